//! Facts of a scene to passes on or off, each with its reason; and the method that `auto` stands for.

mod filtered;

use crate::gpu::Device;
use crate::methods::abuffer::{CLASSES, LOCAL_LENGTH, lower_bound};
use crate::methods::renderer::depth_range;
use crate::methods::spbr::Form;
use crate::methods::splats::PASSES as SPLATTED;
use crate::methods::{Facts, Frame, Renderer, cost, shadows, soft, stochastic};
use crate::passes::bin::{self, Order};
use crate::passes::project::DeviceCloud;
use crate::passes::radix::Digits;
use crate::passes::tiles;
use crate::points::Points;
use crate::prepare::axes::Axis;
use crate::random::STRATUM;
use crate::scene::{
    DiscShape, Discs, Falloff, LongLists, Method, MethodChoice, Raster, ScreenSplats, ShadingModel, Stochastic,
};

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

/// The method in force for some points: `auto` is replaced by one that is exact for them.
///
/// Opaque splats need no transparency: the nearest decides. Flat splats need only an order of splats, and where that is
/// not asked of another method [`choose`] says which of two is cheaper. Splats that may cross need an order of fragments.
pub fn resolve(choice: MethodChoice, points: &Points) -> (Method, String) {
    let discs = match choice {
        MethodChoice::Auto(discs) => discs,
        MethodChoice::Fixed(method) => return (method, format!("{} was asked for", method.name())),
    };
    let transparent = points.opacities.iter().filter(|a| **a < 1.0).count();
    let oriented = discs.shape == DiscShape::Oriented && points.normals.is_some();
    if oriented {
        (Method::ABuffer(discs), "oriented splats may cross: their fragments need an order".to_owned())
    } else if transparent == 0 && discs.falloff == Falloff::Flat {
        // Without the clamp of opaque splats, so that the image is the one that `abuffer` would give.
        let splats = ScreenSplats { max_pixel_radius: f32::MAX, ..Default::default() };
        (Method::Circles(splats), "every point is opaque: the nearest splat decides".to_owned())
    } else {
        let why = match discs.falloff {
            Falloff::Flat => format!("{transparent} of {} points are transparent", points.len()),
            Falloff::Gaussian => "a Gaussian falloff makes every splat transparent".to_owned(),
        };
        let method = if discs.raster == Raster::Hardware { Method::ABuffer(discs) } else { Method::Sorted(discs) };
        (method, format!("{why}, and all are flat"))
    }
}

/// The method in force on a device: as [`resolve`], but for flat splats the cheaper of `sorted` and `abuffer`, by a model of
/// what frames cost here (see [`crate::methods::cost`]). The frame may be of any method.
pub fn choose(
    renderer: &mut Renderer,
    cloud: &mut DeviceCloud,
    points: &Points,
    choice: MethodChoice,
    frame: &Frame,
) -> Result<(Method, String), crate::methods::Error> {
    match (choice, resolve(choice, points)) {
        (MethodChoice::Auto(_), (Method::Sorted(discs), why)) => cost::choose(renderer, cloud, frame, discs, &why),
        (_, resolved) => Ok(resolved),
    }
}

