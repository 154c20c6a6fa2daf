//! A scene: image, camera, shading, clouds and method, as a TOML file or the command line give them.

pub mod procedural;
mod settings;

pub use settings::*;

/// What is wrong with a scene file or with the options that stand for one.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {}

impl Error {
    /// 2, or 1 for a missing input.
    pub fn exit_status(&self) -> u8 {
        2
    }
}
