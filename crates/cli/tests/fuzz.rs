//! The fuzz targets over their corpora, without a fuzzer: every input is read or refused, in little memory.
//! CONTRIBUTING.md says how to fuzz.

#[path = "../../../fuzz/src/bodies/mod.rs"]
mod bodies;
#[path = "../../../fuzz/src/harness.rs"]
mod harness;

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use bodies::TARGETS;
use harness::{Body, MEMORY_LIMIT};
use image::codecs::png::PngEncoder;
use image::{ExtendedColorType, ImageEncoder};
use peak_alloc::PeakAlloc;

/// Counts for the harness.
#[global_allocator]
static MEMORY: PeakAlloc = PeakAlloc;

/// All allocations in the meantime count, so only one body runs at a time.
static SERIAL: Mutex<()> = Mutex::new(());

fn run(body: Body, input: &[u8]) -> Result<(), String> {
    let _guard = SERIAL.lock().unwrap_or_else(PoisonError::into_inner);
    harness::run(&MEMORY, body, input)
}

fn folder(name: &str) -> PathBuf {
    pellucid_testing::root().join("fuzz").join(name)
}

/// The entries of a folder, in order.
fn entries(folder: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).unwrap_or_else(|e| panic!("{}: {e}", folder.display()));
    let mut paths: Vec<_> = entries.map(|entry| entry.unwrap().path()).collect();
    paths.sort();
    paths
}

fn stems(paths: impl IntoIterator<Item = PathBuf>) -> BTreeSet<String> {
    paths.into_iter().map(|path| path.file_stem().unwrap().to_str().unwrap().to_owned()).collect()
}

#[test]
fn every_target_has_a_program_and_a_corpus_and_every_corpus_a_target() {
    let names: BTreeSet<String> = TARGETS.iter().map(|(name, _)| (*name).to_owned()).collect();
    assert_eq!(stems(entries(&folder("targets"))), names);
    assert_eq!(stems(entries(&folder("corpus")).into_iter().filter(|path| path.is_dir())), names);
    let manifest: toml::Table = std::fs::read_to_string(folder("Cargo.toml")).unwrap().parse().unwrap();
    let programs = manifest["bin"].as_array().unwrap().iter().map(|bin| bin["name"].as_str().unwrap().to_owned());
    assert_eq!(programs.collect::<BTreeSet<_>>(), names);
    assert!(stems(entries(&folder("dictionaries"))).is_subset(&names));
}

#[test]
fn corpora_are_read_or_refused() {
    let mut faults = Vec::new();
    for (name, body) in TARGETS {
        let inputs = entries(&folder("corpus").join(name));
        assert!(inputs.len() >= 5, "{name}: only {} inputs", inputs.len());
        for path in inputs {
            if let Err(fault) = run(body, &std::fs::read(&path).unwrap()) {
                faults.push(format!("{}: {fault}", path.display()));
            }
        }
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

#[test]
fn panics_and_too_much_memory_are_noticed() {
    fn panics(input: &[u8]) {
        assert!(input.len() < 2, "{} bytes", input.len());
    }
    fn takes_too_much(input: &[u8]) {
        if let [_, _, ..] = input {
            std::hint::black_box(Vec::<u8>::with_capacity(MEMORY_LIMIT + 1));
        }
    }
    assert_eq!(run(panics, b"a"), Ok(()));
    assert_eq!(run(panics, b"abc"), Err("a panic: 3 bytes".to_owned()));
    assert_eq!(run(takes_too_much, b"a"), Ok(()));
    assert_eq!(run(takes_too_much, b"abc"), Err("200 MiB of memory for 3 bytes".to_owned()));
}

/// A color profile is not used, but the decoder unpacks it, to a thousand times its bytes.
#[test]
fn a_color_profile_of_many_zeros_takes_little_memory() {
    let mut bomb = Vec::new();
    {
        let _guard = SERIAL.lock().unwrap_or_else(PoisonError::into_inner);
        let mut encoder = PngEncoder::new(&mut bomb);
        encoder.set_icc_profile(vec![0; MEMORY_LIMIT + 1]).unwrap();
        encoder.write_image(&[7; 3], 1, 1, ExtendedColorType::Rgb8).unwrap();
    }
    assert!(bomb.len() < 1 << 20, "{} bytes", bomb.len());
    for (name, body) in TARGETS.into_iter().filter(|(name, _)| ["photo", "compare"].contains(name)) {
        assert_eq!(run(body, &bomb), Ok(()), "{name}");
    }
}
