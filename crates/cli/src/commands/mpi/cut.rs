//! Divides an image among the ranks: rectangles of whole tiles that are expected to cost the same.

use glam::DVec3;
use pellucid_core::camera::{Camera, Projection};
use pellucid_core::points::Points;
use pellucid_engine::methods::Frame;
use pellucid_engine::passes::bands::Window;
use pellucid_scene::DiscShape;

/// Side of a tile in pixels: no tile is cut, so that its splats are ordered once.
pub const TILE: u32 = 16;

/// Most points that are looked at; of more, every so manieth.
const LOOKED_AT: usize = 200_000;

/// Rows of tiles that a rectangle has at least before it is cut between columns: rows of whole width travel without
/// being copied.
const ROWS: u32 = 4;

/// Work, as a number of fragments that takes as long: of a point that may show, and of a pixel (`abuffer` on lavapipe).
pub const POINT: f64 = 4.0;
pub const PIXEL: f64 = 0.25;

/// Expected cost of the tiles of an image, in fragments.
#[derive(Debug, Clone, PartialEq)]
pub struct Costs {
    size: [u32; 2],
    columns: u32,
    tiles: Vec<Tile>,
}

/// Expected cost of a tile.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Tile {
    points: f64,
    fragments: f64,
    /// Measured over expected cost, as far as that is known.
    factor: f64,
}

impl Default for Tile {
    fn default() -> Self {
        Self { points: 0.0, fragments: 0.0, factor: 1.0 }
    }
}

/// Expected cost of a part of an image.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Load {
    /// Points that show there.
    pub points: f64,
    /// Fragments.
    pub fragments: f64,
    /// Pixels.
    pub pixels: f64,
    /// Total work, as a number of fragments that takes as long.
    pub work: f64,
}

impl Costs {
    /// The costs of a frame, by where points are and how large.
    pub fn expected(frame: &Frame, points: &Points) -> Self {
        let (camera, mut costs) = (&frame.camera, Self::blank(frame.size));
        let is_tilted = frame.method.discs().is_some_and(|discs| discs.shape == DiscShape::Oriented);
        let step = points.positions.len().div_ceil(LOOKED_AT).max(1);
        let each = points.count() as f64 / points.positions.len().max(1) as f64 * step as f64;
        for at in (0..points.positions.len()).step_by(step) {
            let radius = points.radii.get(at).copied().unwrap_or(0.0) * frame.factors.radius;
            let tilt = if is_tilted { points.own_normal(at) } else { None };
            let slant = tilt.map_or(1.0, |normal| slant(camera, points.positions[at], normal.as_dvec3()));
            costs.add(camera, points.positions[at], (f64::from(radius), slant), each);
        }
        costs
    }

    /// Returns the costs of an image of this size without points.
    pub fn blank(size: [u32; 2]) -> Self {
        let [columns, rows] = size.map(|side| side.div_ceil(TILE));
        Self { size, columns, tiles: vec![Tile::default(); (columns * rows) as usize] }
    }

    /// Adds `count` points like this one, of which a part of the area shows.
    fn add(&mut self, camera: &Camera, position: DVec3, (radius, slant): (f64, f64), count: f64) {
        let ([x, y], depth) = {
            let (pixel, depth) = camera.project(position, self.size);
            (pixel.to_array(), depth)
        };
        let behind = matches!(camera.projection, Projection::Perspective { .. }) && depth < camera.near;
        if behind || depth > camera.far || !(x.is_finite() && y.is_finite()) {
            return;
        }
        let radius = radius * camera.pixels_per_unit(depth, self.size[1]);
        // The tiles that its square meets, and those of them that the image has.
        let met = |middle: f64| [middle - radius, middle + radius].map(|edge| (edge / f64::from(TILE)).floor());
        let [wide, high] = [met(x), met(y)];
        let all = (wide[1] - wide[0] + 1.0) * (high[1] - high[0] + 1.0);
        let within = |[first, last]: [f64; 2], side: u32| {
            let most = f64::from(side.div_ceil(TILE));
            first.clamp(0.0, most) as u32..(last + 1.0).clamp(0.0, most) as u32
        };
        let (columns, rows) = (within(wide, self.size[0]), within(high, self.size[1]));
        let area = slant * std::f64::consts::PI * radius * radius;
        for row in rows {
            for column in columns.clone() {
                let tile = &mut self.tiles[(row * self.columns + column) as usize];
                tile.points += count / all;
                tile.fragments += count * area / all;
            }
        }
    }

    /// Returns the expected cost of a region of whole tiles.
    pub fn of(&self, window: Window) -> Load {
        let mut load = Load::default();
        for (at, pixels) in self.tiles_of(window) {
            let Tile { points, fragments, factor } = self.tiles[at];
            load.points += points;
            load.fragments += fragments;
            load.pixels += pixels;
            load.work += factor * (POINT * points + fragments + PIXEL * pixels);
        }
        load
    }

