// spbr/resolve: sums over all ensembles to color, A, depth and, with SPREAD = 1, the standard error of color. One
// invocation per pixel. Reference: reference::spbr.
#import dispatch
#import splat

#push

// As in spbr/sum.
@group(0) @binding(0) var<storage, read> pixels: array<vec4<u32>>;
@group(0) @binding(1) var<storage, read> squares: array<vec4<u32>>;
@group(0) @binding(2) var<storage, read_write> image: array<vec4<f32>>;
@group(0) @binding(3) var<storage, read_write> depths: array<f32>;
@group(0) @binding(4) var<storage, read_write> spread: array<vec4<f32>>;

override SPREAD: u32 = 0u;

// Product of two words, low and high.
fn product(a: u32, b: u32) -> vec2<u32> {
    let a_low = a & 0xffffu;
    let b_low = b & 0xffffu;
    let first = a_low * b_low;
    let second = (a >> 16u) * b_low + (first >> 16u);
    let third = a_low * (b >> 16u) + (second & 0xffffu);
    return vec2<u32>((third << 16u) | (first & 0xffffu), (a >> 16u) * (b >> 16u) + (second >> 16u) + (third >> 16u));
}

// L Q - S^2 of a channel's sum S and sum of squares Q, exactly: both are below 2^64, and it is not negative.
fn spread_of(sum: u32, squared: vec2<u32>) -> f32 {
    var first = product(push.ensembles, squared.x);
    first.y += push.ensembles * squared.y;
    let second = product(sum, sum);
    let borrow = u32(first.x < second.x);
    return f32(first.y - second.y - borrow) * 4294967296.0 + f32(first.x - second.x);
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
    let last = pixels[2u * p + 1u];
    // Green, red, number, blue.
    let sum = vec4<u32>(pixels[2u * p].zw, last.xy);
    let count = f32(push.ensembles);
    image[p] = vec4<f32>(vec3<f32>(sum.yxw) / (push.scale * count), f32(sum.z) / count);
    depths[p] = select(key_depth(~last.z), bitcast<f32>(0x7f800000u), sum.z == 0u);
    if SPREAD != 0u {
        let first = squares[2u * p];
        let second = squares[2u * p + 1u];
        let apart = vec3<f32>(spread_of(sum.y, first.xy), spread_of(sum.x, first.zw), spread_of(sum.w, second.xy));
        // sqrt((Q / L - mean^2) / (L - 1)).
        let error = sqrt(apart / max(count - 1.0, 1.0)) / (push.scale * count);
        spread[p] = vec4<f32>(select(error, vec3<f32>(bitcast<f32>(0x7f800000u)), count == 1.0), 0.0);
    }
}
