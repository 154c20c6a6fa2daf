//! Gaussian splats: each by itself within what roundings of float32 leave, soups against the float64 reference, the
//! same bytes by every exact method, and by shuffles, windows and budgets.

use glam::{DVec3, Quat, Vec3};
use pellucid_core::camera::Camera;
use pellucid_core::camera::Projection::{Orthographic, Perspective};
use pellucid_core::cloud::gaussians::{ColorCoding, Gaussians, REACH};
use pellucid_core::image::Image;
use pellucid_core::points::Points;
use pellucid_engine::methods::{Error, Frame, Renderer};
use pellucid_gpu::Device;
use pellucid_reference::View;
use pellucid_reference::abuffer::Fragment;
use pellucid_reference::gaussians::{self, Possible};
use pellucid_reference::range::ROUNDING;
use pellucid_reference::{self as reference, ReferencePicture};
use pellucid_scene::prepare::order;
use pellucid_scene::{
    ColorSpace, Discs, GaussianSettings, Hybrid, Kernel, Method, Mlab, Order, Peel, Raster, Shading, Stochastic,
};
use pellucid_testing::gaussians::Soup;
use pellucid_testing::*;
use rand::seq::SliceRandom;

const KERNELS: [Kernel; 2] = [Kernel::Ewa, Kernel::Ray];
const ORDERS: [Order; 3] = [Order::Center, Order::Distance, Order::Pixel];

fn discs(kernel: Kernel, order: Order) -> Discs {
    Discs { gaussians: GaussianSettings { kernel, order: Some(order), ..Default::default() }, ..Discs::default() }
}

fn by_lists(settings: GaussianSettings) -> Method {
    Method::ABuffer(Discs { gaussians: settings, ..Discs::default() })
}

/// Blended as they are, as a scene of Gaussians alone is.
fn encoded(camera: Camera, size: [u32; 2], method: Method) -> Frame {
    Frame { color: ColorSpace::Encoded, ..frame(camera, size, method) }
}

fn shaded(points: &Points, frame: &Frame) -> Vec<DVec3> {
    reference::shading::shade(points, &frame.camera, &Shading::NONE, frame.color)
}

/// Cameras before the cube, beside it, along one of its sides, and with a wide lens.
pub(crate) fn cameras() -> [Camera; 4] {
    let look = |eye, projection| Camera::look_at(eye, DVec3::ZERO, DVec3::Y, projection, 0.1, 100.0).expect("valid");
    let wide = Perspective { fov_y: 100f64.to_radians() };
    let near = look(DVec3::new(1.0, 1.5, 4.0), Perspective { fov_y: 45f64.to_radians() });
    [
        near,
        orthographic(),
        look(DVec3::new(-1.6, 0.3, 0.7), wide),
        look(DVec3::new(0.0, 3.0, 0.5), Orthographic { height: 2.0 }),
    ]
}

/// One Gaussian of a list by itself.
fn alone(points: &Points, index: usize) -> Points {
    points.subset(&[index as u32], 1.0)
}

