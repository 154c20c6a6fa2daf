//! Table of the changes that are measured on a scene.

use pellucid_core::camera::Projection;
use pellucid_scene::{Discs, GaussianSettings, Kernel, Order};

/// Least opacity that leaves nothing visible out.
const FAINTEST: f32 = 1e-6;

/// The share of the light at which lists end in the original (Kerbl et al. 2023).
const EARLY_END: f32 = 1e-4;

/// The least opacity of a fragment in the exact core of HTGS (Hahlbohm et al. 2025).
const CORE_ALPHA_MIN: f32 = 0.05;

/// A change of the settings.
#[derive(Debug, Clone, PartialEq)]
pub(in super::super) struct Change {
    /// See [`Cause::cause`](super::Cause::cause).
    pub cause: &'static str,
    /// See [`Cause::setting`](super::Cause::setting).
    pub setting: String,
    /// See [`Cause::against`](super::Cause::against).
    pub against: &'static str,
    /// See [`Cause::meaning`](super::Cause::meaning).
    pub meaning: String,
    /// The changed settings.
    pub settings: GaussianSettings,
    /// Settings of the image that it is compared with, if they are not the scene's.
    pub base: Option<GaussianSettings>,
    /// Harmonics up to this degree alone.
    pub degree: Option<u32>,
    /// Least opacity of a fragment in the core, to render with `hybrid` in place of `abuffer`.
    pub core_alpha_min: Option<f32>,
}

/// The changes of a scene's exact image, itself first: `discs` and `order` are the scene's, `degree` is that of its
/// harmonics.
pub(in super::super) fn changes(discs: &Discs, order: Order, degree: u32, projection: &Projection) -> Vec<Change> {
    let own = discs.gaussians;
    let about = "The exact image, rendered once more: compare the times below with its time.";
    let mut all = vec![of("the exact image", "", about, own)];
    // Ellipsoids are entered and left: neither one depth nor a fainter rim.
    let has_rims = own.kernel != Kernel::Ellipsoid;
    all.extend(orders(order).filter(|_| has_rims).map(|(changed, cause, meaning)| {
        let settings = GaussianSettings { order: Some(changed), ..own };
        of(cause, &format!("method.order={}", changed.word()), meaning, settings)
    }));
    if has_rims && own.alpha_min > FAINTEST {
        let meaning = format!("What each Gaussian loses at its rim, as it ends at opacity {}.", share(own.alpha_min));
        let settings = GaussianSettings { alpha_min: FAINTEST, ..own };
        all.push(of("cut of faint rims", &format!("method.alpha_min={FAINTEST:e}"), &meaning, settings));
    }
    if own.alpha_max < 1.0 {
        let meaning = format!("What shows through Gaussians, as none may be more opaque than {}.", own.alpha_max);
        let settings = GaussianSettings { alpha_max: 1.0, ..own };
        all.push(of("cap of opacity", "method.alpha_max=1", &meaning, settings));
    }
    if has_rims && own.stop == 0.0 {
        let meaning = "What is lost if a pixel ends once less than a ten-thousandth of the light is left, as in the original renderer.";
        all.push(of("early end", "method.stop=1e-4", meaning, GaussianSettings { stop: EARLY_END, ..own }));
    }
    all.extend(projections(&own, projection));
    // Methods of other lists refuse ellipsoids.
    all.extend(hybrids(own).filter(|_| has_rims));
    all.extend((0..degree).map(|less| of_degree(own, less)));
    all
}

/// A change of the settings, compared with the exact image.
fn of(cause: &'static str, setting: &str, meaning: &str, settings: GaussianSettings) -> Change {
    Change {
        cause,
        setting: setting.to_owned(),
        against: "",
        meaning: meaning.to_owned(),
        settings,
        base: None,
        degree: None,
        core_alpha_min: None,
    }
}

