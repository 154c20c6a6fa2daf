//! Points that stand apart, of a `[[cloud]]`.

use crate::prepare::outliers::Rule;
use crate::scene::schema::{Range, Slider, settings, words};

settings! {
    /// Keys of `[[cloud]]` about points that stand apart from the others.
    #[derive(Copy)]
    pub struct Strays {
        /// Estimated radii are at most so many times the median of the radii around them; 0 is no limit.
        radius_cap: Option<f32> = None, in Range::NOT_NEGATIVE, without "that of a prepared file, else 4", start 4.0,
            slider Slider::Linear(0.0, 16.0);
        /// What becomes of points whose mean distance to their neighbors is far above that of others.
        outliers: Outliers = Outliers::Keep;
        /// Neighbors over which that mean distance is taken.
        outlier_k: usize = 16, in 1..=65_535, slider Slider::Count(1, 64);
        /// A point is an outlier from so many standard deviations above the mean of the cloud.
        outlier_factor: f32 = 3.0, in Range::NOT_NEGATIVE, slider Slider::Linear(0.0, 10.0);
    }
}

words! {
    /// `outliers`.
    pub enum Outliers {
        /// They are points as others are.
        Keep = "keep",
        /// Methods of soft points take them for soft: F = 1.
        Soft = "soft",
        /// They are left out, and the picture is framed without them.
        Drop = "drop",
    }
}

impl Strays {
    /// Which points are outliers, if this becomes of them.
    pub fn rule(&self, treatment: Outliers) -> Option<Rule> {
        (self.outliers == treatment).then_some(Rule { k: self.outlier_k, factor: self.outlier_factor })
    }
}
