//! Reasons why passes don't work on a cloud.

use std::sync::Arc;

use crate::gpu;
use crate::io;
use crate::progress::Cancelled;

/// Reasons why passes don't work on a cloud; `methods::Error` has the messages for people.
#[derive(Debug)]
pub enum Error {
    /// The device failed.
    Gpu(gpu::Error),
    /// The device has no shuffles.
    NoSubgroups {
        /// The device.
        device: String,
    },
    /// The cloud is longer than the device can address.
    TooManyPoints {
        /// Points of the cloud.
        points: u64,
        /// Points that fit.
        limit: u64,
    },
    /// The sort of splats alone takes more than the budget.
    SortOverBudget {
        /// Points of the cloud.
        points: u64,
        /// Bytes that the sort needs.
        needed: u64,
        /// Bytes that are there.
        available: u64,
        /// The budget that would do.
        budget: u64,
    },
    /// Points can't be read.
    Store(Arc<io::Error>),
    /// The coarsest level of detail has more points than are allowed.
    Coarsest {
        /// Points that are allowed.
        allowed: u64,
        /// Points of that level in the picture.
        points: u64,
    },
    /// A count was larger than taken for granted, or not asked for before.
    Unforeseen,
    /// Somebody who watches the progress wanted the work to end.
    Cancelled,
}

impl From<Cancelled> for Error {
    fn from(_: Cancelled) -> Self {
        Self::Cancelled
    }
}

impl From<gpu::Error> for Error {
    fn from(error: gpu::Error) -> Self {
        Self::Gpu(error)
    }
}
