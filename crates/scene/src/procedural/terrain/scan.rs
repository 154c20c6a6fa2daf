//! The points of a tile: as pulses from above leave them, and on walls and trunks as a scanner on the streets would.

use glam::{DVec2, DVec3};

use super::super::builder::SrgbTable;
use super::super::random::Random;
use super::ground::{self, Cover};
use super::light::{Tone, bytes, shade, sun};
use super::site::{Hit, Side, Site};
use super::trees::Tree;
use pellucid_core::cloud::{Cloud, UpAxis};

/// Points on a square meter of upright surfaces, over pulses on a square meter of ground.
const UPRIGHT: f64 = 2.2;
/// Returns of a pulse from a crown, and the share of such pulses that reach the ground.
const LEAVES: usize = 3;
const THROUGH: f64 = 0.5;
/// Meters between the pulses that estimate how many points a tile has.
const PROBES: f64 = 2.5;

/// Square meters that would get as many points at one pulse each.
pub(super) fn weight(site: &Site<'_>) -> f64 {
    let probes = (site.side / PROBES).ceil();
    let count = probes as usize;
    let step = site.side / probes;
    let returns = (0..count * count).map(|i| {
        let cell = DVec2::new((i % count) as f64, (i / count) as f64);
        let p = site.low + (cell + 0.5) * step;
        match site.hit(p) {
            Hit::Crowns([Some(_), ..]) => LEAVES as f64 + THROUGH,
            Hit::Roof(solid, ..) if solid.is_open_below(p) => 2.0,
            _ => 1.0,
        }
    });
    let upright = site.sides.iter().map(|side| side.area).chain(site.posts.iter().map(|post| post.area()));
    returns.sum::<f64>() * step * step + UPRIGHT * upright.sum::<f64>()
}

/// Returns a cloud without points, with the columns of all tiles.
pub(super) fn columns(capacity: usize) -> Cloud {
    Cloud {
        positions: Vec::with_capacity(capacity),
        colors: Some(Vec::with_capacity(capacity)),
        normals: Some(Vec::with_capacity(capacity)),
        radii: Some(Vec::with_capacity(capacity)),
        classification: Some(Vec::with_capacity(capacity)),
        up: UpAxis::Z,
        ..Cloud::default()
    }
}

/// A point before it is on the grids.
struct Point {
    at: DVec3,
    normal: DVec3,
    tone: Tone,
    radius: f64,
    class: u8,
}

/// A scan in the making.
pub(super) struct Scan<'a> {
    site: &'a Site<'a>,
    /// The tile's lowest corner and its side, millimeters.
    corner: [i64; 2],
    side: i64,
    /// Meters between pulses.
    spacing: f64,
    sun: DVec3,
    random: Random,
    table: SrgbTable,
    wanted: usize,
    cloud: Cloud,
}

/// Returns the `wanted` points of a tile whose lowest corner and side are in millimeters, at so many pulses per square
/// meter.
pub(super) fn scan(site: &Site<'_>, corner: [i64; 2], side: i64, density: f64, wanted: usize, random: Random) -> Cloud {
    let cloud = columns(wanted);
    let spacing = 1.0 / density.sqrt();
    let mut scan = Scan { site, corner, side, spacing, sun: sun(), random, table: SrgbTable::new(), wanted, cloud };
    scan.upright(density * UPRIGHT);
    scan.pulses();
    scan.cloud
}

