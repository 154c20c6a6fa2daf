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
mod prelude;
mod prepared;
mod released;
mod same;
mod samples;
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

use pellucid_engine::Result;
use pellucid_scene::Method;

pub use document::document;
pub use released::{Regression, regression, released, released_table};
pub use same::{Difference, difference};
pub use stage::CaseRenderer;
pub use subjects::{Follows, MethodScene, compared, subjects};
pub use table::{Group, groups, markdown};
pub use verdict::{Counts, Finding, Lack, Naive, Verdict};

/// A hard case.
pub struct Case {
    /// Method and case, as in `abuffer/faint-layers`.
    pub name: String,
    /// A description of the computation, and of the known answer.
    pub about: &'static str,
    run: CaseCheck,
}

type CaseResult = Result<Finding>;
type CaseCheck = Box<dyn Fn(&mut CaseRenderer) -> Verdict>;

/// All cases, family by family. No two have the same name.
pub fn cases() -> Vec<Case> {
    joined([
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
        samples::cases(),
        prepared::cases(),
        colored::cases(),
        clipped::cases(),
        cuts::cases(),
        stored::cases(),
        gaussians::cases(),
        machinery::cases(),
    ])
}

/// A case of its own.
fn one<V: Into<Verdict>>(name: &str, about: &'static str, run: impl Fn(&mut CaseRenderer) -> V + 'static) -> Case {
    Case { name: name.to_owned(), about, run: Box::new(move |stage| run(stage).into()) }
}

/// A case of each of some methods, which [`Each::about`] makes.
struct Each<'a, M, V> {
    methods: &'a [M],
    name: &'a str,
    run: fn(&mut CaseRenderer, M) -> V,
}

fn each<'a, M, V>(methods: &'a [M], name: &'a str, run: fn(&mut CaseRenderer, M) -> V) -> Each<'a, M, V> {
    Each { methods, name, run }
}

impl<M: Copy + Into<Method> + 'static, V: Into<Verdict> + 'static> Each<'_, M, V> {
    /// The cases, with the description that they share.
    fn about(self, about: &'static str) -> Vec<Case> {
        let Self { methods, name, run } = self;
        let name_of = |method: M| format!("{}/{name}", method.into().name());
        methods.iter().map(|&method| one(&name_of(method), about, move |stage| run(stage, method))).collect()
    }
}

/// The cases of some lists in one.
fn joined(lists: impl IntoIterator<Item = Vec<Case>>) -> Vec<Case> {
    lists.into_iter().flatten().collect()
}

impl Case {
    /// Runs the case.
    pub fn run(&self, stage: &mut CaseRenderer) -> Verdict {
        (self.run)(stage)
    }
}
