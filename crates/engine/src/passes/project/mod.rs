//! Points on the device, and their projection to splats.

mod beam;
mod cloud;
mod footprint;
mod part;
mod shade;

pub use beam::{Beam, PointExtent};
pub use cloud::{COLUMN_BYTES, Column, CutFor, DeviceCloud, GaussianColumns, LightImages, Placed, Present, View};
pub use footprint::{DISCS, Footprint, TILED};
pub use part::{CloudPart, Parts};
pub(crate) use shade::Shaded;

use self::part::{PART_MARKED, PART_SOFT, PART_SOLID};
use crate::choices::Choices;
use crate::cloud::gaussians::MAX_DEGREE;
use crate::gpu::shader::Shader;
use crate::gpu::{Dispatch, Error, Recorder, Run, Slice, Variant};
use crate::scene::{ColorSpace, DiscShape, Formula, GaussianSettings, Kernel, Order, Shading};
use crate::{gpu_struct, group, pass};

/// A projected splat without its depth: place in its pixel, that pixel, radius; shaders/shared/splat.wgsl says how.
pub type Splat = [u32; 4];

/// An element of the buffer of tilts: the normal of an oriented splat in camera axes; shaders/shared/splat.wgsl says
/// what else. A splat has [`Footprint::tilt_stride`] of them.
pub type Tilt = [f32; 4];

/// Rectangle of pixels that a splat may cover; shaders/shared/splat.wgsl says how.
pub type Bounds = [u32; 2];

gpu_struct! {
    /// Statistics of the projection of one chunk.
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
    /// Returns the number of pixels of all rectangles of all chunks.
    pub fn area(stats: &[Self]) -> u64 {
        stats.iter().map(|s| u64::from(s.area_high) << 32 | u64::from(s.area_low)).sum()
    }

    /// Returns the columns and rows of pixels of the widest and the tallest splat of all chunks.
    pub fn extent(stats: &[Self]) -> [u32; 2] {
        stats.iter().fold([0, 0], |[x, y], s| [x.max(s.widest), y.max(s.tallest)])
    }

    /// Returns bounds of what can be found among so many points in a window of this size.
    pub fn at_most(self, points: u64, [width, height]: [u32; 2]) -> Self {
        let points = points as u32;
        Self {
            visible: self.visible.min(points),
            large: self.large.min(points),
            widest: self.widest.min(width),
            tallest: self.tallest.min(height),
            ..self
        }
    }

    /// Returns the number of tiles of the large splats.
    pub fn tiles(&self) -> u64 {
        u64::from(self.tiles_high) << 32 | u64::from(self.tiles_low)
    }
}

gpu_struct! {
    /// Push constants: points of the chunk, and its number.
    pub struct ProjectPush {
        count: u32, // Points of the chunk, and its number.
        chunk: u32,
    }
}

pass! {
    /// Projects each point to a splat: camera-relative position in two-float arithmetic, culling by near, far and
    /// window, shading, rectangle of pixels. It lists large splats for their tiles.
    pub Project(ProjectPush) = "project/splats" {
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
        splat_depths: ReadWrite<f32>,
    }
}

pass! {
    /// Projects each Gaussian to its ellipse: axes through the camera, factors of its covariance, its color from
    /// harmonics, rectangle of pixels.
    pub ProjectGaussians(ProjectPush) = "project/gaussians" {
        camera: Uniform<View>,
        points_hi: Read<[f32; 4]>,
        points_lo: Read<[f32; 4]>,
        extents: Read<[f32; 4]>,
        rotations: Read<[f32; 4]>,
        harmonics: Read<f32>,
        splats: ReadWrite<Splat>,
        tilts: ReadWrite<Tilt>,
        bounds: ReadWrite<Bounds>,
        colors: ReadWrite<[f32; 4]>,
        large: ReadWrite<u32>,
        tile_counts: ReadWrite<u32>,
        stats: ReadWrite<Stats>,
        splat_depths: ReadWrite<f32>,
    }
}

