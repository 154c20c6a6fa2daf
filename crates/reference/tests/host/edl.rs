//! Eye-dome lighting: its reference by hand, and the scenes that may ask for it.

use pellucid_reference::abuffer::{Fragment, median};
use pellucid_reference::edl::factors;
use pellucid_scene::{METHODS, Method, Scene};

const INF: f64 = f64::INFINITY;

#[test]
fn factors_by_hand() {
    // exp(−300 · s): of a pixel with one neighbor at half its depth, s = 1/8; the edge counts 0.
    let row = factors(&[1.0, 2.0, 2.0, INF, 8.0], [5, 1], 1.0, 1.0);
    assert_eq!([row[0], row[2], row[3], row[4]], [1.0; 4]);
    assert!((row[1] / (-37.5f64).exp() - 1.0).abs() < 1e-12);
    // Eight neighbors at half the depth: s = 1; a radius of 1.4 goes one pixel along diagonals, too.
    let mut hill = vec![1.0; 9];
    hill[4] = 2.0;
    assert!((factors(&hill, [3, 3], 0.01, 1.4)[4] - (-3.0f64).exp()).abs() < 1e-15);
    // Of a radius of 0.3 each neighbor is the pixel itself.
    assert_eq!(factors(&hill, [3, 3], 1.0, 0.3), [1.0; 9]);
    // Two pixels away along the axes, and round(2 · √½) = 1 along diagonals.
    let far: Vec<f64> = (0..25)
        .map(|i| {
            if i == 12 {
                4.0
            } else if [2, 10, 14, 22].contains(&i) {
                1.0
            } else {
                4.0
            }
        })
        .collect();
    assert!((factors(&far, [5, 5], 0.01, 2.0)[12] - (-3.0f64).exp()).abs() < 1e-15);
}

#[test]
fn medians_of_lists_by_hand() {
    let list: Vec<Fragment> = [0.3, 0.0, 0.3, 0.9]
        .iter()
        .zip(1..)
        .map(|(alpha, z)| Fragment { z: f64::from(z), index: 0, alpha: *alpha })
        .collect();
    // T is 0.7, 0.7, 0.49, 0.049.
    for (share, wanted) in [(0.9, 1.0), (0.5, 3.0), (0.48, 4.0), (0.04, INF)] {
        assert_eq!(median(&list, share), wanted, "{share}");
    }
    assert_eq!(median(&[], 0.5), INF);
    assert_eq!(median(&[Fragment { z: 2.0, index: 0, alpha: 1.0 }], 0.5), 2.0);
}

fn read(method: &str) -> Result<Scene, String> {
    let text = format!("[shading]\nedl = true\n[method]\nname = '{method}'\n[[cloud]]\npath = 'a.ply'");
    Scene::from_toml(&text, "s.toml".as_ref()).map_err(|error| error.to_string())
}

#[test]
fn scenes_of_methods_without_one_surface_are_refused() {
    for name in METHODS {
        let takes = Method::all().iter().find(|method| method.name() == *name).is_none_or(Method::takes_edl);
        match read(name) {
            Ok(scene) => assert!(takes && scene.shading.edl.edl, "{name}"),
            Err(error) => {
                assert!(!takes, "{name}: {error}");
                assert!(
                    error.starts_with("s.toml:2:") && error.contains(name) && error.contains("\"circles\""),
                    "{error}"
                );
            }
        }
    }
}
