//! Every pass with the first sentence of its comment, every fill and every copy: docs/internals/passes.md, a page that
//! only the book has (tools/book.sh).

use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::fs;
use std::path::Path;

const CRATE: &str = env!("CARGO_MANIFEST_DIR");

const INTRODUCTION: &str = "\
# Passes

A pass is named `method/stage`, as in `plan`, `profile`, `--profile` and `--trace`. `pellucid plan` lists the passes of a frame in the order
of their first run; here they stand in alphabetical order. The shader of a pass is `crates/engine/shaders/<name>.wgsl` with `-` as `_`, unless
its declaration names another file. Fills and copies have no shader. The comment at each declaration says more.

A *walker* visits pixels: of splats in dispatches, or in draws with `raster = \"hardware\"`; of soft spheres, and of the points of ensembles, in
dispatches alone.

Several passes share how they visit splats, pixels and long lists: see [stages.md](stages.md).

| pass | kind | one run |
|---|---|---|
";

/// Fills, copies and second names of passes have no declaration with a comment; their sentences stand here.
const UNDECLARED: [(&str, &str, &str); 27] = [
    ("abuffer/clear", "fill", "Sets counts, longest list and overflow flag to 0."),
    ("abuffer/cursors", "copy", "Copies the start of each pixel's list to the cursor that `abuffer/store` counts up."),
    ("abuffer/summary", "copy", "Copies overflow, longest list and total to the host, which then cuts bands."),
    ("bin/clear", "fill", "Sets tile counters, longest list and overflow flag to 0."),
    ("bin/summary", "copy", "Copies overflow, number of entries and longest list to the host."),
    ("image/clear", "fill", "Empties the pixels, so that those without fragments stay empty."),
    (
        "image/read-back",
        "copy",
        "Copies the outputs of the window that are wanted to the host: colors, as floats or as the bytes of a PNG, and depths.",
    ),
    (
        "image-space/clear",
        "fill",
        "Sets nearest points to \"nothing\" and the numbers of listed tiles to 0, and fills the one pixel that stands for everything outside of the image.",
    ),
    ("image-space/summary", "copy", "Copies the number of tiles that each filter had to the host."),
    ("linked-list/clear", "fill", "Sets the heads of the band's lists to \"none\", and the counter of nodes to 0."),
    ("peel/clear", "fill", "Sets last ranks and counts to 0, and smallest ranks to \"nothing\"."),
    ("peel/summary", "copy", "Copies the number of layers to the host."),
    ("peel-layers/clear", "fill", "Sets counts of layers to 0, where they are asked for."),
    (
        "peel-layers/next",
        "dispatch",
        "Runs `peel/next` once the points of a layer are measured: a layer without a point empties its own filters and everything that follows.",
    ),
    ("peel-layers/summary", "copy", "Copies the number of layers to the host."),
    ("profile/copy", "copy", "Copies a buffer to find the copy rate of the device; no part of a frame."),
    ("profile/fill", "fill", "Fills the buffer of `profile/copy`; no part of a frame."),
    ("radix/clear", "fill", "Sets the digits' counters to 0."),
    ("shading/depths", "copy", "Copies depths of the whole image back to the device, row after row of it."),
    ("shading/factors", "copy", "Copies the factors of `shading/edl` to the host, which multiplies colors by them."),
    ("shadows/clear", "fill", "Sets a light's image to \"nothing\"."),
    ("shadows/reset", "fill", "Sets the blocks of a light's image to \"nothing\", and the numbers of its holes to 0."),
    (
        "spbr/clear",
        "fill",
        "Sets planes of ensembles to \"nothing\", again when there are no epochs left, and clears sums, depths, counters and the number of large squares.",
    ),
    ("spbr/summary", "copy", "Copies the number of drawn points to the host."),
    (
        "spbr/upload",
        "copy",
        "Copies points to the device before the dispatches over them, where the device has no room for all of them.",
    ),
    (
        "project/clear",
        "fill",
        "Sets the statistics of the projection to 0, and for opaque methods all pixels to \"nothing\".",
    ),
    ("project/stats", "copy", "Copies the numbers of visible and large splats, and of their tiles, to the host."),
];

/// A declaration by `pass!`.
struct Declared {
    name: String,
    /// Shader file of the pass, under shaders/ and without `.wgsl`.
    stem: String,
    comment: String,
}

impl Declared {
    /// Reads those of the source behind `pass! {`.
    fn read(source: &str) -> Vec<Self> {
        let block = source.split("\n}\n").next().unwrap_or_default();
        let (mut found, mut comment) = (Vec::new(), String::new());
        for line in block.lines().map(str::trim) {
            if let Some(text) = line.strip_prefix("///") {
                comment += text;
                continue;
            }
            let comment = std::mem::take(&mut comment);
            if line.contains(" = \"") {
                let name = line.split('"').nth(1).unwrap_or_else(|| panic!("{line}: no name"));
                let stem = line.split_once(" in \"").and_then(|(_, rest)| rest.split('"').next()).unwrap_or(name);
                found.push(Self { name: name.to_owned(), stem: stem.to_owned(), comment });
            }
        }
        assert!(!found.is_empty(), "{source}: nothing is declared");
        found
    }

