//! Shadow textures: cases with known answers, seen through the colors that they give.
//!
//! Lambert without ambient light shows m: a white point has the gray m·n·l, one without a normal m. Most scenes lie
//! under [`pixel_camera`], one world unit to a pixel, and what would hide the rest is nearer than the camera's near
//! plane: it casts its shadow unseen.

use glam::{DVec3, Vec3};
use pellucid_core::camera::Camera;
use pellucid_core::image::Image;
use pellucid_core::points::Points;
use pellucid_engine::methods::shadows::lights;
use pellucid_engine::methods::{Frame, Renderer};
use pellucid_gpu::Device;
use pellucid_reference as reference;
use pellucid_reference::range::{ROUNDING, Range};
use pellucid_reference::shadows::Frames;
use pellucid_scene::{
    BlendedSplats, Discs, ImageSpace, Interpolated, Iterations, Light, MapResolution, Method, PeelLayers, ScreenSplats,
    Shading, ShadingModel, Shadows,
};
use pellucid_testing::*;
use rand::seq::SliceRandom;

/// Straight down onto the scene.
const DOWN: Light = Light::Direction(DVec3::NEG_Z);

/// All light comes from the lamp.
fn lamp(light: Light) -> Shading {
    Shading { model: ShadingModel::Lambert, ambient: 0.0, diffuse: 1.0, light, ..Shading::default() }
}

pub(crate) fn hard(resolution: u32, distance: f32) -> Shadows {
    Shadows {
        samples: 1,
        light_radius: 0.0,
        resolution: MapResolution::Pixels(resolution),
        fill: Iterations::Count(0),
        occlusion: Iterations::Count(1),
        min_layer_distance: Some(distance),
    }
}

/// A white point in pixel coordinates for [`pixel_camera`].
fn point(x: f64, y: f64, depth: f64, normal: Vec3) -> P {
    P { position: at_pixel(x, y, depth), color: Vec3::ONE, opacity: 1.0, radius: 0.7, normal }
}

/// A point in the middle of each pixel, `depth` below the camera.
fn floor(size: [u32; 2], normal: Vec3, depth: impl Fn(f64, f64) -> f64) -> Vec<P> {
    let all = (0..size[1]).flat_map(|y| (0..size[0]).map(move |x| [x, y].map(|at| f64::from(at) + 0.5)));
    all.map(|[x, y]| point(x, y, depth(x, y), normal)).collect()
}

/// A sheet of points `step` apart.
fn lid(x: std::ops::Range<f64>, y: std::ops::Range<f64>, depth: f64, step: f64) -> Vec<P> {
    let along = |range: std::ops::Range<f64>| {
        let count = ((range.end - range.start) / step).round() as u32;
        (0..count).map(move |i| range.start + (f64::from(i) + 0.5) * step)
    };
    along(x).flat_map(|x| along(y.clone()).map(move |y| point(x, y, depth, Vec3::ZERO))).collect()
}

/// A camera that sees depths of `near` and more.
fn camera(size: [u32; 2], near: f64) -> Camera {
    Camera { near, ..pixel_camera(size) }
}

fn lit_frame(camera: Camera, size: [u32; 2], light: Light, shadows: Shadows) -> Frame {
    Frame { shading: lamp(light), shadows: Some(shadows), ..frame(camera, size, Method::Points) }
}

/// The red of each pixel; each has a point.
fn reds(image: &Image) -> Vec<f32> {
    assert!(image.rgba.iter().all(|c| c[3] == 1.0 && c[0] == c[1]), "a pixel is empty");
    image.rgba.iter().map(|c| c[0]).collect()
}

/// m of the points of a floor without normals.
fn shares(device: &Device, points: &[P], near: f64, size: [u32; 2], light: Light, shadows: Shadows) -> Vec<f32> {
    reds(&render(device, &scene(points), &lit_frame(camera(size, near), size, light, shadows)))
}

/// A direction that comes `degrees` off the vertical, `turn` degrees from x in the image's plane.
fn slanted(degrees: f64, turn: f64) -> DVec3 {
    let (sin, cos) = degrees.to_radians().sin_cos();
    let (y, x) = turn.to_radians().sin_cos();
    DVec3::new(sin * x, sin * y, -cos)
}

