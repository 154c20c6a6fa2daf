//! Spheres that are cut, and many of them at a time.

use std::f64::consts::E;

use super::{CaseResult, DISTANCE, INTEGRAL, against_float64, beside, bound, lambda, opacity, truth, wide};
use crate::check::prelude::*;
use pellucid_reference::soft::{Behind, Model, Ray, Scene};
use pellucid_scene::{Density, SoftMethod};

pub(super) fn inside_one(stage: &mut CaseRenderer, method: SoftMethod) -> CaseResult {
    let (camera, size) = (wide(90.0, 0.01), [8, 6]);
    let dots = [Dot { position: DVec3::new(0.2, -0.1, -0.3), ..beside(0, 0.0, 0.0, 1.0) }];
    against_float64(stage, &dots, (camera, size), method, bound(1, 1.0, 1.0), naive::Soft::new(1.0))
}

/// Spheres that all hold the origin, of radii from 1 to 1.5, within 0.4 of it and before it.
fn around_the_origin() -> Vec<Dot> {
    let sphere = |i: u32| {
        // The golden angle spreads them, and their colors are any.
        let (turn, part) = (2.399_963 * f64::from(i), f64::from(i) / 300.0);
        let position = DVec3::new(0.2 * turn.cos(), 0.2 * turn.sin(), -0.05 - 0.3 * part);
        Dot { position, radius: 1.0 + (i * 37 % 300) as f32 / 600.0, color: mixed(i), field: 1.0, ..Dot::default() }
    };
    (0..300).map(sphere).collect()
}

pub(super) fn inside_many(stage: &mut CaseRenderer, method: SoftMethod) -> CaseResult {
    let (camera, size, dots) = (wide(60.0, 0.01), [4, 3], around_the_origin());
    let method = lambda(method, 0.01);
    let naive = naive::Soft { limits: [0.01, f32::INFINITY], most_open: 64, ..naive::Soft::new(0.01) };
    against_float64(stage, &dots, (camera, size), method, bound(300, 0.01, 1.5), naive)
}

pub(super) fn near_plane(stage: &mut CaseRenderer, method: SoftMethod) -> CaseResult {
    let dots = [beside(0, 0.0, 10.0, 2.0)];
    let camera = Camera { near: 10.0, ..pixels([1, 1]) };
    let image = stage.image(&dots, camera, [1, 1], lambda(method, 0.25))?;
    // λ r² / 2 of a sphere with r = 2, and λ r of any number of shells.
    let half = 0.25 * 2.0;
    let found = [image.rgba[0][3], image.depth[0]];
    let naive = apart(&[opacity(2.0 * half) as f32], &[opacity(half)]);
    Ok(Finding::new(apart(&found, &[opacity(half), 10.0]), bound(1, 0.25, 2.0), naive))
}

pub(super) fn solid(stage: &mut CaseRenderer, method: SoftMethod) -> CaseResult {
    // A wall through the sphere's middle, before a wide view: 60 degrees off the axis a ray is twice as long.
    let (camera, size) = (wide(120.0, 0.01), [9, 9]);
    let sphere = Dot { position: DVec3::new(0.0, 0.0, -2.0), ..beside(0, 0.0, 0.0, 8.0) };
    let wall = Dot { position: DVec3::NEG_Z * 2.0, radius: 50.0, color: Vec3::ZERO, ..Dot::default() };
    let method = lambda(method, 0.01);
    let image = stage.image(&[sphere, wall], camera, size, method)?;
    let points = cloud(&[sphere]);
    let model = Model::new(method, &points);
    let colors = [sphere.color.as_dvec3()];
    let view = View::new(&camera, size);
    let scene = Scene { view, points: &points, colors: &colors, model };
    // The wall's drawn radius is 25 pixels at most: more than the image.
    let behind = |depth| Behind { color: DVec3::ZERO, alpha: 1.0, depth };
    let wanted = scene.render(|_| behind(2.0)).rgba;
    let cut_short = scene.render(|pixel| {
        let ray = Ray::new(view, [pixel as u32 % 9, pixel as u32 / 9]);
        behind(2.0 / ray.stretch)
    });
    let naive: Vec<[f32; 4]> = cut_short.rgba.iter().map(|pixel| pixel.map(|c| c as f32)).collect();
    Ok(Finding::pixels(&image.rgba, &naive, &wanted, bound(1, 0.01, 8.0)))
}

pub(super) fn open_300(stage: &mut CaseRenderer, method: SoftMethod) -> CaseResult {
    let dots: Vec<Dot> = around_the_origin();
    let projection = Projection::Orthographic { height: 0.2 };
    let camera = Camera { projection, eye: DVec3::Z * 5.0, ..wide(90.0, 0.5) };
    let naive = naive::Soft { most_open: 64, ..naive::Soft::new(0.01) };
    against_float64(stage, &dots, (camera, [4, 3]), lambda(method, 0.01), bound(300, 0.01, 1.5), naive)
}

