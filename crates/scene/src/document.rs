//! A scene as its keys and values: read from a file, changed key by key, written again.

mod compared;

use std::path::{Path, PathBuf};

use super::error::{Error, Place};
use super::keys;
use super::overrides::Overrides;
use super::parse;
use super::scene::Scene;
use super::setting::Setting;
use super::settings::{Background, ImageSettings};
use super::tree::{self, Entries, Node, Value};

/// The keys of a scene with their values, as given by a file and options; others are absent.
#[derive(Debug, Clone)]
pub struct Document {
    root: Node,
    /// The folder that relative paths of clouds start from.
    folder: Option<PathBuf>,
    /// The scene file that it was read from.
    file: Option<PathBuf>,
    /// `true` of clouds without a scene file, whose background is `auto` unless one is given.
    names_clouds: bool,
}

/// A dotted key and its value; `None` removes the key.
pub type Change = (String, Option<Setting>);

impl Document {
    /// Returns the document that `text` is, with options laid over it. `origin` is the file's path: named in errors,
    /// and clouds are relative to its folder.
    ///
    /// # Errors
    /// A text that is no TOML, options for keys that can't be there.
    pub fn from_toml(text: &str, origin: &Path, overrides: &Overrides) -> Result<Self, Error> {
        let mut root = tree::parse(text, origin)?;
        overrides.apply(&mut root)?;
        Ok(Self { root, folder: origin.parent().map(Path::to_owned), file: None, names_clouds: false })
    }

    /// Returns the document in the file `path`, with options laid over it.
    ///
    /// # Errors
    /// A file that is missing, empty, too large or not text, and all of [`Document::from_toml`].
    pub fn read(path: &Path, overrides: &Overrides) -> Result<Self, Error> {
        let document = Self::from_toml(&parse::read_text(path)?, path, overrides)?;
        Ok(Self { file: Some(path.to_owned()), ..document })
    }

    /// Returns a document of cloud files, with options laid over it.
    ///
    /// # Errors
    /// Options for keys that can't be there.
    pub fn from_clouds(
        paths: impl IntoIterator<Item = impl AsRef<Path>>,
        overrides: &Overrides,
    ) -> Result<Self, Error> {
        let place = || Place::Option("the command line".into());
        let cloud = |path: &Path| {
            let path = Node { place: place(), value: Value::Path(path.to_owned()) };
            Node { place: place(), value: Value::Table([("path".to_owned(), (place(), path))].into()) }
        };
        let clouds = paths.into_iter().map(|path| cloud(path.as_ref())).collect();
        let clouds = Node { place: place(), value: Value::Array(clouds) };
        let mut root = Node { place: place(), value: Value::Table([("cloud".to_owned(), (place(), clouds))].into()) };
        overrides.apply(&mut root)?;
        Ok(Self { root, folder: None, file: None, names_clouds: true })
    }

    /// Returns the scene that the document describes.
    ///
    /// # Errors
    /// Whatever is wrong with a key or value, and where it was given.
    pub fn scene(&self) -> Result<Scene, Error> {
        let scene = parse::read_scene(&self.root, self.folder.as_deref()).map_err(|error| match error {
            Error::UnknownKey { place, key, hint } => {
                let hint = keys::elsewhere(&key).unwrap_or(hint);
                Error::UnknownKey { place, key, hint }
            }
            error => error,
        })?;
        let image = if self.leaves_background() {
            ImageSettings { background: Background::Auto, ..scene.image }
        } else {
            scene.image
        };
        Ok(Scene { image, names_clouds: self.names_clouds, ..scene })
    }

    /// Returns `true` of clouds without a scene file to which no background is given.
    fn leaves_background(&self) -> bool {
        self.names_clouds && !self.has("image.background")
    }

    /// Gives a dotted key a value, as `--set` does, if what comes out is a scene; else all stays as it was.
    ///
    /// # Errors
    /// Whatever is wrong with the value, or with the scene that it would make.
    pub fn set(&mut self, key: &str, value: Setting) -> Result<Scene, Error> {
        self.change(&[(key.to_owned(), Some(value))])
    }

    /// Gives a dotted key a value, whether the scene allows it or not. A number just behind the last table of an array
    /// begins another one (`clip.0.invert` the first, where there is none).
    ///
    /// # Errors
    /// A key that goes through something that holds no keys.
    pub fn put(&mut self, key: &str, value: Setting) -> Result<(), Error> {
        let place = Place::Option(key.to_owned());
        grow(&mut self.root, &path(key), &place);
        let mut overrides = Overrides::default();
        overrides.put(key, Node { value: value.into_value(&place), place });
        overrides.apply(&mut self.root)
    }

