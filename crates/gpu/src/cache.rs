//! Small blobs kept on disk between runs: SPIR-V and the driver's pipeline cache.
//!
//! A cache never fails a run: a blob that is unreadable, corrupt or can't be written counts as absent.

use std::io::Write;
use std::path::PathBuf;

const HASH_BYTES: usize = 32;

/// `PELLUCID_CACHE_DIR`, or the user's cache folder.
fn folder(kind: &str) -> Option<PathBuf> {
    let base = match std::env::var_os("PELLUCID_CACHE_DIR") {
        Some(dir) if !dir.is_empty() => PathBuf::from(dir),
        _ => directories::ProjectDirs::from("", "", "pellucid")?.cache_dir().to_path_buf(),
    };
    Some(base.join(kind))
}

/// Returns the blob stored under a key; `None` if it is absent or its checksum does not match.
pub fn load(kind: &str, key: &str) -> Option<Vec<u8>> {
    let data = std::fs::read(folder(kind)?.join(key)).ok()?;
    let (hash, blob) = data.split_at_checked(HASH_BYTES)?;
    (blake3::hash(blob).as_bytes() == hash).then(|| blob.to_vec())
}

/// Stores a blob under a key, whole or not at all.
pub fn store(kind: &str, key: &str, blob: &[u8]) {
    let write = || -> Option<()> {
        let folder = folder(kind)?;
        std::fs::create_dir_all(&folder).ok()?;
        let mut file = tempfile::Builder::new().prefix(".pellucid-").suffix(".tmp").tempfile_in(&folder).ok()?;
        file.write_all(blake3::hash(blob).as_bytes()).ok()?;
        file.write_all(blob).ok()?;
        pellucid_fault::file("cache/rename").ok()?;
        file.persist(folder.join(key)).ok()?;
        Some(())
    };
    write();
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_corrupt_blob_counts_as_absent() {
        let key = format!("test-{}", std::process::id());
        store("test", &key, b"content");
        let path = folder("test").expect("a cache folder").join(&key);
        assert_eq!(load("test", &key).as_deref(), Some(&b"content"[..]));
        let mut data = std::fs::read(&path).expect("the stored file");
        *data.last_mut().expect("not empty") ^= 1;
        std::fs::write(&path, &data).expect("writable");
        assert_eq!(load("test", &key), None);
        std::fs::write(&path, b"short").expect("writable");
        assert_eq!(load("test", &key), None);
        std::fs::remove_file(&path).expect("removable");
    }
}
