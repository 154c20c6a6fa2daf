//! One picture, and the pictures of a time series.

use std::path::Path;

use pellucid_engine::Result;
use pellucid_engine::methods::Rendered;
use pellucid_engine::profile::Profile;
use pellucid_io::output::{self, WriteOptions};
use pellucid_session::{Clouds, Messages, Opened, Prepared, Session, SettledSamples, Silent};

use super::bar::Bar;
use super::deep;
use super::frames::Pattern;
use super::job::RenderJob;
use super::limit::usage;
use super::tradeoff::IN_FILES;
use crate::legend;

/// Renders a picture, and returns its profile; a deep one has none.
pub fn one(job: &RenderJob, output: &Path, progress: &Bar) -> Result<Option<Profile>> {
    let prepared = Prepared::new(job.request.clone(), progress, progress)?;
    if let Some(format) = job.args.deep.format() {
        deep::run(format, &job.args.device, prepared, output, progress)?;
        return Ok(None);
    }
    output::check_memory(output, prepared.frame().size)?;
    legend::check(&prepared, &[prepared.camera], job.args.legend, progress);
    let session = Session::open(&job.args.device.open(progress)?, prepared, progress, progress)?;
    let mut profile = session.profile();
    picture(job, session, output, None, &mut profile, progress)?;
    Ok(Some(profile))
}

/// A picture of the first cloud, of the first two and so on, by the camera that shows all of them. Returns the profile
/// of all.
pub fn steps(job: &RenderJob, pattern: &Pattern, progress: &Bar) -> Result<Profile> {
    let opened = Opened::new(job.request.clone(), progress, progress)?;
    if matches!(opened.sources.clouds(), Clouds::Stored(_)) {
        return Err(usage(IN_FILES));
    }
    let count = opened.sources.clouds().len();
    (1..=count).try_for_each(|step| output::check_target(&pattern.file(step)))?;
    let mut whole = opened.clone().prepare(progress, progress)?;
    output::check_memory(&pattern.file(count), whole.frame().size)?;
    legend::check(&whole, &[whole.camera], job.args.legend, progress);
    let (mut compilations, mut found) = (Vec::new(), None);
    if whole.see_through().is_some() {
        // As with the camera, clouds that are there already stay as they are when one joins.
        let mut session = Session::upload(&job.args.device.open(progress)?, whole, false, progress)?;
        session.find_opacity()?;
        (found, compilations) = (session.found, session.device.compilations());
        whole = session.prepared;
    }
    let camera = whole.camera;
    // Each picture has a progress of its own.
    let phases = progress.spans();
    progress.finish_and_clear();
    let (mut whole, mut profile, mut settled) = (Some(whole), None, None);
    for step in 1..=count {
        let progress = progress.console.progress();
        let prepared = match whole.take_if(|_| step == count) {
            Some(whole) => whole,
            None => {
                progress.stage(&format!("step {step} of {count}"));
                // Messages about the scene were printed already.
                opened.first(step).prepare_by(|_, _, _| Ok((camera, Vec::new())), &Silent, &progress)?
            }
        };
        let mut session = Session::upload(&job.args.device.open(&progress)?, prepared, false, &progress)?;
        (session.is_part, session.opacity_of_whole) = (step < count, found);
        session.decide(&progress)?;
        session.keep_samples(settled);
        let profile = profile.get_or_insert_with(|| session.profile());
        settled = picture(job, session, &pattern.file(step), Some((step, count)), profile, &progress)?;
    }
    let mut profile = profile.ok_or_else(|| usage(IN_FILES))?;
    profile.add_host(phases, &compilations);
    Ok(profile)
}

/// Renders and writes a picture, and adds it to a profile; `step` is its number and the number of all pictures, if it
/// is one of several. Returns the number of samples that was settled for it.
fn picture(
    job: &RenderJob,
    mut session: Session,
    output: &Path,
    step: Option<(usize, usize)>,
    profile: &mut Profile,
    progress: &Bar,
) -> Result<Option<SettledSamples>> {
    session.renderer.timed = job.args.measure.is_asked() || progress.console.is_verbose();
    session.describe(progress);
    let own = step.map(|(step, count)| ("pellucid:step".to_owned(), format!("{step} of {count}")));
    let (mut rendered, options) = session.picture(job.outputs(), own.into_iter().collect(), progress)?;
    progress.finish_and_clear();
    write(job, &session, &mut rendered, options, output, progress)?;
    profile.add(&rendered);
    session.add_phases(profile);
    // A picture of a series is one of many, and its error is that of the others.
    if step.is_none() && (session.choice.is_some() || progress.console.is_verbose()) {
        session.describe_sampling(progress)?;
    }
    Ok(session.settled)
}

/// Writes a rendered image. List lengths and layers are as they were afterwards, if they are written or were counted
/// for a profile.
pub fn write(
    job: &RenderJob,
    session: &Session,
    rendered: &mut Rendered,
    options: WriteOptions,
    output: &Path,
    messages: &dyn Messages,
) -> Result<()> {
    let options = WriteOptions { transparent: job.args.transparent, ..options };
    // If not requested, the counts served only the profile's histogram.
    let counted = if job.args.aov { None } else { rendered.image.fragments.take() };
    rendered.image.layers = rendered.image.layers.take().filter(|_| job.args.aov);
    rendered.image.stderr = rendered.image.stderr.take().filter(|_| job.args.aov);
    session.begin_writing();
    match session.assembled().legend.as_ref().zip(job.args.legend) {
        Some(legend) => legend::write(output, &rendered.image, &options, legend, &session.frame.camera)?,
        None => output::write_image(output, &rendered.image, &options)?,
    }
    rendered.image.fragments = rendered.image.fragments.take().or(counted);
    messages.detail(&format_args!("{}: written", output.display()));
    Ok(())
}
