//! The opacity that `--see-through` finds, where it can be told beforehand.

use glam::Vec3;
use pellucid_engine::methods::Renderer;
use pellucid_engine::methods::see_through::{TOLERANCE, find, median_transmittance};
use pellucid_scene::{Discs, Method, Peel, Stochastic};
use pellucid_testing::{P, at_pixel, frame, pixel_camera, scene, with_device};

const SIZE: [u32; 2] = [32, 24];

/// Discs over the whole image, one behind the other.
fn stack(opacities: &[f32]) -> Vec<P> {
    let disc = |(i, opacity): (usize, &f32)| P {
        position: at_pixel(16.0, 12.0, 2.0 + 0.01 * i as f64),
        color: Vec3::ONE,
        opacity: *opacity,
        radius: 100.0,
        normal: Vec3::ZERO,
    };
    opacities.iter().enumerate().map(disc).collect()
}

/// The factor and the median for a stack.
fn found(opacities: &[f32], method: Method, share: f64, max: f32) -> (f64, f64) {
    let mut result = (f64::NAN, f64::NAN);
    with_device(|device| {
        let mut renderer = Renderer::new(device).unwrap();
        let mut cloud = renderer.upload(&scene(&stack(opacities))).unwrap();
        let frame = frame(pixel_camera(SIZE), SIZE, method);
        let found = find(&mut renderer, &mut cloud, &frame, share, max).unwrap().expect("pixels are covered");
        result = (f64::from(found.factor), found.transmittance);
        let mut last = frame;
        last.factors.opacity = found.factor;
        let image = renderer.render(&mut cloud, &last).unwrap().image;
        assert_eq!(median_transmittance(&image.rgba), Some(found.transmittance), "that of the frame itself");
    });
    result
}

#[test]
fn equal_layers_have_the_root_as_their_opacity() {
    if !pellucid_testing::has_device() {
        return;
    }
    for method in [Method::ABuffer(Discs::default()), Method::Sorted(Discs::default()), Method::Peel(Peel::default())] {
        for (layers, share) in [(1, 0.5), (1, 0.9), (5, 0.5), (5, 0.05), (24, 0.7)] {
            let (factor, median) = found(&vec![1.0; layers], method, share, 1.0);
            assert!((median - share).abs() <= TOLERANCE, "{layers} layers, {share}: {median}");
            let wanted = (1.0 - factor).powi(layers as i32);
            // Each of the layers rounds T by a few units of 2⁻²⁴.
            assert!((wanted - median).abs() <= 4.0 * layers as f64 * f64::from(f32::EPSILON), "{wanted} {median}");
        }
    }
}

#[test]
fn opacities_keep_their_ratio_and_are_cut_at_1() {
    if !pellucid_testing::has_device() {
        return;
    }
    let method = Method::ABuffer(Discs::default());
    let (factor, median) = found(&[0.1, 0.4], method, 0.3, 10.0);
    let wanted = (1.0 - 0.1 * factor) * (1.0 - 0.4 * factor);
    assert!((median - 0.3).abs() <= TOLERANCE && (wanted - median).abs() < 1e-5 && factor > 1.0, "{factor}, {median}");
    // Beyond 1 / 0.4 only the fainter one is left to grow, and the other lets nothing through.
    let (_, median) = found(&[0.1, 0.4], method, 0.0, 10.0);
    assert!(median.abs() < 1e-6, "{median}");
}

#[test]
fn half_covered_images_count_covered_pixels_alone() {
    with_device(|device| {
        // A disc of ten pixels' radius in the corner.
        let points = [P { position: at_pixel(0.0, 0.0, 2.0), radius: 10.0, ..stack(&[1.0])[0] }];
        let mut renderer = Renderer::new(device).unwrap();
        let mut cloud = renderer.upload(&scene(&points)).unwrap();
        let frame = frame(pixel_camera(SIZE), SIZE, Method::Sorted(Discs::default()));
        let found = find(&mut renderer, &mut cloud, &frame, 0.75, 1.0).unwrap().unwrap();
        assert!((f64::from(found.factor) - 0.25).abs() <= TOLERANCE, "{found:?}");
        let none = renderer.upload(&scene(&[P { opacity: 0.0, ..points[0] }]));
        assert!(find(&mut renderer, &mut none.unwrap(), &frame, 0.75, 1.0).unwrap().is_none());
    });
}

#[test]
fn sampled_images_come_as_near() {
    if !pellucid_testing::has_device() {
        return;
    }
    let settings = Stochastic { samples: 256, ..Stochastic::default() };
    let (factor, median) = found(&[1.0; 3], Method::Stochastic(settings), 0.5, 1.0);
    assert!((median - 0.5).abs() <= TOLERANCE, "{median}");
    // Alpha correction makes A exact, whatever the samples.
    assert!(((1.0 - factor).powi(3) - median).abs() < 1e-5, "{factor}");
}
