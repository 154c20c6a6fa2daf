//! Soft points as spheres in the A-buffer: `soft-base` and `soft-concentric`.
//!
//! A pixel's list holds events: where its ray enters and leaves each sphere, or each of its shells, cut at near and at the
//! solid points. An event is a fragment of the A-buffer, depth key and index, the latter with the shell and a bit that tells
//! exits. All else follows from the sphere while blending, so that counting, storing and sorting are those of other lists.
//!
//! Short lists are gone through by one invocation. `soft-base` keeps the open spheres in an array that half of the events fill
//! at most; `soft-concentric` needs sums only. Of long lists, each run is composed by itself: colors and constant densities
//! are running sums, whose value before each run follows from what the runs before add; the integrals of `soft-base` are
//! taken for each segment from all spheres that may reach it, wherever they lie in the list.

use super::{Layer, SoftModel};
use crate::gpu::shader::{Choices, Shader};
use crate::gpu::{Device, Dispatch, Kept, Memory, Recorder, Run, Slice, Variant};
use crate::methods::abuffer::{self, LOCAL_LENGTH, ListRun, LongList, LongWork, Partial, ResolvingGroup};
use crate::methods::sorted::STOPS;
use crate::methods::{Error, Target, splats};
use crate::passes::bands::Band;
use crate::passes::compose::{self, ComposingGroup, Cut};
use crate::passes::project::Footprint;
use crate::passes::raster::{self, Chunk, ChunkGroup, Raster, RasterPush};
use crate::passes::tiles::SEGMENT;
use crate::scene::{Falloff, MAX_SHELLS, Method, Shells, SoftLayout};
use crate::{choices, gpu_struct, pass};

