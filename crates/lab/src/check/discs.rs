//! Transparent discs: composition of many, of few, of none, in any order.

use super::naive::{gaussian, nearest, over_until};
use super::prelude::*;
use pellucid_scene::{DiscShape, Falloff, Peel, Stochastic};

/// Transmittance below half a step of 8 bits.
pub(super) const SATURATED: f32 = 1.0 / 512.0;

/// Methods with an exact A, whatever they do to colors.
pub(super) fn exact_coverage() -> Vec<Method> {
    let discs = Discs::default();
    let corrected = Stochastic { samples: 4, ..Stochastic::default() };
    vec![Method::Hybrid(Hybrid::default()), Method::Weighted(discs), Method::Stochastic(corrected)]
}

pub(super) fn cases() -> Vec<Case> {
    let gaussian = Method::ABuffer(Discs { falloff: Falloff::Gaussian, ..Discs::default() });
    let tilted = Method::ABuffer(Discs { shape: DiscShape::Oriented, ..Discs::default() });
    joined([
        each(&exact(), "faint-layers", faint).about("100 000 layers of opacity 1e-7 in a pixel: 1 - (1 - 1e-7)^100000"),
        each(&exact_coverage(), "faint-coverage", faint_a)
            .about("A of 10 000 layers of opacity 1e-6: 1 - (1 - 1e-6)^10000"),
        each(&exact(), "ten-thousand-layers", |stage, method| layers(stage, method, 10_000))
            .about("10 000 layers of three colors against float64"),
        each(&with_peel(), "coincident", coincident).about("300 equal discs: 1 - 0.9^300 of their color"),
        each(&with_peel(), "equal-depths", ties)
            .about("discs of equal depth and different colors, shuffled: no byte changes"),
        each(&with_peel(), "reversed", reversed).about("the order of the input reversed: no byte changes"),
        each(&with_peel(), "opacity-0-and-1", extremes).about("nothing shows of opacity 0, or behind opacity 1"),
        lengths(),
        each(&with_peel(), "nearly-opaque", nearly_opaque)
            .about("opacities of 1 - 2^-24: what shines through is not lost"),
        each(&with_peel(), "least-opacity", least_opacity).about("three layers of opacity 2^-125: 3 · 2^-125"),
        each(&[gaussian], "no-radius", no_radius)
            .about("radii of 0 to 1e-3 with a Gaussian: at the rim, exp(-2) of the opacity"),
        each(&[tilted], "edge-on", edge_on).about("a disc seen edge-on covers the pixel of its center, at its depth"),
    ])
}

/// Lists around the sizes at which another kernel takes over.
fn lengths() -> Vec<Case> {
    let about = "a list of that many layers against float64";
    let method = Method::ABuffer(Discs::default());
    let case = |n: u32| one(&format!("abuffer/list-of-{n}"), about, move |stage| layers(stage, method, n));
    [1, 32, 33, 255, 256, 257, 512, 513, 1025].map(case).into()
}

/// Roundings that a pixel of n layers meets on its way at most: the layers of a run are composed one by one, and then
/// the runs; each takes two products and two sums. A list's runs have up to 256 layers, a tile's up to 2048.
pub(super) fn roundings(method: &Method, n: usize) -> f64 {
    let lists = matches!(method, Method::ABuffer(_) | Method::LinkedList(_));
    let run = n.min(if lists { 256 } else { 2048 });
    4.0 * (run + n.div_ceil(run)) as f64
}

fn faint(stage: &mut CaseRenderer, method: Method) -> CaseResult {
    let dots: Vec<Dot> = (0..100_000).map(|i| dot(1.0 + f64::from(i), Vec3::ONE, 1e-7)).collect();
    let wanted = composed(&dots);
    // Each rounding is relative to a sum that is at most the whole.
    let bound = roundings(&method, dots.len()) * HALF_ULP * wanted[3];
    stage.compare(&dots, method, &over(&dots), &wanted, bound)
}

fn faint_a(stage: &mut CaseRenderer, method: Method) -> CaseResult {
    let dots: Vec<Dot> = (0..10_000).map(|i| dot(1.0 + f64::from(i), Vec3::ONE, 1e-6)).collect();
    let wanted = composed(&dots)[3];
    let found = stage.pixel(&dots, method)?[3];
    let bound = roundings(&method, dots.len()) * HALF_ULP * wanted;
    Ok(Finding::apart(&[found], &[over(&dots)[3]], &[wanted], bound))
}

