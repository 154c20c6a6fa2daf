// stochastic/resolve: the sums over all strata to color, A and, with SPREAD = 1, the standard error of color. One
// invocation per pixel. Reference: reference::stochastic::estimate.
#import dispatch

#push

@group(0) @binding(0) var<storage, read> exact: array<f32>;
@group(0) @binding(1) var<storage, read_write> image: array<vec4<f32>>;
@group(0) @binding(2) var<storage, read_write> spread: array<vec4<f32>>;

override SPREAD: u32 = 0u;
// 1: alpha correction.
override EXACT: u32 = 0u;

@compute @workgroup_size(WG_SIZE)
fn main(
    @builtin(local_invocation_index) local: u32,
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
) {
    let p = invocation_index(workgroup, groups, local);
    if p >= push.pixels {
        return;
    }
    let total = image[p];
    let strata = 0.25 * f32(push.samples);
    var below = strata;
    var factor = 1.0;
    var alpha = total.a / strata;
    if EXACT != 0u {
        below = total.a;
        factor = exact[p];
        alpha = factor;
    }
    let scale = select(0.0, factor / below, below > 0.0);
    image[p] = vec4<f32>(total.rgb * scale, alpha);
    if SPREAD != 0u {
        let count = f32((push.samples + 3u) / 4u);
        // f / mean(a) * sqrt(Q / (P (P - 1))).
        let error = scale * sqrt(spread[p].rgb * count / max(count - 1.0, 1.0));
        spread[p] = vec4<f32>(select(error, vec3<f32>(bitcast<f32>(0x7f800000u)), count == 1.0), 0.0);
    }
}
