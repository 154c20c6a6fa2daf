//! The profile as a Chrome trace.

use std::time::{Duration, Instant};

use serde_json::{Value, json};

use super::Profile;
use crate::methods::FrameProfile;
use crate::progress::Span;

/// Rows of the trace: their thread numbers.
const HOST: u32 = 0;
const DEVICE: u32 = 1;

impl Profile {
    /// Phases of the host, frames and dispatches in the Chrome trace event format, in microseconds since the first of
    /// them. The row of the host has the phases, the frames within them, and the pipelines that were made; the row of
    /// the device has the dispatches.
    pub fn to_trace(&self) -> Value {
        let begins = self.host.iter().map(|span| span.begin).chain(self.frames.iter().map(|frame| frame.begin));
        let mut events = Vec::new();
        if let Some(origin) = begins.min() {
            events.extend(self.host.iter().map(|span| phase(span, origin)));
            for (number, frame) in self.frames.iter().enumerate() {
                add_frame(&mut events, number, frame, frame.begin - origin);
            }
        }
        for (thread, name) in [(HOST, "host"), (DEVICE, "device")] {
            events.push(json!({"name": "thread_name", "ph": "M", "pid": 0, "tid": thread, "args": {"name": name}}));
        }
        json!({"traceEvents": events, "displayTimeUnit": "ms"})
    }
}

fn phase(span: &Span, origin: Instant) -> Value {
    event(span.phase.name(), [span.begin - origin, span.length], HOST, &json!({}))
}

/// Adds a frame that began at a time, and its dispatches.
fn add_frame(events: &mut Vec<Value>, number: usize, frame: &FrameProfile, begin: Duration) {
    events.push(event(&format!("frame {number}"), [begin, frame.wall], HOST, &json!({})));
    for (pass, start) in &frame.timeline {
        let counts = json!({"invocations": pass.invocations});
        events.push(event(pass.name, [begin + *start, pass.gpu], DEVICE, &counts));
    }
}

/// An event with its start and its length.
fn event(name: &str, [start, length]: [Duration; 2], thread: u32, args: &Value) -> Value {
    let micros = |time: Duration| time.as_secs_f64() * 1e6;
    json!({"name": name, "ph": "X", "ts": micros(start), "dur": micros(length), "pid": 0, "tid": thread, "args": args})
}
