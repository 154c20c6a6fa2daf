//! Clouds whose points come to the device window by window: the same bytes as with all of them there.

use std::sync::Arc;

use glam::DVec3;
use pellucid_core::points::Points;
use pellucid_engine::methods::{Frame, Renderer};
use pellucid_scene::{Light, Method, Shading, ShadingModel, Shadows};
use pellucid_testing::{bits, by_windows, frame, perspective, scene, soup, with_device};

/// Points with normals and fields: many times as many as come at a time.
fn points() -> Arc<Points> {
    let mut points = scene(&soup(41, 60_000, 0.002..0.02, 0.1..0.9, true));
    points.fields = points.positions.iter().map(|p| (0.5 + 0.5 * p.x).clamp(0.0, 1.0) as f32).collect();
    Arc::new(points)
}

#[test]
fn every_method_renders_the_same_bytes_window_by_window() {
    let points = points();
    with_device(|device| {
        let mut renderer = Renderer::new(device).expect("a renderer");
        let mut differ = Vec::new();
        for method in Method::all().into_iter().filter(|method| !method.is_dealt()) {
            let whole = Frame { fragments: true, ..frame(perspective(), [160, 120], method) };
            let mut cloud = renderer.upload(&*points).expect("room for the points");
            let expected = renderer.render(&mut cloud, &whole).expect("a frame");
            // Room for some 30,000 points.
            let small = Frame { memory_budget: Some(9 << 20), ..whole };
            let mut supplied = by_windows(&renderer, &points);
            for pass in 0..2 {
                match renderer.render(&mut supplied, &small) {
                    Ok(found) => {
                        assert!(supplied.len() < 40_000, "{}: {} points at once", method.name(), supplied.len());
                        if bits(&found.image) != bits(&expected.image)
                            || found.image.fragments != expected.image.fragments
                        {
                            let (a, b) = (&found.image, &expected.image);
                            let pixels: Vec<usize> = (0..a.rgba.len())
                                .filter(|i| a.rgba[*i] != b.rgba[*i] || a.depth[*i].to_bits() != b.depth[*i].to_bits())
                                .collect();
                            let counts = a
                                .fragments
                                .iter()
                                .flatten()
                                .zip(b.fragments.iter().flatten())
                                .filter(|(a, b)| a != b)
                                .count();
                            let first = pixels
                                .first()
                                .map(|i| (i % 160, i / 160, a.rgba[*i], b.rgba[*i], a.depth[*i], b.depth[*i]));
                            differ.push(format!(
                                "{} ({pass}): {} pixels, first {first:?}, {counts} counts, {} windows",
                                method.name(),
                                pixels.len(),
                                found.facts.windows
                            ));
                        }
                    }
                    Err(error) => differ.push(format!("{}: {error}", method.name())),
                }
            }
        }
        assert!(differ.is_empty(), "{}", differ.join("\n"));
    });
}

#[test]
fn points_without_normals_find_their_shares_of_light_window_by_window() {
    let points = Arc::new(scene(&soup(43, 60_000, 0.002..0.02, 0.9..1.0, false)));
    assert!(points.normals.is_none());
    let lamp = Light::Direction(DVec3::new(0.3, -0.8, 0.1).normalize());
    let shading = Shading { model: ShadingModel::Lambert, light: lamp, ..Shading::default() };
    let shadows = Some(Shadows { samples: 2, light_radius: 3.0, ..Shadows::default() });
    with_device(|device| {
        let mut renderer = Renderer::new(device).expect("a renderer");
        for method in Method::all().into_iter().filter(|method| method.name() == "circles") {
            let whole = Frame { shading, shadows, ..frame(perspective(), [160, 120], method) };
            let mut cloud = renderer.upload(&*points).expect("room for the points");
            let expected = renderer.render(&mut cloud, &whole).expect("a frame");
            let unlit = renderer.render(&mut cloud, &Frame { shadows: None, ..whole }).expect("a frame");
            assert!(bits(&expected.image) != bits(&unlit.image), "there are shadows");
            let mut supplied = by_windows(&renderer, &points);
            let small = Frame { memory_budget: Some(9 << 20), ..whole };
            let found = renderer.render(&mut supplied, &small).expect("a frame");
            assert!(found.facts.windows > 1 && bits(&found.image) == bits(&expected.image));
            // The same image of the same light has the same holes.
            assert!(cloud.light_holes().is_some() && supplied.light_holes() == cloud.light_holes());
        }
    });
}
