//! Colors that stand for values, and opacities of classes: constant values, values that are not finite, far
//! coordinates.

use super::prelude::*;
use pellucid_core::cloud::{Cloud, UpAxis};
use pellucid_scene::{self as scene, Scene};

/// The first and the last entry of viridis, in sRGB.
const FIRST: [f64; 3] = [0.267_004, 0.004_874, 0.329_415];
const LAST: [f64; 3] = [0.993_248, 0.906_157, 0.143_936];
/// Colors of viridis between the entries 63 and 64, 127 and 128, 191 and 192 of 0 to 255.
const QUARTERS: [[f64; 3]; 3] =
    [[0.23022275, 0.32129725, 0.545488], [0.1281485, 0.565107, 0.5508925], [0.36285925, 0.786695, 0.386589]];
/// Color of class 2.
const GROUND: [f64; 3] = [0.63, 0.47, 0.3];

/// A decoded color is rounded to float32, and t to some units of float64, of which the decoding makes at most three
/// times as much.
const BOUND: f64 = HALF_ULP + 1e-14;

pub(super) fn cases() -> Vec<Case> {
    let mut cases = vec![
        one("color/constant", "equal values, equal heights, one class: the first color of the map", constant),
        one("color/not-finite", "NaN, infinities, and logarithms of 0 and less: gray, sRGB 0.5", not_finite),
        one("color/far", "heights of 4500000 + i/4096: colors from the first to the last", far),
    ];
    let faint =
        "two classes and a range of a scalar, of different opacities and colors: alpha blending of their points";
    cases.extend(each(&exact(), "classes", classes).about(faint));
    cases
}

fn decoded(srgb: [f64; 3]) -> [f64; 3] {
    srgb.map(|c| if c <= 0.040_45 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) })
}

/// A pixel row of points as a file would have them.
fn row(count: usize) -> Cloud {
    Cloud { positions: (0..count).map(|i| at(i as u32, 0, 8.0)).collect(), up: UpAxis::Z, ..Cloud::default() }
}

/// The picture of a row with these keys of its cloud.
fn picture(stage: &mut CaseRenderer, cloud: Cloud, keys: &str) -> Result<Vec<[f32; 4]>> {
    let text = format!("[method]\nname = \"points\"\n[[cloud]]\npath = \"cloud.las\"\n{keys}\n");
    let scene = Scene::from_toml(&text, "check".as_ref())?;
    let size = [cloud.len() as u32, 1];
    let points = scene::assemble(&scene, vec![cloud], false, &Progress::hidden())?;
    Ok(stage.render(&points, &Frame::new(pixels(size), size, Method::Points))?.image.rgba)
}

fn colors_apart(found: &[[f32; 4]], wanted: &[[f64; 3]]) -> f64 {
    let colors: Vec<f32> = found.iter().flat_map(|[r, g, b, _]| [*r, *g, *b]).collect();
    if colors.len() == 3 * wanted.len() { apart(&colors, wanted.as_flattened()) } else { f64::INFINITY }
}

fn constant(stage: &mut CaseRenderer) -> CaseResult {
    let intensity = Cloud { intensity: Some(vec![7.0; 4]), ..row(4) };
    let one_class = Cloud { classification: Some(vec![2; 4]), ..row(4) };
    let mut error = 0f64;
    for (cloud, keys, color) in [
        (intensity, "color_by = \"intensity\"", FIRST),
        // All points are 8 in front of the camera, at one z.
        (row(4), "color_by = \"height\"", FIRST),
        (one_class.clone(), "color_by = \"classification\"", GROUND),
        // One class tells nothing apart.
        (one_class, "", FIRST),
        (row(4), "", FIRST),
    ] {
        error = error.max(colors_apart(&picture(stage, cloud, keys)?, &[decoded(color); 4]));
    }
    // 0 / 0.
    let t = |value: f32, [low, high]: [f32; 2]| (value - low) / (high - low);
    Ok(Finding::new(error, BOUND, t(7.0, [7.0; 2]).into()))
}

