//! `abuffer`: every stage, then the image, against the float64 reference; hard cases with known answers.

use glam::{DVec3, Vec3};
use pellucid_core::camera::Camera;
use pellucid_engine::methods::{Error, Frame, Renderer, abuffer};
use pellucid_gpu::Device;
use pellucid_reference as reference;
use pellucid_reference::View;
use pellucid_scene::{ColorSpace, DiscShape, Discs, Falloff, Light, LongLists, Method, Raster, Shading, ShadingModel};
use pellucid_testing::*;
use rand::seq::SliceRandom;

fn flat() -> Method {
    Method::ABuffer(Discs::default())
}

#[test]
fn counts_offsets_and_lists_are_the_references_exactly() {
    with_device(|device| {
        let size = [97, 64];
        let mixed = [soup(1, 600, 0.0..0.12, 0.1..0.9, true), soup(2, 30, 0.3..1.5, 0.1..0.9, true)].concat();
        for camera in [perspective(), orthographic()] {
            for discs in all_discs() {
                let points = scene(&safe(&mixed, &camera, size, discs.shape));
                let wanted = reference::abuffer::lists(View::new(&camera, size), &points, &discs);
                let mut renderer = Renderer::new(device).expect("a renderer");
                let mut cloud = renderer.upload(&points).expect("fits");
                let frame = frame(camera, size, Method::ABuffer(discs));
                let found = renderer.lists(&mut cloud, &frame, discs).expect("lists");

                let counts: Vec<u32> = wanted.iter().map(|l| l.len() as u32).collect();
                let offsets: Vec<u32> = reference::scan::exclusive(&counts).iter().map(|o| *o as u32).collect();
                assert_eq!(found.offsets, offsets, "{discs:?}");
                for (pixel, list) in wanted.iter().enumerate() {
                    let mut indices: Vec<u32> = list.iter().map(|f| f.index).collect();
                    let mut stored: Vec<u32> = found.fragments[offsets[pixel] as usize..offsets[pixel + 1] as usize]
                        .iter()
                        .map(|f| f[1])
                        .collect();
                    indices.sort_unstable();
                    stored.sort_unstable();
                    assert_eq!(stored, indices, "pixel {pixel}, {discs:?}");
                }
            }
        }
    });
}

#[test]
fn coverage_safe_scenes_equal_the_reference_to_3e_5() {
    with_device(|device| {
        let size = [160, 120];
        let mixed = [soup(3, 1500, 0.0..0.1, 0.0..1.0, true), soup(4, 40, 0.2..2.0, 0.05..0.4, true)].concat();
        for camera in [perspective(), orthographic()] {
            for discs in all_discs() {
                let points = scene(&safe(&mixed, &camera, size, discs.shape));
                assert!(points.len() > 800, "most points are safe: {}", points.len());
                let image = render(device, &points, &frame(camera, size, Method::ABuffer(discs)));
                let (largest, _) = difference(&image, &exact(&points, &camera, size, &discs), 0.0);
                // Fragments of one pixel nearer than float32 can tell are as good as absent in these scenes.
                assert!(largest < 3e-5, "{discs:?}: {largest}");
            }
        }
    });
}

#[test]
fn depth_and_counts_equal_the_reference() {
    with_device(|device| {
        let size = [80, 60];
        let mixed = [soup(5, 400, 0.0..0.1, 0.0..1.0, true), soup(6, 5, 0.2..2.0, 0.05..0.4, true)].concat();
        for discs in all_discs() {
            let camera = perspective();
            let points = scene(&safe(&mixed, &camera, size, discs.shape));
            let image = render(device, &points, &frame(camera, size, Method::ABuffer(discs)));
            let wanted = exact(&points, &camera, size, &discs);
            assert_eq!(image.fragments.as_deref(), Some(&wanted.counts[..]), "{discs:?}");
            for (found, wanted) in image.depth.iter().zip(&wanted.depth) {
                // A few roundings of a depth of about 5; an oriented disc adds a slope of at most some hundred.
                let close = (f64::from(*found) - wanted).abs() <= 2e-5 * wanted.abs();
                assert!(close || (found.is_infinite() && wanted.is_infinite()), "{found} {wanted}");
            }
        }
    });
}

