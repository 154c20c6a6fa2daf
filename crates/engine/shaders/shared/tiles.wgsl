// Large splats and the tiles of the window that their rectangles meet, as pairs. The pairs of a chunk are numbered
// splat by splat; pair_offsets holds the prefix sums of the splats' numbers of tiles, so that no list of pairs is
// needed.
#import splat
#import dispatch

// Statistics of a chunk's projection; shared/stats.wgsl explains the members.
struct Found {
    visible: u32,
    large: u32,
    tiles_low: u32,
    tiles_high: u32,
    widest: u32,
    tallest: u32,
    area_low: u32,
    area_high: u32,
}

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<storage, read> bounds: array<Bounds>;
@group(0) @binding(2) var<storage, read> large: array<u32>;
@group(0) @binding(3) var<storage, read> pair_offsets: array<u32>;
@group(0) @binding(4) var<storage, read> stats: array<Found>;
#push

struct Pair {
    splat: u32,
    tile: u32,
}

// Pairs of the chunk.
fn pairs() -> u32 {
    return stats[push.chunk].tiles_low;
}

fn pair_at(pair: u32) -> Pair {
    // The last splat whose first pair is not after this one.
    var below = 0u;
    var above = stats[push.chunk].large;
    while above - below > 1u {
        let middle = (below + above) / 2u;
        if pair_offsets[middle] <= pair {
            below = middle;
        } else {
            above = middle;
        }
    }
    let i = large[below];
    let rect = bounds[i];
    let first = (bounds_min(rect) - view.window.xy) / TILE;
    let last = (bounds_max(rect) - 1u - view.window.xy) / TILE;
    let columns = last.x - first.x + 1u;
    let within = pair - pair_offsets[below];
    let place = first + vec2<u32>(within % columns, within / columns);
    return Pair(i, place.y * tile_columns(view.window) + place.x);
}
