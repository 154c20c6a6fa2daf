use super::*;
use pellucid_core::camera::Projection;
use pellucid_core::cloud::Cloud;
use pellucid_core::progress::Progress;
use pellucid_scene::{Scene, arrange_with_legend};

fn camera(projection: Projection) -> Camera {
    Camera::look_at(DVec3::Z, DVec3::ZERO, DVec3::Y, projection, 0.1, 10.0).unwrap()
}

fn legend(keys: &str) -> Legend {
    let text = format!("[[cloud]]\npath = 'a.las'\nradius = 1.0\n{keys}");
    let scene = Scene::from_toml(&text, "s.toml".as_ref()).unwrap();
    let cloud = Cloud {
        positions: (0..=100).map(|i| DVec3::new(f64::from(i), 0.0, 0.0)).collect(),
        classification: Some((0..=100).map(|i| if i < 50 { 2 } else { 6 }).collect()),
        ..Cloud::default()
    };
    arrange_with_legend(&scene, vec![cloud], 0, &Progress::hidden()).unwrap().1
}

const FLAT: Projection = Projection::Orthographic { height: 100.0 };
const DEEP: Projection = Projection::Perspective { fov_y: 1.0 };

/// The layout over a picture, which fits.
fn fit<'a>(legend: &'a Legend, projection: Projection, size: [u32; 2]) -> LegendLayout<'a> {
    match LegendLayout::fit(legend, &camera(projection), size, LegendPlace::Over) {
        Fit::Fits(layout) => *layout,
        Fit::Nothing | Fit::Misfit => panic!("{size:?}"),
    }
}

#[test]
fn a_legend_takes_no_more_than_a_third_of_the_width() {
    let values = legend("color_by = 'x'\nrange = [0, 1]");
    let cases = [(DEEP, [160, 160]), (FLAT, [200, 200]), (FLAT, [640, 480]), (FLAT, [300, 3000]), (FLAT, [4000, 200])];
    for (projection, size) in cases {
        let layout = fit(&values, projection, size);
        assert!(layout.panel[0] <= size[0] as f32 / 3.0 + 1.0, "{size:?}: {:?}", layout.panel);
        assert!(layout.panel[1] <= size[1] as f32, "{size:?}: {:?}", layout.panel);
        assert!(layout.em >= 11.0);
    }
    let none = |legend: &Legend, projection| {
        matches!(LegendLayout::fit(legend, &camera(projection), [640, 480], LegendPlace::Over), Fit::Nothing)
    };
    let uniform = legend("color_by = 'uniform'");
    assert!(none(&uniform, DEEP) && !none(&uniform, FLAT));
}

#[test]
fn where_there_is_little_room_letters_are_smaller_or_the_legend_is_left_out() {
    let values = legend("color_by = 'x'\nrange = [0, 1]");
    let long = legend("color_by = 'x'\nrange = [636000.001, 636000.002]");
    let classes = legend("color_by = 'classification'");
    for (legend, projection, size) in [
        (&values, DEEP, [400, 100]),
        (&values, DEEP, [120, 90]),
        (&long, DEEP, [160, 160]),
        (&classes, DEEP, [64, 48]),
        (&classes, FLAT, [100, 75]),
    ] {
        let layout = fit(legend, projection, size);
        assert!((7.0..11.0).contains(&layout.em), "{size:?}: {}", layout.em);
        assert!(layout.panel[0] <= 0.5 * size[0] as f32 + 1.0, "{size:?}: {:?}", layout.panel);
        assert!(layout.panel[1] <= size[1] as f32, "{size:?}: {:?}", layout.panel);
    }
    for place in [LegendPlace::Over, LegendPlace::Beside] {
        for size in [[64, 20], [200, 30], [1, 1], [1, 5000]] {
            let fit = LegendLayout::fit(&values, &camera(FLAT), size, place);
            assert!(
                matches!(fit, Fit::Misfit) || size[1] == 5000 && place == LegendPlace::Beside,
                "{size:?} {place:?}"
            );
        }
    }
}

