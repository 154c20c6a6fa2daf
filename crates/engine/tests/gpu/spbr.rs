//! `spbr`, `spbr-simplified`: opacities of surfaces against what was asked for, images against the float64 reference,
//! and the same bytes however ensembles are cut and whichever atomics find the nearest.

use std::sync::Arc;

use glam::{DVec3, Vec3};
use pellucid_core::camera::{Camera, Projection};
use pellucid_core::image::Image;
use pellucid_core::points::Points;
use pellucid_engine::methods::spbr::Form;
use pellucid_engine::methods::{Error, Frame, Rendered, Renderer};
use pellucid_engine::plan::plan;
use pellucid_gpu::{Device, Preferences};
use pellucid_reference::View;
use pellucid_reference::range::ROUNDING;
use pellucid_reference::spbr::{self as reference, Ranges};
use pellucid_scene::prepare::Arranged;
use pellucid_scene::prepare::ensembles::{CloudSurface, Dealt};
use pellucid_scene::{ColorSpace, Light, Method, Shading, ShadingModel, Spbr, SpbrSimplified};
use pellucid_testing::*;
use rand::RngExt;

const SIZE: [u32; 2] = [80, 60];

fn method(ensembles: u32) -> Method {
    Method::Spbr(Spbr { ensembles, ..Spbr::default() })
}

/// A camera on the z axis at `distance` from the origin that sees 3.2 × 2.4 world units there.
pub(crate) fn camera(distance: f64, perspective: bool) -> Camera {
    let projection = if perspective {
        Projection::Perspective { fov_y: 2.0 * (1.2f64 / 4.0).atan() }
    } else {
        Projection::Orthographic { height: 2.4 }
    };
    Camera::look_at(DVec3::Z * distance, DVec3::ZERO, DVec3::Y, projection, 0.01, 1000.0).expect("a valid camera")
}

/// Points at random on the rectangle of these sides around `center`; the area follows.
pub(crate) fn plane(
    seed: u64,
    count: usize,
    sides: [DVec3; 2],
    center: DVec3,
    color: Vec3,
    opacity: f32,
) -> (Points, f64) {
    let mut r = random(seed);
    let normal = sides[0].cross(sides[1]);
    let mut unit = || r.random_range(-0.5..0.5);
    let positions = (0..count).map(|_| center + sides[0] * unit() + sides[1] * unit()).collect();
    let points = Points {
        positions,
        colors: vec![color; count],
        opacities: vec![opacity; count],
        radii: vec![0.0; count],
        normals: Some(vec![normal.normalize().as_vec3(); count]),
        ..Points::default()
    };
    (points, normal.length())
}

/// A list of clouds of known area.
pub(crate) fn dealt(clouds: &[(Points, f64)]) -> Dealt {
    let mut list = Dealt::default();
    for (points, area) in clouds {
        let first = list.points.len() as u64;
        let count = points.len() as u64;
        let opacity = points.opacities.iter().copied().fold(0.0, f32::max);
        let center = points.bounds().expect("points").center();
        list.surfaces.push(CloudSurface {
            points: first..first + count,
            center,
            density: count as f64 / area,
            opacity,
        });
        let all = Arc::make_mut(&mut list.points);
        all.positions.extend(&points.positions);
        all.colors.extend(&points.colors);
        all.opacities.extend(&points.opacities);
        all.radii.extend(&points.radii);
        let normals = points.normals.clone().unwrap_or_else(|| vec![Vec3::ZERO; points.len()]);
        all.normals.get_or_insert_default().extend(normals);
    }
    list
}

fn render_on(renderer: &mut Renderer, dealt: &Dealt, frame: &Frame) -> Rendered {
    let mut cloud = renderer.upload(&Arranged::Dealt(dealt.clone())).expect("fits");
    renderer.render(&mut cloud, frame).expect("renders")
}

fn render(device: &Device, dealt: &Dealt, frame: &Frame) -> Rendered {
    render_on(&mut Renderer::new(device).expect("a renderer"), dealt, frame)
}

/// Mean of A over all pixels.
fn mean_alpha(image: &Image) -> f64 {
    image.rgba.iter().map(|c| f64::from(c[3])).sum::<f64>() / image.rgba.len() as f64
}

/// Asserts a mean of A: within four standard errors of so many independent samples, those of pixels and ensembles.
#[track_caller]
fn assert_alpha(image: &Image, alpha: f64, samples: f64, what: &str) {
    let found = mean_alpha(image);
    let bound = 4.0 * (alpha * (1.0 - alpha) / samples).sqrt();
    println!("{what}: {found:.5} for {alpha:.5}, bound {bound:.5}");
    assert!((found - alpha).abs() < bound, "{what}: {found} for {alpha}, bound {bound}");
}

