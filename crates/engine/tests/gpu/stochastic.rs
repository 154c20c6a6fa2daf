//! `stochastic`: each sample's mask against the host's, images against the float64 reference with the same masks; means
//! over seeds against the exact image; how the error falls; what the standard error says; same input, same bytes.

use glam::{DVec3, Vec3};
use pellucid_core::camera::Camera;
use pellucid_core::image::Image;
use pellucid_core::points::Points;
use pellucid_core::random::{mask, word};
use pellucid_engine::methods::{Frame, Renderer};
use pellucid_engine::passes::project::DeviceCloud;
use pellucid_gpu::Device;
use pellucid_reference::View;
use pellucid_reference::abuffer::{Fragment, depth_margin, lists};
use pellucid_reference::stochastic::render_with;
use pellucid_reference::{self as reference, ReferencePicture};
use pellucid_scene::{DiscShape, Discs, Falloff, Method, Stochastic};
use pellucid_testing::*;
use rand::RngExt;
use rand::seq::SliceRandom;

/// Seeds over which means are taken.
const SEEDS: u64 = 64;

fn plain(samples: u32) -> Stochastic {
    Stochastic { samples, alpha_correction: false, ..Stochastic::default() }
}

fn corrected(samples: u32) -> Stochastic {
    Stochastic { samples, ..Stochastic::default() }
}

fn seeded(frame: &Frame, settings: Stochastic, seed: u64) -> Frame {
    Frame { method: Method::Stochastic(settings), seed, ..*frame }
}

/// A renderer with a scene on it.
struct Stage {
    renderer: Renderer,
    cloud: DeviceCloud,
    frame: Frame,
}

impl Stage {
    fn new(device: &Device, points: &Points, camera: Camera, size: [u32; 2]) -> Self {
        let renderer = Renderer::new(device).expect("a renderer");
        let cloud = renderer.upload(points).expect("fits");
        Self { renderer, cloud, frame: frame(camera, size, Method::Stochastic(Stochastic::default())) }
    }

    fn image(&mut self, settings: Stochastic, seed: u64) -> Image {
        let frame = seeded(&self.frame, settings, seed);
        self.renderer.render(&mut self.cloud, &frame).expect("renders").image
    }
}

/// A point that covers one pixel of [`pixel_camera`].
fn dot(x: u32, y: u32, depth: f64, color: Vec3, opacity: f32) -> P {
    let position = at_pixel(f64::from(x) + 0.5, f64::from(y) + 0.5, depth);
    P { position, color, opacity, radius: 0.0, normal: Vec3::ZERO }
}

#[test]
fn every_sample_is_covered_as_the_host_says() {
    with_device(|device| {
        // On each pixel a black dot of random opacity before a white one: what shines through are the samples not
        // covered.
        let size = [37, 29];
        let mut r = random(1);
        let mut dots = Vec::new();
        for (x, y) in (0..size[1]).flat_map(|y| (0..size[0]).map(move |x| (x, y))) {
            let opacity = match (x + y) % 8 {
                0 => [0.0, 1.0, 0.25, 0.5, 0.75, 1e-9, 1.0 - f32::EPSILON / 2.0][r.random_range(0..7)],
                _ => r.random(),
            };
            dots.push(dot(x, y, 1.0, Vec3::ZERO, opacity));
            dots.push(dot(x, y, 2.0, Vec3::ONE, 1.0));
        }
        let points = scene(&dots);
        let lists = lists(View::new(&pixel_camera(size), size), &points, &Discs::default());
        let ids = points.ids(&points.anchor(), 0..points.len());
        let mut stage = Stage::new(device, &points, pixel_camera(size), size);
        for samples in [1, 2, 3, 4, 5, 6, 7, 8, 13, 16, 17, 30, 31, 32, 33, 34, 61, 64] {
            for seed in [0, 7, u64::from(u32::MAX), 0x1234_5678_9abc_def0] {
                let image = stage.image(plain(samples), seed);
                for (at, (rgba, list)) in image.rgba.iter().zip(&lists).enumerate() {
                    let pixel = [at as u32 % size[0], at as u32 / size[0]];
                    let covered = |s: u32| {
                        mask(list[0].alpha as f32, word(seed, pixel, ids[list[0].index as usize], s / 4)) >> (s % 4) & 1
                    };
                    let through = samples - (0..samples).map(covered).sum::<u32>();
                    let found = rgba[0] * samples as f32;
                    assert!((found - through as f32).abs() < 1e-4, "{pixel:?}, seed {seed}: {found} {through}");
                }
            }
        }
    });
}

