//! The passes of the A-buffer, and the structs that they share with their shaders.

use crate::passes::bin::{TiledGroup, TilesPush};
use crate::passes::compose::ComposingGroup;
use crate::passes::raster::{ChunkGroup, CountPush, RasterPush};
use crate::{gpu_struct, group, pass};

gpu_struct! {
    /// Push constants: a band of pixels.
    pub struct BandPush {
        band_start: u32,
        band_end: u32,
    }
}

gpu_struct! {
    /// Push constants: a class, and the band's first fragment.
    pub struct ClassPush {
        class_index: u32,
        first_fragment: u32,
    }
}

gpu_struct! {
    /// Push constants of a kernel: its class, the band's first fragment, and bounds of what may come behind.
    pub struct ResolvePush {
        class_index: u32,
        first_fragment: u32,
        max_opacity: f32,
        max_color: f32,
    }
}

gpu_struct! {
    /// Push constants: length of the runs to merge.
    pub struct MergePush {
        width: u32,
    }
}

gpu_struct! {
    /// Push constants: logarithms of the runs' length and of the first step's distance, and how many steps.
    pub struct InPlacePush {
        width_log: u32,
        distance_log: u32,
        steps: u32,
    }
}

gpu_struct! {
    /// Longest list, and fragments in lists over [`super::LOCAL_LENGTH`].
    pub struct Lengths {
        longest: u32,
        in_long_lists: u32,
    }
}

gpu_struct! {
    /// A run of a long list.
    pub struct ListRun {
        start: u32,
        length: u32,
        run: u32,
        pixel: u32,
    }
}

gpu_struct! {
    /// A long list.
    pub struct LongList {
        pixel: u32,
        first_run: u32,
        runs: u32,
    }
}

gpu_struct! {
    /// Indirect arguments and counts of runs and lists.
    pub struct LongWork {
        run_groups: [u32; 3],
        run_count: u32,
        list_groups: [u32; 3],
        list_count: u32,
        whole_groups: [u32; 3],
        unused: u32,
    }
}

gpu_struct! {
    /// A composed run.
    pub struct Partial {
        rgba: [f32; 4],
        key: [u32; 4],
    }
}

pass! {
    /// Counts the fragments of each pixel by one atomic increment for each covered pixel of each splat.
    pub Count(RasterPush) = "abuffer/count" {
        chunk: Shared<ChunkGroup>,
        counts: ReadWrite<u32>,
    }
}

pass! {
    /// Counts the fragments of each pixel from ordered lists: one subgroup per tile, with its splats counted in
    /// registers.
    pub CountTiles(TilesPush) = "abuffer/count" in "abuffer/count_tiles" {
        tiles: Shared<TiledGroup>,
        counts: ReadWrite<u32>,
    }
}

pass! {
    /// Stores the indices of a tile's splats in the ranges of its pixels, in the order of blending, by one subgroup per
    /// tile.
    pub StoreTiles(TilesPush) = "abuffer/store" in "abuffer/store_tiles" {
        tiles: Shared<TiledGroup>,
        cursors: ReadWrite<u32>,
        indices: ReadWrite<u32>,
    }
}

gpu_struct! {
    /// Push constants of `abuffer/resolve-ordered`; the shader explains the members.
    pub struct OrderedPush {
        band_start: u32,
        band_end: u32,
        first_fragment: u32,
        segment: u32,
        max_opacity: f32,
        max_color: f32,
    }
}

pass! {
    /// Blends each pixel's ordered list run by run of 256 until nothing behind can be seen. A dispatch takes 32 768
    /// indices.
    pub ResolveOrdered(OrderedPush) = "abuffer/resolve-ordered" in "abuffer/resolve_ordered" {
        splats: Shared<ComposingGroup>,
        offsets: Read<u32>,
        indices: Read<u32>,
        image: ReadWrite<[f32; 4]>,
        depths: ReadWrite<f32>,
    }
}

