//! `pellucid render`.

use std::path::PathBuf;
use std::process::ExitCode;

use clap::Args;
use clap::builder::TypedValueParser;
use pellucid_session::area::Against;

use super::Error;
use super::along::PathArgs;
use super::console::Console;
use super::deep::DeepArgs;
use super::films::FilmArgs;
use super::headings::{FRAMES, METHOD, OUTPUT};
use super::input::InputArgs;
use super::job::{RenderJob, Target};
use super::options::{AGAINST, DeviceArgs, MeasureArgs, number, one_of};
use super::touched::{Touched, Touches};
use super::{measured, picture, sequence};
use crate::legend::LegendPlace;

#[derive(Debug, Args)]
pub struct RenderArgs {
    #[command(flatten)]
    pub input: InputArgs,
    #[command(flatten)]
    pub device: DeviceArgs,
    #[command(flatten)]
    pub measure: MeasureArgs,
    /// Picture to write: .png (8-bit sRGB) or .exr (32-bit float R, G, B, A, Z).
    ///
    /// Default: the name of the first input with .png, in the current folder. Z is the distance of the nearest surface
    /// along the viewing axis, in scene units, and +inf where no surface is. For a PNG the methods sorted and abuffer
    /// blend until no 8-bit value would change by more than a quarter of a step, for an EXR until no bit would change.
    ///
    /// With --path or --turntable also a film or an animation: .mp4 (H.264) and .webm (VP9), which need the program
    /// ffmpeg, .gif, or .apng.
    #[arg(short, long, value_name = "OUT")]
    pub output: Option<PathBuf>,
    /// EXR: add channels of list lengths, layers, errors and depths
    ///
    /// - `fragments.Y`: length of each pixel's fragment list.
    /// - `layers.Y`: blended layers (peel, peel-layers).
    /// - `stderr.R`, `stderr.G`, `stderr.B`: standard error of the color (stochastic, spbr, spbr-simplified).
    /// - `depth.median`: depth at which half of the light is left, or +inf if more passes.
    /// - `depth.mean`: mean depth of the fragments, weighted by their share of A, or +inf.
    ///
    /// The two depths need abuffer, linked-list, peel of all layers, or sorted with flat discs.
    /// Each takes as long as another picture.
    #[arg(long, help_heading = OUTPUT, verbatim_doc_comment)]
    pub aov: bool,
    /// PNG: write straight alpha instead of the background.
    ///
    /// An EXR always has both: R, G, B over the background, and A.
    #[arg(long, help_heading = OUTPUT)]
    pub transparent: bool,
    /// PNG: draw a legend of the colors, and a scale bar if the camera is orthographic.
    ///
    /// The legend is a color bar with values, or a list of the classes in the picture, in the lower left corner. With
    /// --legend=beside it stands in a column to the right, by which the file becomes wider than --size. In a small
    /// picture it has smaller letters; where even those don't fit, it is left out.
    #[arg(
        long, value_name = "PLACE", help_heading = OUTPUT,
        num_args = 0..=1, require_equals = true, default_missing_value = "over", value_enum,
    )]
    pub legend: Option<LegendPlace>,
    /// Number of frames for --path or --turntable; without a number a time series.
    ///
    /// Frames count from 0. Unless the output is a film, its name needs a number, as in frame_%04d.png (default: the
    /// name of the first input with _%04d.png). Existing frames of the same scene, path and settings are not rendered
    /// again.
    ///
    /// Without a number the option stands behind the inputs, or before another option. A time series is a picture of
    /// the first cloud of the scene, one of the first two, and so on, all with the camera that shows the whole scene.
    /// Pictures count from 1, as in step_%02d.png (default: the name of the first input with _%02d.png).
    #[arg(long, value_name = "N", num_args = 0..=1, value_parser = number_of_frames, help_heading = FRAMES)]
    pub frames: Option<Option<u32>>,
    #[command(flatten)]
    pub along: PathArgs,
    #[command(flatten)]
    pub films: FilmArgs,
    /// With --path or --turntable: write how the error changes from frame to frame.
    ///
    /// Every frame is also rendered by the exact method: abuffer (for Gaussians with order = "pixel"), or soft-base for
    /// soft spheres. Each line of the table has the RMSE of a frame, and RMSE and FLIP of the change of its error since
    /// the previous frame, on linear R, G, B over the background. Existing frames are rendered again but not written.
    #[arg(long, value_name = "FILE.csv", help_heading = FRAMES)]
    pub popping: Option<PathBuf>,
    /// With --path or --turntable: replace frames of another sequence.
    #[arg(long, help_heading = FRAMES)]
    pub overwrite: bool,
    #[command(flatten)]
    pub choice: ChoiceArgs,
    #[command(flatten)]
    pub deep: DeepArgs,
}