#[test]
fn random_soups_differ_in_few_pixels() {
    with_device(|device| {
        let size = [256, 256];
        for (seed, radius, count) in [(11, 0.005..0.05, 20_000), (12, 0.05..0.3, 1000), (13, 0.0..0.01, 50_000)] {
            for shape in SHAPES {
                let discs = Discs { shape, ..Discs::default() };
                let points = scene(&soup(seed, count, radius.clone(), 0.05..0.95, true));
                let image = render(device, &points, &frame(perspective(), size, Method::ABuffer(discs)));
                let (_, over) = difference(&image, &exact(&points, &perspective(), size, &discs), 1e-3);
                assert!(over < 0.005, "seed {seed} {shape:?}: {over}");
            }
        }
    });
}

#[test]
fn the_comparison_notices_a_wrong_image() {
    with_device(|device| {
        let points = scene(&soup(14, 300, 0.05..0.2, 0.2..0.8, false));
        let mut image = render(device, &points, &frame(perspective(), [64, 64], flat()));
        let wanted = exact(&points, &perspective(), [64, 64], &Discs::default());
        let middle = 32 * 64 + 32;
        image.rgba[middle][1] += 1e-3;
        assert!(difference(&image, &wanted, 0.0).0 > 9e-4);
        image.rgba[middle][1] = f32::NAN;
        assert!(difference(&image, &wanted, 0.0).0 > 1.0);
    });
}

/// The picture of one pixel with these layers, each of one point.
fn one_pixel(device: &Device, layers: &[(f64, Vec3, f32)]) -> [f32; 4] {
    one_pixel_by(device, flat(), layers).expect("renders")
}

/// The picture of one pixel, like [`one_pixel`], by a method that may refuse.
fn one_pixel_by(device: &Device, method: Method, layers: &[(f64, Vec3, f32)]) -> Result<[f32; 4], Error> {
    let points: Vec<P> = layers
        .iter()
        .map(|(depth, color, opacity)| P {
            position: at_pixel(0.5, 0.5, *depth),
            color: *color,
            opacity: *opacity,
            radius: 0.0,
            normal: Vec3::ZERO,
        })
        .collect();
    let mut renderer = Renderer::new(device)?;
    let mut cloud = renderer.upload(&scene(&points))?;
    Ok(renderer.render(&mut cloud, &frame(pixel_camera([1, 1]), [1, 1], method))?.image.rgba[0])
}

/// Compares one pixel of `n` layers with the reference; its bits.
fn assert_layers(device: &Device, method: Method, n: usize) -> [u32; 4] {
    // Opacity falls with the length, so that the last layers still count.
    let opacity = (3.0 / n as f32).min(0.5);
    let mut layers: Vec<_> = (0..n)
        .map(|i| {
            let color = Vec3::new((i % 2) as f32, (i % 3) as f32 / 2.0, i as f32 / n as f32);
            (1.0 + i as f64, color, opacity)
        })
        .collect();
    let fragments: Vec<reference::abuffer::Fragment> = layers
        .iter()
        .enumerate()
        .map(|(i, l)| reference::abuffer::Fragment { z: l.0, index: i as u32, alpha: f64::from(l.2) })
        .collect();
    let colors: Vec<DVec3> = layers.iter().map(|l| l.1.as_dvec3()).collect();
    let wanted = reference::abuffer::composite(&fragments, &colors);
    layers.shuffle(&mut random(n as u64));
    let found = one_pixel_by(device, method, &layers).expect("renders");
    for (f, w) in found.iter().zip([wanted.color.x, wanted.color.y, wanted.color.z, wanted.alpha]) {
        // 256 additions per run and at most 80 runs, each rounding a value below 1 by half an ulp.
        assert!((f64::from(*f) - w).abs() < 3e-6, "{n} layers: {f} {w}");
    }
    found.map(f32::to_bits)
}

