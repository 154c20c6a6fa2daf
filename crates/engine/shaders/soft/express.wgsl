// soft/express: composes the soft discs of each tile in the order of an axis (Seemann et al. 2018, Section 3.3). As
// sorted/blend: one subgroup per tile of BLOCKS x BLOCKS blocks of 8 x 8 pixels; a ballot says which splats of a step may touch
// a block, and these are handed to all invocations one by one by shuffles. Runs over a tile's splats go on from one another's
// sums, so that where they are cut changes no bit.
// Reference: reference::soft.
#import over
#import blocks
#import stop
#import profile
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
    // Opacity in the middle of a disc, Seemann's lambda.
    peak: f32,
    // Largest color component, background included: a bound of what may still come.
    most_color: f32,
}

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<storage, read> ends: array<u32>;
@group(0) @binding(2) var<storage, read> entries: array<u32>;
@group(0) @binding(3) var<storage, read> records: array<vec2<u32>>;
@group(0) @binding(4) var<storage, read> footprints: array<vec4<u32>>;
// Colors as blended, and W.
@group(0) @binding(5) var<storage, read> colors: array<vec4<f32>>;
// Of oriented discs: none here.
@group(0) @binding(6) var<storage, read> slopes: array<vec4<f32>>;
// Of the solid points: only what lies before them counts.
@group(0) @binding(7) var<storage, read> solid: array<f32>;
@group(0) @binding(8) var<storage, read_write> image: array<vec4<f32>>;
@group(0) @binding(9) var<storage, read_write> depths: array<f32>;
// Discs of each pixel.
@group(0) @binding(10) var<storage, read_write> counts: array<u32>;
var<immediate> push: Push;

// Splats of a tile that one run takes: some 5 iterations for each stay below what CPU drivers allow.
override TAKEN: u32 = 1u;
// 1: the image holds what lies in front.
override LATER: u32 = 0u;
// 1: there are solid points.
override CUT: u32 = 0u;
// 1: some splats have a W below 1.
override MODULATED: u32 = 0u;
// 1: those that cover a pixel before its solid point are counted.
override COUNTED: u32 = 0u;
// Steps between two looks at what may stop.
const LOOK = 4u;
#each held var<private> sum{held}: Composed;
// Depth key of the solid point, NOTHING where there is none, 0 outside the window.
#each held var<private> wall{held}: u32;
#each held var<private> count{held}: u32;

// A disc as it is handed from lane to lane.
struct Disc {
    // From the tile's corner to the pixel of the centre, and from the centre to the middle of that pixel.
    pixel: vec2<f32>,
    rest: vec2<f32>,
    // 1 / radius².
    scale: f32,
    radius: f32,
    key: u32,
    // Color and W.
    color: vec4<f32>,
}

// Where a disc lies that is none, in pixels: beyond any radius.
const NOWHERE = 1e19;

// Whole pixels and their parts are kept apart, so that an offset is rounded but once, wherever the tile lies.
fn disc_of(splat: Splat, key: u32, color: vec4<f32>, corner: vec2<u32>) -> Disc {
    let pixel = vec2<f32>(center_pixel(splat) - vec2<i32>(corner));
    let rest = 0.5 - vec2<f32>(splat.fraction_x, splat.fraction_y);
    // Finite, since the square of a tiny radius may be 0.
    let scale = min(1.0 / (splat.radius * splat.radius), 3e38);
    // Of a radius of 0 nothing is left, since d / r counts as 1: its middle comes to lie beside those of all pixels.
    return Disc(pixel, select(vec2<f32>(0.25), rest, splat.radius > 0.0), scale, splat.radius, key, color);
}

// One disc over one of this invocation's pixels, `further` along from the first one; `disc.pixel` relative to that.
fn add(front: Composed, disc: Disc, further: vec2<u32>, wall: u32) -> Composed {
    let offset = (vec2<f32>(further) - disc.pixel) + disc.rest;
    let squared = min(dot(offset, offset) * disc.scale, 1.0);
    var alpha = push.peak * profile(squared);
    if MODULATED != 0u {
        alpha = push.peak * (1.0 - sqrt(squared)) * (1.0 - disc.color.a) + alpha * disc.color.a;
    }
    if CUT != 0u {
        alpha = select(0.0, alpha, disc.key < wall);
    }
    return behind(front, disc.key, vec4<f32>(disc.color.rgb, alpha));
}

// Whether a disc covers a pixel, as `cover` in shared/splat.wgsl has it, and lies before its solid point.
fn counts_as(disc: Disc, further: vec2<u32>, wall: u32) -> u32 {
    let whole = vec2<f32>(further) - disc.pixel;
    let offset = whole + disc.rest;
    let inside = dot(offset, offset) <= disc.radius * disc.radius || all(whole == vec2<f32>(0.0));
    return u32(inside && disc.key < wall);
}

