//! Cameras in the metadata of pictures.

use std::path::{Path, PathBuf};

use glam::{DVec3, Vec3};
use pellucid_core::camera::{Projection, StatedCamera};
use pellucid_core::color::ColorSpace;
use pellucid_core::image::Image;
use pellucid_io::output::{CAMERA_TAG, Inputs, WriteOptions, write_image};
use pellucid_scene::{Error, Overrides, PictureCamera, Scene};

const WHOLE: &str =
    "eye = [1.5, 2.0, 3.0]\ntarget = [0.0, 0.0, 0.0]\nup = [0.0, 0.0, 1.0]\nfov_y = 45.0\nnear = 0.5\nfar = 9.0\n";

/// Writes a picture of 3 × 2 pixels with these metadata.
fn picture(path: &Path, metadata: Vec<(String, String)>) -> PathBuf {
    let image =
        Image { width: 3, height: 2, rgba: vec![[0.0; 4]; 6], depth: vec![f32::INFINITY; 6], ..Image::default() };
    let options = WriteOptions {
        background: Vec3::ZERO,
        color: ColorSpace::Linear,
        transparent: false,
        metadata,
        camera: None,
        inputs: Inputs::default(),
    };
    write_image(path, &image, &options).unwrap();
    path.to_owned()
}

fn with_text(path: &Path, text: &str) -> PathBuf {
    picture(path, vec![(CAMERA_TAG.to_owned(), text.to_owned())])
}

#[test]
fn the_camera_of_a_picture_is_read_with_its_size() {
    let folder = tempfile::tempdir().unwrap();
    let place = DVec3::new(512_345.678_901, 5_403_210.1, 0.3);
    for (name, projection) in [
        ("a.png", Projection::Perspective { fov_y: 33.3f64.to_radians() }),
        ("b.exr", Projection::Orthographic { height: 0.1 + 0.2 }),
    ] {
        let up = DVec3::new(0.1, -1e-9, 1.0 / 3.0);
        let camera = StatedCamera::look_at(place + DVec3::ONE, place, up, projection, 1e-5, 1e17).unwrap();
        let found = PictureCamera::read(&with_text(&folder.path().join(name), &camera.to_toml())).unwrap();
        assert_eq!(found.size, [3, 2]);
        let settings = found.camera;
        assert_eq!((settings.eye, settings.target), (Some(camera.eye), Some(place)));
        assert_eq!((settings.up, settings.fov_y, settings.height), (Some(up), camera.fov_y(), camera.height()));
        assert_eq!((settings.near, settings.far), (Some(1e-5), Some(1e17)));
        // Laid over a scene it replaces the whole camera.
        let mut overrides = Overrides::default();
        overrides.set("--like", "camera", &found.as_value()).unwrap();
        let text = "[camera]\northo = true\nheight = 9\nframe = \"all\"\nfar = 3\n[[cloud]]\npath = \"a.ply\"\n";
        let document = pellucid_scene::Document::from_toml(text, Path::new("s.toml"), &overrides).unwrap();
        assert_eq!(document.scene().unwrap().camera, settings);
        assert_ne!(Scene::from_toml(text, Path::new("s.toml")).unwrap().camera, settings);
    }
}

#[test]
fn pictures_without_a_whole_camera_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let refused = |path: &Path| {
        let error = PictureCamera::read(path).unwrap_err();
        let text = error.to_string();
        assert!(text.contains(&path.display().to_string()), "{text}");
        (error.exit_status(), text)
    };
    for name in ["none.png", "none.exr"] {
        let (status, text) = refused(&picture(&at(name), Vec::new()));
        assert!(status == 2 && text.contains("the picture has none; give a PNG or EXR that `render` wrote"), "{text}");
    }
    let long = format!("{WHOLE}#{}", "x".repeat(5000));
    let replaced = |from: &str, to: &str| WHOLE.replace(from, to);
    for (text, wanted) in [
        (String::new(), "lacks eye"),
        (replaced("near = 0.5\n", ""), "lacks near"),
        (replaced("fov_y = 45.0\n", ""), "lacks fov_y or height"),
        (replaced("up = [0.0, 0.0, 1.0]\n", ""), "lacks up"),
        (replaced("near = 0.5", "near = 9.5"), "must lie below"),
        (replaced("near = 0.5", "near = nan"), "`near` must be a number"),
        (replaced("far = 9.0", "far = inf"), "`far` must be a number"),
        (replaced("[1.5, 2.0, 3.0]", "[nan, 2.0, 3.0]"), "`eye` must be a number"),
        (replaced("[1.5, 2.0, 3.0]", "[1e300, 2.0, 3.0]"), "`eye` must be a number"),
        (replaced("[1.5, 2.0, 3.0]", "[1.5, 2.0]"), "must be an array of 3 numbers"),
        (replaced("[1.5, 2.0, 3.0]", "[0, 0, 0]"), "are the same point"),
        (replaced("[0.0, 0.0, 1.0]", "[1.5, 2.0, 3.0]"), "points along the view"),
        (replaced("fov_y = 45.0", "fov_y = 180.0"), "`fov_y` must be a number"),
        (replaced("fov_y = 45.0", "fov_y = 45.0\nheight = 3.0"), "keep one"),
        (replaced("fov_y", "lens"), "unknown key `lens`"),
        (replaced("= 45.0", "= "), ":4:"),
        (replaced("eye = ", "\0"), ":1:"),
        (format!("eye = {}", "[".repeat(4000)), ":1:"),
        (long, "too long"),
    ] {
        for name in ["damaged.png", "damaged.exr"] {
            let (status, found) = refused(&with_text(&at(name), &text));
            assert!(status == 2 && found.contains(wanted) && found.contains(CAMERA_TAG), "{text:?}: {found}");
        }
    }
    std::fs::write(at("text.png"), "no picture").unwrap();
    std::fs::write(at("text.exr"), "no picture").unwrap();
    std::fs::write(at("scan.ply"), "ply\n").unwrap();
    assert_eq!(["text.png", "text.exr", "missing.png"].map(|name| refused(&at(name)).0), [1; 3]);
    let (status, text) = refused(&at("scan.ply"));
    assert!(status == 2 && text.contains(".png"), "{text}");
    assert!(matches!(PictureCamera::read(&at("missing.png")), Err(Error::Picture(_))));
}
