//! What is known of the clouds: their columns, classes and ranges; and of the points that are shown: how F is spread.

use std::collections::BTreeMap;
use std::sync::Arc;

use glam::DVec3;
use rayon::prelude::*;

use pellucid_engine::cloud::Cloud;
use pellucid_engine::cloud::field::{self, Field};
use pellucid_engine::passes::project::Parts;
use pellucid_engine::scene::{CloudSettings, Scene};

/// Bins of a histogram of F, equally wide.
pub const BINS: usize = 64;

/// What is known of a cloud.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Census {
    /// Finite points.
    pub points: usize,
    /// Whether the file has colors.
    pub colors: bool,
    /// Whether it has normals.
    pub normals: bool,
    /// Whether the points have radii of their own, not estimated ones.
    pub own_radii: bool,
    /// Points of each class; empty without classes.
    pub classes: BTreeMap<u8, usize>,
    /// What a field can be made of, by name, with the smallest and the largest finite value: intensity, scalar properties,
    /// radius, coordinates. Classes are not among them.
    pub scalars: Vec<(String, [f64; 2])>,
    /// K and field of a prepared file.
    pub prepared: Option<(usize, Field)>,
}

impl Census {
    /// Looks at all points of a cloud.
    pub fn of(cloud: &Cloud) -> Self {
        let names = field::names(cloud).into_iter().filter(|name| !name.is_empty() && name != "classification");
        let mut scalars: Vec<(String, [f64; 2])> = Vec::new();
        for name in names {
            // Of two properties of one name the first is taken; the words of other fields mean these.
            let is_taken = name == "uncertainty" || name == "distance-to-axis";
            if !is_taken && !scalars.iter().any(|(other, _)| *other == name) {
                let range = range(cloud, &name);
                scalars.push((name.into_owned(), range));
            }
        }
        Self {
            points: cloud.len(),
            colors: cloud.colors.is_some(),
            normals: cloud.normals.is_some(),
            own_radii: cloud.own_radii().is_some(),
            classes: classes(cloud.classification.as_deref().unwrap_or_default()),
            scalars,
            prepared: cloud.prepared.as_ref().map(|prepared| (prepared.neighbors, prepared.field.clone())),
        }
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
    let add = |mut sum: [usize; 256], more: [usize; 256]| {
        sum.iter_mut().zip(more).for_each(|(sum, more)| *sum += more);
        sum
    };
    let of_chunk = |codes: &[u8]| {
        let mut counts = [0; 256];
        codes.iter().for_each(|code| counts[usize::from(*code)] += 1);
        counts
    };
    let counts = codes.par_chunks(1 << 16).map(of_chunk).reduce(|| [0; 256], add);
    (0u8..=255).zip(counts).filter(|(_, count)| *count > 0).collect()
}

/// The smallest and the largest finite value of what `field` calls so; 0 and 0 if there is none.
fn range(cloud: &Cloud, name: &str) -> [f64; 2] {
    let of = |values: &[f32]| ends(values.par_iter().map(|value| f64::from(*value)));
    if let Some((_, values)) = cloud.scalars.iter().find(|(other, _)| other == name) {
        return of(values);
    }
    let axis = |axis: usize| ends(cloud.positions.par_iter().map(move |p| p[axis]));
    match name {
        "intensity" => of(cloud.intensity.as_deref().unwrap_or_default()),
        "radius" => of(cloud.own_radii().unwrap_or_default()),
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

/// The name of a class of LAS 1.4 (ASPRS, table 17); `None` for those that are reserved or free for users.
pub fn class_name(code: u8) -> Option<&'static str> {
    const NAMES: [&str; 23] = [
        "never classified",
        "unclassified",
        "ground",
        "low vegetation",
        "medium vegetation",
        "high vegetation",
        "building",
        "low point (noise)",
        "model key point",
        "water",
        "rail",
        "road surface",
        "overlap",
        "wire, guard",
        "wire, conductor",
        "transmission tower",
        "wire connector",
        "bridge deck",
        "high noise",
        "overhead structure",
        "ignored ground",
        "snow",
        "temporal exclusion",
    ];
    NAMES.get(usize::from(code)).copied()
}

/// How F of the points that are shown is spread.
#[derive(Debug, Clone, PartialEq)]
pub struct FieldFacts {
    /// Points of each of [`BINS`] equal parts of [0, 1].
    pub histogram: Arc<[u64]>,
    /// What the threshold makes of them.
    pub parts: Parts,
}

/// What F depends on, of each cloud: K, what F is, scale and translation, which may drop points.
type Origins = Vec<(Option<usize>, Option<Field>, f64, DVec3)>;

/// The histogram that was made last, so that it is made only for other points.
#[derive(Default)]
pub struct Histograms(Option<(Origins, Arc<[u64]>)>);

impl Histograms {
    /// The histogram of `fields`, which are F of the points of `scene` in [0, 1].
    pub fn of(&mut self, scene: &Scene, fields: &[f32]) -> Arc<[u64]> {
        let origin = |cloud: &CloudSettings| (cloud.neighbors, cloud.field.clone(), cloud.scale, cloud.translate);
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
    let add = |mut sum: [u64; BINS], more: [u64; BINS]| {
        sum.iter_mut().zip(more).for_each(|(sum, more)| *sum += more);
        sum
    };
    let of_chunk = |fields: &[f32]| {
        let mut counts = [0; BINS];
        // The cast stops at both ends, and 1 belongs to the last bin.
        fields.iter().for_each(|f| counts[((f * BINS as f32) as usize).min(BINS - 1)] += 1);
        counts
    };
    Arc::new(fields.par_chunks(1 << 16).map(of_chunk).reduce(|| [0; BINS], add))
}

#[cfg(test)]
mod tests {
    use super::*;
    use pellucid_engine::scene::{Document, Overrides};

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
    fn a_census_counts_what_is_there() {
        let census = Census::of(&cloud());
        assert_eq!((census.points, census.colors, census.normals, census.own_radii), (100_000, false, false, false));
        assert_eq!(census.classes, [(2, 90_000), (5, 10_000)].into());
        let scalars = [
            ("intensity", [7.0, 100_006.0]),
            ("gps time", [-2.0, 3.0]),
            ("odd", [0.0, 0.0]),
            ("x", [0.0, 99_999.0]),
            ("y", [-1.0, -1.0]),
            ("z", [4.5e6, 4.5e6]),
        ];
        assert_eq!(census.scalars, scalars.map(|(name, range)| (name.to_owned(), range)));
        let plain = Census::of(&Cloud::default());
        assert_eq!(plain.fields(), ["uncertainty", "distance-to-axis", "x", "y", "z"]);
    }

    /// Whatever the chooser offers is a field of the cloud, found by its name.
    #[test]
    fn every_field_that_is_offered_can_be_had() {
        let cloud = cloud();
        let census = Census::of(&cloud);
        assert_eq!(census.fields().len(), 9);
        for name in census.fields() {
            let mut document = Document::from_clouds(["a.ply"], &Overrides::default()).unwrap();
            let word = pellucid_engine::scene::Setting::Word(name.to_owned());
            let classes = pellucid_engine::scene::Setting::Integers(vec![5]);
            let changes =
                [("cloud.0.field".to_owned(), Some(word)), ("cloud.0.soft_classes".to_owned(), Some(classes))];
            let scene = document.change(&changes).unwrap();
            let field = census.field(&scene.clouds[0]);
            assert_eq!(field.name(), name);
            let values = field.of(&cloud).unwrap();
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
        let first = histograms.of(&scene(""), &[0.0]);
        // What doesn't tell F changes nothing: the other points are not looked at.
        assert!(Arc::ptr_eq(&first, &histograms.of(&scene("opacity = 0.5\nradius = 2.0"), &[1.0])));
        for text in ["field = 'z'", "neighbors = 7", "scale = 2.0", ""] {
            assert_eq!(histograms.of(&scene(text), &[1.0])[63], 1, "{text}");
            assert_eq!(histograms.of(&scene("field = 'x'"), &[0.0])[63], 0);
        }
    }

    #[test]
    fn classes_have_their_names() {
        assert_eq!([2, 5, 22].map(class_name), [Some("ground"), Some("high vegetation"), Some("temporal exclusion")]);
        assert_eq!([23, 64, 255].map(class_name), [None; 3]);
    }
}
