//! Soft spheres and discs: densities, rays and radii at their limits; cuts through spheres; numbers of open spheres.

mod many;
mod rays;

use std::f64::consts::E;

use crate::check::prelude::*;
use pellucid_reference::soft::{Behind, Model, Scene};
use pellucid_scene::{Density, OneLayer, Shells, Soft, SoftMethod};

/// Relative error of an optical depth: the guarantee of shaders/shared/absorb.wgsl for its quadrature.
const INTEGRAL: f64 = 1e-5;
/// Relative error of a ray's distance from a center: position on the screen, world units per pixel, cross product and
/// root, each of which Vulkan allows up to 3 units in the last place.
const DISTANCE: f64 = 12.0 * ULP;

pub(super) fn cases() -> Vec<Case> {
    let soft = Soft { density: Density::Lambda(1.0), ..Soft::default() };
    let base = [SoftMethod::Base(soft)];
    let concentric = [SoftMethod::Concentric(Soft { shells: Shells::Fixed(3), ..soft })];
    let both = [base[0], concentric[0]];
    let express = [SoftMethod::Express(Soft { density: Density::Softness(0.5), ..soft })];
    let all = [both[0], both[1], express[0]];
    let layer = [Method::OneLayer(OneLayer::default())];
    joined([
        each(&both, "faint", rays::faint).about("lambda of 1e-6: 1 - exp(-x) of 6e-7, relative"),
        each(&both, "dense", rays::dense).about("lambda of 1e6: rays that pass within 1e-2 to 1e-5 of the rim"),
        each(&base, "through-centre", rays::through_center).about("d of 0 to 1e-3: d² ln d tends to 0"),
        each(&base, "grazing", rays::grazing).about("d = r (1 - 1e-4) at a depth of 1000, relative"),
        each(&base, "thin-segment", |stage, method| rays::segment(stage, method, 8.0, 8.5))
            .about("a segment of 1e-5 r between near and a solid point, relative"),
        each(&both, "far-segment", |stage, method| rays::segment(stage, method, 65536.0, 65536.5))
            .about("the same at a depth of 65536, relative"),
        each(&both, "inside-one", many::inside_one)
            .about("the camera inside a sphere: the part in front of near is left out"),
        each(&both, "inside-many", many::inside_many).about("the camera inside 300 spheres"),
        each(&both, "near-plane", many::near_plane)
            .about("a sphere cut by near through its center: 1 - exp(-λ r²/2) and 1 - exp(-λ r)"),
        each(&both, "solid", many::solid).about("cut by a solid point off the axis: at z / cos φ along the ray"),
        each(&all, "no-radius", rays::no_radius).about("radii of 0, 1e-45 and 1e-20: nothing"),
        each(&both, "huge-radius", rays::huge_radius)
            .about("radii of 1e3 to 3.4e38 around the camera: opaque, of their color"),
        each(&both, "open-300", many::open_300).about("300 spheres open at once, of different colors, against float64"),
        each(&both, "coincident", many::coincident).about("300 equal spheres: 1 - exp(-300 x)"),
        each(&base, "far-away", rays::far_away)
            .about("a sphere of radius 1 at a distance of 1000, 1 degree wide, against float64"),
        each(&base, "quantised", rays::quantized).about("d and color of 32 spheres are not cut to 8 bits"),
        each(&concentric, "shells-add-up", rays::shells_add_up)
            .about("1 to 64 shells: 1 - exp(-2 λ r), whatever their number"),
        each(&concentric, "not-equalized", rays::not_equalized)
            .about("two shells of constant density, without Eq. 15: 1 - exp(-λ (√22.75 + 4)), and to the center half"),
        each(&concentric, "not-equalized-rim", rays::not_equalized_rim)
            .about("two shells of constant density, 1e-2 to 1e-4 within the rim of the inner one, against float64"),
        each(&both, "leftover", many::leftover)
            .about("what 300 spheres leave of the running sums when they end, behind them one of weight 0.008"),
        each(&all, "reversed", many::reversed)
            .about("coincident spheres of different colors, input reversed: no byte changes"),
        each(&all, "softness-0-and-1", rays::extremes).about("softness 0 shows nothing, softness 1 is opaque"),
        each(&all, "modulated", rays::modulated).about("Eq. 22 half-way between threshold and modulation"),
        each(&express, "along-the-axis", many::along_the_axis)
            .about("200 discs along the axis of the view, shuffled, against float64"),
        each(&express, "faint", many::faint_discs).about("10 000 discs of opacity 1e-6: 1 - (1 - 1e-6)^10000"),
        each(&layer, "coincident-layer", many::one_layer)
            .about("the nearest soft points are one layer, however many they are"),
    ])
}

fn lambda(method: SoftMethod, lambda: f32) -> SoftMethod {
    method.changed(|soft| soft.density = Density::Lambda(lambda))
}

/// A soft sphere that the ray of a pixel passes at a distance, above its center.
fn beside(x: u32, distance: f64, depth: f64, radius: f32) -> Dot {
    let position = at(x, 0, depth) + DVec3::Y * distance;
    Dot { position, radius, color: Vec3::new(0.25, 0.5, 1.0), field: 1.0, ..Dot::default() }
}

fn opacity(depth: f64) -> f64 {
    -(-depth).exp_m1()
}

/// The image in float64.
pub(super) fn truth(dots: &[Dot], camera: &Camera, size: [u32; 2], method: SoftMethod) -> Vec<[f64; 4]> {
    let points = cloud(dots);
    let model = Model::new(method, &points);
    Scene { view: View::new(camera, size), points: &points, colors: &colors_of(&points), model }
        .render(|_| Behind::NOTHING)
        .rgba
}

/// The largest error of an opacity: the quadrature, whose effect is at most x exp(-x) ≤ 1/e; the distance of the ray,
/// on which an optical depth depends by at most 2 λ r for each sphere (Eq. 5, by d), or 8 λ for each one of three
/// shells (Eq. 15); the exponential (3 + 2 x units, times exp(-x)); weights of colors, whose mean is above 0.1; four
/// roundings for each of two segments of a sphere.
fn bound(spheres: usize, lambda: f64, radius: f64) -> f64 {
    let n = spheres as f64;
    let distance = n * lambda * radius * (2.0 * radius).max(8.0) * DISTANCE;
    INTEGRAL / E + distance + 10.0 * DISTANCE + 4.0 * ULP + n * 8.0 * HALF_ULP
}

/// An image against float64, and the naive one.
fn against_float64(
    stage: &mut CaseRenderer,
    dots: &[Dot],
    (camera, size): (Camera, [u32; 2]),
    method: SoftMethod,
    bound: f64,
    naive: naive::Soft,
) -> CaseResult {
    let wanted = truth(dots, &camera, size, method);
    let naive = naive.image(dots, &camera, size);
    let image = stage.image(dots, camera, size, method)?;
    Ok(Finding::pixels(&image.rgba, &naive, &wanted, bound))
}

fn wide(degrees: f64, near: f64) -> Camera {
    perspective(DVec3::ZERO, DVec3::NEG_Z, degrees, near, 1e6)
}
