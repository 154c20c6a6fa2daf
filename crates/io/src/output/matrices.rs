//! The camera of an EXR as OpenEXR's standard attributes have it.

use glam::{DMat4, DVec4};

use pellucid_core::camera::{Camera, Projection};

/// Names of the attributes, in the order of [`matrices`].
pub(super) const NAMES: [&str; 2] = ["worldToCamera", "worldToNDC"];

/// Returns `worldToCamera` and `worldToNDC` of a picture, row by row, for points as rows: p′ = p · M.
///
/// OpenEXR defines them in `ImfStandardAttributes.h`: camera space has x to the right, y up and z along the view, and
/// is left-handed. NDC is (0, 0) in the upper left corner of the picture and (1, 1) in the lower right one. Its z,
/// which OpenEXR leaves open, is 0 at the nearest depth and 1 at the farthest. `None` of a camera that float32 can't
/// hold.
pub(super) fn matrices(camera: &Camera, size: [u32; 2]) -> Option<[[f32; 16]; 2]> {
    let to_camera = to_camera(camera);
    let both = [to_camera, to_ndc(camera, size) * to_camera];
    // The columns of a matrix for points as columns are the rows of that for points as rows.
    let rows = both.map(|matrix| matrix.to_cols_array().map(|value| value as f32));
    rows.as_flattened().iter().all(|value| value.is_finite()).then_some(rows)
}

/// Matrix from the world to the camera's axes.
fn to_camera(&Camera { eye, right, up, forward, .. }: &Camera) -> DMat4 {
    let row = |axis: glam::DVec3| axis.extend(-eye.dot(axis));
    DMat4::from_cols(row(right), row(up), row(forward), DVec4::W).transpose()
}

/// Matrix from the camera's axes to NDC.
fn to_ndc(camera: &Camera, [width, height]: [u32; 2]) -> DMat4 {
    let focal = camera.focal_px(height);
    let (x, y) = (focal / f64::from(width), -focal / f64::from(height));
    let depth = 1.0 / (camera.far - camera.near);
    let rows = match camera.projection {
        Projection::Perspective { .. } => [
            DVec4::new(x, 0.0, 0.5, 0.0),
            DVec4::new(0.0, y, 0.5, 0.0),
            DVec4::new(0.0, 0.0, camera.far * depth, -camera.far * camera.near * depth),
            DVec4::Z,
        ],
        Projection::Orthographic { .. } => [
            DVec4::new(x, 0.0, 0.0, 0.5),
            DVec4::new(0.0, y, 0.0, 0.5),
            DVec4::new(0.0, 0.0, depth, -camera.near * depth),
            DVec4::W,
        ],
    };
    let [a, b, c, d] = rows;
    DMat4::from_cols(a, b, c, d).transpose()
}
