//! `.splat`: rows of 32 bytes without a header, as the first viewers in browsers had them.
//!
//! A row is three floats of the center, three of the extents, red, green, blue and opacity as bytes, and the quaternion
//! (w, x, y, z) as bytes b, each (b − 128)/128. There are no harmonics.

use glam::{DQuat, DVec3};

use super::{Splat, Splats, all_bytes, check_count};
use crate::number::float;
use crate::{Error, InputFile};
use pellucid_core::cloud::{Cloud, UpAxis};
use pellucid_core::progress::Progress;

/// Bytes of a splat.
const ROW: usize = 32;

pub(super) fn read(source: InputFile, progress: &Progress) -> Result<Cloud, Error> {
    let (rows, rest) = (source.len / ROW as u64, source.len % ROW as u64);
    if rest != 0 {
        return Err(source.truncated(format!(
            "{} bytes are {rows} splats of {ROW} bytes each, and {rest} bytes of an incomplete one",
            source.len
        )));
    }
    let (file, bytes) = all_bytes(source)?;
    check_count(&file, "byte 0", rows, 0, None)?;
    let splats = Splats::gather(rows as usize, 0, progress, |at, _| row(&bytes[at * ROW..][..ROW]));
    Ok(splats.finish(UpAxis::NegativeY))
}

fn row(row: &[u8]) -> Splat {
    let three = |at: usize| DVec3::new(float(row, at), float(row, at + 4), float(row, at + 8));
    let [red, green, blue, alpha] = [24, 25, 26, 27].map(|at| f64::from(row[at]) / 255.0);
    let rotation = [29, 30, 31, 28].map(|at| (f64::from(row[at]) - 128.0) / 128.0);
    Splat {
        center: three(0),
        extents: three(12),
        rotation: DQuat::from_array(rotation),
        base: DVec3::new(red, green, blue),
        linear: false,
        alpha,
    }
}
