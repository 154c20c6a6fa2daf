//! Records passes into one command buffer: the only place for barriers, labels, timestamps, binding and dispatching.
//!
//! Passes run as if one after another: a barrier stands before each that meets what an earlier one did. Where passes
//! are stamped one stands before each, and timestamps are written at the end of the pipe at both ends of a pass, each
//! followed by an execution barrier, without which lavapipe's stamps shift by one interval after a graphics pass.

mod barriers;
mod condition;
mod descriptors;
mod dispatch;
mod draw;
mod times;

pub use dispatch::Dispatch;
pub use draw::{Draw, Targets, Vertices};
pub use times::{PassTime, Stamps};

use std::borrow::Cow;
use std::marker::PhantomData;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

use ash::vk;

use self::barriers::{Kind, Touch, Touched};
use self::times::Queries;
use super::agree::Agreement;
use super::commands::Commands;
use super::context::lock;
use super::guard::Guards;
use super::paused::DeletionHold;
use super::pipeline::Pipeline;
use super::{Context, Declaration, Error, GpuType, Pass, RawSlice, Resource, Slice, Variant};

/// Label, variant and size of one run of a pass.
#[derive(Debug, Clone)]
pub struct Run<'a> {
    label: Option<&'static str>,
    variant: Variant,
    dispatch: Dispatch<'a>,
}

impl<'a> Run<'a> {
    /// Returns a run of the plain variant.
    pub fn new(dispatch: Dispatch<'a>) -> Self {
        Self { label: None, variant: Variant::plain(), dispatch }
    }

    /// Under another name than the pass's own.
    pub fn label(mut self, label: &'static str) -> Self {
        self.label = Some(label);
        self
    }

    /// Sets the variant of the pass's shader.
    pub fn variant(mut self, variant: Variant) -> Self {
        self.variant = variant;
        self
    }
}

/// The stages of a run.
fn kind(run: &Run<'_>) -> Kind {
    match run.dispatch {
        // Other stages than that of the shader read the numbers of workgroups.
        Dispatch::Indirect(_) => Kind::Other,
        _ => Kind::Compute,
    }
}

/// A finished submission.
#[derive(Debug, Clone, PartialEq)]
pub struct Submitted {
    /// The passes in order.
    pub passes: Vec<PassTime>,
    /// Time when it was submitted.
    pub begin: Instant,
    /// Time from the submission to the end of waiting for it.
    pub wall: Duration,
    /// Device time from its beginning to its end; `None` where that was not to be found ([`Stamps::Ends`]).
    pub whole: Option<Duration>,
}

