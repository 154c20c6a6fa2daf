//! Spread of work over groups that shaders handle one by one: splats of tiles, fragments of pixels.
//!
//! A pass lasts as long as its longest group, so that a maximum far above the median leaves most of a device idle.

use std::collections::BTreeMap;

use serde_json::{Value, json};

/// Spread of work over groups.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spread {
    /// Groups with work.
    pub busy: u64,
    /// Groups without.
    pub empty: u64,
    /// Least work of a group that has any.
    pub min: u32,
    /// Median of the groups with work.
    pub median: f64,
    /// Most work of a group.
    pub max: u32,
}

impl Spread {
    /// Returns the spread of work of which `histogram` has the amounts, ascending, with the number of groups; `None` if
    /// no group has work.
    pub fn of(histogram: &[(u32, u64)]) -> Option<Self> {
        let empty = histogram.iter().filter(|(amount, _)| *amount == 0).map(|(_, groups)| groups).sum();
        let busy: Vec<(u32, u64)> = histogram.iter().copied().filter(|(amount, n)| *amount > 0 && *n > 0).collect();
        let groups: u64 = busy.iter().map(|(_, groups)| groups).sum();
        // The amount of the group of this number, in ascending order.
        let at = |number: u64| {
            let mut before = 0;
            let reaches = |groups: u64| {
                before += groups;
                before > number
            };
            busy.iter().map(|(_, groups)| *groups).position(reaches).map_or(0.0, |place| f64::from(busy[place].0))
        };
        let (first, last) = (busy.first()?, busy.last()?);
        let median = 0.5 * (at((groups - 1) / 2) + at(groups / 2));
        Some(Self { busy: groups, empty, min: first.0, median, max: last.0 })
    }

    /// Returns the form of a profile's JSON.
    pub fn to_json(self) -> Value {
        json!({"busy": self.busy, "empty": self.empty, "min": self.min, "median": self.median, "max": self.max})
    }

    /// Returns words for people: `3 / 12 / 431 splats in a tile (of 1200, 34 more are empty)`.
    pub fn text(self, work: &str, group: &str) -> String {
        let Self { busy, empty, min, median, max } = self;
        format!("{min} / {median} / {max} {work} in a {group} (of {busy}, {empty} more are empty)")
    }
}

/// Adds amounts to a histogram: amounts and the number of groups with each, ascending.
pub fn add(histogram: &mut Vec<(u32, u64)>, amounts: &[u32]) {
    let mut counts: BTreeMap<u32, u64> = histogram.drain(..).collect();
    for amount in amounts {
        *counts.entry(*amount).or_insert(0) += 1;
    }
    histogram.extend(counts);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spreads_by_hand() {
        assert_eq!(Spread::of(&[]), None);
        assert_eq!(Spread::of(&[(0, 7)]), None);
        // 2, 2, 5 | 9: the middle ones of four are 2 and 5.
        let even = Spread { busy: 4, empty: 3, min: 2, median: 3.5, max: 9 };
        assert_eq!(Spread::of(&[(0, 3), (2, 2), (5, 1), (9, 1)]), Some(even));
        // 1, 4, 4.
        let odd = Spread { busy: 3, empty: 0, min: 1, median: 4.0, max: 4 };
        assert_eq!(Spread::of(&[(1, 1), (4, 2)]), Some(odd));
        assert_eq!(even.text("splats", "tile"), "2 / 3.5 / 9 splats in a tile (of 4, 3 more are empty)");
        assert_eq!(odd.to_json(), json!({"busy": 3, "empty": 0, "min": 1, "median": 4.0, "max": 4}));
    }

    #[test]
    fn histograms_add_up() {
        let mut histogram = vec![(0, 2), (3, 1)];
        add(&mut histogram, &[3, 1, 0]);
        assert_eq!(histogram, [(0, 3), (1, 1), (3, 2)]);
    }
}
