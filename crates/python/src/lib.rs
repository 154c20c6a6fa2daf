//! Native part of the Python package `pellucid`: what must be Rust, and no more. Keywords, documentation and plain data
//! are in Python (`python/pellucid`).
//!
//! Every call that takes time runs on a thread of its own, while the caller waits without the interpreter's lock. So
//! Ctrl-C ends the call, and other Python threads go on ([`work`]).

// `cargo test --lib` compiles a harness of this crate in spite of `test = false`: an empty one.
#![cfg(not(test))]

mod arrays;
mod check;
mod cloud;
mod compare;
mod devices;
mod failure;
mod fork;
mod keys;
mod loaded;
mod measures;
mod picture;
mod request;
mod scene;
mod session;
mod stress;
mod talk;
mod threads;
mod work;

use pellucid_io::silence_decoder_panics;
use pyo3::prelude::*;

/// Native module that the Python part of the package imports.
#[pymodule]
mod _pellucid {
    #[pymodule_export]
    use super::check::check;
    #[pymodule_export]
    use super::cloud::Cloud;
    #[pymodule_export]
    use super::compare::compare;
    #[pymodule_export]
    use super::devices::{Device, devices};
    #[pymodule_export]
    use super::keys::{class_code, keys, methods};
    #[pymodule_export]
    use super::loaded::Loaded;
    #[pymodule_export]
    use super::picture::{Picture, picture_camera};
    #[pymodule_export]
    use super::scene::Scene;
    #[pymodule_export]
    use super::stress::stress;
    #[pymodule_export]
    use super::work::wait;

    /// Makes damaged files errors, without output on standard error.
    #[pymodule_init]
    fn init(_module: &super::Bound<'_, super::PyModule>) -> super::PyResult<()> {
        super::silence_decoder_panics();
        Ok(())
    }

    /// The version of pellucid.
    #[pymodule_export]
    const VERSION: &str = env!("CARGO_PKG_VERSION");
}
