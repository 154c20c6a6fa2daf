//! `pellucid render`.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::Args;
use indicatif::ProgressBar;
use pellucid::choice::{self, Choice, Subject, Wish};
use pellucid::methods::Stop;
use pellucid::output::{self, WriteOptions};
use pellucid::profile::Profile;
use pellucid::report::tradeoff::settings::formation;
use pellucid::{Result, plan};

use super::frames::Pattern;
use super::input::{InputArgs, Loaded, Resolved, read};
use super::session::Session;
use super::talk::{Talk, stage};
use super::{DeviceArgs, MeasureArgs};

#[derive(Debug, Args)]
pub struct RenderArgs {
    #[command(flatten)]
    input: InputArgs,
    #[command(flatten)]
    device: DeviceArgs,
    #[command(flatten)]
    measure: MeasureArgs,
    /// The picture: .png (8-bit sRGB) or .exr (32-bit float R, G, B, A, Z); by default the first input's name with
    /// .png, in the current folder. For a .png method sorted blends until no 8-bit value would move by more than a
    /// quarter of a step, for an .exr until no bit would change.
    #[arg(short, long, value_name = "OUT")]
    output: Option<PathBuf>,
    /// EXR: also write the length of each pixel's fragment list, as channel `fragments.Y`, with peel and peel-layers the
    /// layers that were blended, as `layers.Y`, and with stochastic and spbr the standard error of color, as `stderr.R`,
    /// `stderr.G`, `stderr.B`.
    #[arg(long)]
    aov: bool,
    /// PNG: straight alpha instead of the background. (An EXR always has both: R, G, B over the background, and A.)
    #[arg(long)]
    transparent: bool,
    /// A time series: a picture of the first cloud of the scene, one of the first two and so on, all by the camera that
    /// shows the whole scene. The output's name needs a number, as in step_%02d.png (by default the first input's name
    /// with _%02d.png), which counts from 1.
    #[arg(long)]
    frames: bool,
    #[command(flatten)]
    choice: ChoiceArgs,
}

/// The method by what it must keep to.
#[derive(Debug, Args)]
struct ChoiceArgs {
    /// Take the fastest method and setting of which the RMSE on this image was measured to be at most E: on linear R, G, B
    /// over the background, against abuffer, against soft-base for soft spheres, or against what ever more ensembles of spbr
    /// tend to. With --method only its settings. A scene file's method says only which discs.
    #[arg(long, value_name = "E", value_parser = not_negative)]
    max_error: Option<f64>,
    /// Take the most accurate method and setting of which a frame was measured to take at most so many milliseconds on the
    /// device (the median, as in `tradeoff`). If none does, the fastest. With --max-error the error counts, and a warning
    /// says if the time does not fit.
    #[arg(long, value_name = "MS", value_parser = not_negative)]
    budget: Option<f64>,
    /// With --max-error or --budget: measure again what is known of this scene on this device.
    #[arg(long)]
    recalibrate: bool,
}

fn not_negative(text: &str) -> Result<f64, String> {
    text.parse().ok().filter(|x: &f64| *x >= 0.0).ok_or_else(|| "expected a number from 0".into())
}

impl ChoiceArgs {
    /// What is wished for, if anything is that makes sense for the scene's method.
    fn wish(&self, resolved: &Resolved, talk: Talk) -> Option<Wish> {
        let wish = Wish { max_error: self.max_error, budget_ms: self.budget };
        if self.recalibrate && !wish.is_any() {
            talk.warn("--recalibrate has no effect without --max-error or --budget");
        }
        let method = resolved.scene.method;
        let taken = plan::resolve(method, resolved.points()).0;
        if wish.is_any() && resolved.scene.shadows.is_some() && taken.takes_shadows() {
            talk.warn(format_args!(
                "--max-error and --budget have no effect where there are shadows: {} stays the method",
                taken.name()
            ));
            return None;
        }
        if wish.is_any() && formation(&method, resolved.points()).is_err() {
            talk.warn(format_args!(
                "--max-error and --budget have no effect on method {}: no other one draws its image",
                method.name()
            ));
            return None;
        }
        Some(wish).filter(Wish::is_any)
    }
}

/// Chooses by the wish, and says what.
fn choose(
    args: &RenderArgs,
    wish: Wish,
    session: &mut Session,
    resolved: &Resolved,
    progress: &ProgressBar,
    talk: Talk,
) -> Result<Choice> {
    stage(progress, "choosing the method");
    let (arranged, background, only) = (&resolved.arranged, resolved.scene.image.background, args.input.asked_method());
    let subject = Subject { arranged, frame: session.frame, background, only };
    let choice =
        choice::choose(&session.device, &mut session.cloud, &subject, wish, args.choice.recalibrate, progress)?;
    stage(progress, "rendering");
    talk.detail(format_args!(
        "chosen among {} measured settings; frames rendered for it now: {}",
        choice.known, choice.frames
    ));
    let (name, figures) = (choice.method.name(), choice.figures);
    let chosen = format!("{name} {}", choice.setting);
    talk.note(format_args!("{}: RMSE {:.2e}, {:.2} ms on the device", chosen.trim_end(), figures.rmse, figures.gpu_ms));
    if let Some(warning) = &choice.warning {
        talk.warn(warning);
    }
    session.frame.method = choice.method;
    session.why = "chosen by what was measured on this scene".to_owned();
    Ok(choice)
}

