//! Cover of the ground where nothing stands on it: water, roads, yards, fields, meadows and the floor of forests.

use glam::DVec2;

use super::land::{Land, StreetPlace};
use super::light::Tone;
use super::town;

/// Half the width of the main roads and of the lanes that cross them, meters.
pub(super) const ROAD: f64 = 4.0;
const LANE: f64 = 2.8;

/// Keys of noises and hashes.
mod layer {
    pub(super) const FOREST: i64 = 30;
    pub(super) const PATCHES: i64 = 33;
    pub(super) const PARCEL: i64 = 36;
}

/// Cover of the ground.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Cover {
    Water,
    Shore,
    Road,
    Pavement,
    Plaza,
    Yard,
    Park,
    Meadow,
    /// A parcel of farmland.
    Field(Parcel),
    Forest,
}

/// A field.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Parcel {
    /// Uniform in [0, 1): the crop.
    crop: f64,
    /// Meters to the nearest edge.
    pub(super) edge: f64,
    /// `true` if a hedge grows along that edge.
    pub(super) hedge: bool,
}

/// Returns the cover at a position.
pub(super) fn cover(land: &Land, p: DVec2, place: &StreetPlace) -> Cover {
    let from_bank = place.river.abs() - land.river;
    if from_bank < 0.0 {
        return Cover::Water;
    }
    if place.uv.x.abs() < ROAD || place.uv.y.abs() < LANE {
        return Cover::Road;
    }
    if let Some(cover) = town::cover(land, place) {
        return cover;
    }
    if from_bank < 2.2 {
        return Cover::Shore;
    }
    let upland = land.upland(place);
    let length = (0.3 * land.side).clamp(110.0, 420.0);
    let patches = 0.75 * land.noise(p / length, layer::FOREST) + 0.4 * land.noise(p / 41.0, layer::FOREST + 1);
    let wild = patches + 1.5 * (upland - 0.32);
    // Roads keep their verges free.
    if wild > 0.12 && place.uv.abs().min_element() > 7.0 {
        Cover::Forest
    } else if from_bank > 14.0 && wild > -0.75 {
        parcel(land, place)
    } else {
        Cover::Meadow
    }
}

/// The parcel of a place; some lie fallow as meadows.
fn parcel(land: &Land, place: &StreetPlace) -> Cover {
    let size = DVec2::new(86.0, 54.0);
    let row = (place.uv.y / size.y).floor();
    let key = [place.town[0] * 1000 + row as i64, place.town[1]];
    let shifted = place.uv.x / size.x + land.hash(key[0], key[1], layer::PARCEL);
    let column = shifted.floor();
    let inside = DVec2::new(shifted - column, place.uv.y / size.y - row);
    let gaps = (0.5 - (inside - 0.5).abs()) * size;
    let crop = land.hash(key[0], key[1] * 1000 + column as i64, layer::PARCEL + 1);
    if crop > 0.72 {
        return Cover::Meadow;
    }
    let hedge = land.hash(key[0], key[1] * 1000 + column as i64, layer::PARCEL + 2) < 0.55;
    Cover::Field(Parcel { crop: crop / 0.72, edge: gaps.min_element(), hedge })
}

/// LAS class of a cover.
pub(super) fn class(cover: Cover) -> u8 {
    match cover {
        Cover::Water => 9,
        Cover::Road | Cover::Pavement | Cover::Plaza => 11,
        _ => 2,
    }
}

/// Returns the height of what grows on the ground, meters.
pub(super) fn growth(cover: Cover) -> f64 {
    match cover {
        Cover::Meadow => 0.22,
        Cover::Shore => 0.3,
        Cover::Forest => 0.18,
        Cover::Field(Parcel { crop, .. }) if crop < 0.6 => 0.4,
        Cover::Yard | Cover::Park => 0.05,
        _ => 0.0,
    }
}

/// Returns the color of a cover before light, where points are `spacing` meters apart.
pub(super) fn tone(land: &Land, p: DVec2, place: &StreetPlace, cover: Cover, spacing: f64) -> Tone {
    let coarse = land.noise(p / 31.0, layer::PATCHES);
    let fine = land.noise(p / 4.5, layer::PATCHES + 1);
    let mix = |a: Tone, b: Tone, share: f64| a.lerp(b, share.clamp(0.0, 1.0));
    let patches = 0.5 + 0.35 * coarse + 0.25 * fine;
    match cover {
        Cover::Water => mix(Tone::new(62.0, 98.0, 112.0), Tone::new(96.0, 132.0, 140.0), patches),
        Cover::Shore => mix(Tone::new(158.0, 146.0, 118.0), Tone::new(112.0, 126.0, 72.0), patches),
        Cover::Road => road(place, fine, spacing),
        Cover::Pavement => Tone::new(170.0, 165.0, 157.0) * (1.0 + 0.04 * fine),
        Cover::Plaza => plaza(land, place),
        Cover::Yard => mix(Tone::new(96.0, 138.0, 58.0), Tone::new(132.0, 156.0, 78.0), patches),
        Cover::Park => mix(Tone::new(92.0, 140.0, 60.0), Tone::new(118.0, 156.0, 74.0), patches),
        Cover::Meadow => mix(Tone::new(98.0, 134.0, 58.0), Tone::new(154.0, 158.0, 88.0), patches),
        Cover::Field(parcel) => field(place, parcel) * (1.0 + 0.05 * coarse + 0.04 * fine),
        Cover::Forest => mix(Tone::new(84.0, 80.0, 50.0), Tone::new(92.0, 108.0, 54.0), patches),
    }
}

/// Asphalt with a dashed line in the middle of main roads and light lines at their edges, if points are close enough to
/// show them.
fn road(place: &StreetPlace, fine: f64, spacing: f64) -> Tone {
    let across = place.uv.x.abs();
    let dash = across < 0.12 && (place.uv.y / 6.0).rem_euclid(1.0) < 0.5;
    let edge = (across - (ROAD - 0.35)).abs() < 0.1;
    if (dash || edge) && spacing < 0.3 {
        Tone::new(226.0, 224.0, 216.0)
    } else {
        Tone::new(118.0, 117.0, 118.0) * (1.0 + 0.05 * fine)
    }
}

/// Slabs of 1.5 m.
fn plaza(land: &Land, place: &StreetPlace) -> Tone {
    let slab = (place.uv / 1.5).floor();
    let tone = land.hash(slab.x as i64, slab.y as i64, layer::PATCHES + 2);
    Tone::new(190.0, 178.0, 160.0) * (0.92 + 0.14 * tone)
}

/// Crops in rows along v, with a green margin.
fn field(place: &StreetPlace, parcel: Parcel) -> Tone {
    if parcel.edge < 1.2 {
        return Tone::new(112.0, 140.0, 66.0);
    }
    let (crop, row) = match (parcel.crop * 5.0) as u32 {
        0 => (Tone::new(214.0, 190.0, 116.0), 0.05),
        1 => (Tone::new(118.0, 154.0, 70.0), 0.12),
        2 => (Tone::new(206.0, 196.0, 86.0), 0.05),
        3 => (Tone::new(146.0, 118.0, 88.0), 0.14),
        _ => (Tone::new(140.0, 164.0, 84.0), 0.12),
    };
    let stripe = if (place.uv.x / 1.4).rem_euclid(1.0) < 0.5 { 1.0 - row } else { 1.0 };
    // A tramline of a tractor every 18 m.
    let track = if (place.uv.x / 18.0).rem_euclid(1.0) < 0.05 { 0.88 } else { 1.0 };
    crop * stripe * track
}
