//! The plan of a frame: the passes that run, and the fact that decides each. Engines add their own; shared parts are
//! here.

use super::bytes::PassRuns;
use super::{Facts, Frame, edl, shadows};
use crate::gpu::Device;
use crate::passes::bin::{self, Order};
use crate::passes::radix::Digits;
use crate::passes::scan::Scan;
use crate::scene::ShadingModel;

/// The statistics and the prose of an engine's passes.
pub(crate) trait Explain {
    /// Bytes that a pass must at least read and write, from the counts of the frame; cached re-reads are not counted.
    /// `None` where that is not known.
    fn least_bytes(&self, _pass: &PassRuns<'_>) -> Option<u64> {
        None
    }

    /// Adds the passes of the frame to its plan, in the order of their first run, and those of its own that it leaves
    /// out.
    fn explain(&self, plan: &mut FramePlan<'_>);
}

/// A pass of the frame plan.
#[derive(Debug, Clone, PartialEq, Eq, serde::Serialize)]
pub struct Step {
    /// Method and stage, as in profiles.
    pub name: &'static str,
    /// `true` if the frame runs it.
    pub on: bool,
    /// The fact about the scene or the device that decided it.
    pub reason: String,
}

/// Passes that belong together, and why frames without them leave them out.
#[derive(Debug, Clone)]
pub(crate) struct PassGroup {
    /// Names of the passes, in the order of their first run.
    pub names: Vec<&'static str>,
    /// The reason why they don't run, unless an engine gives a more precise one.
    pub absent: Absent,
}

/// Reason why a group of passes doesn't run.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Absent {
    /// A reason for every frame.
    Always(&'static str),
    /// A reason of the current method, which doesn't need them.
    Method(&'static str),
    /// A reason of the current method, if it has discs; methods without discs have no transparency at all.
    Discs(&'static str),
}

impl PassGroup {
    /// Returns a group.
    pub fn new(names: &[&'static str], absent: Absent) -> Self {
        Self { names: names.to_vec(), absent }
    }
}

/// Reason why a pass over splats is off.
pub(crate) const NOTHING: &str = "no splat touches the image";

/// Reason why points that are in order have no keys.
const PRESORTED_KEYS: &str = "points are already sorted along each axis";

/// Reason why splats go through tiles where any order would do.
pub(crate) const EACH_PIXEL: &str = "tiles give each pixel to one subgroup";

/// Counters and pixels that most methods clear, and the results of the projection.
pub(crate) const COUNTERS: [&str; 2] = ["project/clear", "project/stats"];
/// The passes that sort splats, four of them, and put them into tiles.
pub(crate) const ORDER: [&str; 10] = [
    "bin/keys",
    "radix/clear",
    "radix/count",
    "radix/scatter",
    "bin/clear",
    "bin/tile-count",
    "bin/measure",
    "bin/summary",
    "bin/tile-store",
    "bin/pairs",
];
/// The passes that go through an order of points that was made beforehand.
pub(crate) const PRESORTED: [&str; 2] = ["bin/pick", "bin/place"];
/// The pass that empties pixels.
pub(crate) const CLEAR: [&str; 1] = ["image/clear"];
/// The passes of prefix sums.
pub(crate) const SCAN: [&str; 2] = ["scan/reduce", "scan/spread"];

/// The plan of a frame that an engine explains.
pub(crate) struct FramePlan<'a> {
    /// The device.
    pub device: &'a Device,
    /// The frame.
    pub frame: &'a Frame,
    /// The actual or expected counts.
    pub facts: &'a Facts,
    /// `true` if 64-bit atomics are used.
    pub wide_atomics: bool,
    /// Reason for this method.
    pub why: &'a str,
    /// The passes so far.
    pub steps: Vec<Step>,
}

impl FramePlan<'_> {
    /// Adds a pass.
    pub fn add(&mut self, name: &'static str, on: bool, reason: impl Into<String>) {
        self.steps.push(Step { name, on, reason: reason.into() });
    }

    /// Lists these passes as off, unless they are listed already.
    pub fn rest(&mut self, names: &[&'static str], reason: &str) {
        for name in names {
            if self.steps.iter().all(|step| step.name != *name) {
                self.add(name, false, reason);
            }
        }
    }

    /// Lists the passes of a group as off, unless they are listed already.
    pub fn rest_of(&mut self, group: &PassGroup) {
        let reason = match group.absent {
            Absent::Always(reason) => reason.to_owned(),
            Absent::Discs(_) if self.frame.method.discs().is_none() => format!("no transparency: {}", self.why),
            Absent::Discs(reason) | Absent::Method(reason) => format!("{reason}: {}", self.why),
        };
        self.rest(&group.names, &reason);
    }

    /// Returns `true` if any splat touches the image.
    pub fn seen(&self) -> bool {
        self.facts.visible > 0
    }

    /// Returns a reason where splats touch the image.
    pub fn if_seen(&self, reason: impl Into<String>) -> String {
        if self.seen() { reason.into() } else { NOTHING.to_owned() }
    }

    /// Returns the shading of points, in words.
    pub fn shading(&self) -> &'static str {
        match self.frame.shading.model {
            ShadingModel::None => "no shading requested (shading.model = \"none\")",
            ShadingModel::Auto => "Lambert shading for points with normals, stored or estimated",
            ShadingModel::Lambert => "Lambert shading for points with normals",
            ShadingModel::Phong => "Phong shading for points with normals",
        }
    }

    /// Returns the number of pixels of the image.
    pub fn pixels(&self) -> u64 {
        u64::from(self.frame.size[0]) * u64::from(self.frame.size[1])
    }

    /// The light of each point, which later frames don't find again.
    pub fn shadows(&mut self) {
        let views = self.facts.light_views;
        let refusal = shadows::refusal(self.frame);
        let stored = "the cloud already holds the light of each point";
        let shadows = self.frame.shadows.unwrap_or_default();
        let samples = if shadows.light_radius == 0.0 { 1 } else { shadows.samples };
        let images = format!("{samples} light(s), {views} image(s) of {0} × {0} pixels", self.facts.light_resolution);
        let (fill, occlusion) = (shadows.fill.most(), shadows.occlusion.most());
        let points = self.facts.points;
        for (name, reason) in shadows::PASSES.into_iter().zip([
            format!("{points} points start as lit by every light; later frames reuse the result"),
            format!("{images} start empty"),
            format!("{images} receive the nearest depths"),
            "no block has a surface and no hole is counted yet".to_owned(),
            "finds where the first light's image has surfaces, to tell the holes in them".to_owned(),
            match fill {
                0 => "the filter is switched off".to_owned(),
                _ => format!("{fill} iteration(s) fill background between points"),
            },
            match (fill, occlusion) {
                (0, 0) => "the filter is switched off: depths stay as they are".to_owned(),
                (_, 0) => "the filter is switched off".to_owned(),
                _ => format!("{occlusion} iteration(s) close holes in surfaces, so that no light falls through"),
            },
            "counts the holes that are left in the first light's image".to_owned(),
            format!("compares {points} points with the nearest depths of each light"),
            format!("turns the number of lights that reach a point into a share of {samples}"),
        ]) {
            let reason = match &refusal {
                Some(refusal) => refusal.clone(),
                None if views == 0 => stored.to_owned(),
                None if name == "shadows/share" && samples == 1 => {
                    "a point gets all or nothing of a single light, so there is no share to find".to_owned()
                }
                None => reason,
            };
            let is_asked = match name {
                "shadows/share" => samples > 1,
                "shadows/fill" => fill > 0,
                "shadows/occlusion" => occlusion > 0 || fill == 0,
                _ => true,
            };
            let on = refusal.is_none() && views > 0 && is_asked;
            self.add(name, on, reason);
        }
    }

    /// Eye-dome lighting, which comes last.
    pub fn eye_dome(&mut self) {
        let pixels = self.pixels();
        let on = self.frame.shading.edl.edl;
        for (name, reason) in edl::PASSES.into_iter().zip([
            format!("gathers {pixels} depths, as no window holds those of the whole image"),
            format!("shades {pixels} pixels, each by the depths of 8 pixels around it"),
            format!("copies {pixels} factors to the host, which multiplies colors by them"),
        ]) {
            let reason = if on { reason } else { "no eye-dome lighting requested (shading.edl)".to_owned() };
            self.add(name, on, reason);
        }
    }

    /// Empty counters.
    pub fn cleared(&mut self) {
        self.add("project/clear", true, "counters start at zero, and pixels of the opaque methods start empty");
    }

    /// Explains the projection of points to splats, and its results.
    pub fn projected(&mut self) {
        self.cleared();
        let gaussians = if self.frame.method.discs().is_some() { self.facts.gaussians } else { 0 };
        let points = self.facts.points.saturating_sub(gaussians);
        self.add("project/splats", points > 0, format!("{points} points; {}", self.shading()));
        self.add("project/gaussians", gaussians > 0, format!("{gaussians} Gaussians, each projected to an ellipse"));
        self.found();
    }

    /// Points that become pixels, without splats.
    pub fn not_projected(&mut self) {
        let reason = "a point is one pixel or a square, so there are no splats to project";
        self.add("project/splats", false, reason);
        self.add("project/gaussians", false, reason);
    }

    /// Explains the results of the projection.
    pub fn found(&mut self) {
        let met = format!("{} splats touch the image, {} of them large", self.facts.visible, self.facts.large);
        self.add("project/stats", true, met);
    }

    /// Returns how many counters are summed for `large` large splats: the tiles of each, unless the rasterizer visits
    /// the pixels.
    pub fn pairs(&self, large: u64) -> u64 {
        if self.facts.raster == "compute" { large } else { 0 }
    }

    /// Explains the prefix sums of `elements` elements; none for 0.
    pub fn scan(&mut self, elements: u64, counted: &str) {
        let run = Scan::run(self.device);
        let levels = if elements > run { "more" } else { "no more" };
        self.add(
            "scan/reduce",
            elements > run,
            format!("{counted}: {elements} elements, {levels} than one run takes ({run})"),
        );
        self.add("scan/spread", elements > 0, format!("{counted}: {elements} elements"));
    }

    /// Returns the sort of splats and their tiles; returns how many counters are summed.
    pub fn order(&mut self, order: Order, why: &str) -> u64 {
        let (points, visible) = (self.facts.points, self.facts.visible);
        let bits = bin::key_bits(order, self.frame.key_range(), points);
        let Digits { digits, bits: digit, counters } = Digits::new(self.device, points, bits);
        let by = match order {
            Order::Depth => "in order of depth",
            Order::Index => "in canonical order",
            Order::File | Order::Arrival => "in the order of the files",
            Order::Along(_) => "along an axis",
        };
        self.add("bin/keys", true, format!("{why}: {visible} splats {by}"));
        self.digits(format!("keys have {bits} bits, sorted as {digits} digit(s) of {digit} bits"));
        self.bins(by);
        counters.max(self.facts.tile_cells)
    }

    /// A sort by digits.
    fn digits(&mut self, reason: String) {
        let shared = self.device.info().prefers.shared_work;
        let cleared = if shared { "workgroups write each counter" } else { "counters start at zero" };
        self.add("radix/clear", !shared, cleared);
        self.add("radix/count", true, reason.clone());
        self.add("radix/scatter", true, reason);
    }

    /// Splats that are in order into their tiles.
    pub fn bins(&mut self, by: &str) {
        let pairs = self.device.info().prefers.tile_pairs;
        let of = if pairs { "tile and one for each splat" } else { "tile and run of splats" };
        let cells = format!("splats are read {by}; {} counters, one for each {of}", self.facts.tile_cells);
        let longest = "the longest list of a tile decides how often tiles are dispatched";
        let total = "the total length of the lists decides whether the window fits in memory";
        let [store, sort] = if pairs {
            ["pairs of tile and splat are sorted instead", "the sort of pairs by tile gives the lists of the tiles"]
        } else {
            ["stores the splats of each tile in order", "each subgroup stores a run of splats instead"]
        };
        self.add("bin/clear", true, "counters start at zero");
        self.add("bin/tile-count", true, cells);
        self.add("bin/measure", true, longest);
        self.add("bin/summary", true, total);
        self.add("bin/tile-store", !pairs, store);
        self.add("bin/pairs", pairs, sort);
    }

    /// Splats in an order that was made beforehand into their tiles.
    pub fn presorted_bins(&mut self, by: &str) {
        if self.device.info().prefers.tile_pairs {
            self.rest(&ORDER[..1], PRESORTED_KEYS);
            self.digits("pairs of tile and splat are sorted by tile".to_owned());
        } else {
            self.rest(&ORDER[..4], PRESORTED_KEYS);
        }
        self.bins(by);
    }

    /// Windows without splats, of an engine that counts those with some as bands.
    pub fn emptied(&mut self) {
        let empty = self.facts.windows.saturating_sub(self.facts.bands);
        self.add("image/clear", empty > 0, format!("{empty} window(s) show nothing"));
    }

    /// The passes that find the nearest of each pixel, with and without 64-bit atomics: `[wide, narrow, narrow]`.
    pub fn nearest(&mut self, [both, depth, id]: [&'static str; 3], on: bool, reason: &str) {
        let wide = self.wide_atomics;
        let has = if self.device.info().int64_atomics { "the device has" } else { "the device has no" };
        for (name, needed) in [(both, wide), (depth, !wide), (id, !wide)] {
            let atomics = format!("{has} 64-bit atomics");
            let reason = match (on, needed) {
                (false, _) => reason.to_owned(),
                (true, true) => format!("{reason}; {atomics}"),
                (true, false) => atomics,
            };
            self.add(name, on && needed, reason);
        }
    }
}
