//! Shadow textures: one share of light for each point, found once for a light and kept with the cloud (Dobrev et al.
//! 2010, Section 6).
//!
//! For each light that stands for an area the points' smallest depths are found per pixel of a square image, holes in
//! its surfaces filled, and all points compared with it: whoever lies more than d̃ / |n_z| behind loses that light.
//! Counts are whole numbers, so that neither chunks nor the order of lights show. Holes that the filters leave are
//! counted in the images of the first light.

mod filters;
mod images;
pub mod lights;

pub(crate) use images::{see, share};

use crate::progress::Progress;

use super::{Error, Frame, Timeline};
use crate::cloud::light_image::natural_resolution;
use crate::cloud::shadow_texture::Casting;
use crate::gpu::shader::Shader;
use crate::gpu::{Buffer, Device, Dispatch, Memory, Recorder, Run, Variant};
use crate::passes::project::{DeviceCloud, POINTS_RUN, PlacesGroup, PointsPush, Projecting, points_dispatch};
use crate::scene::{Light, ShadingModel};
use crate::{gpu_struct, pass};
use filters::HoleCount;
use lights::LightView;

gpu_struct! {
    /// Push constants: points of the chunk, and the number of lights.
    pub struct SharePush {
        count: u32, // Points of the chunk.
        lights: u32,
    }

    /// Parameters of a light for `shadows/lit`, beside its camera.
    pub struct LightFrame {
        apart: f32,
        face: u32,
    }
}

pass! {
    /// Starts the light of each point: all lights reach it. The passes of shadows run in the first frame with a light;
    /// later frames find the shares with the cloud.
    pub Start(SharePush) = "shadows/start" {
        normals: ReadWrite<[f32; 4]>,
    }

    /// Finds the pixel and depth of each point through a light's camera, and takes the 32-bit atomic minimum of the
    /// depth key there. It runs, as `shadows/clear` and `shadows/lit` do, once for each light, or for each of its six
    /// faces.
    pub Nearest(PointsPush) = "shadows/nearest" {
        places: Shared<PlacesGroup>,
        nearest: ReadWrite<u32>,
    }

    /// Finds the pixel of each point again, and takes one light from the points that lie behind the surface there by
    /// more than d̃ / |n_z|.
    pub Lit(PointsPush) = "shadows/lit" {
        places: Shared<PlacesGroup>,
        normals: ReadWrite<[f32; 4]>,
        depths: Read<f32>,
        light: Uniform<LightFrame>,
    }

    /// Turns the number of lights that reach each point into its share of light, where there are several.
    pub Share(SharePush) = "shadows/share" {
        normals: ReadWrite<[f32; 4]>,
    }
}

/// The passes, in the order of their first run.
pub const PASSES: [&str; 10] = [
    "shadows/start",
    "shadows/clear",
    "shadows/nearest",
    "shadows/reset",
    "shadows/blocks",
    "shadows/fill",
    "shadows/occlusion",
    "shadows/leaks",
    "shadows/lit",
    "shadows/share",
];

/// Rows of pixels of one invocation of a filter.
const FILL_ROWS: u64 = 8;

/// Device bytes of a pixel of a light's image: the depth before a filter, and what the filter makes of it.
const PIXEL_BYTES: u64 = 8;

/// The variant of `shadows/start` for a cloud with or without normals.
fn start_variant(normals: bool) -> Variant {
    Variant::plain().with("NORMALS", u32::from(normals))
}

/// The variant of `shadows/nearest`.
fn walk_variant() -> Variant {
    Variant::plain().with("RUN", POINTS_RUN as u32)
}

/// The variant of `shadows/lit`, with one image of a light or with six.
fn lit_variant(cube: bool) -> Variant {
    walk_variant().with("CUBE", u32::from(cube))
}

/// Returns the reason why a frame has no shadows; `None` if it has.
pub fn refusal(frame: &Frame) -> Option<String> {
    if frame.shadows.is_none() {
        Some("no shadows requested (shadows.method)".to_owned())
    } else if !frame.method.takes_shadows() {
        Some(format!("the method {} has no shadows", frame.method.name()))
    } else if frame.shading.model == ShadingModel::None {
        Some("shading is off (shading.model = \"none\"), so there are no shadows".to_owned())
    } else if frame.shading.light == Light::Headlight {
        Some("a headlight casts no shadows".to_owned())
    } else {
        None
    }
}

/// Describes the shadows of a cloud in a frame; `None` if the frame has none.
pub fn casting(frame: &Frame, cloud: &DeviceCloud) -> Option<Casting> {
    let shadows = frame.shadows.filter(|_| refusal(frame).is_none() && cloud.total() > 0)?;
    shadows.casting(frame.shading.light, frame.seed, (&cloud.bounds(), cloud.drawn()))
}

/// Columns and rows at which a pixel of a light's image holds about one point.
fn natural(casting: &Casting, cloud: &DeviceCloud) -> f64 {
    natural_resolution(&casting.light, &cloud.bounds(), cloud.drawn())
}

