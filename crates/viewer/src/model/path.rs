//! The path of key frames: actions of the window's buttons and keys.

use std::path::PathBuf;

use super::{Model, Pose};
use crate::navigate::{CameraSubject, Navigator, settings_of};
use crate::route::Route;
use pellucid_core::camera::import::CameraSource;
use pellucid_core::camera::path::{Defaults, Key, Problem, Turntable};
use pellucid_scene::{CameraSettings, DEFAULT_FOV_Y, camera_at, path_defaults};

/// Keys of a turntable, θ = 22.5° apart. About what is in the middle of the picture the curve through them is a circle;
/// about another point it leaves that by at most 1 − cos(θ/2) − sin θ·sin(θ/2)/4 = 6·10⁻⁴ of its radius, half way
/// between two keys of a Catmull-Rom spline.
const TURN: usize = 16;

/// Cosine of the angle between the vertical and an `up` below which that turns with a turntable.
const UPRIGHT: f64 = 0.99;

/// Seconds that a turntable takes from key to key.
const TURN_PACE: f64 = 1.0;

impl Model {
    /// The extent of the scene, once a picture of it has arrived.
    fn subject(&self) -> Option<CameraSubject> {
        self.navigator.map(|navigator| navigator.subject()).or(self.picture.as_ref().map(|picture| picture.subject))
    }

    /// Values for keys that leave them open, as `render --path` chooses them.
    fn defaults(&self) -> Option<Defaults> {
        Some(path_defaults(&self.scene.camera, self.subject()?.up))
    }

    /// The present camera as a key. Its depths are left to the scene.
    fn key(&self) -> Option<Key> {
        let shown = match self.pose {
            Pose::At(camera) => camera,
            _ => self.navigator?.settings(None, None),
        };
        Some(key_of(&shown))
    }

    /// Changes the route; a change that makes no valid path becomes a message.
    pub fn change_route(&mut self, change: impl FnOnce(&mut Route, &Defaults) -> Result<(), Problem>) -> bool {
        let Some(defaults) = self.defaults() else {
            self.show_note("nothing is shown yet");
            return false;
        };
        let before = self.route.at_rest();
        match change(&mut self.route, &defaults) {
            Ok(()) => {
                self.message = None;
                self.record_route(before);
            }
            Err(problem) => self.show_error(problem.to_string()),
        }
        self.message.is_none()
    }

    /// Makes the present camera a key behind the one that is selected, or at the end.
    pub fn add_key(&mut self) {
        let Some(key) = self.key() else { return self.show_note("no picture yet to take a key from") };
        if self.change_route(|route, defaults| route.add(key, defaults)) {
            self.go_to_key(self.route.selected().unwrap_or(0));
        }
    }

    /// Puts the present camera in the place of the selected key.
    pub fn replace_key(&mut self) {
        if let Some(key) = self.key()
            && self.change_route(|route, defaults| route.replace(key, defaults))
            && let Some(selected) = self.route.selected()
        {
            self.go_to_key(selected);
        }
    }

    /// Takes the selected key out.
    pub fn delete_key(&mut self) {
        self.change_route(Route::delete);
    }

    /// Moves the selected key one place back or ahead.
    pub fn shift_key(&mut self, back: bool) {
        self.change_route(|route, defaults| route.shift(back, defaults));
    }

    /// Fills the path with a turn of the present camera about the vertical through the pivot.
    pub fn fill_turntable(&mut self) {
        let (Some(navigator), Some(first)) = (self.navigator, self.key()) else { return };
        let subject = navigator.subject();
        let Some(settings) = self.look_of(&first) else { return };
        let Some(camera) = camera_at(&settings, &subject.bounds, subject.radius) else { return };
        let (pivot, vertical) = (navigator.pivot(), navigator.vertical());
        let turn = Turntable::new(&camera, pivot, vertical).frames(TURN);
        let (Some(target), Some(up)) = (settings.target, settings.up) else { return };
        let reach = (target - camera.eye).length();
        let keys = turn.iter().enumerate().map(|(at, pose)| match at {
            0 => first.clone(),
            _ => Key {
                eye: pose.eye.to_array(),
                target: Some((pose.eye + pose.forward * reach).to_array()),
                // Straight views turn with the picture's top, all others keep their horizon.
                up: Some(if up.normalize_or_zero().dot(vertical) > UPRIGHT { up } else { pose.up }.to_array()),
                ..first.clone()
            },
        });
        let keys = keys.collect();
        if self.change_route(|route, defaults| route.fill(keys, defaults)) {
            self.edit_route(|route| route.set_pace(TURN_PACE));
            self.go_to_key(0);
        }
    }

