//! The opacities of all clouds by one slider, which multiplies them.

use super::{opacity, significant};
use pellucid_scene::{Change, CloudSettings, Setting};

/// The opacities that one slider changes: of each cloud by the key that decides about it, then of classes that have
/// their own.
fn opacities(clouds: &[CloudSettings]) -> Vec<(String, f32)> {
    let own = clouds.iter().enumerate().map(|(i, cloud)| {
        let (key, value) = opacity(cloud);
        (format!("cloud.{i}.{key}"), value)
    });
    let classes = clouds.iter().enumerate().flat_map(|(i, cloud)| {
        let entries = cloud.class.iter().enumerate();
        entries.filter_map(move |(at, entry)| Some((format!("cloud.{i}.class.{at}.opacity"), entry.opacity?)))
    });
    own.chain(classes).collect()
}

/// The mean of the clouds' opacities, and true if all are equal.
pub fn mean_opacity(clouds: &[CloudSettings]) -> (f64, bool) {
    let values: Vec<f32> = clouds.iter().map(|cloud| opacity(cloud).1).collect();
    let are_equal = values.iter().all(|value| Some(value) == values.first());
    (values.iter().map(|value| f64::from(*value)).sum::<f64>() / values.len().max(1) as f64, are_equal)
}

/// The keys that the slider changes, of those that `opened`, the same clouds as they were opened, has, too.
pub fn opacity_keys(clouds: &[CloudSettings], opened: &[CloudSettings]) -> Vec<String> {
    let own = ["opacity", "surface_opacity"].map(|key| format!("cloud.*.{key}"));
    let classes = clouds.iter().zip(opened).enumerate().flat_map(|(i, (cloud, opened))| {
        let entries = cloud.class.iter().zip(&opened.class).enumerate();
        let same = entries.filter(|(_, (entry, opened))| entry.points == opened.points && opened.opacity.is_some());
        same.map(move |(at, _)| format!("cloud.{i}.class.{at}.opacity"))
    });
    own.into_iter().chain(classes).collect()
}

/// The ratios of opacities, also while some of them are at 1 or all at 0.
#[derive(Debug, Default)]
pub struct Ratios {
    /// Opacities with the ratios.
    base: Vec<f32>,
    /// The opacities that were made of them last.
    given: Vec<(String, f32)>,
}

impl Ratios {
    /// The changes that give the clouds a mean opacity, from 0 to 1, by a common factor. Opacities stop at 1, and
    /// return to their ratio with a smaller mean. Clouds that are all at 0 have no ratio and become equal.
    pub fn changes(&mut self, clouds: &[CloudSettings], mean: f64) -> Vec<Change> {
        let now = opacities(clouds);
        if now != self.given {
            self.base = now.iter().map(|(_, value)| *value).collect();
        }
        let base: Vec<f64> = self.base.iter().map(|value| f64::from(*value)).collect();
        let (own, classes) = base.split_at(clouds.len());
        let factor = factor(own, mean);
        let scaled = |value: &f64| factor.map(|factor| (value * factor).min(1.0));
        let own = own.iter().map(|value| scaled(value).unwrap_or(mean));
        let values = own.chain(classes.iter().map(|value| scaled(value).unwrap_or(*value))).map(significant);
        let keys = now.into_iter().map(|(key, _)| key);
        let changes: Vec<(String, f64)> = keys.zip(values).collect();
        self.given = changes.iter().map(|(key, value)| (key.clone(), *value as f32)).collect();
        changes.into_iter().map(|(key, value)| (key, Some(Setting::Number(value)))).collect()
    }
}

/// The factor by which opacities, none of them above 1 then, have a mean. If they can't have it, the least one that
/// makes all of them 1 but those at 0; `None` if all are at 0.
fn factor(opacities: &[f64], mean: f64) -> Option<f64> {
    let mut positive: Vec<f64> = opacities.iter().copied().filter(|value| *value > 0.0).collect();
    positive.sort_by(|a, b| b.total_cmp(a));
    let wanted = mean * opacities.len() as f64;
    // As few as possible stop at 1: the largest ones.
    let with_stopped = |count: usize| {
        let rest = &positive[count..];
        let factor = (wanted - count as f64) / rest.iter().sum::<f64>();
        (factor * rest[0] <= 1.0).then_some(factor)
    };
    (0..positive.len()).find_map(with_stopped).or(positive.last().map(|least| 1.0 / least))
}

