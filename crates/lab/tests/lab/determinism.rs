//! Determinism: the same input gives the same bytes with every method, over runs, orders of the input, budgets, and
//! ways to cut the work.
//!
//! The tests of single methods say more about each; this one goes through the list of all of them, so that none is
//! forgotten. `cargo test --test lab determinism -- --ignored` repeats everything 20 times.

mod budgets;

use std::collections::HashSet;
use std::sync::OnceLock;

use pellucid_core::image::Image;
use pellucid_engine::methods::{Error, Facts, Frame, Rendered, Renderer};
use pellucid_gpu::{self as gpu, Device, Preferences, Variant};
use pellucid_lab::check::{self, Follows, Lack, MethodScene};
use pellucid_scene::prepare::Arranged;
use pellucid_scene::{Discs, Method, MethodChoice};
use pellucid_testing::{is_llvmpipe, with_device, with_device_that_binds, with_device_that_prefers};

use crate::by_halves;
use budgets::Budgets;

/// Subjects, all of which llvmpipe renders.
const SUBJECTS: usize = 62;

/// A subject, its points in order, and its image as a renderer that has done nothing else makes it.
pub struct Baseline {
    pub subject: MethodScene,
    arranged: Arranged,
    first: Rendered,
}

fn fresh(device: &Device) -> Renderer {
    Renderer::new(device).expect("a renderer")
}

/// All subjects of a half that the device can render, for all tests; what it lacks for the others is printed.
fn known(half: usize, device: &Device) -> &'static [Baseline] {
    static KNOWN: [OnceLock<Vec<Baseline>>; 2] = [OnceLock::new(), OnceLock::new()];
    KNOWN[half].get_or_init(|| baselines(half, device))
}

fn baselines(half: usize, device: &Device) -> Vec<Baseline> {
    let mut found = Vec::new();
    for subject in check::subjects().into_iter().skip(half).step_by(2) {
        let arranged = subject.arranged();
        match subject.render_arranged(&mut fresh(device), &arranged) {
            Ok(first) => found.push(Baseline { subject, arranged, first }),
            Err(error) if Lack::in_error(&error).is_some() => println!("not applicable: {}: {error}", subject.name),
            Err(error) => panic!("{}: {error}", subject.name),
        }
    }
    if is_llvmpipe(device) {
        assert_eq!(found.len(), (SUBJECTS - half).div_ceil(2), "llvmpipe renders all of them");
    }
    found
}

/// The differences, one per line.
#[derive(Default)]
struct Wrong(Vec<String>);

impl Wrong {
    fn compare(&mut self, known: &Baseline, found: &Image, how: &str) {
        if let Some(difference) = check::difference(&known.first.image, found) {
            self.0.push(format!("{}, {how}: {difference}", known.subject.name));
        }
    }

    /// Renders another frame and compares its image.
    fn compare_frame(&mut self, known: &Baseline, renderer: &mut Renderer, frame: Frame, how: &str) -> Option<Facts> {
        match known.subject.with(frame).render_arranged(renderer, &known.arranged) {
            Ok(rendered) => {
                self.compare(known, &rendered.image, how);
                Some(rendered.facts)
            }
            Err(error) => {
                self.0.push(format!("{}, {how}: {error}", known.subject.name));
                None
            }
        }
    }

    #[track_caller]
    fn assert_none(&self) {
        assert!(self.0.is_empty(), "{} differ:\n{}", self.0.len(), self.0.join("\n"));
    }
}

/// A shader and its variant, without the numbers that a frame or a device decides.
fn key(stem: &str, variant: &Variant) -> String {
    format!("{stem}: {}", pellucid_engine::key_without_numbers(variant))
}

