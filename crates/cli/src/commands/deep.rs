//! `pellucid render --deep`: samples in place of pixels.

use std::io;
use std::path::Path;

use bytesize::ByteSize;
use clap::Args;
use pellucid_engine::methods::{self, Frame, Renderer, deep};
use pellucid_engine::passes::project::DeviceCloud;
use pellucid_engine::{Result, plan};
use pellucid_gpu::Device;
use pellucid_io::output::deep::{DeepLayout, Numbers, Packing, State, Writer, Written};
use pellucid_io::output::{self, room};
use pellucid_scene::{MethodChoice, Samples};
use pellucid_session::{Prepared, Session, Uploaded};

use super::bar::Bar;
use super::headings::OUTPUT;
use super::limit::usage;
use super::options::{DeviceArgs, one_of};

/// Order of samples, and whether the header tells it.
#[derive(Debug, Clone, Copy)]
struct Order {
    state: State,
    is_told: bool,
}

const STATES: [(&str, Order); 4] = [
    ("tidy", Order { state: State::Tidy, is_told: false }),
    ("sorted", Order { state: State::Sorted, is_told: false }),
    ("tidy,state", Order { state: State::Tidy, is_told: true }),
    ("sorted,state", Order { state: State::Sorted, is_told: true }),
];

/// Samples of each pixel.
#[derive(Debug, Args)]
pub struct DeepArgs {
    /// EXR: write every fragment of each pixel as a deep image for compositing.
    ///
    /// Each sample has linear R, G, B times A, A and Z, without the background. Methods: abuffer, linked-list, sorted,
    /// peel, and soft-concentric. Ellipsoids and the shells of soft-concentric are volumes and also have ZBack. `tidy`
    /// (the default) merges fragments at one depth and splits volumes where others begin or end; `sorted` keeps each
    /// fragment as it is. With `,state` the header tells which of both it is (`deepImageState`); OpenEXR's Python
    /// module can't open such files.
    #[arg(long, value_name = "STATE", num_args = 0..=1, require_equals = true, default_missing_value = "tidy", help_heading = OUTPUT)]
    #[arg(value_parser = one_of(&STATES))]
    deep: Option<Order>,
    /// With --deep: type of color and A.
    ///
    /// `float` (the default) keeps all 24 bits of precision, `half` 11 bits in half the space. Z and ZBack are always
    /// float.
    #[arg(long, value_name = "NUMBERS", requires = "deep", help_heading = OUTPUT)]
    #[arg(value_parser = one_of(&[("float", Numbers::Float), ("half", Numbers::Half)]))]
    deep_type: Option<Numbers>,
    /// With --deep: compression; `zips` compresses each row without loss.
    #[arg(long, value_name = "HOW", requires = "deep", help_heading = OUTPUT)]
    #[arg(value_parser = one_of(&[("zips", Packing::Zips), ("none", Packing::Raw)]))]
    deep_compression: Option<Packing>,
}

/// Form of a deep image.
#[derive(Debug, Clone, Copy)]
pub struct DeepFormat {
    order: Order,
    numbers: Numbers,
    packing: Packing,
}

impl DeepArgs {
    /// Returns the form of the deep image, if one is asked for.
    pub fn format(&self) -> Option<DeepFormat> {
        let (numbers, packing) =
            (self.deep_type.unwrap_or(Numbers::Float), self.deep_compression.unwrap_or(Packing::Zips));
        Some(DeepFormat { order: self.deep?, numbers, packing })
    }
}

/// Writes the samples of a scene.
pub fn run(format: DeepFormat, device: &DeviceArgs, prepared: Prepared, output: &Path, progress: &Bar) -> Result<()> {
    let state = format.order.state;
    if prepared.scene().image.samples != Samples::Count(1) {
        return Err(usage(
            "--deep holds the fragments at the center of each pixel, and can't be combined with image.samples above 1 \
             or \"auto\"; use --samples 1",
        ));
    }
    deep::check(&prepared.frame(), prepared.points().splats().is_some(), state)?;
    let mut session = Session::upload(&device.open(progress)?, prepared, false, progress)?;
    session.find_opacity()?;
    session.why = match session.scene().method {
        MethodChoice::Auto(_) => "--deep needs lists of fragments".to_owned(),
        method => plan::resolve(method, session.points()).1,
    };
    session.describe(progress);
    let layout = layout(format, &session);
    progress.stage("counting");
    let Session { renderer, uploaded: Uploaded { cloud, .. }, frame, device, .. } = &mut session;
    let most = renderer.most_samples(cloud, frame, state)?;
    device.check_validation()?;
    let bytes = layout.most_bytes(most).map_err(|source| unwritten(output, source))?;
    progress.console.note(format_args!(
        "{}: at most {most} samples, {} (of {} bytes each) before compression",
        output.display(),
        ByteSize(bytes),
        layout.sample_bytes()
    ));
    room::check(output, bytes)?;
    progress.stage("rendering");
    let written = write(output, &layout, (renderer, cloud, frame, device))?;
    progress.finish_and_clear();
    session.describe_detail(progress);
    progress.console.detail(format_args!(
        "{}: written, {} samples, at most {} in a pixel, {}",
        output.display(),
        written.samples,
        written.longest,
        ByteSize(written.bytes)
    ));
    Ok(())
}

fn layout(DeepFormat { order, numbers, packing }: DeepFormat, session: &Session) -> DeepLayout {
    let mut metadata = session.prepared.metadata(session.frame.method.name(), &session.device.info().name);
    let found = session.found.map(|found| found.json(&session.scene().clouds, session.frame.factors.radius));
    metadata.extend(found.map(|json| ("pellucid:see-through".to_owned(), json.to_string())));
    metadata.push(session.prepared.camera_metadata());
    DeepLayout {
        size: session.frame.size,
        state: order.state,
        tells_state: order.is_told,
        numbers,
        packing,
        volumes: deep::has_volumes(&session.frame.method, session.uploaded.cloud.has_gaussians()),
        metadata,
        camera: Some(session.prepared.camera.camera()),
    }
}

/// Renders into the file, which appears whole or not at all.
fn write(
    output: &Path,
    layout: &DeepLayout,
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