/// The other orders, what they change, and what that means.
fn orders(own: Order) -> impl Iterator<Item = (Order, &'static str, &'static str)> {
    let all = [
        (
            Order::Center,
            "order of centers",
            "Gaussians ordered by the depth of their centers, as in most renderers: where they overlap, the wrong one may be in front, and \
             they change places when the camera turns.",
        ),
        (
            Order::Distance,
            "order of distances",
            "Gaussians ordered by the distance of their centers from the eye: still wrong where they overlap, but the order stays while \
             the camera turns in place.",
        ),
        (
            Order::Pixel,
            "order in each pixel",
            "Gaussians ordered in each pixel by where they are densest along its ray: this shows what the scene's own order gets wrong.",
        ),
    ];
    all.into_iter().filter(move |(order, ..)| *order != own)
}

/// Changes of how a Gaussian comes to the screen.
fn projections(own: &GaussianSettings, projection: &Projection) -> Vec<Change> {
    let other = |kernel| GaussianSettings { kernel, ..*own };
    let along_rays = of(
        "kernel ray",
        "method.kernel=ray",
        "Gaussians evaluated along each pixel's ray, without a projection and without its dilation.",
        other(Kernel::Ray),
    );
    let projected = of(
        "kernel ewa",
        "method.kernel=ewa",
        "Gaussians projected by the perspective at their centers, and widened by the dilation: the scene's kernel needs neither of \
         these approximations.",
        other(Kernel::Ewa),
    );
    let dense = of(
        "density in place of opacity",
        "method.kernel=ellipsoid",
        "Ellipsoids of constant density that rays pass through, in place of an opacity for each Gaussian: no order can be wrong, but \
         shapes and rims differ from those that the model was trained with.",
        other(Kernel::Ellipsoid),
    );
    match own.kernel {
        Kernel::Ray => return vec![projected, dense],
        Kernel::Ellipsoid => return vec![projected, along_rays],
        Kernel::Ewa => {}
    }
    let mut all = vec![along_rays, dense];
    let bare = GaussianSettings { dilation: 0.0, ..*own };
    if own.dilation > 0.0 {
        if matches!(projection, Projection::Perspective { .. }) {
            let ray = of(
                "frozen Jacobian",
                "method.kernel=ray",
                "The part of that error that comes from the perspective, which the projection evaluates only at the Gaussian's center.",
                other(Kernel::Ray),
            );
            all.push(Change { against: "method.dilation=0", base: Some(bare), ..ray });
        }
        let meaning = format!(
            "What {} px² of added variance on the screen do: without them Gaussians are sharper, with gaps where they are thinner than a pixel.",
            own.dilation
        );
        all.push(of("dilation", "method.dilation=0", &meaning, bare));
        let (setting, meaning) = match own.antialias {
            false => (
                "method.antialias=true",
                "The opacity that the dilation adds to small Gaussians: this setting removes it.",
            ),
            true => (
                "method.antialias=false",
                "The opacity that the dilation adds to small Gaussians: this setting keeps it.",
            ),
        };
        let settings = GaussianSettings { antialias: !own.antialias, ..*own };
        all.push(of("opacity of the dilation", setting, meaning, settings));
    }
    all
}

/// An average behind the nearest fragments in place of all in order, of which faint ones are or are not.
fn hybrids(own: GaussianSettings) -> impl Iterator<Item = Change> {
    let all = [
        (
            "average behind the nearest",
            0.0,
            "By hybrid: only the nearest fragments of each pixel are in order, and those behind are averaged (Maule et al. 2013).",
        ),
        (
            "average behind the nearest opaque",
            CORE_ALPHA_MIN,
            "The same, but fragments of less opacity are averaged wherever they lie, and so take no place among the nearest \
             (Hahlbohm et al. 2025).",
        ),
    ];
    all.into_iter().map(move |(cause, least, meaning)| {
        let setting = match least {
            0.0 => "method.name=hybrid".to_owned(),
            _ => format!("method.name=hybrid method.core_alpha_min={least}"),
        };
        Change { core_alpha_min: Some(least), ..of(cause, &setting, meaning, own) }
    })
}

fn of_degree(own: GaussianSettings, degree: u32) -> Change {
    let meaning = match degree {
        0 => "One color for every direction: the gloss and reflections that are lost without any harmonics.".to_owned(),
        _ => format!("The gloss and reflections that are lost with harmonics only up to degree {degree}."),
    };
    Change { degree: Some(degree), ..of("harmonics", &format!("cloud.*.sh_degree={degree}"), &meaning, own) }
}

