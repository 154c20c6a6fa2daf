//! Lists with Gaussians that end early (`stop`): by hand, against the float64 reference, the same bytes by every exact
//! method where lists are short and by both sorts where they are long, through all runs of `sorted`, and not where
//! nothing is a Gaussian.

use glam::{DVec3, Quat, Vec3};
use pellucid_core::camera::Camera;
use pellucid_core::camera::Projection::Orthographic;
use pellucid_core::cloud::gaussians::{Gaussians, REACH};
use pellucid_core::image::Image;
use pellucid_core::points::Points;
use pellucid_engine::methods::Frame;
use pellucid_gpu::Device;
use pellucid_reference::View;
use pellucid_reference::{self as reference, ReferencePicture};
use pellucid_scene::prepare::order;
use pellucid_scene::{ColorSpace, Discs, GaussianSettings, Hybrid, LongLists, Method, Order, Peel, Shading};
use pellucid_testing::gaussians::Soup;
use pellucid_testing::*;

/// Odd, so that the middle pixel's center is in the middle.
const SIZE: [u32; 2] = [9, 9];
const MIDDLE: usize = 40;

/// Looks down −Z at the origin from 10 away.
fn camera() -> Camera {
    Camera::look_at(10.0 * DVec3::Z, DVec3::ZERO, DVec3::Y, Orthographic { height: 2.0 }, 0.1, 100.0).expect("valid")
}

/// Balls behind one another before [`camera`], so large that each covers the image almost evenly: depth, opacity and
/// color of each.
fn row(balls: &[(f64, f32, Vec3)]) -> Points {
    let count = balls.len();
    let gaussians = Gaussians {
        extents: vec![Vec3::splat(20.0); count],
        rotations: vec![Quat::IDENTITY; count],
        bases: balls.iter().map(|ball| ball.2).collect(),
        ..Gaussians::default()
    };
    order::canonical(Points {
        positions: balls.iter().map(|ball| (10.0 - ball.0) * DVec3::Z).collect(),
        colors: balls.iter().map(|ball| ball.2).collect(),
        opacities: balls.iter().map(|ball| ball.1).collect(),
        radii: vec![REACH * 20.0; count],
        gaussians: Some(gaussians),
        ..Points::default()
    })
}

/// Ordered by centers, which all methods can; ends at so little opacity that thousands of fragments are faint enough.
fn ending(stop: f32) -> Discs {
    let gaussians =
        GaussianSettings { order: Some(Order::Center), alpha_min: 1e-6, stop, ..GaussianSettings::default() };
    Discs { gaussians, ..Discs::default() }
}

fn methods(discs: Discs) -> Vec<Method> {
    let in_place = Discs { long_lists: LongLists::InPlace, ..discs };
    let peel = Method::Peel(Peel { discs, ..Peel::default() });
    vec![Method::ABuffer(discs), Method::ABuffer(in_place), Method::LinkedList(discs), peel, Method::Sorted(discs)]
}

fn asked(camera: Camera, size: [u32; 2], method: Method) -> Frame {
    Frame { color: ColorSpace::Encoded, depths: true, ..frame(camera, size, method) }
}

fn wanted(points: &Points, frame: &Frame, discs: &Discs) -> ReferencePicture {
    let colors = reference::shading::shade(points, &frame.camera, &Shading::NONE, frame.color);
    reference::abuffer::render(View::new(&frame.camera, frame.size), points, &colors, discs)
}

/// A, first, median and mean depth of the middle pixel.
fn middle(image: &Image) -> [f64; 4] {
    let [median, mean] =
        [&image.depth_median, &image.depth_mean].map(|depths| depths.as_ref().expect("asked for")[MIDDLE]);
    [image.rgba[MIDDLE][3], image.depth[MIDDLE], median, mean].map(f64::from)
}

#[track_caller]
fn assert_middle(image: &Image, wanted: [f64; 4], what: &str) {
    let found = middle(image);
    let close = |(a, b): (&f64, &f64)| a == b || (a - b).abs() <= 2e-4 * b.abs();
    assert!(found.iter().zip(&wanted).all(close), "{what}: {found:?}, not {wanted:?}");
}

