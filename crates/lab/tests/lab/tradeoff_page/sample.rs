//! A comparison such as a scene with some dozen layers gives, made up: its numbers are plausible and not measured.

use std::path::Path;

use pellucid_io::output::write_rgb_png;
use pellucid_lab::report::fit::power_law;
use pellucid_lab::report::popping::{Candidate, Curve, FrameError, Popping, Refused};
use pellucid_lab::report::stress::Spread;
use pellucid_lab::report::tradeoff::{
    Cause, Convergence, Errors, Finding, Look, PixelArea, Reference, Repeats, Row, Skipped, Tradeoff, Worst,
};
use pellucid_scene::{Discs, Method, Stochastic};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

/// The numbers, with names of pictures that [`write_pictures`] makes.
pub fn report(size: [u32; 2]) -> Tradeoff {
    let mut rows = vec![
        row("abuffer", None, 412.0, 0.0, 1840),
        row("linked-list", None, 655.0, 0.0, 2310),
        row("sorted", None, 287.0, 3.1e-8, 640),
    ];
    rows.push(Row { setting: "method.raster=hardware".into(), ..row("sorted", None, 366.0, 3.1e-8, 640) });
    // Peeling converges at once when the last layer is reached.
    let errors = [0.21, 0.16, 0.098, 0.047, 0.0121, 0.0008, 1.2e-7];
    for (power, error) in errors.into_iter().enumerate() {
        let layers = f64::from(1 << power);
        rows.push(row("peel", Some(("layers", layers)), 70.0 + 66.0 * layers, error, 210));
    }
    for power in 0..=10 {
        let samples = f64::from(1 << power);
        rows.push(row("stochastic", Some(("samples", samples)), 34.0 + 4.7 * samples, 0.31 / samples.sqrt(), 180));
    }
    for (power, error) in [0.083, 0.052, 0.024, 0.0071, 0.0011, 4.0e-6].into_iter().enumerate() {
        let k = f64::from(1 << power);
        rows.push(row("hybrid", Some(("k", k)), 120.0 + 14.0 * k, error, 420));
    }
    rows.push(row("weighted", None, 61.0, 0.071, 150));
    rows.push(row("average", None, 58.0, 0.094, 150));
    rows.push(row("unsorted", None, 49.0, 0.127, 140));
    for index in 0..rows.len() {
        let [time, error] = [rows[index].gpu_ms.median, rows[index].errors.rmse];
        let beats = |other: &Row| {
            let [t, e] = [other.gpu_ms.median, other.errors.rmse];
            t <= time && e <= error && (t < time || e < error)
        };
        rows[index].front = !rows.iter().any(beats);
        rows[index].look = looks(&rows[index], size);
        rows[index].picture = format!("picture-{index}.png");
        rows[index].difference = format!("difference-{index}.png");
    }
    let laws = [("stochastic", "samples"), ("peel", "layers"), ("hybrid", "k")].map(|(method, key)| {
        let ladder: Vec<&Row> = rows.iter().filter(|row| row.method == method).collect();
        let law = |x: fn(&Row) -> f64| {
            power_law(&ladder.iter().map(|row| (x(row), row.errors.rmse)).collect::<Vec<_>>()).unwrap()
        };
        Convergence {
            method: method.into(),
            key: key.into(),
            rmse: law(|row| row.step.as_ref().unwrap().1),
            over_time: law(|row| row.gpu_ms.median),
            rows: ladder.len(),
        }
    });
    let skipped = |method: &str, setting: &str, reason: &str| Skipped {
        method: method.into(),
        setting: setting.into(),
        reason: reason.into(),
        for_time: reason.contains("s are left"),
    };
    Tradeoff {
        version: 1,
        pellucid: "0.1.0".into(),
        command: "pellucid tradeoff forest.laz --opacity 0.3 <with> \"quotes\" & more -o out".into(),
        scene: "forest.laz".into(),
        device: "llvmpipe (LLVM 15.0.6, 256 bits)".into(),
        driver: "llvmpipe, Mesa 22.3.6 (LLVM 15.0.6)".into(),
        size,
        points: 1_204_331,
        fragments: 41_873_902,
        max_list: 64,
        sittings: 1,
        reference: Reference {
            method: "abuffer".into(),
            picture: "reference.png".into(),
            checked_pixels: 4096,
            largest_error: 2.4e-7,
            samples: 1,
        },
        analytic: None,
        surveyed: None,
        shaded: None,
        against: "center".into(),
        area: Some(PixelArea { method: "abuffer".into(), samples: 1, against: 64, rmse: 0.0271 }),
        causes: [("the exact image", "", 0.0), ("order of centers", "method.order=center", 0.0123)].map(cause).to_vec(),
        popping: Some(popping()),
        rows,
        skipped: vec![
            skipped("peel", "method.layers=128", "the longest list has 64 fragments: 64 layers are exact already"),
            skipped("hybrid", "method.k=64", "a frame would take about 6.2 s, more than the limit of 5 s"),
        ],
        convergence: laws.to_vec(),
        findings: vec![Finding {
            claim: "soft-express takes at most a tenth of the time of soft-base".into(),
            measured: "412 ms over 31.0 ms: 13.3".into(),
            holds: Some(true),
        }],
    }
}

/// The approximations whose errors are shown, and the shares of each: even, leak, ghost, noise.
pub const LOOKS: [(&str, [f64; 4]); 5] = [
    ("stochastic", [0.0, 0.01, 0.01, 0.98]),
    ("hybrid", [0.05, 0.75, 0.15, 0.05]),
    ("weighted", [0.1, -0.6, 0.2, 0.1]),
    ("average", [0.02, 0.9, 0.06, 0.02]),
    ("unsorted", [0.0, 0.2, 0.7, 0.1]),
];

