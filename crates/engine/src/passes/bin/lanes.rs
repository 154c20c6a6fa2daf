//! The invocations of the stages that go through tiles.

use crate::gpu::Device;
use crate::gpu::shader::{Choices, SUBGROUPS};
use crate::passes::Error;

/// Subgroups of a workgroup where a device prefers several.
const TEAM: u32 = 4;

/// How the invocations of a workgroup are divided that goes through tiles.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Lanes {
    /// Invocations of a subgroup, which has a tile or a block of a tile to itself.
    pub subgroup: u32,
    /// Subgroups of a workgroup: a GPU holds too few workgroups for one each, a CPU has nothing of more.
    pub team: u32,
}

impl Lanes {
    /// Those of a device.
    pub(super) fn of(device: &Device) -> Result<Self, Error> {
        let info = device.info();
        let subgroup = info.subgroup.ok_or_else(|| Error::NoSubgroups { device: info.name.clone() })?;
        Ok(Self { subgroup, team: if info.prefers.shared_work { TEAM } else { 1 } })
    }

    /// Workgroups of so many subgroups.
    pub(super) fn groups(self, subgroups: u64) -> u64 {
        subgroups.div_ceil(self.team.into())
    }
}

impl Choices for Lanes {
    fn all() -> Vec<Self> {
        [1, TEAM].into_iter().flat_map(|team| SUBGROUPS.map(|subgroup| Self { subgroup, team })).collect()
    }
}
