// Walker: one workgroup per tile and SEGMENT of its large splats. All invocations look at the same splat at a time,
// each at its own pixels, so that a tile's fragments of many splats meet in the cache.
#import dispatch

// Large splats of a tile that one workgroup walks: four pixels of each and invocation stay below the iterations that
// lavapipe allows. A stage that loops for each pixel takes fewer.
override SEGMENT: u32;

const STEP_ROWS = WG_SIZE / TILE;

#main {
    view = camera;
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
        let splat = splat_of(i);
        let tilt = tilt_of(i);
        let low = bounds_min(rect);
        let high = bounds_max(rect);
        // Only the rows of the tile that the rectangle meets; a step takes as many rows as the workgroup has.
        let first = (max(low.y, corner.y) - corner.y) / STEP_ROWS;
        let last = (min(high.y - corner.y, TILE) - 1u) / STEP_ROWS;
        for (var step = first; step <= last; step++) {
            let pixel = corner + vec2<u32>(local % TILE, step * STEP_ROWS + local / TILE);
            if all(pixel >= low) && all(pixel < high) {
                visit(i, splat, tilt, pixel);
            }
        }
    }
}
