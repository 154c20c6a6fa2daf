//! A document beside an earlier one of the same scene: keys that differ, and their earlier values.

use super::{Document, path};
use crate::tree::{Entries, Node, Value};

impl Document {
    /// Returns `true` if a dotted key has another value than in `earlier`, or is given in only one of the two. For
    /// `cloud.*`, if that is so of any cloud.
    pub fn differs(&self, earlier: &Self, key: &str) -> bool {
        !same_at(Some(&self.root), Some(&earlier.root), &path(key))
    }

    /// Gives a dotted key the value that it has in `earlier`, or takes it out where that has none; the scene may not
    /// allow it. For `cloud.*`, each cloud gets its own value.
    pub fn restore(&mut self, earlier: &Self, key: &str) {
        restore(&mut self.root, Some(&earlier.root), &path(key));
    }

    /// Returns the number of values, tables and arrays, which is a measure of its memory.
    pub fn nodes(&self) -> usize {
        fn count(node: &Node) -> usize {
            1 + match &node.value {
                Value::Table(entries) => entries.values().map(|(_, node)| count(node)).sum(),
                Value::Array(items) => items.iter().map(count).sum(),
                _ => 0,
            }
        }
        count(&self.root)
    }
}

/// Returns what a node holds under a segment of a path.
fn child<'a>(node: Option<&'a Node>, segment: &str) -> Option<&'a Node> {
    match &node?.value {
        Value::Table(entries) => entries.get(segment).map(|(_, node)| node),
        Value::Array(items) => items.get(segment.parse::<usize>().ok()?),
        _ => None,
    }
}

/// Returns the items of an array; none of anything else.
fn items(node: Option<&Node>) -> &[Node] {
    match node.map(|node| &node.value) {
        Some(Value::Array(items)) => items,
        _ => &[],
    }
}

fn same_at(a: Option<&Node>, b: Option<&Node>, path: &[&str]) -> bool {
    match path {
        [] => match (a, b) {
            (Some(a), Some(b)) => same(&a.value, &b.value),
            (a, b) => a.is_none() && b.is_none(),
        },
        ["*", rest @ ..] => {
            let (a, b) = (items(a), items(b));
            (0..a.len().max(b.len())).all(|i| same_at(a.get(i), b.get(i), rest))
        }
        [segment, rest @ ..] => same_at(child(a, segment), child(b, segment), rest),
    }
}

/// Compares values; numbers by what they are, whole or not.
fn same(a: &Value, b: &Value) -> bool {
    match (a, b) {
        (Value::Table(a), Value::Table(b)) => {
            a.len() == b.len()
                && a.iter().zip(b).all(|((key, (_, x)), (other, (_, y)))| key == other && same(&x.value, &y.value))
        }
        (Value::Array(a), Value::Array(b)) => {
            a.len() == b.len() && a.iter().zip(b).all(|(x, y)| same(&x.value, &y.value))
        }
        (Value::Integer(i), Value::Float(x)) | (Value::Float(x), Value::Integer(i)) => *i as f64 == *x,
        (Value::Integer(a), Value::Integer(b)) => a == b,
        (Value::Float(a), Value::Float(b)) => a == b,
        (Value::String(a), Value::String(b)) => a == b,
        (Value::Boolean(a), Value::Boolean(b)) => a == b,
        (Value::Path(a), Value::Path(b)) => a == b,
        _ => false,
    }
}

