//! Records passes into one command buffer: the only place for barriers, labels, timestamps, binding and dispatching.
//!
//! Passes run one after another: a full memory barrier stands before each. Timestamps are written at the end of the pipe
//! at both ends of a pass, each followed by an execution barrier, without which lavapipe's stamps shift by one interval
//! after a graphics pass.

use std::ffi::CString;
use std::marker::PhantomData;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

use ash::vk;

use super::agree::Agreement;
use super::context::{Commands, lock};
use super::guard::{self, Guards};
use super::pipeline::{Blend, Outputs, Pipeline};
use super::shader::WORKGROUP;
use super::{Access, Attachment, Context, Error, GpuType, Pass, RawSlice, Resource, Slice, Variant};

/// Passes that one pair of query pools covers.
const QUERY_PASSES: u32 = 128;
/// Descriptor sets and storage descriptors of one pool.
const POOL_SETS: u32 = 128;

/// How much a compute pass runs.
#[derive(Debug, Clone, Copy)]
pub enum Dispatch<'a> {
    /// At least this many invocations, numbered by `invocation_index` in WGSL.
    Invocations(u64),
    /// This many workgroups, numbered by `workgroup_index` in WGSL.
    Groups(u64),
    /// Workgroups x, y, z from a buffer (its first three elements).
    Indirect(Slice<'a, u32>),
}

/// How many vertices a draw has.
#[derive(Debug, Clone, Copy)]
pub enum Vertices<'a> {
    /// So many.
    Count(u32),
    /// Vertices, instances, first vertex and first instance from a buffer (its first four elements).
    Indirect(Slice<'a, u32>),
}

/// Attachments that are drawn into, all of one size and number of samples.
#[derive(Clone, Copy, Default)]
pub struct Targets<'a> {
    /// The color attachment, and what fragments do to it.
    pub color: Option<(&'a Attachment, Blend)>,
    /// The depth attachment: the nearest fragment stays, the first of equals.
    pub depth: Option<&'a Attachment>,
    /// The value of every component of the color attachment at first, with depths at 1; `None`: what an earlier draw left.
    pub clear: Option<f32>,
}

impl<'a> Targets<'a> {
    fn images(&self) -> impl Iterator<Item = &'a Attachment> {
        self.color.map(|(image, _)| image).into_iter().chain(self.depth)
    }

    fn outputs(&self) -> Outputs {
        Outputs {
            color: self.color.map(|(image, blend)| (image.format(), blend)),
            depth: self.depth.is_some(),
            samples: self.images().next().map_or(1, Attachment::samples),
        }
    }

    fn info(&self, image: &Attachment, clear: vk::ClearValue) -> vk::RenderingAttachmentInfo<'static> {
        let load = if self.clear.is_some() { vk::AttachmentLoadOp::CLEAR } else { vk::AttachmentLoadOp::LOAD };
        vk::RenderingAttachmentInfo::default()
            .image_view(image.view())
            .image_layout(DRAWN)
            .load_op(load)
            .store_op(vk::AttachmentStoreOp::STORE)
            .clear_value(clear)
    }
}

/// The layout in which attachments are drawn into.
const DRAWN: vk::ImageLayout = vk::ImageLayout::ATTACHMENT_OPTIMAL;
/// The layout in which they are read, and in which they lie between passes.
const READ: vk::ImageLayout = vk::ImageLayout::READ_ONLY_OPTIMAL;

/// A draw of plain triangles from pulled vertices, into storage buffers and attachments.
#[derive(Clone, Copy)]
pub struct Draw<'a> {
    /// Vertices.
    pub vertices: Vertices<'a>,
    /// Width and height of the area in pixels.
    pub area: [u32; 2],
    /// Attachments, if any, of that size at least.
    pub targets: Targets<'a>,
}

/// Label, variant and size of one run of a pass.
#[derive(Debug, Clone)]
pub struct Run<'a> {
    label: Option<&'static str>,
    variant: Variant,
    dispatch: Dispatch<'a>,
}

impl<'a> Run<'a> {
    /// A run of the plain variant.
    pub fn new(dispatch: Dispatch<'a>) -> Self {
        Self { label: None, variant: Variant::plain(), dispatch }
    }