#[test]
fn a_hundred_thousand_thin_layers_are_not_lost() {
    with_device(|device| {
        let layers: Vec<_> = (0..100_000).map(|i| (1.0 + f64::from(i), Vec3::ONE, 1e-7)).collect();
        let [r, _, _, a] = one_pixel(device, &layers);
        assert!((f64::from(a) - 0.009_950_17).abs() < 2e-6, "{a}");
        assert!((f64::from(r) - 0.009_950_17).abs() < 2e-6, "{r}");
    });
}

#[test]
fn long_lists_are_sorted_whatever_their_length() {
    with_device(|device| {
        for n in [1usize, 2, 3, 31, 32, 33, 63, 64, 65, 128, 129, 255, 256, 257, 511, 512, 513, 1025, 10_000] {
            assert_layers(device, flat(), n);
        }
    });
}

fn in_place() -> Method {
    Method::ABuffer(Discs { long_lists: LongLists::InPlace, ..Discs::default() })
}

#[test]
fn long_lists_are_sorted_in_place_to_the_same_bytes() {
    with_device(|device| {
        // Beyond 8571 one level of merges has more iterations than one run allows.
        for n in [257usize, 512, 513, 4000, 8193, 20_000] {
            assert_eq!(assert_layers(device, in_place(), n), assert_layers(device, flat(), n), "{n}");
        }
        // Many lists of many lengths at a time, ties among them, and in bands.
        let mut points = soup(52, 1500, 0.2..1.5, 0.001..0.02, true);
        for p in &mut points {
            p.position = (p.position * 8.0).round() / 8.0;
        }
        let points = scene(&points);
        let size = [64, 48];
        let merged = render(device, &points, &frame(perspective(), size, flat()));
        let lengths = merged.fragments.as_deref().expect("asked for");
        assert!(lengths.iter().any(|n| *n < 200) && lengths.iter().any(|n| *n > 600));
        for memory_budget in [None, Some(1 << 20)] {
            let image = render(device, &points, &Frame { memory_budget, ..frame(perspective(), size, in_place()) });
            assert!(bits(&image) == bits(&merged), "{memory_budget:?}");
        }
    });
}

#[test]
fn lists_too_long_to_be_sorted_in_place_are_an_error_that_says_what_would_do() {
    with_device(|device| {
        let n = abuffer::in_place_length() + 1;
        let layers: Vec<_> = (0..n).map(|i| (1.0 + f64::from(i), Vec3::ONE, 1e-7)).collect();
        let error = one_pixel_by(device, in_place(), &layers).expect_err("too long");
        assert!(matches!(error, Error::ListTooLong { length, most } if length == n && most == n - 1), "{error:?}");
        let message = error.to_string();
        assert!(message.contains(&(n - 1).to_string()) && message.contains("long_lists = \"merge\""), "{message}");
        one_pixel_by(device, in_place(), &layers[1..]).expect("the longest list allowed");
        one_pixel_by(device, flat(), &layers).expect("merged whatever its length");
    });
}

