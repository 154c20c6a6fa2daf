//! Soft points as spheres in the A-buffer: `soft-base` and `soft-concentric`.
//!
//! A pixel's list holds events: where its ray enters and leaves each sphere, or each of its shells, cut at near and at
//! the solid points. An event is a fragment of the A-buffer, depth key and index, the latter with the shell and a bit
//! that tells exits. All else follows from the sphere while blending, so that counting, storing and sorting are those
//! of other lists.
//!
//! Short lists are gone through by one invocation. `soft-base` keeps the open spheres in an array that half of the
//! events fill at most; `soft-concentric` needs sums only. Of long lists, each run is composed by itself: colors and
//! constant densities are running sums, whose value before each run follows from what the runs before add; the
//! integrals of `soft-base` are taken for each segment from all spheres that may reach it, wherever they lie in the
//! list.

mod interior;
mod long_lists;
mod passes;

pub use interior::{Interior, SphereKind};
pub(in crate::methods) use long_lists::record_carry;
pub use passes::*;

use self::interior::MODEL_BASE;
use self::long_lists::{run_variant, segments_variant};
use super::SoftModel;
use crate::methods::abuffer::{
    self, Blending, Bodies, Counting, LOCAL_LENGTH, Needs, Sampled, Sorting, StoreFragments, Storing, occurring,
};
use crate::methods::prelude::*;
use crate::methods::splats;

/// Names of the kernels by the classes of [`abuffer::CLASSES`]; there is no list of a single event.
pub const RESOLVE: [&str; 7] = [
    "",
    "soft/resolve-4",
    "soft/resolve-8",
    "soft/resolve-16",
    "soft/resolve-32",
    "soft/resolve-128",
    "soft/resolve-256",
];
/// Returns each class of list lengths that events come in, by its number: the longest list and the name of its kernel.
pub fn classes() -> impl Iterator<Item = (usize, (u32, &'static str))> {
    let names = abuffer::CLASSES.into_iter().zip(RESOLVE).map(|((capacity, _), name)| (capacity, name));
    names.enumerate().skip(1)
}

/// Device bytes per pixel of the number of spheres, where these have shells.
pub const SPHERES_BYTES: u64 = 4;

/// Constants that shaders share with this module.
pub(crate) const CONSTANTS: [(&str, u32); 1] = [("MODEL_BASE", MODEL_BASE)];

/// The soft points of a window.
#[derive(Clone, Copy)]
pub struct Spheres<'a> {
    /// The kind of spheres.
    pub kind: SphereKind,
    /// Model of the density of spheres.
    pub model: SoftModel,
    /// Largest world radius.
    pub max_radius: f32,
    /// The depth that those of solid points are relative to.
    pub origin: f32,
    /// The pixels of the solid points, if any.
    pub layer: Option<&'a Layer>,
}

impl Spheres<'_> {
    /// Refuses more points than events can tell apart.
    pub fn check(&self, method: &Method, points: u64) -> Result<(), Error> {
        let limit = self.kind.interior.most_points();
        if points > limit {
            let shells = self.kind.interior.most_shells();
            return Err(Error::TooManySpheres { points, method: method.name(), shells, limit });
        }
        Ok(())
    }

    /// Push constants of the kernels.
    pub fn push(&self, class_index: u32, first_fragment: u32, max_color: f32) -> SoftPush {
        let SoftModel { lambda, peak, equalize } = self.model;
        let (max_radius, equalize) = (self.max_radius, u32::from(equalize));
        SoftPush { class_index, first_fragment, max_color, lambda, peak, equalize, max_radius, first: 0 }
    }

    /// Depths of the solid points; anything where there are none, since nobody reads it then.
    fn solids<'b>(&'b self, other: Slice<'b, u32>) -> Slice<'b, f32> {
        self.layer.map_or(other.cast(), Layer::depths)
    }
}

