//! Four splats in small files of other programs.

use glam::{DQuat, Quat, Vec3};
use pellucid_core::cloud::UpAxis;

use super::super::{load, load_bytes};
use super::folder;

#[test]
fn small_files_of_other_programs() {
    let names =
        ["minimal.splat", "minimal.ksplat", "minimal-v2.spz", "minimal-v3.spz", "minimal-v4.spz", "minimal-raw.spz"];
    let clouds = names.map(|name| load(&folder().join("minimal").join(name)).unwrap());
    for (cloud, name) in clouds.iter().zip(names) {
        assert_eq!((cloud.len(), cloud.non_finite, cloud.up), (4, 0, UpAxis::NegativeY), "{name}");
        let gaussians = cloud.gaussians.as_ref().unwrap();
        assert_eq!((gaussians.len(), gaussians.degree), (4, 0), "{name}");
        assert!(gaussians.rotations.iter().all(|rotation| rotation.is_normalized()), "{name}");
        assert!(gaussians.extents.iter().all(|extents| extents.min_element() > 0.0), "{name}");
        assert!(cloud.alphas.iter().flatten().all(|alpha| (0.0..=1.0).contains(alpha)), "{name}");
    }
    // Versions 2 and 3 of SPZ were made of different splats.
    for (a, b) in [(0, 1), (2, 5), (3, 4)] {
        let (a, b, name) = (&clouds[a], &clouds[b], names[b]);
        for i in 0..4 {
            assert!(a.positions[i].distance(b.positions[i]) < 1e-6, "{name}: {:?}", b.positions);
            let (a, b) = (a.gaussians.as_ref().unwrap(), b.gaussians.as_ref().unwrap());
            assert!((a.extents[i] - b.extents[i]).abs().cmple(Vec3::splat(1e-5)).all(), "{name}: {:?}", b.extents);
            // Two roundings to 8 bits in `.splat`, of the whole range 2.
            assert!(a.rotations[i].angle_between(b.rotations[i]) < 0.03, "{name}: {:?}", b.rotations);
            assert!(a.bases[i].distance(b.bases[i]) < 1e-6, "{name}: {:?}", b.bases);
        }
    }
}

/// Rotations of `.splat` files with these quaternions, w first.
fn rotations_of_rows(quaternions: &[[u8; 4]]) -> Vec<Quat> {
    let row = |quaternion: &[u8; 4]| {
        let numbers = [0.0_f32, 0.0, 0.0, 1.0, 1.0, 1.0].map(f32::to_le_bytes);
        [numbers.as_flattened(), &[255; 4], quaternion].concat()
    };
    let file: Vec<u8> = quaternions.iter().flat_map(row).collect();
    load_bytes("a.splat", file).unwrap().gaussians.unwrap().rotations
}

#[test]
fn rotations_of_splat_files_are_bytes_less_128() {
    // 1·128 + 128 is one too many for a byte.
    assert_eq!(rotations_of_rows(&[[255, 128, 128, 128]]), [Quat::IDENTITY]);
    assert_eq!(rotations_of_rows(&[[128, 128, 0, 128]]), [Quat::from_xyzw(0.0, -1.0, 0.0, 0.0)]);
    // Each part is off by half a step of 1/128, or by a step where it is 1.
    let parts = |at: i32| [at % 7 - 3, at % 5 - 2, at % 11 - 5, at % 3 + 1].map(f64::from);
    let exact: Vec<DQuat> = (0..300).map(|at| DQuat::from_array(parts(at)).normalize()).collect();
    let byte = |part: f64| (part * 128.0 + 128.0).round().clamp(0.0, 255.0) as u8;
    let bytes: Vec<_> = exact.iter().map(|q| [q.w, q.x, q.y, q.z].map(byte)).collect();
    for (found, exact) in rotations_of_rows(&bytes).into_iter().zip(exact) {
        let degrees = found.as_dquat().normalize().angle_between(exact).to_degrees();
        assert!(degrees < 0.95, "{found} is {degrees}° from {exact}");
    }
}
