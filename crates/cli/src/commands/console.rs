//! Terminal output: results on standard output, everything else on standard error.

use std::fmt::Display;
use std::io::{self, ErrorKind, IsTerminal, Write};

use pellucid_engine::{Result, output};
use pellucid_session::Messages;

use super::bar::Bar;

/// The verbosity of standard error.
#[derive(Debug, Clone, Copy)]
pub struct Console {
    quiet: bool,
    verbose: bool,
}

impl Console {
    pub fn new(quiet: bool, verbose: bool) -> Self {
        Self { quiet, verbose }
    }

    /// Returns a console for output that repeats an earlier one: only details.
    pub fn without_repeats(self) -> Self {
        Self { quiet: true, ..self }
    }

    /// Prints a warning unless --quiet is given.
    pub fn warn(self, warning: impl Display) {
        if !self.quiet {
            print_stderr(format_args!("warning: {warning}"));
        }
    }

    /// Prints requested information unless --quiet is given.
    pub fn note(self, note: impl Display) {
        if !self.quiet {
            print_stderr(note);
        }
    }

    /// True if somebody asked for details.
    pub fn is_verbose(self) -> bool {
        self.verbose
    }

    /// A detail for those who asked for more.
    pub fn detail(self, detail: impl Display) {
        if self.verbose {
            print_stderr(detail);
        }
    }

    /// A progress bar: on a terminal only, and only once the work has lasted a second.
    pub fn progress(self) -> Bar {
        Bar::new(!self.quiet && io::stderr().is_terminal())
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

/// Prints a line on standard error; without a standard error the line is lost.
pub fn print_stderr(line: impl Display) {
    let _ = writeln!(io::stderr(), "{line}");
}

/// A result on standard output. A reader that has seen enough (`| head`) is no error.
pub fn print(text: &str) -> Result<()> {
    let mut stdout = io::stdout().lock();
    match stdout.write_all(text.as_bytes()).and_then(|()| stdout.flush()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => Err(output::Error::Stdout(error).into()),
        _ => Ok(()),
    }
}

/// Prints a JSON document on standard output.
pub fn print_json(value: &serde_json::Value) -> Result<()> {
    print(&format!("{value:#}\n"))
}
