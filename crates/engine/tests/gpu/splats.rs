//! `hqs` and `splats`: images against the float64 reference, cases worked by hand; the same bytes whatever the order of
//! input, the cut of the image and the runs over a tile.

use glam::Vec3;
use pellucid_core::image::Image;
use pellucid_core::points::Points;
use pellucid_engine::methods::{Error, Factors, Frame, Rendered, Renderer};
use pellucid_gpu::Device;
use pellucid_reference::View;
use pellucid_reference::coverage::Shape;
use pellucid_reference::range::{PictureRange, ROUNDING};
use pellucid_reference::{self as reference, splats};
use pellucid_scene::{BlendedSplats, ColorSpace, Method, ScreenSplats, Shading, ShadingModel, SplatShape};
use pellucid_testing::*;
use rand::seq::SliceRandom;

const SHAPES: [Shape; 3] = [Shape::Disc, Shape::Square, Shape::Oriented];

fn method(shape: Shape, settings: BlendedSplats) -> Method {
    match shape {
        Shape::Oriented => Method::Splats(settings),
        Shape::Square => Method::Hqs(BlendedSplats { shape: SplatShape::Square, ..settings }),
        _ => Method::Hqs(settings),
    }
}

fn blended(size: f32, max_pixel_radius: f32, blend_depth: f32) -> BlendedSplats {
    let splats = ScreenSplats { size, max_pixel_radius, ..ScreenSplats::default() };
    BlendedSplats { splats, blend_depth, shape: SplatShape::Circle }
}

/// Weights have an exponential of 1 and its argument's 3 roundings, times a color 1; sums are compensated, and their
/// quotient has
/// 3. Both sums have errors of the same sort.
pub(crate) const SUM_ERROR: f64 = 13.0 * ROUNDING;

/// A shaded color has fewer than fifty roundings behind it, of numbers up to 1, and the curve of sRGB is 12.92 times as
/// steep as linear light.
const SHADING_ERROR: f64 = 50.0 * 12.92 * ROUNDING;

/// Everything that roundings may make of an image.
fn ranges(points: &Points, frame: &Frame, shape: Shape, settings: &BlendedSplats) -> PictureRange {
    splats::ranges(View::new(&frame.camera, frame.size), points, &colors(points), shape, settings)
}

/// Compares an image with them; A is 0 or 1 to the bit.
fn compare(image: &Image, wanted: &PictureRange, slack: f64) -> Result<(), String> {
    let is_off = |pixel: &usize| !wanted.rgba[*pixel][3].covers(f64::from(image.rgba[*pixel][3]), 0.0);
    match (0..image.rgba.len()).find(is_off) {
        None => compare_ranges(image, wanted, slack),
        Some(pixel) => Err(format!("pixel {pixel}: A is {}", image.rgba[pixel][3])),
    }
}

#[test]
fn the_comparison_with_ranges_notices_what_roundings_cannot_do() {
    with_device(|device| {
        let points = scene(&soup(5, 3000, 0.02..0.2, 0.1..0.9, true));
        for shape in SHAPES {
            let settings = BlendedSplats::default();
            let frame = frame(perspective(), [90, 70], method(shape, settings));
            let image = render(device, &points, &frame);
            let of = |points: &Points, settings: &BlendedSplats| {
                compare(&image, &ranges(points, &frame, shape, settings), SUM_ERROR)
            };
            of(&points, &settings).expect("its own reference");
            // A little more reach, radii a thousandth larger, the nearest of 3000 points missing.
            of(&points, &BlendedSplats { blend_depth: 1.001, ..settings }).expect_err("another reach");
            let radii = points.radii.iter().map(|radius| 1.001 * radius).collect();
            of(&Points { radii, ..points.clone() }, &settings).expect_err("other radii");
            let far = |i: &usize| points.positions[*i].distance(frame.camera.eye);
            let nearest = (0..points.len()).min_by(|a, b| far(a).total_cmp(&far(b))).expect("one");
            of(&picked(&points, |i| i != nearest), &settings).expect_err("a point is missing");
        }
    });
}

