//! Points on an iso-surface: random, as many to one part of its area as to another of the same size.

use glam::DVec3;

use super::super::random::Random;
use super::field::Field;
use pellucid_core::parallel;

/// Six tetrahedra around a cell's diagonal fill it, and neighbors meet in the same triangles (Freudenthal). Corners are
/// numbers of three bits: x, y, z.
const TETRAHEDRA: [[usize; 4]; 6] =
    [[0, 1, 3, 7], [0, 1, 5, 7], [0, 2, 3, 7], [0, 2, 6, 7], [0, 4, 5, 7], [0, 4, 6, 7]];

/// Steps toward a value.
const NEWTON_STEPS: usize = 8;
/// Halvings of a distance of up to √3 cells: to the last bit.
const BISECTIONS: usize = 54;
/// Share of the range of values that counts as zero.
const RESIDUAL: f64 = 1e-9;

/// A piece of the surface where the field counts as linear in each tetrahedron.
#[derive(Debug, Clone, Copy)]
struct Triangle {
    corners: [DVec3; 3],
    /// A corner of the tetrahedron with at least the value.
    above: DVec3,
    /// A position with a smaller value.
    below: DVec3,
}

impl Triangle {
    fn area(&self) -> f64 {
        let [a, b, c] = self.corners;
        0.5 * (b - a).cross(c - a).length()
    }

    /// Uniform on it.
    fn point(&self, random: &mut Random) -> DVec3 {
        let [a, b, c] = self.corners;
        let (root, along) = (random.unit().sqrt(), random.unit());
        a + root * (1.0 - along) * (b - a) + root * along * (c - a)
    }
}

/// The surface on which a field has a value. Its area is that of triangles that marching through tetrahedra gives; its
/// points are on the trilinear interpolant.
pub(super) struct Isosurface<'a> {
    field: &'a Field<'a>,
    value: f64,
    /// Cells that the surface meets, with the area of it up to the end of each.
    cells: Vec<(usize, f64)>,
}

impl<'a> Isosurface<'a> {
    /// Returns all cells, a layer of them at a time on each core.
    pub fn new(field: &'a Field<'a>, value: f64) -> Self {
        let [width, height, depth] = field.cells();
        let of_layer = |z: usize| {
            let cell = move |at: usize| {
                let area: f64 = triangles(field, [at % width, at / width, z], value).iter().map(Triangle::area).sum();
                (area > 0.0).then_some((z * width * height + at, area))
            };
            (0..width * height).filter_map(cell).collect::<Vec<_>>()
        };
        let mut cells: Vec<(usize, f64)> = parallel::gather(depth, of_layer).concat();
        let mut area = 0.0;
        for (_, end) in &mut cells {
            area += *end;
            *end = area;
        }
        Self { field, value, cells }
    }

    /// Area of the surface, in squares of cells' sides.
    pub fn area(&self) -> f64 {
        self.cells.last().map_or(0.0, |(_, end)| *end)
    }

    /// Returns a random point of a surface with some area, in cells' sides from the first number of the grid.
    pub fn point(&self, random: &mut Random) -> DVec3 {
        let place = random.unit() * self.area();
        let at = self.cells.partition_point(|(_, end)| *end <= place).min(self.cells.len().saturating_sub(1));
        let Some((index, _)) = self.cells.get(at) else { return DVec3::ZERO };
        let mut left = place - at.checked_sub(1).map_or(0.0, |before| self.cells[before].1);
        let [width, height, _] = self.field.cells();
        let cell = [index % width, index / width % height, index / (width * height)];
        let triangles = triangles(self.field, cell, self.value);
        let chosen = triangles.iter().find(|triangle| {
            left -= triangle.area();
            left < 0.0
        });
        // The last triangle absorbs the rounding errors of the sum.
        match chosen.or(triangles.last()) {
            Some(triangle) => self.moved(triangle.point(random), triangle),
            None => DVec3::ZERO,
        }
    }

