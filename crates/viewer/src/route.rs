//! Key frames that are made in the window, and the motion through them. No window, no device, no clock.

use pellucid_core::camera::path::{CameraPath, Curve, Defaults, Key, Pose, Problem};

/// Seconds from key to key, of a path whose keys have no times.
const PACE: f64 = 2.0;

/// Frames of a second in the command that renders a path.
const RATE: u32 = 25;

/// Keys with the selected one, and the camera's position between them.
///
/// A change that makes no valid path is refused, and nothing changes.
#[derive(Debug, Clone)]
pub struct Route {
    /// The path; its size is that of a file.
    path: CameraPath,
    selected: Option<usize>,
    /// Seconds from key to key without times.
    pace: f64,
    rate: u32,
    /// Seconds from the first key.
    position: f64,
    playing: bool,
    /// The motion through the keys as they are, once it was needed.
    curve: Option<Curve>,
}

impl Default for Route {
    fn default() -> Self {
        Self {
            path: CameraPath::new(Vec::new()),
            selected: None,
            pace: PACE,
            rate: RATE,
            position: 0.0,
            playing: false,
            curve: None,
        }
    }
}

impl Route {
    /// The keys in their order.
    pub fn keys(&self) -> &[Key] {
        &self.path.keys
    }

    /// The key that is selected, from 0.
    pub fn selected(&self) -> Option<usize> {
        self.selected
    }

    /// True if the camera returns from the last key to the first.
    pub fn is_closed(&self) -> bool {
        self.path.closed
    }

    /// True if each key has its own time, in seconds.
    pub fn is_timed(&self) -> bool {
        self.keys().first().is_some_and(|key| key.time.is_some())
    }

    /// True while the camera runs.
    pub fn is_playing(&self) -> bool {
        self.playing
    }

    /// Seconds from the first key.
    pub fn position(&self) -> f64 {
        self.position
    }

    /// Seconds from key to key where these have no times, above 0.
    pub fn pace(&self) -> f64 {
        self.pace
    }

    /// Sets [`Route::pace`]; the camera stays where it is.
    pub fn set_pace(&mut self, seconds: f64) {
        if seconds.is_finite() && seconds > 0.0 {
            if !self.is_timed() {
                self.position *= seconds / self.pace;
            }
            self.pace = seconds;
        }
    }

    /// Frames of a second in the command that renders the path, at least 1.
    pub fn rate(&self) -> u32 {
        self.rate
    }

    /// Sets [`Route::rate`].
    pub fn set_rate(&mut self, rate: u32) {
        self.rate = rate.max(1);
    }

    /// Seconds from the first key to the last one, or back to the first.
    pub fn duration(&self) -> f64 {
        let [first, last] = self.ends();
        (last - first) * self.scale()
    }

    /// The number of frames of the path at [`Route::rate`]; an open path includes both ends.
    pub fn frames(&self) -> u32 {
        let steps = (self.duration() * f64::from(self.rate)).round().clamp(1.0, 1e6) as u32;
        if self.is_open() { steps + 1 } else { steps }
    }

    fn is_open(&self) -> bool {
        !self.path.closed || self.keys().len() < 2
    }

    /// Seconds of a unit of the keys' times.
    fn scale(&self) -> f64 {
        if self.is_timed() { 1.0 } else { self.pace }
    }

    /// The times of the path's ends, in its own units.
    fn ends(&self) -> [f64; 2] {
        let count = self.keys().len();
        let time = |at: usize| self.keys().get(at).and_then(|key| key.time).unwrap_or(at as f64);
        let (first, last) = (time(0), time(count.saturating_sub(1)));
        // The way back takes as long as between two others on average.
        let back = if self.is_open() { 0.0 } else { (last - first) / (count - 1) as f64 };
        [first, last + back]
    }

    /// Returns the path without its motion, not running.
    pub fn at_rest(&self) -> Self {
        Self { playing: false, curve: None, ..self.clone() }
    }

    /// True if keys, times or their order are others than in a path; the selected key and the position don't count.
    pub fn differs(&self, other: &Self) -> bool {
        self.path != other.path || self.pace != other.pace || self.rate != other.rate
    }

