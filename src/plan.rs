//! Facts of a scene to passes on or off, each with its reason; and the method that `auto` stands for.

use crate::gpu::Device;
use crate::methods::abuffer::{CLASSES, LOCAL_LENGTH, lower_bound};
use crate::methods::renderer::depth_range;
use crate::methods::{Facts, Frame, sorted};
use crate::passes::radix::Digits;
use crate::passes::tiles;
use crate::points::Points;
use crate::scene::{Discs, Method, ScreenSplats, ShadingModel};

/// One pass of the frame plan.
#[derive(Debug, Clone, PartialEq, Eq, serde::Serialize)]
pub struct Step {
    /// Method and stage, as in profiles.
    pub name: &'static str,
    /// Whether the frame runs it.
    pub on: bool,
    /// The fact about the scene or the device that decided it.
    pub reason: String,
}

/// The method in force for some points: `auto` replaced by the cheapest exact one.
///
/// Opaque splats need no transparency: the nearest decides. Everything else needs an order of fragments.
pub fn resolve(method: Method, points: &Points) -> (Method, String) {
    if method != Method::Auto {
        return (method, format!("{} was asked for", method.name()));
    }
    match points.opacities.iter().filter(|a| **a < 1.0).count() {
        0 => {
            // Without the clamp of opaque splats, so that the image is the one that `abuffer` would give.
            let splats = ScreenSplats { max_pixel_radius: f32::MAX, ..Default::default() };
            (Method::Circles(splats), "every point is opaque: the nearest splat decides".to_owned())
        }
        n => (Method::ABuffer(Discs::default()), format!("{n} of {} points are transparent", points.len())),
    }
}

/// The passes of a frame whose facts were surveyed (see [`crate::methods::Renderer::survey`]), in the order of their first run.
/// `why` is the reason for the method, from [`resolve`].
pub fn plan(device: &Device, frame: &Frame, facts: &Facts, wide_atomics: bool, why: &str) -> Vec<Step> {
    let mut plan = Plan { steps: Vec::new() };
    let seen = facts.visible > 0;
    let shading = match frame.shading.model {
        ShadingModel::None => "no shading asked for",
        ShadingModel::Lambert => "Lambert shading where there are normals",
        ShadingModel::Phong => "Phong shading where there are normals",
    };
    plan.add("splat/clear", true, "counters, and pixels of the opaque methods, start empty");
    plan.add("splat/project", facts.points > 0, format!("{} points; {shading}", facts.points));
    plan.add("splat/stats", true, format!("{} splats touch the image, {} of them large", facts.visible, facts.large));
    let off = |plan: &mut Plan, names: &[&'static str], reason: &str| {
        for name in names {
            plan.add(name, false, format!("{reason}: {why}"));
        }
    };
    match frame.method {
        Method::ABuffer(_) => {
            plan.abuffer(frame, facts, seen, why);
            off(&mut plan, &SORTED, "fragments are sorted, not splats");
            off(&mut plan, &OPAQUE, "no opaque method");
        }
        Method::Sorted(_) => {
            plan.sorted(device, frame, facts, seen, why);
            off(&mut plan, &OPAQUE, "no opaque method");
        }
        Method::Auto | Method::Points | Method::Squares(_) | Method::Circles(_) => {
            plan.opaque(device, frame, facts, wide_atomics, seen, why);
            off(&mut plan, &COUNT, "no transparency");
            off(&mut plan, &["image/clear"], "no transparency");
            off(&mut plan, &blending_passes(), "no transparency");
            off(&mut plan, &SORTED, "no transparency");
        }
    }
    plan.add(
        "image/read-back",
        true,
        format!("{} × {} pixels in {} window(s)", frame.size[0], frame.size[1], facts.windows),
    );
    plan.steps
}

