//! The simulated scan: where on the surfaces a scanner at a few stations would have left points.

use glam::DVec3;

use super::super::Error;
use super::super::random::{Random, dither};
use super::model::Patch;

/// A scanned point before light and noise.
pub(super) struct Sample {
    pub(super) position: DVec3,
    pub(super) normal: DVec3,
    /// Linear color without light.
    pub(super) albedo: DVec3,
    pub(super) class: u8,
}

/// Positions of the scanner: around the house and in both rooms.
const STATIONS: [DVec3; 6] = [
    DVec3::new(-2.6, -5.6, 1.7),
    DVec3::new(4.2, -6.2, 1.7),
    DVec3::new(6.6, 4.6, 1.7),
    DVec3::new(-5.2, 5.2, 1.7),
    DVec3::new(-0.9, 0.4, 1.8),
    DVec3::new(2.6, -0.6, 1.8),
];

/// Distance at which half of the points are left.
const RANGE: f64 = 16.0;

/// Returns the share of the points that the scanner's distance leaves, between 0 and 1.
pub(super) fn density(position: DVec3) -> f64 {
    let nearest = STATIONS.iter().map(|s| s.distance_squared(position)).fold(f64::INFINITY, f64::min);
    1.0 / (1.0 + nearest / (RANGE * RANGE))
}

/// Returns `true` below a scanner outdoors, where its own tripod hides the ground.
pub(super) fn hidden_by_tripod(position: DVec3) -> bool {
    STATIONS.iter().take(4).any(|s| (s.truncate() - position.truncate()).length_squared() < 0.22 * 0.22)
}

/// Returns an empty list with room for `count` samples and a few more.
pub(super) fn samples(count: usize) -> Result<Vec<Sample>, Error> {
    let mut samples = Vec::new();
    samples
        .try_reserve(count)
        .map_err(|_| Error::TooLarge { points: count, bytes: count.saturating_mul(size_of::<Sample>()) })?;
    Ok(samples)
}

/// About `count` points spread over the surfaces by area, weight and distance to the scanner, and the spacing between
/// neighbors where it is nearest.
pub(super) fn scan(patches: &[Patch], count: usize, random: &mut Random) -> Result<(Vec<Sample>, f64), Error> {
    let shares: Vec<f64> = patches.iter().map(|p| p.shape.area() * p.weight * kept(p, random)).collect();
    let total: f64 = shares.iter().sum();
    let mut out = samples(count)?;
    for (patch, share) in patches.iter().zip(&shares) {
        // `kept` reduces these tries to the surface's share of the points.
        let tries = count as f64 / total * patch.shape.area() * patch.weight;
        if *share > 0.0 {
            scan_patch(patch, tries, random, &mut out);
        }
    }
    Ok((out, (total / count.max(1) as f64).sqrt()))
}

/// Share of the tries on a patch that give a point, from an 8 × 8 grid.
fn kept(patch: &Patch, random: &mut Random) -> f64 {
    let places = (0..64).filter_map(|i| {
        let (s, t) = ((f64::from(i % 8) + 0.5) / 8.0, (f64::from(i / 8) + 0.5) / 8.0);
        patch.shape.at(s, t, random)
    });
    places.map(|p| density(p.position)).sum::<f64>() / 64.0
}

/// A jittered grid over the patch with cells as square as they can be.
fn scan_patch(patch: &Patch, tries: f64, random: &mut Random, out: &mut Vec<Sample>) {
    let [width, height] = patch.shape.lengths();
    let columns = (tries * width / height.max(1e-9)).sqrt().round().clamp(1.0, tries.max(1.0));
    // Rounded at random, so that small patches get their share on average.
    let rows = (tries / columns + random.unit()).floor() as usize;
    let shift = random.index(1 << 20);
    for row in 0..rows {
        for column in 0..columns as usize {
            let s = (column as f64 + 0.5 + 0.6 * (random.unit() - 0.5)) / columns;
            let t = (row as f64 + 0.5 + 0.6 * (random.unit() - 0.5)) / rows as f64;
            let Some(place) = patch.shape.at(s, t, random) else { continue };
            if dither(column + shift, row) < density(place.position) {
                let albedo = patch.paint.albedo(s * width, t * height, place.position, place.depth, random);
                out.push(Sample { position: place.position, normal: place.normal, albedo, class: patch.class });
            }
        }
    }
}
