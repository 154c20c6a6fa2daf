//! The field F that separates soft points from solid ones: its classes or axis, and its distribution.

use std::collections::{BTreeMap, BTreeSet};

use egui::{Color32, ScrollArea, Ui};
use egui_plot::{Bar, BarChart, VLine};

use super::row::{choice_row, note, vector};
use crate::counts::grouped;
use crate::hints::hint;
use crate::model::Model;
use crate::overlay::still_plot;
use crate::statistics::{BINS, FieldFacts};
use pellucid_core::cloud::UpAxis;
use pellucid_core::cloud::field::Field;
use pellucid_core::color::classes;
use pellucid_scene::{Change, Setting, Vertical, rounded};

/// The classes that a choice of classes begins with: vegetation.
const VEGETATION: [u8; 3] = [3, 4, 5];

const SOFT: Color32 = Color32::from_rgb(110, 170, 255);
const SOLID: Color32 = Color32::from_gray(120);
const THRESHOLD: Color32 = Color32::from_rgb(255, 190, 90);

/// Draws the section: one chooser for all clouds, and how F is spread over the points that are shown.
pub fn show(ui: &mut Ui, model: &mut Model) {
    let count = model.scene().clouds.len();
    if count == 1 {
        chooser(ui, model, "0", &[0]);
    } else {
        let all: Vec<usize> = (0..count).collect();
        chooser(ui, model, "*", &all);
        ui.weak("for all clouds; Clouds sets each one");
    }
    let facts = model.picture().and_then(|picture| picture.field.clone());
    if let (Some(facts), Some(threshold)) = (facts, model.scene().method.representative().threshold()) {
        histogram(ui, &facts, rounded(threshold));
    }
}

/// The chooser of the field of some clouds, which `cloud.TARGET` names, with what belongs to the field.
pub fn chooser(ui: &mut Ui, model: &mut Model, target: &str, clouds: &[usize]) {
    let (statistics, scene) = (model.statistics(), model.scene().clone());
    let known: Vec<_> = clouds.iter().filter_map(|i| Some((scene.clouds.get(*i)?, statistics.get(*i)?))).collect();
    let fields: Vec<Field> = known.iter().map(|(settings, statistics)| statistics.field(settings)).collect();
    let (Some(first), Some((_, some))) = (fields.first(), known.first()) else {
        ui.weak("examining the clouds");
        return;
    };
    let same = fields.iter().all(|field| field.name() == first.name());
    let word = if same { first.name() } else { "several" };
    let has = |name: &&str| known.iter().all(|(_, statistics)| statistics.fields().contains(name));
    let words: Vec<&str> = some.fields().into_iter().filter(has).collect();
    let keys = ["field", "soft_classes", "axis"].map(|key| format!("cloud.{target}.{key}"));
    let chosen = choice_row(ui, model, &keys.each_ref().map(String::as_str), "field F", word, &words);
    let counts = known.iter().fold(BTreeMap::new(), |mut sum: BTreeMap<u8, usize>, (_, statistics)| {
        statistics.classes.iter().for_each(|(code, count)| *sum.entry(*code).or_default() += count);
        sum
    });
    if let Some(word) = chosen {
        model.change(&to_field(target, word, &counts));
    } else if same {
        match first {
            Field::Classification { .. } => classes(ui, model, target, &fields, &counts),
            Field::DistanceToAxis { point, direction } => axis(ui, model, target, *point, *direction),
            _ => range(ui, some, first.name(), known.len()),
        }
    }
}

/// The changes that give clouds a field. Keys that belong only to another field are removed.
fn to_field(target: &str, word: &str, counts: &BTreeMap<u8, usize>) -> Vec<Change> {
    let key = |name: &str| format!("cloud.{target}.{name}");
    let soft = VEGETATION.into_iter().filter(|code| counts.contains_key(code)).map(u32::from).collect();
    let classes = (word == "classification").then_some(Setting::Integers(soft));
    vec![(key("soft_classes"), classes), (key("axis"), None), (key("field"), Some(word.into()))]
}

