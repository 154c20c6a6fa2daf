//! Names that several methods need, of this module and of the layers below. The modules that it names here, and those
//! that they use, do without it.

pub(crate) use std::ops::Range;

pub(crate) use super::bytes::PassRuns;
pub(crate) use super::engine::{Channels, Counts, Engine, Work, windows_of};
pub(crate) use super::explain::{Absent, EACH_PIXEL, Explain, FramePlan, NOTHING, ORDER, PassGroup};
pub(super) use super::told::Told;
pub(super) use super::walker::walker;
pub(crate) use super::{Buffers, Error, Facts, Frame, Outcome, PixelsGroup, Resources, Target, Timeline};
pub(crate) use super::{Layer, Pixels, SamplePart, engine_of};
pub(crate) use crate::camera::{Camera, Projection};
pub(crate) use crate::choices::Choices;
pub(crate) use crate::gpu::shader::Shader;
pub(crate) use crate::gpu::{
    Buffer, Device, DeviceInfo, Dispatch, Expected, Memory, Recorder, Run, Scratch, Slice, Stamps, Variant,
};
pub(crate) use crate::image::Image;
pub(crate) use crate::passes::bands::{self, Band, Budget, Window};
pub(crate) use crate::passes::bin::{self, Bin, Binned, Bins, Lanes, Order, OrderedTiles, TileWalk, TiledGroup};
pub(crate) use crate::passes::compose::{self, Composing, ComposingGroup, Cut, STOPS};
pub(crate) use crate::passes::foresight::Knowledge;
pub(crate) use crate::passes::project::{CloudPart, DISCS, DeviceCloud, Footprint, PointExtent, Projecting, Stats};
pub(crate) use crate::passes::raster::{self, Chunk, ChunkGroup, CountPush, Raster, RasterPush, Walker};
pub(crate) use crate::progress::Progress;
pub(crate) use crate::scene::{BlendedSplats, DiscShape, Discs, Falloff, Kernel, LongLists, Method, ScreenSplats};
pub(crate) use crate::{choices, fields, gpu_struct, group, pass};
