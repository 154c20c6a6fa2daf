//! The page docs/which-method.md.

use std::collections::BTreeMap;
use std::fmt::Write;

use pellucid_session::choice::EXACT;

use crate::figure::{self, scenes, targets};
use crate::map::{ERRORS, Verdict, between, fastest, front, is_new, verdicts};
use crate::rows::{Measured, Row, Study};

const HEAD: &str = include_str!("page.md");
/// The folder of the figures, beside the page.
pub const FIGURES: &str = "images/which-method";

/// The figures, by the names of their files.
pub fn figures(studies: &[Study]) -> Vec<(String, String)> {
    studies.iter().map(|study| (figure_name(study), figure::svg(study))).collect()
}

fn figure_name(study: &Study) -> String {
    study.device.file_name().replace(".jsonl", ".svg")
}

/// The whole page.
pub fn text(studies: &[Study]) -> String {
    let mut text = HEAD.to_owned();
    for study in studies {
        text.push('\n');
        text.push_str(&of_driver(study));
    }
    text
}

fn of_driver(study: &Study) -> String {
    let device = &study.device;
    let mut text = format!("## {} ({})\n\n", device.device, device.driver);
    let [width, height] = device.size;
    let settings: usize = study.cases.iter().map(|measured| measured.rows.len()).sum();
    let missing: Vec<String> = study.cases.iter().filter(|measured| !measured.done).map(named).collect();
    let _ = write!(
        text,
        "pellucid {}, {width} × {height} pixels, medians of {} frames: {settings} settings in {} cases.",
        device.pellucid,
        device.frames,
        study.cases.len()
    );
    if !missing.is_empty() {
        let _ = write!(text, " Not all settings are measured of {}.", missing.join(", "));
    }
    let _ = writeln!(text, "\n\n![The map of this driver]({FIGURES}/{})\n", figure_name(study));
    let _ = writeln!(text, "### Over all scenes\n\n{}", over_all(study));
    let _ = writeln!(text, "### Scene by scene\n\n{}", by_scene(study));
    let _ = writeln!(text, "### Between `weighted` and exact\n\n{}", between_table(study));
    let _ = write!(text, "### The cases\n\n{}", cases(study));
    text
}

fn named(measured: &Measured) -> String {
    format!("{} at {}", measured.case.scene, measured.case.target)
}

fn heads(first: &[&str]) -> String {
    let mut text = String::from("|");
    first.iter().for_each(|head| _ = write!(text, " {head} |"));
    ERRORS.iter().for_each(|(_, name)| _ = write!(text, " {name} |"));
    text.push_str("\n|");
    first.iter().for_each(|_| text.push_str("---|"));
    ERRORS.iter().for_each(|_| text.push_str("---|"));
    text.push('\n');
    text
}

fn over_all(study: &Study) -> String {
    let mut text = heads(&["mean list"]);
    for target in targets(study) {
        let cases: Vec<&Measured> = study.cases.iter().filter(|measured| measured.case.target == target).collect();
        let _ = write!(text, "| {target} |");
        for (error, _) in ERRORS {
            let best = verdicts(&cases, error).into_iter().next();
            let _ = write!(text, " {} |", best.map_or_else(String::new, |best| verdict(&best, cases.len())));
        }
        text.push('\n');
    }
    text
}

fn verdict(best: &Verdict, scenes: usize) -> String {
    let name = name(&Row(best.key.clone(), 0.0, 0.0, 0));
    let fits = if best.fits < scenes { format!(", {} of {scenes}", best.fits) } else { String::new() };
    format!("{name}<br>{:.2} of exact, {}{fits}", best.of_exact, mib(best.bytes))
}

/// Method and step, as in `hybrid` k=8.
fn name(row: &Row) -> String {
    format!("`{}` {}", row.family(), row.step()).trim_end().to_owned()
}

