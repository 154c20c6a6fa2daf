//! Camera paths of our own, and cameras of nerfstudio, COLMAP and 3D Gaussian Splatting.

use std::fs;

use glam::DVec3;
use pellucid_core::camera::Projection;
use pellucid_core::camera::import::CameraSource;
use pellucid_core::camera::path::{Curve, Defaults, Pose};

/// The first byte: `t`, `b` a COLMAP model as text or binary files, whose two files are parted by the first line `--`;
/// else a JSON file.
pub fn path(input: &[u8]) {
    let [kind, content @ ..] = input else { return };
    let folder = tempfile::tempdir().expect("a temporary folder");
    let write = |name: &str, content: &[u8]| fs::write(folder.path().join(name), content).expect("room for a file");
    let parted = content.windows(4).position(|bytes| bytes == b"\n--\n");
    let [cameras, images] = parted.map_or([content, &[][..]], |at| [&content[..at + 1], &content[at + 4..]]);
    let read = match kind {
        b't' | b'b' => {
            let ending = if *kind == b't' { "txt" } else { "bin" };
            write(&format!("cameras.{ending}"), cameras);
            write(&format!("images.{ending}"), images);
            CameraSource::read(folder.path())
        }
        _ => {
            write("path.json", content);
            CameraSource::read(&folder.path().join("path.json"))
        }
    };
    let Ok(source) = read else { return };
    let path = source.path(source.size().unwrap_or([64, 48]));
    let defaults = Defaults { up: DVec3::Z, projection: Projection::Perspective { fov_y: 0.8 } };
    let Ok(curve) = Curve::new(&path, &defaults) else { return };
    curve.key_poses().iter().chain(&curve.frames(23)).for_each(assert_sound);
}

fn assert_sound(pose: &Pose) {
    let Pose { eye, right, up, forward, projection, .. } = *pose;
    assert!(eye.is_finite(), "{pose:?}");
    assert!(right.cross(forward).dot(up) < 1.0 + 1e-6 && right.cross(up).dot(-forward) > 1.0 - 1e-6, "{pose:?}");
    let (Projection::Perspective { fov_y: extent } | Projection::Orthographic { height: extent }) = projection;
    assert!(extent > 0.0 && extent.is_finite(), "{pose:?}");
}
