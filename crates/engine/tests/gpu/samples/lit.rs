//! Eye-dome lighting, which lights each image by its own depths, and shadows, which no image moves.

use glam::Vec3;
use pellucid_reference::abuffer::{depth_margin, lists, median, splat};
use pellucid_reference::coverage::Shape;
use pellucid_reference::range::DEPTH_ERROR;
use pellucid_reference::shading::shade_lit;
use pellucid_reference::{abuffer, edl, opaque};
use pellucid_scene::{Discs, Edl, Light, ScreenSplats, Shading, ShadingModel};

use super::*;

const STRENGTH: f32 = 0.02;
const RADIUS: f32 = 1.4;

/// A picture with its colors times the factors of depths, which float32 knows to [`DEPTH_ERROR`]: the arithmetic's own
/// error is that of `edl.rs`, and each of up to 8 differences of logarithms has two of depths.
fn lit(picture: PictureRange, depths: &[f64]) -> PictureRange {
    let strength = f64::from(STRENGTH);
    let factors = edl::factors(depths, SIZE, strength, RADIUS.into());
    let of_depths = 300.0 * strength * 2.0 * DEPTH_ERROR * std::f64::consts::LOG2_E;
    let pixel = |(rgba, factor): (&reference::range::ColorRange, f64)| {
        let share = factor * ((crate::edl::slack(strength, -factor.ln()) + of_depths).exp_m1() + 4.0 * ROUNDING);
        std::array::from_fn(|c| match c {
            3 => rgba[3],
            _ => rgba[c].scaled(factor).widened(share * rgba[c].high),
        })
    };
    PictureRange { rgba: picture.rgba.iter().zip(factors).map(pixel).collect(), ..picture }
}

fn domed(frame: Frame) -> Frame {
    let edl = Edl { edl: true, edl_strength: STRENGTH, edl_radius: RADIUS };
    Frame { shading: Shading { edl, ..frame.shading }, ..frame }
}

#[test]
fn each_image_of_opaque_splats_is_lit_by_its_own_depths() {
    with_device(|device| {
        let settings = ScreenSplats::default();
        for (method, shape) in [(Method::Points, Shape::Point), (Method::Circles(settings), Shape::Disc)] {
            for camera in cameras() {
                let points =
                    clear(&mixed(21), &camera, SIZE, |_, points, i| opaque::splat(points, i, shape, &settings));
                let colors = colors(&points);
                let plain = |one: &One| {
                    opaque::render(View::new(one.camera, SIZE), &points, &colors, shape, &settings, method.relief())
                };
                let image = |one: &One| {
                    let picture = plain(one);
                    lit(of_picture(&picture), &picture.depth)
                };
                let frame = domed(frame(camera, SIZE, method));
                let name = format!("{method:?}, lit");
                let subject =
                    Subject { name, points: &points, frame, image: Box::new(image), slack: 1e-6, counts: false };
                subject.check(device);
                // The mean lit by the middle image's depths is another picture.
                let mean = mean(
                    &reference::samples::cameras(&camera, 4)
                        .iter()
                        .zip(0..)
                        .map(|(camera, number)| of_picture(&plain(&One { camera, number })))
                        .collect::<Vec<_>>(),
                );
                let middle = plain(&One { camera: &reference::samples::cameras(&camera, 4)[2], number: 2 });
                let wrong = lit(mean, &middle.depth);
                let found = subject.found(&mut Renderer::new(device).expect("a renderer"), 4);
                assert!(subject.compare_with(&found, &wrong).is_err(), "{method:?}");
            }
        }
    });
}

#[test]
fn each_image_of_discs_is_lit_by_its_own_median_depths() {
    with_device(|device| {
        let (discs, camera) = (Discs::default(), perspective());
        let points = clear(&mixed(23), &camera, SIZE, |_, points, i| splat(points, i, discs.shape));
        let colors = colors(&points);
        let image = |one: &One| {
            let view = View::new(one.camera, SIZE);
            let lists = lists(view, &points, &discs);
            let [early, depths, late] =
                [0.5 + 1e-5, 0.5, 0.5 - 1e-5].map(|share| lists.iter().map(|l| median(l, share)).collect::<Vec<_>>());
            let mut ranges = of_picture(&abuffer::render(view, &points, &colors, &discs));
            // Where order or median are a matter of roundings, nor are the pixels around known.
            let unsure = |pixel: usize| early[pixel] != late[pixel] || depth_margin(&lists[pixel..=pixel]) < FLAT_DEPTH;
            let unsure: Vec<usize> = (0..lists.len()).filter(|pixel| unsure(*pixel)).collect();
            ranges = lit(ranges, &depths);
            let width = SIZE[0] as usize;
            let near =
                |a: usize, b: usize| (a % width).abs_diff(b % width) <= 1 && (a / width).abs_diff(b / width) <= 1;
            open(&mut ranges, |pixel| unsure.iter().any(|other| near(pixel, *other)));
            ranges
        };
        let frame = domed(frame(camera, SIZE, Method::ABuffer(discs)));
        let name = "abuffer, lit".to_owned();
        Subject { name, points: &points, frame, image: Box::new(image), slack: 3e-5, counts: true }.check(device);
    });
}

#[test]
fn shadows_are_those_of_the_scene_in_every_image() {
    with_device(|device| {
        let light = Light::Direction(DVec3::new(0.3, -1.0, -0.2));
        let shading = Shading { model: ShadingModel::Lambert, ambient: 0.1, diffuse: 0.9, light, ..Shading::default() };
        let shadows = crate::shadows::hard(48, 0.1);
        let settings = ScreenSplats::default();
        for camera in cameras() {
            let soup: Vec<P> = mixed(25).into_iter().map(|p| P { normal: Vec3::ZERO, ..p }).collect();
            let points = clear(&soup, &camera, SIZE, |_, points, i| opaque::splat(points, i, Shape::Disc, &settings));
            let (_, shares) = crate::shadows::textures(device, &points, light, shadows, 3);
            let dark = shares.iter().filter(|m| m.high < 1.0).count();
            assert!(dark > 20, "{dark} points are in shadow");
            let frame =
                Frame { shading, shadows: Some(shadows), seed: 3, ..frame(camera, SIZE, Method::Circles(settings)) };
            let [low, high] = [|m: &Range| m.low, |m: &Range| m.high].map(|end| {
                let lit: Vec<f64> = shares.iter().map(end).collect();
                shade_lit(&points, &camera, &shading, frame.color, &lit)
            });
            let image = |one: &One| {
                let of = |colors: &[DVec3]| {
                    let view = View::new(one.camera, SIZE);
                    of_picture(&opaque::render(view, &points, colors, Shape::Disc, &settings, frame.method.relief()))
                };
                let (least, most) = (of(&low), of(&high));
                let rgba = least.rgba.iter().zip(&most.rgba).map(|(a, b)| reference::range::hull(*a, *b)).collect();
                PictureRange { rgba, ..least }
            };
            let name = "circles, in shadow".to_owned();
            // As in the tests of shadows.
            Subject { name, points: &points, frame, image: Box::new(image), slack: 1e-5, counts: false }.check(device);
        }
    });
}
