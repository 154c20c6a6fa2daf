//! Eye-dome lighting: every method that takes it against the float64 reference, cases worked by hand, and the same
//! bytes however the image is cut.

use glam::Vec3;
use pellucid_core::points::Points;
use pellucid_engine::methods::{Error, Frame, Rendered, Renderer};
use pellucid_gpu::Device;
use pellucid_reference as reference;
use pellucid_reference::View;
use pellucid_reference::range::ROUNDING;
use pellucid_scene::{ColorSpace, Edl, ImageSpace, Method, Shading};
use pellucid_testing::*;

const PASS: &str = "shading/edl";

fn lit(frame: &Frame, edl_strength: f32, edl_radius: f32) -> Frame {
    let edl = Edl { edl: true, edl_strength, edl_radius };
    Frame { shading: Shading { edl, ..frame.shading }, ..*frame }
}

fn methods() -> impl Iterator<Item = Method> {
    Method::all().into_iter().filter(Method::takes_edl)
}

/// How far −ln of a factor may be off, x = 300 · strength · s: each of eight quotients is rounded once, each logarithm
/// within a unit, the sum has seven roundings and its factor two.
pub(crate) fn slack(strength: f64, x: f64) -> f64 {
    let per_logarithm = 300.0 * strength * std::f64::consts::LOG2_E / 8.0;
    8.0 * per_logarithm * ROUNDING + 11.0 * ROUNDING * x
}

/// The depths that a frame of these points is shaded by.
fn surface(device: &Device, points: &Points, frame: &Frame) -> Vec<f32> {
    let image = render(device, points, &Frame { depths: true, ..*frame });
    image.depth_median.unwrap_or(image.depth)
}

fn assert_lit(plain: &Rendered, found: &Rendered, depths: &[f32], (strength, radius): (f32, f32), what: &str) {
    let image = &plain.image;
    let depths: Vec<f64> = depths.iter().map(|z| f64::from(*z)).collect();
    let factors = reference::edl::factors(&depths, [image.width, image.height], strength.into(), radius.into());
    assert_eq!(bits(&found.image).len(), bits(image).len());
    for (pixel, factor) in factors.into_iter().enumerate() {
        let (plain, found) = (image.rgba[pixel], found.image.rgba[pixel]);
        assert_eq!(plain[3].to_bits(), found[3].to_bits(), "{what}: A of pixel {pixel}");
        let x = -factor.max(1e-300).ln();
        // The exponential is within a unit, the product rounded once; below e⁻⁸⁷ it is 0.
        let share = factor * (slack(strength.into(), x).exp_m1() + 4.0 * ROUNDING) + 2e-38;
        for (plain, found) in plain.into_iter().zip(found).take(3) {
            let (plain, found) = (f64::from(plain), f64::from(found));
            let off = (found - plain * factor).abs();
            assert!(off == 0.0 || off <= plain * share, "{what}: pixel {pixel}: {found}, not {plain} · {factor}");
        }
    }
    assert_eq!(found.image.depth, image.depth, "{what}");
}

/// Points before each other, some of them larger than a tile.
fn mixed() -> Vec<P> {
    [soup(1, 500, 0.02..0.1, 0.2..1.0, true), soup(2, 5, 0.3..1.0, 0.2..1.0, true)].concat()
}

fn mixture() -> Points {
    scene(&mixed())
}

#[test]
fn images_equal_the_reference() {
    with_device(|device| {
        let points = mixture();
        for (camera, size) in [(perspective(), [61, 43]), (orthographic(), [32, 50])] {
            for method in methods() {
                for color in [ColorSpace::Linear, ColorSpace::Encoded] {
                    let frame = Frame { color, ..frame(camera, size, method) };
                    let plain = rendered(device, &points, &frame);
                    let depths = surface(device, &points, &frame);
                    for setting in [(1.0, 1.4), (0.01, 1.4), (0.05, 4.0), (0.0, 1.4), (1e30, 2.0), (1.0, 0.3)] {
                        let found = rendered(device, &points, &lit(&frame, setting.0, setting.1));
                        assert_lit(&plain, &found, &depths, setting, &format!("{} {setting:?}", method.name()));
                    }
                }
            }
        }
    });
}

