//! A landscape in tiles that are made when they are read.

use std::path::{Path, PathBuf};

use glam::{DVec2, DVec3};

use super::super::random::Random;
use super::land::Land;
use super::scan::{columns, scan, weight};
use super::site::Site;
use super::{Error, NAME, RANGE};
use pellucid_core::cloud::{Bounds, Cloud, UpAxis};
use pellucid_core::parallel;
use pellucid_core::progress::Progress;
use pellucid_io::store::build::{Built, Cube, Settings, Streamed, Types, stream};
use pellucid_io::store::{Grid, Node, Piece, Store, Summary};

/// Meters of side for a single point; those of n are ∛n times as many, nearly: sides are whole tiles.
const SIDE: f64 = 4.472;
/// Most points of a tile, on average.
const TILE_POINTS: f64 = 131_072.0;
/// Fewest tiles along a side, so that rounding to whole ones changes a side by less than a twentieth.
const LEAST_COLUMNS: f64 = 12.0;
/// Lowest height of the cube around a landscape, millimeters.
const FLOOR: i64 = -8000;

/// A landscape of a given number of points. Tiles are squares of the same size in Morton order, whose points have
/// coordinates of whole millimeters; z is up. A tile's side is a power of two of millimeters, so that tiles are columns
/// of cells of an octree on that grid.
#[derive(Debug, Clone)]
pub struct Terrain {
    land: Land,
    seed: u64,
    /// Tiles along a side.
    columns: i64,
    /// Side of a tile, millimeters, and its binary logarithm.
    tile: i64,
    tile_bits: u32,
    /// Each tile's column and row.
    places: Vec<[i64; 2]>,
    /// Pulses per square meter.
    density: f64,
    summary: Summary,
    nodes: Vec<Node>,
    /// Points of the tiles before each.
    starts: Vec<u64>,
}

impl Terrain {
    /// Plans a landscape of exactly so many points, from 10⁴ to 10¹⁰: counts and bounds of its tiles are known, no
    /// point is made.
    ///
    /// # Errors
    /// Another number of points.
    pub fn new(points: u64, seed: u64) -> Result<Self, Error> {
        let count = points as f64;
        let [min, max] = RANGE;
        if !(min..=max).contains(&count) {
            return Err(Error::OutOfRange { scene: NAME, name: "points", value: count, min, max });
        }
        let wanted = 1000.0 * SIDE * cube_root(count);
        let fits = |bits: &u32| {
            let share = f64::from(1u32 << bits) / wanted;
            share * LEAST_COLUMNS <= 1.0 && count * share * share <= TILE_POINTS
        };
        let tile_bits = (1..31).rev().find(fits).unwrap_or(1);
        let tile = 1i64 << tile_bits;
        let columns = (wanted / tile as f64).round() as i64;
        let levels = (columns as u64).next_power_of_two().ilog2();
        let all = (0..1u64 << (2 * levels)).map(|code| [code, code >> 1].map(|bits| even_bits(bits) as i64));
        let side = 0.001 * (tile * columns) as f64;
        let mut terrain = Self {
            land: Land::new(side, seed),
            seed,
            columns,
            tile,
            tile_bits,
            places: all.filter(|[x, y]| *x.max(y) < columns).collect(),
            density: 1.0,
            summary: summary(points, side),
            nodes: Vec::new(),
            starts: Vec::new(),
        };
        terrain.plan();
        Ok(terrain)
    }

    /// Meters of side.
    pub fn side(&self) -> f64 {
        self.land.side
    }

    /// Returns the root of the octree whose cells of some level have the tiles as columns.
    pub fn cube(&self) -> Cube {
        let levels = (self.columns as u64).next_power_of_two().ilog2();
        // Half a landscape of 10¹⁰ points is 5·10⁶ mm.
        let low = (-self.columns * self.tile / 2) as i32;
        Cube { grid: grid(), least: [low, low, FLOOR as i32], bits: [self.tile_bits + levels; 3] }
    }

    /// Writes the landscape as an octree of Potree 2.0 in a folder, as [`stream`] does: with positions, colors, classes
    /// and radii, 23 bytes a point. Normals are left out: they would take half as many bytes again, and the light is in
    /// the colors.
    ///
    /// # Errors
    /// Returns the errors of [`stream`].
    pub fn write(&self, folder: &Path, settings: &Settings, progress: &Progress) -> Result<Built, pellucid_io::Error> {
        // Colors have 8 bits.
        let layout = Types::default().columns(&Cloud { normals: None, ..self.summary.like.clone() });
        let key = format!("{NAME} of {} points, seed {}", self.summary.points, self.seed);
        let streamed = Streamed { store: self, cube: self.cube(), layout: &layout, key: &key };
        stream(&streamed, folder, settings, progress)
    }

