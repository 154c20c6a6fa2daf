//! `spbr`, `spbr-simplified`: stochastic point-based rendering (Tanaka et al. 2016; Uchida et al. 2020).
//!
//! The points of each cloud are dealt to L ensembles ([`crate::prepare::ensembles`]). Each ensemble is an image of
//! opaque points with a depth test of its own; their mean is the image: no order of points is needed. The nearest
//! point of a pixel in an ensemble is found by atomic minima of depth and index, and colors are summed as whole
//! numbers, so that neither the order in which points come nor how many ensembles are drawn at once shows.
//!
//! A point asks for the area q² p t in pixels: q the width of a pixel at the depth of its cloud's middle over that at
//! its own (1 in orthographic views), p = ln(1 − α) / ln(1 − α of its cloud), t = |cos θ| between normal and view
//! unless `cos_theta`. Below 1 it is one pixel with that probability, above it a square.

mod engine;
pub mod rounds;
pub mod share;
pub mod stream;
mod tasks;

pub(crate) use engine::{EnsembleEngine, pass_group};

use std::iter::Peekable;
use std::ops::Range;

use self::rounds::{Epochs, Piece, epoch_bits};
use self::share::{Share, Wanted};
use self::stream::Stream;
use self::tasks::{Task, Tasks};
use super::engine::Work;
use super::{Error, Facts, Frame, Target, ThinCloud};
use crate::gpu::shader::{Choices, Shader};
use crate::gpu::{Device, Dispatch, Expected, Kept, Memory, Recorder, Run, Slice, Variant};
use crate::passes::bands::{self, Budget, Window};
use crate::passes::compose::Cut;
use crate::passes::project::{Column, DeviceCloud, Placed, Projecting, Shaded, View};
use crate::prepare::ensembles::slots;
use crate::random;
use crate::scene::{ColorSpace, Method, ShadingModel, Spbr};
use crate::{choices, gpu_struct, group, pass};

gpu_struct! {
    /// Push constants of the passes that go through slots; shaders/shared/spbr.wgsl says what the members are.
    pub struct SlotsPush {
        count: u32,
        first: u32,
        base: u32,
        list: u32,
        start: u32,
        around: u32,
        columns: u32,
        block_bits: u32,
        hand: u32,
        pass_word: u32,
        whole: u32,
        rest: u32,
        carry: u32,
        ensembles: u32,
        planes: u32,
        ensemble: u32,
        pixels: u32,
        epoch_bits: u32,
        epoch: u32,
        key_x: u32,
        key_y: u32,
        depth: f32,
        unit: f32,
        scale: f32,
        most: f32,
    }
}

gpu_struct! {
    /// What the passes count.
    pub struct Counters {
        visible_low: u32,
        visible_high: u32,
        large: u32,
        spare: u32,
    }
}

gpu_struct! {
    /// Push constants of `spbr/large`.
    pub struct LargePush {
        stripes: u32,
        most: u32,
    }
}

gpu_struct! {
    /// Push constants of `spbr/resolve`: pixels of the window, ensembles, and what a color of 1 is in the sums.
    pub struct ResolvePush {
        pixels: u32,
        ensembles: u32,
        scale: f32,
    }
}

group! {
    /// What a pass that goes through slots binds of the points.
    pub Slots as SlotsGroup {
        /// The camera.
        camera: Uniform<View>,
        /// Positions, rounded.
        points_hi: Read<[f32; 4]>,
        /// The rest of the positions.
        points_lo: Read<[f32; 4]>,
        /// Normals; a single one if there are none.
        normals: Read<[f32; 4]>,
        /// What the passes count.
        counters: ReadWrite<Counters>,
        /// Large squares of a dispatch.
        large: ReadWrite<[u32; 4]>,
    }
}

pass! {
    /// Takes the 64-bit atomic maximum of epoch, complement of the depth key and complement of the point index at each
    /// pixel that a slot's point covers, in the ensemble's plane. The value that it replaces tells whose color to take
    /// back from the pixel's sums when its own is added. A dispatch has as many ensembles as fill the device.
    pub Draw(SlotsPush) = "spbr/draw" {
        slots: Shared<SlotsGroup>,
        nearest: ReadWrite<u64>,
        point_colors: Parts<[f32; 4]>,
        pixels: ReadWrite<u64>,
        squares: ReadWrite<u64>,
    }
}

