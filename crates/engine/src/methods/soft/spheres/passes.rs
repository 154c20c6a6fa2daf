//! The passes.

use crate::methods::abuffer::{LongList, LongWork, Partial, ResolvingGroup, RunSums, SampledGroup, SortedGroup};
use crate::methods::prelude::*;

gpu_struct! {
    /// Push constants of the kernels that blend.
    pub struct SoftPush {
        class_index: u32, // A class of list lengths, and the band's first fragment among the window's.
        first_fragment: u32,
        max_color: f32, // Largest color component, background included.
        lambda: f32, // λ, and the opacity that stands for it in Eq. 22.
        peak: f32,
        equalize: u32, // 1: Eq. 15 weighs the density of shells.
        // For long lists: largest radius, and the first of the events of each list that a dispatch looks at.
        max_radius: f32,
        first: u32,
    }

    /// Push constants: pixels, and the depth that those of solid points are relative to.
    pub struct ComposePush {
        count: u32,
        origin: f32, // The depth that those of solid points are relative to.
    }
}

pass! {
    /// Counts two events in each pixel of a soft sphere's silhouette for each of its shells that the ray meets between
    /// near and the solid points. Spheres with shells count once more for the sphere. From an optical depth of 1000 on,
    /// this pass and all that follow place a sphere in two floats (`Footprint::ExactSphere`): a ray that the sphere
    /// lets through passes so near its rim that float32 would show.
    pub Count(RasterPush) = "soft/count" {
        chunk: Shared<ChunkGroup>,
        solids: Read<f32>,
        counts: ReadWrite<u32>,
        spheres: ReadWrite<u32>,
    }

    /// Stores the depth key and index of each event in a slot of its pixel's range.
    pub Store(RasterPush) = "soft/store" {
        chunk: Shared<ChunkGroup>,
        solids: Read<f32>,
        cursors: ReadWrite<u32>,
        fragments: ReadWrite<[u32; 2]>,
        colors: Read<[f32; 4]>,
        records: ReadWrite<[u32; 4]>,
    }

    /// Sorts the events of each list of a class and blends the segments between them: up to 16 in registers, more in an
    /// array of the invocation's own; where the device prefers shared work, up to 32 in registers and more in the
    /// memory of a workgroup. Its label ends with the longest length of the class.
    pub ResolveNetwork(SoftPush) = "soft/resolve" in "soft/resolve_network",
    /// Sorts the events of each list of a class of up to 256 in a local array, and blends the segments between them.
    pub ResolveMerge(SoftPush) = "soft/resolve" in "soft/resolve_merge",
    /// Blends the segments between the events of each list of a class of up to 256, which are sorted.
    pub ResolveSorted(SoftPush) = "soft/resolve" in "soft/resolve_sorted" {
        lists: Shared<ResolvingGroup>,
        records: Read<[u32; 4]>,
    }

    /// Sums what the events of each run of a sorted long list add to the running sums of color and density.
    pub SumRuns(SoftPush) = "soft/sum-runs" in "soft/sum_runs" {
        sorted: Shared<SortedGroup>,
        sums: ReadWrite<RunSums>,
        records: Read<[u32; 4]>,
    }

    /// Finds the running sums before each run of each long list.
    pub Carry = "soft/carry" {
        work: ReadWrite<LongWork>,
        lists: Read<LongList>,
        sums: ReadWrite<RunSums>,
    }

    /// Integrates the optical depth of each segment of a run from all spheres that may reach it (`soft-base`): one
    /// workgroup per run, four segments per invocation. A dispatch takes 49 152 events of each list.
    pub Segments(SoftPush) = "soft/segments" {
        sorted: Shared<SortedGroup>,
        segments: ReadWrite<f32>,
        records: Read<[u32; 4]>,
    }

    /// Composes the segments of each run.
    pub BlendRuns(SoftPush) = "soft/blend-runs" in "soft/blend_runs" {
        sorted: Shared<SortedGroup>,
        sums: Read<RunSums>,
        segments: Read<f32>,
        partials: ReadWrite<Partial>,
        records: Read<[u32; 4]>,
    }

    /// Writes the pieces of the ray between the events of each run of a sorted list of concentric shells, for a deep
    /// EXR.
    pub Samples(SoftPush) = "soft/samples" {
        sorted: Shared<SortedGroup>,
        sums: Read<RunSums>,
        samples: Shared<SampledGroup>,
        records: Read<[u32; 4]>,
    }

    /// Composes the soft points over the solid ones in each pixel.
    pub Compose(ComposePush) = "soft/compose" {
        solid_image: Read<[f32; 4]>,
        solid_depths: Read<f32>,
        into: Shared<PixelsGroup>,
    }
}
