//! The built-in scenes: clouds generated from a name, parameters and a seed.
//!
//! The same name, parameters and seed give the same clouds on every machine: the generator is PCG-64 and the geometry
//! needs only operations that IEEE 754 defines to the last bit (sines come from `random::unit_circle`). Positions,
//! normals and radii are float32, colors lie on the 8-bit sRGB grid, so that a PLY file holds a scene without loss.

mod builder;
mod garden;
pub mod iso;
mod mosaic;
mod plane;
mod planes;
mod random;
mod sign;
mod spheres;
mod stack;
pub mod terrain;
mod tori;
mod volume;

use pellucid_core::cloud::Cloud;

/// Most points a built-in scene may ask for: 10 GB as [`Cloud`]s with color, normal and class.
const MAX_POINTS: f64 = 200e6;

/// A built-in scene: name, summary in one line, parameters.
pub struct Builtin {
    /// Name of the scene in `pellucid scene`.
    pub name: &'static str,
    /// A single line for `--list`.
    pub summary: &'static str,
    /// The parameters of `--set`.
    pub parameters: &'static [Parameter],
    generate: fn(&Given<'_>, u64) -> Result<Generated, Error>,
}

/// A number that shapes a built-in scene.
pub struct Parameter {
    /// Name of the key in `--set KEY=VALUE`.
    pub name: &'static str,
    /// The value without `--set`.
    pub default: f64,
    /// Smallest value allowed.
    pub min: f64,
    /// Largest value allowed.
    pub max: f64,
    /// `true` for a count, which has to be a whole number.
    pub integer: bool,
    /// A single line for `--list`.
    pub summary: &'static str,
}

const fn count(name: &'static str, default: f64, min: f64, max: f64, summary: &'static str) -> Parameter {
    Parameter { name, default, min, max, integer: true, summary }
}

const fn real(name: &'static str, default: f64, min: f64, max: f64, summary: &'static str) -> Parameter {
    Parameter { name, default, min, max, integer: false, summary }
}

/// Lists the built-in scenes: the module that makes one, which has its name, what it is, and its parameters.
macro_rules! builtins {
    ($($module:ident: $summary:literal; $($parameter:expr),+;)+) => {
        /// All built-in scenes; the first is the one rendered without input.
        pub const BUILTINS: &[Builtin] = &[$(Builtin {
            name: stringify!($module),
            summary: $summary,
            parameters: &[$($parameter),+],
            generate: |given, seed| $module::generate(given.values(&[$($parameter),+])?, seed),
        }),+];
    };
}

builtins! {
    garden: "a simulated scan of a furnished garden house among trees";
        count("points", 500_000.0, 1000.0, MAX_POINTS, "points of the scan, nearly");
    tori: "three nested tori, brown in green in blue, of opacity 1, 0.5 and 0.3";
        count("points", 600_000.0, 100.0, MAX_POINTS, "points of all three together");
    volume: "uniform random points in a cube, with a wanted mean number of layers per covered pixel";
        count("points", 200_000.0, 1.0, MAX_POINTS, "points in the cube"),
        real("layers", 32.0, 1.0, 100_000.0, "mean fragments of the pixels that hold any");
    stack: "parallel layers, each over the whole image: every pixel holds exactly as many fragments";
        count("layers", 64.0, 1.0, stack::MAX_LAYERS, "fragments in every pixel"),
        count("size", 256.0, 1.0, 16384.0, "width and height of the image"),
        real("opacity", 0.05, 0.0, 1.0, "opacity of a layer");
    mosaic: "parallel layers of discs of 9 pixels that tile the image: every pixel holds exactly as many fragments";
        count("layers", 16.0, 1.0, stack::MAX_LAYERS, "fragments in every pixel"),
        count("size", 256.0, 1.0, 16384.0, "width and height of the image"),
        real("opacity", 0.05, 0.0, 1.0, "opacity of a layer");
    plane: "uniform random points on a white square, parallel to the image or tilted";
        count("points", 1e6, 1.0, MAX_POINTS, "points on the square"),
        real("tilt", 0.0, -89.0, 89.0, "turn about the vertical, in degrees"),
        real("opacity", 0.5, 0.0, 1.0, "opacity of the plane");
    planes: "parallel planes of random points over the whole image, a cloud each: alpha blending is their exact picture";
        count("planes", 2.0, 1.0, 64.0, "number of planes"),
        count("points", 1e6, 1.0, MAX_POINTS, "points of each plane, 81% of them on the image"),
        count("size", 128.0, 1.0, 16384.0, "width and height of the image"),
        real("opacity", 0.5, 0.0, 1.0, "opacity of the nearest plane"),
        real("back", 0.7, 0.0, 1.0, "opacity of the farthest; those between in even steps");
    spheres: "one sphere, two that intersect, or a random soup; a point with a radius each, soft for soft methods";
        count("count", 2.0, 1.0, MAX_POINTS, "number of spheres; a soup from 3 on");
    sign: "lettering and a checker on a sign seen aslant, for methods of opaque points";
        count("points", 60_000.0, 100.0, MAX_POINTS, "points on the sign, give or take a row"),
        real("noise", 0.25, 0.0, 10.0, "standard deviation of depths, in distances between points");
    terrain: "an airborne scan of a river valley with a town, fields and forests";
        terrain::POINTS;
}

/// A generated scene: its clouds and the scene file that shows them.
#[derive(Debug, Clone, PartialEq)]
pub struct Generated {
    /// Each cloud with the file name (`….ply`) under which the scene file looks for it.
    pub clouds: Vec<(String, Cloud)>,
    /// The text of `scene.toml`.
    pub scene_toml: String,
}

impl Generated {
    /// A cloud by itself, before a camera on the z axis: what it is, and lines of the scene file, which are the keys of
    /// `[image]`, the eye's height, the camera's lens, and the other keys of the cloud.
    fn alone(name: &str, cloud: Cloud, [about, image, eye, lens, keys]: [&str; 5]) -> Self {
        let scene_toml = format!(
            r#"# {about}
[image]
{image}

[camera]
eye = [0.0, 0.0, {eye}]
target = [0.0, 0.0, 0.0]
up = [0.0, 1.0, 0.0]
{lens}

[[cloud]]
path = "{name}.ply"
{keys}

[method]
name = "abuffer"
"#
        );
        Self { clouds: vec![(format!("{name}.ply"), cloud)], scene_toml }
    }
}

/// Reason why a built-in scene could not be made.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
#[allow(missing_docs, reason = "the messages say what the fields are")]
pub enum Error {
    /// No scene has this name. `hint` is `, did you mean "…"?`, or nothing if no name is near.
    #[error("no built-in scene is called \"{name}\"{hint}; expected one of {known}")]
    UnknownScene { name: String, hint: String, known: String },
    /// The scene has no such parameter. `hint` is `, did you mean "…"?`, or nothing if no name is near.
    #[error("the scene \"{scene}\" has no parameter \"{name}\"{hint}; it has {known}")]
    UnknownParameter { scene: &'static str, name: String, hint: String, known: String },
    /// A value outside its range, NaN included.
    #[error("{scene}: {name} = {value} is out of range; it must lie from {min} to {max}")]
    OutOfRange { scene: &'static str, name: &'static str, value: f64, min: f64, max: f64 },
    /// A count with a fraction.
    #[error("{scene}: {name} = {value} is a count and must be a whole number")]
    NotInteger { scene: &'static str, name: &'static str, value: f64 },
    /// No radius gives the wanted mean number of layers with this many points: it is `least` at radius 0, and `most`
    /// where every point covers the whole image.
    #[error(
        "volume: {points} points cannot give layers = {layers}: a radius of 0 gives {least:.3} and one that fills the \
         image {most:.0}; change points or layers"
    )]
    OutOfReach { layers: f64, points: usize, least: f64, most: f64 },
    /// The volume has no surface at a value, the requested one or the only one in the volume. The least and the
    /// greatest value of the volume are NaN if it has none.
    #[error(
        "iso: no surface has the value {value}; the values of the volume range from {least} to {greatest}, and a surface \
         needs some above it and some below"
    )]
    NoSurface { value: f64, least: f64, greatest: f64 },
    /// More values than available colors.
    #[error("iso: {values} values, but at most {most} are allowed")]
    TooManySurfaces { values: usize, most: usize },
    /// Not enough memory for the points.
    #[error("{points} points need {bytes} bytes, more than can be allocated; ask for fewer points")]
    TooLarge { points: usize, bytes: usize },
}