const X: DVec3 = DVec3::X;
const Y: DVec3 = DVec3::Y;

#[test]
fn a_white_plane_has_the_opacity_asked_for() {
    with_device(|device| {
        let mut renderer = Renderer::new(device).expect("a renderer");
        // A plane larger than the view, of as many points per pixel as make k what it says.
        let (ensembles, pixels_over) = (20u32, (4.0 * 3.0) / (3.2 * 2.4) * 4800.0);
        for alpha in [0.05f64, 0.2, 0.5, 0.9] {
            for k in [0.3, 1.0, 4.0, 19.0] {
                let count = (f64::from(ensembles) * -(-alpha).ln_1p() / k * pixels_over) as usize;
                let points = plane(count as u64, count, [4.0 * X, 3.0 * Y], DVec3::ZERO, Vec3::ONE, alpha as f32);
                let list = dealt(&[points]);
                for perspective in [true, false] {
                    let frame = frame(camera(4.0, perspective), SIZE, method(ensembles));
                    let found = render_on(&mut renderer, &list, &frame);
                    let samples = 4800.0 * (count as f64 * k / pixels_over).min(f64::from(ensembles));
                    // Copies of one point are no independent points.
                    let samples = samples / k.max(1.0);
                    assert_alpha(&found.image, alpha, samples, &format!("k {k}, perspective {perspective}"));
                    let share = found.facts.slots as f64 / (k * count as f64);
                    assert!((share - 1.0).abs() < 0.01, "{share}");
                    assert!(found.facts.thin.is_empty());
                    assert!(found.image.rgba.iter().all(|c| c[0] == c[3] && c[1] == c[3] && c[2] == c[3]));
                }
            }
        }
    });
}

#[test]
fn a_slanted_plane_follows_eq_2_or_keeps_its_opacity() {
    with_device(|device| {
        let (alpha, ensembles, count) = (0.3f64, 25, 60_000);
        for degrees in [0.0f64, 30.0, 60.0] {
            let (sin, cos) = degrees.to_radians().sin_cos();
            // As large as the view once it is seen at this angle, and the camera so far off that rays are parallel.
            let sides = [4.0 * X, DVec3::new(0.0, cos, sin) * 3.0 / cos];
            let list = dealt(&[plane(5, count, sides, DVec3::ZERO, Vec3::ONE, alpha as f32)]);
            for cos_theta in [true, false] {
                let spbr = Method::Spbr(Spbr { ensembles, cos_theta, ..Spbr::default() });
                let found = render(device, &list, &frame(camera(4.0, false), SIZE, spbr));
                let wanted = if cos_theta { reference::slanted(alpha, cos) } else { alpha };
                assert_alpha(&found.image, wanted, 4800.0 * 5.0, &format!("{degrees}°, {cos_theta}"));
            }
        }
    });
}

#[test]
fn two_planes_compose_and_hide_by_depth() {
    with_device(|device| {
        let sides = [5.0 * X, 4.0 * Y];
        let (red, blue) = (Vec3::new(1.0, 0.25, 0.0), Vec3::new(0.0, 0.25, 1.0));
        let front = plane(1, 90_000, sides, DVec3::Z * 0.5, red, 0.4);
        let back = plane(2, 70_000, sides, DVec3::Z * -0.5, blue, 0.7);
        for clouds in [[front.clone(), back.clone()], [back, front]] {
            for perspective in [true, false] {
                let found = render(device, &dealt(&clouds), &frame(camera(4.0, perspective), SIZE, method(30)));
                let image = &found.image;
                assert_alpha(image, 0.4 + 0.6 * 0.7, 4800.0 * 10.0, "both");
                let mean = |c: usize| image.rgba.iter().map(|p| f64::from(p[c])).sum::<f64>() / 4800.0;
                assert!((mean(0) - 0.4).abs() < 0.006 && (mean(2) - 0.42).abs() < 0.006, "{} {}", mean(0), mean(2));
                assert!((mean(1) - 0.25 * mean_alpha(image)).abs() < 1e-4);
            }
        }
    });
}

