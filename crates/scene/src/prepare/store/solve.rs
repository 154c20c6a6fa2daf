//! The values of the points of a region.

use glam::{DVec3, Vec3};

use super::super::neighbors::Places;
use super::super::surface::{self, UnscaledEstimates};
use super::regions::Region;
use super::source::{Local, RegionStore, SpaceRegion};
use super::values::{Value, Values};
use super::{Error, ValuePlan};
use pellucid_core::cloud::Bounds;
use pellucid_core::parallel;
use pellucid_core::progress::Progress;
use pellucid_io as io;

/// Distances around a region that are searched at first and at last, as a share of its side.
const REACH: [f64; 2] = [0.125, 0.5];

/// Largest number of points that are found one by one sooner than with more around their region.
const FEW: usize = 1000;
/// Largest share of a region's points of which the same holds: one in this many.
const FEW_OF: usize = 8;

/// Widens distances by what is rounded.
const WIDER: f64 = 1.0 + 1e-9;

/// Finds values.
pub(super) struct Solver<'a> {
    pub source: &'a RegionStore,
    pub plan: &'a ValuePlan,
}

impl Solver<'_> {
    /// Returns how far away the points may be that a point's values depend on, in distances of its last neighbor: a
    /// neighbor has all of its own neighbors within twice that distance, since the point and the other neighbors are.
    fn hops(&self) -> f64 {
        if self.plan.cap > 0.0 || self.plan.wants.fields { 3.0 } else { 1.0 }
    }

    /// Finds the values of all points of a region.
    pub fn region(&self, region: Region, values: &Values) -> Result<(), Error> {
        let cell = region.bounds(&self.source.bounds);
        let side = (cell.max - cell.min).max_element();
        let mut reach = REACH[0] * side;
        loop {
            let halo = Bounds { min: cell.min - reach - self.source.cell, max: cell.max + reach + self.source.cell };
            let local = self.source.gather(&SpaceRegion::Box(halo))?;
            if local.places.len() <= self.plan.k {
                // There are as many elsewhere.
                reach *= 4.0;
                continue;
            }
            let seen = self.see(&local);
            let own = region.holds(&local.positions, &self.source.bounds);
            let own = (0..own.len()).filter(|i| own[*i]);
            let is_valid = |i: &usize| {
                let needed = self.hops() * seen.last[*i] * WIDER + self.source.cell;
                self.margin(&halo, local.positions[*i]) > needed
            };
            let (valid, left): (Vec<usize>, Vec<usize>) = own.partition(is_valid);
            let few = FEW.min((valid.len() + left.len()) / FEW_OF);
            if left.len() > few && reach < REACH[1] * side {
                reach *= 4.0;
                continue;
            }
            let found = valid.iter().map(|i| (local.places[*i], self.value(&seen, *i))).collect();
            values.write(found)?;
            let alone = |i: &usize| self.alone(local.places[*i], local.positions[*i], seen.last[*i]);
            let found = parallel::try_map_each(&left, alone)?;
            return Ok(values.write(found)?);
        }
    }

    /// Returns how far a position is from the faces of a box beyond which there are points.
    fn margin(&self, halo: &Bounds, p: DVec3) -> f64 {
        let all = self.source.bounds;
        let below =
            |axis: usize| if halo.min[axis] <= all.min[axis] { f64::INFINITY } else { p[axis] - halo.min[axis] };
        let above =
            |axis: usize| if halo.max[axis] >= all.max[axis] { f64::INFINITY } else { halo.max[axis] - p[axis] };
        (0..3).flat_map(|axis| [below(axis), above(axis)]).fold(f64::INFINITY, f64::min)
    }

    fn places(&self, local: &Local) -> Option<Places> {
        Places::group_within(&local.positions, local.normals.as_deref(), &self.source.bounds)
    }

    fn see(&self, local: &Local) -> UnscaledEstimates {
        let Some(places) = self.places(local) else { return UnscaledEstimates::default() };
        let ValuePlan { k, cap, wants, .. } = *self.plan;
        surface::see(&places, local.normals.as_deref(), (k, cap), wants, &Progress::hidden())
    }

    fn value(&self, seen: &UnscaledEstimates, i: usize) -> Value {
        let normal = if self.plan.wants.normals { seen.surface.normals[i] } else { Vec3::ZERO };
        let spread = if self.plan.wants.fields { seen.spreads[i] } else { 0.0 };
        Value { radius: seen.surface.radii[i], normal, spread }
    }

    /// The values of a point that has all neighbors within a distance: from the ball with them, and the balls with
    /// theirs.
    fn alone(&self, place: u64, position: DVec3, within: f64) -> Result<(u64, Value), io::Error> {
        let k = self.plan.k;
        let radius = within.min(self.source.reach(position, k as u64 + 1)) * WIDER + self.source.cell;
        let mut balls = vec![(position, radius)];
        let mut local = self.source.gather(&SpaceRegion::Balls(balls.clone()))?;
        let find = |local: &Local| local.places.iter().position(|other| *other == place).unwrap_or(0);
        if self.hops() > 1.0
            && let Some(places) = self.places(&local)
        {
            let point = find(&local);
            let at = (0..places.points()).position(|rank| places.index(rank) == point).unwrap_or(0);
            let (others, _) = places.others(places.place_of(at as u32), k);
            balls.extend(others.into_iter().map(|rank| {
                let (_, distance) = places.others(places.place_of(rank), k);
                let radius = distance * places.unit * WIDER + self.source.cell;
                (local.positions[places.index(rank as usize)], radius)
            }));
            local = self.source.gather(&SpaceRegion::Balls(balls))?;
        }
        let seen = self.see(&local);
        Ok((place, self.value(&seen, find(&local))))
    }
}
