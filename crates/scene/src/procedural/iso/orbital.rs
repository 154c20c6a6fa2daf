//! The volume of `iso` where no file is given: where the electron of a hydrogen atom is found in its state 3d (m = 0).

use pellucid_io::volume::Volume;

/// Numbers along each side.
const SIDE: usize = 64;
/// Distance from the middle to each side, in Bohr radii: density there is at most a ninetieth of the greatest.
const REACH: f64 = 20.0;

/// Returns the density |ψ₃₂₀|² around the y axis, which is upward in the picture, over its greatest value: (3y² − r²)²
/// e^(−2r/3) with r in Bohr radii. Two lobes along the axis and a ring around it; none at 54.7° to the axis.
pub(super) fn orbital() -> Volume {
    let at = |i: usize| REACH * (2.0 * i as f64 / (SIDE - 1) as f64 - 1.0);
    let density = |i: usize| {
        let [x, y, z] = [i % SIDE, i / SIDE % SIDE, i / (SIDE * SIDE)].map(at);
        let square = x * x + y * y + z * z;
        (3.0 * y * y - square).powi(2) * (-2.0 / 3.0 * square.sqrt()).exp()
    };
    // On the axis 4 r⁴ e^(−2r/3), which is greatest at r = 6.
    let greatest = 4.0 * 6f64.powi(4) * (-4f64).exp();
    Volume { dims: [SIDE; 3], values: (0..SIDE.pow(3)).map(|i| (density(i) / greatest) as f32).collect() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lobes_a_ring_and_cones_without_density() {
        let volume = orbital();
        let at = |x: usize, y: usize, z: usize| volume.values[x + SIDE * (y + SIDE * z)];
        // Diagonals of the cube are at 54.7° to the axis.
        assert!((0..SIDE).all(|i| at(i, i, i) < 1e-12 && at(i, SIDE - 1 - i, i) < 1e-12));
        // The density is flat around its maximum at 6 Bohr radii, which is within half a step of a number.
        let along: Vec<f32> = (SIDE / 2..SIDE).map(|y| at(SIDE / 2, y, SIDE / 2)).collect();
        let (peak, greatest) = along.iter().copied().enumerate().max_by(|a, b| a.1.total_cmp(&b.1)).expect("numbers");
        assert!((0.98..=1.0).contains(&greatest), "{greatest}");
        assert!(volume.values.iter().all(|value| *value <= greatest + 1e-6));
        // Half a step from the middle, then steps of 40/63.
        assert!(((peak as f64 + 0.5) * 40.0 / 63.0 - 6.0).abs() < 0.65, "{peak}");
        // As far from the middle, a quarter of it in the ring.
        let ring = at(SIDE / 2 + peak, SIDE / 2, SIDE / 2) / greatest;
        assert!((ring - 0.25).abs() < 0.02, "{ring}");
        let rim = (0..SIDE).flat_map(|a| (0..SIDE).flat_map(move |b| [[0, a, b], [a, 0, b], [a, b, 0]]));
        assert!(rim.into_iter().all(|[x, y, z]| at(x, y, z) < 1.0 / 90.0));
    }
}
