//! Keys of a scene file, from the table that the readers of scenes have.

use pellucid_core::color::classes;
use pellucid_scene::{self as scene, Key, METHODS, Method, MethodChoice};
use pyo3::prelude::*;
use serde_json::{Value, json};

/// Return all tables with their keys, as JSON: `[{title, path, keys: [{name, about, kind, unit, default, without,
/// methods}]}]`, where methods are those that have a key of `[method]`.
#[pyfunction]
pub fn keys() -> String {
    let tables = scene::tables();
    let tables = tables.iter().map(|table| {
        let keys: Vec<Value> = table.keys.iter().map(|key| described(key, &[])).collect();
        json!({ "title": table.title, "path": table.path, "keys": keys })
    });
    let all: Vec<Value> =
        tables.chain([json!({ "title": "[method]", "path": "method", "keys": of_methods() })]).collect();
    json!(all).to_string()
}

fn of_methods() -> Vec<Value> {
    let mut found: Vec<(Key, Vec<&str>)> = Vec::new();
    for name in METHODS {
        for key in MethodChoice::named(name).iter().flat_map(MethodChoice::keys) {
            match found.iter_mut().find(|(known, _)| known.name == key.name) {
                Some((_, owners)) => owners.push(name),
                None => found.push((key, vec![name])),
            }
        }
    }
    found.iter().map(|(key, owners)| described(key, owners)).collect()
}

fn described(key: &Key, owners: &[&str]) -> Value {
    let default = key.value.as_ref().map(ToString::to_string);
    json!({
        "name": key.name, "about": key.about, "kind": key.kind.to_string().replace('`', ""), "unit": key.unit,
        "default": default, "without": key.without.replace('`', ""), "methods": owners,
    })
}

/// Return names and purposes of all methods.
#[pyfunction]
pub fn methods() -> Vec<(String, String)> {
    let about = |method: &Method| (method.name().to_owned(), method.about().to_owned());
    Method::all().iter().map(about).collect()
}

/// Return the code of a LAS class by its name in a scene file; `None` for other names.
#[pyfunction]
pub fn class_code(name: &str) -> Option<u8> {
    classes::code(name)
}
