//! Facts that a picture of a cloud would meet, found on the host without a device: spacing, and layers on a pixel.

use glam::DVec3;
use rayon::prelude::*;

use super::covered::Pixels;
use super::document::Document;
use super::framed::Framed;
use super::framing::camera;
use super::overrides::Overrides;
use super::scene::Scene;
use super::surroundings;
use crate::prepare::sampled::{Sampled, sample};
use crate::prepare::{DEFAULT_NEIGHBORS, radius};
use pellucid_core::camera::{Camera, Projection};
use pellucid_core::cloud::Cloud;
use pellucid_core::points::Points;

/// Discs that are drawn into one map of covered pixels before it is joined with others.
const RUN: usize = 1 << 14;

/// Points that a camera is found for, at most: it fits all of them, one by one and several times.
const FITTED: usize = 1 << 18;

/// Rows of discs that are drawn, at most: where discs are larger or more, every nth of them stands for its neighbors.
const ROWS: u64 = 1 << 28;

/// Facts that the automatic view of a cloud meets, at the default size and without any setting.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Overview {
    /// The median distance of a point to the nearest other place that has one, in the file's units, from at most 2048
    /// places; `None` of fewer than two.
    pub spacing: Option<f64>,
    /// The mean number of splats that cover a covered pixel; `None` if there is no such view, or nothing to see.
    pub layers: Option<f64>,
    /// `true` if the points surround their middle as those of a room do, so that the camera stands among them.
    pub inside: bool,
}

/// Looks at a cloud. Its splats are discs that face the screen, with the file's radii, else those of Eq. 20 (K = 24),
/// which are found for at most 2048 places and hold for the points after each of them on the Morton curve. Every disc's
/// pixels are counted; of up to 2048 places the number of layers is exactly that of the picture.
pub fn overview(cloud: &Cloud) -> Overview {
    let rule = (DEFAULT_NEIGHBORS, radius::DEFAULT_CAP);
    let Sampled { spacing, positions, radii } = sample(&cloud.positions, cloud.radii.as_deref(), rule);
    let points = Points { positions, radii, sensor: cloud.sensor, ..Points::default() };
    // An empty cloud and coordinates that no camera takes have no view.
    let Some((camera, size, inside)) = automatic(cloud, &some_of(&points)) else {
        return Overview { spacing, ..Overview::default() };
    };
    Overview { spacing, layers: layers(&camera, size, &points), inside }
}

/// Every nth point along the Morton curve.
fn some_of(points: &Points) -> Points {
    let step = points.len().div_ceil(FITTED).max(1);
    let positions = points.positions.iter().copied().step_by(step).collect();
    let radii = points.radii.iter().copied().step_by(step).collect();
    Points { positions, radii, sensor: points.sensor, ..Points::default() }
}

/// The automatic camera, the default size, and whether the camera stands within the points.
fn automatic(cloud: &Cloud, points: &Points) -> Option<(Camera, [u32; 2], bool)> {
    let document = Document::from_clouds(["cloud"], &Overrides::default()).ok()?;
    let scene: Scene = document.scene().ok()?;
    let (camera, _) = camera(&scene, points, cloud.up).ok()?;
    let vertical = scene.camera.vertical(cloud.up);
    let framed = Framed::of(&scene, points).map(|(framed, _)| framed);
    let inside = framed.is_some_and(|framed| surroundings::inside(&scene.camera, &framed, vertical).is_some());
    Some((camera, scene.image.size, inside))
}

/// The mean number of discs on the pixels that have any; `None` if no pixel has.
fn layers(camera: &Camera, size: [u32; 2], points: &Points) -> Option<f64> {
    let disc = |position: &DVec3, radius: &f32| {
        let (center, z) = camera.project(*position, size);
        is_in_depth(camera, z).then(|| (center, f64::from(*radius) * camera.pixels_per_unit(z, size[1])))
    };
    let height = f64::from(size[1]);
    let discs = points.positions.par_iter().zip(&points.radii);
    let of_one = |radius: f64| (2.0 * radius + 1.0).min(height) as u64;
    let rows: u64 = discs.filter_map(|(p, r)| disc(p, r)).map(|(_, radius)| of_one(radius)).sum();
    let step = rows.div_ceil(ROWS).max(1) as usize;
    let runs = points.positions.par_chunks(RUN).zip(points.radii.par_chunks(RUN));
    let drawn = runs.fold(
        || Pixels::none(size),
        |mut pixels, (positions, radii)| {
            let discs = positions.iter().zip(radii).step_by(step).filter_map(|(p, r)| disc(p, r));
            discs.for_each(|(center, radius)| pixels.cover(center, radius));
            pixels
        },
    );
    let all = drawn.reduce(|| Pixels::none(size), Pixels::joined);
    let [fragments, covered] = all.counts();
    (covered > 0).then(|| step as f64 * fragments as f64 / covered as f64)
}

