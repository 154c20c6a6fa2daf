//! Columns of numpy as columns of a cloud, and back. Python has made them contiguous and of the types named here.
//!
//! They are copied while the interpreter's lock is held: whoever else has the array may change it afterwards.

use glam::{DVec3, Vec3};
use numpy::{Element, PyArray1, PyReadonlyArray1};
use pellucid_engine::color::decode_srgb;
use pyo3::prelude::*;
use rayon::prelude::*;

use crate::failure::Failure;

/// Rows of a contiguous array, `width` values each, or of one column.
#[derive(FromPyObject)]
pub enum Floats<'py> {
    Single(PyReadonlyArray1<'py, f32>),
    Double(PyReadonlyArray1<'py, f64>),
}

/// Colors as they are given: integers are sRGB.
#[derive(FromPyObject)]
pub enum Colors<'py> {
    Byte(PyReadonlyArray1<'py, u8>),
    Short(PyReadonlyArray1<'py, u16>),
    Single(PyReadonlyArray1<'py, f32>),
    Double(PyReadonlyArray1<'py, f64>),
}

/// The values of a contiguous array.
pub fn values<'a, T: Element>(name: &str, array: &'a PyReadonlyArray1<'_, T>) -> Result<&'a [T], Failure> {
    array.as_slice().map_err(|_| Failure::Value(format!("{name}: expected a contiguous array")))
}

/// World positions, all finite.
pub fn positions(array: &Floats<'_>) -> Result<Vec<DVec3>, Failure> {
    fn convert<T: Copy + Into<f64> + Sync>(values: &[T]) -> Result<Vec<DVec3>, Failure> {
        let rows = values.par_chunks_exact(3);
        let points: Vec<DVec3> = rows.map(|p| DVec3::new(p[0].into(), p[1].into(), p[2].into())).collect();
        match points.par_iter().position_first(|p| !p.is_finite()) {
            None => Ok(points),
            Some(at) => {
                let [x, y, z] = points[at].to_array();
                let bad = points.par_iter().filter(|p| !p.is_finite()).count();
                Err(Failure::Value(format!(
                    "points: expected finite coordinates, found ({x}, {y}, {z}) in row {at} ({bad} of {} rows are not finite); leave \
                     them out: points[numpy.isfinite(points).all(axis=1)]",
                    points.len()
                )))
            }
        }
    }
    match array {
        Floats::Single(array) => convert(values("points", array)?),
        Floats::Double(array) => convert(values("points", array)?),
    }
}

/// Normals of length 1, or zero where none is given; `None` if there is none at all.
pub fn normals(array: &Floats<'_>) -> Result<Option<Vec<Vec3>>, Failure> {
    let unit = |n: DVec3| {
        let n = n.as_vec3();
        if n.is_finite() { DVec3::from(n).normalize_or_zero().as_vec3() } else { Vec3::ZERO }
    };
    let rows: Vec<Vec3> = match array {
        Floats::Single(array) => {
            let rows = values("normals", array)?.par_chunks_exact(3);
            rows.map(|n| unit(Vec3::from_slice(n).into())).collect()
        }
        Floats::Double(array) => {
            values("normals", array)?.par_chunks_exact(3).map(|n| unit(DVec3::from_slice(n))).collect()
        }
    };
    Ok(rows.par_iter().any(|n| *n != Vec3::ZERO).then_some(rows))
}

/// Linear colors. `srgb` is said of floats.
pub fn colors(array: &Colors<'_>, srgb: bool) -> Result<Vec<Vec3>, Failure> {
    fn decoded<T: Copy + Into<usize> + Sync>(values: &[T], full: u16) -> Vec<Vec3> {
        let table: Vec<f32> = (0..=full).map(|value| decode_srgb(f32::from(value) / f32::from(full))).collect();
        let linear = |c: &[T]| Vec3::new(table[c[0].into()], table[c[1].into()], table[c[2].into()]);
        values.par_chunks_exact(3).map(linear).collect()
    }
    fn floats<T: Copy + Sync>(
        values: &[T],
        single: impl Fn(T) -> f32 + Sync,
        srgb: bool,
    ) -> Result<Vec<Vec3>, Failure> {
        let rows = values.par_chunks_exact(3);
        let colors: Vec<Vec3> = rows.map(|c| Vec3::new(single(c[0]), single(c[1]), single(c[2]))).collect();
        let in_range = |c: &Vec3| c.cmpge(Vec3::ZERO).all() && c.cmple(Vec3::ONE).all();
        if let Some(at) = colors.par_iter().position_first(|c| !in_range(c)) {
            let Vec3 { x, y, z } = colors[at];
            return Err(Failure::Value(format!(
                "colors: expected floats from 0 to 1, found ({x}, {y}, {z}) in row {at}; bytes are colors.astype(numpy.uint8)"
            )));
        }
        let decode = |c: Vec3| Vec3::from_array(c.to_array().map(decode_srgb));
        Ok(if srgb { colors.into_par_iter().map(decode).collect() } else { colors })
    }
    Ok(match array {
        Colors::Byte(array) => decoded(values("colors", array)?, 255),
        Colors::Short(array) => decoded(values("colors", array)?, u16::MAX),
        Colors::Single(array) => floats(values("colors", array)?, |c| c, srgb)?,
        Colors::Double(array) => floats(values("colors", array)?, |c| c as f32, srgb)?,
    })
}

/// A column of numbers that are all in a range, of which `expected` speaks.
pub fn column(
    name: &str,
    array: &PyReadonlyArray1<'_, f32>,
    expected: &str,
    fine: impl Fn(f32) -> bool + Sync,
) -> Result<Vec<f32>, Failure> {
    let values = values(name, array)?;
    match values.par_iter().position_first(|value| !fine(*value)) {
        None => Ok(values.to_vec()),
        Some(at) => Err(Failure::Value(format!("{name}: expected {expected}, found {} in row {at}", values[at]))),
    }
}

/// A vector as an array of numpy, which takes it over without a copy: numbers in a row, `N` for each element.
pub fn flat<T: Element, const N: usize>(py: Python<'_>, values: Vec<[T; N]>) -> Bound<'_, PyArray1<T>> {
    PyArray1::from_vec(py, values.into_flattened())
}
