//! Renders the ensembles of a window: buffers, submissions and their passes.

use std::iter::Peekable;

use super::job::{Scale, SpbrJob};
use super::key;
use super::passes::*;
use super::rounds::Piece;
use super::run;
use super::stream::Stream;
use super::tasks::{Task, Tasks};
use super::variants::{Stage, Through, draw_variant, resolve_variant, sum_variant};
use crate::methods::parts::Plane;
use crate::methods::prelude::*;
use crate::passes::project::Column;

/// Most slots after which is submitted, so that no submission takes seconds.
const SUBMITTED_SLOTS: u64 = 1 << 23;
/// Most slots of each of the pieces that keep a device busy. On a CPU, too, a frame can then be stopped, and a window
/// shows the next one, within a tenth of a second.
const SUBMITTED_SLOTS_OF_A_RUN: u64 = 1 << 15;
/// Passes after which is submitted.
const SUBMITTED_PASSES: u32 = 100;

/// Statistics of a window.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Drawn {
    /// Points that were drawn, each in each ensemble.
    pub visible: u64,
    /// Bytes of points that went to the device.
    pub uploaded: u64,
}

fields! {
    /// Buffers, kept from frame to frame.
    pub struct Ensembles {
        stream: Stream = Stream::default(),
        nearest: Scratch<u64> = Scratch::new("nearest of ensembles", Memory::Device),
        pixels: Scratch<[u32; 4]> = Scratch::new("sums of ensembles", Memory::Device),
        squares: Scratch<[u32; 4]> = Scratch::new("squares of ensembles", Memory::Device),
        spread: Scratch<[f32; 4]> = Scratch::new("spread of ensembles", Memory::Device),
        large: Scratch<[u32; 4]> = Scratch::new("large points", Memory::Device),
        arguments: Scratch<u32> = Scratch::new("large points, groups", Memory::Device),
        counters: Scratch<Counters> = Scratch::new("counters of ensembles", Memory::Device),
        counters_host: Scratch<Counters> = Scratch::new("counters of ensembles, host", Memory::Readback),
    }
}

impl Ensembles {
    /// Renders a window into the target, or keeps its sums.
    pub(crate) fn render(&mut self, work: &mut Work<'_>, job: &SpbrJob<'_>) -> Result<Drawn, Error> {
        let device = work.device;
        self.reserve(device, job)?;
        let mut tasks = Tasks::new(job).peekable();
        let (mut submissions, streamed) = (0, job.streamed.is_some());
        loop {
            let submission = self.next_submission(job, &mut tasks)?;
            let mut recorder = work.timeline.recorder(device)?;
            if submissions == 0 {
                job.cloud.record_view(&mut recorder);
                self.record_clear(&mut recorder, job)?;
            }
            self.stream.record(&mut recorder)?;
            for task in &submission {
                self.record_task(device, &mut recorder, job, task)?;
            }
            if tasks.peek().is_none() {
                recorder.copy("spbr/summary", self.counters.get().all(), self.counters_host.get().all())?;
                if work.sums.is_some() {
                    work.timeline.submit(recorder, "spbr/draw")?;
                    self.keep(work)?;
                } else {
                    self.end(recorder, work, work.samples.end, job.scale())?;
                }
                break;
            }
            if streamed {
                // The next points take the place of these in the host's memory.
                work.timeline.submit(recorder, "spbr/draw")?;
            } else {
                work.timeline.go_on(recorder, "spbr/draw")?;
            }
            submissions += 1;
            let done = submission.last().map_or(0, |task| task.ensembles.end);
            work.progress.set_message(format!("rendering, {done} ensembles"));
        }
        let counters = self.counters_host.get().mapped_slice()[0];
        let visible = u64::from(counters.visible_high) << 32 | u64::from(counters.visible_low);
        Ok(Drawn { visible, uploaded: self.stream.uploaded })
    }

    /// Resolves sums that were put together into the target.
    pub(crate) fn resolve(&mut self, work: &mut Work<'_>, scale: Scale, sums: &SamplePart) -> Result<(), Error> {
        let (device, spread) = (work.device, work.frame.wants_spread());
        self.reserve_sums(device, work.pixels(), spread)?;
        let colors = sums.window(Plane::Colors, work.window);
        let of_pixel = |c: &[u32]| [[0, 0, c[0], c[1]], [c[2], c[3], c[4], 0]];
        self.pixels.get().upload(&colors.chunks_exact(5).flat_map(of_pixel).collect::<Vec<_>>())?;
        if spread {
            let squares = sums.window(Plane::Squares, work.window);
            let of_pixel = |s: &[u32]| [[s[0], s[1], s[2], s[3]], [s[4], s[5], 0, 0]];
            self.squares.get().upload(&squares.chunks_exact(6).flat_map(of_pixel).collect::<Vec<_>>())?;
        }
        let recorder = work.timeline.recorder(device)?;
        self.end(recorder, work, work.samples.end, scale)
    }

    /// Keeps the sums of a window that was submitted.
    fn keep(&self, work: &Work<'_>) -> Result<(), Error> {
        let read = |words: &Scratch<[u32; 4]>| words.get().read(0, 2 * work.pixels());
        let colors = read(&self.pixels)?;
        let of_pixel = |p: &[[u32; 4]]| [p[0][2], p[0][3], p[1][0], p[1][1], p[1][2]];
        work.keep(Plane::Colors, &colors.chunks_exact(2).flat_map(of_pixel).collect::<Vec<_>>());
        if work.frame.wants_spread() {
            let squares = read(&self.squares)?;
            let of_pixel = |s: &[[u32; 4]]| [s[0][0], s[0][1], s[0][2], s[0][3], s[1][0], s[1][1]];
            work.keep(Plane::Squares, &squares.chunks_exact(2).flat_map(of_pixel).collect::<Vec<_>>());
        }
        Ok(())
    }

