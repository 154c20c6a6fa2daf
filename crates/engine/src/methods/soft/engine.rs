//! The engines of soft points: `soft-base` and `soft-concentric` as spheres, `soft-express` as discs.
//!
//! A window is drawn in two parts: solid points into a layer, as `splats` draws them, and soft points before it.

use super::express::{self, COUNT_BYTES, SoftDiscs};
use super::{Interior, SoftModel, SphereKind, Spheres, explain, pixel_bytes, record_compose};
use crate::methods::abuffer::{self, ABuffer, Sampling, Taken, list_bytes};
use crate::methods::prelude::*;
use crate::methods::projecting::UNCLAMPED;
use crate::methods::splats::{self, Onto, solid_projecting};
use crate::methods::tiled;
use crate::passes::project::Parts;
use crate::prepare::axes::Axis;
use crate::scene::Soft;

/// Soft points as spheres whose interior is integrated.
pub(crate) struct SpheresEngine {
    /// The threshold and density of soft points.
    pub soft: Soft,
    /// The interior of a sphere.
    pub interior: Interior,
}

/// Soft points as discs in an order along an axis.
pub(crate) struct ExpressEngine {
    /// The threshold and density of soft points.
    pub soft: Soft,
}

impl SpheresEngine {
    fn projecting(&self, frame: &Frame, cloud: &DeviceCloud, kind: SphereKind) -> Projecting {
        let shells = kind.interior.shells();
        Projecting { relative_depth: true, shells, ..projecting(frame, cloud, &self.soft, kind.footprint()) }
    }

    /// Returns settings of discs that sort long lists as those of the soft points say.
    fn sorting(&self) -> Discs {
        Discs { long_lists: self.soft.long_lists, ..Discs::default() }
    }

    /// Hands the lists of a window's soft points, which lie before its layer, to `go_on`; `None` if the window must be
    /// cut.
    fn soft_points<T>(
        &self,
        cloud: &mut DeviceCloud,
        buffers: &mut Buffers,
        work: &mut Work<'_>,
        parts: Parts,
        go_on: impl FnOnce(&mut ABuffer, &mut Work<'_>, &abuffer::ListsJob<'_>, Option<&Layer>) -> Result<T, Error>,
    ) -> Result<Option<T>, Error> {
        let Buffers { tiles, resources } = buffers;
        let (frame, window, interior) = (work.frame, work.window, self.interior);
        let model = SoftModel::new(&frame.method, &self.soft, parts.median_radius * frame.factors.radius);
        let max_radius = cloud.max_radius() * frame.factors.radius;
        let exact = model.is_stiff(interior, max_radius);
        let kind = SphereKind { interior, exact, modulated: self.soft.modulation.is_some() };
        let how = self.projecting(frame, cloud, kind);
        let stats = work.project(cloud, &how)?;
        let Some(mut budget) = work.reserve_tiles(tiles, &stats, true)? else { return Ok(None) };
        let solid = parts.solid > 0;
        if solid {
            budget.tiles += resources.bins.bytes();
        }
        let (walker, footprint) = (Walker::Compute, how.footprint);
        let raster = Raster { cloud, stats: &stats, tiles, walker, footprint, window };
        let layer = solid.then_some(&resources.layer);
        let spheres = Spheres { kind, model, max_radius, origin: cloud.depth_origin(), layer };
        spheres.check(&frame.method, cloud.len())?;
        let stop = compose::stop(frame.stop, frame.color, cloud.max_color(&how));
        let (discs, shown) = (self.sorting(), abuffer::Shown::First);
        let job = abuffer::ListsJob { raster, discs, storing: &spheres, stop, shown, budget, samples: None };
        let found = go_on(&mut resources.lists, work, &job, layer)?;
        resources.soft_counted = true;
        let seen = stats.found;
        work.note_later(move |facts, timeline| {
            let stats = seen.stats(timeline);
            facts.soft_visible += visible(&stats);
            facts.soft_large += stats.iter().map(|s| u64::from(s.large)).sum::<u64>();
        });
        work.note(&stats, walker);
        Ok(Some(found))
    }

