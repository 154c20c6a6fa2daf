// soft/express: composes the soft discs of each tile in the order of an axis (Seemann et al. 2018, Section 3.3), as
// sorted/blend does. Runs over a tile's splats go on from one another's sums, so that where they are cut changes no
// bit. Reference: reference::soft.
#import coverage
#import over
#import stop
#import profile
#import hand_over

// Depths of the solid points: only discs before them count.
@group(0) @binding(20) var<storage, read> solid: array<f32>;
@group(0) @binding(21) var<storage, read_write> image: array<vec4<f32>>;
@group(0) @binding(22) var<storage, read_write> depths: array<f32>;
// Discs of each pixel.
@group(0) @binding(23) var<storage, read_write> counts: array<u32>;
#push

// 1: there are solid points.
override CUT: u32 = 0u;
// 1: some splats have a W below 1.
override MODULATED: u32 = 0u;
// 1: those that cover a pixel before its solid point are counted.
override COUNTED: u32 = 0u;

// State of each of an invocation's pixels.
struct PixelState {
    sum: Composed,
    // Depth key of the solid point, NOTHING where there is none, 0 outside the window.
    wall: u32,
    count: u32,
}

const STOPS = true;
// The farthest solid point of each block: nothing counts there that lies behind.
#each block var<private> far{block}: u32;

// A disc as it is handed from lane to lane.
struct Handed {
    // Only its own lane needs it.
    splat: Splat,
    // From the tile's corner to the pixel of the center, and from the center to the middle of that pixel.
    pixel: vec2<f32>,
    rest: vec2<f32>,
    // 1 / radius².
    scale: f32,
    radius: f32,
    key: u32,
    // Color and W.
    color: vec4<f32>,
}

// Whole pixels and their parts are kept apart, so that an offset is rounded but once, wherever the tile lies.
fn disc_of(splat: Splat, key: u32, color: vec4<f32>, corner: vec2<u32>) -> Handed {
    let pixel = vec2<f32>(center_pixel(splat) - vec2<i32>(corner));
    let rest = 0.5 - vec2<f32>(splat.fraction_x, splat.fraction_y);
    // Finite, since the square of a tiny radius may be 0.
    let scale = min(1.0 / (splat.radius * splat.radius), 3e38);
    return Handed(splat, pixel, rest, scale, splat.radius, key, color);
}

// One disc over one of this invocation's pixels, `further` along from the first one; `disc.pixel` relative to that.
fn add(front: Composed, disc: Handed, further: vec2<u32>, aside: vec2<f32>, wall: u32) -> Composed {
    let offset = (vec2<f32>(further) - disc.pixel) + (disc.rest + aside);
    var squared = min(dot(offset, offset) * disc.scale, 1.0);
    // Of a radius of 0 nothing is left, since d / r counts as 1. Only who counts them is shown any.
    if COUNTED != 0u {
        squared = select(1.0, squared, disc.radius > 0.0);
    }
    var alpha = push.peak * profile(squared);
    if MODULATED != 0u {
        alpha = push.peak * (1.0 - sqrt(squared)) * (1.0 - disc.color.a) + alpha * disc.color.a;
    }
    if CUT != 0u {
        alpha = select(0.0, alpha, disc.key < wall);
    }
    return behind(front, disc.key, vec4<f32>(disc.color.rgb, alpha));
}

// 1 if a disc covers a pixel, as `cover` in shared/coverage.wgsl has it, and lies before its solid point.
fn counts_as(disc: Handed, further: vec2<u32>, aside: vec2<f32>, wall: u32) -> u32 {
    let whole = vec2<f32>(further) - disc.pixel;
    let offset = whole + (disc.rest + aside);
    let inside = dot(offset, offset) <= disc.radius * disc.radius || contains(whole, offset);
    return u32(inside && disc.key < wall);
}

// The fourth component of a soft disc's color is W.
fn take(i: u32, corner: vec2<u32>) -> Handed {
    return disc_of(flat_at(i), depth_key(depth_at(i)), color_at(i), corner);
}

fn begin(pixel: vec2<u32>) -> PixelState {
    return PixelState(left_by_others(pixel), wall_at(pixel), 0u);
}

fn begin_run(cut: bool) {
#each block     far{block} = farthest{block}();
}

#each block
fn farthest{block}() -> u32 {
    var key = 0u;
#each held     key = max(key, held{block}_{held}.wall);
    return subgroupMax(key);
}
#end

fn may_touch(own: Handed, block: u32, corner: vec2<u32>) -> bool {
    var far = 0u;
#each block     if block == {block}u { far = far{block}; }
    let is_shown = COUNTED != 0u || own.radius > 0.0;
    return is_shown && own.key < far && touches(own.splat, corner + block_corner(block));
}

fn handed(own: Handed, k: u32, present: bool, first: vec2<f32>) -> Handed {
    var d: Handed;
    d.pixel = vec2<f32>(select(NOWHERE, subgroupShuffle(own.pixel.x, k), present), subgroupShuffle(own.pixel.y, k)) - first;
    d.rest = vec2<f32>(subgroupShuffle(own.rest.x, k), subgroupShuffle(own.rest.y, k));
    // A lane that took no disc has a scale of 0, by which everything would be near.
    d.scale = select(1.0, subgroupShuffle(own.scale, k), present);
    d.key = subgroupShuffle(own.key, k);
    if COUNTED != 0u {
        d.radius = subgroupShuffle(own.radius, k);
    }
    d.color = vec4<f32>(
        subgroupShuffle(own.color.r, k), subgroupShuffle(own.color.g, k), subgroupShuffle(own.color.b, k), 1.0,
    );
    if MODULATED != 0u {
        d.color.a = subgroupShuffle(own.color.a, k);
    }
    return d;
}

// `disc.pixel` is relative to the invocation's first pixel.
fn show(before: PixelState, disc: Handed, further: vec2<u32>, pixel: vec2<u32>) -> PixelState {
    var held = before;
    // From the middle of the pixel.
    let aside = sample_in(pixel) - 0.5;
    if COUNTED != 0u {
        held.count += counts_as(disc, further, aside, held.wall);
    }
    held.sum = add(held.sum, disc, further, aside, held.wall);
    return held;
}

fn is_done(held: PixelState) -> bool {
    return held.wall == 0u || done(held.sum, push.peak, push.max_color);
}

// Result of the runs before for a pixel.
fn left_by_others(pixel: vec2<u32>) -> Composed {
    if !is_later() || any(pixel >= view.window.zw) {
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

fn finish(held: PixelState, pixel: vec2<u32>) {
    if all(pixel < view.window.zw) {
        let p = window_index(pixel, view.window);
        if COUNTED != 0u {
            counts[p] = held.count + select(0u, counts[p], is_later());
        }
        image[p] = held.sum.rgba;
        depths[p] = composed_depth(held.sum.key);
    }
}
