// As tile_fold, for stages that do much for each fragment and keep much for each pixel: one subgroup per block of a tile picks
// those of the tile's splats that touch the block, and goes through them once for each of the block's small regions, of which
// every invocation has one pixel. So few invocations idle where splats are small, and the stage's code stands there once.
//
// The stage imports `splat`, declares its push constants, of which the first members are those of tile_fold, and defines
//     begin(pixel)             before the first splat of a run
//     visit(pixel, fragment)   for each splat that may cover the pixel, in the order of the bins
//     finish(pixel)            after the last splat of the run
// pixels outside the window included. A run takes TAKEN splats of each tile; with LATER = 1 it goes on from what earlier ones
// left, wherever the stage keeps that.
#import elementary
#import blocks
#import dispatch

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<storage, read> ends: array<u32>;
@group(0) @binding(2) var<storage, read> entries: array<u32>;
@group(0) @binding(3) var<storage, read> records: array<vec2<u32>>;
@group(0) @binding(4) var<storage, read> footprints: array<vec4<u32>>;
@group(0) @binding(5) var<storage, read> colors: array<vec4<f32>>;
@group(0) @binding(6) var<storage, read> slopes: array<vec4<f32>>;
@group(0) @binding(7) var<storage, read> rectangles: array<vec2<u32>>;

// Splats of a tile that one run takes, PICKED at most: with 64 / SUBGROUP regions and an iteration for each splat and step, an
// invocation stays below what CPU drivers allow.
override TAKEN: u32 = 1u;
override LATER: u32 = 0u;
const FALLOFF_GAUSSIAN = 1u;
override FALLOFF: u32 = 0u;

// Pixels of a region in x and y.
const REGION = vec2<u32>(REGION_COLUMNS, SUBGROUP / REGION_COLUMNS);

// A splat in a pixel; what a stage does not read costs nothing.
struct Fragment {
    // Linear or encoded RGB, and the opacity here: 0 where the splat misses the pixel.
    color: vec4<f32>,
    depth_key: u32,
    // The splat's, in canonical order: what breaks ties of depth.
    index: u32,
    hit: bool,
    // Distance from the splat's centre over its radius, at most 1 but in a square's corners; and that radius in world units.
    rho: f32,
    radius: f32,
}

fn fragment_of(splat: Splat, tilt: Tilt, color: vec4<f32>, record: vec2<u32>, pixel: vec2<u32>) -> Fragment {
    let coverage = cover(splat, tilt, pixel, view);
    var c = color;
    if FALLOFF == FALLOFF_GAUSSIAN {
        c.a *= gaussian(coverage.rho);
    }
    c.a = select(0.0, c.a, coverage.hit);
    let key = select(record.x + push.nearest, depth_key(coverage.depth), SHAPE == SHAPE_ORIENTED);
    let distance = select(key_depth(record.x + push.nearest) + view.eye_hi.w, 1.0, view.orthographic != 0u);
    return Fragment(c, key, record.y, coverage.hit, coverage.rho, splat.radius * (distance / view.focal.x));
}

// Those of the run's splats that touch the block, by rank.
var<workgroup> picked: array<u32, PICKED>;

fn splat_of(footprint: vec4<u32>) -> Splat {
    return Splat(bitcast<f32>(footprint.x), bitcast<f32>(footprint.y), footprint.z, 0.0, bitcast<f32>(footprint.w));
}

// Picks the splats that may touch a block, in their order; returns how many.
fn pick(low: vec2<u32>, start: u32, end: u32, lane: u32) -> u32 {
    var count = 0u;
    for (var next = start; next < end; next += SUBGROUP) {
        let rank = entries[min(next + lane, end - 1u)];
        var near = next + lane < end;
        if SHAPE == SHAPE_ORIENTED {
            near = near && meets(rank, low, vec2<u32>(SIDE));
        } else {
            near = near && touches(splat_of(footprints[rank]), low);
        }
        let found = subgroupBallot(near).x;
        if near {
            picked[count + countOneBits(found & ((1u << lane) - 1u))] = rank;
        }
        count += countOneBits(found);
    }
    return count;
}

