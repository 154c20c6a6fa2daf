//! Place at which a Gaussian is densest along a ray, as far as float32 can tell.
//!
//! With the columns of P for the kernel `ray`, J not clamped and nothing dilated, Y = P⁺d is where the ray would meet
//! the plane of the rows of P, were it parallel to the one through the center. Let r hold the depths of the axes, n the
//! unit normal of that plane, z the center's depth. Then with w = 1 − r·Y/z and D = w² + (n·r/z)²|Y|² the ray has ρ² =
//! |Y|²/D at the depth z w/D. Orthographic rays are parallel, so that ρ² = |Y|² and the depth is z + r·Y.

use glam::{DMat3, DVec2, DVec3};

use super::super::PlacedGaussian;
use super::factor::{AXIS, Factor, Met};
use super::{Bounded, is_orthographic};
use crate::range::{DEPTH_ERROR, ROUNDING, Range};

/// Range that float32 may make of [`super::super::ray::Densest`].
#[derive(Clone, Copy)]
pub(super) struct Possible {
    pub rho2: Range,
    pub depth: Range,
}

impl Possible {
    /// Range where roundings leave nothing.
    pub const ANYTHING: Self = Self {
        rho2: Range { low: 0.0, high: f64::INFINITY },
        depth: Range { low: f64::NEG_INFINITY, high: f64::INFINITY },
    };
}

/// The slope of the ray through the center.
fn slope(placed: &PlacedGaussian) -> DVec2 {
    if is_orthographic(placed.view.camera) { DVec2::ZERO } else { placed.center.truncate() / placed.center.z }
}

/// Returns the columns of P for these axes in camera coordinates, in pixels to the right and down.
pub(super) fn columns(placed: &PlacedGaussian, axes: DMat3) -> [DVec2; 3] {
    let scale = placed.view.pixels_per_unit(placed.center.z);
    let slope = slope(placed);
    [0, 1, 2].map(|k| {
        let axis = axes.col(k);
        scale * DVec2::new(1.0, -1.0) * (axis.truncate() - slope * axis.z)
    })
}

/// Errors of these columns.
pub(super) fn errors(placed: &PlacedGaussian, axes: DMat3) -> [DVec2; 3] {
    super::errors(placed, axes, slope(placed))
}

/// The range in which float32 leaves a chord through an ellipsoid, as depths along the viewing axis.
#[derive(Clone, Copy)]
pub(super) struct Chord {
    pub middle: Range,
    /// Half its length; from 0 where roundings decide whether there is one.
    pub half: Range,
}

/// The numbers of a ray at an offset.
struct Line {
    met: Met,
    /// r·Y and its error.
    along: Range,
    /// w, |n·r/z| and D; of parallel rays 1, |n·r| and 1.
    w: Range,
    across: Range,
    shared: Range,
}

/// Returns the line at an offset in pixels from the projected center; `None` where roundings leave nothing.
fn line(bounded: &Bounded, offset: DVec2, screen_error: DVec2) -> Option<Line> {
    let factor = bounded.depth_factor.as_ref()?;
    let (u, z) = (ROUNDING, bounded.placed.center.z);
    let met = factor.meet(offset, screen_error);
    let rows = bounded.depth_axes.transpose();
    let r = rows.z_axis;
    let lengths = DVec3::from([0, 1, 2].map(|k| bounded.depth_axes.col(k).length()));
    let turned = r.length() * (2.0 * factor.tilt() + 16.0 * u);
    let along = r.dot(met.nearest);
    let along_error = within(factor, r) * met.error
        + met.length * turned
        + u * (AXIS * lengths.dot(met.nearest.abs()) + 4.0 * r.length() * met.length);
    let along = Range::around(along, along_error);
    let parallel = is_orthographic(bounded.placed.view.camera);
    let over = if parallel { 1.0 } else { z };
    let across = across(factor, r) / over;
    let across = Range::around(across, (turned + AXIS * u * lengths.length()) / over + 4.0 * u * across);
    let across = Range { low: across.low.max(0.0), high: across.high };
    if parallel {
        return Some(Line { met, along, w: Range::only(1.0), across, shared: Range::only(1.0) });
    }
    let middle = 0.5 * (along.low + along.high);
    let w = Range::around(1.0 - middle / z, along_error / z + 4.0 * u * (1.0 + middle.abs() / z));
    let shared = squared(w) + across.times(across).times(met.rho2);
    let shared = Range { low: shared.low * (1.0 - 6.0 * u), high: shared.high * (1.0 + 6.0 * u) };
    Some(Line { met, along, w, across, shared })
}