#[test]
fn distance_does_not_change_opacity() {
    with_device(|device| {
        // The camera stays behind one plane's middle; another plane lies nearer or farther in the same cloud, such
        // that its points are 2, 1 or 1/2 pixels wide.
        let mut clouds = Vec::new();
        for (depth, side) in [(2.0, 2.2), (4.0, 4.4), (8.0, 8.8)] {
            let count = (10_000.0 * side * side) as usize;
            clouds.push(plane(depth as u64, count, [side * X, side * Y], DVec3::Z * (4.0 - depth), Vec3::ONE, 0.5));
        }
        for (points, area) in clouds {
            let mut list = dealt(&[(points, area)]);
            list.surfaces[0].center = DVec3::ZERO;
            let found = render(device, &list, &frame(camera(4.0, true), SIZE, method(40)));
            assert_alpha(&found.image, 0.5, 4800.0 * 8.0, &format!("{area}"));
        }
    });
}

/// Three clouds of random points with random normals, opacities and colors: k from below to above 1.
pub(crate) fn mixture(seed: u64) -> Dealt {
    let mut r = random(seed);
    let mut clouds = Vec::new();
    for (count, area, middle) in [(3000, 30.0, 0.0), (500, 1.0, 0.3), (41, 0.3, -0.4)] {
        let (mut points, _) = plane(seed, count, [2.0 * X, 2.0 * Y], DVec3::ZERO, Vec3::ONE, 0.5);
        for i in 0..count {
            let mut unit = || r.random_range(-1.0..1.0f64);
            points.positions[i] = DVec3::new(unit(), unit(), unit()) + DVec3::splat(middle);
            points.colors[i] = DVec3::new(unit().abs(), unit().abs(), unit().abs()).as_vec3();
            points.opacities[i] = (unit().abs() * 0.6) as f32;
            let normal = DVec3::new(unit(), unit(), unit()).normalize().as_vec3();
            points.normals.as_mut().expect("normals")[i] = if i % 7 == 0 { Vec3::ZERO } else { normal };
        }
        clouds.push((points, area));
    }
    dealt(&clouds)
}

/// Colors are whole numbers of 1 / 2^22, half of one is added in float32, which may round it by a quarter; the mean
/// then has two roundings.
const COLOR_ERROR: f64 = 0.75 / 4_194_304.0 + 2.0 * ROUNDING;
/// A standard error is at most that of half the ensembles at 0 and half of them at 1, with six roundings; colors that
/// are off change it by no more than they are off.
const STDERR_ERROR: f64 = COLOR_ERROR + 6.0 * ROUNDING;

/// Compares an image with what roundings may make of the reference's; an error names the pixels.
pub(crate) fn compare(image: &Image, wanted: &Ranges) -> Result<(), String> {
    let stderr = image.stderr.as_ref().ok_or("no standard errors")?;
    let is_off = |i: &usize| {
        let color = image.rgba[*i].iter().zip(wanted.rgba[*i]);
        let error = stderr[*i].iter().zip(wanted.stderr[*i]);
        color.into_iter().any(|(found, wanted)| !wanted.covers(f64::from(*found), COLOR_ERROR))
            || error.into_iter().any(|(found, wanted)| !wanted.covers(f64::from(*found), STDERR_ERROR))
            || !wanted.depth[*i].covers(f64::from(image.depth[*i]), 0.0)
    };
    let off: Vec<usize> = (0..image.rgba.len()).filter(is_off).collect();
    let Some(&i) = off.first() else { return Ok(()) };
    let found = (image.rgba[i], image.depth[i], stderr[i]);
    let wanted = (wanted.rgba[i], wanted.depth[i], wanted.stderr[i]);
    Err(format!("pixels {off:?}, the first is {found:?}, not {wanted:?}"))
}

#[test]
fn images_are_those_of_the_reference() {
    with_device(|device| {
        let mut renderer = Renderer::new(device).expect("a renderer");
        let list = mixture(3);
        let colors: Vec<DVec3> = list.points.colors.iter().map(|c| c.as_dvec3()).collect();
        // Near enough that the nearest points are squares of many pixels.
        for (distance, perspective) in [(6.0, true), (2.2, true), (6.0, false)] {
            let camera = camera(distance, perspective);
            for (method, rule) in [
                (method(9), reference::Rule::from(Spbr { ensembles: 9, ..Spbr::default() })),
                (
                    Method::Spbr(Spbr { ensembles: 64, cos_theta: false, brighten: false }),
                    reference::Rule { ensembles: 64, adjust: true, cos_theta: false },
                ),
                (
                    Method::SpbrSimplified(SpbrSimplified { ensembles: 5, ..SpbrSimplified::default() }),
                    reference::Rule { ensembles: 5, adjust: false, cos_theta: true },
                ),
            ] {
                let frame = Frame { seed: 11, ..frame(camera, SIZE, method) };
                let image = render_on(&mut renderer, &list, &frame).image;
                let wanted = reference::ranges(View::new(&camera, SIZE), &list, &colors, &rule, 11);
                let compared = compare(&image, &wanted);
                assert!(compared.is_ok(), "{method:?}, {distance}, {perspective}: {compared:?}");
                // The comparison can fail: an ensemble more, and in one pixel a part of an ensemble's color less.
                let rule = reference::Rule { ensembles: rule.ensembles + 1, ..rule };
                let other = reference::ranges(View::new(&camera, SIZE), &list, &colors, &rule, 11);
                compare(&image, &other).expect_err("another number of ensembles");
                let pixel = (0..image.rgba.len()).find(|pixel| image.rgba[*pixel][1] > 0.1).expect("something green");
                let mut changed = image.clone();
                changed.rgba[pixel][1] -= 0.1 / rule.ensembles as f32;
                compare(&changed, &wanted).expect_err("another color");
            }
        }
    });
}

