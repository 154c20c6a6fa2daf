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
use super::{Counted, LOCAL_LENGTH, Shown, Storing, WindowJob};
use crate::choices::Choices;
use crate::gpu::shader::Shader;
use crate::gpu::{Buffer, Device, Dispatch, Error, Expected, Kept, Memory, Recorder, Run, Slice, Variant};
use crate::methods::soft::{self, LongSpheres, Spheres};
use crate::methods::sorted::{STOP_EXACT, STOP_NEVER, STOPS};
use crate::methods::{Target, ellipsoids};
use crate::passes::bands::{self, Band};
use crate::passes::bin::OrderedTiles;
use crate::passes::compose::{self, Composing, Cut};
use crate::passes::project::Footprint;
use crate::scene::{Falloff, LongLists};

/// Splats that one run of `abuffer/resolve-ordered` takes of a list: one iteration each.
const ORDERED_TAKEN: u32 = 32_768;
/// Place of the number of long lists among the words of [`LongWork`].
const LIST_COUNT: u64 = 7;
/// Place of the workgroups of a dispatch that gives one to each run.
const WHOLE_GROUPS: u64 = 8;
/// Pixels of one invocation that classifies.
const CLASSIFY_RUN: u64 = 64;

/// Buffers of sorting and blending, kept from frame to frame.
pub struct Blender {
    classes: Buffer<u32>,
    pixels: Kept<u32>,
    runs: Kept<ListRun>,
    lists: Kept<LongList>,
    partials: Kept<Partial>,
    work: Buffer<LongWork>,
    spheres: LongSpheres,
    ellipsoids: ellipsoids::Sums,
    /// `true` if workgroups share lists.
    shared: bool,
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
    /// Room for them once more, if long lists are merged.
    pub spare: Option<Slice<'a, [u32; 2]>>,
    /// Records of packed events of spheres; any buffer where no events are packed.
    pub records: Slice<'a, [u32; 4]>,
}

impl Blender {
    /// No buffers but the small ones yet.
    pub fn new(device: &Device) -> Result<Self, Error> {
        Ok(Self {
            classes: device.buffer("classes", CLASS_WORDS * (CLASSES.len() as u64 + 1), Memory::Device)?,
            pixels: Kept::new("pixels by class", Memory::Device),
            runs: Kept::new("list runs", Memory::Device),
            lists: Kept::new("long lists", Memory::Device),
            partials: Kept::new("partial sums", Memory::Device),
            work: device.buffer("long work", 1, Memory::Device)?,
            spheres: LongSpheres::default(),
            ellipsoids: ellipsoids::Sums::default(),
            shared: device.info().prefers.shared_work,
        })
    }

    /// Room for a window of `pixels`, with at most `long` fragments in a band's long lists.
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

    /// Room for a band of so many events in so many pixels' lists, each of which has a run.
    pub fn reserve_events(&mut self, device: &Device, pixels: u64, events: u64) -> Result<(), super::Error> {
        let runs = pixels + events / u64::from(LOCAL_LENGTH);
        self.runs.reserve(device, runs)?;
        self.lists.reserve(device, pixels)?;
        self.partials.reserve(device, runs)?;
        self.ellipsoids.reserve(device, runs)
    }

    /// Room for what long lists of spheres need besides: in them at most `long` events, if there are any; and for the segments
    /// of at least so many events, but of no more than the limit.
    pub fn reserve_spheres(
        &mut self,
        device: &Device,
        long: Option<u64>,
        [events, limit]: [u64; 2],
    ) -> Result<(), super::Error> {
        match long {
            Some(long) => self.spheres.reserve(device, soft::long_runs(long), events, limit),
            None => {
                self.spheres.release();
                Ok(())
            }
        }
    }

