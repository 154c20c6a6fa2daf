//! The scene on the devices of all ranks: the same everywhere, as the first rank decides it.

use std::ops::Range;

use pellucid_core::camera::Camera;
use pellucid_core::progress::Phase;
use pellucid_engine::Result;
use pellucid_engine::methods::{Frame, Upload};
use pellucid_engine::passes::bands::Window;
use pellucid_scene::MethodChoice;
use pellucid_scene::prepare::Arranged;
use pellucid_session::{Prepared, Session};

use super::cut::{Costs, Load};
use super::link::Link;
use super::ranks::{Ranks, together, told};
use super::share::{Job, Share};
use super::spread;
use super::spread::deal::Spread;
use super::work::RankWork;
use crate::commands::Error;
use crate::commands::bar::Bar;
use crate::commands::limit::usage;
use crate::commands::mpi_args::Wanted;
use crate::commands::options::DeviceArgs;

/// Least work of a rank, in seconds, for which some regions are handed out on demand: for each, points are picked,
/// sent to the device and projected anew, about 50 ms on a CPU.
const WORTH_DEMAND: f64 = 5.0;

/// Regions on demand for each rank, and the share of the work that they have together.
const ON_DEMAND: usize = 3;
const REST: f64 = 0.2;

/// Ranks whose longest time is at most so many times the mean keep their regions: others would have to bring other
/// points.
const BALANCED: f64 = 1.05;

/// A scene on this rank's device.
pub struct RankScene {
    pub session: Session,
    pub share: Share,
    /// Work that can be shared.
    pub job: Job,
    pub link: Link,
    /// The points of this rank, if they are distributed over all.
    pub spread: Option<Spread>,
    /// The last camera, with the costs of its tiles.
    costs: Option<(Camera, Costs)>,
    /// The last frame: its camera and its regions, and if its ranks took much the same time.
    last: Option<Last>,
}

/// A frame that was rendered.
struct Last {
    camera: Camera,
    windows: Vec<Window>,
    /// True if the next one of this camera is to have the same regions.
    is_balanced: bool,
}

impl RankScene {
    /// Brings what `prepare` reads to the device; it also returns how many frames there are to render.
    ///
    /// # Errors
    /// The first error of a rank, once the first rank has said what went wrong.
    pub fn open(
        (device, wanted): (&DeviceArgs, Wanted),
        ranks: &Ranks,
        progress: &Bar,
        prepare: impl FnOnce() -> Result<(Prepared, usize)>,
    ) -> Result<Self, Error> {
        ranks.begin("reading");
        if let Some(all) = ranks.led() {
            return together(ranks, prepare().and_then(|found| Self::spread((device, wanted), all, progress, found)));
        }
        let (prepared, frames) = together(ranks, prepare())?;
        together(ranks, compare(&identity(&prepared), ranks))?;
        let link = Link::measured(ranks).unwrap_or_default();
        // Points come region by region, so that each rank takes those of its own.
        let expected = Job::of(&prepared.frame(), &prepared, frames).choose(wanted, ranks.count(), link);
        let by_windows =
            ranks.count() > 1 && matches!(expected, Ok(Share::Windows)) && prepared.assembled.shadow_texture.is_none();
        ranks.begin("uploading");
        let mut session = together(ranks, open(device, prepared, by_windows, ranks, progress))?;
        // Method and opacity, too, are those of the first rank.
        session.frame = told(session.frame, ranks);
        // So are the samples, for what other ranks write of theirs.
        session.settled = told(session.settled, ranks);
        session.frame.depths = session.prepared.request.frame.depths;
        let job = together(ranks, job(&mut session, frames))?;
        let share = together(ranks, job.choose(wanted, ranks.count(), link))?;
        if ranks.is_first() {
            session.describe(progress);
            if ranks.count() > 1 {
                progress.console.detail(format_args!("{} ranks share {share}", ranks.count()));
            }
        }
        Ok(Self { session, share, job, link, spread: None, costs: None, last: None })
    }

