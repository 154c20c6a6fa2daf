//! `one-layer`: images against the float64 reference, cases worked by hand, which points and passes there are; the same
//! bytes whatever the order of input and the cut of the image.

use glam::{DVec3, Vec3};
use pellucid_core::camera::Camera;
use pellucid_core::image::Image;
use pellucid_core::points::Points;
use pellucid_engine::methods::{Error, Rendered, Renderer};
use pellucid_gpu::Device;
use pellucid_reference::View;
use pellucid_reference::coverage::Shape;
use pellucid_reference::range::{PictureRange, ROUNDING};
use pellucid_reference::{self as reference, one_layer, splats};
use pellucid_scene::prepare::order;
use pellucid_scene::{BlendedSplats, ColorSpace, Method, OneLayer, Shading, ShadingModel};
use pellucid_testing::*;
use rand::RngExt;
use rand::seq::SliceRandom;

/// Points with fields as a scene.
fn fielded(points: &[P], fields: &[f32]) -> Points {
    let normals: Vec<Vec3> = points.iter().map(|p| p.normal).collect();
    order::canonical(Points {
        positions: points.iter().map(|p| p.position).collect(),
        colors: points.iter().map(|p| p.color).collect(),
        opacities: points.iter().map(|p| p.opacity).collect(),
        radii: points.iter().map(|p| p.radius).collect(),
        normals: normals.iter().any(|n| *n != Vec3::ZERO).then_some(normals),
        fields: fields.to_vec(),
        ..Points::default()
    })
}

/// Bound of colors, as in `splats.rs`, with three roundings for the sum of layer and rest.
pub(crate) const SUM_ERROR: f64 = 16.0 * ROUNDING;
/// Bound of shaded colors, as in `splats.rs`.
const SHADING_ERROR: f64 = 50.0 * 12.92 * ROUNDING;

fn method(threshold: f32, softness: f32) -> Method {
    Method::OneLayer(OneLayer { threshold, softness })
}

/// A soup with random fields.
fn mixture(seed: u64, tilted: bool) -> Points {
    let mixed = [soup(seed, 900, 0.02..0.2, 0.0..1.0, tilted), soup(seed + 1, 30, 0.3..2.0, 0.0..1.0, tilted)].concat();
    let mut r = random(seed);
    let fields: Vec<f32> = mixed.iter().map(|_| r.random()).collect();
    fielded(&mixed, &fields)
}

/// Compares with what roundings may make of the reference, colors to `slack` beyond it; A is softness or 1, to the bit.
fn compare(
    image: &Image,
    points: &Points,
    colors: &[DVec3],
    camera: &Camera,
    of: &OneLayer,
    slack: f64,
) -> Result<(), String> {
    let wanted = one_layer::ranges(View::new(camera, [image.width, image.height]), points, colors, of);
    let is_off = |pixel: &usize| !wanted.rgba[*pixel][3].covers(f64::from(image.rgba[*pixel][3]), 0.0);
    match (0..image.rgba.len()).find(is_off) {
        None => compare_ranges(image, &wanted, slack),
        Some(pixel) => Err(format!("pixel {pixel}: A is {}", image.rgba[pixel][3])),
    }
}

#[test]
fn images_equal_the_reference() {
    with_device(|device| {
        let size = [110, 80];
        for (camera, tilted) in [(perspective(), false), (perspective(), true), (orthographic(), true)] {
            let points = mixture(11, tilted);
            let colors: Vec<DVec3> = points.colors.iter().map(|c| c.as_dvec3()).collect();
            let mut renderer = Renderer::new(device).expect("a renderer");
            let mut cloud = renderer.upload(&points).expect("fits");
            for (threshold, softness) in [(0.5, 0.25), (0.9, 0.6), (0.1, 1.0), (0.5, 0.0), (1.0, 0.5)] {
                let frame = frame(camera, size, method(threshold, softness));
                let image = renderer.render(&mut cloud, &frame).expect("renders").image;
                let of = |other: &OneLayer| compare(&image, &points, &colors, &camera, other, SUM_ERROR);
                let found = of(&OneLayer { threshold, softness });
                assert!(found.is_ok(), "{tilted} {threshold} {softness}: {found:?}");
                // The comparison can fail. Without softness no soft point is seen.
                let other = OneLayer { threshold: threshold - 0.05, softness };
                assert!(of(&other).is_err() || softness == 0.0);
            }
        }
    });
}

#[test]
fn shaded_and_encoded_colors() {
    with_device(|device| {
        let (size, camera) = ([80, 60], perspective());
        let points = mixture(15, true);
        let mut frame = frame(camera, size, method(0.5, 0.3));
        frame.shading = Shading { model: ShadingModel::Lambert, ..Shading::default() };
        frame.color = ColorSpace::Encoded;
        let colors = reference::shading::shade(&points, &camera, &frame.shading, frame.color);
        let image = render(device, &points, &frame);
        let settings = OneLayer { threshold: 0.5, softness: 0.3 };
        compare(&image, &points, &colors, &camera, &settings, SUM_ERROR + SHADING_ERROR).expect("the reference");
    });
}

