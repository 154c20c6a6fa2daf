//! The filters of `image-space` on tiny images written as text: a digit is a pixel at that depth, a dot is background.

use super::*;
use pellucid_reference::image_space::{Layer, layer_distance, render};
use pellucid_scene::{ImageSpace, Iterations};

/// Far behind all digits.
const FAR: f64 = 100.0;

/// Red is the depth, so that it shows where a pixel's values came from.
fn layer(rows: &[&str]) -> Layer {
    let width = rows[0].len();
    assert!(rows.iter().all(|row| row.len() == width));
    let depth: Vec<f64> =
        rows.iter().flat_map(|row| row.chars()).map(|c| c.to_digit(10).map_or(f64::INFINITY, f64::from)).collect();
    let rgba = depth.iter().map(|d| if d.is_finite() { [*d, 0.0, 0.0, 1.0] } else { [0.0; 4] });
    Layer { size: [width as u32, rows.len() as u32], rgba: rgba.collect(), depth }
}

/// The other way round; color and depth must have moved together.
#[track_caller]
fn text(layer: &Layer) -> Vec<String> {
    for (depth, rgba) in layer.depth.iter().zip(&layer.rgba) {
        assert_eq!(*rgba, if depth.is_finite() { [*depth, 0.0, 0.0, 1.0] } else { [0.0; 4] });
    }
    let digit = |d: &f64| if d.is_finite() { char::from_digit(*d as u32, 10).unwrap() } else { '.' };
    layer.depth.chunks(layer.size[0] as usize).map(|row| row.iter().map(digit).collect()).collect()
}

/// A field of ones with a square hole in its middle, two pixels from the border on each side.
fn square_hole(side: usize) -> Layer {
    let row = |y: usize| -> String {
        (0..side + 4)
            .map(|x| if (2..side + 2).contains(&x) && (2..side + 2).contains(&y) { '.' } else { '1' })
            .collect()
    };
    let rows: Vec<String> = (0..side + 4).map(row).collect();
    layer(&rows.iter().map(String::as_str).collect::<Vec<_>>())
}

fn holes(layer: &Layer) -> usize {
    layer.depth.iter().filter(|d| d.is_infinite()).count()
}

#[test]
fn a_hole_takes_the_nearest_neighbor() {
    assert_eq!(text(&layer(&["234", "5.6", "789"]).filled()), ["234", "526", "789"]);
    assert_eq!(text(&layer(&["9999", "9..9", "9949", "9999"]).filled()), ["9999", "9449", "9949", "9999"]);
    // Equal depths are decided by what there is, not by where: the smaller color.
    let mut tied = layer(&["999", "2.2", "999"]);
    for (places, wanted) in [([3, 5], 0.25), ([5, 3], 0.25)] {
        tied.rgba[places[0]] = [0.25, 0.0, 0.0, 1.0];
        tied.rgba[places[1]] = [0.5, 0.0, 0.0, 1.0];
        assert_eq!(tied.filled().rgba[4][0], wanted);
    }
}

#[test]
fn square_holes_are_eaten_from_their_corners() {
    assert_eq!(text(&square_hole(2).filled())[2], "111111");
    let once = square_hole(3).filled();
    assert_eq!(text(&once)[2..5], ["111.111", "11...11", "111.111"]);
    // After so many iterations, and not one earlier. A hole of n pixels is filled after n only up to 6: the straight
    // sides of a hole are silhouettes, which stay, and what is eaten from the corners runs along them in turns.
    let wanted = [1, 1, 2, 3, 5, 6, 8, 9, 11, 12, 14];
    for (side, wanted) in (1..).zip(wanted) {
        let mut layer = square_hole(side);
        for iteration in 1..=wanted {
            assert!(holes(&layer) > 0, "{side} pixels are filled before iteration {iteration}");
            layer = layer.filled();
        }
        assert_eq!(holes(&layer), 0, "{side} pixels");
    }
    // ⌊3n/2⌋ − 2 for odd n above 1, − 3 for even n above 2.
    assert!((3..=11).all(|n: usize| wanted[n - 1] == 3 * n / 2 - 3 + n % 2));
}