#[test]
fn images_equal_the_reference() {
    with_device(|device| {
        let size = [120, 90];
        // Small ones, ones that meet several tiles, and some that are clamped; some oriented ones without a normal.
        let mut mixed = [soup(1, 2000, 0.0..0.15, 0.0..1.0, true), soup(2, 60, 0.3..2.0, 0.1..0.9, true)].concat();
        mixed.iter_mut().step_by(7).for_each(|p| p.normal = Vec3::ZERO);
        let all = [blended(1.0, 25.0, 1.0), blended(1.7, 6.0, 0.3), blended(1.0, 25.0, 0.0), blended(0.5, 1e9, 4.0)];
        let points = scene(&mixed);
        for camera in [perspective(), orthographic()] {
            for (shape, settings) in SHAPES.into_iter().flat_map(|shape| all.map(|settings| (shape, settings))) {
                let frame = frame(camera, size, method(shape, settings));
                let image = render(device, &points, &frame);
                let of = |settings| compare(&image, &ranges(&points, &frame, shape, settings), SUM_ERROR);
                let found = of(&settings);
                assert!(found.is_ok(), "{shape:?} {settings:?}: {found:?}");
                assert_eq!(image.fragments, None);
                // The comparison can fail: another reach.
                of(&BlendedSplats { blend_depth: settings.blend_depth + 0.2, ..settings }).expect_err("another reach");
            }
        }
    });
}

#[test]
fn shaded_and_encoded_colors_are_blended_and_radii_follow_the_factor() {
    with_device(|device| {
        let (size, camera) = ([100, 70], perspective());
        let settings = BlendedSplats::default();
        for shape in SHAPES {
            let points = scene(&soup(3, 1500, 0.02..0.2, 0.1..0.9, true));
            let mut frame = frame(camera, size, method(shape, settings));
            frame.shading = Shading { model: ShadingModel::Phong, specular: 0.4, ..Shading::default() };
            frame.color = ColorSpace::Encoded;
            let colors = reference::shading::shade(&points, &camera, &frame.shading, frame.color);
            let wanted = splats::ranges(View::new(&camera, size), &points, &colors, shape, &settings);
            let image = render(device, &points, &frame);
            compare(&image, &wanted, SUM_ERROR + SHADING_ERROR).expect("the reference");
            // Half the uploaded radii, doubled; powers of two round the same.
            let half = Points { radii: points.radii.iter().map(|r| 0.5 * r).collect(), ..points.clone() };
            frame.factors = Factors { radius: 2.0, opacity: 0.1 };
            assert!(bits(&render(device, &half, &frame)) == bits(&image), "{shape:?}");
        }
    });
}

/// A point in pixel coordinates for [`pixel_camera`].
fn disc(x: f64, y: f64, depth: f64, radius: f32, color: Vec3) -> P {
    P { position: at_pixel(x, y, depth), color, opacity: 0.0, radius, normal: Vec3::ZERO }
}

fn row(device: &Device, points: &[P], settings: BlendedSplats) -> Image {
    render(device, &scene(points), &frame(pixel_camera([9, 1]), [9, 1], Method::Hqs(settings)))
}

#[track_caller]
fn assert_color(found: [f32; 4], wanted: Vec3) {
    for (found, wanted) in found.iter().zip(wanted.extend(1.0).to_array()) {
        assert!((found - wanted).abs() <= 4.0 * f32::EPSILON, "{found} {wanted}");
    }
}

