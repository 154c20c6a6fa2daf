// abuffer/resolve-ordered: blends lists whose fragments were stored in the order of blending. One invocation per pixel of the
// band; longer lists are composed run by run.
// Reference: reference::abuffer::composite.
#import compose
#import stop
#import long_list
#import dispatch

struct Push {
    band_start: u32,
    band_end: u32,
    first_fragment: u32,
    // Largest opacity, and largest color component, background included.
    most_opacity: f32,
    most_color: f32,
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
    let n = offsets[p + 1u] - offsets[p];
    if n == 0u || n > RUN_LENGTH {
        return;
    }
    let start = offsets[p] - push.first_fragment;
    let width = view.window.z - view.window.x;
    let pixel = view.window.xy + vec2<u32>(p % width, p / width);
    var sum = Composed(vec4<f32>(0.0), NOTHING);
    var i = 0u;
    // There is a first fragment, so the condition may stand at the end: CPU drivers run every loop once more otherwise.
    loop {
        let fragment = fragments[start + i];
        sum = behind(sum, fragment.x, fragment_color(fragment.y, pixel));
        i += 1u;
        if i >= n || (i % 16u == 0u && done(sum, push.most_opacity, push.most_color)) {
            break;
        }
    }
    image[p] = sum.rgba;
    depths[p] = composed_depth(sum.key);
}
