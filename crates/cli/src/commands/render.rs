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
use pellucid_lab::choice::{self, Choice, Figures, Row, Subject, Wish};
use pellucid_lab::frame_notes;

use super::along::PathArgs;
use super::console::Console;
use super::deep::{self, DeepArgs};
use super::films::{Asked, FilmArgs, Films};
use super::frames::{Naming, Pattern};
use super::headings::{FRAMES, METHOD, OUTPUT};
use super::input::InputArgs;
use super::loaded::{Loaded, Resolved, read};
use super::opacity_notes;
use super::sequence;
use super::session::Session;
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
    /// Default: the name of the first input with .png, in the current folder. Z is the distance of the nearest surface along the
    /// viewing axis, in scene units, and +inf where no surface is. For a PNG the methods sorted and abuffer blend until no
    /// 8-bit value would change by more than a quarter of a step, for an EXR until no bit would change.
    ///
    /// With --path or --turntable also a film or an animation: .mp4 (H.264) and .webm (VP9), which need the program ffmpeg, .gif, or
    /// .apng.
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
    /// Frames count from 0. Unless the output is a film, its name needs a number, as in frame_%04d.png (default: the name of the
    /// first input with _%04d.png). Existing frames of the same scene, path and settings are not rendered again.
    ///
    /// Without a number the option stands behind the inputs, or before another option. A time series is a picture of the first cloud of the scene, one of the first two, and so on, all with the camera that
    /// shows the whole scene. Pictures count from 1, as in step_%02d.png (default: the name of the first input with _%02d.png).
    #[arg(long, value_name = "N", num_args = 0..=1, value_parser = number_of_frames, help_heading = FRAMES)]
    frames: Option<Option<u32>>,
    #[command(flatten)]
    along: PathArgs,
    #[command(flatten)]
    films: FilmArgs,
    /// With --path or --turntable: write how the error changes from frame to frame.
    ///
    /// Every frame is also rendered by the exact method: abuffer (for Gaussians with order = "pixel"), or soft-base for soft
    /// spheres. Each line of the table has the RMSE of a frame, and RMSE and FLIP of the change of its error since the previous
    /// frame, on linear R, G, B over the background. Existing frames are rendered again but not written.
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
    /// The RMSE is measured on linear R, G, B over the background, against abuffer, against soft-base for soft spheres, or
    /// against the limit of many ensembles for spbr. With --method only the settings of that method are tried. The method of a
    /// scene file only selects the kind of discs.
    #[arg(long, value_name = "E", value_parser = not_negative, help_heading = METHOD)]
    max_error: Option<f64>,
    /// Take the most accurate method and settings with a frame time of at most MS.
    ///
    /// The time in milliseconds is the measured median on the device, as in `pellucid tradeoff`. If nothing is fast enough, the
    /// fastest is taken. --max-error has priority; a warning tells if the time is then exceeded.
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

    /// The requested error or time limit, if it is meaningful for the scene's method.
    fn wish(&self, resolved: &Resolved, console: Console) -> Option<Wish> {
        let wish = Wish { max_error: self.max_error, budget_ms: self.budget };
        if self.recalibrate && !wish.is_any() {
            console.warn("--recalibrate has no effect without --max-error or --budget");
        }
        let wish = Some(wish).filter(Wish::is_any)?;
        match Wish::hindrance(&resolved.scene, resolved.points()) {
            Some(reason) => {
                console.warn(format_args!("--max-error and --budget have no effect {reason}"));
                None
            }
            None => Some(wish),
        }
    }
}

