// As tile_fold, for stages that do much for each fragment and keep much for each pixel: one subgroup per block of a tile picks
// those of the tile's splats that touch the block, and goes through them once for each of the block's small regions, of which
// every invocation has one pixel. So few invocations idle where splats are small, and the stage's code stands there once.
//
// The stage imports `splat`, declares its push constants with a member `walk: TileWalk`, and defines
//     begin(pixel)             before the first splat of a run
//     visit(pixel, fragment)   for each splat that may cover the pixel, in the order of the bins
//     finish(pixel)            after the last splat of the run
// pixels outside the window included. A run takes TAKEN splats of each tile, PICKED at most: with 64 / SUBGROUP regions and
// an iteration for each splat and step, an invocation stays below what CPU drivers allow. With LATER = 1 it goes on from what
// earlier ones left, wherever the stage keeps that.
#import folding
#import dispatch

@group(0) @binding(19) var<storage, read> bounds: array<Bounds>;

// Pixels of a region in x and y.
const REGION = vec2<u32>(REGION_COLUMNS, SUBGROUP / REGION_COLUMNS);

// Those of the run's splats that touch the block, by index.
var<workgroup> picked: array<u32, PICKED>;

// Picks the splats that may touch a block, in their order; returns how many.
fn pick(block: u32, low: vec2<u32>, run: vec2<u32>, lane: u32) -> u32 {
    var count = 0u;
    for (var next = run.x; next < run.y; next += SUBGROUP) {
        let entry = entries[min(next + lane, run.y - 1u)];
        let i = index_of(entry);
        var near = next + lane < run.y && meets_block(entry, block);
        if near && SHAPE != SHAPE_ORIENTED {
            near = touches(flat_at(i), low);
        }
        let found = subgroupBallot(near).x;
        if near {
            picked[count + countOneBits(found & ((1u << lane) - 1u))] = i;
        }
        count += countOneBits(found);
    }
    return count;
}

// True if a splat's rectangle meets that of some pixels.
fn meets(i: u32, low: vec2<u32>, size: vec2<u32>) -> bool {
    let rectangle = bounds[i];
    return all(bounds_min(rectangle) < low + size) && all(bounds_max(rectangle) > low);
}

// True if a splat may touch a region; as `touches`, or by the rectangle of an oriented disc.
fn touches_region(splat: Splat, i: u32, low: vec2<u32>) -> bool {
    if SHAPE == SHAPE_ORIENTED {
        return meets(i, low, REGION);
    }
    let half = 0.5 * vec2<f32>(REGION - 1u);
    let middle = vec2<f32>(vec2<i32>(low) - center_pixel(splat)) - vec2<f32>(splat.fraction_x, splat.fraction_y) + half + 0.5;
    let outside = max(abs(middle) - half, vec2<f32>(0.0));
    return reaches(outside, splat.radius, middle);
}

// The picked splats to the pixels of one region.
fn over_region(low: vec2<u32>, pixel: vec2<u32>, count: u32, lane: u32) {
    begin(pixel);
    let first = vec2<f32>(pixel - low);
    for (var next = 0u; next < count; next += SUBGROUP) {
        let i = picked[min(next + lane, count - 1u)];
        let own = whole_splat(i, low);
        var left = subgroupBallot(next + lane < count && touches_region(own.splat, i, low)).x;
        while left != 0u {
            let k = firstTrailingBit(left);
            left &= left - 1u;
            visit(pixel, fragment_of(handed(own, k, true, first), vec2<u32>(0u), pixel));
        }
    }
    finish(pixel);
}

@compute @workgroup_size(SUBGROUP)
fn main(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(subgroup_invocation_id) lane: u32,
) {
    let group = workgroup_index(workgroup, groups);
    let tile = group / (BLOCKS * BLOCKS);
    if tile >= push.walk.tiles {
        return;
    }
    let run = run_of(tile);
    if is_idle(run) {
        return;
    }
    let block = group % (BLOCKS * BLOCKS);
    let corner = tile_corner(tile) + block_corner(block);
    let count = pick(block, corner, run, lane);
    workgroupBarrier();
    let across = BLOCK_SIDE / REGION.x;
    for (var region = 0u; region < HELD; region += 1u) {
        let low = corner + vec2<u32>(region % across, region / across) * REGION;
        over_region(low, low + vec2<u32>(lane % REGION.x, lane / REGION.x), count, lane);
    }
}
