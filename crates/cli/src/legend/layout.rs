//! Layout of a legend in a picture.

use std::iter;

use pellucid_core::camera::Camera;
use pellucid_core::color::ticks::Tick;
use pellucid_scene::legend::{Entry, Legend, ScaleBar, Swatch, Values};

use super::LegendPlace;
use super::canvas::Letters;

/// The height of letters: of the picture's shorter side, and at least so many pixels.
const EM: (f32, f32) = (0.02, 11.0);

/// Letters become smaller in these steps where a legend doesn't fit, down to so many pixels; below, they can't be read.
const SMALLER: (f32, f32) = (0.85, 7.0);

/// The share of the picture's width that a legend over the picture may take: with letters of the usual height, and with
/// smaller ones.
const SHARE: [f32; 2] = [1.0 / 3.0, 0.5];

/// The width of a column beside the picture, in heights of usual letters.
const COLUMN: f32 = 15.0;

/// Color bars in lines of text, from the best to the least.
const BAR_LINES: [u32; 4] = [10, 8, 6, 5];

/// Lines of a color bar where nothing else helps.
const SHORT_BAR: u32 = 3;

/// The least single colors of an entry that are shown before the rest is only counted.
const FEWEST: usize = 2;

/// The width of words, in heights of letters, so that they don't make the panel wide.
const WORDS: f32 = 12.0;

/// A row of a legend.
pub enum LegendRow<'a> {
    /// The name of a file.
    Title(String),
    /// Words.
    Text(String),
    /// A color bar with numbers beside it.
    Bar(&'a Values, Vec<Tick>),
    /// A color and its meaning.
    Swatch(&'a Swatch, String),
    /// A line of a known length, which the words below say.
    Scale(ScaleBar, Vec<String>),
    /// Nothing.
    Gap,
}

/// A legend, if there is one in a picture.
pub enum Fit<'a> {
    /// The legend has its place.
    Fits(Box<LegendLayout<'a>>),
    /// There is nothing to explain.
    Nothing,
    /// The picture has no room for it.
    Misfit,
}

/// A legend with the sizes of its parts, in pixels.
pub struct LegendLayout<'a> {
    /// The rows from the top, each with its height.
    pub rows: Vec<(LegendRow<'a>, f32)>,
    /// Columns and rows of the panel.
    pub panel: [f32; 2],
    /// The height of letters' em square.
    pub em: f32,
    pub letters: Letters,
}

/// Distances that depend on the size of letters.
impl LegendLayout<'_> {
    /// A line of text.
    pub fn line(em: f32) -> f32 {
        (1.35 * em).round()
    }

    /// Distance from the panel's edge to its content, and from the picture's edge to the panel.
    pub fn padding(em: f32) -> f32 {
        (0.6 * em).round()
    }

    /// The width of a color bar and of a single color.
    pub fn swatch(em: f32) -> f32 {
        (1.1 * em).round()
    }

    /// Distance from a color to its words.
    pub fn aside(em: f32) -> f32 {
        (0.6 * em).round()
    }
}

impl<'a> LegendLayout<'a> {
    /// The legend for a picture of so many columns and rows, with letters of the usual height or smaller ones.
    pub fn fit(legend: &'a Legend, camera: &Camera, size: [u32; 2], place: LegendPlace) -> Fit<'a> {
        let scale_bar = legend.scale_bar(camera, size);
        if legend.is_empty() && scale_bar.is_none() {
            return Fit::Nothing;
        }
        let (usual, column) = (usual_em(size), column(size, scale_bar.is_some()));
        let smaller = |em: &f32| Some((SMALLER.0 * em).floor()).filter(|em| *em >= SMALLER.1);
        let width = |em: f32| match place {
            LegendPlace::Beside => column as f32,
            LegendPlace::Over => SHARE[usize::from(em < usual)] * size[0] as f32,
        };
        let place = |em: f32| {
            let room = width(em) - 2.0 * Self::padding(em);
            Self::with_letters(em, [room, size[1] as f32], legend, scale_bar.as_ref())
        };
        iter::successors(Some(usual), smaller).find_map(place).map_or(Fit::Misfit, |layout| Fit::Fits(Box::new(layout)))
    }

    /// The legend with letters of a height, its values and single colors shortened until it fits into the width of its
    /// content and the height of the picture.
    fn with_letters(
        em: f32,
        [room, height]: [f32; 2],
        legend: &'a Legend,
        scale_bar: Option<&ScaleBar>,
    ) -> Option<Self> {
        let most_swatches = legend.entries.iter().map(|entry| entry.swatches.len()).max().unwrap_or(0);
        let whole = BAR_LINES.map(|lines| (lines, most_swatches));
        let shortened = (FEWEST..most_swatches).rev().map(|most| (BAR_LINES[3], most));
        whole.into_iter().chain(shortened).chain([(SHORT_BAR, FEWEST)]).find_map(|(lines, most)| {
            let letters = Letters::new(em).ok()?;
            let mut builder = Builder { letters, em, room, rows: Vec::new(), widest: 0.0 };
            builder.build(legend, scale_bar, lines, most);
            let Builder { letters, rows, widest, .. } = builder;
            let sum: f32 = rows.iter().map(|(_, height)| height).sum();
            let panel = [widest, sum].map(|side| side.ceil() + 2.0 * Self::padding(em));
            let fits = widest <= room && panel[1] + 2.0 * Self::padding(em) <= height;
            fits.then_some(Self { rows, panel, em, letters })
        })
    }
}

/// The usual height of letters in a picture of so many columns and rows.
fn usual_em(size: [u32; 2]) -> f32 {
    (EM.0 * size[0].min(size[1]) as f32).max(EM.1)
}

/// The width of the column beside a picture of so many columns and rows: even, so that a picture of even width stays
/// so. It doesn't depend on the camera but for its kind, so that all frames of a film have one size.
pub fn column(size: [u32; 2], has_scale_bar: bool) -> u32 {
    let em = usual_em(size);
    let bar = if has_scale_bar { ScaleBar::MOST * size[0] as f32 + 2.0 * LegendLayout::padding(em) } else { 0.0 };
    ((COLUMN * em).max(bar).ceil() as u32).next_multiple_of(2)
}

/// Rows that are put below each other.
struct Builder<'a> {
    letters: Letters,
    em: f32,
    /// Pixels that text may take.
    room: f32,
    rows: Vec<(LegendRow<'a>, f32)>,
    /// Pixels that the widest row takes.
    widest: f32,
}

impl<'a> Builder<'a> {
    fn push(&mut self, row: LegendRow<'a>, [width, height]: [f32; 2]) {
        self.widest = self.widest.max(width);
        self.rows.push((row, height));
    }