    /// Records everything from a band's stored fragments to its pixels in the target.
    pub fn record<'a>(
        &'a self,
        recorder: &mut Recorder<'a>,
        job: &WindowJob<'a>,
        stored: Stored<'a>,
        target: &'a Target,
        band: &Band,
        counted: &Counted,
    ) -> Result<(), super::Error> {
        let Stored { cut, offsets, fragments, .. } = stored;
        let variant = compose::variant(cut, job.raster.footprint, job.discs.falloff);
        let composing = Composing::new(job.raster.cloud, cut);
        let (image, depths) = (target.image(), target.depths());
        if let Storing::Ordered(bins, binned) = job.storing {
            let tiles = bins.tiles(job.raster.cloud, binned);
            return Ok(Self::record_ordered(recorder, job, stored, &tiles, target, band, counted)?);
        }
        if let Storing::Spheres(spheres) = &job.storing {
            return self.record_spheres(recorder, job, stored, spheres, target, band, counted);
        }
        if job.storing.are_ellipsoids() {
            return self.record_ellipsoids(recorder, job, stored, target, band, counted);
        }
        self.record_classes(recorder, offsets, band)?;
        let (classes, pixels) = (self.classes.all(), self.pixels.get().all());
        let lists = Resolving { composing, offsets, classes, pixels, fragments, image, depths };
        let stopping = resolving_variant(variant.clone(), job.shown, job.stop.0);
        let classes = || occurring(CLASSES.into_iter().enumerate(), counted.lengths.longest);
        self.record_sort_lists(recorder, classes(), stored, band)?;
        for (index, (capacity, name)) in classes() {
            let push = ResolvePush {
                class_index: index as u32,
                first_fragment: band.first_fragment,
                max_opacity: job.raster.cloud.max_opacity(),
                max_color: job.stop.1,
            };
            let sorting = Sorting::of(capacity, self.shared);
            let run = self.over_class(index).label(name).variant(sorting.resolve_variant(stopping.clone(), capacity));
            match sorting {
                Sorting::Network => recorder.run(&ResolveNetwork { lists }, push, &run)?,
                Sorting::Merge => recorder.run(&ResolveMerge { lists }, push, &run)?,
                Sorting::Group => recorder.run(&ResolveSorted { lists }, push, &run)?,
            }
        }
        if counted.lengths.in_long_lists == 0 {
            return Ok(());
        }

        self.record_split(recorder, stored, band)?;
        let sorted = self.record_sort(recorder, job, stored, counted.lengths.longest)?;
        let (work, runs, lists) = (self.work.all(), self.runs.get().all(), self.lists.get().all());
        let partials = self.partials.get().all();
        let blend = BlendRuns { composing, work, runs, fragments: sorted, partials };
        recorder.run(&blend, (), &self.over_runs().variant(composing_variant(variant.clone(), job.shown)))?;
        let combine = self.over_lists().variant(composing_variant(Variant::plain(), job.shown));
        recorder.run(&Combine { work, lists, partials, image, depths }, (), &combine)?;
        if job.discs.gaussians.stop > 0.0 {
            let end = End { composing, work, lists, runs, fragments: sorted, partials, image, depths };
            recorder.run(&end, (), &self.over_lists().variant(composing_variant(variant.clone(), job.shown)))?;
        }
        if job.shown == Shown::Median {
            let median = Median { composing, work, lists, runs, fragments: sorted, partials, depths };
            recorder.run(&median, (), &self.over_lists().variant(variant))?;
        }
        Ok(())
    }

    /// Records the sorting and blending of events of ellipsoids: every list goes in runs.
    fn record_ellipsoids<'a>(
        &'a self,
        recorder: &mut Recorder<'a>,
        job: &WindowJob<'a>,
        stored: Stored<'a>,
        target: &'a Target,
        band: &Band,
        counted: &Counted,
    ) -> Result<(), super::Error> {
        let longest = counted.lengths.longest;
        let sorted = self.record_every_list(recorder, job, stored, band, longest)?;
        self.ellipsoids.record(recorder, &sorted, longest > LOCAL_LENGTH, job.shown)?;
        let ellipsoids::Sorted { work, lists, partials, .. } = sorted;
        let (image, depths) = (target.image(), target.depths());
        let combine = self.over_lists().variant(composing_variant(Variant::plain(), job.shown));
        recorder.run(&Combine { work, lists, partials, image, depths }, (), &combine)?;
        if job.shown == Shown::Median {
            self.ellipsoids.record_medians(recorder, &sorted, depths)?;
        }
        Ok(())
    }

    /// Records every list in sorted runs, short ones too.
    fn record_every_list<'a>(
        &'a self,
        recorder: &mut Recorder<'a>,
        job: &WindowJob<'a>,
        stored: Stored<'a>,
        band: &Band,
        longest: u32,
    ) -> Result<ellipsoids::Sorted<'a>, super::Error> {
        let (cut, falloff) = (stored.cut, job.discs.falloff);
        let (work, runs, lists) = (self.work.all(), self.runs.get().all(), self.lists.get().all());
        recorder.fill("abuffer/clear", work, 0)?;
        ellipsoids::record_split(recorder, ellipsoids::Split { offsets: stored.offsets, work, runs, lists }, band)?;
        recorder.run(&RunGroups { work }, (), &Run::new(Dispatch::Groups(1)))?;
        let fragments = self.record_sort(recorder, job, stored, longest)?;
        let (composing, partials) = (Composing::new(job.raster.cloud, cut), self.partials.get().all());
        Ok(ellipsoids::Sorted { composing, cut, falloff, work, runs, lists, fragments, partials })
    }

    /// Records the sorting and blending of events of soft spheres.
    #[expect(clippy::too_many_arguments, reason = "as the others, and the spheres")]
    fn record_spheres<'a>(
        &'a self,
        recorder: &mut Recorder<'a>,
        job: &WindowJob<'a>,
        stored: Stored<'a>,
        spheres: &Spheres<'a>,
        target: &'a Target,
        band: &Band,
        counted: &Counted,
    ) -> Result<(), super::Error> {
        let Stored { cut, offsets, fragments, records, .. } = stored;
        let composing = Composing::new(job.raster.cloud, cut);
        let (image, depths) = (target.image(), target.depths());
        self.record_classes(recorder, offsets, band)?;
        let (classes, pixels) = (self.classes.all(), self.pixels.get().all());
        let lists = Resolving { composing, offsets, classes, pixels, fragments, image, depths };
        let longest = counted.lengths.longest;
        // There is no list of one event.
        let classes = || occurring(soft::classes(), longest);
        self.record_sort_lists(recorder, classes(), stored, band)?;
        for (index, (capacity, name)) in classes() {
            let push = spheres.push(index as u32, band.first_fragment, job.stop.1);
            let sorting = Sorting::of(capacity, self.shared);
            let kernel = spheres.resolve_variant(cut, job.stop.0, sorting, capacity);
            let run = self.over_class(index).label(name).variant(kernel);
            match sorting {
                Sorting::Network => recorder.run(&soft::ResolveNetwork { lists, records }, push, &run)?,
                Sorting::Merge => recorder.run(&soft::ResolveMerge { lists, records }, push, &run)?,
                Sorting::Group => recorder.run(&soft::ResolveSorted { lists, records }, push, &run)?,
            }
        }
        let (true, Some(spare)) = (counted.lengths.in_long_lists > 0, stored.spare) else { return Ok(()) };

        self.record_split(recorder, stored, band)?;
        let fragments = self.record_merge_sort(recorder, fragments, spare, longest)?;
        let (work, runs, lists) = (self.work.all(), self.runs.get().all(), self.lists.get().all());
        let partials = self.partials.get().all();
        let sorted = soft::Sorted { composing, cut, work, runs, lists, fragments, records, partials };
        self.spheres.record(recorder, spheres, &sorted, longest)?;
        Ok(recorder.run(&Combine { work, lists, partials, image, depths }, (), &self.over_lists())?)
    }

    /// Records the blending of lists that were stored in order: nothing is sorted.
    fn record_ordered<'a>(
        recorder: &mut Recorder<'a>,
        job: &WindowJob<'a>,
        stored: Stored<'a>,
        tiles: &OrderedTiles<'a>,
        target: &'a Target,
        band: &Band,
        counted: &Counted,
    ) -> Result<(), Error> {
        let cloud = job.raster.cloud;
        let resolve = ResolveOrdered {
            splats: tiles.tiled.splats,
            offsets: stored.offsets,
            indices: stored.fragments.cast(),
            image: target.image(),
            depths: target.depths(),
        };
        for segment in 0..counted.lengths.longest.div_ceil(ORDERED_TAKEN) {
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
        recorder.run(&Groups { classes }, (), &Run::new(Dispatch::Groups(1)).variant(class_variant()))?;
        recorder.run(&Order { offsets, classes, pixels }, push, &run)?;
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
        job: &WindowJob<'a>,
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
            let whole = Run::new(Dispatch::Indirect(work.cast().skip(WHOLE_GROUPS).first(3)));
            return recorder.run(&SortRunsGroup { work, runs, fragments }, (), &whole);
        }
        recorder.run(&SortRuns { work, runs, fragments }, (), &self.over_runs().variant(sort_runs_variant()))
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
            recorder.run(&Merge { work, runs, unmerged, merged }, MergePush { width }, &self.over_runs())?;
            (unmerged, merged) = (merged, unmerged);
            width = width.saturating_mul(2);
        }
        Ok(unmerged)
    }

    /// Records long lists sorted where they lie: runs as for the merge, then merges level by level, each list by one invocation,
    /// in as few dispatches as the loops allow; returns where the sorted lists are.
    fn record_in_place_sort<'a>(
        &'a self,
        recorder: &mut Recorder<'a>,
        fragments: Slice<'a, [u32; 2]>,
        longest: u32,
    ) -> Result<Slice<'a, [u32; 2]>, Error> {
        let (work, runs, lists) = (self.work.all(), self.runs.get().all(), self.lists.get().all());
        self.record_sort_runs(recorder, fragments)?;
        for push in in_place_merges(longest) {
            recorder.run(&MergeInPlace { work, runs, lists, fragments }, push, &self.over_lists())?;
        }
        Ok(fragments)
    }

    fn over_class(&self, index: usize) -> Run<'_> {
        Run::new(Dispatch::Indirect(self.classes.all().skip(CLASS_WORDS * index as u64).first(3)))
    }

    fn over_runs(&self) -> Run<'_> {
        Run::new(long_groups(self.work.all(), 0))
    }

    fn over_lists(&self) -> Run<'_> {
        Run::new(long_groups(self.work.all(), 4))
    }
}

