//! `peel` against the float64 reference and, byte by byte, against `abuffer`; hard cases with known answers.

use glam::Vec3;
use pellucid_core::points::Points;
use pellucid_engine::methods::{Error, Frame, Rendered, Renderer};
use pellucid_gpu::Device;
use pellucid_reference as reference;
use pellucid_reference::View;
use pellucid_scene::{ColorSpace, DiscShape, Discs, Falloff, Method, Peel, Raster, Shading, ShadingModel};
use pellucid_testing::gaussians::Soup;
use pellucid_testing::skip::{NO_ATOMICS, skip};
use pellucid_testing::*;
use rand::seq::SliceRandom;

fn peel(discs: Discs, layers: u32) -> Method {
    Method::Peel(Peel { discs, layers })
}

fn all_layers() -> Method {
    Method::Peel(Peel::default())
}

/// Renders with 64-bit atomics where the device has them, and in two steps of 32 bits: the bytes must be the same.
fn render_both(device: &Device, points: &Points, frame: &Frame) -> Rendered {
    let [wide, narrow] = rendered_by_both_atomics(device, points, frame);
    assert_eq!(ran(&narrow), ["peel/nearest-depth", "peel/nearest-id"]);
    if device.info().int64_atomics {
        assert_eq!(ran(&wide), ["peel/nearest"]);
    }
    wide
}

/// The passes that found the nearest fragments.
fn ran(rendered: &Rendered) -> Vec<&'static str> {
    let names = rendered.profile.passes.iter().map(|pass| pass.name);
    names.filter(|name| name.starts_with("peel/nearest")).collect()
}

#[test]
fn layers_equal_the_reference_to_3e_5() {
    with_device(|device| {
        let size = [160, 120];
        let mixed = [soup(3, 1500, 0.0..0.1, 0.0..1.0, true), soup(4, 40, 0.2..2.0, 0.05..0.4, true)].concat();
        for (camera, layers) in [(perspective(), 0), (perspective(), 1), (orthographic(), 4), (orthographic(), 0)] {
            for discs in all_discs() {
                let points = scene(&safe(&mixed, &camera, size, discs.shape));
                assert!(points.len() > 800, "most points are safe: {}", points.len());
                let rendered = render_both(device, &points, &frame(camera, size, peel(discs, layers)));
                let wanted =
                    reference::peel::render(View::new(&camera, size), &points, &colors(&points), &discs, layers);
                let (largest, _) = difference(&rendered.image, &wanted, 0.0);
                // As for abuffer: fragments of one pixel nearer than float32 can tell are as good as absent here.
                assert!(largest < 3e-5, "{discs:?}, {layers} layers: {largest}");
                // Nothing is opaque, so that every layer counts.
                assert_eq!(rendered.image.layers.as_deref(), Some(&wanted.counts[..]), "{discs:?}");
                assert_eq!(rendered.facts.layers, wanted.counts.iter().copied().max().unwrap_or(0));
                let lists = reference::abuffer::lists(View::new(&camera, size), &points, &discs);
                let lengths: Vec<u32> = lists.iter().map(|list| list.len() as u32).collect();
                assert_eq!(rendered.image.fragments.as_deref(), Some(&lengths[..]), "{discs:?}");
                for (found, wanted) in rendered.image.depth.iter().zip(&wanted.depth) {
                    // A few roundings of a depth of about 5; an oriented disc adds a slope of at most some hundred.
                    let close = (f64::from(*found) - wanted).abs() <= 2e-5 * wanted.abs();
                    assert!(close || (found.is_infinite() && wanted.is_infinite()), "{found} {wanted}");
                }
            }
        }
    });
}

#[test]
fn the_comparison_notices_a_missing_layer() {
    with_device(|device| {
        let (camera, size) = (perspective(), [64, 64]);
        let points = scene(&soup(14, 300, 0.05..0.2, 0.2..0.8, false));
        let image = render_both(device, &points, &frame(camera, size, peel(Discs::default(), 4))).image;
        let wanted = |layers| {
            reference::peel::render(View::new(&camera, size), &points, &colors(&points), &Discs::default(), layers)
        };
        assert!(difference(&image, &wanted(3), 0.0).0 > 1e-2);
        assert!(difference(&image, &wanted(5), 0.0).0 > 1e-2);
        assert_ne!(image.layers, Some(wanted(3).counts));
    });
}

