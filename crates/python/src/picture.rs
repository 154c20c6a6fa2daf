//! Rendered frame: the part that is left once NumPy has its arrays.

use std::path::PathBuf;

use numpy::{Element, PyArray1, PyReadonlyArray1, PyUntypedArrayMethods};
use pellucid_core::camera::StatedCamera;
use pellucid_core::image::{Image, LinearImage};
use pellucid_engine::methods;
use pellucid_engine::profile::Profile;
use pellucid_io::has_memory;
use pellucid_io::output::{self, WriteOptions};
use pellucid_scene::{self as scene, CameraSettings, PictureCamera};
use pyo3::prelude::*;
use pyo3::types::PyBytes;

use crate::arrays::{self, values};
use crate::failure::Failure;
use crate::work;

/// Frame without its arrays: how it is written, and what it cost.
#[pyclass(frozen, module = "pellucid._pellucid")]
pub struct Picture {
    pub size: [u32; 2],
    pub options: WriteOptions,
    pub profile: Profile,
    pub camera: StatedCamera,
    #[pyo3(get)]
    pub method: &'static str,
    #[pyo3(get)]
    pub reason: String,
    #[pyo3(get)]
    pub stderr: Option<f64>,
    /// Images whose mean it is.
    #[pyo3(get)]
    pub samples: u32,
}

/// Arrays of an image as Python keeps them: flat, row by row.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct Arrays<'py> {
    rgba: PyReadonlyArray1<'py, f32>,
    depth: PyReadonlyArray1<'py, f32>,
    median: Option<PyReadonlyArray1<'py, f32>>,
    mean: Option<PyReadonlyArray1<'py, f32>>,
    fragments: Option<Counted<'py>>,
    layers: Option<Counted<'py>>,
    stderr: Option<PyReadonlyArray1<'py, f32>>,
}

/// Counts of an image, or the means of several.
#[derive(FromPyObject)]
enum Counted<'py> {
    Counts(PyReadonlyArray1<'py, u32>),
    Means(PyReadonlyArray1<'py, f32>),
}

impl Counted<'_> {
    fn len(&self) -> usize {
        match self {
            Self::Counts(array) => array.len(),
            Self::Means(array) => array.len(),
        }
    }

    /// Returns the sums over so many images.
    fn sums(&self, name: &str, samples: u32, pixels: usize) -> Result<Vec<u32>, Failure> {
        match self {
            Self::Counts(array) => Ok(sized::<u32, 1>(name, array, pixels)?.into_flattened()),
            Self::Means(array) => {
                let means = sized::<f32, 1>(name, array, pixels)?.into_flattened();
                Ok(means.into_iter().map(|mean| (f64::from(mean) * f64::from(samples)).round() as u32).collect())
            }
        }
    }
}

impl Arrays<'_> {
    /// Returns the numbers of values of the arrays that not every image has.
    fn optional_lens(&self) -> impl Iterator<Item = usize> {
        let floats =
            [&self.median, &self.mean, &self.stderr].map(|array| array.as_ref().map_or(0, |array| array.len()));
        let counts = [&self.fragments, &self.layers].map(|array| array.as_ref().map_or(0, |array| array.len()));
        floats.into_iter().chain(counts)
    }
}

type Floats<'py> = Bound<'py, PyArray1<f32>>;
/// Counts, uint32, or means of counts, float32.
type Counts<'py> = Bound<'py, PyAny>;
/// Color, depth, median depth, mean depth, fragments, layers and standard error.
pub type Moved<'py> = (
    Floats<'py>,
    Floats<'py>,
    Option<Floats<'py>>,
    Option<Floats<'py>>,
    Option<Counts<'py>>,
    Option<Counts<'py>>,
    Option<Floats<'py>>,
);

/// Hands an image over to NumPy, which takes its memory.
pub fn moved(py: Python<'_>, image: Image) -> Moved<'_> {
    let floats = |values: Vec<f32>| PyArray1::from_vec(py, values);
    let [fragments, layers] =
        [&image.fragments, &image.layers].map(|counts| counts.as_ref().map(|c| counted(py, &image, c)));
    (
        arrays::flat(py, image.rgba),
        floats(image.depth),
        image.depth_median.map(floats),
        image.depth_mean.map(floats),
        fragments,
        layers,
        image.stderr.map(|stderr| arrays::flat(py, stderr)),
    )
}

fn counted<'py>(py: Python<'py>, image: &Image, counts: &[u32]) -> Counts<'py> {
    match image.samples {
        0 | 1 => PyArray1::from_slice(py, counts).into_any(),
        _ => PyArray1::from_vec(py, image.mean_counts(counts)).into_any(),
    }
}

#[pymethods]
impl Picture {
    /// Width and height in pixels.
    #[getter]
    fn size(&self) -> (u32, u32) {
        self.size.into()
    }

    #[getter]
    fn metadata(&self) -> Vec<(String, String)> {
        self.options.metadata.clone()
    }

    /// Return eye, target, up, the angle in degrees or the height, then near and far.
    fn camera(&self) -> CameraNumbers {
        numbers(&self.camera)
    }

    fn profile(&self) -> String {
        self.profile.to_json().to_string()
    }

