//! Points that are partitioned into ensembles in a temporary file, for clouds that memory has no room for: the list
//! that [`ensembles::deal`](super::ensembles::deal) makes, to the bit, as far as it is asked for. A picture of many
//! points that are hardly opaque takes few of them.
//!
//! The words that shuffle points are numbers at random. So those with the smallest words are put into buckets by them,
//! as many as let memory hold each, and each bucket is sorted by itself. Points in one place are counted, since their
//! ids differ: places that may have several are found first, and all points in these are brought together, whatever
//! their words.

mod buckets;
mod list;
mod pile;
mod places;
mod records;

use std::fmt;
use std::ops::Range;
use std::path::PathBuf;
use std::sync::Arc;

use glam::DVec3;
use rayon::prelude::*;

use self::list::List;
use self::pile::Pile;
use self::records::RecordLayout;
use super::density::{self, Shuffled};
use super::ensembles::CloudSurface;
use pellucid_core::cloud::Bounds;
use pellucid_core::points::{Anchor, Points};
use pellucid_core::progress::Progress;
use pellucid_io::Error;

/// Points that are read at a time where all are.
const AT_ONCE: usize = 4 * density::BLOCK;

/// Reads the points of a block, with those that are not drawn set apart.
pub type Read = Arc<dyn Fn(usize) -> Result<Points, Error> + Send + Sync>;

/// A cloud that is read block by block.
#[derive(Clone)]
pub struct CloudBlocks {
    /// Path of the store, for errors.
    pub path: PathBuf,
    /// Points of each block.
    pub blocks: Vec<u64>,
    /// Reads them.
    pub read: Read,
    /// The box of all points, also of those that are not drawn, in world coordinates.
    pub bounds: Bounds,
    /// Anchor that ids are made from: that of the cloud by itself.
    pub anchor: Anchor,
}

impl fmt::Debug for CloudBlocks {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Source").field("path", &self.path).field("blocks", &self.blocks.len()).finish_non_exhaustive()
    }
}

/// Settings by which clouds are shuffled into ensembles.
#[derive(Debug, Clone)]
pub struct DealSettings {
    /// `true` if points have normals.
    pub has_normals: bool,
    /// The seed of the shuffle.
    pub seed: u64,
    /// Bytes of memory that may be taken at a time.
    pub memory: u64,
    /// The folder of the temporary file.
    pub folder: PathBuf,
}

/// Facts about a cloud of the list.
#[derive(Debug, Clone, PartialEq)]
pub struct DealtCloud {
    /// Properties of the cloud.
    pub surface: CloudSurface,
    /// The box of its points that are drawn.
    pub bounds: Bounds,
    /// `true` if all of them have the same opacity.
    pub uniform: bool,
    /// The largest component of their colors.
    pub brightest: f32,
}

/// Points in random order, cloud after cloud, in a file without a name that goes with the process.
#[derive(Debug)]
pub struct DealtFile {
    pile: Pile,
    layout: RecordLayout,
    lists: Vec<List>,
    /// The clouds, in the order of their points.
    pub clouds: Vec<DealtCloud>,
    /// Properties of their surfaces alone.
    pub surfaces: Vec<CloudSurface>,
}

impl DealtFile {
    /// Shuffles clouds as [`ensembles::deal`](super::ensembles::deal) does. `progress` counts points, each of them
    /// three times.
    ///
    /// # Errors
    /// A block can't be read, the file can't be written, too many points are in one place, or `progress` cancels it.
    pub fn deal(clouds: Vec<CloudBlocks>, settings: &DealSettings, progress: &Progress) -> Result<Self, Error> {
        progress.set_length(3 * clouds.iter().flat_map(|cloud| &cloud.blocks).sum::<u64>());
        let pile = Pile::new(&settings.folder)?;
        let layout = RecordLayout { has_normals: settings.has_normals };
        let mut file = Self { pile, layout, lists: vec![], clouds: vec![], surfaces: vec![] };
        for cloud in clouds {
            let Some(list) = List::new(cloud, file.lists.len() as u32, settings, progress)? else { continue };
            let own = Own { list: &list, pile: &file.pile, layout, progress };
            let density = density::estimate_of(&own, progress)?;
            let (PointSummary { bounds, opacities, brightest }, first) = (list.seen, file.len());
            let opacity = opacities[1].max(0.0);
            let surface = CloudSurface { points: first..first + list.len, center: bounds.center(), density, opacity };
            file.surfaces.push(surface.clone());
            file.clouds.push(DealtCloud { surface, bounds, uniform: opacities[0] == opacity, brightest });
            file.lists.push(list);
        }
        Ok(file)
    }

