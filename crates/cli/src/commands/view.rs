//! `pellucid view`.

use std::path::PathBuf;

use clap::Args;
use pellucid_core::camera::import::CameraSource;
use pellucid_session::Sources;
use pellucid_viewer::{Display, Options, Setup};

use super::Error;
use super::console::Console;
use super::input::InputArgs;
use super::options::{DeviceArgs, number};
use super::touched::{Touched, Touches};

/// Default size of the window, in columns and rows.
const SIZE: [u32; 2] = [1280, 720];

/// Drag to turn, right-drag to move, scroll to come nearer to what is under the pointer, double-click to turn about it,
/// fly with W, A, S, D, Q and E; F1 shows all keys. F12 saves the picture and a scene file from which `render` makes
/// the same picture, byte for byte. K makes the camera a key of a path, which Space plays and --path of `render` takes.
/// Files dropped onto the window are opened. --size is that of the window.
#[derive(Debug, Args)]
pub struct ViewArgs {
    #[command(flatten)]
    pub input: InputArgs,
    #[command(flatten)]
    device: DeviceArgs,
    /// Open with the key frames of this file.
    ///
    /// A JSON file (docs/camera-paths.md), a transforms.json of nerfstudio, a cameras.json of 3D Gaussian Splatting,
    /// or a COLMAP model.
    #[arg(long, value_name = "PATH")]
    path: Option<PathBuf>,
    /// Target time of a frame during motion, in milliseconds.
    ///
    /// Drafts leave out samples, pixels and points to stay within this time. At rest the picture is refined until it is
    /// complete.
    #[arg(long, value_name = "MS", default_value_t = 33.0, value_parser = number(|x| *x > 0.0 && x.is_finite(), "expected a number above 0"))]
    budget: f64,
}

impl Touches for ViewArgs {
    fn touched(&self) -> pellucid_engine::Result<Touched> {
        Ok(Touched::reads(self.input.reads().with(self.path.iter().flat_map(|path| CameraSource::files(path)))))
    }
}

pub fn run(args: ViewArgs, console: Console) -> Result<(), Error> {
    // Before anything is read: without a display that would be in vain.
    let display = Display::connect()?;
    let ViewArgs { input, device, path, budget } = args;
    let cameras = path.as_deref().map(CameraSource::read).transpose().map_err(pellucid_engine::Error::from)?;
    let progress = console.progress();
    let (named, request) = input.named(None, &progress)?;
    let setup = Setup { seed: input.seed, memory_budget: device.budget(), host_memory: request.limits.memory };
    let sources = Sources::open(&named.input, &request.scene, setup.limits(), &progress, &progress)?;
    progress.finish_and_clear();
    let is_classified = sources.are_classified();
    if let Some(share) = request.see_through.and_then(|share| share.share(request.scene.method, is_classified)) {
        console.note(format_args!(
            "--see-through {share} has no effect in a window: set the opacity with its slider, or use the one that \
             `pellucid render` prints"
        ));
    }
    let options = Options {
        named,
        sources,
        view: request.scene.camera.view,
        setup,
        device: device.options(),
        size: if input.size.is_some() || input.view.like.is_some() { request.scene.image.size } else { SIZE },
        budget_ms: budget,
        path: path.zip(cameras),
    };
    Ok(display.show(options, Box::new(move |line| console.detail(format_args!("view: {line}"))))?)
}
