//! The size of a dispatch, split over the numbers of workgroups that a device allows.

use super::Recorder;
use crate::shader::WORKGROUP;
use crate::{Error, Slice};

/// Amount that a compute pass runs.
#[derive(Debug, Clone, Copy)]
pub enum Dispatch<'a> {
    /// Invocations, at least this many, numbered by `invocation_index` in WGSL.
    Invocations(u64),
    /// Workgroups, exactly this many, numbered by `workgroup_index` in WGSL.
    Groups(u64),
    /// Workgroups x, y, z from a buffer (its first three elements).
    Indirect(Slice<'a, u32>),
}

impl Recorder<'_> {
    /// Indirect arguments that stand for a dispatch, and a fourth word. `name` says in errors what is dispatched.
    pub fn arguments(&self, name: &str, dispatch: Dispatch<'_>) -> Result<[u32; 4], Error> {
        let [x, y] = self.groups(name, dispatch)?;
        Ok([x, y, 1, 0])
    }

    /// Returns workgroups in x and y; none of an indirect dispatch.
    pub(super) fn groups(&self, name: &str, dispatch: Dispatch<'_>) -> Result<[u32; 2], Error> {
        match dispatch {
            Dispatch::Invocations(n) => {
                let [x, y] = self.fold_groups(name, n.div_ceil(u64::from(WORKGROUP)))?;
                // Folding rounds up; a shader's number of an invocation must not come round to 0.
                let (numbered, limit) = (u64::from(x) * u64::from(y) * u64::from(WORKGROUP), 1 << 32);
                if numbered > limit {
                    let (name, limit_name) = (name.to_owned(), "invocations of a dispatch");
                    return Err(Error::TooLarge { name, bytes: numbered, limit, limit_name });
                }
                Ok([x, y])
            }
            Dispatch::Groups(n) => self.fold_groups(name, n),
            Dispatch::Indirect(_) => Ok([0; 2]),
        }
    }

    fn fold_groups(&self, name: &str, groups: u64) -> Result<[u32; 2], Error> {
        let limit = u64::from(self.context.limits.groups_x);
        let [x, y] = folded(groups, limit);
        if y > limit.min(65_535) {
            return Err(Error::TooLarge {
                name: name.to_owned(),
                bytes: groups,
                limit: limit * 65_535,
                limit_name: "workgroups of a dispatch",
            });
        }
        Ok([x as u32, y as u32])
    }
}

/// Splits a number of groups over x, of which so many are allowed, and y. Fewer groups than there are in y have nothing
/// to do: a CPU driver gives each core as many groups as any other, those at the end to the last one.
fn folded(groups: u64, limit: u64) -> [u64; 2] {
    let y = groups.div_ceil(limit).max(1);
    [groups.div_ceil(y).max(1), y]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fewer_groups_than_rows_are_idle() {
        for groups in [0, 1, 7, 65_535, 65_536, 65_537, 131_070, 131_071, 4_000_000, 65_535 * 65_535] {
            let [x, y] = folded(groups, 65_535);
            assert!([x, y].into_iter().all(|side| (1..=65_535).contains(&side)), "{groups}");
            assert!(x * y >= groups && x * y < groups.max(1) + y, "{groups}: {x} x {y}");
        }
        assert_eq!([folded(1000, 65_535), folded(65_536, 65_535)], [[1000, 1], [32_768, 2]]);
    }
}
