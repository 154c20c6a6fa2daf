//! Light baked into the colors: sun with soft shadows, sky, and darkening in corners.

use glam::{DVec2, DVec3};

use super::scan::Sample;

/// Direction toward the sun.
fn sun() -> DVec3 {
    DVec3::new(-0.62, -0.42, 0.66).normalize()
}

const SUN_COLOR: DVec3 = DVec3::new(0.80, 0.74, 0.64);
const SKY_COLOR: DVec3 = DVec3::new(0.50, 0.54, 0.60);

/// Half the side of the square and of the box that the maps cover, and the box's height above −1 m.
const REACH: f64 = 15.0;
const HEIGHT: f64 = 10.0;

/// The height of the topmost points above the plane through the origin that faces the sun, cell by cell.
pub(super) struct ShadowMap {
    cell: f64,
    side: usize,
    heights: Vec<f32>,
}

impl ShadowMap {
    /// Returns an empty map with cells as wide as `spacing` between points asks for.
    pub(super) fn new(spacing: f64) -> Self {
        let cell = (1.6 * spacing).clamp(0.05, REACH);
        let side = (2.0 * REACH / cell).ceil() as usize;
        Self { cell, side, heights: vec![f32::NEG_INFINITY; side * side] }
    }

    pub(super) fn cast<'a>(&mut self, samples: impl IntoIterator<Item = &'a Sample>) {
        for sample in samples {
            let (at, height) = self.place(sample.position);
            if let Some(top) = self.index(at).and_then(|i| self.heights.get_mut(i)) {
                *top = top.max(height as f32);
            }
        }
    }

    /// Share of the sunlight that reaches a point, from the 3 × 3 cells around it; points less than `bias` above it
    /// don't occlude.
    fn lit(&self, position: DVec3, bias: f64) -> f64 {
        let (at, height) = self.place(position);
        let lit = |i: i32| {
            let near = at + DVec2::new(f64::from(i % 3) - 1.0, f64::from(i / 3) - 1.0);
            let top = self.index(near).and_then(|i| self.heights.get(i)).copied().unwrap_or(f32::NEG_INFINITY);
            1.0 - ((f64::from(top) - height - bias) / 0.15).clamp(0.0, 1.0)
        };
        (0..9).map(lit).sum::<f64>() / 9.0
    }

    /// Position in cells, and height toward the sun.
    fn place(&self, p: DVec3) -> (DVec2, f64) {
        let sun = sun();
        let right = DVec3::Z.cross(sun).normalize();
        let at = DVec2::new(p.dot(right), p.dot(sun.cross(right)));
        ((at + REACH) / self.cell, p.dot(sun))
    }

    fn index(&self, at: DVec2) -> Option<usize> {
        let inside = at.min_element() >= 0.0 && at.max_element() < self.side as f64;
        inside.then(|| at.y as usize * self.side + at.x as usize)
    }
}

/// Cells of space that hold points.
pub(super) struct Occupancy {
    cell: f64,
    side: [usize; 3],
    filled: Vec<bool>,
}

impl Occupancy {
    pub(super) fn new(spacing: f64) -> Self {
        let cell = (1.6 * spacing).clamp(0.1, REACH);
        let side = [2.0 * REACH, 2.0 * REACH, HEIGHT].map(|length| (length / cell).ceil() as usize);
        Self { cell, side, filled: vec![false; side.iter().product()] }
    }

    pub(super) fn fill<'a>(&mut self, samples: impl IntoIterator<Item = &'a Sample>) {
        for sample in samples {
            if let Some(cell) = self.index(sample.position).and_then(|i| self.filled.get_mut(i)) {
                *cell = true;
            }
        }
    }

    /// Share of the directions above the surface that meet nothing within five cells.
    fn open(&self, position: DVec3, normal: DVec3) -> f64 {
        let start = position + 1.5 * self.cell * normal;
        let (mut open, mut all) = (0.0, 0.0);
        for i in 0..27 {
            let d = DVec3::new(f64::from(i % 3) - 1.0, f64::from(i / 3 % 3) - 1.0, f64::from(i / 9) - 1.0);
            let weight = d.normalize_or_zero().dot(normal);
            if weight > 0.25 {
                let hit = (1..=5).position(|k| {
                    let at = start + f64::from(k) * self.cell * d;
                    self.index(at).and_then(|i| self.filled.get(i)).copied().unwrap_or(false)
                });
                // A near hit darkens more than a far one.
                open += weight * hit.map_or(1.0, |k| 0.2 * k as f64);
                all += weight;
            }
        }
        if all > 0.0 { open / all } else { 1.0 }
    }

    fn index(&self, p: DVec3) -> Option<usize> {
        let at = (p + DVec3::new(REACH, REACH, 1.0)) / self.cell;
        let [x, y, z] = self.side;
        let inside = at.min_element() >= 0.0 && at.x < x as f64 && at.y < y as f64 && at.z < z as f64;
        inside.then(|| (at.z as usize * y + at.y as usize) * x + at.x as usize)
    }
}

/// Returns the linear color of a sample in the light. Foliage scatters: its normals count half, and shade sets in
/// slowly.
pub(super) fn shade(sample: &Sample, shadows: &ShadowMap, occupancy: &Occupancy, foliage: bool) -> DVec3 {
    let n = sample.normal;
    let facing = n.dot(sun());
    let (direct, open) =
        if foliage { (0.35 + 0.65 * facing.abs(), 1.0) } else { (facing.max(0.0), occupancy.open(sample.position, n)) };
    let lit = shadows.lit(sample.position, if foliage { 0.45 } else { 0.12 });
    // Shadows keep an eighth of the sun, so that nothing sinks into black.
    let sun_light = SUN_COLOR * direct * (0.12 + 0.88 * lit);
    let sky_light = SKY_COLOR * (0.72 + 0.28 * n.z) * (0.35 + 0.65 * open);
    sample.albedo * (sun_light + sky_light)
}