#[test]
fn the_bytes_are_those_of_abuffer() {
    with_device(|device| {
        // Depths on few levels and coincident positions: plenty of ties between different colors; some opaque points.
        let mut tied = soup(21, 3000, 0.0..0.2, 0.1..1.1, true);
        for p in &mut tied {
            p.position = (p.position * 4.0).round() / 4.0;
            p.opacity = p.opacity.min(1.0);
        }
        let crossing = [soup(22, 2000, 0.0..0.1, 0.0..0.9, true), soup(23, 20, 0.5..3.0, 0.1..0.3, true)].concat();
        for (i, (points, camera)) in [(tied, orthographic()), (crossing, perspective())].into_iter().enumerate() {
            let points = scene(&points);
            // Half of them, so that any three of points, shape, falloff and rasterizer meet in every way.
            let half = all_discs().enumerate().filter(|(n, _)| (n.count_ones() as usize + i).is_multiple_of(2));
            for (_, discs) in half {
                let mut frame = frame(camera, [97, 77], Method::ABuffer(discs));
                frame.shading = Shading { model: ShadingModel::Lambert, ..Shading::default() };
                frame.color = ColorSpace::Encoded;
                let wanted = render(device, &points, &frame);
                // abuffer sums lists of up to 256 fragments in one go.
                let longest = wanted.fragments.iter().flatten().max().copied();
                assert!((20..=256).contains(&longest.expect("counted")), "{longest:?}");
                frame.method = peel(discs, 0);
                let found = render_both(device, &points, &frame);
                assert!(bits(&found.image) == bits(&wanted), "{discs:?}");
                assert_eq!(found.image.fragments, wanted.fragments, "{discs:?}");
            }
        }
    });
}

/// One pixel with these layers, each of one point without extent.
fn layered(layers: &[(f64, Vec3, f32)]) -> Vec<P> {
    let point = |(depth, color, opacity): &(f64, Vec3, f32)| P {
        position: at_pixel(0.5, 0.5, *depth),
        color: *color,
        opacity: *opacity,
        radius: 0.0,
        normal: Vec3::ZERO,
    };
    layers.iter().map(point).collect()
}

fn pixel(method: Method) -> Frame {
    frame(pixel_camera([1, 1]), [1, 1], method)
}

#[test]
fn stacks_over_many_batches_equal_the_reference() {
    with_device(|device| {
        for n in [1usize, 2, 15, 16, 17, 32, 256, 600, 3000] {
            let opacity = (3.0 / n as f32).min(0.5);
            let mut layers: Vec<_> = (0..n)
                .map(|i| {
                    let color = Vec3::new((i % 2) as f32, (i % 3) as f32 / 2.0, i as f32 / n as f32);
                    (1.0 + i as f64, color, opacity)
                })
                .collect();
            layers.shuffle(&mut random(n as u64));
            let points = scene(&layered(&layers));
            let [abuffer] = render(device, &points, &pixel(Method::ABuffer(Discs::default()))).rgba[..] else {
                panic!("one pixel")
            };
            for wanted in [0, n as u32 / 2 + 1] {
                let rendered = render_both(device, &points, &pixel(peel(Discs::default(), wanted)));
                let count = if wanted == 0 { n as u32 } else { wanted.min(n as u32) };
                assert_eq!((rendered.facts.layers, rendered.image.layers), (count, Some(vec![count])));
                let frame = pixel(all_layers());
                let exact = reference::peel::render(
                    View::new(&frame.camera, frame.size),
                    &points,
                    &colors(&points),
                    &Discs::default(),
                    wanted,
                );
                for (channel, (found, exact)) in rendered.image.rgba[0].iter().zip(exact.rgba[0]).enumerate() {
                    // Every layer's addition rounds a value below 1 by at most half an ulp, its weight by less than the
                    // opacity's share of that.
                    let bound = 4e-8 * (n + 2) as f64;
                    assert!((f64::from(*found) - exact).abs() < bound, "{n} layers: {found} {exact}");
                    if wanted == 0 && n <= 256 {
                        assert_eq!(found.to_bits(), abuffer[channel].to_bits(), "{n} layers");
                    } else if wanted == 0 {
                        assert!(f64::from(found - abuffer[channel]).abs() < bound, "{n} layers");
                    }
                }
            }
        }
    });
}

/// Walks that were not empty.
fn walks(rendered: &Rendered) -> usize {
    let walks = rendered.profile.timeline.iter().filter(|(pass, _)| pass.name == "peel/blend");
    walks.filter(|(pass, _)| pass.invocations.is_some_and(|invocations| invocations > 0)).count()
}

