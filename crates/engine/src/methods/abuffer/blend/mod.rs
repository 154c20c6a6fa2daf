//! Sorting and blending: each class of list lengths by its own kernel, long lists run by run.

mod classes;
mod in_place;
mod least_bytes;
mod samples;

pub(crate) use classes::Sorting;
pub use classes::{CLASSES, lower_bound};
pub use in_place::in_place_length;
pub use least_bytes::least_bytes;

use self::classes::{CLASS_PLACED, CLASS_START, CLASS_TOTAL, CLASS_WORDS, class_variant, sort_runs_variant};
use self::in_place::in_place_merges;
use super::passes::*;
use super::{LOCAL_LENGTH, ListsJob, Room, RunBuffers, Shown};
use crate::gpu::Error;
use crate::methods::prelude::*;
use crate::passes::compose::{STOP_EXACT, STOP_NEVER};

/// Splats that one run of `abuffer/resolve-ordered` takes of a list: one iteration each.
const ORDERED_TAKEN: u32 = 32_768;
/// Places of workgroups among the words of [`LongWork`]: with an invocation for each run, with one for each long list,
/// and one workgroup for each run; and place of the number of long lists.
const RUN_GROUPS: u64 = 0;
const LIST_GROUPS: u64 = 4;
const WHOLE_GROUPS: u64 = 8;
const LIST_COUNT: u64 = 7;
/// Pixels of one invocation that classifies.
const CLASSIFY_RUN: u64 = 64;

fields! {
    /// Buffers of sorting and blending, kept from frame to frame.
    pub struct Blender by device {
        classes: Buffer<u32> = device.buffer("classes", CLASS_WORDS * (CLASSES.len() as u64 + 1), Memory::Device)?,
        pixels: Scratch<u32> = Scratch::new("pixels by class", Memory::Device),
        runs: Scratch<ListRun> = Scratch::new("list runs", Memory::Device),
        lists: Scratch<LongList> = Scratch::new("long lists", Memory::Device),
        partials: Scratch<Partial> = Scratch::new("partial sums", Memory::Device),
        work: Buffer<LongWork> = device.buffer("long work", 1, Memory::Device)?,
        long: RunBuffers = RunBuffers::default(),
        /// `true` if workgroups share lists.
        shared: bool = device.info().prefers.shared_work,
    }
}

/// A band whose fragments are stored.
#[derive(Clone, Copy)]
pub struct Stored<'a> {
    /// Way to reach the splats.
    pub cut: Cut,
    /// Prefix sums of the window's list lengths.
    pub offsets: Slice<'a, u32>,
    /// The band's fragments.
    pub fragments: Slice<'a, [u32; 2]>,
    /// Room for the fragments once more, if long lists are merged.
    pub spare: Option<Slice<'a, [u32; 2]>>,
    /// Records of fragments; any buffer where there are none.
    pub records: Slice<'a, [u32; 4]>,
}

impl<'a> Stored<'a> {
    /// Returns the buffers of a band, with the spare one if `merged`.
    pub(super) fn of(room: &'a Room, cut: Cut, merged: bool) -> Self {
        Self {
            cut,
            offsets: room.offsets.get().all(),
            fragments: room.fragments.get().all(),
            spare: merged.then(|| room.spare.get().all()),
            records: room.records.get().all(),
        }
    }
}

/// The blending of a band.
#[derive(Clone, Copy)]
pub struct Blending<'a> {
    /// The window.
    pub job: ListsJob<'a>,
    /// The stored fragments.
    pub stored: Stored<'a>,
    /// The band.
    pub band: Band,
    /// Lengths of the window's lists.
    pub lengths: Lengths,
    /// Buffers of sorting and blending.
    pub blender: &'a Blender,
    /// The destination.
    pub target: &'a Target,
}

/// A band's lists, sorted, and their runs.
#[derive(Clone, Copy)]
pub struct Runs<'a> {
    /// Way in which the splats are cut into bindings.
    pub cut: Cut,
    /// The splats, the runs and their fragments.
    pub sorted: Sorted<'a>,
    /// The lists.
    pub lists: Slice<'a, LongList>,
    /// Records of fragments; any buffer where there are none.
    pub records: Slice<'a, [u32; 4]>,
    /// Buffer that the composed runs are written to.
    pub partials: Slice<'a, Partial>,
}

