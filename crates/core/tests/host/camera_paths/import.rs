//! Cameras of other programs, against projections worked by hand.

use std::fs;
use std::path::Path;

use glam::{DVec2, DVec3};
use pellucid_core::camera::import::CameraSource;
use pellucid_core::camera::path::CameraPath;
use tempfile::TempDir;

use super::curve;

fn read(path: &Path) -> CameraSource {
    CameraSource::read(path).unwrap_or_else(|error| panic!("{error}"))
}

#[track_caller]
fn refused(path: &Path, says: &str) {
    let error = CameraSource::read(path).expect_err(says);
    let message = error.to_string();
    assert!(message.contains(says) && message.contains(path.file_name().unwrap().to_str().unwrap()), "{message}");
}

/// The pixel at which key `number` sees a point, and its depth.
fn seen(path: &CameraPath, number: usize, size: [u32; 2], world: [f64; 3]) -> (DVec2, f64) {
    curve(path).key_poses()[number].camera(0.1, 100.0).project(DVec3::from(world), size)
}

#[track_caller]
fn assert_seen(path: &CameraPath, number: usize, size: [u32; 2], world: [f64; 3], pixel: [f64; 2], depth: f64) {
    let (at, z) = seen(path, number, size, world);
    assert!((at - DVec2::from(pixel)).length() < 1e-9 && (z - depth).abs() < 1e-12, "{at} at {z}");
}

/// Eye (1, 2, 3), looking along −z; then eye (5, 0, 0), turned by 90° around y to look along −x.
const FRAMES: &str = r#""frames": [
  {"file_path": "b.png", "transform_matrix": [[1, 0, 0, 1], [0, 1, 0, 2], [0, 0, 1, 3], [0, 0, 0, 1]]},
  {"file_path": "a.png", "transform_matrix": [[0, 0, 1, 5], [0, 1, 0, 0], [-1, 0, 0, 0], [0, 0, 0, 1]]}
]"#;

fn transforms(folder: &TempDir, head: &str) -> std::path::PathBuf {
    let path = folder.path().join("transforms.json");
    fs::write(&path, format!("{{{head}, {FRAMES}}}")).unwrap();
    path
}

