//! The control for a key of the scene file, the key's current value, and the other changes that a change of it
//! requires.

mod beside;
mod classes;
mod clips;
mod clouds;
mod opacities;

pub use beside::{light_changes, method_changes, rival};
pub use classes::{ClassKey, ClassLook, class_changes, class_look, class_resets};
pub use clips::{AXES, NewClip, clip_changes, decimals, new_clip, short_number, without_clip};
pub use clouds::{cloud, opacity};
pub use opacities::{Ratios, mean_opacity, opacity_keys};

use pellucid_engine::methods::soft::SoftModel;
use pellucid_scene::{
    Density, Key, Light, Method, Order, Range, Setting, Shadows, Slider, Soft, ValueKind, Word, rounded,
};

/// The smallest opacity of a slider above 0.
pub const FAINTEST: f64 = 1e-3;

/// The kind of control for a value.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Control {
    /// A slider from one number to another.
    Slider(f64, f64),
    /// A slider by powers of ten, from one number, which may be 0, to another.
    Powers(f64, f64),
    /// A slider of opacities: 0 at its left end, else by powers of ten from [`FAINTEST`] to 1.
    Opacity,
    /// A slider over integers, logarithmic for wide ranges.
    Count(u32, u32),
    /// A choice between whole numbers.
    OneOf(&'static [u32]),
    /// A check box.
    Flag,
    /// A choice between words.
    Choice(&'static [Word]),
    /// A color, linear.
    Color,
}

/// The presence of a key's value.
#[derive(Debug, Clone, PartialEq)]
pub enum Presence {
    /// Always.
    Always,
    /// A key that can be switched off; `without` describes the effect in a few words.
    Optional {
        /// True if the key has a value.
        on: bool,
        /// Effect of switching it off.
        without: String,
    },
    /// A key that excludes another one.
    Rival {
        /// True if it was chosen.
        on: bool,
    },
}

/// A key's control.
#[derive(Debug, Clone, PartialEq)]
pub struct KeyControl {
    /// The control that changes it.
    pub control: Control,
    /// The value in force; of a key without one, what it begins with.
    pub value: Setting,
    /// The presence of its value.
    pub presence: Presence,
    /// The description of the key.
    pub about: &'static str,
}

/// Properties of the shown points that determine the ranges of controls.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ControlExtent {
    /// The diagonal of the points' box, in world units; above 0.
    pub diagonal: f64,
    /// The median radius of the soft points, in world units; 0 if there are none.
    pub median_radius: f32,
}

impl Default for ControlExtent {
    fn default() -> Self {
        Self { diagonal: 1.0, median_radius: 0.0 }
    }
}

/// The control of a key; `None` for values without a control here, such as those of cameras and lights.
pub fn entry(key: &Key, extent: ControlExtent) -> Option<KeyControl> {
    let control = control(key.kind, key.slider, extent)?;
    let start = match (control, key.slider) {
        (Control::Color, _) => Setting::Numbers(vec![1.0; 3]),
        (Control::Count(..), _) => Setting::Integer(key.start as u32),
        (Control::OneOf(numbers), _) => Setting::Integer(numbers.first().copied().unwrap_or_default()),
        (Control::Choice(words), _) => {
            Setting::Word(words.first().map_or_else(String::new, |word| word.name.to_owned()))
        }
        (_, Slider::Lengths(..)) => Setting::Number(significant(key.start * extent.diagonal)),
        _ => Setting::Number(key.start),
    };
    // A word in place of such a value is what a switch leaves.
    let word = match (key.kind, &key.value) {
        (ValueKind::WordOr(word, _), Some(Setting::Word(own))) if own == word => Some(word),
        _ => None,
    };
    let given = key.value.clone().filter(|_| word.is_none());
    let on = given.is_some();
    let presence = match (word.unwrap_or(key.without), key.rival) {
        ("", _) => Presence::Always,
        (_, Some(_)) => Presence::Rival { on },
        (without, None) => Presence::Optional { on, without: without.to_owned() },
    };
    Some(KeyControl { control, value: given.unwrap_or(start), presence, about: key.about })
}