    /// Lays options over it, if what comes out is a scene; else all stays as it was.
    ///
    /// # Errors
    /// Options for keys that can't be there, or whatever is wrong with the scene that they would make.
    pub fn lay_over(&mut self, overrides: &Overrides) -> Result<Scene, Error> {
        let mut changed = self.clone();
        overrides.apply(&mut changed.root)?;
        let scene = changed.scene()?;
        *self = changed;
        Ok(scene)
    }

    /// Takes a key out of a table, if both are there. The table is named by its dotted path (`cloud.0`, `cloud.*` for
    /// all of them), the root by an empty one. In place of the two an array and a number take a table out of it.
    pub fn remove(&mut self, table: &str, key: &str) {
        self.root.visit(&path(table), &mut |value| match (value, key.parse::<usize>()) {
            (Value::Table(entries), _) => drop(entries.remove(key)),
            (Value::Array(items), Ok(index)) if index < items.len() => drop(items.remove(index)),
            _ => {}
        });
    }

    /// Changes several dotted keys at once, one after the other: each is set or removed. If the result is invalid,
    /// nothing changes; intermediate states may be invalid.
    ///
    /// # Errors
    /// An invalid value, or an invalid scene as a result.
    pub fn change(&mut self, changes: &[Change]) -> Result<Scene, Error> {
        let mut changed = self.clone();
        for (key, value) in changes {
            match (value, key.rsplit_once('.')) {
                (Some(value), _) => changed.put(key, value.clone())?,
                (None, Some((table, key))) => changed.remove(table, key),
                (None, None) => changed.remove("", key),
            }
        }
        let scene = changed.scene()?;
        *self = changed;
        Ok(scene)
    }

    /// Returns `true` if a dotted key was given; for `cloud.*`, if any cloud has it.
    pub fn has(&self, key: &str) -> bool {
        fn look(node: &Node, rest: &[&str]) -> bool {
            match (rest, &node.value) {
                ([], _) => true,
                ([key, rest @ ..], Value::Table(entries)) => {
                    entries.get(*key).is_some_and(|(_, node)| look(node, rest))
                }
                (["*", rest @ ..], Value::Array(items)) => items.iter().any(|item| look(item, rest)),
                ([index, rest @ ..], Value::Array(items)) => {
                    index.parse().ok().and_then(|i: usize| items.get(i)).is_some_and(|item| look(item, rest))
                }
                _ => false,
            }
        }
        look(&self.root, &path(key))
    }

    /// Returns the scene file that it was read from, if it was.
    pub fn file(&self) -> Option<&Path> {
        self.file.as_deref()
    }

    /// Returns the files that the keys name: those of clouds, of the heights of pictures, and of polygons.
    pub fn named_files(&self) -> Vec<PathBuf> {
        let mut files = Vec::new();
        collect_files(&self.root, &[], self.folder.as_deref(), &mut files);
        files
    }

    /// Returns the document as a TOML text for a file in `folder`. Files of clouds are found from there: by their names
    /// below it, else by their absolute paths.
    ///
    /// # Errors
    /// A path that isn't UTF-8, which TOML can't hold, or no current folder.
    pub fn to_toml(&self, folder: &Path) -> Result<String, Error> {
        let absolute =
            |path: &Path| std::path::absolute(path).map_err(|source| Error::Read { path: path.to_owned(), source });
        // The empty path is the current folder.
        let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
        let target = absolute(folder)?;
        let moved = |path: &Path| {
            let path = absolute(&self.folder.as_deref().map_or_else(|| path.into(), |folder| folder.join(path)))?;
            let path = path.strip_prefix(&target).map(Path::to_owned).unwrap_or(path);
            path.into_os_string().into_string().map_err(|path| {
                Error::Usage(format!("{}: a scene file can't hold this path, which is not UTF-8", path.display()))
            })
        };
        let mut written = self.clone();
        if self.leaves_background() {
            // A scene file without one has a black background.
            written.put("image.background", Setting::from("auto"))?;
        }
        let value = to_toml(&written.root, &[], &moved)?;
        Ok(toml::to_string(&value).unwrap_or_default())
    }
}