    /// Under another name than the pass's own.
    pub fn label(mut self, label: &'static str) -> Self {
        self.label = Some(label);
        self
    }

    /// With a variant.
    pub fn variant(mut self, variant: Variant) -> Self {
        self.variant = variant;
        self
    }
}

/// What one pass took.
#[derive(Debug, Clone, PartialEq)]
pub struct PassTime {
    /// The pass.
    pub name: &'static str,
    /// Time between the stamps.
    pub gpu: Duration,
    /// Shader invocations, compute and fragment together; `None` where the device does not count them.
    pub invocations: Option<u64>,
}

/// A finished submission.
#[derive(Debug, Clone, PartialEq)]
pub struct Submitted {
    /// The passes in order.
    pub passes: Vec<PassTime>,
    /// From the submission to the end of waiting for it.
    pub wall: Duration,
}

struct Queries {
    stamps: vk::QueryPool,
    statistics: Option<vk::QueryPool>,
}

/// One command buffer in the making.
/// The buffers it was given stay borrowed until it is submitted, which waits for the device.
pub struct Recorder<'a> {
    context: Arc<Context>,
    commands: vk::CommandBuffer,
    taken: Commands,
    pipelines: Vec<Arc<Pipeline>>,
    pools: Vec<vk::DescriptorPool>,
    sets_left: u32,
    descriptors_left: u32,
    queries: Vec<Queries>,
    /// Name of each pass, and whether its invocations are counted.
    passes: Vec<(&'static str, bool)>,
    guards: Guards,
    agreements: Vec<Agreement>,
    buffers: PhantomData<&'a ()>,
}

impl<'a> Recorder<'a> {
    pub(super) fn new(context: &Arc<Context>) -> Result<Self, Error> {
        let commands = context.take_commands()?;
        let recorder = Self {
            context: context.clone(),
            commands: commands.buffer,
            taken: commands,
            pipelines: Vec::new(),
            pools: Vec::new(),
            sets_left: 0,
            descriptors_left: 0,
            queries: Vec::new(),
            passes: Vec::new(),
            guards: Guards::default(),
            agreements: Vec::new(),
            buffers: PhantomData,
        };
        let begin = vk::CommandBufferBeginInfo::default().flags(vk::CommandBufferUsageFlags::ONE_TIME_SUBMIT);
        // SAFETY: a command buffer that is fresh or was reset.
        unsafe { context.device.begin_command_buffer(recorder.commands, &begin) }
            .map_err(Error::call("vkBeginCommandBuffer"))?;
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
    /// # fn record<'a>(recorder: &mut Recorder<'a>, over: Over<'a>, plain: Plain<'a>, run: &Run<'a>) -> Result<(), Error> {
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
    /// # fn record<'a>(recorder: &mut Recorder<'a>, over: Over<'a>, plain: Plain<'a>, run: &Run<'a>) -> Result<(), Error> {
    /// recorder.run(&over, (), run) // wants a CountPush
    /// # }
    /// ```
    /// ```compile_fail,E0308
    /// # use pellucid_gpu::{Error, Recorder, Run, SHADERS, gpu_struct, pass};
    /// # gpu_struct! { pub struct CountPush { count: u32 } }
    /// # gpu_struct! { pub struct WidthPush { width: u32 } }
    /// # pass! { @from SHADERS; pub Over(CountPush) = "test/over" { values: ReadWrite<u32> } }
    /// # pass! { @from SHADERS; pub Plain = "test/plain" { values: ReadWrite<u32> } }
    /// # fn record<'a>(recorder: &mut Recorder<'a>, over: Over<'a>, plain: Plain<'a>, run: &Run<'a>) -> Result<(), Error> {
    /// recorder.run(&over, WidthPush { width: 3 }, run) // another pass's push constants
    /// # }
    /// ```
    /// ```compile_fail,E0308
    /// # use pellucid_gpu::{Error, Recorder, Run, SHADERS, gpu_struct, pass};
    /// # gpu_struct! { pub struct CountPush { count: u32 } }
    /// # gpu_struct! { pub struct WidthPush { width: u32 } }
    /// # pass! { @from SHADERS; pub Over(CountPush) = "test/over" { values: ReadWrite<u32> } }
    /// # pass! { @from SHADERS; pub Plain = "test/plain" { values: ReadWrite<u32> } }
    /// # fn record<'a>(recorder: &mut Recorder<'a>, over: Over<'a>, plain: Plain<'a>, run: &Run<'a>) -> Result<(), Error> {
    /// recorder.run(&plain, CountPush { count: 3 }, run) // declares none
    /// # }
    /// ```
    pub fn run<P: Pass + 'a>(&mut self, pass: &P, push: P::Push, run: &Run<'a>) -> Result<(), Error> {
        let name = run.label.unwrap_or(P::NAME);
        let (pipeline, set) = self.prepare(pass, run, name)?;
        self.begin_pass(name, true)?;
        self.dispatch::<P>(&pipeline, set, push, run)?;
        self.end_pass();
        self.pipelines.push(pipeline);
        Ok(())
    }