/// Chooses method and setting by the wish, and reports the choice.
fn choose(
    args: &RenderArgs,
    wish: Wish,
    session: &mut Session,
    resolved: &Resolved,
    progress: &Bar,
    console: Console,
) -> Result<Choice> {
    progress.stage("choosing the method");
    let (arranged, background, only) = (&resolved.arranged, resolved.scene.image.background, args.input.asked_method());
    let subject = Subject { arranged, frame: session.frame, background, only };
    let choice =
        choice::choose(&session.device, &mut session.cloud, &subject, wish, args.choice.recalibrate, progress)?;
    progress.stage("rendering");
    console.detail(format_args!(
        "chosen among {} measured settings; frames rendered for it now: {}",
        choice.known, choice.frames
    ));
    let (name, figures) = (choice.method.name(), choice.figures);
    let chosen = format!("{name} {}", choice.setting);
    console.note(format_args!(
        "{}: RMSE {:.2e}, {:.2} ms on the device",
        chosen.trim_end(),
        figures.rmse,
        figures.gpu_ms
    ));
    if let Some(warning) = &choice.warning {
        console.warn(warning);
    }
    console.note(candidates(&choice.best));
    session.frame.method = choice.method;
    session.take_detail(choice.detail, resolved)?;
    session.why = "chosen by what was measured on this scene".to_owned();
    Ok(choice)
}

