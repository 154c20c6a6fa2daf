//! `check`: numerically hard cases on a device, each with a known answer and a bound that is derived beside it.
//!
//! One list serves the command and the tests. A case knows how far a naive formula would be off, too: it must be beyond
//! the bound, or the case would notice nothing.

mod approximate;
mod cameras;
mod clipped;
mod colored;
mod cuts;
mod discs;
mod document;
mod fading;
mod gaussians;
mod lists;
mod machinery;
mod mlab;
mod moved;
mod naive;
mod opaque;
mod prepared;
mod released;
mod same;
mod shadows;
mod sizes;
mod soft;
mod spbr;
mod stage;
mod stochastic;
mod stored;
mod subjects;
mod surfaces;
mod table;
mod verdict;

use pellucid_engine::gpu::Device;
use pellucid_engine::methods;
use pellucid_engine::scene::Method;

pub use document::document;
pub use released::{Regression, regression, released, released_table};
pub use same::{Difference, difference};
pub use stage::Stage;
pub use subjects::{Follows, Subject, subjects};
pub use table::{Group, groups, markdown};
use verdict::Trouble;
pub use verdict::{Counts, Finding, Lack, Naive, Verdict};

/// A hard case.
pub struct Case {
    /// Method and case, as in `abuffer/faint-layers`.
    pub name: String,
    /// A description of the computation, and of the known answer.
    pub about: &'static str,
    run: Run,
}

type Run = Box<dyn Fn(&mut Stage) -> Result<Finding, Trouble>>;

/// All cases, family by family. No two have the same name.
pub fn cases() -> Vec<Case> {
    let families = [
        discs::cases(),
        approximate::cases(),
        fading::cases(),
        mlab::cases(),
        stochastic::cases(),
        spbr::cases(),
        soft::cases(),
        opaque::cases(),
        surfaces::cases(),
        shadows::cases(),
        moved::cases(),
        cameras::cases(),
        sizes::cases(),
        prepared::cases(),
        colored::cases(),
        clipped::cases(),
        cuts::cases(),
        stored::cases(),
        gaussians::cases(),
        machinery::cases(),
    ];
    families.into_iter().flatten().collect()
}

/// A case of its own.
fn one(name: &str, about: &'static str, run: impl Fn(&mut Stage) -> Result<Finding, Trouble> + 'static) -> Case {
    Case { name: name.to_owned(), about, run: Box::new(run) }
}

/// Makes a case for each of some methods.
fn each<M: Copy + Into<Method> + 'static>(
    methods: &[M],
    name: &str,
    about: &'static str,
    run: fn(&mut Stage, M) -> Result<Finding, Trouble>,
) -> Vec<Case> {
    let case = |method: &M| {
        let method = *method;
        Case { name: format!("{}/{name}", method.into().name()), about, run: Box::new(move |stage| run(stage, method)) }
    };
    methods.iter().map(case).collect()
}

impl Case {
    /// Runs the case.
    pub fn run(&self, stage: &mut Stage) -> Verdict {
        (self.run)(stage).into()
    }
}

/// A stage on a device.
///
/// # Errors
/// A device that has no memory for the first buffers.
pub fn stage(device: &Device) -> Result<Stage, methods::Error> {
    Stage::new(device)
}
