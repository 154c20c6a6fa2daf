//! Planes before each other, whose exact image is known without a point: alpha blending of their opacities.

use std::cmp::Ordering;

use glam::{DVec3, Vec3};

use super::{Analytic, Row};
use crate::report::fit::{PowerLaw, power_law};
use pellucid_core::camera::Projection;
use pellucid_core::image::LinearImage;
use pellucid_core::metrics;
use pellucid_engine::methods::Frame;
use pellucid_reference::shading::shade;
use pellucid_reference::spbr::points_per_pixel;
use pellucid_scene::ColorSpace;
use pellucid_scene::prepare::Arranged;
use pellucid_scene::prepare::ensembles::{CloudSurface, Dealt};

/// Cells of the image, along each side, in which points are counted.
const CELLS: usize = 8;
/// Least average number of points per cell; smaller numbers carry no information.
const LEAST: f64 = 25.0;
/// The number of standard deviations a cell may deviate: by chance, one cell in 10⁹ does.
const DEVIATIONS: f64 = 6.0;
/// Largest difference of depths in a plane, over the depth; and of colors.
const FLAT: f64 = 1e-6;

/// A single plane.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Plane {
    depth: f64,
    /// Linear.
    color: DVec3,
    alpha: f64,
    /// Points on a pixel.
    points: f64,
}

/// Planes, the nearest first.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Planes(Vec<Plane>);

impl Planes {
    /// The clouds of a frame, if each of them is a plane parallel to an orthographic image, of one color and one
    /// opacity, whose points fill the image evenly and are enough for that opacity, and if blending runs in linear
    /// light.
    pub fn from_points(arranged: &Arranged, frame: &Frame) -> Option<Self> {
        let Arranged::Dealt(dealt) = arranged else { return None };
        if !matches!(frame.camera.projection, Projection::Orthographic { .. }) || frame.color != ColorSpace::Linear {
            return None;
        }
        let colors = shade(&dealt.points, &frame.camera, &frame.shading, frame.color);
        let planes = dealt.surfaces.iter().map(|surface| plane(dealt, surface, &colors, frame));
        let mut planes: Vec<Plane> = planes.collect::<Option<_>>()?;
        planes.sort_by(|a, b| a.depth.total_cmp(&b.depth));
        // The order of two planes at the same depth would be undefined.
        let apart = planes.windows(2).all(|pair| pair[1].depth - pair[0].depth > 2.0 * FLAT * pair[1].depth);
        (apart && !planes.is_empty()).then_some(Self(planes))
    }

    /// Color of every pixel over a background, linear R, G, B, and its standard deviation over the channels. Each plane
    /// lets a random part of the background through, with mean 1 − α and mean square `square`.
    fn color(&self, background: Vec3, square: impl Fn(&Plane) -> f64) -> (DVec3, f64) {
        let behind = (background.as_dvec3(), DVec3::ZERO);
        let (mean, variance) = self.0.iter().rev().fold(behind, |(mean, variance), plane| {
            let free = 1.0 - plane.alpha;
            let beyond = mean - plane.color;
            (plane.color + free * beyond, square(plane) * (variance + beyond * beyond) - free * free * beyond * beyond)
        });
        (mean, (variance.max(DVec3::ZERO).element_sum() / 3.0).sqrt())
    }

    /// Ensembles up to which no point of any plane is assigned twice.
    fn once(&self) -> f64 {
        self.0.iter().map(|plane| plane.points / points_per_pixel(plane.alpha)).fold(f64::INFINITY, f64::min)
    }

    /// The expected values for these planes, with the image that ensembles of these points converge to (`limit`).
    pub fn about(&self, background: Vec3, limit: &LinearImage) -> Analytic {
        // All or nothing.
        let (color, of_one) = self.color(background, |plane| 1.0 - plane.alpha);
        // (1 − q)ⁿ of n points on a pixel, whose number is Poisson's, each in a share q of the ensembles.
        let square = |plane: &Plane| {
            let share = points_per_pixel(plane.alpha) / plane.points;
            (-plane.points * share * (2.0 - share)).exp()
        };
        let (_, expected_floor) = self.color(background, square);
        Analytic {
            opacities: self.0.iter().map(|plane| plane.alpha).collect(),
            points_per_pixel: self.0.iter().map(|plane| plane.points).collect(),
            color: color.to_array(),
            dealt_once: self.once(),
            expected_of_one: of_one,
            expected_floor,
            floor: rmse(color.to_array(), limit),
            slope: None,
        }
    }
}

/// The slope of the error against the analytic image, as long as no point is assigned twice.
pub(super) fn slope(rows: &[Row], dealt_once: f64) -> Option<PowerLaw> {
    let point = |row: &Row| Some((row.step.as_ref()?.1, row.rmse_analytic?));
    let points: Vec<_> = rows.iter().filter_map(point).filter(|(ensembles, _)| *ensembles <= dealt_once).collect();
    power_law(&points)
}

/// The RMSE of an image against a single color.
pub(super) fn rmse(color: [f64; 3], image: &LinearImage) -> f64 {
    let color = color.map(|value| value as f32);
    metrics::rmse(&vec![color; image.pixels.len()], &image.pixels)
}