#[test]
fn coincident_discs_have_the_power_law_and_extremes_are_exact() {
    with_device(|device| {
        for n in [1, 2, 10, 300] {
            let same = vec![(5.0, Vec3::new(0.2, 0.4, 0.8), 0.1f32); n];
            let [r, _, b, a] = one_pixel(device, &same);
            let alpha = 1.0 - 0.9f64.powi(n as i32);
            for (found, wanted) in [(r, 0.2 * alpha), (b, 0.8 * alpha), (a, alpha)] {
                // 300 roundings of at most half an ulp of a value below 1, and the float32 value of 0.1.
                assert!((f64::from(found) - wanted).abs() < 1e-5, "{n}: {found} {wanted}");
            }
        }
        let red = Vec3::new(1.0, 0.0, 0.0);
        assert_eq!(one_pixel(device, &[(1.0, red, 0.0)]), [0.0; 4]);
        assert_eq!(one_pixel(device, &[(1.0, red, 1.0), (2.0, Vec3::ONE, 1.0)]), [1.0, 0.0, 0.0, 1.0]);
        // α = 0 in front neither colors nor takes the depth.
        let layers = [(1.0, Vec3::ONE, 0.0), (2.0, red, 1.0)];
        let points: Vec<P> = layers
            .iter()
            .map(|(z, color, opacity)| P {
                position: at_pixel(0.5, 0.5, *z),
                color: *color,
                opacity: *opacity,
                radius: 0.0,
                normal: Vec3::ZERO,
            })
            .collect();
        let image = render(device, &scene(&points), &frame(pixel_camera([1, 1]), [1, 1], flat()));
        assert_eq!((image.rgba[0], image.depth[0]), ([1.0, 0.0, 0.0, 1.0], 2.0));
        assert_eq!(image.fragments, Some(vec![2]));
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
            let frame = frame(orthographic(), [96, 96], Method::ABuffer(discs));
            let first = bits(&render(device, &scene(&points), &frame));
            let mut shuffled = points.clone();
            for seed in 0..3 {
                shuffled.shuffle(&mut random(seed));
                assert_eq!(bits(&render(device, &scene(&shuffled), &frame)), first, "{discs:?}");
            }
            shuffled.reverse();
            assert_eq!(bits(&render(device, &scene(&shuffled), &frame)), first, "{discs:?} reversed");
        }
    });
}

#[test]
fn both_rasters_give_the_same_bytes() {
    with_device(|device| {
        let points =
            scene(&[soup(22, 3000, 0.0..0.1, 0.1..0.9, true), soup(23, 20, 0.5..3.0, 0.1..0.3, true)].concat());
        for shape in SHAPES {
            for camera in [perspective(), orthographic()] {
                let [a, b] = RASTERS.map(|raster| {
                    let discs = Discs { shape, raster, ..Discs::default() };
                    bits(&render(device, &points, &frame(camera, [131, 77], Method::ABuffer(discs))))
                });
                assert!(a == b, "{shape:?}");
            }
        }
    });
}

#[test]
fn what_is_not_drawn_is_not_read() {
    with_device(|device| {
        // The first splat of all is outside of the image, and stands in where lists are shorter than their networks.
        let drawn = |i: u32| P {
            position: at_pixel(3.5, 3.5, 2.0 + f64::from(i)),
            color: Vec3::splat(0.5),
            opacity: 0.5,
            radius: 2.0,
            normal: Vec3::ZERO,
        };
        let aside = P { position: at_pixel(-1e3, 1e3, 1e3), ..drawn(0) };
        for count in [1, 3, 5, 11, 20] {
            let points: Vec<P> = std::iter::once(aside).chain((0..count).map(drawn)).collect();
            let points = scene(&points);
            assert_eq!(points.positions[0], aside.position);
            let mut renderer = Renderer::new(device).expect("a renderer");
            let mut cloud = renderer.upload(&points).expect("fits");
            cloud.make_room(device).expect("room for splats");
            cloud.colors.upload(&vec![[f32::NAN; 4]; points.len()]).expect("uploads");
            let found = renderer.render(&mut cloud, &frame(pixel_camera([7, 7]), [7, 7], flat())).expect("renders");
            assert!(found.image.rgba.iter().flatten().all(|value| value.is_finite()), "{count}");
        }
    });
}

