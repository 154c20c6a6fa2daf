//! Built-in scenes in place of the papers' scans, and the noise that is added to them (Uchida et al. 2020, Section 4).

use glam::DVec3;
use pellucid_core::camera::{Camera, Projection};
use pellucid_core::cloud::Bounds;
use pellucid_core::points::Points;
use pellucid_core::progress::Progress;
use pellucid_engine::Result;
use pellucid_scene::prepare::order;
use pellucid_scene::{self as scene, Scene, procedural};
use rand::RngExt;

use super::stage::{gauss, random};

/// The share of points that noise is added to.
pub const MOVED: f64 = 0.1;

/// The clouds of a built-in scene with about so many points in all, each with its path.
pub fn built_in(name: &str, points: f64, seed: u64) -> Result<Vec<(String, Points)>> {
    let generated =
        procedural::build(name, &[("points".to_owned(), points.round())], seed).map_err(scene::Error::from)?;
    let whole = Scene::from_toml(&generated.scene_toml, name.as_ref())?;
    let clouds = scene::take_generated(&whole, &generated)?;
    let one = |(settings, cloud): (&pellucid_scene::CloudSettings, _)| {
        let alone = Scene { clouds: vec![settings.clone()], ..whole.clone() };
        let points = scene::assemble(&alone, vec![cloud], false, &Progress::hidden())?;
        Ok((settings.path.display().to_string(), points))
    };
    whole.clouds.iter().zip(clouds).map(one).collect()
}

/// All clouds as one, as a scan is.
pub fn merged(clouds: Vec<(String, Points)>) -> Points {
    let mut all = Points::default();
    clouds.into_iter().for_each(|(_, points)| all.append(points));
    order::canonical(all)
}

/// A camera far off that sees all points from above and from the side.
pub fn aslant(points: &Points) -> Camera {
    let bounds = points.bounds().unwrap_or(Bounds { min: DVec3::ZERO, max: DVec3::ONE });
    let (center, diagonal) = (bounds.center(), bounds.diagonal());
    let projection = Projection::Orthographic { height: 0.8 * diagonal };
    let eye = center + diagonal * DVec3::new(0.4, -0.7, 0.35);
    Camera::look_at(eye, center, DVec3::Z, projection, 0.1 * diagonal, 2.0 * diagonal)
        .expect("the view is not along the vertical")
}

/// Moves a tenth of the points to anywhere in their box, and returns which they are.
pub fn scatter(points: &mut Points, seed: u64) -> Vec<bool> {
    let mut random = random(seed);
    let Some(bounds) = points.bounds() else { return Vec::new() };
    let is_stray: Vec<_> = (0..points.len()).map(|_| random.random::<f64>() < MOVED).collect();
    for position in points.positions.iter_mut().zip(&is_stray).filter_map(|(p, stray)| stray.then_some(p)) {
        let share = DVec3::from_array([(); 3].map(|()| random.random()));
        *position = bounds.min + share * (bounds.max - bounds.min);
    }
    is_stray
}

/// Shifts a tenth of the points by Gaussian noise whose standard deviation is this share of the box's diagonal.
pub fn shift(points: &mut Points, share: f64, seed: u64) {
    let mut random = random(seed);
    let deviation = share * points.bounds().map_or(0.0, |bounds| bounds.diagonal());
    for position in &mut points.positions {
        if random.random::<f64>() < MOVED {
            *position += deviation * DVec3::from_array([(); 3].map(|()| gauss(&mut random)));
        }
    }
}
