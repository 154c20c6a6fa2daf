//! Budgets that are known to cut the images of subjects, so that no test has to search for them.

use std::collections::BTreeMap;
use std::fs;
use std::path::PathBuf;

use pellucid_testing::{root, updates};

/// Bytes by the name of a subject.
#[derive(Default)]
pub struct Budgets(BTreeMap<String, u64>);

fn path() -> PathBuf {
    root().join("crates/lab/tests/lab/determinism/budgets.txt")
}

impl Budgets {
    /// Reads the known budgets.
    pub fn read() -> Self {
        let text = fs::read_to_string(path()).expect("budgets.txt");
        let parse = |line: &str| {
            let (bytes, name) = line.split_once(' ').expect("bytes and a name");
            (name.to_owned(), bytes.parse().expect("bytes"))
        };
        Self(text.lines().map(parse).collect())
    }

    pub fn of(&self, name: &str) -> Option<u64> {
        self.0.get(name).copied()
    }

    pub fn add(&mut self, name: &str, bytes: u64) {
        self.0.insert(name.to_owned(), bytes);
    }

    pub fn extend(&mut self, more: Self) {
        self.0.extend(more.0);
    }

    fn lines(&self) -> String {
        self.0.iter().map(|(name, bytes)| format!("{bytes} {name}\n")).collect()
    }
}

/// Prints the budgets that had to be searched for, because the known ones cut nothing. On llvmpipe, for which they are
/// known, a few may be stale, which costs a search; more are an error. An update writes them.
pub fn judge(searched: Budgets, subjects: usize, is_llvmpipe: bool) {
    if searched.0.is_empty() {
        return;
    }
    println!("budgets that were searched for:\n{}", searched.lines());
    if !is_llvmpipe {
        return;
    }
    if updates() {
        let mut all = Budgets::read();
        all.0.extend(searched.0);
        fs::write(path(), all.lines()).expect("written");
        return;
    }
    let most = subjects / 8;
    assert!(
        searched.0.len() <= most,
        "{} known budgets cut nothing, more than {most}: PELLUCID_UPDATE=1 writes budgets.txt anew",
        searched.0.len()
    );
}
