//! From the tree of keys to a checked [`Scene`].

use std::path::Path;

use glam::DVec3;

use super::document::Document;
use super::error::{Error, Place};
use super::keys::{SHADING_KEYS, SHADOW_KEYS};
use super::method;
use super::overrides::Overrides;
use super::photo;
use super::settings::*;
use super::table::{Range, Table};
use super::tree::{Node, Value};
use crate::cloud::field::Field;
use crate::image::MAX_SIDE;
use crate::io::ColumnNames;

/// Scene files are text written by hand; one above this size is something else.
const MAX_FILE_BYTES: u64 = 16 << 20;

impl Scene {
    /// The scene that `text` describes. `origin` is the file's path: named in errors, and clouds are relative to its folder.
    ///
    /// # Errors
    /// Whatever is wrong with the text, with line and column.
    pub fn from_toml(text: &str, origin: &Path) -> Result<Self, Error> {
        Self::from_toml_with(text, origin, &Overrides::default())
    }

    /// As [`Scene::from_toml`], with options laid over the file before any check.
    ///
    /// # Errors
    /// Whatever is wrong with the text (with line and column) or with an option (by its name).
    pub fn from_toml_with(text: &str, origin: &Path, overrides: &Overrides) -> Result<Self, Error> {
        Document::from_toml(text, origin, overrides)?.scene()
    }

    /// The scene in the file `path`, with options laid over it.
    ///
    /// # Errors
    /// A file that is missing, empty, too large or not text, and all of [`Scene::from_toml_with`].
    pub fn read(path: &Path, overrides: &Overrides) -> Result<Self, Error> {
        Document::read(path, overrides)?.scene()
    }

