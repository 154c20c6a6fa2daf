//! Opaque splats: where they meet, which of them wins, radii at their ends.

use super::prelude::*;
use pellucid_reference::coverage::Shape;
use pellucid_reference::splats;
use pellucid_scene::{BlendedSplats, Interpolated, ScreenSplats};

pub(super) fn cases() -> Vec<Case> {
    let plain = ScreenSplats::default();
    let interpolated = Interpolated::default();
    let flat = [Method::Squares(plain), Method::Circles(plain)];
    let moved = [Method::Paraboloid(interpolated), Method::Cone(interpolated), Method::Sphere(plain)];
    let nearest = [vec![Method::Points], flat.to_vec(), moved.to_vec()].concat();
    let splats = [flat.to_vec(), moved.to_vec()].concat();
    let blended = [Method::Hqs(BlendedSplats::default()), Method::Splats(BlendedSplats::default())];
    let hqs = [blended[0]];
    let all = [nearest.clone(), blended.to_vec()].concat();
    joined([
        each(&moved, "bisector", bisector)
            .about("two equal splats meet on the straight line between them: pixels on the wrong side"),
        each(&hqs, "bisector", blend).about("two equal splats blend by exp(-2 ρ²), evenly on the line between them"),
        each(&all, "equal-depths", ties).about("splats of equal depth and different colors, shuffled: no byte changes"),
        each(&nearest, "nearest", nearest_wins)
            .about("depths of 500000 and 500000.5 between near 1 and far 1e6: the nearer one"),
        each(&splats, "no-radius", no_radius)
            .about("radii of 0, 1e-45 and 1e-3 next to a pixel's center: the pixel, at the point's depth"),
        each(&splats, "huge-radius", huge_radius)
            .about("a radius of 3.4e38 is drawn 25 pixels wide: pixels that differ"),
        each(&splats, "pixel-radius", pixel_radius)
            .about("pixel_radius of 3, from 1 to 4 million units away, radii of 0 to 3.4e38: pixels that differ"),
        each(&blended, "equal-colors", equal_colors).about("the mean of 100 000 splats of one color is that color"),
        each(&hqs, "limit", limit)
            .about("a splat exactly one radius behind the nearest is blended, one a unit behind that is not"),
        each(&hqs, "no-blending", no_blending).about("blend_depth of 0: the nearest alone"),
    ])
}

const SIZE: [u32; 2] = [32, 24];

/// Two splats of a radius of 8 pixels at equal depth, placed so that no pixel's center is near the line between them.
fn pair() -> [Dot; 2] {
    let splat =
        |x: f64, y: f64, color| Dot { position: DVec3::new(x, -y, -20.0), radius: 8.0, color, ..Dot::default() };
    [splat(11.3125, 10.125, Vec3::X), splat(18.4375, 13.6875, Vec3::Z)]
}

fn center(pixel: usize) -> DVec3 {
    at(pixel as u32 % SIZE[0], pixel as u32 / SIZE[0], 20.0)
}

fn bisector(stage: &mut CaseRenderer, method: Method) -> CaseResult {
    let [red, blue] = pair();
    let image = stage.image(&[red, blue], pixels(SIZE), SIZE, method)?;
    let covers = |dot: &Dot, pixel: usize| center(pixel).distance(dot.position) <= 8.0;
    let nearer = |pixel: usize| center(pixel).distance(red.position) < center(pixel).distance(blue.position);
    let all = || 0..image.rgba.len();
    let wanted = |pixel: usize| match (covers(&red, pixel), covers(&blue, pixel)) {
        (false, false) => [0.0; 4],
        (true, false) => [1.0, 0.0, 0.0, 1.0],
        (true, true) if nearer(pixel) => [1.0, 0.0, 0.0, 1.0],
        _ => [0.0, 0.0, 1.0, 1.0],
    };
    let error = all().filter(|pixel| image.rgba[*pixel] != wanted(*pixel)).count();
    // At equal depths all that both cover belongs to one of them.
    let naive = all().filter(|pixel| covers(&red, *pixel) && covers(&blue, *pixel) && nearer(*pixel)).count();
    Ok(Finding::counted(error, naive))
}