gpu_struct! {
    /// Push constants of the kernels that blend; shaders/shared/soft_push.wgsl says what the members are.
    pub struct SoftPush {
        class_index: u32,
        first_fragment: u32,
        most_color: f32,
        lambda: f32,
        peak: f32,
        most_radius: f32,
        first: u32,
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

pass! {
    /// Counts two events in each pixel of a soft sphere's silhouette for each of its shells that the ray meets between
    /// near and the solid points. Spheres with shells count once more for the sphere. From an optical depth of 1000 on,
    /// this pass and all that follow place a sphere in two floats (`Footprint::ExactSphere`): a ray that the sphere lets
    /// through passes so near its rim that float32 would show.
    pub Count(RasterPush) = "soft/count" {
        chunk: Shared<ChunkGroup>,
        solids: Read<f32>,
        counts: ReadWrite<u32>,
        spheres: ReadWrite<u32>,
    }
}

pass! {
    /// Stores the depth key and index of each event in a slot of its pixel's range.
    pub Store(RasterPush) = "soft/store" {
        chunk: Shared<ChunkGroup>,
        solids: Read<f32>,
        cursors: ReadWrite<u32>,
        fragments: ReadWrite<[u32; 2]>,
        colors: Read<[f32; 4]>,
        records: ReadWrite<[u32; 4]>,
    }
}

pass! {
    /// Sorts the events of each list of a class of up to 64 in registers, and blends the segments between them. Its
    /// label ends with the longest length of the class.
    pub ResolveNetwork(SoftPush) = "soft/resolve" in "soft/resolve_network" {
        lists: Shared<ResolvingGroup>,
        records: Read<[u32; 4]>,
    }
}

pass! {
    /// Sorts the events of each list of a class of up to 256 in a local array, and blends the segments between them.
    pub ResolveMerge(SoftPush) = "soft/resolve" in "soft/resolve_merge" {
        lists: Shared<ResolvingGroup>,
        records: Read<[u32; 4]>,
    }
}

pass! {
    /// Sums what the events of each run of a sorted long list add to the running sums of color and density.
    pub SumRuns(SoftPush) = "soft/sum-runs" in "soft/sum_runs" {
        composing: Shared<ComposingGroup>,
        work: ReadWrite<LongWork>,
        runs: Read<ListRun>,
        fragments: Read<[u32; 2]>,
        sums: ReadWrite<RunSums>,
        records: Read<[u32; 4]>,
    }
}

pass! {
    /// Finds the running sums before each run of each long list.
    pub Carry = "soft/carry" {
        work: ReadWrite<LongWork>,
        lists: Read<LongList>,
        sums: ReadWrite<RunSums>,
    }
}

pass! {
    /// Integrates the optical depth of each segment of a run from all spheres that may reach it (`soft-base`): one
    /// workgroup per run, four segments per invocation. A dispatch takes 49 152 events of each list.
    pub Segments(SoftPush) = "soft/segments" {
        composing: Shared<ComposingGroup>,
        work: ReadWrite<LongWork>,
        runs: Read<ListRun>,
        fragments: Read<[u32; 2]>,
        segments: ReadWrite<f32>,
        records: Read<[u32; 4]>,
    }
}

pass! {
    /// Composes the segments of each run.
    pub BlendRuns(SoftPush) = "soft/blend-runs" in "soft/blend_runs" {
        composing: Shared<ComposingGroup>,
        work: ReadWrite<LongWork>,
        runs: Read<ListRun>,
        fragments: Read<[u32; 2]>,
        sums: Read<RunSums>,
        segments: Read<f32>,
        partials: ReadWrite<Partial>,
        records: Read<[u32; 4]>,
    }
}

gpu_struct! {
    /// Push constants: pixels, and the depth that those of solid points are relative to.
    pub struct ComposePush {
        count: u32,
        origin: f32,
    }
}

pass! {
    /// Composes the soft points over the solid ones in each pixel.
    pub Compose(ComposePush) = "soft/compose" {
        solid_image: Read<[f32; 4]>,
        solid_depths: Read<f32>,
        image: ReadWrite<[f32; 4]>,
        depths: ReadWrite<f32>,
    }
}

/// Names of the kernels by the classes of [`abuffer::CLASSES`]; there is no list of a single event.
pub const RESOLVE: [&str; 8] = [
    "",
    "soft/resolve-4",
    "soft/resolve-8",
    "soft/resolve-16",
    "soft/resolve-32",
    "soft/resolve-64",
    "soft/resolve-128",
    "soft/resolve-256",
];
/// Each class of list lengths that events come in, by its number: the longest list and the name of its kernel.
pub fn classes() -> impl Iterator<Item = (usize, (u32, &'static str))> {
    let names = abuffer::CLASSES.into_iter().zip(RESOLVE).map(|((capacity, _), name)| (capacity, name));
    names.enumerate().skip(1)
}

/// Events of a list that one run of `soft/segments` looks at: one iteration each.
const SEGMENTS_TAKEN: u32 = 49_152;
/// Large splats that a workgroup stores where they have shells.
const SHELLS_SEGMENT: u32 = 768;
/// Device bytes of an event of a band with long lists, of `soft-base`.
pub const SEGMENT_BYTES: u64 = 4;
/// Device bytes of what an event carries where it is packed.
pub const RECORD_BYTES: u64 = 16;
/// Device bytes per pixel of the number of spheres, where these have shells.
pub const SPHERES_BYTES: u64 = 4;

/// A sphere of which density falls off linearly, and shells of constant density: values of `MODEL` in WGSL.
const MODEL_BASE: u32 = 0;
const MODEL_CONCENTRIC: u32 = 1;
/// What shaders know of this module.
pub(crate) const CONSTANTS: [(&str, u32); 2] = [("MODEL_BASE", MODEL_BASE), ("MOST_SHELLS", MAX_SHELLS)];

/// What a sphere is made of.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Interior {
    /// It falls off linearly: `soft-base`.
    Linear,
    /// The same, from what the paper stores of events.
    Packed,
    /// That of concentric shells: `soft-concentric`.
    Shells(Shells, f32),
}

impl Interior {
    /// Of spheres that are integrated, by what is stored of their events.
    pub fn integrated(layout: SoftLayout) -> Self {
        match layout {
            SoftLayout::Precise => Self::Linear,
            SoftLayout::Paper => Self::Packed,
        }
    }

    /// Shells of a sphere at most.
    pub fn most_shells(self) -> u32 {
        match self {
            Self::Linear | Self::Packed => 1,
            Self::Shells(Shells::Fixed(shells), _) => shells,
            Self::Shells(Shells::Adaptive, _) => MAX_SHELLS,
        }
    }

    /// Whether the spheres of a pixel must be counted besides its events.
    pub fn counted(self) -> bool {
        self.most_shells() > 1
    }

    /// Large splats of a tile that one workgroup stores: an invocation has four pixels of each, and a loop of up to 16 turns
    /// over the shells in each pixel.
    fn segment(self) -> u32 {
        if self.counted() { SHELLS_SEGMENT } else { SEGMENT }
    }

    /// Bits of an event's index for the shell.
    fn shell_bits(self) -> u32 {
        self.most_shells().next_power_of_two().ilog2()
    }

    /// Points that events can tell apart.
    fn most_points(self) -> u64 {
        1 << (31 - self.shell_bits())
    }

    /// Adds what shaders/shared/sphere.wgsl wants to know.
    fn sphere(self, variant: Variant) -> Variant {
        let (shells, pixels_per_shell) = match self {
            Self::Linear | Self::Packed => (1, 1.0),
            Self::Shells(Shells::Fixed(shells), pixels) => (shells, pixels),
            Self::Shells(Shells::Adaptive, pixels) => (0, pixels),
        };
        variant
            .with("SHELLS", shells)
            .with("PIXELS_PER_SHELL", pixels_per_shell)
            .with("SHELL_BITS", self.shell_bits())
            .with("PACKED", u32::from(self == Self::Packed))
    }

    /// Whether events are integrated, and not constant densities summed.
    pub fn is_integrated(self) -> bool {
        !matches!(self, Self::Shells(..))
    }

    /// Adds what shaders/shared/soft_terms.wgsl wants to know besides.
    fn terms(self, variant: Variant, modulated: bool) -> Variant {
        let model = if self.is_integrated() { MODEL_BASE } else { MODEL_CONCENTRIC };
        self.sphere(variant).with("MODEL", model).with("MODULATED", u32::from(modulated))
    }
}

/// What the kernels are made for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Kind {
    /// What a sphere is made of.
    pub interior: Interior,
    /// Whether it is so dense that float32 would show ([`SoftModel::is_stiff`]).
    pub exact: bool,
    /// Whether some points are modulated.
    pub modulated: bool,
}

impl Kind {
    /// How spheres are projected.
    pub fn footprint(self) -> Footprint {
        if self.exact { Footprint::ExactSphere } else { Footprint::Sphere }
    }
}

/// The soft points of a window.
#[derive(Clone, Copy)]
pub struct Spheres<'a> {
    /// What they are.
    pub kind: Kind,
    /// How dense they are.
    pub model: SoftModel,
    /// Largest world radius.
    pub most_radius: f32,
    /// The depth that those of solid points are relative to.
    pub origin: f32,
    /// What the solid points left, if there are any.
    pub layer: Option<&'a Layer>,
}

