//! Clouds that were dealt to ensembles: their list stays in the host's memory, or in a file.

use std::ops::Range;
use std::sync::{Arc, Mutex, PoisonError};

use rayon::prelude::*;

use super::{COLUMN_BYTES, Column, DeviceCloud, Placed, empty};
use crate::gpu::{Buffer, Device, GpuType, Memory};
use crate::io;
use crate::passes::Error;
use crate::points::Points;
use crate::prepare::dealt_file::DealtFile;
use crate::prepare::ensembles::Dealt;
use crate::progress::Progress;
use pellucid_core::parallel;

/// The points of a dealt list.
#[derive(Debug, Clone)]
pub(super) enum List {
    /// Points in memory.
    Held(Arc<Points>),
    /// Points in a file, which is read part by part on demand.
    Filed(Arc<DealtFile>),
}

impl DeviceCloud {
    /// Takes points that were dealt. They come to the device when a frame asks for them: all by
    /// [`Self::make_resident`], or some after others by [`Self::pack`]. Room for splats is made when a method asks for
    /// it.
    ///
    /// # Errors
    /// No memory for small buffers.
    pub fn of_dealt(device: &Device, dealt: &Dealt) -> Result<Self, crate::gpu::Error> {
        let mut cloud = Self::without_columns(device, &dealt.points)?;
        cloud.surfaces = Some(Placed::all(&dealt.points, &dealt.surfaces));
        cloud.host = Some(List::Held(dealt.points.clone()));
        Ok(cloud)
    }

    /// Returns the same of points in a file; `sample` stands for them, with what is known of all.
    ///
    /// # Errors
    /// No memory for small buffers.
    pub fn of_dealt_file(device: &Device, sample: &Points, file: &Arc<DealtFile>) -> Result<Self, crate::gpu::Error> {
        let mut cloud = Self::without_columns(device, sample)?;
        let clouds = &file.clouds;
        (cloud.len, cloud.total) = (file.len(), file.len());
        cloud.has_normals = file.has_normals();
        cloud.max_opacity = clouds.iter().map(|cloud| cloud.surface.opacity).fold(0.0, f32::max);
        cloud.max_color = clouds.iter().map(|cloud| cloud.brightest).fold(1.0, f32::max);
        cloud.surfaces = Some(clouds.iter().map(Placed::of_facts).collect());
        cloud.host = Some(List::Filed(Arc::clone(file)));
        Ok(cloud)
    }

    /// Uploads all points of a cloud that was dealt, unless they are there.
    ///
    /// # Errors
    /// No memory for them, or they can't be read.
    pub fn make_resident(&mut self, device: &Device) -> Result<(), Error> {
        match self.host.clone() {
            Some(List::Held(points)) if self.points_hi.len() < self.len => Ok(self.upload_columns(device, &points)?),
            Some(List::Filed(file)) if self.points_hi.len() < self.len => self.upload_file(device, &file),
            _ => Ok(()),
        }
    }

    /// Brings the first points of each cloud of a list into the file, as many as `counts` says, if that is where the
    /// list is.
    ///
    /// # Errors
    /// Returns an error if the points can't be read or written, or if `progress` is canceled.
    pub fn reach(&self, counts: impl IntoIterator<Item = u64>, progress: &Progress) -> Result<(), Error> {
        match &self.host {
            Some(List::Filed(file)) => file.reach(counts, progress).map_err(unread),
            _ => Ok(()),
        }
    }

    fn upload_file(&mut self, device: &Device, file: &DealtFile) -> Result<(), Error> {
        file.reach(std::iter::repeat(file.len()), &Progress::hidden()).map_err(unread)?;
        let (origin, len) = (self.origin, self.len.max(1));
        let column = |name, column: Column| {
            uploaded(device, (name, len), file, |points, to: &mut [[f32; 4]]| {
                parallel::for_each_mut(to, |i, to| *to = column.value(points, origin, i));
            })
        };
        let (points_hi, points_lo) = (column("points, hi", Column::High)?, column("points, lo", Column::Low)?);
        let point_colors = column("point colors", Column::Color)?;
        let normals = if self.has_normals { column("normals", Column::Normal)? } else { empty(device, "normals")? };
        self.ids = uploaded(device, ("point ids", len), file, |points, to| to.copy_from_slice(&points.dealt_ids))?;
        (self.points_hi, self.points_lo) = (points_hi, points_lo);
        (self.point_colors, self.normals) = (point_colors, normals);
        self.casting = None;
        Ok(())
    }

