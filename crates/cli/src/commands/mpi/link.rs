//! Cost of a message: latency and bandwidth.

use std::time::Instant;

use serde::{Deserialize, Serialize};

use super::ranks::{Ranks, told};

/// Messages there and back that are timed, short and long ones, and bytes of a long one.
const SHORT: usize = 50;
const LONG: usize = 5;
const BYTES: usize = 8 << 20;

/// The cost of a message.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Link {
    /// Seconds of a message without content.
    pub latency: f64,
    /// Bytes per second.
    pub bandwidth: f64,
}

impl Default for Link {
    /// Much like a cluster's Ethernet.
    fn default() -> Self {
        Self { latency: 30e-6, bandwidth: 2e9 }
    }
}

impl Link {
    /// Seconds of so many messages with so many bytes together.
    pub fn seconds(self, messages: f64, bytes: f64) -> f64 {
        messages * self.latency + bytes / self.bandwidth
    }

    /// Measures messages between the first two ranks and sends the result to all; `None` for a single rank.
    pub fn measured(ranks: &Ranks) -> Option<Self> {
        if ranks.count() < 2 {
            return None;
        }
        ranks.meet();
        let short = there_and_back(ranks, SHORT, 8);
        let long = there_and_back(ranks, LONG, BYTES);
        let link = Self { latency: short, bandwidth: BYTES as f64 / (long - short).max(1e-9) };
        Some(told(link, ranks))
    }
}

/// Median seconds of a message of so many bytes between the first two ranks.
fn there_and_back(ranks: &Ranks, times: usize, bytes: usize) -> f64 {
    let mut message = vec![0; bytes];
    let mut seconds: Vec<f64> = (0..=times)
        .map(|_| {
            let begin = Instant::now();
            match ranks.own() {
                0 => {
                    ranks.send_exactly(1, &message);
                    ranks.receive_exactly(1, &mut message);
                }
                1 => {
                    ranks.receive_exactly(0, &mut message);
                    ranks.send_exactly(0, &message);
                }
                _ => {}
            }
            0.5 * begin.elapsed().as_secs_f64()
        })
        .skip(1)
        .collect();
    seconds.sort_by(f64::total_cmp);
    seconds[seconds.len() / 2]
}
