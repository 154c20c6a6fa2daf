//! `soft-express`: images against float64, in order of depth where the axis gives that, and in the axis' order
//! elsewhere; against the bytes of `sorted`; modulation; what solid points hide; whatever must not show.

use glam::{DVec3, Vec3};
use pellucid_core::camera::Camera;
use pellucid_core::camera::Projection::{Orthographic, Perspective};
use pellucid_core::image::Image;
use pellucid_core::points::Points;
use pellucid_engine::methods::{Frame, Renderer};
use pellucid_gpu::Device;
use pellucid_reference::View;
use pellucid_reference::soft::{Behind, Model, Scene};
use pellucid_reference::{self as reference, ReferencePicture, coverage};
use pellucid_scene::prepare::axes::Axis;
use pellucid_scene::prepare::order;
use pellucid_scene::{Density, DiscShape, Discs, Method, Soft};
use pellucid_testing::*;
use rand::RngExt;
use rand::seq::SliceRandom;

const THRESHOLD: f32 = 0.25;

fn settings(softness: f32, modulation: Option<f32>) -> Soft {
    Soft { threshold: THRESHOLD, density: Density::Softness(softness), modulation, ..Soft::default() }
}

fn express(softness: f32, modulation: Option<f32>) -> Method {
    Method::SoftExpress(settings(softness, modulation))
}

/// Points with fields as a scene.
fn with_fields(points: &[(P, f32)]) -> Points {
    order::canonical(Points {
        positions: points.iter().map(|(p, _)| p.position).collect(),
        colors: points.iter().map(|(p, _)| p.color).collect(),
        opacities: points.iter().map(|(p, _)| p.opacity).collect(),
        radii: points.iter().map(|(p, _)| p.radius).collect(),
        fields: points.iter().map(|(_, f)| *f).collect(),
        ..Points::default()
    })
}

/// Points with one field value for all.
fn with_field(points: &[P], field: f32) -> Points {
    with_fields(&points.iter().map(|p| (*p, field)).collect::<Vec<_>>())
}

/// The image of the soft points in float64, composed in the order of a key: smallest first, then as the points stand.
fn composed(
    points: &Points,
    frame: &Frame,
    order: impl Fn(DVec3) -> f64,
    hidden: impl Fn(f64, usize) -> bool,
) -> ReferencePicture {
    let soft = *frame.method.soft().expect("a soft method");
    let Density::Softness(peak) = soft.density else { panic!("of a softness") };
    let (camera, size) = (&frame.camera, frame.size);
    let mut indices: Vec<usize> = (0..points.len()).filter(|i| points.fields[*i] > soft.threshold).collect();
    indices.sort_by(|a, b| order(points.positions[*a]).total_cmp(&order(points.positions[*b])));
    let pixels = size[0] as usize * size[1] as usize;
    let [width, height] = size;
    let mut picture = ReferencePicture {
        width,
        height,
        rgba: vec![[0.0; 4]; pixels],
        depth: vec![f64::INFINITY; pixels],
        counts: vec![0; pixels],
    };
    for i in indices {
        let (center, z) = camera.project(points.positions[i], size);
        if z < camera.near || z > camera.far {
            continue;
        }
        let radius = f64::from(points.radii[i]) * camera.pixels_per_unit(z, size[1]);
        let w = soft.modulation.map_or(1.0, |most| {
            let [f, t, most] = [points.fields[i], soft.threshold, most].map(f64::from);
            if f < most { (f - t) / (most - t) } else { 1.0 }
        });
        for y in 0..size[1] {
            for x in 0..size[0] {
                let away = (f64::from(x) + 0.5 - center.x).hypot(f64::from(y) + 0.5 - center.y);
                let rho = (away / radius).min(1.0);
                let phi = f64::from(peak) * ((std::f64::consts::PI * rho).cos() + 1.0) / 2.0;
                let alpha = f64::from(peak) * (1.0 - rho) * (1.0 - w) + phi * w;
                let p = (y * size[0] + x) as usize;
                if alpha > 0.0 && !hidden(z, p) {
                    let weight = (1.0 - picture.rgba[p][3]) * alpha;
                    for (sum, c) in picture.rgba[p].iter_mut().zip(points.colors[i].extend(1.0).to_array()) {
                        *sum += weight * f64::from(c);
                    }
                    picture.depth[p] = if picture.depth[p].is_infinite() { z } else { picture.depth[p] };
                }
            }
        }
    }
    picture
}

