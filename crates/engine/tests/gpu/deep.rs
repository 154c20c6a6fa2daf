//! Deep images: they flatten in float64 to the image, as many samples as fragments, tidy where they are said to be, and
//! the same whatever the memory, the order of the points, and whether they come window by window.

use std::sync::Arc;

use glam::DVec3;
use pellucid_core::image::Image;
use pellucid_core::points::Points;
use pellucid_engine::methods::{Error, Frame, Renderer, deep};
use pellucid_engine::passes::project::DeviceCloud;
use pellucid_gpu::Device;
use pellucid_io::output::deep::{Sample, State};
use pellucid_reference::range::ROUNDING;
use pellucid_scene::prepare::order;
use pellucid_scene::{Density, DiscShape, Discs, GaussianSettings, Kernel, Method, Order, Peel, Shells, Soft};
use pellucid_testing::gaussians::Soup;
use pellucid_testing::*;
use rand::seq::SliceRandom;

const STATES: [State; 2] = [State::Tidy, State::Sorted];

/// The samples of each pixel.
type Lists = Vec<Vec<Sample>>;

fn taken(renderer: &mut Renderer, cloud: &mut DeviceCloud, frame: &Frame, state: State) -> Result<Lists, Error> {
    let mut lists = Lists::new();
    let facts = renderer.deep(cloud, frame, state, &mut |lengths, mut samples| {
        for length in lengths {
            let (list, rest) = samples.split_at(*length as usize);
            lists.push(list.to_vec());
            samples = rest;
        }
        assert!(samples.is_empty());
        Ok(())
    })?;
    let most = renderer.most_samples(cloud, frame, state)?;
    let count: usize = lists.iter().map(Vec::len).sum();
    assert!(count as u64 <= most, "{count} samples are more than {most}");
    assert!(facts.bands >= facts.windows.min(1), "{facts:?}");
    assert_eq!(lists.len() as u32, frame.size[0] * frame.size[1]);
    Ok(lists)
}

fn deep_of(device: &Device, points: &Points, frame: &Frame, state: State) -> Lists {
    let mut renderer = Renderer::new(device).expect("a renderer");
    let mut cloud = renderer.upload(points).expect("the cloud fits");
    taken(&mut renderer, &mut cloud, frame, state).expect("the frame has samples")
}

/// Samples that are sorted and apart, over one another.
fn over(list: &[Sample]) -> [f64; 4] {
    list.iter().fold([0.0; 4], |front, sample| {
        std::array::from_fn(|c| front[c] + (1.0 - front[3]) * f64::from(sample.rgba[c]))
    })
}

/// Flattens samples that may overlap, as OpenEXR's "Interpreting Deep Pixels" says: each is cut wherever another one
/// begins or ends, and pieces of the same range are mixed by their optical depths.
fn mixed(list: &[Sample]) -> [f64; 4] {
    let mut ends: Vec<f32> = list.iter().flat_map(|s| [s.depth, s.back]).collect();
    ends.sort_by(f32::total_cmp);
    ends.dedup();
    let mut front = [0.0; 4];
    let mut behind = |rgba: [f64; 4]| front = std::array::from_fn(|c| front[c] + (1.0 - front[3]) * rgba[c]);
    for (i, &at) in ends.iter().enumerate() {
        // Surfaces at one place stay in the order of blending.
        list.iter().filter(|s| s.depth == at && s.back == at).for_each(|s| behind(s.rgba.map(f64::from)));
        let Some(&next) = ends.get(i + 1) else { continue };
        let mut optical = [0.0; 4];
        for s in list.iter().filter(|s| s.depth <= at && s.back >= next) {
            let alpha = f64::from(s.rgba[3]);
            let whole = -(-alpha).ln_1p();
            let part = whole * (f64::from(next) - f64::from(at)) / (f64::from(s.back) - f64::from(s.depth));
            let straight = |c: usize| if c == 3 { 1.0 } else { f64::from(s.rgba[c]) / alpha.max(1e-300) };
            optical.iter_mut().enumerate().for_each(|(c, sum)| *sum += part * straight(c));
        }
        if optical[3] > 0.0 {
            let alpha = -(-optical[3]).exp_m1();
            behind(optical.map(|sum| alpha * sum / optical[3]));
        }
    }
    front
}

