//! The cost of exact methods on a device: `auto` chooses the cheaper of those that are exact for a scene.
//!
//! The time of a frame is modeled as a sum of non-negative costs per frame, splat, pixel of the splats' rectangles and
//! pixel of the image. They are fitted once per device, driver and version to frames of small random clouds, and kept
//! on disk. Small and large splats are fitted separately, since `abuffer` handles them differently, and so is each
//! falloff.

use glam::{DVec3, Vec3};
use serde::{Deserialize, Serialize};

use super::Renderer;
use super::lists::ORDERED_AREA;
use crate::methods::prelude::*;
use crate::points::Points;
use crate::prepare::order;

/// The factors of a frame's cost.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Load {
    /// Splats that touch the image.
    pub splats: u64,
    /// Pixels of their rectangles.
    pub area: u64,
    /// Pixels of the image.
    pub pixels: u64,
}

impl Load {
    fn terms(&self) -> [f64; TERMS] {
        [1.0, self.splats as f64 * 1e-6, self.area as f64 * 1e-6, self.pixels as f64 * 1e-6]
    }

    fn large(&self) -> bool {
        self.area >= self.splats.max(1) * ORDERED_AREA
    }
}

const TERMS: usize = 4;
/// Milliseconds per frame, million splats, million pixels of rectangles, million pixels of the image.
type Costs = [f64; TERMS];

/// The factors of a frame's cost, and its measured milliseconds.
type Sample = ([f64; TERMS], f64);

/// The fitted costs of the methods that are exact for flat discs.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Model {
    /// Costs for small and for large splats.
    abuffer: [Costs; 2],
    sorted: [Costs; 2],
}

impl Model {
    /// Returns the model of a device, from the disk or fitted now, which takes seconds.
    pub fn for_device(device: &Device, falloff: Falloff) -> Result<Self, Error> {
        let info = device.info();
        let identity = format!("{} {} {} {falloff:?} {SAMPLES:?}", env!("CARGO_PKG_VERSION"), info.name, info.driver);
        let key = blake3::hash(identity.as_bytes()).to_hex().to_string();
        let stored = crate::gpu::cache::load("costs", &key);
        if let Some(model) = stored.and_then(|bytes| serde_json::from_slice(&bytes).ok()) {
            return Ok(model);
        }
        let model = Self::fit(device, falloff)?;
        if let Ok(bytes) = serde_json::to_vec(&model) {
            crate::gpu::cache::store("costs", &key, &bytes);
        }
        Ok(model)
    }

    /// Returns the predicted milliseconds of `abuffer` and of `sorted`.
    pub fn predict(&self, load: &Load) -> [f64; 2] {
        let predicted = |costs: &[Costs; 2]| dot(&costs[usize::from(load.large())], &load.terms());
        [predicted(&self.abuffer), predicted(&self.sorted)]
    }

    fn fit(device: &Device, falloff: Falloff) -> Result<Self, Error> {
        let discs = Discs { falloff, ..Discs::default() };
        let methods = [Method::ABuffer(discs), Method::Sorted(discs)];
        let mut samples: [[Vec<Sample>; 2]; 2] = Default::default();
        let mut renderer = Renderer::new(device)?;
        for (splats, radius, side) in SAMPLES {
            let points = cloud(splats, side);
            let mut cloud = renderer.upload(&Points { radii: vec![radius; splats], ..points })?;
            let frame = frame(side, methods[0]);
            let load = renderer.load(&mut cloud, &frame, &discs)?;
            for (method, samples) in methods.into_iter().zip(&mut samples) {
                let ms = time(&mut renderer, &mut cloud, &Frame { method, ..frame })?;
                samples[usize::from(load.large())].push((load.terms(), ms));
            }
        }
        let [abuffer, sorted] = samples.map(|both| both.map(|samples| least_squares(&samples)));
        Ok(Self { abuffer, sorted })
    }
}

/// Splats, radius in pixels and side of the image of the clouds that are measured: small splats, then large ones.
const SAMPLES: [(usize, f32, u32); 12] = [
    (10_000, 0.7, 256),
    (80_000, 0.7, 256),
    (10_000, 1.8, 512),
    (80_000, 1.8, 256),
    (40_000, 1.2, 512),
    (1_000, 1.2, 512),
    (10_000, 4.0, 256),
    (60_000, 4.0, 256),
    (10_000, 9.0, 512),
    (40_000, 9.0, 512),
    (2_000, 20.0, 256),
    (1_000, 5.0, 512),
];

