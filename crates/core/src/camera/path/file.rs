//! The JSON file of key frames.

use std::path::Path;

use glam::{DQuat, DVec3};
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use super::{Error, Problem};
use crate::image::MAX_SIDE;

/// The version of the format that is read and written.
pub const VERSION: u32 = 1;

/// Keys of a path at most.
pub const MAX_KEYS: usize = 100_000;

/// Coordinates up to here can be squared and multiplied in float64 without overflow.
const MAX_COORDINATE: f64 = 1e75;

/// Key frames, as a file holds them.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CameraPath {
    /// [`VERSION`].
    pub version: u32,
    /// Width and height in pixels of the pictures that the path was made for.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub size: Option<[u32; 2]>,
    /// `true` if the path returns from the last key to the first; `loop` in the file.
    #[serde(default, rename = "loop", skip_serializing_if = "std::ops::Not::not")]
    pub closed: bool,
    /// Keys of the path: at least one, at most [`MAX_KEYS`].
    pub keys: Vec<Key>,
}

/// A camera that the path passes through: `eye` and either `target` (and `up`) or `orientation`.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Key {
    /// The key's time, in any unit, ascending from key to key. Either all keys have one or none, which spaces them
    /// evenly.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub time: Option<f64>,
    /// The eye in world units.
    pub eye: [f64; 3],
    /// The point at the image's center, in world units.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub target: Option<[f64; 3]>,
    /// Direction of the image's top, with `target`; by default the scene's vertical.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub up: Option<[f64; 3]>,
    /// Instead of `target`: the quaternion w, x, y, z, of any length but 0, that turns the camera's axes (x right, y
    /// up, looking along −z) into those of the world.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub orientation: Option<[f64; 4]>,
    /// Full vertical angle in degrees, in (0, 180); by default the scene's.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fov_y: Option<f64>,
    /// Instead of `fov_y`: world units over the image's height, orthographic.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub height: Option<f64>,
    /// Nearest depth drawn, positive; either all keys have one or none. By default from the scene's bounds.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub near: Option<f64>,
    /// Farthest depth drawn, above `near`; either all keys have one or none. By default from the scene's bounds.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub far: Option<f64>,
}

impl Key {
    /// Returns a key with only the eye; it needs a `target` or an `orientation`.
    pub fn at(eye: [f64; 3]) -> Self {
        Self { eye, ..Self::default() }
    }

    /// Refuses what makes no camera; `number` counts from 0.
    fn check(&self, number: usize) -> Result<(), Problem> {
        let wrong = |name: &str, problem: &str| Err(Problem::of_key(number, name, problem));
        let vectors = [("eye", Some(self.eye)), ("target", self.target), ("up", self.up)];
        for (name, vector) in vectors {
            if vector.iter().flatten().any(|x| x.is_nan() || x.abs() > MAX_COORDINATE) {
                return wrong(name, "must be three finite numbers of at most 1e75");
            }
        }
        match (self.target, self.orientation) {
            (None, None) => return wrong("", "needs a target or an orientation beside eye"),
            (Some(_), Some(_)) => return wrong("", "target and orientation exclude each other"),
            (None, Some(q)) if !DQuat::from_array(q).length_squared().is_normal() => {
                return wrong("orientation", "must be four finite numbers w, x, y, z, not all 0");
            }
            (None, Some(_)) if self.up.is_some() => return wrong("up", "belongs to a target, not to an orientation"),
            (Some(target), None) if !(DVec3::from(target) - DVec3::from(self.eye)).length_squared().is_normal() => {
                return wrong("target", "must differ from eye");
            }
            _ => {}
        }
        if self.up.is_some_and(|up| !DVec3::from(up).length_squared().is_normal()) {
            return wrong("up", "must have a direction");
        }
        if self.fov_y.is_some() && self.height.is_some() {
            return wrong("", "fov_y (perspective) and height (orthographic) exclude each other");
        }
        if self.fov_y.is_some_and(|fov| !(fov > 0.0 && fov < 180.0)) {
            return wrong("fov_y", "must be degrees between 0 and 180, both excluded");
        }
        for (name, value) in [("height", self.height), ("near", self.near), ("far", self.far)] {
            if value.is_some_and(|value| !(value > 0.0 && value <= MAX_COORDINATE)) {
                return wrong(name, "must be positive and at most 1e75");
            }
        }
        if self.near.zip(self.far).is_some_and(|(near, far)| near >= far) {
            return wrong("near", "must be less than far");
        }
        Ok(())
    }
}

