//! A small scene for every method, and for the settings that use other paths of the engine. Their images must have the
//! same bytes after any earlier frames, for any order of the input and any budget (docs/determinism.md).
//!
//! One list serves the tests and, with larger images, the comparison of drivers. Positions and colors follow from
//! counters and need only operations that IEEE 754 defines to the last bit, so that they are the same everywhere.

mod clouds;
mod compared;

use glam::DVec3;
use pellucid_core::progress::Progress;

use super::stage;
use pellucid_core::camera::Projection;
use pellucid_core::points::Points;
use pellucid_engine::methods::{Error, Frame, Rendered, Renderer};
use pellucid_engine::plan;
use pellucid_scene::prepare::Arranged;
use pellucid_scene::prepare::{ensembles, order};
use pellucid_scene::{
    BlendedSplats, ColorSpace, Density, DiscShape, Discs, Falloff, Family, GaussianSettings, Hybrid, ImageSpace,
    Interpolated, Iterations, Kernel, Light, LongLists, MapResolution, Method, MethodChoice, Mlab, MomentCount,
    Moments, OneLayer, Order, Peel, PeelLayers, Raster, ScreenSplats, Shading, ShadingModel, Shadows, Shells, Soft,
    SoftLayout, Spbr, SpbrSimplified, SplatShape, Stochastic, Tail, Wavelet,
};

pub use compared::compared;

/// A scene for a method.
#[derive(Debug, Clone)]
pub struct MethodScene {
    /// The method, and behind a comma what is special about it, as in `abuffer, oriented`.
    pub name: String,
    /// The clouds, each as a file might hold it: in no particular order.
    pub clouds: Vec<Points>,
    /// The method as a scene file would request it.
    pub choice: MethodChoice,
    /// The frame, including list lengths and standard errors. For `auto`, the method that is exact for the points,
    /// without considering which one is cheaper on the device.
    pub frame: Frame,
}

/// Order of the input that an image follows, by the definition of its method.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Follows {
    /// Nothing: points and clouds may be in any order.
    Nothing,
    /// The order of the clouds, not that of the points within: the random words that shuffle a cloud's points into
    /// ensembles depend on its place among the others (`spbr`, `spbr-simplified`).
    Clouds,
    /// The order of the points, file after file, which is the order of blending (`unsorted`) or of arrival (`mlab`).
    Points,
}

impl MethodScene {
    /// Returns the order of the input on which the image depends.
    pub fn follows(&self) -> Follows {
        match self.frame.method {
            Method::Unsorted(_) | Method::Mlab(_) => Follows::Points,
            method if method.is_dealt() => Follows::Clouds,
            _ => Follows::Nothing,
        }
    }

    /// Returns the points in the order that the method needs.
    pub fn arranged(&self) -> Arranged {
        if self.frame.method.is_dealt() {
            let hidden = Progress::hidden();
            return Arranged::Dealt(ensembles::deal(self.clouds.clone(), self.frame.seed, &hidden));
        }
        Arranged::Canonical(order::canonical(joined(&self.clouds)).into())
    }

    /// Renders it from the beginning: orders and uploads the points, too.
    ///
    /// # Errors
    /// Errors of [`Renderer::render`].
    pub fn render(&self, renderer: &mut Renderer) -> Result<Rendered, Error> {
        self.render_arranged(renderer, &self.arranged())
    }

    /// Renders the subject from the ordered points that [`Self::arranged`] returned.
    ///
    /// # Errors
    /// Errors of [`Renderer::render`].
    pub fn render_arranged(&self, renderer: &mut Renderer, arranged: &Arranged) -> Result<Rendered, Error> {
        let mut cloud = renderer.upload(arranged)?;
        renderer.render(&mut cloud, &self.frame)
    }

    /// Returns the subject with each cloud's points in another order.
    #[must_use]
    pub fn shuffled(&self, seed: u32) -> Self {
        Self { clouds: self.clouds.iter().map(|cloud| clouds::shuffled(cloud, seed)).collect(), ..self.clone() }
    }

    /// Returns the subject with the clouds in reverse order.
    #[must_use]
    pub fn clouds_reversed(&self) -> Self {
        Self { clouds: self.clouds.iter().rev().cloned().collect(), ..self.clone() }
    }

    /// Returns the subject with another frame.
    #[must_use]
    pub fn with(&self, frame: Frame) -> Self {
        Self { frame, ..self.clone() }
    }
}