/// Constants that shaders share with this module.
pub(crate) const CONSTANTS: [(&str, u32); 16] = [
    ("SHAPE_ORIENTED", Footprint::Oriented as u32),
    ("SHAPE_SQUARE", Footprint::Square as u32),
    ("SHAPE_POINT", Footprint::Point as u32),
    ("SHAPE_SPHERE", Footprint::Sphere as u32),
    ("SHAPE_EXACT_SPHERE", Footprint::ExactSphere as u32),
    ("SHAPE_GAUSSIAN_FLAT", Footprint::FlatGaussian as u32),
    ("SHAPE_GAUSSIAN", Footprint::Gaussian as u32),
    ("KERNEL_RAY", Kernel::Ray as u32),
    ("KERNEL_ELLIPSOID", Kernel::Ellipsoid as u32),
    ("ORDER_DISTANCE", Order::Distance as u32),
    ("ORDER_PIXEL", Order::Pixel as u32),
    ("PART_SOLID", PART_SOLID),
    ("PART_SOFT", PART_SOFT),
    ("PART_MARKED", PART_MARKED),
    ("SHADING_NONE", Formula::None as u32),
    ("SHADING_PHONG", Formula::Phong as u32),
];

/// Settings by which splats are made from points.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Projecting {
    /// Shape.
    pub footprint: Footprint,
    /// Factor on the radius.
    pub radius_factor: f32,
    /// Largest radius in pixels.
    pub max_radius_px: f32,
    /// Radius in pixels of all splats, in place of their own and its factor; the largest one still holds.
    pub pixel_radius: Option<f32>,
    /// Factor on the opacity; the product is at most 1.
    pub opacity_factor: f32,
    /// Part of the points.
    pub part: CloudPart,
    /// `true` if depths of splats are relative to the nearest depth of the points' box: the smaller they are, the more
    /// digits they have.
    pub relative_depth: bool,
    /// Number of shells of a soft sphere.
    pub shells: ShellCount,
    /// Shading, unless the cloud has no normals.
    pub shading: Shading,
    /// Space in which colors are blended.
    pub color: ColorSpace,
    /// `true` if the cloud's shares of light count ([`DeviceCloud::casting`]); only where it has some.
    pub lit: bool,
    /// Settings by which Gaussians are drawn, of footprints that have some.
    pub gaussians: Drawing,
    /// Where the samples of pixels lie. Whatever is given in pixels is given in those of the picture.
    pub places: SamplePlaces,
}

impl Projecting {
    /// Returns the conversion of all points as they are, without shading.
    pub fn plain(footprint: Footprint) -> Self {
        Self {
            footprint,
            radius_factor: 1.0,
            max_radius_px: f32::MAX,
            pixel_radius: None,
            opacity_factor: 1.0,
            part: CloudPart::All,
            relative_depth: false,
            shells: ShellCount::ONE,
            shading: Shading::NONE,
            color: ColorSpace::Linear,
            lit: false,
            gaussians: Drawing::default(),
            places: SamplePlaces::MIDDLE,
        }
    }
}

/// Where the samples of pixels lie in them: all in the middle, or, of pixels that are quarters of those of the picture,
/// each where one of four images has it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SamplePlaces {
    /// Column and row of the sample in pixels of even columns and rows, 0 to 1.
    pub first: [f32; 2],
    /// How much farther in x the samples of odd rows lie, and in y those of odd columns; 0 where all lie alike.
    pub step: f32,
    /// How far they lie from the middle at most, in x and y: below ½.
    pub most: f32,
}

impl SamplePlaces {
    /// All in the middle of their pixels.
    pub const MIDDLE: Self = Self { first: [0.5; 2], step: 0.0, most: 0.0 };

    /// Returns the number of columns and rows that a pixel of the picture has.
    pub fn columns(self) -> f32 {
        if self.step > 0.0 { 2.0 } else { 1.0 }
    }
}

/// Number of concentric shells of a soft sphere (Seemann et al. 2018, Section 3.2).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ShellCount {
    /// The most, at least 1.
    pub most: u32,
    /// Pixels of the radius for each shell; 0 where every sphere has the most.
    pub radius_px: f32,
}

impl ShellCount {
    /// A whole sphere.
    pub const ONE: Self = Self { most: 1, radius_px: 0.0 };
}

/// Settings by which Gaussians are drawn.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Drawing {
    /// Kernel and what goes with it.
    pub settings: GaussianSettings,
    /// The order in force.
    pub order: Order,
    /// Orientation of discs that are in the scene, too.
    pub discs: DiscShape,
}

impl Default for Drawing {
    fn default() -> Self {
        Self { settings: GaussianSettings::default(), order: Order::Center, discs: DiscShape::Flat }
    }
}

