//! Parts of an image, rendered alone: the pixels of the whole.

use std::sync::Arc;

use pellucid_core::image::Image;
use pellucid_core::points::Points;
use pellucid_engine::methods::{Frame, Renderer};
use pellucid_engine::passes::bands::Window;
use pellucid_scene::{Discs, Edl, Method, Shading};
use pellucid_testing::{bits, by_windows, frame, perspective, scene, soup, with_device};

const SIZE: [u32; 2] = [160, 112];

/// Rows of whole tiles, and a rectangle that cuts some.
const REGIONS: [Window; 4] = [[0, 0, 160, 16], [0, 16, 160, 64], [0, 64, 77, 112], [77, 64, 160, 112]];

fn points() -> Points {
    let mut points = scene(&soup(51, 3_000, 0.01..0.1, 0.1..0.9, true));
    points.fields = points.positions.iter().map(|p| (0.5 + 0.5 * p.x).clamp(0.0, 1.0) as f32).collect();
    points
}

/// Copies a region's pixels.
fn take(into: &mut Image, from: &Image, [x0, y0, x1, y1]: Window) {
    for y in y0..y1 {
        let row = (y * SIZE[0] + x0) as usize..(y * SIZE[0] + x1) as usize;
        into.rgba[row.clone()].copy_from_slice(&from.rgba[row.clone()]);
        into.depth[row.clone()].copy_from_slice(&from.depth[row.clone()]);
        if let (Some(into), Some(from)) = (&mut into.fragments, &from.fragments) {
            into[row.clone()].copy_from_slice(&from[row]);
        }
    }
}

#[test]
fn regions_have_the_pixels_of_the_whole() {
    let points = points();
    with_device(|device| {
        let mut differ = Vec::new();
        for method in Method::all().into_iter().filter(|method| !method.is_dealt()) {
            let mut renderer = Renderer::new(device).expect("a renderer");
            let whole = Frame { fragments: true, ..frame(perspective(), SIZE, method) };
            let mut cloud = renderer.upload(&points).expect("room for the points");
            let expected = renderer.render(&mut cloud, &whole).expect("a frame").image;
            let mut found = expected.clone();
            found.rgba.fill([-1.0; 4]);
            for region in REGIONS {
                renderer.region = Some(region);
                let part = renderer.render(&mut cloud, &whole).expect("a region").image;
                take(&mut found, &part, region);
            }
            if bits(&found) != bits(&expected) || found.fragments != expected.fragments {
                differ.push(method.name());
            }
        }
        assert!(differ.is_empty(), "{differ:?}");
    });
}

#[test]
fn eye_dome_lighting_comes_once_all_regions_are_there() {
    let points = points();
    with_device(|device| {
        for method in Method::all().into_iter().filter(Method::takes_edl) {
            let mut renderer = Renderer::new(device).expect("a renderer");
            let plain = frame(perspective(), SIZE, method);
            let edl = Edl { edl: true, ..Edl::default() };
            let lit = Frame { shading: Shading { edl, ..plain.shading }, ..plain };
            let mut cloud = renderer.upload(&points).expect("room for the points");
            let expected = renderer.render(&mut cloud, &lit).expect("a frame").image;
            let mut found = expected.clone();
            for region in REGIONS {
                renderer.region = Some(region);
                let part = renderer.render(&mut cloud, &lit).expect("a region").image;
                take(&mut found, &part, region);
                if let Some(medians) = part.depth_median {
                    let into = found.depth_median.get_or_insert_with(|| medians.clone());
                    for y in region[1]..region[3] {
                        let row = (y * SIZE[0] + region[0]) as usize..(y * SIZE[0] + region[2]) as usize;
                        into[row.clone()].copy_from_slice(&medians[row]);
                    }
                }
            }
            renderer.region = None;
            renderer.apply_edl(&cloud, &lit, &mut found).expect("eye-dome lighting");
            assert_eq!(bits(&found), bits(&expected), "{}", method.name());
        }
    });
}

#[test]
fn clouds_that_come_window_by_window_bring_what_a_region_shows() {
    let points = Arc::new(points());
    with_device(|device| {
        let mut renderer = Renderer::new(device).expect("a renderer");
        let whole = frame(perspective(), SIZE, Method::ABuffer(Discs::default()));
        let mut supplied = by_windows(&renderer, &points);
        let expected = renderer.render(&mut supplied, &whole).expect("a frame").image;
        let mut found = expected.clone();
        found.rgba.fill([-1.0; 4]);
        for region in REGIONS {
            renderer.region = Some(region);
            take(&mut found, &renderer.render(&mut supplied, &whole).expect("a region").image, region);
        }
        assert_eq!(bits(&found), bits(&expected));
    });
}
