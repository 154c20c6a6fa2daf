//! The scenes, and how their lists get a wanted mean length.

use std::path::Path;
use std::sync::Arc;

use glam::Vec3;
use pellucid_core::points::Points;
use pellucid_core::progress::Progress;
use pellucid_engine::Result;
use pellucid_engine::methods::{Frame, Renderer};
use pellucid_gpu::Device;
use pellucid_scene::prepare::Arranged;
use pellucid_scene::{self as scene, Overrides, Scene, procedural};
use pellucid_session::candidates;
use pellucid_session::choice::Lists;
use rand::SeedableRng;
use rand::seq::SliceRandom;
use rand_pcg::Pcg64;

use crate::rows::{Case, rounded};

/// Source of a scene.
enum Source {
    BuiltIn,
    /// A built-in scene whose parameter `layers` is the length of all lists.
    Layers,
    /// A file in the folder of real data.
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

/// Share of the background that shines through a picture: the opacity of points leaves this much behind a list of the
/// wanted mean.
const SHINING_THROUGH: f64 = 0.1;
/// Largest relative distance of a list from the wanted mean.
const CLOSE: f64 = 0.05;
/// Largest relative distance where no radius comes closer; beyond it the case is left out.
const FAR: f64 = 0.3;
/// Pixels that a disc should cover: no disc has less than one, so that many points have no short lists.
const DISC_PIXELS: f64 = 4.0;
/// Radii that are tried.
const TRIES: usize = 6;
/// Thinned clouds that are tried.
const THINNINGS: usize = 3;
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
    /// Places of points in random order: so many of the first ones are a thinned cloud.
    places: Vec<u32>,
    pub frame: Frame,
    pub background: Vec3,
    /// Parameter `layers`, if it has to be the wanted mean.
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
        frame.method = candidates::formation(&frame.method, arranged.points())?.exact();
        let Arranged::Canonical(points) = arranged else { return Ok(None) };
        let layers = matches!(known.source, Source::Layers).then_some(target);
        // Places of points on a device are 32-bit numbers.
        let mut places: Vec<u32> = (0..points.len() as u32).collect();
        places.shuffle(&mut Pcg64::seed_from_u64(0));
        Ok(Some(Self { name: known.name, points, places, frame, background: scene.image.background.color(), layers }))
    }

    /// Radii and opacities with which lists have the wanted mean, of fewer points if all are too many; `None` if no
    /// radius comes near it.
    pub fn fit(&self, device: &Device, target: u32) -> Result<Option<Fitted>> {
        let mut renderer = Renderer::new(device)?;
        if self.layers.is_some() {
            return Ok(Some(self.fitted(&mut renderer, self.points.clone(), 1.0, target)?.0));
        }
        let (_, lists) = self.fitted(&mut renderer, self.points.clone(), 1.0, target)?;
        let mut most = match self.points.gaussians {
            Some(_) => f64::INFINITY,
            None => f64::from(target) * lists.covered as f64 / DISC_PIXELS,
        };
        for _ in 0..THINNINGS {
            let (thinned, start) = self.thinned(most);
            let (distance, fitted) = self.nearest(&mut renderer, &thinned, start, target)?;
            if distance.abs() < FAR {
                return Ok(Some(fitted));
            }
            if distance < 0.0 {
                return Ok(None);
            }
            // However small they are, Gaussians cover some pixels each.
            most = thinned.len() as f64 * f64::from(target) / (2.0 * fitted.case.mean);
        }
        Ok(None)
    }

    /// The radii with which the mean comes nearest to the wanted one, and how far above it the mean is, relative to it.
    fn nearest(&self, renderer: &mut Renderer, points: &Arc<Points>, start: f64, target: u32) -> Result<(f64, Fitted)> {
        let mut try_factor = |factor: f64| -> Result<(f64, Fitted)> {
            let (fitted, lists) = self.fitted(renderer, points.clone(), factor, target)?;
            Ok((lists.mean() / f64::from(target) - 1.0, fitted))
        };
        let mut nearest = try_factor(start)?;
        let mut tried = vec![(start, nearest.1.case.mean)];
        while tried.len() < TRIES && nearest.0.abs() > CLOSE {
            let factor = next(&tried, f64::from(target));
            let found = try_factor(factor)?;
            tried.push((factor, found.1.case.mean));
            if found.0.abs() < nearest.0.abs() {
                nearest = found;
            }
        }
        Ok(nearest)
    }

    /// Thins the cloud to at most about so many points, at least one; also returns the factor on radii that keeps lists
    /// about as long.
    fn thinned(&self, most: f64) -> (Arc<Points>, f64) {
        let all = self.places.len();
        let count = (most as usize).clamp(1, all.max(1));
        if count >= all {
            return (self.points.clone(), 1.0);
        }
        let mut chosen = self.places[..count].to_vec();
        // In the order of the scene's points, which keeps neighbors together.
        chosen.sort_unstable();
        (Arc::new(self.points.subset(&chosen, 1.0)), (all as f64 / count as f64).sqrt())
    }

    /// The points with radii times a factor, and the lists that they have.
    fn fitted(
        &self,
        renderer: &mut Renderer,
        points: Arc<Points>,
        factor: f64,
        target: u32,
    ) -> Result<(Fitted, Lists)> {
        let opacity = self.opacity(target);
        let points = Arc::new(scaled(&points, factor as f32, opacity.map(|opacity| opacity as f32)));
        let mut cloud = renderer.upload(&*points)?;
        let rendered = renderer.render(&mut cloud, &self.frame)?;
        let lists = Lists::of(&rendered);
        renderer.recycle(rendered.image);
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
        Ok((Fitted { arranged: Arranged::Canonical(points), case }, lists))
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

/// The factor to try next, by (factor, mean) of those before: lists grow with the square of the radius, or as the last
/// two say.
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
    fn a_tenth_of_the_background_shines_through() {
        let points = Points { radii: vec![2.0], opacities: vec![0.5], ..Points::default() };
        let alpha = 1.0 - SHINING_THROUGH.powf(1.0 / 50.0);
        let found = scaled(&points, 1.5, Some(alpha as f32));
        assert_eq!((found.radii[0], found.opacities[0]), (3.0, alpha as f32));
        assert!(((1.0 - alpha).powi(50) - 0.1).abs() < 1e-12);
        assert_eq!(scaled(&points, 1.0, None).opacities, [0.5]);
    }
}
