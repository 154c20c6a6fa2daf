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

#[test]
fn a_legend_takes_no_more_than_a_third_or_says_why_not() {
    let values = legend("color_by = 'x'\nrange = [0, 1]");
    // The least picture has no room for a scale bar as well.
    let cases = [(DEEP, [160, 160]), (FLAT, [200, 200]), (FLAT, [640, 480]), (FLAT, [300, 3000]), (FLAT, [4000, 200])];
    for (projection, size) in cases {
        let layout = LegendLayout::new(&values, &camera(projection), size)
            .unwrap_or_else(|why| panic!("{size:?}: {why}"))
            .unwrap();
        assert!(layout.panel[0] <= size[0] as f32 / 3.0 + 1.0, "{size:?}: {:?}", layout.panel);
        assert!(layout.panel[1] <= size[1] as f32, "{size:?}: {:?}", layout.panel);
        assert!(layout.em >= 11.0);
    }
    let misfit = |legend: &Legend, size| LegendLayout::new(legend, &camera(DEEP), size).err().unwrap_or_default();
    let wanted = "--legend: a legend does not fit into 400 × 100 pixels: each side must have at least 160";
    assert_eq!(misfit(&values, [400, 100]), wanted);
    let long = legend("color_by = 'x'\nrange = [636000.001, 636000.002]");
    assert!(misfit(&long, [160, 160]).ends_with("its numbers would take more than a third of the width"));
    assert!(LegendLayout::new(&legend("color_by = 'uniform'"), &camera(DEEP), [640, 480]).unwrap().is_none());
    assert!(LegendLayout::new(&legend("color_by = 'uniform'"), &camera(FLAT), [640, 480]).unwrap().is_some());
}

#[test]
fn a_bar_has_the_colors_of_its_values_and_what_is_outside_stays() {
    let legend = legend("color_by = 'x'\ncolormap = 'grey'\nrange = [0, 1]");
    let mut raster = Raster { size: [640, 480], alpha: false, bytes: vec![200; 640 * 480 * 3] };
    let layout = LegendLayout::new(&legend, &camera(DEEP), raster.size).unwrap().unwrap();
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
    let layout = LegendLayout::new(&legend, &camera(DEEP), [640, 480]).unwrap().unwrap();
    let more = layout.rows.iter().any(|(row, _)| matches!(row, LegendRow::Text(text) if text.starts_with("and ")));
    assert!(more && layout.panel[1] < 480.0);
}
