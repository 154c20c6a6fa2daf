//! The cost of the first frame, and of one after a change.

use std::fmt::Write;
use std::path::Path;
use std::time::Instant;

use pellucid_engine::Result;
use pellucid_engine::methods::{Factors, Frame, Renderer};
use pellucid_engine::passes::project::DeviceCloud;
use pellucid_gpu::Device;
use pellucid_lab::report::stress::Spread;
use pellucid_scene::{Density, Method, Soft};

use super::Contender;
use super::scenes::SoftScene;

/// A model of soft transparency.
type Model = fn(Soft) -> Method;

const MODELS: [(&str, Model); 3] = [
    ("soft-base", Method::SoftBase),
    ("soft-concentric", Method::SoftConcentric),
    ("soft-express", Method::SoftExpress),
];

/// The changes.
const CHANGES: [&str; 6] = ["nothing", "threshold", "softness", "modulation", "radius", "view"];

/// A frame that differs from the first one by a change, and from the frames of other rounds by how much of it.
fn changed(subject: &SoftScene, change: &str, model: Model, round: usize) -> Frame {
    let (mut frame, mut soft) = (subject.frame, subject.soft);
    let amount = 0.002 * (round + 1) as f32;
    match change {
        "threshold" => soft.threshold = (soft.threshold - amount).max(0.0),
        "softness" => soft.density = Density::Softness(0.5 + amount),
        "modulation" => soft.modulation = Some((soft.threshold + 0.1 + amount).min(1.0)),
        "radius" => frame.factors = Factors { radius: 1.0 + amount, ..Factors::default() },
        "view" => frame.camera.eye += f64::from(amount) * frame.camera.right,
        _ => {}
    }
    Frame { method: model(soft), ..frame }
}

/// Writes `second.md` and `second.csv`.
pub fn measure(device: &Device, subject: &SoftScene, rounds: usize, folder: &Path) -> Result<()> {
    let mut markdown = String::from(
        "| method | frame after a change of | ms | of a repeated frame | bytes uploaded |\n|---|---|---|---|---|\n",
    );
    let mut csv = String::from("method,change,wall_ms,over_repeated,uploaded_bytes\n");
    for (name, model) in MODELS {
        let before = device.uploaded_bytes();
        let start = Instant::now();
        let mut cloud = Renderer::new(device)?.upload(&subject.points)?;
        let upload = Timed { ms: start.elapsed().as_secs_f64() * 1e3, bytes: device.uploaded_bytes() - before };
        let mut contender = Contender::new(device, name, model(subject.soft))?;
        let first = timed(device, &mut contender, &mut cloud, &subject.frame)?;
        let mut after = [const { Vec::new() }; CHANGES.len()];
        for round in 0..=rounds {
            for (change, frames) in CHANGES.iter().zip(&mut after) {
                let frame = changed(subject, change, model, round);
                contender.method = frame.method;
                let timed = timed(device, &mut contender, &mut cloud, &frame)?;
                // The first round may meet a pipeline for the first time.
                if round > 0 {
                    frames.push(timed);
                }
            }
        }
        let median = |frames: &[Timed]| Timed {
            ms: Spread::from_values(frames.iter().map(|frame| frame.ms).collect()).median,
            bytes: frames.iter().map(|frame| frame.bytes).max().unwrap_or(0),
        };
        let repeated = median(&after[0]).ms;
        let after = CHANGES.iter().copied().zip(after.iter().map(|frames| median(frames)));
        for (change, Timed { ms, bytes }) in [("(upload)", upload), ("(first frame)", first)].into_iter().chain(after) {
            let over = ms / repeated;
            // Writing into a string can't fail.
            let _ = writeln!(markdown, "| {name} | {change} | {ms:.1} | {over:.2} | {bytes} |");
            let _ = writeln!(csv, "{name},{change},{ms},{over},{bytes}");
        }
    }
    println!("\n{markdown}");
    super::write(folder, "second.md", &markdown)?;
    super::write(folder, "second.csv", &csv)
}

struct Timed {
    ms: f64,
    bytes: u64,
}

/// Measures the time from the call to the picture, with all that the host does for it.
fn timed(device: &Device, contender: &mut Contender, cloud: &mut DeviceCloud, frame: &Frame) -> Result<Timed> {
    let (before, start) = (device.uploaded_bytes(), Instant::now());
    let rendered = contender.render(cloud, frame)?;
    let timed = Timed { ms: start.elapsed().as_secs_f64() * 1e3, bytes: device.uploaded_bytes() - before };
    contender.renderer.recycle(rendered.image);
    Ok(timed)
}
