//! Statistics of the clouds (columns, classes, ranges) and of the shown points (the distribution of F).

use std::collections::BTreeMap;
use std::sync::Arc;

use glam::DVec3;
use rayon::prelude::*;

use pellucid_core::cloud::Cloud;
use pellucid_core::cloud::field::{self, Field};
use pellucid_core::cloud::gaussians::Gaussians;
use pellucid_core::color::ColorSpace;
use pellucid_engine::passes::project::Parts;
use pellucid_scene::stored::OpenStore;
use pellucid_scene::{CloudSettings, ColorBy, Scene, Strays, automatic};
use pellucid_session::Clouds;

/// Bins of a histogram of F, equally wide.
pub const BINS: usize = 64;

/// Statistics of one cloud.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Statistics {
    /// Finite points.
    pub points: usize,
    /// True if the file has colors.
    pub colors: bool,
    /// Quantity that `color_by = "auto"` shows; `Auto` while it is not known.
    pub auto: ColorBy,
    /// True if the file has normals.
    pub normals: bool,
    /// True if the file holds Gaussian splats.
    pub gaussians: bool,
    /// The space in which these are meant to be blended.
    pub blend_space: Option<ColorSpace>,
    /// True if the points have radii of their own rather than estimated ones.
    pub own_radii: bool,
    /// Points of each class; empty without classes.
    pub classes: BTreeMap<u8, usize>,
    /// Columns that a field can be made from, by name, each with its smallest and largest finite value: intensity,
    /// scalar properties, radius, coordinates. Classes are listed separately.
    pub scalars: Vec<(String, [f64; 2])>,
    /// K and field of a prepared file.
    pub prepared: Option<(usize, Field)>,
}

impl Statistics {
    /// The statistics of each cloud.
    pub fn of_clouds(clouds: &Clouds) -> Vec<Self> {
        match clouds {
            Clouds::Held(clouds) => clouds.iter().map(|cloud| Self::from_cloud(cloud)).collect(),
            Clouds::Stored(stores) => stores.iter().map(Self::from_store).collect(),
        }
    }

    /// Gathers the statistics of all points of a cloud.
    fn from_cloud(cloud: &Cloud) -> Self {
        let names = field::names(cloud).into_iter().filter(|name| !name.is_empty() && name != "classification");
        let mut scalars: Vec<(String, [f64; 2])> = Vec::new();
        for name in names {
            // If two properties share a name, the first one counts. These two names always mean the fields of other
            // definitions.
            let is_taken = name == "uncertainty" || name == "distance-to-axis";
            if !is_taken && !scalars.iter().any(|(other, _)| *other == name) {
                let range = range(cloud, &name);
                scalars.push((name.into_owned(), range));
            }
        }
        Self {
            points: cloud.len(),
            colors: cloud.colors.is_some(),
            auto: automatic(cloud),
            normals: cloud.normals.is_some(),
            gaussians: cloud.gaussians.is_some(),
            blend_space: cloud.gaussians.as_ref().map(Gaussians::blend_space),
            own_radii: cloud.own_radii().is_some(),
            classes: classes(cloud.classification.as_deref().unwrap_or_default()),
            scalars,
            prepared: cloud.prepared.as_ref().map(|prepared| (prepared.neighbors, prepared.field.clone())),
        }
    }

    /// Statistics of a cloud that stays in its store: those of points that stand for all, once they are known.
    fn from_store(store: &OpenStore) -> Self {
        let summary = store.summary();
        let known = store.surveyed();
        let sample = known.as_ref().map_or(&summary.like, |survey| &survey.sample);
        let statistics = Self::from_cloud(sample);
        let times = summary.points as f64 / sample.len().max(1) as f64;
        let classes = statistics.classes.iter().map(|(code, count)| (*code, (*count as f64 * times).round() as usize));
        Self { points: summary.points as usize, classes: classes.collect(), ..statistics }
    }

    /// The field in force, by the scene's settings for this cloud.
    pub fn field(&self, settings: &CloudSettings) -> Field {
        let prepared = self.prepared.as_ref().map(|(_, field)| field);
        settings.field.as_ref().or(prepared).cloned().unwrap_or_default()
    }

    /// The words that `field` can be given for this cloud.
    pub fn fields(&self) -> Vec<&str> {
        let classes = (!self.classes.is_empty()).then_some("classification");
        let scalars = self.scalars.iter().map(|(name, _)| name.as_str());
        ["uncertainty", "distance-to-axis"].into_iter().chain(classes).chain(scalars).collect()
    }
}

