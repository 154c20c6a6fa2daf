//! Colors by what a cloud has, against a float64 reference written from the equations of the scene file's
//! documentation.

use glam::{DVec3, Vec3};
use pellucid_core::cloud::gaussians::Gaussians;
use pellucid_core::cloud::{Cloud, UpAxis};
use pellucid_core::color::classes;
use pellucid_core::color::colormap::Colormap;
use pellucid_core::progress::Progress;
use pellucid_scene::{self as scene, Error, Scene, assemble};

/// The coordinates of the reference's points stand for their places in the cloud, so that the order can be undone.
fn cloud(count: usize) -> Cloud {
    Cloud { positions: (0..count).map(|i| DVec3::new(i as f64, 0.0, 0.0)).collect(), up: UpAxis::Z, ..Cloud::default() }
}

fn scene_of(keys: &str) -> Scene {
    let text = format!("[[cloud]]\npath = 'a.las'\nradius = 1.0\n{keys}");
    Scene::from_toml(&text, "s.toml".as_ref()).unwrap_or_else(|error| panic!("{keys}: {error}"))
}

/// The colors of a cloud, in its order.
fn colors(keys: &str, cloud: Cloud) -> Vec<Vec3> {
    let points = assemble(&scene_of(keys), vec![cloud], false, &Progress::hidden()).unwrap();
    let mut colors = vec![Vec3::ZERO; points.len()];
    for (place, color) in points.file_order.iter().zip(&points.colors) {
        colors[*place as usize] = *color;
    }
    colors
}

fn failure(keys: &str, cloud: Cloud) -> Error {
    assemble(&scene_of(keys), vec![cloud], false, &Progress::hidden()).unwrap_err()
}

fn decode(c: f64) -> f64 {
    if c <= 0.04045 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) }
}

/// The p-th share of sorted finite values: linear between order statistics.
fn percentile(values: &[f64], p: f64) -> f64 {
    let mut sorted: Vec<f64> = values.iter().copied().filter(|v| v.is_finite()).collect();
    sorted.sort_by(f64::total_cmp);
    let place = p * (sorted.len() - 1) as f64;
    let (below, above) = (place.floor() as usize, place.ceil() as usize);
    sorted[below] + (place - place.floor()) * (sorted[above] - sorted[below])
}

fn t(value: f64, low: f64, high: f64) -> f64 {
    if high == low { 0.0 } else { ((value - low) / (high - low)).clamp(0.0, 1.0) }
}

/// Linear RGB at t of a map whose entries are read off at their own places.
fn mapped(name: &str, entries: usize, t: f64) -> DVec3 {
    let map = Colormap::named(name).unwrap();
    let entry = |i: usize| map.srgb(i as f64 / (entries - 1) as f64);
    let place = t * (entries - 1) as f64;
    let (below, above) = (place.floor() as usize, place.ceil() as usize);
    let srgb = entry(below) + (place - place.floor()) * (entry(above) - entry(below));
    DVec3::from(srgb.to_array().map(decode))
}

/// Colors are rounded to float32; the decoding's slope is at most 2.3, and t is exact to some 1e-13.
#[track_caller]
fn assert_close(found: &[Vec3], wanted: &[DVec3]) {
    assert_eq!(found.len(), wanted.len());
    for (i, (found, wanted)) in found.iter().zip(wanted).enumerate() {
        let off = (found.as_dvec3() - *wanted).abs().max_element();
        assert!(off < 1e-7, "point {i}: {found} instead of {wanted}");
    }
}

const GREY: f64 = 0.214_041_140_482_232_55;

#[test]
fn intensity_goes_from_percentile_1_to_99() {
    let values: Vec<f32> = (0..300).map(|i| ((i * 7919) % 1000) as f32 * 65.0).collect();
    let doubles: Vec<f64> = values.iter().map(|v| f64::from(*v)).collect();
    let (low, high) = (percentile(&doubles, 0.01), percentile(&doubles, 0.99));
    let with = Cloud { intensity: Some(values), ..cloud(300) };
    let wanted: Vec<_> = doubles.iter().map(|v| mapped("viridis", 256, t(*v, low, high))).collect();
    assert_close(&colors("color_by = 'intensity'", with.clone()), &wanted);
    let wanted: Vec<_> = doubles.iter().map(|v| mapped("turbo", 256, 1.0 - t(*v, 1000.0, 40_000.0))).collect();
    let keys = "color_by = 'intensity'\ncolormap = 'turbo'\nreverse = true\nrange = [1000, 40000]";
    assert_close(&colors(keys, with), &wanted);
}