/// Returns the indirect dispatch whose arguments begin at a word of [`LongWork`].
pub fn long_groups(work: Slice<'_, LongWork>, word: u64) -> Dispatch<'_> {
    Dispatch::Indirect(work.cast().skip(word).first(3))
}

/// The classes that lists of up to `longest` fragments are in, by their numbers.
fn occurring(
    classes: impl Iterator<Item = (usize, (u32, &'static str))>,
    longest: u32,
) -> impl Iterator<Item = (usize, (u32, &'static str))> {
    classes.take_while(move |(index, _)| longest > lower_bound(*index))
}

/// The variant of a kernel that sorts and blends whole lists, from the one that composes; `stop` holds for depths of first
/// fragments alone. Behind what changes no bit of A the median has no fragment; the mean may have some that are very far away.
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

/// Pixels and depths of nothing: no color, no coverage, infinitely far.
pub fn record_nothing<'a>(recorder: &mut Recorder<'a>, target: &'a Target, window: bands::Window) -> Result<(), Error> {
    let pixels = bands::pixels(window);
    recorder.fill("image/clear", target.image().first(pixels), 0)?;
    recorder.fill("image/clear", target.depths().first(pixels), f32::INFINITY.to_bits())
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
        Shader::new::<Groups>([class_variant()]),
        Shader::new::<Order>([class_variant()]),
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
        Shader::plain::<MergeInPlace>(),
        Shader::new::<BlendRuns>(compose::variants().into_iter().flat_map(runs)),
        Shader::new::<Combine>(runs(Variant::plain())),
        Shader::new::<End>(compose::variants().into_iter().flat_map(runs)),
        Shader::new::<Median>(compose::variants()),
        Shader::new::<Samples>(compose::variants()),
    ]
}
