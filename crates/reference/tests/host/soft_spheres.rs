//! Soft spheres, one to three at a time, on the middle pixel or rays that are as easy.

use pellucid_reference::soft::{Behind, Model, Pixel, Scene};
use pellucid_scene::{Density, Method, Shells, Soft, SoftLayout};

use super::*;

/// Spheres by position, radius and color.
pub(super) fn spheres(all: &[(DVec3, f32, Vec3)]) -> Points {
    Points {
        positions: all.iter().map(|s| s.0).collect(),
        colors: all.iter().map(|s| s.2).collect(),
        opacities: vec![0.1; all.len()],
        radii: all.iter().map(|s| s.1).collect(),
        fields: vec![1.0; all.len()],
        ..Points::default()
    }
}

pub(super) fn scene<'a>(camera: &'a Camera, points: &'a Points, colors: &'a [DVec3], method: Method) -> Scene<'a> {
    let model = Model::new(method.as_soft().expect("a soft method"), points);
    Scene { view: View::new(camera, SIZE), points, colors, model }
}

pub(super) fn colors(points: &Points) -> Vec<DVec3> {
    points.colors.iter().map(|c| c.as_dvec3()).collect()
}

/// Pixel (x, y) before what is behind.
pub(super) fn pixel(camera: &Camera, points: &Points, method: Method, at: [usize; 2], behind: Behind) -> Pixel {
    scene(camera, points, &colors(points), method).render_at(&[at[1] * 9 + at[0]], |_| behind)[0]
}

/// The middle pixel of the orthographic camera, whose ray is the optical axis.
pub(super) fn middle(points: &Points, method: Method) -> Pixel {
    pixel(&orthographic(), points, method, [4, 4], Behind::NOTHING)
}

pub(super) fn lambda(lambda: f32) -> Soft {
    Soft { density: Density::Lambda(lambda), ..Soft::default() }
}

const RED: Vec3 = Vec3::X;
const GREEN: Vec3 = Vec3::Y;
/// 1 − exp(−depth).
pub(super) fn opacity(depth: f64) -> f64 {
    1.0 - (-depth).exp()
}

fn ahead(z: f64) -> DVec3 {
    -z * DVec3::Z
}

#[test]
fn the_central_chord_has_the_radius_squared() {
    let one = spheres(&[(ahead(5.0), 2.0, RED)]);
    let found = middle(&one, Method::SoftBase(lambda(0.25)));
    assert_close(found.alpha, opacity(1.0), ROUNDING);
    assert_close(found.color.x, found.alpha, ROUNDING);
    assert_eq!((found.color.y, found.depth, found.count), (0.0, 3.0, 1));
    // Softness is that opacity, whatever the radius.
    let soft = Soft { density: Density::Softness(0.75), ..Soft::default() };
    for radius in [0.25, 4.0] {
        let one = spheres(&[(ahead(50.0), radius, RED)]);
        assert_close(middle(&one, Method::SoftBase(soft)).alpha, 0.75, ROUNDING);
    }
}

#[test]
fn six_tenths_of_the_radius_off_the_center() {
    // d = 3, h = 4, asinh(4/3) = ln 3: 25·(0.8 − 0.36·ln 3).
    let one = spheres(&[(DVec3::new(3.0, 0.0, -9.0), 5.0, RED)]);
    let found = middle(&one, Method::SoftBase(lambda(0.125)));
    assert_close(found.alpha, opacity(3.125 * (0.8 - 0.36 * 3f64.ln())), ROUNDING);
    assert_close(found.depth, 5.0, ROUNDING);
}

#[test]
fn coincident_spheres_add_up() {
    for n in [2, 7] {
        let same = spheres(&vec![(ahead(5.0), 2.0, RED); n]);
        let found = middle(&same, Method::SoftBase(lambda(0.0625)));
        assert_close(found.alpha, opacity(0.25 * n as f64), ROUNDING);
        assert_eq!(found.count, n as u32);
    }
    let two = spheres(&[(ahead(5.0), 2.0, RED), (ahead(5.0), 2.0, GREEN)]);
    let found = middle(&two, Method::SoftBase(lambda(0.0625)));
    assert_close(found.color.x, 0.5 * opacity(0.5), ROUNDING);
    assert_close(found.color.y, 0.5 * opacity(0.5), ROUNDING);
}

#[test]
fn overlapping_spheres_share_the_segment_that_they_share() {
    // Both through their centers: half a sphere has 1/2, so segments of λ/2, λ, λ/2.
    let two = spheres(&[(ahead(5.0), 1.0, RED), (ahead(6.0), 1.0, GREEN)]);
    let found = middle(&two, Method::SoftBase(lambda(1.0)));
    let (t1, t2) = ((-0.5f64).exp(), (-1.5f64).exp());
    assert_close(found.color.x, opacity(0.5) + 0.5 * t1 * opacity(1.0), ROUNDING);
    assert_close(found.color.y, 0.5 * t1 * opacity(1.0) + t2 * opacity(0.5), ROUNDING);
    assert_close(found.alpha, opacity(2.0), ROUNDING);
    assert_close(found.depth, 4.0, ROUNDING);
}