impl StoreFragments for Spheres<'_> {
    fn name(&self) -> &'static str {
        "soft/store"
    }

    fn bodies(&self) -> Bodies {
        if self.kind.interior.counted() { Bodies::Counted } else { Bodies::Halves }
    }

    fn needs(&self) -> Needs {
        let interior = self.kind.interior;
        let (records, segments) = (interior == Interior::Packed, interior.is_integrated());
        Needs { records, sums: true, segments, ..Needs::default() }
    }

    fn pixel_bytes(&self) -> u64 {
        pixel_bytes(self.kind.interior, self.layer.is_some())
    }

    /// A sample may begin at each event.
    fn most_samples(&self, fragments: u64, _bodies: u64) -> u64 {
        fragments
    }

    fn record_count<'a>(&'a self, recorder: &mut Recorder<'a>, counting: Counting<'a>) -> Result<(), Error> {
        let Counting { raster, counts, bodies: spheres } = counting;
        raster.record_tiles(recorder)?;
        let whole = Band::whole(raster.window, 0);
        let solids = self.solids(counts);
        let stage = |chunk: Chunk<'a>| Count { chunk, solids, counts, spheres };
        let with = |variant| count_variant(variant, self.kind.interior, self.layer.is_some());
        Ok(raster.record_with(recorder, &whole, stage, None, with)?)
    }

    fn record_store<'a>(&'a self, recorder: &mut Recorder<'a>, storing: Storing<'a>) -> Result<(), Error> {
        let Storing { raster, band, room, .. } = storing;
        let (cursors, fragments) = (room.counts.get().all(), room.fragments.get().all());
        let (solids, records) = (self.solids(cursors), room.records.get().all());
        let stage = |chunk: Chunk<'a>| {
            let colors = raster.colors_of(&chunk);
            Store { chunk, solids, cursors, fragments, colors, records }
        };
        let with = |variant| store_variant(variant, self.kind.interior, self.layer.is_some());
        Ok(raster.record_with(recorder, &band, stage, None, with)?)
    }

    fn record_blend<'a>(&'a self, recorder: &mut Recorder<'a>, blending: &Blending<'a>) -> Result<(), Error> {
        let Blending { blender, target, .. } = *blending;
        let (longest, stop, records) = (blending.lengths.longest, blending.job.stop, blending.stored.records);
        // There is no list of one event.
        let present = || occurring(classes(), longest);
        let lists = blender.record_sorted_classes(recorder, blending, present())?;
        for (index, (capacity, name)) in present() {
            let push = self.push(index as u32, blending.band.first_fragment, stop.1);
            let sorting = blender.sorting(capacity);
            let kernel = resolve_variant(self.kind, blending.stored.cut, stop.0, sorting, capacity);
            let run = blender.over_class(index).label(name).variant(kernel);
            match sorting {
                Sorting::Network => recorder.run(&ResolveNetwork { lists, records }, push, &run)?,
                Sorting::Merge => recorder.run(&ResolveMerge { lists, records }, push, &run)?,
                Sorting::Group => recorder.run(&ResolveSorted { lists, records }, push, &run)?,
            }
        }
        let Some(sorted) = blender.record_long_lists(recorder, blending)? else { return Ok(()) };
        long_lists::record(recorder, self, &sorted, blender.long(), longest)?;
        blender.record_combine(recorder, abuffer::Shown::First, target)
    }

    fn record_samples<'a>(
        &'a self,
        recorder: &mut Recorder<'a>,
        blending: &Blending<'a>,
        _bodies: bool,
        samples: Sampled<'a>,
    ) -> Result<(), Error> {
        let blender = blending.blender;
        let sorted = blender.record_every_list(recorder, blending)?;
        let sums = (blending.lengths.longest > LOCAL_LENGTH, blender.long().sums.get().all());
        long_lists::record_samples(recorder, self, &sorted, sums, samples)
    }

    /// Solid points are behind all soft ones of their pixels.
    fn record_behind<'a>(&'a self, recorder: &mut Recorder<'a>, target: &'a Target, pixels: u64) -> Result<(), Error> {
        match self.layer {
            Some(layer) => record_compose(recorder, layer, target, pixels, self.origin),
            None => Ok(()),
        }
    }
}

/// Returns device bytes per pixel beside those of lists, those by which the solid points were drawn included.
pub fn pixel_bytes(interior: Interior, solids: bool) -> u64 {
    let layer = if solids { Layer::PIXEL_BYTES + splats::PIXEL_BYTES } else { 0 };
    layer + if interior.counted() { SPHERES_BYTES } else { 0 }
}