impl<'a> Spheres<'a> {
    /// Refuses what events cannot name.
    pub fn check(&self, method: &Method, points: u64) -> Result<(), Error> {
        let limit = self.kind.interior.most_points();
        if points > limit {
            let shells = self.kind.interior.most_shells();
            return Err(Error::TooManySpheres { points, method: method.name(), shells, limit });
        }
        Ok(())
    }

    /// Device bytes per pixel beside those of lists.
    pub fn pixel_bytes(&self) -> u64 {
        pixel_bytes(self.kind.interior, self.layer.is_some())
    }

    /// Records the count; `spheres` is anything if they are not [`Interior::counted`].
    pub fn record_count(
        &self,
        recorder: &mut Recorder<'a>,
        raster: &Raster<'a>,
        counts: Slice<'a, u32>,
        spheres: Slice<'a, u32>,
    ) -> Result<(), Error> {
        let whole = Band::whole(raster.window, 0);
        let solids = self.solids(counts);
        let stage = |chunk: Chunk<'a>| Count { chunk, solids, counts, spheres };
        let with = |variant| count_variant(variant, self.kind.interior, self.layer.is_some());
        Ok(raster.record_variant(recorder, &whole, stage, SEGMENT, with)?)
    }

    /// Records a band's store.
    pub fn record_store(
        &self,
        recorder: &mut Recorder<'a>,
        raster: &Raster<'a>,
        band: &Band,
        cursors: Slice<'a, u32>,
        (fragments, records): (Slice<'a, [u32; 2]>, Slice<'a, [u32; 4]>),
    ) -> Result<(), Error> {
        let solids = self.solids(cursors);
        let stage = |chunk: Chunk<'a>| {
            let colors = raster.colors_of(&chunk);
            Store { chunk, solids, cursors, fragments, colors, records }
        };
        let with = |variant| store_variant(variant, self.kind.interior, self.layer.is_some());
        Ok(raster.record_variant(recorder, band, stage, self.kind.interior.segment(), with)?)
    }

    /// Records the solid points of a window behind what is in the target.
    pub fn record_compose(&self, recorder: &mut Recorder<'a>, target: &'a Target, pixels: u64) -> Result<(), Error> {
        match self.layer {
            Some(layer) => record_compose(recorder, layer, target, pixels, self.origin),
            None => Ok(()),
        }
    }

    /// Push constants of the kernels.
    pub fn push(&self, class_index: u32, first_fragment: u32, most_color: f32) -> SoftPush {
        let SoftModel { lambda, peak } = self.model;
        SoftPush { class_index, first_fragment, most_color, lambda, peak, most_radius: self.most_radius, first: 0 }
    }

    /// The variant of the kernel for lists of up to `capacity` events.
    pub fn resolve_variant(&self, cut: Cut, stop: u32, capacity: u32) -> Variant {
        resolve_variant(self.kind, cut, stop, capacity)
    }

    /// Depths of the solid points; anything where there are none, since nobody reads it then.
    fn solids(&self, other: Slice<'a, u32>) -> Slice<'a, f32> {
        self.layer.map_or(other.cast(), Layer::depths)
    }
}

