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
mod simulate;
mod spread;
mod stage;
mod work;

use std::process::ExitCode;

use clap::{Parser, Subcommand};
use pellucid_engine::Result;
use pellucid_engine::scene::Error;

use self::ranks::Ranks;
use self::share::{SharingArgs, Wanted};
use self::spread::{SpreadArgs, orders, worker};
use super::console::{Console, print_stderr};
use super::input::KeptInFiles;
use super::plan::PlanArgs;
use super::profile::ProfileArgs;
use super::render::{RenderArgs, Target};
use super::{DeviceArgs, arguments};

/// Render point clouds you can see through on many machines.
///
/// Every rank that `mpirun` starts renders a part. The first rank writes the picture, with the same bytes as
/// `pellucid`.
#[derive(Debug, Parser)]
#[command(name = "pellucid-mpi", version, max_term_width = 100)]
struct Cli {
    #[command(subcommand)]
    command: Command,
    /// Print no progress and no warnings.
    #[arg(short, long, global = true, conflicts_with = "verbose", display_order = 1000)]
    quiet: bool,
    /// Print details: files, choices, counts and times.
    #[arg(short, long, global = true, display_order = 1001)]
    verbose: bool,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Render point clouds or a scene to a picture, or to the frames of a path.
    Render {
        #[command(flatten)]
        args: RenderArgs,
        #[command(flatten)]
        sharing: SharingArgs,
        #[command(flatten)]
        spread: SpreadArgs,
    },
    /// Render a few frames and print the times of each pass and each rank.
    Profile {
        #[command(flatten)]
        args: ProfileArgs,
        #[command(flatten)]
        sharing: SharingArgs,
        #[command(flatten)]
        spread: SpreadArgs,
    },
    /// Print the ways to share the work among ranks, with the expected time of each.
    Plan {
        #[command(flatten)]
        args: PlanArgs,
        #[command(flatten)]
        sharing: SharingArgs,
        /// Plan for N ranks instead of the running ones.
        #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
        ranks: Option<u32>,
    },
}

/// The command line, for its manual pages.
pub fn command() -> clap::Command {
    <Cli as clap::CommandFactory>::command()
}

/// Parses the command line and runs its command on all ranks.
pub fn run() -> ExitCode {
    let mut ranks = match Ranks::join() {
        Ok(ranks) => ranks,
        Err(problem) => {
            print_stderr(format_args!("error: {problem}"));
            return ExitCode::FAILURE;
        }
    };
    let cli = match Cli::try_parse_from(arguments(std::env::args_os())) {
        Ok(cli) => cli,
        Err(error) => {
            if ranks.is_first() {
                let _ = error.print();
            }
            return ExitCode::from(u8::try_from(error.exit_code()).unwrap_or(2));
        }
    };
    ranks.tells = cli.verbose;
    ranks.begin("joined");
    // A message of one rank is a message of all.
    let console = Console::new(cli.quiet || !ranks.is_first(), cli.verbose && ranks.is_first());
    super::interrupt::watch();
    pellucid_engine::io::silence_decoder_panics();
    let spread = cli.command.spread();
    if let (Some(device), false) = (spread, ranks.is_first()) {
        return worker::serve(device, &ranks).unwrap_or_else(|error| fail(error, &ranks));
    }
    let ranks = if spread.is_some() { ranks.leading() } else { ranks };
    let done = match cli.command {
        Command::Render { mut args, sharing, spread } => {
            args.input.kept_in_files = kept_in_files(&sharing, spread, args.is_film(), &ranks);
            render(&args, &sharing, &ranks, console)
        }
        Command::Profile { mut args, sharing, spread } => {
            args.input.kept_in_files = kept_in_files(&sharing, spread, args.along.option().is_some(), &ranks);
            profile::run(&args, &sharing, &ranks, console)
        }
        Command::Plan { args, sharing, ranks: count } => {
            plan::run(&args, &sharing, count.map(|count| count as usize), &ranks, console)
        }
    };
    let done = done.unwrap_or_else(|error| fail(error, &ranks));
    ranks.led().into_iter().for_each(orders::stop);
    done
}

