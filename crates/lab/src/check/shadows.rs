//! Shadow textures: the share of light that reaches each point, for lights at all angles, among the points, and of an
//! area.

use std::collections::HashSet;
use std::f64::consts::PI;

use super::prelude::*;
use pellucid_core::cloud::Bounds;
use pellucid_core::cloud::shadow_texture::Casting;
use pellucid_engine::methods::shadows::lights;
use pellucid_reference::range::Range;
use pellucid_reference::shadows::{Map, share_ranges};
use pellucid_scene::{Iterations, Light, MapResolution, Shading, ShadingModel, Shadows};

const DOWN: Light = Light::Direction(DVec3::NEG_Z);
const BY: DVec3 = DVec3::new(500_000.0, 4_500_000.0, 100.0);
/// Depths of a floor and of what covers it.
const FLOOR: f64 = 90.0;
const LID: f64 = 50.0;

pub(super) fn cases() -> Vec<Case> {
    vec![
        one("shadows/slanted", "a plane alone, light up to 80 degrees off its normal: dark points", slanted),
        one(
            "shadows/behind",
            "a plane behind one whose points don't cover all pixels of the light: lit points",
            behind,
        ),
        one("shadows/half-a-disc", "half of an area light covered: 0.5, in 4 standard errors", half_a_disc),
        one("shadows/inside", "a lamp in two spheres: the inner one is lit, the outer one is not", inside),
        one("shadows/georeferenced", "moved by (500000, 4500000, 100): the same shares of light", georeferenced),
        one("shadows/along", "light along a plane: it reaches ten times d̃, and no farther", along),
        one("shadows/one-pixel", "a light's image of one pixel: what is behind its only depth is dark", one_pixel),
        one("shadows/all-equal", "1 and 500 points in one place, the lamp above, beside and in it: lit", all_equal),
        one("shadows/sparse", "scattered points over a floor: thousandths of its points that are lit", sparse),
        one(
            "shadows/seams",
            "a lamp in a ball of scattered points in another: thousandths of that one that are lit",
            seams,
        ),
    ]
}

fn hard(resolution: u32, distance: f32) -> Shadows {
    Shadows {
        samples: 1,
        light_radius: 0.0,
        resolution: MapResolution::Pixels(resolution),
        fill: Iterations::Count(0),
        occlusion: Iterations::Count(1),
        min_layer_distance: Some(distance),
    }
}

fn lit_frame(light: Light, shadows: Shadows, seed: u64) -> Frame {
    let shading = Shading { model: ShadingModel::Lambert, ambient: 0.0, diffuse: 1.0, light, ..Shading::default() };
    Frame { shading, shadows: Some(shadows), seed, ..Frame::new(pixels([8, 8]), [8, 8], Method::Points) }
}

/// The share of light of each point, as they are in the cloud.
fn shares(stage: &mut CaseRenderer, points: &Points, frame: &Frame) -> Result<Vec<f32>> {
    let mut cloud = stage.renderer.upload(points)?;
    stage.renderer.cast(&mut cloud, frame)?;
    Ok(cloud.lit()?)
}

/// Points whose share is not what it should be.
fn wrong(shares: &[f32], wanted: impl Fn(usize) -> f32) -> f64 {
    shares.iter().enumerate().filter(|(i, m)| **m != wanted(*i)).count() as f64
}

/// A point in the middle of each pixel, moved a little.
fn sheet(columns: std::ops::Range<i32>, rows: std::ops::Range<i32>, depth: f64, by: f64, normal: Vec3) -> Vec<Dot> {
    let place = |x: i32, y: i32| DVec3::new(f64::from(x) + 0.5 + by, -(f64::from(y) + 0.5 + by), -depth);
    let point = |(x, y)| Dot { position: place(x, y), normal, ..Dot::default() };
    rows.flat_map(|y| columns.clone().map(move |x| (x, y))).map(point).collect()
}

