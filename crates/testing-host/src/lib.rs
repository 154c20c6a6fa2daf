//! Parts of the tests that need no device: small clouds, comparison with the float64 reference, real clouds.

pub mod gaussians;
pub mod skip;

mod places;

use glam::{DVec3, Vec3};
use pellucid_core::camera::{Camera, Projection};
use pellucid_core::image::Image;
use pellucid_core::points::Points;
use pellucid_reference::View;
use pellucid_reference::range::PictureRange;
use pellucid_reference::{self as reference, ReferencePicture};
use pellucid_scene::prepare::order;
use pellucid_scene::{DiscShape, Discs, Falloff, Light, Raster, Shading};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

pub use places::{Clouds, clouds, root, shader_cache, whole_clouds};

/// How much a long test does: `short` where `PELLUCID_SHORT_SWEEPS` is 1, as in CI, which runs all of them.
pub fn long_or<T>(long: T, short: T) -> T {
    if std::env::var("PELLUCID_SHORT_SWEEPS").is_ok_and(|v| v == "1") { short } else { long }
}

/// True if tests rewrite generated documents and tables instead of comparing them: where `PELLUCID_UPDATE` is 1.
pub fn updates() -> bool {
    std::env::var("PELLUCID_UPDATE").is_ok_and(|v| v == "1")
}

/// A generator with a fixed seed.
pub fn random(seed: u64) -> Pcg64 {
    Pcg64::seed_from_u64(seed)
}

/// One test point.
#[derive(Debug, Clone, Copy)]
pub struct P {
    pub position: DVec3,
    pub color: Vec3,
    pub opacity: f32,
    pub radius: f32,
    pub normal: Vec3,
}

/// A list of points as a scene, in canonical order; normals only if any point has one.
pub fn scene(points: &[P]) -> Points {
    let all = scene_in_order(points);
    let normals = all.normals.filter(|normals| normals.iter().any(|n| *n != Vec3::ZERO));
    order::canonical(Points { normals, ..all })
}

/// White points of this opacity without radii.
pub fn white(positions: Vec<DVec3>, opacity: f32) -> Points {
    let count = positions.len();
    let (colors, opacities) = (vec![Vec3::ONE; count], vec![opacity; count]);
    Points { positions, colors, opacities, radii: vec![0.0; count], ..Points::default() }
}

/// Random points in a cube of side 2 around the origin.
pub fn soup(
    seed: u64,
    count: usize,
    radius: std::ops::Range<f32>,
    opacity: std::ops::Range<f32>,
    normals: bool,
) -> Vec<P> {
    let mut r = random(seed);
    let mut unit = || DVec3::new(r.random_range(-1.0..1.0), r.random_range(-1.0..1.0), r.random_range(-1.0..1.0));
    let places: Vec<(DVec3, DVec3)> = (0..count).map(|_| (unit(), unit())).collect();
    places
        .into_iter()
        .map(|(position, normal)| P {
            position: position.as_vec3().as_dvec3(),
            color: Vec3::new(r.random(), r.random(), r.random()),
            opacity: r.random_range(opacity.clone()),
            radius: r.random_range(radius.clone()),
            normal: if normals { normal.normalize().as_vec3() } else { Vec3::ZERO },
        })
        .collect()
}

/// A perspective camera that sees the cube of side 2.
pub fn perspective() -> Camera {
    let fov_y = 45f64.to_radians();
    looking(DVec3::new(1.0, 1.5, 4.0), DVec3::ZERO, Projection::Perspective { fov_y }, 0.1, 100.0)
}

fn looking(eye: DVec3, target: DVec3, projection: Projection, near: f64, far: f64) -> Camera {
    Camera::look_at(eye, target, DVec3::Y, projection, near, far).expect("a valid camera")
}

/// An orthographic camera that sees the cube of side 2 along its diagonal.
pub fn orthographic() -> Camera {
    looking(DVec3::new(2.0, 1.5, 4.0), DVec3::ZERO, Projection::Orthographic { height: 3.5 }, 0.1, 100.0)
}

/// A camera that looks down −Z onto pixels of one world unit: x and y are columns and rows from the image's corner.
pub fn pixel_camera(size: [u32; 2]) -> Camera {
    let center = DVec3::new(f64::from(size[0]) / 2.0, -f64::from(size[1]) / 2.0, 0.0);
    let height = f64::from(size[1]);
    looking(center, center - DVec3::Z, Projection::Orthographic { height }, 0.5, 1e7)
}

/// A point in pixel coordinates for [`pixel_camera`], at a depth.
pub fn at_pixel(x: f64, y: f64, depth: f64) -> DVec3 {
    DVec3::new(x, -y, -depth)
}

pub const SHAPES: [DiscShape; 2] = [DiscShape::Flat, DiscShape::Oriented];
pub const FALLOFFS: [Falloff; 2] = [Falloff::Flat, Falloff::Gaussian];
pub const RASTERS: [Raster; 2] = [Raster::Compute, Raster::Hardware];

/// All combinations of shape, falloff and raster.
pub fn all_discs() -> impl Iterator<Item = Discs> {
    SHAPES.into_iter().flat_map(|shape| {
        FALLOFFS
            .into_iter()
            .flat_map(move |falloff| RASTERS.map(|raster| Discs { shape, falloff, raster, ..Discs::default() }))
    })
}

/// Colors of points, without shading.
pub fn colors(points: &Points) -> Vec<DVec3> {
    points.colors.iter().map(|c| c.as_dvec3()).collect()
}

/// The exact image of transparent discs without shading, in float64.
pub fn exact(points: &Points, camera: &Camera, size: [u32; 2], discs: &Discs) -> ReferencePicture {
    reference::abuffer::render(View::new(camera, size), points, &colors(points), discs)
}