group! {
    /// Bindings of one chunk of points for a pass that takes them straight to their pixels.
    pub Places as PlacesGroup {
        /// The camera.
        camera: Uniform<View>,
        /// Positions, rounded.
        points_hi: Read<[f32; 4]>,
        /// The rest of the positions.
        points_lo: Read<[f32; 4]>,
        /// Statistics that the passes collect.
        stats: ReadWrite<Stats>,
    }
}

gpu_struct! {
    /// Push constants: points of the chunk, its number, and the index of its first point among all; and, of passes
    /// over several images of a frame, which.
    pub struct PointsPush {
        count: u32, // Points of the chunk, its number, and the index of its first point among all.
        chunk: u32,
        first: u32,
        first_turn: u32, // The first image in work, how many are, and how many the frame has.
        images: u32,
        samples: u32,
        stride: u32, // From a pixel of an image to the same of the next.
    }
}

impl PointsPush {
    /// Creates those of a chunk with so many points from the first one.
    pub fn new(chunk: usize, (first, count): (u64, u64)) -> Self {
        let (count, chunk, first) = (count as u32, chunk as u32, first as u32);
        Self { count, chunk, first, first_turn: 0, images: 1, samples: 1, stride: 0 }
    }
}

/// Points of one invocation of a pass that takes them straight to their pixels, at most 32. Those of doubtful pixel are
/// done once more at the end: the more points, the fewer such ends.
pub const POINTS_RUN: u64 = 16;

/// Returns the dispatch of a pass over a chunk of so many points.
pub fn points_dispatch(count: u64) -> Dispatch<'static> {
    Dispatch::Invocations(count.div_ceil(POINTS_RUN))
}

/// Points of one invocation of `project/splats`, at most 32: the more, the fewer atomics meet in the statistics.
const PROJECT_RUN: u64 = 8;

impl DeviceCloud {
    /// Records the projection of all chunks; [`Self::found`] then holds what it found.
    pub fn record_project<'a>(&'a self, recorder: &mut Recorder<'a>, how: &Projecting) -> Result<(), Error> {
        self.record_clear(recorder)?;
        // Without a field F is 0 everywhere: all points are solid, and nobody asks for soft ones.
        let part = if self.has_fields { how.part } else { CloudPart::All };
        let variant = project_variant(&Projecting { part, ..*how }, self.has_normals, self.prefers.shared_work);
        let gaussians = self.gaussians.as_ref().filter(|_| how.footprint.has_gaussians());
        for (chunk, (first, count)) in self.chunks().enumerate() {
            if gaussians.is_some_and(|gaussians| gaussians.are_all) {
                break;
            }
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
                tilts: self.tilts_of(how.footprint, first, count),
                bounds: self.bounds.slice(first, count),
                colors: self.colors.slice(first, count),
                large: self.large.slice(first, count),
                tile_counts: self.tile_counts.slice(first, count),
                stats: self.stats.all(),
                splat_depths: self.splat_depths.slice(first, count),
            };
            let push = ProjectPush { count: count as u32, chunk: chunk as u32 };
            let run = Run::new(Dispatch::Invocations(count.div_ceil(PROJECT_RUN)));
            recorder.run(&pass, push, &run.variant(variant.clone()))?;
        }
        match gaussians {
            Some(gaussians) => self.record_gaussians(recorder, how, gaussians),
            None => Ok(()),
        }
    }

    fn record_gaussians<'a>(
        &'a self,
        recorder: &mut Recorder<'a>,
        how: &Projecting,
        gaussians: &'a GaussianColumns,
    ) -> Result<(), Error> {
        let mixed = !gaussians.are_all;
        let variant = gaussian_variant((how.footprint, how.color), gaussians.degree, mixed, self.prefers.shared_work);
        let words = gaussians.words();
        for (chunk, (first, count)) in self.chunks().enumerate() {
            let pass = ProjectGaussians {
                camera: self.view.all(),
                points_hi: self.points_hi.slice(first, count),
                points_lo: self.points_lo.slice(first, count),
                extents: gaussians.extents.slice(first, count),
                rotations: gaussians.rotations.slice(first, count),
                harmonics: gaussians.harmonics.slice(first * words, count * words),
                splats: self.splats.slice(first, count),
                tilts: self.tilts_of(how.footprint, first, count),
                bounds: self.bounds.slice(first, count),
                colors: self.colors.slice(first, count),
                large: self.large.slice(first, count),
                tile_counts: self.tile_counts.slice(first, count),
                stats: self.stats.all(),
                splat_depths: self.splat_depths.slice(first, count),
            };
            let push = ProjectPush { count: count as u32, chunk: chunk as u32 };
            let run = Run::new(Dispatch::Invocations(count.div_ceil(PROJECT_RUN)));
            recorder.run(&pass, push, &run.variant(variant.clone()))?;
        }
        Ok(())
    }

    /// Returns statistics of the last projection, on the device: one for each chunk.
    pub fn found(&self) -> Slice<'_, Stats> {
        self.stats.slice(0, self.chunks().count() as u64)
    }

    /// Records the view, and that nothing has been found yet.
    pub fn record_clear<'a>(&'a self, recorder: &mut Recorder<'a>) -> Result<(), Error> {
        self.record_view(recorder);
        recorder.fill("project/clear", self.stats.all(), 0)
    }

    /// Records the copy of the statistics to the host, for [`Self::stats`].
    pub fn record_stats<'a>(&'a self, recorder: &mut Recorder<'a>) -> Result<(), Error> {
        recorder.copy("project/stats", self.stats.all(), self.stats_host.all())
    }

    /// Returns bindings of a pass that takes the points of a chunk straight to their pixels.
    pub fn places(&self, first: u64, count: u64) -> Places<'_> {
        let (points_hi, points_lo) = (self.points_hi.slice(first, count), self.points_lo.slice(first, count));
        Places { camera: self.view.all(), points_hi, points_lo, stats: self.stats.all() }
    }

    /// Returns statistics of the last submitted projection, chunk by chunk.
    pub fn stats(&self) -> Vec<Stats> {
        self.chunks().zip(self.stats_host.mapped_slice()).map(|(_, stats)| *stats).collect()
    }
}