fn is_in_depth(camera: &Camera, z: f64) -> bool {
    let before_eye = z > 0.0 || matches!(camera.projection, Projection::Orthographic { .. });
    before_eye && (camera.near..=camera.far).contains(&z)
}

#[cfg(test)]
mod tests {
    use glam::DVec2;
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg64;

    use super::*;
    use pellucid_core::cloud::UpAxis;
    use pellucid_reference::View;
    use pellucid_reference::abuffer;

    fn random(count: usize) -> Vec<DVec3> {
        let mut random = Pcg64::seed_from_u64(5);
        (0..count).map(|_| DVec3::new(random.random(), random.random(), random.random())).collect()
    }

    /// Fragments and covered pixels by the reference of the picture.
    fn counted(camera: &Camera, size: [u32; 2], points: &Points) -> f64 {
        let points = Points { opacities: vec![1.0; points.len()], ..points.clone() };
        let lists = abuffer::lists(View::new(camera, size), &points, &Default::default());
        let lengths: Vec<usize> = lists.iter().map(Vec::len).filter(|length| *length > 0).collect();
        lengths.iter().sum::<usize>() as f64 / lengths.len() as f64
    }

    #[test]
    fn small_clouds_have_the_layers_of_their_picture() {
        // Radii that are given, from less than a pixel to a part of the picture, and those of Eq. 20.
        let given: Vec<f32> = (0..300).map(|i| 1e-5 * 1.03f32.powi(i)).collect();
        for radii in [Some(given), None] {
            let cloud = Cloud { positions: random(300), radii, up: UpAxis::Z, ..Cloud::default() };
            let rule = (DEFAULT_NEIGHBORS, radius::DEFAULT_CAP);
            let Sampled { positions, radii, .. } = sample(&cloud.positions, cloud.radii.as_deref(), rule);
            let points = Points { positions, radii, ..Points::default() };
            let (camera, size, inside) = automatic(&cloud, &points).unwrap();
            let found = overview(&cloud);
            assert_eq!((found.layers, found.inside), (Some(counted(&camera, size, &points)), inside));
            // Where the picture cuts discs off, too.
            let near = Camera { eye: camera.eye + 0.6 * camera.forward, ..camera };
            assert_eq!(layers(&near, [70, 50], &points), Some(counted(&near, [70, 50], &points)));
        }
    }

    #[test]
    fn layers_by_hand() {
        let camera = |height: f64| Camera {
            eye: DVec3::new(4.0, 4.0, 10.0),
            right: DVec3::X,
            up: DVec3::Y,
            forward: -DVec3::Z,
            projection: Projection::Orthographic { height },
            near: 1.0,
            far: 20.0,
            shift: DVec2::ZERO,
        };
        // A picture of 8 × 8 pixels of size 1. Two discs cover the same 4 pixels, one half of them; one more is behind.
        let at = [[4.0, 4.0, 0.0], [4.0, 4.0, 2.0], [4.5, 4.5, 1.0], [1.5, 1.5, 1.0], [4.0, 4.0, -20.0]];
        let points = Points {
            positions: at.map(DVec3::from).to_vec(),
            radii: vec![0.8, 0.8, 0.0, 0.3, 1.0],
            ..Points::default()
        };
        // 4 + 4 + 1 + 1 fragments on 4 + 1 pixels.
        assert_eq!(layers(&camera(8.0), [8, 8], &points), Some(2.0));
        let nothing = Points { positions: vec![DVec3::splat(100.0)], radii: vec![1.0], ..Points::default() };
        assert_eq!(layers(&camera(8.0), [8, 8], &nothing), None);
    }

    #[test]
    fn clouds_without_a_view_have_no_layers() {
        assert_eq!(overview(&Cloud::default()), Overview::default());
        let one = Cloud { positions: vec![DVec3::ONE], ..Cloud::default() };
        assert_eq!(overview(&one), Overview { spacing: None, layers: Some(1.0), inside: false });
        let huge = Cloud { positions: random(9).iter().map(|p| 1e300 * *p).collect(), ..Cloud::default() };
        assert_eq!(overview(&huge).layers, None);
    }
}
