//! Concentric shells and discs.

use pellucid_reference::soft::{Behind, express};
use pellucid_scene::{Method, Shells, Soft};

use super::soft_spheres::{colors, lambda, middle, opacity, pixel, scene, spheres};
use super::*;

fn shells(n: u32, strength: f32) -> Method {
    Method::SoftConcentric(Soft { shells: Shells::Fixed(n), ..lambda(strength) })
}

#[test]
fn the_central_chord_is_the_same_for_every_number_of_shells() {
    let one = spheres(&[(-9.0 * DVec3::Z, 3.0, Vec3::X)]);
    for n in [1, 2, 3, 8, 64] {
        let found = middle(&one, shells(n, 0.25));
        assert_close(found.alpha, opacity(1.5), ROUNDING);
        assert_eq!((found.depth, found.count), (6.0, 1));
    }
}

#[test]
fn two_shells_off_the_center() {
    // r = 5 and 2.5, d = 1.5: half chords √22.75 and 2, μ′ = 1/2·(1 − 0.3) and 1·(1 − 0.6).
    let one = spheres(&[(DVec3::new(1.5, 0.0, -9.0), 5.0, Vec3::X)]);
    let depth = 0.35 * 2.0 * 22.75f64.sqrt() + 0.4 * 4.0;
    assert_close(middle(&one, shells(2, 0.25)).alpha, opacity(0.25 * depth), ROUNDING);
    // Only to the center: half.
    let behind = Behind { color: DVec3::ZERO, alpha: 1.0, depth: 9.0 };
    let half = pixel(&orthographic(), &one, shells(2, 0.25), [4, 4], behind);
    assert_close(half.color.x, opacity(0.125 * depth), ROUNDING);
    // From the outer shell's rim to the inner one's.
    let behind = Behind { depth: 7.0, ..behind };
    let rim = pixel(&orthographic(), &one, shells(2, 0.25), [4, 4], behind);
    assert_close(rim.color.x, opacity(0.25 * 0.35 * (22.75f64.sqrt() - 2.0)), ROUNDING);
}

/// Shells of constant density (Eq. 13 alone).
fn constant(n: u32, strength: f32) -> Method {
    Method::SoftConcentric(Soft { shells: Shells::Fixed(n), equalize: false, ..lambda(strength) })
}

#[test]
fn two_shells_of_constant_density_off_the_center() {
    // r = 5 and 2.5, d = 1.5: half chords √22.75 and 2, μ = 1/2 and 1.
    let one = spheres(&[(DVec3::new(1.5, 0.0, -9.0), 5.0, Vec3::X)]);
    let depth = 0.5 * 2.0 * 22.75f64.sqrt() + 1.0 * 4.0;
    assert_close(middle(&one, constant(2, 0.25)).alpha, opacity(0.25 * depth), ROUNDING);
    // From the outer shell's rim to the inner one's.
    let behind = Behind { color: DVec3::ZERO, alpha: 1.0, depth: 7.0 };
    let rim = pixel(&orthographic(), &one, constant(2, 0.25), [4, 4], behind);
    assert_close(rim.color.x, opacity(0.25 * 0.5 * (22.75f64.sqrt() - 2.0)), ROUNDING);
    // Through the center both forms are the same.
    let one = spheres(&[(-9.0 * DVec3::Z, 3.0, Vec3::X)]);
    for n in [1, 3, 64] {
        assert_close(middle(&one, constant(n, 0.25)).alpha, opacity(1.5), ROUNDING);
    }
}

#[test]
fn many_shells_of_constant_density_come_to_an_integral() {
    // Σ (r/N)/rᵢ·2√(rᵢ² − d²) tends to ∫ 2√(ρ² − d²)/ρ dρ from d to r; with r = 1, d = 0.6 that is
    // 2(0.8 − 0.6·acos 0.6).
    let limit = 2.0 * (0.8 - 0.6 * 0.6f64.acos());
    let one = spheres(&[(DVec3::new(0.6, 0.0, -9.0), 1.0, Vec3::X)]);
    let error = |n: u32| -(1.0 - middle(&one, constant(n, 1.0)).alpha).ln() - limit;
    // A left sum: off by half of the integrand at the rim, 2·0.8, over N; and at d, where the integrand begins as
    // 2√(2/d)·√(ρ − d), by |ζ(−1/2)| = 0.208 of that factor over N^(3/2) at most.
    for n in [100, 1000] {
        assert_close(error(n) * f64::from(n), 0.8, 0.77 / f64::from(n).sqrt());
    }
}

