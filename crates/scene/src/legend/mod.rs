//! Meaning of the colors of a scene's points, and lengths: the facts of a legend, without its looks.

mod scale_bar;

use glam::{DVec3, Vec3};
use rayon::prelude::*;

use super::classes::Rules;
use super::clip::Clips;
use super::coloring::Coloring;
use super::error::Error;
use super::seen::seen;
use super::settings::ColorBy;
use super::units::Units;
use pellucid_core::camera::Camera;
use pellucid_core::cloud::crs::Unit;
use pellucid_core::color::colormap::Colormap;
use pellucid_core::color::scale::Scale;
use pellucid_core::color::{classes, encode_srgb_f64};
use pellucid_core::parallel;

pub use scale_bar::ScaleBar;

/// Unit of lengths where files don't say.
const UNITS: &str = "units";

/// Columns that are lengths.
const LENGTHS: [&str; 4] = ["x", "y", "z", "radius"];

/// The meaning of the colors of a scene's clouds. Empty where colors are the file's or have no meaning.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Legend {
    /// Clouds with the same meanings share an entry; in the order of the scene.
    pub entries: Vec<Entry>,
    /// The number of the scene's clouds.
    clouds: usize,
    /// Units of lengths.
    units: Units,
}

/// The meaning of the colors of some clouds.
#[derive(Debug, Clone, PartialEq)]
pub struct Entry {
    /// Numbers of the clouds in the scene, from 0.
    clouds: Vec<usize>,
    /// The names of their files, without folders.
    files: Vec<String>,
    /// Name and unit of what the colors show; `None` if single colors were given to some points.
    pub heading: Option<String>,
    /// Values by way of a color map.
    pub values: Option<Values>,
    /// Single colors.
    pub swatches: Vec<Swatch>,
    /// `true` if each cloud has a color of its own.
    by_cloud: bool,
}

/// Values and their colors.
#[derive(Debug, Clone, PartialEq)]
pub struct Values {
    /// Scale that maps values to places, 0 to 1.
    pub scale: Scale,
    /// `true` for values that are whole numbers.
    pub whole: bool,
    /// Phrase for what else colors depend on.
    pub note: Option<&'static str>,
    map: Colormap,
    reverse: bool,
}

impl Values {
    /// Returns the color at a place of the scale, 0 at its low end and 1 at its high one: sRGB, each from 0 to 1.
    pub fn srgb(&self, place: f64) -> DVec3 {
        self.map.srgb(if self.reverse { 1.0 - place } else { place })
    }
}

/// A color and its meaning.
#[derive(Debug, Clone, PartialEq)]
pub struct Swatch {
    /// sRGB, each from 0 to 1.
    pub srgb: DVec3,
    /// Name of what has this color.
    pub label: String,
}

impl Swatch {
    fn of_linear(linear: Vec3, label: String) -> Self {
        Self {
            srgb: DVec3::from(linear.as_dvec3().to_array().map(encode_srgb_f64)).clamp(DVec3::ZERO, DVec3::ONE),
            label,
        }
    }
}

impl Legend {
    /// Returns a legend without entries, for a scene with these units.
    pub(super) fn new(units: Units) -> Self {
        Self { units, ..Self::default() }
    }

    /// Returns the longest scale bar for an image of so many columns and rows; `None` in perspective.
    pub fn scale_bar(&self, camera: &Camera, size: [u32; 2]) -> Option<ScaleBar> {
        ScaleBar::of(camera, size, self.units.along(camera.right))
    }

    /// Returns `true` if there is nothing to explain.
    pub fn is_empty(&self) -> bool {
        self.entries.is_empty()
    }

    /// Returns the title of an entry: its files, unless it is about all clouds.
    pub fn title(&self, entry: &Entry) -> Option<String> {
        if entry.by_cloud || entry.files.len() == self.clouds {
            return None;
        }
        match &entry.files[..] {
            [] => None,
            [one] => Some(one.clone()),
            [one, other] => Some(format!("{one}, {other}")),
            [first, others @ ..] => Some(format!("{first} and {} others", others.len())),
        }
    }