/// The picture in the order of the method: along the axis nearest to the view.
fn along_axis(points: &Points, frame: &Frame) -> ReferencePicture {
    let colors: Vec<DVec3> = points.colors.iter().map(|c| c.as_dvec3()).collect();
    let model = Model::new(frame.method.as_soft().expect("a soft method"), points);
    Scene { view: View::new(&frame.camera, frame.size), points, colors: &colors, model }.render(|_| Behind::NOTHING)
}

/// The picture in order of depth.
fn by_depth(points: &Points, frame: &Frame) -> ReferencePicture {
    composed(points, frame, |p| frame.camera.to_view(p).z, |_, _| false)
}

/// Largest difference of color and A, of depth as well, where both know the first disc: next to a rim opacities of
/// nothing and next to nothing differ by rounding.
#[track_caller]
fn assert_close(image: &Image, wanted: &ReferencePicture, limit: f64) {
    let (largest, _) = difference(image, wanted, 0.0);
    assert!(largest < limit, "{largest}");
    let mut apart = 0;
    for (found, wanted) in image.depth.iter().zip(&wanted.depth) {
        let close = (f64::from(*found) - wanted).abs() <= 2e-5 * wanted.abs();
        apart += usize::from(!(close || (found.is_infinite() && wanted.is_infinite())));
    }
    assert!(apart * 200 <= image.depth.len(), "{apart} depths of {}", image.depth.len());
    let seen = image.rgba.iter().filter(|p| p[3] > 0.1).count();
    assert!(seen * 10 > image.rgba.len(), "{seen} pixels with anything to see");
}

/// The six views along the axes.
fn axis_views(height: f64) -> [Camera; 6] {
    [DVec3::X, -DVec3::X, DVec3::Y, -DVec3::Y, DVec3::Z, -DVec3::Z].map(|direction| {
        let up = if direction.y == 0.0 { DVec3::Y } else { DVec3::Z };
        Camera::look_at(-8.0 * direction, DVec3::ZERO, up, Orthographic { height }, 0.1, 100.0).expect("valid")
    })
}

fn rendered(device: &Device, points: &Points, frame: &Frame) -> Image {
    render(device, points, frame)
}

/// A frame that asks for an image only.
fn plain(camera: Camera, size: [u32; 2], method: Method) -> Frame {
    Frame { fragments: false, ..frame(camera, size, method) }
}

#[test]
fn views_along_the_axes_are_exactly_in_order_of_depth() {
    with_device(|device| {
        let points = with_field(&soup(1, 700, 0.05..0.4, 0.0..1.0, false), 1.0);
        for camera in axis_views(2.2) {
            let frame = plain(camera, [64, 48], express(0.6, None));
            assert_close(&rendered(device, &points, &frame), &by_depth(&points, &frame), 1e-5);
        }
    });
}

/// Discs in the middles of pixels that touch no other pixel: there the profile is 1, and the method is `sorted`.
#[test]
fn views_along_the_axes_have_the_bytes_of_sorted() {
    with_device(|device| {
        let size = [24, 24];
        let mut r = random(5);
        for camera in axis_views(24.0) {
            // Depths that no rounding makes equal, in no order; and no tile with more than `sorted` composes in one go.
            let mut depths: Vec<f64> = (0..4000).map(|i| f64::from(i - 2000) / 1024.0).collect();
            depths.shuffle(&mut r);
            let mut disc = |depth: f64| {
                let mut pixel = || f64::from(r.random_range(0..24)) - 11.5;
                let (x, y) = (pixel(), pixel());
                let position = x * camera.right + y * camera.up + depth * camera.forward;
                P { position, color: Vec3::from(r.random::<[f32; 3]>()), opacity: 0.3, radius: 0.9, normal: Vec3::ZERO }
            };
            let points: Vec<P> = depths.into_iter().map(&mut disc).collect();
            let points = with_field(&points, 1.0);
            let found = rendered(device, &points, &plain(camera, size, express(0.3, None)));
            let wanted = rendered(device, &points, &plain(camera, size, Method::Sorted(Discs::default())));
            let met = found.rgba.iter().filter(|p| p[3] > 0.5).count();
            assert!(met * 10 > found.rgba.len() * 9, "{met} pixels with several of 4000 discs");
            assert!(bits(&found) == bits(&wanted), "{}", camera.forward);
        }
    });
}

