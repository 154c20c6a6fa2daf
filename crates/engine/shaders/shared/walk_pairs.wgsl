// Walker: one workgroup per PAIR_RUN pairs of a large splat and a tile of the window that its rectangle meets. All
// invocations look at the same pair at a time, each at its own pixels. The pairs of a chunk are numbered splat by
// splat; pair_offsets holds the prefix sums of the splats' numbers of tiles, so that no list of pairs is needed.
#import dispatch

const STEP_ROWS = WG_SIZE / TILE;

// The last of so many large splats whose first pair is not after this one.
fn splat_with(pair: u32, splats: u32) -> u32 {
    var below = 0u;
    var above = splats;
    while above - below > 1u {
        let middle = (below + above) / 2u;
        if pair_offsets[middle] <= pair {
            below = middle;
        } else {
            above = middle;
        }
    }
    return below;
}

#main {
    view = camera;
    let start = workgroup_index(workgroup, groups) * PAIR_RUN;
    // The host may have foreseen more than there are.
    let found = stats[push.chunk];
    let end = min(start + PAIR_RUN, found.tiles_low);
    if start >= end {
        return;
    }
    var number = splat_with(start, found.large);
    for (var pair = start; pair < end; pair++) {
        // Each large splat has a pair at least.
        if number + 1u < found.large && pair_offsets[number + 1u] <= pair {
            number += 1u;
        }
        let i = large[number];
        let rect = bounds[i];
        let first_tile = (bounds_min(rect) - view.window.xy) / TILE;
        let columns = (bounds_max(rect).x - 1u - view.window.x) / TILE - first_tile.x + 1u;
        let within = pair - pair_offsets[number];
        let corner = view.window.xy + (first_tile + vec2<u32>(within % columns, within / columns)) * TILE;
        let low = max(bounds_min(rect), corner);
        let high = min(bounds_max(rect), corner + TILE);
        if !in_band(low, high) {
            continue;
        }
        let splat = splat_of(i);
        let tilt = tilt_of(i);
        // Only the rows of the tile that the rectangle meets; a step takes as many rows as the workgroup has.
        let last = (high.y - 1u - corner.y) / STEP_ROWS;
        for (var step = (low.y - corner.y) / STEP_ROWS; step <= last; step++) {
            let pixel = corner + vec2<u32>(local % TILE, step * STEP_ROWS + local / TILE);
            if all(pixel >= low) && all(pixel < high) {
                visit(i, splat, tilt, pixel);
            }
        }
    }
}
