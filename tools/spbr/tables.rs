//! Tanaka et al. 2016, Table 1, and Uchida et al. 2020, Table 1: what the pictures of the papers took, and what such
//! pictures of built-in scenes take here.

use std::fmt::Write;
use std::path::Path;

use pellucid_core::points::Points;
use pellucid_engine::Result;
use pellucid_engine::profile::median;
use pellucid_scene::{Brightness, Method, Spbr, SpbrSimplified};

use super::chart;
use super::scans;
use super::stage::Stage;

/// Frames behind a median, after one that pays for shaders and buffers.
const FRAMES: usize = 3;
/// Most points that a built-in scene has.
const MOST_POINTS: f64 = 2e8;

/// A picture of the papers.
struct Picture {
    table: &'static str,
    figure: &'static str,
    /// The built-in scene in place of the paper's.
    scene: &'static str,
    /// α of the clouds; the second one is that of the furniture. None where the points are not resampled.
    alphas: &'static [f64],
    ensembles: u32,
    size: [f64; 2],
    paper: Figures,
}

/// Figures of a picture.
#[derive(Clone, Copy)]
struct Figures {
    original: f64,
    adjusted: f64,
    /// Time for the adjustment; 0 where there is none.
    seconds: f64,
    fps: f64,
}

const PICTURES: [Picture; 5] = [
    Picture {
        table: "Tanaka et al.",
        figure: "Fig. 1",
        scene: "garden",
        alphas: &[0.2],
        ensembles: 500,
        size: [1024.0; 2],
        paper: Figures { original: 2.62e8, adjusted: 4.29e8, seconds: 58.4, fps: 3.55 },
    },
    Picture {
        table: "Tanaka et al.",
        figure: "Fig. 2",
        scene: "garden",
        alphas: &[0.25],
        ensembles: 500,
        size: [1024.0; 2],
        paper: Figures { original: 2.54e7, adjusted: 5.28e8, seconds: 80.7, fps: 1.62 },
    },
    Picture {
        table: "Uchida et al.",
        figure: "Fig. 1",
        scene: "garden",
        alphas: &[0.3],
        ensembles: 150,
        size: [1920.0, 1080.0],
        paper: Figures { original: 2.61e8, adjusted: 7.33e8, seconds: 85.77, fps: 3.61 },
    },
    Picture {
        table: "Uchida et al.",
        figure: "Fig. 3",
        scene: "terrain",
        alphas: &[],
        ensembles: 500,
        size: [1024.0; 2],
        paper: Figures { original: 9.44e8, adjusted: 9.44e8, seconds: 0.0, fps: 1.01 },
    },
    Picture {
        table: "Uchida et al.",
        figure: "Fig. 4",
        scene: "garden",
        alphas: &[0.3, 0.5],
        ensembles: 500,
        size: [1024.0; 2],
        paper: Figures { original: 7.89e6, adjusted: 1.49e8, seconds: 15.44, fps: 0.92 },
    },
];

/// A picture as it was measured here.
struct Measured {
    size: [u32; 2],
    /// α of each cloud; NaN if the points are too few to tell.
    alphas: Vec<f64>,
    /// n_raw of each cloud on the area of a pixel; NaN if unknown.
    per_pixel: Vec<f64>,
    figures: Figures,
}

/// Writes `tables.md` and `tables.csv`.
pub fn measure(stage: &mut Stage, scale: f64, folder: &Path) -> Result<()> {
    let (mut text, mut rows) = (String::new(), Vec::new());
    for (number, picture) in PICTURES.iter().enumerate() {
        if number == 0 || PICTURES[number - 1].table != picture.table {
            text += &head(picture.table);
        }
        let points = picture.paper.original * scale * scale;
        if points > MOST_POINTS {
            eprintln!("{}, {}: {points:.3e} points are more than a scene has", picture.table, picture.figure);
            continue;
        }
        let found = picture.measured(stage, points, picture.size.map(|side| (side * scale).round() as u32))?;
        text += &line(picture, &found);
        rows.push(record(number, picture, &found));
    }
    println!("{text}");
    super::write(folder, "tables.md", &text)?;
    let header = "picture,alpha,alpha of the furniture,ensembles,width,height,n_raw,original,adjusted,k,seconds,fps";
    super::write(folder, "tables.csv", &chart::csv(header, &rows))
}

