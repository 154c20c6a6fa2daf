//! `soft-base` and `soft-concentric` against the float64 reference: hard rays, cameras, densities and coordinates.

use std::f64::consts::PI;

use glam::{DVec3, Vec3};
use pellucid_core::camera::{Camera, Projection};
use pellucid_core::image::Image;
use pellucid_core::points::Points;
use pellucid_engine::methods::{Frame, Renderer};
use pellucid_gpu::Device;
use pellucid_reference::View;
use pellucid_reference::coverage::{Shape, margin_px};
use pellucid_reference::soft::{Behind, Model, Ray, Scene};
use pellucid_reference::{ReferencePicture, splats};
use pellucid_scene::prepare::order;
use pellucid_scene::{BlendedSplats, Density, Method, Shells, Soft};
use pellucid_testing::*;
use rand::RngExt;
use rand::seq::SliceRandom;

/// Every channel and A.
pub(crate) const BOUND: f64 = 3e-4;
/// Relative, of the entry depth; beside it a few roundings of the center's depth and the radius, whose difference it
/// is.
pub(crate) const DEPTH_BOUND: f64 = 1e-5;
pub(crate) const DEPTH_ROUNDINGS: f64 = 4.0 * f32::EPSILON as f64;
/// Spheres that a ray passes this near to their rim, relative to the radius, may be met or not: they contribute nothing
/// that counts, but decide about the entry depth and the list's length.
const RIM: f64 = 1e-5;

/// Error of d / r of a ray that a float32 position leaves, a few roundings of 1.
const ROUNDED: f64 = 2.4e-7;

/// A soft point, or a solid one.
#[derive(Debug, Clone, Copy)]
pub(crate) struct S {
    position: DVec3,
    radius: f32,
    color: Vec3,
    field: f32,
}

pub(crate) fn cloud(spheres: &[S]) -> Points {
    order::canonical(Points {
        positions: spheres.iter().map(|s| s.position).collect(),
        colors: spheres.iter().map(|s| s.color).collect(),
        opacities: vec![0.3; spheres.len()],
        radii: spheres.iter().map(|s| s.radius).collect(),
        fields: spheres.iter().map(|s| s.field).collect(),
        ..Points::default()
    })
}

/// Random soft points in a cube of side 2 around the origin.
pub(crate) fn soft_soup(seed: u64, count: usize, radius: std::ops::Range<f32>) -> Vec<S> {
    let each = soup(seed, count, radius, 0.1..0.9, false).into_iter();
    each.map(|p| S { position: p.position, radius: p.radius, color: p.color, field: 1.0 }).collect()
}

fn soft(density: Density) -> Soft {
    Soft { density, ..Soft::default() }
}

/// Base, and the concentric model with every kind of number of shells.
fn methods(settings: Soft) -> Vec<Method> {
    let shells = [Shells::Fixed(1), Shells::Fixed(3), Shells::Fixed(8), Shells::Adaptive];
    let concentric = shells.map(|shells| Method::SoftConcentric(Soft { shells, pixels_per_shell: 1.7, ..settings }));
    let constant = [Shells::Fixed(3), Shells::Adaptive]
        .map(|shells| Method::SoftConcentric(Soft { shells, pixels_per_shell: 1.7, equalize: false, ..settings }));
    [vec![Method::SoftBase(settings)], concentric.to_vec(), constant.to_vec()].concat()
}

fn densities() -> Vec<Density> {
    vec![
        Density::Softness(0.5),
        Density::Softness(1.0),
        Density::Lambda(1e-6),
        Density::Lambda(1e-3),
        Density::Lambda(1.0),
        Density::Lambda(1e3),
        Density::Lambda(1e6),
    ]
}

fn looking(eye: DVec3, target: DVec3, projection: Projection, near: f64) -> Camera {
    Camera::look_at(eye, target, DVec3::Y, projection, near, 1000.0).expect("a valid camera")
}

fn fov(degrees: f64) -> Projection {
    Projection::Perspective { fov_y: degrees * PI / 180.0 }
}

