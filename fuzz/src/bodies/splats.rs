//! Gaussian splats in formats of their own.

use super::cloud::read;
use super::with_file;

/// Endings of files.
const ENDINGS: [&str; 6] = ["splat", "ksplat", "spz", "sog", "glb", "gltf"];

/// All formats but PLY. The first byte chooses the file's ending; 6 is the `meta.json` of a folder, whose pictures are
/// one: what is behind the first line.
pub fn splats(input: &[u8]) {
    let Some((&first, content)) = input.split_first() else { return };
    match ENDINGS.get(usize::from(first)) {
        Some(ending) => with_file(&format!("input.{ending}"), content, |path| read(path, None)),
        None => folder(content),
    }
}

/// A folder with a description and one picture, which it may name more than once.
fn folder(content: &[u8]) {
    let mut parts = content.splitn(2, |byte| *byte == b'\n');
    let folder = tempfile::tempdir().expect("a temporary folder");
    for name in ["meta.json", "p.webp"] {
        let content = parts.next().unwrap_or_default();
        std::fs::write(folder.path().join(name), content).expect("room for a temporary file");
    }
    read(folder.path(), None);
}