/// Asserts that a Gaussian's image is within what roundings leave; returns its sure pixels.
#[track_caller]
fn assert_possible(image: &Image, points: &Points, frame: &Frame, settings: &GaussianSettings) -> usize {
    let gaussian = gaussians::gaussian(points, 0).expect("a Gaussian");
    let order = settings.order.unwrap_or(Order::Pixel);
    let all = gaussians::possible(View::new(&frame.camera, frame.size), &gaussian, settings, order, 0..frame.size[1]);
    let mut left: Vec<Option<Possible>> = vec![None; image.rgba.len()];
    for pixel in &all {
        left[(pixel.y * frame.size[0] + pixel.x) as usize] = Some(*pixel);
    }
    let color = gaussians::harmonics::color(points, 0, &frame.camera, frame.color).expect("a Gaussian");
    for (at, (found, depth)) in image.rgba.iter().zip(&image.depth).enumerate() {
        let [x, y] = [at as u32 % frame.size[0], at as u32 / frame.size[0]];
        let alpha = f64::from(found[3]);
        let Some(possible) = left[at] else {
            assert_eq!(*found, [0.0; 4], "({x}, {y}): nothing can be there: {settings:?} {gaussian:?}");
            continue;
        };
        if alpha == 0.0 {
            assert!(!possible.sure, "({x}, {y}): {possible:?} is missing: {settings:?} {gaussian:?}");
            continue;
        }
        assert!(possible.alpha.covers(alpha, 1e-9), "({x}, {y}): {alpha} {possible:?} {settings:?} {gaussian:?}");
        assert!(
            possible.z.covers(f64::from(*depth), 0.0),
            "({x}, {y}): {depth} {possible:?} {settings:?} {gaussian:?}"
        );
        for c in 0..3 {
            let wanted = alpha * color[c];
            // A direction, 25 products and their sum, and the curve; coefficients are at most 0.3, so that nothing
            // large cancels.
            let slack = 200.0 * ROUNDING * (1.0 + color.max_element()) * alpha;
            let off = (f64::from(found[c]) - wanted).abs();
            assert!(off <= slack, "({x}, {y}): {found:?}, {wanted} of {color}");
        }
    }
    all.iter().filter(|pixel| pixel.sure).count()
}

fn render_with(renderer: &mut Renderer, points: &Points, frame: &Frame) -> Image {
    let mut cloud = renderer.upload(points).expect("the cloud fits");
    renderer.render(&mut cloud, frame).expect("the frame renders").image
}

#[test]
fn each_gaussian_is_where_roundings_leave_it() {
    with_device(|device| {
        let mut renderer = Renderer::new(device).expect("a renderer");
        let size = [64, 48];
        let soups = [
            Soup { seed: 11, count: 12, degree: 2, ..Soup::default() },
            // Needles and plates.
            Soup { seed: 12, count: 12, extents: 1e-4..1.0, ..Soup::default() },
            // Smaller than pixels.
            Soup { seed: 13, count: 6, extents: 1e-5..1e-2, degree: 4, ..Soup::default() },
        ];
        let mut sure = 0;
        for soup in &soups {
            let points = soup.points();
            for camera in cameras() {
                for (kernel, order) in KERNELS.into_iter().flat_map(|kernel| ORDERS.map(|order| (kernel, order))) {
                    let antialias = soup.seed == 13;
                    let settings = GaussianSettings { kernel, order: Some(order), antialias, ..Default::default() };
                    let frame = encoded(camera, size, by_lists(settings));
                    for index in 0..points.len() {
                        let one = alone(&points, index);
                        let image = render_with(&mut renderer, &one, &frame);
                        sure += assert_possible(&image, &one, &frame, &settings);
                    }
                }
            }
        }
        assert!(sure > 20_000, "{sure} pixels");
    });
}

#[test]
fn flat_gaussians_are_discs_to_rays() {
    with_device(|device| {
        let mut renderer = Renderer::new(device).expect("a renderer");
        let mut points = Soup { seed: 5, count: 16, ..Soup::default() }.points();
        let gaussians = points.gaussians.as_mut().expect("Gaussians");
        gaussians.extents.iter_mut().for_each(|extents| extents.z = 0.0);
        let mut sure = 0;
        for camera in cameras() {
            for (kernel, order) in KERNELS.into_iter().flat_map(|kernel| ORDERS.map(|order| (kernel, order))) {
                let settings = GaussianSettings { kernel, order: Some(order), ..Default::default() };
                let frame = encoded(camera, [64, 48], by_lists(settings));
                for index in 0..points.len() {
                    let one = alone(&points, index);
                    sure += assert_possible(&render_with(&mut renderer, &one, &frame), &one, &frame, &settings);
                }
            }
        }
        assert!(sure > 5_000, "{sure} pixels");
    });
}

