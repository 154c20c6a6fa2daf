//! The clouds of a dealt list.

use glam::DVec3;

use crate::points::Points;
use crate::prepare::dealt_file::DealtCloud;
use crate::prepare::ensembles::CloudSurface;

/// A cloud of a dealt list, with the corners of its box.
#[derive(Debug, Clone, PartialEq)]
pub struct Placed {
    /// Properties of the cloud.
    pub surface: CloudSurface,
    /// Corners of its points' box, in world coordinates.
    pub corners: [DVec3; 8],
    /// `true` if all of its points have the same opacity.
    pub uniform: bool,
}

impl Placed {
    /// Returns the clouds of a list.
    pub fn all(points: &Points, surfaces: &[CloudSurface]) -> Vec<Self> {
        let placed = |surface: &CloudSurface| {
            let range = surface.points.start as usize..surface.points.end as usize;
            let own = points.positions[range].iter().copied();
            let corners = crate::cloud::Bounds::enclosing(own).map_or([surface.center; 8], |bounds| bounds.corners());
            Self { surface: surface.clone(), corners, uniform: is_uniform(points, surface) }
        };
        surfaces.iter().map(placed).collect()
    }

    /// Returns a cloud of a list in a file.
    pub fn of_facts(facts: &DealtCloud) -> Self {
        Self { surface: facts.surface.clone(), corners: facts.bounds.corners(), uniform: facts.uniform }
    }

    /// Takes over opacities that are others: of its points, and of the surface that they are of.
    pub fn renew_opacities(&mut self, points: &Points, surface: &CloudSurface) {
        self.surface.opacity = surface.opacity;
        self.uniform = is_uniform(points, surface);
    }
}

fn is_uniform(points: &Points, surface: &CloudSurface) -> bool {
    let range = surface.points.start as usize..surface.points.end as usize;
    points.opacities[range].iter().all(|opacity| *opacity == surface.opacity)
}
