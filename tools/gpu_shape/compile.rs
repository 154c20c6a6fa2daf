//! Compiles recorded pipelines on RADV's null device, in a process of its own: the loader picks drivers once per
//! process.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use pellucid_gpu::{Compiled, Device, DeviceOptions};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use crate::record::{self, Recorded};

/// Paths of RADV's manifest in distributions: Mesa renamed the file with version 24.
const MANIFESTS: [&str; 2] =
    ["/usr/share/vulkan/icd.d/radeon_icd.json", "/usr/share/vulkan/icd.d/radeon_icd.x86_64.json"];

/// Installation of RADV.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Driver {
    manifest: PathBuf,
    libraries: Option<PathBuf>,
}

impl Default for Driver {
    fn default() -> Self {
        let known = MANIFESTS.iter().map(PathBuf::from).find(|path| path.is_file());
        Self { manifest: known.unwrap_or_else(|| MANIFESTS[0].into()), libraries: None }
    }
}

impl Driver {
    pub fn parse(text: &str) -> Result<Self, String> {
        let (manifest, libraries) = text.split_once(',').map_or((text, None), |(m, l)| (m, Some(l)));
        let there = |path: &str| Path::new(path).canonicalize().map_err(|e| format!("{path}: {e}"));
        Ok(Self { manifest: there(manifest)?, libraries: libraries.map(there).transpose()? })
    }
}

/// Invocations of the subgroups of passes that have no say in them. Those that have take 32.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Lanes {
    ThirtyTwo,
    SixtyFour,
}

/// Results of compiling some pipelines, in their order.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Shapes {
    /// Name and version of device and driver.
    pub device: String,
    /// `None` for a pipeline whose compilation ended the process: the driver's fault.
    pub pipelines: Vec<Option<Shape>>,
}

/// Waves that a SIMD can hold, whatever they need. Mesa 22.3 states more.
const MOST_WAVES: f64 = 16.0;

/// Result of compiling a pipeline; for several stages the worst of each value.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Shape {
    pub lanes: u32,
    /// Vector registers of a lane, scalar registers of a wave, and those of them that went to memory.
    pub vgprs: f64,
    pub sgprs: f64,
    pub spilled_vgprs: f64,
    pub spilled_sgprs: f64,
    /// Bytes of private memory: a wave's over its lanes.
    pub scratch_bytes: f64,
    /// Bytes that a workgroup shares.
    pub lds_bytes: f64,
    /// Waves that a SIMD can hold at a time, of 16.
    pub waves: f64,
    pub code_bytes: f64,
    /// Cycles that a wave takes, and that it keeps a SIMD busy per 64 invocations where others hide its latency. The
    /// compiler counts a loop as 8 turns.
    pub latency: f64,
    pub inverse_throughput: f64,
    /// Time from WGSL, or kept SPIR-V, to the pipeline.
    pub compile_ms: f64,
}

/// Compiles the pipelines for `family`. Where the driver crashes, the others have their shapes all the same.
pub fn on(driver: &Driver, family: &str, lanes: Lanes, recorded: &[Recorded]) -> Result<Shapes, String> {
    if !driver.manifest.is_file() {
        let hint = "install mesa-vulkan-drivers, or name RADV's manifest with --driver";
        return Err(format!("{}: no such file; {hint}", driver.manifest.display()));
    }
    let compile = |some: &[Recorded]| {
        eprintln!("compiling {} pipelines for {family}", some.len());
        in_child(driver, family, lanes, some).map_err(|what| format!("{family}: {what}"))
    };
    // With nothing to compile, a process that crashes says that the driver doesn't know the GPU.
    let opened = compile(&[])?.ok_or_else(|| format!("{family}: the driver crashes before it compiles anything"))?;
    let mut pipelines = Vec::new();
    halved(recorded, &mut |some| Ok(compile(some)?.map(|shapes| shapes.pipelines)), &mut pipelines)?;
    Ok(Shapes { device: opened.device, pipelines })
}

/// Appends the outcomes of `compile` to `found`. A list that crashes it (`None`) is compiled again by halves, down to
/// the items that crash it alone.
fn halved<T, S>(
    list: &[T],
    compile: &mut impl FnMut(&[T]) -> Result<Option<Vec<Option<S>>>, String>,
    found: &mut Vec<Option<S>>,
) -> Result<(), String> {
    match (compile(list)?, list) {
        (Some(shapes), _) => found.extend(shapes),
        (None, [] | [_]) => found.extend(list.iter().map(|_| None)),
        (None, _) => {
            let (before, behind) = list.split_at(list.len() / 2);
            halved(before, compile, found)?;
            halved(behind, compile, found)?;
        }
    }
    Ok(())
}

