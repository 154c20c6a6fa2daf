// Colors of points as they are blended: shading, encoding.
#import elementary
#import camera
#import encode

override SHADING: u32 = 0u;
// 1: points have shares of light.
override LIT: u32 = 0u;
// 1: blending runs on sRGB-encoded values.
override ENCODED: u32 = 0u;

// Interface: c(ambient + diffuse max(0, n.l)), two-sided; Phong adds specular max(0, r.v)^shininess. Of the light,
// diffuse and specular, m arrives (Dobrev et al. 2010, Section 6); 1 changes no bit.
fn shade(color: vec3<f32>, position: vec3<f32>, normal: vec3<f32>, m: f32) -> vec3<f32> {
    var to_eye = vec3<f32>(0.0, 0.0, -1.0);
    if view.orthographic == 0u {
        to_eye = unit3(-position);
    }
    let n = select(-normal, normal, dot3(normal, to_eye) >= 0.0);
    var l = view.light.xyz;
    if view.light.w != 0.0 {
        let toward = view.light.xyz - position;
        let reach = length3(toward);
        l = select(to_eye, toward / reach, reach > 0.0);
    }
    let facing = dot3(n, l);
    var shaded = color * (view.material.x + m * (view.material.y * max(facing, 0.0)));
    if SHADING == SHADING_PHONG && facing > 0.0 {
        let along = max(dot3(2.0 * facing * n - l, to_eye), 0.0);
        // pow(0, 0) is 1 by definition here.
        shaded += vec3<f32>(m * (view.material.z * select(power(along, view.material.w), 1.0, view.material.w == 0.0)));
    }
    return shaded;
}

// Estimated normals have a length of 2: they shade, but tilt and hide nothing.
fn is_estimated(normal: vec3<f32>) -> bool {
    return dot(normal, normal) > 2.0;
}

// The color of a point without a normal: as bright as it is, less what does not arrive.
fn shadowed(color: vec3<f32>, m: f32) -> vec3<f32> {
    let all = view.material.x + view.material.y;
    return color * select(1.0, (view.material.x + m * view.material.y) / all, all > 0.0);
}

// The color of a point as it is blended; a zero normal is none.
fn blended_color(linear: vec3<f32>, position: vec3<f32>, normal: vec3<f32>) -> vec3<f32> {
    return lit_color(linear, position, normal, 1.0);
}

// The same where the light's share m arrives, as the fourth component of normals says it.
fn lit_color(linear: vec3<f32>, position: vec3<f32>, normal: vec3<f32>, m: f32) -> vec3<f32> {
    var color = linear;
    if SHADING != SHADING_NONE {
        if any(normal != vec3<f32>(0.0)) {
            color = shade(color, position, unit3(normal), select(1.0, m, LIT != 0u));
        } else if LIT != 0u {
            color = shadowed(color, m);
        }
    }
    if ENCODED != 0u {
        color = encode(color);
    }
    return color;
}
