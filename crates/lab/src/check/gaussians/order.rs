//! The order of splats: ties, by pixels, by depths and distances of centers, among discs.

use glam::Quat;

use super::super::stage;
use super::alone::Shares;
use super::before;
use super::shapes::some;
use super::splats::{Splat, SplatView, cloud, part, turned, unordered};
use super::together::Float64Scene;
use crate::check::prelude::*;
use pellucid_scene::prepare::order;

const PRIMARIES: [Vec3; 3] = [Vec3::X, Vec3::Y, Vec3::Z];

fn ordered(order: Order) -> GaussianSettings {
    GaussianSettings { order: Some(order), ..GaussianSettings::default() }
}

/// Splats in one place, at two depths.
fn tied() -> Vec<Splat> {
    let color = |i: u32| Vec3::new((i % 7) as f32 / 7.0, (i % 5) as f32 / 5.0, (i % 3) as f32 / 3.0);
    let splat = |i: u32| Splat {
        position: at(2, 2, if i < 40 { 2.0 } else { 3.0 }),
        extents: [Vec3::new(1.0, 0.5, 0.25), Vec3::new(0.25, 1.0, 0.5)][(i % 2) as usize],
        rotation: turned(i % 4),
        opacity: 0.3,
        base: color(i),
        ..Splat::default()
    };
    (0..80).map(splat).collect()
}

pub(super) fn ties(stage: &mut CaseRenderer, method: Method) -> CaseResult {
    let view = SplatView::new(pixels([5, 5]), [5, 5], GaussianSettings::default(), &method);
    let splats = tied();
    let mut other = splats.clone();
    other[..40].rotate_left(13);
    other[40..].rotate_left(29);
    other.swap(0, 77);
    let first = stage.render(&cloud(&splats), &view.frame(method))?.image;
    let second = stage.render(&cloud(&other), &view.frame(method))?.image;
    // In the order of arrival, in the middle.
    let arrived = |splats: &[Splat]| {
        let dots: Vec<Dot> = splats.iter().map(|splat| dot(-splat.position.z, splat.base, splat.opacity)).collect();
        [over(&dots)]
    };
    let naive = bytes_between(&arrived(&splats), &arrived(&other));
    Ok(Finding::new(bytes_apart(&first, &second), 0.0, naive))
}

pub(super) fn crossing(stage: &mut CaseRenderer, method: Method) -> CaseResult {
    let plate = |(i, angle): (usize, &f32)| Splat {
        position: DVec3::new(0.0, 0.0, -1e-3 * i as f64),
        extents: Vec3::new(0.5, 0.5, 0.01),
        rotation: Quat::from_rotation_y(*angle),
        opacity: 0.8,
        base: PRIMARIES[i],
        ..Splat::default()
    };
    let points = cloud(&[0.6, -0.5, 0.1].iter().enumerate().map(plate).collect::<Vec<_>>());
    let view = SplatView::new(before(3.0, 30.0), [63, 48], ordered(Order::Pixel), &method);
    let scene = Float64Scene { view, points: &points, color: ColorSpace::Encoded };
    // In the order of their centers, everywhere.
    let naive = Float64Scene { view: SplatView { settings: ordered(Order::Center), ..view }, ..scene };
    Ok(scene.compare(stage, method, &naive.pixels())?.finding())
}

pub(super) fn by_centers(stage: &mut CaseRenderer, method: Method) -> CaseResult {
    // Farther to the side, nearer in depth, so that the two orders are opposite.
    let places = [(0.0, -5.0), (2.0, -4.9), (4.0, -4.5), (-3.5, -4.6)];
    let splat = |(i, (x, z)): (usize, &(f64, f64))| Splat {
        position: DVec3::new(*x, 0.1 * i as f64, *z),
        extents: Vec3::new(3.0, 2.0, 0.5),
        opacity: 0.7,
        base: PRIMARIES[i % 3],
        ..Splat::default()
    };
    let points = cloud(&places.iter().enumerate().map(splat).collect::<Vec<_>>());
    let camera = perspective(DVec3::ZERO, DVec3::NEG_Z, 80.0, 0.1, 100.0);
    let orders = [Order::Center, Order::Distance];
    let view = |order| SplatView::new(camera, [48, 36], ordered(order), &method);
    let scene = |order| Float64Scene { view: view(order), points: &points, color: ColorSpace::Encoded };
    let [center, distance] = orders.map(|order| scene(order).pixels());
    let shares = scene(Order::Center).compare(stage, method, &distance)?;
    Ok(shares.and(scene(Order::Distance).compare(stage, method, &center)?).finding())
}

/// Splats and discs in a cube.
fn both() -> (Points, Points) {
    let splats = some(30, Vec3::new(0.3, 0.2, 0.1), 1.0).into_iter().zip(0..);
    let splats = splats.map(|(splat, i)| Splat { opacity: 0.5, base: PRIMARIES[i % 3], ..splat });
    let disc = |i: u32| Dot {
        position: DVec3::from_array([30, 31, 32].map(|which| part(i, which))),
        color: PRIMARIES[(i % 3) as usize],
        opacity: 0.4,
        radius: 0.25,
        ..Dot::default()
    };
    (unordered(&splats.collect::<Vec<_>>()), stage::cloud(&(0..30).map(disc).collect::<Vec<_>>()))
}

pub(super) fn mixed(stage: &mut CaseRenderer, method: Method) -> CaseResult {
    let (splats, discs) = both();
    let mut all = splats.clone();
    all.append(discs.clone());
    let all = order::canonical(all);
    let splats = order::canonical(splats);
    let view = SplatView::new(before(5.0, 35.0), [64, 48], GaussianSettings::default(), &method);
    let scene = |points| Float64Scene { view, points, color: ColorSpace::Linear };
    // The picture of the splats over that of the discs.
    let over = |(front, back): ([f64; 4], [f64; 4])| std::array::from_fn(|c| front[c] + (1.0 - front[3]) * back[c]);
    let naive: Vec<[f64; 4]> = scene(&splats).pixels().into_iter().zip(scene(&discs).pixels()).map(over).collect();
    let shares: Shares = scene(&all).compare(stage, method, &naive)?;
    Ok(shares.finding())
}
