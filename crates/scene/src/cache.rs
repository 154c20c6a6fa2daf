//! Values that were read, as many as memory is given for: those that were used last.

use std::collections::{BTreeMap, HashMap};
use std::sync::{Arc, Mutex, PoisonError};

/// Values by number.
#[derive(Debug)]
pub(crate) struct Cache<T> {
    /// Bytes that it holds at most.
    pub most: u64,
    bytes_of: fn(&T) -> u64,
    held: Mutex<Held<T>>,
}

#[derive(Debug)]
struct Held<T> {
    /// Values by number, with the time of their last use.
    values: HashMap<usize, (Arc<T>, u64)>,
    /// Numbers by when they were last used.
    used: BTreeMap<u64, usize>,
    now: u64,
    bytes: u64,
}

impl<T> Cache<T> {
    /// Returns an empty one of values of so many bytes.
    pub fn new(most: u64, bytes_of: fn(&T) -> u64) -> Self {
        Self { most, bytes_of, held: Mutex::default() }
    }

    /// Gives the memory of all values back.
    pub fn clear(&self) {
        *self.lock() = Held::default();
    }

    /// Returns a value, which `read` reads unless it is held.
    pub fn get<E>(&self, number: usize, read: impl FnOnce() -> Result<T, E>) -> Result<Arc<T>, E> {
        if let Some(value) = self.lock().find(number) {
            return Ok(value);
        }
        let value = Arc::new(read()?);
        self.lock().add(number, &value, self.bytes_of, self.most);
        Ok(value)
    }

    fn lock(&self) -> std::sync::MutexGuard<'_, Held<T>> {
        self.held.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl<T> Default for Held<T> {
    fn default() -> Self {
        Self { values: HashMap::new(), used: BTreeMap::new(), now: 0, bytes: 0 }
    }
}

impl<T> Held<T> {
    fn find(&mut self, number: usize) -> Option<Arc<T>> {
        self.now += 1;
        let (value, last) = self.values.get_mut(&number)?;
        self.used.remove(last);
        *last = self.now;
        self.used.insert(self.now, number);
        Some(Arc::clone(value))
    }

    fn add(&mut self, number: usize, value: &Arc<T>, bytes_of: fn(&T) -> u64, most: u64) {
        let bytes = bytes_of(value);
        // Another thread may have read the same.
        if bytes > most || self.values.contains_key(&number) {
            return;
        }
        while self.bytes + bytes > most {
            let Some((_, oldest)) = self.used.pop_first() else { break };
            if let Some((value, _)) = self.values.remove(&oldest) {
                self.bytes -= bytes_of(&value);
            }
        }
        self.now += 1;
        self.used.insert(self.now, number);
        self.values.insert(number, (Arc::clone(value), self.now));
        self.bytes += bytes;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Tells if a cache had to read a value of so many bytes.
    fn reads(cache: &Cache<u64>, number: usize, bytes: u64) -> bool {
        let mut missed = false;
        let value = cache.get(number, || {
            missed = true;
            Ok::<_, ()>(bytes)
        });
        assert_eq!(value.as_deref(), Ok(&bytes));
        missed
    }

    #[test]
    fn the_cache_retains_the_most_recently_used_values() {
        let cache = Cache::new(72, |bytes| *bytes);
        let missed = |number| reads(&cache, number, 24);
        assert!(missed(0) && missed(1) && missed(2));
        assert!(!missed(0) && !missed(1));
        assert!(missed(3), "in place of 2");
        assert!(!missed(0) && !missed(1) && !missed(3) && missed(2));
        assert!(missed(0), "the one that was not used for longest");
        cache.clear();
        assert!(missed(0) && missed(2));
        assert!(reads(&cache, 4, 72) && missed(0), "a large value takes the place of all");
    }

    #[test]
    fn values_larger_than_the_cache_are_not_held() {
        let cache = Cache::new(20, |bytes| *bytes);
        assert!(reads(&cache, 0, 24) && reads(&cache, 0, 24));
    }

    #[test]
    fn an_error_is_returned_and_not_held() {
        let cache = Cache::new(20, |bytes: &u64| *bytes);
        assert_eq!(cache.get(0, || Err("no")), Err("no"));
        assert!(reads(&cache, 0, 8));
    }
}