#[test]
fn other_views_have_the_order_of_the_nearest_axis() {
    with_device(|device| {
        let mixed = [soup(2, 900, 0.02..0.3, 0.0..1.0, false), soup(3, 12, 0.5..2.0, 0.0..1.0, false)].concat();
        let points = with_field(&mixed, 1.0);
        let eyes =
            [[4.0, 1.5, 1.0], [-4.0, 1.0, 2.0], [0.5, 5.0, 0.6], [1.0, -5.0, 1.0], [1.0, 1.5, 4.0], [2.0, 0.0, -3.5]];
        let mut worst = 0f64;
        for eye in eyes.map(DVec3::from) {
            let up = DVec3::new(0.1, 0.3, 0.9);
            let projection = Perspective { fov_y: 45f64.to_radians() };
            let camera = Camera::look_at(eye, DVec3::ZERO, up, projection, 0.1, 100.0).expect("valid");
            let frame = plain(camera, [72, 56], express(0.5, None));
            let image = rendered(device, &points, &frame);
            assert_close(&image, &along_axis(&points, &frame), 2e-5);
            worst = worst.max(difference(&image, &by_depth(&points, &frame), 0.0).0);
        }
        // The method's own error, which no order of points along an axis avoids.
        assert!(worst > 1e-3, "{worst}");
    });
}

#[test]
fn discs_are_counted_where_they_cover_pixels() {
    with_device(|device| {
        let mixed = [soup(12, 1000, 0.0..0.2, 0.0..1.0, false), soup(13, 12, 0.5..2.0, 0.0..1.0, false)].concat();
        for camera in [perspective(), orthographic()] {
            let size = [72, 56];
            let all = with_field(&mixed, 1.0);
            let flat = |i: usize| reference::abuffer::splat(&all, i, DiscShape::Flat);
            let clear = |i: &usize| coverage::margin_px(View::new(&camera, size), &flat(*i)) > 0.02;
            let kept: Vec<P> = (0..all.len())
                .filter(clear)
                .map(|i| {
                    let (position, color, radius) = (all.positions[i], all.colors[i], all.radii[i]);
                    P { position, color, opacity: 1.0, radius, normal: Vec3::ZERO }
                })
                .collect();
            assert!(kept.len() > 600, "{}", kept.len());
            // Of an opacity of 1 nothing behind would be seen, and yet it counts.
            let points = with_field(&kept, 1.0);
            for softness in [0.2, 1.0] {
                let counting = frame(camera, size, express(softness, None));
                let mut renderer = Renderer::new(device).expect("a renderer");
                let mut cloud = renderer.upload(&points).expect("fits");
                let found = renderer.render(&mut cloud, &counting).expect("renders");
                let wanted = along_axis(&points, &counting);
                assert_eq!(found.image.fragments.as_deref(), Some(&wanted.counts[..]));
                assert_eq!(found.facts.fragments, wanted.counts.iter().map(|n| u64::from(*n)).sum::<u64>());
                assert_eq!(Some(&found.facts.max_list), wanted.counts.iter().max());
                assert_close(&found.image, &wanted, 2e-5);
                let plain = Frame { fragments: false, ..counting };
                assert!(bits(&rendered(device, &points, &plain)) == bits(&found.image), "counting changes no byte");
            }
        }
    });
}

/// A disc without normal that covers the image.
fn wall(depth: f64, color: Vec3, size: [u32; 2]) -> P {
    let position = at_pixel(f64::from(size[0]) / 2.0, f64::from(size[1]) / 2.0, depth);
    P { position, color, opacity: 1.0, radius: 24.0, normal: Vec3::ZERO }
}

