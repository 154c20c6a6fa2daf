//! Everything that stands in a tile or near it, gathered from the rules of the land alone.

use glam::{DVec2, DVec3};

use super::bins::Bins;
use super::buildings;
use super::land::Land;
use super::light::TO_SUN;
use super::posts::Post;
use super::solids::{Solid, Wall};
use super::town;
use super::trees::{Tree, trees};

/// Meters between heights of the ground that are computed; linear in between.
const STEP: f64 = 2.0;
/// Meters around a tile from which a shadow may fall into it.
const MARGIN: f64 = 14.0;
/// No tree and no house reaches farther from its middle.
const REACH: f64 = 15.0;

/// The part of a wall that lies in a tile.
#[derive(Debug)]
pub(super) struct Side {
    pub(super) solid: usize,
    pub(super) wall: Wall,
    /// Meters along the wall.
    pub(super) from: f64,
    pub(super) to: f64,
    /// Square meters, nearly.
    pub(super) area: f64,
}

/// A tile before it is scanned.
pub(super) struct Site<'a> {
    pub(super) land: &'a Land,
    pub(super) low: DVec2,
    pub(super) side: f64,
    ground: Lattice,
    pub(super) solids: Vec<Solid>,
    pub(super) trees: Vec<Tree>,
    pub(super) sides: Vec<Side>,
    pub(super) posts: Vec<Post>,
    bins: Bins,
}

