//! `soft-express` (Seemann et al. 2018, Section 3.3): soft points as discs that face the viewer, blended front to back
//! in the order in which they lie along the axis nearest to the viewing direction. That order is made once for a cloud,
//! so that a frame sorts nothing; it is the order of depth for orthographic views along an axis, and close to it
//! otherwise.

use super::{SoftModel, record_compose};
use crate::methods::prelude::*;
use crate::passes::compose::STOP_NEVER;

gpu_struct! {
    /// Push constants of `soft/express`.
    pub struct ExpressPush {
        walk: TileWalk,
        peak: f32, // Opacity in the middle of a disc, Seemann's lambda.
        max_color: f32, // Largest color component, background included: a bound of the splats behind.
    }
}

pass! {
    /// Composes the soft discs of a tile before the solid points, in the order of an axis: one subgroup per tile hands
    /// them from lane to lane and keeps pixels in registers. A run takes 2048 splats, and the next goes on from the
    /// image.
    pub Express(ExpressPush) = "soft/express" {
        tiles: Shared<TiledGroup>,
        solid: Read<f32>,
        into: Shared<PixelsGroup>,
        counts: ReadWrite<u32>,
    }
}

/// Device bytes of a pixel's count.
pub const COUNT_BYTES: u64 = 4;

/// Everything that stays the same while a window is rendered.
#[derive(Clone, Copy)]
pub struct SoftDiscsJob<'a> {
    /// The splats to bin: the soft points, along an axis ([`bin::Order::Along`]).
    pub bin: bin::Job<'a>,
    /// λ, the opacity in the middle of a disc.
    pub model: SoftModel,
    /// `true` if any point may have a W below 1 (Eq. 22).
    pub modulated: bool,
    /// The window's solid points, if there are any. Discs are drawn where their depth is less.
    pub layer: Option<&'a Layer>,
    /// Upper bound of the color components that are blended.
    pub max_color: f32,
}

fields! {
    /// Buffers, kept from frame to frame.
    pub struct SoftDiscs {
        counts: Scratch<u32> = Scratch::new("soft discs of pixels", Memory::Device),
        told: Told<u32> = Told::new("soft discs of pixels, host"),
        counted: Vec<u32> = Vec::new(),
    }
}

impl SoftDiscs {
    /// Bins a window's soft points, and blends them and the solid ones behind them into the target.
    pub(crate) fn render(
        &mut self,
        bins: &mut Bins,
        work: &mut Work<'_>,
        job: &SoftDiscsJob<'_>,
    ) -> Result<Outcome, Error> {
        let (device, frame, target) = (work.device, work.frame, work.target);
        // Then nothing is left out.
        let counted = frame.fragments;
        let window = job.bin.raster.window;
        let pixels = bands::pixels(window);
        self.counts.reserve(device, if counted { pixels } else { 1 })?;
        self.counted.clear();
        self.told.reserve(device, if counted { pixels } else { 0 })?;
        let mut recorder;
        let binned = match bins.bin(device, &job.bin, work.timeline)? {
            Bin::TooLarge => return Ok(Outcome::Overflow),
            Bin::Nothing => {
                recorder = work.timeline.recorder(device)?;
                target.pixels().record_nothing(&mut recorder, window)?;
                None
            }
            Bin::Done(binned) => {
                work.note_binned(binned);
                work.facts.bands += 1;
                recorder = work.timeline.recorder(device)?;
                self.record_blend(bins, &mut recorder, frame, job, binned, target)?;
                Some(binned)
            }
        };
        if let Some(layer) = job.layer {
            record_compose(&mut recorder, layer, target, pixels, 0.0)?;
        }
        self.told.record(&mut recorder, self.counts.get());
        target.record_read_back(&mut recorder, pixels)?;
        work.timeline.submit(recorder, "soft/express")?;
        if counted {
            work.progress.check()?;
            self.counted = match binned {
                Some(_) => self.told.read(self.counts.get(), pixels)?,
                None => vec![0; pixels as usize],
            };
            let facts = &mut *work.facts;
            facts.fragments += self.counted.iter().map(|n| u64::from(*n)).sum::<u64>();
            facts.max_list = facts.max_list.max(self.counted.iter().copied().max().unwrap_or(0));
        }
        Ok(Outcome::Done)
    }

