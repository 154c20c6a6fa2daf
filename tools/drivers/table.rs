//! Images of one driver against those of another: how many pixels differ, by how much, and whether that is within the
//! bound.

use std::fmt::Write;

use pellucid_core::image::Image;
use pellucid_lab::check::MethodScene;

use crate::bound;
use crate::images::{DriverImages, Outcome};

/// Comparison of an image of a driver with the first driver's.
pub struct Line {
    pub subject: String,
    /// Place of the driver among all.
    pub driver: usize,
    pub verdict: Verdict,
}

pub enum Verdict {
    Compared(Apart),
    NotApplicable(String),
    Failed(String),
}

/// Difference of two images.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Apart {
    pub pixels: usize,
    /// Pixels with any byte that differs, depths and list lengths included.
    pub differ: usize,
    /// Pixels whose color, or A, is beyond the bound.
    pub beyond: usize,
    /// Largest and root mean square difference of R, G, B and A.
    pub largest: f64,
    pub rms: f64,
    pub bound: f64,
}

impl Apart {
    /// Returns the difference of two images of the same size.
    pub fn between(a: &Image, b: &Image, bound: f64) -> Self {
        let mut found = Self { pixels: a.rgba.len(), differ: 0, beyond: 0, largest: 0.0, rms: 0.0, bound };
        let mut squares = 0.0;
        for (i, (x, y)) in a.rgba.iter().zip(&b.rgba).enumerate() {
            let same_color = x.map(f32::to_bits) == y.map(f32::to_bits);
            let same_depth = a.depth[i].to_bits() == b.depth[i].to_bits();
            let count = |image: &Image| image.fragments.as_ref().map(|counts| counts[i]);
            found.differ += usize::from(!same_color || !same_depth || count(a) != count(b));
            let each = x.iter().zip(y).map(|(x, y)| (f64::from(*x) - f64::from(*y)).abs());
            // A value that is no number differs from everything.
            let each: Vec<f64> = each.map(|d| if d.is_nan() { f64::INFINITY } else { d }).collect();
            let most = if same_color { 0.0 } else { each.iter().copied().fold(0.0, f64::max) };
            squares += if same_color { 0.0 } else { each.iter().map(|d| d * d).sum::<f64>() };
            found.beyond += usize::from(most > bound);
            found.largest = found.largest.max(most);
        }
        found.rms = (squares / (4 * found.pixels.max(1)) as f64).sqrt();
        found
    }

    pub fn passes(&self) -> bool {
        self.beyond as f64 <= bound::FLIPS * self.pixels as f64
    }
}

impl Verdict {
    pub fn is_wrong(&self) -> bool {
        match self {
            Self::Compared(apart) => !apart.passes(),
            Self::NotApplicable(_) => false,
            Self::Failed(_) => true,
        }
    }

    fn is_same(&self) -> bool {
        matches!(self, Self::Compared(apart) if apart.differ == 0)
    }
}

/// All drivers but the first against the first, subject by subject.
pub fn lines(subjects: &[&MethodScene], found: &[DriverImages]) -> Vec<Line> {
    let Some((first, others)) = found.split_first() else { return Vec::new() };
    let mut lines = Vec::new();
    for (place, subject) in subjects.iter().enumerate() {
        for (number, other) in others.iter().enumerate() {
            let verdict = verdict(first.outcomes.get(place), other.outcomes.get(place));
            lines.push(Line { subject: subject.name.clone(), driver: number + 1, verdict });
        }
    }
    lines
}

fn verdict(first: Option<&Outcome>, other: Option<&Outcome>) -> Verdict {
    match (first, other) {
        (Some(Outcome::Failed(why)), _) | (_, Some(Outcome::Failed(why))) => Verdict::Failed(why.clone()),
        (_, Some(Outcome::Lacks(what))) => Verdict::NotApplicable(format!("lacks: {what}")),
        (Some(Outcome::Lacks(what)), _) => Verdict::NotApplicable(format!("the first driver lacks: {what}")),
        (Some(Outcome::Image(a, met)), Some(Outcome::Image(b, _))) if a.rgba.len() == b.rgba.len() => {
            Verdict::Compared(Apart::between(a, b, bound::largest_difference(*met)))
        }
        _ => Verdict::Failed("no images of one size".into()),
    }
}

/// Lists the drivers.
pub fn heads(found: &[DriverImages]) -> String {
    let mut text = String::new();
    for (number, found) in found.iter().enumerate() {
        let what = if number == 0 { "compared with" } else { "compared" };
        let _ = writeln!(text, "- {what}: {} ({})", found.device, found.driver);
    }
    text + "\n"
}

