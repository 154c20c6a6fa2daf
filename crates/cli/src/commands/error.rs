//! Errors that end a command, and their exit status.

use std::error::Error as _;

/// Anything that keeps a command from its result.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The engine could not do the work.
    #[error(transparent)]
    Engine(#[from] pellucid_engine::Error),
    /// A file could not be written.
    #[error(transparent)]
    Output(#[from] pellucid_io::output::Error),
    /// A film could not be encoded.
    #[error(transparent)]
    Film(#[from] super::films::Error),
    /// A rank failed, and the first one has said why.
    #[cfg(feature = "mpi")]
    #[error("a rank failed")]
    Told(u8),
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
            #[cfg(feature = "mpi")]
            Self::Told(status) => *status,
            Self::Engine(error) => error.exit_status(),
            Self::Output(error) => error.exit_status(),
        }
    }

    /// The message and those of its causes that it doesn't contain already.
    pub fn with_causes(&self) -> String {
        let mut message = self.to_string();
        let mut cause = self.source();
        while let Some(error) = cause {
            let text = error.to_string();
            if !message.contains(&text) {
                message = format!("{message}: {text}");
            }
            cause = error.source();
        }
        message
    }
}
