//! Several Gaussians and discs in a pixel, where roundings decide neither coverage nor order.
//!
//! The error is a difference of color or opacity from float64 over the most that is derived for that pixel, so that the
//! bound is 1.

use super::splats::SplatView;
use pellucid_reference::range::Range;
use pellucid_reference::{abuffer, coverage, gaussians, shading};
use pellucid_scene::{DiscShape, Shading};

use super::alone::Shares;
use crate::check::prelude::*;

/// Roundings in a color: a base of 0 or 1 and its curve, whose power multiplies two roundings and those of its
/// logarithm.
const COLOR: f64 = 16.0;

/// A scene in float64.
pub struct Float64Scene<'a> {
    pub view: SplatView,
    pub points: &'a Points,
    pub color: ColorSpace,
}

impl Float64Scene<'_> {
    /// Pixels of the scene's float64 reference.
    pub fn pixels(&self) -> Vec<[f64; 4]> {
        let Self { view: SplatView { camera, size, settings }, points, color } = self;
        let colors: Vec<DVec3> = shading::shade(points, camera, &Shading::NONE, *color);
        let discs = Discs { gaussians: *settings, ..Discs::default() };
        abuffer::render(View::new(camera, *size), points, &colors, &discs).rgba
    }

    /// The fragments that each pixel may have: what they are ordered by, their opacity, and whether they are there for
    /// sure.
    fn fragments(&self) -> Vec<Vec<(Range, Range, bool)>> {
        let SplatView { camera, size, settings } = &self.view;
        let order = settings.order.unwrap_or(Order::Pixel);
        let mut lists = vec![Vec::new(); (size[0] * size[1]) as usize];
        for index in 0..self.points.len() {
            if let Some(gaussian) = gaussians::gaussian(self.points, index) {
                for found in gaussians::possible(View::new(camera, *size), &gaussian, settings, order, 0..size[1]) {
                    lists[(found.y * size[0] + found.x) as usize].push((found.key, found.alpha, found.sure));
                }
                continue;
            }
            let splat = abuffer::splat(self.points, index, DiscShape::Flat);
            // To the hundredth of a pixel nobody errs.
            let sure = coverage::margin_px(View::new(camera, *size), &splat) > 0.01;
            let opacity = Range::only(self.points.opacities[index].into());
            for found in coverage::footprint(View::new(camera, *size), &splat) {
                lists[(found.y * size[0] + found.x) as usize].push((Range::depth(found.z), opacity, sure));
            }
        }
        lists
    }

    /// The most that each component of a pixel is off by; `None` where roundings decide coverage or order.
    ///
    /// An opacity that is off by e changes what it mixes by as much, since colors are within 0 and 1.
    fn bounds(&self, method: &Method) -> Vec<Option<f64>> {
        let bound = |mut list: Vec<(Range, Range, bool)>| {
            list.sort_by(|(a, ..), (b, ..)| a.low.total_cmp(&b.low));
            let in_order = list.windows(2).all(|pair| pair[0].0.high < pair[1].0.low);
            let sure = list.iter().all(|(.., sure)| *sure);
            let off: f64 = list.iter().map(|(_, alpha, _)| alpha.high - alpha.low).sum();
            (in_order && sure).then(|| off + (roundings(method, list.len().max(1)) + COLOR) * HALF_ULP)
        };
        self.fragments().into_iter().map(bound).collect()
    }

    /// Renders it and compares what is clear, of which there must be two thirds of the image; `naive` are the pixels of
    /// another formula.
    pub fn compare(&self, stage: &mut CaseRenderer, method: Method, naive: &[[f64; 4]]) -> Result<Shares> {
        let frame = Frame { color: self.color, ..self.view.frame(method) };
        let image = stage.render(self.points, &frame)?.image;
        let (wanted, bounds) = (self.pixels(), self.bounds(&method));
        let mut shares = Shares::NOTHING;
        for (pixel, bound) in bounds.iter().enumerate() {
            let Some(bound) = bound else { continue };
            let off = |found: [f64; 4]| {
                let apart = found.iter().zip(wanted[pixel]).map(|(found, wanted)| (found - wanted).abs());
                apart.fold(0.0, |most, off| if off.is_nan() { f64::INFINITY } else { off.max(most) }) / bound
            };
            shares = shares.larger(Shares { found: off(image.rgba[pixel].map(f64::from)), naive: off(naive[pixel]) });
        }
        let clear = bounds.iter().flatten().count();
        Ok(if 3 * clear < 2 * bounds.len() { Shares { found: f64::INFINITY, ..shares } } else { shares })
    }
}
