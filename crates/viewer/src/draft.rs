//! Decides what is left out while things move, so that a frame stays within its time: first samples, ensembles and
//! layers, then pixels and, in the same proportion, points.
//!
//! A coarser picture has one pixel for `coarse` × `coarse` of the screen, and every `coarse`²-th point with `coarse`
//! times the radius. The content of a pixel stays the same, and all work shrinks alike, whether it comes from pixels or
//! points. So a single number predicts the next frame's time from the last one.

use pellucid_scene::{Method, PeelLayers, Setting};

use super::counts::abbreviated;

/// Samples, ensembles or layers of a frame of unknown cost, and the minimum for any frame: below it, larger pixels show
/// more.
const FEWEST: u32 = 4;

/// Columns and rows of the screen for one that is rendered.
const COARSE: [u32; 6] = [1, 2, 3, 4, 6, 8];

/// Share of all points from which a picture at rest has them all.
const NEARLY_ALL: f64 = 0.5;

/// Points of clouds that stay in their files: in a frame of unknown cost, and the minimum for any frame.
const FIRST_POINTS: u32 = 1 << 17;
/// See [`FIRST_POINTS`].
const FEWEST_POINTS: u32 = 1 << 15;

/// The effort that a picture is worth.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Effort {
    /// Effort for moving scenes: as much as fits these milliseconds.
    Moving(f64),
    /// Effort for scenes at rest: as much as fits these milliseconds, and more lights for shadows than before.
    Refining(f64),
    /// Effort for a picture that leaves nothing out.
    Whole,
}

impl Effort {
    /// The milliseconds, if they are limited.
    pub fn budget_ms(self) -> Option<f64> {
        match self {
            Self::Moving(ms) | Self::Refining(ms) => Some(ms),
            Self::Whole => None,
        }
    }
}

/// The part of the whole picture that is rendered.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Draft {
    /// Samples, ensembles or layers, of methods that have some.
    pub steps: Option<u32>,
    /// Columns and rows of the screen for one that is rendered.
    pub coarse: u32,
    /// Points in the picture at most, of clouds that stay in their files; `None` for all.
    pub points: Option<u32>,
}

/// The time of a frame, and the work it covers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cost {
    /// Milliseconds.
    pub ms: f64,
    /// Share of the whole picture's work: up to 1, unless that has become less.
    pub work: f64,
}

/// The times of a method's frames: the last one, and the last one with a very different share of the work, which
/// reveals the fixed cost.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Costs {
    last: Cost,
    other: Option<Cost>,
}

impl Costs {
    /// Starts the estimate with the first frame.
    pub fn new(first: Cost) -> Self {
        Self { last: first, other: None }
    }

    /// Adds another frame.
    pub fn with(self, cost: Cost) -> Self {
        let other = if apart(cost, self.last) { Some(self.last) } else { self.other };
        Self { last: cost, other }
    }

    /// Converts works to shares of a picture that has `now` samples, ensembles or layers when it is whole, and not
    /// `before`.
    pub fn rescaled(mut self, before: Option<u32>, now: Option<u32>) -> Self {
        if let (Some(before), Some(now)) = (before, now) {
            let factor = f64::from(before) / f64::from(now.max(1));
            self.last.work *= factor;
            self.other.iter_mut().for_each(|other| other.work *= factor);
        }
        self
    }

    /// The share of the work expected to fit `budget_ms`: by a straight line through both, or, if only one exists or
    /// they are inconsistent, in proportion to the last one.
    fn share(&self, budget_ms: f64) -> f64 {
        let Cost { ms, work } = self.last;
        let line = self.other.filter(|other| apart(*other, self.last)).map(|other| {
            let slope = (other.ms - ms) / (other.work - work);
            (slope, ms - slope * work)
        });
        match line {
            Some((slope, alike)) if slope > 0.0 && alike > 0.0 => (budget_ms - alike) / slope,
            _ => work * budget_ms / ms.max(f64::MIN_POSITIVE),
        }
    }
}

/// True if two works differ enough for a line through both.
fn apart(a: Cost, b: Cost) -> bool {
    a.work > 2.0 * b.work || b.work > 2.0 * a.work
}

/// The key of a method whose image only gets better with its number: samples, ensembles, layers; and that number.
fn refined(method: &Method) -> Option<(&'static str, u32)> {
    // The number of layers has no effect where one is shown alone.
    if matches!(method, Method::PeelLayers(PeelLayers { only: Some(_), .. })) {
        return None;
    }
    let key = method.keys().into_iter().find(|key| key.refines)?;
    if let Some(Setting::Integer(steps)) = key.value { Some((key.name, steps)) } else { None }
}

