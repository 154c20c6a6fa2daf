//! Colors of Gaussians.

use std::f64::consts::PI;

use pellucid_core::cloud::gaussians::ColorCoding;
use pellucid_reference::gaussians::harmonics::{basis, color};

use super::*;

/// Directions all over the sphere.
fn directions() -> impl Iterator<Item = DVec3> {
    (0..200).map(|i| {
        let (z, angle) = (2.0 * spread(i, 0) - 1.0, 2.0 * PI * spread(i, 1));
        let across = (1.0 - z * z).sqrt();
        DVec3::new(across * angle.cos(), across * angle.sin(), z)
    })
}

/// P_l^m(z) with (−1)^m, by the recurrence over l from P_m^m = (−1)^m (2m−1)!! (1−z²)^(m/2).
fn legendre(l: u32, m: u32, z: f64) -> f64 {
    let first: f64 = (1..=m).map(|i| -(2.0 * f64::from(i) - 1.0) * (1.0 - z * z).sqrt()).product();
    let (mut before, mut here) = (0.0, first);
    for n in m + 1..=l {
        let [n, m] = [n, m].map(f64::from);
        (before, here) = (here, ((2.0 * n - 1.0) * z * here - (n + m - 1.0) * before) / (n - m));
    }
    here
}

/// The real harmonic of degree l and order m, from its definition.
fn harmonic(l: u32, m: i32, direction: DVec3) -> f64 {
    let order = m.unsigned_abs();
    let factorial = |n: u32| (1..=n).map(f64::from).product::<f64>();
    let scale = f64::from(2 * l + 1) / (4.0 * PI) * factorial(l - order) / factorial(l + order);
    let turn = f64::from(order) * direction.y.atan2(direction.x);
    let around = match m {
        0 => 1.0,
        1.. => 2f64.sqrt() * turn.cos(),
        _ => 2f64.sqrt() * turn.sin(),
    };
    scale.sqrt() * legendre(l, order, direction.z) * around
}

#[test]
fn the_basis_is_that_of_its_definition() {
    for direction in directions() {
        let values = basis(direction, 4);
        assert_eq!(values.len(), 25);
        for l in 0..=4 {
            for m in -(l as i32)..=l as i32 {
                let place = (l * l) as usize + (m + l as i32) as usize;
                assert_close(values[place], harmonic(l, m, direction), ROUNDING);
            }
        }
    }
}

#[test]
fn constants_and_signs_are_those_of_the_original() {
    // cuda_rasterizer/auxiliary.h and forward.cu, at (x, y, z) of length 1.
    let DVec3 { x, y, z } = DVec3::new(0.48, -0.6, 0.64);
    let wanted = [
        0.28209479177387814,
        -0.4886025119029199 * y,
        0.4886025119029199 * z,
        -0.4886025119029199 * x,
        1.0925484305920792 * x * y,
        -1.0925484305920792 * y * z,
        0.31539156525252005 * (2.0 * z * z - x * x - y * y),
        -1.0925484305920792 * x * z,
        0.5462742152960396 * (x * x - y * y),
        -0.5900435899266435 * y * (3.0 * x * x - y * y),
        2.890611442640554 * x * y * z,
        -0.4570457994644658 * y * (4.0 * z * z - x * x - y * y),
        0.3731763325901154 * z * (2.0 * z * z - 3.0 * x * x - 3.0 * y * y),
        -0.4570457994644658 * x * (4.0 * z * z - x * x - y * y),
        1.445305721320277 * z * (x * x - y * y),
        -0.5900435899266435 * x * (x * x - 3.0 * y * y),
    ];
    let found = basis(DVec3::new(x, y, z), 3);
    assert_eq!(found.len(), wanted.len());
    found.iter().zip(wanted).for_each(|(found, wanted)| assert_close(*found, wanted, ROUNDING));
}

#[test]
fn the_basis_is_orthonormal() {
    // Five nodes of Gauss along z are exact to degree 9, 12 around it to order 11; products have 8.
    let (inner, outer) = (5.0 - 2.0 * (10.0f64 / 7.0).sqrt(), 5.0 + 2.0 * (10.0f64 / 7.0).sqrt());
    let weight = |sign: f64| (322.0 + sign * 13.0 * 70f64.sqrt()) / 900.0;
    let nodes = [
        (0.0, 128.0 / 225.0),
        (inner.sqrt() / 3.0, weight(1.0)),
        (-inner.sqrt() / 3.0, weight(1.0)),
        (outer.sqrt() / 3.0, weight(-1.0)),
        (-outer.sqrt() / 3.0, weight(-1.0)),
    ];
    let mut products = [[0.0; 25]; 25];
    for (z, weight) in nodes {
        for step in 0..12 {
            let (sin, cos) = (PI * f64::from(step) / 6.0).sin_cos();
            let across = f64::sqrt(1.0 - z * z);
            let values = basis(DVec3::new(across * cos, across * sin, z), 4);
            for (i, j) in (0..25).flat_map(|i| (0..25).map(move |j| (i, j))) {
                products[i][j] += weight * PI / 6.0 * values[i] * values[j];
            }
        }
    }
    for (i, j) in (0..25).flat_map(|i| (0..25).map(move |j| (i, j))) {
        assert_close(products[i][j], f64::from(u8::from(i == j)), ROUNDING);
    }
}

