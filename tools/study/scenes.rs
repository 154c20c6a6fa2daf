//! The scenes, and how their lists get a wanted mean length.

use std::path::Path;
use std::sync::Arc;

use glam::Vec3;
use pellucid_engine::gpu::Device;
use pellucid_engine::methods::{Frame, Renderer};
use pellucid_engine::points::Points;
use pellucid_engine::prepare::Arranged;
use pellucid_engine::progress::Progress;
use pellucid_engine::scene::{self, Overrides, Scene, procedural};
use pellucid_engine::Result;
use pellucid_lab::choice::Lists;
use pellucid_lab::report::tradeoff::settings;

use crate::rows::{Case, rounded};

/// Where a scene comes from.
enum Source {
    BuiltIn,
    /// A built-in scene whose parameter `layers` is the length of all lists.
    Layers,
    /// In the folder of real data.
    File(&'static str),
}

struct Known {
    name: &'static str,
    source: Source,
}

const SCENES: [Known; 9] = [
    Known { name: "garden", source: Source::BuiltIn },
    Known { name: "tori", source: Source::BuiltIn },
    Known { name: "volume", source: Source::BuiltIn },
    Known { name: "stack", source: Source::Layers },
    Known { name: "autzen", source: Source::File("lidar/autzen_stadium_2010_crop.laz") },
    Known { name: "forest", source: Source::File("lidar/lone_star_geyser_tls.copc.laz") },
    Known { name: "angel", source: Source::File("splats/angel.sog") },
    Known { name: "kneeling", source: Source::File("splats/angel-kneeling.sog") },
    Known { name: "narcissus", source: Source::File("splats/narcissus.sog") },
];

/// What shines through a picture: the opacity of points leaves so much of the background behind a list of the wanted mean.
const SHINING_THROUGH: f64 = 0.1;
/// How far from the wanted mean a list may be, relative to it.
const CLOSE: f64 = 0.05;
/// The same where no radius comes closer; beyond it the case is left out.
const FAR: f64 = 0.3;
/// Radii that are tried.
const TRIES: usize = 8;
/// A factor between two radii is at most this.
const STRIDE: f64 = 6.0;

/// The names of all scenes.
pub fn names() -> Vec<&'static str> {
    SCENES.iter().map(|known| known.name).collect()
}

/// A scene that is loaded.
pub struct Base {
    pub name: &'static str,
    points: Arc<Points>,
    pub frame: Frame,
    pub background: Vec3,
    /// Its `layers` have to be the wanted mean.
    layers: Option<u32>,
}

/// A scene whose lists have a wanted mean.
pub struct Fitted {
    pub arranged: Arranged,
    pub case: Case,
}

impl Base {
    /// True if it serves for lists of this mean; a stack of layers does for its own alone.
    pub fn serves(&self, target: u32) -> bool {
        self.layers.is_none_or(|layers| layers == target)
    }

    /// Loads a scene for lists of a mean; `None` if its file is not in the folder of data, or none is given.
    pub fn load(name: &str, target: u32, size: [u32; 2], data: Option<&Path>) -> Result<Option<Self>> {
        let Some(known) = SCENES.iter().find(|known| known.name == name) else { return Ok(None) };
        let progress = Progress::hidden();
        let mut overrides = Overrides::default();
        overrides.set("study", "image.size", &format!("[{}, {}]", size[0], size[1]))?;
        overrides.set("study", "method.name", "abuffer")?;
        let (scene, clouds) = match known.source {
            Source::File(path) => {
                let Some(path) = data.map(|data| data.join(path)).filter(|path| path.is_file()) else {
                    return Ok(None);
                };
                let scene = Scene::from_clouds(&[path], &overrides)?;
                let clouds = scene::load_clouds(&scene, &progress)?;
                (scene, clouds)
            }
            Source::BuiltIn | Source::Layers => {
                let layers = matches!(known.source, Source::Layers).then(|| ("layers".to_owned(), f64::from(target)));
                let parameters: Vec<_> = layers.into_iter().collect();
                let made = procedural::build(known.name, &parameters, 0).map_err(scene::Error::from)?;
                let scene = Scene::from_toml_with(&made.scene_toml, known.name.as_ref(), &overrides)?;
                let clouds = scene::take_generated(&scene, &made)?;
                (scene, clouds)
            }
        };
        let up = scene::up_axis(&clouds);
        let arranged = scene::arrange(&scene, clouds, 0, &progress)?;
        let (camera, _) = scene::camera(&scene, arranged.points(), up)?;
        let mut frame = Frame { shadows: None, ..Frame::of_scene(&scene, camera, 0) };
        // Not all methods have it.
        frame.shading.edl.edl = false;
        frame.method = settings::formation(&frame.method, arranged.points())?.exact();
        let Arranged::Canonical(points) = arranged else { return Ok(None) };
        let layers = matches!(known.source, Source::Layers).then_some(target);
        Ok(Some(Self { name: known.name, points, frame, background: scene.image.background, layers }))
    }