/// The number of samples, ensembles or layers of a method, if its image only improves with their number.
fn steps(method: &Method) -> Option<u32> {
    refined(method).map(|(_, steps)| steps)
}

impl Draft {
    /// The whole picture.
    pub fn whole(method: &Method) -> Self {
        Self { steps: steps(method), coarse: 1, points: None }
    }

    /// Returns a draft like [`Self::within`], for clouds of `all` points that stay in their files. While things move,
    /// one pixel is rendered for several of the screen if points are fewer than pixels: `size` has their columns and
    /// rows.
    pub fn of_stored(method: &Method, costs: Option<Costs>, effort: Effort, all: u64, size: [u32; 2]) -> Self {
        let Some(budget_ms) = effort.budget_ms() else { return Self::whole(method) };
        let whole = Self::whole(method);
        let fewest = whole.steps.map(|most| most.min(FEWEST));
        let (points, steps) = match costs.map(|costs| costs.share(budget_ms) * all as f64) {
            None if all <= FIRST_POINTS.into() => return whole,
            None => (FIRST_POINTS, fewest),
            // The casts saturate.
            Some(points) if points >= all as f64 * NEARLY_ALL => return whole,
            Some(points) if matches!(effort, Effort::Refining(_)) && points >= f64::from(FIRST_POINTS) => {
                (points as u32, whole.steps)
            }
            Some(points) => {
                let times = whole.steps.zip(fewest).map_or(1.0, |(most, fewest)| f64::from(most) / f64::from(fewest));
                ((points * times) as u32, fewest)
            }
        };
        let points = points.max(FEWEST_POINTS);
        let pixels = f64::from(size[0]) * f64::from(size[1]);
        let coarse = if matches!(effort, Effort::Moving(_)) { coarse(f64::from(points) / pixels) } else { 1 };
        Self { steps, coarse, points: Some(points) }
    }

    /// The most accurate draft expected to take at most `budget_ms`, judged by earlier frames of the method; the
    /// coarsest one if none fits. Methods without steps are rendered whole at first.
    pub fn within(method: &Method, costs: Option<Costs>, budget_ms: f64) -> Self {
        let Some(share) = costs.map(|costs| costs.share(budget_ms)) else {
            return Self { steps: steps(method).map(|most| most.min(FEWEST)), ..Self::whole(method) };
        };
        let Some(most) = steps(method) else { return Self { coarse: coarse(share), ..Self::whole(method) } };
        let fewest = most.min(FEWEST);
        // The cast saturates.
        let fitting = (share * f64::from(most)) as u32;
        if fitting >= fewest {
            return Self { steps: Some(fitting.min(most)), ..Self::whole(method) };
        }
        let coarse = coarse(share * f64::from(most) / f64::from(fewest));
        Self { steps: Some(fewest), coarse, points: None }
    }

    /// Share of the whole picture's work, with all of its points.
    pub fn work(&self, method: &Method) -> f64 {
        let of_steps = match (self.steps, steps(method)) {
            (Some(taken), Some(most)) => f64::from(taken) / f64::from(most.max(1)),
            _ => 1.0,
        };
        let of_pixels = if self.points.is_some() { 1 } else { self.coarse * self.coarse };
        of_steps / f64::from(of_pixels)
    }

    /// The method with this number of samples or layers. Ensembles stay those of the L into which the points are
    /// shuffled; fewer of them are drawn. Radii in pixels stay as wide on the screen.
    pub fn method(&self, whole: Method) -> Method {
        let with = |key: &str, value| whole.with(key, value).unwrap_or(whole);
        match (refined(&whole), self.steps, whole.pixel_radius()) {
            (Some((key, _)), Some(steps), _) if !whole.is_dealt() => with(key, Setting::Integer(steps)),
            (_, _, Some(radius)) if self.coarse > 1 => {
                with("pixel_radius", Setting::Number(f64::from(radius) / f64::from(self.coarse)))
            }
            _ => whole,
        }
    }

    /// Ensembles that are drawn, if not all.
    pub fn ensembles(&self, method: &Method) -> Option<u32> {
        method.ensembles().and(self.steps)
    }

    /// Columns and rows that are rendered of a picture of `size`.
    pub fn size(&self, size: [u32; 2]) -> [u32; 2] {
        size.map(|side| side.div_ceil(self.coarse))
    }

