//! The points of a scene that is edited. They keep their origins, so that a setting that doesn't move points costs no
//! more than the columns it changes.
//!
//! [`arrange`](super::arrange) orders points by position first. Colors, opacities, radii and fields only order points
//! of equal position. When they change, each point keeps its place, except for those that share their position with
//! others.

mod derived;
mod origins;

use std::borrow::Borrow;
use std::sync::Arc;

use glam::{DVec3, Vec3};
use pellucid_core::progress::Progress;
use rayon::prelude::*;

pub use derived::DerivedColumns;

use super::assemble::{self, class_radius, opacity, radius, request};
use super::classes::Rules;
use super::clip::Clips;
use super::coloring::{ColorKey, Coloring, Colors};
use super::error::Error;
use super::gaussians;
use super::legend::Legend;
use super::nothing_left::{self, no_points};
use super::scene::Scene;
use super::seen::{leave_out, seen};
use super::settings::{ClassSettings, Clip, CloudSettings, ColorSettings, Outliers, Selection};
use super::surface_opacity::Opacity;
use super::units::Units;
use crate::prepare::ensembles::{self, Trace};
use crate::prepare::order;
use crate::prepare::outliers::Rule;
use crate::prepare::ties::Ties;
use crate::prepare::{Arranged, FieldKey, RadiusKey, ShadingNormals};
use origins::Origins;
use pellucid_core::cloud::Cloud;
use pellucid_core::cloud::gaussians::Gaussians;
use pellucid_core::parallel;
use pellucid_core::points::{Changes, Points, Unseen};

/// The result of [`arrange`](super::arrange) for a scene, which can be updated in place to that of another scene. In
/// addition to the points it takes 4 bytes for each point that was dealt and 8 for each that shares its position with
/// another.
#[derive(Debug, Clone)]
pub struct Tracked {
    arranged: Arranged,
    placement: PlacementKey,
    column_keys: Vec<ColumnKey>,
    /// Number of the point in each place, if points were dealt; otherwise [`Points::file_order`] has it.
    dealt: Vec<u32>,
    ties: Ties,
    origins: Origins,
}

/// Everything that determines the positions of points and their order; numbers by their bits, as the order compares
/// them.
#[derive(Debug, Clone, PartialEq)]
struct PlacementKey {
    dealt: bool,
    /// Scale, translation, and the outliers that are dropped.
    clouds: Vec<(u64, [u64; 3], Option<Rule>)>,
    /// Points of each cloud that are shown or hidden.
    hidden: Vec<Vec<(Selection, bool)>>,
    clips: Vec<Clip>,
    /// Normals that are estimated, and K of each cloud.
    normals: Option<(ShadingNormals, Vec<Option<usize>>)>,
    /// Keys that shapes and colors of Gaussians follow from, of clouds that are drawn as such.
    gaussians: Vec<Option<GaussianKey>>,
}

/// Key that the Gaussians of a cloud follow from, but for its scale.
#[derive(Debug, Clone, PartialEq)]
struct GaussianKey {
    radius_factor: u32,
    sh_degree: Option<u32>,
    color: Option<[u32; 3]>,
    coloring: ColorSettings,
    classes: Vec<ClassSettings>,
}

impl GaussianKey {
    fn of(settings: &CloudSettings) -> Self {
        Self {
            radius_factor: settings.radius_factor.to_bits(),
            sh_degree: settings.sh_degree,
            color: settings.color.map(bits_of),
            coloring: settings.coloring.clone(),
            classes: settings.class.clone(),
        }
    }
}

impl PlacementKey {
    fn for_scene(scene: &Scene, clouds: &[impl Borrow<Cloud>]) -> Self {
        let bits = |translate: DVec3| translate.to_array().map(f64::to_bits);
        let placed =
            |cloud: &CloudSettings| (cloud.scale.to_bits(), bits(cloud.translate), cloud.strays.rule(Outliers::Drop));
        let each = scene.clouds.iter().zip(clouds.iter().map(Borrow::borrow));
        let drawn = |(settings, cloud)| gaussians::are_drawn(scene, settings, cloud).then(|| GaussianKey::of(settings));
        let visible = |entry: &ClassSettings| Some((entry.points.clone(), entry.visible?));
        let hidden = |cloud: &CloudSettings| cloud.class.iter().filter_map(visible).collect();
        let neighbors = || scene.clouds.iter().map(|cloud| cloud.neighbors).collect();
        Self {
            dealt: scene.method.is_dealt(),
            clouds: scene.clouds.iter().map(placed).collect(),
            hidden: scene.clouds.iter().map(hidden).collect(),
            clips: scene.clips.clone(),
            normals: scene.shading_normals().map(|which| (which, neighbors())),
            gaussians: each.map(drawn).collect(),
        }
    }
}