    /// Returns the number of points.
    pub fn len(&self) -> u64 {
        self.surfaces.last().map_or(0, |surface| surface.points.end)
    }

    /// Returns `true` if there are no points.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Returns `true` if points have normals.
    pub fn has_normals(&self) -> bool {
        self.layout.has_normals
    }

    /// Returns the number of points that are in the file so far.
    pub fn reached(&self) -> u64 {
        self.lists.iter().map(List::reached).sum()
    }

    /// Brings the first points of each cloud into the file, as many as `counts` says, unless they are there.
    ///
    /// # Errors
    /// Returns the errors of [`deal`](Self::deal).
    pub fn reach(&self, counts: impl IntoIterator<Item = u64>, progress: &Progress) -> Result<(), Error> {
        let mut each = self.lists.iter().zip(counts);
        each.try_for_each(|(list, count)| list.reach(count, &self.pile, progress))
    }

    /// Returns some points of the list, with their ids. Those of the last cloud of the range that are not in the file
    /// yet are brought there, and more behind them. Those of a cloud before it then are zeros: who binds the first
    /// points of a cloud binds the last ones of another beside them, which it has no use for.
    ///
    /// # Errors
    /// Returns the errors of [`deal`](Self::deal).
    pub fn read(&self, range: Range<u64>) -> Result<Points, Error> {
        let mut words = Vec::new();
        for (list, surface) in self.lists.iter().zip(&self.surfaces) {
            let Range { start: first, end } = surface.points;
            let (start, end) = (range.start.max(first), range.end.min(end));
            if start >= end {
                continue;
            }
            let own = start - first..end - first;
            if own.end <= list.reached() {
                list.read(own, &self.pile, &mut words)?;
            } else if end < range.end {
                words.resize(words.len() + (own.end - own.start) as usize * self.layout.words(), 0);
            } else {
                list.reach(2 * own.end, &self.pile, &Progress::hidden())?;
                list.read(own, &self.pile, &mut words)?;
            }
        }
        Ok(self.layout.points(&words))
    }
}

/// The points of a cloud of the list.
struct Own<'a> {
    list: &'a List,
    pile: &'a Pile,
    layout: RecordLayout,
    progress: &'a Progress,
}

impl Shuffled for Own<'_> {
    type Error = Error;

    fn count(&self) -> usize {
        self.list.len as usize
    }

    fn bounds(&self) -> Option<Bounds> {
        Some(self.list.seen.bounds)
    }

    fn show(&self, count: usize, see: &mut dyn FnMut(&[DVec3])) -> Result<(), Error> {
        // At once what is asked for next.
        self.list.reach(count.max(density::COUNTED) as u64, self.pile, self.progress)?;
        for first in (0..count).step_by(AT_ONCE) {
            let mut words = Vec::new();
            self.list.read(first as u64..count.min(first + AT_ONCE) as u64, self.pile, &mut words)?;
            see(&self.layout.positions(&words));
        }
        Ok(())
    }
}

/// The box of points, and what else is known of them.
#[derive(Debug, Clone, Copy, PartialEq)]
struct PointSummary {
    bounds: Bounds,
    /// The smallest and the largest.
    opacities: [f32; 2],
    brightest: f32,
}

impl PointSummary {
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

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;
    use crate::prepare::ensembles::{Dealt, deal};

    const SEED: u64 = 5;
    const POINTS: usize = 60_000;
    /// Memory for all of them would be four times as much.
    const MEMORY: u64 = 4 << 20;

    /// Points on a wave of a grid of places, some of which have several.
    fn wave(count: usize) -> Points {
        let at = |i: usize| {
            let place = if i.is_multiple_of(10) { i / 3 } else { i };
            DVec3::new(place as f64 * 0.001, (place * 7919 % 1000) as f64 * 0.002, (place as f64 * 0.01).sin())
        };
        Points {
            positions: (0..count).map(at).collect(),
            colors: (0..count).map(|i| Vec3::splat(i as f32)).collect(),
            opacities: vec![0.25; count],
            radii: vec![0.01; count],
            ..Points::default()
        }
    }

    /// The points in blocks of 700, as they come.
    fn source(points: &Points) -> CloudBlocks {
        let starts = (0..points.len()).step_by(700);
        let blocks = starts.map(|start| (start as u32..points.len().min(start + 700) as u32).collect::<Vec<_>>());
        let blocks: Vec<Points> = blocks.map(|block| points.subset(&block, 1.0)).collect();
        CloudBlocks {
            path: PathBuf::from("wave"),
            blocks: blocks.iter().map(|block| block.len() as u64).collect(),
            bounds: points.drawn_bounds().expect("points"),
            anchor: points.anchor(),
            read: Arc::new(move |block| Ok(blocks[block].clone())),
        }
    }

