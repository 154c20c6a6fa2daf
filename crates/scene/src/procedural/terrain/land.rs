//! The lie of the land: valleys, hills and water, and the bent coordinates along which roads, streets and fields run.

use glam::DVec2;

use super::super::random;

/// Distance between rivers and between main roads, meters; a town stands near each crossing.
const PERIOD: f64 = 2400.0;

/// Cosine and sine of the angle by which streets are turned against the axes.
const TURN: [f64; 2] = [12.0 / 13.0, 5.0 / 13.0];

/// Keys of the noises and hashes, so that none repeats another.
mod layer {
    pub(super) const BEND_U: i64 = 1;
    pub(super) const BEND_V: i64 = 2;
    pub(super) const RIVER: i64 = 3;
    pub(super) const TOWN: i64 = 4;
    pub(super) const HILLS: i64 = 10;
    pub(super) const KNOLLS: i64 = 20;
}

/// A landscape without anything on it. Lengths in meters; the origin is in the middle of a town, z = 0 the level of the
/// water.
#[derive(Debug, Clone)]
pub(super) struct Land {
    salt: i64,
    /// Side of the square.
    pub(super) side: f64,
    /// Height of the hills.
    relief: f64,
    /// Distances from a river at which hills begin and are as high as they get.
    valley: [f64; 2],
    /// Half the width of a river.
    pub(super) river: f64,
    /// Radius of the largest town.
    town: f64,
}

/// A position as streets see it: their coordinates, counted from the crossing of roads that the nearest town stands at.
#[derive(Debug, Clone, Copy)]
pub(super) struct StreetPlace {
    /// Place across the main road, and along it.
    pub(super) uv: DVec2,
    /// Cell of the grid of towns.
    pub(super) town: [i64; 2],
    /// Meters from the middle of the river.
    pub(super) river: f64,
}

impl Land {
    pub(super) fn new(side: f64, seed: u64) -> Self {
        Self {
            salt: seed.wrapping_mul(0xD6E8_FEB8_6659_FD93).rotate_left(29) as i64,
            side,
            relief: (0.14 * side).clamp(12.0, 190.0),
            valley: [(0.07 * side).clamp(15.0, 130.0), (0.5 * side).clamp(60.0, 800.0)],
            river: (0.022 * side).clamp(5.0, 22.0),
            town: (0.21 * side).clamp(75.0, 340.0),
        }
    }

    /// Uniform in [0, 1) by two whole numbers and what it is for.
    pub(super) fn hash(&self, x: i64, y: i64, layer: i64) -> f64 {
        random::hash(x, y, layer.wrapping_add(self.salt))
    }

    /// Noise in [−1, 1], smooth over lengths of 1.
    pub(super) fn noise(&self, p: DVec2, layer: i64) -> f64 {
        let cell = p.floor();
        let f = p - cell;
        let w = f * f * f * (f * (6.0 * f - 15.0) + 10.0);
        let (x, y) = (cell.x as i64, cell.y as i64);
        let row = |y: i64| {
            let [a, b] = [self.hash(x, y, layer), self.hash(x + 1, y, layer)];
            a + (b - a) * w.x
        };
        let [a, b] = [row(y), row(y + 1)];
        2.0 * (a + (b - a) * w.y) - 1.0
    }

    /// Noise along a line.
    fn wave(&self, t: f64, layer: i64) -> f64 {
        self.noise(DVec2::new(t, 0.5), layer)
    }

    /// Returns how far streets along v are bent at `v`, zero at the origin.
    fn bend_u(&self, v: f64) -> f64 {
        let bend =
            |v: f64| 17.0 * self.wave(v / 210.0, layer::BEND_U) + 55.0 * self.wave(v / 1300.0, layer::BEND_U + 50);
        bend(v) - bend(0.0)
    }

    fn bend_v(&self, u: f64) -> f64 {
        let bend =
            |u: f64| 13.0 * self.wave(u / 190.0, layer::BEND_V) + 55.0 * self.wave(u / 1500.0, layer::BEND_V + 50);
        bend(u) - bend(0.0)
    }

    /// Returns a position in the coordinates of streets.
    pub(super) fn place(&self, p: DVec2) -> StreetPlace {
        let [cos, sin] = TURN;
        let turned = DVec2::new(cos * p.x + sin * p.y, cos * p.y - sin * p.x);
        let u = turned.x + self.bend_u(turned.y);
        let v = turned.y + self.bend_v(u);
        let all = DVec2::new(u, v);
        let town = (all / PERIOD).round();
        let uv = all - PERIOD * town;
        let town = [town.x as i64, town.y as i64];
        StreetPlace { uv, town, river: self.river_gap(uv, town) }
    }