pass! {
    /// Takes the maximum of `spbr/draw` alone, where colors are shaded, too many to be bound together, or not all on the
    /// device.
    pub Nearest(SlotsPush) = "spbr/nearest" with "nearest_wide" {
        slots: Shared<SlotsGroup>,
        nearest: ReadWrite<u64>,
    }
}

pass! {
    /// Finds the depth of `spbr/nearest` by a 32-bit minimum, where the device has no 64-bit atomics.
    pub NearestDepth(SlotsPush) = "spbr/nearest-depth" in "spbr/nearest" with "nearest_depth" {
        slots: Shared<SlotsGroup>,
        nearest: ReadWrite<super::splat::NearestSplat>,
    }
}

pass! {
    /// Finds the index at the depth of `spbr/nearest-depth` by a second 32-bit pass.
    pub NearestId(SlotsPush) = "spbr/nearest-id" in "spbr/nearest" with "nearest_id" {
        slots: Shared<SlotsGroup>,
        nearest: ReadWrite<super::splat::NearestSplat>,
    }
}

pass! {
    /// Visits the slots again, and adds the colors of the nearest points, shaded only here, to the sums of their pixels.
    pub Sum(SlotsPush) = "spbr/sum" {
        slots: Shared<SlotsGroup>,
        nearest: Read<[u32; 2]>,
        point_colors: Read<[f32; 4]>,
        pixels: ReadWrite<u32>,
        squares: ReadWrite<u32>,
    }
}

pass! {
    /// Turns the number of squares over 64 pixels into the arguments of the dispatch that fills them, workgroup by
    /// workgroup. It runs after each dispatch over slots where such squares are possible.
    pub Large(LargePush) = "spbr/large" {
        counters: Read<Counters>,
        arguments: ReadWrite<u32>,
    }
}

pass! {
    /// Clears the nearest point beside each pixel's sums when there are no epochs left.
    pub Renew(super::abuffer::CountPush) = "spbr/renew" {
        pixels: ReadWrite<[u32; 2]>,
    }
}

pass! {
    /// Turns the sums of each pixel into color, A and depth, and the standard error if it is asked for.
    pub Resolve(ResolvePush) = "spbr/resolve" {
        pixels: Read<[u32; 4]>,
        squares: Read<[u32; 4]>,
        image: ReadWrite<[f32; 4]>,
        depths: ReadWrite<f32>,
        spread: ReadWrite<[f32; 4]>,
    }
}

/// Slots of one invocation, at most 32.
const RUN: u64 = 16;
/// Pixels of a square that one invocation walks: larger ones go to a list.
const SMALL_SQUARE: u32 = 64;
/// What shaders know of this module.
pub(crate) const CONSTANTS: [(&str, u32); 1] = [("SMALL_SQUARE", SMALL_SQUARE)];
/// Slots of a round from which on more ensembles at once gain nothing, for each piece of work that keeps a device busy.
const ROUND_SLOTS: u64 = 1 << 10;
/// Most slots of a dispatch, and of one whose large squares may all be on the list.
const DISPATCH_SLOTS: u64 = 1 << 24;
/// See [`DISPATCH_SLOTS`].
const LISTED_SLOTS: u64 = 1 << 17;
/// Most slots after which is submitted, so that no submission takes seconds.
const SUBMITTED_SLOTS: u64 = 1 << 23;
/// The same for each of the pieces that keep a device busy: on a CPU a frame can be stopped, and a window shows the next one, in
/// a tenth of a second, too.
const SUBMITTED_SLOTS_OF_A_RUN: u64 = 1 << 15;
/// Passes after which is submitted.
const SUBMITTED_PASSES: u32 = 100;
/// Most ensembles of a round.
const MOST_PLANES: u64 = 4096;
/// Steps of an invocation of a large square at most.
const LARGE_STEPS: u64 = 8192;
/// What tells the random words of this method from those of `stochastic`: "SPBR", exclusive-or the second word of the
/// key.
const STREAM: u32 = 0x5350_4252;

/// Threefry's key for the words that decide which points smaller than a pixel are drawn. A word's counter is the
/// point's place in the dealt list, and the ensemble.
pub fn key(seed: u64) -> [u32; 2] {
    let [low, high] = random::key(seed);
    [low, high ^ STREAM]
}

/// Device bytes per pixel of a window, with one plane.
pub fn pixel_bytes(spread: bool) -> u64 {
    8 + 32 + if spread { 48 } else { 0 }
}

/// Pixels of a window whose buffers fit a binding, and a quarter of the budget.
pub fn window_pixels(budget: Budget, spread: bool) -> u64 {
    budget.window_pixels(pixel_bytes(spread)).min(budget.binding / 32).max(1)
}

