//! Bytes that samples may not change, passes that run once, and numbers that are refused.

use std::sync::Arc;

use glam::Vec3;
use pellucid_engine::methods::{Error, PassProfile};
use pellucid_scene::prepare::Arranged;
use pellucid_scene::prepare::ensembles::Dealt;
use pellucid_scene::{Discs, Edl, GaussianSettings, Light, ScreenSplats, Shading, ShadingModel};
use rand::seq::SliceRandom;

use super::*;

/// Points of all kinds: a third is soft, and depths tie.
fn points_of(soup: &[P]) -> Points {
    let mut points = scene(soup);
    points.fields = points.positions.iter().map(|p| if p.x > 0.3 { 1.0 } else { 0.0 }).collect();
    points
}

fn tied(seed: u64) -> Vec<P> {
    let mut soup = mixed(seed);
    soup.iter_mut().for_each(|p| p.position = (p.position * 8.0).round() / 8.0);
    soup
}

/// Points for every method: those that are dealt, and the others.
struct Stage {
    renderer: Renderer,
    points: Points,
    dealt: Dealt,
}

impl Stage {
    fn new(device: &Device) -> Self {
        let renderer = Renderer::new(device).expect("a renderer");
        Self { renderer, points: points_of(&tied(41)), dealt: crate::spbr::mixture(3) }
    }

    fn render(&mut self, frame: &Frame) -> Image {
        let mut cloud = match frame.method.is_dealt() {
            true => self.renderer.upload(&Arranged::Dealt(self.dealt.clone())),
            false => self.renderer.upload(&self.points),
        }
        .expect("fits");
        let rendered = self.renderer.render(&mut cloud, frame);
        rendered.unwrap_or_else(|error| panic!("{:?} in {:?}: {error:?}", frame.method, frame.memory_budget)).image
    }
}

/// Images of one frame foresee the counts of the next: of a list that fits the memory, but not with a margin, too.
#[test]
fn lists_that_fit_without_a_margin_alone_are_whole_in_every_image() {
    with_device(|device| {
        let points = points_of(&mixed(41));
        let discs = Discs::default();
        for method in [Method::ABuffer(discs), Method::LinkedList(discs)] {
            let frame = Frame { size: [160, 120], ..sampled(cameras()[0], method, 4) };
            let first = render(device, &points, &frame);
            // Counts of 1.6 to 2.4 MB of fragments, in steps of a twentieth.
            for budget in (24..=40).map(|step| step << 16) {
                let found = render(device, &points, &Frame { memory_budget: Some(budget), ..frame });
                assert!(all_bits(&found) == all_bits(&first), "{}: {budget}", method.name());
            }
        }
    });
}

fn all_bits(image: &Image) -> (Vec<u32>, &Option<Vec<u32>>, Vec<u32>) {
    let errors = image.stderr.iter().flatten().flatten().map(|error| error.to_bits()).collect();
    (bits(image), &image.fragments, errors)
}

#[test]
fn one_sample_is_the_image_itself() {
    with_device(|device| {
        let mut stage = Stage::new(device);
        for method in Method::all() {
            for color in [ColorSpace::Linear, ColorSpace::Encoded] {
                let plain = Frame { color, background: Vec3::ONE, ..frame(cameras()[0], SIZE, method) };
                assert_eq!((plain.samples, plain.camera.shift), (1, DVec2::ZERO));
                let image = stage.render(&plain);
                let alone = stage.render(&plain.image(0));
                assert!(all_bits(&image) == all_bits(&alone), "{}", method.name());
                // Encoded values stay what they are: no background counts.
                let other = stage.render(&Frame { background: Vec3::ZERO, ..plain });
                assert!(all_bits(&image) == all_bits(&other), "{}", method.name());
            }
        }
    });
}

