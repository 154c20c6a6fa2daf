//! `weighted`, `average`, `unsorted` and `hybrid`: images against their float64 references, and against `abuffer` where
//! they are exact; sums of any length; the same bytes whatever the order of input, the cut of the image and the runs
//! over a tile.

use glam::Vec3;
use pellucid_core::camera::Camera;
use pellucid_core::points::Points;
use pellucid_engine::methods::{Error, Frame, Rendered, Renderer};
use pellucid_gpu::Device;
use pellucid_reference::View;
use pellucid_reference::{self as reference, ReferencePicture};
use pellucid_scene::{ColorSpace, DiscShape, Discs, Falloff, Hybrid, Method, Mlab, Shading, ShadingModel};
use pellucid_testing::*;
use rand::RngExt;
use rand::seq::SliceRandom;

fn hybrid(discs: Discs, k: u32) -> Method {
    Method::Hybrid(Hybrid { discs, k, ..Hybrid::default() })
}

/// `hybrid` with a core of fragments of at least this opacity.
fn gated(discs: Discs, k: u32, core_alpha_min: f32) -> Method {
    Method::Hybrid(Hybrid { discs, k, core_alpha_min, ..Hybrid::default() })
}

fn mlab(discs: Discs, nodes: u32) -> Method {
    Method::Mlab(Mlab { discs, nodes })
}

/// All five; two numbers of fragments for `hybrid`, of which one takes several rounds where discs are oriented; as many
/// layers as `mlab` has slots, and fewer.
fn methods(discs: Discs) -> [Method; 7] {
    [
        Method::Weighted(discs),
        Method::Average(discs),
        Method::Unsorted(discs),
        hybrid(discs, 3),
        hybrid(discs, 11),
        mlab(discs, 3),
        mlab(discs, 16),
    ]
}

fn shapes() -> impl Iterator<Item = Discs> {
    SHAPES.into_iter().flat_map(|shape| FALLOFFS.map(|falloff| Discs { shape, falloff, ..Discs::default() }))
}

fn reference(points: &Points, camera: &Camera, size: [u32; 2], method: &Method) -> ReferencePicture {
    reference::approximate::render(View::new(camera, size), points, &colors(points), method).expect("an approximation")
}

#[track_caller]
fn assert_equals(
    found: &pellucid_core::image::Image,
    wanted: &ReferencePicture,
    bound: f64,
    what: &dyn std::fmt::Debug,
) {
    let (largest, _) = difference(found, wanted, 0.0);
    assert!(largest < bound, "{what:?}: {largest}");
    assert_eq!(found.fragments.as_deref(), Some(&wanted.counts[..]), "{what:?}");
    for (found, wanted) in found.depth.iter().zip(&wanted.depth) {
        // A few roundings of a depth of about 5; an oriented disc adds a slope of at most some hundred.
        let close = (f64::from(*found) - wanted).abs() <= 2e-5 * wanted.abs();
        assert!(close || (found.is_infinite() && wanted.is_infinite()), "{what:?}: {found} {wanted}");
    }
}

#[test]
fn coverage_safe_scenes_equal_the_reference_to_3e_5() {
    with_device(|device| {
        let size = [160, 120];
        let mixed = [soup(3, 1200, 0.0..0.1, 0.0..1.0, true), soup(4, 40, 0.2..2.0, 0.05..0.4, true)].concat();
        for camera in [perspective(), orthographic()] {
            for discs in shapes() {
                let points = scene(&safe(&mixed, &camera, size, discs.shape));
                assert!(points.len() > 600, "most points are safe: {}", points.len());
                // Rounds over oriented discs have a test of their own, and take long to compile.
                let rounds = |m: &Method| matches!(m, Method::Hybrid(Hybrid { k: 11, .. }));
                for method in methods(discs).into_iter().filter(|m| discs.shape == DiscShape::Flat || !rounds(m)) {
                    let image = render(device, &points, &frame(camera, size, method));
                    assert_equals(&image, &reference(&points, &camera, size, &method), 3e-5, &method);
                }
            }
        }
    });
}

