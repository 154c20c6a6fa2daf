//! The methods of one image formation with their settings, which are compared on a scene.

mod applicable;
mod ladder;
mod surfaces;

pub use applicable::settings;
pub use surfaces::Surfaces;

use serde::{Deserialize, Serialize};

use pellucid_core::points::Points;
use pellucid_engine::plan;
use pellucid_scene::{self as scene, Density, Discs, Falloff, Ladder, Method, Soft, Spbr};

/// An image that several methods form in different ways.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Formation {
    /// Transparent discs.
    Discs(Discs),
    /// Spheres of soft points before solid ones.
    Soft {
        /// Threshold, softness (never a factor λ, whose meaning differs between the models) and modulation.
        soft: Soft,
        /// True if the scene gives the factor λ, from which the softness was derived.
        from_lambda: bool,
    },
    /// Points of surfaces with an opacity, shuffled into ensembles. Their number is not the scene's but a setting, and
    /// nothing is brightened.
    Ensembles(Spbr),
    /// Opaque points of surfaces. Each method draws an image of its own; the surface is the reference for all.
    Surfaces(Surfaces),
}

impl Formation {
    /// The method that forms the image exactly, except for rounding. Ensembles are exact for no finite number, so the
    /// method itself is returned. For surfaces it is the method that draws them best when given many samples per pixel.
    pub fn exact(&self) -> Method {
        match *self {
            Self::Discs(discs) => Method::ABuffer(discs),
            Self::Soft { soft, .. } => Method::SoftBase(soft),
            Self::Ensembles(spbr) => Method::Spbr(spbr),
            Self::Surfaces(surfaces) => surfaces.reference(),
        }
    }
}

/// Number of values of each key that are compared.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Detail {
    /// The settings of a report.
    Full,
    /// Fewer settings, for a first look and for CI.
    Quick,
    /// The settings that a choice considers.
    Fine,
}

/// The steps of every ladder, ascending.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ladders {
    /// Number of values of the methods' keys.
    pub detail: Detail,
    /// `size` of opaque splats.
    pub sizes: &'static [f64],
    /// `fill` and `occlusion` of `image-space`, both alike.
    pub iterations: &'static [u32],
    /// Opaque points are drawn completely and thinned to every n-th point; the first entry is 1.
    pub thinning: &'static [u32],
    /// `spacing_px` of `[detail]`, the coarsest first.
    pub spacings: &'static [f32],
    /// `max_points` of `[detail]` as one of so many of all points, the fewest first.
    pub one_of: &'static [u32],
    /// `samples` of `[shadows]`.
    pub shadow_samples: &'static [u32],
}

impl Ladders {
    /// The settings of a report.
    pub const FULL: Self = Self {
        detail: Detail::Full,
        sizes: &[0.0, 0.5, 1.0, 1.5, 2.0, 3.0, 4.0],
        iterations: &[0, 1, 2, 4, 8],
        thinning: &[1, 4, 16],
        spacings: &[16.0, 8.0, 4.0, 2.0, 1.0, 0.5],
        one_of: &[64, 16, 4],
        shadow_samples: &[1, 5, 10, 30],
    };
    /// The settings for a first look and for CI.
    pub const QUICK: Self = Self {
        detail: Detail::Quick,
        sizes: &[0.0, 1.0, 2.0],
        iterations: &[0, 1, 4],
        thinning: &[1, 16],
        spacings: &[8.0, 2.0],
        one_of: &[16],
        shadow_samples: &[1, 5],
    };
    /// The settings that a choice considers.
    pub const FINE: Self = Self { detail: Detail::Fine, ..Self::FULL };

    /// The values of a key that are compared.
    pub fn steps(&self, ladder: &Ladder) -> &'static [u32] {
        match self.detail {
            Detail::Full => ladder.full,
            Detail::Quick => ladder.quick,
            Detail::Fine => ladder.fine,
        }
    }
}