/// Returns the method for a frame of flat discs that are not all opaque, and the reason.
pub fn choose(
    renderer: &mut Renderer,
    cloud: &mut DeviceCloud,
    frame: &Frame,
    discs: Discs,
    why: &str,
) -> Result<(Method, String), Error> {
    let device = renderer.device().clone();
    if device.info().subgroup.is_none() {
        return Ok((Method::ABuffer(discs), format!("{why}; the device has no subgroup shuffles, which sorted needs")));
    }
    if cloud.supply().is_some() {
        return Ok((
            Method::Sorted(discs),
            format!("{why}; points are read a part at a time, and sorted needs no lists of all fragments"),
        ));
    }
    if !renderer.can_sort(cloud, frame) {
        return Ok((
            Method::ABuffer(discs),
            format!("{why}; there is not enough memory to sort {} splats", cloud.len()),
        ));
    }
    let load = renderer.load(cloud, frame, &discs)?;
    let [abuffer, sorted] = Model::for_device(&device, discs.falloff)?.predict(&load);
    let method = if sorted <= abuffer { Method::Sorted(discs) } else { Method::ABuffer(discs) };
    let each = load.area as f64 / load.splats.max(1) as f64;
    let reason = format!(
        "{why}; for {} splats of {each:.1} pixels each this device is expected to take {sorted:.0} ms with sorted and {abuffer:.0} ms with abuffer",
        load.splats
    );
    Ok((method, reason))
}

/// Points at pseudo-random places over an image of `side` pixels and at as many depths; a world unit is a pixel.
fn cloud(splats: usize, side: u32) -> Points {
    // The fractional parts of multiples of the plastic number's powers fill the cube evenly (Roberts 2018).
    let place = |i: usize, step: f64| (0.5 + (i + 1) as f64 * step).fract();
    let positions = (0..splats)
        .map(|i| {
            let x = place(i, 0.819_172_513_396_164_4) * f64::from(side);
            let y = place(i, 0.671_043_606_703_789_2) * f64::from(side);
            DVec3::new(x, -y, -1.0 - place(i, 0.549_700_477_901_970_3))
        })
        .collect();
    order::canonical(Points {
        positions,
        colors: vec![Vec3::splat(0.5); splats],
        opacities: vec![0.05; splats],
        radii: vec![1.0; splats],
        ..Points::default()
    })
}

fn frame(side: u32, method: Method) -> Frame {
    let center = DVec3::new(f64::from(side) / 2.0, -f64::from(side) / 2.0, 0.0);
    let projection = Projection::Orthographic { height: side.into() };
    let camera = Camera::look_at(center, center - DVec3::Z, DVec3::Y, projection, 0.5, 3.0)
        .expect("eye, target and up are apart");
    Frame::new(camera, [side; 2], method)
}

/// Least milliseconds of some frames after one that pays for pipelines and buffers.
fn time(renderer: &mut Renderer, cloud: &mut DeviceCloud, frame: &Frame) -> Result<f64, Error> {
    let mut least = f64::INFINITY;
    for warm in [false, true, true, true] {
        let rendered = renderer.render(cloud, frame)?;
        if warm {
            least = least.min(rendered.profile.wall.as_secs_f64() * 1e3);
        }
        renderer.recycle(rendered.image);
    }
    Ok(least)
}

fn dot(a: &[f64; TERMS], b: &[f64; TERMS]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Non-negative costs with the least squares of relative errors, by coordinate descent: each step is the exact minimum
/// along one axis, cut at zero, so that the error never grows.
fn least_squares(samples: &[Sample]) -> Costs {
    let rows: Vec<[f64; TERMS]> = samples.iter().map(|(terms, ms)| terms.map(|t| t / ms)).collect();
    let mut costs = [0.0; TERMS];
    for _ in 0..10_000 {
        for axis in 0..TERMS {
            let square: f64 = rows.iter().map(|row| row[axis] * row[axis]).sum();
            if square > 0.0 {
                let toward: f64 = rows.iter().map(|row| row[axis] * (1.0 - dot(row, &costs))).sum();
                costs[axis] = (costs[axis] + toward / square).max(0.0);
            }
        }
    }
    costs
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn costs_are_found_again_and_never_negative() {
        let loads = [(10, 40, 65), (80, 320, 65), (10, 400, 262), (80, 3200, 65), (40, 640, 262), (1, 36, 262)];
        let terms = loads.map(|(s, a, p)| Load { splats: s * 1000, area: a * 1000, pixels: p * 1000 }.terms());
        let wanted = [2.0, 150.0, 9.0, 20.0];
        let found = least_squares(&terms.map(|t| (t, dot(&t, &wanted))));
        for (found, wanted) in found.iter().zip(wanted) {
            assert!((found / wanted - 1.0).abs() < 1e-3, "{found} for {wanted}");
        }
        // A cost that would have to be negative is zero.
        let found = least_squares(&terms.map(|t| (t, dot(&t, &[30.0, -20.0, 9.0, 20.0]))));
        assert!(found.iter().all(|c| *c >= 0.0) && found[1] == 0.0, "{found:?}");
    }

    #[test]
    fn the_cheaper_one_depends_on_the_load() {
        let model = Model {
            abuffer: [[1.0, 50.0, 20.0, 0.0], [1.0, 150.0, 12.0, 0.0]],
            sorted: [[3.0, 200.0, 5.0, 0.0], [3.0, 200.0, 2.0, 0.0]],
        };
        let load = |splats, area| Load { splats, area, pixels: 1 << 20 };
        let [abuffer, sorted] = model.predict(&load(1_000_000, 4_000_000));
        assert_eq!([abuffer, sorted], [131.0, 223.0]);
        let [abuffer, sorted] = model.predict(&load(100_000, 10_000_000));
        assert_eq!([abuffer, sorted], [136.0, 43.0]);
    }
}