#[test]
fn round_holes_of_n_pixels_are_filled_after_n_iterations() {
    for diameter in 1..=15usize {
        let center = (diameter as f64 - 1.0) / 2.0 + 2.0;
        let is_hole = |x: usize, y: usize| {
            4.0 * ((x as f64 - center).powi(2) + (y as f64 - center).powi(2)) <= (diameter * diameter) as f64
        };
        let rows: Vec<String> = (0..diameter + 4)
            .map(|y| (0..diameter + 4).map(|x| if is_hole(x, y) { '.' } else { '1' }).collect())
            .collect();
        let mut layer = layer(&rows.iter().map(String::as_str).collect::<Vec<_>>());
        assert!(holes(&layer) > 0);
        for _ in 0..diameter {
            layer = layer.filled();
        }
        assert_eq!(holes(&layer), 0, "{diameter} pixels");
    }
}

#[test]
fn slits_close_at_once() {
    assert_eq!(text(&layer(&["1111", "....", "1111"]).filled())[1], "1111");
    // Two pixels wide, no mask of background sees one of its pixels kept inside: each has five consecutive ones.
    let wide = layer(&["111111", "1....1", "1....1", "111111"]);
    assert_eq!(text(&wide.filled()), ["111111", "11..11", "11..11", "111111"]);
    // A gap that opens to the border of the image is beyond the silhouette where five consecutive are background.
    let open = layer(&["1.1", "1.1", "111"]);
    assert_eq!(text(&open.filled()), ["111", "111", "111"]);
}

#[test]
fn silhouettes_do_not_grow() {
    let upright = ["..555", "..555", "..555", "..555", "..555"];
    let lying = [".....", ".....", "55555", "55555", "55555"];
    let corner = [".....", ".....", "..555", "..555", "..555"];
    let diagonal = ["....5", "...55", "..555", ".5555", "55555"];
    let spike = [".....", ".....", "..5..", "..5..", "..5.."];
    let lone = [".....", ".....", "..5..", ".....", "....."];
    for rows in [upright, lying, corner, diagonal, spike, lone] {
        assert_eq!(text(&layer(&rows).filled()), rows);
    }
    // One that climbs one pixel in two is no straight line of pixels: each step gains the pixel in its inner corner,
    // and then climbs one pixel in one at both ends of each iteration until it is a diagonal.
    let flat = ["......99", "....9999", "..999999", "99999999"];
    assert_eq!(text(&layer(&flat).filled()), [".....999", "...99999", ".9999999", "99999999"]);
    // A corner that opens inward is filled.
    assert_eq!(text(&layer(&["1....", "1....", "1....", "11111"]).filled()), ["1....", "1....", "11...", "11111"]);
}

#[test]
fn planes_are_not_occluded() {
    let flat = ["5555", "5555", "5555"];
    let stairs = ["1357", "1357", "1357"];
    let diagonal = ["1234", "2345", "3456"];
    for rows in [flat, stairs, diagonal] {
        // With whatever d̃: along an axis or a diagonal half of the ring is at least as deep.
        for distance in [0.5, 1.0, 3.0] {
            assert_eq!(text(&layer(&rows).occluded_replaced(distance)), rows, "{distance}");
        }
    }
    // In between only four of the ring are as deep, so that the fifth must be nearer by less than d̃: here it is by 1.
    let skew = ["1234", "3456", "5678"];
    assert_eq!(text(&layer(&skew).occluded_replaced(1.5)), skew);
    assert_eq!(text(&layer(&skew).occluded_replaced(1.0)), ["1234", "3126", "5348"]);
}

#[test]
fn an_occluded_pixel_takes_the_nearest() {
    let hole = ["2222", "2922", "2232", "2222"];
    assert_eq!(text(&layer(&hole).occluded_replaced(1.5)), ["2222", "2222", "2232", "2222"]);
    assert_eq!(text(&layer(&hole).occluded_replaced(0.5)), ["2222", "2222", "2222", "2222"]);
    assert_eq!(text(&layer(&hole).occluded_replaced(8.0)), hole);
    // A depth of exactly d − d̃ is not beyond it.
    assert_eq!(text(&layer(&hole).occluded_replaced(7.0)), ["2222", "2222", "2232", "2222"]);
    // The border between a front and a back layer stays, on both sides of it, and so does one to the background.
    for rows in [["2299", "2299", "2299"], ["22..", "22..", "22.."], ["9999", "9922", "9922"]] {
        assert_eq!(text(&layer(&rows).occluded_replaced(1.0)), rows);
    }
    // Background is not filled here.
    assert_eq!(text(&layer(&["222", "2.2", "222"]).occluded_replaced(1.0)), ["222", "2.2", "222"]);
}

