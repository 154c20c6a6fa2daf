// stochastic/fold: from the attachments of a stratum to the buffers that stochastic/accumulate fills, those of a run of
// strata, and the nearest depth. One invocation per pixel.
// Layout of `sums`: all pixels over the run's samples; with SPREAD = 1 then the same for each stratum alone.
#import held
#import dispatch

struct Push {
    // Columns and pixels of the window.
    width: u32,
    pixels: u32,
    // This stratum among the run's.
    stratum: u32,
    // Its samples that count, 1 to 4.
    samples: u32,
    // 1 for the very first stratum.
    first: u32,
    // Scale of held depths.
    base: u32,
    shift: u32,
}
var<immediate> push: Push;

@group(0) @binding(0) var held_depths: texture_depth_multisampled_2d;
@group(0) @binding(1) var drawn: texture_2d<f32>;
@group(0) @binding(2) var drawn_alpha: texture_2d<f32>;
@group(0) @binding(3) var<storage, read_write> sums: array<vec4<f32>>;
@group(0) @binding(4) var<storage, read_write> exact: array<f32>;
@group(0) @binding(5) var<storage, read_write> depths: array<f32>;

override SPREAD: u32 = 0u;
// 1: alpha correction.
override EXACT: u32 = 0u;

@compute @workgroup_size(WG_SIZE)
fn main(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let p = invocation_index(workgroup, groups, local);
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