#[test]
fn cases_worked_by_hand() {
    with_device(|device| {
        let default = BlendedSplats::default();
        let color = Vec3::new(0.7, 0.2, 0.1);
        // A lone splat is flat, whatever its opacity.
        let alone = row(device, &[disc(4.5, 0.5, 3.0, 2.5, color)], default);
        for x in 0..9 {
            if (2..7).contains(&x) {
                assert_color(alone.rgba[x], color);
                assert_eq!(alone.depth[x], 3.0);
            } else {
                assert_eq!((alone.rgba[x], alone.depth[x]), ([0.0; 4], f32::INFINITY));
            }
        }
        // Two equal points meet on their bisector, and elsewhere the nearer one has the larger part.
        let pair = [disc(2.5, 0.5, 3.0, 4.0, Vec3::X), disc(6.5, 0.5, 3.0, 4.0, Vec3::Y)];
        let met = row(device, &pair, default);
        assert_color(met.rgba[4], Vec3::new(0.5, 0.5, 0.0));
        assert!(met.rgba[3][0] > 0.7 && met.rgba[5][1] > 0.7, "{:?}", met.rgba);
        // At ρ = 1/4 and 3/4 the weights are e^(−1/8) and e^(−9/8), whose ratio is e.
        let wanted = 1.0 / (1.0 + (-1f32).exp());
        assert_color(met.rgba[3], Vec3::new(wanted, 1.0 - wanted, 0.0));
        // A fragment counts up to a radius behind, and not beyond.
        for (behind, counts) in [(0.5, true), (1.0, true), (1.5, false)] {
            let list = [disc(4.5, 0.5, 3.0, 1.0, Vec3::X), disc(4.5, 0.5, 3.0 + behind, 1.0, Vec3::Y)];
            let seen = row(device, &list, default);
            assert_color(seen.rgba[4], if counts { Vec3::new(0.5, 0.5, 0.0) } else { Vec3::X });
            assert_eq!(seen.depth[4], 3.0);
            // Without a reach the nearest alone.
            assert_color(row(device, &list, blended(1.0, 25.0, 0.0)).rgba[4], Vec3::X);
        }
        // Equal depths blend at any reach.
        let level = [disc(4.5, 0.5, 3.0, 1.0, Vec3::X), disc(4.5, 0.5, 3.0, 1.0, Vec3::Y)];
        assert_color(row(device, &level, blended(1.0, 25.0, 0.0)).rgba[4], Vec3::new(0.5, 0.5, 0.0));
        // The clamp: a radius of 4 pixels becomes 1, on the image and in depth.
        let clamped = [disc(4.5, 0.5, 3.0, 4.0, Vec3::X), disc(4.5, 0.5, 5.0, 4.0, Vec3::Y)];
        let seen = row(device, &clamped, blended(1.0, 1.0, 1.0));
        assert_color(seen.rgba[4], Vec3::X);
        assert_eq!(seen.rgba.iter().map(|c| c[3]).collect::<Vec<_>>(), [0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 0.0, 0.0, 0.0]);
        // A radius of 0 draws one pixel.
        let dot = row(device, &[disc(4.3, 0.4, 3.0, 0.0, color)], default);
        assert_color(dot.rgba[4], color);
        assert_eq!(dot.rgba.iter().filter(|c| c[3] > 0.0).count(), 1);
    });
}

#[test]
fn a_surface_of_one_color_keeps_it() {
    with_device(|device| {
        let color = Vec3::new(0.3, 0.6, 0.9);
        let mut plane = soup(4, 6000, 0.1..0.2, 0.0..1.0, false);
        for p in &mut plane {
            p.position.z = 0.2 * p.position.x;
            p.color = color;
            p.normal = Vec3::new(-0.2, 0.0, 1.0).normalize();
        }
        for shape in SHAPES {
            let image =
                render(device, &scene(&plane), &frame(perspective(), [90, 90], method(shape, Default::default())));
            let covered: Vec<_> = image.rgba.iter().filter(|c| c[3] > 0.0).collect();
            assert!(covered.len() > 1500, "{}", covered.len());
            covered.iter().for_each(|c| assert_color(**c, color));
        }
    });
}

#[test]
fn order_of_input_changes_no_byte_although_depths_tie() {
    with_device(|device| {
        let mut points = soup(21, 3000, 0.02..0.2, 0.1..0.9, true);
        for p in &mut points {
            p.position = (p.position * 4.0).round() / 4.0;
        }
        for shape in SHAPES {
            let frame = frame(orthographic(), [96, 96], method(shape, BlendedSplats::default()));
            let first = bits(&render(device, &scene(&points), &frame));
            for seed in 0..2 {
                points.shuffle(&mut random(seed));
                assert!(bits(&render(device, &scene(&points), &frame)) == first, "{shape:?}");
            }
        }
    });
}

fn runs(rendered: &Rendered, name: &str) -> usize {
    rendered.profile.timeline.iter().filter(|(time, _)| time.name == name).count()
}