    /// The place on the trilinear interpolant nearest to one on a triangle: along the gradient (Newton); where that
    /// leads away, as it may where the gradient jumps from cell to cell, toward a corner on the other side of the
    /// surface.
    fn moved(&self, start: DVec3, triangle: &Triangle) -> DVec3 {
        let mut place = start;
        for _ in 0..NEWTON_STEPS {
            let (value, gradient) = self.field.at(place);
            let missing = self.value - value;
            if missing.abs() <= RESIDUAL * self.field.range() {
                return place;
            }
            place += gradient * (missing / gradient.length_squared());
            if !place.is_finite() || place.distance_squared(start) > 0.25 || !self.field.holds(place) {
                break;
            }
        }
        let is_above = |place: DVec3| self.field.at(place).0 >= self.value;
        let starts_above = is_above(start);
        let (mut near, mut far) = (start, if starts_above { triangle.below } else { triangle.above });
        for _ in 0..BISECTIONS {
            let middle = 0.5 * (near + far);
            *if is_above(middle) == starts_above { &mut near } else { &mut far } = middle;
        }
        near
    }
}

/// The surface in one cell. Without any where a number is not finite.
fn triangles(field: &Field<'_>, cell: [usize; 3], value: f64) -> Vec<Triangle> {
    let values = field.corners(cell);
    let mut triangles = Vec::new();
    let above = values.iter().filter(|corner| **corner >= value).count();
    if above == 0 || above == 8 || values.iter().any(|value| !value.is_finite()) {
        return triangles;
    }
    let origin = DVec3::from_array(cell.map(|v| v as f64));
    let corner = |c: usize| origin + DVec3::new((c & 1) as f64, (c >> 1 & 1) as f64, (c >> 2) as f64);
    for tetrahedron in TETRAHEDRA {
        let (high, low): (Vec<usize>, Vec<usize>) = tetrahedron.iter().partition(|c| values[**c] >= value);
        // The point of an edge between the sides where the field equals the value.
        let cut =
            |a: usize, b: usize| corner(a) + (corner(b) - corner(a)) * ((value - values[a]) / (values[b] - values[a]));
        let mut add = |corners: [DVec3; 3]| {
            triangles.push(Triangle { corners, above: corner(high[0]), below: corner(low[0]) });
        };
        match (high.as_slice(), low.as_slice()) {
            ([one], [a, b, c]) | ([a, b, c], [one]) => add([cut(*one, *a), cut(*one, *b), cut(*one, *c)]),
            ([a, b], [c, d]) => {
                let [first, last] = [cut(*a, *c), cut(*b, *d)];
                add([first, cut(*a, *d), last]);
                add([first, last, cut(*b, *c)]);
            }
            _ => {}
        }
    }
    triangles
}

#[cfg(test)]
mod tests {
    use super::*;
    use pellucid_io::volume::Volume;

    #[test]
    fn a_plane_has_its_area_and_its_points() {
        // x + 2y + 3z on 5 × 6 × 7 numbers; through the middle of the box.
        let dims = [5, 6, 7];
        let at = |i: usize| ((i % 5) + 2 * (i / 5 % 6) + 3 * (i / 30)) as f32;
        let volume = Volume { dims, values: (0..210).map(at).collect() };
        let field = Field::new(&volume);
        let surface = Isosurface::new(&field, 4.5);
        // Cut off from the corner: an edge of the triangle ends at z = 1.5, the others at y = 2.25, and x = 4 cuts its
        // tip at 4.5.
        let full = 0.5 * 4.5 * 2.25 * 1.5;
        let cut_off = full / (9.0f64).powi(3);
        // Three times the volume over the height, which is the value over the length of the gradient; the tip's height
        // is a ninth.
        let height = 4.5 / 14f64.sqrt();
        let area = full / height - cut_off / (height / 9.0);
        assert!((surface.area() - area).abs() < 1e-9, "{} and not {area}", surface.area());
        let mut random = Random::new(1);
        for _ in 0..200 {
            let point = surface.point(&mut random);
            assert!((point.dot(DVec3::new(1.0, 2.0, 3.0)) - 4.5).abs() < 1e-6, "{point}");
        }
        assert_eq!(Isosurface::new(&field, 40.0).area(), 0.0);
        // NaN values have no surface around them.
        let mut hurt = volume.clone();
        hurt.values[0] = f32::NAN;
        let field = Field::new(&hurt);
        assert!(Isosurface::new(&field, 0.5).area() == 0.0, "all of it would be in the first cell");
    }
}
