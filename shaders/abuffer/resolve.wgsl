// abuffer/resolve: sorts and blends the lists of LOWEST to CAPACITY fragments; the pixels without any get nothing.
// One invocation per pixel of the band. Reference: reference::abuffer::composite.
#import compose
#import local_sort
#import dispatch

struct Push {
    band_start: u32,
    band_end: u32,
}

@group(0) @binding(13) var<storage, read> offsets: array<u32>;
@group(0) @binding(14) var<storage, read> fragments: array<vec2<u32>>;
@group(0) @binding(15) var<storage, read_write> image: array<vec4<f32>>;
@group(0) @binding(16) var<storage, read_write> depths: array<f32>;
var<immediate> push: Push;

@compute @workgroup_size(WG_SIZE)
fn main(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let p = push.band_start + invocation_index(workgroup, groups, local);
    if p >= push.band_end {
        return;
    }
    let begin = offsets[p];
    let n = offsets[p + 1u] - begin;
    if n < LOWEST || n > CAPACITY {
        return;
    }
    let start = begin - offsets[push.band_start];
    var list: array<vec2<u32>, 2u * CAPACITY>;
    for (var i = 0u; i < n; i++) {
        list[i] = fragments[start + i];
    }
    let sorted = sort_local(&list, n);
    let width = view.window.z - view.window.x;
    let pixel = view.window.xy + vec2<u32>(p % width, p / width);
    var sum = Composed(vec4<f32>(0.0), NOTHING);
    for (var i = 0u; i < n; i++) {
        let fragment = list[sorted + i];
        sum = behind(sum, fragment.x, fragment_color(fragment.y, pixel));
    }
    image[p] = sum.rgba;
    depths[p] = composed_depth(sum.key);
}