/// How the nearest points are found.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Form {
    /// `spbr/draw`: nearest point and sum of colors in one go, by 64-bit atomics; colors of all points within reach.
    Single,
    /// `spbr/nearest` by 64-bit atomics, then `spbr/sum`.
    Wide,
    /// `spbr/nearest-depth`, `spbr/nearest-id`, then `spbr/sum`.
    Narrow,
}

impl Form {
    /// The form for a cloud, `wide` if there are 64-bit atomics.
    pub fn of(device: &Device, cloud: &DeviceCloud, how: &Projecting, wide: bool) -> Self {
        let shaded = how.shading.model != ShadingModel::None && cloud.has_normals();
        match Cut::new(device, cloud.len()) {
            Ok(_) if wide && !shaded => Self::Single,
            _ if wide => Self::Wide,
            _ => Self::Narrow,
        }
    }

    /// Its passes over slots.
    pub fn stages(self) -> &'static [Stage] {
        match self {
            Self::Single => &[Stage::Draw],
            Self::Wide => &[Stage::Nearest, Stage::Sum],
            Self::Narrow => &[Stage::NearestDepth, Stage::NearestId, Stage::Sum],
        }
    }
}

/// A pass over slots.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stage {
    /// [`Draw`]
    Draw,
    /// [`Nearest`]
    Nearest,
    /// [`NearestDepth`]
    NearestDepth,
    /// [`NearestId`]
    NearestId,
    /// [`Sum`]
    Sum,
}

impl Stage {
    /// Whether it is the first to meet a frame's points, and so counts those that are drawn.
    fn counts(self) -> bool {
        matches!(self, Self::Draw | Self::Nearest | Self::NearestDepth)
    }

    /// Whether the standard error shows in it.
    fn spreads(self) -> bool {
        matches!(self, Self::Draw | Self::Sum)
    }
}

/// What the passes over slots must know about frame and cloud.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Kind {
    /// Whether opacities differ from point to point.
    pub weighted: bool,
    /// Whether points may ask for less than a pixel.
    pub thinned: bool,
    /// Whether slanted normals make points smaller.
    pub slanted: bool,
    /// Whether points may be wider than a pixel.
    pub squares: bool,
    /// Whether rounds have more than one ensemble.
    pub planes: bool,
    /// Whether the standard error is asked for.
    pub spread: bool,
}

choices!(struct Kind { weighted, thinned, slanted, squares, planes, spread });

/// Who goes through slots.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Through {
    /// An invocation for some slots each.
    Slots {
        /// Whether they are of a later pass over the cloud.
        again: bool,
    },
    /// So many workgroups for each square of the list of large ones.
    Large {
        /// How many.
        stripes: u32,
    },
}

impl Choices for Through {
    fn all() -> Vec<Self> {
        vec![Self::Slots { again: false }, Self::Slots { again: true }, Self::Large { stripes: 3 }]
    }
}

impl Kind {
    /// Whether there are such clouds and frames: points that ask for less in different ways may ask for less than a pixel.
    fn is_possible(self) -> bool {
        self.thinned || !(self.weighted || self.slanted)
    }

    /// The variant of a stage that goes through slots.
    fn variant(self, stage: Stage, through: Through) -> Variant {
        let variant = Variant::plain()
            .with("WEIGHTED", u32::from(self.weighted))
            .with("THINNED", u32::from(self.thinned))
            .with("SLANTED", u32::from(self.slanted))
            .with("SQUARES", u32::from(self.squares))
            .with("PLANES", u32::from(self.planes));
        let variant = match through {
            Through::Slots { again } => variant
                .walker("spbr_slots")
                .with("RUN", RUN as u32)
                .with("COUNTED", u32::from(stage.counts()))
                .with("AGAIN", u32::from(again)),
            Through::Large { stripes } => variant.walker("spbr_large").with("STRIPES", stripes),
        };
        if stage.spreads() { variant.with("SPREAD", u32::from(self.spread)) } else { variant }
    }

    /// The variants of a stage.
    fn variants(stage: Stage) -> Vec<Variant> {
        let possible = <(Self, Through)>::all().into_iter().filter(|(kind, _)| kind.is_possible());
        possible.map(|(kind, through)| kind.variant(stage, through)).collect()
    }
}

/// The variant of `spbr/draw`: cut and color space besides.
fn draw_variant(variant: Variant, cut: Cut, color: ColorSpace) -> Variant {
    variant.with("PARTS", cut.parts).with("PART_LENGTH", cut.len).with("ENCODED", color as u32)
}

