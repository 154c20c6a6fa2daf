//! Rendered frame.

use std::path::Path;

use pellucid_core::color::encode_srgb;
use pellucid_core::image::Image;
use pellucid_io::output::{WriteOptions, linear, png_bytes, to_byte, write_image};

use crate::error::of_engine;
use crate::{Error, Profile, Result};

/// Picture: linear color, opacity and depth of each pixel, row by row from the top, and the frame's profile.
pub struct Picture {
    pub(crate) image: Image,
    pub(crate) options: WriteOptions,
    pub(crate) method: &'static str,
    pub(crate) reason: String,
    pub(crate) profile: Profile,
}

impl Picture {
    /// Returns the name of the method.
    pub fn method(&self) -> &'static str {
        self.method
    }

    /// Returns the reason for the method.
    pub fn reason(&self) -> &str {
        &self.reason
    }

    /// Returns keys and values that files of the picture hold: settings, method, device, version, and whatever was
    /// decided, such as the opacity that was found.
    pub fn metadata(&self) -> &[(String, String)] {
        &self.options.metadata
    }

    /// Returns the width in pixels.
    pub fn width(&self) -> u32 {
        self.image.width
    }

    /// Returns the height in pixels.
    pub fn height(&self) -> u32 {
        self.image.height
    }

    /// Returns R, G, B, multiplied by opacity, and opacity A of each pixel, without the background. The values are in
    /// linear light, unless the scene sets `image.color = "encoded"`.
    pub fn pixels(&self) -> &[[f32; 4]] {
        &self.image.rgba
    }

    /// Returns the depth of the nearest fragment of each pixel along the view, in world units; infinity for empty
    /// pixels.
    pub fn depth(&self) -> &[f32] {
        &self.image.depth
    }

    /// Returns the depth of each pixel at which half of the light or less is left, in world units along the view;
    /// infinity where opacity is less than 1/2. `None` unless [`depth_channels`](crate::FrameBuilder::depth_channels)
    /// were requested and the method has them.
    pub fn median_depth(&self) -> Option<&[f32]> {
        self.image.depth_median.as_deref()
    }

    /// Returns the mean depth of each pixel's fragments, each weighted by what it adds to opacity; infinity for empty
    /// pixels. `None` under the conditions of [`median_depth`](Self::median_depth).
    pub fn mean_depth(&self) -> Option<&[f32]> {
        self.image.depth_mean.as_deref()
    }

    /// Returns the samples of each pixel's area: the number of images whose mean the picture is.
    pub fn samples(&self) -> u32 {
        self.image.samples.max(1)
    }

    /// Returns the number of fragments of each pixel, if [`counts`](crate::FrameBuilder::counts) were requested and the
    /// method has lists: their sum over [`samples`](Self::samples) images.
    pub fn fragments(&self) -> Option<&[u32]> {
        self.image.fragments.as_deref()
    }

    /// Returns the standard error of a stochastic picture, if it was found: root mean square over pixels and R, G, B.
    pub fn standard_error(&self) -> Option<f64> {
        self.image.standard_error()
    }

    /// Returns linear R, G, B of each pixel over the scene's background.
    pub fn over_background(&self) -> Vec<[f32; 3]> {
        linear(&self.image, self.options.background, self.options.color).pixels
    }

    /// Returns 8-bit sRGB of each pixel over the scene's background, as [`save`](Self::save) writes it.
    pub fn to_srgb8(&self) -> Vec<[u8; 3]> {
        self.over_background().into_iter().map(|pixel| pixel.map(|linear| to_byte(encode_srgb(linear)))).collect()
    }

    /// Writes a PNG (8-bit sRGB over the background) or an EXR (float32 with A, Z, and the requested depths and
    /// counts), by the file's extension.
    ///
    /// # Errors
    /// Returns an error for another extension, a missing folder, and errors of the system while writing. An earlier
    /// file then remains unchanged.
    pub fn save(&self, path: impl AsRef<Path>) -> Result<()> {
        write_image(path.as_ref(), &self.image, &self.options).map_err(of_engine)
    }

    /// Returns the bytes of the PNG that [`save`](Self::save) writes.
    ///
    /// # Errors
    /// Returns an error if the picture can't be encoded.
    pub fn to_png(&self) -> Result<Vec<u8>> {
        let bytes = png_bytes(&self.image, &self.options);
        bytes.map_err(|error| Error::argument(format!("the picture can't be encoded as PNG: {error}")))
    }

    /// Returns the cost of the frame.
    pub fn profile(&self) -> &Profile {
        &self.profile
    }
}
