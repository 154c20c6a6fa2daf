//! What is left out while things move, so that a frame keeps to its time: samples, ensembles, layers.

use crate::scene::{Method, PeelLayers, Spbr, SpbrSimplified, Stochastic};

/// Samples, ensembles or layers of a frame whose cost nobody knows yet.
const FIRST: u32 = 4;

/// How many samples, ensembles or layers a method takes, if its image only gets better with their number.
pub fn steps(method: &Method) -> Option<u32> {
    match method {
        Method::Stochastic(Stochastic { samples, .. }) => Some(*samples),
        Method::PeelLayers(PeelLayers { layers, .. }) => Some(*layers),
        method => method.ensembles(),
    }
}

/// The method with so many of them.
fn with_steps(method: Method, steps: u32) -> Method {
    match method {
        Method::Stochastic(settings) => Method::Stochastic(Stochastic { samples: steps, ..settings }),
        Method::PeelLayers(settings) => Method::PeelLayers(PeelLayers { layers: steps, ..settings }),
        Method::Spbr(settings) => Method::Spbr(Spbr { ensembles: steps, ..settings }),
        Method::SpbrSimplified(settings) => Method::SpbrSimplified(SpbrSimplified { ensembles: steps, ..settings }),
        other => other,
    }
}

/// What a frame took, and with how many samples, ensembles or layers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cost {
    /// Milliseconds.
    pub ms: f64,
    /// Of [`steps`].
    pub steps: u32,
}

/// The method for a frame that is to take at most `budget_ms`: with as many steps as fit by the last frame's cost, at least one,
/// never more than the method has. Methods without steps stay as they are.
pub fn within(method: Method, last: Option<Cost>, budget_ms: f64) -> Method {
    let Some(most) = steps(&method) else { return method };
    let fitting = match last {
        Some(Cost { ms, steps }) if ms > 0.0 => (f64::from(steps) * budget_ms / ms) as u32,
        _ => FIRST,
    };
    with_steps(method, fitting.clamp(1, most))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn as_many_samples_as_fit() {
        let method = Method::Stochastic(Stochastic { samples: 64, ..Default::default() });
        let taken = |last, budget| steps(&within(method, last, budget));
        assert_eq!(taken(None, 33.0), Some(4));
        assert_eq!(taken(Some(Cost { ms: 128.0, steps: 64 }), 33.0), Some(16));
        assert_eq!(taken(Some(Cost { ms: 8.0, steps: 16 }), 33.0), Some(64));
        assert_eq!(taken(Some(Cost { ms: 1e9, steps: 64 }), 33.0), Some(1));
        assert_eq!(taken(Some(Cost { ms: 128.0, steps: 64 }), 0.0), Some(1));
    }

    #[test]
    fn exact_methods_stay_as_they_are() {
        let method = Method::ABuffer(Default::default());
        assert_eq!(within(method, Some(Cost { ms: 1e3, steps: 1 }), 33.0), method);
        for method in [Method::PeelLayers(Default::default()), Method::Spbr(Default::default())] {
            assert_eq!(steps(&within(method, None, 33.0)), Some(4));
            assert_eq!(within(method, None, 33.0).name(), method.name());
        }
    }
}
