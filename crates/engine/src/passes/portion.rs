//! A part of a scene's points: what one of several processes holds, each of which has others.

use std::sync::Arc;

use super::project::{Beam, Present};
use crate::cloud::Bounds;
use crate::points::{Points, Unreadable, Unseen, packed};
use crate::prepare::order;
use crate::supply::{Block, starts};
use pellucid_core::parallel;

/// Blocks that are looked at at once.
const AT_ONCE: usize = 64;

/// Points in canonical order, in runs of some that are near one another. No place is parted between runs.
#[derive(Debug, Clone, PartialEq)]
pub struct Runs {
    points: Points,
    /// The first point of each run.
    starts: Vec<u32>,
    /// Largest radius of each run over all points in its places, wherever these are; for Gaussians their largest reach.
    radii: Vec<f32>,
}

impl Runs {
    /// Returns the indices where runs of points in canonical order begin, and the number of all points.
    pub fn starts(points: &Points) -> Vec<usize> {
        if points.is_empty() { Vec::new() } else { starts(points) }
    }

    /// Returns some of them: those from one of the [`Self::starts`] to another. `radius` is that of the block that the
    /// points are, if there are others in their places.
    pub fn of(points: &Points, starts: &[usize], radius: Option<f32>) -> Self {
        let (first, end) = (starts[0], starts[starts.len() - 1]);
        let range: Vec<u32> = (first as u32..end as u32).collect();
        let largest = |run: &[usize]| points.radii[run[0]..run[1]].iter().copied().fold(0.0, f32::max);
        Self {
            points: Points { unseen: Arc::<Unseen>::default(), whole: None, ..points.subset(&range, 1.0) },
            starts: starts[..starts.len() - 1].iter().map(|start| (start - first) as u32).collect(),
            radii: starts.windows(2).map(|run| radius.unwrap_or_else(|| largest(run))).collect(),
        }
    }

    /// Appends them to some bytes.
    pub fn pack(&self, to: &mut Vec<u8>) {
        packed::put(to, &[self.starts.len() as u64]);
        packed::put(to, &self.starts);
        packed::put(to, &self.radii);
        self.points.pack(to);
    }

    /// Takes some off the front of some bytes.
    ///
    /// # Errors
    /// Returns an error if the bytes hold no runs.
    pub fn unpack(bytes: &mut &[u8]) -> Result<Self, Unreadable> {
        let count = packed::taken::<u64>(bytes, 1)?.into_iter().next().and_then(|count| usize::try_from(count).ok());
        let count = count.ok_or(Unreadable::SHORT)?;
        let (starts, radii): (Vec<u32>, _) = (packed::taken(bytes, count)?, packed::taken(bytes, count)?);
        let points = Points::unpack(bytes)?;
        let is_within = starts.last().is_some_and(|last| (*last as usize) < points.len());
        if !is_within || starts[0] != 0 || !starts.is_sorted_by(|a, b| a < b) {
            return Err(Unreadable::RUNS);
        }
        Ok(Self { points, starts, radii })
    }
}

/// The part of a scene's points that is here.
#[derive(Debug, Default)]
pub struct Portion {
    chunks: Vec<Points>,
    /// The runs of all chunks.
    blocks: Vec<Block>,
    /// Chunk of each block, its first point there, and one past the last.
    places: Vec<[u32; 3]>,
}

impl Portion {
    /// Adds points.
    pub fn add(&mut self, runs: Runs) {
        let Runs { points, starts, radii } = runs;
        let chunk = self.chunks.len() as u32;
        let ends = starts.iter().skip(1).copied().chain([points.len() as u32]);
        for ((start, end), radius) in starts.iter().copied().zip(ends).zip(radii) {
            let positions = points.positions[start as usize..end as usize].iter().copied();
            if let Some(bounds) = Bounds::enclosing(positions) {
                self.blocks.push(Block { bounds, radius, points: u64::from(end - start), branch: None });
                self.places.push([chunk, start, end]);
            }
        }
        self.chunks.push(points);
    }

    /// Returns the number of points.
    pub fn len(&self) -> u64 {
        self.chunks.iter().map(|points| points.len() as u64).sum()
    }

    /// Returns `true` if there are no points.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Shows the points of which anything may show there, some at a time.
    ///
    /// # Errors
    /// Returns the error of `see`, which ends the iteration.
    pub fn within<E>(&self, beam: &Beam, mut see: impl FnMut(Points) -> Result<(), E>) -> Result<(), E> {
        for some in beam.pick(&self.blocks).chunks(AT_ONCE) {
            let taken = parallel::gather(some.len(), |i| self.taken(beam, some[i] as usize));
            taken.into_iter().filter(|points| !points.is_empty()).try_for_each(&mut see)?;
        }
        Ok(())
    }