fn blend(stage: &mut CaseRenderer, method: Method) -> CaseResult {
    let dots = pair();
    let image = stage.image(&dots, pixels(SIZE), SIZE, method)?;
    let points = cloud(&dots);
    let settings = BlendedSplats::default();
    let wanted =
        splats::render(View::new(&pixels(SIZE), SIZE), &points, &colors_of(&points), Shape::Disc, &settings).rgba;
    let nearest = |pixel: &[f64; 4]| pixel.map(|c| c.round() as f32);
    let naive: Vec<[f32; 4]> = wanted.iter().map(nearest).collect();
    // exp(-2 ρ²): 4 roundings of ρ², 4 ρ times, at most 16 units; the exponential one; twice, and a quotient of 2.5.
    let bound = (2.0 * (16.0 + 1.0) + 4.0) * ULP / 2.0;
    Ok(Finding::pixels(&image.rgba, &naive, &wanted, bound))
}

fn ties(stage: &mut CaseRenderer, method: Method) -> CaseResult {
    let color = |i: u32| Vec3::new((i % 7) as f32 / 7.0, (i % 5) as f32 / 5.0, (i % 3) as f32 / 3.0);
    let dots: Vec<Dot> =
        (0..60).map(|i| Dot { position: at(1, 1, 4.0), color: color(i), radius: 1.25, ..Dot::default() }).collect();
    let mut shuffled = dots.clone();
    shuffled.reverse();
    shuffled.rotate_left(17);
    let first = stage.image(&dots, pixels([3, 3]), [3, 3], method)?;
    let second = stage.image(&shuffled, pixels([3, 3]), [3, 3], method)?;
    // The first to arrive.
    let pairs = dots[0].color.to_array().into_iter().zip(shuffled[0].color.to_array());
    let naive = pairs.filter(|(a, b)| a != b).count();
    Ok(Finding::new(bytes_apart(&first, &second), 0.0, naive as f64))
}

fn nearest_wins(stage: &mut CaseRenderer, method: Method) -> CaseResult {
    let dot = |depth: f64, color| Dot { position: at(0, 0, depth), color, radius: 0.75, ..Dot::default() };
    let camera = Camera { near: 1.0, far: 1e6, ..pixels([1, 1]) };
    let dots = [dot(500_000.5, Vec3::X), dot(500_000.0, Vec3::Y), dot(500_001.0, Vec3::Z)];
    let found = stage.image(&dots, camera, [1, 1], method)?.rgba[0];
    // far (z - near) / (z (far - near)) in 24 bits, as a depth buffer has it: equal, and the first one stays.
    let buffer = |z: f64| (1e6 * (z - 1.0) / (z * (1e6 - 1.0)) * f64::from((1u32 << 24) - 1)).round();
    let naive = if buffer(500_000.5) == buffer(500_000.0) { 1.0 } else { 0.0 };
    Ok(Finding::new(apart(&found, &[0.0, 1.0, 0.0, 1.0]), 0.0, naive))
}

fn no_radius(stage: &mut CaseRenderer, method: Method) -> CaseResult {
    let (mut error, mut naive) = (0f64, 0f64);
    for radius in [0.0, 1e-45, 1e-3] {
        let dot = Dot { position: at(1, 1, 4.0) + DVec3::new(0.25, 0.25, 0.0), radius, ..Dot::default() };
        let image = stage.image(&[dot], pixels([3, 3]), [3, 3], method)?;
        let wanted: Vec<[f64; 4]> = (0..9).map(|i| if i == 4 { [1.0; 4] } else { [0.0; 4] }).collect();
        // ρ counts as 1 there, so that only squares move toward the viewer.
        error = error.max(pixels_apart(&image.rgba, &wanted)).max(apart(&image.depth[4..5], &[4.0]));
        // It contains no pixel's center.
        let covered: Vec<[f32; 4]> = (0..9).map(|i| naive::pixel(&dot, [i % 3, i / 3])).collect();
        naive = naive.max(pixels_apart(&covered, &wanted));
    }
    Ok(Finding::new(error, 0.0, naive))
}

fn huge_radius(stage: &mut CaseRenderer, method: Method) -> CaseResult {
    let size = [64, 64];
    let dot = Dot { position: at(31, 31, 4.0), radius: f32::MAX, ..Dot::default() };
    let image = stage.image(&[dot], pixels(size), size, method)?;
    let inside = |pixel: usize| {
        let [x, y] = [pixel % 64, pixel / 64].map(|c| (c as f64 - 31.0).abs());
        if matches!(method, Method::Squares(_)) { x.max(y) <= 25.0 } else { x.hypot(y) <= 25.0 }
    };
    let wanted = |pixel: usize| if inside(pixel) { [1.0; 4] } else { [0.0; 4] };
    let error = (0..64 * 64).filter(|pixel| image.rgba[*pixel] != wanted(*pixel)).count();
    let naive = (0..64 * 64).filter(|pixel| !inside(*pixel)).count();
    Ok(Finding::counted(error, naive))
}

