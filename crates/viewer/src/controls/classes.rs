//! Settings of a class in `[[cloud.class]]`, and the changes to them.

use glam::Vec3;

use pellucid_scene::{Change, ClassSettings, Selection, Setting, rounded};

/// Settings of a class of a cloud.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ClassLook {
    /// Opacity of these points, in place of the cloud's.
    pub opacity: Option<f32>,
    /// Color in place of the cloud's, linear.
    pub color: Option<Vec3>,
    /// Radius in place of the cloud's, in world units.
    pub radius: Option<f32>,
    /// False if its points are not drawn.
    pub visible: bool,
    /// True if an entry is about this class alone.
    pub is_given: bool,
}

/// A key of a class.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ClassKey {
    /// Opacity of the class, from 0 to 1.
    Opacity(f64),
    /// Color of the class, linear.
    Color([f64; 3]),
    /// `true` if its points are drawn.
    Visible(bool),
}

impl ClassKey {
    /// The name, the value, and which entries give the key.
    fn parts(self) -> (&'static str, Setting, fn(&ClassSettings) -> bool) {
        match self {
            Self::Opacity(opacity) => ("opacity", opacity.into(), |entry| entry.opacity.is_some()),
            Self::Color(color) => ("color", color.into(), |entry| entry.color.is_some()),
            Self::Visible(visible) => ("visible", visible.into(), |entry| entry.visible.is_some()),
        }
    }
}

/// Returns the settings of a class in the entries of a cloud: of several the last, key by key.
pub fn class_look(entries: &[ClassSettings], code: u8) -> ClassLook {
    let about = || entries.iter().rev().filter(|entry| entry.points.holds_class(code));
    ClassLook {
        opacity: about().find_map(|entry| entry.opacity),
        color: about().find_map(|entry| entry.color),
        radius: about().find_map(|entry| entry.radius),
        visible: about().find_map(|entry| entry.visible).unwrap_or(true),
        is_given: about().any(|entry| is_own(entry, code)),
    }
}

fn is_own(entry: &ClassSettings, code: u8) -> bool {
    entry.points == Selection::Class(code)
}

/// The changes that give a class of the cloud `cloud` a key: in its own entry, or in a new one where a later entry
/// would win.
pub fn class_changes(cloud: usize, entries: &[ClassSettings], code: u8, key: ClassKey) -> Vec<Change> {
    if key == ClassKey::Visible(true) {
        return shown(cloud, entries, code);
    }
    given(cloud, entries, code, key)
}

fn given(cloud: usize, entries: &[ClassSettings], code: u8, key: ClassKey) -> Vec<Change> {
    let (name, value, is_given) = key.parts();
    let overrules = |entry: &ClassSettings| entry.points.holds_class(code) && is_given(entry);
    let wins = |at: &usize| !entries.iter().skip(at + 1).any(overrules);
    let own = entries.iter().rposition(|entry| is_own(entry, code)).filter(wins);
    let at = |at: usize, name: &str| format!("cloud.{cloud}.class.{at}.{name}");
    let id = own.is_none().then(|| (at(entries.len(), "id"), Some(Setting::Integer(code.into()))));
    let value = (at(own.unwrap_or(entries.len()), name), Some(value));
    id.into_iter().chain([value]).collect()
}

/// The changes that show a class again: its own entries no longer hide it, and if others do, one says otherwise.
fn shown(cloud: usize, entries: &[ClassSettings], code: u8) -> Vec<Change> {
    let without = |entry: &ClassSettings| {
        let visible = entry.visible.filter(|_| !is_own(entry, code));
        ClassSettings { visible, ..entry.clone() }
    };
    let others: Vec<_> = entries.iter().map(without).collect();
    if !class_look(&others, code).visible {
        return given(cloud, entries, code, ClassKey::Visible(true));
    }
    let hiding = entries.iter().enumerate().filter(|(_, entry)| is_own(entry, code) && entry.visible.is_some());
    let change = |(at, entry): (usize, &ClassSettings)| {
        // An entry must say something.
        let says_more = entry.opacity.is_some() || entry.color.is_some() || entry.radius.is_some();
        let key = if says_more { ".visible" } else { "" };
        (format!("cloud.{cloud}.class.{at}{key}"), None)
    };
    // From the last, lest a number mean another entry.
    let changes: Vec<_> = hiding.rev().map(change).collect();
    tidied(cloud, entries, changes)
}

