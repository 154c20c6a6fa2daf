//! `pellucid render`.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use super::bar::Bar;
use clap::Args;
use pellucid_engine::Result;
use pellucid_engine::methods::{Rendered, Stop};
use pellucid_engine::output::{self, WriteOptions};
use pellucid_engine::profile::Profile;
use pellucid_engine::scene::Error;
use pellucid_session::choice::Wish;
use pellucid_session::{Clouds, FrameRequest, Opened, Prepared, Request, Session, Silent};

use super::along::PathArgs;
use super::console::Console;
use super::deep::{self, DeepArgs};
use super::films::{Asked, FilmArgs, Films};
use super::frames::{Naming, Pattern};
use super::headings::{FRAMES, METHOD, OUTPUT};
use super::input::InputArgs;
use super::limit::usage;
use super::sequence;
use super::session;
use super::tradeoff::IN_FILES;
use super::{DeviceArgs, MeasureArgs};
use crate::legend;

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
    output: Option<PathBuf>,
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
    /// The legend is a color bar with values, or a list of the classes in the picture, in the lower left corner.
    #[arg(long, help_heading = OUTPUT)]
    legend: bool,
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
    frames: Option<Option<u32>>,
    #[command(flatten)]
    along: PathArgs,
    #[command(flatten)]
    films: FilmArgs,
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
    choice: ChoiceArgs,
    #[command(flatten)]
    pub deep: DeepArgs,
}

/// Largest number of frames.
const MOST_FRAMES: u32 = 100_000;

/// The method by what it must keep to.
#[derive(Debug, Args)]
struct ChoiceArgs {
    /// Take the fastest method and settings with an RMSE of at most E on this image.
    ///
    /// The RMSE is measured on linear R, G, B over the background, against abuffer, against soft-base for soft spheres,
    /// or against the limit of many ensembles for spbr. With --method only the settings of that method are tried. The
    /// method of a scene file only selects the kind of discs.
    #[arg(long, value_name = "E", value_parser = not_negative, help_heading = METHOD)]
    max_error: Option<f64>,
    /// Take the most accurate method and settings with a frame time of at most MS.
    ///
    /// The time in milliseconds is the measured median on the device, as in `pellucid tradeoff`. If nothing is fast
    /// enough, the fastest is taken. --max-error has priority; a warning tells if the time is then exceeded.
    #[arg(long, value_name = "MS", value_parser = not_negative, help_heading = METHOD)]
    budget: Option<f64>,
    /// With --max-error or --budget: repeat measurements already known for this scene and device.
    #[arg(long, help_heading = METHOD)]
    recalibrate: bool,
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

fn not_negative(text: &str) -> Result<f64, String> {
    text.parse().ok().filter(|x: &f64| *x >= 0.0).ok_or_else(|| "expected a number from 0".into())
}

impl ChoiceArgs {
    fn is_given(&self) -> bool {
        self.max_error.is_some() || self.budget.is_some() || self.recalibrate
    }

    /// Returns the requested error and time limits.
    fn wish(&self, console: Console) -> Wish {
        let wish = Wish { max_error: self.max_error, budget_ms: self.budget };
        if self.recalibrate && !wish.is_any() {
            console.warn("--recalibrate has no effect without --max-error or --budget");
        }
        wish
    }
}

/// The destination of pictures.
pub enum Target {
    One(PathBuf),
    /// A picture for each step of a time series.
    Steps(Pattern),
    /// A picture for each frame of a camera path, and what is made of them.
    Frames(Pattern, Films),
}

impl Target {
    /// Checks that the options fit together and that the first picture could be written in the end.
    pub fn from_args(args: &RenderArgs) -> Result<Self> {
        let usage = |problem: String| Err(Error::Usage(problem).into());
        let given = args.output.clone();
        if args.along.option().is_none() {
            args.films.refuse(given.as_deref())?;
        }
        let target = match (args.along.option(), args.frames) {
            (Some(option), Some(None)) => {
                return usage(format!("--frames needs the number of frames beside {option}, as in --frames 36"));
            }
            (Some(option), _) if args.choice.is_given() => {
                return usage(format!(
                    "--max-error, --budget and --recalibrate choose for one picture, but {option} makes many; choose for one of \
                     them and give its --method and settings"
                ));
            }
            (Some(_), _) => {
                let films = args.films.films(&args.asked())?;
                let pattern = match films.pattern()? {
                    Some(pattern) => pattern,
                    None => Pattern::parse(&given.unwrap_or_else(|| args.input.default_frames()), Naming::Frames)?,
                };
                Self::Frames(pattern, films)
            }
            (None, Some(Some(count))) => {
                return usage(format!(
                    "--frames {count} needs --path or --turntable; the time series has as many pictures as the scene has clouds"
                ));
            }
            (None, _) if args.popping.is_some() => return usage("--popping needs --path or --turntable".to_owned()),
            (None, _) if args.overwrite => return usage("--overwrite needs --path or --turntable".to_owned()),
            (None, Some(None)) => {
                let pattern = given.unwrap_or_else(|| args.input.default_steps());
                Self::Steps(Pattern::parse(&pattern, Naming::Steps)?)
            }
            (None, None) => Self::One(given.unwrap_or_else(|| args.input.default_output())),
        };
        // The folder of a film's frames need not be there yet.
        if !matches!(&target, Self::Frames(_, films) if films.has_folder()) {
            output::check_target(&target.first())?;
        }
        args.popping.iter().try_for_each(|path| output::check_folder(path))?;
        Ok(target)
    }