/// Cameras that see the cube of side 2 from outside: ordinary ones, and the narrowest and the widest view.
fn cameras() -> Vec<(&'static str, Camera)> {
    let towards = DVec3::new(0.3, 0.4, 1.0).normalize();
    vec![
        ("perspective", perspective()),
        ("orthographic", orthographic()),
        ("1 degree", looking(towards * 170.0, DVec3::ZERO, fov(1.0), 0.1)),
        ("120 degrees", looking(towards * 1.5, DVec3::ZERO, fov(120.0), 0.05)),
    ]
}

/// A rendered image, and the expected one.
pub(crate) struct Case {
    name: String,
    points: Points,
    camera: Camera,
    size: [u32; 2],
    /// Additional error of an entry, in radii.
    entry: f64,
}

impl Case {
    fn new(name: impl Into<String>, spheres: &[S], camera: Camera, size: [u32; 2]) -> Self {
        Self { name: name.into(), ..Self::of(cloud(spheres), camera, size) }
    }

    /// A case without a name.
    pub(crate) fn of(points: Points, camera: Camera, size: [u32; 2]) -> Self {
        Self { name: String::new(), points, camera, size, entry: 0.0 }
    }

    pub(crate) fn reference(&self, method: Method) -> ReferencePicture {
        let solids = self.solids();
        let behind = |pixel| solids.as_ref().map_or(Behind::NOTHING, |solids| Behind::from_picture(solids, pixel));
        self.scene(method, &self.colors()).render(behind)
    }

    fn colors(&self) -> Vec<DVec3> {
        self.points.colors.iter().map(|c| c.as_dvec3()).collect()
    }

    fn scene<'a>(&'a self, method: Method, colors: &'a [DVec3]) -> Scene<'a> {
        let model = Model::new(method.as_soft().expect("a soft method"), &self.points);
        Scene { view: View::new(&self.camera, self.size), points: &self.points, colors, model }
    }

    /// The picture of the solid points, if there are any; no pixel's center is near the rim of one.
    fn solids(&self) -> Option<ReferencePicture> {
        let solid: Vec<usize> = (0..self.points.len()).filter(|i| self.points.fields[*i] == 0.0).collect();
        let settings = BlendedSplats::default();
        for i in &solid {
            let splat =
                splats::splat(View::new(&self.camera, self.size), &self.points, *i, Shape::Disc, &settings.splats);
            assert!(margin_px(View::new(&self.camera, self.size), &splat) > 1e-3, "{}: solid point {i}", self.name);
        }
        let colors: Vec<DVec3> = solid.iter().map(|i| self.points.colors[*i].as_dvec3()).collect();
        let points = Points {
            positions: solid.iter().map(|i| self.points.positions[*i]).collect(),
            radii: solid.iter().map(|i| self.points.radii[*i]).collect(),
            ..Points::default()
        };
        let render = || splats::render(View::new(&self.camera, self.size), &points, &colors, Shape::Disc, &settings);
        (!solid.is_empty()).then(render)
    }

    fn image(&self, device: &Device, method: Method) -> Image {
        render(device, &self.points, &self.frame(method))
    }

    fn frame(&self, method: Method) -> Frame {
        frame(self.camera, self.size, method)
    }

    /// Pixels whose ray passes the rim of some sphere.
    pub(crate) fn doubtful(&self) -> Vec<bool> {
        let centers: Vec<DVec3> = self.points.positions.iter().map(|p| self.camera.to_view(*p)).collect();
        let at = |pixel: u32| {
            let ray = Ray::new(View::new(&self.camera, self.size), [pixel % self.size[0], pixel / self.size[0]]);
            let soft = (0..centers.len()).filter(|i| self.points.fields[*i] > 0.0);
            soft.map(|i| (centers[i], self.points.radii[i])).any(|(center, radius)| {
                let distance = (center - ray.origin).cross(ray.direction).length();
                (distance / f64::from(radius) - 1.0).abs() < RIM
            })
        };
        (0..self.size[0] * self.size[1]).map(at).collect()
    }
}

