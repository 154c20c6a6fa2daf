//! Approximations of transparency that keep a few sums for each pixel, most of which go through tiles of splats once:
//! `weighted`, `average`, `unsorted`, `hybrid` and `mlab`. Sums are compensated, so that neither the number of
//! fragments nor where a run over a tile's splats ends shows in them.

mod engine;
mod tail;

pub(crate) use engine::ApproximateEngine;
pub use tail::{GatherTail, TailPush, WeighTail};

use self::tail::Tail;
use super::fading;
use super::tiled::{self, SMALL_WINDOW, STATE_BYTES, SumPush, Sums, SumsGroup};
use crate::methods::prelude::*;
use crate::scene::{MAX_NODES, MomentCount};

gpu_struct! {
    /// Push constants of `hybrid`: number of fragments that are composed exactly, and the least opacity of one.
    pub struct HybridPush {
        walk: TileWalk,
        k: u32, // Fragments that are composed exactly, and the least opacity of one.
        core_alpha_min: f32,
    }

    /// Push constants of a round of `hybrid` over oriented discs, which composes as many fragments as it has slots.
    pub struct RoundPush {
        walk: TileWalk,
        core_alpha_min: f32, // The least opacity of a fragment that is composed exactly.
    }

    /// Push constants of `mlab`; `unused` slots stay empty.
    pub struct LayerPush {
        walk: TileWalk,
        unused: u32, // Slots that stay empty: the first ones.
    }
}

pass! {
    /// Sums the splats of a tile with weights that fall with depth: one subgroup per block of a tile keeps the sums of
    /// its pixels in registers and finds the pixels from them. A run takes 2048 splats, and the next goes on from the
    /// sums.
    pub Weighted(SumPush) = "weighted/accumulate" in "approximate/weighted",
    /// Averages the colors of the splats over each pixel, as `weighted/accumulate` goes through a tile.
    pub Average(SumPush) = "average/accumulate" in "approximate/average",
    /// Blends the splats of each pixel in the order of the files, as `weighted/accumulate` goes through a tile.
    pub Unsorted(SumPush) = "unsorted/accumulate" in "approximate/unsorted",
    /// Composes the first `k` fragments of each pixel front to back and sums the others, over flat discs.
    pub HybridFlat(HybridPush) = "hybrid/accumulate" in "approximate/hybrid" {
        tiles: Shared<TiledGroup>,
        sums: Shared<SumsGroup>,
    }

    /// Composes the first `k` fragments of each pixel front to back before a tail by moments, over flat discs.
    pub HybridFront(HybridPush) = "hybrid/accumulate" in "approximate/hybrid_front" {
        tiles: Shared<TiledGroup>,
        sums: Shared<SumsGroup>,
        lasts: ReadWrite<[u32; 2]>,
    }

    /// Keeps the 8 nearest fragments of each pixel in slots by insertion, over oriented discs: one subgroup per block
    /// of a tile goes through it region by region. It runs once for every 8 of `k`; fragments that fall out in the last
    /// round are summed.
    pub HybridOriented(RoundPush) = "hybrid/accumulate" in "approximate/hybrid_oriented" {
        tiles: Shared<TiledGroup>,
        sums: Shared<SumsGroup>,
        lasts: ReadWrite<[u32; 2]>,
        slots: ReadWrite<[u32; 4]>,
    }

    /// Keeps the nearest fragments of each pixel in slots by insertion, in the order of the files, and merges what
    /// falls out of them into one last layer: region by region, as `hybrid/accumulate` over oriented discs.
    pub Layers(LayerPush) = "mlab/accumulate" in "mlab/accumulate" {
        tiles: Shared<TiledGroup>,
        sums: Shared<SumsGroup>,
        slots: ReadWrite<[u32; 4]>,
    }
}

