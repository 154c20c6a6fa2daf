//! The surface that a picture is put on: positions, normals and numbers of copies of its pixels.

use glam::{DVec3, Vec3};

use super::Photo;
use pellucid_core::random::{key, threefry2x32};

/// Key of the random numbers. It doesn't follow `--seed`: a picture is the same cloud in every image of it.
const SEED: u64 = 0x7068_6f74_6f00;

/// A plane, or a plane with a height at every pixel.
pub struct Surface {
    size: [u32; 2],
    origin: DVec3,
    right: DVec3,
    up: DVec3,
    /// Unit normal of the plane, toward those who see the picture the right way round.
    normal: DVec3,
    map: Option<HeightMap>,
}

/// Values of a height map, from which heights are interpolated as they are asked for.
struct HeightMap {
    /// Values in [0, 1], row by row from the top.
    values: Vec<f32>,
    size: [u32; 2],
    /// Height of 1 over 0, world units.
    scale: f64,
}

impl Surface {
    /// Returns the plane itself, for a picture of `size` pixels.
    pub fn flat(size: [u32; 2], photo: &Photo) -> Self {
        let [width, height] = size.map(f64::from);
        let [right, up] = photo.edges.unwrap_or([DVec3::X, DVec3::Y * (height / width)]);
        let origin = photo.origin.unwrap_or(-0.5 * (right + up));
        let normal = right.cross(up).normalize_or_zero();
        Self { size, origin, right, up, normal, map: None }
    }

    /// Returns the plane displaced by a map of `map_size` values in [0, 1], row by row; 1 displaces by `scale`.
    pub fn new(size: [u32; 2], photo: &Photo, values: Vec<f32>, map_size: [u32; 2], scale: f64) -> Self {
        Self { map: Some(HeightMap { values, size: map_size, scale }), ..Self::flat(size, photo) }
    }

    fn height(&self, x: u32, y: u32) -> f64 {
        let height = |map: &HeightMap| map.scale * sample(&map.values, map.size, [x, y], self.size);
        self.map.as_ref().map_or(0.0, height)
    }

    /// Returns the world position of a pixel's center; column from the left, row from the top.
    pub fn position(&self, x: u32, y: u32) -> DVec3 {
        let [width, height] = self.size.map(f64::from);
        let (u, v) = ((f64::from(x) + 0.5) / width, 1.0 - (f64::from(y) + 0.5) / height);
        self.origin + u * self.right + v * self.up + self.height(x, y) * self.normal
    }

    /// Normal of the surface at a pixel, longer than that of the plane by 1 / cos φ: the cross product of its tangents,
    /// with slopes by central differences, at the rims by one-sided ones.
    fn scaled_normal(&self, x: u32, y: u32) -> DVec3 {
        if self.map.is_none() {
            return self.normal;
        }
        let slope = |count: u32, at: u32, height: &dyn Fn(u32) -> f64| {
            let (before, after) = (at.saturating_sub(1), (at + 1).min(count - 1));
            let steps = f64::from(after - before);
            if steps == 0.0 { 0.0 } else { (height(after) - height(before)) * f64::from(count) / steps }
        };
        let [width, height] = self.size;
        let along_right = slope(width, x, &|x| self.height(x, y));
        let along_up = -slope(height, y, &|y| self.height(x, y));
        let tangents = [self.right + along_right * self.normal, self.up + along_up * self.normal];
        tangents[0].cross(tangents[1]) / self.right.cross(self.up).length()
    }

    /// Returns the unit normal at a pixel.
    pub fn normal(&self, x: u32, y: u32) -> Vec3 {
        self.scaled_normal(x, y).normalize_or_zero().as_vec3()
    }

    /// 1 / cos φ, φ between the plane and the surface at a pixel.
    fn stretch(&self, x: u32, y: u32) -> f64 {
        self.scaled_normal(x, y).length().max(1.0)
    }

    /// Returns the mean number of points over all fractions that are left to chance, if no pixel is transparent.
    pub fn expected_points(&self) -> f64 {
        let [width, height] = self.size;
        if self.map.is_none() {
            return f64::from(width) * f64::from(height);
        }
        let row = |y| (0..width).map(|x| self.stretch(x, y)).sum::<f64>();
        (0..height).map(row).sum()
    }

    /// Returns the number of points for a pixel: 1 / cos φ, rounded at random, the same in each run.
    pub fn copies(&self, x: u32, y: u32) -> u64 {
        let stretch = self.stretch(x, y);
        let (whole, fraction) = (stretch.floor(), stretch.fract());
        let [word, _] = threefry2x32([x, y], key(SEED));
        whole as u64 + u64::from(f64::from(word) < fraction * 2f64.powi(32))
    }
}

/// A map's value at the center of a pixel of a picture of `size` pixels: bilinear; exact where the sizes are equal.
fn sample(map: &[f32], map_size: [u32; 2], pixel: [u32; 2], size: [u32; 2]) -> f64 {
    let place = |at: u32, count: u32, of: u32| {
        let place = ((f64::from(at) + 0.5) * f64::from(of) / f64::from(count) - 0.5).clamp(0.0, f64::from(of - 1));
        (place.floor() as usize, place.fract())
    };
    let (column, right) = place(pixel[0], size[0], map_size[0]);
    let (row, down) = place(pixel[1], size[1], map_size[1]);
    let [width, height] = map_size.map(|side| side as usize);
    let at = |x: usize, y: usize| {
        let index = y.min(height - 1) * width + x.min(width - 1);
        map.get(index).copied().map_or(0.0, f64::from)
    };
    let in_row = |y| at(column, y) * (1.0 - right) + at(column + 1, y) * right;
    in_row(row) * (1.0 - down) + in_row(row + 1) * down
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn maps_of_another_size_are_interpolated() {
        let map = [0.0, 1.0, 0.5, 0.25];
        let at = |x, y, size| sample(&map, [2, 2], [x, y], size);
        assert_eq!([at(0, 0, [2, 2]), at(1, 0, [2, 2]), at(0, 1, [2, 2]), at(1, 1, [2, 2])], [0.0, 1.0, 0.5, 0.25]);
        // A single pixel lies in the middle of the four; rims are extended.
        assert_eq!(at(0, 0, [1, 1]), 0.4375);
        assert_eq!([0, 1, 2, 3].map(|x| at(x, 0, [4, 4])), [0.0, 0.25, 0.75, 1.0]);
        assert_eq!(sample(&[0.75], [1, 1], [7, 3], [9, 9]), 0.75);
    }

    #[test]
    fn a_sheared_plane_has_the_same_stretch_for_the_same_slope() {
        let edges = Some([DVec3::new(2.0, 0.0, 0.0), DVec3::new(1.0, 1.0, 0.0)]);
        let map: Vec<f32> = (0..16).map(|i| (i % 4) as f32 / 4.0).collect();
        let photo = Photo { edges, ..Photo::default() };
        let surface = Surface::new([4, 4], &photo, map, [4, 4], 2.0);
        // Along x at constant y the height grows by 2 over a length of 2, and along y at constant u by nothing: on the
        // way up the x grows too, so that the gradient is (1, −1) and 1 / cos φ = √3.
        for (x, y) in [(0, 0), (2, 1), (3, 3)] {
            assert!((surface.stretch(x, y) - 3f64.sqrt()).abs() < 1e-12);
            let normal = DVec3::new(-1.0, 1.0, 1.0) / 3f64.sqrt();
            assert!(surface.normal(x, y).as_dvec3().distance(normal) < 1e-7, "{}", surface.normal(x, y));
        }
    }
}
