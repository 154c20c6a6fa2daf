//! Clouds whose points come to the device some at a time, block by block: those that show in the window in work.

use std::sync::Arc;

use glam::DVec3;
use rayon::iter::ParallelIterator;

use super::super::{Beam, Bounds, Footprint, PointExtent, Splat, Tilt};
use super::{COLUMN_BYTES, Column, DeviceCloud, GaussianColumns, empty, upload_ids};
use crate::camera::Camera;
use crate::gpu::{Device, Error, Memory};
use crate::points::Points;
use crate::progress::Progress;
use crate::supply::{self, Cut, CutPicture, Keep, Limits, Scale, Supply, each};

/// Source of the points of a cloud, and those of them that are on the device.
pub(super) struct Supplied {
    pub(super) whole: Arc<dyn Supply>,
    /// Part that is drawn, if that is not all.
    cut: Option<(CutFor, Arc<Cut>)>,
    /// The distance between points of clouds without levels, in world units.
    spacing: f64,
    /// The largest radius of all points.
    max_radius: f32,
    /// Points that are on the device.
    present: Option<Present>,
}

/// Purpose of a cut.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CutFor {
    /// Limits of the cut.
    pub limits: Limits,
    /// The picture's camera.
    pub camera: Camera,
    /// Size of the picture in pixels.
    pub size: [u32; 2],
    /// The seed of the order of points without levels.
    pub seed: u64,
}

/// Points of a cloud that are on the device.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Present {
    /// Beam in which anything of a point may show; `None` for all points.
    pub within: Option<Beam>,
}

impl Supplied {
    fn drawn(&self) -> Arc<dyn Supply> {
        match &self.cut {
            Some((_, cut)) => Arc::clone(cut) as Arc<dyn Supply>,
            None => Arc::clone(&self.whole),
        }
    }
}

impl Present {
    /// All points.
    pub const ALL: Self = Self { within: None };

    /// Returns `true` if a Gaussian of this reach, or a disc in a block of this radius, is among them.
    pub fn keeps(&self, position: DVec3, radius: f32) -> bool {
        self.within.is_none_or(|beam| beam.meets_point(position, radius))
    }
}

impl DeviceCloud {
    /// Takes points in canonical order that come to the device when a window asks for them ([`Self::bring`]).
    pub fn of_supply(device: &Device, points: &Points, supply: Arc<dyn Supply>) -> Result<Self, Error> {
        let mut cloud = Self::without_columns(device, points)?;
        cloud.len = 0;
        cloud.gaussians = points.splats().map(|splats| GaussianColumns::empty(device, splats)).transpose()?;
        let sampled: Vec<DVec3> = points.sampled().copied().collect();
        let spacing = supply::spacing(&sampled, points.count());
        let max_radius = cloud.max_radius;
        cloud.supplied = Some(Supplied { whole: supply, cut: None, spacing, max_radius, present: None });
        Ok(cloud)
    }

    /// Has its points come from another supply of the same scene; those that were there are forgotten.
    pub fn supply_by(&mut self, supply: Arc<dyn Supply>) {
        if let Some(supplied) = &mut self.supplied {
            (supplied.whole, supplied.cut, supplied.present) = (supply, None, None);
        }
    }

    /// Returns the source of the points that are drawn, of clouds whose points come some at a time.
    pub fn supply(&self) -> Option<Arc<dyn Supply>> {
        self.supplied.as_ref().map(Supplied::drawn)
    }

    /// Returns the points that are drawn, if they are not all ([`Self::cut`]).
    pub fn cut_in_force(&self) -> Option<&Cut> {
        self.supplied.as_ref()?.cut.as_ref().map(|(_, cut)| &**cut)
    }

    /// Has some of the points drawn of a cloud whose points come some at a time; `None` for all.
    ///
    /// # Errors
    /// Points can't be read, the coarsest level has more than are allowed, or `progress` cancels it: then all are
    /// drawn.
    pub fn cut(&mut self, wanted: Option<&CutFor>, progress: &Progress) -> Result<(), crate::passes::Error> {
        let Some(supplied) = &mut self.supplied else { return Ok(()) };
        if supplied.cut.as_ref().map(|(known, _)| known) == wanted {
            return Ok(());
        }
        (supplied.present, supplied.cut, self.max_radius) = (None, None, supplied.max_radius);
        // Lights saw the points that were drawn before.
        self.light_images = None;
        let Some(wanted) = wanted else { return Ok(()) };
        let CutFor { limits, camera, size, seed } = *wanted;
        let beam = Beam::new(&camera, size, [0, 0, size[0], size[1]], PointExtent::pixels(0.0));
        let behind = camera.near - camera.near.abs().max(camera.far - camera.near);
        let picture = CutPicture {
            scale: Scale::new(&camera, size[1]),
            blocks: &beam.pick(supplied.whole.blocks()),
            shows: &|position| beam.meets_point(position, 0.0),
            nowhere: camera.eye + behind * camera.forward,
            seed,
        };
        let cut = Cut::new(Arc::clone(&supplied.whole), supplied.spacing, &limits, &picture, progress)?;
        self.max_radius = supply::grown(self.max_radius, cut.most_growth);
        supplied.cut = Some((*wanted, Arc::new(cut)));
        Ok(())
    }

