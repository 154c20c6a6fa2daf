//! `pellucid info`.

mod facts;
mod gaussians;
mod histogram;
mod proposal;

use std::fmt::Write;
use std::path::{Path, PathBuf};

use clap::Args;
use pellucid_core::cloud::crs::{Crs, Unit};
use pellucid_core::cloud::shadow_texture::Casting;
use pellucid_core::cloud::{Cloud, Prepared};
use pellucid_engine::Result;
use pellucid_io::output::Inputs;
use pellucid_io::{self as io, ColumnNames, Hints};
use pellucid_scene::prepare::outliers::{self, Rule};
use pellucid_scene::{Light, Outliers, Strays};
use serde_json::{Value, json};

use super::bar::Bar;
use super::console::Console;
use super::limit::usage;
use super::touched::{Touched, Touches};
use facts::Facts;

/// Prints the points, bounds and attributes of files, the points of each class, histograms of height and intensity
/// between their percentiles 1 and 99, and a command line that suits the file. Two figures are estimated from the
/// neighbors of up to 2048 points, with a search tree over all points: the spacing (the median distance to the nearest
/// point), and the mean number of splats on a covered pixel of the automatic view. No device is needed.
#[derive(Debug, Args)]
pub struct InfoArgs {
    /// Point clouds, Gaussian splats, or pictures that become clouds.
    ///
    /// Point clouds: PLY, LAS, LAZ, COPC, E57, PCD, PTS, PTX, XYZ, CSV, TXT. Gaussian splats: PLY, SPLAT, SPZ, SOG,
    /// KSPLAT, glTF. Pictures: PNG, JPEG, TIFF.
    #[arg(required = true, value_name = "FILE")]
    files: Vec<PathBuf>,
    /// Columns of text files, as in x,y,z,-,r,g,b; `pellucid render --help` lists the names.
    #[arg(long, value_name = "LIST", allow_hyphen_values = true)]
    columns: Option<String>,
    /// Count outliers, points far away from all others.
    ///
    /// They are the points that `outliers` of a [[cloud]] selects with the default outlier_k and outlier_factor. The
    /// count needs the neighbors of every point.
    #[arg(long)]
    outliers: bool,
    /// Print JSON.
    ///
    /// {points, non_finite, withheld, bounds: {min, max}, crs, attributes, classes, ranges, spacing, layers,
    /// histograms, command}. `points` counts all points in the file, `classes` maps a code to its number of points,
    /// `ranges` a scalar to [min, max]. `histograms` is {height, intensity}, each null or {min, max, counts}.
    ///
    /// `crs` is null or the coordinate reference system that the file states: {name, epsg, unit, vertical_unit, wkt},
    /// each null where it is unknown. A unit is {name, meters}; `meters` is null for an angle.
    ///
    /// Gaussian splats also have `gaussians: {count, degree, filter, up, color, extents: {min, median, max}}`; `color`
    /// is "encoded", "linear" or "both". --outliers adds their number as `outliers`. A prepared cloud has `prepared:
    /// {neighbors, radius_cap, estimated_radii, field, quantiles}`, with `shadows` if they are stored; `quantiles`
    /// maps a share of the points to the largest field value among them.
    ///
    /// Several files become an array, each with `file`.
    #[arg(long)]
    json: bool,
}

impl Touches for InfoArgs {
    fn touched(&self) -> Result<Touched> {
        Ok(Touched::reads(Inputs::default().with(&self.files)))
    }
}

pub fn run(args: InfoArgs, console: Console) -> Result<()> {
    let columns = args.columns.as_deref().map(ColumnNames::parse).transpose();
    let columns = columns.map_err(|problem| usage(format!("--columns: {problem}")))?;
    let hints = Hints { columns: columns.as_ref(), ..Hints::default() };
    let progress = console.progress();
    let load = |file: &PathBuf| {
        progress.reset();
        progress.set_message(format!("reading {}", file.display()));
        io::load_with(file, hints, &progress)
    };
    let clouds: Vec<_> = args.files.iter().map(|file| Ok((file, load(file)?))).collect::<Result<_>>()?;
    let look = |(file, cloud): (&PathBuf, Cloud)| Seen::of(file, &args, cloud, &progress);
    let seen: Vec<Seen> = clouds.into_iter().map(look).collect();
    progress.finish_and_clear();
    for Seen { file, cloud, .. } in &seen {
        cloud.warnings.iter().for_each(|warning| console.warn(format_args!("{}: {warning}", file.display())));
    }
    match (args.json, seen.as_slice()) {
        (true, [seen]) => console.print_json(&to_json(seen)),
        (true, seen) => console.print_json(&seen.iter().map(with_file).collect()),
        (false, seen) => console.print(&seen.iter().map(to_text).collect::<Vec<_>>().join("\n")),
    }
}