#[test]
fn squares_that_a_workgroup_shares_have_the_bytes_of_those_walked_alone() {
    let list = mixture(8);
    let lambert = Shading { model: ShadingModel::Lambert, light: Light::Headlight, ..Shading::default() };
    // From points of a pixel to squares of the whole image, two cameras among the points.
    let distances = [20.0, 6.0, 2.2, 1.6, 1.5, 1.45, 1.4, 1.0, 0.5];
    let run = |spread_squares: bool| {
        let mut found = Vec::new();
        with_device_that_prefers(Preferences { spread_squares, ..Preferences::CPU }, |device| {
            let mut renderer = Renderer::new(device).expect("a renderer");
            for (number, distance) in distances.into_iter().enumerate() {
                let shading = if number % 2 == 0 { Shading::NONE } else { lambert };
                let frame = Frame { shading, spread: number < 3, ..frame(camera(distance, true), SIZE, method(9)) };
                let listed = render_on(&mut renderer, &list, &frame).facts.listed;
                for (form, image) in all_forms(&mut renderer, &list, &frame) {
                    let stderr = image.stderr.iter().flatten().flatten().map(|v| v.to_bits());
                    found.push((form, listed, bits(&image).into_iter().chain(stderr).collect::<Vec<u32>>()));
                }
            }
        });
        found
    };
    let (alone, shared) = (run(false), run(true));
    assert_eq!(alone.len(), shared.len());
    let mut lists = [0; 3];
    for ((form, listed, bytes), (_, fewer, other)) in alone.iter().zip(&shared) {
        assert!(bytes == other, "{form:?}, on a list: {listed}, {fewer}");
        lists[usize::from(*listed) + usize::from(*fewer)] += 1;
        assert!(*listed || !fewer);
    }
    // No list, a list of squares over 64 pixels alone, and one of those over 4096.
    assert!(alone.is_empty() || lists.iter().all(|count| *count > 0), "{lists:?}");
}

fn all_forms(renderer: &mut Renderer, list: &Dealt, frame: &Frame) -> Vec<(Option<Form>, Image)> {
    forms(renderer, list, frame, |_| true)
}

/// The image in some of the three forms.
fn forms(
    renderer: &mut Renderer,
    list: &Dealt,
    frame: &Frame,
    takes: impl Fn(usize) -> bool,
) -> Vec<(Option<Form>, Image)> {
    let wide = renderer.device().info().int64_atomics;
    let mut found = Vec::new();
    let all = [(wide, true), (wide, false), (false, false)].into_iter().enumerate();
    for (_, (wide, single)) in all.filter(|(number, _)| takes(*number)) {
        (renderer.switches.wide_atomics, renderer.switches.single_pass) = (wide, single);
        let rendered = render_on(renderer, list, frame);
        found.push((rendered.facts.form, rendered.image));
    }
    (renderer.switches.wide_atomics, renderer.switches.single_pass) = (wide, true);
    found
}