/// Slots for the nearest fragments of a pixel: in registers, hence few.
const MOST_SLOTS: u32 = 8;
/// Slots that `mlab` has beside its last layer, in variants of a shader: some may stay empty.
const LAYER_SLOTS: [u32; 4] = [1, 3, 7, 15];
const _: () = assert!(MAX_NODES <= LAYER_SLOTS[3] + 1);
/// Bytes of a slot between two runs; one more holds where the round begins.
const SLOT_BYTES: u64 = 32;
/// Bytes of the rank of the last fragment that is composed.
const LAST_BYTES: u64 = 8;

/// An approximation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ApproximateKind {
    /// `weighted`
    Weighted,
    /// `average`
    Average,
    /// `unsorted`
    Unsorted,
    /// `hybrid`
    Hybrid {
        /// So many fragments are composed exactly.
        k: u32,
        /// The least opacity of one.
        core_alpha_min: f32,
        /// Number of moments that weight the other fragments; `None` averages these.
        tail: Option<MomentCount>,
    },
    /// `mlab`, with so many layers.
    Mlab(u32),
}

impl ApproximateKind {
    /// Slots of each round of `hybrid` over splats that may cross, the last of which has a tail, and of the only one of
    /// `mlab`. Empty for all else.
    fn rounds(self, footprint: Footprint) -> Vec<u32> {
        match self {
            Self::Hybrid { k, .. } if footprint.may_cross() => rounds(k),
            Self::Mlab(nodes) => vec![layer_slots(nodes)],
            _ => Vec::new(),
        }
    }

    /// Moments of the tail.
    fn tail(self) -> Option<MomentCount> {
        let Self::Hybrid { tail, .. } = self else { return None };
        tail
    }

    /// Device bytes of a pixel from stage to stage.
    fn kept_bytes(self, rounds: &[u32]) -> u64 {
        self.tail().map_or_else(|| round_bytes(rounds), tail::pixel_bytes)
    }

    /// The most runs over all tiles that it takes to get a stage through the longest list.
    fn runs_over(self, binned: Binned, rounds: &[u32]) -> u32 {
        let runs = runs_over(binned, rounds);
        if self.tail().is_some() { binned.region_segments().max(runs) } else { runs }
    }
}

/// k fragments in rounds of as many slots as there are.
fn rounds(k: u32) -> Vec<u32> {
    (0..k).step_by(MOST_SLOTS as usize).map(|first| MOST_SLOTS.min(k - first)).collect()
}

/// Slots for all but the last of so many layers.
fn layer_slots(nodes: u32) -> u32 {
    LAYER_SLOTS.into_iter().find(|slots| slots + 1 >= nodes).unwrap_or(MAX_NODES - 1)
}

/// Returns the number of device bytes of a pixel that a method always needs.
pub fn pixel_bytes(kind: ApproximateKind) -> u64 {
    match kind {
        ApproximateKind::Hybrid { tail: Some(moments), .. } => tail::pixel_bytes(moments),
        ApproximateKind::Hybrid { k, tail: None, .. } => round_bytes(&rounds(k)),
        _ => 0,
    }
}

/// Device bytes of a pixel between two rounds that have a tail at once.
fn round_bytes(rounds: &[u32]) -> u64 {
    if rounds.len() > 1 { LAST_BYTES } else { 0 }
}

/// Device bytes of a pixel between two runs over a tile's splats.
fn run_bytes(rounds: &[u32]) -> u64 {
    STATE_BYTES + rounds.first().map_or(0, |slots| 16 + SLOT_BYTES * u64::from(*slots))
}

fields! {
    /// Buffers, kept from frame to frame.
    pub struct Approximations {
        state: Scratch<[f32; 4]> = Scratch::new("sums of pixels", Memory::Device),
        lasts: Scratch<[u32; 2]> = Scratch::new("last ranks of pixels", Memory::Device),
        slots: Scratch<[u32; 4]> = Scratch::new("nearest fragments of pixels, by slot", Memory::Device),
        moments: Scratch<[f32; 2]> = Scratch::new("moments of tails", Memory::Device),
    }
}