fn mib(bytes: u64) -> String {
    let mib = bytes as f64 / f64::from(1 << 20);
    if mib < 10.0 { format!("{mib:.1} MiB") } else { format!("{mib:.0} MiB") }
}

fn by_scene(study: &Study) -> String {
    let mut text = heads(&["scene", "mean list"]);
    for scene in scenes(study) {
        for target in targets(study) {
            let Some(measured) = study.find(&scene, target) else { continue };
            let Some(exact) = fastest(measured, EXACT) else { continue };
            let _ = write!(text, "| {scene} | {} |", Short(measured.case.mean));
            let mut before = None;
            for (error, _) in ERRORS {
                let row = fastest(measured, error);
                let cell = match row {
                    // As on its left.
                    Some(row) if before == Some(row.key()) => "←".to_owned(),
                    Some(row) => format!("{} {:.2}", name(row), row.ms() / exact.ms()),
                    None => String::new(),
                };
                before = row.map(Row::key);
                let _ = write!(text, " {cell} |");
            }
            text.push('\n');
        }
    }
    text
}

/// A number with three digits at most, as in 49.7 or 512.
struct Short(f64);

impl std::fmt::Display for Short {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let decimals = if self.0 < 100.0 { 1 } else { 0 };
        write!(f, "{:.decimals$}", self.0)
    }
}

/// The front between `weighted` and the exact image by scene: which methods are on it, and the new ones among them.
fn between_table(study: &Study) -> String {
    let mut text = String::from("| scene | mean list | on the front, from fast to accurate |\n|---|---|---|\n");
    let mut scenes_with = 0;
    for scene in scenes(study) {
        let mut has_new = false;
        for target in targets(study) {
            let Some(measured) = study.find(&scene, target) else { continue };
            let rows = between(measured);
            has_new |= rows.iter().any(|row| is_new(row));
            let bold = |row: &&Row| if is_new(row) { format!("**{}**", name(row)) } else { name(row) };
            let names: Vec<String> = rows.iter().map(bold).collect();
            let names = if names.is_empty() { nothing_between(measured) } else { names.join(", ") };
            let _ = writeln!(text, "| {scene} | {} | {names} |", Short(measured.case.mean));
        }
        scenes_with += usize::from(has_new);
    }
    let _ = writeln!(
        text,
        "\nOn {scenes_with} of {} scenes one of `moments`, `wavelet`, `mlab` and `hybrid` with `tail=moments` is on the front (bold).",
        scenes(study).len()
    );
    let nearest = nearest(study);
    if !nearest.is_empty() {
        let _ = writeln!(text, "\nHow far the others are from it, at best: {nearest}.");
    }
    text
}

/// Returns the reason why no approximation is between the two: the exact image takes no longer.
fn nothing_between(measured: &Measured) -> String {
    let (Some(exact), Some(first)) = (fastest(measured, EXACT), front(measured).into_iter().next()) else {
        return "the exact image was not measured".to_owned();
    };
    if first.rmse() <= EXACT {
        return format!("nothing: {} is the fastest of all", name(exact));
    }
    format!("nothing: {} takes {:.2} of the time of {}", name(first), first.ms() / exact.ms(), name(exact))
}

/// Lists, for each new method, the setting that comes nearest to the front: its time over that of the fastest setting
/// which is as accurate.
fn nearest(study: &Study) -> String {
    let mut least: BTreeMap<String, (f64, String)> = BTreeMap::new();
    for measured in &study.cases {
        for row in measured.rows.iter().filter(|row| is_new(row)) {
            let Some(best) = fastest(measured, row.rmse().max(EXACT)) else { continue };
            let ratio = row.ms() / best.ms();
            let entry = least.entry(row.family()).or_insert((f64::INFINITY, String::new()));
            if ratio < entry.0 {
                *entry = (ratio, named(measured));
            }
        }
    }
    let beaten = least.into_iter().filter(|(_, (ratio, _))| *ratio > 1.0);
    beaten.map(|(family, (ratio, place))| format!("`{family}` {ratio:.2} ({place})")).collect::<Vec<_>>().join(", ")
}

