//! Vertices that are Gaussian splats as radiance fields are stored (Kerbl et al. 2023).
//!
//! Stored are the degree-0 coefficients of the color in spherical harmonics (`f_dc_0..2`), those of higher degrees
//! (`f_rest_…`, first all of red), the logit of the opacity (`opacity`), the logarithms of the standard deviations
//! along three axes (`scale_0..2`; flat splats have two) and those axes (`rot_0..3`: w, x, y, z). Without `f_dc_0..2`
//! the display color is that of points (`red green blue`). Raw models of Mip-Splatting (Yu et al. 2024) have the
//! standard deviation of a smoothing filter (`filter_3D`), which is applied. Other properties stay what they are, but
//! for normals, which are zeros.

use glam::{DQuat, DVec3, Vec3};

use super::rows::VertexRows;
use crate::columns::{Column, PointTable, RowLayout, ScalarType};
use crate::splats::{Splat, Splats, from_coefficient};
use crate::{Error, memory};
use pellucid_core::cloud::filter::Filter;
use pellucid_core::cloud::gaussians::{MAX_DEGREE, coefficients};
use pellucid_core::cloud::{Cloud, UpAxis};
use pellucid_core::color::encode_srgb;
use pellucid_core::parallel;
use pellucid_core::progress::Progress;

/// Splats that a thread parses at a time.
const RUN: u64 = 1 << 14;

/// The positions of a splat's properties in a row.
pub(crate) struct SplatColumns {
    position: [usize; 3],
    /// The coefficients of degree 0; `None` where `layout` has the color.
    color: Option<[usize; 3]>,
    opacity: usize,
    /// Flat splats have no third one.
    scale: [Option<usize>; 3],
    /// w, x, y, z.
    rotation: [usize; 4],
    /// The standard deviation of the smoothing filter of Mip-Splatting.
    filter: Option<usize>,
    /// [`LINEARITY`].
    linearity: Option<usize>,
    /// Coefficients from degree 1 on: all of red, all of green, all of blue.
    rest: Vec<usize>,
    degree: u32,
    /// Properties that stay as they are.
    kept: Vec<usize>,
    /// Layout of a row of the position and those, if there are any.
    layout: Option<RowLayout>,
    /// Warning of what is odd.
    warning: Option<String>,
}

impl SplatColumns {
    /// Finds splats; `None` if the properties are those of something else, or some are [`missing`].
    pub fn find(properties: &[Column]) -> Option<Self> {
        let find = |name: &str| properties.iter().position(|p| p.name.eq_ignore_ascii_case(name));
        let at = |stem: &str, number: usize| find(&format!("{stem}{number}"));
        let three = |stem: &str| Some([at(stem, 0)?, at(stem, 1)?, at(stem, 2)?]);
        let (color, opacity) = (three("f_dc_"), find("opacity")?);
        if color.is_none() && !has_display_color(properties) {
            return None;
        }
        let scale = [Some(at("scale_", 0)?), Some(at("scale_", 1)?), at("scale_", 2)];
        let [w, x, y] = three("rot_")?;
        let position = [find("x")?, find("y")?, find("z")?];
        let mut rest: Vec<usize> = (0..).map_while(|number| at("f_rest_", number)).collect();
        let degree = (0..=MAX_DEGREE).find(|degree| 3 * coefficients(*degree) == rest.len());
        let warning = degree.is_none().then(|| {
            let found = rest.len();
            format!("{found} properties f_rest_ are left out: harmonics of degree 1, 2, 3 or 4 have 9, 24, 45 or 72")
        });
        if degree.is_none() {
            rest.clear();
        }
        let used = |name: &str| {
            let name = name.to_ascii_lowercase();
            let made = ["x", "y", "z", "nx", "ny", "nz", "alpha", "radius", "opacity", FILTER, LINEARITY];
            made.contains(&name.as_str())
                || (color.is_some() && ["red", "green", "blue"].contains(&name.as_str()))
                || ["f_dc_", "f_rest_", "scale_", "rot_"].iter().any(|stem| name.starts_with(stem))
        };
        let kept: Vec<usize> = (0..properties.len()).filter(|&at| !used(&properties[at].name)).collect();
        let layout = if kept.is_empty() { None } else { Some(layout(properties, &kept)?) };
        let (degree, rotation) = (degree.unwrap_or(0), [w, x, y, at("rot_", 3)?]);
        let (filter, linearity) = (find(FILTER), color.and_then(|_| find(LINEARITY)));
        Some(Self { position, color, opacity, scale, rotation, filter, linearity, rest, degree, kept, layout, warning })
    }