impl Picture {
    fn measured(&self, stage: &mut Stage, points: f64, size: [u32; 2]) -> Result<Measured> {
        let clouds = self.clouds(scans::built_in(self.scene, points, stage.seed)?);
        let mut all = Points::default();
        clouds.iter().for_each(|cloud| all.append(cloud.clone()));
        let camera = scans::aslant(&all);
        drop(all);
        let method = self.method();
        let (mut cloud, seconds) = stage.upload_timed(clouds)?;
        let mut times = Vec::new();
        let mut adjusted = None;
        for number in 0..=FRAMES {
            let rendered = stage.rendered(&mut cloud, camera, size, method)?;
            adjusted = rendered.facts.adjusted;
            if number > 0 {
                times.push(rendered.profile.wall.as_secs_f64());
            }
        }
        let clouds = adjusted.map(|adjusted| adjusted.clouds).unwrap_or_default();
        let sum =
            |of: fn(&pellucid_engine::methods::spbr::Adjustment) -> u64| clouds.iter().map(of).sum::<u64>() as f64;
        Ok(Measured {
            size,
            alphas: clouds.iter().map(|cloud| cloud.opacity.unwrap_or(f64::NAN)).collect(),
            per_pixel: clouds.iter().map(|cloud| cloud.per_pixel.unwrap_or(f64::NAN)).collect(),
            figures: Figures {
                original: sum(|cloud| cloud.points),
                adjusted: sum(|cloud| cloud.adjusted),
                seconds,
                fps: median(times).recip(),
            },
        })
    }

    fn method(&self) -> Method {
        match self.alphas {
            [] => Method::SpbrSimplified(SpbrSimplified {
                ensembles: self.ensembles,
                brightness: Brightness::Factor(1.0),
            }),
            _ => Method::Spbr(Spbr { ensembles: self.ensembles, ..Spbr::default() }),
        }
    }

    /// All points as one cloud, or the furniture as another one, with their opacities.
    fn clouds(&self, parts: Vec<(String, Points)>) -> Vec<Points> {
        let [outer, inner @ ..] = self.alphas else { return vec![scans::merged(parts)] };
        let is_inner = |part: &(String, Points)| !inner.is_empty() && part.0.starts_with("furniture");
        let (within, around) = parts.into_iter().partition(is_inner);
        let with_opacity = |parts: Vec<_>, alpha: &f64| {
            let mut points = scans::merged(parts);
            points.opacities.fill(*alpha as f32);
            points
        };
        let mut clouds = vec![with_opacity(around, outer)];
        clouds.extend(inner.first().map(|alpha| with_opacity(within, alpha)));
        clouds
    }
}

fn head(table: &str) -> String {
    format!(
        "\n{table}, Table 1\n\n\
         | picture | α | L | resolution | original points | adjusted points | k | adjustment, s | frames/s |\n\
         |---|--:|--:|--:|--:|--:|--:|--:|--:|\n"
    )
}

/// The paper's line and the measured one.
fn line(picture: &Picture, found: &Measured) -> String {
    let mut text = String::new();
    let alphas = if picture.alphas.is_empty() { &[0.3] } else { picture.alphas };
    let size = picture.size.map(|side| side as u32);
    for (name, alphas, size, figures) in [
        (picture.figure.to_owned(), alphas, size, picture.paper),
        (format!("here: {}", picture.scene), &found.alphas, found.size, found.figures),
    ] {
        let alphas: Vec<_> = alphas.iter().map(|alpha| format!("{alpha:.2}")).collect();
        let Figures { original, adjusted, seconds, fps } = figures;
        let [width, height] = size;
        let time = if seconds > 0.0 { format!("{seconds:.3}") } else { "none".to_owned() };
        let _ = writeln!(
            text,
            "| {name} | {} | {} | {width} × {height} | {original:.3e} | {adjusted:.3e} | {:.2} | {time} | {fps:.2} |",
            alphas.join(", "),
            picture.ensembles,
            adjusted / original
        );
    }
    text
}

fn record(number: usize, picture: &Picture, found: &Measured) -> Vec<f64> {
    let Figures { original, adjusted, seconds, fps } = found.figures;
    let alpha = |place: usize| found.alphas.get(place).copied().unwrap_or(f64::NAN);
    let size = found.size.map(f64::from);
    let per_pixel = found.per_pixel.first().copied().unwrap_or(f64::NAN);
    let k = adjusted / original;
    let [width, height] = size;
    let ensembles = f64::from(picture.ensembles);
    vec![number as f64, alpha(0), alpha(1), ensembles, width, height, per_pixel, original, adjusted, k, seconds, fps]
}
