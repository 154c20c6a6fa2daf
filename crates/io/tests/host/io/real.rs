//! Real files: those in tests/data, and all where they are present.

use std::path::Path;

use glam::DVec3;
use pellucid_core::cloud::{Cloud, UpAxis};
use pellucid_core::color::decode_srgb;
use pellucid_io::Error;
use pellucid_testing_host::{clouds, whole_clouds};

use super::load;

/// Finite points of each file, measured by other readers (laspy, plyfile, pye57).
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
    ("indoor/office1.pcd", 307_200 - 52_744),
    ("indoor/five_people.pcd", 307_200 - 68_125),
    ("indoor/redwood_fragment.pcd", 113_662),
    ("formats/tree_ascii.pcd", 69_977),
    ("formats/tree_binary.pcd", 69_977),
    ("formats/bun0_ascii.pcd", 397),
    ("nasty/utm17_comma.pcd", 10),
    ("nasty/utm17_tab.pcd", 10),
    ("nasty/utm17_space.pcd", 10),
    ("nasty/autzen-utm.pcd", 1_065),
    ("nasty/capture0001_organised_nan_compressed.pcd", 307_200 - 57_553),
    ("nasty/samp53_utm_float32.pcd", 34_378),
    ("e57/pump_tls.e57", 155_201),
    ("e57/bunny_double.e57", 30_571),
    ("nasty/read_error.e57", 2_651),
    ("nasty/cartesian_invalid_state_single.e57", 1),
    ("nasty/no_ext_namespace.e57", 1),
    ("nasty/tiny_spherical.e57", 180),
    ("nasty/scaled_integer_intensity.e57", 2),
    ("nasty/tiny_pc_with_extension.e57", 1),
    ("formats/bunny_open3d.pts", 30_571),
    ("formats/test.pts", 19),
    ("formats/autzen.pts", 10),
    ("formats/1.2-with-color.ptx", 1_065),
    ("formats/points_agisoft.xyz", 100),
    ("formats/points_cloudcompare.xyz", 101),
    ("nasty/crlf_test.txt", 10),
    ("nasty/missingheader.txt", 5),
    ("nasty/duplicates-unsorted.txt", 7),
    ("nasty/quoted.txt", 9),
];

/// Points of what only tests/data has: every nth of a file above, from a count of theirs.
const CUT: &[(&str, usize)] = &[
    ("models/turbine_blade_6k.ply", 99_519usize.div_ceil(16)),
    ("lidar/sample_c_2k.las", 14_408usize.div_ceil(7)),
    ("indoor/livingroom_fragment_2k.ply", 112_698usize.div_ceil(56)),
    ("indoor/redwood_fragment_1k.pcd", 113_662usize.div_ceil(100)),
];

/// Points of each file that are left out: not finite, or marked as invalid.
const LEFT_OUT: &[(&str, usize)] = &[
    ("indoor/office1.pcd", 52_744),
    ("indoor/five_people.pcd", 68_125),
    ("nasty/capture0001_organised_nan_compressed.pcd", 57_553),
    ("nasty/cartesian_invalid_state_single.e57", 2),
    // Every second one is a direction, without a distance.
    ("nasty/tiny_spherical.e57", 180),
];

/// Files to refuse, and what the message must say.
const REFUSED: &[(&str, &str)] = &[
    ("nasty/laszip_broken_coder.laz", "end before 213093 points are decoded"),
    ("nasty/laszip_broken_compressor.laz", "ompressor"),
    ("nasty/laszip_broken_size.laz", "LAZ"),
    ("nasty/no-points.las", "the cloud has no points"),
    ("nasty/no_vertex.ply", "no element `vertex`"),
    ("nasty/sized_dims.ply", "no property `z`"),
    ("nasty/corrupt_crc.e57", "checksum"),
    ("nasty/empty_pc.e57", "the cloud has no points"),
    ("nasty/empty.e57", "the cloud has no points"),
    ("nasty/badheader.txt", "line 1: no column `z`, only [X, Y, X]"),
];

/// Folders of point clouds.
pub const FOLDERS: [&str; 7] = ["models", "lidar", "photogrammetry", "indoor", "e57", "formats", "nasty"];

