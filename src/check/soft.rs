//! Soft spheres and discs: densities, rays and radii at their ends; what cuts spheres; how many of them are open.

use std::f64::consts::{E, PI};

use glam::{DVec3, Vec3};

use super::naive::{self, over};
use super::stage::{Dot, HALF_ULP, apart, at, bytes_apart, cloud, composed, dot, pixels, pixels_apart};
use super::{Case, Finding, Stage, Trouble, each};
use crate::camera::{Camera, Projection};
use crate::reference::soft::density::antiderivative;
use crate::reference::soft::{Behind, Model, Ray, Scene};
use crate::scene::{Density, Method, OneLayer, Shells, Soft, SoftLayout};

type Found = Result<Finding, Trouble>;

const ULP: f64 = 2.0 * HALF_ULP;
/// Relative, of an optical depth: what shaders/shared/absorb.wgsl promises of its quadrature.
const INTEGRAL: f64 = 1e-5;
/// Relative, of the distance of a ray from a centre: place on the screen, world units over a pixel, cross product and root, each
/// of which Vulkan allows up to 3 units in the last place.
const DISTANCE: f64 = 12.0 * ULP;

pub(super) fn cases() -> Vec<Case> {
    let soft = Soft { density: Density::Lambda(1.0), ..Soft::default() };
    let base = [Method::SoftBase(soft)];
    let concentric = [Method::SoftConcentric(Soft { shells: Shells::Fixed(3), ..soft })];
    let both = [base[0], concentric[0]];
    let express = [Method::SoftExpress(Soft { density: Density::Softness(0.5), ..soft })];
    let all = [both[0], both[1], express[0]];
    let layer = [Method::OneLayer(OneLayer::default())];
    [
        each(&both, "faint", "lambda of 1e-6: 1 - exp(-x) of 6e-7, relative", faint),
        each(&both, "dense", "lambda of 1e6: rays that pass within 1e-2 to 1e-5 of the rim", dense),
        each(&base, "through-centre", "d of 0 to 1e-3: d² ln d tends to 0", through_centre),
        each(&base, "grazing", "d = r (1 - 1e-4) at a depth of 1000, relative", grazing),
        each(&base, "thin-segment", "a segment of 1e-5 r between near and a solid point, relative", thin_segment),
        each(&both, "far-segment", "the same at a depth of 65536, relative", far_segment),
        each(&both, "inside-one", "the camera in a sphere: what lies before near is no part of it", inside_one),
        each(&both, "inside-many", "the camera in 300 spheres", inside_many),
        each(
            &both,
            "near-plane",
            "a sphere cut through its centre by near: 1 - exp(-λ r²/2) and 1 - exp(-λ r)",
            near_plane,
        ),
        each(&both, "solid", "cut by a solid point off the axis: at z / cos φ along the ray", solid),
        each(&all, "no-radius", "radii of 0, 1e-45 and 1e-20: nothing", no_radius),
        each(&both, "huge-radius", "radii of 1e3 to 3.4e38 around the camera: opaque, of their color", huge_radius),
        each(&both, "open-300", "300 spheres open at once, of other colors, against float64", open_300),
        each(&both, "coincident", "300 equal spheres: 1 - exp(-300 x)", coincident),
        each(&base, "far-away", "a sphere of radius 1 at a distance of 1000, 1 degree wide, against float64", far_away),
        each(&base, "quantised", "d and color of 32 spheres are not cut to 8 bits", quantised),
        each(&concentric, "shells-add-up", "1 to 64 shells: 1 - exp(-2 λ r), whatever their number", shells_add_up),
        each(
            &both,
            "leftover",
            "what 300 spheres leave of the running sums when they end, behind them one of weight 0.008",
            leftover,
        ),
        each(&all, "reversed", "coincident spheres of other colors, input reversed: no byte changes", reversed),
        each(&all, "softness-0-and-1", "nothing of softness 0, opaque of softness 1", extremes),
        each(&all, "modulated", "Eq. 22 half-way between threshold and modulation", modulated),
        each(
            &express,
            "along-the-axis",
            "200 discs along the axis of the view, shuffled, against float64",
            along_the_axis,
        ),
        each(&express, "faint", "10 000 discs of opacity 1e-6: 1 - (1 - 1e-6)^10000", faint_discs),
        each(&layer, "coincident-layer", "the nearest soft points are one layer, however many they are", one_layer),
    ]
    .into_iter()
    .flatten()
    .collect()
}

