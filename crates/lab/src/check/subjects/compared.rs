//! Subjects of the comparison of drivers: larger images, and settings whose arithmetic no other subject has.

use super::{
    BlendedSplats, Discs, Frame, GaussianSettings, ImageSpace, Interpolated, Iterations, Kernel, Method, MethodScene,
    Mlab, Moments, PeelLayers, Raster, ScreenSplats, Soft, Stochastic, Wavelet, as_it_is, clouds, lit, orthographic,
    shadowed, subject, subjects,
};

/// Columns and rows: no multiple of a tile in both.
const SIZE: [u32; 2] = [264, 198];

/// Returns every subject of [`subjects`] and some more, with images of 264 × 198 pixels.
pub fn compared() -> Vec<MethodScene> {
    let larger = |subject: MethodScene| subject.with(Frame { size: SIZE, ..subject.frame });
    [subjects(), opaque(), gaussians(), others()].concat().into_iter().map(larger).collect()
}

/// Eye-dome lighting beside what the frame has.
fn domed(frame: &mut Frame) {
    frame.shading.edl.edl = true;
}

fn opaque() -> Vec<MethodScene> {
    let splats = ScreenSplats { size: 1.5, ..ScreenSplats::default() };
    let fixed = Interpolated { splats: ScreenSplats { pixel_radius: Some(3.5), ..splats }, ..Interpolated::default() };
    let filled = ImageSpace { fill: Iterations::Auto, occlusion: Iterations::Auto, ..ImageSpace::default() };
    let (few, surfaces) = (clouds::few, clouds::surfaces);
    vec![
        subject(Method::Circles(splats), "eye-dome lighting", few(), domed),
        subject(Method::Paraboloid(fixed), "radii in pixels", few(), lit),
        subject(Method::Splats(BlendedSplats { splats, ..BlendedSplats::default() }), "shadows", few(), shadowed),
        subject(Method::ImageSpace(filled), "shadows, all holes filled", surfaces(), shadowed),
        subject(Method::PeelLayers(PeelLayers { only: Some(2), ..PeelLayers::default() }), "layer 2", surfaces(), lit),
    ]
}

fn gaussians() -> Vec<MethodScene> {
    let by_ray = GaussianSettings { kernel: Kernel::Ray, ..GaussianSettings::default() };
    let by_ray = Discs { gaussians: by_ray, raster: Raster::Compute, ..Discs::default() };
    let (few, many, mixed) = (clouds::few_gaussians, clouds::many_gaussians, clouds::mixed);
    let stochastic = Stochastic { discs: by_ray, samples: 24, alpha_correction: true };
    vec![
        subject(Method::Moments(Moments { discs: by_ray, ..Moments::default() }), "Gaussians by ray", many(), as_it_is),
        subject(Method::Wavelet(Wavelet::default()), "Gaussians and discs", mixed(), as_it_is),
        subject(Method::Mlab(Mlab::default()), "Gaussians and discs", mixed(), as_it_is),
        subject(Method::Stochastic(stochastic), "Gaussians by ray, compute", few(), orthographic),
    ]
}

fn others() -> Vec<MethodScene> {
    let modulated = Soft { modulation: Some(0.9), ..Soft::default() };
    vec![
        subject(Method::ABuffer(Discs::default()), "eye-dome lighting", clouds::many(), domed),
        subject(Method::SoftConcentric(modulated), "modulated", clouds::soft_alone(), as_it_is),
        subject(Method::SoftExpress(modulated), "modulated", clouds::soft_alone(), orthographic),
    ]
}

#[cfg(test)]
mod tests {
    use std::collections::HashSet;

    use super::*;

    #[test]
    fn images_are_large_and_their_names_differ() {
        let all = compared();
        assert!(all.iter().all(|subject| subject.frame.size[0] >= 256 && subject.frame.size[1] >= 192));
        assert_eq!(all.iter().map(|subject| &subject.name).collect::<HashSet<_>>().len(), all.len());
        assert_eq!(all.len(), subjects().len() + 12);
    }
}