impl CameraPath {
    /// Returns an open path without a size.
    pub fn new(keys: Vec<Key>) -> Self {
        Self { version: VERSION, size: None, closed: false, keys }
    }

    /// Reads the text of a file; `path` is only named in errors.
    ///
    /// # Errors
    /// No JSON, an unknown or missing key, a value out of range: with line and column, or with the key's number.
    pub fn from_json(text: &str, path: &Path) -> Result<Self, Error> {
        let read: Self = from_text(text, path)?;
        read.check().map_err(|problem| Error::Content { path: path.to_owned(), problem })?;
        Ok(read)
    }

    /// Returns the text of a file: one line for each key, with a line feed at the end.
    pub fn to_json(&self) -> String {
        let Self { version, size, closed, keys } = self;
        let mut head = format!("{{\n  \"version\": {version},\n");
        if let Some([width, height]) = size {
            head += &format!("  \"size\": [{width}, {height}],\n");
        }
        if *closed {
            head += "  \"loop\": true,\n";
        }
        // Numbers and arrays of them always have a JSON form.
        let lines = keys.iter().filter_map(|key| serde_json::to_string(key).ok()).map(|key| format!("    {key}"));
        format!("{head}  \"keys\": [\n{}\n  ]\n}}\n", lines.collect::<Vec<_>>().join(",\n"))
    }

    /// Refuses what makes no path; [`CameraPath::from_json`] has done so.
    ///
    /// # Errors
    /// Another version, no keys or too many, a key that makes no camera, times that don't ascend, near, far or times of
    /// some keys only, both kinds of projection.
    pub fn check(&self) -> Result<(), Problem> {
        if self.version != VERSION {
            return Err(Problem::whole(format!("version: this program reads version {VERSION}, not {}", self.version)));
        }
        if self.size.is_some_and(|size| size.iter().any(|side| !(1..=MAX_SIDE).contains(side))) {
            return Err(Problem::whole(format!("size: width and height must be from 1 to {MAX_SIDE} pixels")));
        }
        if self.keys.is_empty() || self.keys.len() > MAX_KEYS {
            let count = self.keys.len();
            return Err(Problem::whole(format!("keys: a path has from 1 to {MAX_KEYS} of them, not {count}")));
        }
        self.keys.iter().enumerate().try_for_each(|(number, key)| key.check(number))?;
        for (at, name) in ["time", "near", "far"].into_iter().enumerate() {
            let is_given = |key: &Key| [key.time, key.near, key.far][at].is_some();
            let first = is_given(&self.keys[0]);
            if let Some(number) = self.keys.iter().position(|key| is_given(key) != first) {
                return Err(Problem::of_key(number, name, "either all keys have it, or none"));
            }
        }
        for (number, pair) in self.keys.windows(2).enumerate() {
            if let (Some(before), Some(after)) = (pair[0].time, pair[1].time)
                && !(before < after && (after - before).is_normal())
            {
                let problem = format!("times must ascend: {after} follows {before}");
                return Err(Problem::of_key(number + 1, "time", problem));
            }
        }
        Ok(())
    }
}

/// Reads JSON; errors have their place in front.
pub(in crate::camera) fn from_text<T: DeserializeOwned>(text: &str, path: &Path) -> Result<T, Error> {
    serde_json::from_str(text).map_err(|error| syntax(text, path, &error))
}

fn syntax(text: &str, path: &Path, error: &serde_json::Error) -> Error {
    let (line, column) = (error.line(), error.column());
    let message = error.to_string();
    let message = message.strip_suffix(&format!(" at line {line} column {column}")).unwrap_or(&message);
    let message = match word_at(text, line, column) {
        Some(word @ ("NaN" | "Infinity")) => {
            format!("{word} is not a number of JSON; leave out the cameras that have it")
        }
        _ => message.to_owned(),
    };
    Error::Syntax { path: path.to_owned(), line, column, message }
}

/// The letters from a place on, which counts from 1.
fn word_at(text: &str, line: usize, column: usize) -> Option<&str> {
    let rest = text.lines().nth(line.checked_sub(1)?)?.get(column.checked_sub(1)?..)?;
    rest.split(|letter: char| !letter.is_ascii_alphabetic()).next()
}