impl Approximations {
    /// Bins a window's splats and accumulates them into the target.
    pub(crate) fn render(
        &mut self,
        bins: &mut Bins,
        work: &mut Work<'_>,
        mut bin: bin::Job<'_>,
        engine: &ApproximateEngine,
    ) -> Result<Outcome, Error> {
        let (device, frame, target, pixels) = (work.device, work.frame, work.target, work.pixels());
        let (kind, raster) = (engine.kind, bin.raster);
        let rounds = kind.rounds(raster.footprint);
        bin.counted_bytes += pixels * kind.kept_bytes(&rounds) + pixels.min(SMALL_WINDOW) * run_bytes(&rounds);
        let small = SMALL_WINDOW * run_bytes(&rounds);
        tiled::blend(bins, work, (&bin, small), "accumulate", |bins, work, binned| {
            let kept = kind.runs_over(binned, &rounds) > 1;
            if kept && pixels > SMALL_WINDOW {
                let left = bin.budget.left(bin.counted_bytes).saturating_sub(bins.bytes());
                if pixels * run_bytes(&rounds) > left.min(bin.budget.binding) {
                    return Ok(None);
                }
            }
            self.reserve(device, pixels, kept, &rounds, kind.tail())?;
            let mut recorder = work.timeline.recorder(device)?;
            self.record(bins, &mut recorder, (raster, engine, frame.depth_range()), binned, &rounds, target)?;
            Ok(Some(recorder))
        })
    }

    fn reserve(
        &mut self,
        device: &Device,
        pixels: u64,
        kept: bool,
        rounds: &[u32],
        tail: Option<MomentCount>,
    ) -> Result<(), Error> {
        let kept = if kept { pixels } else { 0 };
        self.state.reserve(device, (kept * STATE_BYTES / 16).max(1))?;
        let slots = rounds.first().map_or(0, |slots| 1 + 2 * u64::from(*slots));
        self.slots.reserve(device, (kept * slots).max(1))?;
        self.lasts.reserve(device, if rounds.len() > 1 || tail.is_some() { pixels } else { 1 })?;
        self.moments.reserve(device, tail.map_or(1, |moments| pixels * fading::pairs(moments)))?;
        Ok(())
    }

    /// Records the stage of the method over all tiles.
    fn record<'a>(
        &'a self,
        bins: &'a Bins,
        recorder: &mut Recorder<'a>,
        (raster, engine, depth_range): (Raster<'a>, &ApproximateEngine, [f32; 2]),
        binned: Binned,
        rounds: &[u32],
        target: &'a Target,
    ) -> Result<(), Error> {
        let tiles = bins.record_tiles(recorder, raster.cloud, binned)?.tiled;
        let sums = Sums { into: target.pixels(), kept: self.state.get().all() };
        let shape = compose::variant(binned.cut(), raster.footprint, engine.discs.falloff);
        let (lasts, slots, runs) = (self.lasts.get().all(), self.slots.get().all(), runs_over(binned, rounds));
        let push = |walk| SumPush { walk };
        let sum = &bin::fold_blocks_variant(shape.clone(), binned.lanes());
        match engine.kind {
            ApproximateKind::Weighted => binned.record_runs(recorder, &Weighted { tiles, sums }, runs, push, sum)?,
            ApproximateKind::Average => binned.record_runs(recorder, &Average { tiles, sums }, runs, push, sum)?,
            ApproximateKind::Unsorted => binned.record_runs(recorder, &Unsorted { tiles, sums }, runs, push, sum)?,
            ApproximateKind::Mlab(nodes) => {
                let count = layer_slots(nodes);
                let push = |walk| LayerPush { walk, unused: count + 1 - nodes };
                let layers = layer_variant(shape, binned.lanes(), count);
                binned.record_runs(recorder, &Layers { tiles, sums, slots }, runs, push, &layers)?;
            }
            ApproximateKind::Hybrid { k, core_alpha_min, tail } => {
                let push = |walk| HybridPush { walk, k, core_alpha_min };
                match tail {
                    None if rounds.is_empty() => {
                        binned.record_runs(recorder, &HybridFlat { tiles, sums }, runs, push, sum)?;
                    }
                    Some(_) if rounds.is_empty() => {
                        binned.record_runs(recorder, &HybridFront { tiles, sums, lasts }, runs, push, sum)?;
                    }
                    _ => {
                        let push = |walk| RoundPush { walk, core_alpha_min };
                        let oriented = HybridOriented { tiles, sums, lasts, slots };
                        for (i, slots) in rounds.iter().enumerate() {
                            let averaged = tail.is_none() && i + 1 == rounds.len();
                            let round = Round { slots: *slots, behind: i > 0, tail: averaged };
                            let variant = round_variant(shape.clone(), binned.lanes(), round);
                            binned.record_runs(recorder, &oriented, runs, push, &variant)?;
                        }
                    }
                }
                if let Some(moments) = tail {
                    let known = self.moments.get().all();
                    let tail = Tail { tiles, sums, lasts, known, moments, core_alpha_min, depth_range };
                    tail.record(recorder, binned, &shape)?;
                }
            }
        }
        Ok(())
    }
}