#[test]
fn ends_by_hand() {
    with_device(|device| {
        let points = row(&[(2.0, 0.5, Vec3::X), (3.0, 0.5, Vec3::Y), (4.0, 0.5, Vec3::Z)]);
        let infinity = f64::INFINITY;
        let cases = [
            // 1/2, 1/4 and 1/8 of the light are left; as little as the share itself may be left.
            (0.0, [0.875, 2.0, 2.0, (1.0 + 0.75 + 0.5) / 0.875]),
            (0.125, [0.875, 2.0, 2.0, (1.0 + 0.75 + 0.5) / 0.875]),
            (0.13, [0.75, 2.0, 2.0, 1.75 / 0.75]),
            (0.25, [0.75, 2.0, 2.0, 1.75 / 0.75]),
            (0.3, [0.5, 2.0, 2.0, 2.0]),
            (0.5, [0.5, 2.0, 2.0, 2.0]),
            (0.6, [0.0, infinity, infinity, infinity]),
        ];
        for (stop, wanted) in cases {
            for method in methods(ending(stop)) {
                let image = render(device, &points, &asked(camera(), SIZE, method));
                assert_middle(&image, wanted, &format!("{} {stop}", method.name()));
                assert_eq!(image.fragments.as_ref().map(|all| all[MIDDLE]), Some(3), "lists have their whole length");
                let layers = [0.0, 0.5, 0.75, 0.875].iter().position(|a| *a == wanted[0]).map(|n| n as u32);
                let blended = image.layers.as_ref().map(|all| all[MIDDLE]);
                assert!(blended.is_none() || blended == layers, "{blended:?} layers, not {layers:?}");
            }
        }
    });
}

#[test]
fn an_end_in_any_run_of_a_long_list() {
    with_device(|device| {
        let depth = |n: i32| 1.0 + 0.02 * f64::from(n);
        let balls: Vec<_> = (1..=900).map(|n| (depth(n), 0.01, Vec3::new(1.0, 0.5, 0.001 * n as f32))).collect();
        let points = row(&balls);
        for stop in [0.3f32, 0.05, 0.01, 1e-3, 1e-4] {
            // 0.99^n is less than the share from here on: after 119, 298, 458, 687 and all.
            let count = (f64::from(stop).ln() / 0.99f64.ln()).floor().min(900.0) as i32;
            let left = |n: i32| 0.99f64.powi(n);
            let sum: f64 = (1..=count).map(|n| depth(n) * 0.01 * left(n - 1)).sum();
            let alpha = 1.0 - left(count);
            let wanted = [alpha, depth(1), depth(69), sum / alpha];
            for method in methods(ending(stop)) {
                let image = render(device, &points, &asked(camera(), SIZE, method));
                assert_middle(&image, wanted, &format!("{method:?} {stop}"));
            }
        }
        // Behind more than a half nothing is half left.
        let frame = asked(camera(), SIZE, Method::ABuffer(ending(0.55)));
        let found = middle(&render(device, &points, &frame));
        assert!(
            found[0] < 0.45 && found[1].is_finite() && found[2] == f64::INFINITY && found[3].is_finite(),
            "{found:?}"
        );
    });
}

/// The places of `strong` among faint ones: a weak and a strong one, of which the second is where the list ends.
/// Without a memory of that the faint ones behind would be added.
fn broken(strong: usize, count: usize) -> Points {
    let opacity = |i: usize| match i {
        _ if i == strong => 0.3,
        _ if i == strong + 1 => 0.6,
        _ => 0.0002,
    };
    let ball = |i: usize| (1.0 + 0.001 * i as f64, opacity(i), Vec3::new((i % 2) as f32, 0.3, (i % 5) as f32 / 5.0));
    row(&(0..count).map(ball).collect::<Vec<_>>())
}

