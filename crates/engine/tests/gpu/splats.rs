//! `hqs` and `splats`: images against the float64 reference, cases worked by hand; the same bytes whatever the order of input,
//! the cut of the image and the runs over a tile.

use glam::Vec3;
use pellucid_engine::camera::Camera;
use pellucid_engine::gpu::Device;
use pellucid_engine::image::Image;
use pellucid_engine::methods::{Error, Factors, Frame, Rendered, Renderer};
use pellucid_engine::points::Points;
use pellucid_engine::reference::coverage::{Shape, margin_px};
use pellucid_engine::reference::splats::{self, Fragment};
use pellucid_engine::reference::{self, Picture};
use pellucid_engine::scene::{BlendedSplats, ColorSpace, Method, ScreenSplats, Shading, ShadingModel, SplatShape};
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

/// Keeps the points whose every coverage decision is clear in float32 too.
fn clear(points: &[P], camera: &Camera, size: [u32; 2], shape: Shape, settings: &ScreenSplats) -> Points {
    let all = scene(points);
    let kept: Vec<usize> = (0..all.len())
        .filter(|i| margin_px(camera, size, &splats::splat(camera, size, &all, *i, shape, settings)) > 0.02)
        .collect();
    Points {
        positions: kept.iter().map(|i| all.positions[*i]).collect(),
        colors: kept.iter().map(|i| all.colors[*i]).collect(),
        opacities: kept.iter().map(|i| all.opacities[*i]).collect(),
        radii: kept.iter().map(|i| all.radii[*i]).collect(),
        normals: all.normals.as_ref().map(|normals| kept.iter().map(|i| normals[*i]).collect()),
        file_order: Vec::new(),
        fields: Vec::new(),
    }
}

/// Relative errors of depths in float32: a few roundings of a flat disc's, to which a tilted one adds its slope.
fn depth_error(shape: Shape) -> f64 {
    if shape == Shape::Oriented { 4e-5 } else { 1e-6 }
}

/// Compares an image with the reference where it is clear in float32 which fragments count; the share of other pixels.
fn compare(image: &Image, wanted: &Picture, margins: &[f64], shape: Shape, bound: f64) -> Result<f64, String> {
    let mut doubtful = 0;
    for (at, margin) in margins.iter().enumerate() {
        let (found, depth) = (f64::from(image.depth[at]), wanted.depth[at]);
        let close = found == depth || (found - depth).abs() <= depth_error(shape) * depth;
        if !close {
            return Err(format!("pixel {at}: depth {found} {depth}"));
        }
        if *margin < depth_error(shape) {
            doubtful += 1;
            continue;
        }
        for (found, wanted) in image.rgba[at].iter().zip(wanted.rgba[at]) {
            let close = (f64::from(*found) - wanted).abs() <= bound;
            if !close {
                return Err(format!("pixel {at}: {:?} {:?}", image.rgba[at], wanted));
            }
        }
        if image.rgba[at][3] != wanted.rgba[at][3] as f32 {
            return Err(format!("pixel {at}: A is {}", image.rgba[at][3]));
        }
    }
    Ok(f64::from(doubtful) / margins.len() as f64)
}

fn margins(lists: &[Vec<Fragment>], blend_depth: f32) -> Vec<f64> {
    lists.iter().map(|list| splats::margin(list, f64::from(blend_depth))).collect()
}

/// The bound of [`compare`]: weights come from ρ, which tilts make less precise, and an exponential.
fn color_error(shape: Shape) -> f64 {
    if shape == Shape::Oriented { 1e-4 } else { 2e-5 }
}

