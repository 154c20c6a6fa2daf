//! Names that nearly every family of cases needs.

pub(super) use glam::{DVec3, Vec3};

pub(super) use super::discs::roundings;
pub(super) use super::lists::*;
pub(super) use super::naive::{self, over};
pub(super) use super::stage::*;
pub(super) use super::{Case, CaseRenderer, CaseResult, Finding, each, joined, one};
pub(super) use pellucid_core::camera::{Camera, Projection};
pub(super) use pellucid_core::image::Image;
pub(super) use pellucid_core::points::Points;
pub(super) use pellucid_core::progress::Progress;
pub(super) use pellucid_engine::Result;
pub(super) use pellucid_engine::methods::Frame;
pub(super) use pellucid_reference::View;
pub(super) use pellucid_scene::{ColorSpace, Discs, GaussianSettings, Hybrid, Method, Order};