fn not_finite(stage: &mut CaseRenderer) -> CaseResult {
    let values = vec![f32::NAN, 1.0, f32::INFINITY, 100.0, f32::NEG_INFINITY, 0.0, -1.0];
    let cloud = Cloud { scalars: vec![("dose".to_owned(), values.clone())], ..row(7) };
    let keys = "color_by = \"dose\"\ncolormap = \"grey\"\nlog = true\nrange = [1, 100]";
    let found = picture(stage, cloud, keys)?;
    let grey = |srgb| decoded([srgb; 3]);
    let wanted = [grey(0.5), grey(0.0), grey(0.5), grey(1.0), grey(0.5), grey(0.5), grey(0.5)];
    // Clamped without a look: NaN stays NaN, infinities get the first and the last color.
    let naive = |value: &f32| grey(f64::from((value.ln() / 100f32.ln()).clamp(0.0, 1.0)));
    let naive: Vec<f32> = values.iter().flat_map(naive).map(|c| c as f32).collect();
    let naive = apart(&naive, wanted.as_flattened());
    Ok(Finding::new(colors_apart(&found, &wanted), BOUND, naive))
}

fn far(stage: &mut CaseRenderer) -> CaseResult {
    let position = |i: u32| at(i, 0, 8.0) + DVec3::Z * (4_500_000.0 + f64::from(i) / 4096.0);
    let (low, high) = (position(0).z, position(4).z);
    let text = format!("[[cloud]]\npath = \"cloud.las\"\ncolor_by = \"height\"\nrange = [{low:?}, {high:?}]\n");
    let scene = Scene::from_toml(&text, "check".as_ref())?;
    let cloud = Cloud { positions: (0..5).map(position).collect(), ..row(5) };
    let points = scene::assemble(&scene, vec![cloud], false, &Progress::hidden())?;
    let camera = pixels([5, 1]);
    let camera = Camera { eye: camera.eye + DVec3::Z * (high + 8.0), ..camera };
    let found = stage.render(&points, &Frame::new(camera, [5, 1], Method::Points))?.image.rgba;
    // Float32 knows halves there: 0 / 0.
    let t = |z: f64| (z as f32 - low as f32) / (high as f32 - low as f32);
    let [first, second, third] = QUARTERS;
    let error = colors_apart(&found, &[FIRST, first, second, third, LAST].map(decoded));
    Ok(Finding::new(error, BOUND, t(high).into()))
}

fn classes(stage: &mut CaseRenderer, method: Method) -> CaseResult {
    // The points: none of the entries, the first, the second, the last two, the last.
    let text = "
        [[cloud]]
        path = 'cloud.las'
        opacity = 0.5
        radius = 0
        color = [0, 0, 1]
        [[cloud.class]]
        id = 'ground'
        opacity = 0.25
        [[cloud.class]]
        id = 'high-vegetation'
        opacity = 0.03125
        color = [0, 1, 0]
        [[cloud.class]]
        scalar = 'dose'
        range = [3, 4]
        color = [1, 0, 0]";
    let cloud = Cloud {
        positions: (0..5).map(|i| at(0, 0, 8.0 + f64::from(i))).collect(),
        classification: Some(vec![6, 2, 5, 5, 9]),
        scalars: vec![("dose".to_owned(), vec![0.0, 1.0, 2.0, 3.0, 4.0])],
        ..Cloud::default()
    };
    let scene = Scene::from_toml(text, "check".as_ref())?;
    let points = scene::assemble(&scene, vec![cloud], true, &Progress::hidden())?;
    let found = stage.render(&points, &Frame::new(pixels([1, 1]), [1, 1], method))?.image.rgba[0];
    let (blue, green, red) = (Vec3::Z, Vec3::Y, Vec3::X);
    let stack = [(blue, 0.5), (blue, 0.25), (green, 0.03125), (red, 0.03125), (red, 0.5)];
    let dots = |stack: &[(Vec3, f32)]| -> Vec<_> {
        stack.iter().zip(8u8..).map(|((color, opacity), depth)| dot(depth.into(), *color, *opacity)).collect()
    };
    let wanted = composed(&dots(&stack));
    // A class's opacity multiplies the cloud's, and the first entry wins.
    let multiplied = [(blue, 0.5), (blue, 0.125), (green, 0.015_625), (green, 0.015_625), (red, 0.5)];
    let naive = apart(&composed(&dots(&multiplied)).map(|c| c as f32), &wanted);
    // A product and a sum for each of five points, of numbers up to 1.
    Ok(Finding::new(apart(&found, &wanted), 10.0 * HALF_ULP, naive))
}