impl<'a> Runs<'a> {
    /// Returns what the passes over lists bind.
    pub fn listed(&self) -> Listed<'a> {
        let Sorted { composing, work, runs, fragments } = self.sorted;
        Listed { composing, work, lists: self.lists, runs, fragments }
    }

    /// Returns a dispatch with an invocation for each run.
    pub fn over_runs(&self, variant: Variant) -> Run<'a> {
        over_long(self.sorted.work, RUN_GROUPS).variant(variant)
    }

    /// Returns a dispatch with a workgroup for each run.
    pub fn over_whole_runs(&self, variant: Variant) -> Run<'a> {
        over_long(self.sorted.work, WHOLE_GROUPS).variant(variant)
    }

    /// Returns a dispatch with an invocation for each list.
    pub fn over_lists(&self, variant: Variant) -> Run<'a> {
        over_long(self.sorted.work, LIST_GROUPS).variant(variant)
    }
}

impl Blender {
    /// Reserves room for a window of `pixels`, with at most `long` fragments in a band's long lists.
    pub fn reserve(&mut self, device: &Device, pixels: u64, long: u64) -> Result<(), Error> {
        self.pixels.reserve(device, pixels)?;
        if long > 0 {
            let local = u64::from(LOCAL_LENGTH);
            // A long list has more than `local` fragments, so it fills more than half of its runs.
            let runs = (2 * long).div_ceil(local);
            self.runs.reserve(device, runs)?;
            self.lists.reserve(device, long.div_ceil(local))?;
            self.partials.reserve(device, runs)?;
        }
        Ok(())
    }

    /// Reserves room for a band of so many events in so many pixels' lists, each of which has a run.
    pub fn reserve_events(&mut self, device: &Device, pixels: u64, events: u64) -> Result<(), super::Error> {
        let runs = pixels + events / u64::from(LOCAL_LENGTH);
        self.runs.reserve(device, runs)?;
        self.lists.reserve(device, pixels)?;
        self.partials.reserve(device, runs)?;
        Ok(self.long.sums.reserve(device, runs)?)
    }

    /// Reserves room for the sums of long lists with at most `long` fragments, and for the segments of at least so many
    /// fragments, but of no more than the limit. Frees both if no list is long.
    pub(super) fn reserve_sums(
        &mut self,
        device: &Device,
        long: Option<u64>,
        [fragments, limit]: [u64; 2],
    ) -> Result<(), super::Error> {
        let Some(long) = long else {
            self.long.segments.release();
            self.long.sums.release();
            return Ok(());
        };
        self.long.sums.reserve(device, (2 * long).div_ceil(u64::from(LOCAL_LENGTH)).max(1))?;
        self.long.segments.reserve_within(device, fragments.max(1), limit.max(1))?;
        Ok(())
    }

    /// Returns the buffers of running sums and segments; there must have been a reserve.
    pub(in crate::methods) fn long(&self) -> &RunBuffers {
        &self.long
    }