#[test]
fn a_plane_alone_is_lit() {
    with_device(|device| {
        let size = [48, 40];
        for degrees in [0.0, 30.0, 60.0, 80.0f64] {
            // The floor is flat and the light slanted, or the other way round.
            let tan = degrees.to_radians().tan();
            let tilted = Vec3::new(degrees.to_radians().sin() as f32, 0.0, degrees.to_radians().cos() as f32);
            let flat = |normal| floor(size, normal, |_, _| 400.0);
            let steep = |normal| floor(size, normal, |x, _| 400.0 + tan * x);
            let along = Light::Direction(slanted(degrees, 20.0));
            let lamp = Light::Position(DVec3::new(24.0, -20.0, -400.0) - 300.0 * slanted(degrees, 20.0));
            for resolution in [16u32, 200] {
                // Pixels of the light are so wide at most, from corner to corner.
                let across = 1.5 * 48f64.hypot(40.0) / f64::from(resolution - 2);
                let least = 3.0 * across;
                for (floor, light) in
                    [(flat(Vec3::Z), along), (flat(Vec3::NEG_Z), along), (flat(Vec3::Z), lamp), (steep(tilted), DOWN)]
                {
                    let points = scene(&floor);
                    let image = |shadows| {
                        let frame = lit_frame(camera(size, 0.5), size, light, hard(resolution, least as f32));
                        bits(&render(device, &points, &Frame { shadows, ..frame }))
                    };
                    let shadows = Some(hard(resolution, least as f32));
                    assert!(image(shadows) == image(None), "{degrees}°, {light:?}, {resolution}");
                }
                // Without normals d̃ has to do by itself.
                let distance = least * (1.0 + tan);
                for (floor, light) in [(flat(Vec3::ZERO), along), (steep(Vec3::ZERO), DOWN)] {
                    let shares = shares(device, &floor, 0.5, size, light, hard(resolution, distance as f32));
                    assert!(shares.iter().all(|m| *m == 1.0), "{degrees}°, {resolution}");
                }
            }
        }
    });
}

#[test]
fn too_small_a_distance_darkens_a_steep_plane() {
    with_device(|device| {
        // Were this lit too, the case above would say nothing.
        let size = [48, 40];
        let along = Light::Direction(slanted(80.0, 20.0));
        let shares = shares(device, &floor(size, Vec3::ZERO, |_, _| 400.0), 0.5, size, along, hard(16, 4.0));
        assert!(shares.iter().filter(|m| **m == 0.0).count() > 100);
    });
}

/// A floor at depth 90 under a lid at depth 50.
const FLOOR: f64 = 90.0;
const LID: f64 = 50.0;

#[test]
fn a_square_casts_its_shadow_and_no_other() {
    with_device(|device| {
        let size = [64, 64];
        for normal in [Vec3::ZERO, Vec3::Z] {
            let points = [floor(size, normal, |_, _| FLOOR), lid(20.0..44.0, 16.0..40.0, LID, 0.25)].concat();
            for (degrees, turn) in [(0.0, 0.0), (20.0, 0.0), (15.0, 120.0)] {
                let direction = slanted(degrees, turn);
                // How far the shadow moves on the way down; y is down in the image.
                let shift = direction * (FLOOR - LID) / -direction.z;
                let distant = |far: f64| Light::Position(DVec3::new(32.0, -28.0, -LID) - far * direction);
                for light in [Light::Direction(direction), distant(2e4), distant(1e6)] {
                    let frame = lit_frame(camera(size, 70.0), size, light, hard(256, 5.0));
                    let reds = reds(&render(device, &scene(&points), &frame));
                    // Lambert at a place of the floor; rays to a lamp are not quite parallel.
                    let full = |pixel: usize| match light {
                        _ if normal == Vec3::ZERO => 1.0,
                        Light::Position(lamp) => {
                            let place = at_pixel((pixel % 64) as f64 + 0.5, (pixel / 64) as f64 + 0.5, FLOOR);
                            (lamp - place).normalize().z
                        }
                        _ => -direction.z,
                    };
                    let mut dark = 0;
                    for (pixel, red) in reds.iter().enumerate() {
                        let (x, y) = ((pixel % 64) as f64 + 0.5 - shift.x, (pixel / 64) as f64 + 0.5 + shift.y);
                        let inside = (12.0 - (x - 32.0).abs()).min(12.0 - (y - 28.0).abs());
                        // A pixel of the light is half a unit wide.
                        if inside.abs() < 1.0 {
                            continue;
                        }
                        let wanted = if inside > 0.0 { 0.0 } else { full(pixel) };
                        assert!((f64::from(*red) - wanted).abs() < 1e-5, "{degrees}° {light:?}: {pixel}, {red}");
                        dark += usize::from(inside > 0.0);
                    }
                    assert!(dark > 400, "{dark}");
                }
            }
            // Surfaces nearer than d̃ are one.
            let together = lit_frame(camera(size, 70.0), size, DOWN, hard(256, 41.0));
            assert!(reds(&render(device, &scene(&points), &together)).iter().all(|red| *red == 1.0));
        }
    });
}

