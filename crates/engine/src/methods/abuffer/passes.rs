//! The passes of the A-buffer, and the structs that they share with their shaders.

use crate::methods::prelude::*;
use crate::passes::bin::TilesPush;

gpu_struct! {
    /// Push constants: a band of pixels.
    pub struct BandPush {
        band_start: u32,
        band_end: u32,
    }

    /// Push constants: a class, and the band's first fragment.
    pub struct ClassPush {
        class_index: u32,
        first_fragment: u32,
    }

    /// Push constants of a kernel: its class, the band's first fragment, and bounds of what may come behind.
    pub struct ResolvePush {
        class_index: u32,
        first_fragment: u32,
        max_opacity: f32, // Largest opacity, and largest color component, background included.
        max_color: f32,
    }

    /// Push constants: length of the runs to merge.
    pub struct MergePush {
        width: u32,
    }

    /// Push constants: logarithms of the runs' length and of the first step's distance, and how many steps.
    pub struct InPlacePush {
        width_log: u32,
        distance_log: u32,
        steps: u32,
    }

    /// Longest list, and fragments in lists over [`super::LOCAL_LENGTH`].
    pub struct Lengths {
        longest: u32,
        in_long_lists: u32,
    }

    /// A run of a long list.
    pub struct ListRun {
        start: u32,
        length: u32,
        run: u32,
        pixel: u32,
    }

    /// A long list.
    pub struct LongList {
        pixel: u32,
        first_run: u32,
        runs: u32,
    }

    /// Indirect arguments and counts of runs and lists.
    pub struct LongWork {
        run_groups: [u32; 3],
        run_count: u32,
        list_groups: [u32; 3],
        list_count: u32,
        whole_groups: [u32; 3],
        unused: u32,
    }

    /// A composed run.
    pub struct Partial {
        rgba: [f32; 4],
        key: [u32; 4],
    }

    /// Push constants of `abuffer/resolve-ordered`.
    pub struct OrderedPush {
        band_start: u32,
        band_end: u32,
        first_fragment: u32,
        segment: u32, // Which part of each list: its splats from segment * TAKEN on.
        max_opacity: f32, // Largest opacity, and largest color component, background included.
        max_color: f32,
    }

    /// Running sums of a run of a long list.
    pub struct RunSums {
        high: [f32; 4],
        low: [f32; 4],
        rest: [f32; 4],
    }

    /// Push constants: a band of pixels, and its first event.
    pub struct SplitPush {
        band_start: u32,
        band_end: u32,
        first_fragment: u32,
    }
}

