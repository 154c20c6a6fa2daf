//! `soft-base` and `soft-concentric`: spheres with known answers, hard radii, long lists, cuts of the image that may
//! not show.

use glam::{DVec3, Vec3};
use pellucid_core::camera::{Camera, Projection};
use pellucid_core::image::Image;
use pellucid_core::points::Points;
use pellucid_engine::methods::{Error, Facts, Frame, Rendered, Renderer};
use pellucid_gpu::Device;
use pellucid_reference::View;
use pellucid_reference::shading::shade;
use pellucid_reference::soft::{self, Behind, Model};
use pellucid_scene::prepare::order;
use pellucid_scene::{Density, LongLists, Method, Shells, Soft, SoftLayout, SoftMethod};
use pellucid_testing::*;
use rand::RngExt;

/// A soft point if its field is above 0.5.
#[derive(Debug, Clone, Copy)]
struct S {
    position: DVec3,
    radius: f32,
    color: Vec3,
    field: f32,
}

fn sphere(position: DVec3, radius: f32) -> S {
    S { position, radius, color: Vec3::new(0.2, 0.6, 1.0), field: 1.0 }
}

fn cloud(spheres: &[S]) -> Points {
    order::canonical(Points {
        positions: spheres.iter().map(|s| s.position).collect(),
        colors: spheres.iter().map(|s| s.color).collect(),
        opacities: vec![1.0; spheres.len()],
        radii: spheres.iter().map(|s| s.radius).collect(),
        fields: spheres.iter().map(|s| s.field).collect(),
        ..Points::default()
    })
}

fn soup_of(seed: u64, count: usize, radius: std::ops::Range<f32>) -> Vec<S> {
    let mut r = random(seed + 1000);
    let each = soup(seed, count, radius, 0.1..0.9, false).into_iter();
    each.map(|p| S { position: p.position, radius: p.radius, color: p.color, field: r.random_range(0.51..1.0) })
        .collect()
}

fn lambda(lambda: f32) -> Soft {
    Soft { density: Density::Lambda(lambda), ..Soft::default() }
}

fn softness(softness: f32) -> Soft {
    Soft { density: Density::Softness(softness), ..Soft::default() }
}

/// Base and several kinds of concentric spheres.
fn methods(settings: Soft) -> Vec<Method> {
    let shells = [Shells::Fixed(1), Shells::Fixed(7), Shells::Adaptive];
    let concentric = shells.map(|shells| Method::SoftConcentric(Soft { shells, pixels_per_shell: 1.3, ..settings }));
    let constant = Soft { shells: Shells::Fixed(2), equalize: false, ..settings };
    [vec![Method::SoftBase(settings)], concentric.to_vec(), vec![Method::SoftConcentric(constant)]].concat()
}

fn rendered(device: &Device, spheres: &[S], frame: &Frame) -> Result<Rendered, Error> {
    let mut renderer = Renderer::new(device)?;
    let mut cloud = renderer.upload(&cloud(spheres))?;
    renderer.render(&mut cloud, frame)
}

/// One pixel of one world unit, looked at orthographically from depth 0.
fn one_pixel(device: &Device, spheres: &[S], method: Method) -> Image {
    rendered(device, spheres, &frame(pixel_camera([1, 1]), [1, 1], method)).expect("renders").image
}

/// Returns the position at a distance from the ray of [`one_pixel`].
fn beside(distance: f64, depth: f64) -> DVec3 {
    at_pixel(0.5 + distance, 0.5, depth)
}

/// Integral of r - sqrt(x² + d²) from a to b by Simpson's rule.
fn integral(r: f64, d: f64, a: f64, b: f64) -> f64 {
    let (n, h) = (20_000, (b - a) / 20_000.0);
    let rho = |i: usize| r - (a + i as f64 * h).hypot(d);
    let weight = |i: usize| if i == 0 || i == n { 1.0 } else { [2.0, 4.0][i % 2] };
    (0..=n).map(|i| weight(i) * rho(i)).sum::<f64>() * h / 3.0
}

