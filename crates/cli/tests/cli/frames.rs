//! `render --frames`: a picture for each cloud that joins, all by the camera of the whole scene.

use std::fs;

use crate::{builtin, done, folder, has_device, inside, run_inside};

use super::render::exr;

const CAMERA: &str =
    "[camera]\neye = [7.0, -6.0, 5.0]\ntarget = [0.0, 0.0, 0.5]\nup = [0.0, 0.0, 1.0]\nnear = 0.5\nfar = 40.0\n";

/// A scene of some clouds of the garden, in this order.
fn scene(clouds: &[&str], camera: &str, method: &str) -> String {
    let cloud = |name: &&str| format!("[[cloud]]\npath = \"garden/{name}.ply\"\nopacity = 0.4\n");
    let clouds: String = clouds.iter().map(cloud).collect();
    format!("[image]\nsize = [48, 36]\n{camera}[method]\nname = \"{method}\"\n{clouds}")
}

#[test]
fn each_step_is_the_scene_of_its_clouds() {
    if !has_device() {
        return;
    }
    let folder = folder();
    builtin(&folder, "garden", &["points=3000"]);
    let clouds = ["furniture", "structure", "ground"];
    for method in ["spbr", "abuffer", "points"] {
        let write =
            |name: &str, clouds: &[&str]| fs::write(inside(&folder, name), scene(clouds, CAMERA, method)).unwrap();
        write("whole.toml", &clouds);
        // Quiet: there are fewer points than spbr wants for that opacity.
        done(&folder, &["render", "whole.toml", "--frames", "-o", "step_%02d.exr", "--seed", "5", "-q"]);
        let mut before = None;
        for count in 1..=3 {
            write("part.toml", &clouds[..count]);
            done(&folder, &["render", "part.toml", "-o", "part.exr", "--seed", "5", "-q"]);
            let (step, of_step) = exr(&inside(&folder, &format!("step_{count:02}.exr")));
            let (part, of_part) = exr(&inside(&folder, "part.exr"));
            let bits = |channels: &std::collections::BTreeMap<String, Vec<f32>>| {
                channels.iter().map(|(k, v)| (k.clone(), v.iter().map(|x| x.to_bits()).collect())).collect::<Vec<_>>()
            };
            let (step, part): (Vec<(String, Vec<u32>)>, _) = (bits(&step), bits(&part));
            assert!(step == part, "{method}: step {count}");
            assert_eq!(of_step["pellucid:method"], of_part["pellucid:method"]);
            assert_eq!(of_step["pellucid:step"], format!("{count} of 3"));
            assert!(before.replace(step.clone()) != Some(step), "{method}: step {count} adds something");
        }
    }
    assert!(!inside(&folder, "step_04.exr").exists());
}

#[test]
fn the_camera_is_that_of_the_whole_scene() {
    if !has_device() {
        return;
    }
    let folder = folder();
    builtin(&folder, "garden", &["points=3000"]);
    let write = |name: &str, clouds: &[&str]| {
        fs::write(inside(&folder, name), scene(clouds, "[camera]\nup = [0, 0, 1]\n", "points")).unwrap();
    };
    write("whole.toml", &["furniture", "ground"]);
    write("part.toml", &["furniture"]);
    done(&folder, &["render", "whole.toml", "--frames", "-o", "%d.exr"]);
    done(&folder, &["render", "part.toml", "-o", "part.exr"]);
    let covered = |name: &str| exr(&inside(&folder, name)).0["A"].iter().filter(|a| **a > 0.0).count();
    let [small, whole, close] = ["1.exr", "2.exr", "part.exr"].map(covered);
    assert!(small < whole && small < close, "{small} of the furniture, {whole} of all, {close} from nearby");
}

#[test]
fn names_without_a_number_are_refused() {
    let folder = folder();
    let refused = |args: &[&str], says: &str| {
        let (status, stdout, stderr) = run_inside(&folder, args);
        assert_eq!((status, stdout.as_str()), (2, ""), "{stderr}");
        assert!(stderr.contains(says), "{stderr}");
    };
    refused(&["render", "--frames", "-o", "step.png"], "step_%02d.png");
    refused(&["render", "--frames", "-o", "%d_%d.png"], "more than one number");
    refused(&["render", "--frames", "-o", "step_%02d.gif"], ".png");
    let (status, _, stderr) = run_inside(&folder, &["render", "--frames", "-o", "none/step_%d.png"]);
    assert!(status == 1 && stderr.contains("no folder none"), "{stderr}");
    assert_eq!(fs::read_dir(&folder).unwrap().count(), 0, "nothing was written");
}