    fn first(&self) -> PathBuf {
        match self {
            Self::One(path) => path.clone(),
            Self::Steps(pattern) => pattern.file(1),
            Self::Frames(pattern, _) => pattern.file(0),
        }
    }
}

pub fn is_png(path: &Path) -> bool {
    path.extension().is_some_and(|e| e.eq_ignore_ascii_case("png"))
}

impl RenderArgs {
    /// True if an output of this name has a legend.
    pub fn draws_legend(&self, output: &Path) -> bool {
        self.legend && is_png(output)
    }

    /// Returns the facts that decide if a film can be made.
    fn asked(&self) -> Asked<'_> {
        Asked {
            output: self.output.as_deref(),
            transparent: self.transparent,
            aov: self.aov,
            deep: self.deep.is_asked(),
        }
    }

    /// True if there are many frames.
    #[cfg(feature = "mpi")]
    pub fn is_film(&self) -> bool {
        self.along.option().is_some()
    }

    /// The motion of the camera, if there is one.
    #[cfg(feature = "mpi")]
    pub fn course(&self, console: Console) -> Result<Option<super::along::Along>> {
        self.along.course(self.frames.flatten(), &self.input, console)
    }

    /// True if the method is chosen by what it must keep to.
    pub fn chooses(&self) -> bool {
        self.choice.is_given()
    }

    /// Returns the properties of frames for an output of this name.
    pub fn frame(&self, output: &Path) -> FrameRequest {
        let stop = match is_png(output) {
            true => Stop::EightBit { transparent: self.transparent },
            false => Stop::Exact,
        };
        FrameRequest {
            memory_budget: self.device.memory_budget.map(|budget| budget.as_u64()),
            counts: self.aov || self.measure.profile.is_some(),
            depths: self.aov && !is_png(output),
            stop,
            ..FrameRequest::default()
        }
    }

    /// Returns the request for one picture, or for one after another.
    pub fn request(&self, output: &Path, progress: &Bar, console: Console) -> Result<Request> {
        let mut request = self.input.request(None, progress, console)?;
        request.legend = self.draws_legend(output);
        request.frame = self.frame(output);
        request.choice.wish = self.choice.wish(console);
        request.choice.recalibrate = self.choice.recalibrate;
        if self.deep.is_asked() {
            // Samples of a deep image are all of them, and count themselves.
            request.frame = FrameRequest { memory_budget: request.frame.memory_budget, ..FrameRequest::default() };
        }
        Ok(request)
    }
}

pub fn run(args: RenderArgs, console: Console) -> Result<ExitCode, crate::error::Error> {
    let target = Target::from_args(&args)?;
    if let Target::Frames(_, films) = &target {
        films.check_tools()?;
    }
    args.measure.check()?;
    let png = is_png(&target.first());
    if args.deep.is_asked() {
        deep::check(&args, &target.first(), !matches!(target, Target::One(_)), console)?;
    }
    if args.aov && png {
        console.warn("--aov has no effect on a PNG; write an .exr");
    }
    if args.transparent && !png {
        console.warn("--transparent has no effect on an EXR, which holds the alpha channel anyway");
    }
    if args.legend && !png {
        console.warn("--legend has no effect on an EXR; write a .png");
    }
    if let Target::Frames(pattern, films) = &target
        && let Some(along) = args.along.course(args.frames.flatten(), &args.input, console)?
    {
        return sequence::run(&args, &along, (pattern, films), console);
    }
    let progress = console.progress();
    let opened = Opened::new(args.request(&target.first(), &progress, console)?, &console, &progress)?;
    let mut profile = None;
    match &target {
        Target::One(path) => {
            let prepared = opened.prepare(&console, &progress)?;
            if args.deep.is_asked() {
                deep::run(&args, prepared, path, &progress, console)?;
                return Ok(ExitCode::SUCCESS);
            }
            legend::check(&prepared, console)?;
            let session = session::open(&args.device, prepared, &progress, console)?;
            picture(&args, session, path, None, &mut profile, &progress, console)?;
        }
        Target::Steps(pattern) | Target::Frames(pattern, _) => {
            steps(&args, opened, pattern, &mut profile, &progress, console)?;
        }
    }
    if let Some(profile) = profile {
        console.detail(profile.host_text());
        args.measure.write(&profile)?;
    }
    Ok(ExitCode::SUCCESS)
}

