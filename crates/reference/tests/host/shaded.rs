//! Local illumination.

use super::*;

const SHADING: Shading = Shading {
    model: ShadingModel::Lambert,
    ambient: 0.25,
    diffuse: 0.5,
    specular: 1.0,
    shininess: 2.0,
    light: Light::Headlight,
    edl: Edl { edl: false, edl_strength: 1.0, edl_radius: 1.4 },
};
/// Normals are stored in float32.
const FROM_F32: f64 = 1e-6;
/// Position of the point of most cases.
const AHEAD: DVec3 = DVec3::new(0.0, 0.0, -2.0);

/// The shaded color of one point of linear color (1, 0.5, 0).
fn color(camera: &Camera, position: DVec3, normal: DVec3, shading: Shading, space: ColorSpace) -> DVec3 {
    let points = Points {
        positions: vec![position],
        colors: vec![Vec3::new(1.0, 0.5, 0.0)],
        opacities: vec![1.0],
        radii: vec![1.0],
        normals: Some(vec![normal.as_vec3()]),
        ..Points::default()
    };
    shading::shade(&points, camera, &shading, space)[0]
}

fn linear(normal: DVec3, shading: Shading) -> DVec3 {
    color(&orthographic(), AHEAD, normal, shading, ColorSpace::Linear)
}

#[test]
fn lambert_with_a_headlight_is_two_sided() {
    let red = |normal| linear(normal, SHADING).x;
    assert_close(red(DVec3::Z), 0.75, FROM_F32);
    assert_close(red(-DVec3::Z), 0.75, FROM_F32);
    assert_close(red(tilted(60.0)), 0.5, FROM_F32);
    assert_close(red(DVec3::X), 0.25, FROM_F32);
    assert_close(linear(DVec3::Z, SHADING).y, 0.375, FROM_F32);
}

#[test]
fn headlight_sits_at_the_eye_in_perspective_only() {
    // 45° off the axis: the light comes along the diagonal, or along the axis.
    let position = DVec3::new(3.0, 0.0, -3.0);
    let red = |camera: &Camera| color(camera, position, DVec3::Z, SHADING, ColorSpace::Linear).x;
    assert_close(red(&perspective()), 0.25 + 0.5 * 0.5f64.sqrt(), FROM_F32);
    assert_close(red(&orthographic()), 0.75, FROM_F32);
}

#[test]
fn directions_and_positions_of_the_light() {
    let lit = |light| linear(tilted(30.0), Shading { light, ..SHADING }).x;
    // The light travels down the viewing axis, 30° from the normal; then the other way, from behind the surface.
    assert_close(lit(Light::Direction(-7.0 * DVec3::Z)), 0.25 + 0.5 * 0.75f64.sqrt(), FROM_F32);
    assert_close(lit(Light::Direction(DVec3::Z)), 0.25, FROM_F32);
    // To the right of the point at its depth: 60° from the normal.
    assert_close(lit(Light::Position(DVec3::new(9.0, 0.0, -2.0))), 0.5, FROM_F32);
    // At the point itself there is no direction.
    assert_close(lit(Light::Position(AHEAD)), 0.25, FROM_F32);
}

#[test]
fn phong_adds_a_white_highlight() {
    let phong = Shading { model: ShadingModel::Phong, ..SHADING };
    // 30° between normal and light: the reflection is 60° from the viewer, cos² = 1/4.
    let lambert = 0.25 + 0.5 * 0.75f64.sqrt();
    let want = DVec3::new(lambert + 0.25, 0.5 * lambert + 0.25, 0.25);
    assert!((linear(tilted(30.0), phong) - want).length() < FROM_F32);
    // 60°: the reflection points away from the viewer.
    assert!((linear(tilted(60.0), phong) - DVec3::new(0.5, 0.25, 0.0)).length() < FROM_F32);
    // Light from 95° off the normal is on the other side, though the reflection would be 15° from the viewer.
    let behind = Shading { light: Light::Direction(-tilted(175.0)), ..phong };
    assert_eq!(linear(tilted(80.0), behind).z, 0.0);
}

#[test]
fn without_a_normal_or_a_model_the_color_stays() {
    assert_eq!(linear(DVec3::ZERO, SHADING).x, 1.0);
    assert_eq!(linear(DVec3::Z, Shading { model: ShadingModel::None, ..SHADING }).x, 1.0);
}

#[test]
fn encoded_after_shading() {
    let half = Shading { ambient: 0.5, ..SHADING };
    let got = color(&orthographic(), AHEAD, DVec3::X, half, ColorSpace::Encoded);
    // Linear 0.5, 0.25, 0: sRGB 0.735357, 0.537099, 0.
    assert!((got - DVec3::new(0.735_357, 0.537_099, 0.0)).length() < 1e-6);
}