#[test]
fn faint_fragments_are_in_the_tail_wherever_they_lie() {
    with_device(|device| {
        let size = [120, 90];
        let mixed = [soup(6, 900, 0.02..0.15, 0.0..1.0, true), soup(7, 40, 0.2..1.5, 0.0..0.3, true)].concat();
        for shape in SHAPES {
            // Without a falloff only a point's own opacity decides.
            let discs = Discs { shape, ..Discs::default() };
            let points = scene(&safe(&mixed, &perspective(), size, shape));
            let of = |method: Method| render(device, &points, &frame(perspective(), size, method));
            // The second takes two rounds where discs are oriented.
            for (k, least) in [(3, 0.2), (11, 0.2), (3, 1.0)] {
                let method = gated(discs, k, least);
                assert_equals(&of(method), &reference(&points, &perspective(), size, &method), 3e-5, &method);
                assert!(bits(&of(method)) != bits(&of(hybrid(discs, k))), "{method:?} has faint ones before others");
            }
            let smooth = Discs { falloff: Falloff::Gaussian, ..discs };
            let method = gated(smooth, 4, 0.1);
            let (_, share) = difference(&of(method), &reference(&points, &perspective(), size, &method), 3e-5);
            // Opacities that are as near to the least as roundings.
            assert!(share < 1e-3, "{shape:?}: {share}");
        }
    });
}

#[test]
fn a_gate_by_hand() {
    with_device(|device| {
        // Faint red before green and blue: by a core of one it is in the tail with blue.
        let at = |depth: f64, color: Vec3, opacity: f32| P {
            position: at_pixel(0.5, 0.5, depth),
            color,
            opacity,
            radius: 0.0,
            normal: Vec3::ZERO,
        };
        let points = scene(&[at(1.0, Vec3::X, 0.25), at(2.0, Vec3::Y, 0.5), at(3.0, Vec3::Z, 0.5)]);
        for shape in SHAPES {
            let discs = Discs { shape, ..Discs::default() };
            let of = |least: f32| render(device, &points, &frame(pixel_camera([1, 1]), [1, 1], gated(discs, 1, least)));
            // Half of a tail that covers 1 − 3/4 · 1/2 = 5/8, a third of it red.
            let [red, blue] = [0.5 * 0.625 / 3.0, 0.5 * 0.625 * 2.0 / 3.0];
            let close = |a: [f32; 4], b: [f32; 4]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-6);
            let found = of(0.3);
            assert!(close(found.rgba[0], [red, 0.5, blue, 0.8125]), "{:?}", found.rgba);
            assert_eq!(found.depth, [1.0], "the nearest fragment is the nearest");
            // As opaque as the least is opaque enough.
            assert!(close(of(0.25).rgba[0], of(0.0).rgba[0]) && close(of(0.5).rgba[0], found.rgba[0]));
            // Nothing is exact.
            let all = of(0.6).rgba[0];
            assert!(close(all, [0.8125 * 0.2, 0.8125 * 0.4, 0.8125 * 0.4, 0.8125]), "{all:?}");
        }
    });
}

#[test]
fn blending_of_shaded_and_encoded_colors() {
    with_device(|device| {
        let size = [120, 90];
        let points = scene(&safe(&soup(5, 900, 0.02..0.2, 0.1..0.9, true), &perspective(), size, DiscShape::Flat));
        for method in methods(Discs::default()) {
            let mut frame = frame(perspective(), size, method);
            frame.shading = Shading { model: ShadingModel::Phong, specular: 0.4, ..Shading::default() };
            frame.color = ColorSpace::Encoded;
            let colors = reference::shading::shade(&points, &frame.camera, &frame.shading, frame.color);
            let wanted = reference::approximate::render(View::new(&frame.camera, size), &points, &colors, &method);
            // As in the tests of `abuffer`: powers and the curve of sRGB round by themselves.
            assert_equals(&render(device, &points, &frame), &wanted.expect("an approximation"), 1e-4, &method);
        }
    });
}