pass! {
    /// Finds the longest list, and the number of fragments in lists over 256, from 64 pixels per invocation.
    pub Measure(CountPush) = "abuffer/measure" {
        counts: Read<u32>,
        lengths: ReadWrite<Lengths>,
    }
}

pass! {
    /// Stores the depth key and splat index of each fragment in a slot of its pixel's range.
    pub Store(RasterPush) = "abuffer/store" {
        chunk: Shared<ChunkGroup>,
        cursors: ReadWrite<u32>,
        fragments: ReadWrite<[u32; 2]>,
    }
}

pass! {
    /// Counts the pixels of each class of list length.
    pub Classify(BandPush) = "abuffer/classify" {
        offsets: Read<u32>,
        classes: ReadWrite<u32>,
    }
}

pass! {
    /// Turns the sizes of the classes into workgroups, and into places in the work list.
    pub Groups = "abuffer/groups" {
        classes: ReadWrite<u32>,
    }
}

pass! {
    /// Puts the pixels of each class into the work list.
    pub Order(BandPush) = "abuffer/order" {
        offsets: Read<u32>,
        classes: ReadWrite<u32>,
        pixels: ReadWrite<u32>,
    }
}

group! {
    /// Bindings of the kernels that sort and blend the lists of a class.
    pub Resolving as ResolvingGroup {
        composing: Shared<ComposingGroup>,
        offsets: Read<u32>,
        classes: Read<u32>,
        pixels: Read<u32>,
        fragments: Read<[u32; 2]>,
        image: ReadWrite<[f32; 4]>,
        depths: ReadWrite<f32>,
    }
}

pass! {
    /// Sorts each list of a class and blends it: up to 16 fragments in registers by Batcher's network, longer ones in
    /// an array of the invocation's own; where the device prefers shared work, up to 32 in registers and longer ones in
    /// the memory of a workgroup. Its label ends with the longest length of the class.
    pub ResolveNetwork(ResolvePush) = "abuffer/resolve" in "abuffer/resolve_network" {
        lists: Shared<ResolvingGroup>,
    }
}

pass! {
    /// Sorts each list of a class of up to 256 fragments by merge sort in a local array, with blocks of 16 sorted by a
    /// network, and blends it.
    pub ResolveMerge(ResolvePush) = "abuffer/resolve" in "abuffer/resolve_merge" {
        lists: Shared<ResolvingGroup>,
    }
}

pass! {
    /// Sorts each list of a class of up to 256 fragments where it lies, in the memory of a workgroup.
    pub SortLists(ClassPush) = "abuffer/resolve" in "abuffer/sort_lists" {
        offsets: Read<u32>,
        classes: Read<u32>,
        pixels: Read<u32>,
        fragments: ReadWrite<[u32; 2]>,
    }
}

pass! {
    /// Blends each list of a class of up to 256 fragments that is sorted.
    pub ResolveSorted(ResolvePush) = "abuffer/resolve" in "abuffer/resolve_sorted" {
        lists: Shared<ResolvingGroup>,
    }
}

pass! {
    /// Puts the runs of 256 of each longer list into a work list.
    pub Split(ClassPush) = "abuffer/split" {
        offsets: Read<u32>,
        classes: Read<u32>,
        pixels: Read<u32>,
        work: ReadWrite<LongWork>,
        runs: ReadWrite<ListRun>,
        lists: ReadWrite<LongList>,
    }
}

pass! {
    /// Turns the numbers of runs and lists into the arguments of indirect dispatches.
    pub RunGroups = "abuffer/run-groups" in "abuffer/run_groups" {
        work: ReadWrite<LongWork>,
    }
}

pass! {
    /// Sorts each run in an array of an invocation's own, or in the memory of a workgroup (`abuffer/sort_runs_group`),
    /// whichever the device prefers.
    pub SortRuns = "abuffer/sort-runs" in "abuffer/sort_runs" {
        work: ReadWrite<LongWork>,
        runs: Read<ListRun>,
        fragments: ReadWrite<[u32; 2]>,
    }
}