/// Keeps the points whose every coverage decision is clear in float32 too: 0.02 pixels from any rim, pixel border or
/// depth limit.
pub fn safe(points: &[P], camera: &Camera, size: [u32; 2], shape: DiscShape) -> Vec<P> {
    let all = scene_in_order(points);
    let clear = |i: usize| {
        reference::coverage::margin_px(View::new(camera, size), &reference::abuffer::splat(&all, i, shape)) > 0.02
    };
    (0..points.len()).filter(|i| clear(*i)).map(|i| points[i]).collect()
}

/// The points in the order given, for looking at them one by one.
fn scene_in_order(points: &[P]) -> Points {
    Points {
        positions: points.iter().map(|p| p.position).collect(),
        colors: points.iter().map(|p| p.color).collect(),
        opacities: points.iter().map(|p| p.opacity).collect(),
        radii: points.iter().map(|p| p.radius).collect(),
        normals: Some(points.iter().map(|p| p.normal).collect()),
        ..Points::default()
    }
}

/// Largest difference in R, G, B, A, and the share of pixels that differ by more than `limit`.
pub fn difference(image: &Image, reference: &ReferencePicture, limit: f64) -> (f64, f64) {
    assert_eq!(image.rgba.len(), reference.rgba.len());
    let mut largest = 0f64;
    let mut over = 0usize;
    for (a, b) in image.rgba.iter().zip(&reference.rgba) {
        let d = a.iter().zip(b).map(|(a, b)| (f64::from(*a) - b).abs()).fold(0.0, f64::max);
        // A NaN in the image must not pass as no difference.
        let d = if a.iter().any(|v| v.is_nan()) { f64::INFINITY } else { d };
        largest = largest.max(d);
        over += usize::from(d > limit);
    }
    (largest, over as f64 / image.rgba.len() as f64)
}

/// The bytes of an image, for comparisons to the bit.
pub fn bits(image: &Image) -> Vec<u32> {
    image.rgba.iter().flatten().chain(&image.depth).map(|v| v.to_bits()).collect()
}

/// The points that `keep` picks by their index, in their order.
pub fn picked(points: &Points, keep: impl Fn(usize) -> bool) -> Points {
    let kept: Vec<usize> = (0..points.len()).filter(|i| keep(*i)).collect();
    Points {
        positions: kept.iter().map(|i| points.positions[*i]).collect(),
        colors: kept.iter().map(|i| points.colors[*i]).collect(),
        opacities: kept.iter().map(|i| points.opacities[*i]).collect(),
        radii: kept.iter().map(|i| points.radii[*i]).collect(),
        normals: points.normals.as_ref().map(|normals| kept.iter().map(|i| normals[*i]).collect()),
        ..Points::default()
    }
}

/// Returns, in canonical order, the points of which float32 too can say which pixel they are on, whether they look at
/// the viewer, and on which side of them the light is.
pub fn clear_points(points: &[P], camera: &Camera, size: [u32; 2], shading: &Shading) -> Points {
    clear_of(&scene(points), camera, size, shading)
}

/// Selects points like [`clear_points`], from points that are in canonical order already.
pub fn clear_of(all: &Points, camera: &Camera, size: [u32; 2], shading: &Shading) -> Points {
    picked(all, |i| {
        let normal = all.normals.as_ref().map_or(DVec3::ZERO, |normals| normals[i].as_dvec3());
        let to_light = match shading.light {
            Light::Direction(travels) => -travels.normalize(),
            Light::Position(light) => (light - all.positions[i]).normalize(),
            Light::Headlight => DVec3::ZERO,
        };
        let facing = reference::image_space::facing(camera, all.positions[i], normal);
        let is_clear = |cos: f64| cos.abs() > 1e-3;
        reference::coverage::margin_px(View::new(camera, size), &reference::image_space::splat(all, i)) > 0.02
            && facing.is_none_or(is_clear)
            && (to_light == DVec3::ZERO || normal == DVec3::ZERO || is_clear(normal.dot(to_light)))
    })
}

/// Compares an image with what roundings of float32 may make of its reference: depths within their ranges, R, G, B and
/// A off theirs by at most `slack`, which is for the arithmetic of colors alone. An error names the first wrong pixel
/// and how many there are.
pub fn compare_ranges(image: &Image, wanted: &PictureRange, slack: f64) -> Result<(), String> {
    assert_eq!(image.rgba.len(), wanted.rgba.len());
    let is_off = |pixel: &usize| {
        let colors = image.rgba[*pixel].iter().zip(wanted.rgba[*pixel]);
        !wanted.depth[*pixel].covers(f64::from(image.depth[*pixel]), 0.0)
            || colors.into_iter().any(|(found, wanted)| !wanted.covers(f64::from(*found), slack))
    };
    let off: Vec<usize> = (0..image.rgba.len()).filter(is_off).collect();
    let Some(pixel) = off.first() else { return Ok(()) };
    Err(format!(
        "{} pixels are wrong, the first ({}, {}): {:?} at {}, not {:?} at {:?}",
        off.len(),
        pixel % wanted.width as usize,
        pixel / wanted.width as usize,
        image.rgba[*pixel],
        image.depth[*pixel],
        wanted.rgba[*pixel],
        wanted.depth[*pixel]
    ))
}

/// Writes a generated page into the sources of the book, the folder `PELLUCID_BOOK`, if there is one (tools/book.sh).
pub fn add_to_book(page: &str, text: &str) {
    if let Some(folder) = std::env::var_os("PELLUCID_BOOK") {
        std::fs::write(std::path::Path::new(&folder).join(page), text).expect("the book's sources can be written");
    }
}
