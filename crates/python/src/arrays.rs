//! Conversion of NumPy columns to columns of a cloud, and back. Python has made them contiguous and of the types named
//! here.
//!
//! They are copied while the interpreter's lock is held, since other owners of the array may change it afterwards. They
//! are converted without the lock.

use glam::{DVec3, Vec3};
use numpy::{Element, PyArray1, PyReadonlyArray1};
use pellucid_core::color::decode_srgb;
use pellucid_io::unit_or_zero;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use rayon::prelude::*;

use crate::failure::Failure;

/// Copy of a contiguous array.
pub struct ArrayCopy<T>(pub Vec<T>);

impl<'a, 'py, T: Element + Copy + 'a> FromPyObject<'a, 'py> for ArrayCopy<T> {
    type Error = PyErr;

    fn extract(array: Borrowed<'a, 'py, PyAny>) -> PyResult<Self> {
        let array = PyReadonlyArray1::<'py, T>::extract(array)?;
        let values = array.as_slice().map_err(|_| PyValueError::new_err("expected a contiguous array"))?;
        Ok(Self(values.to_vec()))
    }
}

/// Copy of an array of floats.
#[derive(FromPyObject)]
pub enum FloatRows {
    Single(ArrayCopy<f32>),
    Double(ArrayCopy<f64>),
}

/// Copy of colors as given; integers are sRGB.
#[derive(FromPyObject)]
pub enum ColorRows {
    Byte(ArrayCopy<u8>),
    Short(ArrayCopy<u16>),
    Floats(FloatRows),
}

/// Returns the values of a contiguous array.
pub fn values<'a, T: Element>(name: &str, array: &'a PyReadonlyArray1<'_, T>) -> Result<&'a [T], Failure> {
    array.as_slice().map_err(|_| Failure::Value(format!("{name}: expected a contiguous array")))
}

/// Returns positions in world units, all finite.
pub fn positions(rows: &FloatRows) -> Result<Vec<DVec3>, Failure> {
    fn convert<T: Copy + Into<f64> + Sync>(values: &[T]) -> Result<Vec<DVec3>, Failure> {
        let rows = values.par_chunks_exact(3);
        let points: Vec<DVec3> = rows.map(|p| DVec3::new(p[0].into(), p[1].into(), p[2].into())).collect();
        match points.par_iter().position_first(|p| !p.is_finite()) {
            None => Ok(points),
            Some(at) => {
                let [x, y, z] = points[at].to_array();
                let bad = points.par_iter().filter(|p| !p.is_finite()).count();
                Err(Failure::Value(format!(
                    "points: expected finite coordinates, found ({x:?}, {y:?}, {z:?}) in row {at} ({bad} of {} rows are not finite); leave \
                     them out: points[numpy.isfinite(points).all(axis=1)]",
                    points.len()
                )))
            }
        }
    }
    match rows {
        FloatRows::Single(ArrayCopy(values)) => convert(values),
        FloatRows::Double(ArrayCopy(values)) => convert(values),
    }
}

/// Returns normals of length 1, or zero where none is given; `None` if there is none at all.
pub fn normals(rows: &FloatRows) -> Option<Vec<Vec3>> {
    let normals: Vec<Vec3> = vectors(rows).map(unit_or_zero).collect();
    normals.par_iter().any(|n| *n != Vec3::ZERO).then_some(normals)
}

/// Returns rows of three as float32.
fn vectors(rows: &FloatRows) -> impl IndexedParallelIterator<Item = Vec3> + '_ {
    let count = match rows {
        FloatRows::Single(ArrayCopy(values)) => values.len() / 3,
        FloatRows::Double(ArrayCopy(values)) => values.len() / 3,
    };
    (0..count).into_par_iter().map(move |i| match rows {
        FloatRows::Single(ArrayCopy(values)) => Vec3::from_slice(&values[3 * i..]),
        FloatRows::Double(ArrayCopy(values)) => DVec3::from_slice(&values[3 * i..]).as_vec3(),
    })
}

/// Returns linear colors. `srgb` is `true` if floats are sRGB.
pub fn colors(rows: &ColorRows, srgb: bool) -> Result<Vec<Vec3>, Failure> {
    let rows = match rows {
        ColorRows::Byte(ArrayCopy(values)) => return Ok(decoded(values, 255)),
        ColorRows::Short(ArrayCopy(values)) => return Ok(decoded(values, u16::MAX)),
        ColorRows::Floats(rows) => rows,
    };
    let in_range = |c: &Vec3| c.cmpge(Vec3::ZERO).all() && c.cmple(Vec3::ONE).all();
    if let Some((at, Vec3 { x, y, z })) = vectors(rows).enumerate().find_first(|(_, c)| !in_range(c)) {
        return Err(Failure::Value(format!(
            "colors: expected floats from 0 to 1, found ({x:?}, {y:?}, {z:?}) in row {at}; bytes are colors.astype(numpy.uint8)"
        )));
    }
    let decode = |c: Vec3| Vec3::from_array(c.to_array().map(decode_srgb));
    Ok(vectors(rows).map(|c| if srgb { decode(c) } else { c }).collect())
}

/// Returns colors as they are, whatever their range; integers are decoded.
pub fn any_colors(rows: &ColorRows) -> Vec<[f32; 3]> {
    match rows {
        ColorRows::Byte(ArrayCopy(values)) => decoded(values, 255).into_iter().map(|c| c.to_array()).collect(),
        ColorRows::Short(ArrayCopy(values)) => decoded(values, u16::MAX).into_iter().map(|c| c.to_array()).collect(),
        ColorRows::Floats(rows) => vectors(rows).map(|c| c.to_array()).collect(),
    }
}

fn decoded<T: Copy + Into<usize> + Sync>(values: &[T], full: u16) -> Vec<Vec3> {
    let table: Vec<f32> = (0..=full).map(|value| decode_srgb(f32::from(value) / f32::from(full))).collect();
    let linear = |c: &[T]| Vec3::new(table[c[0].into()], table[c[1].into()], table[c[2].into()]);
    values.par_chunks_exact(3).map(linear).collect()
}

/// Refuses a number outside the range that `expected` describes.
pub fn check(name: &str, values: &[f32], expected: &str, fine: impl Fn(f32) -> bool + Sync) -> Result<(), Failure> {
    match values.par_iter().position_first(|value| !fine(*value)) {
        None => Ok(()),
        Some(at) => Err(Failure::Value(format!("{name}: expected {expected}, found {} in row {at}", values[at]))),
    }
}

/// Returns a vector as a NumPy array, which takes it over without a copy: numbers in a row, `N` for each element.
pub fn flat<T: Element, const N: usize>(py: Python<'_>, values: Vec<[T; N]>) -> Bound<'_, PyArray1<T>> {
    PyArray1::from_vec(py, values.into_flattened())
}
