//! The methods of one image formation with their settings: what is compared on a scene.

use super::Skipped;
pub use super::surfaces::Surfaces;
use super::surfaces::ladder;
use pellucid_engine::methods::abuffer::LOCAL_LENGTH;
use pellucid_engine::methods::soft::SoftModel;
use pellucid_engine::passes::project::Parts;
use pellucid_engine::points::Points;
use pellucid_engine::scene::{
    self, BlendedSplats, Density, DiscShape, Discs, Falloff, Hybrid, Interpolated, LongLists, Method, OneLayer, Peel,
    Raster, ScreenSplats, Shells, Soft, SoftLayout, Spbr, Stochastic,
};

/// What several methods draw alike, each in its way.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Formation {
    /// Transparent discs.
    Discs(Discs),
    /// Spheres of soft points before solid ones.
    Soft {
        /// Threshold, softness (never a factor λ, whose meaning differs between the models) and modulation.
        soft: Soft,
        /// Whether the scene gives a factor instead, from which the softness follows.
        from_lambda: bool,
    },
    /// Points of surfaces with an opacity, dealt to ensembles. Their number is not the scene's but a setting, and nothing is
    /// brightened.
    Ensembles(Spbr),
    /// Opaque points of surfaces. Each method draws an image of its own; what they are held against is the surface.
    Surfaces(Surfaces),
}

impl Formation {
    /// The method that draws it exactly, but for rounding. No number of ensembles does: the method itself. Of surfaces the one
    /// that draws them best, if there are many samples in a pixel.
    pub fn exact(&self) -> Method {
        match *self {
            Self::Discs(discs) => Method::ABuffer(discs),
            Self::Soft { soft, .. } => Method::SoftBase(soft),
            Self::Ensembles(spbr) => Method::Spbr(spbr),
            Self::Surfaces(surfaces) => surfaces.reference(),
        }
    }
}

/// The steps of every ladder, ascending.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ladders {
    /// `samples` of `stochastic`.
    pub samples: &'static [u32],
    /// `k` of `hybrid`.
    pub k: &'static [u32],
    /// `layers` of `peel`; all of them come on top.
    pub layers: &'static [u32],
    /// `shells` of `soft-concentric`; adaptive ones come on top.
    pub shells: &'static [u32],
    /// `ensembles` of `spbr`.
    pub ensembles: &'static [u32],
    /// `size` of opaque splats.
    pub sizes: &'static [f64],
    /// `fill` and `occlusion` of `image-space`, both alike.
    pub iterations: &'static [u32],
    /// Opaque points are drawn as they are and with one point of so many; the first is 1.
    pub thinning: &'static [u32],
    /// `samples` of `[shadows]`.
    pub shadow_samples: &'static [u32],
}

impl Ladders {
    /// What a report shows.
    pub const FULL: Self = Self {
        samples: &[1, 4, 16, 64, 256, 1024],
        k: &[1, 2, 4, 8, 16, 32],
        layers: &[1, 2, 4, 8, 16, 32, 64],
        shells: &[1, 2, 4, 8],
        ensembles: &[1, 3, 10, 30, 100, 300, 1000],
        sizes: &[0.0, 0.5, 1.0, 1.5, 2.0, 3.0, 4.0],
        iterations: &[0, 1, 2, 4, 8],
        thinning: &[1, 4, 16],
        shadow_samples: &[1, 5, 10, 30],
    };
    /// For a first look and for CI.
    pub const QUICK: Self = Self {
        samples: &[1, 8, 64],
        k: &[1, 8],
        layers: &[1, 8],
        shells: &[1, 4],
        ensembles: &[1, 10, 100],
        sizes: &[0.0, 1.0, 2.0],
        iterations: &[0, 1, 4],
        thinning: &[1, 16],
        shadow_samples: &[1, 5],
    };
    /// What is chosen from.
    pub const FINE: Self = Self {
        samples: &[1, 2, 4, 8, 16, 32, 64, 128, 256, 512, 1024, 2048, 4096],
        ensembles: &[1, 2, 4, 8, 16, 32, 64, 128, 256, 512, 1024],
        ..Self::FULL
    };
}

