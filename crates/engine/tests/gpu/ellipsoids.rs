//! Gaussians as ellipsoids of constant density: each by itself and soups of them within what roundings of float32
//! leave, surfaces among them, the same bytes by slots and linked lists, and by shuffles, windows and budgets.

use glam::{DVec3, Quat, Vec3};
use pellucid_core::camera::Camera;
use pellucid_core::camera::Projection::{Orthographic, Perspective};
use pellucid_core::cloud::gaussians::Gaussians;
use pellucid_core::image::Image;
use pellucid_core::points::Points;
use pellucid_engine::methods::{Error, Frame, Renderer};
use pellucid_reference::View;
use pellucid_reference::gaussians::{self, PossibleChord, ellipsoid};
use pellucid_reference::range::{ROUNDING, Range};
use pellucid_reference::soft::Ray;
use pellucid_reference::{self as reference, ReferencePicture};
use pellucid_scene::prepare::order;
use pellucid_scene::{
    ColorSpace, Discs, GaussianSettings, Kernel, LongLists, Method, Peel, Raster, Shading, Stochastic,
};
use pellucid_testing::gaussians::Soup;
use pellucid_testing::*;
use rand::seq::SliceRandom;

pub(crate) fn settings(alpha_max: f32) -> Discs {
    let gaussians = GaussianSettings { kernel: Kernel::Ellipsoid, alpha_max, ..GaussianSettings::default() };
    Discs { gaussians, ..Discs::default() }
}

fn encoded(camera: Camera, size: [u32; 2], method: Method) -> Frame {
    Frame { color: ColorSpace::Encoded, ..frame(camera, size, method) }
}

/// Before the cube, along one of its sides, within it, and along parallel rays.
fn cameras() -> [Camera; 4] {
    let look = |eye, projection| Camera::look_at(eye, DVec3::ZERO, DVec3::Y, projection, 0.1, 100.0).expect("valid");
    let wide = Perspective { fov_y: 100f64.to_radians() };
    [
        look(DVec3::new(1.0, 1.5, 4.0), Perspective { fov_y: 45f64.to_radians() }),
        look(DVec3::new(-1.6, 0.3, 0.7), wide),
        look(DVec3::new(0.1, 0.2, 0.3), wide),
        look(DVec3::new(0.0, 3.0, 0.5), Orthographic { height: 2.0 }),
    ]
}

/// Bounds of a pixel: the opacity that roundings may leave, and how far they may move each color.
pub(crate) struct Allowed {
    pub alpha: Range,
    pub color: f64,
    pub depth: Range,
}

/// Bounds of each pixel of a picture of ellipsoids.
pub(crate) fn allowed(points: &Points, frame: &Frame, discs: &Discs, brightest: f64) -> Vec<Allowed> {
    let pixels = (frame.size[0] * frame.size[1]) as usize;
    let mut log_clear = vec![Range::only(0.0); pixels];
    let mut moved = vec![0.0; pixels];
    let mut depth = vec![Range::only(f64::INFINITY); pixels];
    let near = frame.camera.near;
    for index in 0..points.len() {
        let gaussian = gaussians::gaussian(points, index).expect("a Gaussian");
        let shortest = f64::from(points.gaussians.as_ref().expect("some").extents[index].min_element());
        let density = ellipsoid::density(gaussian.opacity, shortest, &discs.gaussians);
        for chord in gaussians::possible_chords(View::new(&frame.camera, frame.size), &gaussian, &discs.gaussians) {
            let PossibleChord { x, y, middle, half } = chord;
            let at = (y * frame.size[0] + x) as usize;
            let dense = density * Ray::new(View::new(&frame.camera, frame.size), [x, y]).stretch;
            // Cut at near, whole lengths are only shorter.
            let length = |middle: f64, half: f64| (middle + half - (middle - half).max(near)).clamp(0.0, 2.0 * half);
            let ends = [middle.low, middle.high].map(|middle| [half.low, half.high].map(|half| length(middle, half)));
            let least = ends.iter().flatten().copied().fold(f64::INFINITY, f64::min);
            let most = ends.iter().flatten().copied().fold(0.0, f64::max);
            // Roundings of the density, of the length and of the stretch.
            let own = 24.0 * ROUNDING;
            let tau = Range { low: dense * least * (1.0 - own), high: dense * most * (1.0 + own) };
            log_clear[at] = log_clear[at] + tau;
            // Where one lies among others; by itself, anywhere is the same.
            let apart =
                if points.len() > 1 { middle.high - middle.low + 2.0 * ROUNDING * middle.high.abs() } else { 0.0 };
            let shift = dense * apart;
            moved[at] += -(-(tau.high - tau.low)).exp_m1() - 2.0 * (-shift).exp_m1() + 64.0 * ROUNDING;
            let entry = Range { low: (middle.low - half.high).max(near), high: (middle.high - half.low).max(near) };
            if most > 0.0 {
                let high = if least > 0.0 { depth[at].high.min(entry.high) } else { depth[at].high };
                depth[at] = Range { low: depth[at].low.min(entry.low), high };
            }
        }
    }
    let each = log_clear.iter().zip(moved).zip(depth);
    each.map(|((tau, moved), depth)| Allowed {
        alpha: Range { low: -(-tau.low).exp_m1(), high: -(-tau.high).exp_m1() },
        color: 2.0 * brightest * moved,
        depth,
    })
    .collect()
}