fn restore(node: &mut Node, earlier: Option<&Node>, path: &[&str]) {
    let Some((segment, rest)) = path.split_first() else { return };
    let old = child(earlier, segment);
    match &mut node.value {
        Value::Table(entries) if rest.is_empty() => match earlier.map(|earlier| &earlier.value) {
            Some(Value::Table(earlier)) if earlier.contains_key(*segment) => {
                entries.extend(earlier.get_key_value(*segment).map(|(key, entry)| (key.clone(), entry.clone())));
            }
            _ => drop(entries.remove(*segment)),
        },
        Value::Table(entries) => {
            if let (Some(Node { place, value: Value::Table(_) }), false) = (old, entries.contains_key(*segment)) {
                let empty = Node { place: place.clone(), value: Value::Table(Entries::new()) };
                entries.insert((*segment).to_owned(), (place.clone(), empty));
            }
            if let Some((_, node)) = entries.get_mut(*segment) {
                restore(node, old, rest);
            }
        }
        Value::Array(now) => {
            let picked = |i: usize| *segment == "*" || segment.parse() == Ok(i);
            let now = now.iter_mut().enumerate().filter(|(i, _)| picked(*i));
            now.for_each(|(i, item)| restore(item, items(earlier).get(i), rest));
        }
        _ => {}
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Overrides, Scene, Setting};

    const TEXT: &str = "
        [image]
        background = [1, 1, 1]
        [[cloud]]
        path = 'a.ply'
        opacity = 1
        axis = { point = [1, 2, 3] }
        [[cloud]]
        path = 'b.ply'
        opacity = 0.25
        [[cloud]]
        path = 'c.ply'
    ";

    /// The scene, whatever empty tables its document has.
    fn scene(document: &Document) -> Scene {
        Scene { settings: String::new(), ..document.scene().unwrap() }
    }

    fn document() -> Document {
        Document::from_toml(TEXT, "/scans/s.toml".as_ref(), &Overrides::default()).unwrap()
    }

    #[test]
    fn restored_keys_have_the_values_of_each_cloud() {
        let earlier = document();
        let mut document = earlier.clone();
        let wanted = scene(&document);
        document.set("cloud.*.opacity", Setting::Number(0.5)).unwrap();
        document.set("cloud.1.radius", Setting::Number(0.5)).unwrap();
        let keys = ["cloud.*.opacity", "cloud.0.opacity", "cloud.2.opacity", "cloud.1.radius", "cloud.*.radius"];
        assert_eq!(keys.map(|key| document.differs(&earlier, key)), [true; 5]);
        assert!(!document.differs(&earlier, "cloud.0.radius") && !document.differs(&earlier, "image.background"));
        document.restore(&earlier, "cloud.1.opacity");
        let opacities: Vec<_> = document.scene().unwrap().clouds.iter().map(|cloud| cloud.opacity).collect();
        assert_eq!(opacities, [0.5, 0.25, 0.5]);
        ["cloud.*.opacity", "cloud.*.radius"].iter().for_each(|key| document.restore(&earlier, key));
        assert_eq!(keys.map(|key| document.differs(&earlier, key)), [false; 5]);
        assert_eq!((scene(&document), document.has("cloud.2.opacity")), (wanted, false));
    }

    #[test]
    fn tables_that_were_taken_out_come_back_key_by_key() {
        let earlier = document();
        let mut document = earlier.clone();
        document.remove("cloud.0", "axis");
        document.remove("", "image");
        document.put("shading.ambient", Setting::Number(0.5)).unwrap();
        for key in ["cloud.0.axis.point", "image.background", "shading.ambient"] {
            assert!(document.differs(&earlier, key), "{key}");
            document.restore(&earlier, key);
            assert!(!document.differs(&earlier, key), "{key}");
        }
        assert_eq!(scene(&document), scene(&earlier));
        // Keys that are nowhere are left alone.
        ["cloud.7.opacity", "cloud.0.path.x", "", "nothing.at.all"]
            .iter()
            .for_each(|key| document.restore(&earlier, key));
        assert_eq!(scene(&document), scene(&earlier));
    }

    #[test]
    fn a_whole_number_is_the_same_as_a_number() {
        let (earlier, mut document) = (document(), document());
        document.set("cloud.0.opacity", Setting::Number(1.0)).unwrap();
        document.set("image.background", Setting::from([1.0; 3])).unwrap();
        assert!(!document.differs(&earlier, "cloud.0.opacity") && !document.differs(&earlier, "image.background"));
        document.set("image.background", Setting::from([1.0, 1.0, 0.5])).unwrap();
        assert!(document.differs(&earlier, "image.background"));
    }

    #[test]
    fn memory_is_measured_in_values() {
        let mut document = document();
        let before = document.nodes();
        // The root; the image with a color of three numbers; the array of clouds; the clouds.
        assert_eq!(before, 1 + (1 + 4) + 1 + (1 + 2 + 1 + 4) + (1 + 2) + (1 + 1));
        document.set("cloud.1.radius", Setting::Number(0.5)).unwrap();
        assert_eq!(document.nodes(), before + 1);
    }
}
