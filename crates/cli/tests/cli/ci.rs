//! The workflow of docs/ci: its steps run as they stand there, except those that install.

use std::collections::BTreeMap;
use std::fs;
use std::os::unix::fs::symlink;
use std::process::Command;

use tempfile::TempDir;

use pellucid_testing::skip::{NO_PROGRAM, skip};
use pellucid_testing::{root, shader_cache};

use crate::{device, done, folder, has_device, inside, run};

/// A step that runs commands.
#[derive(Debug)]
struct Step {
    name: String,
    script: String,
}

/// The variables and the steps of the workflow, of whose YAML this reads no more than is used there.
fn workflow() -> (BTreeMap<String, String>, Vec<Step>) {
    let text = fs::read_to_string(root().join("docs/ci/pellucid.yml")).unwrap();
    let (_, after) = text.split_once("\nenv:\n").unwrap();
    let variables = after.lines().take_while(|line| line.starts_with("  ")).filter_map(|line| line.split_once(": "));
    let variables = variables.filter(|(key, _)| !key.contains('#'));
    let variables = variables.map(|(key, value)| (key.trim().to_owned(), value.to_owned())).collect();
    let steps = text.split("\n      - ").skip(1).filter_map(|step| {
        let name = step.lines().next()?.strip_prefix("name: ")?.to_owned();
        let (_, script) = step.split_once("\n        run: |\n")?;
        let script = script.lines().map(|line| line.strip_prefix("          ").unwrap_or(line));
        Some(Step { name, script: script.collect::<Vec<_>>().join("\n") })
    });
    (variables, steps.collect())
}

/// Runs the steps that don't install, each whatever became of those before it; names and exit statuses.
fn run_steps(folder: &TempDir, changes: &[(&str, &str)]) -> Vec<(String, i32)> {
    let (mut variables, steps) = workflow();
    for (key, value) in changes {
        assert!(variables.insert((*key).to_owned(), (*value).to_owned()).is_some(), "{key} is a variable");
    }
    variables.insert("DEVICE".to_owned(), device().unwrap_or("0".to_owned()));
    let steps = steps.into_iter().filter(|step| !step.name.starts_with("Install"));
    let statuses = steps.map(|step| {
        // As GitHub runs `shell: bash`.
        let mut bash = Command::new("bash");
        bash.args(["--noprofile", "--norc", "-eo", "pipefail", "-c", &step.script]).current_dir(folder);
        let output = bash.envs(&variables).env("PELLUCID_CACHE_DIR", shader_cache()).output().unwrap();
        println!("{}: {output:?}", step.name);
        (step.name, output.status.code().unwrap())
    });
    statuses.collect()
}

fn has(program: &str) -> bool {
    let found = Command::new(program).arg("--version").output().is_ok_and(|output| output.status.success());
    if !found {
        skip(NO_PROGRAM, program);
    }
    found
}

/// The result of the steps before the first one that is run: two checkouts and two installations.
fn checked_out() -> TempDir {
    let folder = folder();
    for side in ["base", "head"] {
        fs::create_dir_all(inside(&folder, &format!("bin/{side}/bin"))).unwrap();
        let binary = inside(&folder, &format!("bin/{side}/bin/pellucid"));
        symlink(assert_cmd::cargo::cargo_bin("pellucid"), binary).unwrap();
        let scene = format!("{side}/scene");
        let args = ["scene", "stack", "-o", &scene, "--set", "layers=12", "--set", "size=64"];
        assert_eq!(run(&folder, &args), (0, String::new(), String::new()));
        done(&folder, &["render", &format!("{scene}/scene.toml"), "-o", &format!("{scene}/reference.exr")]);
    }
    folder
}

/// The uploaded files.
const ARTIFACTS: [&str; 6] = ["render.exr", "difference.png", "picture.txt", "base.json", "head.json", "cost.txt"];

#[test]
fn the_workflow_passes_what_did_not_change_and_stops_what_did() {
    if !has_device() || !has("bash") || !has("jq") {
        return;
    }
    let folder = checked_out();
    let named = |statuses: [i32; 3]| {
        let names = ["Render", "Compare the picture", "Compare the cost"].map(str::to_owned);
        names.into_iter().zip(statuses).collect::<Vec<_>>()
    };
    // Whatever slows one side: what is tested is that the steps work.
    assert_eq!(run_steps(&folder, &[("ROUNDS", "2"), ("MAX_SLOWER", "1e9")]), named([0, 0, 0]));
    let out = |name: &str| inside(&folder, "out").join(name);
    assert!(ARTIFACTS.iter().all(|name| out(name).is_file()));
    let profile: serde_json::Value = serde_json::from_str(&fs::read_to_string(out("head.json")).unwrap()).unwrap();
    assert_eq!(profile["frames"].as_array().unwrap().len(), 10, "two runs of five frames");
    let cost = fs::read_to_string(out("cost.txt")).unwrap();
    assert!(!cost.contains("no noise estimate") && cost.contains("frame"), "{cost}");

    // Another picture, and a limit that every time breaks: both steps fail, and everything is kept.
    fs::remove_dir_all(inside(&folder, "out")).unwrap();
    let scene = inside(&folder, "head/scene/scene.toml");
    let text = fs::read_to_string(&scene).unwrap();
    fs::write(&scene, text.replace("opacity = 0.05", "opacity = 0.06")).unwrap();
    assert_eq!(run_steps(&folder, &[("ROUNDS", "1"), ("MAX_SLOWER", "0.001")]), named([0, 1, 1]));
    assert!(ARTIFACTS.iter().all(|name| out(name).is_file()));
}

#[test]
fn the_page_tells_of_every_variable_and_the_workflow_keeps_what_failed() {
    let folder = root().join("docs");
    let page = fs::read_to_string(folder.join("ci.md")).unwrap();
    let (variables, steps) = workflow();
    assert_eq!((variables.len(), steps.len()), (8, 6));
    for name in variables.keys() {
        assert!(page.contains(&format!("`{name}`")), "{name}");
    }
    let text = fs::read_to_string(folder.join("ci/pellucid.yml")).unwrap();
    let conditions: Vec<_> = text.lines().map(str::trim).filter(|line| line.starts_with("if: ")).collect();
    assert_eq!(conditions, ["if: success() || failure()", "if: always()"]);
}
