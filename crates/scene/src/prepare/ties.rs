//! Points in the same place: all that settings which keep positions can change about the canonical order.
//!
//! The order goes by position first ([`order`](super::order)), so only points of equal position trade places when
//! colors, opacities, radii or fields become others.

use std::cmp::Ordering;

use glam::DVec3;
use rayon::prelude::*;

use super::order;
use pellucid_core::points::Points;

/// Groups of places in a list of points whose points have the same position, to the bit; each group in canonical order.
/// At most 8 bytes for each point that is in one.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(crate) struct Ties {
    /// Group after group.
    places: Vec<u32>,
    /// The end of each group among the places.
    ends: Vec<u32>,
}

impl Ties {
    /// Returns the groups of positions in canonical order.
    pub fn find(positions: &[DVec3]) -> Self {
        let bits = |i: usize| positions[i].to_array().map(f64::to_bits);
        let mut ties = Self::default();
        for i in 1..positions.len() {
            if bits(i) != bits(i - 1) {
                continue;
            }
            if ties.places.last() != Some(&(i as u32 - 1)) {
                ties.close();
                ties.places.push(i as u32 - 1);
            }
            ties.places.push(i as u32);
        }
        ties.close();
        ties
    }

    fn close(&mut self) {
        let end = self.places.len() as u32;
        if end > self.ends.last().copied().unwrap_or(0) {
            self.ends.push(end);
        }
    }

    /// Returns `true` if no two points have the same position.
    pub fn is_empty(&self) -> bool {
        self.places.is_empty()
    }

    /// Adds the groups of other points, at other positions.
    pub fn extend(&mut self, others: &Self, place: impl Fn(u32) -> u32) {
        let before = self.places.len() as u32;
        self.places.extend(others.places.iter().map(|other| place(*other)));
        self.ends.extend(others.ends.iter().map(|end| before + end));
    }

    fn groups(&self) -> impl IndexedParallelIterator<Item = &[u32]> {
        let start = |group: usize| group.checked_sub(1).map_or(0, |before| self.ends[before] as usize);
        (0..self.ends.len()).into_par_iter().map(move |group| &self.places[start(group)..self.ends[group] as usize])
    }

    /// Puts points of equal position into canonical order, and identical ones in the order of `origins`, their original
    /// places, which move along. Returns true if any point moved. `points.file_order` stays unchanged.
    pub fn settle(&self, points: &mut Points, origins: &mut [u32]) -> bool {
        let by_all = |points: &Points, origins: &[u32], a: u32, b: u32| {
            let [a, b] = [a as usize, b as usize];
            order::by_look((points, a), (points, b)).then(origins[a].cmp(&origins[b]))
        };
        let in_order = |a: &u32, b: &u32| by_all(points, origins, *a, *b) != Ordering::Greater;
        let unsettled: Vec<&[u32]> = self.groups().filter(|group| !group.is_sorted_by(in_order)).collect();
        for group in &unsettled {
            let mut order = group.to_vec();
            order.sort_unstable_by(|a, b| by_all(points, origins, *a, *b));
            moved(&mut points.colors, group, &order);
            moved(&mut points.opacities, group, &order);
            moved(&mut points.radii, group, &order);
            moved(&mut points.fields, group, &order);
            if let Some(normals) = &mut points.normals {
                moved(normals, group, &order);
            }
            if let Some(gaussians) = &mut points.gaussians {
                gaussians.trade(group, &order);
            }
            moved(origins, group, &order);
        }
        !unsettled.is_empty()
    }
}

/// Gives each of some places what stood at another one; nothing of a column that isn't there.
fn moved<T: Copy>(column: &mut [T], places: &[u32], from: &[u32]) {
    if column.is_empty() {
        return;
    }
    let values: Vec<T> = from.iter().map(|place| column[*place as usize]).collect();
    for (place, value) in places.iter().zip(values) {
        column[*place as usize] = value;
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;

    fn at(x: &[f64]) -> Vec<DVec3> {
        x.iter().map(|x| DVec3::splat(*x)).collect()
    }

    #[test]
    fn groups_are_found_and_zeros_of_two_signs_are_two_places() {
        let ties = Ties::find(&at(&[1.0, 2.0, 2.0, 2.0, 3.0, 3.0, 4.0, 0.0, -0.0]));
        assert_eq!((ties.places.as_slice(), ties.ends.as_slice()), ([1, 2, 3, 4, 5].as_slice(), [3, 5].as_slice()));
        assert!(Ties::find(&at(&[1.0, 2.0, 1.0])).is_empty() && Ties::find(&[]).is_empty());
        let mut both = ties.clone();
        both.extend(&ties, |place| 100 - place);
        assert_eq!(
            (&both.places[5..], both.ends.as_slice()),
            ([99, 98, 97, 96, 95].as_slice(), [3, 5, 8, 10].as_slice())
        );
    }

    #[test]
    fn points_of_a_group_trade_places() {
        let mut points = Points {
            positions: at(&[1.0, 2.0, 2.0, 2.0, 3.0]),
            colors: vec![Vec3::ONE; 5],
            opacities: vec![0.9, 0.5, 0.1, 0.5, 0.0],
            radii: vec![1.0, 4.0, 3.0, 4.0, 0.0],
            ..Points::default()
        };
        let (ties, mut origins) = (Ties::find(&points.positions), vec![7, 9, 5, 6, 8]);
        assert!(ties.settle(&mut points, &mut origins));
        assert_eq!(points.opacities, [0.9, 0.1, 0.5, 0.5, 0.0]);
        assert_eq!(points.radii, [1.0, 3.0, 4.0, 4.0, 0.0]);
        assert_eq!(origins, [7, 5, 6, 9, 8]);
        assert!(!ties.settle(&mut points, &mut origins));
    }
}