/// The passes of a frame whose facts were surveyed (see [`crate::methods::Renderer::survey`]), in the order of their first run.
/// `why` is the reason for the method, from [`choose`].
pub fn plan(device: &Device, frame: &Frame, facts: &Facts, wide_atomics: bool, why: &str) -> Vec<Step> {
    let mut plan = Plan { steps: Vec::new() };
    let seen = facts.visible > 0;
    let shading = match frame.shading.model {
        ShadingModel::None => "no shading asked for",
        ShadingModel::Lambert => "Lambert shading where there are normals",
        ShadingModel::Phong => "Phong shading where there are normals",
    };
    plan.shadows(frame, facts);
    if frame.method.is_dealt() {
        plan.dealt(device, frame, facts, why);
    } else {
        plan.add("splat/clear", true, "counters, and pixels of the opaque methods, start empty");
    }
    let filters = frame.method.filters();
    let direct = matches!(frame.method, Method::Points) || filters.is_some();
    let project = if direct || frame.method.is_dealt() {
        "a point is one pixel or a square: no splats".to_owned()
    } else {
        format!("{} points; {shading}", facts.points)
    };
    plan.add("splat/project", facts.points > 0 && !direct && !frame.method.is_dealt(), project);
    if let Some(filters) = filters {
        plan.filtered_points(device, frame, facts, wide_atomics, filters, why);
    } else if direct {
        plan.nearest(device, POINTS, facts.points > 0, wide_atomics, why);
    }
    if !frame.method.is_dealt() {
        let met = format!("{} splats touch the image, {} of them large", facts.visible, facts.large);
        plan.add("splat/stats", true, met);
    }
    match frame.method {
        Method::ABuffer(discs) | Method::LinkedList(discs) => plan.lists(device, frame, &discs, facts, seen, why),
        Method::Sorted(_) => plan.tiled("sorted/blend", device, frame, facts, why),
        Method::Peel(peel) => plan.peel(device, frame, facts, wide_atomics, peel.layers, why),
        Method::Stochastic(settings) => plan.stochastic(device, frame, facts, &settings, seen, why),
        Method::Hybrid(_) => plan.tiled("hybrid/accumulate", device, frame, facts, why),
        Method::Weighted(_) => plan.tiled("weighted/accumulate", device, frame, facts, why),
        Method::Average(_) => plan.tiled("average/accumulate", device, frame, facts, why),
        Method::Unsorted(_) => plan.tiled("unsorted/accumulate", device, frame, facts, why),
        Method::Points => {
            plan.add("points/resolve", true, format!("index of the nearest point to color; {shading}"));
        }
        Method::Hqs(_) | Method::Splats(_) | Method::OneLayer(_) => plan.splatted(device, frame, facts, why),
        Method::Spbr(_) | Method::SpbrSimplified(_) => {}
        Method::ImageSpace(filters) => plan.filters(frame, facts, &filters, None, shading),
        Method::PeelLayers(peel) => plan.filters(frame, facts, &peel.filters, Some(peel.layers), shading),
        Method::SoftBase(soft) | Method::SoftConcentric(soft) => {
            plan.soft_spheres(device, frame, facts, soft.threshold, why);
        }
        Method::SoftExpress(soft) => plan.soft_discs(device, frame, facts, soft.threshold, why),
        Method::Squares(_) | Method::Circles(_) | Method::Paraboloid(_) | Method::Cone(_) | Method::Sphere(_) => {
            plan.splats(device, frame, facts, wide_atomics, seen, why);
        }
    }
    plan.rest(&["splat/clear", "splat/stats"], "ensembles have counters of their own");
    plan.rest(&SPBR, &format!("no ensembles: {why}"));
    let without = |what: &str| match frame.method.discs() {
        Some(_) => format!("{what}: {why}"),
        None => format!("no transparency: {why}"),
    };
    plan.rest(&ORDER, &without("splats are not sorted"));
    plan.rest(&PRESORTED, "no order of the points was made beforehand");
    plan.rest(&STOCHASTIC, &without("no samples"));
    plan.rest(&DRAWN, &without("no samples"));
    plan.rest(&["soft/express"], &format!("no soft discs: {why}"));
    plan.rest(&TILED, &without("tiles of splats are gone through otherwise, or not at all"));
    plan.rest(&soft_passes(), &format!("no soft spheres: {why}"));
    plan.rest(&COUNT, &without("no lists"));
    plan.rest(&list_passes(), &without("no lists"));
    plan.rest(&PEEL, &without("no peeling"));
    plan.rest(&SPLATTED, &format!("no splats are blended in three passes: {why}"));
    plan.rest(&["one-layer/compose"], "no layer of soft points");
    plan.rest(&["image/clear"], &without("every pixel is written"));
    plan.rest(&["splat/tile-count", "splat/tile-cursors", "splat/tile-store"], "no stage visits pixels splat by splat");
    plan.rest(&["scan/reduce", "scan/spread"], "nothing is counted");
    plan.rest(&filtered::PASSES, &format!("no filters of the image: {why}"));
    plan.rest(&filtered::LAYERS, &format!("no layers of point surfaces: {why}"));
    plan.rest(&SPLATS, &format!("no opaque splats: {why}"));
    plan.rest(&["splat/resolve"], &format!("no opaque splats: {why}"));
    plan.rest(&POINTS, &format!("no 1-pixel points: {why}"));
    plan.rest(&["points/resolve"], &format!("no 1-pixel points: {why}"));
    plan.add(
        "image/read-back",
        true,
        format!("{} × {} pixels in {} window(s)", frame.size[0], frame.size[1], facts.windows),
    );
    plan.steps
}