    /// The path as a file holds it; `size` is that of the pictures if no file said one.
    pub fn path(&self, size: [u32; 2]) -> CameraPath {
        CameraPath { size: self.path.size.or(Some(size)), ..self.path.clone() }
    }

    /// Takes the keys of a file.
    ///
    /// # Errors
    /// The keys make no valid path in a scene with these defaults.
    pub fn load(&mut self, path: CameraPath, defaults: &Defaults) -> Result<(), Problem> {
        let (curve, pace, rate) = (Some(Curve::new(&path, defaults)?), self.pace, self.rate);
        *self = Self { path, curve, selected: Some(0), pace, rate, ..Self::default() };
        Ok(())
    }

    /// Puts a key behind the selected one, or at the end, and selects it.
    ///
    /// # Errors
    /// A key that makes no path with the others.
    pub fn add(&mut self, key: Key, defaults: &Defaults) -> Result<(), Problem> {
        let at = self.selected.map_or(self.keys().len(), |selected| selected + 1);
        let time = self.is_timed().then(|| self.time_at(at));
        let mut path = self.path.clone();
        path.keys.insert(at, Key { time, ..key });
        self.change(path, Some(at), defaults)
    }

    /// A time for a key before number `at`: in the middle, or as far behind the last as those are apart on average.
    fn time_at(&self, at: usize) -> f64 {
        let time = |at: usize| self.keys().get(at).and_then(|key| key.time);
        let before = at.checked_sub(1).and_then(time).unwrap_or(0.0);
        match (time(at), self.keys().len()) {
            (Some(after), _) => 0.5 * (before + after),
            (None, 0 | 1) => before + self.pace,
            (None, count) => before + (before - time(0).unwrap_or(before)) / (count - 1) as f64,
        }
    }

    /// Puts another camera in the place of the selected key, at its time.
    ///
    /// # Errors
    /// A key that makes no path with the others.
    pub fn replace(&mut self, key: Key, defaults: &Defaults) -> Result<(), Problem> {
        let Some(at) = self.selected else { return Ok(()) };
        let mut path = self.path.clone();
        if let Some(old) = path.keys.get_mut(at) {
            *old = Key { time: old.time, ..key };
        }
        self.change(path, Some(at), defaults)
    }

    /// Takes the selected key out; the next one is selected then, or the last.
    ///
    /// # Errors
    /// None that a path without the key had not before.
    pub fn delete(&mut self, defaults: &Defaults) -> Result<(), Problem> {
        let Some(at) = self.selected.filter(|at| *at < self.keys().len()) else { return Ok(()) };
        let mut path = self.path.clone();
        path.keys.remove(at);
        let selected = path.keys.len().checked_sub(1).map(|last| at.min(last));
        self.change(path, selected, defaults)
    }

    /// Changes the places of the selected key and the one before it, or behind it; times stay where they are.
    ///
    /// # Errors
    /// None: the same keys in another order make a path.
    pub fn shift(&mut self, back: bool, defaults: &Defaults) -> Result<(), Problem> {
        let Some(at) = self.selected else { return Ok(()) };
        let other = if back { at.checked_sub(1) } else { Some(at + 1) };
        let Some(other) = other.filter(|other| *other < self.keys().len()) else { return Ok(()) };
        let mut path = self.path.clone();
        path.keys.swap(at, other);
        for (key, old) in path.keys.iter_mut().zip(&self.path.keys) {
            key.time = old.time;
        }
        self.change(path, Some(other), defaults)
    }

    /// Lets the path go back to its first key, or not.
    ///
    /// # Errors
    /// None: a path can be either.
    pub fn set_closed(&mut self, closed: bool, defaults: &Defaults) -> Result<(), Problem> {
        self.change(CameraPath { closed, ..self.path.clone() }, self.selected, defaults)
    }

    /// Gives each key a time, as far apart as they are now, or takes times away.
    ///
    /// # Errors
    /// None: times that ascend make a path.
    pub fn set_timed(&mut self, timed: bool, defaults: &Defaults) -> Result<(), Problem> {
        let mut path = self.path.clone();
        for (at, key) in path.keys.iter_mut().enumerate() {
            key.time = timed.then(|| key.time.unwrap_or(at as f64 * self.pace));
        }
        self.change(path, self.selected, defaults)
    }

