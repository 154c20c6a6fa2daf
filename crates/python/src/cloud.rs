//! Point cloud.

use std::path::PathBuf;
use std::sync::Arc;

use numpy::{PyArray1, PyReadonlyArray1};
use pellucid_engine::cloud::{Cloud as Columns, UpAxis};
use pellucid_engine::io;
use pellucid_session::describe_cloud;
use pyo3::prelude::*;

use crate::arrays::{self, ColorRows, Colors, FloatRows, Floats};
use crate::failure::Failure;
use crate::work;

/// Columns of a cloud; shared, and never changed.
#[pyclass(frozen, module = "pellucid._pellucid")]
pub struct Cloud(pub Arc<Columns>);

/// Columns given in addition to the points.
#[derive(FromPyObject)]
pub struct Given<'py> {
    #[pyo3(item)]
    colors: Option<Colors<'py>>,
    #[pyo3(item)]
    srgb: bool,
    #[pyo3(item)]
    opacities: Option<PyReadonlyArray1<'py, f32>>,
    #[pyo3(item)]
    radii: Option<PyReadonlyArray1<'py, f32>>,
    #[pyo3(item)]
    normals: Option<Floats<'py>>,
    #[pyo3(item)]
    classification: Option<PyReadonlyArray1<'py, u8>>,
    #[pyo3(item)]
    intensity: Option<PyReadonlyArray1<'py, f32>>,
    #[pyo3(item)]
    scalars: Vec<(String, PyReadonlyArray1<'py, f32>)>,
    #[pyo3(item)]
    z_up: Option<bool>,
}

#[pymethods]
impl Cloud {
    /// Return a cloud of flat, contiguous arrays whose lengths and types Python has checked.
    #[staticmethod]
    fn of_arrays(py: Python<'_>, points: Floats<'_>, given: Given<'_>) -> PyResult<Self> {
        let copies = Copies::new(&points, &given).map_err(|failure| failure.raise(py))?;
        Ok(Self(Arc::new(work::run(py, None, move |_| copies.columns())?)))
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

/// Copies of everything that was given.
struct Copies {
    points: FloatRows,
    colors: Option<ColorRows>,
    srgb: bool,
    normals: Option<FloatRows>,
    z_up: Option<bool>,
    /// Columns that need no conversion.
    columns: Columns,
}

impl Copies {
    fn new(points: &Floats<'_>, given: &Given<'_>) -> Result<Self, Failure> {
        let floats = |name: &str, array: &Option<PyReadonlyArray1<'_, f32>>| {
            array.as_ref().map(|array| arrays::copied(name, array)).transpose()
        };
        let scalars = given.scalars.iter().map(|(name, values)| Ok((name.clone(), arrays::copied(name, values)?)));
        let classification = given.classification.as_ref().map(|codes| arrays::copied("classification", codes));
        Ok(Self {
            points: points.copied("points")?,
            colors: given.colors.as_ref().map(|colors| colors.copied("colors")).transpose()?,
            srgb: given.srgb,
            normals: given.normals.as_ref().map(|normals| normals.copied("normals")).transpose()?,
            z_up: given.z_up,
            columns: Columns {
                alphas: floats("opacities", &given.opacities)?,
                radii: floats("radii", &given.radii)?,
                classification: classification.transpose()?,
                intensity: floats("intensity", &given.intensity)?,
                scalars: scalars.collect::<Result<_, Failure>>()?,
                ..Columns::default()
            },
        })
    }

    /// Returns the columns of a cloud, of which every value is in its range.
    fn columns(self) -> Result<Columns, Failure> {
        let mut columns = self.columns;
        let (alphas, radii) = (columns.alphas.as_deref(), columns.radii.as_deref());
        let not_negative = |r: f32| r >= 0.0 && r.is_finite();
        arrays::check("opacities", alphas.unwrap_or_default(), "numbers from 0 to 1", |a| (0.0..=1.0).contains(&a))?;
        arrays::check("radii", radii.unwrap_or_default(), "finite numbers of at least 0", not_negative)?;
        columns.positions = arrays::positions(&self.points)?;
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