#[test]
fn bands_and_windows_change_no_byte() {
    with_device(|device| {
        // 200 discs over the whole image: 200 fragments in every pixel, with some long lists added in one corner.
        let size = [128, 96];
        let mut points: Vec<P> = (0..200)
            .map(|i| P {
                position: at_pixel(64.0, 48.0, 1.0 + f64::from(i)),
                color: Vec3::new((i % 2) as f32, (i % 5) as f32 / 4.0, 1.0),
                opacity: 0.02,
                radius: 90.0,
                normal: Vec3::ZERO,
            })
            .collect();
        let first = points[0];
        points.extend((0..2000).map(|i| P {
            position: at_pixel(3.5, 5.5, 300.0 + f64::from(i)),
            radius: 0.0,
            ..first
        }));
        let points = scene(&points);
        let mut frame = frame(pixel_camera(size), size, flat());
        let mut renderer = Renderer::new(device).expect("a renderer");
        let mut cloud = renderer.upload(&points).expect("fits");
        let whole = renderer.render(&mut cloud, &frame).expect("renders");
        assert_eq!((whole.facts.bands, whole.facts.windows), (1, 1));
        assert_eq!(whole.facts.fragments, 200 * 128 * 96 + 2000);
        // The larger budgets hold the sorted splats that make ordered lists of half the size; the last one does not.
        for (budget, bands, windows) in [(8u64 << 20, 2, 1), (1 << 20, 25, 1), (480 << 10, 100, 2)] {
            frame.memory_budget = Some(budget);
            let cut = renderer.render(&mut cloud, &frame).expect("renders");
            assert!(cut.facts.bands >= bands && cut.facts.windows >= windows, "{:?}", cut.facts);
            assert!(bits(&cut.image) == bits(&whole.image), "budget {budget}");
            assert_eq!(cut.image.fragments, whole.image.fragments);
        }
        frame.memory_budget = Some(40 << 10);
        match renderer.render(&mut cloud, &frame) {
            Err(Error::PixelOverBudget { x: 3, y: 5, length: 2200, budget, .. }) => {
                frame.memory_budget = Some(budget);
                let cut = renderer.render(&mut cloud, &frame).expect("the budget that the error names does");
                assert!(bits(&cut.image) == bits(&whole.image));
            }
            other => panic!("expected the pixel over budget, got {:?}", other.map(|r| r.facts)),
        }
    });
}

#[test]
fn chunks_and_parts_change_no_byte() {
    // 4 MiB hold 262 144 splats: two chunks, and two of the four parts that stages reach splats by.
    let points =
        |count| scene(&[soup(24, count, 0.0..0.005, 0.1..0.9, true), soup(25, 20, 0.2..0.6, 0.1..0.3, true)].concat());
    let discs =
        Discs { shape: DiscShape::Oriented, falloff: Falloff::Gaussian, raster: Raster::Compute, ..Discs::default() };
    let cases = [
        (Method::ABuffer(discs), 300_000),
        (Method::ABuffer(Discs { raster: Raster::Hardware, shape: DiscShape::Flat, ..discs }), 140_000),
        (Method::Circles(pellucid_scene::ScreenSplats::default()), 300_000),
    ];
    let [many, fewer] = [300_000, 140_000].map(points);
    for (method, count) in cases {
        let points = if count == 300_000 { &many } else { &fewer };
        let frame = frame(perspective(), [160, 120], method);
        let mut images = Vec::new();
        for binding in [None, Some(4 << 20)] {
            with_device_that_binds(binding, |device| images.push(bits(&render(device, points, &frame))));
        }
        assert!(images.windows(2).all(|pair| pair[0] == pair[1]), "{method:?}");
    }
    with_device_that_binds(Some(1 << 20), |device| {
        let renderer = Renderer::new(device).expect("a renderer");
        // Four parts of 65 536 splats.
        assert!(matches!(renderer.upload(&many), Err(Error::TooManyPoints { points: 300_020, limit: 262_144 })));
    });
}

#[test]
fn moved_with_its_camera_the_image_stays() {
    with_device(|device| {
        let far = DVec3::new(500_000.0, 4_500_000.0, 100.0);
        let size = [128, 128];
        let near = safe(&soup(31, 2000, 0.01..0.1, 0.1..0.9, false), &perspective(), size, DiscShape::Flat);
        let moved: Vec<P> = near.iter().map(|p| P { position: p.position + far, ..*p }).collect();
        let mut camera = perspective();
        let here = render(device, &scene(&near), &frame(camera, size, flat()));
        camera.eye += far;
        let there = render(device, &scene(&moved), &frame(camera, size, flat()));
        let largest = here
            .rgba
            .iter()
            .zip(&there.rgba)
            .flat_map(|(a, b)| a.iter().zip(b))
            .map(|(a, b)| (a - b).abs())
            .fold(0.0, f32::max);
        // The moved float64 coordinates carry 1e-9 of rounding; coverage is safe to 0.02 pixels.
        assert!(largest < 3e-5, "{largest}");
    });
}