    /// Name of the draft among others of the method: `16 samples`, `4 × 4 pixels as one`.
    pub fn name(&self, method: &Method) -> String {
        let key = refined(method).map_or("", |(key, _)| key);
        let steps = self.steps.map(|steps| format!("{steps} {key}"));
        let coarse = (self.coarse > 1).then(|| format!("{0} × {0} pixels as one", self.coarse));
        let points = self.points.map(|points| format!("{} points", abbreviated(points.into())));
        let parts: Vec<_> = [points, steps, coarse].into_iter().flatten().collect();
        if parts.is_empty() { "whole".to_owned() } else { parts.join(", ") }
    }
}

/// The finest one whose work is at most this share.
fn coarse(share: f64) -> u32 {
    let fits = |coarse: &u32| 1.0 / f64::from(coarse * coarse) <= share;
    COARSE.into_iter().find(fits).unwrap_or(COARSE[COARSE.len() - 1])
}

#[cfg(test)]
mod tests {
    use super::*;
    use pellucid_scene::{ScreenSplats, Spbr, Stochastic};

    fn stochastic() -> Method {
        Method::Stochastic(Stochastic { samples: 64, ..Default::default() })
    }

    #[test]
    fn samples_go_first() {
        let taken = |ms, work, budget| Draft::within(&stochastic(), Some(Costs::new(Cost { ms, work })), budget);
        let draft = |steps, coarse| Draft { steps: Some(steps), coarse, points: None };
        assert_eq!(Draft::within(&stochastic(), None, 33.0), draft(4, 1));
        assert_eq!(taken(128.0, 1.0, 33.0), draft(16, 1));
        assert_eq!(taken(8.0, 0.25, 33.0), draft(64, 1));
        assert_eq!(taken(528.0, 1.0, 33.0), draft(4, 1));
        // 4 of 64 samples in 132 ms: a quarter of the pixels in 33.
        assert_eq!(taken(132.0, 1.0 / 16.0, 33.0), draft(4, 2));
        assert_eq!(taken(133.0, 1.0 / 16.0, 33.0), draft(4, 3));
        assert_eq!(taken(1e12, 1.0, 33.0), draft(4, 8));
        assert_eq!(taken(128.0, 1.0, 0.0), draft(4, 8));
    }

    /// A slider that asks for 16 times the samples makes no frame that takes 16 times the budget.
    #[test]
    fn more_samples_are_more_work() {
        let (few, many) = (Method::Stochastic(Stochastic { samples: 4, ..Default::default() }), stochastic());
        let costs = Costs::new(Cost { ms: 33.0, work: Draft::whole(&few).work(&few) });
        let rescaled = costs.rescaled(Draft::whole(&few).steps, Draft::whole(&many).steps);
        assert_eq!(Draft::within(&many, Some(rescaled), 33.0), Draft { steps: Some(4), coarse: 1, points: None });
        assert_eq!(rescaled.rescaled(Some(64), Some(4)), costs);
        assert_eq!(costs.rescaled(None, None), costs);
    }

    #[test]
    fn points_of_stores_are_as_many_as_fit_the_time() {
        let (all, size) = (1_000_000_000, [1280, 720]);
        let of = |method: &Method, costs, effort| Draft::of_stored(method, costs, effort, all, size);
        let circles = Method::Circles(Default::default());
        let first = of(&circles, None, Effort::Moving(33.0));
        assert_eq!(first, Draft { steps: None, coarse: 3, points: Some(1 << 17) });
        // A million points in 100 ms.
        let costs = Some(Costs::new(Cost { ms: 100.0, work: 1e-3 }));
        let next = of(&circles, costs, Effort::Moving(33.0));
        assert_eq!((next.points, next.coarse), (Some(330_000), 2));
        assert_eq!(of(&circles, costs, Effort::Moving(0.0)).points, Some(1 << 15));
        assert_eq!(
            of(&circles, costs, Effort::Refining(1000.0)),
            Draft { steps: None, coarse: 1, points: Some(10_000_000) }
        );
        assert_eq!(of(&circles, costs, Effort::Refining(60_000.0)), Draft::whole(&circles));
        assert_eq!(of(&circles, costs, Effort::Whole), Draft::whole(&circles));
        assert_eq!(Draft::of_stored(&circles, None, Effort::Moving(33.0), 1000, size), Draft::whole(&circles));
        // Few samples while something moves, all of them at rest, if points are left.
        let moving = of(&stochastic(), costs, Effort::Moving(33.0));
        assert_eq!((moving.steps, moving.points), (Some(4), Some(330_000 * 16)));
        let resting = of(&stochastic(), costs, Effort::Refining(1000.0));
        assert_eq!((resting.steps, resting.points), (Some(64), Some(10_000_000)));
        assert_eq!(first.name(&circles), "131k points, 3 × 3 pixels as one");
    }

