//! Cancelled work, the examples, and the size of the surface.

mod cancelled;
mod samples;

use std::path::Path;

use pellucid_testing::skip::{NO_DEVICE, skip};

#[path = "../examples/camera_path.rs"]
mod camera_path;
#[path = "../examples/moving_camera.rs"]
mod moving_camera;
#[path = "../examples/quick_start.rs"]
mod quick_start;
#[path = "../examples/read_profile.rs"]
mod read_profile;
#[path = "../examples/render_file.rs"]
mod render_file;

/// Runs an example's `main`.
#[track_caller]
fn run(example: fn() -> crate::Result<()>) {
    match crate::devices() {
        Ok(devices) if !devices.is_empty() => example().expect("the example runs"),
        Ok(_) => skip(NO_DEVICE, "none was found"),
        Err(error) => skip(NO_DEVICE, &error.to_string()),
    }
}

#[test]
fn a_file_is_rendered() {
    run(render_file::main);
}

#[test]
fn a_file_becomes_a_picture_in_ten_lines() {
    run(quick_start::main);
}

#[test]
fn a_camera_moves() {
    run(moving_camera::main);
}

#[test]
fn a_profile_is_read() {
    run(read_profile::main);
}

#[test]
fn a_camera_follows_a_path() {
    run(camera_path::main);
}

#[test]
fn passes_are_timed_where_asked_for() {
    run(|| {
        let cloud = crate::Cloud::from_positions([[0.0; 3], [1.0; 3]]).radius(1.0).opacity(0.5).build()?;
        let mut scene = crate::Scene::from_clouds([cloud])?;
        scene.set("image.size", [16, 16])?;
        let mut loaded = crate::Renderer::open()?.load(&scene)?;
        for timed in [false, true, false] {
            let builder = loaded.frame().method(crate::Method::ABuffer);
            let picture = if timed { builder.timed() } else { builder }.render()?;
            let profile = picture.profile();
            assert_eq!(profile.passes().iter().any(|pass| pass.name == "abuffer/store"), timed);
            assert_eq!(profile.passes().is_empty(), !timed);
            assert!(!profile.device_time().is_zero(), "the whole frame is timed in any case");
        }
        Ok(())
    });
}

#[test]
fn the_methods_are_those_of_a_scene_file() {
    let mut names: Vec<_> = crate::Method::ALL.iter().map(|method| method.name()).collect();
    let mut known = pellucid_scene::METHODS.to_vec();
    names.sort_unstable();
    known.sort_unstable();
    assert_eq!(names, known);
}

/// Every example is among the tests above.
#[test]
fn all_examples_run() {
    let here = include_str!("tests.rs");
    for entry in std::fs::read_dir(Path::new(env!("CARGO_MANIFEST_DIR")).join("examples")).unwrap() {
        let path = entry.unwrap().path();
        let stem = path.file_stem().unwrap().to_str().unwrap().to_owned();
        assert!(here.contains(&format!("run({stem}::main)")), "{} is not run", path.display());
    }
}

/// Counts the lines that make an item public to other crates: functions, types, fields and re-exports.
fn public_items(source: &str) -> usize {
    let items = source.lines().map(str::trim_start).filter(|line| line.starts_with("pub "));
    items.map(|line| if line.starts_with("pub use") { line.matches(',').count() + 1 } else { 1 }).sum()
}

#[test]
fn the_surface_has_at_most_170_items() {
    let mut count = 0;
    for entry in std::fs::read_dir(Path::new(env!("CARGO_MANIFEST_DIR")).join("src")).unwrap() {
        let path = entry.unwrap().path();
        if path.is_file() {
            count += public_items(&std::fs::read_to_string(path).unwrap());
        }
    }
    assert!((50..=170).contains(&count), "{count}");
    assert_eq!(
        public_items("pub struct A {\n    pub b: u8,\n    c: u8,\n}\npub(crate) fn d() {}\npub use e::{F, G};"),
        4
    );
}
