//! A cloud of a scene that stays in its store.

use std::sync::Arc;

use super::super::assemble::{self, CloudScope, Known, given_radius, radius, transformed, upright_note};
use super::super::classes;
use super::super::clip::Clips;
use super::super::coloring::Coloring;
use super::super::error::Error;
use super::super::gaussians;
use super::super::legend::Legend;
use super::super::scene::Scene;
use super::levels::branches;
use super::survey::OpenStore;
use crate::prepare;
use crate::supply::Block;
use pellucid_core::cloud::facts::Facts;
use pellucid_core::cloud::{Bounds, Cloud, UpAxis, upright};
use pellucid_core::points::{Points, WholeSplats};
use pellucid_core::progress::Progress;
use pellucid_io as io;
use pellucid_io::store::{Node, Piece, Store, StoreSurvey, Summary};

/// Place of a cloud in its scene.
pub(super) struct CloudPlace<'a> {
    pub scene: &'a Scene,
    pub clips: &'a Clips,
    pub index: usize,
    /// Points of the clouds before it.
    pub first: u64,
}

/// The cloud.
#[derive(Debug)]
pub(super) struct StoredCloud {
    pub store: Arc<dyn Store>,
    /// Index of the cloud in the scene.
    index: usize,
    pub facts: Facts,
    known: Known,
    /// Note that the vertical was guessed.
    pub up_note: Option<String>,
    /// Points of the clouds before it.
    first: u64,
    /// Bounding box of the cloud in the scene.
    bounds: Bounds,
    pub largest_radius: f32,
    /// The radius that all points have, unless they or their classes have their own.
    fixed_radius: Option<f32>,
    /// The largest radius that a class may give.
    class_radius: f32,
    /// The largest component that a color of its points may have.
    pub brightest: f32,
    /// Count and bounds of its Gaussians, if its points are drawn as such.
    pub splats: Option<WholeSplats>,
    pub is_transparent: bool,
    /// Coloring and the reason for it, a phrase.
    pub coloring: String,
}

impl StoredCloud {
    /// Returns the cloud at a place in the scene, in a store; and some of its points, which stand for all. What its
    /// colors mean goes to the legend.
    pub fn new(
        &CloudPlace { scene, clips, index, first }: &CloudPlace<'_>,
        opened: &OpenStore,
        legend: &mut Legend,
        progress: &Progress,
    ) -> Result<(Self, Points), crate::OpenError> {
        let (settings, store) = (&scene.clouds[index], Arc::clone(&opened.store));
        let like = &store.summary().like;
        let request = request(scene, index, like)?;
        if let Some(what) = request.missing(like) {
            return Err(Error::Unprepared { path: settings.path.clone(), what }.into());
        }
        let field = request.unscaled_field(like);
        let (StoreSurvey { facts, mut sample }, range) = opened.survey(settings, field.as_ref(), progress)?;
        // As of a cloud that is read as a whole.
        upright::lay(&mut sample);
        let up_note = upright_note(scene, &sample);
        let bounds = facts.bounds.unwrap_or(store.summary().bounds);
        let field_error = |source| Error::Field { path: settings.path.clone(), source };
        let found = prepare::of_part(&sample, &request, bounds, range).map_err(field_error)?;
        let mut coloring = Coloring::of_sample(scene, index, &sample, &facts);
        coloring.count_drawn(clips, None)?;
        legend.add(&coloring, clips, found.fields.as_deref(), None)?;
        let (scales, described) = (coloring.scales(found.fields.as_deref())?, coloring.describe());
        let known = Known { scales, up: sample.up, request, bounds, range, has_normals: facts.has_normals };
        // Without one of their own, points have none here, whatever is stored.
        let has_own = known.request.radii && like.radii.is_some() || like.own_radii().is_some();
        let drawn = gaussians::are_drawn(scene, settings, like);
        let fixed_radius = (!drawn && (settings.radius.is_some() || !has_own)).then(|| radius(settings, None));
        let (given, others) = if drawn { (Vec::new(), true) } else { classes::possible_radii(&settings.class, &facts) };
        let class_radius = given.into_iter().fold(0.0, f32::max);
        let class_radius = given_radius(settings, class_radius);
        let own_radius = fixed_radius.unwrap_or_else(|| match drawn {
            true => gaussians::scaled_reach(facts.largest_radius, settings),
            false => radius(settings, Some(facts.largest_radius)),
        });
        let largest_radius = if others { own_radius.max(class_radius) } else { class_radius };
        let is_transparent = settings.opacity < 1.0
            || settings.surface_opacity.is_some_and(|opacity| opacity < 1.0)
            || settings.class.iter().any(|class| class.opacity.is_some_and(|opacity| opacity < 1.0))
            || facts.is_transparent;
        let colors = settings.color.iter().chain(settings.class.iter().filter_map(|class| class.color.as_ref()));
        let brightest = colors.map(|color| color.max_element()).fold(facts.brightest, f32::max);
        let mut cloud = Self {
            bounds: in_scene(scene, index, &bounds),
            store,
            index,
            facts,
            known,
            first,
            largest_radius,
            fixed_radius,
            class_radius,
            brightest,
            splats: None,
            is_transparent,
            coloring: described,
            up_note,
        };
        let points = cloud.transformed(scene, clips, sample, &[])?;
        cloud.splats = points.gaussians.as_ref().map(|all| WholeSplats {
            count: cloud.facts.points,
            degree: all.degree,
            // A color of the scene is the display value of a linear one.
            brightest: cloud.facts.brightest_splats[all.degree as usize].max(gaussians::display(brightest)),
        });
        Ok((cloud, points))
    }

