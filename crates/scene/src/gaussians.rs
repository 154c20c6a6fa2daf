//! Gaussians of a cloud's file as the scene draws them.

use glam::Vec3;

use super::scene::Scene;
use super::settings::{CloudSettings, Kernel};
use pellucid_core::cloud::Cloud;
use pellucid_core::cloud::filter::Filter;
use pellucid_core::cloud::gaussians::{self, Gaussians};
use pellucid_core::color::encode_srgb_f64;
use pellucid_core::parallel;

/// Returns `true` if a cloud's points are drawn as the Gaussians that its file has.
pub(super) fn are_drawn(scene: &Scene, settings: &CloudSettings, cloud: &Cloud) -> bool {
    cloud.gaussians.is_some() && scene.draws_gaussians(settings)
}

/// Returns the note that a cloud's Gaussians were trained with a filter on the image that the scene lacks, unless the
/// scene says so itself.
pub(super) fn filter_note(scene: &Scene, settings: &CloudSettings, cloud: &Cloud) -> Option<String> {
    let method = scene.method.representative();
    let own = method.discs().filter(|_| are_drawn(scene, settings, cloud))?.gaussians;
    let lacks = cloud.filter == Some(Filter::Mip) && own.kernel == Kernel::Ewa && !own.antialias;
    (lacks && !scene.states("method", "antialias")).then(|| {
        "these splats were trained with the filter of Mip-Splatting, without which small ones look bold; method.antialias = \
         true (--set method.antialias=true) applies it, and method.dilation is what they were trained with: 0.1 by \
         Mip-Splatting itself, 0.3 by most other programs"
            .to_owned()
    })
}

/// Source of the colors of a cloud's points.
#[derive(Clone, Copy)]
pub(super) struct Paint<'a> {
    /// Linear colors of all points.
    pub colors: &'a [Vec3],
    /// False if the scene gives them, and not the file.
    pub own: bool,
}

/// Returns the note that radii which the scene gives say nothing of Gaussians.
pub(super) fn radius_note(scene: &Scene, settings: &CloudSettings, cloud: &Cloud) -> Option<String> {
    let of_class = settings.class.iter().any(|entry| entry.radius.is_some());
    let key = [(settings.radius.is_some(), "radius"), (of_class, "class.radius")].into_iter().find(|(is, _)| *is)?.1;
    are_drawn(scene, settings, cloud).then(|| {
        format!("`{key}` has no effect on Gaussians, whose file gives their extents; `radius_factor` multiplies these")
    })
}

/// Returns the Gaussians of a cloud in the scene. `painted` tells of a point whether a class gives it another color
/// than the file.
pub(super) fn placed(
    settings: &CloudSettings,
    gaussians: &Gaussians,
    paint: Paint<'_>,
    painted: impl Fn(usize) -> bool + Sync,
) -> Gaussians {
    let degree = settings.sh_degree.map_or(gaussians.degree, |most| most.min(gaussians.degree));
    let degree = if paint.own { degree } else { 0 };
    let mut placed = gaussians.clone().with_degree(degree);
    let growth = growth(settings);
    if growth != 1.0 {
        parallel::for_each_mut(&mut placed.extents, |_, extents| *extents = scaled(*extents, growth));
    }
    let own = |i: usize| paint.own && !painted(i);
    parallel::for_each_mut(&mut placed.bases, |i, base| {
        if !own(i) {
            let linear = paint.colors[i];
            *base = if gaussians.is_linear(i) { linear } else { linear.to_array().map(display).into() };
        }
    });
    let count = placed.coefficients().max(1);
    parallel::for_each_mut(&mut placed.harmonics, |i, harmonic| {
        if !own(i / count) {
            *harmonic = Vec3::ZERO;
        }
    });
    placed
}

/// The factor on the extents of a cloud's Gaussians.
fn growth(settings: &CloudSettings) -> f64 {
    settings.scale * f64::from(settings.radius_factor)
}

/// Returns the largest reach of a Gaussian, as the cloud's settings have it.
pub(super) fn reach(extents: Vec3, settings: &CloudSettings) -> f32 {
    gaussians::reach(scaled(extents, growth(settings)))
}

/// Returns the same of one that reaches so far in its file.
pub(super) fn scaled_reach(reach: f32, settings: &CloudSettings) -> f32 {
    ((f64::from(reach) * growth(settings)) as f32).min(f32::MAX)
}

/// Returns the display value of a linear component.
pub(super) fn display(linear: f32) -> f32 {
    encode_srgb_f64(linear.into()) as f32
}

fn scaled(extents: Vec3, factor: f64) -> Vec3 {
    // One beyond float32 is as large as float32 can say.
    extents.to_array().map(|extent| ((f64::from(extent) * factor) as f32).min(f32::MAX)).into()
}

/// Returns the largest reach of each Gaussian.
pub(super) fn radii(all: &Gaussians) -> Vec<f32> {
    parallel::map_each(&all.extents, |extents| gaussians::reach(*extents))
}

#[cfg(test)]
mod tests {
    use glam::Quat;

    use super::*;
    use pellucid_core::cloud::gaussians::{ColorCoding, REACH};

    fn two() -> Gaussians {
        Gaussians {
            extents: vec![Vec3::ONE, Vec3::new(3.0, 2.0, 0.0)],
            rotations: vec![Quat::IDENTITY; 2],
            bases: vec![Vec3::splat(0.25), Vec3::splat(1.5)],
            coding: ColorCoding::Display,
            degree: 1,
            harmonics: vec![Vec3::ONE; 6],
        }
    }

