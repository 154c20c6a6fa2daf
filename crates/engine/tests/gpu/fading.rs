//! `moments`, `wavelet`, and `hybrid` with a tail by moments: images against their float64 references within bounds
//! that follow from float32; what they are exact for; near singular moments; the same bytes whatever the order of
//! input, the cut of the image and the runs over a tile.
//!
//! Arithmetic on moments runs in sums of two floats, so that what differs from the reference is what fragments come
//! with: depths and opacities of float32. How much a pixel changes with these, the reference says itself.

use glam::{DVec3, Vec3};
use pellucid_core::camera::Camera;
use pellucid_core::image::Image;
use pellucid_core::points::Points;
use pellucid_engine::methods::{Error, Frame, Renderer};
use pellucid_gpu::Device;
use pellucid_reference::View;
use pellucid_reference::abuffer::{Composite, Fragment, composite, lists};
use pellucid_reference::approximate::hybrid_before;
use pellucid_reference::moments::{moments, optical_depth};
use pellucid_reference::range::ROUNDING;
use pellucid_reference::wavelet::wavelet;
use pellucid_reference::{ReferencePicture, approximate, gaussians, shading};
use pellucid_scene::prepare::order;
use pellucid_scene::{
    ColorSpace, DiscShape, Discs, Falloff, GaussianSettings, Hybrid, Method, MomentCount, Moments, Order, Shading,
    Tail, Wavelet,
};
use pellucid_testing::gaussians::Soup;
use pellucid_testing::*;
use rand::RngExt;
use rand::seq::SliceRandom;

fn by_moments(discs: Discs, moments: MomentCount) -> Method {
    Method::Moments(Moments { discs, moments, ..Moments::default() })
}

fn by_wavelets(discs: Discs, rank: u32) -> Method {
    Method::Wavelet(Wavelet { discs, rank })
}

fn behind(discs: Discs, k: u32, core_alpha_min: f32, moments: MomentCount) -> Method {
    Method::Hybrid(Hybrid { discs, k, core_alpha_min, tail: Tail::Moments, moments })
}

/// All methods of this file. The last one finds some fragments too faint for the front.
fn methods(discs: Discs) -> Vec<Method> {
    let moments = MomentCount::ALL.map(|count| by_moments(discs, count));
    let wavelets = [1, 3, 5].map(|rank| by_wavelets(discs, rank));
    let tails = [behind(discs, 2, 0.0, MomentCount::Four), behind(discs, 3, 0.2, MomentCount::Six)];
    moments.into_iter().chain(wavelets).chain(tails).collect()
}

/// A list by the reference of a method.
fn composed(list: &[Fragment], colors: &[DVec3], camera: &Camera, method: &Method) -> Composite {
    match method {
        Method::Moments(settings) => moments(list, colors, [camera.near, camera.far], settings),
        Method::Wavelet(Wavelet { rank, .. }) => wavelet(list, colors, [camera.near, camera.far], *rank),
        Method::Hybrid(Hybrid { k, core_alpha_min, moments: count, .. }) => {
            let settings = Moments { moments: *count, ..Moments::default() };
            let tail = |tail: &[Fragment]| moments(tail, colors, [camera.near, camera.far], &settings).color;
            hybrid_before(list, colors, (*k, (*core_alpha_min).into()), tail)
        }
        other => panic!("{other:?}"),
    }
}

/// Relative errors that a fragment comes with.
#[derive(Clone, Copy)]
pub(crate) struct Off {
    depth: f64,
    alpha: f64,
}

