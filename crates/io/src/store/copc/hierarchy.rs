//! The hierarchy of a COPC file: pages of entries, some of which lead to further pages.

use std::collections::HashSet;

use crate::number::{long, word};
use crate::store::keys::Key;
use crate::{Error, SharedFile};

/// Bytes of an entry.
const ENTRY: usize = 32;

/// A node with points.
pub(super) struct Entry {
    pub key: Key,
    pub start: u64,
    pub bytes: u64,
    pub points: u64,
}

/// A run of entries in the file.
#[derive(Clone, Copy)]
pub(super) struct Page {
    pub start: u64,
    pub bytes: u64,
}

/// Returns all nodes with points. Pages take no more bytes together than the file has, so there is an end, whatever
/// they say.
pub(super) fn read(file: &SharedFile, root: Page) -> Result<Vec<Entry>, Error> {
    let mut pages = vec![root];
    let (mut entries, mut keys, mut total) = (Vec::new(), HashSet::new(), 0u64);
    while let Some(page) = pages.pop() {
        let place = format!("COPC hierarchy at byte {}", page.start);
        total = total.saturating_add(page.bytes);
        if total > file.len() {
            let cause = format!("its pages take {total} bytes or more in a file of {}, so they overlap", file.len());
            return Err(file.malformed(place, cause));
        }
        let bytes = file.read(page.start, page.bytes)?;
        let (records, rest) = bytes.as_chunks::<ENTRY>();
        if !rest.is_empty() || records.is_empty() {
            let cause =
                format!("a page has {} bytes, expected a multiple of the {ENTRY} bytes of an entry", page.bytes);
            return Err(file.malformed(place, cause));
        }
        for record in records {
            match parse(record).map_err(|cause| file.malformed(&*place, cause))? {
                EntryTarget::Page(further) => pages.push(further),
                EntryTarget::Empty => {}
                EntryTarget::Node(entry) if keys.insert(entry.key) => entries.push(entry),
                EntryTarget::Node(entry) => {
                    return Err(file.malformed(place, format!("there is a second node {}", entry.key)));
                }
            }
        }
    }
    Ok(entries)
}

/// Target of an entry.
enum EntryTarget {
    Node(Entry),
    Page(Page),
    Empty,
}

fn parse(record: &[u8; ENTRY]) -> Result<EntryTarget, String> {
    let word = |at: usize| word(record, 4 * at).cast_signed();
    let start = long(record, 16);
    let numbers = [word(0), word(1), word(2), word(3)];
    let Some(key) = Key::new(numbers.map(i64::from)) else {
        return Err(format!("an entry has level and place {numbers:?}, which no octree has"));
    };
    let (bytes, points) = (word(6), word(7));
    match (u64::try_from(bytes), u64::try_from(points)) {
        (Ok(_), Ok(0)) => Ok(EntryTarget::Empty),
        (Ok(bytes), Ok(points)) => Ok(EntryTarget::Node(Entry { key, start, bytes, points })),
        (Ok(bytes), Err(_)) if points == -1 => Ok(EntryTarget::Page(Page { start, bytes })),
        _ => Err(format!("node {key} can't have {points} points in {bytes} bytes")),
    }
}
