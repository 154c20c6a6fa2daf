//! Error of a failed call.

use std::fmt::{self, Display, Formatter};

/// Error of a failed call: a kind for programs, and a message for people that says what was expected and what helps.
#[derive(Debug)]
pub struct Error {
    kind: ErrorKind,
    cause: ErrorCause,
}

#[derive(Debug)]
enum ErrorCause {
    Engine(pellucid_engine::Error),
    Argument(String),
}

/// Kind of failure of an [`Error`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum ErrorKind {
    /// An argument is wrong: its length, its range, or a number that is not finite.
    Argument,
    /// A file could not be read.
    Read,
    /// A setting or a scene file is wrong.
    Scene,
    /// A file could not be written.
    Write,
    /// No device was found, or the device lacks a feature or failed.
    Device,
    /// The frame does not fit in memory, or cannot be rendered as requested.
    Render,
    /// An [`Observer`](crate::Observer) canceled the work.
    Cancelled,
}

/// Result with the crate's [`Error`], which has an [`enum@ErrorKind`].
pub type Result<T, E = Error> = std::result::Result<T, E>;

impl Error {
    /// Returns the kind of failure.
    pub fn kind(&self) -> ErrorKind {
        self.kind
    }

    pub(crate) fn argument(message: impl Into<String>) -> Self {
        Self { kind: ErrorKind::Argument, cause: ErrorCause::Argument(message.into()) }
    }
}

impl Display for Error {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        match &self.cause {
            ErrorCause::Engine(error) => error.fmt(f),
            ErrorCause::Argument(message) => message.fmt(f),
        }
    }
}

impl std::error::Error for Error {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        match &self.cause {
            ErrorCause::Engine(error) => error.source(),
            ErrorCause::Argument(_) => None,
        }
    }
}

/// Returns an error of the engine as one of this crate.
pub(crate) fn of_engine(error: impl Into<pellucid_engine::Error>) -> Error {
    use pellucid_engine::Error as Engine;
    let error = error.into();
    let kind = match &error {
        Engine::Load(_) | Engine::Scene(pellucid_scene::Error::Picture(_)) => ErrorKind::Read,
        Engine::Scene(_) | Engine::Path(_) => ErrorKind::Scene,
        Engine::Output(_) => ErrorKind::Write,
        Engine::Render(pellucid_engine::methods::Error::Cancelled) => ErrorKind::Cancelled,
        Engine::Gpu(_) | Engine::Render(pellucid_engine::methods::Error::Gpu(_)) => ErrorKind::Device,
        _ => ErrorKind::Render,
    };
    Error { kind, cause: ErrorCause::Engine(error) }
}
