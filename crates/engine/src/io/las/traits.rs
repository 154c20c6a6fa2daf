//! What only all points of a LAS file tell together.

use super::header::Header;
use crate::io::LasColumns;

/// What decides about columns as a whole: whether colors have 8 bits or 16, whether returns are kept, when times begin.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::io) struct Traits {
    /// The largest stored red, green or blue; 0 where there are none.
    pub largest_color: u16,
    /// The largest number of returns of a pulse.
    pub most_returns: u8,
    /// The earliest finite GPS time in seconds, if times are read; infinite if there is none.
    pub first_time: f64,
}

impl Traits {
    /// Those of no point.
    pub const NONE: Self = Self { largest_color: 0, most_returns: 0, first_time: f64::INFINITY };

    /// Those of two parts together.
    #[must_use]
    pub fn and(self, more: Self) -> Self {
        Self {
            largest_color: self.largest_color.max(more.largest_color),
            most_returns: self.most_returns.max(more.most_returns),
            first_time: self.first_time.min(more.first_time),
        }
    }

    /// True if whatever the other points of the file are changes no column.
    pub fn are_settled(&self, header: &Header, asked: LasColumns) -> bool {
        let colors = !header.format.has_color || self.largest_color > u16::from(u8::MAX);
        let returns = asked.returns || self.most_returns > 1;
        let times = !(asked.gps_time && header.format.has_gps_time);
        colors && returns && times
    }
}
