//! A scalar field between the numbers of a grid.

use glam::DVec3;
use rayon::prelude::*;

use pellucid_io::volume::Volume;

/// The trilinear interpolant of a volume. Lengths are those of cells' sides, the first number is at the origin.
pub(super) struct Field<'a> {
    volume: &'a Volume,
    /// The finite ones, ascending.
    sorted: Vec<f32>,
    /// `true` if values grow toward the outside: on the volume's faces they are greater than elsewhere, on average.
    pub rises: bool,
}

impl<'a> Field<'a> {
    pub fn new(volume: &'a Volume) -> Self {
        let mut sorted: Vec<f32> = volume.values.iter().copied().filter(|value| value.is_finite()).collect();
        sorted.par_sort_unstable_by(f32::total_cmp);
        let mut field = Self { volume, sorted, rises: false };
        field.rises = field.mean(true) > field.mean(false);
        field
    }

    /// The mean of all finite values or of those on the volume's faces.
    fn mean(&self, on_faces: bool) -> f64 {
        let [width, height, depth] = self.volume.dims;
        let is_end = |at: usize, count: usize| at == 0 || at + 1 == count;
        let is_face = |i: usize| {
            is_end(i % width, width) || is_end(i / width % height, height) || is_end(i / (width * height), depth)
        };
        let finite = self.volume.values.iter().enumerate().filter(|(_, value)| value.is_finite());
        let (mut sum, mut count) = (0.0, 0.0);
        for (_, value) in finite.filter(|(i, _)| !on_faces || is_face(*i)) {
            sum += f64::from(*value);
            count += 1.0;
        }
        if count > 0.0 { sum / count } else { 0.0 }
    }

    /// Returns the least and greatest value; `None` if no value is finite.
    pub fn extremes(&self) -> Option<[f64; 2]> {
        Some([f64::from(*self.sorted.first()?), f64::from(*self.sorted.last()?)])
    }

    /// Returns the difference between the two.
    pub fn range(&self) -> f64 {
        self.extremes().map_or(0.0, |[least, greatest]| greatest - least)
    }

    /// Returns the isovalue whose surface encloses this share of the volume's numbers. It lies between two of its
    /// values, so that none of them is on the surface. `None` if all of them are equal.
    pub fn enclosing(&self, share: f64) -> Option<f64> {
        let count = self.sorted.len();
        let inside = (share * count as f64).round().clamp(1.0, count.max(2) as f64 - 1.0) as usize;
        let last_inside = if self.rises { inside - 1 } else { count.checked_sub(inside)? };
        let value = self.sorted.get(last_inside)?;
        // Equal values are inside, too, unless all values are equal.
        let [below, up_to] = [self.sorted.partition_point(|v| v < value), self.sorted.partition_point(|v| v <= value)];
        let up_to_it = if self.rises { up_to < count } else { below == 0 };
        let edge = if up_to_it { up_to } else { below };
        let [lower, upper] = [self.sorted.get(edge.checked_sub(1)?)?, self.sorted.get(edge)?];
        Some(0.5 * (f64::from(*lower) + f64::from(*upper)))
    }

    /// Returns cells along x, y and z: one less than numbers.
    pub fn cells(&self) -> [usize; 3] {
        self.volume.dims.map(|count| count - 1)
    }

    /// Returns `true` if a position lies within the grid.
    pub fn holds(&self, place: DVec3) -> bool {
        let end = DVec3::from_array(self.cells().map(|count| count as f64));
        place.cmpge(DVec3::ZERO).all() && place.cmple(end).all()
    }

    fn number(&self, [x, y, z]: [usize; 3]) -> f64 {
        let [width, height, _] = self.volume.dims;
        f64::from(self.volume.values[(z * height + y) * width + x])
    }

    /// Returns the values at the corners of a cell; corner numbers have a bit for x, y and z.
    pub fn corners(&self, [x, y, z]: [usize; 3]) -> [f64; 8] {
        std::array::from_fn(|c| self.number([x + (c & 1), y + (c >> 1 & 1), z + (c >> 2)]))
    }

    /// The cell of a place in the volume and the place in it.
    fn cell(&self, place: DVec3) -> ([usize; 3], DVec3) {
        let cells = self.cells();
        let coordinates = place.to_array();
        let cell = std::array::from_fn(|axis| (coordinates[axis].max(0.0) as usize).min(cells[axis] - 1));
        (cell, place - DVec3::from_array(cell.map(|v| v as f64)))
    }

