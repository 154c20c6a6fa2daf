//! The clouds of a scene: in memory, or in their files.

use std::path::Path;
use std::sync::Arc;

use bytesize::ByteSize;
use pellucid_core::cloud::Cloud;
use pellucid_core::progress::{Phase, Progress};
use pellucid_engine::Result;
use pellucid_io::store::{self, Summary};
use pellucid_io::{self as io, LasColumns};
use pellucid_scene::stored::{self, Stores, are_complete, have_levels, open_stores};
use pellucid_scene::tracked::DerivedColumns;
use pellucid_scene::{Input, MethodChoice, Scene, Systems};

use crate::messages::Messages;

/// Rule by which clouds stay in their files although memory has room for them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Residence {
    /// Clouds with levels of detail stay in their files where the scene leaves points out.
    #[default]
    Levels,
    /// None stays.
    Memory,
    /// Octrees stay, for a method that is given: each of several processes reads the nodes that its part of the picture
    /// shows.
    Octrees,
    /// All that are read in parts stay: points go to other processes part by part.
    Parts,
}

/// Limits on reading the clouds of a scene.
#[derive(Debug, Clone, Copy)]
pub struct Limits {
    /// Bytes of host memory for points; larger clouds stay in their files.
    pub memory: u64,
    /// Rule for clouds that fit.
    pub residence: Residence,
}

/// The clouds of a scene, in its order.
#[derive(Clone)]
pub enum Clouds {
    /// Clouds whose points are all in memory.
    Held(Vec<Arc<Cloud>>),
    /// Clouds that stay in their files.
    Stored(Stores),
}

impl Clouds {
    /// Returns the number of points.
    pub fn points(&self) -> u64 {
        match self {
            Self::Held(clouds) => clouds.iter().map(|cloud| cloud.len() as u64).sum(),
            Self::Stored(stores) => stores.iter().map(|store| store.summary().points).sum(),
        }
    }

    /// Returns the number of clouds.
    pub fn len(&self) -> usize {
        match self {
            Self::Held(clouds) => clouds.len(),
            Self::Stored(stores) => stores.len(),
        }
    }

    /// Returns `true` if there are no clouds.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

/// The clouds of a scene, and columns derived from them.
#[derive(Clone)]
pub struct Sources {
    pub(crate) clouds: Clouds,
    /// Derived columns of each cloud in memory, for points that follow an edited scene.
    pub(crate) derived: Vec<DerivedColumns>,
    /// Columns of each cloud's file that were read in addition to those of its format.
    read: Vec<LasColumns>,
    /// Bytes of memory for points.
    pub(crate) memory: u64,
    /// `true` if the clouds are those of files.
    is_in_files: bool,
}

impl Sources {
    /// Returns the sources of clouds that were read, from files or not. Clouds that stay there take at most `memory`
    /// bytes.
    pub fn new(clouds: Clouds, memory: u64, is_in_files: bool) -> Self {
        let count = clouds.len();
        let derived = match &clouds {
            Clouds::Held(_) => vec![DerivedColumns::default(); count],
            Clouds::Stored(_) => Vec::new(),
        };
        Self { clouds, derived, read: vec![LasColumns::default(); count], memory, is_in_files }
    }

    /// Reads the clouds of a scene, as far as `limits` allow.
    ///
    /// # Errors
    /// Returns an error if a file can't be read, or if a store lacks what the scene needs.
    pub fn open(
        input: &Input,
        scene: &Scene,
        limits: Limits,
        messages: &dyn Messages,
        progress: &Progress,
    ) -> Result<Self> {
        progress.begin(Phase::Read);
        if let Some(stores) = stores(input, scene, limits, messages, progress)? {
            return Ok(Self::new(Clouds::Stored(stores), limits.memory, true));
        }
        let clouds = input.load(scene, progress)?;
        for (settings, cloud) in scene.clouds.iter().zip(&clouds) {
            describe_cloud(&settings.path, cloud, messages);
        }
        Ok(Self::new(Clouds::Held(clouds), limits.memory, matches!(input, Input::Files)))
    }

    /// Reads files again that may have columns which the scene needs and which were not read before.
    ///
    /// # Errors
    /// Returns an error if a file can't be read any more.
    pub fn complete(&mut self, scene: &Scene, progress: &Progress) -> Result<()> {
        if !self.is_in_files {
            return Ok(());
        }
        let clouds = match &mut self.clouds {
            Clouds::Held(clouds) => clouds,
            Clouds::Stored(stores) => return complete_stores(stores, &mut self.read, scene),
        };
        for ((settings, cloud), read) in scene.clouds.iter().zip(clouds).zip(&mut self.read) {
            let all = settings.hints().las.and(*read);
            if all == *read || all.lacking(cloud) == LasColumns::default() {
                continue;
            }
            progress.reset();
            progress.set_message(format!("reading {}", settings.path.display()));
            match io::load_with(&settings.path, io::Hints { las: all, ..settings.hints() }, progress) {
                Ok(found) if found.len() == cloud.len() => Arc::make_mut(cloud).scalars = found.scalars,
                // A file that changed meanwhile is another cloud.
                Ok(_) | Err(io::Error::Missing { .. }) => {}
                Err(error) => return Err(error.into()),
            }
            *read = all;
        }
        Ok(())
    }

