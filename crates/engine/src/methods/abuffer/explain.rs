//! Plans of methods with lists of fragments.

use super::{CLASSES, FRAGMENT_BYTES, LINK_BYTES, LOCAL_LENGTH, lower_bound};
use crate::methods::prelude::*;

/// The passes that find the lengths of lists.
pub(crate) const COUNT: [&str; 5] =
    ["abuffer/clear", "abuffer/count", "abuffer/measure", "abuffer/cursors", "abuffer/summary"];
/// The passes that sort pixels by the length of their lists.
pub(crate) const BY_LENGTH: [&str; 2] = ["abuffer/classify", "abuffer/order"];
/// The passes that put fragments into lists.
const STORE: [&str; 4] = ["abuffer/store", "linked-list/clear", "linked-list/store", "linked-list/gather"];
/// The passes of lists that are too long for one invocation, and the way of sorting them that each belongs to, if to
/// one.
const LONG: [(&str, Option<LongLists>); 7] = [
    ("abuffer/split", None),
    ("abuffer/run-groups", None),
    ("abuffer/sort-runs", None),
    ("abuffer/merge", Some(LongLists::Merge)),
    ("abuffer/merge-in-place", Some(LongLists::InPlace)),
    ("abuffer/blend-runs", None),
    ("abuffer/combine", None),
];

/// Returns the passes that find the lengths of lists.
pub(crate) fn count_group() -> PassGroup {
    PassGroup::new(&COUNT, Absent::Discs("no lists"))
}

/// Returns the passes of events of ellipsoids.
pub(crate) fn ellipsoid_group() -> PassGroup {
    let names = [
        "ellipsoids/count",
        "ellipsoids/store",
        "ellipsoids/link",
        "ellipsoids/split",
        "ellipsoids/sum-runs",
        "ellipsoids/blend-runs",
        "ellipsoids/median",
    ];
    PassGroup::new(&names, Absent::Discs("no ellipsoids"))
}

/// Returns the passes of lists once their lengths are known.
pub(crate) fn list_group() -> PassGroup {
    PassGroup { names: list_passes(), absent: Absent::Discs("no lists") }
}

/// Returns the passes of lists once their lengths are known.
pub(crate) fn list_passes() -> Vec<&'static str> {
    let kernels = ["abuffer/resolve-ordered", "abuffer/end", "abuffer/median"]
        .into_iter()
        .chain(BY_LENGTH)
        .chain(CLASSES.map(|(_, name)| name));
    STORE.into_iter().chain(kernels).chain(LONG.map(|(name, _)| name)).collect()
}

/// The plan of a frame of lists.
pub(crate) fn lists(plan: &mut FramePlan<'_>, discs: &Discs, linked: bool) {
    let (facts, why) = (plan.facts, plan.why);
    plan.projected();
    if facts.gaussians > 0 && discs.gaussians.kernel == Kernel::Ellipsoid {
        return ellipsoids(plan, discs.long_lists, linked);
    }
    // Windows whose splats are sorted need no pairs of large splats and tiles, and no sort of fragments.
    let (ordered, unordered) = (facts.ordered > 0, facts.windows > facts.ordered);
    let mut counters = 0;
    if ordered {
        counters =
            plan.order(Order::Depth, "splats are large and face the screen, so sorting them yields lists in order");
    }
    count(plan, why, unordered, counters, linked);
    plan.add("image/clear", true, "pixels without fragments stay empty");
    let any = facts.fragments > 0;
    let stored = format!("{} fragments in {} band(s)", facts.fragments, facts.bands);
    for (name, for_links) in STORE.into_iter().zip([false, true, true, true]) {
        let reason = if for_links == linked { plan.if_seen(stored.clone()) } else { why.to_owned() };
        plan.add(name, any && for_links == linked, reason);
    }
    if ordered {
        let reason = plan.if_seen("the lists are already in the order of blending");
        plan.add("abuffer/resolve-ordered", any, reason);
    }
    if unordered {
        let reason = "pixels are grouped by the length of their lists, as each length has its own kernel";
        BY_LENGTH.into_iter().for_each(|name| plan.add(name, any, plan.if_seen(reason)));
        kernels(plan, facts.max_list, discs);
    }
    plan.rest(&list_passes(), "every list is already in order, or every list must be sorted");
}

