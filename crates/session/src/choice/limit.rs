//! The image that means over ensembles tend to, from the float64 reference.

use pellucid_core::image::Image;
use pellucid_engine::methods::Frame;
use pellucid_reference::shading::shade;
use pellucid_reference::{ReferencePicture, spbr};
use pellucid_scene::Method;
use pellucid_scene::prepare::Arranged;

use crate::area;

/// Returns the limit of the mean over ensembles as their number grows, in float64; `None` for other methods.
pub fn ensembles(arranged: &Arranged, frame: &Frame) -> Option<Image> {
    let (Arranged::Dealt(dealt), Method::Spbr(settings)) = (arranged, frame.method) else { return None };
    let colors = shade(&dealt.points, &frame.camera, &frame.shading, frame.color);
    let limit = |image: &Frame| {
        let view = pellucid_reference::View::new(&image.camera, image.size);
        spbr::limit(view, dealt, &colors, &settings.into())
    };
    Some(image_of(&area::mean_picture(frame, limit)))
}

/// Returns a picture of the reference as an image, rounded to float32.
pub fn image_of(picture: &ReferencePicture) -> Image {
    Image {
        width: picture.width,
        height: picture.height,
        rgba: picture.rgba.iter().map(|pixel| pixel.map(|value| value as f32)).collect(),
        depth: picture.depth.iter().map(|depth| *depth as f32).collect(),
        ..Image::default()
    }
}