    /// Sets the time of a key in seconds.
    ///
    /// # Errors
    /// A time that is not between those of its neighbors.
    pub fn set_time(&mut self, at: usize, time: f64, defaults: &Defaults) -> Result<(), Problem> {
        let mut path = self.path.clone();
        if let Some(key) = path.keys.get_mut(at) {
            key.time = Some(time);
        }
        self.change(path, self.selected, defaults)
    }

    /// Replaces all keys by those of a closed path, and selects the first.
    ///
    /// # Errors
    /// The keys make no valid path.
    pub fn fill(&mut self, keys: Vec<Key>, defaults: &Defaults) -> Result<(), Problem> {
        self.change(CameraPath { keys, closed: true, ..self.path.clone() }, Some(0), defaults)
    }

    /// Takes all keys out.
    pub fn clear(&mut self) {
        let (pace, rate) = (self.pace, self.rate);
        *self = Self { pace, rate, ..Self::default() };
    }

    /// Takes these keys if they make a path.
    fn change(&mut self, path: CameraPath, selected: Option<usize>, defaults: &Defaults) -> Result<(), Problem> {
        self.curve = if path.keys.is_empty() { None } else { Some(Curve::new(&path, defaults)?) };
        (self.path, self.selected) = (path, selected);
        self.playing = false;
        self.position = self.position.min(self.duration());
        Ok(())
    }

    /// Forgets the motion, since the scene gives other defaults.
    pub fn invalidate(&mut self) {
        self.curve = None;
        self.playing = false;
    }

    /// Selects a key and moves the camera there; returns the camera.
    ///
    /// # Errors
    /// The keys make no valid path in a scene with these defaults.
    pub fn select(&mut self, at: usize, defaults: &Defaults) -> Result<Option<Pose>, Problem> {
        let Some(key) = self.keys().get(at) else { return Ok(None) };
        let time = key.time.unwrap_or(at as f64);
        self.selected = Some(at);
        self.playing = false;
        self.position = (time - self.ends()[0]) * self.scale();
        Ok(self.motion(defaults)?.map(|curve| curve.at(time)))
    }

    /// Moves to a position on the path, in seconds from its first key; returns the camera there.
    ///
    /// # Errors
    /// The keys make no valid path in a scene with these defaults.
    pub fn seek(&mut self, position: f64, defaults: &Defaults) -> Result<Option<Pose>, Problem> {
        let duration = self.duration();
        self.position = if position.is_finite() { position.clamp(0.0, duration) } else { 0.0 };
        // The end itself, without the rounding of what leads there.
        let [first, last] = self.ends();
        let time = if self.position >= duration { last } else { first + self.position / self.scale() };
        Ok(self.motion(defaults)?.map(|curve| curve.at(time)))
    }

    fn motion(&mut self, defaults: &Defaults) -> Result<Option<&Curve>, Problem> {
        if self.curve.is_none() && !self.keys().is_empty() {
            self.curve = Some(Curve::new(&self.path, defaults)?);
        }
        Ok(self.curve.as_ref())
    }

    /// Lets the camera run from where it is; from the end of an open path from its beginning.
    pub fn play(&mut self) {
        let duration = self.duration();
        self.playing = duration > 0.0;
        if self.position >= duration {
            self.position = 0.0;
        }
    }

    /// The camera stays where it is.
    pub fn stop(&mut self) {
        self.playing = false;
    }

    /// Continues by some seconds; returns the camera there while it runs. An open path ends at its last key.
    ///
    /// # Errors
    /// The keys make no valid path in a scene with these defaults.
    pub fn advance(&mut self, seconds: f64, defaults: &Defaults) -> Result<Option<Pose>, Problem> {
        if !self.playing {
            return Ok(None);
        }
        let (duration, position) = (self.duration(), self.position + seconds.max(0.0));
        let ended = self.is_open() && position >= duration;
        let pose = self.seek(if self.is_open() { position } else { position.rem_euclid(duration) }, defaults);
        self.playing = pose.is_ok() && !ended;
        pose
    }
}

#[cfg(test)]
mod tests;
