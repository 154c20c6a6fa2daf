//! The colors of a cloud's points by what the cloud has: `color_by` and its keys.

use std::borrow::Borrow;
use std::borrow::Cow;

use glam::{DVec3, Vec3};
use rayon::prelude::*;

use super::classes::Rules;
use super::clip::Clips;
use super::error::Error;
use super::scene::Scene;
use super::seen::seen;
use super::settings::{ClassSettings, Clip, CloudSettings, ColorBy, ColorRange, ColorSettings};
use super::view::Vertical;
use pellucid_core::cloud::facts::Facts;
use pellucid_core::cloud::field;
use pellucid_core::cloud::sampling::Sampling;
use pellucid_core::cloud::{Cloud, GPS_TIME, POINT_SOURCE, RETURN_NUMBER};
use pellucid_core::color::classes;
use pellucid_core::color::colormap::{Colormap, mid_grey};
use pellucid_core::color::decode_srgb_f64;
use pellucid_core::color::scale::Scale;
use pellucid_core::parallel;

/// Classes other than 0 and 1 that a cloud must have to be colored by them.
const ENOUGH_CLASSES: usize = 3;

/// Brightness of a height where intensity is smallest.
const DARKEST: f64 = 0.35;

/// Meaning of the colors of a cloud, once `auto` is decided.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Choice {
    by: ColorBy,
    /// `true` if heights are darker where intensity is small.
    pub modulated: bool,
    /// The reason, as a phrase.
    why: String,
}

impl Choice {
    /// Returns the choice for a cloud without a `color`, some or all of whose points are there.
    pub fn of(by: &ColorBy, cloud: &Cloud, facts: Option<&Facts>) -> Self {
        let choice = |by, modulated, why: &str| Self { by, modulated, why: why.to_owned() };
        if *by != ColorBy::Auto {
            return choice(by.clone(), false, "it was asked for");
        }
        let lacks = match &cloud.colors {
            // Those are what the splats were trained for, and harmonics change them.
            Some(_) if cloud.gaussians.is_some() => return choice(ColorBy::Rgb, false, "the splats have colors"),
            Some(colors) if !facts.map_or_else(|| is_blank(colors), Facts::is_blank) => {
                return choice(ColorBy::Rgb, false, "the file has colors");
            }
            Some(_) => "the file's colors are all black or all white",
            None => "the file has no colors",
        };
        let classes = classes_beside_0_and_1(cloud, facts);
        if classes >= ENOUGH_CLASSES {
            let why = format!("{lacks}, but {classes} classes besides 0 and 1");
            return Self { by: ColorBy::Classification, modulated: false, why };
        }
        let any = |values: &Vec<f32>| values.iter().any(|value| *value != 0.0);
        let modulated = cloud
            .intensity
            .as_ref()
            .is_some_and(|values| facts.map_or_else(|| any(values), |facts| facts.has_intensity));
        choice(ColorBy::Height, modulated, &format!("{lacks} and fewer than {ENOUGH_CLASSES} classes besides 0 and 1"))
    }
}

/// True for colors of which nothing can be seen: all black, or all white.
fn is_blank(colors: &[Vec3]) -> bool {
    colors.par_iter().all(|color| *color == Vec3::ZERO) || colors.par_iter().all(|color| *color == Vec3::ONE)
}

fn classes_beside_0_and_1(cloud: &Cloud, facts: Option<&Facts>) -> usize {
    if let Some(facts) = facts {
        return (2..=u8::MAX).filter(|code| facts.has_class(*code)).count();
    }
    let mut seen = [false; 256];
    cloud.classification.iter().flatten().for_each(|code| seen[usize::from(*code)] = true);
    seen.iter().skip(2).filter(|seen| **seen).count()
}

/// Source of the colors of a cloud's points.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Colors {
    /// The file.
    Own,
    /// All points have the same.
    One(Vec3),
    /// Linear RGB of each point.
    Each(Vec<Vec3>),
}

impl Colors {
    /// Returns the color of each point, of a cloud whose own colors are `own`.
    pub fn into_list(self, own: Option<Vec<Vec3>>, count: usize) -> Vec<Vec3> {
        match self {
            Self::Own => own.unwrap_or_else(|| vec![Vec3::ONE; count]),
            Self::One(color) => vec![color; count],
            Self::Each(colors) => colors,
        }
    }
}

/// The colors of one of a scene's clouds.
pub(super) struct Coloring<'a> {
    pub settings: &'a CloudSettings,
    pub cloud: &'a Cloud,
    /// The place of the cloud in the scene.
    pub index: usize,
    pub choice: Choice,
    /// The vertical along which height is measured.
    vertical: Vertical,
    /// Scales of the whole cloud, if this is a part of it.
    scales: Option<&'a Scales>,
    /// False for points that don't count for scales; `None` if all count.
    counted: Option<Vec<bool>>,
}

