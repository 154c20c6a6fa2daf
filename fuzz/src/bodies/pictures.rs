//! Pictures that stand for clouds, and those that `compare` reads.

use glam::DVec3;
use pellucid_core::cloud::Bounds;
use pellucid_core::metrics;
use pellucid_core::progress::Progress;
use pellucid_io::output::read_image;
use pellucid_io::photo::{Heights, Photo};
use pellucid_io::{self as io, Hints};
use pellucid_scene::{Overrides, PictureCamera, camera_at};

use super::{cloud::check, with_file};

/// Pixels of a picture that is also its own height map, or is compared with another.
const MOST_PIXELS: usize = 1 << 12;

/// A picture as a cloud, then bent by itself as height map.
pub fn photo(input: &[u8]) {
    with_file("input.png", input, |path| {
        let progress = Progress::hidden();
        let Ok(cloud) = io::load(path, &progress) else { return };
        check(&cloud);
        if cloud.len() <= MOST_PIXELS {
            let heights = Some(Heights { path: path.to_owned(), scale: -0.5 });
            let photo = Photo { heights, ..Photo::default() };
            let hints = Hints { photo: Some(&photo), ..Hints::default() };
            check(&io::load_with(path, hints, &progress).expect("the same picture"));
        }
    });
}

/// A picture as `compare` reads it, by its first bytes a PNG or an EXR, compared with itself mirrored; and its camera
/// as `--like` reads it.
pub fn compare(input: &[u8]) {
    let name = if input.starts_with(b"\x89PNG") { "input.png" } else { "input.exr" };
    let (picture, camera) = with_file(name, input, |path| (read_image(path), PictureCamera::read(path)));
    if let Ok(found) = camera {
        let unit = Bounds { min: DVec3::ZERO, max: DVec3::ONE };
        assert!(camera_at(&found.camera, &unit, 0.0).is_some(), "a camera: {found:?}");
        Overrides::default().set("--like", "camera", &found.as_value()).expect("a value of TOML");
    }
    let Ok(picture) = picture else { return };
    assert_eq!(picture.pixels.len(), picture.width as usize * picture.height as usize);
    if picture.pixels.len() <= MOST_PIXELS {
        let mut other = picture.clone();
        other.pixels.reverse();
        let comparison = metrics::compare(&picture, &other).expect("pictures of one size");
        assert!(comparison.rmse >= 0.0, "an error of {}", comparison.rmse);
        metrics::difference_picture(&picture.pixels, &other.pixels, 10.0);
    }
}