/// The decisions on a pixel that float32 may take differently from the reference.
struct Doubt {
    /// Relative errors of depths and of opacities.
    depth: f64,
    alpha: f64,
}

impl Doubt {
    /// A few roundings of a flat disc's depth; an oriented one adds its slope. A Gaussian adds errors of ρ and of exp.
    fn from_discs(discs: &Discs) -> Self {
        let depth = if discs.shape == DiscShape::Flat { 1e-6 } else { 4e-5 };
        let alpha = if discs.falloff == Falloff::Flat { 0.0 } else { 2e-5 };
        Self { depth, alpha }
    }

    /// True if order or masks of some fragments depend on rounding.
    fn about(&self, (list, ids): (&[Fragment], &[u32]), pixel: [u32; 2], samples: u32, seed: u64) -> bool {
        let unsure = |f: &Fragment, p: u32| {
            let [low, high] = [1.0 - self.alpha, 1.0 + self.alpha].map(|factor| (f.alpha * factor) as f32);
            let word = word(seed, pixel, ids[f.index as usize], p);
            mask(low, word) != mask(high, word)
        };
        let masks = self.alpha > 0.0 && list.iter().any(|f| (0..samples.div_ceil(4)).any(|p| unsure(f, p)));
        masks || depth_margin(&[list.to_vec()]) < self.depth
    }
}

/// Compares an image and its standard error with the reference, where that is clear in float32; the share of such
/// pixels.
///
/// The bound: one rounding of at most 2^-24 of the sum for each fragment and run of 16 samples, and some for the rest.
/// Standard errors are roots of sums of squares, which lose more.
fn compare(
    image: &Image,
    (wanted, errors): &(ReferencePicture, Vec<DVec3>),
    (lists, ids): (&[Vec<Fragment>], &[u32]),
    settings: &Stochastic,
    seed: u64,
) -> Result<f64, String> {
    let doubt = Doubt::from_discs(&settings.discs);
    let stderr = image.stderr.as_deref().ok_or("no standard error")?;
    let mut clear = 0;
    for (at, list) in lists.iter().enumerate() {
        let pixel = [at as u32 % image.width, at as u32 / image.width];
        if doubt.about((list, ids), pixel, settings.samples, seed) {
            continue;
        }
        clear += 1;
        let steps = list.len() as f64 + f64::from(settings.samples) / 16.0 + 8.0;
        for (found, wanted) in image.rgba[at].iter().zip(wanted.rgba[at]) {
            let bound = (steps * 2f64.powi(-23) + doubt.alpha * list.len() as f64) * (1.0 + wanted.abs());
            let apart = (f64::from(*found) - wanted).abs();
            if apart.is_nan() || apart > bound {
                return Err(format!("{pixel:?}: {found} {wanted}, {} fragments", list.len()));
            }
        }
        let (found, depth) = (f64::from(image.depth[at]), wanted.depth[at]);
        if found != depth && (found - depth).abs() > 4e-5 * depth {
            return Err(format!("{pixel:?}: depth {found} {depth}"));
        }
        for (found, wanted) in stderr[at].iter().zip(errors[at].to_array()) {
            let found = f64::from(*found);
            if found != wanted && (found - wanted).abs() > 2e-4 * (wanted + 1.0) {
                return Err(format!("{pixel:?}: standard error {found} {wanted}"));
            }
        }
    }
    Ok(f64::from(clear) / lists.len() as f64)
}

#[test]
fn images_equal_the_reference_with_the_same_masks() {
    with_device(|device| {
        let size = [64, 48];
        let mixed = [soup(3, 500, 0.0..0.1, 0.0..1.0, true), soup(4, 40, 0.2..2.0, 0.05..1.0, true)].concat();
        for camera in [perspective(), orthographic()] {
            for discs in
                SHAPES.into_iter().flat_map(|s| FALLOFFS.map(|falloff| Discs { shape: s, falloff, ..Discs::default() }))
            {
                let points = scene(&safe(&mixed, &camera, size, discs.shape));
                let ids = points.ids(&points.anchor(), 0..points.len());
                let lists = lists(View::new(&camera, size), &points, &discs);
                let mut stage = Stage::new(device, &points, camera, size);
                for samples in [1, 3, 4, 6, 8, 64] {
                    for alpha_correction in [false, true] {
                        let settings = Stochastic { discs, samples, alpha_correction };
                        let seed = u64::from(samples) + 5;
                        let image = stage.image(settings, seed);
                        let wanted = |seed: u64| {
                            reference::stochastic::render(
                                View::new(&camera, size),
                                &points,
                                &colors(&points),
                                &settings,
                                seed,
                            )
                        };
                        let clear = compare(&image, &wanted(seed), (&lists, &ids), &settings, seed);
                        assert!(clear.clone().is_ok_and(|share| share > 0.8), "{settings:?}: {clear:?}");
                        // The comparison can fail.
                        assert!(compare(&image, &wanted(seed + 1), (&lists, &ids), &settings, seed).is_err());
                        assert_eq!(image.fragments, Some(lists.iter().map(|l| l.len() as u32).collect()));
                    }
                }
            }
        }
    });
}

