//! Errors that keep the window from showing a picture.

use super::{Lost, NoDisplay};

/// All errors of the window.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The scene can't be read or rendered, or its files can't be written.
    #[error(transparent)]
    Engine(#[from] pellucid_engine::Error),
    /// No display to open a window on.
    #[error(transparent)]
    NoDisplay(#[from] NoDisplay),
    /// The window had to be closed.
    #[error(transparent)]
    Lost(#[from] Lost),
}

/// A result with the window's [`enum@Error`].
pub type Result<T, E = Error> = std::result::Result<T, E>;

impl Error {
    /// The engine's error, if it is one.
    pub fn engine(&self) -> Option<&pellucid_engine::Error> {
        match self {
            Self::Engine(error) => Some(error),
            Self::NoDisplay(_) | Self::Lost(_) => None,
        }
    }
}

impl From<pellucid_gpu::Error> for Error {
    fn from(error: pellucid_gpu::Error) -> Self {
        Self::Engine(error.into())
    }
}
