//! `[[cloud.class]]` for the points of a cloud: their opacity, color, radius and visibility.

use std::sync::Arc;

use glam::Vec3;

use super::error::Error;
use super::settings::{ClassSettings, CloudSettings, Selection};
use pellucid_core::cloud::facts::Facts;
use pellucid_core::cloud::{CLASSIFICATION_NAMES, Cloud, field};
use pellucid_core::color;
use pellucid_core::parallel;

/// The entries of a cloud that tell anything about its points.
#[derive(Debug, Clone, Default)]
pub(super) struct Rules<'a> {
    rules: Vec<Rule<'a>>,
}

#[derive(Debug, Clone)]
struct Rule<'a> {
    points: Test<'a>,
    settings: &'a ClassSettings,
}

/// Tells which points an entry is about.
#[derive(Debug, Clone)]
enum Test<'a> {
    Classes([f64; 2], &'a [u8]),
    Within([f64; 2], Arc<Vec<f64>>),
}

impl Test<'_> {
    fn holds(&self, i: usize) -> bool {
        match self {
            Self::Classes([low, high], codes) => (*low..=*high).contains(&f64::from(codes[i])),
            Self::Within([low, high], values) => (*low..=*high).contains(&values[i]),
        }
    }
}

impl<'a> Rules<'a> {
    /// Returns the rules of a cloud. Classes of a cloud without a classification have no points.
    ///
    /// # Errors
    /// The cloud lacks a scalar.
    pub fn of(settings: &'a CloudSettings, cloud: &'a Cloud) -> Result<Self, Error> {
        // A column for each scalar, however many entries it has.
        let mut columns: Vec<(&str, Arc<Vec<f64>>)> = Vec::new();
        let mut rules = Vec::new();
        for entry in &settings.class {
            let points = match (&entry.points, &cloud.classification) {
                (Selection::Class(code), Some(codes)) => Test::Classes([f64::from(*code); 2], codes),
                (Selection::Class(_), None) => continue,
                (Selection::Scalar { name, range }, classes) if is_classification(name) => match classes {
                    Some(codes) => Test::Classes(*range, codes),
                    None => continue,
                },
                (Selection::Scalar { name, range }, _) => {
                    let known = columns.iter().find(|(known, _)| known == name).map(|(_, values)| Arc::clone(values));
                    let values = match known {
                        Some(values) => values,
                        None => {
                            columns.push((name, Arc::new(scalar(settings, cloud, name)?)));
                            Arc::clone(&columns[columns.len() - 1].1)
                        }
                    };
                    Test::Within(*range, values)
                }
            };
            rules.push(Rule { points, settings: entry });
        }
        Ok(Self { rules })
    }

    /// Returns what the last rule for a point gives.
    fn last<T>(&self, i: usize, given: impl Fn(&ClassSettings) -> Option<T>) -> Option<T> {
        self.rules.iter().rev().find_map(|rule| given(rule.settings).filter(|_| rule.points.holds(i)))
    }

    /// Returns the opacity in place of the cloud's.
    pub fn opacity(&self, i: usize) -> Option<f32> {
        self.last(i, |entry| entry.opacity)
    }

    /// Returns the color in place of the cloud's.
    pub fn color(&self, i: usize) -> Option<Vec3> {
        self.last(i, |entry| entry.color)
    }

    /// Returns the radius in place of the cloud's, in world units before `radius_factor`.
    pub fn radius(&self, i: usize) -> Option<f32> {
        self.last(i, |entry| entry.radius)
    }

    /// Returns `true` if any rule gives a radius.
    pub fn give_radii(&self) -> bool {
        self.rules.iter().any(|rule| rule.settings.radius.is_some())
    }

    /// False for points that are not drawn; `None` if all are.
    pub fn visible_points(&self, count: usize) -> Option<Vec<bool>> {
        let hides = self.rules.iter().any(|rule| rule.settings.visible == Some(false));
        let visible = |i| self.last(i, |entry| entry.visible).unwrap_or(true);
        hides.then(|| parallel::map(count, visible))
    }

