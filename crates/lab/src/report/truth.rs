//! Exact images as the float64 reference has them: some pixels of discs, all of soft spheres and of what ensembles tend
//! to.

use rand::{SeedableRng, seq};
use rand_pcg::Pcg64;

use super::stress::Deviation;
use pellucid_core::image::Image;
use pellucid_core::points::Points;
use pellucid_engine::methods::{Error, Frame, Renderer};
use pellucid_gpu::Device;
use pellucid_reference::View;
use pellucid_reference::abuffer::{Composite, composite, lists_at};
use pellucid_reference::shading::shade;
use pellucid_reference::soft::{Behind, Model, Scene};
use pellucid_scene::{Density, Method, Soft, SoftMethod};
use pellucid_session::area;
use pellucid_session::choice::image_of;

/// Pixels that are compared with the reference; of a smaller image all.
const SAMPLE: usize = 256;
/// Pairs of soft spheres that are open at the same time, of all pixels that are compared: their number is quadratic in
/// the layers. They take a second or so.
const OPEN_PAIRS: usize = 1 << 22;
/// The fewest pixels.
const FEWEST: usize = 4;

/// A random sample of pixels.
pub(super) struct Truth {
    /// Row by row, ascending.
    pixels: Vec<usize>,
    /// Premultiplied R, G, B and A.
    values: Vec<[f64; 4]>,
}

fn pixel(composite: &Composite) -> [f64; 4] {
    composite.color.extend(composite.alpha).to_array()
}

/// Some pixels of an image, row by row.
fn sample(frame: &Frame, most: usize, seed: u64) -> Vec<usize> {
    let count = frame.size[0] as usize * frame.size[1] as usize;
    let mut pixels = seq::index::sample(&mut Pcg64::seed_from_u64(seed), count, most.min(count)).into_vec();
    pixels.sort_unstable();
    pixels
}

impl Truth {
    /// The reference for a frame of discs.
    pub fn new(points: &Points, frame: &Frame, seed: u64) -> Self {
        let pixels = sample(frame, SAMPLE, seed);
        let colors = shade(points, &frame.camera, &frame.shading, frame.color);
        let discs = frame.method.discs().copied().unwrap_or_default();
        let values = area::mean(frame, |image| {
            let lists = lists_at(View::new(&image.camera, image.size), points, &discs, &pixels);
            lists.iter().map(|list| pixel(&composite(list, &colors))).collect()
        });
        Self { pixels, values }
    }

    /// The reference for a frame of soft spheres without solid points, about so many of them on each ray.
    pub fn of_spheres(points: &Points, frame: &Frame, method: SoftMethod, layers: u32, seed: u64) -> Self {
        let pairs = (layers as usize).pow(2).max(1);
        let pixels = sample(frame, (OPEN_PAIRS / pairs).clamp(FEWEST, SAMPLE), seed);
        let colors = shade(points, &frame.camera, &frame.shading, frame.color);
        let view = View::new(&frame.camera, frame.size);
        let scene = Scene { view, points, colors: &colors, model: Model::new(method, points) };
        let found = scene.render_at(&pixels, |_| Behind::NOTHING);
        Self { pixels, values: found.iter().map(|p| p.color.extend(p.alpha).to_array()).collect() }
    }

    /// The error of an image against it. `roundings` stand beside the standard errors, which may be 0.
    pub fn deviation(&self, image: &Image, roundings: f64) -> Deviation {
        let (mut max, mut squares) = (0f64, 0f64);
        for (pixel, truth) in self.pixels.iter().zip(&self.values) {
            for (channel, (value, truth)) in image.rgba[*pixel].iter().zip(truth).enumerate() {
                // NaN must not pass as no difference.
                let difference =
                    Some((f64::from(*value) - truth).abs()).filter(|d| !d.is_nan()).unwrap_or(f64::INFINITY);
                max = max.max(difference);
                squares += if channel < 3 { difference * difference } else { 0.0 };
            }
        }
        let rmse = (squares / (3 * self.pixels.len()) as f64).sqrt();
        let standard_errors = self.standard_error(image).map(|stated| rmse / stated.hypot(roundings));
        Deviation { max, rmse, pixels: self.pixels.len(), standard_errors }
    }

