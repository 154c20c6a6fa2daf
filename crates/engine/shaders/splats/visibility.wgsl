// splats/visibility: the depth of each pixel's nearest fragment, and the limit behind which fragments are hidden:
// min(z + blend_depth * r), r the drawn radius in world units (Botsch et al. 2004, the first pass, whose depths are
// moved back). One subgroup per block of a tile; a run goes on from the buffers that it fills.
// Reference: reference::splats::limit.
#import splat
#import splats
#import region_fold
@group(0) @binding(20) var<storage, read> layer: array<f32>;
@group(0) @binding(21) var<storage, read_write> limits: array<f32>;
@group(0) @binding(22) var<storage, read_write> depths: array<f32>;

var<private> before: f32;
var<private> limit: f32;
var<private> nearest: f32;

fn begin(pixel: vec2<u32>) {
    limit = bitcast<f32>(INFINITE_BITS);
    nearest = limit;
    before = limit;
    let p = place_of(pixel);
    if is_later() {
        limit = limits[p];
        nearest = depths[p];
    }
    if BEHIND != 0u {
        before = layer[p];
    }
}

fn visit(pixel: vec2<u32>, fragment: Fragment) {
    if counts(fragment, before) {
        let depth = key_depth(fragment.depth_key);
        limit = min(limit, depth + push.blend_depth * fragment.radius);
        nearest = min(nearest, depth);
    }
}

fn finish(pixel: vec2<u32>) {
    if is_inside(pixel) {
        limits[place_of(pixel)] = limit;
        depths[place_of(pixel)] = nearest;
    }
}