#[test]
fn crossing_discs_are_composed_by_their_depths_in_each_pixel() {
    with_device(|device| {
        let size = [96, 72];
        let soup = soup(61, 8000, 0.05..0.2, 0.1..0.6, true);
        for (camera, falloff) in [(perspective(), Falloff::Flat), (orthographic(), Falloff::Gaussian)] {
            let discs = Discs { shape: DiscShape::Oriented, falloff, ..Discs::default() };
            let points = scene(&safe(&soup, &camera, size, discs.shape));
            let lists = reference::abuffer::lists(View::new(&camera, size), &points, &discs);
            let longest = lists.iter().map(Vec::len).max().unwrap_or(0);
            assert!(longest > 32, "{longest}");
            let ks = if falloff == Falloff::Flat { [1, 2, 8, 32, 64] } else { [1, 5, 8, 9, 17] };
            for k in ks {
                let method = hybrid(discs, k);
                let image = render(device, &points, &frame(camera, size, method));
                assert_equals(&image, &reference(&points, &camera, size, &method), 3e-5, &method);
            }
        }
    });
}

/// Largest difference of two images.
fn apart(a: &pellucid_core::image::Image, b: &pellucid_core::image::Image) -> f32 {
    assert_eq!(a.depth, b.depth);
    let pairs = a.rgba.iter().flatten().zip(b.rgba.iter().flatten());
    pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f32::max)
}

#[test]
fn a_hybrid_of_all_fragments_is_exact_and_one_of_fewer_is_not() {
    with_device(|device| {
        let size = [96, 72];
        // Depths and places on few levels: many ties.
        let mut points = soup(62, 1500, 0.05..0.2, 0.05..0.3, true);
        for p in &mut points {
            p.position = (p.position * 8.0).round() / 8.0;
        }
        let points = scene(&points);
        for shape in SHAPES {
            let discs = Discs { shape, ..Discs::default() };
            let of = |method| render(device, &points, &frame(perspective(), size, method));
            let exact = of(Method::ABuffer(discs));
            let longest = exact.fragments.iter().flatten().max().copied().unwrap_or(0);
            assert!((17..=64).contains(&longest), "{longest}");
            assert!(apart(&of(hybrid(discs, 64)), &exact) < 1e-6);
            // Where a list is no longer than k the same holds, and the others are off by less and less.
            let mut before = f32::INFINITY;
            for k in [1, 8, 16] {
                let found = of(hybrid(discs, k));
                let lengths = exact.fragments.iter().flatten();
                for ((a, b), n) in found.rgba.iter().zip(&exact.rgba).zip(lengths) {
                    let off = a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
                    assert!(*n > k + 1 || off < 1e-6, "{n} fragments, k = {k}: {off}");
                }
                let off = apart(&found, &exact);
                assert!(off > 1e-4 && off < before, "k = {k}: {off}, before {before}");
                before = off;
            }
        }
    });
}

/// A point that covers one pixel of [`pixel_camera`].
fn dot(x: f64, y: f64, depth: f64, color: Vec3, opacity: f32) -> P {
    P { position: at_pixel(x, y, depth), color, opacity, radius: 0.0, normal: Vec3::ZERO }
}

fn one_pixel(device: &Device, layers: &[P], method: Method) -> ([f32; 4], f32) {
    let image = render(device, &scene(layers), &frame(pixel_camera([1, 1]), [1, 1], method));
    (image.rgba[0], image.depth[0])
}