#[test]
fn what_lies_behind_solid_points_is_not_drawn() {
    with_device(|device| {
        let size = [24, 20];
        let color = Vec3::new(0.1, 0.9, 0.4);
        let mut r = random(14);
        let mut soft: Vec<(P, f32)> = (0..400)
            .map(|_| {
                let (x, y, depth) = (r.random_range(0.0..24.0), r.random_range(0.0..20.0), r.random_range(2.0..8.0));
                let color = Vec3::from(r.random::<[f32; 3]>());
                (
                    P {
                        position: at_pixel(x, y, depth),
                        color,
                        opacity: 1.0,
                        radius: r.random_range(1.0..5.0),
                        normal: Vec3::ZERO,
                    },
                    1.0,
                )
            })
            .collect();
        // Exactly on the wall: behind it.
        soft.push((P { color: Vec3::ONE, radius: 30.0, ..wall(4.0, color, size) }, 1.0));
        let frame = frame(pixel_camera(size), size, express(0.3, None));
        let alone = with_fields(&soft);
        let by_depth = |p: DVec3| -p.z;
        let mut picture = composed(&alone, &frame, by_depth, |z, _| z >= 4.0);
        for (rgba, depth) in picture.rgba.iter_mut().zip(&mut picture.depth) {
            let rest = 1.0 - rgba[3];
            for (sum, c) in rgba.iter_mut().zip(color.extend(1.0).to_array()) {
                *sum += rest * f64::from(c);
            }
            *depth = depth.min(4.0);
        }
        let both = with_fields(&[&soft[..], &[(wall(4.0, color, size), 0.1)]].concat());
        let image = rendered(device, &both, &frame);
        assert_close(&image, &picture, 1e-5);
        assert!(image.rgba.iter().all(|p| (p[3] - 1.0).abs() < 1e-6));
        // The reference would know a wall that hides nothing, or too much.
        for depth in [3.9, 4.1] {
            let other = with_fields(&[&soft[..], &[(wall(depth, color, size), 0.1)]].concat());
            assert!(difference(&rendered(device, &other, &frame), &picture, 0.0).0 > 1e-3);
        }
    });
}

#[test]
fn a_wrong_axis_would_show() {
    with_device(|device| {
        let points = with_field(&soup(4, 700, 0.05..0.4, 0.0..1.0, false), 1.0);
        for camera in axis_views(2.2) {
            let frame = plain(camera, [48, 48], express(0.8, None));
            let image = rendered(device, &points, &frame);
            let right = Axis::nearest(camera.forward);
            for (index, sign) in [(0, 1.0), (1, 1.0), (2, 1.0), (0, -1.0), (1, -1.0), (2, -1.0)] {
                let picture = composed(&points, &frame, |p| sign * p[index], |_, _| false);
                let (largest, _) = difference(&image, &picture, 0.0);
                let same = right == Axis { index, backward: sign < 0.0 };
                assert_eq!(largest < 1e-5, same, "{right:?} {index} {sign}: {largest}");
                assert!(same || largest > 0.1, "{right:?} {index} {sign}: {largest}");
            }
        }
    });
}

#[test]
fn fields_just_above_the_threshold_are_modulated() {
    with_device(|device| {
        let mut r = random(6);
        let fields = soup(7, 900, 0.05..0.3, 0.0..1.0, false).into_iter().map(|p| (p, r.random_range(0.26f32..1.0)));
        let points = with_fields(&fields.collect::<Vec<_>>());
        for camera in [perspective(), axis_views(2.2)[4]] {
            let method = |modulation| express(0.7, modulation);
            let modulated = plain(camera, [64, 48], method(Some(0.8)));
            let image = rendered(device, &points, &modulated);
            assert_close(&image, &along_axis(&points, &modulated), 2e-5);
            let (largest, _) = difference(&image, &along_axis(&points, &plain(camera, [64, 48], method(None))), 0.0);
            assert!(largest > 0.02, "the reference knows the difference: {largest}");
        }
    });
}

#[test]
fn input_order_windows_and_further_frames_change_no_byte() {
    with_device(|device| {
        // On a grid, so that many coordinates are equal; and in a corner more discs of a tile than one run takes.
        let mut points = soup(8, 6000, 0.05..0.3, 0.0..1.0, false);
        for p in &mut points {
            p.position = (p.position * 8.0).round() / 8.0;
        }
        points.extend(
            soup(9, 5000, 0.01..0.1, 0.0..1.0, false).into_iter().map(|p| P { position: p.position * 0.1, ..p }),
        );
        let mut renderer = Renderer::new(device).expect("a renderer");
        let mut cloud = renderer.upload(&with_field(&points, 1.0)).expect("fits");
        let frame = plain(perspective(), [500, 380], express(0.02, None));
        let first = renderer.render(&mut cloud, &frame).expect("renders");
        let wanted = bits(&first.image);
        assert!(first.facts.tile_entries > 20_000 && first.facts.windows == 1, "{:?}", first.facts);
        assert!(bits(&renderer.render(&mut cloud, &frame).expect("renders").image) == wanted);
        for seed in 0..2 {
            points.shuffle(&mut random(seed));
            assert!(bits(&rendered(device, &with_field(&points, 1.0), &frame)) == wanted);
        }
        let mut most = 1;
        for budget in [2_400_000, 2_700_000, 4_000_000] {
            let small = Frame { memory_budget: Some(budget), ..frame };
            let again = renderer.render(&mut cloud, &small).expect("renders");
            assert!(bits(&again.image) == wanted, "{budget}: {} windows", again.facts.windows);
            most = most.max(again.facts.windows);
        }
        assert!(most > 3, "{most} windows");
    });
}