/// Everything that determines the other columns of a cloud's points; numbers by their bits.
#[derive(Debug, Clone, PartialEq)]
struct ColumnKey {
    color: ColorKey,
    opacity: u32,
    /// Opacity of the surface, and K if the opacities of its points depend on neighbors.
    surface_opacity: Option<(u32, Option<usize>)>,
    classes: Vec<ClassSettings>,
    /// Key of the radii.
    radius: RadiiKey,
    /// Key of the field, if the method needs it.
    field: Option<FieldKey>,
}

/// Everything that determines the radii of a cloud's points.
#[derive(Debug, Clone, PartialEq)]
struct RadiiKey {
    given: Option<u32>,
    factor: u32,
    /// Definition of the estimated ones, if they are asked for.
    estimated: Option<RadiusKey>,
    /// Radii of classes.
    classes: Vec<(Selection, u32)>,
}

impl RadiiKey {
    fn of(settings: &CloudSettings, estimated: Option<RadiusKey>) -> Self {
        let given = |entry: &ClassSettings| Some((entry.points.clone(), entry.radius?.to_bits()));
        Self {
            given: settings.radius.map(f32::to_bits),
            factor: settings.radius_factor.to_bits(),
            estimated,
            classes: settings.class.iter().filter_map(given).collect(),
        }
    }
}

fn bits_of(color: Vec3) -> [u32; 3] {
    color.to_array().map(f32::to_bits)
}

/// A cloud with the values that a scene gives it.
struct CloudView<'a> {
    settings: &'a CloudSettings,
    cloud: &'a Cloud,
    rules: Rules<'a>,
    colors: &'a Colors,
    /// The file's values, used where the settings have none; access is not sequential.
    radii: Option<&'a [f32]>,
    fields: Option<&'a [f32]>,
    /// Radii of Eq. 20, and K, if opacities depend on them.
    uncapped: Option<&'a [f32]>,
    neighbors: usize,
    /// Normals of the file, or with estimated ones.
    normals: Option<&'a [Vec3]>,
    /// Marks the points that are not there.
    dropped: Option<&'a [bool]>,
    /// Gaussians of a cloud that is drawn as such.
    gaussians: Option<&'a Gaussians>,
}

impl CloudView<'_> {
    fn color(&self, i: usize) -> Vec3 {
        let own = || match self.colors {
            Colors::Own => self.cloud.colors.as_ref().map_or(Vec3::ONE, |colors| colors[i]),
            Colors::One(color) => *color,
            Colors::Each(colors) => colors[i],
        };
        self.rules.color(i).unwrap_or_else(own)
    }

    fn opacity(&self, i: usize) -> f32 {
        let base = Opacity { settings: self.settings, estimated: self.uncapped, neighbors: self.neighbors };
        opacity(base, &self.rules, self.cloud, i, self.radius(i))
    }

    fn radius(&self, i: usize) -> f32 {
        if let Some(gaussians) = self.gaussians {
            return gaussians::reach(gaussians.extents[i], self.settings);
        }
        let own = || radius(self.settings, self.radii.map(|radii| radii[i]));
        class_radius(self.settings, &self.rules, i).unwrap_or_else(own)
    }

    fn field(&self, i: usize) -> f32 {
        self.fields.map_or(0.0, |fields| fields[i])
    }

    /// All points, with marks on the remaining ones if some are not drawn.
    fn points(&self, clips: &Clips) -> (Points, Option<Vec<bool>>) {
        let count = self.cloud.len();
        let mut points = Points {
            positions: parallel::map_each(&self.cloud.positions, |p| self.settings.placed(*p)),
            colors: parallel::map(count, |i| self.color(i)),
            opacities: parallel::map(count, |i| self.opacity(i)),
            radii: parallel::map(count, |i| self.radius(i)),
            normals: assemble::shown(self.normals.map(<[Vec3]>::to_vec)),
            fields: self.fields.map_or_else(Vec::new, <[f32]>::to_vec),
            sensor: assemble::sensor(self.settings, self.cloud),
            ..Points::default()
        };
        points.gaussians = self.gaussians.map(|all| {
            let paint = gaussians::Paint { colors: &points.colors, own: matches!(self.colors, Colors::Own) };
            gaussians::placed(self.settings, all, paint, |i| self.rules.color(i).is_some())
        });
        let seen = seen(self.rules.visible_points(count), clips, &points.positions);
        let keep = leave_out(&mut points, seen.as_deref(), self.dropped);
        (points, keep)
    }
}