#[test]
fn opacities_of_0_and_1() {
    with_device(|device| {
        let layer = |depth: f64, color: Vec3, opacity: f32| dot(0.5, 0.5, depth, color, opacity);
        let all = methods(Discs::default());
        for method in all {
            let clear = [layer(1.0, Vec3::X, 0.0), layer(2.0, Vec3::Y, 0.0)];
            let average = matches!(method, Method::Average(_));
            // Opacity is nothing to an average.
            let wanted = if average { [0.5, 0.5, 0.0, 1.0] } else { [0.0; 4] };
            assert_eq!(one_pixel(device, &clear, method), (wanted, f32::INFINITY), "{method:?}");
            // One fragment is what it is, opaque or not.
            for opacity in [1.0, 0.3, 1e-20] {
                let color = Vec3::new(0.7, 0.2, 0.1);
                let (found, depth) = one_pixel(device, &[layer(3.0, color, opacity)], method);
                let wanted = if average { color.extend(1.0) } else { opacity * color.extend(1.0) };
                for (a, b) in found.iter().zip(wanted.to_array()) {
                    assert!((a - b).abs() <= 4.0 * f32::EPSILON * b, "{method:?}: {found:?} {wanted:?}");
                }
                assert_eq!(depth, 3.0);
            }
            // In front of everything lies something without opacity.
            let mixed = [layer(1.0, Vec3::ONE, 0.0), layer(2.0, Vec3::X, 1.0), layer(4.0, Vec3::X, 0.5)];
            let ([red, _, _, a], depth) = one_pixel(device, &mixed, method);
            assert_eq!((a, depth), (1.0, 2.0), "{method:?}");
            assert!((red - 1.0).abs() < 1e-6, "{method:?}: {red}");
        }
        // Opaque layers: the nearest k, and the last of the file.
        let opaque = [layer(2.0, Vec3::X, 1.0), layer(1.0, Vec3::Y, 1.0), layer(3.0, Vec3::Z, 1.0)];
        assert_eq!(one_pixel(device, &opaque, hybrid(Discs::default(), 1)).0, [0.0, 1.0, 0.0, 1.0]);
        assert_eq!(one_pixel(device, &opaque, Method::Unsorted(Discs::default())).0, [0.0, 0.0, 1.0, 1.0]);
    });
}

#[test]
fn sums_of_any_length_are_right_to_a_few_roundings() {
    with_device(|device| {
        let mut r = random(71);
        for n in [2usize, 8, 9, 255, 2047, 2048, 2049, 10_000] {
            let opacity = (3.0 / n as f32).min(0.5);
            let points: Vec<P> = (0..n)
                .map(|i| {
                    let color = Vec3::new((i % 2) as f32, r.random(), r.random());
                    dot(0.5, 0.5, 1.0 + r.random_range(0..n) as f64, color, opacity * r.random::<f32>())
                })
                .collect();
            let points = scene(&points);
            let camera = pixel_camera([1, 1]);
            for method in methods(Discs::default()) {
                let found = render(device, &points, &frame(camera, [1, 1], method));
                let wanted = reference(&points, &camera, [1, 1], &method);
                // Whatever the length: a sum, a quotient and a product each round once or twice.
                assert_equals(&found, &wanted, 1e-6, &(n, method));
            }
        }
    });
}

#[test]
fn a_hundred_thousand_thin_layers_and_huge_weights() {
    with_device(|device| {
        let thin: Vec<P> =
            (0..100_000).map(|i| dot(0.5, 0.5, 1.0 + f64::from(i), Vec3::new(1.0, 0.3, 0.0), 1e-7)).collect();
        // 1 − (1 − α)ⁿ for the float that is nearest to 10⁻⁷.
        let alpha = -(1e5 * f64::from(-1e-7f32).ln_1p()).exp_m1();
        assert!((alpha - 0.009_950_17).abs() < 1e-8);
        for method in methods(Discs::default()) {
            let ([red, green, _, a], _) = one_pixel(device, &thin, method);
            let alpha = if matches!(method, Method::Average(_)) { 1.0 } else { alpha };
            for (found, wanted) in [(red, alpha), (green, 0.3 * alpha), (a, alpha)] {
                assert!((f64::from(found) - wanted).abs() < 1e-6 * wanted, "{method:?}: {found} {wanted}");
            }
        }
        // Σw is 1.5·10⁸ here.
        let near: Vec<P> = (0..50_000).map(|i| dot(0.5, 0.5, 0.5, Vec3::splat((i % 2) as f32), 0.9)).collect();
        let ([red, _, _, a], depth) = one_pixel(device, &near, Method::Weighted(Discs::default()));
        assert!((red - 0.5).abs() < 1e-6 && a == 1.0 && depth == 0.5, "{red} {a}");
    });
}

