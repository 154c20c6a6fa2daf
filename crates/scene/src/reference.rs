//! The reference of the scene file and the table of methods, written from the table of keys. The tests here fail where
//! a document is stale, and rewrite it where `PELLUCID_UPDATE` is 1.

use std::fmt::Write as _;
use std::path::Path;

use super::{Family, Key, METHODS, Method, MethodChoice, ValueKind, tables};

const REWRITE: &str = "PELLUCID_UPDATE=1 cargo test -p pellucid-scene --lib reference";

const INTRODUCTION: &str = "\
# The scene file

<!-- Generated: see crates/scene/src/reference.rs. -->

A scene is a TOML file. Only `[[cloud]]` with its `path` must be there:

```toml
[[cloud]]
path = \"scan.laz\"
opacity = 0.3

[method]
name = \"abuffer\"
shape = \"oriented\"
```

`--set KEY=VALUE` gives any key by its dotted path and wins over the file: `--set method.shape=flat`, `--set cloud.0.opacity=0.2` for
the first cloud, `--set cloud.*.opacity=0.2` for all. A key that no table has is an error with its line and column, and so is a value
out of range. A key of a method that is not in force is a warning, since `--method` may change the method. Paths are relative to
the folder of the scene file. Numbers may be written as integers; NaN and infinities are errors.
";

const METHOD: &str = "
## `[method]`

`name` is `\"auto\"` by default: the exact method that suits the scene. Methods of one family draw the same things, each in
its way.

";

fn scene_file() -> String {
    let mut text = INTRODUCTION.to_owned();
    for table in tables() {
        let about = match table.path {
            "image" => "The picture.",
            "camera" => "All of it is optional: by default all points that are drawn are in view.",
            "cloud.*" => "One or more. Positions become scale · p + translate, in float64.",
            "clip.*" => {
                "Any number of them. A point is drawn if each keeps its center; borders are kept. Points that are cut off still \
                 count for bounds, percentiles, radii and normals, but an automatic camera frames the others."
            }
            "shading" => "Points without normals are not shaded.",
            "detail" => {
                "Levels of detail: a picture without the points that are finer than it can show ([large-clouds.md](large-clouds.md))."
            }
            _ => "Opaque points and surfaces take shadows of a light with a direction or a position.",
        };
        let rows: Vec<_> = table.keys.into_iter().map(|key| (key, String::new())).collect();
        let _ = write!(text, "\n## `{}`\n\n{about}\n\n{}", table.title, keys_table(&rows, false));
    }
    text.push_str(METHOD);
    text.push_str(&methods_table());
    text.push_str("\nThe keys beside `name`:\n\n");
    text.push_str(&keys_table(&method_keys(), true));
    text
}

/// Every key of every method, with the methods that have just this one.
fn method_keys() -> Vec<(Key, String)> {
    let mut rows: Vec<(Key, String)> = Vec::new();
    for name in METHODS {
        for key in MethodChoice::named(name).iter().flat_map(MethodChoice::keys) {
            match rows.iter_mut().find(|(known, _)| *known == key) {
                Some((_, methods)) => {
                    let _ = write!(methods, ", `{name}`");
                }
                None => rows.push((key, format!("`{name}`"))),
            }
        }
    }
    rows.sort_by_key(|(key, _)| key.name);
    rows
}

fn keys_table(rows: &[(Key, String)], methods: bool) -> String {
    let mut text = String::from(if methods {
        "| key | values | default | | methods |\n"
    } else {
        "| key | values | default | |\n"
    });
    text.push_str(if methods { "|---|---|---|---|---|\n" } else { "|---|---|---|---|\n" });
    for (key, owners) in rows {
        let unit = if key.unit.is_empty() { String::new() } else { format!(", {}", key.unit) };
        let default = match (&key.value, key.without) {
            (Some(value), _) => format!("`{value}`"),
            (None, "") => "none: it must be given".to_owned(),
            (None, without) => without.to_owned(),
        };
        let _ = write!(text, "| `{}` | {}{unit} | {default} | {} |", key.name, key.kind, about(key));
        text.push_str(&if methods { format!(" {owners} |\n") } else { "\n".to_owned() });
    }
    text
}

/// The description of a key, and of each of its words.
fn about(key: &Key) -> String {
    let words = if let ValueKind::Words(words) | ValueKind::WordsOr(words, _) = key.kind { words } else { &[] };
    let words = words.iter().map(|word| format!("<br>`{}`: {}", word.name, word.about));
    std::iter::once(key.about.to_owned()).chain(words).collect()
}

fn methods_table() -> String {
    let mut text = "| method | draws | keys |\n|---|---|---|\n".to_owned();
    for family in Family::ALL {
        let _ = writeln!(text, "| **{}** | | |", family.title());
        for method in family.methods() {
            let keys: Vec<_> = method.keys().iter().map(|key| format!("`{}`", key.name)).collect();
            let _ = writeln!(text, "| `{}` | {} | {} |", method.name(), method.about(), keys.join(", "));
        }
    }
    text
}

/// Fails if a document isn't what it should be, or rewrites it.
fn check(document: &str, written: impl FnOnce(&str) -> String) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").join(document);
    let found = std::fs::read_to_string(&path).unwrap_or_default();
    let wanted = written(&found);
    if pellucid_testing_host::updates() {
        std::fs::write(&path, wanted).unwrap();
    } else {
        assert!(found == wanted, "{document} is stale; this rewrites it: {REWRITE}");
    }
}

#[test]
fn the_reference_of_the_scene_file_is_that_of_the_keys() {
    check("docs/scene-file.md", |_| scene_file());
}

#[test]
fn the_table_of_methods_is_that_of_the_methods() {
    let (begin, end) = ("<!-- methods: generated -->\n", "<!-- methods: end -->");
    check("docs/methods.md", |found| {
        let (before, rest) =
            found.split_once(begin).expect("docs/methods.md has a marker where its table of methods begins");
        let (_, after) = rest.split_once(end).expect("docs/methods.md has a marker where its table of methods ends");
        format!("{before}{begin}{}{end}{after}", methods_table())
    });
}

#[test]
fn every_method_and_every_key_has_a_sentence() {
    let keys = tables().into_iter().flat_map(|table| table.keys);
    let methods = Method::all();
    for key in keys.chain(methods.iter().flat_map(Method::keys)) {
        assert!(key.about.ends_with('.') && key.about.starts_with(char::is_uppercase), "{}: {:?}", key.name, key.about);
    }
    for method in &methods {
        assert!(method.about().ends_with('.'), "{}", method.name());
        assert!(method.family().methods().any(|other| other.name() == method.name()));
    }
}