fn slanted(stage: &mut CaseRenderer) -> CaseResult {
    let resolution = 16;
    let across = 1.5 * 48f64.hypot(40.0) / f64::from(resolution - 2);
    // Over a pixel of the light, from corner to corner, depths of a plane differ by tan θ of its width, and the filter
    // takes them from the next: two of them. Three pixels over cos θ are more, for any θ.
    let shadows = hard(resolution, 3.0 * across as f32);
    let (mut error, mut naive) = (0.0, 0.0);
    for degrees in [0.0, 30.0, 60.0, 80.0f64] {
        let (sin, cos) = degrees.to_radians().sin_cos();
        let (turned, up) = 20f64.to_radians().sin_cos();
        let light = Light::Direction(DVec3::new(sin * up, sin * turned, -cos));
        let mut dark = |normal| -> Result<f64> {
            let points = cloud(&sheet(0..48, 0..40, 400.0, 0.0, normal));
            Ok(wrong(&shares(stage, &points, &lit_frame(light, shadows, 0))?, |_| 1.0))
        };
        error += dark(Vec3::Z)? + dark(Vec3::NEG_Z)?;
        // The same d̃ for every angle, as without a normal.
        naive += dark(Vec3::ZERO)?;
    }
    Ok(Finding::new(error, 0.0, naive))
}

/// The pixels of a light's image onto which some points fall.
fn hit(camera: &Camera, resolution: u32, positions: &[DVec3]) -> Vec<[u32; 2]> {
    let pixel = |p: &DVec3| camera.project(*p, [resolution, resolution]).0.to_array().map(|c| c as u32);
    positions.iter().map(pixel).collect()
}

fn behind(stage: &mut CaseRenderer) -> CaseResult {
    let resolution = 44;
    // Pixels of the light are 32 / 42 units wide: two adjacent columns or rows of them are never free. The lid extends
    // beyond the floor, so that its border covers none of it.
    let lid = sheet(0..32, 0..32, LID, 0.0, Vec3::ZERO);
    let floor = sheet(2..29, 2..29, FLOOR, 0.37, Vec3::ZERO);
    let points = cloud(&[lid, floor].concat());
    let found = shares(stage, &points, &lit_frame(DOWN, hard(resolution, 5.0), 0))?;
    let is_floor = |p: &DVec3| p.z == -FLOOR;
    let error = wrong(&found, |i| if is_floor(&points.positions[i]) { 0.0 } else { 1.0 });
    // Without the filter of occluded pixels light falls through the free ones.
    let mut naive = 0;
    if let Some(bounds) = points.bounds() {
        for view in lights::views(DOWN, &bounds, resolution, 1) {
            let (below, above): (Vec<DVec3>, Vec<DVec3>) = points.positions.iter().partition(|p| is_floor(p));
            let covered: HashSet<[u32; 2]> = hit(&view.camera, resolution, &above).into_iter().collect();
            naive += hit(&view.camera, resolution, &below).iter().filter(|pixel| !covered.contains(*pixel)).count();
        }
    }
    Ok(Finding::new(error, 0.0, naive as f64))
}

