//! Turns the clouds of a scene into the points of a frame: settings applied, merged, put into canonical order.

use std::borrow::Borrow;
use std::sync::Arc;

use glam::{DVec3, Vec3};
use pellucid_core::progress::{Phase, Progress};

use super::along_curve;
use super::classes::{self, Rules};
use super::clip::Clips;
use super::coloring::{self, Coloring, Colors, Scales};
use super::error::Error;
use super::gaussians;
use super::legend::Legend;
use super::nothing_left::{self, no_points};
use super::procedural::Generated;
use super::scene::Scene;
use super::seen::{leave_out, seen};
use super::settings::{CloudSettings, Outliers};
use super::surface_opacity::Opacity;
use super::units::Units;
use crate::prepare;
use crate::prepare::Arranged;
use crate::prepare::ensembles;
use pellucid_core::cloud::sensor::Sensor;
use pellucid_core::cloud::shadow_texture::ShadowTexture;
use pellucid_core::cloud::{Bounds, Cloud, UpAxis};
use pellucid_core::parallel;
use pellucid_core::points::Points;
use pellucid_io as io;

/// Reads the scene's cloud files, in the scene's order.
///
/// # Errors
/// The first file that can't be read.
pub fn load_clouds(scene: &Scene, progress: &Progress) -> Result<Vec<Cloud>, io::Error> {
    let load = |cloud: &CloudSettings| {
        progress.reset();
        progress.set_message(format!("reading {}", cloud.path.display()));
        io::load_with(&cloud.path, cloud.hints(), progress)
    };
    scene.clouds.iter().map(load).collect()
}

/// Returns the clouds of a generated scene, looked up by name (with or without the extension) instead of on the disk.
///
/// # Errors
/// A path that is not the name of any generated cloud.
pub fn take_generated(scene: &Scene, generated: &Generated) -> Result<Vec<Cloud>, Error> {
    let find = |settings: &CloudSettings| {
        let path = &settings.path;
        let is_named = |name: &str| path.as_os_str() == name || path.file_stem().is_some_and(|stem| stem == name);
        let missing = || Error::Usage(format!("{}: the built-in scene has no such cloud", path.display()));
        generated.clouds.iter().find(|(name, _)| is_named(name)).map(|(_, cloud)| cloud.clone()).ok_or_else(missing)
    };
    scene.clouds.iter().map(find).collect()
}

/// Returns the vertical of most clouds; Z in a draw, since surveys are what other things are put into.
pub fn up_axis(clouds: &[impl Borrow<Cloud>]) -> UpAxis {
    most_frequent(clouds.iter().map(|cloud| cloud.borrow().up))
}

/// Returns the most frequent one; Z in a draw.
pub(super) fn most_frequent(ups: impl Iterator<Item = UpAxis> + Clone) -> UpAxis {
    let count = |up: UpAxis| ups.clone().filter(|other| *other == up).count();
    // The last one of those that are most.
    let most = [UpAxis::X, UpAxis::NegativeY, UpAxis::Y, UpAxis::Z].into_iter().max_by_key(|up| count(*up));
    most.filter(|up| count(*up) > 0).unwrap_or_default()
}

/// Returns warnings about data of prepared clouds that the scene can't use, one sentence each.
pub fn notes(scene: &Scene, clouds: &[impl Borrow<Cloud>], needs_radii: bool) -> Vec<String> {
    let prefixed_notes = |(settings, cloud): (&CloudSettings, &Cloud)| {
        let path = settings.path.display().to_string();
        let mut request = request(scene, settings, needs_radii, scene.method.needs_field());
        request.forgo_shapes(gaussians::are_drawn(scene, settings, cloud));
        let notes = request.notes(cloud);
        let filter = gaussians::filter_note(scene, settings, cloud);
        let radius = gaussians::radius_note(scene, settings, cloud);
        let of_classes = classes::note(settings, cloud);
        let idle = [of_classes, coloring::note(settings, cloud), upright_note(scene, cloud), filter, radius];
        let idle = idle.into_iter().flatten();
        notes.into_iter().chain(idle).map(move |note| format!("{path}: {note}"))
    };
    scene.clouds.iter().zip(clouds.iter().map(Borrow::borrow)).flat_map(prefixed_notes).collect()
}

/// Says that the vertical was guessed, where the camera depends on it.
pub(super) fn upright_note(scene: &Scene, cloud: &Cloud) -> Option<String> {
    let reason = cloud.up_reason.filter(|_| scene.camera.eye.is_none() && scene.camera.up.is_none())?;
    let [axis, other] = match cloud.up {
        UpAxis::X => ["x", "z"],
        UpAxis::Y | UpAxis::NegativeY => ["y", "z"],
        UpAxis::Z => ["z", "y"],
    };
    Some(format!("the file does not say which axis is up; {axis} is assumed, {reason} (--up {other} changes that)"))
}

