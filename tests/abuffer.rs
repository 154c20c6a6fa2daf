//! `abuffer`: every stage, then the image, against the float64 reference.

mod common;

use common::{bits, difference, frame, orthographic, perspective, render, scene, soup, with_device};
use pellucid::reference;
use pellucid::scene::{DiscShape, Discs, Falloff, Method, Raster};

#[test]
fn smoke() {
    with_device(|device| {
        let points = scene(&soup(1, 500, 0.02..0.2, 0.1..0.9, true));
        for camera in [perspective(), orthographic()] {
            for shape in [DiscShape::Flat, DiscShape::Oriented] {
                for falloff in [Falloff::Flat, Falloff::Gaussian] {
                    for raster in [Raster::Compute, Raster::Hardware] {
                        let discs = Discs { shape, falloff, raster };
                        let frame = frame(camera, [128, 96], Method::ABuffer(discs));
                        let image = render(device, &points, &frame);
                        let colors: Vec<_> = points.colors.iter().map(|c| c.as_dvec3()).collect();
                        let picture = reference::abuffer::render(&camera, [128, 96], &points, &colors, &discs);
                        let (largest, over) = difference(&image, &picture, 1e-3);
                        eprintln!("{discs:?}: {largest} {over} fragments {}", image.fragments.as_ref().map_or(0, |f| f.iter().map(|n| u64::from(*n)).sum::<u64>()));
                        let _ = bits(&image);
                    }
                }
            }
        }
    });
}
