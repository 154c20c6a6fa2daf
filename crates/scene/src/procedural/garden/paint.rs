//! The appearance of unlit surfaces.

use glam::DVec3;

use super::super::builder::Rgb;
use super::super::random::{Random, hash, noise};
use pellucid_core::color::decode_srgb_f64;

/// A color, its pattern and how much it varies from point to point.
#[derive(Clone, Copy)]
pub(super) struct Paint {
    base: DVec3,
    pattern: Pattern,
    grain: f64,
}

/// The variation of the color over the surface; lengths in meters.
#[derive(Clone, Copy)]
enum Pattern {
    Plain,
    /// Boards of this width side by side along t, each of its own brightness, with dark joints.
    Boards(f64),
    /// Roof tiles in rows along t.
    Tiles,
    Bricks,
    /// Stripes of this width along s in a second color.
    Stripes(f64, DVec3),
    /// Backs of books of many colors along s.
    Books,
    /// Leaves: darker inside, lighter on top.
    Leaves,
}

impl Paint {
    pub(super) fn plain(rgb: Rgb) -> Self {
        Self { base: linear(rgb), pattern: Pattern::Plain, grain: 0.10 }
    }

    pub(super) fn boards(rgb: Rgb, width: f64) -> Self {
        Self { base: linear(rgb), pattern: Pattern::Boards(width), grain: 0.12 }
    }

    pub(super) fn tiles(rgb: Rgb) -> Self {
        Self { base: linear(rgb), pattern: Pattern::Tiles, grain: 0.12 }
    }

    pub(super) fn bricks(rgb: Rgb) -> Self {
        Self { base: linear(rgb), pattern: Pattern::Bricks, grain: 0.15 }
    }

    pub(super) fn stripes(rgb: Rgb, other: Rgb, width: f64) -> Self {
        Self { base: linear(rgb), pattern: Pattern::Stripes(width, linear(other)), grain: 0.06 }
    }

    pub(super) fn books() -> Self {
        Self { base: DVec3::ONE, pattern: Pattern::Books, grain: 0.10 }
    }

    pub(super) fn leaves(rgb: Rgb) -> Self {
        Self { base: linear(rgb), pattern: Pattern::Leaves, grain: 0.35 }
    }

    /// Returns the linear albedo at (s, t) meters along the surface and at `position`; `depth` is that inside foliage.
    pub(super) fn albedo(&self, s: f64, t: f64, position: DVec3, depth: f64, random: &mut Random) -> DVec3 {
        let patina = 1.0 + 0.16 * (noise(position * 1.7) - 0.5) + 0.14 * (noise(position * 7.0) - 0.5);
        let grain = 1.0 + self.grain * (random.unit() + random.unit() - 1.0);
        self.pattern(s, t, depth) * patina * grain
    }

    fn pattern(&self, s: f64, t: f64, depth: f64) -> DVec3 {
        match self.pattern {
            Pattern::Plain => self.base,
            Pattern::Boards(width) => {
                let board = (t / width).floor();
                let joint = if t / width - board < 0.12 { 0.55 } else { 1.0 };
                self.base * joint * (0.82 + 0.36 * hash(board as i64, 11, 0))
            }
            Pattern::Tiles => {
                let row = (t / 0.32).floor();
                let column = (s / 0.24 + 0.5 * (row % 2.0)).floor();
                let lip = if t / 0.32 - row < 0.22 { 0.62 } else { 1.0 };
                self.base * lip * (0.72 + 0.5 * hash(row as i64, column as i64, 3))
            }
            Pattern::Bricks => {
                let row = (t / 0.09).floor();
                let x = s / 0.25 + 0.5 * (row % 2.0);
                let mortar = t / 0.09 - row < 0.14 || x - x.floor() < 0.07;
                if mortar {
                    linear([176, 168, 158])
                } else {
                    self.base * (0.7 + 0.55 * hash(row as i64, x.floor() as i64, 7))
                }
            }
            Pattern::Stripes(width, other) => {
                if (s / width).floor() % 2.0 == 0.0 {
                    self.base
                } else {
                    other
                }
            }
            Pattern::Books => {
                let book = (s / 0.045).floor() as i64;
                let rgb = BOOKS[(hash(book, (t * 3.0) as i64, 5) * BOOKS.len() as f64) as usize % BOOKS.len()];
                linear(rgb) * (0.8 + 0.4 * hash(book, 17, 2))
            }
            Pattern::Leaves => self.base * (1.0 - 0.55 * depth),
        }
    }
}

const BOOKS: [Rgb; 6] = [[168, 52, 44], [44, 84, 132], [218, 178, 84], [62, 108, 78], [222, 212, 192], [112, 72, 118]];

pub(super) fn linear(rgb: Rgb) -> DVec3 {
    DVec3::from_array(rgb.map(|byte| decode_srgb_f64(f64::from(byte) / 255.0)))
}
