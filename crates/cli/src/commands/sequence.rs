//! `render --path` and `render --turntable`: one picture per frame, rendered from one upload; frames that exist already
//! are skipped.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use pellucid_core::camera::StatedCamera;
use pellucid_engine::methods::{Frame, Rendered};
use pellucid_engine::profile::Profile;
use pellucid_engine::{Result, identity};
use pellucid_io::output;
use pellucid_session::Session;

use super::along::Along;
use super::bar::Bar;
use super::console::Console;
use super::films::{Caption, Films};
use super::frames::Pattern;
use super::job::RenderJob;
use super::measured::{FrameProfiles, Journal};
use super::options::write_json;
use super::picture::write;
use super::popped::Popped;
use super::render::RenderArgs;
use super::{Error, interrupt};
use crate::legend;

/// The metadata by which a frame is known to belong to a sequence.
const IDENTITY: &str = "pellucid:sequence";

/// The files of the frames, and which of them exist.
pub struct Frames<'a> {
    job: &'a RenderJob,
    files: Vec<PathBuf>,
    pub cameras: Vec<StatedCamera>,
    /// The identity of each picture: a hash of everything it depends on.
    identities: Vec<String>,
    /// True of those that are not to be rendered again.
    pub there: Vec<bool>,
}

/// Frames to render.
pub struct Due<'a> {
    /// Numbers of the frames.
    pub numbers: &'a mut dyn Iterator<Item = usize>,
    /// How many they are at most.
    pub count: usize,
    /// Renders the frame of the session's camera.
    pub render: &'a mut dyn FnMut(&mut Session) -> Result<Rendered>,
}

/// Measurements of the sequence.
#[derive(Default)]
pub struct Records {
    measured: FrameProfiles,
    journal: Option<Journal>,
    /// The frames rendered in this run, if a trace is wanted.
    trace: Option<Profile>,
    /// How the error changes, if it is followed.
    popped: Option<Popped>,
}

pub fn run(
    job: &RenderJob,
    along: &Along,
    (pattern, films): (&Pattern, &Films),
    progress: &Bar,
) -> Result<ExitCode, Error> {
    let console = progress.console;
    let (prepared, cameras) = along.prepare(job.request.clone(), progress)?;
    output::check_memory(&pattern.file(0), prepared.frame().size)?;
    legend::check(&prepared, &cameras, job.args.legend, progress);
    let mut session = Session::open(&job.args.device.open(progress)?, prepared, progress, progress)?;
    session.describe(progress);
    session.renderer.timed = job.args.measure.is_asked() || console.is_verbose();
    // All frames have the samples of the first one, so that nothing changes from frame to frame but the view.
    session.settle(progress)?.into_iter().for_each(|first| session.renderer.recycle(first.image));
    let mut frames = Frames::named(job, cameras, pattern, &session);
    frames.find(pattern)?;
    let _folder = films.make_folder()?;
    let mut records = Records::open(&frames, &session)?;
    interrupt::defer();
    let due = if records.popped.is_some() { (0..frames.files.len()).collect() } else { frames.missing() };
    let render = &mut |session: &mut Session| session.render_for(job.outputs());
    let due = Due { count: due.len(), numbers: &mut due.into_iter(), render };
    let rendered = frames.render(&mut session, &mut records, due, progress, console)?;
    progress.finish_and_clear();
    let (count, before) = (frames.files.len(), frames.there.iter().filter(|there| **there).count());
    if before > 0 {
        console.note(format_args!("{before} of {count} frames were there already, {rendered} were rendered"));
    }
    if before + rendered < count {
        let finished = before + rendered;
        console
            .note(format_args!("interrupted with {finished} of {count} frames; the same command renders the others"));
        return Ok(ExitCode::from(interrupt::STATUS));
    }
    records.finish(job, &session, count, console)?;
    if films.is_none() || films.make(&frames.files, &caption(along, &session), console)? {
        return Ok(ExitCode::SUCCESS);
    }
    console.note(format_args!("interrupted; the same command goes on with the {count} frames, which are all there"));
    Ok(ExitCode::from(interrupt::STATUS))
}

