//! 256 colors for all frames of a GIF, so that nothing flickers that rests.

use std::collections::HashMap;
use std::io;

use color_quant::NeuQuant;

use super::stills::Stills;

/// Pixels that the colors are chosen by.
const SAMPLES: usize = 400_000;

/// The largest step that dithering adds to or takes from a channel.
const DITHER: i32 = 10;

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
    /// At least two, at most 256.
    colors: Vec<[u8; 3]>,
    /// True if every color of the frames is among them.
    is_exact: bool,
    /// The nearest color, once it was looked for.
    known: HashMap<[u8; 3], u8>,
}

impl Palette {
    /// Chooses the colors of all frames.
    ///
    /// # Errors
    /// A frame that can't be read.
    pub fn of(stills: &Stills<'_>) -> io::Result<Self> {
        let [width, height] = stills.size();
        let all = width as usize * height as usize * stills.count();
        // Odd, so that samples are not all in one column.
        let every = (all / SAMPLES).max(1) | 1;
        let mut counts: HashMap<[u8; 3], usize> = HashMap::new();
        let mut samples = Vec::new();
        let mut is_exact = true;
        let mut number = 0;
        for still in stills.iter() {
            for pixel in rgb(&still?.bytes) {
                if counts.len() <= 256 || counts.contains_key(&pixel) {
                    *counts.entry(pixel).or_default() += 1;
                }
                if number % every == 0 {
                    samples.push(pixel);
                }
                number += 1;
            }
        }
        if counts.len() > 256 {
            is_exact = false;
        }
        let mut colors: Vec<[u8; 3]> = if is_exact {
            counts.into_keys().collect()
        } else {
            // The most frequent color is the background's: it is kept as it is, and the others are for the scene.
            let most = counts
                .into_iter()
                .max_by_key(|&(color, count)| (count, color))
                .map(|(color, _)| color)
                .unwrap_or_default();
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
        Ok(Self { colors, is_exact, known: HashMap::new() })
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
        let colors = &self.colors;
        *self.known.entry(pixel).or_insert_with(|| {
            let nearest = colors.iter().enumerate().min_by_key(|(_, color)| apart(pixel, **color));
            nearest.map_or(0, |(at, _)| at as u8)
        })
    }
}

/// How different two colors look, by the shares of the channels in luminance.
fn apart(a: [u8; 3], b: [u8; 3]) -> i32 {
    let square = |channel: usize| (i32::from(a[channel]) - i32::from(b[channel])).pow(2);
    2 * square(0) + 4 * square(1) + square(2)
}

/// At most 255 colors for these pixels (R, G, B, A).
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
        let mut palette = Palette { colors: vec![[100; 3], [110; 3]], is_exact: false, known: HashMap::new() };
        let indices = palette.indices(&[103; 3 * 64], 8);
        let second = indices.iter().filter(|index| **index == 1).count();
        assert!((8..32).contains(&second), "{second} of 64");
        assert!(
            palette.indices(&[100; 3 * 64], 8).iter().all(|index| *index == 0),
            "a color that is there is not mixed"
        );
    }
}