impl Scene {
    /// Returns the scene that `text` describes. `origin` is the file's path: named in errors, and clouds are relative
    /// to its folder.
    ///
    /// # Errors
    /// Whatever is wrong with the text, with line and column.
    pub fn from_toml(text: &str, origin: &Path) -> Result<Self, Error> {
        Self::from_toml_with(text, origin, &Overrides::default())
    }

    /// Reads a scene like [`Scene::from_toml`], with options merged into the file before any check.
    ///
    /// # Errors
    /// Invalid text (with line and column) or an invalid option (with its name).
    pub fn from_toml_with(text: &str, origin: &Path, overrides: &Overrides) -> Result<Self, Error> {
        Document::from_toml(text, origin, overrides)?.scene()
    }

    /// Returns the scene in the file `path`, with options laid over it.
    ///
    /// # Errors
    /// A file that is missing, empty, too large or not text, and all of [`Scene::from_toml_with`].
    pub fn read(path: &Path, overrides: &Overrides) -> Result<Self, Error> {
        Document::read(path, overrides)?.scene()
    }

    /// Returns a scene of cloud files with every default, and options laid over it.
    ///
    /// # Errors
    /// Whatever is wrong with an option.
    pub fn from_clouds(
        paths: impl IntoIterator<Item = impl AsRef<Path>>,
        overrides: &Overrides,
    ) -> Result<Self, Error> {
        Document::from_clouds(paths, overrides)?.scene()
    }
}

/// The segments of a dotted path; empty for an empty one.
fn path(dotted: &str) -> Vec<&str> {
    dotted.split('.').filter(|segment| !segment.is_empty()).collect()
}

/// Adds a table to the end of an array, if a path goes through the place there. An array that is missing is made.
fn grow(node: &mut Node, path: &[&str], place: &Place) {
    let [key, rest @ ..] = path else { return };
    let new = |value| Node { place: place.clone(), value };
    match &mut node.value {
        Value::Table(entries) => {
            if let (["0", _, ..], false) = (rest, entries.contains_key(*key)) {
                entries.insert((*key).to_owned(), (place.clone(), new(Value::Array(Vec::new()))));
            }
            if let Some((_, node)) = entries.get_mut(*key) {
                grow(node, rest, place);
            }
        }
        Value::Array(items) if *key == "*" => items.iter_mut().for_each(|item| grow(item, rest, place)),
        Value::Array(items) => {
            let index = key.parse().unwrap_or(usize::MAX);
            if index == items.len() && !rest.is_empty() {
                items.push(new(Value::Table(Entries::new())));
            }
            if let Some(item) = items.get_mut(index) {
                grow(item, rest, place);
            }
        }
        _ => {}
    }
}

/// Returns `true` if the value of a key is the name of a file.
fn is_file(keys: &[&str]) -> bool {
    matches!(keys, ["cloud", "path"] | ["cloud", "photo", "heights"] | ["clip", "polygon"])
}

/// Collects the files that a value names, of which relative ones start from a folder; `keys` lead to it.
fn collect_files(node: &Node, keys: &[&str], folder: Option<&Path>, files: &mut Vec<PathBuf>) {
    match &node.value {
        Value::Table(entries) => entries.iter().for_each(|(key, (_, node))| {
            collect_files(node, &[keys, &[key.as_str()]].concat(), folder, files);
        }),
        Value::Array(items) => items.iter().for_each(|item| collect_files(item, keys, folder, files)),
        Value::String(text) if is_file(keys) => files.push(folder.unwrap_or(Path::new("")).join(text)),
        Value::Path(path) => files.push(path.clone()),
        _ => {}
    }
}

