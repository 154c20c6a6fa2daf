//! Measurements of the frames of a camera path: one JSON of all, kept line by line while frames are still missing.

use std::collections::BTreeMap;
use std::fs::{self, File, OpenOptions};
use std::io::{BufRead, BufReader, Write};
use std::path::{Path, PathBuf};

use pellucid_core::camera::{Camera, Projection};
use pellucid_engine::Result;
use pellucid_engine::methods::Rendered;
use pellucid_engine::profile::Profile;
use pellucid_io::output;
use pellucid_session::Session;
use serde_json::{Value, json};

/// Profiles of one frame each.
#[derive(Default)]
pub struct FrameProfiles {
    /// Profiles by frame number.
    frames: BTreeMap<usize, Value>,
    /// True if some were measured by this command.
    has_new: bool,
}

impl FrameProfiles {
    /// Adds a rendered frame and returns its profile; `identity` identifies its picture.
    pub fn add(
        &mut self,
        number: usize,
        camera: &Camera,
        identity: Option<&str>,
        session: &Session,
        rendered: &Rendered,
    ) -> &Value {
        let mut profile = session.profile();
        profile.add(rendered);
        let mut whole = profile.to_json();
        if let Some(frame) = whole.pointer_mut("/frames/0").and_then(Value::as_object_mut) {
            let facts = &rendered.facts;
            frame.insert("frame".to_owned(), number.into());
            frame.insert("fragments".to_owned(), facts.fragments.into());
            frame.insert("max_list".to_owned(), facts.max_list.into());
            frame.insert("camera".to_owned(), camera_json(camera));
            frame.extend(identity.map(|identity| ("identity".to_owned(), identity.into())));
        }
        self.has_new = true;
        let slot = self.frames.entry(number).or_default();
        *slot = whole;
        slot
    }

    /// The interface's profile of all frames, in their order; all but `frames` is that of the last one. `empty` is one
    /// without frames, with the phases of this command, which count if it measured any.
    pub fn to_json(&self, empty: &Profile) -> Value {
        let frames: Vec<&Value> = self.frames.values().filter_map(|one| one.pointer("/frames/0")).collect();
        let frames = json!(frames);
        let empty = empty.to_json();
        let mut whole = self.frames.values().next_back().cloned().unwrap_or_else(|| empty.clone());
        if self.has_new {
            whole["host"] = empty["host"].clone();
        }
        whole["steady"] = empty["steady"].clone();
        whole["frames"] = frames;
        whole
    }

    /// Returns the numbers below `count` of the frames that are missing.
    pub fn missing(&self, count: usize) -> Vec<usize> {
        (0..count).filter(|number| !self.frames.contains_key(number)).collect()
    }

    /// Takes the frames of a profile of one or of many that are of these pictures, and for which `there` is.
    fn absorb(&mut self, mut whole: Value, identities: &[String], there: &[bool]) {
        let Some(Value::Array(frames)) = whole.get_mut("frames").map(Value::take) else { return };
        for frame in frames {
            let number = frame.get("frame").and_then(Value::as_u64).and_then(|number| usize::try_from(number).ok());
            let Some(number) = number else { continue };
            let identity = frame.get("identity").and_then(Value::as_str);
            if there.get(number) == Some(&true) && identity == identities.get(number).map(String::as_str) {
                let mut one = whole.clone();
                one["frames"] = json!([frame]);
                self.frames.insert(number, one);
            }
        }
    }
}

/// The file that keeps the measurements of a profile's frames until all are done.
pub fn partial(profile: &Path) -> PathBuf {
    let mut name = profile.as_os_str().to_owned();
    name.push(".partial");
    name.into()
}

/// The measurements' destination, and the file beside it that keeps one line per frame until all frames are done.
pub struct Journal {
    path: PathBuf,
    lines: PathBuf,
    file: File,
}

impl Journal {
    /// Begins or resumes: `there` marks the frames that exist, whose measurements are read back.
    ///
    /// # Errors
    /// The file of lines can't be read or written.
    pub fn open(path: &Path, identities: &[String], there: &[bool]) -> Result<(Self, FrameProfiles)> {
        let lines = partial(path);
        let mut measured = FrameProfiles::default();
        // Files that are not there, or of something else, hold nothing that is wanted.
        if let Ok(bytes) = fs::read(path)
            && let Ok(whole) = serde_json::from_slice(&bytes)
        {
            measured.absorb(whole, identities, there);
        }
        if let Ok(file) = File::open(&lines) {
            for line in BufReader::new(file).split(b'\n').map_while(Result::ok) {
                // The last line of a run that was killed may be cut.
                if let Ok(whole) = serde_json::from_slice(&line) {
                    measured.absorb(whole, identities, there);
                }
            }
        }
        output::write_atomically(&lines, |file| measured.frames.values().try_for_each(|one| writeln!(file, "{one}")))?;
        let file = OpenOptions::new().append(true).open(&lines).map_err(|source| failed(&lines, source))?;
        Ok((Self { path: path.to_owned(), lines, file }, measured))
    }

    /// Adds a line, at once.
    pub fn add(&mut self, one: &Value) -> Result<()> {
        let line = format!("{one}\n");
        self.file.write_all(line.as_bytes()).map_err(|source| failed(&self.lines, source))?;
        Ok(())
    }

    /// Writes the profile of all frames; the lines are no longer needed.
    pub fn finish(self, whole: &Value) -> Result<()> {
        output::write_atomically(&self.path, |file| writeln!(file, "{whole:#}"))?;
        drop(self.file);
        fs::remove_file(&self.lines).map_err(|source| failed(&self.lines, source))?;
        Ok(())
    }
}

fn failed(path: &Path, source: std::io::Error) -> output::Error {
    output::Error::Write { path: path.to_owned(), source }
}

fn camera_json(camera: &Camera) -> Value {
    let Camera { eye, up, forward, projection, near, far, .. } = camera;
    let (lens, value) = match projection {
        Projection::Perspective { fov_y } => ("fov_y", fov_y.to_degrees()),
        Projection::Orthographic { height } => ("height", *height),
    };
    json!({
        "eye": eye.to_array(),
        "forward": forward.to_array(),
        "up": up.to_array(),
        lens: value,
        "near": near,
        "far": far,
    })
}