    /// Returns the vertical.
    pub fn up(&self) -> UpAxis {
        self.known.up
    }

    /// Returns `true` if any point has a normal.
    pub fn has_normals(&self) -> bool {
        self.known.has_normals
    }

    /// Returns the box of its points in the scene.
    pub fn bounds(&self) -> Option<Bounds> {
        (self.facts.points > 0).then_some(self.bounds)
    }

    /// Returns its nodes as blocks.
    pub fn blocks(&self, scene: &Scene) -> Vec<(usize, Block)> {
        let nodes = self.store.nodes();
        let (radii, branches) = (self.radii(nodes, scene), branches(nodes, scene.clouds[self.index].scale));
        let with_points = nodes.iter().enumerate().filter(|(_, node)| node.points > 0);
        let block = |(at, node): (usize, &Node)| {
            let bounds = in_scene(scene, self.index, &node.bounds);
            (at, Block { bounds, radius: radii[at], points: node.points, branch: branches[at] })
        };
        with_points.map(block).collect()
    }

    /// Largest radius, for each node, of all points that may be in the places of its own: those above and below it.
    /// Of Gaussians how far its own reach.
    fn radii(&self, nodes: &[Node], scene: &Scene) -> Vec<f32> {
        let settings = &scene.clouds[self.index];
        if let Some(radius) = self.fixed_radius {
            return vec![radius.max(self.class_radius); nodes.len()];
        }
        if self.splats.is_some() {
            let reach = |own: f32| gaussians::scaled_reach(own, settings);
            return nodes.iter().map(|node| node.largest_radius.map_or(self.largest_radius, reach)).collect();
        }
        let own = |node: &Node| node.largest_radius.map(|own| radius(settings, Some(own)).max(self.class_radius));
        let has_levels = nodes.iter().any(|node| node.parent.is_some());
        let Some(own) = nodes.iter().map(own).collect::<Option<Vec<f32>>>().filter(|_| has_levels) else {
            return vec![self.largest_radius; nodes.len()];
        };
        // Parents come before their children.
        let (mut above, mut below) = (own.clone(), own);
        for at in 0..nodes.len() {
            if let Some(parent) = nodes[at].parent {
                above[at] = above[at].max(above[parent as usize]);
            }
        }
        for at in (0..nodes.len()).rev() {
            if let Some(parent) = nodes[at].parent {
                below[parent as usize] = below[parent as usize].max(below[at]);
            }
        }
        above.into_iter().zip(below).map(|(above, below)| above.max(below)).collect()
    }

    /// Returns the identity of its points.
    pub fn identity(&self) -> String {
        format!("{:?} {:?} {:?}", self.store.summary(), self.known, self.splats)
    }

    /// Returns the points of a node in the scene.
    pub fn points(&self, scene: &Scene, clips: &Clips, node: usize) -> Result<Points, io::Error> {
        let Piece { cloud, places } = self.store.read(node)?;
        self.transformed(scene, clips, cloud, &places).map_err(|error| io::Error::Malformed {
            path: self.store.summary().path.clone(),
            place: format!("node {node}"),
            cause: error.to_string(),
        })
    }

    fn transformed(&self, scene: &Scene, clips: &Clips, cloud: Cloud, places: &[u64]) -> Result<Points, Error> {
        // Places are those of points before any is left out.
        let file_order = places.iter().map(|place| (self.first + place) as u32).collect();
        transformed(scene, clips, self.index, cloud, CloudScope::Part(&self.known, file_order))
    }
}

/// Returns `true` if a store has what its scene needs of it.
pub(super) fn has_all(scene: &Scene, index: usize, summary: &Summary) -> Result<bool, Error> {
    let like = &summary.like;
    Ok(request(scene, index, like)?.missing(like).is_none())
}

/// The data that a scene needs of a cloud's points; normals to shade by are those that points have.
fn request(scene: &Scene, index: usize, like: &Cloud) -> Result<prepare::Request, Error> {
    let settings = &scene.clouds[index];
    let coloring = Coloring::of_sample(scene, index, like, &Facts::default());
    let method = scene.method;
    let fields = method.needs_field() || coloring.needs_field();
    let mut request = assemble::request(scene, settings, method.needs_radii(), fields);
    request.forgo_shapes(gaussians::are_drawn(scene, settings, like));
    Ok(prepare::Request { shading: None, ..request })
}

/// A box of a cloud in the scene.
fn in_scene(scene: &Scene, index: usize, bounds: &Bounds) -> Bounds {
    let ends = [bounds.min, bounds.max].map(|corner| scene.clouds[index].placed(corner));
    Bounds { min: ends[0].min(ends[1]), max: ends[0].max(ends[1]) }
}