/// Largest difference of A between a sphere of shells and one of falling density, of softness 0.5, over all rays.
fn farthest_from_base(n: u32, equalize: bool) -> f64 {
    let soft = Soft { shells: Shells::Fixed(n), equalize, ..Soft::default() };
    let apart = |ray: u32| {
        let one = spheres(&[(DVec3::new(f64::from(ray) / 2000.0, 0.0, -9.0), 1.0, Vec3::X)]);
        (middle(&one, Method::SoftConcentric(soft)).alpha - middle(&one, Method::SoftBase(soft)).alpha).abs()
    };
    (0..2000).map(apart).fold(0.0, f64::max)
}

#[test]
fn shells_are_as_far_from_falling_density_as_their_equations_say() {
    // Of r = 1 and softness 1/2: 1 − 2^(−Σ μᵢ hᵢ) from 1 − 2^(−2 I), with half chords hᵢ = √(rᵢ² − d²) and
    // I = (√(1 − d²) − d² asinh(√(1 − d²)/d))/2 of Eq. 7; the largest difference over d, worked out apart from this
    // program.
    let equations = [(1, 0.05285, 0.23841), (3, 0.18769, 0.06250), (25, 0.23799, 0.09357), (64, 0.24204, 0.09788)];
    for (n, equalized, constant) in equations {
        assert_close(farthest_from_base(n, true), equalized, 2e-5);
        assert_close(farthest_from_base(n, false), constant, 2e-5);
    }
}

#[test]
fn modulation_of_shells_of_constant_density() {
    let mut points = spheres(&[(DVec3::new(1.5, 0.0, -9.0), 5.0, Vec3::X)]);
    points.fields.fill(0.5);
    let settings = Soft { threshold: 0.25, modulation: Some(1.25), shells: Shells::Fixed(2), ..lambda(0.125) };
    // W = 1/4, d/r = 0.3; a₀ = 1 − exp(−2 λ r).
    let (peak, plain) = (opacity(1.25), opacity(0.125 * (22.75f64.sqrt() + 4.0)));
    let found = middle(&points, Method::SoftConcentric(Soft { equalize: false, ..settings })).alpha;
    assert_close(found, peak * 0.7 * 0.75 + plain * 0.25, ROUNDING);
}

#[test]
fn many_shells_come_to_an_integral() {
    // Σ (r/N)/rᵢ·(1 − d/rᵢ)·2√(rᵢ² − d²) tends to ∫ 2(1 − d/ρ)√(ρ² − d²)/ρ dρ from d to r; with r = 1, d = 0.6 that is
    // 2(0.8 − 0.6·acos 0.6) − 1.2(ln 3 − 0.8).
    let limit = 2.0 * (0.8 - 0.6 * 0.6f64.acos()) - 1.2 * (3f64.ln() - 0.8);
    let one = spheres(&[(DVec3::new(0.6, 0.0, -9.0), 1.0, Vec3::X)]);
    let error = |n: u32| -(1.0 - middle(&one, shells(n, 1.0)).alpha).ln() - limit;
    // A left sum: off by half of the integrand at the rim, 2·0.4·0.8, over N.
    for n in [100, 1000] {
        assert_close(error(n) * f64::from(n), 0.32, 3.2 / f64::from(n).sqrt() / 10.0);
    }
}

#[test]
fn shells_weigh_colors_by_themselves() {
    // Two coincident spheres of one and of two shells do not exist in one frame: one sphere inside another does. Red
    // has r = 4, 2; green r = 2, 1 around the same center, and the ray goes through at d = 0: all weights 1.
    let two = spheres(&[(-9.0 * DVec3::Z, 4.0, Vec3::X), (-9.0 * DVec3::Z, 2.0, Vec3::Y)]);
    let found = middle(&two, shells(2, 0.125));
    // Densities: red 1/2 from 4, 1 from 2; green 1/2 from 2, 1 from 1. Segments out to in: 2, 1, 2, 1, 2 long.
    let (outer, next, inner) = (0.125 * 0.5 * 2.0, 0.125 * 2.0, 0.125 * 3.0 * 2.0);
    let segments = [(outer, 1.0), (next, 2.0 / 3.0), (inner, 0.5), (next, 2.0 / 3.0), (outer, 1.0)];
    let (mut red, mut depth) = (0.0, 0.0f64);
    for (thick, share) in segments {
        red += share * (-depth).exp() * opacity(thick);
        depth += thick;
    }
    assert_close(found.color.x, red, ROUNDING);
    assert_close(found.alpha, opacity(depth), ROUNDING);
}

#[test]
fn adaptive_shells_follow_the_radius_in_pixels() {
    let soft = Soft { pixels_per_shell: 0.5, ..Soft::default() };
    let count = |camera: &Camera, radius, z: f64| {
        let points = spheres(&[(-z * DVec3::Z, radius, Vec3::X)]);
        scene(camera, &points, &colors(&points), Method::SoftConcentric(soft)).spheres()[0].shells
    };
    // One pixel per unit; and 4.5 at z = 1.
    let radii = [0.01, 0.5, 0.51, 1.75, 31.9, 40.0, 1e6];
    assert_eq!(radii.map(|r| count(&orthographic(), r, 9.0)), [1, 1, 2, 4, 64, 64, 64].map(Some));
    assert_eq!([1.0, 3.0, 9.0].map(|z| count(&perspective(), 1.1, z)), [10, 4, 2].map(Some));
}