#[test]
fn heights_are_those_of_the_scene_along_the_vertical() {
    let mut a = cloud(60);
    for (i, p) in a.positions.iter_mut().enumerate() {
        p.y = ((i * 37) % 60) as f64;
        p.z = ((i * 17) % 60) as f64 * 1e-3;
    }
    let height =
        |axis: usize, sign: f64| -> Vec<f64> { a.positions.iter().map(|p| sign * (3.0 * p[axis] + 5.0)).collect() };
    let of = |heights: Vec<f64>| -> Vec<DVec3> {
        let (low, high) = (percentile(&heights, 0.01), percentile(&heights, 0.99));
        heights.iter().map(|v| mapped("viridis", 256, t(*v, low, high))).collect()
    };
    let placed = "color_by = 'height'\nscale = 3.0\ntranslate = [5, 5, 5]\n";
    assert_close(&colors(placed, a.clone()), &of(height(2, 1.0)));
    let model = Cloud { up: UpAxis::Y, ..a.clone() };
    assert_close(&colors(placed, model.clone()), &of(height(1, 1.0)));
    assert_close(&colors(&format!("{placed}[camera]\nup = [0.1, -1, 0.2]"), model.clone()), &of(height(1, -1.0)));
    assert_close(&colors(&format!("{placed}[camera]\nup = [1, 0, 0.5]"), model), &of(height(0, 1.0)));
    // A range is that of the scene's coordinates.
    let wanted: Vec<_> = height(2, 1.0).iter().map(|v| mapped("grey", 2, t(*v, 5.0, 5.1))).collect();
    assert_close(&colors(&format!("{placed}colormap = 'grey'\nrange = [5.0, 5.1]"), a.clone()), &wanted);
}

#[test]
fn logarithms_and_numbers_that_have_none() {
    let values = vec![0.0, -1.0, f32::NAN, 1.0, 10.0, 100.0, f32::INFINITY];
    let a = Cloud { scalars: vec![("dose".into(), values)], ..cloud(7) };
    let grey = |x: f64| DVec3::splat(decode(x));
    let mid = DVec3::splat(GREY);
    let keys = "color_by = 'dose'\ncolormap = 'grey'\nlog = true\n";
    let wanted = [mid, mid, mid, grey(0.0), grey(0.5), grey(1.0), mid];
    assert_close(&colors(&format!("{keys}range = [1, 100]"), a.clone()), &wanted);
    // Without a range the ends are percentiles of 1, 10, 100: places 0.02 and 1.98.
    let (low, high) = (1.0 + 0.02 * 9.0, 10.0 + 0.98 * 90.0);
    let middle = (10f64.ln() - f64::ln(low)) / (f64::ln(high) - f64::ln(low));
    let wanted = [mid, mid, mid, grey(0.0), grey(middle), grey(1.0), mid];
    assert_close(&colors(keys, a.clone()), &wanted);
    // Linear: only NaN and infinity have no place; -1 to 100, and reverse acts last.
    let place = |v: f64| grey(1.0 - t(v, -1.0, 100.0));
    let wanted = [place(0.0), place(-1.0), mid, place(1.0), place(10.0), place(100.0), mid];
    let keys = "color_by = 'dose'\ncolormap = 'grey'\nreverse = true\nrange = [-1, 100]";
    assert_close(&colors(keys, a), &wanted);
}

#[test]
fn hard_cases_of_values() {
    let first = mapped("viridis", 256, 0.0);
    let constant = Cloud { intensity: Some(vec![7.0; 5]), ..cloud(5) };
    assert_close(&colors("color_by = 'intensity'", constant), &[first; 5]);
    // All equally high.
    assert_close(&colors("", cloud(4)), &[first; 4]);
    let nan = Cloud { scalars: vec![("a b".into(), vec![f32::NAN; 3])], ..cloud(3) };
    for name in ["a b", "a_b"] {
        assert_close(&colors(&format!("color_by = '{name}'"), nan.clone()), &[DVec3::splat(GREY); 3]);
    }
    let one_class = Cloud { classification: Some(vec![6; 3]), ..cloud(3) };
    let wanted = DVec3::from(classes::srgb(6).to_array().map(decode));
    assert_close(&colors("color_by = 'classification'", one_class), &[wanted; 3]);
}

