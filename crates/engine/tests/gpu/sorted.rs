//! `sorted`: images against its float64 reference, and against `abuffer`, to the byte where both are exact; how far it
//! is off where discs cross; what it leaves out at the back; how windows are cut.

use std::sync::Arc;

use glam::{DVec3, Vec3};
use pellucid_core::camera::Camera;
use pellucid_core::camera::Projection::{Orthographic, Perspective};
use pellucid_core::color::{encode_srgb, encode_srgb_f64};
use pellucid_core::image::Image;
use pellucid_core::points::Points;
use pellucid_engine::methods::{Error, Frame, Renderer, Stop};
use pellucid_gpu::Device;
use pellucid_reference as reference;
use pellucid_reference::View;
use pellucid_scene::prepare::Arranged;
use pellucid_scene::{ColorSpace, DiscShape, Discs, Falloff, Method, Raster, Shading, ShadingModel};
use pellucid_testing::*;
use rand::RngExt;
use rand::seq::SliceRandom;

/// Longest list that `abuffer` composes in one go.
const IN_ONE_GO: u32 = 256;

fn all_discs() -> impl Iterator<Item = Discs> {
    SHAPES.into_iter().flat_map(|shape| FALLOFFS.map(|falloff| Discs { shape, falloff, ..Discs::default() }))
}

fn flat() -> Method {
    Method::Sorted(Discs::default())
}

fn reference(points: &Points, camera: &Camera, size: [u32; 2], discs: &Discs) -> reference::ReferencePicture {
    reference::sorted::render(View::new(camera, size), points, &colors(points), discs)
}

/// The frame by `abuffer`.
fn by_abuffer(frame: &Frame) -> Frame {
    let discs = frame.method.discs().expect("a method of discs");
    Frame { method: Method::ABuffer(*discs), ..*frame }
}

/// Asserts the bytes of `abuffer`, list lengths included, in all pixels but those whose lists are so long that it
/// composes them run by run: those differ by rounding. Returns how many have the bytes and something in them.
#[track_caller]
fn assert_same_bytes(device: &Device, points: &Points, frame: &Frame) -> usize {
    let (found, wanted) = (render(device, points, frame), render(device, points, &by_abuffer(frame)));
    assert_eq!(found.fragments, wanted.fragments);
    assert_eq!(found.depth, wanted.depth);
    let lengths = wanted.fragments.as_deref().expect("a method with lists");
    for (pixel, (a, b)) in found.rgba.iter().zip(&wanted.rgba).enumerate() {
        if lengths[pixel] <= IN_ONE_GO {
            assert_eq!(a.map(f32::to_bits), b.map(f32::to_bits), "pixel {pixel}: {a:?} {b:?}");
        } else {
            let apart = a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
            // Lists of up to 4000: as many roundings of values below 1, few of which go the same way.
            assert!(lengths[pixel] < 4000 && apart < 3e-6, "{} fragments: {apart}", lengths[pixel]);
        }
    }
    lengths.iter().filter(|n| (1..=IN_ONE_GO).contains(*n)).count()
}

#[test]
fn coverage_safe_scenes_equal_the_reference_to_3e_5() {
    with_device(|device| {
        let size = [160, 120];
        let mixed = [soup(3, 1200, 0.0..0.1, 0.0..1.0, true), soup(4, 40, 0.2..2.0, 0.05..0.4, true)].concat();
        for camera in [perspective(), orthographic()] {
            for discs in all_discs() {
                let points = scene(&safe(&mixed, &camera, size, discs.shape));
                assert!(points.len() > 600, "most points are safe: {}", points.len());
                let image = render(device, &points, &frame(camera, size, Method::Sorted(discs)));
                let wanted = reference(&points, &camera, size, &discs);
                let (largest, _) = difference(&image, &wanted, 0.0);
                assert!(largest < 3e-5, "{discs:?}: {largest}");
                assert_eq!(image.fragments.as_deref(), Some(&wanted.counts[..]), "{discs:?}");
                for (found, wanted) in image.depth.iter().zip(&wanted.depth) {
                    // A few roundings of a depth of about 5; an oriented disc adds a slope of at most some hundred.
                    let close = (f64::from(*found) - wanted).abs() <= 2e-5 * wanted.abs();
                    assert!(close || (found.is_infinite() && wanted.is_infinite()), "{found} {wanted}");
                }
            }
        }
    });
}

