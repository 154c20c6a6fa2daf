//! The points that a camera is placed for where nothing says from where to look: those that are drawn, without strays.

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::scene::Scene;
use super::settings::Frame;
use pellucid_core::cloud::Bounds;
use pellucid_core::parallel;
use pellucid_core::points::Points;

/// The share of the half angle's tangent that an automatic camera fills; the rest is a margin.
pub(super) const FILL: f64 = 0.95;
/// Share of the points, at either end of an axis, that may be strays.
const STRAYS: f64 = 0.02;
/// Strays are farther from the other points than these extend, times this.
const FAR: f64 = 2.0;
/// Groups of spheres that are read at once.
const GROUPS: usize = 16;
/// Fewest points of which some can be strays.
const FEWEST: usize = 100;

/// Some of a scene's points.
#[derive(Clone, Copy)]
pub(super) struct Framed<'a> {
    pub points: &'a Points,
    /// `true`: without the points that are not drawn.
    drawn: bool,
    /// Box outside of which there are only strays; `None` if there are none.
    within: Option<Bounds>,
}

impl<'a> Framed<'a> {
    /// Returns all points, also those that are not drawn.
    pub fn all(points: &'a Points) -> Self {
        Self { points, drawn: false, within: None }
    }

    /// Returns the points that the scene asks to be framed, and a box around them; `None` without points.
    pub fn of(scene: &Scene, points: &'a Points) -> Option<(Self, Bounds)> {
        let all = Self::all(points);
        let bounds = points.bounds()?;
        if scene.camera.frame == Frame::All {
            return Some((all, bounds));
        }
        let hides = if points.whole.is_some() { scene.hides_points() } else { !points.unseen.positions.is_empty() };
        let drawn = Self { drawn: hides && !points.positions.is_empty(), ..all };
        let bounds = if drawn.drawn { drawn.bounds()? } else { bounds };
        let Some(within) = drawn.without_strays().filter(|within| !within.holds(&bounds)) else {
            return Some((drawn, bounds));
        };
        let framed = Self { within: Some(within), ..drawn };
        Some((framed, framed.bounds()?))
    }

    /// Returns the positions of points that stand for all of these, in any order.
    pub fn sampled(&self) -> Vec<DVec3> {
        let holds = |position: &DVec3| self.holds(*position);
        if self.drawn {
            return self.points.sampled_drawn().copied().filter(holds).collect();
        }
        self.points.sampled().copied().filter(holds).collect()
    }

    /// Returns the number of points in memory, strays included.
    pub fn len(&self) -> usize {
        self.points.len() + if self.drawn { 0 } else { self.points.unseen.positions.len() }
    }

    /// Returns positions and radii of those in memory.
    pub fn spheres(&self) -> impl ParallelIterator<Item = (DVec3, f64)> {
        let most = if self.drawn { self.points.len() } else { usize::MAX };
        let (framed, spheres) = (*self, self.points.spheres());
        let most = most.min(spheres.len());
        spheres.take(most).filter(move |(position, _)| framed.holds(*position))
    }

    /// Returns position and radius of one of those in memory, by its number below [`Self::len`]; `None` of a stray.
    pub fn sphere(&self, number: usize) -> Option<(DVec3, f64)> {
        let Points { positions, radii, unseen, .. } = self.points;
        let (position, radius) = match number.checked_sub(positions.len()) {
            None => (positions[number], radii[number]),
            Some(number) => (unseen.positions[number], unseen.radii[number]),
        };
        self.holds(position).then_some((position, radius.into()))
    }

    /// Returns the number of strays; `None` where it can't be told without reading all points.
    pub fn strays(&self) -> Option<usize> {
        if self.points.whole.is_some() {
            return self.within.map_or(Some(0), |_| None);
        }
        Some(self.len() - self.spheres().count())
    }

    /// Returns the boxes of groups that are not in memory, with their largest radii; nothing of those without any of
    /// these points.
    pub fn groups(&self) -> Vec<Option<(Bounds, f64)>> {
        let Some(whole) = &self.points.whole else { return Vec::new() };
        let rounding = 1e-12 * whole.bounds.diagonal();
        let around = |Bounds { min, max }: Bounds| {
            let (min, max) = (min - rounding, max + rounding);
            let within = self.within.unwrap_or(Bounds { min, max });
            let part = Bounds { min: min.max(within.min), max: max.min(within.max) };
            part.min.cmple(part.max).all().then_some(part)
        };
        whole.spheres.groups().into_iter().map(|(bounds, radius)| Some((around(bounds)?, radius))).collect()
    }

