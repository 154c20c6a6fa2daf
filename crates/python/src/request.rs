//! Request of a caller beside the points.

use pellucid_engine::methods::{Factors, Stop};
use pellucid_io as io;
use pellucid_scene::{Document, Input, Method, Overrides, Scene, View, ViewName};
use pellucid_session::area::Against;
use pellucid_session::choice::Wish;
use pellucid_session::{ChoiceRequest, FrameRequest, Limits, Request, Residence, SeeThrough, SeeThroughBy};
use pyo3::prelude::*;

use crate::failure::Failure;

/// Changes of keys, like the options of the command line: the option as errors name it, the dotted key, the value as
/// TOML, and `true` if it is appended to an array.
pub type Changes = Vec<(String, String, String, bool)>;

/// Removes whole tables from a document, then applies changes to it.
pub fn lay_over(document: &mut Document, drop: &[String], changes: &Changes) -> Result<Scene, Failure> {
    let mut overrides = Overrides::default();
    for (option, key, text, appended) in changes {
        match appended {
            true => overrides.append(option, key, text)?,
            false => overrides.set(option, key, text)?,
        }
    }
    drop.iter().for_each(|table| document.remove("", table));
    Ok(document.lay_over(&overrides)?)
}

/// Direction from which a scene is framed.
#[derive(FromPyObject, Default)]
#[pyo3(from_item_all)]
pub struct Direction {
    view: Option<String>,
    azimuth: Option<f64>,
    elevation: Option<f64>,
}

impl Direction {
    pub fn view(&self) -> Result<View, Failure> {
        let name = self.view.as_ref().map(|word| {
            ViewName::named(word).ok_or_else(|| {
                let all: Vec<_> = ViewName::ALL.iter().map(|(_, word, _)| *word).collect();
                Failure::Value(format!("view: expected one of {}, found {word:?}", all.join(", ")))
            })
        });
        if let Some(azimuth) = self.azimuth.filter(|degrees| !degrees.is_finite()) {
            return Err(Failure::Value(format!("azimuth: expected a number of degrees, found {azimuth}")));
        }
        if let Some(elevation) = self.elevation.filter(|degrees| !(-90.0..=90.0).contains(degrees)) {
            return Err(Failure::Value(format!("elevation: expected degrees from -90 to 90, found {elevation}")));
        }
        Ok(View { name: name.transpose()?, azimuth: self.azimuth, elevation: self.elevation })
    }
}

/// Request for a frame.
#[derive(FromPyObject, Clone)]
#[pyo3(from_item_all)]
pub struct Ask {
    pub drop: Vec<String>,
    pub changes: Changes,
    /// `false` if a camera was given in place of the view that frames the scene.
    framed: bool,
    fragments: bool,
    depths: bool,
    eight_bit: bool,
    memory_budget: Option<u64>,
    opacity_factor: f32,
    radius_factor: f32,
    seed: Option<u64>,
    /// Share of light that is to get through the median covered pixel, from 0 to 1.
    pub see_through: Option<f64>,
    max_error: Option<f64>,
    budget_ms: Option<f64>,
    /// Word for the picture that errors are measured against.
    against: Option<String>,
    /// Host memory for points, in bytes; beyond it they stay in their files.
    host_memory: Option<u64>,
}

impl Ask {
    /// Returns the same request with counted lists.
    pub fn with_fragments(self) -> Self {
        Self { fragments: true, ..self }
    }

    /// Returns the request for frames of a scene, whose keys with these changes are `parsed`.
    ///
    /// # Errors
    /// Returns an error if there is less memory for points than a reader needs.
    pub fn request(
        &self,
        (name, input): (String, Input),
        (view, seed): (View, u64),
        parsed: Scene,
    ) -> Result<Request, Failure> {
        let limits = Limits { memory: self.host_memory()?, residence: Residence::Levels };
        let seed = self.seed.unwrap_or(seed);
        let mut request = Request::of_scene(name, parsed, input, limits, seed);
        if self.framed {
            request.scene.camera.view = view;
        }
        request.see_through = self.see_through.map(|share| SeeThrough { share, by: SeeThroughBy::Option });
        request.opacity_given =
            self.changes.iter().any(|(option, ..)| ["opacity", "surface_opacity"].contains(&option.as_str()));
        request.choice = ChoiceRequest {
            wish: Wish { max_error: self.max_error, budget_ms: self.budget_ms, against: self.against() },
            only: request.scene.method.fixed().map(|method| Method::name(method).to_owned()),
            recalibrate: false,
        };
        request.frame = FrameRequest {
            memory_budget: self.memory_budget,
            counts: self.fragments,
            depths: self.depths,
            stop: if self.eight_bit { Stop::EightBit { transparent: false } } else { Stop::Exact },
            factors: Factors { radius: self.radius_factor, opacity: self.opacity_factor },
            ..FrameRequest::default()
        };
        Ok(request)
    }

    /// Returns the picture that errors are measured against; [`Self::check`] refuses other words.
    fn against(&self) -> Against {
        self.against.as_deref().and_then(Against::from_word).unwrap_or_default()
    }

    /// Returns the host memory that points may take, in bytes.
    fn host_memory(&self) -> Result<u64, Failure> {
        let least = io::LEAST_MEMORY;
        match self.host_memory {
            Some(bytes) if bytes < least => {
                Err(Failure::Value(format!("host_memory: expected at least {least} bytes, found {bytes}")))
            }
            Some(bytes) => Ok(bytes),
            None => Ok(io::memory_for_points()),
        }
    }

    /// # Errors
    /// Returns an error for a number that makes no sense.
    pub fn check(&self) -> Result<(), Failure> {
        let not_negative = |x: f64| x >= 0.0 && x.is_finite();
        let numbers = [
            ("opacity_factor", Some(f64::from(self.opacity_factor))),
            ("radius_factor", Some(f64::from(self.radius_factor))),
            ("max_error", self.max_error),
            ("budget_ms", self.budget_ms),
        ];
        for (name, value) in numbers {
            if let Some(value) = value.filter(|value| !not_negative(*value)) {
                return Err(Failure::Value(format!("{name}: expected a finite number of at least 0, found {value}")));
            }
        }
        if let Some(word) = self.against.as_ref().filter(|word| Against::from_word(word).is_none()) {
            return Err(Failure::Value(format!("against: expected \"center\" or \"area\", found {word:?}")));
        }
        match self.see_through.filter(|share| !(0.0..=1.0).contains(share)) {
            Some(share) => Err(Failure::Value(format!("see_through: expected a share from 0 to 1, found {share}"))),
            None => Ok(()),
        }
    }
}
