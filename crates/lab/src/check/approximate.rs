//! Approximations of transparency: the parts that each of them computes exactly.

use super::discs::{SATURATED, reversed, ties};
use super::naive::{half, over_until, weighted};
use super::prelude::*;
use pellucid_reference::approximate;

/// Color that has no exact float32.
const COLOR: Vec3 = Vec3::new(0.1, 0.2, 0.7);

pub(super) fn cases() -> Vec<Case> {
    let discs = Discs::default();
    let [average, weighted, unsorted] = [Method::Average(discs), Method::Weighted(discs), Method::Unsorted(discs)];
    let hybrid = Method::Hybrid(Hybrid::default());
    joined([
        each(&[average], "equal-colors", equal_colors).about("the mean of 100 000 equal colors is that color"),
        each(&[weighted], "equal-colors", weighted_equal).about("10 000 layers of one color: that color times A"),
        each(&[weighted], "at-far", at_far).about("fragments at far, where (1 - d)³ is 0: their weight is 0.01"),
        each(&[weighted], "large-sums", large_sums).about("200 weights of 1500: more than 16-bit floats hold"),
        each(&[unsorted], "file-order", file_order).about("later over earlier, whatever the depth"),
        each(&[unsorted], "faint-layers", faint).about("100 000 layers of opacity 1e-7: 1 - (1 - 1e-7)^100000"),
        each(&[hybrid], "as-many-as-k", as_many_as_k).about("8 fragments with k = 8 against float64"),
        each(&approximations(), "equal-depths", ties)
            .about("discs of equal depth and different colors, shuffled: no byte changes"),
        each(&approximations(), "reversed", reversed).about("the order of the input reversed: no byte changes"),
        each(&exact(), "long-and-short", behind_one).about("2000 layers of opacity 1e-3 behind one of 0.999"),
    ])
}

/// Layers of one color and opacity behind one another.
fn layers(n: u32, color: Vec3, opacity: f32) -> Vec<Dot> {
    (0..n).map(|i| dot(1.0 + f64::from(i), color, opacity)).collect()
}

/// A color times A, and A.
fn times(color: Vec3, alpha: f64) -> [f64; 4] {
    (color.as_dvec3() * alpha).extend(alpha).to_array()
}

fn equal_colors(stage: &mut CaseRenderer, method: Method) -> CaseResult {
    let dots = layers(100_000, COLOR, 0.5);
    let wanted = times(COLOR, 1.0);
    let found = stage.pixel(&dots, method)?;
    let sum = dots.iter().fold(Vec3::ZERO, |sum, dot| sum + dot.color) / dots.len() as f32;
    Ok(Finding::new(apart(&found, &wanted), COMPENSATED, apart(&[sum.x, sum.y, sum.z], &wanted[..3])))
}

fn weighted_equal(stage: &mut CaseRenderer, method: Method) -> CaseResult {
    let dots = layers(10_000, COLOR, 1e-4);
    let wanted = times(COLOR, composed(&dots)[3]);
    stage.compare(&dots, method, &over(&dots), &wanted, COMPENSATED)
}

fn at_far(stage: &mut CaseRenderer, method: Method) -> CaseResult {
    let far = 1e7;
    let dots = [dot(far, Vec3::X, 0.25), dot(far, Vec3::Y, 0.5), dot(far, Vec3::Z, 0.25)];
    let alpha = 1.0 - 0.75 * 0.5 * 0.75;
    let wanted = [0.25 * alpha, 0.5 * alpha, 0.25 * alpha, alpha];
    // Without a least weight, 0 / 0.
    let naive = apart(&weighted(&dots, [0.5, 1e7], |sum| sum), &wanted.map(|c| c / alpha));
    Ok(Finding::new(apart(&stage.pixel(&dots, method)?, &wanted), COMPENSATED, naive))
}

fn large_sums(stage: &mut CaseRenderer, method: Method) -> CaseResult {
    let dots = layers(200, COLOR, 0.5);
    // Sums of 300 000 are infinite in 16 bits, and their quotient is no number.
    stage.compare(&dots, method, &weighted(&dots, [0.5, 1e7], half), &times(COLOR, 1.0), COMPENSATED)
}

fn file_order(stage: &mut CaseRenderer, method: Method) -> CaseResult {
    let dots = [dot(2.0, Vec3::X, 0.5), dot(9.0, Vec3::Y, 0.5), dot(5.0, Vec3::Z, 0.5)];
    let wanted = [0.125, 0.25, 0.5, 0.875];
    // Powers of two, exact.
    let by_depth = composed(&[dots[0], dots[2], dots[1]]).map(|c| c as f32);
    stage.compare(&dots, method, &by_depth, &wanted, 0.0)
}

fn faint(stage: &mut CaseRenderer, method: Method) -> CaseResult {
    let dots = layers(100_000, Vec3::ONE, 1e-7);
    let wanted = composed(&dots);
    stage.compare(&dots, method, &over(&dots), &wanted, COMPENSATED * wanted[3])
}

fn as_many_as_k(stage: &mut CaseRenderer, method: Method) -> CaseResult {
    let dots: Vec<Dot> = (0..8).map(|i| dot(1.0 + f64::from(i), graded(i, 8), 0.3)).collect();
    let wanted = composed(&dots);
    let mut shuffled = dots.clone();
    shuffled.rotate_left(3);
    let (list, colors) = fragments(&dots);
    let mixed = approximate::hybrid(&list, &colors, 1, 0.0);
    let mixed = mixed.color.extend(mixed.alpha).to_array().map(|c| c as f32);
    // Four roundings for each of 8.
    stage.compare(&shuffled, method, &mixed, &wanted, 32.0 * HALF_ULP)
}

fn behind_one(stage: &mut CaseRenderer, method: Method) -> CaseResult {
    let mut dots = layers(2000, Vec3::Y, 1e-3);
    dots.insert(0, dot(0.75, Vec3::X, 0.999));
    let wanted = composed(&dots);
    let found = stage.pixel(&dots, method)?;
    // Green alone. Each layer of a run rounds A, which is nearly 1, by half a unit, and changes the brightness of the
    // layers behind it by as much; green opacities sum to 1.
    let bound = roundings(&method, 2001) / 4.0 * HALF_ULP;
    let error = apart(&found[1..2], &wanted[1..2]);
    // Stopping where an 8-bit step is saturated loses the last of them: behind T of 1/512 nothing is drawn.
    let naive = apart(&over_until(&dots, SATURATED)[1..2], &wanted[1..2]);
    Ok(Finding::new(error, bound, naive))
}
