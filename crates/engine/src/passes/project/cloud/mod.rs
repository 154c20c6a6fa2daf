//! Points on the device, with room for their splats.

mod change;
mod column;
mod dealt;
mod gaussians;
mod lit;
mod placed;
mod supplied;
mod view;

pub use column::{COLUMN_BYTES, Column};
pub use gaussians::GaussianColumns;
pub use lit::LightImages;
pub use placed::Placed;
pub use supplied::{CutFor, Present};
pub use view::View;

use std::sync::Arc;

use glam::DVec3;
use rayon::prelude::*;

use self::dealt::List;
use self::supplied::Supplied;
use super::part::{Parts, fields_and_radii};
use super::{Bounds, Footprint, Projecting, Splat, Stats, Tilt};
use crate::cloud::Bounds as Box3;
use crate::cloud::light_image::Holes;
use crate::cloud::shadow_texture::Casting;
use crate::color::decode_srgb_f64;
use crate::gpu::{Buffer, Device, Error, GpuType, Memory, Preferences, Slice};
use crate::points::{Anchor, Points};
use crate::prepare::axes;
use crate::progress::Progress;
use crate::scene::{ColorSpace, Formula, Shading};
use crate::supply::Cut;

/// A cloud on the device, with room for its splats.
///
/// Chunks are ranges of points short enough to be bound; every per-point buffer is bound chunk by chunk.
pub struct DeviceCloud {
    anchor: Anchor,
    pub(super) origin: DVec3,
    /// Corners of the points' box.
    pub(super) corners: [DVec3; 8],
    /// Points on the device, and all of them.
    len: u64,
    total: u64,
    chunk_len: u64,
    pub(super) has_normals: bool,
    pub(super) has_fields: bool,
    /// Columns of Gaussians; `None` if no point of the cloud is one.
    pub(super) gaussians: Option<GaussianColumns>,
    pub(super) opacity_factor: f32,
    pub(super) prefers: Preferences,
    max_opacity: f32,
    max_color: f32,
    max_radius: f32,
    /// The depth that those of splats are relative to.
    pub(super) depth_origin: f32,
    /// Field and radius of each point, if there is a field; and what was last found in them.
    fields_and_radii: Vec<[f32; 2]>,
    parts: Option<(f32, Parts)>,
    /// `true` if the points that it was made from stand for more.
    is_sample: bool,
    /// World positions, if there is a field: what orders along the axes are made from, and those that were asked for.
    positions: Vec<DVec3>,
    orders: [Option<Buffer<u32>>; 3],
    orders_made: u32,
    /// The clouds of a dealt list.
    surfaces: Option<Vec<Placed>>,
    /// The shadows that the shares of light beside the normals belong to.
    casting: Option<Casting>,
    light_holes: Option<Holes>,
    /// View of lights, if points come some at a time.
    light_images: Option<Arc<LightImages>>,
    /// The points of a dealt list: whether they fit the device, the frame decides.
    host: Option<List>,
    /// Source of the points, if they come some at a time.
    supplied: Option<Supplied>,
    /// The points, of a cloud in memory that some methods can't take all at once.
    held: Option<Arc<Points>>,
    /// Positions relative to the cloud's origin, rounded, with radii.
    pub points_hi: Buffer<[f32; 4]>,
    /// The rest of the positions, with opacities.
    pub points_lo: Buffer<[f32; 4]>,
    /// Linear colors of the points; the bits of the fourth component are each point's place in the files.
    pub point_colors: Buffer<[f32; 4]>,
    /// Ids of the points, which seed the random words.
    pub ids: Buffer<u32>,
    /// Normals of the points, and the share of light that reaches each, 1 without shadows. A single element if there
    /// are neither.
    pub normals: Buffer<[f32; 4]>,
    /// Scalar field of the points; a single element if there is none.
    pub fields: Buffer<f32>,
    /// Projected splats.
    pub splats: Buffer<Splat>,
    /// Depths of the splats.
    pub splat_depths: Buffer<f32>,
    /// Tilts of the splats; a single element unless a footprint that was drawn has some.
    pub tilts: Buffer<Tilt>,
    /// Rectangles of the splats.
    pub bounds: Buffer<Bounds>,
    /// Colors of the splats, as blended, and opacities.
    pub colors: Buffer<[f32; 4]>,
    /// Per chunk, the chunk's large splats.
    pub large: Buffer<u32>,
    /// Tiles of each large splat.
    pub tile_counts: Buffer<u32>,
    /// Projection statistics of each chunk.
    pub(super) stats: Buffer<Stats>,
    pub(super) stats_host: Buffer<Stats>,
    pub(super) view: Buffer<View>,
    pub(super) view_host: View,
}