fn with(method: Method, change: impl Fn(&mut Soft)) -> Method {
    let mut method = method;
    if let Method::SoftBase(soft) | Method::SoftConcentric(soft) | Method::SoftExpress(soft) = &mut method {
        change(soft);
    }
    method
}

fn lambda(method: Method, lambda: f32) -> Method {
    with(method, |soft| soft.density = Density::Lambda(lambda))
}

/// A soft sphere of which the ray of a pixel passes at a distance, above it.
fn beside(x: u32, distance: f64, depth: f64, radius: f32) -> Dot {
    let position = at(x, 0, depth) + DVec3::Y * distance;
    Dot { position, radius, color: Vec3::new(0.25, 0.5, 1.0), field: 1.0, ..Dot::default() }
}

/// The integral of ρ over a whole chord.
fn chord(radius: f64, distance: f64) -> f64 {
    2.0 * antiderivative(radius, distance, ((radius - distance) * (radius + distance)).sqrt())
}

fn opacity(depth: f64) -> f64 {
    -(-depth).exp_m1()
}

/// The image in float64.
fn truth(dots: &[Dot], camera: &Camera, size: [u32; 2], method: Method) -> Vec<[f64; 4]> {
    let points = cloud(dots);
    let colors: Vec<DVec3> = points.colors.iter().map(|color| color.as_dvec3()).collect();
    let Some(model) = Model::new(method, &points) else { unreachable!("a soft method") };
    Scene { camera, size, points: &points, colors: &colors, model }.render(|_| Behind::NOTHING).rgba
}

/// What an opacity may be off at most: the quadrature, of which x exp(-x) ≤ 1/e is seen; the distance of the ray, on which an
/// optical depth depends by at most 2 λ r for each sphere (Eq. 5, by d), or 8 λ for each one of three shells (Eq. 15); the
/// exponential (3 + 2 x units, times exp(-x)); weights of colors, of which the mean is above 0.1; four roundings for each of
/// two segments of a sphere.
fn bound(spheres: usize, lambda: f64, radius: f64) -> f64 {
    let n = spheres as f64;
    let distance = n * lambda * radius * (2.0 * radius).max(8.0) * DISTANCE;
    INTEGRAL / E + distance + 10.0 * DISTANCE + 4.0 * ULP + n * 8.0 * HALF_ULP
}

/// An image against float64; `naive` is another one.
fn against_float64(
    stage: &mut Stage,
    dots: &[Dot],
    (camera, size): (Camera, [u32; 2]),
    method: Method,
    bound: f64,
    naive: &[[f32; 4]],
) -> Found {
    let wanted = truth(dots, &camera, size, method);
    let image = stage.image(dots, camera, size, method)?;
    Ok(Finding { error: pixels_apart(&image.rgba, &wanted), bound, naive: pixels_apart(naive, &wanted) })
}

fn relative(found: f32, wanted: f64) -> f64 {
    apart(&[found], &[wanted]) / wanted
}

fn faint(stage: &mut Stage, method: Method) -> Found {
    let dots = [Dot { color: Vec3::ONE, ..beside(0, 0.3, 10.0, 1.0) }];
    let method = lambda(method, 1e-6);
    let wanted = truth(&dots, &pixels([1, 1]), [1, 1], method)[0][3];
    let found = stage.pixel(&dots, method)?[3];
    let depth = -(-wanted).ln_1p() as f32;
    // d(depth)/depth is at most 4 of the relative error of d here, where d = 0.3 r.
    let bound = INTEGRAL + 4.0 * DISTANCE + 8.0 * ULP;
    Ok(Finding { error: relative(found, wanted), bound, naive: relative(1.0 - (-depth).exp(), wanted) })
}

