//! Georeferenced coordinates: a scene and its camera at 500 km east and 4500 km north give the same bytes as at the
//! origin. Positions lie on a grid of 1/1024, so that float64 moves them without rounding. And scenes in other units.

use super::prelude::*;
use pellucid_engine::Error;
use pellucid_scene::{Density, DiscShape, Family, ImageSpace, PeelLayers, Shells, Soft};

const SIZE: [u32; 2] = [40, 30];
/// d̃, whose default depends on the box of all points.
const DISTANCE: f32 = 0.25;
const LAYERS: u32 = 4;
const BY: DVec3 = DVec3::new(500_000.0, 4_500_000.0, 100.0);

pub(super) fn cases() -> Vec<Case> {
    let soft = Soft { density: Density::Softness(0.4), shells: Shells::Fixed(3), ..Soft::default() };
    // The others go the way of one of these.
    let like = |method: &Method| {
        let discs = matches!(method, Method::LinkedList(_) | Method::Average(_) | Method::Unsorted(_));
        discs || matches!(method, Method::Squares(_) | Method::Cone(_) | Method::Sphere(_))
    };
    let families = [Family::Discs, Family::Opaque, Family::Soft, Family::OneLayer, Family::Surfaces];
    let methods = with_samples(8, except(like, of_families(&families)));
    let tuned = |method| with_distance(with_soft(method, soft), DISTANCE);
    let mut methods: Vec<Method> = methods.into_iter().map(tuned).collect();
    let oriented = Discs { shape: DiscShape::Oriented, ..Discs::default() };
    methods.insert(1, Method::ABuffer(oriented));
    let about = "moved by (500000, 4500000, 100): no byte changes";
    let scales = "times 2^30 and 2^-30, camera and all: no byte of a color changes";
    // The others number their random words by points, and the scene has one more of them.
    let known = |method: &&Method| !matches!(method, Method::Stochastic(_));
    let others: Vec<Method> = methods.iter().filter(known).copied().collect();
    let outliers = "a point at 1e20 that is not seen: colors as without it";
    let mut all = [
        each(&methods, "georeferenced", moved).about(about),
        each(&methods, "scaled", scaled).about(scales),
        each(&others, "outlier", outlier).about(outliers),
    ];
    // Two of them are of one method.
    all.iter_mut().for_each(|cases| cases[1].name += "-oriented");
    all.into_iter().flatten().collect()
}

/// Points of [`in_cube`], one in three with a field that makes it soft.
fn dots() -> Vec<Dot> {
    let dot = |i: u32| Dot {
        position: in_cube(i),
        color: mixed(i),
        opacity: 0.1 + 0.1 * (i % 8) as f32,
        radius: 0.05 + 0.01 * (i % 16) as f32,
        normal: Vec3::new((i % 9) as f32 - 4.0, (i % 4) as f32 - 1.5, 2.0).normalize(),
        field: if i.is_multiple_of(3) { 0.0 } else { 1.0 },
    };
    (1..400).map(dot).collect()
}

fn camera() -> Camera {
    // The eye lies on the grid, too.
    perspective(DVec3::new(0.5, 0.75, 3.5), DVec3::ZERO, 45.0, 0.125, 128.0)
}

fn moved(stage: &mut CaseRenderer, method: Method) -> CaseResult {
    let mut render = |dots: &[Dot], camera: Camera| -> Result<Image> {
        Ok(stage.render(&cloud(dots), &Frame::new(camera, SIZE, method))?.image)
    };
    let dots = dots();
    let here = render(&dots, camera())?;
    let (far, far_camera) = shifted(&dots, camera(), BY);
    let there = render(&far, far_camera)?;
    // Positions in float32: the same picture of what is left of them.
    let single = render(&rounded(&far), far_camera)?;
    Ok(Finding::new(bytes_apart(&here, &there), 0.0, bytes_apart(&here, &single)))
}

fn scaled(stage: &mut CaseRenderer, method: Method) -> CaseResult {
    let mut render = |factor: f64| -> Result<Vec<[f32; 4]>> {
        let scaled = |dot: &Dot| Dot { position: dot.position * factor, radius: dot.radius * factor as f32, ..*dot };
        let dots: Vec<Dot> = dots().iter().map(scaled).collect();
        let camera = camera();
        let camera =
            Camera { eye: camera.eye * factor, near: camera.near * factor, far: camera.far * factor, ..camera };
        let method = with_distance(method, DISTANCE * factor as f32);
        Ok(stage.render(&cloud(&dots), &Frame::new(camera, SIZE, method))?.image.rgba)
    };
    let plain = render(1.0)?;
    let mut error = 0.0;
    for power in [30, -30] {
        let other = render(2f64.powi(power))?;
        let differ =
            |(a, b): (&[f32; 4], &[f32; 4])| a.iter().zip(b).filter(|(a, b)| a.to_bits() != b.to_bits()).count();
        error += plain.iter().zip(&other).map(differ).sum::<usize>() as f64;
    }
    // If a radius below 1e-6 counted as zero, the small scene would be empty.
    let is_drawn = dots().iter().any(|dot| dot.radius * 2f32.powi(-30) > 1e-6);
    let lost = plain.iter().flatten().filter(|c| **c > 0.0 && !is_drawn).count();
    Ok(Finding::new(error, 0.0, lost as f64))
}

/// Returns the method with another d̃, if it has one.
fn with_distance(method: Method, distance: f32) -> Method {
    let apart = |filters| ImageSpace { min_layer_distance: Some(distance), ..filters };
    match method {
        Method::ImageSpace(filters) => Method::ImageSpace(apart(filters)),
        Method::PeelLayers(layers) => Method::PeelLayers(PeelLayers { filters: apart(layers.filters), ..layers }),
        method => method,
    }
}

fn outlier(stage: &mut CaseRenderer, method: Method) -> CaseResult {
    let mut render = |dots: &[Dot]| Ok::<_, Error>(stage.image(dots, camera(), SIZE, method)?.rgba);
    let dots = dots();
    let alone = render(&dots)?;
    let far = Dot { position: DVec3::new(1e20, -1e20, 1e20), radius: 0.1, opacity: 0.5, ..Dot::default() };
    let with = render(&[dots.as_slice(), &[far]].concat())?;
    // Counted from the middle of a box that holds them all, the others fall together.
    let middle = 0.5 * far.position;
    let rounded = |dot: &Dot| Dot { position: (dot.position - middle) + middle, ..*dot };
    let lost = render(&dots.iter().map(rounded).collect::<Vec<_>>())?;
    let wanted: Vec<[f64; 4]> = alone.iter().map(|pixel| pixel.map(f64::from)).collect();
    let bound = if method.soft().is_some() {
        // A corner of the box lies behind the camera, so that depths are counted from the eye: two ends of each of ten
        // spheres on a ray, rounded by half a unit of 8, at an absorption λ r of at most 7 for a unit of length.
        10.0 * 2.0 * 8.0 * HALF_ULP * 7.0
    } else if method.filters().is_some() {
        // The zero of depths changes, too: an edge has 8 depths below 8, each with 4 roundings, over 4 d̃; half of it
        // is the share of the neighbors. Smoothing adds 18 roundings; color and alpha of a layer affect all behind it.
        let edge = 8.0 * 4.0 * 8.0 / (4.0 * f64::from(DISTANCE)) / 2.0;
        2.0 * f64::from(LAYERS) * (edge + 18.0) * HALF_ULP
    } else {
        // The order of points in memory changes, and with it that of sums: compensated ones, as for equal colors.
        18.0 * HALF_ULP
    };
    Ok(Finding::pixels(&with, &lost, &wanted, bound))
}