#[test]
fn an_end_holds_in_all_later_runs() {
    with_device(|device| {
        // Of 2048 splats in `sorted`, of 256 fragments in lists: the end is in the first run, in the second of three,
        // and in the last one.
        for (strong, count) in [(1000, 5000), (2500, 5000), (4500, 5000), (100, 700), (300, 700)] {
            let points = broken(strong, count);
            let discs = ending(0.25);
            let frame = |method| Frame { depths: false, ..asked(camera(), [8, 8], method) };
            let exact = wanted(&points, &frame(Method::ABuffer(discs)), &discs);
            for method in methods(discs) {
                // Of peeling the shorter lists are enough.
                if matches!(method, Method::Peel(_)) && count > 1000 {
                    continue;
                }
                let image = render(device, &points, &frame(method));
                let (largest, _) = difference(&image, &exact, 0.0);
                assert!(largest < 2e-4, "{method:?}, {strong} of {count}: {largest}");
                let alphas = image.rgba.iter().map(|pixel| pixel[3]);
                assert!(alphas.clone().all(|a| a.is_sign_positive() && a < 0.75), "{:?}", alphas.collect::<Vec<_>>());
            }
        }
    });
}

#[test]
fn soups_that_end_early_have_the_same_bytes_and_are_those_of_the_reference() {
    with_device(|device| {
        let size = [60, 45];
        let points = Soup { seed: 81, count: 400, degree: 1, ..Soup::default() }.points();
        for order in [Order::Center, Order::Distance, Order::Pixel] {
            for stop in [1e-4, 0.03, 0.6] {
                let gaussians = GaussianSettings { order: Some(order), stop, ..GaussianSettings::default() };
                let discs = Discs { gaussians, ..Discs::default() };
                let frame = asked(perspective(), size, Method::ABuffer(discs));
                let first = render(device, &points, &frame);
                // Orders and ends that roundings decide.
                let (_, share) = difference(&first, &wanted(&points, &frame, &discs), 1e-4);
                assert!(share < 0.03, "{order:?} {stop}: {share}");
                let without = Discs { gaussians: GaussianSettings { stop: 0.0, ..gaussians }, ..discs };
                let whole = render(device, &points, &Frame { method: Method::ABuffer(without), ..frame });
                let ended = whole.rgba.iter().zip(&first.rgba).filter(|(whole, ended)| whole[3] > ended[3]).count();
                assert!(ended > if stop < 0.01 { 0 } else { 100 }, "{order:?} {stop}: {ended} pixels end early");
                let mut others = methods(discs);
                others.retain(|method| order != Order::Pixel || !matches!(method, Method::Sorted(_)));
                for method in others {
                    let tight = render(device, &points, &Frame { method, memory_budget: Some(1 << 19), ..frame });
                    assert!(bits(&tight) == bits(&first), "{method:?} in 512 KiB");
                    if method == frame.method {
                        continue;
                    }
                    let other = render(device, &points, &Frame { method, ..frame });
                    assert!(bits(&other) == bits(&first), "{method:?}");
                    assert!(other.depth_median == first.depth_median && other.depth_mean == first.depth_mean);
                }
            }
        }
    });
}

fn same(device: &Device, points: &Points, method: impl Fn(Discs) -> Method) -> bool {
    let [a, b] = [0.0, 0.5].map(|stop| {
        let gaussians = GaussianSettings { stop, ..GaussianSettings::default() };
        render(device, points, &frame(perspective(), [40, 30], method(Discs { gaussians, ..Discs::default() })))
    });
    bits(&a) == bits(&b)
}

#[test]
fn only_lists_with_gaussians_end() {
    with_device(|device| {
        let discs_alone = scene(&soup(82, 300, 0.05..0.3, 0.2..0.9, true));
        let splats = Soup { seed: 83, ..Soup::default() }.points();
        assert!(same(device, &discs_alone, Method::ABuffer) && same(device, &discs_alone, Method::Sorted));
        assert!(same(device, &splats, Method::Weighted));
        assert!(same(device, &splats, |discs| Method::Hybrid(Hybrid { discs, ..Hybrid::default() })));
        assert!(
            !same(device, &splats, Method::ABuffer)
                && !same(device, &splats, |discs| {
                    let center = GaussianSettings { order: Some(Order::Center), ..discs.gaussians };
                    Method::Sorted(Discs { gaussians: center, ..discs })
                })
        );
    });
}
