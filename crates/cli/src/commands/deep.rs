//! `pellucid render --deep`: samples in place of pixels.

use std::io;
use std::path::Path;

use bytesize::ByteSize;
use clap::Args;
use pellucid_engine::gpu::Device;
use pellucid_engine::methods::{self, Frame, Renderer, deep};
use pellucid_engine::output::deep::{Layout, Numbers, Packing, State, Writer, Written};
use pellucid_engine::output::{self, room};
use pellucid_engine::passes::project::DeviceCloud;
use pellucid_engine::scene::MethodChoice;
use pellucid_engine::{Result, plan};
use pellucid_session::{Prepared, Session, Uploaded};

use super::bar::Bar;
use super::console::Console;
use super::headings::OUTPUT;
use super::limit::usage;
use super::render::{RenderArgs, is_png};
use super::session;

/// Samples of each pixel.
#[derive(Debug, Args)]
pub struct DeepArgs {
    /// EXR: write every fragment of each pixel as a deep image for compositing.
    ///
    /// Each sample has linear R, G, B times A, A and Z, without the background. Methods: abuffer, linked-list, sorted,
    /// peel, and soft-concentric. Ellipsoids and the shells of soft-concentric are volumes and also have ZBack. `tidy`
    /// (the default) merges fragments at one depth and splits volumes where others begin or end; `sorted` keeps each
    /// fragment as it is.
    #[arg(long, value_name = "STATE", num_args = 0..=1, require_equals = true, default_missing_value = "tidy", help_heading = OUTPUT)]
    deep: Option<DeepState>,
    /// With --deep: type of color and A.
    ///
    /// `float` (the default) keeps all 24 bits of precision, `half` 11 bits in half the space. Z and ZBack are always
    /// float.
    #[arg(long, value_name = "NUMBERS", requires = "deep", help_heading = OUTPUT)]
    deep_type: Option<DeepType>,
    /// With --deep: compression; `zips` compresses each row without loss.
    #[arg(long, value_name = "HOW", requires = "deep", help_heading = OUTPUT)]
    deep_compression: Option<DeepCompression>,
}

/// Order of the samples in a pixel.
#[derive(Debug, Clone, Copy, clap::ValueEnum)]
enum DeepState {
    Tidy,
    Sorted,
}

/// The numbers of color and opacity.
#[derive(Debug, Clone, Copy, Default, clap::ValueEnum)]
enum DeepType {
    #[default]
    Float,
    Half,
}

/// Compression of rows.
#[derive(Debug, Clone, Copy, Default, clap::ValueEnum)]
enum DeepCompression {
    #[default]
    Zips,
    None,
}

impl DeepArgs {
    /// Returns the requested order of samples, if a deep image is asked for.
    fn state(&self) -> Option<State> {
        self.deep.map(|state| match state {
            DeepState::Tidy => State::Tidy,
            DeepState::Sorted => State::Sorted,
        })
    }

    /// True if samples are asked for.
    pub fn is_asked(&self) -> bool {
        self.deep.is_some()
    }
}

/// Refuses options that don't go with samples, before anything is read; `several`: more than one picture is asked for.
pub fn check(args: &RenderArgs, output: &Path, several: bool, console: Console) -> Result<()> {
    if is_png(output) {
        return Err(usage(format!(
            "--deep: {} is a PNG, but only an .exr holds samples; name one with -o",
            output.display()
        )));
    }
    if several {
        return Err(usage("--deep writes one picture; --frames, --path and --turntable make several"));
    }
    if args.chooses() {
        return Err(usage(
            "--deep can't be combined with --max-error, --budget and --recalibrate; give --method and its settings instead",
        ));
    }
    if args.measure.is_asked() {
        return Err(usage("--deep can't be combined with --profile and --trace; measure without --deep"));
    }
    if args.aov {
        console.warn("--aov has no effect with --deep: the samples already give depths and counts");
    }
    Ok(())
}

