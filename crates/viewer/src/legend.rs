//! The legend over the picture: the facts that `render --legend` draws, kept as long as they are true, and drawn by
//! egui.

use std::sync::Arc;

use egui::{
    Align2, Area, Color32, Context, FontId, Id, Label, Rect, RichText, Sense, Stroke, TextStyle, Ui, pos2, vec2,
};
use glam::DVec3;

use super::messages::WindowPicture;
use super::model::Model;
use super::overlay;
use pellucid_engine::Result;
use pellucid_scene::legend::{Entry, Legend, ScaleBar, Swatch, Values};
use pellucid_scene::{ClassSettings, Clip, CloudSettings, Scene};

/// The size of a color bar, in points.
const BAR: [f32; 2] = [14.0, 150.0];

/// The most single colors of an entry before the rest is only counted.
const MOST_SWATCHES: usize = 24;

/// The most points of a line of text.
const WIDTH: f32 = 220.0;

/// The color of its text over the picture.
const TEXT: Color32 = Color32::from_gray(225);

/// Everything that a legend depends on besides the clouds: their settings, the vertical, and the clips.
type Origin = (Vec<CloudSettings>, Option<DVec3>, Vec<Clip>);

fn origin(scene: &Scene) -> Origin {
    // A slider of opacities or radii must not have all points looked at again.
    let some = |opacity: f32| if opacity > 0.0 { 1.0 } else { 0.0 };
    let class = |entry: &ClassSettings| ClassSettings { opacity: entry.opacity.map(some), ..entry.clone() };
    let shown = |cloud: &CloudSettings| CloudSettings {
        opacity: some(cloud.surface_opacity.unwrap_or(cloud.opacity)),
        surface_opacity: None,
        class: cloud.class.iter().map(class).collect(),
        radius: None,
        radius_factor: 1.0,
        ..cloud.clone()
    };
    (scene.clouds.iter().map(shown).collect(), scene.camera.up, scene.clips.clone())
}

/// The last legend, kept so that points are looked at only when it may change.
#[derive(Default)]
pub struct Legends(Option<(Origin, Arc<Legend>)>);

impl Legends {
    /// The legend of a scene: as it is known, or as it is found.
    ///
    /// # Errors
    /// The legend can't be found.
    pub fn of_scene(&mut self, scene: &Scene, find: impl FnOnce() -> Result<Legend>) -> Result<Arc<Legend>> {
        let origin = origin(scene);
        match &self.0 {
            Some((known, legend)) if *known == origin => Ok(legend.clone()),
            _ => {
                let legend = Arc::new(find()?);
                self.0 = Some((origin, legend.clone()));
                Ok(legend)
            }
        }
    }
}

/// Draws the legend of the picture, if it is asked for and there is anything to explain.
pub fn show(ctx: &Context, model: &Model) {
    let picture = model.picture().filter(|_| model.shows.legend);
    let Some((picture, legend)) = picture.and_then(|picture| Some((picture, picture.legend.as_ref()?))) else { return };
    let scale_bar = legend.scale_bar(&picture.camera, picture.size);
    if legend.is_empty() && scale_bar.is_none() {
        return;
    }
    // Above the line that says how far points are.
    let at = Area::new(Id::new("legend")).anchor(Align2::LEFT_BOTTOM, [8.0, -44.0]).interactable(false);
    at.show(ctx, |ui| overlay::frame().show(ui, |ui| content(ui, picture, legend, scale_bar)));
}

fn content(ui: &mut Ui, picture: &WindowPicture, legend: &Legend, scale_bar: Option<ScaleBar>) {
    // Read over a picture, and not beside other controls.
    ui.visuals_mut().override_text_color = Some(TEXT);
    ui.set_max_width(WIDTH.max(0.25 * picture.size[0] as f32 / ui.ctx().pixels_per_point()));
    entries(ui, legend);
    if let Some(bar) = scale_bar {
        ui.add_space(4.0);
        length(ui, &bar);
    }
}

/// The meaning of the colors of each cloud.
pub fn entries(ui: &mut Ui, legend: &Legend) {
    for (number, entry) in legend.entries.iter().enumerate() {
        if number > 0 {
            ui.add_space(8.0);
        }
        if let Some(title) = legend.title(entry) {
            ui.add(Label::new(RichText::new(title).strong()).truncate());
        }
        explain(ui, entry);
    }
}

fn explain(ui: &mut Ui, entry: &Entry) {
    if let Some(heading) = &entry.heading {
        ui.label(heading);
    }
    if let Some(values) = &entry.values {
        color_bar(ui, values);
        if let Some(note) = values.note {
            ui.weak(note);
        }
    }
    entry.swatches.iter().take(MOST_SWATCHES).for_each(|swatch| single(ui, swatch));
    if let more @ 1.. = entry.swatches.len().saturating_sub(MOST_SWATCHES) {
        ui.weak(format!("and {more} more"));
    }
}

