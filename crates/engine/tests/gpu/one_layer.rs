//! `one-layer`: images against the float64 reference, cases worked by hand, which points and passes there are; the same bytes
//! whatever the order of input and the cut of the image.

use glam::{DVec3, Vec3};
use pellucid_engine::camera::Camera;
use pellucid_engine::gpu::Device;
use pellucid_engine::image::Image;
use pellucid_engine::methods::{Error, Rendered, Renderer};
use pellucid_engine::points::Points;
use pellucid_engine::prepare::order;
use pellucid_engine::reference::coverage::{Shape, margin_px};
use pellucid_engine::reference::{self, one_layer, splats};
use pellucid_engine::scene::{BlendedSplats, ColorSpace, Method, OneLayer, ScreenSplats, Shading, ShadingModel};
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
        file_order: Vec::new(),
        fields: fields.to_vec(),
    })
}

fn method(threshold: f32, softness: f32) -> Method {
    Method::OneLayer(OneLayer { threshold, softness })
}

/// A soup of which every coverage decision is clear in float32, with random fields.
fn clear(seed: u64, camera: &Camera, size: [u32; 2], tilted: bool) -> Points {
    let mixed = [soup(seed, 900, 0.02..0.2, 0.0..1.0, tilted), soup(seed + 1, 30, 0.3..2.0, 0.0..1.0, tilted)].concat();
    let all = scene(&mixed);
    let shape = if tilted { Shape::Oriented } else { Shape::Disc };
    let is_clear = |i: &usize| {
        let splat = splats::splat(camera, size, &all, *i, shape, &ScreenSplats::default());
        margin_px(camera, size, &splat) > 0.02
    };
    let kept: Vec<P> = (0..all.len())
        .filter(is_clear)
        .map(|i| P {
            position: all.positions[i],
            color: all.colors[i],
            opacity: all.opacities[i],
            radius: all.radii[i],
            normal: all.normals.as_ref().map_or(Vec3::ZERO, |normals| normals[i]),
        })
        .collect();
    let mut r = random(seed);
    let fields: Vec<f32> = kept.iter().map(|_| r.random()).collect();
    fielded(&kept, &fields)
}

/// Compares with the reference where it is clear in float32 which fragments count; the share of other pixels.
fn compare(image: &Image, points: &Points, colors: &[DVec3], camera: &Camera, of: &OneLayer) -> Result<f64, String> {
    let size = [image.width, image.height];
    let wanted = one_layer::render(camera, size, points, colors, of);
    let lists = one_layer::lists(camera, size, points, of.threshold);
    if image.fragments.as_deref() != Some(&wanted.counts) {
        return Err("other counts".to_owned());
    }
    let (limit, bound) = if points.normals.is_some() { (4e-5, 2e-4) } else { (1e-6, 1e-4) };
    let mut doubtful = 0;
    for (at, parts) in lists.iter().enumerate() {
        if parts.margin(f64::from(BlendedSplats::default().blend_depth)) < limit {
            doubtful += 1;
            continue;
        }
        let off = image.rgba[at].iter().zip(wanted.rgba[at]).map(|(a, b)| (f64::from(*a) - b).abs());
        let (found, depth) = (f64::from(image.depth[at]), wanted.depth[at]);
        let deep = found == depth || (found - depth).abs() <= limit * depth;
        // A is softness or 1, to the bit.
        let opaque = image.rgba[at][3] == wanted.rgba[at][3] as f32;
        if !deep || !opaque || off.fold(0.0, |a: f64, b| if b.is_nan() { b } else { a.max(b) }) > bound {
            return Err(format!("pixel {at}: {:?} {found}, {:?} {depth}", image.rgba[at], wanted.rgba[at]));
        }
    }
    Ok(f64::from(doubtful) / lists.len() as f64)
}

#[test]
fn images_equal_the_reference() {
    with_device(|device| {
        let size = [110, 80];
        for (camera, tilted) in [(perspective(), false), (perspective(), true), (orthographic(), true)] {
            let points = clear(11, &camera, size, tilted);
            let colors: Vec<DVec3> = points.colors.iter().map(|c| c.as_dvec3()).collect();
            let mut renderer = Renderer::new(device).expect("a renderer");
            let mut cloud = renderer.upload(&points).expect("fits");
            for (threshold, softness) in [(0.5, 0.25), (0.9, 0.6), (0.1, 1.0), (0.5, 0.0), (1.0, 0.5)] {
                let frame = frame(camera, size, method(threshold, softness));
                let image = renderer.render(&mut cloud, &frame).expect("renders").image;
                let doubtful = compare(&image, &points, &colors, &camera, &OneLayer { threshold, softness });
                println!("{tilted} {threshold} {softness}: {doubtful:?}");
                assert!(doubtful.clone().is_ok_and(|s| s < 0.01), "{tilted} {threshold} {softness}: {doubtful:?}");
                // The comparison can fail.
                let other = OneLayer { threshold: threshold - 0.05, softness };
                assert!(compare(&image, &points, &colors, &camera, &other).is_err() || softness == 0.0);
            }
        }
    });
}

#[test]
fn shaded_and_encoded_colors() {
    with_device(|device| {
        let (size, camera) = ([80, 60], perspective());
        let points = clear(15, &camera, size, true);
        let mut frame = frame(camera, size, method(0.5, 0.3));
        frame.shading = Shading { model: ShadingModel::Lambert, ..Shading::default() };
        frame.color = ColorSpace::Encoded;
        let colors = reference::shading::shade(&points, &camera, &frame.shading, frame.color);
        let image = render(device, &points, &frame);
        let doubtful = compare(&image, &points, &colors, &camera, &OneLayer { threshold: 0.5, softness: 0.3 });
        assert!(doubtful.clone().is_ok_and(|share| share < 0.01), "{doubtful:?}");
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

/// Pixels of [`rendered`] of which roundings decide which splats count: some rim is there with slightly larger radii alone, or a depth
/// lies at the limit of what is blended.
fn doubtful(points: &Points, tilted: bool, settings: &BlendedSplats) -> Vec<bool> {
    let shape = if tilted { Shape::Oriented } else { Shape::Disc };
    let lists = |factor: f32| {
        let radii = points.radii.iter().map(|radius| radius * factor).collect();
        let points = Points { radii, ..points.clone() };
        splats::lists(&perspective(), [90, 70], &points, shape, &settings.splats, |_| true)
    };
    let (fewer, more) = (lists(1.0 - 1e-5), lists(1.0 + 1e-5));
    let is_close = |list: &[splats::Fragment]| splats::margin(list, f64::from(settings.blend_depth)) < 4e-5;
    fewer.iter().zip(&more).map(|(a, b)| a.len() != b.len() || is_close(b)).collect()
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
            let alone = rendered(device, &scene(&solid), opaque).image;
            let far = |pixel: &usize| {
                hidden.image.rgba[*pixel].iter().zip(alone.rgba[*pixel]).any(|(a, b)| (a - b).abs() > 1e-4)
            };
            let off: Vec<usize> = (0..alone.rgba.len()).filter(far).collect();
            let doubtful = doubtful(&scene(&solid), tilted, &settings);
            assert!(off.iter().all(|pixel| doubtful[*pixel]), "{tilted}: {off:?}");
            assert!(off.len() < 10, "{tilted}: {off:?}");
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