/// The passes of stochastic point-based rendering.
const SPBR: [&str; 11] = [
    "spbr/clear",
    "spbr/upload",
    "spbr/draw",
    "spbr/nearest",
    "spbr/nearest-depth",
    "spbr/nearest-id",
    "spbr/renew",
    "spbr/large",
    "spbr/sum",
    "spbr/resolve",
    "spbr/summary",
];

/// Why a pass over splats is off.
const NOTHING: &str = "no splat touches the image";

/// Why splats go through tiles where any order would do.
const EACH_PIXEL: &str = "tiles give each pixel to one subgroup";

/// The passes that find the lengths of lists.
const COUNT: [&str; 5] = ["abuffer/clear", "abuffer/count", "abuffer/measure", "abuffer/cursors", "abuffer/summary"];
/// The passes that sort splats, four of them, and put them into tiles.
const ORDER: [&str; 10] = [
    "bin/keys",
    "radix/clear",
    "radix/count",
    "radix/scatter",
    "bin/gather",
    "bin/clear",
    "bin/tile-count",
    "bin/measure",
    "bin/summary",
    "bin/tile-store",
];
/// The passes that go through an order of points that was made beforehand.
const PRESORTED: [&str; 2] = ["bin/pick", "bin/place"];
/// The stages that go through tiles of ordered splats.
const TILED: [&str; 5] =
    ["sorted/blend", "hybrid/accumulate", "weighted/accumulate", "average/accumulate", "unsorted/accumulate"];
/// The passes of stochastic transparency, without those that it shares.
const STOCHASTIC: [&str; 4] =
    ["stochastic/visibility", "stochastic/accumulate", "stochastic/gather", "stochastic/resolve"];
/// The passes by which the rasteriser takes the samples.
const DRAWN: [&str; 4] = ["stochastic/draw-alpha", "stochastic/draw-held", "stochastic/draw-sums", "stochastic/fold"];
/// The passes that sort pixels by the length of their lists.
const BY_LENGTH: [&str; 3] = ["abuffer/classify", "abuffer/groups", "abuffer/order"];
/// The passes of lists that are too long for one invocation, and the way of sorting them that each belongs to, if to one.
const LONG: [(&str, Option<LongLists>); 7] = [
    ("abuffer/split", None),
    ("abuffer/run-groups", None),
    ("abuffer/sort-runs", None),
    ("abuffer/merge", Some(LongLists::Merge)),
    ("abuffer/merge-in-place", Some(LongLists::InPlace)),
    ("abuffer/blend-runs", None),
    ("abuffer/combine", None),
];
/// The passes that find the nearest splats, by 64-bit atomics and without.
const SPLATS: [&str; 3] = ["splat/nearest", "splat/nearest-depth", "splat/nearest-id"];
/// The same for 1-pixel points.
const POINTS: [&str; 3] = ["points/nearest", "points/nearest-depth", "points/nearest-id"];
/// The same for layers.
const LAYERS: [&str; 3] = ["peel/nearest", "peel/nearest-depth", "peel/nearest-id"];
/// The passes of depth peeling, without those that it shares.
const PEEL: [&str; 8] = [
    "peel/count",
    "peel/clear",
    "peel/nearest",
    "peel/nearest-depth",
    "peel/nearest-id",
    "peel/blend",
    "peel/next",
    "peel/summary",
];

/// The passes of lists once their lengths are known.
fn list_passes() -> Vec<&'static str> {
    let stores = ["abuffer/store", "linked-list/clear", "linked-list/store", "linked-list/gather"];
    let kernels = ["abuffer/resolve-ordered"].into_iter().chain(BY_LENGTH).chain(CLASSES.map(|(_, name)| name));
    stores.into_iter().chain(kernels).chain(LONG.map(|(name, _)| name)).collect()
}

/// The passes of soft spheres, without those that they share.
fn soft_passes() -> Vec<&'static str> {
    let kernels = soft::classes().map(|(_, (_, name))| name);
    let first = ["soft/count", "soft/store"].into_iter().chain(kernels);
    first.chain(SOFT_LONG).chain(["soft/compose"]).collect()
}