#[test]
fn the_bytes_do_not_depend_on_atomics_windows_and_rounds() {
    let run = |device: &Device, budgets: &[Option<u64>], images: &mut Vec<Vec<Vec<u32>>>| {
        let mut renderer = Renderer::new(device).expect("a renderer");
        let list = mixture(4);
        let lambert = Shading { model: ShadingModel::Lambert, light: Light::Headlight, ..Shading::default() };
        let mut all: Vec<Vec<u32>> = Vec::new();
        for (shading, color) in [(Shading::NONE, ColorSpace::Linear), (lambert, ColorSpace::Encoded)] {
            for camera in [camera(2.2, true), camera(4.0, false)] {
                let spbr = Method::Spbr(Spbr { ensembles: 20, cos_theta: false, brighten: false });
                let mut seen: Option<Vec<u32>> = None;
                for (number, memory_budget) in budgets.iter().copied().enumerate() {
                    let frame = Frame { memory_budget, shading, color, ..frame(camera, SIZE, spbr) };
                    // Each form in one of the budgets, by turns: every pair of shading, camera, budget and form.
                    let shift = all.len() + number;
                    for (form, image) in forms(&mut renderer, &list, &frame, |form| form == shift % 3) {
                        let stderr = image.stderr.iter().flatten().flatten().map(|v| v.to_bits());
                        let found: Vec<u32> = bits(&image).into_iter().chain(stderr).collect();
                        let first = seen.get_or_insert_with(|| found.clone());
                        assert!(*first == found, "{form:?}, budget {memory_budget:?}");
                    }
                }
                all.push(seen.expect("rendered"));
            }
        }
        images.push(all);
    };
    let mut images = Vec::new();
    with_device(|device| run(device, &[None, Some(2_000_000), Some(100_000)], &mut images));
    // Points in several bindings.
    with_device_that_binds(Some(100_000), |device| run(device, &[None, Some(2_000_000)], &mut images));
    assert!(images.windows(2).all(|pair| pair[0] == pair[1]));
}

/// Clouds of so many points and such an area each, with random opacities, colors and perhaps normals, all over a box.
pub(crate) fn planes(seed: u64, counts: &[(usize, f64)], normals: bool) -> Dealt {
    let mut r = random(seed);
    let mut clouds = Vec::new();
    for (count, area) in counts {
        let (mut points, _) = plane(seed, *count, [3.0 * X, 2.0 * Y], DVec3::ZERO, Vec3::ONE, 0.5);
        for i in 0..*count {
            points.positions[i].z = r.random_range(-1.0..1.0);
            points.colors[i] = Vec3::new(r.random(), r.random(), r.random());
            points.opacities[i] = r.random_range(0.2..0.6);
            let normal = Vec3::new(r.random_range(-0.5..0.5), r.random_range(-0.5..0.5), 1.0).normalize();
            points.normals.as_mut().expect("normals")[i] = normal;
        }
        clouds.push((points, *area));
    }
    let mut list = dealt(&clouds);
    if !normals {
        Arc::make_mut(&mut list.points).normals = None;
    }
    list
}

#[test]
fn points_that_go_through_the_device_bit_by_bit_give_the_same_bytes() {
    with_device(|device| {
        let mut renderer = Renderer::new(device).expect("a renderer");
        let lambert = Shading { model: ShadingModel::Lambert, light: Light::Headlight, ..Shading::default() };
        // Each point in less than one ensemble and in several; one cloud larger than the window and some.
        let mut case = 0;
        for (counts, ensembles, k) in [
            (&[(100_000, 4.0)][..], 9, 0.1..0.9),
            (&[(100_000, 40.0)], 9, 1.1..8.0),
            (&[(70_000, 0.2), (1000, 1.6), (40_000, 2.4)], 60, 0.5..15.0),
        ] {
            for (normals, shading, distance) in [(true, lambert, 4.0), (false, Shading::NONE, 2.2)] {
                let list = planes(11, counts, normals);
                let spbr = Method::Spbr(Spbr { ensembles, cos_theta: false, brighten: false });
                let all = Frame { shading, ..frame(camera(distance, true), SIZE, spbr) };
                let resident = render_on(&mut renderer, &list, &all);
                assert_eq!((resident.facts.streamed, resident.facts.uploaded_bytes), (None, 0));
                let share = resident.facts.slots as f64 / list.points.len() as f64;
                println!("{share} copies of each point, {} drawn", resident.facts.visible);
                assert!(k.contains(&share), "{share}");
                let frame = Frame { memory_budget: Some(4 << 20), ..all };
                // Every pair of clouds, normals and form.
                let turn = (case + case / 2) % 2;
                case += 1;
                for (form, image) in forms(&mut renderer, &list, &frame, |form| form % 2 == turn) {
                    assert!(form != Some(Form::Single));
                    assert!(bits(&image) == bits(&resident.image), "{form:?}, {counts:?}, {normals}");
                    assert!(image.stderr == resident.image.stderr);
                }
            }
        }
    });
}

