//! The samples of a pixel's area of a session's pictures: how many there are, and the error that they leave.

use pellucid_core::image::{Image, LinearImage};
use pellucid_engine::Result;
use pellucid_engine::methods::{self, Outputs, Rendered, brightness};
use pellucid_gpu::MemoryBudget;
use pellucid_scene::{ImageSettings, Samples};

use super::Session;
use crate::area::{self, Sampling};
use crate::messages::Messages;
use crate::notes;
use crate::samples::{SettledSamples, Settling};

/// Time that a picture's sampling error may take to measure, in seconds.
const SAMPLING_SECONDS: f64 = 2.0;

impl Session {
    /// Finds the number of samples that `image.samples = "auto"` asks for, and says so: pictures of 2, 4, 8 and so on
    /// are rendered until one differs from the one before by `image.sampling_error` at most. Returns the last one, as
    /// [`Self::render`] would render it; `None` where the number is given, or settled already. With a share of light
    /// each of these pictures has the opacity that was found for its own number.
    ///
    /// # Errors
    /// Returns the errors of [`Self::render`].
    pub fn settle(&mut self, messages: &dyn Messages) -> Result<Option<Rendered>> {
        if !self.is_unsettled() {
            return Ok(None);
        }
        let mut settling = Settling::new(self.scene().image.sampling_error);
        let (settled, rendered) = loop {
            self.frame.samples = settling.samples();
            self.refind_opacity()?;
            self.progress.set_message(format!("{} samples per pixel", self.frame.samples));
            let rendered = self.render()?;
            if let Some(settled) = settling.take(self.shown(&rendered.image)?) {
                break (settled, rendered);
            }
            self.renderer.recycle(rendered.image);
        };
        self.progress.set_message("rendering");
        self.keep_samples(Some(settled));
        let text = settled.text();
        if settled.meets() {
            messages.note(&text);
        } else {
            messages.warn(&text);
        }
        self.describe_opacity(messages);
        Ok(Some(rendered))
    }

    /// Renders the first frame of a decision, which settles the number of samples if that is to be found. Of the image
    /// the caller needs these outputs.
    ///
    /// # Errors
    /// Returns the errors of [`Self::render`].
    pub fn first(&mut self, outputs: Outputs, messages: &dyn Messages) -> Result<Rendered> {
        let (before, free) = (self.device.reset_peak(), self.device.memory_budget().map(MemoryBudget::free));
        let rendered = self.settle(messages)?.map_or_else(|| self.render_for(outputs), Ok)?;
        let taken = rendered.facts.peak_device_bytes.saturating_sub(before);
        let warning = free.and_then(|free| notes::beyond_memory(taken, free));
        warning.iter().for_each(|warning| self.told.to(messages).warn(warning));
        Ok(rendered)
    }

    /// Returns `true` as long as the number of samples is to be found.
    pub(super) fn is_unsettled(&self) -> bool {
        self.scene().image.samples == Samples::Auto && self.settled.is_none() && self.chosen_samples().is_none()
    }

    /// Renders further frames with the samples that were settled for another one, if any were.
    pub fn keep_samples(&mut self, settled: Option<SettledSamples>) {
        self.settled = settled;
        let given = || self.chosen_samples().unwrap_or_else(|| self.scene().image.samples.count());
        self.frame.samples = settled.map_or_else(given, |settled| settled.samples);
    }

    /// Returns the samples of a pixel that were chosen with the method, if any were.
    pub(super) fn chosen_samples(&self) -> Option<u32> {
        self.choice.as_ref()?.samples
    }

    /// Returns an image as its picture shows it, in linear light.
    fn shown(&mut self, image: &Image) -> Result<LinearImage> {
        let ImageSettings { background, .. } = self.scene().image;
        let color = self.frame.color;
        if !brightness::is_applied(&self.frame.method) {
            return Ok(methods::linear(image, background.color(), color)?);
        }
        let mut image = image.clone();
        brightness::apply(&mut self.renderer, &mut self.uploaded.cloud, &self.frame, &mut image)?;
        Ok(methods::linear(&image, background.color(), color)?)
    }

    /// Finds the opacity again for the frame's number of samples, unless it is that of a larger scene.
    fn refind_opacity(&mut self) -> Result<()> {
        if self.prepared.see_through().is_none() || self.opacity_of_whole.is_some() {
            return Ok(());
        }
        self.find_opacity()?;
        self.frame.factors.opacity *= self.prepared.request.frame.factors.opacity;
        Ok(())
    }

    /// Says how far the exact picture with the frame's samples is off from itself with many: the error of looking at
    /// points of each pixel in place of its area. Beside the error of a chosen method it is a note, otherwise a detail.
    ///
    /// # Errors
    /// Returns an error if the device fails.
    pub fn describe_sampling(&mut self, messages: &dyn Messages) -> Result<()> {
        let Self { renderer, uploaded, prepared, frame, choice, .. } = self;
        let background = prepared.scene().image.background.color();
        let measured =
            area::sampling(renderer, &mut uploaded.cloud, prepared.points(), (frame, background), SAMPLING_SECONDS);
        let text = match measured {
            Ok(Sampling::Known(area)) => area.text(),
            Ok(Sampling::TooSlow(seconds)) => {
                format!("pixel area: not measured, since that would take about {seconds:.0} s")
            }
            Ok(Sampling::Nothing) => return Ok(()),
            Err(error) if error.is_refusal() => format!("pixel area: not measured: {error}"),
            Err(error) => return Err(error.into()),
        };
        match choice {
            Some(_) => messages.note(&text),
            None => messages.detail(&text),
        }
        Ok(self.device.check_validation()?)
    }
}
