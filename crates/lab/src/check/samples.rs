//! Samples of a pixel's area: half planes, points, discs and lines whose area in each pixel is known in closed form.
//!
//! The N places of samples are a (0, m, 2)-net in base 2, N = 2^m (Hammersley): every box of area 1/N that is cut from
//! the pixel by halves has one of them. So a border along an axis at a multiple of 1/N leaves exactly its share of the
//! samples on either side, a box at a corner of the pixel has its area of them but for (m + 3) / 2 (Niederreiter 1992,
//! "Random Number Generation and Quasi-Monte Carlo Methods", Chapter 4), and a straight border meets 2 √N − 1 squares
//! of area 1/N at most, each of which may be off by one. A test below counts both.

use super::prelude::*;
use pellucid_scene::{BlendedSplats, Interpolated, Mlab, ScreenSplats};

/// Numbers of samples, powers of four.
const COUNTS: [u32; 3] = [4, 16, 64];
const SIZE: [u32; 2] = [8, 8];
/// Radius of discs whose rim is straight in an image of 8 pixels: it bends by 4²/2R, 2e-3, and float32 knows distances
/// in pixels to 5 roundings of R, 1.3e-3. No sample is nearer than 1/128 to a border at a multiple of 1/64.
const HUGE: f64 = 4096.0;

pub(super) fn cases() -> Vec<Case> {
    let splats = ScreenSplats { max_pixel_radius: 1e9, ..ScreenSplats::default() };
    let blended = BlendedSplats { splats, ..BlendedSplats::default() };
    let opaque = vec![Method::Circles(splats), Method::Hqs(blended), Method::Splats(blended)];
    let discs = [opaque, with_peel(), with_samples(8, approximations())].concat();
    let relief = Interpolated { splats, ..Interpolated::default() };
    let nearest = [Method::Points, Method::Squares(splats), Method::Paraboloid(relief), Method::Cone(relief)];
    let points = [&nearest[..], &[Method::Sphere(splats)], &discs].concat();
    let layers = [with_peel(), vec![Method::Hybrid(Hybrid::default()), Method::Mlab(Mlab::default())]].concat();
    joined([
        each(&discs, "area-edge", edges)
            .about("half planes along the axes, borders at multiples of 1/N: their area in each pixel"),
        each(&discs, "area-slanted-edge", slanted).about(
            "slanted half planes with N samples, off their area by (2 √N - 1) / N at most: times what is allowed",
        ),
        each(&points, "area-point", points_beside)
            .about("a point of no radius is as wide as a pixel: the area of a square in each pixel"),
        each(&points, "area-corner", points_at_corners)
            .about("a point near a corner of pixels, off its area by (m + 3) / 2N at most: times what is allowed"),
        each(&discs, "area-small-disc", small_discs)
            .about("a disc of a radius of 0.3 pixels is its pixel: as a point of no radius, to the byte"),
        each(&discs, "area-line", lines).about("a line of discs, one pixel wide or 2.5: its area in each row"),
        each(&layers, "area-crossing", crossing)
            .about("borders of two layers cross in a pixel, off by their boxes' (m + 3) / 2N: times what is allowed"),
    ])
}

fn picture(stage: &mut CaseRenderer, dots: &[Dot], method: Method, samples: u32) -> Result<Vec<[f32; 4]>> {
    let frame = Frame { samples, ..Frame::new(pixels(SIZE), SIZE, method) };
    Ok(stage.render(&cloud(dots), &frame)?.image.rgba)
}

/// A white disc at a place of the image.
fn disc(x: f64, y: f64, radius: f64) -> Dot {
    Dot { position: DVec3::new(x, -y, -10.0), radius: radius as f32, ..Dot::default() }
}

/// White of these opacities, pixel by pixel.
fn white(alpha: impl Fn(f64, f64) -> f64) -> Vec<[f64; 4]> {
    let [width, height] = SIZE.map(f64::from);
    let all = (0..(width * height) as u32).map(|i| [i % SIZE[0], i / SIZE[0]].map(f64::from));
    all.map(|[x, y]| [alpha(x, y); 4]).collect()
}

/// The length that two ranges of pixels share.
fn shared([a, b]: [f64; 2], [c, d]: [f64; 2]) -> f64 {
    (b.min(d) - a.max(c)).max(0.0)
}

/// The largest error over all numbers of samples, and that of pixels' centers alone.
#[derive(Default)]
struct Worst {
    found: f64,
    naive: f64,
}

impl Worst {
    /// Adds a picture whose values should be these, in units of what is allowed. `center`: the values at the centers.
    fn add(&mut self, found: &[[f32; 4]], center: &[[f64; 4]], wanted: &[[f64; 4]], allowed: f64) {
        let center: Vec<[f32; 4]> = center.iter().map(|pixel| pixel.map(|value| value as f32)).collect();
        self.found = self.found.max(pixels_apart(found, wanted) / allowed);
        self.naive = self.naive.max(pixels_apart(&center, wanted) / allowed);
    }

