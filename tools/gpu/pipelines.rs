//! Facts of the driver about each pipeline: registers, code, private memory, under the driver's own names.

use pellucid_engine::Result;
use pellucid_engine::methods::Renderer;
use pellucid_gpu::{Device, Error, Executable, PipelineSource};
use pellucid_lab::check::{self, Lack};
use rayon::prelude::*;
use serde_json::{Map, Value, json};

use crate::{Bounds, lines};

/// Subjects whose pipelines are enough for a look.
const FEW: usize = 3;

/// Renders the subjects of `pellucid check`, and prints a line for each pipeline that this made; true if none failed.
pub fn run(device: &Device, bounds: Bounds) -> Result<bool> {
    let subjects = check::subjects();
    let few = if bounds.quick { FEW } else { subjects.len() };
    let (mut renderer, mut good) = (Renderer::new(device)?, true);
    for subject in subjects.iter().take(few) {
        if let Err(error) = subject.render(&mut renderer)
            && Lack::in_error(&error).is_none()
        {
            good = false;
            lines::put_missing("pipeline", json!({ "label": subject.name }), "failed", &error.to_string());
        }
    }
    drop(renderer);
    let mut made = device.made();
    made.sort_by(|a, b| (a.label, a.variant.key()).cmp(&(b.label, b.variant.key())));
    let shaders: Vec<_> = pellucid_engine::shaders().into_iter().chain(pellucid_gpu::shaders()).collect();
    let statistics = |source: &PipelineSource| -> std::result::Result<Vec<Value>, Error> {
        let shader = shaders.iter().find(|s| s.pass.name == source.pass && s.pass.shader == source.stem);
        let Some(shader) = shader else { return Ok(Vec::new()) };
        let compiled = shader.compiled(device, &source.variant, source.outputs)?;
        let of = |executable: &Executable| {
            let values = executable.statistics.iter().map(|(name, value)| (name.clone(), json!(value)));
            let values: Map<_, _> = values.collect();
            json!({ "stage": executable.name, "lanes": executable.subgroup, "statistics": values })
        };
        Ok(compiled.executables.iter().map(of).collect())
    };
    let found: Vec<_> = made.par_iter().map(|source| (source, statistics(source))).collect();
    let mut counted = 0;
    for (source, found) in found {
        // Overrides alone tell most variants apart.
        let values = source.variant.overrides.iter().map(|(name, value)| ((*name).to_owned(), json!(value)));
        let line = json!({ "label": source.label, "overrides": values.collect::<Map<_, _>>() });
        match found {
            Ok(executables) => {
                counted += 1;
                let mut line = line;
                line["executables"] = executables.into();
                lines::put("pipeline", line);
            }
            Err(Error::Lacks { missing, .. }) => {
                lines::put("pipelines", json!({ "lacks": missing, "made": made.len() }));
                return Ok(good);
            }
            Err(error) => {
                good = false;
                lines::put_missing("pipeline", line, "failed", &error.to_string());
            }
        }
    }
    lines::put("pipelines", json!({ "made": made.len(), "counted": counted }));
    Ok(good && counted == made.len())
}