#[test]
fn smoothing_weighs_and_leaves_the_background_out() {
    let close = |found: &Layer, wanted: &[f64]| {
        found.rgba.iter().zip(wanted).for_each(|(found, wanted)| assert_close(found[0], *wanted, ROUNDING));
    };
    // A step from 1 to 8: (16 + 2·2)·1 + (2 + 2·1)·8 beside it, over 16 + 3·2 + 2·1 at the upper border.
    let step = layer(&["1188", "1188", "1188"]);
    let smooth = step.smoothed();
    let inner = (24.0 + 4.0 * 8.0) / 28.0;
    assert_close(smooth.rgba[5][0], inner, ROUNDING);
    assert_close(smooth.rgba[6][0], 9.0 - inner, ROUNDING);
    assert_close(smooth.rgba[1][0], (21.0 + 3.0 * 8.0) / 24.0, ROUNDING);
    assert_close(smooth.rgba[4][0], 1.0, ROUNDING);
    assert_eq!(smooth.depth, step.depth);
    // One bright pixel: its own share, an edge's, a corner's.
    let dot = layer(&["11111", "11111", "11811", "11111", "11111"]).smoothed();
    assert_close(dot.rgba[12][0], (16.0 * 8.0 + 12.0) / 28.0, ROUNDING);
    assert_close(dot.rgba[11][0], (26.0 + 2.0 * 8.0) / 28.0, ROUNDING);
    assert_close(dot.rgba[6][0], (27.0 + 8.0) / 28.0, ROUNDING);
    // Background neither takes part nor changes: (16·2 + 2·4 + 2·2) / 20.
    let rim = layer(&["...", "42.", ".2."]).smoothed();
    close(&rim, &[0.0, 0.0, 0.0, (16.0 * 4.0 + 2.0 * 2.0 + 2.0) / 19.0, (32.0 + 8.0 + 4.0) / 20.0, 0.0, 0.0]);
    assert!(rim.rgba.iter().zip(&rim.depth).all(|(rgba, depth)| (rgba[3] > 0.0) == depth.is_finite()));
    // A transparent neighbor counts by its alpha: color and alpha are averaged together.
    let mut two = layer(&["12"]);
    two.rgba = vec![[0.5, 0.0, 0.0, 0.5], [0.0, 0.0, 0.0, 0.0]];
    let mean = two.smoothed().rgba;
    assert_close(mean[0][0], 16.0 * 0.5 / 18.0, ROUNDING);
    assert_close(mean[0][3], 16.0 * 0.5 / 18.0, ROUNDING);
    assert_close(mean[1][3], 2.0 * 0.5 / 18.0, ROUNDING);
}

#[test]
fn edges_of_depth_are_softened() {
    // L = 2 on one side of the step, −2 on the other, 0 elsewhere away from the image's border.
    let step = layer(&["11133", "11133", "11133", "11133", "11133"]);
    for (x, wanted) in [(1, 0.0), (2, 0.25), (3, 0.25)] {
        assert_close(step.edge(10 + x, 2.0, FAR), wanted, ROUNDING);
        assert_close(step.edge(10 + x, 0.2, FAR), if wanted > 0.0 { 1.0 } else { 0.0 }, ROUNDING);
    }
    // Beyond the image is background.
    assert_close(step.edge(0, 1e3, FAR), 2.0 * 99.0 / 4e3, ROUNDING);
    let red = |layer: &Layer, x: usize| layer.rgba[10 + x][0];
    // t = 1/4: 7/8 of the own color, 1/8 of the mean.
    let soft = step.antialiased(2.0, FAR, 0.25);
    assert_close(red(&soft, 1), 1.0, ROUNDING);
    assert_close(red(&soft, 2), 0.875 + 0.125 * 1.5, ROUNDING);
    assert_close(red(&soft, 3), 0.875 * 3.0 + 0.125 * 2.5, ROUNDING);
    assert_eq!(soft.depth, step.depth);
    // Below the threshold nothing happens.
    assert_close(red(&step.antialiased(2.0, FAR, 0.26), 2), 1.0, ROUNDING);
    // A threshold of 0 takes everything that differs at all; 1 only whole edges.
    assert_close(red(&step.antialiased(200.0, FAR, 0.0), 2), 1.0 + 0.5 * 0.0025 * 0.5, ROUNDING);
    assert_close(red(&step.antialiased(0.5, FAR, 1.0), 2), 0.5 + 0.5 * 1.5, ROUNDING);
}