#[test]
fn flat_discs_have_the_bytes_of_the_abuffer() {
    with_device(|device| {
        let eye = DVec3::new(0.3, 0.2, 3.0);
        let look =
            |projection, near, far| Camera::look_at(eye, DVec3::ZERO, DVec3::Y, projection, near, far).expect("valid");
        let inside =
            Camera::look_at(DVec3::ZERO, DVec3::X, DVec3::Y, Perspective { fov_y: 1.0 }, 1e-4, 100.0).expect("valid");
        let wide = look(Perspective { fov_y: 170f64.to_radians() }, 1e-3, 1e3);
        let narrow = look(Perspective { fov_y: 1f64.to_radians() }, 0.1, 10.0);
        // Most discs reach over its borders, some cover all of it.
        let close = look(Orthographic { height: 0.5 }, -10.0, 10.0);
        let mixed = [soup(7, 900, 0.0..0.1, 0.0..1.0, true), soup(8, 25, 0.3..3.0, 0.05..0.4, true)].concat();
        let points = scene(&mixed);
        let mut compared = 0;
        for camera in [perspective(), orthographic(), inside, wide, narrow, close] {
            for size in [[131, 77], [1, 1], [1, 90], [90, 1], [16, 16], [17, 15]] {
                for falloff in FALLOFFS {
                    let discs = Discs { falloff, ..Discs::default() };
                    compared += assert_same_bytes(device, &points, &frame(camera, size, Method::Sorted(discs)));
                }
            }
        }
        assert!(compared > 50_000, "{compared} pixels with the same bytes");
        // Shading, blending of encoded values, and discs that would be tilted if they had normals.
        let mut flat = frame(perspective(), [100, 60], Method::Sorted(Discs::default()));
        flat.shading = Shading { model: ShadingModel::Phong, specular: 0.5, ..Shading::default() };
        assert_same_bytes(device, &points, &flat);
        flat.color = ColorSpace::Encoded;
        assert_same_bytes(device, &points, &flat);
        let bare: Vec<P> = mixed.iter().map(|p| P { normal: Vec3::ZERO, ..*p }).collect();
        for discs in all_discs() {
            assert_same_bytes(device, &scene(&bare), &frame(perspective(), [100, 60], Method::Sorted(discs)));
        }
    });
}

#[test]
fn many_small_splats_have_the_bytes_of_the_abuffer() {
    with_device(|device| {
        for (seed, radius, count) in [(11, 0.005..0.05, 20_000), (12, 0.0..0.01, 60_000)] {
            let points = scene(&soup(seed, count, radius, 0.05..0.95, false));
            assert_same_bytes(device, &points, &frame(perspective(), [300, 200], flat()));
        }
    });
}

#[test]
fn shuffled_input_and_a_second_run_change_no_byte() {
    with_device(|device| {
        // Depths on few levels and coincident positions: plenty of ties between different colors.
        let mut points = soup(21, 3000, 0.02..0.2, 0.1..0.9, true);
        for p in &mut points {
            p.position = (p.position * 4.0).round() / 4.0;
        }
        for discs in all_discs() {
            let frame = frame(orthographic(), [96, 96], Method::Sorted(discs));
            let first = bits(&render(device, &scene(&points), &frame));
            if discs.shape == DiscShape::Flat {
                assert_same_bytes(device, &scene(&points), &frame);
            }
            let mut shuffled = points.clone();
            for seed in 0..2 {
                shuffled.shuffle(&mut random(seed));
                assert!(bits(&render(device, &scene(&shuffled), &frame)) == first, "{discs:?}");
            }
            shuffled.reverse();
            assert!(bits(&render(device, &scene(&shuffled), &frame)) == first, "{discs:?} reversed");
            // The rasterizer, if asked for, is not asked.
            let method = Method::Sorted(Discs { raster: Raster::Hardware, ..discs });
            let met = rendered(device, &scene(&points), &Frame { method, ..frame });
            assert!(bits(&met.image) == first && met.facts.raster == "compute");
        }
    });
}

/// A point that covers one pixel of [`pixel_camera`].
fn dot(x: f64, y: f64, depth: f64, color: Vec3, opacity: f32) -> P {
    P { position: at_pixel(x, y, depth), color, opacity, radius: 0.0, normal: Vec3::ZERO }
}