/// Two flat walls beside each other: columns below 4 at depth 2, the others at 4; nothing in column 7.
fn step() -> Points {
    let wall = |x: u32, y: u32| P {
        position: at_pixel(f64::from(x) + 0.5, f64::from(y) + 0.5, if x < 4 { 2.0 } else { 4.0 }),
        color: Vec3::ONE,
        opacity: 1.0,
        radius: 0.0,
        normal: Vec3::ZERO,
    };
    scene(&(0..7).flat_map(|x| (0..6).map(move |y| wall(x, y))).collect::<Vec<_>>())
}

#[test]
fn a_step_by_hand() {
    with_device(|device| {
        let size = [8, 6];
        let frame = frame(pixel_camera(size), size, Method::Points);
        let image = render(device, &step(), &lit(&frame, 0.01, 1.4));
        let red = |x: usize, y: usize| f64::from(image.rgba[y * 8 + x][0]);
        // Three pixels beside the step are nearer by log₂ 2 = 1, in the corner two: exp(−300 · 0.01 · 3/8).
        for (y, nearer) in [(0, 2.0), (1, 3.0), (4, 3.0), (5, 2.0)] {
            let wanted = (-3.0 * nearer / 8.0f64).exp();
            assert!((red(4, y) - wanted).abs() < 1e-5, "row {y}: {}, not {wanted}", red(4, y));
        }
        // The near wall has nothing before it, and the far one only far ones where the step is two pixels away: to the
        // bit.
        for x in [0, 3, 5, 6] {
            assert_eq!(red(x, 2), 1.0, "column {x}");
        }
        assert_eq!(image.rgba[2 * 8 + 7], [0.0; 4], "background");
        // 2.9 reaches 3 columns along the row, 2 on diagonals.
        let wide = render(device, &step(), &lit(&frame, 0.01, 2.9));
        let of_column = |x: usize| f64::from(wide.rgba[3 * 8 + x][0]);
        for (x, nearer) in [(4, 3.0), (5, 3.0), (6, 1.0)] {
            let wanted = (-3.0 * nearer / 8.0f64).exp();
            assert!((of_column(x) - wanted).abs() < 1e-5, "column {x}: {}, not {wanted}", of_column(x));
        }
    });
}

/// Some layers on each pixel, and on pixels of the middle more than 256, so that there are runs of long lists.
fn layers() -> Vec<P> {
    let thin = |points: Vec<P>, most: f32| {
        points.into_iter().map(|p| P { opacity: p.opacity * most, ..p }).collect::<Vec<_>>()
    };
    let few = thin(soup(3, 600, 0.05..0.3, 0.0..1.0, true), 0.6);
    let many = thin(soup(4, 900, 0.5..0.8, 0.0..1.0, true), 0.01);
    [few, many].concat()
}

#[test]
fn medians_are_the_depths_at_which_half_of_the_light_is_left() {
    with_device(|device| {
        let size = [40, 30];
        for discs in all_discs().filter(|discs| discs.raster == RASTERS[0]) {
            for (camera, points) in [(perspective(), mixed()), (orthographic(), layers())] {
                let points = scene(&safe(&points, &camera, size, discs.shape));
                let lists = reference::abuffer::lists(View::new(&camera, size), &points, &discs);
                // A is a sum of products, each with three roundings of at most 2^-24.
                let longest = lists.iter().map(Vec::len).max().unwrap_or(0) as f64;
                let tolerance = 3.0 * longest * ROUNDING;
                for method in [Method::ABuffer(discs), Method::LinkedList(discs)] {
                    let found = surface(device, &points, &frame(camera, size, method));
                    let mut between = 0;
                    for (pixel, list) in lists.iter().enumerate() {
                        // Fragments as near to each other as depths are rounded may have traded places.
                        let [near, far] =
                            [0.5 + tolerance, 0.5 - tolerance].map(|share| reference::abuffer::median(list, share));
                        let z = f64::from(found[pixel]);
                        assert!(
                            near * (1.0 - 1e-5) <= z && z <= far * (1.0 + 1e-5),
                            "{} {discs:?}, pixel {pixel} of {}: {z}, not from {near} to {far}",
                            method.name(),
                            list.len()
                        );
                        between += usize::from(near < far);
                    }
                    // Where both are the same the depth is known but for its own rounding.
                    assert!(between * 2 < lists.len(), "{between}");
                }
            }
        }
    });
}