/// The fragments of each pixel in their order, where neither coverage nor order depends on roundings.
fn clear_lists(points: &Points, frame: &Frame, settings: &GaussianSettings) -> Vec<Option<Vec<(Possible, usize)>>> {
    let mut lists: Vec<Vec<(Possible, usize)>> = vec![Vec::new(); (frame.size[0] * frame.size[1]) as usize];
    let order = settings.order.unwrap_or(Order::Pixel);
    for index in 0..points.len() {
        let gaussian = gaussians::gaussian(points, index).expect("a Gaussian");
        for pixel in
            gaussians::possible(View::new(&frame.camera, frame.size), &gaussian, settings, order, 0..frame.size[1])
        {
            lists[(pixel.y * frame.size[0] + pixel.x) as usize].push((pixel, index));
        }
    }
    let clear = |mut list: Vec<(Possible, usize)>| {
        list.sort_by(|a, b| a.0.key.low.total_cmp(&b.0.key.low));
        let in_order = list.windows(2).all(|pair| pair[0].0.key.high < pair[1].0.key.low);
        let sure = list.iter().all(|(pixel, _)| pixel.sure);
        (in_order && sure).then_some(list)
    };
    lists.into_iter().map(clear).collect()
}

/// How far T and what each fragment adds may be off. An opacity that is off by e changes what lies behind by as much;
/// three roundings for each fragment, and those of colors.
fn off(list: &[(Possible, usize)]) -> f64 {
    list.iter().map(|(pixel, _)| pixel.alpha.high - pixel.alpha.low + 220.0 * ROUNDING).sum()
}

/// Where neither coverage nor order depends on roundings, the most that they change each component.
pub(crate) fn clear_pixels(
    points: &Points,
    frame: &Frame,
    settings: &GaussianSettings,
    colors: &[DVec3],
) -> Vec<Option<f64>> {
    let bound = |list: Vec<(Possible, usize)>| {
        let brightest = list.iter().map(|(_, i)| colors[*i].max_element()).fold(1.0, f64::max);
        2.0 * brightest * off(&list)
    };
    clear_lists(points, frame, settings).into_iter().map(|list| list.map(bound)).collect()
}

#[track_caller]
fn assert_like(image: &Image, wanted: &ReferencePicture, clear: &[Option<f64>]) {
    for (pixel, bound) in clear.iter().enumerate() {
        let Some(bound) = bound else { continue };
        let (found, wanted) = (image.rgba[pixel], wanted.rgba[pixel]);
        let off = found.iter().zip(wanted).map(|(a, b)| (f64::from(*a) - b).abs()).fold(0.0, f64::max);
        assert!(off <= *bound, "pixel {pixel}: {found:?} {wanted:?}, off by {off}, {bound} allowed");
    }
}

/// Asserts that the picture of a frame by `abuffer` is that of the reference where roundings decide nothing, which is
/// in most pixels. Returns both pictures and the bounds by pixel.
#[track_caller]
fn assert_reference(
    device: &Device,
    points: &Points,
    frame: &Frame,
    discs: &Discs,
) -> (Image, ReferencePicture, Vec<Option<f64>>) {
    let image = render(device, points, frame);
    let colors = shaded(points, frame);
    let wanted = reference::abuffer::render(View::new(&frame.camera, frame.size), points, &colors, discs);
    let clear = clear_pixels(points, frame, &discs.gaussians, &colors);
    assert_like(&image, &wanted, &clear);
    let known = clear.iter().filter(|bound| bound.is_some()).count();
    assert!(2 * known > clear.len(), "{known} of {} pixels are clear", clear.len());
    (image, wanted, clear)
}

#[test]
fn soups_are_those_of_the_reference() {
    with_device(|device| {
        let size = [80, 60];
        let points = Soup { seed: 21, count: 120, degree: 3, ..Soup::default() }.points();
        for camera in cameras() {
            for kernel in KERNELS {
                for order in ORDERS {
                    for color in [ColorSpace::Encoded, ColorSpace::Linear] {
                        let discs = discs(kernel, order);
                        let frame = Frame { color, ..frame(camera, size, Method::ABuffer(discs)) };
                        let (image, wanted, clear) = assert_reference(device, &points, &frame, &discs);
                        let same = clear
                            .iter()
                            .zip(image.depth.iter().zip(&wanted.depth))
                            .filter(|(clear, _)| clear.is_some());
                        for (_, (found, wanted)) in same {
                            let close = (f64::from(*found) - wanted).abs() <= 1e-3 * wanted.abs();
                            assert!(close || (found.is_infinite() && wanted.is_infinite()), "{found} {wanted}");
                        }
                    }
                }
            }
        }
    });
}

