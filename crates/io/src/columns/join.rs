//! Columns that were made in parts.

use bytemuck::Zeroable;
use bytemuck::allocation::zeroed_vec;

use pellucid_core::parallel;

/// Takes a column of each part, and returns their values, one part behind the other, copied on all cores. Each part's
/// is gone once it is copied.
pub(crate) fn taken<P, T: Zeroable + Copy + Send + Sync>(
    parts: &mut [P],
    column: impl Fn(&mut P) -> &mut Vec<T>,
) -> Vec<T> {
    if let [only] = parts {
        return std::mem::take(column(only));
    }
    let parts: Vec<Vec<T>> = parts.iter_mut().map(|part| std::mem::take(column(part))).collect();
    let mut all = zeroed_vec(parts.iter().map(Vec::len).sum());
    let mut rest = all.as_mut_slice();
    let mut copies = Vec::with_capacity(parts.len());
    for part in parts {
        let (own, behind) = rest.split_at_mut(part.len());
        copies.push((part, own));
        rest = behind;
    }
    parallel::for_each_mut(&mut copies, |_, (from, to)| to.copy_from_slice(&std::mem::take(from)));
    all
}

/// Takes a column as [`taken`] does, but one that all parts have if the first one has it.
pub(crate) fn taken_optional<P, T: Zeroable + Copy + Send + Sync>(
    parts: &mut [P],
    column: impl Fn(&mut P) -> &mut Option<Vec<T>>,
) -> Option<Vec<T>> {
    column(parts.first_mut()?).as_ref()?;
    Some(taken(parts, |part| column(part).get_or_insert_default()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_keep_their_order() {
        let mut parts = [vec![1, 2], vec![], vec![3], (4..5000).collect()];
        assert_eq!(taken(&mut parts, |part| part), (1..5000).collect::<Vec<_>>());
        assert_eq!(taken(&mut [vec![7u8]], |part| part), [7]);
        assert!(taken(&mut [], |part: &mut Vec<f32>| part).is_empty());
    }
}