/// Asserts that a picture is what roundings leave of the reference's; returns how many of its pixels are known to a
/// hundredth.
#[track_caller]
fn assert_allowed(image: &Image, wanted: &ReferencePicture, allowed: &[Allowed], what: &str) -> usize {
    let mut known = 0;
    for (pixel, allowed) in allowed.iter().enumerate() {
        let (found, wanted, depth) = (image.rgba[pixel], wanted.rgba[pixel], image.depth[pixel]);
        let fits = allowed.alpha.covers(f64::from(found[3]), 1e-6 + 0.01 * allowed.color.min(1e-4));
        assert!(fits, "{what} pixel {pixel}: {found:?}, {:?} allowed, {wanted:?}", allowed.alpha);
        for c in 0..3 {
            let off = (f64::from(found[c]) - wanted[c]).abs();
            assert!(off <= allowed.color + 1e-6, "{what} pixel {pixel}: {found:?} {wanted:?}, {}", allowed.color);
        }
        let deep = allowed.depth.covers(f64::from(depth), 1e-6 * f64::from(depth).abs());
        assert!(deep || found[3] == 0.0, "{what} pixel {pixel}: {depth}, {:?} allowed", allowed.depth);
        known += usize::from(found[3] > 0.0 && allowed.color < 1e-2);
    }
    known
}

pub(crate) fn wanted(points: &Points, frame: &Frame, discs: &Discs) -> (ReferencePicture, f64) {
    let colors = reference::shading::shade(points, &frame.camera, &Shading::NONE, frame.color);
    let brightest = colors.iter().map(|color| color.max_element()).fold(1.0, f64::max);
    (reference::abuffer::render(View::new(&frame.camera, frame.size), points, &colors, discs), brightest)
}

#[test]
fn each_ellipsoid_is_where_roundings_leave_it() {
    with_device(|device| {
        let mut renderer = Renderer::new(device).expect("a renderer");
        let discs = settings(0.99);
        let soups = [
            Soup { seed: 10, count: 24, extents: 0.1..0.3, degree: 2, ..Soup::default() },
            Soup { seed: 11, count: 12, ..Soup::default() },
            // Needles and plates, of which a ray along the plate sees nothing but density.
            Soup { seed: 12, count: 12, extents: 1e-4..1.0, ..Soup::default() },
            // Smaller than pixels.
            Soup { seed: 13, count: 6, extents: 1e-5..1e-2, ..Soup::default() },
        ];
        let mut known = 0;
        for soup in &soups {
            let points = soup.points();
            for camera in cameras() {
                let frame = encoded(camera, [64, 48], Method::ABuffer(discs));
                for index in 0..points.len() {
                    let one = points.subset(&[index as u32], 1.0);
                    let mut cloud = renderer.upload(&one).expect("the cloud fits");
                    let image = renderer.render(&mut cloud, &frame).expect("the frame renders").image;
                    let (wanted, brightest) = wanted(&one, &frame, &discs);
                    let allowed = allowed(&one, &frame, &discs, brightest);
                    known += assert_allowed(&image, &wanted, &allowed, &format!("{} {index}", soup.seed));
                }
            }
        }
        assert!(known > 5_000, "{known} pixels");
    });
}