    /// Returns the value and gradient at a place in the volume.
    pub fn at(&self, place: DVec3) -> (f64, DVec3) {
        let (cell, t) = self.cell(place);
        let v = self.corners(cell);
        let mix = |a: f64, b: f64, t: f64| a + (b - a) * t;
        // Along x, then y, then z.
        let x = [mix(v[0], v[1], t.x), mix(v[2], v[3], t.x), mix(v[4], v[5], t.x), mix(v[6], v[7], t.x)];
        let y = [mix(x[0], x[1], t.y), mix(x[2], x[3], t.y)];
        let dx = [v[1] - v[0], v[3] - v[2], v[5] - v[4], v[7] - v[6]];
        let gradient = DVec3::new(
            mix(mix(dx[0], dx[1], t.y), mix(dx[2], dx[3], t.y), t.z),
            mix(x[1] - x[0], x[3] - x[2], t.z),
            y[1] - y[0],
        );
        (mix(y[0], y[1], t.z), gradient)
    }

    /// Returns the unit normal at a place, outward; zero where values don't change. From central differences at the
    /// numbers, between which it is interpolated: those of the interpolant jump from cell to cell.
    pub fn normal(&self, place: DVec3) -> DVec3 {
        let ([x, y, z], t) = self.cell(place);
        let weight = |bit: usize, t: f64| if bit == 1 { t } else { 1.0 - t };
        let gradient: DVec3 = (0..8)
            .map(|c| {
                let bits = [c & 1, c >> 1 & 1, c >> 2];
                let weights = weight(bits[0], t.x) * weight(bits[1], t.y) * weight(bits[2], t.z);
                weights * self.difference([x + bits[0], y + bits[1], z + bits[2]])
            })
            .sum();
        let outward = if self.rises { gradient } else { -gradient };
        outward.try_normalize().unwrap_or(DVec3::ZERO)
    }

    /// Central differences at a number, one-sided at the volume's faces.
    fn difference(&self, at: [usize; 3]) -> DVec3 {
        DVec3::from_array(std::array::from_fn(|axis| {
            let (mut before, mut after) = (at, at);
            before[axis] = at[axis].saturating_sub(1);
            after[axis] = (at[axis] + 1).min(self.volume.dims[axis] - 1);
            (self.number(after) - self.number(before)) / (after[axis] - before[axis]) as f64
        }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_and_gradients_between_numbers() {
        // f = 1 + 2x − 3y + z + xyz is trilinear.
        let f = |x: f64, y: f64, z: f64| 1.0 + 2.0 * x - 3.0 * y + z + x * y * z;
        let dims = [3, 4, 2];
        let numbers = (0..24).map(|i| f((i % 3) as f64, (i / 3 % 4) as f64, (i / 12) as f64) as f32);
        let volume = Volume { dims, values: numbers.collect() };
        let field = Field::new(&volume);
        for place in [DVec3::new(0.25, 0.5, 0.75), DVec3::new(1.5, 2.75, 0.125), DVec3::new(2.0, 3.0, 1.0)] {
            let (value, gradient) = field.at(place);
            let DVec3 { x, y, z } = place;
            assert!((value - f(x, y, z)).abs() < 1e-12, "{place}");
            let expected = DVec3::new(2.0 + y * z, -3.0 + x * z, 1.0 + x * y);
            assert!((gradient - expected).length() < 1e-12, "{place}");
            assert!(field.holds(place) && !field.holds(place + DVec3::splat(2.0)));
        }
    }

    #[test]
    fn a_share_of_the_volume_is_enclosed() {
        // 27 numbers: one of 9, eight of 4, the others 1.
        let mut values = vec![1f32; 27];
        values[..8].fill(4.0);
        values[13] = 9.0;
        let volume = Volume { dims: [3; 3], values };
        let field = Field::new(&volume);
        assert!(!field.rises && field.range() == 8.0);
        assert_eq!(
            (field.enclosing(1.0 / 27.0), field.enclosing(0.2), field.enclosing(0.9)),
            (Some(6.5), Some(2.5), Some(2.5))
        );
        let negative = Volume { values: volume.values.iter().map(|v| -v).collect(), ..volume };
        let field = Field::new(&negative);
        assert!(field.rises);
        assert_eq!((field.enclosing(1.0 / 27.0), field.enclosing(0.2)), (Some(-6.5), Some(-2.5)));
        let constant = Volume { dims: [2; 3], values: vec![3.0; 8] };
        assert_eq!(
            (Field::new(&constant).enclosing(0.5), Field::new(&constant).normal(DVec3::ONE)),
            (None, DVec3::ZERO)
        );
        let nothing = Volume { dims: [2; 3], values: vec![f32::NAN; 8] };
        assert_eq!((Field::new(&nothing).enclosing(0.5), Field::new(&nothing).extremes()), (None, None));
    }
}
