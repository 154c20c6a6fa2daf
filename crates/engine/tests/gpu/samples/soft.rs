//! Soft spheres and the discs that stand for them.

use pellucid_reference::soft::{Behind, Model, Scene, express};
use pellucid_scene::{Density, Shells, Soft};

use super::*;

fn settings() -> Soft {
    Soft { density: Density::Softness(0.6), ..Soft::default() }
}

/// The reference of spheres; near rims roundings decide depths and counts.
fn spheres(points: &Points, camera: &Camera, method: Method) -> PictureRange {
    let case = crate::soft_accuracy::Case::of(points.clone(), *camera, SIZE);
    let mut ranges = PictureRange::of_picture(&case.reference(method), crate::soft_accuracy::DEPTH_BOUND);
    let roundings = crate::soft_accuracy::DEPTH_ROUNDINGS * f64::from(points.radii.iter().copied().fold(0.0, f32::max));
    for (pixel, is_open) in case.doubtful().into_iter().enumerate() {
        let depth = &mut ranges.depth[pixel];
        *depth = match is_open {
            true => Range { low: 0.0, high: f64::INFINITY },
            false if depth.is_finite() => depth.widened(roundings),
            false => *depth,
        };
        if is_open {
            ranges.counts[pixel] = ranges.counts[pixel].widened(1e3);
        }
    }
    ranges
}

#[test]
fn spheres_are_the_mean_of_their_references() {
    with_device(|device| {
        let points = crate::soft_accuracy::cloud(&crate::soft_accuracy::soft_soup(3, 80, 0.02..0.4));
        let shells = Soft { shells: Shells::Fixed(3), ..settings() };
        for camera in cameras() {
            for method in [Method::SoftBase(settings()), Method::SoftConcentric(shells)] {
                let image = |one: &One| spheres(&points, one.camera, method);
                let (name, frame) = (format!("{method:?}"), frame(camera, SIZE, method));
                let slack = crate::soft_accuracy::BOUND;
                Subject { name, points: &points, frame, image: Box::new(image), slack, counts: true }.check(device);
            }
        }
    });
}

/// The reference of presorted discs. Next to a rim an opacity of nothing and of next to nothing differ by rounding, and
/// with them the depth of the first disc.
fn discs(points: &Points, colors: &[DVec3], camera: &Camera, method: Method) -> PictureRange {
    let model = Model::new(method.as_soft().expect("a soft method"), points);
    let view = View::new(camera, SIZE);
    let picture = Scene { view, points, colors, model }.render(|_| Behind::NOTHING);
    let mut ranges = PictureRange::of_picture(&picture, 2e-5);
    let lists = express::lists(view, points, &model, Some, ranges.rgba.len());
    for (depth, list) in ranges.depth.iter_mut().zip(lists) {
        if list.iter().any(|fragment| fragment.alpha < 1e-5) {
            *depth = Range { low: 0.0, high: f64::INFINITY };
        }
    }
    ranges
}

#[test]
fn presorted_discs_are_the_mean_of_their_references() {
    with_device(|device| {
        let points = crate::soft_accuracy::cloud(&crate::soft_accuracy::soft_soup(5, 150, 0.05..0.4));
        let colors = colors(&points);
        let modulated = Soft { modulation: Some(1.5), ..settings() };
        for camera in cameras() {
            for method in [Method::SoftExpress(settings()), Method::SoftExpress(modulated)] {
                let image = |one: &One| discs(&points, &colors, one.camera, method);
                let (name, frame) = (format!("{method:?}"), frame(camera, SIZE, method));
                // As at one sample.
                Subject { name, points: &points, frame, image: Box::new(image), slack: 2e-5, counts: false }
                    .check(device);
            }
        }
    });
}
