//! Real and nasty files through the binary: pictures that show them, or one clean error.

use std::path::{Path, PathBuf};
use std::process::Output;

use assert_cmd::Command;
use pellucid_core::cloud::Cloud;
use pellucid_core::progress::Progress;
use pellucid_io::output::read_image;
use pellucid_testing::{Clouds, clouds, has_device, shader_cache, whole_clouds};
use tempfile::TempDir;

/// Runs the binary; quiet, since what real files deserve a warning for is not this test's business.
fn pellucid(folder: &TempDir, args: &[&str], file: &Path) -> Output {
    let mut command = Command::cargo_bin("pellucid").unwrap();
    command.current_dir(folder).env("PELLUCID_VALIDATION", "1").env("PELLUCID_CACHE_DIR", shader_cache());
    command.args(args).arg("-q").arg(file).output().unwrap()
}

/// The device of the tests, as an option.
fn device() -> Vec<String> {
    std::env::var("PELLUCID_TEST_DEVICE").map_or_else(|_| Vec::new(), |device| vec!["--device".to_owned(), device])
}

/// Renders a file to `out.png` with automatic camera and radius.
fn render(folder: &TempDir, args: &[&str], file: &Path) -> Output {
    let device = device();
    let options = device.iter().map(String::as_str).chain(args.iter().copied());
    pellucid(folder, &["render", "-o", "out.png"].into_iter().chain(options).collect::<Vec<_>>(), file)
}

#[test]
fn info_counts_the_points() {
    let folder = tempfile::tempdir().unwrap();
    // Counted by other readers (plyfile, laspy); NaN-free, all of them.
    let counts = [
        ("models/bun_zipper.ply", 35_947),
        ("models/stanford_dragon_437k.ply", 437_645),
        ("lidar/autzen_trim.laz", 110_000),
        ("lidar/sample_c_rgb_classified.las", 14_408),
        ("photogrammetry/lion_takanawa.copc.laz", 341_989),
        ("formats/horse_big_endian_rgb.ply", 48_485),
        ("e57/bunny_double.e57", 30_571),
        ("indoor/redwood_fragment.pcd", 113_662),
        ("formats/bunny_open3d.pts", 30_571),
        ("formats/1.2-with-color.ptx", 1_065),
        ("formats/points_agisoft.xyz", 100),
        ("nasty/crlf_test.txt", 10),
    ];
    for clouds in clouds() {
        for (path, points) in counts.iter().filter_map(|(file, points)| Some((clouds.file(file)?, *points))) {
            let output = pellucid(&folder, &["info", "--json"], &path);
            assert!(output.status.success(), "{output:?}");
            let json: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
            assert_eq!((&json["points"], &json["non_finite"]), (&points.into(), &0.into()), "{}", path.display());
        }
    }
}

/// A file of the data and what `pellucid prepare` makes of it.
fn prepared(folder: &TempDir, file: &Path, args: &[&str]) -> (Cloud, Cloud) {
    let output = pellucid(folder, &[&["prepare", "-o", "out.ply"], args].concat(), file);
    assert!(output.status.success() && output.stderr.is_empty(), "{output:?}");
    let load = |path: &Path| pellucid_io::load(path, &Progress::hidden()).unwrap();
    let (source, cloud) = (load(file), load(&folder.path().join("out.ply")));
    // A PLY file has no place for a sensor.
    let plain = Cloud { prepared: None, radii: source.radii.clone(), sensor: source.sensor, ..cloud.clone() };
    assert_eq!(plain, source, "every column, to the bit");
    (source, cloud)
}

