//! Points on the device, and their projection to splats.

mod change;
mod placed;

pub use placed::Placed;

use std::ops::Range;
use std::sync::Arc;

use glam::{DVec3, Vec3};
use rayon::prelude::*;

use crate::camera::{Camera, Projection};
use crate::cloud::Bounds as Box3;
use crate::cloud::shadow_texture::Casting;
use crate::gpu::shader::{Choices, Shader};
use crate::gpu::{Buffer, Device, Dispatch, Error, GpuType, Memory, Recorder, Run, Slice, Variant};
use crate::passes::compose::Cut;
use crate::points::Points;
use crate::prepare::axes;
use crate::prepare::ensembles::Dealt;
use crate::scene::{ColorSpace, Light, Shading, ShadingModel};
use crate::{choices, gpu_struct, group, pass};

gpu_struct! {
    /// The camera and the part of the image in work; shaders/shared/view.wgsl says what the members are.
    pub struct View {
        right: [f32; 4],
        right_lo: [f32; 4],
        down: [f32; 4],
        down_lo: [f32; 4],
        forward: [f32; 4],
        forward_lo: [f32; 4],
        eye_hi: [f32; 4],
        eye_lo: [f32; 4],
        light: [f32; 4],
        material: [f32; 4],
        window: [u32; 4],
        size: [u32; 2],
        focal: [f32; 2],
        depth_range: [f32; 2],
        radius_limits: [f32; 2],
        orthographic: u32,
        opacity_factor: f32,
        threshold: f32,
        modulation: f32,
    }
}

gpu_struct! {
    /// A projected splat.
    pub struct Splat {
        fraction_x: f32,
        fraction_y: f32,
        pixel: u32,
        depth: f32,
        radius: f32,
    }
}

gpu_struct! {
    /// Normal of an oriented splat in camera axes.
    pub struct Tilt {
        normal: [f32; 4],
    }
}

/// Rectangle of pixels that a splat may cover; shaders/shared/splat.wgsl says how.
pub type Bounds = [u32; 2];

gpu_struct! {
    /// What the projection of one chunk found.
    pub struct Stats {
        visible: u32,
        large: u32,
        tiles_low: u32,
        tiles_high: u32,
        widest: u32,
        tallest: u32,
        area_low: u32,
        area_high: u32,
    }
}

impl Stats {
    /// Pixels of all rectangles of all chunks.
    pub fn area(stats: &[Self]) -> u64 {
        stats.iter().map(|s| u64::from(s.area_high) << 32 | u64::from(s.area_low)).sum()
    }

    /// Columns and rows of pixels of the widest and the tallest splat of all chunks.
    pub fn extent(stats: &[Self]) -> [u32; 2] {
        stats.iter().fold([0, 0], |[x, y], s| [x.max(s.widest), y.max(s.tallest)])
    }

    /// Tiles of the large splats.
    pub fn tiles(&self) -> u64 {
        u64::from(self.tiles_high) << 32 | u64::from(self.tiles_low)
    }
}

gpu_struct! {
    /// Push constants: points of the chunk, and its number.
    pub struct ProjectPush {
        count: u32,
        chunk: u32,
    }
}

pass! {
    /// Projects each point to a splat: camera-relative position in two-float arithmetic, culling by near, far and
    /// window, shading, rectangle of pixels. It lists large splats for their tiles.
    pub Project(ProjectPush) = "splat/project" {
        camera: Uniform<View>,
        points_hi: Read<[f32; 4]>,
        points_lo: Read<[f32; 4]>,
        point_colors: Read<[f32; 4]>,
        normals: Read<[f32; 4]>,
        fields: Read<f32>,
        splats: ReadWrite<Splat>,
        tilts: ReadWrite<Tilt>,
        bounds: ReadWrite<Bounds>,
        colors: ReadWrite<[f32; 4]>,
        large: ReadWrite<u32>,
        tile_counts: ReadWrite<u32>,
        stats: ReadWrite<Stats>,
    }
}

/// Which pixels a splat covers; the values of `SHAPE` in WGSL.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Footprint {
    /// Screen-aligned disc.
    Disc = 0,
    /// Disc in the tangent plane.
    Oriented = 1,
    /// Screen-aligned square.
    Square = 2,
    /// One pixel.
    Point = 3,
    /// Sphere; its radius stays in world units.
    Sphere = 4,
    /// The same, its place to twice as many digits.
    ExactSphere = 5,
}

choices!(
    enum Footprint {
        Disc,
        Oriented,
        Square,
        Point,
        Sphere,
        ExactSphere,
    }
);

/// The footprints that are composed.
pub const DISCS: [Footprint; 2] = [Footprint::Disc, Footprint::Oriented];