    /// The camera of a key with a target: its own numbers, so that the picture is that of `render --path`.
    fn look_of(&self, key: &Key) -> Option<CameraSettings> {
        let target = key.target?.into();
        let (scene, defaults) = (&self.scene.camera, self.defaults()?);
        let (fov_y, height) = match (key.fov_y, key.height) {
            (None, None) if scene.height.is_some() => (None, scene.height),
            (None, None) => (Some(scene.fov_y.unwrap_or(DEFAULT_FOV_Y)), None),
            own => own,
        };
        Some(CameraSettings {
            eye: Some(key.eye.into()),
            target: Some(target),
            up: Some(key.up.map_or(defaults.up, Into::into)),
            fov_y,
            height,
            near: key.near.or(scene.near),
            far: key.far.or(scene.far),
            ..CameraSettings::default()
        })
    }

    /// Selects a key, from 0, and looks from there.
    pub fn go_to_key(&mut self, at: usize) {
        let (Some(defaults), Some(subject)) = (self.defaults(), self.subject()) else { return };
        match self.route.select(at, &defaults) {
            Ok(pose) => {
                let own = self.route.keys().get(at).and_then(|key| self.look_of(key));
                if let Some(settings) = own.or(pose.map(|pose| settings_of(&pose, &subject))) {
                    self.go(settings);
                }
            }
            Err(problem) => self.show_error(problem.to_string()),
        }
    }

    /// Goes to a place on the path, in seconds from its first key.
    pub fn seek(&mut self, position: f64) {
        self.route.stop();
        self.run_route(|route, defaults| route.seek(position, defaults));
    }

    /// Lets the camera run along the path, or stops it.
    pub fn play(&mut self) {
        if self.route.is_playing() {
            self.route.stop();
        } else if self.route.keys().len() < 2 {
            self.show_note("a path needs two keys: press K to add the current camera");
        } else {
            self.route.play();
        }
    }

    /// Runs on for some seconds, if the camera runs.
    pub fn tick(&mut self, seconds: f64) {
        self.run_route(|route, defaults| route.advance(seconds, defaults));
    }

    fn run_route(
        &mut self,
        step: impl FnOnce(&mut Route, &Defaults) -> Result<Option<pellucid_core::camera::path::Pose>, Problem>,
    ) {
        let (Some(defaults), Some(subject)) = (self.defaults(), self.subject()) else { return };
        match step(&mut self.route, &defaults) {
            Ok(Some(pose)) => {
                let near_far = (pose.near.or(self.scene.camera.near), pose.far.or(self.scene.camera.far));
                self.go(CameraSettings { near: near_far.0, far: near_far.1, ..settings_of(&pose, &subject) });
            }
            Ok(None) => {}
            Err(problem) => self.show_error(problem.to_string()),
        }
    }

    /// Looks from a place, as something that moves.
    fn go(&mut self, settings: CameraSettings) {
        let Some(subject) = self.subject() else { return };
        match Navigator::at(&settings, subject) {
            Some(navigator) => {
                self.navigator = Some(navigator);
                self.flatten = false;
                if self.pose != Pose::At(settings) {
                    self.pose = Pose::At(settings);
                    self.touch();
                }
            }
            None => self.show_error("this key is not a valid camera: it is too far away, or near is not less than far"),
        }
    }

    /// Takes in a file of cameras, as soon as a picture exists: its size and vertical may be needed.
    pub fn take_path(&mut self, file: PathBuf, source: CameraSource) {
        self.arriving = Some((file, source));
        self.receive_path();
    }

    pub(super) fn receive_path(&mut self) {
        if self.navigator.is_none() || self.viewport.size.contains(&0) {
            return;
        }
        let Some((file, source)) = self.arriving.take() else { return };
        let path = source.path(self.viewport.size);
        let (count, name) = (path.keys.len(), file.display());
        let mut text = format!("{name}: {count} key{}", if count == 1 { "" } else { "s" });
        source.warnings().iter().for_each(|warning| text += &format!("; {warning}"));
        let warned = !source.warnings().is_empty();
        if self.change_route(|route, defaults| route.load(path, defaults)) {
            self.go_to_key(0);
            self.message = Some((text, warned));
        } else if let Some((problem, _)) = &mut self.message {
            *problem = format!("{name}: {problem}");
        }
    }

    /// Writes the path, and the scene that it leads through, into the current folder.
    pub fn save_path(&mut self) {
        if self.route.keys().is_empty() {
            return self.show_note("no keys yet: press K to add the current camera");
        }
        if self.viewport.size.contains(&0) {
            return self.show_error("the window has no room for a picture, and a path needs its size");
        }
        // With the scene's own camera: it supplies what keys leave open.
        let path = Some(self.route.path(self.viewport.size));
        self.ask_to_save(self.document_of_size(), false, path, None);
    }
}

/// A key with the numbers of a camera.
fn key_of(camera: &CameraSettings) -> Key {
    let eye = camera.eye.unwrap_or_default().to_array();
    Key {
        target: camera.target.map(|target| target.to_array()),
        up: camera.up.map(|up| up.to_array()),
        fov_y: camera.fov_y,
        height: camera.height,
        ..Key::at(eye)
    }
}
