//! What goes to standard output (results, nothing else) and to standard error (all else).

use std::fmt::Display;
use std::io::{self, ErrorKind, IsTerminal, Write};

use pellucid_engine::{Result, output};

use super::bar::Bar;

/// How much is said on standard error.
#[derive(Debug, Clone, Copy)]
pub struct Talk {
    quiet: bool,
    verbose: bool,
}

impl Talk {
    pub fn new(quiet: bool, verbose: bool) -> Self {
        Self { quiet, verbose }
    }

    /// For what was said before: only details.
    pub fn once_said(self) -> Self {
        Self { quiet: true, ..self }
    }

    /// A warning, unless the user wants none.
    pub fn warn(self, warning: impl Display) {
        if !self.quiet {
            say(format_args!("warning: {warning}"));
        }
    }

    /// What somebody asked to be told, unless they want nothing to be said.
    pub fn note(self, note: impl Display) {
        if !self.quiet {
            say(note);
        }
    }

    /// A detail for those who asked for more.
    pub fn detail(self, detail: impl Display) {
        if self.verbose {
            say(detail);
        }
    }

    /// A progress bar: on a terminal only, and only once the work has lasted a second.
    pub fn progress(self) -> Bar {
        Bar::new(!self.quiet && io::stderr().is_terminal())
    }
}

/// One line on standard error; without a standard error there is nobody to tell.
pub fn say(line: impl Display) {
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

/// One JSON document on standard output.
pub fn print_json(value: &serde_json::Value) -> Result<()> {
    print(&format!("{value:#}\n"))
}
