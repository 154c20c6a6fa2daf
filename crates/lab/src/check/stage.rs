//! The stage of the cases: a renderer, small clouds, cameras that make positions on the screen exact.

use glam::{DVec3, Vec3};

use super::{CaseResult, Finding};
use pellucid_core::camera::{Camera, Projection};
use pellucid_core::image::Image;
use pellucid_core::points::Points;
use pellucid_engine::methods::{Error, Frame, Rendered, Renderer};
use pellucid_gpu::Device;
use pellucid_reference::abuffer::{Fragment, composite};
use pellucid_scene::Method;
use pellucid_scene::prepare::{Arranged, order};

/// Half a unit in the last place, relative: the largest error of a rounding to float32.
pub const HALF_ULP: f64 = f32::EPSILON as f64 / 2.0;
/// A unit in the last place.
pub const ULP: f64 = 2.0 * HALF_ULP;
/// The relative error of a compensated sum of any length (2 units: Kahan 1965), for color and weight, their quotient
/// (2.5 units) and two products.
pub const COMPENSATED: f64 = 9.0 * ULP;
/// Colors of which no two are alike.
pub const COLORS: [Vec3; 5] = [
    Vec3::new(0.9, 0.1, 0.2),
    Vec3::new(0.1, 0.8, 0.3),
    Vec3::new(0.3, 0.2, 1.0),
    Vec3::new(0.7, 0.6, 0.1),
    Vec3::new(0.2, 0.4, 0.5),
];

/// A device with a renderer.
pub struct CaseRenderer {
    /// The renderer.
    pub renderer: Renderer,
}

/// A point of a case.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Dot {
    /// World position.
    pub position: DVec3,
    /// Linear RGB.
    pub color: Vec3,
    /// Opacity.
    pub opacity: f32,
    /// World radius.
    pub radius: f32,
    /// Unit normal, or zero.
    pub normal: Vec3,
    /// The field that makes it soft.
    pub field: f32,
}

impl Default for Dot {
    fn default() -> Self {
        Self { position: DVec3::ZERO, color: Vec3::ONE, opacity: 1.0, radius: 0.0, normal: Vec3::ZERO, field: 0.0 }
    }
}

impl CaseRenderer {
    /// A stage on a device.
    ///
    /// # Errors
    /// A device that has no memory for the first buffers.
    pub fn new(device: &Device) -> Result<Self, Error> {
        Ok(Self { renderer: Renderer::new(device)? })
    }

    /// The device.
    pub fn device(&self) -> &Device {
        self.renderer.device()
    }

    /// Renders a frame of points.
    pub fn render(&mut self, points: &Points, frame: &Frame) -> Result<Rendered, Error> {
        let mut cloud = self.renderer.upload(points)?;
        self.renderer.render(&mut cloud, frame)
    }

    /// The image of points in the order that a method needs.
    pub fn arranged(&mut self, arranged: &Arranged, frame: &Frame) -> Result<Image, Error> {
        let mut cloud = self.renderer.upload(arranged)?;
        Ok(self.renderer.render(&mut cloud, frame)?.image)
    }

    /// The image of dots by a method, without list lengths.
    pub fn image(
        &mut self,
        dots: &[Dot],
        camera: Camera,
        size: [u32; 2],
        method: impl Into<Method>,
    ) -> Result<Image, Error> {
        Ok(self.render(&cloud(dots), &Frame::new(camera, size, method.into()))?.image)
    }

    /// The only pixel of the image of dots, which all lie on its ray.
    pub fn pixel(&mut self, dots: &[Dot], method: impl Into<Method>) -> Result<[f32; 4], Error> {
        Ok(self.image(dots, pixels([1, 1]), [1, 1], method)?.rgba[0])
    }

    /// Compares a pixel of this kind, and that of a naive formula, with what it should be.
    pub(super) fn compare(
        &mut self,
        dots: &[Dot],
        method: impl Into<Method>,
        naive: &[f32],
        wanted: &[f64],
        bound: f64,
    ) -> CaseResult {
        Ok(Finding::apart(&self.pixel(dots, method)?, naive, wanted, bound))
    }
}

/// Dots as a scene, in canonical order; normals and fields only if any dot has one.
pub fn cloud(dots: &[Dot]) -> Points {
    let normals: Vec<Vec3> = dots.iter().map(|dot| dot.normal).collect();
    let fields: Vec<f32> = dots.iter().map(|dot| dot.field).collect();
    order::canonical(Points {
        positions: dots.iter().map(|dot| dot.position).collect(),
        colors: dots.iter().map(|dot| dot.color).collect(),
        opacities: dots.iter().map(|dot| dot.opacity).collect(),
        radii: dots.iter().map(|dot| dot.radius).collect(),
        normals: normals.iter().any(|normal| *normal != Vec3::ZERO).then_some(normals),
        fields: if fields.iter().any(|field| *field != 0.0) { fields } else { Vec::new() },
        ..Points::default()
    })
}

/// A camera from a case's own constants, +Y up.
///
/// # Panics
/// Eye and target coincide, the view is vertical, or `projection`, `near` or `far` allow none.
pub fn looking(eye: DVec3, target: DVec3, projection: Projection, near: f64, far: f64) -> Camera {
    Camera::look_at(eye, target, DVec3::Y, projection, near, far).expect("a case's constants make a view")
}

