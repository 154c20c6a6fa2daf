//! `--legend`: what the colors of a picture mean and how long things are, drawn onto the pixels of a PNG.

mod canvas;
mod layout;
#[cfg(test)]
mod tests;

use std::path::Path;

use clap::ValueEnum;
use glam::{DVec3, Vec3};
use pellucid_core::camera::{Camera, StatedCamera};
use pellucid_core::color::encode_srgb;
use pellucid_core::color::ticks::Tick;
use pellucid_core::image::Image;
use pellucid_engine::Result;
use pellucid_io::output::{self, Raster, WriteOptions};
use pellucid_scene::legend::{Legend, ScaleBar, Values};
use pellucid_session::{Messages, Prepared};

use canvas::{Canvas, Ink};
use layout::{Fit, LegendLayout, LegendRow};

/// Linear luminance of a background from which on the panel is light: sRGB 0.5, halfway between black and white to the
/// eye.
const LIGHT: f32 = 0.214;

/// The colors of a panel and of its text.
#[derive(Clone, Copy)]
struct Looks {
    panel: Ink,
    text: Ink,
    title: Ink,
}

const DARK_PANEL: Looks = Looks {
    panel: Ink { rgb: [18.0, 18.0, 22.0], cover: 0.75 },
    text: Ink::solid([225.0, 225.0, 225.0]),
    title: Ink::solid([255.0, 255.0, 255.0]),
};

const LIGHT_PANEL: Looks = Looks {
    panel: Ink { rgb: [250.0, 250.0, 250.0], cover: 0.8 },
    text: Ink::solid([40.0, 40.0, 40.0]),
    title: Ink::solid([0.0, 0.0, 0.0]),
};

impl Looks {
    /// Returns the looks that stand out least from a background, linear RGB.
    fn on(background: Vec3) -> Self {
        let luminance = background.dot(Vec3::new(0.2126, 0.7152, 0.0722));
        if luminance > LIGHT { LIGHT_PANEL } else { DARK_PANEL }
    }
}

/// Place of a legend.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum LegendPlace {
    /// Lower left corner of the picture.
    Over,
    /// Column to the right, by which the file becomes wider than the picture.
    Beside,
}

/// Says, before anything is rendered by these cameras, where there will be no legend: since there is nothing to
/// explain, or no room for it.
pub fn check(prepared: &Prepared, cameras: &[StatedCamera], place: Option<LegendPlace>, messages: &dyn Messages) {
    let (Some(legend), Some(place)) = (&prepared.assembled.legend, place) else { return };
    let size = prepared.scene().image.size;
    let fit = |camera: &Camera| LegendLayout::fit(legend, camera, size, place);
    if !cameras.iter().any(|camera| !matches!(fit(camera), Fit::Nothing)) {
        messages.note(
            &"--legend draws nothing: the colors show neither values nor classes (see --color-by), and a scale bar needs an \
             orthographic camera (--ortho)",
        );
        return;
    }
    let Some(first) = cameras.iter().position(|camera| matches!(fit(camera), Fit::Misfit)) else { return };
    let frame = if cameras.len() > 1 { format!(" from frame {first} on") } else { String::new() };
    let [width, height] = size;
    messages.note(&format_args!(
        "--legend: a legend does not fit into {width} × {height} pixels, and is left out{frame}; a larger --size has room for it"
    ));
}

/// Writes a picture as a PNG with its legend; without one where it does not fit into this frame.
pub fn write(
    path: &Path,
    image: &Image,
    options: &WriteOptions,
    (legend, place): (&Legend, LegendPlace),
    camera: &Camera,
) -> Result<()> {
    output::check_writing(path, image, options)?;
    let mut raster = output::raster(image, options);
    // The background of a transparent picture is not known.
    let looks = if options.transparent { DARK_PANEL } else { Looks::on(options.background) };
    if let Fit::Fits(layout) = LegendLayout::fit(legend, camera, raster.size, place) {
        match place {
            LegendPlace::Over => draw(&layout, looks, &mut raster),
            LegendPlace::Beside => {
                let column = layout::column(raster.size, legend.scale_bar(camera, raster.size).is_some());
                raster = widened(&raster, column, options.background);
                draw_beside(&layout, looks, column, &mut raster);
            }
        }
    }
    Ok(output::write_raster(path, &raster, &options.metadata)?)
}

/// Draws a legend into the lower left corner.
fn draw(layout: &LegendLayout<'_>, looks: Looks, raster: &mut Raster) {
    let padding = LegendLayout::padding(layout.em);
    let corner = [padding, raster.size[1] as f32 - padding - layout.panel[1]];
    Canvas::new(raster).fill(corner, layout.panel, looks.panel);
    rows(layout, looks, corner, raster);
}

/// Draws a legend into the last columns of a picture, at their lower end.
fn draw_beside(layout: &LegendLayout<'_>, looks: Looks, column: u32, raster: &mut Raster) {
    let padding = LegendLayout::padding(layout.em);
    let [width, height] = raster.size.map(|side| side as f32);
    let left = width - column as f32;
    Canvas::new(raster).fill([left, 0.0], [column as f32, height], looks.panel);
    rows(layout, looks, [left, height - padding - layout.panel[1]], raster);
}

