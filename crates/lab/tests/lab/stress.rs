//! `stress`: errors of all methods on layers, against what their equations give in float64.

use pellucid_core::camera::Camera;
use pellucid_core::points::Points;
use pellucid_core::progress::Progress;
use pellucid_engine::methods::Frame;
use pellucid_lab::report::stress::{self, Cell, Entry, Expected, Settings, Sweep, Workload};
use pellucid_reference::approximate;
use pellucid_reference::shading::shade;
use pellucid_reference::soft::{Behind, Model, Scene as SoftScene};
use pellucid_reference::{ReferencePicture, View, abuffer};
use pellucid_scene::{self as scene, Density, Discs, Method, Scene, Soft, SoftMethod, procedural};
use pellucid_testing::with_device;

const SIDE: u32 = 16;
const LAYERS: [u32; 3] = [1, 12, 40];
const SEED: u64 = 3;

fn sweep(device: &pellucid_gpu::Device) -> Sweep {
    let settings = Settings {
        sides: vec![SIDE],
        layers: LAYERS.into(),
        frames: 1,
        max_seconds: 100.0,
        seed: SEED,
        ..Settings::quick(Entry::all())
    };
    stress::run(device, &settings, &Progress::hidden()).unwrap()
}

fn opacity(layers: u32) -> f64 {
    1.0 - 0.5f64.powf(1.0 / f64::from(layers))
}

/// The layers of a cell and their camera, as the report describes them.
fn layers(cell: &Cell, is_soft: bool) -> (Points, Camera) {
    let parameters = [("layers", cell.layers.into()), ("size", SIDE.into()), ("opacity", opacity(cell.layers))];
    let parameters = parameters.map(|(key, value): (&str, f64)| (key.to_owned(), value));
    let made = procedural::build(cell.workload.name(), &parameters, SEED).unwrap();
    let scene = Scene::from_toml(&made.scene_toml, "layers".as_ref()).unwrap();
    let clouds = scene::take_generated(&scene, &made).unwrap();
    let up = scene::up_axis(&clouds);
    let mut points = scene::assemble(&scene, clouds, true, &Progress::hidden()).unwrap();
    let (mut camera, _) = scene::camera(&scene, &points, up).unwrap();
    if is_soft {
        points.fields = vec![1.0; points.len()];
        camera.eye -= 2.0 * camera.forward;
        camera.far += 2.0;
    }
    (points, camera)
}

/// Pictures of an approximation and of the exact method, in float64.
fn both(cell: &Cell, entry: &Entry) -> [ReferencePicture; 2] {
    let (points, camera) = layers(cell, entry.method.as_soft().is_some());
    let view = View::new(&camera, [SIDE; 2]);
    let frame = Frame::new(camera, [SIDE; 2], entry.method);
    let colors = shade(&points, &camera, &frame.shading, frame.color);
    let Some(soft) = entry.method.as_soft() else {
        let own = approximate::render(view, &points, &colors, &entry.method).expect("an approximation");
        return [own, abuffer::render(view, &points, &colors, &Discs::default())];
    };
    let density = Density::Softness(opacity(cell.layers) as f32);
    let render = |method: SoftMethod| {
        let model = Model::new(method.changed(|soft| soft.density = density), &points);
        SoftScene { view, points: &points, colors: &colors, model }.render(|_| Behind::NOTHING)
    };
    [render(soft), render(SoftMethod::Base(Soft::default()))]
}

/// Largest difference of R, G, B and A, and RMSE of R, G and B.
fn apart([a, b]: &[ReferencePicture; 2]) -> (f64, f64) {
    let (mut max, mut squares) = (0f64, 0f64);
    for (a, b) in a.rgba.iter().zip(&b.rgba) {
        let differences: [f64; 4] = std::array::from_fn(|channel| (a[channel] - b[channel]).abs());
        max = differences.into_iter().fold(max, f64::max);
        squares += differences[..3].iter().map(|d| d * d).sum::<f64>();
    }
    (max, (squares / (3 * a.rgba.len()) as f64).sqrt())
}

