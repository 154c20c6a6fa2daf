//! Lists of Gaussians and of mixed scenes, and what each method makes of them.

use pellucid_reference::abuffer::{mean_depth, median};
use pellucid_reference::gaussians::{depth_of_key, with_depths};
use pellucid_reference::{approximate, peel, stochastic};
use pellucid_scene::{Hybrid, Method, Stochastic};

use super::*;

/// The pixel in the middle of [`SIZE`].
const MIDDLE: usize = 40;

fn by(kernel: Kernel, order: Order) -> Discs {
    Discs { gaussians: GaussianSettings { order: Some(order), ..bare(kernel) }, ..Discs::default() }
}

fn indices(list: &[Fragment]) -> Vec<u32> {
    list.iter().map(|fragment| fragment.index).collect()
}

/// Two pancakes through each other, the first tilted so that it is nearer on the left.
fn crossing() -> Points {
    scene(&[pancake(-5.0 * DVec3::Z, 4.0, 40.0, 0.5), pancake(-5.25 * DVec3::Z, 4.0, -40.0, 0.5)])
}

#[test]
fn splats_that_cross_change_places_from_pixel_to_pixel() {
    for kernel in [Kernel::Ewa, Kernel::Ray] {
        let of = |order: Order| lists(View::new(&orthographic(), SIZE), &crossing(), &by(kernel, order));
        let (pixel, center) = (of(Order::Pixel), of(Order::Center));
        for x in 0..9 {
            // 5 + x tan 40° and 5.25 − x tan 40° are equal at x = 0.149.
            let nearest = if x <= 4 { [0, 1] } else { [1, 0] };
            assert_eq!(indices(&pixel[36 + x]), nearest, "{kernel:?} {x}");
            assert_eq!(indices(&center[36 + x]), [0, 1], "{kernel:?} {x}");
        }
        // A thousandth of thickness (ewa) tilts the plane by no more than 1e-6; the angle is float32.
        let slope = f64::from(40f32).to_radians().tan();
        assert_close(pixel[38][0].z, 5.0 - 2.0 * slope, 1e-5);
        assert_eq!(center[38][0].z, 5.0);
        assert_eq!(pixel[38][0].alpha, center[38][0].alpha);
    }
}

#[test]
fn without_an_order_it_is_that_of_the_pixel_and_of_the_center_when_sorted() {
    let none = Discs { gaussians: bare(Kernel::Ewa), ..Discs::default() };
    let all = crossing();
    let of = |discs: &Discs| lists(View::new(&orthographic(), SIZE), &all, discs);
    assert_eq!(of(&none), of(&by(Kernel::Ewa, Order::Pixel)));
    let sorted = sorted::lists(View::new(&orthographic(), SIZE), &all, &none);
    assert_eq!(sorted, of(&by(Kernel::Ewa, Order::Center)));
}

#[test]
fn distance_and_depth_order_otherwise() {
    // At the side and 4 deep it is √(4² + 3²) = 5 from the eye, before it and 4.5 deep it is 4.5.
    let points = scene(&[ball(DVec3::new(3.0, 0.0, -4.0), 4.0, 0.5), ball(-4.5 * DVec3::Z, 4.0, 0.5)]);
    let of = |camera: &Camera, order: Order| {
        lists(View::new(camera, SIZE), &points, &by(Kernel::Ewa, order)).swap_remove(MIDDLE)
    };
    assert_eq!(indices(&of(&perspective(), Order::Center)), [0, 1]);
    let list = of(&perspective(), Order::Distance);
    assert_eq!(indices(&list), [1, 0]);
    assert_eq!(list.iter().map(|fragment| fragment.z).collect::<Vec<_>>(), [4.5, 5.0]);
    assert_eq!(indices(&of(&orthographic(), Order::Distance)), [0, 1]);
    // Images show depths.
    let settings = by(Kernel::Ewa, Order::Distance);
    let shown = with_depths(&perspective(), &points, &settings.gaussians, &list);
    assert_eq!(shown.iter().map(|fragment| fragment.z).collect::<Vec<_>>(), [4.5, 4.0]);
    let depth = |key: f64| depth_of_key(&perspective(), &points, &settings.gaussians, &list, key);
    assert_eq!([depth(4.5), depth(5.0), depth(f64::INFINITY)], [4.5, 4.0, f64::INFINITY]);
    for order in [None, Some(Order::Center), Some(Order::Distance)] {
        let settings = GaussianSettings { order, ..bare(Kernel::Ewa) };
        let wanted = if order == Some(Order::Distance) { [1, 0] } else { [0, 1] };
        assert_eq!(sorted::order(&perspective(), &points, &settings), wanted);
        let discs = Discs { gaussians: settings, ..Discs::default() };
        let list = &sorted::lists(View::new(&perspective(), SIZE), &points, &discs)[MIDDLE];
        assert_eq!(indices(list), wanted.map(|index| index as u32));
        assert_eq!(list[0].z, if wanted[0] == 0 { 4.0 } else { 4.5 });
    }
}

