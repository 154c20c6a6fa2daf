// Goes through the splats of each tile and shows each to every pixel that it may cover. One subgroup per tile of
// BLOCKS x BLOCKS blocks of 8 x 8 pixels (shared/blocks.wgsl), or per block; nobody else touches its pixels, so that
// sums need no atomics and come in the same order every time.
//
// A step takes one splat per invocation. For each block a ballot says which of them may touch it, and these are handed
// to all invocations one by one by shuffles. The stage defines what is handed over, and what becomes of it:
//     Handed, PixelState                           a splat in an invocation's hands; the state of one of its pixels
//     begin(pixel) -> PixelState                   before the run's first splat, pixels outside the window included
//     begin_run(cut)                               after that; `cut`: the tile has splats behind the run
//     take(i, corner) -> Handed                    a splat by its index, for a tile's corner
//     may_touch(own, block, corner) -> bool        of one whose rectangle meets the block
//     handed(own, k, present, first) -> Handed     that of lane k, for pixels from `first` on, relative to the corner;
//                                                  without `present` it must change nothing
//     show(state, handed, further, pixel) -> PixelState
//                                                  to a pixel of the invocation, `further` along from its first one
//     STOPS, is_done(state) -> bool                whether pixels may be done before the last splat, and whether one is
//     finish(state, pixel)                         after the run's last splat
// Held pixels are told apart in the text alone, which lavapipe compiles in half the time of one that picks them by an
// index. Each block has functions of its own for its own pixels: drivers inline all calls before they find out which
// pixels another block has.
#import tile_run
#import dispatch

// Subgroups that share a tile: 1, or one for each block where the stage holds more than a number for each pixel.
override SHARED: u32 = 1u;
// Steps between two tests for an early stop.
const LOOK = 4u;

fn is_live(live: u32, block: u32) -> bool {
    return (live & (1u << block)) != 0u;
}

// Where this block's pixels lie from an invocation's first one in the tile.
#each block
#each held const FURTHER{block}_{held} = vec2<u32>({held}u * SUBGROUP % BLOCK_SIDE, {held}u * SUBGROUP / BLOCK_SIDE) + BLOCK_SIDE * vec2<u32>({block}u % BLOCKS, {block}u / BLOCKS);
#each held var<private> held{block}_{held}: PixelState;

// Shows the splats of one step that touch this block to its pixels.
fn over_block{block}(hits: u32, own: Handed, corner: vec2<u32>, lane: u32) {
    let first = first_place(lane);
    var left = hits;
    loop {
        let k = firstTrailingBit(left) & (SUBGROUP - 1u);
        let h = handed(own, k, left != 0u, vec2<f32>(first));
#each held         held{block}_{held} = show(held{block}_{held}, h, FURTHER{block}_{held}, corner + first + FURTHER{block}_{held});
        left &= left - 1u;
        if left == 0u {
            break;
        }
    }
}

// Strikes this block from the live ones if its pixels are all done.
fn close{block}(live: u32) -> u32 {
    var open = false;
#each held     open = open || !is_done(held{block}_{held});
    return select(live & ~(1u << {block}u), live, subgroupBallot(open).x != 0u);
}

fn begin_block{block}(first: vec2<u32>) {
#each held     held{block}_{held} = begin(first + FURTHER{block}_{held});
}

fn finish_block{block}(first: vec2<u32>) {
#each held     finish(held{block}_{held}, first + FURTHER{block}_{held});
}
#end

@compute @workgroup_size(SUBGROUP * TEAM)
fn main(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(subgroup_id) member: u32,
    @builtin(subgroup_invocation_id) lane: u32,
) {
    let group = subgroup_of(workgroup_index(workgroup, groups), member);
    if group / SHARED >= push.walk.tiles {
        return;
    }
    let tile = push.walk.first_tile + group / SHARED;
    let run = run_of(tile);
    if is_idle(run) {
        return;
    }
    let corner = tile_corner(tile) + block_corner(group % SHARED);
#each block     begin_block{block}(corner + first_place(lane));
    tile_lens = lens_of_view();
    begin_run(run.y < tile_end(tile));
    var live = (1u << (BLOCKS * BLOCKS / SHARED)) - 1u;
    var next = run.x;
    while next < run.y && live != 0u {
        // Tests stand behind a loop of their own: CPU drivers run what stands in a branch in every turn.
        let look = select(run.y, min(next + LOOK * SUBGROUP, run.y), STOPS);
        for (; next < look; next += SUBGROUP) {
            let present = next + lane < run.y;
            let entry = entries[min(next + lane, run.y - 1u)];
            var near = false;
#each block             let near{block} = present && meets_block(entry, group % SHARED + {block}u);
#each block             near = near || near{block};
            // CPU drivers load lane by lane, and only for those that take part.
            var own: Handed;
            if near {
                own = take(index_of(entry), corner);
            }
#each block             let hits{block} = subgroupBallot(near{block} && may_touch(own, {block}u, corner)).x;
#each block             over_block{block}(select(0u, hits{block}, is_live(live, {block}u)), own, corner, lane);
        }
        if STOPS {
#each block             live = close{block}(live);
        }
    }
#each block     finish_block{block}(corner + first_place(lane));
}
