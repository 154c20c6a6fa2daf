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

    /// Splits a number of groups over x and y, since x alone is limited.
    fn fold_groups(&self, name: &str, groups: u64) -> Result<[u32; 2], Error> {
        let limit = u64::from(self.context.limits.groups_x);
        let x = groups.clamp(1, limit);
        let y = groups.div_ceil(x).max(1);
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
