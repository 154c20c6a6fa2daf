//! The passes of the A-buffer and what they share with their shaders.

use crate::passes::bin::{GatheringGroup, TilesPush};
use crate::passes::compose::ComposingGroup;
use crate::passes::project::View;
use crate::passes::raster::{ChunkGroup, RasterPush};
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
        most_opacity: f32,
        most_color: f32,
    }
}

gpu_struct! {
    /// Push constants: a number of elements.
    pub struct CountPush {
        count: u32,
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
    /// Fragments per pixel.
    pub Count(RasterPush) = "abuffer/count" {
        chunk: Shared<ChunkGroup>,
        counts: ReadWrite<u32>,
    }
}

pass! {
    /// Fragments per pixel, from ordered tiles.
    pub CountTiles(TilesPush) = "abuffer/count" in "abuffer/count_tiles" {
        tiles: Shared<GatheringGroup>,
        counts: ReadWrite<u32>,
    }
}

pass! {
    /// Fragments into their pixels' slots in the order of blending, from ordered tiles.
    pub StoreTiles(TilesPush) = "abuffer/store" in "abuffer/store_tiles" {
        tiles: Shared<GatheringGroup>,
        cursors: ReadWrite<u32>,
        ranks: ReadWrite<u32>,
    }
}

gpu_struct! {
    /// Push constants of `abuffer/resolve-ordered`; the shader says what the members are.
    pub struct OrderedPush {
        band_start: u32,
        band_end: u32,
        first_fragment: u32,
        segment: u32,
        nearest: u32,
        most_opacity: f32,
        most_color: f32,
    }
}

pass! {
    /// Lists that were stored in order.
    pub ResolveOrdered(OrderedPush) = "abuffer/resolve-ordered" in "abuffer/resolve_ordered" {
        view: Uniform<View>,
        offsets: Read<u32>,
        ranks: Read<u32>,
        records: Read<[u32; 2]>,
        footprints: Read<[u32; 4]>,
        colors: Read<[f32; 4]>,
        image: ReadWrite<[f32; 4]>,
        depths: ReadWrite<f32>,
    }
}

pass! {
    /// The longest list.
    pub Measure(CountPush) = "abuffer/measure" {
        counts: Read<u32>,
        lengths: ReadWrite<Lengths>,
    }
}

pass! {
    /// Fragments into their pixels' slots.
    pub Store(RasterPush) = "abuffer/store" {
        chunk: Shared<ChunkGroup>,
        cursors: ReadWrite<u32>,
        fragments: ReadWrite<[u32; 2]>,
    }
}

pass! {
    /// Pixels per class.
    pub Classify(BandPush) = "abuffer/classify" {
        offsets: Read<u32>,
        classes: ReadWrite<u32>,
    }
}

pass! {
    /// Classes to workgroups and places.
    pub Groups = "abuffer/groups" {
        classes: ReadWrite<u32>,
    }
}

pass! {
    /// Pixels in order of their classes.
    pub Order(BandPush) = "abuffer/order" {
        offsets: Read<u32>,
        classes: ReadWrite<u32>,
        pixels: ReadWrite<u32>,
    }
}

group! {
    /// What the kernels that sort and blend the lists of a class bind.
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
    /// Sorts and blends the lists of a class in registers.
    pub ResolveNetwork(ResolvePush) = "abuffer/resolve" in "abuffer/resolve_network" {
        lists: Shared<ResolvingGroup>,
    }
}

pass! {
    /// Sorts and blends the lists of a class in a local array.
    pub ResolveMerge(ResolvePush) = "abuffer/resolve" in "abuffer/resolve_merge" {
        lists: Shared<ResolvingGroup>,
    }
}

pass! {
    /// Lists the runs of long lists.
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
    /// Counts to indirect arguments.
    pub RunGroups = "abuffer/run-groups" in "abuffer/run_groups" {
        work: ReadWrite<LongWork>,
    }
}

pass! {
    /// Sorts each run.
    pub SortRuns = "abuffer/sort-runs" in "abuffer/sort_runs" {
        work: ReadWrite<LongWork>,
        runs: Read<ListRun>,
        fragments: ReadWrite<[u32; 2]>,
    }
}

pass! {
    /// Merges pairs of runs.
    pub Merge(MergePush) = "abuffer/merge" {
        work: ReadWrite<LongWork>,
        runs: Read<ListRun>,
        unmerged: Read<[u32; 2]>,
        merged: ReadWrite<[u32; 2]>,
    }
}

pass! {
    /// Merges pairs of runs in place.
    pub MergeInPlace(InPlacePush) = "abuffer/merge-in-place" in "abuffer/merge_in_place" {
        work: ReadWrite<LongWork>,
        runs: Read<ListRun>,
        lists: Read<LongList>,
        fragments: ReadWrite<[u32; 2]>,
    }
}

pass! {
    /// Blends each run.
    pub BlendRuns = "abuffer/blend-runs" in "abuffer/blend_runs" {
        composing: Shared<ComposingGroup>,
        work: ReadWrite<LongWork>,
        runs: Read<ListRun>,
        fragments: Read<[u32; 2]>,
        partials: ReadWrite<Partial>,
    }
}

pass! {
    /// Composes the runs of each long list.
    pub Combine = "abuffer/combine" {
        work: ReadWrite<LongWork>,
        lists: Read<LongList>,
        partials: Read<Partial>,
        image: ReadWrite<[f32; 4]>,
        depths: ReadWrite<f32>,
    }
}
