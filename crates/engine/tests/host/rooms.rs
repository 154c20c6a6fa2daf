//! The rooms of each crate, which are the modules at its root, use each other in one direction only.

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

/// The first words of all paths that begin with `crate::`.
fn used(code: &str) -> BTreeSet<String> {
    let word = |text: &str| -> String { text.chars().take_while(|c| c.is_ascii_alphanumeric() || *c == '_').collect() };
    let mut found = BTreeSet::new();
    for rest in code.split("crate::").skip(1) {
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

fn read(folder: &Path, room: Option<&str>, uses: &mut Uses) {
    for entry in std::fs::read_dir(folder).expect("a folder of sources") {
        let path = entry.expect("an entry").path();
        let stem = path.file_stem().and_then(|stem| stem.to_str()).unwrap_or_default().to_owned();
        let room = room.unwrap_or(&stem);
        if path.is_dir() {
            read(&path, Some(room), uses);
        } else if path.extension().is_some_and(|e| e == "rs") && !["lib", "main"].contains(&room) {
            let text = std::fs::read_to_string(&path).expect("a source");
            uses.entry(room.to_owned()).or_default().extend(used(&code(&text)));
        }
    }
}

/// The rooms on a circle: those that are left when every room that uses no other one is taken away, again and again.
fn circle(mut uses: Uses) -> BTreeSet<String> {
    let rooms: BTreeSet<String> = uses.keys().cloned().collect();
    for (room, used) in &mut uses {
        used.retain(|other| other != room && rooms.contains(other));
    }
    while let Some(free) = uses.iter().find(|(_, used)| used.is_empty()).map(|(room, _)| room.clone()) {
        uses.remove(&free);
        uses.values_mut().for_each(|used| {
            used.remove(&free);
        });
    }
    uses.into_keys().collect()
}

#[test]
fn no_room_uses_one_that_uses_it() {
    for name in ["engine", "lab", "python"] {
        let mut uses = Uses::new();
        read(&root().join("crates").join(name).join("src"), None, &mut uses);
        assert!(uses.len() > 2, "{name}: {uses:?}");
        assert_eq!(
            circle(uses),
            BTreeSet::new(),
            "rooms of crates/{name} that use each other in a circle, or use such rooms"
        );
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
    assert_eq!(found.into_iter().collect::<Vec<_>>(), ["a", "b", "c"]);
    let text = "use crate::{Error, io::{self, gpu}, scene};\n// crate::no\nfn f() { crate::atomic::g() }";
    assert_eq!(used(&code(text)).into_iter().collect::<Vec<_>>(), ["Error", "atomic", "io", "scene"]);
    assert_eq!(code("a\n#[cfg(test)]\nmod tests { crate::no }"), "a");
}