#[test]
fn the_picture_is_the_rounded_mean_of_the_images_one_by_one() {
    with_device(|device| {
        let mut stage = Stage::new(device);
        // Four at once are rounded elsewhere.
        stage.renderer.switches.together = false;
        for method in Method::all() {
            for (samples, edl) in [(2, false), (4, method.takes_edl())] {
                let mut frame = sampled(cameras()[0], method, samples);
                frame.shading.edl = Edl { edl, edl_strength: 0.02, ..Edl::default() };
                let picture = stage.render(&frame);
                let images: Vec<Image> = (0..samples).map(|number| stage.render(&frame.image(number))).collect();
                let middle = &images[samples as usize / 2];
                let name = method.name();
                assert!(picture.depth == middle.depth, "{name}");
                for (pixel, found) in picture.rgba.iter().enumerate() {
                    for (c, found) in found.iter().enumerate() {
                        // Sums of so few numbers of 24 bits are exact in 53, but for large differences of size.
                        let sum: f64 = images.iter().map(|image| f64::from(image.rgba[pixel][c])).sum();
                        let wanted = sum / f64::from(samples);
                        let off = (f64::from(*found) - wanted).abs();
                        assert!(off <= ROUNDING * (1.0 + 1e-6) * wanted.abs(), "{name}, pixel {pixel}: {found}");
                    }
                }
                let Some(sums) = &picture.fragments else { continue };
                for (pixel, sum) in sums.iter().enumerate() {
                    let wanted: u32 = images.iter().flat_map(|image| &image.fragments).map(|of| of[pixel]).sum();
                    assert_eq!(*sum, wanted, "{name}, pixel {pixel}");
                }
            }
        }
    });
}

#[test]
fn neither_budgets_nor_windows_nor_the_order_of_input_change_a_byte() {
    with_device(|device| {
        let mut stage = Stage::new(device);
        let size = [160, 120];
        for method in Method::all() {
            let frame = Frame { size, ..sampled(cameras()[0], method, 4) };
            let first = stage.render(&frame);
            for memory_budget in [Some(2 << 20), Some(400_000)] {
                let found = stage.render(&Frame { memory_budget, ..frame });
                assert!(all_bits(&found) == all_bits(&first), "{}: {memory_budget:?}", method.name());
            }
            // Its picture is that of the order in the files.
            if method.is_dealt() || matches!(method, Method::Unsorted(_) | Method::Mlab(_)) {
                continue;
            }
            let mut shuffled = tied(41);
            shuffled.shuffle(&mut random(7));
            let mut cloud = stage.renderer.upload(&points_of(&shuffled)).expect("fits");
            let found = stage.renderer.render(&mut cloud, &frame).expect("renders").image;
            assert!(all_bits(&found) == all_bits(&first), "{}: shuffled", method.name());
        }
    });
}

#[test]
fn lit_images_are_the_same_in_windows() {
    with_device(|device| {
        let mut stage = Stage::new(device);
        for method in Method::all().into_iter().filter(Method::takes_edl) {
            let mut frame = Frame { size: [160, 120], ..sampled(cameras()[1], method, 4) };
            frame.shading.edl = Edl { edl: true, edl_strength: 0.02, ..Edl::default() };
            let first = stage.render(&frame);
            let found = stage.render(&Frame { memory_budget: Some(400_000), ..frame });
            assert!(all_bits(&found) == all_bits(&first), "{}", method.name());
        }
    });
}

#[test]
fn points_that_come_window_by_window_come_to_every_image() {
    let mut points = scene(&soup(43, 60_000, 0.002..0.02, 0.1..0.9, true));
    points.fields = points.positions.iter().map(|p| (0.5 + 0.5 * p.x).clamp(0.0, 1.0) as f32).collect();
    let points = Arc::new(points);
    with_device(|device| {
        let mut renderer = Renderer::new(device).expect("a renderer");
        for method in Method::all().into_iter().filter(|method| !method.is_dealt()) {
            let whole = Frame { size: [160, 120], ..sampled(perspective(), method, 4) };
            let mut cloud = renderer.upload(&*points).expect("room for the points");
            let expected = renderer.render(&mut cloud, &whole).expect("a frame");
            let mut supplied = by_windows(&renderer, &points);
            let small = Frame { memory_budget: Some(9 << 20), ..whole };
            let found = renderer.render(&mut supplied, &small).expect("a frame");
            assert!(found.facts.windows > 1 && supplied.len() < 40_000);
            assert!(all_bits(&found.image) == all_bits(&expected.image), "{}", method.name());
        }
    });
}

fn casts(passes: &[PassProfile]) -> Vec<&'static str> {
    passes.iter().map(|pass| pass.name).filter(|name| name.starts_with("shadows/")).collect()
}

