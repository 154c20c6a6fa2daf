//! Which methods a device can run.

use crate::gpu::DeviceInfo;

/// Methods that go through tiles of splats, besides the soft ones where there are solid points: they need subgroups of 8 to 32
/// invocations, of a size that is known beforehand, with ballots and shuffles.
pub const TILE_METHODS: &[&str] =
    &["sorted", "stochastic", "hybrid", "weighted", "average", "unsorted", "hqs", "splats", "one-layer"];

/// What a device lacks for some methods, and which these are; `None` if it runs all of them.
pub fn lacks_for_methods(device: &DeviceInfo) -> Option<String> {
    without(device.subgroup, device.multisampled.is_some())
}

fn without(subgroup: Option<u32>, multisampled: bool) -> Option<String> {
    if subgroup.is_some() {
        return None;
    }
    // `stochastic` leaves its samples to the rasteriser where it can.
    let is_lacking = |name: &&str| !(multisampled && *name == "stochastic");
    let names: Vec<&str> = TILE_METHODS.iter().copied().filter(is_lacking).collect();
    let names = names.join(", ");
    Some(format!("subgroups of 8 to 32 invocations with shuffles for {names}, and solid points of the soft methods"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::methods::Error;
    use crate::scene::METHODS;

    #[test]
    fn methods_that_a_device_lacks_are_named() {
        assert!(TILE_METHODS.iter().all(|name| METHODS.contains(name)));
        assert_eq!((without(Some(8), true), without(Some(32), false)), (None, None));
        let [some, all] = [true, false].map(|multisampled| without(None, multisampled).unwrap());
        assert!(TILE_METHODS.iter().all(|name| all.contains(name)), "{all}");
        assert!(some.contains("sorted") && !some.contains("stochastic"), "{some}");
        let error = Error::NoSubgroups { device: "a device".to_owned() }.to_string();
        assert!(TILE_METHODS.iter().all(|name| error.contains(name)) && error.contains("a device"), "{error}");
    }
}