/// Check boxes of the classes, with their names and counts.
fn classes(ui: &mut Ui, model: &mut Model, target: &str, fields: &[Field], counts: &BTreeMap<u8, usize>) {
    let soft: BTreeSet<u8> = fields
        .iter()
        .filter_map(|field| if let Field::Classification { classes } = field { Some(classes) } else { None })
        .flatten()
        .copied()
        .collect();
    let mut chosen = soft.clone();
    let key = format!("cloud.{target}.soft_classes");
    ScrollArea::vertical().id_salt(&key).max_height(220.0).auto_shrink([false, true]).show(ui, |ui| {
        for (code, count) in counts {
            let mut on = chosen.contains(code);
            let name = classes::name(*code).map_or_else(|| code.to_string(), |name| format!("{code} {name}"));
            ui.horizontal(|ui| {
                let response = ui.checkbox(&mut on, name).on_hover_text(hint(&key));
                note(model, &format!("{key}.{code}"), response);
                ui.weak(grouped(*count as u64));
            });
            if on {
                chosen.insert(*code)
            } else {
                chosen.remove(code)
            };
        }
    });
    if chosen != soft {
        // A prepared file's field has classes without the scene saying so.
        let field = Setting::Word("classification".to_owned());
        let classes = Setting::Integers(chosen.into_iter().map(u32::from).collect());
        model.change(&[(format!("cloud.{target}.field"), Some(field)), (key, Some(classes))]);
    }
}

/// The axis: its point and direction, each left to the cloud or given.
fn axis(ui: &mut Ui, model: &mut Model, target: &str, point: Option<[f64; 3]>, direction: Option<[f64; 3]>) {
    let subject = model.picture().map(|picture| picture.subject);
    let center =
        subject.map_or([0.0; 3], |subject| subject.bounds.center().to_array().map(|x| (x * 1e3).round() / 1e3));
    let vertical = vertical_of(subject.map_or(UpAxis::Z, |subject| subject.up));
    let diagonal = model.extent().diagonal;
    let rows = [
        ("point", "middle", "axis through", point, center, 0.002 * diagonal),
        ("direction", "vertical", "axis along", direction, vertical, 0.005),
    ];
    for (part, without, label, given, start, speed) in rows {
        let key = format!("cloud.{target}.axis.{part}");
        let mut on = given.is_some();
        let switched = ui.horizontal(|ui| {
            let response = note(model, &format!("{key}?"), ui.checkbox(&mut on, label));
            if given.is_none() {
                ui.weak(without);
            }
            response.on_hover_text(hint(&key)).changed()
        });
        if switched.inner {
            model.change(&around(target, part, on.then_some(start)));
        } else if let Some(numbers) = given.and_then(|given| vector(ui, model, &key, given, speed))
            && (part == "point" || numbers != [0.0; 3])
        {
            model.change(&around(target, part, Some(numbers)));
        }
    }
}

/// The direction that holds without one: the files' vertical, whatever the camera's is.
fn vertical_of(up: UpAxis) -> [f64; 3] {
    Vertical::from(up).up().to_array()
}

/// The changes that give clouds a part of an axis, or take it out. A prepared file's field has an axis without the
/// scene saying so, which is then said.
fn around(target: &str, part: &str, numbers: Option<[f64; 3]>) -> Vec<Change> {
    let field = Setting::Word("distance-to-axis".to_owned());
    let numbers = numbers.map(|numbers| Setting::Numbers(numbers.to_vec()));
    vec![(format!("cloud.{target}.field"), Some(field)), (format!("cloud.{target}.axis.{part}"), numbers)]
}

/// Shows the least and the largest value of a property.
fn range(ui: &mut Ui, statistics: &crate::statistics::Statistics, field: &str, clouds: usize) {
    let found = statistics.scalars.iter().find(|(name, _)| name == field);
    if let (Some((_, [least, most])), 1) = (found, clouds) {
        let scaled = if *least >= 0.0 && *most <= 1.0 { "as stored" } else { "scaled to 0 to 1" };
        ui.weak(format!("{least} to {most}, {scaled}"));
    }
}

