//! Points by a code each, sorted by the digits of the codes on all cores.

use std::cmp::Ordering;
use std::slice::IterMut;

use bytemuck::Zeroable;
use rayon::prelude::*;

use pellucid_core::parallel;

/// Bits of a code.
const CODE_BITS: u32 = 63;
/// Bits of a digit at most: as many places as stay in the processor's cache with what is written to them.
const DIGIT_BITS: u32 = 10;
/// Points whose codes one thread looks at together to see whether they ascend.
const LOOKED_AT: usize = 1 << 14;
/// Points that are compared rather than counted, at most.
const FEW: usize = 48;
/// Points from which on all cores count them together.
const MANY: usize = 1 << 20;
/// Runs of points for each core, so that a slow one holds up the others little.
const RUNS_PER_CORE: usize = 4;

/// A code and the index of the point that has it, in 12 bytes.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Zeroable)]
pub(super) struct Keyed {
    /// The halves of the code, since a whole one would take 16 bytes with the index.
    high: u32,
    low: u32,
    pub index: u32,
}

impl Keyed {
    fn new(code: u64, index: u32) -> Self {
        Self { high: (code >> 32) as u32, low: code as u32, index }
    }

    pub fn code(self) -> u64 {
        u64::from(self.high) << 32 | u64::from(self.low)
    }
}

/// Returns the codes of 63 bits of so many points in ascending order; those of equal codes in the order of
/// `by_content`, and of equal content in that of their indices.
///
/// Codes are found twice, so that nothing but the result needs memory. Each digit, from the highest on, cuts a run of
/// points into shorter ones, until these are few enough to be compared. Codes that ascend stay where they are.
pub(super) fn sorted(
    count: u32,
    code: impl Fn(u32) -> u64 + Sync,
    by_content: &(impl Fn(u32, u32) -> Ordering + Sync),
) -> Vec<Keyed> {
    if are_ordered(count, &code, |before, next| before.1 <= next.1) {
        let mut all = parallel::map(count as usize, |i| Keyed::new(code(i as u32), i as u32));
        let equal = all.par_chunk_by_mut(|a, b| a.code() == b.code()).filter(|equal| equal.len() > 1);
        equal.for_each(|equal| by_indices(equal, by_content));
        return all;
    }
    let mut all = vec![Keyed::default(); count as usize];
    let digit = Digit::below(CODE_BITS, count as usize);
    let sizes = scatter(count as usize, |i| Keyed::new(code(i as u32), i as u32), digit, &mut all);
    sort_each(&mut all, &sizes, digit.shift, by_content);
    all
}

/// Returns `true` if [`sorted`] would return all points as they come.
pub(super) fn are_sorted(
    count: u32,
    code: impl Fn(u32) -> u64 + Sync,
    by_content: &(impl Fn(u32, u32) -> Ordering + Sync),
) -> bool {
    are_ordered(count, &code, |before, next| {
        before.1.cmp(&next.1).then_with(|| by_content(before.0, next.0)) != Ordering::Greater
    })
}

/// Returns `true` if `are` holds for all pairs of a point and the next one, each by its index and its code.
fn are_ordered(
    count: u32,
    code: &(impl Fn(u32) -> u64 + Sync),
    are: impl Fn((u32, u64), (u32, u64)) -> bool + Sync,
) -> bool {
    let count = count as usize;
    let run = |start: usize| {
        let start = start * LOOKED_AT;
        // Each run but the first begins with the last point of the one before.
        let mut points = (start.saturating_sub(1)..count.min(start + LOOKED_AT)).map(|i| (i as u32, code(i as u32)));
        let Some(mut before) = points.next() else { return true };
        points.all(|next| are(std::mem::replace(&mut before, next), next))
    };
    (0..count.div_ceil(LOOKED_AT)).into_par_iter().with_max_len(1).all(run)
}

/// Some bits of a code.
#[derive(Clone, Copy)]
struct Digit {
    /// Bits below it.
    shift: u32,
    mask: usize,
}

impl Digit {
    /// The digit above which all bits but the lowest `left` are, for so many points.
    fn below(left: u32, points: usize) -> Self {
        let bits = points.max(2).ilog2().min(DIGIT_BITS).min(left);
        Self { shift: left - bits, mask: (1 << bits) - 1 }
    }