fn half_a_disc(stage: &mut CaseRenderer) -> CaseResult {
    let (samples, seeds, resolution, radius) = (100u32, 8, 512, 10.0f64);
    // Right below the border of what covers the left half, at x = 32.
    let below = Dot { position: DVec3::new(32.0, -4.5, -FLOOR), ..Dot::default() };
    let quarter = |dot: &Dot| Dot { position: dot.position * DVec3::new(0.25, 0.25, 1.0), ..*dot };
    let lid = sheet(0..128, -64..96, LID, 0.0, Vec3::ZERO);
    let far = Dot { position: DVec3::new(64.0, -4.5, -FLOOR), ..Dot::default() };
    let points = cloud(&[lid.iter().map(quarter).collect(), vec![below, far]].concat());
    let place = points.positions.iter().position(|p| *p == below.position);
    let mut sum = 0.0;
    for seed in 0..seeds {
        let shadows = Shadows { samples, light_radius: radius as f32, ..hard(resolution, 5.0) };
        let found = shares(stage, &points, &lit_frame(DOWN, shadows, seed))?;
        sum += place.map_or(f64::NAN, |place| f64::from(found[place]));
    }
    let mean = sum / seeds as f64;
    // As if the lights were independent. The border is at the last points, an eighth before 32, to a pixel of the
    // light: 64 units of 512 (a chord of the disc near its middle is 2 radii long, its area π of their squares).
    let errors = 4.0 * 0.5 / (f64::from(samples) * seeds as f64).sqrt();
    let reach = (FLOOR - LID) * radius.to_radians().tan();
    let border = (0.125 + 65.0 / f64::from(resolution)) / reach * 2.0 / PI;
    let error = if mean.is_nan() { f64::INFINITY } else { (mean - 0.5).abs() };
    // One light in the middle: fully lit or dark, depending on a point of the lid on its pixel.
    let is_lid = |p: &&DVec3| p.z == -LID;
    let is_covered = points.bounds().is_some_and(|bounds| {
        let views = lights::views(DOWN, &bounds, resolution, 1);
        let pixels = |positions: &[DVec3]| -> HashSet<[u32; 2]> {
            views.iter().flat_map(|view| hit(&view.camera, resolution, positions)).collect()
        };
        let lid: Vec<DVec3> = points.positions.iter().filter(is_lid).copied().collect();
        !pixels(&lid).is_disjoint(&pixels(&[below.position]))
    });
    let naive: f64 = if is_covered { 0.0 } else { 1.0 };
    Ok(Finding::new(error, errors + border, (naive - 0.5).abs()))
}

/// Points all over a sphere, as evenly as on a sunflower.
fn sphere(radius: f64, count: u32) -> impl Iterator<Item = Dot> {
    (0..count).map(move |i| {
        let (z, turn) = (1.0 - (2.0 * f64::from(i) + 1.0) / f64::from(count), 2.399_963 * f64::from(i));
        let ring = (1.0 - z * z).sqrt();
        Dot { position: radius * DVec3::new(ring * turn.cos(), ring * turn.sin(), z), ..Dot::default() }
    })
}

fn inside(stage: &mut CaseRenderer) -> CaseResult {
    let points = cloud(&sphere(10.0, 20_000).chain(sphere(20.0, 5000)).collect::<Vec<_>>());
    let lamp = DVec3::new(0.3, -0.2, 0.1);
    let found = shares(stage, &points, &lit_frame(Light::Position(lamp), hard(16, 3.0), 0))?;
    // In a corner of the cube a pixel is an eighth of a radius wide, and depth along its axis, r cos θ, changes by 0.82
    // of that; over two of them, less than 3. Spheres are 10 cos 55° = 5.7 apart there, minus the 0.4 of the lamp.
    let is_outer = |i: usize| points.positions[i].length() > 15.0;
    let error = wrong(&found, |i| if is_outer(i) { 0.0 } else { 1.0 });
    // A single camera toward the middle: points behind the lamp are in no image, and lit.
    let forward = -lamp.normalize();
    let unseen = |i: &usize| is_outer(*i) && (points.positions[*i] - lamp).dot(forward) <= 0.0;
    let naive = (0..points.len()).filter(unseen).count();
    Ok(Finding::new(error, 0.0, naive as f64))
}

/// Points of [`in_cube`].
fn on_a_grid() -> Vec<Dot> {
    let dot = |i: u32| Dot {
        position: in_cube(i),
        normal: Vec3::new((i % 9) as f32 - 4.0, (i % 4) as f32 - 1.5, 2.0).normalize(),
        ..Dot::default()
    };
    (1..2000).map(dot).collect()
}

