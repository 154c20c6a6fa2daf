//! Differences of two pictures.

use std::path::PathBuf;

use numpy::PyArray1;
use pellucid_core::image::LinearImage;
use pellucid_core::metrics;
use pellucid_io::output::read_image;
use pyo3::prelude::*;
use serde_json::json;

use crate::arrays::{self, ColorRows};
use crate::failure::Failure;
use crate::work;

/// A file, or R, G, B of this width and height, row by row: linear floats, or sRGB integers.
#[derive(FromPyObject)]
pub enum ImageSource {
    Pixels(ColorRows, u32, u32),
    File(PathBuf),
}

impl ImageSource {
    fn read(self, name: &str) -> Result<LinearImage, Failure> {
        let image = match self {
            Self::Pixels(rows, width, height) => LinearImage { width, height, pixels: arrays::any_colors(&rows) },
            Self::File(path) => read_image(&path)?,
        };
        let LinearImage { width, height, pixels } = &image;
        if pixels.len() as u64 != u64::from(*width) * u64::from(*height) {
            let found = pixels.len();
            return Err(Failure::Value(format!("{name}: expected {width} × {height} pixels, found {found}")));
        }
        match pixels.iter().position(|pixel| pixel.iter().any(|value| !value.is_finite())) {
            Some(at) => {
                let (column, row) = (at % *width as usize, at / *width as usize);
                let message =
                    format!("{name}: expected finite colors, found {:?} in column {column}, row {row}", pixels[at]);
                Err(Failure::Value(message))
            }
            None => Ok(image),
        }
    }
}

/// JSON of `pellucid compare`, the absolute difference of each pixel, and width and height.
type Compared<'py> = (String, Bound<'py, PyArray1<f32>>, u32, u32);

/// Compare a picture with another one, the reference.
#[pyfunction]
pub fn compare<'py>(py: Python<'py>, a: ImageSource, b: ImageSource) -> PyResult<Compared<'py>> {
    let (json, difference, [width, height]) = work::run(py, None, move |_| {
        let (a, b) = (a.read("a")?, b.read("b")?);
        let comparison = metrics::compare(&a, &b).ok_or_else(|| {
            let [a, b] = [&a, &b].map(|image| format!("{} × {}", image.width, image.height));
            Failure::Value(format!("a and b: expected pictures of one size, found {a} and {b} pixels"))
        })?;
        let difference = metrics::difference_picture(&a.pixels, &b.pixels, 1.0);
        // JSON has no infinity: null is written for it.
        Ok((json!(comparison).to_string(), difference, [a.width, a.height]))
    })?;
    Ok((json, arrays::flat(py, difference), width, height))
}