#[test]
fn equal_depths_and_extreme_opacities_are_exact() {
    with_device(|device| {
        let one = |points: &[P]| render(device, &scene(points), &frame(pixel_camera([1, 1]), [1, 1], flat()));
        let layer = |depth: f64, color: Vec3, opacity: f32| dot(0.5, 0.5, depth, color, opacity);
        assert_eq!(one(&[layer(1.0, Vec3::X, 0.0)]).rgba[0], [0.0; 4]);
        assert_eq!(one(&[layer(1.0, Vec3::X, 1.0), layer(2.0, Vec3::ONE, 1.0)]).rgba[0], [1.0, 0.0, 0.0, 1.0]);
        // α = 0 in front neither colors nor takes the depth.
        let behind_nothing = one(&[layer(1.0, Vec3::ONE, 0.0), layer(2.0, Vec3::X, 1.0)]);
        assert_eq!((behind_nothing.rgba[0], behind_nothing.depth[0]), ([1.0, 0.0, 0.0, 1.0], 2.0));
        assert_eq!(behind_nothing.fragments, Some(vec![2]));
        // Coincident, of different colors: whatever the order of the input.
        let mut same: Vec<P> =
            (0..200).map(|i| layer(5.0, Vec3::new((i % 7) as f32 / 7.0, 0.5, (i % 3) as f32), 0.02)).collect();
        let first = bits(&one(&same));
        assert_same_bytes(device, &scene(&same), &frame(pixel_camera([1, 1]), [1, 1], flat()));
        for seed in 0..3 {
            same.shuffle(&mut random(seed));
            assert_eq!(bits(&one(&same)), first);
        }
    });
}

/// One pixel with these layers, front to back, by `method`.
fn one_pixel(device: &Device, layers: &[(f64, Vec3, f32)], method: Method) -> [f32; 4] {
    let points: Vec<P> = layers.iter().map(|(depth, color, opacity)| dot(0.5, 0.5, *depth, *color, *opacity)).collect();
    render(device, &scene(&points), &frame(pixel_camera([1, 1]), [1, 1], method)).rgba[0]
}

#[test]
fn long_lists_differ_from_the_reference_by_rounding_alone() {
    with_device(|device| {
        // Up to three runs of `sorted/blend`, which take 8192 each.
        for n in [1usize, 2, 7, 8, 9, 31, 32, 33, 255, 256, 257, 1025, 8191, 8192, 8193, 20_000] {
            // Opacity falls with the length, so that the last layers still count.
            let opacity = (3.0 / n as f32).min(0.5);
            let color = |i: usize| Vec3::new((i % 2) as f32, (i % 3) as f32 / 2.0, i as f32 / n as f32);
            let mut layers: Vec<_> = (0..n).map(|i| (1.0 + i as f64, color(i), opacity)).collect();
            let fragments: Vec<reference::abuffer::Fragment> = layers
                .iter()
                .enumerate()
                .map(|(i, l)| reference::abuffer::Fragment { z: l.0, index: i as u32, alpha: f64::from(l.2) })
                .collect();
            let colors: Vec<DVec3> = layers.iter().map(|l| l.1.as_dvec3()).collect();
            let wanted = reference::abuffer::composite(&fragments, &colors);
            layers.shuffle(&mut random(n as u64));
            let found = one_pixel(device, &layers, flat());
            // Each addition rounds a value below 1 by at most half an ulp of 2^-24, and what rounds the same way adds
            // up.
            let bound = 1e-6 + n as f64 * 2f64.powi(-25);
            let by_abuffer = one_pixel(device, &layers, Method::ABuffer(Discs::default()));
            for i in 0..4 {
                let wanted = [wanted.color.x, wanted.color.y, wanted.color.z, wanted.alpha][i];
                let error = (f64::from(found[i]) - wanted).abs();
                assert!(error < bound, "{n} layers: {} {wanted}", found[i]);
                let apart = f64::from((found[i] - by_abuffer[i]).abs());
                // Runs of 256 round less; up to that length nothing is rounded otherwise.
                assert!(if n <= 256 { apart == 0.0 } else { apart < bound }, "{n} layers: {apart}");
            }
        }
    });
}

