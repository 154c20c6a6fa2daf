//! Windows of methods that draw three-pass splats, and of those that tell solid points from soft ones.

use super::{Facts, Frame, Renderer, Work, depth_range, projecting, projecting_of};
use crate::camera::Projection;
use crate::methods::abuffer::{self, Storing};
use crate::methods::bands;
use crate::methods::soft::express;
use crate::methods::soft::{self, Interior, Kind, SoftModel, Spheres};
use crate::methods::spbr::{self, Form, stream};
use crate::methods::{Error, Outcome, one_layer, sorted, splats};
use crate::passes::bin::{self, Bins, Order};
use crate::passes::project::{DeviceCloud, Footprint, Part, Projecting, Stats};
use crate::passes::raster::{self, Walker};
use crate::passes::tiles::Tiles;
use crate::prepare::axes::Axis;
use crate::scene::{BlendedSplats, Discs, Method, OneLayer, ScreenSplats, Soft};

impl Renderer {
    /// Renders a window of three-pass splats.
    pub(super) fn splats(
        &mut self,
        cloud: &mut DeviceCloud,
        frame: &Frame,
        settings: BlendedSplats,
        work: &mut Work<'_>,
    ) -> Result<Outcome, Error> {
        let (how, blend_depth) = (projecting(frame, cloud), settings.blend_depth);
        let stats = self.project_as(cloud, frame, work.window, &how, work.timeline)?;
        let mut facts = work.facts.clone();
        let drawing = Drawing { cloud, stats: &stats, footprint: how.footprint, blend_depth, onto: Onto::Target };
        if let Outcome::Overflow = self.draw_splats(frame, &drawing, work, &mut facts)? {
            return Ok(Outcome::Overflow);
        }
        facts.note(&stats, Walker::Compute);
        *work.facts = facts;
        self.read_back(work)
    }

    /// Draws a window's solid points into the layer, or nothing where none is to be seen, without any pass over splats. Of its
    /// facts `windows` stays as it is: soft points follow.
    fn solid_layer(
        &mut self,
        cloud: &mut DeviceCloud,
        frame: &Frame,
        threshold: f32,
        work: &mut Work<'_>,
    ) -> Result<Outcome, Error> {
        if !work.survey {
            self.layer.reserve(&self.device, bands::pixels(work.window))?;
        }
        let (mut facts, mut stats) = (work.facts.clone(), Vec::new());
        let how = solid_projecting(frame, cloud, Part::Solid(threshold));
        if cloud.parts(threshold).solid > 0 {
            stats = self.project_as(cloud, frame, work.window, &how, work.timeline)?;
        }
        let blend_depth = BlendedSplats::default().blend_depth;
        let drawing = Drawing { cloud, stats: &stats, footprint: how.footprint, blend_depth, onto: Onto::Layer };
        let outcome = self.draw_splats(frame, &drawing, work, &mut facts)?;
        if outcome == Outcome::Done {
            facts.meet(&stats);
            *work.facts = facts;
        }
        Ok(outcome)
    }

    /// Renders a window of `one-layer`: soft points into the layer; then all, but soft ones only behind it, which is laid over
    /// them. Where there is no layer, the solid points.
    pub(super) fn one_layer(
        &mut self,
        cloud: &mut DeviceCloud,
        frame: &Frame,
        OneLayer { threshold, softness }: OneLayer,
        work: &mut Work<'_>,
    ) -> Result<Outcome, Error> {
        let (mut facts, mut met) = (work.facts.clone(), Vec::new());
        let blend_depth = BlendedSplats::default().blend_depth;
        if cloud.parts(threshold).soft > 0 {
            let how = solid_projecting(frame, cloud, Part::Soft { threshold, modulation: None });
            met = self.project_as(cloud, frame, work.window, &how, work.timeline)?;
            if !work.survey {
                self.layer.reserve(&self.device, bands::pixels(work.window))?;
            }
            let drawing = Drawing { cloud, stats: &met, footprint: how.footprint, blend_depth, onto: Onto::Layer };
            if let Outcome::Overflow = self.draw_splats(frame, &drawing, work, &mut facts)? {
                return Ok(Outcome::Overflow);
            }
        }
        let layered = met.iter().any(|s| s.visible > 0);
        let (part, onto) = if layered {
            (Part::Marked(threshold), Onto::TargetBehindLayer)
        } else {
            (Part::Solid(threshold), Onto::Target)
        };
        let how = solid_projecting(frame, cloud, part);
        let stats = self.project_as(cloud, frame, work.window, &how, work.timeline)?;
        let drawing = Drawing { cloud, stats: &stats, footprint: how.footprint, blend_depth, onto };
        if let Outcome::Overflow = self.draw_splats(frame, &drawing, work, &mut facts)? {
            return Ok(Outcome::Overflow);
        }
        facts.layered += u64::from(layered);
        facts.note(&[met, stats].concat(), Walker::Compute);
        *work.facts = facts;
        if layered && !work.survey {
            let mut recorder = self.device.recorder()?;
            one_layer::record(&mut recorder, self.layer.pixels(), self.target.pixels(), work.window, softness)?;
            work.timeline.add(recorder.submit("one-layer/compose")?);
        }
        self.read_back(work)
    }