    /// Returns the number of device bytes of a point with its splat, by the widest footprint if some points are
    /// Gaussians.
    pub fn point_bytes(&self, footprint: Footprint) -> u64 {
        let columns = self.columns().len() as u64 * COLUMN_BYTES + 4 + if self.has_fields { 8 } else { 0 };
        let footprint = if self.has_gaussians() { Footprint::Gaussian } else { footprint };
        let tilts = footprint.tilt_stride() * size_of::<Tilt>() as u64;
        let columns = columns + self.gaussians.as_ref().map_or(0, GaussianColumns::bytes_each);
        // Depth, color, place among the large ones and number of their tiles.
        columns + tilts + (size_of::<Splat>() + size_of::<Bounds>()) as u64 + 4 + 16 + 4 + 4
    }

    /// Returns `true` if these points are on the device, and, unless `others` may be there too, no others.
    pub fn has(&self, wanted: &Present, others: bool) -> bool {
        let present = self.supplied.as_ref().and_then(|supplied| supplied.present);
        present.is_some_and(|present| others && present == Present::ALL || present == *wanted)
    }

    /// Brings points of these blocks to the device in place of those that are there: at most `room` of them, or false.
    /// Room for them is kept.
    ///
    /// # Errors
    /// The points can't be taken, or there is no memory for them: then none are there.
    pub fn bring(
        &mut self,
        device: &Device,
        (blocks, wanted, room): (&[u32], Present, u64),
        progress: &Progress,
    ) -> Result<bool, crate::passes::Error> {
        let Some(supplied) = &mut self.supplied else { return Ok(true) };
        let supply = supplied.drawn();
        let all = supply.blocks();
        let keeps = |position, block: u32, reach: Option<f32>| {
            wanted.keeps(position, reach.unwrap_or(all[block as usize].radius))
        };
        let mut points = supply.take(blocks, Keep::those(&keeps), progress)?;
        if points.len() as u64 > room {
            return Ok(false);
        }
        if points.is_empty() {
            // Passes want one. It shows nowhere.
            points = supplied.whole.take(&[0], Keep::ALL, progress)?.subset(&[0], 1.0);
            if let Some((_, cut)) = &supplied.cut {
                points.positions.fill(cut.nowhere);
            }
        }
        self.put(device, &points)?;
        if let Some(supplied) = &mut self.supplied {
            supplied.present = Some(wanted);
        }
        Ok(true)
    }

    /// Brings all points to the device, at most `room` at a time in place of those that are there, and has them seen
    /// each time.
    ///
    /// # Errors
    /// The points can't be taken, or there is no memory for them; those of `see`.
    pub fn show_all(
        &mut self,
        device: &Device,
        room: u64,
        progress: &Progress,
        mut see: impl FnMut(&mut Self) -> Result<(), crate::passes::Error>,
    ) -> Result<(), crate::passes::Error> {
        let Some(supply) = self.supply() else { return Ok(()) };
        let mut seen = Ok(());
        let show = |points: &Points| {
            let places: Vec<u32> = (0..points.len() as u32).collect();
            for some in places.chunks(usize::try_from(room).unwrap_or(usize::MAX).max(1)) {
                if seen.is_ok() {
                    let put = self.put(device, &points.subset(some, 1.0));
                    seen = put.map_err(Into::into).and_then(|()| see(self));
                }
            }
        };
        each(&*supply, room, progress, show)?;
        seen
    }

    /// Puts points on the device in place of those that are there.
    fn put(&mut self, device: &Device, points: &Points) -> Result<(), Error> {
        if let Some(supplied) = &mut self.supplied {
            supplied.present = None;
        }
        self.len = points.len() as u64;
        self.make_columns(device)?;
        self.put_columns(device, points)
    }

    /// Makes room for the columns of points, unless there is.
    fn make_columns(&mut self, device: &Device) -> Result<(), Error> {
        let len = self.len;
        let chunks = self.chunks().count() as u64;
        if self.stats.len() < chunks {
            self.stats = device.buffer("splat stats", chunks, Memory::Device)?;
            self.stats_host = device.buffer("splat stats, host", chunks, Memory::Readback)?;
        }
        if self.points_hi.len() < len {
            // Old buffers are freed first: old and new ones may not fit together.
            self.points_hi = empty(device, "points, hi")?;
            self.points_lo = empty(device, "points, lo")?;
            self.point_colors = empty(device, "point colors")?;
            self.points_hi = device.buffer("points, hi", len, Memory::Device)?;
            self.points_lo = device.buffer("points, lo", len, Memory::Device)?;
            self.point_colors = device.buffer("point colors", len, Memory::Device)?;
            self.ids = empty(device, "point ids")?;
            self.ids = device.buffer("point ids", len, Memory::Device)?;
        }
        if self.has_normals && self.normals.len() < len {
            self.normals = empty(device, "normals")?;
            self.normals = device.buffer("normals", len, Memory::Device)?;
        }
        if self.has_fields && self.fields.len() < len {
            self.fields = empty(device, "fields")?;
            self.fields = device.buffer("fields", len, Memory::Device)?;
        }
        Ok(())
    }

    /// Fills the columns with points.
    fn put_columns(&mut self, device: &Device, points: &Points) -> Result<(), Error> {
        Column::High.upload(points, self.origin, &self.points_hi)?;
        Column::Low.upload(points, self.origin, &self.points_lo)?;
        Column::Color.upload(points, self.origin, &self.point_colors)?;
        upload_ids(points, &self.anchor, &self.ids)?;
        if self.has_normals {
            Column::Normal.upload(points, self.origin, &self.normals)?;
        }
        if let Some(gaussians) = &mut self.gaussians {
            gaussians.put(device, points)?;
        }
        if self.has_fields {
            self.fields.upload(&points.fields)?;
            self.positions.clone_from(&points.positions);
        }
        self.orders = [None, None, None];
        self.casting = None;
        Ok(())
    }
}
