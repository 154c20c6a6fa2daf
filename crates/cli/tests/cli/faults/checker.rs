//! Says what is half-written, and is itself tested on what is.

use std::ffi::OsStr;
use std::fs;
use std::path::Path;

use pellucid_core::progress::Progress;

use super::{CASES, Files, cases, done, files, place, put_old};

/// True if this is the name of a temporary file.
pub fn is_temporary(path: &Path) -> bool {
    let name = path.file_name().and_then(OsStr::to_str).unwrap_or_default();
    name.starts_with(".pellucid-") && name.ends_with(".tmp")
}

/// Changes that a failed command may leave.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Allowed {
    /// Nothing.
    Nothing,
    /// New files, if they are whole.
    NewOrOld,
    /// New files, if they are whole, and temporary files.
    Leftovers,
}

/// The faults of a folder after a command failed in it.
pub fn complaints(before: &Files, after: &Files, allowed: Allowed) -> Vec<String> {
    let mut found = Vec::new();
    for path in before.keys().filter(|path| !after.contains_key(*path)) {
        found.push(format!("{} is gone", path.display()));
    }
    for (path, bytes) in after.iter().filter(|(path, bytes)| before.get(*path) != Some(bytes)) {
        let name = path.display();
        if is_temporary(path) {
            if allowed != Allowed::Leftovers {
                found.push(format!("{name} is left"));
            }
        } else if allowed == Allowed::Nothing {
            found.push(format!("{name} is new or changed"));
        } else if let Err(why) = is_whole(path, bytes) {
            found.push(format!("{name} is not whole: {why}"));
        }
    }
    found
}

/// Checks that a file is complete and has the format of its name.
pub fn is_whole(path: &Path, bytes: &[u8]) -> Result<(), String> {
    let text = || std::str::from_utf8(bytes).map_err(|error| error.to_string());
    let ends = |end: &str| if text()?.trim_end().ends_with(end) { Ok(()) } else { Err(format!("no {end} at its end")) };
    let folder = tempfile::tempdir().unwrap();
    let copy = folder.path().join(path.file_name().unwrap_or_default());
    fs::write(&copy, bytes).unwrap();
    match path.extension().and_then(OsStr::to_str) {
        Some("png") => {
            // The picture may be there though the end of the file isn't.
            if !bytes.ends_with(b"IEND\xaeB`\x82") {
                return Err("no end".to_owned());
            }
            pellucid_io::output::read_image(&copy).map(drop).map_err(|error| error.to_string())
        }
        Some("exr") if is_deep(bytes) => deep_ends(bytes)
            .filter(|end| *end == bytes.len())
            .map_or_else(|| Err("its rows don't end where it does".to_owned()), |_| Ok(())),
        Some("exr") => pellucid_io::output::read_image(&copy).map(drop).map_err(|error| error.to_string()),
        Some("ply") => pellucid_io::load(&copy, &Progress::hidden()).map(drop).map_err(|error| error.to_string()),
        Some("json") => serde_json::from_slice::<serde_json::Value>(bytes).map(drop).map_err(|error| error.to_string()),
        Some("toml") if !text()?.ends_with('\n') => Err("no end of its last line".to_owned()),
        Some("toml") => toml::from_str::<toml::Table>(text()?).map(drop).map_err(|error| error.to_string()),
        Some("html") => ends("</html>"),
        Some("svg") => ends("</svg>"),
        Some("csv") => {
            let mut reader = csv::Reader::from_reader(bytes);
            let rows = reader.records().collect::<Result<Vec<_>, _>>().map_err(|error| error.to_string())?;
            if rows.is_empty() || !bytes.ends_with(b"\n") { Err("no end of its last line".to_owned()) } else { Ok(()) }
        }
        _ => Err("nobody knows what this is".to_owned()),
    }
}

/// True if the version of an EXR says that it holds samples (bit 11).
fn is_deep(bytes: &[u8]) -> bool {
    bytes.get(4..8).is_some_and(|version| version[1] & 8 != 0)
}

/// Returns the offset at which the last row of a deep EXR ends, by the table of its rows, all of which must be in it.
/// The header is a list of name, type, length and value, up to an empty name; a row is its number, three lengths, and
/// as many bytes as the first two say.
fn deep_ends(bytes: &[u8]) -> Option<usize> {
    let number = |at: usize| Some(u32::from_le_bytes(bytes.get(at..at + 4)?.try_into().ok()?) as usize);
    let long = |at: usize| usize::try_from(u64::from_le_bytes(bytes.get(at..at + 8)?.try_into().ok()?)).ok();
    let (mut at, mut rows) = (8, 0);
    while *bytes.get(at)? != 0 {
        let word = |from: usize| Some(from + bytes.get(from..)?.iter().position(|byte| *byte == 0)?);
        let name = at..word(at)?;
        let value = word(name.end + 1)? + 5;
        if &bytes[name] == b"chunkCount" {
            rows = number(value)?;
        }
        at = value + number(value - 4)?;
    }
    let offsets: Vec<usize> = (0..rows).map(|row| long(at + 1 + 8 * row)).collect::<Option<_>>()?;
    let last = offsets.iter().copied().max().filter(|_| offsets.iter().all(|offset| *offset > at))?;
    Some(last + 28 + long(last + 4)? + long(last + 12)?)
}

#[test]
fn half_written_files_are_noticed() {
    for case in cases() {
        let folder = place();
        let whole = done(folder.path(), case);
        for (path, bytes) in &whole {
            assert_eq!(is_whole(path, bytes), Ok(()), "{}", path.display());
            for cut in [0, 1, bytes.len() / 2, bytes.len() - 2] {
                let mut after = whole.clone();
                after.insert(path.clone(), bytes[..cut].to_vec());
                for allowed in [Allowed::Nothing, Allowed::NewOrOld, Allowed::Leftovers] {
                    let found = complaints(&whole, &after, allowed);
                    assert_eq!(found.len(), 1, "{} cut at {cut} of {}: {found:?}", path.display(), bytes.len());
                }
            }
        }
    }
}

#[test]
fn leftover_missing_and_changed_files_are_noticed() {
    let folder = place();
    put_old(folder.path(), CASES[0]);
    let before = files(&folder.path().join("out"));
    assert_eq!(complaints(&before, &before, Allowed::Nothing), [""; 0]);
    let with = |name: &str, content: &str| {
        let mut after = before.clone();
        after.insert(name.into(), content.as_bytes().to_vec());
        after
    };
    for name in [".pellucid-Ab12.tmp", "deep/.pellucid-x.tmp"] {
        let after = with(name, "half");
        assert_eq!(complaints(&before, &after, Allowed::Nothing).len(), 1);
        assert_eq!(complaints(&before, &after, Allowed::NewOrOld).len(), 1);
        assert_eq!(complaints(&before, &after, Allowed::Leftovers).len(), 0);
    }
    // A name that nobody would know for a temporary one.
    assert_eq!(complaints(&before, &with(".tmpAb12", ""), Allowed::Leftovers).len(), 1);
    let other = with("scene.toml", "a = 1\n");
    assert_eq!(complaints(&before, &other, Allowed::Nothing), ["scene.toml is new or changed"]);
    assert_eq!(complaints(&before, &other, Allowed::NewOrOld), [""; 0]);
    let mut gone = before.clone();
    gone.pop_first();
    assert_eq!(complaints(&before, &gone, Allowed::Leftovers).len(), 1);
}
