//! Approximations of transparency in float64: methods whose image does not need all fragments of a pixel in order.
//!
//! Each composes the fragments of [`super::abuffer::lists`], those with α = 0 included, near to far.

use glam::DVec3;

use super::abuffer::lists;
use super::fragments::{Composite, Fragment, composite, coverage, nearest, place};
use super::{ReferencePicture, View, gaussians, mlab, moments, wavelet};
use pellucid_core::points::Points;
use pellucid_scene::{Hybrid, Method, Mlab, Moments, Tail, Wavelet};

/// Σwᵢcᵢ / Σwᵢ of the fragments with a weight, black if none has.
fn mean(list: &[Fragment], colors: &[DVec3], weight: impl Fn(&Fragment) -> f64) -> DVec3 {
    let total: f64 = list.iter().map(&weight).sum();
    let sum: DVec3 = list.iter().map(|f| colors[f.index as usize] * weight(f)).sum();
    if total > 0.0 { sum / total } else { DVec3::ZERO }
}

/// Returns the weight of opacity at a depth (McGuire and Bavoil 2013, Eq. 10): max(10⁻², 3·10³·(1−d)³), d =
/// (z−near)/(far−near) within [0, 1].
pub fn weight(z: f64, [near, far]: [f64; 2]) -> f64 {
    let d = ((z - near) / (far - near)).clamp(0.0, 1.0);
    (3e3 * (1.0 - d).powi(3)).max(1e-2)
}

/// Weighted blending (McGuire and Bavoil 2013): color Σwαc / Σwα, A = 1 − ∏(1−α).
pub fn weighted(list: &[Fragment], colors: &[DVec3], depth_range: [f64; 2]) -> Composite {
    let alpha = coverage(list);
    let color = mean(list, colors, |f| weight(f.z, depth_range) * f.alpha);
    Composite { color: alpha * color, alpha, depth: nearest(list) }
}

/// Returns the naive picture (Tanaka et al. 2016, Fig. 6): the mean color of all fragments regardless of opacity;
/// opaque where at least one exists.
pub fn average(list: &[Fragment], colors: &[DVec3]) -> Composite {
    let alpha = if list.is_empty() { 0.0 } else { 1.0 };
    Composite { color: mean(list, colors, |_| 1.0), alpha, depth: nearest(list) }
}

/// Blended over one another in the order of `places`, where in the files each point stood: later over earlier.
pub fn unsorted(list: &[Fragment], colors: &[DVec3], places: &[u32]) -> Composite {
    let mut by_place = list.to_vec();
    by_place.sort_by_key(|f| place(f, places));
    let color =
        by_place.iter().fold(DVec3::ZERO, |below, f| f.alpha * colors[f.index as usize] + (1.0 - f.alpha) * below);
    Composite { color, alpha: coverage(list), depth: nearest(list) }
}

/// Hybrid transparency (Maule et al. 2013): the first k fragments composed exactly, and behind them a tail of color
/// Σαc / Σα and coverage 1 − ∏(1−α). Of fragments fainter than `core_alpha_min` all are in the tail, wherever they lie
/// (Hahlbohm et al. 2025).
pub fn hybrid(list: &[Fragment], colors: &[DVec3], k: u32, core_alpha_min: f64) -> Composite {
    hybrid_before(list, colors, (k, core_alpha_min), |tail| coverage(tail) * mean(tail, colors, |f| f.alpha))
}

/// Returns the same before a tail whose premultiplied color a function finds from its fragments.
pub fn hybrid_before(
    list: &[Fragment],
    colors: &[DVec3],
    (k, core_alpha_min): (u32, f64),
    tail_color: impl Fn(&[Fragment]) -> DVec3,
) -> Composite {
    let (mut front, mut tail) = (Vec::new(), Vec::new());
    for fragment in list {
        let exact = front.len() < k as usize && fragment.alpha >= core_alpha_min;
        if exact { front.push(*fragment) } else { tail.push(*fragment) }
    }
    let front = composite(&front, colors);
    let through = 1.0 - front.alpha;
    Composite { color: front.color + through * tail_color(&tail), alpha: coverage(list), depth: nearest(list) }
}

/// Returns the whole image by one of the methods of this module, or by `mlab`, `moments` or `wavelet`; `None` for
/// others. `colors` holds a color for each point, shaded and in the space that blending runs in
/// ([`super::shading::shade`]).
pub fn render(view: View, points: &Points, colors: &[DVec3], method: &Method) -> Option<ReferencePicture> {
    let discs = method.discs()?;
    let lists = lists(view, points, discs);
    let range = [view.camera.near, view.camera.far];
    let with_depths = |list: &[Fragment]| gaussians::with_depths(view.camera, points, &discs.gaussians, list);
    let pixel = |list: &Vec<Fragment>| match method {
        Method::Weighted(_) => Some(weighted(list, colors, range)),
        Method::Average(_) => Some(average(list, colors)),
        Method::Unsorted(_) => Some(unsorted(list, colors, &points.file_order)),
        Method::Hybrid(Hybrid { k, core_alpha_min, tail: Tail::Average, .. }) => {
            Some(hybrid(list, colors, *k, (*core_alpha_min).into()))
        }
        Method::Hybrid(Hybrid { k, core_alpha_min, tail: Tail::Moments, moments: count, .. }) => {
            let settings = Moments { moments: *count, ..Moments::default() };
            let color = |tail: &[Fragment]| moments::moments(&with_depths(tail), colors, range, &settings).color;
            Some(hybrid_before(list, colors, (*k, (*core_alpha_min).into()), color))
        }
        Method::Mlab(Mlab { nodes, .. }) => Some(mlab::mlab(list, colors, &points.file_order, *nodes)),
        Method::Moments(settings) => Some(moments::moments(&with_depths(list), colors, range, settings)),
        Method::Wavelet(Wavelet { rank, .. }) => Some(wavelet::wavelet(&with_depths(list), colors, range, *rank)),
        _ => None,
    };
    let shown = |list: &[Fragment], key| gaussians::depth_of_key(view.camera, points, &discs.gaussians, list, key);
    let finished =
        |list| pixel(list).map(|found| (Composite { depth: shown(list, found.depth), ..found }, list.len() as u32));
    Some(ReferencePicture::of(view.size, lists.iter().map(finished).collect::<Option<Vec<_>>>()?))
}