/// A camera as [`looking`] makes it, with a field of view of so many degrees from top to bottom.
pub fn perspective(eye: DVec3, target: DVec3, degrees: f64, near: f64, far: f64) -> Camera {
    looking(eye, target, Projection::Perspective { fov_y: degrees.to_radians() }, near, far)
}

/// A camera that looks down −Z onto pixels of one world unit: x and −y are columns and rows from the image's corner.
pub fn pixels(size: [u32; 2]) -> Camera {
    let center = DVec3::new(f64::from(size[0]) / 2.0, -f64::from(size[1]) / 2.0, 0.0);
    let height = f64::from(size[1]);
    looking(center, center - DVec3::Z, Projection::Orthographic { height }, 0.5, 1e7)
}

/// The center of a pixel of [`pixels`] at a depth.
pub fn at(x: u32, y: u32, depth: f64) -> DVec3 {
    DVec3::new(f64::from(x) + 0.5, -(f64::from(y) + 0.5), -depth)
}

/// Bytes in which two lists differ.
pub fn bytes_between<T: bytemuck::NoUninit>(a: &[T], b: &[T]) -> f64 {
    let (a, b) = (bytemuck::cast_slice::<_, u8>(a), bytemuck::cast_slice::<_, u8>(b));
    (a.iter().zip(b).filter(|(a, b)| a != b).count() + a.len().abs_diff(b.len())) as f64
}

/// Bytes in which two images differ, depths included.
pub fn bytes_apart(a: &Image, b: &Image) -> f64 {
    bytes_between(&a.rgba, &b.rgba) + bytes_between(&a.depth, &b.depth)
}

/// The largest difference between components and what they should be; infinite for NaN.
pub fn apart(found: &[f32], wanted: &[f64]) -> f64 {
    let pairs = found.iter().zip(wanted);
    pairs
        .map(|(f, w)| (f64::from(*f) - w).abs())
        .fold(0.0, |most, d| if d.is_nan() { f64::INFINITY } else { d.max(most) })
}

/// A dot of one pixel on the ray of the only pixel.
pub fn dot(depth: f64, color: Vec3, opacity: f32) -> Dot {
    Dot { position: at(0, 0, depth), color, opacity, ..Dot::default() }
}

/// The fragments of dots on one ray, and their colors.
pub fn fragments(dots: &[Dot]) -> (Vec<Fragment>, Vec<DVec3>) {
    let fragment = |(dot, index): (&Dot, u32)| Fragment { z: -dot.position.z, index, alpha: f64::from(dot.opacity) };
    (dots.iter().zip(0..).map(fragment).collect(), dots.iter().map(|dot| dot.color.as_dvec3()).collect())
}

/// The exact pixel of dots from near to far.
pub fn composed(dots: &[Dot]) -> [f64; 4] {
    let (fragments, colors) = fragments(dots);
    let exact = composite(&fragments, &colors);
    exact.color.extend(exact.alpha).to_array()
}

/// The colors of points in float64.
pub fn colors_of(points: &Points) -> Vec<DVec3> {
    points.colors.iter().map(|color| color.as_dvec3()).collect()
}

/// A place for each number on a grid of 1/1024 in a cube of side 2.
pub fn in_cube(i: u32) -> DVec3 {
    let part = |factor: u32| f64::from((i.wrapping_mul(factor) >> 7) % 2048) / 1024.0 - 1.0;
    DVec3::new(part(2_654_435_761), part(2_246_822_519), part(3_266_489_917))
}

/// A color for each number, which few others have.
pub fn mixed(i: u32) -> Vec3 {
    Vec3::new((i % 7) as f32 / 6.0, (i % 5) as f32 / 4.0, (i % 3) as f32 / 2.0)
}

/// A color for each of some numbers, none like another.
pub fn graded(i: u32, count: u32) -> Vec3 {
    Vec3::new((i % 2) as f32, (i % 3) as f32 / 2.0, i as f32 / count as f32)
}

/// The mean of some values.
pub fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// The variance of which some values are a sample.
pub fn variance(values: &[f64]) -> f64 {
    let mean = mean(values);
    values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (values.len() as f64 - 1.0)
}

/// The largest difference between the pixels of an image and those that should be; infinite for NaN.
pub fn pixels_apart(found: &[[f32; 4]], wanted: &[[f64; 4]]) -> f64 {
    apart(found.as_flattened(), wanted.as_flattened())
}

/// Points at their positions in float32.
pub fn rounded(dots: &[Dot]) -> Vec<Dot> {
    dots.iter().map(|dot| Dot { position: dot.position.as_vec3().as_dvec3(), ..*dot }).collect()
}

/// Moves points and camera: the same picture, if no digit is lost.
pub fn shifted(dots: &[Dot], camera: Camera, by: DVec3) -> (Vec<Dot>, Camera) {
    let dots = dots.iter().map(|dot| Dot { position: dot.position + by, ..*dot }).collect();
    (dots, Camera { eye: camera.eye + by, ..camera })
}
