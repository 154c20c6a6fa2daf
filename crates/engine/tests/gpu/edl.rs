//! Eye-dome lighting: every method that takes it against the float64 reference, cases worked by hand, and the same bytes however
//! the image is cut.

use glam::Vec3;
use pellucid_engine::gpu::Device;
use pellucid_engine::methods::{Error, Frame, Rendered, Renderer};
use pellucid_engine::points::Points;
use pellucid_engine::reference;
use pellucid_engine::reference::range::ROUNDING;
use pellucid_engine::scene::{ColorSpace, Edl, ImageSpace, Method, Shading};
use pellucid_testing::*;

const PASS: &str = "shading/edl";

fn lit(frame: &Frame, edl_strength: f32, edl_radius: f32) -> Frame {
    let edl = Edl { edl: true, edl_strength, edl_radius };
    Frame { shading: Shading { edl, ..frame.shading }, ..*frame }
}

fn methods() -> impl Iterator<Item = Method> {
    Method::all().into_iter().filter(Method::takes_edl)
}

/// How far −ln of a factor may be off, x = 300 · strength · s: each of eight quotients is rounded once, each logarithm within a
/// unit, the sum has seven roundings and its factor two.
fn slack(strength: f64, x: f64) -> f64 {
    let per_logarithm = 300.0 * strength * std::f64::consts::LOG2_E / 8.0;
    8.0 * per_logarithm * ROUNDING + 11.0 * ROUNDING * x
}

fn assert_lit(plain: &Rendered, found: &Rendered, (strength, radius): (f32, f32), what: &str) {
    let image = &plain.image;
    let depths: Vec<f64> = image.depth.iter().map(|z| f64::from(*z)).collect();
    let factors =
        reference::edl::factors(&depths, [image.width, image.height], strength.into(), radius.into());
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
            assert!(off <= plain * share, "{what}: pixel {pixel}: {found}, not {plain} · {factor}");
        }
    }
    assert_eq!(found.image.depth, image.depth, "{what}");
}

/// Points before each other, some of them larger than a tile.
fn mixture() -> Points {
    scene(&[soup(1, 500, 0.02..0.1, 0.2..1.0, true), soup(2, 5, 0.3..1.0, 0.2..1.0, true)].concat())
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
                    for setting in [(1.0, 1.4), (0.01, 1.4), (0.05, 4.0), (0.0, 1.4), (1e30, 2.0), (1.0, 0.3)] {
                        let found = rendered(device, &points, &lit(&frame, setting.0, setting.1));
                        assert_lit(&plain, &found, setting, &format!("{} {setting:?}", method.name()));
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
        // The near wall has nothing before it, and the far one only far ones where the step is two pixels away: to the bit.
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

fn with_budget(device: &Device, points: &Points, frame: &Frame, budget: u64) -> Rendered {
    rendered(device, points, &Frame { memory_budget: Some(budget), ..*frame })
}

#[test]
fn cuts_change_no_byte() {
    with_device(|device| {
        let (points, size) = (mixture(), [64, 90]);
        for method in [Method::Points, Method::Circles(Default::default()), Method::ImageSpace(ImageSpace::default())] {
            // A radius beyond several bands, and one of none.
            for radius in [0.3, 1.4, 20.0] {
                let frame = lit(&Frame { fragments: false, ..frame(perspective(), size, method) }, 0.02, radius);
                let whole = rendered(device, &points, &frame);
                let runs = |rendered: &Rendered| {
                    rendered.profile.timeline.iter().filter(|(pass, _)| pass.name == PASS).count()
                };
                assert_eq!(runs(&whole), 1);
                // Bands of a row and of several.
                for budget in [1 << 20, 60_000] {
                    let cut = with_budget(device, &points, &frame, budget);
                    assert!(bits(&cut.image) == bits(&whole.image), "{} in {budget} bytes", method.name());
                    assert!(budget > 60_000 || runs(&cut) > 1);
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