#[test]
fn hard_cameras_and_sizes_equal_the_reference() {
    use pellucid_core::camera::Projection::{Orthographic, Perspective};
    with_device(|device| {
        let eye = DVec3::new(0.3, 0.2, 3.0);
        let look =
            |projection, near, far| Camera::look_at(eye, DVec3::ZERO, DVec3::Y, projection, near, far).expect("valid");
        let wide = look(Perspective { fov_y: 170f64.to_radians() }, 1e-3, 1e3);
        let narrow = look(Perspective { fov_y: 1f64.to_radians() }, 0.1, 10.0);
        let inside =
            Camera::look_at(DVec3::ZERO, DVec3::X, DVec3::Y, Perspective { fov_y: 1.0 }, 1e-4, 100.0).expect("valid");
        let flat_view = look(Orthographic { height: 2.0 }, 0.01, 10.0);
        let soup = [soup(41, 800, 0.0..0.05, 0.2..0.9, true), soup(42, 20, 1.0..5.0, 0.05..0.2, true)].concat();
        for camera in [wide, narrow, inside, flat_view] {
            for size in [[1, 1], [1, 300], [300, 1], [65, 63]] {
                for shape in SHAPES {
                    let discs = Discs { shape, ..Discs::default() };
                    let points = scene(&safe(&soup, &camera, size, shape));
                    let image = render(device, &points, &frame(camera, size, Method::ABuffer(discs)));
                    let (largest, _) = difference(&image, &exact(&points, &camera, size, &discs), 0.0);
                    assert!(largest < 3e-5, "{camera:?} {size:?} {shape:?}: {largest}");
                }
            }
        }
    });
}

#[test]
fn odd_points_are_drawn_as_the_reference_says() {
    with_device(|device| {
        // Off the middle: the origin projects to a corner of pixels.
        let base = P {
            position: DVec3::new(0.013, 0.021, 0.0),
            color: Vec3::ONE,
            opacity: 0.5,
            radius: 0.1,
            normal: Vec3::ZERO,
        };
        let odd = [
            P { radius: 0.0, ..base },
            P { radius: 1e-40, position: DVec3::new(0.51, 0.5, 0.0), ..base },
            P { radius: 1e30, color: Vec3::X, opacity: 0.1, ..base },
            P { position: DVec3::new(1e30, 0.0, 0.0), ..base },
            P { position: DVec3::new(0.0, 0.0, 1e30), ..base },
            P { position: DVec3::new(0.0, 0.0, -1e30), ..base },
            // Behind the camera and exactly at the eye.
            P { position: perspective().eye * 2.0, radius: 100.0, ..base },
            P { position: perspective().eye, radius: 100.0, ..base },
            // Just before near and just behind it.
            P { position: perspective().eye + perspective().forward * 0.0999, ..base },
            P { position: perspective().eye + perspective().forward * 0.1001, ..base },
        ];
        for p in odd {
            let points = scene(&[p]);
            let image = render(device, &points, &frame(perspective(), [64, 64], flat()));
            let (largest, _) = difference(&image, &exact(&points, &perspective(), [64, 64], &Discs::default()), 0.0);
            assert!(largest < 1e-6, "{p:?}: {largest}");
        }
        let empty = render(device, &scene(&odd[6..8]), &frame(perspective(), [64, 64], flat()));
        assert!(empty.rgba.iter().all(|c| *c == [0.0; 4]) && empty.depth.iter().all(|z| *z == f32::INFINITY));
    });
}

