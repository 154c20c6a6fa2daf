// Walker: one workgroup per tile and SEGMENT of its large splats. All invocations look at the same splat at a time, each at
// its own pixels, so that a tile's fragments of many splats meet in the cache.
#import dispatch

@compute @workgroup_size(WG_SIZE)
fn main(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let group = workgroup_index(workgroup, groups);
    let tile = push.first_tile + group % push.tiles;
    let segment = group / push.tiles;
    if segment >= push.segments {
        return;
    }
    let start = tile_starts[tile] + segment * SEGMENT;
    let end = min(start + SEGMENT, tile_starts[tile + 1u]);
    let columns = tile_columns(view.window);
    let corner = view.window.xy + vec2<u32>(tile % columns, tile / columns) * TILE;
    for (var entry = start; entry < end; entry++) {
        let i = tile_entries[entry];
        let rect = bounds[i];
        let splat = splats[i];
        let tilt = tilt_of(i);
        for (var k = local; k < TILE * TILE; k += WG_SIZE) {
            let pixel = corner + vec2<u32>(k % TILE, k / TILE);
            if all(pixel >= bounds_min(rect)) && all(pixel < bounds_max(rect)) {
                visit(i, splat, tilt, pixel);
            }
        }
    }
}