fn color(srgb: DVec3) -> Color32 {
    let [r, g, b] = srgb.to_array().map(|value| (255.0 * value).round() as u8);
    Color32::from_rgb(r, g, b)
}

fn font(ui: &Ui) -> FontId {
    TextStyle::Body.resolve(ui.style())
}

/// A color bar, its high end at the top, with numbers beside it.
fn color_bar(ui: &mut Ui, values: &Values) {
    let ticks = values.scale.ticks(6, values.whole);
    let (alone, font, text) = (ticks.len() == 1, font(ui), ui.visuals().text_color());
    let [width, tall] = if alone { [BAR[0], font.size] } else { BAR };
    // Half a line above and below is for the labels at the ends.
    let (room, _) = ui.allocate_exact_size(vec2(WIDTH, tall + font.size), Sense::hover());
    let bar = Rect::from_min_size(room.min + vec2(0.0, 0.5 * font.size), vec2(width, tall));
    let painter = ui.painter();
    let rows = tall.round() as u32;
    for row in 0..rows {
        let place = if alone { 0.0 } else { 1.0 - (f64::from(row) + 0.5) / f64::from(rows) };
        let strip = Rect::from_min_size(bar.min + vec2(0.0, row as f32), vec2(width, 1.0));
        painter.rect_filled(strip, 0.0, color(values.srgb(place)));
    }
    let mut free_above = f32::INFINITY;
    for tick in &ticks {
        let y = if alone { bar.center().y } else { bar.bottom() - tick.place as f32 * tall };
        painter.hline(bar.right()..=bar.right() + 4.0, y, Stroke::new(1.0, text));
        if y + 0.5 * font.size < free_above {
            painter.text(pos2(bar.right() + 8.0, y), Align2::LEFT_CENTER, &tick.label, font.clone(), text);
            free_above = y - 0.5 * font.size;
        }
    }
}

/// A color and its meaning.
fn single(ui: &mut Ui, swatch: &Swatch) {
    ui.horizontal(|ui| {
        let side = font(ui).size;
        let (room, _) = ui.allocate_exact_size(vec2(BAR[0], side), Sense::hover());
        ui.painter().rect_filled(room, 1.0, color(swatch.srgb));
        ui.add(Label::new(&swatch.label).truncate());
    });
}

/// A line between two marks, as long on the screen as its length in the picture.
fn length(ui: &mut Ui, bar: &ScaleBar) {
    let long = bar.length_px as f32 / ui.ctx().pixels_per_point();
    let (room, _) = ui.allocate_exact_size(vec2(long, 8.0), Sense::hover());
    let stroke = Stroke::new(1.5, ui.visuals().text_color());
    ui.painter().hline(room.x_range(), room.bottom(), stroke);
    for x in [room.left(), room.right()] {
        ui.painter().vline(x, room.y_range(), stroke);
    }
    ui.label(&bar.label);
}

#[cfg(test)]
mod tests {
    use super::*;
    use pellucid_scene::{Document, Overrides};

    #[test]
    fn points_are_looked_at_again_only_if_colors_may_mean_something_else() {
        let scene = |text: &str| {
            let text = format!("[[cloud]]\npath = 'a.ply'\n{text}");
            Document::from_toml(&text, "s.toml".as_ref(), &Overrides::default()).unwrap().scene().unwrap()
        };
        let (mut legends, mut looked) = (Legends::default(), 0);
        let cases = [
            ("", 1),
            ("opacity = 0.5\nradius = 2.0", 1),
            ("opacity = 0.0", 2),
            ("color_by = 'z'", 3),
            ("color_by = 'z'\nradius_factor = 2.0", 3),
            ("color_by = 'z'\nsurface_opacity = 0.3", 3),
            ("color_by = 'z'\nsurface_opacity = 0.7", 3),
            ("color_by = 'z'\nsurface_opacity = 0.0", 4),
            ("color_by = 'z'\n[camera]\nup = [0, 1, 0]", 5),
            ("[[cloud.class]]\nid = 2\nopacity = 0.5", 6),
            ("[[cloud.class]]\nid = 2\nopacity = 0.7", 6),
            ("[[cloud.class]]\nid = 2\nopacity = 0.0", 7),
            ("surface_opacity = 0.2\n[[cloud.class]]\nid = 2\nopacity = 0.0", 7),
            ("[[cloud.class]]\nid = 2\nvisible = false", 8),
        ];
        for (text, wanted) in cases {
            legends
                .of_scene(&scene(text), || {
                    looked += 1;
                    Ok(Legend::default())
                })
                .unwrap();
            assert_eq!(looked, wanted, "{text}");
        }
    }
}