/// A picture of the first cloud, of the first two and so on, by the camera that shows all of them.
fn steps(
    args: &RenderArgs,
    opened: Opened,
    pattern: &Pattern,
    profile: &mut Option<Profile>,
    progress: &Bar,
    console: Console,
) -> Result<()> {
    if matches!(opened.sources.clouds(), Clouds::Stored(_)) {
        return Err(usage(IN_FILES));
    }
    let count = opened.sources.clouds().len();
    (1..=count).try_for_each(|step| output::check_target(&pattern.file(step)))?;
    let mut whole = opened.clone().prepare(&console, progress)?;
    legend::check(&whole, console)?;
    let (mut compilations, mut found) = (Vec::new(), None);
    if whole.see_through().is_some() {
        // As with the camera, clouds that are there already stay as they are when one joins.
        let mut session = session::upload(&args.device, whole, false, progress)?;
        session.find_opacity()?;
        (found, compilations) = (session.found, session.device.compilations());
        whole = session.into_prepared();
    }
    let camera = whole.camera;
    // Each picture has a progress of its own.
    let phases = progress.spans();
    progress.finish_and_clear();
    let open = |prepared: Prepared, progress: &Bar| {
        let mut session = session::upload(&args.device, prepared, false, progress)?;
        session.opacity_of_whole = found;
        session.decide(&console)?;
        Ok::<_, pellucid_engine::Error>(session)
    };
    for step in 1..count {
        let progress = console.progress();
        progress.stage(&format!("step {step} of {count}"));
        // Messages about the scene were printed already.
        let part = opened.first(step).prepare_by(|_, _, _| Ok((camera, Vec::new())), &Silent, &progress)?;
        let session = open(part, &progress)?;
        picture(args, session, &pattern.file(step), Some((step, count)), profile, &progress, console)?;
    }
    let progress = console.progress();
    let session = open(whole, &progress)?;
    picture(args, session, &pattern.file(count), Some((count, count)), profile, &progress, console)?;
    if let Some(profile) = profile {
        profile.add_host(phases, &compilations);
    }
    Ok(())
}

/// Renders and writes a picture; `step` is its number and the number of all pictures, if it is one of several.
fn picture(
    args: &RenderArgs,
    mut session: Session,
    output: &Path,
    step: Option<(usize, usize)>,
    profile: &mut Option<Profile>,
    progress: &Bar,
    console: Console,
) -> Result<()> {
    session.renderer.timed = args.measure.is_asked() || console.is_verbose();
    session.describe(&console);
    // In a time series, warn only once.
    let last = step.is_none_or(|(step, count)| step == count);
    if last {
        session.warn(&console);
    }
    let mut rendered = session.render()?;
    if last {
        session.judge(&rendered.image, &console)?;
    }
    progress.finish_and_clear();
    let own = step.map(|(step, count)| ("pellucid:step".to_owned(), format!("{step} of {count}")));
    finish(args, &mut session, &mut rendered, output, own.into_iter().collect(), console)?;
    let profile = profile.get_or_insert_with(|| session.profile());
    profile.add(&rendered);
    session.add_phases(profile);
    Ok(())
}

/// Brightens a rendered image if its method is to do so, and writes it with its metadata, `own` among it. List lengths
/// and layers are as they were afterwards, if they are written or were counted for a profile.
pub fn finish(
    args: &RenderArgs,
    session: &mut Session,
    rendered: &mut Rendered,
    output: &Path,
    own: Vec<(String, String)>,
    console: Console,
) -> Result<()> {
    let brightness = session.brighten(rendered, &console)?;
    let options = WriteOptions { transparent: args.transparent, ..session.write_options(brightness.as_ref(), own) };
    // If not requested, the counts served only the profile's histogram.
    let counted = if args.aov { None } else { rendered.image.fragments.take() };
    rendered.image.layers = rendered.image.layers.take().filter(|_| args.aov);
    rendered.image.stderr = rendered.image.stderr.take().filter(|_| args.aov);
    session.begin_writing();
    match &session.assembled().legend {
        Some(legend) => legend::write(output, &rendered.image, &options, legend, &session.frame.camera, console)?,
        None => output::write_image(output, &rendered.image, &options)?,
    }
    rendered.image.fragments = rendered.image.fragments.take().or(counted);
    console.detail(format_args!("{}: written", output.display()));
    Ok(())
}
