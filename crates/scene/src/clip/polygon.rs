//! Polygons with holes, united: the side of a point, exact for the coordinates as they are in float64.

use std::ops::RangeInclusive;

use glam::DVec2;
use robust::{Coord, orient2d};

use super::Side;
use pellucid_io::polygon::Rings;

/// The largest number of strips of a polygon. With more of them, a point meets fewer edges.
const MAX_STRIPS: usize = 4096;

/// The number of strips that an edge may lie in, in the mean, so that strips take no more memory than some copies of
/// the edges.
const STRIPS_PER_EDGE: usize = 8;

/// Polygons, of which each may have holes.
#[derive(Debug)]
pub(super) struct Area {
    polygons: Vec<Polygon>,
}

/// The edges of a polygon's rings, by strips across y.
#[derive(Debug)]
struct Polygon {
    min: DVec2,
    max: DVec2,
    strips: Vec<Vec<[DVec2; 2]>>,
}

impl Area {
    pub fn new(polygons: &[Rings]) -> Self {
        Self { polygons: polygons.iter().filter_map(Polygon::new).collect() }
    }

    /// Inside if any of the polygons has the point inside.
    pub fn side(&self, p: DVec2) -> Side {
        let mut border = false;
        for polygon in &self.polygons {
            match polygon.side(p) {
                Side::Inside => return Side::Inside,
                Side::Border => border = true,
                Side::Outside => {}
            }
        }
        if border { Side::Border } else { Side::Outside }
    }
}

impl Polygon {
    /// `None` without corners.
    fn new(rings: &Rings) -> Option<Self> {
        let corners = || rings.iter().flatten().map(|corner| DVec2::from(*corner));
        let (min, max) = (corners().reduce(DVec2::min)?, corners().reduce(DVec2::max)?);
        let edges: Vec<_> = rings.iter().flat_map(|ring| edges(ring)).collect();
        let mut polygon = Self { min, max, strips: vec![Vec::new(); edges.len().clamp(1, MAX_STRIPS)] };
        let entries = |polygon: &Self| edges.iter().map(|edge| polygon.strips_of(edge).count()).sum::<usize>();
        while polygon.strips.len() > 1 && entries(&polygon) > STRIPS_PER_EDGE * edges.len() {
            polygon.strips.truncate(polygon.strips.len() / 2);
        }
        for edge in edges {
            let strips = polygon.strips_of(&edge);
            polygon.strips[strips].iter_mut().for_each(|strip| strip.push(edge));
        }
        Some(polygon)
    }

    /// The strips that an edge lies in.
    fn strips_of(&self, [a, b]: &[DVec2; 2]) -> RangeInclusive<usize> {
        self.strip(a.y.min(b.y))..=self.strip(a.y.max(b.y))
    }

    /// The strip of a y within the bounds. It never falls as y rises.
    fn strip(&self, y: f64) -> usize {
        // Halved, as the difference of the largest float64 values overflows.
        let share = (0.5 * y - 0.5 * self.min.y) / (0.5 * self.max.y - 0.5 * self.min.y);
        ((share * self.strips.len() as f64) as usize).min(self.strips.len() - 1)
    }

    /// Tells on which side of the polygon a place is, by the even-odd rule.
    fn side(&self, p: DVec2) -> Side {
        if p.cmplt(self.min).any() || p.cmpgt(self.max).any() {
            return Side::Outside;
        }
        let mut inside = false;
        for [a, b] in &self.strips[self.strip(p.y)] {
            let turn = orient2d(coord(*a), coord(*b), coord(p));
            if turn == 0.0 && p.cmpge(a.min(*b)).all() && p.cmple(a.max(*b)).all() {
                return Side::Border;
            }
            // A ray toward +x crosses the edge if the point is on the left of one that goes up, or on the right of one
            // that goes down.
            inside ^= (a.y > p.y) != (b.y > p.y) && (turn > 0.0) == (b.y > a.y);
        }
        if inside { Side::Inside } else { Side::Outside }
    }
}