    fn values(self) -> usize {
        self.mask + 1
    }

    #[inline]
    fn of(self, keyed: Keyed) -> usize {
        (keyed.code() >> self.shift) as usize & self.mask
    }
}

/// Puts points in the order of a digit, those of equal digits as they come; returns how many have each.
fn scatter(count: usize, point: impl Fn(usize) -> Keyed + Sync, digit: Digit, to: &mut [Keyed]) -> Vec<usize> {
    let run = count.div_ceil(rayon::current_num_threads() * RUNS_PER_CORE).max(1);
    let runs: Vec<_> = (0..count).step_by(run).map(|start| start..count.min(start + run)).collect();
    let count_run = |i: usize| {
        let mut sizes = vec![0u32; digit.values()];
        runs[i].clone().for_each(|i| sizes[digit.of(point(i))] += 1);
        sizes
    };
    let sizes: Vec<Vec<u32>> = parallel::gather(runs.len(), count_run);
    let mut places: Vec<Vec<IterMut<'_, Keyed>>> = runs.iter().map(|_| Vec::with_capacity(digit.values())).collect();
    let mut totals = vec![0; digit.values()];
    let mut rest = to;
    for (value, total) in totals.iter_mut().enumerate() {
        for (sizes, places) in sizes.iter().zip(&mut places) {
            let (own, behind) = rest.split_at_mut(sizes[value] as usize);
            *total += own.len();
            places.push(own.iter_mut());
            rest = behind;
        }
    }
    parallel::for_each_mut(&mut places, |run, places| {
        for i in runs[run].clone() {
            let point = point(i);
            if let Some(place) = places[digit.of(point)].next() {
                *place = point;
            }
        }
    });
    totals
}

/// Sorts runs of these lengths by the lowest `left` bits.
fn sort_each(all: &mut [Keyed], lengths: &[usize], left: u32, by_content: &(impl Fn(u32, u32) -> Ordering + Sync)) {
    let mut rest = all;
    let mut runs = Vec::with_capacity(lengths.len());
    for &length in lengths {
        let (run, behind) = rest.split_at_mut(length);
        runs.push(run);
        rest = behind;
    }
    runs.into_par_iter().for_each_init(Vec::new, |room, run| sort(run, left, room, by_content));
}

/// Sorts points that differ in the lowest `left` bits at most. They come in the order of their indices where codes are
/// equal.
fn sort(run: &mut [Keyed], left: u32, room: &mut Vec<Keyed>, by_content: &(impl Fn(u32, u32) -> Ordering + Sync)) {
    if left == 0 {
        return by_indices(run, by_content);
    }
    if run.len() <= FEW {
        run.sort_unstable_by_key(|keyed| (keyed.code(), keyed.index));
        let equal = run.chunk_by_mut(|a, b| a.code() == b.code()).filter(|equal| equal.len() > 1);
        return equal.for_each(|equal| by_indices(equal, by_content));
    }
    let digit = Digit::below(left, run.len());
    if run.len() >= MANY {
        let from: Vec<Keyed> = run.par_iter().copied().collect();
        let sizes = scatter(from.len(), |i| from[i], digit, run);
        drop(from);
        return sort_each(run, &sizes, digit.shift, by_content);
    }
    let mut ends = [0; 1 << DIGIT_BITS];
    run.iter().for_each(|keyed| ends[digit.of(*keyed)] += 1);
    let ends = &mut ends[..digit.values()];
    if ends.contains(&run.len()) {
        return sort(run, digit.shift, room, by_content);
    }
    let mut before = 0;
    for end in &mut *ends {
        before += std::mem::replace(end, before);
    }
    room.clear();
    room.extend_from_slice(run);
    for keyed in room.iter() {
        let end = &mut ends[digit.of(*keyed)];
        run[*end] = *keyed;
        *end += 1;
    }
    let mut start = 0;
    for &mut end in ends {
        if end - start > 1 {
            sort(&mut run[start..end], digit.shift, room, by_content);
        }
        start = end;
    }
}

