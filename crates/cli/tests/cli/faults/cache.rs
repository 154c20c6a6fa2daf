//! Caches that are of no use: the same picture, and not a word.

use std::fs;
use std::path::Path;
use std::process::Command;

use pellucid_testing::shader_cache;
use tempfile::TempDir;

use super::{command, files, has_device, place, text};

/// A picture by several shaders that compile soon.
const RENDER: [&str; 9] =
    ["render", "in/scene.toml", "-q", "--size", "40x30", "--method", "weighted", "-o", "out/a.exr"];

/// Renders with a cache; the picture, after a run without a word.
fn picture(folder: &TempDir, cache: &Path) -> Vec<u8> {
    let run = command(folder.path(), &RENDER);
    picture_of(run, folder, cache)
}

fn picture_of(mut run: Command, folder: &TempDir, cache: &Path) -> Vec<u8> {
    let output = run.env("PELLUCID_VALIDATION", "1").env("PELLUCID_CACHE_DIR", cache).output().unwrap();
    let what = cache.display();
    assert_eq!((output.status.code(), text(&output.stderr).as_str()), (Some(0), ""), "{what}");
    let out = folder.path().join("out");
    assert_eq!(fs::read_dir(&out).unwrap().count(), 1, "{what}");
    fs::read(out.join("a.exr")).unwrap()
}

#[test]
fn no_cache_changes_a_picture() {
    if !has_device() {
        return;
    }
    let folder = place();
    let cache = folder.path().join("cache");
    // Neither this program nor the driver has anything cached.
    let mut cold = command(folder.path(), &RENDER);
    cold.env("MESA_SHADER_CACHE_DIR", folder.path().join("driver"));
    let wanted = picture_of(cold, &folder, &cache);
    assert!(picture(&folder, &shader_cache()) == wanted, "caches that other tests filled");
    let kept = files(&cache);
    let of_kind = |kind: &str| kept.keys().filter(|path| path.starts_with(kind)).count();
    assert!(of_kind("spirv") > 3 && of_kind("pipelines") == 1, "something was kept: {:?}", kept.keys());
    assert!(picture(&folder, &cache) == wanted, "found again");

    // Cut short, changed, changed behind the checksum, empty, something else, and folders in the place of files.
    let damages: [fn(&Path, &[u8]); 6] = [
        |path, bytes| fs::write(path, &bytes[..bytes.len() / 2]).unwrap(),
        |path, bytes| fs::write(path, bytes.iter().map(|byte| !byte).collect::<Vec<_>>()).unwrap(),
        |path, bytes| {
            let flipped = |(i, byte): (usize, &u8)| byte ^ if i >= 40 && (i - 40) % 97 == 0 { 0x55 } else { 0 };
            fs::write(path, bytes.iter().enumerate().map(flipped).collect::<Vec<_>>()).unwrap();
        },
        |path, _| fs::write(path, "").unwrap(),
        |path, _| fs::write(path, b"not a cache".repeat(100)).unwrap(),
        |path, _| {
            fs::remove_file(path).unwrap();
            fs::create_dir(path).unwrap();
        },
    ];
    for damage in damages {
        kept.iter().for_each(|(path, bytes)| damage(&cache.join(path), bytes));
        assert!(picture(&folder, &cache) == wanted);
    }
    fs::remove_dir_all(&cache).unwrap();
    let file = folder.path().join("file");
    fs::write(&file, "no folder").unwrap();
    assert!(picture(&folder, &file) == wanted);
    assert_eq!(fs::read(&file).unwrap(), b"no folder");
    #[cfg(target_os = "linux")]
    assert!(picture(&folder, Path::new("/proc/pellucid")) == wanted, "nobody makes files there");
    // Half-written by somebody who was killed: no other run looks at it.
    fs::create_dir_all(cache.join("spirv")).unwrap();
    fs::write(cache.join("spirv/.pellucid-Ab12.tmp"), "half").unwrap();
    assert!(picture(&folder, &cache) == wanted);
}

#[test]
fn without_a_home_there_is_a_picture_and_nothing_else() {
    if !has_device() {
        return;
    }
    let folder = place();
    let wanted = picture(&folder, &folder.path().join("cache"));
    for set_empty in [false, true] {
        let before = files(folder.path());
        let mut run = command(folder.path(), &RENDER);
        let home = folder.path().join("nowhere");
        run.env_remove("PELLUCID_CACHE_DIR").env_remove("HOME").env("XDG_CACHE_HOME", &home);
        if set_empty {
            run.env("PELLUCID_CACHE_DIR", "");
        }
        let output = run.output().unwrap();
        assert_eq!((output.status.code(), text(&output.stderr).as_str()), (Some(0), ""));
        assert!(fs::read(folder.path().join("out/a.exr")).unwrap() == wanted);
        fs::remove_dir_all(&home).unwrap();
        assert!(files(folder.path()) == before, "the cache is where the system wants it, not here");
    }
}
