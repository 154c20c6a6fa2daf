//! `[[clip]]`: no method draws what is cut off, and borders are kept.

use super::prelude::*;
use pellucid_core::cloud::Cloud;
use pellucid_scene::{self as scene, Scene, Setting};

pub(super) fn cases() -> Vec<Case> {
    let about = "red points are cut off by a plane, green ones by nothing: the largest red of a pixel";
    let fast = |method: Method| method.with("ensembles", Setting::Integer(8)).unwrap_or(method);
    let methods: Vec<Method> = with_samples(8, Method::all()).into_iter().map(fast).collect();
    let mut cases = each(&methods, "clipped", clipped).about(about);
    let borders = "points on a slanted plane at 500 km and 4500 km: kept on either side, and no point beyond";
    cases.push(one("clip/borders", borders, |_| borders_are_kept()));
    cases
}

/// The scene of a cloud with a clip.
fn scene_of(clip: &str) -> Result<Scene> {
    let text = format!("[[cloud]]\npath = \"cloud.ply\"\nradius = 0.25\n{clip}\n");
    Ok(Scene::from_toml(&text, "check".as_ref())?)
}

/// Points in a cube of side 2, red where x > 0, else green, one in two soft.
fn cloud() -> Cloud {
    let positions: Vec<DVec3> = (1..600).map(in_cube).collect();
    Cloud {
        colors: Some(positions.iter().map(|p| if p.x > 0.0 { Vec3::X } else { Vec3::Y }).collect()),
        normals: Some(vec![Vec3::Z; positions.len()]),
        scalars: vec![("soft".to_owned(), (1..600u16).map(|i| f32::from(i % 2)).collect())],
        positions,
        ..Cloud::default()
    }
}

fn picture(stage: &mut CaseRenderer, clip: &str, method: Method) -> Result<Image> {
    let scene = Scene { method: method.into(), ..scene_of(&format!("field = \"soft\"\n{clip}"))? };
    let arranged = scene::arrange(&scene, vec![cloud()], 1, &Progress::hidden())?;
    let camera = perspective(DVec3::new(0.5, 0.75, 3.5), DVec3::ZERO, 45.0, 0.125, 128.0);
    Ok(stage.arranged(&arranged, &Frame::new(camera, [40, 30], method))?)
}

/// The largest value of a channel; infinite for NaN.
fn most(image: &Image, channel: usize) -> f64 {
    let value = |pixel: &[f32; 4]| if pixel[channel].is_nan() { f64::INFINITY } else { pixel[channel].into() };
    image.rgba.iter().map(value).fold(0.0, f64::max)
}

fn clipped(stage: &mut CaseRenderer, method: Method) -> CaseResult {
    let cut = picture(stage, "[[clip]]\nplane = { point = [0, 0, 0], normal = [-1, 0, 0] }", method)?;
    let whole = picture(stage, "", method)?;
    // Something is drawn of what remains.
    let error = if most(&cut, 1) > 0.0 { most(&cut, 0) } else { f64::INFINITY };
    Ok(Finding::new(error, 0.0, most(&whole, 0)))
}

fn borders_are_kept() -> CaseResult {
    const ORIGIN: [i64; 3] = [500_000, 4_500_000, 100];
    const NORMAL: [i64; 3] = [3, 5, -7];
    // A grid of whole numbers, so that an integer tells the side.
    let cells = || (0..9i64 * 9 * 9).map(|i| [i % 9 - 4, i / 9 % 9 - 4, i / 81 - 4]);
    let side = |cell: [i64; 3]| (0..3).map(|axis| cell[axis] * NORMAL[axis]).sum::<i64>();
    let position = |cell: [i64; 3]| DVec3::from([0, 1, 2].map(|axis| (ORIGIN[axis] + cell[axis]) as f64));
    let mut wrong = 0;
    for (invert, keeps) in [(false, 1), (true, -1)] {
        let clip = format!("[[clip]]\nplane = {{ point = {ORIGIN:?}, normal = {NORMAL:?} }}\ninvert = {invert}");
        let cloud = Cloud { positions: cells().map(position).collect(), ..Cloud::default() };
        let points = scene::assemble(&scene_of(&clip)?, vec![cloud], false, &Progress::hidden())?;
        let is_kept = |cell: &[i64; 3]| points.positions.contains(&position(*cell));
        wrong += cells().filter(|cell| is_kept(cell) != (keeps * side(*cell) >= 0)).count();
    }
    // The plane's equation n · p ≥ d in float32, where d is 24 million and neighbors are 2 apart.
    let normal = Vec3::from(NORMAL.map(|c| c as f32));
    let least = normal.dot(position([0; 3]).as_vec3());
    let naive = cells().filter(|cell| (normal.dot(position(*cell).as_vec3()) >= least) != (side(*cell) >= 0)).count();
    Ok(Finding::counted(wrong, naive))
}
