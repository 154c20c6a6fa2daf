//! `one-layer`: the nearest soft points make a transparent layer before everything else, which is opaque (Seemann et
//! al. 2018). Three-pass splats ([`super::splats`]) of the soft points give the layer; those of all points, soft ones
//! only where they lie behind it, give the rest.
//!
//! Reference: `pellucid_reference::one_layer`.

mod engine;

pub(crate) use engine::{OneLayerEngine, pass_group};

use super::{Error, Pixels, PixelsGroup};
use crate::gpu::shader::Shader;
use crate::gpu::{Dispatch, Recorder, Run};
use crate::passes::bands::{self, Window};
use crate::{gpu_struct, pass};

gpu_struct! {
    /// Push constants of `one-layer/compose`: pixels of the window, and the layer's opacity.
    pub struct ComposePush {
        count: u32,
        softness: f32, // Opacity of the layer.
    }
}

pass! {
    /// Composes the splats of the soft points over those of all others in each pixel, where they lie before the solid
    /// ones.
    pub Compose(ComposePush) = "one-layer/compose" in "one_layer/compose" {
        layer: Read<[f32; 4]>,
        layer_depths: Read<f32>,
        into: Shared<PixelsGroup>,
    }
}

/// Records the layer of a window over the opaque pixels.
pub fn record<'a>(
    recorder: &mut Recorder<'a>,
    layer: Pixels<'a>,
    onto: Pixels<'a>,
    window: Window,
    softness: f32,
) -> Result<(), Error> {
    let pixels = bands::pixels(window);
    let pass = Compose { layer: layer.image, layer_depths: layer.depths, into: onto };
    let push = ComposePush { count: pixels as u32, softness };
    Ok(recorder.run(&pass, push, &Run::new(Dispatch::Invocations(pixels)))?)
}

/// Returns the pass.
pub fn shaders() -> Vec<Shader> {
    vec![Shader::plain::<Compose>()]
}
