//! The stage of the cases: a renderer, small clouds, cameras that make positions on the screen exact.

use glam::{DVec3, Vec3};

use pellucid_engine::camera::{Camera, Projection};
use pellucid_engine::gpu::Device;
use pellucid_engine::image::Image;
use pellucid_engine::methods::{Error, Frame, Rendered, Renderer};
use pellucid_engine::points::Points;
use pellucid_engine::prepare::order;
use pellucid_engine::reference::abuffer::{Fragment, composite};
use pellucid_engine::scene::Method;

/// Half a unit in the last place, relative: the largest error of a rounding to float32.
pub const HALF_ULP: f64 = f32::EPSILON as f64 / 2.0;

/// A device with a renderer.
pub struct Stage {
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

impl Stage {
    pub(super) fn new(device: &Device) -> Result<Self, Error> {
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

    /// The image of dots by a method, without list lengths.
    pub fn image(
        &mut self,
        dots: &[Dot],
        camera: Camera,
        size: [u32; 2],
        method: impl Into<Method>,
    ) -> Result<Image, Error> {
        Ok(self.render(&cloud(dots), &frame(camera, size, method.into()))?.image)
    }

    /// The only pixel of the image of dots, which all lie on its ray.
    pub fn pixel(&mut self, dots: &[Dot], method: impl Into<Method>) -> Result<[f32; 4], Error> {
        Ok(self.image(dots, pixels([1, 1]), [1, 1], method)?.rgba[0])
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

/// A frame without shading or budget, in linear color.
pub fn frame(camera: Camera, size: [u32; 2], method: Method) -> Frame {
    Frame::new(camera, size, method)
}

/// Bytes in which two images differ, depths included.
pub fn bytes_apart(a: &Image, b: &Image) -> f64 {
    let bytes = |image: &Image| -> Vec<u8> {
        [bytemuck::cast_slice::<_, u8>(&image.rgba), bytemuck::cast_slice(&image.depth)].concat()
    };
    let (a, b) = (bytes(a), bytes(b));
    let apart = a.iter().zip(&b).filter(|(a, b)| a != b).count() + a.len().abs_diff(b.len());
    apart as f64
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

/// The exact pixel of dots from near to far.
pub fn composed(dots: &[Dot]) -> [f64; 4] {
    let fragment =
        |(i, dot): (usize, &Dot)| Fragment { z: -dot.position.z, index: i as u32, alpha: f64::from(dot.opacity) };
    let fragments: Vec<Fragment> = dots.iter().enumerate().map(fragment).collect();
    let colors: Vec<DVec3> = dots.iter().map(|dot| dot.color.as_dvec3()).collect();
    let exact = composite(&fragments, &colors);
    [exact.color.x, exact.color.y, exact.color.z, exact.alpha]
}

/// The largest difference between the pixels of an image and those that should be; infinite for NaN.
pub fn pixels_apart(found: &[[f32; 4]], wanted: &[[f64; 4]]) -> f64 {
    apart(found.as_flattened(), wanted.as_flattened())
}

/// Moves points and camera: the same picture, if no digit is lost.
pub fn shifted(dots: &[Dot], camera: Camera, by: DVec3) -> (Vec<Dot>, Camera) {
    let dots = dots.iter().map(|dot| Dot { position: dot.position + by, ..*dot }).collect();
    (dots, Camera { eye: camera.eye + by, ..camera })
}
