//! Cameras at their limits: angles, ranges of depth, points behind the eye.

use super::naive::is_between;
use super::prelude::*;
use pellucid_reference::{abuffer, coverage};
use pellucid_scene::{DiscShape, Family};

pub(super) fn cases() -> Vec<Case> {
    let discs = Discs::default();
    let oriented = [Method::ABuffer(Discs { shape: DiscShape::Oriented, ..discs })];
    // The others go the way of one of these: averages that of `stochastic`, squares and cones that of circles and
    // paraboloids.
    let like = |method: &Method| {
        let averages = Family::Discs == method.family() && !method.is_exact(false) && !method.is_sampled();
        averages || matches!(method, Method::Squares(_) | Method::Cone(_))
    };
    let families = [Family::Discs, Family::Opaque, Family::Soft, Family::OneLayer, Family::Surfaces];
    let all = with_samples(8, except(like, of_families(&families)));
    let limits = [with_peel(), except(like, of_families(&[Family::Opaque]))].concat();
    joined([
        each(&exact(), "one-degree", narrow)
            .about("one degree over 4096 rows, points 1e-4 of a pixel from a border: rows that differ"),
        each(&exact(), "170-degrees", wide).about("170 degrees wide: discs grow with 1 / z, against float64"),
        each(&oriented, "170-degrees-oriented", wide)
            .about("tilted discs 170 degrees wide, each ray by itself, against float64"),
        each(&oriented, "through-the-eye", through_the_eye)
            .about("tilted discs that reach behind the camera, against float64"),
        each(&exact(), "depth-range", depth_range)
            .about("depths from 1 to 1e6, in float32 steps apart: in their order"),
        each(&limits, "depth-limits", depth_limits)
            .about("at near and at far, and a unit in the last place beyond: the first two"),
        each(&all, "behind", behind)
            .about("points behind the camera, at its eye, in front of near and behind far: nothing"),
    ])
}

/// Discs around a position, spread by a few multiplications, in a box of these half sides.
fn some(count: u32, middle: DVec3, half: DVec3, radius: f32) -> Vec<Dot> {
    let part = |i: u32, factor: u32| f64::from((i.wrapping_mul(factor) >> 5) % 4096) / 2048.0 - 1.0;
    let dot = |i: u32| {
        let at = DVec3::new(part(i, 2_654_435_761), part(i, 2_246_822_519), part(i, 3_266_489_917));
        Dot {
            position: middle + half * at,
            color: mixed(i),
            opacity: 0.1 + 0.1 * (i % 8) as f32,
            radius: radius * (1 + i % 4) as f32,
            normal: Vec3::new((i % 9) as f32 - 4.0, (i % 4) as f32 - 1.5, 2.0).normalize(),
            ..Dot::default()
        }
    };
    (1..=count).map(dot).collect()
}

/// Discs whose every pixel is clear in float32 against float64; `naive` renders other ones.
fn against_float64(
    stage: &mut CaseRenderer,
    dots: &[Dot],
    camera: Camera,
    method: Method,
    naive: impl Fn(&Dot) -> Dot,
) -> CaseResult {
    let size = [48, 36];
    let discs = method.discs().copied().unwrap_or_default();
    let margin =
        |dot: &Dot| coverage::margin_px(View::new(&camera, size), &abuffer::splat(&cloud(&[*dot]), 0, discs.shape));
    let clear = |dot: &&Dot| margin(dot) > 0.02;
    let dots: Vec<Dot> = dots.iter().filter(clear).copied().collect();
    let render = |dots: &[Dot]| {
        let points = cloud(dots);
        abuffer::render(View::new(&camera, size), &points, &colors_of(&points), &discs)
    };
    let wanted = render(&dots);
    let longest = wanted.counts.iter().copied().max().unwrap_or_default() as usize;
    let image = stage.image(&dots, camera, size, method)?;
    let other: Vec<[f32; 4]> =
        render(&dots.iter().map(naive).collect::<Vec<_>>()).rgba.iter().map(|p| p.map(|c| c as f32)).collect();
    let error = if longest > 1 { pixels_apart(&image.rgba, &wanted.rgba) } else { f64::INFINITY };
    let bound = roundings(&method, longest) * HALF_ULP;
    Ok(Finding::new(error, bound, pixels_apart(&other, &wanted.rgba)))
}