/// Records a window's solid points behind the pixels of the target.
pub fn record_compose<'a>(
    recorder: &mut Recorder<'a>,
    layer: &'a Layer,
    target: &'a Target,
    pixels: u64,
    origin: f32,
) -> Result<(), Error> {
    let compose = Compose { solid_image: layer.image(), solid_depths: layer.depths(), into: target.pixels() };
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

/// The variant of the kernel for lists of up to `capacity` events, which are sorted as told.
fn resolve_variant(kind: SphereKind, cut: Cut, stop: u32, sorting: Sorting, capacity: u32) -> Variant {
    let integrated = kind.interior.is_integrated();
    let piece = if integrated { "blend_spheres" } else { "blend_shells" };
    let variant = run_variant(kind, cut).with("STOP", stop).walker(piece);
    let kernel = sorting.resolve_variant(variant, capacity);
    // Merge sort has its capacity already; without a list of one's own, only the spheres that are open ask for one.
    let asked = sorting == Sorting::Network || sorting == Sorting::Group && integrated;
    if asked { kernel.constant("CAPACITY", capacity) } else { kernel }
}

/// Returns the passes with their variants.
pub(super) fn shaders() -> Vec<Shader> {
    let walked = |of: fn(Variant, Interior, bool) -> Variant| {
        let spheres = || raster::computed_variants(&[Footprint::Sphere, Footprint::ExactSphere]);
        let of = |(interior, cut)| spheres().into_iter().map(move |walker| of(walker, interior, cut));
        <(Interior, bool)>::all().into_iter().flat_map(of).collect::<Vec<_>>()
    };
    let blended = |of: &dyn Fn(SphereKind, Cut) -> Vec<Variant>| {
        <(SphereKind, Cut)>::all().into_iter().flat_map(|(kind, cut)| of(kind, cut)).collect::<Vec<_>>()
    };
    let kernels = |sorting, capacity| {
        blended(&|kind, cut| STOPS.map(|stop| resolve_variant(kind, cut, stop, sorting, capacity)).to_vec())
    };
    let runs = || blended(&|kind, cut| vec![run_variant(kind, cut)]);
    vec![
        Shader::new::<Count>(walked(count_variant)),
        Shader::new::<Store>(walked(store_variant)),
        Shader::new::<ResolveNetwork>(Sorting::Network.kernels(|sorting, capacity| {
            // There is no list of one event.
            if capacity > 1 { kernels(sorting, capacity) } else { Vec::new() }
        })),
        Shader::new::<ResolveMerge>(Sorting::Merge.kernels(kernels)),
        Shader::new::<ResolveSorted>(Sorting::Group.kernels(kernels)),
        Shader::new::<SumRuns>(runs()),
        Shader::plain::<Carry>(),
        Shader::new::<Segments>(blended(&|kind, cut| vec![segments_variant(kind, cut)])),
        Shader::new::<BlendRuns>(runs()),
        Shader::new::<Samples>(runs()),
        Shader::plain::<Compose>(),
    ]
}

#[cfg(test)]
mod tests {
    use super::long_lists::SEGMENTS_TAKEN;
    use super::*;
    use crate::methods::abuffer::LOCAL_LENGTH;
    use crate::passes::tiles::PAIR_RUN;
    use crate::scene::{MAX_SHELLS, Shells, Soft};

    /// Iterations of all loops of an invocation together: one driver ends loops silently after 65 535.
    const MOST_ITERATIONS: u32 = 60_000;

    #[test]
    fn loops_are_within_the_iterations() {
        const {
            // Four pixels of each pair, and groups of four of the shells after the first.
            assert!(PAIR_RUN * (1 + 4 * (1 + (MAX_SHELLS - 1).div_ceil(4))) < MOST_ITERATIONS);
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
            let model = SoftModel { lambda: 1.0, peak: 0.5, equalize: true };
            let kind = SphereKind { interior, exact: false, modulated: false };
            let spheres = Spheres { kind, model, max_radius: 1.0, origin: 0.0, layer: None };
            assert!(spheres.check(&method, limit).is_ok());
            let refused = spheres.check(&method, limit + 1);
            assert!(matches!(refused, Err(Error::TooManySpheres { limit: most, .. }) if most == limit), "{refused:?}");
        }
    }
}
