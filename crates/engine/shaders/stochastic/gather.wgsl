// stochastic/gather: a run's strata added to those before. One invocation per pixel.
//
// With SPREAD = 1 it also keeps what the standard error needs. Color is a ratio of sums over strata, R = sum c / sum a,
// with a = A_p under alpha correction and the stratum's weight without it; the error follows from Q = sum (c - R a)^2.
// R moves by some d with every stratum, and Q with it: each term becomes (c - R a - d a)^2, so that Q needs X = sum (c
// - R a) a and S = sum a^2. Nothing large cancels, as it would in sum c^2 - ...: the terms are deviations from the R of
//   the moment.
// Layout of `spread`: Q and S, then X, of all pixels each.
// Reference: reference::stochastic::estimate.
#import dispatch

#push

@group(0) @binding(0) var<storage, read> sums: array<vec4<f32>>;
@group(0) @binding(1) var<storage, read_write> image: array<vec4<f32>>;
@group(0) @binding(2) var<storage, read_write> spread: array<vec4<f32>>;

override SPREAD: u32 = 0u;
// 1: alpha correction.
override EXACT: u32 = 0u;

struct Spread {
    // Sum of c, and of a.
    total: vec4<f32>,
    squares: vec4<f32>,
    cross: vec3<f32>,
}

fn ratio(total: vec4<f32>) -> vec3<f32> {
    return select(vec3<f32>(0.0), total.rgb / total.a, total.a > 0.0);
}

// A stratum more, of so many samples.
fn with_stratum(old: Spread, stratum: vec4<f32>, samples: u32) -> Spread {
    if samples == 0u {
        return old;
    }
    let a = select(0.25 * f32(samples), stratum.a, EXACT != 0u);
    let total = old.total + vec4<f32>(stratum.rgb, a);
    let r = ratio(total);
    let d = r - ratio(old.total);
    let rest = stratum.rgb - r * a;
    let squares = max(old.squares.rgb + d * (d * old.squares.a - 2.0 * old.cross) + rest * rest, vec3<f32>(0.0));
    return Spread(total, vec4<f32>(squares, old.squares.a + a * a), old.cross - d * old.squares.a + rest * a);
}

fn samples_of(s: u32) -> u32 {
    return min(max(push.left, 4u * s) - 4u * s, 4u);
}

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
    let first = push.before == 0u;
    let total = select(image[p], vec4<f32>(0.0), first);
    image[p] = total + sums[p];
    if SPREAD != 0u {
        let below = select(0.25 * f32(push.before), total.a, EXACT != 0u);
        var found = Spread(vec4<f32>(total.rgb, below), vec4<f32>(0.0), vec3<f32>(0.0));
        if !first {
            found.squares = spread[p];
            found.cross = spread[push.pixels + p].xyz;
        }
#each stratum         found = with_stratum(found, sums[({stratum}u + 1u) * push.pixels + p], samples_of({stratum}u));
        spread[p] = found.squares;
        spread[push.pixels + p] = vec4<f32>(found.cross, 0.0);
    }
}