/// Returns the text that a film and a page hold about their frames.
fn caption(along: &Along, session: &Session) -> Caption {
    let name = Path::new(&session.prepared.request.name).file_name().map(|name| name.to_string_lossy().into_owned());
    let method = session.frame.method.name();
    Caption {
        title: name.unwrap_or_else(|| session.prepared.request.name.clone()),
        points: session.uploaded.cloud.total(),
        method,
        closed: along.is_closed(),
        background: session.scene().image.background.color(),
        metadata: session.prepared.metadata(method, &session.device.info().name),
    }
}

impl<'a> Frames<'a> {
    /// The frames of cameras, of which none is known to exist.
    pub fn named(job: &'a RenderJob, cameras: Vec<StatedCamera>, pattern: &Pattern, session: &Session) -> Self {
        let files = (0..cameras.len()).map(|number| pattern.file(number)).collect();
        let identities = identities(job, &cameras, session);
        let there = vec![false; cameras.len()];
        Self { job, files, cameras, identities, there }
    }

    /// Finds the frames that exist, and removes those to be replaced.
    ///
    /// # Errors
    /// Files with these names, or with numbers after the last one, that don't belong to the sequence, unless they may
    /// be replaced.
    pub fn find(&mut self, pattern: &Pattern) -> Result<()> {
        // Whoever makes a film of the frames would take those that follow for the rest of it.
        let after = (self.files.len()..).map(|number| pattern.file(number)).take_while(|file| is_taken(file));
        let mut foreign: Vec<PathBuf> = after.collect();
        for ((file, identity), there) in self.files.iter().zip(&self.identities).zip(&mut self.there) {
            let taken = is_taken(file);
            *there = taken && output::metadata(file, IDENTITY).as_ref() == Some(identity);
            foreign.extend(Some(file.clone()).filter(|_| taken && !*there));
        }
        if let Some(first) = foreign.iter().min()
            && !self.job.args.overwrite
        {
            return Err(output::Error::Foreign { path: first.clone(), count: foreign.len() }.into());
        }
        for file in foreign {
            fs::remove_file(&file).map_err(|source| output::Error::Write { path: file, source })?;
        }
        Ok(())
    }

    /// The numbers of those that are to be rendered.
    pub fn missing(&self) -> Vec<usize> {
        (0..self.files.len()).filter(|number| !self.there[*number]).collect()
    }

    /// Renders frames and returns how many were written. If errors are followed, those that are there are rendered for
    /// it alone.
    pub fn render(
        &self,
        session: &mut Session,
        records: &mut Records,
        due: Due<'_>,
        progress: &Bar,
        console: Console,
    ) -> Result<usize> {
        let count = self.files.len();
        // Counts only the frames to render, so that the estimated time is theirs.
        progress.counted("frames", due.count as u64);
        let (mut done, mut empty) = (0, Vec::new());
        for number in due.numbers {
            if interrupt::asked() {
                break;
            }
            session.look_through(self.cameras[number]);
            let mut rendered = (due.render)(session)?;
            if rendered.image.is_empty() {
                empty.push(number);
            }
            if let Some(popped) = &mut records.popped {
                popped.add(session, &rendered.image)?;
                if self.there[number] {
                    session.renderer.recycle(rendered.image);
                    progress.inc(1);
                    continue;
                }
            }
            // Recorded before the picture is written, so that every existing picture has its measurements.
            records.add(self, number, session, &rendered)?;
            let own = vec![
                ("pellucid:frame".to_owned(), format!("{number} of {count}")),
                (IDENTITY.to_owned(), self.identities[number].clone()),
            ];
            let console_for_frame = if done == 0 { console } else { console.without_repeats() };
            let options = session.finish(&mut rendered, own, &console_for_frame)?;
            write(self.job, session, &mut rendered, options, &self.files[number], &console_for_frame)?;
            session.renderer.recycle(rendered.image);
            done += 1;
            progress.inc(1);
        }
        if let Some(first) = empty.first() {
            let empty = empty.len();
            console
                .warn(format_args!("{empty} of {count} frames show nothing of the scene, the first is frame {first}"));
        }
        Ok(done)
    }
}

