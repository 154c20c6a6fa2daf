//! `garden`: a simulated laser scan of a furnished garden house, which one sees into through walls, roof and trees.

mod furniture;
mod ground;
mod house;
mod light;
mod model;
mod paint;
mod plants;
mod scan;
mod shape;

use glam::DVec3;

use super::builder::{CloudBuilder, encode};
use super::random::Random;
use super::{Error, Generated};
use light::{Occupancy, ShadowMap, shade};
use model::class;
use pellucid_core::cloud::Cloud;
use scan::{Sample, scan};

/// A single cloud of the scene.
struct GardenPart {
    name: &'static str,
    opacity: f64,
    /// Share of the points.
    share: f64,
    /// Radius of the discs over the spacing of the points.
    overlap: f64,
}

const GROUND: GardenPart = GardenPart { name: "ground", opacity: 0.45, share: 0.19, overlap: 1.3 };
const STRUCTURE: GardenPart = GardenPart { name: "structure", opacity: 0.17, share: 0.17, overlap: 0.85 };
const FRAME: GardenPart = GardenPart { name: "frame", opacity: 0.7, share: 0.13, overlap: 0.8 };
const FURNITURE: GardenPart = GardenPart { name: "furniture", opacity: 0.75, share: 0.21, overlap: 0.95 };
const WOOD: GardenPart = GardenPart { name: "wood", opacity: 0.7, share: 0.04, overlap: 0.7 };
const LEAVES: GardenPart = GardenPart { name: "leaves", opacity: 0.25, share: 0.26, overlap: 0.4 };

/// Standard deviation of the scanner's range, in meters.
const NOISE: f64 = 0.003;

/// Number of points of which one is an outlier.
const OUTLIERS: usize = 1200;

/// A part, its points without light, and their spacing.
type Scanned = (GardenPart, Vec<Sample>, f64);

pub(super) fn generate([points]: [f64; 1], seed: u64) -> Result<Generated, Error> {
    let mut random = Random::new(seed);
    let count = |part: &GardenPart| (part.share * points).round() as usize;

    let plants = plants::plants(&mut random);
    let mut frame = house::frame();
    frame.place(&ground::built(), 0.0, 0.0, 0.0, 0.0);
    let (lawn, spacing) = ground::ground(count(&GROUND), &mut random)?;
    let mut scanned: Vec<Scanned> = vec![(GROUND, lawn, spacing)];
    for (part, model) in [
        (STRUCTURE, house::structure()),
        (FRAME, frame),
        (FURNITURE, furniture::furniture()),
        (WOOD, plants.wood),
        (LEAVES, plants.leaves),
    ] {
        let (samples, spacing) = scan(&model.patches, count(&part), &mut random)?;
        scanned.push((part, samples, spacing));
    }
    finish(&scanned, &mut random)
}

/// Lights the parts and writes the scene.
fn finish(scanned: &[Scanned], random: &mut Random) -> Result<Generated, Error> {
    let coarsest = scanned.iter().filter(|s| s.0.name != LEAVES.name).map(|s| s.2).fold(0.0, f64::max);
    let (mut outdoors, mut indoors) = (ShadowMap::new(coarsest), ShadowMap::new(coarsest));
    let mut occupancy = Occupancy::new(coarsest);
    for (part, samples, _) in scanned {
        outdoors.cast(samples);
        // The house casts no shadow on what is in it: the picture shows it as if the sun came through the roof.
        if part.name == FURNITURE.name {
            indoors.cast(samples);
        }
        if part.name != LEAVES.name {
            occupancy.fill(samples);
        }
    }
    let mut scene_toml = String::from(HEADER);
    let mut clouds = Vec::with_capacity(scanned.len());
    for (part, samples, spacing) in scanned {
        let shadows = if part.name == FURNITURE.name { &indoors } else { &outdoors };
        let light = |s: &Sample| shade(s, shadows, &occupancy, part.name == LEAVES.name);
        clouds.push((format!("{}.ply", part.name), cloud(samples, light, random)?));
        let (name, opacity, radius) = (part.name, part.opacity, (part.overlap * spacing) as f32);
        scene_toml += &format!("\n[[cloud]]\npath = \"{name}.ply\"\nopacity = {opacity:?}\nradius = {radius:?}\n");
    }
    Ok(Generated { clouds, scene_toml })
}

/// The points as the scanner delivers them: with noise along the normal, and a few outliers.
fn cloud(samples: &[Sample], light: impl Fn(&Sample) -> DVec3, random: &mut Random) -> Result<Cloud, Error> {
    let mut builder = CloudBuilder::with_capacity(samples.len())?;
    for sample in samples {
        let stray = random.index(OUTLIERS) == 0;
        let error =
            if stray { 0.4 * random.direction() * random.gauss() } else { NOISE * random.gauss() * sample.normal };
        builder.point(sample.position + error, encode(light(sample)));
        builder.normal(sample.normal);
        builder.class(if stray { class::NOISE } else { sample.class });
    }
    Ok(builder.finish())
}

const HEADER: &str = r#"# A simulated scan of a garden house. Each material is a cloud of its own, so that it has its own opacity.
[image]
size = [1280, 960]
background = [0.86, 0.89, 0.93]

[camera]
eye = [12.5, -20.0, 13.5]
target = [0.2, -0.5, 0.45]
up = [0.0, 0.0, 1.0]
fov_y = 37.0

[method]
name = "abuffer"
shape = "oriented"
"#;