/// Those of them that long lists need; the optical depths of segments only where density varies within a sphere.
const SOFT_LONG: [&str; 4] = ["soft/sum-runs", "soft/carry", "soft/segments", "soft/blend-runs"];

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

    /// Passes that are not listed yet are off.
    fn rest(&mut self, names: &[&'static str], reason: &str) {
        for name in names {
            if self.steps.iter().all(|step| step.name != *name) {
                self.add(name, false, reason);
            }
        }
    }

    /// The light of each point, which later frames don't find again.
    fn shadows(&mut self, frame: &Frame, facts: &Facts) {
        let views = facts.light_views;
        let refusal = shadows::refusal(frame);
        let stored = "the light of each point is with the cloud";
        let shadows = frame.shadows.unwrap_or_default();
        let samples = if shadows.light_radius == 0.0 { 1 } else { shadows.samples };
        let images = format!("{samples} light(s), {views} image(s) of {0} × {0} pixels", shadows.resolution);
        for (name, reason) in shadows::PASSES.into_iter().zip([
            format!("{} points, lit by all lights at first; later frames take what this one finds", facts.points),
            format!("{images}: nothing is there yet"),
            format!("{images}: the nearest depths"),
            "holes in surfaces are closed, so that no light falls through".to_owned(),
            format!("{} points are compared with the nearest depths of each light", facts.points),
            format!("number of lights to share of {samples}"),
        ]) {
            let reason = match &refusal {
                Some(refusal) => refusal.clone(),
                None if views == 0 => stored.to_owned(),
                None if name == "shadows/share" && samples == 1 => "of one light there is all or nothing".to_owned(),
                None => reason,
            };
            let on = refusal.is_none() && views > 0 && (name != "shadows/share" || samples > 1);
            self.add(name, on, reason);
        }
    }

    fn lists(&mut self, device: &Device, frame: &Frame, discs: &Discs, facts: &Facts, seen: bool, why: &str) {
        let pick = |reason: String| if seen { reason } else { NOTHING.to_owned() };
        // Windows whose splats are sorted need no tiles of large splats, and no sort of fragments.
        let (ordered, unordered) = (facts.ordered > 0, facts.windows > facts.ordered);
        let mut counters = 0;
        if ordered {
            let why = "splats are large and flat: sorted, they make ordered lists";
            counters = self.order(device, frame, facts, frame.method.order(), why);
        }
        self.count(frame, facts, seen, why, unordered, counters);
        self.add("image/clear", true, "pixels without fragments stay empty");
        let any = facts.fragments > 0;
        let linked = matches!(frame.method, Method::LinkedList(_));
        let stored = format!("{} fragments in {} band(s)", facts.fragments, facts.bands);
        for (name, for_links) in [
            ("abuffer/store", false),
            ("linked-list/clear", true),
            ("linked-list/store", true),
            ("linked-list/gather", true),
        ] {
            let reason = if for_links == linked { pick(stored.clone()) } else { why.to_owned() };
            self.add(name, any && for_links == linked, reason);
        }
        if ordered {
            self.add("abuffer/resolve-ordered", any, pick("the lists are in the order of blending".to_owned()));
        }
        if unordered {
            for name in BY_LENGTH {
                self.add(name, any, pick("lists of each length get their own kernel".to_owned()));
            }
            self.kernels(facts.max_list, discs.long_lists);
        }
        self.rest(&list_passes(), "no list has to be sorted, or none is in order");
    }

    /// Solid points as opaque splats, and soft ones as spheres before them.
    fn soft_spheres(&mut self, device: &Device, frame: &Frame, facts: &Facts, threshold: f32, why: &str) {
        let solid = facts.solid_points;
        let soft = facts.points.saturating_sub(solid);
        let solids = format!("{solid} solid points (field at most {threshold})");
        let softs = format!("{soft} soft points above threshold {threshold}");
        let counters = if solid > 0 { self.solids(device, frame, facts, &solids) } else { 0 };
        self.add("image/clear", true, "pixels without fragments stay empty");
        if soft == 0 {
            self.scan(counters, "counters of digits and tiles");
        } else {
            let seen = facts.soft_visible > 0;
            let any = facts.fragments > 0;
            let pick = |reason: &str| if seen { reason.to_owned() } else { NOTHING.to_owned() };
            self.add("abuffer/clear", true, "counters start at zero");
            self.add("soft/count", seen, pick(&softs));
            self.add("abuffer/measure", true, format!("the longest list has {} events", facts.max_events));
            let counts = pixels(frame).div_ceil(facts.windows.max(1)) + 1;
            let tiled = self.tiles(frame, &Facts { large: facts.soft_large, ..facts.clone() });
            self.scan(counts.max(tiled).max(counters), "counters of events, tiles and digits");
            self.add("abuffer/cursors", true, "the next free slot of each list is its first");
            self.add("abuffer/summary", true, "the events' total decides the bands");
            let stored = format!(
                "{} spheres on pixels, each with two events or more, in {} band(s)",
                facts.fragments, facts.bands
            );
            self.add("soft/store", any, pick(&stored));
            for name in BY_LENGTH {
                self.add(name, any, pick("lists of each length get their own kernel"));
            }
            self.soft_kernels(facts.max_events, matches!(frame.method, Method::SoftBase(_)));
        }
        self.add("soft/compose", solid > 0, format!("{softs}, before {solids}"));
        self.rest(&soft_passes(), &softs);
        self.rest(&COUNT, if soft > 0 { "soft spheres have a count of their own" } else { &softs });
        self.rest(&list_passes(), &format!("events of soft spheres, not fragments: {why}"));
    }

    /// The kernels of the lengths that there are, for events of soft spheres.
    fn soft_kernels(&mut self, longest: u32, integrated: bool) {
        let reason = |on: bool, least: u32, most: u32| match on {
            true => format!("lists of {least} to {most} events (longest: {longest})"),
            false => format!("no list has {least} events or more (longest: {longest})"),
        };
        for (class, (most, name)) in soft::classes() {
            let least = lower_bound(class) + 1;
            self.add(name, longest >= least, reason(longest >= least, least, most));
        }
        let long = longest > LOCAL_LENGTH;
        let reason = reason(long, LOCAL_LENGTH + 1, longest.max(LOCAL_LENGTH));
        for name in ["abuffer/split", "abuffer/run-groups", "abuffer/sort-runs", "abuffer/merge"] {
            self.add(name, long, reason.clone());
        }
        for name in SOFT_LONG {
            let on = long && (integrated || name != "soft/segments");
            self.add(name, on, if on || !long { reason.clone() } else { "densities are constant".to_owned() });
        }
        self.add("abuffer/combine", long, reason);
    }

    /// The lengths of lists; `visited`: splat by splat. Prefix sums of so many `others` go with theirs.
    fn count(&mut self, frame: &Frame, facts: &Facts, seen: bool, why: &str, visited: bool, others: u64) {
        let counted = if seen { format!("{why}; by {}", facts.raster) } else { NOTHING.to_owned() };
        self.add("abuffer/clear", true, "counters start at zero");
        self.add("abuffer/count", seen, counted);
        self.add("abuffer/measure", true, format!("the longest list has {} fragments", facts.max_list));
        // One element more than pixels: the last prefix sum is the total.
        let counts = pixels(frame).div_ceil(facts.windows.max(1)) + 1;
        let tiled = if visited { self.tiles(frame, facts) } else { 0 };
        self.scan(counts.max(tiled).max(others), "counters of fragments, tiles and digits");
        let linked = matches!(frame.method, Method::LinkedList(_));
        let slots = if linked { "linked lists need no slots" } else { "the next free slot of each list is its first" };
        self.add("abuffer/cursors", !linked, slots);
        self.add("abuffer/summary", true, "the fragments' total decides the bands");
    }

    /// The sort of splats and their tiles; returns how many counters are summed.
    fn order(&mut self, device: &Device, frame: &Frame, facts: &Facts, order: Order, why: &str) -> u64 {
        let bits = bin::key_bits(order, depth_range(frame), facts.points);
        let Digits { digits, bits: digit, counters } = Digits::new(device, facts.points, bits);
        let by = match order {
            Order::Depth => "in order of depth",
            Order::Index => "in canonical order",
            Order::File => "in the files' order",
            Order::Along(_) => "along an axis",
        };
        let by_digit = format!("keys have {bits} bits: {digits} digit(s) of {digit}");
        let zero = || "counters start at zero".to_owned();
        let reasons = [format!("{why}: {} splats {by}", facts.visible), zero(), by_digit.clone(), by_digit];
        for (name, reason) in ORDER.into_iter().zip(reasons) {
            self.add(name, true, reason);
        }
        self.bins(facts, by);
        counters.max(facts.tile_cells)
    }

    /// Splats that are in order into their tiles.
    fn bins(&mut self, facts: &Facts, by: &str) {
        let reasons = [
            format!("splats are read {by}"),
            "counters start at zero".to_owned(),
            format!("{} counters of tiles and runs of splats", facts.tile_cells),
            "the longest list of a tile decides how often tiles are run".to_owned(),
            "the total of the lists decides whether the window fits".to_owned(),
            "each tile gets its splats in order".to_owned(),
        ];
        for (name, reason) in ORDER[4..].iter().zip(reasons) {
            self.add(name, true, reason);
        }
    }

    /// Solid points as opaque splats, and soft ones as discs in a presorted order before them.
    fn soft_discs(&mut self, device: &Device, frame: &Frame, facts: &Facts, threshold: f32, why: &str) {
        let solid = facts.solid_points;
        let solids = format!("{solid} solid points (field at most {threshold})");
        let softs = format!("{} soft points above threshold {threshold}", facts.points.saturating_sub(solid));
        let mut counters = if solid > 0 { self.solids(device, frame, facts, &solids) } else { 0 };
        let Axis { index, backward } = Axis::nearest(frame.camera.forward);
        let by = format!("along {}{}", if backward { '-' } else { '+' }, ['x', 'y', 'z'][index]);
        let seen = facts.soft_visible > 0;
        if seen {
            self.rest(&ORDER[..4], "points were sorted along the axes once");
            self.add("bin/pick", true, format!("{} soft points are drawn, in order {by}", facts.soft_visible));
            self.add("bin/place", true, "only what is drawn is fetched and binned");
            if facts.splatted == 0 {
                self.bins(facts, &by);
            }
            counters = counters.max(facts.tile_cells).max(bin::order_runs(device, facts.points).runs.into());
        }
        self.scan(counters, "counters of runs, tiles and digits");
        let blended = format!("{softs}, {by}, in {} window(s)", facts.bands);
        self.add("soft/express", seen, if seen { &blended } else { NOTHING });
        self.add("soft/compose", solid > 0, format!("{softs}, before {solids}"));
        let empty = facts.windows - facts.bands.min(facts.windows);
        let bare = if solid > 0 { facts.windows.saturating_sub(facts.splatted) } else { 0 };
        let windows = format!("{empty} window(s) show no soft point, {bare} with solid points none of these");
        self.add("image/clear", empty + bare > 0, windows);
        self.rest(&PRESORTED, NOTHING);
        self.rest(&ORDER, NOTHING);
        self.rest(&soft_passes(), &format!("discs, not spheres: {why}"));
        self.rest(&COUNT, "the method needs no lists");
        self.rest(&list_passes(), "soft discs are blended tile by tile: no lists");
    }

    /// The sort of splats, the stage that goes through their tiles, and what counts lists beside them where their lengths are
    /// asked for.
    fn tiled(&mut self, stage: &'static str, device: &Device, frame: &Frame, facts: &Facts, why: &str) {
        let seen = facts.visible > 0;
        let counters = if seen { self.order(device, frame, facts, frame.method.order(), why) } else { 0 };
        if frame.fragments {
            self.count(frame, facts, seen, "lengths of lists are asked for", true, counters);
        } else {
            self.scan(counters, "counters of digits and tiles");
        }
        self.add(stage, seen, if seen { format!("{} window(s) with splats", facts.bands) } else { NOTHING.to_owned() });
        let empty = facts.windows.saturating_sub(facts.bands);
        self.add("image/clear", empty > 0, format!("{empty} window(s) show nothing"));
        self.rest(&ORDER, NOTHING);
        self.rest(&COUNT, "lengths of lists are not asked for, and the method needs none");
        self.rest(&list_passes(), &format!("splats are sorted, not fragments: {why}"));
    }

    /// Splats in three passes, and perhaps a layer over them.
    fn splatted(&mut self, device: &Device, frame: &Frame, facts: &Facts, why: &str) {
        let counters = self.solids(device, frame, facts, why);
        self.scan(counters, "counters of digits and tiles");
        let layered = facts.layered > 0;
        let layer = format!("soft points lie before others in {} window(s)", facts.layered);
        self.add("one-layer/compose", layered, if layered { &layer } else { "no soft point touches the image" });
        // A window with a layer is drawn into twice.
        let empty = facts.windows.saturating_sub(facts.splatted - facts.layered);
        self.add("image/clear", empty > 0, format!("{empty} window(s) show nothing"));
    }

    /// The passes of opaque splats that are blended, tiles included; returns how many counters are summed.
    fn solids(&mut self, device: &Device, frame: &Frame, facts: &Facts, why: &str) -> u64 {
        let seen = facts.splatted > 0;
        let counters = if seen { self.order(device, frame, facts, Order::Index, EACH_PIXEL) } else { 0 };
        let reasons = [
            format!("{why}; what is nearest hides what lies deeper"),
            "what is not hidden is summed by weight".to_owned(),
            "sums to colors".to_owned(),
        ];
        for (name, reason) in SPLATTED.into_iter().zip(reasons) {
            self.add(name, seen, if seen { reason } else { NOTHING.to_owned() });
        }
        counters
    }

    /// The rasteriser's samples, stratum by stratum.
    fn drawn(&mut self, frame: &Frame, facts: &Facts, of: &Stochastic, seen: bool, why: &str) {
        if frame.fragments {
            self.count(frame, facts, seen, "lengths of lists are asked for", true, 0);
        }
        let strata = of.samples.div_ceil(STRATUM);
        let alpha = if of.alpha_correction { "the exact A corrects colors" } else { "no alpha correction" };
        for (name, on, reason) in [
            ("stochastic/draw-alpha", of.alpha_correction, alpha.to_owned()),
            ("stochastic/draw-held", true, format!("{why}; {} samples in {strata} draws", of.samples)),
            ("stochastic/draw-sums", true, format!("what is visible in the samples, in {strata} draws")),
            ("stochastic/fold", true, "from attachments to sums".to_owned()),
            ("stochastic/gather", true, "the sums of each run to those before".to_owned()),
            ("stochastic/resolve", true, format!("sums to color and A; {alpha}")),
        ] {
            self.add(name, seen && on, if seen { reason } else { NOTHING.to_owned() });
        }
        let empty = facts.windows.saturating_sub(facts.bands);
        self.add("image/clear", empty > 0, format!("{empty} window(s) show nothing"));
        self.rest(&STOCHASTIC, "the rasteriser takes the samples");
        self.rest(&ORDER, &format!("splats are blended in no order: {why}"));
        self.rest(&TILED, &format!("samples are taken: {why}"));
        self.rest(&COUNT, "lengths of lists are not asked for, and the method needs none");
        self.rest(&list_passes(), &format!("samples, not lists: {why}"));
    }

    /// Ensembles of points.
    fn dealt(&mut self, device: &Device, frame: &Frame, facts: &Facts, why: &str) {
        let any = facts.slots > 0;
        let dealt = format!("{} points dealt to {} ensembles", facts.slots, facts.ensembles);
        let has = if device.info().int64_atomics { "the device has" } else { "the device has no" };
        self.add("spbr/clear", true, "planes of ensembles and sums start empty");
        let whole = || "all points fit the device and the budget".to_owned();
        let part = |n| format!("{} points don't fit the budget or an allocation: at most {n} at a time", facts.points);
        self.add("spbr/upload", any && facts.streamed.is_some(), facts.streamed.map_or_else(whole, part));
        for (name, forms, how) in [
            (
                "spbr/draw",
                &[Form::Single][..],
                "64-bit atomics, colors need no shading and are within reach".to_owned(),
            ),
            ("spbr/nearest", &[Form::Wide], format!("{has} 64-bit atomics; colors are shaded, or not all in reach")),
            ("spbr/nearest-depth", &[Form::Narrow], format!("{has} 64-bit atomics")),
            ("spbr/nearest-id", &[Form::Narrow], format!("{has} 64-bit atomics")),
            (
                "spbr/sum",
                &[Form::Wide, Form::Narrow],
                "colors of the points that are the nearest of an ensemble".to_owned(),
            ),
        ] {
            let on = any && facts.form.is_some_and(|form| forms.contains(&form));
            self.add(
                name,
                on,
                if on { format!("{why}; {dealt}; {how}") } else { "the ensembles are drawn otherwise".to_owned() },
            );
        }
        let wide = "points of more than 64 pixels are possible: whole workgroups fill them";
        let narrow = "no point can be wider than 7 pixels";
        self.add("spbr/large", any && facts.listed, if facts.listed { wide } else { narrow });
        let epochs = "index and epoch of a point share 32 bits";
        let renewed = if facts.renewed { "there are more ensembles than epochs" } else { "epochs last" };
        self.add("spbr/renew", any && facts.renewed, format!("{epochs}: {renewed}"));
        self.add("spbr/resolve", true, format!("sums of {} ensembles to color and A", facts.ensembles));
        self.add("spbr/summary", true, "how many points were drawn, to the host");
        self.rest(&SPBR, &format!("{} needs none", frame.method.name()));
    }

    /// Splats in tiles, and what goes through them for each few strata of samples.
    fn stochastic(&mut self, device: &Device, frame: &Frame, facts: &Facts, of: &Stochastic, seen: bool, why: &str) {
        if facts.raster == "hardware" {
            return self.drawn(frame, facts, of, seen, why);
        }
        let order = frame.method.order();
        let counters = if seen { self.order(device, frame, facts, order, EACH_PIXEL) } else { 0 };
        if frame.fragments {
            self.count(frame, facts, seen, "lengths of lists are asked for", true, counters);
        } else {
            self.scan(counters, "counters of digits and tiles");
        }
        let (samples, runs) = (of.samples, stochastic::batches(of.samples).count());
        let alpha = if of.alpha_correction { "the exact A corrects colors" } else { "no alpha correction" };
        let reasons = [
            format!("{why}; {samples} samples in {runs} run(s) over the splats"),
            format!("what is visible in {samples} samples; {alpha}"),
            "the sums of each run to those before".to_owned(),
            format!("sums to color and A; {alpha}"),
        ];
        for (name, reason) in STOCHASTIC.into_iter().zip(reasons) {
            self.add(name, seen, if seen { reason } else { NOTHING.to_owned() });
        }
        let empty = facts.windows.saturating_sub(facts.bands);
        self.add("image/clear", empty > 0, format!("{empty} window(s) show nothing"));
        self.rest(&ORDER, &format!("splats are blended in no order: {why}"));
        self.rest(&TILED, &format!("samples are taken: {why}"));
        self.rest(&COUNT, "lengths of lists are not asked for, and the method needs none");
        self.rest(&list_passes(), &format!("samples, not lists: {why}"));
    }

    /// The lists of large splats by tile; returns the longest prefix sum that they need.
    fn tiles(&mut self, frame: &Frame, facts: &Facts) -> u64 {
        let on = facts.large > 0 && facts.raster == "compute";
        let reason = if facts.raster == "compute" {
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
    fn kernels(&mut self, longest: u32, long_lists: LongLists) {
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
        for (name, way) in LONG {
            let taken = way.is_none_or(|way| way == long_lists);
            let how = if long_lists == LongLists::Merge { "merge" } else { "in-place" };
            let reason = if taken { reason.clone() } else { format!("long_lists = \"{how}\"") };
            self.add(name, long && taken, reason);
        }
    }

    fn peel(&mut self, device: &Device, frame: &Frame, facts: &Facts, wide: bool, layers: u32, why: &str) {
        let seen = facts.visible > 0;
        let tiled = self.tiles(frame, facts);
        self.scan(tiled, "tiles of large splats");
        let counted = "list lengths, for `profile` and --aov only";
        self.add("peel/clear", true, "nothing is peeled yet");
        self.add("peel/count", seen && frame.fragments, if seen { counted } else { NOTHING });
        self.add("image/clear", true, "pixels without fragments stay empty");
        let until = if layers == 0 { "until nothing is left".to_owned() } else { format!("{layers} layers") };
        self.nearest(device, LAYERS, seen, wide, if seen { format!("{why}; {until}") } else { NOTHING.to_owned() });
        self.add("peel/blend", true, "each layer lies behind those before");
        self.add("peel/next", true, "a layer without a fragment is the last");
        self.add("peel/summary", true, "between batches of layers the host looks whether there are more");
    }

    /// The passes of opaque splats.
    fn splats(&mut self, device: &Device, frame: &Frame, facts: &Facts, wide: bool, seen: bool, why: &str) {
        let tiled = self.tiles(frame, facts);
        self.scan(tiled, "tiles of large splats");
        self.nearest(device, SPLATS, seen, wide, if seen { why } else { NOTHING });
        self.add("splat/resolve", true, "index of the nearest splat to color");
    }

    /// The nearest of each pixel, with and without 64-bit atomics: `[wide, narrow, narrow]`.
    fn nearest(
        &mut self,
        device: &Device,
        [both, depth, id]: [&'static str; 3],
        on: bool,
        wide: bool,
        reason: impl AsRef<str>,
    ) {
        let reason = reason.as_ref();
        let has = if device.info().int64_atomics { "the device has" } else { "the device has no" };
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