/// A round of `hybrid` over oriented discs.
#[derive(Debug, Clone, Copy)]
pub struct Round {
    /// Fragments that it composes.
    pub slots: u32,
    /// `true` if other runs came before.
    pub behind: bool,
    /// `true` if it is the last one, and what falls out of it is averaged.
    pub tail: bool,
}

/// Runs over all tiles that it takes to get through the longest list.
fn runs_over(binned: Binned, rounds: &[u32]) -> u32 {
    if rounds.is_empty() { binned.segments() } else { binned.region_segments() }
}

/// A variant of `hybrid` over oriented discs.
fn round_variant(shape: Variant, lanes: Lanes, round: Round) -> Variant {
    bin::region_variant(shape, lanes)
        .with("BEHIND", u32::from(round.behind))
        .with("TAIL", u32::from(round.tail))
        .constant("SLOTS", round.slots)
        .each("slot", round.slots)
}

/// A variant of `mlab`.
fn layer_variant(shape: Variant, lanes: Lanes, slots: u32) -> Variant {
    bin::region_variant(shape, lanes).constant("SLOTS", slots).each("slot", slots)
}

/// Returns the number of bytes that a stage must at least read and write: `tilted` whether discs are oriented. Of
/// splats each pair with a tile, in each round, and the window's pixels.
pub fn least_bytes(name: &str, facts: &Facts, kind: ApproximateKind, tilted: bool, pixels: u64) -> Option<u64> {
    // Index, then splat, depth and color.
    let splat = 4 + 16 + 4 + 16 + if tilted { 16 } else { 0 };
    if let ApproximateKind::Hybrid { tail: Some(moments), .. } = kind
        && matches!(name, "hybrid/gather" | "hybrid/weigh")
    {
        // A tail is known by moments that one stage leaves and the other reads, with the image in front of it.
        let (color, image) = if name == "hybrid/gather" { (12, 0) } else { (0, 36) };
        return Some(facts.tile_entries * (splat - color) + pixels * (tail::pixel_bytes(moments) + image));
    }
    if !name.ends_with("/accumulate") {
        return None;
    }
    let rounds = match kind {
        ApproximateKind::Hybrid { k, .. } if tilted => rounds(k).len() as u64,
        _ => 1,
    };
    Some(rounds * (facts.tile_entries * splat + pixels * 20))
}

