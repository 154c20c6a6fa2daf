//! All settings on one image, one by one, for whoever compares images (tools/study).

use pellucid_engine::Result;
use pellucid_engine::gpu::Device;
use pellucid_engine::methods::Rendered;
use pellucid_engine::passes::project::DeviceCloud;
use pellucid_engine::progress::Progress;

use super::trials::Trials;
use super::{Figures, Subject};
use crate::candidates::{Ladders, Setting, settings};

/// Lists of an image of the exact method.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Lists {
    /// Fragments of all lists.
    pub fragments: u64,
    /// Pixels with an opacity above 0.
    pub covered: u64,
    /// The longest list.
    pub longest: u32,
}

impl Lists {
    /// Returns the statistics of a frame's fragment lists.
    pub fn of(rendered: &Rendered) -> Self {
        let covered = rendered.image.rgba.iter().filter(|[_, _, _, alpha]| *alpha > 0.0).count() as u64;
        Self { fragments: rendered.facts.fragments, covered, longest: rendered.facts.max_list }
    }

    /// The mean list of the covered pixels; 0 if none is.
    pub fn mean(&self) -> f64 {
        self.fragments as f64 / self.covered.max(1) as f64
    }
}

/// The measurements of a setting.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Measured {
    /// Error, and the median time of the frames behind it.
    pub figures: Figures,
    /// Largest number of device bytes at any time of a frame, cloud and image included.
    pub peak_device_bytes: u64,
}

/// Measures settings as a choice does, but those that are asked for, and without what earlier choices measured.
pub struct Survey<'a> {
    trials: Trials<'a>,
}

impl<'a> Survey<'a> {
    /// Renders the image of the exact method.
    ///
    /// # Errors
    /// Errors of [`super::choose`].
    pub fn open(
        device: &'a Device,
        cloud: &'a mut DeviceCloud,
        subject: &'a Subject<'a>,
        progress: &'a Progress,
    ) -> Result<Self> {
        Ok(Self { trials: Trials::open(device, cloud, subject, true, progress)? })
    }

    /// The settings that apply, each ladder ascending, exact methods first.
    pub fn settings(&self, ladders: &Ladders) -> Vec<Setting> {
        settings(&self.trials.occasion(), ladders).0
    }

    /// The error of a setting and the median time of so many frames, at least 1, after one that pays for buffers and
    /// shaders; `None` if the device can't render it. A frame that takes more than `most` ms is the last one.
    ///
    /// # Errors
    /// A lost device, a message of the validation layers.
    pub fn measure(&mut self, setting: &Setting, frames: usize, most: Option<f64>) -> Result<Option<Measured>> {
        self.trials.measure(setting, frames, most)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn means_are_those_of_covered_pixels() {
        assert_eq!(Lists { fragments: 30, covered: 4, longest: 9 }.mean(), 7.5);
        assert_eq!(Lists::default().mean(), 0.0);
    }
}