impl DeviceCloud {
    /// Uploads a scene's points. Room for splats is made when a method asks for it.
    pub fn new(device: &Device, points: &Points) -> Result<Self, Error> {
        let mut cloud = Self::without_columns(device, points)?;
        cloud.upload_columns(device, points)?;
        Ok(cloud)
    }

    /// Returns `true` if the device prefers to sort pairs of tile and splat.
    pub(crate) fn sorts_pairs(&self) -> bool {
        self.prefers.tile_pairs
    }

    /// Keeps the points that it was made from, to be made again from them in another way.
    pub(crate) fn hold(&mut self, points: Arc<Points>) {
        self.held = Some(points);
    }

    /// Returns the points that it was made from, if it keeps them.
    pub(crate) fn held(&self) -> Option<Arc<Points>> {
        self.held.clone()
    }

    /// Makes room for splats, unless there is.
    pub fn make_room(&mut self, device: &Device) -> Result<(), Error> {
        let len = self.len;
        if self.splats.len() < len {
            self.splat_depths = device.buffer("splat depths", len, Memory::Device)?;
            // Few footprints have some.
            self.tilts = device.buffer("tilts", 1, Memory::Device)?;
            self.bounds = device.buffer("splat bounds", len, Memory::Device)?;
            self.colors = device.buffer("splat colors", len, Memory::Device)?;
            self.large = device.buffer("large splats", len, Memory::Device)?;
            self.tile_counts = device.buffer("tile counts", len, Memory::Device)?;
            // Last, since its length says that there is room: the memory may not last for all of them.
            self.splats = device.buffer("splats", len, Memory::Device)?;
        }
        Ok(())
    }

    /// Uploads the columns, and the fields.
    fn upload_columns(&mut self, device: &Device, points: &Points) -> Result<(), Error> {
        let upload = |name, column: Column| -> Result<_, Error> {
            let buffer = device.buffer(name, (points.len() as u64).max(1), Memory::Device)?;
            column.upload(points, self.origin, &buffer)?;
            Ok(buffer)
        };
        let (points_hi, points_lo) = (upload("points, hi", Column::High)?, upload("points, lo", Column::Low)?);
        let point_colors = upload("point colors", Column::Color)?;
        let normals = if self.has_normals { upload("normals", Column::Normal)? } else { empty(device, "normals")? };
        self.fields = device.upload("fields", &points.fields)?;
        self.ids = device.buffer("point ids", (points.len() as u64).max(1), Memory::Device)?;
        upload_ids(points, &self.anchor, &self.ids)?;
        (self.points_hi, self.points_lo) = (points_hi, points_lo);
        (self.point_colors, self.normals) = (point_colors, normals);
        self.gaussians = points.gaussians.as_ref().map(|all| GaussianColumns::new(device, all)).transpose()?;
        self.casting = None;
        Ok(())
    }

    fn without_columns(device: &Device, points: &Points) -> Result<Self, Error> {
        let anchor = points.anchor();
        let origin = anchor.origin;
        let len = points.count();
        let has_normals = points.normals.as_ref().is_some_and(|normals| !normals.is_empty());
        // No element is wider than a splat, but for a Gaussian's color; a chunk starts at a multiple of any device's
        // offset alignment.
        let binding_bytes = device.limits().binding_bytes;
        let chunk_len = match points.splats() {
            Some(all) => ((binding_bytes / (4 * gaussians::words(all.degree).max(8))) & !0x3f).max(0x40),
            None => ((binding_bytes / size_of::<Splat>() as u64) & !0xffff).max(0x1_0000),
        };
        let chunks = len.div_ceil(chunk_len).max(1);
        Ok(Self {
            anchor,
            origin,
            corners: points.bounds().map_or([origin; 8], |b| b.corners()),
            len,
            total: len,
            chunk_len,
            has_normals,
            has_fields: !points.fields.is_empty(),
            gaussians: None,
            opacity_factor: 1.0,
            prefers: device.info().prefers,
            depth_origin: 0.0,
            max_opacity: largest_opacity(points),
            max_color: largest_component(points),
            max_radius: points.largest_radius() as f32,
            fields_and_radii: fields_and_radii(points),
            parts: None,
            is_sample: points.whole.is_some(),
            positions: if points.fields.is_empty() { Vec::new() } else { points.positions.clone() },
            orders: [None, None, None],
            orders_made: 0,
            surfaces: None,
            casting: None,
            light_holes: None,
            light_images: None,
            host: None,
            supplied: None,
            held: None,
            points_hi: empty(device, "points, hi")?,
            points_lo: empty(device, "points, lo")?,
            point_colors: empty(device, "point colors")?,
            ids: empty(device, "point ids")?,
            normals: empty(device, "normals")?,
            fields: empty(device, "fields")?,
            splats: empty(device, "splats")?,
            splat_depths: empty(device, "splat depths")?,
            tilts: empty(device, "tilts")?,
            bounds: empty(device, "splat bounds")?,
            colors: empty(device, "splat colors")?,
            large: empty(device, "large splats")?,
            tile_counts: empty(device, "tile counts")?,
            stats: device.buffer("splat stats", chunks, Memory::Device)?,
            stats_host: device.buffer("splat stats, host", chunks, Memory::Readback)?,
            view: device.buffer("view", 1, Memory::Device)?,
            view_host: bytemuck::Zeroable::zeroed(),
        })
    }