#[test]
fn a_walk_of_k_layers_needs_one_kth_of_the_walks() {
    with_device(|device| {
        if !device.info().int64_atomics || !device.info().pipeline_statistics {
            return skip(NO_ATOMICS, "a walk finds one layer, or walks can't be counted");
        }
        for n in [1usize, 7, 8, 9, 30] {
            let mut layers: Vec<_> = (0..n).map(|i| (1.0 + i as f64, Vec3::X, 0.05)).collect();
            layers.shuffle(&mut random(n as u64));
            let points = scene(&layered(&layers));
            let mut renderer = Renderer::new(device).expect("a renderer");
            let mut cloud = renderer.upload(&points).expect("fits");
            for k in [1, 2, 4, 8] {
                renderer.switches.layers_of_a_walk = k as u32;
                // The walk that finds fewer than k layers is the last one.
                let all = renderer.render(&mut cloud, &pixel(all_layers())).expect("renders");
                assert_eq!((all.facts.layers, walks(&all)), (n as u32, n / k + 1), "{n} layers, {k} in a walk");
                // Of those that are asked for none is empty, unless there are fewer. A walk finds no more than that.
                for asked in [1, 3, n] {
                    let some = renderer.render(&mut cloud, &pixel(peel(Discs::default(), asked as u32)));
                    let some = some.expect("renders");
                    let slots = k.min(asked.next_power_of_two());
                    let wanted = if asked <= n { asked.div_ceil(slots) } else { n / slots + 1 };
                    assert_eq!((some.facts.layers as usize, walks(&some)), (asked.min(n), wanted), "{n}, {k}, {asked}");
                }
            }
        }
    });
}

#[test]
fn layers_of_a_walk_change_no_byte() {
    with_device(|device| {
        // Ties, splats that are walked tile by tile, opaque points in front of others, and Gaussians whose lists end.
        let mut tied = soup(51, 1500, 0.0..0.2, 0.1..1.1, true);
        for p in &mut tied {
            p.position = (p.position * 4.0).round() / 4.0;
            p.opacity = p.opacity.min(1.0);
        }
        tied.extend(soup(52, 20, 0.5..3.0, 0.1..0.3, true));
        let subjects = [scene(&tied), Soup { count: 400, ..Soup::default() }.points()];
        for raster in RASTERS {
            for (points, shape) in subjects.iter().zip([DiscShape::Oriented, DiscShape::Flat]) {
                let discs = Discs { shape, raster, falloff: Falloff::Gaussian, ..Discs::default() };
                for layers in [0, 3, 8, 13] {
                    let frame = frame(perspective(), [70, 50], peel(discs, layers));
                    let mut renderer = Renderer::new(device).expect("a renderer");
                    let mut cloud = renderer.upload(points).expect("fits");
                    let mut images = [1, 2, 4, 8].map(|layers_of_a_walk| {
                        renderer.switches.layers_of_a_walk = layers_of_a_walk;
                        renderer.render(&mut cloud, &frame).expect("renders")
                    });
                    let last = images.last_mut().expect("four");
                    assert!(layers != 0 || last.facts.layers > 16, "{} layers", last.facts.layers);
                    for image in &images[..3] {
                        assert!(bits(&image.image) == bits(&images[3].image), "{raster:?}, {layers} layers");
                        assert_eq!(image.image.layers, images[3].image.layers);
                        assert_eq!(image.facts.layers, images[3].facts.layers);
                    }
                }
            }
        }
    });
}

#[test]
fn a_tight_budget_has_fewer_layers_of_a_walk_and_the_same_bytes() {
    with_device(|device| {
        if !device.info().int64_atomics || !device.info().pipeline_statistics {
            return skip(NO_ATOMICS, "a walk finds one layer, or walks can't be counted");
        }
        let n = 21;
        let points = scene(&layered(&(0..n).map(|i| (1.0 + i as f64, Vec3::Y, 0.05)).collect::<Vec<_>>()));
        let mut frame = frame(pixel_camera([32, 32]), [32, 32], all_layers());
        let mut renderer = Renderer::new(device).expect("a renderer");
        let mut cloud = renderer.upload(&points).expect("fits");
        let whole = renderer.render(&mut cloud, &frame).expect("renders");
        // A quarter of the budget holds 8 + 8 + 8 k bytes of each of 1024 pixels, or just not.
        let exactly = |k: u64| 4 * 1024 * (16 + 8 * k);
        for (budget, wanted) in [
            (exactly(1), 22),
            (exactly(2) - 1, 22),
            (exactly(2), 11),
            (exactly(4) - 1, 11),
            (exactly(4), 6),
            (exactly(8) - 1, 6),
            (exactly(8), 3),
        ] {
            frame.memory_budget = Some(budget);
            let found = renderer.render(&mut cloud, &frame).expect("renders");
            assert!(bits(&found.image) == bits(&whole.image), "{budget}");
            assert_eq!((found.facts.windows, walks(&found)), (1, wanted), "{budget} bytes");
        }
    });
}

