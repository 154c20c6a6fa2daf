//! 256 colors for all frames of a GIF, so that nothing flickers that rests.

use std::collections::{HashMap, HashSet};
use std::io;

use color_quant::NeuQuant;

use super::stills::Stills;

/// Pixels that the colors are chosen by.
const SAMPLES: usize = 200_000;

/// The largest step that dithering adds to or takes from a channel.
const DITHER: i32 = 6;

/// Thresholds in the order in which the cells of a square of eight by eight light up (Bayer 1973): even apart in each
/// neighborhood, and the same in each frame.
fn bayer(x: usize, y: usize) -> i32 {
    let bit = |shift: usize| {
        let (x, y) = (x >> shift & 1, y >> shift & 1);
        ((x ^ y) << 1 | y) << (2 * (2 - shift))
    };
    (bit(0) | bit(1) | bit(2)) as i32
}

pub struct Palette {
    /// Colors of the palette: at least 2, at most 256.
    colors: Vec<[u8; 3]>,
    /// True if every color of the frames is among them.
    is_exact: bool,
    /// The nearest color of each that there is, once it was looked for.
    known: Vec<u16>,
}

/// No nearest color yet.
const UNKNOWN: u16 = u16::MAX;

impl Palette {
    /// Chooses the colors of all frames.
    ///
    /// # Errors
    /// A frame that can't be read.
    pub fn of(stills: &Stills<'_>) -> io::Result<Self> {
        let [width, height] = stills.size();
        let pixels = width as usize * height as usize * stills.count();
        // Odd, so that samples are not all in one column.
        let every = (pixels / SAMPLES).max(1) | 1;
        // All colors, as long as a palette has room for them.
        let mut all = HashSet::new();
        let mut samples = Vec::new();
        let mut number = 0;
        for still in stills.iter() {
            let bytes = still?.bytes;
            let mut before = None;
            for pixel in rgb(&bytes) {
                if before.replace(pixel) != Some(pixel) && all.len() <= 256 {
                    all.insert(pixel);
                }
                if number % every == 0 {
                    samples.push(pixel);
                }
                number += 1;
            }
        }
        let is_exact = all.len() <= 256;
        let mut colors: Vec<[u8; 3]> = if is_exact {
            all.into_iter().collect()
        } else {
            // The most frequent color is the background's: it is kept as it is, and the others are for the scene.
            let mut counts: HashMap<[u8; 3], usize> = HashMap::new();
            samples.iter().for_each(|pixel| *counts.entry(*pixel).or_default() += 1);
            let most = counts.into_iter().map(|(color, count)| (count, color)).max().unwrap_or_default().1;
            let rest: Vec<u8> =
                samples.iter().filter(|pixel| **pixel != most).flat_map(|&[r, g, b]| [r, g, b, 255]).collect();
            let mut colors = chosen(&rest);
            colors.push(most);
            colors
        };
        colors.sort_unstable();
        colors.dedup();
        while colors.len() < 2 {
            colors.push([0; 3]);
        }
        Ok(Self::new(colors, is_exact))
    }

    fn new(colors: Vec<[u8; 3]>, is_exact: bool) -> Self {
        Self { colors, is_exact, known: vec![UNKNOWN; 1 << 24] }
    }

    /// The colors one after the other.
    pub fn bytes(&self) -> Vec<u8> {
        self.colors.concat()
    }

    /// The colors of a frame's pixels as numbers.
    pub fn indices(&mut self, bytes: &[u8], width: usize) -> Vec<u8> {
        rgb(bytes).enumerate().map(|(at, pixel)| self.index(pixel, [at % width, at / width])).collect()
    }

    fn index(&mut self, pixel: [u8; 3], [x, y]: [usize; 2]) -> u8 {
        let nearest = self.nearest(pixel);
        if self.is_exact || self.colors[usize::from(nearest)] == pixel {
            return nearest;
        }
        // From −DITHER to DITHER.
        let offset = (2 * bayer(x, y) - 63) * DITHER / 63;
        self.nearest(pixel.map(|value| (i32::from(value) + offset).clamp(0, 255) as u8))
    }

    fn nearest(&mut self, pixel: [u8; 3]) -> u8 {
        let [r, g, b] = pixel.map(usize::from);
        let place = r << 16 | g << 8 | b;
        if self.known[place] == UNKNOWN {
            let nearest = self.colors.iter().enumerate().min_by_key(|(_, color)| apart(pixel, **color));
            self.known[place] = nearest.map_or(0, |(at, _)| at as u16);
        }
        self.known[place] as u8
    }
}

/// Returns a distance between two colors, weighted by the shares of the channels in luminance.
fn apart(a: [u8; 3], b: [u8; 3]) -> i32 {
    let square = |channel: usize| (i32::from(a[channel]) - i32::from(b[channel])).pow(2);
    2 * square(0) + 4 * square(1) + square(2)
}

/// Chooses at most 255 colors for these pixels (R, G, B, A).
fn chosen(pixels: &[u8]) -> Vec<[u8; 3]> {
    if pixels.is_empty() {
        return Vec::new();
    }
    let map = NeuQuant::new(1, 255, pixels).color_map_rgb();
    map.chunks_exact(3).map(|color| [color[0], color[1], color[2]]).collect()
}

fn rgb(bytes: &[u8]) -> impl Iterator<Item = [u8; 3]> {
    bytes.chunks_exact(3).map(|pixel| [pixel[0], pixel[1], pixel[2]])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn thresholds_are_each_there_once() {
        let mut all: Vec<i32> = (0..64).map(|at| bayer(at % 8, at / 8)).collect();
        // The first four of Bayer's square: neighbors are far apart.
        assert_eq!([bayer(0, 0), bayer(1, 1), bayer(1, 0), bayer(0, 1)].map(|value| value / 16), [0, 1, 2, 3]);
        all.sort_unstable();
        assert_eq!(all, (0..64).collect::<Vec<_>>());
    }

    #[test]
    fn colors_between_two_are_mixed_of_both_and_their_mean_stays() {
        let mut palette = Palette::new(vec![[100; 3], [106; 3]], false);
        let indices = palette.indices(&[102; 3 * 64], 8);
        let second = indices.iter().filter(|index| **index == 1).count();
        assert!((8..32).contains(&second), "{second} of 64");
        assert!(
            palette.indices(&[100; 3 * 64], 8).iter().all(|index| *index == 0),
            "a color that is there is not mixed"
        );
    }
}