pass! {
    /// Sorts each run in the memory of a workgroup.
    pub SortRunsGroup = "abuffer/sort-runs" in "abuffer/sort_runs_group" {
        work: ReadWrite<LongWork>,
        runs: Read<ListRun>,
        fragments: ReadWrite<[u32; 2]>,
    }
}

pass! {
    /// Merges pairs of sorted runs: 256 fragments of the result per invocation, which finds its part of both runs by
    /// bisection (merge path). It repeats with doubled width.
    pub Merge(MergePush) = "abuffer/merge" {
        work: ReadWrite<LongWork>,
        runs: Read<ListRun>,
        unmerged: Read<[u32; 2]>,
        merged: ReadWrite<[u32; 2]>,
    }
}

pass! {
    /// Merges the sorted runs of each long list in place by Batcher's odd-even merge: as many steps as the iterations
    /// of an invocation allow, repeated.
    pub MergeInPlace(InPlacePush) = "abuffer/merge-in-place" in "abuffer/merge_in_place" {
        work: ReadWrite<LongWork>,
        runs: Read<ListRun>,
        lists: Read<LongList>,
        fragments: ReadWrite<[u32; 2]>,
    }
}

pass! {
    /// Composes each run by itself.
    pub BlendRuns = "abuffer/blend-runs" in "abuffer/blend_runs" {
        composing: Shared<ComposingGroup>,
        work: ReadWrite<LongWork>,
        runs: Read<ListRun>,
        fragments: Read<[u32; 2]>,
        partials: ReadWrite<Partial>,
    }
}

pass! {
    /// Finds the depth at which each long list first lets through half of the light or less, for eye-dome lighting and
    /// where that depth is asked for, from its composed runs and the fragments of one.
    pub Median = "abuffer/median" {
        composing: Shared<ComposingGroup>,
        work: ReadWrite<LongWork>,
        lists: Read<LongList>,
        runs: Read<ListRun>,
        fragments: Read<[u32; 2]>,
        partials: Read<Partial>,
        depths: ReadWrite<f32>,
    }
}

pass! {
    /// Composes each long list of Gaussians that ends early once more, up to its end, from its composed runs and the
    /// fragments of one, where an early end is asked for.
    pub End = "abuffer/end" {
        composing: Shared<ComposingGroup>,
        work: ReadWrite<LongWork>,
        lists: Read<LongList>,
        runs: Read<ListRun>,
        fragments: Read<[u32; 2]>,
        partials: Read<Partial>,
        image: ReadWrite<[f32; 4]>,
        depths: ReadWrite<f32>,
    }
}

pass! {
    /// Composes the runs of each long list front to back.
    pub Combine = "abuffer/combine" {
        work: ReadWrite<LongWork>,
        lists: Read<LongList>,
        partials: Read<Partial>,
        image: ReadWrite<[f32; 4]>,
        depths: ReadWrite<f32>,
    }
}

pass! {
    /// Writes color times opacity and depth of each fragment of each run of a sorted list, for a deep EXR.
    pub Samples = "abuffer/samples" {
        composing: Shared<ComposingGroup>,
        work: ReadWrite<LongWork>,
        runs: Read<ListRun>,
        fragments: Read<[u32; 2]>,
        sample_colors: ReadWrite<[f32; 4]>,
        sample_depths: ReadWrite<[f32; 2]>,
    }
}

gpu_struct! {
    /// Running sums of a run of a long list.
    pub struct RunSums {
        high: [f32; 4],
        low: [f32; 4],
        rest: [f32; 4],
    }
}

gpu_struct! {
    /// Push constants: a band of pixels, and its first event.
    pub struct SplitPush {
        band_start: u32,
        band_end: u32,
        first_fragment: u32,
    }
}

pass! {
    /// Puts the runs of 256 of each list, and those of a shorter one, into a work list.
    pub SplitEvery(SplitPush) = "ellipsoids/split" {
        offsets: Read<u32>,
        work: ReadWrite<LongWork>,
        runs: ReadWrite<ListRun>,
        lists: ReadWrite<LongList>,
    }
}
