//! `pellucid tradeoff`.

use std::path::PathBuf;
use std::time::Instant;

use clap::Args;
use clap::builder::PossibleValuesParser;
use pellucid_core::camera::Camera;
use pellucid_core::metrics;
use pellucid_core::points::Points;
use pellucid_engine::Result;
use pellucid_engine::methods::{Factors, Frame};
use pellucid_gpu::Device;
use pellucid_io::output::{self, Output};
use pellucid_lab::report::page::{self, ReportTable};
use pellucid_lab::report::popping;
use pellucid_lab::report::tradeoff::{self, Against, MeasuredScene, Options, Shaded, ShadedStep, Skipped, Tradeoff};
use pellucid_scene::{Discs, Interpolated, Method, ScreenSplats, Soft, Spbr};
use pellucid_session::candidates::{self, Formation, Ladders, Occasion, Surfaces};
use pellucid_session::{Clouds, FrameRequest, Opened, Prepared, Request, Session, without_soft_points};

use super::along::{Along, PathArgs};
use super::console::Console;
use super::input::InputArgs;
use super::limit::usage;
use super::options::{AGAINST, DeviceArgs, one_of};
use super::stress::seconds;
use super::touched::{Touched, Touches};
use super::typed::command;

const ABOUT: &str = "\
Methods: All methods that draw the scene's transparent discs are compared, with the scene's shape and falloff: the exact ones; peel \
with 1 to 64 layers; hybrid with k = 1 to 32; stochastic with 1 to 1024 samples, with and without alpha correction, and with the \
rasterizer; weighted, average and unsorted. If every point is opaque, also circles. Some settings are left out and listed with the \
reason: methods that do not apply, steps beyond the longest list, and settings whose frames would take too long.

Soft methods: If the scene's method is a soft one, the models of soft spheres are compared instead, with the scene's threshold, \
softness and modulation: soft-base with both layouts, soft-concentric with 1 to 8 shells and adaptive shells, each equalized \
(Eq. 15) and not, and soft-express. lambda is converted to the softness that it means for the scene's method. The report compares \
the paper's claims about the three with the measurements.

Gaussian splats: A table \"by cause\" gives the cost of each approximation alone: abuffer with another order, kernel, cut, cap, \
dilation, antialias or degree of harmonics, against the exact image of the scene's own kernel and order. It takes at most a fifth of \
--time. --only skips it unless it names abuffer.

Pixel area: Of every scene but opaque points, the table \"by cause\" also has the exact picture with 1, 4 and 16 samples of \
a pixel's area (`pixel area`) against itself with 64, or with 16 where 64 would take more than a tenth of --time, and its time as a \
multiple of that of one sample. A line of every report gives the first of these errors, that of the scene's own samples.

Opaque methods: If the scene's method draws opaque points (points, squares, circles, paraboloid, cone, sphere, hqs, splats, \
image-space), all of these are compared, with sizes from 0 to 4 and 0 to 8 iterations of the filters. Each is run on all points, \
a quarter and a 16th of them (\"thinning\"; a scene file has no key for it). The table also has the share of holes.

Shadows: With [shadows] and a light_radius the scene's own method is rendered with 1 to 30 samples and with many.

Camera paths: With --path or --turntable the report has the popping of each method: the change of its error from one frame to the \
next. For Gaussians the reference is then abuffer with order = \"pixel\", because an order of centers pops. Opaque methods are \
followed with the scene's settings, against three-pass splats with up to 4 x 4 samples per pixel.

Errors: The reference is the image of abuffer, which is checked against the float64 reference on 256 random pixels. Errors are \
measured on linear R, G, B over the scene's background. For soft spheres the reference is soft-base in float64 at all pixels, in front \
of the solid points as the device draws them. For opaque points it is three-pass splats of all points with up to 4 x 4 \
samples per pixel. Stochastic settings are rendered with several seeds, starting with --seed.

Times: Medians over frames. The settings take turns, so that a machine that slows down affects all of them. The Pareto front \
is that of device time and RMSE.

Interrupted runs: DIR/tradeoff.partial.json keeps the measurements. The same command continues from there, also with another \
--quick, --only or --time.

Output: report.html (self-contained), tradeoff.csv, tradeoff.json; causes.csv, but for opaque points; popping.csv for a path; the figures as .svg; \
the pictures, and their differences from reference.png (10 times as bright), as .png.";

/// Refusal of clouds that stay in their files.
pub(super) const IN_FILES: &str =
    "this command needs all clouds in memory, but they take more than --host-memory allows";