/// Coincident discs of different colors over a few pixels.
fn coincident(count: usize) -> Vec<P> {
    let mut r = random(17);
    (0..count)
        .map(|i| P {
            position: at_pixel(8.0, 8.0, 5.0),
            color: Vec3::new(r.random(), r.random(), (i % 2) as f32),
            opacity: r.random_range(0.1..0.9),
            radius: 5.3,
            normal: Vec3::ZERO,
        })
        .collect()
}

#[test]
fn coincident_splats_are_ordered_by_their_index() {
    with_device(|device| {
        let (camera, size) = (pixel_camera([16, 16]), [16, 16]);
        let points = scene(&coincident(12));
        let ids = points.ids(&points.anchor(), 0..points.len());
        let lists = lists(View::new(&camera, size), &points, &Discs::default());
        assert!(lists.iter().any(|list| list.len() == 12));
        let mut stage = Stage::new(device, &points, camera, size);
        for settings in [plain(6), plain(64), corrected(6), corrected(64)] {
            let image = stage.image(settings, 3);
            let wanted =
                reference::stochastic::render(View::new(&camera, size), &points, &colors(&points), &settings, 3);
            assert_eq!(compare(&image, &wanted, (&lists, &ids), &settings, 3), Ok(1.0), "{settings:?}");
        }
    });
}

/// Means and variances over seeds, of R, G, B and A of each pixel.
struct Moments {
    mean: Vec<[f64; 4]>,
    variance: Vec<[f64; 4]>,
}

/// Mean and variance of the images that `render` gives for [`SEEDS`] seeds.
fn moments(mut render: impl FnMut(u64) -> Vec<[f64; 4]>) -> Moments {
    let images: Vec<Vec<[f64; 4]>> = (0..SEEDS).map(|seed| render(seed * 7919 + 1)).collect();
    let of = |value: &dyn Fn(usize, usize) -> f64| -> Vec<[f64; 4]> {
        (0..images[0].len()).map(|at| std::array::from_fn(|i| value(at, i))).collect()
    };
    let n = SEEDS as f64;
    let mean = of(&|at, i| images.iter().map(|image| image[at][i]).sum::<f64>() / n);
    let variance =
        of(&|at, i| images.iter().map(|image| (image[at][i] - mean[at][i]).powi(2)).sum::<f64>() / (n - 1.0));
    Moments { mean, variance }
}

fn doubles(image: &Image) -> Vec<[f64; 4]> {
    image.rgba.iter().map(|c| c.map(f64::from)).collect()
}

/// Tests that means over seeds agree with the exact image, by two tests of R, G, B and A: the mean over all pixels lies
/// within 4 of its standard errors, and so does nearly every single pixel. Of normally distributed means 1 in 5800
/// would lie beyond 4 errors estimated from 64 samples; of means of few skewed samples more.
fn unbiased(found: &Moments, exact: &[[f64; 4]]) -> Result<(), String> {
    let n = SEEDS as f64;
    let (mut beyond, mut drawn) = (0, 0);
    for i in 0..4 {
        let (mut sum, mut square) = (0.0, 0.0);
        for (at, exact) in exact.iter().enumerate() {
            let (off, error) = (found.mean[at][i] - exact[i], (found.variance[at][i] / n).sqrt());
            // Float32 sums of up to a hundred fragments.
            beyond += usize::from(off.abs() > 4.0 * error + 1e-5);
            drawn += usize::from(exact[i] > 0.0);
            sum += off;
            square += error * error;
        }
        let error = square.sqrt();
        if sum.abs() > 4.0 * error + 1e-5 * exact.len() as f64 {
            return Err(format!("channel {i}: the image's mean is off by {} standard errors", sum / error));
        }
    }
    let share = beyond as f64 / drawn.max(1) as f64;
    if share > 0.005 {
        return Err(format!("{share} of the pixels are off by more than 4 standard errors"));
    }
    Ok(())
}