#[test]
fn a_column_beside_a_picture_hides_nothing_and_is_as_wide_in_all_frames() {
    let values = legend("color_by = 'x'\ncolormap = 'grey'\nrange = [636000.001, 636000.002]");
    for size in [[640, 480], [64, 148], [1001, 333]] {
        let columns = [layout::column(size, false), layout::column(size, true)];
        assert!(columns.iter().all(|column| column.is_multiple_of(2)));
        for height in [1e-3, 1.0, 99.0, 1e5] {
            let camera = camera(Projection::Orthographic { height });
            let Fit::Fits(layout) = LegendLayout::fit(&values, &camera, size, LegendPlace::Beside) else {
                panic!("{size:?} {height}")
            };
            assert!(layout.panel[0] <= columns[1] as f32 + 1.0, "{size:?} {:?}", layout.panel);
            let raster = Raster { size, alpha: false, bytes: vec![200; (size[0] * size[1] * 3) as usize] };
            let mut wider = widened(&raster, columns[1], Vec3::ONE);
            assert_eq!(wider.size, [size[0] + columns[1], size[1]]);
            draw_beside(&layout, LIGHT_PANEL, columns[1], &mut wider);
            let (own, row) = (3 * size[0] as usize, 3 * wider.size[0] as usize);
            assert!(wider.bytes.chunks_exact(row).all(|row| row[..own].iter().all(|value| *value == 200)));
            // Its first pixels are the panel over white: 0.8 · 250 + 0.2 · 255.
            assert!(wider.bytes.chunks_exact(row).all(|row| row[own..own + 3] == [251; 3]));
            let text = wider.bytes.chunks_exact(row).flat_map(|row| &row[own..]).filter(|value| **value < 60).count();
            assert!(text > 100, "{size:?} {text}");
        }
    }
}

#[test]
fn a_bar_has_the_colors_of_its_values_and_what_is_outside_stays() {
    let legend = legend("color_by = 'x'\ncolormap = 'grey'\nrange = [0, 1]");
    let mut raster = Raster { size: [640, 480], alpha: false, bytes: vec![200; 640 * 480 * 3] };
    let layout = fit(&legend, DEEP, raster.size);
    draw(&layout, DARK_PANEL, &mut raster);
    let at = |x: f32, y: f32| raster.bytes[(y as usize * 640 + x as usize) * 3];
    let padding = LegendLayout::padding(layout.em);
    let left = 2.0 * padding + 3.0;
    let rows: Vec<u8> = (0..480).map(|y| at(left, y as f32)).collect();
    // From white at the top to black: 10 lines of 15 pixels, that is 150 steps.
    // Of the line of 15 pixels that is left 8 are above and 7 below.
    let bottom = 480.0 - 2.0 * padding - 7.0;
    assert!(at(left, bottom - 1.0) < 3 && at(left, bottom - 150.0) > 252, "{rows:?}");
    assert!((at(left, bottom - 75.0).abs_diff(127)) <= 2);
    for (x, y) in [(2.0, 470.0), (300.0, 470.0), (20.0, 100.0)] {
        assert_eq!(at(x, y), 200, "{x}, {y}");
    }
}

#[test]
fn long_lists_are_cut_and_counted() {
    let scalar = |i: u32| format!("[[cloud.class]]\nscalar = 'x'\nrange = [{i}, {i}]\ncolor = 'red'\n");
    let legend = legend(&(0..60).map(scalar).collect::<String>());
    assert!(legend.entries[0].swatches.len() >= 60);
    let layout = fit(&legend, DEEP, [640, 480]);
    let more = layout.rows.iter().any(|(row, _)| matches!(row, LegendRow::Text(text) if text.starts_with("and ")));
    assert!(more && layout.panel[1] < 480.0);
}