/// Returns the shadow texture that is stored with the scene's cloud, if it matches the scene; else the reason as one
/// sentence, if the cloud has one. `seed` is that of the frame.
pub fn shadow_texture(
    scene: &Scene,
    clouds: &[impl Borrow<Cloud>],
    seed: u64,
) -> (Option<ShadowTexture>, Option<String>) {
    let stored = |cloud: &Cloud| cloud.prepared.as_ref().and_then(|prepared| prepared.shadows.clone());
    let with_settings = scene.clouds.iter().zip(clouds.iter().map(Borrow::borrow));
    let found = with_settings.filter_map(|(settings, cloud)| Some((settings, cloud, stored(cloud)?))).next();
    let (Some(shadows), Some((settings, cloud, texture))) = (scene.shadows, found) else { return (None, None) };
    let bounds = cloud.bounds().unwrap_or(Bounds { min: DVec3::ZERO, max: DVec3::ZERO });
    let wanted = shadows.casting(scene.shading.light, seed, (&bounds, cloud.len() as u64));
    let other = wanted.map(|wanted| texture.casting.differences(&wanted)).unwrap_or_default();
    let why = if clouds.len() > 1 {
        "stored for this cloud by itself".to_owned()
    } else if settings.scale != 1.0 || settings.translate != DVec3::ZERO {
        "stored for the cloud where it is in its file".to_owned()
    } else if scene.hides_points() || settings.strays.outliers == Outliers::Drop {
        "stored for all points of the cloud".to_owned()
    } else if wanted.is_none() || !other.is_empty() {
        format!("stored for other settings ({})", other.join(", "))
    } else {
        return (Some(texture), None);
    };
    (None, Some(format!("{}: shadows {why}; cast again", settings.path.display())))
}

/// Returns the data that a scene needs of a cloud's points.
pub(super) fn request(scene: &Scene, settings: &CloudSettings, radii: bool, fields: bool) -> prepare::Request {
    prepare::Request {
        neighbors: settings.neighbors,
        radius_cap: settings.strays.radius_cap,
        field: settings.field.as_ref().map(|field| field.in_file_units(settings.scale, settings.translate)),
        radii: radii && settings.radius.is_none(),
        uncapped: settings.surface_opacity.is_some() && scene.method.is_made_of_discs(),
        soft_outliers: settings.strays.rule(Outliers::Soft).filter(|_| fields),
        dropped_outliers: settings.strays.rule(Outliers::Drop),
        fields,
        normals: false,
        shading: scene.shading_normals(),
    }
}

/// Returns all points of the scene. `clouds` are those of `scene.clouds`, in that order.
///
/// Positions become scale·p + translate in float64; non-finite results are dropped, and so are outliers if they are to
/// be. Colors stay linear, whatever the scene's color space; clouds without `color` are colored by `color_by`. Points
/// that a class hides or a clip cuts off are set apart ([`Points::unseen`]) once everything is computed. A radius is
/// that of the class, else of the cloud's settings, else the file's times `scale`, else, only if `needs_radii`, that of
/// Eq. 20 over its own cloud times `scale`, else 0; `radius_factor` multiplies all of them. F is included if the method
/// needs it. Neighbors and fields are computed in the cloud's own coordinates, before `scale` and `translate` round
/// them, because a prepared file stores those values.
///
/// # Errors
/// No point is left, a cloud lacks the property of its field or its colors, or the polygons of a clip can't be read.
pub fn assemble(scene: &Scene, clouds: Vec<Cloud>, needs_radii: bool, progress: &Progress) -> Result<Points, Error> {
    merged(scene, clouds, needs_radii, progress, None)
}

fn merged(
    scene: &Scene,
    clouds: Vec<Cloud>,
    needs_radii: bool,
    progress: &Progress,
    mut legend: Option<&mut Legend>,
) -> Result<Points, Error> {
    let (mut points, clips) = (Points::default(), Clips::load(&scene.clips)?);
    let classes = nothing_left::classes(scene, &clouds);
    let is_alone = clouds.len() == 1;
    for (index, cloud) in clouds.into_iter().enumerate() {
        let from = CloudScope::Whole { needs_radii, progress, legend: legend.as_deref_mut() };
        let more = transformed(scene, &clips, index, cloud, from)?;
        // The order of its file counts on.
        if is_alone { points = more } else { points.append(more) }
    }
    if points.is_empty() {
        return Err(no_points(scene, &points, &classes));
    }
    progress.begin(Phase::Order);
    Ok(prepare::order::canonical(points))
}

