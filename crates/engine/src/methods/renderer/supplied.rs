//! Clouds whose points come to the device window by window.

use std::sync::Arc;

use super::walk::Job;
use super::{Error, Renderer};
use crate::cloud::shadow_texture::Casting;
use crate::methods::prelude::*;
use crate::methods::shadows;
use crate::passes::project::{Beam, CutFor, Present};
use crate::passes::tiles::TILE;
use crate::supply::{HeldPoints, Limits};

/// The part of a memory budget that is for points; the rest is the engine's.
const PART: u64 = 2;
/// Factor on the number of points that fit, which are read where nobody knows how many to expect, in the hope that so
/// many of them lie outside of the window: blocks are larger than the parts of them that a window shows.
const READ: u64 = 3;
/// Bytes of an element of the sort of splats, for each point.
const SORT_BYTES: u64 = 16;

/// Bytes of a frame on the device, points included.
fn all_bytes(device: &Device, frame: &Frame) -> u64 {
    frame.memory_budget.unwrap_or(device.limits().heap_bytes / 4 * 3)
}

/// Returns the bytes that a budget leaves the engine.
pub(super) fn rest(device: &Device, frame: &Frame) -> u64 {
    let bytes = all_bytes(device, frame);
    bytes - bytes / PART
}

/// Points that are on the device at a time, at most: never more than `most`.
fn room(device: &Device, cloud: &DeviceCloud, frame: &Frame, most: u64) -> u64 {
    let bytes = cloud.point_bytes(Footprint::Oriented) + SORT_BYTES;
    (all_bytes(device, frame) / PART / bytes).min(most).max(1)
}

/// Returns the part of space that a window of all images of a frame shows.
fn beam(engine: &dyn Engine, cloud: &DeviceCloud, frame: &Frame, window: Window) -> Beam {
    let mut extent = engine.extent(frame, cloud);
    if frame.samples > 1 {
        // Each of them is moved by less than half a pixel.
        extent.pixels += 0.5;
    }
    Beam::new(&frame.camera, frame.size, window, extent)
}

impl Renderer {
    /// Returns the part of space that a window of a frame shows: points outside of it need not be there.
    pub fn beam(&self, cloud: &DeviceCloud, frame: &Frame, window: Window) -> Beam {
        beam(engine_of(&frame.method).as_ref(), cloud, frame, window)
    }

    /// Returns the number of points of a cloud that comes window by window that are on the device at a time, at most.
    pub fn room(&self, cloud: &DeviceCloud, frame: &Frame) -> u64 {
        room(&self.device, cloud, frame, engine_of(&frame.method).most_points(&self.device))
    }

    /// Lets points of a cloud in memory that a method can't take all at once come window by window; and brings all of
    /// them back for another method that can.
    pub(super) fn divide(&self, engine: &dyn Engine, cloud: &mut DeviceCloud, frame: &Frame) -> Result<(), Error> {
        let Some(points) = cloud.held() else { return Ok(()) };
        let too_many = points.len() as u64 > engine.most_points(&self.device);
        let is_divided = cloud.supply().is_some();
        if too_many == is_divided || !frame.detail.is_whole() {
            return Ok(());
        }
        // In both cases what is on the device is freed first.
        let supply = Arc::new(HeldPoints::new(Arc::clone(&points)));
        *cloud = DeviceCloud::of_supply(&self.device, &points, supply)?;
        if is_divided {
            *cloud = DeviceCloud::new(&self.device, &points)?;
        }
        cloud.hold(points);
        Ok(())
    }

    /// Has the points drawn that a frame's detail asks for, of clouds whose points come some at a time.
    pub(super) fn cut(&self, cloud: &mut DeviceCloud, frame: &Frame) -> Result<(), Error> {
        let Frame { detail, camera, size, seed, .. } = *frame;
        let limits = Limits { spacing_px: detail.spacing_px.into(), max_points: detail.max_points.map(u64::from) };
        let wanted = (!detail.is_whole()).then_some(CutFor { limits, camera, size, seed });
        if wanted.is_some() && cloud.supply().is_none() && !cloud.is_dealt() {
            return Err(Error::NoLevels);
        }
        cloud.cut(wanted.as_ref(), &self.progress)
    }

