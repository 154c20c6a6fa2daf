//! Devices of this machine.

use std::sync::{Arc, Mutex, PoisonError};

use pellucid_engine::methods;
use pellucid_gpu::{self as gpu, DeviceOptions};
use pyo3::prelude::*;

use crate::failure::Failure;
use crate::fork::Kept;
use crate::work;

/// Open device; scenes on it may be used from several threads at once.
#[pyclass(frozen, module = "pellucid._pellucid")]
pub struct Device(Arc<Mutex<Kept<gpu::Device>>>);

#[pymethods]
impl Device {
    /// Open the device of that index or part of a name, else the best one.
    #[new]
    #[pyo3(signature = (device=None))]
    fn new(py: Python<'_>, device: Option<String>) -> PyResult<Self> {
        let opened = work::run(py, None, move |_| {
            Ok(gpu::Device::open(&DeviceOptions { device, ..DeviceOptions::from_env() })?)
        })?;
        Ok(Self(Arc::new(Mutex::new(Kept::new("renderer", opened)))))
    }

    fn name(&self) -> PyResult<String> {
        Ok(self.device()?.info().name.clone())
    }

    fn driver(&self) -> PyResult<String> {
        Ok(self.device()?.info().driver.clone())
    }

    /// Return the device memory that scenes and frames of this device use, in bytes.
    fn bytes_in_use(&self) -> PyResult<u64> {
        let device = self.device()?;
        Ok(device.live_allocations().iter().map(|(_, bytes)| bytes).sum())
    }

    /// Close the device. Scenes on it keep it until they end, too.
    fn close(&self) {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).close();
    }
}

impl Device {
    pub fn device(&self) -> Result<gpu::Device, Failure> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).get().cloned()
    }
}

/// Index, name, driver, missing features, methods that it has no subgroups for, and `true` if it would be taken.
type Listed = (usize, String, String, Vec<String>, Vec<String>, bool);

/// Return all devices.
#[pyfunction]
pub fn devices(py: Python<'_>) -> PyResult<Vec<Listed>> {
    work::run(py, None, |_| {
        let (devices, taken) = gpu::devices(None)?;
        let listed = devices.into_iter().map(|device| {
            let without = methods::without_subgroups(&device).iter().map(ToString::to_string).collect();
            (device.index, device.name, device.driver, device.lacks, without, taken == Some(device.index))
        });
        Ok(listed.collect())
    })
}