/// Returns the passes with their variants.
pub fn shaders() -> Vec<Shader> {
    let sums = |footprints: &[Footprint]| {
        bin::tile_variants(compose::variants_of(footprints), &[()], |shape, lanes, ()| {
            bin::fold_blocks_variant(shape, lanes)
        })
    };
    // The last round, which is the first one or not, has the slots that are left, and a tail or not.
    let flags = [false, true].into_iter().flat_map(|behind| [false, true].map(|tail| (behind, tail)));
    let round = |slots| flags.clone().map(move |(behind, tail)| Round { slots, behind, tail });
    let rounds: Vec<Round> = (1..=MOST_SLOTS).rev().flat_map(round).collect();
    let (crossing, flat): (Vec<Footprint>, Vec<Footprint>) = DISCS.iter().partition(|disc| disc.may_cross());
    let [gather, weigh] = tail::shaders();
    vec![
        Shader::new::<Weighted>(sums(&DISCS)),
        Shader::new::<Average>(sums(&DISCS)),
        Shader::new::<Unsorted>(sums(&DISCS)),
        Shader::new::<HybridFlat>(sums(&flat)),
        Shader::new::<HybridFront>(sums(&flat)),
        Shader::new::<HybridOriented>(bin::tile_variants(compose::variants_of(&crossing), &rounds, round_variant)),
        gather,
        weigh,
        Shader::new::<Layers>(bin::tile_variants(compose::variants(), &LAYER_SLOTS, layer_variant)),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::MAX_K;

    #[test]
    fn rounds_have_room_for_all_fragments() {
        assert_eq!(rounds(1), [1]);
        assert_eq!(rounds(8), [8]);
        assert_eq!(rounds(9), [8, 1]);
        assert_eq!(rounds(24), [8, 8, 8]);
        assert!((1..=MAX_K).all(|k| rounds(k).iter().sum::<u32>() == k));
        assert_eq!(pixel_bytes(ApproximateKind::Hybrid { k: 9, core_alpha_min: 0.0, tail: None }), 8);
        assert_eq!(pixel_bytes(ApproximateKind::Hybrid { k: 8, core_alpha_min: 0.0, tail: None }), 0);
        assert_eq!(
            pixel_bytes(ApproximateKind::Hybrid { k: 8, core_alpha_min: 0.0, tail: Some(MomentCount::Eight) }),
            10 * 8 + 8
        );
        assert_eq!((run_bytes(&[]), run_bytes(&[8, 1])), (64, 64 + 16 + 8 * 32));
    }

    #[test]
    fn every_number_of_layers_has_its_slots() {
        assert_eq!([1, 2, 3, 4, 5, 8, 9, 16].map(layer_slots), [1, 1, 3, 3, 7, 7, 15, 15]);
        assert!((1..=MAX_NODES).all(|nodes| layer_slots(nodes) + 1 >= nodes));
        assert_eq!(pixel_bytes(ApproximateKind::Mlab(16)), 0);
    }

    #[test]
    fn least_bytes_by_hand() {
        let facts = Facts { tile_entries: 20, ..Facts::default() };
        let of = |kind, tilted| least_bytes("hybrid/accumulate", &facts, kind, tilted, 100);
        assert_eq!(of(ApproximateKind::Average, false), Some(20 * 40 + 2000));
        let hybrid = ApproximateKind::Hybrid { k: 9, core_alpha_min: 0.0, tail: None };
        assert_eq!(of(hybrid, false), Some(20 * 40 + 2000));
        assert_eq!(of(hybrid, true), Some(2 * (20 * 56 + 2000)));
        let by_moments = ApproximateKind::Hybrid { k: 9, core_alpha_min: 0.0, tail: Some(MomentCount::Four) };
        assert_eq!(of(by_moments, false), Some(20 * 40 + 2000));
        let stage = |name| least_bytes(name, &facts, by_moments, true, 100);
        // 6 pairs of floats, and the last rank.
        assert_eq!(stage("hybrid/gather"), Some(20 * 44 + 100 * 56));
        assert_eq!(stage("hybrid/weigh"), Some(20 * 56 + 100 * (56 + 36)));
        assert_eq!(least_bytes("hybrid/gather", &facts, hybrid, true, 100), None);
        assert_eq!(least_bytes("sorted/blend", &facts, hybrid, true, 100), None);
    }
}