/// The variant of `spbr/sum`: shading besides.
fn sum_variant(mut variant: Variant, shaded: Shaded) -> Variant {
    variant.overrides.extend(shaded.variant().overrides);
    variant
}

/// The variant of `spbr/resolve`.
fn resolve_variant(spread: bool) -> Variant {
    Variant::plain().with("SPREAD", u32::from(spread))
}

/// The passes with their variants.
pub fn shaders() -> Vec<Shader> {
    let stages = Kind::variants;
    let colored = |draw: Variant| {
        <(Cut, ColorSpace)>::all().into_iter().map(move |(cut, color)| draw_variant(draw.clone(), cut, color))
    };
    let shaded = |sum: Variant| Shaded::all().into_iter().map(move |shaded| sum_variant(sum.clone(), shaded));
    let draw = stages(Stage::Draw).into_iter().flat_map(colored);
    let sum = stages(Stage::Sum).into_iter().flat_map(shaded);
    vec![
        Shader::new::<Draw>(draw),
        Shader::new::<Nearest>(stages(Stage::Nearest)),
        Shader::new::<NearestDepth>(stages(Stage::NearestDepth)),
        Shader::new::<NearestId>(stages(Stage::NearestId)),
        Shader::new::<Sum>(sum),
        Shader::plain::<Renew>(),
        Shader::plain::<Large>(),
        Shader::new::<Resolve>([false, true].map(resolve_variant)),
    ]
}

/// How colors become whole numbers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scale {
    /// What a color of 1 is.
    pub one: f32,
    /// The most that a color may be: with `ensembles` times that a sum still has 32 bits.
    pub most: f32,
}

impl Scale {
    /// For so many ensembles and colors of up to `most_color`: a power of two, at most 2^22.
    pub fn new(ensembles: u32, most_color: f32) -> Self {
        let most = f64::from(u32::MAX / ensembles.max(1));
        let bits = (most / f64::from(most_color.max(1.0))).log2().floor().clamp(0.0, 22.0);
        // Rounded down.
        let float = most as f32;
        Self { one: bits.exp2() as f32, most: if f64::from(float) > most { float.next_down() } else { float } }
    }
}

/// Everything that stays the same while a window is rendered.
pub struct WindowJob<'a> {
    /// The cloud, its view set.
    pub cloud: &'a DeviceCloud,
    /// The window.
    pub window: Window,
    /// Shading and color space.
    pub how: &'a Projecting,
    /// What is taken of each cloud.
    pub shares: &'a [Share],
    /// The method.
    pub method: Method,
    /// Ensembles that are drawn, at most those of the method.
    pub drawn: u32,
    /// Seed.
    pub seed: u64,
    /// Whether the standard error is asked for.
    pub spread: bool,
    /// Whether the width of points depends on depth.
    pub perspective: bool,
    /// How the nearest points are found.
    pub form: Form,
    /// Points on the device at a time, if not all: see [`stream::window_points`]. [`Form::Single`] needs all.
    pub streamed: Option<u64>,
    /// Most bits of a key for epochs.
    pub most_epoch_bits: u32,
    /// Pieces of work that keep the device busy.
    pub concurrent: u64,
    /// The budget.
    pub budget: Budget,
}