    /// Returns the entry about a cloud, by its number in the scene.
    pub fn entry_of(&self, cloud: usize) -> Option<&Entry> {
        self.entries.iter().find(|entry| entry.clouds.contains(&cloud))
    }

    /// Adds the meaning of the colors of the scene's next cloud. `fields` as for [`Coloring::colors`]; `dropped` marks
    /// points that are left out.
    ///
    /// # Errors
    /// The cloud lacks what `color_by` or a class is about.
    pub(super) fn add(
        &mut self,
        coloring: &Coloring<'_>,
        clips: &Clips,
        fields: Option<&[f32]>,
        dropped: Option<&[bool]>,
    ) -> Result<(), Error> {
        self.clouds += 1;
        let Some(mut entry) = entry(coloring, &self.units, clips, fields, dropped)? else { return Ok(()) };
        let alike = |known: &&mut Entry| {
            known.by_cloud && entry.by_cloud
                || (&known.heading, &known.values, &known.swatches) == (&entry.heading, &entry.values, &entry.swatches)
        };
        match self.entries.iter_mut().find(alike) {
            Some(known) => {
                known.clouds.append(&mut entry.clouds);
                known.files.append(&mut entry.files);
                entry.swatches.retain(|swatch| !known.swatches.contains(swatch));
                known.swatches.append(&mut entry.swatches);
            }
            None => self.entries.push(entry),
        }
        Ok(())
    }
}

/// Facts that are met among the points of a cloud that are drawn.
struct Met {
    /// Classes by code: true for those whose points have the class's color.
    classes: Vec<bool>,
    /// Rules by index: true for those about a scalar that give points their color.
    rules: Vec<bool>,
    /// Points whose color is that of `color_by`.
    own: bool,
    /// Points without a value.
    missing: bool,
}

/// The values of a cloud's points and their scale.
type Scaled = Option<(Vec<f64>, Scale)>;

/// The meaning of a cloud's colors, if they have any.
fn entry(
    coloring: &Coloring<'_>,
    units: &Units,
    clips: &Clips,
    fields: Option<&[f32]>,
    dropped: Option<&[bool]>,
) -> Result<Option<Entry>, Error> {
    let Coloring { settings, cloud, index, .. } = coloring;
    let rules = Rules::of(settings, cloud)?;
    let scaled: Scaled = coloring.values(fields)?.map(|values| {
        let scale = coloring.scale(&values);
        (values, scale)
    });
    let met = met(coloring, &rules, clips, &scaled, dropped);
    let file = settings.path.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
    let by_cloud = met.own && coloring.by() == Some(&ColorBy::Cloud);
    let mut swatches = Vec::new();
    if by_cloud {
        swatches.push(Swatch { srgb: classes::distinct(*index), label: file.clone() });
    }
    for code in (0..=u8::MAX).filter(|code| met.classes[usize::from(*code)]) {
        let label = classes::label(code);
        let painted = rules.color_of_class(code).map(|color| Swatch::of_linear(color, label.clone()));
        swatches.push(painted.unwrap_or_else(|| Swatch { srgb: classes::srgb(code), label }));
    }
    let painted = (0..rules.len()).filter(|rule| met.rules[*rule]).filter_map(|rule| rules.described(rule));
    swatches.extend(painted.map(|(words, color)| Swatch::of_linear(color, words)));
    if met.missing {
        swatches.push(Swatch { srgb: DVec3::splat(0.5), label: "no value".to_owned() });
    }
    let values = scaled.filter(|_| met.own).map(|(_, scale)| Values {
        scale,
        whole: matches!(coloring.by(), Some(ColorBy::Return | ColorBy::Source)),
        note: coloring.choice.modulated.then_some("darker where intensity is small"),
        map: settings.coloring.colormap.map(),
        reverse: settings.coloring.reverse,
    });
    let shown = values.is_some() || met.missing || by_cloud;
    let heading = if shown { coloring.by().and_then(|by| quantity(by, coloring, units)) } else { None };
    let heading = heading.or_else(|| met.classes.contains(&true).then(|| "class".to_owned()));
    let anything = values.is_some() || !swatches.is_empty();
    Ok(anything.then(|| Entry { clouds: vec![*index], files: vec![file], heading, values, swatches, by_cloud }))
}

