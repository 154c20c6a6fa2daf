// stochastic/draw-sums: sum of alpha c and of alpha over the fragments of each pixel and the samples that hold nothing
// before the fragment, in strata, by blending. Reference: reference::stochastic::stratum.
#import stochastic_quad
#import held

@group(0) @binding(6) var depths: texture_depth_multisampled_2d;
@group(0) @binding(7) var indices: texture_multisampled_2d<f32>;

// 1 where a sample holds nothing before a fragment.
fn seen(pixel: vec2<u32>, sample: u32, depth: f32, index: u32) -> f32 {
    let held = textureLoad(depths, pixel, i32(sample));
    let first = bitcast<u32>(textureLoad(indices, pixel, i32(sample)).x) >= index;
    let behind = held > depth || (held == depth && first);
    return select(0.0, 1.0, behind && sample < push.samples);
}

@fragment
fn main(@builtin(position) position: vec4<f32>, @location(0) @interpolate(flat) i: u32) -> @location(0) vec4<f32> {
    view = camera;
    // Attachments begin at the window's corner.
    let place = vec2<u32>(position.xy);
    let found = quad_fragment(i, place + view.window.xy);
    if found.color.a == 0.0 {
        discard;
    }
    let depth = held_depth(found.depth_key, push.base, push.shift);
    let index = bitcast<u32>(held_index(push.first + i));
    var visible = seen(place, 0u, depth, index) + seen(place, 1u, depth, index);
    visible += seen(place, 2u, depth, index) + seen(place, 3u, depth, index);
    // The arithmetic of stochastic/accumulate.
    return vec4<f32>(found.color.rgb, 1.0) * found.color.a * 0.25 * visible;
}
