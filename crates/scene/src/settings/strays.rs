//! Points that stand apart, of a `[[cloud]]`.

use crate::prepare::outliers::Rule;
use crate::schema::{Range, Slider, settings, words};

settings! {
    /// Keys of `[[cloud]]` about points that stand apart from the others.
    #[derive(Copy)]
    pub struct Strays {
        /// Largest estimated radius, as a multiple of the median radius around it; 0 means no limit.
        radius_cap: Option<f32> = None, in Range::NOT_NEGATIVE, without "that of a prepared file, else 4", start 4.0,
            slider Slider::Linear(0.0, 16.0);
        /// Treatment of outliers: points whose mean distance to their neighbors is far above that of others.
        outliers: Outliers = Outliers::Keep;
        /// Number of neighbors in that mean distance.
        outlier_k: usize = 16, in 1..=65_535, slider Slider::Count(1, 64);
        /// Limit for outliers, in standard deviations above the mean of the cloud.
        outlier_factor: f32 = 3.0, in Range::NOT_NEGATIVE, slider Slider::Linear(0.0, 10.0);
    }
}

words! {
    /// `outliers`.
    pub enum Outliers {
        /// Outliers are drawn like other points.
        Keep = "keep",
        /// Methods of soft points draw them as soft: F = 1.
        Soft = "soft",
        /// Outliers are left out, also when the picture is framed.
        Drop = "drop",
    }
}

impl Strays {
    /// Returns the rule that tells which points are outliers, if this is their treatment.
    pub fn rule(&self, treatment: Outliers) -> Option<Rule> {
        (self.outliers == treatment).then_some(Rule { k: self.outlier_k, factor: self.outlier_factor })
    }
}
