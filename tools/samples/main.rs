//! How pictures converge over the samples of a pixel's area, and how much of a slow turn flickers.
//!
//! ```sh
//! cargo run --release --example samples-experiments                  # the garden at 640 × 480
//! cargo run --release --example samples-experiments -- --scale 0.25  # at 160 × 120
//! ```
//!
//! The output is Markdown. Convergence: the root mean square over pixels and R, G, B of picture N less picture 64, in
//! linear light, over black, and the slope of its logarithm over that of N by least squares, N from 1 to 16: beyond,
//! errors of picture 64 itself count. An edge that N samples of a plain grid would leave with N^-½ falls as N^-¾ where
//! samples are spread evenly (Mitchell 1996, "Consequences of stratified sampling in graphics").
//!
//! Flicker: p_N(t) is the picture of frame t with N samples. A turn at constant speed moves every point by nearly the
//! same step from frame to frame, so that what changes otherwise is in second differences, Δ²p(t) = p(t−1) − 2 p(t) +
//! p(t+1). Those of picture 64 are what motion, occlusion and perspective leave. Flicker of N samples is the root mean
//! square over pixels, R, G, B and frames of Δ²p_N(t) − Δ²p_64(t).

use std::process::ExitCode;

use clap::Parser;
use glam::DVec3;
use pellucid_core::camera::path::Turntable;
use pellucid_core::camera::{Camera, Projection};
use pellucid_core::points::Points;
use pellucid_core::progress::Progress;
use pellucid_engine::Result;
use pellucid_engine::methods::{Frame, Renderer};
use pellucid_engine::passes::project::DeviceCloud;
use pellucid_gpu::{Device, DeviceOptions};
use pellucid_scene::prepare::{Arranged, order};
use pellucid_scene::{self as scene, Discs, Method, Scene, procedural};

#[derive(Debug, Parser)]
struct Args {
    /// Columns and rows over 640 and 480, from 0.05 to 1.
    #[arg(long, default_value_t = 1.0, value_parser = scale)]
    scale: f64,
    /// Points of the garden.
    #[arg(long, default_value_t = 200_000)]
    points: u32,
    /// Frames of the turn, each a tenth of a degree, at least 3.
    #[arg(long, default_value_t = 30)]
    frames: usize,
}

fn scale(text: &str) -> Result<f64, String> {
    text.parse().ok().filter(|x| (0.05..=1.0).contains(x)).ok_or_else(|| "expected a number from 0.05 to 1".into())
}

/// Numbers of samples of the table, and those the slope follows from.
const COUNTS: [u32; 6] = [1, 2, 4, 8, 16, 32];
const FITTED: usize = 5;
/// Numbers of samples of the turn, and those that stand for the whole area.
const TURNED: [u32; 3] = [1, 4, 16];
const MOST: u32 = 64;
/// Frames of a whole turn.
const TURN: usize = 3600;

fn main() -> ExitCode {
    let opened = Device::open(&DeviceOptions::from_env()).map_err(pellucid_engine::Error::from);
    match opened.and_then(|device| run(&Args::parse(), &device)) {
        Ok(text) => {
            println!("{text}");
            ExitCode::SUCCESS
        }
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::from(error.exit_status())
        }
    }
}

/// R, G, B of all pixels, premultiplied: over black.
type Picture = Vec<f64>;

/// A cloud on the device, and its frame.
struct Subject {
    name: &'static str,
    cloud: DeviceCloud,
    frame: Frame,
    /// The middle of its points.
    center: DVec3,
}

fn size(args: &Args) -> [u32; 2] {
    [640.0, 480.0].map(|side| (side * args.scale).round() as u32)
}

fn picture(renderer: &mut Renderer, subject: &mut Subject, camera: Camera, samples: u32) -> Result<Picture> {
    let frame = Frame { camera, samples, ..subject.frame };
    let image = renderer.render(&mut subject.cloud, &frame)?.image;
    let colors = image.rgba.iter().flat_map(|rgba| [rgba[0], rgba[1], rgba[2]]).map(f64::from).collect();
    renderer.recycle(image);
    Ok(colors)
}

/// Root mean square of a difference.
fn rms(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0.0), |(sum, count), v| (sum + v * v, count + 1.0));
    if count > 0.0 { f64::sqrt(sum / count) } else { 0.0 }
}

fn apart(a: &Picture, b: &Picture) -> f64 {
    rms(a.iter().zip(b).map(|(a, b)| a - b))
}