#[test]
fn all_files_load_or_are_refused() {
    for clouds in clouds() {
        let cut = if clouds.is_subset() { CUT } else { &[] };
        let found = POINTS.iter().chain(cut).filter_map(|(file, points)| Some((file, clouds.file(file)?, points)));
        let count = found.map(|(file, path, points)| assert_loads(file, &path, *points)).count();
        assert!(count >= if clouds.is_subset() { 47 } else { 48 }, "{count} files");
        let found = REFUSED.iter().filter_map(|(file, says)| Some((file, clouds.file(file)?, says)));
        for (file, path, says) in found {
            let message = load(&path).expect_err(file).to_string();
            assert!(message.starts_with(&path.display().to_string()), "{message}");
            assert!(message.contains(says), "{message}");
            println!("{message}");
        }
    }
}

/// Asserts that a file has this many finite points, and as many values in every column.
fn assert_loads(file: &str, path: &Path, points: usize) {
    let cloud = load(path).unwrap_or_else(|e| panic!("{e}"));
    let left_out = LEFT_OUT.iter().find(|(known, _)| *known == file).map_or(0, |(_, count)| *count);
    assert_eq!((cloud.len(), cloud.non_finite), (points, left_out), "{file}");
    let columns = [
        cloud.colors.as_ref().map(Vec::len),
        cloud.alphas.as_ref().map(Vec::len),
        cloud.normals.as_ref().map(Vec::len),
        cloud.radii.as_ref().map(Vec::len),
        cloud.classification.as_ref().map(Vec::len),
        cloud.intensity.as_ref().map(Vec::len),
    ];
    let scalars = cloud.scalars.iter().map(|(_, values)| Some(values.len()));
    assert!(columns.into_iter().chain(scalars).flatten().all(|len| len == points), "{file}: {columns:?}");
}

#[test]
fn no_file_is_forgotten() {
    for clouds in clouds() {
        for folder in FOLDERS {
            // The subset has none of some folders.
            let Ok(entries) = std::fs::read_dir(clouds.folder().join(folder)) else {
                assert!(clouds.is_subset(), "no folder {folder}");
                continue;
            };
            for entry in entries {
                let name = entry.unwrap().file_name().into_string().unwrap();
                let file = format!("{folder}/{name}");
                let known = POINTS.iter().chain(CUT).map(|(file, _)| file).chain(REFUSED.iter().map(|(file, _)| file));
                assert!(known.into_iter().any(|known| *known == file), "{file} is in no table");
            }
        }
    }
}

