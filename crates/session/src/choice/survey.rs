//! Measurements of single settings and images, for those who compare them (tools/study).

use pellucid_engine::methods::Rendered;

use super::Figures;

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
pub struct TrialResult {
    /// Error, and the median time of the frames behind it, each as a whole.
    pub figures: Figures,
    /// Largest number of device bytes at any time of a frame, cloud and image included.
    pub peak_device_bytes: u64,
    /// `false` if the device's clock moved while the frames were measured: their time must not be used.
    pub is_steady: bool,
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