/// Returns all points of the scene in the order of its method: like [`assemble`], or partitioned into ensembles by
/// `seed`, without radii and F. The latter omits clouds without points. `progress` shows the progress.
///
/// # Errors
/// Returns the errors of [`assemble`].
pub fn arrange(scene: &Scene, clouds: Vec<Cloud>, seed: u64, progress: &Progress) -> Result<Arranged, Error> {
    arrange_explained(scene, clouds, seed, progress, None)
}

/// Arranges clouds like [`arrange`], and tells what the colors of the points mean, which takes some more time.
///
/// # Errors
/// Returns the errors of [`assemble`].
pub fn arrange_with_legend(
    scene: &Scene,
    clouds: Vec<Cloud>,
    seed: u64,
    progress: &Progress,
) -> Result<(Arranged, Legend), Error> {
    let systems = clouds.iter().map(|cloud| cloud.crs.clone()).collect();
    let mut legend = Legend::new(Units::of(scene, systems));
    let arranged = arrange_explained(scene, clouds, seed, progress, Some(&mut legend))?;
    Ok((arranged, legend))
}

fn arrange_explained(
    scene: &Scene,
    clouds: Vec<Cloud>,
    seed: u64,
    progress: &Progress,
    mut legend: Option<&mut Legend>,
) -> Result<Arranged, Error> {
    if !scene.method.is_dealt() {
        return merged(scene, clouds, scene.method.needs_radii(), progress, legend)
            .map(|points| Arranged::Canonical(Arc::new(points)));
    }
    let classes = nothing_left::classes(scene, &clouds);
    let (each, clips) = (clouds.into_iter().enumerate(), Clips::load(&scene.clips)?);
    let placed = each.map(|(index, cloud)| {
        let from = CloudScope::Whole { needs_radii: false, progress, legend: legend.as_deref_mut() };
        transformed(scene, &clips, index, cloud, from)
    });
    let placed: Vec<Points> = placed.collect::<Result<_, _>>()?;
    progress.begin(Phase::Order);
    progress.reset();
    progress.set_message("dealing points to ensembles");
    let dealt = ensembles::deal(placed, seed, progress);
    if dealt.points.is_empty() { Err(no_points(scene, &dealt.points, &classes)) } else { Ok(Arranged::Dealt(dealt)) }
}

/// Available part of a cloud.
pub(super) enum CloudScope<'a> {
    /// All of it. What its colors mean goes to the legend.
    Whole { needs_radii: bool, progress: &'a Progress, legend: Option<&'a mut Legend> },
    /// A part, with what is known of the whole, and the places of its points among all of the scene.
    Part(&'a Known, Vec<u32>),
}

/// Facts about a cloud that are needed before some of its points can be made by themselves.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Known {
    /// Scales that follow from the points that stand for all.
    pub scales: Scales,
    /// The vertical, which follows from them, too.
    pub up: UpAxis,
    /// Data that is wanted of each point; all of it is stored, or follows from its columns.
    pub request: prepare::Request,
    /// The box of the cloud, in the file's units.
    pub bounds: Bounds,
    /// The range of what F is made of.
    pub range: [f64; 2],
    /// `true` if any point has a normal.
    pub has_normals: bool,
}

