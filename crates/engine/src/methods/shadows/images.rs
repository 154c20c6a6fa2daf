//! Shadows of clouds whose points come to the device some at a time: all points are shown to the lights first, whose
//! images stay on the device. Then the points of each window find their shares of light in them.

use std::sync::Arc;

use super::filters::{self, HoleCount};
use super::lights::LightView;
use super::{
    LightFrame, check, finish, light_image, look, natural, pitch, record_lit, record_nearest, record_surfaces, start,
    views,
};
use crate::cloud::shadow_texture::Casting;
use crate::gpu::{Device, Memory};
use crate::methods::{Error, Timeline};
use crate::passes::project::{DeviceCloud, LightImages, Projecting};
use crate::progress::Progress;

/// Device bytes of so many images, and of one more that is being filled.
fn bytes(count: u64, resolution: u32) -> u64 {
    (count + 1).saturating_mul(4 * pitch(resolution) * u64::from(resolution))
}

/// Refuses images that don't fit the budget together.
fn check_all(count: u64, resolution: u32, budget: u64) -> Result<(), Error> {
    let needed = bytes(count, resolution);
    if needed <= budget {
        return Ok(());
    }
    let largest = (1..resolution).rev().find(|smaller| bytes(count, *smaller) <= budget).unwrap_or(0);
    Err(Error::ShadowImages { count, resolution, needed, budget, largest })
}

/// Makes the images of all lights from all points, at most `room` of them on the device at a time. `how` is that of any
/// frame.
pub(crate) fn see(
    device: &Device,
    cloud: &mut DeviceCloud,
    (casting, how): (&Casting, &Projecting),
    (budget, room): (u64, u64),
    progress: &Progress,
    timeline: &mut Timeline,
) -> Result<(), Error> {
    let resolution = casting.resolution;
    let views: Vec<LightView> = views(casting, cloud).flatten().collect();
    check(resolution, device.limits().binding_bytes, u64::MAX)?;
    check_all(views.len() as u64, resolution, budget)?;
    cloud.set_light_images(None);
    let images = views.iter().map(|_| light_image(device, resolution)).collect::<Result<Vec<_>, Error>>()?;
    let mut recorder = device.recorder()?;
    images.iter().try_for_each(|image| recorder.fill("shadows/clear", image.all(), u32::MAX))?;
    timeline.submit(recorder, "shadows/clear")?;
    progress.set_message("casting shadows");
    progress.set_length(cloud.total());
    progress.set_position(0);
    cloud.show_all(device, room, progress, |cloud| -> Result<(), Error> {
        for (view, image) in views.iter().zip(&images) {
            look(cloud, view, resolution, how);
            let mut recorder = device.recorder()?;
            cloud.record_view(&mut recorder);
            record_nearest(&mut recorder, cloud, image)?;
            timeline.submit(recorder, "shadows/nearest")?;
        }
        progress.inc(cloud.len());
        Ok(())
    })?;
    let rest = budget.saturating_sub(bytes(views.len() as u64, resolution));
    let count = HoleCount::new(device, casting, natural(casting, cloud), rest)?;
    let of_first_light = super::views(casting, cloud).next().map_or(0, |views| views.len());
    let mut depths = Vec::with_capacity(images.len());
    let mut spare = light_image(device, resolution)?;
    for (i, mut image) in images.into_iter().enumerate() {
        let counted = count.as_ref().filter(|_| i < of_first_light);
        let mut recorder = device.recorder()?;
        record_surfaces(&mut recorder, [&image, &spare], casting, counted.map(|count| (count, i == 0)))?;
        timeline.submit(recorder, "shadows/occlusion")?;
        if filters::last(casting) == 1 {
            std::mem::swap(&mut image, &mut spare);
        }
        depths.push(image);
    }
    let holes = count.map(|count| count.found()).transpose()?;
    cloud.set_light_images(Some(Arc::new(LightImages { casting: *casting, depths, holes })));
    Ok(())
}

/// Finds the shares of light of the points on the device in the images, unless they have them.
pub(crate) fn share(
    device: &Device,
    cloud: &mut DeviceCloud,
    how: &Projecting,
    timeline: &mut Timeline,
) -> Result<(), Error> {
    let Some(images) = cloud.light_images().cloned() else { return Ok(()) };
    let casting = &images.casting;
    if cloud.casting() == Some(casting) {
        return Ok(());
    }
    cloud.reserve_shares(device)?;
    start(device, cloud, casting, timeline)?;
    let mut frame = device.buffer("light", 1, Memory::Upload)?;
    for (view, depths) in views(casting, cloud).flatten().zip(&images.depths) {
        frame.write(&[LightFrame { apart: casting.min_layer_distance, face: view.face.unwrap_or(0) }]);
        look(cloud, &view, casting.resolution, how);
        let mut recorder = device.recorder()?;
        cloud.record_view(&mut recorder);
        record_lit(&mut recorder, cloud, depths, (&frame, view.face.is_some()))?;
        timeline.submit(recorder, "shadows/lit")?;
    }
    finish(device, cloud, casting, timeline)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn images_that_do_not_fit_together_name_some_that_would() {
        // 4 bytes a pixel, three images and one more.
        let needed = 4 * 4 * 64 * 64;
        assert!(check_all(3, 64, needed).is_ok());
        match check_all(3, 64, needed - 1) {
            // Rows are multiples of four pixels in memory.
            Err(Error::ShadowImages { count: 3, largest: 63, needed: told, .. }) => assert_eq!(told, needed),
            other => panic!("{other:?}"),
        }
        assert!(matches!(check_all(3, 64, 0), Err(Error::ShadowImages { largest: 0, .. })));
    }
}