#[test]
fn an_order_is_made_once() {
    with_device(|device| {
        let mut r = random(10);
        let fields = soup(11, 500, 0.05..0.3, 0.0..1.0, false).into_iter().map(|p| (p, r.random::<f32>()));
        let points = with_fields(&fields.collect::<Vec<_>>());
        let mut renderer = Renderer::new(device).expect("a renderer");
        let mut cloud = renderer.upload(&points).expect("fits");
        assert_eq!(cloud.orders_made(), 0);
        let [x, _, y, _, z, back] = axis_views(2.2);
        cloud.make_room(device).expect("room for splats");
        let before = cloud.bytes();
        for (threshold, softness, camera, made) in [
            (0.1, 0.5, z, 1),
            (0.6, 0.5, z, 1),
            (0.6, 0.9, back, 1),
            (0.6, 0.9, x, 2),
            (0.1, 0.1, y, 3),
            (0.2, 0.1, z, 3),
        ] {
            let method = Method::SoftExpress(Soft { threshold, ..settings(softness, None) });
            let frame = plain(camera, [40, 40], method);
            let image = renderer.render(&mut cloud, &frame).expect("renders").image;
            assert_eq!(cloud.orders_made(), made);
            assert!(bits(&image) == bits(&rendered(device, &points, &frame)), "as if it were the first frame");
        }
        assert_eq!(cloud.bytes() - before, 3 * 4 * 500);
    });
}

#[test]
fn extremes() {
    with_device(|device| {
        let (camera, size) = (pixel_camera([4, 4]), [4, 4]);
        let disc = |x: f64, depth: f64, radius: f32, color: Vec3| P {
            position: at_pixel(x, 1.5, depth),
            color,
            opacity: 1.0,
            radius,
            normal: Vec3::ZERO,
        };
        let of = |points: &[P], softness| {
            rendered(device, &with_field(points, 1.0), &plain(camera, size, express(softness, None)))
        };
        // In the middle of a pixel λ itself, on the rim nothing, and nothing of a disc without extent.
        let image = of(&[disc(1.5, 2.0, 1.0, Vec3::X), disc(3.5, 2.0, 0.0, Vec3::ONE)], 0.25);
        let wanted = (0..16).map(|p| if p == 5 { [0.25, 0.0, 0.0, 0.25] } else { [0.0; 4] }).collect::<Vec<_>>();
        assert_eq!(image.rgba, wanted);
        assert!(image.depth.iter().enumerate().all(|(p, z)| if p == 5 { *z == 2.0 } else { z.is_infinite() }));
        // Opaque discs hide what is behind; a peak of 0 shows nothing; tiny and huge radii.
        let both = [disc(1.5, 2.0, 3.0, Vec3::X), disc(1.5, 3.0, 3.0, Vec3::Y)];
        assert_eq!(of(&both, 1.0).rgba[5], [1.0, 0.0, 0.0, 1.0]);
        assert_eq!(of(&both, 0.0), of(&[disc(1.5, 2.0, 0.0, Vec3::X)], 1.0));
        assert_eq!(of(&[disc(1.5, 2.0, 1e-30, Vec3::X)], 0.5).rgba[5], [0.5, 0.0, 0.0, 0.5]);
        assert!(of(&[disc(1.5, 2.0, 1e30, Vec3::X)], 0.5).rgba.iter().all(|p| *p == [0.5, 0.0, 0.0, 0.5]));
        // Nothing is soft: the solid points alone.
        let two = [disc(1.5, 2.0, 1.0, Vec3::X), disc(1.5, 30.0, 1.0, Vec3::Y)];
        let none = rendered(device, &with_field(&two, 0.2), &plain(camera, size, express(0.5, None)));
        assert_eq!((none.rgba[5], none.depth[5]), ([1.0, 0.0, 0.0, 1.0], 2.0));
        // A long list of very little: 1 - (1 - 1e-5)^100000.
        let many: Vec<P> = (0..100_000).map(|i| disc(1.5, 2.0 + f64::from(i) * 1e-5, 1.0, Vec3::ONE)).collect();
        let found = of(&many, 1e-5).rgba[5][3];
        assert!((f64::from(found) - 0.632_122_4).abs() < 2e-5, "{found}");
    });
}
