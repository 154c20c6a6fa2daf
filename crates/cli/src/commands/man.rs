//! `pellucid man`: the manual pages, one for the program and one for each command.

use std::path::PathBuf;

use clap::{Args, Command, CommandFactory};
use clap_mangen::Man;
use pellucid_engine::Result;
use pellucid_io::output::{Files, Output, check_report_folder, make_folder};

use super::Cli;
use super::console::Console;
use super::touched::{Touched, Touches};

/// The day of the release, in the pages' footer. Without one, `man` shows the version in its place.
const RELEASED: &str = "2026-11-27";

#[derive(Debug, Args)]
pub struct ManArgs {
    /// Folder for the pages, `pellucid.1`, `pellucid-render.1` and so on; created if it isn't there.
    #[arg(value_name = "DIR")]
    folder: PathBuf,
}

impl Touches for ManArgs {
    fn touched(&self) -> Result<Touched> {
        Ok(Touched::default().and([Output::folder("", &self.folder, &[".1"])]))
    }
}

pub fn run(args: ManArgs, console: Console) -> Result<()> {
    check_report_folder(&args.folder)?;
    let _folder = make_folder(&args.folder)?;
    let mut files = Files::default();
    for page in pages() {
        files.add(&args.folder.join(page.get_filename()), |file| page.render(file))?;
    }
    files.publish()?;
    console.detail(format_args!("{}: manual pages written", args.folder.display()));
    Ok(())
}

/// The pages of the programs that are built, each before those of its commands.
fn pages() -> Vec<Man> {
    #[cfg(not(feature = "mpi"))]
    let programs = [Cli::command()];
    #[cfg(feature = "mpi")]
    let programs = [Cli::command(), super::command_of_ranks()];
    programs.into_iter().flat_map(pages_of).collect()
}

fn pages_of(program: Command) -> Vec<Man> {
    // Its page would repeat the list of commands.
    let mut program = program.disable_help_subcommand(true);
    // Gives commands their full names and the options that all share.
    program.build();
    let version = format!("{} {}", program.get_name(), env!("CARGO_PKG_VERSION"));
    let commands: Vec<Command> = program.get_subcommands().cloned().collect();
    let page = |command| Man::new(command).date(RELEASED).source(version.clone()).manual("User Commands");
    std::iter::once(program).chain(commands).map(page).collect()
}
