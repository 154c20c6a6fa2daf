//! Cases of a single sphere or a single disc: densities, distances of the ray and radii at their limits.

use std::f64::consts::{E, PI};

use super::{CaseResult, DISTANCE, INTEGRAL, against_float64, beside, bound, lambda, opacity, truth, wide};
use crate::check::prelude::*;
use pellucid_reference::soft::density::antiderivative;
use pellucid_scene::{Density, Shells, Soft, SoftLayout, SoftMethod};

/// The integral of ρ over a whole chord.
fn chord(radius: f64, distance: f64) -> f64 {
    2.0 * antiderivative(radius, distance, ((radius - distance) * (radius + distance)).sqrt())
}

fn relative(found: f32, wanted: f64) -> f64 {
    apart(&[found], &[wanted]) / wanted
}

pub(super) fn faint(stage: &mut CaseRenderer, method: SoftMethod) -> CaseResult {
    let dots = [Dot { color: Vec3::ONE, ..beside(0, 0.3, 10.0, 1.0) }];
    let method = lambda(method, 1e-6);
    let wanted = truth(&dots, &pixels([1, 1]), [1, 1], method)[0][3];
    let found = stage.pixel(&dots, method)?[3];
    let depth = -(-wanted).ln_1p() as f32;
    // d(depth)/depth is at most 4 of the relative error of d here, where d = 0.3 r.
    let bound = INTEGRAL + 4.0 * DISTANCE + 8.0 * ULP;
    Ok(Finding::new(relative(found, wanted), bound, relative(1.0 - (-depth).exp(), wanted)))
}

pub(super) fn dense(stage: &mut CaseRenderer, method: SoftMethod) -> CaseResult {
    let edges = [1e-2, 3e-3, 1e-3, 5e-4, 2e-4, 1e-4, 3e-5, 1e-5];
    let sphere = |(x, edge): (u32, &f64)| beside(x, 0.25 * (1.0 - edge), 1000.0, 0.25);
    let dots: Vec<Dot> = (0..).zip(&edges).map(sphere).collect();
    let (size, method) = ([8, 1], lambda(method, 1e6));
    // Placed in two floats: the distance from the rim is rounded as such, a few times, and counts to the power 1.5.
    let bound = (INTEGRAL + 1.5 * 16.0 * ULP) / E + 8.0 * ULP;
    against_float64(stage, &dots, (pixels(size), size), method, bound, naive::Soft::new(1e6))
}

pub(super) fn through_center(stage: &mut CaseRenderer, method: SoftMethod) -> CaseResult {
    let distances = [0.0, 1e-40, 1e-30, 1e-20, 1e-10, 1e-6, 1e-4, 1e-3];
    let dots: Vec<Dot> = (0..).zip(&distances).map(|(x, d)| beside(x, *d, 10.0, 0.25)).collect();
    let size = [8, 1];
    let naive = naive::Soft::new(16.0);
    against_float64(stage, &dots, (pixels(size), size), lambda(method, 16.0), bound(1, 16.0, 0.25), naive)
}

pub(super) fn grazing(stage: &mut CaseRenderer, method: SoftMethod) -> CaseResult {
    let dots = [beside(0, 0.25 * (1.0 - 1e-4), 1000.0, 0.25)];
    let wanted = truth(&dots, &pixels([1, 1]), [1, 1], method)[0][3];
    let found = stage.pixel(&dots, method)?[3];
    let naive = naive::Soft::new(1.0).pixel(&dots, &pixels([1, 1]), [1, 1], [0, 0])[3];
    // The error of d over r - d, to the power 1.5.
    let bound = 1.5 * DISTANCE / 1e-4;
    Ok(Finding::new(relative(found, wanted), bound, relative(naive, wanted)))
}

/// A sphere of radius 1, cut by near and a solid point behind it: its visible part, and the result of the naive
/// formula.
pub(super) fn segment(stage: &mut CaseRenderer, method: SoftMethod, near: f64, center: f64) -> CaseResult {
    let length = 2f64.powi(-17);
    let sphere = Dot { color: Vec3::ONE, ..beside(0, 0.25, center, 1.0) };
    let wall = Dot { field: 0.0, color: Vec3::ZERO, ..beside(0, 0.0, near + length, 1.0) };
    let camera = Camera { near, ..pixels([1, 1]) };
    let method = lambda(method, 1e5);
    let image = stage.image(&[sphere, wall], camera, [1, 1], method)?;
    let density = match method {
        SoftMethod::Base(_) => {
            let from = near - center;
            antiderivative(1.0, 0.25, from + length) - antiderivative(1.0, 0.25, from)
        }
        // Eq. 15: of three shells those that reach so far, r_i of 1, 2/3 and 1/3.
        _ => {
            let reaches = |r: f64| (r * r - 0.0625).max(0.0).sqrt() > center - near;
            let shells = [1.0, 2.0 / 3.0, 1.0 / 3.0].into_iter().filter(|r| reaches(*r));
            length * shells.map(|r| (1.0 - 0.25 / r) / (3.0 * r)).sum::<f64>()
        }
    };
    let wanted = opacity(1e5 * density);
    let whole = naive::Soft { limits: [near as f32, (near + length) as f32], ..naive::Soft::new(1e5) };
    let naive = whole.pixel(&[sphere], &camera, [1, 1], [0, 0])[0];
    // Center and both ends are binary fractions, exact for any zero of depths, and so is the segment's length.
    let bound = INTEGRAL + 4.0 * DISTANCE + 16.0 * ULP;
    Ok(Finding::new(relative(image.rgba[0][0], wanted), bound, relative(naive, wanted)))
}