#[test]
fn soups_are_those_of_the_reference() {
    with_device(|device| {
        for alpha_max in [0.99, 0.5] {
            let discs = settings(alpha_max);
            let soups = [
                (Soup { seed: 21, count: 120, degree: 3, extents: 0.1..0.3, ..Soup::default() }, [48, 36]),
                // Lists of more than a run.
                (Soup { seed: 22, count: 1200, extents: 0.4..1.2, opacities: 0.0..0.05, ..Soup::default() }, [12, 9]),
            ];
            for (soup, size) in soups {
                let points = soup.points();
                for camera in cameras() {
                    for color in [ColorSpace::Encoded, ColorSpace::Linear] {
                        let frame = Frame { color, ..frame(camera, size, Method::ABuffer(discs)) };
                        let frame = Frame { fragments: true, ..frame };
                        let image = render(device, &points, &frame);
                        let (wanted, brightest) = wanted(&points, &frame, &discs);
                        let allowed = allowed(&points, &frame, &discs, brightest);
                        let known = assert_allowed(&image, &wanted, &allowed, &format!("{} {color:?}", soup.seed));
                        assert!(soup.seed == 22 || known > 200, "{known} pixels of {soup:?} are known");
                        let counts = image.fragments.as_ref().expect("counted");
                        let differ = counts.iter().zip(&wanted.counts).filter(|(a, b)| a.abs_diff(**b) > 1).count();
                        // Two rims in a pixel may both be decided by roundings.
                        assert!(differ <= 2, "{differ} counts differ");
                        let longest = *counts.iter().max().expect("pixels");
                        assert!(soup.seed == 21 || longest > 128, "{longest} ellipsoids are less than a run");
                    }
                }
            }
        }
    });
}

/// Compares depths of single bodies and of lists of more than a run.
#[test]
fn depths_are_those_of_the_reference() {
    with_device(|device| {
        let soups = [
            Soup { seed: 91, count: 60, extents: 0.1..0.4, ..Soup::default() },
            Soup { seed: 92, count: 1200, extents: 0.4..1.2, opacities: 0.0..0.05, ..Soup::default() },
        ];
        for soup in soups {
            let points = soup.points();
            let discs = settings(0.99);
            for camera in cameras() {
                let frame = Frame { depths: true, ..encoded(camera, [16, 12], Method::ABuffer(discs)) };
                let image = render(device, &points, &frame);
                let plain = render(device, &points, &Frame { depths: false, ..frame });
                assert!(bits(&image) == bits(&plain) && plain.depth_median.is_none(), "asking changes nothing else");
                let (median, mean) = (image.depth_median.as_ref(), image.depth_mean.as_ref());
                let (median, mean) = (median.expect("asked for"), mean.expect("asked for"));
                let lists = ellipsoid::bodies(View::new(&camera, frame.size), &points, &discs);
                for (pixel, list) in lists.iter().enumerate() {
                    let stretch =
                        Ray::new(View::new(&camera, frame.size), [pixel as u32 % 16, pixel as u32 / 16]).stretch;
                    // Roundings and rims move T by some thousandths of itself, and means by as much of what the list
                    // goes through.
                    let slack = 2e-3;
                    let [low, high] = [1.0 + slack, 1.0 - slack].map(|s| ellipsoid::median(list, stretch, 0.5 * s));
                    let found = f64::from(median[pixel]);
                    let deep = found >= low * (1.0 - 1e-5) && (found <= high * (1.0 + 1e-5) || high.is_infinite());
                    assert!(deep, "{} pixel {pixel}: median {found}, {low} to {high}", soup.seed);
                    let wanted = ellipsoid::mean_depth(list, stretch);
                    let found = f64::from(mean[pixel]);
                    let close = (found - wanted).abs() <= 4e-3 * wanted.abs() + 4e-3;
                    let nothing = image.rgba[pixel][3] < 1e-6;
                    assert!(close || found == wanted || nothing, "{} pixel {pixel}: mean {found} {wanted}", soup.seed);
                }
                let linked = render(device, &points, &Frame { method: Method::LinkedList(discs), ..frame });
                assert_eq!((&linked.depth_median, &linked.depth_mean), (&image.depth_median, &image.depth_mean));
            }
        }
    });
}

#[test]
fn slots_and_links_budgets_and_shuffles_have_the_same_bytes() {
    with_device(|device| {
        let soup = Soup { seed: 31, count: 500, degree: 1, extents: 0.05..0.6, opacities: 0.0..0.3 };
        let mut mixed = soup.unordered();
        mixed.append(among());
        let mut places: Vec<u32> = (0..mixed.len() as u32).collect();
        places.shuffle(&mut random(1));
        let shuffled = order::canonical(mixed.subset(&places, 1.0));
        let mixed = order::canonical(mixed);
        for camera in cameras() {
            let discs = settings(0.99);
            let whole = Frame { fragments: true, ..encoded(camera, [90, 70], Method::ABuffer(discs)) };
            let first = render(device, &mixed, &whole);
            let in_place = Discs { long_lists: LongLists::InPlace, ..discs };
            let hardware = Discs { raster: Raster::Hardware, ..discs };
            let frames = [
                Frame { method: Method::LinkedList(discs), ..whole },
                Frame { method: Method::ABuffer(in_place), ..whole },
                Frame { method: Method::ABuffer(hardware), ..whole },
                Frame { method: Method::LinkedList(in_place), memory_budget: Some(1 << 20), ..whole },
                Frame { memory_budget: Some(1 << 20), ..whole },
            ];
            for frame in frames {
                let other = render(device, &mixed, &frame);
                assert!(bits(&other) == bits(&first), "{:?} in {:?} bytes", frame.method, frame.memory_budget);
                assert_eq!(other.fragments, first.fragments);
            }
            assert!(bits(&render(device, &shuffled, &whole)) == bits(&first), "shuffled");
        }
    });
}