#[test]
fn each_method_has_the_error_that_its_equations_have() {
    with_device(|device| {
        let sweep = sweep(device);
        let cells = Workload::ALL.len() * LAYERS.len() * Entry::all().len();
        assert_eq!(sweep.cells.len() + sweep.skipped.len(), cells);
        for cell in &sweep.cells {
            assert_eq!(cell.error.pixels, (SIDE * SIDE) as usize, "all pixels of this image");
            let entry = *Entry::all().iter().find(|entry| entry.name == cell.method).unwrap();
            match cell.expected {
                Expected::Exact(_) => assert_eq!(cell.holds(), Some(true), "{cell:?}"),
                Expected::Noise(_) => assert_noise(cell),
                Expected::Stated => {
                    let (max, rmse) = apart(&both(cell, &entry));
                    let off = (cell.error.max - max).abs().max((cell.error.rmse - rmse).abs());
                    assert!(off <= 1e-4, "{}, {} layers: {:?} for {max} {rmse}", entry.name, cell.layers, cell.error);
                }
            }
        }
        // Mean colors and wrong orders are far off, so that equal errors say something.
        for name in ["average", "unsorted", "weighted", "soft-express"] {
            let least = sweep.cells.iter().filter(|cell| cell.method == name && cell.layers == 40);
            assert!(least.map(|cell| cell.error.rmse).fold(1.0, f64::min) > 1e-3, "{name}");
        }
    });
}

/// The noise is as large as it is said to be: RMS of 256 pixels, whose ratio is known to 1/√512, or twice that since
/// standard errors are estimates.
fn assert_noise(cell: &Cell) {
    assert_eq!(cell.holds(), Some(true), "{cell:?}");
    let ratio = cell.error.standard_errors.unwrap();
    // A layer alone has no noise, since its color is scaled to the exact opacity.
    let least = if cell.layers == 1 { 0.0 } else { 1.0 - 6.0 / 16.0 };
    assert!(ratio >= least, "{cell:?}");
}

/// RMSE of R, G and B between the exact picture of a scene and the mean of so many, each moved by a part of a pixel, in
/// float64.
fn sampling_error(cell: &Cell, samples: u32) -> f64 {
    let (points, camera) = layers(cell, false);
    let frame = Frame { samples, ..Frame::new(camera, [SIDE; 2], Method::ABuffer(Discs::default())) };
    let colors = shade(&points, &camera, &frame.shading, frame.color);
    let picture =
        |frame: &Frame| abuffer::render(View::new(&frame.camera, [SIDE; 2]), &points, &colors, &Discs::default());
    let mut mean = picture(&frame);
    let images: Vec<ReferencePicture> = (0..samples).map(|index| picture(&frame.image(index))).collect();
    for (at, pixel) in mean.rgba.iter_mut().enumerate() {
        let sum = |channel: usize| images.iter().map(|image| image.rgba[at][channel]).sum::<f64>();
        *pixel = std::array::from_fn(|channel| sum(channel) / f64::from(samples));
    }
    apart(&[picture(&frame), mean]).1
}

#[test]
fn layers_without_edges_have_no_sampling_error_and_tiles_have_that_of_their_rims() {
    with_device(|device| {
        let sweep = sweep(device);
        let areas = sweep.areas.iter().filter(|area| area.error.method == "abuffer");
        let mut seen = 0;
        for area in areas {
            let cell = sweep
                .cells
                .iter()
                .find(|cell| (cell.workload, cell.layers, cell.method) == (area.workload, area.layers, "abuffer"));
            let expected = sampling_error(cell.unwrap(), area.error.against);
            assert!((area.error.rmse - expected).abs() < 1e-5, "{area:?} for {expected}");
            match area.workload {
                Workload::Stack => assert!(area.error.rmse < 1e-6, "{area:?}"),
                Workload::Mosaic => assert!(area.error.rmse > 1e-3, "{area:?}"),
            }
            seen += 1;
        }
        assert_eq!(seen, Workload::ALL.len() * LAYERS.len());
    });
}

#[test]
fn a_wrong_picture_does_not_hold() {
    with_device(|device| {
        // One layer of several is left out: each of 8 holds 8% of the light.
        let entry = *Entry::all().iter().find(|entry| matches!(entry.method, Method::Peel(_))).unwrap();
        let settings = Settings {
            sides: vec![SIDE],
            layers: vec![8],
            frames: 1,
            max_seconds: 100.0,
            ..Settings::quick(vec![entry])
        };
        let right = stress::run(device, &settings, &Progress::hidden()).unwrap();
        assert!(right.cells.iter().all(|cell| cell.holds() == Some(true)), "{right:?}");
        let Method::Peel(peel) = entry.method else { unreachable!() };
        let wrong = Entry { method: Method::Peel(pellucid_scene::Peel { layers: 7, ..peel }), ..entry };
        let found = stress::run(device, &Settings { entries: vec![wrong], ..settings }, &Progress::hidden()).unwrap();
        for (cell, right) in found.cells.iter().zip(&right.cells) {
            // Seven layers hide the last one: α (1 − α)⁷ of its color, of which some channel is 0.9 or so.
            assert!(cell.error.max > 0.5 * opacity(8) * 0.5, "{cell:?}");
            assert_eq!(Cell { expected: right.expected, ..cell.clone() }.holds(), Some(false), "{cell:?}");
        }
    });
}