/// The footprints of splats that go through tiles.
pub const TILED: [Footprint; 3] = [Footprint::Disc, Footprint::Oriented, Footprint::Square];

impl Footprint {
    /// Whether splats of this shape have tilts.
    pub fn has_tilts(self) -> bool {
        matches!(self, Self::Oriented | Self::ExactSphere)
    }
}

/// Which points of a cloud are projected.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Part {
    /// All.
    All,
    /// Those whose field is at most the threshold.
    Solid(f32),
    /// Those whose field is above it. Their splats' fourth component is W of Seemann et al., Eq. 22, not an opacity.
    Soft {
        /// t
        threshold: f32,
        /// l_m
        modulation: Option<f32>,
    },
    /// All; the fourth component of their splats is 1 for those whose field is at most the threshold, else 0.
    Marked(f32),
}

impl Part {
    /// The value of `PART` in WGSL.
    fn value(self) -> u32 {
        match self {
            Self::All => PART_ALL,
            Self::Solid(_) => PART_SOLID,
            Self::Soft { .. } => PART_SOFT,
            Self::Marked(_) => PART_MARKED,
        }
    }

    fn modulation(self) -> f32 {
        match self {
            Self::Soft { modulation: Some(most), .. } => most,
            _ => 0.0,
        }
    }

    fn threshold(self) -> f32 {
        match self {
            Self::All => 0.0,
            Self::Solid(threshold) | Self::Marked(threshold) | Self::Soft { threshold, .. } => threshold,
        }
    }
}

const PART_ALL: u32 = 0;
const PART_SOLID: u32 = 1;
const PART_SOFT: u32 = 2;
const PART_MARKED: u32 = 3;

/// What shaders know of this module.
pub(crate) const CONSTANTS: [(&str, u32); 10] = [
    ("SHAPE_ORIENTED", Footprint::Oriented as u32),
    ("SHAPE_SQUARE", Footprint::Square as u32),
    ("SHAPE_POINT", Footprint::Point as u32),
    ("SHAPE_SPHERE", Footprint::Sphere as u32),
    ("SHAPE_EXACT_SPHERE", Footprint::ExactSphere as u32),
    ("PART_SOLID", PART_SOLID),
    ("PART_SOFT", PART_SOFT),
    ("PART_MARKED", PART_MARKED),
    ("SHADING_NONE", ShadingModel::None as u32),
    ("SHADING_PHONG", ShadingModel::Phong as u32),
];

/// What a threshold makes of a cloud.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Parts {
    /// Points with a field of at most the threshold; all if there is no field.
    pub solid: u64,
    /// Points with a field above it.
    pub soft: u64,
    /// Median radius of these in world units, 0 if there are none.
    pub median_radius: f32,
}

impl Parts {
    /// Of a scene's points.
    pub fn of(points: &Points, threshold: f32) -> Self {
        Self::new(points.len() as u64, &fields_and_radii(points), threshold)
    }

    /// Of `len` points, of which fields and radii are known if there is a field.
    fn new(len: u64, fields_and_radii: &[[f32; 2]], threshold: f32) -> Self {
        let mut radii: Vec<f32> = fields_and_radii.iter().filter(|[f, _]| *f > threshold).map(|[_, r]| *r).collect();
        let soft = radii.len() as u64;
        Self { solid: len - soft, soft, median_radius: median(&mut radii) }
    }
}

/// Field and radius of each point; nothing without a field.
fn fields_and_radii(points: &Points) -> Vec<[f32; 2]> {
    points.fields.iter().zip(&points.radii).map(|(field, radius)| [*field, *radius]).collect()
}

/// The largest value; 0 of none.
fn most(values: &[f32]) -> f32 {
    values.par_iter().copied().reduce(|| 0.0, f32::max)
}

fn most_of_colors(colors: &[Vec3]) -> f32 {
    colors.par_iter().map(|c| c.max_element()).reduce(|| 0.0, f32::max)
}

/// The median, the mean of the middle two of an even number; 0 of none.
fn median(values: &mut [f32]) -> f32 {
    let middle = values.len() / 2;
    if values.is_empty() {
        return 0.0;
    }
    let (_, upper, _) = values.select_nth_unstable_by(middle, f32::total_cmp);
    let upper = *upper;
    if values.len().is_multiple_of(2) {
        let lower = values[..middle].iter().copied().fold(f32::MIN, f32::max);
        0.5 * lower + 0.5 * upper
    } else {
        upper
    }
}

