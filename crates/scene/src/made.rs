//! From the clouds of a scene, in memory or where they are stored, to its points, with what is worth saying on the way.

use std::fmt::Display;
use std::path::Path;

use bytesize::ByteSize;

use super::legend::Legend;
use super::stored::{Stored, are_complete, have_levels, open_stores};
use super::{Method, Named, Scene, ScreenSplats, assemble, coloring, layers};
use crate::prepare::Arranged;
use pellucid_core::cloud::shadow_texture::ShadowTexture;
use pellucid_core::cloud::{Cloud, UpAxis};
use pellucid_core::points::Points;
use pellucid_core::progress::Progress;
use pellucid_io::store::{self, Summary};

/// Takes messages for people, one sentence each.
pub trait Messages {
    /// Something does not come out as asked.
    fn warn(&self, warning: &dyn Display);
    /// Something that nobody asked for and many want to know.
    fn note(&self, note: &dyn Display);
    /// For those who want to know everything.
    fn detail(&self, _detail: &dyn Display) {}
}

/// The clouds of a scene, in its order.
#[derive(Clone)]
pub enum Source {
    /// All of them in memory.
    Held(Vec<Cloud>),
    /// All of them in their files.
    Stored(Stored),
}

/// The form in which points are wanted.
#[derive(Clone, Copy)]
pub struct Wanted<'a> {
    /// Of the frame.
    pub seed: u64,
    /// With the meaning of colors.
    pub legend: bool,
    /// With radii and in canonical order, even if the scene's method does without. Stored points are as the method wants them.
    pub radii: bool,
    /// The folder of the temporary file for stored points that are dealt to ensembles.
    pub folder: &'a Path,
}

/// The points of a scene, and what is known of them.
pub struct Made {
    /// The scene with what its clouds decide.
    pub scene: Scene,
    /// All points, in the order that the method wants.
    pub arranged: Arranged,
    /// Meaning of the colors, if it was wanted.
    pub legend: Option<Legend>,
    /// Coloring of clouds and the reason for it, a phrase for each way.
    pub colorings: Vec<String>,
    /// The vertical of the clouds.
    pub up: UpAxis,
    /// The shadows of the scene that were stored with its cloud, in the order of the file.
    pub shadow_texture: Option<ShadowTexture>,
    /// Location of the clouds, if they are not in memory.
    pub stored: Option<Stored>,
    /// `true` if some clouds are of Gaussians: their points, and the color space, follow from method and detail as
    /// well.
    pub follows_method: bool,
}

impl Made {
    /// Returns all points, or of stored ones a sample.
    pub fn points(&self) -> &Points {
        self.arranged.points()
    }
}

/// Returns the names of the clouds in [`Arranged::surfaces`], which omits clouds without points.
pub fn cloud_names(scene: &Scene, arranged: &Arranged) -> Vec<String> {
    let (clouds, count) = (&scene.clouds, arranged.surfaces().len());
    if clouds.len() == count {
        clouds.iter().map(|cloud| cloud.path.display().to_string()).collect()
    } else {
        (1..=count).map(|number| format!("cloud {number} of those with points")).collect()
    }
}

impl Source {
    /// Reads the clouds of a scene; they stay in their files if `memory` (bytes) is too small for all of them, or if they have levels
    /// of detail there with which the picture can do.
    ///
    /// # Errors
    /// A file can't be read, or a store lacks what the scene needs.
    pub fn open(
        named: &Named,
        scene: &Scene,
        memory: u64,
        messages: &impl Messages,
        progress: &Progress,
    ) -> Result<Self, crate::OpenError> {
        if let Some(stored) = stored(named, scene, (memory, false), messages, progress)? {
            return Ok(Self::Stored(stored));
        }
        Self::held(named, scene, messages, progress)
    }