/// 1/255 as such, anything else as a number.
fn share(alpha: f32) -> String {
    if (alpha * 255.0 - 1.0).abs() < 1e-4 { "1/255".to_owned() } else { alpha.to_string() }
}

#[cfg(test)]
mod tests {
    use super::*;

    const WIDE: Projection = Projection::Perspective { fov_y: 1.0 };

    fn settings(gaussians: GaussianSettings, order: Order, degree: u32, projection: &Projection) -> Vec<String> {
        let discs = Discs { gaussians, ..Discs::default() };
        let of = |change: &Change| format!("{} {}", change.setting, change.against).trim().replace("method.", "");
        changes(&discs, order, degree, projection).iter().map(of).collect()
    }

    #[test]
    fn every_cause_of_the_defaults_is_there_once() {
        let found = settings(GaussianSettings::default(), Order::Pixel, 3, &WIDE);
        let causes = [
            "",
            "order=center",
            "order=distance",
            "alpha_min=1e-6",
            "alpha_max=1",
            "stop=1e-4",
            "kernel=ray",
            "kernel=ellipsoid",
            "kernel=ray dilation=0",
            "dilation=0",
            "antialias=true",
            "name=hybrid",
            "name=hybrid core_alpha_min=0.05",
            "cloud.*.sh_degree=0",
            "cloud.*.sh_degree=1",
            "cloud.*.sh_degree=2",
        ];
        assert_eq!(found, causes);
    }

    #[test]
    fn settings_that_a_scene_does_not_use_are_no_causes() {
        let own = GaussianSettings {
            alpha_min: 1e-6,
            alpha_max: 1.0,
            dilation: 0.0,
            stop: 1e-3,
            ..GaussianSettings::default()
        };
        assert_eq!(
            settings(own, Order::Center, 0, &WIDE),
            [
                "",
                "order=distance",
                "order=pixel",
                "kernel=ray",
                "kernel=ellipsoid",
                "name=hybrid",
                "name=hybrid core_alpha_min=0.05"
            ]
        );
        let ray = GaussianSettings { kernel: Kernel::Ray, ..GaussianSettings::default() };
        let found = settings(ray, Order::Pixel, 0, &WIDE);
        assert_eq!(found[3..8], ["alpha_min=1e-6", "alpha_max=1", "stop=1e-4", "kernel=ewa", "kernel=ellipsoid"]);
        let ellipsoids = GaussianSettings { kernel: Kernel::Ellipsoid, ..GaussianSettings::default() };
        assert_eq!(settings(ellipsoids, Order::Pixel, 0, &WIDE), ["", "alpha_max=1", "kernel=ewa", "kernel=ray"]);
        // Without a perspective the projection is the same everywhere.
        let flat = settings(GaussianSettings::default(), Order::Pixel, 0, &Projection::Orthographic { height: 1.0 });
        assert!(
            flat.contains(&"kernel=ray".to_owned()) && !flat.contains(&"kernel=ray dilation=0".to_owned()),
            "{flat:?}"
        );
    }

    #[test]
    fn each_row_changes_one_thing() {
        let own = GaussianSettings::default();
        let number = |a: GaussianSettings, b: GaussianSettings| {
            [
                a.kernel != b.kernel,
                a.order.unwrap_or(Order::Pixel) != b.order.unwrap_or(Order::Pixel),
                a.alpha_max != b.alpha_max,
                a.alpha_min != b.alpha_min,
                a.dilation != b.dilation,
                a.antialias != b.antialias,
                a.stop != b.stop,
            ]
            .map(u32::from)
            .iter()
            .sum::<u32>()
        };
        for change in changes(&Discs::default(), Order::Pixel, 2, &WIDE).iter().skip(1) {
            let [degree, hybrid] = [change.degree.is_some(), change.core_alpha_min.is_some()].map(u32::from);
            // The kernel along the ray has no dilation: that both lack it is no second change.
            assert_eq!(number(change.settings, own) + degree + hybrid, 1, "{change:?}");
            assert!(change.meaning.ends_with('.') && !change.meaning.contains("  "), "{change:?}");
        }
    }
}
