//! Differences of two pictures.

use std::path::PathBuf;

use numpy::PyArray1;
use pellucid_engine::image::LinearImage;
use pellucid_engine::metrics::{self, Comparison};
use pellucid_engine::output::read_image;
use pyo3::prelude::*;
use serde_json::json;

use crate::arrays::{self, Colors, values};
use crate::failure::Failure;
use crate::work;

/// A file, or R, G, B of as many columns and rows, row by row: linear floats, or integers that are sRGB.
#[derive(FromPyObject)]
pub enum Given<'py> {
    Pixels(Colors<'py>, u32, u32),
    File(PathBuf),
}

enum Source {
    Pixels(LinearImage),
    File(PathBuf),
}

impl Source {
    fn new(name: &str, given: Given<'_>) -> Result<Self, Failure> {
        let (array, width, height) = match given {
            Given::Pixels(array, width, height) => (array, width, height),
            Given::File(path) => return Ok(Self::File(path)),
        };
        let pixels: Vec<[f32; 3]> = match &array {
            Colors::Single(array) => values(name, array)?.chunks_exact(3).map(|c| [c[0], c[1], c[2]]).collect(),
            Colors::Double(array) => {
                values(name, array)?.chunks_exact(3).map(|c| [c[0], c[1], c[2]].map(|c| c as f32)).collect()
            }
            encoded => arrays::colors(encoded, false)?.iter().map(|c| c.to_array()).collect(),
        };
        if pixels.len() as u64 == u64::from(width) * u64::from(height) {
            Ok(Self::Pixels(LinearImage { width, height, pixels }))
        } else {
            Err(Failure::Value(format!("{name}: expected {width} × {height} pixels, found {}", pixels.len())))
        }
    }

    fn read(self) -> Result<LinearImage, Failure> {
        match self {
            Self::Pixels(image) => Ok(image),
            Self::File(path) => Ok(read_image(&path)?),
        }
    }
}

/// JSON as of `pellucid compare`, the absolute difference of each pixel, and columns and rows.
type Compared<'py> = (String, Bound<'py, PyArray1<f32>>, u32, u32);

/// Compares a picture with another one, the reference.
#[pyfunction]
pub fn compare<'py>(py: Python<'py>, a: Given<'_>, b: Given<'_>) -> PyResult<Compared<'py>> {
    let sources = Source::new("a", a).and_then(|a| Ok((a, Source::new("b", b)?)));
    let (a, b) = sources.map_err(|failure| failure.raise(py))?;
    let (json, difference, [width, height]) = work::run(py, None, move |_| {
        let (a, b) = (a.read()?, b.read()?);
        let comparison = metrics::compare(&a, &b).ok_or_else(|| {
            let [a, b] = [&a, &b].map(|image| format!("{} × {}", image.width, image.height));
            Failure::Value(format!("a and b: expected pictures of one size, found {a} and {b} pixels"))
        })?;
        let difference = metrics::difference_picture(&a.pixels, &b.pixels, 1.0);
        Ok((described(&comparison), difference, [a.width, a.height]))
    })?;
    Ok((json, arrays::flat(py, difference), width, height))
}

fn described(comparison: &Comparison) -> String {
    let Comparison { rmse, nmse, psnr, ssim, flip, max, above_1_255 } = comparison;
    // JSON has no infinity: null is written for it.
    let value = json!({
        "rmse": rmse, "nmse": nmse, "psnr": psnr, "ssim": ssim, "flip": flip,
        "max": { "value": max.value, "x": max.x, "y": max.y }, "above_1_255": above_1_255,
    });
    value.to_string()
}
