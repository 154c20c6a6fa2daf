//! Colors of points as the camera sees them: the local illumination model, then the space that blending runs in.
//! Gaussians have their harmonics instead, and no light.

use glam::DVec3;

use super::gaussians::harmonics;
use pellucid_core::camera::{Camera, Projection};
use pellucid_core::color::encode_srgb_f64;
use pellucid_core::points::Points;
use pellucid_scene::{ColorSpace, Formula, Light, Shading};

/// Returns a color for each point: shaded on linear color, then encoded if blending runs on encoded values.
pub fn shade(points: &Points, camera: &Camera, shading: &Shading, space: ColorSpace) -> Vec<DVec3> {
    shade_lit(points, camera, shading, space, &[])
}

/// [`shade`] where the share m of the light that reaches each point is known ([`super::shadows::shares`]); 1 where
/// `lit` ends.
pub fn shade_lit(points: &Points, camera: &Camera, shading: &Shading, space: ColorSpace, lit: &[f64]) -> Vec<DVec3> {
    let shaded = points.colors.iter().enumerate().map(|(i, color)| {
        if let Some(color) = harmonics::color(points, i, camera, space) {
            return color;
        }
        let normal = points.normals.as_ref().map_or(DVec3::ZERO, |normals| normals[i].as_dvec3());
        let m = lit.get(i).copied().unwrap_or(1.0);
        let shaded = shade_point(camera, shading, points.positions[i], normal, color.as_dvec3(), m);
        match space {
            ColorSpace::Linear => shaded,
            ColorSpace::Encoded => shaded.map(encode_srgb_f64),
        }
    });
    shaded.collect()
}

/// Returns the unit vector toward the viewer; zero in the eye.
pub(super) fn to_viewer(camera: &Camera, position: DVec3) -> DVec3 {
    match camera.projection {
        Projection::Perspective { .. } => (camera.eye - position).normalize_or_zero(),
        Projection::Orthographic { .. } => -camera.forward,
    }
}

/// Lambert: c·(ambient + m·diffuse·max(0, n·l)). Phong adds the white highlight m·specular·max(0, r·v)^shininess, with
/// r = 2(n·l)n − l, on the lit side (n·l > 0). The normal is turned toward the viewer first. Without a normal the light
/// counts as coming along it, scaled to the brightness of the unlit color: in full light the color is unchanged.
fn shade_point(camera: &Camera, shading: &Shading, position: DVec3, normal: DVec3, color: DVec3, m: f64) -> DVec3 {
    if shading.model.formula() == Formula::None {
        return color;
    }
    let (ambient, diffuse) = (f64::from(shading.ambient), f64::from(shading.diffuse));
    let Some(normal) = normal.try_normalize() else {
        let full = ambient + diffuse;
        return if full > 0.0 { color * (ambient + m * diffuse) / full } else { color };
    };
    let to_viewer = to_viewer(camera, position);
    let to_light = match shading.light {
        Light::Headlight => to_viewer,
        Light::Direction(travels) => -travels.normalize_or_zero(),
        Light::Position(light) => (light - position).normalize_or_zero(),
    };
    let normal = if normal.dot(to_viewer) < 0.0 { -normal } else { normal };
    let cos_light = normal.dot(to_light);
    let lambert = color * (ambient + m * diffuse * cos_light.max(0.0));
    match shading.model.formula() {
        Formula::None | Formula::Lambert => lambert,
        Formula::Phong if cos_light > 0.0 => {
            let reflected = 2.0 * cos_light * normal - to_light;
            let highlight = reflected.dot(to_viewer).max(0.0).powf(f64::from(shading.shininess));
            lambert + DVec3::splat(m * f64::from(shading.specular) * highlight)
        }
        Formula::Phong => lambert,
    }
}
