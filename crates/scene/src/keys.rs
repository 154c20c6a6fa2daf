//! All keys of a scene file, table by table.

use super::choice::MethodChoice;
use super::methods::METHODS;
use super::schema::{Key, Value};
use super::settings::{
    CameraSettings, Clip, CloudSettings, Detail, GaussianSettings, ImageSettings, Shading, ShadowMethod, Shadows,
};

/// A table of the scene file.
#[derive(Debug, Clone, PartialEq)]
pub struct KeyTable {
    /// Heading of the table in the file, as in `[image]` or `[[cloud]]`.
    pub title: &'static str,
    /// The prefix of its keys in a dotted path, as in `cloud.*`.
    pub path: &'static str,
    /// Keys of the table with their defaults.
    pub keys: Vec<Key>,
}

/// Returns the tables of a scene file with their keys; those of `[method]` follow from the method
/// ([`MethodChoice::keys`]).
pub fn tables() -> [KeyTable; 7] {
    let table = |title, path, keys| KeyTable { title, path, keys };
    let texture = Key {
        kind: ShadowMethod::kind(()),
        value: ShadowMethod::default().setting(),
        ..Key::new("method", "How shadows are found.")
    };
    let shadows = std::iter::once(texture).chain(Shadows::default().keys()).collect();
    [
        table("[image]", "image", ImageSettings::default().keys()),
        table("[camera]", "camera", CameraSettings::default().keys()),
        table("[[cloud]]", "cloud.*", CloudSettings::default().keys()),
        table("[[clip]]", "clip.*", Clip::keys()),
        table("[shading]", "shading", Shading::default().keys()),
        table("[shadows]", "shadows", shadows),
        table("[detail]", "detail", Detail::default().keys()),
    ]
}

/// Returns the keys of a method, or of `auto`, except for `name`, in the order of their declaration; empty for other
/// names.
pub fn method_keys(name: &str) -> Vec<&'static str> {
    let choice = MethodChoice::named(name);
    choice.iter().flat_map(MethodChoice::keys).map(|key| key.name).collect()
}

/// Returns the keys of methods that Gaussian splats alone heed.
pub fn gaussian_keys() -> Vec<&'static str> {
    GaussianSettings::default().keys().into_iter().map(|key| key.name).collect()
}

/// Returns the methods that have `key`.
pub(crate) fn owners(key: &str) -> Vec<&'static str> {
    METHODS.iter().copied().filter(|name| method_keys(name).contains(&key)).collect()
}

/// Returns every key that some method has in addition to `name`, each once, by the alphabet.
pub fn all_method_keys() -> Vec<&'static str> {
    let mut keys: Vec<_> = METHODS.iter().flat_map(|name| method_keys(name)).collect();
    keys.sort_unstable();
    keys.dedup();
    keys
}

/// Returns the dotted paths of the tables' keys of this name, those of all methods as one.
pub fn paths_of(key: &str) -> Vec<String> {
    let of_methods = all_method_keys().contains(&key).then(|| format!("method.{key}"));
    let tables = tables();
    let tables = tables.iter().filter(|table| table.keys.iter().any(|known| known.name == key));
    tables.map(|table| format!("{}.{key}", table.path)).chain(of_methods).collect()
}

/// Returns a phrase that names the tables which have a key that another one lacks, if there are any. `path` is the
/// unknown one, with its table.
pub(crate) fn elsewhere(path: &str) -> Option<String> {
    let (table, key) = path.rsplit_once('.').unwrap_or(("", path));
    let paths = paths_of(key);
    let segment = |segment| if str::parse::<usize>(segment).is_ok() { "*" } else { segment };
    let table = table.split('.').map(segment).collect::<Vec<_>>().join(".");
    let is_own = |path: &String| path.rsplit_once('.').is_some_and(|(other, _)| other == table);
    if paths.is_empty() || paths.iter().any(is_own) {
        return None;
    }
    let paths: Vec<_> = paths.iter().map(|path| format!("`{path}`")).collect();
    Some(format!("; it should be {}", paths.join(" or ")))
}

/// Returns the pairs of keys that exclude each other, each with its table.
pub(crate) fn rivals() -> Vec<[&'static str; 3]> {
    let named = tables().into_iter().flat_map(|table| table.keys.into_iter().map(move |key| (table.path, key)));
    let methods = METHODS.iter().filter_map(|name| MethodChoice::named(name)).flat_map(|choice| choice.keys());
    let all = named.chain(methods.map(|key| ("method", key)));
    all.filter_map(|(table, key)| Some([table, key.name, key.rival?])).collect()
}