    /// Draws projected splats in three passes, or decides only how they are binned.
    fn draw_splats(
        &mut self,
        frame: &Frame,
        drawing: &Drawing<'_>,
        work: &mut Work<'_>,
        facts: &mut Facts,
    ) -> Result<Outcome, Error> {
        let Drawing { cloud, stats, footprint, blend_depth, onto } = *drawing;
        let window = work.window;
        let raster = raster::Raster { cloud, stats, tiles: &self.tiles, walker: Walker::Compute, footprint, window };
        let counted_bytes = bands::pixels(window) * splatting_bytes(&frame.method);
        let depth_range = depth_range(frame).map(|depth| depth - cloud.depth_origin());
        let (order, budget) = (Order::Index, work.budget);
        let bin = bin::Job { raster, order, depth_range, budget, counted_bytes };
        if work.survey {
            return splats::survey(&self.device, &bin, facts);
        }
        let (into, layer) = match onto {
            Onto::Target => (self.target.pixels(), None),
            Onto::TargetBehindLayer => (self.target.pixels(), Some(self.layer.depths())),
            Onto::Layer => (self.layer.pixels(), None),
        };
        let job = splats::WindowJob { bin, blend_depth, layer };
        self.splatter.render(&mut self.bins, &self.device, &job, into, work.timeline, facts)
    }

    /// A window of ensembles.
    pub(super) fn dealt(
        &mut self,
        cloud: &mut DeviceCloud,
        frame: &Frame,
        work: &mut Work<'_>,
    ) -> Result<Outcome, Error> {
        let (shares, how) = (spbr::shares(cloud, frame)?, projecting(frame, cloud));
        let ensembles = frame.method.ensembles().unwrap_or(1);
        let drawn = self.drawn.map_or(ensembles, |few| few.max(1).min(ensembles));
        let (device, window, spread) = (&self.device, work.window, frame.spread());
        let streamed = stream::window_points(device, cloud, frame.memory_budget);
        let form = match Form::of(device, cloud, &how, self.wide_atomics) {
            // The color of the point that is replaced may not be there.
            Form::Single if !self.single_pass || streamed.is_some() => Form::Wide,
            form => form,
        };
        let facts = &mut *work.facts;
        (facts.ensembles, facts.form) = (drawn, Some(form));
        facts.slots = shares.iter().map(|s| spbr::slots_of(s, ensembles, drawn)).sum();
        facts.thin = spbr::thin(&shares);
        facts.listed = spbr::is_listed(&shares);
        facts.streamed = streamed;
        if !work.survey {
            cloud.set_view(&frame.camera, frame.size, window, &how);
        }
        let job = spbr::WindowJob {
            cloud,
            window,
            how: &how,
            shares: &shares,
            method: frame.method,
            drawn,
            seed: frame.seed,
            spread,
            perspective: matches!(frame.camera.projection, Projection::Perspective { .. }),
            form,
            streamed,
            most_epoch_bits: self.epoch_bits,
            concurrent: device.info().concurrent_runs,
            budget: work.budget,
            progress: &self.progress,
        };
        facts.renewed |= job.is_renewed();
        if !work.survey {
            let met = self.ensembles.render(device, &job, &self.target, work.timeline)?;
            facts.visible += met.visible;
            facts.uploaded_bytes += met.uploaded;
            self.progress.inc(bands::pixels(window));
        }
        facts.note(&[], Walker::Compute);
        Ok(Outcome::Done)
    }

