//! `iso`: surfaces of equal value in a volume, as points (Dobrev et al., Figs. 18 and 19). The volume is a file's, or
//! that of a hydrogen orbital.

mod field;
mod orbital;
mod surface;

use glam::DVec3;

use super::builder::{CloudBuilder, Rgb};
use super::random::Random;
use super::{Error, Generated, Given, MAX_POINTS, Parameter, count};
use field::Field;
use pellucid_io::volume::Volume;
use surface::Isosurface;

/// Name of the generator in `pellucid scene`.
pub const NAME: &str = "iso";
/// A single line for `--list`.
pub const SUMMARY: &str = "nested surfaces of equal value in a volume (--volume FILE, or a hydrogen orbital), at --values or at some chosen ones";
/// The parameters of `--set`.
pub const PARAMETERS: &[Parameter; 2] = &[
    count("points", 535_000.0, 100.0, MAX_POINTS, "points of all surfaces together"),
    count("surfaces", 3.0, 1.0, MAX_SURFACES as f64, "surfaces, if no values are given"),
];

/// Surfaces at most.
pub const MAX_SURFACES: usize = 8;

/// The outermost chosen surface encloses the volume divided by the square of the first number, the innermost one by the
/// square of the second. Those between use divisors in between, for example a ninth, 1/49, 1/121.
const DIVISORS: [f64; 2] = [3.0, 11.0];
/// The share of a single one.
const ENCLOSED_BY_ONE: f64 = 0.08;

/// Colors from the innermost surface to the outermost; those of three are as in Fig. 19's neighbor, Fig. 17.
const COLORS: [Rgb; MAX_SURFACES] = [
    [204, 118, 36],
    [60, 150, 50],
    [50, 80, 170],
    [190, 60, 60],
    [120, 70, 160],
    [40, 150, 160],
    [200, 180, 60],
    [150, 150, 150],
];

/// Opacity of a single surface (Fig. 18); of the outermost, those between and the innermost (Fig. 19).
const ALONE: f64 = 0.7;
const NESTED: [f64; 3] = [0.5, 0.3, 1.0];

/// Layers that are seen: a single surface is crossed four times, nested ones six times (Figs. 18 and 19).
const LAYERS: [u32; 2] = [4, 6];

/// Returns the volume where none is given: the density of the electron in a hydrogen atom's state 3d (m = 0), 64³
/// numbers from 0 to 1 within 20 Bohr radii of the nucleus.
pub fn built_in() -> Volume {
    orbital::orbital()
}

/// Makes the scene from a volume, whose longest side becomes 2 world units around the origin. `values`: where the field
/// has surfaces; none: chosen so that they lie within each other.
///
/// # Errors
/// A parameter that is unknown or out of range, a value without a surface, too many values, a volume without different
/// values, too little memory.
pub fn build_iso(volume: &Volume, values: &[f64], parameters: &[(String, f64)], seed: u64) -> Result<Generated, Error> {
    let [points, chosen] = Given { scene: NAME, values: parameters }.values(PARAMETERS)?;
    let field = Field::new(volume);
    let surfaces = surfaces(&field, values, chosen as usize)?;
    let total: f64 = surfaces.iter().map(|(_, surface)| surface.area()).sum();
    let sides = volume.dims.map(|count| (count - 1) as f64);
    let longest = sides.iter().copied().fold(1.0, f64::max);
    let (scale, center) = (2.0 / longest, 0.5 * DVec3::from_array(sides));
    // World units between points, if they stood on a grid.
    let spacing = scale * (total / points).sqrt();
    let mut scene_toml = header(surfaces.len(), spacing);
    let (mut clouds, mut random, mut given, mut area) = (Vec::new(), Random::new(seed), 0, 0.0);
    for (place, (value, surface)) in surfaces.iter().enumerate() {
        area += surface.area();
        // All of them together are as many as asked for.
        let end = (points * (area / total)).round() as usize;
        let count = end.saturating_sub(given);
        given = end;
        let color = COLORS[surfaces.len() - 1 - place];
        let mut builder = CloudBuilder::with_capacity(count)?;
        for _ in 0..count {
            let point = surface.point(&mut random);
            builder.point(scale * (point - center), color);
            builder.normal(field.normal(point));
        }
        let name = format!("surface-{}.ply", place + 1);
        let opacity = opacity(place, surfaces.len());
        scene_toml += &format!("\n# Value {value}.\n[[cloud]]\npath = \"{name}\"\nopacity = {opacity:?}\n");
        clouds.push((name, builder.finish()));
    }
    Ok(Generated { clouds, scene_toml })
}

/// The surfaces and their values, the outermost first.
fn surfaces<'a>(field: &'a Field<'a>, values: &[f64], chosen: usize) -> Result<Vec<(f64, Isosurface<'a>)>, Error> {
    let [least, greatest] = field.extremes().unwrap_or([f64::NAN; 2]);
    if values.len() > MAX_SURFACES {
        return Err(Error::TooManySurfaces { values: values.len(), most: MAX_SURFACES });
    }
    let mut values = if values.is_empty() {
        shares(chosen).iter().filter_map(|share| field.enclosing(*share)).collect()
    } else {
        values.to_vec()
    };
    values.sort_by(f64::total_cmp);
    values.dedup();
    if field.rises {
        values.reverse();
    }
    if values.is_empty() {
        return Err(Error::NoSurface { value: least, least, greatest });
    }
    let surface = |value: f64| {
        let surface = Isosurface::new(field, value);
        if surface.area() > 0.0 { Ok((value, surface)) } else { Err(Error::NoSurface { value, least, greatest }) }
    };
    values.into_iter().map(surface).collect()
}

/// The shares of the volume that the surfaces enclose.
fn shares(count: usize) -> Vec<f64> {
    if count == 1 {
        return vec![ENCLOSED_BY_ONE];
    }
    let [outer, inner] = DIVISORS;
    (0..count).map(|place| (outer + (inner - outer) * place as f64 / (count - 1) as f64).powi(-2)).collect()
}

fn opacity(place: usize, count: usize) -> f64 {
    let [outer, between, inner] = NESTED;
    match (place, count) {
        (_, 1) => ALONE,
        (0, _) => outer,
        (place, count) if place + 1 == count => inner,
        _ => between,
    }
}

/// The scene file without its clouds. Points within a pixel or two of each other belong to one layer.
fn header(surfaces: usize, spacing: f64) -> String {
    let layers = LAYERS[usize::from(surfaces > 1)];
    let min_layer_distance = (LAYER_SPACINGS * spacing) as f32;
    format!(
        r#"# Surfaces of equal value in a volume after Dobrev et al., Figs. 18 and 19.
[image]
size = [640, 640]
background = [1.0, 1.0, 1.0]

[camera]
eye = [2.1, 1.6, 3.15]
target = [0.0, 0.0, 0.0]
up = [0.0, 1.0, 0.0]
fov_y = 30.0

[shading]
model = "phong"
ambient = 0.3
diffuse = 0.7
specular = 0.2
shininess = 32.0

[method]
name = "peel-layers"
layers = {layers}
fill = 3
occlusion = 3
min_layer_distance = {min_layer_distance:?}
"#
    )
}

/// Distance between layers, in point spacings: a surface seen at a grazing angle is one layer.
const LAYER_SPACINGS: f64 = 6.0;