#[test]
fn a_million_thin_layers_in_one_pixel() {
    with_device(|device| {
        for (n, opacity) in [(100_000, 1e-7f32), (1_000_000, 1e-6)] {
            let layers: Vec<_> = (0..n).map(|i| (1.0 + f64::from(i), Vec3::new(1.0, 0.5, 0.0), opacity)).collect();
            let [r, g, b, a] = one_pixel(device, &layers, flat());
            let alpha = -(f64::from(n) * f64::from(-opacity).ln_1p()).exp_m1();
            let by_abuffer = one_pixel(device, &layers, Method::ABuffer(Discs::default()))[3];
            eprintln!("{n} layers of {opacity}: A is {a}, by abuffer {by_abuffer}, exactly {alpha}");
            let bound = f64::from(n) * 2f64.powi(-25) * alpha.max(0.01);
            assert!((f64::from(a) - alpha).abs() < bound, "{a} {alpha}");
            assert!((f64::from(r) - alpha).abs() < bound, "{r}");
            assert!((f64::from(g) - 0.5 * alpha).abs() < bound, "{g}");
            assert_eq!(b, 0.0);
        }
    });
}

#[test]
fn a_tile_with_many_splats_goes_on_from_run_to_run() {
    with_device(|device| {
        // The tile has 20 000 splats, which are composed 2048 at a time and joined: the A-buffer's image to rounding.
        let size = [16, 16];
        let mut r = random(31);
        let mut points: Vec<P> = (0..20_000)
            .map(|i| {
                let (x, y) = (r.random_range(0..16), r.random_range(0..16));
                let color = Vec3::new(r.random(), r.random(), r.random());
                let opacity = if i % 5 == 0 { 0.0 } else { r.random_range(0.0..0.1) };
                dot(f64::from(x) + 0.5, f64::from(y) + 0.5, 1.0 + f64::from(i % 9973), color, opacity)
            })
            .collect();
        // A pixel that has nothing before the last run, and one whose first is transparent.
        points.retain(|p| p.position.x > 2.0 || p.position.z < -9900.0);
        let (points, frame) = (scene(&points), frame(pixel_camera(size), size, flat()));
        let (found, wanted) = (render(device, &points, &frame), render(device, &points, &by_abuffer(&frame)));
        assert_eq!((&found.fragments, &found.depth), (&wanted.fragments, &wanted.depth));
        for (a, b) in found.rgba.iter().flatten().zip(wanted.rgba.iter().flatten()) {
            assert!((a - b).abs() < 1e-6, "{a} {b}");
        }
    });
}

/// The share of pixels in which two references differ by more than `limit`.
fn share_apart(a: &reference::ReferencePicture, b: &reference::ReferencePicture, limit: f64) -> f64 {
    let differ = |(a, b): &(&[f64; 4], &[f64; 4])| a.iter().zip(*b).any(|(a, b)| (a - b).abs() > limit);
    a.rgba.iter().zip(&b.rgba).filter(differ).count() as f64 / a.rgba.len() as f64
}

#[test]
fn crossing_discs_are_off_by_what_their_order_makes() {
    with_device(|device| {
        let size = [160, 120];
        let points = soup(61, 3000, 0.03..0.12, 0.3..0.9, true);
        for (camera, falloff) in [perspective(), orthographic()].into_iter().flat_map(|c| FALLOFFS.map(|f| (c, f))) {
            let discs = Discs { shape: DiscShape::Oriented, falloff, ..Discs::default() };
            let points = scene(&safe(&points, &camera, size, discs.shape));
            let frame = frame(camera, size, Method::Sorted(discs));
            let (sorted, exact) = (render(device, &points, &frame), render(device, &points, &by_abuffer(&frame)));
            let own = reference(&points, &camera, size, &discs);
            let exact_reference =
                reference::abuffer::render(View::new(&camera, size), &points, &colors(&points), &discs);
            let (to_own, _) = difference(&sorted, &own, 0.0);
            let (off, share) = difference(&sorted, &exact_reference, 0.01);
            let (by_abuffer, _) = difference(&exact, &exact_reference, 0.0);
            eprintln!(
                "{falloff:?}: {to_own:e} from its reference, {off} from the exact one, {share} of pixels over 0.01"
            );
            assert!(to_own < 3e-5 && by_abuffer < 3e-5, "{to_own} {by_abuffer}");
            // A pixel is as far off as its reference is, but for what both images are off their references. Few are:
            // discs of a radius of 0.1 in a cube of side 2 seldom cross. Gaussian ones are fainter where they do.
            let crossed = share_apart(&own, &exact_reference, 0.01 + 6e-5);
            let most = if falloff == Falloff::Flat { 0.3 } else { 0.2 };
            assert!(off > most && share >= crossed && crossed > 0.01, "{off}, {share} of the pixels, {crossed}");
            assert_eq!(sorted.fragments, exact.fragments);
            // Transmittance does not depend on the order.
            let alpha = sorted.rgba.iter().zip(&exact.rgba).map(|(a, b)| (a[3] - b[3]).abs()).fold(0.0, f32::max);
            assert!(alpha < 1e-5, "{alpha}");
        }
    });
}

