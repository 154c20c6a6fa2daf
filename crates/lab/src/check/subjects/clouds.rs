//! The points of the subjects: they cause ties, long lists, full tiles and large splats.

use glam::{DVec3, Quat, Vec3};

use pellucid_core::cloud::gaussians::{Gaussians, REACH, coefficients};
use pellucid_core::points::Points;
use pellucid_core::random::threefry2x32;

/// A number in [0, 1) for a point, of several that it has.
fn part(cloud: u32, point: u32, which: u32) -> f64 {
    f64::from(threefry2x32([point, which], [cloud, 0x706f_696e])[0]) / 4_294_967_296.0
}

/// A point of the unit ball's surface, nearly evenly: corners of the cube get no more than faces.
fn direction(cloud: u32, point: u32) -> DVec3 {
    let candidate =
        |turn: u32| DVec3::from_array([0, 1, 2].map(|axis| 2.0 * part(cloud, point, 3 * turn + axis) - 1.0));
    let inside = |v: &DVec3| (0.01..1.0).contains(&v.length_squared());
    let found = (10..30).map(candidate).find(inside).unwrap_or(DVec3::X);
    found / found.length()
}

/// Makes a point from its number.
struct Recipe {
    count: u32,
    position: fn(u32, u32) -> (DVec3, DVec3),
    /// Least and largest.
    radius: [f64; 2],
    opacity: [f64; 2],
}

fn cloud(number: u32, recipe: &Recipe) -> Points {
    let between = |[low, high]: [f64; 2], part: f64| (low + (high - low) * part) as f32;
    let column = |make: &dyn Fn(u32) -> f32| (0..recipe.count).map(make).collect::<Vec<f32>>();
    let places: Vec<(DVec3, DVec3)> = (0..recipe.count).map(|i| (recipe.position)(number, i)).collect();
    let color = |i: u32| Vec3::from_array([0, 1, 2].map(|channel| part(number, i, channel) as f32));
    Points {
        positions: places.iter().map(|(position, _)| position.as_vec3().as_dvec3()).collect(),
        colors: (0..recipe.count).map(color).collect(),
        opacities: column(&|i| match i % 50 {
            // Both ends, now and then.
            7 => 0.0,
            31 => 1.0,
            _ => between(recipe.opacity, part(number, i, 3)),
        }),
        radii: column(&|i| if i % 40 == 3 { 0.0 } else { between(recipe.radius, part(number, i, 4)) }),
        // Some are missing.
        normals: Some(
            places
                .iter()
                .zip(0..)
                .map(|((_, normal), i): (_, u32)| if i % 29 == 5 { Vec3::ZERO } else { normal.as_vec3() })
                .collect(),
        ),
        fields: column(&|i| part(number, i, 5) as f32),
        ..Points::default()
    }
}

/// A ball's surface; every third point on a grid, so that depths and places coincide.
fn ball(count: u32) -> Points {
    let position = |cloud, i: u32| {
        let normal = direction(cloud, i);
        (if i.is_multiple_of(3) { (normal * 8.0).round() / 8.0 } else { normal }, normal)
    };
    cloud(1, &Recipe { count, position, radius: [0.02, 0.15], opacity: [0.05, 0.8] })
}

/// A floor below.
fn floor(count: u32) -> Points {
    let position = |cloud, i| {
        let [x, z] = [0, 1].map(|axis| 3.0 * part(cloud, i, 60 + axis) - 1.5);
        (DVec3::new(x, -1.0, z), DVec3::Y)
    };
    cloud(2, &Recipe { count, position, radius: [0.04, 0.1], opacity: [0.3, 0.3] })
}

/// `count` points within a pixel or two: long lists, and tiles with more splats than fit one run.
fn knot(count: u32) -> Points {
    let position = |cloud, i| {
        let normal = direction(cloud, i);
        (DVec3::new(0.5, 0.25, 0.75) + 0.06 * part(cloud, i, 70) * normal, normal)
    };
    cloud(3, &Recipe { count, position, radius: [0.005, 0.06], opacity: [0.002, 0.02] })
}

