//! Units of the EPSG codes that are most used. Others are in a database that this program doesn't have.

use std::ops::RangeInclusive;

use pellucid_core::cloud::crs::Unit;

/// Projected systems in meters: UTM in several datums, and what some countries use.
const METERS: [RangeInclusive<u32>; 14] = [
    // WGS 84, UTM north and south.
    32601..=32660,
    32701..=32760,
    // ETRS89, NAD83, NAD83(2011), UTM.
    25828..=25838,
    26901..=26923,
    6328..=6348,
    // France, Germany, Great Britain, the Netherlands, Switzerland, Europe, the web.
    2154..=2154,
    3942..=3950,
    31466..=31469,
    27700..=27700,
    28992..=28992,
    21781..=21781,
    2056..=2056,
    3035..=3035,
    3857..=3857,
];

/// Geographic systems: WGS 84, ETRS89, NAD83, NAD27, RGF93, NAD83(2011).
const DEGREES: [u32; 7] = [4326, 4979, 4258, 4269, 4267, 4171, 6318];

/// Heights in meters: NAVD88, EGM2008, EGM96, France, Germany (two).
const HEIGHTS: [u32; 6] = [5703, 3855, 5773, 5720, 5783, 7837];

/// NAVD88 heights in US survey feet.
const HEIGHTS_IN_US_FEET: u32 = 6360;

/// Returns the unit of the horizontal coordinates of a system.
pub(super) fn unit(code: u32) -> Option<Unit> {
    if DEGREES.contains(&code) {
        return Some(Unit::degree());
    }
    METERS.iter().any(|codes| codes.contains(&code)).then(Unit::metre)
}

/// Returns the unit of the heights of a vertical system.
pub(super) fn height_unit(code: u32) -> Option<Unit> {
    match code {
        HEIGHTS_IN_US_FEET => of_unit_code(9003),
        code => HEIGHTS.contains(&code).then(Unit::metre),
    }
}

/// Returns the unit of length with a code of its own.
pub(super) fn of_unit_code(code: u32) -> Option<Unit> {
    let (name, meters) = match code {
        9001 => ("metre", 1.0),
        9002 => ("foot", 0.3048),
        9003 => ("US survey foot", 1200.0 / 3937.0),
        9005 => ("Clarke's foot", 0.304_797_265_4),
        9036 => ("kilometre", 1000.0),
        9037 => ("Clarke's yard", 0.914_391_796_2),
        9039 => ("Clarke's link", 0.201_166_194_964),
        9042 => ("British chain (Sears 1922)", 20.116_765_121_552_632),
        9062 => ("British yard (Sears 1922)", 0.914_398_414_616_028_7),
        9084 => ("Indian yard", 0.914_398_530_744_440_8),
        9096 => ("yard", 0.9144),
        1025 => ("millimetre", 0.001),
        1033 => ("centimetre", 0.01),
        _ => return None,
    };
    Unit::length(name, meters)
}

/// Returns the unit of angles with a code of its own.
pub(super) fn of_angle_code(code: u32) -> Option<Unit> {
    let (name, radians) = match code {
        9101 => ("radian", 1.0),
        9102 | 9122 => return Some(Unit::degree()),
        9105 | 9106 => ("grad", std::f64::consts::PI / 200.0),
        _ => return None,
    };
    Unit::angle(name, radians)
}