/// Opacity falls with the length, so that the last layers still count; colors differ from layer to layer.
fn layers(stage: &mut CaseRenderer, method: Method, n: u32) -> CaseResult {
    let opacity = (3.0 / n as f32).min(0.5);
    let dots: Vec<Dot> = (0..n).map(|i| dot(1.0 + f64::from(i), graded(i, n), opacity)).collect();
    let wanted = composed(&dots);
    let mut shuffled = dots.clone();
    shuffled.reverse();
    shuffled.rotate_left(n as usize / 3);
    let found = stage.pixel(&shuffled, method)?;
    let bound = roundings(&method, dots.len()) * HALF_ULP * wanted.into_iter().fold(0.0, f64::max);
    if n == 1 {
        let why = "one layer is right by any formula; it is here as the shortest list";
        return Ok(Finding::stated(apart(&found, &wanted), bound, why));
    }
    // In the order of arrival.
    Ok(Finding::apart(&found, &over(&shuffled), &wanted, bound))
}

fn coincident(stage: &mut CaseRenderer, method: Method) -> CaseResult {
    let dots = vec![dot(5.0, Vec3::new(0.25, 0.5, 1.0), 0.1); 300];
    let wanted = composed(&dots);
    let bound = roundings(&method, dots.len()) * HALF_ULP;
    // A depth test that lets only what is nearer pass keeps one of them.
    stage.compare(&dots, method, &over(&dots[..1]), &wanted, bound)
}

/// Dots at equal depth that differ in color alone.
fn tied() -> Vec<Dot> {
    let color = |i: u32| Vec3::new((i % 7) as f32 / 7.0, (i % 5) as f32 / 5.0, (i % 3) as f32 / 3.0);
    let near = (0..40).map(|i| dot(2.0, color(i), 0.3));
    near.chain((0..40).map(|i| dot(3.0, color(i), 0.2))).collect()
}

/// Bytes that change when the input is permuted, and how many would by composition in the order of arrival.
fn permuted(stage: &mut CaseRenderer, method: Method, permute: fn(&mut Vec<Dot>)) -> CaseResult {
    let dots = tied();
    let mut other = dots.clone();
    permute(&mut other);
    let method = match method {
        Method::Peel(peel) => Method::Peel(Peel { layers: 0, ..peel }),
        method => method,
    };
    let first = stage.image(&dots, pixels([1, 1]), [1, 1], method)?;
    let second = stage.image(&other, pixels([1, 1]), [1, 1], method)?;
    let arrived = |dots: &[Dot]| over(dots).map(f32::to_bits);
    let naive = arrived(&dots).iter().zip(arrived(&other)).filter(|(a, b)| **a != *b).count();
    Ok(Finding::new(bytes_apart(&first, &second), 0.0, naive as f64))
}

pub(super) fn ties(stage: &mut CaseRenderer, method: Method) -> CaseResult {
    permuted(stage, method, |dots| {
        dots.swap(0, 77);
        dots[..40].rotate_left(13);
        dots[40..].rotate_left(29);
    })
}

pub(super) fn reversed(stage: &mut CaseRenderer, method: Method) -> CaseResult {
    permuted(stage, method, |dots| dots.reverse())
}

pub(super) fn extremes(stage: &mut CaseRenderer, method: Method) -> CaseResult {
    let red = Vec3::new(1.0, 0.0, 0.0);
    // Invisible points are in front, between and behind.
    let dots = [
        dot(1.0, Vec3::ONE, 0.0),
        dot(2.0, Vec3::Y, 0.5),
        dot(3.0, Vec3::ONE, 0.0),
        dot(4.0, red, 1.0),
        dot(5.0, Vec3::ONE, 1.0),
    ];
    let image = stage.image(&dots, pixels([1, 1]), [1, 1], method)?;
    let found = [image.rgba[0].as_slice(), &[image.depth[0]]].concat();
    let wanted = [0.5, 0.5, 0.0, 1.0, 2.0];
    // Powers of two, exact; the depth is that of the first fragment with an opacity. Naive: that of the nearest.
    let naive = [over(&dots).as_slice(), &[nearest(&dots)]].concat();
    Ok(Finding::apart(&found, &naive, &wanted, 0.0))
}