fn classes(codes: &[u8]) -> BTreeMap<u8, usize> {
    let counts: [usize; 256] = counts(codes, |code| usize::from(*code));
    (0u8..=255).zip(counts).filter(|(_, count)| *count > 0).collect()
}

/// Counts items by their bin, below N.
fn counts<T: Sync, const N: usize>(items: &[T], bin: impl Fn(&T) -> usize + Sync) -> [usize; N] {
    let add = |mut sum: [usize; N], more: [usize; N]| {
        sum.iter_mut().zip(more).for_each(|(sum, more)| *sum += more);
        sum
    };
    let of_chunk = |items: &[T]| {
        let mut counts = [0; N];
        items.iter().for_each(|item| counts[bin(item)] += 1);
        counts
    };
    items.par_chunks(1 << 16).map(of_chunk).reduce(|| [0; N], add)
}

/// The smallest and the largest finite value of the column called `name`; 0 and 0 if it has none.
fn range(cloud: &Cloud, name: &str) -> [f64; 2] {
    let range_of = |values: &[f32]| ends(values.par_iter().map(|value| f64::from(*value)));
    if let Some((_, values)) = cloud.scalars.iter().find(|(other, _)| other == name) {
        return range_of(values);
    }
    let axis = |axis: usize| ends(cloud.positions.par_iter().map(move |p| p[axis]));
    match name {
        "intensity" => range_of(cloud.intensity.as_deref().unwrap_or_default()),
        "radius" => range_of(cloud.own_radii().unwrap_or_default()),
        "x" => axis(0),
        "y" => axis(1),
        _ => axis(2),
    }
}

fn ends(values: impl ParallelIterator<Item = f64>) -> [f64; 2] {
    let nothing = || [f64::INFINITY, f64::NEG_INFINITY];
    let of_one = |value: f64| if value.is_finite() { [value; 2] } else { nothing() };
    let [least, most] = values.map(of_one).reduce(nothing, |[a, b], [c, d]| [a.min(c), b.max(d)]);
    if least <= most { [least, most] } else { [0.0; 2] }
}

/// The distribution of F over the shown points.
#[derive(Debug, Clone, PartialEq)]
pub struct FieldFacts {
    /// Number of points in each of [`BINS`] equal parts of [0, 1].
    pub histogram: Arc<[u64]>,
    /// Number of points on each side of the threshold.
    pub parts: Parts,
}

/// Everything F depends on, per cloud: K, the definition of F, caps and outliers, scale and translation (which may drop
/// points).
type Origins = Vec<(Option<usize>, Option<Field>, Strays, f64, DVec3)>;

/// The last histogram, kept so that it is recomputed only when the points change.
#[derive(Default)]
pub struct Histograms(Option<(Origins, Arc<[u64]>)>);

impl Histograms {
    /// The histogram of `fields`: F of the points of `scene`, in [0, 1].
    pub fn for_scene(&mut self, scene: &Scene, fields: &[f32]) -> Arc<[u64]> {
        let origin =
            |cloud: &CloudSettings| (cloud.neighbors, cloud.field.clone(), cloud.strays, cloud.scale, cloud.translate);
        let origins: Origins = scene.clouds.iter().map(origin).collect();
        match &self.0 {
            Some((known, histogram)) if *known == origins => histogram.clone(),
            _ => {
                let histogram = histogram(fields);
                self.0 = Some((origins, histogram.clone()));
                histogram
            }
        }
    }
}