    fn settings() -> DealSettings {
        DealSettings { has_normals: false, seed: SEED, memory: MEMORY, folder: std::env::temp_dir() }
    }

    fn list(points: &Points, place: u32) -> List {
        List::new(source(points), place, &settings(), &Progress::hidden()).expect("read").expect("points")
    }

    fn assert_same(file: &DealtFile, dealt: &Dealt, range: Range<usize>) {
        let found = file.read(range.start as u64..range.end as u64).expect("read");
        let places: Vec<u32> = (range.start as u32..range.end as u32).collect();
        let expected = dealt.points.subset(&places, 1.0);
        assert!(found.positions == expected.positions, "{range:?}: positions");
        assert!(found.dealt_ids == expected.dealt_ids, "{range:?}: ids");
        assert!(found.colors == expected.colors, "{range:?}: colors");
    }

    /// The first points of a list of which no more than some are in the file.
    fn beginning(points: &Points) -> (DealtFile, Dealt) {
        let (pile, layout) = (Pile::new(&settings().folder).expect("a file"), RecordLayout { has_normals: false });
        let list = list(points, 0);
        let dealt = deal(vec![points.clone()], SEED, &Progress::hidden());
        assert_eq!(list.len, points.len() as u64);
        let surfaces = dealt.surfaces.clone();
        (DealtFile { pile, layout, lists: vec![list], clouds: vec![], surfaces }, dealt)
    }

    #[test]
    fn a_list_is_made_as_far_as_it_is_asked_for() {
        let (file, dealt) = beginning(&wave(POINTS));
        let repeated = dealt.points.dealt_ids.len() - {
            let mut places: Vec<_> = dealt.points.positions.iter().map(|p| p.to_array().map(f64::to_bits)).collect();
            places.sort_unstable();
            places.dedup();
            places.len()
        };
        assert!(repeated > POINTS / 20, "{repeated} points in the places of others");
        assert_eq!(file.reached(), 0);
        file.reach([10], &Progress::hidden()).unwrap();
        let first = file.reached() as usize;
        assert!((POINTS / 5..POINTS / 3).contains(&first), "{first}");
        assert_same(&file, &dealt, 0..first);
        file.reach([first as u64], &Progress::hidden()).unwrap();
        assert_eq!(file.reached(), first as u64, "nothing to do");
        // Over the end of what is there; more than half is everything.
        assert_same(&file, &dealt, first - 5..first + 5);
        assert_eq!(file.reached(), POINTS as u64);
        assert_same(&file, &dealt, 0..POINTS);
    }

    #[test]
    fn lists_grow_in_pieces() {
        let (file, dealt) = beginning(&wave(4 * POINTS));
        let mut reached = vec![];
        for end in [1, POINTS / 3, POINTS] {
            file.reach([end as u64], &Progress::hidden()).unwrap();
            reached.push(file.reached());
            assert!(file.reached() >= end as u64);
            assert_same(&file, &dealt, 0..end);
        }
        assert!(reached.is_sorted_by(|a, b| a < b) && reached[2] < 2 * POINTS as u64, "{reached:?}");
        assert_same(&file, &dealt, 0..4 * POINTS);
    }

    #[test]
    fn clouds_are_dealt_one_behind_the_other() {
        let clouds = [wave(9_000), wave(20_000)];
        let dealt = deal(clouds.to_vec(), SEED, &Progress::hidden());
        let sources = clouds.iter().map(source).collect();
        let file = DealtFile::deal(sources, &settings(), &Progress::hidden()).expect("dealt");
        assert_eq!(file.surfaces, dealt.surfaces);
        assert_same(&file, &dealt, 0..29_000);
        assert_same(&file, &dealt, 8_990..9_010);
    }

    #[test]
    fn points_beside_those_of_a_cloud_are_not_brought() {
        let clouds = [wave(POINTS), wave(3_000)];
        let dealt = deal(clouds.to_vec(), SEED, &Progress::hidden());
        let (mut file, _) = beginning(&clouds[0]);
        file.lists.push(list(&clouds[1], 1));
        file.surfaces = dealt.surfaces.clone();
        let found = file.read(POINTS as u64 - 8..POINTS as u64 + 100).unwrap();
        assert_eq!(found.dealt_ids[..8], [0; 8]);
        assert_eq!(found.dealt_ids[8..], dealt.points.dealt_ids[POINTS..POINTS + 100]);
        assert_eq!(file.lists[0].reached(), 0);
        file.reach([POINTS as u64; 2], &Progress::hidden()).unwrap();
        assert_same(&file, &dealt, 0..POINTS + 3_000);
    }
}
