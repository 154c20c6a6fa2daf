//! Ensembles of points: image i has those from iL to (i + 1)L of N·L, to which all points are dealt together.

use pellucid_reference::spbr::{Ranges, Rule, Turn, ranges_of};
use pellucid_scene::prepare::Arranged;
use pellucid_scene::{Spbr, SpbrSimplified};

use super::*;

/// The mean of images, and of squared standard errors.
fn mean_of(images: &[Ranges], width: u32) -> Ranges {
    let picture = |of: &Ranges| PictureRange {
        width,
        rgba: of.rgba.clone(),
        depth: of.depth.clone(),
        counts: vec![Range::only(0.0); of.rgba.len()],
    };
    let mean = mean(&images.iter().map(picture).collect::<Vec<_>>());
    let error = |pixel: usize, c: usize| {
        let sum = |end: fn(&Range) -> f64| {
            let squares = images.iter().map(|image| end(&image.stderr[pixel][c]).powi(2));
            squares.sum::<f64>().sqrt() / images.len() as f64
        };
        Range { low: sum(|range| range.low), high: sum(|range| range.high) }
    };
    let stderr = (0..mean.rgba.len()).map(|pixel| std::array::from_fn(|c| error(pixel, c))).collect();
    Ranges { rgba: mean.rgba, depth: mean.depth, stderr }
}

#[test]
fn pictures_are_the_mean_of_ensembles_that_are_dealt_together() {
    with_device(|device| {
        let mut renderer = Renderer::new(device).expect("a renderer");
        let list = crate::spbr::mixture(3);
        let colors = colors(&list.points);
        let mut cloud = renderer.upload(&Arranged::Dealt(list.clone())).expect("fits");
        let simplified = SpbrSimplified { ensembles: 5, ..SpbrSimplified::default() };
        for (distance, perspective) in [(6.0, true), (2.2, true), (6.0, false)] {
            let camera = crate::spbr::camera(distance, perspective);
            for (method, rule) in [
                (
                    Method::Spbr(Spbr { ensembles: 9, ..Spbr::default() }),
                    Rule::from(Spbr { ensembles: 9, ..Spbr::default() }),
                ),
                (
                    Method::Spbr(Spbr { ensembles: 6, cos_theta: false, brighten: false }),
                    Rule { ensembles: 6, adjust: true, cos_theta: false },
                ),
                (Method::SpbrSimplified(simplified), Rule::from(simplified)),
            ] {
                for count in COUNTS {
                    let frame = Frame { seed: 11, ..sampled(camera, method, count) };
                    let image = renderer.render(&mut cloud, &frame).expect("renders").image;
                    let of = |turn: &dyn Fn(u32) -> Turn| {
                        let cameras = reference::samples::cameras(&camera, count);
                        let image = |(camera, index): (&Camera, u32)| {
                            ranges_of(View::new(camera, SIZE), &list, &colors, &rule, 11, turn(index))
                        };
                        mean_of(&cameras.iter().zip(0..).map(image).collect::<Vec<_>>(), SIZE[0])
                    };
                    let found = crate::spbr::compare(&image, &of(&|index| Turn { index, images: count }));
                    assert!(found.is_ok(), "{method:?}, {distance}, {count}: {found:?}");
                    // The comparison can fail: the same ensembles in each image, another order.
                    for wrong in [&(|_| Turn { index: 0, images: count }) as &dyn Fn(u32) -> Turn, &|index| Turn {
                        index: count - 1 - index,
                        images: count,
                    }] {
                        assert!(crate::spbr::compare(&image, &of(wrong)).is_err(), "{method:?}, {count}");
                    }
                }
            }
        }
    });
}
