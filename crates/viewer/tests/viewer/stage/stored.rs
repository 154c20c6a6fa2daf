//! Clouds that stay in their files: whole pictures have the bytes of those with all points in memory, drafts hold part
//! of the points, and what is stopped leaves no trace.

use std::sync::Arc;

use super::*;
use pellucid_engine::methods;
use pellucid_io::ply;
use pellucid_io::store::build::Settings;
use pellucid_io::store::{self, Store};
use pellucid_scene::{self as scene, procedural};
use pellucid_session::Silent;
use pellucid_viewer::messages::CloudShare;
use pellucid_viewer::statistics::Statistics;

const COUNT: usize = 90_000;

/// Setup with less memory than the cloud takes.
const LITTLE: Setup = Setup { memory_budget: Some(8 << 20), host_memory: 2 << 20, ..SETUP };

/// A landscape with radii and normals, and with trees.
fn landscape() -> Cloud {
    let made = procedural::build("terrain", &[("points".into(), COUNT as f64)], 3).unwrap();
    let scene = Document::from_toml(&made.scene_toml, Path::new("terrain"), &Overrides::default()).unwrap();
    let mut clouds = scene::take_generated(&scene.scene().unwrap(), &made).unwrap();
    assert_eq!(clouds.len(), 1);
    let mut cloud = clouds.remove(0);
    cloud.radii = Some(vec![0.4; cloud.len()]);
    cloud
}

/// The landscape as a file of these formats, and in memory.
struct Case {
    _folder: tempfile::TempDir,
    document: Document,
    stage: SceneRenderer,
    clouds: Vec<Cloud>,
}

impl Case {
    fn octree(device: &Device) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("store");
        let input = [Box::new(store::MemoryStore::new(Path::new("memory"), landscape()).unwrap()) as Box<dyn Store>];
        let settings = Settings { node_points: 1000, host_memory: 4 << 20 };
        let request = Request::default();
        prepare::store::prepare(&input, &path, &request, &settings, &Progress::hidden()).unwrap();
        Self::of(device, folder, &path)
    }

    fn file(device: &Device) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("scan.ply");
        ply::write(&path, &landscape()).unwrap();
        Self::of(device, folder, &path)
    }

    fn of(device: &Device, folder: tempfile::TempDir, path: &Path) -> Self {
        let mut named = scene::name(&[path.to_path_buf()], &Overrides::default(), SEED).unwrap();
        named.document.put("image.size", Setting::Integers(vec![243, 182])).unwrap();
        let (scene, hidden) = (named.document.scene().unwrap(), Progress::hidden());
        let open = |setup: Setup| Sources::open(&named.input, &scene, setup.limits(), &Silent, &hidden).unwrap();
        let sources = open(LITTLE);
        assert!(matches!(sources.clouds(), Clouds::Stored(_)));
        let stage = SceneRenderer::new(device, sources, &LITTLE).unwrap();
        let Clouds::Held(clouds) = open(SETUP).clouds().clone() else { panic!("there is memory enough") };
        let clouds = clouds.into_iter().map(Arc::unwrap_or_clone).collect();
        Self { _folder: folder, document: named.document, stage, clouds }
    }
}

fn pixels(taken: &TakenPicture) -> Vec<u32> {
    taken.rendered.image.rgba.iter().flatten().map(|value| value.to_bits()).collect()
}

#[test]
fn whole_pictures_have_the_bytes_of_those_in_memory() {
    with_device(|device| {
        let mut case = Case::octree(device);
        for (key, value) in [
            words("method.name", "points"),
            words("method.name", "circles"),
            number("cloud.0.opacity", 0.4),
            words("method.name", "sorted"),
            words("cloud.0.color_by", "height"),
            numbers("cloud.0.translate", [3.0, 0.0, 1.0]),
            words("method.name", "stochastic"),
            words("method.name", "spbr"),
        ] {
            let scene = case.document.set(&key, value).unwrap();
            let taken = case.stage.take(&scene, Pose::Scene, Effort::Whole).unwrap();
            let mut held = stage(device, case.clouds.clone());
            let expected = held.take(&scene, Pose::Scene, Effort::Whole).unwrap();
            assert_eq!(taken.frame.method, expected.frame.method, "{key}");
            assert!(taken.is_whole() && pixels(&taken) == pixels(&expected), "{key}");
            assert_eq!(
                taken.held,
                Some(CloudShare { points: COUNT as u64, all: COUNT as u64, is_fine: true }),
                "{key}"
            );
            assert_eq!(expected.held, None);
            let legend = (case.stage.legend(&scene).unwrap(), held.legend(&scene).unwrap());
            assert_eq!(legend.0, legend.1, "{key}");
        }
    });
}