#[test]
fn a_cloud_may_change_between_the_device_and_the_host() {
    with_device(|device| {
        let mut renderer = Renderer::new(device).expect("a renderer");
        let list = planes(12, &[(100_000, 4.0)], true);
        let mut cloud = renderer.upload(&Arranged::Dealt(list.clone())).expect("fits");
        let all = frame(camera(4.0, true), SIZE, method(9));
        let frames = [None, Some(3 << 20), Some(3 << 20), None].map(|memory_budget| Frame { memory_budget, ..all });
        let point = 64 * 100_000;
        let images = frames.map(|frame| {
            let surveyed = renderer.survey(&mut cloud, &frame).expect("surveyed");
            let found = renderer.render(&mut cloud, &frame).expect("renders");
            let streamed = frame.memory_budget.map(|_| 65_536);
            assert_eq!((found.facts.streamed, surveyed.streamed), (streamed, streamed));
            assert_eq!(cloud.bytes() >= point, streamed.is_none());
            // In two stages, each of which goes over the whole cloud in each window.
            assert!(found.facts.uploaded_bytes <= 2 * point * found.facts.windows);
            let steps = plan(device, &frame, &surveyed, renderer.switches.wide_atomics, "asked for");
            let mut ran: Vec<&str> = found.profile.passes.iter().map(|pass| pass.name).collect();
            let mut planned: Vec<&str> = steps.iter().filter(|step| step.on).map(|step| step.name).collect();
            ran.sort_unstable();
            planned.sort_unstable();
            assert_eq!(ran, planned);
            bits(&found.image)
        });
        assert!(images.windows(2).all(|pair| pair[0] == pair[1]));
        let points = Frame { method: Method::Points, ..frames[1] };
        renderer.render(&mut cloud, &points).expect("renders");
        assert!(cloud.bytes() > point);
    });
}

#[test]
fn a_streamed_frame_stays_within_its_budget() {
    with_new_device(|device| {
        let list = planes(13, &[(1_500_000, 1.0)], false);
        let size = [640, 480];
        for budget in [32 << 20, 64 << 20] {
            let frame =
                Frame { memory_budget: Some(budget), fragments: false, ..frame(camera(4.0, true), size, method(20)) };
            let facts = render(device, &list, &frame).facts;
            println!("{facts:?}, {:?} points", list.points.len());
            assert!(facts.streamed.is_some_and(|points| points < 1_500_000));
            // Color and depth of the image, there and for the host.
            let image = 2 * 20 * 640 * 480 / facts.windows;
            assert!(facts.peak_device_bytes <= budget + image, "{} of {budget}", facts.peak_device_bytes);
        }
    });
}

#[test]
fn epochs_that_run_out_change_nothing() {
    with_device(|device| {
        let mut renderer = Renderer::new(device).expect("a renderer");
        // Enough points that an ensemble is a round by itself.
        let list = dealt(&[plane(10, 300_000, [4.0 * X, 3.0 * Y], DVec3::ZERO, Vec3::ONE, 0.99)]);
        let frame = Frame { fragments: false, ..frame(camera(4.0, true), SIZE, method(8)) };
        let many = render_on(&mut renderer, &list, &frame);
        assert!(!many.facts.renewed);
        for (epoch_bits, single_pass) in [(2, true), (1, true), (0, true), (2, false)] {
            (renderer.switches.epoch_bits, renderer.switches.single_pass) = (epoch_bits, single_pass);
            let few = render_on(&mut renderer, &list, &frame);
            assert_eq!(few.facts.renewed, single_pass);
            assert!(bits(&few.image) == bits(&many.image), "{epoch_bits} bits");
        }
    });
}

#[test]
fn seeds_decide() {
    with_device(|device| {
        let mut renderer = Renderer::new(device).expect("a renderer");
        let list = mixture(5);
        let of = |seed| Frame { seed, ..frame(camera(4.0, true), SIZE, method(30)) };
        let first = render_on(&mut renderer, &list, &of(1)).image;
        assert!(bits(&first) == bits(&render_on(&mut renderer, &list, &of(1)).image));
        assert!(bits(&first) != bits(&render_on(&mut renderer, &list, &of(2)).image));
    });
}

#[test]
fn a_pixel_varies_as_a_mean_of_independent_images_does() {
    with_device(|device| {
        let (alpha, ensembles) = (0.4f64, 10u32);
        let list = dealt(&[plane(9, 80_000, [4.0 * X, 3.0 * Y], DVec3::ZERO, Vec3::ONE, alpha as f32)]);
        let image = render(device, &list, &frame(camera(4.0, false), SIZE, method(ensembles))).image;
        let mean = mean_alpha(&image);
        let spread: f64 = image.rgba.iter().map(|c| (f64::from(c[3]) - mean).powi(2)).sum::<f64>() / 4799.0;
        let wanted = alpha * (1.0 - alpha) / f64::from(ensembles);
        // The variance of 4800 binomial numbers is known to about 2%.
        assert!((spread / wanted - 1.0).abs() < 0.08, "{spread} for {wanted}");
    });
}

