//! The times of a frame's passes, and the bytes that each must move at least.

use std::time::Duration;

use super::{Facts, Frame, PassProfile, edl, shadows};
use crate::gpu::PassTime;
use crate::image::Image;
use crate::passes::project::DeviceCloud;

/// All runs of a pass in a frame.
pub(crate) struct PassRuns<'a> {
    /// The pass.
    pub name: &'static str,
    /// The number of its runs.
    pub runs: u64,
    /// The counts of the frame.
    pub facts: &'a Facts,
    /// The frame.
    pub frame: &'a Frame,
    /// The points of the frame.
    pub cloud: &'a DeviceCloud,
    /// The image of the frame.
    pub image: &'a Image,
}

impl PassRuns<'_> {
    /// Returns lengths of all lists of fragments, if they were read back.
    pub fn lengths(&self) -> &[u32] {
        self.image.fragments.as_deref().unwrap_or_default()
    }

    /// Returns the number of pixels of the image; of all of its images, where it has samples.
    pub fn pixels(&self) -> u64 {
        let images = if self.frame.is_mean() { self.frame.samples.into() } else { 1 };
        u64::from(self.frame.size[0]) * u64::from(self.frame.size[1]) * images
    }

    /// Returns the number of bytes of a splat; `tilted` for a method whose splats lie in their tangent planes.
    pub fn splat(&self, tilted: bool) -> u64 {
        20 + if self.is_tilted(tilted) { 16 } else { 0 }
    }

    /// Returns `true` if splats have tilts.
    pub fn is_tilted(&self, tilted: bool) -> bool {
        tilted && self.cloud.has_normals()
    }

    /// Returns the bytes of a pass that visits all splats once per window: every band's store reads their rectangles
    /// again.
    pub fn walks(&self, tilted: bool) -> u64 {
        let facts = self.facts;
        facts.points * 8 * facts.windows.max(1) + facts.visible * self.splat(tilted)
    }

    /// Returns the number of bytes of the projection.
    pub fn projected(&self, tilted: bool) -> Option<u64> {
        let facts = self.facts;
        let normal = if self.cloud.has_normals() || self.cloud.casting().is_some() { 16 } else { 0 };
        let points = facts.points * (32 + 16 + normal + 8) * facts.windows.max(1);
        // How many of them touch the image is known of both together.
        (self.name == "project/splats" && facts.gaussians == 0)
            .then(|| points + facts.visible * (self.splat(tilted) + 16))
    }

    /// Bytes of passes that every engine has: empty pixels, the copy to the host, and shadows.
    fn common(&self) -> Option<u64> {
        match self.name {
            "image/clear" => Some(self.pixels() * 20),
            "image/encode" => Some(self.pixels() * (16 + 4)),
            "image/read-back" => Some(self.pixels() * self.image.pixel_bytes() * 2),
            name if name.starts_with("shading/") => edl::least_bytes(name, self.pixels()),
            // Runs have some of the points then, and how many is not known.
            name if name.starts_with("shadows/") && self.cloud.supply().is_some() => None,
            name if name.starts_with("shadows/") => {
                let resolution = shadows::casting(self.frame, self.cloud).map_or(0, |casting| casting.resolution);
                let chunks = self.cloud.chunks().count() as u64;
                shadows::least_bytes(name, self.runs, self.facts.points, chunks, resolution)
            }
            _ => None,
        }
    }
}

/// Sums the dispatches of each pass of a frame and its image, in order of first appearance, and adds the bytes that
/// each must move: those of the engine's own passes are `least_bytes`.
pub(super) fn aggregate(
    least_bytes: impl Fn(&PassRuns<'_>) -> Option<u64>,
    timeline: &[(PassTime, Duration)],
    facts: &Facts,
    (frame, image): (&Frame, &Image),
    cloud: &DeviceCloud,
) -> Vec<PassProfile> {
    let mut passes: Vec<PassProfile> = Vec::new();
    for (time, _) in timeline {
        if let Some(pass) = passes.iter_mut().find(|pass| pass.name == time.name) {
            pass.gpu += time.gpu;
            pass.invocations = pass.invocations.zip(time.invocations).map(|(a, b)| a + b);
            continue;
        }
        let runs = timeline.iter().filter(|(other, _)| other.name == time.name).count() as u64;
        let pass = PassRuns { name: time.name, runs, facts, frame, cloud, image };
        let bytes = pass.common().or_else(|| least_bytes(&pass));
        passes.push(PassProfile { name: time.name, gpu: time.gpu, invocations: time.invocations, bytes });
    }
    passes
}