#[test]
fn real_clouds_are_prepared() {
    let Some(data) = whole_clouds() else { return };
    let folder = tempfile::tempdir().unwrap();

    // Ground, buildings and water are solid; what is not classified is trees, mostly.
    let classes = ["--field", "classification", "--soft-classes", "1"];
    let (source, delft) = prepared(&folder, &data.join("lidar/ahn3_delft_classified.laz"), &classes);
    let soft = fields(&delft).iter().filter(|f| **f == 1.0).count();
    assert_eq!((soft, delft.up), (196_137, pellucid_core::cloud::UpAxis::Z));
    assert_radii(&source, &delft);

    let (_, lion) = prepared(&folder, &data.join("photogrammetry/lion_takanawa.copc.laz"), &[]);
    let f = fields(&lion);
    assert!(f.contains(&0.0) && f.contains(&1.0) && f.iter().all(|f| (0.0..=1.0).contains(f)));
    // A photogrammetric surface with a few stray points, whose radii are capped: nearly all of it is certain.
    assert!(f.iter().filter(|f| **f > 0.1).count() * 20 < f.len());

    assert_distances(&folder, &data.join("models/turbine_blade_100k.ply"));
}

#[test]
fn cut_clouds_are_prepared() {
    for clouds in clouds().into_iter().filter(Clouds::is_subset) {
        let folder = tempfile::tempdir().unwrap();
        // The class of most points is one of two trees, high and low.
        let path = clouds.file("lidar/sample_c_2k.las").unwrap();
        let (source, trees) = prepared(&folder, &path, &["--field", "classification", "--soft-classes", "4,5"]);
        let is_tree = |class: &u8| f32::from(u8::from([4, 5].contains(class)));
        let classes = source.classification.as_ref().unwrap();
        assert_eq!(fields(&trees), classes.iter().map(is_tree).collect::<Vec<_>>());
        assert!(fields(&trees).contains(&1.0) && fields(&trees).contains(&0.0));
        assert_radii(&source, &trees);
        let (_, room) = prepared(&folder, &clouds.file("indoor/livingroom_fragment_2k.ply").unwrap(), &[]);
        let f = fields(&room);
        assert!(f.contains(&0.0) && f.contains(&1.0) && f.iter().all(|f| (0.0..=1.0).contains(f)));
        assert_distances(&folder, &clouds.file("models/turbine_blade_6k.ply").unwrap());
    }
}

fn fields(cloud: &Cloud) -> Vec<f32> {
    cloud.prepared.as_ref().expect("recognized").values.clone()
}

/// Asserts that radii follow from the distances to the nearest 24 points, by a search through all of them.
fn assert_radii(source: &Cloud, prepared: &Cloud) {
    let radii = prepared.radii.as_ref().unwrap();
    for i in (0..source.len()).step_by(source.len().div_ceil(13)) {
        let mut squared: Vec<f64> = source.positions.iter().map(|p| p.distance_squared(source.positions[i])).collect();
        // The nearest is the point itself.
        let (_, farthest, _) = squared.select_nth_unstable_by(24, f64::total_cmp);
        assert_eq!(radii[i], (2.0 * farthest.sqrt() / 24f64.sqrt()) as f32, "point {i}");
    }
}

/// Asserts that the field of a blade is its points' distance to the axis.
fn assert_distances(folder: &TempDir, file: &Path) {
    let (source, blade) = prepared(folder, file, &["--field", "distance-to-axis"]);
    let center = source.bounds().unwrap().center();
    let distance = |p: &glam::DVec3| (p.x - center.x).hypot(p.z - center.z);
    let nearest = source.positions.iter().map(distance).fold(f64::INFINITY, f64::min);
    let farthest = source.positions.iter().map(distance).fold(0.0, f64::max);
    for (p, f) in source.positions.iter().zip(fields(&blade)) {
        assert!((f64::from(f) - (distance(p) - nearest) / (farthest - nearest)).abs() < 1e-6, "{p}: {f}");
    }
}

/// Share of the pixels that are not black, and the box around them: first column and row, one past the last.
fn silhouette(path: &Path) -> (f64, [u32; 4]) {
    let image = read_image(path).unwrap();
    let mut found = [image.width, image.height, 0, 0];
    let mut covered = 0;
    for (i, pixel) in (0..).zip(&image.pixels) {
        if pixel.iter().any(|value| *value > 0.0) {
            let (x, y) = (i % image.width, i / image.width);
            found = [found[0].min(x), found[1].min(y), found[2].max(x + 1), found[3].max(y + 1)];
            covered += 1;
        }
    }
    (f64::from(covered) / image.pixels.len() as f64, found)
}