/// The table, and below it how many images came out how on each driver. Without `all` those that are the same to the
/// last bit have no row.
pub fn markdown(lines: &[Line], found: &[DriverImages], all: bool) -> String {
    let mut text =
        "| image | driver | pixels that differ | largest | RMS | bound | |\n|---|---|--:|--:|--:|--:|---|\n".to_owned();
    let mut lacks: Vec<String> = Vec::new();
    for line in lines.iter().filter(|line| all || !line.verdict.is_same()) {
        let (subject, driver) = (&line.subject, &found[line.driver].device);
        let _ = match &line.verdict {
            Verdict::Compared(apart) => {
                let share = 100.0 * apart.differ as f64 / apart.pixels.max(1) as f64;
                let Apart { largest, rms, bound, beyond, .. } = apart;
                let word = match (apart.passes(), apart.differ, beyond) {
                    (true, 0, _) => "same bytes".to_owned(),
                    (true, _, 0) => "pass".to_owned(),
                    (true, _, beyond) => format!("pass, {beyond} flipped"),
                    (false, ..) => format!("FAIL, {beyond} beyond the bound"),
                };
                writeln!(
                    text,
                    "| {subject} | {driver} | {share:.1} % | {largest:.1e} | {rms:.1e} | {bound:.1e} | {word} |"
                )
            }
            Verdict::NotApplicable(what) => {
                let number = lacks.iter().position(|known| known == what).unwrap_or_else(|| {
                    lacks.push(what.clone());
                    lacks.len() - 1
                });
                writeln!(text, "| {subject} | {driver} | | | | | not applicable ({}) |", number + 1)
            }
            Verdict::Failed(why) => writeln!(text, "| {subject} | {driver} | | | | | FAIL: {why} |"),
        };
    }
    text.push('\n');
    for (number, what) in lacks.iter().enumerate() {
        let _ = writeln!(text, "({}) {what}", number + 1);
    }
    for (number, other) in found.iter().enumerate().skip(1) {
        let own = || lines.iter().filter(|line| line.driver == number);
        let count = |which: fn(&Verdict) -> bool| own().filter(|line| which(&line.verdict)).count();
        let same = count(Verdict::is_same);
        let apart = count(|verdict| matches!(verdict, Verdict::NotApplicable(_)));
        let wrong = count(Verdict::is_wrong);
        let within = own().count() - same - apart - wrong;
        let device = &other.device;
        let _ = writeln!(
            text,
            "{device}: {same} images with the same bytes, {within} within their bounds, {apart} not applicable, {wrong} wrong"
        );
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::images::Met;

    fn image(red: f32) -> Image {
        Image {
            width: 10,
            height: 100,
            rgba: (0..1000).map(|i| [if i < 3 { red } else { 0.5 }, 0.25, 0.0, 1.0]).collect(),
            depth: vec![1.0; 1000],
            ..Image::default()
        }
    }

    #[test]
    fn differences_are_as_by_hand() {
        let same = Apart::between(&image(0.5), &image(0.5), 1e-6);
        assert_eq!((same.differ, same.beyond, same.largest, same.rms), (0, 0, 0.0, 0.0));
        // Three pixels of 1000 by 0.25 in one of four channels: two may flip.
        let other = Apart::between(&image(0.5), &image(0.25), 1e-6);
        assert_eq!((other.differ, other.beyond, other.largest), (3, 3, 0.25));
        assert!((other.rms - (3.0 * 0.0625 / 4000f64).sqrt()).abs() < 1e-12 && !other.passes());
        assert!(Apart::between(&image(0.5), &image(0.25), 0.25).passes());
        let none = Apart::between(&image(0.5), &image(f32::NAN), 1e-6);
        assert!(none.largest.is_infinite() && !none.passes());
        let mut far = image(0.5);
        far.depth[7] = f32::INFINITY;
        let depths = Apart::between(&image(0.5), &far, 1e-6);
        assert_eq!((depths.differ, depths.beyond), (1, 0));
    }

    #[test]
    fn a_missing_feature_is_neither_a_pass_nor_a_failure() {
        let outcome = |red| Outcome::Image(Box::new(image(red)), Met { longest: 1 });
        let lacks = || Outcome::Lacks("shuffles".into());
        let failed = || Outcome::Failed("lost".into());
        let found = |outcomes| DriverImages { device: "d".into(), driver: "v".into(), outcomes };
        let all = [
            found(vec![outcome(0.5), outcome(0.5), outcome(0.5), outcome(0.5), lacks()]),
            found(vec![outcome(0.5), outcome(0.1), lacks(), failed(), outcome(0.5)]),
        ];
        let subjects = pellucid_lab::check::subjects();
        let subjects: Vec<&MethodScene> = subjects.iter().take(5).collect();
        let lines = lines(&subjects, &all);
        let wrong: Vec<bool> = lines.iter().map(|line| line.verdict.is_wrong()).collect();
        assert_eq!(wrong, [false, true, false, true, false]);
        let text = markdown(&lines, &all, true);
        for part in ["same bytes |", "FAIL, 3 beyond", "not applicable (1)", "FAIL: lost", "(1) lacks: shuffles"] {
            assert!(text.contains(part), "{part}: {text}");
        }
        assert!(
            text.contains("d: 1 images with the same bytes, 0 within their bounds, 2 not applicable, 2 wrong"),
            "{text}"
        );
        let short = markdown(&lines, &all, false);
        assert!(!short.contains("| same bytes |"), "{short}");
    }
}
