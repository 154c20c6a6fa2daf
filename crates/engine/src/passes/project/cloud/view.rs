//! The camera, as shaders read it.

use glam::{DVec3, Vec3};

use super::column::split;
use super::{DeviceCloud, Projecting};
use crate::camera::{Camera, Projection};
use crate::gpu::{Recorder, Slice};
use crate::gpu_struct;
use crate::scene::{DiscShape, GaussianSettings, Light};

gpu_struct! {
    /// The camera and the part of the image in work.
    pub struct View {
        right: [f32; 4],
        right_lo: [f32; 4],
        down: [f32; 4],
        down_lo: [f32; 4],
        forward: [f32; 4],
        forward_lo: [f32; 4],
        eye_hi: [f32; 4],
        eye_lo: [f32; 4],
        light: [f32; 4],
        material: [f32; 4],
        window: [u32; 4],
        size: [u32; 2],
        focal: [f32; 2],
        depth_range: [f32; 2],
        radius_limits: [f32; 2],
        orthographic: u32,
        opacity_factor: f32,
        threshold: f32,
        modulation: f32,
        small_area: u32,
        kernel: u32,
        order: u32,
        tilted: u32,
        gaussian: [f32; 4],
        sample: [f32; 4],
        shift: [f32; 2],
        padding: [f32; 2],
    }
}

impl DeviceCloud {
    /// Returns the view of the last [`Self::set_view`].
    pub fn view(&self) -> Slice<'_, View> {
        self.view.all()
    }

    /// Sets the camera and the rectangle of pixels that is rendered next; [`Self::record_view`] brings it to the
    /// device.
    pub fn set_view(&mut self, camera: &Camera, size: [u32; 2], window: [u32; 4], how: &Projecting) {
        let rows = |v: DVec3| {
            let (hi, lo) = split(v);
            (padded(hi), padded(lo))
        };
        let (mut eye_hi, mut eye_lo) = rows(camera.eye - self.origin);
        let depths = self.corners.map(|corner| camera.to_view(corner).z);
        let nearest = depths.into_iter().fold(f64::INFINITY, f64::min).max(0.0) as f32;
        eye_hi[3] = if how.relative_depth { nearest } else { 0.0 };
        eye_lo[3] = (camera.near - f64::from(eye_hi[3])) as f32;
        let (mut right, right_lo) = rows(camera.right);
        right[3] = how.shells.most as f32;
        let (mut down, down_lo) = rows(-camera.up);
        down[3] = how.shells.radius_px * how.places.columns();
        let (mut forward, forward_lo) = rows(camera.forward);
        forward[3] = how.gaussians.settings.stop;
        let (focal, focal_lo) = split(DVec3::splat(camera.focal_px(size[1])));
        let view = View {
            right,
            right_lo,
            down,
            down_lo,
            forward,
            forward_lo,
            eye_hi,
            eye_lo,
            light: light(camera, &how.shading.light),
            material: [how.shading.ambient, how.shading.diffuse, how.shading.specular, how.shading.shininess],
            window,
            size,
            focal: [focal.x, focal_lo.x],
            depth_range: [camera.near as f32, camera.far as f32],
            radius_limits: radius_limits(how),
            orthographic: u32::from(matches!(camera.projection, Projection::Orthographic { .. })),
            opacity_factor: how.opacity_factor,
            threshold: how.part.threshold(),
            modulation: how.part.modulation(),
            small_area: self.prefers.small_area,
            kernel: how.gaussians.settings.kernel as u32,
            order: how.gaussians.order as u32,
            tilted: u32::from(how.gaussians.discs == DiscShape::Oriented),
            gaussian: gaussian(&how.gaussians.settings, how.places.columns()),
            sample: [how.places.first[0], how.places.first[1], how.places.step, how.places.most],
            shift: camera.shift.as_vec2().to_array(),
            padding: [0.0; 2],
        };
        self.opacity_factor = how.opacity_factor;
        self.depth_origin = eye_hi[3];
        self.view_host = view;
    }

    /// Records that the view of the last [`Self::set_view`] holds from here on.
    pub fn record_view<'a>(&'a self, recorder: &mut Recorder<'a>) {
        recorder.update(self.view.all().cast(), bytemuck::cast_slice(&[self.view_host]));
    }
}

fn padded(v: Vec3) -> [f32; 4] {
    [v.x, v.y, v.z, 0.0]
}

/// The factor on radii, and the largest one in pixels; a factor below 0 means that all are as large as that.
fn radius_limits(how: &Projecting) -> [f32; 2] {
    let columns = how.places.columns();
    match how.pixel_radius {
        Some(radius) => [-1.0, radius.min(how.max_radius_px) * columns],
        None => [how.radius_factor, (how.max_radius_px * columns).min(f32::MAX)],
    }
}

/// Least and most opacity, dilation by the columns of a pixel, and whether it is taken back.
fn gaussian(settings: &GaussianSettings, columns: f32) -> [f32; 4] {
    let GaussianSettings { alpha_min, alpha_max, dilation, antialias, .. } = *settings;
    [alpha_min, alpha_max, dilation * columns * columns, if antialias { 1.0 } else { 0.0 }]
}

/// Direction to the light (w = 0), or its place relative to the eye (w = 1), in camera axes.
fn light(camera: &Camera, light: &Light) -> [f32; 4] {
    let axes = |v: DVec3| DVec3::new(v.dot(camera.right), -v.dot(camera.up), v.dot(camera.forward));
    let (v, w) = match *light {
        Light::Direction(direction) => (axes(-direction.normalize_or_zero()), 0.0),
        Light::Position(position) => (axes(position - camera.eye), 1.0),
        Light::Headlight => match camera.projection {
            Projection::Perspective { .. } => (DVec3::ZERO, 1.0),
            Projection::Orthographic { .. } => (DVec3::NEG_Z, 0.0),
        },
    };
    [v.x as f32, v.y as f32, v.z as f32, w]
}