#[test]
fn colors_weigh_by_distance_from_the_centers() {
    // d = 0 and d = 0.6 at the same depth: the green chord of half length 0.8 lies within the red one's.
    let two = spheres(&[(ahead(5.0), 1.0, RED), (DVec3::new(0.6, 0.0, -5.0), 1.0, GREEN)]);
    let found = middle(&two, Method::SoftBase(lambda(1.0)));
    // Red alone for 0.2 on either side: 0.2 − (1 − 0.64)/2. Then both; Eq. 12 has the weights 1 and 0.4.
    let rim = 0.2 - 0.18;
    let both = 1.0 - 2.0 * rim + 0.8 - 0.36 * 3f64.ln();
    let inner = (-rim).exp() * opacity(both);
    let last = (-rim - both).exp() * opacity(rim);
    assert_close(found.color.x, opacity(rim) + inner / 1.4 + last, 1e-7);
    assert_close(found.color.y, inner * 0.4 / 1.4, 1e-7);
    // 0.6 is rounded to float64 alone.
    assert_close(found.alpha, opacity(2.0 * rim + both), ROUNDING);
}

#[test]
fn a_solid_cuts_spheres() {
    let one = spheres(&[(ahead(5.0), 2.0, RED)]);
    let behind = |depth| Behind { color: DVec3::new(0.0, 0.5, 1.0), alpha: 1.0, depth };
    let at = |depth| pixel(&orthographic(), &one, Method::SoftBase(lambda(0.5)), [4, 4], behind(depth));
    let half = at(5.0);
    assert_close(half.color.x, opacity(1.0), ROUNDING);
    assert_close(half.color.y, 0.5 * (-1f64).exp(), ROUNDING);
    assert_close(half.alpha, 1.0, ROUNDING);
    assert_eq!((half.depth, half.count), (3.0, 1));
    // All of it before the solid, and all of it behind.
    assert_close(at(7.5).color.x, opacity(2.0), ROUNDING);
    let hidden = at(3.0);
    assert_eq!((hidden.color, hidden.alpha, hidden.depth, hidden.count), (behind(3.0).color, 1.0, 3.0, 0));
}

#[test]
fn a_solid_cuts_oblique_rays_at_its_depth_along_the_axis() {
    // The ray of pixel (8, 4) goes through the center, at z = 5 and s = 5/cos φ.
    let through = DVec3::new(4.0 / 4.5, 0.0, -1.0);
    let one = spheres(&[(5.0 * through, 2.0, RED)]);
    let at = |depth| {
        let behind = Behind { color: DVec3::ZERO, alpha: 1.0, depth };
        pixel(&perspective(), &one, Method::SoftBase(lambda(0.5)), [8, 4], behind)
    };
    assert_close(at(5.0).color.x, opacity(1.0), 1e-9);
    assert_close(at(100.0).color.x, opacity(2.0), 1e-9);
    assert_close(at(100.0).depth, 5.0 - 2.0 / through.length(), 1e-9);
}

#[test]
fn the_near_plane_cuts_what_the_camera_is_inside_of() {
    for camera in [orthographic(), perspective()] {
        // The center on the near plane is still drawn.
        let one = spheres(&[(ahead(0.5), 2.0, RED)]);
        let found = pixel(&camera, &one, Method::SoftBase(lambda(0.5)), [4, 4], Behind::NOTHING);
        assert_close(found.alpha, opacity(1.0), ROUNDING);
        assert_eq!((found.depth, found.count), (0.5, 1));
        let nearer = spheres(&[(ahead(0.49), 2.0, RED)]);
        assert_eq!(pixel(&camera, &nearer, Method::SoftBase(lambda(0.5)), [4, 4], Behind::NOTHING).count, 0);
        // far tests the center alone.
        let far = spheres(&[(ahead(99.0), 2.0, RED)]);
        let found = pixel(&camera, &far, Method::SoftBase(lambda(0.5)), [4, 4], Behind::NOTHING);
        assert_close(found.alpha, opacity(2.0), ROUNDING);
    }
}

#[test]
fn modulated_spheres_have_the_opacity_of_equation_22() {
    // W = 0.5, ρ = 0.6; Φ from 25·0.1·(0.8 − 0.36 ln 3) or, of one shell, 0.1·0.4·8.
    let soft = Soft { threshold: 0.25, modulation: Some(0.75), shells: Shells::Fixed(1), ..lambda(0.1) };
    let base = opacity(2.5 * (0.8 - 0.36 * 3f64.ln()));
    let concentric = opacity(0.1 * 0.4 * 8.0);
    for (method, whole, peak) in [
        (Method::SoftBase(soft), base, opacity(f64::from(0.1f32) * 25.0)),
        (Method::SoftConcentric(soft), concentric, opacity(f64::from(0.1f32) * 10.0)),
    ] {
        for n in [1, 3] {
            let mut points = spheres(&vec![(DVec3::new(3.0, 0.0, -9.0), 5.0, RED); n]);
            points.fields.fill(0.5);
            let wanted = 0.5 * peak * 0.4 + 0.5 * whole;
            // λ is 0.1 in float32.
            assert_close(middle(&points, method).alpha, 1.0 - (1.0 - wanted).powi(n as i32), 1e-8);
            points.fields.fill(0.75);
            assert_close(middle(&points, method).alpha, 1.0 - (1.0 - whole).powi(n as i32), 1e-8);
            points.fields.fill(0.25);
            assert_eq!(middle(&points, method).count, 0);
        }
    }
}