/// Returns the variants that no stage lists, so that the tests of shaders don't go through them.
fn unlisted(ran: &[(&'static str, Variant)]) -> Vec<String> {
    let shaders = pellucid_engine::shaders().into_iter().chain(gpu::shaders());
    let keys = |shader: gpu::shader::Shader| {
        shader.variants.iter().map(|variant| key(shader.pass.shader, variant)).collect::<Vec<_>>()
    };
    let listed: HashSet<String> = shaders.flat_map(keys).collect();
    ran.iter().map(|(stem, variant)| key(stem, variant)).filter(|key| !listed.contains(key)).collect()
}

/// Every shader that ran on the device must be listed by its stage, in that variant.
fn assert_listed(device: &Device) {
    let ran: Vec<_> = device.made().into_iter().map(|made| (made.stem, made.variant)).collect();
    let missing = unlisted(&ran);
    assert!(missing.is_empty(), "{} of {}:\n{}", missing.len(), ran.len(), missing.join("\n"));
}

#[test]
fn a_variant_that_no_stage_lists_is_found() {
    let shaders = pellucid_engine::shaders();
    let shader = shaders.iter().find(|shader| shader.pass.name == "opaque/nearest").expect("a pass of opaque splats");
    let listed = || shader.variants[0].clone();
    assert_eq!(unlisted(&[(shader.pass.shader, listed())]), Vec::<String>::new());
    let mut other = listed();
    other.overrides[0].1 = 17.0;
    let made_up = [other, listed().with("PART_LENGTH", 1), listed().subgroup(7), listed().walker("walk_nothing")];
    for made_up in made_up {
        assert_eq!(unlisted(&[(shader.pass.shader, made_up.clone())]), [key(shader.pass.shader, &made_up)]);
    }
    assert_eq!(unlisted(&[("splat/nowhere", listed())]).len(), 1);
    // The length of a part is the device's.
    let shader = shaders.iter().find(|shader| shader.pass.name == "opaque/resolve").expect("a pass over parts");
    let mut long = shader.variants[0].clone();
    let (_, length) = long.overrides.iter_mut().find(|(name, _)| *name == "PART_LENGTH").expect("it has parts");
    *length += 64.0;
    assert_eq!(unlisted(&[(shader.pass.shader, long)]), Vec::<String>::new());
}

/// Runs on a renderer that has rendered all the others before, in both directions, and on fresh ones.
fn repeated(device: &Device, all: &[Baseline], times: usize, wrong: &mut Wrong) {
    let mut kept = fresh(device);
    for round in 0..times {
        let places: Vec<usize> = if round % 2 == 0 { (0..all.len()).collect() } else { (0..all.len()).rev().collect() };
        for place in places {
            let known = &all[place];
            wrong.compare_frame(known, &mut kept, known.subject.frame, &format!("run {round} on a kept renderer"));
        }
    }
    for round in 0..times.div_ceil(2) {
        for known in all {
            let how = format!("run {round} on a fresh renderer");
            wrong.compare_frame(known, &mut fresh(device), known.subject.frame, &how);
        }
    }
}

fn render(device: &Device, subject: &MethodScene) -> Image {
    subject.render(&mut fresh(device)).expect("what renders in one order renders in any").image
}

/// Points and clouds in other orders; where an order is part of the method, it must show.
fn reordered(device: &Device, all: &[Baseline], seeds: u32, wrong: &mut Wrong) {
    for known in all {
        let subject = &known.subject;
        let shuffled = (1..=seeds).map(|seed| (format!("points shuffled by {seed}"), subject.shuffled(seed), false));
        let reversed = ("clouds reversed".to_owned(), subject.clouds_reversed(), true);
        for (how, other, of_clouds) in shuffled.chain([reversed]) {
            let image = render(device, &other);
            let may_show = match subject.follows() {
                Follows::Nothing => false,
                Follows::Clouds => of_clouds,
                Follows::Points => true,
            };
            if !may_show {
                wrong.compare(known, &image, &how);
            } else if check::difference(&known.first.image, &image).is_none() {
                wrong.0.push(format!("{}, {how}: should show, by the definition of the method", subject.name));
            }
        }
    }
}

/// A budget that cuts the image into windows or its fragments into bands: the known one, or where that cuts nothing on
/// this device, one between a budget that is enough for all and one that is enough for nothing, found by bisection.
/// Each image on the way is compared. Returns the budgets that were searched for.
fn budgeted(device: &Device, all: &[Baseline], wrong: &mut Wrong) -> Budgets {
    let mut renderer = fresh(device);
    let (kept, mut searched) = (Budgets::read(), Budgets::default());
    for known in all {
        let whole = &known.first.facts;
        let (mut refused, mut enough) = (16u64 << 10, 4u64 << 20);
        let mut was_cut = false;
        let first = kept.of(&known.subject.name);
        for step in 0..13 {
            let budget = first.filter(|_| step == 0).unwrap_or_else(|| refused.midpoint(enough));
            let frame = Frame { memory_budget: Some(budget), ..known.subject.frame };
            match known.subject.with(frame).render_arranged(&mut renderer, &known.arranged) {
                Ok(rendered) => {
                    wrong.compare(known, &rendered.image, &format!("budget {budget}"));
                    was_cut = rendered.facts.windows > whole.windows || rendered.facts.bands > whole.bands;
                    enough = budget;
                }
                Err(error) if error.is_refusal() => refused = budget,
                Err(error) => wrong.0.push(format!("{}, budget {budget}: {error}", known.subject.name)),
            }
            if was_cut {
                if first != Some(budget) {
                    searched.add(&known.subject.name, budget);
                }
                break;
            }
        }
        if !was_cut {
            let name = &known.subject.name;
            wrong.0.push(format!("{name}: no budget cuts anything, {refused} is too little and {enough} enough"));
        }
    }
    searched
}

/// Runs everything so many times over.
fn sweep(times: usize) {
    by_halves(|half| {
        with_device(|device| {
            let (all, mut wrong) = (known(half, device), Wrong::default());
            repeated(device, all, times, &mut wrong);
            reordered(device, all, u32::try_from(times).expect("few"), &mut wrong);
            wrong.assert_none();
            assert_listed(device);
        });
    });
}

#[test]
fn the_same_bytes_whatever_ran_before_and_in_whatever_order() {
    // Forwards, backwards, and forwards after backwards.
    sweep(3);
}

#[test]
#[ignore = "takes minutes: everything 20 times"]
fn the_same_bytes_twenty_times() {
    sweep(20);
}

#[test]
fn the_same_bytes_however_the_work_is_cut() {
    let halves = by_halves(|half| {
        let mut all: &[Baseline] = &[];
        let mut result = None;
        with_device(|device| {
            all = known(half, device);
            let mut wrong = Wrong::default();
            let searched = budgeted(device, all, &mut wrong);
            let in_uploads = streamed(device, all, &mut wrong);
            otherwise(device, all, &mut wrong);
            wrong.assert_none();
            assert_listed(device);
            result = Some((searched, in_uploads, is_llvmpipe(device)));
        });
        // Arrays in slices, images in windows: chunks of points have at least 4096, of 20 bytes each. Where points are
        // streamed, as those of the crowd are above, an upload of 65 536 must.
        with_device_that_binds(Some(100_000), |device| {
            let mut wrong = Wrong::default();
            for known in all.iter().filter(|known| known.arranged.points().len() <= 65_536) {
                wrong.compare_frame(known, &mut fresh(device), known.subject.frame, "bindings of 100 000 bytes");
            }
            wrong.assert_none();
            assert_listed(device);
        });
        result
    });
    // Without a device both were skipped.
    if let [Some((mut searched, a, is_llvmpipe)), Some((more, b, _))] = halves {
        assert!(a + b > 0, "none has points enough to be streamed");
        searched.extend(more);
        budgets::judge(searched, SUBJECTS, is_llvmpipe);
    }
}

/// Compares the other shape of work than the device's own: what a GPU prefers, or a CPU.
#[test]
fn the_same_bytes_whatever_shape_of_work_a_device_prefers() {
    by_halves(|half| {
        let mut all: &[Baseline] = &[];
        let mut other = Preferences::GPU;
        with_device(|device| {
            all = known(half, device);
            if device.info().prefers == Preferences::GPU {
                other = Preferences::CPU;
            }
        });
        with_device_that_prefers(other, |device| {
            let mut wrong = Wrong::default();
            for known in all {
                wrong.compare_frame(known, &mut fresh(device), known.subject.frame, "work of another shape");
            }
            wrong.assert_none();
            assert_listed(device);
        });
    });
}

/// A budget in which a large cloud goes through the device in several uploads. Returns how many clouds are that large.
fn streamed(device: &Device, all: &[Baseline], wrong: &mut Wrong) -> usize {
    let dealt = all.iter().filter(|known| known.subject.frame.method.is_dealt());
    let crowded: Vec<&Baseline> = dealt.filter(|known| known.arranged.points().len() > 65_536).collect();
    for known in &crowded {
        let frame = Frame { memory_budget: Some(2 << 20), ..known.subject.frame };
        let facts = wrong.compare_frame(known, &mut fresh(device), frame, "streamed");
        assert!(facts.is_some_and(|facts| facts.streamed.is_some()), "{}: not streamed", known.subject.name);
    }
    crowded.len()
}

/// Compares with other atomics, with ensembles in two stages and with few epochs, and images without lists.
fn otherwise(device: &Device, all: &[Baseline], wrong: &mut Wrong) {
    type Change = fn(&mut Renderer);
    let changes: [(&str, Change); 3] = [
        ("32-bit atomics", |renderer| renderer.switches.wide_atomics = false),
        ("two stages", |renderer| renderer.switches.single_pass = false),
        ("few epochs", |renderer| renderer.switches.epoch_bits = 2),
    ];
    for known in all {
        for (how, change) in changes {
            let mut renderer = fresh(device);
            change(&mut renderer);
            wrong.compare_frame(known, &mut renderer, known.subject.frame, how);
        }
        let frame = Frame { fragments: false, ..known.subject.frame };
        let plain = known.subject.with(frame).render_arranged(&mut fresh(device), &known.arranged).expect("renders");
        let Image { fragments, layers, stderr, .. } = known.first.image.clone();
        wrong.compare(known, &Image { fragments, layers, stderr, ..plain.image }, "without lists");
    }
}

/// The choice of `auto` on a device depends on times. It must not show, except in tiles with long lists: one method
/// composes those in runs of 256, the other in runs over a tile's splats, which is another order of the same roundings.
#[test]
fn the_ways_between_which_auto_chooses_have_the_same_bytes_but_in_long_lists() {
    with_device(|device| {
        let subjects = check::subjects();
        let auto = subjects.iter().find(|s| matches!(s.choice, MethodChoice::Auto(_))).expect("one of `auto`");
        let render = |method| auto.with(Frame { method, ..auto.frame }).render(&mut fresh(device));
        let discs = Discs::default();
        let (sorted, abuffer) = match (render(Method::Sorted(discs)), render(Method::ABuffer(discs))) {
            (Ok(sorted), Ok(abuffer)) => (sorted.image, abuffer.image),
            (Err(error @ Error::NoSubgroups { .. }), _) => return println!("not applicable: {error}"),
            (sorted, abuffer) => panic!("{:?} {:?}", sorted.err(), abuffer.err()),
        };
        let (mut short, mut long) = (0, 0);
        assert_eq!((&sorted.depth, &sorted.fragments), (&abuffer.depth, &abuffer.fragments));
        // The knot with the long lists lies in a tile of more than 2048 splats, all of whose pixels are composed in
        // runs.
        let lengths: Vec<u32> = abuffer.fragments.iter().flatten().copied().collect();
        let tile = |pixel: usize| [pixel % abuffer.width as usize / 16, pixel / abuffer.width as usize / 16];
        let crowded: HashSet<_> = (0..lengths.len()).filter(|pixel| lengths[*pixel] > 256).map(tile).collect();
        for (pixel, length) in lengths.iter().enumerate() {
            let (a, b) = (sorted.rgba[pixel], abuffer.rgba[pixel]);
            if !crowded.contains(&tile(pixel)) {
                assert_eq!(a.map(f32::to_bits), b.map(f32::to_bits), "pixel {pixel}, {length} fragments");
                short += 1;
                continue;
            }
            // Of each fragment a difference, two products and a sum of values up to 1, rounded in either order.
            let bound = 2.0 * 4.0 * f64::from(*length) * f64::from(f32::EPSILON) / 2.0;
            let apart = a.iter().zip(b).map(|(a, b)| f64::from((a - b).abs())).fold(0.0, f64::max);
            assert!(apart <= bound, "pixel {pixel}, {length} fragments: {apart}");
            long += 1;
        }
        // One tile, the rest of the image to the bit.
        assert_eq!((short, long), (56 * 40 - 256, 256));
    });
}

/// A wrong image among the runs is found and named.
#[test]
fn one_changed_bit_is_reported() {
    with_device(|device| {
        let subject = check::subjects().into_iter().find(|s| s.name == "abuffer, oriented").expect("in the list");
        let arranged = subject.arranged();
        let first = subject.render_arranged(&mut fresh(device), &arranged).expect("renders");
        let mut other = first.image.clone();
        let known = Baseline { subject, arranged, first };
        let place = 11 * other.width as usize + 30;
        let green = &mut other.rgba[place][1];
        *green = f32::from_bits(green.to_bits() ^ 1);
        let mut wrong = Wrong::default();
        wrong.compare(&known, &known.first.image.clone(), "the same");
        assert!(wrong.0.is_empty());
        wrong.compare(&known, &other, "one bit");
        assert_eq!(wrong.0.len(), 1);
        let text = &wrong.0[0];
        assert!(text.starts_with("abuffer, oriented, one bit: pixel (30, 11), G: "), "{text}");
        assert!(text.ends_with("; 1 of 2240 pixels differ"), "{text}");
    });
}
