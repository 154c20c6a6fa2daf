//! Surfaces of points that are filtered in the image (`image-space`), and layers of them (`peel-layers`): holes,
//! borders, and d̃ at its ends.

use super::discs::extremes;
use super::naive::peel;
use super::prelude::*;
use pellucid_engine::methods::Rendered;
use pellucid_scene::{ImageSpace, Iterations, MAX_POINT_LAYERS, PeelLayers};

/// Settings without any filter.
const PLAIN: ImageSpace = ImageSpace {
    fill: Iterations::Count(0),
    occlusion: Iterations::Count(0),
    smooth: 0,
    antialias: false,
    antialias_threshold: 0.25,
    min_layer_distance: Some(0.25),
    cull: false,
};
/// Bytes of a pixel with its depth.
const PIXEL: f64 = 20.0;

pub(super) fn cases() -> Vec<Case> {
    let filters =
        ImageSpace { fill: Iterations::Count(2), occlusion: Iterations::Count(2), smooth: 2, antialias: true, ..PLAIN };
    let both =
        [Method::ImageSpace(filters), Method::PeelLayers(PeelLayers { filters, layers: 3, ..PeelLayers::default() })];
    let alone = vec![
        one("image-space/holes", "square holes, 1 to 6 wide: closed after 1, 1, 2, 3, 5, 6 fills and no sooner", holes),
        one("image-space/auto", "filters that run until nothing changes: bytes of 64 iterations", settled),
        one("image-space/silhouette", "40 fills beside borders along the axes and at 45 degrees: nothing", silhouette),
        one("image-space/tilted-plane", "the filter of occluded pixels on tilted planes: no byte changes", tilted),
        one("image-space/tiny-distance", "d̃ of 1e-30: one surface is left, one a unit behind is replaced", tiny),
        one("image-space/huge-distance", "d̃ of 3e38: nothing is another surface, nothing an edge", huge),
        one("image-space/thresholds", "antialiasing from 0 and from 1 on: a step of depth and the outline", thresholds),
        one("image-space/one-color", "100 times smoothed in the corner of an image: that color", smoothed),
        one("peel-layers/at-the-distance", "d̃ behind a surface: the next layer; a unit before that: none", at_distance),
        one("peel-layers/tiny-distance", "d̃ of 1e-30: surfaces a unit apart are two layers, each once", tiny_layers),
        one("peel-layers/huge-distance", "d̃ of 3e38: one layer", huge_layers),
        one("peel-layers/three-planes", "opacities of 0.3, 0.6 and 0.9, shuffled, against float64", three_planes),
        one("peel-layers/only", "each of three planes alone: its color, opacity and depth", alone),
        one("peel-layers/opacity-0-and-1", "nothing shows of opacity 0, or behind opacity 1", |stage| {
            extremes(stage, Method::PeelLayers(PeelLayers { filters: PLAIN, layers: 9, ..PeelLayers::default() }))
        }),
        one("peel-layers/ends", "0, 1, 8, 9 and 17 surfaces: as many layers as there are", ends),
        one("peel-layers/all-equal", "500 points in one place, d̃ of 1% of nothing: one layer", all_equal),
    ];
    joined([
        alone,
        each(&both, "budget", budget).about("cut by a memory budget: no byte changes"),
        each(&both, "equal-depths", ties)
            .about("points of equal depth and different colors, shuffled: no byte changes"),
    ])
}

fn image(stage: &mut CaseRenderer, dots: &[Dot], size: [u32; 2], filters: ImageSpace) -> Result<Image> {
    Ok(stage.image(dots, pixels(size), size, Method::ImageSpace(filters))?)
}

fn layered(
    stage: &mut CaseRenderer,
    dots: &[Dot],
    size: [u32; 2],
    filters: ImageSpace,
    layers: u32,
) -> Result<Rendered> {
    let method = Method::PeelLayers(PeelLayers { filters, layers, ..PeelLayers::default() });
    Ok(stage.render(&cloud(dots), &Frame::new(pixels(size), size, method))?)
}

