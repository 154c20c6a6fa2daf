//! The frame rates of Dobrev et al. (2010), Table 3, and what they say of them: local illumination, layers of surfaces,
//! and shadows of an area light, as times over that of local illumination.
//!
//! ```sh
//! cargo run --release --example layers-experiments                    # as many points as in the paper: 4 GB of memory
//! cargo run --release --example layers-experiments -- --scale 0.05    # a twentieth of the points of generated clouds
//! ```
//!
//! The output is Markdown. The paper's figures are ratios of its frame rates: 68 per second with local illumination and
//! 23 with three layers are 2.96. Real data (scans and volumes) are looked for in `PELLUCID_TEST_DATA`, else in
//! `shared/data` beside the repository; what is missing is listed below the table.

mod scenes;
mod table;

use std::path::Path;
use std::process::ExitCode;

use clap::Parser;
use pellucid_engine::Result;
use pellucid_engine::methods::{Frame, Renderer};
use pellucid_engine::passes::project::DeviceCloud;
use pellucid_gpu::{Device, DeviceOptions};
use pellucid_lab::report::stress::Spread;
use pellucid_scene::{ImageSpace, Method, PeelLayers, Shadows};

use scenes::{Loaded, Subject};
use table::{Fit, Line};

#[derive(Debug, Parser)]
struct Args {
    /// Points of generated clouds over the paper's, from 0.001 to 1.
    #[arg(long, default_value_t = 1.0, value_parser = scale)]
    scale: f64,
    /// Frames behind a median.
    #[arg(long, default_value_t = 3)]
    frames: usize,
    /// Only this data set; by default all, and fits over layers, points and pixels.
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
/// Sides of the images that time is fitted over.
const FITTED_SIDES: [u32; 4] = [256, 512, 1024, 2048];
/// Parts of the tori's points that time is fitted over.
const FITTED_PARTS: [f64; 4] = [0.125, 0.25, 0.5, 1.0];
/// Degrees around the direction of the light.
const LIGHT_RADIUS: f32 = 4.0;

/// Images of the table and of the fits.
struct Sizes {
    table: [u32; 2],
    fits: [u32; 4],
}

fn main() -> ExitCode {
    let sizes = Sizes { table: SIDES, fits: FITTED_SIDES };
    let args = Args::parse();
    let opened = Device::open(&DeviceOptions::from_env()).map_err(pellucid_engine::Error::from);
    match opened.and_then(|device| run(&args, &scenes::data(), &device, &sizes)) {
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

/// Measures all that is asked for, and returns the page.
fn run(args: &Args, data: &Path, device: &Device, sizes: &Sizes) -> Result<String> {
    let info = device.info();
    let mut text =
        format!("{} ({}), pellucid {}, scale {}\n\n", info.name, info.driver, env!("CARGO_PKG_VERSION"), args.scale);
    let mut stage = Stage { renderer: Renderer::new(device)?, frames: args.frames.max(1), seed: args.seed };
    let (mut lines, mut missing, mut pixels) = (Vec::new(), String::new(), Vec::new());
    for name in scenes::NAMES {
        if args.only.as_deref().is_some_and(|only| only != name) {
            continue;
        }
        match scenes::load(name, data, args.scale, args.seed)? {
            Loaded::Subject(subject) => {
                lines.extend(stage.lines(&subject, sizes.table)?);
                if args.only.is_none() {
                    pixels.push((name, stage.over_pixels(&subject, sizes.fits)?));
                }
            }
            Loaded::Missing(why) => missing += &format!("- {why}\n"),
        }
    }
    text += &table::markdown(&lines);
    if !missing.is_empty() {
        text += &format!("\n\nLeft out:\n\n{missing}");
    }
    if args.only.is_none() {
        let pixels = table::over_pixels(&pixels);
        text += &format!("\n\n{}\n- {pixels}", stage.fits(data, args.scale, sizes.table[1])?);
    }
    Ok(text)
}

struct Stage {
    renderer: Renderer,
    frames: usize,
    seed: u64,
}

impl Stage {
    /// A line of the table for each size of the image.
    fn lines(&mut self, subject: &Subject, sides: [u32; 2]) -> Result<Vec<Line>> {
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
        sides.iter().enumerate().map(&mut line).collect()
    }

    /// Times with local illumination over pixels.
    fn over_pixels(&mut self, subject: &Subject, sides: [u32; 4]) -> Result<Vec<(f64, f64)>> {
        let mut cloud = self.renderer.upload(&subject.points)?;
        let mut point = |side: u32| {
            let ms = self.ms(&mut cloud, subject, side, local(), None)?;
            Ok((f64::from(side).powi(2), ms))
        };
        sides.into_iter().map(&mut point).collect()
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
    fn fits(&mut self, data: &Path, scale: f64, side: u32) -> Result<String> {
        let (mut over_layers, mut over_points) = (Vec::new(), Vec::new());
        for part in FITTED_PARTS {
            eprintln!("fits, {part} of the tori");
            let Loaded::Subject(subject) = scenes::load(scenes::TORI, data, part * scale, self.seed)? else { continue };
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

#[cfg(test)]
mod tests {
    use pellucid_testing::with_device;

    use super::*;

    /// The whole command on few points and pixels.
    fn small(words: &[&str], data: &Path, device: &Device) -> String {
        let args = Args::parse_from([&["layers", "--scale", "0.001", "--frames", "1"], words].concat());
        let sizes = Sizes { table: [32, 64], fits: [16, 32, 64, 128] };
        run(&args, data, device, &sizes).expect("measured")
    }

    #[test]
    fn without_options_as_many_points_as_in_the_paper_are_measured() {
        let args = Args::parse_from(["layers"]);
        assert_eq!((args.scale, args.only), (1.0, None));
        assert_eq!(scenes::NAMES.len(), 6);
    }

    #[test]
    fn missing_data_is_named_below_the_table_and_the_tori_are_in_it() {
        with_device(assert_missing_data_is_named);
    }

    fn assert_missing_data_is_named(device: &Device) {
        let empty = tempfile::tempdir().expect("a folder");
        let text = small(&[], empty.path(), device);
        let rows: Vec<&str> = text.lines().filter(|line| line.starts_with("| tori |")).collect();
        assert!(rows.len() == 2 && rows[0].contains("| 32² |") && rows[1].contains("| 64² |"), "{text}");
        // Name, points, side, ms, and five ratios beside those of the paper.
        assert!(rows.iter().all(|row| row.matches('|').count() == 15), "{text}");
        for name in ["blade (883000", "buddha (543000", "dragon (437000", "neghip (128000", "hydrogen (535000"] {
            assert!(text.contains(&format!("- {name} points in the paper): no file")), "{name}: {text}");
        }
        for fit in ["linear in layers", "linear in points", "sublinear"] {
            assert!(text.contains(&format!("{fit}, as the paper says:")), "{fit}: {text}");
        }
    }

    #[test]
    fn a_volume_in_the_folder_is_in_the_table() {
        with_device(assert_volume_is_measured);
    }

    fn assert_volume_is_measured(device: &Device) {
        let folder = tempfile::tempdir().expect("a folder");
        std::fs::create_dir(folder.path().join("volumes")).expect("a folder");
        // A ball: values fall with the distance from the middle.
        let at = |i: usize| [i % 64, i / 64 % 64, i / 4096].map(|x| x as f64 - 31.5);
        let value = |i: usize| (255.0 - 8.0 * at(i).iter().map(|x| x * x).sum::<f64>().sqrt()).max(0.0) as u8;
        let bytes: Vec<u8> = (0..64 * 64 * 64).map(value).collect();
        std::fs::write(folder.path().join("volumes/neghip_64x64x64_uint8.raw"), bytes).expect("written");
        let text = small(&["--only", "neghip"], folder.path(), device);
        assert_eq!(text.lines().filter(|line| line.starts_with("| neghip |")).count(), 2, "{text}");
        assert!(!text.contains("Left out") && !text.contains("least squares"), "{text}");
    }
}
