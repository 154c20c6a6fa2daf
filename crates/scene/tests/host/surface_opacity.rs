//! `surface_opacity` against float64 and brute force.

use glam::DVec3;
use pellucid_core::cloud::Cloud;
use pellucid_core::points::Points;
use pellucid_core::progress::Progress;
use pellucid_reference as reference;
use pellucid_scene::{Overrides, Scene, assemble};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

fn cloud() -> Cloud {
    let mut rng = Pcg64Mcg::seed_from_u64(9);
    let mut positions: Vec<_> =
        (0..300).map(|_| DVec3::new(rng.random(), rng.random(), rng.random::<f64>() * 0.01)).collect();
    // An outlier, whose radius is capped, and six points in one place, more than K.
    positions.push(DVec3::new(9.0, 9.0, 9.0));
    positions.extend([DVec3::new(-1.0, 0.0, 0.0); 6]);
    Cloud { positions, ..Cloud::default() }
}

fn points(keys: &str, cloud: Cloud) -> Points {
    let text = format!("[[cloud]]\npath = 'a.ply'\nneighbors = 5\n{keys}");
    let scene = Scene::from_toml(&text, "s.toml".as_ref()).unwrap_or_else(|error| panic!("{text}: {error}"));
    assemble(&scene, vec![cloud], true, &Progress::hidden()).unwrap()
}

#[test]
fn discs_are_as_faint_as_their_overlap_asks_for() {
    let positions = cloud().positions;
    let surface = reference::field::surface(&positions, &vec![DVec3::ZERO; positions.len()], 5, 4.0);
    for (keys, factor) in
        [("", 1.0), ("radius_factor = 2.5", 2.5), ("radius_factor = 0.25", 0.25), ("scale = 1000", 1.0)]
    {
        for a in [0.01f64, 0.5, 0.99] {
            let found = points(&format!("surface_opacity = {a}\n{keys}"), cloud());
            let scale = if keys.starts_with("scale") { 1000.0 } else { 1.0 };
            for (position, alpha) in found.positions.iter().zip(&found.opacities) {
                let near = |p: &DVec3| (*p * scale).distance(*position) < 1e-9 * scale;
                let i = positions.iter().position(near).unwrap();
                // n = K r² / d², d the distance of the K-th neighbor.
                let n = match surface.uncapped[i] {
                    0.0 => 6.0,
                    own => (4.0 * (factor * surface.radii[i] / own).powi(2)).max(1.0),
                };
                let wanted = 1.0 - (1.0 - a).powf(1.0 / n);
                assert!((f64::from(*alpha) - wanted).abs() < 1e-6, "{keys}, {a}, point {i}: {alpha}, not {wanted}");
            }
        }
    }
    // Own radii are measured by the neighbors, too.
    let own = points("surface_opacity = 0.5\nradius = 1e-5", cloud());
    assert!(own.opacities.iter().filter(|a| **a == 0.5).count() >= 300, "small discs don't overlap");
}

#[test]
fn methods_without_discs_take_it_for_their_opacity() {
    let found = points("surface_opacity = 0.25\n[method]\nname = 'spbr'", cloud());
    assert!(found.opacities.iter().all(|a| *a == 0.25));
}

#[test]
fn it_stands_in_place_of_opacity() {
    let scene = |text: &str, overrides: &Overrides| Scene::from_toml_with(text, "s.toml".as_ref(), overrides);
    let both = "[[cloud]]\npath = 'a.ply'\nopacity = 0.5\nsurface_opacity = 0.5";
    let error = scene(both, &Overrides::default()).unwrap_err().to_string();
    assert!(error.contains("s.toml:4") && error.contains("keep one"), "{error}");
    // An option wins over the file's key, either way round, of one cloud or of all.
    let one = "[[cloud]]\npath = 'a.ply'\nopacity = 0.5\n[[cloud]]\npath = 'b.ply'\nopacity = 0.25";
    let mut overrides = Overrides::default();
    overrides.set("--surface-opacity 0.3", "cloud.*.surface_opacity", "0.3").unwrap();
    let found = scene(one, &overrides).unwrap().clouds;
    assert!(found.iter().all(|cloud| cloud.surface_opacity == Some(0.3) && cloud.opacity == 1.0));
    let mut overrides = Overrides::default();
    overrides.set_pair("cloud.1.surface_opacity=0.3").unwrap();
    let found = scene(one, &overrides).unwrap().clouds;
    assert_eq!([found[0].surface_opacity, found[1].surface_opacity], [None, Some(0.3)]);
    assert_eq!([found[0].opacity, found[1].opacity], [0.5, 1.0]);
}