/// A disc of one pixel's width around the middle of a pixel of [`pixel_camera`].
fn disc(x: u32, depth: f64, color: Vec3) -> P {
    P { position: at_pixel(f64::from(x) + 0.5, 0.5, depth), color, opacity: 0.0, radius: 0.5, normal: Vec3::ZERO }
}

/// Depth, color and field of a disc.
type Disc = (f64, Vec3, f32);

#[test]
fn cases_worked_by_hand() {
    with_device(|device| {
        let [red, green, blue] = [Vec3::X, Vec3::Y, Vec3::Z];
        // Pixel by pixel: its discs, nearest first; its color and depth.
        let (soft, solid) = (0.75, 0.5);
        let cases: [(&[Disc], [f32; 4], f32); 7] = [
            (&[(2.0, red, soft), (5.0, green, solid)], [0.25, 0.75, 0.0, 1.0], 2.0),
            (&[(5.0, green, solid), (6.0, red, soft)], [0.0, 1.0, 0.0, 1.0], 5.0),
            (&[(2.0, red, soft)], [0.25, 0.0, 0.0, 0.25], 2.0),
            (&[(5.0, green, solid)], [0.0, 1.0, 0.0, 1.0], 5.0),
            // The second soft one lies more than its radius behind the first: opaque.
            (&[(2.0, red, soft), (3.0, blue, soft), (5.0, green, solid)], [0.25, 0.0, 0.75, 1.0], 2.0),
            // Within it: part of the layer.
            (&[(2.0, red, soft), (2.25, blue, soft), (5.0, green, solid)], [0.125, 0.75, 0.125, 1.0], 2.0),
            // Behind the layer the opaque ones blend with each other.
            (&[(2.0, red, soft), (5.0, green, solid), (5.25, blue, soft)], [0.25, 0.375, 0.375, 1.0], 2.0),
        ];
        let mut points = Vec::new();
        let mut fields = Vec::new();
        for (x, (discs, ..)) in (0u32..).zip(&cases) {
            points.extend(discs.iter().map(|(depth, color, _)| disc(x, *depth, *color)));
            fields.extend(discs.iter().map(|(.., field)| *field));
        }
        let size = [cases.len() as u32 + 1, 1];
        let image = render(device, &fielded(&points, &fields), &frame(pixel_camera(size), size, method(0.5, 0.25)));
        for (x, (discs, rgba, depth)) in cases.iter().enumerate() {
            for (found, wanted) in image.rgba[x].iter().zip(rgba) {
                assert!((found - wanted).abs() <= 2.0 * f32::EPSILON, "{discs:?}: {:?} {rgba:?}", image.rgba[x]);
            }
            assert_eq!(image.depth[x], *depth, "{discs:?}");
        }
        assert_eq!((image.rgba[cases.len()], image.depth[cases.len()]), ([0.0; 4], f32::INFINITY));
        // Whatever they are, and whatever hides them.
        let counts: Vec<u32> = cases.iter().map(|(discs, ..)| discs.len() as u32).chain([0]).collect();
        assert_eq!(image.fragments, Some(counts));
    });
}

fn rendered(device: &Device, points: &Points, method: Method) -> Rendered {
    let mut renderer = Renderer::new(device).expect("a renderer");
    let mut cloud = renderer.upload(points).expect("fits");
    renderer.render(&mut cloud, &frame(perspective(), [90, 70], method)).expect("renders")
}

/// Everything that roundings may make of the splats of some points, in the view of [`rendered`].
fn solid_ranges(points: &Points, tilted: bool, settings: &BlendedSplats) -> PictureRange {
    let shape = if tilted { Shape::Oriented } else { Shape::Disc };
    let colors: Vec<DVec3> = points.colors.iter().map(|c| c.as_dvec3()).collect();
    splats::ranges(View::new(&perspective(), [90, 70]), points, &colors, shape, settings)
}

fn times(rendered: &Rendered, name: &str) -> usize {
    rendered.profile.timeline.iter().filter(|(time, _)| time.name == name).count()
}