/// The scenes as they were drawn.
fn cases(study: &Study) -> String {
    let mut text = String::from(
        "| scene | points | mean list | longest | covered pixels | radius × | opacity | exact, ms | settings |\n\
         |---|--:|--:|--:|--:|--:|--:|--:|--:|\n",
    );
    for Measured { case, rows, .. } in &study.cases {
        let opacity = case.opacity.map_or_else(|| "own".to_owned(), |opacity| format!("{opacity:.4}"));
        let exact = rows.iter().filter(|row| row.rmse() <= EXACT).map(Row::ms).fold(f64::INFINITY, f64::min);
        let exact = if exact.is_finite() { format!("{exact:.2}") } else { String::new() };
        let (scene, points, longest, covered, factor) =
            (&case.scene, case.points, case.longest, case.covered, case.radius_factor);
        let _ = writeln!(
            text,
            "| {scene} | {points} | {} | {longest} | {covered} | {factor:.3} | {opacity} | {exact} | {} |",
            Short(case.mean),
            rows.len()
        );
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::map::tests::case;
    use crate::rows::Device;

    #[test]
    fn a_page_says_what_was_found() {
        let device = Device {
            device: "llvmpipe".to_owned(),
            driver: "Mesa 1".to_owned(),
            kind: "CPU".to_owned(),
            pellucid: "0.1.0".to_owned(),
            size: [64, 48],
            frames: 3,
        };
        let tori = [
            ("abuffer", 0.0, 10.0),
            ("mlab method.nodes=4", 0.015, 4.0),
            ("moments method.moments=4", 0.03, 7.0),
            ("weighted", 0.1, 2.0),
        ];
        let stack = [("abuffer", 0.0, 4.0), ("weighted", 0.1, 5.0)];
        let mut cases = vec![case("tori", 50, &tori), case("stack", 50, &stack)];
        cases[1].done = false;
        let study = Study { device, cases };
        let text = text(std::slice::from_ref(&study));
        let parts = [
            "## llvmpipe (Mesa 1)",
            "64 × 48 pixels, medians of 3 frames: 6 settings in 2 cases. Not all settings are measured of stack at 50.",
            "![The map of this driver](images/which-method/llvmpipe-mesa-1.svg)",
            "| mean list | 0.05 | 0.03 | 0.02 | 0.01 | 0.005 | 0.002 | 1e-4 | exact |",
            // Over all: mlab fits on one scene of two, which is not most of them.
            "| 50 | `abuffer`<br>1.00 of exact, 9.5 MiB |",
            "| tori | 50.0 | `mlab` nodes=4 0.40 | ← | ← | `abuffer` 1.00 | ← | ← | ← | ← |",
            "| tori | 50.0 | **`mlab` nodes=4** |",
            "| stack | 50.0 | nothing: `abuffer` is the fastest of all |",
            "On 1 of 2 scenes",
            // As accurate as moments is mlab, in 4 of 7 ms.
            "at best: `moments` 1.75 (tori at 50).",
            "| tori | 1000 | 50.0 | 100 | 100 | 1.000 | own | 10.00 | 4 |",
        ];
        for part in parts {
            assert!(text.contains(part), "{part} in {text}");
        }
        let [(name, svg)] = &figures(&[study])[..] else { panic!("one figure") };
        assert_eq!(name, "llvmpipe-mesa-1.svg");
        for part in ["all scenes", "tori", "stack", "mean 50", "1e-4", "mlab 4", "abuffer", "0.40", "1.00"] {
            assert!(svg.contains(&format!(">{part}</text>")), "{part} in {svg}");
        }
        // The background; one panel of eight cells over all, one for each of two scenes.
        assert_eq!(svg.matches("<rect ").count(), 1 + 3 * 8);
    }
}
