//! The accuracy of the picture so far: its known properties, and the errors of the drafts of a view, once a better
//! picture exists to compare with.

use std::sync::Arc;

use super::navigate::Pose;
use pellucid_core::metrics;
use pellucid_core::points::Points;
use pellucid_engine::plan;
use pellucid_scene::{Method, Scene};

/// Bytes of pictures of one view that are kept to be measured; the last one is always kept.
const MOST_BYTES: usize = 256 << 20;

/// The relation of a method's whole picture to the exact one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Exactness {
    /// Exact except for rounding.
    Exact,
    /// A mean of samples or ensembles; the standard error estimates its error.
    Sampled,
    /// Approximation of the image that this exact method draws.
    Approximation(Method),
    /// The method's own image, which no other method draws.
    Own,
}

impl Exactness {
    /// Returns the exactness of a method that is applied to these points.
    pub fn for_method(method: &Method, points: &Points) -> Self {
        let exact = method.is_exact(plan::may_cross(method, points));
        match plan::exact(method, points) {
            _ if exact => Self::Exact,
            Some(Method::Spbr(_)) => Self::Sampled,
            Some(other) => Self::Approximation(other),
            None => Self::Own,
        }
    }
}

/// A picture of a view as its table of accuracy has it.
#[derive(Debug, Clone, PartialEq)]
pub struct Refinement {
    /// Description of the draft.
    pub name: String,
    /// Milliseconds that it took.
    pub ms: f64,
    /// Standard error in linear light, if that was found.
    pub standard_error: Option<f64>,
    /// RMSE in linear light against the best available picture of the view.
    pub rmse: Option<f64>,
}

/// The reference for pictures of the view.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Reference {
    /// The whole picture.
    Whole,
    /// The picture of an exact method.
    Exact(&'static str),
}

/// The accuracy of a view, for the overlay.
#[derive(Debug, Clone, PartialEq)]
pub struct Accuracy {
    /// The pictures so far, the last one last.
    pub refinements: Vec<Refinement>,
    /// The reference, if any.
    pub against: Option<Reference>,
    /// The exactness class of the last picture, if it is a whole one.
    pub exactness: Option<Exactness>,
}

/// Pictures of one view. Pixels are composed linear R, G, B, and missing while they are on the device alone.
#[derive(Default)]
pub struct History {
    view: Option<(Arc<Scene>, Pose)>,
    refinements: Vec<(Refinement, Option<Vec<[f32; 3]>>)>,
    against: Option<Reference>,
}

impl History {
    /// Adds a picture; those of another view are forgotten. A whole one becomes the reference for the earlier ones.
    pub fn add(
        &mut self,
        scene: &Arc<Scene>,
        pose: Pose,
        refinement: Refinement,
        pixels: Option<Vec<[f32; 3]>>,
        whole: bool,
    ) {
        if !self.is_of(scene, pose) {
            *self = Self { view: Some((scene.clone(), pose)), ..Self::default() };
        }
        // A repeated one carries no new information.
        self.refinements.retain(|(before, _)| before.name != refinement.name);
        self.refinements.push((refinement, pixels));
        while self.refinements.len() > 1 && self.bytes() > MOST_BYTES {
            self.refinements.remove(0);
        }
        if let (true, Some(((_, Some(whole)), rest))) = (whole, self.refinements.split_last_mut()) {
            measure(rest, whole);
            self.against = Some(Reference::Whole);
        }
    }

    /// Gives the last picture its pixels, if they were missing.
    pub fn supply(&mut self, pixels: Vec<[f32; 3]>) {
        if let Some((_, missing)) = self.refinements.last_mut() {
            missing.get_or_insert(pixels);
        }
    }

    /// Holds all pictures of a view against the one that an exact method makes of it; false if the view is another one
    /// by now.
    pub fn measure(&mut self, scene: &Arc<Scene>, pose: Pose, method: &'static str, exact: &[[f32; 3]]) -> bool {
        let same = self.is_of(scene, pose);
        if same {
            measure(&mut self.refinements, exact);
            self.against = Some(Reference::Exact(method));
        }
        same
    }

    /// True if it has pictures of this view.
    pub fn is_of(&self, scene: &Scene, pose: Pose) -> bool {
        self.view.as_ref().is_some_and(|(before, from)| *from == pose && **before == *scene)
    }

    fn bytes(&self) -> usize {
        self.refinements.iter().flat_map(|(_, pixels)| pixels).map(|pixels| size_of_val(pixels.as_slice())).sum()
    }

    /// The table.
    pub fn accuracy(&self, exactness: Option<Exactness>) -> Accuracy {
        let refinements = self.refinements.iter().map(|(refinement, _)| refinement.clone()).collect();
        Accuracy { refinements, against: self.against, exactness }
    }
}

