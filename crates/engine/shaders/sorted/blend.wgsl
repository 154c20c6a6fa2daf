// sorted/blend: composes each tile's splats front to back. Every invocation holds the sums of its pixels in registers
// (shared/hand_over.wgsl). A block is done when nothing behind can change its output.
// Reference: reference::sorted.
#import over
#import folding
#import stop
#import early_end
#import hand_over

@group(0) @binding(20) var<storage, read_write> image: array<vec4<f32>>;
@group(0) @binding(21) var<storage, read_write> depths: array<f32>;
#push

// Runs are composed by themselves: a later one goes behind what the image holds.
struct PixelState {
    sum: Composed,
    front: Composed,
    // Of Gaussians: true once the list has ended early.
    ended: bool,
}

const STOPS = true;
// The sign bit of a float. Between two runs A has it where the list has ended.
const SIGN = 0x80000000u;
// Largest opacity of the splats behind: another run may be opaque.
var<private> max_opacity: f32;
// True if another run follows.
var<private> is_cut: bool;

fn begin(pixel: vec2<u32>) -> PixelState {
    var front = left_by_others(pixel);
    let a = bitcast<u32>(front.rgba.a);
    front.rgba.a = bitcast<f32>(a & ~SIGN);
    return PixelState(Composed(vec4<f32>(0.0), NOTHING), front, (a & SIGN) != 0u);
}

fn begin_run(cut: bool) {
    max_opacity = select(push.max_opacity, 1.0, is_later() || cut);
    is_cut = cut;
}

fn take(i: u32, corner: vec2<u32>) -> Handed {
    return whole_splat(i, corner);
}

fn may_touch(own: Handed, block: u32, corner: vec2<u32>) -> bool {
    return is_rectangle() || touches(own.splat, corner + block_corner(block));
}

fn show(held: PixelState, h: Handed, further: vec2<u32>, pixel: vec2<u32>) -> PixelState {
    let fragment = fragment_of(h, further, pixel);
    // A flat splat's index stands for its key: one look-up at the end gives the depth.
    let key = select(h.index, fragment.shown_key, may_cross());
    let next = PixelState(behind(held.sum, key, fragment.color), held.front, false);
    if has_gaussians() && (held.ended || is_end(joined(next).rgba.a)) {
        return PixelState(held.sum, held.front, true);
    }
    return next;
}

// This run's composition, behind that of the runs in front of it.
fn joined(held: PixelState) -> Composed {
    if !is_later() {
        return held.sum;
    }
    return Composed(held.front.rgba + (1.0 - held.front.rgba.a) * held.sum.rgba, held.front.key);
}

fn is_done(held: PixelState) -> bool {
    return (has_gaussians() && held.ended) || done(joined(held), max_opacity, push.max_color);
}

// Result of the runs before for a pixel. A depth stands for its key: nothing behind asks for the index again.
fn left_by_others(pixel: vec2<u32>) -> Composed {
    if !is_later() || any(pixel >= view.window.zw) {
        return Composed(vec4<f32>(0.0), NOTHING);
    }
    let p = window_index(pixel, view.window);
    return Composed(image[p], select(0u, NOTHING, depths[p] > 3.4e38));
}

fn finish(held: PixelState, pixel: vec2<u32>) {
    if any(pixel >= view.window.zw) {
        return;
    }
    let p = window_index(pixel, view.window);
    var rgba = joined(held).rgba;
    if has_gaussians() && held.ended && is_cut {
        rgba.a = bitcast<f32>(bitcast<u32>(rgba.a) | SIGN);
    }
    image[p] = rgba;
    if !is_later() || (held.front.key == NOTHING && held.sum.key != NOTHING) {
        var key = held.sum.key;
        if !may_cross() && key != NOTHING {
            key = depth_key(shown_depth(flat_at(key), tilt_at(key), depth_at(key)));
        }
        depths[p] = composed_depth(key);
    }
}
