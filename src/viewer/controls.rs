//! Which control a key of the scene file gets, and the value that it has now.

use crate::scene::{
    BlendedSplats, Density, DiscShape, Falloff, Hybrid, ImageSpace, Interpolated, LongLists, MAX_K, Method, OneLayer,
    Peel, PeelLayers, Raster, ScreenSplats, Setting, SoftLayout, Spbr, SplatShape, Stochastic,
};

/// What changes a value.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Control {
    /// A slider from one number to another.
    Slider(f64, f64),
    /// A slider over whole numbers, by powers.
    Count(u32, u32),
    /// A check box.
    Flag,
    /// One of some words.
    Choice(&'static [&'static str]),
}

/// The control of a method's key, and its value; `None` for keys of the file alone and of other methods.
pub fn control(method: &Method, key: &str) -> Option<(Control, Setting)> {
    of_numbers(method, key).or_else(|| of_words(method, key))
}

fn of_numbers(method: &Method, key: &str) -> Option<(Control, Setting)> {
    use Control::{Count, Flag, Slider};
    let (number, count) = (|x: f32| Setting::Number(rounded(x)), Setting::Integer);
    let soft = method.soft();
    Some(match (key, method) {
        ("threshold", _) => (Slider(0.0, 1.0), number(method.threshold()?)),
        ("softness", Method::OneLayer(OneLayer { softness, .. })) => (Slider(0.0, 1.0), number(*softness)),
        ("softness", _) => match soft?.density {
            Density::Softness(softness) => (Slider(0.0, 1.0), number(softness)),
            Density::Lambda(_) => return None,
        },
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
    let discs = method.discs().or(match method {
        Method::Auto(discs) => Some(discs),
        _ => None,
    });
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

/// What a key is called beside its control.
pub fn label(key: &str) -> String {
    key.replace('_', " ")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Document, METHODS, Overrides, method_keys};

    /// Keys that only the scene file has: each stands for another key, or is a number or a word, or absent.
    const FILE_ONLY: &[&str] = &["lambda", "modulation", "shells", "min_layer_distance", "brightness"];

    fn document(method: &str) -> Document {
        let text = format!("[[cloud]]\npath = 'a.ply'\n[method]\nname = '{method}'\n");
        Document::from_toml(&text, "s.toml".as_ref(), &Overrides::default()).unwrap()
    }

    /// A key that a method gets can't be forgotten here, and a control shows the value that is in force.
    #[test]
    fn every_key_of_every_method_has_a_control_with_its_value() {
        for name in METHODS {
            let document = document(name);
            let method = document.scene().unwrap().method;
            for key in method_keys(name) {
                match control(&method, key) {
                    None => assert!(FILE_ONLY.contains(&key), "{name}: {key} has no control"),
                    Some((control, value)) => {
                        assert!(!FILE_ONLY.contains(&key), "{name}: {key}");
                        let scene = document.clone().set(&format!("method.{key}"), value.clone());
                        assert_eq!(scene.unwrap().method, method, "{name}: {key} = {value:?}");
                        moves(&document, key, control);
                    }
                }
            }
        }
    }

    /// Both ends of a control are values that a scene takes, and the other end shows.
    fn moves(document: &Document, key: &str, shape: Control) {
        let ends = match shape {
            Control::Slider(from, to) => vec![Setting::Number(from), Setting::Number(to)],
            Control::Count(from, to) => vec![Setting::Integer(from), Setting::Integer(to)],
            Control::Flag => vec![Setting::Flag(false), Setting::Flag(true)],
            Control::Choice(words) => words.iter().map(|word| Setting::Word((*word).to_owned())).collect(),
        };
        for end in ends {
            let scene = document.clone().set(&format!("method.{key}"), end.clone()).unwrap();
            assert_eq!(control(&scene.method, key), Some((shape, end)), "{key}");
        }
    }

    #[test]
    fn numbers_are_as_short_as_in_the_file() {
        assert_eq!(rounded(0.17), 0.17);
        assert_eq!(rounded(f32::MAX) as f32, f32::MAX);
    }
}