/// Finds the errors of pictures against a better one.
fn measure(refinements: &mut [(Refinement, Option<Vec<[f32; 3]>>)], better: &[[f32; 3]]) {
    for (refinement, pixels) in refinements {
        refinement.rmse = pixels.as_ref().map(|pixels| metrics::rmse(better, pixels));
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;
    use pellucid_scene::{DiscShape, Discs, Document, Overrides, Peel, PeelLayers, Soft, Spbr, Stochastic};

    fn points(normals: bool) -> Points {
        let normals = normals.then(|| vec![Vec3::Z]);
        Points {
            positions: vec![Default::default()],
            opacities: vec![0.5],
            radii: vec![1.0],
            normals,
            ..Default::default()
        }
    }

    #[test]
    fn exact_methods_are_told_from_others() {
        let exactness_of = |method| Exactness::for_method(&method, &points(true));
        let discs = Discs::default();
        let oriented = Discs { shape: DiscShape::Oriented, ..discs };
        assert_eq!(exactness_of(Method::Sorted(discs)), Exactness::Exact);
        assert_eq!(exactness_of(Method::Sorted(oriented)), Exactness::Approximation(Method::ABuffer(oriented)));
        assert_eq!(Exactness::for_method(&Method::Sorted(oriented), &points(false)), Exactness::Exact);
        assert_eq!(exactness_of(Method::Peel(Default::default())), Exactness::Exact);
        let cut = Method::Peel(Peel { layers: 3, ..Default::default() });
        assert_eq!(exactness_of(cut), Exactness::Approximation(Method::ABuffer(discs)));
        assert_eq!(exactness_of(Method::Weighted(discs)), Exactness::Approximation(Method::ABuffer(discs)));
        let sampled = Method::Stochastic(Stochastic::default());
        assert_eq!(exactness_of(sampled), Exactness::Approximation(Method::ABuffer(discs)));
        assert_eq!(exactness_of(Method::SoftBase(Soft::default())), Exactness::Exact);
        assert!(matches!(
            exactness_of(Method::SoftExpress(Soft::default())),
            Exactness::Approximation(Method::SoftBase(_))
        ));
        assert_eq!(exactness_of(Method::Spbr(Spbr::default())), Exactness::Sampled);
        for own in [Method::Points, Method::Hqs(Default::default()), Method::PeelLayers(PeelLayers::default())] {
            assert_eq!(exactness_of(own), Exactness::Own);
        }
    }

    #[test]
    fn pictures_of_one_view_are_held_against_its_best() {
        let scene = Document::from_clouds(["a.ply"], &Overrides::default()).unwrap().scene().unwrap();
        let (scene, mut history) = (Arc::new(scene), History::default());
        let refinement = |name: &str| Refinement { name: name.into(), ms: 1.0, standard_error: None, rmse: None };
        let gray = |value: f32| vec![[value; 3]; 4];
        history.add(&scene, Pose::Scene, refinement("a"), Some(gray(0.5)), false);
        history.add(&scene, Pose::Scene, refinement("b"), Some(gray(0.25)), false);
        assert_eq!(history.accuracy(None).against, None);
        history.add(&scene, Pose::Scene, refinement("whole"), Some(gray(0.0)), true);
        let errors = |history: &History| {
            history.accuracy(None).refinements.iter().map(|refinement| refinement.rmse).collect::<Vec<_>>()
        };
        assert_eq!(errors(&history), [Some(0.5), Some(0.25), None]);
        assert!(history.measure(&scene, Pose::Scene, "abuffer", &gray(0.125)));
        assert_eq!(errors(&history), [Some(0.375), Some(0.125), Some(0.125)]);
        assert_eq!(history.accuracy(None).against, Some(Reference::Exact("abuffer")));
        // Another view: earlier pictures are forgotten, and late results for the old one are rejected.
        let mut again = Scene::clone(&scene);
        again.image.size[0] += 1;
        let again = Arc::new(again);
        history.add(&again, Pose::Scene, refinement("a"), Some(gray(1.0)), false);
        assert_eq!(errors(&history), [None]);
        assert!(!history.measure(&scene, Pose::Scene, "abuffer", &gray(0.0)));
        assert_eq!(errors(&history), [None]);
    }

    #[test]
    fn the_history_stays_within_its_bytes() {
        let scene = Document::from_clouds(["a.ply"], &Overrides::default()).unwrap().scene().unwrap();
        let (scene, mut history) = (Arc::new(scene), History::default());
        let pixels = MOST_BYTES / size_of::<[f32; 3]>() / 2;
        for name in ["a", "b", "c"] {
            let refinement = Refinement { name: name.into(), ms: 1.0, standard_error: None, rmse: None };
            history.add(&scene, Pose::Scene, refinement, Some(vec![[0.0; 3]; pixels]), false);
        }
        assert_eq!(history.accuracy(None).refinements.len(), 2);
        assert!(history.bytes() <= MOST_BYTES);
    }
}
