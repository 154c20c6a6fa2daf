//! Warnings about clouds whose points are shuffled into ensembles.

use pellucid_engine::methods::Frame;
use pellucid_engine::methods::spbr::share::Share;
use pellucid_scene::Method;
use pellucid_scene::prepare::ensembles::CloudSurface;

/// Copies of a point up to which Tanaka et al. (2016, Fig. 5 and Table 1) found opacities to be right.
const COPIES: f64 = 20.0;

/// The excess demand for points, as a factor, that is tolerated without a warning: the density isn't known any better.
const ALMOST: f64 = 1.05;

/// A sentence for each cloud that doesn't come out as asked in a frame, and one for all of those with many copies;
/// `names` are those of the clouds.
pub fn warnings(names: &[String], surfaces: &[CloudSurface], shares: &[Share], frame: &Frame) -> Vec<String> {
    let method = &frame.method;
    let (Method::Spbr(_), Some(ensembles)) = (method, method.ensembles()) else { return Vec::new() };
    let mut warnings = Vec::new();
    let mut copied = Vec::new();
    for ((name, surface), share) in names.iter().zip(surfaces).zip(shares) {
        let copies = share.slots as f64 / (surface.points.end - surface.points.start) as f64;
        match lost(surface, share, frame.size) {
            Some(lost) => warnings.push(format!("{name}: {lost}")),
            // Opaque surfaces always use all points.
            None if surface.opacity < 1.0 && copies > COPIES => {
                copied.push((copies, noise(copies, surface.opacity), name.as_str()));
            }
            None => {}
        }
    }
    warnings.extend(many(&copied, f64::from(ensembles)));
    warnings
}

/// The reason why a surface can't reach the requested opacity in a picture of this size, and what would.
fn lost(surface: &CloudSurface, share: &Share, size: [u32; 2]) -> Option<String> {
    let opacity = f64::from(surface.opacity);
    let times = -(-opacity).ln_1p() / share.unit;
    if opacity <= 0.0 || opacity >= 1.0 {
        None
    } else if surface.density == 0.0 {
        let points = surface.points.end - surface.points.start;
        Some(format!(
            "its {points} point(s) are too few, or too far apart, to tell how dense a surface they make: every point is drawn \
             in every ensemble, whatever the opacity"
        ))
    } else if share.capped && times > ALMOST {
        let [width, height] = size.map(|side| (f64::from(side) / times.sqrt()).max(1.0) as u32);
        Some(format!(
            "opacity {opacity:.3} needs {times:.1} times as many points on a pixel as there are, so that it becomes {:.3}; \
             --size {width}x{height} would do, or discs of the same opacity: --method auto --surface-opacity {opacity:.3}; more \
             ensembles would not help",
            share.opacity
        ))
    } else {
        None
    }
}

/// Noise that copies add: the variance of a surface of this opacity over that of a surface whose points are assigned
/// once. The variance has two parts: α(1 − α) from drawing a point or not, and (1 − α)²mk from the number of points on
/// a pixel, m = −ln(1 − α), which copies don't change.
fn noise(copies: f64, opacity: f32) -> f64 {
    let opacity = f64::from(opacity);
    1.0 + (1.0 - opacity) / opacity * -(-opacity).ln_1p() * copies
}

/// A sentence on the clouds with many copies per point; `copied` has their copies, noise and names.
fn many(copied: &[(f64, f64, &str)], ensembles: f64) -> Option<String> {
    let most = copied.iter().map(|(copies, ..)| *copies).fold(0.0, f64::max);
    let noise = copied.iter().map(|(_, noise, _)| *noise).fold(1.0, f64::max);
    let names: Vec<&str> = copied.iter().map(|(.., name)| *name).collect();
    (!copied.is_empty()).then(|| {
        format!(
            "up to {most:.0} copies of each point are dealt to {ensembles} ensembles, so that there is about the noise of {:.1} \
             of them; a smaller image or more points would help, more ensembles would not: {}",
            ensembles / noise,
            names.join(", ")
        )
    })
}

#[cfg(test)]
mod tests {
    use std::slice::from_ref;

    use super::*;
    use glam::DVec3;
    use pellucid_core::camera::{Camera, Projection};
    use pellucid_scene::Scene;

    fn frame() -> Frame {
        let scene = Scene::from_toml("method.name = 'spbr'\n[[cloud]]\npath = 'a.ply'", "s.toml".as_ref()).unwrap();
        let camera =
            Camera::look_at(DVec3::ZERO, DVec3::Z, DVec3::Y, Projection::Orthographic { height: 1.0 }, 1.0, 2.0);
        Frame { size: [600, 300], ..Frame::of_scene(&scene, camera.unwrap(), 0) }
    }

    fn said(density: f64, opacity: f32, slots: u64, capped: bool) -> String {
        let surface = CloudSurface { points: 10..110, center: DVec3::ZERO, density, opacity };
        let unit = if capped { 0.25 } else { -f64::from(-opacity).ln_1p() };
        let share =
            Share { points: 10..110, slots, depth: 1.0, unit, capped, opacity: 0.221, largest: 1.0, uniform: true };
        warnings(&["a.ply".to_owned()], from_ref(&surface), from_ref(&share), &frame()).join("\n")
    }

    #[test]
    fn who_loses_opacity_is_told() {
        assert_eq!(said(3.0, 0.5, 700, false), "");
        let copies = said(3.0, 0.5, 2100, false);
        assert!(copies.contains("21 copies of each point") && copies.contains("noise of 6.4"), "{copies}");
        // 1 + 0.1 / 0.9 · 2.303 · 21 = 6.4.
        assert!(said(3.0, 0.9, 2100, false).contains("noise of 15.7"), "{}", said(3.0, 0.9, 2100, false));
        assert!(copies.ends_with(": a.ply"), "{copies}");
        let capped = said(3.0, 0.9, 10_000, true);
        assert!(capped.starts_with("a.ply: opacity 0.900 needs 9.2 times") && capped.contains("0.221"), "{capped}");
        // The root of 9.21 is 3.035.
        assert!(capped.contains("--size 197x98 would do") && capped.contains("--surface-opacity 0.900"), "{capped}");
        // A shortage of 2% is within the uncertainty of the density, so only the copies are reported.
        assert!(said(3.0, 0.225, 10_000, true).starts_with("up to 100 copies"));
        assert!(said(0.0, 0.5, 10_000, true).contains("100 point(s)"));
        // Nothing is lost at full or zero opacity.
        assert_eq!(said(3.0, 1.0, 10_000, true) + &said(0.0, 0.0, 0, false), "");
    }
}