fn assert_close(found: f32, wanted: f64, relative: f64) {
    assert!((f64::from(found) - wanted).abs() <= relative * wanted.abs(), "{found} {wanted}");
}

#[test]
fn a_sphere_has_the_opacity_of_its_integral() {
    with_device(|device| {
        for strength in [1e-6f32, 1e-2, 0.3, 5.0] {
            for distance in [0.0, 1e-4, 0.3, 1.0, 1.9, 1.99] {
                let image =
                    one_pixel(device, &[sphere(beside(distance, 10.0), 2.0)], Method::SoftBase(lambda(strength)));
                let half = ((2.0 - distance) * (2.0 + distance)).sqrt();
                let wanted = -(-f64::from(strength) * integral(2.0, distance, -half, half)).exp_m1();
                // Near the rim the position in float32 decides.
                let bound = 2e-6 + 1e-6 / (2.0 - distance);
                assert_close(image.rgba[0][3], wanted, bound);
                assert_close(image.rgba[0][0], 0.2 * wanted, bound);
                assert_close(image.rgba[0][2], wanted, bound);
                assert_close(image.depth[0], 10.0 - half, 1e-6);
                assert_eq!(image.fragments.as_deref(), Some(&[1][..]));
            }
        }
    });
}

#[test]
fn softness_is_the_opacity_through_the_center_of_the_median_sphere() {
    with_device(|device| {
        let of = |method, radius: f32| {
            // The others don't meet the ray: 3 is the median radius.
            let others = [1.0, 2.0, 3.0, 4.0, 5.0].map(|r| sphere(beside(40.0, 30.0), r));
            one_pixel(device, &[&others[..], &[sphere(beside(0.0, 10.0), radius)]].concat(), method).rgba[0][3]
        };
        for peak in [0.1f32, 0.5, 0.99] {
            assert_close(of(Method::SoftBase(softness(peak)), 3.0), peak.into(), 2e-6);
            // Depth grows with the squared radius; the median is that of 1, 1.5, 2, 3, 4 and 5.
            let wanted = 1.0 - (1.0 - f64::from(peak)).powf(0.36);
            assert_close(of(Method::SoftBase(softness(peak)), 1.5), wanted, 2e-6);
            // As many shells as there may be, the total is the same.
            for shells in [1, 2, 4, 16, 64] {
                let settings = Soft { shells: Shells::Fixed(shells), ..softness(peak) };
                assert_close(of(Method::SoftConcentric(settings), 3.0), peak.into(), 1e-5);
            }
        }
        assert_eq!(of(Method::SoftBase(softness(1.0)), 3.0), 1.0);
        assert_eq!(of(Method::SoftBase(softness(0.0)), 3.0), 0.0);
    });
}

#[test]
fn two_shells_by_hand() {
    with_device(|device| {
        // r = 2, d = 0.5, N = 2: radii 2 and 1, mu' = (1 - 0.25) / 2 and (2 / 2) (1 - 0.5).
        let settings = Soft { shells: Shells::Fixed(2), ..lambda(0.4) };
        let image = one_pixel(device, &[sphere(beside(0.5, 10.0), 2.0)], Method::SoftConcentric(settings));
        let depth = 0.4 * (0.375 * 2.0 * (4.0f64 - 0.25).sqrt() + 0.5 * 2.0 * 0.75f64.sqrt());
        assert_close(image.rgba[0][3], -(-depth).exp_m1(), 2e-6);
        assert_close(image.depth[0], 10.0 - (4.0f64 - 0.25).sqrt(), 1e-6);
        assert_eq!(image.fragments.as_deref(), Some(&[1][..]));
    });
}