/// Returns the cloud at a place in the scene, or a part of it, with its settings applied. F is there if the method
/// needs it.
pub(super) fn transformed(
    scene: &Scene,
    clips: &Clips,
    index: usize,
    mut cloud: Cloud,
    from: CloudScope<'_>,
) -> Result<Points, Error> {
    let (settings, needs_field) = (&scene.clouds[index], scene.method.needs_field());
    let field_error = |source| Error::Field { path: settings.path.clone(), source };
    let mut places = Vec::new();
    let (coloring, request, found, has_normals) = match &from {
        CloudScope::Part(known, _) => {
            cloud.up = known.up;
            let found = prepare::of_part(&cloud, &known.request, known.bounds, known.range).map_err(field_error)?;
            let coloring = Coloring::of_part(scene, index, &cloud, &known.scales);
            (coloring, known.request.clone(), found, Some(known.has_normals))
        }
        CloudScope::Whole { needs_radii, progress, .. } => {
            progress.begin(Phase::Order);
            places = along_curve::arrange(scene, &mut cloud);
            progress.begin(Phase::Prepare);
            let mut coloring = Coloring::of(scene, index, &cloud);
            let mut request = request(scene, settings, *needs_radii, needs_field || coloring.needs_field());
            request.forgo_shapes(gaussians::are_drawn(scene, settings, &cloud));
            if request.needs_neighbors() {
                progress.reset();
                progress.set_message("finding neighbors");
            }
            let found = prepare::find(&cloud, &request, progress).map_err(field_error)?;
            coloring.count_drawn(clips, found.dropped.as_deref())?;
            (coloring, request, found, None)
        }
    };
    let (count, is_whole) = (cloud.len(), matches!(from, CloudScope::Whole { .. }));
    let colors = coloring.colors(found.fields.as_deref())?;
    let file_order = match from {
        CloudScope::Whole { legend, .. } => {
            if let Some(legend) = legend {
                legend.add(&coloring, clips, found.fields.as_deref(), found.dropped.as_deref())?;
            }
            places
        }
        CloudScope::Part(_, file_order) => file_order,
    };
    let own = matches!(colors, Colors::Own);
    let mut colors = colors.into_list(cloud.colors.take(), count);
    let rules = Rules::of(settings, &cloud)?;
    rules.paint(&mut colors);
    let visible = rules.visible_points(count);
    // Estimated ones that are stored don't count where none were asked for: the camera would be another one.
    let gaussians = cloud.gaussians.as_ref().filter(|_| gaussians::are_drawn(scene, settings, &cloud));
    let gaussians = gaussians.map(|all| {
        let paint = gaussians::Paint { colors: &colors, own };
        gaussians::placed(settings, all, paint, |i| rules.color(i).is_some())
    });
    let mut radii: Vec<f32> = match found.radii.as_deref().or(cloud.own_radii()) {
        Some(radii) => parallel::map_each(radii, |own| radius(settings, Some(*own))),
        None => vec![radius(settings, None); count],
    };
    if rules.give_radii() {
        parallel::for_each_mut(&mut radii, |i, radius| *radius = class_radius(settings, &rules, i).unwrap_or(*radius));
    }
    let radii = gaussians.as_ref().map_or(radii, gaussians::radii);
    let base = Opacity { settings, estimated: found.uncapped.as_deref(), neighbors: request.neighbors_of(&cloud) };
    let one = |i: usize| opacity(base, &rules, &cloud, i, radii[i]);
    let opacities = parallel::map(count, one);
    parallel::for_each_mut(&mut cloud.positions, |_, position| *position = settings.placed(*position));
    let (seen, sensor) = (seen(visible, clips, &cloud.positions), sensor(settings, &cloud));
    let mut points = Points {
        positions: cloud.positions,
        colors,
        opacities,
        radii,
        normals: match has_normals {
            Some(has_normals) => cloud.normals.filter(|_| has_normals),
            None => shown(found.shading.or(cloud.normals)),
        },
        fields: found.fields.filter(|_| needs_field).unwrap_or_default(),
        file_order,
        gaussians,
        sensor,
        ..Points::default()
    };
    let is_cut = leave_out(&mut points, seen.as_deref(), found.dropped.as_deref()).is_some();
    if is_cut && is_whole && !points.file_order.is_empty() {
        points.file_order = along_curve::without_gaps(&points.file_order, count);
    }
    Ok(points)
}

/// Returns the sensor of a cloud in the scene.
pub(super) fn sensor(settings: &CloudSettings, cloud: &Cloud) -> Option<Sensor> {
    cloud.sensor.map(|sensor| Sensor { position: settings.placed(sensor.position), ..sensor })
}

/// Normals, unless no point has one.
pub(super) fn shown(normals: Option<Vec<Vec3>>) -> Option<Vec<Vec3>> {
    normals.filter(|normals| normals.iter().any(|normal| *normal != Vec3::ZERO))
}

/// Returns the opacity of a point of this radius: that of its class, else the cloud's, times its alpha if it has one.
pub(super) fn opacity(base: Opacity<'_>, rules: &Rules<'_>, cloud: &Cloud, i: usize, radius: f32) -> f32 {
    let opacity = rules.opacity(i).unwrap_or_else(|| base.of(i, radius));
    cloud.alphas.as_ref().map_or(opacity, |alphas| alphas[i] * opacity)
}

/// Returns the radius of a point, with or without a radius of its own, in the cloud's units.
pub(super) fn radius(settings: &CloudSettings, own: Option<f32>) -> f32 {
    let factor = f64::from(settings.radius_factor);
    match (settings.radius, own) {
        (Some(radius), _) => given_radius(settings, radius),
        (None, Some(own)) => scaled(own, settings.scale * factor),
        (None, None) => 0.0,
    }
}

/// Returns the radius that a point has because of its class; `None` if no entry gives one.
pub(super) fn class_radius(settings: &CloudSettings, rules: &Rules<'_>, i: usize) -> Option<f32> {
    rules.radius(i).map(|radius| given_radius(settings, radius))
}

/// A radius that the scene gives, in world units.
pub(super) fn given_radius(settings: &CloudSettings, radius: f32) -> f32 {
    scaled(radius, f64::from(settings.radius_factor))
}

/// A radius times the cloud's scale; one beyond float32 is as large as float32 can say.
fn scaled(radius: f32, scale: f64) -> f32 {
    ((f64::from(radius) * scale) as f32).min(f32::MAX)
}