    /// Returns the samples of a window's soft points, with its solid ones behind them; how many there are at most, or
    /// `None` if the window must be cut.
    pub fn samples(
        &self,
        cloud: &mut DeviceCloud,
        buffers: &mut Buffers,
        work: &mut Work<'_>,
        take: &mut Take<'_>,
    ) -> Result<Option<u64>, Error> {
        let parts = cloud.parts(self.soft.threshold);
        let how = Projecting { relative_depth: true, ..solids(work.frame, cloud, &self.soft) };
        if draw_solids(cloud, buffers, work, (parts, &how, true))? == Outcome::Overflow {
            return Ok(None);
        }
        let (origin, pixels, survey) = (cloud.depth_origin(), work.pixels(), work.survey);
        let most_solid = if parts.solid > 0 { pixels } else { 0 };
        if parts.soft == 0 {
            if !survey {
                let found = Solids::read(&buffers.resources.layer, [0, pixels], origin, parts)?;
                take(&Taken::nothing(pixels), found.as_ref())?;
            }
            return Ok(Some(most_solid));
        }
        let found = self.soft_points(cloud, buffers, work, parts, |lists, work, job, layer| {
            let job = abuffer::ListsJob { samples: Some(1), ..*job };
            lists.samples(work, &job, Sampling { bodies: false }, &mut |taken| {
                let [start, end] = taken.pixels.map(u64::from);
                let solids = layer.map(|layer| Solids::read(layer, [start, end - start], origin, parts)).transpose()?;
                take(taken, solids.flatten().as_ref())
            })
        })?;
        Ok(found.flatten().map(|most| most + most_solid))
    }
}

/// Takes the samples of some pixels, and their solid points where there are any.
type Take<'a> = dyn FnMut(&Taken<'_>, Option<&Solids>) -> Result<(), Error> + 'a;

/// The solid points of some pixels, on the host.
pub(crate) struct Solids {
    /// Premultiplied color, and A.
    pub colors: Vec<[f32; 4]>,
    /// Depths along the viewing axis, +inf where nothing is.
    pub depths: Vec<f32>,
}

impl Solids {
    /// Reads the solid points of a layer; `None` if no point is solid.
    fn read(layer: &Layer, range: [u64; 2], origin: f32, parts: Parts) -> Result<Option<Self>, Error> {
        if parts.solid == 0 {
            return Ok(None);
        }
        let (colors, relative) = layer.read(range)?;
        Ok(Some(Self { colors, depths: relative.into_iter().map(|depth| depth + origin).collect() }))
    }
}

impl Engine for SpheresEngine {
    fn sorts(&self, _device: &DeviceInfo) -> bool {
        true
    }

    fn windows(&self, frame: &Frame, budget: Budget) -> Result<Vec<Window>, Error> {
        Ok(windows_of(frame, budget, abuffer::PIXEL_BYTES.max(bin::PIXEL_BYTES) + pixel_bytes(self.interior, true)))
    }

    fn channels(&self) -> Channels {
        Channels::LISTS_WITHIN
    }

    /// Solid points decide how much of a sphere is counted, so a survey draws them, too, if spheres are present.
    fn render(&self, cloud: &mut DeviceCloud, buffers: &mut Buffers, work: &mut Work<'_>) -> Result<Outcome, Error> {
        let parts = cloud.parts(self.soft.threshold);
        let how = Projecting { relative_depth: true, ..solids(work.frame, cloud, &self.soft) };
        let drawn = parts.soft > 0;
        if draw_solids(cloud, buffers, work, (parts, &how, drawn))? == Outcome::Overflow {
            return Ok(Outcome::Overflow);
        }
        match parts.soft {
            0 => only_solids(cloud, &buffers.resources.layer, work),
            _ => {
                let render =
                    |lists: &mut ABuffer, work: &mut Work<'_>, job: &abuffer::ListsJob<'_>, _: Option<&Layer>| {
                        if work.survey { lists.survey(work, job) } else { lists.render(work, job) }
                    };
                let found = self.soft_points(cloud, buffers, work, parts, render)?;
                Ok(found.unwrap_or(Outcome::Overflow))
            }
        }
    }

