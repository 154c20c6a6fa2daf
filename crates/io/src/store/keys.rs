//! Nodes of octrees that are named by level and place, as COPC and EPT name them.

use glam::DVec3;

use pellucid_core::cloud::Bounds;

/// The deepest level: places on it fill the 31 bits that files give them.
const DEEPEST: u32 = 31;

/// A node's level and its place among the 2^level cubes along each axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(super) struct Key {
    pub level: u32,
    pub place: [u32; 3],
}

impl Key {
    /// Returns the key of some numbers; `None` if that is no node of an octree.
    pub fn new([level, place @ ..]: [i64; 4]) -> Option<Self> {
        let level = u32::try_from(level).ok().filter(|&level| level <= DEEPEST)?;
        let place = place.map(|at| u32::try_from(at).ok().filter(|&at| u64::from(at) < 1 << level));
        let [Some(x), Some(y), Some(z)] = place else { return None };
        Some(Self { level, place: [x, y, z] })
    }

    /// Returns the key of a name as `3-1-0-7`.
    pub fn parse(name: &str) -> Option<Self> {
        let mut numbers = name.split('-').map(str::parse::<u32>);
        let mut next = || Some(i64::from(numbers.next()?.ok()?));
        let key = [next()?, next()?, next()?, next()?];
        if numbers.next().is_some() { None } else { Self::new(key) }
    }

    /// Returns the node above; `None` of the root.
    pub fn parent(self) -> Option<Self> {
        let level = self.level.checked_sub(1)?;
        Some(Self { level, place: self.place.map(|at| at / 2) })
    }

    /// Returns its part of the root's cube, whose side is the same along all axes.
    pub fn cube(self, root: &Bounds) -> Bounds {
        // Halved exactly, so that a node's corner is the same number as that of the node above.
        let side = (root.max - root.min) / (1u64 << self.level) as f64;
        let corner = |add: u64| DVec3::from(self.place.map(|at| (u64::from(at) + add) as f64)) * side + root.min;
        Bounds { min: corner(0), max: corner(1) }
    }
}

impl std::fmt::Display for Key {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let [x, y, z] = self.place;
        write!(f, "{}-{x}-{y}-{z}", self.level)
    }
}

/// Returns the part of a box that lies in another; `None` if they have no point in common.
pub(super) fn cut(a: Bounds, b: Bounds) -> Option<Bounds> {
    let (min, max) = (a.min.max(b.min), a.max.min(b.max));
    min.cmple(max).all().then_some(Bounds { min, max })
}

/// Returns the place of the closest node above each one in a sorted list of keys.
pub(super) fn parents(keys: &[Key]) -> Vec<Option<u32>> {
    let above = |key: &Key| {
        let mut key = *key;
        while let Some(parent) = key.parent() {
            if let Ok(at) = keys.binary_search(&parent) {
                return u32::try_from(at).ok();
            }
            key = parent;
        }
        None
    };
    keys.iter().map(above).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_outside_of_the_octree_are_none() {
        assert!(Key::new([0, 0, 0, 0]).is_some() && Key::new([31, (1 << 31) - 1, 0, 0]).is_some());
        for numbers in [[-1, 0, 0, 0], [0, 1, 0, 0], [3, 0, 8, 0], [3, 0, 0, -1], [32, 0, 0, 0], [1 << 32, 0, 0, 0]] {
            assert_eq!(Key::new(numbers), None, "{numbers:?}");
        }
        assert_eq!(Key::parse("3-1-0-7").map(|key| key.to_string()).as_deref(), Some("3-1-0-7"));
        for name in ["", "3-1-0", "3-1-0-8", "3-1-0-7-0", "3--1-0-7", "a-0-0-0", "4294967296-0-0-0"] {
            assert_eq!(Key::parse(name), None, "{name}");
        }
    }

    #[test]
    fn cubes_lie_in_those_above() {
        let root = Bounds { min: DVec3::new(0.1, -7.3, 1e6), max: DVec3::new(1.1, -6.3, 1e6 + 1.0) };
        let mut key = Key::new([31, 1_234_567_890, 2_147_483_647, 0]).unwrap();
        assert_eq!(Key::new([0; 4]).unwrap().cube(&root), root);
        while let Some(parent) = key.parent() {
            assert!(parent.cube(&root).holds(&key.cube(&root)), "{key}");
            key = parent;
        }
    }

    #[test]
    fn the_closest_node_above_is_the_parent() {
        let mut keys = ["0-0-0-0", "1-1-0-0", "3-7-3-0", "3-0-0-0"].map(|name| Key::parse(name).unwrap());
        keys.sort();
        assert_eq!(parents(&keys), [None, Some(0), Some(0), Some(1)]);
        assert_eq!(
            cut(
                keys[1].cube(&Bounds { min: DVec3::ZERO, max: DVec3::ONE }),
                Bounds { min: DVec3::ZERO, max: DVec3::splat(0.4) }
            ),
            None
        );
    }
}
