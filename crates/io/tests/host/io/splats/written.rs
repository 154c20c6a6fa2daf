//! Splats written as a PLY file, and read again.

use glam::Vec3;
use pellucid_core::cloud::Cloud;
use pellucid_core::cloud::gaussians::ColorCoding;
use pellucid_io::ply;

use super::super::{Folder, load};
use super::folder;

fn written(cloud: &Cloud) -> Cloud {
    let folder = Folder::new();
    let path = folder.file("a.ply", "");
    ply::write_prepared(&path, cloud).unwrap();
    load(&path).unwrap()
}

#[test]
fn splats_come_back_to_rounding() {
    for name in ["soup.ply", "soup-v1.spz", "soup-v4.spz", "soup.sog", "soup.gltf", "minimal/minimal.splat"] {
        let cloud = load(&folder().join(name)).unwrap();
        let back = written(&cloud);
        assert_eq!((&back.positions, back.filter, back.up), (&cloud.positions, cloud.filter, cloud.up), "{name}");
        let (own, other) = (back.gaussians.unwrap(), cloud.gaussians.unwrap());
        // Quaternions, harmonics and display values are kept or within some roundings; logarithms of extents reach 10.
        assert_eq!((own.degree, &own.harmonics), (other.degree, &other.harmonics), "{name}");
        for at in 0..other.len() {
            assert!((own.rotations[at] - other.rotations[at]).length() < 3e-7, "{name}");
            assert!(own.bases[at].distance(other.bases[at]) < 3e-7, "{name}");
            assert!((own.extents[at] / other.extents[at] - 1.0).abs().max_element() < 2e-6, "{name}");
        }
        let (own, other) = (back.alphas.unwrap(), cloud.alphas.unwrap());
        assert!(own.iter().zip(&other).all(|(a, b)| (a - b).abs() < 3e-7), "{name}");
    }
}

#[test]
fn linear_colors_stay_linear() {
    let mut cloud = load(&folder().join("soup.gltf")).unwrap();
    let count = cloud.len();
    for coding in [ColorCoding::Linear, ColorCoding::Each((0..count).map(|at| at % 3 == 0).collect())] {
        let gaussians = cloud.gaussians.as_mut().unwrap();
        gaussians.coding = coding;
        cloud.colors = Some((0..count).map(|at| gaussians.linear_base(at)).collect());
        let back = written(&cloud);
        let (own, other) = (back.gaussians.as_ref().unwrap(), cloud.gaussians.as_ref().unwrap());
        assert_eq!((&own.coding, &own.harmonics), (&other.coding, &other.harmonics));
        let colors = back.colors.iter().flatten().zip(cloud.colors.iter().flatten());
        assert!(colors.clone().count() == count && colors.into_iter().all(|(a, b)| a.distance(*b) < 1e-6));
        assert!(back.scalars.is_empty(), "{:?}", back.scalars);
    }
}

#[test]
fn extremes_and_other_columns_stay() {
    let mut cloud = load(&folder().join("minimal/minimal.splat")).unwrap();
    cloud.alphas = Some(vec![0.0, 1.0, 0.25, 1.0 - f32::EPSILON]);
    cloud.classification = Some(vec![1, 2, 3, 255]);
    cloud.scalars = vec![("time stamp".to_owned(), vec![0.5, -1.0, 3.0, 4.0])];
    cloud.positions[0].x = 0.1;
    if let Some(gaussians) = &mut cloud.gaussians {
        gaussians.extents = vec![Vec3::new(1.0, 2.0, 0.0); 4];
        gaussians.bases[1] = Vec3::new(-3.0, 17.0, 0.5);
    }
    let back = written(&cloud);
    assert_eq!((&back.positions, &back.classification), (&cloud.positions, &cloud.classification));
    assert_eq!(back.scalars, [("time_stamp".to_owned(), vec![0.5, -1.0, 3.0, 4.0])]);
    let alphas = back.alphas.unwrap();
    assert_eq!((alphas[0], alphas[1], alphas[2]), (0.0, 1.0, 0.25));
    assert!((alphas[3] - 1.0).abs() < 3e-7);
    let gaussians = back.gaussians.unwrap();
    assert!(gaussians.extents.iter().all(|extents| extents.z == 0.0 && (extents.y - 2.0).abs() < 1e-6));
    assert!(gaussians.bases[1].distance(Vec3::new(-3.0, 17.0, 0.5)) < 1e-5);
}
