//! Uchida et al. 2020, Figs. 8 and 9: pictures of a noisy scan with ever more ensembles; and Figs. 11 to 15: opaque
//! points beside a hundred ensembles.

use std::path::Path;

use pellucid_core::image::Image;
use pellucid_engine::Result;
use pellucid_io::output;
use pellucid_scene::{Brightness, ColorSpace, Method, SpbrSimplified};

use super::chart;
use super::scans;
use super::stage::{Stage, nmse};

/// Side of the paper's images.
const SIDE: f64 = 1024.0;
/// Points of a scene at the full size.
const POINTS: f64 = 8e6;
/// Standard deviation of the noise over the diagonal of the box: "approximately 1% of the bounding box length".
const DEVIATION: f64 = 0.01;

/// L of the pictures.
const ENSEMBLES: [u32; 4] = [1, 10, 50, 100];
/// L of the pairs.
const PAIR: [u32; 2] = [1, 100];

/// Writes `series-noise.png` and `series-outliers.png`, four pictures each, and `series.csv`.
pub fn measure(stage: &mut Stage, scale: f64, folder: &Path) -> Result<()> {
    let side = (SIDE * scale).round() as u32;
    let scan = scans::merged(scans::built_in("garden", POINTS * scale * scale, stage.seed)?);
    let camera = scans::aslant(&scan);
    let (mut shifted, mut scattered) = (scan.clone(), scan.clone());
    scans::shift(&mut shifted, DEVIATION, stage.seed);
    scans::scatter(&mut scattered, stage.seed);
    let mut clean = stage.upload(scan)?;
    let mut table = Vec::new();
    for (kind, (name, points)) in [("series-noise", shifted), ("series-outliers", scattered)].into_iter().enumerate() {
        let mut noisy = stage.upload(points)?;
        let mut pictures = Vec::new();
        for ensembles in ENSEMBLES {
            let (picture, p) =
                stage.brightened(&mut noisy, camera, [side; 2], simplified(ensembles, Brightness::Auto))?;
            let plain = simplified(ensembles, Brightness::Factor(1.0));
            let standard = stage.image(&mut clean, camera, [side; 2], plain)?;
            let found = nmse(&standard, &stage.image(&mut noisy, camera, [side; 2], plain)?);
            println!("{name}, L {ensembles}: NMSE {found:.4}, p {p:.2}");
            table.push(vec![kind as f64, f64::from(ensembles), found, f64::from(p)]);
            pictures.push(picture);
        }
        write_sheet(folder, name, &pictures, 2)?;
    }
    super::write(folder, "series.csv", &chart::csv("0 noise or 1 outliers,ensembles,NMSE,p", &table))
}

/// Writes `pair-garden.png` and `pair-terrain.png`: opaque points beside a hundred ensembles.
pub fn measure_pairs(stage: &mut Stage, scale: f64, folder: &Path) -> Result<()> {
    let side = (SIDE * scale).round() as u32;
    for name in ["garden", "terrain"] {
        let scan = scans::merged(scans::built_in(name, POINTS * scale * scale, stage.seed)?);
        let camera = scans::aslant(&scan);
        let mut cloud = stage.upload(scan)?;
        let mut pictures = Vec::new();
        for ensembles in PAIR {
            let method = simplified(ensembles, Brightness::Auto);
            let (picture, p) = stage.brightened(&mut cloud, camera, [side; 2], method)?;
            println!("{name}, L {ensembles}: p {p:.2}");
            pictures.push(picture);
        }
        write_sheet(folder, &format!("pair-{name}"), &pictures, 2)?;
    }
    Ok(())
}

fn simplified(ensembles: u32, brightness: Brightness) -> Method {
    Method::SpbrSimplified(SpbrSimplified { ensembles, brightness })
}

/// Writes pictures of one size, row after row, so many in each row, over black.
fn write_sheet(folder: &Path, name: &str, pictures: &[Image], columns: usize) -> Result<()> {
    let Some(Image { width, height, .. }) = pictures.first() else { return Ok(()) };
    let [width, height] = [*width, *height].map(|side| side as usize);
    let black = glam::Vec3::ZERO;
    let linear: Vec<_> =
        pictures.iter().map(|picture| output::linear(picture, black, ColorSpace::Encoded).pixels).collect();
    let mut pixels = Vec::with_capacity(width * height * pictures.len());
    for row in linear.chunks(columns) {
        for y in 0..height {
            row.iter().for_each(|picture| pixels.extend_from_slice(&picture[y * width..(y + 1) * width]));
        }
    }
    let size = [(columns * width) as u32, (height * pictures.len().div_ceil(columns)) as u32];
    Ok(output::write_rgb_png(&folder.join(format!("{name}.png")), size, &pixels)?)
}

/// The image of opaque points, for tests: SPBR with L = 1.
#[cfg(test)]
pub fn opaque(stage: &mut Stage, points: pellucid_core::points::Points, side: u32) -> Result<[Image; 2]> {
    let camera = scans::aslant(&points);
    let mut cloud = stage.upload(points)?;
    let mut image = |method| stage.image(&mut cloud, camera, [side; 2], method);
    Ok([image(simplified(1, Brightness::Factor(1.0)))?, image(Method::Points)?])
}
