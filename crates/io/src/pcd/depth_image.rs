//! Tells images of depth cameras from other organized clouds: their columns run along +X, their rows along +Y, and +Z
//! is the direction of view, so that −Y is up (the optical frame of the Robot Operating System's REP 103, and of PCL's
//! grabbers).

use crate::grid::Line;

/// Stride of the points that the sums count.
const STEP: u64 = 7;

/// Fewest points for which a decision is made.
const FEWEST: f64 = 100.0;

/// Largest distance of points from where a pinhole camera has their pixels, root mean square, in pixels.
const NEAR: f64 = 4.0;

/// Fits x/z to a point's column and y/z to its row.
pub(super) struct DepthImage {
    width: u64,
    index: u64,
    /// False once a point lay behind the camera.
    possible: bool,
    columns: Line,
    rows: Line,
}

impl DepthImage {
    /// Starts the sums of an image with this many columns.
    pub fn new(width: u64) -> Self {
        Self { width, index: 0, possible: width > 1, columns: Line::default(), rows: Line::default() }
    }

    /// The next point, finite or not.
    pub fn add(&mut self, [x, y, z]: [f64; 3]) {
        let index = self.index;
        self.index += 1;
        if !self.possible || !index.is_multiple_of(STEP) || ![x, y, z].iter().all(|x| x.is_finite()) {
            return;
        }
        self.possible = z > 0.0;
        self.columns.add((index % self.width) as f64, x / z);
        self.rows.add((index / self.width) as f64, y / z);
    }

    /// Returns `true` if the points lie where a depth camera sees them.
    pub fn is_one(&self) -> bool {
        self.possible && fits(&self.columns) && fits(&self.rows)
    }
}

/// Returns `true` if y rises with x and the residue is small.
fn fits(line: &Line) -> bool {
    let [sxx, sxy, syy] = line.squares();
    let slope = sxy / sxx;
    let residue = ((syy - slope * sxy) / line.count()).max(0.0).sqrt();
    line.count() >= FEWEST && sxx > 0.0 && slope > 0.0 && residue <= NEAR * slope
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An image of 64 × 48 pixels with depths from a formula; `flip` turns it as cameras of graphics have it.
    fn image(flip: f64, forward: f64) -> DepthImage {
        let mut image = DepthImage::new(64);
        for row in 0..48 {
            for column in 0..64 {
                let (u, v) = (f64::from(column) - 31.5, f64::from(row) - 23.5);
                let z = if (column + row) % 5 == 0 { f64::NAN } else { forward * (2.0 + (u * 0.1).sin()) };
                image.add([z * u / 50.0, flip * z * v / 50.0, z]);
            }
        }
        image
    }

    #[test]
    fn depth_images_are_told_from_other_grids() {
        assert!(image(1.0, 1.0).is_one());
        assert!(!image(-1.0, 1.0).is_one(), "Y up");
        assert!(!image(1.0, -1.0).is_one(), "looks along -Z");
        let mut terrain = DepthImage::new(64);
        (0..64 * 48).for_each(|i| terrain.add([f64::from(i % 64), f64::from(i / 64), 5.0 + f64::from(i * 37 % 19)]));
        assert!(!terrain.is_one(), "a grid seen from above");
        assert!(!DepthImage::new(1).is_one() && !DepthImage::new(64).is_one());
    }
}
