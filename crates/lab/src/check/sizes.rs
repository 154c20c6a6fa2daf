//! Images and lists at their ends: one pixel, as long as may be, one pixel that holds everything, one point.

use std::f64::consts::E;

use super::prelude::*;
use super::soft::truth;
use pellucid_scene::{BlendedSplats, Density, Family, ScreenSplats, Shells, Soft, SoftMethod, Stochastic};

pub(super) fn cases() -> Vec<Case> {
    let long = [
        exact(),
        vec![Method::Hybrid(Hybrid::default()), Method::Points, Method::Circles(ScreenSplats::default())],
        vec![Method::Hqs(BlendedSplats::default()), Method::Stochastic(Stochastic::default())],
    ]
    .concat();
    let one = of_families(&[Family::Discs, Family::Opaque, Family::OneLayer, Family::Soft]);
    let one = with_samples(5, one);
    let spheres = Soft { density: Density::Lambda(1e-6), shells: Shells::Fixed(64), ..Soft::default() };
    let spheres = [SoftMethod::Base(spheres), SoftMethod::Concentric(spheres)];
    let round =
        [exact(), vec![Method::Circles(ScreenSplats::default()), Method::Hqs(BlendedSplats::default())]].concat();
    let placed = [exact(), vec![Method::Points, Method::Circles(ScreenSplats::default())]].concat();
    joined([
        each(&long, "16384x1", |stage, method| line(stage, method, [16384, 1], |x| DVec3::new(x, -0.5, 0.0)))
            .about("a row of 16384 pixels, points 2^-14 of a pixel left of a border: pixels that differ"),
        each(&long, "1x16384", |stage, method| line(stage, method, [1, 16384], |y| DVec3::new(0.5, -y, 0.0)))
            .about("a column of 16384 pixels, points 2^-14 of a pixel above a border: pixels that differ"),
        each(&spheres, "one-over-16384", one_sphere)
            .about("one sphere over a row of 16384 pixels, of 64 shells, against float64"),
        each(&exact(), "one-pixel-of-many", crowded).about("20 000 fragments in one of 4096 pixels against float64"),
        each(&round, "rim", rim)
            .about("a radius of 25 pixels around a pixel's center: 1961 of them, 20 on the rim itself"),
        each(&placed, "border", border).about("points on corners of pixels belong to the pixel right below"),
        each(&one, "one-point", one_point).about("one opaque point of no radius: its pixel, at its depth"),
    ])
}

/// Checks a point for each 64 pixels of a line of 16384, slightly before a border of pixels.
fn line(stage: &mut CaseRenderer, method: Method, size: [u32; 2], place: fn(f64) -> DVec3) -> CaseResult {
    let along = |i: u32| f64::from(64 * i + 63) - 2f64.powi(-14);
    let dot = |i: u32| Dot { position: place(along(i)) - DVec3::Z * 8.0, ..Dot::default() };
    let dots: Vec<Dot> = (0..256).map(dot).collect();
    let image = stage.image(&dots, pixels(size), size, method)?;
    let wanted = |i: usize| if i % 64 == 62 { 1.0 } else { 0.0 };
    let error = (0..16384).filter(|i| image.rgba[*i][3] != wanted(*i)).count();
    let naive = (0..256).filter(|i| (along(*i) as f32).floor() as u32 != 64 * i + 62).count();
    Ok(Finding::counted(error, naive))
}

fn one_sphere(stage: &mut CaseRenderer, method: SoftMethod) -> CaseResult {
    let size = [16384, 1];
    let position = DVec3::new(8192.0, -0.5, -2e4);
    let dots = [Dot { position, radius: 1e4, field: 1.0, ..Dot::default() }];
    let wanted = truth(&dots, &pixels(size), size, method);
    let image = stage.image(&dots, pixels(size), size, method)?;
    // The quadrature and the distance of the ray, whose effect is at most x exp(-x) ≤ 1/e; two ends and their roundings
    // for each shell, of depths of 1e4 at most 1e-3, at an absorption of λ μ' ≤ 1e-6 · 64 / 64 a unit.
    let bound = 1e-5 / E + 24.0 * HALF_ULP * 4.0 + 128.0 * 1e-3 * 1e-6 + 64.0 * 8.0 * HALF_ULP;
    let why = "an invocation that visits all pixels of a sphere ends where a driver allows 65 535 turns of a loop";
    Ok(Finding::stated(pixels_apart(&image.rgba, &wanted), bound, why))
}

