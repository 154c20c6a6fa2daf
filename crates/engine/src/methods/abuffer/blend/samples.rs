//! Samples of lists, in place of what they are blended to.

use super::{Blender, Stored};
use crate::gpu::{Recorder, Slice};
use crate::methods::abuffer::{LOCAL_LENGTH, Samples, WindowJob};
use crate::methods::{Error, ellipsoids, soft};
use crate::passes::bands::Band;
use crate::passes::compose;

impl Blender {
    /// Records the samples of a band's stored fragments, of every list in order; `bodies` if each ellipsoid is one.
    pub(in crate::methods::abuffer) fn record_samples<'a>(
        &'a self,
        recorder: &mut Recorder<'a>,
        (job, bodies): (&WindowJob<'a>, bool),
        stored: Stored<'a>,
        (band, longest): (&Band, u32),
        (sample_colors, sample_depths): (Slice<'a, [f32; 4]>, Slice<'a, [f32; 2]>),
    ) -> Result<(), Error> {
        let sorted = self.record_every_list(recorder, job, stored, band, longest)?;
        let (to, several) = ((sample_colors, sample_depths), longest > LOCAL_LENGTH);
        if job.storing.are_ellipsoids() {
            return self.ellipsoids.record_samples(recorder, &sorted, (several, bodies), to);
        }
        let ellipsoids::Sorted { composing, cut, falloff, work, runs, lists, fragments, partials } = sorted;
        if let Some(spheres) = job.storing.spheres() {
            let sorted =
                soft::Sorted { composing, cut, work, runs, lists, fragments, records: stored.records, partials };
            let sums = (several, self.ellipsoids.sums());
            return soft::record_samples(recorder, spheres, &sorted, sums, to);
        }
        let samples = Samples { composing, work, runs, fragments, sample_colors, sample_depths };
        let variant = compose::variant(cut, job.raster.footprint, falloff);
        Ok(recorder.run(&samples, (), &self.over_runs().variant(variant))?)
    }
}
