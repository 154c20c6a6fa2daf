//! Errors of the engine as Python exceptions.

use pellucid_engine::{Error, methods};
use pyo3::exceptions::{PyOSError, PyRuntimeError, PyValueError};
use pyo3::prelude::*;

/// Reason why a call failed.
#[derive(Debug)]
pub enum Failure {
    Engine(Box<Error>),
    /// An argument that makes no sense.
    Value(String),
    /// Request that can't be done here.
    Refused(String),
    /// Canceled work: nobody waits for it any more.
    Cancelled,
}

impl<E: Into<Error>> From<E> for Failure {
    fn from(error: E) -> Self {
        match error.into() {
            Error::Render(methods::Error::Cancelled) => Self::Cancelled,
            error => Self::Engine(Box::new(error)),
        }
    }
}

/// Packages to install for Vulkan, by system.
const VULKAN: &str = "\n\
    pellucid needs a Vulkan driver of version 1.3; a GPU is not needed. Install one:\n  \
    Debian, Ubuntu: apt install libvulkan1 mesa-vulkan-drivers\n  \
    Fedora: dnf install vulkan-loader mesa-vulkan-drivers\n  \
    Windows: the driver of the GPU's maker, which brings Vulkan; without a GPU Mesa's lavapipe (github.com/pal1000/mesa-dist-win)\n  \
    macOS: brew install vulkan-loader molten-vk";

/// Converts a failure to an exception of the package.
impl From<Failure> for PyErr {
    fn from(failure: Failure) -> Self {
        match failure {
            Failure::Value(message) => PyValueError::new_err(message),
            Failure::Refused(message) => of_class("Error", message),
            Failure::Cancelled => of_class("Error", "the work was cancelled".to_owned()),
            Failure::Engine(error) => {
                let (class, more) = match &*error {
                    Error::Load(_) => ("ReadError", ""),
                    Error::Scene(_) | Error::Path(_) => ("SceneError", ""),
                    Error::Output(_) => return PyOSError::new_err(error.to_string()),
                    Error::Gpu(gpu) | Error::Render(methods::Error::Gpu(gpu)) => ("DeviceError", install(gpu)),
                    _ => ("Error", ""),
                };
                of_class(class, format!("{error}{more}"))
            }
        }
    }
}

/// Returns advice where there is no driver, or none that will do.
fn install(error: &pellucid_gpu::Error) -> &'static str {
    use pellucid_gpu::Error as Gpu;
    match error {
        Gpu::NoLoader(_) | Gpu::NoDevice | Gpu::NoDriver { .. } | Gpu::Lacks { .. } => VULKAN,
        _ => "",
    }
}

/// Returns an exception of a Python class, since some have two bases.
fn of_class(name: &str, message: String) -> PyErr {
    Python::attach(|py| {
        let found = py.import("pellucid._errors").and_then(|module| module.getattr(name)?.call1((&message,)));
        found.map_or_else(|_| PyRuntimeError::new_err(message), PyErr::from_value)
    })
}