fn control(kind: ValueKind, slider: Slider, extent: ControlExtent) -> Option<Control> {
    let length = |share: f64| significant(share * extent.diagonal);
    Some(match (kind, slider) {
        (ValueKind::WordOr(_, other), slider) => return control(*other, slider, extent),
        (ValueKind::Number(_), Slider::Linear(from, to)) => Control::Slider(from, to),
        (ValueKind::Number(_), Slider::Powers(from, to)) => Control::Powers(from, to),
        (ValueKind::Number(_), Slider::Lengths(from, to)) => Control::Powers(length(from), length(to)),
        (ValueKind::Number(_), Slider::Opacity) => Control::Opacity,
        (ValueKind::Number(range), Slider::Whole) if range == Range::UNIT => Control::Slider(0.0, 1.0),
        (ValueKind::Integer(..), Slider::Count(from, to)) | (ValueKind::Integer(from, to), Slider::Whole) => {
            Control::Count(from, to)
        }
        (ValueKind::OneOf(numbers), _) => Control::OneOf(numbers),
        (ValueKind::Flag, _) => Control::Flag,
        (ValueKind::Words(words) | ValueKind::WordsOr(words, _), _) => Control::Choice(words),
        (ValueKind::Color, _) => Control::Color,
        _ => return None,
    })
}

/// The control of a method's key; `None` for keys of other methods.
pub fn method(method: &Method, key: &str, extent: ControlExtent) -> Option<KeyControl> {
    let mut key = method.key(key)?;
    match (key.name, method.soft()) {
        ("softness" | "lambda", Some(soft)) => Some(density(method, soft, &key, extent)),
        ("modulation", Some(soft)) => {
            // Half-way, so that both have room to move.
            key.start = 0.5 + 0.5 * f64::from(soft.threshold);
            entry(&key, extent)
        }
        (name, _) => {
            let mut entry = shortened(&key, extent)?;
            if let Presence::Optional { without, .. } = &mut entry.presence {
                match (name, method) {
                    ("order", _) => order(method).clone_into(without),
                    ("bias", Method::Moments(moments)) => *without = format!("{:e}", rounded(moments.bias())),
                    _ => {}
                }
            }
            Some(entry)
        }
    }
}

/// The word for the order of Gaussians in force.
fn order(method: &Method) -> &'static str {
    match method.order() {
        Order::Center => "center",
        Order::Distance => "distance",
        Order::Pixel => "pixel",
    }
}

/// The control of a key with a default that depends on the scene, which it shows.
fn shortened(key: &Key, extent: ControlExtent) -> Option<KeyControl> {
    let mut entry = entry(key, extent)?;
    if let (Presence::Optional { without, .. }, Slider::Lengths(..)) = (&mut entry.presence, key.slider) {
        *without = format!("{}%: {}", significant(100.0 * key.start), significant(key.start * extent.diagonal));
    }
    Some(entry)
}

/// The control of a key of `[shadows]`; `None` for `method`, which is the table's switch.
pub fn shadows(shadows: &Shadows, light: Light, key: &str, extent: ControlExtent) -> Option<KeyControl> {
    let mut key = find(shadows.keys(), key)?;
    if let ("light_radius", Light::Direction(_)) = (key.name, light) {
        // Degrees, and no length.
        key.slider = Slider::Linear(0.0, 45.0);
    }
    shortened(&key, extent)
}

/// The key of this name.
pub fn find(keys: Vec<Key>, name: &str) -> Option<Key> {
    keys.into_iter().find(|key| key.name == name)
}

/// `softness` or `lambda`: the one that was not chosen begins where the picture stays the same.
fn density(method: &Method, soft: &Soft, key: &Key, extent: ControlExtent) -> KeyControl {
    let radius = if extent.median_radius > 0.0 { extent.median_radius } else { (0.003 * extent.diagonal) as f32 };
    let model = SoftModel::new(method, soft, radius);
    let rival = |control, value, on| {
        let (value, presence) = (Setting::Number(value), Presence::Rival { on });
        KeyControl { control, value, presence, about: key.about }
    };
    if key.name == "softness" {
        let on = matches!(soft.density, Density::Softness(_));
        let value = if on { rounded(model.peak) } else { thousandths(model.peak.into()) };
        return rival(Control::Slider(0.0, 1.0), value, on);
    }
    let most = match method {
        Method::SoftExpress(_) => 1.0,
        // A sphere of median radius that lets 10⁻⁴ of the light through.
        _ => {
            let dense = Soft { density: Density::Softness(0.9999), ..*soft };
            significant(SoftModel::new(method, &dense, radius).lambda.into())
        }
    };
    let (on, value) = match soft.density {
        Density::Lambda(lambda) => (true, rounded(lambda)),
        Density::Softness(_) => (false, significant(model.lambda.into())),
    };
    rival(Control::Powers(0.0, most), value, on)
}

/// A number to three decimals.
pub fn thousandths(x: f64) -> f64 {
    (x * 1e3).round() / 1e3
}

/// A number to four significant digits.
pub fn significant(x: f64) -> f64 {
    format!("{x:.3e}").parse().unwrap_or(x)
}

/// The label of a key beside its control.
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