/// How splats are made from points.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Projecting {
    /// Shape.
    pub footprint: Footprint,
    /// Factor on the radius.
    pub radius_factor: f32,
    /// Largest radius in pixels.
    pub max_radius_px: f32,
    /// Factor on the opacity; the product is at most 1.
    pub opacity_factor: f32,
    /// Which points.
    pub part: Part,
    /// Whether depths of splats are relative to the nearest depth of the points' box: the less they are, the more digits they
    /// have.
    pub relative_depth: bool,
    /// Shading, unless the cloud has no normals.
    pub shading: Shading,
    /// In which space colors are blended.
    pub color: ColorSpace,
    /// Whether the cloud's shares of light count ([`DeviceCloud::casting`]); only where it has some.
    pub lit: bool,
}

impl Projecting {
    /// How points of a cloud with or without normals are shaded.
    pub(crate) fn shaded(&self, normals: bool) -> Shaded {
        Shaded { model: self.shading.model, color: self.color, lit: self.lit, normals }
    }
}

/// What shaders depend on that shade points.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Shaded {
    model: ShadingModel,
    color: ColorSpace,
    lit: bool,
    normals: bool,
}

choices!(
    enum ShadingModel {
        None,
        Lambert,
        Phong,
    }
);
choices!(
    enum ColorSpace {
        Linear,
        Encoded,
    }
);
choices!(struct Shaded { model, color, lit, normals });

impl Shaded {
    /// The variant of shaders/shared/shade.wgsl.
    pub(crate) fn variant(self) -> Variant {
        // Without a normal there is still a share of light.
        let model = if self.normals || self.lit { self.model } else { ShadingModel::None };
        let variant = Variant::plain().with("SHADING", model as u32).with("LIT", u32::from(self.lit));
        variant.with("ENCODED", self.color as u32)
    }

    /// That variant of a shader that reads points in parts.
    pub(crate) fn cut(self, cut: Cut) -> Variant {
        self.variant().with("PARTS", cut.parts).with("PART_LENGTH", cut.len)
    }

    /// The variants of such a shader.
    pub(crate) fn cut_variants() -> Vec<Variant> {
        <(Self, Cut)>::all().into_iter().map(|(shaded, cut)| shaded.cut(cut)).collect()
    }
}

group! {
    /// What a pass binds of one chunk of points that it takes straight to their pixels.
    pub Places as PlacesGroup {
        /// The camera.
        camera: Uniform<View>,
        /// Positions, rounded.
        points_hi: Read<[f32; 4]>,
        /// The rest of the positions.
        points_lo: Read<[f32; 4]>,
        /// What the passes find.
        stats: ReadWrite<Stats>,
    }
}

/// A cloud on the device, with room for its splats.
///
/// Chunks are ranges of points short enough to be bound; every per-point buffer is bound chunk by chunk.
pub struct DeviceCloud {
    origin: DVec3,
    /// Of the points' box.
    corners: [DVec3; 8],
    len: u64,
    chunk_len: u64,
    has_normals: bool,
    has_fields: bool,
    opacity_factor: f32,
    most_opacity: f32,
    most_color: f32,
    most_radius: f32,
    /// What depths of splats are relative to.
    depth_origin: f32,
    /// Field and radius of each point, if there is a field; and what was last found in them.
    fields_and_radii: Vec<[f32; 2]>,
    parts: Option<(f32, Parts)>,
    /// World positions, if there is a field: what orders along the axes are made from, and those that were asked for.
    positions: Vec<DVec3>,
    orders: [Option<Buffer<u32>>; 3],
    orders_made: u32,
    /// The clouds of a dealt list.
    surfaces: Option<Vec<Placed>>,
    /// What the shares of light belong to that normals carry.
    casting: Option<Casting>,
    /// The points of a dealt list: whether they fit the device, the frame decides.
    host: Option<Arc<Points>>,
    /// Positions relative to the cloud's origin, rounded, with radii.
    pub points_hi: Buffer<[f32; 4]>,
    /// The rest of the positions, with opacities.
    pub points_lo: Buffer<[f32; 4]>,
    /// Their colors, linear, and as the bits of the fourth where in the files each point stood.
    pub point_colors: Buffer<[f32; 4]>,
    /// Their normals, and the share of light that reaches each point, 1 without shadows. A single element if there are neither.
    pub normals: Buffer<[f32; 4]>,
    /// Their scalar field; a single element if there is none.
    pub fields: Buffer<f32>,
    /// Projected splats.
    pub splats: Buffer<Splat>,
    /// Their tilts; a single element unless the cloud has normals, or had to be exact.
    pub tilts: Buffer<Tilt>,
    /// Their rectangles.
    pub bounds: Buffer<Bounds>,
    /// Their colors, as blended, and opacities.
    pub colors: Buffer<[f32; 4]>,
    /// Per chunk, the chunk's large splats.
    pub large: Buffer<u32>,
    /// Tiles of each large splat.
    pub tile_counts: Buffer<u32>,
    /// One for each chunk.
    stats: Buffer<Stats>,
    stats_host: Buffer<Stats>,
    view: Buffer<View>,
}