/// A few splats that are visited tile by tile.
fn large() -> Points {
    let position = |cloud, i| (DVec3::new(-0.5, 0.0, -1.0) + 0.5 * direction(cloud, i), direction(cloud, i + 100));
    cloud(4, &Recipe { count: 6, position, radius: [1.2, 1.8], opacity: [0.1, 0.3] })
}

/// Returns clouds for methods whose time grows with the longest list.
pub(super) fn few() -> Vec<Points> {
    vec![ball(700), floor(300), knot(60), large()]
}

/// Lists beyond 256 fragments, tiles beyond 2048 splats.
pub(super) fn many() -> Vec<Points> {
    vec![ball(1500), floor(500), knot(2300), large()]
}

/// Makes Gaussians of points: needles and plates among them, with harmonics of degree 2.
fn gaussians(number: u32, points: Points) -> Points {
    const DEGREE: u32 = 2;
    let count = points.len() as u32;
    let signed = |i: u32, which: u32| 2.0 * part(number, i, which) - 1.0;
    let extents: Vec<Vec3> = (0..count)
        .map(|i| {
            let radius = 0.02 + f64::from(points.radii[i as usize]) / 2.0;
            // One axis in three is thin.
            let axis =
                |axis: u32| if (i + axis).is_multiple_of(3) { 0.02 } else { 0.2 + 0.8 * part(number, i, 80 + axis) };
            Vec3::from_array([0, 1, 2].map(|which| (radius * axis(which)) as f32))
        })
        .collect();
    let rotation = |i: u32| {
        let q = [90, 91, 92, 93].map(|which| signed(i, which) + 0.001);
        let length = (q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]).sqrt();
        Quat::from_array(q.map(|component| (component / length) as f32))
    };
    let coefficient = |i: u32, k: u32| Vec3::from_array([0, 1, 2].map(|c| 0.2 * signed(i, 100 + 3 * k + c) as f32));
    let own = coefficients(DEGREE) as u32;
    let splats = Gaussians {
        rotations: (0..count).map(rotation).collect(),
        bases: points.colors.clone(),
        degree: DEGREE,
        harmonics: (0..count).flat_map(|i| (0..own).map(move |k| (i, k))).map(|(i, k)| coefficient(i, k)).collect(),
        extents,
        ..Gaussians::default()
    };
    let radii = splats.extents.iter().map(|extents| REACH * extents.max_element()).collect();
    Points { normals: None, radii, gaussians: Some(splats), ..points }
}

/// Gaussians, for methods whose time grows with the longest list.
pub(super) fn few_gaussians() -> Vec<Points> {
    vec![gaussians(11, ball(500)), gaussians(13, knot(40)), gaussians(14, large())]
}

/// Gaussians in lists beyond 256 fragments and tiles beyond 2048 splats.
pub(super) fn many_gaussians() -> Vec<Points> {
    vec![gaussians(11, ball(1200)), gaussians(13, knot(2300)), gaussians(14, large())]
}

/// Gaussians among discs.
pub(super) fn mixed() -> Vec<Points> {
    vec![gaussians(11, ball(600)), floor(400), knot(300), large()]
}

/// Only soft points; lists beyond 256 events.
pub(super) fn soft_alone() -> Vec<Points> {
    let soft =
        |points: Points| Points { fields: points.fields.iter().map(|f| 0.5 + f / 2.0 + 0.001).collect(), ..points };
    vec![soft(ball(400)), soft(knot(200)), soft(large())]
}

/// Surfaces alone.
pub(super) fn surfaces() -> Vec<Points> {
    vec![ball(2500), floor(1200)]
}

/// More points than are kept on the device for a small budget.
pub(super) fn crowd() -> Vec<Points> {
    vec![ball(70_000), floor(900)]
}

/// Returns the points in another order, that of their words for the seed.
pub(super) fn shuffled(points: &Points, seed: u32) -> Points {
    let mut order: Vec<(u32, usize)> =
        (0..points.len()).map(|i| (threefry2x32([i as u32, seed], [5, 5])[0], i)).collect();
    order.sort_unstable();
    points.clone().in_order(|place| order[place].1)
}
