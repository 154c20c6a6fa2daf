//! Samples of lists, in place of what they are blended to.

use super::{Blender, Blending};
use crate::gpu::{Recorder, Slice};
use crate::methods::Error;
use crate::methods::abuffer::Samples;
use crate::passes::compose;

impl Blender {
    /// Records the samples of a band's stored fragments, of every list in order.
    pub(in crate::methods) fn record_fragment_samples<'a>(
        &'a self,
        recorder: &mut Recorder<'a>,
        blending: &Blending<'a>,
        (sample_colors, sample_depths): (Slice<'a, [f32; 4]>, Slice<'a, [f32; 2]>),
    ) -> Result<(), Error> {
        let sorted = self.record_every_list(recorder, blending)?;
        let (composing, work, runs, fragments) = (sorted.composing, sorted.work, sorted.runs, sorted.fragments);
        let samples = Samples { composing, work, runs, fragments, sample_colors, sample_depths };
        let variant = compose::variant(sorted.cut, blending.job.raster.footprint, blending.job.discs.falloff);
        Ok(recorder.run(&samples, (), &self.over_runs().variant(variant))?)
    }
}
