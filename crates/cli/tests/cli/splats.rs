//! Gaussian splats on the command line: described, and written as PLY files.

use pellucid_core::progress::Progress;
use pellucid_io as io;
use serde_json::{Value, json};

use crate::{folder, inside, run};

/// A small file of splats.
fn splats(name: &str) -> String {
    pellucid_testing::root().join("tests/data/splats").join(name).display().to_string()
}

#[test]
fn info_describes_splats() {
    let folder = folder();
    let (code, text, errors) = run(&folder, &["info", &splats("soup.ply")]);
    assert_eq!((code, errors.as_str()), (0, ""), "{text}");
    for part in [
        "\n  points      40\n",
        "\n  attributes  color, alpha 0.1",
        "\n  gaussians   40, harmonics of degree 2, trained with filter mip\n",
        "\n  extents     0.00",
        "\n              (Gaussian splats have opacities of their own)\n",
    ] {
        assert!(text.contains(part), "{part:?}: {text}");
    }
    // The folder of a description is one of splats.
    let (code, text, errors) = run(&folder, &["info", "--json", &splats("soup-folder")]);
    assert_eq!((code, errors.as_str()), (0, ""), "{text}");
    let value: Value = serde_json::from_str(&text).unwrap();
    let gaussians = &value["gaussians"];
    assert_eq!(
        (&gaussians["count"], &gaussians["degree"], &gaussians["filter"]),
        (&json!(40), &json!(2), &Value::Null)
    );
    let extent = |name: &str| gaussians["extents"][name].as_f64().unwrap();
    // Logarithms from −5 to −1.
    assert!(extent("min") > 0.006 && extent("min") < extent("median") && extent("max") < 0.37, "{text}");
}

#[test]
fn prepare_writes_splats_as_ply() {
    let folder = folder();
    let (code, _, errors) = run(&folder, &["prepare", &splats("soup-v4.spz"), "-o", "out.ply", "--neighbors", "7"]);
    assert_eq!(code, 0, "{errors}");
    assert!(errors.contains("Gaussian splats are written as they are, without radii, field and normals"), "{errors}");
    let load = |path: &std::path::Path| io::load(path, &Progress::hidden()).unwrap();
    let (back, cloud) = (load(&inside(&folder, "out.ply")), load(splats("soup-v4.spz").as_ref()));
    assert_eq!((&back.positions, back.radii, back.prepared), (&cloud.positions, None, None));
    assert_eq!(back.gaussians.unwrap().harmonics, cloud.gaussians.unwrap().harmonics);
}

#[test]
fn a_store_of_splats_has_their_picture() {
    let folder = folder();
    let soup = splats("soup.sog");
    let (code, _, errors) =
        run(&folder, &["prepare", &soup, "-o", "store", "--node-points", "100", "--neighbors", "7"]);
    assert_eq!(code, 0, "{errors}");
    assert!(errors.contains("Gaussian splats are written as they are, without radii, field and normals"), "{errors}");
    let info = |path: &str| {
        let (code, text, errors) = run(&folder, &["info", "--json", path]);
        assert_eq!((code, errors.as_str()), (0, ""), "{text}");
        let mut value: Value = serde_json::from_str(&text).unwrap();
        // Both name the input.
        value["file"].take();
        value["command"].take();
        value
    };
    let (of_store, of_file) = (info("store"), info(&soup));
    assert_eq!(of_store, of_file);
    assert_eq!((&of_store["gaussians"]["count"], &of_store["gaussians"]["degree"]), (&json!(40), &json!(2)));
    let render = |path: &str, name: &str, more: &[&str]| {
        let all = [&["render", path, "-o", name, "--size", "64x48", "-v"], more].concat();
        let (code, _, errors) = run(&folder, &all);
        assert_eq!(code, 0, "{errors}");
        assert!(errors.contains("every cloud is of Gaussians"), "{errors}");
        image_of(&inside(&folder, name))
    };
    for method in ["abuffer", "sorted", "stochastic"] {
        let more = ["--method", method];
        let expected = render(&soup, "file.png", &more);
        assert!(render("store", "store.png", &more) == expected, "{method}");
    }
    // A store that is made of one is that store, and splats of it are written as a file.
    let (code, _, errors) = run(&folder, &["prepare", "store", "-o", "out.ply"]);
    assert_eq!(code, 0, "{errors}");
    let load = |path: &std::path::Path| io::load(path, &Progress::hidden()).unwrap();
    assert_eq!(load(&inside(&folder, "out.ply")).positions, load(soup.as_ref()).positions);
}

/// The bytes of a PNG file behind its metadata, which name the input.
fn image_of(path: &std::path::Path) -> Vec<u8> {
    let bytes = std::fs::read(path).unwrap();
    let at = bytes.windows(4).position(|four| four == b"IDAT").unwrap();
    bytes[at..].to_vec()
}

#[test]
fn splats_are_refused_in_mixed_stores_and_with_shadows() {
    let folder = folder();
    let soup = splats("soup.sog");
    std::fs::write(inside(&folder, "points.xyz"), "0 0 0\n1 2 3\n").unwrap();
    let (code, _, errors) = run(&folder, &["prepare", &soup, "points.xyz", "-o", "store/"]);
    assert_eq!(code, 1, "{errors}");
    assert!(
        errors.contains(
            "soup.sog has Gaussian splats, points.xyz has points: a store can't mix them; write one store for each"
        ),
        "{errors}"
    );
    assert!(!inside(&folder, "store").exists());
    let (code, _, errors) = run(&folder, &["prepare", &soup, "-o", "out.ply", "--light", "0,-1,0"]);
    assert_eq!(code, 2, "{errors}");
    assert!(errors.contains("Gaussian splats can't store shadows"), "{errors}");
    assert!(!inside(&folder, "out.ply").exists());
}
