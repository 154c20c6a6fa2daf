//! Normals that are estimated for shading: which scenes ask for some, and which points get one.

use glam::{DVec3, Vec3};
use pellucid_core::cloud::Cloud;
use pellucid_core::points::Points;
use pellucid_core::progress::Progress;
use pellucid_scene::prepare::ShadingNormals;
use pellucid_scene::{Scene, assemble};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

/// 2000 points of the plane z = 0, then 2000 in a ball far above.
fn ground_and_foliage() -> Cloud {
    let mut rng = Pcg64Mcg::seed_from_u64(5);
    let mut ground: Vec<_> = (0..2000).map(|_| DVec3::new(rng.random(), rng.random(), 0.0) * 10.0).collect();
    ground.extend((0..2000).map(|_| {
        let p = || DVec3::ZERO;
        let mut at = p() + DVec3::splat(2.0);
        while at.length() > 1.0 {
            at = DVec3::new(rng.random(), rng.random(), rng.random()) * 2.0 - 1.0;
        }
        at + DVec3::Z * 20.0
    }));
    Cloud { positions: ground, ..Cloud::default() }
}

fn scene_of(keys: &str) -> Scene {
    let text = format!("[[cloud]]\npath = 'a.ply'\n{keys}");
    Scene::from_toml(&text, "s.toml".as_ref()).unwrap_or_else(|error| panic!("{text}: {error}"))
}

fn points(keys: &str, cloud: Cloud) -> Points {
    assemble(&scene_of(keys), vec![cloud], true, &Progress::hidden()).unwrap()
}

/// The shares of ground and foliage that have a normal.
fn shares(points: &Points) -> [f64; 2] {
    let mut counts = [0.0; 2];
    for (position, normal) in points.positions.iter().zip(points.normals.iter().flatten()) {
        counts[usize::from(position.z > 10.0)] += f64::from(u8::from(*normal != Vec3::ZERO));
    }
    counts.map(|count| count / 2000.0)
}

#[test]
fn scenes_ask_for_the_normals_that_they_use() {
    let wanted = |keys: &str| scene_of(keys).shading_normals();
    assert_eq!(wanted(""), Some(ShadingNormals::Planar), "auto is the default");
    assert_eq!(wanted("[shading]\nmodel = 'auto'"), Some(ShadingNormals::Planar));
    assert_eq!(wanted("[shading]\nmodel = 'lambert'"), Some(ShadingNormals::All));
    assert_eq!(wanted("[shading]\nmodel = 'phong'"), Some(ShadingNormals::All));
    assert_eq!(wanted("[shading]\nmodel = 'none'"), None);
    let spbr = |cos: bool| format!("[method]\nname = 'spbr'\ncos_theta = {cos}\n[shading]\nmodel = 'none'");
    assert_eq!([wanted(&spbr(true)), wanted(&spbr(false))], [None, Some(ShadingNormals::All)]);
}

#[test]
fn auto_shades_ground_and_leaves_foliage_as_it_is() {
    assert_eq!(points("[shading]\nmodel = 'none'", ground_and_foliage()).normals, None);
    let [ground, foliage] = shares(&points("", ground_and_foliage()));
    assert!(ground == 1.0 && foliage < 0.15, "{ground} {foliage}");
    assert_eq!(shares(&points("[shading]\nmodel = 'lambert'", ground_and_foliage())), [1.0, 1.0]);
}

#[test]
fn normals_of_the_file_stay_and_count_for_geometry_alone() {
    let mut cloud = ground_and_foliage();
    let mut normals = vec![Vec3::ZERO; cloud.len()];
    normals[3] = Vec3::X;
    let kept = cloud.positions[3];
    cloud.normals = Some(normals);
    let found = points("[shading]\nmodel = 'lambert'", cloud.clone());
    for (i, normal) in found.normals.iter().flatten().enumerate() {
        if found.positions[i] == kept {
            assert_eq!((*normal, found.own_normal(i)), (Vec3::X, Some(Vec3::X)));
        } else {
            assert!((normal.length() - 2.0).abs() < 1e-6, "estimated: {normal}");
            assert_eq!(found.own_normal(i), None);
        }
    }
    // A cloud whose normals are complete is looked at no further.
    cloud.normals = Some(vec![Vec3::Y; cloud.len()]);
    let found = points("", cloud);
    assert!(found.normals.iter().flatten().all(|normal| *normal == Vec3::Y));
}
