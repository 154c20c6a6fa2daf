//! The rooms of each crate, which are the modules at its root, use each other in one direction only, as do the crates.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use pellucid_testing::root;

type Uses = BTreeMap<String, BTreeSet<String>>;

/// Code without comments and without its unit tests, which may look up.
fn code(text: &str) -> String {
    let end = text.find("#[cfg(test)]\nmod tests").unwrap_or(text.len());
    let lines = text[..end].lines().map(|line| line.split("//").next().unwrap_or_default());
    lines.collect::<Vec<_>>().join("\n")
}

/// The words behind `crate::` and `path`, of all paths that begin so.
fn used(code: &str, path: &[&str]) -> BTreeSet<String> {
    let prefix: String = path.iter().fold("crate::".to_owned(), |prefix, name| format!("{prefix}{name}::"));
    let word = |text: &str| -> String { text.chars().take_while(|c| c.is_ascii_alphanumeric() || *c == '_').collect() };
    let mut found = BTreeSet::new();
    for rest in code.split(prefix.as_str()).skip(1) {
        match rest.strip_prefix('{') {
            None => found.extend([word(rest)]),
            // Only the words at the depth of the first brace are rooms.
            Some(list) => {
                let mut depth = 1;
                let mut start = true;
                for (at, c) in list.char_indices() {
                    match c {
                        '{' => depth += 1,
                        '}' => depth -= 1,
                        ',' if depth == 1 => start = true,
                        c if depth == 1 && start && !c.is_whitespace() => {
                            found.insert(word(&list[at..]));
                            start = false;
                        }
                        _ => {}
                    }
                    if depth == 0 {
                        break;
                    }
                }
            }
        }
    }
    found
}

/// Reads what the rooms in a folder of a crate's sources use of each other. `path` leads from the root of the crate to
/// the folder.
fn read(sources: &Path, path: &[&str]) -> Uses {
    let mut uses = Uses::new();
    let folder = path.iter().fold(sources.to_owned(), |folder, name| folder.join(name));
    add(sources, &folder, path, &mut uses);
    uses
}

fn add(sources: &Path, folder: &Path, path: &[&str], uses: &mut Uses) {
    for entry in std::fs::read_dir(folder).expect("a folder of sources") {
        let file = entry.expect("an entry").path();
        if file.is_dir() {
            add(sources, &file, path, uses);
            continue;
        }
        let name = file.strip_prefix(sources).expect("a source of the crate").with_extension("");
        let mut module: Vec<&str> = name.iter().filter_map(|part| part.to_str()).collect();
        module.pop_if(|last| *last == "mod");
        let is_test = module.contains(&"tests");
        let Some(room) = module.get(path.len()).filter(|room| !is_test && !["lib", "main"].contains(*room)) else {
            continue;
        };
        if file.extension().is_some_and(|e| e == "rs") {
            let text = code(&std::fs::read_to_string(&file).expect("a source"));
            uses.entry((*room).to_owned()).or_default().extend(used(&from_root(&text, &module), path));
        }
    }
}

/// Code with its paths from the root of the crate where it climbs as far as the room's own level, or one less.
fn from_root(code: &str, module: &[&str]) -> String {
    let mut text = code.to_owned();
    for up in (1..=module.len()).rev() {
        let to: String = module[..module.len() - up].iter().map(|name| format!("{name}::")).collect();
        text = text.replace(&"super::".repeat(up), &format!("crate::{to}"));
    }
    text
}

/// The rooms that lead back to themselves.
fn circle(mut uses: Uses) -> BTreeSet<String> {
    let rooms: BTreeSet<String> = uses.keys().cloned().collect();
    for (room, used) in &mut uses {
        used.retain(|other| other != room && rooms.contains(other));
    }
    let reaches_itself = |room: &&String| {
        let (mut seen, mut next) = (BTreeSet::new(), vec![*room]);
        while let Some(from) = next.pop() {
            next.extend(uses[from].iter().filter(|to| seen.insert(*to)));
        }
        seen.contains(*room)
    };
    rooms.iter().filter(reaches_itself).cloned().collect()
}