    /// Copies a finished window to the host.
    fn read_back(&self, work: &mut Work<'_>) -> Result<Outcome, Error> {
        if !work.survey {
            let pixels = bands::pixels(work.window);
            let mut recorder = self.device.recorder()?;
            self.target.record_read_back(&mut recorder, pixels)?;
            work.timeline.add(recorder.submit("image/read-back")?);
            self.progress.inc(pixels);
        }
        Ok(Outcome::Done)
    }

    /// A window of solid and soft points: the solid ones into a layer, the soft ones before it.
    pub(super) fn soft(
        &mut self,
        cloud: &mut DeviceCloud,
        frame: &Frame,
        soft: Soft,
        work: &mut Work<'_>,
    ) -> Result<Outcome, Error> {
        let parts = cloud.parts(soft.threshold);
        // A window may turn out to be too large after its solid points were drawn; its halves draw them again.
        let mut facts = work.facts.clone();
        facts.solid_points = parts.solid;
        self.soft_counted = false;
        let Work { window, budget, survey, .. } = *work;
        // Solid points decide how much of a sphere there is to count: a survey of spheres draws them too.
        let surveyed = survey && (parts.soft == 0 || Interior::of(&frame.method).is_none());
        let mut solid = Work { window, budget, timeline: work.timeline, facts: &mut facts, survey: surveyed };
        if parts.solid > 0 && self.solid_layer(cloud, frame, soft.threshold, &mut solid)? == Outcome::Overflow {
            return Ok(Outcome::Overflow);
        }
        let mut both = Work { window, budget, timeline: work.timeline, facts: &mut facts, survey };
        let outcome = if parts.soft > 0 {
            self.soft_points(cloud, frame, soft, &mut both)?
        } else {
            self.only_solids(cloud.depth_origin(), &mut both)?
        };
        if outcome == Outcome::Done {
            *work.facts = facts;
        }
        Ok(outcome)
    }

    /// A window without soft points from its layer.
    fn only_solids(&mut self, origin: f32, work: &mut Work<'_>) -> Result<Outcome, Error> {
        if !work.survey {
            let mut recorder = self.device.recorder()?;
            abuffer::record_nothing(&mut recorder, &self.target, work.window)?;
            soft::record_compose(&mut recorder, &self.layer, &self.target, bands::pixels(work.window), origin)?;
            work.timeline.add(recorder.submit("solid points alone")?);
        }
        work.facts.note(&[], Walker::Compute);
        self.read_back(work)
    }

    /// The soft points of a window before its layer, and the window from both.
    fn soft_points(
        &mut self,
        cloud: &mut DeviceCloud,
        frame: &Frame,
        soft: Soft,
        work: &mut Work<'_>,
    ) -> Result<Outcome, Error> {
        let Some(interior) = Interior::of(&frame.method) else {
            return self.soft_discs(cloud, frame, soft, work);
        };
        let window = work.window;
        let parts = cloud.parts(soft.threshold);
        let model = SoftModel::new(&frame.method, &soft, parts.median_radius * frame.factors.radius);
        let most_radius = cloud.most_radius() * frame.factors.radius;
        let exact = model.is_stiff(interior, most_radius);
        let kind = Kind { interior, exact, modulated: soft.modulation.is_some() };
        let how = soft_projecting(frame, cloud, &soft, kind.footprint());
        let stats = self.project_as(cloud, frame, window, &how, work.timeline)?;
        let countable = stats.iter().all(|s| u32::try_from(s.tiles()).is_ok());
        let Some(mut budget) = work.budget.with_tiles(Tiles::bytes(&stats, window)).filter(|_| countable) else {
            return Ok(Outcome::Overflow);
        };
        if parts.solid > 0 {
            budget.tiles += self.bins.bytes();
        }
        self.tiles.reserve(&self.device, &stats, window)?;
        let walker = Walker::Compute;
        let raster =
            raster::Raster { cloud, stats: &stats, tiles: &self.tiles, walker, footprint: how.footprint, window };
        let solid = parts.solid > 0;
        let spheres =
            Spheres { kind, model, most_radius, origin: cloud.depth_origin(), layer: solid.then_some(&self.layer) };
        spheres.check(&frame.method, cloud.len())?;
        let stop = sorted::stop(frame.stop, frame.color, cloud.most_color(&how));
        let storing = Storing::Spheres(spheres);
        let lists =
            abuffer::WindowJob { raster, discs: Discs::default(), storing, stop, budget, progress: &self.progress };
        let outcome = if work.survey {
            self.abuffer.survey(&self.device, &lists, work.timeline, work.facts)?
        } else {
            self.abuffer.render(&self.device, &lists, &self.target, work.timeline, work.facts)?
        };
        self.soft_counted = true;
        work.facts.soft_visible += stats.iter().map(|s| u64::from(s.visible)).sum::<u64>();
        work.facts.soft_large += stats.iter().map(|s| u64::from(s.large)).sum::<u64>();
        work.facts.note(&stats, walker);
        Ok(outcome)
    }

