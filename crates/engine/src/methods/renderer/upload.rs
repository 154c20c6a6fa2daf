//! Points to the device, in whichever order they are.

use std::sync::Arc;

use super::{Error, Renderer};
use crate::cloud::shadow_texture::ShadowTexture;
use crate::passes::bin;
use crate::passes::compose::Cut;
use crate::passes::project::DeviceCloud;
use crate::points::Points;
use crate::prepare::{Arranged, Supplied};
use crate::scene::Detail;
use crate::supply::HeldPoints;

/// Points to bring to a device.
#[derive(Clone, Copy)]
pub struct Upload<'a> {
    /// The points.
    pub points: PointSource<'a>,
    /// Shadows that were stored with the points, in the order of their files. Only points that come to the device all
    /// at once take them.
    pub shadows: Option<&'a ShadowTexture>,
    /// `true` if arranged points in memory come to the device window by window, as they must for frames that leave
    /// points out.
    pub by_windows: bool,
}

/// Source of points.
#[derive(Clone, Copy)]
pub enum PointSource<'a> {
    /// Points that the device holds all at once, whatever their order.
    Whole(&'a Points),
    /// Arranged points. Those in canonical order come window by window if they are more than the device can address, or
    /// than a method can sort.
    /// Dealt ones are for `spbr` and `spbr-simplified`, but any method may render them. They go to the device with the
    /// first frame, or through it while a frame of these methods is rendered, if they don't fit
    /// [`Frame::memory_budget`](crate::methods::Frame::memory_budget). Lists in memory stay there.
    Arranged(&'a Arranged),
}

impl<'a> From<&'a Points> for Upload<'a> {
    fn from(points: &'a Points) -> Self {
        Self { points: PointSource::Whole(points), shadows: None, by_windows: false }
    }
}

impl<'a> From<&'a Arranged> for Upload<'a> {
    fn from(arranged: &'a Arranged) -> Self {
        Self { points: PointSource::Arranged(arranged), shadows: None, by_windows: false }
    }
}

impl<'a> Upload<'a> {
    /// Returns arranged points for frames with this detail.
    pub fn with_detail(arranged: &'a Arranged, detail: &Detail) -> Self {
        Self { by_windows: !detail.is_whole(), ..arranged.into() }
    }
}

impl Renderer {
    /// Brings points to the device: `&Points`, `&Arranged`, or an [`Upload`] that says more of them.
    ///
    /// # Errors
    /// More points than the device can address, or no memory for them.
    pub fn upload<'a>(&self, points: impl Into<Upload<'a>>) -> Result<DeviceCloud, Error> {
        let Upload { points, shadows, by_windows } = points.into();
        let device = &self.device;
        Ok(match points {
            PointSource::Whole(points) => {
                Cut::new(device, points.len() as u64)?;
                DeviceCloud::new(device, points)?
            }
            PointSource::Arranged(arranged) => match arranged {
                Arranged::Canonical(points) if by_windows || points.len() as u64 > Cut::most(device) => {
                    DeviceCloud::of_supply(device, points, Arc::new(HeldPoints::new(points.clone())))?
                }
                Arranged::Canonical(points) => {
                    let mut cloud = DeviceCloud::new(device, points)?;
                    shadows.map_or(Ok(()), |texture| cloud.put_lit(device, arranged, texture))?;
                    if points.len() as u64 > bin::most_points(device) {
                        cloud.hold(Arc::clone(points));
                    }
                    cloud
                }
                Arranged::Dealt(dealt) => {
                    check_dealt(dealt.points.len() as u64)?;
                    DeviceCloud::of_dealt(device, dealt)?
                }
                Arranged::Supplied(Supplied { sample, dealt: Some(file), .. }) => {
                    check_dealt(file.len())?;
                    DeviceCloud::of_dealt_file(device, sample, file)?
                }
                Arranged::Supplied(Supplied { sample, supply, .. }) => {
                    DeviceCloud::of_supply(device, sample, Arc::clone(supply))?
                }
            },
        })
    }
}

/// Refuses more points than an index tells apart: it has 32 bits, and all ones marks none of them.
fn check_dealt(points: u64) -> Result<(), Error> {
    let limit = u64::from(u32::MAX);
    if points > limit { Err(Error::TooManyPoints { points, limit }) } else { Ok(()) }
}