/// A point in the middle of each pixel that has a depth.
fn surface(size: [u32; 2], color: impl Fn(u32, u32) -> Vec3, depth: impl Fn(u32, u32) -> Option<f64>) -> Vec<Dot> {
    let all = (0..size[1]).flat_map(|y| (0..size[0]).map(move |x| (x, y)));
    let point = |(x, y)| Some(Dot { position: at(x, y, depth(x, y)?), color: color(x, y), ..Dot::default() });
    all.filter_map(point).collect()
}

/// Colors that tell neighbors apart.
fn mixed(x: u32, y: u32) -> Vec3 {
    Vec3::new((x % 3) as f32 / 2.0, (y % 5) as f32 / 4.0, ((x + 2 * y) % 7) as f32 / 6.0)
}

fn red(_: u32, _: u32) -> Vec3 {
    Vec3::X
}

fn holes(stage: &mut CaseRenderer) -> CaseResult {
    // A side of a hole has five consecutive neighbors of background and stays, a corner has three and goes, and with
    // it, in the next iteration, the ends of the sides: the remainder of a hole after each was derived by hand.
    let known = [(1u32, 1u32), (2, 1), (3, 2), (4, 3), (5, 5), (6, 6)];
    let mut error = 0;
    for (side, iterations) in known {
        let size = [side + 8, side + 6];
        let is_hole = |x: u32, y: u32| (4..4 + side).contains(&x) && (3..3 + side).contains(&y);
        let sheet = surface(size, red, |x, y| (!is_hole(x, y)).then_some(4.0));
        let mut left = |fill| -> Result<usize> {
            let image = image(stage, &sheet, size, ImageSpace { fill: Iterations::Count(fill), ..PLAIN })?;
            let full = |(rgba, z): &(&[f32; 4], &f32)| **rgba == [1.0, 0.0, 0.0, 1.0] && **z == 4.0;
            Ok(image.rgba.len() - image.rgba.iter().zip(&image.depth).filter(full).count())
        };
        error += left(iterations)? + usize::from(left(iterations - 1)? == 0);
    }
    // Whatever has a neighbor takes it: a hole is closed from all sides, half its width at a time.
    let naive = known.iter().filter(|(side, iterations)| side.div_ceil(2) != *iterations).count();
    Ok(Finding::counted(error, naive))
}

fn settled(stage: &mut CaseRenderer) -> CaseResult {
    let (mut error, mut naive) = (0.0, f64::INFINITY);
    // Square holes, of background and of a surface behind, which take from 2 to more than 64 iterations.
    for side in [3, 8, 50] {
        let size = [side + 8, side + 6];
        let is_hole = |x: u32, y: u32| (4..4 + side).contains(&x) && (3..3 + side).contains(&y);
        let torn = surface(size, red, |x, y| (!is_hole(x, y)).then_some(4.0));
        let deep = surface(size, mixed, |x, y| Some(if is_hole(x, y) { 9.0 } else { 4.0 }));
        for dots in [torn, deep] {
            let mut of = |fill, occlusion| image(stage, &dots, size, ImageSpace { fill, occlusion, ..PLAIN });
            let [once, many] = [Iterations::Count(1), Iterations::Count(64)];
            let auto = of(Iterations::Auto, Iterations::Auto)?;
            error += bytes_apart(&auto, &of(many, many)?);
            // An end after the first iteration, as if no more changed.
            naive = naive.min(bytes_apart(&of(once, once)?, &auto));
        }
    }
    Ok(Finding::new(error, 0.0, naive))
}