    /// The tiles of a region, and how many pixels of the image each has.
    fn tiles_of(&self, [x0, y0, x1, y1]: Window) -> impl Iterator<Item = (usize, f64)> {
        let Self { columns, size: [width, height], .. } = *self;
        let side = |tile: u32, side: u32| f64::from(TILE.min(side - tile * TILE));
        let rows = if x0 < x1 { y0 / TILE..y1.div_ceil(TILE) } else { 0..0 };
        rows.flat_map(move |row| {
            let tiles = x0 / TILE..x1.div_ceil(TILE);
            tiles.map(move |column| ((row * columns + column) as usize, side(row, height) * side(column, width)))
        })
    }

    /// Takes over what regions have really taken, each set of them together: in any unit of time.
    pub fn learn(&mut self, taken: &[(&[Window], f64)]) {
        let expected = |windows: &[Window]| windows.iter().map(|window| self.of(*window).work).sum::<f64>();
        let of_sets: Vec<f64> = taken.iter().map(|(windows, _)| expected(windows)).collect();
        let mean = taken.iter().map(|(_, time)| time).sum::<f64>() / of_sets.iter().sum::<f64>();
        for ((windows, time), expected) in taken.iter().zip(of_sets) {
            let factor = time / expected / mean;
            let tiles: Vec<usize> =
                windows.iter().flat_map(|window| self.tiles_of(*window)).map(|(at, _)| at).collect();
            tiles
                .into_iter()
                .filter(|_| factor.is_finite() && factor > 0.0)
                .for_each(|at| self.tiles[at].factor *= factor);
        }
    }

    /// Takes over what others have learned of an image of the same size.
    pub fn remember(&mut self, other: &Self) {
        for (own, other) in self.tiles.iter_mut().zip(&other.tiles).filter(|_| self.size == other.size) {
            own.factor = other.factor;
        }
    }

    /// Returns the expected cost of the whole image.
    pub fn whole(&self) -> Load {
        self.of([0, 0, self.size[0], self.size[1]])
    }

    /// Cuts the image into one region for each of `ranks`, and `more` each to be handed out on demand, which have
    /// together the share `rest` of the work. Regions may be empty where there are more ranks than tiles.
    pub fn windows(&self, ranks: usize, more: usize, rest: f64) -> Vec<Window> {
        let leaves = self.leaves([0, 0, self.size[0], self.size[1]], ranks);
        if more == 0 {
            return leaves;
        }
        let parts: Vec<[Window; 2]> = leaves.iter().map(|leaf| self.parted(*leaf, 1.0 - rest)).collect();
        let own = parts.iter().map(|[first, _]| *first);
        let others = parts.iter().flat_map(|[_, rest]| self.leaves(*rest, more)).filter(|window| !is_empty(*window));
        own.chain(others).collect()
    }

    /// Cuts a region into `count` of about the same work.
    fn leaves(&self, window: Window, count: usize) -> Vec<Window> {
        if count <= 1 {
            return vec![window];
        }
        let [low, high] = self.parted(window, (count / 2) as f64 / count as f64);
        [self.leaves(low, count / 2), self.leaves(high, count - count / 2)].concat()
    }

    /// Cuts a region in two, of which the first has this share of the work, as far as tiles allow.
    fn parted(&self, window: Window, share: f64) -> [Window; 2] {
        let [x0, y0, x1, y1] = window;
        let [wide, high] = [(x1 - x0).div_ceil(TILE), (y1 - y0).div_ceil(TILE)];
        let by_rows = high >= 2 * ROWS || high >= wide;
        let (first, last) = if by_rows { (y0, y1) } else { (x0, x1) };
        let strip = |from: u32, to: u32| if by_rows { [x0, from, x1, to] } else { [from, y0, to, y1] };
        let wanted = share * self.of(window).work;
        let (mut edge, mut before) = (first, 0.0);
        while edge < last {
            let next = (edge + TILE).min(last);
            let work = self.of(strip(edge, next)).work;
            // The strip in which the share ends goes to whom most of it belongs.
            if before + 0.5 * work > wanted {
                break;
            }
            (edge, before) = (next, before + work);
        }
        [strip(first, edge), strip(edge, last)]
    }
}

/// The part of a disc's area that shows: the cosine between its normal and the line of sight.
fn slant(camera: &Camera, position: DVec3, normal: DVec3) -> f64 {
    let sight = match camera.projection {
        Projection::Perspective { .. } => (position - camera.eye).normalize_or_zero(),
        Projection::Orthographic { .. } => camera.forward,
    };
    sight.dot(normal.normalize_or_zero()).abs()
}