/// The most that float32 may change a component of a pixel, given what it does to its fragments: of equal depths all
/// the same.
pub(crate) fn bound(
    list: &[Fragment],
    colors: &[DVec3],
    camera: &Camera,
    method: &Method,
    off: impl Fn(&Fragment) -> Off,
) -> f64 {
    let seen: Vec<Fragment> = list.iter().filter(|f| f.alpha > 0.0).copied().collect();
    let whole = composed(&seen, colors, camera, method);
    // Logarithms of ratios of depths have some five roundings, of numbers up to ln(far / near); places are these by a
    // factor.
    let of_place = 6.0 * ROUNDING * (camera.far / camera.near).ln();
    let mut moved = 0.0;
    let mut of_alpha = 0.0f64;
    for (i, f) in seen.iter().enumerate() {
        let Off { depth, alpha } = off(f);
        of_alpha = of_alpha.max(alpha);
        if seen[..i].iter().any(|other| other.z == f.z) {
            continue;
        }
        let with = |factor: f64| {
            let at = |other: &Fragment| if other.z == f.z { other.z * factor } else { other.z };
            let list: Vec<Fragment> = seen.iter().map(|other| Fragment { z: at(other), ..*other }).collect();
            (composed(&list, colors, camera, method).color - whole.color).abs().max_element()
        };
        let by = depth + of_place;
        moved += with(1.0 + by).max(with(1.0 - by));
    }
    let total: f64 = seen.iter().map(|f| optical_depth(f.alpha)).sum();
    let brightest = seen.iter().map(|f| colors[f.index as usize].max_element()).fold(1.0, f64::max);
    // Shares of the optical depth have some twenty roundings, and are times it in an exponent, as errors of opacities
    // are. A mean of colors changes by at most twice the relative error of its weights; ten more roundings are those of
    // sums, products and A.
    let of_weights = total * (20.0 * ROUNDING + of_alpha) + of_alpha + 10.0 * ROUNDING;
    2.0 * moved + 2.0 * brightest * whole.alpha * of_weights
}

/// Asserts that an image is that of the reference; returns the median bound of pixels with fragments.
#[track_caller]
fn assert_like(image: &Image, wanted: &ReferencePicture, bounds: &[Option<f64>], what: &Method) -> f64 {
    for (pixel, (found, wanted)) in image.rgba.iter().zip(&wanted.rgba).enumerate() {
        let Some(bound) = bounds[pixel] else { continue };
        let off = found.iter().zip(wanted).map(|(a, b)| (f64::from(*a) - b).abs()).fold(0.0, f64::max);
        assert!(
            off <= bound && found.iter().all(|v| v.is_finite()),
            "{pixel}: {found:?} {wanted:?}, {bound}: {what:?}"
        );
    }
    let mut known: Vec<f64> = bounds.iter().flatten().copied().filter(|bound| *bound > 0.0).collect();
    known.sort_by(f64::total_cmp);
    known[known.len() / 2]
}

/// Errors of flat discs: a depth is rounded once or twice. The polynomial of the falloff and its argument have some ten
/// roundings. An oriented disc adds a slope of at most some hundred to a few roundings.
pub(crate) fn off(discs: &Discs) -> impl Fn(&Fragment) -> Off {
    let depth = if discs.shape == DiscShape::Oriented { 2e-5 } else { 2.0 * ROUNDING };
    let alpha = if discs.falloff == Falloff::Gaussian { 2e-5 } else { ROUNDING };
    move |_| Off { depth, alpha }
}

/// True where roundings decide whether a fragment is too faint for a front.
fn is_at_gate(list: &[Fragment], method: &Method) -> bool {
    let Method::Hybrid(Hybrid { core_alpha_min, .. }) = method else { return false };
    list.iter().any(|f| (f.alpha / f64::from(*core_alpha_min) - 1.0).abs() < 2e-5)
}

fn shapes() -> impl Iterator<Item = Discs> {
    SHAPES.into_iter().flat_map(|shape| FALLOFFS.map(|falloff| Discs { shape, falloff, ..Discs::default() }))
}

