//! Session with the scene of its requests.

use pellucid_engine::methods::see_through;
use pellucid_gpu::Device;
use pellucid_scene::Scene;
use pellucid_session::{Prepared, Request, Session, inputs};

use crate::failure::Failure;
use crate::request::{self, Ask, Changes};
use crate::scene::State;
use crate::talk::Talk;

/// Session with the scene that its requests change.
pub struct SceneSession {
    pub session: Session,
    state: State,
    /// `true` if points have radii whatever the method.
    radii: bool,
    /// Tables and keys that were changed last, and the keys then.
    parsed: Option<((Vec<String>, Changes), Scene)>,
}

impl SceneSession {
    /// Reads, arranges and uploads the points of a scene; with radii, if they are wanted, whatever the method.
    pub fn open(device: &Device, state: State, ask: &Ask, radii: bool, talk: &Talk) -> Result<Self, Failure> {
        ask.check()?;
        let mut parsed = None;
        let mut request = request(&state, &mut parsed, ask)?;
        request.wanted.radii = radii;
        let prepared = Prepared::new(request, talk, &talk.progress)?;
        talk.go_on()?;
        let session = Session::upload(device, prepared, false, &talk.progress)?;
        Ok(Self { session, state, radii, parsed })
    }

    /// Makes everything ready for the frame that is asked for.
    pub fn prepare(&mut self, ask: &Ask, talk: &Talk) -> Result<(), Failure> {
        ask.check()?;
        let mut request = request(&self.state, &mut self.parsed, ask)?;
        request.wanted.radii = self.radii;
        if self.session.update(request, talk, &talk.progress)? {
            self.session.warn(talk);
        }
        Ok(())
    }
}

/// Returns the request of a call. Keys are parsed again only if other ones change than in the call before.
fn request(state: &State, parsed: &mut Option<((Vec<String>, Changes), Scene)>, ask: &Ask) -> Result<Request, Failure> {
    let by = (ask.drop.clone(), ask.changes.clone());
    let scene = match parsed {
        Some((last, scene)) if *last == by => scene.clone(),
        _ => {
            let scene = request::lay_over(&mut state.document.clone(), &ask.drop, &ask.changes)?;
            *parsed = Some((by, scene.clone()));
            scene
        }
    };
    if let (Some(share), Some(reason)) = (ask.see_through, see_through::refusal(scene.method)) {
        return Err(Failure::Value(format!("see_through={share}: {reason}")));
    }
    let request = ask.request((state.name.clone(), state.input.clone()), (state.view, state.seed), scene)?;
    Ok(Request { inputs: inputs(&state.document), ..request })
}