/// Scenes with exact images that the tests of means know: name, camera, points, discs.
fn scenes() -> Vec<(&'static str, Camera, Points, Discs)> {
    let flat = Discs::default();
    let oriented = Discs { shape: DiscShape::Oriented, ..flat };
    let gaussian = Discs { falloff: Falloff::Gaussian, ..flat };
    let mut r = random(23);
    let stack: Vec<P> = (0..30)
        .map(|i| P {
            position: at_pixel(r.random_range(0.0..24.0), r.random_range(0.0..18.0), 1.0 + f64::from(i)),
            color: Vec3::new(r.random(), r.random(), r.random()),
            opacity: r.random_range(0.05..0.6),
            radius: r.random_range(8.0..40.0),
            normal: Vec3::ZERO,
        })
        .collect();
    let crossing = soup(29, 300, 0.1..0.5, 0.1..0.9, true);
    vec![
        ("soup", perspective(), scene(&soup(27, 400, 0.05..0.4, 0.05..0.95, false)), flat),
        ("gaussian soup", orthographic(), scene(&soup(28, 300, 0.1..0.6, 0.05..0.95, false)), gaussian),
        ("stack", pixel_camera(SMALL), scene(&stack), flat),
        ("crossing", perspective(), scene(&crossing), oriented),
    ]
}

const SMALL: [u32; 2] = [24, 18];

/// The exact image by the A-buffer on the same device, so that coverage is decided alike.
fn exact_on(device: &Device, points: &Points, camera: Camera, discs: Discs) -> Vec<[f64; 4]> {
    doubles(&render(device, points, &frame(camera, SMALL, Method::ABuffer(discs))))
}

#[test]
fn without_correction_means_over_seeds_are_exact_and_correlated_masks_are_not() {
    with_device(|device| {
        for (name, camera, points, discs) in scenes() {
            let exact = exact_on(device, &points, camera, discs);
            let mut stage = Stage::new(device, &points, camera, SMALL);
            let settings = Stochastic { discs, ..plain(16) };
            let found = unbiased(&moments(|seed| doubles(&stage.image(settings, seed))), &exact);
            assert_eq!(found, Ok(()), "{name}");
            // Masks that don't know the splat let every fragment of a pixel cover the same samples.
            let colors = colors(&points);
            let correlated = moments(|seed| {
                let words = |pixel, _, p| word(seed, pixel, 0, p);
                render_with(View::new(&camera, SMALL), &points, &colors, &settings, words).0.rgba
            });
            assert!(unbiased(&correlated, &exact).is_err(), "{name}: correlated masks pass");
        }
    });
}

/// Root mean square over pixels of R, G and B.
fn rms(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0usize), |(sum, count), v| (sum + v * v, count + 1));
    (sum / count as f64).sqrt()
}

fn rmse(image: &[[f64; 4]], exact: &[[f64; 4]]) -> f64 {
    rms(image.iter().zip(exact).flat_map(|(a, b)| (0..3).map(|i| a[i] - b[i])))
}

#[test]
fn with_correction_alpha_is_exact_and_the_bias_of_color_small() {
    with_device(|device| {
        for (name, camera, points, discs) in scenes() {
            let exact = exact_on(device, &points, camera, discs);
            let mut stage = Stage::new(device, &points, camera, SMALL);
            for samples in [4, 16, 64] {
                let found = moments(|seed| doubles(&stage.image(Stochastic { discs, ..corrected(samples) }, seed)));
                let alpha = found.mean.iter().zip(&exact).map(|(a, b)| (a[3] - b[3]).abs()).fold(0.0, f64::max);
                assert!(alpha < 1e-5 && found.variance.iter().all(|v| v[3] < 1e-10), "{name}: A off by {alpha}");
                // Subtracts the noise of a mean of 64 seeds.
                let chance = rms(found.variance.iter().flat_map(|v| (0..3).map(|i| (v[i] / SEEDS as f64).sqrt())));
                let off = rmse(&found.mean, &exact);
                let bias = (off * off - chance * chance).max(0.0).sqrt();
                let deviation = chance * (SEEDS as f64).sqrt();
                eprintln!("{name}, {samples} samples: bias {bias:.5}, standard deviation {deviation:.5}");
                // That of a ratio falls as 1 / samples.
                assert!(bias < 0.06 / f64::from(samples), "{name}, {samples} samples: bias {bias}");
            }
        }
    });
}

