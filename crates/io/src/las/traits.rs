//! Facts that only all points of a LAS file tell together.

use crate::channel::full_integer;

/// Facts that decide about columns as a whole: how many bits colors have, whether returns are kept, when times
/// begin.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Traits {
    /// The largest stored red, green or blue; 0 where there are none.
    pub largest_color: u16,
    /// The largest number of returns of a pulse.
    pub most_returns: u8,
    /// The earliest finite GPS time in seconds, if times are read; infinite if there is none.
    pub first_time: f64,
}

impl Traits {
    /// Traits of no points.
    pub const NONE: Self = Self { largest_color: 0, most_returns: 0, first_time: f64::INFINITY };

    /// Returns those of two parts together.
    #[must_use]
    pub fn and(self, more: Self) -> Self {
        Self {
            largest_color: self.largest_color.max(more.largest_color),
            most_returns: self.most_returns.max(more.most_returns),
            first_time: self.first_time.min(more.first_time),
        }
    }

    /// Returns `true` if a file with these columns needs no second look: whatever its other points are changes no
    /// column.
    pub fn settle(&self, has_color: bool, has_times: bool, keeps_returns: bool) -> bool {
        let colors = !has_color || full_integer(self.largest_color.into()) == u16::MAX;
        let returns = keeps_returns || self.most_returns > 1;
        colors && returns && !has_times
    }
}