fn dense(stage: &mut Stage, method: Method) -> Found {
    let edges = [1e-2, 3e-3, 1e-3, 5e-4, 2e-4, 1e-4, 3e-5, 1e-5];
    let sphere = |(x, edge): (u32, &f64)| beside(x, 0.25 * (1.0 - edge), 1000.0, 0.25);
    let dots: Vec<Dot> = (0..).zip(&edges).map(sphere).collect();
    let (size, method) = ([8, 1], lambda(method, 1e6));
    let naive = naive::Soft::new(1e6).image(&dots, &pixels(size), size);
    // Placed in two floats: the distance from the rim is rounded as such, a few times, and counts to the power 1.5.
    let bound = (INTEGRAL + 1.5 * 16.0 * ULP) / E + 8.0 * ULP;
    against_float64(stage, &dots, (pixels(size), size), method, bound, &naive)
}

fn through_centre(stage: &mut Stage, method: Method) -> Found {
    let distances = [0.0, 1e-40, 1e-30, 1e-20, 1e-10, 1e-6, 1e-4, 1e-3];
    let dots: Vec<Dot> = (0..).zip(&distances).map(|(x, d)| beside(x, *d, 10.0, 0.25)).collect();
    let size = [8, 1];
    let naive = naive::Soft::new(16.0).image(&dots, &pixels(size), size);
    against_float64(stage, &dots, (pixels(size), size), lambda(method, 16.0), bound(1, 16.0, 0.25), &naive)
}

fn grazing(stage: &mut Stage, method: Method) -> Found {
    let dots = [beside(0, 0.25 * (1.0 - 1e-4), 1000.0, 0.25)];
    let wanted = truth(&dots, &pixels([1, 1]), [1, 1], method)[0][3];
    let found = stage.pixel(&dots, method)?[3];
    let naive = naive::Soft::new(1.0).pixel(&dots, &pixels([1, 1]), [1, 1], [0, 0])[3];
    // The error of d over r - d, to the power 1.5.
    let bound = 1.5 * DISTANCE / 1e-4;
    Ok(Finding { error: relative(found, wanted), bound, naive: relative(naive, wanted) })
}