/// Compiles the pipelines in a process of their own; `None` if a signal ended it.
fn in_child(driver: &Driver, family: &str, lanes: Lanes, recorded: &[Recorded]) -> Result<Option<Shapes>, String> {
    let folder = tempfile::tempdir().map_err(|e| format!("a folder for the list: {e}"))?;
    let list = folder.path().join("pipelines.json");
    let text = serde_json::to_string(recorded).map_err(|e| e.to_string())?;
    std::fs::write(&list, text).map_err(|e| e.to_string())?;
    let program = std::env::current_exe().map_err(|e| format!("this program's path: {e}"))?;
    let mut command = Command::new(program);
    command.arg("--compile").arg(&list).stdout(Stdio::piped());
    // The older variable would win in old loaders.
    command.env("VK_DRIVER_FILES", &driver.manifest).env_remove("VK_ICD_FILENAMES").env_remove("PELLUCID_VALIDATION");
    // Shaders as a release build has them.
    command.env("PELLUCID_CHECKS", "0");
    // So that everything is compiled, and its time measured.
    command.env("MESA_SHADER_CACHE_DISABLE", "true");
    command.env("RADV_FORCE_FAMILY", family);
    match lanes {
        Lanes::ThirtyTwo => command.env("RADV_PERFTEST", "cswave32,pswave32"),
        Lanes::SixtyFour => command.env_remove("RADV_PERFTEST"),
    };
    match &driver.libraries {
        Some(libraries) => command.env("LD_LIBRARY_PATH", libraries),
        None => command.env_remove("LD_LIBRARY_PATH"),
    };
    let output = command.spawn().and_then(std::process::Child::wait_with_output).map_err(|e| e.to_string())?;
    match output.status.code() {
        Some(0) => serde_json::from_slice(&output.stdout).map(Some).map_err(|e| format!("its answer: {e}")),
        Some(_) => Err(format!("its process ended with {}", output.status)),
        None => Ok(None),
    }
}

/// Compiles a list's pipelines on the only device there is, and prints what became of them.
pub fn child(list: &Path) -> Result<(), String> {
    let text = std::fs::read(list).map_err(|e| format!("{}: {e}", list.display()))?;
    let recorded: Vec<Recorded> = serde_json::from_slice(&text).map_err(|e| format!("{}: {e}", list.display()))?;
    let options = DeviceOptions { statistics: true, ..DeviceOptions::default() };
    let device = Device::open(&options).map_err(|e| e.to_string())?;
    let info = device.info();
    let lanes = info.subgroup.ok_or_else(|| format!("{} has no subgroups of up to 32", info.name))?;
    let shaders = record::shaders();
    let pipelines = recorded
        .par_iter()
        .map(|recorded| {
            let (shader, variant, outputs) = recorded.rebuilt(&shaders, lanes);
            let compiled = shader.compiled(&device, &variant, outputs);
            compiled.map(|compiled| Some(shape(&compiled))).map_err(|e| format!("{}: {e}", recorded.label))
        })
        .collect::<Result<Vec<_>, String>>()?;
    let shapes = Shapes { device: format!("{}, {}", info.name, info.driver), pipelines };
    println!("{}", serde_json::to_string(&shapes).map_err(|e| e.to_string())?);
    // RADV of Mesa 22.3 crashes when a null device is destroyed.
    std::mem::forget(device);
    Ok(())
}

/// The worst of the stages.
fn shape(compiled: &Compiled) -> Shape {
    let values = |name: &'static str| {
        let of = move |e: &pellucid_gpu::Executable| {
            e.statistics.iter().find(|(known, _)| known.eq_ignore_ascii_case(name)).map(|(_, value)| *value)
        };
        compiled.executables.iter().filter_map(of)
    };
    let most = |name| values(name).fold(0.0, f64::max);
    let lanes = compiled.executables.iter().map(|e| e.subgroup).max().unwrap_or(0);
    Shape {
        lanes,
        vgprs: most("VGPRs"),
        sgprs: most("SGPRs"),
        spilled_vgprs: most("Spilled VGPRs"),
        spilled_sgprs: most("Spilled SGPRs"),
        // The driver states a wave's.
        scratch_bytes: most("Scratch size") / f64::from(lanes.max(1)),
        lds_bytes: most("LDS size"),
        waves: values("Subgroups per SIMD").fold(MOST_WAVES, f64::min),
        code_bytes: most("Code size"),
        latency: most("Latency"),
        inverse_throughput: most("Inverse Throughput"),
        compile_ms: compiled.time.as_secs_f64() * 1e3,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use pellucid_gpu::Executable;

    #[test]
    fn of_a_list_that_crashes_only_those_that_crash_alone_have_no_shape() {
        let mut lists = 0;
        let mut compile = |some: &[u32]| {
            lists += 1;
            let crashes = some.iter().any(|n| [3, 6].contains(n));
            Ok((!crashes).then(|| some.iter().map(|n| Some(n * 10)).collect()))
        };
        let mut found = Vec::new();
        halved(&[0, 1, 2, 3, 4, 5, 6, 7], &mut compile, &mut found).expect("no list is refused");
        assert_eq!(found, [Some(0), Some(10), Some(20), None, Some(40), Some(50), None, Some(70)]);
        // All; of each half, a good quarter and a bad one, which has two items.
        assert_eq!(lists, 1 + 2 * (1 + 2 + 2));
        let refused = halved(&[1, 2], &mut |_| Err("unknown".into()), &mut Vec::<Option<u32>>::new());
        assert_eq!(refused, Err("unknown".to_owned()));
    }

    #[test]
    fn a_shape_is_the_worst_of_the_stages() {
        let stage = |waves: f64, vgprs: f64| Executable {
            name: "stage".into(),
            subgroup: 32,
            statistics: vec![
                ("Subgroups per SIMD".into(), waves),
                ("VGPRs".into(), vgprs),
                ("Scratch size".into(), 64.0),
            ],
        };
        let time = std::time::Duration::from_millis(5);
        let found = shape(&Compiled { time, executables: vec![stage(16.0, 24.0), stage(8.0, 12.0)] });
        assert_eq!((found.waves, found.vgprs, found.scratch_bytes, found.compile_ms), (8.0, 24.0, 2.0, 5.0));
    }
}