/// The image's float32 sums of n fragments: three roundings of numbers up to 1 for each, in A and in a color, where an
/// error of A counts at most once more by all weights behind it; and one or two roundings of the samples themselves.
fn slack(list: &[Sample], brightest: f64) -> f64 {
    8.0 * (list.len() as f64 + 2.0) * ROUNDING * brightest.max(1.0)
}

/// Asserts that lists flatten to an image, within a slack for each list.
#[track_caller]
fn assert_flattens(
    image: &Image,
    lists: &Lists,
    flat: impl Fn(&[Sample]) -> [f64; 4],
    slack: impl Fn(&[Sample]) -> f64,
) {
    for (pixel, list) in lists.iter().enumerate() {
        let (found, wanted, allowed) = (flat(list), image.rgba[pixel], slack(list));
        for c in 0..4 {
            let off = (found[c] - f64::from(wanted[c])).abs();
            assert!(off <= allowed, "pixel {pixel}: {found:?} {wanted:?}, {} samples, {off} > {allowed}", list.len());
        }
    }
}

/// Asserts the order that a state promises, as ImfDeepImageState.h words it.
#[track_caller]
fn assert_state(lists: &Lists, state: State) {
    for list in lists {
        assert!(
            list.iter().all(|s| s.depth > 0.0 && s.back >= s.depth && (0.0..=1.0).contains(&s.rgba[3])),
            "{list:?}"
        );
        for pair in list.windows(2) {
            let [a, b] = [pair[0], pair[1]];
            let sorted = a.depth < b.depth || (a.depth == b.depth && a.back <= b.back);
            let apart = (a.depth < b.depth && a.back <= b.depth)
                || (a.depth == b.depth && a.back <= a.depth && b.back > b.depth);
            assert!(if state == State::Tidy { sorted && apart } else { sorted }, "{state:?}: {a:?} {b:?}");
        }
    }
}

fn count(lists: &Lists) -> Vec<u32> {
    lists.iter().map(|list| list.len() as u32).collect()
}

fn bits_of(lists: &Lists) -> Vec<Vec<[u32; 6]>> {
    let words = |s: &Sample| [s.rgba[0], s.rgba[1], s.rgba[2], s.rgba[3], s.depth, s.back].map(f32::to_bits);
    lists.iter().map(|list| list.iter().map(words).collect()).collect()
}

/// Short and long lists, discs larger than a tile, some without opacity, some opaque, and pairs at one place.
fn discs() -> Points {
    let mut points = [soup(1, 400, 0.02..0.2, 0.2..1.0, true), soup(2, 1500, 0.5..0.9, 0.0..0.02, true)].concat();
    points.iter_mut().step_by(50).for_each(|p| p.opacity = 0.0);
    points.iter_mut().skip(1).step_by(50).for_each(|p| p.opacity = 1.0);
    points.extend(soup(1, 40, 0.02..0.2, 0.3..0.5, true));
    scene(&points)
}

fn peeled(discs: Discs, layers: u32) -> Method {
    Method::Peel(Peel { discs, layers })
}

