//! Lists as samples on the host, for deep EXR: sorted as for an image, but read back and not blended.

use super::blend::Stored;
use super::capacity::Need;
use super::{ABuffer, Blending, ListsJob, RUN_PIXEL_BYTES, Sampled};
use crate::methods::prelude::*;

/// Bytes of a sample's color.
pub(super) const COLOR_BYTES: u64 = 16;
/// Bytes of a sample on the device and in the host memory that it sees.
pub(super) const SAMPLE_BYTES: u64 = 2 * (COLOR_BYTES + 8);

/// Samples of a band at most, unless a pixel has more: 96 MiB of them.
pub(super) const MOST_SAMPLES: u64 = 1 << 22;

/// Settings of samples.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Sampling {
    /// `true` if each ellipsoid is one sample, however many of them overlap.
    pub bodies: bool,
}

/// The samples of a band, as the device leaves them.
pub(crate) struct Taken<'a> {
    /// The pixels among those of the window.
    pub pixels: [u32; 2],
    /// Index in the band at which the list of each pixel begins, and the last ends.
    pub offsets: Vec<usize>,
    /// Color times opacity, and opacity; below 0 where there is no sample.
    pub colors: &'a [[f32; 4]],
    /// Depths at which each sample begins and ends.
    pub depths: &'a [[f32; 2]],
}

impl Taken<'_> {
    /// Returns so many pixels without a sample.
    pub fn nothing(pixels: u64) -> Self {
        Self { pixels: [0, pixels as u32], offsets: vec![0; pixels as usize + 1], colors: &[], depths: &[] }
    }
}

fields! {
    /// Buffers of samples, kept from window to window.
    pub(super) struct Buffers {
        colors: Scratch<[f32; 4]> = Scratch::new("sample colors", Memory::Device),
        depths: Scratch<[f32; 2]> = Scratch::new("sample depths", Memory::Device),
        colors_host: Scratch<[f32; 4]> = Scratch::new("sample colors, host", Memory::Readback),
        depths_host: Scratch<[f32; 2]> = Scratch::new("sample depths, host", Memory::Readback),
    }
}

impl Buffers {
    /// Reserves room for so many samples, but not for more than the limit.
    pub fn reserve(&mut self, device: &Device, [samples, limit]: [u64; 2]) -> Result<(), Error> {
        self.colors.reserve_within(device, samples, limit)?;
        self.depths.reserve_within(device, samples, limit)?;
        self.colors_host.reserve_within(device, samples, limit)?;
        self.depths_host.reserve_within(device, samples, limit)?;
        Ok(())
    }
}

impl ListsJob<'_> {
    /// Returns the number of device bytes of a pixel for the runs of its list, where every list has some.
    pub(super) fn run_bytes(&self) -> u64 {
        if self.samples.is_some() && !self.storing.needs().every_run { RUN_PIXEL_BYTES } else { 0 }
    }
}

impl ABuffer {
    /// Counts, then stores, sorts and reads back band by band, the window's pixels in their order. With
    /// [`Work::survey`] nothing is read. Returns how many samples there are at most, or `None` if the window must be
    /// cut.
    pub(crate) fn samples(
        &mut self,
        work: &mut Work<'_>,
        job: &ListsJob<'_>,
        how: Sampling,
        take: &mut dyn FnMut(&Taken<'_>) -> Result<(), Error>,
    ) -> Result<Option<u64>, Error> {
        let device = work.device;
        let counted = self.count(device, job, false, work.timeline)?;
        if counted.overflow {
            return Ok(None);
        }
        let each = u64::from(job.samples.unwrap_or(1));
        let most = job.storing.most_samples(counted.total.into(), counted.bodies.into()) * each;
        if work.survey {
            counted.note(&[], work.facts);
            return Ok(Some(most));
        }
        let bands = self.plan_bands(work, job, &counted)?;
        self.reserve_fragments(device, job, &bands, &counted)?;
        let offsets = self.room.offsets.get().read(0, bands::pixels(job.raster.window) + 1)?;
        let cut = Cut::of(device, job.raster.cloud, job.raster.footprint)?;
        let stored = Stored::of(&self.room, cut, Need::for_window(job, &counted).spare);
        for band in &bands {
            let count = band.fragments * each;
            if count > 0 {
                let (colors, depths) = (self.taken.colors.get(), self.taken.depths.get());
                let mut recorder = work.timeline.recorder(device)?;
                self.record_store(&mut recorder, job, band, &counted)?;
                let (blender, lengths, target) = (&self.blender, counted.lengths, work.target);
                let blending = Blending { job: *job, stored, band: *band, lengths, blender, target };
                let samples = Sampled { sample_colors: colors.all(), sample_depths: depths.all() };
                job.storing.record_samples(&mut recorder, &blending, how.bodies, samples)?;
                recorder.copy_untimed(colors.slice(0, count), self.taken.colors_host.get().slice(0, count));
                recorder.copy_untimed(depths.slice(0, count), self.taken.depths_host.get().slice(0, count));
                work.timeline.submit(recorder, "abuffer/samples")?;
            }
            take(&self.taken_of(band, &offsets, each))?;
            work.progress.inc(u64::from(band.pixels[1] - band.pixels[0]));
        }
        counted.note(&bands, work.facts);
        Ok(Some(most))
    }

    /// The samples of a band that was submitted.
    fn taken_of(&self, band: &Band, offsets: &[u32], each: u64) -> Taken<'_> {
        let [start, end] = band.pixels.map(|pixel| pixel as usize);
        let place = |offset: &u32| (u64::from(offset - band.first_fragment) * each) as usize;
        let count = (band.fragments * each) as usize;
        Taken {
            pixels: band.pixels,
            offsets: offsets[start..=end].iter().map(place).collect(),
            colors: &self.taken.colors_host.get().mapped_slice()[..count],
            depths: &self.taken.depths_host.get().mapped_slice()[..count],
        }
    }
}