/// Facts that the colors of a part of a cloud follow from, in addition to its points.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Scales {
    choice: Choice,
    /// Scale of the values that become colors.
    values: Option<Scale>,
    /// Scale of intensities.
    light: Option<Scale>,
}

/// Says that keys about the color map have no effect on a cloud for which `auto` decides so.
pub(super) fn note(settings: &CloudSettings, cloud: &Cloud) -> Option<String> {
    let asked = ColorSettings { color_by: ColorBy::Auto, ..settings.coloring.clone() };
    if settings.color.is_some() || settings.coloring != asked || asked == ColorSettings::default() {
        return None;
    }
    let Choice { by, why, .. } = Choice::of(&ColorBy::Auto, cloud, None);
    (!by.is_mapped()).then(|| {
        format!(
            "`colormap`, `range`, `reverse` and `log` have no effect, since {why}; color_by (--color-by) height or another \
             value uses them"
        )
    })
}

/// Everything that the colors of a cloud's points depend on.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct ColorKey {
    color: Option<[u32; 3]>,
    /// `None` where `color` overrides it.
    by: Option<(ColorSettings, Vertical)>,
    placement: (u64, [u64; 3]),
    /// Key of the field, if colors show F.
    field: Option<crate::prepare::FieldKey>,
    /// Everything that decides which points are drawn, if the range is theirs.
    drawn: Option<(Vec<Clip>, Vec<ClassSettings>, Option<crate::prepare::outliers::Rule>)>,
}

impl<'a> Coloring<'a> {
    /// Returns the coloring of the cloud at a place in the scene.
    pub fn of(scene: &'a Scene, index: usize, cloud: &'a Cloud) -> Self {
        let choice = Choice::of(&scene.clouds[index].coloring.color_by, cloud, None);
        Self::with(scene, index, cloud, choice, None)
    }

    /// Returns the coloring of a cloud of which some points are there, given the facts of all of them.
    pub fn of_sample(scene: &'a Scene, index: usize, sample: &'a Cloud, facts: &Facts) -> Self {
        let choice = Choice::of(&scene.clouds[index].coloring.color_by, sample, Some(facts));
        Self::with(scene, index, sample, choice, None)
    }

    /// Returns the coloring of a part of a cloud.
    pub fn of_part(scene: &'a Scene, index: usize, part: &'a Cloud, scales: &'a Scales) -> Self {
        Self::with(scene, index, part, scales.choice.clone(), Some(scales))
    }

    fn with(scene: &'a Scene, index: usize, cloud: &'a Cloud, choice: Choice, scales: Option<&'a Scales>) -> Self {
        let vertical = scene.camera.vertical(cloud.up);
        Self { settings: &scene.clouds[index], cloud, index, choice, vertical, scales, counted: None }
    }

    /// Has scales follow from the points that are drawn, if the range asks for that and there are some. `dropped` marks
    /// points that are left out.
    ///
    /// # Errors
    /// The cloud lacks what a class is about.
    pub fn count_drawn(&mut self, clips: &Clips, dropped: Option<&[bool]>) -> Result<(), Error> {
        if self.settings.coloring.range != Some(ColorRange::Drawn) {
            return Ok(());
        }
        let positions = parallel::map_each(&self.cloud.positions, |position| self.settings.placed(*position));
        let visible = Rules::of(self.settings, self.cloud)?.visible_points(positions.len());
        let seen = seen(visible, clips, &positions);
        let counts = |i: usize| {
            positions[i].is_finite()
                && seen.as_ref().is_none_or(|seen| seen[i])
                && dropped.is_none_or(|dropped| !dropped[i])
        };
        self.counted = Some(parallel::map(positions.len(), counts)).filter(|counted| counted.contains(&true));
        Ok(())
    }

    /// Returns the same of another part of the same cloud, with the scales of this one. `fields` as for
    /// [`Coloring::colors`].
    ///
    /// # Errors
    /// The cloud lacks what `color_by` shows.
    pub fn scales(&self, fields: Option<&[f32]>) -> Result<Scales, Error> {
        let values = self.values(fields)?.map(|values| self.scale(&values));
        let light =
            self.cloud.intensity.as_ref().filter(|_| self.choice.modulated).map(|values| self.light(&doubles(values)));
        Ok(Scales { choice: self.choice.clone(), values, light })
    }