#[test]
fn linear_colors_are_those_of_the_reference_in_either_space() {
    with_device(|device| {
        let (size, camera) = ([80, 60], perspective());
        let soup = Soup { seed: 22, count: 120, degree: 2, ..Soup::default() }.points();
        let coded = |coding| Points {
            gaussians: soup.gaussians.clone().map(|all| Gaussians { coding, ..all }),
            ..soup.clone()
        };
        let each = ColorCoding::Each((0..soup.len()).map(|at| at % 3 == 0).collect());
        for coding in [ColorCoding::Linear, each] {
            let points = coded(coding);
            for color in [ColorSpace::Encoded, ColorSpace::Linear] {
                let discs = discs(Kernel::Ewa, Order::Pixel);
                let frame = Frame { color, ..frame(camera, size, Method::ABuffer(discs)) };
                let (image, ..) = assert_reference(device, &points, &frame, &discs);
                assert!(bits(&image) != bits(&render(device, &soup, &frame)));
            }
        }
    });
}

/// Between which depths half of the light or less is left for the first time: `share` more or less than a half may be
/// taken for it. They are those of all fragments from the first that it may be to the last, since depths that show are
/// not in order by distance.
fn possible_median(list: &[(Possible, usize)], share: f64) -> [f64; 2] {
    let first = |alpha: fn(&Possible) -> f64, most: f64| {
        let mut left = 1.0;
        list.iter().position(|(pixel, _)| {
            left *= 1.0 - alpha(pixel);
            left <= most
        })
    };
    let Some(start) = first(|pixel| pixel.alpha.high, 0.5 + share) else { return [f64::INFINITY; 2] };
    let last = first(|pixel| pixel.alpha.low, 0.5 - share);
    let all = || list[start..=last.unwrap_or(list.len() - 1)].iter().map(|(pixel, _)| pixel.z);
    let far = if last.is_some() { f64::NEG_INFINITY } else { f64::INFINITY };
    [all().map(|z| z.low).fold(f64::INFINITY, f64::min), all().map(|z| z.high).fold(far, f64::max)]
}

/// The mean depth, and how far it may be off: Σ wz / Σ w, with the same weights above and below, so that what they are
/// off only moves it within the list's own span. Besides there are the errors of depths and two for each summand.
fn possible_mean(list: &[(Possible, usize)]) -> [f64; 2] {
    let middle = |low: f64, high: f64| 0.5 * (low + high);
    let fragment = |(pixel, index): &(Possible, usize)| {
        let (z, alpha) = (middle(pixel.z.low, pixel.z.high), middle(pixel.alpha.low, pixel.alpha.high));
        Fragment { z, index: *index as u32, alpha }
    };
    let fragments: Vec<Fragment> = list.iter().map(fragment).collect();
    let depths = || fragments.iter().map(|f| f.z);
    let (near, far) = (depths().fold(f64::INFINITY, f64::min), depths().fold(f64::NEG_INFINITY, f64::max));
    let width = list.iter().map(|(pixel, _)| pixel.z.high - pixel.z.low).fold(0.0, f64::max);
    let alpha = 1.0 - fragments.iter().map(|f| 1.0 - f.alpha).product::<f64>();
    let sums = 2.0 * (list.len() + 4) as f64 * ROUNDING * far;
    [reference::abuffer::mean_depth(&fragments), 2.0 * off(list) * (far - near) / alpha + width + sums]
}

