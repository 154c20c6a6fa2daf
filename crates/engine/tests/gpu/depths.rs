//! Mean and median depths of lists of fragments: against the float64 reference, by hand, the same bytes by every exact
//! method and budget, and at no cost where nobody asks. Medians of discs are also in `edl`, Gaussians in `gaussians`.

use glam::Vec3;
use pellucid_core::image::Image;
use pellucid_core::points::Points;
use pellucid_engine::methods::{Frame, Renderer};
use pellucid_gpu::Device;
use pellucid_reference::View;
use pellucid_reference::abuffer::{self, Fragment};
use pellucid_reference::range::ROUNDING;
use pellucid_scene::{DiscShape, Discs, Edl, LongLists, Method, Peel, Shading};
use pellucid_testing::*;

fn asked(frame: &Frame) -> Frame {
    Frame { depths: true, ..*frame }
}

/// Median and mean depths of an image, as bits.
#[track_caller]
fn depth_bits(image: &Image) -> [Vec<u32>; 2] {
    [&image.depth_median, &image.depth_mean].map(|depths| {
        let depths = depths.as_ref().expect("the method has these depths");
        depths.iter().map(|z| z.to_bits()).collect()
    })
}

fn peeled(discs: Discs) -> Method {
    Method::Peel(Peel { discs, layers: 0 })
}

/// Points before each other, some of them larger than a tile.
fn mixed() -> Vec<P> {
    [soup(1, 500, 0.02..0.1, 0.2..1.0, true), soup(2, 5, 0.3..1.0, 0.2..1.0, true)].concat()
}

/// Some layers on each pixel, and on pixels of the middle hundreds.
fn layers() -> Vec<P> {
    let faint = |points: Vec<P>, most: f32| {
        points.into_iter().map(|p| P { opacity: p.opacity * most, ..p }).collect::<Vec<_>>()
    };
    [faint(soup(3, 600, 0.05..0.3, 0.0..1.0, true), 0.6), faint(soup(4, 800, 0.5..0.8, 0.0..1.0, true), 0.01)].concat()
}

/// Piles of 800 small discs on a few pixels of [`pixel_camera`], so that there are three runs of long lists.
fn piles() -> Vec<P> {
    let all = soup(6, 3200, 0.0..0.4, 0.0..0.02, true);
    let place = |(i, p): (usize, P)| {
        let (column, row) = (0.5 + (i % 2) as f64, 0.5 + (i / 2 % 2) as f64);
        let at = at_pixel(column + 0.2 * p.position.x, row + 0.2 * p.position.y, 4.0 + 2.0 * p.position.z);
        P { position: at.as_vec3().as_dvec3(), ..p }
    };
    all.into_iter().enumerate().map(place).collect()
}

/// How far float32 may be off in the mean depth of a list. It is Σ wz / Σ w, with the same weights above and below, so
/// that an error of weights only moves it within the list's own span of depths: a weight has the relative errors of its
/// opacity (16 roundings with a falloff) and of T, which is 1 − A, where A has a rounding for each fragment and the
/// errors of the weights in front. Two sums of n numbers have n roundings each, those of the runs' parts 2 more. A
/// depth has a relative error of 1e-5 where a ray meets a tilted disc at a small angle, as `safe` leaves some.
fn slack(list: &[Fragment]) -> f64 {
    let (n, opacities) = (list.len() as f64, list.iter().map(|f| f.alpha).sum::<f64>());
    let depths = || list.iter().map(|f| f.z);
    let (near, far) = (depths().fold(f64::INFINITY, f64::min), depths().fold(f64::NEG_INFINITY, f64::max));
    let weights = (n + 3.0) * opacities + 16.0 * (1.0 + opacities);
    2.0 * (far - near) * weights * ROUNDING + far.abs() * (2.0 * (n + 4.0) * ROUNDING + 1e-5)
}