#[test]
fn errors_fall_with_the_root_of_the_samples() {
    with_device(|device| {
        for (name, camera, points, discs) in scenes() {
            let exact = exact_on(device, &points, camera, discs);
            let mut stage = Stage::new(device, &points, camera, SMALL);
            for alpha_correction in [false, true] {
                // Root mean squares over four seeds, so that chance doesn't decide.
                let error = |samples: u32| {
                    let settings = Stochastic { discs, samples, alpha_correction };
                    rms((11..15).map(|seed| rmse(&doubles(&stage.image(settings, seed)), &exact)))
                };
                let errors = [4, 16, 64, 256, 1024].map(error);
                let slope = (errors[4] / errors[0]).ln() / 256f64.ln();
                eprintln!("{name}, correction {alpha_correction}: {errors:.5?}, slope {slope:.3}");
                assert!(slope < -0.45, "{name}: {errors:?}, slope {slope}");
            }
        }
    });
}

#[test]
fn the_standard_error_is_the_spread_over_seeds() {
    with_device(|device| {
        for (name, camera, points, discs) in scenes() {
            let mut stage = Stage::new(device, &points, camera, SMALL);
            for settings in [plain(32), corrected(32), corrected(30)] {
                let settings = Stochastic { discs, ..settings };
                let mut squares = vec![[0.0; 3]; 24 * 18];
                let found = moments(|seed| {
                    let image = stage.image(settings, seed);
                    for (sum, error) in squares.iter_mut().zip(image.stderr.as_deref().expect("asked for")) {
                        (0..3).for_each(|i| sum[i] += f64::from(error[i]).powi(2) / SEEDS as f64);
                    }
                    doubles(&image)
                });
                let told: f64 = squares.iter().flatten().sum();
                let seen: f64 = found.variance.iter().flat_map(|v| &v[..3]).sum();
                let ratio = (told / seen).sqrt();
                eprintln!("{name}, {settings:?}: standard error over spread {ratio:.3}");
                // 1300 variances of 64 seeds each would agree to 1% if they were independent; R, G, B of a pixel are
                // not, and a ratio of 8 strata is a little skewed.
                assert!((ratio - 1.0).abs() < 0.06, "{name}, {settings:?}: {ratio}");
            }
            // One stratum tells no spread.
            let alone = stage.image(Stochastic { discs, ..corrected(4) }, 1);
            let errors = alone.stderr.expect("asked for");
            let drawn = |at: usize| alone.fragments.as_ref().is_some_and(|n| n[at] > 0);
            assert!((0..errors.len()).filter(|at| drawn(*at)).all(|at| errors[at] == [f32::INFINITY; 3]));
        }
    });
}

#[test]
fn no_opacity_draws_nothing_and_full_opacity_hides() {
    with_device(|device| {
        let (camera, size) = (pixel_camera([16, 16]), [16, 16]);
        let one =
            |points: &[P], settings: Stochastic| Stage::new(device, &scene(points), camera, size).image(settings, 9);
        let splat = |x: f64, depth: f64, color: Vec3, opacity: f32, radius: f32| P {
            position: at_pixel(x, 8.0, depth),
            color,
            opacity,
            radius,
            normal: Vec3::ZERO,
        };
        for settings in [plain(3), plain(16), corrected(1), corrected(16), corrected(64)] {
            let nothing = one(&[splat(8.0, 2.0, Vec3::ONE, 0.0, 5.0)], settings);
            assert!(nothing.rgba.iter().all(|c| *c == [0.0; 4]) && nothing.depth.iter().all(|d| *d == f32::INFINITY));
            // Whatever the color and size of what has no opacity, the bytes of the rest are the same.
            let with = |color: Vec3, radius: f32| {
                let others = [splat(7.0, 1.0, color, 0.0, radius), splat(9.0, 3.0, color, 0.0, radius)];
                one(
                    &[&others[..], &[splat(8.0, 2.0, Vec3::X, 0.5, 6.0), splat(8.5, 4.0, Vec3::Y, 0.7, 6.0)]].concat(),
                    settings,
                )
            };
            assert!(bits(&with(Vec3::ONE, 8.0)) == bits(&with(Vec3::ZERO, 0.0)), "{settings:?}");
            // Whatever lies behind what is opaque, the same again, and its color is exact.
            let before = |color: Vec3| {
                let hidden = [splat(7.0, 3.0, color, 0.5, 4.0), splat(9.0, 3.0, color, 1.0, 4.0)];
                one(&[&hidden[..], &[splat(8.0, 2.0, Vec3::new(0.25, 0.5, 1.0), 1.0, 20.0)]].concat(), settings)
            };
            assert!(bits(&before(Vec3::ONE)) == bits(&before(Vec3::ZERO)), "{settings:?}");
            let opaque = before(Vec3::ONE);
            assert!(opaque.rgba.iter().all(|c| *c == [0.25, 0.5, 1.0, 1.0]) && opaque.depth.iter().all(|d| *d == 2.0));
        }
    });
}

