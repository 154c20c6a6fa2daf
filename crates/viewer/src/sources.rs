//! The clouds of a scene: in memory, or where they are stored.

use pellucid_engine::Result;
use pellucid_engine::cloud::Cloud;
use pellucid_engine::io::LasColumns;
use pellucid_engine::progress::{Phase, Progress};
use pellucid_engine::scene::stored::{Stores, open_stores};
use pellucid_engine::scene::{Document, Named, Scene};

use super::census::Census;

/// The clouds of a scene, in its order.
pub enum Clouds {
    /// Clouds with all of their points in memory.
    Held(Vec<Cloud>),
    /// Clouds that stay in their files: memory is too small.
    Stored(Stores),
}

impl Clouds {
    /// Statistics of each.
    pub fn census(&self) -> Vec<Census> {
        match self {
            Self::Held(clouds) => clouds.iter().map(Census::from_cloud).collect(),
            Self::Stored(stores) => stores.iter().map(Census::from_store).collect(),
        }
    }

    /// Number of points.
    pub fn points(&self) -> u64 {
        match self {
            Self::Held(clouds) => clouds.iter().map(|cloud| cloud.len() as u64).sum(),
            Self::Stored(stores) => stores.iter().map(|store| store.summary().points).sum(),
        }
    }
}

/// A scene and its clouds.
pub struct Opened {
    /// The inputs as they were named.
    pub name: String,
    /// The keys of the scene.
    pub document: Document,
    /// The clouds of the scene.
    pub clouds: Clouds,
    /// True if the clouds were generated, so that no file contains them.
    pub generated: bool,
}

impl Opened {
    /// The scene, with its points in memory if `memory` bytes have room for them.
    ///
    /// # Errors
    /// Files that can't be read.
    pub fn open(named: Named, memory: u64, progress: &Progress) -> Result<Self> {
        progress.begin(Phase::Read);
        if named.needed_memory()?.unwrap_or(0) <= memory {
            let pellucid_engine::scene::Opened { name, document, clouds, generated } = named.load(progress)?;
            return Ok(Self { name, document, clouds: Clouds::Held(clouds), generated });
        }
        let Named { name, document, .. } = named;
        let clouds = Clouds::Stored(open_stores(&document.scene()?, progress)?);
        Ok(Self { name, document, clouds, generated: false })
    }
}

/// Opens those stores again that may have columns which a scene needs and which were not asked for before.
///
/// # Errors
/// A store that can't be opened any more.
pub fn complete(stores: &mut Stores, asked: &mut [LasColumns], scene: &Scene) -> Result<()> {
    for ((settings, store), asked) in scene.clouds.iter().zip(stores).zip(asked) {
        let all = settings.hints().las.and(*asked);
        if all == *asked || all.lacking(&store.summary().like) == LasColumns::default() {
            continue;
        }
        let only = Scene { clouds: vec![settings.clone()], ..scene.clone() };
        if let Some(again) = open_stores(&only, &Progress::hidden())?.pop() {
            *store = again;
        }
        *asked = all;
    }
    Ok(())
}