    /// Brings the points that may show in a window to the device, unless they are there. A window that too many reach
    /// must be cut.
    pub(super) fn bring(
        &self,
        cloud: &mut DeviceCloud,
        job: &Job<'_>,
        window: Window,
        timeline: &mut Timeline,
    ) -> Result<Outcome, Error> {
        let Some(supply) = cloud.supply() else { return Ok(Outcome::Done) };
        let most = job.engine.most_points(&self.device);
        let (frame, blocks, room) = (job.frame, supply.blocks(), room(&self.device, cloud, job.frame, most));
        let count = |picked: &[u32]| picked.iter().map(|i| blocks[*i as usize].points).sum::<u64>();
        let beam = beam(job.engine, cloud, frame, window);
        let wanted = Present { within: Some(beam) };
        // A region is for others to render the rest: its points alone are projected.
        let is_whole = self.region.is_none();
        if cloud.has(&wanted, is_whole) {
            self.share_light(cloud, frame, timeline)?;
            return Ok(Outcome::Done);
        }
        if is_whole && cloud.drawn() <= room {
            // They stay for the windows and frames to come. A count of points without levels may be a little too low.
            let all: Vec<u32> = (0..blocks.len() as u32).collect();
            if cloud.bring(&self.device, (&all, Present::ALL, room), &self.progress)? {
                return self.ready(cloud, job, timeline);
            }
        }
        let picked = beam.pick(blocks);
        let [x, y, x1, y1] = window;
        let (alone, is_tile) = (x1 - x == 1 && y1 - y == 1, x1 - x <= TILE && y1 - y <= TILE);
        // Runs over a tile's splats are composed by themselves, so a window within a tile may have other bytes: as long
        // as the device can hold them, a tile's points come together.
        let room = if is_tile { most } else { room.min(supply.most()) };
        let points = count(&picked);
        // Nodes are not read in vain where so many points are expected that they won't fit; some more than that are.
        // However many points the nodes have besides, halves of the window would read most of them twice.
        let few = alone
            || points <= room
            || match supply.estimate(&|position| beam.meets_point(position, 0.0)) {
                Some(expected) => expected <= room - room / 10,
                None => points <= READ * room,
            };
        if few && cloud.bring(&self.device, (&picked, wanted, room), &self.progress)? {
            return self.ready(cloud, job, timeline);
        }
        if alone { Err(Error::PointsOfPixel { x, y, points, limit: room }) } else { Ok(Outcome::Overflow) }
    }

    /// Finds what a window needs of the points that were brought.
    fn ready(&self, cloud: &mut DeviceCloud, job: &Job<'_>, timeline: &mut Timeline) -> Result<Outcome, Error> {
        if job.engine.projects() {
            cloud.make_room(&self.device)?;
        }
        self.share_light(cloud, job.frame, timeline)?;
        job.engine.prepare(&self.device, cloud, job.frame)?;
        Ok(Outcome::Done)
    }

    /// Makes the images of the lights of a frame from all points.
    pub(super) fn see_by_lights(
        &self,
        cloud: &mut DeviceCloud,
        frame: &Frame,
        casting: &Casting,
        timeline: &mut Timeline,
    ) -> Result<(), Error> {
        let how = frame.projecting_points(cloud);
        let limits = (rest(&self.device, frame) / PART, room(&self.device, cloud, frame, Cut::most(&self.device)));
        shadows::see(&self.device, cloud, (casting, &how), limits, &self.progress, timeline)
    }

    /// Gives the points on the device their shares of light, if the images are those of the frame.
    fn share_light(&self, cloud: &mut DeviceCloud, frame: &Frame, timeline: &mut Timeline) -> Result<(), Error> {
        if shadows::casting(frame, cloud).is_some_and(|casting| cloud.has_cast(&casting)) {
            let how = frame.projecting_points(cloud);
            shadows::share(&self.device, cloud, &how, timeline)?;
        }
        Ok(())
    }
}