    fn counts(&self, buffers: &Buffers, frame: &Frame, window: Window) -> Result<Counts, Error> {
        let Resources { lists, soft_counted, .. } = &buffers.resources;
        let asked = frame.fragments && *soft_counted;
        let fragments = if asked { Some(lists.read_bodies(window)?) } else { None };
        Ok(Counts { fragments, ..Counts::default() })
    }
}

impl Explain for SpheresEngine {
    /// The number of solid splats is unknown.
    fn least_bytes(&self, pass: &PassRuns<'_>) -> Option<u64> {
        match pass.name {
            "soft/count" => Some(pass.walks(false) + pass.facts.fragments * 8),
            "soft/compose" => Some(pass.pixels() * 3 * 20),
            _ => pass.projected(false).or_else(|| list_bytes(pass, false)),
        }
    }

    fn explain(&self, plan: &mut FramePlan<'_>) {
        explain::spheres(plan, &self.soft, self.interior);
    }
}

impl ExpressEngine {
    /// The soft points of a window before its layer, and the window from both.
    fn soft_points(
        &self,
        cloud: &mut DeviceCloud,
        buffers: &mut Buffers,
        work: &mut Work<'_>,
        parts: Parts,
    ) -> Result<Outcome, Error> {
        let Buffers { tiles, resources } = buffers;
        let (device, frame, window, soft) = (work.device, work.frame, work.window, &self.soft);
        let how = projecting(frame, cloud, soft, Footprint::Disc);
        let stats = work.project(cloud, &how)?;
        let (walker, footprint) = (Walker::Compute, how.footprint);
        let raster = Raster { cloud, stats: &stats, tiles, walker, footprint, window };
        let order = Order::Along(Axis::nearest(frame.camera.forward));
        let counts = if frame.fragments { bands::pixels(window) * COUNT_BYTES } else { 0 };
        // The memory for sorting solid points is still allocated.
        let counted_bytes = counts + if parts.solid > 0 { bin::sort_bytes(device, cloud.len()) } else { 0 };
        let bin = bin::Job { raster, order, depth_range: frame.depth_range(), budget: work.budget, counted_bytes };
        let outcome = if work.survey {
            work.facts.note_survey(Bins::survey(device, &bin)?)
        } else {
            let job = express::SoftDiscsJob {
                bin,
                model: SoftModel::new(&frame.method, soft, parts.median_radius * frame.factors.radius),
                modulated: soft.modulation.is_some(),
                layer: (parts.solid > 0).then_some(&resources.layer),
                max_color: cloud.max_color(&how),
            };
            resources.own.of::<SoftDiscs>(device)?.render(&mut resources.bins, work, &job)?
        };
        if outcome == Outcome::Done {
            resources.soft_counted = true;
            let found = stats.found;
            work.note_later(move |facts, timeline| facts.soft_visible += visible(&found.stats(timeline)));
            work.finish();
            work.note(&stats, walker);
        }
        Ok(outcome)
    }
}

impl Engine for ExpressEngine {
    fn sorts(&self, _device: &DeviceInfo) -> bool {
        true
    }

    fn windows(&self, frame: &Frame, budget: Budget) -> Result<Vec<Window>, Error> {
        Ok(windows_of(frame, budget, abuffer::PIXEL_BYTES.max(bin::PIXEL_BYTES) + Layer::PIXEL_BYTES))
    }

    fn prepare(&self, device: &Device, cloud: &mut DeviceCloud, frame: &Frame) -> Result<(), Error> {
        if cloud.parts(self.soft.threshold).soft > 0 {
            cloud.sort_along(device, Axis::nearest(frame.camera.forward).index)?;
        }
        Ok(())
    }

    fn channels(&self) -> Channels {
        Channels::LISTS_WITHIN
    }