#[test]
fn only_unsorted_and_mlab_ask_for_the_order_of_the_files() {
    with_device(|device| {
        let size = [96, 96];
        // Depths on few levels and coincident positions: plenty of ties between different colors.
        let mut points = soup(21, 3000, 0.02..0.2, 0.1..0.9, true);
        for p in &mut points {
            p.position = (p.position * 4.0).round() / 4.0;
        }
        for discs in
            [Discs::default(), Discs { shape: DiscShape::Oriented, falloff: Falloff::Gaussian, ..Discs::default() }]
        {
            for method in methods(discs) {
                let frame = frame(orthographic(), size, method);
                let first = bits(&render(device, &scene(&points), &frame));
                assert!(bits(&render(device, &scene(&points), &frame)) == first, "{method:?}: a second time");
                let mut shuffled = points.clone();
                shuffled.shuffle(&mut random(1));
                let found = bits(&render(device, &scene(&shuffled), &frame));
                assert_eq!(found == first, !matches!(method, Method::Unsorted(_) | Method::Mlab(_)), "{method:?}");
            }
        }
        // The order is that of the files, whatever the canonical one.
        let camera = orthographic();
        let mut shuffled = safe(&soup(22, 1500, 0.02..0.2, 0.1..0.9, false), &camera, size, DiscShape::Flat);
        for _ in 0..2 {
            let points = scene(&shuffled);
            for method in [Method::Unsorted(Discs::default()), mlab(Discs::default(), 1), mlab(Discs::default(), 2)] {
                let image = render(device, &points, &frame(camera, size, method));
                assert_equals(&image, &reference(&points, &camera, size, &method), 3e-5, &method);
            }
            shuffled.shuffle(&mut random(2));
        }
    });
}

