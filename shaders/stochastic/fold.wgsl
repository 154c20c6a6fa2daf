// stochastic/fold: means and spread of the strata so far, and the nearest depth. One invocation per pixel. The spread is
// updated from the distance to the mean before and after (Welford 1962), so that nothing cancels.
#import moments
#import dispatch

@group(0) @binding(0) var depths: texture_depth_multisampled_2d;
@group(0) @binding(1) var sums: texture_2d<f32>;
// Means of w C_p and of w A_p.
@group(0) @binding(2) var<storage, read_write> means: array<vec4<f32>>;
// Sums of squares of X and of Y about their means.
@group(0) @binding(3) var<storage, read_write> squares: array<vec4<f32>>;
// Sums of products of X and Y about their means, and the nearest held depth.
@group(0) @binding(4) var<storage, read_write> products: array<vec4<f32>>;
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
    let pixel = vec2<u32>(p % push.width, p / push.width);
    var nearest = 1.0;
    for (var s = 0u; s < push.samples; s++) {
        nearest = min(nearest, textureLoad(depths, pixel, i32(s)));
    }
    let share = 0.25 * f32(push.samples);
    let found = share * textureLoad(sums, pixel, 0);
    if push.stratum == 1u {
        means[p] = found;
        squares[p] = vec4<f32>(0.0);
        products[p] = vec4<f32>(0.0, 0.0, 0.0, nearest);
        return;
    }
    let before = means[p];
    let away = found - before;
    let mean = before + away / f32(push.stratum);
    // The mean of w before: the sum less this one's.
    let n = f32(push.stratum);
    let weight_before = (push.weight * n - share) / (n - 1.0);
    let y_away = select(share - weight_before, away.a, push.corrected == 1u);
    let y_rest = select(share - push.weight, found.a - mean.a, push.corrected == 1u);
    let x_rest = found.rgb - mean.rgb;
    let so_far = products[p];
    means[p] = mean;
    squares[p] += vec4<f32>(away.rgb * x_rest, y_away * y_rest);
    products[p] = vec4<f32>(so_far.rgb + away.rgb * y_rest, min(so_far.a, nearest));
}