/// Where pictures go.
enum Target {
    One(PathBuf),
    /// A picture for each step of a time series.
    Steps(Pattern),
}

impl Target {
    /// Checks that the first picture could be written in the end.
    fn of(args: &RenderArgs) -> Result<Self> {
        let given = args.output.clone();
        let target = if args.frames {
            Self::Steps(Pattern::parse(&given.unwrap_or_else(|| args.input.default_pattern()))?)
        } else {
            Self::One(given.unwrap_or_else(|| args.input.default_output()))
        };
        output::check_target(&target.file(1))?;
        Ok(target)
    }

    fn file(&self, step: usize) -> PathBuf {
        match self {
            Self::One(path) => path.clone(),
            Self::Steps(pattern) => pattern.file(step),
        }
    }

    fn is_png(&self) -> bool {
        self.file(1).extension().is_some_and(|e| e.eq_ignore_ascii_case("png"))
    }
}

pub fn run(args: RenderArgs, talk: Talk) -> Result<ExitCode> {
    let target = Target::of(&args)?;
    args.measure.check()?;
    if args.aov && target.is_png() {
        talk.warn("--aov has no effect on a PNG; write an .exr");
    }
    if args.transparent && !target.is_png() {
        talk.warn("--transparent has no effect on an EXR, which holds the alpha channel anyway");
    }
    let progress = talk.progress();
    let loaded = read(&args.input, talk, &progress)?;
    let mut profile = None;
    match &target {
        Target::One(path) => {
            let resolved = loaded.resolve(None, talk, &progress)?;
            picture(&args, &resolved, path, None, &mut profile, &progress, talk)?;
        }
        Target::Steps(pattern) => steps(&args, loaded, pattern, &mut profile, &progress, talk)?,
    }
    if let Some(profile) = profile {
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
    progress: &ProgressBar,
    talk: Talk,
) -> Result<()> {
    let count = loaded.count();
    (1..=count).try_for_each(|step| output::check_target(&pattern.file(step)))?;
    let whole = loaded.clone().resolve(None, talk, progress)?;
    progress.finish_and_clear();
    // What is to be said about the scene was said.
    let silent = Talk::new(true, false);
    for step in 1..count {
        let progress = talk.progress();
        stage(&progress, &format!("step {step} of {count}"));
        let part = loaded.first(step).resolve(Some(whole.camera), silent, &progress)?;
        picture(args, &part, &pattern.file(step), Some((step, count)), profile, &progress, talk)?;
    }
    picture(args, &whole, &pattern.file(count), Some((count, count)), profile, &talk.progress(), talk)
}

/// Renders and writes a picture; `step` is its number and that of all, if there are several.
fn picture(
    args: &RenderArgs,
    resolved: &Resolved,
    output: &Path,
    step: Option<(usize, usize)>,
    profile: &mut Option<Profile>,
    progress: &ProgressBar,
    talk: Talk,
) -> Result<()> {
    let png = output.extension().is_some_and(|e| e.eq_ignore_ascii_case("png"));
    let stop = if png { Stop::EightBit { transparent: args.transparent } } else { Stop::Exact };
    let counted = args.aov || args.measure.profile.is_some();
    let wish = args.choice.wish(resolved, talk);
    // An error was measured of every bit.
    let stop = if wish.is_some() { Stop::Exact } else { stop };
    let (mut session, choice) = match wish {
        None => (Session::open(&args.device, resolved, counted, stop, progress)?, None),
        Some(wish) => {
            let mut session = Session::upload(&args.device, resolved, counted, stop, progress)?;
            let choice = choose(args, wish, &mut session, resolved, progress, talk)?;
            (session, Some(choice))
        }
    };
    session.renderer.progress = progress.clone();
    session.describe(talk);
    // Of a time series once.
    if step.is_none_or(|(step, count)| step == count) {
        session.warn(resolved, talk);
    }
    let mut rendered = session.render()?;
    let brightness = session.brighten(&mut rendered.image)?;
    progress.finish_and_clear();
    Session::describe_frame(&rendered, talk);
    let mut metadata = resolved.metadata(session.frame.method.name(), &session.device.info().name);
    metadata.extend(choice.map(|choice| ("pellucid:choice".to_owned(), choice.json().to_string())));
    if let Some(applied) = brightness {
        if applied.found.is_some() {
            talk.note(format_args!("brightness: colors times {}", applied.factor));
        }
        applied.warning().iter().for_each(|warning| talk.warn(warning));
        metadata.push(("pellucid:brightness".to_owned(), applied.json().to_string()));
    }
    metadata.extend(step.map(|(step, count)| ("pellucid:step".to_owned(), format!("{step} of {count}"))));
    let options = WriteOptions {
        background: resolved.scene.image.background,
        color: resolved.scene.image.color,
        transparent: args.transparent,
        metadata,
    };
    // Lists may have been counted, but for the profile's histogram only.
    let counted = if args.aov { None } else { rendered.image.fragments.take() };
    rendered.image.layers = rendered.image.layers.filter(|_| args.aov);
    rendered.image.stderr = rendered.image.stderr.filter(|_| args.aov);
    output::write_image(output, &rendered.image, &options)?;
    rendered.image.fragments = rendered.image.fragments.or(counted);
    profile.get_or_insert_with(|| session.profile()).add(&rendered);
    talk.detail(format_args!("{}: written", output.display()));
    Ok(())
}
