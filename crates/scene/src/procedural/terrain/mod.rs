//! `terrain`: a landscape of any size with a river, fields, forests and towns, whose tiles can be made one by one.
//!
//! A landscape of n points is a square of 4.47 ∛n meters, nearly: each doubling of the side takes eight times the
//! points, so that pulses are denser in larger ones: some 4 on a square meter of 10⁶ points, 40 of 10⁹. What stands
//! where follows from the seed and the side alone; a tile needs no other one.

mod bins;
mod buildings;
mod ground;
mod land;
mod light;
mod posts;
mod scan;
mod site;
mod solids;
mod store;
mod town;
mod trees;

pub use store::Terrain;

use super::builder::CloudBuilder;
use super::{Error, Generated, Given, MAX_POINTS, Parameter, count};
use pellucid_core::parallel;
use pellucid_io::store::Store;

/// The name of the scene.
pub const NAME: &str = "terrain";

/// Points of a landscape up to which a file is written where nothing else is asked for: in memory they take 0.6 GB.
pub const FILE_POINTS: u64 = 10_000_000;

/// Fewest and most points of a [`Terrain`].
const RANGE: [f64; 2] = [10_000.0, 1e10];

/// The parameter of the scene.
pub(super) const POINTS: Parameter = count("points", 1e6, RANGE[0], RANGE[1], "points of the scan");

/// Tiles that are made at once.
const BATCH: usize = 32;

/// Returns the number of points that some parameters ask for, as [`build`](super::build) takes them.
///
/// # Errors
/// An unknown parameter, a value out of range or not whole.
pub fn points(parameters: &[(String, f64)]) -> Result<u64, Error> {
    let [points] = Given { scene: NAME, values: parameters }.values(&[POINTS])?;
    Ok(points as u64)
}

/// All of it in memory.
pub(super) fn generate([points]: [f64; 1], seed: u64) -> Result<Generated, Error> {
    if points > MAX_POINTS {
        return Err(Error::OutOfRange { scene: NAME, name: "points", value: points, min: RANGE[0], max: MAX_POINTS });
    }
    let points = points as usize;
    // All columns in advance, as long as they are refused as a whole.
    let mut cloud = CloudBuilder::with_capacity(points)?.finish();
    let terrain = Terrain::new(points as u64, seed)?;
    let empty = &terrain.summary().like;
    (cloud.normals, cloud.radii) = (empty.normals.clone(), empty.radii.clone());
    cloud.classification.clone_from(&empty.classification);
    let tiles: Vec<usize> = (0..terrain.nodes().len()).collect();
    for some in tiles.chunks(BATCH) {
        let parts = parallel::gather(some.len(), |i| terrain.tile(some[i]));
        for mut part in parts {
            // PLY files of scenes hold float32.
            part.positions.iter_mut().for_each(|p| *p = p.as_vec3().as_dvec3());
            cloud.append(part);
        }
    }
    Ok(Generated { clouds: vec![("terrain.ply".to_owned(), cloud)], scene_toml: terrain.scene_toml("terrain.ply") })
}
