//! Rows: the times of a method on a scene in a size, as a whole and of each pass.

use pellucid_engine::Result;
use pellucid_engine::methods::{self, Frame, FrameProfile, Outputs, PassProfile, Renderer};
use pellucid_engine::passes::project::DeviceCloud;
use pellucid_engine::profile::median;
use pellucid_engine::totals::{self, Effort};
use pellucid_gpu::{Device, Yardstick};
use serde_json::{Value, json};

use crate::scenes::{self, Loaded, Plan};
use crate::{Bounds, lines};

/// Frames whose passes are timed one by one.
const STAMPED: usize = 5;

/// How a row came out.
enum Row {
    Measured(Value),
    /// The frame doesn't fit the device, or the device lacks something.
    Refused(String),
    Failed(String),
    LeftOut,
}

/// Prints a row for each method of each plan; true if none failed or was left out.
pub fn run(device: &Device, bounds: Bounds) -> Result<bool> {
    let plans: &[Plan] = if bounds.quick { &scenes::QUICK } else { &scenes::ALL };
    let yardstick = Yardstick::new(device)?;
    let (mut loaded, mut good, mut measured): (Option<Loaded>, bool, usize) = (None, true, 0);
    for plan in plans {
        if loaded.as_ref().is_none_or(|loaded| loaded.source != plan.source) && !bounds.is_over() {
            // Makes room first.
            drop(loaded.take());
            loaded = Some(Loaded::new(plan)?);
        }
        // All methods but those of ensembles share the points.
        let mut shared: Option<DeviceCloud> = None;
        for name in plan.methods {
            let row = match &loaded {
                Some(scene) if !bounds.is_over() => row(device, &yardstick, (scene, plan, name), &mut shared, bounds),
                _ => Row::LeftOut,
            };
            let line = json!({ "scene": plan.scene, "size": plan.size, "method": name });
            match row {
                Row::Measured(Value::Object(times)) => {
                    let mut line = line;
                    times.into_iter().for_each(|(key, value)| line[key.as_str()] = value);
                    measured += 1;
                    lines::put("row", line);
                }
                Row::Measured(_) => good = false,
                Row::Refused(why) => lines::put_missing("row", line, "refused", &why),
                Row::Failed(why) => {
                    good = false;
                    lines::put_missing("row", line, "failed", &why);
                }
                Row::LeftOut => {
                    good = false;
                    lines::put_missing("row", line, "left_out", "the time was over");
                }
            }
        }
    }
    let planned: usize = plans.iter().map(|plan| plan.methods.len()).sum();
    lines::put("rows", json!({ "planned": planned, "measured": measured }));
    Ok(good)
}

fn row(
    device: &Device,
    yardstick: &Yardstick,
    (loaded, plan, name): (&Loaded, &Plan, &str),
    shared: &mut Option<DeviceCloud>,
    bounds: Bounds,
) -> Row {
    let Some(method) = scenes::method(name) else { return Row::Failed("no such method".to_owned()) };
    let scene = loaded.with(method, plan.size);
    let mut work = || -> std::result::Result<Value, methods::Error> {
        let mut renderer = Renderer::new(device)?;
        if method.is_dealt() {
            // Makes room first: both hold the points.
            *shared = None;
            let mut cloud = renderer.upload(&scene.arranged())?;
            return measure(&mut renderer, &mut cloud, &scene.frame, yardstick, bounds);
        }
        if shared.is_none() {
            *shared = Some(renderer.upload(&scene.arranged())?);
        }
        let Some(cloud) = shared else { return Err(methods::Error::Cancelled) };
        measure(&mut renderer, cloud, &scene.frame, yardstick, bounds)
    };
    let found = work();
    let messages = device.check_validation();
    match (found, messages) {
        (Ok(times), Ok(())) => Row::Measured(times),
        (Ok(_), Err(error)) => Row::Failed(error.to_string()),
        (Err(error), _) if error.is_refusal() => Row::Refused(error.to_string()),
        (Err(error), _) => Row::Failed(error.to_string()),
    }
}

/// Totals first, then the passes, in frames of their own.
fn measure(
    renderer: &mut Renderer,
    cloud: &mut DeviceCloud,
    frame: &Frame,
    yardstick: &Yardstick,
    bounds: Bounds,
) -> std::result::Result<Value, methods::Error> {
    let effort = if bounds.quick { Effort::LOOK } else { Effort::RELIABLE };
    // The picture stays on the device, so that the host does as little as can be between two frames.
    let staying = Frame { outputs: Outputs::SCREEN, ..*frame };
    let totals = totals::measure(renderer, cloud, &staying, Some(yardstick), effort)?;
    let mut profiles: Vec<FrameProfile> = Vec::new();
    let mut facts = None;
    // The first of these has the picture's memory made.
    for number in 0..=if bounds.quick { 1 } else { STAMPED } {
        let rendered = renderer.render(cloud, frame)?;
        renderer.recycle(rendered.image);
        if number > 0 {
            profiles.push(rendered.profile);
        }
        facts = Some(rendered.facts);
    }
    let mut times = totals.to_json();
    times["passes"] = passes(&profiles);
    times["stamped_ms"] = median(profiles.iter().map(|profile| profile.gpu().as_secs_f64() * 1e3).collect()).into();
    // With all of the picture on the host.
    times["wall_ms"] = median(profiles.iter().map(|profile| profile.wall.as_secs_f64() * 1e3).collect()).into();
    if let Some(facts) = facts {
        times["points"] = facts.points.into();
        times["fragments"] = facts.fragments.into();
        times["longest"] = facts.max_list.into();
        times["peak_bytes"] = facts.peak_device_bytes.saturating_sub(yardstick.bytes()).into();
    }
    Ok(lines::all_rounded(times))
}

/// Name, median of ms, invocations and least bytes of each pass.
fn passes(profiles: &[FrameProfile]) -> Value {
    let Some(first) = profiles.first() else { return json!([]) };
    let named = |name: &str| -> Vec<&PassProfile> {
        profiles.iter().flat_map(|profile| &profile.passes).filter(|pass| pass.name == name).collect()
    };
    let line = |pass: &PassProfile| {
        let all = named(pass.name);
        let times = median(all.iter().map(|pass| pass.gpu.as_secs_f64() * 1e3).collect());
        json!([pass.name, times, pass.invocations, pass.bytes])
    };
    first.passes.iter().map(line).collect()
}