/// Rooms that use each other in a circle today, each list with the reason. Entries are only ever deleted.
const KNOWN: [(&str, &[&str], &[&str]); 1] = [
    // Readers and stores share the error and the source of the root.
    ("io", &[], &["channel", "columns", "las", "store"]),
];

#[test]
fn no_room_uses_one_that_uses_it() {
    let found = std::fs::read_dir(root().join("crates")).expect("the crates");
    let crates = found.map(|entry| entry.expect("a crate").file_name().into_string().expect("a plain name"));
    let mut places: Vec<(String, &[&str])> = crates.map(|name| (name, &[][..])).collect();
    places.extend([("engine".to_owned(), &["methods"][..]), ("engine".to_owned(), &["passes"])]);
    assert!(places.len() > 10, "{places:?}");
    for (name, path) in places {
        let sources = root().join("crates").join(&name).join("src");
        let known = KNOWN.iter().filter(|(of, at, _)| *of == name && *at == path).flat_map(|(.., rooms)| *rooms);
        let mut circle = circle(read(&sources, path));
        known.for_each(|room| {
            circle.remove(*room);
        });
        assert_eq!(circle, BTreeSet::new(), "rooms of crates/{name}/{path:?} that use each other in a circle");
    }
}

/// The crates from the bottom to the top. One uses only crates before it.
const ORDER: [&str; 16] = [
    "fault",
    "core",
    "io",
    "scene",
    "reference",
    "testing-host",
    "gpu",
    "window",
    "engine",
    "testing",
    "session",
    "pellucid",
    "lab",
    "viewer",
    "cli",
    "python",
];

#[test]
fn crates_use_those_below_them_alone() {
    for entry in std::fs::read_dir(root().join("crates")).expect("the crates") {
        let folder = entry.expect("a crate").path();
        let name = folder.file_name().and_then(|name| name.to_str()).expect("a plain name").to_owned();
        let text = std::fs::read_to_string(folder.join("Cargo.toml")).expect("a manifest");
        let at = |name: &str| ORDER.iter().position(|known| *known == name);
        let own = at(&name).unwrap_or_else(|| panic!("crates/{name} has no place in the order"));
        let mut counts = false;
        for line in text.lines() {
            if line.starts_with('[') {
                counts = line.ends_with("dependencies]") && !line.contains("dev-dependencies");
            }
            let Some(used) = line.strip_prefix("pellucid-").filter(|_| counts) else { continue };
            let used = used.split([' ', '.', '=']).next().unwrap_or_default();
            assert!(
                at(used).is_some_and(|used| used < own),
                "crates/{name} uses pellucid-{used}, which isn't below it"
            );
        }
    }
}

#[test]
fn a_circle_is_found() {
    let graph = |pairs: &[(&str, &[&str])]| -> Uses {
        let set = |used: &[&str]| used.iter().map(|word| (*word).to_owned()).collect();
        pairs.iter().map(|(room, used)| ((*room).to_owned(), set(used))).collect()
    };
    assert_eq!(circle(graph(&[("a", &["b", "a", "Error"]), ("b", &["c"]), ("c", &[])])), BTreeSet::new());
    let found = circle(graph(&[("a", &["b"]), ("b", &["c"]), ("c", &["b"]), ("d", &[])]));
    assert_eq!(found.into_iter().collect::<Vec<_>>(), ["b", "c"]);
    let text = "use crate::{Error, io::{self, gpu}, scene};\n// crate::no\nfn f() { crate::atomic::g() }";
    assert_eq!(used(&code(text), &[]).into_iter().collect::<Vec<_>>(), ["Error", "atomic", "io", "scene"]);
    assert_eq!(code("a\n#[cfg(test)]\nmod tests { crate::no }"), "a");
}