    /// Frees the buffers of a cloud that was dealt; its list stays where it is.
    ///
    /// # Errors
    /// No memory for the small buffers in their places.
    pub fn release(&mut self, device: &Device) -> Result<(), crate::gpu::Error> {
        if self.host.is_some() && !self.points_hi.is_empty() {
            let (points_hi, points_lo) = (empty(device, "points, hi")?, empty(device, "points, lo")?);
            (self.points_hi, self.points_lo) = (points_hi, points_lo);
            (self.point_colors, self.normals) = (empty(device, "point colors")?, empty(device, "normals")?);
            self.ids = empty(device, "point ids")?;
            (self.fields, self.orders) = (empty(device, "fields")?, [None, None, None]);
            self.casting = None;
            (self.splats, self.tilts) = (empty(device, "splats")?, empty(device, "tilts")?);
            self.splat_depths = empty(device, "splat depths")?;
            (self.bounds, self.colors) = (empty(device, "splat bounds")?, empty(device, "splat colors")?);
            (self.large, self.tile_counts) = (empty(device, "large splats")?, empty(device, "tile counts")?);
        }
        Ok(())
    }

    /// Returns the columns that the device holds.
    pub fn columns(&self) -> &'static [Column] {
        if self.has_normals { &Column::ALL } else { &Column::ALL[..3] }
    }

    /// Returns the number of device bytes of all columns.
    pub fn column_bytes(&self) -> u64 {
        self.len * self.columns().len() as u64 * COLUMN_BYTES
    }

    /// Puts the columns of some points of a cloud that was dealt, column after column, and their ids behind what is
    /// there.
    ///
    /// # Errors
    /// Returns an error if the points can't be read.
    pub fn pack(&self, range: Range<u64>, columns: &mut Vec<[f32; 4]>, ids: &mut Vec<u32>) -> Result<(), Error> {
        match &self.host {
            Some(List::Held(points)) => {
                self.pack_held(points, range.start as usize..range.end as usize, columns, ids);
            }
            Some(List::Filed(file)) => {
                let points = file.read(range).map_err(unread)?;
                self.pack_held(&points, 0..points.len(), columns, ids);
            }
            None => {}
        }
        Ok(())
    }

    fn pack_held(&self, points: &Points, range: Range<usize>, columns: &mut Vec<[f32; 4]>, ids: &mut Vec<u32>) {
        for column in self.columns() {
            columns.par_extend(range.clone().into_par_iter().map(|i| column.value(points, self.origin, i)));
        }
        ids.extend(points.ids(&self.anchor, range));
    }
}

/// A buffer of what `fill` makes of the points of a file, some after others.
fn uploaded<T: GpuType>(
    device: &Device,
    (name, len): (&str, u64),
    file: &DealtFile,
    fill: impl Fn(&Points, &mut [T]),
) -> Result<Buffer<T>, Error> {
    let (buffer, failed) = (device.buffer(name, len, Memory::Device)?, Mutex::new(None));
    buffer.upload_by(file.len(), |range, to| match file.read(range.start as u64..range.end as u64) {
        Ok(points) => fill(&points, to),
        Err(error) => *failed.lock().unwrap_or_else(PoisonError::into_inner) = Some(error),
    })?;
    match failed.into_inner().unwrap_or_else(PoisonError::into_inner) {
        Some(error) => Err(unread(error)),
        None => Ok(buffer),
    }
}

fn unread(error: io::Error) -> Error {
    match error {
        io::Error::Cancelled { .. } => Error::Cancelled,
        error => Error::Store(Arc::new(error)),
    }
}
