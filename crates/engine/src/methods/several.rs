//! Images of a frame with samples whose nearest points are found together.

use crate::passes::project::PointsPush;

/// Images of a frame with samples whose nearest points are found by one walk over the points.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Several {
    /// Turn of the first one.
    pub first: u32,
    /// Number of them.
    pub images: u32,
    /// Number of all images of the frame.
    pub samples: u32,
    /// Elements from an image's nearest points to the next one's.
    pub stride: u32,
    /// `true` if all points are shaded once.
    pub shaded: bool,
}

impl Several {
    /// Returns the push constants of a walk that finds them.
    pub fn of(self, push: PointsPush) -> PointsPush {
        let Self { first, images, samples, stride, .. } = self;
        PointsPush { first_turn: first, images, samples, stride, ..push }
    }

    /// Returns `true` if the image whose turn it is belongs to them.
    pub fn has(&self, turn: u32) -> bool {
        (self.first..self.first + self.images).contains(&turn)
    }
}
