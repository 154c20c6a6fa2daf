//! Quality of the choice for `--max-error` and `--budget`: against an exhaustive search.
//!
//! ```sh
//! cargo bench --bench choice                            # the built-in scenes
//! PELLUCID_BENCH_SECONDS=60 cargo bench --bench choice  # seconds of frames of a search, 240 without it
//! ```
//!
//! How to read it. On each scene `tradeoff` first measures every setting, all of them in turns. Then each line is a
//! constraint, the choice for it, and the best by the search's table. `ratio` is the time of the chosen setting over
//! that of the fastest one allowed (by error), or its RMSE over the least one allowed (by time), both by that one
//! table: 1 is the best there is. `error / E` is the RMSE of the chosen setting over the constraint, as it was measured
//! for the choice. What the choice knew of the scene before is forgotten for the first line of each scene.

mod common;

use std::process::ExitCode;
use std::time::Instant;

use pellucid_core::progress::Progress;
use pellucid_engine::Result;
use pellucid_engine::methods::{Frame, Renderer};
use pellucid_gpu::{Device, DeviceOptions};
use pellucid_lab::report::tradeoff::{self, MeasuredScene, Options, Row, Tradeoff};
use pellucid_scene::prepare::Arranged;
use pellucid_scene::{self as scene, Overrides, Scene, procedural};
use pellucid_session::candidates::Ladders;
use pellucid_session::choice::{self, Choice, Wish};

/// Name, keys of the scene file. Half of the pixels of the scenes' own images in each direction.
const SCENES: [(&str, &[(&str, &str)]); 4] = [
    ("tori", &[("image.size", "[512, 512]")]),
    ("volume", &[("image.size", "[512, 512]")]),
    ("garden", &[("image.size", "[640, 480]")]),
    ("garden", &[("image.size", "[640, 480]"), ("method.shape", "flat")]),
];
const ERRORS: [f64; 5] = [0.1, 0.03, 0.01, 0.003, 0.0];
/// Budgets as parts of the time of the fastest exact setting.
const BUDGETS: [f64; 3] = [0.3, 0.7, 1.2];

fn main() -> ExitCode {
    common::measure(run)
}

fn run() -> Result<()> {
    let device = Device::open(&DeviceOptions::from_env())?;
    println!("{} ({}), pellucid {}", device.info().name, device.info().driver, env!("CARGO_PKG_VERSION"));
    SCENES.iter().try_for_each(|(name, keys)| compare(&device, name, keys))
}

fn compare(device: &Device, name: &str, keys: &[(&str, &str)]) -> Result<()> {
    let mut overrides = Overrides::default();
    keys.iter().try_for_each(|(key, value)| overrides.set("bench", key, value))?;
    let generated = procedural::build(name, &[], 0).map_err(scene::Error::from)?;
    let scene = Scene::from_toml_with(&generated.scene_toml, name.as_ref(), &overrides)?;
    let clouds = scene::take_generated(&scene, &generated)?;
    let up = scene::up_axis(&clouds);
    let arranged = scene::arrange(&scene, clouds, 0, &Progress::hidden())?;
    let (camera, _) = scene::camera(&scene, arranged.points(), up)?;
    let frame = Frame {
        shading: scene.shading,
        color: scene.image.color_space(),
        ..Frame::new(camera, scene.image.size, scene.method.representative())
    };
    let start = Instant::now();
    let table = search(
        device,
        &MeasuredScene {
            arranged: &arranged,
            frame,
            background: scene.image.background.color(),
            scene: name,
            cameras: &[],
        },
    )?;
    let (settings, seconds) = (table.rows.len(), start.elapsed().as_secs());
    println!("\n== {name} {keys:?}: {settings} settings searched in {seconds} s");
    choices(device, &arranged, &scene, frame, &table)
}

fn search(device: &Device, subject: &MeasuredScene<'_>) -> Result<Tradeoff> {
    let seconds = std::env::var("PELLUCID_BENCH_SECONDS").ok().and_then(|text| text.parse().ok()).unwrap_or(240.0);
    let options = Options {
        ladders: Ladders::FINE,
        only: Vec::new(),
        seconds,
        end: None,
        rounds: 7,
        seeds: 2,
        command: String::new(),
        against: Default::default(),
    };
    let folder = tempfile::tempdir()
        .map_err(|source| pellucid_io::output::Error::Write { path: std::env::temp_dir(), source })?;
    tradeoff::run(device, subject, &options, folder.path(), &Progress::hidden())
}

fn choices(device: &Device, arranged: &Arranged, scene: &Scene, frame: Frame, table: &Tradeoff) -> Result<()> {
    let mut cloud = Renderer::new(device)?.upload(arranged)?;
    let subject = choice::ChoiceFrame { arranged, frame, background: scene.image.background.color(), only: None };
    let exact = table.rows.iter().filter(|row| row.errors.rmse < choice::EXACT);
    let exact = exact.map(|row| row.gpu_ms.median).fold(f64::INFINITY, f64::min);
    let by_error = ERRORS.map(|error| Wish { max_error: Some(error), ..Wish::default() });
    let by_time = BUDGETS.map(|part| Wish { budget_ms: Some(part * exact), ..Wish::default() });
    println!("{:<16} {:<38} {:<38} {:>6} {:>9} {:>7}", "wish", "chosen", "best", "ratio", "error / E", "frames");
    for (number, wish) in by_error.into_iter().chain(by_time).enumerate() {
        let hidden = Progress::hidden();
        let choice = choice::choose(device, &mut cloud, &subject, wish, number == 0, &hidden)?;
        println!("{}", line(&choice, table));
    }
    Ok(())
}

fn line(choice: &Choice, table: &Tradeoff) -> String {
    let rows = || table.rows.iter();
    let chosen = rows().find(|row| row.method == choice.method.name() && row.setting == choice.setting);
    let ms = |row: &&Row| row.gpu_ms.median;
    let rmse = |row: &&Row| row.errors.rmse.max(choice::EXACT);
    let (wish, best, ratio) = match (choice.wish.max_error, choice.wish.budget_ms) {
        (Some(error), _) => {
            let best = rows().filter(|row| row.errors.rmse <= error).min_by(|a, b| ms(a).total_cmp(&ms(b)));
            (format!("RMSE <= {error}"), best, chosen.zip(best).map(|(a, b)| ms(&a) / ms(&b)))
        }
        (None, budget) => {
            let budget = budget.unwrap_or(f64::INFINITY);
            let best = rows().filter(|row| ms(row) <= budget).min_by(|a, b| rmse(a).total_cmp(&rmse(b)));
            (format!("<= {budget:.1} ms"), best, chosen.zip(best).map(|(a, b)| rmse(&a) / rmse(&b)))
        }
    };
    let name = |method: &str, setting: &str, ms: f64| {
        format!("{method} {} {ms:.1} ms", setting.replace("method.", "")).replace("  ", " ")
    };
    let found = name(choice.method.name(), &choice.setting, chosen.map_or(choice.figures.gpu_ms, |row| ms(&row)));
    let best = best.map_or("-".to_owned(), |row| name(&row.method, &row.setting, ms(&row)));
    let error = choice.wish.max_error.filter(|most| *most > 0.0).map(|most| choice.figures.rmse / most);
    let number = |value: Option<f64>| value.map_or("-".to_owned(), |value| format!("{value:.2}"));
    format!("{wish:<16} {found:<38} {best:<38} {:>6} {:>9} {:>7}", number(ratio), number(error), choice.frames)
}