    /// The same where soft points are discs in a presorted order.
    fn soft_discs(
        &mut self,
        cloud: &mut DeviceCloud,
        frame: &Frame,
        soft: Soft,
        work: &mut Work<'_>,
    ) -> Result<Outcome, Error> {
        let window = work.window;
        let how = soft_projecting(frame, cloud, &soft, Footprint::Disc);
        let stats = self.project_as(cloud, frame, window, &how, work.timeline)?;
        let parts = cloud.parts(soft.threshold);
        let (device, walker) = (&self.device, Walker::Compute);
        let raster =
            raster::Raster { cloud, stats: &stats, tiles: &self.tiles, walker, footprint: how.footprint, window };
        let order = Order::Along(Axis::nearest(frame.camera.forward));
        let counts = if frame.fragments { bands::pixels(window) * express::COUNT_BYTES } else { 0 };
        // Solid points are sorted, and what that took is still there.
        let counted_bytes = counts + if parts.solid > 0 { bin::sort_bytes(device, cloud.len()) } else { 0 };
        let bin = bin::Job { raster, order, depth_range: depth_range(frame), budget: work.budget, counted_bytes };
        let outcome = if work.survey {
            Bins::survey(device, &bin, work.facts)?
        } else {
            let job = express::WindowJob {
                bin,
                model: SoftModel::new(&frame.method, &soft, parts.median_radius * frame.factors.radius),
                modulated: soft.modulation.is_some(),
                layer: (parts.solid > 0).then_some(&self.layer),
                counted: frame.fragments,
                color: frame.color,
                most_color: cloud.most_color(&how),
                stop: frame.stop,
            };
            self.discs.render(&mut self.bins, device, &job, &self.target, work.timeline, work.facts)?
        };
        if outcome == Outcome::Done {
            self.soft_counted = true;
            work.facts.soft_visible += stats.iter().map(|s| u64::from(s.visible)).sum::<u64>();
            self.progress.inc(bands::pixels(window));
            work.facts.note(&stats, walker);
        }
        Ok(outcome)
    }
}

/// Splats that are drawn in three passes.
struct Drawing<'a> {
    cloud: &'a DeviceCloud,
    stats: &'a [Stats],
    footprint: Footprint,
    blend_depth: f32,
    onto: Onto,
}

/// What three-pass splats are drawn into.
#[derive(Clone, Copy)]
enum Onto {
    Target,
    /// The target; only what is solid or lies behind the layer.
    TargetBehindLayer,
    Layer,
}

/// Device bytes per pixel of a window that three-pass splats take, with those of a layer; 0 if the method has none.
pub(super) fn splatting_bytes(method: &Method) -> u64 {
    match method {
        Method::Hqs(_) | Method::Splats(_) => splats::PIXEL_BYTES,
        Method::OneLayer(_) => splats::PIXEL_BYTES + soft::LAYER_BYTES,
        method if method.soft().is_some() => splats::PIXEL_BYTES + soft::LAYER_BYTES,
        _ => 0,
    }
}

/// How the splats of a part of the points are made that are drawn in three passes: as those of `splats`, with its defaults.
fn solid_projecting(frame: &Frame, cloud: &DeviceCloud, part: Part) -> Projecting {
    projecting_of(frame, cloud, Footprint::Oriented, ScreenSplats::default(), part)
}

/// How the soft points become splats.
fn soft_projecting(frame: &Frame, cloud: &DeviceCloud, soft: &Soft, footprint: Footprint) -> Projecting {
    let part = Part::Soft { threshold: soft.threshold, modulation: soft.modulation };
    Projecting { footprint, part, ..projecting(frame, cloud) }
}