#[test]
fn means_are_those_of_the_reference() {
    with_device(|device| {
        let (size, small) = ([40, 30], [3, 2]);
        let mut longest = 0;
        for (i, discs) in all_discs().filter(|discs| discs.raster == RASTERS[0]).enumerate() {
            let cases = [
                (perspective(), size, mixed()),
                (orthographic(), size, layers()),
                (pixel_camera(small), small, piles()),
            ];
            for (j, (camera, size, points)) in cases.into_iter().enumerate() {
                let points = scene(&safe(&points, &camera, size, discs.shape));
                let lists = abuffer::lists(View::new(&camera, size), &points, &discs);
                longest = longest.max(lists.iter().map(Vec::len).max().unwrap_or(0));
                // By turns: every pair of discs, points and method.
                let method = [Method::ABuffer(discs), Method::LinkedList(discs), peeled(discs)][(i + j) % 3];
                let image = render(device, &points, &asked(&frame(camera, size, method)));
                let found = image.depth_mean.expect("a mean depth");
                for (pixel, list) in lists.iter().enumerate() {
                    let (z, wanted) = (f64::from(found[pixel]), abuffer::mean_depth(list));
                    let (name, slack) = (method.name(), slack(list));
                    let close = z == wanted || (z - wanted).abs() <= slack;
                    assert!(close, "{name} {discs:?}, pixel {pixel}: {z}, not {wanted}, {slack} allowed");
                    assert!(slack < 0.02 || list.is_empty(), "{slack} says nothing of depths from 2 to 6");
                }
            }
        }
        assert!(longest > 512, "{longest}: three runs");
    });
}

#[test]
fn depths_by_hand() {
    with_device(|device| {
        let at = |depth: f64, opacity: f32, x: f64| P {
            position: at_pixel(x, 0.5, depth),
            color: Vec3::ONE,
            opacity,
            radius: 0.0,
            normal: Vec3::ZERO,
        };
        let columns: [Vec<P>; 5] = [
            // Half of the light at 2, a quarter at 4, and A is 3/4: (1 + 1) / 0.75.
            vec![at(2.0, 0.5, 0.5), at(4.0, 0.5, 0.5)],
            // A fragment without opacity is nowhere, and nothing is behind an opaque one.
            vec![at(1.0, 0.0, 1.5), at(3.0, 1.0, 1.5), at(9.0, 0.5, 1.5)],
            // T never falls to a half: a quarter at 3, 3/16 at 5, and A is 7/16.
            vec![at(3.0, 0.25, 2.5), at(5.0, 0.25, 2.5)],
            vec![at(3.0, 0.0, 3.5)],
            // 1000 layers, three in four of them in runs of their own: Σ n 0.001 0.999^(n-1) over A = 1 − 0.999^1000.
            (1..=1000).map(|n| at(f64::from(n), 0.001, 5.5)).collect(),
        ];
        let far: f64 = (1..=1000).map(|n| f64::from(n) * 0.001 * 0.999f64.powi(n - 1)).sum();
        let far = far / (1.0 - 0.999f64.powi(1000));
        let infinity = f64::INFINITY;
        let means = [2.0 / 0.75, 3.0, (0.75 + 15.0 / 16.0) / (7.0 / 16.0), infinity, infinity, far];
        let points = scene(&columns.concat());
        let discs = Discs::default();
        let in_place = Discs { long_lists: LongLists::InPlace, ..discs };
        let methods = [discs, in_place].map(Method::ABuffer);
        let others = [Method::LinkedList(discs), peeled(discs), Method::Sorted(discs)];
        for method in methods.into_iter().chain(others) {
            let image = render(device, &points, &asked(&frame(pixel_camera([6, 1]), [6, 1], method)));
            let median = image.depth_median.expect("a median depth");
            assert_eq!(median, [2.0, 3.0, f32::INFINITY, f32::INFINITY, f32::INFINITY, 693.0], "{method:?}");
            for (found, wanted) in image.depth_mean.expect("a mean depth").into_iter().zip(means) {
                let found = f64::from(found);
                assert!(found == wanted || (found - wanted).abs() < 1e-4 * wanted, "{method:?}: {found}, not {wanted}");
            }
        }
    });
}

