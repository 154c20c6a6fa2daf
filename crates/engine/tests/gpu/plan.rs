//! The frame plan: the method that `auto` stands for, and facts that are surveyed without rendering.

use glam::{DVec3, Vec3};
use pellucid_core::points::Points;
use pellucid_engine::methods::{Facts, Renderer};
use pellucid_engine::plan::{plan, resolve};
use pellucid_scene::{
    BlendedSplats, DiscShape, Discs, Hybrid, ImageSpace, Iterations, LongLists, Method, MethodChoice, Mlab, Moments,
    OneLayer, Peel, PeelLayers, Raster, ScreenSplats, Soft, Stochastic, Wavelet,
};
use pellucid_testing::{P, at_pixel, frame, perspective, pixel_camera, scene, soup, with_device};

/// Six samples of each pixel, by the rasterizer.
fn in_hardware() -> Stochastic {
    let discs = Discs { raster: Raster::Hardware, ..Discs::default() };
    Stochastic { discs, samples: 6, alpha_correction: true }
}

fn with_opacities(opacities: &[f32]) -> Vec<P> {
    let point = |(i, opacity): (usize, &f32)| P {
        position: DVec3::X * i as f64,
        color: Vec3::ONE,
        opacity: *opacity,
        radius: 0.5,
        normal: Vec3::ZERO,
    };
    opacities.iter().enumerate().map(point).collect()
}

/// Every second point is soft.
fn half_soft(points: Points) -> Points {
    let fields = (0..points.len()).map(|i| (i % 2) as f32).collect();
    Points { fields, ..points }
}

#[test]
fn auto_takes_the_exact_method_that_suits_the_points() {
    let (method, why) = resolve(MethodChoice::default(), &scene(&with_opacities(&[1.0, 1.0])));
    // Not clamped: the image is that of the exact method.
    assert!(
        matches!(method, Method::Circles(ScreenSplats { size: 1.0, max_pixel_radius: f32::MAX, .. })),
        "{method:?}"
    );
    assert!(why.contains("every point is opaque"), "{why}");
    for opacities in [[1.0, 0.999], [0.0, 0.0], [0.5, 1.0]] {
        let transparent = opacities.iter().filter(|a| **a < 1.0).count();
        let (method, why) = resolve(MethodChoice::default(), &scene(&with_opacities(&opacities)));
        assert_eq!(method, Method::Sorted(Discs::default()));
        assert!(why.contains(&format!("{transparent} of 2 points")), "{why}");
    }
}

#[test]
fn a_method_that_was_asked_for_stays() {
    let oriented = Method::ABuffer(Discs { shape: DiscShape::Oriented, ..Discs::default() });
    for method in [Method::Points, Method::Squares(ScreenSplats::default()), oriented] {
        let (taken, why) = resolve(method.into(), &scene(&with_opacities(&[0.5])));
        assert_eq!(taken, method);
        assert!(why.contains(method.name()) && why.contains("requested"), "{why}");
    }
}

#[test]
fn a_survey_finds_what_a_frame_meets() {
    with_device(|device| {
        // Radii that give splats of a few pixels and of thousands.
        let points = half_soft(scene(&soup(11, 400, 0.001..0.5, 0.1..0.9, false)));
        let methods = [
            Method::Points,
            Method::Circles(ScreenSplats::default()),
            Method::ABuffer(Discs::default()),
            Method::LinkedList(Discs::default()),
            Method::Sorted(Discs::default()),
            Method::Peel(Peel::default()),
            Method::Stochastic(Stochastic::default()),
            Method::Stochastic(in_hardware()),
            Method::Hybrid(Hybrid::default()),
            Method::Mlab(Mlab::default()),
            Method::Moments(Moments::default()),
            Method::Wavelet(Wavelet::default()),
            Method::Weighted(Discs::default()),
            Method::Average(Discs::default()),
            Method::Unsorted(Discs::default()),
            Method::SoftBase(Soft::default()),
            Method::SoftConcentric(Soft::default()),
            Method::SoftExpress(Soft::default()),
            Method::Hqs(BlendedSplats::default()),
            Method::Splats(BlendedSplats::default()),
            Method::OneLayer(OneLayer::default()),
            Method::ImageSpace(ImageSpace::default()),
            Method::PeelLayers(PeelLayers { layers: 2, ..PeelLayers::default() }),
        ];
        for method in methods {
            for memory_budget in [None, Some(200_000)] {
                let frame =
                    pellucid_engine::methods::Frame { memory_budget, ..frame(perspective(), [150, 100], method) };
                let mut renderer = Renderer::new(device).expect("a renderer");
                let mut cloud = renderer.upload(&points).expect("fits");
                let surveyed = renderer.survey(&mut cloud, &frame).expect("surveyed");
                let met = renderer.render(&mut cloud, &frame).expect("rendered").facts;
                // Allocations, the number of peeled layers, and the tiles of splats are known only afterwards. The
                // splats of a pixel are counted while soft discs are blended.
                let counted = !matches!(method, Method::SoftExpress(_));
                let decided = |facts: &Facts| Facts {
                    fragments: if counted { facts.fragments } else { 0 },
                    max_list: if counted { facts.max_list } else { 0 },
                    fragment_bytes: 0,
                    peak_device_bytes: 0,
                    layers: 0,
                    tile_entries: 0,
                    ..facts.clone()
                };
                assert_eq!(decided(&surveyed), decided(&met), "{}, {memory_budget:?}", method.name());
                assert!(met.visible > 300 && (met.windows > 1) == memory_budget.is_some(), "{met:?}");
            }
        }
    });
}

