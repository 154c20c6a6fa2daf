//! The keys of a scene that put a picture into the world.

use glam::DVec3;
use image::{ExtendedColorType, save_buffer};
use pellucid_core::cloud::Cloud;
use pellucid_core::progress::Progress;
use pellucid_io::photo::{Heights, Photo};
use pellucid_io::{Hints, load, load_with};
use pellucid_scene::{self as scene, Overrides, Scene};

/// Two by two pixels: red, half-transparent mid gray; nothing, white.
const FOUR: [u8; 16] = [255, 0, 0, 255, 128, 128, 128, 51, 9, 9, 9, 0, 255, 255, 255, 255];

#[test]
fn keys_of_the_scene() {
    let folder = tempfile::tempdir().unwrap();
    save_buffer(folder.path().join("photo.png"), &FOUR, 2, 2, ExtendedColorType::Rgba8).unwrap();
    // A ramp of 16 bits along x: 1/64 per pixel, from 0 to 63/64.
    let ramp: Vec<u16> = (0..64 * 64).map(|pixel| pixel % 64 * 1024).collect();
    let ramp = bytemuck::cast_slice(&ramp);
    save_buffer(folder.path().join("ramp.png"), ramp, 64, 64, ExtendedColorType::L16).unwrap();
    let origin = folder.path().join("scene.toml");
    let read = |keys: &str| Scene::from_toml(&format!("[[cloud]]\npath = \"photo.png\"\n{keys}\n"), &origin);
    let keys =
        "photo = { origin = [1, 2, 3], right = [1, 0, 0], up = [0, 0, 2], heights = \"ramp.png\", height_scale = 0.1 }";
    let scene = read(&format!("{keys}\ntranslate = [0, 0, 10]\nopacity = 0.5")).unwrap();
    let wanted = Photo {
        origin: Some(DVec3::new(1.0, 2.0, 3.0)),
        edges: Some([DVec3::X, DVec3::Z * 2.0]),
        heights: Some(Heights { path: folder.path().join("ramp.png"), scale: 0.1 }),
    };
    assert_eq!((&scene.clouds[0].photo, scene.warnings.len()), (&Some(wanted), 0));
    let progress = Progress::hidden();
    let clouds = scene::load_clouds(&scene, &progress).unwrap();
    let points = scene::assemble(&scene, clouds, false, &progress).unwrap();
    let bounds = points.bounds().unwrap();
    assert!(bounds.min.z == 13.5 && bounds.max.z == 14.5 && points.opacities.contains(&0.1), "{bounds:?}");

    let refused = |keys: &str, says: &[&str]| {
        let message = read(keys).expect_err(keys).to_string();
        assert!(says.iter().all(|words| message.contains(words)) && message.contains("scene.toml:3:"), "{message}");
    };
    refused("photo = { right = [1, 0, 0] }", &["`photo.right` needs `photo.up`"]);
    refused("photo = { right = [1, 0, 0], up = [2, 0, 0] }", &["photo.up", "span a plane"]);
    refused("photo = { right = [0, 0, 0], up = [2, 0, 0] }", &["photo.right", "direction"]);
    refused("photo = { heights = \"ramp.png\" }", &["needs `photo.height_scale`"]);
    refused("photo = { hights = \"ramp.png\" }", &["unknown key", "did you mean `heights`"]);
    refused("photo = \"here\"", &["must be a table"]);
    assert!(read("photo = { height_scale = 1 }").unwrap().warnings[0].contains("no effect"));

    // By options too; and a cloud that is no picture has no such place.
    let mut overrides = Overrides::default();
    overrides.set_pair("cloud.0.photo.origin=[5, 5, 5]").unwrap();
    let scene = Scene::from_clouds(["photo.png"], &overrides).unwrap();
    assert_eq!(scene.clouds[0].photo.as_ref().unwrap().origin, Some(DVec3::splat(5.0)));
    let ply = folder.path().join("cloud.ply");
    let cloud = Cloud { positions: vec![DVec3::ZERO], ..Cloud::default() };
    pellucid_io::ply::write(&ply, &cloud).unwrap();
    assert!(load(&ply, &progress).is_ok());
    let photo = Photo::default();
    let hints = Hints { photo: Some(&photo), ..Hints::default() };
    let message = load_with(&ply, hints, &progress).unwrap_err().to_string();
    assert!(message.contains("cloud.ply") && message.contains("this is a point cloud"), "{message}");
}