/// The passes that find the lengths of lists.
const COUNT: [&str; 5] = ["abuffer/clear", "abuffer/count", "abuffer/measure", "abuffer/cursors", "abuffer/summary"];
/// The passes of opaque methods.
const OPAQUE: [&str; 4] = ["splat/nearest", "splat/nearest-depth", "splat/nearest-id", "splat/resolve"];
/// The passes of splats that are sorted.
const SORTED: [&str; 11] = [
    "sorted/keys",
    "radix/clear",
    "radix/count",
    "radix/scatter",
    "sorted/gather",
    "sorted/clear",
    "sorted/tile-count",
    "sorted/measure",
    "sorted/summary",
    "sorted/tile-store",
    "sorted/blend",
];
/// The passes that sort pixels by the length of their lists.
const BY_LENGTH: [&str; 3] = ["abuffer/classify", "abuffer/groups", "abuffer/order"];
/// The passes of lists that are too long for one invocation.
const LONG: [&str; 6] = [
    "abuffer/split",
    "abuffer/run-groups",
    "abuffer/sort-runs",
    "abuffer/merge",
    "abuffer/blend-runs",
    "abuffer/combine",
];

/// The passes of the A-buffer once lengths are known.
fn blending_passes() -> Vec<&'static str> {
    ["abuffer/store"].into_iter().chain(BY_LENGTH).chain(CLASSES.map(|(_, name)| name)).chain(LONG).collect()
}

const NOTHING: &str = "no splat touches the image";

/// Elements that a prefix sum takes in one run, without a level of sums above.
const SCAN_RUN: u64 = 64;

/// Pixels of the image.
fn pixels(frame: &Frame) -> u64 {
    u64::from(frame.size[0]) * u64::from(frame.size[1])
}

struct Plan {
    steps: Vec<Step>,
}

impl Plan {
    fn add(&mut self, name: &'static str, on: bool, reason: impl Into<String>) {
        self.steps.push(Step { name, on, reason: reason.into() });
    }

    fn abuffer(&mut self, frame: &Frame, facts: &Facts, seen: bool, why: &str) {
        let pick = |reason: String| if seen { reason } else { NOTHING.to_owned() };
        self.count(frame, facts, seen, why, 0, "fragment counts");
        self.add("image/clear", true, "pixels without fragments stay empty");
        let any = facts.fragments > 0;
        self.add("abuffer/store", any, pick(format!("{} fragments in {} band(s)", facts.fragments, facts.bands)));
        for name in BY_LENGTH {
            self.add(name, any, pick("lists of each length get their own kernel".to_owned()));
        }
        self.kernels(facts.max_list);
    }

    /// The lengths of lists, with prefix sums `of` them and of so many `others`.
    fn count(&mut self, frame: &Frame, facts: &Facts, seen: bool, why: &str, others: u64, of: &str) {
        let counted = if seen { format!("{why}; by {}", facts.raster) } else { NOTHING.to_owned() };
        self.add("abuffer/clear", true, "counters start at zero");
        self.add("abuffer/count", seen, counted);
        self.add("abuffer/measure", true, format!("the longest list has {} fragments", facts.max_list));
        // One element more than pixels: the last prefix sum is the total.
        let counts = pixels(frame).div_ceil(facts.windows.max(1)) + 1;
        let tiled = self.tiles(frame, facts, true);
        self.scan(counts.max(tiled).max(others), of);
        self.add("abuffer/cursors", true, "the next free slot of each list is its first");
        self.add("abuffer/summary", true, "the host reads the fragments' total");
    }

