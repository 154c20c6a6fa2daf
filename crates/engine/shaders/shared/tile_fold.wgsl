// Goes through the splats of each tile in the order in which they were binned, and shows each to every pixel that it may
// cover. One subgroup per tile of BLOCKS x BLOCKS blocks of 8 x 8 pixels (shared/blocks.wgsl); nobody else touches the tile's
// pixels, so that sums need no atomics and come in the same order every time.
//
// The stage imports `splat`, declares its push constants, of which the first members are those below, and then imports this:
//     columns: u32,   // tiles of the window in x
//     tiles: u32,     // tiles of the window
//     runs: u32,      // cells of a tile in the table of ends
//     nearest: u32,   // key of the nearest depth
//     segment: u32,   // which part of each tile's splats: those from segment * TAKEN on
// It defines the type Held, what an invocation holds of each of its pixels, and
//     begin(pixel) -> Held            before the first splat of a run
//     visit(held, fragment) -> Held   for each splat that may cover the pixel
//     finish(held, pixel)             after the last splat of the run
// pixels outside the window included. Held pixels are told apart in the text alone, which lavapipe compiles in half the time
// of one that picks them by an index. A run takes TAKEN splats of each tile; with LATER = 1 it goes on from what earlier
// ones left, wherever the stage keeps that.
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

// Splats of a tile that one run takes: some 5 iterations for each stay below what CPU drivers allow.
override TAKEN: u32 = 1u;
override LATER: u32 = 0u;
// Subgroups that share a tile: 1, or one for each block where the stage holds much for each pixel.
override SHARED: u32 = 1u;
const FALLOFF_GAUSSIAN = 1u;
override FALLOFF: u32 = 0u;

#each held var<private> held{held}: Held;

// A splat in a pixel.
struct Fragment {
    hit: bool,
    // Linear or encoded RGB, and the opacity here: 0 where the splat misses the pixel.
    color: vec4<f32>,
    depth_key: u32,
    // The splat's, in canonical order: what breaks ties of depth.
    index: u32,
}

fn fragment_of(splat: Splat, tilt: Tilt, color: vec4<f32>, record: vec2<u32>, pixel: vec2<u32>, present: bool) -> Fragment {
    let coverage = cover(splat, tilt, pixel, view);
    let hit = coverage.hit && present;
    var c = color;
    if FALLOFF == FALLOFF_GAUSSIAN {
        c.a *= gaussian(coverage.rho);
    }
    c.a = select(0.0, c.a, hit);
    let key = select(record.x + push.nearest, depth_key(coverage.depth), SHAPE == SHAPE_ORIENTED);
    return Fragment(hit, c, key, record.y);
}

// Shows the splats of one step that touch a block to its pixels.
fn over_block(block: u32, hits: u32, splat: Splat, tilt: Tilt, color: vec4<f32>, record: vec2<u32>, corner: vec2<u32>, lane: u32) {
    var left = hits;
    loop {
        let k = firstTrailingBit(left) & (SUBGROUP - 1u);
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
        let present = left != 0u;
#each held         if {held}u / HELD == block { held{held} = visit(held{held}, fragment_of(s, t, c, r, corner + place(lane, {held}u), present)); }
        left &= left - 1u;
        if left == 0u {
            break;
        }
    }
}

@compute @workgroup_size(SUBGROUP)
fn main(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(subgroup_invocation_id) lane: u32,
) {
    let group = workgroup_index(workgroup, groups);
    let tile = group / SHARED;
    if tile >= push.tiles {
        return;
    }
    let before = select(0u, ends[max(tile * push.runs, 1u) - 1u], tile > 0u);
    let start = before + push.segment * TAKEN;
    let end = min(start + TAKEN, ends[(tile + 1u) * push.runs - 1u]);
    if LATER != 0u && start >= end {
        return;
    }
    let corner = view.window.xy + vec2<u32>(tile % push.columns, tile / push.columns) * TILE_SIDE + block_corner(group % SHARED);
#each held     held{held} = begin(corner + place(lane, {held}u));
    for (var next = start; next < end; next += SUBGROUP) {
        let present = next + lane < end;
        let rank = entries[min(next + lane, end - 1u)];
        let footprint = footprints[rank];
        let color = colors[rank];
        let record = records[rank];
        var splat = Splat(bitcast<f32>(footprint.x), bitcast<f32>(footprint.y), footprint.z, 0.0, bitcast<f32>(footprint.w));
        var tilt = Tilt(vec4<f32>(0.0));
        if SHAPE == SHAPE_ORIENTED {
            tilt.normal = slopes[rank];
            splat.depth = key_depth(record.x + push.nearest);
        }
#each block         let hits{block} = subgroupBallot(present && touches(splat, corner + block_corner({block}u))).x;
#each block         over_block({block}u, hits{block}, splat, tilt, color, record, corner, lane);
    }
#each held     finish(held{held}, corner + place(lane, {held}u));
}
