//! Parts of an approximation's error: an even shift, hidden colors that come through, shapes and noise; and the place
//! where it is worst.

mod measure;
mod page;
mod text;
mod worst;

use serde::{Deserialize, Serialize};

use super::{Row, Tradeoff};

pub(super) use measure::{Exact, look};
pub(super) use page::{Crops, section};

/// The parts of an image's error. The shares are those of the squared error over the covered pixels and add up to 1,
/// with `leak` as it is without its sign.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Look {
    /// Bias: the mean luminance of the image less that of the reference over the covered pixels, in linear light; below
    /// 0 it is too dark.
    pub bias: f64,
    /// The share of a shift that is the same on all covered pixels.
    pub even: f64,
    /// The share that points from the reference toward the image without order, in which hidden colors are as strong as
    /// those before them; what points the other way counts against it, so that it may be below 0. `None` where no such
    /// image exists.
    pub leak: Option<f64>,
    /// The share of the rest that goes on from a pixel to those beside it: shapes and outlines.
    pub ghost: f64,
    /// The share of the rest that does not.
    pub noise: f64,
    /// Square in which the error is worst.
    pub worst: Worst,
}

/// The square of pixels with the largest squared error, to a quarter of its side.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Worst {
    /// Column of its left side.
    pub x: u32,
    /// Row of its upper side.
    pub y: u32,
    /// Side of the square in pixels.
    pub side: u32,
    /// Share of the square in the squared error of the image.
    pub share: f64,
}

/// The most accurate setting of each approximation, and how its error looks. A method of which a setting is exact is
/// none.
pub(super) fn shown(report: &Tradeoff) -> Vec<(usize, &Row, Look)> {
    let mut found: Vec<(usize, &Row, Look)> = Vec::new();
    for (index, row) in report.rows.iter().enumerate() {
        let is_exact = report.rows.iter().any(|other| other.method == row.method && other.look.is_none());
        let Some(look) = row.look.filter(|_| !is_exact) else { continue };
        match found.iter_mut().find(|(_, known, _)| known.method == row.method) {
            Some(best) if row.errors.rmse < best.1.errors.rmse => *best = (index, row, look),
            Some(_) => {}
            None => found.push((index, row, look)),
        }
    }
    found
}
