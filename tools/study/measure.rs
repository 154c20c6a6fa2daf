//! Measures what is missing in the file of this driver.

use std::collections::BTreeSet;
use std::path::Path;
use std::time::{Duration, Instant};

use pellucid_core::progress::Progress;
use pellucid_engine::methods::Renderer;
use pellucid_engine::totals::Effort;
use pellucid_engine::{Error, Result};
use pellucid_gpu::{self as gpu, DeviceOptions};
use pellucid_lab::report::tradeoff::method_by_method;
use pellucid_session::candidates::{Ladders, Setting, settings};
use pellucid_session::choice::{ChoiceFrame, EXACT, TrialResult, Trials};

use crate::Args;
use crate::rows::{Device, Log, Row, rounded};
use crate::scenes::{self, Base, Fitted};

/// A ladder ends at a step that takes so many times as long as the fastest exact setting.
const TOO_SLOW: f64 = 4.0;
/// Measurements of a setting until the device's clock holds.
const TRIES: usize = 3;

/// Measures all scenes and means that are asked for, and not in the file yet.
pub fn run(args: &Args, folder: &Path) -> Result<()> {
    let device = gpu::Device::open(&DeviceOptions::from_env())?;
    let info = device.info();
    let about = Device {
        device: info.name.clone(),
        driver: info.driver.clone(),
        kind: info.kind.to_owned(),
        pellucid: env!("CARGO_PKG_VERSION").to_owned(),
        size: args.size,
        frames: args.frames,
    };
    let name = about.file_name();
    let mut log = Log::open(folder, about)?;
    println!("{} ({}): {}", info.name, info.driver, folder.join(name).display());
    let budget = args.budget_minutes.map(|minutes| Duration::from_secs_f64(60.0 * minutes));
    let end = budget.and_then(|budget| Instant::now().checked_add(budget));
    let cases = cases(args, &log);
    let mut bases: Vec<Option<Base>> = Vec::new();
    for (number, (scene, target)) in cases.iter().enumerate() {
        if end.is_some_and(|end| Instant::now() >= end) {
            println!("{} cases are left: the time is over", cases.len() - number);
            return Ok(());
        }
        let Some(base) = load(&mut bases, scene, *target, args)? else {
            println!("{scene}: left out, since its file is not in the folder of --data");
            continue;
        };
        // The rest of the time is shared by the rest of the cases.
        let share = end.map(|end| end.saturating_duration_since(Instant::now()) / (cases.len() - number) as u32);
        let warm_up = Duration::from_millis(args.warm_up_ms);
        let effort = Effort { frames: args.frames as usize, warm_up, ..Effort::RELIABLE };
        let end = share.and_then(|share| Instant::now().checked_add(share));
        let part = Part { effort, tries: TRIES, end };
        let fitted = base.fit(&device, *target);
        match fitted.and_then(|fitted| fitted.map(|fitted| measure(&device, base, &fitted, part, &mut log)).transpose())
        {
            Ok(Some(())) => {}
            Ok(None) => println!("{scene}: left out, since no radius gives lists of a mean of {target}"),
            Err(Error::Render(error)) if error.is_refusal() => {
                println!("{scene}, lists of {target}: left out, since the exact image is refused: {error}");
            }
            Err(error) => return Err(error),
        }
    }
    Ok(())
}

/// The cases that are missing: the first mean of all scenes, then the second, so that any part of them covers every
/// scene.
fn cases(args: &Args, log: &Log) -> Vec<(&'static str, u32)> {
    let is_asked = |name: &&str| args.only.is_empty() || args.only.iter().any(|only| only == name);
    let names: Vec<&str> = scenes::names().into_iter().filter(is_asked).collect();
    let all = args.means.iter().flat_map(|mean| names.iter().map(|name| (*name, *mean)));
    all.filter(|(name, mean)| !log.study.find(name, *mean).is_some_and(|measured| measured.done)).collect()
}

/// The scene, loaded unless it is there already.
fn load<'a>(bases: &'a mut Vec<Option<Base>>, scene: &str, target: u32, args: &Args) -> Result<Option<&'a Base>> {
    let serves = |base: &Option<Base>| base.as_ref().is_some_and(|base| base.name == scene && base.serves(target));
    if !bases.iter().any(serves) {
        bases.push(Base::load(scene, target, args.size, args.data.as_deref())?);
    }
    Ok(bases.iter().find(|base| serves(base)).and_then(Option::as_ref))
}

/// Limits on the measurement of a case.
#[derive(Debug, Clone, Copy)]
struct Part {
    effort: Effort,
    /// Measurements of a setting until the device's clock holds.
    tries: usize,
    end: Option<Instant>,
}

