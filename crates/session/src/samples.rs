//! Samples of a pixel's area: as many as a picture takes, and what pictures say of them.

use pellucid_core::image::LinearImage;
use pellucid_core::metrics;
use pellucid_engine::methods::SAMPLES;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

/// The key of the metadata of pictures.
pub(crate) const SAMPLES_TAG: &str = "pellucid:samples";

/// Samples of the first picture that is compared, with one of half as many: where 4 change nothing, 2 were enough.
const FIRST: u32 = 4;

/// The most samples.
const MOST: u32 = SAMPLES[SAMPLES.len() - 1];

/// The number that `image.samples = "auto"` was settled to.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct SettledSamples {
    /// Samples per pixel, a power of two from 4 to 64.
    pub samples: u32,
    /// RMSE of the picture and the one with half as many samples: linear R, G, B over the background.
    pub error: f64,
    /// `image.sampling_error`.
    pub limit: f64,
}

impl SettledSamples {
    /// Returns `true` if the picture with half as many samples differs by no more than `image.sampling_error`.
    pub fn meets(&self) -> bool {
        self.error <= self.limit
    }

    /// Returns what is said of the number: a warning if even the most samples don't meet `image.sampling_error`.
    pub fn text(&self) -> String {
        let Self { samples, error, limit } = *self;
        let (error, half) = (metrics::error_text(error), samples / 2);
        match self.meets() {
            true => format!("{samples} samples per pixel: {half} differ by an RMSE of {error}"),
            false => format!(
                "{samples} samples per pixel, the most there are, differ from {half} by an RMSE of {error}, above \
                 image.sampling_error = {limit}"
            ),
        }
    }
}

/// Returns the metadata of a picture with so many samples; `None` of an ordinary one.
pub(crate) fn metadata(samples: u32, settled: Option<&SettledSamples>) -> Option<Value> {
    match settled.filter(|settled| settled.samples == samples) {
        Some(settled) => Some(json!({ "samples": samples, "sampling_error": settled.error })),
        None => (samples > 1).then(|| json!({ "samples": samples })),
    }
}

/// The search for the number of samples: it doubles until a picture changes little.
pub struct Settling {
    limit: f64,
    samples: u32,
    last: Option<LinearImage>,
}

impl Settling {
    /// Begins with the picture that the first one is compared with; `limit` is `image.sampling_error`.
    pub fn new(limit: f32) -> Self {
        // The decimal number that was written, not what float32 makes of it.
        let limit = limit.to_string().parse().unwrap_or(f64::from(limit));
        Self { limit, samples: FIRST / 2, last: None }
    }

    /// Returns the number of samples of the picture that is wanted next.
    pub fn samples(&self) -> u32 {
        self.samples
    }

    /// Takes that picture; returns the number once it is settled, which is then the picture's own.
    pub fn take(&mut self, picture: LinearImage) -> Option<SettledSamples> {
        let last = self.last.take();
        let error = last.map(|last| metrics::rmse(&picture.pixels, &last.pixels));
        let samples = self.samples;
        let settled = error.map(|error| SettledSamples { samples, error, limit: self.limit });
        if let Some(settled) = settled.filter(|settled| settled.meets() || samples >= MOST) {
            return Some(settled);
        }
        (self.samples, self.last) = (2 * samples, Some(picture));
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn gray(value: f32) -> LinearImage {
        LinearImage { width: 2, height: 1, pixels: vec![[value; 3], [0.0; 3]] }
    }

    /// Two pixels, of which one changes by d: an RMSE of d / √2.
    #[test]
    fn samples_double_until_a_picture_changes_little() {
        let mut settling = Settling::new(0.01);
        let mut asked = Vec::new();
        let mut take = |value: f32| {
            asked.push(settling.samples());
            settling.take(gray(value))
        };
        assert_eq!(take(0.5), None);
        assert_eq!(take(0.25), None);
        assert_eq!(take(0.125), None);
        let settled = take(0.125 + 1.0 / 128.0).unwrap();
        assert_eq!((settled.samples, settled.limit, settled.meets()), (16, 0.01, true));
        assert!((settled.error - 0.5f64.sqrt() / 128.0).abs() < 1e-12, "{settled:?}");
        assert_eq!(settled.text(), "16 samples per pixel: 8 differ by an RMSE of 5.52e-3");
        assert_eq!(asked, [2, 4, 8, 16]);
    }

    #[test]
    fn a_picture_that_does_not_change_has_4_samples_and_one_that_always_does_64() {
        let mut settling = Settling::new(0.003);
        assert_eq!(settling.take(gray(0.5)), None);
        assert_eq!(settling.take(gray(0.5)), Some(SettledSamples { samples: 4, error: 0.0, limit: 0.003 }));
        let (mut settling, mut values) = (Settling::new(0.003), [0.0, 1.0].into_iter().cycle());
        let settled = std::iter::from_fn(|| Some(settling.take(gray(values.next()?)))).flatten().next().unwrap();
        assert_eq!((settled.samples, settled.meets()), (64, false));
        assert_eq!(
            settled.text(),
            "64 samples per pixel, the most there are, differ from 32 by an RMSE of 7.07e-1, above image.sampling_error = \
             0.003"
        );
    }

    #[test]
    fn metadata_have_the_number_and_the_figure_that_settled_it() {
        let settled = SettledSamples { samples: 8, error: 0.25, limit: 0.5 };
        assert_eq!(metadata(1, None), None);
        assert_eq!(metadata(8, None), Some(json!({ "samples": 8 })));
        assert_eq!(metadata(8, Some(&settled)), Some(json!({ "samples": 8, "sampling_error": 0.25 })));
        assert_eq!(metadata(1, Some(&settled)), None);
    }
}