    /// Returns how it reaches the device.
    fn kind(&self) -> &'static str {
        let path = Path::new(CRATE).join("shaders").join(&self.stem).with_extension("wgsl");
        let shader = fs::read_to_string(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
        let visits = shader.contains("#walker") && shader.contains("fn visit(");
        match (visits, shader.contains("@fragment")) {
            (true, _) => "walker",
            (_, true) => "draw",
            _ => "dispatch",
        }
    }
}

/// The sources of the crate.
fn sources() -> String {
    let mut found = String::new();
    read_folder(&Path::new(CRATE).join("src"), &mut found);
    found
}

fn read_folder(folder: &Path, found: &mut String) {
    let mut paths: Vec<_> = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    paths.sort();
    for path in paths {
        if path.is_dir() {
            read_folder(&path, found);
        } else if path.file_name().is_some_and(|name| name != "passes_page.rs") {
            found.push_str(&fs::read_to_string(path).unwrap());
        }
    }
}

/// Every pass that the sources declare.
fn declared(sources: &str) -> Vec<Declared> {
    sources.split("\npass! {\n").skip(1).flat_map(Declared::read).collect()
}

/// The first sentence of a comment, in one line.
fn first_sentence(comment: &str) -> String {
    let line = comment.split_whitespace().collect::<Vec<_>>().join(" ");
    let end = line.find(". ").map_or(line.len(), |end| end + 1);
    line[..end].to_owned()
}

fn page() -> String {
    let declared = declared(&sources());
    let declared = declared.into_iter().map(|pass| (pass.name.clone(), pass.kind(), first_sentence(&pass.comment)));
    let undeclared = UNDECLARED.map(|(name, kind, text)| (name.to_owned(), kind, text.to_owned()));
    let mut rows: Vec<_> = declared.chain(undeclared).collect();
    rows.sort();
    let mut page = INTRODUCTION.to_owned();
    for (name, kind, text) in rows {
        let _ = writeln!(page, "| `{name}` | {kind} | {} |", text.replace('|', "\\|"));
    }
    page
}

#[test]
fn the_book_has_every_pass() {
    let page = page();
    assert!(page.contains("| `abuffer/store` | walker |") && page.contains("| `abuffer/clear` | fill |"), "{page}");
    pellucid_testing::add_to_book("docs/internals/passes.md", &page);
}

#[test]
fn every_pass_has_a_sentence() {
    let declared = declared(&sources());
    assert!(declared.len() > 90, "{}", declared.len());
    for pass in declared {
        let sentence = first_sentence(&pass.comment);
        assert!(sentence.ends_with('.') && sentence.starts_with(char::is_uppercase), "{}: {sentence:?}", pass.name);
    }
}

/// The stems of the shader files in a folder.
fn stems(folder: &Path) -> BTreeSet<String> {
    let paths = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    paths.map(|path| path.file_stem().unwrap().to_str().unwrap().to_owned()).collect()
}

#[test]
fn every_shader_belongs_to_a_pass_on_the_page() {
    let known: BTreeSet<String> = declared(&sources()).into_iter().map(|pass| pass.stem).collect();
    for entry in fs::read_dir(Path::new(CRATE).join("shaders")).unwrap() {
        let folder = entry.unwrap();
        let method = folder.file_name().into_string().unwrap();
        if method == "shared" {
            continue;
        }
        // The vertex shader of all draws is no pass.
        for stage in stems(&folder.path()).iter().filter(|stage| *stage != "quad.vert") {
            assert!(known.contains(&format!("{method}/{stage}")), "{method}/{stage} is declared by no pass");
        }
    }
}

/// Every string literal of a source that has the form of a pass's name.
fn names_in(source: &str) -> impl Iterator<Item = &str> {
    let quoted = source
        .lines()
        .filter(|line| !line.trim_start().starts_with("//"))
        .flat_map(|line| line.split('"').skip(1).step_by(2));
    quoted.filter(|text| {
        let plain = |part: &str| {
            !part.is_empty() && part.chars().all(|c| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-')
        };
        text.split_once('/').is_some_and(|(method, stage)| plain(method) && plain(stage))
    })
}

#[test]
fn the_page_has_every_name_that_the_code_uses_and_no_other() {
    let text = sources();
    let used: BTreeSet<&str> = names_in(&text).collect();
    let declared = declared(&text);
    let names = declared.iter().map(|pass| pass.name.as_str());
    let known: BTreeSet<&str> = names.chain(UNDECLARED.iter().map(|(name, ..)| *name)).collect();
    for (name, ..) in UNDECLARED {
        assert!(used.contains(name), "{name} is on the page, but nothing is called so");
    }
    let methods: BTreeSet<&str> = known.iter().filter_map(|name| name.split('/').next()).collect();
    for name in used.iter().filter(|name| methods.contains(name.split('/').next().unwrap_or_default())) {
        // Kernels for lists of different lengths are one pass.
        let pass = name.trim_end_matches(|c: char| c.is_ascii_digit()).trim_end_matches('-');
        let is_file = declared.iter().any(|pass| pass.stem == *name);
        assert!(known.contains(name) || known.contains(pass) || is_file, "{name} is missing in UNDECLARED");
    }
}