fn silhouette(stage: &mut CaseRenderer) -> CaseResult {
    let size = [20, 18];
    let shapes: [fn(u32, u32) -> bool; 5] = [
        |x, _| x >= 7,
        |_, y| y < 11,
        |x, y| x + y >= 19,
        |x, y| x + 18 >= y + 20,
        |x, y| (4..9).contains(&x) && (5..16).contains(&y),
    ];
    let (mut error, mut naive) = (0.0, 0);
    for is_there in shapes {
        let dots = surface(size, red, |x, y| is_there(x, y).then_some(4.0));
        let plain = image(stage, &dots, size, PLAIN)?;
        error += bytes_apart(&image(stage, &dots, size, ImageSpace { fill: Iterations::Count(40), ..PLAIN })?, &plain);
        // Whatever has a neighbor takes it.
        let all = (0..size[1]).flat_map(|y| (0..size[0]).map(move |x| (x, y)));
        let has = |x: u32, y: u32| (y.saturating_sub(1)..=y + 1).any(|y| is_there(x.saturating_sub(1), y));
        naive += all.filter(|(x, y)| !is_there(*x, *y) && has(*x, *y)).count();
    }
    Ok(Finding::new(error, 0.0, naive as f64 * PIXEL))
}

fn tilted(stage: &mut CaseRenderer) -> CaseResult {
    let size = [40, 30];
    let (mut error, mut naive) = (0.0, 0);
    // Along an axis five neighbors are as far or farther, for any d̃; between, those of one side are nearer by less
    // than it.
    for (gx, gy, distance) in [(0.0, 0.0, 0.01), (0.5, 0.0, 0.01), (0.0, -0.5, 0.01), (0.125, 0.25, 0.5)] {
        let depth = |x: u32, y: u32| 50.0 + gx * f64::from(x) + gy * f64::from(y);
        let dots = surface(size, mixed, |x, y| Some(depth(x, y)));
        let filters = ImageSpace { min_layer_distance: Some(distance), ..PLAIN };
        let plain = image(stage, &dots, size, filters)?;
        for occlusion in [1, 5] {
            error += bytes_apart(
                &image(stage, &dots, size, ImageSpace { occlusion: Iterations::Count(occlusion), ..filters })?,
                &plain,
            );
        }
        // One neighbor that is nearer by d̃ occludes a pixel.
        let hidden = |x: u32, y: u32| x > 0 && depth(x - 1, y) <= depth(x, y) - f64::from(distance);
        naive += (0..40 * 30).filter(|i| hidden(i % 40, i / 40)).count();
    }
    Ok(Finding::new(error, 0.0, naive as f64 * PIXEL))
}

fn tiny(stage: &mut CaseRenderer) -> CaseResult {
    let size = [16, 12];
    let filters = ImageSpace { min_layer_distance: Some(1e-30), ..PLAIN };
    let sheet = surface(size, mixed, |_, _| Some(4.0));
    let plain = image(stage, &sheet, size, filters)?;
    let left = image(stage, &sheet, size, ImageSpace { occlusion: Iterations::Count(3), ..filters })?;
    // One pixel a unit in the last place behind the others, which are all red.
    let behind = f64::from(4f32.next_up());
    let dots = surface(size, red, |x, y| Some(if (x, y) == (7, 5) { behind } else { 4.0 }));
    let dots: Vec<Dot> = dots.iter().map(|dot| if dot.position.z == -4.0 { *dot } else { blue(dot) }).collect();
    let replaced = image(stage, &dots, size, ImageSpace { occlusion: Iterations::Count(1), ..filters })?;
    let wrong = replaced.rgba.iter().filter(|rgba| **rgba != [1.0, 0.0, 0.0, 1.0]).count();
    let error = bytes_apart(&plain, &left) + wrong as f64;
    // Not behind 4 - 1e-30, which is 4: the whole sheet counts as lying behind it.
    let hidden = |dot: &&Dot| (-dot.position.z as f32) <= -dot.position.z as f32 - 1e-30;
    let naive = sheet.iter().filter(hidden).count();
    Ok(Finding::new(error, 0.0, naive as f64))
}

fn blue(dot: &Dot) -> Dot {
    Dot { color: Vec3::Z, ..*dot }
}