    /// Root mean square of the standard errors of these pixels, if the image has some.
    fn standard_error(&self, image: &Image) -> Option<f64> {
        let stated = image.stderr.as_deref()?;
        let squares: f64 = self.pixels.iter().flat_map(|pixel| stated[*pixel]).map(|e| f64::from(e).powi(2)).sum();
        Some((squares / (3 * self.pixels.len()) as f64).sqrt())
    }
}

/// Soft spheres in float64, before the solid points as the device splats them; `None` for another method.
pub(super) fn soft_spheres(device: &Device, points: &Points, frame: &Frame) -> Result<Option<Image>, Error> {
    let Some(method) = frame.method.as_soft() else { return Ok(None) };
    let model = Model::new(method, points);
    let solids = solids(device, points, &model.soft, frame)?;
    let colors = shade(points, &frame.camera, &frame.shading, frame.color);
    let picture = area::mean_picture(frame, |image| {
        let solids = match image.only {
            Some(index) => solids.get(index as usize),
            None => solids.first(),
        };
        let scene = Scene { view: View::new(&image.camera, image.size), points, colors: &colors, model };
        scene.render(|pixel| solids.map_or(Behind::NOTHING, |image| behind(image, pixel)))
    });
    Ok(Some(image_of(&picture)))
}

/// The pictures of the solid points alone, one for each image of the frame, as the device shows them behind soft points
/// of zero density; none without solid points.
fn solids(device: &Device, points: &Points, soft: &Soft, frame: &Frame) -> Result<Vec<Image>, Error> {
    if points.fields.iter().all(|field| *field > soft.threshold) && !points.fields.is_empty() {
        return Ok(Vec::new());
    }
    let method = Method::SoftBase(Soft { threshold: soft.threshold, density: Density::Lambda(0.0), ..Soft::default() });
    let mut renderer = Renderer::new(device)?;
    let mut cloud = renderer.upload(points)?;
    let frame = Frame { method, ..*frame };
    let images = match frame.samples {
        1 => vec![frame],
        count => (0..count).map(|index| frame.image(index)).collect(),
    };
    images.iter().map(|image| Ok(renderer.render(&mut cloud, image)?.image)).collect()
}

fn behind(image: &Image, pixel: usize) -> Behind {
    let [r, g, b, alpha] = image.rgba[pixel].map(f64::from);
    Behind { color: glam::DVec3::new(r, g, b), alpha, depth: f64::from(image.depth[pixel]) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_wrong_pixel_shows_and_so_does_none_at_all() {
        let truth = Truth { pixels: vec![0, 3], values: vec![[1.0; 4]; 2] };
        let image = |rgba: [f32; 4]| Image {
            width: 4,
            height: 1,
            rgba: vec![[1.0; 4], [0.0; 4], [0.0; 4], rgba],
            depth: vec![1.0; 4],
            ..Image::default()
        };
        let same = Deviation { max: 0.0, rmse: 0.0, pixels: 2, standard_errors: None };
        assert_eq!(truth.deviation(&image([1.0; 4]), 0.0), same);
        // One of six channels is off by 0.5; A counts only for the largest difference.
        let Deviation { max, rmse, .. } = truth.deviation(&image([1.0, 0.5, 1.0, 0.25]), 0.0);
        assert!(max == 0.75 && (rmse - (0.25f64 / 6.0).sqrt()).abs() < 1e-15);
        assert_eq!(truth.deviation(&image([f32::NAN; 4]), 0.0).max, f64::INFINITY);
        // All six are stated to be off by 0.125 or so: sqrt(0.25 / 6) / 0.125. Pixels apart from the two don't count.
        let stated = vec![[0.125; 3], [9.0; 3], [9.0; 3], [0.125; 3]];
        let noisy = Image { stderr: Some(stated), ..image([1.0, 0.5, 1.0, 0.25]) };
        let found = truth.deviation(&noisy, 0.0).standard_errors.unwrap();
        assert!((found - (0.25f64 / 6.0).sqrt() / 0.125).abs() < 1e-12);
        // Roundings of 0.125 beside them: √2 times as much is explained.
        let beside = truth.deviation(&noisy, 0.125).standard_errors.unwrap();
        assert!((found / beside - 2f64.sqrt()).abs() < 1e-12);
    }
}
