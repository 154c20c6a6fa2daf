//! Points that are dealt to ensembles in a temporary file, for clouds that memory has no room for: the list that
//! [`ensembles::deal`](super::ensembles::deal) makes, to the bit.
//!
//! The words that shuffle points are numbers at random. So points are put into buckets by them, as many as let memory hold each, and
//! each bucket is sorted by itself. Points in one place are counted, since their ids differ: all of them go to the bucket of
//! the first one's word, where they meet, and from there to their own.

mod buckets;
mod pile;
mod records;
mod sorted;

use std::ops::Range;
use std::path::{Path, PathBuf};

use glam::DVec3;
use rayon::prelude::*;

use self::buckets::points_of;
use self::pile::{Extent, Pile};
use self::records::Layout;
use super::density::{self, Shuffled};
use super::ensembles::Surface;
use crate::cloud::Bounds;
use crate::io::Error;
use crate::points::{Anchor, Points};
use crate::progress::Progress;

/// Points that are read at a time where all are.
const AT_ONCE: usize = 4 * density::BLOCK;

/// A cloud that is read block by block.
pub struct Source<'a> {
    /// Where it is stored, for errors.
    pub path: &'a Path,
    /// Points of each block.
    pub blocks: Vec<u64>,
    /// The points of a block, with those that are not drawn set apart.
    pub read: &'a (dyn Fn(usize) -> Result<Points, Error> + Sync),
    /// The box of all points, also of those that are not drawn, in world coordinates.
    pub bounds: Bounds,
    /// What ids are made from: that of the cloud by itself.
    pub anchor: Anchor,
}

/// How clouds are dealt.
#[derive(Debug, Clone)]
pub struct Settings {
    /// True if points have normals.
    pub has_normals: bool,
    /// The seed of the shuffle.
    pub seed: u64,
    /// Bytes of memory that may be taken at a time.
    pub memory: u64,
    /// The folder of the temporary file.
    pub folder: PathBuf,
}

/// What is known of a cloud of the list.
#[derive(Debug, Clone, PartialEq)]
pub struct Facts {
    /// Properties of the cloud.
    pub surface: Surface,
    /// The box of its points that are drawn.
    pub bounds: Bounds,
    /// True if all of them have the same opacity.
    pub uniform: bool,
    /// The largest component of their colors.
    pub brightest: f32,
}

/// Points in random order, cloud after cloud, in a file without a name that goes with the process.
#[derive(Debug)]
pub struct DealtFile {
    pile: Pile,
    layout: Layout,
    clouds: Vec<Facts>,
    surfaces: Vec<Surface>,
    /// The pieces of the list, each with its first point.
    pieces: Vec<(u64, Extent)>,
    len: u64,
}

impl DealtFile {
    /// Deals clouds as [`ensembles::deal`](super::ensembles::deal) does. `progress` counts points, each of them three times.
    ///
    /// # Errors
    /// A block can't be read, the file can't be written, too many points are in one place, or `progress` cancels it.
    pub fn deal(clouds: &[Source<'_>], settings: &Settings, progress: &Progress) -> Result<Self, Error> {
        progress.set_length(3 * clouds.iter().flat_map(|cloud| &cloud.blocks).sum::<u64>());
        let pile = Pile::new(&settings.folder)?;
        let layout = Layout { has_normals: settings.has_normals };
        let mut file = Self { pile, layout, clouds: vec![], surfaces: vec![], pieces: vec![], len: 0 };
        for cloud in clouds {
            let place = file.clouds.len() as u32;
            let Some((facts, buckets)) = sorted::sorted(cloud, place, &file.pile, settings, progress)? else {
                continue;
            };
            let first = file.len;
            for extent in buckets.into_iter().flatten() {
                file.pieces.push((file.len, extent));
                file.len += points_of(layout, &[extent]);
            }
            let own = Own { file: &file, points: first..file.len, bounds: facts.bounds };
            let density = density::estimate_of(&own, progress)?;
            let surface = Surface {
                points: first..file.len,
                center: facts.bounds.center(),
                density,
                opacity: facts.opacities[1].max(0.0),
            };
            file.surfaces.push(surface.clone());
            let uniform = facts.opacities[0] == surface.opacity;
            file.clouds.push(Facts { surface, bounds: facts.bounds, uniform, brightest: facts.brightest });
        }
        Ok(file)
    }

    /// Number of points.
    pub fn len(&self) -> u64 {
        self.len
    }

    /// True without points.
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// True if points have normals.
    pub fn has_normals(&self) -> bool {
        self.layout.has_normals
    }

    /// The clouds, in the order of their points.
    pub fn clouds(&self) -> &[Facts] {
        &self.clouds
    }

    /// Their properties alone.
    pub fn surfaces(&self) -> &[Surface] {
        &self.surfaces
    }

    /// Some points of the list, with their ids.
    ///
    /// # Errors
    /// The file can't be read.
    pub fn read(&self, range: Range<u64>) -> Result<Points, Error> {
        Ok(self.layout.points(&self.words(range)?))
    }

    fn words(&self, range: Range<u64>) -> Result<Vec<u32>, Error> {
        let size = self.layout.words() as u64;
        let mut words = Vec::with_capacity(usize::try_from((range.end - range.start) * size).unwrap_or_default());
        let mut at = self.pieces.partition_point(|(first, _)| *first <= range.start).saturating_sub(1);
        let mut next = range.start;
        while let Some((first, extent)) = self.pieces.get(at).filter(|_| next < range.end) {
            let end = range.end.min(first + extent.words / size);
            let start = extent.start + (next - first) * size;
            self.pile.read(Extent { start, words: (end - next) * size }, &mut words)?;
            (next, at) = (end, at + 1);
        }
        Ok(words)
    }
}

/// The points of a cloud of the list.
struct Own<'a> {
    file: &'a DealtFile,
    points: Range<u64>,
    bounds: Bounds,
}

impl Shuffled for Own<'_> {
    type Error = Error;

    fn count(&self) -> usize {
        (self.points.end - self.points.start) as usize
    }

    fn bounds(&self) -> Option<Bounds> {
        Some(self.bounds)
    }

    fn show(&self, count: usize, see: &mut dyn FnMut(&[DVec3])) -> Result<(), Error> {
        for first in (0..count).step_by(AT_ONCE) {
            let range = self.points.start + first as u64..self.points.start + count.min(first + AT_ONCE) as u64;
            see(&self.file.layout.positions(&self.file.words(range)?));
        }
        Ok(())
    }
}

/// The box of points, and what else is known of them.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Seen {
    bounds: Bounds,
    /// The smallest and the largest.
    opacities: [f32; 2],
    brightest: f32,
}

impl Seen {
    /// `None` without points.
    fn of(points: &Points) -> Option<Self> {
        let bounds = Bounds::enclosing(points.positions.iter().copied())?;
        let opacities = points.opacities.par_iter().map(|opacity| [*opacity; 2]);
        let opacities =
            opacities.reduce(|| [f32::INFINITY, f32::NEG_INFINITY], |a, b| [a[0].min(b[0]), a[1].max(b[1])]);
        let brightest = points.colors.par_iter().map(|color| color.max_element()).reduce(|| 0.0, f32::max);
        Some(Self { bounds, opacities, brightest })
    }

    fn and(self, other: Self) -> Self {
        let [least, most] = [other.opacities[0].min(self.opacities[0]), other.opacities[1].max(self.opacities[1])];
        Self {
            bounds: self.bounds.union(other.bounds),
            opacities: [least, most],
            brightest: self.brightest.max(other.brightest),
        }
    }
}
