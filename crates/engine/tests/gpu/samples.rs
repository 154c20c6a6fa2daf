//! Several samples per pixel: the picture of every method against the mean of float64 references, each of a scene that
//! is moved by a fraction of a pixel; what may not change a byte; what is computed once.
//!
//! The references' moves are those of [`reference::samples`], written from the definition. Each method has the bounds
//! of its own test at one sample; the mean is rounded once.

mod contract;
mod discs;
mod ensembles;
mod gaussians;
mod lit;
mod opaque;
mod soft;
mod stochastic;

use glam::{DVec2, DVec3, Vec2Swizzles as _};
use pellucid_core::camera::{Camera, Projection};
use pellucid_core::color::{decode_srgb_f64, encode_srgb};
use pellucid_core::image::Image;
use pellucid_core::points::Points;
use pellucid_engine::methods::{Frame, Renderer};
use pellucid_gpu::Device;
use pellucid_reference as reference;
use pellucid_reference::coverage::{Splat, possible};
use pellucid_reference::range::{PictureRange, ROUNDING, Range};
use pellucid_reference::samples::{mean, moved, places, shown};
use pellucid_reference::{ReferencePicture, View};
use pellucid_scene::{ColorSpace, Method};
use pellucid_testing::*;

/// Numbers of samples.
const COUNTS: [u32; 3] = [2, 4, 16];

/// Odd numbers of columns and rows.
const SIZE: [u32; 2] = [61, 43];

/// An image of several: its camera and its number.
struct One<'a> {
    camera: &'a Camera,
    number: u32,
}

/// A frame of some points, and its reference.
struct Subject<'a> {
    name: String,
    points: &'a Points,
    frame: Frame,
    /// An image whose mean with others the picture is.
    image: Box<dyn Fn(&One) -> PictureRange + 'a>,
    /// How far colors may be out of their ranges.
    slack: f64,
    /// True if the reference counts what the image counts.
    counts: bool,
}

impl Subject<'_> {
    /// The mean of the images whose samples lie at these places.
    fn wanted(&self, places: &[DVec2]) -> PictureRange {
        let image = |(place, number): (&DVec2, u32)| {
            let camera = moved(&self.frame.camera, *place);
            let image = (self.image)(&One { camera: &camera, number });
            match self.frame.color {
                ColorSpace::Linear => image,
                ColorSpace::Encoded => shown(&image, encoded(&self.frame).as_dvec3()),
            }
        };
        mean(&places.iter().zip(0..).map(image).collect::<Vec<_>>())
    }

    fn found(&self, renderer: &mut Renderer, samples: u32) -> Image {
        let mut cloud = renderer.upload(self.points).expect("the cloud fits");
        let image = renderer.render(&mut cloud, &Frame { samples, ..self.frame }).expect("renders").image;
        as_shown(image, &self.frame)
    }

    /// Compares with the mean of images whose samples lie at these places.
    fn compare(&self, image: &Image, places: &[DVec2]) -> Result<(), String> {
        self.compare_with(image, &self.wanted(places))
    }

    fn compare_with(&self, image: &Image, wanted: &PictureRange) -> Result<(), String> {
        compare_ranges(image, wanted, self.slack + ROUNDING)?;
        let Some(sums) = image.fragments.as_ref().filter(|_| self.counts) else { return Ok(()) };
        let counts = image.mean_counts(sums);
        let off = |pixel: &usize| !wanted.counts[*pixel].covers(f64::from(counts[*pixel]), 1e-6);
        match (0..counts.len()).find(off) {
            None => Ok(()),
            Some(pixel) => Err(format!("pixel {pixel}: {} fragments, not {:?}", counts[pixel], wanted.counts[pixel])),
        }
    }

    /// Asserts that the picture is the mean at every number of samples, and none of pictures that are moved otherwise.
    #[track_caller]
    fn check(&self, device: &Device) {
        let mut renderer = Renderer::new(device).expect("a renderer");
        for count in COUNTS {
            let image = self.found(&mut renderer, count);
            assert_eq!(image.samples, count, "{}", self.name);
            let wanted = self.wanted(&places(count));
            let known = wanted.rgba.iter().filter(|rgba| rgba[3].high - rgba[3].low < 0.5).count();
            assert!(4 * known > 3 * wanted.rgba.len(), "{}: {known} pixels are known", self.name);
            let found = self.compare_with(&image, &wanted);
            assert!(found.is_ok(), "{}, {count} samples: {found:?}", self.name);
            if count == 4 {
                self.check_that_others_differ(&image);
            }
        }
    }

    /// The set of places is its own mirror image along both diagonals and in the middle of the pixel, so that only
    /// depths tell whether x and y are exchanged or both signs turned.
    #[track_caller]
    fn check_that_others_differ(&self, image: &Image) {
        let right = places(4);
        let each = |change: fn(DVec2) -> DVec2| right.iter().map(|place| change(*place)).collect::<Vec<_>>();
        let exchanged = each(|place| place.yx());
        let turned = each(|place| 1.0 - place);
        for (what, wrong) in [("x and y exchanged", &exchanged), ("both signs turned", &turned)] {
            assert!(self.compare(image, wrong).is_err(), "{}: {what} is noticed", self.name);
        }
        let upside_down = each(|place| DVec2::new(place.x, 1.0 - place.y));
        let next = each(|place| place + DVec2::new(0.25, 0.0));
        let corner = each(|place| place - 0.125);
        for (what, wrong) in [("y turned", &upside_down), ("i + 1", &next), ("no half cell", &corner)] {
            let wanted = without_depths(self.wanted(wrong));
            assert!(self.compare_with(image, &wanted).is_err(), "{}: {what} is noticed in colors", self.name);
        }
    }
}