/// Extent and smallest corner as other readers give them, to the digits printed there.
#[test]
fn boxes_of_real_files() {
    let boxes = [
        ("lidar/autzen_stadium_2010_crop.laz", [2000.0, 2000.0, 187.14], [636000.02, 850500.03, 411.01], 0.05),
        ("lidar/lone_star_geyser_tls.copc.laz", [32.441, 40.76, 15.679], [515368.6, 4918340.4, 2322.8962], 0.06),
        ("photogrammetry/lion_takanawa.copc.laz", [4.2, 5.68, 4.57], [-4.99, 1.04, -3.45], 0.006),
        ("formats/laz_pointwise_nochunk.laz", [440.24, 412.73, 100.9], [2483569.1, 366203.87, 1480.88], 0.06),
        ("formats/las14_test1_4.las", [501.23, 5.27, 6.3198], [1694038.4, 1816492.7, 5592.7499], 0.06),
        ("formats/horse_big_endian_rgb.ply", [0.084006, 0.18334, 0.15284], [-0.042003, -0.0916705, -0.0764180], 1e-5),
        ("indoor/office1.pcd", [4.1498, 3.7777, 3.531], [-2.6454761, -2.196429, 1.8329999], 1e-4),
        ("indoor/five_people.pcd", [4.9196, 5.0155, 7.998], [-1.9311192, -3.8749232, 1.7590001], 1e-4),
        ("indoor/redwood_fragment.pcd", [2.3675, 1.9464, 0.80402], [1.1519887, 0.81527287, 0.72640908], 1e-4),
        ("formats/tree_ascii.pcd", [4.9997, 4.9999, 27.538], [-121.2607, -24.789, 1.9876], 1e-3),
        ("formats/tree_binary.pcd", [4.9997, 4.9999, 27.538], [-121.26071, -24.78898, 1.9876008], 1e-3),
        ("formats/bun0_ascii.pcd", [0.1535, 0.14708, 0.11283], [-0.093938, 0.037420001, -0.055025999], 1e-5),
        ("e57/pump_tls.e57", [4.6254, 4.5085, 3.7427], [-2.903763, -5.301102, -1.899704], 1e-4),
        ("e57/bunny_double.e57", [0.1557, 0.14731, 0.12067], [-0.094689, 0.040011, -0.061873], 1e-5),
        ("formats/bunny_open3d.pts", [0.1557, 0.14731, 0.12067], [-0.094689, 0.040011, -0.061873], 1e-5),
        ("formats/test.pts", [29.031, 22.527, 1.9909], [-25.050461, -24.533554, -2.000961], 1e-3),
        ("formats/autzen.pts", [23.56, 376.4, 84.22], [636102.84, 848968.8, 427.92], 0.01),
        ("formats/1.2-with-color.ptx", [3362.7, 4635.7, 179.79], [635619.85, 848899.7, 406.59], 0.06),
        ("formats/points_agisoft.xyz", [16.496, 41.4, 12.389], [665171.38, 5648340.5, 233.51407], 0.06),
        ("formats/points_cloudcompare.xyz", [16.496, 83.802, 17.854], [665171.38, 5648298.1, 228.04919], 0.06),
        ("indoor/livingroom_fragment_double.ply", [2.3203, 1.4584, 2.069], [-1.4492188, -1.1054688, 0.78515625], 1e-4),
    ];
    for clouds in clouds() {
        let found = boxes.iter().filter_map(|expected| Some((clouds.file(expected.0)?, expected)));
        for (path, (file, extent, min, tolerance)) in found {
            let bounds = load(&path).unwrap().bounds().unwrap();
            let got = [(bounds.max - bounds.min).to_array(), bounds.min.to_array()].concat();
            for (got, wanted) in got.iter().zip([*extent, *min].concat()) {
                assert!((got - wanted).abs() <= *tolerance, "{file}: {got}, not {wanted}");
            }
        }
    }
}

/// The positions stated by the data's README.
#[test]
fn places_of_nasty_files() {
    for clouds in clouds() {
        let load = |file: &str| load(&clouds.file(&format!("nasty/{file}")).unwrap()).unwrap();
        // To half of the last digit printed there.
        assert_near(&load("spurious.las"), [1.006, 0.012, 55.0], 0.05);
        assert_near(&load("single_point.laz"), [0.0; 3], 0.0);
        assert!((load("issue_2421.ply").positions[0].z / 1e9 - 1.23).abs() < 0.005);
        for file in ["utm17.las", "utm17_comma.pcd", "utm17_tab.pcd", "utm17_space.pcd", "crlf_test.txt"] {
            let cloud = load(file);
            let middle = DVec3::new(289_816.0, 4_320_979.5, 170.6);
            assert!(cloud.positions.iter().all(|p| p.distance(middle) < 4.0), "{file}");
            // Float32 would be off by up to 0.25.
            let second = DVec3::new(289_814.64, 4_320_978.84, 170.76);
            assert!(cloud.positions[1].distance(second) < 1e-6, "{file}: {}", cloud.positions[1]);
        }
        let spherical = load("tiny_spherical.e57");
        let (near, far) = extremes(&spherical.positions.iter().map(|p| p.length() as f32).collect::<Vec<_>>());
        assert!(0.0 < near && near <= far && far.is_finite(), "{near} to {far}");
    }
}

#[test]
fn places_of_large_nasty_files() {
    let Some(data) = whole_clouds() else { return };
    let load = |file: &str| load(&data.join("nasty").join(file)).unwrap();
    assert_near(&load("epsg_4326_degrees.las"), [0.02, 0.02, 39.0], 0.5);
    let stored_as_float32 = load("samp53_utm_float32.pcd");
    assert!(stored_as_float32.positions.iter().all(|p| (p.y * 2.0).fract() == 0.0));
}

/// Asserts that a cloud's box has this size, to a share of it.
#[track_caller]
fn assert_near(cloud: &Cloud, wanted: [f64; 3], tolerance: f64) {
    let bounds = cloud.bounds().unwrap();
    let size = (bounds.max - bounds.min).to_array();
    let off = |(size, wanted): (f64, f64)| (size - wanted).abs() > tolerance * wanted;
    assert!(!size.into_iter().zip(wanted).any(off), "{size:?}, not {wanted:?}");
}

