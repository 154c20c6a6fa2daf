// points/resolve: index of each pixel's nearest point to its color, shaded here and not before, and depth. One
// invocation per pixel.
#import all_points
#import splat
#import dispatch

// Index and depth key.
@group(0) @binding(17) var<storage, read> nearest: array<vec2<u32>>;
// The same of the image that was resolved last, if AGAIN.
@group(0) @binding(18) var<storage, read> last: array<vec2<u32>>;
@group(0) @binding(19) var<storage, read_write> image: array<vec4<f32>>;
@group(0) @binding(20) var<storage, read_write> depths: array<f32>;
#push

// 1: a pixel that shows the same point as in the last image stays as it is.
override AGAIN: u32 = 0u;

const NOTHING = 0xffffffffu;

#main {
    view = camera;
    let p = invocation_index(workgroup, groups, local);
    if p >= push.count {
        return;
    }
    let found = nearest[p];
    if AGAIN != 0u && found.x == last[p].x {
        return;
    }
    var color = vec4<f32>(0.0);
    var depth = bitcast<f32>(0x7f800000u);
    if found.y != NOTHING {
        color = vec4<f32>(color_of(found.x), 1.0);
        depth = key_depth(found.y);
    }
    image[p] = color;
    depths[p] = depth;
}