/// Returns the subjects: at least one for each method that a scene file can name.
pub fn subjects() -> Vec<MethodScene> {
    let mut all = [discs(), gaussians(), opaque(), soft(), surfaces(), ensembles_of_points()].concat();
    let known = |all: &[MethodScene], method: &Method| all.iter().any(|subject| subject.choice.name() == method.name());
    for method in Method::all() {
        if !known(&all, &method) {
            all.push(subject(method, "", clouds_of(method.family()), as_it_is));
        }
    }
    all
}

/// The clouds for methods without a subject of their own.
fn clouds_of(family: Family) -> Vec<Points> {
    match family {
        Family::Surfaces | Family::Ensembles => clouds::surfaces(),
        Family::Discs => clouds::many(),
        _ => clouds::few(),
    }
}

/// Columns and rows of the images: no multiple of a tile.
const SIZE: [u32; 2] = [56, 40];

fn joined(clouds: &[Points]) -> Points {
    let mut all = Points::default();
    for cloud in clouds {
        all.append(cloud.clone());
    }
    all
}

fn subject(
    choice: impl Into<MethodChoice>,
    special: &str,
    clouds: Vec<Points>,
    change: impl FnOnce(&mut Frame),
) -> MethodScene {
    let choice = choice.into();
    let (method, _why) = plan::resolve(choice, &joined(&clouds));
    let fov_y = 0.8;
    let eye = DVec3::new(0.75, 1.0, 3.5);
    let camera = stage::looking(eye, DVec3::ZERO, Projection::Perspective { fov_y }, 0.1, 100.0);
    let mut frame = Frame { fragments: true, ..Frame::new(camera, SIZE, method) };
    change(&mut frame);
    let comma = if special.is_empty() { "" } else { ", " };
    MethodScene { name: format!("{}{comma}{special}", choice.name()), clouds, choice, frame }
}

fn as_it_is(_: &mut Frame) {}

/// An orthographic view of the same.
fn orthographic(frame: &mut Frame) {
    frame.camera.projection = Projection::Orthographic { height: 3.0 };
}

/// Light from a point beside the scene.
fn lit(frame: &mut Frame) {
    let light = Light::Position(DVec3::new(2.0, 3.0, 2.5));
    frame.shading = Shading { model: ShadingModel::Phong, specular: 0.3, light, ..Shading::default() };
}

fn lit_and_encoded(frame: &mut Frame) {
    lit(frame);
    frame.color = ColorSpace::Encoded;
}

/// Blended as display values.
fn encoded(frame: &mut Frame) {
    frame.color = ColorSpace::Encoded;
}

/// Shadows of that light, which is a small ball.
fn shadowed(frame: &mut Frame) {
    lit(frame);
    frame.shadows =
        Some(Shadows { samples: 3, light_radius: 0.2, resolution: MapResolution::Pixels(48), ..Shadows::default() });
}

