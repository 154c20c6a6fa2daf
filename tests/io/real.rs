//! Real files, if they are there: `PELLUCID_TEST_DATA`, by default `../shared/data`.

use std::path::{Path, PathBuf};

use pellucid::cloud::UpAxis;
use pellucid::color::decode_srgb;
use pellucid::io::Error;

use crate::load;

fn data() -> Option<PathBuf> {
    let folder = std::env::var_os("PELLUCID_TEST_DATA")
        .map_or_else(|| Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/data"), PathBuf::from);
    if !folder.is_dir() {
        eprintln!("skipped: no test data in {}", folder.display());
        return None;
    }
    Some(folder)
}

/// Points of each file, measured by other readers (laspy, plyfile).
const POINTS: &[(&str, usize)] = &[
    ("models/stanford_dragon_437k.ply", 437_645),
    ("models/turbine_blade_100k.ply", 99_519),
    ("models/stanford_armadillo_43k.ply", 43_243),
    ("models/bun_zipper.ply", 35_947),
    ("lidar/autzen_stadium_2010_crop.laz", 2_834_708),
    ("lidar/autzen_trim.laz", 110_000),
    ("lidar/ahn3_delft_classified.laz", 640_510),
    ("lidar/ign_lidarhd_77050_627755_classified.laz", 84_524),
    ("lidar/lone_star_geyser_tls.copc.laz", 518_862),
    ("lidar/sample_c_rgb_classified.las", 14_408),
    ("photogrammetry/centro_fuerte_village.laz", 2_096_574),
    ("photogrammetry/lion_takanawa.copc.laz", 341_989),
    ("indoor/livingroom_fragment_double.ply", 112_698),
    ("formats/horse_big_endian_rgb.ply", 48_485),
    ("formats/1.2-with-color.las", 1_065),
    ("formats/las14_test1_4.las", 1_000),
    ("formats/las_extrabytes.las", 1_065),
    ("formats/laz_pointwise_nochunk.laz", 11_781),
    ("formats/simple_binary_le.ply", 3),
    ("formats/5points_double_ascii.ply", 5),
    ("nasty/bad_vlr_count.las", 10),
    ("nasty/spurious.las", 1_065),
    ("nasty/bad-geotiff-keys.las", 10),
    ("nasty/lots_of_vlr.las", 1),
    ("nasty/100-points.las", 100),
    ("nasty/utm17.las", 10),
    ("nasty/noise-dirty.las", 1_065),
    ("nasty/epsg_4326_degrees.las", 5_380),
    ("nasty/issue_2421.ply", 1),
    ("nasty/mesh.ply", 4),
    ("nasty/text_extradim.ply", 1),
    ("nasty/simple_text_trailing_space.ply", 3),
    ("nasty/points_emptyface.ply", 1_024),
    ("nasty/points_emptyascii.ply", 12),
    ("nasty/example_with_invalid_comments.ply", 3),
    ("nasty/example_with_invalid_comments_little_endian.ply", 3),
    ("nasty/append-bug.laz", 37_805),
    ("nasty/unregistered_extra_bytes.las", 4),
    ("nasty/single_point.laz", 1),
    ("nasty/pdalfail_0643_6319.laz", 89),
    ("nasty/crop_duplicate.laz", 849),
    ("nasty/gaussian_splat_train_1000.ply", 1_000),
];

/// Files to refuse, and what the message must say.
const REFUSED: &[(&str, &str)] = &[
    ("nasty/laszip_broken_coder.laz", "end before 213093 points are decoded"),
    ("nasty/laszip_broken_compressor.laz", "ompressor"),
    ("nasty/laszip_broken_size.laz", "LAZ"),
    ("nasty/no-points.las", "without points"),
    ("nasty/no_vertex.ply", "no element `vertex`"),
    ("nasty/sized_dims.ply", "no property `z`"),
];

#[test]
fn all_files_load_or_are_refused() {
    let Some(data) = data() else { return };
    for (file, points) in POINTS {
        let cloud = load(&data.join(file)).unwrap_or_else(|e| panic!("{e}"));
        assert_eq!((cloud.len(), cloud.non_finite), (*points, 0), "{file}");
        let columns = [
            cloud.colors.as_ref().map(Vec::len),
            cloud.alphas.as_ref().map(Vec::len),
            cloud.normals.as_ref().map(Vec::len),
            cloud.radii.as_ref().map(Vec::len),
            cloud.classification.as_ref().map(Vec::len),
            cloud.intensity.as_ref().map(Vec::len),
        ];
        let scalars = cloud.scalars.iter().map(|(_, values)| Some(values.len()));
        assert!(columns.into_iter().chain(scalars).flatten().all(|len| len == *points), "{file}: {columns:?}");
    }
    for (file, says) in REFUSED {
        let message = load(&data.join(file)).expect_err(file).to_string();
        assert!(message.starts_with(&data.join(file).display().to_string()), "{message}");
        assert!(message.contains(says), "{message}");
        println!("{message}");
    }
}

#[test]
fn no_file_is_forgotten() {
    let Some(data) = data() else { return };
    for folder in ["models", "lidar", "photogrammetry", "formats", "nasty", "indoor"] {
        for entry in std::fs::read_dir(data.join(folder)).unwrap() {
            let name = entry.unwrap().file_name().into_string().unwrap();
            if [".ply", ".las", ".laz"].iter().any(|extension| name.ends_with(extension)) {
                let file = format!("{folder}/{name}");
                let known = POINTS.iter().map(|(file, _)| file).chain(REFUSED.iter().map(|(file, _)| file));
                assert!(known.into_iter().any(|known| *known == file), "{file} is in no table");
            }
        }
    }
}

/// Extent and smallest corner as other readers give them, to the digits printed there.
#[test]
fn boxes_of_real_files() {
    let Some(data) = data() else { return };
    let boxes = [
        ("lidar/autzen_stadium_2010_crop.laz", [2000.0, 2000.0, 187.14], [636000.02, 850500.03, 411.01], 0.05),
        ("lidar/lone_star_geyser_tls.copc.laz", [32.441, 40.76, 15.679], [515368.6, 4918340.4, 2322.8962], 0.06),
        ("photogrammetry/lion_takanawa.copc.laz", [4.2, 5.68, 4.57], [-4.99, 1.04, -3.45], 0.006),
        ("formats/laz_pointwise_nochunk.laz", [440.24, 412.73, 100.9], [2483569.1, 366203.87, 1480.88], 0.06),
        ("formats/las14_test1_4.las", [501.23, 5.27, 6.3198], [1694038.4, 1816492.7, 5592.7499], 0.06),
        ("formats/horse_big_endian_rgb.ply", [0.084006, 0.18334, 0.15284], [-0.042003, -0.0916705, -0.0764180], 1e-5),
        ("indoor/livingroom_fragment_double.ply", [2.3203, 1.4584, 2.069], [-1.4492188, -1.1054688, 0.78515625], 1e-4),
    ];
    for (file, extent, min, tolerance) in boxes {
        let bounds = load(&data.join(file)).unwrap().bounds().unwrap();
        let got = [(bounds.max - bounds.min).to_array(), bounds.min.to_array()].concat();
        for (got, wanted) in got.iter().zip([extent, min].concat()) {
            assert!((got - wanted).abs() <= tolerance, "{file}: {got}, not {wanted}");
        }
    }
}

#[test]
fn attributes_of_real_files() {
    let Some(data) = data() else { return };
    let load = |file: &str| load(&data.join(file)).unwrap_or_else(|e| panic!("{e}"));
    let brightest = |file: &str| {
        let colors = load(file).colors.unwrap_or_else(|| panic!("{file} has no colors"));
        colors.into_iter().map(|c| c.max_element()).fold(0.0, f32::max)
    };
    // 8 bits in 16, at most 236: taken as 16 bits the brightest would be 236/65535.
    assert_eq!(brightest("lidar/autzen_trim.laz"), decode_srgb(236.0 / 255.0));
    assert!(brightest("lidar/sample_c_rgb_classified.las") > 0.5);
    assert_eq!(load("lidar/ign_lidarhd_77050_627755_classified.laz").colors, None, "all zero");
    assert_eq!(brightest("formats/horse_big_endian_rgb.ply"), 1.0);

    let bunny = load("models/bun_zipper.ply");
    assert!(bunny.intensity.is_some() && bunny.scalars[0].0 == "confidence" && bunny.up == UpAxis::Y);
    assert!(load("models/stanford_dragon_437k.ply").normals.unwrap().iter().all(|n| n.is_normalized()));
    assert_eq!(load("nasty/gaussian_splat_train_1000.ply").normals, None, "all zero");

    let codes = |file: &str| {
        let mut codes = load(file).classification.unwrap();
        codes.sort_unstable();
        codes.dedup();
        codes
    };
    assert_eq!(codes("lidar/ahn3_delft_classified.laz"), [1, 2, 6, 9, 26]);
    assert_eq!(codes("nasty/append-bug.laz"), [1, 2, 3, 4, 5, 17, 65]);
    let names = |file: &str| load(file).scalars.into_iter().map(|(name, _)| name).collect::<Vec<_>>();
    assert!(names("photogrammetry/lion_takanawa.copc.laz").contains(&"OriginId".to_owned()));
}

#[test]
fn halves_of_real_files_are_refused() {
    let Some(data) = data() else { return };
    let folder = crate::Folder::new();
    for file in [
        "models/turbine_blade_100k.ply",
        "nasty/points_emptyface.ply",
        "nasty/100-points.las",
        "lidar/autzen_trim.laz",
        "photogrammetry/lion_takanawa.copc.laz",
        "formats/laz_pointwise_nochunk.laz",
    ] {
        let bytes = std::fs::read(data.join(file)).unwrap();
        let half = folder.file("half", &bytes[..bytes.len() / 2]);
        let error = load(&half).expect_err(file);
        assert!(matches!(error, Error::Truncated { .. } | Error::Malformed { .. }), "{error}");
        println!("{error}");
    }
}