#[test]
fn samples_are_the_fragments_and_flatten_to_the_image() {
    with_device(|device| {
        let points = discs();
        let mut longest = 0;
        for (i, camera) in [perspective(), orthographic()].into_iter().enumerate() {
            for (j, discs) in all_discs().filter(|discs| discs.raster == RASTERS[0]).enumerate() {
                let mut others = vec![Method::LinkedList(discs), peeled(discs, 0)];
                // Oriented discs that cross are blended in another order.
                others.extend((discs.shape == DiscShape::Flat).then_some(Method::Sorted(discs)));
                // By turns: every pair of camera, discs and method.
                let others = others.into_iter().skip((i + j) % 2).step_by(2);
                let mut first = None;
                for method in [Method::ABuffer(discs)].into_iter().chain(others) {
                    let frame = frame(camera, [40, 30], method);
                    let image = render(device, &points, &frame);
                    let [tidy, sorted] = STATES.map(|state| deep_of(device, &points, &frame, state));
                    for (lists, state) in [(&tidy, State::Tidy), (&sorted, State::Sorted)] {
                        assert_state(lists, state);
                        assert_flattens(&image, lists, over, |list| slack(list, 1.0));
                    }
                    assert_eq!(Some(&count(&sorted)), image.fragments.as_ref(), "{}", method.name());
                    assert!(sorted.iter().flatten().all(|s| s.depth == s.back), "surfaces");
                    // Merged fragments are at one depth.
                    let depths = |list: &Vec<Sample>| {
                        let mut depths: Vec<_> = list.iter().map(|s| s.depth.to_bits()).collect();
                        depths.dedup();
                        depths
                    };
                    assert!(sorted.iter().map(depths).eq(tidy.iter().map(depths)));
                    assert!(count(&tidy) != count(&sorted), "some points are at one place");
                    longest = longest.max(count(&sorted).into_iter().max().unwrap_or(0));
                    assert!(
                        *first.get_or_insert_with(|| bits_of(&sorted)) == bits_of(&sorted),
                        "the same by each method"
                    );
                }
            }
        }
        assert!(longest > 512, "{longest}: three runs");
    });
}

#[test]
fn the_nearest_sample_has_the_depth_of_the_image() {
    with_device(|device| {
        let frame = frame(perspective(), [40, 30], Method::ABuffer(Discs::default()));
        let points = discs();
        let image = render(device, &points, &frame);
        for (list, z) in deep_of(device, &points, &frame, State::Sorted).iter().zip(&image.depth) {
            let shown = list.iter().find(|s| s.rgba[3] > 0.0).map_or(f32::INFINITY, |s| s.depth);
            assert_eq!(shown, *z);
        }
    });
}

#[test]
fn only_the_peeled_layers_are_written() {
    with_device(|device| {
        let points = discs();
        for layers in [1, 3, 300] {
            for shape in SHAPES {
                let frame = frame(perspective(), [40, 30], peeled(Discs { shape, ..Discs::default() }, layers));
                let image = render(device, &points, &frame);
                let lists = deep_of(device, &points, &frame, State::Sorted);
                assert_flattens(&image, &lists, over, |list| slack(list, 1.0));
                let [lengths, layered] =
                    [&image.fragments, &image.layers].map(|counts| counts.as_ref().expect("counted"));
                for (pixel, count) in count(&lists).into_iter().enumerate() {
                    // Peeling ends where nothing shows any more.
                    let blended = layered[pixel] == count || (image.rgba[pixel][3] == 1.0 && layered[pixel] < count);
                    assert!(count == layers.min(lengths[pixel]) && blended, "{count} {}", layered[pixel]);
                }
                let tidy = deep_of(device, &points, &frame, State::Tidy);
                assert_flattens(&image, &tidy, over, |list| slack(list, 1.0));
            }
        }
    });
}

#[test]
fn lists_of_gaussians_end_where_the_image_does() {
    with_device(|device| {
        let soup = Soup { seed: 5, count: 900, extents: 0.1..0.6, opacities: 0.0..0.1, degree: 0 };
        let mut all = soup.unordered();
        all.append(scene(&soup_of_discs()));
        let points = order::canonical(all);
        for order in [Order::Center, Order::Pixel] {
            for stop in [0.0, 0.3, 0.01] {
                let gaussians = GaussianSettings { order: Some(order), stop, ..GaussianSettings::default() };
                let frame = frame(perspective(), [24, 18], Method::ABuffer(Discs { gaussians, ..Discs::default() }));
                let image = render(device, &points, &frame);
                for state in STATES {
                    let lists = deep_of(device, &points, &frame, state);
                    assert_state(&lists, state);
                    // Of harmonics nothing is brighter than 1 here.
                    assert_flattens(&image, &lists, over, |list| slack(list, 1.0));
                    let total: u32 = count(&lists).iter().sum();
                    let all: u32 = image.fragments.iter().flatten().sum();
                    let cut = total < all;
                    assert!(state == State::Tidy || cut == (stop > 0.0), "{total} of {all} fragments at {stop}");
                }
            }
        }
    });
}

