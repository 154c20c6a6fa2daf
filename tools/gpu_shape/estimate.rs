//! Roofline estimates: the time of a pass on a GPU that is not there, from the bytes it must move, the compiler's count
//! of cycles, and the latency of one wave.

use pellucid_engine::methods::PassProfile;

use crate::compile::Shape;

/// A GPU, by its maker's figures.
pub struct Gpu {
    pub name: &'static str,
    /// RADV's name of the compiler's target, the older first: Mesa renamed some.
    pub families: &'static [&'static str],
    /// SIMDs: two for each compute unit.
    pub simds: f64,
    /// Clock in GHz under load.
    pub clock: f64,
    /// Memory bandwidth in GB/s.
    pub bandwidth: f64,
}

/// A portable one, one for a desk, a large one.
pub const GPUS: [Gpu; 3] = [
    Gpu { name: "Steam Deck", families: &["vangogh"], simds: 16.0, clock: 1.6, bandwidth: 88.0 },
    Gpu { name: "Radeon RX 6800", families: &["navi21"], simds: 120.0, clock: 2.1, bandwidth: 512.0 },
    Gpu { name: "Radeon RX 7900 XTX", families: &["gfx1100", "navi31"], simds: 192.0, clock: 2.5, bandwidth: 960.0 },
];

/// Limiting resource of a pass.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Bound {
    Memory,
    Arithmetic,
    /// Too few waves to hide what one waits for.
    Latency,
}

/// An estimate.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimate {
    pub us: f64,
    pub bound: Bound,
}

/// Invocations of a workgroup of one subgroup where the pass was recorded, and on the GPU.
pub type Lanes = [f64; 2];

/// The largest of the three times. `lanes` for passes whose workgroup is one subgroup: they keep their number of
/// workgroups.
pub fn estimate(gpu: &Gpu, pass: &PassProfile, shape: &Shape, lanes: Option<Lanes>) -> Option<Estimate> {
    let invocations = pass.invocations? as f64 * lanes.map_or(1.0, |[here, there]| there / here);
    let cycles = 1e3 * gpu.clock;
    let memory = pass.bytes.map_or(0.0, |bytes| bytes as f64 / gpu.bandwidth / 1e3);
    let arithmetic = invocations / 64.0 * shape.inverse_throughput / gpu.simds / cycles;
    let latency = shape.latency / cycles;
    let all = [(memory, Bound::Memory), (arithmetic, Bound::Arithmetic), (latency, Bound::Latency)];
    let (us, bound) =
        all.into_iter().fold((0.0, Bound::Memory), |most, each| if each.0 > most.0 { each } else { most });
    Some(Estimate { us, bound })
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::Duration;

    #[test]
    fn by_hand() {
        let gpu = Gpu { name: "", families: &[], simds: 100.0, clock: 2.0, bandwidth: 500.0 };
        let shape = Shape {
            lanes: 32,
            vgprs: 0.0,
            sgprs: 0.0,
            spilled_vgprs: 0.0,
            spilled_sgprs: 0.0,
            scratch_bytes: 0.0,
            lds_bytes: 0.0,
            waves: 16.0,
            code_bytes: 0.0,
            latency: 10_000.0,
            inverse_throughput: 1000.0,
            compile_ms: 0.0,
        };
        let pass = |invocations, bytes| PassProfile { name: "", gpu: Duration::ZERO, invocations, bytes };
        let of = |pass: &PassProfile, lanes| estimate(&gpu, pass, &shape, lanes).map(|e| (e.us, e.bound));
        // 5 µs for one wave; 6.4 M invocations are 100 000 waves of 64, 1000 for each SIMD, of half a microsecond.
        assert_eq!(of(&pass(Some(64), None), None), Some((5.0, Bound::Latency)));
        assert_eq!(of(&pass(Some(6_400_000), None), None), Some((500.0, Bound::Arithmetic)));
        assert_eq!(of(&pass(Some(1_600_000), None), Some([8.0, 32.0])), Some((500.0, Bound::Arithmetic)));
        assert_eq!(of(&pass(Some(64), Some(500_000_000)), None), Some((1000.0, Bound::Memory)));
        assert_eq!(of(&pass(None, Some(1)), None), None);
    }
}