    /// Makes the stage with the points distributed over all ranks, as this one orders.
    fn spread(
        asked: (&DeviceArgs, Wanted),
        all: &Ranks,
        progress: &Bar,
        (prepared, frames): (Prepared, usize),
    ) -> Result<Self> {
        let (session, spread) = spread::open(asked, prepared, all, progress)?;
        session.describe(progress);
        progress.console.detail(spread.described());
        let (share, job) = (Share::Windows, Job::of(&session.frame, &session.prepared, frames));
        Ok(Self { session, share, job, link: Link::default(), spread: Some(spread), costs: None, last: None })
    }

    /// Bytes that this rank has read of nodes.
    pub fn bytes_read(&self) -> u64 {
        self.session.assembled().stored().map_or(0, |stored| stored.bytes_read()[0])
    }

    /// The regions of the ranks for the session's camera, and those on demand; the first rank cuts.
    pub fn windows(&mut self, ranks: &Ranks) -> Vec<Window> {
        let cut = if ranks.is_first() { self.cut(ranks.count()) } else { Vec::new() };
        told(cut, ranks)
    }

    /// Cuts the image into regions for any number of ranks.
    pub fn cut(&mut self, ranks: usize) -> Vec<Window> {
        let (more, rest) = on_demand(&self.job, ranks);
        let camera = self.session.frame.camera;
        match &self.last {
            Some(last) if last.is_balanced && more == 0 && last.camera == camera && last.windows.len() == ranks => {
                last.windows.clone()
            }
            _ => self.costs().windows(ranks, more, rest),
        }
    }

    /// The samples of each of so many ranks, and those on demand, cut where they may be.
    pub fn samples(&self, ranks: usize) -> Vec<Range<u32>> {
        let Some([total, step]) = self.job.samples else { return Vec::new() };
        let (more, rest) = on_demand(&self.job, ranks);
        parted(total, step, ranks, if more > 0 { Some((more * ranks, rest)) } else { None })
    }

    /// Learns from what ranks took for a frame.
    pub fn learn(&mut self, work: &[RankWork], imbalance: f64) {
        let camera = self.session.frame.camera;
        let windows = work.iter().flat_map(|work| work.windows.clone()).collect();
        // Who gets other regions of the same view brings other points, which takes time once.
        let is_new = self.last.as_ref().is_none_or(|last| last.camera == camera && last.windows != windows);
        let is_balanced = is_new || imbalance < BALANCED;
        self.last = Some(Last { camera, windows, is_balanced });
        if is_balanced {
            return;
        }
        let taken: Vec<(&[Window], f64)> = work.iter().map(|work| (work.windows.as_slice(), work.work_ms)).collect();
        if let Some((_, costs)) = &mut self.costs {
            costs.learn(&taken);
        }
    }

    /// Returns the expected cost of the tiles of the session's frame.
    pub fn costs(&mut self) -> &Costs {
        let (frame, points) = (&self.session.frame, self.session.points());
        let old = self.costs.take_if(|(camera, _)| *camera != frame.camera);
        let make = || {
            let mut costs = Costs::expected(frame, points);
            old.iter().for_each(|(_, old)| costs.remember(old));
            (frame.camera, costs)
        };
        &self.costs.get_or_insert_with(make).1
    }
}

/// Cuts samples into a range for each rank, and ranges on demand, which have a share of all together. Each but the last
/// begins and ends at a multiple of `step`; none is empty unless there are more ranks than steps.
fn parted(total: u32, step: u32, ranks: usize, more: Option<(usize, f64)>) -> Vec<Range<u32>> {
    let steps = total.div_ceil(step.max(1));
    let kept = more.map_or(steps, |(_, rest)| ((1.0 - rest) * f64::from(steps)).ceil() as u32);
    let cut = |from: u32, to: u32, parts: usize| {
        let edge = move |part: usize| from + (u64::from(to - from) * part as u64 / parts as u64) as u32;
        (0..parts).map(move |part| edge(part)..edge(part + 1))
    };
    let others = cut(kept, steps, more.map_or(1, |(parts, _)| parts)).filter(|range| !range.is_empty());
    let of_steps = |range: Range<u32>| (range.start * step).min(total)..(range.end * step).min(total);
    cut(0, kept, ranks).chain(others).map(of_steps).collect()
}

