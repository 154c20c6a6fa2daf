//! Things that may stand over a position: lists by cells of a square grid.

use glam::DVec2;

use crate::lists::Lists;

/// Side of a cell, meters.
const CELL: f64 = 4.0;

/// Lists of numbers, one for each cell.
#[derive(Debug)]
pub(super) struct Bins {
    low: DVec2,
    side: usize,
    cells: Lists,
}

impl Bins {
    /// Sorts circles (middle, radius) into the cells that they may touch, of a square from its lowest corner on.
    pub(super) fn new(low: DVec2, length: f64, circles: &[(DVec2, f64)]) -> Self {
        let side = (length / CELL).ceil() as usize + 1;
        let last = side as i64 - 1;
        let cells = |(center, radius): &(DVec2, f64)| {
            let span = |at: f64| {
                let first = (((at - radius) / CELL).floor() as i64).clamp(0, last + 1);
                let end = (((at + radius) / CELL).floor() as i64).clamp(-1, last);
                first..=end
            };
            let (columns, rows) = (span(center.x - low.x), span(center.y - low.y));
            rows.flat_map(move |y| columns.clone().map(move |x| (y * side as i64 + x) as usize))
        };
        let members = |(member, circle): (u32, &(DVec2, f64))| cells(circle).map(move |cell| (cell, member));
        Self { low, side, cells: Lists::new(side * side, || (0..).zip(circles).flat_map(members)) }
    }

    /// Returns the circles that may be over a position; none outside the square.
    pub(super) fn at(&self, p: DVec2) -> impl Iterator<Item = usize> + '_ {
        let cell = (p - self.low) / CELL;
        let inside = cell.min_element() >= 0.0 && cell.max_element() < self.side as f64;
        let list = if inside { self.cells.of(cell.y as usize * self.side + cell.x as usize) } else { &[] };
        list.iter().map(|member| *member as usize)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_circle_over_a_position_is_found() {
        let circles: Vec<(DVec2, f64)> = (0..60)
            .map(|i| (DVec2::new(f64::from(i * 37 % 83) - 20.0, f64::from(i * 53 % 79) - 20.0), f64::from(i % 9)))
            .collect();
        let low = DVec2::new(-7.0, 3.0);
        let bins = Bins::new(low, 33.0, &circles);
        for i in 0..33 * 33 {
            let p = low + DVec2::new(f64::from(i % 33) + 0.3, f64::from(i / 33) + 0.7);
            let found: Vec<usize> = bins.at(p).collect();
            for (member, (center, radius)) in circles.iter().enumerate() {
                assert!(center.distance(p) > *radius || found.contains(&member), "{p}: {member}");
            }
            assert!(found.len() < 30, "{p}: {} of 60", found.len());
        }
        assert_eq!(bins.at(low - 1.0).count() + bins.at(low + 60.0).count(), 0);
    }
}