    /// Like [`Self::open`], for points that go to other processes block by block: clouds also stay in their files wherever the picture is
    /// that of points in memory.
    ///
    /// # Errors
    /// Those of [`Self::open`].
    pub fn open_in_parts(
        named: &Named,
        scene: &Scene,
        memory: u64,
        messages: &impl Messages,
        progress: &Progress,
    ) -> Result<Self, crate::OpenError> {
        match stored(named, scene, (memory, true), messages, progress)? {
            Some(stored) => Ok(Self::Stored(stored)),
            None => Self::held(named, scene, messages, progress),
        }
    }

    fn held(
        named: &Named,
        scene: &Scene,
        messages: &impl Messages,
        progress: &Progress,
    ) -> Result<Self, crate::OpenError> {
        let clouds = named.clone().load(progress)?.clouds;
        for (settings, cloud) in scene.clouds.iter().zip(&clouds) {
            tell_of_cloud(&settings.path, cloud, messages);
        }
        Ok(Self::Held(clouds))
    }

    /// Makes points of the clouds.
    ///
    /// # Errors
    /// As [`super::assemble`], and those of the temporary file.
    pub fn made(
        self,
        scene: Scene,
        wanted: Wanted<'_>,
        messages: &impl Messages,
        progress: &Progress,
    ) -> Result<Made, crate::OpenError> {
        let made = match self {
            Self::Held(clouds) => of_clouds(scene, clouds, wanted, messages, progress)?,
            Self::Stored(stored) => of_stores(stored, wanted, messages, progress)?,
        };
        made.colorings.iter().for_each(|how| messages.detail(how));
        layers::note_of_layers(&made.scene, made.points()).iter().for_each(|note| messages.note(note));
        Ok(made)
    }
}

fn of_clouds(
    mut scene: Scene,
    clouds: Vec<Cloud>,
    wanted: Wanted<'_>,
    messages: &impl Messages,
    progress: &Progress,
) -> Result<Made, crate::OpenError> {
    let method = scene.method;
    if wanted.radii && matches!(method.fixed(), Some(Method::Points | Method::ImageSpace(_))) {
        // Like these two it wants the points in canonical order, and nothing else of them.
        scene.method = Method::Circles(ScreenSplats::default()).into();
    }
    assemble::notes(&scene, &clouds, scene.method.needs_radii()).iter().for_each(|note| messages.note(note));
    let (shadow_texture, note) = assemble::shadow_texture(&scene, &clouds, wanted.seed);
    note.iter().for_each(|note| messages.note(note));
    let up = assemble::up_axis(&clouds);
    let follows_method = clouds.iter().any(|cloud| cloud.gaussians.is_some());
    let mut colorings = colorings(&scene, &coloring::colorings(&scene, &clouds));
    colorings.extend(scene.settle(&clouds).then(blended_displays));
    let (arranged, legend) = if wanted.legend {
        let (arranged, legend) = assemble::arrange_with_legend(&scene, clouds, wanted.seed, progress)?;
        (arranged, Some(legend))
    } else {
        (assemble::arrange(&scene, clouds, wanted.seed, progress)?, None)
    };
    scene.method = method;
    Ok(Made { scene, arranged, legend, colorings, up, shadow_texture, stored: None, follows_method })
}

/// Points that stay where they are stored, or, if they are dealt to ensembles, in a temporary file.
fn of_stores(
    stored: Stored,
    wanted: Wanted<'_>,
    messages: &impl Messages,
    progress: &Progress,
) -> Result<Made, crate::OpenError> {
    stored.notes().iter().for_each(|note| messages.note(note));
    let arranged = if stored.scene().method.is_dealt() {
        let folder = wanted.folder.display();
        messages.detail(&format_args!("points are dealt to ensembles in a temporary file in {folder}"));
        stored.dealt(wanted.seed, wanted.folder, progress)?
    } else {
        stored.arranged()
    };
    let mut colorings = colorings(stored.scene(), &stored.colorings());
    colorings.extend(stored.blends_displays().then(blended_displays));
    let (scene, up, follows_method) = (stored.scene().clone(), stored.up(), stored.has_gaussians());
    let legend = wanted.legend.then(|| stored.legend().clone());
    Ok(Made { scene, arranged, legend, colorings, up, shadow_texture: None, stored: Some(stored), follows_method })
}

