//! `pellucid render`.

use std::path::PathBuf;
use std::process::ExitCode;

use clap::Args;
use pellucid::Result;
use pellucid::methods::Stop;
use pellucid::output::{self, WriteOptions};

use super::input::{InputArgs, prepare};
use super::session::Session;
use super::talk::Talk;
use super::{DeviceArgs, MeasureArgs};

#[derive(Debug, Args)]
pub struct RenderArgs {
    #[command(flatten)]
    input: InputArgs,
    #[command(flatten)]
    device: DeviceArgs,
    #[command(flatten)]
    measure: MeasureArgs,
    /// The picture: .png (8-bit sRGB) or .exr (32-bit float R, G, B, A, Z); by default the first input's name with
    /// .png, in the current folder. For a .png method sorted blends until no 8-bit value would move by more than a
    /// quarter of a step, for an .exr until no bit would change.
    #[arg(short, long, value_name = "OUT")]
    output: Option<PathBuf>,
    /// EXR: also write the length of each pixel's fragment list, as channel `fragments.Y`, with peel the layers that
    /// were blended, as `layers.Y`, and with stochastic the standard error of color, as `stderr.R`, `stderr.G`, `stderr.B`.
    #[arg(long)]
    aov: bool,
    /// PNG: straight alpha instead of the background. (An EXR always has both: R, G, B over the background, and A.)
    #[arg(long)]
    transparent: bool,
}

pub fn run(args: RenderArgs, talk: Talk) -> Result<ExitCode> {
    let output = args.output.clone().unwrap_or_else(|| args.input.default_output());
    output::check_target(&output)?;
    args.measure.check()?;
    let png = output.extension().is_some_and(|e| e.eq_ignore_ascii_case("png"));
    if args.aov && png {
        talk.warn("--aov has no effect on a PNG; write an .exr");
    }
    if args.transparent && !png {
        talk.warn("--transparent has no effect on an EXR, which holds the alpha channel anyway");
    }
    let progress = talk.progress();
    let resolved = prepare(&args.input, talk, &progress)?;
    let stop = if png { Stop::EightBit { transparent: args.transparent } } else { Stop::Exact };
    let counted = args.aov || args.measure.profile.is_some();
    let mut session = Session::open(&args.device, &resolved, counted, stop, &progress)?;
    session.renderer.progress = progress.clone();
    session.describe(talk);
    let mut rendered = session.render()?;
    progress.finish_and_clear();
    Session::describe_frame(&rendered, talk);
    let options = WriteOptions {
        background: resolved.scene.image.background,
        color: resolved.scene.image.color,
        transparent: args.transparent,
        metadata: resolved.metadata(session.frame.method.name(), &session.device.info().name),
    };
    // Lists may have been counted, but for the profile's histogram only.
    let counted = if args.aov { None } else { rendered.image.fragments.take() };
    rendered.image.layers = rendered.image.layers.filter(|_| args.aov);
    rendered.image.stderr = rendered.image.stderr.filter(|_| args.aov);
    output::write_image(&output, &rendered.image, &options)?;
    rendered.image.fragments = rendered.image.fragments.or(counted);
    let mut profile = session.profile();
    profile.add(&rendered);
    args.measure.write(&profile)?;
    talk.detail(format_args!("{}: written", output.display()));
    Ok(ExitCode::SUCCESS)
}