#[test]
fn auto_takes_the_best_that_there_is() {
    let colored =
        |colors: Vec<Vec3>| Cloud { colors: Some(colors), classification: Some(vec![2, 5, 6, 1]), ..cloud(4) };
    let own = vec![Vec3::ZERO, Vec3::ONE, Vec3::ONE, Vec3::ONE];
    assert_eq!(colors("", colored(own.clone())), own);
    let by_class: Vec<_> = [2, 5, 6, 1].iter().map(|c| DVec3::from(classes::srgb(*c).to_array().map(decode))).collect();
    for blank in [Vec3::ZERO, Vec3::ONE] {
        assert_close(&colors("", colored(vec![blank; 4])), &by_class);
        assert_eq!(colors("color_by = 'rgb'", colored(vec![blank; 4])), [blank; 4]);
    }
    assert_eq!(colors("color = [0.5, 0, 1]", colored(own.clone())), [Vec3::new(0.5, 0.0, 1.0); 4]);
    assert_eq!(colors("color_by = 'uniform'", colored(own)), [Vec3::ONE; 4]);
    // Two classes other than 0 and 1 are not enough; intensities of 0 only are none.
    let mut high = cloud(4);
    (0..4).for_each(|i| high.positions[i].z = i as f64);
    let few = Cloud { classification: Some(vec![0, 1, 2, 5]), intensity: Some(vec![0.0; 4]), ..high };
    let heights = [0.0, 1.0, 2.0, 3.0];
    let (low, high) = (percentile(&heights, 0.01), percentile(&heights, 0.99));
    let wanted: Vec<_> = heights.iter().map(|v| mapped("viridis", 256, t(*v, low, high))).collect();
    assert_close(&colors("", few.clone()), &wanted);
    let lit = [400.0, 100.0, 300.0, 200.0];
    let (low, high) = (percentile(&lit, 0.01), percentile(&lit, 0.99));
    let wanted: Vec<_> = wanted.iter().zip(lit).map(|(c, v)| *c * (0.35 + 0.65 * t(v, low, high))).collect();
    let with = Cloud { intensity: Some(lit.map(|v| v as f32).to_vec()), ..few };
    assert_close(&colors("", with.clone()), &wanted);
    let said = scene::colorings(&scene_of(""), std::slice::from_ref(&with));
    assert!(
        said[0].starts_with("height in viridis, darker where intensity is small: the file has no colors"),
        "{said:?}"
    );
}

#[test]
fn normals_sources_and_clouds() {
    let diagonal = Vec3::splat(3f32.sqrt().recip());
    let a = Cloud { normals: Some(vec![Vec3::X, Vec3::NEG_Y, diagonal, Vec3::ZERO]), ..cloud(4) };
    let color = |n: DVec3| DVec3::from((0.5 + 0.5 * n).to_array().map(decode));
    let wanted = [DVec3::X, -DVec3::Y, DVec3::splat(f64::from(diagonal.x)), DVec3::ZERO].map(color);
    assert_close(&colors("color_by = 'normal'", a), &wanted);
    for (word, name) in [("source", "PointSourceId"), ("gps-time", "scalar_GpsTime"), ("return", "return_number")] {
        let a = Cloud { scalars: vec![(name.into(), vec![1.0, 2.0, 3.0])], ..cloud(3) };
        let wanted = [0.0, 0.5, 1.0].map(|t| mapped("viridis", 256, t));
        assert_close(&colors(&format!("color_by = '{word}'\nrange = [1, 3]"), a), &wanted);
    }
    let two =
        "[[cloud]]\npath = 'a'\nradius = 1\ncolor_by = 'cloud'\n[[cloud]]\npath = 'b'\nradius = 1\ncolor_by = 'cloud'";
    let two = Scene::from_toml(two, "s.toml".as_ref()).unwrap();
    let points = assemble(&two, vec![cloud(1), cloud(1)], false, &Progress::hidden()).unwrap();
    assert_ne!(points.colors[0], points.colors[1]);
}

#[test]
fn the_field_is_a_value_like_others() {
    let a = Cloud { scalars: vec![("f".into(), vec![2.0, 4.0, 6.0])], ..cloud(3) };
    // Scaled from the smallest to the largest: 0, 0.5, 1.
    let wanted = [0.0, 0.5, 1.0].map(|t| DVec3::splat(decode(t)));
    let keys = "color_by = 'field'\nfield = 'f'\ncolormap = 'grey'\nrange = [0, 1]";
    assert_close(&colors(keys, a.clone()), &wanted);
    let points = assemble(&scene_of(keys), vec![a], false, &Progress::hidden()).unwrap();
    assert!(points.fields.is_empty(), "the method has no use for it");
}

