//! `mosaic`: layers of small discs that tile the image: every pixel holds exactly n fragments, as in `stack`, but of
//! n·pixels/9 splats instead of n, and with another color on each.

use glam::DVec3;

use super::builder::CloudBuilder;
use super::random::Random;
use super::stack::{COLORS, height, scene, shuffle};
use super::{Error, Generated, MAX_POINTS};

/// Pixels between the centers of a layer's discs.
const PITCH: usize = 3;

/// World units, which are pixels. From the center of a pixel it reaches the 3 × 3 pixels around (√2) and no other (2):
/// the rim is 0.28 pixels away from any pixel's center, so that float32 decides as float64 does.
const RADIUS: f64 = 1.7;

pub(super) fn generate([layers, size, opacity]: [f64; 3], seed: u64) -> Result<Generated, Error> {
    let (layers, size) = (layers as usize, size as usize);
    let most = (size / PITCH + 2).pow(2) as f64 * layers as f64;
    if most > MAX_POINTS {
        // Rounded up: the size of a full grid on every layer.
        return Err(Error::TooLarge { points: most as usize, bytes: most as usize * size_of::<DVec3>() });
    }
    let mut discs: Vec<_> = (0..layers).flat_map(|layer| centers(layer, size).map(move |c| (layer, c))).collect();
    let mut random = Random::new(seed);
    shuffle(&mut discs, &mut random);
    let mut builder = CloudBuilder::with_capacity(discs.len())?;
    // The middle of the image is the world's origin; half pixels are exact in float32.
    let middle = 0.5 * size as f64;
    for (layer, [x, y]) in discs {
        let position = DVec3::new(x as f64 - 0.5 - middle, middle - (y as f64 - 0.5), height(layer, layers));
        builder.point(position, COLORS[random.index(COLORS.len())]);
    }
    let about =
        format!("{layers} layers of discs of 3 × 3 pixels, in the file in random order. A world unit is a pixel.");
    Ok(scene("mosaic", &about, size, [size as f64, opacity, RADIUS], builder.finish()))
}

/// Columns and rows of the pixels at the centers of a layer's discs, plus one: the blocks of 3 × 3 around them cover
/// each pixel once. The grid of each layer begins elsewhere, so that neighbors share no list.
fn centers(layer: usize, size: usize) -> impl Iterator<Item = [usize; 2]> {
    let along = move |shift: usize| (shift..size + 2).step_by(PITCH);
    let (x, y) = (layer % PITCH, layer / PITCH % PITCH);
    along(y).flat_map(move |row| along(x).map(move |column| [column, row]))
}
