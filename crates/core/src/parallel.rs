//! Loops over all cores that are compiled once for each type of element.
//!
//! Rayon compiles the whole of its splitting and joining anew for every chain of iterators, since each closure is a
//! type of its own: that was 44% of what the scene crate had compiled. Here the closure of a caller is a reference to
//! code, called once for a part of the elements, so that it costs nothing within the part.
//! Loops that reduce, filter or sort are rayon's own.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};

use bytemuck::Zeroable;
use bytemuck::allocation::zeroed_vec;
use rayon::prelude::*;

/// Parts for each thread: some take longer than others.
const PARTS: usize = 8;

/// Calls `each` with the index of an element and the element, for all of them.
pub fn for_each_mut<T: Send>(elements: &mut [T], each: impl Fn(usize, &mut T) + Sync) {
    for_parts(elements, 1, &|first, part: &mut [T]| {
        part.iter_mut().enumerate().for_each(|(i, element)| each(first + i, element));
    });
}

/// Returns `of` each number below `count`, in order.
pub fn map<T: Zeroable + Send>(count: usize, of: impl Fn(usize) -> T + Sync) -> Vec<T> {
    // All threads touch the memory first, since the kernel clears every page then.
    let mut values = zeroed_vec(count);
    for_each_mut(&mut values, |i, value| *value = of(i));
    values
}

/// Returns `count` runs of `run` elements, one behind the other. `write` is given the number of a run and its elements,
/// zeros.
pub fn runs<T: Zeroable + Send>(count: usize, run: usize, write: impl Fn(usize, &mut [T]) + Sync) -> Vec<T> {
    let (mut values, run) = (zeroed_vec(count * run), run.max(1));
    for_parts(&mut values, run, &|first, part: &mut [T]| {
        part.chunks_mut(run).enumerate().for_each(|(i, elements)| write(first / run + i, elements));
    });
    values
}

/// Returns `of` each element, in order.
pub fn map_each<S: Sync, T: Zeroable + Send>(elements: &[S], of: impl Fn(&S) -> T + Sync) -> Vec<T> {
    map(elements.len(), |i| of(&elements[i]))
}

/// Returns `of` each number below `count`, in order, as [`map`] does, for values that own memory.
pub fn gather<T: Send>(count: usize, of: impl Fn(usize) -> T + Sync) -> Vec<T> {
    let mut values: Vec<Option<T>> = std::iter::repeat_with(|| None).take(count).collect();
    for_each_mut(&mut values, |i, value| *value = Some(of(i)));
    values.into_iter().flatten().collect()
}

/// Returns `of` each element, in order.
///
/// # Errors
/// Returns the error of the first element that failed; once one did, further ones may not be looked at.
pub fn try_map_each<S: Sync, T: Send, E: Send>(
    elements: &[S],
    of: impl Fn(&S) -> Result<T, E> + Sync,
) -> Result<Vec<T>, E> {
    let failed = AtomicBool::new(false);
    let result = |i: usize| {
        if failed.load(Ordering::Relaxed) {
            return None;
        }
        let found = of(&elements[i]);
        failed.fetch_or(found.is_err(), Ordering::Relaxed);
        Some(found)
    };
    gather(elements.len(), result).into_iter().flatten().collect()
}

/// Calls `each` with the index of a part's first element and the part, for all parts, which cut no run.
fn for_parts<T: Send>(elements: &mut [T], run: usize, each: &(dyn Fn(usize, &mut [T]) + Sync)) {
    let length = elements.len().div_ceil(PARTS * rayon::current_num_threads()).max(1).next_multiple_of(run);
    let parts = Mutex::new(elements.chunks_mut(length).enumerate());
    on_all_threads(&|| {
        loop {
            // The lock is held for this line alone.
            let next = parts.lock().unwrap_or_else(PoisonError::into_inner).next();
            let Some((i, part)) = next else { return };
            each(i * length, part);
        }
    });
}

/// Calls `work` once for each thread. A thread that is busy elsewhere leaves its call to the others.
#[inline(never)]
fn on_all_threads(work: &(dyn Fn() + Sync)) {
    (0..rayon::current_num_threads()).into_par_iter().with_max_len(1).for_each(|_| work());
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_in_the_order_of_their_elements() {
        for count in [0, 1, 7, 1000, 100_003] {
            let triples: Vec<usize> = (0..count).map(|i| 3 * i).collect();
            assert_eq!(map(count, |i| 3 * i), triples);
            let elements: Vec<u32> = (0..count as u32).rev().collect();
            assert_eq!(map_each(&elements, |x| x + 1), elements.iter().map(|x| x + 1).collect::<Vec<_>>());
            assert_eq!(try_map_each(&elements, |x| Ok::<_, ()>(*x)), Ok(elements));
        }
    }

    #[test]
    fn runs_are_whole() {
        for (count, run) in [(0, 3), (5, 0), (1, 7), (1001, 3)] {
            let written = runs(count, run, |i, elements| elements.fill(i));
            assert_eq!(written, (0..count * run).map(|at| at / run).collect::<Vec<_>>());
        }
    }

    #[test]
    fn each_element_is_visited_once_with_its_index() {
        let mut elements = vec![0; 5000];
        for_each_mut(&mut elements, |i, element| *element += i + 1);
        assert!(elements.iter().enumerate().all(|(i, element)| *element == i + 1));
    }

    #[test]
    fn the_error_is_that_of_an_element_that_failed() {
        let elements: Vec<usize> = (0..1000).collect();
        let odd_after = |least: usize| move |x: &usize| if *x >= least && x % 2 == 1 { Err(*x) } else { Ok(*x) };
        assert_eq!(try_map_each(&elements[..1], |_| Err::<(), _>(5)), Err(5));
        let error = try_map_each(&elements, odd_after(500)).unwrap_err();
        assert!(error >= 500 && error % 2 == 1, "{error}");
    }
}