/// Device bytes per pixel beside those of lists, those by which the solid points were drawn included.
pub fn pixel_bytes(interior: Interior, solids: bool) -> u64 {
    let layer = if solids { Layer::PIXEL_BYTES + splats::PIXEL_BYTES } else { 0 };
    layer + if interior.counted() { SPHERES_BYTES } else { 0 }
}

/// Records a window's solid points behind what is in the target.
pub fn record_compose<'a>(
    recorder: &mut Recorder<'a>,
    layer: &'a Layer,
    target: &'a Target,
    pixels: u64,
    origin: f32,
) -> Result<(), Error> {
    let (image, depths) = (target.image(), target.depths());
    let compose = Compose { solid_image: layer.image(), solid_depths: layer.depths(), image, depths };
    let push = ComposePush { count: pixels as u32, origin };
    Ok(recorder.run(&compose, push, &Run::new(Dispatch::Invocations(pixels)))?)
}

/// The variant of `soft/count` for a walker's.
fn count_variant(walker: Variant, interior: Interior, cut: bool) -> Variant {
    interior.sphere(walker).with("CUT", u32::from(cut)).with("COUNTED", u32::from(interior.counted()))
}

/// The variant of `soft/store` for a walker's.
fn store_variant(walker: Variant, interior: Interior, cut: bool) -> Variant {
    interior.sphere(walker).with("CUT", u32::from(cut))
}

/// The variant of the kernel for lists of up to `capacity` events; which of the two kernels it is, [`abuffer::is_network`] says.
fn resolve_variant(kind: Kind, cut: Cut, stop: u32, capacity: u32) -> Variant {
    let piece = if kind.interior.is_integrated() { "blend_spheres" } else { "blend_shells" };
    let variant = run_variant(kind, cut).with("STOP", stop).walker(piece);
    let sorted = abuffer::resolve_variant(variant, capacity);
    if abuffer::is_network(capacity) { sorted.constant("CAPACITY", capacity) } else { sorted }
}