#[derive(Debug, Args)]
#[command(after_help = ABOUT)]
pub struct TradeoffArgs {
    #[command(flatten)]
    pub input: InputArgs,
    /// Folder for the report; created if missing. Files of the same names are replaced.
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
    /// Measure fewer settings, for a first look or for CI.
    ///
    /// Three numbers of samples, two of k and two of layers, 3 frames, 4 seeds. --time then limits the whole run. One
    /// setting of each method is measured first, then a second one, and so on; settings that don't fit are listed with
    /// the reason.
    #[arg(long)]
    quick: bool,
    /// Compare only this method; repeatable. By default all methods.
    ///
    /// --method, like the method of a scene file, only selects the kind of discs.
    #[arg(long, value_name = "NAME", value_parser = method_names())]
    only: Vec<String>,
    /// Time for rendering in seconds; by default 360, with --quick 55 for the whole run.
    ///
    /// Slow settings get fewer frames and seeds. A setting whose frame takes more than a 60th of this time is measured
    /// once. A setting is skipped if its frame is predicted to take more than an 8th of this time, or more than the
    /// rest of it; the prediction comes from cheaper settings of the same method.
    #[arg(long, value_name = "SECONDS", value_parser = seconds())]
    time: Option<f64>,
    /// The picture that errors are measured against, center or area.
    ///
    /// center: the exact picture with the scene's samples, by default the center of each pixel. area: the exact picture
    /// with 64 samples of each pixel's area, or 16 if 64 take more than a tenth of --time. Each setting is then
    /// measured with 1, 4 and 16 samples: what its error costs, whether it comes from the method or from the samples.
    #[arg(long, value_name = "PICTURE", default_value = "center", value_parser = one_of(AGAINST))]
    against: Against,
    #[command(flatten)]
    along: PathArgs,
    /// Number of frames for --path or --turntable.
    ///
    /// The report then also has the popping of the approximate methods, or of those given by --only: how their errors
    /// change from frame to frame. That takes one frame per method and camera in addition to --time. The rest of the
    /// report is about the first frame.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(2..=100_000), help_heading = super::headings::FRAMES)]
    frames: Option<u32>,
    #[command(flatten)]
    device: DeviceArgs,
    /// Print the contents of tradeoff.json instead of the summary.
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
        let (settings, _) = candidates::settings(&occasion, &Ladders::QUICK);
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
    fn check_popping(&self, prepared: &Prepared, cameras: &[Camera]) -> Result<()> {
        let Some(option) = self.along.option() else { return Ok(()) };
        let (method, points) = (prepared.scene().method.representative(), prepared.points());
        if prepared.assembled.stored().is_some() {
            return Err(usage(IN_FILES));
        }
        if popping::reference(&method, points).is_none() {
            let name = method.name();
            return Err(usage(format!(
                "{option} measures popping of discs, soft spheres and opaque points, not of {name}"
            )));
        }
        match cameras.len() {
            0 | 1 => Err(usage(format!("{option} has one frame, but popping needs at least two"))),
            _ => Ok(()),
        }
    }
}

impl Touches for TradeoffArgs {
    fn touched(&self) -> Result<Touched> {
        let written = Output::folder("-o", &self.output, tradeoff::FILES);
        Ok(Touched::reads(self.along.reads(&self.input)).and([written]))
    }
}

