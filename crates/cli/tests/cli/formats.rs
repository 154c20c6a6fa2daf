//! Text files whose columns the command line or a scene file names.

use std::fs;

use pellucid_core::cloud::UpAxis;
use serde_json::{Value, json};

use crate::{assert_refused, done, folder, has_device, inside, run};

const TABLE: &str = "9 0 0 0 255 0 0\n8 1 2 3 0 0 255\n";

fn info(folder: &tempfile::TempDir, args: &[&str]) -> Value {
    let (code, stdout, stderr) = run(folder, &[&["info", "--json"], args].concat());
    assert_eq!((code, stderr.as_str()), (0, ""), "{args:?}");
    serde_json::from_str(&stdout).unwrap()
}

#[test]
fn columns_are_named_wherever_files_are_read() {
    let folder = folder();
    fs::write(inside(&folder, "a.xyz"), TABLE).unwrap();
    let guessed = info(&folder, &["a.xyz"]);
    assert_eq!(guessed["bounds"]["max"], json!([9.0, 1.0, 2.0]));
    let named = info(&folder, &["a.xyz", "--columns", "-,x,y,z,r,g,b"]);
    assert_eq!((&named["bounds"]["max"], &named["attributes"]), (&json!([1.0, 2.0, 3.0]), &json!(["color"])));
    let (code, _, stderr) =
        run(&folder, &["prepare", "a.xyz", "-o", "a.ply", "--columns", "height,x,y,z,r,g,b", "--field", "height"]);
    assert_eq!((code, stderr.as_str()), (0, ""));
    let prepared = info(&folder, &["a.ply"]);
    assert_eq!(prepared["attributes"], json!(["color", "radius", "field", "height"]));
    let cloud = pellucid_io::load(&inside(&folder, "a.ply"), &pellucid_core::progress::Progress::hidden()).unwrap();
    assert_eq!((cloud.up, cloud.prepared.unwrap().values), (UpAxis::Z, vec![1.0, 0.0]));
    // For files that name their columns an error says that nothing is left to name.
    let (code, _, stderr) = run(&folder, &["info", "a.ply", "--columns", "x,y,z"]);
    assert!(code == 0 && stderr.contains("warning: a.ply: columns have no effect"), "{stderr}");

    for command in ["render", "plan", "profile", "info"] {
        assert_refused(&folder, &[command, "a.xyz", "--columns", "x,y"], 2, &["--columns", "no `z` in \"x,y\""]);
        assert_refused(&folder, &[command, "a.xyz", "--columns", "x,y,z,x"], 2, &["`x` occurs twice"]);
        let short = [command, "a.xyz", "--columns", "x,y,z"];
        assert_refused(&folder, &short, 1, &["a.xyz: line 1: 7 values, but names are given for 3 columns"]);
    }
    assert_refused(&folder, &["prepare", "a.xyz", "-o", "b.ply", "--columns", "x"], 2, &["no `y`"]);
}

#[test]
fn a_scene_names_columns_and_the_option_wins() {
    if !has_device() {
        return;
    }
    let folder = folder();
    fs::write(inside(&folder, "a.xyz"), TABLE).unwrap();
    fs::write(inside(&folder, "b.xyz"), "0 0 0 255 0 0\n1 2 3 0 0 255\n").unwrap();
    let scene = |name: &str, cloud: &str, columns: &str| {
        let camera = "[image]\nsize = [32, 32]\n[camera]\neye = [0, -30, 1]\ntarget = [0, 0, 1]\nup = [0, 0, 1]\n";
        let text = format!("{camera}[[cloud]]\npath = \"{cloud}\"\nradius = 2\n{columns}\n");
        fs::write(inside(&folder, name), text).unwrap();
    };
    scene("named.toml", "a.xyz", "columns = \"-,x,y,z,r,g,b\"");
    scene("wrong.toml", "a.xyz", "columns = \"x,y,z,r,g,b,-\"");
    scene("plain.toml", "b.xyz", "");
    let picture = |scene: &str, args: &[&str]| {
        done(&folder, &[&["render", scene, "-o", "out.exr", "--set", "method.name=circles"], args].concat());
        pellucid_io::output::read_image(&inside(&folder, "out.exr")).unwrap().pixels
    };
    let plain = picture("plain.toml", &[]);
    let lit = |channel: usize| plain.iter().filter(|pixel| pixel[channel] == 1.0).count();
    assert!(lit(0) > 5 && lit(2) > 5, "a red disc and a blue one");
    assert!(plain == picture("named.toml", &[]));
    assert!(plain != picture("wrong.toml", &[]));
    assert!(plain == picture("wrong.toml", &["--columns", "-,x,y,z,r,g,b"]));
}

#[test]
fn info_reads_pictures() {
    let folder = folder();
    // Two by two pixels, one of them nothing.
    let bytes = [[255, 0, 0, 255], [128, 128, 128, 51], [9, 9, 9, 0], [255; 4]].concat();
    let mut encoder = png::Encoder::new(fs::File::create(inside(&folder, "a.png")).unwrap(), 2, 2);
    encoder.set_color(png::ColorType::Rgba);
    encoder.write_header().unwrap().write_image_data(&bytes).unwrap();
    let info = info(&folder, &["a.png"]);
    let found = (&info["points"], &info["attributes"], &info["bounds"]["max"]);
    assert_eq!(found, (&3.into(), &json!(["color", "alpha", "normal"]), &json!([0.25, 0.25, 0.0])));
}