#[test]
fn squares_of_a_degree_have_a_sum_that_no_rotation_changes() {
    // Unsöld: (2l + 1) / 4π.
    for direction in directions() {
        let values = basis(direction, 4);
        for l in 0..=4usize {
            let sum: f64 = values[l * l..(l + 1) * (l + 1)].iter().map(|y| y * y).sum();
            assert_close(sum, (2 * l + 1) as f64 / (4.0 * PI), ROUNDING);
        }
    }
}

/// A splat at (3, 0, −4) with harmonics of degree 1.
fn colored(base: Vec3, harmonics: [Vec3; 3]) -> Points {
    let mut points = scene(&[ball(DVec3::new(3.0, 0.0, -4.0), 1.0, 0.5)]);
    let gaussians = points.gaussians.as_mut().unwrap();
    (gaussians.degree, gaussians.harmonics, gaussians.bases) = (1, harmonics.to_vec(), vec![base]);
    points
}

#[test]
fn linear_colors_are_encoded_after_their_harmonics() {
    let mut points = colored(Vec3::splat(0.5), [Vec3::X, Vec3::Y, Vec3::Z]);
    points.gaussians.as_mut().unwrap().coding = ColorCoding::Linear;
    let y1 = 0.4886025119029199;
    // The sum of the next test, which is linear here.
    let linear = DVec3::new(0.5, 0.5 - 0.8 * y1, 0.5 - 0.6 * y1);
    assert!(color(&points, 0, &perspective(), ColorSpace::Linear).unwrap().abs_diff_eq(linear, ROUNDING));
    let display = linear.map(|value| 1.055 * value.powf(1.0 / 2.4) - 0.055);
    assert!(color(&points, 0, &perspective(), ColorSpace::Encoded).unwrap().abs_diff_eq(display, ROUNDING));
}

#[test]
fn the_direction_goes_from_the_eye_to_the_center() {
    let points = colored(Vec3::splat(0.5), [Vec3::X, Vec3::Y, Vec3::Z]);
    let y1 = 0.4886025119029199;
    // (0.6, 0, −0.8): −y, z, −x; red, green, blue.
    let wanted = DVec3::new(0.5, 0.5 - 0.8 * y1, 0.5 - 0.6 * y1);
    assert!(color(&points, 0, &perspective(), ColorSpace::Encoded).unwrap().abs_diff_eq(wanted, ROUNDING));
    // Orthographic it is that of the view.
    let wanted = DVec3::new(0.5, 0.5 - y1, 0.5);
    assert!(color(&points, 0, &orthographic(), ColorSpace::Encoded).unwrap().abs_diff_eq(wanted, ROUNDING));
}

#[test]
fn colors_end_at_0_and_not_at_1() {
    // 2 − 0.8·0.4886·(0, 1, 6).
    let points = colored(Vec3::splat(2.0), [Vec3::ZERO, Vec3::new(0.0, 1.0, 6.0), Vec3::ZERO]);
    let encoded = color(&points, 0, &perspective(), ColorSpace::Encoded).unwrap();
    assert!(encoded.abs_diff_eq(DVec3::new(2.0, 2.0 - 0.8 * 0.4886025119029199, 0.0), ROUNDING), "{encoded}");
    // The curve of sRGB goes on above 1.
    let linear = color(&points, 0, &perspective(), ColorSpace::Linear).unwrap();
    assert_close(linear.x, (2.055f64 / 1.055).powf(2.4), ROUNDING);
    assert_eq!(linear.z, 0.0);
}

#[test]
fn lights_shade_discs_and_no_gaussians() {
    let mut points = colored(Vec3::new(0.25, 0.5, 0.75), [Vec3::ZERO; 3]);
    points.gaussians.as_mut().unwrap().append(Gaussians::none(1));
    points.positions.push(DVec3::new(0.0, 0.0, -4.0));
    points.colors = vec![Vec3::ONE; 2];
    points.normals = Some(vec![Vec3::Z; 2]);
    points.opacities.push(0.5);
    points.radii.push(1.0);
    let light = Light::Direction(DVec3::new(-1.0, 0.0, -1.0));
    let shading = Shading { model: ShadingModel::Lambert, ambient: 0.0, diffuse: 1.0, light, ..Shading::default() };
    let colors = shading::shade(&points, &perspective(), &shading, ColorSpace::Encoded);
    assert_eq!(colors[0], DVec3::new(0.25, 0.5, 0.75));
    // A disc has its linear color by cos 45°, encoded.
    assert_close(colors[1].x, 1.055 * 0.5f64.sqrt().powf(1.0 / 2.4) - 0.055, 1e-12);
    assert_eq!(color(&points, 1, &perspective(), ColorSpace::Linear), None);
}