#[test]
fn nothing_in_view_sorts_nothing() {
    with_device(|device| {
        let behind =
            P { position: perspective().eye * 2.0, color: Vec3::ONE, opacity: 1.0, radius: 1.0, normal: Vec3::ZERO };
        let found = rendered(device, &scene(&[behind; 3]), &frame(perspective(), [64, 48], flat()));
        assert!(
            found.image.rgba.iter().all(|c| *c == [0.0; 4]) && found.image.depth.iter().all(|z| *z == f32::INFINITY)
        );
        assert_eq!(found.image.fragments, Some(vec![0; 64 * 48]));
        assert_eq!((found.facts.tile_entries, found.facts.visible, found.facts.bands), (0, 0, 0));
        let names: Vec<_> = found.profile.passes.iter().map(|p| p.name).collect();
        assert!(!names.iter().any(|n| n.starts_with("radix/") || n.starts_with("sorted/")), "{names:?}");
        assert!(names.contains(&"image/clear"), "{names:?}");
    });
}

#[test]
fn splats_may_be_larger_than_a_large_image() {
    with_device(|device| {
        let size = [4096, 2048];
        let disc = |depth: f64, opacity: f32| P {
            position: at_pixel(2048.0, 1024.0, depth),
            color: Vec3::ONE,
            opacity,
            radius: 3000.0,
            normal: Vec3::ZERO,
        };
        let frame = frame(pixel_camera(size), size, flat());
        let found = rendered(device, &scene(&[disc(1.0, 0.25), disc(2.0, 0.5)]), &frame);
        assert!(found.image.rgba.iter().all(|c| *c == [0.625; 4]));
        assert_eq!(found.facts.tile_entries, 2 * 256 * 128);
        // With many small splats beside it, subgroups walk blocks of tiles.
        let mut points: Vec<P> = (0..3000)
            .map(|i| P {
                radius: 2.0,
                ..dot(f64::from(i) * 1.3, f64::from(i % 2000), 0.5 + f64::from(i % 7), Vec3::X, 0.5)
            })
            .collect();
        points.push(disc(3.0, 0.5));
        assert_same_bytes(device, &scene(&points), &frame);
    });
}

#[test]
fn small_budgets_cut_windows_and_change_no_byte() {
    with_device(|device| {
        // Discs of up to the whole image: many more entries of tiles than splats.
        let size = [320, 240];
        let points =
            scene(&[soup(41, 2500, 0.1..0.6, 0.01..0.1, true), soup(42, 500, 0.0..0.02, 0.1..0.9, true)].concat());
        let mut renderer = Renderer::new(device).expect("a renderer");
        let mut cloud = renderer.upload(&points).expect("fits");
        for (n, discs) in all_discs().enumerate() {
            let mut frame = frame(perspective(), size, Method::Sorted(discs));
            let whole = renderer.render(&mut cloud, &frame).expect("renders");
            assert_eq!((whole.facts.windows, whole.facts.bands), (1, 1));
            // By turns: every pair of shape, falloff and whether fragments are counted.
            frame.fragments = n.count_ones() % 2 == 0;
            frame.memory_budget = Some(100 << 10);
            let named = match renderer.render(&mut cloud, &frame) {
                Err(error @ Error::SortOverBudget { points: 3000, budget, .. }) => {
                    let text = error.to_string();
                    assert!(text.contains("sorting 3000 splats") && text.contains("--memory-budget"), "{text}");
                    budget
                }
                other => panic!("expected the sort over budget, got {:?}", other.map(|r| r.facts)),
            };
            for (budget, least) in [(named, 2), (2 * named, 1)] {
                frame.memory_budget = Some(budget);
                let cut = renderer.render(&mut cloud, &frame).expect("the budget that the error names does");
                assert!(cut.facts.windows >= least, "{:?}", cut.facts);
                assert!(bits(&cut.image) == bits(&whole.image), "budget {budget}: {discs:?}");
                if frame.fragments {
                    // Windows that were halved after their lists were counted count once.
                    assert_eq!(cut.image.fragments, whole.image.fragments);
                    assert_eq!(cut.facts.fragments, whole.facts.fragments);
                }
            }
        }
    });
}