#[test]
fn neither_windows_nor_runs_over_a_tile_change_a_byte() {
    with_device(|device| {
        let size = [64, 32];
        // Every tile has some 2500 splats, of which a run takes 2048.
        let points =
            scene(&[soup(41, 2300, 2.0..3.0, 0.001..0.02, true), soup(42, 300, 0.0..0.1, 0.1..0.9, true)].concat());
        for discs in [Discs::default(), Discs { shape: DiscShape::Oriented, ..Discs::default() }] {
            for method in methods(discs) {
                let mut renderer = Renderer::new(device).expect("a renderer");
                let mut cloud = renderer.upload(&points).expect("fits");
                let mut frame = frame(perspective(), size, method);
                let whole = renderer.render(&mut cloud, &frame).expect("renders");
                let accumulated = |r: &Rendered| {
                    r.profile.timeline.iter().filter(|(time, _)| time.name.ends_with("/accumulate")).count()
                };
                assert!(accumulated(&whole) > 1 && whole.facts.windows == 1, "{:?}", whole.facts);
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
        }
    });
}

#[test]
fn the_state_of_pixels_is_within_the_budget() {
    with_device(|device| {
        // Few splats over many pixels, so that what runs leave to each other takes more memory than all else.
        let size = [150, 100];
        let points = scene(&soup(43, 2300, 2.0..3.0, 0.001..0.01, true));
        let discs = Discs { shape: DiscShape::Oriented, ..Discs::default() };
        let of = |method, memory_budget| {
            let frame = Frame { fragments: false, memory_budget, ..frame(perspective(), size, method) };
            rendered(device, &points, &frame)
        };
        let budget = Some(2 << 20);
        assert_eq!(of(Method::Sorted(discs), budget).facts.windows, 1, "binning alone fits");
        for method in [Method::Weighted(discs), hybrid(discs, 11), mlab(discs, 4)] {
            let (whole, cut) = (of(method, None), of(method, budget));
            assert!(whole.facts.windows == 1 && cut.facts.windows > 1, "{:?} {:?}", whole.facts, cut.facts);
            assert!(bits(&cut.image) == bits(&whole.image), "{method:?}");
        }
    });
}

#[test]
fn layers_of_all_fragments_are_exact_and_fewer_are_not() {
    with_device(|device| {
        let size = [64, 48];
        let points = soup(63, 700, 0.05..0.2, 0.05..0.3, true);
        for shape in SHAPES {
            let discs = Discs { shape, ..Discs::default() };
            let points = scene(&safe(&points, &perspective(), size, shape));
            let of = |method| render(device, &points, &frame(perspective(), size, method));
            let exact = of(Method::ABuffer(discs));
            let lengths = exact.fragments.as_deref().expect("lengths");
            assert!(lengths.iter().any(|n| *n > 9), "{:?}", lengths.iter().max());
            for nodes in [1, 2, 5, 8] {
                let found = of(mlab(discs, nodes));
                for ((a, b), n) in found.rgba.iter().zip(&exact.rgba).zip(lengths) {
                    let off = a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
                    // Up to ten sums and products, each rounded.
                    assert!(*n > nodes + 1 || off < 1e-6, "{n} fragments, {nodes} layers: {off}");
                }
                // Few lists are as long as the most layers.
                assert!(nodes > 2 || apart(&found, &exact) > 1e-4, "{nodes} layers");
            }
        }
    });
}

#[test]
fn what_comes_in_order_is_exact_in_a_single_layer() {
    with_device(|device| {
        let mut r = random(72);
        // More than a run takes.
        let mut layers: Vec<P> = (0..3000)
            .map(|i| {
                dot(
                    0.5,
                    0.5,
                    1.0 + f64::from(i),
                    Vec3::new(r.random(), r.random(), r.random()),
                    0.002 * r.random::<f32>(),
                )
            })
            .collect();
        let exact = one_pixel(device, &layers, Method::ABuffer(Discs::default()));
        for _ in 0..2 {
            let found = one_pixel(device, &layers, mlab(Discs::default(), 1));
            for (a, b) in found.0.iter().zip(exact.0) {
                assert!((a - b).abs() < 1e-6, "{found:?} {exact:?}");
            }
            assert_eq!(found.1, exact.1);
            layers.reverse();
        }
        // Of equal depths the last to come lies in front.
        let equal = [dot(0.5, 0.5, 2.0, Vec3::X, 0.5), dot(0.5, 0.5, 2.0, Vec3::Y, 0.5)];
        for nodes in [1, 2, 4] {
            assert_eq!(one_pixel(device, &equal, mlab(Discs::default(), nodes)).0, [0.25, 0.5, 0.0, 0.75]);
        }
    });
}

#[test]
fn nothing_in_view_accumulates_nothing() {
    with_device(|device| {
        let behind =
            P { position: perspective().eye * 2.0, color: Vec3::ONE, opacity: 1.0, radius: 1.0, normal: Vec3::ZERO };
        for method in methods(Discs::default()) {
            let found = rendered(device, &scene(&[behind; 3]), &frame(perspective(), [64, 48], method));
            assert!(found.image.rgba.iter().all(|c| *c == [0.0; 4]), "{method:?}");
            assert!(found.image.depth.iter().all(|z| *z == f32::INFINITY), "{method:?}");
            assert_eq!((found.facts.visible, found.facts.bands), (0, 0));
            let names: Vec<_> = found.profile.passes.iter().map(|p| p.name).collect();
            assert!(!names.iter().any(|n| n.ends_with("/accumulate")) && names.contains(&"image/clear"), "{names:?}");
        }
    });
}
