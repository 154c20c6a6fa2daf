//! Exponentials and powers that shaders compute themselves (shaders/shared/elementary.wgsl), seen in pixels.

use glam::Vec3;
use pellucid_engine::methods::Frame;
use pellucid_scene::{ColorSpace, Discs, Falloff, Method};
use pellucid_testing::{P, at_pixel, frame, pixel_camera, render, scene, with_device};

#[test]
fn encoded_colors_are_the_curve_of_srgb() {
    with_device(|device| {
        let size = [256, 1];
        let color =
            |i: u32| Vec3::new((i as f32 + 0.5) / 256.0, (i as f32 / 255.0).powi(3), 0.0031308 + i as f32 * 1e-5);
        let point = |i: u32| P {
            position: at_pixel(f64::from(i) + 0.5, 0.5, 2.0),
            color: color(i),
            opacity: 1.0,
            radius: 0.0,
            normal: Vec3::ZERO,
        };
        let points = scene(&(0..256).map(point).collect::<Vec<_>>());
        let frame = Frame { color: ColorSpace::Encoded, ..frame(pixel_camera(size), size, Method::Points) };
        let image = render(device, &points, &frame);
        let curve = |c: f32| {
            let c = f64::from(c);
            if c <= 0.0031308 { 12.92 * c } else { 1.055 * c.powf(1.0 / 2.4) - 0.055 }
        };
        for (i, found) in image.rgba.iter().enumerate() {
            for (found, linear) in found.iter().zip(color(i as u32).to_array()) {
                let wanted = curve(linear);
                // A power within 1.5 · 2.4 + 2 units of at most 2^-24, the exponent's rounding, a product and a
                // difference: 9 of them; where the two pieces meet they are 3e-8 apart.
                let bound = 9.0 * f64::from(f32::EPSILON) / 2.0 + 3e-8;
                assert!((f64::from(*found) - wanted).abs() <= bound, "{linear}: {found}, not {wanted}");
            }
        }
    });
}

#[test]
fn gaussian_discs_fall_off_as_an_exponential() {
    with_device(|device| {
        let size = [33, 1];
        let radius = 16.25f32;
        let point = P { position: at_pixel(0.5, 0.5, 2.0), color: Vec3::ONE, opacity: 1.0, radius, normal: Vec3::ZERO };
        let method = Method::ABuffer(Discs { falloff: Falloff::Gaussian, ..Discs::default() });
        let image = render(device, &scene(&[point]), &frame(pixel_camera(size), size, method));
        for (i, found) in image.rgba.iter().enumerate() {
            let rho = i as f64 / f64::from(radius);
            let wanted = if rho <= 1.0 { (-2.0 * rho * rho).exp() } else { 0.0 };
            // The argument, up to 2, has four roundings, the exponential one unit.
            let bound = 10.0 * f64::from(f32::EPSILON) / 2.0 * wanted;
            assert!((f64::from(found[3]) - wanted).abs() <= bound, "{rho}: {}, not {wanted}", found[3]);
        }
    });
}