#[test]
fn long_lists_over_the_budget_are_counted_all_the_same() {
    with_device(|device| {
        // 8 bytes of each fragment would not fit; lengths are all that is needed.
        let points: Vec<P> = (0..50_000).map(|i| dot(0.5, 0.5, 1.0 + f64::from(i), Vec3::ONE, 1e-5)).collect();
        let points = scene(&points);
        let mut frame = frame(pixel_camera([1, 1]), [1, 1], flat());
        let whole = rendered(device, &points, &frame);
        frame.memory_budget = Some(7 << 20);
        let cut = rendered(device, &points, &frame);
        assert!(bits(&cut.image) == bits(&whole.image));
        assert_eq!((cut.image.fragments, cut.facts.max_list), (Some(vec![50_000]), 50_000));
    });
}

#[test]
fn small_bindings_change_no_byte() {
    // 4 MiB hold 262 144 splats: two chunks, and two of the parts that splats are reached by. No tile has more than
    // 2048 splats, so that none is composed in two runs.
    let points =
        scene(&[soup(24, 300_000, 0.0..0.005, 0.1..0.9, true), soup(25, 20, 0.2..0.6, 0.1..0.3, true)].concat());
    for discs in
        [Discs { shape: DiscShape::Oriented, falloff: Falloff::Gaussian, ..Discs::default() }, Discs::default()]
    {
        let frame = frame(perspective(), [640, 480], Method::Sorted(discs));
        let mut images = Vec::new();
        for binding in [None, Some(4 << 20)] {
            with_device_that_binds(binding, |device| {
                let cloud = Renderer::new(device).expect("a renderer").upload(&points).expect("fits");
                assert_eq!(cloud.chunks().count() > 1, binding.is_some(), "chunks");
                drop(cloud);
                let found = rendered(device, &points, &frame);
                images.push(bits(&found.image));
            });
        }
        assert!(images.windows(2).all(|pair| pair[0] == pair[1]), "{discs:?}");
    }
    let points = scene(&soup(26, 300_000, 0.0..0.005, 0.1..0.9, false));
    with_device_that_binds(Some(2 << 20), |device| {
        let mut renderer = Renderer::new(device).expect("a renderer");
        let mut cloud = renderer.upload(&points).expect("fits");
        let found = renderer.render(&mut cloud, &frame(perspective(), [64, 64], flat()));
        assert!(
            matches!(found, Err(Error::TooManyPoints { points: 300_000, limit: 262_144 })),
            "records of 8 bytes: {:?}",
            found.map(|f| f.facts)
        );
    });
}

#[test]
fn more_points_than_a_binding_has_records_for_are_sorted_window_by_window() {
    // 300,000 points, of which a binding of 2 MiB holds 2^18 = 262,144 records of 8 bytes, and four hold all columns.
    let points = Arc::new(scene(&soup(26, 300_000, 0.0..0.005, 0.1..0.9, false)));
    let arranged = Arranged::Canonical(Arc::clone(&points));
    let by = |method| frame(perspective(), [64, 64], method);
    let methods = [flat(), Method::ABuffer(Discs::default()), Method::Weighted(Discs::default())];
    let mut wanted = None;
    with_device(|device| wanted = Some(methods.map(|method| bits(&render(device, &points, &by(method))))));
    with_device_that_binds(Some(2 << 20), |device| {
        let mut renderer = Renderer::new(device).expect("a renderer");
        let mut cloud = renderer.upload(&arranged).expect("fits");
        // Lists are made of all points at once before and after.
        for (number, divided) in [(1, false), (0, true), (2, true), (1, false), (0, true)] {
            let found = renderer.render(&mut cloud, &by(methods[number])).expect("renders");
            assert!(wanted.as_ref().is_none_or(|wanted| bits(&found.image) == wanted[number]), "{number}: other bytes");
            assert_eq!((cloud.supply().is_some(), found.facts.windows > 1), (divided, divided), "{number}");
            assert!(cloud.len() <= if divided { 262_144 } else { 300_000 }, "{number}: {}", cloud.len());
        }
    });
}