pub(super) fn no_radius(stage: &mut CaseRenderer, method: SoftMethod) -> CaseResult {
    let radii = [0.0, 1e-45, 1e-20];
    let dots: Vec<Dot> = (0..).zip(radii).map(|(x, radius)| beside(x, 0.0, 10.0, radius)).collect();
    let image = stage.image(&dots, pixels([3, 1]), [3, 1], method)?;
    let wanted: Vec<[f64; 4]> = match method {
        // A disc covers the pixel of its center, except with a radius of 0.
        SoftMethod::Express(_) => [0.0, 0.5, 0.5].map(|a: f64| [a / 4.0, a / 2.0, a, a]).to_vec(),
        _ => vec![[0.0; 4]; 3],
    };
    // 1 - d / r of no radius is no number, nor is cos(π d / r).
    let naive = match method {
        SoftMethod::Express(_) => dots.iter().map(|dot| [naive::disc(0.0, dot.radius); 4]).collect(),
        _ => naive::Soft::new(1.0).image(&dots, &pixels([3, 1]), [3, 1]),
    };
    Ok(Finding::pixels(&image.rgba, &naive, &wanted, 4.0 * HALF_ULP))
}

pub(super) fn huge_radius(stage: &mut CaseRenderer, method: SoftMethod) -> CaseResult {
    let (mut error, mut naive) = (0f64, 0f64);
    for radius in [1e3, 1e10, 1e20, f32::MAX] {
        let dots = [beside(0, 0.0, 10.0, radius)];
        let wanted = [0.25, 0.5, 1.0, 1.0];
        error = error.max(apart(&stage.pixel(&dots, method)?, &wanted));
        naive = naive.max(apart(&naive::Soft::new(1.0).pixel(&dots, &pixels([1, 1]), [1, 1], [0, 0]), &wanted));
    }
    // Opaque at once: one product and one quotient.
    Ok(Finding::new(error, 4.0 * ULP, naive))
}

pub(super) fn far_away(stage: &mut CaseRenderer, method: SoftMethod) -> CaseResult {
    let dots = [Dot { position: DVec3::new(0.3, 0.1, -1000.0), ..beside(0, 0.0, 0.0, 1.0) }];
    let (camera, size) = (wide(0.25, 1.0), [12, 9]);
    // Directions of 1/1000 are as exact as any.
    against_float64(stage, &dots, (camera, size), method, bound(1, 1.0, 1.0), naive::Soft::new(1.0))
}

pub(super) fn quantized(stage: &mut CaseRenderer, method: SoftMethod) -> CaseResult {
    let sphere =
        |x: u32| Dot { color: Vec3::new(x as f32 / 31.3, 0.123, 0.777), ..beside(x, f64::from(x) / 140.0, 10.0, 0.25) };
    let dots: Vec<Dot> = (0..32).map(sphere).collect();
    let (size, method) = ([32, 1], lambda(method, 16.0));
    let in_float64 = |method: SoftMethod| truth(&dots, &pixels(size), size, method);
    let packed = in_float64(method.changed(|soft| soft.layout = SoftLayout::Paper));
    let naive: Vec<[f32; 4]> = packed.iter().map(|pixel| pixel.map(|c| c as f32)).collect();
    let image = stage.image(&dots, pixels(size), size, method)?;
    Ok(Finding::pixels(&image.rgba, &naive, &in_float64(method), bound(1, 16.0, 0.25)))
}

pub(super) fn shells_add_up(stage: &mut CaseRenderer, method: SoftMethod) -> CaseResult {
    let dots = [beside(0, 0.0, 10.0, 2.0)];
    let wanted = [opacity(0.25 * 2.0 * 2.0)];
    let mut error = 0f64;
    for shells in [1, 2, 4, 16, 64] {
        let method = lambda(method, 0.25).changed(|soft| soft.shells = Shells::Fixed(shells));
        error = error.max(apart(&stage.pixel(&dots, method)?[3..], &wanted));
    }
    // Eq. 17 as printed counts the innermost shell alone: for two shells 3/4 of the sum.
    let naive = apart(&[opacity(0.75 * 0.25 * 2.0 * 2.0) as f32], &wanted);
    // Lengths of 64 segments come from depths around 10, relative to where they are counted from: a unit of 2 for each
    // end.
    let lengths = 0.25 * 128.0 * 2.0 * HALF_ULP;
    Ok(Finding::new(error, bound(64, 0.25, 2.0) + lengths, naive))
}