#[test]
fn each_point_has_the_opacity_of_its_own() {
    with_device(|device| {
        let (mut points, area) = plane(6, 60_000, [4.0 * X, 3.0 * Y], DVec3::ZERO, Vec3::ONE, 0.6);
        for (p, opacity) in points.positions.iter().zip(&mut points.opacities) {
            *opacity = if p.x < 0.0 { 0.2 } else { 0.6 };
        }
        let list = dealt(&[(points, area)]);
        let image = render(device, &list, &frame(camera(4.0, false), SIZE, method(20))).image;
        let half = |right: bool| {
            let side = image.rgba.iter().enumerate().filter(|(i, _)| (i % 80 >= 40) == right);
            side.map(|(_, c)| f64::from(c[3])).sum::<f64>() / 2400.0
        };
        assert!((half(false) - 0.2).abs() < 0.01 && (half(true) - 0.6).abs() < 0.01, "{} {}", half(false), half(true));
    });
}

#[test]
fn too_few_points_are_told_and_huge_ones_fill_the_image() {
    with_device(|device| {
        let sparse = dealt(&[plane(7, 4000, [4.0 * X, 3.0 * Y], DVec3::ZERO, Vec3::ONE, 0.99)]);
        let found = render(device, &sparse, &frame(camera(4.0, false), SIZE, method(7)));
        let [thin] = found.facts.thin[..] else { panic!("{:?}", found.facts.thin) };
        let reached = 1.0 - (-4000.0f64 / 7500.0).exp();
        assert!((f64::from(thin.reached) / 1000.0 - reached).abs() < 1e-3 && thin.cloud == 0);
        assert_alpha(&found.image, reached, 4800.0, "as many as there are");
        // One point just before the camera, one far behind: a square over the whole image and more.
        let (mut points, _) = plane(8, 2, [X, Y], DVec3::ZERO, Vec3::ONE, 1.0);
        points.positions = vec![DVec3::new(0.0, 0.0, 3.98), DVec3::new(0.0, 0.0, -400.0)];
        points.colors = vec![Vec3::new(0.5, 0.0, 1.0), Vec3::ONE];
        let huge = dealt(&[(points, 1e-3)]);
        let mut renderer = Renderer::new(device).expect("a renderer");
        for memory_budget in [None, Some(60_000)] {
            let frame = Frame { memory_budget, ..frame(camera(4.0, true), [167, 111], method(3)) };
            for (form, image) in all_forms(&mut renderer, &huge, &frame) {
                assert!(image.rgba.iter().all(|c| *c == [0.5, 0.0, 1.0, 1.0]), "{form:?}");
                assert!(image.depth.iter().all(|z| (z - 0.02).abs() < 1e-6), "{form:?}");
            }
        }
    });
}

#[test]
fn an_error_may_stop_the_ensembles() {
    with_device(|device| {
        let list = dealt(&[plane(9, 30_000, [4.0 * X, 3.0 * Y], DVec3::ZERO, Vec3::ONE, 0.4)]);
        let all = frame(camera(4.0, false), SIZE, method(2000));
        let mut renderer = Renderer::new(device).expect("a renderer");
        let mut last = None;
        for memory_budget in [None, Some(100_000)] {
            let frame = Frame { max_error: Some(0.05), memory_budget, ..all };
            let found = render_on(&mut renderer, &list, &frame);
            let errors = found.image.stderr.as_ref().expect("asked for");
            let squares: f64 = errors.iter().flatten().map(|e| f64::from(*e).powi(2)).sum();
            let error = (squares / 14_400.0).sqrt();
            println!("{} ensembles, {error}", found.facts.ensembles);
            assert!(error <= 0.05 && (90..200).contains(&found.facts.ensembles), "{error}");
            assert!(last.is_none_or(|before| before == bits(&found.image)));
            last = Some(bits(&found.image));
        }
    });
}

/// A frame may draw fewer ensembles than the method deals: those that it would draw first.
#[test]
fn so_many_ensembles_are_drawn_as_a_frame_asks_for() {
    with_device(|device| {
        let list = dealt(&[plane(9, 30_000, [4.0 * X, 3.0 * Y], DVec3::ZERO, Vec3::ONE, 0.4)]);
        let all = Frame { fragments: false, ..frame(camera(4.0, false), SIZE, method(40)) };
        let mut renderer = Renderer::new(device).expect("a renderer");
        let whole = render_on(&mut renderer, &list, &all);
        for (asked, drawn) in [(0, 1), (1, 1), (7, 7), (40, 40), (u32::MAX, 40)] {
            let few = Frame { ensembles: Some(asked), ..all };
            let found = render_on(&mut renderer, &list, &few);
            assert_eq!(found.facts.ensembles, drawn, "{asked}");
            assert_eq!(bits(&found.image) == bits(&whole.image), drawn == 40, "{asked}");
            assert!(found.image.stderr.is_none());
            // An error that is never reached takes all of them, and no more; one that is asked for is that of those
            // drawn.
            let limited = render_on(&mut renderer, &list, &Frame { max_error: Some(1e-9), ..few });
            assert_eq!(limited.facts.ensembles, drawn, "{asked}");
            assert!(bits(&limited.image) == bits(&found.image), "{asked}");
            let spread = render_on(&mut renderer, &list, &Frame { spread: true, ..few });
            assert!(bits(&spread.image) == bits(&found.image), "{asked}");
            let error = spread.image.standard_error().expect("asked for");
            assert!(if drawn == 1 { error == f64::INFINITY } else { error > 0.0 && error < 1.0 }, "{asked}: {error}");
        }
    });
}