    /// Returns the number of the rules.
    pub fn len(&self) -> usize {
        self.rules.len()
    }

    /// Returns the rule that gives a point its color.
    pub fn painter(&self, i: usize) -> Option<usize> {
        self.rules.iter().rposition(|rule| rule.settings.color.is_some() && rule.points.holds(i))
    }

    /// Returns `true` for a rule about classes, which says the same of all points of a class.
    pub fn is_of_classes(&self, rule: usize) -> bool {
        matches!(self.rules[rule].points, Test::Classes(..))
    }

    /// Returns the color that rules about classes give to one.
    pub fn color_of_class(&self, code: u8) -> Option<Vec3> {
        let about = |rule: &&Rule<'_>| match &rule.points {
            Test::Classes([low, high], _) => (*low..=*high).contains(&f64::from(code)),
            Test::Within(..) => false,
        };
        self.rules.iter().rev().filter(about).find_map(|rule| rule.settings.color)
    }

    /// Returns the points of a rule, in words, and the color it gives them.
    pub fn described(&self, rule: usize) -> Option<(String, Vec3)> {
        let ClassSettings { points, color, .. } = self.rules[rule].settings;
        let words = match points {
            Selection::Class(code) => color::classes::label(*code),
            Selection::Scalar { name, range: [low, high] } => format!("{name} {low} to {high}"),
        };
        Some((words, (*color)?))
    }

    /// Gives points the colors of their classes.
    pub fn paint(&self, colors: &mut [Vec3]) {
        if self.rules.iter().any(|rule| rule.settings.color.is_some()) {
            parallel::for_each_mut(colors, |i, color| *color = self.color(i).unwrap_or(*color));
        }
    }
}

/// Returns the radii that entries may give to points of which only these facts are known, before `radius_factor`, and
/// `false` if each point has one of them.
pub(super) fn possible_radii(entries: &[ClassSettings], facts: &Facts) -> (Vec<f32>, bool) {
    let mut found = Vec::new();
    let (mut others, mut has_classes) = (false, false);
    for code in (0..=u8::MAX).filter(|code| facts.has_class(*code)) {
        has_classes = true;
        let mut about = entries.iter().rev().filter(|entry| entry.points.holds_class(code));
        match about.find_map(|entry| entry.radius) {
            Some(radius) => found.push(radius),
            None => others = true,
        }
    }
    let is_of_scalar = |entry: &&ClassSettings| match &entry.points {
        Selection::Class(_) => false,
        Selection::Scalar { name, .. } => !is_classification(name),
    };
    found.extend(entries.iter().filter(is_of_scalar).filter_map(|entry| entry.radius));
    (found, others || !has_classes)
}

fn is_classification(name: &str) -> bool {
    CLASSIFICATION_NAMES.contains(&name.to_lowercase().as_str())
}

fn scalar(settings: &CloudSettings, cloud: &Cloud, name: &str) -> Result<Vec<f64>, Error> {
    let found = field::column(cloud, name);
    let found = found.or_else(|| Some(cloud.scalar(name)?.iter().map(|value| f64::from(*value)).collect()));
    found.ok_or_else(|| {
        let names = field::names(cloud);
        let hint = pellucid_core::words::nearest(name, names.iter().map(|name| &**name), "the file has");
        Error::NoScalar { path: settings.path.clone(), name: name.to_owned(), key: "cloud.class", hint }
    })
}

/// Says of each cloud without classes that entries are about them.
pub(super) fn note(settings: &CloudSettings, cloud: &Cloud) -> Option<String> {
    let by_class = |entry: &ClassSettings| match &entry.points {
        Selection::Class(_) => true,
        Selection::Scalar { name, .. } => is_classification(name),
    };
    let idle = cloud.classification.is_none() && settings.class.iter().any(by_class);
    idle.then(|| "the file has no classes; entries of `class` with an `id` have no effect on it".to_owned())
}
