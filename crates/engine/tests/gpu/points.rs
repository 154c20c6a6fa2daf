//! `points` takes each point straight to its pixel: the bytes must be those that splats of radius 0 give, and the pixel
//! the one of float64 however near its border lies. Colors and depths against the reference:
//! `crates/engine/tests/gpu/splat.rs`.

use std::sync::Arc;

use glam::{DVec3, Vec3};
use pellucid_core::camera::{Camera, Projection};
use pellucid_core::points::Points;
use pellucid_engine::methods::{Frame, Renderer};
use pellucid_engine::passes::compose::Cut;
use pellucid_gpu::{Device, DeviceOptions, Preferences};
use pellucid_scene::prepare::Arranged;
use pellucid_scene::{ColorSpace, Light, Method, Raster, ScreenSplats, Shading, ShadingModel};
use pellucid_testing::*;
use rand::RngExt;

/// Discs of radius 0: one pixel each, by way of splats.
const DOTS: Method =
    Method::Circles(ScreenSplats { size: 0.0, max_pixel_radius: 25.0, pixel_radius: None, raster: Raster::Auto });

/// Asserts that points and dots give the same bytes, with both kinds of atomics; how many pixels were drawn.
#[track_caller]
fn assert_same_as_dots(device: &Device, points: &Points, frame: &Frame) -> usize {
    let mut renderer = Renderer::new(device).expect("a renderer");
    let mut cloud = renderer.upload(points).expect("fits");
    let dots = renderer.render(&mut cloud, &Frame { method: DOTS, ..*frame }).expect("renders");
    for wide in [renderer.switches.wide_atomics, false] {
        renderer.switches.wide_atomics = wide;
        let found = renderer.render(&mut cloud, &Frame { method: Method::Points, ..*frame }).expect("renders");
        assert!(bits(&found.image) == bits(&dots.image), "wide atomics: {wide}, {frame:?}");
        assert_eq!(found.facts.visible, dots.facts.visible);
    }
    dots.image.rgba.iter().filter(|c| c[3] == 1.0).count()
}

fn shadings() -> Vec<Shading> {
    let shading = |model, light| Shading { model, light, specular: 0.4, ..Shading::default() };
    let lights = [Light::Headlight, Light::Direction(DVec3::new(0.3, -1.0, -0.2)), Light::Position(DVec3::ONE)];
    let models = [ShadingModel::Lambert, ShadingModel::Phong];
    let all = models.iter().flat_map(|m| lights.iter().map(|l| shading(*m, *l)));
    [Shading::NONE].into_iter().chain(all).collect()
}

#[test]
fn points_equal_splats_of_radius_0_however_shaded() {
    with_device(|device| {
        let mut mixed = soup(21, 3000, 0.0..0.1, 0.1..0.9, true);
        // Some without a normal.
        mixed.iter_mut().step_by(7).for_each(|p| p.normal = Vec3::ZERO);
        let points = scene(&mixed);
        for camera in [perspective(), orthographic()] {
            for shading in shadings() {
                for color in [ColorSpace::Linear, ColorSpace::Encoded] {
                    let frame = Frame { shading, color, ..frame(camera, [161, 90], Method::Points) };
                    assert!(assert_same_as_dots(device, &points, &frame) > 1500);
                }
            }
        }
    });
}

#[test]
fn columns_beyond_one_allocation_draw_the_same_bytes() {
    // 1 MiB holds 65 536 points of 16 bytes: more are in one buffer where larger ones are tried, else they come window
    // by window.
    let points = Arc::new(scene(&soup(23, 90_000, 0.0..0.1, 0.1..0.9, true)));
    let frame = frame(perspective(), [200, 150], Method::Points);
    let mut images = Vec::new();
    with_device(|device| images.push(bits(&render(device, &points, &frame))));
    for prefers in [Preferences::CPU, Preferences::GPU] {
        let (allocation_bytes, prefers) = (Some(1 << 20), Some(prefers));
        with_device_of(&DeviceOptions { allocation_bytes, prefers, ..DeviceOptions::validated() }, |device| {
            let is_whole = device.info().prefers.large_allocations;
            assert_eq!(Cut::most(device) == 65_536, !is_whole);
            let mut renderer = Renderer::new(device).expect("a renderer");
            assert_eq!(renderer.upload(&*points).is_ok(), is_whole);
            let mut cloud = renderer.upload(&Arranged::Canonical(points.clone())).expect("fits");
            assert_eq!(cloud.supply().is_none(), is_whole);
            images.push(bits(&renderer.render(&mut cloud, &frame).expect("renders").image));
        });
    }
    assert!(images.windows(2).all(|pair| pair[0] == pair[1]));
}

