//! Gaussian splats: in PLY files, and in formats of their own.

mod bad;
mod bombs;
mod converted;
mod gltf;
mod minimal;
mod ply;
mod spz;
mod written;

use std::path::PathBuf;

/// The folder of small files.
fn folder() -> PathBuf {
    pellucid_testing_host::root().join("tests/data/splats")
}

/// The bytes of a small file.
fn bytes(name: &str) -> Vec<u8> {
    std::fs::read(folder().join(name)).unwrap()
}