fn looks(row: &Row, [width, height]: [u32; 2]) -> Option<Look> {
    let (_, [even, leak, ghost, noise]) = *LOOKS.iter().find(|(method, _)| *method == row.method)?;
    let side = width.min(height).min(64);
    let worst = Worst { x: (width - side) / 2, y: (height - side) / 3, side, share: 0.125 };
    Some(Look { bias: 0.5 * row.errors.rmse, even, leak: Some(leak), ghost, noise, worst })
}

fn cause((cause, setting, rmse): (&str, &str, f64)) -> Cause {
    Cause {
        cause: cause.into(),
        setting: setting.into(),
        against: String::new(),
        meaning: "What this means.".into(),
        rmse,
        flip: 1.5 * rmse,
        max: (20.0 * rmse).min(1.0),
        above_1_255: 9.0 * rmse,
        gpu_ms: 51.0,
        times: Some(1.0),
        difference: "cause-difference.png".into(),
    }
}

/// Forty frames: one method jumps in some of them, one has noise.
fn popping() -> Popping {
    let curve = |method: Method, setting: &str, change: fn(u32) -> f64| {
        let frame = |frame: u32| FrameError {
            frame,
            error: 0.02,
            rmse: (frame > 0).then(|| change(frame)),
            flip: (frame > 0).then(|| 1.4 * change(frame)),
        };
        Curve::new(&Candidate { method, setting: setting.into() }, (0..40).map(frame).collect())
    };
    let jumps = |frame: u32| if frame.is_multiple_of(7) { 0.03 } else { 4e-4 };
    let noise = |frame: u32| 0.008 + 1e-4 * f64::from(frame % 3);
    let curves = vec![
        curve(Method::Sorted(Discs::default()), "method.order=center", jumps),
        curve(Method::Stochastic(Stochastic::default()), "", noise),
    ];
    let refused = Refused { method: "peel".into(), reason: "too many layers".into() };
    Popping { exact: "abuffer order=pixel".into(), frames: 40, curves, refused: vec![refused] }
}

fn row(method: &str, step: Option<(&str, f64)>, ms: f64, rmse: f64, mib: u64) -> Row {
    let spread = |ms: f64| Spread { min: 0.94 * ms, median: ms, max: 1.13 * ms };
    let samples = step.filter(|(key, _)| *key == "samples");
    let repeats = samples.map(|(_, samples)| {
        let noise = 0.999 * rmse;
        // A bias that more samples don't take away shows where noise gets below it.
        Repeats { seeds: 16, noise, bias: if samples < 16.0 { 0.0 } else { 0.0031 }, bias_floor: noise / 4.0 }
    });
    Row {
        method: method.into(),
        setting: step.map(|(key, value)| format!("method.{key}={value}")).unwrap_or_default(),
        step: step.map(|(key, value)| (key.to_owned(), value)),
        stochastic: samples.is_some(),
        gpu_ms: spread(ms),
        wall_ms: spread(ms + 6.0),
        frames: 7,
        peak_device_bytes: mib << 20,
        fragment_bytes: mib << 19,
        errors: Errors {
            rmse,
            nmse: rmse * rmse / 0.2,
            psnr: (rmse > 0.0).then(|| -20.0 * rmse.log10()),
            ssim: 1.0 - rmse,
            flip: (0.9 * rmse.powf(0.8)).min(1.0),
            max: (6.0 * rmse).min(1.0),
            above_1_255: (9.0 * rmse).min(1.0),
        },
        repeats,
        thinning: 1,
        passes: vec![("project/splats".into(), 0.2 * ms), (format!("{method}/blend"), 0.8 * ms)],
        ..Row::default()
    }
}

/// Discs on black for the reference, the same with as much noise as the error says for each row, and the differences.
pub fn write_pictures(folder: &Path, report: &Tradeoff) {
    let [width, height] = report.size;
    let mut random = Pcg64::seed_from_u64(7);
    let mut truth = vec![[0.02f32; 3]; (width * height) as usize];
    for _ in 0..60 {
        let color: [f32; 3] = std::array::from_fn(|_| random.random());
        let (cx, cy) = (random.random_range(0..width) as i64, random.random_range(0..height) as i64);
        let radius = random.random_range(width / 40..width / 8) as i64;
        for y in (cy - radius).max(0)..(cy + radius).min(height.into()) {
            for x in (cx - radius).max(0)..(cx + radius).min(width.into()) {
                if (x - cx).pow(2) + (y - cy).pow(2) < radius * radius {
                    let pixel = &mut truth[y as usize * width as usize + x as usize];
                    *pixel = std::array::from_fn(|c| 0.7 * pixel[c] + 0.3 * color[c]);
                }
            }
        }
    }
    let save = |name: &str, pixels: &[[f32; 3]]| write_rgb_png(&folder.join(name), [width, height], pixels).unwrap();
    save(&report.reference.picture, &truth);
    for row in &report.rows {
        let rmse = row.errors.rmse as f32;
        let mut noisy = |value: f32| value + rmse * random.random_range(-1.7..1.7);
        let picture: Vec<[f32; 3]> = truth.iter().map(|pixel| pixel.map(&mut noisy)).collect();
        let difference = |(a, b): (&[f32; 3], &[f32; 3])| std::array::from_fn(|c| 10.0 * (a[c] - b[c]).abs());
        save(&row.picture, &picture);
        save(&row.difference, &truth.iter().zip(&picture).map(difference).collect::<Vec<_>>());
    }
}
