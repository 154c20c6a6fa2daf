//! A device, clouds on it, and images of a square seen from the front.

use glam::{DVec3, Vec3};
use pellucid_core::camera::{Camera, Projection};
use pellucid_core::image::Image;
use pellucid_core::points::Points;
use pellucid_core::progress::Progress;
use pellucid_engine::Result;
use pellucid_engine::methods::{Factors, Frame, Renderer};
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
        let dealt = ensembles::deal(vec![points], self.seed, &Progress::hidden());
        Ok(self.renderer.upload(&Arranged::Dealt(dealt))?)
    }

    /// The square from (−½, −½, 0) to (½, ½, 0), or what is around it, from the front: `height` world units on `side`
    /// pixels. Values are encoded, as the papers blend them.
    pub fn square(&mut self, cloud: &mut DeviceCloud, side: u32, height: f64, method: Method) -> Result<Image> {
        self.image(cloud, Self::front(height), [side, side], method)
    }

    /// The square's camera.
    fn front(height: f64) -> Camera {
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
        let frame = self.frame(camera, size, method);
        Ok(self.renderer.render(cloud, &frame)?.image)
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

pub fn random(seed: u64) -> Pcg64 {
    Pcg64::seed_from_u64(seed)
}

/// Gaussian, mean 0 and variance 1 (Box and Muller).
pub fn gauss(random: &mut Pcg64) -> f64 {
    let radius = (-2.0 * (1.0 - random.random::<f64>()).ln()).sqrt();
    radius * (std::f64::consts::TAU * random.random::<f64>()).cos()
}
