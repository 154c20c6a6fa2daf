//! `[detail]`.

use crate::schema::{Range, Slider, settings};

settings! {
    /// `[detail]`: which points a picture does without, so that the others grow to cover. By default none.
    #[derive(Copy, serde::Serialize, serde::Deserialize)]
    pub struct Detail {
        /// Points that are closer to each other than this are thinned out; 0 keeps all.
        spacing_px: f32 = 0.0, in Range::NOT_NEGATIVE, unit "pixels", slider Slider::Linear(0.0, 16.0);
        /// Largest number of points in the picture; the finest levels are left out.
        max_points: Option<u32> = None, in 1..=u32::MAX, without "no limit", start 1_000_000.0;
    }
}

impl Detail {
    /// Returns `true` if every point is drawn.
    pub fn is_whole(&self) -> bool {
        self.spacing_px == 0.0 && self.max_points.is_none()
    }
}
