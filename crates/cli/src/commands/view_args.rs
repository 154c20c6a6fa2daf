//! The options for where a camera stands: `--like`, `--view`, `--azimuth`, `--elevation`, `--up`, `--ortho`.

use std::path::PathBuf;

use clap::Args;
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use glam::DVec3;
use pellucid_engine::Result;
use pellucid_scene::{Overrides, PictureCamera, Vertical, View, ViewName};

use super::headings::CAMERA;
use super::options::number;

/// Options for the viewpoint.
#[derive(Debug, Args)]
// A group of this name would be that of `view`'s own options.
#[group(skip)]
pub struct ViewArgs {
    /// Take camera and size of a picture that was rendered before, from its metadata.
    ///
    /// A PNG or EXR of this program. Its camera replaces that of the scene file, with the depths that were drawn;
    /// --size gives another size. With the inputs and the other options of that picture the same pixels come out; its
    /// metadata list them (pellucid:scene, pellucid:settings, pellucid:seed).
    #[arg(long, value_name = "PICTURE", conflicts_with_all = ["view", "azimuth", "elevation", "up", "ortho"], help_heading = CAMERA)]
    pub like: Option<PathBuf>,
    /// Show the whole scene from a named side or point of the compass.
    ///
    /// --view, --azimuth and --elevation replace the camera's eye and target. Without them the camera stands above, to
    /// the right of the front, or 90 degrees farther around if the scene is clearly broader from there.
    #[arg(long, value_name = "NAME", value_parser = view_name(), help_heading = CAMERA)]
    view: Option<ViewName>,
    /// Direction of the camera around the vertical, in degrees, or as in SW.
    ///
    /// 0 looks from the front (−Y in surveys, +Z in models), 90 from +X. Points of the compass: N is +Y in surveys and
    /// −Z in models, E is +X.
    #[arg(long, value_name = "DEG", allow_hyphen_values = true, value_parser = azimuth, help_heading = CAMERA)]
    azimuth: Option<f64>,
    /// Height of the camera above the horizon in degrees, from −90 to 90.
    #[arg(long, value_name = "DEG", allow_hyphen_values = true, value_parser = number(|x| x.abs() <= 90.0, "expected degrees from -90 to 90"), help_heading = CAMERA)]
    elevation: Option<f64>,
    /// Axis that points up in the image, as in y or -z.
    ///
    /// Default: camera.up of the scene file; else Z. PLY files have Y up, except those in survey coordinates and those
    /// whose shape shows that Z is up. PLY and PCD files of a depth camera have −Y up. Of flat clouds the axis is up
    /// along which they are flattest.
    #[arg(long, value_name = "AXIS", allow_hyphen_values = true, value_parser = axis, help_heading = CAMERA)]
    up: Option<Vertical>,
    /// Use an orthographic camera.
    ///
    /// It shows the whole scene unless camera.height is set.
    #[arg(long, help_heading = CAMERA)]
    ortho: bool,
}

impl ViewArgs {
    /// The direction that was asked for.
    pub fn view(&self) -> View {
        View { name: self.view, azimuth: self.azimuth, elevation: self.elevation }
    }

    /// The camera and the size of the picture of --like. They come first, so that other options win.
    pub fn apply_like(&self, overrides: &mut Overrides) -> Result<()> {
        let Some(picture) = &self.like else { return Ok(()) };
        let (option, found) = (format!("--like {}", picture.display()), PictureCamera::read(picture)?);
        overrides.set(option.clone(), "camera", &found.as_value())?;
        Ok(overrides.set(option, "image.size", &format!("{:?}", found.size))?)
    }

    /// The options that stand for keys of a scene file.
    pub fn apply(&self, overrides: &mut Overrides) -> Result<()> {
        if let Some(up) = self.up {
            overrides.set(format!("--up {up}"), "camera.up", &format!("{:?}", up.up().to_array()))?;
        }
        if self.ortho {
            overrides.set("--ortho", "camera.ortho", "true")?;
        }
        Ok(())
    }
}

/// Parses the name of a view direction.
fn view_name() -> impl TypedValueParser<Value = ViewName> {
    let values = ViewName::ALL.iter().map(|(_, word, about)| PossibleValue::new(*word).help(*about));
    PossibleValuesParser::new(values).try_map(|word| ViewName::named(&word).ok_or("no such view"))
}

/// Degrees, or a point of the compass by its letters or words.
fn azimuth(text: &str) -> Result<f64, String> {
    const COMPASS: [(&str, &str); 8] = [
        ("s", "south"),
        ("se", "south-east"),
        ("e", "east"),
        ("ne", "north-east"),
        ("n", "north"),
        ("nw", "north-west"),
        ("w", "west"),
        ("sw", "south-west"),
    ];
    let lower = text.to_lowercase();
    let point = COMPASS.iter().position(|(letters, words)| lower == *letters || lower == *words);
    let degrees = point.map(|point| 45.0 * point as f64).or_else(|| text.parse().ok().filter(|x: &f64| x.is_finite()));
    degrees.ok_or_else(|| "expected a number of degrees, or N, NE, E, SE, S, SW, W or NW".into())
}

/// An axis and which way it goes.
fn axis(text: &str) -> Result<Vertical, String> {
    let (sign, name) = text.strip_prefix('-').map_or((1.0, text.trim_start_matches('+')), |name| (-1.0, name));
    let direction = match name {
        "x" | "X" => Some(DVec3::X),
        "y" | "Y" => Some(DVec3::Y),
        "z" | "Z" => Some(DVec3::Z),
        _ => None,
    };
    direction.and_then(|axis| Vertical::nearest(sign * axis)).ok_or_else(|| "expected x, y, z, -x, -y or -z".into())
}
