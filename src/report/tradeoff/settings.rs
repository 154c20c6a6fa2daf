//! The methods of one image formation with their settings: what is compared on a scene.

use super::Skipped;
use crate::methods::abuffer::LOCAL_LENGTH;
use crate::points::Points;
use crate::scene::{
    self, DiscShape, Discs, Falloff, Hybrid, LongLists, Method, Peel, Raster, ScreenSplats, Stochastic,
};

/// The steps of every ladder, ascending.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Ladders {
    /// `samples` of `stochastic`.
    pub samples: &'static [u32],
    /// `k` of `hybrid`.
    pub k: &'static [u32],
    /// `layers` of `peel`; all of them come on top.
    pub layers: &'static [u32],
}

impl Ladders {
    /// What a report shows.
    pub const FULL: Self =
        Self { samples: &[1, 4, 16, 64, 256, 1024], k: &[1, 2, 4, 8, 16, 32], layers: &[1, 2, 4, 8, 16, 32, 64] };
    /// For a first look and for CI.
    pub const QUICK: Self = Self { samples: &[1, 8, 64], k: &[1, 8], layers: &[1, 8] };
    /// What is chosen from.
    pub const FINE: Self = Self { samples: &[1, 2, 4, 8, 16, 32, 64, 128, 256, 512, 1024, 2048, 4096], ..Self::FULL };
}

/// What decides which settings make sense.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Occasion {
    /// The image formation.
    pub discs: Discs,
    /// Whether every fragment is opaque.
    pub opaque: bool,
    /// Whether discs have a depth for each pixel.
    pub oriented: bool,
    /// Longest list of fragments.
    pub max_list: u32,
}

impl Occasion {
    /// Of a scene's points.
    pub fn new(points: &Points, discs: Discs, max_list: u32) -> Self {
        let opaque = discs.falloff == Falloff::Flat && points.opacities.iter().all(|opacity| *opacity >= 1.0);
        Self { discs, opaque, oriented: discs.shape == DiscShape::Oriented && points.normals.is_some(), max_list }
    }
}

/// One method with one setting.
#[derive(Debug, Clone, PartialEq)]
pub struct Setting {
    /// What is rendered.
    pub method: Method,
    /// As options of the command line would give it, beside `--method`; empty for the defaults.
    pub text: String,
    /// What is turned, and how far.
    pub step: Option<(&'static str, u32)>,
    /// What settings of one ladder share; of others the name.
    pub series: String,
    /// What the time grows with along the series.
    pub effort: Option<f64>,
}

impl Setting {
    fn single(method: Method, text: &str) -> Self {
        let series = format!("{} {text}", method.name());
        Self { method, text: text.to_owned(), step: None, series, effort: None }
    }