/// Returns which clouds stay in their files: those that are distributed, and octrees of which regions show parts.
fn kept_in_files(sharing: &SharingArgs, spread: SpreadArgs, is_film: bool, ranks: &Ranks) -> KeptInFiles {
    let by_windows = sharing.share == Wanted::Windows || sharing.share == Wanted::Auto && !is_film;
    if spread.spread {
        KeptInFiles::Everything
    } else if by_windows && ranks.count() > 1 {
        KeptInFiles::Octrees
    } else {
        KeptInFiles::Nothing
    }
}

fn fail(error: pellucid_engine::Error, ranks: &Ranks) -> ! {
    let error = crate::error::Error::from(error);
    ranks.fail(&crate::with_causes(&error), error.exit_status())
}

impl Command {
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
fn render(args: &RenderArgs, sharing: &SharingArgs, ranks: &Ranks, console: Console) -> Result<ExitCode> {
    let target = match together(ranks, sharing.simulation.check().and_then(|()| target(args))) {
        Ok(target) => target,
        Err(status) => return Ok(status),
    };
    match target {
        Target::One(output) => picture::run(args, sharing, &output, ranks, console),
        Target::Frames(pattern, _) | Target::Steps(pattern) => match together(ranks, args.course(console)) {
            Ok(Some(along)) => frames::run(args, sharing, (&along, &pattern), ranks, console),
            Ok(None) => Ok(ExitCode::FAILURE),
            Err(status) => Ok(status),
        },
    }
}

/// Returns the destination of pictures, if ranks can share the work.
fn target(args: &RenderArgs) -> Result<Target> {
    args.measure.check()?;
    let usage = |problem: &str| Err(Error::Usage(problem.to_owned()).into());
    if args.chooses() {
        return usage(
            "--max-error, --budget and --recalibrate measure a single device: choose with `pellucid render`, then give the \
             method here",
        );
    }
    if args.deep.is_asked() {
        return usage(
            "--deep is not supported here, because a deep file is written during rendering; use `pellucid render`",
        );
    }
    match Target::from_args(args)? {
        Target::Frames(_, films) if !films.is_none() => usage(
            "films and pages are not supported here: render numbered frames (-o frame_%04d.png), then give `pellucid render` the same \
             options and --html, or make a film of them (ffmpeg -framerate 25 -i frame_%04d.png -pix_fmt yuv420p film.mp4)",
        ),
        Target::Steps(_) => usage(
            "a time series is not supported here, because each picture depends on the previous one; \
              use `pellucid render`",
        ),
        target => Ok(target),
    }
}

/// Returns the result of a rank once all others have theirs: an error of one is an error of all, and the first rank
/// prints it.
///
/// # Errors
/// The exit status.
fn together<T>(ranks: &Ranks, done: Result<T>) -> std::result::Result<T, ExitCode> {
    let (own, said) = match done {
        Ok(own) => (Some(own), Vec::new()),
        Err(error) => {
            let error = crate::error::Error::from(error);
            let text = format!("{}: {}", ranks.name(), crate::with_causes(&error));
            (None, [vec![error.exit_status()], text.into_bytes()].concat())
        }
    };
    let all = ranks.all_told(&said);
    let Some(first) = all.iter().find(|said| !said.is_empty()) else {
        return own.ok_or(ExitCode::FAILURE);
    };
    if ranks.is_first() {
        let others = all.iter().filter(|said| !said.is_empty()).count() - 1;
        let more = if others > 0 { format!(" (and {others} other ranks)") } else { String::new() };
        print_stderr(format_args!("error: {}{more}", String::from_utf8_lossy(&first[1..])));
    }
    Err(ExitCode::from(first[0]))
}
