//! Columns that were made in parts.

use bytemuck::Zeroable;
use bytemuck::allocation::zeroed_vec;
use rayon::prelude::*;

/// Returns the values of all parts of a column, one part behind the other, copied on all cores. Each part is gone once
/// it is copied.
pub(crate) fn joined<T: Zeroable + Copy + Send + Sync>(mut parts: Vec<Vec<T>>) -> Vec<T> {
    if parts.len() == 1 {
        return parts.pop().unwrap_or_default();
    }
    let mut all = zeroed_vec(parts.iter().map(Vec::len).sum());
    let mut rest = all.as_mut_slice();
    let mut copies = Vec::with_capacity(parts.len());
    for part in parts {
        let (own, behind) = rest.split_at_mut(part.len());
        copies.push((part, own));
        rest = behind;
    }
    copies.into_par_iter().for_each(|(from, to)| to.copy_from_slice(&from));
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_keep_their_order() {
        let parts = vec![vec![1, 2], vec![], vec![3], (4..5000).collect()];
        assert_eq!(joined(parts), (1..5000).collect::<Vec<_>>());
        assert_eq!(joined(vec![vec![7u8]]), [7]);
        assert!(joined::<f32>(vec![]).is_empty());
    }
}
