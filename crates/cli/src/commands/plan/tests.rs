//! The passes that a plan has on are those that run: by many of the roads that a frame may take, on one device.

use std::fs;
use std::path::Path;

use clap::Parser;
use glam::{DVec3, Vec3};
use pellucid_core::cloud::Cloud;
use pellucid_gpu::Device;
use pellucid_session::Session;
use pellucid_testing::with_device;
use tempfile::TempDir;

use super::PlanArgs;
use crate::commands::console::{Console, Streams};

#[derive(Parser)]
struct Line {
    #[command(flatten)]
    plan: PlanArgs,
}

/// Scenes in a folder, and the device that draws them.
struct Stage<'a> {
    device: &'a Device,
    folder: TempDir,
}

impl<'a> Stage<'a> {
    fn new(device: &'a Device) -> Self {
        Self { device, folder: tempfile::tempdir().unwrap() }
    }

    fn path(&self, name: &str) -> String {
        self.folder.path().join(name).to_str().unwrap().to_owned()
    }

    /// Writes a built-in scene; its scene file.
    fn builtin(&self, name: &str, parameters: &[&str]) -> String {
        let folder = self.path(name);
        let sets = parameters.iter().flat_map(|pair| ["--set", pair]);
        let args = ["pellucid", "scene", name, "-o", &folder].into_iter().chain(sets);
        crate::run_from(args.map(Into::into), Streams::Process);
        let file = format!("{folder}/scene.toml");
        assert!(Path::new(&file).exists());
        file
    }

    /// Writes `tori`, no larger than the budgets below need to cut it into regions; its scene file.
    fn tori(&self) -> String {
        let file = self.builtin("tori", &["points=2000"]);
        let text = fs::read_to_string(&file).unwrap();
        fs::write(&file, text.replace("[1024, 1024]", "[512, 512]")).unwrap();
        file
    }

    /// Points in a row across the view, of this radius.
    fn row(&self, count: usize, radius: f32) -> String {
        let cloud = Cloud {
            positions: (0..count).map(|i| DVec3::new(i as f64 * 0.01, 0.0, 0.0)).collect(),
            colors: Some(vec![Vec3::ONE; count]),
            radii: Some(vec![radius; count]),
            ..Cloud::default()
        };
        let file = self.path("row.ply");
        pellucid_io::ply::write(Path::new(&file), &cloud).unwrap();
        file
    }

    /// Asserts that a plan says of exactly the passes of a frame that they are on; the names of those.
    #[track_caller]
    fn planned(&self, args: &[&str]) -> Vec<&'static str> {
        let line = Line::try_parse_from([&["plan"], args].concat()).unwrap();
        let progress = Console::new(true, false, Streams::Process).progress();
        let prepared = line.plan.prepare(&progress).unwrap();
        let mut session = Session::open(self.device, prepared, &progress, &progress).unwrap();
        let steps = session.plan().unwrap();
        assert!(steps.iter().all(|step| !step.reason.is_empty()), "{args:?}: {steps:?}");
        let on: Vec<&'static str> = steps.iter().filter(|step| step.on).map(|step| step.name).collect();
        // As `profile` has it: methods that have no use for the lengths of lists don't count them.
        session.frame.fragments &= !session.frame.counts_on_demand();
        let profile = session.render().unwrap().profile;
        let ran: Vec<&'static str> = profile.passes.iter().map(|pass| pass.name).collect();
        assert_eq!(sorted(&on), sorted(&ran), "{args:?}: what the plan has on, and what ran");
        on
    }
}

fn sorted<'a>(names: &[&'a str]) -> Vec<&'a str> {
    let mut names = names.to_vec();
    names.sort_unstable();
    names
}

fn has(passes: &[&str], name: &str) -> bool {
    passes.contains(&name)
}