/// Transparent discs, and their approximations.
fn discs() -> Vec<MethodScene> {
    let flat = Discs::default();
    let soft_edged = Discs { falloff: Falloff::Gaussian, ..flat };
    let oriented = Discs { shape: DiscShape::Oriented, ..flat };
    let drawn = |discs| Discs { raster: Raster::Hardware, ..discs };
    let in_place = Discs { long_lists: LongLists::InPlace, ..oriented };
    let computed = Discs { raster: Raster::Compute, ..oriented };
    let moments = Moments { discs: oriented, moments: MomentCount::Eight, ..Moments::default() };
    let tailed = Hybrid { k: 3, tail: Tail::Moments, ..Hybrid::default() };
    let sampled = |discs| Stochastic { discs, samples: 24, alpha_correction: true };
    let (few, many) = (clouds::few, clouds::many);
    vec![
        subject(MethodChoice::Auto(flat), "", many(), as_it_is),
        subject(Method::ABuffer(flat), "", many(), as_it_is),
        subject(Method::ABuffer(soft_edged), "Gaussian, encoded", many(), lit_and_encoded),
        subject(Method::ABuffer(oriented), "oriented", many(), orthographic),
        subject(Method::ABuffer(drawn(oriented)), "oriented, rasterizer", many(), as_it_is),
        subject(Method::ABuffer(in_place), "oriented, in place", many(), as_it_is),
        subject(Method::LinkedList(oriented), "oriented", many(), as_it_is),
        subject(Method::Sorted(flat), "", many(), as_it_is),
        subject(Method::Sorted(Discs { falloff: Falloff::Gaussian, ..oriented }), "oriented, Gaussian", many(), lit),
        subject(Method::Peel(Peel::default()), "", few(), as_it_is),
        subject(Method::Peel(Peel { discs: oriented, layers: 9 }), "oriented, 9 layers", few(), as_it_is),
        subject(Method::Stochastic(sampled(Discs { raster: Raster::Compute, ..flat })), "compute", many(), as_it_is),
        subject(Method::Stochastic(sampled(computed)), "oriented, compute", few(), orthographic),
        subject(Method::Stochastic(sampled(drawn(oriented))), "oriented, rasterizer", few(), as_it_is),
        subject(Method::Hybrid(Hybrid::default()), "", many(), as_it_is),
        subject(
            Method::Hybrid(Hybrid { discs: oriented, k: 11, ..Hybrid::default() }),
            "oriented, k = 11",
            few(),
            as_it_is,
        ),
        subject(Method::Hybrid(tailed), "tail by moments", many(), as_it_is),
        subject(Method::Hybrid(Hybrid { discs: oriented, ..tailed }), "oriented, tail by moments", few(), as_it_is),
        subject(Method::Mlab(Mlab::default()), "", many(), as_it_is),
        subject(Method::Mlab(Mlab { discs: oriented, nodes: 3 }), "oriented, 3 nodes", few(), as_it_is),
        subject(Method::Moments(Moments::default()), "", many(), as_it_is),
        subject(Method::Moments(moments), "oriented, 8 moments", few(), orthographic),
        subject(Method::Wavelet(Wavelet::default()), "", many(), as_it_is),
        subject(Method::Wavelet(Wavelet { discs: soft_edged, rank: 5 }), "Gaussian, rank 5", many(), as_it_is),
        subject(Method::Weighted(flat), "", many(), as_it_is),
        subject(Method::Average(soft_edged), "Gaussian", many(), as_it_is),
        subject(Method::Unsorted(flat), "", many(), as_it_is),
    ]
}

/// Gaussian splats by both kernels and in every order, with harmonics, alone and among discs.
fn gaussians() -> Vec<MethodScene> {
    let settings = GaussianSettings::default();
    let with = |gaussians| Discs { gaussians, ..Discs::default() };
    let by_ray = with(GaussianSettings { kernel: Kernel::Ray, ..settings });
    let ellipsoids = with(GaussianSettings { kernel: Kernel::Ellipsoid, ..settings });
    let smooth = with(GaussianSettings { antialias: true, order: Some(Order::Distance), ..settings });
    let drawn = Discs { raster: Raster::Hardware, ..by_ray };
    let computed = Discs { raster: Raster::Compute, ..with(settings) };
    let stochastic = Stochastic { discs: computed, samples: 24, alpha_correction: true };
    let (few, many, mixed) = (clouds::few_gaussians, clouds::many_gaussians, clouds::mixed);
    vec![
        subject(Method::ABuffer(with(settings)), "Gaussians, encoded", many(), encoded),
        subject(Method::ABuffer(drawn), "Gaussians by ray, rasterizer", few(), orthographic),
        subject(Method::ABuffer(ellipsoids), "ellipsoids, encoded", many(), encoded),
        subject(Method::LinkedList(by_ray), "Gaussians and discs", mixed(), as_it_is),
        subject(Method::LinkedList(ellipsoids), "ellipsoids and discs", mixed(), as_it_is),
        subject(Method::Sorted(smooth), "Gaussians by distance", many(), encoded),
        subject(Method::Peel(Peel { discs: by_ray, layers: 0 }), "Gaussians by ray", few(), as_it_is),
        subject(Method::Stochastic(stochastic), "Gaussians, compute", few(), as_it_is),
        subject(
            Method::Hybrid(Hybrid { discs: smooth, k: 11, ..Hybrid::default() }),
            "Gaussians by distance",
            many(),
            encoded,
        ),
        subject(Method::Weighted(with(settings)), "Gaussians and discs", mixed(), as_it_is),
    ]
}