/// Splits coordinates into a float and the rest.
fn split(v: DVec3) -> (Vec3, Vec3) {
    let hi = v.as_vec3();
    (hi, (v - hi.as_dvec3()).as_vec3())
}

/// Points that tell the middle of all.
const TELLING: usize = 4096;

/// What positions are counted from: the median of each coordinate, of evenly many of them if they are many. Points far off,
/// however far, take no digits from the others, as they do from the middle of a box around all.
fn middle(positions: &[DVec3]) -> DVec3 {
    let step = positions.len().div_ceil(TELLING).max(1);
    let median = |axis: usize| {
        let mut all: Vec<f64> = positions.iter().step_by(step).map(|position| position[axis]).collect();
        let half = all.len() / 2;
        if all.is_empty() { 0.0 } else { *all.select_nth_unstable_by(half, f64::total_cmp).1 }
    };
    DVec3::new(median(0), median(1), median(2))
}

fn padded(v: Vec3) -> [f32; 4] {
    [v.x, v.y, v.z, 0.0]
}

/// A buffer for nothing.
fn empty<T: GpuType>(device: &Device, name: &str) -> Result<Buffer<T>, Error> {
    device.buffer(name, 0, Memory::Device)
}

/// What a device holds of each point, a vector each.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Column {
    /// The position relative to the cloud's origin, rounded, and the radius.
    High = 0,
    /// The rest of the position, and the opacity.
    Low = 1,
    /// Color, and as the bits of the fourth where in the files the point stood.
    Color = 2,
    /// The normal, of clouds that have some, and the share of light: 1.
    Normal = 3,
}

/// Bytes that a point has in each column.
pub const COLUMN_BYTES: u64 = size_of::<[f32; 4]>() as u64;

impl Column {
    /// All of them, normals last.
    pub const ALL: [Self; 4] = [Self::High, Self::Low, Self::Color, Self::Normal];

    /// The column of some points.
    fn of(
        self,
        points: &Points,
        origin: DVec3,
        range: Range<usize>,
    ) -> impl IndexedParallelIterator<Item = [f32; 4]> + '_ {
        range.into_par_iter().map(move |i| self.of_point(points, origin, i))
    }

    /// Brings the column of all points to the front of a buffer.
    fn upload(self, points: &Points, origin: DVec3, buffer: &Buffer<[f32; 4]>) -> Result<(), Error> {
        buffer.upload_by(points.len() as u64, |range, to| {
            self.of(points, origin, range).zip(to).for_each(|(from, to)| *to = from);
        })
    }

    fn of_point(self, points: &Points, origin: DVec3, i: usize) -> [f32; 4] {
        let with = |v: Vec3, w: f32| [v.x, v.y, v.z, w];
        match self {
            Self::High => with(split(points.positions[i] - origin).0, points.radii[i]),
            Self::Low => with(split(points.positions[i] - origin).1, points.opacities[i]),
            Self::Color => {
                let place = points.file_order.get(i).copied().unwrap_or(i as u32);
                with(points.colors[i], f32::from_bits(place))
            }
            Self::Normal => with(points.normals.as_ref().map_or(Vec3::ZERO, |normals| normals[i]), 1.0),
        }
    }
}

impl DeviceCloud {
    /// Uploads a scene's points.
    pub fn new(device: &Device, points: &Points) -> Result<Self, Error> {
        let mut cloud = Self::without_columns(device, points)?;
        cloud.upload_columns(device, points)?;
        cloud.make_room(device)?;
        Ok(cloud)
    }

    /// Takes points that were dealt. They come to the device when a frame asks for them: all by [`Self::make_resident`], or
    /// some after others by [`Self::pack`]. Room for splats is made when a method asks for it.
    pub fn of_dealt(device: &Device, dealt: &Dealt) -> Result<Self, Error> {
        let mut cloud = Self::without_columns(device, &dealt.points)?;
        cloud.surfaces = Some(Placed::all(&dealt.points, &dealt.surfaces));
        cloud.host = Some(dealt.points.clone());
        Ok(cloud)
    }

    /// Uploads all points of a cloud that was dealt, unless they are there.
    pub fn make_resident(&mut self, device: &Device) -> Result<(), Error> {
        match self.host.clone() {
            Some(points) if self.points_hi.len() < self.len => self.upload_columns(device, &points),
            _ => Ok(()),
        }
    }