pub fn run(args: TradeoffArgs, console: Console) -> Result<()> {
    let begin = Instant::now();
    output::check_report_folder(&args.output)?;
    let progress = console.progress();
    let frame = FrameRequest { memory_budget: args.device.budget(), ..FrameRequest::default() };
    let along = args.course(console)?;
    let size = along.as_ref().and_then(Along::size);
    let mut request = Request { frame, ..args.input.request(size, &progress)? };
    request.wanted.radii = true;
    let (prepared, stated) = match along {
        Some(along) => along.prepare(request, &progress)?,
        None => {
            let opened = Opened::new(request, &progress, &progress)?;
            if matches!(opened.sources.clouds(), Clouds::Stored(_)) {
                return Err(usage(IN_FILES));
            }
            (opened.prepare(&progress, &progress)?, Vec::new())
        }
    };
    let cameras: Vec<Camera> = stated.into_iter().map(Camera::from).collect();
    args.check_popping(&prepared, &cameras)?;
    let formation = candidates::compared(&prepared.scene().method.representative(), prepared.points())?;
    let (prepared, factors) = match prepared.see_through() {
        None => (prepared, Factors::default()),
        Some(_) => {
            let mut session = Session::upload(&args.device.open(&progress)?, prepared, false, &progress)?;
            session.find_opacity()?;
            session.describe_opacity(&progress);
            let factors = session.frame.factors;
            (session.prepared, factors)
        }
    };
    progress.stage("uploading");
    let device = Device::open(&args.device.options())?;
    console.detail(format_args!("device {} ({})", device.info().name, device.info().driver));
    let scene = prepared.scene();
    let mut shading = scene.shading;
    if shading.edl.edl && !matches!(formation, Formation::Surfaces(_)) {
        console.warn("eye-dome lighting is left out, because not all compared methods support it");
        shading.edl.edl = false;
    }
    let without = without_soft_points(prepared.points(), &scene.method.representative());
    without.iter().for_each(|warning| console.warn(warning));
    let shadows = scene.shadows.filter(|_| matches!(formation, Formation::Surfaces(_)));
    let frame = Frame { shading, shadows, detail: Default::default(), factors, ..prepared.frame() };
    let background = scene.image.background.color();
    let (arranged, scene) = (prepared.assembled.arranged(), prepared.request.name.as_str());
    let subject = MeasuredScene { arranged, frame, background, scene, cameras: &cameras };
    progress.counted("tradeoff", 1);
    let options = Options::new(args.quick, begin, args.only.clone(), args.time, command());
    let options = Options { against: args.against, ..options };
    let report = tradeoff::run(&device, &subject, &options, &args.output, &progress)?;
    progress.stage("writing the report");
    tradeoff::write(&args.output, &report)?;
    tradeoff::discard(&args.output)?;
    progress.finish_and_clear();
    warn_of_left_out(&report, console);
    if report.sittings > 1 {
        console.detail(format_args!("measured in {} runs; results of earlier runs were kept", report.sittings));
    }
    if args.json {
        let value =
            serde_json::to_value(&report).map_err(|error| output::Error::Report { reason: error.to_string() })?;
        return console.print_json(&value);
    }
    console.print(&summary(&report, &args))
}

/// Names the settings that were left out because of the time.
fn warn_of_left_out(report: &Tradeoff, console: Console) {
    let name = |skipped: &Skipped| format!("{} {}", skipped.method, skipped.setting.replace("method.", ""));
    let late: Vec<String> = report.skipped.iter().filter(|skipped| skipped.for_time).map(name).collect();
    if !late.is_empty() {
        let (count, late) = (late.len(), late.iter().map(|name| name.trim_end()).collect::<Vec<_>>().join(", "));
        console.note(format_args!("{count} setting(s) left out for lack of time (--time): {late}"));
    }
}

/// All rows, how much was skipped, and where the rest is.
fn summary(report: &Tradeoff, args: &TradeoffArgs) -> String {
    let error = metrics::error_text;
    let mib = |mib: f64| format!("{mib:.1}");
    let mut table = ReportTable::new(&report.rows)
        .text("front", |row| if row.front { "*" } else { "" })
        .text("method", |row| &row.method)
        .text("setting", |row| row.setting.replace("method.", ""))
        .number("median ms", |ms| format!("{ms:.2}"), |row| row.gpu_ms.median)
        .number("frames", page::count, |row| row.frames as f64)
        .number("RMSE", error, |row| row.errors.rmse)
        .number("FLIP", error, |row| row.errors.flip)
        .number("> 1/255", |share| format!("{:.2}%", 100.0 * share), |row| row.errors.above_1_255)
        .number("peak MiB", mib, |row| page::mib(row.peak_device_bytes))
        .number("lists MiB", mib, |row| page::mib(row.fragment_bytes));
    if report.surveyed.is_some() {
        table = table.number("holes", |share| format!("{:.3}%", 100.0 * share), |row| row.holes);
    }
    let area = report.area.as_ref().map_or_else(String::new, |area| format!("{}\n", area.text()));
    let holds = |holds| match holds {
        Some(true) => "holds here: ",
        Some(false) => "does not hold here: ",
        None => "",
    };
    let findings = report.findings.iter().map(|f| format!("{}\n  {}{}\n", f.claim, holds(f.holds), f.measured));
    let mut findings: String = findings.collect();
    if let Some(shaded) = &report.shaded {
        let step = |step: &ShadedStep| format!("{}: {:.2} ms, RMSE {}", step.samples, step.ms.median, error(step.rmse));
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
        "{}\n\n{}{area}* on the Pareto front: no other setting is at least as fast and as accurate, and better in one of the two.\n\
         {} settings measured, {} skipped; reasons and all figures: {}\n",
        table.terminal(),
        if findings.is_empty() { findings } else { format!("{findings}\n") },
        report.rows.len(),
        report.skipped.len(),
        args.output.join("report.html").display()
    )
}