#[test]
fn a_disc_falls_off_as_a_cosine() {
    let points = spheres(&[(-9.0 * DVec3::Z, 2.0, Vec3::X)]);
    let at = |x| pixel(&orthographic(), &points, Method::SoftExpress(lambda(0.75)), [x, 4], Behind::NOTHING);
    assert_eq!((at(4).alpha, at(4).depth, at(4).count), (0.75, 9.0, 1));
    assert_close(at(5).alpha, 0.375, ROUNDING);
    // The rim is covered and lets everything through.
    assert_eq!((at(6).alpha, at(6).depth, at(6).count), (0.0, f64::INFINITY, 1));
    assert_eq!(at(7).count, 0);
    // The pixel of a small disc's center is always covered, at ρ = 1.
    let small = spheres(&[(DVec3::new(0.3, 0.0, -9.0), 0.2, Vec3::X)]);
    let found = middle(&small, Method::SoftExpress(lambda(0.75)));
    assert_eq!((found.alpha, found.count), (0.0, 1));
}

#[test]
fn a_modulated_disc() {
    let mut points = spheres(&[(DVec3::new(1.0, 0.0, -9.0), 4.0, Vec3::X)]);
    points.fields.fill(0.5);
    let soft = Soft { threshold: 0.25, modulation: Some(1.25), ..lambda(0.75) };
    // ρ = 1/4, W = 1/4.
    let plain = 0.75 * (0.5f64.sqrt() + 1.0) / 2.0;
    let wanted = 0.75 * 0.75 * 0.75 + 0.25 * plain;
    assert_close(middle(&points, Method::SoftExpress(soft)).alpha, wanted, ROUNDING);
}

#[test]
fn discs_come_in_the_order_along_an_axis() {
    assert_eq!(express::axis(DVec3::new(0.1, -0.9, 0.3)), (1, -1.0));
    assert_eq!(express::axis(DVec3::new(-0.5, 0.5, 0.1)), (0, -1.0));
    assert_eq!(express::axis(DVec3::new(0.0, 0.5, 0.5)), (1, 1.0));
    let red_green = |z: [f64; 2]| {
        let points = spheres(&[(-z[0] * DVec3::Z, 2.0, Vec3::X), (-z[1] * DVec3::Z, 2.0, Vec3::Y)]);
        let found = middle(&points, Method::SoftExpress(lambda(0.5)));
        (found.color.x, found.color.y, found.depth)
    };
    assert_eq!(red_green([5.0, 6.0]), (0.5, 0.25, 5.0));
    assert_eq!(red_green([6.0, 5.0]), (0.25, 0.5, 5.0));
    // Against the axis the last of equal places comes first: one order is read both ways.
    assert_eq!(red_green([5.0, 5.0]), (0.25, 0.5, 5.0));
    // Looking 50° off that axis, another one decides: the disc farther along it comes last, though it is nearer.
    let camera = |degrees: f64| {
        let (sin, cos) = degrees.to_radians().sin_cos();
        let forward = DVec3::new(sin, 0.0, -cos);
        let projection = Projection::Orthographic { height: 9.0 };
        Camera::look_at(DVec3::ZERO, forward, DVec3::Y, projection, 0.5, 100.0).expect("a camera")
    };
    let points = spheres(&[(DVec3::new(5.0, 0.0, -5.0), 2.0, Vec3::X), (DVec3::new(5.1, 0.0, -4.8), 2.0, Vec3::Y)]);
    for (degrees, red_first) in [(40.0, false), (50.0, true)] {
        let pixel = pixel(&camera(degrees), &points, Method::SoftExpress(lambda(0.5)), [4, 4], Behind::NOTHING);
        assert_eq!(pixel.color.x > pixel.color.y, red_first, "{degrees}");
    }
}

#[test]
fn discs_behind_the_solid_are_not_drawn() {
    let points = spheres(&[(-5.0 * DVec3::Z, 2.0, Vec3::X), (-6.0 * DVec3::Z, 2.0, Vec3::Y)]);
    let behind = |depth| Behind { color: DVec3::Z, alpha: 1.0, depth };
    let at = |depth| pixel(&orthographic(), &points, Method::SoftExpress(lambda(0.5)), [4, 4], behind(depth));
    assert_eq!((at(5.5).color, at(5.5).count), (DVec3::new(0.5, 0.0, 0.5), 1));
    assert_eq!((at(5.0).color, at(5.0).depth), (DVec3::Z, 5.0));
    assert_eq!((at(7.0).color, at(7.0).alpha), (DVec3::new(0.5, 0.25, 0.25), 1.0));
}