/// Ranges with any depth, so that colors alone decide.
fn without_depths(picture: PictureRange) -> PictureRange {
    let any = Range { low: f64::NEG_INFINITY, high: f64::INFINITY };
    PictureRange { depth: vec![any; picture.depth.len()], ..picture }
}

/// The encoded values of a frame's background.
fn encoded(frame: &Frame) -> glam::Vec3 {
    glam::Vec3::from_array(frame.background.to_array().map(encode_srgb))
}

/// An image with the linear colors that it shows, of a frame of encoded ones.
fn as_shown(mut image: Image, frame: &Frame) -> Image {
    if frame.color == ColorSpace::Encoded {
        for rgba in &mut image.rgba {
            let [r, g, b] = Image::over(*rgba, encoded(frame)).map(|value| decode_srgb_f64(value.into()) as f32);
            *rgba = [r, g, b, rgba[3]];
        }
    }
    image
}

/// The points, in canonical order, whose coverage roundings decide in no image of any number of samples.
fn clear(points: &[P], camera: &Camera, size: [u32; 2], splat: impl Fn(View, &Points, usize) -> Splat) -> Points {
    let all = scene(points);
    let images: Vec<Camera> = COUNTS.into_iter().flat_map(|count| reference::samples::cameras(camera, count)).collect();
    let is_clear = |i: usize, camera: &Camera| {
        let view = View::new(camera, size);
        possible(view, &splat(view, &all, i), 0..size[1]).iter().all(|pixel| pixel.sure)
    };
    let kept: Vec<bool> = (0..all.len()).map(|i| images.iter().all(|camera| is_clear(i, camera))).collect();
    let clear = picked(&all, |i| kept[i]);
    assert!(2 * clear.len() > points.len(), "most points are clear: {} of {}", clear.len(), points.len());
    clear
}

/// Makes pixels unknown.
fn open(picture: &mut PictureRange, is_open: impl Fn(usize) -> bool) {
    for pixel in (0..picture.rgba.len()).filter(|pixel| is_open(*pixel)) {
        picture.rgba[pixel] = [Range { low: 0.0, high: 2.0 }; 4];
        picture.depth[pixel] = Range { low: 0.0, high: f64::INFINITY };
    }
}

/// A soup of small discs with a few large ones.
fn mixed(seed: u64) -> Vec<P> {
    [soup(seed, 400, 0.0..0.1, 0.0..1.0, true), soup(seed + 1, 12, 0.2..1.0, 0.05..0.4, true)].concat()
}

/// Both projections, so narrow that the image's border cuts the cube of side 2: points come in and go out.
fn cameras() -> [Camera; 2] {
    let fov_y = 24f64.to_radians();
    let near = Camera { projection: Projection::Perspective { fov_y }, ..perspective() };
    [near, Camera { projection: Projection::Orthographic { height: 2.0 }, ..orthographic() }]
}

/// The relative error of a depth: one projection in float32.
const FLAT_DEPTH: f64 = 1e-6;

fn of_picture(picture: &ReferencePicture) -> PictureRange {
    PictureRange::of_picture(picture, FLAT_DEPTH)
}

/// The colors of points as a frame blends them.
fn shaded(points: &Points, frame: &Frame) -> Vec<DVec3> {
    reference::shading::shade(points, &frame.camera, &frame.shading, frame.color)
}

/// A frame of several samples.
fn sampled(camera: Camera, method: Method, samples: u32) -> Frame {
    Frame { samples, ..frame(camera, SIZE, method) }
}