/// Largest number of frames.
const MOST_FRAMES: u32 = 100_000;

/// The method by what it must keep to.
#[derive(Debug, Clone, Copy, Args)]
pub struct ChoiceArgs {
    /// Take the fastest method and settings with an RMSE of at most E on this image.
    ///
    /// The RMSE is measured on linear R, G, B over the background, against abuffer, against soft-base for soft spheres,
    /// or against the limit of many ensembles for spbr. With --method only the settings of that method are tried. The
    /// method of a scene file only selects the kind of discs.
    #[arg(long, value_name = "E", value_parser = not_negative(), help_heading = METHOD)]
    pub max_error: Option<f64>,
    /// Take the most accurate method and settings with a frame time of at most MS.
    ///
    /// The time in milliseconds is the measured median on the device, as in `pellucid tradeoff`. If nothing is fast
    /// enough, the fastest is taken. --max-error has priority; a warning tells if the time is then exceeded.
    #[arg(long, value_name = "MS", value_parser = not_negative(), help_heading = METHOD)]
    pub budget: Option<f64>,
    /// With --max-error or --budget: the picture that errors are measured against, center or area.
    ///
    /// center: the exact picture with the scene's samples, by default the center of each pixel. area: the exact picture
    /// with 64 samples of each pixel's area. The choice is then one of a method, its settings and 1 to 32 samples, in
    /// place of --samples, and its error counts both what the method and what the samples leave.
    #[arg(long, value_name = "PICTURE", default_value = "center", value_parser = one_of(AGAINST), help_heading = METHOD)]
    pub against: Against,
    /// With --max-error or --budget: repeat measurements already known for this scene and device.
    #[arg(long, help_heading = METHOD)]
    pub recalibrate: bool,
}

fn number_of_frames(text: &str) -> Result<u32, String> {
    let number: Option<u32> = text.parse().ok().filter(|number| (1..=MOST_FRAMES).contains(number));
    number.ok_or_else(|| {
        format!(
            "expected a number of frames from 1 to {MOST_FRAMES}; for a time series --frames stands behind the inputs, as in \
             `pellucid render scene.toml --frames`"
        )
    })
}

fn not_negative() -> impl TypedValueParser<Value = f64> {
    number(|x| *x >= 0.0, "expected a number from 0")
}

impl ChoiceArgs {
    /// True if the method is chosen by what it must keep to.
    pub fn is_given(&self) -> bool {
        self.max_error.is_some() || self.budget.is_some() || self.recalibrate || self.against != Against::Center
    }
}

impl Touches for RenderArgs {
    fn touched(&self) -> pellucid_engine::Result<Touched> {
        let target = Target::named(self)?;
        let touched = Touched::reads(self.along.reads(&self.input)).and(target.writes()).and(self.measure.writes());
        let partial = self.measure.profile.as_deref().filter(|_| matches!(target, Target::Frames(..)));
        let partial = partial.map(measured::partial);
        Ok(touched.writes("--popping", self.popping.as_deref()).writes("--profile", partial.as_deref()))
    }
}

pub fn run(args: RenderArgs, console: Console) -> Result<ExitCode, Error> {
    let target = Target::new(&args)?;
    target.check(&args, console)?;
    let progress = console.progress();
    let job = RenderJob::new(args, target, &progress)?;
    if let (Target::Frames(pattern, films), Some(along)) = (&job.target, &job.along) {
        return sequence::run(&job, along, (pattern, films), &progress);
    }
    let profile = match &job.target {
        Target::One(output) => picture::one(&job, output, &progress)?,
        Target::Steps(pattern) | Target::Frames(pattern, _) => Some(picture::steps(&job, pattern, &progress)?),
    };
    if let Some(profile) = profile {
        console.detail(profile.host_text());
        job.args.measure.write(&profile.to_json(), || profile.to_trace())?;
    }
    Ok(ExitCode::SUCCESS)
}