    /// A scene of cloud files with every default, and options laid over it.
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

/// A scene file's text.
pub(super) fn read_text(path: &Path) -> Result<String, Error> {
    use std::io::Read;
    let failed = |source| Error::Read { path: path.to_owned(), source };
    let mut bytes = Vec::new();
    let file = std::fs::File::open(path).map_err(failed)?;
    file.take(MAX_FILE_BYTES + 1).read_to_end(&mut bytes).map_err(failed)?;
    if bytes.is_empty() {
        return Err(Error::Empty { path: path.to_owned() });
    }
    if bytes.len() as u64 > MAX_FILE_BYTES {
        let message = format!("more than {} MiB: this is no scene file", MAX_FILE_BYTES >> 20);
        return Err(failed(std::io::Error::new(std::io::ErrorKind::InvalidData, message)));
    }
    String::from_utf8(bytes).map_err(|error| {
        let valid = error.as_bytes().get(..error.utf8_error().valid_up_to()).unwrap_or_default();
        let line = 1 + valid.iter().filter(|byte| **byte == b'\n').count();
        let column = 1 + valid.iter().rev().take_while(|byte| **byte != b'\n').count();
        let place = Place::File { path: path.display().to_string(), line, column };
        Error::Syntax { place, message: "not UTF-8 text, so not TOML".into() }
    })
}

pub(super) fn read_scene(root: &Node, folder: Option<&Path>) -> Result<Scene, Error> {
    let table = Table::root(root)?;
    table.refuse_unknown(&["image", "camera", "shading", "cloud", "method", "shadows"])?;
    let mut warnings = Vec::new();
    let image = image(&table.table("image")?)?;
    let camera = camera(&table.table("camera")?)?;
    let shading = shading(&table.table("shading")?)?;
    let clouds: Vec<_> =
        table.tables("cloud")?.iter().map(|t| cloud(t, folder, &mut warnings)).collect::<Result<_, _>>()?;
    let method = method::read(&table.table("method")?, &mut warnings)?;
    if !method.needs_field() {
        table.tables("cloud")?.iter().for_each(|cloud| warn_of_fields(cloud, &method, &mut warnings));
    }
    let shadows = shadows(&table, &shading, &method, &mut warnings)?;
    if clouds.is_empty() {
        let problem = "there is no cloud: add [[cloud]] with path = \"FILE\"".into();
        return Err(Error::Conflict { place: table.place, problem });
    }
    Ok(Scene { image, camera, shading, clouds, method, shadows, warnings, settings: root.value.to_json().to_string() })
}

fn image(table: &Table<'_>) -> Result<ImageSettings, Error> {
    table.refuse_unknown(&["size", "background", "color"])?;
    let default = ImageSettings::default();
    let size = table.size("size", MAX_SIDE)?.unwrap_or(default.size);
    Ok(ImageSettings {
        size,
        background: table.color("background")?.unwrap_or(default.background),
        color: table
            .choice("color", &[("linear", ColorSpace::Linear), ("encoded", ColorSpace::Encoded)])?
            .unwrap_or(default.color),
    })
}

fn camera(table: &Table<'_>) -> Result<CameraSettings, Error> {
    table.refuse_unknown(&["eye", "target", "up", "fov_y", "height", "near", "far"])?;
    let settings = CameraSettings {
        eye: table.vector("eye")?,
        target: table.vector("target")?,
        up: table.direction("up")?,
        fov_y: table.number("fov_y", Range::open(0.0, 180.0))?,
        height: table.number("height", Range::POSITIVE)?,
        near: table.number("near", Range::POSITIVE)?,
        far: table.number("far", Range::POSITIVE)?,
        ..CameraSettings::default()
    };
    let conflict = |key: &str, problem: String| {
        let place = table.get(key).map_or(&table.place, |node| &node.place).clone();
        Err(Error::Conflict { place, problem })
    };
    if settings.fov_y.is_some() && settings.height.is_some() {
        return conflict(
            "height",
            "`camera.fov_y` (perspective) and `camera.height` (orthographic) are both given: keep one".into(),
        );
    }
    if let (Some(near), Some(far)) = (settings.near, settings.far)
        && near >= far
    {
        return conflict("near", format!("`camera.near` must lie below `camera.far`, found {near} and {far}"));
    }
    if let (Some(eye), Some(target)) = (settings.eye, settings.target) {
        let Some(forward) = (target - eye).try_normalize() else {
            return conflict("target", format!("`camera.eye` and `camera.target` are the same point, {eye}"));
        };
        if let Some(up) = settings.up
            // The bound of `Camera::look_at`.
            && forward.cross(up.normalize_or_zero()).length() < 1e-6
        {
            return conflict("up", format!("`camera.up` {up} points along the view, from {eye} to {target}"));
        }
    }
    Ok(settings)
}

fn shading(table: &Table<'_>) -> Result<Shading, Error> {
    table.refuse_unknown(SHADING_KEYS)?;
    let default = Shading::default();
    let models = [("none", ShadingModel::None), ("lambert", ShadingModel::Lambert), ("phong", ShadingModel::Phong)];
    let factor = |key, default| Ok::<_, Error>(table.number32(key, Range::NOT_NEGATIVE)?.unwrap_or(default));
    Ok(Shading {
        model: table.choice("model", &models)?.unwrap_or(default.model),
        ambient: factor("ambient", default.ambient)?,
        diffuse: factor("diffuse", default.diffuse)?,
        specular: factor("specular", default.specular)?,
        shininess: factor("shininess", default.shininess)?,
        light: light(table)?.unwrap_or(default.light),
    })
}

fn light(table: &Table<'_>) -> Result<Option<Light>, Error> {
    let Some(node) = table.get("light") else { return Ok(None) };
    match &node.value {
        Value::String(word) if word == "headlight" => Ok(Some(Light::Headlight)),
        Value::Array(_) => Ok(table.direction("light")?.map(Light::Direction)),
        Value::Table(_) => {
            let light = table.table("light")?;
            light.refuse_unknown(&["position"])?;
            match light.vector("position")? {
                Some(position) => Ok(Some(Light::Position(position))),
                None => Err(table.error("light", node, "must have a `position` if it is a table".into())),
            }
        }
        other => {
            let problem = format!(
                "must be \"headlight\", a direction [x, y, z] or {{ position = [x, y, z] }}, found {}",
                other.describe()
            );
            Err(table.error("light", node, problem))
        }
    }
}

/// The keys of a cloud that only methods with solid and soft points read.
const FIELD_KEYS: [&str; 3] = ["field", "soft_classes", "axis"];

fn cloud(table: &Table<'_>, folder: Option<&Path>, warnings: &mut Vec<String>) -> Result<CloudSettings, Error> {
    let own =
        ["path", "color", "opacity", "radius", "radius_factor", "neighbors", "translate", "scale", "photo", "columns"];
    table.refuse_unknown(&[&own[..], &FIELD_KEYS].concat())?;
    Ok(CloudSettings {
        path: path(table, folder)?,
        color: table.color("color")?,
        opacity: table.number32("opacity", Range::UNIT)?.unwrap_or(1.0),
        radius: table.number32("radius", Range::NOT_NEGATIVE)?,
        radius_factor: table.number32("radius_factor", Range::NOT_NEGATIVE)?.unwrap_or(1.0),
        neighbors: table.integer("neighbors", 1, 65_535)?.map(|k| k as usize),
        field: field(table, warnings)?,
        translate: table.vector("translate")?.unwrap_or(DVec3::ZERO),
        scale: table.number("scale", Range::POSITIVE)?.unwrap_or(1.0),
        photo: photo::read(table, folder, warnings)?,
        columns: columns(table)?,
    })
}

fn columns(table: &Table<'_>) -> Result<Option<ColumnNames>, Error> {
    let (Some(text), Some(node)) = (table.string("columns")?, table.get("columns")) else { return Ok(None) };
    ColumnNames::parse(text)
        .map(Some)
        .map_err(|problem| table.error("columns", node, format!("names columns: {problem}")))
}

fn warn_of_fields(cloud: &Table<'_>, method: &MethodChoice, warnings: &mut Vec<String>) {
    for node in FIELD_KEYS.into_iter().filter_map(|key| Some((key, cloud.get(key)?))) {
        let (key, Node { place, .. }) = node;
        let name = method.name();
        warnings.push(format!(
            "{place}: method {name:?} does not use `{key}` (a key for soft-base, soft-concentric, soft-express, one-layer)"
        ));
    }
}

fn path(table: &Table<'_>, folder: Option<&Path>) -> Result<std::path::PathBuf, Error> {
    if let Some(Node { value: Value::Path(path), .. }) = table.get("path") {
        return Ok(path.clone());
    }
    match table.string("path")? {
        Some(path) => Ok(folder.map_or_else(|| path.into(), |folder| folder.join(path))),
        None => {
            let problem = "a [[cloud]] needs `path`, the file of its points".into();
            Err(Error::Conflict { place: table.place.clone(), problem })
        }
    }
}

fn field(table: &Table<'_>, warnings: &mut Vec<String>) -> Result<Option<Field>, Error> {
    let classes = table.integers("soft_classes", 255)?;
    let axis = table.table("axis")?;
    axis.refuse_unknown(&["point", "direction"])?;
    let point = axis.vector("point")?.map(|p| p.to_array());
    let direction = axis.direction("direction")?.map(|d| d.to_array());
    let name = table.string("field")?;
    for (key, kind) in [("soft_classes", "classification"), ("axis", "distance-to-axis")] {
        if let (Some(node), true) = (table.get(key), name != Some(kind)) {
            warnings.push(format!("{}: `{key}` has no effect without field = {kind:?}", node.place));
        }
    }
    Ok(Some(match name {
        None => return Ok(None),
        Some("uncertainty") => Field::Uncertainty,
        Some("classification") => {
            let Some(mut classes) = classes else {
                let place = table.get("field").map_or(&table.place, |node| &node.place).clone();
                let problem = "field = \"classification\" needs soft_classes, as in soft_classes = [3, 4, 5]".into();
                return Err(Error::Conflict { place, problem });
            };
            classes.sort_unstable();
            classes.dedup();
            // The range was checked.
            Field::Classification { classes: classes.into_iter().map(|class| class as u8).collect() }
        }
        Some("intensity") => Field::Intensity,
        Some("distance-to-axis") => Field::DistanceToAxis { point, direction },
        Some(name) => Field::Property { name: name.to_owned() },
    }))
}

/// `[shadows]`; what can't have any leaves a warning. What `auto` stands for is known only when there are points.
fn shadows(
    root: &Table<'_>,
    shading: &Shading,
    method: &MethodChoice,
    warnings: &mut Vec<String>,
) -> Result<Option<Shadows>, Error> {
    let table = root.table("shadows")?;
    table.refuse_unknown(SHADOW_KEYS)?;
    table.choice("method", &[("texture", ())])?;
    let default = Shadows::default();
    let shadows = Shadows {
        samples: table.integer("samples", 1, MAX_SHADOW_SAMPLES)?.unwrap_or(default.samples),
        light_radius: table.number32("light_radius", Range::NOT_NEGATIVE)?.unwrap_or(default.light_radius),
        resolution: table.integer("resolution", 1, MAX_SIDE)?.unwrap_or(default.resolution),
        min_layer_distance: table.number32("min_layer_distance", Range::POSITIVE)?,
    };
    if let (Some(node), Light::Direction(_)) = (table.get("light_radius"), shading.light)
        && shadows.light_radius >= 90.0
    {
        let problem = format!("around a direction must be below 90 degrees, found {}", shadows.light_radius);
        return Err(table.error("light_radius", node, problem));
    }
    let why = if root.get("shadows").is_none() {
        return Ok(None);
    } else if !method.may_take_shadows() {
        format!("method {:?} takes no shadows: points, squares, circles and other opaque methods do", method.name())
    } else if shading.model == ShadingModel::None {
        "without shading there are no shadows: shading.model = \"lambert\" or \"phong\" has some".to_owned()
    } else if shading.light == Light::Headlight {
        "a headlight casts no shadows: give shading.light a direction or a position".to_owned()
    } else {
        return Ok(Some(shadows));
    };
    warnings.push(format!("{}: [shadows] has no effect: {why}", table.place));
    Ok(None)
}
