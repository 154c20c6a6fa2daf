//! Names that nearly every method needs, of this module and of the layers below. The modules that it names here, and
//! those that they use, do without it.

pub(crate) use std::ops::Range;

pub(crate) use super::bytes::PassRuns;
pub(crate) use super::engine::{Channels, Counts, Engine, Work, windows_of};
pub(crate) use super::explain::{Absent, Explain, FramePlan, PassGroup};
pub(crate) use super::{Buffers, Error, Frame, Outcome, PixelsGroup, Resources, Target, Timeline};
pub(crate) use crate::choices::Choices;
pub(crate) use crate::gpu::shader::Shader;
pub(crate) use crate::gpu::{Buffer, Device, Dispatch, Expected, Memory, Recorder, Run, Scratch, Slice, Variant};
pub(crate) use crate::passes::bands::{self, Band, Budget, Window};
pub(crate) use crate::passes::bin::{Binned, Bins};
pub(crate) use crate::passes::compose::{self, Cut};
pub(crate) use crate::passes::project::{CloudPart, DeviceCloud, Footprint, PointExtent, Projecting, Stats};
pub(crate) use crate::passes::raster::{Raster, Walker};
pub(crate) use crate::scene::{DiscShape, Discs, Falloff, Method};
pub(crate) use crate::{fields, gpu_struct, group, pass};