#[test]
fn soups_and_crossing_discs_are_those_of_the_reference() {
    with_device(|device| {
        let size = [36, 28];
        let mixed = [soup(3, 700, 0.02..0.15, 0.0..1.0, true), soup(4, 30, 0.2..2.0, 0.05..0.4, true)].concat();
        for (i, camera) in [perspective(), orthographic()].into_iter().enumerate() {
            // Shapes by turns with falloffs: every pair of camera, shape, falloff and method.
            for (_, discs) in shapes().enumerate().filter(|(n, _)| (n + n / 2 + i) % 2 == 0) {
                let points = scene(&safe(&mixed, &camera, size, discs.shape));
                let (lists, colors) = (lists(View::new(&camera, size), &points, &discs), colors(&points));
                assert!(lists.iter().map(Vec::len).max() > Some(9));
                for method in methods(discs) {
                    let image = render(device, &points, &frame(camera, size, method));
                    let wanted = approximate::render(View::new(&camera, size), &points, &colors, &method).expect("one");
                    let of = |list: &Vec<Fragment>| bound(list, &colors, &camera, &method, off(&discs));
                    let bounds: Vec<_> =
                        lists.iter().map(|list| (!is_at_gate(list, &method)).then(|| of(list))).collect();
                    assert!(bounds.iter().flatten().count() > bounds.len() - 10, "nearly all pixels are compared");
                    let median = assert_like(&image, &wanted, &bounds, &method);
                    println!("{method:?}: median bound {median:e}");
                    assert!(median < 2e-2, "a bound that says something: {median}");
                    assert_eq!(image.fragments.as_deref(), Some(&wanted.counts[..]), "{method:?}");
                    for (found, wanted) in image.depth.iter().zip(&wanted.depth) {
                        let close = (f64::from(*found) - wanted).abs() <= 2e-5 * wanted.abs();
                        assert!(close || (found.is_infinite() && wanted.is_infinite()), "{method:?}: {found} {wanted}");
                    }
                }
            }
        }
    });
}

/// A point that covers one pixel of [`pixel_camera`].
fn dot(depth: f64, color: Vec3, opacity: f32) -> P {
    P { position: at_pixel(0.5, 0.5, depth), color, opacity, radius: 0.0, normal: Vec3::ZERO }
}

fn near_camera() -> Camera {
    Camera { near: 1.0, far: 1024.0, ..pixel_camera([1, 1]) }
}

fn one_pixel(device: &Device, layers: &[P], method: Method) -> [f64; 4] {
    let image = render(device, &scene(layers), &frame(near_camera(), [1, 1], method));
    image.rgba[0].map(f64::from)
}

/// Lists whose moments are near singular, and long ones: their depths are floats.
fn stacks() -> Vec<(&'static str, Vec<P>)> {
    let mut r = random(5);
    let mut color = move || Vec3::new(r.random(), r.random(), r.random());
    let mut layers =
        |depths: &[f64], opacity: f32| -> Vec<P> { depths.iter().map(|depth| dot(*depth, color(), opacity)).collect() };
    let even: Vec<f64> = (0..16).map(|i| 1.0 + 4.0 * f64::from(i)).collect();
    // On few levels, as a bound asks what moving each does.
    let many: Vec<f64> = (0..10_000).map(|i| 1.0 + 8.0 * f64::from(i % 100)).collect();
    vec![
        ("one depth", layers(&[7.0], 0.4)),
        ("two equal depths", layers(&[7.0, 7.0], 0.4)),
        (
            "five times three depths",
            layers(&[3.0, 3.0, 3.0, 3.0, 3.0, 17.0, 17.0, 17.0, 17.0, 17.0, 90.0, 90.0, 90.0, 90.0, 90.0], 0.1),
        ),
        ("near and far", layers(&[1.0, 1024.0], 0.4)),
        ("near, middle and far", layers(&[1.0, 32.0, 1024.0], 0.4)),
        ("close together", layers(&[7.0, 7.0625, 7.125, 7.25], 0.3)),
        ("sixteen", layers(&even, 0.2)),
        ("opaque", layers(&even, 1.0)),
        ("faint", layers(&even, 1e-20)),
        ("ten thousand faint", layers(&many, 1e-4)),
        ("ten thousand opaque", layers(&many, 1.0)),
    ]
}

