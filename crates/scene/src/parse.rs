//! Turns the tree of keys into a checked [`Scene`].

use std::path::Path;

use super::choice::MethodChoice;
use super::error::{Error, Place};
use super::keys::owners;
use super::method;
use super::methods::{Method, edl_methods};
use super::scene::Scene;
use super::schema::{Key, Settings, Value};
use super::settings::*;
use super::table::{Context, Table};
use super::tree::Node;

/// Scene files are text written by hand; one above this size is something else.
const MAX_FILE_BYTES: u64 = 16 << 20;

/// Returns a scene file's text.
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
        let message = format!("larger than {} MiB: not a scene file", MAX_FILE_BYTES >> 20);
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
    let context = Context { folder, ..Context::default() };
    let table = Table::root(root, &context)?;
    table.refuse_unknown(&["image", "camera", "shading", "cloud", "clip", "method", "shadows", "detail"])?;
    let image = read(&table.table("image")?)?;
    let camera = read(&table.table("camera")?)?;
    let shading: Shading = read(&table.table("shading")?)?;
    let clouds = table.tables("cloud")?;
    let settings: Vec<_> = clouds.iter().map(cloud).collect::<Result<_, _>>()?;
    let clips = table.tables("clip")?.iter().map(Clip::read).collect::<Result<_, _>>()?;
    let method = method::read(&table.table("method")?)?;
    if method.fixed().and_then(Method::pixel_radius).is_some() {
        clouds.iter().try_for_each(check_pixel_radius)?;
    }
    if !method.needs_field() {
        clouds.iter().for_each(|cloud| warn_of_fields(cloud, &method));
    }
    let shadows = shadows(&table, &shading, &method)?;
    let detail = read(&table.table("detail")?)?;
    check_edl(&table, &shading, &method)?;
    if settings.is_empty() {
        return Err(table.conflict("", "no cloud: add [[cloud]] with path = \"FILE\""));
    }
    let warnings = context.warnings.take();
    let json = root.value.to_json().to_string();
    let names_clouds = false;
    Ok(Scene {
        image,
        camera,
        shading,
        clouds: settings,
        clips,
        method,
        detail,
        shadows,
        names_clouds,
        warnings,
        settings: json,
    })
}

/// Returns settings with what a table gives.
pub(super) fn read<T: Settings + Default>(table: &Table<'_>) -> Result<T, Error> {
    let mut settings = T::default();
    table.refuse_unknown(&names(&settings))?;
    settings.read(table)?;
    Ok(settings)
}

/// The keys as their own table has them: `axis`, not `axis.point` and `axis.direction`.
fn names(settings: &impl Settings) -> Vec<&'static str> {
    let name = |key: Key| key.name.split_once('.').map_or(key.name, |(name, _)| name);
    let mut names: Vec<_> = settings.keys().into_iter().map(name).collect();
    names.dedup();
    names
}

fn cloud(table: &Table<'_>) -> Result<CloudSettings, Error> {
    let mut cloud = CloudSettings::default();
    table.refuse_unknown(&names(&cloud))?;
    if table.get("path").is_none() {
        return Err(table.conflict("", "a [[cloud]] needs `path`, the file of its points"));
    }
    cloud.read(table)?;
    if table.get("surface_opacity").is_some() && table.get("opacity").is_some() {
        let problem = "`opacity` (of each splat) and `surface_opacity` (of the surface) exclude each other: keep one";
        return Err(table.conflict("surface_opacity", problem));
    }
    Ok(cloud)
}

fn warn_of_fields(cloud: &Table<'_>, method: &MethodChoice) {
    for (key, Node { place, .. }) in FIELD_KEYS.into_iter().filter_map(|key| Some((key, cloud.get(key)?))) {
        let (name, owners) = (method.name(), owners("threshold").join(", "));
        cloud.warn(format!("{place}: method {name:?} does not use `{key}` (a key for {owners})"));
    }
}

/// Refuses a radius in world units where all splats have one in pixels, and warns of a factor on radii.
fn check_pixel_radius(cloud: &Table<'_>) -> Result<(), Error> {
    let stated = [vec![cloud.clone()], cloud.tables("class")?].concat();
    if let Some(table) = stated.iter().find(|table| table.get("radius").is_some()) {
        let problem = "`method.pixel_radius` (pixels, of all splats) and `radius` of a cloud (world units) exclude each \
                       other: keep one";
        return Err(table.conflict("radius", problem));
    }
    if let Some(node) = cloud.get("radius_factor") {
        cloud.warn(format!("{}: `radius_factor` has no effect with method.pixel_radius", node.place));
    }
    Ok(())
}

/// Refuses eye-dome lighting of a method whose pixels have no depth of a surface. The method that `auto` becomes is
/// only known once the points are.
fn check_edl(root: &Table<'_>, shading: &Shading, method: &MethodChoice) -> Result<(), Error> {
    let Some(method) = method.fixed().filter(|method| shading.edl.edl && !method.takes_edl()) else { return Ok(()) };
    let (name, others) = (method.name(), edl_methods());
    let problem = format!("`shading.edl` needs the depth of a surface, but method {name:?} has none: {others}");
    Err(root.table("shading")?.conflict("edl", problem))
}

/// `[shadows]`; a method that can't have shadows leaves a warning. The method that `auto` becomes is only known once
/// the points are.
fn shadows(root: &Table<'_>, shading: &Shading, method: &MethodChoice) -> Result<Option<Shadows>, Error> {
    let table = root.table("shadows")?;
    let mut shadows = Shadows::default();
    table.refuse_unknown(&[&["method"], &*names(&shadows)].concat())?;
    ShadowMethod::read(&table, "method", ())?;
    shadows.read(&table)?;
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
        "shadows need shading: set shading.model = \"lambert\" or \"phong\"".to_owned()
    } else if shading.light == Light::Headlight {
        "a headlight casts no shadows: give shading.light a direction or a position".to_owned()
    } else {
        return Ok(Some(shadows));
    };
    table.warn(format!("{}: [shadows] has no effect: {why}", table.place));
    Ok(None)
}
