// shadows/lit: every point again; those that lie behind what a light sees lose it (Dobrev et al. 2010, Section 6).
#import every_point

struct Light {
    // Smallest distance of surfaces.
    apart: f32,
    // Face of a cube around the light: axis of the world and sign.
    face: u32,
}

// The fourth component is the number of lights that reach the point.
@group(0) @binding(4) var<storage, read_write> normals: array<vec4<f32>>;
// Depth of the nearest surface.
@group(0) @binding(5) var<storage, read> depths: array<f32>;
@group(0) @binding(6) var<uniform> light: Light;

// 1: the image is one of six, which overlap by their margins: a point belongs to that of its largest coordinate.
override CUBE: u32 = 0u;

// The distance from one surface to the next is that along the normal. Where the light grazes, it ends somewhere.
const FLATTEST = 0.1;

fn on_face(from_light: vec3<f32>) -> bool {
    let far = abs(from_light);
    let most = max(far.x, max(far.y, far.z));
    let axis = select(select(2u, 1u, far.y == most), 0u, far.x == most);
    let sign = u32(from_light[axis] < 0.0);
    return light.face == 2u * axis + sign;
}

fn visit(i: u32, hit: Hit) -> u32 {
    let k = i - push.first;
    let normal = normals[k];
    let along = abs(dot3(normal.xyz, view.forward.xyz));
    // An estimated one, of length 2, says too little of the surface.
    let unknown = all(normal.xyz == vec3<f32>(0.0)) || dot(normal.xyz, normal.xyz) > 2.0;
    let slope = select(max(along, FLATTEST), 1.0, unknown);
    var dark = key_depth(hit.key) > depths[hit.pixel] + light.apart / slope;
    if CUBE != 0u {
        dark = dark && on_face(rounded(minus_eye(points_hi[k].xyz, points_lo[k].xyz)));
    }
    if dark {
        normals[k].w = normal.w - 1.0;
    }
    return 0u;
}