    /// Returns the clouds.
    pub fn clouds(&self) -> &Clouds {
        &self.clouds
    }

    /// Keeps only the first clouds.
    pub fn truncate(&mut self, count: usize) {
        match &mut self.clouds {
            Clouds::Held(clouds) => clouds.truncate(count),
            Clouds::Stored(stores) => stores.truncate(count),
        }
        self.derived.truncate(count);
        self.read.truncate(count);
    }

    /// Returns the coordinate reference systems of the clouds.
    pub fn systems(&self) -> Systems {
        match &self.clouds {
            Clouds::Held(clouds) => clouds.iter().map(|cloud| cloud.crs.clone()).collect(),
            Clouds::Stored(stores) => stored::systems(stores),
        }
    }

    /// Returns `true` if some points have other classes than 0 and 1, which LAS files give to points that nobody
    /// classified.
    pub fn are_classified(&self) -> bool {
        let Clouds::Held(clouds) = &self.clouds else { return false };
        clouds.iter().any(|cloud| cloud.classification.iter().flatten().any(|code| *code > 1))
    }
}

/// Opens stores again that may have columns which a scene needs and which were not read before.
fn complete_stores(stores: &mut Stores, read: &mut [LasColumns], scene: &Scene) -> Result<()> {
    for ((settings, store), read) in scene.clouds.iter().zip(stores).zip(read) {
        let all = settings.hints().las.and(*read);
        if all == *read || all.lacking(&store.summary().like) == LasColumns::default() {
            continue;
        }
        let only = Scene { clouds: vec![settings.clone()], ..scene.clone() };
        if let Some(again) = open_stores(&only, &Progress::hidden())?.pop() {
            *store = again;
        }
        *read = all;
    }
    Ok(())
}

/// Opens the clouds of a scene in their files, if memory is too small for all of them or if the rule keeps them there.
fn stores(
    input: &Input,
    scene: &Scene,
    Limits { memory, residence }: Limits,
    messages: &dyn Messages,
    progress: &Progress,
) -> Result<Option<Stores>> {
    let announced = input.needed_memory(scene)?;
    let needed = announced.unwrap_or(0);
    let fits = needed <= memory;
    let in_parts = match residence {
        Residence::Levels | Residence::Memory => false,
        // `auto` may choose otherwise among points in memory.
        Residence::Octrees => {
            matches!(scene.method, MethodChoice::Fixed(_)) && announced.is_some() && have_levels(scene)?
        }
        Residence::Parts => true,
    };
    let is_kept = || -> Result<bool> {
        match residence {
            _ if in_parts => Ok(announced.is_some() && are_in_parts(scene)?),
            Residence::Memory => Ok(false),
            _ => Ok(announced.is_some() && !scene.detail.is_whole() && have_levels(scene)?),
        }
    };
    if fits && (scene.method.is_dealt() || !is_kept()?) {
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
    stores.iter().for_each(|store| describe_store(store.summary(), messages));
    Ok(Some(stores))
}

/// Returns `true` if all clouds of a scene are read in parts.
fn are_in_parts(scene: &Scene) -> Result<bool> {
    for cloud in &scene.clouds {
        if store::announced(&cloud.path, &cloud.hints())?.is_none() {
            return Ok(false);
        }
    }
    Ok(true)
}

/// Reports the size of a cloud in its file, and anything odd about it.
pub fn describe_store(summary: &Summary, messages: &dyn Messages) {
    describe(&summary.path, summary.points, &summary.like, messages);
}

/// Reports the size of a cloud that was read, and anything odd about it.
pub fn describe_cloud(path: &Path, cloud: &Cloud, messages: &dyn Messages) {
    describe(path, cloud.len() as u64, cloud, messages);
}

fn describe(path: &Path, points: u64, cloud: &Cloud, messages: &dyn Messages) {
    let path = path.display();
    messages.detail(&format_args!("{path}: {points} points"));
    if cloud.non_finite > 0 {
        messages.warn(&format_args!("{path}: {} points without finite coordinates are left out", cloud.non_finite));
    }
    if cloud.withheld > 0 {
        messages.warn(&format_args!("{path}: withheld points are left out: {}", cloud.withheld));
    }
    cloud.warnings.iter().for_each(|warning| messages.warn(&format_args!("{path}: {warning}")));
}
