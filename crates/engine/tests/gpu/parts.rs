//! Random samples that are drawn in parts, by renderers with other budgets and switches, and put together in any order:
//! the bytes of the frame that is drawn at once.

use std::ops::Range;
use std::sync::Arc;

use glam::{DVec3, Vec3};
use pellucid_core::image::Image;
use pellucid_core::points::Points;
use pellucid_engine::methods::spbr::Form;
use pellucid_engine::methods::{DrawnPart, Error, Frame, PartError, Renderer, SamplePart, SampleSteps};
use pellucid_engine::passes::project::DeviceCloud;
use pellucid_gpu::Device;
use pellucid_scene::prepare::Arranged;
use pellucid_scene::prepare::ensembles::Dealt;
use pellucid_scene::{
    DiscShape, Discs, Light, Method, Raster, Shading, ShadingModel, Spbr, SpbrSimplified, Stochastic,
};
use pellucid_testing::*;
use rand::RngExt;
use rand::seq::SliceRandom;

use crate::spbr::{camera, dealt, mixture, plane, planes};

const SIZE: [u32; 2] = [80, 60];

/// All that an image has.
fn all(image: &Image) -> Vec<u32> {
    let errors = image.stderr.iter().flatten().flatten().map(|e| e.to_bits());
    bits(image).into_iter().chain(errors).chain(image.fragments.iter().flatten().copied()).collect()
}

/// So many parts of all samples, of unequal size.
fn parts_of(SampleSteps { total, step }: SampleSteps, count: usize, seed: u64) -> Vec<Range<u32>> {
    let mut r = random(seed);
    let mut cuts: Vec<u32> = (1..count).map(|_| r.random_range(0..=total.div_ceil(step)) * step).collect();
    cuts.extend([0, total]);
    cuts.iter_mut().for_each(|cut| *cut = total.min(*cut));
    cuts.sort_unstable();
    cuts.windows(2).map(|cut| cut[0]..cut[1]).collect()
}

/// A renderer with points on it, and the budget that it keeps.
struct Rank {
    renderer: Renderer,
    cloud: DeviceCloud,
    budget: Option<u64>,
}

impl Rank {
    fn new(device: &Device, upload: impl Fn(&Renderer) -> DeviceCloud, budget: Option<u64>) -> Self {
        let renderer = Renderer::new(device).expect("a renderer");
        let cloud = upload(&renderer);
        Self { renderer, cloud, budget }
    }

    fn frame(&self, frame: &Frame) -> Frame {
        Frame { memory_budget: self.budget, ..*frame }
    }

    fn render(&mut self, frame: &Frame) -> Image {
        let frame = self.frame(frame);
        self.renderer.render(&mut self.cloud, &frame).expect("renders").image
    }

    fn draw(&mut self, frame: &Frame, samples: Range<u32>) -> DrawnPart {
        let frame = self.frame(frame);
        self.renderer.draw_part(&mut self.cloud, &frame, samples).expect("draws")
    }

    /// A part that went through bytes.
    fn part(&mut self, frame: &Frame, samples: Range<u32>) -> SamplePart {
        let drawn = self.draw(frame, samples.clone());
        let count = samples.end - samples.start;
        assert!(drawn.facts.samples.max(drawn.facts.ensembles) == count, "{samples:?}: {:?}", drawn.facts);
        assert!(drawn.profile.passes.iter().all(|pass| !pass.name.ends_with("/resolve")));
        let part = part_of(&bytes_of(&drawn.part)).expect("the bytes of a part");
        assert!(part == drawn.part);
        part
    }

    fn resolve(&mut self, frame: &Frame, parts: &SamplePart) -> Result<Image, Error> {
        let frame = self.frame(frame);
        Ok(self.renderer.resolve_parts(&self.cloud, &frame, parts)?.image)
    }
}

fn bytes_of(part: &SamplePart) -> Vec<u8> {
    postcard::to_allocvec(part).expect("bytes")
}

fn part_of(bytes: &[u8]) -> Result<SamplePart, postcard::Error> {
    postcard::from_bytes(bytes)
}

fn together(parts: &[SamplePart]) -> SamplePart {
    let mut all = parts[0].clone();
    parts[1..].iter().for_each(|part| all.add(part.clone()).expect("other samples"));
    all
}