pass! {
    /// Counts the fragments of each pixel by one atomic increment for each covered pixel of each splat.
    pub Count(RasterPush) = "abuffer/count" {
        chunk: Shared<ChunkGroup>,
        counts: ReadWrite<u32>,
    }

    /// Counts the fragments of each pixel from ordered lists: one subgroup per tile, with its splats counted in
    /// registers.
    pub CountTiles(TilesPush) = "abuffer/count" in "abuffer/count_tiles" {
        tiles: Shared<TiledGroup>,
        counts: ReadWrite<u32>,
    }

    /// Stores the indices of a tile's splats in the ranges of its pixels, in the order of blending, by one subgroup per
    /// tile.
    pub StoreTiles(TilesPush) = "abuffer/store" in "abuffer/store_tiles" {
        tiles: Shared<TiledGroup>,
        cursors: ReadWrite<u32>,
        indices: ReadWrite<u32>,
    }

    /// Blends each pixel's ordered list run by run of 256 until nothing behind can be seen. A dispatch takes 32 768
    /// indices.
    pub ResolveOrdered(OrderedPush) = "abuffer/resolve-ordered" in "abuffer/resolve_ordered" {
        splats: Shared<ComposingGroup>,
        offsets: Read<u32>,
        indices: Read<u32>,
        into: Shared<PixelsGroup>,
    }

    /// Finds the longest list, and the number of fragments in lists over 256, from 64 pixels per invocation.
    pub Measure(CountPush) = "abuffer/measure" {
        counts: Read<u32>,
        lengths: ReadWrite<Lengths>,
    }

    /// Stores the depth key and splat index of each fragment in a slot of its pixel's range.
    pub Store(RasterPush) = "abuffer/store" {
        chunk: Shared<ChunkGroup>,
        cursors: ReadWrite<u32>,
        fragments: ReadWrite<[u32; 2]>,
    }

    /// Counts the pixels of each class of list length.
    pub Classify(BandPush) = "abuffer/classify" {
        offsets: Read<u32>,
        classes: ReadWrite<u32>,
    }

    /// Puts the pixels of each class into the work list, and turns the sizes of the classes into workgroups.
    pub OrderPixels(BandPush) = "abuffer/order" {
        offsets: Read<u32>,
        classes: ReadWrite<u32>,
        pixels: ReadWrite<u32>,
    }

    /// Sorts each list of a class and blends it: up to 16 fragments in registers by Batcher's network, longer ones in
    /// an array of the invocation's own; where the device prefers shared work, up to 32 in registers and longer ones in
    /// the memory of a workgroup. Its label ends with the longest length of the class.
    pub ResolveNetwork(ResolvePush) = "abuffer/resolve" in "abuffer/resolve_network",
    /// Sorts each list of a class of up to 256 fragments by merge sort in a local array, with blocks of 16 sorted by a
    /// network, and blends it.
    pub ResolveMerge(ResolvePush) = "abuffer/resolve" in "abuffer/resolve_merge" {
        lists: Shared<ResolvingGroup>,
    }

    /// Sorts each list of a class of up to 256 fragments where it lies, in the memory of a workgroup.
    pub SortLists(ClassPush) = "abuffer/resolve" in "abuffer/sort_lists" {
        offsets: Read<u32>,
        classes: Read<u32>,
        pixels: Read<u32>,
        fragments: ReadWrite<[u32; 2]>,
    }

    /// Blends each list of a class of up to 256 fragments that is sorted.
    pub ResolveSorted(ResolvePush) = "abuffer/resolve" in "abuffer/resolve_sorted" {
        lists: Shared<ResolvingGroup>,
    }

    /// Puts the runs of 256 of each longer list into a work list.
    pub Split(ClassPush) = "abuffer/split" {
        offsets: Read<u32>,
        classes: Read<u32>,
        pixels: Read<u32>,
        work: ReadWrite<LongWork>,
        runs: ReadWrite<ListRun>,
        lists: ReadWrite<LongList>,
    }

    /// Turns the numbers of runs and lists into the arguments of indirect dispatches.
    pub RunGroups = "abuffer/run-groups" in "abuffer/run_groups" {
        work: ReadWrite<LongWork>,
    }

    /// Sorts each run in an array of an invocation's own, or in the memory of a workgroup (`abuffer/sort_runs_group`),
    /// whichever the device prefers.
    pub SortRuns = "abuffer/sort-runs" in "abuffer/sort_runs",
    /// Sorts each run in the memory of a workgroup.
    pub SortRunsGroup = "abuffer/sort-runs" in "abuffer/sort_runs_group" {
        work: ReadWrite<LongWork>,
        runs: Read<ListRun>,
        fragments: ReadWrite<[u32; 2]>,
    }

    /// Merges pairs of sorted runs: 256 fragments of the result per invocation, or per workgroup in the memory that it
    /// shares (`abuffer/merge_group`), whichever the device prefers. Their part of both runs is found by bisection
    /// (merge path). It repeats with doubled width.
    pub Merge(MergePush) = "abuffer/merge" in "abuffer/merge",
    /// Merges pairs of sorted runs, 256 fragments of the result per workgroup.
    pub MergeGroup(MergePush) = "abuffer/merge" in "abuffer/merge_group" {
        work: ReadWrite<LongWork>,
        runs: Read<ListRun>,
        unmerged: Read<[u32; 2]>,
        merged: ReadWrite<[u32; 2]>,
    }

    /// Merges the sorted runs of each long list in place by Batcher's odd-even merge: as many steps as the iterations
    /// of an invocation allow, repeated.
    pub MergeInPlace(InPlacePush) = "abuffer/merge-in-place" in "abuffer/merge_in_place" {
        work: ReadWrite<LongWork>,
        runs: Read<ListRun>,
        lists: Read<LongList>,
        fragments: ReadWrite<[u32; 2]>,
    }

    /// Composes each run by itself.
    pub BlendRuns = "abuffer/blend-runs" in "abuffer/blend_runs" {
        sorted: Shared<SortedGroup>,
        partials: ReadWrite<Partial>,
    }

    /// Finds the depth at which each long list first lets through half of the light or less, for eye-dome lighting and
    /// where that depth is asked for, from its composed runs and the fragments of one.
    pub Median = "abuffer/median" {
        sorted: Shared<ListedGroup>,
        partials: Read<Partial>,
        depths: ReadWrite<f32>,
    }

    /// Composes each long list of Gaussians that ends early once more, up to its end, from its composed runs and the
    /// fragments of one, where an early end is asked for.
    pub End = "abuffer/end" {
        sorted: Shared<ListedGroup>,
        partials: Read<Partial>,
        into: Shared<PixelsGroup>,
    }

    /// Composes the runs of each long list front to back.
    pub Combine = "abuffer/combine" {
        work: ReadWrite<LongWork>,
        lists: Read<LongList>,
        partials: Read<Partial>,
        into: Shared<PixelsGroup>,
    }

    /// Writes color times opacity and depth of each fragment of each run of a sorted list, for a deep EXR.
    pub Samples = "abuffer/samples" {
        sorted: Shared<SortedGroup>,
        samples: Shared<SampledGroup>,
    }

    /// Puts the runs of 256 of each list, and those of a shorter one, into a work list.
    pub SplitEvery(SplitPush) = "ellipsoids/split" {
        offsets: Read<u32>,
        work: ReadWrite<LongWork>,
        runs: ReadWrite<ListRun>,
        lists: ReadWrite<LongList>,
    }
}

group! {
    /// Bindings of the passes over runs of sorted lists.
    pub Sorted as SortedGroup {
        composing: Shared<ComposingGroup>,
        /// Counts and indirect arguments.
        work: ReadWrite<LongWork>,
        /// The runs.
        runs: Read<ListRun>,
        /// The fragments of their lists.
        fragments: Read<[u32; 2]>,
    }

    /// Bindings of the passes over sorted lists whose runs are composed.
    pub Listed as ListedGroup {
        composing: Shared<ComposingGroup>,
        work: ReadWrite<LongWork>,
        lists: Read<LongList>,
        runs: Read<ListRun>,
        fragments: Read<[u32; 2]>,
    }

    /// Samples of a deep EXR: color times opacity, and the depths at which each begins and ends.
    pub Sampled as SampledGroup {
        sample_colors: ReadWrite<[f32; 4]>,
        sample_depths: ReadWrite<[f32; 2]>,
    }

    /// Bindings of the kernels that sort and blend the lists of a class.
    pub Resolving as ResolvingGroup {
        composing: Shared<ComposingGroup>,
        offsets: Read<u32>,
        classes: Read<u32>,
        pixels: Read<u32>,
        fragments: Read<[u32; 2]>,
        into: Shared<PixelsGroup>,
    }
}
