//! A window to render: how many ensembles, slots and epochs a dispatch takes.

use super::rounds::{Epochs, epoch_bits};
use super::share::Share;
use super::variants::{Form, SpbrKind};
use super::{is_listed, largest, small_square};
use crate::methods::prelude::*;
use crate::scene::Spbr;

/// Slots of a round from which on more ensembles at once gain nothing, for each piece of work that keeps a device busy.
const ROUND_SLOTS: u64 = 1 << 10;
/// Most slots of a dispatch, and of one whose large squares may all be on the list.
const DISPATCH_SLOTS: u64 = 1 << 24;
/// See [`DISPATCH_SLOTS`].
const LISTED_SLOTS: u64 = 1 << 20;
/// Most ensembles of a round.
const MOST_PLANES: u64 = 4096;
/// Steps of an invocation of a large square at most.
const LARGE_STEPS: u64 = 8192;

/// Everything that stays the same while a window is rendered.
pub struct SpbrJob<'a> {
    /// The cloud, its view set.
    pub cloud: &'a DeviceCloud,
    /// The window.
    pub window: Window,
    /// Shading and color space.
    pub how: &'a Projecting,
    /// The share of each cloud.
    pub shares: &'a [Share],
    /// Ensembles of an image, and of all images to which points are dealt together.
    pub ensembles: [u32; 2],
    /// The method.
    pub method: Method,
    /// Ensembles that are drawn, of those of all images.
    pub drawn: Range<u32>,
    /// Seed.
    pub seed: u64,
    /// `true` if the standard error is asked for.
    pub spread: bool,
    /// `true` if the width of points depends on depth.
    pub perspective: bool,
    /// Way to find the nearest points.
    pub form: Form,
    /// Points on the device at a time, if not all: see `stream::window_points`. [`Form::Single`] needs all.
    pub streamed: Option<u64>,
    /// Most bits of a key for epochs.
    pub most_epoch_bits: u32,
    /// Pieces of work that keep the device busy.
    pub concurrent: u64,
    /// `true` if the invocations of a workgroup share the pixels of its squares.
    pub shares_squares: bool,
    /// The budget.
    pub budget: Budget,
}

impl SpbrJob<'_> {
    pub(super) fn pixels(&self) -> u64 {
        bands::pixels(self.window)
    }

    pub(super) fn kind(&self) -> SpbrKind {
        let weighted = matches!(self.method, Method::Spbr(_)) && self.shares.iter().any(|s| !s.uniform);
        let slanted = matches!(self.method, Method::Spbr(Spbr { cos_theta: false, .. })) && self.cloud.has_normals();
        SpbrKind {
            weighted,
            slanted,
            thinned: weighted || slanted || self.perspective,
            squares: largest(self.shares) > 1.0,
            planes: self.planes() > 1,
            spread: self.spread,
        }
    }

    pub(super) fn listed(&self) -> bool {
        is_listed(self.shares, small_square(self.shares_squares))
    }

    /// Returns the largest number of slots of a dispatch.
    pub(super) fn dispatch_slots(&self) -> u64 {
        if !self.listed() {
            return DISPATCH_SLOTS;
        }
        LISTED_SLOTS.min(self.budget.bytes / 8 / 32).min(self.budget.binding / 32).max(64)
    }

    /// Ensembles of a round: as many as planes fit a binding and half of the budget, but no more than make it worth
    /// while.
    pub(super) fn planes(&self) -> u64 {
        let slots: u64 = self.shares.iter().map(|s| s.slots).sum();
        let worth = ROUND_SLOTS * self.concurrent * u64::from(self.ensembles[1]) / slots.max(1);
        let bytes = 8 * self.pixels();
        let fit = (self.budget.binding / bytes).min(self.budget.bytes / 2 / bytes);
        worth.clamp(1, MOST_PLANES).min(fit).min(self.drawn.len() as u64).max(1)
    }

    /// Returns `true` if a pixel's nearest point stands beside its sums.
    pub(super) fn is_inline(&self) -> bool {
        self.form == Form::Single && self.planes() == 1
    }

    /// Returns a word of a plane that holds nothing: `spbr/draw` looks for the largest key, the other forms for its
    /// smallest complement.
    pub(super) fn nothing(&self) -> u32 {
        if self.form == Form::Single { 0 } else { u32::MAX }
    }

    /// Returns `true` if the rounds outnumber the epochs of planes that no fill can clear.
    pub fn is_renewed(&self) -> bool {
        self.is_inline() && self.drawn.len() as u64 > u64::from(Epochs::most(self.epoch_bits()))
    }

    /// Returns the number of points that a dispatch can bind.
    pub(super) fn longest(&self) -> u64 {
        self.streamed.unwrap_or(u64::MAX).min(self.cloud.longest())
    }

    /// Returns the number of bits of keys for epochs.
    pub(super) fn epoch_bits(&self) -> u32 {
        if self.form == Form::Narrow { 0 } else { epoch_bits(self.cloud.len()).min(self.most_epoch_bits) }
    }

    pub(super) fn scale(&self) -> Scale {
        Scale::new(self.ensembles[0], self.cloud.max_color(self.how))
    }

    /// Returns the number of workgroups of a large square.
    pub(super) fn stripes(&self) -> u64 {
        self.pixels().div_ceil(LARGE_STEPS * u64::from(crate::gpu::shader::WORKGROUP))
    }
}

/// Scale by which colors become whole numbers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scale {
    /// The whole number for a color of 1.
    pub one: f32,
    /// The most that a color may be: with `ensembles` times that a sum still has 32 bits.
    pub most: f32,
}

impl Scale {
    /// Creates the scale for `ensembles` ensembles and colors of up to `max_color`: a power of two, at most 2^22.
    pub fn new(ensembles: u32, max_color: f32) -> Self {
        let most = f64::from(u32::MAX / ensembles.max(1));
        let bits = (most / f64::from(max_color.max(1.0))).log2().floor().clamp(0.0, 22.0);
        // Rounded down.
        let float = most as f32;
        Self { one: bits.exp2() as f32, most: if f64::from(float) > most { float.next_down() } else { float } }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sums_of_whole_colors_fit_32_bits() {
        for ensembles in [1, 2, 3, 100, 1000, 1023, 1024, 65_535, 65_536] {
            for max_color in [0.0f32, 0.3, 1.0, 1.001, 2.5, 1e3] {
                let Scale { one, most } = Scale::new(ensembles, max_color);
                assert!(one.log2().fract() == 0.0 && (1.0..=4_194_304.0).contains(&one), "{one}");
                assert!(f64::from(most) * f64::from(ensembles) <= f64::from(u32::MAX), "{ensembles}, {most}");
                assert!(one * max_color <= most, "{ensembles}, {max_color}");
            }
        }
        // With 100 ensembles a color of 1 has all of the bits.
        assert_eq!(Scale::new(100, 1.0).one, 4_194_304.0);
    }
}
