//! `tori`: three nested tori (Dobrev et al., Fig. 17), the inner ones seen through the outer ones.

use std::f64::consts::TAU;

use glam::DVec3;

use super::builder::{CloudBuilder, Rgb};
use super::random::{Random, unit_circle};
use super::{Error, Generated};
use pellucid_core::cloud::Cloud;

/// Name, radius of the tube, opacity, color. All share the center circle of radius 1 in the plane z = 0.
const TORI: [(&str, f64, f64, Rgb); 3] =
    [("inner", 0.15, 1.0, [204, 118, 36]), ("middle", 0.30, 0.5, [60, 150, 50]), ("outer", 0.45, 0.3, [50, 80, 170])];

/// Radius of a disc in spacings. Opacities add up where discs overlap. With this radius the weights exp(−2ρ²) of the
/// discs over a position sum to 1 on average, π·s²·(1 − e⁻²)/2 = 1, so that a surface is about as opaque as its cloud's
/// setting. No position is farther from a point than √2/2 spacings, so the surfaces are closed.
const RADIUS_PER_SPACING: f64 = 0.858;

pub(super) fn generate([points]: [f64; 1], seed: u64) -> Result<Generated, Error> {
    let mut random = Random::new(seed);
    let area: f64 = TORI.iter().map(|&(_, tube, ..)| TAU * TAU * tube).sum();
    let spacing = (area / points).sqrt();
    let mut scene_toml = String::from(HEADER);
    let mut clouds = Vec::with_capacity(TORI.len());
    for (name, tube, opacity, color) in TORI {
        let radius = (RADIUS_PER_SPACING * spacing) as f32;
        scene_toml += &format!("\n[[cloud]]\npath = \"{name}.ply\"\nopacity = {opacity:?}\nradius = {radius:?}\n");
        clouds.push((format!("{name}.ply"), torus(tube, spacing, color, &mut random)?));
    }
    Ok(Generated { clouds, scene_toml })
}

/// Rings around the axis, one spacing apart along the tube; points one spacing apart along each ring. So the points
/// are spread evenly over the area, without the gaps of independent random ones.
fn torus(tube: f64, spacing: f64, color: Rgb, random: &mut Random) -> Result<Cloud, Error> {
    let rings = (TAU * tube / spacing).round().max(3.0) as usize;
    let estimate = TAU * TAU * tube / (spacing * spacing);
    let mut builder = CloudBuilder::with_capacity((1.05 * estimate) as usize + rings)?;
    let start = random.unit();
    for ring in 0..rings {
        let turn = (start + ring as f64) / rings as f64;
        let around = (TAU * (1.0 + tube * unit_circle(turn).0) / spacing).round().max(3.0) as usize;
        let shift = random.unit();
        for step in 0..around {
            let (cos_v, sin_v) = unit_circle(turn);
            let (cos_u, sin_u) = unit_circle((shift + step as f64) / around as f64);
            let normal = DVec3::new(cos_v * cos_u, cos_v * sin_u, sin_v);
            builder.point(DVec3::new(cos_u, sin_u, 0.0) + tube * normal, color);
            builder.normal(normal);
        }
    }
    Ok(builder.finish())
}

const HEADER: &str = r#"# Three nested tori after Dobrev et al., Fig. 17.
[image]
size = [1024, 1024]
background = [1.0, 1.0, 1.0]

[camera]
eye = [0.0, -3.3, 3.3]
target = [0.0, -0.1, 0.0]
up = [0.0, 0.0, 1.0]
fov_y = 38.0

[shading]
model = "phong"
ambient = 0.3
diffuse = 0.7
specular = 0.2
shininess = 32.0

[method]
name = "abuffer"
shape = "oriented"
falloff = "gaussian"
"#;