fn histogram(fields: &[f32]) -> Arc<[u64]> {
    // The cast clamps at both ends; 1 belongs to the last bin.
    let counts: [usize; BINS] = counts(fields, |f| ((f * BINS as f32) as usize).min(BINS - 1));
    Arc::new(counts.map(|count| count as u64))
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;
    use pellucid_scene::{Document, Overrides};

    fn cloud() -> Cloud {
        let n = 100_000;
        Cloud {
            positions: (0..n).map(|i| DVec3::new(f64::from(i), -1.0, 4.5e6)).collect(),
            classification: Some((0..n).map(|i| if i % 10 == 0 { 5 } else { 2 }).collect()),
            intensity: Some((0..n).map(|i| i as f32 + 7.0).collect()),
            scalars: vec![
                ("gps time".into(), [f32::NAN, f32::INFINITY, 3.0, -2.0].repeat(n as usize / 4)),
                ("uncertainty".into(), vec![0.0; n as usize]),
                ("odd".into(), vec![f32::NAN; n as usize]),
            ],
            ..Cloud::default()
        }
    }

    #[test]
    fn statistics_count_what_is_there() {
        let statistics = Statistics::from_cloud(&cloud());
        assert_eq!(
            (statistics.points, statistics.colors, statistics.normals, statistics.own_radii),
            (100_000, false, false, false)
        );
        assert_eq!(statistics.classes, [(2, 90_000), (5, 10_000)].into());
        let scalars = [
            ("intensity", [7.0, 100_006.0]),
            ("gps time", [-2.0, 3.0]),
            ("odd", [0.0, 0.0]),
            ("x", [0.0, 99_999.0]),
            ("y", [-1.0, -1.0]),
            ("z", [4.5e6, 4.5e6]),
        ];
        assert_eq!(statistics.scalars, scalars.map(|(name, range)| (name.to_owned(), range)));
        let plain = Statistics::from_cloud(&Cloud::default());
        assert_eq!(plain.fields(), ["uncertainty", "distance-to-axis", "x", "y", "z"]);
    }

    #[test]
    fn auto_is_what_the_engine_makes_of_it() {
        let of = |colors: Option<Vec3>, codes: [u8; 4]| {
            let colors = colors.map(|color| vec![color; 4]);
            let positions = vec![DVec3::ZERO; 4];
            automatic(&Cloud { positions, colors, classification: Some(codes.to_vec()), ..Cloud::default() })
        };
        let (few, enough) = ([0, 1, 2, 3], [2, 3, 4, 5]);
        assert_eq!(of(Some(Vec3::new(0.1, 0.2, 0.3)), enough), ColorBy::Rgb);
        for blank in [Some(Vec3::ZERO), Some(Vec3::ONE), None] {
            assert_eq!(of(blank, enough), ColorBy::Classification);
            assert_eq!(of(blank, few), ColorBy::Height);
        }
        assert_eq!(Statistics::from_cloud(&cloud()).auto, ColorBy::Height, "darker where intensity is small");
    }

    /// Every name the chooser offers is a field of the cloud.
    #[test]
    fn every_field_that_is_offered_can_be_had() {
        let cloud = cloud();
        let statistics = Statistics::from_cloud(&cloud);
        assert_eq!(statistics.fields().len(), 9);
        for name in statistics.fields() {
            let mut document = Document::from_clouds(["a.ply"], &Overrides::default()).unwrap();
            let word = pellucid_scene::Setting::Word(name.to_owned());
            let classes = pellucid_scene::Setting::Integers(vec![5]);
            let changes =
                [("cloud.0.field".to_owned(), Some(word)), ("cloud.0.soft_classes".to_owned(), Some(classes))];
            let scene = document.change(&changes).unwrap();
            let field = statistics.field(&scene.clouds[0]);
            assert_eq!(field.name(), name);
            let values = field.values(&cloud).unwrap();
            assert_eq!(values.is_none(), name == "uncertainty");
            assert!(values.is_none_or(|values| values.len() == cloud.len()));
        }
    }

    #[test]
    fn every_point_is_in_one_bin() {
        let fields: Vec<f32> = (0..200_000).map(|i| i as f32 / 199_999.0).collect();
        let bins = histogram(&fields);
        assert_eq!((bins.len(), bins.iter().sum::<u64>()), (BINS, 200_000));
        assert!(bins.iter().all(|count| (3124..=3126).contains(count)), "{bins:?}");
        let bins = histogram(&[0.0, 1.0, 0.999_999_9, 0.5, 0.499_999_97]);
        assert_eq!((bins[0], bins[63], bins[32], bins[31]), (1, 2, 1, 1));
    }

    #[test]
    fn a_histogram_is_made_anew_for_another_field_only() {
        let scene = |text: &str| {
            let text = format!("[[cloud]]\npath = 'a.ply'\n{text}");
            Document::from_toml(&text, "s.toml".as_ref(), &Overrides::default()).unwrap().scene().unwrap()
        };
        let mut histograms = Histograms::default();
        let first = histograms.for_scene(&scene(""), &[0.0]);
        // Settings that don't affect F change nothing: the other points are not examined.
        assert!(Arc::ptr_eq(&first, &histograms.for_scene(&scene("opacity = 0.5\nradius = 2.0"), &[1.0])));
        for text in ["field = 'z'", "neighbors = 7", "outliers = 'soft'", "scale = 2.0", ""] {
            assert_eq!(histograms.for_scene(&scene(text), &[1.0])[63], 1, "{text}");
            assert_eq!(histograms.for_scene(&scene("field = 'x'"), &[0.0])[63], 0);
        }
    }
}