#[test]
fn so_they_do_in_windows_chunks_and_parts() {
    // A binding of 1.5 MiB holds 78 592 splats: two chunks, and two of four parts.
    with_device_that_binds(Some(3 << 19), |device| {
        let points = scene(&soup(22, 90_000, 0.0..0.1, 0.1..0.9, true));
        let shading = Shading { model: ShadingModel::Lambert, ..Shading::default() };
        for memory_budget in [None, Some(200_000)] {
            let frame = Frame { memory_budget, shading, ..frame(perspective(), [200, 150], Method::Points) };
            assert!(assert_same_as_dots(device, &points, &frame) > 5000);
        }
    });
}

#[test]
fn narrow_wide_and_far_away_views_change_nothing() {
    with_device(|device| {
        let georeferenced = DVec3::new(500_000.0, 4_500_000.0, 100.0);
        for shift in [DVec3::ZERO, georeferenced] {
            let mut moved = soup(23, 4000, 0.0..0.1, 0.1..0.9, false);
            moved.iter_mut().for_each(|p| p.position += shift);
            let points = scene(&moved);
            for (degrees, distance) in [(170.0, 0.2), (45.0, 0.0), (20.0, 3.0), (1.0, 100.0), (0.01, 10_000.0)] {
                let eye = DVec3::new(0.3, 0.5, 1.0).normalize() * distance + shift;
                let projection = Projection::Perspective { fov_y: f64::to_radians(degrees) };
                let target = shift - DVec3::new(0.1, 0.0, 0.1);
                let camera = Camera::look_at(eye, target, DVec3::Y, projection, 1e-3, 1e5).expect("valid");
                assert!(assert_same_as_dots(device, &points, &frame(camera, [120, 121], Method::Points)) > 100);
            }
        }
    });
}

#[test]
fn a_point_beside_a_border_of_pixels_falls_on_the_right_side() {
    with_device(|device| {
        let size = [401, 300];
        let mut random = random(24);
        for camera in [perspective(), orthographic()] {
            let mut wrong_in_f32 = 0;
            let mut expected = vec![f64::INFINITY; 401 * 300];
            let mut list = Vec::new();
            for number in 0..20_000 {
                // Near a border in x and in y by turns, on either side, by 1e-3 to 1e-8 of a pixel.
                let beside = 10f64.powf(random.random_range(-8.0..-3.0)) * [1.0, -1.0][number % 2];
                let mut at = [random.random_range(1.0..400.0), random.random_range(1.0..299.0)];
                let axis = number / 2 % 2;
                at[axis] = f64::round(at[axis]) + beside;
                let depth = random.random_range(2.0..8.0);
                let scale = camera.pixels_per_unit(depth, size[1]);
                let [x, y] = [(at[0] - 200.5) / scale, (at[1] - 150.0) / scale];
                let position = camera.eye + camera.right * x - camera.up * y + camera.forward * depth;
                let exact = camera.project(position, size).0.to_array();
                assert!((exact[axis] - at[axis]).abs() < 1e-10);
                let pixel = exact.map(|v| v.floor() as usize);
                let slot = &mut expected[pixel[1] * 401 + pixel[0]];
                *slot = slot.min(depth);
                // The result of float32 alone.
                let single = (position.as_vec3() - camera.eye.as_vec3()).dot(camera.right.as_vec3()) * scale as f32;
                wrong_in_f32 += usize::from((f64::from(single) + 200.5).floor() != exact[0].floor());
                list.push(P { position, color: Vec3::ONE, opacity: 1.0, radius: 0.0, normal: Vec3::ZERO });
            }
            assert!(wrong_in_f32 > 500, "the test would not notice float32: {wrong_in_f32}");
            let points = scene(&list);
            let frame = frame(camera, size, Method::Points);
            let found = render(device, &points, &frame);
            for (i, (found, wanted)) in found.depth.iter().zip(&expected).enumerate() {
                let same = (f64::from(*found) - wanted).abs() <= 1e-6 * wanted.abs();
                assert!(same || found.is_infinite() && wanted.is_infinite(), "pixel {i}: {found} for {wanted}");
            }
            assert_same_as_dots(device, &points, &frame);
        }
    });
}

#[test]
fn an_image_given_back_leaves_no_trace() {
    with_device(|device| {
        let points = scene(&soup(25, 500, 0.01..0.1, 0.1..0.9, false));
        let mut renderer = Renderer::new(device).expect("a renderer");
        let mut cloud = renderer.upload(&points).expect("fits");
        for size in [[64, 40], [40, 64]] {
            for method in [Method::Points, DOTS, Method::ABuffer(Default::default())] {
                let frame = frame(perspective(), size, method);
                let fresh = renderer.render(&mut cloud, &frame).expect("renders").image;
                let mut spoiled = fresh.clone();
                spoiled.rgba.fill([7.0; 4]);
                spoiled.depth.fill(7.0);
                renderer.recycle(spoiled);
                let again = renderer.render(&mut cloud, &frame).expect("renders").image;
                assert!(bits(&again) == bits(&fresh) && again.fragments == fresh.fragments, "{method:?}");
            }
        }
    });
}
