//! Facts for a picture of a cloud: classes, ranges, histograms, spacing and layers.

use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::Path;

use pellucid_core::cloud::Cloud;
use pellucid_core::color::classes;
use pellucid_scene::{self as scene, Overview};
use serde_json::{Map, Value, json};

use super::histogram::{Histogram, short};
use super::proposal::{self, Proposal};

/// Cells of the bar of a class that has all points.
const BAR: usize = 24;

/// Points of each class that has any.
pub type Classes = BTreeMap<u8, usize>;

/// Facts for a picture of a cloud.
pub struct Facts {
    pub classes: Classes,
    /// The smallest and the largest finite value of each scalar.
    ranges: Vec<(String, [f32; 2])>,
    /// Heights along the file's vertical.
    height: Option<Histogram>,
    intensity: Option<Histogram>,
    overview: Overview,
    proposal: Proposal,
}

impl Facts {
    /// `columns` are those that were given for a text file.
    pub fn of(file: &Path, columns: Option<&str>, cloud: &Cloud) -> Self {
        let up = cloud.up.direction();
        let intensity = cloud.intensity.as_ref().map(|values| values.iter().map(|value| f64::from(*value)).collect());
        let (classes, overview) = (classes(cloud), scene::overview(cloud));
        Self {
            ranges: ranges(cloud),
            height: Histogram::of(cloud.positions.iter().map(|p| p.dot(up)).collect()),
            intensity: intensity.and_then(Histogram::of),
            proposal: proposal::propose(file, columns, cloud, &classes, &overview),
            classes,
            overview,
        }
    }

    /// Adds the numbers to those that describe the file.
    pub fn add_to(&self, object: &mut Map<String, Value>) {
        let histogram = |histogram: &Option<Histogram>| histogram.as_ref().map(Histogram::json);
        let ranges: Map<_, _> =
            self.ranges.iter().map(|(name, [min, max])| (name.clone(), json!([min, max]))).collect();
        let Overview { spacing, layers, .. } = self.overview;
        object.insert("ranges".into(), ranges.into());
        object.insert("spacing".into(), json!(spacing));
        object.insert("layers".into(), json!(layers));
        let histograms = json!({ "height": histogram(&self.height), "intensity": histogram(&self.intensity) });
        object.insert("histograms".into(), histograms);
        object.insert("command".into(), json!(self.proposal.command));
    }

    /// Attributes by name, scalars with their ranges.
    pub fn attributes(&self, names: &[&str]) -> String {
        let with_range = |name: &&str| match self.ranges.iter().find(|(known, _)| known == name) {
            Some((_, [min, max])) if min < max => format!("{name} {min} to {max}"),
            Some((_, [min, _])) => format!("{name} {min}"),
            None => (*name).to_owned(),
        };
        names.iter().map(with_range).collect::<Vec<_>>().join(", ")
    }

    /// Lines about it, each after a line break.
    pub fn text(&self) -> String {
        let mut text = classes_text(&self.classes);
        // Writing to a string can't fail.
        for (name, histogram) in [("height", &self.height), ("intensity", &self.intensity)] {
            if let Some(histogram) = histogram {
                let _ = write!(text, "\n  {name:<10}  {}", histogram.text());
            }
        }
        if let Some(spacing) = self.overview.spacing {
            let _ = write!(text, "\n  spacing     {} (median distance to the nearest other point)", short(spacing));
        }
        if let Some(layers) = self.overview.layers {
            let _ = write!(text, "\n  layers      {layers:.1} on a covered pixel of the automatic view");
        }
        let Proposal { command, why } = &self.proposal;
        let _ = write!(text, "\n  try         {command}\n              ({why})");
        text
    }
}

fn classes(cloud: &Cloud) -> Classes {
    let mut counts = [0; 256];
    cloud.classification.iter().flatten().for_each(|code| counts[usize::from(*code)] += 1);
    (0..=u8::MAX).zip(counts).filter(|(_, count)| *count > 0).collect()
}

/// A line for each class: code, name, points, share, bar.
fn classes_text(classes: &Classes) -> String {
    let total = classes.values().sum::<usize>().max(1);
    let width = classes.values().max().map_or(0, |most| most.to_string().len());
    let line = |(place, (code, count)): (usize, (&u8, &usize))| {
        let title = if place == 0 { "classes" } else { "" };
        let share = *count as f64 / total as f64;
        let name = classes::name(*code).unwrap_or("-");
        // A class that is there has a bar.
        let bar = "█".repeat(((share * BAR as f64).round() as usize).max(1));
        format!("\n  {title:<10}  {code:>3} {name:<19} {count:>width$} {:>5.1}%  {bar}", 100.0 * share)
    };
    classes.iter().enumerate().map(line).collect()
}

/// The ranges of all scalars with a finite value: of those with a meaning, then of the others.
fn ranges(cloud: &Cloud) -> Vec<(String, [f32; 2])> {
    let field = cloud.prepared.as_ref().map(|prepared| &prepared.values);
    let own = [("alpha", &cloud.alphas), ("radius", &cloud.radii), ("intensity", &cloud.intensity)];
    let own = own.into_iter().filter_map(|(name, values)| Some((name, values.as_ref()?)));
    let own = own.chain(field.map(|values| ("field", values))).map(|(name, values)| (name, values.as_slice()));
    let others = cloud.scalars.iter().map(|(name, values)| (name.as_str(), values.as_slice()));
    own.chain(others).filter_map(|(name, values)| Some((name.to_owned(), range(values)?))).collect()
}

fn range(values: &[f32]) -> Option<[f32; 2]> {
    let finite = values.iter().copied().filter(|value| value.is_finite());
    finite.fold(None, |range, value| match range {
        None => Some([value; 2]),
        Some([min, max]) => Some([value.min(min), value.max(max)]),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn classes_have_names_shares_and_bars() {
        let classes = Classes::from([(2, 900), (5, 90), (64, 10)]);
        let bar = "█".repeat(22);
        let wanted = [
            String::new(),
            format!("  classes       2 ground              900  90.0%  {bar}"),
            "                5 high-vegetation      90   9.0%  ██".to_owned(),
            "               64 -                    10   1.0%  █".to_owned(),
        ];
        assert_eq!(classes_text(&classes).split('\n').collect::<Vec<_>>(), wanted);
        assert_eq!(classes_text(&Classes::new()), "");
    }

    #[test]
    fn ranges_are_those_of_finite_values() {
        assert_eq!(range(&[f32::NAN, 3.0, -1.0, f32::INFINITY]), Some([-1.0, 3.0]));
        assert_eq!((range(&[]), range(&[f32::NAN])), (None, None));
    }
}