/// Looks at every point that is drawn.
fn met(coloring: &Coloring<'_>, rules: &Rules<'_>, clips: &Clips, scaled: &Scaled, dropped: Option<&[bool]>) -> Met {
    const CODES: usize = 256;
    let Coloring { settings, cloud, .. } = coloring;
    let count = cloud.len();
    let codes = cloud.classification.as_deref();
    let by_class = coloring.by() == Some(&ColorBy::Classification);
    let (own, missing) = (CODES + rules.len(), CODES + rules.len() + 1);
    // Where the meaning of a point's color stands in the list of all meanings.
    let meaning = |i: usize| match (rules.painter(i), codes, scaled) {
        (Some(rule), Some(codes), _) if rules.is_of_classes(rule) => usize::from(codes[i]),
        (Some(rule), ..) => CODES + rule,
        (None, Some(codes), _) if by_class => usize::from(codes[i]),
        (None, _, Some((values, scale))) if values.get(i).is_none_or(|v| scale.place(*v).is_none()) => missing,
        _ => own,
    };
    let shown = {
        // Without clips positions don't matter.
        let positions: Vec<DVec3> =
            if clips.is_empty() { Vec::new() } else { parallel::map_each(&cloud.positions, |p| settings.placed(*p)) };
        seen(rules.visible_points(count), clips, &positions)
    };
    let opacity = settings.surface_opacity.unwrap_or(settings.opacity);
    let alpha = |i: usize| cloud.alphas.as_ref().map_or(1.0, |alphas| alphas[i]);
    let is_drawn = |i: &usize| {
        let is_there = shown.as_ref().is_none_or(|s| s[*i]) && dropped.is_none_or(|dropped| !dropped[*i]);
        is_there && alpha(*i) * rules.opacity(*i).unwrap_or(opacity) > 0.0
    };
    let none = || vec![false; missing + 1];
    let with = |mut all: Vec<bool>, i: usize| {
        all[meaning(i)] = true;
        all
    };
    let either = |a: Vec<bool>, b: Vec<bool>| a.into_iter().zip(b).map(|(a, b)| a || b).collect();
    let mut all = (0..count).into_par_iter().filter(is_drawn).fold(none, with).reduce(none, either);
    let (own, missing) = (all[own], all[missing]);
    let mut rest = all.split_off(CODES);
    rest.truncate(rules.len());
    Met { classes: all, rules: rest, own, missing }
}

/// Returns what colors show, with its unit; `None` if it needs no words.
fn quantity(by: &ColorBy, coloring: &Coloring<'_>, units: &Units) -> Option<String> {
    let with = |words: &str, unit: Option<&Unit>| Some(format!("{words} ({})", unit.map_or(UNITS, Unit::symbol)));
    let words = match by {
        ColorBy::Height => return with("height", units.along(coloring.up())),
        ColorBy::Intensity => "intensity",
        ColorBy::Return => "return number",
        ColorBy::Source => "point source",
        ColorBy::GpsTime => "seconds since the first point",
        ColorBy::Field => "field F",
        ColorBy::Cloud => "cloud",
        ColorBy::Scalar(name) if LENGTHS.contains(&name.as_str()) => {
            return with(name, units.of_column(coloring.index, name));
        }
        ColorBy::Scalar(name) => name,
        ColorBy::Auto | ColorBy::Rgb | ColorBy::Classification | ColorBy::Normal | ColorBy::Uniform => return None,
    };
    Some(words.to_owned())
}
