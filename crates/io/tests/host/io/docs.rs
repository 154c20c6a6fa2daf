//! The table of sample files in docs/formats.md is what the reader does with them.

use std::fmt::Write;
use std::path::Path;

use pellucid_core::cloud::Cloud;

use pellucid_testing_host::{root, whole_clouds};

use super::load;
use super::real::FOLDERS;

/// The heading that the table follows.
const HEADING: &str = "## Sample files\n";

/// Sources of the files, as the folder's README has it.
fn sources(readme: &str) -> Vec<(&str, &str)> {
    readme.lines().filter_map(source).collect()
}

/// File and source of a row in one of the README's two tables.
fn source(line: &str) -> Option<(&str, &str)> {
    let cells: Vec<&str> = line.split('|').map(str::trim).collect();
    match cells.as_slice() {
        ["", file, _, _, _, _, _, _, _, source, _, ""] | ["", file, _, source, _, _, ""] => Some((file, source)),
        _ => None,
    }
}

/// The attributes of a cloud other than positions.
fn attributes(cloud: &Cloud) -> String {
    let usual = [
        ("color", cloud.colors.is_some()),
        ("alpha", cloud.alphas.is_some()),
        ("gaussian", cloud.gaussians.is_some()),
        ("normal", cloud.normals.is_some()),
        ("radius", cloud.radii.is_some()),
        ("classification", cloud.classification.is_some()),
        ("intensity", cloud.intensity.is_some()),
    ];
    let usual = usual.into_iter().filter(|(_, given)| *given).map(|(name, _)| name.to_owned());
    let names: Vec<_> = usual.chain(cloud.scalars.iter().map(|(name, _)| format!("`{name}`"))).collect();
    if names.is_empty() { "none".to_owned() } else { names.join(", ") }
}

fn row(data: &Path, file: &str, source: &str) -> String {
    let name = file.rsplit('/').next().unwrap();
    let (points, rest) = match load(&data.join(file)) {
        Ok(cloud) => {
            let left_out =
                if cloud.non_finite > 0 { format!(" (+ {} left out)", cloud.non_finite) } else { String::new() };
            (format!("{}{left_out}", cloud.len()), attributes(&cloud))
        }
        Err(e) => {
            let message = e.to_string();
            ("refused".to_owned(), message.split_once(": ").unwrap().1.replace('|', "\\|"))
        }
    };
    format!("| {name} | {points} | {rest} | {source} |\n")
}

#[test]
fn the_table_of_sample_files_is_true() {
    let Some(data) = whole_clouds() else { return };
    let readme = std::fs::read_to_string(data.join("README.md")).unwrap();
    let sources = sources(&readme);
    let mut table = String::from("| file | points | attributes, or why it is refused | source |\n|---|---|---|---|\n");
    for folder in FOLDERS.into_iter().chain(["volumes"]) {
        let entries = std::fs::read_dir(data.join(folder)).unwrap();
        let mut names: Vec<_> = entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        for name in names {
            let file = format!("{folder}/{name}");
            let source = sources.iter().find(|(known, _)| *known == file || *known == name);
            let source = source.unwrap_or_else(|| panic!("{file} is not in README.md")).1;
            table.write_str(&row(&data, &file, source)).unwrap();
        }
    }
    let docs = std::fs::read_to_string(root().join("docs/formats.md")).unwrap();
    let (_, section) = docs.split_once(HEADING).expect("the heading");
    let found: String = section.lines().filter(|line| line.starts_with('|')).flat_map(|line| [line, "\n"]).collect();
    if found != table {
        let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join("sample-files.md");
        std::fs::write(&path, table).unwrap();
        panic!("the table in docs/formats.md is not what the reader does; {} is", path.display());
    }
}
