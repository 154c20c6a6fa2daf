//! The files that a cloud consists of, where it is more than one.

use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

use serde_json::Value;

use crate::{splats, store};

/// Bytes of a text that is searched for names of other files, at most.
const MAX_BYTES: u64 = 1 << 26;

/// Bytes of a binary glTF file before its text.
const GLB_HEADER: usize = 20;

/// Returns the other files of the cloud at a path: all files of a store or of splats in a folder, and those that the
/// text of SOG splats or of a glTF file names. A folder stands for everything in it. Files that can't be read have no
/// parts; whoever reads the cloud says so.
pub(crate) fn of(path: &Path) -> Vec<PathBuf> {
    let folder = if path.is_dir() { path } else { pellucid_core::atomic::folder(path) };
    if store::is_folder(path) {
        return store::FILES.iter().map(|name| folder.join(name)).filter(|part| part.exists()).collect();
    }
    let text = if splats::is_folder(path) { folder.join(splats::META) } else { path.to_owned() };
    let mut parts = named(&text, folder);
    if path.is_dir() && text.is_file() {
        parts.push(text);
    }
    parts
}

/// Returns the files beside a text that it names.
fn named(text: &Path, folder: &Path) -> Vec<PathBuf> {
    let extension = text.extension().and_then(|extension| extension.to_str()).map(str::to_lowercase);
    let is_sog = text.file_name().is_some_and(|name| name == splats::META);
    let content = match extension.as_deref() {
        _ if is_sog => start(text, MAX_BYTES),
        Some("gltf") => start(text, MAX_BYTES),
        Some("glb") => start(text, GLB_HEADER as u64).and_then(|header| {
            let bytes = header.get(12..16)?.try_into().ok()?;
            start(text, GLB_HEADER as u64 + u64::from(u32::from_le_bytes(bytes)).min(MAX_BYTES))
        }),
        _ => None,
    };
    let skipped = if extension.as_deref() == Some("glb") { GLB_HEADER } else { 0 };
    let Some(value) = content.as_deref().and_then(|bytes| serde_json::from_slice(bytes.get(skipped..)?).ok()) else {
        return Vec::new();
    };
    let mut names = Vec::new();
    strings(&value, &mut names);
    names.into_iter().map(|name| folder.join(name)).filter(|part| part.is_file()).collect()
}

fn start(path: &Path, bytes: u64) -> Option<Vec<u8>> {
    let mut content = Vec::new();
    // A pipe could be read only once.
    path.is_file().then(|| File::open(path).ok()).flatten()?.take(bytes).read_to_end(&mut content).ok()?;
    Some(content)
}

/// Collects all texts of a JSON value that may be names of files, as they are and without the escapes of a URI.
fn strings(value: &Value, names: &mut Vec<String>) {
    match value {
        Value::String(text) if text.len() < 4096 && !text.starts_with("data:") => {
            names.extend(splats::decoded(text).filter(|name| name != text));
            names.push(text.clone());
        }
        Value::Array(items) => items.iter().for_each(|item| strings(item, names)),
        Value::Object(entries) => entries.values().for_each(|item| strings(item, names)),
        _ => {}
    }
}