/// How many windows each of so many ranks may get on demand, and which share of the work they have together.
fn on_demand(job: &Job, ranks: usize) -> (usize, f64) {
    if ranks > 1 && job.alone() / ranks as f64 >= WORTH_DEMAND { (ON_DEMAND, REST) } else { (0, 0.0) }
}

/// Returns a hash of the facts that must be the same on all ranks.
fn identity(prepared: &Prepared) -> [u8; 32] {
    let (points, Prepared { camera, request, .. }) = (prepared.points(), prepared);
    let stored = points.whole.as_ref().map(|whole| &whole.identity);
    let written = format!(
        "{} {} {camera:?} {} {} {:?} {stored:?}",
        env!("CARGO_PKG_VERSION"),
        prepared.scene().settings,
        request.wanted.seed,
        points.positions.len(),
        points.bounds()
    );
    let mut hash = blake3::Hasher::new();
    hash.update(written.as_bytes());
    hash.update(bytemuck::cast_slice(&points.positions));
    hash.update(bytemuck::cast_slice(&points.colors));
    *hash.finalize().as_bytes()
}

/// Refuses ranks that found something else than the first one.
fn compare(own: &[u8], ranks: &Ranks) -> Result<()> {
    let all = ranks.all_told(own);
    match all.iter().position(|one| *one != all[0]) {
        Some(other) => Err(usage(format!(
            "rank {other} found another scene, other points or another version of pellucid than rank 0: all ranks must see \
             the same files"
        ))),
        None => Ok(()),
    }
}

/// Brings the points to the device; the first rank decides the method and the opacity, too.
fn open(device: &DeviceArgs, prepared: Prepared, by_windows: bool, ranks: &Ranks, progress: &Bar) -> Result<Session> {
    // Method and opacity are those of a rank alone, which has all points at once.
    let follows = matches!(prepared.scene().method, MethodChoice::Auto(..)) || prepared.see_through().is_some();
    let is_first = ranks.is_first();
    progress.begin(Phase::Upload);
    let device = ranks.device(device)?;
    let mut session = Session::upload(&device, prepared, by_windows && !(is_first && follows), progress)?;
    if is_first {
        session.decide(progress)?;
        session.settle(progress)?;
        if by_windows
            && follows
            && let arranged @ Arranged::Canonical(_) = session.assembled().arranged()
        {
            let upload = Upload { by_windows: true, ..arranged.into() };
            session.uploaded.cloud = session.renderer.upload(upload)?;
        }
    }
    Ok(session)
}

/// Returns the work that can be shared, including facts that only a device knows.
fn job(session: &mut Session, frames: usize) -> Result<Job> {
    let Session { renderer, uploaded, frame, device, .. } = &mut *session;
    let slots = if frame.method.is_dealt() { renderer.survey(&mut uploaded.cloud, frame)?.slots } else { 0 };
    let is_gpu = device.info().prefers.shared_work;
    Ok(Job { slots, is_gpu, ..Job::of(&session.frame, &session.prepared, frames) })
}

impl Job {
    /// Returns the work that can be shared, as far as it is known without a device.
    fn of(frame: &Frame, prepared: &Prepared, frames: usize) -> Self {
        let load: Load = Costs::expected(frame, prepared.points()).whole();
        let samples = frame.sample_steps().map(|steps| [steps.total, steps.step]);
        Self { load, samples, slots: 0, images: frame.samples, frames, is_gpu: false }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_sample_is_drawn_once() {
        for (total, step, ranks, more) in [
            (100, 1, 2, None),
            (64, 16, 3, None),
            (70, 16, 8, None),
            (1000, 1, 7, Some((21, 0.2))),
            (5, 1, 4, Some((12, 0.2))),
        ] {
            let ranges = parted(total, step, ranks, more);
            assert!(ranges.len() >= ranks);
            let mut next = 0;
            for range in &ranges {
                assert!(range.start == next && (range.end % step == 0 || range.end == total), "{ranges:?}");
                next = range.end;
            }
            assert_eq!(next, total);
        }
        assert_eq!(parted(100, 1, 3, None), [0..33, 33..66, 66..100]);
        assert_eq!(parted(10, 1, 2, Some((2, 0.2))), [0..4, 4..8, 8..9, 9..10]);
    }
}
