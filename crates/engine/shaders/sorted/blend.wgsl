// sorted/blend: composes each tile's splats front to back. Every invocation holds the sums of its pixels in registers
// (shared/hand_over.wgsl). A block is done when nothing behind can change its output.
// Reference: reference::sorted.
#import over
#import folding
#import stop
#import hand_over

struct Push {
    walk: TileWalk,
    // Largest opacity, and largest color component, background included: bounds of the splats behind.
    max_opacity: f32,
    max_color: f32,
}

@group(0) @binding(20) var<storage, read_write> image: array<vec4<f32>>;
@group(0) @binding(21) var<storage, read_write> depths: array<f32>;
var<immediate> push: Push;

alias PixelState = Composed;

const STOPS = true;

// A later run goes on from what the image holds: how a tile's splats are cut into runs shows in no bit.
fn begin(pixel: vec2<u32>) -> Composed {
    return left_by_others(pixel);
}

fn begin_run() {
}

fn take(i: u32, corner: vec2<u32>) -> Handed {
    return whole_splat(i, corner);
}

fn may_touch(own: Handed, block: u32, corner: vec2<u32>) -> bool {
    return SHAPE == SHAPE_ORIENTED || touches(own.splat, corner + block_corner(block));
}

fn show(held: Composed, h: Handed, i: u32, pixel: vec2<u32>) -> Composed {
    let fragment = fragment_of(h, place(0u, i), pixel);
    // A flat splat's index stands for its key: one look-up at the end gives the depth.
    let key = select(h.index, fragment.depth_key, SHAPE == SHAPE_ORIENTED);
    return behind(held, key, fragment.color);
}

fn is_done(held: Composed) -> bool {
    return done(held, push.max_opacity, push.max_color);
}

// Stands for the key of a fragment of an earlier run, whose depth is there: no index, and the key of no depth.
const SEEN = 0xfffffffeu;

// Result of the runs before for a pixel.
fn left_by_others(pixel: vec2<u32>) -> Composed {
    if LATER == 0u || any(pixel >= view.window.zw) {
        return Composed(vec4<f32>(0.0), NOTHING);
    }
    let p = window_index(pixel, view.window);
    return Composed(image[p], select(SEEN, NOTHING, depths[p] > 3.4e38));
}

fn finish(held: Composed, pixel: vec2<u32>) {
    if any(pixel >= view.window.zw) {
        return;
    }
    let p = window_index(pixel, view.window);
    image[p] = held.rgba;
    if LATER != 0u && held.key == SEEN {
        return;
    }
    var key = held.key;
    if SHAPE != SHAPE_ORIENTED && key != NOTHING {
        key = depth_key(depth_at(key));
    }
    depths[p] = composed_depth(key);
}
