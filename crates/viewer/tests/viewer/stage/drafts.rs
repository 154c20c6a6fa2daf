//! Drafts show what the whole picture shows, where it shows it; and the whole picture does not depend on them.

use super::*;
use pellucid_core::metrics;
use pellucid_scene::{procedural, take_generated};
use pellucid_viewer::display::SceneImage;

const SIZE: [u32; 2] = [243, 182];

/// A small garden in the method's picture.
fn garden(device: &Device) -> (SceneRenderer, Document) {
    let made = procedural::build("garden", &[("points".into(), 20_000.0)], 3).unwrap();
    let mut document = Document::from_toml(&made.scene_toml, Path::new("garden"), &Overrides::default());
    let document = document.as_mut().unwrap();
    document.put("image.size", Setting::Integers(SIZE.to_vec())).unwrap();
    document.put("method.ensembles", Setting::Integer(40)).unwrap();
    document.put("method.samples", Setting::Integer(32)).unwrap();
    let clouds = take_generated(&document.scene().unwrap(), &made).unwrap();
    (stage(device, clouds), document.clone())
}

/// The pixels of a picture, of the last one if its colors are on the device.
fn composed(stage: &SceneRenderer, taken: &TakenPicture, scene: &Scene) -> Vec<[f32; 3]> {
    let image = &taken.rendered.image;
    let rgba = match image.has_colors() {
        true => image.rgba.clone(),
        false => stage.renderer().read_colors().unwrap().expect("they are where they were found"),
    };
    SceneImage { size: [image.width, image.height], scene }.composed(&rgba)
}

/// Each pixel the mean of 9 × 9, at the border of fewer: single points are left out of drafts, and samples, by chance.
fn blurred(pixels: &[[f32; 3]]) -> Vec<[f32; 3]> {
    let [width, height] = SIZE.map(i64::from);
    let mean = |x: i64, y: i64| {
        let rows = (y - 4).max(0)..(y + 5).min(height);
        let of_row = |y: i64| ((x - 4).max(0)..(x + 5).min(width)).map(move |x| (x, y));
        let around: Vec<_> = rows.flat_map(of_row).map(|(x, y)| pixels[(y * width + x) as usize]).collect();
        [0, 1, 2].map(|i| around.iter().map(|pixel| pixel[i]).sum::<f32>() / around.len() as f32)
    };
    (0..width * height).map(|i| mean(i % width, i / width)).collect()
}

/// Root mean square difference over the common pixels, with the second picture shifted by `dx`, `dy` pixels.
fn apart(a: &[[f32; 3]], b: &[[f32; 3]], [dx, dy]: [i64; 2]) -> f64 {
    let [width, height] = SIZE.map(i64::from);
    let border = 16;
    let inside = (border..height - border).flat_map(|y| (border..width - border).map(move |x| (x, y)));
    let at = |pixels: &[[f32; 3]], x: i64, y: i64| pixels[(y * width + x) as usize];
    let (a, b): (Vec<_>, Vec<_>) = inside.map(|(x, y)| (at(a, x, y), at(b, x + dx, y + dy))).unzip();
    metrics::rmse(&a, &b)
}

#[test]
fn drafts_lie_where_the_whole_picture_does() {
    with_device(|device| {
        let (mut stage, mut document) = garden(device);
        document.put("shading.model", Setting::Word("none".into())).unwrap();
        // The least share of the work, and the drafts it yields.
        let of_pixels =
            [(0.25, "2 × 2 pixels as one", 2), (0.12, "3 × 3 pixels as one", 3), (0.07, "4 × 4 pixels as one", 4)];
        // Discs that face the camera at one depth cover what is farther, in a garden seen from above by up to their
        // radius above them: larger ones more of it.
        let of_screen_aligned = [of_pixels[0], of_pixels[1]];
        let of_samples = [(0.5, "16 samples", 1), (0.032, "4 samples, 2 × 2 pixels as one", 2)];
        let of_ensembles = [(0.5, "20 ensembles", 1), (0.026, "4 ensembles, 2 × 2 pixels as one", 2)];
        type Case<'a> = (&'a str, &'a [(f64, &'a str, i64)]);
        let cases: [Case<'_>; 7] = [
            ("abuffer", &of_pixels),
            ("circles", &of_screen_aligned),
            ("points", &of_pixels),
            ("hqs", &of_screen_aligned),
            ("soft-express", &of_pixels),
            ("stochastic", &of_samples),
            ("spbr", &of_ensembles),
        ];
        let mut wrong = Vec::new();
        for (method, drafts) in cases {
            if method == "spbr" {
                // Little opacity, so that enough points remain on the smallest pixels; larger ones hold more.
                document.put("cloud.*.opacity", Setting::Number(0.2)).unwrap();
            }
            let scene = document.set("method.name", Setting::Word(method.into())).unwrap();
            let whole = stage.take(&scene, Pose::Scene, Effort::Whole).unwrap();
            assert!(whole.is_whole() && whole.name() == "whole" || whole.draft.steps.is_some(), "{method}");
            let picture = blurred(&composed(&stage, &whole, &scene));
            let background = vec![scene.image.background.color().to_array(); picture.len()];
            for (work, name, step) in drafts {
                let what = format!("{method}, {name}");
                let taken = draft(&mut stage, &scene, Effort::Moving, *work);
                assert_eq!((taken.name().as_str(), taken.is_whole()), (*name, false), "{what}");
                let pixels = blurred(&composed(&stage, &taken, &scene));
                let here = apart(&picture, &pixels, [0, 0]);
                let nothing = apart(&picture, &background, [0, 0]);
                if here >= 0.7 * nothing {
                    wrong.push(format!("{what}: {here}, and {nothing} without any draft"));
                }
                for aside in [[1, 0], [-1, 0], [0, 1], [0, -1]] {
                    let there = apart(&picture, &pixels, aside.map(|x| x * 2 * step));
                    if here >= there {
                        wrong.push(format!("{what}: {here} here, {there} if moved by {aside:?}"));
                    }
                }
                assert!(
                    taken.rendered.facts.points < whole.rendered.facts.points || *step == 1 || method == "spbr",
                    "{what}"
                );
            }
            let again = stage.take(&scene, Pose::Scene, Effort::Whole).unwrap();
            assert_same(&again, &whole, method);
        }
        assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    });
}

