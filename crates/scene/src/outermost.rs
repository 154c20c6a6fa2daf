//! The outermost of many spheres, found without looking at most of them again and again.
//!
//! Points in canonical order that follow each other lie together in space. So each run of them has a small box, and
//! only runs whose boxes reach as far as some sphere is known to reach can hold the outermost ones.

use std::ops::Range;

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::framed::{Framed, Spheres};
use pellucid_core::parallel;

/// Spheres of a run.
const RUN: usize = 1 << 12;

/// Offset, depth and radius of a sphere.
type Sphere = (DVec2, f64, f64);

/// Spheres that follow each other, and where they lie.
struct Run {
    /// Numbers of the spheres.
    spheres: Range<usize>,
    /// The box of their offsets and depths.
    low: DVec3,
    high: DVec3,
    /// The largest radius.
    radius: f64,
    /// The first one that counts.
    first: Sphere,
}

impl Run {
    /// Returns the corners of the box with the largest radius.
    fn corners(&self) -> impl Iterator<Item = Sphere> + use<> {
        let ([low, high], radius) = ([self.low, self.high], self.radius);
        (0..8).map(move |corner| {
            let at = |axis: usize| if corner >> axis & 1 == 1 { high[axis] } else { low[axis] };
            (DVec2::new(at(0), at(1)), at(2), radius)
        })
    }
}

/// The runs of spheres in memory.
pub(super) struct Runs<'a> {
    spheres: &'a Spheres<'a>,
    runs: Vec<Run>,
}

impl<'a> Runs<'a> {
    /// Looks at all spheres once.
    pub fn of(spheres: &'a Spheres<'a>) -> Self {
        let count = spheres.framed.len();
        let run = |i: usize| run(spheres, i * RUN..count.min((i + 1) * RUN));
        Self { spheres, runs: parallel::gather(count.div_ceil(RUN), run).into_iter().flatten().collect() }
    }

    /// Returns what adding all spheres `with` one another to `nothing` gives, as if they were added in their order.
    /// `both` joins the states of two parts. `reaches` tells if a state has anything as far out as another one.
    ///
    /// No sphere of a run may be farther out than all corners of the run's box with its largest radius.
    pub fn outermost<S: Copy + Send + Sync>(
        &self,
        nothing: S,
        with: impl Fn(S, Sphere) -> S + Sync + Send,
        both: impl Fn(S, S) -> S + Sync + Send,
        reaches: impl Fn(&S, &S) -> bool + Sync,
    ) -> S {
        let known = self.runs.iter().map(|run| run.first).fold(nothing, &with);
        let may_count = |run: &&Run| reaches(&run.corners().fold(nothing, &with), &known);
        let framed = &self.spheres.framed;
        let of_run = |run: &Run| {
            let spheres = run.spheres.clone().filter_map(|i| framed.sphere(i));
            spheres.map(|(position, radius)| self.spheres.relative(position, radius)).fold(nothing, &with)
        };
        self.runs.par_iter().filter(may_count).map(of_run).reduce(|| nothing, both)
    }
}

/// The run of the spheres with these numbers; `None` if none of them counts.
fn run(spheres: &Spheres<'_>, numbers: Range<usize>) -> Option<Run> {
    let framed: &Framed<'_> = &spheres.framed;
    let mut each = numbers.clone().filter_map(|i| framed.sphere(i)).map(|(position, r)| spheres.relative(position, r));
    let first = each.next()?;
    let place = |(offset, depth, _): Sphere| offset.extend(depth);
    let start = Run { spheres: numbers, low: place(first), high: place(first), radius: first.2, first };
    Some(each.fold(start, |run, sphere| Run {
        low: run.low.min(place(sphere)),
        high: run.high.max(place(sphere)),
        radius: run.radius.max(sphere.2),
        ..run
    }))
}

#[cfg(test)]
mod tests {
    use pellucid_core::points::{Points, Unseen};
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg64Mcg;

    use super::*;

    /// Points in a ball with radii, along a line in memory, and some that are not drawn.
    fn points(count: usize, seed: u64) -> Points {
        let mut random = Pcg64Mcg::seed_from_u64(seed);
        let mut number = || 2.0 * random.random::<f64>() - 1.0;
        let ball = std::iter::repeat_with(|| DVec3::new(number(), number(), number())).filter(|p| p.length() < 1.0);
        let mut positions: Vec<DVec3> = ball.take(count + 5).collect();
        positions[..count].sort_by(|a, b| a.x.total_cmp(&b.x));
        let unseen = positions.split_off(count).into_iter().map(|p| 1.2 * p).collect();
        let radii = (0..count).map(|i| (i % 7) as f32 * 0.01).collect();
        let unseen = Unseen { positions: unseen, radii: vec![0.1; 5] }.into();
        Points { radii, unseen, ..pellucid_testing_host::white(positions, 1.0) }
    }

    /// The farthest right, and the first of the spheres that have the greatest slope, with its depth.
    type Reach = (f64, (f64, f64));

    #[test]
    fn the_outermost_are_those_of_all_and_of_equals_the_first() {
        for (count, seed) in [(0, 1), (1, 2), (RUN, 3), (5 * RUN + 77, 4)] {
            let mut points = points(count, seed);
            if count > RUN {
                // Equally far out, once more at another depth in another run.
                let far = DVec3::new(0.0, 3.0, 1.0);
                (points.positions[3], points.positions[2 * RUN + 9]) = (far, far * DVec3::new(1.0, 2.0, 4.0));
                (points.radii[3], points.radii[2 * RUN + 9]) = (0.0, 0.0);
            }
            let spheres = Spheres { framed: Framed::all(&points), center: DVec3::ZERO, axes: DVec3::AXES };
            let with = |(right, slope): Reach, (offset, depth, radius): Sphere| {
                let here = ((offset.y + radius) / (depth + 2.0), depth);
                (right.max(offset.x + radius), if here.0 > slope.0 { here } else { slope })
            };
            let both = |a: Reach, b: Reach| (a.0.max(b.0), if b.1.0 > a.1.0 { b.1 } else { a.1 });
            let nothing = (f64::NEG_INFINITY, (f64::NEG_INFINITY, 0.0));
            let one_by_one = points.spheres().collect::<Vec<_>>().into_iter();
            let wanted = one_by_one.map(|(position, radius)| spheres.relative(position, radius)).fold(nothing, with);
            let reaches = |state: &Reach, known: &Reach| state.0 >= known.0 || state.1.0 >= known.1.0;
            assert_eq!(Runs::of(&spheres).outermost(nothing, with, both, reaches), wanted, "{count}");
            if count > RUN {
                assert_eq!(wanted.1, (1.0, 1.0), "3 / (1 + 2), and then 6 / (4 + 2)");
            }
        }
    }

    #[test]
    fn few_runs_are_looked_at() {
        let points = points(50 * RUN, 7);
        let spheres = Spheres { framed: Framed::all(&points), center: DVec3::ZERO, axes: DVec3::AXES };
        let seen = std::sync::atomic::AtomicUsize::new(0);
        let runs = Runs::of(&spheres);
        let with = |right: f64, (offset, _, radius): Sphere| {
            seen.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
            right.max(offset.x + radius)
        };
        runs.outermost(f64::NEG_INFINITY, with, f64::max, |state, known| state >= known);
        // Nine for the box of each of 51 runs; sorted along x, those beyond are in the last ones.
        assert!(seen.into_inner() < 9 * 51 + 5 * RUN);
    }
}