    /// Frees what a cloud that was dealt has on the device, of which the host keeps the points.
    pub fn release(&mut self, device: &Device) -> Result<(), Error> {
        if self.host.is_some() && !self.points_hi.is_empty() {
            let (points_hi, points_lo) = (empty(device, "points, hi")?, empty(device, "points, lo")?);
            (self.points_hi, self.points_lo) = (points_hi, points_lo);
            (self.point_colors, self.normals) = (empty(device, "point colors")?, empty(device, "normals")?);
            (self.fields, self.orders) = (empty(device, "fields")?, [None, None, None]);
            self.casting = None;
            (self.splats, self.tilts) = (empty(device, "splats")?, empty(device, "tilts")?);
            (self.bounds, self.colors) = (empty(device, "splat bounds")?, empty(device, "splat colors")?);
            (self.large, self.tile_counts) = (empty(device, "large splats")?, empty(device, "tile counts")?);
        }
        Ok(())
    }

    /// What the device holds of each point.
    pub fn columns(&self) -> &'static [Column] {
        if self.has_normals { &Column::ALL } else { &Column::ALL[..3] }
    }

    /// Device bytes of all columns.
    pub fn column_bytes(&self) -> u64 {
        self.len * self.columns().len() as u64 * COLUMN_BYTES
    }

    /// Puts a column of some points of a cloud that was dealt behind what is there.
    pub fn pack(&self, column: Column, range: Range<u64>, into: &mut Vec<[f32; 4]>) {
        if let Some(points) = &self.host {
            into.par_extend(column.of(points, self.origin, range.start as usize..range.end as usize));
        }
    }

    /// Makes room for splats, unless there is.
    pub fn make_room(&mut self, device: &Device) -> Result<(), Error> {
        let len = self.len;
        if self.splats.len() < len {
            self.splats = device.buffer("splats", len, Memory::Device)?;
            self.tilts = device.buffer("tilts", if self.has_normals { len } else { 1 }, Memory::Device)?;
            self.bounds = device.buffer("splat bounds", len, Memory::Device)?;
            self.colors = device.buffer("splat colors", len, Memory::Device)?;
            self.large = device.buffer("large splats", len, Memory::Device)?;
            self.tile_counts = device.buffer("tile counts", len, Memory::Device)?;
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
        (self.points_hi, self.points_lo) = (points_hi, points_lo);
        (self.point_colors, self.normals) = (point_colors, normals);
        self.casting = None;
        Ok(())
    }

    /// Room for shares of light, which clouds without normals have none for yet. What was there belongs to no light from here on.
    pub fn reserve_shares(&mut self, device: &Device) -> Result<(), Error> {
        self.casting = None;
        if self.normals.len() < self.len {
            self.normals = device.buffer("normals", self.len, Memory::Device)?;
        }
        Ok(())
    }

    /// What the shares of light belong to; `None`: no shadows were cast, or others put there.
    pub fn casting(&self) -> Option<&Casting> {
        self.casting.as_ref()
    }

    /// Says what the shares of light belong to that were put there.
    pub fn set_casting(&mut self, casting: Casting) {
        self.casting = Some(casting);
    }

    /// Puts shares of light there that were found before, in the order of the points that were uploaded.
    pub fn put_lit(
        &mut self,
        device: &Device,
        points: &Points,
        casting: Casting,
        lit: impl Fn(usize) -> f32 + Sync,
    ) -> Result<(), Error> {
        self.reserve_shares(device)?;
        self.normals.upload_by(self.len, |range, to| {
            let first = range.start;
            let column = Column::Normal.of(points, self.origin, range).zip(to).enumerate();
            column.for_each(|(i, ([x, y, z, _], to))| *to = [x, y, z, lit(first + i)]);
        })?;
        self.set_casting(casting);
        Ok(())
    }

    /// m of each point, the share of light that reaches it, in the order of the points that were uploaded; 1 without shadows.
    pub fn lit(&self) -> Result<Vec<f32>, Error> {
        match self.casting {
            Some(_) => Ok(self.normals.read(0, self.len)?.into_iter().map(|normal| normal[3]).collect()),
            None => Ok(vec![1.0; self.len as usize]),
        }
    }

    fn without_columns(device: &Device, points: &Points) -> Result<Self, Error> {
        let origin = middle(&points.positions);
        let len = points.len() as u64;
        let has_normals = points.normals.as_ref().is_some_and(|normals| !normals.is_empty());
        // Splats are the widest element; a chunk starts at a multiple of any device's offset alignment.
        let chunk_len = ((device.limits().binding_bytes / size_of::<Splat>() as u64) & !0xffff).max(0x1_0000);
        let chunks = len.div_ceil(chunk_len).max(1);
        Ok(Self {
            origin,
            corners: points.bounds().map_or([origin; 8], |b| b.corners()),
            len,
            chunk_len,
            has_normals,
            has_fields: !points.fields.is_empty(),
            opacity_factor: 1.0,
            depth_origin: 0.0,
            most_opacity: most(&points.opacities),
            most_color: most_of_colors(&points.colors),
            most_radius: most(&points.radii),
            fields_and_radii: fields_and_radii(points),
            parts: None,
            positions: if points.fields.is_empty() { Vec::new() } else { points.positions.clone() },
            orders: [None, None, None],
            orders_made: 0,
            surfaces: None,
            casting: None,
            host: None,
            points_hi: empty(device, "points, hi")?,
            points_lo: empty(device, "points, lo")?,
            point_colors: empty(device, "point colors")?,
            normals: empty(device, "normals")?,
            fields: empty(device, "fields")?,
            splats: empty(device, "splats")?,
            tilts: empty(device, "tilts")?,
            bounds: empty(device, "splat bounds")?,
            colors: empty(device, "splat colors")?,
            large: empty(device, "large splats")?,
            tile_counts: empty(device, "tile counts")?,
            stats: device.buffer("splat stats", chunks, Memory::Device)?,
            stats_host: device.buffer("splat stats, host", chunks, Memory::Readback)?,
            view: device.buffer("view", 1, Memory::Upload)?,
        })
    }

    /// Makes room for tilts, for a footprint that has some.
    pub fn reserve_tilts(&mut self, device: &Device, footprint: Footprint) -> Result<(), Error> {
        if footprint.has_tilts() && self.tilts.len() < self.len {
            self.tilts = device.buffer("tilts", self.len, Memory::Device)?;
        }
        Ok(())
    }

    /// Number of points.
    pub fn len(&self) -> u64 {
        self.len
    }

    /// True without points.
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// Device bytes of the cloud and its splats.
    pub fn bytes(&self) -> u64 {
        self.points_hi.bytes()
            + self.points_lo.bytes()
            + self.point_colors.bytes()
            + self.normals.bytes()
            + self.fields.bytes()
            + self.splats.bytes()
            + self.tilts.bytes()
            + self.bounds.bytes()
            + self.colors.bytes()
            + self.large.bytes()
            + self.tile_counts.bytes()
            + self.orders.iter().flatten().map(Buffer::bytes).sum::<u64>()
    }

    /// Whether points have normals.
    pub fn has_normals(&self) -> bool {
        self.has_normals
    }

    /// The largest opacity, with the factor of the last [`Self::set_view`].
    pub fn most_opacity(&self) -> f32 {
        (self.most_opacity * self.opacity_factor).min(1.0)
    }

    /// The depth that those of splats are relative to since the last [`Self::set_view`]: 0, or the nearest of the points' box.
    pub fn depth_origin(&self) -> f32 {
        self.depth_origin
    }

    /// Diagonal of the points' box in world units; 0 without points.
    pub fn diagonal(&self) -> f64 {
        self.bounds().diagonal()
    }

    /// The points' box; a single place without points.
    pub fn bounds(&self) -> Box3 {
        Box3 { min: self.corners[0], max: self.corners[7] }
    }

    /// The largest radius of all points, as uploaded.
    pub fn most_radius(&self) -> f32 {
        self.most_radius
    }

    /// How many points a threshold makes solid and soft.
    pub fn parts(&mut self, threshold: f32) -> Parts {
        match self.parts {
            Some((known, parts)) if known == threshold => parts,
            _ => {
                let parts = Parts::new(self.len, &self.fields_and_radii, threshold);
                self.parts = Some((threshold, parts));
                parts
            }
        }
    }

    /// Puts the points of a cloud with a field into order along an axis, the first time that it is asked for; it stays with
    /// the cloud, whatever threshold, densities and views come.
    pub fn sort_along(&mut self, device: &Device, axis: usize) -> Result<(), Error> {
        if self.orders[axis].is_none() && self.has_fields {
            let order = axes::order(&self.positions, axis);
            self.orders[axis] = Some(device.upload("points along an axis", &order)?);
            self.orders_made += 1;
        }
        Ok(())
    }

    /// How often points were put into order along an axis.
    pub fn orders_made(&self) -> u32 {
        self.orders_made
    }

    /// Indices of the points along an axis; `None` before [`Self::sort_along`], and without a field.
    pub fn along(&self, axis: usize) -> Option<Slice<'_, u32>> {
        self.orders[axis].as_ref().map(Buffer::all)
    }

    /// The largest color component that blending may meet, once shaded and encoded.
    pub fn most_color(&self, how: &Projecting) -> f32 {
        let Shading { model, ambient, diffuse, specular, .. } = how.shading;
        let shaded = match model {
            ShadingModel::None => self.most_color,
            ShadingModel::Lambert => self.most_color * (ambient + diffuse).max(1.0),
            ShadingModel::Phong => self.most_color * (ambient + diffuse).max(1.0) + specular,
        };
        // Rounding up: shading and encoding round by themselves.
        1.001 * if how.color == ColorSpace::Encoded { shaded.max(1.0) } else { shaded }
    }

    /// The clouds of a dealt list; `None` if the points were not dealt.
    pub fn surfaces(&self) -> Option<&[Placed]> {
        self.surfaces.as_deref()
    }

    /// Points that can be bound at a time.
    pub fn longest(&self) -> u64 {
        self.chunk_len
    }

    /// First point and number of points of each chunk.
    pub fn chunks(&self) -> impl Iterator<Item = (u64, u64)> + use<> {
        let (len, chunk_len) = (self.len, self.chunk_len);
        (0..len.div_ceil(chunk_len)).map(move |i| (i * chunk_len, chunk_len.min(len - i * chunk_len)))
    }

    /// The view of the last [`Self::set_view`].
    pub fn view(&self) -> Slice<'_, View> {
        self.view.all()
    }

    /// Sets the camera and the rectangle of pixels that is rendered next.
    pub fn set_view(&mut self, camera: &Camera, size: [u32; 2], window: [u32; 4], how: &Projecting) {
        let rows = |v: DVec3| {
            let (hi, lo) = split(v);
            (padded(hi), padded(lo))
        };
        let (mut eye_hi, mut eye_lo) = rows(camera.eye - self.origin);
        let depths = self.corners.map(|corner| camera.to_view(corner).z);
        let nearest = depths.into_iter().fold(f64::INFINITY, f64::min).max(0.0) as f32;
        eye_hi[3] = if how.relative_depth { nearest } else { 0.0 };
        eye_lo[3] = (camera.near - f64::from(eye_hi[3])) as f32;
        let (right, right_lo) = rows(camera.right);
        let (down, down_lo) = rows(-camera.up);
        let (forward, forward_lo) = rows(camera.forward);
        let (focal, focal_lo) = split(DVec3::splat(camera.focal_px(size[1])));
        let view = View {
            right,
            right_lo,
            down,
            down_lo,
            forward,
            forward_lo,
            eye_hi,
            eye_lo,
            light: light(camera, &how.shading.light),
            material: [how.shading.ambient, how.shading.diffuse, how.shading.specular, how.shading.shininess],
            window,
            size,
            focal: [focal.x, focal_lo.x],
            depth_range: [camera.near as f32, camera.far as f32],
            radius_limits: [how.radius_factor, how.max_radius_px],
            orthographic: u32::from(matches!(camera.projection, Projection::Orthographic { .. })),
            opacity_factor: how.opacity_factor,
            threshold: how.part.threshold(),
            modulation: how.part.modulation(),
        };
        self.opacity_factor = how.opacity_factor;
        self.depth_origin = eye_hi[3];
        self.view.write(&[view]);
    }

    /// Records the projection of all chunks; [`Self::stats`] holds what it found once it was submitted.
    pub fn record_project<'a>(&'a self, recorder: &mut Recorder<'a>, how: &Projecting) -> Result<(), Error> {
        self.record_clear(recorder)?;
        // Without a field F is 0 everywhere: all points are solid, and nobody asks for soft ones.
        let part = if self.has_fields { how.part } else { Part::All };
        let variant = project_variant(&Projecting { part, ..*how }, self.has_normals);
        for (chunk, (first, count)) in self.chunks().enumerate() {
            let used = used_normals(how, self.has_normals);
            // One stands in where none are read: all of them may be more than can be bound.
            let normals = if used { self.normals.slice(first, count) } else { self.normals.slice(0, 1) };
            let pass = Project {
                camera: self.view.all(),
                points_hi: self.points_hi.slice(first, count),
                points_lo: self.points_lo.slice(first, count),
                point_colors: self.point_colors.slice(first, count),
                normals,
                fields: if self.has_fields { self.fields.slice(first, count) } else { self.fields.all() },
                splats: self.splats.slice(first, count),
                tilts: self.tilts_of(first, count),
                bounds: self.bounds.slice(first, count),
                colors: self.colors.slice(first, count),
                large: self.large.slice(first, count),
                tile_counts: self.tile_counts.slice(first, count),
                stats: self.stats.all(),
            };
            let push = ProjectPush { count: count as u32, chunk: chunk as u32 };
            let run = Run::new(Dispatch::Invocations(count.div_ceil(PROJECT_RUN)));
            recorder.run(&pass, push, &run.variant(variant.clone()))?;
        }
        self.record_stats(recorder)
    }

    /// Records that nothing has been found yet.
    pub fn record_clear<'a>(&'a self, recorder: &mut Recorder<'a>) -> Result<(), Error> {
        recorder.fill("splat/clear", self.stats.all(), 0)
    }

    /// Records the copy of what was found to the host, for [`Self::stats`].
    pub fn record_stats<'a>(&'a self, recorder: &mut Recorder<'a>) -> Result<(), Error> {
        recorder.copy("splat/stats", self.stats.all(), self.stats_host.all())
    }

    /// What a pass binds that takes the points of a chunk straight to their pixels.
    pub fn places(&self, first: u64, count: u64) -> Places<'_> {
        let (points_hi, points_lo) = (self.points_hi.slice(first, count), self.points_lo.slice(first, count));
        Places { camera: self.view.all(), points_hi, points_lo, stats: self.stats.all() }
    }

    /// What the last submitted projection found, chunk by chunk.
    pub fn stats(&self) -> Vec<Stats> {
        self.chunks().zip(self.stats_host.mapped_slice()).map(|(_, stats)| *stats).collect()
    }

    /// Tilts of a chunk, or the single element that stands for none.
    pub fn tilts_of(&self, first: u64, count: u64) -> Slice<'_, Tilt> {
        if self.tilts.len() == self.len { self.tilts.slice(first, count) } else { self.tilts.all() }
    }
}