    fn step(method: Method, (key, value): (&'static str, u32), rest: &str) -> Self {
        let text = format!("method.{key}={value} {rest}").trim_end().to_owned();
        let series = format!("{} {rest}", method.name());
        Self { method, text, step: Some((key, value)), series, effort: Some(value.into()) }
    }

    /// Method and setting: no two have the same.
    pub fn key(&self) -> String {
        format!("{} {}", self.method.name(), self.text).trim_end().to_owned()
    }

    /// The same as the name of a file, without an extension.
    pub fn stem(&self) -> String {
        self.key().replace("method.", "").replace([' ', '=', '_'], "-")
    }

    /// Whether the image depends on the seed.
    pub fn is_stochastic(&self) -> bool {
        matches!(self.method, Method::Stochastic(_))
    }

    /// Whether the image is exact but for rounding.
    pub fn is_exact(&self, occasion: &Occasion) -> bool {
        match self.method {
            Method::ABuffer(_) | Method::LinkedList(_) | Method::Circles(_) => true,
            Method::Sorted(_) => !occasion.oriented,
            Method::Peel(peel) => peel.layers == 0,
            _ => false,
        }
    }

    /// The setting of a ladder.
    pub fn skipped(&self, reason: impl Into<String>) -> Skipped {
        Skipped { method: self.method.name().to_owned(), setting: self.text.clone(), reason: reason.into() }
    }
}

/// The discs that a method draws, if it is one of those whose images are comparable; methods that draw others are an error.
///
/// # Errors
/// A method of opaque points: no other one has its image formation.
pub fn formation(method: &Method) -> Result<Discs, scene::Error> {
    let discs = match method {
        Method::Auto(discs) => *discs,
        method => *method.discs().ok_or_else(|| {
            let name = method.name();
            scene::Error::Usage(format!(
                "method {name} draws opaque points in a way of its own, so that there is nothing to compare it with; \
                 --method auto compares the methods of transparent discs"
            ))
        })?,
    };
    // How the same image is made is what the settings differ in.
    Ok(Discs { raster: Raster::default(), long_lists: LongLists::default(), ..discs })
}

/// All settings that apply, exact methods first, each ladder ascending; and those that don't, with the reason.
pub fn settings(occasion: &Occasion, ladders: &Ladders) -> (Vec<Setting>, Vec<Skipped>) {
    let (mut settings, mut skipped) = (Vec::new(), Vec::new());
    exact(occasion, &mut settings, &mut skipped);
    peel(occasion, ladders, &mut settings, &mut skipped);
    approximate(occasion, ladders, &mut settings, &mut skipped);
    for opaque in [Method::Points, Method::Squares(ScreenSplats::default())] {
        let reason = "draws opaque points of another shape: its image is not meant to be the same";
        skipped.push(Setting::single(opaque, "").skipped(reason));
    }
    (settings, skipped)
}

fn exact(occasion: &Occasion, settings: &mut Vec<Setting>, skipped: &mut Vec<Skipped>) {
    let Occasion { discs, max_list, .. } = *occasion;
    let hardware = Discs { raster: Raster::Hardware, ..discs };
    let in_place = Discs { long_lists: LongLists::InPlace, ..discs };
    settings.push(Setting::single(Method::ABuffer(discs), ""));
    settings.push(Setting::single(Method::ABuffer(hardware), "method.raster=hardware"));
    let in_place = Setting::single(Method::ABuffer(in_place), "method.long_lists=in-place");
    if max_list > LOCAL_LENGTH {
        settings.push(in_place);
    } else {
        skipped.push(in_place.skipped(format!("the longest list has {max_list} fragments: none is long")));
    }
    settings.push(Setting::single(Method::LinkedList(discs), ""));
    settings.push(Setting::single(Method::Sorted(discs), ""));
    // Without the clamp of opaque splats the image is that of the A-buffer.
    let unclamped = ScreenSplats { max_pixel_radius: f32::MAX, ..ScreenSplats::default() };
    let circles = Setting::single(Method::Circles(unclamped), &format!("method.max_pixel_radius={:e}", f32::MAX));
    if !occasion.opaque {
        skipped.push(circles.skipped("draws opaque discs, and not all of this scene are"));
    } else if occasion.oriented {
        skipped.push(circles.skipped("draws discs that face the screen, and those of this scene don't"));
    } else {
        settings.push(circles);
    }
}

/// Adds a ladder; steps beyond the longest list change nothing any more.
fn climb(
    occasion: &Occasion,
    ladder: impl Iterator<Item = Setting>,
    settings: &mut Vec<Setting>,
    skipped: &mut Vec<Skipped>,
) {
    let mut reached = false;
    for setting in ladder {
        if reached {
            let longest = occasion.max_list;
            skipped.push(setting.skipped(format!("the longest list has {longest} fragments: the step before has all")));
        } else {
            reached = setting.step.is_some_and(|(_, value)| value >= occasion.max_list);
            settings.push(setting);
        }
    }
}

fn peel(occasion: &Occasion, ladders: &Ladders, settings: &mut Vec<Setting>, skipped: &mut Vec<Skipped>) {
    let discs = occasion.discs;
    let step = |layers: &u32| Setting::step(Method::Peel(Peel { discs, layers: *layers }), ("layers", *layers), "");
    climb(occasion, ladders.layers.iter().map(step), settings, skipped);
    let all = Setting::single(Method::Peel(Peel { discs, layers: 0 }), "");
    settings.push(Setting { effort: Some(occasion.max_list.into()), ..all });
}

fn approximate(occasion: &Occasion, ladders: &Ladders, settings: &mut Vec<Setting>, skipped: &mut Vec<Skipped>) {
    let discs = occasion.discs;
    let hybrid = |k: &u32| Setting::step(Method::Hybrid(Hybrid { discs, k: *k }), ("k", *k), "");
    climb(occasion, ladders.k.iter().map(hybrid), settings, skipped);
    // The rasteriser takes samples in a way of its own.
    let ways = [
        (Raster::Auto, true, ""),
        (Raster::Auto, false, "method.alpha_correction=false"),
        (Raster::Hardware, true, "method.raster=hardware"),
    ];
    for (raster, alpha_correction, rest) in ways {
        let stochastic = |samples: &u32| {
            let discs = Discs { raster, ..discs };
            let method = Method::Stochastic(Stochastic { discs, samples: *samples, alpha_correction });
            // Samples are taken by fours.
            Setting { effort: Some(samples.div_ceil(4).into()), ..Setting::step(method, ("samples", *samples), rest) }
        };
        settings.extend(ladders.samples.iter().map(stochastic));
    }
    for method in [Method::Weighted(discs), Method::Average(discs), Method::Unsorted(discs)] {
        settings.push(Setting::single(method, ""));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn occasion(max_list: u32) -> Occasion {
        Occasion { discs: Discs::default(), opaque: false, oriented: false, max_list }
    }

    fn keys(occasion: &Occasion) -> Vec<String> {
        settings(occasion, &Ladders::FULL).0.iter().map(Setting::key).collect()
    }

    #[test]
    fn keys_and_files_differ() {
        for name in [Setting::key, Setting::stem] {
            let mut names: Vec<String> = settings(&occasion(5000), &Ladders::FINE).0.iter().map(name).collect();
            let count = names.len();
            names.sort();
            names.dedup();
            assert_eq!(names.len(), count);
        }
        let (all, _) = settings(&occasion(5000), &Ladders::FULL);
        assert!(all.iter().any(|s| s.stem() == "stochastic-samples-64-alpha-correction-false"), "{all:#?}");
    }

    #[test]
    fn ladders_end_at_the_longest_list() {
        let keys = keys(&occasion(5));
        let of = |name: &str| keys.iter().filter(|key| key.split(' ').next() == Some(name)).count();
        // 1, 2, 4, 8; and all layers.
        assert_eq!((of("hybrid"), of("peel"), of("stochastic")), (4, 5, 18), "{keys:?}");
        let (_, skipped) = settings(&occasion(5), &Ladders::FULL);
        let of = |name: &str| skipped.iter().filter(|skipped| skipped.method == name).count();
        assert_eq!((of("hybrid"), of("peel"), of("abuffer"), of("circles")), (2, 3, 1, 1), "{skipped:?}");
    }

    #[test]
    fn what_applies_depends_on_the_scene() {
        assert!(!keys(&occasion(256)).contains(&"abuffer method.long_lists=in-place".to_owned()));
        assert!(keys(&occasion(257)).contains(&"abuffer method.long_lists=in-place".to_owned()));
        let is_circles = |key: &String| key.starts_with("circles");
        assert!(!keys(&occasion(1)).iter().any(is_circles));
        assert!(keys(&Occasion { opaque: true, ..occasion(1) }).iter().any(is_circles));
        assert!(!keys(&Occasion { opaque: true, oriented: true, ..occasion(1) }).iter().any(is_circles));
    }

    #[test]
    fn only_methods_of_discs_are_compared() {
        let gaussian = Discs { falloff: Falloff::Gaussian, raster: Raster::Hardware, ..Discs::default() };
        let plain = Discs { raster: Raster::Auto, ..gaussian };
        assert_eq!(formation(&Method::Auto(gaussian)).unwrap(), plain);
        assert_eq!(formation(&Method::Peel(Peel { discs: gaussian, layers: 3 })).unwrap(), plain);
        assert!(formation(&Method::Points).is_err());
    }
}