fn is_live(live: u32, block: u32) -> bool {
    return (live & (1u << block)) != 0u;
}

// Strikes a block whose pixels are all done from the live ones.
fn close(live: u32, block: u32) -> u32 {
    var open = false;
#each held     if {held}u / HELD == block { open = open || (wall{held} > 0u && !done(sum{held}, push.peak, push.most_color)); }
    return select(live & ~(1u << block), live, subgroupBallot(open).x != 0u);
}

// The farthest solid point of a block: nothing counts there that lies behind.
fn farthest(block: u32) -> u32 {
    var key = 0u;
#each held     if {held}u / HELD == block { key = max(key, wall{held}); }
    return subgroupMax(key);
}

fn tile_start(tile: u32) -> u32 {
    return select(0u, ends[max(tile * push.runs, 1u) - 1u], tile > 0u);
}

// Composes the discs of one step that touch a block.
fn blend(block: u32, hits: u32, disc: Disc, lane: u32) {
    let first = vec2<f32>(place(lane, 0u));
    var left = hits;
    loop {
        let k = firstTrailingBit(left) & (SUBGROUP - 1u);
        var d: Disc;
        d.pixel = vec2<f32>(select(NOWHERE, subgroupShuffle(disc.pixel.x, k), left != 0u), subgroupShuffle(disc.pixel.y, k)) - first;
        d.rest = vec2<f32>(subgroupShuffle(disc.rest.x, k), subgroupShuffle(disc.rest.y, k));
        d.scale = subgroupShuffle(disc.scale, k);
        d.key = subgroupShuffle(disc.key, k);
        if COUNTED != 0u {
            d.radius = subgroupShuffle(disc.radius, k);
        }
        d.color = vec4<f32>(
            subgroupShuffle(disc.color.r, k), subgroupShuffle(disc.color.g, k), subgroupShuffle(disc.color.b, k), 1.0,
        );
        if MODULATED != 0u {
            d.color.a = subgroupShuffle(disc.color.a, k);
        }
        if COUNTED != 0u {
#each held             if {held}u / HELD == block { count{held} += counts_as(d, place(0u, {held}u), wall{held}); }
        }
#each held         if {held}u / HELD == block { sum{held} = add(sum{held}, d, place(0u, {held}u), wall{held}); }
        left &= left - 1u;
        if left == 0u {
            break;
        }
    }
}

// What the runs before left of a pixel.
fn left_by_others(pixel: vec2<u32>) -> Composed {
    if LATER == 0u || any(pixel >= view.window.zw) {
        return Composed(vec4<f32>(0.0), NOTHING);
    }
    let p = window_index(pixel, view.window);
    return Composed(image[p], select(depth_key(depths[p]), NOTHING, depths[p] > 3.4e38));
}

fn wall_at(pixel: vec2<u32>) -> u32 {
    if any(pixel >= view.window.zw) {
        return 0u;
    }
    if CUT == 0u {
        return NOTHING;
    }
    return depth_key(solid[window_index(pixel, view.window)]);
}

fn finish(sum: Composed, count: u32, pixel: vec2<u32>) {
    if all(pixel < view.window.zw) {
        let p = window_index(pixel, view.window);
        if COUNTED != 0u {
            counts[p] = count + select(0u, counts[p], LATER != 0u);
        }
        image[p] = sum.rgba;
        depths[p] = composed_depth(sum.key);
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
#each held     sum{held} = left_by_others(corner + place(lane, {held}u));
#each held     wall{held} = wall_at(corner + place(lane, {held}u));
#each held     count{held} = 0u;
#each block     let far{block} = farthest({block}u);
    var live = (1u << (BLOCKS * BLOCKS)) - 1u;
    var steps = 0u;
    for (var next = start; next < end && live != 0u; next += SUBGROUP) {
        let present = next + lane < end;
        let rank = entries[min(next + lane, end - 1u)];
        let footprint = footprints[rank];
        let splat = Splat(bitcast<f32>(footprint.x), bitcast<f32>(footprint.y), footprint.z, 0.0, bitcast<f32>(footprint.w));
        let disc = disc_of(splat, records[rank].x + push.nearest, colors[rank], corner);
#each block         let hits{block} = subgroupBallot(present && disc.key < far{block} && touches(splat, corner + block_corner({block}u))).x;
#each block         blend({block}u, select(0u, hits{block}, is_live(live, {block}u)), disc, lane);
        steps += 1u;
        if steps % LOOK == 0u {
#each block             live = close(live, {block}u);
        }
    }
#each held     finish(sum{held}, count{held}, corner + place(lane, {held}u));
}