fn huge(stage: &mut CaseRenderer) -> CaseResult {
    let size = [16, 12];
    let filters = ImageSpace { min_layer_distance: Some(3e38), ..PLAIN };
    let dots = surface(size, mixed, |x, y| (x != 3 || y > 4).then_some(if x == 7 { 9e6 } else { 1.0 }));
    let plain = image(stage, &dots, size, filters)?;
    let filtered =
        image(stage, &dots, size, ImageSpace { occlusion: Iterations::Count(3), antialias: true, ..filters })?;
    // With an infinity for background every pixel beside it is an edge, and its share of 4 d̃ = ∞ is NaN.
    let naive = bytes_between(&naive::Filtered::new(&plain).antialiased(3e38, 0.25).rgba, &plain.rgba);
    Ok(Finding::new(bytes_apart(&plain, &filtered), 0.0, naive))
}

fn thresholds(stage: &mut CaseRenderer) -> CaseResult {
    let size = [8, 5];
    let color = |x: u32, _: u32| if x < 3 { Vec3::ZERO } else { Vec3::X };
    let dots = surface(size, color, |x, _| (x < 6).then_some(if x < 3 { 4.0 } else { 6.0 }));
    let (mut error, mut naive) = (0f64, 0f64);
    let plain = naive::Filtered::new(&image(stage, &dots, size, PLAIN)?);
    // With d̃ = 2 the step is a quarter of an edge, and the outline, to far at 1e7, a full edge. Red and alpha of the
    // row in the middle: (1 - t/2) own + (t/2) mean; powers of two, exact.
    for (threshold, step) in [(0.0, [0.03125, 0.96875]), (1.0, [0.0, 1.0])] {
        let filters =
            ImageSpace { antialias: true, antialias_threshold: threshold, min_layer_distance: Some(2.0), ..PLAIN };
        let found = image(stage, &dots, size, filters)?;
        let wanted = [
            [0.0, 0.875],
            [0.0, 1.0],
            [step[0], 1.0],
            [step[1], 1.0],
            [1.0, 1.0],
            [0.875, 0.875],
            [0.125, 0.125],
            [0.0, 0.0],
        ];
        let wanted = wanted.map(|[red, alpha]| [red, 0.0, 0.0, alpha]);
        error = error.max(pixels_apart(&found.rgba[16..24], &wanted));
        // An infinity less an infinity beside the outline.
        naive = naive.max(pixels_apart(&plain.antialiased(2.0, threshold).rgba[16..24], &wanted));
    }
    Ok(Finding::new(error, 0.0, naive))
}

fn smoothed(stage: &mut CaseRenderer) -> CaseResult {
    let size = [6, 5];
    let color = Vec3::new(0.1, 0.2, 0.7);
    let dots = surface(size, |_, _| color, |_, _| Some(4.0));
    let found = image(stage, &dots, size, ImageSpace { smooth: 100, ..PLAIN })?;
    let wanted = vec![color.extend(1.0).as_dvec4().to_array(); 30];
    // An iteration: 8 sums of products with powers of two, a quotient of 2.5 units, and as much again for its divisor.
    let bound = 100.0 * 18.0 * HALF_ULP;
    // A corner has 16 + 2 · 2 + 1 of 28 in the image.
    let plain = naive::Filtered::new(&image(stage, &dots, size, PLAIN)?);
    Ok(Finding::pixels(&found.rgba, &(0..100).fold(plain, |image, _| image.smoothed()).rgba, &wanted, bound))
}

/// Points of one pixel, which all lie on its ray.
fn on_a_ray(stage: &mut CaseRenderer, dots: &[Dot], distance: Option<f32>, layers: u32) -> Result<Rendered> {
    layered(stage, dots, [1, 1], ImageSpace { min_layer_distance: distance, ..PLAIN }, layers)
}

/// The largest error of such a pixel and of the number of its layers.
fn layers_apart(found: &Rendered, wanted: &[f64], layers: u32) -> f64 {
    apart(&found.image.rgba[0], wanted).max((f64::from(found.facts.layers) - f64::from(layers)).abs())
}

