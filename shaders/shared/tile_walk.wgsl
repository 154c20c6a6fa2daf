// Walks the tiles that drawn splats meet, in order of depth: one subgroup per run of splats and block of tiles. A tile
// belongs to one invocation by its place in a pattern of LANE_COLUMNS x LANE_ROWS, so that its counter is nobody else's
// and no two splats of a run meet in it at the same time. The stage defines visit(cell, rank); a cell is a tile's counter
// of one run.
#import splat
#import dispatch

struct Push {
    // Drawn splats, and how they are cut into runs.
    count: u32,
    runs: u32,
    run_length: u32,
    // Tiles of the window in x and y, and of a block.
    columns: u32,
    rows: u32,
    block_columns: u32,
    block_rows: u32,
    // Blocks in x.
    blocks_x: u32,
}

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<storage, read> rectangles: array<vec2<u32>>;
var<immediate> push: Push;

const LANE_COLUMNS = select(2u, select(4u, 8u, SUBGROUP == 32u), SUBGROUP >= 8u);
const LANE_ROWS = SUBGROUP / LANE_COLUMNS;

// The first tile at or after `low` that belongs to this invocation's place in the pattern.
fn own(low: u32, place: u32, period: u32) -> u32 {
    return low + (place + period - low % period) % period;
}

@compute @workgroup_size(SUBGROUP)
fn main(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(subgroup_invocation_id) lane: u32,
) {
    let item = workgroup_index(workgroup, groups);
    let run = item % push.runs;
    let block = item / push.runs;
    let block_low = vec2<u32>(block % push.blocks_x * push.block_columns, block / push.blocks_x * push.block_rows);
    let block_high = min(block_low + vec2<u32>(push.block_columns, push.block_rows), vec2<u32>(push.columns, push.rows));
    let start = run * push.run_length;
    let end = min(start + push.run_length, push.count);
    let place = vec2<u32>(lane % LANE_COLUMNS, lane / LANE_COLUMNS);
    for (var step = start; step < end; step += SUBGROUP) {
        let rect = rectangles[min(step + lane, end - 1u)];
        let rect_low = (vec2<u32>(rect.x & 0xffffu, rect.y & 0xffffu) - view.window.xy) / TILE_SIDE;
        let rect_high = (vec2<u32>(rect.x >> 16u, rect.y >> 16u) - 1u - view.window.xy) / TILE_SIDE + 1u;
        let own_low = max(rect_low, block_low);
        let own_high = min(rect_high, block_high);
        for (var k = 0u; k < min(SUBGROUP, end - step); k++) {
            let low = vec2<u32>(subgroupShuffle(own_low.x, k), subgroupShuffle(own_low.y, k));
            let high = vec2<u32>(subgroupShuffle(own_high.x, k), subgroupShuffle(own_high.y, k));
            let first = vec2<u32>(own(low.x, place.x, LANE_COLUMNS), own(low.y, place.y, LANE_ROWS));
            var tile = first;
            while all(tile < high) {
                visit((tile.y * push.columns + tile.x) * push.runs + run, step + k);
                tile.x += LANE_COLUMNS;
                if tile.x >= high.x {
                    tile = vec2<u32>(first.x, tile.y + LANE_ROWS);
                }
            }
        }
    }
}