    #[test]
    fn scale_and_degree_and_colors_of_the_scene_hold() {
        let colors = [Vec3::ONE, Vec3::ONE];
        let settings = CloudSettings { scale: 2.0, ..CloudSettings::default() };
        let own = placed(&settings, &two(), Paint { colors: &colors, own: true }, |i| i == 1);
        assert_eq!(
            (own.extents[1], own.bases[0], own.bases[1]),
            (Vec3::new(6.0, 4.0, 0.0), Vec3::splat(0.25), Vec3::ONE)
        );
        assert_eq!((own.harmonics_of(0)[0], own.harmonics_of(1)[2]), (Vec3::ONE, Vec3::ZERO));
        let larger = CloudSettings { radius_factor: 1.5, ..settings };
        let grown = placed(&larger, &two(), Paint { colors: &colors, own: true }, |_| false);
        assert_eq!(grown.extents[1], Vec3::new(9.0, 6.0, 0.0));
        assert_eq!(reach(two().extents[1], &larger), scaled_reach(gaussians::reach(two().extents[1]), &larger));
        let settings = CloudSettings { sh_degree: Some(0), ..CloudSettings::default() };
        assert!(placed(&settings, &two(), Paint { colors: &colors, own: true }, |_| false).harmonics.is_empty());
        let given = placed(&settings, &two(), Paint { colors: &colors, own: false }, |_| false);
        assert_eq!((given.degree, given.bases[0]), (0, Vec3::ONE));
        let (half, linear) = ([Vec3::splat(0.5); 2], Gaussians { coding: ColorCoding::Linear, ..two() });
        let of = |all: &Gaussians| placed(&settings, all, Paint { colors: &half, own: false }, |_| false).bases[0].x;
        assert!(of(&linear) == 0.5 && (of(&two()) - 0.735_357).abs() < 1e-6, "the scene's color is linear");
        assert_eq!(radii(&two())[1], 3.0 * REACH);
    }

    fn scene_of(text: &str) -> Scene {
        let text = format!("[[cloud]]\npath = 'a.ply'\n{text}");
        Scene::from_toml(&text, "s.toml".as_ref()).unwrap_or_else(|error| panic!("{text}: {error}"))
    }

    #[test]
    fn splats_trained_with_a_filter_want_its_keys() {
        let cloud = |filter| Cloud { filter, gaussians: Some(two()), ..Cloud::default() };
        let note = |text: &str, filter| {
            let scene = scene_of(text);
            filter_note(&scene, &scene.clouds[0], &cloud(filter))
        };
        let said = note("", Some(Filter::Mip)).unwrap();
        assert!(said.contains("method.antialias") && said.contains("method.dilation"), "{said}");
        assert!(note("[method]\nname = 'sorted'\ndilation = 0.1", Some(Filter::Mip)).is_some());
        for (text, filter) in [
            ("", None),
            ("", Some(Filter::Plain)),
            ("[method]\nantialias = true", Some(Filter::Mip)),
            ("[method]\nantialias = false", Some(Filter::Mip)),
            ("[method]\nkernel = 'ray'", Some(Filter::Mip)),
            ("[method]\nname = 'points'", Some(Filter::Mip)),
            ("primitive = 'points'", Some(Filter::Mip)),
        ] {
            assert_eq!(note(text, filter), None, "{text}");
        }
    }

    #[test]
    fn radii_that_splats_have_no_use_for_are_told() {
        let cloud = Cloud { gaussians: Some(two()), ..Cloud::default() };
        let note = |text: &str| {
            let scene = scene_of(text);
            radius_note(&scene, &scene.clouds[0], &cloud)
        };
        assert!(note("radius = 0.5").unwrap().starts_with("`radius` has no effect on Gaussians"));
        let of_class = "[[cloud.class]]\nid = 2\nradius = 0.5";
        assert!(note(of_class).unwrap().starts_with("`class.radius` has no effect on Gaussians"));
        for text in
            ["", "radius_factor = 0.5", "primitive = 'points'\nradius = 0.5", "[[cloud.class]]\nid = 2\nopacity = 0"]
        {
            assert_eq!(note(text), None, "{text}");
        }
    }

    #[test]
    fn gaussians_alone_decide_the_space_of_blending() {
        use pellucid_core::color::ColorSpace::{Encoded, Linear};
        let clouds = |codings: &[ColorCoding]| -> Vec<Cloud> {
            let cloud = |coding: &ColorCoding| Gaussians { coding: coding.clone(), ..two() };
            codings.iter().map(|coding| Cloud { gaussians: Some(cloud(coding)), ..Cloud::default() }).collect()
        };
        let settled = |text: &str, clouds: &[Cloud]| {
            let mut scene = scene_of(text);
            (scene.settle(clouds), scene.image.color_space())
        };
        let (display, linear) = (ColorCoding::Display, ColorCoding::Linear);
        let two_clouds = "[[cloud]]\npath = 'b.ply'";
        assert_eq!(settled("", &clouds(std::slice::from_ref(&display))), (Some(Encoded), Encoded));
        assert_eq!(settled("", &clouds(std::slice::from_ref(&linear))), (Some(Linear), Linear));
        assert_eq!(settled("", &clouds(&[ColorCoding::Each(vec![false, true])])), (Some(Linear), Linear));
        assert_eq!(settled(two_clouds, &clouds(&[display.clone(), linear.clone()])), (Some(Linear), Linear));
        assert_eq!(settled("[image]\ncolor = 'encoded'", &clouds(std::slice::from_ref(&linear))), (None, Encoded));
        let with_points = [clouds(&[display]), vec![Cloud::default()]].concat();
        assert_eq!(settled(two_clouds, &with_points), (None, Linear));
    }
}
