//! Errors that end a command, and their exit status.

/// Anything that keeps a command from its result.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The engine could not do the work.
    #[error(transparent)]
    Engine(#[from] pellucid_engine::Error),
    /// A film could not be encoded.
    #[error(transparent)]
    Film(#[from] crate::commands::films::Error),
    /// The window could not be opened, or was closed by a failure.
    #[cfg(feature = "viewer")]
    #[error(transparent)]
    Window(#[from] pellucid_viewer::Error),
}

impl Error {
    /// Exit status: 1 the work could not be done, 2 the command line or scene file is wrong.
    pub fn exit_status(&self) -> u8 {
        match self {
            #[cfg(feature = "viewer")]
            Self::Window(pellucid_viewer::Error::Engine(error)) => error.exit_status(),
            #[cfg(feature = "viewer")]
            Self::Window(_) => 1,
            Self::Film(_) => 1,
            Self::Engine(error) => error.exit_status(),
        }
    }
}