#[test]
fn shading_and_encoded_blending_equal_the_reference() {
    with_device(|device| {
        let size = [96, 96];
        let lights = [
            Light::Headlight,
            Light::Direction(DVec3::new(1.0, -2.0, -1.0)),
            Light::Position(DVec3::new(0.5, 3.0, 1.0)),
        ];
        let mixed = soup(51, 1500, 0.02..0.15, 0.2..1.0, true);
        for camera in [perspective(), orthographic()] {
            let points = scene(&safe(&mixed, &camera, size, DiscShape::Flat));
            for light in lights {
                for model in [ShadingModel::Lambert, ShadingModel::Phong] {
                    for color in [ColorSpace::Linear, ColorSpace::Encoded] {
                        let shading = Shading { model, light, specular: 0.4, ..Shading::default() };
                        let mut frame = frame(camera, size, flat());
                        (frame.shading, frame.color) = (shading, color);
                        let image = render(device, &points, &frame);
                        let colors = reference::shading::shade(&points, &camera, &shading, color);
                        let wanted =
                            reference::abuffer::render(View::new(&camera, size), &points, &colors, &Discs::default());
                        let (largest, _) = difference(&image, &wanted, 0.0);
                        // A highlight of exponent 32 amplifies the rounding of r·v by 32.
                        assert!(largest < 6e-5, "{shading:?} {color:?}: {largest}");
                    }
                }
            }
        }
    });
}

#[test]
fn one_splat_may_fill_a_large_image() {
    with_device(|device| {
        let size = [4096, 2048];
        let point = P {
            position: at_pixel(2048.0, 1024.0, 1.0),
            color: Vec3::ONE,
            opacity: 0.25,
            radius: 3000.0,
            normal: Vec3::ZERO,
        };
        let image = render(device, &scene(&[point]), &frame(pixel_camera(size), size, flat()));
        assert!(image.rgba.iter().all(|c| *c == [0.25; 4]));
    });
}

#[test]
fn ordered_lists_are_those_that_are_sorted() {
    with_device(|device| {
        let mut r = random(77);
        let discs = |n: usize, radius: std::ops::Range<f32>| soup(78, n, radius, 0.0..0.6, false);
        let mut ties = discs(900, 0.2..0.4);
        for p in &mut ties {
            p.position = (p.position * 4.0).round() / 4.0;
        }
        let size = [150, 101];
        for points in [discs(1500, 0.1..0.5), discs(40, 0.5..3.0), ties] {
            let mut shuffled = points.clone();
            shuffled.shuffle(&mut r);
            let (points, shuffled) = (scene(&points), scene(&shuffled));
            for falloff in FALLOFFS {
                let discs = Discs { falloff, ..Discs::default() };
                for camera in [perspective(), orthographic()] {
                    let mut images = Vec::new();
                    for (points, method, memory_budget) in [
                        (&points, Method::LinkedList(discs), None),
                        (&points, Method::ABuffer(discs), None),
                        (&shuffled, Method::ABuffer(discs), None),
                        (&points, Method::ABuffer(discs), Some(8 << 20)),
                    ] {
                        let frame = Frame { memory_budget, ..frame(camera, size, method) };
                        let mut renderer = Renderer::new(device).expect("a renderer");
                        let mut cloud = renderer.upload(points).expect("fits");
                        let found = renderer.render(&mut cloud, &frame).expect("renders");
                        let ordered = matches!(method, Method::ABuffer(_));
                        assert_eq!(found.facts.ordered > 0, ordered, "{:?}", found.facts);
                        images.push((bits(&found.image), found.image.fragments));
                    }
                    assert!(images.windows(2).all(|pair| pair[0] == pair[1]), "{falloff:?}");
                }
            }
        }
        // More than one dispatch takes: of a tile (2048 splats), and of a list (32 768).
        let size = [6, 6];
        let deep: Vec<P> = (0..70_000)
            .map(|i| P {
                position: at_pixel(3.0, 3.0, 1.0 + f64::from(i)),
                color: Vec3::new((i % 3) as f32 / 2.0, 0.5, (i % 7) as f32 / 6.0),
                opacity: 2e-5,
                radius: 9.0,
                normal: Vec3::ZERO,
            })
            .collect();
        let deep = scene(&deep);
        let [ordered, sorted] = [Method::ABuffer(Discs::default()), Method::LinkedList(Discs::default())]
            .map(|method| bits(&render(device, &deep, &frame(pixel_camera(size), size, method))));
        assert!(ordered == sorted);
    });
}
