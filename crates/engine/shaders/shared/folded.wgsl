// Workgroups in x and y for a number of them, of which so many are allowed in x. Fewer than there are in y have nothing
// to do: a CPU driver gives each core as many groups as any other, those at the end to the last one.
fn folded(groups: u32, most: u32) -> vec2<u32> {
    let y = (groups + most - 1u) / most;
    let rows = max(y, 1u);
    return vec2<u32>((groups + rows - 1u) / rows, y);
}