#[test]
fn a_median_by_hand() {
    with_device(|device| {
        let at = |depth: f64, opacity: f32, x: f64| P {
            position: at_pixel(x, 0.5, depth),
            color: Vec3::ONE,
            opacity,
            radius: 0.0,
            normal: Vec3::ZERO,
        };
        // T is 0.7, 0.49: the second. T is exactly a half: the first. T never falls to a half: none.
        let first = [at(2.0, 0.3, 0.5), at(3.0, 0.3, 0.5), at(4.0, 0.3, 0.5)];
        let second = [at(2.0, 0.5, 1.5), at(3.0, 0.9, 1.5)];
        let third = [at(2.0, 0.0, 2.5), at(3.0, 0.25, 2.5), at(4.0, 0.25, 2.5)];
        // 1000 layers of 1/1000, the nth at depth n: 0.999^693 = 0.49992, 0.999^692 = 0.50042.
        let fourth: Vec<P> = (1..=1000).map(|n| at(f64::from(n), 0.001, 3.5)).collect();
        let points = scene(&[&first[..], &second, &third, &fourth].concat());
        for method in [Method::ABuffer(Default::default()), Method::LinkedList(Default::default())] {
            let found = surface(device, &points, &frame(pixel_camera([4, 1]), [4, 1], method));
            assert_eq!(found, [3.0, 2.0, f32::INFINITY, 693.0]);
        }
    });
}

fn with_budget(device: &Device, points: &Points, frame: &Frame, budget: u64) -> Rendered {
    rendered(device, points, &Frame { memory_budget: Some(budget), ..*frame })
}

#[test]
fn cuts_change_no_byte() {
    with_device(|device| {
        let (points, size) = (mixture(), [256, 90]);
        let methods = [
            Method::Points,
            Method::Circles(Default::default()),
            Method::ImageSpace(ImageSpace::default()),
            Method::ABuffer(Default::default()),
        ];
        for method in methods {
            // A radius beyond several bands, and one of none.
            for radius in [0.3, 1.4, 20.0] {
                let frame = lit(&Frame { fragments: false, ..frame(perspective(), size, method) }, 0.02, radius);
                let whole = rendered(device, &points, &frame);
                let runs = |rendered: &Rendered| {
                    rendered.profile.timeline.iter().filter(|(pass, _)| pass.name == PASS).count()
                };
                assert_eq!(runs(&whole), 1);
                // A quarter is for the bands: 16 bytes for each of 256 × 90 pixels, and for half of them.
                for budget in [1 << 22, 800_000] {
                    let cut = with_budget(device, &points, &frame, budget);
                    assert!(bits(&cut.image) == bits(&whole.image), "{} in {budget} bytes", method.name());
                    assert_eq!(runs(&cut) > 1, budget == 800_000);
                }
            }
        }
    });
}

#[test]
fn who_does_not_ask_pays_nothing() {
    with_device(|device| {
        let frame = frame(perspective(), [20, 20], Method::Circles(Default::default()));
        let named = |rendered: &Rendered| rendered.profile.passes.iter().any(|pass| pass.name.starts_with("shading/"));
        assert!(!named(&rendered(device, &mixture(), &frame)));
        assert!(named(&rendered(device, &mixture(), &lit(&frame, 1.0, 1.4))));
    });
}

#[test]
fn methods_without_one_surface_refuse_and_name_those_that_have_one() {
    with_device(|device| {
        let points = mixture();
        let mut renderer = Renderer::new(device).unwrap();
        let mut cloud = renderer.upload(&points).unwrap();
        for method in Method::all().into_iter().filter(|method| !method.takes_edl()) {
            let frame = lit(&frame(perspective(), [8, 8], method), 1.0, 1.4);
            let error = renderer.render(&mut cloud, &frame).unwrap_err();
            assert!(matches!(error, Error::NoSurfaceDepth { .. }) && error.is_refusal(), "{error}");
            let text = error.to_string();
            assert!(text.contains(method.name()) && text.contains("\"circles\"") && text.contains("\"image-space\""));
        }
    });
}