#[test]
fn images_by_distance_show_depths_along_the_axis() {
    // The nearest one by distance is 3 deep, at 5.
    let points = scene(&[ball(DVec3::new(4.0, 0.0, -3.0), 4.0, 0.5), ball(-6.0 * DVec3::Z, 4.0, 0.5)]);
    let (camera, colors, discs) = (perspective(), [DVec3::X, DVec3::Y], by(Kernel::Ewa, Order::Distance));
    assert_eq!(lists(View::new(&camera, SIZE), &points, &discs)[MIDDLE][0].z, 5.0);
    let stochastic = Stochastic { discs, samples: 64, alpha_correction: true };
    let hybrid = Method::Hybrid(Hybrid { discs, k: 1, ..Hybrid::default() });
    let pictures = [
        abuffer::render(View::new(&camera, SIZE), &points, &colors, &discs),
        sorted::render(View::new(&camera, SIZE), &points, &colors, &discs),
        peel::render(View::new(&camera, SIZE), &points, &colors, &discs, 0),
        approximate::render(View::new(&camera, SIZE), &points, &colors, &hybrid).unwrap(),
        stochastic::render(View::new(&camera, SIZE), &points, &colors, &stochastic, 1).0,
    ];
    for picture in pictures {
        assert_eq!(picture.depth[MIDDLE], 3.0);
        assert_eq!(picture.counts[MIDDLE], 2);
    }
}

/// A disc 5 deep between two balls, and one of them behind near.
fn mixed() -> Points {
    let balls = [ball(-4.0 * DVec3::Z, 2.0, 0.5), ball(-6.0 * DVec3::Z, 2.0, 0.25), ball(-0.4 * DVec3::Z, 2.0, 0.9)];
    let mut points = scene(&balls);
    points.gaussians.as_mut().unwrap().append(Gaussians::none(1));
    points.positions.push(-5.0 * DVec3::Z);
    points.colors.push(Vec3::ONE);
    points.opacities.push(0.5);
    points.radii.push(1.2);
    points
}

#[test]
fn discs_and_gaussians_share_a_list() {
    let points = mixed();
    let colors = [DVec3::X, DVec3::Y, DVec3::ONE, DVec3::Z];
    for order in [Order::Center, Order::Distance, Order::Pixel] {
        let discs = by(Kernel::Ewa, order);
        let all = lists(View::new(&orthographic(), SIZE), &points, &discs);
        let of = |pixel: usize| all[pixel].iter().map(|f| (f.index, f.z, f.alpha)).collect::<Vec<_>>();
        assert_eq!(of(MIDDLE), [(0, 4.0, 0.5), (3, 5.0, 0.5), (1, 6.0, 0.25)]);
        // The disc ends after a pixel.
        let beside = (-0.5f64).exp();
        let [near, far] = [(0, 0.5 * beside), (1, 0.25 * beside)];
        assert_eq!(indices(&all[MIDDLE + 2]), [near.0, far.0]);
        assert_close(all[MIDDLE + 2][0].alpha, near.1, ROUNDING);
        assert_close(all[MIDDLE + 2][1].alpha, far.1, ROUNDING);
        let picture = abuffer::render(View::new(&orthographic(), SIZE), &points, &colors, &discs);
        // 1/2 red, half of the rest blue, a quarter of the rest green.
        let wanted = [0.5, 0.0625, 0.25, 0.8125];
        picture.rgba[MIDDLE].iter().zip(wanted).for_each(|(got, want)| assert_close(*got, want, ROUNDING));
        let sorted = sorted::render(View::new(&orthographic(), SIZE), &points, &colors, &discs);
        let peeled = peel::render(View::new(&orthographic(), SIZE), &points, &colors, &discs, 0);
        for other in [sorted, peeled] {
            assert_eq!(picture.counts, other.counts);
            for (a, b) in picture.rgba.iter().flatten().zip(other.rgba.iter().flatten()) {
                assert_close(*a, *b, ROUNDING);
            }
        }
    }
}

