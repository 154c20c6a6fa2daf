//! Everything that `pellucid render` was asked for, as plain data: made once from its arguments.

use std::path::{Path, PathBuf};

use pellucid_engine::Result;
use pellucid_engine::methods::{Outputs, Stop};
use pellucid_io::output::{self, Output};
use pellucid_session::area::Against;
use pellucid_session::choice::Wish;
use pellucid_session::{FrameRequest, Request};

use super::Error;
use super::along::Along;
use super::bar::Bar;
use super::console::Console;
use super::films::Films;
use super::frames::{Naming, Pattern};
use super::limit::usage;
use super::options::refuse;
use super::render::{ChoiceArgs, RenderArgs};

/// Pictures to render, and what becomes of them.
pub struct RenderJob {
    /// Destination of the pictures.
    pub target: Target,
    /// Motion of the camera, if there are frames of one.
    pub along: Option<Along>,
    /// Request for one picture, or for one after another.
    pub request: Request,
    pub args: RenderArgs,
}

impl RenderJob {
    /// Reads the camera's path and the keys of the scene. Begins the phase of reading.
    ///
    /// # Errors
    /// Returns an error if a file can't be read, or if a key is wrong.
    pub fn new(args: RenderArgs, target: Target, progress: &Bar) -> Result<Self> {
        let console = progress.console;
        let along = args.along.course(args.frames.flatten(), &args.input, console)?;
        let mut request = args.input.request(along.as_ref().and_then(Along::size), progress)?;
        let is_png = is_png(&target.first());
        let ChoiceArgs { max_error, budget, against, recalibrate } = args.choice;
        let wish = Wish { max_error, budget_ms: budget, against };
        for (is_given, option) in [(recalibrate, "--recalibrate"), (against != Against::Center, "--against")] {
            if is_given && !wish.is_any() {
                console.warn(format_args!("{option} has no effect without --max-error or --budget"));
            }
        }
        (request.choice.wish, request.choice.recalibrate) = (wish, recalibrate);
        request.wanted.legend = args.legend.is_some() && is_png;
        request.frame.memory_budget = args.device.budget();
        // Samples of a deep image are all of them, and count themselves.
        if args.deep.format().is_none() {
            request.frame = FrameRequest {
                counts: args.aov || args.measure.profile.is_some(),
                depths: args.aov && !is_png,
                stop: if is_png { Stop::EightBit { transparent: args.transparent } } else { Stop::Exact },
                ..request.frame
            };
        }
        Ok(Self { target, along, request, args })
    }

    /// Returns the outputs of the pictures that are written, or compared with others.
    pub fn outputs(&self) -> Outputs {
        let needs_floats = self.args.transparent || self.args.popping.is_some();
        if is_png(&self.target.first()) && !needs_floats { Outputs::PNG } else { Outputs::default() }
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
    pub fn new(args: &RenderArgs) -> Result<Self> {
        let target = Self::named(args)?;
        if let Self::Frames(_, films) = &target {
            films.check_targets()?;
        }
        // The folder of a film's frames need not be there yet.
        if !matches!(&target, Self::Frames(_, films) if films.has_folder()) {
            output::check_target(&target.first())?;
        }
        args.popping.iter().try_for_each(|path| output::check_folder(path))?;
        Ok(target)
    }

    /// Returns the target that the options name, if they fit together.
    pub fn named(args: &RenderArgs) -> Result<Self> {
        let given = args.output.clone();
        if args.along.option().is_none() {
            args.films.refuse(given.as_deref())?;
        }
        Ok(match (args.along.option(), args.frames) {
            (Some(option), Some(None)) => {
                return Err(usage(format!("--frames needs the number of frames beside {option}, as in --frames 36")));
            }
            (Some(option), _) if args.choice.is_given() => {
                return Err(usage(format!(
                    "--max-error, --budget, --against and --recalibrate choose for one picture, but {option} makes many; choose for one of \
                     them and give its --method and settings"
                )));
            }
            (Some(_), _) => {
                let films = args.films.films(args)?;
                let pattern = match films.pattern()? {
                    Some(pattern) => pattern,
                    None => Pattern::parse(
                        &given.unwrap_or_else(|| args.input.default_output("_%04d.png")),
                        Naming::Frames,
                    )?,
                };
                Self::Frames(pattern, films)
            }
            (None, Some(Some(count))) => {
                return Err(usage(format!(
                    "--frames {count} needs --path or --turntable; the time series has as many pictures as the scene has clouds"
                )));
            }
            (None, _) if args.popping.is_some() => return Err(usage("--popping needs --path or --turntable")),
            (None, _) if args.overwrite => return Err(usage("--overwrite needs --path or --turntable")),
            (None, Some(None)) => {
                let pattern = given.unwrap_or_else(|| args.input.default_output("_%02d.png"));
                Self::Steps(Pattern::parse(&pattern, Naming::Steps)?)
            }
            (None, None) => Self::One(given.unwrap_or_else(|| args.input.default_output(".png"))),
        })
    }

    /// Returns the files that are written.
    pub fn writes(&self) -> Vec<Output> {
        match self {
            Self::One(path) => vec![Output::file("-o", path)],
            Self::Steps(pattern) => vec![pattern.output()],
            Self::Frames(pattern, films) => films.outputs().chain([pattern.output()]).collect(),
        }
    }

    /// Refuses options that don't go together or with the machine, and names those without an effect, before anything
    /// is read.
    pub fn check(&self, args: &RenderArgs, console: Console) -> Result<(), Error> {
        if let Self::Frames(_, films) = self {
            films.check_tools()?;
        }
        args.measure.check()?;
        let is_deep = args.deep.format().is_some();
        if is_deep {
            self.check_deep(args)?;
        }
        if args.aov && is_deep {
            console.warn("--aov has no effect with --deep: the samples already give depths and counts");
        }
        let png = is_png(&self.first());
        for (is_vain, what) in [
            (args.aov && png, "--aov has no effect on a PNG; write an .exr"),
            (args.transparent && !png, "--transparent has no effect on an EXR, which holds the alpha channel anyway"),
            (args.legend.is_some() && !png, "--legend has no effect on an EXR; write a .png"),
        ] {
            if is_vain {
                console.warn(what);
            }
        }
        Ok(())
    }

    /// Refuses options that don't go with samples.
    fn check_deep(&self, args: &RenderArgs) -> Result<()> {
        let output = self.first();
        if is_png(&output) {
            let output = output.display();
            return Err(usage(format!("--deep: {output} is a PNG, but only an .exr holds samples; name one with -o")));
        }
        refuse([
            (!matches!(self, Self::One(_)), "--deep writes one picture; --frames, --path and --turntable make several"),
            (
                args.choice.is_given(),
                "--deep can't be combined with --max-error, --budget, --against and --recalibrate; give --method and its settings instead",
            ),
            (args.measure.is_asked(), "--deep can't be combined with --profile and --trace; measure without --deep"),
        ])
    }

    /// The first picture.
    pub fn first(&self) -> PathBuf {
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