    /// The splat of a row's values.
    fn splat(&self, value: impl Fn(usize) -> f64, harmonics: &mut [Vec3]) -> Splat {
        let three = |places: [usize; 3]| DVec3::from(places.map(&value));
        let channels = harmonics.len();
        for (at, color) in harmonics.iter_mut().enumerate() {
            *color = three([0, 1, 2].map(|channel| self.rest[channel * channels + at])).as_vec3();
        }
        let [w, x, y, z] = self.rotation.map(&value);
        let mut extents = self.scale.map(|at| at.map_or(0.0, |at| value(at).exp()));
        let mut alpha = 1.0 / (1.0 + (-value(self.opacity)).exp());
        if let Some(filter) = self.filter {
            let axes = self.scale.iter().flatten().count();
            alpha *= smoothed(&mut extents[..axes], value(filter));
        }
        Splat {
            center: three(self.position),
            extents: DVec3::from(extents),
            rotation: DQuat::from_xyzw(x, y, z, w),
            // Without coefficients that of `layout` takes its place.
            base: self.color.map_or(DVec3::ZERO, |color| from_coefficient(three(color))),
            linear: self.linearity.is_some_and(|at| value(at) != 0.0),
            alpha,
        }
    }

    /// Checks that memory can hold so many of them.
    pub fn check(&self, path: &std::path::Path, count: u64) -> Result<(), Error> {
        let kept = self.layout.as_ref().map_or(0, RowLayout::bytes);
        memory::check(path, count, Splats::bytes(self.degree) + kept)
    }
}

/// The property that Mip-Splatting writes besides extents and opacities that lack its filter, in lower case.
const FILTER: &str = "filter_3d";

/// The property of this program's files whose colors are linear, or partly so: 1 for splats of linear colors, else 0.
pub(super) const LINEARITY: &str = "lin_rec709_display";

/// Convolves a Gaussian with one of a standard deviation; returns the factor on its opacity that keeps its integral
/// (Yu et al. 2024).
fn smoothed(extents: &mut [f64], filter: f64) -> f64 {
    let grown = |extent: &mut f64| {
        let before = *extent;
        *extent = before.hypot(filter);
        if before == *extent { 1.0 } else { before / *extent }
    };
    extents.iter_mut().map(grown).product()
}

/// True if the properties have a color that is no coefficient.
fn has_display_color(properties: &[Column]) -> bool {
    RowLayout::new(properties).is_ok_and(|layout| layout.has_color())
}

/// Returns a warning that names the properties which points lack to be splats, if they are meant to be some: if they
/// have two of color coefficients, scales and rotations.
pub(super) fn missing(properties: &[Column]) -> Option<String> {
    let has = |name: &str| properties.iter().any(|property| property.name.eq_ignore_ascii_case(name));
    let families = [("f_dc_", 3), ("scale_", 3), ("rot_", 4)];
    let has_any = |(stem, count): &(&str, usize)| (0..*count).any(|at| has(&format!("{stem}{at}")));
    if families.iter().filter(|family| has_any(family)).count() < 2 {
        return None;
    }
    let numbered = |stem: &'static str, count: usize| (0..count).map(move |at| format!("{stem}{at}"));
    let needed = numbered("scale_", 2).chain(numbered("rot_", 4)).chain(["opacity".to_owned()]);
    let color = numbered("f_dc_", 3).filter(|_| !has_display_color(properties));
    let missing: Vec<String> = color.chain(needed).filter(|name| !has(name)).map(|name| format!("`{name}`")).collect();
    let (some, missing) = (if missing.len() == 1 { "property" } else { "properties" }, missing.join(", "));
    (!missing.is_empty()).then(|| {
        format!("the points seem to be Gaussian splats, but lack the {some} {missing}, so they are drawn as discs")
    })
}

/// The columns of a row of the position and some properties.
fn layout(properties: &[Column], kept: &[usize]) -> Option<RowLayout> {
    let position = ["x", "y", "z"].map(|name| Column::new(name, ScalarType::Double));
    let kept = kept.iter().map(|&at| Column::new(&properties[at].name, properties[at].kind.clone()));
    let columns: Vec<_> = position.into_iter().chain(kept).collect();
    RowLayout::new(&columns).ok()
}

