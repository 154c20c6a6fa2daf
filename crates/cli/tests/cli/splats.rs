//! Gaussian splats on the command line: described, and written as PLY files.

use pellucid_engine::io;
use pellucid_engine::progress::Progress;
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
        "--method auto\n",
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
fn what_splats_are_not_made_into() {
    let folder = folder();
    let soup = splats("soup.sog");
    let (code, _, errors) = run(&folder, &["prepare", &soup, "-o", "store/"]);
    assert_eq!(code, 1, "{errors}");
    assert!(
        errors.contains("soup.sog: Gaussian splats, of which no store can be made yet; `pellucid prepare "),
        "{errors}"
    );
    assert!(
        errors.contains("-o NAME.ply` writes them as a PLY file") && !inside(&folder, "store").exists(),
        "{errors}"
    );
    let (code, _, errors) = run(&folder, &["prepare", &soup, "-o", "out.ply", "--light", "0,-1,0"]);
    assert_eq!(code, 2, "{errors}");
    assert!(errors.contains("shadows are stored with points, but these are Gaussian splats"), "{errors}");
    assert!(!inside(&folder, "out.ply").exists());
}