    /// Makes room for tilts, for a footprint that has some.
    pub fn reserve_tilts(&mut self, device: &Device, footprint: Footprint) -> Result<(), Error> {
        let wanted = self.len * footprint.tilt_stride();
        if self.tilts.len() < wanted {
            self.tilts = device.buffer("tilts", wanted, Memory::Device)?;
        }
        Ok(())
    }

    /// Returns the number of points; of a cloud whose points come some at a time, of those on the device.
    pub fn len(&self) -> u64 {
        self.len
    }

    /// Returns the number of all points.
    pub fn total(&self) -> u64 {
        self.total
    }

    /// Returns the number of points that are drawn; where those without levels are left out, about so many.
    pub fn drawn(&self) -> u64 {
        self.cut_in_force().map_or(self.total, Cut::points)
    }

    /// Returns the number of points that are drawn in the picture, where a limit had them counted, else of all.
    pub fn shown(&self) -> u64 {
        self.cut_in_force().map_or(self.total, Cut::shown)
    }

    /// Returns `true` if the points were dealt.
    pub fn is_dealt(&self) -> bool {
        self.host.is_some()
    }

    /// Returns `true` if there are no points on the device.
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// Returns the number of device bytes of the cloud and its splats.
    pub fn bytes(&self) -> u64 {
        self.points_hi.bytes()
            + self.points_lo.bytes()
            + self.point_colors.bytes()
            + self.normals.bytes()
            + self.ids.bytes()
            + self.fields.bytes()
            + self.splats.bytes()
            + self.splat_depths.bytes()
            + self.tilts.bytes()
            + self.gaussians.as_ref().map_or(0, GaussianColumns::bytes)
            + self.bounds.bytes()
            + self.colors.bytes()
            + self.large.bytes()
            + self.tile_counts.bytes()
            + self.orders.iter().flatten().map(Buffer::bytes).sum::<u64>()
    }

    /// Returns `true` if points have normals.
    pub fn has_normals(&self) -> bool {
        self.has_normals
    }

    /// Returns the largest opacity, with the factor of the last [`Self::set_view`].
    pub fn max_opacity(&self) -> f32 {
        (self.max_opacity * self.opacity_factor).min(1.0)
    }

    /// Returns the depth that those of splats are relative to since the last [`Self::set_view`]: 0, or the nearest of
    /// the points' box.
    pub fn depth_origin(&self) -> f32 {
        self.depth_origin
    }

    /// Returns the diagonal of the points' box in world units; 0 without points.
    pub fn diagonal(&self) -> f64 {
        self.bounds().diagonal()
    }

    /// Returns the points' box; a single place without points.
    pub fn bounds(&self) -> Box3 {
        Box3 { min: self.corners[0], max: self.corners[7] }
    }

    /// Returns the largest radius of all points, as uploaded.
    pub fn max_radius(&self) -> f32 {
        self.max_radius
    }

    /// Counts the points that a threshold makes solid and soft, where only some points are in memory.
    ///
    /// # Errors
    /// Points can't be read, or `progress` cancels it.
    pub fn find_parts(&mut self, threshold: f32, progress: &Progress) -> Result<(), crate::passes::Error> {
        let is_known = self.parts.is_some_and(|(known, _)| known == threshold);
        let supplied = self.supplied.as_ref().filter(|_| self.is_sample && self.has_fields && !is_known);
        let Some(supplied) = supplied else { return Ok(()) };
        let parts = Parts::of_supply(&*supplied.whole, threshold, progress)?;
        self.parts = Some((threshold, parts));
        Ok(())
    }

    /// Takes over how many points a threshold makes solid and soft, from another cloud of the same scene.
    pub fn know_parts(&mut self, threshold: f32, parts: Parts) {
        self.parts = Some((threshold, parts));
    }