/// A value with the files in it moved. `keys` lead to it.
fn to_toml(node: &Node, keys: &[&str], moved: &dyn Fn(&Path) -> Result<String, Error>) -> Result<toml::Value, Error> {
    Ok(match &node.value {
        Value::Table(entries) => {
            let entry = |(key, (_, node)): (&String, &(Place, Node))| {
                Ok((key.clone(), to_toml(node, &[keys, &[key.as_str()]].concat(), moved)?))
            };
            toml::Value::Table(entries.iter().map(entry).collect::<Result<_, Error>>()?)
        }
        Value::Array(items) => {
            toml::Value::Array(items.iter().map(|item| to_toml(item, keys, moved)).collect::<Result<_, _>>()?)
        }
        Value::String(text) if is_file(keys) => toml::Value::String(moved(Path::new(text))?),
        Value::Path(path) => toml::Value::String(moved(path)?),
        Value::String(text) => toml::Value::String(text.clone()),
        Value::Integer(i) => toml::Value::Integer(*i),
        Value::Float(f) => toml::Value::Float(*f),
        Value::Boolean(flag) => toml::Value::Boolean(*flag),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "
        [image]
        background = [0.86, 0.1, 1]
        [camera]
        eye = [4500000.1, 0.30000000000000004, -1e-300]
        [[cloud]]
        path = 'a.ply'
        opacity = 0.25
        [[cloud]]
        path = '/data/b.ply'
        [[clip]]
        polygon = 'area.geojson'
        [method]
        name = 'sorted'
        shape = 'flat'
    ";

    fn document() -> Document {
        Document::from_toml(TEXT, Path::new("/scans/s.toml"), &Overrides::default()).unwrap()
    }

    #[test]
    fn a_written_document_parses_to_the_same_scene() {
        let (document, plain) = (document(), |scene: Scene| Scene { settings: String::new(), ..scene });
        for folder in ["/scans", "/scans/views", "/elsewhere"] {
            let text = document.to_toml(Path::new(folder)).unwrap();
            let again = Document::from_toml(&text, &Path::new(folder).join("t.toml"), &Overrides::default()).unwrap();
            assert_eq!(plain(again.scene().unwrap()), plain(document.scene().unwrap()), "{text}");
        }
        assert!(document.to_toml(Path::new("/scans")).unwrap().contains("path = \"a.ply\""));
        let moved = document.to_toml(Path::new("/else")).unwrap();
        assert!(moved.contains("path = \"/scans/a.ply\"") && moved.contains("polygon = \"/scans/area.geojson\""));
    }

    #[test]
    fn a_value_that_makes_no_scene_changes_nothing() {
        let mut document = document();
        let scene = document.set("cloud.*.opacity", Setting::Number(0.5)).unwrap();
        assert_eq!(scene.clouds.iter().map(|cloud| cloud.opacity).collect::<Vec<_>>(), [0.5, 0.5]);
        let error = document.set("cloud.1.opacity", Setting::Number(1.5)).unwrap_err().to_string();
        assert!(error.starts_with("cloud.1.opacity: "), "{error}");
        assert_eq!(document.scene().unwrap().clouds[1].opacity, 0.5);
        document.put("camera.height", Setting::Number(3.0)).unwrap();
        document.remove("camera", "eye");
        assert_eq!(document.scene().unwrap().camera.eye, None);
        assert_eq!(document.scene().unwrap().camera.height, Some(3.0));
    }

    #[test]
    fn options_are_laid_over_all_or_none() {
        let mut document = document();
        let mut overrides = Overrides::default();
        overrides.set("opacity=0.5", "cloud.*.opacity", "0.5").unwrap();
        overrides.append("class", "cloud.1.class", "{ id = \"building\", opacity = 0.1 }").unwrap();
        let scene = document.lay_over(&overrides).unwrap();
        assert_eq!((scene.clouds[0].opacity, scene.clouds[1].class[0].opacity), (0.5, Some(0.1)));
        overrides.set("opacity=0.75", "cloud.*.opacity", "0.75").unwrap();
        overrides.set("size=2", "image.size", "2").unwrap();
        let error = document.lay_over(&overrides).unwrap_err().to_string();
        assert!(error.starts_with("size=2: "), "{error}");
        assert_eq!(document.scene().unwrap().clouds[0].opacity, 0.5);
    }

    #[test]
    fn the_files_of_a_scene_are_those_that_its_keys_name() {
        let mut document = document();
        document.put("cloud.0.photo.heights", Setting::Word("h.png".into())).unwrap();
        let mut files = document.named_files();
        files.sort();
        assert_eq!(files, ["/data/b.ply", "/scans/a.ply", "/scans/area.geojson", "/scans/h.png"].map(PathBuf::from));
        let typed = Document::from_clouds(["x.ply"], &Overrides::default()).unwrap();
        assert_eq!((typed.named_files(), typed.file()), (vec![PathBuf::from("x.ply")], None));
    }

    #[test]
    fn keys_of_clouds_and_tables_can_be_taken_out() {
        let mut document = document();
        assert!(document.has("cloud.*.opacity") && document.has("cloud.0.opacity") && !document.has("cloud.1.opacity"));
        assert!(document.has("image") && !document.has("shadows") && !document.has("cloud.2.path"));
        document.remove("cloud.0", "opacity");
        assert!(!document.has("cloud.*.opacity"));
        assert_eq!(document.scene().unwrap().clouds[0].opacity, 1.0);
        document.set("cloud.*.radius", Setting::Number(0.5)).unwrap();
        document.remove("cloud.*", "radius");
        assert_eq!(document.scene().unwrap().clouds[1].radius, None);
        document.remove("", "image");
        assert_eq!(document.scene().unwrap().image, Default::default());
        // Removing an absent key is fine.
        for (table, key) in [("cloud.7", "opacity"), ("cloud.x", "opacity"), ("method.name", "x"), ("a.b", "c")] {
            document.remove(table, key);
        }
        assert!(document.scene().is_ok());
    }

    #[test]
    fn tables_of_arrays_come_and_go() {
        let mut document = document();
        let corner = |x: f64| Some(Setting::from([x; 3]));
        let new = [("clip.1.box.min".to_owned(), corner(0.0)), ("clip.1.box.max".to_owned(), corner(1.0))];
        assert_eq!(document.change(&new).unwrap().clips.len(), 2);
        let before = document.to_toml(Path::new("/scans")).unwrap();
        let far = ("clip.3.invert".to_owned(), Some(Setting::Flag(true)));
        assert!(document.change(std::slice::from_ref(&far)).is_err(), "not the next one");
        assert_eq!(document.to_toml(Path::new("/scans")).unwrap(), before);
        // The array of a cloud that has none yet.
        let class = |key: &str, value| (format!("cloud.1.class.0.{key}"), Some(value));
        let given = [class("id", Setting::Integer(6)), class("opacity", Setting::Number(0.5))];
        let scene = document.change(&given).unwrap();
        assert_eq!((scene.clouds[0].class.len(), scene.clouds[1].class[0].opacity), (0, Some(0.5)));
        let scene = document.change(&[("clip.0".to_owned(), None), ("cloud.1.class.0".to_owned(), None)]).unwrap();
        assert!(matches!(scene.clips[..], [crate::Clip { shape: crate::ClipShape::Box { .. }, .. }]));
        assert!(scene.clouds[1].class.is_empty());
        document.remove("clip", "7");
        assert_eq!(document.scene().unwrap().clips.len(), 1);
    }

    #[test]
    fn several_keys_are_one_change() {
        let mut document = document();
        let given = |key: &str, value| (key.to_owned(), Some(value));
        let out = |key: &str| (key.to_owned(), None);
        document.change(&[given("method.softness", Setting::Number(0.25))]).unwrap();
        // Both would be an error, and a class field needs its classes.
        let both = [given("method.lambda", Setting::Number(2.0)), out("method.softness")];
        document.change(&both).unwrap();
        assert!(document.has("method.lambda") && !document.has("method.softness"));
        let field = given("cloud.0.field", Setting::Word("classification".into()));
        let before = document.to_toml(Path::new("/scans")).unwrap();
        assert!(document.change(&[out("method.lambda"), field.clone()]).is_err());
        assert_eq!(document.to_toml(Path::new("/scans")).unwrap(), before, "all or nothing");
        let scene = document.change(&[field, given("cloud.0.soft_classes", Setting::Integers(vec![5]))]).unwrap();
        assert!(scene.clouds[0].field.is_some());
        // A word makes room for a table.
        document.change(&[given("shading.light", Setting::Word("headlight".into()))]).unwrap();
        let position = given("shading.light.position", Setting::Numbers(vec![1.0, 2.0, 3.0]));
        assert!(document.change(std::slice::from_ref(&position)).is_err());
        document.change(&[out("shading.light"), position]).unwrap();
        document.change(&[out("shading")]).unwrap();
        assert!(!document.has("shading"));
    }

    #[test]
    fn clouds_of_the_command_line_are_found_from_anywhere() {
        let document = Document::from_clouds(["scan.laz"], &Overrides::default()).unwrap();
        assert!(document.to_toml(Path::new("")).unwrap().contains("path = \"scan.laz\""));
        let elsewhere = document.to_toml(Path::new("/elsewhere")).unwrap();
        let here = std::env::current_dir().unwrap().join("scan.laz");
        assert!(elsewhere.contains(&here.display().to_string()), "{elsewhere}");
    }
}