#[test]
fn the_background_beside_an_edge_takes_part_in_it() {
    let rim = layer(&["..4..", "..4..", "..4.."]);
    let soft = rim.antialiased(1.0, FAR, 0.25);
    let at = |x: usize| soft.rgba[5 + x];
    assert_eq!(at(0), [0.0; 4]);
    // One of four neighbors is there: half of a quarter of it.
    assert_eq!(at(1), [0.5, 0.0, 0.0, 0.125]);
    // Half of its own, and half of the mean of itself twice and background twice.
    assert_eq!(at(2), [3.0, 0.0, 0.0, 0.75]);
    assert_eq!(soft.depth, rim.depth);
}

fn points(at: &[(f64, f64, f64)], normals: Option<Vec<Vec3>>) -> Points {
    Points {
        // Pixel centers are whole numbers away from the axis.
        positions: at.iter().map(|(x, y, z)| DVec3::new(*x, *y, -z)).collect(),
        colors: vec![Vec3::ONE; at.len()],
        opacities: vec![0.5; at.len()],
        radii: vec![3.0; at.len()],
        normals,
        ..Points::default()
    }
}

fn plain() -> ImageSpace {
    ImageSpace {
        fill: Iterations::Count(0),
        occlusion: Iterations::Count(0),
        smooth: 0,
        antialias: false,
        ..ImageSpace::default()
    }
}

#[test]
fn the_nearest_point_that_looks_at_the_viewer_is_drawn() {
    let at = [(0.0, 0.0, 3.0), (0.2, -0.2, 2.0), (0.0, 0.0, 4.0), (2.0, 0.0, 4.0), (2.2, 0.0, 4.0), (-2.0, 0.0, 200.0)];
    let colors = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0].map(DVec3::splat);
    let red = |normals, filters: &ImageSpace| {
        let picture = render(View::new(&orthographic(), SIZE), &points(&at, normals), &colors, filters);
        assert!(picture.rgba.iter().all(|rgba| rgba[3] == f64::from(u8::from(rgba[0] > 0.0))));
        [4 * 9 + 4, 4 * 9 + 6, 4 * 9 + 2].map(|pixel| (picture.rgba[pixel][0], picture.depth[pixel]))
    };
    // The sixth lies beyond the far plane; of the two at one depth the first is taken.
    assert_eq!(red(None, &plain()), [(2.0, 2.0), (4.0, 4.0), (0.0, f64::INFINITY)]);
    // The second looks away and the fourth is seen edge-on; the first has no normal.
    let normals = vec![Vec3::ZERO, Vec3::NEG_Z, Vec3::Z, Vec3::X, Vec3::Z, Vec3::Z];
    assert_eq!(red(Some(normals.clone()), &plain())[..2], [(1.0, 3.0), (5.0, 4.0)]);
    assert_eq!(red(Some(normals), &ImageSpace { cull: false, ..plain() })[..2], [(2.0, 2.0), (4.0, 4.0)]);
    // In perspective the line to the eye decides, not the axis: 45° to the left this one is seen from behind.
    let aside = |camera: &Camera| {
        let normals = Some(vec![Vec3::new(-0.8, 0.0, 0.6)]);
        let picture = render(View::new(camera, SIZE), &points(&[(-3.9, 0.0, 4.0)], normals), &colors[..1], &plain());
        picture.counts.iter().sum::<u32>()
    };
    assert_eq!([aside(&orthographic()), aside(&perspective())], [1, 0]);
}

#[test]
fn the_distance_of_layers_is_a_hundredth_of_the_diagonal() {
    let box_of_points = points(&[(0.0, 0.0, 1.0), (2.0, -3.0, 7.0)], None);
    assert_close(layer_distance(None, &box_of_points), 0.07, ROUNDING);
    assert_close(layer_distance(Some(0.5), &box_of_points), 0.5, ROUNDING);
}