fn measure(device: &gpu::Device, base: &Base, fitted: &Fitted, part: Part, log: &mut Log) -> Result<()> {
    let Fitted { arranged, case } = fitted;
    let (scene, target) = (base.name, case.target);
    let begin = Instant::now();
    let mut cloud = Renderer::new(device)?.upload(arranged)?;
    let subject = ChoiceFrame { arranged, frame: base.frame, background: base.background, only: None };
    let progress = Progress::hidden();
    let mut trials = Trials::open(device, &mut cloud, &subject, true, &progress)?;
    let settings = settings(&trials.occasion(), &Ladders::FULL).0;
    log.case(case.clone())?;
    let mut ladders = Ladder::default();
    let mut is_whole = true;
    for at in method_by_method(&settings) {
        let setting = &settings[at];
        let key = setting.key();
        let known = log.study.find(scene, target).and_then(|m| m.rows.iter().find(|row| row.key() == key)).cloned();
        if known.is_none() && part.end.is_some_and(|end| Instant::now() >= end) {
            is_whole = false;
            break;
        }
        let row = match known {
            Some(row) => Some(row),
            None if ladders.is_over(setting) => None,
            None => {
                let found = steady(|| trials.measure(setting, part.effort, ladders.most()), part.tries)?;
                if found.is_some_and(|found| !found.is_steady) {
                    println!("{scene}: {key} is left for the next run, since the device's clock moved");
                    is_whole = false;
                }
                let found = found.map(|found| (found.is_steady, row(key, found)));
                if let Some((true, row)) = &found {
                    log.row(scene, target, row.clone())?;
                }
                found.map(|(_, row)| row)
            }
        };
        if let Some(row) = row {
            ladders.note(setting, &row);
        }
    }
    if is_whole {
        log.done(scene, target)?;
    }
    let (count, seconds) = (log.study.find(scene, target).map_or(0, |m| m.rows.len()), begin.elapsed().as_secs_f64());
    let cut = if is_whole { "" } else { ", the others later" };
    println!("{scene}, lists of {:.1}: {count} of {} settings in {seconds:.1} s{cut}", case.mean, settings.len());
    Ok(())
}

/// The first measurement during which the device's clock held, else the last of so many.
fn steady(mut measure: impl FnMut() -> Result<Option<TrialResult>>, tries: usize) -> Result<Option<TrialResult>> {
    let mut found = measure()?;
    for _ in 1..tries {
        if found.is_none_or(|found| found.is_steady) {
            break;
        }
        found = measure()?;
    }
    Ok(found)
}

fn row(key: String, TrialResult { figures, peak_device_bytes, .. }: TrialResult) -> Row {
    Row(key, rounded(figures.rmse), rounded(figures.gpu_ms), peak_device_bytes)
}

/// Ladders that have become too slow.
#[derive(Debug, Default)]
struct Ladder {
    /// Time of the fastest exact setting so far.
    exact: Option<f64>,
    over: BTreeSet<String>,
}

impl Ladder {
    /// The time beyond which a setting is too slow.
    fn most(&self) -> Option<f64> {
        self.exact.map(|exact| TOO_SLOW * exact)
    }

    fn is_over(&self, setting: &Setting) -> bool {
        self.over.contains(&setting.series)
    }

    fn note(&mut self, setting: &Setting, row: &Row) {
        if row.rmse() <= EXACT {
            self.exact = Some(self.exact.map_or(row.ms(), |exact| exact.min(row.ms())));
        }
        if self.most().is_some_and(|most| row.ms() > most) {
            self.over.insert(setting.series.clone());
        }
    }
}

#[cfg(test)]
mod tests {
    use pellucid_core::points::Points;
    use pellucid_scene::Discs;
    use pellucid_session::candidates::{Formation, Occasion, settings};
    use pellucid_session::choice::Figures;

    use super::*;

    #[test]
    fn a_setting_is_measured_until_the_clock_holds() {
        let result = |is_steady: bool, gpu_ms: f64| {
            let figures = Figures { rmse: 0.0, gpu_ms };
            Some(TrialResult { figures, peak_device_bytes: 1, is_steady })
        };
        let of = |held: &[bool]| {
            let mut number = 0;
            let found = steady(
                || {
                    number += 1;
                    Ok(result(held[number - 1], number as f64))
                },
                3,
            );
            (found.unwrap(), number)
        };
        assert_eq!(of(&[true]), (result(true, 1.0), 1));
        assert_eq!(of(&[false, false, true]), (result(true, 3.0), 3));
        assert_eq!(of(&[false, false, false]), (result(false, 3.0), 3));
        assert_eq!(steady(|| Ok(None), 3).unwrap(), None, "what can't be rendered is not tried again");
    }

    #[test]
    fn a_ladder_ends_where_it_is_too_slow() {
        let occasion = Occasion::new(&Points::default(), Formation::Discs(Discs::default()), 300);
        let (all, _) = settings(&Occasion { opaque: false, ..occasion }, &Ladders::FULL);
        let find = |key: &str| all.iter().find(|setting| setting.key() == key).unwrap();
        let row = |rmse, ms| Row(String::new(), rmse, ms, 1);
        let mut ladder = Ladder::default();
        ladder.note(find("peel method.layers=1"), &row(0.1, 1e3));
        assert!(!ladder.is_over(find("peel method.layers=2")), "nothing exact yet");
        ladder.note(find("abuffer"), &row(0.0, 10.0));
        ladder.note(find("linked-list"), &row(1e-7, 12.0));
        assert_eq!(ladder.most(), Some(40.0));
        ladder.note(find("peel method.layers=2"), &row(0.1, 39.0));
        assert!(!ladder.is_over(find("peel method.layers=4")));
        ladder.note(find("peel method.layers=4"), &row(0.1, 41.0));
        assert!(ladder.is_over(find("peel method.layers=8")) && !ladder.is_over(find("hybrid method.k=8")));
    }
}
