//! The crate's error: one enum for each layer below it, and their exit statuses.

/// Anything that keeps a command from its result.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A point cloud could not be read.
    #[error(transparent)]
    Load(#[from] crate::io::Error),
    /// A scene file, an option or their combination is wrong.
    #[error(transparent)]
    Scene(#[from] crate::scene::Error),
    /// A camera path can't be used.
    #[error(transparent)]
    Path(#[from] crate::camera::path::Error),
    /// An image or a report could not be written or read.
    #[error(transparent)]
    Output(#[from] crate::output::Error),
    /// The device refused, failed or lacks something.
    #[error(transparent)]
    Gpu(#[from] crate::gpu::Error),
    /// The frame does not fit or cannot be rendered as asked.
    #[error(transparent)]
    Render(#[from] crate::methods::Error),
}

/// A result with the crate's [`Error`].
pub type Result<T, E = Error> = std::result::Result<T, E>;

impl From<crate::scene::OpenError> for Error {
    fn from(error: crate::scene::OpenError) -> Self {
        match error {
            crate::scene::OpenError::Load(e) => Self::Load(e),
            crate::scene::OpenError::Scene(e) => Self::Scene(e),
        }
    }
}

impl Error {
    /// Exit status: 1 the work could not be done, 2 the command line or scene file is wrong.
    pub fn exit_status(&self) -> u8 {
        match self {
            Self::Scene(e) => e.exit_status(),
            Self::Path(e) => e.exit_status(),
            Self::Output(e) => e.exit_status(),
            Self::Load(_) | Self::Gpu(_) | Self::Render(_) => 1,
        }
    }
}