pub(super) fn not_equalized(stage: &mut CaseRenderer, method: SoftMethod) -> CaseResult {
    let dots = [beside(0, 1.5, 9.0, 5.0)];
    let shells =
        |equalize| lambda(method, 0.25).changed(|soft| (soft.shells, soft.equalize) = (Shells::Fixed(2), equalize));
    // Eq. 13: μ of 1/2 on a chord of 2 √22.75, and of 1 on one of 2·2. Cut in the middle: half of it.
    let half = 0.25 * (0.5 * 22.75f64.sqrt() + 2.0);
    let whole = stage.pixel(&dots, shells(false))?[3];
    let cut = stage.image(&dots, Camera { near: 9.0, ..pixels([1, 1]) }, [1, 1], shells(false))?.rgba[0][3];
    let wanted = [opacity(2.0 * half), opacity(half)];
    // Eq. 15 as well: 0.7 of the outer shell's density and 0.4 of the inner one's.
    let equalized = 0.25 * (0.35 * 22.75f64.sqrt() + 0.8);
    let naive = apart(&[opacity(2.0 * equalized) as f32, opacity(equalized) as f32], &wanted);
    Ok(Finding::new(apart(&[whole, cut], &wanted), bound(2, 0.25, 5.0), naive))
}

pub(super) fn not_equalized_rim(stage: &mut CaseRenderer, method: SoftMethod) -> CaseResult {
    let edges = [1e-2, 3e-3, 1e-3, 3e-4, 1e-4];
    let sphere = |(x, edge): (u32, &f64)| beside(x, 0.125 * (1.0 - edge), 10.0, 0.25);
    let dots: Vec<Dot> = (0..).zip(&edges).map(sphere).collect();
    let (size, strength) = ([5, 1], 2f32);
    let method = lambda(method, strength).changed(|soft| (soft.shells, soft.equalize) = (Shells::Fixed(2), false));
    let wanted = truth(&dots, &pixels(size), size, method);
    // The inner shell alone, of optical depth 2 λ √(r² - d²), has the rim; its slope in d/r is at most that at 1e-4.
    let slope = 2.0 * f64::from(strength) * 0.125 / (2f64 * 1e-4).sqrt();
    let weighted = truth(&dots, &pixels(size), size, method.changed(|soft| soft.equalize = true));
    let naive: Vec<[f32; 4]> = weighted.iter().map(|pixel| pixel.map(|c| c as f32)).collect();
    let image = stage.image(&dots, pixels(size), size, method)?;
    Ok(Finding::pixels(&image.rgba, &naive, &wanted, bound(2, 2.0, 0.25) + slope * 2.0 * DISTANCE))
}

pub(super) fn extremes(stage: &mut CaseRenderer, method: SoftMethod) -> CaseResult {
    let dots = [beside(0, 0.0, 10.0, 1.0)];
    let none = stage.pixel(&dots, method.changed(|soft| soft.density = Density::Softness(0.0)))?;
    let all = stage.pixel(&dots, method.changed(|soft| soft.density = Density::Softness(1.0)))?;
    let error = apart(&none, &[0.0; 4]).max(apart(&all, &[0.25, 0.5, 1.0, 1.0]));
    if matches!(method, SoftMethod::Express(_)) {
        let why = "the softness of a disc is the opacity of its middle, by any formula";
        return Ok(Finding::stated(error, 4.0 * ULP, why));
    }
    // λ is infinite, times antiderivatives of what is 0 at a chord's end.
    let opaque = naive::Soft::new(-(-1f32).ln_1p()).pixel(&dots, &pixels([1, 1]), [1, 1], [0, 0]);
    Ok(Finding::new(error, 4.0 * ULP, apart(&opaque, &[0.25, 0.5, 1.0, 1.0])))
}

pub(super) fn modulated(stage: &mut CaseRenderer, method: SoftMethod) -> CaseResult {
    let (radius, distance, peak) = (1.0f64, 0.25, 0.5);
    let dots = [Dot { field: 0.75, color: Vec3::ONE, ..beside(0, distance, 10.0, 1.0) }];
    let change = |soft: &mut Soft| {
        (soft.density, soft.modulation, soft.shells) = (Density::Softness(peak as f32), Some(1.0), Shells::Fixed(1));
    };
    let found = stage.pixel(&dots, method.changed(change))?[3];
    let plain = match method {
        SoftMethod::Express(_) => peak * ((PI * distance / radius).cos() + 1.0) / 2.0,
        SoftMethod::Base(_) => opacity(-(-peak).ln_1p() * chord(radius, distance) / (radius * radius)),
        // A single shell: λ μ' and the chord.
        _ => {
            let length = 2.0 * ((radius - distance) * (radius + distance)).sqrt();
            opacity(-(-peak).ln_1p() / (2.0 * radius) * (1.0 - distance / radius) * length)
        }
    };
    let wanted = peak * (1.0 - distance / radius) * 0.5 + plain * 0.5;
    // The law of the disc's profile is within 3e-7 (shaders/shared/profile.wgsl).
    let error = apart(&[found], &[wanted]);
    Ok(Finding::new(error, bound(1, 0.7, 1.0) + 3e-7, apart(&[plain as f32], &[wanted])))
}