    /// Returns the position of a place.
    pub(super) fn position(&self, uv: DVec2, town: [i64; 2]) -> DVec2 {
        let all = uv + PERIOD * DVec2::new(town[0] as f64, town[1] as f64);
        let turned_v = all.y - self.bend_v(all.x);
        let turned_u = all.x - self.bend_u(turned_v);
        let [cos, sin] = TURN;
        DVec2::new(cos * turned_u - sin * turned_v, sin * turned_u + cos * turned_v)
    }

    /// Returns the unit vector along v at a place.
    pub(super) fn along_v(&self, uv: DVec2, town: [i64; 2]) -> DVec2 {
        let step = self.position(uv + DVec2::Y, town) - self.position(uv - DVec2::Y, town);
        step.normalize_or(DVec2::Y)
    }

    /// Returns where a river runs, from the middle of its towns.
    fn river_line(&self, u: f64, row: i64) -> f64 {
        let swing = (0.05 * self.side).clamp(6.0, 80.0);
        let length = (0.3 * self.side).clamp(80.0, 450.0);
        -0.72 * self.town - self.river + swing * self.wave(u / length, layer::RIVER + 100 * row)
    }

    /// Meters from the middle of the river to a place.
    pub(super) fn river_gap(&self, uv: DVec2, town: [i64; 2]) -> f64 {
        uv.y - self.river_line(uv.x + PERIOD * town[0] as f64, town[1])
    }

    /// Returns the radius of a town.
    pub(super) fn town_radius(&self, town: [i64; 2]) -> f64 {
        let share = if town == [0, 0] { 1.0 } else { 0.3 + 0.6 * self.hash(town[0], town[1], layer::TOWN) };
        share * self.town
    }

    /// 0 in the bottom of a valley, 1 among the hills.
    pub(super) fn upland(&self, place: &StreetPlace) -> f64 {
        let [low, high] = self.valley;
        smooth((place.river.abs() - low) / (high - low))
    }

    /// Returns the height of the ground, below 0 under water.
    pub(super) fn height(&self, p: DVec2) -> f64 {
        let place = self.place(p);
        let from_bank = place.river.abs() - self.river;
        if from_bank < 0.0 {
            return -1.5 * (-from_bank / self.river).min(1.0);
        }
        let radius = self.town_radius(place.town);
        let open = smooth((place.uv.length() - 0.8 * radius) / (0.9 * radius));
        let shore = smooth(from_bank / 9.0);
        let upland = self.upland(&place) * (0.1 + 0.9 * open);
        let knolls = 3.2 * self.noise(p / 75.0, layer::KNOLLS) + 0.7 * self.noise(p / 23.0, layer::KNOLLS + 1);
        let hills = self.relief * upland * (0.2 + 0.8 * self.hills(p)) + 0.006 * from_bank;
        2.6 * shore + hills + shore * (0.12 + 0.88 * open) * (0.7 + knolls * (0.25 + 0.75 * upland))
    }

    /// Hills between 0 and 1.
    fn hills(&self, p: DVec2) -> f64 {
        let mut length = (0.42 * self.side).clamp(110.0, 950.0);
        let (mut sum, mut weight, mut at) = (0.0, 0.62, p);
        for octave in 0..4 {
            sum += weight * self.noise(at / length + 0.37, layer::HILLS + octave);
            // Turned by the triangle of sides 3, 4 and 5, so that the cells of octaves don't line up.
            at = DVec2::new(0.8 * at.x - 0.6 * at.y, 0.6 * at.x + 0.8 * at.y);
            length *= 0.47;
            weight *= 0.42;
        }
        (0.5 + 0.62 * sum).clamp(0.0, 1.0)
    }
}

/// Rises from 0 to 1 without a kink, and stays there.
pub(super) fn smooth(t: f64) -> f64 {
    let t = t.clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_are_found_again() {
        let land = Land::new(4000.0, 3);
        for i in 0..200 {
            let p = DVec2::new(f64::from(i % 20) - 9.7, f64::from(i / 20) - 5.2) * 203.0;
            let place = land.place(p);
            // Sums and differences of numbers below 4000: some of their last bits.
            assert!(land.position(place.uv, place.town).distance(p) < 1e-9, "{p}");
        }
    }

    #[test]
    fn the_ground_has_no_steps() {
        let land = Land::new(450.0, 1);
        for i in 0..100_000 {
            let p = DVec2::new(f64::from(i % 400), f64::from(i / 400)) * 1.1 - 200.0;
            let step = land.height(p + DVec2::new(0.01, 0.0)) - land.height(p);
            // No slope is steeper than 55 degrees.
            assert!(step.abs() < 0.0143, "{p}: {step}");
        }
    }
}