impl Records {
    /// Reads back the measurements of existing frames.
    fn open(frames: &Frames<'_>, session: &Session) -> Result<Self> {
        let RenderArgs { popping, measure, .. } = &frames.job.args;
        let popped = popping.clone().map(|path| Popped::open(path, session)).transpose()?;
        let trace = measure.trace.as_ref().map(|_| session.profile());
        let (journal, measured) = match &measure.profile {
            Some(path) => {
                let (journal, measured) = Journal::open(path, &frames.identities, &frames.there)?;
                (Some(journal), measured)
            }
            None => (None, FrameProfiles::default()),
        };
        Ok(Self { measured, journal, trace, popped })
    }

    fn add(&mut self, frames: &Frames<'_>, number: usize, session: &Session, rendered: &Rendered) -> Result<()> {
        if let Some(journal) = &mut self.journal {
            let (camera, identity) = (&frames.cameras[number], frames.identities[number].as_str());
            journal.add(self.measured.add(number, camera, Some(identity), session, rendered))?;
        }
        if let Some(trace) = &mut self.trace {
            trace.add(rendered);
        }
        Ok(())
    }

    /// Writes the requested files.
    fn finish(self, job: &RenderJob, session: &Session, count: usize, console: Console) -> Result<()> {
        self.popped.map_or(Ok(()), |popped| popped.finish(count, console))?;
        let mut host = session.profile();
        session.add_phases(&mut host);
        console.detail(host.host_text());
        if let Some(journal) = self.journal {
            let missing = self.measured.missing(count);
            if let Some(first) = missing.first() {
                let missing = missing.len();
                console.warn(format_args!(
                    "the profile lacks {missing} of {count} frames, the first is frame {first}: they were rendered without \
                     --profile; `pellucid profile` measures all of them along the same path"
                ));
            }
            journal.finish(&self.measured.to_json(&host))?;
        }
        let Some((mut trace, path)) = self.trace.zip(job.args.measure.trace.as_ref()) else { return Ok(()) };
        trace.host = host.host;
        write_json(path, &trace.to_trace())
    }
}

/// True if anything with this name exists, even a dangling link.
fn is_taken(file: &Path) -> bool {
    fs::symlink_metadata(file).is_ok()
}

/// A hash, for each frame, of everything its file depends on.
fn identities(job: &RenderJob, cameras: &[StatedCamera], session: &Session) -> Vec<String> {
    let prepared = &session.prepared;
    let depths = prepared.request.frame.depths;
    let frame = Frame { camera: prepared.camera.camera(), depths, ..session.frame };
    let info = session.device.info();
    let metadata = prepared.metadata(session.frame.method.name(), &info.name);
    let mut written = format!("{:?} {metadata:?} {} {}", session.frame.method, job.args.aov, job.args.transparent);
    if let Some(legend) = &prepared.assembled.legend {
        // Other values may have the same colors.
        written.push_str(&format!(" {:?} {legend:?}", job.args.legend));
    }
    let whole = identity::hash(
        prepared.assembled.arranged(),
        &frame,
        prepared.scene().image.background.color(),
        &written,
        info,
    );
    let count = cameras.len();
    let one = |(number, camera): (usize, &StatedCamera)| {
        // Debug output of floats is exact.
        blake3::hash(format!("{whole} {number} of {count} {camera:?}").as_bytes()).to_hex().to_string()
    };
    cameras.iter().enumerate().map(one).collect()
}