/// Computes the data that a scene needs of its clouds' points, and the keys of their columns.
fn learn(
    scene: &Scene,
    clouds: &[impl Borrow<Cloud>],
    derived: &mut [DerivedColumns],
    progress: &Progress,
) -> Result<Vec<ColumnKey>, Error> {
    let (method, clips) = (&scene.method, Clips::load(&scene.clips)?);
    let each = scene.clouds.iter().zip(clouds.iter().map(Borrow::borrow)).zip(derived).enumerate();
    let column_key =
        |(index, ((settings, cloud), derived)): (usize, ((&CloudSettings, &Cloud), &mut DerivedColumns))| {
            let coloring = Coloring::of(scene, index, cloud);
            let mut request =
                request(scene, settings, method.needs_radii(), method.needs_field() || coloring.needs_field());
            request.forgo_shapes(gaussians::are_drawn(scene, settings, cloud));
            let found = derived.learn(cloud, &request, progress);
            found.map_err(|source| Error::Field { path: settings.path.clone(), source })?;
            let color = coloring.key(&request, &scene.clips);
            derived.learn_colors(coloring, &color, &clips)?;
            let neighbors = request.uncapped.then(|| request.neighbors_of(cloud));
            let estimated = request.radii.then(|| request.radius_key(cloud));
            Ok(ColumnKey {
                color,
                opacity: settings.opacity.to_bits(),
                surface_opacity: settings.surface_opacity.map(|a| (a.to_bits(), neighbors)),
                classes: settings.class.clone(),
                radius: RadiiKey::of(settings, estimated),
                field: method.needs_field().then(|| request.field_key(cloud)),
            })
        };
    each.map(column_key).collect()
}

/// The clouds as a scene shows them, once [`learn`] has computed their data.
fn views<'a>(
    scene: &'a Scene,
    clouds: &'a [impl Borrow<Cloud>],
    derived: &'a [DerivedColumns],
    column_keys: &[ColumnKey],
) -> Result<Vec<CloudView<'a>>, Error> {
    let each = scene.clouds.iter().zip(clouds.iter().map(Borrow::borrow)).zip(derived).zip(column_keys);
    each.map(|(((settings, cloud), derived), column_key)| {
        let own = if column_key.radius.estimated.is_some() { derived.radii() } else { cloud.own_radii() };
        let normals = scene.shading_normals().and_then(|which| derived.normals(which));
        let neighbors = column_key.surface_opacity.and_then(|(_, neighbors)| neighbors);
        Ok(CloudView {
            settings,
            cloud,
            rules: Rules::of(settings, cloud)?,
            colors: derived.colors(),
            radii: own.filter(|_| settings.radius.is_none()),
            fields: column_key.field.as_ref().and_then(|_| derived.fields()),
            uncapped: neighbors.and_then(|_| derived.uncapped()),
            neighbors: neighbors.unwrap_or_default(),
            normals: normals.or(cloud.normals.as_deref()),
            dropped: settings.strays.rule(Outliers::Drop).and_then(|rule| derived.dropped(rule)),
            gaussians: cloud.gaussians.as_ref().filter(|_| gaussians::are_drawn(scene, settings, cloud)),
        })
    })
    .collect()
}

