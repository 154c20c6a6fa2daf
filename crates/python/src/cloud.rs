//! Point cloud.

use std::path::PathBuf;
use std::sync::Arc;

use numpy::PyArray1;
use pellucid_core::cloud::{Cloud as Columns, UpAxis};
use pellucid_io as io;
use pellucid_session::describe_cloud;
use pyo3::prelude::*;

use crate::arrays::{self, ArrayCopy, ColorRows, FloatRows};
use crate::failure::Failure;
use crate::work;

/// Columns of a cloud; shared, and never changed.
#[pyclass(frozen, module = "pellucid._pellucid")]
pub struct Cloud(pub Arc<Columns>);

/// Columns given in addition to the points.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct Given {
    colors: Option<ColorRows>,
    srgb: bool,
    opacities: Option<ArrayCopy<f32>>,
    radii: Option<ArrayCopy<f32>>,
    normals: Option<FloatRows>,
    classification: Option<ArrayCopy<u8>>,
    intensity: Option<ArrayCopy<f32>>,
    scalars: Vec<(String, ArrayCopy<f32>)>,
    z_up: Option<bool>,
}

#[pymethods]
impl Cloud {
    /// Return a cloud of flat, contiguous arrays whose lengths and types Python has checked.
    #[staticmethod]
    fn of_arrays(py: Python<'_>, points: FloatRows, given: Given) -> PyResult<Self> {
        Ok(Self(Arc::new(work::run(py, None, move |_| given.columns(&points))?)))
    }

    /// Return the cloud of a file.
    #[staticmethod]
    #[pyo3(signature = (path, listener=None))]
    fn read(py: Python<'_>, path: PathBuf, listener: Option<&Bound<'_, PyAny>>) -> PyResult<Self> {
        let columns = work::run(py, listener, move |talk| {
            let columns = io::load(&path, &talk.progress)?;
            describe_cloud(&path, &columns, talk);
            Ok(columns)
        })?;
        Ok(Self(Arc::new(columns)))
    }

    fn __len__(&self) -> usize {
        self.0.len()
    }

    /// Return the smallest and the largest corner, six numbers; `None` without points.
    fn bounds<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyArray1<f64>>>> {
        let columns = Arc::clone(&self.0);
        let bounds = work::run(py, None, move |_| Ok(columns.bounds()))?;
        Ok(bounds.map(|bounds| arrays::flat(py, vec![bounds.min.to_array(), bounds.max.to_array()])))
    }

    fn points<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        arrays::flat(py, self.0.positions.iter().map(|p| p.to_array()).collect())
    }

    fn colors<'py>(&self, py: Python<'py>) -> Option<Bound<'py, PyArray1<f32>>> {
        Some(arrays::flat(py, self.0.colors.as_ref()?.iter().map(|c| c.to_array()).collect()))
    }

    fn normals<'py>(&self, py: Python<'py>) -> Option<Bound<'py, PyArray1<f32>>> {
        Some(arrays::flat(py, self.0.normals.as_ref()?.iter().map(|n| n.to_array()).collect()))
    }

    fn opacities<'py>(&self, py: Python<'py>) -> Option<Bound<'py, PyArray1<f32>>> {
        Some(PyArray1::from_slice(py, self.0.alphas.as_ref()?))
    }

    fn radii<'py>(&self, py: Python<'py>) -> Option<Bound<'py, PyArray1<f32>>> {
        Some(PyArray1::from_slice(py, self.0.own_radii()?))
    }

    fn classification<'py>(&self, py: Python<'py>) -> Option<Bound<'py, PyArray1<u8>>> {
        Some(PyArray1::from_slice(py, self.0.classification.as_ref()?))
    }

    fn intensity<'py>(&self, py: Python<'py>) -> Option<Bound<'py, PyArray1<f32>>> {
        Some(PyArray1::from_slice(py, self.0.intensity.as_ref()?))
    }

    /// Return names and values of all other scalars.
    fn scalars<'py>(&self, py: Python<'py>) -> Vec<(String, Bound<'py, PyArray1<f32>>)> {
        self.0.scalars.iter().map(|(name, values)| (name.clone(), PyArray1::from_slice(py, values))).collect()
    }

    /// Returns `true` if +Z points up.
    fn z_up(&self) -> bool {
        self.0.up == UpAxis::Z
    }
}

impl Given {
    /// Returns the columns of a cloud, of which every value is in its range.
    fn columns(self, points: &FloatRows) -> Result<Columns, Failure> {
        let floats = |rows: Option<ArrayCopy<f32>>| rows.map(|ArrayCopy(values)| values);
        let mut columns = Columns {
            alphas: floats(self.opacities),
            radii: floats(self.radii),
            classification: self.classification.map(|ArrayCopy(codes)| codes),
            intensity: floats(self.intensity),
            scalars: self.scalars.into_iter().map(|(name, ArrayCopy(values))| (name, values)).collect(),
            ..Columns::default()
        };
        let (alphas, radii) = (columns.alphas.as_deref(), columns.radii.as_deref());
        let not_negative = |r: f32| r >= 0.0 && r.is_finite();
        arrays::check("opacities", alphas.unwrap_or_default(), "numbers from 0 to 1", |a| (0.0..=1.0).contains(&a))?;
        arrays::check("radii", radii.unwrap_or_default(), "finite numbers of at least 0", not_negative)?;
        columns.positions = arrays::positions(points)?;
        columns.colors = self.colors.map(|colors| arrays::colors(&colors, self.srgb)).transpose()?;
        columns.normals = self.normals.and_then(|normals| arrays::normals(&normals));
        match self.z_up {
            Some(true) => columns.up = UpAxis::Z,
            Some(false) => columns.up = UpAxis::Y,
            None => io::ply::find_vertical(&mut columns),
        }
        Ok(columns)
    }
}