impl WindowJob<'_> {
    fn pixels(&self) -> u64 {
        bands::pixels(self.window)
    }

    /// L.
    fn ensembles(&self) -> u32 {
        self.method.ensembles().unwrap_or(1)
    }

    fn kind(&self) -> Kind {
        let weighted = matches!(self.method, Method::Spbr(_)) && self.shares.iter().any(|s| !s.uniform);
        let slanted = matches!(self.method, Method::Spbr(Spbr { cos_theta: false, .. })) && self.cloud.has_normals();
        Kind {
            weighted,
            slanted,
            thinned: weighted || slanted || self.perspective,
            squares: largest(self.shares) > 1.0,
            planes: self.planes() > 1,
            spread: self.spread,
        }
    }

    fn listed(&self) -> bool {
        is_listed(self.shares)
    }

    /// Most slots of a dispatch.
    fn dispatch_slots(&self) -> u64 {
        if !self.listed() {
            return DISPATCH_SLOTS;
        }
        LISTED_SLOTS.min(self.budget.bytes / 8 / 32).max(64)
    }

    /// Ensembles of a round: as many as planes fit a binding and half of the budget, but no more than make it worth
    /// while.
    fn planes(&self) -> u64 {
        let slots: u64 = self.shares.iter().map(|s| s.slots).sum();
        let worth = ROUND_SLOTS * self.concurrent * u64::from(self.ensembles()) / slots.max(1);
        let bytes = 8 * self.pixels();
        let fit = (self.budget.binding / bytes).min(self.budget.bytes / 2 / bytes);
        worth.clamp(1, MOST_PLANES).min(fit).min(u64::from(self.drawn)).max(1)
    }

    /// Whether a pixel's nearest point stands beside its sums.
    fn is_inline(&self) -> bool {
        self.form == Form::Single && self.planes() == 1
    }

    /// A word of a plane that holds nothing: `spbr/draw` looks for the largest key, the other forms for its smallest complement.
    fn nothing(&self) -> u32 {
        if self.form == Form::Single { 0 } else { u32::MAX }
    }

    /// Whether there are more rounds than epochs of planes that no fill can clear.
    pub fn is_renewed(&self) -> bool {
        self.is_inline() && self.drawn > Epochs::most(self.epoch_bits())
    }

    /// Points that a dispatch can bind.
    fn longest(&self) -> u64 {
        self.streamed.unwrap_or(u64::MAX).min(self.cloud.longest())
    }

    /// Bits of keys for epochs.
    fn epoch_bits(&self) -> u32 {
        if self.form == Form::Narrow { 0 } else { epoch_bits(self.cloud.len()).min(self.most_epoch_bits) }
    }

    fn scale(&self) -> Scale {
        Scale::new(self.ensembles(), self.cloud.most_color(self.how))
    }

    /// Workgroups of a large square.
    fn stripes(&self) -> u64 {
        self.pixels().div_ceil(LARGE_STEPS * u64::from(crate::gpu::shader::WORKGROUP))
    }
}

/// What a window met.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Drawn {
    /// Points that were drawn, each in each ensemble.
    pub visible: u64,
    /// Bytes of points that went to the device.
    pub uploaded: u64,
}

/// Buffers, kept from frame to frame.
pub struct Ensembles {
    stream: Stream,
    nearest: Kept<u64>,
    pixels: Kept<[u32; 4]>,
    squares: Kept<[u32; 4]>,
    spread: Kept<[f32; 4]>,
    large: Kept<[u32; 4]>,
    arguments: Kept<u32>,
    counters: Kept<Counters>,
    counters_host: Kept<Counters>,
}

impl Default for Ensembles {
    fn default() -> Self {
        Self {
            stream: Stream::default(),
            nearest: Kept::new("nearest of ensembles", Memory::Device),
            pixels: Kept::new("sums of ensembles", Memory::Device),
            squares: Kept::new("squares of ensembles", Memory::Device),
            spread: Kept::new("spread of ensembles", Memory::Device),
            large: Kept::new("large points", Memory::Device),
            arguments: Kept::new("large points, groups", Memory::Device),
            counters: Kept::new("counters of ensembles", Memory::Device),
            counters_host: Kept::new("counters of ensembles, host", Memory::Readback),
        }
    }
}

impl Ensembles {
    /// Renders a window into the target.
    pub(crate) fn render(&mut self, work: &mut Work<'_>, job: &WindowJob<'_>) -> Result<Drawn, Error> {
        let (device, target) = (work.device, work.target);
        self.reserve(device, job)?;
        let mut tasks = Tasks::new(job).peekable();
        let mut submissions = 0;
        loop {
            let submission = self.next_submission(job, &mut tasks);
            let mut recorder = device.recorder()?;
            if submissions == 0 {
                self.record_clear(&mut recorder, job)?;
            }
            self.stream.record(&mut recorder)?;
            for task in &submission {
                self.record_task(device, &mut recorder, job, task)?;
            }
            if tasks.peek().is_none() {
                self.record_resolve(&mut recorder, job, target)?;
                recorder.copy("spbr/summary", self.counters.get().all(), self.counters_host.get().all())?;
                target.record_read_back(&mut recorder, job.pixels())?;
                work.timeline.submit(recorder, "spbr/resolve")?;
                break;
            }
            work.timeline.submit(recorder, "spbr/draw")?;
            submissions += 1;
            let done = submission.last().map_or(0, |task| task.ensembles.end);
            work.progress.set_message(format!("rendering, {done} ensembles"));
        }
        let counters = self.counters_host.get().mapped_slice()[0];
        let visible = u64::from(counters.visible_high) << 32 | u64::from(counters.visible_low);
        Ok(Drawn { visible, uploaded: self.stream.uploaded })
    }