#[cfg(test)]
mod tests {
    use super::*;
    use pellucid_scene::{Document, Overrides};

    const TEXT: &str = "
        [[cloud]]
        path = 'a.ply'
        opacity = 0.8
        [[cloud]]
        path = 'b.ply'
        surface_opacity = 0.2
        [[cloud.class]]
        id = 6
        opacity = 0.1
        [[cloud.class]]
        id = 2
        visible = false
        [[cloud]]
        path = 'c.ply'
        opacity = 0.05
    ";

    /// The scene after the slider was at these places, one after the other: opacities of the clouds, then the class.
    fn after(ratios: &mut Ratios, document: &mut Document, means: &[f64]) -> [f32; 4] {
        for mean in means {
            let changes = ratios.changes(&document.scene().unwrap().clouds, *mean);
            document.change(&changes).unwrap();
        }
        let clouds = document.scene().unwrap().clouds;
        let class = clouds[1].class[0].opacity.unwrap();
        [clouds[0].opacity, clouds[1].surface_opacity.unwrap(), clouds[2].opacity, class]
    }

    fn document() -> Document {
        Document::from_toml(TEXT, "s.toml".as_ref(), &Overrides::default()).unwrap()
    }

    #[test]
    fn ratios_of_opacities_are_kept() {
        let mut document = document();
        assert_eq!(after(&mut Ratios::default(), &mut document, &[0.175]), [0.4, 0.1, 0.025, 0.05]);
        let (mean, alike) = mean_opacity(&document.scene().unwrap().clouds);
        assert!((mean - 0.175).abs() < 1e-7 && !alike);
    }

    #[test]
    fn ratios_come_back_from_both_ends() {
        for end in [0.0, 1.0, 0.5] {
            let (mut ratios, mut document) = (Ratios::default(), document());
            let [a, b, c, class] = after(&mut ratios, &mut document, &[0.3, end]);
            match end {
                0.0 => assert_eq!([a, b, c, class], [0.0; 4]),
                1.0 => assert_eq!([a, b, c, class], [1.0; 4]),
                // The first one stops; the others have the factor 2, and the mean is what the slider says.
                _ => assert_eq!([a, b, c, class], [1.0, 0.4, 0.1, 0.2]),
            }
            // Another drag, later.
            assert_eq!(after(&mut ratios, &mut document, &[0.9, 0.35]), [0.8, 0.2, 0.05, 0.1], "{end}");
        }
    }

    #[test]
    fn opacities_that_were_changed_otherwise_have_new_ratios() {
        let (mut ratios, mut document) = (Ratios::default(), document());
        after(&mut ratios, &mut document, &[1.0]);
        document.set("cloud.0.opacity", Setting::Number(0.25)).unwrap();
        assert_eq!(after(&mut ratios, &mut document, &[0.375]), [0.125, 0.5, 0.5, 0.5]);
    }

    #[test]
    fn clouds_that_are_all_invisible_become_equal() {
        let (mut ratios, mut document) = (Ratios::default(), document());
        let none = [0, 1, 2].map(|i| {
            let key = if i == 1 { "surface_opacity" } else { "opacity" };
            (format!("cloud.{i}.{key}"), Some(Setting::Number(0.0)))
        });
        document.change(&none).unwrap();
        assert_eq!(after(&mut ratios, &mut document, &[0.25, 0.5]), [0.5, 0.5, 0.5, 0.1]);
    }

    #[test]
    fn a_cloud_at_0_stays_there() {
        assert_eq!(factor(&[0.5, 0.0], 0.5), Some(2.0));
        assert_eq!(factor(&[0.5, 0.0], 1.0), Some(2.0));
        assert_eq!((factor(&[0.0, 0.0], 0.5), factor(&[], 0.5)), (None, None));
        // Of ten, as many stop as must.
        let values: Vec<f64> = (1..=10).map(|i| 0.1 * f64::from(i)).collect();
        for mean in [0.1, 0.55, 0.7, 0.9, 0.99, 1.0] {
            let factor = factor(&values, mean).unwrap();
            let made: f64 = values.iter().map(|value| (value * factor).min(1.0)).sum();
            assert!((made / 10.0 - mean).abs() < 1e-12, "{mean}: {factor}");
        }
    }
}
