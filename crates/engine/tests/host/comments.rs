//! Style of comments: documentation says what an item is or does in a sentence that stands alone, and lines fit 120
//! columns.

use std::path::Path;

use pellucid_testing::root;

/// Most columns of a line that is a comment, indentation included.
const COLUMNS: usize = 120;
/// Words that no documentation begins with: in an index or a hover nothing stands before them that they could refer to.
const OPENINGS: &[&str] = &[
    "As", "At", "Beside", "Besides", "By", "For", "From", "In", "It", "Its", "Of", "On", "One by", "One for", "One of",
    "One per", "One that", "One with", "Such", "That", "The same", "Their", "Them", "These", "They", "This", "Those",
    "To", "What", "Whether", "Which", "Who", "Whom", "Whose", "With",
];
/// Words that no other comment begins with either.
const QUESTIONS: &[&str] = &["What", "Whether"];
/// Headings whose sections begin with a sentence that stands alone as well.
const HEADINGS: &[&str] = &["# Errors", "# Panics"];

/// Attributes that make the documentation before them a help text, which is shown under the name of an argument.
const HELP: &[&str] = &["#[arg", "#[command"];

/// Returns the marker of a line that is a comment, and the text behind it.
fn comment<'a>(line: &'a str, extension: &str) -> Option<(&'static str, &'a str)> {
    let markers: &[&'static str] = match extension {
        "rs" | "wgsl" => &["///", "//!", "//"],
        _ => &["#"],
    };
    let line = line.trim();
    markers.iter().find_map(|marker| line.strip_prefix(*marker).map(|text| (*marker, text.trim())))
}

/// Returns `true` if `text` begins with one of `words`, and not with a longer word, as "In-place" is.
fn begins_with(text: &str, words: &[&str]) -> bool {
    let ends = |rest: &str| !rest.starts_with(|c: char| c.is_alphanumeric() || c == '_' || c == '-');
    words.iter().any(|word| text.strip_prefix(*word).is_some_and(ends))
}

/// Returns `true` if the lines begin with documentation that is directly followed by an attribute of [`HELP`].
fn is_help(lines: &[&str]) -> bool {
    let next = lines.iter().map(|line| line.trim()).find(|line| !line.starts_with("///"));
    next.is_some_and(|line| HELP.iter().any(|attribute| line.starts_with(attribute)))
}

/// Finds comments that break a rule: number of the line, from 1, and the line with the rule. Only lengths matter where
/// comments begin with `#`, and in help texts. A line of a single word, as of an address, can't be wrapped and may be
/// long.
fn offenders(text: &str, extension: &str) -> Vec<(usize, String)> {
    let mut found = Vec::new();
    let lines: Vec<&str> = text.lines().collect();
    let mut last = "";
    let mut opens = false;
    for (at, line) in lines.iter().copied().enumerate() {
        let Some((marker, said)) = comment(line, extension) else {
            last = "";
            continue;
        };
        if line.chars().count() > COLUMNS && said.contains(' ') {
            found.push((at + 1, format!("over {COLUMNS} columns: {}", line.trim())));
        }
        opens |= marker != last;
        last = marker;
        if marker == "#" || said.is_empty() {
            continue;
        }
        let words = if marker == "//" { QUESTIONS } else { OPENINGS };
        if opens && begins_with(said, words) && !(marker == "///" && is_help(&lines[at..])) {
            found.push((at + 1, format!("doesn't stand alone: {}", line.trim())));
        }
        opens = marker != "//" && HEADINGS.contains(&said);
    }
    found
}

/// Adds the offenders of all sources in a folder, as `path:line: why`; returns the number of sources.
fn read(folder: &Path, found: &mut Vec<String>) -> usize {
    let mut sources = 0;
    for entry in std::fs::read_dir(folder).expect("a folder of sources") {
        let path = entry.expect("an entry").path();
        let name = path.file_name().and_then(|name| name.to_str()).unwrap_or_default();
        let extension = path.extension().and_then(|extension| extension.to_str()).unwrap_or_default();
        if path.is_dir() {
            if !name.starts_with('.') && !["target", "node_modules", "__pycache__"].contains(&name) {
                sources += read(&path, found);
            }
        } else if ["rs", "wgsl", "sh", "toml", "py"].contains(&extension) {
            let text = std::fs::read_to_string(&path).expect("a source");
            let lines = offenders(&text, extension).into_iter();
            found.extend(lines.map(|(line, why)| format!("{}:{line}: {why}", path.display())));
            sources += 1;
        }
    }
    sources
}