/// A sphere of radius 1, cut by near and a solid point behind it: what is seen of it, and what the naive formula finds.
fn segment(stage: &mut Stage, method: Method, near: f64, center: f64) -> Found {
    let length = 2f64.powi(-17);
    let sphere = Dot { color: Vec3::ONE, ..beside(0, 0.25, center, 1.0) };
    let wall = Dot { field: 0.0, color: Vec3::ZERO, ..beside(0, 0.0, near + length, 1.0) };
    let camera = Camera { near, ..pixels([1, 1]) };
    let method = lambda(method, 1e5);
    let image = stage.image(&[sphere, wall], camera, [1, 1], method)?;
    let density = match method {
        Method::SoftBase(_) => {
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
    // Both ends are exact in float32, relative to where depths are counted from; so is the centre. The place of the segment in
    // the sphere is rounded by a unit of 0.5, which is nothing to ρ, and its length by as much: a unit of 0.5 / 2^-17.
    let place = if matches!(method, Method::SoftBase(_)) { 2.0 * HALF_ULP / length } else { 0.0 };
    let bound = INTEGRAL + place + 4.0 * DISTANCE + 16.0 * ULP;
    Ok(Finding { error: relative(image.rgba[0][0], wanted), bound, naive: relative(naive, wanted) })
}

fn thin_segment(stage: &mut Stage, method: Method) -> Found {
    segment(stage, method, 8.0, 8.5)
}

fn far_segment(stage: &mut Stage, method: Method) -> Found {
    segment(stage, method, 65536.0, 65536.5)
}

fn wide(degrees: f64, near: f64) -> Camera {
    let projection = Projection::Perspective { fov_y: degrees.to_radians() };
    Camera::look_at(DVec3::ZERO, DVec3::NEG_Z, DVec3::Y, projection, near, 1e6)
        .unwrap_or_else(|| unreachable!("looks along an axis"))
}

fn inside_one(stage: &mut Stage, method: Method) -> Found {
    let (camera, size) = (wide(90.0, 0.01), [8, 6]);
    let dots = [Dot { position: DVec3::new(0.2, -0.1, -0.3), ..beside(0, 0.0, 0.0, 1.0) }];
    let naive = naive::Soft::new(1.0).image(&dots, &camera, size);
    against_float64(stage, &dots, (camera, size), method, bound(1, 1.0, 1.0), &naive)
}

/// Spheres that all hold the origin, of radii from 1 to 1.5, within 0.4 of it and before it.
fn around_the_origin() -> Vec<Dot> {
    let of = |i: u32| {
        // The golden angle spreads them, and their colors are any.
        let (turn, part) = (2.399_963 * f64::from(i), f64::from(i) / 300.0);
        let position = DVec3::new(0.2 * turn.cos(), 0.2 * turn.sin(), -0.05 - 0.3 * part);
        let color = Vec3::new((i % 7) as f32 / 6.0, (i % 5) as f32 / 4.0, (i % 3) as f32 / 2.0);
        Dot { position, radius: 1.0 + (i * 37 % 300) as f32 / 600.0, color, field: 1.0, ..Dot::default() }
    };
    (0..300).map(of).collect()
}

fn inside_many(stage: &mut Stage, method: Method) -> Found {
    let (camera, size, dots) = (wide(60.0, 0.01), [4, 3], around_the_origin());
    let method = lambda(method, 0.01);
    let naive = naive::Soft { limits: [0.01, f32::INFINITY], most_open: 64, ..naive::Soft::new(0.01) };
    let naive = naive.image(&dots, &camera, size);
    against_float64(stage, &dots, (camera, size), method, bound(300, 0.01, 1.5), &naive)
}

fn near_plane(stage: &mut Stage, method: Method) -> Found {
    let dots = [beside(0, 0.0, 10.0, 2.0)];
    let camera = Camera { near: 10.0, ..pixels([1, 1]) };
    let image = stage.image(&dots, camera, [1, 1], lambda(method, 0.25))?;
    // λ r² / 2 of a sphere with r = 2, and λ r of any number of shells.
    let half = 0.25 * 2.0;
    let found = [image.rgba[0][3], image.depth[0]];
    let naive = apart(&[opacity(2.0 * half) as f32], &[opacity(half)]);
    Ok(Finding { error: apart(&found, &[opacity(half), 10.0]), bound: bound(1, 0.25, 2.0), naive })
}

fn solid(stage: &mut Stage, method: Method) -> Found {
    // A wall through the sphere's middle, before a wide view: 60 degrees off the axis a ray is twice as long.
    let (camera, size) = (wide(120.0, 0.01), [9, 9]);
    let sphere = Dot { position: DVec3::new(0.0, 0.0, -2.0), ..beside(0, 0.0, 0.0, 8.0) };
    let wall = Dot { position: DVec3::NEG_Z * 2.0, radius: 50.0, color: Vec3::ZERO, ..Dot::default() };
    let method = lambda(method, 0.01);
    let image = stage.image(&[sphere, wall], camera, size, method)?;
    let points = cloud(&[sphere]);
    let Some(model) = Model::new(method, &points) else { unreachable!("a soft method") };
    let colors = [sphere.color.as_dvec3()];
    let scene = Scene { camera: &camera, size, points: &points, colors: &colors, model };
    // The wall's drawn radius is 25 pixels at most: more than the image.
    let behind = |depth| Behind { color: DVec3::ZERO, alpha: 1.0, depth };
    let wanted = scene.render(|_| behind(2.0)).rgba;
    let cut_short = scene.render(|pixel| {
        let ray = Ray::new(&camera, size, [pixel as u32 % 9, pixel as u32 / 9]);
        behind(2.0 / ray.stretch)
    });
    let naive: Vec<[f32; 4]> = cut_short.rgba.iter().map(|pixel| pixel.map(|c| c as f32)).collect();
    let error = pixels_apart(&image.rgba, &wanted);
    Ok(Finding { error, bound: bound(1, 0.01, 8.0), naive: pixels_apart(&naive, &wanted) })
}

fn no_radius(stage: &mut Stage, method: Method) -> Found {
    let radii = [0.0, 1e-45, 1e-20];
    let dots: Vec<Dot> = (0..).zip(radii).map(|(x, radius)| beside(x, 0.0, 10.0, radius)).collect();
    let image = stage.image(&dots, pixels([3, 1]), [3, 1], method)?;
    let wanted: Vec<[f64; 4]> = match method {
        // A disc covers the pixel of its centre, of which it is the middle, unless it has no radius at all.
        Method::SoftExpress(_) => [0.0, 0.5, 0.5].map(|a: f64| [a / 4.0, a / 2.0, a, a]).to_vec(),
        _ => vec![[0.0; 4]; 3],
    };
    // 1 - d / r of no radius is no number.
    Ok(Finding { error: pixels_apart(&image.rgba, &wanted), bound: 4.0 * HALF_ULP, naive: f64::INFINITY })
}

fn huge_radius(stage: &mut Stage, method: Method) -> Found {
    let (mut error, mut naive) = (0f64, 0f64);
    for radius in [1e3, 1e10, 1e20, f32::MAX] {
        let dots = [beside(0, 0.0, 10.0, radius)];
        let wanted = [0.25, 0.5, 1.0, 1.0];
        error = error.max(apart(&stage.pixel(&dots, method)?, &wanted));
        naive = naive.max(apart(&naive::Soft::new(1.0).pixel(&dots, &pixels([1, 1]), [1, 1], [0, 0]), &wanted));
    }
    // Opaque at once: one product and one quotient.
    Ok(Finding { error, bound: 4.0 * ULP, naive })
}

fn open_300(stage: &mut Stage, method: Method) -> Found {
    let dots: Vec<Dot> = around_the_origin();
    let projection = Projection::Orthographic { height: 0.2 };
    let camera = Camera { projection, eye: DVec3::Z * 5.0, ..wide(90.0, 0.5) };
    let naive = naive::Soft { most_open: 64, ..naive::Soft::new(0.01) }.image(&dots, &camera, [4, 3]);
    against_float64(stage, &dots, (camera, [4, 3]), lambda(method, 0.01), bound(300, 0.01, 1.5), &naive)
}

fn coincident(stage: &mut Stage, method: Method) -> Found {
    let one = beside(0, 0.7, 10.0, 2.0);
    let method = lambda(method, 0.002);
    let single = -(-truth(&[one], &pixels([1, 1]), [1, 1], method)[0][3]).ln_1p();
    let alpha = opacity(300.0 * single);
    let wanted = [0.25, 0.5, 1.0, 1.0].map(|c| c * alpha);
    let found = stage.pixel(&vec![one; 300], method)?;
    // Keyed by depth, one of them is left.
    let lost = [0.25, 0.5, 1.0, 1.0].map(|c| (c * opacity(single)) as f32);
    Ok(Finding { error: apart(&found, &wanted), bound: bound(300, 0.002, 2.0), naive: apart(&lost, &wanted) })
}

fn far_away(stage: &mut Stage, method: Method) -> Found {
    let dots = [Dot { position: DVec3::new(0.3, 0.1, -1000.0), ..beside(0, 0.0, 0.0, 1.0) }];
    let (camera, size) = (wide(0.25, 1.0), [12, 9]);
    let naive = naive::Soft::new(1.0).image(&dots, &camera, size);
    // Directions of 1/1000 are as exact as any.
    against_float64(stage, &dots, (camera, size), method, bound(1, 1.0, 1.0), &naive)
}

fn quantised(stage: &mut Stage, method: Method) -> Found {
    let sphere =
        |x: u32| Dot { color: Vec3::new(x as f32 / 31.3, 0.123, 0.777), ..beside(x, f64::from(x) / 140.0, 10.0, 0.25) };
    let dots: Vec<Dot> = (0..32).map(sphere).collect();
    let (size, method) = ([32, 1], lambda(method, 16.0));
    let packed = truth(&dots, &pixels(size), size, with(method, |soft| soft.layout = SoftLayout::Paper));
    let naive: Vec<[f32; 4]> = packed.iter().map(|pixel| pixel.map(|c| c as f32)).collect();
    against_float64(stage, &dots, (pixels(size), size), method, bound(1, 16.0, 0.25), &naive)
}

fn shells_add_up(stage: &mut Stage, method: Method) -> Found {
    let dots = [beside(0, 0.0, 10.0, 2.0)];
    let wanted = [opacity(0.25 * 2.0 * 2.0)];
    let mut error = 0f64;
    for shells in [1, 2, 4, 16, 64] {
        let method = with(lambda(method, 0.25), |soft| soft.shells = Shells::Fixed(shells));
        error = error.max(apart(&stage.pixel(&dots, method)?[3..], &wanted));
    }
    // Eq. 17 as printed counts the innermost shell alone: for two shells 3/4 of the sum.
    let naive = apart(&[opacity(0.75 * 0.25 * 2.0 * 2.0) as f32], &wanted);
    // Lengths of 64 segments come from depths around 10, relative to where they are counted from: a unit of 2 for each end.
    let lengths = 0.25 * 128.0 * 2.0 * HALF_ULP;
    Ok(Finding { error, bound: bound(64, 0.25, 2.0) + lengths, naive })
}

fn leftover(stage: &mut Stage, method: Method) -> Found {
    // A large red sphere that the ray grazes, and many small blue ones in its first half, all open at once.
    let red = Dot { color: Vec3::X, ..beside(0, 63.5, 100.0, 64.0) };
    let blue = |i: u32| {
        let distance = 0.19 * f64::from(i * 7 % 300) / 300.0;
        Dot { color: Vec3::Z, ..beside(0, distance, 95.0 + f64::from(i) / 3000.0, 0.2) }
    };
    let dots: Vec<Dot> = (0..300).map(blue).chain([red]).collect();
    let (size, method) = ([1, 1], lambda(method, 0.04));
    let naive = naive::Soft::new(0.04).image(&dots, &pixels(size), size);
    // Where red is alone, its weight cancels. Its own distance from the rim is 1/128 of the radius, so that an error of d
    // counts 128-fold, to the power 1.5, in an optical depth of 0.2; as its weight among the blue ones it is nothing.
    let own = 1.5 * 128.0 * DISTANCE * 0.2;
    against_float64(
        stage,
        &dots,
        (pixels(size), size),
        method,
        INTEGRAL / E + own + 600.0 * 4.0 * HALF_ULP * 0.2,
        &naive,
    )
}

fn reversed(stage: &mut Stage, method: Method) -> Found {
    let color = |i: u32| Vec3::new((i % 7) as f32 / 7.0, (i % 5) as f32 / 5.0, (i % 3) as f32 / 3.0);
    let dots: Vec<Dot> =
        (0..60).map(|i| Dot { color: color(i), opacity: 0.1, ..beside(0, 0.3, f64::from(10 + i / 20), 1.0) }).collect();
    let backward: Vec<Dot> = dots.iter().rev().copied().collect();
    let method = with(method, |soft| soft.density = Density::Softness(0.05));
    let first = stage.image(&dots, pixels([1, 1]), [1, 1], method)?;
    let second = stage.image(&backward, pixels([1, 1]), [1, 1], method)?;
    let naive = |dots: &[Dot]| match method {
        Method::SoftExpress(_) => over(dots),
        _ => naive::Soft::new(0.05).pixel(dots, &pixels([1, 1]), [1, 1], [0, 0]),
    };
    let differ = naive(&dots).iter().zip(naive(&backward)).filter(|(a, b)| **a != *b).count();
    Ok(Finding { error: bytes_apart(&first, &second), bound: 0.0, naive: differ as f64 })
}

fn extremes(stage: &mut Stage, method: Method) -> Found {
    let dots = [beside(0, 0.0, 10.0, 1.0)];
    let none = stage.pixel(&dots, with(method, |soft| soft.density = Density::Softness(0.0)))?;
    let all = stage.pixel(&dots, with(method, |soft| soft.density = Density::Softness(1.0)))?;
    let error = apart(&none, &[0.0; 4]).max(apart(&all, &[0.25, 0.5, 1.0, 1.0]));
    // λ is infinite, times a chord's end at which ρ is 0.
    Ok(Finding { error, bound: 4.0 * ULP, naive: f64::INFINITY })
}

fn modulated(stage: &mut Stage, method: Method) -> Found {
    let (radius, distance, peak) = (1.0f64, 0.25, 0.5);
    let dots = [Dot { field: 0.75, color: Vec3::ONE, ..beside(0, distance, 10.0, 1.0) }];
    let change = |soft: &mut Soft| {
        (soft.density, soft.modulation, soft.shells) = (Density::Softness(peak as f32), Some(1.0), Shells::Fixed(1));
    };
    let found = stage.pixel(&dots, with(method, change))?[3];
    let plain = match method {
        Method::SoftExpress(_) => peak * ((PI * distance / radius).cos() + 1.0) / 2.0,
        Method::SoftBase(_) => opacity(-(-peak).ln_1p() * chord(radius, distance) / (radius * radius)),
        // One shell: λ μ' and the chord.
        _ => {
            let length = 2.0 * ((radius - distance) * (radius + distance)).sqrt();
            opacity(-(-peak).ln_1p() / (2.0 * radius) * (1.0 - distance / radius) * length)
        }
    };
    let wanted = peak * (1.0 - distance / radius) * 0.5 + plain * 0.5;
    // The law of the disc's profile is within 3e-7 (shaders/shared/profile.wgsl).
    let error = apart(&[found], &[wanted]);
    Ok(Finding { error, bound: bound(1, 0.7, 1.0) + 3e-7, naive: apart(&[plain as f32], &[wanted]) })
}

fn along_the_axis(stage: &mut Stage, method: Method) -> Found {
    let color = |i: u32| Vec3::new((i % 2) as f32, (i % 3) as f32 / 2.0, i as f32 / 200.0);
    // Through the middle, so that the opacity is λ itself.
    let disc = |i: u32| Dot { field: 1.0, radius: 0.25, opacity: 0.02, ..dot(1.0 + f64::from(i), color(i), 1.0) };
    let dots: Vec<Dot> = (0..200).map(disc).collect();
    let wanted = composed(&dots);
    let mut shuffled = dots;
    shuffled.rotate_left(77);
    shuffled[..100].reverse();
    let method = with(method, |soft| soft.density = Density::Softness(0.02));
    let found = stage.pixel(&shuffled, method)?;
    // Four roundings of each of a sum of at most 1.
    Ok(Finding {
        error: apart(&found, &wanted),
        bound: 200.0 * 4.0 * HALF_ULP,
        naive: apart(&over(&shuffled), &wanted),
    })
}

fn faint_discs(stage: &mut Stage, method: Method) -> Found {
    let disc = |i: u32| Dot { field: 1.0, radius: 0.25, ..dot(1.0 + f64::from(i), Vec3::ONE, 1e-6) };
    let dots: Vec<Dot> = (0..10_000).map(disc).collect();
    let wanted = composed(&dots);
    let found = stage.pixel(&dots, lambda(method, 1e-6))?;
    let bound = 10_000.0 * 4.0 * HALF_ULP * wanted[3];
    Ok(Finding { error: apart(&found, &wanted), bound, naive: apart(&over(&dots), &wanted) })
}

fn one_layer(stage: &mut Stage, method: Method) -> Found {
    let soft = |color| Dot { field: 1.0, radius: 0.25, ..dot(2.0, color, 1.0) };
    let blue = Dot { radius: 0.25, ..dot(6.0, Vec3::Z, 1.0) };
    let image = stage.image(&[soft(Vec3::X), soft(Vec3::X), blue], pixels([1, 1]), [1, 1], method)?;
    let found = [image.rgba[0].as_slice(), &[image.depth[0]]].concat();
    // All of them powers of two. Blended one by one, two points of softness 1/2 hide 3/4.
    Ok(Finding { error: apart(&found, &[0.5, 0.0, 0.5, 1.0, 2.0]), bound: 0.0, naive: 0.25 })
}
