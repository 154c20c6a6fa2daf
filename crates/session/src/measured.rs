//! Frames that are rendered to measure them.

use pellucid_engine::Result;
use pellucid_engine::methods::Rendered;

use crate::session::Session;

/// Frames after which one is as foreseen as it can be: one waits for its counts, one makes room for more, and one more
/// may have taken long, which has the next one wait.
const TRIES: usize = 4;

/// Renders frames of a session to measure them.
#[derive(Debug, Clone, Copy)]
pub struct Measuring {
    /// `true` for frames whose counts are foreseen, as those of a window or a film; `false` for frames that each wait
    /// for their own counts.
    pub steady: bool,
    /// `true` once a frame waited for its counts whatever was done.
    waits: bool,
}

impl Measuring {
    /// Begins.
    pub fn new(steady: bool) -> Self {
        Self { steady, waits: false }
    }

    /// Renders the session's frame twice: for the times of its passes, then for that of the whole frame. Returns the
    /// first with both; of its image only the lengths of lists are left, the rest is the renderer's again.
    ///
    /// # Errors
    /// Returns the errors of [`Session::render`].
    pub fn frame(&mut self, session: &mut Session) -> Result<Rendered> {
        let mut rendered = self.one(session, Session::render)?;
        let mut image = std::mem::take(&mut rendered.image);
        (rendered.image.fragments, rendered.image.samples) = (image.fragments.take(), image.samples);
        session.renderer.recycle(image);
        let whole = self.one(session, Session::render_whole)?;
        rendered.profile.total = whole.profile.total;
        session.renderer.recycle(whole.image);
        Ok(rendered)
    }

    /// Returns the reason why steady frames waited for their counts all the same, a phrase; `None` if they didn't.
    pub fn hindrance(&self, session: &Session, rendered: &Rendered) -> Option<&'static str> {
        let reason = || session.renderer.hindrance(&session.uploaded.cloud, rendered);
        self.waits.then(|| reason().unwrap_or("they have more than one result to wait for"))
    }

    fn one(&mut self, session: &mut Session, render: fn(&mut Session) -> Result<Rendered>) -> Result<Rendered> {
        if !self.steady {
            session.renderer.forget();
        }
        let mut rendered = render(session)?;
        if !self.steady || self.waits || rendered.profile.waits <= 1 {
            return Ok(rendered);
        }
        // Whatever went wrong in earlier frames counts no more.
        session.renderer.forget();
        for _ in 0..TRIES {
            session.renderer.recycle(rendered.image);
            rendered = render(session)?;
            if rendered.profile.waits <= 1 {
                return Ok(rendered);
            }
        }
        self.waits = true;
        Ok(rendered)
    }
}
