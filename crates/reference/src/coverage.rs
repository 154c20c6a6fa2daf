//! Pixels that a splat covers, at which depth, and how far from its center.
//!
//! Every pixel of a window around the splat is tested by the definition itself: the pixel's center against the drawn
//! outline, or the ray through the pixel's center against the tangent plane.

mod ranges;

use std::ops::Range;

use glam::{DVec2, DVec3};

pub use ranges::{Possible, possible};

use super::View;
use pellucid_core::camera::{Camera, Projection};

/// The shape drawn for a point.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Shape {
    /// The pixel that contains the projected center.
    Point,
    /// Screen-aligned disc at the depth of its center.
    Disc,
    /// Screen-aligned square of half side `radius` at the depth of its center.
    Square,
    /// Disc in the tangent plane with a depth for each pixel; [`Shape::Disc`] without a normal.
    Oriented,
}

/// A point in its drawn form.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Splat {
    /// World position; drawn only if it is finite.
    pub position: DVec3,
    /// World radius, at least 0.
    pub radius: f64,
    /// World normal of any length; zero counts as missing. Only [`Shape::Oriented`] uses it.
    pub normal: Option<DVec3>,
    /// The outline.
    pub shape: Shape,
    /// Upper bound of the pixel radius of discs and squares; infinite where a method does not clamp.
    pub max_pixel_radius: f64,
}

impl Splat {
    /// A splat that faces the viewer, of any size.
    pub(crate) fn facing(position: DVec3, radius: f64, shape: Shape) -> Self {
        Self { position, radius, normal: None, shape, max_pixel_radius: f64::INFINITY }
    }
}

/// A single pixel of a footprint.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Coverage {
    /// Column, from the left.
    pub x: u32,
    /// Row, from the top.
    pub y: u32,
    /// Depth along the viewing axis.
    pub z: f64,
    /// Distance from the splat's center over its radius: on screen for flat shapes, in the tangent plane for oriented
    /// ones. At most 1, save in a square's corners.
    pub rho: f64,
}

/// Returns the pixels that a splat covers, row by row; empty if it is not drawn.
pub fn footprint(view: View, splat: &Splat) -> Vec<Coverage> {
    match PlacedSplat::new(view, splat) {
        Some(placed) if placed.is_within_depth_range() => placed.window().filter_map(|p| placed.cover(p)).collect(),
        _ => Vec::new(),
    }
}

/// Returns the splat's distance, in pixels, from covering another set of pixels. It is the minimum over three
/// distances: from its rim to the nearest pixel center, from its center to the nearest pixel border where the
/// always-covered pixel matters, and from its depth to `near` and `far` (in pixels at that depth). To first order for
/// oriented discs; infinite for a non-finite position.
pub fn margin_px(view: View, splat: &Splat) -> f64 {
    let Some(placed) = PlacedSplat::new(view, splat) else { return f64::INFINITY };
    let depth = placed.depth_margin_px();
    if !placed.is_within_depth_range() {
        return depth;
    }
    placed.window().map(|p| placed.rim_margin_px(p)).fold(depth.min(placed.home_margin_px()), f64::min)
}

/// The per-pixel test once a splat's center is projected.
enum Outline {
    Pixel,
    Disc { radius_px: f64 },
    Square { radius_px: f64 },
    Tangent { radius: f64, normal_view: DVec3 },
}

struct PlacedSplat<'a> {
    view: View<'a>,
    position_view: DVec3,
    center_px: DVec2,
    outline: Outline,
}

impl<'a> PlacedSplat<'a> {
    /// `None` for a non-finite position.
    fn new(view: View<'a>, splat: &Splat) -> Option<Self> {
        if !splat.position.is_finite() {
            return None;
        }
        let camera = view.camera;
        let position_view = camera.to_view(splat.position);
        let (center_px, z) = camera.project(splat.position, view.size);
        let radius_px = (splat.radius * view.pixels_per_unit(z)).min(splat.max_pixel_radius);
        let normal = splat.normal.and_then(DVec3::try_normalize);
        let outline = match (splat.shape, normal) {
            (Shape::Point, _) => Outline::Pixel,
            (Shape::Square, _) => Outline::Square { radius_px },
            (Shape::Oriented, Some(n)) => {
                let normal_view = DVec3::new(n.dot(camera.right), n.dot(camera.up), n.dot(camera.forward));
                Outline::Tangent { radius: splat.radius, normal_view }
            }
            (Shape::Disc | Shape::Oriented, _) => Outline::Disc { radius_px },
        };
        Some(Self { view, position_view, center_px, outline })
    }