#[test]
fn two_shells_of_constant_density_by_hand() {
    with_device(|device| {
        // r = 2, d = 0.5, N = 2: radii 2 and 1, mu = 1/2 and 1.
        let settings = Soft { shells: Shells::Fixed(2), equalize: false, ..lambda(0.4) };
        let image = one_pixel(device, &[sphere(beside(0.5, 10.0), 2.0)], Method::SoftConcentric(settings));
        let depth = 0.4 * (0.5 * 2.0 * 3.75f64.sqrt() + 2.0 * 0.75f64.sqrt());
        assert_close(image.rgba[0][3], -(-depth).exp_m1(), 2e-6);
        assert_close(image.depth[0], 10.0 - 3.75f64.sqrt(), 1e-6);
        assert_eq!(image.fragments.as_deref(), Some(&[1][..]));
        // Eq. 22 between threshold and modulation: F = 0.75, W = 1/2, d / r = 1/4; a0 = 1 - exp(-2 λ r).
        let modulated = Soft { modulation: Some(1.0), ..settings };
        let faint = S { field: 0.75, ..sphere(beside(0.5, 10.0), 2.0) };
        let image = one_pixel(device, &[faint], Method::SoftConcentric(modulated));
        let wanted = 0.5 * 0.75 * -(-1.6f64).exp_m1() + 0.5 * -(-depth).exp_m1();
        assert_close(image.rgba[0][3], wanted, 2e-6);
        // r = 5, d = 1.5: half chords √22.75 and 2.
        let settings = Soft { density: Density::Lambda(0.1), ..settings };
        let image = one_pixel(device, &[sphere(beside(1.5, 10.0), 5.0)], Method::SoftConcentric(settings));
        assert_close(image.rgba[0][3], -(-0.1 * (22.75f64.sqrt() + 4.0)).exp_m1(), 2e-6);
    });
}

#[test]
fn colors_mix_by_distance_where_spheres_intersect() {
    with_device(|device| {
        // Both chords are the same, so that there is one segment; weights 1 - d / r of 0.75 and 0.125.
        let (r, d) = ([2.0f64, 4.0], [0.5, 3.5]);
        let red = S { color: Vec3::X, ..sphere(beside(d[0], 10.0), r[0] as f32) };
        let blue = S { color: Vec3::Z, ..sphere(beside(d[1], 10.0), r[1] as f32) };
        let pixel = one_pixel(device, &[red, blue], Method::SoftBase(lambda(0.1))).rgba[0];
        let weights = [1.0 - d[0] / r[0], 1.0 - d[1] / r[1]];
        assert_close(pixel[0] / pixel[3], weights[0] / (weights[0] + weights[1]), 1e-5);
        assert_close(pixel[2] / pixel[3], weights[1] / (weights[0] + weights[1]), 1e-5);
    });
}

#[test]
fn what_lies_before_near_is_cut_off() {
    with_device(|device| {
        // near = 0.5 through the middle: half of the sphere; and spheres that end there or begin behind.
        let camera = pixel_camera([1, 1]);
        let of = |depth: f64, near: f64| {
            let frame = frame(Camera { near, ..camera }, [1, 1], Method::SoftBase(lambda(0.2)));
            rendered(device, &[sphere(beside(0.0, depth), 2.0)], &frame).expect("renders").image
        };
        let image = of(10.0, 10.0);
        assert_close(image.rgba[0][3], -(-0.2f64 * 2.0).exp_m1(), 2e-6);
        assert_eq!(image.depth[0], 10.0);
        let image = of(10.0, 9.0);
        assert_close(image.rgba[0][3], -(-0.2 * integral(2.0, 0.0, -1.0, 2.0)).exp_m1(), 1e-5);
        // The center decides whether a sphere is drawn at all.
        assert_eq!(of(10.0, 10.1).rgba[0], [0.0; 4]);
    });
}