/// The scene with its clouds where they are stored, if memory is too small for all of them, or if they have levels of detail there
/// with which the picture can do; or, if they are wanted `in_parts`, if their files are read in parts.
fn stored(
    named: &Named,
    scene: &Scene,
    (memory, in_parts): (u64, bool),
    messages: &impl Messages,
    progress: &Progress,
) -> Result<Option<Stored>, crate::OpenError> {
    let announced = named.needed_memory()?;
    let needed = announced.unwrap_or(0);
    let fits = needed <= memory;
    let by_levels =
        || Ok::<_, crate::OpenError>(announced.is_some() && !scene.detail.is_whole() && have_levels(scene)?);
    let is_wanted = || if in_parts { Ok(announced.is_some() && are_in_parts(scene)?) } else { by_levels() };
    if fits && (scene.method.is_dealt() || !is_wanted()?) {
        return Ok(None);
    }
    if !fits {
        messages.detail(&format_args!(
            "all points would take {} of memory, but only {} are allowed; points are read as the picture needs them",
            ByteSize(needed),
            ByteSize(memory)
        ));
    }
    let stores = open_stores(scene, progress)?;
    if fits && !are_complete(scene, &stores)? {
        let note = match in_parts {
            false => {
                "the levels of the stores lack the radii or normals that the scene needs; points are left out at random \
                 instead (`pellucid prepare` stores both)"
            }
            true => {
                "the files lack the radii or normals that the scene needs; one rank reads all points to find them \
                 (`pellucid prepare` stores both)"
            }
        };
        messages.note(&note);
        return Ok(None);
    }
    stores.iter().for_each(|store| tell_of_store(store.summary(), messages));
    Ok(Some(Stored::new(scene, &stores, memory, progress)?))
}

/// Returns `true` if all clouds of a scene are read in parts.
fn are_in_parts(scene: &Scene) -> Result<bool, crate::OpenError> {
    for cloud in &scene.clouds {
        if store::announced(&cloud.path, &cloud.hints())?.is_none() {
            return Ok(false);
        }
    }
    Ok(true)
}

/// The size of a cloud that stays where it is stored, and what is odd about it.
pub fn tell_of_store(summary: &Summary, messages: &impl Messages) {
    messages.detail(&format_args!("{}: {} points", summary.path.display(), summary.points));
    warn_of_cloud(&summary.path, &summary.like, messages);
}

/// Tells what was read, and what was odd about it.
pub fn tell_of_cloud(path: &Path, cloud: &Cloud, messages: &impl Messages) {
    messages.detail(&format_args!("{}: {} points", path.display(), cloud.len()));
    warn_of_cloud(path, cloud, messages);
}

fn warn_of_cloud(path: &Path, cloud: &Cloud, messages: &impl Messages) {
    let path = path.display();
    if cloud.non_finite > 0 {
        messages.warn(&format_args!("{path}: {} points without finite coordinates are left out", cloud.non_finite));
    }
    cloud.warnings.iter().for_each(|warning| messages.warn(&format_args!("{path}: {warning}")));
}

/// Said of a scene of Gaussians alone.
fn blended_displays() -> String {
    "colors are blended as encoded values, because every cloud is of Gaussians".to_owned()
}

/// Returns how clouds are colored and why, a phrase for each way.
fn colorings(scene: &Scene, each: &[String]) -> Vec<String> {
    let mut ways: Vec<(&str, Vec<&Path>)> = Vec::new();
    for (settings, way) in scene.clouds.iter().zip(each) {
        match ways.iter_mut().find(|(known, _)| known == way) {
            Some((_, paths)) => paths.push(&settings.path),
            None => ways.push((way, vec![&settings.path])),
        }
    }
    let phrase = |(way, paths): &(&str, Vec<&Path>)| match paths[..] {
        [path] => format!("{} is colored by {way}", path.display()),
        _ => format!("{} clouds are colored by {way}", paths.len()),
    };
    ways.iter().map(phrase).collect()
}
