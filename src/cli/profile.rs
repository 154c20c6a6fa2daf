//! `pellucid profile`.

use std::process::ExitCode;

use clap::Args;
use pellucid::methods::Stop;
use pellucid::{Result, profile};

use super::input::{InputArgs, prepare};
use super::session::Session;
use super::talk::{Talk, counted, print, print_json};
use super::{DeviceArgs, MeasureArgs};

#[derive(Debug, Args)]
pub struct ProfileArgs {
    #[command(flatten)]
    input: InputArgs,
    #[command(flatten)]
    device: DeviceArgs,
    #[command(flatten)]
    measure: MeasureArgs,
    /// Frames to measure.
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = clap::value_parser!(u32).range(1..=100_000))]
    frames: u32,
    /// For which output the frames are: an .exr gets every bit, for a .png blending stops where no 8-bit value would move by
    /// more than a quarter of a step. Only method sorted stops at all.
    #[arg(long = "for", value_name = "FORMAT", default_value = "exr")]
    format: Format,
    /// Print the measurements as JSON, as --profile writes them, instead of the table.
    #[arg(long)]
    json: bool,
}

/// An output format.
#[derive(Debug, Clone, Copy, clap::ValueEnum)]
enum Format {
    Exr,
    Png,
}

pub fn run(args: ProfileArgs, talk: Talk) -> Result<ExitCode> {
    args.measure.check()?;
    let progress = talk.progress();
    let resolved = prepare(&args.input, talk, &progress)?;
    let stop = match args.format {
        Format::Exr => Stop::Exact,
        Format::Png => Stop::EightBit { transparent: false },
    };
    let mut session = Session::open(&args.device, &resolved, true, stop, &progress)?;
    session.describe(talk);
    session.warn(&resolved, talk);
    // The first frame pays for pipelines and buffers.
    let first = session.render()?;
    let shadows = first.profile.passes.iter().filter(|pass| pass.name.starts_with("shadows/"));
    let casting_ms = shadows.map(|pass| pass.gpu.as_secs_f64() * 1e3).sum::<f64>();
    if first.facts.light_views > 0 {
        let views = first.facts.light_views;
        talk.note(format_args!(
            "shadows: {casting_ms:.2} ms on the device for {views} image(s) of a light, in the first frame only; it is not among \
             those below"
        ));
    }
    let mut profile = session.profile();
    let counted_facts = (first.facts.fragments, first.facts.max_list);
    let histogram = first.image.fragments.as_deref().map(profile::histogram).unwrap_or_default();
    if session.frame.method.is_tiled() {
        // The first frame counted the lists, which the method itself has no use for.
        session.frame.fragments = false;
    }
    session.renderer.recycle(first.image);
    counted(&progress, "measuring", args.frames.into());
    for _ in 0..args.frames {
        let rendered = session.render()?;
        profile.add(&rendered);
        session.renderer.recycle(rendered.image);
        progress.inc(1);
    }
    let copy_rate = profile::copy_rate(&session.device)?;
    progress.finish_and_clear();
    (profile.facts.fragments, profile.facts.max_list) = counted_facts;
    profile.list_histogram = histogram;
    args.measure.write(&profile)?;
    if args.json {
        print_json(&profile.to_json())?;
    } else {
        print(&format!("{}\n", profile.table(Some(copy_rate))))?;
    }
    Ok(ExitCode::SUCCESS)
}
