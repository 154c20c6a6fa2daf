//! Each Gaussian by itself: pixel by pixel against what roundings of float32 leave of float64.
//!
//! The error is a difference of opacity or depth from float64 over the most that is derived for that pixel, so that the
//! bound is 1.

use super::super::naive::gaussians::Seen;
use super::splats::{Splat, SplatView, cloud};
use crate::check::prelude::*;
use pellucid_reference::gaussians::{self, Hit};
use pellucid_reference::range::Range;

/// Facts about a pixel that a Gaussian may cover.
#[derive(Debug, Clone, Copy)]
pub struct Known {
    /// Opacity and depth without roundings; `None` where the Gaussian has no fragment.
    pub exact: Option<(f64, f64)>,
    /// Possible opacities.
    pub alpha: Range,
    /// Possible depths.
    pub depth: Range,
    /// False if roundings decide whether there is a fragment.
    pub sure: bool,
}

/// A Gaussian's image as far as it is known; `None` where nothing can be.
pub struct Expected(pub Vec<Option<Known>>);

/// Largest errors of the device and of a naive formula over the pixels of some Gaussians, as shares of the allowed
/// error.
#[derive(Debug, Clone, Copy)]
pub struct Shares {
    /// Error of the device.
    pub found: f64,
    /// Error of the formula.
    pub naive: f64,
}

impl Shares {
    /// Shares of no pixel.
    pub const NOTHING: Self = Self { found: 0.0, naive: 0.0 };

    /// The larger ones.
    pub fn larger(self, other: Self) -> Self {
        Self { found: self.found.max(other.found), naive: self.naive.max(other.naive) }
    }

    /// Combines two naive formulas: the larger error of the device, and the smaller one of the formulas.
    pub fn and(self, other: Self) -> Self {
        Self { found: self.found.max(other.found), naive: self.naive.min(other.naive) }
    }

    /// Returns the shares as the finding of a case.
    pub fn finding(self) -> Finding {
        Finding::new(self.found, 1.0, self.naive)
    }
}

impl Expected {
    /// Computes the expected image with the float64 reference.
    fn new(view: &SplatView, splat: &Splat, method: &Method) -> Option<Self> {
        let gaussian = gaussians::gaussian(&cloud(std::slice::from_ref(splat)), 0)?;
        let order = view.settings.order.unwrap_or(Order::Pixel);
        let (camera, size) = (&view.camera, view.size);
        let at = |x: u32, y: u32| (y * size[0] + x) as usize;
        let mut pixels = vec![None; (size[0] * size[1]) as usize];
        for possible in gaussians::possible(View::new(camera, size), &gaussian, &view.settings, order, 0..size[1]) {
            // A list of one.
            let alpha = possible.alpha.widened(roundings(method, 1) * HALF_ULP * possible.alpha.high);
            let known = Known { exact: None, alpha, depth: possible.z, sure: possible.sure };
            pixels[at(possible.x, possible.y)] = Some(known);
        }
        for Hit { x, y, alpha, z, .. } in
            gaussians::footprint(View::new(camera, size), &gaussian, &view.settings, order)
        {
            // A pixel that the ranges lack is an error of theirs, and no image passes it.
            let nothing = Known { exact: None, alpha: Range::only(f64::NAN), depth: Range::only(f64::NAN), sure: true };
            pixels[at(x, y)].get_or_insert(nothing).exact = Some((alpha, z));
        }
        Some(Self(pixels))
    }

    /// Pixels of which much is known.
    pub fn clear(&self) -> usize {
        let is_clear = |known: &&Known| known.sure && known.alpha.high - known.alpha.low < 0.1;
        self.0.iter().flatten().filter(is_clear).count()
    }

    /// The largest error of some pixels, over what is allowed there.
    pub fn share(&self, found: &[Seen]) -> f64 {
        let shares = self.0.iter().zip(found).map(|(known, seen)| match known {
            None if seen.alpha == 0.0 => 0.0,
            None => f64::INFINITY,
            Some(known) => known.share(seen),
        });
        shares.fold(0.0, f64::max)
    }
}

impl Known {
    fn share(&self, seen: &Seen) -> f64 {
        let alpha = f64::from(seen.alpha);
        let wrong_if = |wrong: bool| if wrong { f64::INFINITY } else { 0.0 };
        match self.exact {
            _ if alpha == 0.0 => wrong_if(self.sure),
            None => wrong_if(!self.alpha.covers(alpha, 0.0)),
            Some((exact, depth)) => {
                let of_depth = seen.depth.map_or(0.0, |found| share(found.into(), depth, self.depth));
                share(alpha, exact, self.alpha).max(of_depth)
            }
        }
    }
}

/// The distance of a number from the exact one over the most that it may have on that side.
fn share(found: f64, exact: f64, range: Range) -> f64 {
    let off = found - exact;
    let allowed = if off > 0.0 { range.high - exact } else { exact - range.low };
    match off.abs() / allowed {
        _ if off == 0.0 => 0.0,
        share if share.is_nan() || share < 0.0 => f64::INFINITY,
        share => share,
    }
}

/// Returns the pixels that a device drew.
pub fn seen(image: &Image) -> Vec<Seen> {
    let pixels = image.rgba.iter().zip(&image.depth);
    pixels.map(|(rgba, depth)| Seen { alpha: rgba[3], depth: Some(*depth) }).collect()
}

/// Renders Gaussians one by one. `least`: so many pixels of all of them must be clear, or nothing is known.
pub fn alone(
    stage: &mut CaseRenderer,
    method: Method,
    view: &SplatView,
    splats: &[Splat],
    least: usize,
    naive: impl Fn(&Splat) -> Vec<Seen>,
) -> Result<Shares> {
    let expected = |splat: &Splat| Expected::new(view, splat, &method);
    compared(stage, method, view, splats, least, expected, naive)
}

/// Renders Gaussians one by one as [`alone`] does, with expectations of the caller.
pub fn compared(
    stage: &mut CaseRenderer,
    method: Method,
    view: &SplatView,
    splats: &[Splat],
    least: usize,
    expected: impl Fn(&Splat) -> Option<Expected>,
    naive: impl Fn(&Splat) -> Vec<Seen>,
) -> Result<Shares> {
    let (mut shares, mut clear) = (Shares::NOTHING, 0);
    for splat in splats {
        let Some(expected) = expected(splat) else { continue };
        let image = stage.render(&cloud(std::slice::from_ref(splat)), &view.frame(method))?.image;
        shares.found = shares.found.max(expected.share(&seen(&image)));
        shares.naive = shares.naive.max(expected.share(&naive(splat)));
        clear += expected.clear();
    }
    if clear < least {
        shares.found = f64::INFINITY;
    }
    Ok(shares)
}
