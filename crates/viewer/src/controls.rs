//! Which control a key of the scene file gets, the value that it has now, and what a change of it brings along.

mod beside;
mod optional;
#[cfg(test)]
mod tests;

pub use beside::{changes, light_changes, method_changes};
pub use optional::{cloud, shading, shadows};

use pellucid_engine::methods::soft::SoftModel;
use pellucid_engine::scene::{
    BlendedSplats, Brightness, Density, DiscShape, Falloff, Hybrid, ImageSpace, Interpolated, LongLists, MAX_K, Method,
    OneLayer, Peel, PeelLayers, Raster, ScreenSplats, Setting, Shells, Soft, SoftLayout, Spbr, SpbrSimplified,
    SplatShape, Stochastic,
};

/// What changes a value.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Control {
    /// A slider from one number to another.
    Slider(f64, f64),
    /// A slider by powers of ten, from one number, which may be 0, to another.
    Powers(f64, f64),
    /// A slider over whole numbers, by powers if there are many.
    Count(u32, u32),
    /// A check box.
    Flag,
    /// One of some words.
    Choice(&'static [&'static str]),
    /// A color, linear.
    Color,
}

/// Whether a key has a value.
#[derive(Debug, Clone, PartialEq)]
pub enum Presence {
    /// Always.
    Always,
    /// If it is switched on; what goes without it, in a few words.
    Optional { on: bool, without: String },
    /// If it was chosen, and not the other key in whose place it stands.
    Rival { on: bool },
}

/// A key's control.
#[derive(Debug, Clone, PartialEq)]
pub struct Entry {
    /// What changes it.
    pub control: Control,
    /// The value in force; of a key without one, what it begins with.
    pub value: Setting,
    /// Whether it has one.
    pub presence: Presence,
}

/// What ranges of controls depend on, of the points that are shown.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Extent {
    /// Of the points' box, in world units; above 0.
    pub diagonal: f64,
    /// Of the soft points, in world units; 0 if there are none.
    pub median_radius: f32,
}

impl Default for Extent {
    fn default() -> Self {
        Self { diagonal: 1.0, median_radius: 0.0 }
    }
}

impl Entry {
    fn always((control, value): (Control, Setting)) -> Self {
        Self { control, value, presence: Presence::Always }
    }

    fn optional<T>(
        control: Control,
        value: Option<T>,
        start: T,
        setting: impl Fn(T) -> Setting,
        without: &str,
    ) -> Self {
        let presence = Presence::Optional { on: value.is_some(), without: without.to_owned() };
        Self { control, value: setting(value.unwrap_or(start)), presence }
    }
}

/// The control of a method's key; `None` for keys of other methods.
pub fn control(method: &Method, key: &str, extent: Extent) -> Option<Entry> {
    let always = of_numbers(method, key).or_else(|| of_words(method, key)).map(Entry::always);
    always.or_else(|| of_alternatives(method, key, extent))
}

/// Keys that are left out as often as not, or stand for one another.
fn of_alternatives(method: &Method, key: &str, extent: Extent) -> Option<Entry> {
    let number = |x: f32| Setting::Number(rounded(x));
    let factor = |p| Entry::optional(Control::Powers(0.1, 100.0), p, 1.0, number, "auto");
    match (key, method) {
        ("softness" | "lambda", _) => Some(density(method, method.soft()?, key, extent)),
        ("modulation", _) => {
            let Soft { threshold, modulation, .. } = method.soft()?;
            // Half-way, so that both have room to move.
            let start = 0.5 + 0.5 * *threshold;
            Some(Entry::optional(Control::Slider(0.0, 1.0), *modulation, start, number, "off"))
        }
        ("shells", _) => {
            let fixed = match method.soft()?.shells {
                Shells::Fixed(shells) => Some(shells),
                Shells::Adaptive => None,
            };
            let control = Control::Count(1, pellucid_engine::scene::MAX_SHELLS);
            Some(Entry::optional(control, fixed, 8, Setting::Integer, "adaptive"))
        }
        ("min_layer_distance", _) => Some(optional::layer_distance(method.filters()?.min_layer_distance, extent)),
        ("brightness", Method::SpbrSimplified(SpbrSimplified { brightness, .. })) => Some(factor(match brightness {
            Brightness::Factor(p) => Some(*p),
            Brightness::Auto => None,
        })),
        _ => None,
    }
}

/// `softness` or `lambda`: the one that was not chosen begins where the picture stays the same.
fn density(method: &Method, soft: &Soft, key: &str, extent: Extent) -> Entry {
    let radius = if extent.median_radius > 0.0 { extent.median_radius } else { (0.003 * extent.diagonal) as f32 };
    let model = SoftModel::new(method, soft, radius);
    if key == "softness" {
        let on = matches!(soft.density, Density::Softness(_));
        let value = if on { rounded(model.peak) } else { thousandths(model.peak.into()) };
        return Entry {
            control: Control::Slider(0.0, 1.0),
            value: Setting::Number(value),
            presence: Presence::Rival { on },
        };
    }
    let on = matches!(soft.density, Density::Lambda(_));
    let most = match method {
        Method::SoftExpress(_) => 1.0,
        // A sphere of median radius that lets 10⁻⁴ of the light through.
        _ => {
            let dense = Soft { density: Density::Softness(0.9999), ..*soft };
            significant(SoftModel::new(method, &dense, radius).lambda.into())
        }
    };
    let value = match soft.density {
        Density::Lambda(lambda) => rounded(lambda),
        Density::Softness(_) => significant(model.lambda.into()),
    };
    Entry { control: Control::Powers(0.0, most), value: Setting::Number(value), presence: Presence::Rival { on } }
}