fn narrow(stage: &mut CaseRenderer, method: Method) -> CaseResult {
    let size = [1, 4096];
    let camera = perspective(DVec3::ZERO, DVec3::NEG_Z, 1.0, 1.0, 1000.0);
    let focal = camera.focal_px(size[1]);
    // One point for each eighth row, 1e-4 of a pixel from its border.
    let dot = |i: u32| {
        let depth = 50.0 + f64::from(i * 37 % 512) / 11.0;
        let row = f64::from(8 * i + 4) + if i.is_multiple_of(2) { 1e-4 } else { -1e-4 };
        Dot { position: DVec3::new(0.0, (2048.0 - row) * depth / focal, -depth), ..Dot::default() }
    };
    let dots: Vec<Dot> = (0..512).map(dot).collect();
    let image = stage.image(&dots, camera, size, method)?;
    let row = |dot: &Dot| camera.project(dot.position, size).0.y.floor() as usize;
    let rows: Vec<usize> = dots.iter().map(row).collect();
    let wanted = |y: usize| if rows.binary_search(&y).is_ok() { 1.0 } else { 0.0 };
    let error = (0..4096).filter(|y| image.rgba[*y][3] != wanted(*y)).count();
    let single = |dot: &Dot| {
        let (y, z) = (dot.position.y as f32, -dot.position.z as f32);
        (2048.0 - y * (focal as f32 / z)).floor() as usize
    };
    let naive = dots.iter().filter(|dot| single(dot) != row(dot)).count();
    Ok(Finding::counted(error, naive))
}

fn wide(stage: &mut CaseRenderer, method: Method) -> CaseResult {
    let camera = perspective(DVec3::new(0.1, 0.2, 0.3), DVec3::new(0.1, 0.2, -1.0), 170.0, 1e-3, 1e3);
    let dots = some(200, DVec3::new(0.0, 0.0, -1.0), DVec3::new(12.0, 9.0, 1.0), 0.1);
    // A radius by the distance of the point, and not by its depth, which is a tenth of it here.
    let by_distance = |dot: &Dot| {
        let view = camera.to_view(dot.position);
        Dot { radius: dot.radius * (view.z / view.length()) as f32, ..*dot }
    };
    against_float64(stage, &dots, camera, method, by_distance)
}

fn through_the_eye(stage: &mut CaseRenderer, method: Method) -> CaseResult {
    let camera = perspective(DVec3::ZERO, DVec3::NEG_Z, 80.0, 0.25, 100.0);
    let tilted = |dot: &Dot| Dot {
        radius: 40.0 * dot.radius,
        opacity: 0.02,
        normal: Vec3::new(dot.normal.y, 0.9, 0.3 * dot.normal.x).normalize(),
        ..*dot
    };
    let dots: Vec<Dot> = some(60, DVec3::NEG_Z * 2.0, DVec3::new(1.0, 1.0, 1.0), 0.1).iter().map(tilted).collect();
    // The outline from the corners of a box, some with a negative depth: as if the discs ended before the eye.
    let cut = |dot: &Dot| Dot { radius: dot.radius.min(-dot.position.z as f32), ..*dot };
    against_float64(stage, &dots, camera, method, cut)
}

