//! `spbr-simplified` and `spbr` with `brighten`: p is printed, kept in the metadata, and what the picture was
//! multiplied by.

use serde_json::Value;

use super::render::exr;
use crate::{builtin, done, folder, has_device, inside, run};

#[test]
fn the_factor_is_printed_and_kept() {
    if !has_device() {
        return;
    }
    let folder = folder();
    let tori = builtin(&folder, "tori", &["points=20000"]);
    let render = |name: &str, more: &[&str]| {
        let args = [
            &[
                "render",
                &tori,
                "-q",
                "--size",
                "64x48",
                "--method",
                "spbr-simplified",
                "--background",
                "0,0,0",
                "-o",
                name,
            ],
            more,
        ]
        .concat();
        done(&folder, &args);
        exr(&inside(&folder, name))
    };
    let (plain, of_plain) = render("plain.exr", &["--set", "method.ensembles=200", "--set", "method.brightness=1"]);
    let (bright, of_bright) = render("bright.exr", &["--set", "method.ensembles=200"]);
    let found: Value = serde_json::from_str(&of_bright["pellucid:brightness"]).unwrap();
    let p = found["p"].as_f64().unwrap() as f32;
    assert!(p > 1.0 && found["threshold"].as_u64() <= found["largest"].as_u64(), "{found}");
    assert_eq!(of_plain["pellucid:brightness"], r#"{"p":1.0,"threshold":null,"largest":null}"#);
    assert!(plain["A"] == bright["A"] && plain["Z"] == bright["Z"]);
    for channel in ["R", "G", "B"] {
        assert!(plain[channel].iter().zip(&bright[channel]).all(|(plain, bright)| (plain * p).min(1.0) == *bright));
    }
    let args = ["render", &tori, "--size", "64x48", "--method", "spbr", "--set", "method.brighten=true", "-o", "a.png"];
    let (status, stdout, stderr) = run(&folder, &args);
    assert_eq!((status, stdout.as_str()), (0, ""), "{stderr}");
    assert!(stderr.lines().any(|line| line.starts_with("brightness: colors times ")), "{stderr}");
}