/// Writes the samples of a scene.
pub fn run(args: &RenderArgs, prepared: Prepared, output: &Path, progress: &Bar, console: Console) -> Result<()> {
    let Some(state) = args.deep.state() else { return Ok(()) };
    deep::check(&prepared.frame(), prepared.points().splats().is_some(), state)?;
    let mut session = session::upload(&args.device, prepared, false, progress)?;
    session.find_opacity()?;
    session.why = match session.scene().method {
        MethodChoice::Auto(_) => "--deep needs lists of fragments".to_owned(),
        method => plan::resolve(method, session.points()).1,
    };
    session.describe(&console);
    session.warn(&console);
    let layout = layout(args, state, &session);
    progress.stage("counting");
    let Session { renderer, uploaded: Uploaded { cloud, .. }, frame, device, .. } = &mut session;
    let most = renderer.most_samples(cloud, frame, state)?;
    device.check_validation()?;
    let bytes = layout.most_bytes(most).map_err(|source| unwritten(output, source))?;
    console.note(format_args!(
        "{}: at most {most} samples, {} (of {} bytes each) before compression",
        output.display(),
        ByteSize(bytes),
        layout.sample_bytes()
    ));
    room::check(output, bytes)?;
    progress.stage("rendering");
    let written = write(output, &layout, (renderer, cloud, frame, device))?;
    progress.finish_and_clear();
    session.describe_detail(&console);
    console.detail(format_args!(
        "{}: written, {} samples, at most {} in a pixel, {}",
        output.display(),
        written.samples,
        written.longest,
        ByteSize(written.bytes)
    ));
    Ok(())
}

fn layout(args: &RenderArgs, state: State, session: &Session) -> Layout {
    let mut metadata = session.prepared.metadata(session.frame.method.name(), &session.device.info().name);
    let found = session.found.map(|found| found.json(&session.scene().clouds));
    metadata.extend(found.map(|json| ("pellucid:see-through".to_owned(), json.to_string())));
    Layout {
        size: session.frame.size,
        state,
        numbers: match args.deep.deep_type.unwrap_or_default() {
            DeepType::Float => Numbers::Float,
            DeepType::Half => Numbers::Half,
        },
        packing: match args.deep.deep_compression.unwrap_or_default() {
            DeepCompression::Zips => Packing::Zips,
            DeepCompression::None => Packing::Raw,
        },
        volumes: deep::has_volumes(&session.frame.method, session.uploaded.cloud.has_gaussians()),
        metadata,
    }
}

/// Renders into the file, which appears whole or not at all.
fn write(
    output: &Path,
    layout: &Layout,
    (renderer, cloud, frame, device): (&mut Renderer, &mut DeviceCloud, &Frame, &Device),
) -> Result<Written> {
    let mut written = None;
    // Errors that aren't about the file keep their own words.
    let mut failed: Option<pellucid_engine::Error> = None;
    let done = output::write_atomically(output, |file| {
        let mut writer = Writer::begin(file, layout)?;
        let rendered = renderer.deep(cloud, frame, layout.state, &mut |lengths, samples| writer.push(lengths, samples));
        let checked = rendered.map_err(Into::into).and_then(|_| Ok(device.check_validation()?));
        match checked {
            Ok(()) => written = Some(writer.finish()?),
            Err(pellucid_engine::Error::Render(methods::Error::Samples(error))) => return Err(error),
            Err(error) => {
                failed = Some(error);
                return Err(io::ErrorKind::Interrupted.into());
            }
        }
        Ok(())
    });
    match (failed, done, written) {
        (Some(error), ..) => Err(error),
        (None, Err(error), _) => Err(error.into()),
        (None, Ok(()), Some(written)) => Ok(written),
        (None, Ok(()), None) => Err(unwritten(output, io::ErrorKind::UnexpectedEof.into()).into()),
    }
}

fn unwritten(path: &Path, source: io::Error) -> output::Error {
    output::Error::Write { path: path.to_owned(), source }
}
