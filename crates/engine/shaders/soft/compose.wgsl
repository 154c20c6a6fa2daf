// soft/compose: the soft points of each pixel before its solid one. One invocation per pixel of the window.
#import dispatch

@group(0) @binding(0) var<storage, read> solid_image: array<vec4<f32>>;
@group(0) @binding(1) var<storage, read> solid_depths: array<f32>;
@group(0) @binding(2) var<storage, read_write> image: array<vec4<f32>>;
@group(0) @binding(3) var<storage, read_write> depths: array<f32>;
#push

#main p {
    if p >= push.count {
        return;
    }
    let soft = image[p];
    image[p] = soft + (1.0 - soft.a) * solid_image[p];
    // Soft points with opacity lie before the solid ones.
    depths[p] = min(depths[p], solid_depths[p] + push.origin);
}