#[test]
fn only_what_is_there_is_drawn() {
    with_device(|device| {
        for tilted in [false, true] {
            let soup = soup(21, 800, 0.02..0.2, 0.0..1.0, tilted);
            let settings = BlendedSplats::default();
            let opaque = if tilted { Method::Splats(settings) } else { Method::Hqs(settings) };
            let all = rendered(device, &scene(&soup), opaque);
            let fields: Vec<f32> = (0..soup.len()).map(|i| i as f32 / 799.0).collect();
            let points = fielded(&soup, &fields);
            // No field, or none above the threshold: the splats of all points.
            for solid in
                [rendered(device, &scene(&soup), method(0.0, 0.5)), rendered(device, &points, method(1.0, 0.5))]
            {
                assert!(bits(&solid.image) == bits(&all.image), "{tilted}");
                assert_eq!((solid.facts.splatted, solid.facts.layered, times(&solid, "one-layer/compose")), (1, 0, 0));
                assert_eq!((times(&solid, "splats/attributes"), solid.facts.visible), (1, all.facts.visible));
            }
            let both = rendered(device, &points, method(0.5, 0.5));
            assert_eq!((both.facts.splatted, both.facts.layered, times(&both, "one-layer/compose")), (2, 1, 1));
            assert_eq!((both.facts.windows, times(&both, "splats/attributes")), (1, 2));
            // The soft half, and all again.
            assert!(both.facts.visible > all.facts.visible && both.facts.visible < 2 * all.facts.visible);
            // Soft points behind the camera: the splats of the solid ones.
            let mut away = soup.clone();
            away.iter_mut().step_by(2).for_each(|p| p.position += 3.0 * perspective().eye);
            let fields: Vec<f32> = (0..soup.len()).map(|i| if i % 2 == 0 { 0.6 } else { 0.5 }).collect();
            let hidden = rendered(device, &fielded(&away, &fields), method(0.5, 0.5));
            let solid: Vec<P> = soup.iter().skip(1).step_by(2).copied().collect();
            // Other bounds, and so another origin and order: rims and limits may round the other way.
            let alone = rendered(device, &scene(&solid), opaque);
            let wanted = solid_ranges(&scene(&solid), tilted, &settings);
            // The comparison can fail: without the nearest point.
            let far = |p: &P| p.position.distance(perspective().eye);
            let least = solid.iter().map(far).fold(f64::INFINITY, f64::min);
            let fewer: Vec<P> = solid.iter().copied().filter(|p| far(p) > least).collect();
            let other = solid_ranges(&scene(&fewer), tilted, &settings);
            for image in [&hidden.image, &alone.image] {
                compare_ranges(image, &wanted, SUM_ERROR).expect("the solid points");
                compare_ranges(image, &other, SUM_ERROR).expect_err("a point is missing");
            }
            assert_eq!((hidden.facts.splatted, hidden.facts.layered), (1, 0));
            // Only soft points: their first layer before the rest of them, and softness where there is no rest.
            let soft = rendered(device, &fielded(&soup, &vec![1.0; soup.len()]), method(0.5, 0.5));
            let alphas: Vec<f32> = soft.image.rgba.iter().map(|c| c[3]).collect();
            assert!([0.0, 0.5, 1.0].iter().all(|a| alphas.contains(a)), "{tilted}");
            assert!(alphas.iter().all(|a| [0.0, 0.5, 1.0].contains(a)), "{tilted}");
        }
    });
}

#[test]
fn neither_order_of_input_nor_windows_change_a_byte() {
    with_device(|device| {
        let size = [160, 96];
        // Depths tie, and some tiles take several runs: of 6000 splats in the middle.
        let mut dense = soup(41, 6000, 0.1..0.3, 0.0..1.0, true);
        dense.iter_mut().for_each(|p| p.position *= 0.1);
        let mut soup = [dense, soup(42, 600, 0.0..0.1, 0.0..1.0, true)].concat();
        for p in &mut soup {
            p.position = (p.position * 16.0).round() / 16.0;
        }
        let mut r = random(5);
        let mut fielded_soup: Vec<(P, f32)> = soup.into_iter().map(|p| (p, r.random())).collect();
        let of = |soup: &[(P, f32)]| {
            let (points, fields): (Vec<P>, Vec<f32>) = soup.iter().copied().unzip();
            fielded(&points, &fields)
        };
        let mut frame = frame(perspective(), size, method(0.4, 0.5));
        let mut renderer = Renderer::new(device).expect("a renderer");
        let mut cloud = renderer.upload(&of(&fielded_soup)).expect("fits");
        let whole = renderer.render(&mut cloud, &frame).expect("renders");
        assert!(times(&whole, "splats/attributes") > 2 && whole.facts.windows == 1, "{:?}", whole.facts);
        let again = renderer.render(&mut cloud, &frame).expect("renders");
        assert!(bits(&again.image) == bits(&whole.image), "a second time");
        fielded_soup.shuffle(&mut random(1));
        assert!(bits(&render(device, &of(&fielded_soup), &frame)) == bits(&whole.image), "another order");
        frame.memory_budget = Some(100 << 10);
        let named = match renderer.render(&mut cloud, &frame) {
            Err(Error::SortOverBudget { budget, .. }) => budget,
            other => panic!("expected the sort over budget, got {:?}", other.map(|r| r.facts)),
        };
        let mut cuts = 0;
        for budget in [named, 2 * named] {
            frame.memory_budget = Some(budget);
            let cut = renderer.render(&mut cloud, &frame).expect("the budget that the error names does");
            cuts += usize::from(cut.facts.windows > 1);
            assert!(bits(&cut.image) == bits(&whole.image), "budget {budget}: {:?}", cut.facts);
            assert!(cut.image.fragments == whole.image.fragments, "budget {budget}: {:?}", cut.facts);
        }
        assert!(cuts > 0, "some budget cuts the image");
    });
}
