//! The passes.

use crate::methods::abuffer::{ListedGroup, Partial, RunSums, SampledGroup, SortedGroup};
use crate::methods::linked_list::LinkingGroup;
use crate::pass;
use crate::passes::raster::{ChunkGroup, RasterPush};

pass! {
    /// Counts the events of each pixel, and what they are of: an ellipsoid that its ray enters and leaves, or a
    /// surface.
    pub Count(RasterPush) = "ellipsoids/count" {
        chunk: Shared<ChunkGroup>,
        counts: ReadWrite<u32>,
        bodies: ReadWrite<u32>,
    }

    /// Stores the depth key and index of each event in a slot of its pixel's range.
    pub Store(RasterPush) = "ellipsoids/store" {
        chunk: Shared<ChunkGroup>,
        cursors: ReadWrite<u32>,
        fragments: ReadWrite<[u32; 2]>,
    }

    /// Takes a node for each event, and puts it before the pixel's list, for `linked-list`.
    pub Link(RasterPush) = "ellipsoids/link" {
        chunk: Shared<ChunkGroup>,
        lists: Shared<LinkingGroup>,
    }

    /// Sums what the events of each run of a sorted list of several add to color and density of what is open.
    pub SumRuns = "ellipsoids/sum-runs" in "ellipsoids/sum_runs" {
        sorted: Shared<SortedGroup>,
        sums: ReadWrite<RunSums>,
    }

    /// Finds the depth at which each list first lets through half of the light or less, for eye-dome lighting and
    /// `depth.median`, from its composed runs and the events of one.
    pub Median = "ellipsoids/median" {
        sorted: Shared<ListedGroup>,
        sums: Read<RunSums>,
        partials: Read<Partial>,
        depths: ReadWrite<f32>,
    }

    /// Composes the surfaces of each run, and the segments between events.
    pub BlendRuns = "ellipsoids/blend-runs" in "ellipsoids/blend_runs" {
        sorted: Shared<SortedGroup>,
        sums: Read<RunSums>,
        partials: ReadWrite<Partial>,
    }

    /// Writes the surfaces of each run of a sorted list and the pieces of the ray between events, for a deep EXR; or
    /// each ellipsoid as a whole, where no sample is to be split.
    pub Samples = "ellipsoids/samples" {
        sorted: Shared<SortedGroup>,
        sums: Read<RunSums>,
        samples: Shared<SampledGroup>,
    }
}