#[test]
fn only_lists_with_gaussians_end_early() {
    let points = mixed();
    let colors = [DVec3::X, DVec3::Y, DVec3::ONE, DVec3::Z];
    let ending = |stop: f32| {
        let discs = by(Kernel::Ewa, Order::Center);
        Discs { gaussians: GaussianSettings { stop, ..discs.gaussians }, ..discs }
    };
    // A half is left behind the first, a quarter behind the disc, 3/16 behind the last.
    for (stop, wanted) in [(0.1, 0.8125), (0.2, 0.75), (0.3, 0.5), (0.6, 0.0)] {
        let discs = ending(stop);
        let pictures = [
            abuffer::render(View::new(&orthographic(), SIZE), &points, &colors, &discs),
            sorted::render(View::new(&orthographic(), SIZE), &points, &colors, &discs),
            peel::render(View::new(&orthographic(), SIZE), &points, &colors, &discs, 0),
        ];
        for picture in &pictures {
            assert_close(picture.rgba[MIDDLE][3], wanted, ROUNDING);
            assert_eq!(picture.depth[MIDDLE], if stop > 0.5 { f64::INFINITY } else { 4.0 });
        }
        // Lists have their whole length, layers are those that were blended.
        assert_eq!((pictures[0].counts[MIDDLE], pictures[1].counts[MIDDLE]), (3, 3));
        let layers = [0.8125, 0.75, 0.5, 0.0].iter().position(|a| *a == wanted).map(|ended| 3 - ended as u32);
        assert_eq!(Some(pictures[2].counts[MIDDLE]), layers);
    }
    let mut alone = mixed();
    alone.gaussians = None;
    let of = |stop: f32| abuffer::render(View::new(&orthographic(), SIZE), &alone, &colors, &ending(stop));
    assert_eq!(of(0.6), of(0.0));
}

#[test]
fn some_pixels_have_the_lists_of_all() {
    let discs = by(Kernel::Ray, Order::Pixel);
    let all = lists(View::new(&perspective(), SIZE), &mixed(), &discs);
    let some = lists_at(View::new(&perspective(), SIZE), &mixed(), &discs, &[3, 40, 41]);
    assert_eq!(some, [3, 40, 41].map(|pixel: usize| all[pixel].clone()));
}

#[test]
fn median_and_mean_depth() {
    let fragment = |z: f64, alpha: f64| Fragment { z, index: 0, alpha };
    let list = [fragment(2.0, 0.25), fragment(3.0, 0.5), fragment(5.0, 0.5)];
    // Transmittance 3/4, 3/8, 3/16.
    assert_eq!(median(&list, 0.5), 3.0);
    assert_eq!(median(&list[..1], 0.5), f64::INFINITY);
    assert_close(mean_depth(&list), (2.0 * 0.25 + 3.0 * 0.375 + 5.0 * 0.1875) / 0.8125, ROUNDING);
    assert_close(mean_depth(&list[..1]), 2.0, ROUNDING);
    assert_eq!(mean_depth(&[]), f64::INFINITY);
    assert_eq!(mean_depth(&[fragment(1.0, 0.0)]), f64::INFINITY);
    assert_close(mean_depth(&[fragment(4.0, 1.0), fragment(5.0, 1.0)]), 4.0, ROUNDING);
}