/// The distribution of F, in powers of ten, and the threshold's position in it.
fn histogram(ui: &mut Ui, facts: &FieldFacts, threshold: f64) {
    let width = 1.0 / BINS as f64;
    let middle = |bin: usize| (bin as f64 + 0.5) * width;
    let bar = |(bin, count): (usize, &u64)| {
        let color = if middle(bin) > threshold { SOFT } else { SOLID };
        let height = if *count > 0 { 1.0 + (*count as f64).log10() } else { 0.0 };
        Bar::new(middle(bin), height).width(width).fill(color).stroke(egui::Stroke::NONE)
    };
    let counts = facts.histogram.clone();
    let says = move |bar: &Bar, _: &BarChart| {
        let bin = ((bar.argument / width) as usize).min(BINS - 1);
        let [from, to] = [bin, bin + 1].map(|bin| bin as f64 * width);
        format!("F from {from:.3} to {to:.3}\n{} points", grouped(counts.get(bin).copied().unwrap_or_default()))
    };
    let bars = facts.histogram.iter().enumerate().map(bar).collect();
    let chart = BarChart::new("points", bars).element_formatter(Box::new(says));
    let plot = still_plot("field", 74.0, 1.0).width(ui.available_width() - 8.0).show_y(false);
    plot.show_axes([true, false]).set_margin_fraction([0.01, 0.05].into()).show(ui, |plot| {
        plot.bar_chart(chart);
        plot.vline(VLine::new("t", threshold).color(THRESHOLD).width(1.5));
    });
    let parts = facts.parts;
    let all = (parts.solid + parts.soft).max(1);
    let share = 100.0 * parts.soft as f64 / all as f64;
    ui.weak(format!("{share:.1}% soft: {} of {} points", grouped(parts.soft), grouped(all)));
}

#[cfg(test)]
mod tests {
    use super::*;
    use pellucid_scene::{Document, Overrides};

    #[test]
    fn an_axis_begins_along_the_vertical() {
        let directions = [UpAxis::Y, UpAxis::Z, UpAxis::NegativeY].map(vertical_of);
        assert_eq!(directions, [[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]]);
    }

    #[test]
    fn another_field_leaves_nothing_behind() {
        let clouds = ["a.ply", "b.ply"];
        let mut document = Document::from_clouds(clouds, &Overrides::default()).unwrap();
        document.set("method.name", Setting::Word("soft-express".into())).unwrap();
        let counts = [(2, 10), (4, 20), (5, 30), (6, 7)].into();
        for (target, first, second) in [("*", true, true), ("0", true, false), ("1", false, true)] {
            let scene = document.change(&to_field(target, "classification", &counts)).unwrap();
            let vegetation = Some(Field::Classification { classes: vec![4, 5] });
            let is_set: Vec<_> = scene.clouds.iter().map(|cloud| cloud.field == vegetation).collect();
            assert_eq!((is_set, scene.warnings), (vec![first, second], vec![]));
            let scene = document.change(&to_field(target, "distance-to-axis", &counts)).unwrap();
            assert_eq!(scene.warnings, [""; 0]);
            let scene = document.change(&around(target, "point", Some([1.0; 3]))).unwrap();
            let through = Some(Field::DistanceToAxis { point: Some([1.0; 3]), direction: None });
            assert!(scene.clouds.iter().any(|cloud| cloud.field == through) && scene.warnings.is_empty());
            let scene = document.change(&around(target, "point", None)).unwrap();
            assert!(scene.clouds.iter().all(|cloud| cloud.field != through) && scene.warnings.is_empty());
            let scene = document.change(&to_field(target, "uncertainty", &counts)).unwrap();
            assert!(
                scene.warnings.is_empty() && !document.has("cloud.*.axis") && !document.has("cloud.*.soft_classes")
            );
        }
        let scene = document.change(&to_field("0", "classification", &[(9, 1)].into())).unwrap();
        assert_eq!(scene.clouds[0].field, Some(Field::Classification { classes: vec![] }));
    }
}