/// Draws the rows of a legend on a panel with this corner.
fn rows(layout: &LegendLayout<'_>, looks: Looks, corner: [f32; 2], raster: &mut Raster) {
    let mut pen = Pen { canvas: Canvas::new(raster), layout, looks };
    let [x, mut y] = corner.map(|edge| edge + LegendLayout::padding(layout.em));
    for (row, height) in &layout.rows {
        pen.row(row, [x, y], *height);
        y += height;
    }
}

/// Returns a picture with more columns to the right: of its background, or of nothing where it is transparent.
fn widened(raster: &Raster, column: u32, background: Vec3) -> Raster {
    let pixel = if raster.alpha { 4 } else { 3 };
    let [width, height] = raster.size;
    let more: Vec<u8> = match raster.alpha {
        true => vec![0; column as usize * pixel],
        false => background.to_array().map(|value| output::to_byte(encode_srgb(value))).repeat(column as usize),
    };
    let rows = raster.bytes.chunks_exact(width as usize * pixel);
    let mut bytes = Vec::with_capacity(raster.bytes.len() + more.len() * height as usize);
    rows.for_each(|row| bytes.extend(row.iter().chain(&more)));
    Raster { size: [width + column, height], alpha: raster.alpha, bytes }
}

/// Means by which rows are drawn.
struct Pen<'a> {
    canvas: Canvas<'a>,
    layout: &'a LegendLayout<'a>,
    looks: Looks,
}

impl Pen<'_> {
    fn row(&mut self, row: &LegendRow<'_>, [x, y]: [f32; 2], height: f32) {
        let (em, middle) = (self.layout.em, y + 0.5 * height);
        match row {
            LegendRow::Title(text) => self.canvas.write(&self.layout.letters, [x, middle], text, self.looks.title),
            LegendRow::Text(text) => self.words([x, middle], text),
            LegendRow::Bar(values, ticks) => self.bar(values, ticks, [x, y], height),
            LegendRow::Swatch(swatch, label) => {
                let side = (0.9 * em).round();
                self.canvas.fill(
                    [x, (middle - 0.5 * side).round()],
                    [LegendLayout::swatch(em), side],
                    ink(swatch.srgb),
                );
                self.words([x + LegendLayout::swatch(em) + LegendLayout::aside(em), middle], label);
            }
            LegendRow::Scale(bar, lines) => self.scale_bar(bar, lines, [x, y]),
            LegendRow::Gap => {}
        }
    }

    fn words(&mut self, at: [f32; 2], words: &str) {
        self.canvas.write(&self.layout.letters, at, words, self.looks.text);
    }

    /// A color bar, its high end at the top, with a mark at each number, and the numbers that don't touch the one
    /// before.
    fn bar(&mut self, values: &Values, ticks: &[Tick], [x, y]: [f32; 2], height: f32) {
        let (em, width) = (self.layout.em, LegendLayout::swatch(self.layout.em));
        let line = LegendLayout::line(em);
        let (top, tall) = if ticks.len() == 1 { (y, line) } else { (y + (0.5 * line).round(), height - line) };
        for row in 0..tall as u32 {
            let place = if ticks.len() == 1 { 0.0 } else { 1.0 - (f64::from(row) + 0.5) / f64::from(tall) };
            self.canvas.fill([x, top + row as f32], [width, 1.0], ink(values.srgb(place)));
        }
        let mut free_above = f32::INFINITY;
        for tick in ticks {
            let at = if ticks.len() == 1 { top + 0.5 * tall } else { top + (1.0 - tick.place as f32) * tall };
            self.canvas.fill([x + width, (at - 0.5).round()], [(0.3 * em).round(), 1.0], self.looks.text);
            if at + 0.5 * em < free_above {
                self.words([x + width + LegendLayout::aside(em), at], &tick.label);
                free_above = at - 0.5 * em;
            }
        }
    }

    /// A line between two marks, with its length below.
    fn scale_bar(&mut self, bar: &ScaleBar, lines: &[String], [x, y]: [f32; 2]) {
        let em = self.layout.em;
        let (long, thick, mark) = (bar.length_px as f32, (0.12 * em).round().max(1.0), (0.5 * em).round());
        let text = self.looks.text;
        self.canvas.fill([x, y + mark - thick], [long, thick], text);
        for at in [x, x + long - thick] {
            self.canvas.fill([at, y], [thick, mark], text);
        }
        for (number, words) in lines.iter().enumerate() {
            self.words([x, y + mark + 0.75 * em + number as f32 * LegendLayout::line(em)], words);
        }
    }
}

/// An opaque color of sRGB values from 0 to 1.
fn ink(srgb: DVec3) -> Ink {
    Ink::solid(srgb.to_array().map(|value| (255.0 * value) as f32))
}
