//! The frame rates of Dobrev et al. (2010), Table 3, and what they say of them: local illumination, layers of surfaces,
//! and shadows of an area light, as times over that of local illumination.
//!
//! ```sh
//! cargo run --release --example layers-experiments                    # a twentieth of the points of generated clouds
//! cargo run --release --example layers-experiments -- --scale 1       # all of them: 4 GB of memory
//! ```
//!
//! The output is Markdown. The paper's figures are ratios of its frame rates: 68 per second with local illumination and
//! 23 with three layers are 2.96. Real data (the dragon, the volumes) are looked for in `PELLUCID_TEST_DATA`, else
//! beside the project; what is missing is left out with a note.

mod scenes;
mod table;

use std::process::ExitCode;

use clap::Parser;
use pellucid_engine::Result;
use pellucid_engine::methods::{Frame, Renderer};
use pellucid_engine::passes::project::DeviceCloud;
use pellucid_gpu::{Device, DeviceOptions};
use pellucid_lab::report::stress::Spread;
use pellucid_scene::{ImageSpace, Method, PeelLayers, Shadows};

use scenes::Subject;
use table::{Fit, Line};

#[derive(Debug, Parser)]
struct Args {
    /// Points of generated clouds over the paper's, from 0.001 to 1.
    #[arg(long, default_value_t = 0.05, value_parser = scale)]
    scale: f64,
    /// Frames behind a median.
    #[arg(long, default_value_t = 3)]
    frames: usize,
    /// Only this data set: dragon, tori, neghip or hydrogen.
    #[arg(long, value_parser = scenes::NAMES)]
    only: Option<String>,
    /// Seed of clouds and of lights.
    #[arg(long, default_value_t = 1)]
    seed: u64,
}

fn scale(text: &str) -> Result<f64, String> {
    text.parse().ok().filter(|x| (0.001..=1.0).contains(x)).ok_or_else(|| "expected a number from 0.001 to 1".into())
}

/// Sides of the images.
const SIDES: [u32; 2] = [512, 1024];
/// Layers of the table, and those that time is fitted over.
const LAYERS: [u32; 2] = [3, 6];
const FITTED_LAYERS: [u32; 6] = [1, 2, 3, 4, 5, 6];
/// Samples of the light.
const SAMPLES: [u32; 3] = [1, 5, 10];
/// Parts of the tori's points that time is fitted over.
const FITTED_PARTS: [f64; 4] = [0.125, 0.25, 0.5, 1.0];
/// Degrees around the direction of the light.
const LIGHT_RADIUS: f32 = 4.0;

fn main() -> ExitCode {
    match run(&Args::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::from(error.exit_status())
        }
    }
}

fn run(args: &Args) -> Result<()> {
    let device = Device::open(&DeviceOptions::from_env())?;
    let info = device.info();
    println!("{} ({}), pellucid {}, scale {}\n", info.name, info.driver, env!("CARGO_PKG_VERSION"), args.scale);
    let mut stage = Stage { renderer: Renderer::new(&device)?, frames: args.frames.max(1), seed: args.seed };
    let mut lines = Vec::new();
    for name in scenes::NAMES {
        if args.only.as_deref().is_none_or(|only| only == name) {
            match scenes::load(name, args.scale, args.seed)? {
                Some(subject) => lines.extend(stage.lines(&subject)?),
                None => eprintln!("{name} is left out: its file is not there"),
            }
        }
    }
    println!("{}", table::markdown(&lines));
    if args.only.is_none() {
        println!("{}", stage.fits(args.scale)?);
    }
    Ok(())
}

struct Stage {
    renderer: Renderer,
    frames: usize,
    seed: u64,
}

impl Stage {
    /// A line of the table for each size of the image.
    fn lines(&mut self, subject: &Subject) -> Result<Vec<Line>> {
        let mut cloud = self.renderer.upload(&subject.points)?;
        let mut line = |size: (usize, &u32)| -> Result<Line> {
            let (place, side) = size;
            let side = *side;
            eprintln!("{}, {side} × {side}", subject.name);
            let mut ms = vec![self.ms(&mut cloud, subject, side, local(), None)?];
            for layers in LAYERS {
                ms.push(self.ms(&mut cloud, subject, side, layered(layers), None)?);
            }
            for samples in SAMPLES {
                ms.push(self.ms(&mut cloud, subject, side, local(), Some(samples))?);
            }
            let paper = subject.paper[place];
            Ok(Line { name: subject.name, points: subject.points.len(), side, ms, paper })
        };
        SIDES.iter().enumerate().map(&mut line).collect()
    }

    /// Median device time of a frame. Shadows are cast anew in each: their lights follow the seed.
    fn ms(
        &mut self,
        cloud: &mut DeviceCloud,
        subject: &Subject,
        side: u32,
        method: Method,
        samples: Option<u32>,
    ) -> Result<f64> {
        let shadows = samples.map(|samples| Shadows { samples, light_radius: LIGHT_RADIUS, ..Shadows::default() });
        let mut times = Vec::new();
        // The first one pays for shaders and buffers.
        for number in 0..=self.frames as u64 {
            let seed = self.seed.wrapping_add(number);
            let frame =
                Frame { shading: subject.shading, seed, shadows, ..Frame::new(subject.camera, [side; 2], method) };
            let rendered = self.renderer.render(cloud, &frame)?;
            self.renderer.recycle(rendered.image);
            if number > 0 {
                times.push(rendered.profile.gpu().as_secs_f64() * 1e3);
            }
        }
        Ok(Spread::from_values(times).median)
    }

    /// Fits lines to the times of the tori, over layers and over points.
    fn fits(&mut self, scale: f64) -> Result<String> {
        let side = SIDES[1];
        let (mut over_layers, mut over_points) = (Vec::new(), Vec::new());
        for part in FITTED_PARTS {
            eprintln!("fits, {part} of the tori");
            let Some(subject) = scenes::load(scenes::TORI, part * scale, self.seed)? else { continue };
            let mut cloud = self.renderer.upload(&subject.points)?;
            let ms = self.ms(&mut cloud, &subject, side, local(), None)?;
            over_points.push((subject.points.len() as f64 / 1e6, ms));
            if part == 1.0 {
                for layers in FITTED_LAYERS {
                    over_layers.push((f64::from(layers), self.ms(&mut cloud, &subject, side, layered(layers), None)?));
                }
            }
        }
        let layers = Fit::through(&over_layers).told("layers of the tori", "a layer", "linear in layers");
        let points = Fit::through(&over_points).told("millions of points of the tori", "a million", "linear in points");
        Ok(format!("Time of a frame of {side} × {side} pixels, by least squares:\n\n- {layers}\n- {points}"))
    }
}

/// Returns a single step of each filter that fills holes, as in the table.
fn local() -> Method {
    Method::ImageSpace(ImageSpace::default())
}

fn layered(layers: u32) -> Method {
    Method::PeelLayers(PeelLayers { layers, ..PeelLayers::default() })
}
