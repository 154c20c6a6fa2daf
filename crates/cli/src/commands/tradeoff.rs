//! `pellucid tradeoff`.

use std::path::PathBuf;
use std::process::ExitCode;
use std::time::{Duration, Instant};

use clap::Args;
use clap::builder::PossibleValuesParser;
use comfy_table::{CellAlignment, ColumnConstraint, Table, presets};
use pellucid_engine::camera::Camera;
use pellucid_engine::gpu::{Device, DeviceOptions};
use pellucid_engine::methods::{Factors, Frame, Stop};
use pellucid_engine::points::Points;
use pellucid_engine::scene::{Discs, Interpolated, Method, ScreenSplats, Soft, Spbr};
use pellucid_engine::{Result, output};
use pellucid_lab::report::popping;
use pellucid_lab::report::tradeoff::settings::{self, Formation, Ladders, Occasion, Surfaces};
use pellucid_lab::report::tradeoff::{self, Options, Row, Shaded, ShadedStep, Skipped, Subject, Tradeoff};

use super::DeviceArgs;
use super::along::{Along, PathArgs};
use super::console::{Console, print, print_json};
use super::input::InputArgs;
use super::limit::usage;
use super::loaded::{Resolved, read};
use super::opacity_notes;
use super::session::Session;
use super::stress::seconds;

const ABOUT: &str = "\
What is compared: all methods that draw the scene's transparent discs, with the scene's shape and falloff. The exact ones; \
peel with 1 to 64 layers; hybrid with k = 1 to 32; stochastic with 1 to 1024 samples, with and without alpha correction, and with \
the rasteriser; weighted, average and unsorted. Where every point is opaque, circles too. A method that does not apply, a step beyond the \
longest list, and a setting whose frames would take too long are listed with the reason.

If the scene's method is a soft one, the models of soft spheres are compared instead, with its threshold, softness and \
modulation: soft-base with both layouts, soft-concentric with 1 to 8 shells and adaptive ones, soft-express. A lambda counts \
as the softness that it means for the scene's method. What the paper says of the three stands below the table with what was \
measured.

If points are Gaussian splats, a table \"by cause\" tells what each approximation costs by itself: abuffer with another order, kernel, \
cut, cap, dilation, antialias or degree of harmonics, each against the exact image of the scene's own kernel and order. It takes a fifth of \
--time at most; --only leaves it out unless it names abuffer.

