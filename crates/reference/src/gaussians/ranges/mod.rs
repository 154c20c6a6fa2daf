//! Gaussians where roundings of float32 decide: the opacities and depths that a pixel may have.
//!
//! Errors are counted in roundings ([`ROUNDING`]), as the shaders compute: from the projected center, which is known as
//! a whole pixel and a rounded fraction of one, and from a few float32 numbers of each splat, linear in the offset of a
//! pixel ([`factor`]).

mod densest;
mod factor;

use glam::{DMat3, DVec2};

use self::factor::{Factor, MatrixRows};
use super::ewa::{Projected, thickened};
use super::{Gaussian, PlacedGaussian, is_orthographic, largest_rho2, ray};
use crate::View;
use crate::range::{ROUNDING, Range, screen_error};
use pellucid_scene::{GaussianSettings, Kernel, Order};

/// A pixel that a Gaussian may cover.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Possible {
    /// Column, from the left.
    pub x: u32,
    /// Row, from the top.
    pub y: u32,
    /// Opacity, if the pixel is covered.
    pub alpha: Range,
    /// Key that fragments are sorted by.
    pub key: Range,
    /// The depth along the viewing axis that an image shows.
    pub z: Range,
    /// False if roundings decide that the pixel is covered.
    pub sure: bool,
}

/// A pixel in which an ellipsoid may be met.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PossibleChord {
    /// Column, from the left.
    pub x: u32,
    /// Row, from the top.
    pub y: u32,
    /// Depth along the viewing axis of the chord's middle.
    pub middle: Range,
    /// Half of the chord as depth along the viewing axis. From 0 where roundings decide whether there is one.
    pub half: Range,
}

/// Returns the pixels in which an ellipsoid with a thickness may be met ([`super::ellipsoid`]). Near and far have to be
/// clear of its center's depth.
pub fn possible_chords(view: View, gaussian: &Gaussian, settings: &GaussianSettings) -> Vec<PossibleChord> {
    let Some(placed) = PlacedGaussian::new(view, gaussian) else { return Vec::new() };
    let found = Bounded::new(&placed, settings, Order::Pixel);
    // Errors of a large share of the whole may put it anywhere.
    let fine = found.depth_factor.as_ref().is_some_and(|factor| factor.epsilon < 0.01);
    let window = if fine { ray::bounds(&placed, 1.1) } else { [DVec2::NEG_INFINITY, DVec2::INFINITY] };
    let chord = |[x, y]: [u32; 2]| {
        let (offset, screen) = found.offset([x, y]);
        let densest::Chord { middle, half } = densest::chord(&found, offset, screen)?;
        Some(PossibleChord { x, y, middle, half })
    };
    placed.window(window).filter_map(chord).collect()
}

/// Roundings in an opacity over itself, in addition to those of ρ²: two in the exponential, one in its product with the
/// opacity, up to five in the opacity's factor for the dilation.
const ALPHA: f64 = 8.0;

/// Roundings in a distance from the eye: of a sum of squares, its root, and the three coordinates.
const DISTANCE: f64 = 6.0;

/// Returns the pixels of some rows that a Gaussian may cover ([`super::footprint`]). Near and far have to be clear of
/// its center's depth.
pub fn possible(
    view: View,
    gaussian: &Gaussian,
    settings: &GaussianSettings,
    order: Order,
    rows: std::ops::Range<u32>,
) -> Vec<Possible> {
    let Some(placed) = PlacedGaussian::new(view, gaussian) else { return Vec::new() };
    let found = Bounded::new(&placed, settings, order);
    let Some(window) = found.window() else { return Vec::new() };
    let inside = placed.window(window).filter(|[_, y]| rows.contains(y));
    inside.filter_map(|pixel| found.possible(pixel)).collect()
}

/// A Gaussian with the errors of its numbers.
struct Bounded<'a> {
    placed: &'a PlacedGaussian<'a>,
    settings: &'a GaussianSettings,
    order: Order,
    projected: Projected,
    opacity: Range,
    /// Factor that the kernel's ρ² comes from; `None` where roundings leave nothing of it.
    factor: Option<Factor>,
    /// Axes that a ray meets: its own axes (`ray`), thickened ones (`ewa`).
    depth_axes: DMat3,
    depth_factor: Option<Factor>,
}

impl<'a> Bounded<'a> {
    fn new(placed: &'a PlacedGaussian<'a>, settings: &'a GaussianSettings, order: Order) -> Self {
        let projected = Projected::new(placed, settings);
        let depth_axes = if settings.kernel == Kernel::Ewa { thickened(placed.axes) } else { placed.axes };
        let columns = densest::columns(placed, depth_axes);
        let depth_factor = Factor::new(MatrixRows::new(columns, densest::errors(placed, depth_axes), 0.0));
        let errors = errors(placed, placed.axes, projected.slope);
        let rows = |dilation: f64| MatrixRows::new(projected.columns, errors, dilation);
        let (factor, opacity) = match settings.kernel {
            Kernel::Ewa if settings.antialias && projected.dilation > 0.0 => {
                let factor = dilation_factor(&rows(0.0), &rows(projected.dilation));
                (Factor::new(rows(projected.dilation)), factor.scaled(placed.opacity))
            }
            Kernel::Ewa => (Factor::new(rows(projected.dilation)), Range::only(placed.opacity)),
            Kernel::Ray | Kernel::Ellipsoid => (None, Range::only(placed.opacity)),
        };
        Self { placed, settings, order, projected, opacity, factor, depth_axes, depth_factor }
    }

