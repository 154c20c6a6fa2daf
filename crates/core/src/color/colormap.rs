//! Color maps: tables of sRGB colors, linear in sRGB between their entries.

use glam::{DVec3, Vec3};

use super::decode_srgb_f64;

/// The tables that are text, by name; each names its source and license in its first line.
const TABLES: [(&str, &str); 7] = [
    ("viridis", include_str!("tables/viridis.txt")),
    ("cividis", include_str!("tables/cividis.txt")),
    ("magma", include_str!("tables/magma.txt")),
    ("inferno", include_str!("tables/inferno.txt")),
    ("plasma", include_str!("tables/plasma.txt")),
    ("turbo", include_str!("tables/turbo.txt")),
    ("terrain", include_str!("tables/terrain.txt")),
];

/// sRGB 0.5 in linear light: what stands for a value that is not finite.
pub fn mid_grey() -> Vec3 {
    Vec3::splat(decode_srgb_f64(0.5) as f32)
}

/// A color map.
#[derive(Debug, Clone, PartialEq)]
pub struct Colormap {
    /// sRGB, at least two.
    entries: Vec<DVec3>,
}

impl Colormap {
    /// Returns the color map from black to white.
    pub fn grey() -> Self {
        Self { entries: vec![DVec3::ZERO, DVec3::ONE] }
    }

    /// Returns the map of a name: one of matplotlib's, `turbo`, or `grey`. `None` for other names.
    pub fn named(name: &str) -> Option<Self> {
        if name == "grey" {
            return Some(Self::grey());
        }
        let (_, text) = TABLES.into_iter().find(|(known, _)| *known == name)?;
        let entries = text.lines().filter(|line| !line.starts_with('#')).filter_map(entry).collect();
        Some(Self { entries })
    }

    /// Returns the color in sRGB at t, from 0 to 1.
    pub fn srgb(&self, t: f64) -> DVec3 {
        let last = self.entries.len() - 1;
        let place = t.clamp(0.0, 1.0) * last as f64;
        let below = (place as usize).min(last);
        let (lower, upper) = (self.entries[below], self.entries[(below + 1).min(last)]);
        lower + (place - below as f64) * (upper - lower)
    }

    /// Returns the color in linear light at t, from 0 to 1.
    pub fn linear(&self, t: f64) -> DVec3 {
        DVec3::from(self.srgb(t).to_array().map(decode_srgb_f64))
    }
}

/// Three numbers of a line.
fn entry(line: &str) -> Option<DVec3> {
    let mut numbers = line.split_ascii_whitespace().map(str::parse);
    let mut next = || numbers.next()?.ok();
    Some(DVec3::new(next()?, next()?, next()?))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_are_whole_and_within_srgb() {
        for (name, text) in TABLES {
            let map = Colormap::named(name).unwrap();
            assert_eq!(map.entries.len(), 256, "{name}");
            assert!(map.entries.iter().all(|c| c.min_element() >= 0.0 && c.max_element() <= 1.0), "{name}");
            // All of them are smooth: a wrong row would be a kink.
            let kink = |three: &[DVec3]| (three[0] - 2.0 * three[1] + three[2]).abs().max_element();
            assert!(map.entries.windows(3).map(kink).all(|kink| kink < 0.03), "{name}");
            let about = text.lines().next().unwrap();
            assert!(about.starts_with('#') && about.contains("licen") | about.contains("CC0"), "{about}");
        }
        assert_eq!(Colormap::named("viridi"), None);
    }

    #[test]
    fn entries_and_what_lies_between_them() {
        // The published first and last entries.
        let ends = [
            ("viridis", [0.267004, 0.004874, 0.329415], [0.993248, 0.906157, 0.143936]),
            ("cividis", [0.0, 0.135112, 0.304751], [0.995737, 0.909344, 0.217772]),
            ("magma", [0.001462, 0.000466, 0.013866], [0.987053, 0.991438, 0.749504]),
            ("inferno", [0.001462, 0.000466, 0.013866], [0.988362, 0.998364, 0.644924]),
            ("plasma", [0.050383, 0.029803, 0.527975], [0.940015, 0.975158, 0.131326]),
            ("turbo", [0.18995, 0.07176, 0.23217], [0.4796, 0.01583, 0.01055]),
            ("grey", [0.0; 3], [1.0; 3]),
            ("terrain", [0.2, 0.2, 0.6], [1.0; 3]),
        ];
        for (name, first, last) in ends {
            let map = Colormap::named(name).unwrap();
            assert_eq!([map.srgb(0.0), map.srgb(1.0)], [first, last].map(DVec3::from), "{name}");
            assert_eq!([map.srgb(-1.0), map.srgb(2.0)], [first, last].map(DVec3::from), "{name}");
        }
        // Entry 128 of 0 to 255, as published.
        let middles = [
            ("viridis", [0.127568, 0.566949, 0.550556]),
            ("magma", [0.716387, 0.214982, 0.47529]),
            ("inferno", [0.735683, 0.215906, 0.330245]),
            ("plasma", [0.798216, 0.280197, 0.469538]),
            ("turbo", [0.64362, 0.98999, 0.23356]),
        ];
        for (name, wanted) in middles {
            assert!(
                (Colormap::named(name).unwrap().srgb(128.0 / 255.0) - DVec3::from(wanted)).length() < 1e-12,
                "{name}"
            );
        }
        let viridis = Colormap::named("viridis").unwrap();
        // Halfway between entries 100 and 101.
        let wanted = 0.5 * (viridis.entries[100] + viridis.entries[101]);
        assert!((viridis.srgb(100.5 / 255.0) - wanted).length() < 1e-14);
        // sRGB 0.5 is 0.2140 in linear light.
        assert!((Colormap::named("grey").unwrap().linear(0.5) - DVec3::splat(0.214_041_140)).length() < 1e-8);
        assert!((mid_grey().x - 0.214_041_14).abs() < 1e-7);
    }
}
