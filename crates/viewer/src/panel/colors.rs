//! The colors of the clouds: what they show, by which colors, and what each means.

use egui::{ComboBox, DragValue, Id, Ui};

use super::clips::shown_decimals;
use super::clouds;
use super::row::{choice_row, name, row};
use crate::controls::{self, KeyControl, Presence, short_number};
use crate::legend;
use crate::model::Model;
use crate::statistics::Statistics;
use pellucid_scene::{Change, CloudSettings, ColorBy, ColorRange, Setting};

/// The cloud that the section is about; `None` for all.
type Target = Option<usize>;

fn key_of(target: Target, name: &str) -> String {
    target.map_or_else(|| format!("cloud.*.{name}"), |i| format!("cloud.{i}.{name}"))
}

/// Draws the section.
pub fn show(ui: &mut Ui, model: &mut Model) {
    let clouds = model.scene().clouds.clone();
    let target = target(ui, &clouds);
    let first = target.unwrap_or(0);
    let Some(settings) = clouds.get(first) else { return };
    one_color(ui, model, target, settings);
    if settings.color.is_none() {
        meaning(ui, model, target, settings);
        if is_mapped(settings, model.statistics().get(first)) {
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
        return Some(0);
    }
    let id = Id::new("colors of");
    let known: Option<Target> = ui.data(|data| data.get_temp(id));
    let mut target = known.flatten().filter(|i| *i < clouds.len());
    let text = |target: Target| target.map_or_else(|| "all clouds".to_owned(), |i| clouds::name(&clouds[i], i));
    ComboBox::from_id_salt(id).selected_text(text(target)).width(150.0).truncate().show_ui(ui, |ui| {
        for other in [None].into_iter().chain((0..clouds.len()).map(Some)) {
            ui.selectable_value(&mut target, other, text(other));
        }
    });
    ui.data_mut(|data| data.insert_temp(id, target));
    target
}

/// Shows the row of a single color that replaces all others.
fn one_color(ui: &mut Ui, model: &mut Model, target: Target, settings: &CloudSettings) {
    let mut entry = controls::cloud(settings, "color", false, None, model.extent());
    if let Some(KeyControl { presence: Presence::Optional { without, .. }, .. }) = &mut entry {
        without.clear();
    }
    row(ui, model, &key_of(target, "color"), "one color", entry);
}

/// The row of a key that needs nothing but its control.
fn plain(ui: &mut Ui, model: &mut Model, target: Target, settings: &CloudSettings, key: &str) {
    let entry = controls::cloud(settings, key, false, None, model.extent());
    row(ui, model, &key_of(target, key), &controls::label(key), entry);
}

/// Shows the choice of what the colors mean, among the quantities that all of the clouds have.
fn meaning(ui: &mut Ui, model: &mut Model, target: Target, settings: &CloudSettings) {
    let (statistics, scene) = (model.statistics(), model.scene().clone());
    let known = scene.clouds.iter().zip(statistics.iter()).enumerate();
    let about = known.filter(|(i, _)| target.is_none_or(|target| target == *i));
    let offers: Vec<Vec<&str>> = about.map(|(_, (settings, statistics))| offers(settings, statistics)).collect();
    let Some((first, others)) = offers.split_first() else { return };
    let words: Vec<&str> =
        first.iter().copied().filter(|word| others.iter().all(|other| other.contains(word))).collect();
    let keys = ["color_by", "range"].map(|key| key_of(target, key));
    let keys = keys.each_ref().map(String::as_str);
    if let Some(word) = choice_row(ui, model, &keys, "colored by", settings.coloring.color_by.word(), &words) {
        model.change(&by(target, word));
    }
}

/// The changes that let colors show something else. A range of other values goes.
fn by(target: Target, word: &str) -> Vec<Change> {
    vec![(key_of(target, "color_by"), Some(Setting::from(word))), (key_of(target, "range"), None)]
}

/// Returns the quantities that the colors of a cloud can show.
fn offers<'a>(settings: &CloudSettings, statistics: &'a Statistics) -> Vec<&'a str> {
    let has = |name: &str| statistics.scalars.iter().any(|(known, _)| known == name);
    // Columns of LAS files are read when they are asked for.
    let is_las =
        settings.path.extension().is_some_and(|end| ["las", "laz"].iter().any(|las| end.eq_ignore_ascii_case(las)));
    let offered = |word: &&str| match *word {
        "rgb" => statistics.colors,
        "intensity" => has("intensity"),
        "classification" => !statistics.classes.is_empty(),
        "return" | "source" | "gps-time" => is_las,
        "normal" => statistics.normals,
        _ => true,
    };
    let scalars = statistics.scalars.iter().map(|(name, _)| name.as_str());
    let known = ["x", "y", "z", "intensity", "return_number", "point_source_id", "gps_time"];
    let scalars = scalars.filter(|name| !known.contains(name) && ColorBy::words().all(|word| word != *name));
    let words = ColorBy::words().filter(offered).map(|word| -> &'a str { word });
    words.chain(scalars).collect()
}

/// True if values become colors by way of the color map.
fn is_mapped(settings: &CloudSettings, statistics: Option<&Statistics>) -> bool {
    match settings.coloring.color_by {
        ColorBy::Auto => statistics.is_some_and(|statistics| statistics.auto.is_mapped()),
        ref by => by.is_mapped(),
    }
}

/// The values of the first and the last color, as the picture has them.
fn ends(model: &Model, cloud: usize) -> Option<[f64; 2]> {
    Some(model.picture()?.legend.as_ref()?.entry_of(cloud)?.values.as_ref()?.scale.ends())
}