#[test]
fn depths_of_lists_are_where_roundings_leave_them() {
    with_device(|device| {
        let size = [80, 60];
        let points = Soup { seed: 23, count: 150, ..Soup::default() }.points();
        let faint = Soup { seed: 24, count: 900, extents: 0.2..0.6, opacities: 0.0..0.05, ..Soup::default() }.points();
        let (mut known, mut longest) = (0, 0);
        let cases = [(&points, size, &cameras()[..]), (&faint, [24, 18], &cameras()[..2])];
        for (points, size, cameras) in cases {
            for camera in cameras {
                for (kernel, order) in KERNELS.into_iter().flat_map(|kernel| ORDERS.map(|order| (kernel, order))) {
                    let discs = discs(kernel, order);
                    let frame = Frame { depths: true, ..encoded(*camera, size, Method::ABuffer(discs)) };
                    let image = render(device, points, &frame);
                    let [median, mean] =
                        [image.depth_median, image.depth_mean].map(|depths| depths.expect("asked for"));
                    for (pixel, list) in clear_lists(points, &frame, &discs.gaussians).iter().enumerate() {
                        let Some(list) = list.as_ref().filter(|list| !list.is_empty()) else { continue };
                        let [near, far] = possible_median(list, off(list));
                        let z = f64::from(median[pixel]);
                        assert!(
                            near <= z && z <= far,
                            "{kernel:?} {order:?}, {pixel}: median {z}, from {near} to {far}"
                        );
                        let ([wanted, slack], z) = (possible_mean(list), f64::from(mean[pixel]));
                        assert!(
                            (z - wanted).abs() <= slack,
                            "{kernel:?} {order:?}, {pixel}: mean {z}, not {wanted}, {slack}"
                        );
                        known += usize::from(near == far || far - near < 1e-2);
                        longest = longest.max(list.len());
                    }
                }
            }
        }
        println!("{known} medians are known, in lists of up to {longest}");
        assert!(known > 20_000 && longest > 256, "{known} {longest}");
    });
}

#[test]
fn exact_methods_have_the_same_bytes() {
    with_device(|device| {
        let size = [90, 70];
        let points = Soup { seed: 31, count: 400, degree: 1, opacities: 0.0..0.6, ..Soup::default() }.points();
        for (i, camera) in [cameras()[0], cameras()[1]].into_iter().enumerate() {
            // Kernels by turns with orders: every pair of camera, kernel, order and method.
            let all = KERNELS.into_iter().flat_map(|kernel| ORDERS.map(|order| (kernel, order)));
            for (kernel, order) in all.skip(i).step_by(2) {
                let discs = discs(kernel, order);
                let asked = |method| Frame { depths: true, ..encoded(camera, size, method) };
                let first = render(device, &points, &asked(Method::ABuffer(discs)));
                let hardware = Discs { raster: Raster::Hardware, ..discs };
                let mut others = vec![
                    Method::ABuffer(hardware),
                    Method::LinkedList(discs),
                    Method::Peel(Peel { discs, ..Peel::default() }),
                    Method::Peel(Peel { discs: hardware, ..Peel::default() }),
                ];
                if order != Order::Pixel {
                    others.push(Method::Sorted(discs));
                }
                for method in others {
                    let other = render(device, &points, &asked(method));
                    assert!(bits(&other) == bits(&first), "{method:?}");
                    assert_eq!(other.fragments, first.fragments);
                    assert!(other.depth_median == first.depth_median && other.depth_mean == first.depth_mean);
                }
            }
        }
    });
}

