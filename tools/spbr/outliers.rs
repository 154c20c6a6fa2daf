//! Uchida et al. 2020, Fig. 10: points far from any surface fade as the number of ensembles grows.

use std::collections::HashMap;
use std::path::Path;

use pellucid_core::camera::Camera;
use pellucid_core::points::Points;
use pellucid_engine::Result;
use pellucid_scene::{Brightness, Method, SpbrSimplified};

use super::chart::{self, Axis, Row};
use super::scans;
use super::stage::Stage;

const SIDE: f64 = 1024.0;
/// Points of the built-in garden at the full size: some per pixel, as of the paper's 25 million.
const POINTS: f64 = 8e6;
const ENSEMBLES: [u32; 13] = [1, 2, 3, 5, 7, 10, 15, 20, 30, 50, 75, 100, 150];

/// Writes `outliers.svg` and `outliers.csv`.
pub fn measure(stage: &mut Stage, scale: f64, folder: &Path) -> Result<()> {
    let side = (SIDE * scale).round() as u32;
    let (points, is_stray) = garden((POINTS * scale * scale).round(), stage.seed)?;
    let camera = scans::aslant(&points);
    let strays = only_strays(&points, &is_stray, &camera, side);
    let hits = |count: &u32| f64::from(*count);
    let mean_count = strays.values().map(hits).sum::<f64>() / strays.len() as f64;
    println!("{} points, {} pixels with only stray points, {mean_count:.2} in each", points.len(), strays.len());
    let mut cloud = stage.upload(points)?;
    let (mut table, mut rows) = (Vec::new(), Vec::new());
    for ensembles in ENSEMBLES {
        let method = SpbrSimplified { ensembles, brightness: Brightness::Factor(1.0) };
        let image = stage.image(&mut cloud, camera, [side, side], Method::SpbrSimplified(method))?;
        let alpha = |pixel: &usize| f64::from(image.rgba.get(*pixel).map_or(0.0, |pixel| pixel[3]));
        let found = strays.keys().map(alpha).sum::<f64>() / strays.len() as f64;
        // So many points in a pixel hit that share of the ensembles.
        let share = |count: &u32| 1.0 - (1.0 - 1.0 / f64::from(ensembles)).powi(*count as i32);
        let expected = strays.values().map(share).sum::<f64>() / strays.len() as f64;
        println!("L {ensembles}: M/L {found:.4}, expected {expected:.4}");
        table.push(vec![f64::from(ensembles), found, expected]);
        rows.push(Row { x: f64::from(ensembles), found, spread: 0.0, expected });
    }
    let panels = [(format!("{} pixels with only stray points", strays.len()), rows)];
    chart::figure(folder, "outliers", Axis::tens("ensembles L", 1.0), Axis::tens("mean M / L", 1e-3), &panels)?;
    super::write(folder, "outliers.csv", &chart::csv("ensembles,M/L,expected M/L", &table))
}

/// The garden with a tenth of its points moved to anywhere in its box, and which they are.
fn garden(count: f64, seed: u64) -> Result<(Points, Vec<bool>)> {
    let mut points = scans::merged(scans::built_in("garden", count, seed)?);
    let is_stray = scans::scatter(&mut points, seed);
    Ok((points, is_stray))
}

/// Pixels, by row and column, that only stray points are projected to, and how many.
fn only_strays(points: &Points, is_stray: &[bool], camera: &Camera, side: u32) -> HashMap<usize, u32> {
    let mut found: HashMap<usize, Option<u32>> = HashMap::new();
    for (position, stray) in points.positions.iter().zip(is_stray) {
        let (at, _) = camera.project(*position, [side; 2]);
        let inside = 0.0..f64::from(side);
        if inside.contains(&at.x) && inside.contains(&at.y) {
            let count = found.entry(at.y as usize * side as usize + at.x as usize).or_insert(Some(0));
            *count = count.filter(|_| *stray).map(|count| count + 1);
        }
    }
    found.into_iter().filter_map(|(pixel, count)| Some((pixel, count?))).collect()
}
