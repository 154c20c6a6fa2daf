//! Clouds on their way to the device: radii of degenerate clouds, places far from the origin, what is not finite.

use std::io::Write;
use std::path::Path;

use super::prelude::*;
use pellucid_core::cloud::Cloud;
use pellucid_io as io;
use pellucid_scene::prepare::{radius, surface};
use pellucid_scene::{self as scene, Scene};

pub(super) fn cases() -> Vec<Case> {
    vec![
        one("prepare/all-equal", "500 points in one place: radius 0, and 1 - 0.99^500 on their pixel", all_equal),
        one("prepare/line", "1000 points in a row: radii by Eq. 20, 2 · 12 h / √24", |_| line()),
        one("prepare/plane", "a grid in a plane: normals along its axis", |_| plane()),
        one("prepare/georeferenced", "the row moved by (500000, 4500000, 100): the same radii", |_| georeferenced()),
        one("prepare/scale", "the row times 1000: radii times 1000 (Eq. 20 as printed: times √1000)", |_| scale()),
        one(
            "read/not-finite",
            "NaN and infinity for position, color, opacity, normal, radius: the bytes of what they stand for",
            not_finite,
        ),
    ]
}

/// A scene of one cloud as its file would be, with what its colors show.
fn scene(color_by: &str) -> Result<Scene> {
    let cloud = format!("[[cloud]]\npath = \"cloud.ply\"\nopacity = 0.01\ncolor_by = \"{color_by}\"\n");
    Ok(Scene::from_toml(&format!("[method]\nname = \"abuffer\"\n{cloud}"), Path::new("check"))?)
}

fn all_equal(stage: &mut CaseRenderer) -> CaseResult {
    let dot = dot(8.0, Vec3::ONE, 0.01);
    let cloud = Cloud { positions: vec![dot.position; 500], ..Cloud::default() };
    let points = scene::assemble(&scene("uniform")?, vec![cloud], true, &Progress::hidden())?;
    let frame = Frame::new(pixels([1, 1]), [1, 1], Method::ABuffer(Discs::default()));
    let found = stage.render(&points, &frame)?.image.rgba[0];
    let wanted = composed(&vec![dot; 500]);
    // Four roundings for each of a run of 256, and for each run.
    let bound = 4.0 * (256.0 + 2.0) * HALF_ULP;
    // Empty, where a radius of 0 covers no pixel.
    let covering: Vec<Dot> = vec![dot; 500].into_iter().filter(|dot| naive::covers(dot, [0, 0])).collect();
    Ok(Finding::apart(&found, &over(&covering), &wanted, bound))
}

/// 1000 points, 1/16 apart.
fn in_a_row() -> Vec<DVec3> {
    (0..1000).map(|i| DVec3::X * f64::from(i) / 16.0).collect()
}

fn radii(positions: &[DVec3]) -> Vec<f32> {
    radius::estimate(positions, 24, radius::DEFAULT_CAP, &Progress::hidden())
}

/// Eq. 20 in float32 for the middle point, with its twelve neighbors on each side.
fn middle_in_float32(positions: &[DVec3]) -> f32 {
    let near = &positions[500 - 12..=500 + 12];
    let own = positions[500].as_vec3();
    2.0 * near.iter().map(|p| p.as_vec3().distance(own)).fold(0.0, f32::max) / 24f32.sqrt()
}

fn line() -> CaseResult {
    let found = radii(&in_a_row());
    let wanted = 2.0 * 12.0 / 16.0 / 24f64.sqrt();
    let error = apart(&found[12..988], &[wanted; 976]);
    // Rounded once. Twelve neighbors on either side, not 24: the ends of the row have twice the radius.
    let ends = apart(&[found[0], found[999]], &[2.0 * wanted; 2]);
    // With the point itself as one of K, its neighbors are 23, the last at the same distance, but K is 25 with them
    // all.
    let naive = apart(&[(2.0 * 12.0 / 16.0 / 25f64.sqrt()) as f32], &[wanted]);
    Ok(Finding::new(error.max(ends), 2.0 * wanted * HALF_ULP, naive))
}

fn plane() -> CaseResult {
    // So far from the origin that a covariance, computed as the mean of products minus the product of means, has no
    // digit left in float64.
    let grid = |i: u32| DVec3::new(f64::from(i % 20) / 16.0, f64::from(i / 20) / 16.0, 0.0);
    let away = DVec3::new(500_000.0, 4_500_000.0, 100.0);
    let positions: Vec<DVec3> = (0..400).map(|i| grid(i) + away).collect();
    let surface = surface::estimate(&positions, None, (24, radius::DEFAULT_CAP), &Progress::hidden());
    let off = |normal: &Vec3| f64::from(normal.x.abs().max(normal.y.abs()).max((normal.z.abs() - 1.0).abs()));
    let most =
        |normals: &[Vec3]| normals.iter().map(off).fold(0.0, |most: f64, d| if d.is_nan() { 1.0 } else { most.max(d) });
    let error = most(&surface.normals);
    // In float32 the rows of the grid coincide: the plane becomes a line, whose normal may be anything across it.
    let rounded: Vec<DVec3> = positions.iter().map(|p| p.as_vec3().as_dvec3()).collect();
    let naive = most(&surface::estimate(&rounded, None, (24, radius::DEFAULT_CAP), &Progress::hidden()).normals);
    Ok(Finding::new(error, 4.0 * HALF_ULP, naive))
}

