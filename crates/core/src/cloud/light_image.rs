//! The square image that a light has of some points: how much of it their box covers, how many pixels it takes, and the
//! holes that are left in its surfaces.

use glam::{DVec2, DVec3};

use super::Bounds;
use crate::light::Light;

/// The tangent of the widest angle from the middle of a light's image to its border; wider scenes need a cube of
/// images.
pub const WIDEST: f64 = 1.732_050_807_568_877_2;

/// Fewest columns and rows of an image whose resolution follows from the points.
pub const FEWEST: u32 = 64;
/// Most columns and rows of such an image.
pub const MOST: u32 = 4096;

/// Points of a cloud for each one on a surface that the light reaches first: the other half of a closed surface lies
/// behind, and most scenes hold more than one surface.
const POINTS_PER_LIT: f64 = 2.0;

/// Columns and rows of a block in which holes are looked for, in pixels that hold a point each.
const BLOCK: f64 = 3.0;

/// Share of the covered pixels that may be holes.
const MANY: f64 = 0.05;
/// Share of the covered pixels with points that may show some behind a hole.
const SEEN: f64 = 0.005;

/// Axes of a camera that looks along `forward`, of length 1: right and up.
pub fn axes(forward: DVec3) -> [DVec3; 2] {
    let up = forward.any_orthonormal_vector();
    [forward.cross(up), up]
}

/// Corners of a box in the axes of a camera at `eye`, in world units: right, up, forward.
pub fn seen(eye: DVec3, [right, up]: [DVec3; 2], forward: DVec3, bounds: &Bounds) -> [DVec3; 8] {
    bounds.corners().map(|corner| {
        let p = corner - eye;
        DVec3::new(p.dot(right), p.dot(up), p.dot(forward))
    })
}

/// Returns how many of a light's images the box covers, seen from the light: up to 1 of a single one, 6 if the light is
/// in the box or so near that it needs a cube of images; 0 for a headlight, which has none.
pub fn covered(light: &Light, bounds: &Bounds) -> f64 {
    let flat = match *light {
        Light::Headlight => return 0.0,
        Light::Direction(direction) => {
            let forward = direction.normalize_or_zero();
            seen(bounds.center(), axes(forward), forward, bounds).map(|p| p.truncate())
        }
        Light::Position(position) => {
            let Some(forward) = (bounds.center() - position).try_normalize() else { return 6.0 };
            let corners = seen(position, axes(forward), forward, bounds);
            let flat = corners.map(|p| p.truncate() / p.z);
            if corners.iter().any(|p| p.z <= 0.0) || half(&flat) > WIDEST {
                return 6.0;
            }
            flat
        }
    };
    let side = 2.0 * half(&flat);
    if side > 0.0 { hull_area(flat) / (side * side) } else { 0.0 }
}

/// Half of the side of the square around the middle that holds these places.
fn half(places: &[DVec2]) -> f64 {
    places.iter().map(|p| p.abs().max_element()).fold(0.0, f64::max)
}

/// Area of the convex hull of some places (the monotone chain of Andrew 1979).
fn hull_area(mut places: [DVec2; 8]) -> f64 {
    places.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    // Twice the area between one side of the hull and the line from its first place to its last.
    let side = |places: &mut dyn Iterator<Item = DVec2>| {
        let mut hull: Vec<DVec2> = Vec::with_capacity(8);
        for p in places {
            while let [.., a, b] = hull[..] {
                if (b - a).perp_dot(p - a) > 0.0 {
                    break;
                }
                hull.pop();
            }
            hull.push(p);
        }
        hull.windows(2).map(|edge| edge[0].perp_dot(edge[1])).sum::<f64>()
    };
    0.5 * (side(&mut places.into_iter()) + side(&mut places.into_iter().rev()))
}

/// Columns and rows at which a pixel of a light's image holds about one point of the surface that the light reaches
/// first: half of the `points` lie evenly in what the box covers of it. Not a whole number, and without limits.
pub fn natural_resolution(light: &Light, bounds: &Bounds, points: u64) -> f64 {
    let lit = points as f64 / POINTS_PER_LIT;
    // A line of points covers no area, but as many pixels as the image has columns.
    (lit / covered(light, bounds)).sqrt().min(lit)
}

/// Returns the columns and rows that `shadows.resolution = "auto"` is: [`natural_resolution`], rounded, from [`FEWEST`]
/// to [`MOST`]. It follows from the points' box and number and from the light alone.
pub fn automatic_resolution(light: &Light, bounds: &Bounds, points: u64) -> u32 {
    natural_resolution(light, bounds, points).round().clamp(FEWEST.into(), MOST.into()) as u32
}

/// Columns and rows of the square blocks in which holes are looked for in an image of `resolution` whose pixels hold a
/// point each at `natural`: about nine points of the nearest surface are in a block.
pub fn hole_block(resolution: u32, natural: f64) -> u32 {
    (BLOCK * f64::from(resolution) / natural).round().clamp(BLOCK, resolution.max(3).into()) as u32
}