/// Draws a frame in parts, each by another one of the ranks, and compares the bytes with those of each rank's own
/// image.
fn compare(ranks: &mut [Rank], frame: &Frame, what: &str) {
    let steps = frame.sample_steps().expect("samples");
    let expected = ranks[0].render(frame);
    for rank in &mut ranks[1..] {
        assert!(all(&rank.render(frame)) == all(&expected), "{what}: {:?} renders something else", rank.budget);
    }
    for (count, seed) in [(1, 1), (2, 2), (5, 4)] {
        let cuts = parts_of(steps, count, seed);
        let count = ranks.len();
        let draw = |(i, samples): (usize, &Range<u32>)| ranks[i % count].part(frame, samples.clone());
        let mut parts: Vec<SamplePart> = cuts.iter().enumerate().map(draw).collect();
        parts.shuffle(&mut random(seed));
        let sum = together(&parts);
        for rank in ranks.iter_mut() {
            let found = rank.resolve(frame, &sum).expect("resolves");
            assert!(all(&found) == all(&expected), "{what}: {cuts:?}, resolved with {:?}", rank.budget);
            assert_eq!(found.stderr.is_some(), expected.stderr.is_some());
            assert_eq!(found.fragments.is_some(), expected.fragments.is_some());
        }
    }
    // The next frames of the renderers are as before.
    assert!(all(&ranks[0].render(frame)) == all(&expected), "{what}: after parts");
}

fn dealt_ranks(device: &Device, list: &Dealt, budgets: &[Option<u64>]) -> Vec<Rank> {
    let upload = |renderer: &Renderer| renderer.upload(&Arranged::Dealt(list.clone())).expect("fits");
    budgets.iter().map(|budget| Rank::new(device, upload, *budget)).collect()
}

const LAMBERT: Shading = Shading { model: ShadingModel::Lambert, light: Light::Headlight, ..Shading::NONE };

#[test]
fn parts_of_ensembles_are_the_whole() {
    with_device(|device| {
        let list = mixture(4);
        let methods = [
            Method::Spbr(Spbr { ensembles: 20, cos_theta: false, brighten: false }),
            Method::SpbrSimplified(SpbrSimplified { ensembles: 7, ..SpbrSimplified::default() }),
            Method::Spbr(Spbr { ensembles: 1, ..Spbr::default() }),
        ];
        for (method, shading, spread, ensembles) in [
            (methods[0], Shading::NONE, true, None),
            (methods[0], LAMBERT, false, None),
            (methods[0], Shading::NONE, false, Some(9)),
            (methods[1], LAMBERT, true, None),
            (methods[2], Shading::NONE, true, None),
        ] {
            // In several windows, in one, with and without atomics of 64 bits, in one go and in two stages.
            let mut ranks = dealt_ranks(device, &list, &[None, Some(200_000), None, None, Some(3_000_000)]);
            ranks[2].renderer.switches.wide_atomics = false;
            ranks[3].renderer.switches.single_pass = false;
            let frame = frame(camera(2.2, true), SIZE, method);
            let frame = Frame { shading, spread, ensembles, fragments: false, seed: 11, ..frame };
            assert!(ranks[1].draw(&frame, 0..1).facts.windows > 1);
            compare(&mut ranks, &frame, &format!("{method:?}, spread {spread}"));
        }
    });
}

#[test]
fn a_part_draws_its_own_points_alone() {
    with_device(|device| {
        let list = mixture(4);
        let mut rank = dealt_ranks(device, &list, &[None]).remove(0);
        let frame = frame(camera(4.0, true), SIZE, Method::Spbr(Spbr { ensembles: 20, ..Spbr::default() }));
        let whole = rank.renderer.render(&mut rank.cloud, &frame).expect("renders").facts;
        let mut of = |samples| rank.renderer.draw_part(&mut rank.cloud, &frame, samples).expect("draws").facts;
        let parts = [of(0..3), of(3..11), of(11..20)];
        assert_eq!(parts.iter().map(|facts| facts.slots).sum::<u64>(), whole.slots);
        assert_eq!(parts.iter().map(|facts| facts.visible).sum::<u64>(), whole.visible);
        assert_eq!((of(5..5).slots, of(20..20).visible), (0, 0));
    });
}

#[test]
fn parts_of_ensembles_whose_epochs_run_out_are_the_whole() {
    with_device(|device| {
        // Enough points that an ensemble is a round by itself, its nearest points beside the sums.
        let sides = [4.0 * DVec3::X, 3.0 * DVec3::Y];
        let list = dealt(&[plane(10, 300_000, sides, DVec3::ZERO, Vec3::ONE, 0.99)]);
        let mut ranks = dealt_ranks(device, &list, &[None, None]);
        let frame = frame(camera(4.0, true), SIZE, Method::Spbr(Spbr { ensembles: 5, ..Spbr::default() }));
        ranks[1].renderer.switches.epoch_bits = 1;
        let drawn = ranks[1].draw(&frame, 0..4).facts;
        assert!(drawn.renewed && drawn.form == Some(Form::Single), "{drawn:?}");
        compare(&mut ranks, &frame, "epochs");
    });
}