#[test]
fn near_singular_moments_and_long_lists() {
    with_device(|device| {
        let camera = near_camera();
        for (name, layers) in stacks() {
            let points = scene(&layers);
            let (list, colors) = (&lists(View::new(&camera, [1, 1]), &points, &Discs::default())[0], colors(&points));
            for method in methods(Discs::default()) {
                let found = one_pixel(device, &layers, method);
                let wanted = composed(list, &colors, &camera, &method);
                // Depths and opacities are floats as they are.
                let exact = |_: &Fragment| Off { depth: 0.0, alpha: ROUNDING };
                let bound = bound(list, &colors, &camera, &method, exact);
                for (found, wanted) in found.iter().zip(wanted.color.extend(wanted.alpha).to_array()) {
                    let off = (found - wanted).abs();
                    assert!(off <= bound, "{name}: {found} {wanted}, {off} over {bound}: {method:?}");
                }
            }
        }
    });
}

/// Asserts that a pixel is that of exact composition, but for what float32 does to depths, and for what the method's
/// bias does.
#[track_caller]
fn assert_exact(device: &Device, layers: &[P], points: &Points, method: Method) {
    let camera = near_camera();
    let (list, colors) = (&lists(View::new(&camera, [1, 1]), points, &Discs::default())[0], colors(points));
    let (exact, own) = (composite(list, &colors), composed(list, &colors, &camera, &method));
    let biased = (exact.color - own.color).abs().max_element();
    let rounded = bound(list, &colors, &camera, &method, |_| Off { depth: ROUNDING, alpha: ROUNDING });
    assert!(biased + rounded < 2e-4, "{}: {biased} {rounded}: {method:?}", list.len());
    for (found, wanted) in one_pixel(device, layers, method).iter().zip(exact.color.extend(exact.alpha).to_array()) {
        assert!((found - wanted).abs() <= biased + rounded, "{}: {found} {wanted}: {method:?}", list.len());
    }
}

#[test]
fn few_fragments_are_exact() {
    with_device(|device| {
        let mut r = random(8);
        for count in MomentCount::ALL {
            let most = count.get() / 2 + 1;
            for n in 1..=most {
                let layers: Vec<P> = (0..n)
                    .map(|i| {
                        dot(
                            2f64.powi(1 + 2 * i as i32),
                            Vec3::new(r.random(), r.random(), r.random()),
                            r.random_range(0.2..0.8),
                        )
                    })
                    .collect();
                let points = scene(&layers);
                let method = Method::Moments(Moments {
                    moments: count,
                    overestimation: 0.0,
                    bias: Some(1e-8),
                    ..Moments::default()
                });
                assert_exact(device, &layers, &points, method);
            }
        }
        // At the edges of 15 cells from 1 to 2^10.
        for rank in 1..=5 {
            let last = (2u32 << rank) - 1;
            let layers: Vec<P> = (0..=last)
                .map(|i| {
                    dot(
                        1024f64.powf(f64::from(i) / f64::from(last)),
                        Vec3::new(r.random(), r.random(), r.random()),
                        0.2,
                    )
                })
                .collect();
            assert_exact(device, &layers, &scene(&layers), by_wavelets(Discs::default(), rank));
        }
    });
}

#[test]
fn opacities_of_0_and_1() {
    with_device(|device| {
        for method in methods(Discs::default()) {
            let clear = [dot(1.0, Vec3::X, 0.0), dot(2.0, Vec3::Y, 0.0)];
            let image = render(device, &scene(&clear), &frame(near_camera(), [1, 1], method));
            assert_eq!((image.rgba[0], image.depth[0]), ([0.0; 4], f32::INFINITY), "{method:?}");
            // One fragment is what it is, opaque or not.
            for opacity in [1.0, 0.3, 1e-20] {
                let color = Vec3::new(0.7, 0.2, 0.1);
                let image = render(device, &scene(&[dot(3.0, color, opacity)]), &frame(near_camera(), [1, 1], method));
                for (a, b) in image.rgba[0].iter().zip((opacity * color.extend(1.0)).to_array()) {
                    assert!((a - b).abs() <= 4.0 * f32::EPSILON * b, "{method:?}: {:?}, {opacity}", image.rgba[0]);
                }
                assert_eq!(image.depth[0], 3.0);
            }
            // In front of everything lies something without opacity.
            let mixed = [dot(1.0, Vec3::ONE, 0.0), dot(2.0, Vec3::X, 1.0), dot(4.0, Vec3::X, 0.5)];
            let image = render(device, &scene(&mixed), &frame(near_camera(), [1, 1], method));
            let [red, green, _, a] = image.rgba[0];
            assert_eq!((a, green, image.depth[0]), (1.0, 0.0, 2.0), "{method:?}");
            assert!((red - 1.0).abs() < 1e-6, "{method:?}: {red}");
        }
    });
}

