//! Errors that keep the window from showing a picture.

/// All errors of the window.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The scene can't be read or rendered, or its files can't be written.
    #[error(transparent)]
    Engine(#[from] pellucid_engine::Error),
    /// No display to open a window on.
    #[error("can't open a window: {0}; `pellucid render` writes a picture without one")]
    NoDisplay(String),
    /// The device was lost again soon after it was opened again.
    #[error(
        "{device} was lost again, during {during}: its driver stopped or restarted, often because a dispatch took too long; \
         try a smaller --size or --memory-budget, which make dispatches shorter, or another --device; `pellucid render` writes a picture without a window"
    )]
    LostAgain {
        /// The device's name.
        device: String,
        /// The operation that was running.
        during: String,
    },
    /// The device could not be opened again.
    #[error(
        "{device} was lost during {during} and can't be opened again: {why}; `pellucid devices` lists all devices, --device \
         selects another one, and `pellucid render` writes a picture without a window"
    )]
    NotReopened {
        /// The device's name.
        device: String,
        /// The operation that was running.
        during: String,
        /// Reason why the device could not be opened.
        why: String,
    },
    /// The renderer has a defect.
    #[error("the renderer panicked, which is a bug in this program (its message is above); saved files are intact")]
    Panicked,
    /// The server of the window has ended the connection.
    #[error("the display server closed the window ({0}); saved files are intact")]
    DisplayEnded(String),
}

/// A result with the window's [`enum@Error`].
pub type Result<T, E = Error> = std::result::Result<T, E>;

impl From<pellucid_gpu::Error> for Error {
    fn from(error: pellucid_gpu::Error) -> Self {
        Self::Engine(error.into())
    }
}