#[test]
fn real_models_fill_the_image_up_to_its_margin() {
    if !has_device() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    // The share of the image that the object covers, measured in pictures that were looked at and found right.
    let whole = [
        ("models/bun_zipper.ply", "0.1", 0.50),
        ("models/stanford_dragon_437k.ply", "0.2", 0.38),
        ("lidar/autzen_trim.laz", "0.3", 0.21),
    ];
    let subset = [("models/turbine_blade_6k.ply", "0.3", 0.25), ("lidar/sample_c_2k.las", "0.3", 0.30)];
    for clouds in clouds() {
        for (file, opacity, share) in if clouds.is_subset() { &subset[..] } else { &whole[..] } {
            let file = clouds.file(file).unwrap();
            let output = render(&folder, &["--size", "256x256", "--opacity", opacity], &file);
            assert!(output.status.success() && output.stderr.is_empty() && output.stdout.is_empty(), "{output:?}");
            let (file, (covered, [x0, y0, x1, y1])) = (file.display(), silhouette(&folder.path().join("out.png")));
            assert!((0.9 * share..1.1 * share).contains(&covered), "{file}: {covered} of the image is covered");
            // The margin is 2.5% of 256 pixels on each side, 6.4; a disc that reaches it covers the pixels whose
            // centers it holds, or the one of its own center.
            let ends = |low: u32, high: u32| (5..=8).contains(&low) && (248..=251).contains(&high);
            assert!(ends(x0, x1) || ends(y0, y1), "{file}: columns {x0}..{x1}, rows {y0}..{y1}");
            // Narrower ranges lie in the middle.
            for (low, high) in [(x0, x1), (y0, y1)] {
                assert!(low >= 5 && high <= 251 && (low + high).abs_diff(256) <= 4, "{file}: {low}..{high}");
            }
        }
    }
}

/// All files of a folder.
fn files(folder: &Path) -> Vec<PathBuf> {
    let mut found: Vec<_> = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    found.sort();
    found
}

#[test]
fn nasty_files_give_a_picture_or_one_clean_error() {
    if !has_device() {
        return;
    }
    clouds().iter().for_each(|clouds| assert_pictures_or_errors(&files(&clouds.folder().join("nasty"))));
}

/// Asserts that each file gives a picture or one clean error, and which give one.
fn assert_pictures_or_errors(files: &[PathBuf]) {
    assert!(files.len() > 20, "{} files", files.len());
    let mut refused = Vec::new();
    for file in files {
        let folder = tempfile::tempdir().unwrap();
        let picture = folder.path().join("out.png");
        // In white, since points may be as black as the background.
        let args = ["--size", "32x32", "--opacity", "0.5", "--set", "cloud.*.color=[1, 1, 1]"];
        let output = render(&folder, &args, file);
        let stderr = String::from_utf8(output.stderr).unwrap();
        let name = file.file_name().unwrap().to_str().unwrap();
        match output.status.code() {
            Some(0) => {
                assert_eq!(stderr, "", "{name}");
                let (covered, _) = silhouette(&picture);
                assert!(covered > 0.0, "{name}: an empty picture");
            }
            Some(1) => {
                assert!(stderr.starts_with(&format!("error: {}: ", file.display())), "{name}: {stderr}");
                assert!(stderr.lines().count() == 1 && !picture.exists(), "{name}: {stderr}");
                refused.push(name);
            }
            status => panic!("{name}: {status:?}, {stderr}"),
        }
    }
    // Those that hold no point, or that no reader can decode (README of the data).
    let expected = [
        "badheader.txt",
        "corrupt_crc.e57",
        "empty.e57",
        "empty_pc.e57",
        "laszip_broken_coder.laz",
        "laszip_broken_compressor.laz",
        "laszip_broken_size.laz",
        "no-points.las",
        "no_vertex.ply",
        "sized_dims.ply",
    ];
    assert_eq!(refused, expected);
}