/// Some splats, and what stays of their properties.
pub(super) struct SplatPart<'a> {
    of: &'a SplatColumns,
    splats: Splats,
    others: Option<PointTable>,
    row: Vec<f64>,
    harmonics: Vec<Vec3>,
}

impl<'a> SplatPart<'a> {
    /// No splats, with room for some.
    pub fn new(of: &'a SplatColumns, room: usize) -> Self {
        Self {
            of,
            splats: Splats::new(of.degree, room),
            others: of.layout.as_ref().map(|layout| PointTable::new(layout, 0)),
            row: Vec::new(),
            harmonics: vec![Vec3::ZERO; coefficients(of.degree)],
        }
    }

    /// Adds the splat of a row, unless it is none.
    pub fn push(&mut self, value: impl Fn(usize) -> f64) {
        let splat = self.of.splat(&value, &mut self.harmonics);
        if self.splats.push(&splat, &self.harmonics)
            && let (Some(others), Some(layout)) = (&mut self.others, &self.of.layout)
        {
            self.row.clear();
            self.row.extend(self.of.position.iter().chain(&self.of.kept).map(|at| value(*at)));
            others.push(layout, &self.row);
        }
    }

    /// Returns the cloud of some parts, one behind the other.
    pub fn finish(of: &SplatColumns, parts: Vec<SplatPart>) -> Cloud {
        let (splats, others): (Vec<_>, Vec<_>) = parts.into_iter().map(|part| (part.splats, part.others)).unzip();
        let mut cloud = Splats::join(of.degree, splats).finish(UpAxis::NegativeY);
        let others = of
            .layout
            .as_ref()
            .map(|layout| PointTable::join(layout, others.into_iter().flatten().collect()).into_cloud(layout));
        let others = others.unwrap_or_default();
        if of.color.is_none() {
            paint(&mut cloud, others.colors);
        }
        let warnings = cloud.warnings.into_iter().chain(of.warning.clone()).collect();
        let (classification, intensity) = (others.classification, others.intensity);
        // Who smooths in space smooths on the image too.
        let filter = of.filter.map(|_| Filter::Mip);
        Cloud { warnings, filter, classification, intensity, scalars: others.scalars, ..cloud }
    }
}

/// Gives splats the linear colors of points; white ones where there are none.
fn paint(cloud: &mut Cloud, colors: Option<Vec<Vec3>>) {
    let colors = colors.unwrap_or_else(|| vec![Vec3::ONE; cloud.len()]);
    if let Some(gaussians) = &mut cloud.gaussians {
        let display = |color: &Vec3| Vec3::from(color.to_array().map(encode_srgb));
        gaussians.bases = parallel::map_each(&colors, display);
    }
    cloud.colors = Some(colors);
}

/// Reads splats that are rows, on all cores.
pub(super) fn read_rows(rows: &VertexRows, of: &SplatColumns, progress: &Progress) -> Result<Cloud, Error> {
    of.check(rows.file.path(), rows.count)?;
    progress.set_length(rows.count);
    let run = |first: &u64| {
        let places = *first..rows.count.min(*first + RUN);
        let mut part = SplatPart::new(of, (places.end - places.start) as usize);
        rows.blocks(places.clone(), |block| {
            (0..block.len()).for_each(|row| part.push(|at| block.value(row, at)));
        })?;
        progress.inc(places.end - places.start);
        Ok(part)
    };
    let firsts: Vec<u64> = (0..rows.count).step_by(RUN as usize).collect();
    Ok(SplatPart::finish(of, parallel::try_map_each::<_, _, Error>(&firsts, run)?))
}

/// Returns the filter that comments name; the last of them counts.
pub(super) fn filter(comments: &[(u64, String)]) -> Option<Filter> {
    comments.iter().rev().find_map(|(_, text)| {
        let (name, value) = text.split_once([':', ' '])?;
        match (name.to_ascii_lowercase().as_str(), value.trim()) {
            ("splatrendermode", value) => Filter::named(value),
            ("antialiased", "0") => Some(Filter::Plain),
            ("antialiased", "1") => Some(Filter::Mip),
            _ => None,
        }
    })
}
