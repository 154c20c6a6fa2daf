// Colors of points as they are blended: shading, encoding.
#import camera

const SHADING_NONE = 0u;
const SHADING_LAMBERT = 1u;
const SHADING_PHONG = 2u;
override SHADING: u32 = 0u;
// 1: blending runs on sRGB-encoded values.
override ENCODED: u32 = 0u;

fn encode(c: vec3<f32>) -> vec3<f32> {
    let curve = 1.055 * pow(max(c, vec3<f32>(0.0)), vec3<f32>(1.0 / 2.4)) - 0.055;
    return select(curve, c * 12.92, c <= vec3<f32>(0.0031308));
}

// Interface: c(ambient + diffuse max(0, n.l)), two-sided; Phong adds specular max(0, r.v)^shininess.
fn shade(color: vec3<f32>, position: vec3<f32>, normal: vec3<f32>) -> vec3<f32> {
    var to_eye = vec3<f32>(0.0, 0.0, -1.0);
    if view.orthographic == 0u {
        to_eye = normalize(-position);
    }
    let n = select(-normal, normal, dot(normal, to_eye) >= 0.0);
    var l = view.light.xyz;
    if view.light.w != 0.0 {
        let toward = view.light.xyz - position;
        let reach = length(toward);
        l = select(to_eye, toward / reach, reach > 0.0);
    }
    let facing = dot(n, l);
    var shaded = color * (view.material.x + view.material.y * max(facing, 0.0));
    if SHADING == SHADING_PHONG && facing > 0.0 {
        let along = max(dot(2.0 * facing * n - l, to_eye), 0.0);
        // pow(0, 0) is 1 by definition here.
        shaded += vec3<f32>(view.material.z * select(pow(along, view.material.w), 1.0, view.material.w == 0.0));
    }
    return shaded;
}

// The color of a point as it is blended; a zero normal is none.
fn blended_color(linear: vec3<f32>, position: vec3<f32>, normal: vec3<f32>) -> vec3<f32> {
    var color = linear;
    if SHADING != SHADING_NONE && any(normal != vec3<f32>(0.0)) {
        color = shade(color, position, normalize(normal));
    }
    if ENCODED != 0u {
        color = encode(color);
    }
    return color;
}