fn at_distance(stage: &mut CaseRenderer) -> CaseResult {
    // Powers of two, so that 4 + 0.25 is exact. Those in the first place are one surface, however many they are.
    let before = f64::from(4.25f32.next_down());
    let mut dots = vec![dot(4.0, Vec3::X, 0.5); 5];
    dots.extend([dot(before, Vec3::Y, 1.0), dot(4.25, Vec3::Z, 0.5)]);
    let found = on_a_ray(stage, &dots, Some(0.25), 9)?;
    let wanted = [0.5, 0.0, 0.25, 0.75];
    let error = layers_apart(&found, &wanted, 2);
    // A tolerance of 1e-6 takes what comes just before for the second layer.
    let naive = apart(&peel(&dots, 0.25, 1e-6, 9).0, &wanted);
    Ok(Finding::new(error, 0.0, naive))
}

fn tiny_layers(stage: &mut CaseRenderer) -> CaseResult {
    let dots = [dot(4.0, Vec3::X, 0.5), dot(f64::from(4f32.next_up()), Vec3::Y, 0.5)];
    let found = on_a_ray(stage, &dots, Some(1e-30), 4)?;
    // 4 + 1e-30 is 4: the first surface again, in every layer.
    let naive = apart(&peel(&dots, 1e-30, 0.0, 4).0, &[0.5, 0.25, 0.0, 0.75]);
    Ok(Finding::new(layers_apart(&found, &[0.5, 0.25, 0.0, 0.75], 2), 0.0, naive))
}

fn huge_layers(stage: &mut CaseRenderer) -> CaseResult {
    let dots = [dot(1.0, Vec3::X, 0.5), dot(9e6, Vec3::Y, 1.0)];
    let found = on_a_ray(stage, &dots, Some(3e38), 9)?;
    let wanted = [0.5, 0.0, 0.0, 0.5];
    let error = layers_apart(&found, &wanted, 1);
    // A distance clamped to the depth of the scene finds the points at its far end.
    let naive = apart(&peel(&dots, 3e38f32.min(9e6 - 1.0), 0.0, 9).0, &wanted);
    Ok(Finding::new(error, 0.0, naive))
}

fn three_planes(stage: &mut CaseRenderer) -> CaseResult {
    let dots = [dot(5.0, Vec3::X, 0.3), dot(6.0, Vec3::Y, 0.6), dot(9.0, Vec3::new(0.1, 0.7, 1.0), 0.9)];
    let wanted = composed(&dots);
    let shuffled = [dots[2], dots[0], dots[1]];
    let found = on_a_ray(stage, &shuffled, Some(0.25), 4)?.image.rgba[0];
    // For each layer: color times alpha, 1 - α, their product and a sum.
    let bound = 4.0 * 3.0 * HALF_ULP;
    // In the order of arrival.
    Ok(Finding::apart(&found, &over(&shuffled), &wanted, bound))
}

fn alone(stage: &mut CaseRenderer) -> CaseResult {
    let dots = [dot(5.0, Vec3::X, 0.5), dot(6.0, Vec3::Y, 1.0), dot(9.0, Vec3::new(0.0, 0.25, 1.0), 0.25)];
    let (mut error, mut naive) = (0f64, f64::INFINITY);
    for (only, dot) in (1..).zip(&dots) {
        let method = Method::PeelLayers(PeelLayers { filters: PLAIN, layers: 4, only: Some(only) });
        let found = stage.render(&cloud(&dots), &Frame::new(pixels([1, 1]), [1, 1], method))?.image;
        // Powers of two, so that products are exact.
        let wanted = (dot.opacity * dot.color).extend(dot.opacity).as_dvec4().to_array();
        error = error.max(apart(&found.rgba[0], &wanted)).max(apart(&found.depth, &[-dot.position.z]));
        if only > 1 {
            // All layers up to this one, blended.
            naive = naive.min(apart(&peel(&dots, 0.25, 0.0, only).0, &wanted));
        }
    }
    Ok(Finding::new(error, 0.0, naive))
}