    /// Returns positions and radii of a group.
    pub fn of_group(&self, group: usize) -> Vec<(DVec3, f64)> {
        let Some(whole) = &self.points.whole else { return Vec::new() };
        let mut spheres = whole.spheres.of_group(group, self.drawn);
        spheres.retain(|(position, _)| self.holds(*position));
        spheres
    }

    fn holds(&self, position: DVec3) -> bool {
        self.within.is_none_or(|Bounds { min, max }| (position.cmpge(min) & position.cmple(max)).all())
    }

    /// A box that strays are outside of. `None` of few points, and where nearly all are in one place.
    fn without_strays(&self) -> Option<Bounds> {
        let sampled = self.sampled();
        if sampled.len() < FEWEST {
            return None;
        }
        let ends = [0, 1, 2].map(|axis| ends(sampled.iter().map(|position| position[axis]).collect()));
        let (min, max) = (DVec3::from(ends.map(|[low, _]| low)), DVec3::from(ends.map(|[_, high]| high)));
        let far = FAR * (max - min).length();
        (far > 0.0).then_some(Bounds { min: min - far, max: max + far })
    }

    /// The box around all of these points.
    fn bounds(&self) -> Option<Bounds> {
        let spheres = Spheres { framed: *self, center: DVec3::ZERO, axes: DVec3::AXES };
        let nothing = Bounds { min: DVec3::INFINITY, max: DVec3::NEG_INFINITY };
        let with = |bounds: Bounds, (offset, depth, _): (DVec2, f64, f64)| {
            let position = offset.extend(depth);
            Bounds { min: bounds.min.min(position), max: bounds.max.max(position) }
        };
        let known = spheres.iter().fold(|| nothing, with).reduce(|| nothing, Bounds::union);
        let bounds = spheres
            .with_groups(known, with, |bounds, more| (more.max - bounds.max).max(bounds.min - more.min).max_element());
        bounds.min.cmple(bounds.max).all().then_some(bounds)
    }
}

/// Points as spheres at (offset, depth) around a center.
pub(super) struct Spheres<'a> {
    pub framed: Framed<'a>,
    pub center: DVec3,
    /// Right, up, forward.
    pub axes: [DVec3; 3],
}

impl Spheres<'_> {
    /// Offset, depth, radius.
    pub fn iter(&self) -> impl ParallelIterator<Item = (DVec2, f64, f64)> {
        self.framed.spheres().map(|(position, radius)| self.relative(position, radius))
    }

    /// Adds those groups of spheres to a state that may change it, where only some points are in memory: what changes
    /// most goes first. `with` adds a sphere, `gain` tells how much farther a state is than another one. What is
    /// farthest of a group is so at a corner of its box.
    pub fn with_groups<S: Copy + Send + Sync>(
        &self,
        mut state: S,
        with: impl Fn(S, (DVec2, f64, f64)) -> S + Sync,
        gain: impl Fn(S, S) -> f64 + Sync,
    ) -> S {
        let groups: Vec<_> = self.framed.groups();
        let mut left: Vec<usize> = (0..groups.len()).filter(|group| groups[*group].is_some()).collect();
        loop {
            let gain_of = |group: usize| {
                let around = groups[group]
                    .into_iter()
                    .flat_map(|(bounds, radius)| bounds.corners().map(|corner| (corner, radius)));
                let corners = around.map(|(corner, radius)| self.relative(corner, radius));
                (gain(state, corners.fold(state, &with)), group)
            };
            let mut gains: Vec<(f64, usize)> = parallel::gather(left.len(), |i| gain_of(left[i]));
            gains.retain(|(gain, _)| *gain > 0.0);
            gains.sort_unstable_by(|a, b| b.0.total_cmp(&a.0));
            gains.truncate(GROUPS);
            if gains.is_empty() {
                return state;
            }
            let spheres: Vec<_> = parallel::gather(gains.len(), |i| self.framed.of_group(gains[i].1));
            let each = spheres.iter().flatten().map(|(position, radius)| self.relative(*position, *radius));
            state = each.fold(state, &with);
            left.retain(|group| gains.iter().all(|(_, done)| done != group));
        }
    }

    pub fn relative(&self, position: DVec3, radius: f64) -> (DVec2, f64, f64) {
        let [right, up, forward] = self.axes;
        let p = position - self.center;
        (DVec2::new(p.dot(right), p.dot(up)), p.dot(forward), radius)
    }
}

