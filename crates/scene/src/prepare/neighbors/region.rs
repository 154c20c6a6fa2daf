//! The places around a leaf, for the search of the neighbors of its places.
//!
//! Distances within a region are float32 first, in vectors as wide as the processor has: they say which few places can
//! be neighbors at all. Distances in float64 decide between those.

use glam::DVec3;

use super::search::{Columns, Found};
use super::tree::{Cuboid, Node, PlaceTree};

/// Places in the leaves around one, above which each of its places is looked for by itself.
const MOST_AROUND: usize = 4096;

/// Places that are looked at together.
pub(super) const LANES: usize = 8;

/// Limits that are tried before the places within one are taken, however many they are.
const TRIES: usize = 8;

/// Places beyond those wanted that a limit may leave to be decided in float64.
const SPARE: usize = 8;

/// The lanes of each set of them, in ascending order, and zeros behind.
const PACKED: [[u8; LANES]; 1 << LANES] = packed();

const fn packed() -> [[u8; LANES]; 1 << LANES] {
    let mut packed = [[0; LANES]; 1 << LANES];
    let mut set = 0;
    while set < packed.len() {
        let (mut lane, mut count) = (0, 0);
        while lane < LANES {
            if set >> lane & 1 == 1 {
                packed[set][count] = lane as u8;
                count += 1;
            }
            lane += 1;
        }
        set += 1;
    }
    packed
}

/// Writes the numbers `first` + lane of a set of lanes, with more behind them; returns how many they are.
#[inline(always)]
fn write_set(to: &mut [u32], set: usize, first: u32) -> usize {
    for (to, lane) in to[..LANES].iter_mut().zip(&PACKED[set]) {
        *to = first + u32::from(*lane);
    }
    set.count_ones() as usize
}

/// All places within reach of a leaf.
#[derive(Default)]
pub(super) struct Region {
    /// Places in ascending order.
    places: Vec<u32>,
    /// Offsets of the places from the middle of the leaf, times `scale`, a coordinate at a time: at most 1. Infinity
    /// fills the last vector.
    offsets: [Vec<f32>; 3],
    /// Squared distances from the place that was measured last, in the unit of offsets.
    squared: Vec<f32>,
    middle: DVec3,
    /// A power of two.
    scale: f64,
    /// The squared distance from the leaf within which there are all places.
    pub reach: f64,
    /// The leaves that are within reach.
    leaves: Vec<Node>,
}

/// Returns a number that no squared distance in float64 exceeds where that in float32 is `squared`, and the other way
/// round; both of offsets of at most 1, whose rounding moves each coordinate of a difference by up to 2⁻²².
fn widened(squared: f64) -> f64 {
    squared + squared.sqrt() * 2f64.powi(-19) + squared * 2f64.powi(-20) + 2f64.powi(-38)
}

impl Region {
    /// Gathers the places within a squared distance of a leaf. False if they are too many, or too far or too near for
    /// float32.
    #[inline(always)]
    pub fn gather(&mut self, tree: &PlaceTree, columns: &Columns, leaf: &Cuboid, reach: f64) -> bool {
        self.reach = reach;
        if !self.list(tree, leaf) {
            return false;
        }
        let half = 0.5 * leaf.max - 0.5 * leaf.min;
        self.middle = leaf.min + half;
        // A leaf's middle is rounded, too.
        let farthest = 1.01 * (half.max_element() + reach.sqrt());
        self.scale = (-farthest.log2().ceil()).exp2();
        if !(farthest.is_normal() && self.scale.is_normal()) {
            return false;
        }
        let most: usize = self.leaves.iter().map(|leaf| leaf.leaf_len as usize).sum();
        self.places.resize(most + LANES, 0);
        let mut count = 0;
        for at in &self.leaves {
            count += within(columns, leaf, reach, *at, &mut self.places[count..]);
        }
        self.places.truncate(count);
        self.offset(columns);
        true
    }

    /// Finds the offsets of all places.
    #[inline(always)]
    fn offset(&mut self, columns: &Columns) {
        let padded = self.places.len().next_multiple_of(LANES);
        self.squared.resize(padded, f32::INFINITY);
        let (middle, scale) = (self.middle, self.scale);
        let [x, y, z] = &mut self.offsets;
        for offsets in [&mut *x, &mut *y, &mut *z] {
            offsets.clear();
            offsets.resize(padded, f32::INFINITY);
        }
        let all = columns.all();
        for (((place, x), y), z) in self.places.iter().zip(x).zip(y).zip(z) {
            let at = *place as usize;
            *x = ((all[0][at] - middle.x) * scale) as f32;
            *y = ((all[1][at] - middle.y) * scale) as f32;
            *z = ((all[2][at] - middle.z) * scale) as f32;
        }
    }

