//! The hierarchy of an EPT folder: JSON files of names and counts, where −1 leads to a file of that name.

use std::collections::{BTreeMap, HashSet};
use std::path::Path;

use super::metadata::read_json;
use crate::Error;
use crate::store::keys::Key;

/// Returns the nodes with points, and how many each has. Each file is read once, so there is an end, whatever they say.
pub(super) fn read(folder: &Path, announced: u64) -> Result<Vec<(Key, u64)>, Error> {
    let hierarchy = folder.join("ept-hierarchy");
    let mut files = vec![Key { level: 0, place: [0; 3] }];
    let (mut seen, mut keys, mut nodes) = (HashSet::from([files[0]]), HashSet::new(), Vec::new());
    let mut total = 0u64;
    while let Some(file) = files.pop() {
        let path = hierarchy.join(format!("{file}.json"));
        let entries: BTreeMap<String, i64> = read_json(&path)?;
        let malformed = |name: &str, cause: String| Err(Error::malformed(&path, format!("node `{name}`"), cause));
        for (name, count) in entries {
            let Some(key) = Key::parse(&name) else {
                return malformed(&name, "it is not a level and place of an octree".to_owned());
            };
            match u64::try_from(count) {
                Ok(points) if !keys.insert(key) => {
                    return malformed(&name, format!("the same node has a second count, {points}"));
                }
                Ok(0) => {}
                Ok(points) => {
                    nodes.push((key, points));
                    total = total.saturating_add(points);
                }
                Err(_) if count == -1 && seen.insert(key) => files.push(key),
                Err(_) if count == -1 => return malformed(&name, "it leads to a file that was read before".to_owned()),
                Err(_) => return malformed(&name, format!("{count} points")),
            }
        }
    }
    if total != announced {
        let cause = format!("`points` says {announced}, but the nodes of the hierarchy have {total}");
        return Err(Error::malformed(&folder.join("ept.json"), "hierarchy", cause));
    }
    Ok(nodes)
}