/// Layers over the whole image, front to back, with these colors and opacities.
fn stack(layers: impl IntoIterator<Item = (Vec3, f32)>) -> Points {
    let layer = |(i, (color, opacity)): (usize, (Vec3, f32))| P {
        radius: 40.0,
        ..dot(16.0, 16.0, 1.0 + i as f64, color, opacity)
    };
    scene(&layers.into_iter().enumerate().map(layer).collect::<Vec<_>>())
}

const STACK: [u32; 2] = [32, 32];

/// Deep stacks of dark, light and mixed colors, the back of other colors than the front.
fn stacks() -> Vec<Points> {
    let gray = |v: f32| Vec3::splat(v);
    let mut r = random(77);
    let mut found = Vec::new();
    for opacity in [0.004, 0.03, 0.2, 0.7, 1.0] {
        for (front, back) in [
            (gray(0.0), gray(1.0)),
            (gray(1.0), gray(0.0)),
            (gray(0.002), gray(1.0)),
            (gray(0.004), gray(1.0)),
            (Vec3::X, Vec3::ONE - Vec3::X),
            (Vec3::new(0.9, 0.003, 0.5), Vec3::ONE),
        ] {
            // As many layers in front as stop just before, just behind and well behind the limits.
            for in_front in [300, 1200, 2000] {
                let count = (in_front as f32 * 0.004 / opacity).ceil() as usize;
                found.push(stack((0..count + 400).map(|i| (if i < count { front } else { back }, opacity))));
            }
        }
        found.push(stack((0..2500).map(|_| (Vec3::new(r.random(), r.random(), r.random()), opacity))));
    }
    found
}

/// 8-bit values before rounding, on a scale of 255 steps, as `output` makes them: over a background, or straight with
/// alpha.
fn steps(image: &Image, color: ColorSpace, background: Option<f64>) -> Vec<f64> {
    let encode = |v: f64| if color == ColorSpace::Linear { encode_srgb_f64(v) } else { v };
    let of = |[r, g, b, a]: [f64; 4]| match background {
        Some(behind) => [r, g, b].map(|c| encode((c + (1.0 - a) * behind).clamp(0.0, 1.0))).to_vec(),
        None if a > 0.0 => [r, g, b].map(|c| encode((c / a).clamp(0.0, 1.0))).into_iter().chain([a]).collect(),
        None => vec![0.0; 4],
    };
    image.rgba.iter().flat_map(|c| of(c.map(f64::from))).map(|v| 255.0 * v).collect()
}