    /// Returns the direction along which height is measured, upward.
    pub fn up(&self) -> DVec3 {
        self.vertical.up()
    }

    /// Returns `true` if F of the points must be known.
    pub fn needs_field(&self) -> bool {
        self.settings.color.is_none() && self.choice.by == ColorBy::Field
    }

    /// Returns what the colors depend on. `request` is that of the cloud's data.
    pub fn key(&self, request: &crate::prepare::Request, clips: &[Clip]) -> ColorKey {
        let CloudSettings { color, scale, translate, class, coloring, .. } = self.settings;
        let is_drawn = color.is_none() && coloring.range == Some(ColorRange::Drawn);
        let field = self.needs_field().then(|| request.field_key(self.cloud));
        ColorKey {
            color: color.map(|color| color.to_array().map(f32::to_bits)),
            by: color.is_none().then(|| (self.settings.coloring.clone(), self.vertical)),
            placement: (scale.to_bits(), translate.to_array().map(f64::to_bits)),
            field,
            drawn: is_drawn.then(|| (clips.to_vec(), class.clone(), request.dropped_outliers)),
        }
    }

    /// Returns the coloring and the reason for it, in a phrase.
    pub fn describe(&self) -> String {
        if self.settings.color.is_some() {
            return "the scene's `color`".to_owned();
        }
        let Choice { by, modulated, why } = &self.choice;
        let intensity = if *modulated { ", darker where intensity is small" } else { "" };
        let map =
            if by.is_mapped() { format!(" in {}", self.settings.coloring.colormap.word()) } else { String::new() };
        format!("{}{map}{intensity}: {why}", by.word())
    }

    /// Returns what the colors show; `None` if the scene gives one color in place of it.
    pub fn by(&self) -> Option<&ColorBy> {
        self.settings.color.is_none().then_some(&self.choice.by)
    }

    /// Returns the colors. `fields` is F of each point, if [`Coloring::needs_field`].
    ///
    /// # Errors
    /// The cloud lacks what `color_by` shows.
    pub fn colors(&self, fields: Option<&[f32]>) -> Result<Colors, Error> {
        if let Some(color) = self.settings.color {
            return Ok(Colors::One(color));
        }
        let cloud = self.cloud;
        match &self.choice.by {
            ColorBy::Rgb => cloud.colors.as_ref().map(|_| Colors::Own).ok_or_else(|| self.lacking("colors")),
            ColorBy::Uniform => Ok(Colors::One(Vec3::ONE)),
            ColorBy::Cloud => Ok(Colors::One(linear(classes::distinct(self.index)))),
            ColorBy::Classification => {
                let codes = cloud.classification.as_ref().ok_or_else(|| self.lacking("classes"))?;
                let table: Vec<Vec3> = (0..=u8::MAX).map(|code| linear(classes::srgb(code))).collect();
                Ok(Colors::Each(parallel::map_each(codes, |code| table[usize::from(*code)])))
            }
            ColorBy::Normal => {
                let normals = cloud.normals.as_ref();
                let normals = normals.ok_or_else(|| self.lacking("normals; `prepare --normals` stores some"))?;
                Ok(Colors::Each(parallel::map_each(normals, |normal| of_normal(*normal))))
            }
            _ => {
                let colors = self.mapped(&self.values(fields)?.unwrap_or_default());
                Ok(Colors::Each(if self.choice.modulated { self.modulated(colors) } else { colors }))
            }
        }
    }

    /// Returns the value of each point that becomes a color by way of the colormap; `None` if colors come from
    /// elsewhere. `fields` as for [`Coloring::colors`].
    ///
    /// # Errors
    /// The cloud lacks what `color_by` shows.
    pub fn values(&self, fields: Option<&[f32]>) -> Result<Option<Vec<f64>>, Error> {
        let cloud = self.cloud;
        let scalar = |name: &str| cloud.scalar(name).map(doubles).ok_or_else(|| self.lacking(name));
        if self.settings.color.is_some() {
            return Ok(None);
        }
        let values = match &self.choice.by {
            ColorBy::Auto
            | ColorBy::Rgb
            | ColorBy::Classification
            | ColorBy::Normal
            | ColorBy::Cloud
            | ColorBy::Uniform => return Ok(None),
            ColorBy::Height => {
                let height = |p: &DVec3| self.vertical.up().dot(self.settings.placed(*p));
                parallel::map_each(&cloud.positions, height)
            }
            ColorBy::Intensity => cloud.intensity.as_deref().map(doubles).ok_or_else(|| self.lacking("intensity"))?,
            ColorBy::Return => scalar(RETURN_NUMBER)?,
            ColorBy::Source => scalar(POINT_SOURCE)?,
            ColorBy::GpsTime => scalar(GPS_TIME)?,
            ColorBy::Field => doubles(fields.unwrap_or_default()),
            ColorBy::Scalar(name) => match field::column(cloud, name) {
                Some(values) => values,
                None => scalar(name).map_err(|_| self.no_scalar(name))?,
            },
        };
        Ok(Some(values))
    }