/// Makes the built-in scene `name`.
///
/// `parameters` override the defaults of [`Builtin::parameters`]; of a name given twice the last value counts.
///
/// # Errors
/// An unknown scene or parameter, a value out of range or not whole, more points than fit the memory.
pub fn build(name: &str, parameters: &[(String, f64)], seed: u64) -> Result<Generated, Error> {
    let builtin = BUILTINS.iter().find(|b| b.name == name).ok_or_else(|| {
        let known = || BUILTINS.iter().map(|b| b.name).chain([iso::NAME]);
        Error::UnknownScene { name: name.to_owned(), hint: hint(name, known()), known: list(known()) }
    })?;
    (builtin.generate)(&Given { scene: builtin.name, values: parameters }, seed)
}

/// The parameters that are given for a scene, unchecked.
struct Given<'a> {
    scene: &'static str,
    values: &'a [(String, f64)],
}

impl Given<'_> {
    /// The values of all parameters that the scene has, in its order. Counts are whole numbers below 2⁵³.
    fn values<const N: usize>(&self, parameters: &[Parameter; N]) -> Result<[f64; N], Error> {
        let scene = self.scene;
        let mut values = parameters.each_ref().map(|p| p.default);
        for (name, value) in self.values {
            let known = || parameters.iter().map(|p| p.name);
            let Some((slot, p)) = values.iter_mut().zip(parameters).find(|(_, p)| p.name == name) else {
                let (hint, known) = (hint(name, known()), list(known()));
                return Err(Error::UnknownParameter { scene, name: name.clone(), hint, known });
            };
            if !(p.min..=p.max).contains(value) {
                return Err(Error::OutOfRange { scene, name: p.name, value: *value, min: p.min, max: p.max });
            }
            if p.integer && value.fract() != 0.0 {
                return Err(Error::NotInteger { scene, name: p.name, value: *value });
            }
            *slot = *value;
        }
        Ok(values)
    }
}

fn list(names: impl Iterator<Item = &'static str>) -> String {
    names.collect::<Vec<_>>().join(", ")
}

fn hint(name: &str, known: impl Iterator<Item = &'static str>) -> String {
    let similarity = |candidate: &str| strsim::normalized_damerau_levenshtein(name, candidate);
    let nearest = known.max_by(|a, b| similarity(a).total_cmp(&similarity(b)));
    // Half of the letters right: below that a suggestion only misleads.
    nearest.filter(|n| similarity(n) >= 0.5).map_or_else(String::new, |n| format!(", did you mean \"{n}\"?"))
}