    fn render(&self, cloud: &mut DeviceCloud, buffers: &mut Buffers, work: &mut Work<'_>) -> Result<Outcome, Error> {
        let parts = cloud.parts(self.soft.threshold);
        let how = solids(work.frame, cloud, &self.soft);
        if draw_solids(cloud, buffers, work, (parts, &how, false))? == Outcome::Overflow {
            return Ok(Outcome::Overflow);
        }
        match parts.soft {
            0 => only_solids(cloud, &buffers.resources.layer, work),
            _ => self.soft_points(cloud, buffers, work, parts),
        }
    }

    fn counts(&self, buffers: &Buffers, frame: &Frame, _window: Window) -> Result<Counts, Error> {
        let Resources { own, soft_counted, .. } = &buffers.resources;
        let discs = own.there::<SoftDiscs>().filter(|_| frame.fragments && *soft_counted);
        let fragments = discs.map(|discs| discs.counts().to_vec());
        Ok(Counts { fragments, ..Counts::default() })
    }
}

impl Explain for ExpressEngine {
    fn least_bytes(&self, pass: &PassRuns<'_>) -> Option<u64> {
        if pass.name == "soft/compose" {
            return Some(pass.pixels() * 3 * 20);
        }
        // The number of solid splats is unknown.
        let known = pass.facts.solid_points == 0 || ["bin/pick", "bin/place"].contains(&pass.name);
        pass.projected(false).or_else(|| tiled::binned_bytes(pass).filter(|_| known))
    }

    fn explain(&self, plan: &mut FramePlan<'_>) {
        explain::discs(plan, self.soft.threshold);
    }
}

fn visible(stats: &[Stats]) -> u64 {
    stats.iter().map(|s| u64::from(s.visible)).sum()
}

/// The conversion of soft points to splats.
fn projecting(frame: &Frame, cloud: &DeviceCloud, soft: &Soft, footprint: Footprint) -> Projecting {
    let part = CloudPart::Soft { threshold: soft.threshold, modulation: soft.modulation };
    frame.projecting(cloud, footprint, UNCLAMPED, part)
}

/// The conversion of solid points to splats.
fn solids(frame: &Frame, cloud: &DeviceCloud, soft: &Soft) -> Projecting {
    solid_projecting(frame, cloud, CloudPart::Solid(soft.threshold))
}

/// Draws a window's solid points into the layer, or clears it without any pass over splats if none is visible. A survey
/// only decides how they are binned, unless they must be `drawn` even so. The window is not counted, because soft
/// points follow.
fn draw_solids(
    cloud: &mut DeviceCloud,
    buffers: &mut Buffers,
    work: &mut Work<'_>,
    (parts, how, drawn): (Parts, &Projecting, bool),
) -> Result<Outcome, Error> {
    work.facts.solid_points = parts.solid;
    buffers.resources.soft_counted = false;
    if parts.solid == 0 {
        return Ok(Outcome::Done);
    }
    let survey = work.survey;
    work.survey = survey && !drawn;
    if !work.survey {
        buffers.resources.layer.reserve(work.device, work.pixels())?;
    }
    let stats = work.project(cloud, how)?;
    let outcome = splats::draw_solid(cloud, buffers, work, (&stats, how.footprint, Onto::Layer), 0)?;
    work.survey = survey;
    let found = stats.found;
    work.note_later(move |facts, timeline| facts.meet(&found.stats(timeline)));
    Ok(outcome)
}

/// A window without soft points from its layer.
fn only_solids(cloud: &DeviceCloud, layer: &Layer, work: &mut Work<'_>) -> Result<Outcome, Error> {
    if !work.survey {
        let mut recorder = work.timeline.recorder(work.device)?;
        work.target.pixels().record_nothing(&mut recorder, work.window)?;
        record_compose(&mut recorder, layer, work.target, work.pixels(), cloud.depth_origin())?;
        work.timeline.go_on(recorder, "solid points alone")?;
    }
    work.facts.note(&[], Walker::Compute);
    work.read_back()?;
    Ok(Outcome::Done)
}