    /// Returns the points of a block of which anything may show.
    fn taken(&self, beam: &Beam, block: usize) -> Points {
        let ([chunk, start, end], radius) = (self.places[block], self.blocks[block].radius);
        let points = &self.chunks[chunk as usize];
        let present = Present { within: Some(*beam) };
        let keeps = |at: &u32| {
            let at = *at as usize;
            present.keeps(points.positions[at], points.reach(at).unwrap_or(radius))
        };
        let kept: Vec<u32> = (start..end).filter(keeps).collect();
        points.subset(&kept, 1.0)
    }
}

/// Returns all points of parts of a scene with these bounds, in canonical order. Points that are alike stay in the
/// order of the parts.
pub fn joined(parts: Vec<Points>, bounds: &Bounds) -> Points {
    let parts: Vec<Arc<Points>> = parts.into_iter().map(Arc::new).collect();
    Points::gather(&parts, &order::merged(&parts, bounds))
}

#[cfg(test)]
mod tests {
    use glam::{DVec3, Vec3};

    use super::*;
    use crate::camera::{Camera, Projection};
    use crate::passes::project::PointExtent;
    use crate::progress::Progress;
    use crate::supply::{HeldPoints, Keep, Supply};

    fn points(count: usize) -> Points {
        let place = |at: usize| DVec3::new((at * 7919 % count) as f64, (at * 104_729 % 997) as f64, (at % 13) as f64);
        let radii = (0..count).map(|at| (at % 5) as f32 * 0.1).collect();
        let positions = (0..count).map(place).collect();
        order::canonical(Points {
            positions,
            radii,
            colors: vec![Vec3::ONE; count],
            opacities: vec![0.5; count],
            ..Points::default()
        })
    }

    fn beam() -> Beam {
        let projection = Projection::Orthographic { height: 1000.0 };
        let eye = DVec3::new(5_000.0, 500.0, 100.0);
        let camera = Camera::look_at(eye, eye - DVec3::Z, DVec3::Y, projection, 1.0, 200.0).unwrap();
        Beam::new(&camera, [100, 100], [10, 20, 60, 80], PointExtent::discs(1.0))
    }

    #[test]
    fn portions_together_have_what_one_list_has() {
        let (all, beam) = (points(20_000), beam());
        let bounds = all.bounds().unwrap();
        let mut portions = [Portion::default(), Portion::default(), Portion::default()];
        let starts = Runs::starts(&all);
        for (at, starts) in [&starts[..3], &starts[2..4], &starts[3..]].into_iter().enumerate() {
            let mut bytes = Vec::new();
            Runs::of(&all, starts, None).pack(&mut bytes);
            portions[at].add(Runs::unpack(&mut bytes.as_slice()).unwrap());
        }
        assert_eq!(portions.iter().map(Portion::len).sum::<u64>(), 20_000);
        let mut parts = Vec::new();
        for portion in &portions {
            portion
                .within(&beam, |points| -> Result<(), ()> {
                    parts.push(points);
                    Ok(())
                })
                .unwrap();
        }
        let together = joined(parts, &bounds);
        let held = HeldPoints::new(Arc::new(all));
        let blocks = held.blocks();
        let keeps = |position, block: u32, _: Option<f32>| beam.meets_point(position, blocks[block as usize].radius);
        let wanted = held.take(&beam.pick(blocks), Keep::those(&keeps), &Progress::hidden()).unwrap();
        assert!(wanted.len() > 300 && wanted.len() < 10_000, "{}", wanted.len());
        assert_eq!(Points { file_order: Vec::new(), ..together }, Points { file_order: Vec::new(), ..wanted });
    }

    #[test]
    fn what_ends_too_early_is_no_run() {
        let points = points(10_000);
        let runs = Runs::of(&points, &Runs::starts(&points), Some(1.0));
        let mut bytes = Vec::new();
        runs.pack(&mut bytes);
        assert_eq!((Runs::unpack(&mut bytes.as_slice()), runs.starts.len()), (Ok(runs.clone()), 3));
        for end in [0, 3, 8, 31, 50, bytes.len() - 1] {
            assert!(Runs::unpack(&mut &bytes[..end]).is_err());
        }
        // Starts that are none.
        for (at, value) in [(8, 1), (12, 0), (16, 0), (18, 0xff)] {
            let mut other = bytes.clone();
            other[at] = value;
            if at == 16 {
                other[17] = 0;
            }
            assert!(at == 12 || Runs::unpack(&mut other.as_slice()).is_err(), "{at}");
        }
        assert!(Runs::starts(&Points::default()).is_empty());
    }
}