#[test]
fn eight_bit_values_move_by_a_quarter_of_a_step_at_most() {
    with_device(|device| {
        let (mut changed, mut most) = (0, 0f64);
        for points in stacks() {
            let mut renderer = Renderer::new(device).expect("a renderer");
            let mut cloud = renderer.upload(&points).expect("fits");
            for color in [ColorSpace::Linear, ColorSpace::Encoded] {
                let mut frame = frame(pixel_camera(STACK), STACK, flat());
                (frame.color, frame.fragments) = (color, false);
                let exact = renderer.render(&mut cloud, &frame).expect("renders").image;
                for transparent in [false, true] {
                    frame.stop = Stop::EightBit { transparent };
                    let early = renderer.render(&mut cloud, &frame).expect("renders").image;
                    changed += usize::from(bits(&early) != bits(&exact));
                    assert_eq!(early.depth, exact.depth);
                    let backgrounds = if transparent { vec![None] } else { vec![Some(0.0), Some(0.3), Some(1.0)] };
                    for background in backgrounds {
                        let background = background.map(|b| match color {
                            ColorSpace::Linear => b,
                            ColorSpace::Encoded => encode_srgb_f64(b),
                        });
                        let (a, b) = (steps(&early, color, background), steps(&exact, color, background));
                        let apart = a.iter().zip(&b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
                        most = most.max(apart);
                        assert!(apart <= 0.2501, "{apart} steps: {color:?}, {background:?}");
                    }
                }
            }
        }
        eprintln!("{changed} images stopped early, by at most {most} steps");
        assert!(changed > 100, "{changed} images stopped early");
    });
}

#[test]
fn the_comparison_of_steps_notices_what_a_quarter_of_a_step_is() {
    let image = |value: f32| Image {
        width: 1,
        height: 1,
        rgba: vec![[value, value, value, 1.0]],
        depth: vec![1.0],
        ..Image::default()
    };
    let dark = 1.0 / 255.0 / 12.92;
    let apart =
        |a: f32, b: f32, color| (steps(&image(a), color, Some(0.0))[0] - steps(&image(b), color, Some(0.0))[0]).abs();
    assert!((apart(0.0, dark, ColorSpace::Linear) - 1.0).abs() < 1e-4);
    assert!((apart(0.5, 0.5 + 1.0 / 255.0, ColorSpace::Encoded) - 1.0).abs() < 1e-4);
    assert!(
        (apart(0.5, 0.6, ColorSpace::Linear) - 255.0 * f64::from(encode_srgb(0.6) - encode_srgb(0.5))).abs() < 1e-3
    );
}

#[test]
fn stopping_exactly_leaves_out_nothing_that_can_be_seen() {
    with_device(|device| {
        // Lists of 250 that saturate after few, many or no layers: the bytes of a method that never stops.
        let mut r = random(78);
        for opacity in [1.0, 0.999, 0.5, 0.1, 0.05, 0.01, 1e-6] {
            for color in [Vec3::ZERO, Vec3::ONE, Vec3::X, Vec3::splat(1e-6)] {
                let random = Vec3::new(r.random(), r.random(), r.random());
                let points = stack((0..250).map(|i| (if i % 3 == 0 { color } else { random * color }, opacity)));
                for space in [ColorSpace::Linear, ColorSpace::Encoded] {
                    let frame = Frame { color: space, ..frame(pixel_camera(STACK), STACK, flat()) };
                    assert_same_bytes(device, &points, &frame);
                }
            }
        }
        // One layer of each opacity among others: the largest of them may still come.
        let mixed = stack((0..250).map(|i| (Vec3::ONE, if i == 249 { 1.0 } else { 0.1 })));
        assert_same_bytes(device, &mixed, &frame(pixel_camera(STACK), STACK, flat()));
    });
}

#[test]
fn saturated_tiles_stop() {
    with_device(|device| {
        let eight = Stop::EightBit { transparent: false };
        // Layers behind the first 1000 have no color: blended, they would leave NaN. A run of 2048 splats looks for the
        // first time after 32, hence a color for these.
        let color = |i: usize| if i >= 1000 && i % 2048 >= 32 { Vec3::NAN } else { Vec3::splat(0.5) };
        let image = |opacity: f32, stop: Stop, color: &dyn Fn(usize) -> Vec3| {
            let points = stack((0..8192).map(|i| (color(i), opacity)));
            render(device, &points, &Frame { fragments: false, stop, ..frame(pixel_camera(STACK), STACK, flat()) })
        };
        let spoiled = |image: &Image| image.rgba.iter().all(|c| c[0].is_nan());
        let clean = |image: &Image| image.rgba.iter().flatten().all(|v| v.is_finite());
        // Thin layers never saturate: the test can fail.
        assert!(spoiled(&image(1e-6, Stop::Exact, &color)) && spoiled(&image(1e-6, eight, &color)));
        assert!(clean(&image(0.9, Stop::Exact, &color)) && clean(&image(0.9, eight, &color)));
        // With α = 1/100 some 700 of 8192 layers do for 8 bits: what was blended follows from A = 1 − 0.99ⁿ.
        let plain = image(0.01, eight, &|_| Vec3::splat(0.5));
        let layers = plain.rgba.iter().map(|c| (-f64::from(c[3])).ln_1p() / 0.99f64.ln()).fold(0.0, f64::max);
        assert!((500.0..1000.0).contains(&layers), "{layers}");
    });
}