// Whether a splat's rectangle meets that of some pixels.
fn meets(rank: u32, low: vec2<u32>, size: vec2<u32>) -> bool {
    let rectangle = rectangles[rank];
    return all(bounds_min(rectangle) < low + size) && all(bounds_max(rectangle) > low);
}

// Whether a splat may touch a region; as `touches`, or by the rectangle of an oriented disc.
fn touches_region(splat: Splat, rank: u32, low: vec2<u32>) -> bool {
    if SHAPE == SHAPE_ORIENTED {
        return meets(rank, low, REGION);
    }
    let half = 0.5 * vec2<f32>(REGION - 1u);
    let middle = vec2<f32>(vec2<i32>(low) - center_pixel(splat)) - vec2<f32>(splat.fraction_x, splat.fraction_y) + half + 0.5;
    let outside = max(abs(middle) - half, vec2<f32>(0.0));
    return reaches(outside, splat.radius, middle);
}

// The picked splats to the pixels of one region.
fn over_region(low: vec2<u32>, pixel: vec2<u32>, count: u32, lane: u32) {
    begin(pixel);
    for (var next = 0u; next < count; next += SUBGROUP) {
        let rank = picked[min(next + lane, count - 1u)];
        let color = colors[rank];
        let record = records[rank];
        var splat = splat_of(footprints[rank]);
        var tilt = Tilt(vec4<f32>(0.0));
        if SHAPE == SHAPE_ORIENTED {
            tilt.normal = slopes[rank];
            splat.depth = key_depth(record.x + push.nearest);
        }
        var left = subgroupBallot(next + lane < count && touches_region(splat, rank, low)).x;
        while left != 0u {
            let k = firstTrailingBit(left);
            left &= left - 1u;
            var s: Splat;
            s.fraction_x = subgroupShuffle(splat.fraction_x, k);
            s.fraction_y = subgroupShuffle(splat.fraction_y, k);
            s.pixel = subgroupShuffle(splat.pixel, k);
            s.radius = subgroupShuffle(splat.radius, k);
            var t = Tilt(vec4<f32>(0.0));
            if SHAPE == SHAPE_ORIENTED {
                s.depth = subgroupShuffle(splat.depth, k);
                t.normal = vec4<f32>(
                    subgroupShuffle(tilt.normal.x, k), subgroupShuffle(tilt.normal.y, k),
                    subgroupShuffle(tilt.normal.z, k), subgroupShuffle(tilt.normal.w, k),
                );
            }
            let c = vec4<f32>(
                subgroupShuffle(color.r, k), subgroupShuffle(color.g, k),
                subgroupShuffle(color.b, k), subgroupShuffle(color.a, k),
            );
            let r = vec2<u32>(subgroupShuffle(record.x, k), subgroupShuffle(record.y, k));
            visit(pixel, fragment_of(s, t, c, r, pixel));
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
    if tile >= push.tiles {
        return;
    }
    let before = select(0u, ends[max(tile * push.runs, 1u) - 1u], tile > 0u);
    let start = before + push.segment * TAKEN;
    let end = min(start + TAKEN, ends[(tile + 1u) * push.runs - 1u]);
    if LATER != 0u && start >= end {
        return;
    }
    let corner = view.window.xy + vec2<u32>(tile % push.columns, tile / push.columns) * TILE_SIDE
        + block_corner(group % (BLOCKS * BLOCKS));
    let count = pick(corner, start, end, lane);
    workgroupBarrier();
    let across = SIDE / REGION.x;
    for (var region = 0u; region < HELD; region += 1u) {
        let low = corner + vec2<u32>(region % across, region / across) * REGION;
        over_region(low, low + vec2<u32>(lane % REGION.x, lane / REGION.x), count, lane);
    }
}
