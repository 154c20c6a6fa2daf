//! Gaussian splats in float32: as Kerbl et al. 2023 project them, and through the inverse of their covariance.

use glam::{Mat2, Mat3, Vec2, Vec3};

use crate::check::gaussians::splats::{Splat, SplatView};
use pellucid_core::camera::Projection;
use pellucid_scene::Order;

/// A Gaussian in a pixel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Seen {
    /// Opacity in the pixel; 0 if the Gaussian has no fragment there.
    pub alpha: f32,
    /// Depth in the pixel, if that is known.
    pub depth: Option<f32>,
}

const NOTHING: Seen = Seen { alpha: 0.0, depth: Some(f32::INFINITY) };

/// Parameters in which published implementations differ; the defaults follow Kerbl et al.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Formula {
    /// A center that is as near as that is not drawn.
    pub nearest: f32,
    /// The bound of the slopes in J, over those of the image's borders.
    pub clamp: f32,
    /// Standard deviations at which a Gaussian ends; `None`: its least opacity ends it.
    pub reach: Option<f32>,
    /// J of a perspective, whatever the camera is.
    pub perspective: bool,
}

impl Default for Formula {
    fn default() -> Self {
        Self { nearest: 0.0, clamp: 1.3, reach: None, perspective: false }
    }
}

/// A camera in float32.
struct Lens {
    /// Rotation from world axes to right, up and away.
    turn: Mat3,
    eye: Vec3,
    focal: f32,
    orthographic: bool,
}

impl Lens {
    fn new(view: &SplatView) -> Self {
        let camera = &view.camera;
        Self {
            turn: Mat3::from_cols(camera.right.as_vec3(), camera.up.as_vec3(), camera.forward.as_vec3()).transpose(),
            eye: camera.eye.as_vec3(),
            focal: camera.focal_px(view.size[1]) as f32,
            orthographic: matches!(camera.projection, Projection::Orthographic { .. }),
        }
    }

    fn center(&self, splat: &Splat) -> Vec3 {
        self.turn * (splat.position.as_vec3() - self.eye)
    }

    /// Pixels of a unit at a depth.
    fn scale(&self, z: f32) -> f32 {
        if self.orthographic { self.focal } else { self.focal / z }
    }
}

fn middle(view: &SplatView) -> Vec2 {
    0.5 * Vec2::new(view.size[0] as f32, view.size[1] as f32)
}

fn opacity_of(splat: &Splat, rho2: f32, view: &SplatView, formula: &Formula) -> f32 {
    let alpha = (splat.opacity * (-0.5 * rho2).exp()).min(view.settings.alpha_max);
    let ends = match formula.reach {
        Some(reach) => rho2 > reach * reach,
        None => alpha < view.settings.alpha_min,
    };
    if ends { 0.0 } else { alpha }
}

/// Evaluates the kernel `ewa`, with a determinant that is a difference of products. Depths are the center's, or not
/// known.
pub fn projected(splat: &Splat, view: &SplatView, formula: &Formula) -> Vec<Seen> {
    let lens = Lens::new(view);
    let t = lens.center(splat);
    if t.z <= formula.nearest {
        return view.pixels().map(|_| NOTHING).collect();
    }
    let scale = lens.scale(t.z);
    let most = formula.clamp * middle(view) / lens.focal;
    let flat = lens.orthographic && !formula.perspective;
    let slope = if flat { Vec2::ZERO } else { (t.truncate() / t.z).clamp(-most, most) };
    let jacobian = Mat3::from_cols(
        Vec3::new(scale, 0.0, 0.0),
        Vec3::new(0.0, -scale, 0.0),
        Vec3::new(-scale * slope.x, scale * slope.y, 0.0),
    );
    let covariance = splat.axes() * splat.axes().transpose();
    let through = jacobian * lens.turn;
    let shadow = through * covariance * through.transpose();
    let dilation = view.settings.dilation;
    let (a, b, c) = (shadow.x_axis.x + dilation, shadow.x_axis.y, shadow.y_axis.y + dilation);
    let inverse = Mat2::from_cols(Vec2::new(c, -b), Vec2::new(-b, a)) * (1.0 / (a * c - b * b));
    let center = middle(view) + scale * Vec2::new(t.x, -t.y);
    let depth = (view.settings.order != Some(Order::Pixel)).then_some(t.z);
    let seen = |[x, y]: [u32; 2]| {
        let d = Vec2::new(x as f32 + 0.5, y as f32 + 0.5) - center;
        let alpha = opacity_of(splat, d.dot(inverse * d), view, formula);
        if alpha > 0.0 { Seen { alpha, depth } } else { NOTHING }
    };
    view.pixels().map(seen).collect()
}

/// Evaluates the kernel `ray`, with the inverse of the covariance: A = dᵀΣ⁻¹d, B = dᵀΣ⁻¹(μ − e), C = (μ − e)ᵀΣ⁻¹(μ −
/// e), ρ² = C − B²/A at the depth B/A.
pub fn along_rays(splat: &Splat, view: &SplatView) -> Vec<Seen> {
    let lens = Lens::new(view);
    let t = lens.center(splat);
    let axes = lens.turn * splat.axes();
    let inverse = (axes * axes.transpose()).inverse();
    let order = view.settings.order;
    let seen = |[x, y]: [u32; 2]| {
        let place = (Vec2::new(x as f32 + 0.5, y as f32 + 0.5) - middle(view)) * Vec2::new(1.0, -1.0) / lens.focal;
        let (direction, from) =
            if lens.orthographic { (Vec3::Z, t - place.extend(0.0)) } else { (place.extend(1.0), t) };
        let a = direction.dot(inverse * direction);
        let b = direction.dot(inverse * from);
        let alpha = opacity_of(splat, from.dot(inverse * from) - b * b / a, view, &Formula::default());
        let depth = if order == Some(Order::Pixel) { b / a } else { t.z };
        // An opacity that is not a number is no fragment.
        if alpha > 0.0 { Seen { alpha, depth: Some(depth) } } else { NOTHING }
    };
    view.pixels().map(seen).collect()
}