/// True for a region without pixels.
pub fn is_empty([x0, y0, x1, y1]: Window) -> bool {
    x0 >= x1 || y0 >= y1
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Costs of an image, by a function of tile column and row.
    fn costs(size: [u32; 2], fragments: impl Fn(u32, u32) -> f64) -> Costs {
        let mut costs = Costs::blank(size);
        for (tile, at) in costs.tiles.iter_mut().zip(0..) {
            tile.fragments = fragments(at % costs.columns, at / costs.columns);
        }
        costs
    }

    #[test]
    fn windows_cover_every_pixel_once_and_cut_no_tile() {
        for (size, ranks, more) in [
            ([70, 50], 1, 0),
            ([70, 50], 3, 0),
            ([70, 50], 64, 0),
            ([200, 130], 4, 3),
            ([16, 16], 5, 2),
            ([1, 300], 7, 1),
        ] {
            let costs = costs(size, |column, row| f64::from(1000 * ((column * 7 + row * 3) % 5)));
            let windows = costs.windows(ranks, more, 0.3);
            assert!(windows.len() >= ranks, "each rank has its own");
            let mut seen = vec![0; (size[0] * size[1]) as usize];
            for [x0, y0, x1, y1] in windows.iter().copied().filter(|window| !is_empty(*window)) {
                assert!(x0 % TILE == 0 && y0 % TILE == 0 && (x1 % TILE == 0 || x1 == size[0]));
                assert!(y1 % TILE == 0 || y1 == size[1]);
                (y0..y1).for_each(|y| (x0..x1).for_each(|x| seen[(y * size[0] + x) as usize] += 1));
            }
            assert!(seen.iter().all(|times| *times == 1), "{size:?} {ranks} {more}");
        }
    }

    #[test]
    fn work_is_shared_evenly_wherever_it_is() {
        // All of it in a corner, and most in one row of tiles.
        let corner = costs([640, 640], |column, row| if column < 10 && row > 25 { 1e6 } else { 0.0 });
        let row = costs([640, 640], |_, row| if row == 20 { 1e6 } else { 1e4 });
        for (costs, most) in [(corner, 1.35), (row, 1.8)] {
            for ranks in [2, 3, 4, 8] {
                let work: Vec<f64> = costs.windows(ranks, 0, 0.0).iter().map(|window| costs.of(*window).work).collect();
                let mean = work.iter().sum::<f64>() / ranks as f64;
                assert!((mean * ranks as f64 - costs.whole().work).abs() < 1.0);
                if most < 1.5 || ranks == 2 {
                    assert!(work.iter().copied().fold(0.0, f64::max) <= most * mean, "{ranks}: {work:?}");
                }
            }
        }
    }

    #[test]
    fn regions_on_demand_have_their_share_of_the_work() {
        let costs = costs([640, 640], |_, _| 1e5);
        let windows = costs.windows(4, 2, 0.25);
        let rest: f64 = windows[4..].iter().map(|window| costs.of(*window).work).sum();
        assert!((0.15..0.35).contains(&(rest / costs.whole().work)), "{}", rest / costs.whole().work);
    }

    #[test]
    fn regions_that_took_longer_than_expected_become_smaller() {
        let mut costs = costs([640, 640], |_, _| 1e5);
        let halves = costs.windows(2, 0, 0.0);
        assert_eq!(halves[0][3], 320);
        // The upper half takes three times as long: in all as much as the lower half and two thirds of a half more.
        costs.learn(&[(&halves[..1], 3.0), (&halves[1..], 1.0)]);
        let cut = costs.windows(2, 0, 0.0);
        assert_eq!(cut[0][3], 208, "two thirds of the upper half, to a whole tile");
        let mut other = self::costs([640, 640], |_, _| 1e5);
        other.remember(&costs);
        assert_eq!(other.windows(2, 0, 0.0), cut);
    }

    #[test]
    fn discs_count_where_they_are() {
        let projection = Projection::Orthographic { height: 64.0 };
        let eye = DVec3::Z * 10.0;
        let camera = Camera::look_at(eye, DVec3::ZERO, DVec3::Y, projection, 1.0, 100.0).expect("a camera");
        let mut costs = costs([64, 64], |_, _| 0.0);
        // A pixel is a unit. The second is cut by the image's edge, the third lies outside, the last behind the camera.
        for (x, y, z, radius) in
            [(-20.0, 20.0, 0.0, 2.0), (32.0, 0.0, 0.0, 16.0), (60.0, 0.0, 0.0, 2.0), (0.0, 0.0, 200.0, 2.0)]
        {
            costs.add(&camera, DVec3::new(x, y, z), (radius, 1.0), 10.0);
        }
        let first = costs.of([0, 0, 16, 16]);
        assert_eq!((first.points, first.fragments.round()), (10.0, (40.0 * std::f64::consts::PI).round()));
        let all = costs.whole();
        let half = 0.5 * 10.0 * std::f64::consts::PI * 256.0;
        assert!(
            (all.fragments - first.fragments) < 1.4 * half && (all.fragments - first.fragments) > 0.5 * half,
            "{all:?}"
        );
    }
}