#[test]
fn drafts_of_levels_hold_part_of_the_points() {
    with_device(|device| {
        let mut case = Case::octree(device);
        let scene = case.document.set("method.name", Setting::Word("circles".into())).unwrap();
        let first = case.stage.take(&scene, Pose::Scene, Effort::Moving(33.0)).unwrap();
        assert!(first.is_whole(), "of so few points");
        let whole = pixels(&first);
        let moving = draft(&mut case.stage, &scene, Effort::Moving, 0.1);
        let held = moving.held.unwrap();
        assert!(held.points <= 1 << 15 && held.points > 1000 && !held.is_fine, "{held:?}");
        assert!(!moving.is_whole() && moving.name().contains("points"), "{}", moving.name());
        // Pixels of a small picture are wider than points are apart.
        let small = case.document.set("image.size", Setting::Integers(vec![60, 45])).unwrap();
        let resting = draft(&mut case.stage, &small, Effort::Refining, 0.4);
        let finer = resting.held.unwrap();
        assert!(finer.is_fine && !resting.is_whole() && finer.points < finer.all, "{finer:?}");
        let again = case.stage.take(&scene, Pose::Scene, Effort::Whole).unwrap();
        assert!(pixels(&again) == whole, "drafts leave no trace");
    });
}

#[test]
fn drafts_without_levels_show_points_that_stand_for_all() {
    with_device(|device| {
        let mut case = Case::file(device);
        let scene = case.document.set("method.name", Setting::Word("circles".into())).unwrap();
        let whole = case.stage.take(&scene, Pose::Scene, Effort::Whole).unwrap();
        let draft = draft(&mut case.stage, &scene, Effort::Moving, 0.1);
        assert!(!draft.is_whole() && draft.held.unwrap().all == COUNT as u64);
        let expected = stage(device, case.clouds.clone()).take(&scene, Pose::Scene, Effort::Whole).unwrap();
        assert!(pixels(&whole) == pixels(&expected));
    });
}

#[test]
fn a_frame_stopped_while_nodes_are_read_leaves_no_trace() {
    with_device(|device| {
        let mut case = Case::octree(device);
        let scene = case.document.set("method.name", Setting::Word("sorted".into())).unwrap();
        device.allow_submissions(Some(0));
        let stopped = case.stage.take(&scene, Pose::Scene, Effort::Whole);
        device.allow_submissions(None);
        let Err(error) = stopped else { panic!("no submission was allowed") };
        assert!(
            matches!(error, pellucid_engine::Error::Render(methods::Error::Cancelled | methods::Error::Gpu(_))),
            "{error}"
        );
        let taken = case.stage.take(&scene, Pose::Scene, Effort::Whole).unwrap();
        let expected = stage(device, case.clouds.clone()).take(&scene, Pose::Scene, Effort::Whole).unwrap();
        assert!(pixels(&taken) == pixels(&expected));
    });
}

#[test]
fn statistics_of_a_store_are_those_of_points_that_stand_for_all() {
    with_device(|device| {
        let mut case = Case::octree(device);
        let before = Statistics::of_clouds(case.stage.clouds());
        assert_eq!((before[0].points, before[0].own_radii, before[0].classes.len()), (COUNT, true, 0));
        let scene = case.document.scene().unwrap();
        case.stage.take(&scene, Pose::Scene, Effort::Whole).unwrap();
        let held = Clouds::Held(case.clouds.into_iter().map(Arc::new).collect());
        let [found, expected] = [case.stage.clouds(), &held].map(Statistics::of_clouds);
        // So few points stand for themselves.
        assert_eq!(found[0].classes, expected[0].classes);
        assert_eq!((found[0].auto.clone(), found[0].normals), (expected[0].auto.clone(), expected[0].normals));
    });
}