    /// The dispatches of the next submission: so few that it takes no seconds, and that there is room for all of their
    /// points, which are packed.
    fn next_submission(&mut self, job: &WindowJob<'_>, tasks: &mut Peekable<Tasks<'_>>) -> Vec<Task> {
        let (mut found, mut slots, mut passes) = (Vec::new(), 0, 0);
        let streamed = job.streamed.is_some();
        if let Some(first) = tasks.peek()
            && streamed
        {
            self.stream.begin(&first.piece.bound);
        }
        let most = SUBMITTED_SLOTS.min(SUBMITTED_SLOTS_OF_A_RUN * job.concurrent);
        while slots < most
            && passes < SUBMITTED_PASSES
            && let Some(task) = tasks.next_if(|task| !streamed || self.stream.admit(&task.piece.bound))
        {
            slots += task.piece.slots.end - task.piece.slots.start;
            passes += if job.listed() { 4 } else { 1 };
            found.push(task);
        }
        if streamed {
            self.stream.pack(job.cloud);
        }
        found
    }

    /// The standard error of every pixel of the window, in its order; what the last one rendered with it left.
    pub fn read_stderr(&self, window: Window) -> Result<Vec<[f32; 3]>, Error> {
        let errors = self.spread.get().read(0, bands::pixels(window))?;
        Ok(errors.iter().map(|[r, g, b, _]| [*r, *g, *b]).collect())
    }

    fn reserve(&mut self, device: &Device, job: &WindowJob<'_>) -> Result<(), Error> {
        self.stream.reserve(device, job.cloud, job.streamed)?;
        let pixels = job.pixels();
        let planes = if job.is_inline() { 1 } else { pixels * job.planes() };
        // No larger than asked for, since all of it is cleared.
        self.nearest.reserve_within(device, planes, planes)?;
        self.pixels.reserve_within(device, 2 * pixels, 2 * pixels)?;
        let squares = if job.spread { 2 * pixels } else { 1 };
        self.squares.reserve_within(device, squares, squares)?;
        self.spread.reserve(device, if job.spread { pixels } else { 1 })?;
        self.large.reserve(device, if job.listed() { 2 * job.dispatch_slots() } else { 1 })?;
        self.arguments.reserve(device, 4)?;
        self.counters.reserve(device, 1)?;
        self.counters_host.reserve(device, 1)?;
        Ok(())
    }

