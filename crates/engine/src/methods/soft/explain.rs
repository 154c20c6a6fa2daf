//! Plans of methods with soft points.

use super::{Interior, classes};
use crate::methods::abuffer::{self, BY_LENGTH, LOCAL_LENGTH, lower_bound};
use crate::methods::explain::{Absent, FramePlan, NOTHING, ORDER, PRESORTED, PassGroup};
use crate::methods::splats::explain_solids;
use crate::passes::bin;
use crate::prepare::axes::Axis;
use crate::scene::{LongLists, Soft};

/// Passes of soft spheres that only long lists need; the optical depths of segments only where density varies within a
/// sphere.
const LONG: [&str; 4] = ["soft/sum-runs", "soft/carry", "soft/segments", "soft/blend-runs"];

/// Returns the passes of soft spheres, without those that they share.
pub(crate) fn sphere_group() -> PassGroup {
    PassGroup { names: sphere_passes(), absent: Absent::Method("no soft spheres") }
}

/// Returns the pass of soft discs.
pub(crate) fn disc_group() -> PassGroup {
    PassGroup::new(&["soft/express"], Absent::Method("no soft discs"))
}

fn sphere_passes() -> Vec<&'static str> {
    let kernels = classes().map(|(_, (_, name))| name);
    let first = ["soft/count", "soft/store"].into_iter().chain(kernels);
    first.chain(LONG).chain(["soft/compose"]).collect()
}

/// Solid points as opaque splats, and soft ones as spheres before them.
pub(super) fn spheres(plan: &mut FramePlan<'_>, settings: &Soft, interior: Interior) {
    let (facts, why, threshold) = (plan.facts, plan.why, settings.threshold);
    plan.projected();
    let solid = facts.solid_points;
    let soft = facts.points.saturating_sub(solid);
    let solids = format!("{solid} solid points (field values up to {threshold})");
    let softs = format!("{soft} soft points (field values above {threshold})");
    let counters = if solid > 0 { explain_solids(plan, &solids) } else { 0 };
    plan.add("image/clear", true, "pixels without fragments stay empty");
    if soft == 0 {
        plan.scan(counters, "counters of digits and tiles");
    } else {
        events(plan, &softs, counters, (interior, settings.long_lists));
    }
    plan.add("soft/compose", solid > 0, format!("{softs}, in front of {solids}"));
    plan.rest(&sphere_passes(), &softs);
    plan.rest(&abuffer::COUNT, if soft > 0 { "soft spheres are counted by soft/count" } else { &softs });
    plan.rest(&abuffer::list_passes(), &format!("lists hold events of soft spheres, not fragments: {why}"));
}

/// Events of spheres in lists.
fn events(plan: &mut FramePlan<'_>, softs: &str, counters: u64, (interior, way): (Interior, LongLists)) {
    let facts = plan.facts;
    let seen = facts.soft_visible > 0;
    let any = facts.fragments > 0;
    let pick = |reason: &str| if seen { reason.to_owned() } else { NOTHING.to_owned() };
    plan.add("abuffer/clear", true, "counters start at zero");
    plan.add("soft/count", seen, pick(softs));
    plan.add("abuffer/measure", true, format!("the longest list has {} events", facts.max_events));
    let counts = plan.pixels().div_ceil(facts.windows.max(1)) + 1;
    let tiled = plan.pairs(facts.soft_large);
    plan.scan(counts.max(tiled).max(counters), "counters of events, tiles and digits");
    plan.add("abuffer/cursors", true, "each list starts with its first slot free");
    plan.add("abuffer/summary", true, "the total number of events decides how many bands the image is split into");
    let stored =
        format!("pixels meet {} spheres, each with two events or more, in {} band(s)", facts.fragments, facts.bands);
    plan.add("soft/store", any, pick(&stored));
    for name in BY_LENGTH {
        plan.add(name, any, pick("pixels are grouped by the length of their lists, as each length has its own kernel"));
    }
    kernels(plan, facts.max_events, interior.is_integrated(), way);
}

/// The kernels of the lengths that occur, for events of soft spheres.
fn kernels(plan: &mut FramePlan<'_>, longest: u32, integrated: bool, way: LongLists) {
    let reason = |on: bool, least: u32, most: u32| match on {
        true => format!("lists of {least} to {most} events (longest: {longest})"),
        false => format!("no list has {least} events or more (longest: {longest})"),
    };
    for (class, (most, name)) in classes() {
        let least = lower_bound(class) + 1;
        plan.add(name, longest >= least, reason(longest >= least, least, most));
    }
    let long = longest > LOCAL_LENGTH;
    let reason = reason(long, LOCAL_LENGTH + 1, longest.max(LOCAL_LENGTH));
    for name in ["abuffer/split", "abuffer/run-groups", "abuffer/sort-runs"] {
        plan.add(name, long, reason.clone());
    }
    for (name, of) in [("abuffer/merge", LongLists::Merge), ("abuffer/merge-in-place", LongLists::InPlace)] {
        let other = format!("long_lists = \"{}\"", way.word());
        plan.add(name, long && way == of, if way == of || !long { reason.clone() } else { other });
    }
    for name in LONG {
        let on = long && (integrated || name != "soft/segments");
        let constant = "the density is constant within each sphere";
        plan.add(name, on, if on || !long { &reason } else { constant });
    }
    plan.add("abuffer/combine", long, reason);
}

/// Solid points as opaque splats, and soft ones as discs in a presorted order before them.
pub(super) fn discs(plan: &mut FramePlan<'_>, threshold: f32) {
    let (facts, why) = (plan.facts, plan.why);
    plan.projected();
    let solid = facts.solid_points;
    let solids = format!("{solid} solid points (field values up to {threshold})");
    let softs = format!("{} soft points (field values above {threshold})", facts.points.saturating_sub(solid));
    let mut counters = if solid > 0 { explain_solids(plan, &solids) } else { 0 };
    let Axis { index, backward } = Axis::nearest(plan.frame.camera.forward);
    let by = format!("along {}{}", if backward { '-' } else { '+' }, ['x', 'y', 'z'][index]);
    let seen = facts.soft_visible > 0;
    if seen {
        plan.add("bin/pick", true, format!("{} soft points are drawn, in their order {by}", facts.soft_visible));
        plan.add("bin/place", true, "fetches and bins only the points that are drawn");
        if facts.splatted == 0 {
            plan.presorted_bins(&by);
        }
        counters = counters.max(facts.tile_cells).max(bin::order_runs(plan.device, facts.points).runs.into());
    }
    plan.scan(counters, "counters of runs, tiles and digits");
    let blended = format!("{softs}, {by}, in {} window(s)", facts.bands);
    plan.add("soft/express", seen, if seen { &blended } else { NOTHING });
    plan.add("soft/compose", solid > 0, format!("{softs}, in front of {solids}"));
    let empty = facts.windows - facts.bands.min(facts.windows);
    let bare = if solid > 0 { facts.windows.saturating_sub(facts.splatted) } else { 0 };
    let windows = format!("{empty} window(s) show no soft point; {bare} show none of the frame's solid points");
    plan.add("image/clear", empty + bare > 0, windows);
    plan.rest(&PRESORTED, NOTHING);
    plan.rest(&ORDER, NOTHING);
    plan.rest(&sphere_passes(), &format!("soft points are discs, not spheres: {why}"));
    plan.rest(&abuffer::COUNT, "the method needs no lists");
    plan.rest(&abuffer::list_passes(), "soft discs are blended tile by tile, without lists");
}