    /// Returns the discs of each pixel of the last window, row by row, if they were counted.
    pub fn counts(&self) -> &[u32] {
        &self.counted
    }

    /// Records the blending of all tiles.
    fn record_blend<'a>(
        &'a self,
        bins: &'a Bins,
        recorder: &mut Recorder<'a>,
        frame: &Frame,
        job: &SoftDiscsJob<'a>,
        binned: Binned,
        target: &'a Target,
    ) -> Result<(), Error> {
        let cloud = job.bin.raster.cloud;
        // Without solid points the shader does not look at their depths.
        let solid = job.layer.map_or(cloud.fields.all(), Layer::depths);
        let tiles = bins.record_tiles(recorder, cloud, binned)?.tiled;
        let counts = self.counts.get().all();
        let express = Express { tiles, solid, into: target.pixels(), counts };
        let (stop, max_color) = compose::stop(frame.stop, frame.color, job.max_color);
        let (modulated, counted) = (job.modulated, frame.fragments);
        let kind = ExpressKind { stop, cut: job.layer.is_some(), modulated, counted };
        let variant = express_variant(compose::disc_variant(binned.cut()), binned.lanes(), kind);
        let over = Run::new(binned.over_tiles()).variant(variant);
        let segments = binned.segments();
        (0..segments).try_for_each(|segment| {
            let push = ExpressPush { walk: binned.walk(segment, segments), peak: job.model.lambda, max_color };
            Ok(recorder.run(&express, push, &over)?)
        })
    }
}

/// Properties on which a variant of `soft/express` depends.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ExpressKind {
    /// `STOP` in WGSL, from [`compose::stop`].
    pub stop: u32,
    /// `true` if solid points cut it.
    pub cut: bool,
    /// `true` if some W are below 1.
    pub modulated: bool,
    /// `true` if discs are counted, so that none is left out.
    pub counted: bool,
}

/// A variant of `soft/express`, from that of flat discs.
fn express_variant(flat: Variant, lanes: Lanes, kind: ExpressKind) -> Variant {
    bin::fold_variant(flat, lanes)
        .with("STOP", if kind.counted { STOP_NEVER } else { kind.stop })
        .with("CUT", u32::from(kind.cut))
        .with("MODULATED", u32::from(kind.modulated))
        .with("COUNTED", u32::from(kind.counted))
}

/// Returns the pass with its variants.
pub(super) fn shaders() -> Vec<Shader> {
    let flags = <(bool, (bool, bool))>::all();
    let kinds: Vec<_> = flags
        .iter()
        .flat_map(|(cut, (modulated, counted))| {
            STOPS.map(|stop| ExpressKind { stop, cut: *cut, modulated: *modulated, counted: *counted })
        })
        .collect();
    let flat = Cut::all().into_iter().map(compose::disc_variant).collect();
    vec![Shader::new::<Express>(bin::tile_variants(flat, &kinds, express_variant))]
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    /// The shader's polynomial, with its rounding.
    fn profile(x: f32) -> f32 {
        let root = (1.0 - x) * (1.0 + x * (-0.233_699_32 + x * (0.019_957_643 - 0.000_863_812_3 * x)));
        root * root
    }

    #[test]
    fn the_polynomial_is_the_raised_cosine() {
        assert_eq!([profile(0.0), profile(1.0)], [1.0, 0.0]);
        let steps = 1 << 20;
        let mut worst = 0f64;
        for i in 0..=steps {
            let x = i as f32 / steps as f32;
            let exact = 0.5 * ((PI * f64::from(x).sqrt()).cos() + 1.0);
            worst = worst.max((f64::from(profile(x)) - exact).abs());
        }
        assert!(worst < 3e-7, "{worst}");
        // It falls all the way, apart from rounding, and stays within [0, 1].
        let falls =
            (0..steps).all(|i| profile((i + 1) as f32 / steps as f32) <= profile(i as f32 / steps as f32) + 1e-6);
        assert!(falls);
        // The numbers are those of the shader.
        let shader = include_str!("../../../shaders/shared/profile.wgsl");
        for digits in ["0.233699319", "0.0199576433", "0.000863812306"] {
            assert!(shader.contains(digits));
        }
    }
}
