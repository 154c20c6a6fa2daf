//! The limits that --fail-above, --fail-below and --fail-slower of `pellucid compare` set on a measurement.

use pellucid_engine::Result;
use pellucid_scene as scene;

use super::console::Console;

/// A metric and the largest or the smallest value it may have.
pub struct Limit {
    option: &'static str,
    pub metric: String,
    value: f64,
    /// Compares a measured value with the limit; true if it breaks the limit.
    breaks: fn(&f64, &f64) -> bool,
    /// The word for the side on which a value breaks it.
    side: &'static str,
}

impl Limit {
    /// The values of --fail-above and --fail-below.
    pub fn all(above: &[String], below: &[String]) -> Result<Vec<Self>, scene::Error> {
        let above = above.iter().map(|text| Self::parse("--fail-above", text, f64::gt, "above"));
        let below = below.iter().map(|text| Self::parse("--fail-below", text, f64::lt, "below"));
        above.chain(below).collect()
    }

    fn parse(
        option: &'static str,
        text: &str,
        breaks: fn(&f64, &f64) -> bool,
        side: &'static str,
    ) -> Result<Self, scene::Error> {
        let problem = || scene::Error::Usage(format!("{option} {text}: expected METRIC=VALUE, as in rmse=0.01"));
        // From the right: the names of passes may hold anything but end before the number.
        let (metric, value) = text.rsplit_once('=').ok_or_else(problem)?;
        let value = value.trim().parse().ok().filter(|value: &f64| !value.is_nan()).ok_or_else(problem)?;
        Ok(Self { option, metric: metric.trim().to_owned(), value, breaks, side })
    }

    /// Returns true if a measured value breaks the limit, and reports that on standard error.
    pub fn is_broken_by(&self, measured: f64, console: Console) -> bool {
        let broken = (self.breaks)(&measured, &self.value);
        if broken {
            console
                .report(format_args!("error: {} is {measured}, {} the allowed {}", self.metric, self.side, self.value));
        }
        broken
    }

    /// The error of a limit that can't be checked.
    pub fn unusable(&self, why: &str) -> pellucid_engine::Error {
        usage(format!("{} {}: {why}", self.option, self.metric))
    }
}

/// The largest ratio by which a pass may get slower.
pub struct Slower {
    /// The one pass that it is about; `None`: every pass that is long enough, and the frame.
    pub pass: Option<String>,
    ratio: f64,
}

impl Slower {
    /// The value of --fail-slower.
    pub fn parse(text: &str) -> Result<Self, scene::Error> {
        let (pass, ratio) = match text.rsplit_once('=') {
            Some((pass, ratio)) => (Some(pass.trim().to_owned()), ratio),
            None => (None, text),
        };
        let number = ratio.trim().parse().ok().filter(|ratio: &f64| !ratio.is_nan());
        let ratio = number.ok_or_else(|| {
            scene::Error::Usage(format!("--fail-slower {text}: expected RATIO or PASS=RATIO, as in 1.5"))
        })?;
        Ok(Self { pass, ratio })
    }

    /// Returns true if even the lower end of an interval of B/A breaks the limit, and reports that on standard error.
    pub fn is_broken_by(&self, name: &str, [low, high]: [f64; 2], console: Console) -> bool {
        let broken = low > self.ratio;
        if broken {
            console.report(format_args!(
                "error: {name} is {low:.3} to {high:.3} times as slow, above the allowed {}",
                self.ratio
            ));
        }
        broken
    }

    /// The error of a limit that can't be checked.
    pub fn unusable(&self, why: &str) -> pellucid_engine::Error {
        let pass = self.pass.as_ref().map_or(String::new(), |pass| format!("{pass}="));
        usage(format!("--fail-slower {pass}{}: {why}", self.ratio))
    }
}

/// An error of the command line.
pub fn usage(problem: impl Into<String>) -> pellucid_engine::Error {
    scene::Error::Usage(problem.into()).into()
}
