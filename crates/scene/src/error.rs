//! Errors in a scene file or in the options that stand for one, with their positions.

use std::path::PathBuf;

use super::procedural;
use pellucid_core::cloud::field;
use pellucid_io as io;

/// Anything that keeps a scene and its clouds from being opened.
#[derive(Debug, thiserror::Error)]
pub enum OpenError {
    /// A point cloud could not be read.
    #[error(transparent)]
    Load(#[from] pellucid_io::Error),
    /// A scene file, an option or their combination is wrong.
    #[error(transparent)]
    Scene(#[from] Error),
}

/// The position of a key or value.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
#[allow(missing_docs, reason = "the messages say what the fields are")]
pub enum Place {
    /// Position in a file, as it was named; line and column count from 1, columns in characters.
    File { path: String, line: usize, column: usize },
    /// Position in an option, as it was typed.
    Option(String),
}

impl std::fmt::Display for Place {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::File { path, line, column } => write!(f, "{path}:{line}:{column}"),
            Self::Option(option) => f.write_str(option),
        }
    }
}

/// An error in a scene file or in the options that stand for one.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
#[allow(missing_docs, reason = "the messages say what the fields are")]
pub enum Error {
    /// The scene file is missing or can't be read.
    #[error("{path}: can't read the scene file: {source}", path = path.display())]
    Read { path: PathBuf, source: std::io::Error },
    /// A cloud that is read node by node lacks what follows from neighbors.
    #[error(
        "{path}: {what} must be found from the neighbors of all points, but these are not in memory at once; store them \
         with `pellucid prepare {path} -o FOLDER`, load all points with more --host-memory, or choose a method or setting that does not need them",
        path = path.display()
    )]
    Unprepared { path: PathBuf, what: &'static str },
    /// The scene file has no bytes.
    #[error("{path}: the scene file is empty; it needs at least one [[cloud]] with a path", path = path.display())]
    Empty { path: PathBuf },
    /// The text is not TOML.
    #[error("{place}: {message}")]
    Syntax { place: Place, message: String },
    /// No table or method has this key.
    #[error("{place}: unknown key `{key}`{hint}")]
    UnknownKey { place: Place, key: String, hint: String },
    /// A value has the wrong type or is out of range.
    #[error("{place}: `{key}` {problem}")]
    Value { place: Place, key: String, problem: String },
    /// Two keys contradict each other, or one that is needed is missing.
    #[error("{place}: {problem}")]
    Conflict { place: Place, problem: String },
    /// No method of that name.
    #[error("{place}: unknown method {name:?}{hint}")]
    UnknownMethod { place: Place, name: String, hint: String },
    /// The options contradict each other.
    #[error("{0}")]
    Usage(String),
    /// A built-in scene can't be made as asked.
    #[error(transparent)]
    Procedural(#[from] procedural::Error),
    /// No finite point is left after `translate` and `scale`, or none that may be seen.
    #[error("{clouds}: {reason}")]
    NoPoints { clouds: String, reason: String },
    /// A cloud lacks what its field is made of.
    #[error("{path}: {source}", path = path.display())]
    Field { path: PathBuf, source: field::Error },
    /// A cloud lacks what its colors are to show. `there` names the existing properties, as a phrase.
    #[error("{path}: color_by = {by:?}, but the file has no {lacking}; {there}", path = path.display())]
    Color { path: PathBuf, by: String, lacking: String, there: String },
    /// No scalar has the name that a key gives.
    #[error("{path}: no scalar `{name}` for {key}{hint}", path = path.display())]
    NoScalar { path: PathBuf, name: String, key: &'static str, hint: String },
    /// The polygons of a clip can't be read.
    #[error(transparent)]
    Polygon(#[from] io::Error),
    /// A picture whose camera is wanted can't be read.
    #[error(transparent)]
    Picture(#[from] io::output::Error),
    /// A picture holds no camera, or no whole one.
    #[error(
        "{path}: expected the camera of the picture in its metadata ({tag}), but {problem}; give a PNG or EXR that `render` \
         wrote (pictures of version 0.2.0 have no camera, and programs that edit pictures may drop it)",
        path = path.display(), tag = io::output::CAMERA_TAG
    )]
    NoCamera { path: PathBuf, problem: String },
    /// Coordinates beyond what the camera can be computed for.
    #[error(
        "the scene extends from {min} to {max}, too large or too far from the origin for a camera in float64; use \
         `scale`"
    )]
    Extent { min: glam::DVec3, max: glam::DVec3 },
}

impl Error {
    /// 2 for a wrong scene file or option; 1 for an input that is missing, empty or can't be drawn.
    pub fn exit_status(&self) -> u8 {
        match self {
            Self::Read { .. }
            | Self::Empty { .. }
            | Self::NoPoints { .. }
            | Self::Field { .. }
            | Self::Color { .. }
            | Self::NoScalar { .. }
            | Self::Polygon(_)
            | Self::Extent { .. } => 1,
            Self::Procedural(procedural::Error::TooLarge { .. }) => 1,
            Self::Picture(error) => error.exit_status(),
            _ => 2,
        }
    }
}