#[test]
fn parts_of_streamed_points_are_the_whole() {
    with_device(|device| {
        let list = planes(11, &[(70_000, 0.2), (1000, 1.6), (40_000, 2.4)], true);
        let mut ranks = dealt_ranks(device, &list, &[None, Some(4 << 20)]);
        let method = Method::Spbr(Spbr { ensembles: 9, cos_theta: false, brighten: false });
        let frame = Frame { shading: LAMBERT, ..frame(camera(4.0, true), SIZE, method) };
        assert!(ranks[1].draw(&frame, 2..5).facts.streamed.is_some());
        compare(&mut ranks, &frame, "streamed");
    });
}

fn crowd() -> Points {
    // More splats in a tile than one run takes, and pixels without any.
    scene(&[soup(31, 400, 0.001..0.5, 0.1..0.9, true), soup(32, 3000, 0.1..0.2, 0.001..0.01, true)].concat())
}

fn sampled_ranks(device: &Device, points: &Points, budgets: &[Option<u64>]) -> Vec<Rank> {
    let upload = |renderer: &Renderer| renderer.upload(points).expect("fits");
    budgets.iter().map(|budget| Rank::new(device, upload, *budget)).collect()
}

fn stochastic(discs: Discs, samples: u32, alpha_correction: bool) -> Method {
    Method::Stochastic(Stochastic { discs, samples, alpha_correction })
}

#[test]
fn parts_of_samples_are_the_whole() {
    with_device(|device| {
        let points = crowd();
        let size = [150, 100];
        let oriented = Discs { shape: DiscShape::Oriented, ..Discs::default() };
        for (discs, samples, correction, spread, fragments) in [
            (Discs::default(), 70, true, true, true),
            (oriented, 70, false, true, false),
            (oriented, 64, true, false, false),
            (Discs::default(), 33, false, false, false),
            (Discs::default(), 4, true, true, true),
            (Discs::default(), 16, false, false, true),
        ] {
            let mut ranks = sampled_ranks(device, &points, &[None, Some(3_000_000)]);
            let method = stochastic(discs, samples, correction);
            let frame = Frame { seed: 5, spread, fragments, ..frame(perspective(), size, method) };
            compare(&mut ranks, &frame, &format!("{samples} samples, {correction}, {spread}, {fragments}"));
            assert!(ranks[1].draw(&frame, 0..samples.min(16)).facts.windows > 1);
        }
    });
}

#[test]
fn parts_of_samples_of_the_rasteriser_are_the_whole() {
    with_device(|device| {
        if device.info().multisampled.is_none() {
            return;
        }
        let points = crowd();
        for (shape, samples, correction, fragments) in [
            (DiscShape::Flat, 70, true, true),
            (DiscShape::Oriented, 41, false, true),
            (DiscShape::Flat, 32, true, false),
        ] {
            let discs = Discs { shape, raster: Raster::Hardware, ..Discs::default() };
            let frame = frame(perspective(), [90, 60], stochastic(discs, samples, correction));
            let frame = Frame { seed: 5, fragments, ..frame };
            let mut ranks = sampled_ranks(device, &points, &[None, Some(3_000_000)]);
            assert_eq!(ranks[1].draw(&frame, 16..32).facts.raster, "hardware");
            compare(&mut ranks, &frame, &format!("{shape:?}, {samples} samples, {correction}"));
        }
    });
}

#[test]
fn parts_of_samples_of_points_that_come_window_by_window_are_the_whole() {
    with_device(|device| {
        let points = Arc::new(crowd());
        let upload = |renderer: &Renderer| by_windows(renderer, &points);
        let mut ranks: Vec<Rank> = [None, Some(900_000)].map(|budget| Rank::new(device, upload, budget)).into();
        let frame = frame(perspective(), [150, 100], stochastic(Discs::default(), 40, true));
        compare(&mut ranks, &frame, "supplied");
    });
}

/// Windows without splats have the bytes of pixels without splats.
#[test]
fn parts_of_samples_where_nothing_is_are_the_whole() {
    with_device(|device| {
        let all_behind = [P { position: DVec3::new(0.0, 0.0, 1e6), ..soup(1, 1, 0.1..0.2, 0.1..0.2, true)[0] }];
        let corner = soup(1, 1, 0.01..0.02, 0.5..0.6, true);
        for (i, dots) in [&all_behind[..], &corner[..]].into_iter().enumerate() {
            for (j, (samples, correction)) in [(4, true), (3, false), (40, true), (40, false)].into_iter().enumerate() {
                // By turns, so that every pair of points, samples and rasterizer is met.
                let raster = [Raster::Compute, Raster::Auto][(i + j) % 2];
                let discs = Discs { raster, ..Discs::default() };
                let mut ranks = sampled_ranks(device, &scene(dots), &[None, Some(100_000)]);
                let frame = frame(perspective(), [75, 50], stochastic(discs, samples, correction));
                compare(&mut ranks, &frame, &format!("{samples} samples, {correction}"));
                let facts = ranks[1].draw(&frame, 0..samples.min(16)).facts;
                println!("{samples} samples, {correction}: {} windows", facts.windows);
                assert!(facts.windows > 1, "{facts:?}");
            }
        }
    });
}