impl Scan<'_> {
    /// Walls, trunks and lamps, at so many points per square meter.
    fn upright(&mut self, density: f64) {
        let site = self.site;
        let radius = 0.9 / density.sqrt();
        for side in &site.sides {
            self.side(side, density.sqrt(), radius);
        }
        for post in &site.posts {
            let count = (density * post.area() + self.random.unit()) as usize;
            for _ in 0..count {
                let (at, normal, tone) = post.at(&mut self.random);
                let lit = if post.head.is_some() { 1.0 } else { 0.45 };
                let tone = tone * shade(normal, self.sun, lit);
                self.push(Point { at, normal, tone, radius: radius.min(0.8 * post.radius + 0.03), class: post.class });
            }
        }
    }

    /// A wall, in rows of so many points per meter that stray by a quarter of their distance.
    fn side(&mut self, side: &Side, per_meter: f64, radius: f64) {
        let length = side.to - side.from;
        // Rounded at random, so that parts of walls get their share on average.
        let columns = (per_meter * length + self.random.unit()).floor();
        let rows = (per_meter * side.area / length).round().max(1.0);
        for i in 0..(columns * rows) as usize {
            let cell = DVec2::new(i as f64 % columns, (i as f64 / columns).floor());
            let stray = 0.5 * DVec2::new(self.random.unit(), self.random.unit()) + 0.25;
            let at = (cell + stray) / DVec2::new(columns, rows);
            self.wall(side, at.to_array(), radius);
        }
    }

    /// A point on a wall at a position of the unit square.
    fn wall(&mut self, side: &Side, [s, h]: [f64; 2], radius: f64) {
        let solid = &self.site.solids[side.solid];
        let t = side.from + s * (side.to - side.from);
        let p = side.wall.from + t * side.wall.along;
        let (ground, _) = self.site.ground(p);
        let (low, high) = (ground.max(solid.base), solid.wall_top(&side.wall, t));
        if high <= low {
            return;
        }
        let at = p.extend(low + h * (high - low));
        let normal = side.wall.normal();
        let lit = if normal.dot(self.sun) > 0.0 { self.site.lit(at + 0.5 * normal) } else { 0.0 };
        let tone = solid.wall_tone(&side.wall, t, at.z - low, solid.eave - low, radius) * shade(normal, self.sun, lit);
        let radius = radius.min(0.5 * (high - low) + 0.05);
        self.push(Point { at, normal, tone, radius, class: solid.class });
    }

    /// Pulses evenly over the tile until it has its points.
    fn pulses(&mut self) {
        let shift = [self.random.unit(), self.random.unit()];
        let mut pulse = 0;
        while self.cloud.len() < self.wanted {
            let place = DVec2::from_array(evenly(pulse, shift)) * self.site.side;
            let place = place + self.jitter(0.4);
            let p = self.site.low + self.fold(place);
            match self.site.hit(p) {
                Hit::Roof(solid, z, normal) => {
                    let lit = self.site.lit(p.extend(z) + 0.3 * normal);
                    let tone = solid.roof_tone(p) * shade(normal, self.sun, lit);
                    let radius = self.covering(normal).min(solid.half.min_element());
                    self.push(Point { at: p.extend(z), normal, tone, radius, class: solid.class });
                    // A scanner on the ground sees there.
                    if solid.is_open_below(p) {
                        self.ground(p, false);
                    }
                }
                Hit::Crowns(crowns) => self.through(p, &crowns),
            }
            pulse += 1;
        }
    }

    /// Leaves of crowns, and the ground below them if the pulse gets there.
    fn through(&mut self, p: DVec2, crowns: &[Option<&Tree>; 3]) {
        let count = crowns.iter().flatten().count();
        let before = self.cloud.len();
        if count > 0 {
            for _ in 0..LEAVES {
                let which = self.random.index(count);
                if let Some(tree) = crowns.iter().flatten().nth(which) {
                    self.leaf(tree, p);
                }
            }
        }
        if self.cloud.len() == before || self.random.unit() < THROUGH {
            self.ground(p, count > 0);
        }
    }

    fn leaf(&mut self, tree: &Tree, p: DVec2) {
        // Away from the others of its pulse, or they would stand in columns.
        let aside = p - self.site.low + self.jitter(1.2);
        let aside = self.site.low + self.fold(aside);
        let leaf = tree.leaf(aside, &mut self.random).map(|leaf| (aside, leaf));
        let Some((p, leaf)) = leaf.or_else(|| tree.leaf(p, &mut self.random).map(|leaf| (p, leaf))) else { return };
        let z = leaf.z.max(self.site.ground(p).0 + 0.05);
        let light = shade(leaf.normal, self.sun, 0.35 + 0.65 * leaf.up) * (0.78 + 0.28 * leaf.up);
        let class = match z - tree.foot.z {
            h if h < 0.5 => 3,
            h if h < 2.5 => 4,
            _ => 5,
        };
        let tone = tree.tone * light * self.random.range(0.86, 1.14);
        let radius = 0.52 * self.spacing.min(1.2);
        self.push(Point { at: p.extend(z), normal: leaf.normal, tone, radius, class });
    }

    /// A point of the ground, with larger where few pulses get through leaves.
    fn ground(&mut self, p: DVec2, below_leaves: bool) {
        let land = self.site.land;
        let place = land.place(p);
        let cover = ground::cover(land, p, &place);
        let (mut z, mut normal) = self.site.ground(p);
        let mut class = ground::class(cover);
        let mut tone = ground::tone(land, p, &place, cover, self.spacing);
        if cover == Cover::Water {
            (z, normal) = (0.0, DVec3::Z);
        }
        let lit = self.site.lit(p.extend(z + 0.1));
        let growth = ground::growth(cover) * self.random.unit();
        if growth > 0.0 {
            z += growth;
            tone *= 0.9 + 0.5 * growth;
            class = if growth > 0.15 { 3 } else { class };
        }
        let tone = tone * shade(normal, self.sun, lit);
        let wider = if below_leaves { 1.2 / THROUGH.sqrt() } else { 1.0 };
        self.push(Point { at: p.extend(z), normal, tone, radius: wider * self.covering(normal), class });
    }

    /// The radius at which discs on a surface leave no gaps.
    fn covering(&self, normal: DVec3) -> f64 {
        0.88 * self.spacing / normal.z.clamp(0.25, 1.0).sqrt()
    }

    /// A step within a square whose sides are so many distances of pulses.
    fn jitter(&mut self, size: f64) -> DVec2 {
        size * self.spacing * DVec2::new(self.random.unit() - 0.5, self.random.unit() - 0.5)
    }

    /// A position in the tile, from its lowest corner, in place of one that is just outside.
    fn fold(&self, p: DVec2) -> DVec2 {
        DVec2::from_array(p.to_array().map(|x| self.site.side - (self.site.side - x.abs()).abs()))
    }

    /// Adds a point on the grid, unless there are enough. It stays in the tile: what reaches out is mirrored at the
    /// edge.
    fn push(&mut self, point: Point) {
        if self.cloud.len() == self.wanted {
            return;
        }
        let inside = self.fold(point.at.truncate() - self.site.low);
        let grid = |x: f64, corner: i64| corner + ((1000.0 * x).floor() as i64).clamp(0, self.side - 1);
        let [x, y] = [grid(inside.x, self.corner[0]), grid(inside.y, self.corner[1])];
        let z = (1000.0 * point.at.z).round();
        self.cloud.positions.push(DVec3::new(x as f64, y as f64, z) * 0.001);
        let grain = 0.96 + 0.08 * self.random.unit();
        self.cloud.colors.get_or_insert_default().push(self.table.decode(bytes(point.tone * grain)));
        self.cloud.normals.get_or_insert_default().push(point.normal.as_vec3());
        self.cloud.radii.get_or_insert_default().push(point.radius as f32);
        self.cloud.classification.get_or_insert_default().push(point.class);
    }
}

/// The `i`-th of positions that fill the unit square evenly, however many there are (Roberts 2018).
fn evenly(i: usize, shift: [f64; 2]) -> [f64; 2] {
    [(0.754_877_666_246_692_8 * i as f64 + shift[0]).fract(), (0.569_840_290_998_053_2 * i as f64 + shift[1]).fract()]
}