fn ends(stage: &mut CaseRenderer) -> CaseResult {
    let (mut error, mut naive) = (0f64, f64::INFINITY);
    // 8 layers are one submission.
    for count in [0u32, 1, 8, 9, 17] {
        let mut dots: Vec<Dot> = (0..count).map(|i| dot(4.0 + f64::from(i), Vec3::ONE, 0.5)).collect();
        // Behind the camera: a cloud has a point at least.
        dots.push(dot(-4.0, Vec3::ONE, 0.5));
        let found = on_a_ray(stage, &dots, Some(0.25), MAX_POINT_LAYERS)?;
        // Sums of powers of two.
        let wanted = 1.0 - 0.5f64.powi(count as i32);
        error = error.max(layers_apart(&found, &[wanted; 4], count));
        // Without a distance the first surface is the next one, too.
        naive = naive.min((f64::from(peel(&dots, 0.0, 0.0, MAX_POINT_LAYERS).1) - f64::from(count)).abs());
    }
    Ok(Finding::new(error, 0.0, naive))
}

fn all_equal(stage: &mut CaseRenderer) -> CaseResult {
    let dots = vec![dot(4.0, Vec3::X, 0.5); 500];
    let found = on_a_ray(stage, &dots, None, 4)?;
    let wanted = [0.5, 0.0, 0.0, 0.5];
    let error = layers_apart(&found, &wanted, 1);
    // Empty behind it: otherwise the same point would be in every layer.
    Ok(Finding::new(error, 0.0, apart(&peel(&dots, 0.0, 0.0, 4).0, &wanted)))
}

/// Points over an image, more than one to a pixel, on four depths.
fn scattered(size: [u32; 2], count: u32) -> Vec<Dot> {
    let part = |i: u32, factor: u32, of: u32| (i.wrapping_mul(factor) >> 9) % of;
    let dot = |i: u32| Dot {
        position: at(part(i, 2_654_435_761, size[0]), part(i, 2_246_822_519, size[1]), f64::from(4 + i % 4)),
        color: mixed(i, i / 3),
        opacity: 0.5,
        ..Dot::default()
    };
    (1..=count).map(dot).collect()
}

fn budget(stage: &mut CaseRenderer, method: Method) -> CaseResult {
    let size = [160, 120];
    let mut cloud = stage.renderer.upload(&cloud(&scattered(size, 12_000)))?;
    let whole = Frame::new(pixels(size), size, method);
    let free = stage.renderer.render(&mut cloud, &whole)?;
    // Less and less, until it takes several regions; too little for any is refused.
    let mut budget = 8u64 << 20;
    let cut = loop {
        let cut = stage.renderer.render(&mut cloud, &Frame { memory_budget: Some(budget), ..whole })?;
        if cut.facts.windows > free.facts.windows {
            break cut;
        }
        budget = budget / 4 * 3;
    };
    let error = bytes_apart(&free.image, &cut.image);
    let why = "filters that end where a window does are wrong in some columns on each side of its border";
    Ok(Finding::stated(error, 0.0, why))
}

fn ties(stage: &mut CaseRenderer, method: Method) -> CaseResult {
    let size = [24, 16];
    let dots = scattered(size, 3000);
    let mut shuffled = dots.clone();
    shuffled.reverse();
    shuffled.rotate_left(1234);
    let frame = Frame { fragments: true, ..Frame::new(pixels(size), size, method) };
    let first = stage.render(&cloud(&dots), &frame)?.image;
    let second = stage.render(&cloud(&shuffled), &frame)?.image;
    // The first to arrive, of those on the nearest depth.
    let naive = dots[0].color.to_array().into_iter().zip(shuffled[0].color.to_array()).filter(|(a, b)| a != b).count();
    Ok(Finding::new(bytes_apart(&first, &second), 0.0, naive as f64))
}