/// The variant of the passes over runs of long lists.
fn run_variant(kind: Kind, cut: Cut) -> Variant {
    kind.interior.terms(compose::variant(cut, kind.footprint(), Falloff::Flat), kind.modulated)
}

/// The variant of `soft/segments`.
fn segments_variant(kind: Kind, cut: Cut) -> Variant {
    run_variant(kind, cut).with("TAKEN", SEGMENTS_TAKEN)
}

/// Buffers of long lists, kept from frame to frame.
pub struct LongSpheres {
    segments: Kept<f32>,
    sums: Kept<RunSums>,
}

impl Default for LongSpheres {
    fn default() -> Self {
        Self { segments: Kept::new("segments", Memory::Device), sums: Kept::new("sums of runs", Memory::Device) }
    }
}

/// A band's long lists, sorted.
#[derive(Clone, Copy)]
pub struct Sorted<'a> {
    /// How the splats are reached.
    pub composing: compose::Composing<'a>,
    /// The same.
    pub cut: Cut,
    /// Counts and indirect arguments.
    pub work: Slice<'a, LongWork>,
    /// The runs.
    pub runs: Slice<'a, ListRun>,
    /// The lists.
    pub lists: Slice<'a, LongList>,
    /// Where their events are.
    pub fragments: Slice<'a, [u32; 2]>,
    /// What is stored of them besides, if they are packed.
    pub records: Slice<'a, [u32; 4]>,
    /// Where the composed runs come out.
    pub partials: Slice<'a, Partial>,
}

impl LongSpheres {
    /// Room for so many runs, and for the segments of a band of so many events.
    pub fn reserve(&mut self, device: &Device, runs: u64, events: u64, limit: u64) -> Result<(), Error> {
        self.sums.reserve(device, runs.max(1))?;
        self.segments.reserve_within(device, events.max(1), limit.max(1))?;
        Ok(())
    }

    /// Frees what [`Self::reserve`] took.
    pub fn release(&mut self) {
        self.segments.release();
        self.sums.release();
    }

    /// Records the composition of each run.
    pub fn record<'a>(
        &'a self,
        recorder: &mut Recorder<'a>,
        spheres: &Spheres<'a>,
        sorted: &Sorted<'a>,
        longest: u32,
    ) -> Result<(), Error> {
        let Sorted { composing, cut, work, runs, lists, fragments, records, partials } = *sorted;
        let (sums, segments) = (self.sums.get().all(), self.segments.get().all());
        let arguments = |word| Dispatch::Indirect(work.cast().skip(word).first(3));
        let variant = run_variant(spheres.kind, cut);
        let push = spheres.push(0, 0, 0.0);
        let over_runs = || Run::new(arguments(0)).variant(variant.clone());
        recorder.run(&SumRuns { composing, work, runs, fragments, sums, records }, push, &over_runs())?;
        recorder.run(&Carry { work, lists, sums }, (), &Run::new(arguments(4)))?;
        if spheres.kind.interior.is_integrated() {
            for first in (0..longest).step_by(SEGMENTS_TAKEN as usize) {
                let push = SoftPush { first, ..push };
                let run = Run::new(arguments(8)).variant(segments_variant(spheres.kind, cut));
                recorder.run(&Segments { composing, work, runs, fragments, segments, records }, push, &run)?;
            }
        }
        let blend = BlendRuns { composing, work, runs, fragments, sums, segments, partials, records };
        Ok(recorder.run(&blend, push, &over_runs())?)
    }
}

/// Runs of long lists of so many events at most.
pub fn long_runs(events: u64) -> u64 {
    (2 * events).div_ceil(u64::from(LOCAL_LENGTH))
}

/// Of shells as many as a sphere's radius asks for, and a number of them.
impl Choices for Interior {
    fn all() -> Vec<Self> {
        vec![Self::Linear, Self::Packed, Self::Shells(Shells::Adaptive, 4.0), Self::Shells(Shells::Fixed(5), 4.0)]
    }
}