    /// Returns the numbers of points that a threshold makes solid and soft ([`Self::find_parts`] where only some points
    /// are in memory).
    pub fn parts(&mut self, threshold: f32) -> Parts {
        match self.parts {
            Some((known, parts)) if known == threshold => parts,
            _ => {
                let parts = Parts::new(self.total, &self.fields_and_radii, threshold);
                self.parts = Some((threshold, parts));
                parts
            }
        }
    }

    /// Puts the points of a cloud with a field into order along an axis, the first time that it is asked for; it stays
    /// with the cloud, whatever threshold, densities and views come.
    pub fn sort_along(&mut self, device: &Device, axis: usize) -> Result<(), Error> {
        if self.orders[axis].is_none() && self.has_fields {
            let order = axes::order(&self.positions, axis);
            self.orders[axis] = Some(device.upload("points along an axis", &order)?);
            self.orders_made += 1;
        }
        Ok(())
    }

    /// Returns how often points were put into order along an axis.
    pub fn orders_made(&self) -> u32 {
        self.orders_made
    }

    /// Returns the indices of the points along an axis; `None` before [`Self::sort_along`], and without a field.
    pub fn along(&self, axis: usize) -> Option<Slice<'_, u32>> {
        self.orders[axis].as_ref().map(Buffer::all)
    }

    /// Returns the largest color component that blending may meet, once shaded and encoded.
    pub fn max_color(&self, how: &Projecting) -> f32 {
        let Shading { model, ambient, diffuse, specular, .. } = how.shading;
        let shaded = match model.formula() {
            Formula::None => self.max_color,
            Formula::Lambert => self.max_color * (ambient + diffuse).max(1.0),
            Formula::Phong => self.max_color * (ambient + diffuse).max(1.0) + specular,
        };
        let discs = if how.color == ColorSpace::Encoded { shaded.max(1.0) } else { shaded };
        let gaussians = self.gaussians.as_ref().map_or(0.0, |all| match how.color {
            ColorSpace::Encoded => all.brightest,
            ColorSpace::Linear => decode_srgb_f64(all.brightest.into()) as f32,
        });
        // Rounding up: shading, harmonics and encoding round by themselves.
        1.001 * discs.max(gaussians)
    }

    /// Returns the clouds of a dealt list; `None` if the points were not dealt.
    pub fn surfaces(&self) -> Option<&[Placed]> {
        self.surfaces.as_deref()
    }

    /// Returns the number of points that can be bound at a time.
    pub fn longest(&self) -> u64 {
        self.chunk_len
    }

    /// Returns the first point and number of points of each chunk.
    pub fn chunks(&self) -> impl Iterator<Item = (u64, u64)> + use<> {
        let (len, chunk_len) = (self.len, self.chunk_len);
        (0..len.div_ceil(chunk_len)).map(move |i| (i * chunk_len, chunk_len.min(len - i * chunk_len)))
    }

    /// Tilts of a chunk's splats, or the elements that stand for none.
    pub fn tilts_of(&self, footprint: Footprint, first: u64, count: u64) -> Slice<'_, Tilt> {
        match footprint.tilt_stride() {
            0 => self.tilts.slice(0, 1),
            stride => self.tilts.slice(first * stride, count * stride),
        }
    }

    /// Returns `true` if some points are Gaussians.
    pub fn has_gaussians(&self) -> bool {
        self.gaussians.is_some()
    }

    /// Returns the number of points that are Gaussians.
    pub fn gaussian_count(&self) -> u64 {
        self.gaussians.as_ref().map_or(0, |gaussians| gaussians.count)
    }
}

/// Brings the ids of all points to the front of a buffer.
fn upload_ids(points: &Points, anchor: &Anchor, ids: &Buffer<u32>) -> Result<(), Error> {
    ids.upload_by(points.len() as u64, |range, to| to.copy_from_slice(&points.ids(anchor, range)))
}

/// A buffer for nothing.
fn empty<T: GpuType>(device: &Device, name: &str) -> Result<Buffer<T>, Error> {
    device.buffer(name, 0, Memory::Device)
}

/// The largest value; 0 of none.
fn largest(values: &[f32]) -> f32 {
    values.par_iter().copied().reduce(|| 0.0, f32::max)
}

/// The largest opacity, or a bound on it.
fn largest_opacity(points: &Points) -> f32 {
    if points.whole.is_some() { 1.0 } else { largest(&points.opacities) }
}

/// The largest component of a color, at least 1, which scenes of which only a part is known have, too.
fn largest_component(points: &Points) -> f32 {
    let most = || points.colors.par_iter().map(|color| color.max_element()).reduce(|| 1.0, f32::max);
    points.whole.as_ref().map_or_else(most, |whole| whole.brightest.max(1.0))
}