/// Returns images of the scene that a casting takes: one for each light, or six.
pub fn image_count(casting: &Casting, cloud: &DeviceCloud) -> u64 {
    views(casting, cloud).map(|views| views.len() as u64).sum()
}

/// The images of each light.
fn views(casting: &Casting, cloud: &DeviceCloud) -> impl Iterator<Item = Vec<LightView>> + use<> {
    let (casting, bounds) = (*casting, cloud.bounds());
    let views = move |light| lights::views(light, &bounds, casting.resolution, casting.reach());
    (0..casting.samples).map(move |i| views(lights::light(&casting, &bounds, i)))
}

/// Pixels of a row in memory: four of them are read at a time.
fn pitch(resolution: u32) -> u64 {
    u64::from(resolution).next_multiple_of(4)
}

/// Device bytes of a light's images.
fn image_bytes(resolution: u32) -> u64 {
    pitch(resolution) * u64::from(resolution) * PIXEL_BYTES
}

/// Device bytes of so many depths.
fn light_bytes(depths: u64) -> u64 {
    depths.saturating_mul(size_of::<f32>() as u64)
}

/// Refuses images that no binding holds, or that don't fit the budget.
fn check(resolution: u32, binding: u64, budget: u64) -> Result<(), Error> {
    let fits = |resolution| image_bytes(resolution) <= budget.min(binding.saturating_mul(2));
    if fits(resolution) {
        return Ok(());
    }
    let largest = (1..resolution).rev().find(|smaller| fits(*smaller)).unwrap_or(0);
    let needed = image_bytes(resolution);
    Err(Error::ShadowImage { resolution, needed, budget, binding, largest })
}

/// Makes the shadow texture of a cloud that is on the device. `how` is that of any frame: nothing of it shows.
pub fn cast(
    device: &Device,
    cloud: &mut DeviceCloud,
    (casting, how): (&Casting, &Projecting),
    budget: u64,
    progress: &Progress,
    timeline: &mut Timeline,
) -> Result<(), Error> {
    let resolution = casting.resolution;
    check(resolution, device.limits().binding_bytes, budget)?;
    cloud.reserve_shares(device)?;
    let images = [light_image(device, resolution)?, light_image(device, resolution)?];
    let rest = budget.saturating_sub(image_bytes(resolution));
    let count = HoleCount::new(device, casting, natural(casting, cloud), rest)?;
    let mut frame = device.buffer("light", 1, Memory::Upload)?;
    start(device, cloud, casting, timeline)?;
    progress.set_length(u64::from(casting.samples));
    progress.set_position(0);
    for (light, views) in views(casting, cloud).enumerate() {
        for (face, view) in views.into_iter().enumerate() {
            let counted = count.as_ref().filter(|_| light == 0);
            frame.write(&[LightFrame { apart: casting.min_layer_distance, face: view.face.unwrap_or(0) }]);
            look(cloud, &view, resolution, how);
            let mut recorder = device.recorder()?;
            cloud.record_view(&mut recorder);
            recorder.fill("shadows/clear", images[0].all(), u32::MAX)?;
            record_nearest(&mut recorder, cloud, &images[0])?;
            record_surfaces(&mut recorder, images.each_ref(), casting, counted.map(|count| (count, face == 0)))?;
            record_lit(&mut recorder, cloud, &images[filters::last(casting)], (&frame, view.face.is_some()))?;
            timeline.submit(recorder, "shadows/lit")?;
        }
        progress.inc(1);
    }
    finish(device, cloud, casting, timeline)?;
    cloud.set_light_holes(count.map(|count| count.found()).transpose()?);
    Ok(())
}

/// A light's image: keys of the nearest depths, and after the filters the bits of the depths of surfaces.
fn light_image(device: &Device, resolution: u32) -> Result<Buffer<u32>, Error> {
    Ok(device.buffer("depths from a light", pitch(resolution) * u64::from(resolution), Memory::Device)?)
}

/// Sets the cloud's view to that of a light.
fn look(cloud: &mut DeviceCloud, view: &LightView, resolution: u32, how: &Projecting) {
    let window = [0, 0, pitch(resolution) as u32, resolution];
    cloud.set_view(&view.camera, [resolution; 2], window, how);
}

/// All lights reach each point of the cloud that is on the device.
fn start(device: &Device, cloud: &DeviceCloud, casting: &Casting, timeline: &mut Timeline) -> Result<(), Error> {
    let mut recorder = device.recorder()?;
    for (first, count) in cloud.chunks() {
        let start = Start { normals: cloud.normals.slice(first, count) };
        let push = SharePush { count: count as u32, lights: casting.samples };
        let run = Run::new(Dispatch::Invocations(count));
        recorder.run(&start, push, &run.variant(start_variant(cloud.has_normals())))?;
    }
    timeline.submit(recorder, "shadows/start")
}

