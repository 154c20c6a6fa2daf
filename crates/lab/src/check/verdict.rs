//! The outcome of a case.

use super::stage::apart;
use pellucid_engine::{Error, Result, methods};
use pellucid_gpu as gpu;

/// Error of the formula that one writes first, in the place of the case and in its unit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Naive {
    /// Computed beside the case, in float32 on the host unless the case states otherwise. It must exceed the bound, or
    /// the case would notice nothing; NaN and infinity count as errors, too.
    Computed(f64),
    /// No formula was computed.
    Stated {
        /// The result of an engine without the precaution, or the reason why no formula fails here.
        why: &'static str,
    },
}

impl Naive {
    /// True if a bound separates the formula from a correct one; `None` where none was computed.
    pub fn is_noticed(&self, bound: f64) -> Option<bool> {
        match self {
            // NaN is beyond any bound.
            Self::Computed(error) => Some(error.is_nan() || *error > bound),
            Self::Stated { .. } => None,
        }
    }
}

/// Errors of a case, and their bound.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Finding {
    /// Largest error found; NaN and infinity are errors too.
    pub error: f64,
    /// Largest error allowed.
    pub bound: f64,
    /// Error of the naive formula.
    pub naive: Naive,
}

impl Finding {
    /// A finding whose naive formula was computed.
    pub(super) fn new(error: f64, bound: f64, naive: f64) -> Self {
        Self { error, bound, naive: Naive::Computed(naive) }
    }

    /// A finding without a formula, see [`Naive::Stated`].
    pub(super) fn stated(error: f64, bound: f64, why: &'static str) -> Self {
        Self { error, bound, naive: Naive::Stated { why } }
    }

    /// Wrong items where none is allowed.
    pub(super) fn counted(wrong: usize, naive: usize) -> Self {
        Self::new(wrong as f64, 0.0, naive as f64)
    }

    /// Components that a device found, and those of the naive formula, against what they should be.
    pub(super) fn apart(found: &[f32], naive: &[f32], wanted: &[f64], bound: f64) -> Self {
        Self::new(apart(found, wanted), bound, apart(naive, wanted))
    }

    /// Pixels that a device found, and those of the naive formula, against what they should be.
    pub(super) fn pixels(found: &[[f32; 4]], naive: &[[f32; 4]], wanted: &[[f64; 4]], bound: f64) -> Self {
        Self::apart(found.as_flattened(), naive.as_flattened(), wanted.as_flattened(), bound)
    }

    /// True if the error is within the bound.
    pub fn passes(&self) -> bool {
        // NaN is not.
        self.error <= self.bound
    }
}

/// A property of a device that keeps it from running something.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
#[non_exhaustive]
pub enum Lack {
    /// Subgroups of a size that methods with tiles can use.
    Subgroups,
    /// Stores from fragment shaders.
    Rasterizer,
    /// Free memory.
    Memory,
    /// Buffers, bindings or images of the size that is needed.
    Limits,
}

impl Lack {
    /// Kinds of lack, in the order in which counts name them.
    pub const ALL: [Self; 4] = [Self::Subgroups, Self::Rasterizer, Self::Memory, Self::Limits];

    /// The missing feature if that is why something was refused; `None` for an error of any other kind.
    pub fn in_error(error: &methods::Error) -> Option<Self> {
        use gpu::Error::{OutOfMemory, TooLarge};
        use methods::Error::{Gpu, NoHardwareRaster, NoSubgroups};
        match error {
            NoSubgroups { .. } => Some(Self::Subgroups),
            NoHardwareRaster { .. } => Some(Self::Rasterizer),
            Gpu(OutOfMemory { .. }) => Some(Self::Memory),
            Gpu(TooLarge { .. }) => Some(Self::Limits),
            _ => None,
        }
    }

    /// The word for it in counts.
    pub fn name(self) -> &'static str {
        match self {
            Self::Subgroups => "subgroups",
            Self::Rasterizer => "rasterizer",
            Self::Memory => "memory",
            Self::Limits => "limits",
        }
    }
}

/// The verdict on a case.
#[derive(Debug)]
pub enum Verdict {
    /// The case was run.
    Found(Finding),
    /// The device lacks something that it needs; the text names it.
    NotApplicable(Lack, String),
    /// The case could not be rendered.
    Failed(Error),
}