#[test]
fn finer_drafts_are_closer_to_the_whole_picture() {
    with_device(|device| {
        let (mut stage, mut document) = garden(device);
        let scene = document.set("method.name", Setting::Word("abuffer".into())).unwrap();
        let whole = stage.take(&scene, Pose::Scene, Effort::Whole).unwrap();
        let picture = composed(&stage, &whole, &scene);
        let shares = [0.016, 0.028, 0.0625, 0.12, 0.25, 1.0];
        let errors = shares.map(|work| {
            let taken = draft(&mut stage, &scene, Effort::Moving, work);
            assert!(!taken.rendered.image.has_colors(), "they stay on the device");
            apart(&picture, &composed(&stage, &taken, &scene), [0, 0])
        });
        assert!(errors.is_sorted_by(|coarse, fine| coarse > fine), "{errors:?}");
        assert_eq!(errors[5], 0.0);
    });
}

#[test]
fn a_picture_at_rest_is_whole_once_half_of_its_work_fits() {
    with_device(|device| {
        let (mut stage, mut document) = garden(device);
        let scene = document.set("method.name", Setting::Word("stochastic".into())).unwrap();
        let mut refined = |work: f64| draft(&mut stage, &scene, Effort::Refining, work);
        assert_eq!(refined(0.4).name(), "12 samples");
        let whole = refined(0.5);
        assert!(whole.is_whole() && whole.draft.steps == Some(32));
        assert!(whole.rendered.image.standard_error().is_some_and(|error| error > 0.0 && error < 0.1));
    });
}

#[test]
fn lights_of_an_area_come_one_by_one() {
    with_device(|device| {
        let clouds = clouds();
        let mut stage = stage(device, clouds.clone());
        let mut document = document();
        for (key, value) in [("shadows.samples", Setting::Integer(10)), ("shadows.light_radius", Setting::Number(5.0))]
        {
            document.put(key, value).unwrap();
        }
        let scene = document.set("method.name", Setting::Word("points".into())).unwrap();
        let mut lights = |effort| {
            let taken = stage.take(&scene, Pose::Scene, effort).unwrap();
            (taken.lights, taken.is_whole())
        };
        assert_eq!(lights(Effort::Moving(1e9)), (Some([1, 10]), false));
        assert_eq!(lights(Effort::Moving(1e9)), (Some([1, 10]), false));
        assert_eq!(lights(Effort::Refining(1e9)), (Some([4, 10]), false));
        assert_eq!(lights(Effort::Moving(1e9)), (Some([4, 10]), false), "what is there stays");
        assert_eq!(lights(Effort::Refining(1e9)), (Some([10, 10]), true));
        assert_eq!(lights(Effort::Moving(1e9)), (Some([10, 10]), true));
        let live = stage.take(&scene, Pose::Scene, Effort::Whole).unwrap();
        let mut other = self::stage(device, clouds.clone());
        assert_same(&live, &fresh(&mut other, device, &clouds, &scene), "after fewer lights");
        // Another light restarts the refinement.
        let moved = document.set("shading.light", Setting::Numbers(vec![-0.5, -1.0, -0.5])).unwrap();
        let taken = stage.take(&moved, Pose::Scene, Effort::Moving(1e9)).unwrap();
        assert_eq!(taken.lights, Some([1, 10]));
    });
}

#[test]
fn the_area_of_a_pixel_is_for_pictures_at_rest() {
    with_device(|device| {
        let clouds = clouds();
        let mut stage = stage(device, clouds.clone());
        let mut document = document();
        document.put("image.samples", Setting::Integer(4)).unwrap();
        let scene = document.set("method.name", Setting::Word("points".into())).unwrap();
        for effort in [Effort::Moving(1e9), Effort::Refining(1e9)] {
            let taken = stage.take(&scene, Pose::Scene, effort).unwrap();
            assert_eq!((taken.frame.samples, taken.is_whole(), taken.lacks_samples()), (1, false, true));
            assert_eq!(taken.name(), "whole, 1 sample per pixel");
        }
        let live = stage.take(&scene, Pose::Scene, Effort::Whole).unwrap();
        assert_eq!((live.frame.samples, live.is_whole(), live.lacks_samples()), (4, true, false));
        assert_eq!(live.name(), "whole, 4 samples per pixel");
        let mut other = self::stage(device, clouds.clone());
        assert_same(&live, &fresh(&mut other, device, &clouds, &scene), "after drafts");
        // As many as it takes, down to none that differ: 64.
        document.put("image.samples", Setting::Word("auto".into())).unwrap();
        let scene = document.set("image.sampling_error", Setting::Number(1e-9)).unwrap();
        let settled = stage.take(&scene, Pose::Scene, Effort::Whole).unwrap();
        assert_eq!((settled.frame.samples, settled.rendered.image.samples, settled.is_whole()), (64, 64, true));
        let options = stage.write_options("scene".to_owned(), None).unwrap();
        let samples = options.metadata.iter().find(|(key, _)| key == "pellucid:samples").map(|(_, value)| value);
        assert!(samples.is_some_and(|text| text.contains("\"samples\":64")), "{samples:?}");
    });
}