#[test]
fn shadows_are_cast_once_whatever_the_number_of_samples() {
    with_device(|device| {
        let light = Light::Direction(DVec3::new(0.3, -1.0, -0.2));
        let shading = Shading { model: ShadingModel::Lambert, light, ..Shading::default() };
        let shadows = Some(crate::shadows::hard(48, 0.1));
        let points = scene(&mixed(45));
        for method in [Method::Points, Method::Circles(ScreenSplats::default())] {
            let of = |samples: u32, edl: bool| {
                let mut frame = Frame { shadows, shading, ..sampled(cameras()[0], method, samples) };
                frame.shading.edl.edl = edl;
                casts(&rendered(device, &points, &frame).profile.passes)
            };
            let once = of(1, false);
            assert!(!once.is_empty());
            for samples in COUNTS {
                assert_eq!(of(samples, false), once, "{samples}");
            }
            assert_eq!(of(4, true), once, "each image lit by itself");
        }
    });
}

/// A Gaussian whose center lies at 1.3 of the depth beside the axis. The image's border is at 0.82, its clamp at 1.06.
fn beyond_the_clamp() -> Points {
    let mut points = pellucid_testing::gaussians::Soup { count: 1, ..Default::default() }.points();
    points.positions[0] = DVec3::new(2.6, 0.0, 0.0);
    points.opacities[0] = 0.9;
    let gaussians = points.gaussians.as_mut().expect("one");
    (gaussians.extents[0], gaussians.rotations[0]) = (Vec3::new(0.5, 0.5, 0.6), glam::Quat::IDENTITY);
    points.radii[0] = pellucid_core::cloud::gaussians::REACH * 0.6;
    points
}

/// A Gaussian beyond 1.3 times the half image is projected by the slope there. A picture that is moved by whole pixels
/// shows the same values, unless that place moved with it.
#[test]
fn clamps_of_projected_gaussians_stay_where_they_are() {
    with_device(|device| {
        let projection = Projection::Perspective { fov_y: 60f64.to_radians() };
        let eye = 2.0 * DVec3::Z;
        let camera = Camera::look_at(eye, DVec3::ZERO, DVec3::Y, projection, 0.1, 100.0).expect("valid");
        let plain =
            frame(camera, SIZE, Method::ABuffer(Discs { gaussians: GaussianSettings::default(), ..Discs::default() }));
        let (width, by) = (SIZE[0] as usize, 4usize);
        let moved = Camera { shift: DVec2::new(-(by as f64), 0.0), ..camera };
        // A wider image, whose clamps are farther out by as much, shows that they count.
        let wider = Frame { size: [SIZE[0] + 2 * by as u32, SIZE[1]], ..plain };
        let points = beyond_the_clamp();
        let [image, found, wide] =
            [plain, Frame { camera: moved, ..plain }, wider].map(|f| render(device, &points, &f));
        let apart = |a: [f32; 4], b: [f32; 4]| a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
        let inside: Vec<usize> = (0..image.rgba.len()).filter(|pixel| pixel % width >= by).collect();
        let most = |of: &dyn Fn(usize) -> f32| inside.iter().map(|pixel| of(*pixel)).fold(0.0, f32::max);
        let moved = most(&|pixel| apart(image.rgba[pixel], found.rgba[pixel - by]));
        let at = |pixel: usize| pixel / width * (width + 2 * by) + pixel % width + by;
        let widened = most(&|pixel| apart(image.rgba[pixel], wide.rgba[at(pixel)]));
        // Places on the screen have some ten roundings of numbers below 100, at most a fifth of the opacity a pixel.
        assert!(moved < 1e-5 && widened > 1e-2, "{moved}, {widened}");
    });
}

#[test]
fn other_numbers_of_samples_are_refused() {
    with_device(|device| {
        let mut renderer = Renderer::new(device).expect("a renderer");
        let mut cloud = renderer.upload(&scene(&mixed(47))).expect("fits");
        for samples in [0, 3, 5, 63, 65, 128, u32::MAX] {
            let frame = sampled(perspective(), Method::Points, samples);
            let error = renderer.render(&mut cloud, &frame).expect_err("refused");
            assert!(matches!(error, Error::PixelSamples { samples: found } if found == samples), "{error:?}");
            assert_eq!(error.to_string(), format!("{samples} samples per pixel; use 1, 2, 4, 8, 16, 32 or 64"));
        }
        // Nor is there an image behind the last.
        let frame = Frame { only: Some(4), ..sampled(perspective(), Method::Points, 4) };
        renderer.render(&mut cloud, &frame).expect_err("refused");
        renderer.render(&mut cloud, &Frame { only: Some(3), ..frame }).expect("the last one");
    });
}
