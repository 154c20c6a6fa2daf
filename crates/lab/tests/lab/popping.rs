//! Flicker of opaque points where the answer is known: two discs beside each other, of which one and then the other is
//! nearer by a hair.

use std::sync::Arc;

use glam::{DVec3, Vec3};
use pellucid_core::camera::{Camera, Projection};
use pellucid_core::points::Points;
use pellucid_core::progress::Progress;
use pellucid_engine::methods::Frame;
use pellucid_lab::report::popping::{self, Curve, Film};
use pellucid_scene::prepare::Arranged;
use pellucid_scene::{Method, ScreenSplats};
use pellucid_testing::with_device;

/// Pixels of the image, ten to a world unit.
const SIZE: [u32; 2] = [48, 32];
/// Half the distance of the centers, and the radius, in pixels: the borders of the discs pass no pixel's center.
const HALF: f64 = 4.0;
const RADIUS: f64 = 10.3;
/// Degrees that the camera turns to each side: depths differ by 3e-4 units, and nothing moves by a thousandth pixel.
const TURN: f64 = 0.02;

/// A red and a blue disc at x = ∓0.4, of radius 1.03.
fn pair() -> Points {
    Points {
        positions: [-1.0, 1.0].map(|side| DVec3::X * side * HALF / 10.0).to_vec(),
        colors: vec![Vec3::X, Vec3::Z],
        opacities: vec![1.0; 2],
        radii: vec![(RADIUS / 10.0) as f32; 2],
        ..Points::default()
    }
}

/// A camera that turned about the vertical through the origin.
fn turned(degrees: f64) -> Camera {
    let (sin, cos) = degrees.to_radians().sin_cos();
    let lens = Projection::Orthographic { height: 3.2 };
    Camera::look_at(5.0 * DVec3::new(sin, 0.0, cos), DVec3::ZERO, DVec3::Y, lens, 0.1, 20.0).expect("a valid camera")
}

/// RMSE of the change if all pixels in both splats turn from red to blue: two of three channels change by 1.
fn expected(is_within: impl Fn([f64; 2]) -> bool) -> f64 {
    let [width, height] = SIZE.map(f64::from);
    let centers = (0..SIZE[1]).flat_map(|y| (0..SIZE[0]).map(move |x| [x, y].map(|at| f64::from(at) + 0.5)));
    let in_both =
        |[x, y]: &[f64; 2]| [-HALF, HALF].iter().all(|center| is_within([x - 0.5 * width - center, y - 0.5 * height]));
    (centers.filter(in_both).count() as f64 * 2.0 / (3.0 * width * height)).sqrt()
}

#[test]
fn two_discs_that_change_their_order_flicker_by_their_common_area_and_paraboloids_not_at_all() {
    with_device(|device| {
        let points = pair();
        let own = Method::Circles(ScreenSplats::default());
        let candidates = popping::candidates(&own, &points, &[]);
        let method = popping::reference(&own, &points).expect("surfaces have a reference");
        let frame = Frame::new(turned(-TURN), SIZE, method);
        let cameras = [-TURN, TURN, -TURN].map(turned);
        let arranged = Arranged::Canonical(Arc::new(points));
        let film = Film { arranged: &arranged, frame: &frame, background: Vec3::ZERO, cameras: &cameras };
        let found = popping::measure(device, &film, &candidates, &Progress::hidden()).expect("measures");
        assert_eq!((found.exact.as_str(), found.refused.len()), ("hqs with 4 × 4 samples in a pixel", 0));
        let curve = |method: &str| -> &Curve { found.curves.iter().find(|c| c.method == method).unwrap() };
        let lens = expected(|[x, y]| x * x + y * y <= RADIUS * RADIUS);
        let overlap = expected(|[x, y]| x.abs().max(y.abs()) <= RADIUS);
        for (method, change) in [
            ("circles", lens),
            ("squares", overlap),
            ("paraboloid", 0.0),
            ("cone", 0.0),
            ("sphere", 0.0),
            ("hqs", 0.0),
            ("points", 0.0),
        ] {
            let Curve { mean_rmse, worst_rmse, rolled_rmse, .. } = curve(method);
            assert!((mean_rmse - change).abs() < 1e-4 && (worst_rmse - change).abs() < 1e-4, "{method}: {mean_rmse}");
            // So little motion changes nothing by itself.
            assert!(rolled_rmse.unwrap() < 1e-4, "{method}: {rolled_rmse:?}");
        }
        // Some 200 of 1536 pixels.
        assert!(lens > 0.25 && overlap > lens, "{lens} {overlap}");
    });
}
