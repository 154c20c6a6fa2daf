// points/resolve: index of each pixel's nearest point to its color, shaded here and not before unless several images
// show it, and depth. One invocation per pixel.
#import all_points
#import splat
#import dispatch

// Index and depth key.
@group(0) @binding(17) var<storage, read> nearest: array<vec2<u32>>;
// Colors of all points, if SHADED.
@group(0) @binding(18) var<storage, read> shades: array<vec4<f32>>;
@group(0) @binding(19) var<storage, read_write> image: array<vec4<f32>>;
@group(0) @binding(20) var<storage, read_write> depths: array<f32>;
#push

// 1: points/shade has shaded all points.
override SHADED: u32 = 0u;

fn shown_color(i: u32) -> vec4<f32> {
    if SHADED != 0u {
        return shades[i];
    }
    return vec4<f32>(color_of(i), 1.0);
}

const NOTHING = 0xffffffffu;

#main {
    view = camera;
    let p = invocation_index(workgroup, groups, local);
    if p >= push.count {
        return;
    }
    let found = nearest[p];
    var color = vec4<f32>(0.0);
    var depth = bitcast<f32>(0x7f800000u);
    if found.y != NOTHING {
        color = shown_color(found.x);
        depth = key_depth(found.y);
    }
    image[p] = color;
    depths[p] = depth;
}
