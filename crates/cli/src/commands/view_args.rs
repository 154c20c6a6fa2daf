//! The options for where a camera stands: `--view`, `--azimuth`, `--elevation`, `--up`, `--ortho`.

use clap::Args;
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use glam::DVec3;
use pellucid_engine::Result;
use pellucid_engine::scene::{Overrides, Vertical, View, ViewName};

/// From where a scene is looked at.
#[derive(Debug, Args)]
// A group of this name would be that of `view`'s own options.
#[group(skip)]
pub struct ViewArgs {
    /// Frame the whole scene from a named side, or from where a compass points. This and the two angles replace the camera's eye
    /// and target. Without any of them the camera stands to the right of the front and above, or a quarter farther around if
    /// the scene is clearly broader from there.
    #[arg(long, value_name = "NAME", value_parser = view_name())]
    view: Option<ViewName>,
    /// Degrees around the vertical: 0 from the front (−Y of surveys, +Z of models), 90 from +X; or where a compass points, as in
    /// SW: N is +Y of surveys and −Z of models, E is +X.
    #[arg(long, value_name = "DEG", allow_hyphen_values = true, value_parser = azimuth)]
    azimuth: Option<f64>,
    /// Degrees above the horizon, from −90 to 90.
    #[arg(long, value_name = "DEG", allow_hyphen_values = true, value_parser = elevation)]
    elevation: Option<f64>,
    /// The vertical, as in y or -z: the axis that points to the top of the image. By default the scene file's camera.up, else Y for
    /// PLY (Z for one in survey coordinates, or that only lies or stands with Z up), Z for all other point clouds; −Y for PLY and PCD of
    /// a depth camera.
    #[arg(long, value_name = "AXIS", allow_hyphen_values = true, value_parser = axis)]
    up: Option<Vertical>,
    /// An orthographic camera; without camera.height it shows the whole scene.
    #[arg(long)]
    ortho: bool,
}

impl ViewArgs {
    /// The direction that was asked for.
    pub fn view(&self) -> View {
        View { name: self.view, azimuth: self.azimuth, elevation: self.elevation }
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

/// One of the directions that have names.
fn view_name() -> impl TypedValueParser<Value = ViewName> {
    let values = ViewName::ALL.iter().map(|(_, word, about)| PossibleValue::new(*word).help(*about));
    PossibleValuesParser::new(values).try_map(|word| ViewName::named(&word).ok_or("no such view"))
}

fn finite(text: &str) -> Result<f64, String> {
    text.parse().ok().filter(|x: &f64| x.is_finite()).ok_or_else(|| "expected a number of degrees".into())
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
    let degrees = point.map(|point| 45.0 * point as f64).or_else(|| finite(text).ok());
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

fn elevation(text: &str) -> Result<f64, String> {
    finite(text).ok().filter(|x| x.abs() <= 90.0).ok_or_else(|| "expected degrees from -90 to 90".into())
}