    #[test]
    fn a_layer_shown_alone_is_in_every_draft() {
        let of = |only| Method::PeelLayers(PeelLayers { layers: 9, only, ..PeelLayers::default() });
        let draft = |only| Draft::within(&of(only), None, 33.0).method(of(only));
        assert!(matches!(draft(None), Method::PeelLayers(PeelLayers { layers: 4, .. })));
        assert_eq!(draft(Some(7)), of(Some(7)));
    }

    #[test]
    fn radii_in_pixels_are_as_wide_in_coarse_drafts() {
        let of = |radius| Method::Circles(ScreenSplats { pixel_radius: radius, ..ScreenSplats::default() });
        let coarse = |coarse| Draft { steps: None, coarse, points: None };
        assert_eq!(coarse(4).method(of(Some(6.0))), of(Some(1.5)));
        assert_eq!(coarse(1).method(of(Some(6.0))), of(Some(6.0)));
        assert_eq!(coarse(4).method(of(None)), of(None));
    }

    #[test]
    fn exact_methods_get_coarser() {
        let method = Method::ABuffer(Default::default());
        let coarse = |cost: Option<Cost>| Draft::within(&method, cost.map(Costs::new), 33.0).coarse;
        assert_eq!(coarse(None), 1);
        for (ms, expected) in [(33.0, 1), (33.1, 2), (132.0, 2), (140.0, 3), (500.0, 4), (1e9, 8)] {
            assert_eq!(coarse(Some(Cost { ms, work: 1.0 })), expected, "{ms} ms");
        }
        assert_eq!(coarse(Some(Cost { ms: 8.0, work: 1.0 / 9.0 })), 2, "and finer again");
    }

    /// The prediction keeps to the budget: work and milliseconds are in proportion.
    #[test]
    fn a_draft_keeps_to_the_time_that_it_was_chosen_for() {
        for method in [stochastic(), Method::ABuffer(Default::default()), Method::Spbr(Spbr::default())] {
            for budget in [1.0, 5.0, 33.0, 100.0, 1000.0] {
                let whole_ms = 200.0;
                let draft = Draft::within(&method, Some(Costs::new(Cost { ms: whole_ms * 0.25, work: 0.25 })), budget);
                let takes = whole_ms * draft.work(&method);
                let coarsest = draft.coarse == 8;
                assert!(takes <= budget || coarsest, "{draft:?} takes {takes} of {budget}");
            }
        }
    }

    #[test]
    fn the_constant_cost_of_frames_is_separated() {
        // 20 ms for any frame, 1000 for the whole picture's work.
        let cost = |coarse: f64| Cost { ms: 20.0 + 1000.0 / (coarse * coarse), work: 1.0 / (coarse * coarse) };
        let mut costs = Costs::new(cost(1.0));
        assert!((costs.share(33.0) - 33.0 / 1020.0).abs() < 1e-12);
        for coarse in [6.0, 8.0, 3.0, 8.0, 8.0] {
            costs = costs.with(cost(coarse));
            assert!((costs.share(33.0) - 0.013).abs() < 1e-9, "{coarse}: {}", costs.share(33.0));
        }
        // By proportion alone the last one would keep it at 1/64.
        assert!(33.0 / 1020.0 > 0.013 && 33.0 / 64.0 / cost(8.0).ms < 0.0155);
        // Less than what all take: nothing fits, the coarsest it is.
        let method = Method::ABuffer(Default::default());
        assert_eq!(Draft::within(&method, Some(costs), 10.0).coarse, 8);
        // A scene that suddenly takes less makes no line.
        costs = costs.with(Cost { ms: 1.0, work: 1.0 });
        assert_eq!(costs.share(33.0), 33.0);
    }

    #[test]
    fn whole_pictures_have_everything() {
        for method in [stochastic(), Method::Points, Method::Spbr(Spbr::default())] {
            let whole = Draft::whole(&method);
            assert_eq!((whole.work(&method), whole.method(method)), (1.0, method));
            assert_eq!(Draft::within(&method, Some(Costs::new(Cost { ms: 1.0, work: 1.0 })), 1.0), whole);
        }
        let half = Draft { steps: Some(8), coarse: 2, points: None };
        assert_eq!(half.ensembles(&Method::Spbr(Spbr::default())), Some(8));
        assert_eq!(half.method(Method::Spbr(Spbr::default())), Method::Spbr(Spbr::default()), "the same deal");
        assert_eq!(half.size([641, 480]), [321, 240]);
        assert_eq!(half.name(&stochastic()), "8 samples, 2 × 2 pixels as one");
        assert_eq!(Draft::whole(&Method::Points).name(&Method::Points), "whole");
    }
}