#[test]
fn coincident_and_equally_deep_fragments_survive() {
    with_device(|device| {
        for n in [2, 10, 100] {
            let same = vec![(5.0, Vec3::new(0.2, 0.4, 0.8), 0.1f32); n];
            let rendered = render_both(device, &scene(&layered(&same)), &pixel(all_layers()));
            let alpha = 1.0 - 0.9f64.powi(n as i32);
            let [r, _, b, a] = rendered.image.rgba[0];
            for (found, wanted) in [(r, 0.2 * alpha), (b, 0.8 * alpha), (a, alpha)] {
                // 100 roundings of at most half an ulp of a value below 1, and the float32 values of 0.1 and the
                // colors.
                assert!((f64::from(found) - wanted).abs() < 6e-6, "{n}: {found} {wanted}");
            }
            assert_eq!(rendered.image.layers, Some(vec![n as u32]));
        }
        // Three colors at one depth: whichever is first, 1/2, 1/4 and 1/8 of them add up.
        let colors = [Vec3::X, Vec3::Y, Vec3::Z].map(|color| (2.0, color, 0.5));
        let image = render_both(device, &scene(&layered(&colors)), &pixel(all_layers())).image;
        let mut parts = image.rgba[0];
        parts.sort_by(f32::total_cmp);
        assert_eq!(parts, [0.125, 0.25, 0.5, 0.875]);
    });
}

#[test]
fn nothing_behind_an_opaque_fragment_is_peeled() {
    with_device(|device| {
        let red = Vec3::X;
        let layers = [(1.0, Vec3::Y, 0.5), (2.0, red, 1.0), (3.0, Vec3::Z, 0.5), (4.0, red, 1.0)];
        let rendered = render_both(device, &scene(&layered(&layers)), &pixel(all_layers()));
        assert_eq!((rendered.image.rgba[0], rendered.image.depth[0]), ([0.5, 0.5, 0.0, 1.0], 1.0));
        assert_eq!((rendered.image.fragments, rendered.image.layers), (Some(vec![4]), Some(vec![2])));
        // α = 0 in front is a layer, but neither colors nor takes the depth.
        let clear = [(1.0, Vec3::Y, 0.0), (2.0, red, 1.0)];
        let points = scene(&layered(&clear));
        for (layers, rgba, depth) in [(0, [1.0, 0.0, 0.0, 1.0], 2.0), (1, [0.0; 4], f32::INFINITY)] {
            let image = render_both(device, &points, &pixel(peel(Discs::default(), layers))).image;
            assert_eq!((image.rgba[0], image.depth[0]), (rgba, depth));
        }
    });
}

#[test]
fn too_many_layers_are_an_error_that_names_the_limit() {
    with_device(|device| {
        let stack = |n: usize| scene(&layered(&(0..n).map(|i| (1.0 + i as f64, Vec3::ONE, 0.1)).collect::<Vec<_>>()));
        // Within a batch, at its end, and beyond it.
        for limit in [5u32, 15, 16, 20] {
            let mut renderer = Renderer::new(device).expect("a renderer");
            renderer.switches.max_layers = limit;
            let mut fitting = renderer.upload(&stack(limit as usize)).expect("fits");
            let rendered = renderer.render(&mut fitting, &pixel(all_layers())).expect("as many as allowed");
            assert_eq!(rendered.facts.layers, limit);
            let mut deeper = renderer.upload(&stack(limit as usize + 1)).expect("fits");
            let error = renderer.render(&mut deeper, &pixel(all_layers())).expect_err("one more");
            assert!(matches!(error, Error::TooManyLayers { limit: named } if named == limit), "{error}");
            let message = error.to_string();
            assert!(message.contains(&limit.to_string()) && message.contains("abuffer"), "{message}");
            // Whoever asks for a number of layers gets them.
            let some = renderer.render(&mut deeper, &pixel(peel(Discs::default(), limit + 1))).expect("asked for");
            assert_eq!(some.facts.layers, limit + 1);
        }
    });
}

