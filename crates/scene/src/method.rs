//! `[method]`: the method in force, its keys, and the keys of others.

use super::choice::MethodChoice;
use super::error::{Error, Place};
use super::keys::{all_method_keys, owners};
use super::methods::{METHODS, Method};
use super::schema::{Key, ValueKind, Word};
use super::setting::Setting;
use super::settings::Raster;
use super::table::{Context, Table};
use super::tree::{Entries, Node, Value};
use pellucid_core::words::nearest;

/// Reads the table; keys of other methods become warnings.
pub(super) fn read(table: &Table<'_>) -> Result<MethodChoice, Error> {
    let mut known = [all_method_keys(), vec!["name"]].concat();
    known.sort_unstable();
    table.refuse_unknown(&known)?;
    let mut choice = choice(table)?;
    if table.get("softness").is_some() && table.get("lambda").is_some() {
        let problem = "`method.lambda` and `method.softness` set the same thing: keep one";
        return Err(table.conflict("softness", problem));
    }
    let name = choice.name();
    let own = choice.keys();
    let mut unread = Vec::new();
    for (key, place) in table.keys().filter(|(key, _)| *key != "name" && own.iter().all(|own| own.name != *key)) {
        table.warn(format!("{place}: method {name:?} does not use `{key}` (a key of {})", owners(key).join(", ")));
        unread.push(key);
    }
    for key in &own {
        if let (ValueKind::Words(words), Some(Node { value: Value::String(found), place })) =
            (key.kind, table.get(key.name))
            && is_foreign(key.name, words, found)
        {
            let own: Vec<_> = words.iter().map(|word| format!("{:?}", word.name)).collect();
            let (key, own) = (key.name, own.join(" and "));
            table.warn(format!(
                "{place}: this value of `{key}` is for other methods; {name:?} has {own} and takes the \
                 first"
            ));
            unread.push(key);
        }
    }
    choice.read(&table.without(unread))?;
    if let (Some(method), Some(node)) = (choice.fixed(), table.get("raster")) {
        warn_of_raster(table, method, node);
    }
    if let (Some(_), Some(node)) = (choice.fixed().and_then(Method::pixel_radius), table.get("size")) {
        table.warn(format!("{}: `size` has no effect with method.pixel_radius", node.place));
    }
    Ok(choice)
}

impl Method {
    /// Returns the same method with another value for one of its keys.
    ///
    /// # Errors
    /// A key of other methods, a value that the key doesn't take.
    pub fn with(mut self, key: &str, value: Setting) -> Result<Self, Error> {
        let place = Place::Option(format!("method.{key}={value}"));
        let node = |value| Node { place: place.clone(), value };
        let given = Entries::from([(key.to_owned(), (place.clone(), node(value.into_value(&place))))]);
        let (root, context) = (node(Value::Table(given)), Context::default());
        let table = Table::root(&root, &context)?;
        table.refuse_unknown(&self.keys().iter().map(|key| key.name).collect::<Vec<_>>())?;
        self.settings_mut().map_or(Ok(()), |settings| settings.read(&table))?;
        Ok(self)
    }

    /// Returns the same method with the values of other keys, as far as it has these keys.
    #[must_use]
    pub fn with_keys(self, keys: &[Key]) -> Self {
        let given = keys.iter().filter_map(|key| Some((key.name, key.value.clone()?)));
        given.fold(self, |method, (key, value)| method.with(key, value).unwrap_or(method))
    }
}

/// A word that the same key has under other methods alone, which is what a file has whose method was changed.
fn is_foreign(key: &str, words: &[Word], found: &str) -> bool {
    let has = |words: &[Word]| words.iter().any(|word| word.name == found);
    let other =
        |method: Method| method.key(key).is_some_and(|key| matches!(key.kind, ValueKind::Words(words) if has(words)));
    !has(words) && Method::all().into_iter().any(other)
}

fn warn_of_raster(table: &Table<'_>, method: &Method, node: &Node) {
    let follows =
        matches!(method, Method::ABuffer(_) | Method::LinkedList(_) | Method::Peel(_) | Method::Stochastic(_));
    let in_vain = method.discs().is_some_and(|discs| discs.raster == Raster::Hardware) && !follows;
    if in_vain {
        let (place, name) = (&node.place, method.name());
        table.warn(format!("{place}: method {name:?} always works in compute shaders: `raster` has no effect"));
    }
}

fn choice(table: &Table<'_>) -> Result<MethodChoice, Error> {
    let (Some(name), Some(node)) = (table.string("name")?, table.get("name")) else {
        return Ok(MethodChoice::default());
    };
    MethodChoice::named(name).ok_or_else(|| Error::UnknownMethod {
        place: node.place.clone(),
        name: name.to_owned(),
        hint: nearest(name, METHODS.iter().copied(), "this version has"),
    })
}
