//! Request of a caller, as plain data: made once from arguments, keywords or the state of a window.

use pellucid_engine::Result;
use pellucid_engine::methods::{Factors, Stop};
use pellucid_io::output::Inputs;
use pellucid_scene::{Detail, Document, Input, MethodChoice, Named, Scene};

use crate::assembled::Wanted;
use crate::choice::Wish;
use crate::sources::Limits;

/// Everything that was requested of pictures of a scene.
#[derive(Debug, Clone)]
pub struct Request {
    /// Inputs as they were named, for metadata.
    pub name: String,
    /// All keys, with the requested view.
    pub scene: Scene,
    /// Place of the clouds.
    pub input: Input,
    /// Files that the scene was read from and names, none of which an output may replace.
    pub inputs: Inputs,
    /// Limits on reading the clouds.
    pub limits: Limits,
    /// Form in which points are wanted, with the seed of everything random.
    pub wanted: Wanted,
    /// Share of the light that is to get through.
    pub see_through: Option<SeeThrough>,
    /// `true` if an option gave all points one opacity, which may have been a guess.
    pub opacity_given: bool,
    /// Choice of the method by error or time.
    pub choice: ChoiceRequest,
    /// Properties of frames.
    pub frame: FrameRequest,
}

/// Share of the light that is to get through the median covered pixel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SeeThrough {
    /// Share from 0 to 1.
    pub share: f64,
    /// Source of the share.
    pub by: SeeThroughBy,
}

/// Source of a share of light.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SeeThroughBy {
    /// An option. Methods without opacity refuse it.
    Option,
    /// A preset. It counts for methods with opacity only.
    Preset,
    /// A preset that counts only where no point is classified.
    PresetWithoutClasses,
}

/// Choice of the method by what it must keep to.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct ChoiceRequest {
    /// Largest error and longest time.
    pub wish: Wish,
    /// Name of the only method that is allowed.
    pub only: Option<String>,
    /// `true` if earlier measurements are repeated.
    pub recalibrate: bool,
}

/// Properties of frames that are no keys of a scene.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct FrameRequest {
    /// Bytes of device memory in addition to cloud and image.
    pub memory_budget: Option<u64>,
    /// `true` if list lengths are counted.
    pub counts: bool,
    /// `true` if median and mean depths are wanted.
    pub depths: bool,
    /// Omissions that are allowed.
    pub stop: Stop,
    /// Factors on radii and opacities.
    pub factors: Factors,
    /// Standard error at which stochastic methods may end.
    pub max_error: Option<f32>,
    /// `true` if stochastic methods compute their standard error.
    pub spread: bool,
    /// Points that may be left out, in place of what the scene says.
    pub detail: Option<Detail>,
}

/// Returns the files that a scene was read from and names.
pub fn inputs(document: &Document) -> Inputs {
    Inputs::default().with(document.file()).with(document.named_files())
}

impl Request {
    /// Returns the request for pictures of a scene, exact to the last bit, on clouds that `limits` allow to read.
    ///
    /// # Errors
    /// Returns an error with line and column if a key is wrong.
    pub fn new(named: &Named, limits: Limits, seed: u64) -> Result<Self> {
        let request = Self::of_scene(named.name.clone(), named.document.scene()?, named.input.clone(), limits, seed);
        Ok(Self { inputs: inputs(&named.document), ..request })
    }

    /// Returns the request for pictures of a scene whose keys are already parsed. It has no [`inputs`](Self::inputs).
    pub fn of_scene(name: String, scene: Scene, input: Input, limits: Limits, seed: u64) -> Self {
        // Clouds of the caller stay where they are; whoever names files can have them read again.
        let is_edited = matches!(input, Input::Clouds(_));
        Self {
            name,
            scene,
            input,
            inputs: Inputs::default(),
            limits,
            wanted: Wanted { seed, legend: false, radii: false, is_edited },
            see_through: None,
            opacity_given: false,
            choice: ChoiceRequest::default(),
            frame: FrameRequest::default(),
        }
    }
}

impl SeeThrough {
    /// Returns the share that counts for a method, given if some points are classified.
    pub fn share(self, method: MethodChoice, is_classified: bool) -> Option<f64> {
        let has_opacity = || method.fixed().is_none_or(|method| method.family().has_opacity());
        let counts = match self.by {
            SeeThroughBy::Option => true,
            SeeThroughBy::Preset => has_opacity(),
            SeeThroughBy::PresetWithoutClasses => has_opacity() && !is_classified,
        };
        counts.then_some(self.share)
    }
}