choices!(struct Kind { interior, exact, modulated });

/// The passes with their variants.
pub(super) fn shaders() -> Vec<Shader> {
    let walked = |of: fn(Variant, Interior, bool) -> Variant, segment: fn(Interior) -> u32| {
        let spheres =
            |interior| raster::computed_variants(&[Footprint::Sphere, Footprint::ExactSphere], segment(interior));
        let of = |(interior, cut)| spheres(interior).into_iter().map(move |walker| of(walker, interior, cut));
        <(Interior, bool)>::all().into_iter().flat_map(of).collect::<Vec<_>>()
    };
    let blended = |of: &dyn Fn(Kind, Cut) -> Vec<Variant>| {
        <(Kind, Cut)>::all().into_iter().flat_map(|(kind, cut)| of(kind, cut)).collect::<Vec<_>>()
    };
    let kernels =
        |capacity| blended(&|kind, cut| STOPS.map(|stop| resolve_variant(kind, cut, stop, capacity)).to_vec());
    let runs = || blended(&|kind, cut| vec![run_variant(kind, cut)]);
    vec![
        Shader::new::<Count>(walked(count_variant, |_| SEGMENT)),
        Shader::new::<Store>(walked(store_variant, Interior::segment)),
        Shader::new::<ResolveNetwork>(abuffer::kernels(kernels, |capacity| {
            capacity > 1 && abuffer::is_network(capacity)
        })),
        Shader::new::<ResolveMerge>(abuffer::kernels(kernels, |capacity| !abuffer::is_network(capacity))),
        Shader::new::<SumRuns>(runs()),
        Shader::plain::<Carry>(),
        Shader::new::<Segments>(blended(&|kind, cut| vec![segments_variant(kind, cut)])),
        Shader::new::<BlendRuns>(runs()),
        Shader::plain::<Compose>(),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Soft;

    /// Iterations of all loops of an invocation together: one driver ends loops silently after 65 535.
    const MOST_ITERATIONS: u32 = 60_000;

    #[test]
    fn loops_are_within_the_iterations() {
        const {
            // Four pixels of each large splat of a segment, and groups of four of the shells after the first.
            assert!(SHELLS_SEGMENT * (1 + 4 * (1 + (MAX_SHELLS - 1).div_ceil(4))) < MOST_ITERATIONS);
            // Small splats have up to 1024 pixels.
            assert!(1024 * (1 + (MAX_SHELLS - 1).div_ceil(4)) < MOST_ITERATIONS);
            // Events, and one turn more for each workgroup of them.
            assert!(SEGMENTS_TAKEN + SEGMENTS_TAKEN / 64 + 64 < MOST_ITERATIONS);
            // Each event of a run may go over all shells, if modulated.
            assert!(LOCAL_LENGTH * (1 + MAX_SHELLS) < MOST_ITERATIONS);
            // Half of the events are entries, and each segment goes over what is open.
            assert!(LOCAL_LENGTH * (1 + LOCAL_LENGTH / 2) < MOST_ITERATIONS);
        }
    }

    #[test]
    fn events_tell_so_many_points_apart() {
        let limits = [
            (Interior::Linear, 1 << 31),
            (Interior::Shells(Shells::Fixed(1), 4.0), 1 << 31),
            (Interior::Shells(Shells::Fixed(5), 4.0), 1 << 28),
            (Interior::Shells(Shells::Adaptive, 4.0), 1 << 25),
        ];
        let method = Method::SoftConcentric(Soft::default());
        for (interior, limit) in limits {
            let model = SoftModel { lambda: 1.0, peak: 0.5 };
            let kind = Kind { interior, exact: false, modulated: false };
            let spheres = Spheres { kind, model, most_radius: 1.0, origin: 0.0, layer: None };
            assert!(spheres.check(&method, limit).is_ok());
            let refused = spheres.check(&method, limit + 1);
            assert!(matches!(refused, Err(Error::TooManySpheres { limit: most, .. }) if most == limit), "{refused:?}");
        }
    }
}
