//! Soft transparency (Seemann et al. 2018): spheres that are densest in the middle, in front of solid points.
//!
//! Everything is exact except for rounding: rays through pixel centers, spheres that are hit where d < r, no
//! always-covered pixel, no limit on radii. s runs along the normalized ray; a depth z cuts it at z/cos φ. Colors of
//! points are those of [`super::shading::shade`].

pub mod density;
pub mod express;
mod ray;
mod rectangle;
mod spans;

use glam::DVec3;

pub use self::density::Strength;
pub use self::ray::{Chord, Ray};
pub use self::spans::{Limits, Medium, Span, in_8_bits};
use super::coverage::is_in_depth;
use super::fragments::Composite;
/// The background of soft points: the pixel of a picture of the solid ones.
pub use super::fragments::Composite as Behind;
use super::{ReferencePicture, View};
use pellucid_core::parallel;
use pellucid_core::points::Points;
use pellucid_scene::{MAX_SHELLS, Shells, Soft, SoftMethod};

/// A soft method, its settings, and their meaning for a cloud.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Model {
    /// The method.
    pub method: SoftMethod,
    /// Settings of the method.
    pub soft: Soft,
    /// λ and a₀.
    pub strength: Strength,
}

impl Model {
    /// Prepares a method for some points.
    pub fn new(method: SoftMethod, points: &Points) -> Self {
        let soft = *method.settings();
        let median_radius = density::median_radius(points, soft.threshold);
        Self { method, soft, strength: Strength::new(&method.into(), &soft, median_radius) }
    }
}

/// A soft point as a camera sees it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sphere {
    /// Camera coordinates (right, up, z).
    pub center: DVec3,
    /// World units.
    pub radius: f64,
    /// Shaded, in the space that blending runs in.
    pub color: DVec3,
    /// W of Eq. 22, 1 where nothing is modulated.
    pub modulation: f64,
    /// The number of concentric spheres that approximate it; `None` uses the density itself.
    pub shells: Option<u32>,
}

/// A finished pixel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pixel {
    /// Premultiplied.
    pub color: DVec3,
    /// A = 1 − T.
    pub alpha: f64,
    /// z where the first soft point with α > 0 is entered, else the solid's.
    pub depth: f64,
    /// Soft points with some part between the near plane and the solid.
    pub count: u32,
}

impl Pixel {
    /// Light of the soft points over the background, whose visible share is exp(`log_transmittance`).
    fn before(color: DVec3, log_transmittance: f64, first: Option<f64>, count: u32, behind: &Behind) -> Self {
        let transmittance = log_transmittance.exp();
        Self {
            color: color + transmittance * behind.color,
            // From zero, so that nothing drawn is 0 and not the −0 that −expm1(0) yields.
            alpha: 0.0 - log_transmittance.exp_m1() + transmittance * behind.alpha,
            depth: first.unwrap_or(behind.depth),
            count,
        }
    }
}

/// The scene to render.
#[derive(Debug, Clone, Copy)]
pub struct Scene<'a> {
    /// Camera and image.
    pub view: View<'a>,
    /// All points; those with F > t are soft.
    pub points: &'a Points,
    /// A color for each point ([`super::shading::shade`]).
    pub colors: &'a [DVec3],
    /// The model of the soft points.
    pub model: Model,
}

