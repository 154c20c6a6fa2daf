//! The profile of frames that ranks shared: that of `pellucid`, and what each rank did.

use pellucid_core::image::Image;
use pellucid_engine::Result;
use pellucid_engine::profile::{self, Profile};
use pellucid_session::Session;
use serde_json::{Value, json};

use super::share::Share;
use super::turn::{FrameTiming, Shared};
use super::work::{RankWork, imbalance, ms};
use crate::commands::options::MeasureArgs;
use crate::commands::tables;

/// Measurements of frames.
pub struct Report {
    /// Profile of the first rank, in the form of `pellucid`.
    pub profile: Profile,
    share: Share,
    frames: Vec<FrameTiming>,
    /// Distribution of points over the ranks, if they are distributed.
    pub spread: Option<Value>,
}

impl FrameTiming {
    fn to_json(&self) -> Value {
        json!({
            "wall_ms": ms(self.wall),
            "gather_ms": ms(self.gather),
            "imbalance": imbalance(&self.work),
            "ranks": self.work.iter().map(rank).collect::<Vec<_>>(),
        })
    }
}

/// Returns the work of a rank, without its timeline.
fn rank(work: &RankWork) -> Value {
    let mut value = json!(work);
    if let Some(object) = value.as_object_mut() {
        object.remove("timeline");
    }
    value
}

impl Report {
    /// Returns a report without frames.
    pub fn new(session: &Session, share: Share) -> Self {
        Self { profile: session.profile(), share, frames: Vec::new(), spread: None }
    }

    /// Adds a frame, and returns its image.
    pub fn add(&mut self, Shared { rendered, measured }: Shared) -> Image {
        self.profile.add(&rendered);
        self.frames.push(measured);
        rendered.image
    }

    /// Formats the times of frames in a line.
    pub fn times(&self) -> String {
        let walls: Vec<f64> = self.frames.iter().map(|frame| ms(frame.wall)).collect();
        let made: usize = self.frames.iter().flat_map(|frame| &frame.work).map(|work| work.frames.len()).sum();
        let median = profile::median(walls.clone());
        if made > 0 {
            format!("{made} frames in {median:.1} ms")
        } else {
            format!("median of {} frames: {median:.1} ms", walls.len())
        }
    }

    /// All measurements.
    pub fn to_json(&self) -> Value {
        let mut whole = self.profile.to_json();
        whole["ranks"] = json!({
            "count": self.frames.first().map_or(1, |frame| frame.work.len()),
            "share": self.share.to_string(),
            "frames": self.frames.iter().map(FrameTiming::to_json).collect::<Vec<_>>(),
        });
        if let Some(spread) = &self.spread {
            whole["ranks"]["spread"] = spread.clone();
        }
        whole
    }

    /// A Chrome trace with a row for each rank: its passes, then what it waited for.
    pub fn to_trace(&self) -> Value {
        let (mut events, mut begin) = (Vec::new(), 0.0);
        for frame in &self.frames {
            let event = |name: &str, start: f64, length: f64, rank: usize| json!({"name": name, "ph": "X", "ts": 1e3 * (begin + start), "dur": 1e3 * length, "pid": 0, "tid": rank, "args": {}});
            for work in &frame.work {
                events
                    .extend(work.timeline.iter().map(|(name, start, length)| event(name, *start, *length, work.rank)));
                let rest = (ms(frame.wall) - work.work_ms).max(0.0);
                let after = if work.rank == 0 { "gather and wait" } else { "send and wait" };
                events.push(event(after, work.work_ms, rest, work.rank));
            }
            begin += ms(frame.wall);
        }
        profile::sort_events(&mut events);
        for work in self.frames.first().map(|frame| frame.work.as_slice()).unwrap_or_default() {
            let name = format!("rank {} ({})", work.rank, work.host);
            events.push(json!({"name": "thread_name", "ph": "M", "pid": 0, "tid": work.rank, "args": {"name": name}}));
        }
        json!({"traceEvents": events, "displayTimeUnit": "ms"})
    }

    /// Writes the files that were asked for.
    pub fn write(&self, args: &MeasureArgs) -> Result<()> {
        args.write(&self.to_json(), || self.to_trace())
    }

    /// Returns a table of the work of each rank in the last frame.
    pub fn table(&self) -> String {
        let Some(frame) = self.frames.last() else { return String::new() };
        let header =
            ["rank", "host", "parts", "work ms", "passes ms", "wait ms", "sent MiB", "received MiB", "read MiB"];
        let mib = |bytes: u64| format!("{:.1}", bytes as f64 / f64::from(1 << 20));
        let rows = frame.work.iter().map(|work| {
            [
                work.rank.to_string(),
                work.host.clone(),
                (work.windows.len() + work.samples.len() + work.frames.len()).max(1).to_string(),
                format!("{:.1}", work.work_ms),
                format!("{:.1}", work.gpu_ms()),
                format!("{:.1}", work.waited_ms),
                mib(work.sent),
                mib(work.received),
                mib(work.read),
            ]
        });
        let table = tables::table(header, rows, 2..9);
        format!(
            "{table}\n{} {} {}: {:.1} ms, of which {:.1} ms ({:.1} %) to bring the parts together; imbalance {:.2}",
            frame.work.len(),
            if frame.work.len() == 1 { "rank, which would share" } else { "ranks share" },
            self.share,
            ms(frame.wall),
            ms(frame.gather),
            100.0 * ms(frame.gather) / ms(frame.wall).max(f64::MIN_POSITIVE),
            imbalance(&frame.work),
        )
    }
}