#[test]
fn nerfstudio_by_hand() {
    let folder = tempfile::tempdir().unwrap();
    let size = [200, 100];
    let path = transforms(&folder, r#""fl_x": 100, "fl_y": 100, "cx": 100, "cy": 50, "w": 200, "h": 100.0, "k1": 0"#);
    let source = read(&path);
    assert_eq!((source.size(), source.warnings().len()), (Some(size), 0), "{:?}", source.warnings());
    let keys = source.path(size);
    assert_eq!(keys.keys.len(), 2);
    // (2, 3, −7) lies 1 to the right, 1 above and 10 before the eye: 100 + 100·1/10 and 50 − 100·1/10.
    assert_seen(&keys, 0, size, [2.0, 3.0, -7.0], [110.0, 40.0], 10.0);
    // (1, 0.5, −1) lies 4 before, 0.5 above and, as −z is to the right of −x, 1 to the right: 100 + 100/4, 50 − 50/4.
    assert_seen(&keys, 1, size, [1.0, 0.5, -1.0], [125.0, 37.5], 4.0);
    // Twice the size in the picture: pixels twice as far from its center.
    assert_seen(&keys, 1, [400, 200], [1.0, 0.5, -1.0], [250.0, 75.0], 4.0);
    // A folder is read by the file in it.
    assert_eq!(read(folder.path()), source);
}

#[test]
fn nerfstudio_by_angle() {
    let folder = tempfile::tempdir().unwrap();
    let angle = 2.0 * 1f64.atan();
    // 90° across 200 pixels: 100 pixels for one unit at depth 1, as above.
    let path = transforms(&folder, &format!("\"camera_angle_x\": {angle}"));
    let source = read(&path);
    assert_eq!(source.size(), None);
    assert_seen(&source.path([200, 100]), 0, [200, 100], [2.0, 3.0, -7.0], [110.0, 40.0], 10.0);
    // Across 300 they are 150.
    assert_seen(&source.path([300, 300]), 0, [300, 300], [2.0, 3.0, -7.0], [165.0, 135.0], 10.0);
    let path = transforms(&folder, &format!("\"camera_angle_x\": {angle}, \"w\": 200, \"h\": 100"));
    assert_seen(&read(&path).path([200, 100]), 0, [200, 100], [2.0, 3.0, -7.0], [110.0, 40.0], 10.0);
}

#[test]
fn cameras_that_are_no_pinholes_give_notes() {
    let folder = tempfile::tempdir().unwrap();
    let warnings = |head: &str| read(&transforms(&folder, head)).warnings().join("\n");
    let base = r#""fl_x": 100, "fl_y": 100, "w": 200, "h": 100"#;
    assert_eq!(warnings(base), "");
    assert_eq!(warnings(&format!("{base}, \"applied_scale\": 1.0")), "", "a scale of 1 moves nothing");
    for (more, says) in [
        (r#""k1": 0.1"#, "distortion"),
        (r#""p2": -0.001"#, "distortion"),
        (r#""camera_model": "OPENCV_FISHEYE""#, "distortion"),
        (r#""camera_model": "FISHEYE624""#, "distortion"),
        (r#""is_fisheye": true"#, "distortion"),
        (r#""cx": 103.5, "cy": 50"#, "up to 3.5 pixels"),
        (r#""applied_transform": [[1, 0, 0, 0]]"#, "after its applied_transform; "),
        (r#""applied_scale": 0.25"#, "after its applied_scale; "),
        (
            r#""applied_scale": 2, "applied_transform": [[1, 0, 0, 0]]"#,
            "after its applied_transform and applied_scale; ",
        ),
    ] {
        let said = warnings(&format!("{base}, {more}"));
        assert!(said.contains(says) && said.lines().count() == 1, "{said}");
    }
    let said = warnings(r#""fl_x": 101, "fl_y": 100, "w": 200, "h": 100"#);
    assert!(said.contains("of 2 of 2 cameras the focal lengths in x and y differ"), "{said}");
}

#[test]
fn cameras_that_draw_no_perspective_are_refused_by_name() {
    let folder = tempfile::tempdir().unwrap();
    let base = r#""fl_x": 100, "fl_y": 100, "w": 200, "h": 100"#;
    for model in ["EQUIRECTANGULAR", "ORTHOPHOTO", "VR180_L", "VR180_R", "OMNIDIRECTIONALSTEREO_L", "equirectangular"] {
        let path = transforms(&folder, &format!("{base}, \"camera_model\": \"{model}\""));
        refused(&path, &format!("frames[0]: camera_model {}: only perspective cameras", model.to_uppercase()));
    }
    refused(&transforms(&folder, &format!("{base}, \"latlong\": true")), "latlong: only perspective cameras");
    refused(&transforms(&folder, &format!("{base}, \"ftheta_p0\": 0.1")), "ftheta_p0: only perspective cameras");
    // One of the frames.
    let text = format!("{{{base}, {FRAMES}}}").replace("\"a.png\"", "\"a.png\", \"camera_model\": \"VR180_R\"");
    let path = folder.path().join("one.json");
    fs::write(&path, text).unwrap();
    refused(&path, "frames[1]: camera_model VR180_R");
    for model in ["PINHOLE", "SIMPLE_PINHOLE", "OPENCV", "perspective", "FULL_OPENCV"] {
        let source = read(&transforms(&folder, &format!("{base}, \"camera_model\": \"{model}\"")));
        assert!(source.warnings().is_empty(), "{model}: {:?}", source.warnings());
    }
}

#[test]
fn damaged_transforms_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("t.json");
    let frame = |matrix: &str, rest: &str| {
        format!("{{\"fl_x\": 9, \"w\": 9, \"h\": 9{rest}, \"frames\": [{{\"transform_matrix\": {matrix}}}]}}")
    };
    let unit = "[[1,0,0,0],[0,1,0,0],[0,0,1,0]]";
    for (text, says) in [
        ("{\"frames\": []}".to_owned(), "no frames"),
        ("{\"cameras\": []}".to_owned(), "neither keys"),
        ("5".to_owned(), "neither keys"),
        (frame("[[1,0,0,NaN],[0,1,0,0],[0,0,1,0]]", ""), "NaN is not a number of JSON"),
        (frame("[[1,0,0,0],\n[0,1,0,-Infinity],[0,0,1,0]]", ""), ":2:9: Infinity is not a number of JSON"),
        ("{\"frames\": [{}]}".to_owned(), "transform_matrix"),
        (frame("[]", ""), "frames[0]: transform_matrix must have"),
        (frame("[[1,0,0],[0,1,0],[0,0,1]]", ""), "length 4"),
        (frame("[[1,0,0,0],[0,1,0,0],[0,0,-1,0]]", ""), "not a rotation"),
        (frame("[[1,0,0,0],[0,0,0,0],[0,0,1,0]]", ""), "not a rotation"),
        (frame("[[1,0,0,1e200],[0,1,0,0],[0,0,1,0]]", ""), "1e75"),
        (frame(unit, ", \"h\": 10"), "duplicate"),
        (frame(unit, ", \"camera_angle_x\": 4"), "camera_angle_x"),
        (frame(unit, "").replace("\"w\": 9", "\"w\": 1e9"), "from 1 to 16384"),
        (frame(unit, "").replace("\"fl_x\": 9", "\"fl_x\": -9"), "focal lengths"),
        (frame(unit, "").replace("\"fl_x\": 9, ", ""), "fl_x"),
        (frame(unit, "").replace("\"w\": 9, ", ""), "need w and h"),
    ] {
        fs::write(&path, &text).unwrap();
        refused(&path, says);
    }
    fs::write(&path, frame(unit, "")).unwrap();
    read(&path);
}

/// Looking along +z from the origin; then turned by a quaternion of 90° around y. Not in the order of their names.
const IMAGES: &str = "# a comment
2 1 0 0 0 0 0 0 1 b 1.jpg
1.5 2.5 -1 3 4 17

7 0.70710678118654752 0 0.70710678118654752 0 1 2 3 1 a.jpg

";

fn model(folder: &TempDir, cameras: &str) -> std::path::PathBuf {
    fs::write(folder.path().join("cameras.txt"), cameras).unwrap();
    fs::write(folder.path().join("images.txt"), IMAGES).unwrap();
    folder.path().to_owned()
}

#[track_caller]
fn assert_model(source: &CameraSource) {
    let size = [200, 100];
    assert_eq!(source.size(), Some(size));
    let keys = source.path(size);
    // a.jpg comes first. R·x + t = (z + 1, y + 2, −x + 3), so that (−7, −1, 1) becomes (2, 1, 10), y down:
    // 100 + 100·2/10 and 50 + 100·1/10.
    assert_seen(&keys, 0, size, [-7.0, -1.0, 1.0], [120.0, 60.0], 10.0);
    // Its eye is −Rᵀt = (3, −2, −1).
    assert!((DVec3::from(keys.keys[0].eye) - DVec3::new(3.0, -2.0, -1.0)).length() < 1e-12);
    assert_seen(&keys, 1, size, [1.0, 2.0, 10.0], [110.0, 70.0], 10.0);
}

#[test]
fn colmap_text_by_hand() {
    let folder = tempfile::tempdir().unwrap();
    for (camera, bent) in [
        ("SIMPLE_PINHOLE 200 100 100 100 50", false),
        ("PINHOLE 200 100 100 100 100 50", false),
        ("SIMPLE_RADIAL 200 100 100 100 50 0", false),
        ("SIMPLE_RADIAL 200 100 100 100 50 -0.02", true),
        ("RADIAL 200 100 100 100 50 0 0.1", true),
        ("OPENCV 200 100 100 100 100 50 0.1 0 0 0", true),
        ("OPENCV_FISHEYE 200 100 100 100 100 50 0 0 0 0", true),
        ("FULL_OPENCV 200 100 100 100 100 50 0 0 0 0 0 0 0 0", false),
    ] {
        let source = read(&model(&folder, &format!("# cameras\n1 {camera}\n")));
        assert_model(&source);
        let said = source.warnings().join("\n");
        assert_eq!(said.contains("distortion"), bent, "{camera}: {said}");
        assert_eq!(said.is_empty(), !bent);
    }
    let off = read(&model(&folder, "1 PINHOLE 200 100 120 100 102 50\n")).warnings().join("\n");
    assert!(off.contains("focal lengths in x and y differ") && off.contains("up to 2.0 pixels"), "{off}");
    assert_model(&read(&folder.path().join("images.txt")));
    // As COLMAP and nerfstudio lay it out.
    let above = tempfile::tempdir().unwrap();
    fs::create_dir_all(above.path().join("sparse")).unwrap();
    model(&folder, "1 PINHOLE 200 100 100 100 100 50\n");
    fs::rename(folder.keep(), above.path().join("sparse/0")).unwrap();
    assert_model(&read(above.path()));
}

#[test]
fn colmap_text_without_lines_of_points_gives_every_image() {
    let folder = tempfile::tempdir().unwrap();
    model(&folder, "1 PINHOLE 200 100 100 100 100 50\n");
    let line = |number: usize, name: &str| format!("{number} 1 0 0 0 {number} 0 0 1 {name}\n");
    for (images, expected) in [
        (format!("# a list\n{}{}{}", line(1, "a.jpg"), line(2, "b.jpg"), line(3, "c.jpg")), 3),
        // Some with points, one with none, one without a line; names that are numbers, and that have spaces.
        (format!("{}1 2 -1 3.5 4 17\n{}\n{}{}", line(1, "1"), line(2, "2"), line(3, "3 rd"), line(4, "4")), 4),
        (format!("{}  \n{}1e1 -2 5\n", line(1, "a"), line(2, "b")), 2),
    ] {
        fs::write(folder.path().join("images.txt"), &images).unwrap();
        let keys = read(folder.path()).path([200, 100]).keys;
        let eyes: Vec<_> = keys.iter().map(|key| key.eye[0]).collect();
        assert_eq!(eyes, (1..=expected).map(|number| -f64::from(number)).collect::<Vec<_>>(), "{images}");
    }
    fs::write(folder.path().join("images.txt"), format!("{}1 2 -1 3\n", line(1, "a"))).unwrap();
    let message = CameraSource::read(folder.path()).unwrap_err().to_string();
    assert!(message.contains("images.txt:2:1: QZ is missing"), "{message}");
}

/// Cameras as the training of Gaussians writes them: looking along +z from (1, 2, 3), y down; then from (5, 0, 0),
/// turned by 90° around y to look along +x.
const TRAINED: &str = r#"[
  {"id": 0, "img_name": "b", "width": 200, "height": 100, "position": [1, 2, 3],
   "rotation": [[1, 0, 0], [0, 1, 0], [0, 0, 1]], "fy": 100, "fx": 100},
  {"id": 1, "img_name": "a", "width": 200, "height": 100, "position": [5.0, 0.0, 0.0],
   "rotation": [[0, 0, 1], [0, 1, 0], [-1, 0, 0]], "fy": 100.0, "fx": 100.0}
]"#;

#[test]
fn cameras_beside_gaussians_by_hand() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("cameras.json");
    let size = [200, 100];
    // With and without the mark of UTF-8, as a file and by its folder.
    for text in [TRAINED.to_owned(), format!("\u{feff}{TRAINED}")] {
        fs::write(&path, text).unwrap();
        let source = read(&path);
        assert_eq!((source.size(), source.warnings()), (Some(size), [].as_slice()));
        let keys = source.path(size);
        assert_eq!(keys.keys.len(), 2);
        // (2, 3, 13) lies 1 to the right, 1 below and 10 before the eye.
        assert_seen(&keys, 0, size, [2.0, 3.0, 13.0], [110.0, 60.0], 10.0);
        // (9, 0.5, −1) lies 4 before, 0.5 below and, as −z is to the right of +x where y is down, 1 to the right.
        assert_seen(&keys, 1, size, [9.0, 0.5, -1.0], [125.0, 62.5], 4.0);
        assert_eq!(read(folder.path()), source);
    }
    fs::write(&path, TRAINED.replacen("\"fx\": 100", "\"cx\": 97, \"cy\": 50, \"fx\": 101", 1)).unwrap();
    let said = read(&path).warnings().join("\n");
    assert!(said.contains("of 1 of 2 cameras the focal lengths") && said.contains("up to 3.0 pixels"), "{said}");
}

#[test]
fn damaged_lists_of_cameras_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("c.json");
    for (text, says) in [
        ("[]".to_owned(), "holds no cameras"),
        ("[{\"id\": 0}]".to_owned(), "camera [0]: width is missing; a cameras.json of 3D Gaussian Splatting has width"),
        ("[{\"id\": 0}, {\"id\": 0}, {\"id\": 0}]".to_owned(), "camera [0]: width is missing"),
        ("[3]".to_owned(), "c.json:1:2: invalid type"),
        (
            "[{\"file_path\": \"a\", \"transform\": [[1, 0, 0, 0]]}]".to_owned(),
            "camera [0]: this list of `ns-export cameras`",
        ),
        (TRAINED.replace("[5.0, 0.0, 0.0]", "[5.0, NaN, 0.0]"), "NaN is not a number of JSON"),
        (TRAINED.replace("[5.0, 0.0, 0.0]", "[1e300, 0, 0]"), "camera [1] (a): position"),
        (TRAINED.replace("[0, 1, 0], [-1", "[0, 1, 0], [1"), "camera [1] (a): rotation is none"),
        (TRAINED.replacen("200", "0", 1), "camera [0] (b): the picture's sides"),
        (TRAINED.replacen("\"fx\": 100", "\"fx\": 0", 1), "focal lengths"),
    ] {
        fs::write(&path, text).unwrap();
        refused(&path, says);
    }
}

#[test]
fn damaged_colmap_text_names_its_line() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    let said = |cameras: &str| {
        model(&folder, cameras);
        CameraSource::read(folder.path()).expect_err(cameras).to_string()
    };
    for (cameras, says) in [
        ("\n# x\n1 PINHOLE 200 100 100 100 100", "cameras.txt:3:1: PINHOLE has 4 parameters, not 3"),
        ("1 PINHOLE 200 100 100 100 100 nine", "\"nine\" is not a parameter"),
        ("1 PINHOLE 200 100 0 100 100 50", "focal lengths"),
        ("1 PINHOLE 200 100 NaN 100 100 50", "focal lengths"),
        ("1 PINHOLE 200 100 100 100 inf 50", "principal point"),
        ("1 PINHOLE 0 100 100 100 100 50", "sides"),
        ("1 HOLE 200 100 100 100 100 50", "unknown camera model HOLE; known: SIMPLE_PINHOLE"),
        ("-1 PINHOLE", "not a camera's number"),
        ("1", "model is missing"),
        ("1 PINHOLE 9 9 9 9 9 9\n1 PINHOLE 9 9 9 9 9 9", "cameras.txt:2:1: camera 1 occurs twice"),
        ("3 PINHOLE 200 100 100 100 100 50", "image a.jpg: its camera 1 is not among"),
        ("", "its camera 1"),
    ] {
        let message = said(cameras);
        assert!(message.contains(says), "{message} for {says}");
    }
    model(&folder, "1 PINHOLE 200 100 100 100 100 50");
    for (images, says) in [
        ("", "holds no images"),
        ("1 0 0 0 0 0 0 0 1 a", "image a: its pose"),
        ("1 1 0 0 0 0 0 1e300 1 a", "image a: its pose"),
        ("1 1 0 0 0 0 0 nan 1 a", "image a: its pose"),
        ("\n1 1 0 0 0 0 0 0 1", "images.txt:2:1: the image's name"),
        ("1 1 0 0", "QZ is missing"),
    ] {
        fs::write(path("images.txt"), images).unwrap();
        let message = CameraSource::read(folder.path()).expect_err(images).to_string();
        assert!(message.contains(says), "{message} for {says}");
    }
}

/// The model of [`IMAGES`] as binary files: cameras and images.
fn binary() -> [Vec<u8>; 2] {
    let mut cameras = [1u64.to_le_bytes().as_slice(), &1u32.to_le_bytes(), &1i32.to_le_bytes()].concat();
    cameras.extend([200u64, 100].iter().flat_map(|side| side.to_le_bytes()));
    cameras.extend([100.0f64, 100.0, 100.0, 50.0].iter().flat_map(|x| x.to_le_bytes()));
    let mut images = 2u64.to_le_bytes().to_vec();
    let half = 0.5f64.sqrt();
    for (id, pose, name, points) in [
        (2u32, [1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0], "b 1.jpg", 2u64),
        (7, [half, 0.0, half, 0.0, 1.0, 2.0, 3.0], "a.jpg", 0),
    ] {
        images.extend(id.to_le_bytes());
        images.extend(pose.iter().flat_map(|x: &f64| x.to_le_bytes()));
        images.extend(1u32.to_le_bytes());
        images.extend(name.bytes().chain([0]));
        images.extend(points.to_le_bytes());
        images.extend((0..24 * points).map(|i| i as u8));
    }
    [cameras, images]
}

#[test]
fn colmap_binary_by_hand_and_cut_anywhere() {
    let folder = tempfile::tempdir().unwrap();
    let names = ["cameras.bin", "images.bin"].map(|name| folder.path().join(name));
    let whole = binary();
    let write =
        |files: &[Vec<u8>; 2]| names.iter().zip(files).for_each(|(name, bytes)| fs::write(name, bytes).unwrap());
    write(&whole);
    assert_model(&read(folder.path()));
    assert_model(&read(&names[0]));
    // Where there are both, the binary files count.
    model(&folder, "damaged");
    assert_model(&read(folder.path()));
    for (i, name) in names.iter().enumerate() {
        for length in 0..whole[i].len() {
            let mut cut = whole.clone();
            cut[i].truncate(length);
            write(&cut);
            refused(name, "");
        }
        let mut many = whole.clone();
        many[i][..8].copy_from_slice(&u64::MAX.to_le_bytes());
        write(&many);
        assert!(CameraSource::read(folder.path()).unwrap_err().to_string().contains("too short"));
    }
    let mut points = whole.clone();
    let at = points[1].len() - 8;
    points[1][at..].copy_from_slice(&(u64::MAX / 2).to_le_bytes());
    write(&points);
    assert!(CameraSource::read(folder.path()).unwrap_err().to_string().contains("ends too early"));
    let mut unknown = whole.clone();
    unknown[0][12] = 200;
    write(&unknown);
    assert!(CameraSource::read(folder.path()).unwrap_err().to_string().contains("camera 1: unknown camera model 200"));
}

#[test]
fn missing_files_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let empty = CameraSource::read(folder.path()).unwrap_err();
    assert!(
        empty.exit_status() == 2 && empty.to_string().contains("neither a transforms.json nor a cameras.json"),
        "{empty}"
    );
    let missing = CameraSource::read(&folder.path().join("none.json")).unwrap_err();
    assert_eq!(missing.exit_status(), 1);
    fs::write(folder.path().join("latin.json"), b"\xff\xfe").unwrap();
    refused(&folder.path().join("latin.json"), "latin.json");
}
