//! `check`: numerically hard cases on a device, each with a known answer and a bound that is derived beside it.
//!
//! One list serves the command and the tests. A case knows how far a naive formula would be off, too: it must be beyond the
//! bound, or the case would notice nothing.

mod approximate;
mod cameras;
mod cuts;
mod discs;
mod machinery;
mod moved;
mod naive;
mod opaque;
mod prepared;
mod same;
mod shadows;
mod sizes;
mod soft;
mod spbr;
mod stage;
mod stochastic;
mod subjects;
mod surfaces;
mod table;

use pellucid_engine::gpu::{self, Device};
use pellucid_engine::scene::Method;
use pellucid_engine::{Error, io, methods, scene};

pub use same::{Difference, difference};
pub use stage::Stage;
pub use subjects::{Follows, Subject, subjects};
pub use table::{Group, groups, markdown};

/// A hard case.
pub struct Case {
    /// Method and case, as in `abuffer/faint-layers`.
    pub name: String,
    /// What is rendered or computed, and what is known of the answer.
    pub about: &'static str,
    run: Run,
}

type Run = Box<dyn Fn(&mut Stage) -> Result<Finding, Trouble>>;

/// Why a case has no finding.
#[derive(Debug)]
enum Trouble {
    /// The device lacks what it needs.
    Lacks(String),
    /// It could not be rendered.
    Failed(Error),
}

impl From<methods::Error> for Trouble {
    /// A device without subgroups has no methods that go through tiles, one without writes from fragment shaders no
    /// rasteriser; what a case of this size can't bind or allocate, a device has no room for. Everything else is wrong.
    fn from(error: methods::Error) -> Self {
        if is_lack(&error) { Self::Lacks(error.to_string()) } else { Self::Failed(error.into()) }
    }
}

/// Whether an error says that the device lacks what a method needs: subgroups, the rasteriser's stores, room.
pub fn is_lack(error: &methods::Error) -> bool {
    use gpu::Error::{OutOfMemory, TooLarge};
    use methods::Error::{Gpu, NoHardwareRaster, NoSubgroups};
    matches!(error, NoSubgroups { .. } | NoHardwareRaster { .. } | Gpu(OutOfMemory { .. } | TooLarge { .. }))
}

impl From<gpu::Error> for Trouble {
    fn from(error: gpu::Error) -> Self {
        methods::Error::from(error).into()
    }
}

impl From<io::Error> for Trouble {
    fn from(error: io::Error) -> Self {
        Self::Failed(error.into())
    }
}

impl From<scene::Error> for Trouble {
    fn from(error: scene::Error) -> Self {
        Self::Failed(error.into())
    }
}

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
    Failed(Error),
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
    let families = [
        discs::cases(),
        approximate::cases(),
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
        cuts::cases(),
        machinery::cases(),
    ];
    families.into_iter().flatten().collect()
}

/// A case of its own.
fn one(name: &str, about: &'static str, run: impl Fn(&mut Stage) -> Result<Finding, Trouble> + 'static) -> Case {
    Case { name: name.to_owned(), about, run: Box::new(run) }
}

/// The same case for each of some methods.
fn each(
    methods: &[Method],
    name: &str,
    about: &'static str,
    run: fn(&mut Stage, Method) -> Result<Finding, Trouble>,
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
            Err(Trouble::Lacks(what)) => Verdict::NotApplicable(what),
            Err(Trouble::Failed(error)) => Verdict::Failed(error),
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
