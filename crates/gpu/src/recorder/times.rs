//! Labels, timestamps and counts of invocations around each pass.

use std::ffi::CString;
use std::time::{Duration, Instant};

use ash::vk;

use super::Recorder;
use super::barriers::{Kind, Touch};
use crate::Error;
use crate::clock::Calibrator;

/// Passes that one pair of query pools covers.
const QUERY_PASSES: u32 = 128;

/// Time and work of one pass.
#[derive(Debug, Clone, PartialEq)]
pub struct PassTime {
    /// The pass.
    pub name: &'static str,
    /// Time between the stamps.
    pub gpu: Duration,
    /// Time of the first of them by the host's clock; `None` where the device can't tell what its own clock shows
    /// (VK_KHR_calibrated_timestamps).
    pub begin: Option<Instant>,
    /// Shader invocations, compute and fragment together; `None` where the device does not count them.
    pub invocations: Option<u64>,
}

/// Places at which a recorder writes timestamps.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Stamps {
    /// Nowhere.
    #[default]
    None,
    /// Beginning and end of what is submitted, without barriers between passes that need none.
    Ends,
    /// Both ends of each pass; barriers separate the passes, and their invocations are counted.
    Passes,
}

pub(super) struct Queries {
    pub(super) stamps: vk::QueryPool,
    pub(super) statistics: Option<vk::QueryPool>,
}

impl Recorder<'_> {
    pub(super) fn begin_pass(
        &mut self,
        name: &'static str,
        counted: bool,
        kind: Kind,
        touches: &[Touch],
    ) -> Result<(), Error> {
        let index = self.passes.len() as u32 % QUERY_PASSES;
        let is_stamped = self.stamps == Stamps::Passes;
        if is_stamped {
            if index == 0 {
                let queries = self.new_queries()?;
                self.queries.push(queries);
            }
            self.passes.push((name, counted));
        }
        self.barrier_before(kind, touches);
        if let Some(debug) = &self.context.debug {
            let label_name = CString::new(name).unwrap_or_default();
            let label = vk::DebugUtilsLabelEXT::default().label_name(&label_name);
            // SAFETY: the extension is enabled, the command buffer is recording.
            unsafe { debug.cmd_begin_debug_utils_label(self.commands, &label) };
        }
        if !is_stamped {
            return Ok(());
        }
        self.stamp(2 * index);
        if let (true, Some(pool)) = (counted, self.queries.last().and_then(|q| q.statistics)) {
            // SAFETY: the query was reset on the host when its pool was made.
            unsafe { self.context.device.cmd_begin_query(self.commands, pool, index, vk::QueryControlFlags::empty()) };
        }
        Ok(())
    }

    pub(super) fn end_pass(&mut self) {
        self.stamp_end();
        if let Some(debug) = &self.context.debug {
            // SAFETY: a label was begun in `begin_pass`.
            unsafe { debug.cmd_end_debug_utils_label(self.commands) };
        }
    }

    fn stamp_end(&self) {
        let Some(&(_, counted)) = self.passes.last() else { return };
        let index = (self.passes.len() as u32 - 1) % QUERY_PASSES;
        if let (true, Some(pool)) = (counted, self.queries.last().and_then(|q| q.statistics)) {
            // SAFETY: begun in `begin_pass`.
            unsafe { self.context.device.cmd_end_query(self.commands, pool, index) };
        }
        self.stamp(2 * index + 1);
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

    /// Writes the first of two timestamps around what is submitted.
    pub(super) fn begin_whole(&mut self) -> Result<(), Error> {
        let stamps = self.new_stamps(2)?;
        self.queries.push(Queries { stamps, statistics: None });
        self.stamp(0);
        Ok(())
    }

    /// Writes the second of them.
    pub(super) fn end_whole(&self) {
        if self.stamps == Stamps::Ends {
            self.stamp(1);
        }
    }

    /// Returns the time between them, once all was submitted and waited for; `None` where there are none.
    pub(super) fn read_whole(&self) -> Result<Option<Duration>, Error> {
        let Some(queries) = self.queries.first().filter(|_| self.stamps == Stamps::Ends) else { return Ok(None) };
        let mut stamps = [0u64; 2];
        // SAFETY: the submission has finished, so both stamps are available.
        unsafe {
            let device = &self.context.device;
            device.get_query_pool_results(queries.stamps, 0, &mut stamps, vk::QueryResultFlags::TYPE_64)
        }
        .map_err(Error::call("vkGetQueryPoolResults"))?;
        Ok(Some(self.context.clock.between(stamps)))
    }

    /// A pool of timestamps, which is destroyed in drop once it is among the queries.
    fn new_stamps(&self, count: u32) -> Result<vk::QueryPool, Error> {
        let device = &self.context.device;
        let info = vk::QueryPoolCreateInfo::default().query_type(vk::QueryType::TIMESTAMP).query_count(count);
        // SAFETY: a live device with host query reset.
        unsafe {
            let stamps = device.create_query_pool(&info, None).map_err(Error::call("vkCreateQueryPool"))?;
            device.reset_query_pool(stamps, 0, count);
            Ok(stamps)
        }
    }

    fn new_queries(&self) -> Result<Queries, Error> {
        let mut queries = Queries { stamps: self.new_stamps(2 * QUERY_PASSES)?, statistics: None };
        let device = &self.context.device;
        // SAFETY: a live device with host query reset; the pools are destroyed in drop.
        unsafe {
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

    pub(super) fn read_times(&self) -> Result<Vec<PassTime>, Error> {
        let mut times = Vec::with_capacity(self.passes.len());
        let clock = self.context.clock;
        // Now, so that the clocks have no time to drift apart.
        let timed = (!self.passes.is_empty()).then_some(self.context.calibrator.as_ref()).flatten();
        let calibration = timed.and_then(Calibrator::read);
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
                let gpu = clock.between([stamps[2 * i], stamps[2 * i + 1]]);
                let begin = calibration.map(|read| read.time_of(clock, stamps[2 * i]));
                let invocations = match queries.statistics {
                    Some(pool) if *counted => self.read_statistics(pool, i as u32)?,
                    _ => None,
                };
                times.push(PassTime { name, gpu, begin, invocations });
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
}