#[test]
fn gaps_of_a_pixel_of_the_light_let_none_through() {
    with_device(|device| {
        // Points of the lid one unit apart; pixels of the light are 64/74 units wide, so that a seventh of their
        // columns and of their rows have none.
        let size = [64, 64];
        let points = [floor(size, Vec3::ZERO, |_, _| FLOOR), lid(0.0..64.0, 0.0..64.0, LID, 1.0)].concat();
        let shares = shares(device, &points, 70.0, size, DOWN, hard(76, 5.0));
        let inside = |pixel: usize| (2..62).contains(&(pixel % 64)) && (2..62).contains(&(pixel / 64));
        assert!((0..64 * 64).filter(|pixel| inside(*pixel)).all(|pixel| shares[pixel] == 0.0));
        // Gaps that are wider stay open.
        let wide = [floor(size, Vec3::ZERO, |_, _| FLOOR), lid(0.0..64.0, 0.0..64.0, LID, 4.0)].concat();
        let open = self::shares(device, &wide, 70.0, size, DOWN, hard(128, 5.0));
        assert!(open.iter().filter(|m| **m == 1.0).count() > 2000);
    });
}

/// The share of a unit disc on one side of a line at distance t from its center, the side of the center for t > 0.
fn share_of_disc(t: f64) -> f64 {
    let t = t.clamp(-1.0, 1.0);
    0.5 + (t.asin() + t * (1.0 - t * t).sqrt()) / std::f64::consts::PI
}

#[test]
#[ignore = "long: 3,000 images of lights"]
fn half_a_disc_of_light_is_half_the_light() {
    with_device(|device| {
        let size = [64, 9];
        // A half-plane over the left half: its border is at x = 32, and reaches beyond the floor in y as far as the
        // light does.
        let mut points = floor(size, Vec3::ZERO, |_, _| FLOOR);
        // The middle column of points lies right below the border.
        points.iter_mut().for_each(|p| p.position.x -= 0.5);
        points.iter_mut().filter(|p| p.position.x == 0.0).for_each(|p| p.position.x = 0.25);
        points.extend(lid(-10.0..32.0, -8.0..17.0, LID, 0.25));
        let (radius, height) = (10.0f64, 60.0);
        // By how many radii of the disc the line through a point and the border misses its center.
        let reach = (FLOOR - LID) * radius.to_radians().tan();
        let direction = |x: f64| (x - 32.0) / reach;
        // A lamp in the middle above: radius in world units, the border half-way.
        let center = bounds_center(&points);
        let lamp_at = DVec3::new(32.0, center.y, -LID + height);
        let toward = (center - lamp_at).normalize();
        let lamp_radius = 12.0;
        for (light, light_radius, t, slack) in [
            (DOWN, radius as f32, &direction as &dyn Fn(f64) -> f64, 0.0),
            // The disc is a little tilted toward the middle of the points, so that the line is only nearly in its
            // plane.
            (
                Light::Position(lamp_at),
                lamp_radius as f32,
                &|x: f64| (x - 32.0) * height / (FLOOR - LID) / lamp_radius,
                0.06 + (1.0 + toward.z).abs(),
            ),
        ] {
            for samples in [16u32, 100, 400] {
                let mut means = [0f64; 64];
                for seed in 0..3 {
                    let shadows = Shadows { samples, light_radius, ..hard(360, 5.0) };
                    let frame = Frame { seed, ..lit_frame(camera(size, 70.0), size, light, shadows) };
                    let image = render(device, &scene(&points), &frame);
                    for (x, mean) in means.iter_mut().enumerate() {
                        let m = f64::from(image.rgba[4 * 64 + x][0]);
                        *mean += m / 3.0;
                        let at = if x == 0 { 0.25 } else { x as f64 };
                        let wanted = share_of_disc(t(at));
                        // Four standard errors of as many independent lights, and a pixel of the light's image over the
                        // penumbra.
                        let bound = 4.0 * (wanted * (1.0 - wanted) / f64::from(samples)).sqrt() + 0.06 + slack;
                        assert!((m - wanted).abs() < bound, "{light:?}, {samples}, x {at}: {m} {wanted}");
                        // M lights give multiples of 1/M.
                        let lights = m * f64::from(samples);
                        assert!((lights - lights.round()).abs() < 1e-3, "{m} of {samples}");
                    }
                }
                let bound = 4.0 * 0.5 / (3.0 * f64::from(samples)).sqrt() + slack;
                assert!((means[32] - 0.5).abs() < bound + 0.06, "{light:?}, {samples}: {}", means[32]);
                assert!((means[0], means[63]) == (0.0, 1.0));
            }
        }
    });
}

