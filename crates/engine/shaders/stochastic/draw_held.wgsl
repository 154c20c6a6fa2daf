// stochastic/draw-held: the nearest fragment of each sample of a stratum, among those whose mask has the sample. The
// mask goes to the rasterizer; its depth test keeps the nearest, and of equal depths the first one drawn, which has the
// lowest index. Reference: reference::stochastic::stratum.
#import stochastic_quad
#import held
#import random

// Of the points of the chunk, from which random words follow.
@group(0) @binding(6) var<storage, read> ids: array<u32>;

struct Output {
    @builtin(frag_depth) depth: f32,
    @builtin(sample_mask) mask: u32,
    @location(0) index: f32,
}

@fragment
fn main(@builtin(position) position: vec4<f32>, @location(0) @interpolate(flat) i: u32) -> Output {
    view = camera;
    let pixel = vec2<u32>(position.xy) + view.window.xy;
    let found = quad_fragment(i, pixel);
    let words = words_of(pixel, ids[i], vec2<u32>(push.key_low, push.key_high));
    let mask = mask_of(found.color.a, select(words.x, words.y, push.word == 1u)) & ((1u << push.samples) - 1u);
    if mask == 0u {
        discard;
    }
    return Output(held_depth(found.depth_key, push.base, push.shift), mask, held_index(push.first + i));
}