fn of_numbers(method: &Method, key: &str) -> Option<(Control, Setting)> {
    use Control::{Count, Flag, Slider};
    let (number, count) = (|x: f32| Setting::Number(rounded(x)), Setting::Integer);
    let soft = method.soft();
    Some(match (key, method) {
        ("threshold", _) => (Slider(0.0, 1.0), number(method.threshold()?)),
        ("softness", Method::OneLayer(OneLayer { softness, .. })) => (Slider(0.0, 1.0), number(*softness)),
        ("pixels_per_shell", _) => (Slider(1.0, 16.0), number(soft?.pixels_per_shell)),
        ("size", _) => (Slider(0.0, 4.0), number(splats(method)?.size)),
        ("max_pixel_radius", _) => (Slider(0.0, 100.0), number(splats(method)?.max_pixel_radius)),
        (
            "blend_depth",
            Method::Hqs(BlendedSplats { blend_depth, .. }) | Method::Splats(BlendedSplats { blend_depth, .. }),
        ) => (Slider(0.0, 4.0), number(*blend_depth)),
        ("samples", Method::Stochastic(Stochastic { samples, .. })) => (Count(1, 1024), count(*samples)),
        ("alpha_correction", Method::Stochastic(Stochastic { alpha_correction, .. })) => {
            (Flag, Setting::Flag(*alpha_correction))
        }
        ("k", Method::Hybrid(Hybrid { k, .. })) => (Count(1, MAX_K), count(*k)),
        ("layers", Method::Peel(Peel { layers, .. })) => (Count(0, 256), count(*layers)),
        ("layers", Method::PeelLayers(PeelLayers { layers, .. })) => (Count(1, 32), count(*layers)),
        ("ensembles", _) => (Count(1, 1000), count(method.ensembles()?)),
        ("cos_theta", Method::Spbr(Spbr { cos_theta, .. })) => (Flag, Setting::Flag(*cos_theta)),
        ("brighten", Method::Spbr(Spbr { brighten, .. })) => (Flag, Setting::Flag(*brighten)),
        _ => return of_filters(method.filters()?, key),
    })
}

fn of_filters(filters: &ImageSpace, key: &str) -> Option<(Control, Setting)> {
    use Control::{Count, Flag, Slider};
    Some(match key {
        "fill" => (Count(0, 16), Setting::Integer(filters.fill)),
        "occlusion" => (Count(0, 16), Setting::Integer(filters.occlusion)),
        "smooth" => (Count(0, 16), Setting::Integer(filters.smooth)),
        "antialias" => (Flag, Setting::Flag(filters.antialias)),
        "antialias_threshold" => (Slider(0.0, 1.0), Setting::Number(rounded(filters.antialias_threshold))),
        "cull" => (Flag, Setting::Flag(filters.cull)),
        _ => return None,
    })
}

fn of_words(method: &Method, key: &str) -> Option<(Control, Setting)> {
    let word = |words: &'static [&'static str], at: usize| {
        Some((Control::Choice(words), Setting::Word((*words.get(at)?).to_owned())))
    };
    let discs = method.discs();
    let outline = match method {
        Method::Paraboloid(Interpolated { shape, .. }) | Method::Cone(Interpolated { shape, .. }) => Some(shape),
        Method::Hqs(BlendedSplats { shape, .. }) => Some(shape),
        _ => None,
    };
    let drawn = discs.map(|discs| discs.raster).or(method.nearest_splats().map(|splats| splats.raster));
    match (key, discs, outline) {
        ("shape", Some(discs), _) => word(&["flat", "oriented"], usize::from(discs.shape == DiscShape::Oriented)),
        ("shape", _, Some(shape)) => word(&["circle", "square"], usize::from(*shape == SplatShape::Square)),
        ("falloff", Some(discs), _) => word(&["flat", "gaussian"], usize::from(discs.falloff == Falloff::Gaussian)),
        ("long_lists", ..) => {
            word(&["merge", "in-place"], usize::from(method.lists()?.long_lists == LongLists::InPlace))
        }
        ("layout", ..) => word(&["precise", "paper"], usize::from(method.soft()?.layout == SoftLayout::Paper)),
        ("raster", ..) => word(
            &["auto", "compute", "hardware"],
            [Raster::Auto, Raster::Compute, Raster::Hardware].iter().position(|raster| Some(*raster) == drawn)?,
        ),
        _ => None,
    }
}

fn splats(method: &Method) -> Option<&ScreenSplats> {
    match method {
        Method::Hqs(BlendedSplats { splats, .. }) | Method::Splats(BlendedSplats { splats, .. }) => Some(splats),
        _ => method.nearest_splats(),
    }
}

/// The shortest number that is this one in float32: 0.17 and not 0.17000000178813934.
pub fn rounded(x: f32) -> f64 {
    x.to_string().parse().unwrap_or(f64::from(x))
}

/// A number to three decimals.
pub fn thousandths(x: f64) -> f64 {
    (x * 1e3).round() / 1e3
}

/// A number to four significant digits.
pub fn significant(x: f64) -> f64 {
    format!("{x:.3e}").parse().unwrap_or(x)
}

/// What a key is called beside its control.
pub fn label(key: &str) -> String {
    match key {
        "threshold" => "threshold t".to_owned(),
        "lambda" => "lambda λ".to_owned(),
        "ensembles" => "ensembles L".to_owned(),
        "min_layer_distance" => "layer distance".to_owned(),
        "antialias_threshold" => "edge share".to_owned(),
        key => key.replace('_', " "),
    }
}