#[test]
fn neither_order_of_input_nor_windows_nor_runs_over_a_tile_change_a_byte() {
    with_device(|device| {
        let size = [32, 32];
        // Every tile has some 2500 splats, of which a run takes 1024 or 2048; depths on few levels, so that there are
        // ties.
        let mut soup = [soup(41, 2300, 2.0..3.0, 0.001..0.02, true), soup(42, 300, 0.0..0.1, 0.1..0.9, true)].concat();
        for p in &mut soup {
            p.position = (p.position * 16.0).round() / 16.0;
        }
        let points = scene(&soup);
        let mut shuffled = soup.clone();
        shuffled.shuffle(&mut random(1));
        let shuffled = scene(&shuffled);
        let oriented = Discs { shape: DiscShape::Oriented, falloff: Falloff::Gaussian, ..Discs::default() };
        let flat = Discs::default();
        let all = [
            by_moments(flat, MomentCount::Four),
            by_moments(oriented, MomentCount::Eight),
            by_wavelets(oriented, 3),
            by_wavelets(flat, 5),
            behind(flat, 11, 0.0, MomentCount::Four),
            behind(oriented, 11, 0.01, MomentCount::Six),
        ];
        for method in all {
            let mut renderer = Renderer::new(device).expect("a renderer");
            let mut cloud = renderer.upload(&points).expect("fits");
            let mut frame = frame(perspective(), size, method);
            let whole = renderer.render(&mut cloud, &frame).expect("renders");
            let accumulated = whole
                .profile
                .timeline
                .iter()
                .filter(|(time, _)| ["/accumulate", "/weigh"].iter().any(|stage| time.name.ends_with(stage)))
                .count();
            assert!(accumulated > 1 && whole.facts.windows == 1, "{:?}", whole.facts);
            assert!(bits(&render(device, &shuffled, &frame)) == bits(&whole.image), "{method:?}: shuffled");
            frame.fragments = false;
            frame.memory_budget = Some(100 << 10);
            let named = match renderer.render(&mut cloud, &frame) {
                Err(Error::SortOverBudget { budget, .. }) => budget,
                other => panic!("expected the sort over budget, got {:?}", other.map(|r| r.facts)),
            };
            let mut cuts = 0;
            for budget in [named, named * 3 / 2] {
                frame.memory_budget = Some(budget);
                let cut = renderer.render(&mut cloud, &frame).expect("the budget that the error names does");
                cuts += usize::from(cut.facts.windows > 1);
                assert!(bits(&cut.image) == bits(&whole.image), "{method:?}, budget {budget}: {:?}", cut.facts);
            }
            assert!(cuts > 0, "{method:?}: some budget cuts the image");
        }
    });
}

#[test]
fn nothing_in_view_is_nothing() {
    with_device(|device| {
        let behind =
            P { position: perspective().eye * 2.0, color: Vec3::ONE, opacity: 1.0, radius: 1.0, normal: Vec3::ZERO };
        for method in methods(Discs::default()) {
            let found = rendered(device, &scene(&[behind; 3]), &frame(perspective(), [64, 48], method));
            assert!(found.image.rgba.iter().all(|c| *c == [0.0; 4]), "{method:?}");
            assert!(found.image.depth.iter().all(|z| *z == f32::INFINITY), "{method:?}");
            assert_eq!((found.facts.visible, found.facts.bands), (0, 0));
        }
    });
}

