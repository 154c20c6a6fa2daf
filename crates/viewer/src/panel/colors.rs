//! The colors of the clouds: what they show, by which colors, and what each means.

use egui::{ComboBox, DragValue, Id, Ui};

use super::clouds;
use super::row::{choice, name, note, row, takes_out};
use crate::census::Census;
use crate::controls::{self, Presence, changes, significant};
use crate::legend;
use crate::model::Model;
use pellucid_engine::scene::{Change, CloudSettings, ColorBy, Setting};

/// The clouds that the section is about.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Target {
    All,
    One(usize),
}

impl Target {
    fn key(self, name: &str) -> String {
        match self {
            Self::All => format!("cloud.*.{name}"),
            Self::One(i) => format!("cloud.{i}.{name}"),
        }
    }
}

/// Draws the section.
pub fn show(ui: &mut Ui, model: &mut Model) {
    let clouds = model.scene().clouds.clone();
    let target = target(ui, &clouds);
    let first = if let Target::One(i) = target { i } else { 0 };
    let Some(settings) = clouds.get(first) else { return };
    one_color(ui, model, target, settings);
    if settings.color.is_none() {
        meaning(ui, model, target, settings);
        if is_mapped(model, settings) {
            plain(ui, model, target, settings, "colormap");
            range(ui, model, target, settings);
            ui.horizontal(|ui| ["reverse", "log"].into_iter().for_each(|key| plain(ui, model, target, settings, key)));
        }
    }
    if let Some(legend) = model.picture().and_then(|picture| picture.legend.clone()) {
        ui.add_space(4.0);
        legend::entries(ui, &legend);
    }
}

/// The clouds that were chosen; with one there is no choice.
fn target(ui: &mut Ui, clouds: &[CloudSettings]) -> Target {
    if clouds.len() == 1 {
        return Target::One(0);
    }
    let id = Id::new("colors of");
    let known = ui.data(|data| data.get_temp(id)).filter(|target| match target {
        Target::All => true,
        Target::One(i) => *i < clouds.len(),
    });
    let mut target = known.unwrap_or(Target::All);
    let text = |target| match target {
        Target::All => "all clouds".to_owned(),
        Target::One(i) => clouds.get(i).map_or_else(String::new, |settings| clouds::name(settings, i)),
    };
    ComboBox::from_id_salt(id).selected_text(text(target)).width(150.0).truncate().show_ui(ui, |ui| {
        for other in [Target::All].into_iter().chain((0..clouds.len()).map(Target::One)) {
            ui.selectable_value(&mut target, other, text(other));
        }
    });
    ui.data_mut(|data| data.insert_temp(id, target));
    target
}

/// One color in place of all others.
fn one_color(ui: &mut Ui, model: &mut Model, target: Target, settings: &CloudSettings) {
    if let Some(mut entry) = controls::cloud(settings, "color", false, None, model.extent()) {
        if let Presence::Optional { without, .. } = &mut entry.presence {
            without.clear();
        }
        row(ui, model, &target.key("color"), "one color", entry);
    }
}

/// The row of a key that needs nothing but its control.
fn plain(ui: &mut Ui, model: &mut Model, target: Target, settings: &CloudSettings, key: &str) {
    if let Some(entry) = controls::cloud(settings, key, false, None, model.extent()) {
        row(ui, model, &target.key(key), &controls::label(key), entry);
    }
}

