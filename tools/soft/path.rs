//! Fig. 8: time and fragments along a path.

use std::f64::consts::TAU;
use std::fmt::Write;
use std::path::Path;

use glam::DVec3;
use pellucid_core::camera::{Camera, Projection};
use pellucid_engine::Result;
use pellucid_engine::methods::{Frame, Renderer};
use pellucid_gpu::Device;
use pellucid_lab::report::plot::{Axis, Figure, Panel, Point, Series};
use pellucid_lab::report::stress::Spread;
use pellucid_scene::{BlendedSplats, Method};

use super::scenes::SoftScene;
use super::{Contender, gpu_ms};

/// Eye to center, over the diagonal of the scene's box, at the path's ends and in its middle: into the scene and out
/// again.
const FAR: f64 = 0.9;
const CLOSE: f64 = 0.15;
/// Height of the eye above the center over its distance.
const RISE: f64 = 0.3;

/// Milliseconds and fragments of one frame of each method.
type PathFrame = Vec<(f64, u64)>;

/// Writes `path.csv`, `path-time.svg` and `path-fragments.svg`.
pub fn measure(device: &Device, subject: &SoftScene, count: usize, folder: &Path) -> Result<()> {
    let mut cloud = Renderer::new(device)?.upload(&subject.points)?;
    let soft = subject.soft;
    let mut all = [
        Contender::new(device, "splats", Method::Splats(BlendedSplats::default()))?,
        Contender::new(device, "soft-base", Method::SoftBase(soft))?,
        Contender::new(device, "soft-concentric", Method::SoftConcentric(soft))?,
        Contender::new(device, "soft-express", Method::SoftExpress(soft))?,
    ];
    let mut places: Vec<PathFrame> = Vec::new();
    // Once around without looking at the times: pipelines and buffers.
    for (round, step) in [0, count / 2].into_iter().chain(0..count).enumerate() {
        let frame = Frame { camera: camera(subject, step, count), ..subject.frame };
        let mut place = PathFrame::new();
        for contender in &mut all {
            let rendered = contender.render(&mut cloud, &frame)?;
            place.push((gpu_ms(&rendered), rendered.facts.fragments));
        }
        if round >= 2 {
            places.push(place);
        }
    }
    let names = all.map(|contender| contender.name);
    let median = |index: usize| Spread::from_values(places.iter().map(|place| place[index].0).collect()).median;
    println!(
        "path of {count} frames, median ms: {}",
        (0..4).map(|i| format!("{} {:.1}", names[i], median(i))).collect::<Vec<_>>().join(", ")
    );
    let [.., express] = names;
    for (index, name) in names.iter().enumerate().take(3).skip(1) {
        let over = Spread::from_values(places.iter().map(|place| place[index].0 / place[3].0).collect());
        println!("{name} / {express}: median {:.1}, at most {:.1}", over.median, over.max);
    }
    super::write(folder, "path.csv", &csv(&names, &places))?;
    let time = figure(&names, &places, "device time of a frame in ms", |place| place.0);
    let fragments = figure(&names, &places, "fragments", |place| place.1 as f64);
    super::write(folder, "path-time.svg", &svg(&time)?)?;
    super::write(folder, "path-fragments.svg", &svg(&fragments)?)
}

/// Returns a camera on a turn around the center of the scene's box, closest halfway.
fn camera(subject: &SoftScene, step: usize, count: usize) -> Camera {
    let bounds = subject.points.bounds().expect("assembled scenes have points");
    let (given, share) = (subject.frame.camera, step as f64 / count as f64);
    let diagonal = (bounds.max - bounds.min).length();
    let away = CLOSE + (FAR - CLOSE) * (share * TAU / 2.0).cos().abs();
    // Around the vertical that the scene's own camera shows.
    let axes = [DVec3::Y, DVec3::Z, DVec3::X];
    let up = axes.into_iter().max_by(|a, b| given.up.dot(*a).total_cmp(&given.up.dot(*b))).unwrap_or(DVec3::Y);
    let side = up.any_orthonormal_vector();
    let around = side * (share * TAU).cos() + up.cross(side) * (share * TAU).sin();
    let (center, eye) = (bounds.center(), bounds.center() + away * diagonal * (around + RISE * up).normalize());
    let projection = Projection::Perspective { fov_y: 45f64.to_radians() };
    Camera::look_at(eye, center, up, projection, 1e-3 * diagonal, 3.0 * diagonal).unwrap_or(given)
}

fn csv(names: &[&str], places: &[PathFrame]) -> String {
    let columns = names.iter().flat_map(|name| [format!("{name} ms"), format!("{name} fragments")]);
    let mut text = format!("frame,{}\n", columns.collect::<Vec<_>>().join(","));
    for (frame, place) in places.iter().enumerate() {
        let cells = place.iter().map(|(ms, fragments)| format!("{ms},{fragments}"));
        let _ = writeln!(text, "{frame},{}", cells.collect::<Vec<_>>().join(","));
    }
    text
}

fn figure(names: &[&str], places: &[PathFrame], label: &'static str, value: impl Fn((f64, u64)) -> f64) -> Figure {
    let series = |(index, _): (usize, &&str)| {
        let point = |(frame, place): (usize, &PathFrame)| Point::new(frame as f64, value(place[index]));
        // A method without lists has no fragments to count.
        Series::new(index, places.iter().enumerate().map(point).filter(|point| point.y > 0.0))
    };
    let panels = vec![Panel::new("", names.iter().enumerate().map(series))];
    let names = names.iter().map(|name| (*name).to_owned()).collect();
    let (x, y) = (Axis::even("frame of the path"), Axis::tens(label, 1e-3));
    Figure { panel: [760, 420], ..Figure::in_rows(420, names, x, y, panels) }
}

fn svg(figure: &Figure) -> Result<String> {
    Ok(figure.svg().map_err(|error| pellucid_io::output::Error::Report { reason: error.to_string() })?)
}