    fn lacking(&self, lacking: &str) -> Error {
        Error::Color {
            path: self.settings.path.clone(),
            by: self.choice.by.word().to_owned(),
            lacking: lacking.to_owned(),
            there: field::there(self.cloud),
        }
    }

    fn no_scalar(&self, name: &str) -> Error {
        let names = field::names(self.cloud);
        let mut known: Vec<&str> = ColorBy::words().collect();
        known.extend(names.iter().map(Cow::as_ref));
        let hint = pellucid_core::words::nearest(name, known, "there are");
        Error::NoScalar { path: self.settings.path.clone(), name: name.to_owned(), key: "color_by", hint }
    }

    /// Returns the scale of the values of all points.
    pub fn scale(&self, values: &[f64]) -> Scale {
        if let Some(known) = self.scales.and_then(|scales| scales.values) {
            return known;
        }
        let range = self.settings.coloring.range.and_then(ColorRange::ends);
        Scale::of(&self.sampled(values), range, self.settings.coloring.log)
    }

    /// The scale of the intensities of all points.
    fn light(&self, values: &[f64]) -> Scale {
        self.scales.and_then(|scales| scales.light).unwrap_or_else(|| Scale::of(&self.sampled(values), None, false))
    }

    /// The values of points that stand for all.
    fn sampled<'v>(&self, values: &'v [f64]) -> Cow<'v, [f64]> {
        let sampling = Sampling::of(values.len() as u64);
        if sampling.takes_all() && self.counted.is_none() {
            return values.into();
        }
        let counts = |i: usize| self.counted.as_ref().is_none_or(|counted| counted[i]);
        let both = self.cloud.positions.par_iter().zip(values).enumerate().with_min_len(1 << 14);
        both.filter(|(i, (position, _))| counts(*i) && sampling.takes(self.settings.placed(**position)))
            .map(|(_, (_, value))| *value)
            .collect::<Vec<_>>()
            .into()
    }

    /// Colors of heights, darker where intensity is small.
    fn modulated(&self, mut colors: Vec<Vec3>) -> Vec<Vec3> {
        let Some(intensities) = &self.cloud.intensity else { return colors };
        let values = doubles(intensities);
        let scale = self.light(&values);
        let light = |value: f64| scale.place(value).map_or(1.0, |t| DARKEST + (1.0 - DARKEST) * t);
        let modulate = |i: usize, color: &mut Vec3| *color = (color.as_dvec3() * light(values[i])).as_vec3();
        parallel::for_each_mut(&mut colors, modulate);
        colors
    }

    /// The colors of values.
    fn mapped(&self, values: &[f64]) -> Vec<Vec3> {
        let ColorSettings { colormap, reverse, .. } = &self.settings.coloring;
        let (map, scale) = (colormap.map(), self.scale(values));
        parallel::map_each(values, |value| of_value(&map, scale.place(*value), *reverse))
    }
}

fn of_value(map: &Colormap, t: Option<f64>, reverse: bool) -> Vec3 {
    t.map_or_else(mid_grey, |t| map.linear(if reverse { 1.0 - t } else { t }).as_vec3())
}

/// A unit vector as sRGB from 0 to 1; gray without one.
fn of_normal(normal: Vec3) -> Vec3 {
    linear(0.5 + 0.5 * normal.as_dvec3().clamp(DVec3::NEG_ONE, DVec3::ONE))
}

fn linear(srgb: DVec3) -> Vec3 {
    DVec3::from(srgb.to_array().map(decode_srgb_f64)).as_vec3()
}

fn doubles(values: &[f32]) -> Vec<f64> {
    parallel::map_each(values, |value| f64::from(*value))
}

/// Returns the quantity that [`ColorBy::Auto`] shows of a cloud.
pub fn automatic(cloud: &Cloud) -> ColorBy {
    Choice::of(&ColorBy::Auto, cloud, None).by
}

/// Returns how the points of each cloud are colored and why, a sentence for each.
pub fn colorings(scene: &Scene, clouds: &[impl Borrow<Cloud>]) -> Vec<String> {
    let describe = |(index, cloud)| Coloring::of(scene, index, cloud).describe();
    clouds.iter().map(Borrow::borrow).enumerate().map(describe).collect()
}
