//! Four splats in small files of other programs.

use glam::Vec3;
use pellucid_core::cloud::UpAxis;

use super::super::load;
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