#[test]
fn solid_points_cut_what_lies_behind_them() {
    with_device(|device| {
        let wall = S { color: Vec3::new(1.0, 0.5, 0.0), field: 0.5, ..sphere(beside(0.0, 10.0), 3.0) };
        let half = -(-0.2f64 * 2.0).exp_m1();
        let one = |soft: &[S]| one_pixel(device, &[&[wall], soft].concat(), Method::SoftBase(lambda(0.2)));
        // Half of a sphere before it, all of one behind it.
        for spheres in
            [vec![sphere(beside(0.0, 10.0), 2.0)], [10.0, 15.0].map(|z| sphere(beside(0.0, z), 2.0)).to_vec()]
        {
            let image = one(&spheres);
            assert_eq!(image.fragments.as_deref(), Some(&[1][..]));
            assert_close(image.rgba[0][0], 0.2 * half + (1.0 - half), 3e-6);
            assert_close(image.rgba[0][2], half, 3e-6);
            assert_close(image.rgba[0][3], 1.0, 1e-6);
            assert_eq!(image.depth[0], 8.0);
        }
        let image = one(&[sphere(beside(0.0, 12.5), 2.0)]);
        assert_eq!((image.rgba[0], image.depth[0]), ([1.0, 0.5, 0.0, 1.0], 10.0));
        assert_eq!(image.fragments.as_deref(), Some(&[0][..]));
        // Shells that lie behind it have no events, and what is before it stays as it is.
        let settings = Soft { shells: Shells::Fixed(4), ..lambda(0.3) };
        let image = one_pixel(device, &[wall, sphere(beside(0.0, 10.8), 2.0)], Method::SoftConcentric(settings));
        // Radii 2, 1.5, 1, of which the last reaches 0.2 before the wall; d = 0, so that mu' = 2 / (4 r).
        let depth = 0.3f64 * (1.2 * 0.25 + 0.7 / 3.0 + 0.2 * 0.5);
        assert_close(image.rgba[0][2], -(-depth).exp_m1(), 1e-5);
        assert_close(image.depth[0], 8.8, 1e-6);
    });
}

#[test]
fn there_is_no_pixel_that_is_always_covered() {
    with_device(|device| {
        let small = [sphere(at_pixel(0.9, 0.9, 5.0), 0.3), sphere(at_pixel(1.5, 0.5, 5.0), 0.01)];
        for method in methods(softness(0.5)) {
            let image = rendered(device, &small, &frame(pixel_camera([2, 2]), [2, 2], method)).expect("renders").image;
            assert_eq!(image.fragments.as_deref(), Some(&[0, 1, 0, 0][..]), "{method:?}");
            assert!(image.rgba[1][3] > 0.0 && image.rgba[0] == [0.0; 4] && image.depth[0].is_infinite());
        }
    });
}

#[test]
fn any_radius_gives_numbers() {
    with_device(|device| {
        let size = [12, 8];
        let wide = Projection::Perspective { fov_y: 170f64.to_radians() };
        let towards = Camera::look_at(DVec3::new(0.0, 0.1, 2.0), DVec3::ZERO, DVec3::Y, wide, 1e-4, 100.0);
        let mut renderer = Renderer::new(device).expect("a renderer");
        for (i, camera) in [perspective(), orthographic(), towards.expect("a camera")].into_iter().enumerate() {
            for (j, radius) in [0.0, 1e-45, 1e-20, 1e3, 1e15, f32::MAX].into_iter().enumerate() {
                let mut spheres = soup_of(3, 40, 0.1..0.5);
                for sphere in &mut spheres[..20] {
                    sphere.radius = radius;
                }
                let mut cloud = renderer.upload(&cloud(&spheres)).expect("fits");
                let settings = [
                    (Density::Softness(1.0), None),
                    (Density::Softness(1.0), Some(0.9)),
                    (Density::Lambda(1e-30), None),
                    (Density::Lambda(1e30), Some(0.9)),
                ];
                for (k, (density, modulation)) in settings.into_iter().enumerate() {
                    let methods = methods(Soft { density, modulation, ..Soft::default() }).into_iter();
                    // By turns: every pair of camera, radius, settings and method.
                    for method in methods.skip((2 * (i + j + k)) % 3).step_by(3) {
                        let frame = frame(camera, size, method);
                        let image = renderer.render(&mut cloud, &frame).expect("renders").image;
                        let sane = |p: &[f32; 4]| p.iter().all(|v| v.is_finite() && *v >= 0.0 && *v <= 1.0 + 1e-4);
                        assert!(image.rgba.iter().all(sane), "{radius:e} {method:?}");
                        assert!(image.depth.iter().all(|z| *z > 0.0), "{radius:e} {method:?}");
                    }
                }
            }
        }
    });
}