fn bounds_center(points: &[P]) -> DVec3 {
    scene(points).bounds().expect("there are points").center()
}

#[test]
fn the_seed_shifts_the_lights_of_an_area_alone() {
    with_device(|device| {
        let size = [64, 9];
        let points = scene(&[floor(size, Vec3::ZERO, |_, _| FLOOR), lid(-40.0..32.0, -16.0..25.0, LID, 0.5)].concat());
        let of = |light_radius, samples, seed| {
            let shadows = Shadows { samples, light_radius, ..hard(256, 5.0) };
            bits(&render(device, &points, &Frame { seed, ..lit_frame(camera(size, 70.0), size, DOWN, shadows) }))
        };
        assert!(of(10.0, 9, 0) == of(10.0, 9, 0));
        assert!(of(10.0, 9, 0) != of(10.0, 9, 1));
        assert!(of(10.0, 9, 0) != of(10.0, 10, 0));
        // Without an area all lights are the same one.
        assert!(of(0.0, 1, 0) == of(0.0, 30, 7));
    });
}

#[test]
fn a_light_among_the_points_shines_in_all_directions() {
    with_device(|device| {
        // Walls of a cube around the light, 20 wide, in those of one of 40; the light is a little off the middle.
        let size = [42, 42];
        let middle = at_pixel(21.0, 21.0, 100.0);
        let walls = |half: f64| {
            let steps = (4.0 * half) as i32;
            let along = move |i: i32| (f64::from(i) + 0.5) / 2.0 - half;
            let sides = [DVec3::X, DVec3::Y, DVec3::Z].into_iter().flat_map(move |axis| {
                let edges = [DVec3::new(axis.y, axis.z, axis.x), DVec3::new(axis.z, axis.x, axis.y)];
                [-1.0, 1.0].into_iter().flat_map(move |sign| {
                    (0..steps).flat_map(move |i| {
                        (0..steps).map(move |j| sign * half * axis + along(i) * edges[0] + along(j) * edges[1])
                    })
                })
            });
            sides.map(move |p| P { position: middle + p, ..point(0.0, 0.0, 0.0, Vec3::ZERO) })
        };
        let points = scene(&walls(10.0).chain(walls(20.0)).collect::<Vec<_>>());
        let light = Light::Position(middle + DVec3::new(0.3, -0.2, 0.1));
        let mut renderer = Renderer::new(device).expect("a renderer");
        let mut cloud = renderer.upload(&points).expect("fits");
        // From each of four sides along z and x: down to the inner walls' far side, and to the outer ones' behind it.
        for (forward, up) in [
            (DVec3::NEG_Z, DVec3::Y),
            (DVec3::Z, DVec3::Y),
            (DVec3::X, DVec3::Y),
            (DVec3::NEG_X, DVec3::Y),
            (DVec3::Y, DVec3::X),
            (DVec3::NEG_Y, DVec3::X),
        ] {
            let right = forward.cross(up);
            for (near, half, wanted) in [(0.5, 10.0, 1.0), (15.0, 20.0, 0.0)] {
                let camera = Camera { eye: middle, right, up, forward, near, ..pixel_camera(size) };
                let image =
                    renderer.render(&mut cloud, &lit_frame(camera, size, light, hard(64, 2.0))).expect("renders");
                let mut seen = 0;
                for (pixel, rgba) in image.image.rgba.iter().enumerate() {
                    let off = |at: usize| (at as f64 + 0.5 - 21.0).abs();
                    // Away from the walls' edges, where the inner ones hide less than half a pixel more or less.
                    if off(pixel % 42).max(off(pixel / 42)) < half - 1.5 {
                        assert_eq!(*rgba, [wanted, wanted, wanted, 1.0], "{forward}, {near}, pixel {pixel}");
                        seen += 1;
                    }
                }
                assert!(seen > 250);
            }
        }
    });
}