    /// Lists the leaves within reach of one; false if their places are too many.
    fn list(&mut self, tree: &PlaceTree, leaf: &Cuboid) -> bool {
        self.leaves.clear();
        let (mut index, mut places) = (0, 0);
        while let Some(node) = tree.nodes.get(index) {
            if node.cuboid.squared(leaf) > self.reach {
                index = node.next as usize;
                continue;
            }
            index += 1;
            if node.leaf_len > 0 {
                places += node.leaf_len as usize;
                self.leaves.push(*node);
            }
            if places > MOST_AROUND {
                return false;
            }
        }
        true
    }

    /// Finds the places that may be among the `wanted` nearest of a place of the leaf, with their squared distances;
    /// about as many lie within the squared distance `guess`. False if there are fewer.
    #[inline(always)]
    pub fn find(&mut self, columns: &Columns, here: DVec3, wanted: usize, guess: f64, found: &mut Found) -> bool {
        self.measure(((here - self.middle) * self.scale).as_vec3().to_array());
        let Some(limit) = self.limit(wanted, guess * self.scale * self.scale) else { return false };
        // One way for the last place wanted, and back for those as near in float64.
        let limit = widened(widened(limit)) as f32;
        found.make_room(self.squared.len() + LANES);
        let (places, mut count) = (&mut found.places[..], 0);
        let (all, _) = self.squared.as_chunks::<LANES>();
        for (squared, first) in all.iter().zip((0..).step_by(LANES)) {
            let mut set = 0;
            for (lane, squared) in squared.iter().enumerate() {
                set |= usize::from(*squared <= limit) << lane;
            }
            count += write_set(&mut places[count..], set, first);
        }
        found.count = count;
        // Slices of their own: a store could change a vector's address for all that the compiler knows.
        let ([x, y, z], all) = (columns.all(), &self.places[..]);
        for (place, squared) in places[..count].iter_mut().zip(&mut found.squared[..]) {
            *place = all[*place as usize];
            let at = *place as usize;
            let (x, y, z) = (x[at] - here.x, y[at] - here.y, z[at] - here.z);
            *squared = x * x + y * y + z * z;
        }
        true
    }

    /// Measures the distances of all places from an offset.
    #[inline(always)]
    fn measure(&mut self, here: [f32; 3]) {
        let count = self.squared.len();
        let [x, y, z] = &self.offsets;
        let (x, y, z) = (&x[..count], &y[..count], &z[..count]);
        for (i, squared) in self.squared.iter_mut().enumerate() {
            let (x, y, z) = (x[i] - here[0], y[i] - here[1], z[i] - here[2]);
            *squared = x * x + y * y + z * z;
        }
    }

    /// Returns a squared distance that at least so many places don't exceed, and few more if it is found soon. `None`
    /// if there are fewer within reach.
    #[inline(always)]
    fn limit(&self, wanted: usize, guess: f64) -> Option<f64> {
        let most = self.reach * self.scale * self.scale;
        let (mut low, mut high) = (0.0, most);
        let mut limit = if guess > 0.0 { guess.min(most) } else { most };
        for _ in 0..TRIES {
            let count = self.count(limit as f32);

            if (wanted..=wanted + SPARE).contains(&count) {
                return Some(limit);
            }
            if count < wanted {
                if limit >= most {
                    return None;
                }
                low = limit;
            } else {
                high = limit;
            }
            // On a surface, counts grow as squared distances do.
            let share = (wanted + SPARE / 2) as f64 / (count as f64 + 0.5);
            let next = (limit * share.min(4.0)).min(most);
            limit =
                if low < next && (next < high || next == most && count < wanted) { next } else { 0.5 * (low + high) };
        }
        (self.count(high as f32) >= wanted).then_some(high)
    }

    #[inline(always)]
    fn count(&self, limit: f32) -> usize {
        // Of 32 bits, as the distances are: they add in vectors.
        self.squared.iter().fold(0, |count, squared| count + u32::from(*squared <= limit)) as usize
    }
}

/// Writes the places of a leaf that are within a squared distance of another one; returns how many they are.
#[inline(always)]
fn within(columns: &Columns, middle: &Cuboid, reach: f64, leaf: Node, to: &mut [u32]) -> usize {
    let (first, end) = (leaf.first as usize, (leaf.first + leaf.leaf_len) as usize);
    let mut count = 0;
    for first in (first..end).step_by(LANES) {
        let [x, y, z] = columns.lanes(first);
        let mut set = 0;
        for (lane, ((x, y), z)) in x.iter().zip(y).zip(z).enumerate() {
            let x = larger(larger(middle.min.x - x, x - middle.max.x), 0.0);
            let y = larger(larger(middle.min.y - y, y - middle.max.y), 0.0);
            let z = larger(larger(middle.min.z - z, z - middle.max.z), 0.0);
            set |= usize::from(x * x + y * y + z * z <= reach) << lane;
        }
        // Lanes behind the end are places of the next leaf.
        set &= (1 << (end - first).min(LANES)) - 1;
        count += write_set(&mut to[count..], set, first as u32);
    }
    count
}

/// The larger of two numbers; one instruction, which `f64::max` is not.
#[inline(always)]
pub(super) fn larger(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}
