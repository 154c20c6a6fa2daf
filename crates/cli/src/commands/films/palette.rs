//! 256 colors for all frames of a GIF, so that nothing flickers that rests.

use std::collections::{HashMap, HashSet};
use std::io;

use color_quant::NeuQuant;

use super::stills::Stills;

/// Pixels that the colors are chosen by.
const SAMPLES: usize = 200_000;

/// Distance in levels of 255 from the nearest color of the palette at which a color gets one of its own: farther away
/// a small thing changes its hue.
const NEGLECTED: i32 = 16;

/// Colors that are for neglected ones, at most: a quarter costs the others a tenth of their accuracy.
const RESERVED: usize = 64;

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
        let mut cells = Cells::default();
        let mut number = 0;
        for still in stills.iter() {
            let bytes = still?.bytes;
            let mut before = None;
            for pixel in rgb(&bytes) {
                if before.replace(pixel) != Some(pixel) {
                    cells.add(pixel);
                    if all.len() <= 256 {
                        all.insert(pixel);
                    }
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
            let colors = |count| [chosen(&rest, count), vec![most]].concat();
            let means = cells.means();
            // The samples decide by their number, so few pixels count little, and may not be among them at all.
            match neglected(&means, &colors(255), RESERVED).len() {
                0 => colors(255),
                reserved => {
                    let frequent = colors(255 - reserved);
                    let rare = neglected(&means, &frequent, reserved);
                    [frequent, rare].concat()
                }
            }
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

/// Sums of the colors in each cube of 8 levels.
struct Cells {
    sums: Vec<[u64; 3]>,
    counts: Vec<u64>,
}

impl Default for Cells {
    fn default() -> Self {
        Self { sums: vec![[0; 3]; 1 << 15], counts: vec![0; 1 << 15] }
    }
}

impl Cells {
    fn add(&mut self, pixel: [u8; 3]) {
        let [r, g, b] = pixel.map(|value| usize::from(value >> 3));
        let cell = r << 10 | g << 5 | b;
        (0..3).for_each(|channel| self.sums[cell][channel] += u64::from(pixel[channel]));
        self.counts[cell] += 1;
    }

    /// Means of the cubes that hold a color.
    fn means(&self) -> Vec<[u8; 3]> {
        let held = self.sums.iter().zip(&self.counts).filter(|(_, count)| **count > 0);
        held.map(|(sum, count)| sum.map(|sum| ((sum + count / 2) / count) as u8)).collect()
    }
}

/// Returns at most `most` of the colors, so that those of which the palette has nothing near become fewer: always the
/// one that is farthest from all.
fn neglected(colors: &[[u8; 3]], palette: &[[u8; 3]], most: usize) -> Vec<[u8; 3]> {
    let far = NEGLECTED.pow(2) * apart([0; 3], [1; 3]);
    let to_nearest = |color: &[u8; 3]| palette.iter().map(|other| apart(*color, *other)).min().unwrap_or(i32::MAX);
    let mut distances: Vec<i32> = colors.iter().map(to_nearest).collect();
    let mut found = Vec::new();
    while found.len() < most
        && let Some((at, distance)) = distances.iter().copied().enumerate().max_by_key(|(_, distance)| *distance)
        && distance > far
    {
        let color = colors[at];
        found.push(color);
        distances.iter_mut().zip(colors).for_each(|(distance, other)| *distance = apart(color, *other).min(*distance));
    }
    found
}

/// Chooses at most `count` colors for these pixels (R, G, B, A).
fn chosen(pixels: &[u8], count: usize) -> Vec<[u8; 3]> {
    if pixels.is_empty() {
        return Vec::new();
    }
    let map = NeuQuant::new(1, count, pixels).color_map_rgb();
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
    fn colors_far_from_a_palette_come_first_and_near_ones_not_at_all() {
        let colors = [[10; 3], [0, 255, 0], [0, 250, 0], [255, 255, 0], [24; 3]];
        // Beside the yellow the second green is the farther one, by 4 · 5²; the first one then has it near.
        assert_eq!(neglected(&colors, &[[10; 3]], 9), [[255, 255, 0], [0, 250, 0]]);
        assert_eq!(neglected(&colors, &[[10; 3]], 1), [[255, 255, 0]]);
        assert_eq!(neglected(&colors, &colors, 9), [[0; 3]; 0]);
    }

    #[test]
    fn a_cell_is_the_mean_of_its_colors() {
        let mut cells = Cells::default();
        [[8, 16, 255], [11, 17, 255], [11, 16, 254], [90; 3]].into_iter().for_each(|color| cells.add(color));
        assert_eq!(cells.means(), [[10, 16, 255], [90; 3]]);
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