/// Errors of a pixel's Gaussians by their indices, where neither coverage nor depth is a matter of chance; `None`
/// elsewhere.
fn gaussian_offs(points: &Points, frame: &Frame, settings: &GaussianSettings) -> Vec<Option<Vec<(u32, Off)>>> {
    let mut pixels = vec![Some(Vec::new()); (frame.size[0] * frame.size[1]) as usize];
    for index in 0..points.len() {
        let gaussian = gaussians::gaussian(points, index).expect("a Gaussian");
        // The depth that an image shows, whatever the order.
        let order = match settings.order {
            Some(Order::Center | Order::Distance) => Order::Center,
            _ => Order::Pixel,
        };
        for found in
            gaussians::possible(View::new(&frame.camera, frame.size), &gaussian, settings, order, 0..frame.size[1])
        {
            let pixel = &mut pixels[(found.y * frame.size[0] + found.x) as usize];
            let relative = |low: f64, high: f64| (high - low) / low;
            let off =
                Off { depth: relative(found.z.low, found.z.high), alpha: relative(found.alpha.low, found.alpha.high) };
            match pixel {
                Some(offs) if found.sure => offs.push((index as u32, off)),
                _ => *pixel = None,
            }
        }
    }
    pixels
}

#[test]
fn gaussians_are_those_of_the_reference() {
    with_device(|device| {
        let size = [48, 36];
        let soup = Soup { seed: 51, count: 80, degree: 1, ..Soup::default() };
        let points = soup.points();
        let mut places: Vec<u32> = (0..80).collect();
        places.shuffle(&mut random(1));
        let shuffled = order::canonical(soup.unordered().subset(&places, 1.0));
        for order in [Order::Center, Order::Distance, Order::Pixel] {
            let settings = GaussianSettings { order: Some(order), ..Default::default() };
            let discs = Discs { gaussians: settings, ..Discs::default() };
            let moments = |count| by_moments(discs, count);
            let tail = behind(discs, 2, 0.0, MomentCount::Four);
            for method in [moments(MomentCount::Four), moments(MomentCount::Six), by_wavelets(discs, 3), tail] {
                let frame = Frame { color: ColorSpace::Encoded, ..frame(perspective(), size, method) };
                let image = render(device, &points, &frame);
                assert!(bits(&render(device, &shuffled, &frame)) == bits(&image), "{method:?}: shuffled");
                let colors = shading::shade(&points, &frame.camera, &Shading::NONE, frame.color);
                let wanted =
                    approximate::render(View::new(&frame.camera, size), &points, &colors, &method).expect("one");
                let lists = lists(View::new(&frame.camera, size), &points, &discs);
                let offs = gaussian_offs(&points, &frame, &settings);
                let bounds: Vec<Option<f64>> = lists
                    .iter()
                    .zip(&offs)
                    .map(|(list, offs)| {
                        let offs = offs.as_ref()?;
                        let shown = gaussians::with_depths(&frame.camera, &points, &settings, list);
                        let of = |f: &Fragment| offs.iter().find(|(index, _)| *index == f.index).map(|(_, off)| *off);
                        let known = shown.iter().all(|f| of(f).is_some());
                        // Colors by harmonics have some 200 roundings.
                        let of_colors = 400.0 * ROUNDING;
                        known.then(|| {
                            of_colors
                                + bound(&shown, &colors, &frame.camera, &method, |f| {
                                    of(f).unwrap_or(Off { depth: 1.0, alpha: 1.0 })
                                })
                        })
                    })
                    .collect();
                let sure = bounds.iter().flatten().count();
                let median = assert_like(&image, &wanted, &bounds, &method);
                println!("{method:?}: {sure} pixels, median bound {median:e}");
                assert!(sure > 600 && median < 5e-2, "{sure} pixels, {median}");
            }
        }
    });
}