/// What decides which settings make sense.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Occasion {
    /// The image formation.
    pub formation: Formation,
    /// Of discs: whether every fragment is opaque.
    pub opaque: bool,
    /// Whether discs have a depth for each pixel.
    pub oriented: bool,
    /// Longest list of fragments.
    pub max_list: u32,
}

impl Occasion {
    /// Of a scene's points.
    pub fn new(points: &Points, formation: Formation, max_list: u32) -> Self {
        let (opaque, oriented) = match formation {
            Formation::Discs(Discs { falloff, shape, .. }) => (
                falloff == Falloff::Flat && points.opacities.iter().all(|opacity| *opacity >= 1.0),
                shape == DiscShape::Oriented && points.normals.is_some(),
            ),
            Formation::Soft { .. } | Formation::Ensembles(_) | Formation::Surfaces(_) => (false, false),
        };
        Self { formation, opaque, oriented, max_list }
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
    pub step: Option<(&'static str, f64)>,
    /// What settings of one ladder share; of others the name.
    pub series: String,
    /// What the time grows with along the series.
    pub effort: Option<f64>,
    /// One point of so many is drawn, of opaque ones; 1: all.
    pub thinning: u32,
}

impl Setting {
    pub(super) fn single(method: Method, text: &str) -> Self {
        let series = format!("{} {text}", method.name());
        Self { method, text: text.to_owned(), step: None, series, effort: None, thinning: 1 }
    }

    /// What is turned may be several keys, as in `fill+occlusion`.
    pub(super) fn step(method: Method, (key, value): (&'static str, impl Into<f64>), rest: &str) -> Self {
        let value = value.into();
        let turned: String = key.split('+').map(|key| format!("method.{key}={value} ")).collect();
        let text = format!("{turned}{rest}").trim_end().to_owned();
        let series = format!("{} {rest}", method.name());
        Self { method, text, step: Some((key, value)), series, effort: Some(value), thinning: 1 }
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
        matches!(self.method, Method::Stochastic(_) | Method::Spbr(_))
    }

    /// Whether the image is exact but for rounding.
    pub fn is_exact(&self, occasion: &Occasion) -> bool {
        match self.method {
            Method::ABuffer(_) | Method::LinkedList(_) | Method::Circles(_) => true,
            Method::SoftBase(soft) => soft.layout == SoftLayout::Precise,
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

/// What a method draws, if others draw it too. A factor λ becomes the softness that it means for the method and these
/// points.
///
/// # Errors
/// A method of opaque points, or of one transparent layer: no other one has its image formation.
pub fn formation(method: &Method, points: &Points) -> Result<Formation, scene::Error> {
    if let Some(soft) = method.soft() {
        let from_lambda = matches!(soft.density, Density::Lambda(_));
        let model = SoftModel::new(method, soft, Parts::of(points, soft.threshold).median_radius);
        // How the same image is made is what the settings differ in; `pixels_per_shell` is the scene's.
        let (shells, layout) = (Shells::default(), SoftLayout::default());
        return Ok(Formation::Soft {
            soft: Soft { density: Density::Softness(model.peak), shells, layout, ..*soft },
            from_lambda,
        });
    }
    let discs = match method {
        Method::Spbr(spbr) => {
            return Ok(Formation::Ensembles(Spbr { ensembles: Spbr::default().ensembles, brighten: false, ..*spbr }));
        }
        method => *method.discs().ok_or_else(|| {
            let name = method.name();
            scene::Error::Usage(format!(
                "method {name} draws points in a way of its own, so that there is nothing to compare it with; \
                 --method auto compares the methods of transparent discs, --method circles those of opaque points, \
                 --method soft-base those of soft spheres, --method spbr numbers of ensembles"
            ))
        })?,
    };
    Ok(Formation::Discs(Discs { raster: Raster::default(), long_lists: LongLists::default(), ..discs }))
}

/// As [`formation`], and [`Formation::Surfaces`] for methods of opaque points, which draw no image alike but the same surfaces.
///
/// # Errors
/// A method of one transparent layer, or of layers of points.
pub fn compared(method: &Method, points: &Points) -> Result<Formation, scene::Error> {
    Surfaces::of(method, points).map_or_else(|| formation(method, points), |surfaces| Ok(Formation::Surfaces(surfaces)))
}

/// All settings that apply, exact methods first, each ladder ascending; and those that don't, with the reason.
pub fn settings(occasion: &Occasion, ladders: &Ladders) -> (Vec<Setting>, Vec<Skipped>) {
    let (mut settings, mut skipped) = (Vec::new(), Vec::new());
    match occasion.formation {
        Formation::Discs(discs) => {
            exact(occasion, discs, &mut settings, &mut skipped);
            peel(occasion, discs, ladders, &mut settings, &mut skipped);
            approximate(occasion, discs, ladders, &mut settings, &mut skipped);
            let soft = Soft::default();
            let other = [Method::SoftBase(soft), Method::SoftConcentric(soft), Method::SoftExpress(soft)];
            let reason = "draws soft spheres, another image formation";
            skipped.extend(other.map(|method| Setting::single(method, "").skipped(reason)));
        }
        Formation::Ensembles(spbr) => {
            let step = |ensembles: &u32| {
                let method = Method::Spbr(Spbr { ensembles: *ensembles, ..spbr });
                Setting::step(method, ("ensembles", *ensembles), "")
            };
            settings.extend(ladders.ensembles.iter().map(step));
            let reason = "its opacity depends on the number of ensembles: there is no one image to compare them with";
            skipped.push(Setting::single(Method::SpbrSimplified(Default::default()), "").skipped(reason));
            let reason = "draws discs that cover each other, each with the opacity that spbr gives to their surface";
            skipped.push(Setting::single(Method::ABuffer(Discs::default()), "").skipped(reason));
            let reason = "draws soft spheres, another image formation";
            skipped.push(Setting::single(Method::SoftBase(Soft::default()), "").skipped(reason));
        }
        Formation::Soft { soft, from_lambda } => {
            let mut all = self::soft(soft, from_lambda, ladders);
            if soft.modulation.is_some() {
                // Of the settings, the one whose events have no room for W.
                let reason = "has no room for what method.modulation needs";
                let packed = |s: &mut Setting| s.method.soft().is_some_and(|soft| soft.layout == SoftLayout::Paper);
                skipped.extend(all.extract_if(.., packed).map(|setting| setting.skipped(reason)));
            }
            settings.extend(all);
            let reason = "draws opaque discs, another image formation";
            skipped.push(Setting::single(Method::Circles(ScreenSplats::default()), "").skipped(reason));
        }
        Formation::Surfaces(surfaces) => return ladder::settings(&surfaces, ladders),
    }
    for opaque in [
        Method::Points,
        Method::Squares(ScreenSplats::default()),
        Method::Paraboloid(Interpolated::default()),
        Method::Cone(Interpolated::default()),
        Method::Sphere(ScreenSplats::default()),
        Method::Hqs(BlendedSplats::default()),
        Method::Splats(BlendedSplats::default()),
    ] {
        let reason = "draws opaque points of another shape: its image is not meant to be the same";
        skipped.push(Setting::single(opaque, "").skipped(reason));
    }
    let reason = "draws one transparent layer, another image formation";
    skipped.push(Setting::single(Method::OneLayer(OneLayer::default()), "").skipped(reason));
    (settings, skipped)
}

/// The three models of soft transparency, all with the same softness.
fn soft(soft: Soft, from_lambda: bool, ladders: &Ladders) -> Vec<Setting> {
    let rest = match soft.density {
        Density::Softness(peak) if from_lambda => format!("method.softness={peak}"),
        _ => String::new(),
    };
    let text = |own: &str| format!("{own} {rest}").trim().to_owned();
    let paper = Soft { layout: SoftLayout::Paper, ..soft };
    let shells = |count: &u32| {
        let method = Method::SoftConcentric(Soft { shells: Shells::Fixed(*count), ..soft });
        Setting::step(method, ("shells", *count), &rest)
    };
    let mut settings = vec![
        Setting::single(Method::SoftBase(soft), &rest),
        Setting::single(Method::SoftBase(paper), &text("method.layout=paper")),
    ];
    settings.extend(ladders.shells.iter().map(shells));
    settings.extend([
        Setting::single(Method::SoftConcentric(soft), &text("method.shells=adaptive")),
        Setting::single(Method::SoftExpress(soft), &rest),
    ]);
    settings
}

fn exact(occasion: &Occasion, discs: Discs, settings: &mut Vec<Setting>, skipped: &mut Vec<Skipped>) {
    let max_list = occasion.max_list;
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
            reached = setting.step.is_some_and(|(_, value)| value >= f64::from(occasion.max_list));
            settings.push(setting);
        }
    }
}

fn peel(occasion: &Occasion, discs: Discs, ladders: &Ladders, settings: &mut Vec<Setting>, skipped: &mut Vec<Skipped>) {
    let step = |layers: &u32| Setting::step(Method::Peel(Peel { discs, layers: *layers }), ("layers", *layers), "");
    climb(occasion, ladders.layers.iter().map(step), settings, skipped);
    let all = Setting::single(Method::Peel(Peel { discs, layers: 0 }), "");
    settings.push(Setting { effort: Some(occasion.max_list.into()), ..all });
}

fn approximate(
    occasion: &Occasion,
    discs: Discs,
    ladders: &Ladders,
    settings: &mut Vec<Setting>,
    skipped: &mut Vec<Skipped>,
) {
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
    use pellucid_engine::scene::MethodChoice;

    fn occasion(max_list: u32) -> Occasion {
        let formation = Formation::Discs(Discs::default());
        Occasion { formation, opaque: false, oriented: false, max_list }
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
    fn methods_of_one_image_formation_are_compared() {
        let gaussian = Discs { falloff: Falloff::Gaussian, raster: Raster::Hardware, ..Discs::default() };
        let plain = Formation::Discs(Discs { raster: Raster::Auto, ..gaussian });
        let of = |method: Method| formation(&method, &Points::default());
        assert_eq!(of(MethodChoice::Auto(gaussian).representative()).unwrap(), plain);
        assert_eq!(of(Method::Peel(Peel { discs: gaussian, layers: 3 })).unwrap(), plain);
        let own = [
            Method::Points,
            Method::OneLayer(OneLayer::default()),
            Method::Hqs(BlendedSplats::default()),
            Method::Splats(BlendedSplats::default()),
        ];
        assert!(own.into_iter().all(|method| of(method).is_err()));
        let soft = Soft { layout: SoftLayout::Paper, shells: Shells::Fixed(3), threshold: 0.25, ..Soft::default() };
        let same = Soft { threshold: 0.25, ..Soft::default() };
        for method in [Method::SoftBase(soft), Method::SoftConcentric(soft), Method::SoftExpress(soft)] {
            assert_eq!(of(method).unwrap(), Formation::Soft { soft: same, from_lambda: false });
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
        assert_eq!(names[..3], ["spbr-simplified", "abuffer", "soft-base"]);
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
    fn soft_spheres_have_three_models() {
        let of = |density, from_lambda| {
            let formation = Formation::Soft { soft: Soft { density, ..Soft::default() }, from_lambda };
            settings(&Occasion { formation, ..occasion(9) }, &Ladders::QUICK)
        };
        let (given, skipped) = of(Density::Softness(0.5), false);
        let keys: Vec<String> = given.iter().map(Setting::key).collect();
        let expected = [
            "soft-base",
            "soft-base method.layout=paper",
            "soft-concentric method.shells=1",
            "soft-concentric method.shells=4",
            "soft-concentric method.shells=adaptive",
            "soft-express",
        ];
        assert_eq!(keys, expected);
        let exact: Vec<bool> = given.iter().map(|setting| setting.is_exact(&occasion(9))).collect();
        assert_eq!(exact, [true, false, false, false, false, false]);
        let names: Vec<&str> = skipped.iter().map(|skipped| skipped.method.as_str()).collect();
        assert_eq!(
            names,
            ["circles", "points", "squares", "paraboloid", "cone", "sphere", "hqs", "splats", "one-layer"]
        );
        // What the rows were rendered with, where the scene says something else.
        let (converted, _) = of(Density::Softness(0.25), true);
        assert!(converted.iter().all(|setting| setting.text.ends_with("method.softness=0.25")), "{converted:#?}");
    }
}
