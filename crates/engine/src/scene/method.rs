//! `[method]`: the method in force, its keys, and the keys of others.

use super::error::Error;
use super::keys::{all_method_keys, owners};
use super::methods::{METHODS, Method};
use super::schema::{Kind, Word};
use super::choice::MethodChoice;
use super::settings::Raster;
use super::table::Table;
use super::tree::{Node, Value};
use crate::words::nearest;

/// Reads the table; keys of other methods become warnings.
pub(super) fn read(table: &Table<'_>) -> Result<MethodChoice, Error> {
    table.refuse_unknown(&all_method_keys())?;
    let mut choice = choice(table)?;
    if let (Some(softness), true) = (table.get("softness"), table.get("lambda").is_some()) {
        let problem =
            "`method.lambda` and `method.softness` are both given, one follows from the other: keep one".into();
        return Err(Error::Conflict { place: softness.place.clone(), problem });
    }
    let name = choice.name();
    let own = choice.keys();
    let mut unread = Vec::new();
    for (key, place) in table.keys().filter(|(key, _)| *key != "name" && own.iter().all(|own| own.name != *key)) {
        table.warn(format!("{place}: method {name:?} does not use `{key}` (a key of {})", owners(key).join(", ")));
        unread.push(key);
    }
    for key in &own {
        if let (Kind::Words(words), Some(Node { value: Value::String(found), place })) = (key.kind, table.get(key.name))
            && is_foreign(key.name, words, found)
        {
            let own: Vec<_> = words.iter().map(|word| format!("{:?}", word.name)).collect();
            let (key, own) = (key.name, own.join(" and "));
            table.warn(format!("{place}: this `{key}` is of other methods: {name:?} has {own}, and takes the first"));
            unread.push(key);
        }
    }
    choice.read(&table.without(unread))?;
    if let (Some(method), Some(node)) = (choice.fixed(), table.get("raster")) {
        warn_of_raster(table, method, node);
    }
    Ok(choice)
}

/// A word that the same key has under other methods alone, which is what a file has whose method was changed.
fn is_foreign(key: &str, words: &[Word], found: &str) -> bool {
    let has = |words: &[Word]| words.iter().any(|word| word.name == found);
    let other = |method: Method| method.key(key).is_some_and(|key| matches!(key.kind, Kind::Words(words) if has(words)));
    !has(words) && Method::all().into_iter().any(other)
}

fn warn_of_raster(table: &Table<'_>, method: &Method, node: &Node) {
    let in_vain = method.raster() == Raster::Hardware && method.is_tiled() && !matches!(method, Method::Stochastic(_));
    if in_vain {
        let (place, name) = (&node.place, method.name());
        table.warn(format!("{place}: method {name:?} always works in compute shaders: `raster` has no effect"));
    }
}

fn choice(table: &Table<'_>) -> Result<MethodChoice, Error> {
    let (Some(name), Some(node)) = (table.string("name")?, table.get("name")) else { return Ok(MethodChoice::default()) };
    MethodChoice::named(name).ok_or_else(|| Error::UnknownMethod {
        place: node.place.clone(),
        name: name.to_owned(),
        hint: nearest(name, METHODS.iter().copied(), "this version has"),
    })
}