/// n spheres at one place are n times as dense, whichever kernel blends them.
#[test]
fn coincident_spheres_add_up_at_any_length() {
    with_device(|device| {
        // Lists of 256, 258, 512, 514 events, and of more than a dispatch over segments takes.
        for n in [1, 2, 3, 4, 5, 8, 9, 17, 33, 64, 65, 127, 128, 129, 256, 257, 2000, 25_000] {
            let spheres = vec![sphere(beside(0.7, 10.0), 2.0); n];
            let one = 2.0 / n as f64;
            let half = (4.0f64 - 0.49).sqrt();
            let base = Method::SoftBase(lambda((one / integral(2.0, 0.7, -half, half)) as f32));
            assert_close(one_pixel(device, &spheres, base).rgba[0][3], -(-2.0f64).exp_m1(), 1e-5);
            let shells = |n: u32| f64::from(n);
            for count in [1, 3] {
                let mu = |i: u32| {
                    let radius = 2.0 - 2.0 * f64::from(i) / shells(count);
                    2.0 / (shells(count) * radius)
                        * (1.0 - 0.7 / radius).max(0.0)
                        * 2.0
                        * (radius * radius - 0.49).max(0.0).sqrt()
                };
                let whole: f64 = (0..count).map(mu).sum();
                let settings = Soft { shells: Shells::Fixed(count), ..lambda((one / whole) as f32) };
                let image = one_pixel(device, &spheres, Method::SoftConcentric(settings));
                assert_close(image.rgba[0][3], -(-2.0f64).exp_m1(), 1e-5);
                assert_eq!(image.fragments.as_deref(), Some(&[n as u32][..]));
            }
        }
    });
}

/// A column of spheres of which each meets a few others: as many as fill long lists, and the same ones in shorter
/// columns.
#[test]
fn long_lists_are_blended_as_short_ones() {
    with_device(|device| {
        let column = |from: usize, to: usize| -> Vec<S> {
            let mut r = random(5);
            let all: Vec<S> = (0..600)
                .map(|i| S {
                    color: Vec3::new(r.random(), r.random(), r.random()),
                    // Groups of 100 stay apart.
                    ..sphere(beside(r.random_range(0.0..0.9), 10.0 + 0.5 * i as f64 + 5.0 * (i / 100) as f64), 1.0)
                })
                .collect();
            all[from..to].to_vec()
        };
        for method in methods(lambda(0.01)) {
            let long = one_pixel(device, &column(0, 600), method).rgba[0];
            let mut front = [0f64; 4];
            for group in 0..6 {
                let part = one_pixel(device, &column(100 * group, 100 * (group + 1)), method).rgba[0];
                let transmittance = 1.0 - front[3];
                front.iter_mut().zip(part).for_each(|(sum, c)| *sum += transmittance * f64::from(c));
            }
            for (found, wanted) in long.iter().zip(front) {
                assert_close(*found, wanted, 1e-5);
            }
        }
    });
}

fn bytes(rendered: &Rendered) -> (Vec<u32>, Option<Vec<u32>>) {
    (bits(&rendered.image), rendered.image.fragments.clone())
}

#[test]
fn cuts_into_windows_and_bands_do_not_show() {
    with_device(|device| {
        let spheres = soup_of(7, 560, 0.02..0.9);
        for (i, modulation) in [None, Some(0.8)].into_iter().enumerate() {
            for (j, method) in methods(Soft { modulation, ..Soft::default() }).into_iter().enumerate() {
                // Solid points among them.
                let solid = soup_of(8, 60, 0.02..0.3).into_iter().map(|s| S { field: 0.1, ..s }).collect();
                let spheres = [spheres.clone(), solid].concat();
                let frame = frame(perspective(), [61, 40], method);
                let whole = rendered(device, &spheres, &frame).expect("renders");
                let most = whole.facts.max_events;
                assert!(most > 256, "{most}: there are long lists");
                // By turns: every pair of modulation, method and budget.
                for budget in [60_000, 240_000, 1_600_000].into_iter().skip((i + j) % 2).step_by(2) {
                    let cut = rendered(device, &spheres, &Frame { memory_budget: Some(budget), ..frame });
                    let cut = match cut {
                        Err(Error::PixelOverBudget { .. }) if budget < 240_000 => continue,
                        cut => cut.expect("renders"),
                    };
                    assert!(cut.facts.windows > 1 || cut.facts.bands > 1 || budget > 240_000, "{:?}", cut.facts);
                    assert!(bytes(&cut) == bytes(&whole), "{method:?} {budget}");
                }
            }
        }
    });
}

