//! Messages about the work for people.

use std::cell::RefCell;
use std::fmt::Display;

/// Receiver of messages for people, one sentence each.
pub trait Messages {
    /// Reports that something does not come out as requested.
    fn warn(&self, warning: &dyn Display);
    /// Reports something that nobody requested and many want to know.
    fn note(&self, note: &dyn Display);
    /// Reports a detail of the work.
    fn detail(&self, _detail: &dyn Display) {}
    /// Returns an option of the command line as the caller would name it, such as `--max-error` or `max_error`.
    fn name(&self, option: &str) -> String {
        format!("--{option}")
    }
    /// Returns an option with its value as the caller would write it, such as `--see-through 0.5` or `see_through=0.5`.
    fn option(&self, option: &str, value: &dyn Display) -> String {
        format!("{} {value}", self.name(option))
    }
}

/// Receiver that drops all messages.
pub struct Silent;

impl Messages for Silent {
    fn warn(&self, _warning: &dyn Display) {}
    fn note(&self, _note: &dyn Display) {}
}

/// Warnings that were given already, so that a loop of frames gives each one once.
#[derive(Debug, Default)]
pub(crate) struct Told(RefCell<Vec<String>>);

impl Told {
    /// Returns a receiver that passes each warning on once.
    pub fn to<'a>(&'a self, messages: &'a dyn Messages) -> Once<'a> {
        Once { told: self, messages }
    }
}

/// Receiver that passes each warning on once.
pub(crate) struct Once<'a> {
    told: &'a Told,
    messages: &'a dyn Messages,
}

impl Messages for Once<'_> {
    fn warn(&self, warning: &dyn Display) {
        let warning = warning.to_string();
        let mut told = self.told.0.borrow_mut();
        if !told.contains(&warning) {
            self.messages.warn(&warning);
            told.push(warning);
        }
    }

    fn note(&self, note: &dyn Display) {
        self.messages.note(note);
    }

    fn detail(&self, detail: &dyn Display) {
        self.messages.detail(detail);
    }

    fn name(&self, option: &str) -> String {
        self.messages.name(option)
    }

    fn option(&self, option: &str, value: &dyn Display) -> String {
        self.messages.option(option, value)
    }
}
