//! `points`, `squares`, `circles`, `paraboloid`, `cone`, `sphere` against the float64 reference, with both kinds of
//! atomics.

use glam::{DVec3, Vec3};
use pellucid_core::camera::{Camera, Projection};
use pellucid_core::image::Image;
use pellucid_core::points::Points;
use pellucid_engine::methods::{Frame, Renderer};
use pellucid_gpu::Device;
use pellucid_reference::View;
use pellucid_reference::{self as reference, coverage::Shape};
use pellucid_scene::{Interpolated, Method, Raster, ScreenSplats, SplatShape};
use pellucid_testing::*;
use rand::seq::SliceRandom;

/// Renders with 64-bit atomics where the device has them, and with two passes of 32 bits: the bytes must be the same.
fn render_both(device: &Device, points: &Points, frame: &Frame) -> Image {
    let mut renderer = Renderer::new(device).expect("a renderer");
    let mut cloud = renderer.upload(points).expect("fits");
    let native = renderer.render(&mut cloud, frame).expect("renders").image;
    renderer.switches.wide_atomics = false;
    let narrow = renderer.render(&mut cloud, frame).expect("renders").image;
    assert!(bits(&native) == bits(&narrow), "the two kinds of atomics differ");
    if let Some(method) = rasterized(frame.method) {
        for wide in [device.info().int64_atomics, false] {
            renderer.switches.wide_atomics = wide;
            let drawn = renderer.render(&mut cloud, &Frame { method, ..*frame }).expect("renders").image;
            assert!(bits(&native) == bits(&drawn), "{method:?}: the rasterizer finds other fragments");
        }
    }
    native
}

/// Returns the method with the rasterizer to visit its splats' pixels; `None` where there are no splats.
fn rasterized(method: Method) -> Option<Method> {
    let drawn = |splats| ScreenSplats { raster: Raster::Hardware, ..splats };
    Some(match method {
        Method::Squares(splats) => Method::Squares(drawn(splats)),
        Method::Circles(splats) => Method::Circles(drawn(splats)),
        Method::Sphere(splats) => Method::Sphere(drawn(splats)),
        Method::Paraboloid(of) => Method::Paraboloid(Interpolated { splats: drawn(of.splats), ..of }),
        Method::Cone(of) => Method::Cone(Interpolated { splats: drawn(of.splats), ..of }),
        _ => return None,
    })
}

const METHODS: [(Method, Shape, ScreenSplats); 12] = {
    let plain = ScreenSplats { size: 1.0, max_pixel_radius: 25.0, pixel_radius: None, raster: Raster::Auto };
    let other = ScreenSplats { size: 1.7, max_pixel_radius: 4.0, pixel_radius: None, raster: Raster::Auto };
    let fixed = ScreenSplats { size: 1.7, max_pixel_radius: 25.0, pixel_radius: Some(1.3), raster: Raster::Auto };
    let clamped = ScreenSplats { size: 1.0, max_pixel_radius: 1.5, pixel_radius: Some(5.0), raster: Raster::Auto };
    [
        (Method::Points, Shape::Point, plain),
        (Method::Squares(plain), Shape::Square, plain),
        (Method::Circles(plain), Shape::Disc, plain),
        (Method::Circles(other), Shape::Disc, other),
        (Method::Paraboloid(Interpolated { splats: plain, shape: SplatShape::Circle }), Shape::Disc, plain),
        (Method::Paraboloid(Interpolated { splats: other, shape: SplatShape::Square }), Shape::Square, other),
        (Method::Cone(Interpolated { splats: other, shape: SplatShape::Circle }), Shape::Disc, other),
        (Method::Cone(Interpolated { splats: plain, shape: SplatShape::Square }), Shape::Square, plain),
        (Method::Sphere(plain), Shape::Disc, plain),
        (Method::Circles(fixed), Shape::Disc, fixed),
        (Method::Sphere(clamped), Shape::Disc, clamped),
        (Method::Paraboloid(Interpolated { splats: fixed, shape: SplatShape::Square }), Shape::Square, fixed),
    ]
};

#[test]
fn equal_the_reference_where_coverage_is_safe() {
    with_device(|device| {
        let size = [160, 110];
        let mixed = [soup(1, 2000, 0.0..0.08, 0.1..0.9, false), soup(2, 20, 0.3..2.0, 0.1..0.9, false)].concat();
        for camera in [perspective(), orthographic()] {
            for (method, shape, settings) in METHODS {
                let all = scene(&mixed);
                let clear: Vec<usize> = (0..all.len())
                    .filter(|i| {
                        reference::coverage::margin_px(
                            View::new(&camera, size),
                            &reference::opaque::splat(&all, *i, shape, &settings),
                        ) > 0.02
                    })
                    .collect();
                let points = Points {
                    positions: clear.iter().map(|i| all.positions[*i]).collect(),
                    colors: clear.iter().map(|i| all.colors[*i]).collect(),
                    opacities: clear.iter().map(|i| all.opacities[*i]).collect(),
                    radii: clear.iter().map(|i| all.radii[*i]).collect(),
                    ..Points::default()
                };
                assert!(points.len() > 1000);
                let colors: Vec<DVec3> = points.colors.iter().map(|c| c.as_dvec3()).collect();
                let image = render_both(device, &points, &frame(camera, size, method));
                let wanted = reference::opaque::render(
                    View::new(&camera, size),
                    &points,
                    &colors,
                    shape,
                    &settings,
                    method.relief(),
                );
                let (largest, over) = difference(&image, &wanted, 1e-6);
                assert!(over == 0.0, "{method:?}: {largest}, {over} of the pixels");
                for (found, wanted) in image.depth.iter().zip(&wanted.depth) {
                    // One projection in float32.
                    assert!(
                        (f64::from(*found) - wanted).abs() <= 1e-6 * wanted.abs()
                            || (found.is_infinite() && wanted.is_infinite())
                    );
                }
            }
        }
    });
}