/// Points of one invocation of `splat/project`, at most 32: the more, the fewer atomics meet in the statistics.
const PROJECT_RUN: u64 = 8;

/// The variant of `splat/project` for a cloud with or without normals.
fn project_variant(how: &Projecting, normals: bool) -> Variant {
    how.shaded(used_normals(how, normals)).project(how.footprint, how.part)
}

impl Shaded {
    fn project(self, footprint: Footprint, part: Part) -> Variant {
        self.variant()
            .with("SHAPE", footprint as u32)
            .with("NORMALS", u32::from(self.normals))
            .with("PART", part.value())
            .with("RUN", PROJECT_RUN as u32)
    }
}

/// The passes with their variants.
pub fn shaders() -> Vec<Shader> {
    let soft = Part::Soft { threshold: 0.5, modulation: None };
    let parts = [Part::All, Part::Solid(0.5), soft, Part::Marked(0.5)];
    let choices = <(Shaded, Footprint)>::all();
    let variants = choices.iter().flat_map(|(shaded, shape)| parts.map(|part| shaded.project(*shape, part)));
    vec![Shader::new::<Project>(variants)]
}

/// Whether the buffer of normals is read, for the normals of a cloud that has some or for shares of light.
fn used_normals(how: &Projecting, normals: bool) -> bool {
    let oriented = how.footprint == Footprint::Oriented;
    how.lit || (normals && (how.shading.model != ShadingModel::None || oriented))
}