#[test]
fn shuffled_input_and_a_second_run_change_no_byte() {
    with_device(|device| {
        let mut points = soup(21, 2000, 0.02..0.2, 0.1..0.9, true);
        for p in &mut points {
            p.position = (p.position * 4.0).round() / 4.0;
        }
        for (discs, layers) in all_discs().zip([0, 3, 0, 1, 5, 0, 2, 0]) {
            let frame = frame(orthographic(), [96, 96], peel(discs, layers));
            let first = bits(&render(device, &scene(&points), &frame));
            let mut shuffled = points.clone();
            for seed in 0..2 {
                shuffled.shuffle(&mut random(seed));
                assert!(bits(&render(device, &scene(&shuffled), &frame)) == first, "{discs:?}");
            }
        }
    });
}

#[test]
fn windows_and_buffers_that_were_used_before_change_no_byte() {
    with_device(|device| {
        let points = scene(&[soup(31, 800, 0.0..0.1, 0.1..0.9, true), soup(32, 10, 0.5..3.0, 0.1..0.3, true)].concat());
        for raster in RASTERS {
            for layers in [0, 2] {
                let discs = Discs { shape: DiscShape::Oriented, raster, ..Discs::default() };
                let mut frame = frame(perspective(), [128, 96], peel(discs, layers));
                let mut renderer = Renderer::new(device).expect("a renderer");
                let mut cloud = renderer.upload(&points).expect("fits");
                let whole = renderer.render(&mut cloud, &frame).expect("renders");
                assert_eq!(whole.facts.windows, 1);
                // 24 bytes per pixel from a quarter of the budget: 2730 and 682 of 12 288 pixels.
                for (budget, windows) in [(256u64 << 10, 5), (64 << 10, 18)] {
                    frame.memory_budget = Some(budget);
                    let cut = renderer.render(&mut cloud, &frame).expect("renders");
                    assert!(cut.facts.windows >= windows, "{:?}", cut.facts);
                    assert!(bits(&cut.image) == bits(&whole.image), "budget {budget}");
                    assert_eq!(
                        (&cut.image.fragments, &cut.image.layers),
                        (&whole.image.fragments, &whole.image.layers)
                    );
                    assert_eq!(cut.facts.fragments, whole.facts.fragments);
                    assert_eq!(cut.facts.layers, whole.facts.layers);
                }
            }
        }
    });
}

#[test]
fn chunks_and_parts_change_no_byte() {
    // 4 MiB hold 131 072 points: two chunks, and for 300 000 two of the four parts that blending reaches splats by.
    let points =
        |count| scene(&[soup(24, count, 0.0..0.005, 0.1..0.9, true), soup(25, 20, 0.2..0.6, 0.1..0.3, true)].concat());
    for (raster, count) in [(Raster::Compute, 300_000), (Raster::Hardware, 140_000)] {
        let points = points(count);
        let discs = Discs { shape: DiscShape::Oriented, falloff: Falloff::Gaussian, raster, ..Discs::default() };
        let mut frame = frame(perspective(), [80, 60], peel(discs, 3));
        frame.fragments = false;
        let mut images = Vec::new();
        for binding in [None, Some(4 << 20)] {
            with_device_that_binds(binding, |device| images.push(render(device, &points, &frame)));
        }
        assert!(images.windows(2).all(|pair| bits(&pair[0]) == bits(&pair[1])), "{raster:?}");
        assert!(images.iter().all(|image| image.fragments.is_none() && image.layers.is_none()));
    }
}

#[test]
fn nothing_in_view_is_nothing_peeled() {
    with_device(|device| {
        let behind = P { position: perspective().eye * 2.0, ..layered(&[(1.0, Vec3::ONE, 0.5)])[0] };
        for raster in RASTERS {
            let frame = frame(perspective(), [30, 20], peel(Discs { raster, ..Discs::default() }, 0));
            let rendered = Renderer::new(device)
                .and_then(|mut renderer| {
                    let mut cloud = renderer.upload(&scene(&[behind]))?;
                    renderer.render(&mut cloud, &frame)
                })
                .expect("renders");
            assert!(rendered.image.rgba.iter().all(|c| *c == [0.0; 4]));
            assert!(rendered.image.depth.iter().all(|z| *z == f32::INFINITY));
            assert_eq!((rendered.facts.layers, rendered.image.layers), (0, Some(vec![0; 600])));
        }
    });
}
