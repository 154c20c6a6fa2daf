// stochastic/estimate: the strata's means to color, opacity, depth and standard error. One invocation per pixel.
// C = f R and R = mean X / mean Y, with f = A and Y = w A_p, or, without alpha correction, f = 1 and Y = w. The error is that
// of a ratio (Cochran, "Sampling Techniques", Section 2.11): f / mean Y sqrt(sum (X - R Y)^2 / (P (P - 1))) for P strata.
// Reference: reference::stochastic::estimate.
#import moments
#import held
#import dispatch

@group(0) @binding(0) var alphas: texture_2d<f32>;
@group(0) @binding(1) var<storage, read> means: array<vec4<f32>>;
@group(0) @binding(2) var<storage, read> squares: array<vec4<f32>>;
@group(0) @binding(3) var<storage, read> products: array<vec4<f32>>;
@group(0) @binding(4) var<storage, read_write> image: array<vec4<f32>>;
@group(0) @binding(5) var<storage, read_write> depths: array<f32>;
@group(0) @binding(6) var<storage, read_write> errors: array<vec4<f32>>;
var<immediate> push: MomentsPush;

@compute @workgroup_size(WG_SIZE)
fn main(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let p = invocation_index(workgroup, groups, local);
    if p >= push.count {
        return;
    }
    let mean = means[p];
    var total = mean.a / push.weight;
    var factor = 1.0;
    var below = push.weight;
    if push.corrected == 1u {
        total = textureLoad(alphas, vec2<u32>(p % push.width, p / push.width), 0).x;
        factor = total;
        below = mean.a;
    }
    let safe = select(1.0, below, below > 0.0);
    let ratio = mean.rgb / safe;
    let about = products[p];
    let of_y = squares[p].a;
    let spread = squares[p].rgb - 2.0 * ratio * about.rgb + ratio * ratio * of_y;
    let n = f32(push.stratum);
    let error = factor / safe * sqrt(max(spread, vec3<f32>(0.0)) / (n * (n - 1.0)));
    image[p] = vec4<f32>(factor * ratio, total);
    depths[p] = depth_of_held(about.a, push.base, push.shift);
    // One stratum says nothing about the spread.
    let unknown = vec3<f32>(bitcast<f32>(select(0u, 0x7f800000u, push.stratum == 1u)));
    errors[p] = vec4<f32>(select(error, unknown, push.stratum == 1u), 0.0);
}