#[test]
fn lists_and_layers_are_planned_as_they_run() {
    with_device(|device| {
        let stage = Stage::new(device);
        let tori = stage.tori();
        let stack = stage.builtin("stack", &["layers=300", "size=8"]);
        let short = stage.planned(&[&tori, "--size", "40x30"]);
        assert!(has(&short, "abuffer/resolve-8") && !has(&short, "abuffer/merge") && !has(&short, "opaque/resolve"));
        let long = stage.planned(&[&stack]);
        assert!(has(&long, "abuffer/resolve-ordered") && !has(&long, "abuffer/merge"), "large flat discs: {long:?}");
        let linked = stage.planned(&[&stack, "--method", "linked-list"]);
        assert!(has(&linked, "abuffer/merge") && has(&linked, "abuffer/combine"), "lists of 300: {linked:?}");
        // Prefix sums of a single run, of exactly one run, and of a little more.
        for size in ["1x1", "8x8", "13x5"] {
            stage.planned(&[&tori, "--size", size]);
        }
        let linked = stage.planned(&[&tori, "--size", "40x30", "--method", "linked-list"]);
        assert!(has(&linked, "linked-list/gather") && !has(&linked, "abuffer/store"), "{linked:?}");
        for method in ["abuffer", "linked-list"] {
            let in_place = stage.planned(&[&stack, "--method", method, "--set", "method.long_lists=in-place"]);
            assert!(has(&in_place, "abuffer/merge-in-place") && !has(&in_place, "abuffer/merge"), "{in_place:?}");
        }
        // Splats of more than 1024 pixels, few and many, transparent and not.
        for count in [3, 200] {
            let row = stage.row(count, 1.0);
            for opacity in ["0.5", "1"] {
                stage.planned(&[&row, "--size", "64x64", "--opacity", opacity]);
            }
        }
        // Layers: all of them and one, short and long lists, large splats and small ones.
        let row = stage.row(200, 1.0);
        let peel = ["--method", "peel", "--size", "40x30"];
        for layers in ["method.layers=0", "method.layers=1"] {
            for input in [&tori, &row] {
                let peeled = stage.planned(&[&[input, "--opacity", "0.5", "--set", layers], &peel[..]].concat());
                assert!(has(&peeled, "peel/blend") && has(&peeled, "peel/count"), "{peeled:?}");
                assert!(
                    !has(&peeled, "opaque/resolve") && !peeled.iter().any(|pass| pass.starts_with("abuffer")),
                    "{peeled:?}"
                );
            }
        }
    });
}

#[test]
fn what_the_rasterizer_draws_is_planned_as_it_runs() {
    with_device(|device| {
        let stage = Stage::new(device);
        let (tori, row) = (stage.tori(), stage.row(200, 1.0));
        // Large splats drawn by the rasterizer need no tiles.
        if device.info().fragment_atomics {
            let hardware = ["--method", "abuffer", "--set", "method.raster=hardware"];
            stage.planned(&[&[row.as_str(), "--size", "7x9", "--opacity", "0.5"], &hardware[..]].concat());
        }
        if device.info().multisampled.is_some() && device.info().fragment_atomics {
            let samples = ["--method", "stochastic", "--set", "method.raster=hardware", "--set", "method.samples=6"];
            for more in [&[row.as_str()][..], &[row.as_str(), "--set", "method.alpha_correction=false"], &[&tori]] {
                let drawn = stage.planned(&[&["--size", "40x30"], more, &samples[..]].concat());
                assert!(has(&drawn, "stochastic/draw-sums") && !has(&drawn, "stochastic/accumulate"), "{drawn:?}");
                assert_eq!(has(&drawn, "stochastic/draw-alpha"), !more.iter().any(|arg| arg.ends_with("false")));
            }
        }
    });
}

#[test]
fn tiles_of_splats_are_planned_as_they_run() {
    with_device(|device| {
        let stage = Stage::new(device);
        let tori = stage.tori();
        let (stack, row) = (stage.builtin("stack", &["layers=300", "size=8"]), stage.row(200, 1.0));
        let sorted = stage.planned(&[&tori, "--size", "40x30", "--method", "sorted"]);
        assert!(
            has(&sorted, "radix/scatter") && has(&sorted, "sorted/blend") && !has(&sorted, "abuffer/count"),
            "{sorted:?}"
        );
        let sampled = ["--method", "stochastic", "--set", "method.samples=20"];
        let sampled = stage.planned(&[&[tori.as_str(), "--size", "40x30"], &sampled[..]].concat());
        assert!(has(&sampled, "stochastic/gather") && !has(&sampled, "sorted/blend"), "{sampled:?}");
        // Sums of one run and of more, several regions, large splats that need no lists of tiles, and a deep stack.
        for args in [[&row, "--size", "7x9"], [&tori, "--memory-budget", "400KiB"], [&stack, "--size", "8x8"]] {
            for opacity in ["0.5", "1"] {
                stage.planned(&[&args[..], &["--opacity", opacity, "--method", "sorted"]].concat());
            }
        }
        for method in ["hybrid", "mlab", "moments", "wavelet", "weighted", "average", "unsorted"] {
            let accumulate = format!("{method}/accumulate");
            for (args, more) in [
                ([&tori, "--size", "40x30"], &["--set", "method.shape=oriented"][..]),
                ([&tori, "--memory-budget", "400KiB"], &[]),
                ([&stack, "--size", "8x8"], &["--set", "method.falloff=gaussian"]),
            ] {
                let planned = stage.planned(&[&args[..], &["--method", method], more].concat());
                assert!(has(&planned, &accumulate) && !has(&planned, "sorted/blend"), "{planned:?}");
            }
        }
        // Opaque splats in three passes: of one region and of several, large and small.
        for method in ["hqs", "splats"] {
            for args in [[&row, "--size", "7x9"], [&tori, "--memory-budget", "400KiB"], [&tori, "--size", "40x30"]] {
                let planned = stage.planned(&[&args[..], &["--method", method]].concat());
                assert!(has(&planned, "splats/normalize") && !has(&planned, "opaque/nearest"), "{planned:?}");
            }
        }
    });
}