#[test]
fn neither_windows_nor_runs_over_a_tile_change_a_byte() {
    with_device(|device| {
        let size = [96, 64];
        // Every tile has some 2500 splats, of which a run takes 2048, or 1024 on wide devices; unclamped.
        let points =
            scene(&[soup(41, 2300, 2.0..3.0, 0.001..0.02, true), soup(42, 300, 0.0..0.1, 0.1..0.9, true)].concat());
        for (shape, camera) in [(Shape::Disc, perspective()), (Shape::Oriented, orthographic())] {
            let settings = blended(1.0, 1e9, 0.4);
            let mut renderer = Renderer::new(device).expect("a renderer");
            let mut cloud = renderer.upload(&points).expect("fits");
            let mut frame = frame(camera, size, method(shape, settings));
            let whole = renderer.render(&mut cloud, &frame).expect("renders");
            let wanted = if device.info().subgroup < Some(16) { 2 } else { 3 };
            assert_eq!((runs(&whole, "splats/visibility"), runs(&whole, "splats/attributes")), (wanted, wanted));
            assert_eq!((whole.facts.windows, whole.facts.splatted, whole.facts.layered), (1, 1, 0));
            compare(&whole.image, &ranges(&points, &frame, shape, &settings), SUM_ERROR).expect("the reference");
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
                assert!(bits(&cut.image) == bits(&whole.image), "{shape:?}, budget {budget}: {:?}", cut.facts);
            }
            assert!(cuts > 0, "{shape:?}: some budget cuts the image");
        }
    });
}

#[test]
fn sums_of_any_length_are_right_to_a_few_roundings() {
    with_device(|device| {
        for n in [2usize, 8, 255, 1023, 1024, 1025, 2047, 2048, 2049, 10_000] {
            let list: Vec<P> =
                (0..n).map(|i| disc(0.5, 0.5, 3.0, 0.0, Vec3::new((i % 2) as f32, 0.1, i as f32 / n as f32))).collect();
            let camera = pixel_camera([1, 1]);
            let image = render(device, &scene(&list), &frame(camera, [1, 1], Method::Hqs(BlendedSplats::default())));
            let half = (n / 2) as f64 / n as f64;
            let wanted = [half, f64::from(0.1f32), (n - 1) as f64 / (2 * n) as f64, 1.0];
            for (found, wanted) in image.rgba[0].iter().zip(wanted) {
                assert!((f64::from(*found) - wanted).abs() < 5e-7, "{n}: {:?} {wanted:?}", image.rgba[0]);
            }
        }
    });
}

#[test]
fn nothing_in_view_runs_no_pass() {
    with_device(|device| {
        let behind =
            P { position: perspective().eye * 2.0, color: Vec3::ONE, opacity: 1.0, radius: 1.0, normal: Vec3::ZERO };
        let mut renderer = Renderer::new(device).expect("a renderer");
        let mut cloud = renderer.upload(&scene(&[behind; 3])).expect("fits");
        for shape in SHAPES {
            let frame = frame(perspective(), [64, 48], method(shape, BlendedSplats::default()));
            let found = renderer.render(&mut cloud, &frame).expect("renders");
            assert!(
                found.image.rgba.iter().all(|c| *c == [0.0; 4]) && found.image.depth.iter().all(|z| z.is_infinite())
            );
            let names: Vec<_> = found.profile.passes.iter().map(|p| p.name).collect();
            assert!(!names.iter().any(|n| n.starts_with("splats/")) && names.contains(&"image/clear"), "{names:?}");
        }
    });
}

#[test]
fn devices_that_bind_little_take_chunks() {
    with_device_that_binds(Some(2 << 20), |device| {
        // 65 536 splats of a chunk are 1.25 MiB.
        let points = scene(&soup(51, 90_000, 0.0..0.02, 0.1..0.9, true));
        let mut renderer = Renderer::new(device).expect("a renderer");
        let mut cloud = renderer.upload(&points).expect("fits");
        let frame =
            Frame { fragments: false, ..frame(perspective(), [100, 80], Method::Splats(BlendedSplats::default())) };
        let image = renderer.render(&mut cloud, &frame).expect("renders").image;
        let wanted = ranges(&points, &frame, Shape::Oriented, &BlendedSplats::default());
        compare(&image, &wanted, SUM_ERROR).expect("the reference");
    });
}