#[test]
fn errors_for_missing_columns_list_the_columns_there_are() {
    let a = || Cloud { intensity: Some(vec![1.0; 2]), scalars: vec![("dose".into(), vec![1.0; 2])], ..cloud(2) };
    for (by, wanted) in [
        ("rgb", "a.las: color_by = \"rgb\", but the file has no colors; it has intensity, dose, x, y, z"),
        (
            "classification",
            "a.las: color_by = \"classification\", but the file has no classes; it has intensity, dose, x, y, z",
        ),
        (
            "source",
            "a.las: color_by = \"source\", but the file has no point_source_id; it has intensity, dose, x, y, z",
        ),
        ("dosse", "a.las: no scalar `dosse` for color_by; did you mean `dose`?"),
        ("hight", "a.las: no scalar `hight` for color_by; did you mean `height`?"),
    ] {
        let error = failure(&format!("color_by = '{by}'"), a());
        assert_eq!((error.to_string().as_str(), error.exit_status()), (wanted, 1));
    }
    for (keys, wanted) in [
        ("range = [2, 1]", "s.toml:4:9: `cloud.0.range` must go from low to high, found [2.0, 1.0]"),
        ("range = [0, 1]\nlog = true", "s.toml:4:9: `cloud.0.range` must begin above 0 with log = true, found 0.0"),
        ("range = [1]", "s.toml:4:9: `cloud.0.range` must be an array of 2 numbers, found an array of 1"),
    ] {
        let text = format!("[[cloud]]\npath = 'a.las'\nradius = 1.0\n{keys}");
        assert_eq!(Scene::from_toml(&text, "s.toml".as_ref()).unwrap_err().to_string(), wanted);
    }
    let warnings = scene_of("color_by = 'rgb'\nlog = true").warnings;
    assert_eq!(warnings, ["s.toml:5:7: `log` has no effect with color_by = \"rgb\""]);
}

#[test]
fn white_and_black_splats_keep_their_colors() {
    // White ones, black ones, and those whose base is brighter than white. Heights would give two of them two colors.
    for base in [Vec3::ONE, Vec3::ZERO, Vec3::splat(2.0)] {
        let splats = Gaussians { extents: vec![Vec3::ONE; 2], bases: vec![base; 2], ..Gaussians::none(2) };
        let splats = Gaussians { harmonics: vec![Vec3::splat(0.25); 6], degree: 1, ..splats };
        let own: Vec<Vec3> = (0..2).map(|at| splats.linear_base(at)).collect();
        let white = Cloud { colors: Some(own.clone()), gaussians: Some(splats.clone()), ..cloud(2) };
        assert_eq!(colors("", white.clone()), own);
        let points =
            assemble(&scene_of("primitive = 'points'"), vec![white.clone()], false, &Progress::hidden()).unwrap();
        assert_eq!(points.colors, own, "as points too");
        let points = assemble(&scene_of(""), vec![white.clone()], false, &Progress::hidden()).unwrap();
        assert_eq!(points.gaussians.unwrap().harmonics, splats.harmonics);
        // Points without splats are colored by height, as before.
        let other = Cloud { gaussians: None, ..white };
        if base != Vec3::splat(2.0) {
            assert_ne!(colors("", other), own);
        }
    }
}

#[test]
fn a_range_of_drawn_points_has_their_percentiles() {
    // Classes 2 from 0 to 100, and a tower of class 6 up to 1000.
    let value = |i: usize| if i < 101 { i as f32 } else { 1000.0 };
    let values: Vec<f32> = (0..151).map(value).collect();
    let codes = (0..151).map(|i| if i < 101 { 2 } else { 6 }).collect();
    let a = Cloud { scalars: vec![("dose".into(), values.clone())], classification: Some(codes), ..cloud(151) };
    let all: Vec<f64> = values.iter().map(|v| f64::from(*v)).collect();
    let by = "color_by = 'dose'\ncolormap = 'grey'\n";
    let wanted = |of: &[f64], shown: &[f64]| -> Vec<DVec3> {
        let (low, high) = (percentile(of, 0.01), percentile(of, 0.99));
        shown.iter().map(|v| DVec3::splat(decode(t(*v, low, high)))).collect()
    };
    let shown = |keys: &str, count: usize| colors(&format!("{by}{keys}"), a.clone())[..count].to_vec();
    let hidden = "[[cloud.class]]\nid = 6\nvisible = false\n";
    assert_close(&shown(&format!("range = 'drawn'\n{hidden}"), 101), &wanted(&all[..101], &all[..101]));
    assert_close(&shown(hidden, 101), &wanted(&all, &all[..101]));
    // Nothing is hidden, or everything else.
    assert_close(&shown("range = 'drawn'", 151), &wanted(&all, &all));
    // Positions run along x.
    let clip = "[[clip]]\nslab = { axis = 'x', max = 50.0 }\n";
    assert_close(&shown(&format!("range = 'drawn'\n{clip}"), 51), &wanted(&all[..51], &all[..51]));
    let outer = format!("range = 'drawn'\ntranslate = [10, 0, 0]\n{clip}");
    assert_close(&shown(&outer, 41), &wanted(&all[..41], &all[..41]));
    let error = Scene::from_toml("[[cloud]]\npath = 'a'\nrange = 'seen'", "s.toml".as_ref()).unwrap_err();
    assert!(error.to_string().contains("`cloud.0.range` must be"), "{error}");
}
