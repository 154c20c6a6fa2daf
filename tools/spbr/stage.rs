//! A device, clouds on it, and images of a square seen from the front.

use std::time::Instant;

use glam::{DVec3, Vec3};
use pellucid_core::camera::{Camera, Projection};
use pellucid_core::color::decode_srgb;
use pellucid_core::image::Image;
use pellucid_core::points::Points;
use pellucid_core::progress::Progress;
use pellucid_engine::Result;
use pellucid_engine::methods::brightness;
use pellucid_engine::methods::{Factors, Frame, Rendered, Renderer};
use pellucid_engine::passes::project::DeviceCloud;
use pellucid_gpu::{Device, DeviceOptions};
use pellucid_scene::prepare::{Arranged, ensembles};
use pellucid_scene::{ColorSpace, Method, Shading};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

pub struct Stage {
    device: Device,
    renderer: Renderer,
    /// Seed of clouds and ensembles.
    pub seed: u64,
}

impl Stage {
    pub fn open(seed: u64) -> Result<Self> {
        let device = Device::open(&DeviceOptions::from_env())?;
        let renderer = Renderer::new(&device)?;
        Ok(Self { device, renderer, seed })
    }

    pub fn machine(&self) -> String {
        let info = self.device.info();
        format!("{} ({}), pellucid {}", info.name, info.driver, env!("CARGO_PKG_VERSION"))
    }

    /// Deals a cloud and puts it on the device.
    pub fn upload(&self, points: Points) -> Result<DeviceCloud> {
        Ok(self.upload_timed(vec![points])?.0)
    }

    /// Deals clouds and puts them on the device; also the time that the dealing took, in seconds.
    pub fn upload_timed(&self, clouds: Vec<Points>) -> Result<(DeviceCloud, f64)> {
        let begin = Instant::now();
        let dealt = ensembles::deal(clouds, self.seed, &Progress::hidden());
        let seconds = begin.elapsed().as_secs_f64();
        Ok((self.renderer.upload(&Arranged::Dealt(dealt))?, seconds))
    }

    /// The square from (−½, −½, 0) to (½, ½, 0), or what is around it, from the front: `height` world units on `side`
    /// pixels. Values are encoded, as the papers blend them.
    pub fn square(&mut self, cloud: &mut DeviceCloud, side: u32, height: f64, method: Method) -> Result<Image> {
        self.image(cloud, Self::front(height), [side, side], method)
    }

    /// The square's camera.
    pub fn front(height: f64) -> Camera {
        let up = DVec3::Y;
        let projection = Projection::Orthographic { height };
        Camera::look_at(DVec3::Z, DVec3::ZERO, up, projection, 0.1, 2.0).expect("Y is not the view's direction")
    }

    /// The whole square of points of opacity 1, as if they had another one.
    pub fn thinned(&mut self, cloud: &mut DeviceCloud, side: u32, opacity: f32, method: Method) -> Result<Image> {
        let factors = Factors { opacity, ..Factors::default() };
        let frame = Frame { factors, ..self.frame(Self::front(1.0), [side, side], method) };
        Ok(self.renderer.render(cloud, &frame)?.image)
    }

    pub fn image(&mut self, cloud: &mut DeviceCloud, camera: Camera, size: [u32; 2], method: Method) -> Result<Image> {
        Ok(self.rendered(cloud, camera, size, method)?.image)
    }

    /// A frame with its times and counts.
    pub fn rendered(
        &mut self,
        cloud: &mut DeviceCloud,
        camera: Camera,
        size: [u32; 2],
        method: Method,
    ) -> Result<Rendered> {
        let frame = self.frame(camera, size, method);
        Ok(self.renderer.render(cloud, &frame)?)
    }

    /// An image, brightened as its method says, and the factor p.
    pub fn brightened(
        &mut self,
        cloud: &mut DeviceCloud,
        camera: Camera,
        size: [u32; 2],
        method: Method,
    ) -> Result<(Image, f32)> {
        let frame = self.frame(camera, size, method);
        let mut image = self.renderer.render(cloud, &frame)?.image;
        let applied = brightness::apply(&mut self.renderer, cloud, &frame, &mut image)?;
        Ok((image, applied.map_or(1.0, |applied| applied.factor)))
    }

    fn frame(&self, camera: Camera, size: [u32; 2], method: Method) -> Frame {
        Frame {
            shading: Shading::default(),
            color: ColorSpace::Encoded,
            seed: self.seed,
            ..Frame::new(camera, size, method)
        }
    }
}

/// White points of opacity 1, uniform on the square of side 1 around the origin.
pub fn plane(count: usize, seed: u64) -> Points {
    let mut random = random(seed);
    let mut at = || random.random::<f64>() - 0.5;
    Points {
        positions: (0..count).map(|_| DVec3::new(at(), at(), 0.0)).collect(),
        colors: vec![Vec3::ONE; count],
        opacities: vec![1.0; count],
        radii: vec![0.0; count],
        ..Points::default()
    }
}

/// A plane of points of this gray, of 255, each with Gaussian noise of this variance in gray levels².
pub fn noisy_plane(count: usize, gray: f64, variance: f64, seed: u64) -> Points {
    let (mut points, mut random) = (plane(count, seed), random(seed + 1));
    for color in &mut points.colors {
        *color = Vec3::splat(of_level(gray + variance.sqrt() * gauss(&mut random)));
    }
    points
}

/// Linear value of one of 256 levels, clamped to them; not rounded.
pub fn of_level(level: f64) -> f32 {
    decode_srgb((level.clamp(0.0, 255.0) / 255.0) as f32)
}

/// Gray of encoded color: 0.299 R + 0.587 G + 0.114 B.
pub fn gray([r, g, b, _]: &[f32; 4]) -> f64 {
    0.299 * f64::from(*r) + 0.587 * f64::from(*g) + 0.114 * f64::from(*b)
}

/// Eq. 10 of Uchida et al. 2020: the error of an image's grays against a standard image, normalized by its square.
pub fn nmse(standard: &Image, target: &Image) -> f64 {
    let pairs = standard.rgba.iter().zip(&target.rgba).map(|(i, k)| (gray(i), gray(k)));
    let (error, whole) = pairs.fold((0.0, 0.0), |(error, whole), (i, k)| (error + (i - k) * (i - k), whole + i * i));
    error / whole
}

pub fn random(seed: u64) -> Pcg64 {
    Pcg64::seed_from_u64(seed)
}

/// Gaussian, mean 0 and variance 1 (Box and Muller).
pub fn gauss(random: &mut Pcg64) -> f64 {
    let radius = (-2.0 * (1.0 - random.random::<f64>()).ln()).sqrt();
    radius * (std::f64::consts::TAU * random.random::<f64>()).cos()
}