#[test]
#[ignore = "long: every exact method and shape, with hundreds of layers"]
fn every_exact_method_and_every_budget_have_the_same_bytes() {
    with_device(|device| {
        let (points, size) = (scene(&layers()), [48, 34]);
        for shape in SHAPES {
            let discs = Discs { shape, ..Discs::default() };
            let image = render(device, &points, &asked(&frame(perspective(), size, Method::ABuffer(discs))));
            let wanted = depth_bits(&image);
            let hardware = Discs { raster: RASTERS[1], ..discs };
            let mut methods =
                vec![Method::ABuffer(hardware), Method::LinkedList(discs), peeled(discs), peeled(hardware)];
            if shape == DiscShape::Flat {
                methods.push(Method::Sorted(discs));
            }
            for method in methods {
                let other = render(device, &points, &asked(&frame(perspective(), size, method)));
                assert!(depth_bits(&other) == wanted, "{method:?}");
            }
            let budgets = [1 << 18, 1 << 17].map(|budget| {
                let of_lists = Frame { fragments: false, ..frame(perspective(), size, Method::ABuffer(discs)) };
                let lists = rendered(device, &points, &Frame { memory_budget: Some(budget), ..of_lists }).facts;
                assert!(lists.bands > 1, "{lists:?}");
                (budget, lists.peak_device_bytes)
            });
            for method in [Method::ABuffer(discs), Method::LinkedList(discs), peeled(discs)] {
                let whole = Frame { fragments: false, ..frame(perspective(), size, method) };
                let plain = rendered(device, &points, &whole);
                for (budget, lists) in budgets {
                    let tight = asked(&Frame { memory_budget: Some(budget), ..whole });
                    let cut = rendered(device, &points, &tight);
                    assert!(depth_bits(&cut.image) == wanted, "{method:?} in {budget} bytes");
                    assert!(bits(&cut.image) == bits(&plain.image), "{method:?} in {budget} bytes: the image itself");
                    let peak = cut.facts.peak_device_bytes;
                    let alone = match method {
                        Method::ABuffer(_) => lists,
                        _ => rendered(device, &points, &Frame { depths: false, ..tight })
                            .facts
                            .peak_device_bytes
                            .max(lists),
                    };
                    assert!(peak <= alone + alone / 8, "{method:?} in {budget} bytes: {peak}, alone {alone}");
                }
            }
        }
    });
}

#[test]
fn eye_dome_lighting_and_depths_go_together() {
    with_device(|device| {
        let (points, size) = (scene(&mixed()), [61, 43]);
        let edl = Edl { edl: true, edl_strength: 0.05, ..Edl::default() };
        let plain = frame(perspective(), size, Method::ABuffer(Discs::default()));
        let lit = Frame { shading: Shading { edl, ..plain.shading }, ..plain };
        let (with, without) = (render(device, &points, &asked(&lit)), render(device, &points, &lit));
        assert!(bits(&with) == bits(&without));
        assert_eq!(without.depth_median, None);
        assert_eq!(depth_bits(&with), depth_bits(&render(device, &points, &asked(&plain))));
    });
}

#[test]
fn who_does_not_ask_pays_nothing() {
    with_device(|device| {
        let (points, size) = (scene(&mixed()), [40, 30]);
        for method in [Method::ABuffer(Discs::default()), peeled(Discs::default())] {
            let plain = frame(perspective(), size, method);
            let (without, with) = (rendered(device, &points, &plain), rendered(device, &points, &asked(&plain)));
            assert_eq!((&without.image.depth_median, &without.image.depth_mean), (&None, &None));
            assert!(bits(&with.image) == bits(&without.image));
            assert!(without.profile.timeline.len() < with.profile.timeline.len());
            // The image of a frame that asks is given back, and its depths are not those of the next.
            let mut renderer = Renderer::new(device).expect("a renderer");
            let mut cloud = renderer.upload(&points).expect("the cloud fits");
            let first = renderer.render(&mut cloud, &asked(&plain)).expect("the frame renders");
            renderer.recycle(first.image);
            let second = renderer.render(&mut cloud, &plain).expect("the frame renders").image;
            assert!(second.depth_median.is_none() && second.depth_mean.is_none());
            assert!(bits(&second) == bits(&without.image));
        }
    });
}

#[test]
fn other_methods_have_none() {
    with_device(|device| {
        let points: Points = scene(&soup(5, 50, 0.05..0.2, 0.2..0.8, true));
        let oriented = Discs { shape: DiscShape::Oriented, ..Discs::default() };
        let two = Method::Peel(Peel { layers: 2, ..Peel::default() });
        let has = |device: &Device, method: Method| {
            let image = render(device, &points, &asked(&frame(perspective(), [16, 12], method)));
            assert_eq!(image.depth_median.is_some(), image.depth_mean.is_some(), "{method:?}");
            image.depth_median.is_some()
        };
        let with: Vec<_> =
            Method::all().into_iter().filter(|method| !method.is_dealt() && has(device, *method)).collect();
        let names: Vec<_> = with.iter().map(Method::name).collect();
        assert_eq!(names, ["abuffer", "linked-list", "sorted", "peel"]);
        assert!(!has(device, two) && !has(device, Method::Sorted(oriented)));
    });
}
