//! `scene iso`: a volume becomes a scene, or is refused with a reason.

use std::fs;

use pellucid_io as io;

use crate::{assert_refused, folder, inside, run};

#[test]
fn a_volume_becomes_a_scene_that_can_be_planned() {
    let folder = folder();
    // Distances from the middle of 9 × 9 × 9 numbers, squared.
    let at = |i: u16| [i % 9, i / 9 % 9, i / 81].map(|v| (i32::from(v) - 4).pow(2)).iter().sum::<i32>();
    let bytes: Vec<u8> = (0..729).flat_map(|i| (at(i) as u16).to_le_bytes()).collect();
    fs::write(inside(&folder, "ball_9x9x9_uint16.raw"), &bytes).unwrap();
    fs::write(inside(&folder, "ball.raw"), &bytes).unwrap();
    let named = ["scene", "iso", "--volume", "ball_9x9x9_uint16.raw", "--values", "4.5,10.5", "--set", "points=500"];
    assert_eq!(run(&folder, &[&named[..], &["-o", "a"]].concat()), (0, String::new(), String::new()));
    let told = ["scene", "iso", "--volume", "ball.raw", "--dims", "9x9x9", "--type", "uint16", "--values", "10.5,4.5"];
    assert_eq!(run(&folder, &[&told[..], &["--set", "points=500", "-o", "b"]].concat()).0, 0);
    for name in ["scene.toml", "surface-1.ply", "surface-2.ply"] {
        let [a, b] = ["a", "b"].map(|of| fs::read(inside(&folder, &format!("{of}/{name}"))).unwrap());
        assert!(a == b, "{name}");
    }
    let load = |name: &str| io::load(&inside(&folder, name), &pellucid_core::progress::Progress::hidden()).unwrap();
    let [outer, inner] = ["a/surface-1.ply", "a/surface-2.ply"].map(load);
    assert!(outer.len() + inner.len() == 500 && outer.len() > inner.len());
    // From −1 to 1 over eight cells. Between the numbers the interpolant of each square is too large by up to ¼: the
    // surface lies where the squared distance is up to ¾ below the value.
    for (cloud, value) in [(outer, 10.5), (inner, 4.5)] {
        let squares = cloud.positions.iter().map(|p| 16.0 * p.length_squared());
        assert!(squares.into_iter().all(|square| (value - 0.7501..value + 1e-4).contains(&square)));
    }
    let (code, plan, _) = run(&folder, &["plan", "a/scene.toml", "-q"]);
    assert!(code == 0 && plan.contains("on "), "{plan}");
}

#[test]
fn without_a_volume_there_are_surfaces_of_an_orbital() {
    let folder = folder();
    assert_eq!(run(&folder, &["scene", "iso", "--set", "points=3000", "-o", "a"]), (0, String::new(), String::new()));
    let load = |name: &str| io::load(&inside(&folder, name), &pellucid_core::progress::Progress::hidden()).unwrap();
    let surfaces = ["a/surface-1.ply", "a/surface-2.ply", "a/surface-3.ply"].map(load);
    assert_eq!(surfaces.iter().map(|cloud| cloud.len()).sum::<usize>(), 3000);
    // Density is equal above and below the nucleus, and none where lobes and ring would meet.
    for cloud in &surfaces {
        let above = cloud.positions.iter().filter(|p| p.y > 0.0).count();
        // Five standard deviations of a fair coin.
        let spread = 2.5 * (cloud.len() as f64).sqrt();
        assert!((above as f64 - cloud.len() as f64 / 2.0).abs() < spread, "{above} of {}", cloud.len());
        assert!(cloud.positions.iter().all(|p| (p.y.abs() / p.length() - 1.0 / 3f64.sqrt()).abs() > 0.01));
    }
    assert_eq!(run(&folder, &["plan", "a/scene.toml", "-q"]).0, 0);
}

#[test]
fn wrong_volumes_are_refused() {
    let folder = folder();
    fs::write(inside(&folder, "a_2x2x2_uint8.raw"), [1; 9]).unwrap();
    fs::write(inside(&folder, "b_2x2x2_uint8.raw"), [1; 8]).unwrap();
    let refused = |args: &[&str], status: i32, parts: &[&str]| {
        assert_refused(&folder, &[&["scene", "iso", "-o", "new"][..], args].concat(), status, parts);
    };
    refused(&["--volume", "a_2x2x2_uint8.raw"], 1, &["a_2x2x2_uint8.raw", "8 bytes", "has 9", "--dims"]);
    refused(&["--volume", "none_2x2x2_uint8.raw"], 1, &["none_2x2x2_uint8.raw", "no such file"]);
    refused(&["--volume", "b_2x2x2_uint8.raw"], 2, &["no surface", "1"]);
    refused(&["--volume", "b_2x2x2_uint8.raw", "--values", "3"], 2, &["value 3", "from 1 to 1"]);
    refused(&["--volume", "b_2x2x2_uint8.raw", "--dims", "2x2"], 2, &["2x2", "64x64x64"]);
    refused(&["--volume", "b_2x2x2_uint8.raw", "--type", "float16"], 2, &["float16", "float32"]);
    refused(&["--volume", "b_2x2x2_uint8.raw", "--set", "layers=3"], 2, &["layers", "surfaces"]);
    // The built-in volume goes from 0 to 1.
    refused(&["--values", "2"], 2, &["value 2", "from 0"]);
    refused(&["--dims", "2x2x2"], 2, &["--volume"]);
    assert_refused(&folder, &["scene", "tori", "-o", "new", "--volume", "b_2x2x2_uint8.raw"], 2, &["belong to", "iso"]);
    assert_refused(&folder, &["scene", "tori", "-o", "new", "--values", "1"], 2, &["belong to", "iso"]);
    let (code, list, _) = run(&folder, &["scene", "--list"]);
    assert!(code == 0 && list.lines().any(|line| line.starts_with("iso ") && line.contains("points=")), "{list}");
}