/// The edges of a ring, closed from its last corner to the first.
fn edges(ring: &[[f64; 2]]) -> impl Iterator<Item = [DVec2; 2]> {
    let ends = ring.iter().skip(1).chain(ring.first());
    ring.iter().zip(ends).map(|(from, to)| [DVec2::from(*from), DVec2::from(*to)])
}

fn coord(p: DVec2) -> Coord<f64> {
    Coord { x: p.x, y: p.y }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn area(polygons: &[&[&[[f64; 2]]]]) -> Area {
        let rings = |rings: &&[&[[f64; 2]]]| rings.iter().map(|ring| ring.to_vec()).collect();
        Area::new(&polygons.iter().map(rings).collect::<Vec<Rings>>())
    }

    const SQUARE: &[[f64; 2]] = &[[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 4.0], [0.0, 0.0]];
    const HOLE: &[[f64; 2]] = &[[1.0, 1.0], [3.0, 1.0], [3.0, 3.0], [1.0, 3.0], [1.0, 1.0]];

    #[test]
    fn holes_are_outside_and_borders_are_borders() {
        let ring = area(&[&[SQUARE, HOLE]]);
        for (p, wanted) in [
            ([0.5, 0.5], Side::Inside),
            ([2.0, 2.0], Side::Outside),
            ([2.0, 3.0], Side::Border),
            ([4.0, 2.0], Side::Border),
            ([0.0, 0.0], Side::Border),
            ([4.5, 2.0], Side::Outside),
            // Level with corners.
            ([0.5, 1.0], Side::Inside),
            ([3.5, 3.0], Side::Inside),
            ([-1.0, 4.0], Side::Outside),
        ] {
            assert_eq!(ring.side(DVec2::from(p)), wanted, "{p:?}");
        }
    }

    #[test]
    fn polygons_are_united() {
        let both = area(&[&[SQUARE, HOLE], &[&[[2.0, 2.0], [9.0, 2.0], [9.0, 3.0]]]]);
        assert_eq!(both.side(DVec2::new(2.9, 2.05)), Side::Inside, "in the hole of one, but in the other");
        assert_eq!(both.side(DVec2::new(8.0, 2.5)), Side::Inside);
        assert_eq!(both.side(DVec2::new(1.5, 2.0)), Side::Outside);
    }

    #[test]
    fn far_from_the_origin_a_border_is_still_exact() {
        let far = [5e5, 5e6];
        let corners = [[0.0, 0.0], [8.0, 2.0], [0.0, 2.0]].map(|[x, y]| [far[0] + x, far[1] + y]);
        let slanted = area(&[&[&corners]]);
        assert_eq!(slanted.side(DVec2::new(far[0] + 4.0, far[1] + 1.0)), Side::Border);
        let step = 1e-9;
        assert_eq!(slanted.side(DVec2::new(far[0] + 4.0, far[1] + 1.0 + step)), Side::Inside);
        assert_eq!(slanted.side(DVec2::new(far[0] + 4.0, far[1] + 1.0 - step)), Side::Outside);
    }

    #[test]
    fn long_edges_take_little_memory_and_strips_change_nothing() {
        // A comb: every edge goes from the bottom to the top.
        let count = 20_000;
        let mut comb: Vec<[f64; 2]> = (0..count).map(|i| [f64::from(i), f64::from(i % 2)]).collect();
        comb.extend([[f64::from(count), 2.0], [0.0, 2.0]]);
        let area = area(&[&[&comb]]);
        let entries: usize = area.polygons[0].strips.iter().map(Vec::len).sum();
        assert!(entries <= STRIPS_PER_EDGE * comb.len(), "{entries}");
        for i in (0..count - 1).step_by(997) {
            // Half-way along an edge the comb's border is at a half.
            let x = f64::from(i) + 0.5;
            for (y, wanted) in
                [(0.5, Side::Border), (0.4375, Side::Outside), (0.5625, Side::Inside), (1.5, Side::Inside)]
            {
                assert_eq!(area.side(DVec2::new(x, y)), wanted, "{x} {y}");
            }
        }
    }
}