fn georeferenced() -> CaseResult {
    let here = radii(&in_a_row());
    let away = DVec3::new(500_000.0, 4_500_000.0, 100.0);
    // Along y, where float32 knows halves.
    let turned: Vec<DVec3> = in_a_row().iter().map(|p| DVec3::new(0.0, p.x, 0.0) + away).collect();
    let wanted: Vec<f64> = here.iter().map(|r| f64::from(*r)).collect();
    let naive = apart(&[middle_in_float32(&turned)], &[wanted[500]]);
    // All places and differences are exact.
    Ok(Finding::new(apart(&radii(&turned), &wanted), 0.0, naive))
}

fn scale() -> CaseResult {
    let here = radii(&in_a_row());
    let large: Vec<DVec3> = in_a_row().iter().map(|p| *p * 1000.0).collect();
    let wanted: Vec<f64> = here.iter().map(|r| f64::from(*r) * 1000.0).collect();
    let most = wanted.iter().copied().fold(0.0, f64::max);
    // Both were rounded.
    let printed: Vec<f32> = here.iter().map(|r| r * 1000f32.sqrt()).collect();
    Ok(Finding::apart(&radii(&large), &printed, &wanted, 2.0 * most * HALF_ULP))
}

/// A cloud as a text file; each row is position, color, alpha, normal, radius.
fn ply(rows: &[&str]) -> String {
    let names = ["x", "y", "z", "red", "green", "blue", "alpha", "nx", "ny", "nz", "radius"];
    let properties: String = names.iter().map(|name| format!("property float {name}\n")).collect();
    let header = format!("ply\nformat ascii 1.0\nelement vertex {}\n{properties}end_header\n", rows.len());
    header + &rows.join("\n") + "\n"
}

/// A row as its numbers say.
fn as_read(row: &str) -> Option<Dot> {
    let numbers: Vec<f32> = row.split(' ').map(str::parse).collect::<Result<_, _>>().ok()?;
    let [x, y, z, red, green, blue, opacity, nx, ny, nz, radius] = *numbers else { return None };
    let (position, normal) = (Vec3::new(x, y, z).as_dvec3(), Vec3::new(nx, ny, nz));
    Some(Dot { position, color: Vec3::new(red, green, blue), opacity, radius, normal, field: 0.0 })
}

fn picture(stage: &mut CaseRenderer, rows: &[&str]) -> Result<Image> {
    let failed = |source| io::Error::Write { path: "a temporary file".into(), source };
    let mut file = tempfile::Builder::new().prefix(".pellucid-").suffix(".ply").tempfile().map_err(failed)?;
    file.write_all(ply(rows).as_bytes()).map_err(failed)?;
    let cloud = io::load(file.path(), &Progress::hidden())?;
    let points = scene::assemble(&scene("rgb")?, vec![cloud], true, &Progress::hidden())?;
    Ok(stage.render(&points, &Frame::new(pixels([8, 1]), [8, 1], Method::ABuffer(Discs::default())))?.image)
}

fn not_finite(stage: &mut CaseRenderer) -> CaseResult {
    let odd = [
        "nan -0.5 -8 1 1 1 1 0 0 1 0.5",
        "0.5 inf -8 1 1 1 1 0 0 1 0.5",
        "0.5 -0.5 -inf 1 1 1 1 0 0 1 0.5",
        "1.5 -0.5 -8 nan 1 1 1 0 0 1 0.25",
        "2.5 -0.5 -8 inf -inf 1 1 0 0 1 0.25",
        "3.5 -0.5 -8 1 1 1 nan 0 0 1 0.25",
        "4.5 -0.5 -8 1 1 1 inf 0 0 1 0.25",
        "5.5 -0.5 -8 1 1 1 1 nan inf 1 0.25",
        "6.5 -0.5 -8 1 1 1 1 0 0 1 nan",
        "7.5 -0.5 -8 1 1 1 1 0 0 1 inf",
    ];
    // No position, no point; a color of 0, or of the end that it is beyond; opaque; no normal; no radius.
    let meant = [
        "1.5 -0.5 -8 0 1 1 1 0 0 1 0.25",
        "2.5 -0.5 -8 1 0 1 1 0 0 1 0.25",
        "3.5 -0.5 -8 1 1 1 1 0 0 1 0.25",
        "4.5 -0.5 -8 1 1 1 1 0 0 1 0.25",
        "5.5 -0.5 -8 1 1 1 1 0 0 0 0.25",
        "6.5 -0.5 -8 1 1 1 1 0 0 1 0",
        "7.5 -0.5 -8 1 1 1 1 0 0 1 0",
    ];
    let (found, wanted) = (picture(stage, &odd)?, picture(stage, &meant)?);
    let drawn = wanted.rgba[1..].iter().all(|pixel| pixel[3] > 0.0) && wanted.rgba[0] == [0.0; 4];
    let error = if drawn { bytes_apart(&found, &wanted) } else { f64::INFINITY };
    // Blended without a check, non-finite values spread over their pixel.
    let mut blended = wanted.rgba.clone();
    for dot in odd.iter().filter_map(|row| as_read(row)) {
        if let Some(pixel) = blended.get_mut(dot.position.x.max(0.0) as usize) {
            *pixel = over(&[dot]);
        }
    }
    let naive = bytes_between(&blended, &wanted.rgba);
    Ok(Finding::new(error, 0.0, naive))
}