    fn record_clear<'a>(&'a self, recorder: &mut Recorder<'a>, job: &WindowJob<'a>) -> Result<(), Error> {
        recorder.fill("spbr/clear", self.nearest.get().all(), job.nothing())?;
        recorder.fill("spbr/clear", self.pixels.get().all(), 0)?;
        recorder.fill("spbr/clear", self.squares.get().all(), 0)?;
        recorder.fill("spbr/clear", self.counters.get().all(), 0)?;
        Ok(())
    }

    /// Records that planes are empty again.
    fn record_renew<'a>(&'a self, recorder: &mut Recorder<'a>, job: &WindowJob<'a>) -> Result<(), Error> {
        if !job.is_inline() {
            recorder.fill("spbr/clear", self.nearest.get().all(), job.nothing())?;
            return Ok(());
        }
        let pass = Renew { pixels: self.pixels.get().all().cast() };
        let push = super::abuffer::CountPush { count: job.pixels() as u32 };
        recorder.run(&pass, push, &Run::new(Dispatch::Invocations(job.pixels())))?;
        Ok(())
    }

    /// Records a dispatch, and that of its large squares.
    fn record_task<'a>(
        &'a self,
        device: &Device,
        recorder: &mut Recorder<'a>,
        job: &WindowJob<'a>,
        task: &Task,
    ) -> Result<(), Error> {
        if task.renews {
            self.record_renew(recorder, job)?;
        }
        let stage = task.stage;
        let count = task.piece.slots.end - task.piece.slots.start;
        let (kind, again) = (job.kind(), task.piece.rows.is_some());
        let run = Run::new(Dispatch::Invocations(count.div_ceil(RUN)));
        let walk = (run, kind.variant(stage, Through::Slots { again }));
        let listed: Slice<'a, u32> = self.counters.get().all().cast::<u32>().skip(2).first(1);
        if !job.listed() {
            self.record_stage(device, recorder, job, task, walk)?;
            return Ok(recorder.agree("spbr/draw", "list of large squares", listed, Expected::Value(0))?);
        }
        recorder.fill("spbr/clear", listed, 0)?;
        self.record_stage(device, recorder, job, task, walk)?;
        let stripes = job.stripes() as u32;
        let large = Large { counters: self.counters.get().all(), arguments: self.arguments.get().all() };
        let most = LargePush { stripes, most: device.limits().groups_x.min(65_535) };
        recorder.run(&large, most, &Run::new(Dispatch::Invocations(1)))?;
        let run = Run::new(Dispatch::Indirect(self.arguments.get().all()));
        self.record_stage(device, recorder, job, task, (run, kind.variant(stage, Through::Large { stripes })))
    }

    fn record_stage<'a>(
        &'a self,
        device: &Device,
        recorder: &mut Recorder<'a>,
        job: &WindowJob<'a>,
        task: &Task,
        run: (Run<'a>, Variant),
    ) -> Result<(), Error> {
        let slots = self.slots(job, &task.piece);
        let cloud = job.cloud;
        let nearest = self.nearest.get().all();
        let (run, variant) = run;
        let push = push(job, task);
        match task.stage {
            Stage::Nearest => recorder.run(&Nearest { slots, nearest }, push, &run.variant(variant))?,
            Stage::NearestDepth => {
                recorder.run(&NearestDepth { slots, nearest: nearest.cast() }, push, &run.variant(variant))?;
            }
            Stage::NearestId => {
                recorder.run(&NearestId { slots, nearest: nearest.cast() }, push, &run.variant(variant))?;
            }
            Stage::Draw => {
                let cut = Cut::new(device, cloud.len())?;
                let point_colors = cut.of(&cloud.point_colors);
                let (pixels, squares) = (self.pixels.get().all().cast(), self.squares.get().all().cast());
                let pass = Draw { slots, nearest, point_colors, pixels, squares };
                recorder.run(&pass, push, &run.variant(draw_variant(variant, cut, job.how.color)))?;
            }
            Stage::Sum => {
                let point_colors = self.column(job, Column::Color, &task.piece.bound);
                let (pixels, squares) = (self.pixels.get().all().cast(), self.squares.get().all().cast());
                let pass = Sum { slots, nearest: nearest.cast(), point_colors, pixels, squares };
                recorder.run(&pass, push, &run.variant(sum_variant(variant, job.how.shaded(cloud.has_normals()))))?;
            }
        }
        Ok(())
    }

    fn slots<'a>(&'a self, job: &WindowJob<'a>, piece: &Piece) -> Slots<'a> {
        let (cloud, bound) = (job.cloud, &piece.bound);
        Slots {
            camera: cloud.view(),
            points_hi: self.column(job, Column::High, bound),
            points_lo: self.column(job, Column::Low, bound),
            normals: if cloud.has_normals() {
                self.column(job, Column::Normal, bound)
            } else {
                cloud.normals.slice(0, 1)
            },
            counters: self.counters.get().all(),
            large: self.large.get().all(),
        }
    }

    /// A column of some points, from where they are.
    fn column<'a>(&'a self, job: &WindowJob<'a>, column: Column, points: &Range<u64>) -> Slice<'a, [f32; 4]> {
        if job.streamed.is_some() {
            return self.stream.column(column, points);
        }
        let all = match column {
            Column::High => &job.cloud.points_hi,
            Column::Low => &job.cloud.points_lo,
            Column::Color => &job.cloud.point_colors,
            Column::Normal => &job.cloud.normals,
        };
        all.slice(points.start, points.end - points.start)
    }

    fn record_resolve<'a>(
        &'a self,
        recorder: &mut Recorder<'a>,
        job: &WindowJob<'a>,
        target: &'a Target,
    ) -> Result<(), Error> {
        let pass = Resolve {
            pixels: self.pixels.get().all(),
            squares: self.squares.get().all(),
            image: target.image(),
            depths: target.depths(),
            spread: self.spread.get().all(),
        };
        let push = ResolvePush { pixels: job.pixels() as u32, ensembles: job.drawn, scale: job.scale().one };
        let run = Run::new(Dispatch::Invocations(job.pixels()));
        recorder.run(&pass, push, &run.variant(resolve_variant(job.spread)))?;
        Ok(())
    }
}