pub(super) fn coincident(stage: &mut CaseRenderer, method: SoftMethod) -> CaseResult {
    let one = beside(0, 0.7, 10.0, 2.0);
    let method = lambda(method, 0.002);
    let single = -(-truth(&[one], &pixels([1, 1]), [1, 1], method)[0][3]).ln_1p();
    let alpha = opacity(300.0 * single);
    let wanted = [0.25, 0.5, 1.0, 1.0].map(|c| c * alpha);
    let found = stage.pixel(&vec![one; 300], method)?;
    // Keyed by depth, one of them is left.
    let lost = [0.25, 0.5, 1.0, 1.0].map(|c| (c * opacity(single)) as f32);
    Ok(Finding::apart(&found, &lost, &wanted, bound(300, 0.002, 2.0)))
}

pub(super) fn leftover(stage: &mut CaseRenderer, method: SoftMethod) -> CaseResult {
    // A large red sphere that the ray grazes, and many small blue ones in its first half, all open at once.
    let red = Dot { color: Vec3::X, ..beside(0, 63.5, 100.0, 64.0) };
    let blue = |i: u32| {
        let distance = 0.19 * f64::from(i * 7 % 300) / 300.0;
        Dot { color: Vec3::Z, ..beside(0, distance, 95.0 + f64::from(i) / 3000.0, 0.2) }
    };
    let dots: Vec<Dot> = (0..300).map(blue).chain([red]).collect();
    let (size, method) = ([1, 1], lambda(method, 0.04));
    // Where red is alone, its weight cancels. Its own distance from the rim is 1/128 of the radius, so that an error of
    // d counts 128-fold, to the power 1.5, in an optical depth of 0.2; its weight among the blue ones is negligible.
    let own = 1.5 * 128.0 * DISTANCE * 0.2;
    let bound = INTEGRAL / E + own + 600.0 * 4.0 * HALF_ULP * 0.2;
    against_float64(stage, &dots, (pixels(size), size), method, bound, naive::Soft::new(0.04))
}

pub(super) fn reversed(stage: &mut CaseRenderer, method: SoftMethod) -> CaseResult {
    // Multiples of the golden ratio, less their whole part: no two sums of them round alike.
    let part = |i: u32, k: f32| (i as f32 * k * 0.618_034).fract();
    let color = |i: u32| Vec3::new(part(i, 1.0), part(i, 3.0), part(i, 7.0));
    let dots: Vec<Dot> = (0..300)
        .map(|i| Dot { color: color(i), opacity: 0.01, ..beside(0, 0.3, f64::from(10 + i / 100), 1.0) })
        .collect();
    let backward: Vec<Dot> = dots.iter().rev().copied().collect();
    let method = method.changed(|soft| soft.density = Density::Softness(0.01));
    let first = stage.image(&dots, pixels([1, 1]), [1, 1], method)?;
    let second = stage.image(&backward, pixels([1, 1]), [1, 1], method)?;
    let naive = |dots: &[Dot]| match method {
        SoftMethod::Express(_) => over(dots),
        _ => naive::Soft::new(0.01).pixel(dots, &pixels([1, 1]), [1, 1], [0, 0]),
    };
    let differ = naive(&dots).iter().zip(naive(&backward)).filter(|(a, b)| **a != *b).count();
    Ok(Finding::new(bytes_apart(&first, &second), 0.0, differ as f64))
}

pub(super) fn along_the_axis(stage: &mut CaseRenderer, method: SoftMethod) -> CaseResult {
    // Through the middle, so that the opacity is λ itself.
    let disc = |i: u32| Dot { field: 1.0, radius: 0.25, opacity: 0.02, ..dot(1.0 + f64::from(i), graded(i, 200), 1.0) };
    let dots: Vec<Dot> = (0..200).map(disc).collect();
    let wanted = composed(&dots);
    let mut shuffled = dots;
    shuffled.rotate_left(77);
    shuffled[..100].reverse();
    let method = method.changed(|soft| soft.density = Density::Softness(0.02));
    // Four roundings of each of a sum of at most 1.
    stage.compare(&shuffled, method, &over(&shuffled), &wanted, 200.0 * 4.0 * HALF_ULP)
}

pub(super) fn faint_discs(stage: &mut CaseRenderer, method: SoftMethod) -> CaseResult {
    let disc = |i: u32| Dot { field: 1.0, radius: 0.25, ..dot(1.0 + f64::from(i), Vec3::ONE, 1e-6) };
    let dots: Vec<Dot> = (0..10_000).map(disc).collect();
    let wanted = composed(&dots);
    let bound = 10_000.0 * 4.0 * HALF_ULP * wanted[3];
    stage.compare(&dots, lambda(method, 1e-6), &over(&dots), &wanted, bound)
}

pub(super) fn one_layer(stage: &mut CaseRenderer, method: Method) -> CaseResult {
    let soft = |color| Dot { field: 1.0, radius: 0.25, ..dot(2.0, color, 1.0) };
    let blue = Dot { radius: 0.25, ..dot(6.0, Vec3::Z, 1.0) };
    let image = stage.image(&[soft(Vec3::X), soft(Vec3::X), blue], pixels([1, 1]), [1, 1], method)?;
    let found = [image.rgba[0].as_slice(), &[image.depth[0]]].concat();
    let wanted = [0.5, 0.0, 0.5, 1.0, 2.0];
    // All of them powers of two. Blended one by one, two points of softness 1/2 hide 3/4.
    let half = Dot { opacity: 0.5, ..soft(Vec3::X) };
    Ok(Finding::new(apart(&found, &wanted), 0.0, apart(&over(&[half, half, blue]), &wanted[..4])))
}
