//! Things with upright walls and a roof: houses, chimneys, churches, bridges and cars.

use glam::{DVec2, DVec3};

use super::super::random;
use super::light::Tone;

/// Distance that a gable roof reaches beyond the walls, meters.
const EAVES: f64 = 0.4;
/// Height of a storey and distance of windows, meters.
const STOREY: f64 = 2.8;
const BAY: f64 = 2.5;

/// LAS class of bridges.
pub(super) const BRIDGE: u8 = 17;

/// The shape of a roof.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Roof {
    Gable,
    Spire,
    Flat,
}

/// Look of a wall.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Front {
    Plain,
    /// Rows of windows, and a door.
    House,
    /// Tall windows.
    Church,
}

/// A body over a rectangle. Lengths in meters.
#[derive(Debug, Clone)]
pub(super) struct Solid {
    pub(super) center: DVec2,
    /// Unit vector along the ridge.
    pub(super) axis: DVec2,
    /// Half the lengths along and across the ridge.
    pub(super) half: DVec2,
    /// Height at which walls begin, unless the ground is higher.
    pub(super) base: f64,
    /// Height at which walls end.
    pub(super) eave: f64,
    /// Height from the eave to the top.
    pub(super) rise: f64,
    pub(super) roof: Roof,
    pub(super) front: Front,
    pub(super) wall: Tone,
    pub(super) cover: Tone,
    /// LAS class.
    pub(super) class: u8,
}

/// A wall, seen from outside from left to right.
#[derive(Debug, Clone, Copy)]
pub(super) struct Wall {
    pub(super) from: DVec2,
    pub(super) along: DVec2,
    pub(super) length: f64,
    /// True below a gable.
    gable: bool,
}

impl Wall {
    /// Returns the unit vector away from the body.
    pub(super) fn normal(&self) -> DVec3 {
        DVec3::new(self.along.y, -self.along.x, 0.0)
    }
}

impl Solid {
    /// Returns the radius of a circle around it.
    pub(super) fn reach(&self) -> f64 {
        self.half.length() + EAVES
    }

    pub(super) fn top(&self) -> f64 {
        self.eave + self.rise
    }

    /// A position along and across the ridge.
    fn local(&self, p: DVec2) -> DVec2 {
        let d = p - self.center;
        DVec2::new(d.dot(self.axis), d.dot(self.axis.perp()))
    }

    /// Returns the height and normal of the roof over a position, if it is there.
    pub(super) fn roof_at(&self, p: DVec2) -> Option<(f64, DVec3)> {
        let at = self.local(p);
        let beyond = if self.roof == Roof::Gable { EAVES } else { 0.0 };
        if (at.abs() - self.half).max_element() > beyond {
            return None;
        }
        let shares = at.abs() / self.half;
        let falls_along = self.roof == Roof::Spire && shares.x > shares.y;
        let (share, half, out) = if falls_along {
            (shares.x, self.half.x, self.axis * at.x.signum())
        } else {
            (shares.y, self.half.y, self.axis.perp() * at.y.signum())
        };
        if self.roof == Roof::Flat {
            return Some((self.eave, DVec3::Z));
        }
        let normal = (out * self.rise).extend(half).normalize_or(DVec3::Z);
        Some((self.eave + self.rise * (1.0 - share), normal))
    }

    /// Returns the color of the roof: rows of tiles, each of its own brightness.
    pub(super) fn roof_tone(&self, p: DVec2) -> Tone {
        if self.roof == Roof::Flat {
            return self.cover;
        }
        let at = self.local(p) / DVec2::new(0.6, 0.45);
        self.cover * (0.9 + 0.2 * random::hash(at.x.floor() as i64, at.y.floor() as i64, 5))
    }

    /// Returns `true` if there is air between the roof and the ground at a position: under eaves and bridges.
    pub(super) fn is_open_below(&self, p: DVec2) -> bool {
        self.class == BRIDGE || (self.local(p).abs() - self.half).max_element() > 0.0
    }

    pub(super) fn walls(&self) -> [Wall; 4] {
        let (a, b) = (self.axis, self.axis.perp());
        let wall = |x: f64, y: f64, along: DVec2, half: f64, gable: bool| {
            let from = self.center + x * self.half.x * a + y * self.half.y * b;
            Wall { from, along, length: 2.0 * half, gable: gable && self.roof == Roof::Gable }
        };
        [
            wall(-1.0, -1.0, a, self.half.x, false),
            wall(1.0, -1.0, b, self.half.y, true),
            wall(1.0, 1.0, -a, self.half.x, false),
            wall(-1.0, 1.0, -b, self.half.y, true),
        ]
    }

