//! Rectangles and text on the pixels of a PNG.

use ab_glyph::{Font, FontRef, InvalidFont, PxScale, ScaleFont, point};
use pellucid_io::output::Raster;

/// A color in sRGB, 0 to 255, and how much of it covers what is there, 0 to 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ink {
    pub rgb: [f32; 3],
    pub cover: f32,
}

impl Ink {
    /// An opaque color.
    pub const fn solid(rgb: [f32; 3]) -> Self {
        Self { rgb, cover: 1.0 }
    }
}

/// Letters of one size.
pub struct Letters {
    font: FontRef<'static>,
    scale: PxScale,
}

impl Letters {
    /// Letters whose em square is so many pixels high.
    ///
    /// # Errors
    /// The font that is part of the program is none; a test reads it.
    pub fn new(em_px: f32) -> Result<Self, InvalidFont> {
        let font = FontRef::try_from_slice(epaint_default_fonts::HACK_REGULAR)?;
        // The crate counts in heights of a line.
        let line = font.units_per_em().map_or(1.0, |em| font.height_unscaled() / em);
        Ok(Self { font, scale: PxScale::from(em_px * line) })
    }

    /// Pixels from the start of a text to its end.
    pub fn width(&self, text: &str) -> f32 {
        let font = self.font.as_scaled(self.scale);
        text.chars().map(|c| font.h_advance(font.glyph_id(c))).sum()
    }

    /// The text, or as much of it as fits, with an ellipsis.
    pub fn fit(&self, text: &str, width: f32) -> String {
        if self.width(text) <= width {
            return text.to_owned();
        }
        let mut short: Vec<char> = text.chars().collect();
        loop {
            let line = short.iter().collect::<String>() + "…";
            if short.pop().is_none() || self.width(&line) <= width {
                return line;
            }
        }
    }

    /// The text in lines that fit, broken between words where it can be.
    pub fn wrap(&self, text: &str, width: f32) -> Vec<String> {
        let mut lines: Vec<String> = Vec::new();
        for word in text.split_whitespace() {
            match lines.last_mut() {
                Some(line) if self.width(&format!("{line} {word}")) <= width => {
                    line.push(' ');
                    line.push_str(word);
                }
                _ => lines.push(word.to_owned()),
            }
        }
        lines.iter().map(|line| self.fit(line, width)).collect()
    }

    /// Pixels from the middle of capital letters down to the line they stand on.
    fn half_capital(&self) -> f32 {
        let glyph = self.font.glyph_id('0').with_scale_and_position(self.scale, point(0.0, 0.0));
        self.font.outline_glyph(glyph).map_or(0.0, |outline| -0.5 * outline.px_bounds().min.y)
    }
}

/// Pixels that are drawn on.
pub struct Canvas<'a> {
    raster: &'a mut Raster,
}

impl<'a> Canvas<'a> {
    pub fn new(raster: &'a mut Raster) -> Self {
        Self { raster }
    }

    /// Lays a color over a pixel, if there is such a pixel.
    fn blend(&mut self, x: i64, y: i64, ink: Ink, share: f32) {
        let [width, height] = self.raster.size.map(i64::from);
        if !(0..width).contains(&x) || !(0..height).contains(&y) {
            return;
        }
        let channels = if self.raster.alpha { 4 } else { 3 };
        let start = (y * width + x) as usize * channels;
        let Some(pixel) = self.raster.bytes.get_mut(start..start + channels) else { return };
        let over = (ink.cover * share).clamp(0.0, 1.0);
        let below = pixel.get(3).map_or(1.0, |alpha| f32::from(*alpha) / 255.0) * (1.0 - over);
        let sum = over + below;
        if sum <= 0.0 {
            return;
        }
        for (value, ink) in pixel.iter_mut().zip(ink.rgb) {
            *value = ((ink * over + f32::from(*value) * below) / sum).round() as u8;
        }
        if let Some(alpha) = pixel.get_mut(3) {
            *alpha = (255.0 * sum).round() as u8;
        }
    }