/// The slope of y over x by least squares, both as logarithms.
fn slope(points: &[(f64, f64)]) -> f64 {
    let logs: Vec<(f64, f64)> = points.iter().map(|(x, y)| (x.ln(), y.ln())).collect();
    let count = logs.len() as f64;
    let mean = |of: fn(&(f64, f64)) -> f64| logs.iter().map(of).sum::<f64>() / count;
    let (x, y) = (mean(|p| p.0), mean(|p| p.1));
    let products: f64 = logs.iter().map(|p| (p.0 - x) * (p.1 - y)).sum();
    products / logs.iter().map(|p| (p.0 - x).powi(2)).sum::<f64>()
}

/// RMSE of each number of samples against the most.
fn convergence(renderer: &mut Renderer, subject: &mut Subject) -> Result<Vec<f64>> {
    let camera = subject.frame.camera;
    let whole = picture(renderer, subject, camera, MOST)?;
    COUNTS.into_iter().map(|samples| Ok(apart(&picture(renderer, subject, camera, samples)?, &whole))).collect()
}

/// Flicker of each number of samples, and the second differences of the most.
fn flicker(renderer: &mut Renderer, subject: &mut Subject, frames: usize) -> Result<(Vec<f64>, f64)> {
    let Frame { camera, .. } = subject.frame;
    let turntable = Turntable::new(&camera, subject.center, DVec3::Z);
    let cameras: Vec<Camera> =
        turntable.frames(TURN).into_iter().take(frames).map(|pose| pose.camera(camera.near, camera.far)).collect();
    let mut film = |samples: u32| -> Result<Vec<Picture>> {
        cameras.iter().map(|camera| picture(renderer, subject, *camera, samples)).collect()
    };
    let whole = film(MOST)?;
    let second = |film: &[Picture], at: usize| film[0][at] - 2.0 * film[1][at] + film[2][at];
    let all = |film: &[Picture], less: &[Picture]| {
        let each = film.windows(3).zip(less.windows(3));
        rms(each.flat_map(|(film, less)| (0..film[0].len()).map(move |at| second(film, at) - second(less, at))))
    };
    let nothing = vec![vec![0.0; whole[0].len()]; whole.len()];
    let found = TURNED.into_iter().map(|samples| Ok(all(&film(samples)?, &whole))).collect::<Result<_>>()?;
    Ok((found, all(&whole, &nothing)))
}

/// A white disc of opacity 1 that covers half of the picture.
fn edge() -> Points {
    disc(vec![(DVec3::ZERO, 0.7)])
}

/// 40 000 white points of no radius on a grid that is turned against that of the pixels.
fn texture() -> Points {
    let (sin, cos) = 0.3f64.sin_cos();
    let at = |i: u32| [i % 200, i / 200].map(|v| f64::from(v) / 100.0 - 0.995);
    disc((0..40_000).map(at).map(|[x, y]| (DVec3::new(cos * x - sin * y, sin * x + cos * y, 0.0), 0.0)).collect())
}

fn disc(points: Vec<(DVec3, f32)>) -> Points {
    let count = points.len();
    let (positions, radii) = points.into_iter().unzip();
    order::canonical(Points {
        positions,
        radii,
        colors: vec![glam::Vec3::ONE; count],
        opacities: vec![1.0; count],
        ..Points::default()
    })
}

/// Points seen along −z, two units from top to bottom.
fn flat(renderer: &Renderer, args: &Args, name: &'static str, points: &Points, method: Method) -> Result<Subject> {
    let projection = Projection::Orthographic { height: 2.0 };
    let eye = DVec3::new(0.123, 0.045, 4.0);
    let camera = Camera::look_at(eye, eye - DVec3::Z, DVec3::Y, projection, 0.1, 10.0)
        .ok_or_else(|| scene::Error::Usage("no view".into()))?;
    let frame = Frame::new(camera, size(args), method);
    Ok(Subject { name, cloud: renderer.upload(points)?, frame, center: DVec3::ZERO })
}