fn soup_of_discs() -> Vec<P> {
    soup(71, 60, 0.05..0.3, 0.2..0.8, true)
}

/// Ellipsoids, some of them flat, some opaque, with discs between them.
fn ellipsoids(soup: &Soup) -> Points {
    let mut all = soup.unordered();
    let gaussians = all.gaussians.as_mut().expect("Gaussians");
    gaussians.extents.iter_mut().step_by(7).for_each(|extents| extents.y = 0.0);
    all.opacities.iter_mut().skip(1).step_by(40).for_each(|opacity| *opacity = 1.0);
    all.append(scene(&soup_of_discs()));
    order::canonical(all)
}

fn of_ellipsoids() -> Discs {
    let gaussians = GaussianSettings { kernel: Kernel::Ellipsoid, ..GaussianSettings::default() };
    Discs { gaussians, ..Discs::default() }
}

/// Error of the samples' optical depths from rounding their ends to float32: each piece is cut by two of them, whose
/// place and so the piece's length are only known to a rounding of the depth.
fn moved(list: &[Sample]) -> f64 {
    let each = |s: &Sample| {
        let (depth, back) = (f64::from(s.depth), f64::from(s.back));
        let optical = -(-f64::from(s.rgba[3]).min(0.999_999)).ln_1p();
        if back > depth { 2.0 * ROUNDING * back * optical / (back - depth) } else { 0.0 }
    };
    list.iter().map(each).sum::<f64>().min(1.0)
}

#[test]
fn ellipsoids_are_volumes_that_split_where_others_end() {
    with_device(|device| {
        let soups = [
            (Soup { seed: 21, count: 150, extents: 0.1..0.4, ..Soup::default() }, [40, 30]),
            // Lists of more than a run.
            (Soup { seed: 22, count: 900, extents: 0.4..1.2, opacities: 0.0..0.05, ..Soup::default() }, [8, 6]),
        ];
        for (soup, size) in soups {
            let points = ellipsoids(&soup);
            for camera in [perspective(), orthographic()] {
                let frame = frame(camera, size, Method::ABuffer(of_ellipsoids()));
                let image = render(device, &points, &frame);
                let tidy = deep_of(device, &points, &frame, State::Tidy);
                assert_state(&tidy, State::Tidy);
                // The device cut them: nothing but its sums is left.
                assert_flattens(&image, &tidy, over, |list| slack(list, 1.0));
                assert!(
                    tidy.iter().flatten().any(|s| s.back > s.depth) && tidy.iter().flatten().any(|s| s.back == s.depth)
                );
                let bodies = deep_of(device, &points, &frame, State::Sorted);
                assert_state(&bodies, State::Sorted);
                assert_eq!(Some(&count(&bodies)), image.fragments.as_ref());
                assert!(count(&bodies).into_iter().max() > Some(if soup.seed == 21 { 10 } else { 256 }));
                // Bodies that begin together may be in another order than surfaces among them, which roundings decide.
                assert_flattens(&image, &bodies, mixed, |list| slack(list, 1.0) + 2.0 * moved(list));
                let linked = Frame { method: Method::LinkedList(of_ellipsoids()), ..frame };
                assert!(bits_of(&deep_of(device, &points, &linked, State::Tidy)) == bits_of(&tidy));
            }
        }
    });
}

/// Spheres, solid ones among them if `solid`.
fn spheres(count: usize, solid: bool) -> Points {
    let all = soup(31, count, 0.1..0.5, 0.1..0.9, false);
    let field = |i: usize| if solid && i.is_multiple_of(9) { 0.1 } else { 0.9 };
    order::canonical(Points {
        positions: all.iter().map(|p| p.position).collect(),
        colors: all.iter().map(|p| p.color).collect(),
        opacities: vec![1.0; count],
        radii: all.iter().map(|p| p.radius).collect(),
        fields: (0..count).map(field).collect(),
        ..Points::default()
    })
}

