//! Names and colors of the classes of LAS files (ASPRS, LAS 1.4 R15, table 17).

use glam::DVec3;

/// Codes from 0 with their names as a scene file writes them, empty for reserved ones, and their colors in sRGB, in
/// hundredths.
const CLASSES: [(&str, [u8; 3]); 23] = [
    ("never-classified", [60, 60, 60]),
    ("unclassified", [72, 72, 72]),
    ("ground", [63, 47, 30]),
    ("low-vegetation", [62, 80, 38]),
    ("medium-vegetation", [36, 67, 28]),
    ("high-vegetation", [12, 48, 18]),
    ("building", [85, 32, 22]),
    ("low-noise", [95, 10, 60]),
    ("", [90, 75, 95]),
    ("water", [16, 45, 85]),
    ("rail", [48, 36, 58]),
    ("road", [40, 40, 44]),
    ("", [96, 86, 50]),
    ("wire-guard", [100, 93, 20]),
    ("wire-conductor", [100, 78, 10]),
    ("transmission-tower", [98, 60, 12]),
    ("wire-connector", [80, 62, 10]),
    ("bridge-deck", [55, 64, 72]),
    ("high-noise", [85, 0, 85]),
    ("overhead-structure", [35, 80, 80]),
    ("ignored-ground", [78, 66, 52]),
    ("snow", [93, 97, 100]),
    ("temporal-exclusion", [20, 16, 40]),
];

/// Other names of some classes.
const ALIASES: [(&str, u8); 4] =
    [("noise", 7), ("low-point", 7), ("road-surface", 11), ("wire-structure-connector", 16)];

/// Returns the name of a class; `None` for reserved codes and those of users.
pub fn name(code: u8) -> Option<&'static str> {
    CLASSES.get(usize::from(code)).map(|(name, _)| *name).filter(|name| !name.is_empty())
}

/// Returns the name of a class, or its number.
pub fn label(code: u8) -> String {
    name(code).map_or_else(|| format!("class {code}"), str::to_owned)
}

/// Returns the names of all classes that have one, in the order of their codes.
pub fn names() -> impl Iterator<Item = &'static str> {
    CLASSES.iter().map(|(name, _)| *name).filter(|name| !name.is_empty())
}

/// Returns the class of a name.
pub fn code(name: &str) -> Option<u8> {
    let alias = || ALIASES.into_iter().find(|(alias, _)| *alias == name).map(|(_, code)| code);
    let found = CLASSES.iter().position(|(known, _)| *known == name && !known.is_empty());
    // There are 23 of them.
    found.map(|code| code as u8).or_else(alias)
}

/// Returns the color of a class in sRGB. Any two differ by at least 0.04 in some channel.
pub fn srgb(code: u8) -> DVec3 {
    match CLASSES.get(usize::from(code)) {
        Some((_, hundredths)) => DVec3::from(hundredths.map(|c| f64::from(c) / 100.0)),
        None => distinct(usize::from(code)),
    }
}

/// Returns colors in sRGB that differ by at least 0.15 in some channel, 288 of them, over and over.
pub fn distinct(index: usize) -> DVec3 {
    let colors: Vec<[u16; 3]> = (0..343u16).map(|i| [i / 49, i / 7 % 7, i % 7]).filter(|c| is_vivid(*c)).collect();
    // Prime to their number, so that all are met, and far apart at first.
    let [r, g, b] = colors[index * 113 % colors.len()].map(|level| 0.1 + 0.15 * f64::from(level));
    DVec3::new(r, g, b)
}

/// True for colors of the lattice that are neither gray nor dark.
fn is_vivid(levels: [u16; 3]) -> bool {
    let (most, least) = (levels.into_iter().max().unwrap_or(0), levels.into_iter().min().unwrap_or(0));
    most - least >= 2 && most >= 3
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn any_two_classes_can_be_told_apart() {
        for a in 0..=255 {
            for b in 0..a {
                let apart = (srgb(a) - srgb(b)).abs().max_element();
                assert!(apart >= 0.04, "{a} and {b}: {apart}");
            }
            assert!(srgb(a).min_element() >= 0.0 && srgb(a).max_element() <= 1.0);
        }
    }

    #[test]
    fn names_and_codes_are_those_of_the_standard() {
        let known = [(0, "never-classified"), (2, "ground"), (5, "high-vegetation"), (6, "building"), (9, "water")];
        for (number, word) in known {
            assert_eq!((name(number), code(word)), (Some(word), Some(number)));
        }
        assert_eq!((name(22), name(8), name(12), name(23)), (Some("temporal-exclusion"), None, None, None));
        assert_eq!((code("noise"), code("low-noise"), code("Ground"), code("")), (Some(7), Some(7), None, None));
        assert!(names().all(|word| code(word).and_then(name) == Some(word)));
    }
}