/// The changes that give this class the look that it has by `opened`, the entries of the cloud as it was opened: its
/// own entries are taken out, and one says again what the others don't.
pub fn class_resets(cloud: usize, entries: &[ClassSettings], opened: &[ClassSettings], code: u8) -> Vec<Change> {
    let (own, others): (Vec<_>, Vec<_>) = entries.iter().enumerate().partition(|(_, entry)| is_own(entry, code));
    let removed = own.iter().rev().map(|(at, _)| (format!("cloud.{cloud}.class.{at}"), None)).collect();
    let others: Vec<ClassSettings> = others.into_iter().map(|(_, entry)| entry.clone()).collect();
    let (wanted, left) = (class_look(opened, code), class_look(&others, code));
    let at = |name: &str| format!("cloud.{cloud}.class.{}.{name}", others.len());
    let opacity = wanted.opacity.filter(|_| wanted.opacity != left.opacity).map(|x| Setting::Number(rounded(x)));
    let color = wanted.color.filter(|_| wanted.color != left.color);
    let color = color.map(|color| Setting::from(color.to_array().map(rounded)));
    let radius = wanted.radius.filter(|_| wanted.radius != left.radius).map(|x| Setting::Number(rounded(x)));
    let visible = (wanted.visible != left.visible).then_some(Setting::Flag(wanted.visible));
    let given = [("opacity", opacity), ("color", color), ("radius", radius), ("visible", visible)];
    let given: Vec<Change> =
        given.into_iter().filter(|(_, value)| value.is_some()).map(|(name, value)| (at(name), value)).collect();
    if given.is_empty() {
        return tidied(cloud, entries, removed);
    }
    let id = (at("id"), Some(Setting::Integer(code.into())));
    removed.into_iter().chain([id]).chain(given).collect()
}

/// Returns the changes, or the removal of the whole array if they take every entry out.
fn tidied(cloud: usize, entries: &[ClassSettings], changes: Vec<Change>) -> Vec<Change> {
    let is_entry = |(key, _): &&Change| !key.ends_with(".visible");
    if !entries.is_empty() && changes.iter().filter(is_entry).count() == entries.len() {
        return vec![(format!("cloud.{cloud}.class"), None)];
    }
    changes
}

#[cfg(test)]
mod tests {
    use super::*;
    use pellucid_scene::{Document, Overrides};

    fn document(classes: &str) -> Document {
        let text = format!("[[cloud]]\npath = 'a.laz'\n[[cloud]]\npath = 'b.laz'\n{classes}");
        Document::from_toml(&text, "s.toml".as_ref(), &Overrides::default()).unwrap()
    }

    fn entries(document: &Document) -> Vec<ClassSettings> {
        document.scene().unwrap().clouds[1].class.clone()
    }

    /// Whatever stands there already, the class has what it is given, another one what it had, and the default is what
    /// the entries of others make of it.
    #[test]
    fn a_class_has_what_it_is_given() {
        let range = "[[cloud.class]]\nscalar = 'classification'\nrange = [3, 6]\n";
        let cases = [
            String::new(),
            "[[cloud.class]]\nid = 'building'\nopacity = 0.5\n".to_owned(),
            format!("{range}opacity = 0.25\nvisible = false\n"),
            format!("[[cloud.class]]\nid = 6\nvisible = false\ncolor = 'red'\n{range}visible = false\n"),
            format!("[[cloud.class]]\nid = 6\nradius = 0.25\nvisible = false\n{range}opacity = 0.5\n"),
            format!(
                "{range}color = 'blue'\n[[cloud.class]]\nid = 6\nopacity = 0.1\n[[cloud.class]]\nid = 6\nopacity = 0.2\n"
            ),
        ];
        for text in cases {
            let mut document = document(&text);
            let (opened, other) = (entries(&document), class_look(&entries(&document), 5));
            let keys = [
                ClassKey::Visible(false),
                ClassKey::Opacity(0.125),
                ClassKey::Visible(true),
                ClassKey::Color([0.5; 3]),
            ];
            for key in keys {
                document.change(&class_changes(1, &entries(&document), 6, key)).unwrap();
            }
            let wanted = ClassLook {
                opacity: Some(0.125),
                color: Some(Vec3::splat(0.5)),
                radius: class_look(&opened, 6).radius,
                visible: true,
                is_given: true,
            };
            assert_eq!(class_look(&entries(&document), 6), wanted, "{text}");
            assert_eq!(class_look(&entries(&document), 5), other, "{text}");
            document.change(&class_resets(1, &entries(&document), &opened, 6)).unwrap();
            assert_eq!(class_look(&entries(&document), 6), class_look(&opened, 6), "{text}");
            assert_eq!(class_look(&entries(&document), 5), other, "{text}");
        }
    }

    #[test]
    fn a_class_that_is_hidden_and_shown_again_leaves_nothing_behind() {
        let mut document = document("");
        let before = document.to_toml("".as_ref()).unwrap();
        for visible in [false, true] {
            document.change(&class_changes(1, &entries(&document), 2, ClassKey::Visible(visible))).unwrap();
            assert_eq!(class_look(&entries(&document), 2).visible, visible);
        }
        assert_eq!(document.to_toml("".as_ref()).unwrap(), before);
    }
}