#[test]
fn neither_order_of_input_nor_budget_changes_a_byte() {
    with_device(|device| {
        let size = [90, 70];
        let soup = Soup { seed: 41, count: 300, degree: 2, ..Soup::default() };
        let points = soup.points();
        let mut places: Vec<u32> = (0..300).collect();
        places.shuffle(&mut random(1));
        let shuffled = order::canonical(soup.unordered().subset(&places, 1.0));
        let methods = [
            Method::ABuffer(discs(Kernel::Ewa, Order::Pixel)),
            Method::Sorted(discs(Kernel::Ewa, Order::Center)),
            Method::Peel(Peel { discs: discs(Kernel::Ray, Order::Pixel), ..Peel::default() }),
            Method::Hybrid(Hybrid { discs: discs(Kernel::Ewa, Order::Pixel), ..Hybrid::default() }),
            Method::Hybrid(Hybrid { discs: discs(Kernel::Ewa, Order::Distance), ..Hybrid::default() }),
            Method::Hybrid(Hybrid {
                discs: discs(Kernel::Ewa, Order::Pixel),
                k: 11,
                core_alpha_min: 0.05,
                ..Hybrid::default()
            }),
            Method::Weighted(discs(Kernel::Ray, Order::Pixel)),
            Method::Average(discs(Kernel::Ewa, Order::Center)),
            Method::Stochastic(Stochastic {
                discs: discs(Kernel::Ewa, Order::Pixel),
                samples: 8,
                ..Stochastic::default()
            }),
        ];
        for method in methods {
            let whole = encoded(perspective(), size, method);
            let image = render(device, &points, &whole);
            let other = render(device, &shuffled, &whole);
            assert!(bits(&other) == bits(&image), "{}: shuffled", method.name());
            let tight = Frame { memory_budget: Some(1 << 19), ..whole };
            let other = render(device, &points, &tight);
            assert!(bits(&other) == bits(&image), "{}: in 512 KiB", method.name());
        }
    });
}

#[test]
fn approximations_are_those_of_the_reference() {
    with_device(|device| {
        let size = [80, 60];
        let points = Soup { seed: 51, count: 100, degree: 1, ..Soup::default() }.points();
        for order in ORDERS {
            let discs = discs(Kernel::Ewa, order);
            let hybrid = |k| Method::Hybrid(Hybrid { discs, k, ..Hybrid::default() });
            let mlab = Method::Mlab(Mlab { discs, nodes: 3 });
            for method in [Method::Weighted(discs), Method::Average(discs), hybrid(3), hybrid(11), mlab] {
                let frame = encoded(perspective(), size, method);
                let image = render(device, &points, &frame);
                let colors = shaded(&points, &frame);
                let wanted = reference::approximate::render(View::new(&frame.camera, size), &points, &colors, &method)
                    .expect("one");
                // Sums that are divided: their errors are those of opacities over the sum of these, which is at least
                // one opacity.
                let clear: Vec<_> = clear_pixels(&points, &frame, &discs.gaussians, &colors)
                    .into_iter()
                    .map(|bound| bound.map(|bound| 300.0 * bound))
                    .collect();
                assert_like(&image, &wanted, &clear);
                let clear_depths =
                    clear.iter().zip(image.depth.iter().zip(&wanted.depth)).filter(|(clear, _)| clear.is_some());
                for (_, (found, wanted)) in clear_depths {
                    let close = (f64::from(*found) - wanted).abs() <= 1e-3 * wanted.abs();
                    assert!(
                        close || (found.is_infinite() && wanted.is_infinite()),
                        "{order:?} {method:?}: {found} {wanted}"
                    );
                }
            }
        }
    });
}

#[test]
fn samples_converge_to_the_lists() {
    with_device(|device| {
        let size = [60, 40];
        let points = Soup { seed: 61, count: 80, ..Soup::default() }.points();
        let discs = discs(Kernel::Ewa, Order::Pixel);
        let exact = render(device, &points, &encoded(perspective(), size, Method::ABuffer(discs)));
        for raster in RASTERS {
            let settings = Stochastic { discs: Discs { raster, ..discs }, samples: 1024, ..Stochastic::default() };
            let frame = Frame { spread: true, ..encoded(perspective(), size, Method::Stochastic(settings)) };
            let image = render(device, &points, &frame);
            let stderr = image.stderr.as_ref().expect("a standard error");
            let mut off = Vec::new();
            for (pixel, error) in stderr.iter().enumerate() {
                // Opacity is exact but for the order of its roundings.
                assert!((image.rgba[pixel][3] - exact.rgba[pixel][3]).abs() < 1e-4);
                if error[0] > 1e-4 {
                    off.push(f64::from((image.rgba[pixel][0] - exact.rgba[pixel][0]) / error[0]));
                }
            }
            let rms = (off.iter().map(|t| t * t).sum::<f64>() / off.len() as f64).sqrt();
            assert!(off.len() > 300 && rms < 1.2, "{rms} standard errors over {} pixels", off.len());
        }
    });
}