#[test]
fn shells_are_volumes_before_solid_points() {
    with_device(|device| {
        for (count_of, solid, size) in [(60, true, [40, 30]), (60, false, [40, 30]), (2000, false, [12, 9])] {
            let points = spheres(count_of, solid);
            for shells in [Shells::Fixed(1), Shells::Fixed(3), Shells::Adaptive] {
                let soft = Soft { shells, density: Density::Softness(0.2), ..Soft::default() };
                let frame = frame(perspective(), size, Method::SoftConcentric(soft));
                let image = render(device, &points, &frame);
                let lists = deep_of(device, &points, &frame, State::Tidy);
                assert_state(&lists, State::Tidy);
                // The image rounds the depths of events of long lists, by which lengths of pieces move.
                assert_flattens(&image, &lists, over, |list| slack(list, 1.0) + 2.0 * moved(list));
                let [walls, volumes] =
                    [|s: &Sample| s.back == s.depth && s.rgba[3] == 1.0, |s: &Sample| s.back > s.depth];
                assert!(lists.iter().flatten().any(walls) == solid && lists.iter().flatten().any(volumes));
                let longest = lists.iter().map(Vec::len).max().unwrap_or(0);
                assert!(count_of < 2000 || longest > 256, "{longest}: more than a run");
            }
        }
        // None is soft.
        let frame = frame(perspective(), [40, 30], Method::SoftConcentric(Soft { threshold: 1.0, ..Soft::default() }));
        let points = spheres(60, true);
        let lists = deep_of(device, &points, &frame, State::Tidy);
        assert_flattens(&render(device, &points, &frame), &lists, over, |_| ROUNDING);
        assert!(lists.iter().any(|list| list.len() == 1));
    });
}

#[test]
fn the_same_bytes_in_any_memory_and_from_any_order() {
    with_device(|device| {
        let soup = Soup { seed: 31, count: 300, degree: 1, extents: 0.05..0.6, opacities: 0.0..0.3 };
        let soft = Method::SoftConcentric(Soft { shells: Shells::Fixed(2), ..Soft::default() });
        let cases = [
            (discs(), Method::ABuffer(Discs::default())),
            (ellipsoids(&soup), Method::ABuffer(of_ellipsoids())),
            (spheres(150, true), soft),
        ];
        for (points, method) in cases {
            // Two columns more than a few windows of whole rows.
            let frame = frame(perspective(), [170, 90], method);
            let mut renderer = Renderer::new(device).expect("a renderer");
            let mut cloud = renderer.upload(&points).expect("the cloud fits");
            let whole = taken(&mut renderer, &mut cloud, &frame, State::Tidy).expect("samples");
            for budget in [8 << 20, 1 << 20, 400 << 10] {
                let small = Frame { memory_budget: Some(budget), ..frame };
                let parts = taken(&mut renderer, &mut cloud, &small, State::Tidy).expect("samples");
                assert!(bits_of(&parts) == bits_of(&whole), "{} in {budget} bytes", method.name());
            }
            let mut places: Vec<u32> = (0..points.len() as u32).collect();
            places.shuffle(&mut random(1));
            let shuffled = order::canonical(points.subset(&places, 1.0));
            assert!(bits_of(&deep_of(device, &shuffled, &frame, State::Tidy)) == bits_of(&whole), "{}", method.name());
            let mut supplied = by_windows(&renderer, &Arc::new(points));
            let small = Frame { memory_budget: Some(1 << 20), ..frame };
            let parts = taken(&mut renderer, &mut supplied, &small, State::Tidy).expect("samples");
            assert!(bits_of(&parts) == bits_of(&whole), "{} window by window", method.name());
        }
    });
}