/// To the light (w = 0), or its place relative to the eye (w = 1), in camera axes.
fn light(camera: &Camera, light: &Light) -> [f32; 4] {
    let axes = |v: DVec3| DVec3::new(v.dot(camera.right), -v.dot(camera.up), v.dot(camera.forward));
    let (v, w) = match *light {
        Light::Direction(direction) => (axes(-direction.normalize_or_zero()), 0.0),
        Light::Position(position) => (axes(position - camera.eye), 1.0),
        Light::Headlight => match camera.projection {
            Projection::Perspective { .. } => (DVec3::ZERO, 1.0),
            Projection::Orthographic { .. } => (DVec3::NEG_Z, 0.0),
        },
    };
    [v.x as f32, v.y as f32, v.z as f32, w]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_threshold_parts_a_cloud() {
        let points = [[0.2, 9.0], [0.6, 3.0], [0.5, 7.0], [0.9, 1.0], [0.7, 2.0], [0.8, 8.0]];
        assert_eq!(Parts::new(6, &points, 0.5), Parts { solid: 2, soft: 4, median_radius: 2.5 });
        assert_eq!(Parts::new(6, &points, 0.6), Parts { solid: 3, soft: 3, median_radius: 2.0 });
        assert_eq!(Parts::new(6, &points, 1.0), Parts { solid: 6, soft: 0, median_radius: 0.0 });
        assert_eq!(Parts::new(6, &[], 0.0), Parts { solid: 6, soft: 0, median_radius: 0.0 });
    }
}
