//! Facts that follow from all points of a store, and some points that stand for all.

use std::sync::{Arc, Mutex, PoisonError};

use glam::DVec3;

use super::super::settings::CloudSettings;
use crate::batches::batches;
use pellucid_core::cloud::Cloud;
use pellucid_core::cloud::facts::Facts;
use pellucid_core::cloud::field::{self, Field};
use pellucid_core::cloud::sampling::Sampling;
use pellucid_core::parallel;
use pellucid_core::progress::Progress;
use pellucid_io::store::{Store, StoreSurvey, Summary};

/// Nodes that are read at once at most, and of large ones about so many points for each thread.
const BATCH: usize = 64;
const POINTS: u64 = 1 << 19;

/// Nothing of a range is known.
const NONE: [f64; 2] = [f64::INFINITY, f64::NEG_INFINITY];

/// A store, with its last survey.
#[derive(Debug, Clone)]
pub struct OpenStore {
    pub(super) store: Arc<dyn Store>,
    found: Arc<Mutex<Option<KnownSurvey>>>,
}

/// A survey, and the settings that it depends on: scale, translation and field.
#[derive(Debug, Clone)]
struct KnownSurvey {
    by: (f64, DVec3, Option<Field>),
    survey: StoreSurvey,
    range: [f64; 2],
}

impl OpenStore {
    /// Returns one whose points nobody has looked at.
    pub fn new(store: Box<dyn Store>) -> Self {
        Self { store: Arc::from(store), found: Arc::default() }
    }

    /// Returns the summary of the whole cloud.
    pub fn summary(&self) -> &Summary {
        self.store.summary()
    }

    /// Returns the last survey; `None` before a scene was made of this store.
    pub fn surveyed(&self) -> Option<StoreSurvey> {
        self.found.lock().unwrap_or_else(PoisonError::into_inner).as_ref().map(|found| found.survey.clone())
    }

    /// Surveys like [`survey`]; points are looked at once for all scenes that want the same of them.
    pub(super) fn survey(
        &self,
        settings: &CloudSettings,
        field: Option<&Field>,
        progress: &Progress,
    ) -> Result<(StoreSurvey, [f64; 2]), crate::OpenError> {
        let by = (settings.scale, settings.translate, field.cloned());
        let mut known = self.found.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(found) = known.as_ref().filter(|found| found.by == by) {
            return Ok((found.survey.clone(), found.range));
        }
        let (survey, range) = survey(&*self.store, settings, field, progress)?;
        *known = Some(KnownSurvey { by, survey: survey.clone(), range });
        Ok((survey, range))
    }
}

/// Looks at a store's points where a scene places them, unless the store knows; and at the range of what a field is
/// made of, if one is given.
///
/// # Errors
/// The store can't be read, lacks what the field is made of, or the survey was cancelled.
fn survey(
    store: &dyn Store,
    settings: &CloudSettings,
    field: Option<&Field>,
    progress: &Progress,
) -> Result<(StoreSurvey, [f64; 2]), crate::OpenError> {
    let summary = store.summary();
    let is_in_place = settings.scale == 1.0 && settings.translate == DVec3::ZERO;
    if field.is_none()
        && is_in_place
        && let Some(survey) = store.survey()?
    {
        return Ok((survey, NONE));
    }
    let sampling = Sampling::of(summary.points);
    progress.reset();
    progress.set_message(format!("looking at {}", summary.path.display()));
    progress.set_length(summary.points);
    let look = |node: usize| -> Result<(Facts, Cloud, [f64; 2]), crate::OpenError> {
        let cloud = store.read(node)?.cloud;
        progress.inc(cloud.len() as u64);
        let positions = cloud.positions.iter().enumerate();
        let taken = positions.filter(|(_, position)| sampling.takes(settings.placed(**position)));
        let taken: Vec<u32> = taken.map(|(at, _)| at as u32).collect();
        let mut range = NONE;
        if let Some(field) = field {
            let values = field.unscaled(&cloud, || Some(summary.bounds));
            let failed = |source| super::super::error::Error::Field { path: settings.path.clone(), source };
            range = field::range(values.map_err(failed)?.unwrap_or_default());
        }
        Ok((Facts::of(&cloud), cloud.subset(&taken), range))
    };
    let mut found = StoreSurvey { facts: Facts::default(), sample: summary.like.clone() };
    let mut range = NONE;
    let nodes: Vec<usize> = (0..store.nodes().len()).filter(|node| store.nodes()[*node].points > 0).collect();
    let most = POINTS * rayon::current_num_threads() as u64;
    for batch in batches(nodes.iter().map(|node| store.nodes()[*node].points), most, BATCH) {
        let cancelled = |_| pellucid_io::Error::Cancelled { path: summary.path.clone() };
        progress.check().map_err(cancelled)?;
        let parts = parallel::try_map_each(&nodes[batch], |node| look(*node))?;
        for (facts, sample, [least, most]) in parts {
            found.facts = found.facts.and(&facts);
            found.sample.append(sample);
            range = [range[0].min(least), range[1].max(most)];
        }
    }
    Ok((found, range))
}
