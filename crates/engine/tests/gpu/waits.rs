//! How often the host waits for the device.

use pellucid_engine::methods::{Frame, Renderer};
use pellucid_engine::scene::{Family, Method};
use pellucid_testing::{frame, perspective, scene, soup, with_device};

/// Waits of a steady frame in one window and band whose lists nobody asks for. Those of ensembles depend on how many there are,
/// and those of `peel` on the layers.
const WAITS: [(&str, u64); 22] = [
    ("points", 1),
    ("squares", 2),
    ("circles", 2),
    ("paraboloid", 2),
    ("cone", 2),
    ("sphere", 2),
    ("abuffer", 3),
    ("linked-list", 3),
    ("sorted", 3),
    ("peel-layers", 4),
    ("stochastic", 7),
    ("hybrid", 3),
    ("weighted", 3),
    ("average", 3),
    ("unsorted", 3),
    ("hqs", 4),
    ("splats", 4),
    ("image-space", 1),
    ("soft-base", 6),
    ("soft-concentric", 6),
    ("soft-express", 6),
    ("one-layer", 8),
];

#[test]
fn a_steady_frame_waits_no_more_often_than_it_has_to() {
    with_device(|device| {
        let mut points = scene(&soup(7, 400, 0.02..0.1, 0.1..0.9, true));
        points.fields = (0..points.len()).map(|i| (i % 2) as f32).collect();
        let mut found = Vec::new();
        let is_fixed = |method: &Method| method.family() != Family::Ensembles && !matches!(method, Method::Peel(_));
        for method in Method::all().into_iter().filter(is_fixed) {
            let mut renderer = Renderer::new(device).expect("a renderer");
            let mut cloud = renderer.upload(&points).expect("fits");
            let frame = Frame { fragments: false, ..frame(perspective(), [64, 48], method) };
            renderer.render(&mut cloud, &frame).expect("renders");
            let steady = renderer.render(&mut cloud, &frame).expect("renders");
            found.push((method.name(), steady.profile.waits));
        }
        assert_eq!(found, WAITS);
    });
}