fn georeferenced(stage: &mut CaseRenderer) -> CaseResult {
    // Differences of depths on the grid are no d̃ of this kind, so that no roundings decide.
    let shadows = hard(77, 0.097_31);
    let dots = on_a_grid();
    let (mut error, mut naive) = (0.0, 0.0);
    for light in [Light::Direction(DVec3::new(0.5, -1.0, -0.4)), Light::Position(DVec3::new(1.0, 6.0, 2.0))] {
        let moved = match light {
            Light::Position(position) => Light::Position(position + BY),
            light => light,
        };
        let (far, _) = shifted(&dots, pixels([8, 8]), BY);
        let here = shares(stage, &cloud(&dots), &lit_frame(light, shadows, 0))?;
        let there = shares(stage, &cloud(&far), &lit_frame(moved, shadows, 0))?;
        error += wrong(&there, |i| here[i]);
        let lost = shares(stage, &cloud(&rounded(&far)), &lit_frame(moved, shadows, 0))?;
        naive += wrong(&lost, |i| here[i]);
        // A scene without shadow, or without light, would say nothing.
        error += if here.contains(&0.0) && here.contains(&1.0) { 0.0 } else { f64::INFINITY };
    }
    Ok(Finding::new(error, 0.0, naive))
}

fn along(stage: &mut CaseRenderer) -> CaseResult {
    // Each row is a pixel of the light, with the first point's depth. |n·f| is 0 and counts as 0.1: 5.2 units are lit.
    let points = cloud(&sheet(0..48, 0..40, 400.0, 0.0, Vec3::Z));
    let light = Light::Direction(DVec3::X);
    let found = shares(stage, &points, &lit_frame(light, hard(64, 0.52), 0))?;
    let is_lit = |i: usize| points.positions[i].x < 0.5 + 5.2;
    let error = wrong(&found, |i| if is_lit(i) { 1.0 } else { 0.0 });
    // d̃ / 0 is any distance.
    let reach = 0.52 / Vec3::Z.dot(Vec3::X);
    let is_naively_lit = |i: usize| (points.positions[i].x as f32) < 0.5 + reach;
    let naive = (0..points.len()).filter(|i| is_naively_lit(*i) != is_lit(*i)).count();
    Ok(Finding::new(error, 0.0, naive as f64))
}

fn one_pixel(stage: &mut CaseRenderer) -> CaseResult {
    let lid = Dot { position: at(5, 5, LID), ..Dot::default() };
    let floor = sheet(0..16, 0..16, FLOOR, 0.0, Vec3::ZERO);
    let points = cloud(&[vec![lid], floor.clone()].concat());
    let found = shares(stage, &points, &lit_frame(DOWN, hard(1, 5.0), 0))?;
    let mut error = wrong(&found, |i| if points.positions[i].z == -LID { 1.0 } else { 0.0 });
    error += wrong(&shares(stage, &cloud(&floor), &lit_frame(DOWN, hard(1, 5.0), 0))?, |_| 1.0);
    let why =
        "a free pixel on each side leaves an image of one pixel with a negative size, so that it is mirrored or empty";
    Ok(Finding::stated(error, 0.0, why))
}

fn all_equal(stage: &mut CaseRenderer) -> CaseResult {
    let place = at(3, 4, 5.0);
    let (mut error, mut naive) = (0.0, 0);
    for count in [1, 500] {
        let points = cloud(&vec![Dot { position: place, ..Dot::default() }; count]);
        for light in [DOWN, Light::Position(place + DVec3::Z), Light::Position(DVec3::ZERO), Light::Position(place)] {
            // d̃ of 1% of a diagonal of 0.
            let shadows = Shadows { min_layer_distance: None, ..hard(64, 1.0) };
            error += wrong(&shares(stage, &points, &lit_frame(light, shadows, 0))?, |_| 1.0);
            // Places in a box without an extent are 0 / 0: in no pixel of the light's image.
            let in_box =
                points.bounds().map(|bounds| (place - bounds.min).as_vec3() / (bounds.max - bounds.min).as_vec3());
            naive += if in_box.is_some_and(|x| (0.0..=1.0).contains(&x.x)) { 0 } else { count };
        }
    }
    Ok(Finding::new(error, 0.0, naive as f64))
}

