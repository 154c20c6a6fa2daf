//! Outputs that are inputs are refused before any work, and default names avoid inputs.

use std::fs;

use crate::{assert_refused, folder, has_device, inside, pellucid, run_inside, write_cloud, write_picture};

#[test]
fn an_output_that_is_an_input_is_refused_and_nothing_is_written() {
    let folder = folder();
    write_picture(&inside(&folder, "photo.png"), 3, 0.5);
    write_cloud(&inside(&folder, "m.ply"));
    fs::write(inside(&folder, "p.json"), r#"{"version": 1, "keys": []}"#).unwrap();
    fs::write(inside(&folder, "b.toml"), "[[cloud]]\npath = 'photo.png'\n").unwrap();
    let before = ["photo.png", "m.ply", "p.json", "b.toml"].map(|name| fs::read(inside(&folder, name)).unwrap());
    for (args, parts) in [
        (&["render", "photo.png", "-o", "photo.png"][..], ["-o photo.png", "the input photo.png"]),
        (&["render", "b.toml", "-o", "./photo.png"], ["-o ./photo.png", "the input photo.png"]),
        (&["render", "m.ply", "--profile", "m.ply"], ["--profile m.ply", "the input m.ply"]),
        (&["render", "b.toml", "--trace", "b.toml"], ["--trace b.toml", "the input b.toml"]),
        (&["render", "m.ply", "--path", "p.json", "--profile", "p.json"], ["--profile p.json", "the input p.json"]),
        (&["prepare", "m.ply", "-o", "m.ply"], ["-o m.ply", "the input m.ply"]),
        (&["render", "m.ply", "-o", "a.png", "--profile", "a.png"], ["-o a.png", "--profile a.png"]),
    ] {
        assert_refused(&folder, args, 2, &parts);
    }
    assert_eq!(before, ["photo.png", "m.ply", "p.json", "b.toml"].map(|name| fs::read(inside(&folder, name)).unwrap()));
}

#[test]
fn a_store_is_not_replaced_by_what_is_made_of_it() {
    let folder = folder();
    write_cloud(&inside(&folder, "m.ply"));
    assert_eq!(run_inside(&folder, &["prepare", "m.ply", "-o", "store/"]), (0, String::new(), String::new()));
    for (args, parts) in [
        (&["prepare", "store", "-o", "store/"][..], ["-o store/", "the input store"]),
        (&["prepare", "store/metadata.json", "-o", "store"], ["-o store", "the input store/metadata.json"]),
        (&["render", "store", "--profile", "store/metadata.json"], ["--profile", "the input store/metadata.json"]),
        (&["render", "store/metadata.json", "--profile", "store/octree.bin"], ["--profile", "store/octree.bin"]),
    ] {
        assert_refused(&folder, args, 2, &parts);
    }
}

#[test]
fn files_of_splats_in_several_files_are_inputs() {
    let folder = folder();
    fs::create_dir(inside(&folder, "sog")).unwrap();
    fs::write(inside(&folder, "sog/meta.json"), r#"{"means": {"files": ["means_l.webp", "means_u.webp"]}}"#).unwrap();
    fs::write(inside(&folder, "sog/means_u.webp"), "x").unwrap();
    fs::write(inside(&folder, "a.gltf"), r#"{"buffers": [{"uri": "a%20b.bin"}]}"#).unwrap();
    fs::write(inside(&folder, "a b.bin"), "x").unwrap();
    for (args, part) in [
        (&["render", "sog", "--profile", "sog/means_u.webp"][..], "the input sog/means_u.webp"),
        (&["render", "sog/meta.json", "--profile", "sog/means_u.webp"], "the input sog/means_u.webp"),
        (&["render", "sog", "--profile", "sog/meta.json"], "the input sog/meta.json"),
        (&["render", "a.gltf", "--profile", "a b.bin"], "a b.bin"),
    ] {
        assert_refused(&folder, args, 2, &[part]);
    }
    let tile = inside(&folder, "ept/ept-data/0-0-0-0.laz");
    fs::create_dir_all(tile.parent().unwrap()).unwrap();
    fs::write(inside(&folder, "ept/ept.json"), "{}").unwrap();
    fs::write(tile, "x").unwrap();
    let args = ["render", "ept/", "--profile", "ept/ept-data/0-0-0-0.laz"];
    assert_refused(&folder, &args, 2, &["the input ept/ept-data"]);
}

#[test]
fn the_picture_of_a_picture_has_a_name_of_its_own() {
    if !has_device() {
        return;
    }
    let folder = folder();
    write_picture(&inside(&folder, "photo.png"), 3, 0.5);
    fs::write(inside(&folder, "b.toml"), "[[cloud]]\npath = 'b.png'\n").unwrap();
    fs::copy(inside(&folder, "photo.png"), inside(&folder, "b.png")).unwrap();
    let before = fs::read(inside(&folder, "photo.png")).unwrap();
    for (input, output) in [("photo.png", "photo.render.png"), ("b.toml", "b.render.png")] {
        pellucid(&folder, &["render", input, "--size", "8x8"]).assert().success();
        assert!(inside(&folder, output).is_file(), "{output}");
    }
    assert!(["photo.png", "b.png"].iter().all(|name| fs::read(inside(&folder, name)).unwrap() == before));
}

#[cfg(unix)]
#[test]
fn a_pipe_is_no_file_and_the_error_says_what_to_do() {
    let folder = folder();
    for command in ["info", "plan"] {
        let output = pellucid(&folder, &[command, "/dev/stdin"]).write_stdin("0 0 0\n1 1 1\n").output().unwrap();
        let stderr = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(1), "{stderr}");
        assert!(stderr.starts_with("error: /dev/stdin: a pipe or a device"), "{stderr}");
        assert!(stderr.contains("write it to a file first"), "{stderr}");
    }
}