/// m of all points as the device finds it, and as the reference does with the same lights.
pub(crate) fn textures(
    device: &Device,
    points: &Points,
    light: Light,
    shadows: Shadows,
    seed: u64,
) -> (Vec<f32>, Vec<Range>) {
    let mut renderer = Renderer::new(device).expect("a renderer");
    let mut cloud = renderer.upload(points).expect("fits");
    let frame = Frame { seed, ..lit_frame(perspective(), [8, 8], light, shadows) };
    let casting = renderer.cast(&mut cloud, &frame).expect("casts").expect("there are shadows");
    let found = cloud.lit().expect("it can be read");
    let bounds = points.bounds().expect("there are points");
    let cameras = |i: u32| -> Frames {
        let light = lights::light(&casting, &bounds, i);
        let views = lights::views(light, &bounds, casting.resolution, casting.reach());
        views.iter().map(|view| view.camera).collect()
    };
    let cameras: Vec<Frames> = (0..casting.samples).map(cameras).collect();
    let map = reference::shadows::Map {
        resolution: casting.resolution,
        fill: casting.fill,
        occlusion: casting.occlusion,
        distance: casting.min_layer_distance.into(),
    };
    (found, reference::shadows::share_ranges(&cameras, map, points))
}

/// The points that have another m, which is a quotient of whole numbers.
fn different(found: &[f32], wanted: &[Range]) -> Vec<usize> {
    assert_eq!(found.len(), wanted.len());
    (0..found.len()).filter(|point| !wanted[*point].covers(f64::from(found[*point]), ROUNDING)).collect()
}

#[test]
fn the_share_of_each_point_equals_the_reference() {
    with_device(|device| {
        for normals in [true, false] {
            let points = scene(&jumble(normals));
            for light in [
                SUN,
                Light::Direction(DVec3::NEG_Y),
                Light::Position(DVec3::new(3.0, 6.0, 1.0)),
                Light::Position(DVec3::new(0.1, 0.2, -0.1)),
                Light::Position(DVec3::new(0.3, 1.2, 0.0)),
            ] {
                for shadows in [hard(48, 0.1), hard(150, 0.03), AREA, Shadows { min_layer_distance: None, ..AREA }] {
                    let (found, wanted) = textures(device, &points, light, shadows, 3);
                    let lit = wanted.iter().map(|m| m.low).sum::<f64>() / wanted.len() as f64;
                    assert!((0.02..0.98).contains(&lit), "{light:?}: {lit} of the light arrives");
                    let off = different(&found, &wanted);
                    assert!(off.is_empty(), "{light:?} {shadows:?}, normals {normals}: points {off:?}");
                    // The comparison can fail: another distance, and a single point.
                    let distance = shadows.min_layer_distance.unwrap_or(0.035);
                    let other = Shadows { min_layer_distance: Some(3.0 * distance), ..shadows };
                    let changed = different(&found, &textures(device, &points, light, other, 3).1).len();
                    let mut flipped = found.clone();
                    flipped[1000] = 1.0 - flipped[1000];
                    assert_eq!(different(&flipped, &wanted), [1000]);
                    assert!(changed > 30, "{light:?} {shadows:?}, normals {normals}: {changed} points");
                }
            }
        }
    });
}

/// A cloud with plenty of shadow in it.
fn jumble(normals: bool) -> Vec<P> {
    soup(12, 6000, 0.02..0.1, 0.1..0.9, normals)
}

const AREA: Shadows = Shadows {
    samples: 5,
    light_radius: 4.0,
    resolution: MapResolution::Pixels(64),
    fill: Iterations::Count(1),
    occlusion: Iterations::Count(1),
    min_layer_distance: Some(0.1),
};
const SUN: Light = Light::Direction(DVec3::new(0.5, -1.0, -0.4));

