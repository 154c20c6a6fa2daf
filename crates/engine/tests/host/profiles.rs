//! Debug and release builds compile the same code, so that CI proves both with one build: the difference is a value,
//! `cfg!(debug_assertions)`, never an attribute.

use pellucid_testing::root;

/// Returns the mentions of `debug_assertions` that are no `cfg!`: number of the line, and the line.
fn attributes(text: &str) -> Vec<(usize, &str)> {
    let is_one = |line: &str| line.replace("cfg!(debug_assertions)", "").contains("debug_assertions");
    let is_comment = |line: &str| line.starts_with("//");
    let lines = text.lines().map(str::trim).enumerate();
    lines.filter(|(_, line)| is_one(line) && !is_comment(line)).map(|(at, line)| (at + 1, line)).collect()
}

#[test]
fn no_code_is_compiled_in_one_kind_of_build_alone() {
    let mut folders = ["crates", "tools", "fuzz"].map(|name| root().join(name)).to_vec();
    let (mut found, mut files) = (Vec::new(), 0);
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(folder).expect("a folder of sources") {
            let path = entry.expect("an entry").path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|extension| extension == "rs") && !path.ends_with("profiles.rs") {
                files += 1;
                let text = std::fs::read_to_string(&path).expect("a source");
                found.extend(attributes(&text).iter().map(|(at, line)| format!("{}:{at}: {line}", path.display())));
            }
        }
    }
    assert!(files > 500, "{files}");
    assert_eq!(found, Vec::<String>::new());
}

#[test]
fn attributes_are_found() {
    let text = "#[cfg(debug_assertions)]\nfn a() {}\n    not(debug_assertions),\nif cfg!(debug_assertions) {}\n// debug_assertions";
    assert_eq!(attributes(text).iter().map(|(at, _)| *at).collect::<Vec<_>>(), [1, 3]);
}