/// The values between which all are but for the share at either end that may be strays.
fn ends(mut values: Vec<f64>) -> [f64; 2] {
    let last = values.len() - 1;
    let few = (last as f64 * STRAYS) as usize;
    let mut at = |place: usize| *values.select_nth_unstable_by(place, f64::total_cmp).1;
    [at(few), at(last - few)]
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::{Document, Overrides};
    use pellucid_core::points::Unseen;

    /// A square of 40 × 40 points with corners at 0 and 39, and some others.
    fn with(others: &[DVec3]) -> Points {
        let square = (0..1600).map(|i| DVec3::new(f64::from(i % 40), f64::from(i / 40), 0.0));
        pellucid_testing_host::white(square.chain(others.iter().copied()).collect(), 0.5)
    }

    fn scene(text: &str) -> Scene {
        let text = format!("{text}\n[[cloud]]\npath = 'a.ply'");
        Document::from_toml(&text, "s.toml".as_ref(), &Overrides::default()).unwrap().scene().unwrap()
    }

    const SQUARE: Bounds = Bounds { min: DVec3::ZERO, max: DVec3::new(39.0, 39.0, 0.0) };

    #[test]
    fn a_few_points_far_from_all_others_are_not_framed() {
        let far = |factor: f64| DVec3::new(55.0 * factor, 3.0, 0.0);
        for strays in [vec![far(10.0)], vec![far(1e6), far(-100.0), far(10.0)], vec![DVec3::splat(f64::from(f32::MAX))]]
        {
            let points = with(&strays);
            let (framed, bounds) = Framed::of(&scene(""), &points).unwrap();
            assert_eq!((bounds, framed.strays()), (SQUARE, Some(strays.len())), "{strays:?}");
            assert_eq!(framed.sampled().len(), 1600);
            let (all, bounds) = Framed::of(&scene("camera = { frame = 'all' }"), &points).unwrap();
            assert_eq!((Some(bounds), all.strays()), (points.bounds(), Some(0)));
        }
    }

    #[test]
    fn more_or_nearer_points_are_framed() {
        let near = with(&[DVec3::new(140.0, 0.0, 0.0)]);
        let many = with(&(0..80).map(|i| DVec3::new(1e4, f64::from(i), 0.0)).collect::<Vec<_>>());
        let few = pellucid_testing_host::white([0.0, 1.0, 2.0, 1e6].map(|x| DVec3::X * x).to_vec(), 0.5);
        let one_place = pellucid_testing_host::white([vec![DVec3::ZERO; 999], vec![DVec3::X]].concat(), 0.5);
        for points in [near, many, few, one_place] {
            let (framed, bounds) = Framed::of(&scene(""), &points).unwrap();
            assert_eq!((Some(bounds), framed.strays()), (points.bounds(), Some(0)));
        }
    }

    #[test]
    fn points_that_are_not_drawn_are_not_framed() {
        let mut points = with(&[]);
        points.unseen = Arc::new(Unseen { positions: vec![DVec3::splat(60.0)], radii: vec![0.5] });
        assert_eq!(Framed::of(&scene(""), &points).unwrap().1, SQUARE);
        let (all, bounds) = Framed::of(&scene("camera = { frame = 'all' }"), &points).unwrap();
        assert_eq!((bounds.max, all.spheres().count()), (DVec3::splat(60.0), 1601));
        // Where nothing is drawn, everything is framed.
        let none = Points { positions: vec![], radii: vec![], ..points };
        assert_eq!(Framed::of(&scene(""), &none).unwrap().1.max, DVec3::splat(60.0));
    }
}