/// A method with its long lists sorted in place.
fn in_place(method: Method) -> Method {
    let change = |soft: &mut Soft| soft.long_lists = LongLists::InPlace;
    method.as_soft().expect("a soft method").changed(change).into()
}

#[test]
fn long_lists_sorted_in_place_give_the_bytes_of_the_merge() {
    with_device(|device| {
        // Lists of a few events to many runs of them; coincident spheres have events at equal depths.
        let twins = soup_of(21, 450, 0.3..0.9).into_iter().flat_map(|s| [s, s]).collect::<Vec<_>>();
        let solid: Vec<S> = soup_of(8, 60, 0.02..0.3).into_iter().map(|s| S { field: 0.1, ..s }).collect();
        let clouds = [twins, [soup_of(7, 900, 0.3..0.9), solid].concat()];
        let packed = Method::SoftBase(Soft { layout: SoftLayout::Paper, ..softness(0.1) });
        for method in methods(softness(0.1)).into_iter().chain([packed]) {
            for spheres in &clouds {
                let of = |method| rendered(device, spheres, &frame(perspective(), [31, 20], method)).expect("renders");
                let (merged, sorted) = (of(method), of(in_place(method)));
                let names = |rendered: &Rendered| rendered.profile.passes.iter().map(|p| p.name).collect::<Vec<_>>();
                let most = merged.facts.max_events;
                assert!(most > 256, "{most}: there are long lists");
                assert!(names(&merged).contains(&"abuffer/merge"), "{method:?}");
                let used = names(&sorted);
                assert!(used.contains(&"abuffer/merge-in-place") && !used.contains(&"abuffer/merge"), "{used:?}");
                assert!(bytes(&sorted) == bytes(&merged), "{method:?}, {most} events");
                // In bands as well.
                let tight = Frame { memory_budget: Some(1 << 20), ..frame(perspective(), [31, 20], in_place(method)) };
                assert!(bytes(&rendered(device, spheres, &tight).expect("renders")) == bytes(&merged), "{method:?}");
            }
        }
    });
}

#[test]
fn too_long_a_list_to_sort_in_place_says_so() {
    with_device(|device| {
        // One list of one event more than there may be.
        let most = pellucid_engine::methods::abuffer::in_place_length();
        let spheres = vec![sphere(beside(0.5, 10.0), 2.0); most as usize / 2 + 1];
        let frame = frame(pixel_camera([1, 1]), [1, 1], in_place(Method::SoftBase(softness(1e-5))));
        match rendered(device, &spheres, &frame) {
            Err(Error::ListTooLong { length, most: limit }) => assert!(length > limit && limit == most, "{length}"),
            other => panic!("{:?}", other.map(|rendered| rendered.facts)),
        }
    });
}

#[test]
fn facts_count_a_sphere_once() {
    with_device(|device| {
        let spheres = soup_of(9, 300, 0.02..0.5);
        let mut lists = Vec::new();
        for method in methods(Soft::default()) {
            let frame = frame(orthographic(), [80, 60], method);
            let Rendered { image, facts, .. } = rendered(device, &spheres, &frame).expect("renders");
            let counts = image.fragments.expect("asked for");
            assert_eq!(facts.fragments, counts.iter().map(|n| u64::from(*n)).sum::<u64>());
            assert_eq!(Some(facts.max_list), counts.iter().max().copied());
            assert!(facts.max_events >= 2 * facts.max_list && facts.solid_points == 0);
            // Not asked for, the numbers are the same.
            let again = rendered(device, &spheres, &Frame { fragments: false, ..frame }).expect("renders").facts;
            assert_eq!(Facts { peak_device_bytes: 0, ..again }, Facts { peak_device_bytes: 0, ..facts });
            lists.push(counts);
        }
        assert!(lists.iter().all(|counts| *counts == lists[0]), "the spheres are the same, whatever they are made of");
    });
}

