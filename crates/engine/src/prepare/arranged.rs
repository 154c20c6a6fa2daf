//! The points of a scene in the order that its method wants.

use std::sync::Arc;

use super::ensembles::{Dealt, Surface};
use crate::points::Points;

/// The points of a scene in the order that its method wants.
#[derive(Debug, Clone, PartialEq)]
pub enum Arranged {
    /// Points in canonical order; shared with what renders them, which may have no room for all of them at once.
    Canonical(Arc<Points>),
    /// Shuffled, cloud after cloud, for methods that deal points to ensembles.
    Dealt(Dealt),
}

impl Arranged {
    /// All points, in either order.
    pub fn points(&self) -> &Points {
        match self {
            Self::Canonical(points) => points,
            Self::Dealt(dealt) => &dealt.points,
        }
    }

    /// The clouds, if they are kept apart.
    pub fn surfaces(&self) -> &[Surface] {
        match self {
            Self::Canonical(_) => &[],
            Self::Dealt(dealt) => &dealt.surfaces,
        }
    }
}