    fn is_within_depth_range(&self) -> bool {
        is_in_depth(self.view.camera, self.position_view.z)
    }

    fn cover(&self, [x, y]: [u32; 2]) -> Option<Coverage> {
        let pixel = DVec2::new(f64::from(x), f64::from(y));
        let hit = match self.outline {
            Outline::Pixel => None,
            Outline::Disc { radius_px } => {
                let distance = (pixel + 0.5 - self.center_px).length();
                (distance <= radius_px).then(|| (self.position_view.z, relative(distance, radius_px)))
            }
            Outline::Square { radius_px } => {
                let offset = pixel + 0.5 - self.center_px;
                let inside = offset.abs().max_element() <= radius_px;
                inside.then(|| (self.position_view.z, relative(offset.length(), radius_px)))
            }
            Outline::Tangent { .. } => self.tangent_hit(pixel + 0.5).filter(|&(_, rho)| rho <= 1.0),
        };
        let (z, rho) = match hit {
            Some(hit) => hit,
            // The pixel holds the projected center, its own center is outside the rim: ρ is the rim's own.
            None if self.center_px.floor() == pixel => (self.position_view.z, 1.0),
            None => return None,
        };
        Some(Coverage { x, y, z, rho })
    }

    /// Depth and ρ where the ray through an image position meets the tangent plane. A perspective ray starts at the
    /// eye, an orthographic one is a whole line.
    fn tangent_hit(&self, at_px: DVec2) -> Option<(f64, f64)> {
        let Outline::Tangent { radius, normal_view } = self.outline else { return None };
        let on_plane = self.view.on_plane(at_px);
        let (origin, direction) = match self.view.camera.projection {
            Projection::Perspective { .. } => (DVec3::ZERO, on_plane.extend(1.0)),
            Projection::Orthographic { .. } => (on_plane.extend(0.0), DVec3::Z),
        };
        let z = normal_view.dot(self.position_view - origin) / normal_view.dot(direction);
        let behind = z <= 0.0 && matches!(self.view.camera.projection, Projection::Perspective { .. });
        if !z.is_finite() || behind {
            return None;
        }
        Some((z, relative((origin + z * direction - self.position_view).length(), radius)))
    }

    /// Pixels that can be covered, and at least one more on each side.
    fn window(&self) -> impl Iterator<Item = [u32; 2]> + use<> {
        self.window_in(0..self.view.size[1])
    }

    /// Returns the pixels of the splat's window in some rows of the image.
    fn window_in(&self, wanted: Range<u32>) -> impl Iterator<Item = [u32; 2]> + use<> {
        let (low, high) = match self.outline {
            Outline::Pixel => (self.center_px, self.center_px),
            Outline::Disc { radius_px } | Outline::Square { radius_px } => {
                (self.center_px - radius_px, self.center_px + radius_px)
            }
            Outline::Tangent { radius, normal_view } => self.tangent_window(radius, normal_view),
        };
        pixels_within(self.view.size, [low, high], wanted)
    }

    /// Image positions around a tilted disc, from its box in camera coordinates; everything if that reaches the eye.
    fn tangent_window(&self, radius: f64, normal_view: DVec3) -> (DVec2, DVec2) {
        let half = radius * (DVec3::ONE - normal_view * normal_view).max(DVec3::ZERO).map(f64::sqrt);
        on_screen(self.view, self.position_view - half, self.position_view + half).into()
    }

    fn depth_margin_px(&self) -> f64 {
        let to = |border: f64| (self.position_view.z - border).abs() * self.view.pixels_per_unit(border);
        // An infinite far plane gives NaN in perspective, which `min` drops.
        to(self.view.camera.near).min(to(self.view.camera.far))
    }

