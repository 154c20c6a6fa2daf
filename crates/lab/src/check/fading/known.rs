//! Lists of few depths in float64, and how much roundings change them.

use glam::{DVec3, Vec3};

use crate::check::stage::{Dot, HALF_ULP, dot};
use pellucid_reference::moments::{Absorption, optical_depth, place_of, power_moments};
use pellucid_reference::wavelet::{self, places};
use pellucid_scene::{Method, Wavelet};

/// Discs of one depth, color and opacity.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Layer {
    /// Distance from the eye.
    pub depth: f32,
    /// Linear RGB.
    pub color: Vec3,
    /// Opacity of each disc.
    pub opacity: f32,
    /// Number of discs.
    pub count: u32,
}

/// The discs, color by color in turns, so that none comes after all others.
pub fn dots(layers: &[Layer]) -> Vec<Dot> {
    let most = layers.iter().map(|layer| layer.count).max().unwrap_or(0);
    let round = |i: u32| layers.iter().filter(move |layer| i < layer.count);
    (0..most).flat_map(round).map(|layer| dot(layer.depth.into(), layer.color, layer.opacity)).collect()
}

/// A method's pixel of layers at these depths, which are between near and far, by the reference: A ΣcαT / ΣαT.
fn pixel(layers: &[Layer], depths: &[f64], range: [f64; 2], method: &Method) -> [f64; 4] {
    let of_one = |layer: &Layer| optical_depth(layer.opacity.into());
    let absorbed = layers.iter().map(|layer| f64::from(layer.count) * of_one(layer));
    let exponents: Vec<f64> = match method {
        Method::Moments(settings) => {
            let pairs: Vec<_> = depths.iter().map(|z| place_of(*z, range)).zip(absorbed).collect();
            let absorption = Absorption::new(&power_moments(&pairs, settings.moments.get()), settings.bias().into());
            let share = |z: f64| absorption.share(z, settings.overestimation.into());
            pairs.iter().map(|(z, _)| -absorption.total * share(*z)).collect()
        }
        Method::Wavelet(Wavelet { rank, .. }) => {
            let pairs: Vec<_> = places(depths, range).into_iter().zip(absorbed).collect();
            let absorption = wavelet::Absorption::new(&pairs, *rank);
            pairs.iter().map(|(place, _)| -absorption.before(*place)).collect()
        }
        _ => vec![f64::NAN; layers.len()],
    };
    let most = exponents.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let weight = |layer: &Layer| f64::from(layer.count) * f64::from(layer.opacity);
    let weights: Vec<f64> = layers.iter().zip(&exponents).map(|(layer, e)| weight(layer) * (e - most).exp()).collect();
    let sum: DVec3 = layers.iter().zip(&weights).map(|(layer, w)| layer.color.as_dvec3() * *w).sum();
    let through: f64 = layers.iter().map(|layer| f64::from(layer.count) * (-f64::from(layer.opacity)).ln_1p()).sum();
    let alpha = -through.exp_m1();
    (alpha * sum / weights.iter().sum::<f64>()).extend(alpha).to_array()
}

/// The pixel in float64.
pub fn known(layers: &[Layer], range: [f32; 2], method: &Method) -> [f64; 4] {
    let depths: Vec<f64> = layers.iter().map(|layer| layer.depth.into()).collect();
    pixel(layers, &depths, range.map(f64::from), method)
}

/// The most that float32 may change a component of the pixel: each depth is off by what a logarithm of a ratio is,
/// equal ones alike, and the reference says what that does to the pixel. Everything behind it is in sums of two floats,
/// compensated or a few roundings.
pub fn bound(layers: &[Layer], range: [f32; 2], method: &Method) -> f64 {
    let range = range.map(f64::from);
    let depths: Vec<f64> = layers.iter().map(|layer| layer.depth.into()).collect();
    let whole = pixel(layers, &depths, range, method);
    let nearest = depths.iter().copied().fold(f64::INFINITY, f64::min);
    // A difference, a quotient, a sum, the logarithm of 2 units and its correction: six roundings, relative to the
    // logarithm. Wavelets take the ratio of two such, times the number of cells.
    let moved = |z: f64, sign: f64| match method {
        Method::Moments(_) => z * (range[1] / range[0]).powf(sign * 7.0 * HALF_ULP),
        _ => nearest * (z / nearest).powf(1.0 + sign * 14.0 * HALF_ULP),
    };
    let mut of_depths = 0.0;
    for (i, z) in depths.iter().enumerate() {
        if depths[..i].contains(z) {
            continue;
        }
        let change = |sign: f64| {
            let with = |other: &f64| if other == z { moved(*z, sign) } else { *other };
            let depths: Vec<f64> = depths.iter().map(with).collect();
            let pixel = pixel(layers, &depths, range, method);
            pixel.iter().zip(&whole).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
        };
        of_depths += change(1.0).max(change(-1.0));
    }
    let of_one = |layer: &Layer| f64::from(layer.count) * optical_depth(layer.opacity.into());
    let total: f64 = layers.iter().map(of_one).sum();
    // Shares of the optical depth have some twenty roundings, and are times it in an exponent. A mean of colors up to 1
    // changes by at most twice the relative error of its weights; ten roundings are those of sums, products and A.
    2.0 * of_depths + 2.0 * whole[3] * (total * 20.0 + 10.0) * HALF_ULP
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::check::stage::fragments;
    use pellucid_reference::moments::moments;
    use pellucid_reference::wavelet::wavelet;
    use pellucid_scene::{MomentCount, Moments};

    #[test]
    fn layers_are_what_their_discs_are() {
        let layer = |depth, color, count| Layer { depth, color, opacity: 0.125, count };
        let layers = [layer(1.0, Vec3::X, 3), layer(2.5, Vec3::Y, 1), layer(9.0, Vec3::Z, 2)];
        let dots = dots(&layers);
        assert_eq!(dots.len(), 6);
        let (list, colors) = fragments(&dots);
        let all = MomentCount::ALL.map(|moments| Method::Moments(Moments { moments, ..Moments::default() }));
        for method in all.into_iter().chain([1, 4].map(|rank| Method::Wavelet(Wavelet { rank, ..Wavelet::default() })))
        {
            let wanted = match &method {
                Method::Moments(settings) => moments(&list, &colors, [0.5, 20.0], settings),
                Method::Wavelet(Wavelet { rank, .. }) => wavelet(&list, &colors, [0.5, 20.0], *rank),
                other => panic!("{other:?}"),
            };
            let found = known(&layers, [0.5, 20.0], &method);
            for (a, b) in found.iter().zip(wanted.color.extend(wanted.alpha).to_array()) {
                assert!((a - b).abs() < 1e-12, "{method:?}: {found:?} {wanted:?}");
            }
            let bound = bound(&layers, [0.5, 20.0], &method);
            assert!(bound > 1e-7 && bound < 1e-2, "{method:?}: {bound}");
        }
    }
}
