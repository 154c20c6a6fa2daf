// Walker: one workgroup per tile of a large splat. The tile's splat is found by bisection in the tiles' prefix sums, so
// that no list of tiles is needed however many there are.
#import dispatch

@compute @workgroup_size(WG_SIZE)
fn main(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let tile = workgroup_index(workgroup, groups);
    if tile >= push.tiles {
        return;
    }
    // The last splat whose first tile is not after this one.
    var below = 0u;
    var above = push.large_count;
    while above - below > 1u {
        let middle = (below + above) / 2u;
        if tile_offsets[middle] <= tile {
            below = middle;
        } else {
            above = middle;
        }
    }
    let i = large[below];
    let rect = bounds[i];
    let columns = (bounds_max(rect).x - bounds_min(rect).x + TILE - 1u) / TILE;
    let within = tile - tile_offsets[below];
    let low = bounds_min(rect) + vec2<u32>(within % columns, within / columns) * TILE;
    let high = min(low + TILE, bounds_max(rect));
    if !in_band(low, high) {
        return;
    }
    let splat = splats[i];
    let tilt = tilt_of(i);
    for (var k = local; k < TILE * TILE; k += WG_SIZE) {
        let pixel = low + vec2<u32>(k % TILE, k / TILE);
        if all(pixel < high) {
            visit(i, splat, tilt, pixel);
        }
    }
}