/// Returns what the colors of a scene's points mean; `derived` is that of the points of this scene.
///
/// # Errors
/// Returns the errors of [`Tracked::new`].
pub fn legend(scene: &Scene, clouds: &[impl Borrow<Cloud>], derived: &[DerivedColumns]) -> Result<Legend, Error> {
    let systems = clouds.iter().map(|cloud| cloud.borrow().crs.clone()).collect();
    let (mut legend, clips) = (Legend::new(Units::of(scene, systems)), Clips::load(&scene.clips)?);
    for (index, (cloud, derived)) in clouds.iter().map(Borrow::borrow).zip(derived).take(scene.clouds.len()).enumerate()
    {
        let dropped = scene.clouds[index].strays.rule(Outliers::Drop).and_then(|rule| derived.dropped(rule));
        let mut coloring = Coloring::of(scene, index, cloud);
        coloring.count_drawn(&clips, dropped)?;
        legend.add(&coloring, &clips, derived.fields(), dropped)?;
    }
    Ok(legend)
}

impl Tracked {
    /// Returns the points of a scene, as [`arrange`](super::arrange) orders them. `derived` has one entry per cloud,
    /// with earlier results.
    ///
    /// # Errors
    /// Returns an error if no point is left, if a cloud lacks the property of its field or its colors, or if the
    /// polygons of a clip can't be read.
    pub fn new(
        scene: &Scene,
        clouds: &[impl Borrow<Cloud>],
        derived: &mut [DerivedColumns],
        seed: u64,
        progress: &Progress,
    ) -> Result<Self, Error> {
        let column_keys = learn(scene, clouds, derived, progress)?;
        let (mut placed, mut origins, clips) = (Vec::new(), Origins::default(), Clips::load(&scene.clips)?);
        for view in views(scene, clouds, derived, &column_keys)? {
            let (points, keep) = view.points(&clips);
            origins.push(points.len(), keep.as_deref());
            placed.push(points);
        }
        let placement = PlacementKey::for_scene(scene, clouds);
        progress.reset();
        let (arranged, trace) = if placement.dealt {
            progress.set_message("dealing points to ensembles");
            let mut trace = Trace::default();
            let dealt = ensembles::deal_traced(placed, seed, progress, Some(&mut trace));
            (Arranged::Dealt(dealt), trace)
        } else {
            progress.set_message("putting points into order");
            let mut points = Points::default();
            placed.into_iter().for_each(|cloud| points.append(cloud));
            let points = order::canonical(points);
            let ties = Ties::find(&points.positions);
            (Arranged::Canonical(Arc::new(points)), Trace { origins: Vec::new(), ties })
        };
        if arranged.points().is_empty() {
            return Err(no_points(scene, arranged.points(), &nothing_left::classes(scene, clouds)));
        }
        Ok(Self { arranged, placement, column_keys, dealt: trace.origins, ties: trace.ties, origins })
    }

    /// Returns the points as they are arranged.
    pub fn arranged(&self) -> &Arranged {
        &self.arranged
    }

    /// Returns all points, in either order.
    pub fn points(&self) -> &Points {
        self.arranged.points()
    }

    /// Updates the points in place to the result of [`arrange`](super::arrange) for another scene of the same clouds.
    /// Returns `None`, with everything unchanged, if points would move: then they must be arranged again. A dealt list
    /// that is shared is copied.
    ///
    /// # Errors
    /// A cloud lacks the property of its field; nothing changes.
    pub fn follow(
        &mut self,
        scene: &Scene,
        clouds: &[impl Borrow<Cloud>],
        derived: &mut [DerivedColumns],
        progress: &Progress,
    ) -> Result<Option<Changes>, Error> {
        if PlacementKey::for_scene(scene, clouds) != self.placement {
            return Ok(None);
        }
        let column_keys = learn(scene, clouds, derived, progress)?;
        if column_keys == self.column_keys {
            return Ok(Some(Changes::default()));
        }
        let views = views(scene, clouds, derived, &column_keys)?;
        let Self { arranged, dealt, ties, origins, .. } = self;
        let points = match arranged {
            Arranged::Canonical(points) => Arc::make_mut(points),
            Arranged::Dealt(dealt) => Arc::make_mut(&mut dealt.points),
            // Nobody tracks points that come some at a time.
            Arranged::Supplied(_) => return Ok(None),
        };
        let mut order = std::mem::take(if self.placement.dealt { dealt } else { &mut points.file_order });
        let mut changes =
            ColumnUpdate { origins, order: &order, clouds: &views, before: &self.column_keys, after: &column_keys }
                .all(points);
        changes.order = changes.any() && ties.settle(points, &mut order);
        *(if self.placement.dealt { dealt } else { &mut points.file_order }) = order;
        if let (Arranged::Dealt(dealt), true) = (arranged, changes.opacities) {
            dealt.renew_opacities();
        }
        self.column_keys = column_keys;
        Ok(Some(changes))
    }
}