fn pixel_radius(stage: &mut CaseRenderer, method: Method) -> CaseResult {
    let method = method.with("pixel_radius", 3.0.into())?;
    let size = [24, 24];
    let eye = DVec3::new(12.0, -12.0, 0.0);
    let camera = Camera { projection: Projection::Perspective { fov_y: 0.5 }, eye, ..pixels(size) };
    // The center is a corner of pixels.
    let inside = |pixel: usize| {
        let [x, y] = [pixel % 24, pixel / 24].map(|c| (c as f64 - 11.5).abs());
        if matches!(method, Method::Squares(_)) { x.max(y) <= 3.0 } else { x.hypot(y) <= 3.0 }
    };
    let (mut error, mut naive) = (0, usize::MAX);
    for (depth, radius) in [(1.0, 0.0), (40.0, 1.0), (4e6, f32::MAX)] {
        let dot = Dot { position: eye - depth * DVec3::Z, radius, ..Dot::default() };
        let image = stage.image(&[dot], camera, size, method)?;
        let wanted = |pixel: usize| if inside(pixel) { [1.0; 4] } else { [0.0; 4] };
        error += (0..24 * 24).filter(|pixel| image.rgba[*pixel] != wanted(*pixel)).count();
        // With radii in the world.
        let scale = camera.pixels_per_unit(depth, size[1]) * f64::from(radius);
        let in_the_world = |pixel: usize| {
            let [x, y] = [pixel % 24, pixel / 24].map(|c| (c as f64 - 11.5).abs());
            x.hypot(y) <= scale.min(25.0)
        };
        naive = naive.min((0..24 * 24).filter(|pixel| in_the_world(*pixel) != inside(*pixel)).count());
    }
    Ok(Finding::counted(error, naive))
}

fn equal_colors(stage: &mut CaseRenderer, method: Method) -> CaseResult {
    let color = Vec3::new(0.1, 0.2, 0.7);
    let dot = Dot { position: at(0, 0, 4.0), color, radius: 0.75, ..Dot::default() };
    let found = stage.pixel(&vec![dot; 100_000], method)?;
    let wanted = color.extend(1.0).as_dvec4().to_array();
    let sum = (0..100_000).fold(Vec3::ZERO, |sum, _| sum + color) / 1e5;
    // Compensated sums (2 units) of color and weight, a product each, and their quotient.
    Ok(Finding::new(apart(&found, &wanted), 9.0 * ULP, apart(&sum.to_array(), &wanted[..3])))
}

fn limit(stage: &mut CaseRenderer, method: Method) -> CaseResult {
    let dot = |depth: f64, color| Dot { position: at(0, 0, depth), color, radius: 1.0, ..Dot::default() };
    // All numbers are exact: 4 + 1 ≤ 5.
    let behind = 5.0 + f64::from(f32::EPSILON) * 4.0;
    let dots = [dot(4.0, Vec3::X), dot(5.0, Vec3::Y), dot(behind, Vec3::Z)];
    let wanted = [0.5, 0.5, 0.0, 1.0];
    // With < the second one is lost.
    stage.compare(&dots, method, &naive::blended(&dots, 1.0, 0.0), &wanted, 0.0)
}

fn no_blending(stage: &mut CaseRenderer, method: Method) -> CaseResult {
    let dot = |depth: f64, color| Dot { position: at(0, 0, depth), color, radius: 1.0, ..Dot::default() };
    let method = match method {
        Method::Hqs(settings) => Method::Hqs(BlendedSplats { blend_depth: 0.0, ..settings }),
        method => method,
    };
    let behind = 4.0 + f64::from(f32::EPSILON) * 4.0;
    let dots = [dot(behind, Vec3::X), dot(4.0, Vec3::Y)];
    let (found, wanted) = (stage.pixel(&dots, method)?, [0.0, 1.0, 0.0, 1.0]);
    // A tolerance of 1e-6 of the depth takes both.
    Ok(Finding::apart(&found, &naive::blended(&dots, 0.0, 1e-6), &wanted, 0.0))
}