#[test]
fn without_soft_points_nothing_soft_runs() {
    with_device(|device| {
        let solid: Vec<S> = soup_of(11, 50, 0.1..0.3).into_iter().map(|s| S { field: 0.5, ..s }).collect();
        for method in methods(Soft::default()) {
            let names = |spheres: &[S]| -> Vec<&str> {
                let frame = frame(perspective(), [40, 30], method);
                let found = rendered(device, spheres, &frame).expect("renders");
                found.profile.passes.iter().map(|p| p.name).collect()
            };
            let none = names(&solid);
            assert!(none.contains(&"soft/compose") && !none.contains(&"soft/count"), "{none:?}");
            let all = names(&soup_of(11, 50, 0.1..0.3));
            assert!(!all.contains(&"soft/compose") && all.contains(&"soft/count"), "{all:?}");
            let both = names(&[solid.clone(), soup_of(12, 50, 0.1..0.3)].concat());
            assert!(both.contains(&"soft/compose") && both.contains(&"soft/count"), "{both:?}");
        }
    });
}

#[test]
fn the_papers_layout_is_what_its_reference_says() {
    let settings = |softness| Soft {
        layout: SoftLayout::Paper,
        density: Density::Softness(softness),
        threshold: 0.5,
        ..Soft::default()
    };
    // Short lists, and lists of more than 256 events.
    for (points, softness) in [(soup_of(3, 200, 0.1..0.3), 0.6), (soup_of(4, 900, 0.5..0.9), 0.05)] {
        with_device(|device| {
            let frame =
                Frame { size: [24, 20], ..frame(perspective(), [24, 20], Method::SoftBase(settings(softness))) };
            let image = rendered(device, &points, &frame).unwrap().image;
            let scene = cloud(&points);
            let colors = shade(&scene, &frame.camera, &frame.shading, frame.color);
            let truth = |layout| {
                let soft = Soft { layout, ..settings(softness) };
                let model = Model::new(SoftMethod::Base(soft), &scene);
                let scene =
                    soft::Scene { view: View::new(&frame.camera, frame.size), points: &scene, colors: &colors, model };
                scene.render(|_| Behind::NOTHING)
            };
            let off = |layout| {
                let truth = truth(layout).rgba;
                let of = |(rgba, wanted): (&[f32; 4], &[f64; 4])| {
                    rgba.iter().zip(wanted).map(|(a, b)| (f64::from(*a) - b).abs()).fold(0.0, f64::max)
                };
                image.rgba.iter().zip(&truth).map(of).collect::<Vec<f64>>()
            };
            // d / r and colors next to the middle between two of 256 levels may be rounded the other way: of one sphere
            // of many.
            let mut packed = off(SoftLayout::Paper);
            packed.sort_by(f64::total_cmp);
            let (most, bulk) = (packed[packed.len() - 1], packed[packed.len() * 9 / 10]);
            let precise = off(SoftLayout::Precise).into_iter().fold(0.0, f64::max);
            println!(
                "softness {softness}: from packed {bulk:.1e}, at most {most:.1e}; from precise at most {precise:.1e}"
            );
            assert!(bulk < 3e-4 && most < 3e-3, "{bulk} {most}");
            assert!(precise > 2.0 * bulk, "what 8 bits cost must show");
            let shuffled: Vec<S> = points.iter().rev().copied().collect();
            assert!(image == rendered(device, &shuffled, &frame).unwrap().image, "order of points");
            let tight = Frame { memory_budget: Some(1 << 20), ..frame };
            assert!(image == rendered(device, &points, &tight).unwrap().image, "budget");
        });
    }
}