    /// Returns the scene file that shows the landscape, whose points are in the file or folder of this name.
    pub fn scene_toml(&self, path: &str) -> String {
        // From above the river over the town to the hills; of large landscapes a part.
        let scale = self.land.side.min(1500.0);
        let at = |x: f64, y: f64, z: f64| [x, y, z].map(|share| (10.0 * share * scale).round() / 10.0);
        let (eye, target) = (at(0.3, -0.4, 0.17), at(-0.03, 0.03, 0.0));
        format!(
            r#"# An airborne scan of a made-up river valley: {points} points on {side:.0} x {side:.0} m.
[image]
size = [1600, 900]
background = [0.62, 0.74, 0.86]

# The colors have light in them.
[shading]
model = "none"

[camera]
eye = {eye:?}
target = {target:?}
up = [0.0, 0.0, 1.0]
fov_y = 45.0

[[cloud]]
path = "{path}"

[[cloud.class]]
id = "high-vegetation"
opacity = 0.6

[[cloud.class]]
id = "medium-vegetation"
opacity = 0.6

[method]
name = "auto"
"#,
            points = self.summary.points,
            side = self.land.side,
        )
    }

    /// The lowest corner of a tile, millimeters.
    fn corner(&self, index: usize) -> [i64; 2] {
        let half = self.columns * self.tile / 2;
        self.places[index].map(|place| place * self.tile - half)
    }

    /// Returns what stands in a tile.
    fn site(&self, index: usize) -> Site<'_> {
        let [x, y] = self.corner(index).map(|mm| 0.001 * mm as f64);
        Site::new(&self.land, DVec2::new(x, y), 0.001 * self.tile as f64)
    }

    /// Deals the points to the tiles by what stands there.
    fn plan(&mut self) {
        let tiles = self.places.len();
        let estimate = |index: usize| {
            let site = self.site(index);
            (weight(&site), site.heights())
        };
        let estimates: Vec<(f64, [f64; 2])> = parallel::map(tiles, estimate);
        let total: f64 = estimates.iter().map(|(weight, _)| weight).sum();
        let points = self.summary.points;
        self.density = points as f64 / total;
        let (mut before, mut start) = (0.0, 0);
        for (index, (weight, [low, high])) in estimates.iter().enumerate() {
            before += weight;
            let last = index + 1 == tiles;
            let end = if last { points } else { ((before / total * points as f64) as u64).clamp(start, points) };
            let corner = self.corner(index).map(|mm| 0.001 * mm as f64);
            let far = self.corner(index).map(|mm| 0.001 * (mm + self.tile - 1) as f64);
            let bounds = Bounds { min: DVec3::new(corner[0], corner[1], *low), max: DVec3::new(far[0], far[1], *high) };
            self.starts.push(start);
            self.nodes.push(Node {
                level: 0,
                parent: None,
                bounds,
                points: end - start,
                bytes: 0,
                spacing: 0.0,
                largest_radius: None,
            });
            start = end;
        }
        let all = self.nodes.iter().map(|node| node.bounds).reduce(Bounds::union);
        self.summary.bounds = all.unwrap_or(self.summary.bounds);
    }

    /// Returns the points of a tile.
    pub(super) fn tile(&self, index: usize) -> Cloud {
        let site = self.site(index);
        let random = Random::new(self.seed.wrapping_add((index as u64 + 1).wrapping_mul(0x9E37_79B9_7F4A_7C15)));
        let wanted = self.nodes[index].points as usize;
        scan(&site, self.corner(index), self.tile, self.density, wanted, random)
    }
}

impl Store for Terrain {
    fn summary(&self) -> &Summary {
        &self.summary
    }

    fn nodes(&self) -> &[Node] {
        &self.nodes
    }

    fn read(&self, node: usize) -> Result<Piece, pellucid_io::Error> {
        let first = self.starts[node];
        Ok(Piece { cloud: self.tile(node), places: (first..first + self.nodes[node].points).collect() })
    }
}

fn summary(points: u64, side: f64) -> Summary {
    let corner = DVec3::new(0.5 * side, 0.5 * side, 0.0);
    Summary {
        path: PathBuf::from(NAME),
        points,
        bounds: Bounds { min: -corner, max: corner },
        up: UpAxis::Z,
        ranges: Vec::new(),
        grid: Some(grid()),
        like: columns(0),
    }
}

/// Millimeters.
fn grid() -> Grid {
    Grid { scale: DVec3::splat(0.001), offset: DVec3::ZERO }
}

/// Takes the cube root by Newton's method: the standard library's differs between platforms.
fn cube_root(value: f64) -> f64 {
    (0..100).fold(value, |root, _| (2.0 * root + value / (root * root)) / 3.0)
}

/// The bits 0, 2, 4, … as a number.
fn even_bits(bits: u64) -> u64 {
    (0..32).fold(0, |number, i| number | (bits >> (2 * i) & 1) << i)
}
