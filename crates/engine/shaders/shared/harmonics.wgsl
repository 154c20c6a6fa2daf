// Color of a Gaussian from a direction: real spherical harmonics, with the signs of Kerbl et al. 2023 (those of Sloan
// 2008). `harmonics` holds for each splat 3 numbers for each coefficient; that of degree 0 is the color ½ + Y0 f_dc
// itself.

// 0 to 4.
override DEGREE: u32 = 0u;

fn coefficient(first: u32, k: u32) -> vec3<f32> {
    let at = first + 3u * k;
    return vec3<f32>(harmonics[at], harmonics[at + 1u], harmonics[at + 2u]);
}

// Degrees 1 and 2; d is the unit vector from the eye to the center in world axes.
fn low_degrees(first: u32, d: vec3<f32>) -> vec3<f32> {
    var sum = vec3<f32>(0.0);
    if DEGREE >= 1u {
        sum += -0.4886025119029199 * d.y * coefficient(first, 1u);
        sum += 0.4886025119029199 * d.z * coefficient(first, 2u);
        sum += -0.4886025119029199 * d.x * coefficient(first, 3u);
    }
    if DEGREE >= 2u {
        let s = d * d;
        sum += 1.0925484305920792 * (d.x * d.y) * coefficient(first, 4u);
        sum += -1.0925484305920792 * (d.y * d.z) * coefficient(first, 5u);
        sum += 0.31539156525252005 * (2.0 * s.z - s.x - s.y) * coefficient(first, 6u);
        sum += -1.0925484305920792 * (d.x * d.z) * coefficient(first, 7u);
        sum += 0.5462742152960396 * (s.x - s.y) * coefficient(first, 8u);
    }
    return sum;
}

fn third_degree(first: u32, d: vec3<f32>) -> vec3<f32> {
    let s = d * d;
    var sum = -0.5900435899266435 * d.y * (3.0 * s.x - s.y) * coefficient(first, 9u);
    sum += 2.890611442640554 * (d.x * d.y * d.z) * coefficient(first, 10u);
    sum += -0.4570457994644658 * d.y * (4.0 * s.z - s.x - s.y) * coefficient(first, 11u);
    sum += 0.3731763325901154 * d.z * (2.0 * s.z - 3.0 * s.x - 3.0 * s.y) * coefficient(first, 12u);
    sum += -0.4570457994644658 * d.x * (4.0 * s.z - s.x - s.y) * coefficient(first, 13u);
    sum += 1.445305721320277 * d.z * (s.x - s.y) * coefficient(first, 14u);
    sum += -0.5900435899266435 * d.x * (s.x - 3.0 * s.y) * coefficient(first, 15u);
    return sum;
}

fn fourth_degree(first: u32, d: vec3<f32>) -> vec3<f32> {
    let s = d * d;
    var sum = 2.5033429417967046 * (d.x * d.y) * (s.x - s.y) * coefficient(first, 16u);
    sum += -1.7701307697799304 * (d.y * d.z) * (3.0 * s.x - s.y) * coefficient(first, 17u);
    sum += 0.9461746957575601 * (d.x * d.y) * (7.0 * s.z - 1.0) * coefficient(first, 18u);
    sum += -0.6690465435572892 * (d.y * d.z) * (7.0 * s.z - 3.0) * coefficient(first, 19u);
    sum += 0.10578554691520431 * (s.z * (35.0 * s.z - 30.0) + 3.0) * coefficient(first, 20u);
    sum += -0.6690465435572892 * (d.x * d.z) * (7.0 * s.z - 3.0) * coefficient(first, 21u);
    sum += 0.47308734787878004 * (s.x - s.y) * (7.0 * s.z - 1.0) * coefficient(first, 22u);
    sum += -1.7701307697799304 * (d.x * d.z) * (s.x - 3.0 * s.y) * coefficient(first, 23u);
    sum += 0.6258357354491761 * (s.x * (s.x - 3.0 * s.y) - s.y * (3.0 * s.x - s.y)) * coefficient(first, 24u);
    return sum;
}

// Value of splat i from the direction d, not clamped above: a display value or linear, as its colors are.
fn harmonic_color(i: u32, d: vec3<f32>) -> vec3<f32> {
    let first = 3u * i * (DEGREE + 1u) * (DEGREE + 1u);
    var color = coefficient(first, 0u) + low_degrees(first, d);
    if DEGREE >= 3u {
        color += third_degree(first, d);
    }
    if DEGREE >= 4u {
        color += fourth_degree(first, d);
    }
    return max(color, vec3<f32>(0.0));
}