/// Ranges that roundings may give to the share of light of each point, in images with `reach` pixels around the faces
/// of a cube.
fn share_bounds(points: &Points, light: Light, shadows: Shadows, reach: impl Fn(&Casting) -> u32) -> Vec<Range> {
    let zero = Bounds { min: DVec3::ZERO, max: DVec3::ZERO };
    let bounds = points.bounds().unwrap_or(zero);
    let Some(casting) = shadows.casting(light, 0, (&bounds, points.len() as u64)) else { return Vec::new() };
    let Casting { resolution, fill, occlusion, min_layer_distance, .. } = casting;
    let views = lights::views(light, &bounds, resolution, reach(&casting));
    let cameras = vec![views.iter().map(|view| view.camera).collect()];
    share_ranges(&cameras, Map { resolution, fill, occlusion, distance: min_layer_distance.into() }, points)
}

/// Casts shadows by settings, and counts the points among `dark` that are lit, of a thousand; the bound is what
/// roundings may make of the float64 reference's.
fn leak(
    (stage, points): (&mut CaseRenderer, &Points),
    (light, shadows): (Light, Shadows),
    dark: impl Fn(&DVec3) -> bool,
    naive: &[Range],
) -> CaseResult {
    let places: Vec<usize> = (0..points.len()).filter(|i| dark(&points.positions[*i])).collect();
    let of = |m: &dyn Fn(usize) -> f64| 1000.0 * places.iter().map(|i| m(*i)).sum::<f64>() / places.len() as f64;
    let found = shares(stage, points, &lit_frame(light, shadows, 0))?;
    let allowed = share_bounds(points, light, shadows, Casting::reach);
    // A point beyond its bounds is one too many, whichever way.
    let off = (0..points.len()).filter(|i| !allowed[*i].covers(f64::from(found[*i]), 0.0)).count();
    let error = if off > 0 { f64::INFINITY } else { of(&|i| f64::from(found[i])) };
    Ok(Finding::new(error, of(&|i| allowed[i].high), of(&|i| naive[i].low)))
}

/// A number in [0, 1), as if at random, and the same everywhere.
fn scattered(i: u32, k: u32) -> f64 {
    let word = pellucid_core::random::threefry2x32([i, k], [0x5eed, 0])[0];
    f64::from(word) / 4_294_967_296.0
}

fn sparse(stage: &mut CaseRenderer) -> CaseResult {
    let on = |i: u32, k: u32, from: f64, to: f64, depth: f64| {
        let place = |k| from + (to - from) * scattered(i, k);
        Dot { position: DVec3::new(place(k), -place(k + 1), -depth), ..Dot::default() }
    };
    let lid = (0..5000).map(|i| on(i, 0, 12.0, 36.0, LID));
    let floor = (0..15_000).map(|i| on(i, 2, 0.0, 48.0, FLOOR));
    let points = cloud(&lid.chain(floor).collect::<Vec<_>>());
    let shadows = Shadows { min_layer_distance: Some(5.0), ..Shadows::default() };
    let below = |p: &DVec3| p.z == -FLOOR && [p.x, -p.y].into_iter().all(|at| (13.0..35.0).contains(&at));
    // A map of any cloud, and one filter.
    let naive = share_bounds(&points, DOWN, hard(512, 5.0), Casting::reach);
    leak((stage, &points), (DOWN, shadows), below, &naive)
}

fn seams(stage: &mut CaseRenderer) -> CaseResult {
    let ball = |radius: f64, count: u32, k: u32| {
        (0..count).map(move |i| {
            let (z, turn) = (2.0 * scattered(i, k) - 1.0, 2.0 * PI * scattered(i, k + 1));
            let ring = (1.0 - z * z).sqrt();
            Dot { position: radius * DVec3::new(ring * turn.cos(), ring * turn.sin(), z), ..Dot::default() }
        })
    };
    let points = cloud(&ball(10.0, 3000, 4).chain(ball(20.0, 6000, 6)).collect::<Vec<_>>());
    let lamp = Light::Position(DVec3::new(0.3, -0.2, 0.1));
    let [fill, occlusion] = [Iterations::Count(6); 2];
    let shadows = Shadows { fill, occlusion, ..hard(64, 3.0) };
    // Images that end a pixel beyond their faces: filters find nothing there.
    let naive = share_bounds(&points, lamp, shadows, |_| 0);
    leak((stage, &points), (lamp, shadows), |p| p.length() > 15.0, &naive)
}