/// Splats where only the nearest one counts, and splats that are blended when close together.
fn opaque() -> Vec<MethodScene> {
    let few = clouds::few;
    let splats = ScreenSplats { size: 1.5, ..ScreenSplats::default() };
    let relief = |shape| Interpolated { splats, shape };
    let drawn = ScreenSplats { raster: Raster::Hardware, ..splats };
    let blended = BlendedSplats { splats, ..BlendedSplats::default() };
    vec![
        subject(Method::Points, "", few(), lit),
        subject(Method::Squares(splats), "", few(), as_it_is),
        subject(Method::Circles(splats), "shadows", few(), shadowed),
        subject(Method::Circles(drawn), "rasterizer", few(), as_it_is),
        subject(Method::Paraboloid(relief(SplatShape::Circle)), "", few(), as_it_is),
        subject(Method::Cone(relief(SplatShape::Square)), "squares", few(), lit_and_encoded),
        subject(Method::Sphere(splats), "", few(), lit),
        subject(Method::Hqs(blended), "", clouds::many(), as_it_is),
        subject(Method::Splats(blended), "Phong", clouds::many(), lit),
    ]
}

/// Soft spheres and discs, with solid points among them.
fn soft() -> Vec<MethodScene> {
    let soft = Soft { density: Density::Softness(0.3), ..Soft::default() };
    let stiff = Soft { density: Density::Lambda(2e4), ..soft };
    let modulated = Soft { modulation: Some(0.9), ..soft };
    let shells = Soft { shells: Shells::Fixed(4), ..soft };
    let packed = Soft { layout: SoftLayout::Paper, ..soft };
    let (few, clear) = (clouds::few, clouds::soft_alone);
    vec![
        subject(Method::SoftBase(soft), "solid points", few(), as_it_is),
        subject(Method::SoftBase(soft), "", clear(), as_it_is),
        subject(Method::SoftBase(modulated), "modulated", clear(), orthographic),
        subject(Method::SoftBase(stiff), "stiff", clear(), as_it_is),
        subject(Method::SoftBase(packed), "packed", clear(), as_it_is),
        subject(Method::SoftConcentric(shells), "4 shells", clear(), as_it_is),
        subject(Method::SoftConcentric(soft), "solid points", few(), as_it_is),
        subject(Method::SoftExpress(modulated), "solid points", few(), as_it_is),
        subject(Method::OneLayer(OneLayer::default()), "", few(), as_it_is),
    ]
}

/// Surfaces of points that are closed in the image.
fn surfaces() -> Vec<MethodScene> {
    let filters = ImageSpace {
        fill: Iterations::Count(2),
        occlusion: Iterations::Count(2),
        min_layer_distance: Some(0.1),
        ..ImageSpace::default()
    };
    let layers = PeelLayers { filters: ImageSpace { cull: false, ..filters }, layers: 3, ..PeelLayers::default() };
    vec![
        subject(Method::ImageSpace(filters), "", clouds::surfaces(), lit),
        subject(Method::PeelLayers(layers), "", clouds::surfaces(), as_it_is),
        subject(Method::PeelLayers(layers), "shadows", clouds::surfaces(), shadowed),
    ]
}

/// Points that are shuffled into ensembles.
fn ensembles_of_points() -> Vec<MethodScene> {
    let spbr = Spbr { ensembles: 30, ..Spbr::default() };
    let simplified = SpbrSimplified { ensembles: 12, ..SpbrSimplified::default() };
    // Enough points that a small budget streams them.
    let crowd = Spbr { ensembles: 5, cos_theta: false, ..spbr };
    vec![
        subject(Method::Spbr(spbr), "", clouds::surfaces(), as_it_is),
        subject(Method::Spbr(spbr), "shaded", clouds::surfaces(), lit),
        subject(Method::Spbr(crowd), "70 000 points", clouds::crowd(), as_it_is),
        subject(Method::SpbrSimplified(simplified), "", clouds::surfaces(), as_it_is),
    ]
}

#[cfg(test)]
mod tests {
    use std::collections::HashSet;

    use super::*;
    use pellucid_scene::METHODS;

    #[test]
    fn there_is_one_for_every_method_and_no_two_of_a_name() {
        let subjects = subjects();
        for method in METHODS {
            assert!(subjects.iter().any(|s| s.choice.name() == *method), "{method} has none");
        }
        let names: HashSet<&String> = subjects.iter().map(|s| &s.name).collect();
        assert_eq!(names.len(), subjects.len());
    }
}