/// Thing that a pulse from above meets.
pub(super) enum Hit<'a> {
    /// A roof: its body, height and normal.
    Roof(&'a Solid, f64, DVec3),
    /// Crowns, or none, over the ground.
    Crowns([Option<&'a Tree>; 3]),
}

impl<'a> Site<'a> {
    /// Gathers what stands in a square of `side` meters from its lowest corner on.
    pub(super) fn new(land: &'a Land, low: DVec2, side: f64) -> Self {
        let (from, length) = (low - MARGIN, side + 2.0 * MARGIN);
        let center = low + 0.5 * side;
        let half = 0.5 * length + REACH;
        let blocks = town::blocks(land, center, half * std::f64::consts::SQRT_2);
        let mut solids: Vec<Solid> = blocks.iter().flat_map(|block| buildings::solids(land, block)).collect();
        solids.extend(buildings::bridge(land, center));
        solids.retain(|solid| (solid.center - center).abs().max_element() < 0.5 * length + solid.reach());
        let mut trees = trees(land, from - REACH, length + 2.0 * REACH);
        trees.retain(|tree| (tree.foot.truncate() - center).abs().max_element() < 0.5 * length + tree.radius);
        let lamps = blocks.iter().flat_map(|block| buildings::lamps(land, block));
        let inside = |post: &Post| {
            let at = post.foot.truncate() - low;
            at.min_element() >= 0.0 && at.max_element() < side
        };
        let posts = trees.iter().filter_map(Tree::trunk).chain(lamps).filter(inside).collect();
        let circles: Vec<(DVec2, f64)> = solids
            .iter()
            .map(|solid| (solid.center, solid.reach()))
            .chain(trees.iter().map(|tree| (tree.foot.truncate(), tree.radius)))
            .collect();
        let bins = Bins::new(from, length, &circles);
        let ground = Lattice::new(land, low, side);
        let mut site = Self { land, low, side, ground, solids, trees, sides: Vec::new(), posts, bins };
        site.sides = site.find_sides();
        site
    }

    /// Returns the height and normal of the ground, or of the water over it.
    pub(super) fn ground(&self, p: DVec2) -> (f64, DVec3) {
        let (z, normal) = self.ground.at(p);
        if z < 0.0 { (0.0, DVec3::Z) } else { (z, normal) }
    }

    /// Returns what a pulse that comes straight down at a position meets.
    pub(super) fn hit(&self, p: DVec2) -> Hit<'_> {
        let mut roof: Option<(&Solid, f64, DVec3)> = None;
        let mut crowns = [None; 3];
        let mut count = 0;
        for member in self.bins.at(p) {
            if let Some(solid) = self.solids.get(member) {
                if let Some((z, normal)) = solid.roof_at(p).filter(|(z, _)| roof.is_none_or(|(_, top, _)| *z > top)) {
                    roof = Some((solid, z, normal));
                }
            } else if let Some(slot) = crowns.get_mut(count)
                && let Some(tree) = self.trees.get(member - self.solids.len()).filter(|tree| tree.covers(p))
            {
                *slot = Some(tree);
                count += 1;
            }
        }
        match roof {
            Some((solid, z, normal)) => Hit::Roof(solid, z, normal),
            None => Hit::Crowns(crowns),
        }
    }

    /// Returns the share of the sun's light that reaches a position.
    pub(super) fn lit(&self, p: DVec3) -> f64 {
        let mut light = 1.0;
        for rise in [1.0, 2.6, 5.0, 9.0] {
            let at = p + rise * DVec3::new(TO_SUN[0], TO_SUN[1], 1.0);
            for member in self.bins.at(at.truncate()) {
                if let Some(solid) = self.solids.get(member) {
                    let above = solid.base < at.z && solid.roof_at(at.truncate()).is_some_and(|(z, _)| z > at.z);
                    if above {
                        return 0.12;
                    }
                } else if self.trees.get(member - self.solids.len()).is_some_and(|tree| tree.shades(at)) {
                    light *= 0.5;
                }
            }
        }
        f64::max(light, 0.2)
    }

    /// Returns the lowest and highest height in the tile, with all that stands there.
    pub(super) fn heights(&self) -> [f64; 2] {
        let [low, mut high] = self.ground.range();
        for top in self.solids.iter().map(Solid::top).chain(self.trees.iter().map(Tree::top)) {
            high = high.max(top);
        }
        for post in &self.posts {
            high = high.max(post.foot.z + post.height + post.head.map_or(0.0, |(radius, _)| radius));
        }
        // Water is at 0, and banks within the two meters to the next height that is known are low.
        let low = if low < 1.0 { 0.0 } else { low };
        [low - 0.1, high + 0.6]
    }

    fn find_sides(&self) -> Vec<Side> {
        let mut sides = Vec::new();
        for (solid, body) in self.solids.iter().enumerate() {
            for wall in body.walls() {
                let Some([from, to]) = clip(wall.from - self.low, wall.along, wall.length, self.side) else { continue };
                let middle = wall.from + 0.5 * (from + to) * wall.along;
                let height = body.mean_top(&wall) - self.ground(middle).0.max(body.base);
                let area = (to - from) * height.max(0.0);
                sides.push(Side { solid, wall, from, to, area });
            }
        }
        sides
    }
}

/// The part of a segment within a square from the origin on: meters along it.
fn clip(from: DVec2, along: DVec2, length: f64, side: f64) -> Option<[f64; 2]> {
    let (mut enter, mut leave) = (0.0f64, length);
    for axis in 0..2 {
        if along[axis].abs() < 1e-12 {
            if !(0.0..side).contains(&from[axis]) {
                return None;
            }
            continue;
        }
        let [a, b] = [-from[axis] / along[axis], (side - from[axis]) / along[axis]];
        enter = enter.max(a.min(b));
        leave = leave.min(a.max(b));
    }
    (enter < leave).then_some([enter, leave])
}

/// Heights and slopes of the ground at the corners of cells whose sides are multiples of [`STEP`], so that tiles agree.
struct Lattice {
    first: [i64; 2],
    columns: usize,
    /// Height, then slopes along x and y.
    nodes: Vec<DVec3>,
}

impl Lattice {
    fn new(land: &Land, low: DVec2, side: f64) -> Self {
        let first = (low / STEP).floor();
        let columns = (side / STEP).ceil() as usize + 2;
        // One more on each side, for slopes.
        let wide = columns + 2;
        let at = |i: usize| first - 1.0 + DVec2::new((i % wide) as f64, (i / wide) as f64);
        let heights: Vec<f64> = (0..wide * wide).map(|i| land.height(STEP * at(i))).collect();
        let node = |i: usize| {
            let at = (i / columns + 1) * wide + i % columns + 1;
            let slope = |step: usize| (heights[at + step] - heights[at - step]) / (2.0 * STEP);
            DVec3::new(heights[at], slope(1), slope(wide))
        };
        let nodes = (0..columns * columns).map(node).collect();
        Self { first: [first.x as i64, first.y as i64], columns, nodes }
    }

    fn at(&self, p: DVec2) -> (f64, DVec3) {
        let last = (self.columns - 2) as f64;
        let at = p / STEP - DVec2::new(self.first[0] as f64, self.first[1] as f64);
        let cell = at.floor().clamp(DVec2::ZERO, DVec2::splat(last));
        let f = (at - cell).clamp(DVec2::ZERO, DVec2::ONE);
        let i = cell.y as usize * self.columns + cell.x as usize;
        let row = |i: usize| self.nodes[i] + (self.nodes[i + 1] - self.nodes[i]) * f.x;
        let [a, b] = [row(i), row(i + self.columns)];
        let v = a + (b - a) * f.y;
        (v.x, DVec3::new(-v.y, -v.z, 1.0).normalize())
    }

    fn range(&self) -> [f64; 2] {
        let heights = self.nodes.iter().map(|node| node.x);
        heights.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], z| [low.min(z), high.max(z)])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn segments_are_cut_at_the_edges() {
        let diagonal = DVec2::ONE.normalize();
        let cut = clip(DVec2::new(-1.0, -1.0), diagonal, 100.0, 2.0).unwrap();
        assert!((cut[0] - 2f64.sqrt()).abs() < 1e-12 && (cut[1] - 3.0 * 2f64.sqrt()).abs() < 1e-12, "{cut:?}");
        assert_eq!(clip(DVec2::new(0.5, 0.5), DVec2::X, 1.0, 2.0), Some([0.0, 1.0]));
        assert_eq!(clip(DVec2::new(0.5, 2.5), DVec2::X, 1.0, 2.0), None);
        assert_eq!(clip(DVec2::new(2.5, 0.5), DVec2::X, 9.0, 2.0), None);
    }

    #[test]
    fn tiles_agree_on_the_ground_they_share() {
        let land = Land::new(450.0, 2);
        let [left, right] = [-30.5, 4.5].map(|x| Lattice::new(&land, DVec2::new(x, 7.0), 35.0));
        for i in 0..350 {
            let p = DVec2::new(4.5, 7.0 + 0.1 * f64::from(i));
            assert_eq!(left.at(p), right.at(p));
            // Linear over 2 m on a ground that bends by less than 0.3 a meter.
            assert!((left.at(p).0 - land.height(p)).abs() < 0.3 * STEP * STEP / 8.0, "{p}");
        }
    }
}