/// The value of an override, by its name.
pub type Given = (&'static str, f64);

/// One command buffer in the making.
/// The buffers it was given stay borrowed until it is submitted, which waits for the device.
pub struct Recorder<'a> {
    context: Arc<Context>,
    commands: vk::CommandBuffer,
    /// There until it is given back.
    taken: Option<Commands>,
    pipelines: Vec<Arc<Pipeline>>,
    /// Pools of descriptor sets that are in use, the first ones of those that were taken.
    pools: usize,
    sets_left: u32,
    descriptors_left: u32,
    queries: Vec<Queries>,
    /// Name of each pass, and whether its invocations are counted.
    passes: Vec<(&'static str, bool)>,
    guards: Guards,
    agreements: Vec<Agreement>,
    /// True where the device may leave commands out.
    conditional: bool,
    stamps: Stamps,
    touched: Touched,
    given: Option<Given>,
    /// There once the recording was interrupted.
    pub(super) held: Option<DeletionHold>,
    buffers: PhantomData<&'a ()>,
}

impl<'a> Recorder<'a> {
    pub(super) fn new(context: &Arc<Context>, stamps: Stamps) -> Result<Self, Error> {
        let commands = context.take_commands()?;
        let mut recorder = Self {
            context: context.clone(),
            commands: commands.buffer,
            taken: Some(commands),
            pipelines: Vec::new(),
            pools: 0,
            sets_left: 0,
            descriptors_left: 0,
            queries: Vec::new(),
            passes: Vec::new(),
            guards: Guards::default(),
            agreements: Vec::new(),
            conditional: false,
            stamps,
            touched: Touched::default(),
            given: None,
            held: None,
            buffers: PhantomData,
        };
        let begin = vk::CommandBufferBeginInfo::default().flags(vk::CommandBufferUsageFlags::ONE_TIME_SUBMIT);
        // SAFETY: a command buffer that is fresh or was reset.
        unsafe { context.device.begin_command_buffer(recorder.commands, &begin) }
            .map_err(Error::call("vkBeginCommandBuffer"))?;
        if stamps == Stamps::Ends {
            recorder.begin_whole()?;
        }
        Ok(recorder)
    }

    /// Runs a compute pass with its push constants, `()` for one that declares none.
    ///
    /// Neither can be left out or mistaken:
    ///
    /// ```
    /// # use pellucid_gpu::{Error, Recorder, Run, SHADERS, gpu_struct, pass};
    /// # gpu_struct! { pub struct CountPush { count: u32 } }
    /// # gpu_struct! { pub struct WidthPush { width: u32 } }
    /// # pass! { @from SHADERS; pub Over(CountPush) = "test/over" { values: ReadWrite<u32> } }
    /// # pass! { @from SHADERS; pub Plain = "test/plain" { values: ReadWrite<u32> } }
    /// # type Out = Result<(), Error>;
    /// # fn record<'a>(recorder: &mut Recorder<'a>, over: Over<'a>, plain: Plain<'a>, run: &Run<'a>) -> Out {
    /// recorder.run(&over, CountPush { count: 3 }, run)?;
    /// recorder.run(&plain, (), run)
    /// # }
    /// ```
    /// ```compile_fail,E0308
    /// # use pellucid_gpu::{Error, Recorder, Run, SHADERS, gpu_struct, pass};
    /// # gpu_struct! { pub struct CountPush { count: u32 } }
    /// # gpu_struct! { pub struct WidthPush { width: u32 } }
    /// # pass! { @from SHADERS; pub Over(CountPush) = "test/over" { values: ReadWrite<u32> } }
    /// # pass! { @from SHADERS; pub Plain = "test/plain" { values: ReadWrite<u32> } }
    /// # type Out = Result<(), Error>;
    /// # fn record<'a>(recorder: &mut Recorder<'a>, over: Over<'a>, plain: Plain<'a>, run: &Run<'a>) -> Out {
    /// recorder.run(&over, (), run) // wants a CountPush
    /// # }
    /// ```
    /// ```compile_fail,E0308
    /// # use pellucid_gpu::{Error, Recorder, Run, SHADERS, gpu_struct, pass};
    /// # gpu_struct! { pub struct CountPush { count: u32 } }
    /// # gpu_struct! { pub struct WidthPush { width: u32 } }
    /// # pass! { @from SHADERS; pub Over(CountPush) = "test/over" { values: ReadWrite<u32> } }
    /// # pass! { @from SHADERS; pub Plain = "test/plain" { values: ReadWrite<u32> } }
    /// # type Out = Result<(), Error>;
    /// # fn record<'a>(recorder: &mut Recorder<'a>, over: Over<'a>, plain: Plain<'a>, run: &Run<'a>) -> Out {
    /// recorder.run(&over, WidthPush { width: 3 }, run) // another pass's push constants
    /// # }
    /// ```
    /// ```compile_fail,E0308
    /// # use pellucid_gpu::{Error, Recorder, Run, SHADERS, gpu_struct, pass};
    /// # gpu_struct! { pub struct CountPush { count: u32 } }
    /// # gpu_struct! { pub struct WidthPush { width: u32 } }
    /// # pass! { @from SHADERS; pub Over(CountPush) = "test/over" { values: ReadWrite<u32> } }
    /// # pass! { @from SHADERS; pub Plain = "test/plain" { values: ReadWrite<u32> } }
    /// # type Out = Result<(), Error>;
    /// # fn record<'a>(recorder: &mut Recorder<'a>, over: Over<'a>, plain: Plain<'a>, run: &Run<'a>) -> Out {
    /// recorder.run(&plain, CountPush { count: 3 }, run) // declares none
    /// # }
    /// ```
    pub fn run<P: Pass + 'a>(&mut self, pass: &P, push: P::Push, run: &Run<'a>) -> Result<(), Error> {
        self.run_declared(&P::DECLARATION, &pass.resources(), bytemuck::bytes_of(&push), run)
    }

    /// Gives every pass from here on whose shader has it the value of an override; `None` gives them nothing.
    pub fn give(&mut self, given: Option<Given>) {
        self.given = given;
    }

    /// A variant of a pass with what it is given.
    fn variant<'v>(&self, pass: &Declaration, variant: &'v Variant) -> Result<Cow<'v, Variant>, Error> {
        Ok(match self.given {
            Some((name, value)) if self.context.has_override(pass, variant, name)? => {
                Cow::Owned(variant.clone().with(name, value))
            }
            _ => Cow::Borrowed(variant),
        })
    }

    fn run_declared(
        &mut self,
        pass: &Declaration,
        resources: &[Resource],
        push: &[u8],
        run: &Run<'_>,
    ) -> Result<(), Error> {
        let name = run.label.unwrap_or(pass.name);
        let (pipeline, set, touches) = self.prepare(pass, resources, run, name)?;
        self.begin_pass(name, true, kind(run), &touches)?;
        self.dispatch(pass, &pipeline, set, push, run)?;
        self.end_pass();
        self.pipelines.push(pipeline);
        Ok(())
    }

    /// Runs a compute pass that the submission's times know nothing of. The caller keeps its buffers until after the
    /// submission.
    pub(super) fn run_untimed<P: Pass>(&mut self, pass: &P, push: P::Push, run: &Run<'_>) -> Result<(), Error> {
        let (declared, push) = (&P::DECLARATION, bytemuck::bytes_of(&push));
        let (pipeline, set, touches) = self.prepare(declared, &pass.resources(), run, declared.name)?;
        self.barrier_before(kind(run), &touches);
        self.dispatch(declared, &pipeline, set, push, run)?;
        self.pipelines.push(pipeline);
        Ok(())
    }

    fn prepare(
        &mut self,
        pass: &Declaration,
        resources: &[Resource],
        run: &Run<'_>,
        name: &'static str,
    ) -> Result<(Arc<Pipeline>, vk::DescriptorSet, Vec<Touch>), Error> {
        let variant = self.variant(pass, &run.variant)?;
        let pipeline = Pipeline::compute(&self.context, pass, &variant, name)?;
        let (set, mut touches) = self.descriptors(pass, &pipeline, name, resources)?;
        if let Dispatch::Indirect(arguments) = run.dispatch {
            touches.push(Touch::read(arguments.raw()));
        }
        Ok((pipeline, set, touches))
    }

    fn dispatch(
        &self,
        pass: &Declaration,
        pipeline: &Pipeline,
        set: vk::DescriptorSet,
        push: &[u8],
        run: &Run<'_>,
    ) -> Result<(), Error> {
        let groups = self.groups(pass.name, run.dispatch)?;
        let (device, commands) = (&self.context.device, self.commands);
        // SAFETY: the recorder holds the pipeline and the set and borrows the buffers, until the submission has been
        // waited for.
        unsafe {
            device.cmd_bind_pipeline(commands, vk::PipelineBindPoint::COMPUTE, pipeline.raw);
            device.cmd_bind_descriptor_sets(commands, vk::PipelineBindPoint::COMPUTE, pipeline.layout, 0, &[set], &[]);
            if let Some(stages) = pipeline.push_stages {
                device.cmd_push_constants(commands, pipeline.layout, stages, 0, push);
            }
            match run.dispatch {
                Dispatch::Indirect(arguments) => {
                    let RawSlice { buffer, offset, bytes, .. } = arguments.raw();
                    assert!(bytes >= 12, "{}: a dispatch takes three words", pass.name);
                    device.cmd_dispatch_indirect(commands, buffer, offset);
                }
                _ => device.cmd_dispatch(commands, groups[0], groups[1], 1),
            }
        }
        Ok(())
    }

    /// Returns the context, for checks in debug builds.
    pub(super) fn context(&self) -> &Arc<Context> {
        &self.context
    }

    /// A comparison whose outcome is looked at after the submission.
    pub(super) fn keep(&mut self, agreement: Agreement) {
        self.agreements.push(agreement);
    }

    /// Fills a range with copies of one word, as a pass of its own.
    pub fn fill<T: GpuType>(&mut self, name: &'static str, target: Slice<'a, T>, word: u32) -> Result<(), Error> {
        self.fill_all(name, &[(target.cast(), word)])
    }

    /// Fills each range with copies of its word, all in one pass: none waits for another, so they must not overlap.
    pub fn fill_all(&mut self, name: &'static str, targets: &[(Slice<'a, u32>, u32)]) -> Result<(), Error> {
        let touches: Vec<Touch> = targets.iter().map(|(target, _)| Touch::write(target.raw())).collect();
        assert!(!Touch::meet_within(&touches), "{name}: ranges that overlap");
        self.begin_pass(name, false, Kind::Other, &touches)?;
        for (target, word) in targets {
            let raw = target.raw();
            self.guards.note_write(raw);
            // SAFETY: ranges of buffers are multiples of four bytes for every `GpuType`.
            unsafe { self.context.device.cmd_fill_buffer(self.commands, raw.buffer, raw.offset, raw.bytes, *word) };
        }
        self.end_pass();
        Ok(())
    }

    /// Copies one range into another of the same length, as a pass of its own.
    pub fn copy<T: GpuType>(&mut self, name: &'static str, from: Slice<'a, T>, to: Slice<'a, T>) -> Result<(), Error> {
        self.copy_all(name, &[(from.cast(), to.cast())])
    }

    /// Copies each range into the other of its pair, which has the same length, all in one pass: none waits for
    /// another, so that what is written must not overlap anything.
    pub fn copy_all(&mut self, name: &'static str, pairs: &[(Slice<'a, u32>, Slice<'a, u32>)]) -> Result<(), Error> {
        let ends = |(from, to): &(Slice<'a, u32>, Slice<'a, u32>)| [Touch::read(from.raw()), Touch::write(to.raw())];
        let touches: Vec<Touch> = pairs.iter().flat_map(ends).collect();
        assert!(pairs.iter().all(|(from, to)| from.len() == to.len()), "{name}: ranges of different length");
        // Validation tells of a pair whose ranges overlap.
        assert!(pairs.len() < 2 || !Touch::meet_within(&touches), "{name}: ranges that overlap");
        self.begin_pass(name, false, Kind::Other, &touches)?;
        for (from, to) in pairs {
            self.guards.note_write(to.raw());
            self.copy_command(from.raw(), to.raw());
        }
        self.end_pass();
        Ok(())
    }

    /// Copies one range into another of the same length, untimed.
    pub fn copy_untimed<T: GpuType>(&mut self, from: Slice<'a, T>, to: Slice<'a, T>) {
        assert_eq!(from.len(), to.len(), "ranges of different length");
        self.guards.note_write(to.raw());
        self.copy_raw("", from.raw(), to.raw());
    }

    /// A copy that is not timed.
    pub(super) fn copy_raw(&mut self, _name: &'static str, from: RawSlice, to: RawSlice) {
        self.barrier_before(Kind::Other, &[Touch::read(from), Touch::write(to)]);
        self.copy_command(from, to);
    }

    fn copy_command(&self, from: RawSlice, to: RawSlice) {
        let region = vk::BufferCopy { src_offset: from.offset, dst_offset: to.offset, size: from.bytes };
        // SAFETY: both ranges lie within their buffers, which outlive the submission.
        unsafe { self.context.device.cmd_copy_buffer(self.commands, from.buffer, to.buffer, &[region]) };
    }

    /// Ends, submits, waits, and reads the times. `name` says in errors what was submitted.
    pub fn submit(mut self, name: &str) -> Result<Submitted, Error> {
        self.end_condition();
        self.end_whole();
        let context = self.context.clone();
        let allowed = |left: u64| if left == u64::MAX { Some(left) } else { left.checked_sub(1) };
        if context.allowed.fetch_update(Ordering::Relaxed, Ordering::Relaxed, allowed).is_err() {
            return Err(Error::Stopped { before: name.to_owned() });
        }
        let lost = |call: &'static str| {
            let during = name.to_owned();
            move |result| match result {
                vk::Result::ERROR_DEVICE_LOST => Error::Lost { during },
                result => Error::call(call)(result),
            }
        };
        self.guards.finish(&context, self.commands);
        self.host_barrier();
        let guard = lock(&context.submission);
        let device = &context.device;
        let fence = self.taken.as_ref().map_or(vk::Fence::null(), |taken| taken.fence);
        // SAFETY: the command buffer is complete; the fence is not signaled, and is waited for here.
        let (begin, wall) = unsafe {
            device.end_command_buffer(self.commands).map_err(lost("vkEndCommandBuffer"))?;
            let command = [vk::CommandBufferSubmitInfo::default().command_buffer(self.commands)];
            let submit = vk::SubmitInfo2::default().command_buffer_infos(&command);
            let begin = Instant::now();
            let submitted = context.labelled(name, || {
                crate::fault::vulkan("submit").and_then(|()| device.queue_submit2(context.queue, &[submit], fence))
            });
            // Whoever shows pictures in a window may submit while this one waits.
            drop(guard);
            context.waits.fetch_add(1, Ordering::Relaxed);
            let result = submitted
                .and_then(|()| device.wait_for_fences(&[fence], true, u64::MAX))
                .and_then(|()| crate::fault::vulkan("wait"));
            let wall = begin.elapsed();
            result.map_err(lost("vkQueueSubmit2"))?;
            (begin, wall)
        };
        self.guards.check(&context)?;
        self.agreements.iter().try_for_each(Agreement::check)?;
        Ok(Submitted { passes: self.read_times()?, begin, wall, whole: self.read_whole()? })
    }
}

impl Drop for Recorder<'_> {
    fn drop(&mut self) {
        // Of a recording that was not submitted: validation layers remember it beyond the reset.
        self.end_condition();
        let device = &self.context.device;
        // SAFETY: either never submitted or waited for in `submit`.
        unsafe {
            for queries in &self.queries {
                device.destroy_query_pool(queries.stamps, None);
                if let Some(pool) = queries.statistics {
                    device.destroy_query_pool(pool, None);
                }
            }
        }
        // Kept and not freed: old validation layers race with whoever frees one (CONTRIBUTING.md).
        if let Some(taken) = self.taken.take() {
            self.context.give_commands_back(taken);
        }
    }
}