/// The values of the first and the last color.
fn range(ui: &mut Ui, model: &mut Model, target: Target, settings: &CloudSettings) {
    let key = key_of(target, "range");
    let given = settings.coloring.range;
    let Some([low, high]) = given.and_then(ColorRange::ends).or_else(|| ends(model, target.unwrap_or(0))) else {
        return;
    };
    let speed = 0.005 * (high - low).abs().max(f64::MIN_POSITIVE);
    let shown = shown_decimals((high - low).abs());
    let mut ends = [low, high];
    let out = ui.horizontal(|ui| {
        ui.spacing_mut().item_spacing.x = 4.0;
        for (end, range) in [(0, f64::NEG_INFINITY..=high), (1, low..=f64::INFINITY)] {
            let mut x = ends[end];
            let number = DragValue::new(&mut x).range(range).speed(speed).max_decimals(shown);
            let dragged = ui.add_sized([70.0, 18.0], number.update_while_editing(false)).dragged();
            if x != ends[end] {
                ends = with_end(ends, end, x, dragged);
            }
        }
        name(ui, &key, "range");
        given.is_some() && ui.small_button("percentiles").on_hover_text("1 and 99, as without `range`").clicked()
    });
    if out.inner {
        model.set(&key, None);
    } else if ends != [low, high] {
        model.set(&key, Setting::from(ends));
    }
}

/// The ends of a range with one of them elsewhere. A dragged one is as short as their distance allows and stays on its
/// side of the other one; a typed one is taken as it is.
fn with_end(ends: [f64; 2], end: usize, x: f64, dragged: bool) -> [f64; 2] {
    let [low, high] = ends;
    let apart = |x: &f64| if end == 0 { *x < high } else { *x > low };
    let mut moved = ends;
    moved[end] =
        if dragged { [short_number(x, (high - low).abs()), x].into_iter().find(apart).unwrap_or(ends[end]) } else { x };
    moved
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;
    use pellucid_core::cloud::{Cloud, UpAxis};
    use pellucid_core::progress::Progress;
    use pellucid_scene::{Scene, arrange_with_legend};

    #[test]
    fn only_the_dragged_end_is_rounded_and_ends_never_meet() {
        for (ends, end, x, wanted) in [
            ([630.001, 630.009], 0, 630.002_345_678, [630.002_346, 630.009]),
            ([630.001, 630.009], 1, 630.007_654_321, [630.001, 630.007_654]),
            ([4_500_000.6, 4_500_000.9], 0, 4_500_000.712_345, [4_500_000.712_3, 4_500_000.9]),
            ([0.123_456_789, 5000.4], 1, 4321.6, [0.123_456_789, 4322.0]),
            // Rounding would bring it to the other end, or the pointer does.
            ([0.0, 4000.0], 0, 3999.7, [3999.7, 4000.0]),
            ([1.0, 2.0], 0, 2.0, [1.0, 2.0]),
            ([1.0, 2.0], 1, 1.0, [1.0, 2.0]),
        ] {
            assert_eq!(with_end(ends, end, x, true), wanted, "{ends:?} {x}");
        }
        assert_eq!(with_end([0.0, 5000.0], 1, 4_321.654_321, false), [0.0, 4_321.654_321], "typed");
    }

    /// The ends of the colors of two clouds, as the legend has them.
    fn ends_of(paths: [&str; 2], keys: [&str; 2]) -> [Option<[f64; 2]>; 2] {
        let table = |i: usize| {
            let (path, keys) = (paths[i], keys[i]);
            format!("[[cloud]]\npath = '{path}'\nradius = 1.0\ncolor_by = 'height'\n{keys}\n")
        };
        let scene = Scene::from_toml(&(table(0) + &table(1)), "s.toml".as_ref()).unwrap();
        let positions = (0..20).map(|i| DVec3::new(f64::from(i), 0.0, f64::from(i))).collect();
        let cloud = Cloud { positions, up: UpAxis::Z, ..Cloud::default() };
        let clouds = vec![cloud.clone(), cloud];
        let (_, legend) = arrange_with_legend(&scene, clouds, 0, &Progress::hidden()).unwrap();
        [0, 1].map(|i| {
            let entry = legend.entry_of(i)?;
            Some(entry.values.as_ref()?.scale.ends())
        })
    }

    #[test]
    fn a_cloud_has_no_range_of_another_one_of_its_name() {
        let (first, second) = ("range = [2.0, 5.0]", "range = [3.0, 9.0]");
        let wanted = [Some([2.0, 5.0]), Some([3.0, 9.0])];
        assert_eq!(ends_of(["a/scan.laz", "b/other.laz"], [first, second]), wanted);
        assert_eq!(ends_of(["a/scan.laz", "b/scan.laz"], [first, second]), wanted);
        assert_eq!(ends_of(["a/scan.laz", "b/scan.laz"], [first, first]), [wanted[0]; 2]);
    }

    #[test]
    fn auto_is_mapped_where_it_falls_to_height() {
        let statistics = |auto| Statistics { auto, ..Statistics::default() };
        let settings = CloudSettings::default();
        for (auto, wanted) in [(ColorBy::Height, true), (ColorBy::Rgb, false), (ColorBy::Classification, false)] {
            assert_eq!(is_mapped(&settings, Some(&statistics(auto))), wanted);
        }
        assert!(!is_mapped(&settings, None), "not known yet");
    }
}