/// Discs that stand between ellipsoids.
fn among() -> Points {
    scene(&soup(71, 60, 0.05..0.3, 0.2..0.8, true))
}

#[test]
fn surfaces_stand_among_ellipsoids() {
    with_device(|device| {
        let mut mixed = Soup { seed: 72, count: 60, degree: 1, ..Soup::default() }.unordered();
        // A third of them without thickness, a third opaque from where they begin.
        let gaussians = mixed.gaussians.as_mut().expect("Gaussians");
        gaussians.extents.iter_mut().step_by(3).for_each(|extents| extents.y = 0.0);
        mixed.opacities.iter_mut().skip(1).step_by(3).for_each(|opacity| *opacity = 1.0);
        mixed.append(among());
        let mixed = order::canonical(mixed);
        for shape in SHAPES {
            let discs = Discs { shape, ..settings(1.0) };
            for camera in cameras() {
                let frame = frame(camera, [80, 60], Method::ABuffer(discs));
                let image = render(device, &mixed, &frame);
                let (wanted, _) = wanted(&mixed, &frame, &discs);
                let (_, share) = difference(&image, &wanted, 1e-3);
                // Rims and orders that roundings decide.
                assert!(share < 0.02, "{shape:?}: {share}");
            }
        }
    });
}

/// Thinner than a step between two depths of float32, a plate has the opacity of its chord.
#[test]
fn what_is_too_thin_for_two_depths_is_a_surface() {
    with_device(|device| {
        for extent in [1e-7f32, 1e-9, 1e-12, 1e-20] {
            let gaussians = Gaussians {
                extents: vec![Vec3::new(0.5, 0.5, extent); 2],
                rotations: vec![Quat::IDENTITY; 2],
                bases: vec![Vec3::X, Vec3::Y],
                ..Gaussians::default()
            };
            let points = Points {
                positions: vec![DVec3::ZERO, -0.25 * DVec3::Z],
                colors: vec![Vec3::X, Vec3::Y],
                opacities: vec![0.5, 0.75],
                radii: vec![0.5; 2],
                gaussians: Some(gaussians),
                ..Points::default()
            };
            let discs = settings(0.99);
            let look = |projection| Camera::look_at(3.0 * DVec3::Z, DVec3::ZERO, DVec3::Y, projection, 0.1, 10.0);
            for projection in [Perspective { fov_y: 0.5 }, Orthographic { height: 1.5 }] {
                let frame = encoded(look(projection).expect("valid"), [41, 41], Method::ABuffer(discs));
                let image = render(device, &points, &frame);
                let [r, g, _, a] = image.rgba[20 * 41 + 20];
                assert!(
                    (r - 0.5).abs() < 1e-3 && (g - 0.375).abs() < 1e-3 && (a - 0.875).abs() < 1e-3,
                    "{extent}: {r} {g}"
                );
                let (wanted, _) = wanted(&points, &frame, &discs);
                // At the rim a chord is what roundings leave of it.
                let (most, share) = difference(&image, &wanted, 1e-2);
                assert!(share < 0.05, "{extent}: {most} {share}");
            }
        }
    });
}

#[test]
fn other_methods_have_no_ellipsoids() {
    with_device(|device| {
        let points = Soup::default().points();
        let mut renderer = Renderer::new(device).expect("a renderer");
        let mut cloud = renderer.upload(&points).expect("the cloud fits");
        let discs = settings(0.99);
        let methods = [
            Method::Sorted(discs),
            Method::Peel(Peel { discs, ..Peel::default() }),
            Method::Stochastic(Stochastic { discs, ..Stochastic::default() }),
            Method::Weighted(discs),
        ];
        for method in methods {
            let refused = renderer.render(&mut cloud, &encoded(perspective(), [8, 8], method)).expect_err("refused");
            let said = refused.to_string();
            assert!(matches!(refused, Error::NoEllipsoids { .. }), "{said}");
            assert!(said.contains(method.name()) && said.contains("abuffer") && said.contains("ray"), "{said}");
        }
    });
}