    /// Runs a compute pass that the submission's times know nothing of. The caller keeps its buffers until after the submission.
    pub(super) fn run_untimed<P: Pass>(&mut self, pass: &P, push: P::Push, run: &Run<'_>) -> Result<(), Error> {
        let (pipeline, set) = self.prepare(pass, run, P::NAME)?;
        self.memory_barrier();
        self.dispatch::<P>(&pipeline, set, push, run)?;
        self.pipelines.push(pipeline);
        Ok(())
    }

    fn prepare<P: Pass>(
        &mut self,
        pass: &P,
        run: &Run<'_>,
        name: &'static str,
    ) -> Result<(Arc<Pipeline>, vk::DescriptorSet), Error> {
        let pipeline = Pipeline::compute::<P>(&self.context, &run.variant)?;
        let set = self.descriptors::<P>(&pipeline, name, &pass.resources())?;
        Ok((pipeline, set))
    }

    fn dispatch<P: Pass>(
        &self,
        pipeline: &Pipeline,
        set: vk::DescriptorSet,
        push: P::Push,
        run: &Run<'_>,
    ) -> Result<(), Error> {
        let groups = self.groups(P::NAME, run.dispatch)?;
        let (device, commands) = (&self.context.device, self.commands);
        // SAFETY: the recorder holds the pipeline and the set and borrows the buffers, until the submission has been waited for.
        unsafe {
            device.cmd_bind_pipeline(commands, vk::PipelineBindPoint::COMPUTE, pipeline.raw);
            device.cmd_bind_descriptor_sets(commands, vk::PipelineBindPoint::COMPUTE, pipeline.layout, 0, &[set], &[]);
            if let Some(stages) = pipeline.push_stages {
                device.cmd_push_constants(commands, pipeline.layout, stages, 0, bytemuck::bytes_of(&push));
            }
            match run.dispatch {
                Dispatch::Indirect(arguments) => {
                    let RawSlice { buffer, offset, bytes, .. } = arguments.raw();
                    assert!(bytes >= 12, "{}: a dispatch takes three words", P::NAME);
                    device.cmd_dispatch_indirect(commands, buffer, offset);
                }
                _ => device.cmd_dispatch(commands, groups[0], groups[1], 1),
            }
        }
        Ok(())
    }

    /// For what is compared in debug builds.
    pub(super) fn context(&self) -> &Arc<Context> {
        &self.context
    }

    /// A comparison whose outcome is looked at after the submission.
    pub(super) fn keep(&mut self, agreement: Agreement) {
        self.agreements.push(agreement);
    }

