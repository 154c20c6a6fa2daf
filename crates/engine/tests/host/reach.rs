//! Gaussians of a window: it takes all that have a fragment in it.

use glam::DVec3;
use pellucid_core::camera::{Camera, Projection};
use pellucid_core::cloud::Bounds;
use pellucid_engine::passes::project::{Beam, PointExtent};
use pellucid_reference::View;
use pellucid_reference::gaussians::{footprint, gaussian};
use pellucid_scene::supply::Block;
use pellucid_scene::{GaussianSettings, Kernel, Order};
use pellucid_testing::gaussians::Soup;

#[test]
fn every_gaussian_with_a_fragment_in_a_window_is_taken() {
    // Small and huge ones, around the eye as well.
    let soup = Soup { seed: 9, count: 1500, extents: 0.002..0.5, opacities: 0.3..1.0, degree: 0 };
    let points = soup.unordered();
    let size = [80, 48];
    let projections = [Projection::Perspective { fov_y: 1.2 }, Projection::Orthographic { height: 1.0 }];
    let (mut seen, mut taken) = (0, 0);
    for (projection, eye) in projections.into_iter().flat_map(|p| [(p, 0.2), (p, 2.5)]) {
        let camera = Camera::look_at(DVec3::new(0.1, -eye, 0.1), DVec3::ZERO, DVec3::Z, projection, 0.05, 20.0);
        let camera = camera.expect("a camera");
        for settings in [
            GaussianSettings::default(),
            GaussianSettings { alpha_min: 1e-5, dilation: 4.0, ..GaussianSettings::default() },
            GaussianSettings { kernel: Kernel::Ray, alpha_min: 1e-3, ..GaussianSettings::default() },
        ] {
            let extent = PointExtent::gaussians(&settings, &camera, size);
            for window in [[0, 0, 8, 8], [36, 20, 44, 28], [70, 40, 80, 48]] {
                let beam = Beam::new(&camera, size, window, extent);
                for (i, position) in points.positions.iter().enumerate() {
                    let of = gaussian(&points, i).expect("a Gaussian");
                    let hits = footprint(View::new(&camera, size), &of, &settings, Order::Center);
                    let is_in =
                        |x: u32, y: u32| (window[0]..window[2]).contains(&x) && (window[1]..window[3]).contains(&y);
                    let shows = hits.iter().any(|hit| is_in(hit.x, hit.y));
                    let radius = points.radii[i];
                    let is_taken = beam.meets_point(*position, radius);
                    assert!(is_taken || !shows, "{settings:?}, {projection:?}: {position}, {radius}");
                    let bounds = Bounds { min: *position, max: *position + 0.01 };
                    let block = Block { bounds, radius, points: 1, branch: None };
                    assert!(beam.meets(&block) || !shows, "{block:?}");
                    seen += u32::from(shows);
                    taken += u32::from(is_taken);
                }
            }
        }
    }
    // Balls are larger than the ellipsoids in them, and those in the corners of wide images larger still.
    assert!(seen > 1000 && taken < 8 * seen, "{taken} for {seen}");
}