    /// Distance from the projected center to the next pixel border, where that decides something.
    fn home_margin_px(&self) -> f64 {
        // From these radii on, a flat shape reaches the center of its own pixel from anywhere in it.
        let decides = match self.outline {
            Outline::Disc { radius_px } => radius_px < 0.5f64.sqrt(),
            Outline::Square { radius_px } => radius_px < 0.5,
            Outline::Pixel | Outline::Tangent { .. } => true,
        };
        let [width, height] = self.view.size.map(f64::from);
        let c = self.center_px;
        let near_image = c.x > -1.0 && c.y > -1.0 && c.x < width + 1.0 && c.y < height + 1.0;
        if decides && near_image { (c - c.round()).abs().min_element() } else { f64::INFINITY }
    }

    /// Distance from a pixel's center to the rim.
    fn rim_margin_px(&self, [x, y]: [u32; 2]) -> f64 {
        let at_px = DVec2::new(f64::from(x), f64::from(y)) + 0.5;
        let offset = at_px - self.center_px;
        match self.outline {
            Outline::Disc { radius_px } if radius_px > 0.0 => (offset.length() - radius_px).abs(),
            Outline::Square { radius_px } if radius_px > 0.0 => (offset.abs().max_element() - radius_px).abs(),
            Outline::Tangent { radius, .. } if radius > 0.0 => self.tangent_rim_margin_px(at_px),
            _ => f64::INFINITY,
        }
    }

    /// |ρ − 1| over the slope of ρ per pixel.
    fn tangent_rim_margin_px(&self, at_px: DVec2) -> f64 {
        // Small against a pixel, large against the rounding of ρ.
        const STEP_PX: f64 = 1e-4;
        let rho = |at: DVec2| self.tangent_hit(at).map(|(_, rho)| rho);
        let slope = |step: DVec2| Some((rho(at_px + step)? - rho(at_px - step)?) / (2.0 * STEP_PX));
        let Some(here) = rho(at_px) else { return f64::INFINITY };
        match (slope(STEP_PX * DVec2::X), slope(STEP_PX * DVec2::Y)) {
            (Some(dx), Some(dy)) if here != 1.0 => (here - 1.0).abs() / dx.hypot(dy),
            // On the rim, or so close to edge-on that the next ray misses the plane: nothing is safe.
            _ => 0.0,
        }
    }
}

/// Returns `true` if a depth is before the eye and from near to far.
pub(crate) fn is_in_depth(camera: &Camera, z: f64) -> bool {
    let before_eye = z > 0.0 || matches!(camera.projection, Projection::Orthographic { .. });
    before_eye && z >= camera.near && z <= camera.far
}

/// Returns the pixels of some rows whose centers are within a box on the screen, and at least one more on each side.
pub(crate) fn pixels_within(
    size: [u32; 2],
    [low, high]: [DVec2; 2],
    wanted: Range<u32>,
) -> impl Iterator<Item = [u32; 2]> + use<> {
    let first = |low: f64| (low.floor() - 1.0).max(0.0) as u32;
    let end = |high: f64, size: u32| ((high.ceil() + 1.0).max(0.0) as u32).min(size);
    let columns = first(low.x)..end(high.x, size[0]);
    let rows = first(low.y).max(wanted.start)..end(high.y, size[1]).min(wanted.end);
    rows.flat_map(move |y| columns.clone().map(move |x| [x, y]))
}

/// Returns the box on the screen around one in camera coordinates; everything if that reaches the eye.
pub(crate) fn on_screen(view: View, min: DVec3, max: DVec3) -> [DVec2; 2] {
    let (low, high) = (min.truncate(), max.truncate());
    let (low, high) = match view.camera.projection {
        Projection::Orthographic { .. } => (low, high),
        Projection::Perspective { .. } if min.z <= 0.0 => return [DVec2::NEG_INFINITY, DVec2::INFINITY],
        Projection::Perspective { .. } => ((low / min.z).min(low / max.z), (high / min.z).max(high / max.z)),
    };
    let focal = view.camera.focal_px(view.size[1]);
    let middle = view.middle();
    [middle + focal * DVec2::new(low.x, -high.y), middle + focal * DVec2::new(high.x, -low.y)]
}

/// Distance over radius; 1 for a radius of 0, where the point alone is its rim.
fn relative(distance: f64, radius: f64) -> f64 {
    if radius == 0.0 && distance == 0.0 { 1.0 } else { distance / radius }
}