/// What the colors show: whatever all of the clouds have.
fn meaning(ui: &mut Ui, model: &mut Model, target: Target, settings: &CloudSettings) {
    let (census, scene) = (model.census(), model.scene().clone());
    let known = scene.clouds.iter().zip(census.iter()).enumerate();
    let about = known.filter(|(i, _)| target == Target::All || target == Target::One(*i));
    let offers: Vec<Vec<&str>> = about.map(|(_, (settings, census))| offers(settings, census)).collect();
    let Some((first, others)) = offers.split_first() else { return };
    let words: Vec<&str> =
        first.iter().copied().filter(|word| others.iter().all(|other| other.contains(word))).collect();
    let key = target.key("color_by");
    let given = model.is_given(&key);
    let (chosen, out) = ui
        .horizontal(|ui| {
            let (response, chosen) = choice(ui, &key, settings.coloring.color_by.word(), &words);
            note(ui, model, &key, &response);
            name(ui, &key, "colored by");
            (chosen, given && takes_out(ui, model, &key))
        })
        .inner;
    if out {
        model.change(&by(target, None));
    } else if let Some(word) = chosen {
        model.change(&by(target, Some(word)));
    }
}

/// The changes that let colors show something else. A range of other values goes.
fn by(target: Target, word: Option<&str>) -> Vec<Change> {
    vec![(target.key("color_by"), word.map(Setting::from)), (target.key("range"), None)]
}

/// What the colors of a cloud can show.
fn offers<'a>(settings: &CloudSettings, census: &'a Census) -> Vec<&'a str> {
    let has = |name: &str| census.scalars.iter().any(|(known, _)| known == name);
    // Columns of LAS files are read when they are asked for.
    let is_las =
        settings.path.extension().is_some_and(|end| ["las", "laz"].iter().any(|las| end.eq_ignore_ascii_case(las)));
    let offered = |word: &&str| match *word {
        "rgb" => census.colors,
        "intensity" => has("intensity"),
        "classification" => !census.classes.is_empty(),
        "return" | "source" | "gps-time" => is_las,
        "normal" => census.normals,
        _ => true,
    };
    let scalars = census.scalars.iter().map(|(name, _)| name.as_str());
    let known = ["x", "y", "z", "intensity", "return_number", "point_source_id", "gps_time"];
    let scalars = scalars.filter(|name| !known.contains(name) && ColorBy::words().all(|word| word != *name));
    let words = ColorBy::words().filter(offered).map(|word| -> &'a str { word });
    words.chain(scalars).collect()
}

/// True if values become colors by way of the color map.
fn is_mapped(model: &Model, settings: &CloudSettings) -> bool {
    match settings.coloring.color_by {
        ColorBy::Auto => ends(model, settings).is_some(),
        ref by => by.is_mapped(),
    }
}

/// The values of the first and the last color, as the picture has them.
fn ends(model: &Model, settings: &CloudSettings) -> Option<[f64; 2]> {
    let legend = model.picture()?.legend.as_ref()?;
    let file = settings.path.file_name()?.to_string_lossy();
    Some(legend.entry_of(&file)?.values.as_ref()?.scale.ends())
}

/// The values of the first and the last color.
fn range(ui: &mut Ui, model: &mut Model, target: Target, settings: &CloudSettings) {
    let key = target.key("range");
    let given = settings.coloring.range;
    let Some([low, high]) = given.or_else(|| ends(model, settings)) else { return };
    let speed = 0.005 * (high - low).abs().max(f64::MIN_POSITIVE);
    let mut ends = [low, high];
    let out = ui.horizontal(|ui| {
        ui.spacing_mut().item_spacing.x = 4.0;
        let [from, to] = &mut ends;
        for (end, range) in [(from, f64::NEG_INFINITY..=high), (to, low..=f64::INFINITY)] {
            let number = DragValue::new(end).range(range).speed(speed).max_decimals(4).update_while_editing(false);
            ui.add_sized([70.0, 18.0], number);
        }
        name(ui, &key, "range");
        given.is_some() && ui.small_button("percentiles").on_hover_text("1 and 99, as without `range`").clicked()
    });
    if out.inner {
        model.change(&changes(&key, None));
    } else if ends != [low, high] {
        let short = |x: f64| if x.abs() < 1e6 { (x * 1e4).round() / 1e4 } else { x.round() };
        let ends = if high - low < 1e-2 { ends.map(significant) } else { ends.map(short) };
        model.change(&changes(&key, Some(ends.into())));
    }
}
