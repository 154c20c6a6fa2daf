//! Budget of a GPU's resources for every pipeline, and the exceptions by name (tools/gpu_shape/budget.txt).

use crate::compile::Shape;
use crate::record::Recorded;

/// Waves that a SIMD must hold, of 16.
const LEAST_WAVES: f64 = 8.0;
/// Bytes of code: what RDNA's instruction caches hold.
const MOST_CODE: f64 = 32.0 * 1024.0;

/// Exceptions from the budget.
const EXCEPTIONS: &str = include_str!("budget.txt");

/// Resources that a pass may take beyond the budget.
#[derive(Debug, Clone, PartialEq)]
struct Exception<'a> {
    label: &'a str,
    least_waves: f64,
    most_scratch: f64,
    most_spilled: f64,
    most_code: f64,
}

impl Exception<'_> {
    /// Budget of a pass without an exception.
    const NONE: Exception<'static> =
        Exception { label: "", least_waves: LEAST_WAVES, most_scratch: 0.0, most_spilled: 0.0, most_code: MOST_CODE };
}

/// Lines of `label waves=4 scratch=512 spilled=3 code-kib=40 # why`, each key if it is an exception.
fn parse(text: &str) -> Result<Vec<Exception<'_>>, String> {
    let mut found = Vec::new();
    for (number, line) in (1..).zip(text.lines()) {
        let wrong = |what: &str| format!("tools/gpu_shape/budget.txt:{number}: {what}");
        let (line, why) = line.split_once('#').unwrap_or((line, ""));
        let mut words = line.split_whitespace();
        let Some(label) = words.next() else { continue };
        if why.trim().is_empty() {
            return Err(wrong("an exception has its reason behind a #"));
        }
        let mut exception = Exception { label, ..Exception::NONE };
        for word in words {
            let number = |text: &str| text.parse::<f64>().map_err(|_| wrong(&format!("{word}: expected a number")));
            match word.split_once('=') {
                Some(("waves", value)) => exception.least_waves = number(value)?,
                Some(("scratch", value)) => exception.most_scratch = number(value)?,
                Some(("spilled", value)) => exception.most_spilled = number(value)?,
                Some(("code-kib", value)) => exception.most_code = number(value)? * 1024.0,
                _ => return Err(wrong(&format!("{word}: expected waves=, scratch=, spilled= or code-kib="))),
            }
        }
        found.push(exception);
    }
    Ok(found)
}

/// A line for each pipeline that is beyond the budget, and for each exception that nothing needs.
pub fn beyond(recorded: &[Recorded], shapes: &[Option<Shape>]) -> Result<Vec<String>, String> {
    let all = || recorded.iter().map(|recorded| recorded.label.as_str()).zip(shapes);
    let crashed = all().filter(|(_, shape)| shape.is_none());
    let mut lines: Vec<String> = crashed.map(|(label, _)| format!("{label}: the driver crashes: its fault")).collect();
    let (labels, shapes): (Vec<_>, Vec<_>) = all().filter_map(|(label, shape)| Some((label, (*shape)?))).unzip();
    lines.extend(compared(&parse(EXCEPTIONS)?, &labels, &shapes));
    Ok(lines)
}

fn compared(exceptions: &[Exception<'_>], labels: &[&str], shapes: &[Shape]) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for (label, shape) in labels.iter().zip(shapes) {
        let exception = exceptions.iter().find(|e| e.label == *label).unwrap_or(&Exception::NONE);
        for what in over(exception, shape) {
            let line = format!("{label}: {what}");
            if !lines.contains(&line) {
                lines.push(line);
            }
        }
    }
    for exception in exceptions {
        let of = || labels.iter().zip(shapes).filter(|(label, _)| **label == exception.label).map(|(_, shape)| shape);
        if of().next().is_none() {
            lines.push(format!("{}: an exception for a pass that was not recorded", exception.label));
        } else if of().all(|shape| over(&Exception::NONE, shape).is_empty()) {
            lines.push(format!("{}: an exception that the pass no longer needs", exception.label));
        }
    }
    lines
}

fn over(allowed: &Exception<'_>, shape: &Shape) -> Vec<String> {
    let spilled = shape.spilled_vgprs + shape.spilled_sgprs;
    let code = shape.code_bytes / 1024.0;
    let found = [
        (shape.waves < allowed.least_waves)
            .then(|| format!("{} waves of 16, at least {} wanted", shape.waves, allowed.least_waves)),
        (shape.scratch_bytes > allowed.most_scratch)
            .then(|| format!("{} bytes of scratch a lane, {} allowed", shape.scratch_bytes, allowed.most_scratch)),
        (spilled > allowed.most_spilled)
            .then(|| format!("{spilled} registers spilled, {} allowed", allowed.most_spilled)),
        (shape.code_bytes > allowed.most_code)
            .then(|| format!("{code:.1} KiB of code, {} allowed", allowed.most_code / 1024.0)),
    ];
    found.into_iter().flatten().collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const GOOD: Shape = Shape {
        lanes: 32,
        vgprs: 64.0,
        sgprs: 32.0,
        spilled_vgprs: 0.0,
        spilled_sgprs: 0.0,
        scratch_bytes: 0.0,
        lds_bytes: 0.0,
        waves: 16.0,
        code_bytes: 4096.0,
        latency: 1.0,
        inverse_throughput: 1.0,
        compile_ms: 1.0,
    };

    #[test]
    fn pipelines_beyond_the_budget_are_listed() {
        let bad = Shape { waves: 7.0, scratch_bytes: 16.0, spilled_sgprs: 2.0, code_bytes: 33.0 * 1024.0, ..GOOD };
        let found = compared(&[], &["a/b", "c/d", "c/d"], &[GOOD, bad, bad]);
        assert_eq!(
            found,
            [
                "c/d: 7 waves of 16, at least 8 wanted",
                "c/d: 16 bytes of scratch a lane, 0 allowed",
                "c/d: 2 registers spilled, 0 allowed",
                "c/d: 33.0 KiB of code, 32 allowed",
            ]
        );
    }

    #[test]
    fn an_exception_goes_as_far_as_it_says_and_must_be_needed() {
        let text = "# comment\n\nc/d waves=7 scratch=16 # its list\n";
        let exceptions = parse(text).expect("well formed");
        let few = Shape { waves: 7.0, scratch_bytes: 16.0, ..GOOD };
        assert_eq!(compared(&exceptions, &["c/d"], &[few]), Vec::<String>::new());
        assert_eq!(compared(&exceptions, &["c/d"], &[Shape { waves: 6.0, ..few }]).len(), 1);
        assert!(compared(&exceptions, &["c/d"], &[GOOD])[0].contains("no longer needs"));
        assert!(compared(&exceptions, &["a/b"], &[GOOD])[0].contains("not recorded"));
        for wrong in ["a/b waves=x # why", "a/b size=3 # why", "a/b waves=3", "a/b waves # why"] {
            assert!(parse(wrong).is_err_and(|text| text.contains("budget.txt:1: ")), "{wrong}");
        }
        parse(EXCEPTIONS).expect("the one in earnest");
    }
}