If it is one of opaque points (points, squares, circles, paraboloid, cone, sphere, hqs, splats, image-space), all of them are \
compared, with sizes from 0 to 4 and 0 to 8 iterations of the filters, on all points, a quarter and a 16th of them \
(\"thinning\", which is no key of a scene file). Each leaves other holes: their share is in the table too. Under \
[shadows] with a light_radius the scene's own method is rendered with 1 to 30 samples and with many.

Along a camera path (--path, --turntable) the errors of the methods are followed: popping is how much they change from one frame \
to the next. Gaussians are held against abuffer with order = \"pixel\" there, since an order of centres is what pops.

What errors are: against the image of abuffer, which itself is checked against the float64 reference on 256 random pixels; \
on linear R, G, B over the scene's background. That of soft spheres is soft-base in float64, all pixels, before the solid \
points as the device splats them. Opaque points are held against three-pass splats of all of them with up to 4 x 4 samples in a \
pixel. Stochastic settings are rendered with several seeds, from --seed on.

What times are: medians over frames that take turns, so that a machine that slows down slows all. The Pareto front is that \
of device time and RMSE.

An interrupted run leaves what it measured in DIR/tradeoff.partial.json. The same command, or one that differs only in \
--quick, --only or --time, goes on from there.

What is written: report.html, which needs no other file; tradeoff.csv; tradeoff.json; causes.csv of Gaussians; popping.csv along a path; the figures as .svg; the pictures, and \
their differences from reference.png 10 times as bright, as .png.";

/// Frames behind a median, and images with seeds of their own, if time permits: for the full run and for a quick look.
const REPEATS: (usize, u32) = (10, 8);
const QUICK_REPEATS: (usize, u32) = (3, 4);
/// Default of --time: for frames of the full run, and for all of a quick look.
const SECONDS: f64 = 360.0;
const QUICK_SECONDS: f64 = 55.0;

#[derive(Debug, Args)]
#[command(after_help = ABOUT)]
pub struct TradeoffArgs {
    #[command(flatten)]
    pub input: InputArgs,
    /// Folder for the report; created if it isn't there, files of the same names are replaced.
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
    /// A part of it for a first look and for CI: three samples, two k and two layers, 3 frames, 4 seeds. --time then bounds
    /// all of it, and settings that would not fit are left out, with the reason: first one setting of each method is measured, then
    /// a second one, and so on.
    #[arg(long)]
    quick: bool,
    /// Compare this method only; repeatable. By default all. (--method, like a scene file's, says only which discs.)
    #[arg(long, value_name = "NAME", value_parser = method_names())]
    only: Vec<String>,
    /// About how long frames may be rendered, by default 360; with --quick how long all may take, by default 55. Slow settings
    /// get fewer frames and seeds; one whose frame takes more than a 60th of it is timed once, by itself, and one is skipped if its
    /// own ladder predicts that a frame takes more than an 8th, or more than is left.
    #[arg(long, value_name = "SECONDS", value_parser = seconds)]
    time: Option<f64>,
    #[command(flatten)]
    along: PathArgs,
    /// With --path or --turntable the number of frames: those of a path of key frames, or of the turn. The methods that are not exact,
    /// or those of --only, are then followed from frame to frame, and what changes of their errors is reported as popping. That takes a frame
    /// of each method at each camera beyond --time. The rest of the report is about the first frame.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(2..=100_000))]
    frames: Option<u32>,
    #[command(flatten)]
    device: DeviceArgs,
    /// Print what tradeoff.json holds instead of the summary.
    #[arg(long)]
    json: bool,
}

fn method_names() -> PossibleValuesParser {
    let soft = Formation::Soft { soft: Soft::default(), from_lambda: false };
    let mut names = Vec::new();
    let with_normals = Points { normals: Some(Vec::new()), ..Points::default() };
    let opaque = [Method::Cone(Interpolated::default()), Method::Sphere(ScreenSplats::default())];
    let opaque =
        opaque.iter().filter_map(|method| Surfaces::for_method(method, &with_normals)).map(Formation::Surfaces);
    let others = [Formation::Discs(Discs::default()), soft, Formation::Ensembles(Spbr::default())];
    for formation in others.into_iter().chain(opaque) {
        let occasion = Occasion { formation, opaque: true, oriented: false, max_list: u32::MAX, points: u64::MAX };
        let (settings, _) = settings::settings(&occasion, &Ladders::QUICK);
        for name in settings.iter().map(|setting| setting.method.name()) {
            if !names.contains(&name) {
                names.push(name);
            }
        }
    }
    names.into()
}

impl TradeoffArgs {
    /// The camera's path, if there is one.
    fn course(&self, console: Console) -> Result<Option<Along>> {
        match (self.frames, self.along.option()) {
            (Some(frames), None) => Err(usage(format!("--frames {frames} needs --path or --turntable"))),
            _ => self.along.course(self.frames, &self.input, console),
        }
    }

    /// Refuses a path along which nothing can be followed.
    fn check_popping(&self, resolved: &Resolved, cameras: &[Camera]) -> Result<()> {
        let Some(option) = self.along.option() else { return Ok(()) };
        let (method, points) = (resolved.scene.method.representative(), resolved.points());
        if resolved.stored.is_some() {
            let problem = "this needs all clouds in memory, and these would take more than --host-memory allows";
            return Err(usage(problem.to_owned()));
        }
        if popping::exact(&method, points).is_none() {
            let name = method.name();
            return Err(usage(format!(
                "{option} follows errors of transparent discs and soft spheres, not those of {name}"
            )));
        }
        match cameras.len() {
            0 | 1 => Err(usage(format!("{option} has one frame, and errors change from one to the next"))),
            _ => Ok(()),
        }
    }

    /// The extent of a comparison by a command that began at this time.
    fn options(&self, begin: Instant) -> Options {
        let (ladders, (rounds, seeds)) =
            if self.quick { (Ladders::QUICK, QUICK_REPEATS) } else { (Ladders::FULL, REPEATS) };
        let command: Vec<_> = std::env::args().skip(1).collect();
        let command = format!("pellucid {}", command.join(" "));
        let seconds = self.time.unwrap_or(if self.quick { QUICK_SECONDS } else { SECONDS });
        // A time beyond what a clock can hold is no limit.
        let end = Duration::try_from_secs_f64(seconds).ok().and_then(|time| begin.checked_add(time));
        let end = end.filter(|_| self.quick);
        Options { ladders, only: self.only.clone(), seconds, end, rounds, seeds, command }
    }
}

pub fn run(args: TradeoffArgs, console: Console) -> Result<ExitCode> {
    let begin = Instant::now();
    output::check_report_folder(&args.output)?;
    let progress = console.progress();
    let (resolved, cameras) = match args.course(console)? {
        Some(along) => along.resolve(&args.input, false, console, &progress)?,
        None => {
            let loaded = read(&args.input, None, console, &progress)?;
            loaded.count()?;
            (loaded.with_radii().resolve(None, console, &progress)?, Vec::new())
        }
    };
    args.check_popping(&resolved, &cameras)?;
    let formation = settings::compared(&resolved.scene.method.representative(), resolved.points())?;
    let factors = match resolved.see_through {
        None => Factors::default(),
        Some(share) => {
            let mut session = Session::upload(&args.device, &resolved, false, Stop::Exact, &progress)?;
            session.find_opacity(&resolved, &progress)?;
            opacity_notes::describe(share, session.see_through, &resolved, console);
            session.frame.factors
        }
    };
    progress.stage("uploading");
    let options = DeviceOptions { device: args.device.device.clone(), ..DeviceOptions::from_env() };
    let device = Device::open(&options)?;
    console.detail(format_args!("device {} ({})", device.info().name, device.info().driver));
    let mut shading = resolved.scene.shading;
    if shading.edl.edl && !matches!(formation, Formation::Surfaces(_)) {
        console.warn("eye-dome lighting is left out: not all of the methods that are compared have it");
        shading.edl.edl = false;
    }
    let frame = Frame {
        camera: resolved.camera,
        size: resolved.scene.image.size,
        shading,
        color: resolved.scene.image.color_space(),
        method: resolved.scene.method.representative(),
        detail: Default::default(),
        memory_budget: args.device.memory_budget.map(|b| b.as_u64()),
        fragments: false,
        depths: false,
        stop: Stop::Exact,
        max_error: None,
        spread: false,
        ensembles: None,
        shadows: resolved.scene.shadows.filter(|_| matches!(formation, Formation::Surfaces(_))),
        factors,
        seed: resolved.seed,
    };
    let background = resolved.scene.image.background;
    let subject = Subject { arranged: &resolved.arranged, frame, background, scene: &resolved.name, cameras: &cameras };
    progress.counted("tradeoff", 1);
    let report = tradeoff::run(&device, &subject, &args.options(begin), &args.output, &progress)?;
    progress.stage("writing the report");
    tradeoff::write(&args.output, &report)?;
    tradeoff::discard(&args.output)?;
    progress.finish_and_clear();
    warn_of_left_out(&report, console);
    if report.sittings > 1 {
        console.detail(format_args!("measured in {} runs: what earlier ones had stored was kept", report.sittings));
    }
    if args.json {
        let value =
            serde_json::to_value(&report).map_err(|error| output::Error::Report { reason: error.to_string() })?;
        print_json(&value)?;
    } else {
        print(&summary(&report, &args))?;
    }
    Ok(ExitCode::SUCCESS)
}

/// Names the settings that were left out because of the time.
fn warn_of_left_out(report: &Tradeoff, console: Console) {
    let name = |skipped: &Skipped| format!("{} {}", skipped.method, skipped.setting.replace("method.", ""));
    let late: Vec<String> = report.skipped.iter().filter(|skipped| skipped.for_time).map(name).collect();
    if !late.is_empty() {
        let (count, late) = (late.len(), late.iter().map(|name| name.trim_end()).collect::<Vec<_>>().join(", "));
        console.note(format_args!("{count} setting(s) left out because of the time (--time): {late}"));
    }
}

/// All rows, how much was skipped, and where the rest is.
fn summary(report: &Tradeoff, args: &TradeoffArgs) -> String {
    let mut table = Table::new();
    table.load_style(presets::NOTHING).set_header([
        "front",
        "method",
        "setting",
        "median ms",
        "frames",
        "RMSE",
        "FLIP",
        "> 1/255",
        "peak MiB",
        "lists MiB",
        "holes",
    ]);
    let mib = |bytes: u64| format!("{:.1}", bytes as f64 / f64::from(1 << 20));
    let line = |row: &Row| {
        [
            if row.front { "*" } else { "" }.to_owned(),
            row.method.clone(),
            row.setting.replace("method.", ""),
            format!("{:.2}", row.gpu_ms.median),
            row.frames.to_string(),
            format!("{:.2e}", row.errors.rmse),
            format!("{:.2e}", row.errors.flip),
            format!("{:.2}%", 100.0 * row.errors.above_1_255),
            mib(row.peak_device_bytes),
            mib(row.fragment_bytes),
            row.holes.map_or_else(String::new, |holes| format!("{:.3}%", 100.0 * holes)),
        ]
    };
    table.add_rows(report.rows.iter().map(line));
    for column in table.column_iter_mut().skip(3) {
        column.set_cell_alignment(CellAlignment::Right);
    }
    if let (None, Some(holes)) = (&report.surveyed, table.column_mut(10)) {
        holes.set_constraint(ColumnConstraint::Hidden);
    }
    let holds = |holds| match holds {
        Some(true) => "holds here: ",
        Some(false) => "does not hold here: ",
        None => "",
    };
    let findings = report.findings.iter().map(|f| format!("{}\n  {}{}\n", f.claim, holds(f.holds), f.measured));
    let mut findings: String = findings.collect();
    if let Some(shaded) = &report.shaded {
        let step = |step: &ShadedStep| format!("{}: {:.2} ms, RMSE {:.2e}", step.samples, step.ms.median, step.rmse);
        let steps: Vec<_> = shaded.steps.iter().map(step).collect();
        let Shaded { method, reference_samples, .. } = shaded;
        findings += &format!("shadows with {method} by samples, against {reference_samples}\n  {}\n", steps.join("; "));
    }
    let causes = tradeoff::causes_table(&report.causes);
    if !causes.is_empty() {
        findings += &format!("{}{causes}", if findings.is_empty() { "" } else { "\n" });
    }
    if let Some(found) = &report.popping {
        findings += &format!("{}{}", if findings.is_empty() { "" } else { "\n" }, popping::popping_table(found));
    }
    format!(
        "{}\n\n{}* on the Pareto front: nothing else is at least as fast and as accurate, and better in one of the two.\n\
         {} settings measured, {} skipped; why, and all figures: {}\n",
        table.trim_fmt(),
        if findings.is_empty() { findings } else { format!("{findings}\n") },
        report.rows.len(),
        report.skipped.len(),
        args.output.join("report.html").display()
    )
}
