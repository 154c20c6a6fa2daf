//! Opaque points and splats, one layer of soft ones, and surfaces that are closed in the image.

use pellucid_reference::coverage::Shape;
use pellucid_reference::{image_space, one_layer, opaque, peel_layers, splats};
use pellucid_scene::prepare::order;
use pellucid_scene::{
    BlendedSplats, ImageSpace, Interpolated, Iterations, OneLayer, PeelLayers, ScreenSplats, Shading, SplatShape,
};
use rand::RngExt;

use super::*;

/// The methods of which the nearest splat wins, with what they draw.
fn nearest() -> Vec<(Method, Shape, ScreenSplats)> {
    let plain = ScreenSplats::default();
    let fixed = ScreenSplats { pixel_radius: Some(1.3), ..plain };
    let of = |splats, shape| Interpolated { splats, shape };
    vec![
        (Method::Points, Shape::Point, plain),
        (Method::Squares(plain), Shape::Square, plain),
        (Method::Circles(plain), Shape::Disc, plain),
        (Method::Circles(fixed), Shape::Disc, fixed),
        (Method::Paraboloid(of(plain, SplatShape::Circle)), Shape::Disc, plain),
        (Method::Cone(of(plain, SplatShape::Square)), Shape::Square, plain),
        (Method::Sphere(plain), Shape::Disc, plain),
    ]
}

/// A sphere's displacement is r √(1 − ρ²). Eight roundings of ρ² change the root by at most their own root, 7e-4; radii
/// are below 0.6 and depths above 3.
fn depth_error(method: Method) -> f64 {
    if matches!(method, Method::Sphere(_)) { 7e-4 * 0.6 / 3.0 } else { FLAT_DEPTH }
}

#[test]
fn nearest_splats_are_the_mean_of_their_references() {
    with_device(|device| {
        for camera in cameras() {
            for (method, shape, settings) in nearest() {
                let points = clear(&mixed(1), &camera, SIZE, |_, points, i| opaque::splat(points, i, shape, &settings));
                let colors = colors(&points);
                let image = |one: &One| {
                    let view = View::new(one.camera, SIZE);
                    let picture = opaque::render(view, &points, &colors, shape, &settings, method.relief());
                    PictureRange::of_picture(&picture, depth_error(method))
                };
                let (name, frame) = (format!("{method:?}"), frame(camera, SIZE, method));
                // As at one sample: 1e-6.
                let subject =
                    Subject { name, points: &points, frame, image: Box::new(image), slack: 1e-6, counts: false };
                subject.check(device);
            }
        }
    });
}

#[test]
fn blended_splats_are_the_mean_of_their_references() {
    with_device(|device| {
        let settings = BlendedSplats::default();
        let squares = BlendedSplats { shape: SplatShape::Square, ..settings };
        let methods = [
            (Method::Hqs(settings), Shape::Disc),
            (Method::Hqs(squares), Shape::Square),
            (Method::Splats(settings), Shape::Oriented),
        ];
        for camera in cameras() {
            for (method, shape) in methods {
                let points = scene(&mixed(3));
                let colors = colors(&points);
                let image = |one: &One| splats::ranges(View::new(one.camera, SIZE), &points, &colors, shape, &settings);
                let (name, frame) = (format!("{method:?}"), frame(camera, SIZE, method));
                let slack = crate::splats::SUM_ERROR;
                let subject = Subject { name, points: &points, frame, image: Box::new(image), slack, counts: false };
                subject.check(device);
            }
        }
    });
}

#[test]
fn one_layer_is_the_mean_of_its_references() {
    with_device(|device| {
        let settings = OneLayer { threshold: 0.5, softness: 0.3 };
        let soup = mixed(5);
        let mut random = random(5);
        let fields = soup.iter().map(|_| random.random()).collect();
        let points = order::canonical(Points {
            positions: soup.iter().map(|p| p.position).collect(),
            colors: soup.iter().map(|p| p.color).collect(),
            opacities: soup.iter().map(|p| p.opacity).collect(),
            radii: soup.iter().map(|p| p.radius).collect(),
            normals: Some(soup.iter().map(|p| p.normal).collect()),
            fields,
            ..Points::default()
        });
        let colors = colors(&points);
        for camera in cameras() {
            let image = |one: &One| one_layer::ranges(View::new(one.camera, SIZE), &points, &colors, &settings);
            let frame = frame(camera, SIZE, Method::OneLayer(settings));
            let (name, slack) = ("one-layer".to_owned(), crate::one_layer::SUM_ERROR);
            let subject = Subject { name, points: &points, frame, image: Box::new(image), slack, counts: false };
            subject.check(device);
        }
    });
}

/// Filters of both kinds, and layers that are far enough apart.
fn filters() -> ImageSpace {
    ImageSpace {
        fill: Iterations::Count(2),
        occlusion: Iterations::Count(2),
        min_layer_distance: Some(0.2),
        cull: false,
        ..ImageSpace::default()
    }
}

#[test]
fn closed_surfaces_are_the_mean_of_their_references() {
    with_device(|device| {
        let filters = filters();
        let layers = PeelLayers { filters, layers: 3, ..PeelLayers::default() };
        for camera in cameras() {
            let points = clear(&soup(7, 4000, 0.0..0.1, 0.1..0.9, true), &camera, SIZE, |_, points, i| {
                image_space::splat(points, i)
            });
            let points = clear_of(&points, &camera, SIZE, &Shading::NONE);
            let colors = colors(&points);
            let surface = |one: &One| image_space::ranges(View::new(one.camera, SIZE), &points, &colors, &filters);
            let peeled = |one: &One| peel_layers::ranges(View::new(one.camera, SIZE), &points, &colors, &layers);
            let of = |method: Method| frame(camera, SIZE, method);
            let surfaces = Subject {
                name: "image-space".into(),
                points: &points,
                frame: of(Method::ImageSpace(filters)),
                image: Box::new(surface),
                slack: crate::image_space::COLOR_ERROR,
                counts: false,
            };
            surfaces.check(device);
            let peeled = Subject {
                name: "peel-layers".into(),
                points: &points,
                frame: of(Method::PeelLayers(layers)),
                image: Box::new(peeled),
                slack: crate::peel_layers::COLOR_ERROR,
                counts: false,
            };
            peeled.check(device);
        }
    });
}
