// opaque/resolve: index of the nearest splat to color and depth. One invocation per pixel.
#import compose
#import dispatch

struct Nearest {
    id: u32,
    key: u32,
}

@group(0) @binding(17) var<storage, read> nearest: array<Nearest>;
@group(0) @binding(18) var<storage, read_write> image: array<vec4<f32>>;
@group(0) @binding(19) var<storage, read_write> depths: array<f32>;
#push

#main p {
    if p >= push.count {
        return;
    }
    let found = nearest[p];
    depths[p] = composed_depth(found.key);
    if found.key == NOTHING {
        image[p] = vec4<f32>(0.0);
    } else {
        image[p] = vec4<f32>(color_at(found.id).rgb, 1.0);
    }
}