    /// Bound of exact areas: colors may be sums over weights.
    fn exact(&self) -> Finding {
        Finding::new(self.found, COMPENSATED, self.naive)
    }

    /// Error in units of what is allowed, as one sample is off by more than that of 64.
    fn in_units(&self) -> Finding {
        Finding::new(self.found, 1.0, self.naive)
    }
}

/// Three eighths of N, a whole number.
fn part(samples: u32) -> f64 {
    f64::from(3 * samples / 8) / f64::from(samples)
}

fn is_in(inside: bool) -> f64 {
    f64::from(u8::from(inside))
}

fn edges(stage: &mut CaseRenderer, method: Method) -> CaseResult {
    let mut worst = Worst::default();
    for samples in COUNTS {
        let border = 3.0 + part(samples);
        let left = |v: f64| shared([v, v + 1.0], [-1.0, border]);
        let found = picture(stage, &[disc(border - HUGE, 4.0, HUGE)], method, samples)?;
        worst.add(&found, &white(|x, _| is_in(x + 0.5 < border)), &white(|x, _| left(x)), 1.0);
        // The lower half.
        let found = picture(stage, &[disc(4.0, border + HUGE, HUGE)], method, samples)?;
        worst.add(&found, &white(|_, y| is_in(y + 0.5 > border)), &white(|_, y| 1.0 - left(y)), 1.0);
    }
    Ok(worst.exact())
}

/// The area of a pixel where n · p ≤ d: its square is cut, and the polygon's area is that of the triangles from one of
/// its corners.
fn area(x: f64, y: f64, normal: [f64; 2], d: f64) -> f64 {
    let side = |p: [f64; 2]| normal[0] * p[0] + normal[1] * p[1] - d;
    let square = [[x, y], [x + 1.0, y], [x + 1.0, y + 1.0], [x, y + 1.0]];
    let mut polygon: Vec<[f64; 2]> = Vec::new();
    for (i, p) in square.iter().enumerate() {
        let (q, here, there) = (square[(i + 1) % 4], side(*p), side(square[(i + 1) % 4]));
        if here <= 0.0 {
            polygon.push(*p);
        }
        if here * there < 0.0 {
            let t = here / (here - there);
            polygon.push([p[0] + t * (q[0] - p[0]), p[1] + t * (q[1] - p[1])]);
        }
    }
    let crosses = polygon.iter().enumerate().map(|(i, p)| {
        let q = polygon[(i + 1) % polygon.len()];
        p[0] * q[1] - q[0] * p[1]
    });
    0.5 * crosses.sum::<f64>().abs()
}

fn slanted(stage: &mut CaseRenderer, method: Method) -> CaseResult {
    let mut worst = Worst::default();
    for degrees in [17.0f64, 45.0, 107.0] {
        let (sin, cos) = degrees.to_radians().sin_cos();
        let through = [4.3, 3.6];
        let d = cos * through[0] + sin * through[1];
        let wanted = white(|x, y| area(x, y, [cos, sin], d));
        let center = white(|x, y| is_in(cos * (x + 0.5) + sin * (y + 0.5) <= d));
        let dots = [disc(through[0] - HUGE * cos, through[1] - HUGE * sin, HUGE)];
        for samples in COUNTS {
            // The rim bends by 6²/2R, over the diagonal of a pixel at most.
            let allowed = (2.0 * f64::from(samples).sqrt() - 1.0) / f64::from(samples) + 36.0 / (2.0 * HUGE) * 1.5;
            worst.add(&picture(stage, &dots, method, samples)?, &center, &wanted, allowed);
        }
    }
    Ok(worst.in_units())
}

/// A point of a moved image is in the pixel that holds its center: over all of them in the square around it.
fn square(x: f64, y: f64) -> Vec<[f64; 4]> {
    let around = |v: f64| [v - 0.5, v + 0.5];
    white(|column, row| shared([column, column + 1.0], around(x)) * shared([row, row + 1.0], around(y)))
}

fn home(x: f64, y: f64) -> Vec<[f64; 4]> {
    white(|column, row| is_in(x.floor() == column && y.floor() == row))
}

fn points_beside(stage: &mut CaseRenderer, method: Method) -> CaseResult {
    let mut worst = Worst::default();
    for samples in COUNTS {
        for [x, y] in [[3.5 + part(samples), 4.5], [3.5, 4.5 - part(samples)]] {
            let found = picture(stage, &[disc(x, y, 0.0)], method, samples)?;
            worst.add(&found, &home(x, y), &square(x, y), 1.0);
        }
    }
    Ok(worst.exact())
}

/// Most that a box at a corner of a pixel may be off its area with N samples.
fn at_corner(samples: u32) -> f64 {
    (f64::from(samples.ilog2()) + 3.0) / f64::from(2 * samples)
}

