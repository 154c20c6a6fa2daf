//! The invocations of the stages that go through tiles.

use crate::choices::Choices;
use crate::gpu::Device;
use crate::gpu::shader::SUBGROUPS;
use crate::passes::Error;

/// Splats of a tile that one run takes, at five iterations each. Runs are composed by themselves and then joined, so
/// that the smallest opacities don't round away in a sum of millions.
pub(super) const SEGMENT: u32 = 2048;
/// Returns the same for stages that go through tiles region by region, whose workgroups note that many: wide ones may
/// not take the room of others.
pub(super) const fn region_segment(subgroup: u32) -> u32 {
    if subgroup < 16 { SEGMENT } else { SEGMENT / 2 }
}
/// Subgroups of a workgroup where a device prefers several.
const TEAM: u32 = 4;

/// Division of the invocations of a workgroup that goes through tiles.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Lanes {
    /// Invocations of a subgroup, which has a tile or a block of a tile to itself.
    pub subgroup: u32,
    /// Subgroups of a workgroup: a GPU holds too few workgroups for one each, a CPU has nothing of more.
    pub team: u32,
}

impl Lanes {
    /// Returns those of a device.
    pub(super) fn of(device: &Device) -> Result<Self, Error> {
        let info = device.info();
        let subgroup = info.subgroup.ok_or_else(|| Error::NoSubgroups { device: info.name.clone() })?;
        let fits = picked_bytes(subgroup, TEAM) <= device.limits().shared_bytes;
        Ok(Self { subgroup, team: if info.prefers.shared_work && fits { TEAM } else { 1 } })
    }

    /// Returns the number of workgroups of so many subgroups.
    pub(super) fn groups(self, subgroups: u64) -> u64 {
        subgroups.div_ceil(self.team.into())
    }
}

/// Bytes of a workgroup's memory that stages take which go through tiles region by region.
const fn picked_bytes(subgroup: u32, team: u32) -> u32 {
    region_segment(subgroup) * team * 4
}

// Every device has 16 KiB.
const _: () = assert!(picked_bytes(4, 1) <= 16 << 10);

impl Choices for Lanes {
    fn all() -> Vec<Self> {
        [1, TEAM].into_iter().flat_map(|team| SUBGROUPS.map(|subgroup| Self { subgroup, team })).collect()
    }
}