/// Checks windows that are parts of a row, since there is room for a few fragments only.
#[test]
fn memory_is_bounded_and_bands_say_so() {
    with_device(|device| {
        let (points, mut renderer) = (discs(), Renderer::new(device).expect("a renderer"));
        let mut cloud = renderer.upload(&points).expect("the cloud fits");
        let frame = frame(perspective(), [64, 16], Method::ABuffer(Discs::default()));
        let run = |renderer: &mut Renderer, cloud: &mut DeviceCloud, budget| {
            let frame = Frame { memory_budget: Some(budget), ..frame };
            let mut most = 0;
            let facts = renderer.deep(cloud, &frame, State::Sorted, &mut |_, samples| {
                most = most.max(samples.len());
                Ok(())
            });
            facts.map(|facts| (facts, most))
        };
        let (large, all) = run(&mut renderer, &mut cloud, 64 << 20).expect("samples");
        let (small, part) = run(&mut renderer, &mut cloud, 300 << 10).expect("samples");
        assert!(small.bands > 8 && small.windows > 1 && large.bands == 1, "{large:?} {small:?}");
        assert!(part * 4 < all && small.fragments == large.fragments && all as u64 == large.fragments, "{part} {all}");
        // A single pixel's list that does not fit.
        let refused = run(&mut renderer, &mut cloud, 20 << 10);
        assert!(matches!(refused, Err(Error::PixelOverBudget { .. })), "{refused:?}");
    });
}

#[test]
fn errors_of_the_taker_end_the_frame_and_other_methods_have_no_samples() {
    with_device(|device| {
        let (points, mut renderer) = (discs(), Renderer::new(device).expect("a renderer"));
        let mut cloud = renderer.upload(&points).expect("the cloud fits");
        let good = frame(perspective(), [16, 12], Method::ABuffer(Discs::default()));
        let full =
            renderer.deep(&mut cloud, &good, State::Tidy, &mut |_, _| Err(std::io::ErrorKind::StorageFull.into()));
        assert!(matches!(full, Err(Error::Samples(ref e)) if e.kind() == std::io::ErrorKind::StorageFull), "{full:?}");
        let points = Frame { method: Method::Points, ..good };
        let refused = renderer.deep(&mut cloud, &points, State::Tidy, &mut |_, _| Ok(()));
        assert!(matches!(refused, Err(Error::NoSamples { method: "points" })), "{refused:?}");
        assert!(deep::check(&good, false, State::Tidy).is_ok() && deep::check(&points, false, State::Tidy).is_err());
        assert!(taken(&mut renderer, &mut cloud, &good, State::Tidy).is_ok(), "the next frame is as before");
    });
}

/// Checks a case worked by hand: two discs on a pixel and one behind them at one depth, of which the lower index is in
/// front.
#[test]
fn merging_by_hand() {
    with_device(|device| {
        let at = |depth: f64, opacity: f32, red: f32| P {
            position: at_pixel(0.5, 0.5, depth),
            color: glam::Vec3::new(red, 0.0, 1.0),
            opacity,
            radius: 0.0,
            normal: glam::Vec3::ZERO,
        };
        let points = scene(&[at(2.0, 0.5, 1.0), at(4.0, 0.5, 0.5), at(4.0, 0.5, 0.5)]);
        let frame = frame(pixel_camera([1, 1]), [1, 1], Method::ABuffer(Discs::default()));
        let [tidy, sorted] = STATES.map(|state| deep_of(device, &points, &frame, state).remove(0));
        let sample = |rgba, depth| Sample { rgba, depth, back: depth };
        let (front, behind) = (sample([0.5, 0.0, 0.5, 0.5], 2.0), sample([0.25, 0.0, 0.5, 0.5], 4.0));
        assert_eq!(sorted, [front, behind, behind]);
        assert_eq!(tidy, [front, sample([0.375, 0.0, 0.75, 0.75], 4.0)]);
        assert_eq!(DVec3::from_slice(&over(&tidy)[..3]), DVec3::new(0.6875, 0.0, 0.875));
    });
}