/// A file and what was found in it.
struct Seen {
    file: PathBuf,
    cloud: Cloud,
    facts: Facts,
    /// Number of outliers, if it was asked for.
    outliers: Option<usize>,
}

impl Seen {
    fn of(file: &Path, args: &InfoArgs, cloud: Cloud, progress: &Bar) -> Self {
        let outliers = args.outliers.then(|| count_outliers(&cloud, progress));
        progress.reset();
        progress.set_message("examining points");
        let facts = Facts::of(file, args.columns.as_deref(), &cloud);
        Self { file: file.to_owned(), cloud, facts, outliers }
    }
}

/// The number of points that stand apart, by the rule that scenes have by default.
fn count_outliers(cloud: &Cloud, progress: &Bar) -> usize {
    progress.reset();
    progress.set_message("finding neighbors");
    let rule = Strays { outliers: Outliers::Drop, ..Strays::default() }.rule(Outliers::Drop);
    rule.map_or(0, |rule: Rule| outliers::count(&outliers::find(&cloud.positions, rule, progress)))
}

/// Names of the columns that the file gave, the usual ones first.
fn attributes(cloud: &Cloud) -> Vec<&str> {
    let usual = [
        ("color", cloud.colors.is_some()),
        ("alpha", cloud.alphas.is_some()),
        ("gaussian", cloud.gaussians.is_some()),
        ("normal", cloud.normals.is_some()),
        ("radius", cloud.radii.is_some()),
        ("classification", cloud.classification.is_some()),
        ("intensity", cloud.intensity.is_some()),
        ("field", cloud.prepared.is_some()),
        ("lit", cloud.prepared.as_ref().is_some_and(|prepared| prepared.shadows.is_some())),
    ];
    let usual = usual.into_iter().filter(|(_, given)| *given).map(|(name, _)| name);
    usual.chain(cloud.scalars.iter().map(|(name, _)| name.as_str())).collect()
}

/// The number of points in the file.
fn in_file(cloud: &Cloud) -> usize {
    cloud.len() + cloud.non_finite + cloud.withheld
}

fn to_json(seen: &Seen) -> Value {
    let Seen { cloud, facts, outliers, .. } = seen;
    let classes: serde_json::Map<_, _> =
        facts.classes.iter().map(|(code, count)| (code.to_string(), (*count).into())).collect();
    let mut value = json!({
        "points": in_file(cloud),
        "non_finite": cloud.non_finite,
        "withheld": cloud.withheld,
        "bounds": cloud.bounds().map(|b| json!({ "min": b.min.to_array(), "max": b.max.to_array() })),
        "crs": cloud.crs.as_deref().map(crs_json),
        "attributes": attributes(cloud),
        "classes": classes,
    });
    if let Value::Object(object) = &mut value {
        facts.add_to(object);
    }
    if let Some(outliers) = *outliers {
        value["outliers"] = outliers.into();
    }
    if let Some(splats) = &cloud.gaussians {
        value["gaussians"] = gaussians::json(splats, cloud);
    }
    if let Some(prepared) = &cloud.prepared {
        let threshold = |(share, threshold): (f64, f32)| (share.to_string(), f64::from(threshold).into());
        let quantiles: serde_json::Map<_, _> = quantiles(prepared).into_iter().map(threshold).collect();
        value["prepared"] = json!({
            "neighbors": prepared.neighbors,
            "radius_cap": prepared.radius_cap,
            "estimated_radii": prepared.estimated_radii,
            "field": prepared.field,
            "quantiles": quantiles,
        });
        if let Some(shadows) = &prepared.shadows {
            value["prepared"]["shadows"] = json!(shadows.casting);
        }
    }
    value
}

/// The coordinate reference system; what is unknown is null.
fn crs_json(crs: &Crs) -> Value {
    json!({
        "name": Some(&crs.name).filter(|name| !name.is_empty()),
        "epsg": crs.epsg,
        "unit": crs.unit,
        "vertical_unit": crs.vertical_unit,
        "wkt": crs.wkt,
    })
}