/// An update of the columns whose keys changed.
struct ColumnUpdate<'a> {
    origins: &'a Origins,
    /// Number of the point in each place.
    order: &'a [u32],
    clouds: &'a [CloudView<'a>],
    before: &'a [ColumnKey],
    after: &'a [ColumnKey],
}

impl<'a> ColumnUpdate<'a> {
    /// Gives all columns their values, and returns the changed ones.
    fn all(&self, points: &mut Points) -> Changes {
        let colors = self.changed(|column_key| (column_key.color.clone(), column_key.classes.clone()));
        let opacities = self.changed(|column_key| {
            // The opacity of a disc of a surface depends on its radius.
            let of_surface = column_key.surface_opacity.map(|opacity| (opacity, column_key.radius.clone()));
            (column_key.opacity, of_surface, column_key.classes.clone())
        });
        let radii = self.changed(|column_key| column_key.radius.clone());
        Changes {
            colors: self.column(&mut points.colors, &colors, CloudView::color, bits_of),
            opacities: self.column(&mut points.opacities, &opacities, CloudView::opacity, f32::to_bits),
            radii: self.column(&mut points.radii, &radii, CloudView::radius, f32::to_bits),
            fields: self.fields(&mut points.fields),
            unseen: self.unseen(&mut points.unseen, &radii),
            order: false,
            gaussians: false,
        }
    }

    /// Gives points that are not drawn their radii. Returns true if any changed.
    fn unseen(&self, unseen: &mut Arc<Unseen>, changed: &[bool]) -> bool {
        if unseen.radii.is_empty() || !changed.contains(&true) {
            return false;
        }
        let radii = self.clouds.iter().enumerate().flat_map(|(cloud, view)| {
            let is_there = |i: &usize| {
                let dropped = view.dropped.is_some_and(|dropped| dropped[*i]);
                !dropped && view.settings.placed(view.cloud.positions[*i]).is_finite()
            };
            let left_out = self.origins.left_out(cloud, view.cloud.len());
            left_out.into_iter().filter(is_there).map(|i| view.radius(i))
        });
        let before = std::mem::replace(&mut Arc::make_mut(unseen).radii, radii.collect());
        before != unseen.radii
    }

    /// The method decides if the clouds have F, all or none.
    fn fields(&self, fields: &mut Vec<f32>) -> bool {
        let wanted = self.after.iter().all(|column_key| column_key.field.is_some());
        let toggled = wanted == fields.is_empty();
        match (wanted, toggled) {
            (true, true) => *fields = vec![0.0; self.order.len()],
            (false, true) => *fields = Vec::new(),
            _ => {}
        }
        let changed = self.changed(|column_key| column_key.field.clone());
        (wanted && self.column(fields, &changed, CloudView::field, f32::to_bits)) || toggled
    }

    /// Marks the clouds for which this part of the key changed.
    fn changed<K: PartialEq>(&self, part: impl Fn(&ColumnKey) -> K) -> Vec<bool> {
        self.before.iter().zip(self.after).map(|(before, after)| part(before) != part(after)).collect()
    }

    /// Updates a column for the clouds that changed. Returns true if any value did.
    fn column<T: Copy + Send, K: PartialEq>(
        &self,
        column: &mut [T],
        changed: &[bool],
        value: impl Fn(&CloudView<'a>, usize) -> T + Sync,
        bits: impl Fn(T) -> K + Sync,
    ) -> bool {
        if !changed.contains(&true) {
            return false;
        }
        let each = column.par_iter_mut().zip(self.order).map(|(to, number)| {
            let (cloud, i) = self.origins.locate(*number);
            if !changed[cloud] {
                return false;
            }
            let before = std::mem::replace(to, value(&self.clouds[cloud], i));
            bits(before) != bits(*to)
        });
        each.reduce(|| false, |a, b| a | b)
    }
}