fn points_at_corners(stage: &mut CaseRenderer, method: Method) -> CaseResult {
    let mut worst = Worst::default();
    // No border of the square is as near to a sample as 1/1000.
    for [x, y] in [[4.0 - 0.115, 4.0 + 0.072], [3.0 + 0.205, 4.0 - 0.330]] {
        for samples in COUNTS {
            let found = picture(stage, &[disc(x, y, 0.0)], method, samples)?;
            worst.add(&found, &home(x, y), &square(x, y), at_corner(samples));
        }
    }
    Ok(worst.in_units())
}

fn small_discs(stage: &mut CaseRenderer, method: Method) -> CaseResult {
    let mut error = 0.0;
    for samples in COUNTS {
        let [none, small] = [0.0, 0.3].map(|radius| picture(stage, &[disc(4.2, 3.1, radius)], method, samples));
        error += bytes_between(&none?, &small?);
    }
    // Its own area, of the pixel's that is drawn.
    let naive = (1.0 - std::f64::consts::PI * 0.3f64.powi(2)).abs();
    Ok(Finding::new(error, 0.0, naive))
}

fn lines(stage: &mut CaseRenderer, method: Method) -> CaseResult {
    let mut worst = Worst::default();
    for samples in COUNTS {
        let y = 3.5 + part(samples);
        // Discs below half a pixel are as high as one. Between those of 1.25 the border is lower by 1/32² / 2.5, 4e-4.
        for (radius, half) in [(0.2, 0.5), (1.25, 1.25)] {
            let line: Vec<Dot> = (-48..=176).map(|i| disc(f64::from(i) / 16.0, y, radius)).collect();
            let found = picture(stage, &line, method, samples)?;
            let wanted = white(|_, row| shared([row, row + 1.0], [y - half, y + half]));
            let center = white(|_, row| is_in((row + 0.5 - y).abs() <= half));
            worst.add(&found, &center, &wanted, 1.0);
        }
    }
    Ok(worst.exact())
}

fn crossing(stage: &mut CaseRenderer, method: Method) -> CaseResult {
    let [front, back] = [0.5, 0.75];
    let mut worst = Worst::default();
    for samples in COUNTS {
        let border = 3.0 + part(samples);
        let layer = |x: f64, y: f64, depth: f64, color: Vec3, opacity: f64| Dot {
            position: DVec3::new(x, -y, -depth),
            color,
            opacity: opacity as f32,
            ..disc(0.0, 0.0, HUGE)
        };
        let dots = [layer(border - HUGE, 4.0, 10.0, Vec3::X, front), layer(4.0, border - HUGE, 20.0, Vec3::Z, back)];
        // Shares of a pixel that the two cover, and that both do.
        let blended = |a: f64, b: f64, both: f64| {
            let (red, blue) = (front * a, back * (b - front * both));
            [red, 0.0, blue, red + blue]
        };
        let share = |v: f64| shared([v, v + 1.0], [-1.0, border]);
        let each = |of: &dyn Fn(f64) -> f64| -> Vec<[f64; 4]> {
            (0..64).map(|i| [of(f64::from(i % 8)), of(f64::from(i / 8))]).map(|[a, b]| blended(a, b, a * b)).collect()
        };
        let (wanted, center) = (each(&share), each(&|v| is_in(v + 0.5 < border)));
        let allowed = front * back * at_corner(samples) + COMPENSATED;
        worst.add(&picture(stage, &dots, method, samples)?, &center, &wanted, allowed);
    }
    Ok(worst.in_units())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn areas_of_half_a_pixel_a_corner_and_all_of_it() {
        assert!((area(3.0, 4.0, [1.0, 0.0], 3.5) - 0.5).abs() < 1e-12);
        // A triangle of legs 0.4 and 0.2.
        assert!((area(0.0, 0.0, [1.0, 2.0], 0.4) - 0.04).abs() < 1e-12);
        assert_eq!(area(0.0, 0.0, [1.0, 1.0], 5.0), 1.0);
        assert_eq!(area(0.0, 0.0, [1.0, 1.0], -5.0), 0.0);
    }

    #[test]
    fn boxes_at_corners_and_half_planes_have_their_share_of_the_samples() {
        for samples in COUNTS {
            let places = pellucid_reference::samples::places(samples);
            let share = |inside: &dyn Fn(f64, f64) -> bool| {
                places.iter().filter(|place| inside(place.x, place.y)).count() as f64 / f64::from(samples)
            };
            for i in 0..=40 {
                for j in 0..=40 {
                    let [a, b] = [i, j].map(|v| f64::from(v) / 40.0 + 1e-5);
                    let found = share(&|x, y| x < a && y < b);
                    assert!((found - a.min(1.0) * b.min(1.0)).abs() <= at_corner(samples), "{samples}: {a} {b}");
                    let (sin, cos) = (f64::from(i) / 5.0).sin_cos();
                    let d = 1.5 * b - 0.5;
                    let off = (share(&|x, y| cos * x + sin * y <= d) - area(0.0, 0.0, [cos, sin], d)).abs();
                    let root = f64::from(samples).sqrt();
                    assert!(off <= (2.0 * root - 1.0) / f64::from(samples), "{samples}: {off}");
                }
            }
        }
    }
}