/// The properties of a scene that decide which settings apply.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Occasion {
    /// The image formation.
    pub formation: Formation,
    /// True if every fragment is opaque, for discs.
    pub opaque: bool,
    /// True if splats have a depth for each pixel.
    pub oriented: bool,
    /// Longest list of fragments.
    pub max_list: u32,
    /// Points of the scene.
    pub points: u64,
}

impl Occasion {
    /// Properties of a scene's points.
    pub fn new(points: &Points, formation: Formation, max_list: u32) -> Self {
        let (opaque, oriented) = match formation {
            Formation::Discs(Discs { falloff, .. }) => (
                falloff == Falloff::Flat && points.opacities.iter().all(|opacity| *opacity >= 1.0),
                plan::may_cross(&formation.exact(), points),
            ),
            Formation::Soft { .. } | Formation::Ensembles(_) | Formation::Surfaces(_) => (false, false),
        };
        Self { formation, opaque, oriented, max_list, points: points.count() }
    }
}

/// A setting that was not measured, and why.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Skipped {
    /// The method's name.
    pub method: String,
    /// The setting's text, as options of the command line.
    pub setting: String,
    /// Why.
    pub reason: String,
    /// True if it would have taken too long; another limit of time may let it in.
    pub for_time: bool,
}

/// A method with one setting.
#[derive(Debug, Clone, PartialEq)]
pub struct Setting {
    /// The method to render.
    pub method: Method,
    /// Written as options of the command line, in addition to `--method`; empty for the defaults.
    pub text: String,
    /// The key that varies, and its value.
    pub step: Option<(&'static str, f64)>,
    /// A name shared by the settings of one ladder; without a ladder the method's name.
    pub series: String,
    /// The quantity that the time grows with along the series.
    pub effort: Option<f64>,
    /// Thinning of opaque points: every n-th is drawn; 1 means all.
    pub thinning: u32,
    /// Level of detail: leaves points out by how fine they are.
    pub detail: scene::Detail,
    /// Samples of a pixel's area; `None` for those of the scene.
    pub samples: Option<u32>,
}

impl Setting {
    pub(super) fn single(method: Method, text: &str) -> Self {
        let series = format!("{} {text}", method.name());
        let detail = scene::Detail::default();
        Self { method, text: text.to_owned(), step: None, series, effort: None, thinning: 1, detail, samples: None }
    }