#[test]
fn filters_run_in_their_order_and_as_often_as_asked() {
    // A ring of eight with a deeper point in its hole, beside a hole that shows background.
    let at: Vec<(f64, f64, f64)> = (-3..=3)
        .flat_map(|x| (-2..=2).map(move |y| (f64::from(x), f64::from(y), if (x, y) == (1, 0) { 9.0 } else { 5.0 })))
        .filter(|at| (at.0, at.1) != (-1.0, 0.0))
        .collect();
    let colors: Vec<DVec3> = at.iter().map(|at| DVec3::splat(at.2)).collect();
    let filters = ImageSpace { min_layer_distance: Some(1.0), ..plain() };
    let shown = |filters: ImageSpace| {
        let picture = render(View::new(&orthographic(), SIZE), &points(&at, None), &colors, &filters);
        [4 * 9 + 3, 4 * 9 + 5, 4 * 9 + 4].map(|pixel| picture.rgba[pixel][0])
    };
    assert_eq!(shown(filters), [0.0, 9.0, 5.0]);
    assert_eq!(shown(ImageSpace { fill: Iterations::Count(1), ..filters }), [5.0, 9.0, 5.0]);
    assert_eq!(shown(ImageSpace { occlusion: Iterations::Count(1), ..filters }), [0.0, 5.0, 5.0]);
    assert_eq!(
        shown(ImageSpace { fill: Iterations::Count(1), occlusion: Iterations::Count(1), smooth: 2, ..filters }),
        [5.0, 5.0, 5.0]
    );
    // Smoothed with the deeper one still there, once and twice.
    let once = shown(ImageSpace { fill: Iterations::Count(1), smooth: 1, ..filters })[1];
    assert_close(once, (16.0 * 9.0 + 12.0 * 5.0) / 28.0, ROUNDING);
    assert!(shown(ImageSpace { fill: Iterations::Count(1), smooth: 2, ..filters })[1] < once);
}

/// A full layer of this side at depth 5, in which `is_hole` shows something else.
fn sheet(side: u32, is_hole: impl Fn(u32, u32) -> bool, in_hole: f64) -> Layer {
    let places = (0..side * side).map(|pixel| is_hole(pixel % side, pixel / side));
    let depth: Vec<f64> = places.map(|hole| if hole { in_hole } else { 5.0 }).collect();
    let color = |z: &f64| if z.is_finite() { [*z, 0.0, 0.0, 1.0] } else { [0.0; 4] };
    Layer { size: [side; 2], rgba: depth.iter().map(color).collect(), depth }
}

#[test]
fn holes_close_until_nothing_changes_any_more() {
    let square = |from: u32, side: u32| move |x: u32, y: u32| [x, y].iter().all(|c| (from..from + side).contains(c));
    // A square hole of 7 pixels takes 8 iterations, of background and of what lies behind.
    for in_hole in [f64::INFINITY, 9.0] {
        let layer = sheet(15, square(4, 7), in_hole);
        let filtered = |iterations| {
            let filters = match in_hole {
                9.0 => ImageSpace { occlusion: iterations, ..plain() },
                _ => ImageSpace { fill: iterations, ..plain() },
            };
            layer.clone().filtered(&filters, 1.0, 200.0)
        };
        assert!(filtered(Iterations::Auto).depth.iter().all(|z| *z == 5.0), "{in_hole}");
        assert!(filtered(Iterations::Count(7)) != filtered(Iterations::Auto), "{in_hole}");
        assert!(filtered(Iterations::Count(8)) == filtered(Iterations::Auto), "{in_hole}");
    }
    // Background beside a straight border never closes.
    let half = sheet(15, |x, _| x > 7, f64::INFINITY);
    assert!(half.clone().filtered(&ImageSpace { fill: Iterations::Auto, ..plain() }, 1.0, 200.0) == half);
}

#[test]
fn iterations_end_after_64() {
    // One of 50 pixels takes 72.
    let layer = sheet(58, |x, y| [x, y].iter().all(|c| (4..54).contains(c)), f64::INFINITY);
    let filtered = |fill| layer.clone().filtered(&ImageSpace { fill, ..plain() }, 1.0, 200.0);
    assert!(filtered(Iterations::Auto) == filtered(Iterations::Count(64)));
    assert!(filtered(Iterations::Auto) != filtered(Iterations::Count(65)));
    assert!(filtered(Iterations::Count(72)).depth.iter().all(|z| *z == 5.0));
    assert!(filtered(Iterations::Count(71)).depth.iter().any(|z| z.is_infinite()));
}