#[test]
fn soft_points_and_layers_of_them_are_planned_as_they_run() {
    with_device(|device| {
        let stage = Stage::new(device);
        let tori = stage.tori();
        // Spheres alone, before solid points, without any; one kernel and several, long lists, regions.
        let axis = "cloud.0.field=distance-to-axis";
        for (method, threshold) in
            [("soft-base", "0"), ("soft-base", "0.4"), ("soft-concentric", "0.4"), ("soft-base", "1")]
        {
            let threshold = format!("method.threshold={threshold}");
            let soft = ["--method", method, "--set", axis, "--set", &threshold];
            for args in [&[][..], &["--memory-budget", "400KiB"], &["--radius", "0.4"]] {
                let planned = stage.planned(&[&[tori.as_str(), "--size", "40x30"], args, &soft[..]].concat());
                let spheres = threshold != "method.threshold=1";
                assert_eq!(has(&planned, "soft/count") && has(&planned, "soft/store"), spheres, "{planned:?}");
                assert_eq!(has(&planned, "soft/compose"), has(&planned, "splats/normalize"), "{planned:?}");
            }
        }
        // Long lists of events, merged and in place.
        let crowd = stage.builtin("spheres", &["count=8000"]);
        for (way, pass) in [("merge", "abuffer/merge"), ("in-place", "abuffer/merge-in-place")] {
            let way = format!("method.long_lists={way}");
            for method in ["soft-base", "soft-concentric"] {
                let planned = stage.planned(&[&crowd, "--size", "24x24", "--method", method, "--set", &way]);
                let merges: Vec<_> = planned.into_iter().filter(|name| name.starts_with("abuffer/merge")).collect();
                assert_eq!(merges, [pass], "{method}");
            }
        }
        // Soft discs before solid points: with many of either, with few, and in several regions.
        for args in [&["--size", "40x30"][..], &["--size", "1024x1024", "--memory-budget", "800KiB"]] {
            for (threshold, seen) in [("0", true), ("0.5", true), ("1", false)] {
                let threshold = format!("method.threshold={threshold}");
                let method = ["--method", "soft-express", "--set", &threshold];
                let planned = stage.planned(&[&[tori.as_str()], args, &method[..]].concat());
                assert!(has(&planned, "splats/normalize") && has(&planned, "soft/compose"), "{planned:?}");
                let presorted = ["bin/pick", "bin/place", "soft/express"].iter().filter(|name| has(&planned, name));
                assert_eq!(presorted.count(), if seen { 3 } else { 0 }, "{threshold}: {planned:?}");
            }
        }
        // One layer of soft points, and none.
        for (threshold, layered) in [("0.5", true), ("1", false)] {
            let threshold = format!("method.threshold={threshold}");
            let planned = stage.planned(&[&tori, "--size", "40x30", "--method", "one-layer", "--set", &threshold]);
            assert!(has(&planned, "splats/attributes") && has(&planned, "one-layer/compose") == layered, "{planned:?}");
        }
    });
}

#[test]
fn a_view_of_nothing_is_planned_as_it_runs() {
    with_device(|device| {
        let stage = Stage::new(device);
        stage.row(200, 1.0);
        let scene = "[camera]\neye = [0, 0, 5]\ntarget = [0, 0, 9]\n[[cloud]]\npath = \"row.ply\"\n";
        let away = stage.path("away.toml");
        fs::write(&away, scene).unwrap();
        let away = |more: &[&str]| stage.planned(&[&[away.as_str(), "--size", "40x30"], more].concat());
        for opacity in ["0.5", "1"] {
            away(&["--opacity", opacity]);
        }
        for method in [
            "points",
            "peel",
            "hybrid",
            "mlab",
            "moments",
            "wavelet",
            "weighted",
            "average",
            "unsorted",
            "hqs",
            "splats",
            "one-layer",
            "soft-express",
        ] {
            away(&["--method", method]);
        }
        let sorted = away(&["--method", "sorted"]);
        assert!(!sorted.iter().any(|pass| pass.starts_with("radix/") || pass.starts_with("sorted/")), "{sorted:?}");
        assert!(has(&sorted, "image/clear"), "{sorted:?}");
    });
}

#[test]
fn points_are_planned_without_splats() {
    with_device(|device| {
        let stage = Stage::new(device);
        let tori = stage.tori();
        let opaque = stage.planned(&[&tori, "--size", "40x30", "--method", "points"]);
        assert!(has(&opaque, "points/resolve") && !has(&opaque, "project/splats"), "{opaque:?}");
        assert!(!opaque.iter().any(|pass| pass.starts_with("abuffer")), "{opaque:?}");
    });
}