    /// The box on the screen outside of which no pixel is possible; `None` if none is anywhere.
    fn window(&self) -> Option<[DVec2; 2]> {
        let everything = Some([DVec2::NEG_INFINITY, DVec2::INFINITY]);
        let rho2 = largest_rho2(self.opacity.high, self.settings) + ALPHA * ROUNDING;
        if rho2.is_nan() || rho2 < 0.0 {
            return None;
        }
        match (self.settings.kernel, &self.factor, &self.depth_factor) {
            (Kernel::Ewa, Some(factor), _) => {
                let [low, high] = self.projected.bounds(rho2);
                let most = rho2.sqrt() * (1.0 + 2.0 * factor.epsilon) + 2.0 * factor.most_error(0.5 * (high - low));
                Some(self.projected.bounds(most * most))
            }
            // ρ² of pixels outside is 1.5 times as large and more, and errors of so small a share of it don't matter.
            (Kernel::Ray, _, Some(factor)) if factor.epsilon < 0.01 => Some(ray::bounds(self.placed, 1.5 * rho2 + 1.0)),
            _ => everything,
        }
    }

    /// Returns the offset from the projected center to a pixel's, and the error of that.
    fn offset(&self, [x, y]: [u32; 2]) -> (DVec2, DVec2) {
        let place = DVec2::new(f64::from(x), f64::from(y)) + 0.5;
        let size = self.placed.view.size;
        let screen = DVec2::from([0, 1].map(|axis| screen_error(self.projected.center[axis], size[axis])));
        (place - self.projected.center, screen)
    }

    fn possible(&self, [x, y]: [u32; 2]) -> Option<Possible> {
        let (offset, screen) = self.offset([x, y]);
        let by_ray = self.settings.kernel == Kernel::Ray;
        let densest = if by_ray || self.order == Order::Pixel {
            densest::range(self, offset, screen)
        } else {
            densest::Possible::ANYTHING
        };
        let rho2 = match &self.factor {
            _ if by_ray => densest.rho2,
            Some(factor) => factor.meet(offset, screen).rho2,
            None => densest::Possible::ANYTHING.rho2,
        };
        let (alpha, mut sure) = self.alpha(rho2)?;
        if by_ray {
            let (near, far) = (self.placed.view.camera.near, self.placed.view.camera.far);
            if densest.depth.high < near || densest.depth.low > far {
                return None;
            }
            sure &= densest.depth.low >= near && densest.depth.high <= far;
        }
        let center = Range::depth(self.placed.center.z);
        let (key, z) = match self.order {
            Order::Center => (center, center),
            Order::Distance if is_orthographic(self.placed.view.camera) => (center, center),
            Order::Distance => {
                (Range::around(self.placed.distance, DISTANCE * ROUNDING * self.placed.distance), center)
            }
            Order::Pixel => (densest.depth, densest.depth),
        };
        Some(Possible { x, y, alpha, key, z, sure })
    }

    /// α, and whether it is enough for sure; `None` if it is not.
    fn alpha(&self, rho2: Range) -> Option<(Range, bool)> {
        let [least, most] = [self.settings.alpha_min, self.settings.alpha_max].map(f64::from);
        let of = |opacity: f64, rho2: f64, sign: f64| {
            (opacity * (-0.5 * rho2).exp() * (1.0 + sign * ALPHA * ROUNDING)).min(most)
        };
        let alpha = Range { low: of(self.opacity.low, rho2.high, -1.0), high: of(self.opacity.high, rho2.low, 1.0) };
        // Where ρ² ends decides, not α, which then has the roundings of an exponent of ln(o / least), and its own.
        let ends = least * (1.0 - ROUNDING * (ALPHA + largest_rho2(self.opacity.high, self.settings).max(0.0)));
        (alpha.high >= least).then(|| (Range { low: alpha.low.max(ends), ..alpha }, alpha.low >= least))
    }
}

/// Errors of the columns of J M, where J goes along this slope.
fn errors(placed: &PlacedGaussian, axes: DMat3, slope: DVec2) -> [DVec2; 3] {
    let scale = placed.view.pixels_per_unit(placed.center.z);
    let most = factor::AXIS * ROUNDING * scale * (DVec2::ONE + slope.abs());
    [0, 1, 2].map(|k| axes.col(k).length() * most)
}

/// The factor of the opacity for the dilation: the root of the ratio of two determinants.
fn dilation_factor(bare: &MatrixRows, dilated: &MatrixRows) -> Range {
    let [(below, below_error), (above, above_error)] = [dilated, bare].map(MatrixRows::determinant);
    let factor = super::ewa::dilation_factor;
    let high = if below > below_error { factor((above + above_error) / (below - below_error)) } else { 1.0 };
    Range { low: factor((above - above_error).max(0.0) / (below + below_error)), high }
}