    /// Runs a pass that draws, with its push constants as in [`Self::run`].
    pub fn draw<P: Pass + 'a>(
        &mut self,
        pass: &P,
        push: P::Push,
        variant: &Variant,
        draw: Draw<'a>,
    ) -> Result<(), Error> {
        let (size, limit) = (draw.area, self.context.limits.framebuffer);
        if size[0] > limit[0] || size[1] > limit[1] {
            return Err(Error::Framebuffer { name: P::NAME.to_owned(), size, limit });
        }
        let pipeline = Pipeline::draw::<P>(&self.context, variant, draw.targets.outputs())?;
        let set = self.descriptors::<P>(&pipeline, P::NAME, &pass.resources())?;
        self.begin_pass(P::NAME, true)?;
        let extent = vk::Extent2D { width: draw.area[0], height: draw.area[1] };
        let area = vk::Rect2D { offset: vk::Offset2D::default(), extent };
        let viewport = vk::Viewport {
            width: draw.area[0] as f32,
            height: draw.area[1] as f32,
            max_depth: 1.0,
            ..Default::default()
        };
        let value = draw.targets.clear.unwrap_or_default();
        let clear = vk::ClearValue { color: vk::ClearColorValue { float32: [value; 4] } };
        let far = vk::ClearValue { depth_stencil: vk::ClearDepthStencilValue { depth: 1.0, stencil: 0 } };
        let colors: Vec<_> = draw.targets.color.iter().map(|(image, _)| draw.targets.info(image, clear)).collect();
        let depth = draw.targets.depth.map(|image| draw.targets.info(image, far));
        let mut rendering = vk::RenderingInfo::default().render_area(area).layer_count(1).color_attachments(&colors);
        if let Some(depth) = &depth {
            rendering = rendering.depth_attachment(depth);
        }
        let before = if draw.targets.clear.is_some() { vk::ImageLayout::UNDEFINED } else { READ };
        self.image_barrier(draw.targets, before, DRAWN);
        let (device, commands) = (&self.context.device, self.commands);
        // SAFETY: as in `run`; the area is within the framebuffer limits. Indirect arguments lie
        // within their buffer, every buffer is made for that use, and the caller's passes never raise a count: the vertex
        // shader reads no splat beyond those that a direct draw would read.
        unsafe {
            device.cmd_begin_rendering(commands, &rendering);
            device.cmd_bind_pipeline(commands, vk::PipelineBindPoint::GRAPHICS, pipeline.raw);
            device.cmd_bind_descriptor_sets(commands, vk::PipelineBindPoint::GRAPHICS, pipeline.layout, 0, &[set], &[]);
            device.cmd_set_viewport(commands, 0, &[viewport]);
            device.cmd_set_scissor(commands, 0, &[area]);
            if let Some(stages) = pipeline.push_stages {
                device.cmd_push_constants(commands, pipeline.layout, stages, 0, bytemuck::bytes_of(&push));
            }
            match draw.vertices {
                Vertices::Count(count) => device.cmd_draw(commands, count, 1, 0, 0),
                Vertices::Indirect(arguments) => {
                    let RawSlice { buffer, offset, bytes, .. } = arguments.raw();
                    assert!(bytes >= 16, "{}: a draw takes four words", P::NAME);
                    device.cmd_draw_indirect(commands, buffer, offset, 1, 16);
                }
            }
            device.cmd_end_rendering(commands);
        }
        self.image_barrier(draw.targets, DRAWN, READ);
        self.end_pass();
        self.pipelines.push(pipeline);
        Ok(())
    }

    /// Fills a range with copies of one word, as a pass of its own.
    pub fn fill<T: GpuType>(&mut self, name: &'static str, target: Slice<'a, T>, word: u32) -> Result<(), Error> {
        self.begin_pass(name, false)?;
        let raw = target.raw();
        self.guards.note_write(raw);
        // SAFETY: ranges of buffers are multiples of four bytes for every `GpuType`.
        unsafe { self.context.device.cmd_fill_buffer(self.commands, raw.buffer, raw.offset, raw.bytes, word) };
        self.end_pass();
        Ok(())
    }

    /// Copies one range into another of the same length, as a pass of its own.
    pub fn copy<T: GpuType>(&mut self, name: &'static str, from: Slice<'a, T>, to: Slice<'a, T>) -> Result<(), Error> {
        assert_eq!(from.len(), to.len(), "{name}: ranges of different length");
        self.begin_pass(name, false)?;
        self.guards.note_write(to.raw());
        self.copy_command(from.raw(), to.raw());
        self.end_pass();
        Ok(())
    }

    /// A copy that is not timed.
    pub(super) fn copy_raw(&mut self, _name: &'static str, from: RawSlice, to: RawSlice) {
        self.memory_barrier();
        self.copy_command(from, to);
    }

    fn copy_command(&self, from: RawSlice, to: RawSlice) {
        let region = vk::BufferCopy { src_offset: from.offset, dst_offset: to.offset, size: from.bytes };
        // SAFETY: both ranges lie within their buffers, which outlive the submission.
        unsafe { self.context.device.cmd_copy_buffer(self.commands, from.buffer, to.buffer, &[region]) };
    }

    /// Ends, submits, waits, and reads the times. `name` says in errors what was submitted.
    pub fn submit(self, name: &str) -> Result<Submitted, Error> {
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
        // SAFETY: the command buffer is complete; the fence is waited for and destroyed here.
        let wall = unsafe {
            device.end_command_buffer(self.commands).map_err(lost("vkEndCommandBuffer"))?;
            let fence = device.create_fence(&vk::FenceCreateInfo::default(), None).map_err(lost("vkCreateFence"))?;
            let command = [vk::CommandBufferSubmitInfo::default().command_buffer(self.commands)];
            let submit = vk::SubmitInfo2::default().command_buffer_infos(&command);
            let start = Instant::now();
            let submitted =
                crate::fault::vulkan("submit").and_then(|()| device.queue_submit2(context.queue, &[submit], fence));
            // Whoever shows pictures in a window may submit while this one waits.
            drop(guard);
            let result = submitted
                .and_then(|()| device.wait_for_fences(&[fence], true, u64::MAX))
                .and_then(|()| crate::fault::vulkan("wait"));
            let wall = start.elapsed();
            device.destroy_fence(fence, None);
            result.map_err(lost("vkQueueSubmit2"))?;
            wall
        };
        self.guards.check(&context)?;
        self.agreements.iter().try_for_each(Agreement::check)?;
        Ok(Submitted { passes: self.read_times()?, wall })
    }

    fn read_times(&self) -> Result<Vec<PassTime>, Error> {
        let mut times = Vec::with_capacity(self.passes.len());
        for (queries, chunk) in self.queries.iter().zip(self.passes.chunks(QUERY_PASSES as usize)) {
            let mut stamps = vec![0u64; 2 * chunk.len()];
            // SAFETY: the submission has finished, so every stamp of the chunk is available.
            unsafe {
                self.context.device.get_query_pool_results(
                    queries.stamps,
                    0,
                    &mut stamps,
                    vk::QueryResultFlags::TYPE_64,
                )
            }
            .map_err(Error::call("vkGetQueryPoolResults"))?;
            for (i, (name, counted)) in chunk.iter().enumerate() {
                let ticks = stamps[2 * i + 1].saturating_sub(stamps[2 * i]);
                let gpu = Duration::from_nanos((ticks as f64 * self.context.info.timestamp_period_ns) as u64);
                let invocations = match queries.statistics {
                    Some(pool) if *counted => self.read_statistics(pool, i as u32)?,
                    _ => None,
                };
                times.push(PassTime { name, gpu, invocations });
            }
        }
        Ok(times)
    }

    fn read_statistics(&self, pool: vk::QueryPool, index: u32) -> Result<Option<u64>, Error> {
        // One query gives both counters: fragment, then compute invocations.
        let mut counters = [[0u64; 2]];
        // SAFETY: the submission has finished, and the array is as large as one query's counters.
        unsafe {
            self.context.device.get_query_pool_results(pool, index, &mut counters, vk::QueryResultFlags::TYPE_64)
        }
        .map_err(Error::call("vkGetQueryPoolResults"))?;
        Ok(Some(counters[0].iter().sum()))
    }

    /// Indirect arguments that stand for a dispatch, and a fourth word. `name` says in errors what is dispatched.
    pub fn arguments(&self, name: &str, dispatch: Dispatch<'_>) -> Result<[u32; 4], Error> {
        let [x, y] = self.groups(name, dispatch)?;
        Ok([x, y, 1, 0])
    }

    /// Workgroups in x and y; none of an indirect dispatch.
    fn groups(&self, name: &str, dispatch: Dispatch<'_>) -> Result<[u32; 2], Error> {
        match dispatch {
            Dispatch::Invocations(n) => {
                let [x, y] = self.fold_groups(name, n.div_ceil(u64::from(WORKGROUP)))?;
                // Folding rounds up; a shader's number of an invocation must not come round to 0.
                let (numbered, limit) = (u64::from(x) * u64::from(y) * u64::from(WORKGROUP), 1 << 32);
                if numbered > limit {
                    let (name, limit_name) = (name.to_owned(), "invocations of a dispatch");
                    return Err(Error::TooLarge { name, bytes: numbered, limit, limit_name });
                }
                Ok([x, y])
            }
            Dispatch::Groups(n) => self.fold_groups(name, n),
            Dispatch::Indirect(_) => Ok([0; 2]),
        }
    }

    /// Splits a number of groups over x and y, since x alone is limited.
    fn fold_groups(&self, name: &str, groups: u64) -> Result<[u32; 2], Error> {
        let limit = u64::from(self.context.limits.groups_x);
        let x = groups.clamp(1, limit);
        let y = groups.div_ceil(x).max(1);
        if y > limit.min(65_535) {
            return Err(Error::TooLarge {
                name: name.to_owned(),
                bytes: groups,
                limit: limit * 65_535,
                limit_name: "workgroups of a dispatch",
            });
        }
        Ok([x as u32, y as u32])
    }

    fn begin_pass(&mut self, name: &'static str, counted: bool) -> Result<(), Error> {
        let index = self.passes.len() as u32 % QUERY_PASSES;
        if index == 0 {
            let queries = self.new_queries()?;
            self.queries.push(queries);
        }
        self.passes.push((name, counted));
        self.memory_barrier();
        if let Some(debug) = &self.context.debug {
            let label_name = CString::new(name).unwrap_or_default();
            let label = vk::DebugUtilsLabelEXT::default().label_name(&label_name);
            // SAFETY: the extension is enabled, the command buffer is recording.
            unsafe { debug.cmd_begin_debug_utils_label(self.commands, &label) };
        }
        self.stamp(2 * index);
        if let (true, Some(pool)) = (counted, self.queries.last().and_then(|q| q.statistics)) {
            // SAFETY: the query was reset on the host when its pool was made.
            unsafe { self.context.device.cmd_begin_query(self.commands, pool, index, vk::QueryControlFlags::empty()) };
        }
        Ok(())
    }

    fn end_pass(&mut self) {
        let Some(&(_, counted)) = self.passes.last() else { return };
        let index = (self.passes.len() as u32 - 1) % QUERY_PASSES;
        if let (true, Some(pool)) = (counted, self.queries.last().and_then(|q| q.statistics)) {
            // SAFETY: begun in `begin_pass`.
            unsafe { self.context.device.cmd_end_query(self.commands, pool, index) };
        }
        self.stamp(2 * index + 1);
        if let Some(debug) = &self.context.debug {
            // SAFETY: a label was begun in `begin_pass`.
            unsafe { debug.cmd_end_debug_utils_label(self.commands) };
        }
    }

    fn stamp(&self, query: u32) {
        let Some(queries) = self.queries.last() else { return };
        let all = vk::PipelineStageFlags2::ALL_COMMANDS;
        let barrier = [vk::MemoryBarrier2::default().src_stage_mask(all).dst_stage_mask(all)];
        let dependency = vk::DependencyInfo::default().memory_barriers(&barrier);
        // SAFETY: the query is within the pool and reset; the barrier has no resources.
        unsafe {
            self.context.device.cmd_write_timestamp2(self.commands, all, queries.stamps, query);
            self.context.device.cmd_pipeline_barrier2(self.commands, &dependency);
        }
    }

    fn memory_barrier(&self) {
        full_barrier(&self.context, self.commands);
    }

    /// Takes attachments from one layout to another, if there are any.
    fn image_barrier(&self, targets: Targets<'_>, from: vk::ImageLayout, to: vk::ImageLayout) {
        let all = vk::PipelineStageFlags2::ALL_COMMANDS;
        let barriers: Vec<_> = targets
            .images()
            .map(|image| {
                vk::ImageMemoryBarrier2::default()
                    .src_stage_mask(all)
                    .src_access_mask(vk::AccessFlags2::MEMORY_WRITE)
                    .dst_stage_mask(all)
                    .dst_access_mask(vk::AccessFlags2::MEMORY_READ | vk::AccessFlags2::MEMORY_WRITE)
                    .old_layout(from)
                    .new_layout(to)
                    .image(image.raw())
                    .subresource_range(image.range())
            })
            .collect();
        if barriers.is_empty() {
            return;
        }
        let dependency = vk::DependencyInfo::default().image_memory_barriers(&barriers);
        // SAFETY: the command buffer is recording outside of a render pass; the images outlive the submission.
        unsafe { self.context.device.cmd_pipeline_barrier2(self.commands, &dependency) };
    }

    fn host_barrier(&self) {
        let barrier = [vk::MemoryBarrier2::default()
            .src_stage_mask(vk::PipelineStageFlags2::ALL_COMMANDS)
            .src_access_mask(vk::AccessFlags2::MEMORY_WRITE)
            .dst_stage_mask(vk::PipelineStageFlags2::HOST)
            .dst_access_mask(vk::AccessFlags2::HOST_READ)];
        let dependency = vk::DependencyInfo::default().memory_barriers(&barrier);
        // SAFETY: as above.
        unsafe { self.context.device.cmd_pipeline_barrier2(self.commands, &dependency) };
    }

    fn new_queries(&self) -> Result<Queries, Error> {
        let device = &self.context.device;
        let stamp_info =
            vk::QueryPoolCreateInfo::default().query_type(vk::QueryType::TIMESTAMP).query_count(2 * QUERY_PASSES);
        // SAFETY: a live device with host query reset; the pools are destroyed in drop.
        unsafe {
            let stamps = device.create_query_pool(&stamp_info, None).map_err(Error::call("vkCreateQueryPool"))?;
            device.reset_query_pool(stamps, 0, 2 * QUERY_PASSES);
            let mut queries = Queries { stamps, statistics: None };
            if self.context.info.pipeline_statistics {
                let info = vk::QueryPoolCreateInfo::default()
                    .query_type(vk::QueryType::PIPELINE_STATISTICS)
                    .query_count(QUERY_PASSES)
                    .pipeline_statistics(
                        vk::QueryPipelineStatisticFlags::FRAGMENT_SHADER_INVOCATIONS
                            | vk::QueryPipelineStatisticFlags::COMPUTE_SHADER_INVOCATIONS,
                    );
                // A failure here only leaves the counts unmeasured.
                queries.statistics = device.create_query_pool(&info, None).ok();
                if let Some(pool) = queries.statistics {
                    device.reset_query_pool(pool, 0, QUERY_PASSES);
                }
            }
            Ok(queries)
        }
    }

    fn descriptors<P: Pass>(
        &mut self,
        pipeline: &Pipeline,
        name: &'static str,
        resources: &[Resource],
    ) -> Result<vk::DescriptorSet, Error> {
        let limit = self.context.limits.binding_bytes;
        let needed = resources.len() as u32;
        if self.sets_left == 0 || self.descriptors_left < needed {
            self.new_pool()?;
        }
        self.sets_left -= 1;
        self.descriptors_left -= needed;
        let layouts = [pipeline.set_layout];
        let pool = *self.pools.last().unwrap_or(&vk::DescriptorPool::null());
        let info = vk::DescriptorSetAllocateInfo::default().descriptor_pool(pool).set_layouts(&layouts);
        // SAFETY: the pool has room for the set: counted above.
        let set = unsafe { self.context.device.allocate_descriptor_sets(&info) }
            .map_err(Error::call("vkAllocateDescriptorSets"))?[0];
        let (mut buffers, mut images) = (Vec::new(), Vec::new());
        for (resource, binding) in resources.iter().zip(P::bindings()) {
            match *resource {
                Resource::Buffer(RawSlice { bytes, .. }) if bytes > limit => {
                    let (name, limit_name) = (name.to_owned(), "maxStorageBufferRange");
                    return Err(Error::TooLarge { name, bytes, limit, limit_name });
                }
                Resource::Buffer(slice @ RawSlice { buffer, offset, bytes, .. }) => {
                    assert!(bytes > 0, "{name}: nothing is bound to {}", binding.name);
                    if binding.access == Access::ReadWrite {
                        self.guards.watch(&self.context, self.commands, (name, binding.name), slice)?;
                    }
                    let guard = if binding.access == Access::Uniform { 0 } else { guard::BYTES };
                    // What fills the device's limit goes without, which then only makes its `arrayLength` too short.
                    let range = (bytes + guard).min(self.context.limits.range_bytes.max(bytes));
                    buffers.push([vk::DescriptorBufferInfo { buffer, offset, range }]);
                }
                Resource::Texture(view) => {
                    images.push([vk::DescriptorImageInfo::default().image_view(view).image_layout(READ)]);
                }
            }
        }
        let (mut buffers, mut images) = (buffers.iter(), images.iter());
        let writes: Vec<_> = (0u32..)
            .zip(&pipeline.descriptor_types)
            .map(|(i, ty)| {
                let write = vk::WriteDescriptorSet::default().dst_set(set).dst_binding(i).descriptor_type(*ty);
                match *ty {
                    vk::DescriptorType::SAMPLED_IMAGE => write.image_info(images.next().map_or(&[], |i| i)),
                    _ => write.buffer_info(buffers.next().map_or(&[], |b| b)),
                }
            })
            .collect();
        // SAFETY: set, buffers and images are live; ranges lie within the buffers.
        unsafe { self.context.device.update_descriptor_sets(&writes, &[]) };
        Ok(set)
    }

    fn new_pool(&mut self) -> Result<(), Error> {
        let per_set = 16;
        let sizes = [
            vk::DescriptorPoolSize { ty: vk::DescriptorType::STORAGE_BUFFER, descriptor_count: per_set * POOL_SETS },
            vk::DescriptorPoolSize { ty: vk::DescriptorType::UNIFORM_BUFFER, descriptor_count: per_set * POOL_SETS },
            vk::DescriptorPoolSize { ty: vk::DescriptorType::SAMPLED_IMAGE, descriptor_count: per_set * POOL_SETS },
        ];
        let info = vk::DescriptorPoolCreateInfo::default().max_sets(POOL_SETS).pool_sizes(&sizes);
        // SAFETY: a live device; destroyed in drop.
        let pool = unsafe { self.context.device.create_descriptor_pool(&info, None) }
            .map_err(Error::call("vkCreateDescriptorPool"))?;
        self.pools.push(pool);
        (self.sets_left, self.descriptors_left) = (POOL_SETS, per_set * POOL_SETS);
        Ok(())
    }
}