    /// Write a PNG or an EXR, by the extension.
    fn save(&self, py: Python<'_>, path: PathBuf, transparent: bool, arrays: Arrays<'_>) -> PyResult<()> {
        let image = self.image(&arrays)?;
        let options = self.options(transparent);
        work::run(py, None, move |_| Ok(output::write_image(&path, &image, &options)?))
    }

    /// Return the bytes of a PNG.
    fn png<'py>(&self, py: Python<'py>, transparent: bool, arrays: Arrays<'_>) -> PyResult<Bound<'py, PyBytes>> {
        let image = self.image(&arrays)?;
        let options = self.options(transparent);
        let bytes = work::run(py, None, move |_| {
            output::png_bytes(&image, &options).map_err(|error| Failure::Refused(format!("no PNG: {error}")))
        })?;
        Ok(PyBytes::new(py, &bytes))
    }

    /// Return 8-bit sRGB over the background.
    fn srgb<'py>(&self, py: Python<'py>, arrays: Arrays<'_>) -> PyResult<Bound<'py, PyArray1<u8>>> {
        let image = self.image(&arrays)?;
        let options = self.options(false);
        let raster = py.detach(move || output::raster(&image, &options));
        Ok(PyArray1::from_vec(py, raster.bytes))
    }

    /// Return linear colors over the background.
    fn linear<'py>(&self, py: Python<'py>, arrays: Arrays<'_>) -> PyResult<Floats<'py>> {
        let image = self.image(&arrays)?;
        let WriteOptions { background, color, .. } = self.options;
        let LinearImage { pixels, .. } = py.detach(move || output::linear(&image, background, color));
        Ok(arrays::flat(py, pixels))
    }
}

/// See [`Picture::camera`].
pub type CameraNumbers = ([f64; 3], [f64; 3], [f64; 3], Option<f64>, Option<f64>, f64, f64);

pub fn numbers(camera: &StatedCamera) -> CameraNumbers {
    let [eye, target, up] = [camera.eye, camera.target(), camera.stated_up()].map(|v| v.to_array());
    (eye, target, up, camera.fov_y(), camera.height(), camera.near, camera.far)
}

/// Return the camera of a PNG or EXR from its metadata; see [`Picture::camera`].
#[pyfunction]
pub fn picture_camera(py: Python<'_>, path: PathBuf) -> PyResult<CameraNumbers> {
    let found = work::run(py, None, move |_| {
        PictureCamera::read(&path).map_err(|error| match error {
            scene::Error::Picture(error) => Failure::from(error),
            error => Failure::from(error),
        })
    })?;
    let CameraSettings { eye, target, up, fov_y, height, near, far, .. } = found.camera;
    let [eye, target, up] = [eye, target, up].map(|v| v.unwrap_or_default().to_array());
    Ok((eye, target, up, fov_y, height, near.unwrap_or_default(), far.unwrap_or_default()))
}

impl Picture {
    fn options(&self, transparent: bool) -> WriteOptions {
        WriteOptions { transparent, ..self.options.clone() }
    }

    fn image(&self, arrays: &Arrays<'_>) -> Result<Image, Failure> {
        let [width, height] = self.size;
        let pixels = width as usize * height as usize;
        // Copies of the arrays, the composed color, and 8-bit values in a vector that grows.
        let lens = [arrays.rgba.len(), arrays.depth.len()].into_iter().chain(arrays.optional_lens());
        let bytes = 4 * lens.sum::<usize>() as u64 + 24 * pixels as u64;
        if !has_memory(bytes) {
            return Err(methods::Error::HostMemory { width, height, bytes }.into());
        }
        let sums = |name: &str, counts: &Option<Counted<'_>>| {
            counts.as_ref().map(|counts| counts.sums(name, self.samples, pixels)).transpose()
        };
        Ok(Image {
            width,
            height,
            rgba: sized("rgba", &arrays.rgba, pixels)?,
            bytes: None,
            depth: sized::<f32, 1>("depth", &arrays.depth, pixels)?.into_flattened(),
            depth_median: given("median_depth", &arrays.median, pixels)?.map(Vec::<[f32; 1]>::into_flattened),
            depth_mean: given("mean_depth", &arrays.mean, pixels)?.map(Vec::<[f32; 1]>::into_flattened),
            samples: self.samples,
            fragments: sums("fragments", &arrays.fragments)?,
            layers: sums("layers", &arrays.layers)?,
            stderr: given("stderr", &arrays.stderr, pixels)?,
        })
    }
}

/// Returns an array as `N` values for each pixel.
fn sized<T: Element + Copy, const N: usize>(
    name: &str,
    array: &PyReadonlyArray1<'_, T>,
    pixels: usize,
) -> Result<Vec<[T; N]>, Failure> {
    let (expected, values) = (pixels * N, values(name, array)?);
    match values.as_chunks() {
        (chunks, []) if values.len() == expected => Ok(chunks.to_vec()),
        _ => Err(Failure::Value(format!("{name}: expected {expected} values, found {}", values.len()))),
    }
}

fn given<T: Element + Copy, const N: usize>(
    name: &str,
    array: &Option<PyReadonlyArray1<'_, T>>,
    pixels: usize,
) -> Result<Option<Vec<[T; N]>>, Failure> {
    array.as_ref().map(|array| sized(name, array, pixels)).transpose()
}