    /// The sort of splats, and what counts lists beside it where their lengths are asked for.
    fn sorted(&mut self, device: &Device, frame: &Frame, facts: &Facts, seen: bool, why: &str) {
        let bits = sorted::key_bits(depth_range(frame));
        let Digits { digits, bits: digit, counters } = Digits::new(device, facts.points, bits);
        let sums = if seen { counters.max(facts.tile_cells) } else { 0 };
        if frame.fragments {
            self.count(
                frame,
                facts,
                seen,
                "lengths of lists are asked for",
                sums,
                "counters of lists, digits and tiles",
            );
        } else {
            for name in COUNT {
                self.add(name, false, "lengths of lists are not asked for, and the method needs none");
            }
            self.tiles(frame, facts, false);
            self.scan(sums, "counters of digits and tiles");
        }
        for name in blending_passes() {
            self.add(name, false, format!("splats are sorted, not fragments: {why}"));
        }
        let pick = |reason: String| if seen { reason } else { NOTHING.to_owned() };
        let sort = format!("{why}: {} splats by depth", facts.visible);
        let by_digit = format!("depths have {bits} bits: {digits} digit(s) of {digit}");
        let reasons = [
            sort,
            "counters start at zero".to_owned(),
            by_digit.clone(),
            by_digit,
            "blending reads splats in order of depth".to_owned(),
            "counters start at zero".to_owned(),
            format!("{} counters of tiles and runs of splats", facts.tile_cells),
            "the longest list of a tile decides how often tiles are blended".to_owned(),
            "the total of the lists decides whether the window fits".to_owned(),
            "each tile gets its splats in order".to_owned(),
            format!("{} window(s) with splats", facts.bands),
        ];
        for (name, reason) in SORTED.into_iter().zip(reasons) {
            self.add(name, seen, pick(reason));
        }
        let empty = facts.windows.saturating_sub(facts.bands);
        self.add("image/clear", empty > 0, format!("{empty} window(s) show nothing"));
    }

    /// The lists of large splats by tile, if pixels are `visited`; returns the longest prefix sum that they need.
    fn tiles(&mut self, frame: &Frame, facts: &Facts, visited: bool) -> u64 {
        let on = visited && facts.large > 0 && facts.raster == "compute";
        let reason = if !visited {
            "no stage visits pixels splat by splat".to_owned()
        } else if facts.raster == "compute" {
            format!("{} splats are large enough for tiles", facts.large)
        } else {
            "the rasteriser visits the pixels".to_owned()
        };
        for name in ["splat/tile-count", "splat/tile-cursors", "splat/tile-store"] {
            self.add(name, on, reason.clone());
        }
        let rows = frame.size[1].div_ceil(facts.windows.max(1) as u32);
        let [columns, rows] = tiles::grid([0, 0, frame.size[0], rows]);
        if on { facts.large.max(u64::from(columns) * u64::from(rows) + 1) } else { 0 }
    }

    /// Prefix sums of so many elements, none for no element.
    fn scan(&mut self, elements: u64, of: &str) {
        let levels = if elements > SCAN_RUN { "more" } else { "no more" };
        self.add(
            "scan/reduce",
            elements > SCAN_RUN,
            format!("{of}: {elements} elements, {levels} than the {SCAN_RUN} of a run"),
        );
        self.add("scan/spread", elements > 0, format!("{of}: {elements} elements"));
    }

    /// The kernels of the lengths that there are.
    fn kernels(&mut self, longest: u32) {
        for (class, (most, name)) in CLASSES.into_iter().enumerate() {
            let least = lower_bound(class) + 1;
            let on = longest >= least;
            let lengths = if least == most { most.to_string() } else { format!("{least} to {most}") };
            let reason = if on {
                format!("lists of length {lengths} (longest: {longest})")
            } else {
                format!("no list has length {least} or more (longest: {longest})")
            };
            self.add(name, on, reason);
        }
        let long = longest > LOCAL_LENGTH;
        let reason = if long {
            format!("the longest list has {longest} fragments, more than {LOCAL_LENGTH}")
        } else {
            format!("no list is longer than {LOCAL_LENGTH} (longest: {longest})")
        };
        for name in LONG {
            self.add(name, long, reason.clone());
        }
    }

    fn opaque(&mut self, device: &Device, frame: &Frame, facts: &Facts, wide: bool, seen: bool, why: &str) {
        let tiled = self.tiles(frame, facts, true);
        self.scan(tiled, "tiles of large splats");
        let has = if device.info().int64_atomics { "the device has" } else { "the device has no" };
        let reason = |used: bool| match (seen, used) {
            (false, _) => NOTHING.to_owned(),
            (true, true) => format!("{why}; {has} 64-bit atomics"),
            (true, false) => format!("{has} 64-bit atomics"),
        };
        self.add("splat/nearest", seen && wide, reason(wide));
        self.add("splat/nearest-depth", seen && !wide, reason(!wide));
        self.add("splat/nearest-id", seen && !wide, reason(!wide));
        self.add("splat/resolve", true, "index of the nearest splat to color");
    }
}
