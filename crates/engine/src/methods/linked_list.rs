//! `linked-list`: the image of `abuffer` through per-pixel linked lists (YHGT10).
//!
//! Count, scan and bands are those of `abuffer`, so that all memory is bounded before it is taken: a band has as many
//! nodes as fragments were counted in it. `linked-list/store` hangs each fragment before its pixel's list,
//! `linked-list/gather` writes the lists to where `abuffer/store` would have put them, and sorting and blending go on
//! from there: the order of fragments is total, so that the image has the same bytes. A fragment takes 20 bytes: node
//! and link, 12, and its place in the fragment buffer, 8; long lists are merged into the memory of the nodes.
//!
//! Measured on lavapipe: nodes of 16 bytes, read and written at once, are stored no faster and gathered 0 to 40%
//! faster, for four bytes more of the budget; a counter of nodes for every 64 pixels in place of one for all made the
//! store no faster.

use super::abuffer::{Needs, StoreFragments, Storing};
use crate::gpu;
use crate::methods::prelude::*;

/// Links that one invocation of `linked-list/gather` follows; longer lists are gathered by several runs.
const GATHER_STEP: u32 = 32_768;
/// The end of a list.
const NONE: u32 = u32::MAX;

gpu_struct! {
    /// Push constants: a band of pixels, its first fragment, and how many nodes of each list are gathered.
    pub struct GatherPush {
        band_start: u32,
        band_end: u32,
        first_fragment: u32, // The band's first fragment among the window's.
        done: u32, // Nodes of each list that earlier runs have written.
    }
}

group! {
    /// Bindings of a pass that puts nodes before the lists of pixels.
    pub Linking as LinkingGroup {
        /// The first node of each pixel of the window.
        heads: ReadWrite<u32>,
        /// Counter of nodes.
        node_count: ReadWrite<u32>,
        /// The nodes of the band.
        nodes: ReadWrite<[u32; 2]>,
        /// Links to the next node.
        links: ReadWrite<u32>,
    }
}

pass! {
    /// Takes a node from the counter for each covered pixel of each splat, and puts it before the pixel's list by an
    /// atomic exchange.
    pub Store(RasterPush) = "linked-list/store" in "linked_list/store" {
        chunk: Shared<ChunkGroup>,
        lists: Shared<LinkingGroup>,
    }

    /// Copies up to 32 768 nodes of each pixel's list into the pixel's range; repeats from where it stopped.
    pub Gather(GatherPush) = "linked-list/gather" in "linked_list/gather" {
        offsets: Read<u32>,
        heads: ReadWrite<u32>,
        nodes: Read<[u32; 2]>,
        links: Read<u32>,
        fragments: ReadWrite<[u32; 2]>,
    }
}

/// The variant of `linked-list/gather`; `counted` if heads are to say how long their lists were.
fn gather_variant(counted: bool) -> Variant {
    Variant::plain().with("STEP", GATHER_STEP).with("COUNTED", u32::from(counted))
}

/// Stores fragments through linked lists.
#[derive(Debug, Clone, Copy)]
pub struct LinkedLists;

impl StoreFragments for LinkedLists {
    fn needs(&self) -> Needs {
        Needs { links: true, ..Needs::default() }
    }

    fn record_store<'a>(&'a self, recorder: &mut Recorder<'a>, storing: Storing<'a>) -> Result<(), Error> {
        record(recorder, storing, |recorder, lists| {
            Ok(storing.raster.record(recorder, &storing.band, |chunk: Chunk<'a>| Store { chunk, lists })?)
        })
    }
}

/// Records a band's fragments to their pixels' ranges: `link` puts them into lists, whose nodes are then copied.
///
/// # Errors
/// Vulkan errors.
pub fn record<'a>(
    recorder: &mut Recorder<'a>,
    Storing { band, room, longest, .. }: Storing<'a>,
    link: impl FnOnce(&mut Recorder<'a>, Linking<'a>) -> Result<(), Error>,
) -> Result<(), Error> {
    let (offsets, heads) = (room.offsets.get().all(), room.counts.get().all());
    let (nodes, fragments) = (room.spare.get().all(), room.fragments.get().all());
    let (node_count, links) = (room.node_count.all(), room.links.get().all());
    let pixels = u64::from(band.pixels[1] - band.pixels[0]);
    let cleared = heads.skip(band.pixels[0].into()).first(pixels);
    recorder.fill_all("linked-list/clear", &[(cleared, NONE), (node_count, 0)])?;
    link(recorder, Linking { heads, node_count, nodes, links })?;
    for done in (0..longest).step_by(GATHER_STEP as usize) {
        let [band_start, band_end] = band.pixels;
        let push = GatherPush { band_start, band_end, first_fragment: band.first_fragment, done };
        let run = Run::new(Dispatch::Invocations(pixels)).variant(gather_variant(gpu::checks()));
        recorder.run(&Gather { offsets, heads, nodes, links, fragments }, push, &run)?;
    }
    let offset = |pixel: u32| offsets.skip(pixel.into()).first(1);
    let stored = Expected::Below { ends: offset(band.pixels[1]), counts: offset(band.pixels[0]) };
    recorder.agree("linked-list/store", "counter", node_count, stored)?;
    // Heads are lengths now.
    let of_band = |slice: Slice<'a, u32>| slice.skip(band.pixels[0].into()).first(pixels);
    let lengths = Expected::Below { ends: of_band(offsets.skip(1)), counts: of_band(offsets) };
    Ok(recorder.agree("linked-list/gather", "pixel", of_band(heads), lengths)?)
}

/// Returns the passes with their variants.
pub fn shaders() -> Vec<Shader> {
    vec![Shader::new::<Store>(raster::flat_variants()), Shader::new::<Gather>([false, true].map(gather_variant))]
}