/// The garden, as its scene has it.
fn garden(renderer: &Renderer, args: &Args, method: Option<(&'static str, Method)>) -> Result<Subject> {
    let parameters = [("points".to_owned(), f64::from(args.points))];
    let generated = procedural::build("garden", &parameters, 1).map_err(scene::Error::from)?;
    let whole = Scene::from_toml(&generated.scene_toml, "garden".as_ref())?;
    let clouds = scene::take_generated(&whole, &generated)?;
    let up = scene::up_axis(&clouds);
    let arranged = scene::arrange(&whole, clouds, 1, &Progress::hidden())?;
    let (camera, _) = scene::camera(&whole, arranged.points(), up)?;
    let frame = Frame { size: size(args), ..Frame::of_scene(&whole, camera, 1) };
    let (name, method) = method.unwrap_or(("garden, `abuffer`", frame.method));
    let center = arranged.points().bounds().map_or(DVec3::ZERO, |bounds| bounds.center());
    Ok(Subject { name, cloud: upload(renderer, &arranged)?, frame: Frame { method, samples: 1, ..frame }, center })
}

fn upload(renderer: &Renderer, arranged: &Arranged) -> Result<DeviceCloud> {
    Ok(renderer.upload(arranged)?)
}

fn subjects(renderer: &Renderer, args: &Args) -> Result<Vec<Subject>> {
    Ok(vec![
        flat(renderer, args, "an edge: one disc, `abuffer`", &edge(), Method::ABuffer(Discs::default()))?,
        flat(renderer, args, "fine texture: a turned grid, `points`", &texture(), Method::Points)?,
        garden(renderer, args, None)?,
        garden(renderer, args, Some(("garden, `points`", Method::Points)))?,
    ])
}

/// Measures all, and returns the page.
fn run(args: &Args, device: &Device) -> Result<String> {
    let mut renderer = Renderer::new(device)?;
    let [width, height] = size(args);
    let heads: Vec<String> = COUNTS.iter().map(|count| format!("N = {count}")).collect();
    let mut text = format!("{width} × {height}\n\n| RMSE against N = {MOST} | {} | slope |\n", heads.join(" | "));
    text += &format!("|---|{}\n", "--:|".repeat(COUNTS.len() + 1));
    let mut all = subjects(&renderer, args)?;
    for subject in &mut all {
        eprintln!("{}", subject.name);
        let found = convergence(&mut renderer, subject)?;
        let points: Vec<(f64, f64)> = COUNTS.into_iter().map(f64::from).zip(found.iter().copied()).collect();
        let cells: Vec<String> = found.iter().map(|rmse| format!("{rmse:.4}")).collect();
        text += &format!("| {} | {} | {:.2} |\n", subject.name, cells.join(" | "), slope(&points[..FITTED]));
    }
    let heads: Vec<String> = TURNED.iter().map(|count| format!("N = {count}")).collect();
    text += &format!("\n| flicker | {} | motion |\n|---|{}\n", heads.join(" | "), "--:|".repeat(TURNED.len() + 1));
    for subject in all.iter_mut().filter(|subject| subject.name.starts_with("garden")) {
        eprintln!("turn of {}", subject.name);
        let (found, motion) = flicker(&mut renderer, subject, args.frames.max(3))?;
        let cells: Vec<String> = found.iter().map(|rms| format!("{rms:.4}")).collect();
        text += &format!("| {} | {} | {motion:.4} |\n", subject.name, cells.join(" | "));
    }
    Ok(text)
}

#[cfg(test)]
mod tests {
    use pellucid_testing::with_device;

    use super::*;

    #[test]
    fn slopes_of_powers_are_their_exponents() {
        let of = |power: f64| slope(&[1.0, 2.0, 4.0, 8.0].map(|x: f64| (x, 3.0 * x.powf(power))));
        assert!((of(-0.75) + 0.75).abs() < 1e-12 && of(0.0).abs() < 1e-12);
    }

    /// N^-½ is what samples at random would give, N^-1 what none can where an edge goes through a pixel.
    #[test]
    fn an_edge_converges_faster_than_at_random_and_a_turn_flickers_less_with_more_samples() {
        with_device(|device| {
            let args = Args { scale: 0.1, points: 3000, frames: 3 };
            let mut renderer = Renderer::new(device).expect("a renderer");
            let mut all = subjects(&renderer, &args).expect("fit");
            let found = convergence(&mut renderer, &mut all[0]).expect("renders");
            let points: Vec<(f64, f64)> = COUNTS.into_iter().map(f64::from).zip(found).collect();
            let slope = slope(&points[..FITTED]);
            assert!((-1.0..-0.6).contains(&slope), "{slope}: {points:?}");
            let (found, motion) = flicker(&mut renderer, &mut all[2], args.frames).expect("renders");
            assert!(found[0] > found[1] && found[1] > found[2] && motion > 0.0, "{found:?}, {motion}");
            // Four times as many samples leave half or less, as at random.
            assert!(found[0] > 1.5 * found[1] && found[1] > 1.5 * found[2], "{found:?}");
        });
    }

    #[test]
    fn the_page_has_a_row_for_each_subject() {
        with_device(|device| {
            let args = Args::parse_from(["samples", "--scale", "0.05", "--points", "2000", "--frames", "3"]);
            let text = run(&args, device).expect("measured");
            assert_eq!(text.lines().filter(|line| line.starts_with("| garden")).count(), 4, "{text}");
            assert!(text.starts_with("32 × 24\n") && text.contains("| N = 32 | slope |"), "{text}");
        });
    }
}