    /// The varied key may stand for several keys, as in `fill+occlusion`.
    pub(super) fn step(method: Method, (key, value): (&'static str, impl Into<f64>), rest: &str) -> Self {
        let value = value.into();
        let turned: String = key.split('+').map(|key| format!("method.{key}={value} ")).collect();
        let text = format!("{turned}{rest}").trim_end().to_owned();
        Self { text, step: Some((key, value)), effort: Some(value), ..Self::single(method, rest) }
    }

    /// Points at most so many pixels apart, which take the longer the nearer they are.
    pub(super) fn spaced(method: Method, spacing_px: f32, rest: &str) -> Self {
        let detail = scene::Detail { spacing_px, ..Default::default() };
        let effort = 1.0 / f64::from(spacing_px * spacing_px);
        Self::level(method, ("detail.spacing_px", spacing_px.into()), effort, detail, rest)
    }

    /// Returns the setting that draws at most so many points.
    pub(super) fn limited(method: Method, max_points: u32, rest: &str) -> Self {
        let detail = scene::Detail { max_points: Some(max_points), ..Default::default() };
        Self::level(method, ("detail.max_points", max_points.into()), max_points.into(), detail, rest)
    }

    fn level(method: Method, step: (&'static str, f64), effort: f64, detail: scene::Detail, rest: &str) -> Self {
        let (key, value) = step;
        let text = format!("{key}={value} {rest}").trim_end().to_owned();
        let series = format!("{} {key} {rest}", method.name());
        Self { text, step: Some(step), series, effort: Some(effort), detail, ..Self::single(method, rest) }
    }

    /// Method and setting: no two have the same.
    pub fn key(&self) -> String {
        format!("{} {}", self.method.name(), self.text).trim_end().to_owned()
    }

    /// Method and setting as the name of a file, without an extension.
    pub fn stem(&self) -> String {
        self.key().replace("method.", "").replace([' ', '=', '_'], "-")
    }

    /// Returns the setting with so many samples of a pixel's area. They are the ladder of a setting that is alone in
    /// its series; others climb theirs with each number of them.
    fn sampled(&self, samples: u32, is_alone: bool) -> Self {
        let text = format!("{} {SAMPLES}={samples}", self.text).trim_start().to_owned();
        let count = f64::from(samples);
        let own = Self { text, samples: Some(samples), ..self.clone() };
        if is_alone {
            return Self { step: Some((SAMPLES, count)), effort: Some(count), ..own };
        }
        let effort = self.effort.map(|effort| count * effort);
        Self { series: format!("{} {SAMPLES}={samples}", self.series), effort, ..own }
    }

    /// True if another setting differs in its samples of a pixel's area alone.
    pub fn is_like(&self, other: &Self) -> bool {
        (self.method, self.detail, self.thinning) == (other.method, other.detail, other.thinning)
    }

    /// True if the image depends on the seed.
    pub fn is_stochastic(&self) -> bool {
        self.method.is_sampled()
    }

    /// True if the image is exact except for rounding.
    pub fn is_exact(&self, occasion: &Occasion) -> bool {
        let draws_this = matches!(self.method, Method::Circles(_)) || self.method.is_exact(occasion.oriented);
        draws_this && self.detail.is_whole()
    }

    /// The setting of a ladder.
    pub fn skipped(&self, reason: impl Into<String>) -> Skipped {
        let (method, setting) = (self.method.name().to_owned(), self.text.clone());
        Skipped { method, setting, reason: reason.into(), for_time: false }
    }

    /// The setting of a ladder, of which there is no time to measure it.
    pub fn too_slow(&self, reason: String) -> Skipped {
        Skipped { for_time: true, ..self.skipped(reason) }
    }
}

/// Key of a pixel's samples.
const SAMPLES: &str = "image.samples";

/// Returns each setting with each of these numbers of samples of a pixel's area.
pub fn with_samples(settings: &[Setting], counts: &[u32]) -> Vec<Setting> {
    let in_series = |setting: &Setting| settings.iter().filter(|other| other.series == setting.series).count();
    let all = settings.iter().flat_map(|setting| {
        let is_alone = setting.step.is_none() && in_series(setting) == 1;
        counts.iter().map(move |count| setting.sampled(*count, is_alone))
    });
    all.collect()
}

/// The image that a method forms, if other methods form it, too. A factor λ is converted to the softness it gives this
/// method and these points.
///
/// # Errors
/// A method of opaque points, or of one transparent layer: no other method shares its image formation.
pub fn formation(method: &Method, points: &Points) -> Result<Formation, scene::Error> {
    let from_lambda = method.soft().is_some_and(|soft| matches!(soft.density, Density::Lambda(_)));
    match plan::exact(method, points) {
        Some(Method::ABuffer(discs)) => Ok(Formation::Discs(discs)),
        Some(Method::SoftBase(soft)) => Ok(Formation::Soft { soft, from_lambda }),
        Some(Method::Spbr(spbr)) => Ok(Formation::Ensembles(spbr)),
        _ => Err(scene::Error::Usage(format!(
            "no other method draws the same image as {}, so there is nothing to compare; --method auto compares the methods \
             of transparent discs, --method circles those of opaque points, --method soft-base those of soft spheres, --method spbr numbers of ensembles",
            method.name()
        ))),
    }
}

/// Returns the image formation like [`formation`], but [`Formation::Surfaces`] for methods of opaque points, whose
/// images differ but show the same surfaces.
///
/// # Errors
/// A method of one transparent layer, or of layers of points.
pub fn compared(method: &Method, points: &Points) -> Result<Formation, scene::Error> {
    Surfaces::for_method(method, points)
        .map_or_else(|| formation(method, points), |surfaces| Ok(Formation::Surfaces(surfaces)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use pellucid_scene::MethodChoice;
    use pellucid_scene::{BlendedSplats, OneLayer, Peel, Raster, Shells, SoftLayout};

    fn occasion(max_list: u32) -> Occasion {
        let formation = Formation::Discs(Discs::default());
        Occasion { formation, opaque: false, oriented: false, max_list, points: 1000 }
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
    fn samples_are_the_ladder_of_settings_without_one() {
        let (plain, _) = settings(&occasion(5), &Ladders::QUICK);
        let all = with_samples(&plain, &[1, 4]);
        assert_eq!(all.len(), 2 * plain.len());
        let of = |key: &str| all.iter().find(|setting| setting.key() == key).unwrap_or_else(|| panic!("{key}"));
        let [one, four] = ["weighted image.samples=1", "weighted image.samples=4"].map(of);
        assert_eq!((one.series == four.series, four.step, four.effort), (true, Some((SAMPLES, 4.0)), Some(4.0)));
        assert_eq!((one.samples, four.samples, one.is_like(four)), (Some(1), Some(4), true));
        // Layers stay the ladder of peel, once for each number of samples; the last rung is all layers.
        let layers: Vec<&Setting> = all.iter().filter(|setting| setting.method.name() == "peel").collect();
        for count in [1, 4] {
            let rungs: Vec<&&Setting> = layers.iter().filter(|setting| setting.samples == Some(count)).collect();
            assert!(rungs.len() > 1 && rungs.iter().all(|rung| rung.series == rungs[0].series), "{rungs:#?}");
            assert!(rungs.iter().all(|rung| rung.step.is_none_or(|(key, _)| key == "layers")), "{rungs:#?}");
            // Of one layer as many images as samples.
            assert_eq!(rungs[0].effort, Some(f64::from(count)));
        }
        let mut keys: Vec<String> = all.iter().map(Setting::key).collect();
        keys.sort();
        keys.dedup();
        assert_eq!(keys.len(), all.len());
        assert!(plain.iter().all(|setting| setting.samples.is_none()));
    }

    #[test]
    fn ladders_end_at_the_longest_list() {
        let keys = keys(&occasion(5));
        let count_of = |name: &str| keys.iter().filter(|key| key.split(' ').next() == Some(name)).count();
        // 1, 2, 4, 8, with two tails; and all layers.
        assert_eq!((count_of("hybrid"), count_of("peel"), count_of("stochastic")), (8, 5, 18), "{keys:?}");
        let (_, skipped) = settings(&occasion(5), &Ladders::FULL);
        let count_of = |name: &str| skipped.iter().filter(|skipped| skipped.method == name).count();
        assert_eq!(
            (count_of("hybrid"), count_of("peel"), count_of("abuffer"), count_of("circles")),
            (4, 3, 1, 1),
            "{skipped:?}"
        );
    }

    #[test]
    fn settings_apply_by_the_scene() {
        assert!(!keys(&occasion(256)).contains(&"abuffer method.long_lists=in-place".to_owned()));
        assert!(keys(&occasion(257)).contains(&"abuffer method.long_lists=in-place".to_owned()));
        let is_circles = |key: &String| key.starts_with("circles");
        assert!(!keys(&occasion(1)).iter().any(is_circles));
        assert!(keys(&Occasion { opaque: true, ..occasion(1) }).iter().any(is_circles));
        assert!(!keys(&Occasion { opaque: true, oriented: true, ..occasion(1) }).iter().any(is_circles));
    }

    #[test]
    fn levels_of_detail_are_ladders_of_large_clouds() {
        let large = Occasion { points: 1 << 20, ..occasion(5) };
        let (all, _) = settings(&large, &Ladders::FULL);
        let levels: Vec<&Setting> = all.iter().filter(|setting| !setting.detail.is_whole()).collect();
        // Of two methods, six distances and three numbers.
        assert_eq!(levels.len(), 2 * (6 + 3));
        assert!(levels.iter().all(|setting| !setting.is_exact(&large)));
        let keys: Vec<String> = levels.iter().map(|setting| setting.key()).collect();
        assert_eq!(keys[0], "abuffer detail.spacing_px=16");
        assert_eq!(keys[5], "abuffer detail.spacing_px=0.5");
        // 2^20 over 64, 16 and 4.
        assert_eq!(keys[6..9], ["16384", "65536", "262144"].map(|n| format!("abuffer detail.max_points={n}")));
        for pair in levels.windows(2).filter(|pair| pair[0].series == pair[1].series) {
            assert!(pair[0].effort < pair[1].effort, "{pair:?}");
        }
        let mut names = keys.clone();
        names.sort();
        names.dedup();
        assert_eq!(names.len(), keys.len());
        let (few, _) = settings(&occasion(5), &Ladders::FULL);
        assert!(few.iter().all(|setting| setting.detail.is_whole()));
        let ensembles = Occasion { formation: Formation::Ensembles(Spbr::default()), ..large };
        assert!(settings(&ensembles, &Ladders::FULL).0.iter().all(|setting| setting.detail.is_whole()));
        let surfaces = Surfaces::for_method(&Method::Points, &Points::default()).unwrap();
        let surfaces = Occasion { formation: Formation::Surfaces(surfaces), ..large };
        let (all, _) = settings(&surfaces, &Ladders::QUICK);
        let keys: Vec<String> = all.iter().filter(|s| !s.detail.is_whole()).map(Setting::key).collect();
        assert_eq!(
            keys,
            [
                "circles detail.spacing_px=8 method.size=1",
                "circles detail.spacing_px=2 method.size=1",
                "circles detail.max_points=65536 method.size=1"
            ]
        );
    }

    #[test]
    fn methods_of_one_image_formation_are_compared() {
        let gaussian = Discs { falloff: Falloff::Gaussian, raster: Raster::Hardware, ..Discs::default() };
        let plain = Formation::Discs(Discs { raster: Raster::Auto, ..gaussian });
        let formation_of = |method: Method| formation(&method, &Points::default());
        assert_eq!(formation_of(MethodChoice::Auto(gaussian).representative()).unwrap(), plain);
        assert_eq!(formation_of(Method::Peel(Peel { discs: gaussian, layers: 3 })).unwrap(), plain);
        let own = [
            Method::Points,
            Method::OneLayer(OneLayer::default()),
            Method::Hqs(BlendedSplats::default()),
            Method::Splats(BlendedSplats::default()),
        ];
        assert!(own.into_iter().all(|method| formation_of(method).is_err()));
        let own = Soft { layout: SoftLayout::Paper, shells: Shells::Fixed(3), equalize: false, ..Soft::default() };
        let soft = Soft { threshold: 0.25, ..own };
        let same = Soft { threshold: 0.25, ..Soft::default() };
        for method in [Method::SoftBase(soft), Method::SoftConcentric(soft), Method::SoftExpress(soft)] {
            assert_eq!(formation_of(method).unwrap(), Formation::Soft { soft: same, from_lambda: false });
        }
    }

    #[test]
    fn ensembles_are_a_ladder_of_their_own() {
        let scene = Spbr { ensembles: 7, cos_theta: false, brighten: true };
        let formation = formation(&Method::Spbr(scene), &Points::default()).unwrap();
        assert_eq!(formation, Formation::Ensembles(Spbr { ensembles: 100, cos_theta: false, brighten: false }));
        let occasion = Occasion { formation, ..occasion(9) };
        let (settings, skipped) = settings(&occasion, &Ladders::QUICK);
        let keys: Vec<String> = settings.iter().map(Setting::key).collect();
        assert_eq!(keys, ["spbr method.ensembles=1", "spbr method.ensembles=10", "spbr method.ensembles=100"]);
        assert!(settings.iter().all(|setting| setting.is_stochastic() && !setting.is_exact(&occasion)));
        assert!(settings.iter().all(|s| matches!(s.method, Method::Spbr(Spbr { cos_theta: false, .. }))));
        let names: Vec<&str> = skipped.iter().map(|skipped| skipped.method.as_str()).collect();
        assert_eq!(names[0], "spbr-simplified");
        assert!(["abuffer", "soft-base"].iter().all(|other| names.contains(other)), "{names:?}");
        assert!(super::formation(&Method::SpbrSimplified(Default::default()), &Points::default()).is_err());
    }

    #[test]
    fn a_factor_becomes_a_softness() {
        // Median radius of the soft ones: 2.
        let points = Points {
            positions: vec![glam::DVec3::ZERO; 3],
            radii: vec![2.0, 2.0, 50.0],
            fields: vec![1.0, 1.0, 0.0],
            ..Points::default()
        };
        let soft = Soft { density: Density::Lambda(0.25), ..Soft::default() };
        let softness = |method: Method| match formation(&method, &points).unwrap() {
            Formation::Soft { soft: Soft { density: Density::Softness(peak), .. }, from_lambda: true } => peak,
            other => panic!("{other:?}"),
        };
        // Optical depths r² λ and 2 r λ are 1 both.
        let one = 1.0 - (-1f32).exp();
        assert!((softness(Method::SoftBase(soft)) - one).abs() < 1e-6);
        assert!((softness(Method::SoftConcentric(soft)) - one).abs() < 1e-6);
        assert_eq!(softness(Method::SoftExpress(soft)), 0.25);
    }

    #[test]
    fn every_method_is_compared_or_skipped_for_a_reason() {
        let soft = Formation::Soft { soft: Soft::default(), from_lambda: false };
        let surfaces = Surfaces::for_method(&Method::Points, &Points::default()).unwrap();
        let formations =
            [occasion(9).formation, soft, Formation::Ensembles(Spbr::default()), Formation::Surfaces(surfaces)];
        for formation in formations {
            let (settings, skipped) = settings(&Occasion { formation, ..occasion(9) }, &Ladders::QUICK);
            for method in Method::all().iter().map(Method::name) {
                let is_compared = settings.iter().any(|setting| setting.method.name() == method);
                let is_skipped = skipped.iter().any(|skipped| skipped.method == method && !skipped.reason.is_empty());
                assert!(is_compared || is_skipped, "{method}: {formation:?}");
            }
        }
    }

    #[test]
    fn soft_spheres_have_three_models() {
        let settings_for = |density, from_lambda| {
            let formation = Formation::Soft { soft: Soft { density, ..Soft::default() }, from_lambda };
            settings(&Occasion { formation, ..occasion(9) }, &Ladders::QUICK)
        };
        let (given, skipped) = settings_for(Density::Softness(0.5), false);
        let keys: Vec<String> = given.iter().map(Setting::key).collect();
        let expected = [
            "soft-base",
            "soft-base method.layout=paper",
            "soft-concentric method.shells=1",
            "soft-concentric method.shells=4",
            "soft-concentric method.shells=adaptive",
            "soft-concentric method.shells=1 method.equalize=false",
            "soft-concentric method.shells=4 method.equalize=false",
            "soft-concentric method.shells=adaptive method.equalize=false",
            "soft-express",
        ];
        assert_eq!(keys, expected);
        let exact: Vec<bool> = given.iter().map(|setting| setting.is_exact(&occasion(9))).collect();
        assert_eq!(exact, [true, false, false, false, false, false, false, false, false]);
        assert!(skipped.iter().all(|skipped| skipped.reason.contains("another")), "{skipped:?}");
        // The rows show the converted density rather than the scene's own form.
        let (converted, _) = settings_for(Density::Softness(0.25), true);
        assert!(converted.iter().all(|setting| setting.text.ends_with("method.softness=0.25")), "{converted:#?}");
    }
}
