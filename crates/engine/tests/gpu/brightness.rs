//! Brightening of thinned-out images on the device: by a factor that is given, and by one that is found.

use glam::{DVec3, Vec3};
use pellucid_core::image::Image;
use pellucid_core::points::Points;
use pellucid_core::progress::Progress;
use pellucid_engine::methods::brightness::{Applied, End, apply, factor};
use pellucid_engine::methods::{Frame, Renderer};
use pellucid_gpu::Device;
use pellucid_scene::prepare::Arranged;
use pellucid_scene::prepare::ensembles::{Dealt, deal};
use pellucid_scene::{Brightness, ColorSpace, Discs, Method, Spbr, SpbrSimplified};
use pellucid_testing::{frame, orthographic, random, render, with_device};
use rand::RngExt;

const SIZE: [u32; 2] = [48, 32];

/// Gray and colored points all over the view, a few for each pixel.
fn cloud() -> Dealt {
    let mut random = random(3);
    let count = 6000;
    let mut unit = || random.random::<f64>();
    let points = Points {
        positions: (0..count).map(|_| DVec3::new(4.0 * unit() - 2.0, 4.0 * unit() - 2.0, unit() - 0.5)).collect(),
        colors: (0..count).map(|_| Vec3::new(unit() as f32, 0.3, 0.6 * unit() as f32)).collect(),
        opacities: vec![0.2; count],
        radii: vec![0.0; count],
        ..Points::default()
    };
    deal(vec![points], 1, &Progress::hidden())
}

fn simplified(ensembles: u32, brightness: Brightness) -> Method {
    Method::SpbrSimplified(SpbrSimplified { ensembles, brightness })
}

/// The image as it is rendered, as it is after brightening, and what was done.
fn brightened(device: &Device, dealt: &Dealt, frame: &Frame) -> (Image, Image, Option<Applied>) {
    let mut renderer = Renderer::new(device).unwrap();
    let mut cloud = renderer.upload(&Arranged::Dealt(dealt.clone())).unwrap();
    let image = renderer.render(&mut cloud, frame).unwrap().image;
    let mut bright = image.clone();
    let applied = apply(&mut renderer, &mut cloud, frame, &mut bright).unwrap();
    (image, bright, applied)
}

/// Asserts that A and depth are the same, and colors are multiplied by `p` and cut at 1.
fn assert_multiplied(before: &Image, after: &Image, p: f32) {
    assert_eq!(before.depth, after.depth);
    for (before, after) in before.rgba.iter().zip(&after.rgba) {
        assert_eq!(before[3], after[3]);
        (0..3).for_each(|i| assert_eq!(after[i], (before[i] * p).min(1.0)));
    }
}

#[test]
fn a_given_factor_multiplies() {
    with_device(|device| {
        let of = |p| frame(orthographic(), SIZE, simplified(8, Brightness::Factor(p)));
        let (before, after, applied) = brightened(device, &cloud(), &of(2.5));
        assert_eq!(applied, Some(Applied { factor: 2.5, found: None }));
        assert_multiplied(&before, &after, 2.5);
        let (before, after, _) = brightened(device, &cloud(), &of(1.0));
        assert!(before == after);
    });
}

#[test]
fn the_opaque_image_tells_the_factor() {
    with_device(|device| {
        let dealt = cloud();
        let opaque = frame(orthographic(), SIZE, simplified(1, Brightness::Factor(1.0)));
        let spbr = Method::Spbr(Spbr { ensembles: 30, brighten: true, ..Spbr::default() });
        for method in [simplified(30, Brightness::Auto), spbr] {
            for color in [ColorSpace::Linear, ColorSpace::Encoded] {
                let frame = Frame { color, ..frame(orthographic(), SIZE, method) };
                let (before, after, applied) = brightened(device, &dealt, &frame);
                let (reference, ..) = brightened(device, &dealt, &Frame { color, ..opaque });
                let found = factor(&before.rgba, &reference.rgba, color);
                assert_eq!(applied, Some(Applied { factor: found.factor, found: Some(found) }));
                assert!(found.end == End::Met && found.factor > 1.2, "{found:?}");
                assert_multiplied(&before, &after, found.factor);
                // So bright that nothing more is to be done.
                assert_eq!(factor(&after.rgba, &reference.rgba, color).factor, 1.0);
            }
        }
        // One ensemble is the opaque image itself.
        let (_, _, applied) = brightened(device, &dealt, &frame(orthographic(), SIZE, simplified(1, Brightness::Auto)));
        assert_eq!(applied.map(|applied| applied.factor), Some(1.0));
    });
}

#[test]
fn other_methods_stay_as_they_are() {
    with_device(|device| {
        let dealt = cloud();
        for method in [Method::Spbr(Spbr { ensembles: 4, ..Spbr::default() }), Method::Points] {
            let (before, after, applied) = brightened(device, &dealt, &frame(orthographic(), SIZE, method));
            assert!(applied.is_none() && before == after);
        }
        // Points that were dealt are the same to a method that does not mind.
        let frame = frame(orthographic(), SIZE, Method::ABuffer(Discs::default()));
        let (_, after, applied) = brightened(device, &dealt, &frame);
        assert!(applied.is_none() && after.rgba.len() == render(device, &dealt.points, &frame).rgba.len());
    });
}