/// Returns the possible values at an offset in pixels from the projected center.
pub(super) fn range(bounded: &Bounded, offset: DVec2, screen_error: DVec2) -> Possible {
    let Some(Line { met, along, w, shared, .. }) = line(bounded, offset, screen_error) else {
        return Possible::ANYTHING;
    };
    let (u, z) = (ROUNDING, bounded.placed.center.z);
    if is_orthographic(bounded.placed.view.camera) {
        let depth = along + Range::only(z);
        return Possible { rho2: met.rho2, depth: depth.widened(DEPTH_ERROR * z.abs() + u * depth.high.abs()) };
    }
    Possible { rho2: quotient(met.rho2, shared, 4.0 * u), depth: depth(z, w, shared) }
}

/// Returns the chord of the ellipsoid of ρ² = 1 at an offset; `None` where there is none for sure. With D of parallel
/// rays 1, half of it goes through the depth |n·r| √(D − |Y|²) / D.
pub(super) fn chord(bounded: &Bounded, offset: DVec2, screen_error: DVec2) -> Option<Chord> {
    let placed = bounded.placed;
    let (u, z) = (ROUNDING, placed.center.z);
    let Some(Line { met, along, w, across, shared }) = line(bounded, offset, screen_error) else {
        return Some(Chord { middle: Possible::ANYTHING.depth, half: Possible::ANYTHING.rho2 });
    };
    // D − |Y|² = w² + (t² − 1)|Y|², whose first rounding is of the larger of the two.
    let rest = if is_orthographic(placed.view.camera) {
        Range { low: 1.0 - met.rho2.high, high: 1.0 - met.rho2.low }
    } else {
        let steep = across.times(across);
        let [least, most] = [steep.low - 1.0, steep.high - 1.0];
        let Range { low, high } = met.rho2;
        let ends = [least * low, least * high, most * low, most * high];
        squared(w) + Range::spanning(ends)
    };
    let rest = rest.widened(6.0 * u * (shared.high + met.rho2.high));
    if rest.high < 0.0 {
        return None;
    }
    let root = Range { low: rest.low.max(0.0).sqrt(), high: rest.high.sqrt() };
    let over = if is_orthographic(placed.view.camera) { 1.0 } else { z };
    let half = quotient(across.scaled(over).times(root), shared, 8.0 * u);
    let middle = range(bounded, offset, screen_error).depth;
    // Relative to the center: what is added to it has roundings of its own.
    let own = 8.0 * u * (along.low.abs().max(along.high.abs()) + half.high);
    Some(Chord { middle: middle.widened(own), half })
}

/// The length of r within the plane of the rows.
fn within(factor: &Factor, r: DVec3) -> f64 {
    let [a, b] = factor.directions();
    a.dot(r).hypot(b.dot(r))
}

/// |n·r|.
fn across(factor: &Factor, r: DVec3) -> f64 {
    let [a, b] = factor.directions();
    a.cross(b).dot(r).abs()
}

/// z w / D with seven roundings and those of z.
fn depth(z: f64, w: Range, shared: Range) -> Range {
    if shared.low <= 0.0 {
        return Possible::ANYTHING.depth;
    }
    let all = [w.low / shared.low, w.low / shared.high, w.high / shared.low, w.high / shared.high].map(|part| z * part);
    let all = Range::spanning(all);
    all.widened((DEPTH_ERROR + 5.0 * ROUNDING) * all.low.abs().max(all.high.abs()))
}

/// The square of a number of any sign.
fn squared(w: Range) -> Range {
    let (a, b) = (w.low * w.low, w.high * w.high);
    Range { low: if w.low <= 0.0 && w.high >= 0.0 { 0.0 } else { a.min(b) }, high: a.max(b) }
}

/// A quotient of numbers that are not negative, with a relative error.
fn quotient(above: Range, below: Range, error: f64) -> Range {
    Range { low: above.low / below.high * (1.0 - error), high: above.high / below.low * (1.0 + error) }
}