fn nearly_opaque(stage: &mut CaseRenderer, method: Method) -> CaseResult {
    let opacity = 1.0 - f32::EPSILON / 2.0;
    let dots = [dot(1.0, Vec3::ZERO, opacity), dot(2.0, Vec3::ONE, 1.0)];
    let found = stage.pixel(&dots, method)?;
    // 2^-24 of white; one rounding of a product. Stopping where an 8-bit step is saturated loses it.
    let wanted = [1.0 - f64::from(opacity); 3];
    Ok(Finding::apart(&found[..3], &over_until(&dots, SATURATED)[..3], &wanted, HALF_ULP * wanted[0]))
}

fn least_opacity(stage: &mut CaseRenderer, method: Method) -> CaseResult {
    // Above the least normal number, below which a device may take it for 0.
    let opacity = f32::MIN_POSITIVE * 2.0;
    let dots = [1.0, 2.0, 3.0].map(|depth| dot(depth, Vec3::ONE, opacity));
    let image = stage.image(&dots, pixels([1, 1]), [1, 1], method)?;
    let wanted = 3.0 * f64::from(opacity);
    // It has an opacity, so its depth is that of the image. 1 - T is 0.
    let depth = if image.depth[0] == 1.0 { 0.0 } else { 1.0 };
    let error = apart(&image.rgba[0], &[wanted; 4]);
    Ok(Finding::new(error.max(depth), 12.0 * HALF_ULP * wanted, apart(&over(&dots), &[wanted; 4])))
}

fn no_radius(stage: &mut CaseRenderer, method: Method) -> CaseResult {
    // In the middle of their pixels and beside it: d / r is 0 / 0 or larger than 1.
    let radii = [0.0, 0.0, 1e-45, 1e-3];
    let beside = |x: u32| DVec3::X * if x == 0 { 0.0 } else { 0.25 };
    let dot = |(x, radius): (u32, &f32)| Dot { position: at(x, 0, 3.0) + beside(x), radius: *radius, ..Dot::default() };
    let dots: Vec<Dot> = (0..).zip(&radii).map(dot).collect();
    let image = stage.image(&dots, pixels([4, 1]), [4, 1], method)?;
    let wanted = [(-2f64).exp(); 4];
    let error = image.rgba.iter().map(|pixel| apart(pixel, &wanted)).fold(0.0, f64::max);
    // ρ counts as 1, products with 1 are exact, and the shaders' own exponential is within one unit
    // (shared/elementary.wgsl).
    let naive = (0..).zip(&radii).map(|(x, radius)| gaussian(beside(x).x as f32, *radius));
    let naive = apart(&naive.collect::<Vec<f32>>(), &wanted);
    Ok(Finding::new(error, 2.0 * HALF_ULP * wanted[0], naive))
}

fn edge_on(stage: &mut CaseRenderer, method: Method) -> CaseResult {
    let size = [5, 5];
    let disc = Dot { position: at(2, 2, 3.0), radius: 2.0, normal: Vec3::X, opacity: 0.5, ..Dot::default() };
    let image = stage.render(&cloud(&[disc]), &Frame::new(pixels(size), size, method))?.image;
    let found: Vec<f32> = image.rgba.iter().map(|c| c[3]).collect();
    let wanted: Vec<f64> = (0..25).map(|i| if i == 12 { 0.5 } else { 0.0 }).collect();
    let depth = (f64::from(image.depth[12]) - 3.0).abs();
    // The ray of a pixel's center doesn't meet the disc's plane, without the rule of the always-covered pixel.
    let (normal, center) = (disc.normal, disc.position.as_vec3());
    let met = |pixel: u32| {
        let start = at(pixel % 5, pixel / 5, 0.0).as_vec3();
        let along = normal.dot(center - start) / normal.dot(Vec3::NEG_Z);
        if (start + along * Vec3::NEG_Z).distance(center) <= disc.radius { disc.opacity } else { 0.0 }
    };
    let naive = apart(&(0..25).map(met).collect::<Vec<f32>>(), &wanted);
    Ok(Finding::new(apart(&found, &wanted).max(depth), 0.0, naive))
}