#[test]
fn where_there_is_no_light_to_miss_nothing_changes() {
    with_device(|device| {
        let points = scene(&jumble(true));
        let mut renderer = Renderer::new(device).expect("a renderer");
        let mut cloud = renderer.upload(&points).expect("fits");
        let lambert = lamp(SUN);
        for (method, shading) in [
            (Method::Points, Shading { light: Light::Headlight, ..lambert }),
            (Method::Points, Shading { model: ShadingModel::None, ..lambert }),
            (Method::ABuffer(Discs::default()), lambert),
        ] {
            let frame = Frame { shading, ..frame(perspective(), [90, 70], method) };
            let plain = renderer.render(&mut cloud, &frame).expect("renders");
            let asked = renderer.render(&mut cloud, &Frame { shadows: Some(AREA), ..frame }).expect("renders");
            assert!(bits(&asked.image) == bits(&plain.image), "{method:?}");
            assert!(!casts(&asked.profile.passes), "{method:?}");
        }
        // The passes have that name.
        let cast = Frame { shading: lambert, shadows: Some(AREA), ..frame(perspective(), [90, 70], Method::Points) };
        assert!(casts(&renderer.render(&mut cloud, &cast).expect("renders").profile.passes));
    });
}

fn casts(passes: &[pellucid_engine::methods::PassProfile]) -> bool {
    passes.iter().any(|pass| pass.name.starts_with("shadows/"))
}

#[test]
fn a_texture_is_cast_once_and_belongs_to_its_light() {
    with_device(|device| {
        for normals in [true, false] {
            let mut jumble = jumble(normals);
            let points = scene(&jumble);
            let frame = Frame {
                shading: Shading { specular: 0.3, model: ShadingModel::Phong, ..lamp(SUN) },
                shadows: Some(AREA),
                ..frame(perspective(), [90, 70], Method::Points)
            };
            let mut renderer = Renderer::new(device).expect("a renderer");
            let mut cloud = renderer.upload(&points).expect("fits");
            let mut bytes = |frame: &Frame| {
                let rendered = renderer.render(&mut cloud, frame).expect("renders");
                (bits(&rendered.image), casts(&rendered.profile.passes))
            };
            let (first, cast) = bytes(&frame);
            assert!(cast);
            assert!(bytes(&frame) == (first.clone(), false), "the texture is kept");
            // Another camera, size and method do not need another one.
            let other = Frame {
                camera: orthographic(),
                size: [40, 80],
                method: Method::Circles(ScreenSplats::default()),
                ..frame
            };
            assert!(!bytes(&other).1);
            // Without shadows, then with them again.
            let unlit = bytes(&Frame { shadows: None, ..frame });
            assert!(unlit.0 != first && !unlit.1);
            assert!(bytes(&frame).0 == first);
            let lights = [
                Frame {
                    shading: Shading { light: Light::Direction(DVec3::new(-0.5, -1.0, -0.4)), ..frame.shading },
                    ..frame
                },
                Frame {
                    shading: Shading { light: Light::Position(DVec3::new(0.0, 5.0, 0.0)), ..frame.shading },
                    ..frame
                },
                Frame { shadows: Some(Shadows { light_radius: 40.0, ..AREA }), ..frame },
                Frame { shadows: Some(Shadows { resolution: MapResolution::Pixels(16), ..AREA }), ..frame },
                Frame { shadows: Some(Shadows { fill: Iterations::Count(4), ..AREA }), ..frame },
                Frame { shadows: Some(Shadows { occlusion: Iterations::Count(0), ..AREA }), ..frame },
                Frame { shadows: Some(Shadows { min_layer_distance: Some(0.5), ..AREA }), ..frame },
                Frame { seed: 9, ..frame },
            ];
            for light in lights {
                let (changed, cast) = bytes(&light);
                assert!(cast && changed != first, "{:?} {:?}", light.shading.light, light.shadows);
            }
            assert!(bytes(&frame).0 == first);
            // Neither the order of the points nor the kind of atomics shows.
            jumble.shuffle(&mut random(5));
            assert!(bits(&render(device, &scene(&jumble), &frame)) == first);
            let mut renderer = Renderer::new(device).expect("a renderer");
            renderer.switches.wide_atomics = false;
            let mut cloud = renderer.upload(&points).expect("fits");
            assert!(bits(&renderer.render(&mut cloud, &frame).expect("renders").image) == first);
            // Nor does a budget that cuts the image.
            let tight = Frame { memory_budget: Some(256 << 10), ..frame };
            assert!(bits(&renderer.render(&mut cloud, &tight).expect("renders").image) == first);
        }
    });
}