    /// Radii and opacities with which lists have the wanted mean; `None` if no radius comes near it.
    pub fn fit(&self, device: &Device, target: u32) -> Result<Option<Fitted>> {
        let mut renderer = Renderer::new(device)?;
        let mut tried: Vec<(f64, f64)> = Vec::new();
        let mut nearest: Option<(f64, Fitted)> = None;
        let tries = if self.layers.is_some() { 1 } else { TRIES };
        while tried.len() < tries {
            let factor = next(&tried, f64::from(target));
            let opacity = self.opacity(target);
            let points = Arc::new(scaled(&self.points, factor as f32, opacity.map(|opacity| opacity as f32)));
            let mut cloud = renderer.upload(&points)?;
            let rendered = renderer.render(&mut cloud, &self.frame)?;
            let lists = Lists::of(&rendered);
            renderer.recycle(rendered.image);
            tried.push((factor, lists.mean()));
            let distance = (lists.mean() / f64::from(target) - 1.0).abs();
            if nearest.as_ref().is_none_or(|(least, _)| distance < *least) {
                let case = Case {
                    scene: self.name.to_owned(),
                    target,
                    mean: rounded(lists.mean()),
                    longest: lists.longest,
                    covered: lists.covered,
                    points: points.len() as u64,
                    radius_factor: rounded(factor),
                    opacity: opacity.map(rounded),
                };
                nearest = Some((distance, Fitted { arranged: Arranged::Canonical(points), case }));
            }
            if distance < CLOSE {
                break;
            }
        }
        Ok(nearest.filter(|(distance, _)| *distance < FAR).map(|(_, fitted)| fitted))
    }

    /// The opacity of discs; Gaussians keep theirs.
    fn opacity(&self, target: u32) -> Option<f64> {
        self.points.gaussians.is_none().then(|| 1.0 - SHINING_THROUGH.powf(1.0 / f64::from(target)))
    }
}

/// The points with radii and extents times a factor, and with one opacity if it is given.
fn scaled(points: &Points, factor: f32, opacity: Option<f32>) -> Points {
    let mut points = points.clone();
    points.radii.iter_mut().for_each(|radius| *radius = (*radius * factor).min(f32::MAX));
    if let Some(gaussians) = &mut points.gaussians {
        gaussians.extents.iter_mut().for_each(|extents| *extents *= factor);
    }
    if let Some(opacity) = opacity {
        points.opacities.fill(opacity);
    }
    points
}

/// The factor to try next, by (factor, mean) of those before: lists grow with the square of the radius, or as the last two say.
fn next(tried: &[(f64, f64)], target: f64) -> f64 {
    let Some(&(factor, mean)) = tried.last() else { return 1.0 };
    if mean <= 0.0 {
        return factor * STRIDE;
    }
    let exponent = match tried {
        [.., (before, less), _] if *less > 0.0 && *before != factor && *less != mean => {
            ((mean / less).ln() / (factor / before).ln()).clamp(0.25, 4.0)
        }
        _ => 2.0,
    };
    factor * (target / mean).powf(1.0 / exponent).clamp(1.0 / STRIDE, STRIDE)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn factors_tend_to_the_one_wanted() {
        // Lists that begin at one fragment and grow with the area.
        let mean = |factor: f64| 1.0 + 7.0 * factor * factor;
        for target in [5.0, 50.0, 500.0, 1.5] {
            let mut tried = Vec::new();
            while tried.last().is_none_or(|(_, found): &(f64, f64)| (found / target - 1.0).abs() >= CLOSE) {
                assert!(tried.len() < TRIES, "{target}: {tried:?}");
                let factor = next(&tried, target);
                tried.push((factor, mean(factor)));
            }
        }
        assert_eq!(next(&[(1.0, 0.0)], 5.0), STRIDE);
    }

    #[test]
    fn what_shines_through_is_a_tenth() {
        let points = Points { radii: vec![2.0], opacities: vec![0.5], ..Points::default() };
        let alpha = 1.0 - SHINING_THROUGH.powf(1.0 / 50.0);
        let found = scaled(&points, 1.5, Some(alpha as f32));
        assert_eq!((found.radii[0], found.opacities[0]), (3.0, alpha as f32));
        assert!(((1.0 - alpha).powi(50) - 0.1).abs() < 1e-12);
        assert_eq!(scaled(&points, 1.0, None).opacities, [0.5]);
    }
}