/// Makes shares of the numbers of lights.
fn finish(device: &Device, cloud: &mut DeviceCloud, casting: &Casting, timeline: &mut Timeline) -> Result<(), Error> {
    if casting.samples > 1 {
        let mut recorder = device.recorder()?;
        for (first, count) in cloud.chunks() {
            let share = Share { normals: cloud.normals.slice(first, count) };
            let push = SharePush { count: count as u32, lights: casting.samples };
            recorder.run(&share, push, &Run::new(Dispatch::Invocations(count)))?;
        }
        timeline.submit(recorder, "shadows/share")?;
    }
    cloud.set_casting(*casting);
    Ok(())
}

/// A run of the passes over points.
fn walk<'a>((_, count): (u64, u64)) -> Run<'a> {
    Run::new(points_dispatch(count))
}

/// Records what an image has of the points on the device, through the cloud's view.
fn record_nearest<'a>(
    recorder: &mut Recorder<'a>,
    cloud: &'a DeviceCloud,
    image: &'a Buffer<u32>,
) -> Result<(), Error> {
    for (chunk, range) in cloud.chunks().enumerate() {
        let nearest = Nearest { places: cloud.places(range.0, range.1), nearest: image.all() };
        recorder.run(&nearest, PointsPush::new(chunk, range), &walk(range).variant(walk_variant()))?;
    }
    Ok(())
}

/// Records the surfaces of an image of keys, the first of both, and counts their holes if asked to; `true` with the
/// first image that is counted.
fn record_surfaces<'a>(
    recorder: &mut Recorder<'a>,
    images: [&'a Buffer<u32>; 2],
    casting: &Casting,
    count: Option<(&'a HoleCount, bool)>,
) -> Result<(), Error> {
    if let Some((count, first)) = count {
        if first {
            count.record_clear(recorder)?;
        }
        count.record_blocks(recorder, images[0])?;
    }
    filters::record(recorder, images, casting)?;
    count.map_or(Ok(()), |(count, _)| count.record_leaks(recorder, images[filters::last(casting)]))
}

/// Records what an image keeps from the points on the device, through the cloud's view.
fn record_lit<'a>(
    recorder: &mut Recorder<'a>,
    cloud: &'a DeviceCloud,
    depths: &'a Buffer<u32>,
    (light, cube): (&'a Buffer<LightFrame>, bool),
) -> Result<(), Error> {
    for (chunk, range) in cloud.chunks().enumerate() {
        let lit = Lit {
            places: cloud.places(range.0, range.1),
            normals: cloud.normals.slice(range.0, range.1),
            depths: depths.all().cast(),
            light: light.all(),
        };
        recorder.run(&lit, PointsPush::new(chunk, range), &walk(range).variant(lit_variant(cube)))?;
    }
    Ok(())
}

/// Returns the number of bytes that one of the passes must at least read and write in its `runs`, for `points` points
/// and a light's image of `resolution` pixels squared.
pub fn least_bytes(name: &str, runs: u64, points: u64, chunks: u64, resolution: u32) -> Option<u64> {
    let pixels = pitch(resolution) * u64::from(resolution);
    // A run is one chunk's.
    let walks = runs / chunks.max(1);
    match name {
        "shadows/start" | "shadows/share" => Some(points * 32),
        "shadows/clear" => Some(runs * pixels * 4),
        // Position, and the pixel read and written.
        "shadows/nearest" => Some(walks * points * (32 + 8)),
        "shadows/fill" | "shadows/occlusion" => Some(runs * pixels * 8),
        // Blocks are few, at least one, and so are the counts.
        "shadows/reset" => Some(runs * 4),
        "shadows/blocks" | "shadows/leaks" => Some(runs * pixels * 4),
        // Position, normal and depth; who is in the dark is not known.
        "shadows/lit" => Some(walks * points * (32 + 16 + 4)),
        _ => None,
    }
}

/// Returns the passes with their variants.
pub fn shaders() -> Vec<Shader> {
    vec![
        Shader::new::<Start>([false, true].map(start_variant)),
        Shader::new::<Nearest>([walk_variant()]),
        Shader::new::<Lit>([false, true].map(lit_variant)),
        Shader::plain::<Share>(),
    ]
    .into_iter()
    .chain(filters::shaders())
    .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_image_that_does_not_fit_names_one_that_would() {
        let (plenty, mebibyte) = (u64::MAX, 1 << 20);
        assert!(check(1024, plenty, plenty).is_ok());
        assert!(check(1024, 4 * mebibyte, 8 * mebibyte).is_ok());
        // 4 bytes a pixel in each of two bindings.
        for (binding, budget) in [(4 * mebibyte - 1, plenty), (plenty, 8 * mebibyte - 1)] {
            match check(1024, binding, budget) {
                Err(Error::ShadowImage { largest: 1023, .. }) => assert!(check(1023, binding, budget).is_ok()),
                other => panic!("{other:?}"),
            }
        }
        assert!(matches!(check(64, plenty, 0), Err(Error::ShadowImage { largest: 0, .. })));
    }
}