    /// Records everything from a band's stored fragments to its pixels in the target.
    pub(in crate::methods) fn record_fragments<'a>(
        &'a self,
        recorder: &mut Recorder<'a>,
        blending: &Blending<'a>,
    ) -> Result<(), super::Error> {
        let Blending { ref job, stored, ref band, lengths, target, .. } = *blending;
        let cut = stored.cut;
        let variant = compose::variant(cut, job.raster.footprint, job.discs.falloff);
        let stopping = resolving_variant(variant.clone(), job.shown, job.stop.0);
        let classes = || occurring(CLASSES.into_iter().enumerate(), lengths.longest);
        let lists = self.record_sorted_classes(recorder, blending, classes())?;
        for (index, (capacity, name)) in classes() {
            let push = ResolvePush {
                class_index: index as u32,
                first_fragment: band.first_fragment,
                max_opacity: job.raster.cloud.max_opacity(),
                max_color: job.stop.1,
            };
            let sorting = self.sorting(capacity);
            let run = self.over_class(index).label(name).variant(sorting.resolve_variant(stopping.clone(), capacity));
            match sorting {
                Sorting::Network => recorder.run(&ResolveNetwork { lists }, push, &run)?,
                Sorting::Merge => recorder.run(&ResolveMerge { lists }, push, &run)?,
                Sorting::Group => recorder.run(&ResolveSorted { lists }, push, &run)?,
            }
        }
        if lengths.in_long_lists == 0 {
            return Ok(());
        }

        self.record_split(recorder, stored, band)?;
        let runs = self.runs_of(blending, self.record_sort(recorder, job, stored, lengths.longest)?);
        let (sorted, partials, blended) = (runs.listed(), runs.partials, composing_variant(variant.clone(), job.shown));
        recorder.run(&BlendRuns { sorted: runs.sorted, partials }, (), &runs.over_runs(blended.clone()))?;
        self.record_combine(recorder, job.shown, target)?;
        if job.discs.gaussians.stop > 0.0 {
            recorder.run(&End { sorted, partials, into: target.pixels() }, (), &runs.over_lists(blended))?;
        }
        if job.shown == Shown::Median {
            recorder.run(&Median { sorted, partials, depths: target.depths() }, (), &runs.over_lists(variant))?;
        }
        Ok(())
    }

    /// Records the image of composed runs of lists.
    pub(in crate::methods) fn record_combine<'a>(
        &'a self,
        recorder: &mut Recorder<'a>,
        shown: Shown,
        target: &'a Target,
    ) -> Result<(), super::Error> {
        let (work, lists, partials) = (self.work.all(), self.lists.get().all(), self.partials.get().all());
        let combine = over_long(work, LIST_GROUPS).variant(composing_variant(Variant::plain(), shown));
        Ok(recorder.run(&Combine { work, lists, partials, into: target.pixels() }, (), &combine)?)
    }

    /// Records every list in sorted runs, short ones too.
    pub(in crate::methods) fn record_every_list<'a>(
        &'a self,
        recorder: &mut Recorder<'a>,
        blending: &Blending<'a>,
    ) -> Result<Runs<'a>, super::Error> {
        let Blending { ref job, stored, ref band, lengths, .. } = *blending;
        let (work, runs, lists) = (self.work.all(), self.runs.get().all(), self.lists.get().all());
        recorder.fill("abuffer/clear", work, 0)?;
        let [band_start, band_end] = band.pixels;
        let push = SplitPush { band_start, band_end, first_fragment: band.first_fragment };
        let over_pixels = Run::new(Dispatch::Invocations(u64::from(band_end - band_start)));
        recorder.run(&SplitEvery { offsets: stored.offsets, work, runs, lists }, push, &over_pixels)?;
        recorder.run(&RunGroups { work }, (), &Run::new(Dispatch::Groups(1)))?;
        let fragments = self.record_sort(recorder, job, stored, lengths.longest)?;
        Ok(self.runs_of(blending, fragments))
    }

    /// Records the long lists in runs, sorted as the settings say; `None` if no list is long.
    pub(in crate::methods) fn record_long_lists<'a>(
        &'a self,
        recorder: &mut Recorder<'a>,
        blending: &Blending<'a>,
    ) -> Result<Option<Runs<'a>>, super::Error> {
        let Blending { ref job, stored, ref band, lengths, .. } = *blending;
        if lengths.in_long_lists == 0 {
            return Ok(None);
        }
        self.record_split(recorder, stored, band)?;
        let fragments = self.record_sort(recorder, job, stored, lengths.longest)?;
        Ok(Some(self.runs_of(blending, fragments)))
    }

    fn runs_of<'a>(&'a self, blending: &Blending<'a>, fragments: Slice<'a, [u32; 2]>) -> Runs<'a> {
        let Stored { cut, records, .. } = blending.stored;
        let composing = Composing::new(blending.job.raster.cloud, cut);
        let sorted = Sorted { composing, work: self.work.all(), runs: self.runs.get().all(), fragments };
        Runs { cut, sorted, lists: self.lists.get().all(), records, partials: self.partials.get().all() }
    }

    /// Records the work lists of the classes, and sorts those whose kernels only blend. Returns what the kernels bind.
    pub(in crate::methods) fn record_sorted_classes<'a>(
        &'a self,
        recorder: &mut Recorder<'a>,
        blending: &Blending<'a>,
        classes: impl Iterator<Item = (usize, (u32, &'static str))>,
    ) -> Result<Resolving<'a>, Error> {
        let Blending { ref job, stored, ref band, target, .. } = *blending;
        let Stored { cut, offsets, fragments, .. } = stored;
        let composing = Composing::new(job.raster.cloud, cut);
        self.record_classes(recorder, offsets, band)?;
        self.record_sort_lists(recorder, classes, stored, band)?;
        let (classes, pixels) = (self.classes.all(), self.pixels.get().all());
        Ok(Resolving { composing, offsets, classes, pixels, fragments, into: target.pixels() })
    }

    /// Returns how lists of up to `capacity` fragments are sorted on this device.
    pub(in crate::methods) fn sorting(&self, capacity: u32) -> Sorting {
        Sorting::of(capacity, self.shared)
    }

    /// Records the blending of lists that were stored in order: nothing is sorted.
    pub(super) fn record_ordered<'a>(
        recorder: &mut Recorder<'a>,
        blending: &Blending<'a>,
        tiles: &OrderedTiles<'a>,
    ) -> Result<(), Error> {
        let Blending { ref job, stored, ref band, lengths, target, .. } = *blending;
        let cloud = job.raster.cloud;
        let resolve = ResolveOrdered {
            splats: tiles.tiled.splats,
            offsets: stored.offsets,
            indices: stored.fragments.cast(),
            into: target.pixels(),
        };
        for segment in 0..lengths.longest.div_ceil(ORDERED_TAKEN) {
            let push = OrderedPush {
                band_start: band.pixels[0],
                band_end: band.pixels[1],
                first_fragment: band.first_fragment,
                segment,
                max_opacity: cloud.max_opacity(),
                max_color: job.stop.1,
            };
            let pixels = Dispatch::Invocations(u64::from(band.pixels[1] - band.pixels[0]));
            let run = Run::new(pixels).variant(ordered_variant(tiles.binned.cut(), job.discs.falloff, job.stop.0));
            recorder.run(&resolve, push, &run)?;
        }
        Ok(())
    }

    /// Records the work list of each class; pixels without fragments are in none, and are set to nothing before.
    fn record_classes<'a>(
        &'a self,
        recorder: &mut Recorder<'a>,
        offsets: Slice<'a, u32>,
        band: &Band,
    ) -> Result<(), Error> {
        let push = BandPush { band_start: band.pixels[0], band_end: band.pixels[1] };
        let invocations = u64::from(band.pixels[1] - band.pixels[0]).div_ceil(CLASSIFY_RUN);
        let run = Run::new(Dispatch::Invocations(invocations)).variant(class_variant());
        let (classes, pixels) = (self.classes.all(), self.pixels.get().all());
        recorder.fill("abuffer/clear", classes, 0)?;
        recorder.run(&Classify { offsets, classes }, push, &run)?;
        recorder.run(&OrderPixels { offsets, classes, pixels }, push, &run)?;
        let words = |place: u64| classes.skip(place).first(CLASS_WORDS * CLASSES.len() as u64 + 1);
        let (placed, counted) = (words(CLASS_PLACED), words(CLASS_TOTAL));
        recorder.agree_every(CLASS_WORDS as u32, "abuffer/order", "class", placed, Expected::Words(counted))
    }

    /// Records the sorting of the lists whose kernels only blend.
    fn record_sort_lists<'a>(
        &'a self,
        recorder: &mut Recorder<'a>,
        classes: impl Iterator<Item = (usize, (u32, &'static str))>,
        stored: Stored<'a>,
        band: &Band,
    ) -> Result<(), Error> {
        let Stored { offsets, fragments, .. } = stored;
        let sort = SortLists { offsets, classes: self.classes.all(), pixels: self.pixels.get().all(), fragments };
        for (index, (_, name)) in classes.filter(|(_, (n, _))| Sorting::of(*n, self.shared) == Sorting::Group) {
            let push = ClassPush { class_index: index as u32, first_fragment: band.first_fragment };
            recorder.run(&sort, push, &self.over_class(index).label(name).variant(class_variant()))?;
        }
        Ok(())
    }

    /// Records lists in runs sorted as the settings say; returns where they end up.
    fn record_sort<'a>(
        &'a self,
        recorder: &mut Recorder<'a>,
        job: &ListsJob<'a>,
        stored: Stored<'a>,
        longest: u32,
    ) -> Result<Slice<'a, [u32; 2]>, Error> {
        match (job.discs.long_lists, stored.spare) {
            (LongLists::Merge, Some(spare)) => self.record_merge_sort(recorder, stored.fragments, spare, longest),
            _ => self.record_in_place_sort(recorder, stored.fragments, longest),
        }
    }

    /// Records the sorting of the runs of long lists, each by itself.
    fn record_sort_runs<'a>(
        &'a self,
        recorder: &mut Recorder<'a>,
        fragments: Slice<'a, [u32; 2]>,
    ) -> Result<(), Error> {
        let (work, runs) = (self.work.all(), self.runs.get().all());
        if self.shared {
            return recorder.run(&SortRunsGroup { work, runs, fragments }, (), &over_long(work, WHOLE_GROUPS));
        }
        let over_runs = over_long(work, RUN_GROUPS).variant(sort_runs_variant());
        recorder.run(&SortRuns { work, runs, fragments }, (), &over_runs)
    }

    /// Records the work lists of runs and of long lists.
    fn record_split<'a>(&'a self, recorder: &mut Recorder<'a>, stored: Stored<'a>, band: &Band) -> Result<(), Error> {
        let offsets = stored.offsets;
        let (classes, pixels) = (self.classes.all(), self.pixels.get().all());
        let (work, runs, lists) = (self.work.all(), self.runs.get().all(), self.lists.get().all());
        recorder.fill("abuffer/clear", work, 0)?;
        let push = ClassPush { class_index: CLASSES.len() as u32, first_fragment: band.first_fragment };
        let over_long = self.over_class(CLASSES.len()).variant(class_variant());
        recorder.run(&Split { offsets, classes, pixels, work, runs, lists }, push, &over_long)?;
        let listed = work.cast().skip(LIST_COUNT).first(1);
        let long = classes.skip(CLASS_WORDS * CLASSES.len() as u64 + CLASS_TOTAL).first(1);
        recorder.agree("abuffer/split", "number of long lists", listed, Expected::Words(long))?;
        recorder.run(&RunGroups { work }, (), &Run::new(Dispatch::Groups(1)))
    }

    /// Records runs sorted one by one and merged pair by pair; returns where the sorted lists end up.
    fn record_merge_sort<'a>(
        &'a self,
        recorder: &mut Recorder<'a>,
        fragments: Slice<'a, [u32; 2]>,
        spare: Slice<'a, [u32; 2]>,
        longest: u32,
    ) -> Result<Slice<'a, [u32; 2]>, Error> {
        let (work, runs) = (self.work.all(), self.runs.get().all());
        self.record_sort_runs(recorder, fragments)?;
        let (mut unmerged, mut merged) = (fragments, spare);
        let mut width = LOCAL_LENGTH;
        while width < longest {
            let push = MergePush { width };
            match self.shared {
                true => {
                    let over_runs = over_long(work, WHOLE_GROUPS);
                    recorder.run(&MergeGroup { work, runs, unmerged, merged }, push, &over_runs)?;
                }
                false => {
                    recorder.run(&Merge { work, runs, unmerged, merged }, push, &over_long(work, RUN_GROUPS))?;
                }
            }
            (unmerged, merged) = (merged, unmerged);
            width = width.saturating_mul(2);
        }
        Ok(unmerged)
    }

    /// Records long lists sorted where they lie: runs as for the merge, then merges level by level, each list by one
    /// invocation, in as few dispatches as the loops allow; returns where the sorted lists are.
    fn record_in_place_sort<'a>(
        &'a self,
        recorder: &mut Recorder<'a>,
        fragments: Slice<'a, [u32; 2]>,
        longest: u32,
    ) -> Result<Slice<'a, [u32; 2]>, Error> {
        let (work, runs, lists) = (self.work.all(), self.runs.get().all(), self.lists.get().all());
        self.record_sort_runs(recorder, fragments)?;
        for push in in_place_merges(longest) {
            recorder.run(&MergeInPlace { work, runs, lists, fragments }, push, &over_long(work, LIST_GROUPS))?;
        }
        Ok(fragments)
    }

    /// Returns a dispatch over the lists of a class.
    pub(in crate::methods) fn over_class(&self, index: usize) -> Run<'_> {
        Run::new(Dispatch::Indirect(self.classes.all().skip(CLASS_WORDS * index as u64).first(3)))
    }
}

