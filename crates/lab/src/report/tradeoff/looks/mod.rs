//! Parts of an approximation's error: an even shift, hidden colors that come through, shapes and noise; and the place
//! where it is worst.

mod measure;
mod page;

use pellucid_core::image::LinearImage;
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

/// Side of the square in pixels; less where the image is smaller.
const SIDE: u32 = 64;
/// Steps across a square by which it is moved.
const STEPS: u32 = 4;

/// The square with the largest squared error.
fn worst(reference: &LinearImage, image: &LinearImage) -> Worst {
    let (width, height) = (reference.width, reference.height);
    let side = SIDE.min(width).min(height).max(1);
    let cell = (side / STEPS).max(1);
    let across = width.div_ceil(cell);
    let mut cells = vec![0.0; (across * height.div_ceil(cell)) as usize];
    for (x, y, square) in squares(reference, image) {
        cells[(y / cell * across + x / cell) as usize] += square;
    }
    let touched = |x: u32, y: u32| {
        let columns = || x / cell..(x + side).div_ceil(cell);
        let rows = y / cell..(y + side).div_ceil(cell);
        let indices = rows.flat_map(|row| columns().map(move |column| row * across + column));
        indices.map(|index| cells[index as usize]).sum::<f64>()
    };
    // The last ones end with the image.
    let starts =
        |length: u32| (0..length.saturating_sub(side)).step_by(cell as usize).chain([length.saturating_sub(side)]);
    let places = starts(height).flat_map(|y| starts(width).map(move |x| (x, y, touched(x, y))));
    let (x, y, _) = places.reduce(|best, next| if next.2 > best.2 { next } else { best }).unwrap_or_default();
    let is_inside = |(column, row): (u32, u32)| (x..x + side).contains(&column) && (y..y + side).contains(&row);
    let (inside, whole) = squares(reference, image).fold((0.0, 0.0), |(inside, whole), (column, row, square)| {
        (if is_inside((column, row)) { inside + square } else { inside }, whole + square)
    });
    Worst { x, y, side, share: if whole > 0.0 { inside / whole } else { 0.0 } }
}

/// Column, row and squared error of each pixel whose error is a number.
fn squares(reference: &LinearImage, image: &LinearImage) -> impl Iterator<Item = (u32, u32, f64)> {
    let width = reference.width.max(1);
    let pixels = reference.pixels.iter().zip(&image.pixels).enumerate().map(move |(index, (a, b))| {
        let square: f64 = a.iter().zip(b).map(|(a, b)| (f64::from(*a) - f64::from(*b)).powi(2)).sum();
        (index as u32 % width, index as u32 / width, square)
    });
    pixels.filter(|(.., square)| square.is_finite())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn worst_of(size: [u32; 2], wrong: impl Fn(u32, u32) -> f32) -> Worst {
        let [width, height] = size;
        let pixels = vec![[0.5; 3]; (width * height) as usize];
        let error = |i: u32| [0.5 + wrong(i % width, i / width), 0.5, 0.5];
        let image = LinearImage { width, height, pixels: (0..width * height).map(error).collect() };
        worst(&LinearImage { width, height, pixels }, &image)
    }

    #[test]
    fn it_lies_around_the_error() {
        let spot =
            worst_of([300, 200], |x, y| if (150..170).contains(&x) && (90..100).contains(&y) { 0.2 } else { 0.0 });
        assert_eq!((spot.side, spot.share), (64, 1.0));
        assert!(spot.x <= 150 && spot.x + 64 >= 170 && spot.y <= 90 && spot.y + 64 >= 100, "{spot:?}");
        let corner = worst_of([300, 203], |x, y| if (x, y) == (299, 202) { 0.2 } else { 0.0 });
        assert_eq!((corner.x, corner.y, corner.share), (236, 139, 1.0));
    }

    #[test]
    fn small_images_are_shown_whole() {
        let spot = worst_of([5, 3], |x, _| if x == 4 { 0.1 } else { 0.0 });
        assert_eq!((spot.x, spot.y, spot.side), (2, 0, 3));
        assert_eq!(worst_of([1, 1], |_, _| 0.0), Worst { x: 0, y: 0, side: 1, share: 0.0 });
    }
}
