// bin/tile-store: each tile's splats, in order of depth. cursors are the prefix sums of the counts before, and where
// each cell's entries end after; a cell is a tile's counter of one run.
//
// One subgroup per run of splats and block of tiles takes its splats one by one. A tile belongs to one invocation by
// its place in a pattern of LANE_COLUMNS x LANE_ROWS: its cursor is nobody else's, so that the entries keep the order
// without atomics or barriers.
#import tile_push
#import tile_entry
#import dispatch
@group(0) @binding(3) var<storage, read_write> cursors: array<u32>;
@group(0) @binding(4) var<storage, read_write> entries: array<u32>;

// The first tile at or after `low` that has this place in the pattern.
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
    // Read once: drivers that cannot rule out that a store changes the view would load it for every splat.
    let corner = view.window.xy;
    let place = vec2<u32>(lane % LANE_COLUMNS, lane / LANE_COLUMNS);
    for (var step = start; step < end; step += SUBGROUP) {
        let own_index = records[min(step + lane, end - 1u)].y;
        let own_rectangle = rectangle_of(own_index);
        // Conditions stand at the ends of the loops: CPU drivers run every loop once.
        var k = 0u;
        loop {
            let rectangle = vec2<u32>(subgroupShuffle(own_rectangle.x, k), subgroupShuffle(own_rectangle.y, k));
            let index = subgroupShuffle(own_index, k);
            let met = select(vec4<u32>(0u), tiles_of(rectangle, corner), any(rectangle != vec2<u32>(0u)));
            let low = max(met.xy, block_low);
            let high = min(met.zw, block_high);
            let first = vec2<u32>(own(low.x, place.x, LANE_COLUMNS), own(low.y, place.y, LANE_ROWS));
            var tile = first;
            loop {
                if all(tile < high) {
                    let cell = (tile.y * push.columns + tile.x) * push.runs + run;
                    let slot = cursors[cell];
                    cursors[cell] = slot + 1u;
                    // Both passes walk the same tiles; should a driver ever disagree with itself, nothing is written
                    // outside.
                    if slot < arrayLength(&entries) {
                        entries[slot] = entry_of(index, rectangle, corner + tile * TILE_SIDE);
                    }
                }
                tile.x += LANE_COLUMNS;
                if tile.x >= high.x {
                    tile = vec2<u32>(first.x, tile.y + LANE_ROWS);
                }
                if tile.y >= high.y {
                    break;
                }
            }
            k += 1u;
            if k >= min(SUBGROUP, end - step) {
                break;
            }
        }
    }
}