impl Drop for Recorder<'_> {
    fn drop(&mut self) {
        let device = &self.context.device;
        // SAFETY: either never submitted or waited for in `submit`.
        unsafe {
            for pool in &self.pools {
                device.destroy_descriptor_pool(*pool, None);
            }
            for queries in &self.queries {
                device.destroy_query_pool(queries.stamps, None);
                if let Some(pool) = queries.statistics {
                    device.destroy_query_pool(pool, None);
                }
            }
        }
        // Kept and not freed: old validation layers race with whoever frees one (CONTRIBUTING.md).
        self.context.give_commands_back(self.taken);
    }
}

/// What was written before is seen by everything that comes after.
pub(super) fn full_barrier(context: &Context, commands: vk::CommandBuffer) {
    let all = vk::PipelineStageFlags2::ALL_COMMANDS;
    let barrier = [vk::MemoryBarrier2::default()
        .src_stage_mask(all)
        .src_access_mask(vk::AccessFlags2::MEMORY_WRITE)
        .dst_stage_mask(all)
        .dst_access_mask(vk::AccessFlags2::MEMORY_READ | vk::AccessFlags2::MEMORY_WRITE)];
    let dependency = vk::DependencyInfo::default().memory_barriers(&barrier);
    // SAFETY: the command buffer is recording outside of a render pass; the barrier has no resources.
    unsafe { context.device.cmd_pipeline_barrier2(commands, &dependency) };
}
