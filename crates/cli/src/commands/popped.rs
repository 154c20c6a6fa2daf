//! `render --popping`: how the error of the method changes from frame to frame.

use std::path::PathBuf;

use pellucid_core::image::Image;
use pellucid_core::metrics::error_text;
use pellucid_engine::Result;
use pellucid_engine::methods::{Frame, Renderer, Stop, linear};
use pellucid_lab::report::popping::{self, Candidate, Follower, Popping};
use pellucid_session::Session;

use super::console::Console;
use super::limit::usage;

/// The method's frames so far, and what renders the exact ones.
pub struct Popped {
    path: PathBuf,
    renderer: Renderer,
    /// The exact frame; its camera is replaced.
    frame: Frame,
    followed: Candidate,
    follower: Follower,
}

impl Popped {
    /// Begins a table in a file.
    ///
    /// # Errors
    /// A method whose frames no other one draws exactly.
    pub fn open(path: PathBuf, session: &Session) -> Result<Self> {
        let method = session.frame.method;
        let Some(exact) = popping::exact(&method, session.points()) else {
            let name = method.name();
            return Err(usage(format!("--popping measures transparent discs and soft spheres, not {name}")));
        };
        let mut frame = Frame { method: exact, stop: Stop::Exact, fragments: false, depths: false, ..session.frame };
        // A feature that the method's own frames lack is no error.
        frame.shading.edl.edl &= method.takes_edl();
        let followed = Candidate { method, setting: String::new() };
        let renderer = Renderer::new(&session.device)?;
        Ok(Self { path, renderer, frame, followed, follower: Follower::default() })
    }

    /// Takes a frame of the session as it was rendered.
    pub fn add(&mut self, session: &mut Session, image: &Image) -> Result<()> {
        let frame = Frame { camera: session.frame.camera, ..self.frame };
        let exact = self.renderer.render(&mut session.uploaded.cloud, &frame)?;
        session.device.check_validation()?;
        let background = session.scene().image.background.color();
        let linear = |image: &Image| linear(image, background, frame.color);
        self.follower.add(&linear(&exact.image)?, &linear(image)?);
        self.renderer.recycle(exact.image);
        Ok(())
    }

    /// Writes the table and prints the figures.
    pub fn finish(self, frames: usize, console: Console) -> Result<()> {
        let curve = self.follower.curve(&self.followed);
        let exact = popping::named(&self.frame.method);
        console.note(format_args!(
            "popping against {exact}: RMSE {} on the average, {} at worst (frame {}); mean FLIP {}",
            error_text(curve.mean_rmse),
            error_text(curve.worst_rmse),
            curve.worst_frame,
            error_text(curve.mean_flip)
        ));
        let found = Popping { exact, frames: frames as u32, curves: vec![curve], refused: Vec::new() };
        popping::write(&self.path, &found)?;
        Ok(())
    }
}
