//! A scene that was opened: its keys, and its clouds in memory or in their files.

use pellucid_core::progress::Progress;
use pellucid_engine::Result;
use pellucid_scene::{Document, Named, Scene};
use pellucid_session::{Limits, Messages, Residence, Sources};

/// A scene and its clouds.
pub struct Opened {
    /// The inputs as they were named.
    pub name: String,
    /// The keys of the scene.
    pub document: Document,
    /// The clouds of the scene.
    pub sources: Sources,
    /// True if the clouds were generated, so that no file contains them.
    pub generated: bool,
}

impl Opened {
    /// Opens a scene whose keys are `scene`, with its points in memory if `memory` bytes have room for them.
    ///
    /// # Errors
    /// Returns an error if a file can't be read.
    pub fn open(
        named: Named,
        scene: &Scene,
        memory: u64,
        messages: &dyn Messages,
        progress: &Progress,
    ) -> Result<Self> {
        // The window leaves points out while it moves, and draws all at rest.
        let limits = Limits { memory, residence: Residence::Memory };
        let sources = Sources::open(&named.input, scene, limits, messages, progress)?;
        let generated = named.is_generated();
        let Named { name, document, .. } = named;
        Ok(Self { name, document, sources, generated })
    }
}
