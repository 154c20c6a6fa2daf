//! Popping as a table for programs.

use std::io::{self, Write};
use std::path::Path;

use pellucid_engine::output;
use serde::Serialize;

use super::Popping;

/// A line of `popping.csv`: a frame of a method.
#[derive(Debug, Serialize)]
struct Line<'a> {
    method: &'a str,
    setting: &'a str,
    frame: u32,
    error_rmse: f64,
    popping_rmse: Option<f64>,
    popping_flip: Option<f64>,
}

/// Method after method, and of each frame after frame.
///
/// # Errors
/// Writing fails.
pub fn csv(popping: &Popping, file: impl Write) -> io::Result<()> {
    let mut writer = csv::Writer::from_writer(file);
    for curve in &popping.curves {
        for frame in &curve.frames {
            let line = Line {
                method: &curve.method,
                setting: &curve.setting,
                frame: frame.frame,
                error_rmse: frame.error,
                popping_rmse: frame.rmse,
                popping_flip: frame.flip,
            };
            writer.serialize(line).map_err(io::Error::other)?;
        }
    }
    writer.flush()
}

/// Writes the table to a file, whole or not at all.
///
/// # Errors
/// Writing fails.
pub fn write(path: &Path, popping: &Popping) -> Result<(), output::Error> {
    output::write_atomically(path, |file| csv(popping, file))
}