/// The variant of `project/splats` for a cloud with or without normals; `shared` if workgroups share statistics.
fn project_variant(how: &Projecting, normals: bool, shared: bool) -> Variant {
    how.shaded(used_normals(how, normals)).project(how.footprint, how.part, shared)
}

impl Shaded {
    fn project(self, footprint: Footprint, part: CloudPart, shared: bool) -> Variant {
        self.variant()
            .walker(if shared { "found_by_group" } else { "found_alone" })
            .with("SHAPE", footprint as u32)
            .with("NORMALS", u32::from(self.normals))
            .with("PART", part.value())
            .with("RUN", PROJECT_RUN as u32)
    }
}

/// Returns the passes with their variants.
pub fn shaders() -> Vec<Shader> {
    let soft = CloudPart::Soft { threshold: 0.5, modulation: None };
    let parts = [CloudPart::All, CloudPart::Solid(0.5), soft, CloudPart::Marked(0.5)];
    let choices = <((Shaded, Footprint), bool)>::all();
    let variants =
        choices.iter().flat_map(|((shaded, shape), shared)| parts.map(|part| shaded.project(*shape, part, *shared)));
    vec![Shader::new::<Project>(variants), Shader::new::<ProjectGaussians>(gaussian_variants())]
}

/// The variant of `project/gaussians`; `mixed` if some points are none, `shared` if workgroups share statistics.
fn gaussian_variant((footprint, color): (Footprint, ColorSpace), degree: u32, mixed: bool, shared: bool) -> Variant {
    Variant::plain()
        .walker(if shared { "found_by_group" } else { "found_alone" })
        .with("SHAPE", footprint as u32)
        .with("ENCODED", color as u32)
        .with("DEGREE", degree)
        .with("MIXED", u32::from(mixed))
        .with("RUN", PROJECT_RUN as u32)
}

fn gaussian_variants() -> Vec<Variant> {
    let choices = <((ColorSpace, bool), bool)>::all();
    let each = choices.into_iter().flat_map(|((color, mixed), shared)| {
        [Footprint::FlatGaussian, Footprint::Gaussian].into_iter().flat_map(move |footprint| {
            (0..=MAX_DEGREE).map(move |degree| gaussian_variant((footprint, color), degree, mixed, shared))
        })
    });
    each.collect()
}

/// Returns `true` if the buffer of normals is read, for the normals of a cloud that has some or for shares of light.
fn used_normals(how: &Projecting, normals: bool) -> bool {
    let oriented = how.footprint.may_cross();
    how.lit || (normals && (how.shading.model.formula() != Formula::None || oriented))
}