    /// Returns the upper end of a wall so many meters along it.
    pub(super) fn wall_top(&self, wall: &Wall, t: f64) -> f64 {
        let share = if wall.gable { 1.0 - (2.0 * t / wall.length - 1.0).abs() } else { 0.0 };
        self.eave + self.rise * share
    }

    /// Returns the mean of that.
    pub(super) fn mean_top(&self, wall: &Wall) -> f64 {
        self.eave + if wall.gable { 0.5 * self.rise } else { 0.0 }
    }

    /// Returns the color of a wall at so many meters along it and above the ground outside, whose points are `spacing`
    /// apart.
    pub(super) fn wall_tone(&self, wall: &Wall, t: f64, h: f64, storeys_end: f64, spacing: f64) -> Tone {
        let glass = Tone::new(66.0, 80.0, 96.0);
        let bay = |width: f64| {
            let count = (wall.length / width).floor().max(1.0);
            let at = (t / wall.length * count).rem_euclid(1.0) - 0.5;
            (at.abs() * wall.length / count, (t / wall.length * count).floor())
        };
        match self.front {
            Front::Plain => self.wall,
            Front::Church => {
                let (off, _) = bay(4.0);
                if off < 0.6 && (2.0..storeys_end - 1.5).contains(&h) { glass } else { self.wall }
            }
            Front::House => {
                let (off, which) = bay(BAY);
                let storey = (h / STOREY).floor();
                let up = h - STOREY * storey - 1.6;
                let middle = which == (0.5 * wall.length / BAY).floor();
                if storey == 0.0 && middle && !wall.gable {
                    return if off < 0.5 && h < 2.1 { Tone::new(112.0, 74.0, 50.0) } else { self.wall };
                }
                let fits = STOREY * storey + 2.4 < storeys_end || wall.gable && off + t.min(wall.length - t) > 1.6;
                if !fits || up.abs() > 0.82 || off > 0.67 {
                    // A plinth.
                    return if h < 0.45 { self.wall * 0.72 } else { self.wall };
                }
                let frame = up.abs() > 0.7 || !(0.04..=0.55).contains(&off);
                // Frames of single points would tear the glass.
                if frame && spacing < 0.12 { Tone::new(240.0, 238.0, 232.0) } else { glass }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn house(roof: Roof) -> Solid {
        Solid {
            center: DVec2::new(10.0, 20.0),
            axis: DVec2::new(0.6, 0.8),
            half: DVec2::new(5.0, 4.0),
            base: 0.0,
            eave: 6.0,
            rise: 4.0,
            roof,
            front: Front::House,
            wall: Tone::ONE,
            cover: Tone::ONE,
            class: 6,
        }
    }

    #[test]
    fn roofs_rise_from_their_walls() {
        for (roof, ridge_end) in [(Roof::Gable, 10.0), (Roof::Spire, 6.0), (Roof::Flat, 6.0)] {
            let house = house(roof);
            let height = |along: f64, across: f64| {
                house.roof_at(house.center + along * house.axis + across * house.axis.perp()).map(|(z, _)| z)
            };
            let near = |found: Option<f64>, wanted: f64| found.is_some_and(|z| (z - wanted).abs() < 1e-9);
            assert!(near(height(0.0, 0.0), house.top() - if roof == Roof::Flat { 4.0 } else { 0.0 }), "{roof:?}");
            assert!(near(height(5.0 - 1e-12, 0.0), ridge_end), "{roof:?}: {:?}", height(5.0, 0.0));
            assert!(near(height(0.0, 4.0 - 1e-12), 6.0) && height(0.0, 4.5).is_none() && height(5.5, 0.0).is_none());
        }
        // The normals of a gable of 45 degrees look away from the ridge.
        let (_, normal) = house(Roof::Gable).roof_at(DVec2::new(10.0, 20.0) + DVec2::new(-0.8, 0.6)).unwrap();
        assert!((normal - DVec3::new(-0.8, 0.6, 1.0).normalize()).length() < 1e-12, "{normal}");
    }

    #[test]
    fn walls_go_around_and_look_outside() {
        let house = house(Roof::Gable);
        let walls = house.walls();
        for (wall, next) in walls.iter().zip(walls.iter().cycle().skip(1)) {
            assert!((wall.from + wall.length * wall.along).distance(next.from) < 1e-12);
            let middle = wall.from + 0.5 * wall.length * wall.along;
            assert!(wall.normal().truncate().dot(middle - house.center) > 0.0);
        }
        let tops = walls.map(|wall| house.wall_top(&wall, 0.5 * wall.length));
        assert_eq!(tops, [6.0, 10.0, 6.0, 10.0]);
    }
}
