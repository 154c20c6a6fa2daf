//! Deep images: each pixel's list of fragments as samples with depths, in place of what they are blended to.
//!
//! `abuffer`, `linked-list`, `sorted` and `peel` draw the same fragments, so that their samples are those of the
//! A-buffer's lists: counted, stored and sorted by its passes, window by window and band by band, and read back with
//! their colors. Of ellipsoids and of the shells of `soft-concentric` a sample is a piece of the ray between two
//! events, along which everything is of constant density: what OpenEXR calls a volume sample, and splits as such
//! densities ask for.

mod engine;
mod lists;

pub(crate) use engine::DeepEngine;

use std::io;

use super::Frame;
use super::explain::{Absent, PassGroup};
use super::soft::{Interior, SpheresEngine};
use crate::output::deep::{Sample, State};
use crate::scene::{ColorSpace, Discs, Error, Kernel, LongLists, Method, Order, Peel, Soft};

/// Returns the passes of samples.
pub(crate) fn pass_group() -> PassGroup {
    PassGroup::new(
        &["abuffer/samples", "ellipsoids/samples", "soft/samples"],
        Absent::Always("only a deep EXR has samples"),
    )
}

/// Takes the next pixels of an image, row by row: how many samples each has, and all their samples.
pub type Sink<'a> = dyn FnMut(&[u32], &[Sample]) -> io::Result<()> + 'a;

/// Source of a deep image.
pub(crate) enum DeepSource {
    /// Discs and Gaussians, of each pixel at most so many; all of them with 0.
    Discs(Discs, u32),
    /// Spheres with shells of constant density.
    Shells(SpheresEngine),
}

impl DeepSource {
    /// Returns the source of a method; `None` if it has no lists of fragments, or none that are of constant density.
    pub fn of(method: &Method) -> Option<Self> {
        let merged = |discs| Discs { long_lists: LongLists::Merge, ..discs };
        match *method {
            Method::ABuffer(discs) | Method::LinkedList(discs) | Method::Sorted(discs) => {
                Some(Self::Discs(merged(discs), 0))
            }
            Method::Peel(Peel { discs, layers }) => Some(Self::Discs(merged(discs), layers)),
            Method::SoftConcentric(soft) => {
                let interior = Interior::Shells(soft.shells, soft.pixels_per_shell);
                Some(Self::Shells(SpheresEngine { soft: Soft { long_lists: LongLists::Merge, ..soft }, interior }))
            }
            _ => None,
        }
    }
}

/// Refuses frames whose image doesn't follow from samples; `gaussians`: the scene has some.
///
/// # Errors
/// Names the key or the option that stands in the way.
pub fn check(frame: &Frame, gaussians: bool, state: State) -> Result<(), Error> {
    let name = frame.method.name();
    let refused = |problem: String| Err(Error::Usage(problem));
    if DeepSource::of(&frame.method).is_none() {
        return refused(format!(
            "--deep: method.name = {name:?} has no samples per pixel; use abuffer, linked-list, sorted, peel or \
             soft-concentric"
        ));
    }
    if frame.color == ColorSpace::Encoded {
        return refused(
            "--deep: with image.color = \"encoded\" (which scenes of Gaussians alone have by default) colors are blended as they are \
             stored, and deep samples hold linear color, so that they would not flatten to this picture; --set image.color=linear blends \
             in linear light"
                .into(),
        );
    }
    if frame.shading.edl.edl {
        return refused("--deep: shading.edl darkens pixels, and not samples; --set shading.edl=false".into());
    }
    if gaussians && frame.method.order() == Order::Distance {
        return refused(
            "--deep: with method.order = \"distance\" Gaussians are not blended in the order of their depths; \"center\" and \"pixel\" do that"
                .into(),
        );
    }
    if state == State::Sorted && matches!(frame.method, Method::SoftConcentric(_)) {
        return refused(format!(
            "--deep=sorted: the shells of method.name = {name:?} don't mix as overlapping samples do; --deep=tidy splits them where others \
             begin or end"
        ));
    }
    Ok(())
}

/// Returns `true` if the samples of a frame have a length; `gaussians`: the scene has some.
pub fn has_volumes(method: &Method, gaussians: bool) -> bool {
    match DeepSource::of(method) {
        Some(DeepSource::Discs(discs, _)) => gaussians && discs.gaussians.kernel == Kernel::Ellipsoid,
        Some(DeepSource::Shells(_)) => true,
        None => false,
    }
}