#[test]
fn images_equal_the_reference() {
    with_device(|device| {
        let size = [120, 90];
        // Small ones, ones that meet several tiles, and some that are clamped; some oriented ones without a normal.
        let mut mixed = [soup(1, 2000, 0.0..0.15, 0.0..1.0, true), soup(2, 60, 0.3..2.0, 0.1..0.9, true)].concat();
        mixed.iter_mut().step_by(7).for_each(|p| p.normal = Vec3::ZERO);
        let all = [blended(1.0, 25.0, 1.0), blended(1.7, 6.0, 0.3), blended(1.0, 25.0, 0.0), blended(0.5, 1e9, 4.0)];
        for camera in [perspective(), orthographic()] {
            for (shape, settings) in SHAPES.into_iter().flat_map(|shape| all.map(|settings| (shape, settings))) {
                let points = clear(&mixed, &camera, size, shape, &settings.splats);
                assert!(points.len() > 700, "{}", points.len());
                let lists = splats::lists(&camera, size, &points, shape, &settings.splats, |_| true);
                let wanted = splats::render(&camera, size, &points, &colors(&points), shape, &settings);
                let image = render(device, &points, &frame(camera, size, method(shape, settings)));
                let margins = margins(&lists, settings.blend_depth);
                let of = |wanted: &Picture| compare(&image, wanted, &margins, shape, color_error(shape));
                let doubtful = of(&wanted);
                println!("{shape:?} {settings:?}: {doubtful:?}");
                assert!(doubtful.clone().is_ok_and(|share| share < 0.01), "{shape:?} {settings:?}: {doubtful:?}");
                assert_eq!(image.fragments, None);
                // The comparison can fail: another reach, and the nearest alone.
                let other = BlendedSplats { blend_depth: settings.blend_depth + 0.2, ..settings };
                assert!(of(&splats::render(&camera, size, &points, &colors(&points), shape, &other)).is_err());
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
            let points = clear(&soup(3, 1500, 0.02..0.2, 0.1..0.9, true), &camera, size, shape, &settings.splats);
            let mut frame = frame(camera, size, method(shape, settings));
            frame.shading = Shading { model: ShadingModel::Phong, specular: 0.4, ..Shading::default() };
            frame.color = ColorSpace::Encoded;
            let colors = reference::shading::shade(&points, &camera, &frame.shading, frame.color);
            let lists = splats::lists(&camera, size, &points, shape, &settings.splats, |_| true);
            let wanted = splats::render(&camera, size, &points, &colors, shape, &settings);
            let image = render(device, &points, &frame);
            // Powers and the curve of sRGB round by themselves.
            let found = compare(&image, &wanted, &margins(&lists, settings.blend_depth), shape, 2e-4);
            assert!(found.clone().is_ok_and(|share| share < 0.01), "{shape:?}: {found:?}");
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
        let size = [160, 96];
        // Every tile has some 2500 splats, of which a run takes 2048; unclamped.
        let points =
            scene(&[soup(41, 2300, 2.0..3.0, 0.001..0.02, true), soup(42, 300, 0.0..0.1, 0.1..0.9, true)].concat());
        for (shape, camera) in [(Shape::Disc, perspective()), (Shape::Oriented, orthographic())] {
            let settings = blended(1.0, 1e9, 0.4);
            let mut renderer = Renderer::new(device).expect("a renderer");
            let mut cloud = renderer.upload(&points).expect("fits");
            let mut frame = frame(camera, size, method(shape, settings));
            let whole = renderer.render(&mut cloud, &frame).expect("renders");
            assert_eq!((runs(&whole, "splats/visibility"), runs(&whole, "splats/attributes")), (2, 2));
            assert_eq!((whole.facts.windows, whole.facts.splatted, whole.facts.layered), (1, 1, 0));
            let lists = splats::lists(&camera, size, &points, shape, &settings.splats, |_| true);
            let margins = margins(&lists, settings.blend_depth);
            let wanted = splats::render(&camera, size, &points, &colors(&points), shape, &settings);
            // Coverage is not safe here: rims may fall on either side of a pixel's centre.
            let off = (0..margins.len()).filter(|at| {
                let far =
                    whole.image.rgba[*at].iter().zip(wanted.rgba[*at]).any(|(a, b)| (f64::from(*a) - b).abs() > 1e-4);
                far && margins[*at] > depth_error(shape)
            });
            let off: Vec<usize> = off.collect();
            // How many splats cover a pixel if their radii are a few roundings smaller, or larger.
            let lengths = |factor: f32| -> Vec<usize> {
                let radii = points.radii.iter().map(|radius| radius * factor).collect();
                let points = Points { radii, ..points.clone() };
                splats::lists(&camera, size, &points, shape, &settings.splats, |_| true).iter().map(Vec::len).collect()
            };
            let (fewer, more) = (lengths(1.0 - 1e-5), lengths(1.0 + 1e-5));
            assert!(off.iter().all(|at| fewer[*at] != more[*at]), "{shape:?}: {off:?}");
            assert!(off.len() < 40, "{shape:?}: {off:?}");
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
        for n in [2usize, 8, 255, 2047, 2048, 2049, 10_000] {
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
        let wanted = splats::render(
            &frame.camera,
            frame.size,
            &points,
            &colors(&points),
            Shape::Oriented,
            &BlendedSplats::default(),
        );
        let (_, over) = difference(&image, &wanted, 1e-3);
        assert!(over < 0.03, "{over}");
    });
}