fn push(job: &WindowJob<'_>, task: &Task) -> SlotsPush {
    let (share, piece) = (&job.shares[task.cloud], &task.piece);
    let ensembles = job.ensembles();
    let [key_x, key_y] = key(job.seed);
    let scale = job.scale();
    let before = u128::from(share.slots) * u128::from(task.ensembles.start);
    let bits = job.epoch_bits();
    let rows = piece.rows.map(|again| again.rows);
    SlotsPush {
        count: (piece.slots.end - piece.slots.start) as u32,
        first: piece.slots.start as u32,
        base: piece.base,
        list: piece.bound.start as u32,
        start: piece.rows.map_or(0, |again| again.start),
        around: piece.rows.map_or(u32::MAX, |again| again.around),
        columns: rows.map_or(1, |rows| rows.columns),
        block_bits: rows.map_or(0, |rows| rows.block_bits),
        hand: task.ensembles.start.wrapping_sub(piece.rows.map_or(0, |again| again.ensemble)),
        pass_word: rows.map_or(0, |rows| rows.word),
        whole: (share.slots / u64::from(ensembles)) as u32,
        rest: (share.slots % u64::from(ensembles)) as u32,
        carry: (before % u128::from(ensembles)) as u32,
        ensembles,
        planes: task.ensembles.end - task.ensembles.start,
        ensemble: task.ensembles.start,
        pixels: job.pixels() as u32,
        epoch_bits: bits,
        epoch: task.epoch,
        key_x,
        key_y,
        depth: share.depth as f32,
        unit: share.unit as f32,
        scale: scale.one,
        most: scale.most,
    }
}

/// The shares of a frame, if its points were dealt.
pub fn shares(cloud: &DeviceCloud, frame: &Frame) -> Result<Vec<Share>, Error> {
    let placed: &[Placed] = cloud.surfaces().ok_or(Error::NotDealt)?;
    let wanted = Wanted {
        camera: &frame.camera,
        height: frame.size[1],
        method: frame.method,
        opacity_factor: f64::from(frame.factors.opacity),
    };
    Ok(placed.iter().map(|p| wanted.share(p)).collect())
}

/// Most pixels that a point may cover.
fn largest(shares: &[Share]) -> f64 {
    shares.iter().map(|s| s.largest).fold(0.0, f64::max)
}

/// Whether squares may be so large that they go to a list: a side of up to `s` pixels touches `s + 1`.
pub fn is_listed(shares: &[Share]) -> bool {
    (largest(shares).sqrt() + 1.0).powi(2) > f64::from(SMALL_SQUARE)
}

/// Bytes that a pass must at least read and write; `pixels` of the image.
pub fn least_bytes(name: &str, facts: &Facts, spread: bool, pixels: u64) -> Option<u64> {
    let (walk, squares) = (facts.slots * 32 * facts.windows.max(1), if spread { 32 } else { 0 });
    match name {
        "spbr/nearest" | "spbr/nearest-depth" | "spbr/nearest-id" => Some(walk + facts.visible * 8),
        "spbr/draw" => Some(walk + facts.visible * (16 + 16) + pixels * 32),
        "spbr/sum" => Some(walk + facts.visible * 8 + pixels * 32),
        "spbr/upload" => Some(2 * facts.uploaded_bytes),
        "spbr/resolve" => Some(pixels * (32 + squares + 20 + squares / 2)),
        _ => None,
    }
}

/// Slots of the first `drawn` of `ensembles`.
pub fn slots_of(share: &Share, ensembles: u32, drawn: u32) -> u64 {
    drawn.checked_sub(1).map_or(0, |last| slots(share.slots, ensembles, last).end)
}

/// The clouds that lose opacity.
pub fn thin(shares: &[Share]) -> Vec<ThinCloud> {
    let thousandths = |share: &Share| (1000.0 * share.opacity).round() as u32;
    let all = shares.iter().zip(0..);
    all.filter(|(s, _)| s.capped).map(|(s, cloud)| ThinCloud { cloud, reached: thousandths(s) }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sums_of_whole_colors_fit_32_bits() {
        for ensembles in [1, 2, 3, 100, 1000, 1023, 1024, 65_535, 65_536] {
            for most_color in [0.0f32, 0.3, 1.0, 1.001, 2.5, 1e3] {
                let Scale { one, most } = Scale::new(ensembles, most_color);
                assert!(one.log2().fract() == 0.0 && (1.0..=4_194_304.0).contains(&one), "{one}");
                assert!(f64::from(most) * f64::from(ensembles) <= f64::from(u32::MAX), "{ensembles}, {most}");
                assert!(one * most_color <= most, "{ensembles}, {most_color}");
            }
        }
        // With 100 ensembles a color of 1 has all of the bits.
        assert_eq!(Scale::new(100, 1.0).one, 4_194_304.0);
    }
}
