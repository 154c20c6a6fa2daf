// stochastic/draw-alpha: total opacity of each pixel. One draw of all splats; blending makes A + alpha (1 - A) of A, in
// whatever order the fragments come. Reference: the A of reference::abuffer::composite.
#import stochastic_quad

@fragment
fn main(@builtin(position) position: vec4<f32>, @location(0) @interpolate(flat) i: u32) -> @location(0) f32 {
    view = camera;
    let found = quad_fragment(i, vec2<u32>(position.xy) + view.window.xy);
    if found.color.a == 0.0 {
        discard;
    }
    return found.color.a;
}