impl From<Result<Finding>> for Verdict {
    fn from(result: Result<Finding>) -> Self {
        let error = match result {
            Ok(finding) => return Self::Found(finding),
            Err(Error::Gpu(error)) => methods::Error::from(error).into(),
            Err(error) => error,
        };
        let lack = if let Error::Render(error) = &error { Lack::in_error(error) } else { None };
        match lack {
            Some(lack) => Self::NotApplicable(lack, error.to_string()),
            None => Self::Failed(error),
        }
    }
}

impl Verdict {
    /// Returns the finding, if the case was run.
    pub(super) fn finding(&self) -> Option<Finding> {
        if let Self::Found(finding) = self { Some(*finding) } else { None }
    }

    /// True if the case failed; a case that does not apply neither passed nor failed.
    pub fn is_wrong(&self) -> bool {
        match self {
            Self::Found(finding) => !finding.passes(),
            Self::NotApplicable(..) => false,
            Self::Failed(_) => true,
        }
    }
}

/// The number of cases for each outcome.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Counts {
    /// Cases within their bounds.
    pub passed: usize,
    /// Cases beyond their bounds, or without an image.
    pub failed: usize,
    /// Cases that the device cannot run, by the property that it lacks; only those that occur.
    pub not_applicable: Vec<(Lack, usize)>,
}

impl Counts {
    /// Counts verdicts.
    pub fn new<'a>(verdicts: impl IntoIterator<Item = &'a Verdict>) -> Self {
        let (mut passed, mut failed, mut lacking) = (0, 0, [0; Lack::ALL.len()]);
        for verdict in verdicts {
            match verdict {
                Verdict::NotApplicable(lack, _) => lacking[*lack as usize] += 1,
                verdict if verdict.is_wrong() => failed += 1,
                _ => passed += 1,
            }
        }
        let not_applicable = Lack::ALL.into_iter().zip(lacking).filter(|(_, count)| *count > 0).collect();
        Self { passed, failed, not_applicable }
    }

    /// True if they show that a device can be trusted: something passed and nothing failed.
    pub fn is_good(&self) -> bool {
        self.failed == 0 && self.passed > 0
    }
}

impl std::fmt::Display for Counts {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let sum: usize = self.not_applicable.iter().map(|(_, count)| count).sum();
        write!(out, "{} passed, {} failed, {sum} not applicable", self.passed, self.failed)?;
        let reasons: Vec<String> =
            self.not_applicable.iter().map(|(lack, count)| format!("{} {count}", lack.name())).collect();
        if reasons.is_empty() { Ok(()) } else { write!(out, " ({})", reasons.join(", ")) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_name_the_reasons_and_nothing_passed_is_not_good() {
        let found = |error| Verdict::Found(Finding { error, bound: 1e-6, naive: Naive::Computed(1.0) });
        let lacks = |lack| Verdict::NotApplicable(lack, "not here".into());
        let counts = Counts::new(&[found(0.0), found(1.0), lacks(Lack::Memory), lacks(Lack::Subgroups)]);
        assert_eq!(counts.to_string(), "1 passed, 1 failed, 2 not applicable (subgroups 1, memory 1)");
        assert!(!counts.is_good());
        assert!(Counts::new(&[found(0.0), lacks(Lack::Limits)]).is_good());
        for nothing in [vec![], vec![lacks(Lack::Subgroups)], vec![found(f64::NAN)]] {
            assert!(!Counts::new(&nothing).is_good(), "{nothing:?}");
        }
        assert_eq!(Counts::new(&[found(0.0)]).to_string(), "1 passed, 0 failed, 0 not applicable");
    }

    #[test]
    fn a_naive_formula_is_noticed_beyond_the_bound_alone() {
        let noticed = |error| Naive::Computed(error).is_noticed(1.0);
        assert_eq!([0.5, 1.0, 1.5, f64::NAN].map(noticed), [Some(false), Some(false), Some(true), Some(true)]);
        assert_eq!(Naive::Stated { why: "it would allocate too much" }.is_noticed(1.0), None);
    }

    #[test]
    fn only_what_a_device_lacks_is_a_lack() {
        let device = "a device".to_owned();
        assert_eq!(Lack::in_error(&methods::Error::NoSubgroups { device }), Some(Lack::Subgroups));
        let large = gpu::Error::TooLarge { name: "a buffer".into(), bytes: 2, limit: 1, limit_name: "a limit" };
        assert_eq!(Lack::in_error(&large.into()), Some(Lack::Limits));
        let failed = gpu::Error::Stopped { before: "a submission".into() };
        assert_eq!(Lack::in_error(&failed.into()), None);
    }
}