/// Lines about the coordinate reference system, each after a line break.
fn crs_text(crs: &Crs) -> String {
    let described = |unit: &Option<Unit>| unit.as_ref().map(Unit::described);
    let heights = described(&crs.vertical_unit).filter(|_| crs.vertical_unit != crs.unit);
    let unit = match (described(&crs.unit), heights) {
        (unit, None) => unit.unwrap_or_else(|| "not stated".to_owned()),
        (unit, Some(heights)) => format!("{}, heights in {heights}", unit.unwrap_or_else(|| "not stated".to_owned())),
    };
    format!("\n  crs         {}\n  unit        {unit}", crs.title())
}

/// Thresholds, each with the share of points whose F is at most the threshold; the rest are soft.
fn quantiles(prepared: &Prepared) -> Vec<(f64, f32)> {
    let mut values = prepared.values.clone();
    values.sort_unstable_by(f32::total_cmp);
    let last = |share: f64| ((share * values.len() as f64).ceil() as usize).saturating_sub(1);
    let at = |share: f64| values.get(last(share)).copied().unwrap_or_default();
    [0.5, 0.75, 0.9, 0.99].into_iter().map(|share| (share, at(share))).collect()
}

fn prepared_text(prepared: &Prepared) -> String {
    let radii = if prepared.estimated_radii { "radii and field" } else { "field" };
    let quantile = |(share, threshold)| format!("{:.0}% above {threshold:.3}", 100.0 * (1.0 - share));
    let above: Vec<_> = quantiles(prepared).into_iter().map(quantile).collect();
    let (name, k) = (prepared.field.name(), prepared.neighbors);
    let shadows = prepared.shadows.as_ref().map(|shadows| shadows_text(&shadows.casting)).unwrap_or_default();
    format!("\n  prepared    {radii}, {k} neighbors\n  field       {name}: {}{shadows}", above.join(", "))
}

fn shadows_text(casting: &Casting) -> String {
    let Casting { light, samples, light_radius, resolution, fill, occlusion, min_layer_distance, seed } = casting;
    let (light, unit) = match light {
        Light::Position(position) => (format!("a light at {position}"), ""),
        Light::Direction(direction) => (format!("a light along {direction}"), "°"),
        Light::Headlight => return String::new(),
    };
    let soft = if *light_radius > 0.0 {
        format!(", {samples} lights within {light_radius}{unit}, seed {seed}")
    } else {
        String::new()
    };
    format!(
        "\n  shadows     {light}{soft}, {resolution} × {resolution} pixels, surfaces {min_layer_distance} apart, fill {fill}, \
         occlusion {occlusion}"
    )
}

fn with_file(seen: &Seen) -> Value {
    let mut value = json!({ "file": seen.file.display().to_string() });
    if let (Value::Object(object), Value::Object(more)) = (&mut value, to_json(seen)) {
        object.extend(more);
    }
    value
}

fn to_text(seen: &Seen) -> String {
    let Seen { file, cloud, facts, outliers } = seen;
    let mut text = format!("{}\n  points      {}", file.display(), in_file(cloud));
    // Writing to a string can't fail.
    if cloud.non_finite > 0 {
        let _ = write!(text, " ({} without finite coordinates)", cloud.non_finite);
    }
    if cloud.withheld > 0 {
        let _ = write!(text, " ({} withheld)", cloud.withheld);
    }
    if let Some(bounds) = cloud.bounds() {
        let size = bounds.max - bounds.min;
        let _ = write!(text, "\n  bounds      {} to {}\n  size        {size}", bounds.min, bounds.max);
    }
    cloud.crs.iter().for_each(|crs| text.push_str(&crs_text(crs)));
    if let Some(outliers) = outliers {
        let _ = write!(text, "\n  outliers    {outliers}");
    }
    let attributes = attributes(cloud);
    let listed = if attributes.is_empty() { "none".into() } else { facts.attributes(&attributes) };
    let _ = write!(text, "\n  attributes  {listed}");
    cloud.gaussians.iter().for_each(|splats| text.push_str(&gaussians::text(splats, cloud)));
    text.push_str(&facts.text());
    cloud.prepared.iter().for_each(|prepared| text.push_str(&prepared_text(prepared)));
    text + "\n"
}