/// The best settings as a table: setting, RMSE, time, and how far apart the times of its frames are.
fn candidates(rows: &[Row]) -> String {
    let width = rows.iter().map(|row| row.name.chars().count()).max().unwrap_or(0).max("setting".len());
    let line = |row: &Row| {
        let spread = row.spread.map_or_else(String::new, |spread| format!("{:>6.0}%", 100.0 * spread));
        let mark = if row.busy { " (a busy machine?)" } else { "" };
        let Figures { rmse, gpu_ms } = row.figures;
        format!("\n  {:<width$}  {rmse:>8.1e}  {gpu_ms:>9.2}  {spread}{mark}", row.name)
    };
    let lines: String = rows.iter().map(line).collect();
    format!("  {:<width$}  {:>8}  {:>9}  {:>7}{lines}", "setting", "RMSE", "ms", "spread")
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

    /// The accuracy at which blending may stop for an output of this name.
    pub fn stop(&self, output: &Path) -> Stop {
        if is_png(output) { Stop::EightBit { transparent: self.transparent } } else { Stop::Exact }
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
    let loaded = read(&args.input, None, console, &progress)?.with_legend(args.legend && png);
    let mut profile = None;
    match &target {
        Target::One(path) => {
            let resolved = loaded.resolve(None, console, &progress)?;
            if args.deep.is_asked() {
                deep::run(&args, &resolved, path, &progress, console)?;
                return Ok(ExitCode::SUCCESS);
            }
            legend::check(&resolved, console)?;
            picture(&args, &resolved, path, None, &mut profile, &progress, console)?;
        }
        Target::Steps(pattern) | Target::Frames(pattern, _) => {
            steps(&args, loaded, pattern, &mut profile, &progress, console)?;
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
    loaded: Loaded,
    pattern: &Pattern,
    profile: &mut Option<Profile>,
    progress: &Bar,
    console: Console,
) -> Result<()> {
    let count = loaded.count()?;
    (1..=count).try_for_each(|step| output::check_target(&pattern.file(step)))?;
    let mut whole = loaded.clone().resolve(None, console, progress)?;
    legend::check(&whole, console)?;
    let mut compilations = Vec::new();
    if whole.see_through.is_some() {
        // As with the camera, what is there already stays as it is when a cloud joins.
        let mut session = Session::upload(&args.device, &whole, false, Stop::Exact, progress)?;
        session.find_opacity(&whole, progress)?;
        whole.opacity_found = session.see_through;
        compilations = session.device.compilations();
    }
    // Each picture has a progress of its own.
    let phases = progress.spans();
    progress.finish_and_clear();
    // Messages about the scene were printed already.
    let silent = Console::new(true, false);
    for step in 1..count {
        let progress = console.progress();
        progress.stage(&format!("step {step} of {count}"));
        let part = loaded.first(step).resolve(Some(whole.camera), silent, &progress)?;
        let part = Resolved { opacity_found: whole.opacity_found, ..part };
        picture(args, &part, &pattern.file(step), Some((step, count)), profile, &progress, console)?;
    }
    picture(args, &whole, &pattern.file(count), Some((count, count)), profile, &console.progress(), console)?;
    if let Some(profile) = profile {
        profile.add_host(phases, &compilations);
    }
    Ok(())
}

/// Renders and writes a picture; `step` is its number and the number of all pictures, if it is one of several.
fn picture(
    args: &RenderArgs,
    resolved: &Resolved,
    output: &Path,
    step: Option<(usize, usize)>,
    profile: &mut Option<Profile>,
    progress: &Bar,
    console: Console,
) -> Result<()> {
    let stop = args.stop(output);
    let counted = args.aov || args.measure.profile.is_some();
    let wish = args.choice.wish(resolved, console);
    // An error was measured of every bit.
    let stop = if wish.is_some() { Stop::Exact } else { stop };
    let (mut session, choice) = match wish {
        None => (Session::open(&args.device, resolved, counted, stop, progress)?, None),
        Some(wish) => {
            let mut session = Session::upload(&args.device, resolved, counted, stop, progress)?;
            session.find_opacity(resolved, progress)?;
            let choice = choose(args, wish, &mut session, resolved, progress, console)?;
            (session, Some(choice))
        }
    };
    session.renderer.progress = (**progress).clone();
    session.renderer.timed = args.measure.is_asked() || console.is_verbose();
    session.describe(console);
    // In a time series, warn only once.
    let last = step.is_none_or(|(step, count)| step == count);
    if last {
        session.warn(resolved, console);
    }
    session.frame.depths = args.aov && !is_png(output);
    let mut rendered = session.render()?;
    session.frame.depths = false;
    if last {
        opacity_notes::judge(&mut session, resolved, &rendered.image, console)?;
    }
    progress.finish_and_clear();
    let mut own: Vec<_> =
        choice.map(|choice| ("pellucid:choice".to_owned(), choice.json().to_string())).into_iter().collect();
    own.extend(step.map(|(step, count)| ("pellucid:step".to_owned(), format!("{step} of {count}"))));
    finish(args, resolved, &mut session, &mut rendered, output, own, console)?;
    let profile = profile.get_or_insert_with(|| session.profile());
    profile.add(&rendered);
    session.add_phases(profile);
    Ok(())
}

/// Brightens a rendered image if its method is to do so, and writes it with its metadata, `own` among it. List lengths and
/// layers are as they were afterwards, if they are written or were counted for a profile.
pub fn finish(
    args: &RenderArgs,
    resolved: &Resolved,
    session: &mut Session,
    rendered: &mut Rendered,
    output: &Path,
    own: Vec<(String, String)>,
    console: Console,
) -> Result<()> {
    let brightness = session.brighten(&mut rendered.image)?;
    Session::describe_frame(rendered, console);
    resolved.described_reads().iter().for_each(|reads| console.detail(reads));
    session.describe_detail(console);
    let mut metadata = resolved.metadata(session.frame.method.name(), &session.device.info().name);
    if let Some(applied) = &brightness {
        if applied.found.is_some() {
            console.note(format_args!("brightness: colors times {}", applied.factor));
        }
        applied.warning().iter().for_each(|warning| console.warn(warning));
    }
    let Session { frame, cloud, see_through, .. } = &session;
    let clouds = &resolved.scene.clouds;
    metadata.extend(frame_notes::decisions(frame, cloud, clouds, brightness.as_ref(), see_through.as_ref()));
    metadata.extend(own);
    let options = WriteOptions {
        background: resolved.scene.image.background,
        color: resolved.scene.image.color_space(),
        transparent: args.transparent,
        metadata,
    };
    // If not requested, the counts served only the profile's histogram.
    let counted = if args.aov { None } else { rendered.image.fragments.take() };
    rendered.image.layers = rendered.image.layers.take().filter(|_| args.aov);
    rendered.image.stderr = rendered.image.stderr.take().filter(|_| args.aov);
    session.begin_writing();
    match &resolved.legend {
        Some(legend) => legend::write(output, &rendered.image, &options, legend, &session.frame.camera, console)?,
        None => output::write_image(output, &rendered.image, &options)?,
    }
    rendered.image.fragments = rendered.image.fragments.take().or(counted);
    console.detail(format_args!("{}: written", output.display()));
    Ok(())
}
