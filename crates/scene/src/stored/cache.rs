//! Points of blocks that were read, as many as memory is given for: those that were used last.

use std::collections::{BTreeMap, HashMap};
use std::sync::{Arc, Mutex, PoisonError};

use crate::supply::Failure;
use pellucid_core::points::Points;

/// The points of some blocks.
#[derive(Debug)]
pub(super) struct Cache {
    /// Bytes that it holds at most.
    pub most: u64,
    held: Mutex<CachedPoints>,
}

#[derive(Debug, Default)]
struct CachedPoints {
    /// Points by block, with the time of their last use.
    points: HashMap<u32, (Arc<Points>, u64)>,
    /// Blocks by when they were last used.
    used: BTreeMap<u64, u32>,
    now: u64,
    bytes: u64,
    read: u64,
}

impl Cache {
    /// Returns an empty one.
    pub fn new(most: u64) -> Self {
        Self { most, held: Mutex::default() }
    }

    /// Returns the number of bytes that were read of the store so far.
    pub fn bytes_read(&self) -> u64 {
        self.lock().read
    }

    /// Counts bytes that were read of the store for points that are not kept.
    pub fn count(&self, bytes: u64) {
        self.lock().read += bytes;
    }

    /// Gives the memory of all points back.
    pub fn clear(&self) {
        let mut held = self.lock();
        *held = CachedPoints { read: held.read, ..CachedPoints::default() };
    }

    /// Returns the points of a block. `read` reads them, with how many bytes of the store that took.
    pub fn get(
        &self,
        block: u32,
        read: impl FnOnce() -> Result<(Points, u64), Failure>,
    ) -> Result<Arc<Points>, Failure> {
        if let Some(points) = self.lock().find(block) {
            return Ok(points);
        }
        let (points, bytes) = read()?;
        let points = Arc::new(points);
        let mut held = self.lock();
        held.read += bytes;
        held.add(block, &points, self.most);
        Ok(points)
    }

    fn lock(&self) -> std::sync::MutexGuard<'_, CachedPoints> {
        self.held.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl CachedPoints {
    fn find(&mut self, block: u32) -> Option<Arc<Points>> {
        self.now += 1;
        let (points, last) = self.points.get_mut(&block)?;
        self.used.remove(last);
        *last = self.now;
        self.used.insert(self.now, block);
        Some(Arc::clone(points))
    }

    fn add(&mut self, block: u32, points: &Arc<Points>, most: u64) {
        let bytes = points.bytes();
        // Another thread may have read the same.
        if bytes > most || self.points.contains_key(&block) {
            return;
        }
        while self.bytes + bytes > most {
            let Some((_, oldest)) = self.used.pop_first() else { break };
            if let Some((points, _)) = self.points.remove(&oldest) {
                self.bytes -= points.bytes();
            }
        }
        self.now += 1;
        self.used.insert(self.now, block);
        self.points.insert(block, (Arc::clone(points), self.now));
        self.bytes += bytes;
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;

    #[test]
    fn the_cache_retains_the_most_recently_used_blocks() {
        // 24 bytes a block.
        let cache = Cache::new(72);
        let points = || Points { positions: vec![DVec3::ONE], ..Points::default() };
        let get = |block| {
            let mut missed = false;
            cache
                .get(block, || {
                    missed = true;
                    Ok((points(), 10))
                })
                .unwrap();
            missed
        };
        assert!(get(0) && get(1) && get(2));
        assert!(!get(0) && !get(1));
        assert!(get(3), "in place of 2");
        assert!(!get(0) && !get(1) && !get(3) && get(2));
        assert!(get(0), "the one that was not used for longest");
        assert_eq!(cache.bytes_read(), 60);
        // A block that is larger than the cache is not kept.
        let small = Cache::new(20);
        for _ in 0..2 {
            small.get(0, || Ok((points(), 10))).unwrap();
        }
        assert_eq!(small.bytes_read(), 20);
        let failed = small.get(1, || Err(Failure::Cancelled));
        assert!(matches!(failed, Err(Failure::Cancelled)));
    }
}
