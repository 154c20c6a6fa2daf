// Opaque splats in three passes (Botsch et al. 2004): shared by visibility and attributes. One subgroup per block of a
// tile; splats come in canonical order. The stage imports `splat` before, and `region_fold` after this.
#push

// 1: the fourth component of colors says which splats are solid (1); of the others only what lies behind the layer
// counts.
override BEHIND: u32 = 0u;

const INFINITE_BITS = 0x7f800000u;

// True if a splat's fragment counts in a pixel where the layer before it has this depth.
fn counts(f: Fragment, layer: f32) -> bool {
    let behind = f.color.a > 0.5 || key_depth(f.depth_key) > layer + push.blend_depth * f.radius;
    return f.hit && (BEHIND == 0u || behind);
}

// Place of a pixel in the buffers of the window; of its last one for those outside.
fn place_of(pixel: vec2<u32>) -> u32 {
    return window_index(min(pixel, view.window.zw - 1u), view.window);
}

fn is_inside(pixel: vec2<u32>) -> bool {
    return all(pixel < view.window.zw);
}
