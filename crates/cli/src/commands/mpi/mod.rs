//! `pellucid-mpi`: one picture, or the frames of a path, by many ranks, with the bytes of one.

mod cut;
mod desk;
mod frame;
mod frames;
mod link;
mod picture;
mod pixels;
mod plan;
mod profile;
mod ranks;
mod report;
mod share;
mod spread;
mod stage;
mod turn;
mod work;

use std::process::ExitCode;

use clap::Parser;
use pellucid_engine::Result;
use pellucid_session::Residence;

use self::ranks::{Ranks, together};
use self::spread::orders::{self, Order};
use self::spread::worker;
use super::console::{Console, Streams};
use super::job::{RenderJob, Target};
use super::limit::usage;
use super::mpi_args::{Cli, Command, SharingArgs, SpreadArgs, Wanted};
use super::options::DeviceArgs;
use super::render::RenderArgs;
use super::touched::{Touched, Touches};
use super::unknown::advise;
use super::{Error, VerbosityArgs};

/// Parses the command line and runs its command on all ranks.
pub fn main() -> ExitCode {
    let mut ranks = match Ranks::join() {
        Ok(ranks) => ranks,
        Err(problem) => {
            Streams::Process.print_stderr(format_args!("error: {problem}"));
            return ExitCode::FAILURE;
        }
    };
    let cli = match Cli::try_parse() {
        Ok(cli) => cli,
        Err(error) => {
            let error = advise(error);
            if ranks.is_first() {
                let _ = error.print();
            }
            return ExitCode::from(u8::try_from(error.exit_code()).unwrap_or(2));
        }
    };
    let VerbosityArgs { quiet, verbose } = cli.verbosity;
    ranks.tells = verbose;
    ranks.begin("joined");
    // A message of one rank is a message of all.
    let console = Console::new(quiet || !ranks.is_first(), verbose && ranks.is_first(), Streams::Process);
    super::interrupt::watch();
    pellucid_io::silence_decoder_panics();
    let spread = cli.command.spread();
    if let (Some(device), false) = (spread, ranks.is_first()) {
        return worker::serve(device, &ranks).unwrap_or_else(|error| fail(&error.into(), &ranks));
    }
    let ranks = if spread.is_some() { ranks.leading() } else { ranks };
    let touched = cli.command.touched().and_then(|touched| touched.check());
    let done = together(&ranks, touched).and_then(|()| match cli.command {
        Command::Render { mut args, sharing, spread } => {
            args.input.residence = residence(&sharing, spread, args.along.option().is_some(), &ranks);
            render(args, &sharing, &ranks, console)
        }
        Command::Profile { mut args, sharing, spread } => {
            args.input.residence = residence(&sharing, spread, args.along.option().is_some(), &ranks);
            args.files();
            profile::run(&args, &sharing, &ranks, console).map(|()| ExitCode::SUCCESS)
        }
        Command::Plan { args, sharing, ranks: count } => {
            let count = count.map(|count| count as usize);
            plan::run(&args, &sharing, count, &ranks, console).map(|()| ExitCode::SUCCESS)
        }
    });
    let done = match done {
        Ok(status) => status,
        Err(Error::Told(status)) => ExitCode::from(status),
        Err(error) => fail(&error, &ranks),
    };
    ranks.led().into_iter().for_each(|others| orders::send_to_others(others, &Order::Stop, None));
    done
}

/// Returns which clouds stay in their files: those that are distributed, and octrees of which regions show parts.
fn residence(sharing: &SharingArgs, spread: SpreadArgs, is_film: bool, ranks: &Ranks) -> Residence {
    let by_windows = sharing.share == Wanted::Windows || sharing.share == Wanted::Auto && !is_film;
    if spread.spread {
        Residence::Parts
    } else if by_windows && ranks.count() > 1 {
        Residence::Octrees
    } else {
        Residence::Levels
    }
}

fn fail(error: &Error, ranks: &Ranks) -> ! {
    ranks.fail(&error.with_causes(), error.exit_status())
}

impl Command {
    /// The files that the command reads and writes.
    fn touched(&self) -> Result<Touched> {
        match self {
            Self::Render { args, .. } => args.touched(),
            Self::Profile { args, .. } => args.touched(),
            Self::Plan { args, .. } => args.touched(),
        }
    }

    /// The device that is asked for, if points are to be distributed over the ranks.
    fn spread(&self) -> Option<&DeviceArgs> {
        match self {
            Self::Render { args, spread, .. } => spread.spread.then_some(&args.device),
            Self::Profile { args, spread, .. } => spread.spread.then_some(&args.device),
            Self::Plan { .. } => None,
        }
    }
}

/// A picture, or the frames of a path.
fn render(args: RenderArgs, sharing: &SharingArgs, ranks: &Ranks, console: Console) -> Result<ExitCode, Error> {
    let target = together(ranks, target(&args))?;
    let progress = console.progress();
    let job = together(ranks, RenderJob::new(args, target, &progress))?;
    match (&job.target, &job.along) {
        (Target::One(output), _) => picture::run(&job, sharing, output, ranks, &progress).map(|()| ExitCode::SUCCESS),
        (Target::Frames(pattern, _), Some(along)) => frames::run(&job, sharing, (along, pattern), ranks, &progress),
        // Refused before.
        (Target::Frames(..) | Target::Steps(_), _) => Ok(ExitCode::FAILURE),
    }
}

/// Returns the destination of pictures, if ranks can share the work.
fn target(args: &RenderArgs) -> Result<Target> {
    args.measure.check()?;
    if args.choice.is_given() {
        return Err(usage(
            "--max-error, --budget and --recalibrate measure a single device: choose with `pellucid render`, then give the \
             method here",
        ));
    }
    if args.deep.format().is_some() {
        return Err(usage(
            "--deep is not supported here, because a deep file is written during rendering; use `pellucid render`",
        ));
    }
    match Target::new(args)? {
        Target::Frames(_, films) if !films.is_none() => Err(usage(
            "films and pages are not supported here: render numbered frames (-o frame_%04d.png), then give `pellucid render` the same \
             options and --html, or make a film of them (ffmpeg -framerate 25 -i frame_%04d.png -pix_fmt yuv420p film.mp4)",
        )),
        Target::Steps(_) => Err(usage(
            "a time series is not supported here, because each picture depends on the previous one; \
              use `pellucid render`",
        )),
        target => Ok(target),
    }
}