fn extremes(values: &[f32]) -> (f32, f32) {
    values.iter().fold((f32::INFINITY, f32::NEG_INFINITY), |(low, high), value| (low.min(*value), high.max(*value)))
}

/// Splats hold what a trainer left: colors around the middle, every opacity, and sizes far below the scene's.
#[test]
fn gaussian_splats_of_a_real_scene() {
    let Some(data) = whole_clouds() else { return };
    let splats = load(&data.join("nasty/gaussian_splat_train_1000.ply")).unwrap();
    let (bounds, gaussians) = (splats.bounds().unwrap(), splats.gaussians.unwrap());
    let (alphas, colors) = (splats.alphas.unwrap(), splats.colors.unwrap());
    let (low, high) = extremes(&alphas);
    assert!(0.0 < low && low < 0.1 && 0.9 < high && high <= 1.0, "opacities from {low} to {high}");
    let mean = colors.iter().sum::<glam::Vec3>() / 1000.0;
    assert!(mean.min_element() > 0.05 && mean.max_element() < 0.8, "{mean}");
    let extents: Vec<f32> = gaussians.extents.iter().flat_map(|extents| extents.to_array()).collect();
    let (low, high) = extremes(&extents);
    assert!(low > 0.0 && f64::from(high) < bounds.diagonal(), "extents from {low} to {high}");
    assert!(gaussians.degree == 3 && splats.scalars.is_empty() && splats.warnings.is_empty());
}

/// The brightest channel of any point.
#[track_caller]
fn brightest(cloud: &Cloud) -> f32 {
    cloud.colors.as_ref().expect("colors").iter().map(|c| c.max_element()).fold(0.0, f32::max)
}

/// The codes of the points' classes, each once.
fn codes(cloud: Cloud) -> Vec<u8> {
    let mut codes = cloud.classification.unwrap();
    codes.sort_unstable();
    codes.dedup();
    codes
}

fn names(cloud: Cloud) -> Vec<String> {
    cloud.scalars.into_iter().map(|(name, _)| name).collect()
}

#[test]
fn attributes_of_real_files() {
    for clouds in clouds() {
        let load = |file: &str| load(&clouds.file(file).unwrap()).unwrap_or_else(|e| panic!("{e}"));
        // Shorts that hold bytes, as in the LAS file of the same name; and a table and a grid with the same points.
        let las = load("formats/1.2-with-color.las");
        let ptx = load("formats/1.2-with-color.ptx");
        assert_eq!((ptx.len(), ptx.colors.as_ref().map(Vec::len)), (las.len(), Some(1_065)));
        assert_eq!(brightest(&ptx), brightest(&las));

        assert_eq!(load("nasty/scaled_integer_intensity.e57").intensity.map(|values| values.len()), Some(2));
        assert_eq!(load("nasty/tiny_pc_with_extension.e57").normals.map(|normals| normals.len()), Some(1));
        assert!(load("nasty/no_ext_namespace.e57").classification.is_some());
        let autzen = load("nasty/autzen-utm.pcd");
        assert!(autzen.colors.is_some() && autzen.intensity.is_some() && autzen.classification.is_some());
        let (low, high) = extremes(&load("formats/autzen.pts").intensity.unwrap());
        assert_eq!((low, high), (-1998.0, 602.0));
        assert_eq!(load("nasty/missingheader.txt").intensity.unwrap(), [25.0, 30.0, 35.0, 40.0, 45.0]);
        assert_eq!(load("nasty/crlf_test.txt").intensity.unwrap()[9], 9.0);
        assert_eq!(names(load("formats/points_cloudcompare.xyz")), ["column_7"]);
        assert_eq!(names(load("nasty/duplicates-unsorted.txt")), ["GpsTime", "PointSourceId", "UserData"]);
    }
}

