//! Some points that stand for all of a list, with what is known of all.

use std::sync::Arc;

use glam::DVec3;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::{Points, Spheres, Unseen, WholeScene, WholeSplats};
use crate::cloud::Bounds;
use crate::cloud::sampling::Sampling;

/// Facts about all points of a scene whose points are elsewhere, in a form that travels.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Known {
    /// Number of points.
    pub count: u64,
    /// The box around all of them, also around those that are not drawn.
    pub bounds: Bounds,
    /// World units; may be infinite, as the next one may, which no JSON is.
    largest_radius: f32,
    /// The largest component of a color, linear.
    brightest: f32,
    is_transparent: bool,
    splats: Option<WholeSplats>,
}

/// The points of a scene that are elsewhere.
#[derive(Debug)]
struct Elsewhere;

impl Spheres for Elsewhere {
    fn groups(&self) -> Vec<(Bounds, f64)> {
        Vec::new()
    }

    fn of_group(&self, _group: usize, _drawn: bool) -> Vec<(DVec3, f64)> {
        Vec::new()
    }
}

impl Points {
    /// Returns what is known of all points; `None` without any.
    pub fn known(&self) -> Option<Known> {
        let brightest = || self.colors.par_iter().map(|color| color.max_element()).reduce(|| 1.0, f32::max);
        let whole = self.whole.as_ref();
        let is_transparent = || self.opacities.par_iter().any(|opacity| *opacity < 1.0);
        Some(Known {
            count: self.count(),
            bounds: self.bounds()?,
            largest_radius: self.largest_radius() as f32,
            brightest: whole.map_or_else(brightest, |whole| whole.brightest),
            is_transparent: whole.map_or_else(is_transparent, |whole| whole.is_transparent),
            splats: self.splats(),
        })
    }

    /// Returns some points that stand for these, at least one, without what is known of all: those of a list that
    /// stands for more as they are.
    pub fn sampled_points(&self) -> Self {
        if self.whole.is_some() {
            return Self { whole: None, ..self.clone() };
        }
        let sample = self.taken_by(Sampling::of((self.len() + self.unseen.positions.len()) as u64));
        sample.with_one(self.anchor().origin, || self.subset(&[0], 1.0))
    }

    /// Returns the points that a sampling takes, also of those that are not drawn.
    #[doc(hidden)]
    pub fn taken_by(&self, sampling: Sampling) -> Self {
        let seen: Vec<u32> = (0..self.len() as u32).filter(|at| sampling.takes(self.positions[*at as usize])).collect();
        let unseen = self.unseen.positions.iter().zip(&self.unseen.radii);
        let unseen = unseen.filter(|(position, _)| sampling.takes(**position));
        let (positions, radii) = unseen.map(|(position, radius)| (*position, *radius)).unzip();
        Self { unseen: Arc::new(Unseen { positions, radii }), ..self.subset(&seen, 1.0) }
    }

    /// Returns the same points, or, if these are none, one of the scene, which leaves the origin where it is.
    #[must_use]
    pub fn with_one(self, origin: DVec3, one: impl FnOnce() -> Self) -> Self {
        if !self.is_empty() {
            return self;
        }
        // The median of these and another one is theirs.
        let unseen = Unseen { positions: vec![origin; 3], radii: vec![0.0; 3] };
        Self { unseen: Arc::new(unseen), whole: self.whole, ..one() }
    }

    /// Marks these points as some that stand for a scene; `identity` is the same text for the same points.
    #[must_use]
    pub fn standing_for(self, known: &Known, identity: String) -> Self {
        let Known { count, bounds, largest_radius, brightest, is_transparent, splats } = *known;
        let spheres = Arc::new(Elsewhere);
        let whole = WholeScene { count, bounds, largest_radius, brightest, is_transparent, identity, splats, spheres };
        Self { whole: Some(Arc::new(whole)), ..self }
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;

    fn points(positions: Vec<DVec3>) -> Points {
        let count = positions.len();
        let radii = (0..count).map(|at| (at % 7) as f32).collect();
        let colors = vec![Vec3::new(0.5, 2.0, 0.0); count];
        Points { positions, colors, radii, opacities: vec![0.5; count], ..Points::default() }
    }

    #[test]
    fn a_sample_that_stands_for_all_is_known_as_all() {
        let all = points((0..300_000).map(|at| DVec3::new(f64::from(at), 0.0, f64::from(at % 1000))).collect());
        let known = all.known().unwrap();
        let sample = all.sampled_points().standing_for(&known, String::new());
        assert!((10_000..200_000).contains(&sample.len()), "{}", sample.len());
        assert_eq!(sample.anchor(), all.anchor());
        assert_eq!(sample.known(), Some(known));
        assert_eq!((sample.count(), sample.bounds()), (300_000, all.bounds()));
    }

    #[test]
    fn many_points_in_one_place_keep_their_origin() {
        // A place that is not sampled.
        let sampling = Sampling::of(300_000);
        let place = (1..).map(|at| DVec3::splat(f64::from(at))).find(|place| !sampling.takes(*place)).unwrap();
        let all = points(vec![place; 300_000]);
        let sample = all.sampled_points();
        assert_eq!((sample.len(), sample.anchor().origin), (1, place));
    }
}