/// Returns the indirect dispatch whose arguments begin at a word of [`LongWork`].
fn over_long(work: Slice<'_, LongWork>, word: u64) -> Run<'_> {
    Run::new(Dispatch::Indirect(work.cast().skip(word).first(3)))
}

/// Returns the classes that lists of up to `longest` fragments are in, by their numbers.
pub(crate) fn occurring(
    classes: impl Iterator<Item = (usize, (u32, &'static str))>,
    longest: u32,
) -> impl Iterator<Item = (usize, (u32, &'static str))> {
    classes.take_while(move |(index, _)| longest > lower_bound(*index))
}

/// The variant of a kernel that sorts and blends whole lists, from the one that composes; `stop` holds for depths of
/// first fragments alone. Behind what changes no bit of A the median has no fragment; the mean may have some that are
/// very far away.
fn resolving_variant(compose: Variant, shown: Shown, stop: u32) -> Variant {
    match shown {
        Shown::First => compose.with("STOP", stop),
        Shown::Median => compose.with("STOP", STOP_EXACT).with("SHOWN", shown as u32),
        Shown::Mean => compose.with("STOP", STOP_NEVER).with("SHOWN", shown as u32),
    }
}

/// Returns the variant of a pass that composes parts of long lists, of which those with medians are looked at once
/// more.
pub(crate) fn composing_variant(compose: Variant, shown: Shown) -> Variant {
    if shown == Shown::Mean { compose.with("SHOWN", shown as u32) } else { compose }
}

/// The variant of `abuffer/resolve-ordered`.
fn ordered_variant(cut: Cut, falloff: Falloff, stop: u32) -> Variant {
    compose::variant(cut, Footprint::Disc, falloff).with("STOP", stop).with("TAKEN", ORDERED_TAKEN)
}

/// Constants that shaders share with this module.
pub(crate) const CONSTANTS: [(&str, u32); 8] = [
    ("CLASS_WORDS", CLASS_WORDS as u32),
    ("CLASS_TOTAL", CLASS_TOTAL as u32),
    ("CLASS_START", CLASS_START as u32),
    ("CLASS_PLACED", CLASS_PLACED as u32),
    ("CLASSIFY_RUN", CLASSIFY_RUN as u32),
    ("RUN_LENGTH", LOCAL_LENGTH),
    ("SHOWN_MEDIAN", Shown::Median as u32),
    ("SHOWN_MEAN", Shown::Mean as u32),
];

/// Returns the passes of sorting and blending with their variants.
pub(super) fn shaders() -> Vec<Shader> {
    let firsts = STOPS.map(|stop| (Shown::First, stop));
    let kinds = || firsts.into_iter().chain([Shown::Median, Shown::Mean].map(|shown| (shown, STOP_EXACT)));
    let stopping = || {
        let composed = compose::variants().into_iter();
        composed.flat_map(move |v| kinds().map(move |(shown, stop)| resolving_variant(v.clone(), shown, stop)))
    };
    let resolving =
        |sorting: Sorting, capacity: u32| stopping().map(|v| sorting.resolve_variant(v, capacity)).collect::<Vec<_>>();
    let runs = |v: Variant| [Shown::First, Shown::Mean].map(|shown| composing_variant(v.clone(), shown));
    let choices = <(Cut, Falloff)>::all().into_iter();
    let ordered = choices.flat_map(|(cut, falloff)| STOPS.map(|stop| ordered_variant(cut, falloff, stop)));
    vec![
        Shader::new::<Classify>([class_variant()]),
        Shader::new::<OrderPixels>([class_variant()]),
        Shader::new::<ResolveNetwork>(Sorting::Network.kernels(resolving)),
        Shader::new::<ResolveMerge>(Sorting::Merge.kernels(resolving)),
        Shader::new::<SortLists>([class_variant()]),
        Shader::new::<ResolveSorted>(Sorting::Group.kernels(resolving)),
        Shader::new::<ResolveOrdered>(ordered),
        Shader::new::<Split>([class_variant()]),
        Shader::plain::<RunGroups>(),
        Shader::new::<SortRuns>([sort_runs_variant()]),
        Shader::plain::<SortRunsGroup>(),
        Shader::plain::<Merge>(),
        Shader::plain::<MergeGroup>(),
        Shader::plain::<MergeInPlace>(),
        Shader::new::<BlendRuns>(compose::variants().into_iter().flat_map(runs)),
        Shader::new::<Combine>(runs(Variant::plain())),
        Shader::new::<End>(compose::variants().into_iter().flat_map(runs)),
        Shader::new::<Median>(compose::variants()),
        Shader::new::<Samples>(compose::variants()),
    ]
}