    fn build(&mut self, legend: &'a Legend, scale_bar: Option<&ScaleBar>, bar_lines: u32, most_swatches: usize) {
        for entry in &legend.entries {
            self.gap();
            self.entry(legend.title(entry), entry, bar_lines, most_swatches);
        }
        if let Some(bar) = scale_bar {
            self.gap();
            // In a small picture the unit stands below the number. A number is never cut off: it has to fit.
            let lines = self.letters.wrap(&bar.label, self.room);
            let words = bar.label.split_whitespace().map(|word| self.letters.width(word));
            let words = lines.iter().map(|line| self.letters.width(line)).chain(words);
            let width = words.fold(bar.length_px as f32, f32::max);
            let height = lines.len() as f32 * LegendLayout::line(self.em) + (0.5 * self.em).round();
            self.push(LegendRow::Scale(bar.clone(), lines), [width, height]);
        }
    }

    fn gap(&mut self) {
        if !self.rows.is_empty() {
            self.push(LegendRow::Gap, [0.0, (0.7 * self.em).round()]);
        }
    }

    fn entry(&mut self, title: Option<String>, entry: &'a Entry, bar_lines: u32, most_swatches: usize) {
        let line = LegendLayout::line(self.em);
        if let Some(title) = title {
            let title = self.letters.fit(&title, self.room);
            let width = self.letters.width(&title);
            self.push(LegendRow::Title(title), [width, line]);
        }
        self.words(entry.heading.as_deref().unwrap_or_default());
        if let Some(values) = &entry.values {
            self.values(values, bar_lines);
            self.words(values.note.unwrap_or_default());
        }
        for swatch in entry.swatches.iter().take(most_swatches) {
            let aside = LegendLayout::swatch(self.em) + LegendLayout::aside(self.em);
            let label = self.letters.fit(&swatch.label, self.room - aside);
            let width = aside + self.letters.width(&label);
            self.push(LegendRow::Swatch(swatch, label), [width, line]);
        }
        if let more @ 1.. = entry.swatches.len().saturating_sub(most_swatches) {
            self.words(&format!("and {more} more"));
        }
    }

    fn words(&mut self, words: &str) {
        for text in self.letters.wrap(words, self.room.min(WORDS * self.em)) {
            let width = self.letters.width(&text);
            self.push(LegendRow::Text(text), [width, LegendLayout::line(self.em)]);
        }
    }

    fn values(&mut self, values: &'a Values, bar_lines: u32) {
        let ticks = values.scale.ticks(if bar_lines >= 8 { 6 } else { 5 }, values.whole);
        let labels = ticks.iter().map(|tick| self.letters.width(&tick.label)).fold(0.0, f32::max);
        let width = LegendLayout::swatch(self.em) + LegendLayout::aside(self.em) + labels;
        // A value alone has one color. Half a line above and below is for the labels at the ends.
        let lines = if ticks.len() == 1 { 1.0 } else { bar_lines as f32 + 1.0 };
        self.push(LegendRow::Bar(values, ticks), [width, lines * LegendLayout::line(self.em)]);
    }
}