#[test]
fn the_plan_lists_the_passes_that_run() {
    with_device(|device| {
        let mut renderer = Renderer::new(device).expect("a renderer");
        let list = mixture(7);
        let lambert = Shading { model: ShadingModel::Lambert, light: Light::Headlight, ..Shading::default() };
        for (shading, distance) in [(Shading::NONE, 2.2), (lambert, 2.2), (Shading::NONE, 20.0)] {
            let frame = Frame { shading, ..frame(camera(distance, true), SIZE, method(9)) };
            let mut cloud = renderer.upload(&Arranged::Dealt(list.clone())).expect("fits");
            let surveyed = renderer.survey(&mut cloud, &frame).expect("surveyed");
            let steps = plan(device, &frame, &surveyed, renderer.switches.wide_atomics, "asked for");
            let found = renderer.render(&mut cloud, &frame).expect("renders");
            let mut ran: Vec<&str> = found.profile.passes.iter().map(|pass| pass.name).collect();
            let mut planned: Vec<&str> = steps.iter().filter(|step| step.on).map(|step| step.name).collect();
            ran.sort_unstable();
            planned.sort_unstable();
            assert_eq!(ran, planned);
            assert_eq!((surveyed.slots, surveyed.ensembles), (found.facts.slots, found.facts.ensembles));
            assert!(found.facts.visible > 0);
        }
    });
}

#[test]
fn points_that_were_not_dealt_are_refused_and_other_methods_take_dealt_ones() {
    with_device(|device| {
        let mut renderer = Renderer::new(device).expect("a renderer");
        let list = mixture(6);
        let frame = frame(perspective(), SIZE, method(3));
        let mut plain = renderer.upload(&*list.points).expect("fits");
        assert!(matches!(renderer.render(&mut plain, &frame), Err(Error::NotDealt)));
        let mut cloud = renderer.upload(&Arranged::Dealt(list.clone())).expect("fits");
        renderer.render(&mut cloud, &frame).expect("renders");
        for method in [Method::Points, Method::ABuffer(Default::default())] {
            let frame = Frame { method, ..frame };
            let found = renderer.render(&mut cloud, &frame).expect("renders").image;
            assert!(bits(&found) == bits(&renderer.render(&mut plain, &frame).expect("renders").image));
        }
        let empty =
            renderer.upload(&Arranged::Dealt(Dealt::default())).map(|mut cloud| renderer.render(&mut cloud, &frame));
        let image = empty.expect("uploads").expect("renders").image;
        assert!(image.rgba.iter().all(|c| *c == [0.0; 4]) && image.depth.iter().all(|z| z.is_infinite()));
    });
}

#[test]
fn regions_have_the_pixels_of_the_whole() {
    with_device(|device| {
        let list = mixture(5);
        for method in Method::all().into_iter().filter(Method::is_dealt) {
            let mut renderer = Renderer::new(device).expect("a renderer");
            let frame = Frame { spread: true, ..frame(perspective(), [96, 64], method) };
            let expected = render_on(&mut renderer, &list, &frame).image;
            let mut found = expected.clone();
            found.rgba.fill([-1.0; 4]);
            for [x0, y0, x1, y1] in [[0, 0, 96, 32], [0, 32, 50, 64], [50, 32, 96, 64]] {
                renderer.region = Some([x0, y0, x1, y1]);
                let part = render_on(&mut renderer, &list, &frame).image;
                for y in y0..y1 {
                    let row = (y * 96 + x0) as usize..(y * 96 + x1) as usize;
                    found.rgba[row.clone()].copy_from_slice(&part.rgba[row.clone()]);
                    found.depth[row.clone()].copy_from_slice(&part.depth[row]);
                }
            }
            assert_eq!(bits(&found), bits(&expected), "{}", method.name());
        }
    });
}