/// The plan of a frame of lists of events: where rays enter and leave ellipsoids.
fn ellipsoids(plan: &mut FramePlan<'_>, long_lists: LongLists, linked: bool) {
    let facts = plan.facts;
    let (any, several) = (facts.fragments > 0, facts.max_events > LOCAL_LENGTH);
    let met = plan
        .if_seen(format!("all rays meet {} ellipsoids and discs, stored in {} band(s)", facts.fragments, facts.bands));
    plan.add("abuffer/clear", true, "counters start at zero");
    let events = plan.if_seen("a ray that meets an ellipsoid has two events: it enters and it leaves");
    plan.add("ellipsoids/count", plan.seen(), events);
    plan.add("abuffer/measure", true, format!("the longest list has {} events", facts.max_events));
    let counts = plan.pixels().div_ceil(facts.windows.max(1)) + 1;
    let tiled = plan.pairs(facts.large);
    plan.scan(counts.max(tiled), "counters of events and tiles");
    let slots = if linked { "linked lists reserve no slots" } else { "each list starts with its first slot free" };
    plan.add("abuffer/cursors", !linked, slots);
    plan.add("abuffer/summary", true, "the total number of events decides how many bands the image is split into");
    plan.add("image/clear", true, "pixels without events stay empty");
    for (name, for_links) in [
        ("ellipsoids/store", false),
        ("linked-list/clear", true),
        ("ellipsoids/link", true),
        ("linked-list/gather", true),
    ] {
        let reason = if for_links == linked { met.clone() } else { plan.why.to_owned() };
        plan.add(name, any && for_links == linked, reason);
    }
    let runs = plan.if_seen(format!("lists are sorted and composited in runs of {LOCAL_LENGTH} events"));
    let longest = format!("the longest list has {} events", facts.max_events);
    plan.add("ellipsoids/split", any, runs.clone());
    plan.add("abuffer/run-groups", any, runs.clone());
    plan.add("abuffer/sort-runs", any, runs.clone());
    let merged = long_lists == LongLists::Merge;
    plan.add("abuffer/merge", several && merged, longest.clone());
    plan.add("abuffer/merge-in-place", several && !merged, longest.clone());
    plan.add("ellipsoids/sum-runs", several, longest.clone());
    plan.add("soft/carry", several, longest);
    plan.add("ellipsoids/blend-runs", any, runs.clone());
    plan.add("abuffer/combine", any, runs.clone());
    let wanted = wants_medians(plan);
    plan.add("ellipsoids/median", any && wanted, if wanted { runs } else { NO_MEDIANS.to_owned() });
}

/// The lengths of lists, counted beside what the method does if they are asked for; `others` are elements of its prefix
/// sums.
pub(crate) fn counted_beside(plan: &mut FramePlan<'_>, others: u64) {
    if plan.frame.fragments {
        count(plan, "the lengths of lists were requested", true, others, false);
    } else {
        plan.scan(others, "counters of digits and tiles");
    }
}

/// Explains the counting of list lengths; `visited` means splat by splat. Prefix sums of `others` further elements
/// share their passes.
fn count(plan: &mut FramePlan<'_>, why: &str, visited: bool, others: u64, linked: bool) {
    let facts = plan.facts;
    let counted = if plan.seen() { format!("{why}; rasterized by {}", facts.raster) } else { NOTHING.to_owned() };
    plan.add("abuffer/clear", true, "counters start at zero");
    plan.add("abuffer/count", plan.seen(), counted);
    plan.add("abuffer/measure", true, format!("the longest list has {} fragments", facts.max_list));
    // One more element than pixels: the last prefix sum is the total.
    let counts = plan.pixels().div_ceil(facts.windows.max(1)) + 1;
    let tiled = if visited { plan.pairs(facts.large) } else { 0 };
    plan.scan(counts.max(tiled).max(others), "counters of fragments, tiles and digits");
    let slots = if linked { "linked lists reserve no slots" } else { "each list starts with its first slot free" };
    plan.add("abuffer/cursors", !linked, slots);
    plan.add("abuffer/summary", true, "the total number of fragments decides how many bands the image is split into");
}

/// The kernels of the lengths that occur.
fn kernels(plan: &mut FramePlan<'_>, longest: u32, discs: &Discs) {
    let long_lists = discs.long_lists;
    for (class, (most, name)) in CLASSES.into_iter().enumerate() {
        let least = lower_bound(class) + 1;
        let on = longest >= least;
        let lengths = if least == most { most.to_string() } else { format!("{least} to {most}") };
        let reason = if on {
            format!("lists of length {lengths} (longest: {longest})")
        } else {
            format!("no list has length {least} or more (longest: {longest})")
        };
        plan.add(name, on, reason);
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
        plan.add(name, long && taken, reason);
    }
    let ends = discs.gaussians.stop > 0.0;
    let end = if ends { reason.clone() } else { "no early end of lists requested (method.stop)".to_owned() };
    plan.add("abuffer/end", long && ends, end);
    let wanted = wants_medians(plan);
    plan.add("abuffer/median", long && wanted, if wanted { reason } else { NO_MEDIANS.to_owned() });
}

/// Reason why no medians are found.
const NO_MEDIANS: &str = "neither eye-dome lighting (shading.edl) nor median depths were requested";

/// Returns `true` if the depths are wanted at which half of the light or less is left.
fn wants_medians(plan: &FramePlan<'_>) -> bool {
    plan.frame.shading.edl.edl || plan.frame.depths
}

/// Returns the least number of bytes that a pass over lists must move, for any lengths; `tilted` if discs lie in their
/// tangent planes.
pub(crate) fn list_bytes(pass: &PassRuns<'_>, tilted: bool) -> Option<u64> {
    let (facts, pixels) = (pass.facts, pass.pixels());
    let stored = |fragment: u64| {
        let splats = facts.points * 8 * facts.bands + facts.visible * pass.splat(tilted);
        splats + facts.fragments * (8 + fragment)
    };
    match pass.name {
        "abuffer/clear" | "abuffer/measure" | "abuffer/classify" => Some(pixels * 4),
        "abuffer/cursors" | "abuffer/order" => Some(pixels * 8),
        "abuffer/count" => Some(pass.walks(tilted) + facts.fragments * 8),
        "abuffer/store" => Some(stored(FRAGMENT_BYTES)),
        // Besides the node, its link and the counter of nodes, read and written.
        "linked-list/store" => Some(stored(FRAGMENT_BYTES + LINK_BYTES + 8)),
        // Every run looks at all offsets.
        "linked-list/gather" => Some(pixels * 8 + facts.fragments * (2 * FRAGMENT_BYTES + LINK_BYTES)),
        _ => None,
    }
}
