// stochastic/fold: from the attachments of a stratum to the buffers that stochastic/accumulate fills, those of a run of
// strata, and the nearest depth. One invocation per pixel.
// Layout of `sums`: all pixels over the run's samples; with SPREAD = 1 then the same for each stratum alone.
#import held
#import dispatch

#push

@group(0) @binding(0) var held_depths: texture_depth_multisampled_2d;
@group(0) @binding(1) var drawn: texture_2d<f32>;
@group(0) @binding(2) var drawn_alpha: texture_2d<f32>;
@group(0) @binding(3) var<storage, read_write> sums: array<vec4<f32>>;
@group(0) @binding(4) var<storage, read_write> exact: array<f32>;
@group(0) @binding(5) var<storage, read_write> depths: array<f32>;

override SPREAD: u32 = 0u;
// 1: alpha correction.
override EXACT: u32 = 0u;

#main p {
    if p >= push.pixels {
        return;
    }
    let place = vec2<u32>(p % push.width, p / push.width);
    let found = textureLoad(drawn, place, 0);
    if push.stratum == 0u {
        sums[p] = found;
    } else {
        sums[p] += found;
    }
    if SPREAD != 0u {
        sums[(push.stratum + 1u) * push.pixels + p] = found;
    }
    if EXACT != 0u && push.first == 1u {
        exact[p] = textureLoad(drawn_alpha, place, 0).x;
    }
    var nearest = 1.0;
    for (var s = 0u; s < push.samples; s++) {
        nearest = min(nearest, textureLoad(held_depths, place, i32(s)));
    }
    let depth = depth_of_held(nearest, push.base, push.shift);
    if push.first == 1u {
        depths[p] = depth;
    } else {
        depths[p] = min(depths[p], depth);
    }
}
