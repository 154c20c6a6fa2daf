//! Terminal output: results on standard output, everything else on standard error.

use std::fmt::Display;
use std::io::{self, ErrorKind, IsTerminal, Write};
use std::sync::{Mutex, MutexGuard, PoisonError};

use pellucid_engine::Result;
use pellucid_io::output;
use pellucid_session::Messages;

use super::bar::{Bar, Shows};

/// The destination of a command's output.
#[derive(Debug, Clone, Copy)]
pub enum Streams {
    /// Standard output and standard error.
    Process,
    /// Memory.
    Captured(&'static Mutex<Captured>),
}

/// The output of a command that ran inside another program.
#[derive(Debug, Default)]
pub struct Captured {
    /// Results.
    pub stdout: String,
    /// Errors, warnings and notes.
    pub stderr: String,
}

fn locked(captured: &Mutex<Captured>) -> MutexGuard<'_, Captured> {
    captured.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Streams {
    /// True for the streams of the process.
    pub fn is_process(self) -> bool {
        matches!(self, Self::Process)
    }

    /// Prints a result. A reader that has seen enough (`| head`) is no error.
    fn print(self, text: &str) -> Result<()> {
        let mut stdout = match self {
            Self::Process => io::stdout().lock(),
            Self::Captured(captured) => {
                locked(captured).stdout.push_str(text);
                return Ok(());
            }
        };
        match stdout.write_all(text.as_bytes()).and_then(|()| stdout.flush()) {
            Err(error) if error.kind() != ErrorKind::BrokenPipe => Err(output::Error::Stdout(error).into()),
            _ => Ok(()),
        }
    }

    /// Prints one line on standard error; without a standard error the line is lost.
    pub fn print_stderr(self, line: impl Display) {
        match self {
            Self::Process => {
                // In one piece, or another stream's lines would come between its parts.
                let _ = io::stderr().write_all(format!("{line}\n").as_bytes());
            }
            Self::Captured(captured) => {
                locked(captured).stderr.push_str(&format!("{line}\n"));
            }
        }
    }

    /// Prints a mistake of the command line, or the help or version that it asks for.
    pub fn print_usage(self, stopped: &clap::Error) {
        match self {
            // Without the stream there is nobody to tell.
            Self::Process => drop(stopped.print()),
            Self::Captured(captured) => {
                let mut captured = locked(captured);
                let Captured { stdout, stderr } = &mut *captured;
                let stream = if stopped.use_stderr() { stderr } else { stdout };
                stream.push_str(&stopped.render().to_string());
            }
        }
    }
}

/// The verbosity of standard error, and where it and the results go.
#[derive(Debug, Clone, Copy)]
pub struct Console {
    quiet: bool,
    verbose: bool,
    streams: Streams,
}

impl Console {
    pub fn new(quiet: bool, verbose: bool, streams: Streams) -> Self {
        Self { quiet, verbose, streams }
    }

    /// Returns a console for output that repeats an earlier one: only details.
    pub fn without_repeats(self) -> Self {
        Self { quiet: true, ..self }
    }

    /// Prints a warning unless --quiet is given.
    pub fn warn(self, warning: impl Display) {
        if !self.quiet {
            self.report(format_args!("warning: {warning}"));
        }
    }

    /// Prints requested information unless --quiet is given.
    pub fn note(self, note: impl Display) {
        if !self.quiet {
            self.report(note);
        }
    }

    /// True if somebody asked for details.
    pub fn is_verbose(self) -> bool {
        self.verbose
    }

    /// A detail for those who asked for more.
    pub fn detail(self, detail: impl Display) {
        if self.verbose {
            self.report(detail);
        }
    }

    /// Prints one line on standard error, even with --quiet.
    pub fn report(self, line: impl Display) {
        self.streams.print_stderr(line);
    }

    /// Prints a result on standard output. A reader that has seen enough (`| head`) is no error.
    pub fn print(self, text: &str) -> Result<()> {
        self.streams.print(text)
    }

    /// Prints one JSON document on standard output.
    pub fn print_json(self, value: &serde_json::Value) -> Result<()> {
        self.print(&format!("{value:#}\n"))
    }

    /// A progress bar once the work has lasted a second; without a terminal a line each ten seconds.
    pub fn progress(self) -> Bar {
        let shows = match self.streams {
            Streams::Process if self.quiet => Shows::Nothing,
            Streams::Process if io::stderr().is_terminal() => Shows::Bar,
            Streams::Process => Shows::Lines,
            Streams::Captured(_) => Shows::Nothing,
        };
        Bar::new(self, shows)
    }
}

impl Messages for Console {
    fn warn(&self, warning: &dyn Display) {
        Console::warn(*self, warning);
    }

    fn note(&self, note: &dyn Display) {
        Console::note(*self, note);
    }

    fn detail(&self, detail: &dyn Display) {
        Console::detail(*self, detail);
    }
}