/// Two that cross: each is in front on its side, by pixels; by centers one is everywhere.
#[test]
fn crossing_gaussians_change_their_order_across_the_image() {
    with_device(|device| {
        let tilted = |angle: f32| Quat::from_rotation_y(angle);
        let gaussians = Gaussians {
            extents: vec![Vec3::new(0.5, 0.5, 0.01); 2],
            rotations: vec![tilted(0.6), tilted(-0.6)],
            bases: vec![Vec3::X, Vec3::Y],
            ..Gaussians::default()
        };
        let points = Points {
            positions: vec![DVec3::ZERO, DVec3::new(0.0, 0.0, -1e-3)],
            colors: vec![Vec3::X, Vec3::Y],
            opacities: vec![0.9; 2],
            radii: vec![REACH * 0.5; 2],
            gaussians: Some(gaussians),
            ..Points::default()
        };
        let points = order::canonical(points);
        let camera = Camera::look_at(3.0 * DVec3::Z, DVec3::ZERO, DVec3::Y, Perspective { fov_y: 0.5 }, 0.1, 10.0)
            .expect("valid");
        let of =
            |order| render(device, &points, &encoded(camera, [40, 20], Method::ABuffer(discs(Kernel::Ewa, order))));
        let redder = |image: &Image, x: usize| image.rgba[10 * 40 + x][0] > image.rgba[10 * 40 + x][1];
        let (pixel, center) = (of(Order::Pixel), of(Order::Center));
        assert_ne!(redder(&pixel, 12), redder(&pixel, 28));
        assert!(redder(&center, 12) && redder(&center, 28));
    });
}

#[test]
fn discs_and_gaussians_share_their_lists() {
    with_device(|device| {
        let size = [80, 60];
        let discs_alone = scene(&soup(71, 60, 0.05..0.3, 0.2..0.8, true));
        let mut mixed = Soup { seed: 72, count: 60, degree: 1, ..Soup::default() }.unordered();
        mixed.append(discs_alone.clone());
        let mixed = order::canonical(mixed);
        for shape in SHAPES {
            for order in ORDERS {
                let settings = Discs { shape, ..discs(Kernel::Ewa, order) };
                let frame = frame(perspective(), size, Method::ABuffer(settings));
                let image = render(device, &mixed, &frame);
                let colors = shaded(&mixed, &frame);
                let wanted = reference::abuffer::render(View::new(&frame.camera, size), &mixed, &colors, &settings);
                let (_, share) = difference(&image, &wanted, 1e-3);
                // Rims of discs, borders of Gaussians and orders that roundings decide.
                assert!(share < 0.02, "{shape:?} {order:?}: {share}");
                let others = [Method::LinkedList(settings), Method::Peel(Peel { discs: settings, ..Peel::default() })];
                for method in others {
                    let other = render(device, &mixed, &Frame { method, ..frame });
                    assert!(bits(&other) == bits(&image), "{method:?}");
                }
                let opaque_to_none = render(device, &discs_alone, &frame);
                assert!(bits(&opaque_to_none) != bits(&image));
            }
        }
    });
}

#[test]
fn one_order_of_splats_is_none_for_each_pixel() {
    with_device(|device| {
        let points = Soup::default().points();
        let mut renderer = Renderer::new(device).expect("a renderer");
        let mut cloud = renderer.upload(&points).expect("the cloud fits");
        let frame = encoded(perspective(), [8, 8], Method::Sorted(discs(Kernel::Ewa, Order::Pixel)));
        let refused = renderer.render(&mut cloud, &frame).expect_err("no such order");
        assert!(matches!(refused, Error::OneOrder) && refused.to_string().contains("abuffer"), "{refused}");
    });
}