fn crowded(stage: &mut CaseRenderer, method: Method) -> CaseResult {
    let size = [64, 64];
    let count = 20_000;
    let place = |i: u32| at(37, 21, 1.0 + f64::from(i));
    let dot = |i: u32| Dot { position: place(i), color: graded(i, count), opacity: 1.5e-4, ..Dot::default() };
    let dots: Vec<Dot> = (0..count).map(dot).collect();
    let mut wanted = vec![[0.0; 4]; 64 * 64];
    wanted[21 * 64 + 37] = composed(&dots);
    let image = stage.image(&dots, pixels(size), size, method)?;
    // An array of the nearest 256.
    let naive = apart(&over(&dots[..256]), &wanted[21 * 64 + 37]);
    let error = pixels_apart(&image.rgba, &wanted);
    Ok(Finding::new(error, roundings(&method, dots.len()) * HALF_ULP, naive))
}

fn one_point(stage: &mut CaseRenderer, method: Method) -> CaseResult {
    let radius = if method.soft().is_some() { 0.25 } else { 0.0 };
    let dot = Dot { position: at(1, 2, 8.0), color: Vec3::new(0.25, 0.5, 1.0), radius, ..Dot::default() };
    let image = stage.image(&[dot], pixels([4, 4]), [4, 4], method)?;
    let wanted: Vec<[f64; 4]> = (0..16).map(|i| if i == 9 { [0.25, 0.5, 1.0, 1.0] } else { [0.0; 4] }).collect();
    let depth: Vec<f64> = (0..16).map(|i| if i == 9 { 8.0 } else { f64::INFINITY }).collect();
    let deep =
        |depths: &[f32]| depths.iter().zip(&depth).filter(|(z, wanted)| f64::from(**z) != **wanted).count() as f64;
    let error = pixels_apart(&image.rgba, &wanted).max(deep(&image.depth));
    if radius > 0.0 {
        let why = "by any formula, a disc that has a radius covers the pixel in whose center it lies";
        return Ok(Finding::stated(error, 0.0, why));
    }
    // A disc of a radius of 0 covers no pixel, not even with its center in the pixel's: 0 / 0 is not at most 1.
    let covered: Vec<[f32; 4]> = (0..16).map(|i| naive::pixel(&dot, [i % 4, i / 4])).collect();
    Ok(Finding::new(error, 0.0, pixels_apart(&covered, &wanted)))
}

fn rim(stage: &mut CaseRenderer, method: Method) -> CaseResult {
    let size = [64, 64];
    let dot = Dot { position: at(31, 31, 8.0), radius: 25.0, ..Dot::default() };
    let image = stage.image(&[dot], pixels(size), size, method)?;
    let inside = |pixel: usize, most: usize| {
        let [x, y] = [pixel % 64, pixel / 64].map(|c| c.abs_diff(31));
        x * x + y * y <= most
    };
    let wanted = |pixel: usize| if inside(pixel, 625) { 1.0 } else { 0.0 };
    let error = (0..64 * 64).filter(|pixel| image.rgba[*pixel][3] != wanted(*pixel)).count();
    // With < for <= the rim is lost: 7² + 24², 15² + 20² and 25².
    let naive = (0..64 * 64).filter(|pixel| inside(*pixel, 625) && !inside(*pixel, 624)).count();
    Ok(Finding::counted(error, naive))
}

fn border(stage: &mut CaseRenderer, method: Method) -> CaseResult {
    let size = [15, 15];
    let dot = |i: u32| {
        let [x, y] = [3 * (i % 5), 3 * (i / 5)].map(f64::from);
        Dot { position: DVec3::new(x, -y, -8.0), ..Dot::default() }
    };
    let dots: Vec<Dot> = (0..25).map(dot).collect();
    let image = stage.image(&dots, pixels(size), size, method)?;
    let wanted = |pixel: usize| if pixel.is_multiple_of(3) && (pixel / 15).is_multiple_of(3) { 1.0 } else { 0.0 };
    let error = (0..225).filter(|pixel| image.rgba[*pixel][3] != wanted(*pixel)).count();
    // The nearest center, where two are as near: half to even takes the left one of an odd border.
    let naive = (0..5).map(|i| 3.0 * f64::from(i)).filter(|x| (x - 0.5).round_ties_even() != *x).count();
    Ok(Finding::counted(error, naive))
}
