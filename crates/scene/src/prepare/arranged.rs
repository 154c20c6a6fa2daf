//! The points of a scene in the order that its method wants.

use std::sync::Arc;

use super::dealt_file::DealtFile;
use super::ensembles::{CloudSurface, Dealt};
use crate::supply::Supply;
use pellucid_core::points::Points;

/// The points of a scene in the order that its method wants.
#[derive(Debug, Clone, PartialEq)]
pub enum Arranged {
    /// Points in canonical order; shared with what renders them, which may have no room for all of them at once.
    Canonical(Arc<Points>),
    /// Shuffled, cloud after cloud, for methods that partition points into ensembles.
    Dealt(Dealt),
    /// Points that come some at a time, from where they are stored.
    Supplied(Supplied),
}

/// The points of a scene, where they are stored.
#[derive(Debug, Clone)]
pub struct Supplied {
    /// All of them, block by block.
    pub supply: Arc<dyn Supply>,
    /// Some that stand for all, with what is known of all ([`Points::whole`]).
    pub sample: Arc<Points>,
    /// All of them shuffled, cloud after cloud, for methods that partition points into ensembles.
    pub dealt: Option<Arc<DealtFile>>,
}

impl PartialEq for Supplied {
    fn eq(&self, other: &Self) -> bool {
        self.sample == other.sample
    }
}

impl Arranged {
    /// Returns all points, in either order; of those that come some at a time a few that stand for all.
    pub fn points(&self) -> &Points {
        match self {
            Self::Canonical(points) => points,
            Self::Dealt(dealt) => &dealt.points,
            Self::Supplied(supplied) => &supplied.sample,
        }
    }

    /// Returns the clouds, if they are kept apart.
    pub fn surfaces(&self) -> &[CloudSurface] {
        match self {
            Self::Canonical(_) => &[],
            Self::Dealt(dealt) => &dealt.surfaces,
            Self::Supplied(supplied) => supplied.dealt.as_ref().map_or(&[], |file| &file.surfaces),
        }
    }
}