#[test]
fn without_density_there_is_nothing_but_the_list() {
    let one = spheres(&[(ahead(5.0), 2.0, RED)]);
    for method in [Method::SoftBase, Method::SoftConcentric, Method::SoftExpress] {
        let found = middle(&one, method(lambda(0.0)));
        assert_eq!((found.color, found.alpha, found.depth, found.count), (DVec3::ZERO, 0.0, f64::INFINITY, 1));
    }
}

#[test]
fn whole_images_are_their_pixels() {
    use rand::{RngExt, SeedableRng};
    let mut random = rand_pcg::Pcg64::seed_from_u64(7);
    let sphere = |_: usize| {
        let x = random.random_range(-4.0..4.0);
        let y = random.random_range(-4.0..4.0);
        let position = DVec3::new(x, y, -random.random_range(0.2..9.0));
        let color = Vec3::new(random.random(), random.random(), random.random());
        (position, random.random_range(0.0..1.5f32), color)
    };
    let mut points = spheres(&(0..200).map(sphere).collect::<Vec<_>>());
    for (i, field) in points.fields.iter_mut().enumerate() {
        *field = i as f32 / 200.0;
    }
    let colors = colors(&points);
    let all: Vec<usize> = (0..81).collect();
    let soft = Soft { modulation: Some(0.8), ..Soft::default() };
    for camera in [orthographic(), perspective()] {
        for method in [Method::SoftBase, Method::SoftConcentric, Method::SoftExpress] {
            let scene = scene(&camera, &points, &colors, method(soft));
            // Solids behind every other pixel.
            let behind = |pixel: usize| match pixel % 2 {
                0 => Behind::NOTHING,
                _ => Behind { color: DVec3::ONE, alpha: 1.0, depth: 4.0 },
            };
            let (picture, pixels) = (scene.render(behind), scene.render_at(&all, behind));
            for (i, pixel) in pixels.iter().enumerate() {
                assert_eq!(picture.rgba[i], pixel.color.extend(pixel.alpha).to_array());
                assert_eq!((picture.depth[i], picture.counts[i]), (pixel.depth, pixel.count));
            }
            assert!(picture.counts.iter().any(|count| *count >= 5));
        }
    }
}

#[test]
fn georeferenced_spheres_look_the_same() {
    let origin = DVec3::new(500_000.0, 4_500_000.0, 100.0);
    let here = perspective();
    let there = Camera { eye: here.eye + origin, ..here };
    // Multiples of 2⁻², so that nothing is rounded.
    let points = spheres(&[(DVec3::new(0.25, -0.5, -5.0), 2.25, RED), (DVec3::new(-0.5, 0.75, -4.25), 1.5, GREEN)]);
    let mut moved = points.clone();
    moved.positions.iter_mut().for_each(|p| *p += origin);
    for method in [Method::SoftBase, Method::SoftConcentric, Method::SoftExpress] {
        let [a, b] = [(&here, &points), (&there, &moved)].map(|(camera, points)| {
            scene(camera, points, &colors(points), method(Soft::default())).render(|_| Behind::NOTHING)
        });
        assert_eq!(a, b);
    }
}

#[test]
fn the_papers_layout_rounds_distance_and_color() {
    let soft = Soft { layout: SoftLayout::Paper, ..lambda(1.0) };
    // ρ = 0.5 becomes 128/255, and 0.3 of the color 77/255 (76.5 is no float32, and what it is lies above).
    let one = spheres(&[(DVec3::new(0.5, 0.0, -5.0), 1.0, Vec3::new(0.3, 1.5, 0.2))]);
    let found = middle(&one, Method::SoftBase(soft));
    // The chord at that distance ends a little before the sphere's own.
    let d = 128.0 / 255.0;
    let half = (1.0f64 - d * d).sqrt();
    let depth = 2.0 * half - half - d * d * (half / d).asinh();
    assert_close(found.alpha, opacity(depth), ROUNDING);
    assert_close(found.color.x / found.alpha, 77.0 / 255.0, ROUNDING);
    assert_close(found.color.y / found.alpha, 1.0, ROUNDING);
    // Through the center nothing is rounded but the color; at the rim nothing is left.
    let centered = spheres(&[(ahead(5.0), 1.0, RED)]);
    assert_close(middle(&centered, Method::SoftBase(soft)).alpha, opacity(1.0), ROUNDING);
    let rim = spheres(&[(DVec3::new(0.9985, 0.0, -5.0), 1.0, RED)]);
    let found = middle(&rim, Method::SoftBase(soft));
    assert_eq!((found.alpha, found.depth, found.count), (0.0, f64::INFINITY, 1));
}