fn depth_range(stage: &mut CaseRenderer, method: Method) -> CaseResult {
    let camera = Camera { near: 1.0, far: 1e6, ..pixels([1, 1]) };
    // Eight depths a unit of float32 apart, at both ends and between.
    let depth = |i: u32| {
        let base: f32 = [1.0, 32.0, 1000.0, 60_000.0, 999_000.0][(i / 8) as usize];
        f64::from(f32::from_bits(base.to_bits() + i % 8))
    };
    let dots: Vec<Dot> = (0..40).map(|i| dot(depth(i), graded(i, 40), 0.1)).collect();
    let wanted = composed(&dots);
    let mut shuffled = dots;
    shuffled.reverse();
    let found = stage.image(&shuffled, camera, [1, 1], method)?.rgba[0];
    // The depth of a buffer of 24 bits, far (z - near) / (z (far - near)), orders the nearest alone.
    let key = |dot: &Dot| {
        let z = -dot.position.z;
        (1e6 * (z - 1.0) / (z * (1e6 - 1.0)) * f64::from((1u32 << 24) - 1)).round()
    };
    let mut by_key = shuffled.clone();
    by_key.sort_by(|a, b| key(a).total_cmp(&key(b)));
    Ok(Finding::apart(&found, &over(&by_key), &wanted, roundings(&method, 40) * HALF_ULP))
}

fn depth_limits(stage: &mut CaseRenderer, method: Method) -> CaseResult {
    let camera = Camera { near: 8.0, far: 1000.0, ..pixels([4, 1]) };
    let depths = [8f32.next_down(), 8.0, 1000.0, 1000f32.next_up()];
    let dot = |(x, depth): (u32, &f32)| Dot { position: at(x, 0, f64::from(*depth)), ..Dot::default() };
    let dots: Vec<Dot> = (0..).zip(&depths).map(dot).collect();
    let image = stage.image(&dots, camera, [4, 1], method)?;
    let wanted = [[0.0; 4], [1.0; 4], [1.0; 4], [0.0; 4]];
    // Clipped where (z - near) / (far - near) is not above 0 and below 1.
    let naive = depths.map(|z| if is_between(z, 8.0, 1000.0) { [1.0; 4] } else { [0.0; 4] });
    Ok(Finding::pixels(&image.rgba, &naive, &wanted, 0.0))
}

fn behind(stage: &mut CaseRenderer, method: Method) -> CaseResult {
    let camera = perspective(DVec3::ZERO, DVec3::NEG_Z, 60.0, 0.5, 100.0);
    let at = |x: f64, z: f64| Dot {
        position: DVec3::new(x, 0.01, z),
        radius: 0.2,
        field: if x > 0.0 { 1.0 } else { 0.0 },
        normal: Vec3::Z,
        ..Dot::default()
    };
    let mut dots: Vec<Dot> = [1e-300, 1e-3, 0.4, 1.0, 5.0, 1e3, 1e30].map(|z| at(0.02, z)).to_vec();
    dots.extend([1e-30, 1e-3, 0.4].map(|z| at(-0.01, -z)));
    dots.extend([101.0, 1e9, 1e30].map(|z| at(0.01, -z)));
    dots.push(Dot { position: DVec3::ZERO, radius: 100.0, ..at(0.0, 0.0) });
    let image = stage.image(&dots, camera, [9, 9], method)?;
    let drawn = image.rgba.iter().flatten().map(|c| if *c == 0.0 { 0.0 } else { 1.0 }).fold(0.0, f64::max);
    let deep = if image.depth.iter().all(|z| *z == f32::INFINITY) { 0.0 } else { 1.0 };
    // Divided by a negative depth they appear in the image, upside down.
    let focal = camera.focal_px(9) as f32;
    let is_inside = |dot: &Dot| {
        let p = dot.position.as_vec3();
        [p.x, -p.y].iter().all(|x| (0.0..9.0).contains(&(4.5 + x * focal / -p.z)))
    };
    let naive = if dots.iter().any(is_inside) { 1.0 } else { 0.0 };
    Ok(Finding::new(f64::max(drawn, deep), 0.0, naive))
}