/// Additional error of each pixel where the density of shells is one for all rays: it begins at the rim of each
/// shell as a root, 2 λ (r/N) √(2 x r / rᵢ) at x = 1 − d / rᵢ, so that a ray within RIM of it is off by up to
/// 2 λ r √(2 ROUNDED). A shell that begins or ends within a rounding of near is in the first segment or not, and that
/// may be all that is seen: by its share of the weights there. `None` for shells of another kind. Denser spheres than
/// float32 can place are placed exactly.
fn at_rims(case: &Case, method: Method) -> Option<Vec<f64>> {
    let Method::SoftConcentric(Soft { equalize: false, .. }) = method else { return None };
    let colors = case.colors();
    let scene = case.scene(method, &colors);
    let spheres = scene.spheres();
    let [width, height] = case.size;
    let at = |pixel: u32| {
        let ray = Ray::new(scene.view, [pixel % width, pixel / width]);
        let near = case.camera.near * ray.stretch;
        let (mut rims, mut open, mut unsure) = (0.0, 0.0, 0.0);
        for sphere in &spheres {
            let distance = (sphere.center - ray.origin).cross(ray.direction).length();
            let shells = sphere.shells.unwrap_or(1);
            let radii = (0..shells).map(|i| sphere.radius * (1.0 - f64::from(i) / f64::from(shells)));
            if radii.clone().any(|rim| (distance / rim - 1.0).abs() < RIM) {
                let whole = 2.0 * scene.model.strength.lambda * sphere.radius;
                rims += (whole * (2.0 * ROUNDED).sqrt()).min(1.0);
            }
            for (chord, radius) in radii.filter_map(|radius| Some((ray.meet(sphere.center, radius)?, radius))) {
                let [from, to] = [chord.middle - chord.half - near, chord.middle + chord.half - near];
                let (weight, rounding) = (1.0 - distance / radius, DEPTH_ROUNDINGS * sphere.radius);
                open += if from < rounding && to > -rounding { weight } else { 0.0 };
                unsure += if from.abs() < rounding || to.abs() < rounding { weight } else { 0.0 };
            }
        }
        rims + if open > 0.0 { unsure / open } else { 0.0 }
    };
    Some((0..width * height).map(at).collect())
}

/// How far an image is from its reference.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Deviation {
    /// Largest difference of any channel of any pixel.
    rgba: f64,
    /// Largest relative difference of depths where they are certain.
    depth: f64,
    /// Lists of another length where that is certain.
    lengths: usize,
}

fn deviation(case: &Case, image: &Image, reference: &ReferencePicture, doubtful: &[bool]) -> Deviation {
    let (rgba, _) = difference(image, reference, 0.0);
    let radius = case.points.radii.iter().copied().fold(0.0, f32::max);
    let roundings = (DEPTH_ROUNDINGS + case.entry) * f64::from(radius);
    let certain = || (0..doubtful.len()).filter(|i| !doubtful[*i]);
    let apart = |i: usize| match (f64::from(image.depth[i]), reference.depth[i]) {
        (found, wanted) if found == wanted => 0.0,
        (found, wanted) if found.is_finite() && wanted.is_finite() => {
            ((found - wanted).abs() - roundings).max(0.0) / wanted
        }
        _ => f64::INFINITY,
    };
    let lengths = image.fragments.as_deref().expect("asked for");
    Deviation {
        rgba,
        depth: certain().map(apart).fold(0.0, f64::max),
        lengths: certain().filter(|i| lengths[*i] != reference.counts[*i]).count(),
    }
}

/// Largest difference of any channel beyond what each pixel is allowed.
fn beyond(image: &Image, reference: &ReferencePicture, allowed: &[f64]) -> f64 {
    let apart = |i: usize| {
        let channels = image.rgba[i].iter().zip(reference.rgba[i]);
        let off = channels.map(|(found, wanted)| (f64::from(*found) - wanted).abs() - allowed[i]);
        off.map(|off| if off.is_nan() { f64::INFINITY } else { off }).fold(0.0, f64::max)
    };
    (0..allowed.len()).map(apart).fold(0.0, f64::max)
}

/// Renders every pair of case, density and method in a third of all combinations; prints the worst deviations, and
/// fails after the last.
fn check(device: &Device, cases: &[Case], densities: &[Density]) {
    check_with(device, cases, densities, soft);
}

