//! `stack`: n discs one behind the other, each over the whole image: every pixel holds exactly n fragments.

use glam::DVec3;

use super::builder::{CloudBuilder, Rgb};
use super::random::Random;
use super::{Error, Generated};
use pellucid_core::cloud::Cloud;

/// Depths are in [1, 2), where float32 has 2²³ values: each layer has its own.
pub(super) const MAX_LAYERS: f64 = (1u32 << 23) as f64;

/// The eye's height; the image is 2 world units high and wide.
pub(super) const EYE_Z: f64 = 2.0;

/// Extends beyond the image's corners, which are √2 from its center.
const RADIUS: f64 = 1.5;

/// Neighbors differ strongly, so that a wrong order shows.
pub(super) const COLORS: [Rgb; 6] =
    [[230, 60, 50], [60, 180, 75], [60, 100, 230], [245, 200, 40], [170, 60, 200], [50, 200, 210]];

pub(super) fn generate([layers, size, opacity]: [f64; 3], seed: u64) -> Result<Generated, Error> {
    let (layers, size) = (layers as usize, size as usize);
    let mut order: Vec<usize> = (0..layers).collect();
    shuffle(&mut order, &mut Random::new(seed));
    let mut builder = CloudBuilder::with_capacity(layers)?;
    for layer in order {
        builder.point(DVec3::new(0.0, 0.0, height(layer, layers)), COLORS[layer % COLORS.len()]);
    }
    let about = format!("{layers} layers over the whole image, in the file in random order.");
    Ok(scene("stack", &about, size, [2.0, opacity, RADIUS], builder.finish()))
}

/// Returns the scene of a cloud of layers: its name, what it is, the side of the image; the height of the image in
/// world units, and opacity and radius of the points.
pub(super) fn scene(name: &str, about: &str, size: usize, numbers: [f64; 3], cloud: Cloud) -> Generated {
    let [height, opacity, radius] = numbers;
    let image = format!("size = [{size}, {size}]");
    let lens = format!("height = {height:?}\nnear = 0.5\nfar = 2.5");
    let keys = format!("opacity = {opacity:?}\nradius = {radius:?}");
    Generated::alone(name, cloud, [about, &image, &format!("{EYE_Z:?}"), &lens, &keys])
}

/// Returns the height of a layer below the eye, the first one on top.
pub(super) fn height(layer: usize, layers: usize) -> f64 {
    // A power of two, so that depth and height are exact in float32.
    let spacing = 1.0 / layers.next_power_of_two() as f64;
    EYE_Z - 1.0 - layer as f64 * spacing
}

/// Fisher–Yates.
pub(super) fn shuffle<T>(order: &mut [T], random: &mut Random) {
    for last in (1..order.len()).rev() {
        order.swap(last, random.index(last + 1));
    }
}