#[test]
fn parts_that_are_no_whole_are_refused() {
    with_device(|device| {
        let method = Method::Spbr(Spbr { ensembles: 9, ..Spbr::default() });
        let ensembles = (dealt_ranks(device, &mixture(4), &[None]).remove(0), frame(camera(4.0, true), SIZE, method));
        let method = stochastic(Discs::default(), 40, true);
        let sampled = (sampled_ranks(device, &crowd(), &[None]).remove(0), frame(perspective(), SIZE, method));
        for ((mut rank, frame), cuts) in
            [(ensembles, [0..3, 3..3, 3..8, 8..9]), (sampled, [0..16, 16..16, 16..32, 32..40])]
        {
            let parts = cuts.map(|samples| rank.part(&frame, samples));
            let expected = all(&rank.render(&frame));
            let sum = together(&parts);
            assert!(all(&rank.resolve(&frame, &sum).expect("a whole")) == expected);
            // Without an empty part it is the same, without another one no whole.
            for missing in 0..4 {
                let some: Vec<SamplePart> = (0..4).filter(|i| *i != missing).map(|i| parts[i].clone()).collect();
                let resolved = rank.resolve(&frame, &together(&some));
                if missing == 1 {
                    assert!(all(&resolved.expect("a whole")) == expected);
                    continue;
                }
                let is_missing = matches!(resolved, Err(Error::Part(PartError::Missing { .. })));
                assert!(is_missing, "without part {missing}: {:?}", resolved.map(|_| ()));
                let twice = together(&parts[..=missing]).add(parts[missing].clone());
                assert!(matches!(twice, Err(PartError::Twice { .. })), "{twice:?}");
            }
            // Of another frame.
            for other in [
                Frame { size: [81, 60], ..frame },
                Frame { fragments: !frame.fragments, ..frame },
                Frame { method: stochastic(Discs::default(), 41, true), ..frame },
                Frame { method: stochastic(Discs::default(), 40, false), ..frame },
                Frame { ensembles: Some(8), method: Method::Spbr(Spbr { ensembles: 9, ..Spbr::default() }), ..frame },
            ] {
                let resolved = rank.resolve(&other, &sum);
                assert!(matches!(resolved, Err(Error::Part(PartError::Different))), "{other:?}");
            }
            // Half of the bytes; and a word that is another one shows in the image.
            let bytes = bytes_of(&sum);
            assert!(part_of(&bytes[..bytes.len() / 2]).is_err());
            let middle = bytes.len() - 4 * SIZE[0] as usize * SIZE[1] as usize / 2;
            let changed = (0..2000).any(|word| {
                let mut damaged = bytes.clone();
                damaged[middle + 4 * word + 2] ^= 0x10;
                let sum = part_of(&damaged).expect("the same size");
                all(&rank.resolve(&frame, &sum).expect("a whole")) != expected
            });
            assert!(changed);
        }
    });
}

#[test]
fn samples_that_are_no_part_are_refused() {
    with_device(|device| {
        let mut rank = sampled_ranks(device, &crowd(), &[None]).remove(0);
        let whole = frame(perspective(), SIZE, stochastic(Discs::default(), 40, true));
        assert_eq!(whole.sample_steps(), Some(SampleSteps { total: 40, step: 16 }));
        let mut draw = |frame: &Frame, samples| rank.renderer.draw_part(&mut rank.cloud, frame, samples).map(|_| ());
        for samples in [0..8, 8..16, 0..41, 40..48, 48..48] {
            assert!(matches!(draw(&whole, samples), Err(Error::SampleRange { total: 40, step: 16, .. })));
        }
        // A number of samples that follows from the image, and methods without samples.
        let rounds = Frame { max_error: Some(0.01), ..whole };
        assert!(rounds.sample_steps().is_none());
        assert!(matches!(draw(&rounds, 0..16), Err(Error::NoParts { method: "stochastic" })));
        for method in Method::all() {
            let steps = Frame { method, ..whole }.sample_steps();
            let is_random = method.is_dealt() || matches!(method, Method::Stochastic(_));
            assert_eq!(steps.is_some(), is_random, "{}", method.name());
            if let Some(SampleSteps { total, step }) = steps {
                assert!(total >= 1 && step == if method.is_dealt() { 1 } else { 16 });
            }
        }
        let few = Frame { ensembles: Some(3), method: Method::Spbr(Spbr::default()), ..whole };
        assert_eq!(few.sample_steps(), Some(SampleSteps { total: 3, step: 1 }));
        // A renderer that refused goes on.
        draw(&whole, 16..40).expect("draws");
    });
}
