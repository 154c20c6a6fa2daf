//! Tells how the cells of an organized cloud lie around its sensor.

use glam::DVec3;
use pellucid_core::cloud::sensor::Sensor;

/// Share of the variance of elevations that rows explain in the grid of a laser scanner.
const RISES: f64 = 0.8;

/// Sums of a line's least squares.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Line {
    count: f64,
    x: f64,
    y: f64,
    xx: f64,
    xy: f64,
    yy: f64,
}

impl Line {
    pub fn add(&mut self, x: f64, y: f64) {
        self.count += 1.0;
        self.x += x;
        self.y += y;
        self.xx += x * x;
        self.xy += x * y;
        self.yy += y * y;
    }

    pub fn count(&self) -> f64 {
        self.count
    }

    /// Returns the sums of squares about the means, of x, of x and y, and of y.
    pub fn squares(&self) -> [f64; 3] {
        let Self { count, x, y, xx, xy, yy } = *self;
        [xx - x * x / count, xy - x * y / count, yy - y * y / count]
    }
}

/// Fits a point's elevation above the sensor's XY plane to its row.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Elevations(Line);

impl Elevations {
    /// Adds a point of a row, in the sensor's coordinates. Points that are not finite, or in the sensor, don't count.
    pub fn add(&mut self, row: u64, point: DVec3) {
        let elevation = (point.z / point.length()).asin();
        if elevation.is_finite() {
            self.0.add(row as f64, elevation);
        }
    }

    /// Returns `true` if rows rise, or fall, along Z, as those of a laser scanner.
    pub fn follow_rows(&self) -> bool {
        let [rows, both, elevations] = self.0.squares();
        rows > 0.0 && elevations > 0.0 && both * both >= RISES * rows * elevations
    }
}

/// Returns the sensor of all scans; `None` if they have several, or none.
pub(crate) fn the_only(sensors: &[Option<Sensor>]) -> Option<Sensor> {
    let [first, others @ ..] = sensors else { return None };
    first.filter(|_| others.iter().all(|other| other == first))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_of_a_laser_rise_along_z() {
        let of = |place: &dyn Fn(f64, f64) -> DVec3| {
            let mut elevations = Elevations::default();
            for i in 0..600_u64 {
                elevations.add(i % 20, place((i % 20) as f64, (i / 20) as f64));
            }
            elevations.follow_rows()
        };
        let wall = |row: f64, column: f64| DVec3::new(5.0, 0.3 * column - 4.5, 0.2 * row - 2.0);
        let ring =
            |row: f64, column: f64| DVec3::new(column.cos(), column.sin(), (0.02 * row - 0.3).tan()) * (5.0 + row);
        assert!(of(&wall) && of(&ring) && of(&|row, column| ring(19.0 - row, column)));
        assert!(!of(&|row, column| DVec3::new(row, column, 9.0 + (row * column).sin())), "terrain from below");
        assert!(!of(&|row, column| DVec3::new(5.0, row, column)), "rows run along y");
        assert!(!of(&|_, _| DVec3::NAN) && !of(&|_, _| DVec3::ZERO));
    }
}
