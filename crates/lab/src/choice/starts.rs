//! Settings that were the fastest on the scenes of a study: where a choice by error begins.

use serde::{Deserialize, Serialize};

/// Written by `cargo run --example study -- --starts`.
const RELEASED: &str = include_str!("starts.json");

/// The fastest settings by the kind of device, the length of lists and the wanted error.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Starts {
    /// Measured on drivers that run on a CPU.
    pub cpu: Vec<Start>,
    /// Measured on GPUs; empty as long as none was.
    pub gpu: Vec<Start>,
}

/// The fastest settings of one length of lists and one wanted error.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Start {
    /// Mean list of the pixels that hold any fragment.
    pub mean: f64,
    /// The largest RMSE allowed.
    pub error: f64,
    /// Keys of settings ([`crate::report::tradeoff::settings::Setting::key`]), the best one first.
    pub first: Vec<String>,
}

impl Starts {
    /// Those of this version.
    pub fn released() -> Self {
        // A test reads the same text: it can't be another.
        serde_json::from_str(RELEASED).unwrap_or_default()
    }

    /// Those of a kind of device, as [`pellucid_engine::gpu::DeviceInfo::kind`] names it.
    fn of(&self, kind: &str) -> &[Start] {
        if kind == "CPU" { &self.cpu } else { &self.gpu }
    }

    /// The keys to try first on lists of this mean where the RMSE may be at most `most`: those of the nearest mean, by its logarithm,
    /// and of the largest error that is no larger. Empty if nothing as accurate was measured.
    pub fn first(&self, kind: &str, mean: f64, most: f64) -> &[String] {
        let distance = |start: &Start| (start.mean.ln() - mean.ln()).abs();
        let fits = self.of(kind).iter().filter(|start| start.error <= most);
        let nearest = fits.min_by(|a, b| distance(a).total_cmp(&distance(b)).then(b.error.total_cmp(&a.error)));
        nearest.map_or(&[], |start| &start.first)
    }
}

#[cfg(test)]
mod tests {
    use pellucid_engine::points::Points;
    use pellucid_engine::scene::Discs;

    use super::*;
    use crate::report::tradeoff::settings::{Formation, Ladders, Occasion, settings};

    fn start(mean: f64, error: f64, key: &str) -> Start {
        Start { mean, error, first: vec![key.to_owned()] }
    }

    #[test]
    fn the_nearest_mean_and_the_largest_error_within_the_wish() {
        let cpu = vec![
            start(5.0, 0.05, "a"),
            start(5.0, 0.01, "b"),
            start(50.0, 0.05, "c"),
            start(50.0, 0.01, "d"),
            start(50.0, 0.002, "e"),
        ];
        let starts = Starts { cpu, gpu: vec![start(5.0, 0.05, "g")] };
        let first = |mean, most| starts.first("CPU", mean, most).concat();
        assert_eq!([first(5.0, 0.1), first(5.0, 0.05), first(5.0, 0.04), first(5.0, 0.01)], ["a", "a", "b", "b"]);
        // The geometric mean of 5 and 50 is 15.8.
        assert_eq!([first(15.7, 0.02), first(15.9, 0.02), first(1e4, 0.02), first(1e-3, 0.02)], ["b", "d", "d", "b"]);
        assert_eq!(first(5.0, 0.005), "e", "another mean is better than nothing");
        assert_eq!(first(50.0, 0.001), "");
        assert_eq!(starts.first("discrete", 40.0, 0.05), ["g"]);
    }

    #[test]
    fn the_released_ones_are_settings_that_a_choice_considers() {
        let starts: Starts = serde_json::from_str(RELEASED).unwrap();
        assert_eq!(starts, Starts::released());
        let occasion = Occasion::new(&Points::default(), Formation::Discs(Discs::default()), u32::MAX);
        let (mut all, _) = settings(&Occasion { opaque: false, ..occasion }, &Ladders::FINE);
        all.retain(|setting| setting.detail.is_whole());
        for start in starts.cpu.iter().chain(&starts.gpu) {
            assert!(start.mean > 0.0 && start.error > 0.0 && !start.first.is_empty(), "{start:?}");
            for key in &start.first {
                assert!(all.iter().any(|setting| setting.key() == *key), "{key}");
            }
        }
    }
}