/// Holes in the surfaces of a light's image. An image is divided into blocks ([`hole_block`]). A block is *covered* if
/// it and the eight around it have points; the surface in it is as far as the farthest of the nearest points of these
/// nine. A pixel of a covered block is a *hole* if the filters left nothing there, or points more than d̃ behind that
/// surface.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Holes {
    /// Pixels of covered blocks.
    pub covered: u64,
    /// Covered pixels that are holes.
    pub holes: u64,
    /// Covered pixels that show points.
    pub shown: u64,
    /// Holes that show points behind the surface, which light reaches through them.
    pub leaks: u64,
}

impl Holes {
    /// Returns the share of the covered pixels that are holes; 0 without any.
    pub fn share(&self) -> f64 {
        self.holes as f64 / self.covered.max(1) as f64
    }

    /// Returns `true` if over 5% of the covered pixels are holes, and light visibly falls through them: at least one of
    /// 200 pixels with points shows some behind a hole. A surface over nothing may have holes.
    pub fn are_many(&self) -> bool {
        self.share() > MANY && self.leaks as f64 >= SEEN * self.shown.max(1) as f64
    }
}

impl std::ops::Add for Holes {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self {
            covered: self.covered + other.covered,
            holes: self.holes + other.holes,
            shown: self.shown + other.shown,
            leaks: self.leaks + other.leaks,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const DOWN: Light = Light::Direction(DVec3::NEG_Z);

    fn slab(x: f64, y: f64, z: f64) -> Bounds {
        Bounds { min: DVec3::ZERO, max: DVec3::new(x, y, z) }
    }

    #[test]
    fn a_box_from_above_covers_its_floor() {
        // The image is 4 wide, the floor 4 × 1.
        assert!((covered(&DOWN, &slab(4.0, 1.0, 7.0)) - 0.25).abs() < 1e-12);
        // A cube along its diagonal: the projected area is √3. Its outline is a hexagon with corners √(2/3) from the
        // middle, so that the square around it is between that and the distance of the sides, √2 / 2, from the middle.
        let share = covered(&Light::Direction(DVec3::ONE), &slab(1.0, 1.0, 1.0));
        let (least, most) = (3f64.sqrt() / (4.0 * 2.0 / 3.0), 3f64.sqrt() / (4.0 * 0.5));
        assert!(share >= least - 1e-12 && share <= most, "{share}");
    }

    #[test]
    fn a_lamp_sees_what_a_direction_sees_from_afar_and_all_around_from_within() {
        let bounds = slab(4.0, 1.0, 0.0);
        let above = |height: f64| Light::Position(bounds.center() + height * DVec3::Z);
        assert!((covered(&above(3.0), &bounds) - 0.25).abs() < 1e-12);
        // Two units to the side and less than 2 / √3 below.
        assert_eq!(covered(&above(1.1), &bounds), 6.0);
        assert_eq!(covered(&Light::Position(DVec3::ONE), &slab(2.0, 3.0, 4.0)), 6.0);
        assert_eq!(covered(&Light::Position(DVec3::ONE), &slab(2.0, 2.0, 2.0)), 6.0);
        assert_eq!(covered(&Light::Headlight, &bounds), 0.0);
    }

    #[test]
    fn resolution_gives_a_pixel_two_points_of_the_cloud() {
        // 80 000 points on 4 × 1, which is a quarter of the image: 40 000 pixels there, 160 000 in all.
        assert_eq!(automatic_resolution(&DOWN, &slab(4.0, 1.0, 7.0), 80_000), 400);
        // A lamp in the midst has six images.
        let lamp = Light::Position(DVec3::ONE);
        assert_eq!(automatic_resolution(&lamp, &slab(2.0, 3.0, 4.0), 1_920_000), 400);
        // Limits.
        assert_eq!(automatic_resolution(&DOWN, &slab(1.0, 1.0, 1.0), 1), 64);
        assert_eq!(automatic_resolution(&DOWN, &slab(1.0, 1.0, 1.0), u64::MAX), 4096);
        // A line: as many pixels as half of its points. A place: no area at all.
        assert_eq!(automatic_resolution(&DOWN, &slab(1.0, 0.0, 0.0), 1000), 500);
        assert_eq!(automatic_resolution(&DOWN, &slab(0.0, 0.0, 0.0), 1000), 500);
        assert_eq!(automatic_resolution(&DOWN, &slab(0.0, 0.0, 0.0), 0), 64);
    }

    #[test]
    fn blocks_hold_nine_points() {
        assert_eq!([hole_block(400, 400.0), hole_block(100, 400.0), hole_block(1600, 400.0)], [3, 3, 12]);
        assert_eq!([hole_block(1, 0.0), hole_block(500, 0.5)], [3, 500]);
    }

    #[test]
    fn holes_count_if_they_are_many_and_something_shows_through() {
        let holes = Holes { covered: 1000, holes: 51, shown: 1000, leaks: 5 };
        assert!(holes.are_many());
        assert!(!Holes { holes: 50, ..holes }.are_many());
        assert!(!Holes { leaks: 4, ..holes }.are_many());
        assert!(!Holes::default().are_many());
        assert_eq!((holes + holes).share(), 0.051);
    }
}