/// Renders and compares like [`check`], with settings for each density.
fn check_with(device: &Device, cases: &[Case], densities: &[Density], settings: impl Fn(Density) -> Soft) {
    let mut wrong = Vec::new();
    assert!(cases.len() >= 3 && densities.len() >= 3, "too few for every pair");
    for (i, case) in cases.iter().enumerate() {
        let doubtful = case.doubtful();
        for (j, density) in densities.iter().enumerate() {
            for method in methods(settings(*density)).into_iter().skip((2 * (i + j)) % 3).step_by(3) {
                let (reference, image) = (case.reference(method), case.image(device, method));
                let mut found = deviation(case, &image, &reference, &doubtful);
                if let Some(rims) = at_rims(case, method) {
                    found.rgba = beyond(&image, &reference, &rims);
                }
                let Deviation { rgba, depth, lengths } = found;
                let what = format!("{} by {}, {density:?}", case.name, describe(method));
                if rgba > 0.1 * BOUND || depth > 0.1 * DEPTH_BOUND {
                    println!("{what}: {rgba:.1e}, depth {depth:.1e}");
                }
                // NaN would be no number above the bound.
                if !(rgba <= BOUND && depth <= DEPTH_BOUND && lengths == 0) {
                    wrong.push(format!("{what}: {found:?}"));
                }
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

fn describe(method: Method) -> String {
    match method {
        Method::SoftConcentric(Soft { shells, equalize, .. }) => {
            format!("soft-concentric {shells:?}{}", if equalize { "" } else { ", constant" })
        }
        _ => "soft-base".into(),
    }
}

/// A sphere on the ray of each pixel, the further from it the further to the lower right: from through the center to
/// 10⁻⁶ of the radius within the rim.
fn one_on_each_ray(camera: &Camera, size: [u32; 2], depths: std::ops::Range<f64>) -> Vec<S> {
    let mut r = random(17);
    let count = size[0] * size[1];
    let sphere = |pixel: u32| {
        let ray = Ray::new(View::new(camera, size), [pixel % size[0], pixel / size[0]]);
        let place = f64::from(pixel) / f64::from(count - 1);
        // Evenly from 0 to 0.9, then by powers of ten to 1 − 10⁻⁶.
        let rho = if place < 0.5 { 1.8 * place } else { 1.0 - 10f64.powf(-1.0 - 10.0 * (place - 0.5)) };
        let z = r.random_range(depths.clone());
        // No larger than that the neighbors' rays miss it: half of their distance, less what it is off its own ray.
        let radius = (0.24 * z / camera.focal_px(size[1])) as f32;
        let radius = if matches!(camera.projection, Projection::Orthographic { .. }) {
            (0.24 / camera.focal_px(size[1])) as f32
        } else {
            radius
        };
        let across = ray.direction.cross(DVec3::new(r.random(), r.random(), r.random::<f64>() - 2.0)).normalize();
        let view = ray.origin + z * ray.stretch * ray.direction + rho * f64::from(radius) * across;
        let position = camera.eye + view.x * camera.right + view.y * camera.up + view.z * camera.forward;
        S { position, radius, color: Vec3::new(r.random(), r.random(), 1.0), field: 1.0 }
    };
    (0..count).map(sphere).collect()
}

#[test]
fn one_sphere_from_its_center_to_its_rim() {
    with_device(|device| {
        let size = [32, 24];
        let cases: Vec<Case> = cameras()
            .into_iter()
            .map(|(name, camera)| {
                let depths = 2.0 * camera.near.max(0.5)..90.0;
                Case::new(name, &one_on_each_ray(&camera, size, depths), camera, size)
            })
            .collect();
        for case in &cases {
            let lengths = case.reference(Method::SoftBase(Soft::default())).counts;
            assert!(lengths.iter().all(|n| *n == 1), "{}: one sphere on each ray", case.name);
        }
        check(device, &cases, &densities());
    });
}

#[test]
fn a_large_sphere_with_many_pixels_at_its_rim() {
    with_device(|device| {
        let sphere =
            S { position: DVec3::new(0.1, -0.2, 0.3), radius: 1.0, color: Vec3::new(1.0, 0.5, 0.2), field: 1.0 };
        // Half a chord is √(2 RIM) of the radius where a ray passes so near to the rim, and float32 knows that to
        // 2·10⁻⁷.
        let entry = 2e-7 / (2.0 * RIM).sqrt();
        let case = |(name, camera)| Case { entry, ..Case::new(name, &[sphere], camera, [320, 240]) };
        let cases: Vec<Case> = cameras().into_iter().map(case).collect();
        check(device, &cases, &[Density::Softness(0.5), Density::Lambda(1e3), Density::Lambda(1e6)]);
    });
}

#[test]
fn two_intersecting_spheres() {
    with_device(|device| {
        let two = [
            S { position: DVec3::new(-0.3, 0.0, 0.1), radius: 0.7, color: Vec3::new(1.0, 0.3, 0.0), field: 1.0 },
            S { position: DVec3::new(0.4, 0.2, -0.2), radius: 0.5, color: Vec3::new(0.0, 0.4, 1.0), field: 1.0 },
        ];
        let cases: Vec<Case> =
            cameras().into_iter().map(|(name, camera)| Case::new(name, &two, camera, [64, 48])).collect();
        check(device, &cases, &densities());
    });
}

#[test]
fn a_soup_of_two_hundred() {
    with_device(|device| {
        let spheres = soft_soup(3, 200, 0.02..0.4);
        let cases: Vec<Case> =
            cameras().into_iter().map(|(name, camera)| Case::new(name, &spheres, camera, [64, 48])).collect();
        check(device, &cases, &densities());
    });
}

#[test]
fn a_camera_inside_of_spheres() {
    with_device(|device| {
        let size = [24, 18];
        let eye = DVec3::new(0.1, -0.2, 0.3);
        let target = DVec3::new(-1.0, 0.5, -1.0);
        let one = S { position: DVec3::new(0.0, 0.0, 0.0), radius: 0.8, color: Vec3::ONE, field: 1.0 };
        let mut many = soft_soup(5, 150, 0.1..1.2);
        many.push(one);
        let mut cases = Vec::new();
        for projection in [fov(60.0), fov(120.0), Projection::Orthographic { height: 2.0 }] {
            for near in [1e-3, 0.2] {
                let camera = looking(eye, target, projection, near);
                cases.push(Case::new(format!("inside one, {projection:?}, near {near}"), &[one], camera, size));
                cases.push(Case::new(format!("inside many, {projection:?}, near {near}"), &many, camera, size));
            }
        }
        check(device, &cases, &densities());
    });
}

#[test]
fn spheres_cut_by_the_near_plane() {
    with_device(|device| {
        let size = [64, 48];
        let spheres = soft_soup(7, 60, 0.1..0.6);
        let towards = DVec3::new(0.3, 0.4, 1.0).normalize();
        let mut cases = Vec::new();
        for (projection, distance) in
            [(fov(45.0), 3.0), (fov(120.0), 1.2), (fov(1.0), 170.0), (Projection::Orthographic { height: 2.5 }, 3.0)]
        {
            // Through the middle of the cube.
            let camera = looking(towards * distance, DVec3::ZERO, projection, distance);
            cases.push(Case::new(format!("{projection:?}"), &spheres, camera, size));
        }
        for case in &cases {
            let near = case.camera.near;
            let picture = case.reference(Method::SoftBase(Soft::default()));
            assert!(picture.depth.contains(&near), "{}: something is cut", case.name);
        }
        check(device, &cases, &densities());
    });
}

#[test]
fn spheres_cut_by_solid_points() {
    with_device(|device| {
        let mut spheres = soft_soup(19, 80, 0.1..0.5);
        // Flat discs through the middle of it.
        let solids = [(DVec3::new(-0.3, 0.2, 0.0), 0.41), (DVec3::new(0.5, -0.3, 0.3), 0.33), (DVec3::ZERO, 0.2)];
        spheres.extend(solids.map(|(position, radius)| S {
            position,
            radius,
            color: Vec3::new(0.9, 0.8, 0.1),
            field: 0.0,
        }));
        let cases: Vec<Case> =
            cameras().into_iter().map(|(name, camera)| Case::new(name, &spheres, camera, [64, 48])).collect();
        for case in &cases {
            let solids = case.solids().expect("solid points");
            let covered = solids.rgba.iter().filter(|pixel| pixel[3] == 1.0).count();
            assert!((40..2500).contains(&covered), "{}: {covered} pixels before solids", case.name);
        }
        check(device, &cases, &densities());
    });
}

#[test]
fn two_thousand_spheres_open_at_once() {
    with_device(|device| {
        // Radii of 1 to 1.5 around places within 0.3 of the origin: every ray through the origin's neighborhood is
        // within all of them.
        let mut r = random(23);
        let mut unit = || DVec3::new(r.random_range(-1.0..1.0), r.random_range(-1.0..1.0), r.random_range(-1.0..1.0));
        let places: Vec<DVec3> = (0..2000).map(|_| 0.15 * unit()).collect();
        let spheres: Vec<S> = places
            .into_iter()
            .map(|position| {
                let color = Vec3::new(r.random(), r.random(), r.random());
                S { position, radius: r.random_range(1.0..1.5), color, field: 1.0 }
            })
            .collect();
        let towards = DVec3::new(0.3, 0.4, 1.0).normalize();
        let cases = [("perspective", fov(2.0)), ("orthographic", Projection::Orthographic { height: 0.2 })].map(
            |(name, projection)| {
                Case::new(name, &spheres, looking(towards * 5.0, DVec3::ZERO, projection, 0.1), [3, 2])
            },
        );
        for (density, method) in [
            (Density::Softness(0.0005), Method::SoftBase as fn(Soft) -> Method),
            (Density::Softness(0.01), Method::SoftBase),
            (Density::Softness(0.001), |soft| Method::SoftConcentric(Soft { shells: Shells::Fixed(3), ..soft })),
        ] {
            for case in &cases {
                let method = method(soft(density));
                let reference = case.reference(method);
                assert_eq!(reference.counts, [2000; 6]);
                let found = deviation(case, &case.image(device, method), &reference, &case.doubtful());
                println!("{} {}, {density:?}: {found:?}", case.name, describe(method));
                assert!(found.rgba <= BOUND && found.depth <= DEPTH_BOUND && found.lengths == 0, "{found:?}");
            }
        }
    });
}

#[test]
fn modulated_spheres() {
    with_device(|device| {
        let mut spheres = soft_soup(9, 200, 0.05..0.4);
        for (i, sphere) in spheres.iter_mut().enumerate() {
            sphere.field = 0.3 + 0.7 * (i as f32 + 0.5) / 200.0;
        }
        let cases: Vec<Case> =
            cameras().into_iter().map(|(name, camera)| Case::new(name, &spheres, camera, [48, 36])).collect();
        let settings = |density| Soft { threshold: 0.3, modulation: Some(0.8), ..soft(density) };
        check_with(device, &cases, &densities(), settings);
    });
}

/// Largest difference of any channel.
fn apart(a: &Image, b: &Image) -> f64 {
    let each = a.rgba.iter().flatten().zip(b.rgba.iter().flatten()).map(|(a, b)| f64::from((a - b).abs()));
    // A NaN must not pass as no difference.
    each.map(|d| if d.is_nan() { f64::INFINITY } else { d }).fold(0.0, f64::max)
}

#[test]
fn neither_scale_nor_place_of_a_scene_shows() {
    with_device(|device| {
        let size = [80, 60];
        let spheres = soft_soup(11, 150, 0.02..0.4);
        let far_off = DVec3::new(500_000.0, 4_500_000.0, 100.0);
        for (name, camera) in cameras() {
            let here = Case::new(name, &spheres, camera, size);
            let changed = |factor: f64, offset: DVec3| {
                let place = |p: DVec3| p * factor + offset;
                let sphere = |s: &S| S { position: place(s.position), radius: s.radius * factor as f32, ..*s };
                let projection = match camera.projection {
                    Projection::Orthographic { height } => Projection::Orthographic { height: height * factor },
                    perspective => perspective,
                };
                let eye = place(camera.eye);
                let (near, far) = (camera.near * factor, camera.far * factor);
                let camera = Camera { eye, near, far, projection, ..camera };
                Case::new(name, &spheres.iter().map(sphere).collect::<Vec<_>>(), camera, size)
            };
            for method in methods(soft(Density::Softness(0.6))) {
                let image = here.image(device, method);
                for other in [
                    changed(1000.0, DVec3::ZERO),
                    changed(1e-3, DVec3::ZERO),
                    changed(1.0, far_off),
                    changed(1000.0, far_off),
                ] {
                    let found = apart(&image, &other.image(device, method));
                    assert!(found < 1e-3, "{name} by {}: {found:e}", describe(method));
                }
            }
        }
    });
}

#[test]
fn the_order_of_the_points_does_not_show() {
    with_device(|device| {
        let mut spheres = soft_soup(13, 300, 0.05..0.5);
        // Coincident ones of other colors, and spheres that begin where others end.
        for i in 0..100 {
            spheres[i + 100] = S { color: spheres[i + 100].color, ..spheres[i] };
            spheres[i].position = (spheres[i].position * 4.0).round() / 4.0;
            spheres[i].radius = 0.25;
        }
        for camera in [perspective(), orthographic()] {
            for method in methods(Soft::default()) {
                let first = bits(&Case::new("", &spheres, camera, [64, 48]).image(device, method));
                let mut shuffled = spheres.clone();
                for seed in 0..3 {
                    shuffled.shuffle(&mut random(seed));
                    let again = bits(&Case::new("", &shuffled, camera, [64, 48]).image(device, method));
                    assert!(again == first, "{}", describe(method));
                }
            }
        }
    });
}

#[test]
fn bands_do_not_show() {
    with_device(|device| {
        let spheres = soft_soup(15, 400, 0.1..0.6);
        let case = Case::new("", &spheres, perspective(), [96, 72]);
        for method in methods(Soft::default()) {
            let mut renderer = Renderer::new(device).expect("a renderer");
            let mut cloud = renderer.upload(&case.points).expect("fits");
            let whole = renderer.render(&mut cloud, &case.frame(method)).expect("renders");
            let budget = Frame { memory_budget: Some(512 << 10), ..case.frame(method) };
            let cut = renderer.render(&mut cloud, &budget).expect("renders");
            assert!(cut.facts.bands > whole.facts.bands, "{:?}", cut.facts);
            assert!(bits(&cut.image) == bits(&whole.image), "{}", describe(method));
        }
    });
}

#[test]
fn the_comparison_notices_wrong_images() {
    with_device(|device| {
        let case = Case::new("", &soft_soup(3, 200, 0.02..0.4), perspective(), [64, 48]);
        let method = Method::SoftBase(Soft::default());
        let (reference, doubtful) = (case.reference(method), case.doubtful());
        let right = case.image(device, method);
        let middle = 24 * 64 + 32;
        assert!(!doubtful[middle]);
        let wrong = |change: &dyn Fn(&mut Image)| {
            let mut image = right.clone();
            change(&mut image);
            deviation(&case, &image, &reference, &doubtful)
        };
        assert!(wrong(&|image| image.rgba[middle][1] += 7e-4).rgba > BOUND);
        assert!(wrong(&|image| image.rgba[middle][3] = f32::NAN).rgba > BOUND);
        assert!(wrong(&|image| image.depth[middle] *= 1.0 + 3e-5).depth > DEPTH_BOUND);
        assert!(wrong(&|image| image.depth[middle] = f32::NAN).depth > DEPTH_BOUND);
        assert!(wrong(&|image| image.depth[middle] = f32::INFINITY).depth > DEPTH_BOUND);
        assert_eq!(wrong(&|image| image.fragments.as_mut().expect("asked for")[middle] += 1).lengths, 1);
        // Another model is another image.
        let other = case.image(device, Method::SoftConcentric(Soft::default()));
        assert!(deviation(&case, &other, &reference, &doubtful).rgba > 10.0 * BOUND);
    });
}
