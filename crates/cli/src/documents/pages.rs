//! The pages and their blocks of code.

use std::path::{Path, PathBuf};

/// A fenced block of a page.
pub struct Block {
    /// The page and the line of the fence.
    pub page: String,
    pub line: usize,
    /// The word after the fence, as `sh`.
    pub language: String,
    pub lines: Vec<String>,
}

pub fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// The pages that users read, relative to the repository: README, those in `docs`, and that of the Python package.
pub fn pages() -> Vec<PathBuf> {
    let mut pages = vec![PathBuf::from("README.md"), PathBuf::from("python/README.md")];
    let mut folders = vec![PathBuf::from("docs")];
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(root().join(&folder)).unwrap() {
            let entry = entry.unwrap();
            let path = folder.join(entry.file_name());
            if entry.file_type().unwrap().is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|ending| ending == "md") {
                pages.push(path);
            }
        }
    }
    pages.sort();
    pages
}

/// The blocks of all pages in one language.
pub fn blocks(language: &str) -> Vec<Block> {
    let read = |page: &PathBuf| {
        let text = std::fs::read_to_string(root().join(page)).unwrap();
        blocks_of(&page.display().to_string(), &text)
    };
    pages().iter().flat_map(read).filter(|block| block.language == language).collect()
}

/// The blocks of a page. A fence inside a list may be indented.
pub fn blocks_of(page: &str, text: &str) -> Vec<Block> {
    let mut blocks = Vec::new();
    let mut open: Option<Block> = None;
    for (at, line) in text.lines().enumerate() {
        match (line.trim_start().strip_prefix("```"), open.take()) {
            (Some(_), Some(block)) => blocks.push(block),
            (Some(language), None) => {
                let language = language.trim().to_owned();
                open = Some(Block { page: page.to_owned(), line: at + 1, language, lines: Vec::new() });
            }
            (None, Some(mut block)) => {
                block.lines.push(line.to_owned());
                open = Some(block);
            }
            (None, None) => {}
        }
    }
    assert!(open.is_none(), "{page}: a block of code has no end");
    blocks
}