impl Scene<'_> {
    /// Returns the spheres with centers between near and far.
    pub fn spheres(&self) -> Vec<Sphere> {
        let Self { view: View { camera, .. }, points, colors, model } = self;
        let soft = (0..points.fields.len()).filter(|i| points.fields[*i] > model.soft.threshold);
        let sphere = |i: usize| {
            let center = camera.to_view(points.positions[i]);
            let drawn = center.is_finite() && is_in_depth(camera, center.z);
            let radius = f64::from(points.radii[i]);
            drawn.then(|| Sphere {
                center,
                radius,
                color: colors[i],
                modulation: density::modulation(points.fields[i], &model.soft),
                shells: self.shells(radius, center.z),
            })
        };
        soft.filter_map(sphere).collect()
    }

    fn shells(&self, radius: f64, z: f64) -> Option<u32> {
        let SoftMethod::Concentric(soft) = self.model.method else { return None };
        Some(match soft.shells {
            Shells::Fixed(shells) => shells,
            Shells::Adaptive => {
                let radius_px = radius * self.view.pixels_per_unit(z);
                let wanted = (radius_px / f64::from(soft.pixels_per_shell)).ceil();
                wanted.clamp(1.0, f64::from(MAX_SHELLS)) as u32
            }
        })
    }

    /// Renders one pixel; spheres that its ray misses have no effect.
    fn pixel<'s>(&self, pixel: usize, spheres: impl Iterator<Item = &'s Sphere>, behind: &Behind) -> Pixel {
        let ray = Ray::new(self.view, self.view.place(pixel));
        let limits = Limits { near: self.view.camera.near * ray.stretch, solid: behind.depth * ray.stretch };
        let mut spans = Vec::new();
        let met = spheres.filter(|sphere| spans::append(&mut spans, &self.model, sphere, &ray, &limits)).count();
        spans::blend(spans, ray.stretch, met as u32, behind)
    }

    /// Renders these pixels (row · width + column, ascending), testing every sphere on each. `behind` gives the
    /// background of a pixel.
    pub fn render_at(&self, wanted: &[usize], behind: impl Fn(usize) -> Behind + Sync) -> Vec<Pixel> {
        if let SoftMethod::Express(_) = self.model.method {
            let found = |pixel: usize| wanted.binary_search(&pixel).ok();
            let lists = express::lists(self.view, self.points, &self.model, found, wanted.len());
            let each = lists.iter().zip(wanted);
            return each.map(|(list, pixel)| express::blend(list, self.colors, &behind(*pixel))).collect();
        }
        let spheres = self.spheres();
        parallel::gather(wanted.len(), |i| self.pixel(wanted[i], spheres.iter(), &behind(wanted[i])))
    }

    /// Renders the whole image. `behind` gives the background of a pixel.
    pub fn render(&self, behind: impl Fn(usize) -> Behind + Sync) -> ReferencePicture {
        let pixels = match self.model.method {
            SoftMethod::Express(_) => self.render_at(&(0..self.view.pixels()).collect::<Vec<_>>(), behind),
            _ => self.render_rows(behind),
        };
        let pixel = |p: &Pixel| (Composite { color: p.color, alpha: p.alpha, depth: p.depth }, p.count);
        ReferencePicture::of(self.view.size, pixels.iter().map(pixel))
    }

    /// All pixels, with the spheres tried only where a rectangle around them reaches.
    fn render_rows(&self, behind: impl Fn(usize) -> Behind + Sync) -> Vec<Pixel> {
        let width = self.view.size[0] as usize;
        let spheres = self.spheres();
        let rectangles: Vec<[u32; 4]> = spheres.iter().map(|s| rectangle::around(self.view, s)).collect();
        let mut of_row = vec![Vec::new(); self.view.size[1] as usize];
        for (i, [_, y0, _, y1]) in rectangles.iter().enumerate() {
            of_row[*y0 as usize..*y1 as usize].iter_mut().for_each(|row| row.push(i));
        }
        let row = |y: usize| {
            let mut of_pixel = vec![Vec::new(); width];
            for i in &of_row[y] {
                let [x0, _, x1, _] = rectangles[*i];
                of_pixel[x0 as usize..x1 as usize].iter_mut().for_each(|pixel| pixel.push(*i));
            }
            let pixel = |(x, members): (usize, Vec<usize>)| {
                let at = y * width + x;
                self.pixel(at, members.iter().map(|i| &spheres[*i]), &behind(at))
            };
            of_pixel.into_iter().enumerate().map(pixel).collect::<Vec<_>>()
        };
        parallel::gather(of_row.len(), row).concat()
    }
}
