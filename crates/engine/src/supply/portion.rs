//! A part of a scene's points: what one of several processes holds, each of which has others.

use std::sync::Arc;

use rayon::prelude::*;

use super::{Block, starts};
use crate::cloud::Bounds;
use crate::passes::project::{Beam, Present};
use crate::points::{Points, Unreadable, Unseen};
use crate::prepare::order;

/// Blocks that are looked at at once.
const AT_ONCE: usize = 64;

/// Some points that are near one another, with the largest radius of all points in their places, wherever these are.
#[derive(Debug, Clone, PartialEq)]
pub struct Run {
    /// The points.
    pub points: Points,
    /// The largest radius; of Gaussians how far one of them reaches at most.
    pub radius: f32,
}

impl Run {
    /// Points in canonical order, in runs that part no place. `radius` is that of the block that they are, if there are others in
    /// their places.
    pub fn all(points: &Points, radius: Option<f32>) -> impl Iterator<Item = Self> + '_ {
        let starts = starts(points);
        (1..starts.len()).map(move |end| {
            let range: Vec<u32> = (starts[end - 1] as u32..starts[end] as u32).collect();
            let points = Points { unseen: Arc::<Unseen>::default(), whole: None, ..points.subset(&range, 1.0) };
            let largest = || points.radii.iter().copied().fold(0.0, f32::max);
            Self { radius: radius.unwrap_or_else(largest), points }
        })
    }

    /// Appends the run to some bytes.
    pub fn pack(&self, to: &mut Vec<u8>) {
        to.extend_from_slice(&self.radius.to_ne_bytes());
        self.points.pack(to);
    }

    /// Takes a run off the front of some bytes.
    ///
    /// # Errors
    /// They are none.
    pub fn unpack(bytes: &mut &[u8]) -> Result<Self, Unreadable> {
        let (radius, mut rest) = bytes.split_first_chunk().ok_or(Unreadable::SHORT)?;
        let points = Points::unpack(&mut rest)?;
        *bytes = rest;
        Ok(Self { radius: f32::from_ne_bytes(*radius), points })
    }
}

/// The part of a scene's points that is here.
#[derive(Debug, Default)]
pub struct Portion {
    blocks: Vec<Block>,
    runs: Vec<Points>,
}

impl Portion {
    /// Adds a run, unless it is empty.
    pub fn add(&mut self, run: Run) {
        let Run { points, radius } = run;
        if let Some(bounds) = Bounds::of(&points.positions) {
            self.blocks.push(Block { bounds, radius, points: points.len() as u64, branch: None });
            self.runs.push(points);
        }
    }

    /// Number of points.
    pub fn len(&self) -> u64 {
        self.blocks.iter().map(|block| block.points).sum()
    }

    /// True without points.
    pub fn is_empty(&self) -> bool {
        self.blocks.is_empty()
    }

    /// Shows the points of which anything may show there, some at a time.
    ///
    /// # Errors
    /// Those of `see`, which ends it.
    pub fn within<E>(&self, beam: &Beam, mut see: impl FnMut(Points) -> Result<(), E>) -> Result<(), E> {
        for some in beam.pick(&self.blocks).chunks(AT_ONCE) {
            let taken: Vec<Points> = some.par_iter().map(|block| self.taken(beam, *block as usize)).collect();
            taken.into_iter().filter(|points| !points.is_empty()).try_for_each(&mut see)?;
        }
        Ok(())
    }

    /// Those of a block.
    fn taken(&self, beam: &Beam, block: usize) -> Points {
        let (points, radius) = (&self.runs[block], self.blocks[block].radius);
        let present = Present { within: Some(*beam) };
        let keeps = |at: &u32| {
            let at = *at as usize;
            present.keeps(points.positions[at], points.reach(at).unwrap_or(radius))
        };
        let kept: Vec<u32> = (0..points.len() as u32).filter(keeps).collect();
        points.subset(&kept, 1.0)
    }
}

/// All points of parts of a scene with these bounds, in canonical order. Points that are alike stay in the order of the parts.
pub fn joined(parts: Vec<Points>, bounds: &Bounds) -> Points {
    let parts: Vec<Arc<Points>> = parts.into_iter().map(Arc::new).collect();
    Points::gather(&parts, &order::merged(&parts, bounds))
}

#[cfg(test)]
mod tests {
    use glam::{DVec3, Vec3};

    use super::*;
    use crate::camera::{Camera, Projection};
    use crate::passes::project::Extent;
    use crate::progress::Progress;
    use crate::supply::{Held, Keep, Supply};

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
        Beam::new(&camera, [100, 100], [10, 20, 60, 80], Extent::discs(1.0))
    }

    #[test]
    fn portions_together_have_what_one_list_has() {
        let (all, beam) = (points(20_000), beam());
        let bounds = all.bounds().unwrap();
        let mut portions = [Portion::default(), Portion::default(), Portion::default()];
        for (at, run) in Run::all(&all, None).enumerate() {
            let mut bytes = Vec::new();
            run.pack(&mut bytes);
            portions[at * 3 / 5].add(Run::unpack(&mut bytes.as_slice()).unwrap());
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
        let held = Held::new(Arc::new(all));
        let blocks = held.blocks();
        let keeps = |position, block: u32, _: Option<f32>| beam.meets_point(position, blocks[block as usize].radius);
        let wanted = held.take(&beam.pick(blocks), Keep::those(&keeps), &Progress::hidden()).unwrap();
        assert!(wanted.len() > 300 && wanted.len() < 10_000, "{}", wanted.len());
        assert_eq!(Points { file_order: Vec::new(), ..together }, Points { file_order: Vec::new(), ..wanted });
    }

    #[test]
    fn what_ends_too_early_is_no_run() {
        let run = Run { points: points(10), radius: 1.0 };
        let mut bytes = Vec::new();
        run.pack(&mut bytes);
        assert_eq!(Run::unpack(&mut bytes.as_slice()), Ok(run));
        for end in [0, 3, 4, 50, bytes.len() - 1] {
            assert!(Run::unpack(&mut &bytes[..end]).is_err());
        }
    }
}
