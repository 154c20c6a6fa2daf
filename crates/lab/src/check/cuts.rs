//! Memory: images that a budget cuts into regions and batches of fragments, and fragments beyond what one binding can
//! hold.

use super::prelude::*;
use super::{Lack, Verdict};
use pellucid_scene::{Density, DiscShape, Family, LongLists, Setting, Shells, Soft};

pub(super) fn cases() -> Vec<Case> {
    let oriented = Discs { shape: DiscShape::Oriented, ..Discs::default() };
    let soft = Soft { density: Density::Softness(0.05), shells: Shells::Fixed(2), ..Soft::default() };
    // The runs of `sorted` follow its regions, and opaque splats that are not blended have nothing to cut.
    let blended = |method: &Method| method.key("blend_depth").is_some();
    let discs = with_samples(8, except(|method| matches!(method, Method::Sorted(_)), of_families(&[Family::Discs])));
    let discs = discs.into_iter().map(|method| if method.is_exact(true) { tilted(method) } else { method });
    let splats = Family::Opaque.methods().filter(blended);
    let spheres = Family::Soft.methods().map(|method| with_soft(method, soft));
    let cut: Vec<Method> = discs.chain(splats).chain(spheres).collect();
    let in_place = [Method::ABuffer(Discs { long_lists: LongLists::InPlace, ..oriented })];
    let events = Family::Soft.methods().filter(|method| method.key("long_lists").is_some());
    let events: Vec<Method> = events.map(|method| with_soft(method, soft)).collect();
    joined([
        each(&cut, "budget", budget).about("cut by a memory budget: no byte changes"),
        each(&in_place, "in-place", in_place_bytes).about("4000 fragments sorted in place: the bytes of the merge"),
        each(&[Method::ABuffer(oriented)], "beyond-a-binding", beyond)
            .about("more fragments than one binding holds, against float64"),
        each(&events, "events-in-place", in_place_events)
            .about("600 events and more sorted in place: the bytes of the merge"),
    ])
}

/// Discs over an image of 48 × 32 pixels, some at the same depth, in which every pixel holds more than one fragment.
fn crowd(count: u32, radius: f32) -> Vec<Dot> {
    let part = |i: u32, factor: u32| (i.wrapping_mul(factor) >> 9) % 4096;
    let disc = |i: u32| {
        let [x, y] = [2_654_435_761, 2_246_822_519].map(|factor| f64::from(part(i, factor)) / 4096.0);
        Dot {
            position: DVec3::new(48.0 * x, -32.0 * y, -f64::from(10 + i % 200)),
            color: mixed(i),
            opacity: 0.05,
            radius,
            normal: Vec3::new((i % 9) as f32 - 4.0, (i % 4) as f32 - 1.5, 6.0).normalize(),
            field: 1.0,
        }
    };
    (1..=count).map(disc).collect()
}

fn budget(stage: &mut CaseRenderer, method: Method) -> CaseResult {
    let size = [48, 32];
    // Without lists of fragments there is less to cut: what tiles of more than 2048 splats leave to their next run.
    let whole = Frame::new(pixels(size), size, method);
    let tiled = whole.counts_on_demand() && !matches!(method, Method::Stochastic(_));
    let dots = if tiled { crowd(2500, 60.0) } else { crowd(600, 6.0) };
    let points = cloud(&dots);
    let free = stage.render(&points, &whole)?;
    // Half as much again each time, from what is too little for anything until it does.
    let mut budget = 2u64 << 10;
    let cut = loop {
        let attempt = stage.render(&points, &Frame { memory_budget: Some(budget), ..whole });
        match attempt {
            Err(error) if error.is_refusal() && budget < 64 << 20 => budget += budget / 2,
            found => break found?,
        }
    };
    let was_cut = cut.facts.windows > free.facts.windows || cut.facts.bands > free.facts.bands;
    let error = if was_cut { bytes_apart(&free.image, &cut.image) } else { f64::INFINITY };
    let why = "a pool of a fixed size loses the fragments that come last";
    Ok(Finding::stated(error, 0.0, why))
}

fn in_place_bytes(stage: &mut CaseRenderer, method: Method) -> CaseResult {
    // Discs that might cross, so that no order is made beforehand.
    let discs = |long_lists| Method::ABuffer(Discs { shape: DiscShape::Oriented, long_lists, ..Discs::default() });
    let facing = |dot: &Dot| Dot { normal: Vec3::Z, ..*dot };
    let dots: Vec<Dot> = crowd(4000, 60.0).iter().map(facing).collect();
    let size = [4, 3];
    let merged = stage.image(&dots, pixels(size), size, discs(LongLists::Merge))?;
    let sorted = stage.image(&dots, pixels(size), size, method)?;
    // Composed as they came; each disc covers every pixel.
    let mut by_depth = dots.clone();
    by_depth.sort_by(|a, b| b.position.z.total_cmp(&a.position.z));
    let pixels = (size[0] * size[1]) as usize;
    let naive = bytes_between(&vec![over(&dots); pixels], &vec![over(&by_depth); pixels]);
    Ok(Finding::new(bytes_apart(&merged, &sorted), 0.0, naive))
}

fn in_place_events(stage: &mut CaseRenderer, method: Method) -> CaseResult {
    let dots = crowd(300, 60.0);
    let size = [4, 3];
    let sorted = |word: &str| method.with("long_lists", Setting::Word(word.to_owned())).unwrap_or(method);
    let [merged, in_place] = ["merge", "in-place"].map(|word| stage.image(&dots, pixels(size), size, sorted(word)));
    let (merged, in_place) = (merged?, in_place?);
    let points = cloud(&dots);
    let facts = stage.render(&points, &Frame::new(pixels(size), size, sorted("in-place")))?.facts;
    let error = if facts.max_events >= 600 { bytes_apart(&merged, &in_place) } else { f64::INFINITY };
    Ok(Finding::stated(error, 0.0, "a merge that is cut off leaves runs that are sorted by themselves alone"))
}

/// Layers of [`beyond`].
const LAYERS: u32 = 24;

fn beyond(stage: &mut CaseRenderer, method: Method) -> Verdict {
    let binding = stage.device().limits().binding_bytes;
    let side = ((binding / 8 / u64::from(LAYERS)) as f64 * 1.25).sqrt().ceil() as u32;
    if side > 1536 {
        let what = format!("to bind less than {binding} bytes at a time: more fragments than are worth rendering");
        return Verdict::NotApplicable(Lack::Limits, what);
    }
    fragments_beyond(stage, method, side).into()
}

fn fragments_beyond(stage: &mut CaseRenderer, method: Method, side: u32) -> CaseResult {
    let size = [side, side];
    let layer = |i: u32| Dot {
        position: at(side / 2, side / 2, f64::from(10 + i)),
        color: graded(i, LAYERS),
        opacity: 0.1,
        radius: 2.0 * side as f32,
        normal: Vec3::Z,
        ..Dot::default()
    };
    let dots: Vec<Dot> = (0..LAYERS).map(layer).collect();
    let wanted = composed(&dots);
    let found = stage.render(&cloud(&dots), &Frame::new(pixels(size), size, method))?;
    let error = found.image.rgba.iter().map(|pixel| apart(pixel, &wanted)).fold(0.0, f64::max);
    let error = if found.facts.bands > 1 { error } else { f64::INFINITY };
    let why = "what is written beyond the end of a binding is gone, and whole pixels with it";
    Ok(Finding::stated(error, roundings(&method, LAYERS as usize) * HALF_ULP, why))
}
