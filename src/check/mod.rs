//! `check`: numerically hard cases on a device, each with a known answer and a bound that is derived beside it.
//!
//! One list serves the command and the tests. A case knows how far a naive formula would be off, too: it must be beyond the
//! bound, or the case would notice nothing.

mod discs;
mod stage;

use crate::gpu::Device;
use crate::methods;
use crate::scene::Method;

pub use stage::Stage;

/// A hard case.
pub struct Case {
    /// Method and case, as in `abuffer/faint-layers`.
    pub name: String,
    /// What is rendered or computed, and what is known of the answer.
    pub about: &'static str,
    run: Run,
}

type Run = Box<dyn Fn(&mut Stage) -> Result<Finding, methods::Error>>;

/// What became of a case.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Finding {
    /// Largest error found; NaN and infinity are errors too.
    pub error: f64,
    /// Largest error allowed.
    pub bound: f64,
    /// Error of the naive formula in the same place, in float32 on the host: above the bound.
    pub naive: f64,
}

impl Finding {
    /// Whether the error is within the bound.
    pub fn passes(&self) -> bool {
        // NaN is not.
        self.error <= self.bound
    }
}

/// The verdict on a case.
#[derive(Debug)]
pub enum Verdict {
    /// It was run.
    Found(Finding),
    /// The device lacks what it needs.
    NotApplicable(String),
    /// It could not be rendered.
    Failed(methods::Error),
}

impl Verdict {
    /// Whether nothing is wrong; what does not apply is neither passed nor wrong.
    pub fn is_wrong(&self) -> bool {
        match self {
            Self::Found(finding) => !finding.passes(),
            Self::NotApplicable(_) => false,
            Self::Failed(_) => true,
        }
    }
}

/// All cases, family by family. No two have the same name.
pub fn cases() -> Vec<Case> {
    [discs::cases()].into_iter().flatten().collect()
}

/// The same case for each of some methods.
fn each(
    methods: &[Method],
    name: &str,
    about: &'static str,
    run: fn(&mut Stage, Method) -> Result<Finding, methods::Error>,
) -> Vec<Case> {
    let case = |method: &Method| {
        let method = *method;
        Case { name: format!("{}/{name}", method.name()), about, run: Box::new(move |stage| run(stage, method)) }
    };
    methods.iter().map(case).collect()
}

impl Case {
    /// Runs the case.
    pub fn run(&self, stage: &mut Stage) -> Verdict {
        match (self.run)(stage) {
            Ok(finding) => Verdict::Found(finding),
            // A device without shuffles has no methods that go through tiles; one without memory for an allocation can't do it.
            Err(error @ methods::Error::NoSubgroups { .. }) => Verdict::NotApplicable(error.to_string()),
            Err(error) => Verdict::Failed(error),
        }
    }
}

/// A stage on a device.
///
/// # Errors
/// A device that has no memory for the first buffers.
pub fn stage(device: &Device) -> Result<Stage, methods::Error> {
    Stage::new(device)
}