/// Every nth point of a file keeps its attributes in the cut files.
#[test]
fn attributes_of_cut_files() {
    for clouds in clouds().into_iter().filter(|clouds| clouds.is_subset()) {
        let load = |file: &str| load(&clouds.file(file).unwrap()).unwrap_or_else(|e| panic!("{e}"));
        assert!(load("models/turbine_blade_6k.ply").normals.unwrap().iter().all(|n| n.is_normalized()));
        for file in ["lidar/sample_c_2k.las", "indoor/redwood_fragment_1k.pcd", "indoor/livingroom_fragment_2k.ply"] {
            assert!(brightest(&load(file)) > 0.5, "{file}");
        }
        assert_eq!(names(load("indoor/redwood_fragment_1k.pcd")), ["curvature"]);
        assert_eq!(codes(load("lidar/sample_c_2k.las")), [2, 3, 4, 6, 11, 14, 31]);
    }
}

#[test]
fn attributes_of_large_files() {
    let Some(data) = whole_clouds() else { return };
    let load = |file: &str| load(&data.join(file)).unwrap_or_else(|e| panic!("{e}"));
    // 8 bits in 16, at most 236: taken as 16 bits the brightest would be 236/65535.
    assert_eq!(brightest(&load("lidar/autzen_trim.laz")), decode_srgb(236.0 / 255.0));
    assert!(brightest(&load("lidar/sample_c_rgb_classified.las")) > 0.5);
    assert_eq!(load("lidar/ign_lidarhd_77050_627755_classified.laz").colors, None, "all zero");
    assert_eq!(brightest(&load("formats/horse_big_endian_rgb.ply")), 1.0);

    let bunny = load("models/bun_zipper.ply");
    assert!(bunny.intensity.is_some() && bunny.scalars[0].0 == "confidence" && bunny.up == UpAxis::Y);
    assert!(load("models/stanford_dragon_437k.ply").normals.unwrap().iter().all(|n| n.is_normalized()));
    assert_eq!(load("nasty/gaussian_splat_train_1000.ply").normals, None, "all zero");

    // A stereo camera on an office, a depth camera on people, and scans.
    for file in ["indoor/office1.pcd", "indoor/five_people.pcd", "indoor/redwood_fragment.pcd", "e57/pump_tls.e57"] {
        assert!(brightest(&load(file)) > 0.5, "{file}");
    }
    assert_eq!(load("formats/bunny_open3d.pts").positions[1], DVec3::new(-0.044779, 0.128887, 0.001904));

    let pump = load("e57/pump_tls.e57");
    let (low, high) = extremes(&pump.intensity.unwrap());
    assert!(0.0 <= low && low < high && high <= 1.0 && pump.scalars.is_empty() && pump.up == UpAxis::Z);

    assert_eq!(codes(load("lidar/ahn3_delft_classified.laz")), [1, 2, 6, 9, 26]);
    assert_eq!(codes(load("nasty/append-bug.laz")), [1, 2, 3, 4, 5, 17, 65]);
    assert_eq!(names(load("indoor/redwood_fragment.pcd")), ["curvature"]);
    assert!(names(load("photogrammetry/lion_takanawa.copc.laz")).contains(&"OriginId".to_owned()));
}

#[test]
fn halves_of_real_files_are_refused() {
    let folder = super::Folder::new();
    for clouds in clouds() {
        let cut: &[_] = if clouds.is_subset() {
            &["models/turbine_blade_6k.ply", "indoor/redwood_fragment_1k.pcd", "lidar/sample_c_2k.las"]
        } else {
            &[]
        };
        let files = [
            "models/turbine_blade_100k.ply",
            "nasty/points_emptyface.ply",
            "nasty/100-points.las",
            "lidar/autzen_trim.laz",
            "photogrammetry/lion_takanawa.copc.laz",
            "formats/laz_pointwise_nochunk.laz",
            "indoor/office1.pcd",
            "indoor/redwood_fragment.pcd",
            "formats/tree_ascii.pcd",
            "e57/pump_tls.e57",
            "formats/test.pts",
            "formats/1.2-with-color.ptx",
        ];
        for (file, path) in files.iter().chain(cut).filter_map(|file| Some((file, clouds.file(file)?))) {
            let bytes = std::fs::read(path).unwrap();
            let name = Path::new(file).file_name().unwrap().to_str().unwrap();
            let half = folder.file(name, &bytes[..bytes.len() / 2]);
            let error = load(&half).expect_err(file);
            assert!(matches!(error, Error::Truncated { .. } | Error::Malformed { .. }), "{error}");
            println!("{error}");
        }
    }
}