    /// Submits the end of a window: resolves sums over so many ensembles into the target, and copies it to the host.
    fn end<'a, 'w: 'a>(
        &'a self,
        mut recorder: Recorder<'a>,
        work: &mut Work<'w>,
        ensembles: u32,
        scale: Scale,
    ) -> Result<(), Error> {
        let (target, pixels) = (work.target, work.pixels());
        let push = ResolvePush { pixels: pixels as u32, ensembles, scale: scale.one };
        let pass = Resolve {
            pixels: self.pixels.get().all(),
            squares: self.squares.get().all(),
            into: target.pixels(),
            spread: self.spread.get().all(),
        };
        let run = Run::new(Dispatch::Invocations(pixels)).variant(resolve_variant(work.frame.wants_spread()));
        recorder.run(&pass, push, &run)?;
        target.record_read_back(&mut recorder, pixels)?;
        work.timeline.submit(recorder, "spbr/resolve")
    }

    /// Returns the dispatches of the next submission: so few that it takes no seconds and that all of their points fit,
    /// which are packed.
    fn next_submission(&mut self, job: &SpbrJob<'_>, tasks: &mut Peekable<Tasks<'_>>) -> Result<Vec<Task>, Error> {
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
            self.stream.pack(job.cloud)?;
        }
        Ok(found)
    }

    /// Returns the standard error of every pixel of the window, in its order, from the last window rendered with it.
    pub fn read_stderr(&self, window: Window) -> Result<Vec<[f32; 3]>, Error> {
        let errors = self.spread.get().read(0, bands::pixels(window))?;
        Ok(errors.iter().map(|[r, g, b, _]| [*r, *g, *b]).collect())
    }

    fn reserve(&mut self, device: &Device, job: &SpbrJob<'_>) -> Result<(), Error> {
        self.stream.reserve(device, job.cloud, job.streamed)?;
        let pixels = job.pixels();
        let planes = if job.is_inline() { 1 } else { pixels * job.planes() };
        // No larger than asked for, since all of it is cleared.
        self.nearest.reserve_within(device, planes, planes)?;
        self.reserve_sums(device, pixels, job.spread)?;
        self.large.reserve(device, if job.listed() { 2 * job.dispatch_slots() } else { 1 })?;
        self.arguments.reserve(device, 4)?;
        self.counters.reserve(device, 1)?;
        self.counters_host.reserve(device, 1)?;
        Ok(())
    }

    fn reserve_sums(&mut self, device: &Device, pixels: u64, spread: bool) -> Result<(), Error> {
        self.pixels.reserve_within(device, 2 * pixels, 2 * pixels)?;
        let squares = if spread { 2 * pixels } else { 1 };
        self.squares.reserve_within(device, squares, squares)?;
        Ok(self.spread.reserve(device, if spread { pixels } else { 1 })?)
    }

    fn record_clear<'a>(&'a self, recorder: &mut Recorder<'a>, job: &SpbrJob<'a>) -> Result<(), Error> {
        let [nearest, pixels] = [self.nearest.get().all().cast(), self.pixels.get().all().cast()];
        let [squares, counters] = [self.squares.get().all().cast(), self.counters.get().all().cast()];
        let fills = [(nearest, job.nothing()), (pixels, 0), (squares, 0), (counters, 0)];
        Ok(recorder.fill_all("spbr/clear", &fills)?)
    }

    /// Records that planes are empty again.
    fn record_renew<'a>(&'a self, recorder: &mut Recorder<'a>, job: &SpbrJob<'a>) -> Result<(), Error> {
        if !job.is_inline() {
            recorder.fill("spbr/clear", self.nearest.get().all(), job.nothing())?;
            return Ok(());
        }
        let pass = Renew { pixels: self.pixels.get().all().cast() };
        let push = CountPush { count: job.pixels() as u32 };
        Ok(recorder.run(&pass, push, &Run::new(Dispatch::Invocations(job.pixels())))?)
    }

    /// Records a dispatch, and that of its large squares.
    fn record_task<'a>(
        &'a self,
        device: &Device,
        recorder: &mut Recorder<'a>,
        job: &SpbrJob<'a>,
        task: &Task,
    ) -> Result<(), Error> {
        if task.renews {
            self.record_renew(recorder, job)?;
        }
        let stage = task.stage;
        let count = task.piece.slots.end - task.piece.slots.start;
        let (kind, again) = (job.kind(), task.piece.rows.is_some());
        let spread = job.shares_squares;
        let walk = Run::new(Dispatch::Invocations(count.div_ceil(run(spread))));
        let walk = (walk, kind.variant(stage, Through::Slots { again, spread }));
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
        job: &SpbrJob<'a>,
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
                let point_colors = cut.slices(&cloud.point_colors);
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

    fn slots<'a>(&'a self, job: &SpbrJob<'a>, piece: &Piece) -> Slots<'a> {
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
            ids: match job.streamed {
                Some(_) => self.stream.ids(bound),
                None => cloud.ids.slice(bound.start, bound.end - bound.start),
            },
            counters: self.counters.get().all(),
            large: self.large.get().all(),
        }
    }

    /// A column of some points, from where they are.
    fn column<'a>(&'a self, job: &SpbrJob<'a>, column: Column, points: &Range<u64>) -> Slice<'a, [f32; 4]> {
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
}

fn push(job: &SpbrJob<'_>, task: &Task) -> SlotsPush {
    let (share, piece) = (&job.shares[task.cloud], &task.piece);
    let ensembles = job.ensembles[1];
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
