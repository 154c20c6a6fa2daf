// sorted/blend: composes each tile's splats front to back. One subgroup per tile of BLOCKS x BLOCKS blocks of 8 x 8 pixels;
// every invocation holds the sums of the same few pixels of each block in registers.
//
// A step takes one splat per invocation. For each block a ballot says which of them may touch it, and these are handed to
// all invocations one by one by shuffles. A block is done when nothing behind can change its output.
// Reference: reference::sorted.
#import elementary
#import over
#import blocks
#import stop
#import dispatch

struct Push {
    // Tiles of the window in x, and in all; cells of a tile in the table of ends.
    columns: u32,
    tiles: u32,
    runs: u32,
    // Key of the nearest depth.
    nearest: u32,
    // Which part of each tile's splats: those from segment * TAKEN on.
    segment: u32,
    // Largest opacity, and largest color component, background included: bounds of what may still come.
    most_opacity: f32,
    most_color: f32,
}

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<storage, read> ends: array<u32>;
@group(0) @binding(2) var<storage, read> entries: array<u32>;
@group(0) @binding(3) var<storage, read> records: array<vec2<u32>>;
@group(0) @binding(4) var<storage, read> footprints: array<vec4<u32>>;
@group(0) @binding(5) var<storage, read> colors: array<vec4<f32>>;
@group(0) @binding(6) var<storage, read> slopes: array<vec4<f32>>;
@group(0) @binding(7) var<storage, read_write> image: array<vec4<f32>>;
@group(0) @binding(8) var<storage, read_write> depths: array<f32>;
var<immediate> push: Push;

// Splats of a tile that one run takes: some 5 iterations for each stay below what CPU drivers allow. The next run goes on
// from the image.
override TAKEN: u32 = 1u;
// 1: the image holds what lies in front.
override LATER: u32 = 0u;
const FALLOFF_GAUSSIAN = 1u;
override FALLOFF: u32 = 0u;
// Steps between two looks at what may stop.
const LOOK = 4u;
#each held var<private> sum{held}: Composed;
#each held var<private> front{held}: Composed;
// Of what may come behind: another run may be opaque.
var<private> most_opacity: f32;

// One splat over one of this invocation's pixels.
fn add(front: Composed, splat: Splat, tilt: Tilt, color: vec4<f32>, rank: u32, pixel: vec2<u32>) -> Composed {
    let coverage = cover(splat, tilt, pixel, view);
    var c = color;
    if FALLOFF == FALLOFF_GAUSSIAN {
        c.a *= gaussian(coverage.rho);
    }
    c.a = select(0.0, c.a, coverage.hit);
    // Flat splats note the rank here; one look-up at the end gives the depth.
    return behind(front, select(rank, depth_key(coverage.depth), SHAPE == SHAPE_ORIENTED), c);
}

// What this run composed, behind what lies in front of it.
fn joined(front: Composed, sum: Composed) -> Composed {
    if LATER == 0u {
        return sum;
    }
    return Composed(front.rgba + (1.0 - front.rgba.a) * sum.rgba, front.key);
}

fn is_live(live: u32, block: u32) -> bool {
    return (live & (1u << block)) != 0u;
}

// Strikes a block whose pixels are all done from the live ones.
fn close(live: u32, block: u32) -> u32 {
    var open = false;
#each held     if {held}u / HELD == block { open = open || !done(joined(front{held}, sum{held}), most_opacity, push.most_color); }
    return select(live & ~(1u << block), live, subgroupBallot(open).x != 0u);
}

fn tile_start(tile: u32) -> u32 {
    return select(0u, ends[max(tile * push.runs, 1u) - 1u], tile > 0u);
}

// Composes the splats of one step that touch a block.
fn blend(block: u32, hits: u32, splat: Splat, tilt: Tilt, color: vec4<f32>, rank: u32, corner: vec2<u32>, lane: u32) {
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
            subgroupShuffle(color.b, k), select(0.0, subgroupShuffle(color.a, k), left != 0u),
        );
        let r = subgroupShuffle(rank, k);
#each held         if {held}u / HELD == block { sum{held} = add(sum{held}, s, t, c, r, corner + place(lane, {held}u)); }
        left &= left - 1u;
        if left == 0u {
            break;
        }
    }
}

// What the runs before left of a pixel. A depth stands for its key: nothing behind asks for the rank again.
fn left_by_others(pixel: vec2<u32>) -> Composed {
    if LATER == 0u || any(pixel >= view.window.zw) {
        return Composed(vec4<f32>(0.0), NOTHING);
    }
    let p = window_index(pixel, view.window);
    return Composed(image[p], select(0u, NOTHING, depths[p] > 3.4e38));
}

fn finish(sum: Composed, front: Composed, pixel: vec2<u32>) {
    if any(pixel >= view.window.zw) {
        return;
    }
    let p = window_index(pixel, view.window);
    image[p] = joined(front, sum).rgba;
    if LATER == 0u || (front.key == NOTHING && sum.key != NOTHING) {
        var key = sum.key;
        if SHAPE != SHAPE_ORIENTED && key != NOTHING {
            key = records[key].x + push.nearest;
        }
        depths[p] = composed_depth(key);
    }
}

@compute @workgroup_size(SUBGROUP)
fn main(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(subgroup_invocation_id) lane: u32,
) {
    let tile = workgroup_index(workgroup, groups);
    if tile >= push.tiles {
        return;
    }
    let corner = view.window.xy + vec2<u32>(tile % push.columns, tile / push.columns) * TILE_SIDE;
    let start = tile_start(tile) + push.segment * TAKEN;
    let end = min(start + TAKEN, ends[(tile + 1u) * push.runs - 1u]);
    if LATER != 0u && start >= end {
        return;
    }
    most_opacity = select(push.most_opacity, 1.0, LATER != 0u || end < ends[(tile + 1u) * push.runs - 1u]);
#each held     sum{held} = Composed(vec4<f32>(0.0), NOTHING);
#each held     front{held} = left_by_others(corner + place(lane, {held}u));
    var live = (1u << (BLOCKS * BLOCKS)) - 1u;
    var steps = 0u;
    for (var next = start; next < end && live != 0u; next += SUBGROUP) {
        let present = next + lane < end;
        let rank = entries[min(next + lane, end - 1u)];
        let footprint = footprints[rank];
        let color = colors[rank];
        var splat = Splat(bitcast<f32>(footprint.x), bitcast<f32>(footprint.y), footprint.z, 0.0, bitcast<f32>(footprint.w));
        var tilt = Tilt(vec4<f32>(0.0));
        if SHAPE == SHAPE_ORIENTED {
            tilt.normal = slopes[rank];
            splat.depth = key_depth(records[rank].x + push.nearest);
        }
#each block         let hits{block} = subgroupBallot(present && touches(splat, corner + block_corner({block}u))).x;
#each block         blend({block}u, select(0u, hits{block}, is_live(live, {block}u)), splat, tilt, color, rank, corner, lane);
        steps += 1u;
        if steps % LOOK == 0u {
#each block             live = close(live, {block}u);
        }
    }
#each held     finish(sum{held}, front{held}, corner + place(lane, {held}u));
}