#[test]
fn shuffled_input_changes_no_byte_although_depths_tie() {
    with_device(|device| {
        let mut points = soup(3, 4000, 0.02..0.2, 0.1..0.9, false);
        for p in &mut points {
            p.position.z = (p.position.z * 2.0).round() / 2.0;
        }
        let camera = Camera { eye: DVec3::new(0.0, 0.0, 4.0), ..straight() };
        for (method, _, _) in METHODS {
            let frame = frame(camera, [100, 100], method);
            let first = bits(&render_both(device, &scene(&points), &frame));
            points.shuffle(&mut random(9));
            assert!(bits(&render_both(device, &scene(&points), &frame)) == first, "{method:?}");
        }
    });
}

fn straight() -> Camera {
    use pellucid_core::camera::Projection::Orthographic;
    Camera::look_at(DVec3::Z, DVec3::ZERO, DVec3::Y, Orthographic { height: 2.5 }, 0.1, 100.0).expect("valid")
}

#[test]
fn opacity_is_ignored_and_the_nearest_wins() {
    with_device(|device| {
        let at = |z: f64, color: Vec3| P {
            position: at_pixel(1.5, 1.5, z),
            color,
            opacity: 0.01,
            radius: 0.6,
            normal: Vec3::ZERO,
        };
        let points = scene(&[at(3.0, Vec3::X), at(2.0, Vec3::Y), at(4.0, Vec3::Z)]);
        for (method, covered) in [
            (Method::Points, 1),
            (Method::Circles(ScreenSplats::default()), 1),
            (Method::Squares(ScreenSplats::default()), 1),
        ] {
            let image = render_both(device, &points, &frame(pixel_camera([3, 3]), [3, 3], method));
            assert_eq!(image.rgba[4], [0.0, 1.0, 0.0, 1.0], "{method:?}");
            assert_eq!(image.depth[4], 2.0);
            assert_eq!(image.rgba.iter().filter(|c| c[3] == 1.0).count(), covered);
        }
    });
}

#[test]
fn a_radius_in_pixels_is_the_same_at_every_depth() {
    with_device(|device| {
        let camera = Camera { near: 0.01, far: 1e6, ..pixel_camera([40, 40]) };
        let perspective =
            Camera { projection: Projection::Perspective { fov_y: 0.8 }, eye: DVec3::new(20.0, -20.0, 0.0), ..camera };
        let settings = ScreenSplats { pixel_radius: Some(4.0), size: 9.0, ..ScreenSplats::default() };
        let relief = Interpolated { splats: settings, shape: SplatShape::Square };
        for camera in [camera, perspective] {
            for z in [0.5, 40.0, 40_000.0] {
                for radius in [0.0, 1.0, f32::MAX] {
                    let position = DVec3::new(20.0, -20.0, -z);
                    let points = scene(&[P { position, color: Vec3::ONE, opacity: 1.0, radius, normal: Vec3::ZERO }]);
                    // The center is a corner of four pixels: offsets of a half, 1½, 2½, 3½; the square has 8 × 8.
                    for (method, wanted) in
                        [(Method::Circles(settings), 52), (Method::Squares(settings), 64), (Method::Cone(relief), 64)]
                    {
                        let image = render_both(device, &points, &frame(camera, [40, 40], method));
                        let covered = image.rgba.iter().filter(|rgba| rgba[3] == 1.0).count();
                        assert_eq!(covered, wanted, "{} at {z}, radius {radius}", method.name());
                    }
                }
            }
        }
    });
}

#[test]
fn splats_of_a_pixel_radius_reach_into_windows_beside_their_points() {
    with_device(|device| {
        let points = scene(&soup(7, 400, 0.0..0.01, 0.1..0.9, false));
        let settings = ScreenSplats { pixel_radius: Some(20.0), ..ScreenSplats::default() };
        let whole = frame(perspective(), [120, 90], Method::Circles(settings));
        let mut renderer = Renderer::new(device).expect("a renderer");
        let mut cloud = renderer.upload(&points).expect("fits");
        let free = renderer.render(&mut cloud, &whole).expect("renders");
        let cut = renderer.render(&mut cloud, &Frame { memory_budget: Some(128 << 10), ..whole }).expect("renders");
        assert!(cut.facts.windows > free.facts.windows, "{}", cut.facts.windows);
        assert!(bits(&cut.image) == bits(&free.image));
    });
}
