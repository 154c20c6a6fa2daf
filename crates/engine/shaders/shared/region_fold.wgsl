// As tile_fold, for stages that do much for each fragment: one subgroup per block of a tile picks those of the tile's
// splats that touch the block, and goes through them once for each of the block's small regions, of which every
// invocation has one pixel. So few invocations idle where splats are small, and the stage's code stands there once.
//
// The stage imports `splat`, declares its push constants with a member `walk: TileWalk`, and defines
//     begin(pixel)             before the first splat of a run
//     visit(pixel, fragment)   for each splat that may cover the pixel, in the order of the bins
//     finish(pixel)            after the last splat of the run
// pixels outside the window included. A run takes TAKEN splats of each tile, PICKED at most: with 64 / SUBGROUP regions
// and an iteration for each splat and step, an invocation stays below what CPU drivers allow. A later one goes on
// from what earlier ones left, wherever the stage keeps that.
#import folding
#import dispatch

// Pixels of a region in x and y.
const REGION = vec2<u32>(REGION_COLUMNS, SUBGROUP / REGION_COLUMNS);
// Bits of a picked splat that hold its index; the others, one for each of the HELD regions of a block, say which it may
// touch.
const PICKED_BITS = 32u - HELD;

// Those of the run's splats that touch the block of each subgroup.
var<workgroup> picked: array<u32, TEAM * PICKED>;

// First pixel of a region of a block.
fn region_corner(region: u32, block: vec2<u32>) -> vec2<u32> {
    const ACROSS = BLOCK_SIDE / REGION.x;
    return block + vec2<u32>(region % ACROSS, region / ACROSS) * REGION;
}

// True if a screen-aligned splat may touch a region; as `touches`.
fn touches_region(splat: Splat, low: vec2<u32>) -> bool {
    let half = 0.5 * vec2<f32>(REGION - 1u);
    let middle = vec2<f32>(vec2<i32>(low) - center_pixel(splat)) - vec2<f32>(splat.fraction_x, splat.fraction_y) + half + 0.5;
    let outside = max(abs(middle) - (half + most_aside()), vec2<f32>(0.0));
    return reaches(outside, splat.radius, middle);
}

// True if a rectangle meets a region.
fn meets_region(rectangle: Bounds, low: vec2<u32>) -> bool {
    return all(bounds_min(rectangle) < low + REGION) && all(bounds_max(rectangle) > low);
}

// The regions of a block that a splat may touch, in bits from PICKED_BITS on; an oriented disc and a Gaussian by their
// rectangles.
fn regions_of(i: u32, corner: vec2<u32>) -> u32 {
    var regions = 0u;
    if is_rectangle() {
        let rectangle = bounds[i];
        for (var region = 0u; region < HELD; region += 1u) {
            regions |= select(0u, 1u, meets_region(rectangle, region_corner(region, corner))) << (PICKED_BITS + region);
        }
    } else {
        let splat = flat_at(i);
        for (var region = 0u; region < HELD; region += 1u) {
            regions |= select(0u, 1u, touches_region(splat, region_corner(region, corner))) << (PICKED_BITS + region);
        }
    }
    return regions;
}

// Picks the splats that may touch a block, in their order, from `base` on; returns how many.
fn pick(block: u32, corner: vec2<u32>, run: vec2<u32>, base: u32, lane: u32) -> u32 {
    var count = 0u;
    for (var next = run.x; next < run.y; next += SUBGROUP) {
        let entry = entries[min(next + lane, run.y - 1u)];
        let i = index_of(entry);
        var regions = 0u;
        if next + lane < run.y && meets_block(entry, block) {
            regions = regions_of(i, corner);
        }
        let found = subgroupBallot(regions != 0u).x;
        if regions != 0u {
            picked[base + count + countOneBits(found & ((1u << lane) - 1u))] = i | regions;
        }
        count += countOneBits(found);
    }
    return count;
}

// The picked splats to the pixels of one region.
fn over_region(region: u32, low: vec2<u32>, pixel: vec2<u32>, base: u32, count: u32, lane: u32) {
    begin(pixel);
    // Where a stage branches, invocations must meet before they exchange anything.
    subgroupBarrier();
    let first = vec2<f32>(pixel - low);
    for (var next = 0u; next < count; next += SUBGROUP) {
        let one = picked[base + min(next + lane, count - 1u)];
        let near = next + lane < count && (one >> (PICKED_BITS + region) & 1u) != 0u;
        // CPU drivers load lane by lane, and only for those that take part.
        var own: Handed;
        if near {
            own = whole_splat(one & ((1u << PICKED_BITS) - 1u), low);
        }
        var left = subgroupBallot(near).x;
        // The condition stands at the end: CPU drivers run every loop once.
        loop {
            let k = firstTrailingBit(left) & (SUBGROUP - 1u);
            visit(pixel, fragment_of(handed(own, k, left != 0u, first), vec2<u32>(0u), pixel));
            subgroupBarrier();
            left &= left - 1u;
            if left == 0u {
                break;
            }
        }
    }
    finish(pixel);
}

@compute @workgroup_size(SUBGROUP * TEAM)
fn main(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(subgroup_id) member: u32,
    @builtin(subgroup_invocation_id) lane: u32,
) {
    let group = subgroup_of(workgroup_index(workgroup, groups), member);
    let tile = group / (BLOCKS * BLOCKS);
    let block = group % (BLOCKS * BLOCKS);
    let corner = tile_corner(tile) + block_corner(block);
    var run = vec2<u32>(0u);
    var idle = tile >= push.walk.tiles;
    if !idle {
        run = run_of(tile);
        idle = is_idle(run);
    }
    tile_lens = lens_of_view();
    let base = select(member * PICKED, 0u, TEAM == 1u);
    var count = 0u;
    if !idle {
        count = pick(block, corner, run, base, lane);
    }
    // Those of a workgroup whose subgroups have nothing to do wait with the others.
    workgroupBarrier();
    if idle {
        return;
    }
    for (var region = 0u; region < HELD; region += 1u) {
        let low = region_corner(region, corner);
        over_region(region, low, low + vec2<u32>(lane % REGION.x, lane / REGION.x), base, count, lane);
    }
}