#[test]
fn same_input_same_bytes_whatever_order_budget_or_windows() {
    with_device(|device| {
        let (camera, size) = (perspective(), [150, 100]);
        // Many splats in a tile: more than one run takes.
        let mut points =
            [soup(31, 400, 0.001..0.5, 0.1..0.9, true), soup(32, 5000, 0.3..0.6, 0.001..0.01, true)].concat();
        points[..200].iter_mut().for_each(|p| p.position = (p.position * 4.0).round() / 4.0);
        let all = |image: &Image| {
            let errors = image.stderr.iter().flatten().flatten().map(|e| e.to_bits());
            bits(image).into_iter().chain(errors).collect::<Vec<u32>>()
        };
        for shape in SHAPES {
            let discs = Discs { shape, ..Discs::default() };
            for settings in [Stochastic { discs, ..corrected(22) }, Stochastic { discs, ..plain(8) }] {
                let mut stage = Stage::new(device, &scene(&points), camera, size);
                let first = stage.image(settings, 5);
                assert!(all(&stage.image(settings, 5)) == all(&first), "a second time");
                assert!(all(&stage.image(settings, 6)) != all(&first), "another seed");
                assert!(all(&stage.image(settings, 5 + (1 << 32))) != all(&first), "a seed of 64 bits");
                let mut shuffled = points.clone();
                shuffled.shuffle(&mut random(3));
                let again = Stage::new(device, &scene(&shuffled), camera, size).image(settings, 5);
                assert!(all(&again) == all(&first), "shuffled");
                let frame = seeded(&frame(camera, size, Method::Stochastic(Stochastic::default())), settings, 5);
                let budget = Frame { memory_budget: Some(3_000_000), ..frame };
                let small = stage.renderer.render(&mut stage.cloud, &budget).expect("fits");
                assert!(small.facts.windows > 1, "{:?}", small.facts);
                assert!(all(&small.image) == all(&first), "{} windows", small.facts.windows);
                // Without what is only told, the image is the same.
                let silent = Frame { fragments: false, ..frame };
                let silent = stage.renderer.render(&mut stage.cloud, &silent).expect("renders").image;
                assert!(bits(&silent) == bits(&first) && silent.stderr.is_none());
            }
        }
    });
}

#[test]
fn samples_stop_where_the_error_is_small_enough() {
    with_device(|device| {
        for (name, camera, points, discs) in scenes() {
            let exact = exact_on(device, &points, camera, discs);
            let mut stage = Stage::new(device, &points, camera, SMALL);
            for settings in [plain(4096), corrected(4096)] {
                let settings = Stochastic { discs, ..settings };
                let asked = Frame { max_error: Some(0.01), fragments: false, ..seeded(&stage.frame, settings, 3) };
                let found = stage.renderer.render(&mut stage.cloud, &asked).expect("renders");
                let samples = found.facts.samples;
                let error = rmse(&doubles(&found.image), &exact);
                eprintln!("{name}, {settings:?}: {samples} samples, error {error:.5}");
                assert!((32..1024).contains(&samples) && samples.is_multiple_of(16), "{samples}");
                // 1300 values, of which R, G and B go together.
                assert!((0.006..0.0115).contains(&error), "{error}");
                let same = stage.image(Stochastic { samples, ..settings }, 3);
                assert!(bits(&same) == bits(&found.image) && found.image.stderr.is_none());
                // In windows, the same; not beyond what the settings allow.
                let windows = Frame { memory_budget: Some(300_000), ..asked };
                let cut = stage.renderer.render(&mut stage.cloud, &windows).expect("renders");
                assert!(
                    cut.facts.windows > 1 && cut.facts.samples == samples && bits(&cut.image) == bits(&found.image)
                );
                let few = Frame { method: Method::Stochastic(Stochastic { samples: 24, ..settings }), ..asked };
                assert_eq!(stage.renderer.render(&mut stage.cloud, &few).expect("renders").facts.samples, 24);
            }
        }
    });
}