    /// Fills a rectangle of whole pixels.
    pub fn fill(&mut self, [x, y]: [f32; 2], [width, height]: [f32; 2], ink: Ink) {
        let [left, top, right, bottom] = [x, y, x + width, y + height].map(|edge| edge.round() as i64);
        for row in top..bottom {
            (left..right).for_each(|column| self.blend(column, row, ink, 1.0));
        }
    }

    /// Writes a text from a place to the right; `middle` is where the middle of its digits lies.
    pub fn write(&mut self, letters: &Letters, [x, middle]: [f32; 2], text: &str, ink: Ink) {
        let font = letters.font.as_scaled(letters.scale);
        // On a whole pixel, where feet of letters are sharp.
        let (mut x, baseline) = (x, (middle + letters.half_capital()).round());
        for c in text.chars() {
            let id = font.glyph_id(c);
            let glyph = id.with_scale_and_position(letters.scale, point(x, baseline));
            if let Some(outline) = letters.font.outline_glyph(glyph) {
                let corner = outline.px_bounds().min;
                let [left, top] = [corner.x, corner.y].map(|edge| edge as i64);
                outline.draw(|dx, dy, share| self.blend(left + i64::from(dx), top + i64::from(dy), ink, share));
            }
            x += font.h_advance(id);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ink_covers_its_share() {
        let mut raster = Raster { size: [3, 2], alpha: false, bytes: vec![100; 18] };
        let mut canvas = Canvas::new(&mut raster);
        canvas.fill([1.0, 0.0], [9.0, 1.0], Ink { rgb: [200.0, 0.0, 100.0], cover: 0.5 });
        // Outside is nothing to draw on.
        canvas.fill([-5.0, -5.0], [3.0, 3.0], Ink::solid([0.0; 3]));
        assert_eq!(raster.bytes[..9], [100, 100, 100, 150, 50, 100, 150, 50, 100]);
        assert_eq!(raster.bytes[9..], [100; 9]);
        // Over a pixel of alpha 0.2: half of 200, and a tenth of 100, of 0.6 in all.
        let mut raster = Raster { size: [1, 1], alpha: true, bytes: vec![100, 100, 100, 51] };
        Canvas::new(&mut raster).fill([0.0; 2], [1.0; 2], Ink { rgb: [200.0; 3], cover: 0.5 });
        assert_eq!(raster.bytes, [183, 183, 183, 153]);
    }

    #[test]
    fn texts_fit_where_they_are_to() {
        let letters = Letters::new(11.0).unwrap();
        let wide = letters.width("temporal-exclusion");
        assert!((wide - 18.0 * letters.width("0")).abs() < 1e-3, "all letters are equally wide");
        assert_eq!(letters.fit("ground", wide), "ground");
        let short = letters.fit("temporal-exclusion", 0.5 * wide);
        assert_eq!(short, "temporal…");
        assert!(letters.width(&short) <= 0.5 * wide);
        assert_eq!(letters.wrap("seconds since the first point", wide), ["seconds since the", "first point"]);
    }

    #[test]
    fn letters_leave_marks_of_their_size() {
        let mut raster = Raster { size: [40, 40], alpha: false, bytes: vec![0; 40 * 40 * 3] };
        Canvas::new(&mut raster).write(&Letters::new(20.0).unwrap(), [10.0, 20.0], "0", Ink::solid([255.0; 3]));
        let lit: Vec<usize> = (0..1600).filter(|i| raster.bytes[3 * i] > 128).map(|i| i / 40).collect();
        let (top, bottom) = (lit.iter().min().unwrap(), lit.iter().max().unwrap());
        // A digit is some 0.73 em high, its middle at 20.
        assert!((12..=14).contains(top) && (26..=28).contains(bottom), "{top} to {bottom}");
    }
}