#[test]
fn comments_stand_alone_and_fit_their_lines() {
    let mut found = Vec::new();
    for folder in ["crates", "tools"] {
        let sources = read(&root().join(folder), &mut found);
        assert!(sources > 10, "{folder}: {sources} sources");
    }
    found.sort();
    assert!(found.is_empty(), "{} comments break the style:\n{}", found.len(), found.join("\n"));
}

/// Returns the lines of offenders in a Rust file.
fn lines_of(text: &str) -> Vec<usize> {
    offenders(text, "rs").into_iter().map(|(line, _)| line).collect()
}

#[test]
fn planted_words_are_found() {
    for opening in OPENINGS {
        assert_eq!(lines_of(&format!("    /// {opening} a frame.\nfn f() {{}}")), [1], "{opening}");
        assert_eq!(lines_of(&format!("//! {opening}, and more.")), [1], "{opening}");
    }
    assert_eq!(lines_of("/// It's one."), [1]);
    // The first sentence counts, however the comment is divided, and the first one behind a heading.
    assert_eq!(lines_of("///\n/// Those of a frame."), [2]);
    assert_eq!(lines_of("// Plain.\n/// They, by chunk."), [2]);
    assert_eq!(lines_of("/// Renders.\n///\n/// # Errors\n/// Those of rendering."), [4]);
    assert_eq!(lines_of("/// Renders.\n///\n/// # Errors\n///\n/// Those of rendering."), [5]);
    assert_eq!(lines_of("/// A number.\nn: u32,\n/// Its unit.\nunit: u32,"), [3]);
    assert_eq!(lines_of("// What is kept.\n// Whether it is.\nlet a = 1;\n// Whether it is."), [1, 4]);
    // Only an attribute of an argument, directly behind it, makes documentation a help text.
    assert_eq!(lines_of("/// With --deep: type of color.\ndeep: bool,"), [1]);
    assert_eq!(lines_of("/// With --deep: type of color.\n#[serde(skip)]\ndeep: bool,"), [1]);
    assert_eq!(lines_of("/// With --deep: type of color.\n\n#[arg(long)]\ndeep: bool,"), [1]);
    assert_eq!(lines_of("// What it is.\n#[arg(long)]\ndeep: bool,"), [1]);
    assert_eq!(offenders("// What remains.\nfn f() {}", "wgsl").len(), 1);
}

#[test]
fn planted_long_lines_are_found() {
    let text = "a ".repeat(COLUMNS);
    for (marker, extension) in [("///", "rs"), ("//!", "rs"), ("//", "wgsl"), ("#", "sh"), ("#", "toml")] {
        let line = |columns: usize| -> String {
            let begin: String = format!("{marker} {text}").chars().take(columns - 1).collect();
            format!("{begin}é")
        };
        let count = |text: &str| offenders(text, extension).len();
        assert_eq!(count(&line(COLUMNS)), 0, "{marker}");
        assert_eq!(count(&format!("b\n{}", line(COLUMNS + 1))), 1, "{marker}");
        assert_eq!(count(&format!("    {}", line(COLUMNS - 3))), 1, "{marker}");
    }
}

#[test]
fn other_comments_are_let_through() {
    for text in [
        "/// In-place sort of a list.",
        "/// Forward axis.",
        "/// `From` a type.",
        "/// One uniform color.",
        "/// Renders.\n/// From there it goes on: only the first line counts.",
        "    /// With --deep: type of color.\n    ///\n    /// More.\n    #[arg(long)]\n    deep: bool,",
        "/// For tests.\n#[command(flatten)]\nchoice: Choice,",
        "// They are plain comments.",
        "// In these only questions count.",
        "let a = \"/// Those of rendering.\";",
    ] {
        assert!(lines_of(text).is_empty(), "{text}");
    }
    assert!(lines_of(&format!("// https://{}", "a".repeat(COLUMNS))).is_empty());
    assert!(lines_of(&"let a = 1; ".repeat(COLUMNS)).is_empty());
    assert!(offenders("# What this does.", "sh").is_empty());
}

#[test]
fn every_script_names_its_interpreter() {
    let scripts =
        std::fs::read_dir(root().join("tools")).expect("the tools").map(|entry| entry.expect("a tool").path());
    let scripts: Vec<_> = scripts.filter(|path| path.extension().is_some_and(|extension| extension == "sh")).collect();
    assert!(scripts.len() > 5, "{scripts:?}");
    for script in scripts {
        let text = std::fs::read_to_string(&script).expect("a script");
        assert!(text.starts_with("#!/usr/bin/env bash\n"), "{}", script.display());
    }
}
