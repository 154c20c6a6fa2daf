//! Contents of packages besides the program: completions, manual pages, licenses, one version.

use std::fs;
use std::process::Command;

use pellucid_testing::root;
use pellucid_testing::skip::{NO_PROGRAM, skip};

use crate::{assert_refused, folder, inside, run};

const CRATES: [&str; 13] = [
    "cli",
    "core",
    "engine",
    "fault",
    "gpu",
    "io",
    "lab",
    "pellucid",
    "reference",
    "scene",
    "session",
    "viewer",
    "window",
];

/// A program that is there, with what it prints; `None`, and a word, if it isn't.
fn program(name: &str, args: &[&str]) -> Option<String> {
    match Command::new(name).args(args).output() {
        Ok(output) => Some(String::from_utf8_lossy(&[output.stdout, output.stderr].concat()).into_owned()),
        Err(_) => {
            skip(NO_PROGRAM, name);
            None
        }
    }
}

/// The words that bash offers at the end of a line.
#[cfg(unix)]
fn offered(script: &str, words: &[&str]) -> Option<String> {
    let last = words.len() - 1;
    let list = words.iter().map(|word| format!("'{word}'")).collect::<Vec<_>>().join(" ");
    let (word, before) = (words[last], words[last - 1]);
    let line = format!(
        "source '{script}'; COMP_WORDS=({list}); COMP_CWORD={last}; _pellucid pellucid '{word}' '{before}'; printf '%s\\n' \"${{COMPREPLY[@]}}\""
    );
    program("bash", &["--noprofile", "--norc", "-c", &line])
}

#[cfg(unix)]
#[test]
fn bash_completes_commands_options_and_values() {
    let folder = folder();
    let (status, script, stderr) = run(&folder, &["completions", "bash"]);
    assert_eq!((status, stderr.as_str()), (0, ""));
    let path = inside(&folder, "pellucid.bash");
    fs::write(&path, script).unwrap();
    let path = path.to_str().unwrap();
    for (words, expected) in [
        (&["pellucid", "ren"] as &[&str], "render\n"),
        (&["pellucid", "comp"], "compare\ncompletions\n"),
        (&["pellucid", "render", "--see-t"], "--see-through\n"),
        (&["pellucid", "completions", "fi"], "fish\n"),
    ] {
        let Some(offered) = offered(path, words) else { return };
        assert_eq!(offered, expected, "{words:?}");
    }
}

#[test]
fn every_shell_has_a_script_with_every_command() {
    let folder = folder();
    for shell in ["bash", "zsh", "fish", "powershell", "elvish"] {
        let (status, script, stderr) = run(&folder, &["completions", shell]);
        assert_eq!((status, stderr.as_str()), (0, ""), "{shell}");
        for word in ["render", "tradeoff", "see-through"] {
            assert!(script.contains(word), "{shell}: {word}");
        }
    }
    let (status, _, stderr) = run(&folder, &["completions", "tcsh"]);
    assert_eq!(status, 2);
    assert!(stderr.contains("bash") && stderr.contains("elvish"), "{stderr}");
}

#[test]
fn every_command_has_a_manual_page_that_renders() {
    let folder = folder();
    assert_eq!(run(&folder, &["man", "pages"]), (0, String::new(), String::new()));
    let (_, help, _) = run(&folder, &["--help"]);
    let (_, rest) = help.split_once("Commands:\n").unwrap();
    let commands = rest
        .lines()
        .take_while(|line| !line.is_empty())
        .filter(|line| line.starts_with("  ") && !line.starts_with("   "));
    let commands: Vec<&str> =
        commands.filter_map(|line| line.split_whitespace().next()).filter(|name| *name != "help").collect();
    assert!(commands.len() >= 13, "{help}");
    for command in &commands {
        let page = fs::read_to_string(inside(&folder, &format!("pages/pellucid-{command}.1"))).unwrap();
        assert!(
            page.contains(".SH SYNOPSIS") && page.contains(&format!("pellucid {}", env!("CARGO_PKG_VERSION"))),
            "{command}"
        );
    }
    for name in ["pellucid.1", "pellucid-render.1"] {
        let path = inside(&folder, "pages").join(name);
        let Some(words) = program("man", &["--warnings", "-E", "UTF-8", "-l", "-Tutf8", path.to_str().unwrap()]) else {
            return;
        };
        let words = without_overstrikes(&words);
        assert!(words.contains("NAME") && words.contains("SYNOPSIS"), "{name}: {words}");
        assert!(!words.contains("warning:"), "{name}: {words}");
    }
}

/// A typewriter's bold is a character twice in its place.
fn without_overstrikes(words: &str) -> String {
    words.chars().fold(String::new(), |mut text, c| {
        if c == '\u{8}' {
            text.pop();
        } else {
            text.push(c);
        }
        text
    })
}

#[test]
fn manual_pages_want_a_folder() {
    let folder = folder();
    fs::write(inside(&folder, "file"), "").unwrap();
    assert_refused(&folder, &["man", "file"], 1, &["file"]);
}

#[test]
fn one_version_and_one_day_stand_everywhere() {
    let version = env!("CARGO_PKG_VERSION");
    let read = |name: &str| fs::read_to_string(root().join(name)).unwrap();
    let manifest: toml::Table = toml::from_str(&read("Cargo.toml")).unwrap();
    let workspace = manifest["workspace"].as_table().unwrap();
    assert_eq!(workspace["package"]["version"].as_str(), Some(version));
    for (name, dependency) in workspace["dependencies"].as_table().unwrap() {
        if name.starts_with("pellucid-") && !name.starts_with("pellucid-testing") {
            assert_eq!(dependency["version"].as_str(), Some(version), "{name}");
        }
    }
    let changelog = read("CHANGELOG.md");
    let newest =
        changelog.lines().filter_map(|line| line.strip_prefix("## [")).find(|line| !line.starts_with("Unreleased"));
    let (found, day) = newest.unwrap().split_once("] - ").unwrap();
    assert_eq!(found, version, "CHANGELOG.md");
    let citation = read("CITATION.cff");
    assert!(citation.contains(&format!("\nversion: {version}\n")), "CITATION.cff");
    assert!(citation.contains(&format!("\ndate-released: {day}\n")), "CITATION.cff");
    let folder = folder();
    assert_eq!(run(&folder, &["man", "pages"]), (0, String::new(), String::new()));
    let page = fs::read_to_string(inside(&folder, "pages/pellucid-render.1")).unwrap();
    let title = format!(".TH pellucid-render 1 {day} \"pellucid {version}\" \"User Commands\"");
    assert!(page.contains(&title), "{page}");
}

#[test]
fn every_published_crate_holds_the_licenses_and_a_readme() {
    for name in CRATES {
        let crate_folder = root().join("crates").join(name);
        for license in ["LICENSE-MIT", "LICENSE-APACHE"] {
            let text = |path| fs::read_to_string(path).unwrap();
            assert_eq!(text(crate_folder.join(license)), text(root().join(license)), "{name}: {license}");
        }
        let manifest: toml::Table =
            toml::from_str(&fs::read_to_string(crate_folder.join("Cargo.toml")).unwrap()).unwrap();
        let package = manifest["package"].as_table().unwrap();
        assert!(crate_folder.join(package["readme"].as_str().unwrap()).is_file(), "{name}");
        assert!(package.contains_key("description"), "{name}");
    }
}