#[test]
fn every_pass_is_listed_once_with_a_reason_whatever_the_method() {
    with_device(|device| {
        let points = scene(&soup(12, 50, 0.01..0.1, 0.1..0.9, false));
        let names_of = |method: Method, wide: bool| {
            let frame = frame(perspective(), [64, 64], method);
            let mut renderer = Renderer::new(device).expect("a renderer");
            let mut cloud = renderer.upload(&points).expect("fits");
            let facts = renderer.survey(&mut cloud, &frame).expect("surveyed");
            let steps = plan(device, &frame, &facts, wide, "a reason");
            assert!(steps.iter().all(|step| !step.reason.is_empty()), "{steps:?}");
            let on = |name: &str| steps.iter().any(|step| step.name == name && step.on);
            let nearest =
                |stem: &str| ["nearest", "nearest-depth", "nearest-id"].map(|end| on(&format!("{stem}/{end}")));
            let wanted = |of: bool| if of { [wide, !wide, !wide] } else { [false; 3] };
            assert_eq!(nearest("opaque"), wanted(matches!(method, Method::Circles(_))));
            let direct = method == Method::Points || method.filters().is_some();
            assert_eq!(nearest("points"), wanted(direct));
            assert_eq!(nearest("spbr"), [false; 3]);
            assert_eq!(nearest("peel"), wanted(matches!(method, Method::Peel(_))));
            let mut names: Vec<_> = steps.iter().map(|step| step.name).collect();
            names.sort_unstable();
            names
        };
        let all = names_of(Method::ABuffer(Discs::default()), true);
        let mut once = all.clone();
        once.dedup();
        assert_eq!(all, once);
        let in_place = Discs { long_lists: LongLists::InPlace, ..Discs::default() };
        for method in [
            Method::Points,
            Method::Circles(ScreenSplats::default()),
            Method::LinkedList(in_place),
            Method::Sorted(Discs::default()),
            Method::Peel(Peel::default()),
            Method::Stochastic(Stochastic::default()),
            Method::Stochastic(in_hardware()),
            Method::Hybrid(Hybrid::default()),
            Method::Mlab(Mlab::default()),
            Method::Moments(Moments::default()),
            Method::Wavelet(Wavelet::default()),
            Method::Weighted(Discs::default()),
            Method::Average(Discs::default()),
            Method::Unsorted(Discs::default()),
            Method::SoftBase(Soft::default()),
            Method::SoftConcentric(Soft::default()),
            Method::SoftExpress(Soft::default()),
            Method::Hqs(BlendedSplats::default()),
            Method::Splats(BlendedSplats::default()),
            Method::OneLayer(OneLayer::default()),
            Method::ImageSpace(ImageSpace::default()),
            Method::PeelLayers(PeelLayers::default()),
        ] {
            assert_eq!(names_of(method, true), all);
            assert_eq!(names_of(method, false), all);
        }
    });
}

/// A plane of points, one for each pixel of the image at its middle depth, but for those that `is_left_out` says.
fn plane(size: [u32; 2], is_left_out: impl Fn(u32, u32) -> bool) -> Points {
    let all = (0..size[1]).flat_map(|y| (0..size[0]).map(move |x| (x, y))).filter(|(x, y)| !is_left_out(*x, *y));
    let point = |(x, y): (u32, u32)| P {
        position: at_pixel(f64::from(x) + 0.5, f64::from(y) + 0.5, 8.0),
        color: Vec3::ONE,
        opacity: 1.0,
        radius: 0.0,
        normal: Vec3::ZERO,
    };
    scene(&all.map(point).collect::<Vec<_>>())
}