#[test]
fn all_opaque_methods_take_shadows() {
    with_device(|device| {
        // A lid of many colors over a floor: m is 0 below it and 1 elsewhere, away from its border.
        let size = [40, 40];
        let mut points = [floor(size, Vec3::ZERO, |_, _| FLOOR), lid(8.0..30.0, 12.0..33.0, LID, 0.25)].concat();
        for (i, p) in points.iter_mut().enumerate() {
            p.color = Vec3::new(0.2, 0.5, 1.0) * (1.0 + (i % 7) as f32) / 8.0;
        }
        // Leaves out what is near the border: there it is the light's pixels that decide.
        let border = |p: &P| {
            let [x, y] = [p.position.x, -p.position.y];
            (11.0 - (x - 19.0).abs()).min(10.5 - (y - 22.5).abs())
        };
        points.retain(|p| p.position.z == -LID || border(p).abs() > 1.0);
        let dark: Vec<P> = points
            .iter()
            .map(|p| P { color: if p.position.z == -FLOOR && border(p) > 0.0 { Vec3::ZERO } else { p.color }, ..*p })
            .collect();
        let screen = ScreenSplats::default();
        let filters = ImageSpace { min_layer_distance: Some(3.0), ..ImageSpace::default() };
        for method in [
            Method::Points,
            Method::Squares(screen),
            Method::Circles(screen),
            Method::Paraboloid(Interpolated { splats: screen, ..Interpolated::default() }),
            Method::Cone(Interpolated { splats: screen, ..Interpolated::default() }),
            Method::Sphere(screen),
            Method::Hqs(BlendedSplats::default()),
            Method::Splats(BlendedSplats::default()),
            Method::ImageSpace(filters),
            Method::PeelLayers(PeelLayers { filters, layers: 3, ..PeelLayers::default() }),
        ] {
            assert!(method.takes_shadows());
            let cast = Frame { method, ..lit_frame(camera(size, 70.0), size, DOWN, hard(128, 5.0)) };
            let shown = render(device, &scene(&points), &cast);
            let wanted = render(device, &scene(&dark), &Frame { shading: Shading::NONE, shadows: None, ..cast });
            assert!(shown.depth == wanted.depth, "{method:?}");
            for (pixel, (a, b)) in shown.rgba.iter().zip(&wanted.rgba).enumerate() {
                assert!(a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-5), "{method:?}: pixel {pixel}, {a:?} {b:?}");
            }
        }
    });
}

#[test]
fn what_is_dark_keeps_its_ambient_light() {
    with_device(|device| {
        let size = [32, 32];
        let normal = Vec3::new(0.3, 0.1, 1.0).normalize();
        let points = scene(&[floor(size, normal, |_, _| FLOOR), lid(-4.0..20.0, -4.0..60.0, LID, 0.5)].concat());
        let shading = Shading {
            model: ShadingModel::Phong,
            ambient: 0.25,
            diffuse: 0.5,
            specular: 0.4,
            shininess: 3.0,
            light: Light::Direction(slanted(20.0, 90.0)),
            ..Shading::default()
        };
        let cast = Frame { shading, ..lit_frame(camera(size, 70.0), size, DOWN, hard(128, 5.0)) };
        let image = render(device, &points, &cast);
        let full = render(device, &points, &Frame { shadows: None, ..cast });
        for y in 0..32 {
            for (x, ambient) in [(3, true), (17, true), (23, false), (30, false)] {
                let (found, full) = (image.rgba[y * 32 + x], full.rgba[y * 32 + x]);
                assert!(full[0] > 0.8, "{full:?}");
                let wanted = if ambient { [0.25, 0.25, 0.25, 1.0] } else { full };
                assert_eq!(found, wanted, "({x}, {y})");
            }
        }
        // Lit by half of the lights: half of what is not ambient, by the float64 formula.
        let lit = vec![0.5; points.len()];
        let colors = reference::shading::shade_lit(&points, &cast.camera, &shading, cast.color, &lit);
        let of_floor = points.positions.iter().position(|p| p.z == -FLOOR).expect("a floor");
        let wanted = 0.5 * (f64::from(full.rgba[0][0]) + 0.25);
        assert!((colors[of_floor].x - wanted).abs() < 1e-5, "{} {wanted}", colors[of_floor].x);
    });
}
