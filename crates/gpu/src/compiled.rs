//! Statistics of a driver's compiler about a pipeline: registers, scratch, occupancy
//! (VK_KHR_pipeline_executable_properties).

use std::sync::Arc;
use std::time::{Duration, Instant};

use ash::{khr, vk};

use super::context::lock;
use super::pipeline::{Pipeline, PipelineSource};
use super::{Declaration, Device, Error, Outputs, Variant};

/// A pipeline as the driver compiled it.
#[derive(Debug, Clone, PartialEq)]
pub struct Compiled {
    /// Time from SPIR-V to the pipeline.
    pub time: Duration,
    /// The driver's executables: one for each stage, or more where a driver cuts stages.
    pub executables: Vec<Executable>,
}

/// A piece of a pipeline that the driver compiled as a whole.
#[derive(Debug, Clone, PartialEq)]
pub struct Executable {
    /// The driver's name of it.
    pub name: String,
    /// Invocations of a subgroup; 0 if the driver doesn't say.
    pub subgroup: u32,
    /// The driver's own statistics, names and values.
    pub statistics: Vec<(String, f64)>,
}

impl Device {
    /// Compiles a variant of a pass, to draw where there are `outputs`, and asks the driver what became of it. Nothing
    /// runs.
    ///
    /// # Errors
    /// The shader does not compile, or the device was opened without
    /// [`DeviceOptions::statistics`](super::DeviceOptions::statistics).
    pub(super) fn compiled(
        &self,
        pass: &Declaration,
        variant: &Variant,
        outputs: Option<Outputs>,
    ) -> Result<Compiled, Error> {
        let context = &self.0;
        let Some(loader) = &context.executables else {
            let missing = "pipelineExecutableInfo, or it was not asked for".to_owned();
            return Err(Error::Lacks { device: context.info.name.clone(), missing });
        };
        let begin = Instant::now();
        let pipeline = match outputs {
            None => Pipeline::compute(context, pass, variant, pass.name)?,
            Some(outputs) => Pipeline::draw(context, pass, variant, outputs)?,
        };
        let time = begin.elapsed();
        Ok(Compiled { time, executables: executables(loader, &pipeline)? })
    }

    /// Returns what the driver says of every pipeline so far, in no order; `None` where it doesn't tell, or the device
    /// was opened without [`DeviceOptions::statistics`](super::DeviceOptions::statistics).
    ///
    /// # Errors
    /// Vulkan errors.
    pub fn compiled_pipelines(&self) -> Result<Option<Vec<CompiledPipeline>>, Error> {
        let Some(loader) = &self.0.executables else { return Ok(None) };
        let pipelines: Vec<_> = lock(&self.0.pipelines).values().cloned().collect();
        let told = |pipeline: Arc<Pipeline>| Ok((pipeline.made.clone(), executables(loader, &pipeline)?));
        pipelines.into_iter().map(told).collect::<Result<_, _>>().map(Some)
    }
}

/// A pipeline, and the programs that the driver made of it.
pub type CompiledPipeline = (PipelineSource, Vec<Executable>);

/// Asks the driver about a pipeline that was made with the flag for statistics.
fn executables(
    loader: &khr::pipeline_executable_properties::Device,
    pipeline: &Pipeline,
) -> Result<Vec<Executable>, Error> {
    let info = vk::PipelineInfoKHR::default().pipeline(pipeline.raw);
    // SAFETY: the pipeline is alive and was made with the flag for statistics.
    let listed = unsafe { loader.get_pipeline_executable_properties(&info) }
        .map_err(Error::call("vkGetPipelineExecutablePropertiesKHR"))?;
    let mut executables = Vec::new();
    for (index, properties) in (0u32..).zip(&listed) {
        let info = vk::PipelineExecutableInfoKHR::default().pipeline(pipeline.raw).executable_index(index);
        // SAFETY: as above, and the index is one of those listed.
        let found = unsafe { loader.get_pipeline_executable_statistics(&info) }
            .map_err(Error::call("vkGetPipelineExecutableStatisticsKHR"))?;
        let name = properties.name_as_c_str().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
        let statistics = found.iter().map(|statistic| {
            let name = statistic.name_as_c_str().map(|name| name.to_string_lossy().into_owned());
            (name.unwrap_or_default(), number(statistic))
        });
        executables.push(Executable { name, subgroup: properties.subgroup_size, statistics: statistics.collect() });
    }
    Ok(executables)
}

fn number(statistic: &vk::PipelineExecutableStatisticKHR<'_>) -> f64 {
    use vk::PipelineExecutableStatisticFormatKHR as Format;
    // SAFETY: the format says which member the driver has written.
    unsafe {
        match statistic.format {
            Format::BOOL32 => f64::from(statistic.value.b32),
            Format::INT64 => statistic.value.i64 as f64,
            Format::UINT64 => statistic.value.u64 as f64,
            Format::FLOAT64 => statistic.value.f64,
            _ => f64::NAN,
        }
    }
}