/// Sorts points of equal codes.
fn by_indices(equal: &mut [Keyed], by_content: &(impl Fn(u32, u32) -> Ordering + Sync)) {
    equal.par_sort_unstable_by(|a, b| by_content(a.index, b.index).then(a.index.cmp(&b.index)));
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg64Mcg;

    use super::*;

    /// Codes as they are sorted by comparison.
    fn compared(codes: &[u64], content: impl Fn(u32, u32) -> Ordering + Sync) -> Vec<(u64, u32)> {
        let mut all: Vec<(u64, u32)> = codes.iter().copied().zip(0..).collect();
        all.par_sort_unstable_by(|a, b| a.0.cmp(&b.0).then_with(|| content(a.1, b.1)).then(a.1.cmp(&b.1)));
        all
    }

    fn check(codes: &[u64], name: &str) {
        // A content that ties as well, and one that is the order of the indices.
        let rest = |i: u32| i.wrapping_mul(0x9e37_79b9) >> 28;
        for content in [&|a, b| rest(a).cmp(&rest(b)), &|_, _| Ordering::Equal] as [&(dyn Fn(_, _) -> _ + Sync); 2] {
            let found = sorted(codes.len() as u32, |i| codes[i as usize], &content);
            let found: Vec<_> = found.into_iter().map(|keyed| (keyed.code(), keyed.index)).collect();
            assert!(found == compared(codes, content), "{name}: {} codes", codes.len());
            let are_sorted = are_sorted(codes.len() as u32, |i| codes[i as usize], &content);
            let stay = found.iter().map(|(_, index)| *index).eq(0..codes.len() as u32);
            assert_eq!(are_sorted, stay, "{name}: {} codes", codes.len());
        }
    }

    #[test]
    fn codes_come_in_the_order_of_comparison() {
        let mut rng = Pcg64Mcg::seed_from_u64(7);
        let most = (1u64 << CODE_BITS) - 1;
        for count in [0, 1, 2, FEW, FEW + 1, 1000, 40_000] {
            let mut codes = |code: &mut dyn FnMut(u64) -> u64| -> Vec<u64> {
                (0..count).map(|_| code(rng.random::<u64>() & most)).collect()
            };
            check(&codes(&mut |code| code), "anywhere");
            check(&codes(&mut |code| code & 0x1249_2492_4924_9249), "on a line");
            check(&codes(&mut |code| code % 100), "few");
            check(&codes(&mut |code| code % 3 * (most / 2)), "at ends and middle");
            check(&codes(&mut |_| most), "one");
            check(&codes(&mut |code| if code % 1000 == 0 { most } else { code % 4096 }), "with strays");
            check(&codes(&mut |code| code >> (code % 63)), "of all sizes");
        }
    }

    #[test]
    fn codes_that_ascend_stay_where_they_are_but_for_equal_ones() {
        // Pairs of equal codes, some across the ends of what one thread looks at.
        let mut codes: Vec<u64> = (0..2 * LOOKED_AT as u64 + 99).map(|i| i.div_ceil(2)).collect();
        check(&codes, "pairs");
        // The last of a run of threads, the first and the last of all.
        for misplaced in [LOOKED_AT, 0, codes.len() - 1] {
            let own = std::mem::replace(&mut codes[misplaced], if misplaced == 0 { u64::MAX >> 1 } else { 0 });
            assert!(!are_sorted(codes.len() as u32, |i| codes[i as usize], &|_, _| Ordering::Equal), "{misplaced}");
            check(&codes, "misplaced");
            codes[misplaced] = own;
        }
    }

    #[test]
    fn a_run_of_many_is_cut_on_all_cores() {
        let count = MANY as u64 + 12_345;
        let scattered = |i: u64| i.wrapping_mul(0x9e37_79b9_7f4a_7c15);
        // All but one have equal digits first, and fill others then.
        let near: Vec<u64> = (0..count).map(|i| if i == 77 { 1 << 62 } else { scattered(i) >> 34 }).collect();
        check(&near, "near");
        check(&(0..count).map(|i| scattered(i) >> 62).collect::<Vec<_>>(), "in four places");
    }
}