fn plane(dealt: &Dealt, surface: &CloudSurface, colors: &[DVec3], frame: &Frame) -> Option<Plane> {
    let range = surface.points.start as usize..surface.points.end as usize;
    let (positions, colors) = (dealt.points.positions.get(range.clone())?, colors.get(range.clone())?);
    let is_even = dealt.points.opacities.get(range)?.iter().all(|opacity| *opacity == surface.opacity);
    let color = *colors.first()?;
    let depth = frame.camera.to_view(*positions.first()?).z;
    let is_flat = |position: &DVec3| (frame.camera.to_view(*position).z - depth).abs() <= FLAT * depth.abs();
    if !is_even
        || !(frame.camera.near..=frame.camera.far).contains(&depth)
        || !positions.iter().all(is_flat)
        || !colors.iter().all(|other| (*other - color).abs().max_element() <= FLAT)
    {
        return None;
    }
    let points = per_pixel(positions, frame)?;
    let alpha = f64::from(surface.opacity);
    (points_per_pixel(alpha).partial_cmp(&points) != Some(Ordering::Greater)).then_some(Plane {
        depth,
        color,
        alpha,
        points,
    })
}

/// Points on a pixel; `None` if the image is not filled evenly.
fn per_pixel(positions: &[DVec3], frame: &Frame) -> Option<f64> {
    let mut counts = [0.0; CELLS * CELLS];
    let sides = frame.size.map(f64::from);
    for position in positions {
        let (at, _) = frame.camera.project(*position, frame.size);
        let [x, y] = [at.x / sides[0], at.y / sides[1]];
        if (0.0..1.0).contains(&x) && (0.0..1.0).contains(&y) {
            let cell = |share: f64| ((share * CELLS as f64) as usize).min(CELLS - 1);
            counts[cell(y) * CELLS + cell(x)] += 1.0;
        }
    }
    let all: f64 = counts.iter().sum();
    let mean = all / counts.len() as f64;
    let is_even = counts.iter().all(|count| (count - mean).abs() <= DEVIATIONS * mean.sqrt());
    (mean >= LEAST && is_even).then(|| all / (sides[0] * sides[1]))
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg64Mcg;

    use super::*;

    fn plane(depth: f64, color: DVec3, alpha: f64, points: f64) -> Plane {
        Plane { depth, color, alpha, points }
    }

    fn black(size: u32) -> LinearImage {
        LinearImage { width: size, height: size, pixels: vec![[0.0; 3]; (size * size) as usize] }
    }

    #[test]
    fn one_plane_by_hand() {
        // ln 2 of two points: q = 0.347; a white plane before black.
        let planes = Planes(vec![plane(1.0, DVec3::ONE, 0.5, 2.0)]);
        let about = planes.about(Vec3::ZERO, &black(2));
        let assert_is = |value: f64, wanted: f64| assert!((value - wanted).abs() < 1e-12, "{value} for {wanted}");
        about.color.iter().for_each(|value| assert_is(*value, 0.5));
        assert_is(about.floor, 0.5);
        assert_is(about.dealt_once, 2.0 / 2f64.ln());
        assert_is(about.expected_of_one, 0.5);
        assert_is(about.expected_floor, 0.5 * (2f64.ln().powi(2) / 2.0).exp_m1().sqrt());
        assert_is(about.expected(2.0), 0.5 / 2f64.sqrt());
        assert_is(about.expected(1e18), about.expected_floor);
    }

    /// A Poisson number (Knuth).
    fn poisson(mean: f64, random: &mut Pcg64Mcg) -> i32 {
        let (limit, mut product, mut count) = ((-mean).exp(), random.random::<f64>(), 0);
        while product > limit {
            product *= random.random::<f64>();
            count += 1;
        }
        count
    }

    #[test]
    fn two_planes_as_blended_and_as_simulated() {
        let (red, green) = (0.8 * DVec3::X, 0.6 * DVec3::Y);
        let planes = Planes(vec![plane(1.0, red, 0.3, 5.0), plane(2.0, green, 0.6, 4.0)]);
        let background = Vec3::new(0.0, 0.0, 0.5);
        let about = planes.about(background, &black(1));
        let blended = 0.3 * red + 0.7 * (0.6 * green + 0.4 * background.as_dvec3());
        assert!(DVec3::from_array(about.color).abs_diff_eq(blended, 1e-12), "{about:?}");
        let mut random = Pcg64Mcg::seed_from_u64(1);
        let mut free = |plane: &Plane| {
            let share = points_per_pixel(plane.alpha) / plane.points;
            (1.0 - share).powi(poisson(plane.points, &mut random))
        };
        let trials = 40_000;
        let squares = (0..trials).map(|_| {
            let [front, back] = [free(&planes.0[0]), free(&planes.0[1])];
            let color = (1.0 - front) * red + front * ((1.0 - back) * green + back * background.as_dvec3());
            (color - blended).length_squared() / 3.0
        });
        let found = (squares.sum::<f64>() / f64::from(trials)).sqrt();
        assert!((found / about.expected_floor - 1.0).abs() < 0.02, "{found} and not {}", about.expected_floor);
    }
}