#[test]
fn filters_run_over_tiles_that_they_may_change() {
    with_device(|device| {
        let size = [100, 80];
        let of = |points: &Points, iterations: u32, smooth: u32| {
            let distance = Some(0.5);
            let filters = ImageSpace {
                fill: Iterations::Count(iterations),
                occlusion: Iterations::Count(iterations),
                smooth,
                min_layer_distance: distance,
                ..ImageSpace::default()
            };
            let frame = frame(pixel_camera(size), size, Method::ImageSpace(filters));
            let mut renderer = Renderer::new(device).expect("a renderer");
            let mut cloud = renderer.upload(points).expect("fits");
            let facts = renderer.render(&mut cloud, &frame).expect("renders").facts;
            assert_eq!(facts.image_tiles, 7 * 5);
            facts.filtered_tiles
        };
        // A full plane: no holes, nothing hidden; edges where the image ends.
        assert_eq!(of(&plane(size, |_, _| false), 3, 1), [0, 0, 35, 20]);
        // A hole inside of a tile: that one, and those around it once more, since there may be something to do still.
        let one = plane(size, |x, y| (x, y) == (40, 40));
        assert_eq!(of(&one, 1, 0)[..3], [1, 0, 0]);
        // It is filled then, and no background is left.
        assert_eq!(of(&one, 5, 0)[..3], [1, 0, 0]);
        // An upper half ends with a row of tiles: beyond it there is background, but nothing to fill.
        let half = plane(size, |_, y| y >= 32);
        assert_eq!(of(&half, 1, 2), [7, 0, 2 * 14, 7 + 7 + 7]);
        // The second time nothing has changed.
        assert_eq!(of(&half, 9, 0)[0], 7);
        // Nothing at all.
        let far_away = scene(&[P { position: DVec3::new(0.0, 0.0, 9.0), ..with_opacities(&[1.0])[0] }]);
        assert_eq!(of(&far_away, 2, 1), [0; 4]);
    });
}

#[test]
fn a_plan_says_how_many_iterations_had_tiles() {
    with_device(|device| {
        let size = [40, 40];
        // A square of 4 pixels takes 3 iterations.
        let points = plane(size, |x, y| (20..24).contains(&x) && (20..24).contains(&y));
        let filters = ImageSpace { fill: Iterations::Auto, occlusion: Iterations::Count(2), ..ImageSpace::default() };
        let frame = frame(pixel_camera(size), size, Method::ImageSpace(filters));
        let mut renderer = Renderer::new(device).expect("a renderer");
        let mut cloud = renderer.upload(&points).expect("fits");
        let facts = renderer.render(&mut cloud, &frame).expect("renders").facts;
        let steps = plan(device, &frame, &facts, true, "a reason");
        let reason = |name: &str| steps.iter().find(|step| step.name == name).expect("it is listed").reason.clone();
        let fill = reason("image-space/fill");
        assert!(fill.starts_with("3 of at most 64 iterations had tiles with background"), "{fill}");
        assert!(reason("image-space/occlusion").starts_with("2 iteration(s) over tiles"), "a fixed number");
    });
}

#[test]
fn layers_end_on_the_device_when_there_are_no_points_left() {
    with_device(|device| {
        let size = [40, 40];
        let points = plane(size, |_, _| false);
        let frame =
            frame(pixel_camera(size), size, Method::PeelLayers(PeelLayers { layers: 30, ..PeelLayers::default() }));
        let mut renderer = Renderer::new(device).expect("a renderer");
        let mut cloud = renderer.upload(&points).expect("fits");
        let rendered = renderer.render(&mut cloud, &frame).expect("renders");
        assert_eq!((rendered.facts.layers, rendered.facts.image_tiles), (1, 9));
        let runs = |name| rendered.profile.timeline.iter().filter(|(pass, _)| pass.name == name).count();
        // One batch of them.
        assert_eq!(runs("image-space/measure"), 8);
        let shaded = rendered.profile.passes.iter().find(|pass| pass.name == "image-space/resolve").expect("it ran");
        assert!(shaded.invocations.is_none_or(|n| n == 9 * 64), "{shaded:?}");
    });
}
