//! Density, its integral, and what settings mean.

use pellucid_reference::soft::density::{antiderivative, density_factor, median_radius, modulated_opacity, modulation};
use pellucid_reference::soft::{Chord, Ray, Strength};
use pellucid_scene::{Density, Method, Soft};

use super::*;

/// ∫ of r − √(x² + d²) by adaptive Simpson; its error is some 10⁻¹⁴ of the integral of the function's size.
fn quadrature(radius: f64, distance: f64, from: f64, to: f64) -> f64 {
    let f = |x: f64| {
        // (r² − d² − x²)/(r + √(x² + d²)) does not cancel.
        (radius * radius - distance * distance - x * x) / (radius + x.hypot(distance))
    };
    fn simpson(f: &impl Fn(f64) -> f64, a: f64, b: f64, whole: f64, limit: f64, depth: u32) -> f64 {
        let m = 0.5 * (a + b);
        let rule = |a: f64, b: f64| (b - a) / 6.0 * (f(a) + 4.0 * f(0.5 * (a + b)) + f(b));
        let (left, right) = (rule(a, m), rule(m, b));
        let error = left + right - whole;
        if depth == 0 || error.abs() <= 15.0 * limit {
            return left + right + error / 15.0;
        }
        simpson(f, a, m, left, 0.5 * limit, depth - 1) + simpson(f, m, b, right, 0.5 * limit, depth - 1)
    }
    simpson(&f, from, to, f64::INFINITY, 1e-14 * radius * (to - from), 40)
}

#[test]
fn the_integral_is_that_of_quadrature() {
    for radius in [1e-3f64, 1.0, 1e3] {
        for rho in [0.0, 1e-200, 1e-9, 0.1, 0.6, 0.99, 1.0 - 1e-6] {
            let distance = rho * radius;
            let half = ((radius - distance) * (radius + distance)).sqrt();
            for (from, to) in [(-1.0, 1.0), (0.0, 1.0), (-0.3, 0.7), (0.5, 0.5 + 1e-5), (-1.0, -0.9999), (0.2, 0.2)] {
                let (from, to) = (from * half, to * half);
                let found = antiderivative(radius, distance, to) - antiderivative(radius, distance, from);
                assert_close(found, quadrature(radius, distance, from, to), 1e-14 * radius * radius);
            }
        }
    }
    // A whole chord at d = 0 has r².
    assert_eq!(2.0 * antiderivative(3.0, 0.0, 3.0), 9.0);
}

#[test]
fn a_ray_meets_a_sphere() {
    let chord = |camera: &Camera, pixel, center| Ray::new(View::new(camera, SIZE), pixel).meet(center, 2.0);
    // Pixel (5, 3) is a unit to the right and one up.
    let right_and_up = chord(&orthographic(), [5, 3], DVec3::new(1.0, -0.2, 7.0)).expect("1.2 away");
    assert_close(right_and_up.distance, 1.2, ROUNDING);
    assert_close(right_and_up.half, 1.6, ROUNDING);
    assert_eq!(right_and_up.middle, 7.0);
    // 4.5 units of the image plane at z = 1 are 45°: pixel (8, 4) has the slope 4/4.5.
    let through = DVec3::new(4.0 / 4.5, 0.0, 1.0);
    let ray = Ray::new(View::new(&perspective(), SIZE), [8, 4]);
    assert_close(ray.stretch, through.length(), ROUNDING);
    let Chord { distance, middle, half } = ray.meet(3.0 * through, 2.0).expect("through the center");
    assert_close(distance, 0.0, 1e-9);
    assert_close(middle, 3.0 * through.length(), ROUNDING);
    assert_close(half, 2.0, ROUNDING);
    // d < r, so that a touching ray misses, and a point of no size is never met.
    assert_eq!(chord(&orthographic(), [4, 4], DVec3::new(2.0, 0.0, 5.0)), None);
    assert_eq!(Ray::new(View::new(&orthographic(), SIZE), [4, 4]).meet(5.0 * DVec3::Z, 0.0), None);
}

fn with_density(density: Density) -> Soft {
    Soft { density, ..Soft::default() }
}

#[test]
fn softness_and_lambda_of_a_median_sphere() {
    let of =
        |model: fn(Soft) -> Method, density| Strength::new(&model(with_density(density)), &with_density(density), 3.0);
    // 1 − exp(−λ·9) = 0.75.
    assert_close(of(Method::SoftBase, Density::Softness(0.75)).lambda, 4f64.ln() / 9.0, ROUNDING);
    assert_close(of(Method::SoftConcentric, Density::Softness(0.75)).lambda, 4f64.ln() / 6.0, ROUNDING);
    assert_eq!(of(Method::SoftExpress, Density::Softness(0.75)), Strength { lambda: 0.75, peak: 0.75 });
    assert_close(of(Method::SoftBase, Density::Lambda(0.5)).peak, 1.0 - (-4.5f64).exp(), ROUNDING);
    assert_close(of(Method::SoftConcentric, Density::Lambda(0.5)).peak, 1.0 - (-3f64).exp(), ROUNDING);
    assert_eq!(of(Method::SoftExpress, Density::Lambda(7.0)), Strength { lambda: 1.0, peak: 1.0 });
    assert_eq!(of(Method::SoftBase, Density::Softness(1.0)).lambda * 9.0, 1e20);
}

#[test]
fn the_median_of_the_soft_points() {
    let points = |fields: &[f32]| Points {
        fields: fields.to_vec(),
        radii: (1..=fields.len()).map(|i| (i * i) as f32).collect(),
        ..Points::default()
    };
    assert_eq!(median_radius(&points(&[0.5, 0.6, 0.7, 0.4, 0.9]), 0.5), 9.0);
    assert_eq!(median_radius(&points(&[0.6, 0.0, 0.0, 0.7]), 0.5), 8.5);
    assert_eq!(median_radius(&points(&[0.5]), 0.5), 0.0);
}

#[test]
fn modulation_goes_from_the_threshold_to_its_limit() {
    let soft = Soft { threshold: 0.25, modulation: Some(0.75), ..Soft::default() };
    assert_eq!([0.25, 0.375, 0.5, 0.75, 1.0].map(|field| modulation(field, &soft)), [0.0, 0.25, 0.5, 1.0, 1.0]);
    assert_eq!(modulation(0.3, &Soft { modulation: None, ..soft }), 1.0);
}

#[test]
fn equation_22_holds_for_a_whole_chord() {
    for peak in [1e-9, 0.3, 0.999, 1.0] {
        for whole in [1e-12f64, 1e-3, 1.0, 30.0] {
            for rho in [1e-6, 0.3, 1.0 - 1e-9] {
                for w in [0.0, 1e-7, 0.5, 1.0] {
                    let factor = density_factor(whole, rho, w, peak);
                    let opacity = -(-whole).exp_m1();
                    let wanted = modulated_opacity(opacity, rho, w, peak);
                    let found = -(-whole * factor).exp_m1();
                    assert_close(found, wanted, 1e-13 * wanted);
                    if w == 1.0 {
                        assert_eq!(factor, 1.0);
                    }
                }
            }
        }
    }
    assert_close(modulated_opacity(0.5, 0.25, 0.0, 0.8), 0.6, ROUNDING);
    assert_close(modulated_opacity(0.5, 0.25, 0.4, 0.8), 0.36 + 0.2, ROUNDING);
    // Neither no density nor an opaque chord has a ratio of logarithms.
    assert_eq!(density_factor(0.0, 0.5, 0.5, 0.0), 1.0);
    assert_eq!(density_factor(1e20, 0.0, 0.5, 1.0), 1.0);
}
