//! Measurements of a scene, each as the JSON of the command line.

use std::path::Path;
use std::time::Instant;

use pellucid_engine::methods::{Frame, Outputs, Stop};
use pellucid_engine::profile;
use pellucid_engine::totals::Effort;
use pellucid_io::output;
use pellucid_lab::report::tradeoff::{self, Against, MeasuredScene, Options};
use pellucid_session::candidates::{self, Formation};
use pellucid_session::{Measuring, Messages, Session};
use pyo3::prelude::*;
use serde_json::json;

use crate::failure::Failure;
use crate::request::Ask;
use crate::session::SceneSession;
use crate::talk::Talk;

/// Renders a first frame, which pays for pipelines and buffers, then those that count, steady or not.
pub fn profile(session: &mut Session, (frames, steady): (u32, bool), talk: &Talk) -> Result<String, Failure> {
    let kept = session.frame;
    session.renderer.notes_tiles = true;
    let first = session.first(Outputs::default(), talk);
    session.renderer.notes_tiles = false;
    let first = first?;
    let mut profile = session.profile();
    profile.steady = Some(steady);
    profile.tile_histogram = Some(first.facts.tile_histogram.clone());
    let counted = (first.facts.fragments, first.facts.max_list);
    let histogram = first.image.fragments.as_deref().map(profile::histogram).unwrap_or_default();
    if session.frame.counts_on_demand() || steady {
        // The first frame counted the lists, which the method itself has no use for.
        session.frame.fragments = false;
    }
    session.renderer.recycle(first.image);
    talk.progress.reset();
    talk.progress.set_message("measuring");
    let (mut measuring, mut hindrance) = (Measuring::new(steady), None);
    let measured = (0..frames).try_for_each(|_| {
        talk.go_on()?;
        let rendered = measuring.frame(session)?;
        hindrance = hindrance.or(measuring.hindrance(session, &rendered));
        profile.add(&rendered);
        Ok::<_, Failure>(())
    });
    let measured = measured.and_then(|()| {
        let effort = Effort { frames: frames as usize, ..Effort::RELIABLE };
        profile.totals = if steady { Some(session.totals(effort)?) } else { None };
        Ok(())
    });
    session.frame = Frame { samples: session.frame.samples, ..kept };
    measured?;
    if let Some(reason) = hindrance {
        talk.note(&format_args!("steady: the frames wait for their counts, because {reason}"));
    }
    (profile.facts.fragments, profile.facts.max_list) = counted;
    profile.list_histogram = histogram;
    session.add_use(&mut profile);
    profile.add_host(talk.progress.spans(), &session.device.compilations());
    Ok(profile.to_json().to_string())
}

/// Returns the passes of a frame, each with its reason; the reason of the method comes first.
pub fn plan(session: &mut Session, talk: &Talk) -> Result<String, Failure> {
    session.settle(talk)?;
    Ok(json!(session.plan()?).to_string())
}

/// Extent of a comparison.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct TradeoffExtent {
    quick: bool,
    only: Vec<String>,
    seconds: Option<f64>,
    /// Word for the picture that errors are measured against.
    against: String,
    /// Name of the function that was called, for the report.
    command: String,
}

/// Compares the methods that draw a scene.
pub fn tradeoff(
    work: &mut SceneSession,
    ask: &Ask,
    extent: &TradeoffExtent,
    folder: &Path,
    talk: &Talk,
) -> Result<String, Failure> {
    let begin = Instant::now();
    if work.session.assembled().stored().is_some() {
        let problem = "tradeoff: all clouds are needed in memory; these stay in their files, since they would take more than host_memory \
                       allows, or since [detail] is to leave points out";
        return Err(Failure::Value(problem.to_owned()));
    }
    work.prepare(ask, talk)?;
    let session = &work.session;
    let scene = session.scene();
    let method = scene.method.representative();
    let formation = candidates::compared(&method, session.points())?;
    let mut shading = scene.shading;
    if shading.edl.edl && !matches!(formation, Formation::Surfaces(_)) {
        talk.warn(&"eye-dome lighting is left out, because not all compared methods support it");
        shading.edl.edl = false;
    }
    let shadows = scene.shadows.filter(|_| matches!(formation, Formation::Surfaces(_)));
    let frame = Frame {
        shading,
        method,
        detail: Default::default(),
        fragments: false,
        stop: Stop::Exact,
        shadows,
        ..session.frame
    };
    let background = scene.image.background.color();
    let subject = MeasuredScene {
        arranged: session.assembled().arranged(),
        frame,
        background,
        scene: &session.prepared.request.name,
        cameras: &[],
    };
    output::check_report_folder(folder)?;
    let TradeoffExtent { quick, only, seconds, against, command } = extent;
    let options = Options::new(*quick, begin, only.clone(), *seconds, command.clone());
    let options = Options { against: Against::from_word(against).unwrap_or_default(), ..options };
    let report = tradeoff::run(&session.device, &subject, &options, folder, &talk.progress)?;
    talk.progress.set_message("writing the report");
    tradeoff::write(folder, &report)?;
    tradeoff::discard(folder)?;
    serde_json::to_string(&report).map_err(|error| Failure::Refused(format!("no report: {error}")))
}
