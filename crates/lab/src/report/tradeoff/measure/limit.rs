//! The time that a whole comparison may take, and which settings still fit it.

use std::time::Instant;

use pellucid_session::candidates::Setting;

/// Part of the time that is kept for figures, pictures and the page.
const REPORT_SHARE: f64 = 0.1;

/// Times that the first frames of a setting took.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Spent {
    /// Seconds of a frame whose buffers and shaders were ready.
    pub(super) frame: f64,
    /// Seconds of all: frames, uploads, errors, pictures.
    pub(super) whole: f64,
}

/// Times of a comparison so far, in seconds.
#[derive(Debug, Clone, Copy)]
pub(super) struct Account<'a> {
    /// The settings that were tried by this run.
    pub(super) tried: &'a [Spent],
    /// A longer frame is not timed again in turns.
    pub(super) alone: f64,
    /// Frames in turns of every other setting.
    pub(super) rounds: usize,
}

impl Account<'_> {
    /// Seconds that a setting takes, from its first frame to the last one in turns; `frame` is the predicted one.
    /// Without a prediction it is what settings took so far on the average, and `None` before the first one.
    pub(super) fn needed(&self, frame: Option<f64>) -> Option<f64> {
        let mean = |part: fn(&Spent) -> f64| self.tried.iter().map(part).sum::<f64>() / self.tried.len() as f64;
        if self.tried.is_empty() {
            return None;
        }
        // Two frames, as of every setting, and its other time.
        let beside = mean(|spent| (spent.whole - 2.0 * spent.frame).max(0.0));
        let frame = frame.unwrap_or_else(|| mean(|spent| spent.frame));
        Some(beside + 2.0 * frame + self.in_turns(frame))
    }

    /// Seconds of the frames in turns of a setting, and of the one before them that makes buffers.
    pub(super) fn in_turns(&self, frame: f64) -> f64 {
        if frame > self.alone { 0.0 } else { (1 + self.rounds) as f64 * frame }
    }
}

/// Seconds until `end`, less those that writing the report of a comparison of `all` seconds takes.
pub(super) fn left(end: Instant, now: Instant, all: f64) -> f64 {
    end.saturating_duration_since(now).as_secs_f64() - REPORT_SHARE * all
}

/// Returns the reason why a setting that needs so many seconds is left out, if it is.
pub(super) fn refusal(needed: f64, left: f64, all: f64) -> Option<String> {
    (needed > left).then(|| {
        let left = left.max(0.0);
        format!(
            "it would take about {needed:.1} s by what was measured so far, but only {left:.1} s are left of {all} s in all"
        )
    })
}

/// The order in which settings are tried where time may run out: the first of each method, then the second of each, and
/// so on. Steps of a ladder stay in order.
pub fn method_by_method(settings: &[Setting]) -> Vec<usize> {
    let rank = |at: &usize| {
        let is_same = |other: &&Setting| other.method.name() == settings[*at].method.name();
        settings[..*at].iter().filter(is_same).count()
    };
    let mut order: Vec<usize> = (0..settings.len()).collect();
    order.sort_by_key(rank);
    order
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use pellucid_core::points::Points;
    use pellucid_scene::Discs;

    use super::*;
    use pellucid_session::candidates::{Formation, Ladders, Occasion, settings};

    #[test]
    fn the_time_of_a_setting_is_told_from_those_before() {
        let tried = [Spent { frame: 1.0, whole: 5.0 }, Spent { frame: 0.5, whole: 2.0 }];
        let account = Account { tried: &tried, alone: 2.0, rounds: 3 };
        // 3 s and 1 s in addition to the frames. Then two frames, and three in turns with one before them.
        assert_eq!(account.needed(Some(0.25)), Some(2.0 + 0.5 + 1.0));
        assert_eq!(account.needed(Some(2.5)), Some(2.0 + 5.0), "not in turns");
        assert_eq!(account.needed(None), Some(2.0 + 6.0 * 0.75));
        assert_eq!(Account { tried: &[], ..account }.needed(Some(9.0)), None, "the first one is tried anyway");
    }

    #[test]
    fn a_setting_is_left_out_where_it_needs_more_than_is_left() {
        let now = Instant::now();
        let after = |seconds| left(now + Duration::from_secs(seconds), now, 50.0);
        assert_eq!((after(8), after(0)), (3.0, -5.0));
        assert_eq!(left(now, now + Duration::from_secs(3), 50.0), -5.0, "past the end");
        assert_eq!(refusal(3.0, 3.0, 50.0), None);
        let reason = refusal(3.04, 3.0, 50.0).unwrap();
        assert!(reason.contains("about 3.0 s") && reason.contains("3.0 s are left of 50 s"), "{reason}");
        assert!(refusal(1.0, -5.0, 50.0).unwrap().contains("0.0 s are left"));
    }

    #[test]
    fn each_method_is_tried_before_any_is_tried_twice() {
        let formation = Formation::Discs(Discs::default());
        let occasion = Occasion::new(&Points::default(), formation, 300);
        let (settings, _) = settings(&occasion, &Ladders::QUICK);
        let order = method_by_method(&settings);
        let mut names: Vec<&str> = settings.iter().map(|setting| setting.method.name()).collect();
        names.dedup();
        let first: Vec<&str> = order[..names.len()].iter().map(|at| settings[*at].method.name()).collect();
        assert!(names.len() >= 9 && first == names, "{first:?}");
        let mut sorted = order.clone();
        sorted.sort_unstable();
        assert!(sorted.into_iter().eq(0..settings.len()), "all of them, once");
        for series in settings.iter().map(|setting| &setting.series) {
            let steps: Vec<_> = order.iter().filter(|at| settings[**at].series == *series).collect();
            assert!(steps.is_sorted(), "{series}");
        }
    }
}
