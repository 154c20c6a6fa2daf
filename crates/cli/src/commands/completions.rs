//! `pellucid completions`: the script that completes the command line in a shell.

use clap::{Args, CommandFactory};
use clap_complete::Shell;
use pellucid_engine::Result;

use super::Cli;
use super::console::Console;
use super::touched::{Touched, Touches};

#[derive(Debug, Args)]
pub struct CompletionsArgs {
    /// The shell.
    shell: Shell,
}

impl Touches for CompletionsArgs {
    fn touched(&self) -> Result<Touched> {
        Ok(Touched::default())
    }
}

pub fn run(args: CompletionsArgs, console: Console) -> Result<()> {
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut Cli::command(), "pellucid", &mut script);
    console.print(&String::from_utf8_lossy(&script))
}
