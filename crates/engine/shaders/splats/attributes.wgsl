// splats/attributes: colors times weight, and weights exp(-2 rho^2), of the fragments that are not hidden, summed
// (Botsch et al. 2004, the second pass). One subgroup per block of a tile; one of several runs leaves what the next
// needs to round as if there were one. Relies on splats/visibility finding depths by the same arithmetic: the nearest
// fragment always counts. Reference: reference::splats::blend.
#import elementary
#import splat
#import splats
#import sums
#import region_fold
@group(0) @binding(20) var<storage, read> layer: array<f32>;
@group(0) @binding(21) var<storage, read> limits: array<f32>;
@group(0) @binding(22) var<storage, read_write> image: array<vec4<f32>>;
@group(0) @binding(23) var<storage, read_write> excess: array<vec4<f32>>;

var<private> before: f32;
var<private> limit: f32;
var<private> sum: Sum;

fn begin(pixel: vec2<u32>) {
    let p = place_of(pixel);
    limit = limits[p];
    sum = Sum(vec4<f32>(0.0), vec4<f32>(0.0));
    if is_later() {
        sum = Sum(image[p], excess[p]);
    }
    before = 0.0;
    if BEHIND != 0u {
        before = layer[p];
    }
}

fn visit(pixel: vec2<u32>, fragment: Fragment) {
    if counts(fragment, before) && key_depth(fragment.depth_key) <= limit {
        let weight = gaussian(fragment.rho);
        sum = plus(sum, weight * vec4<f32>(fragment.color.rgb, 1.0));
    }
}

fn finish(pixel: vec2<u32>) {
    if is_inside(pixel) {
        image[place_of(pixel)] = sum.total;
        if is_one_of_several() {
            excess[place_of(pixel)] = sum.excess;
        }
    }
}
