//! The plan of towns: blocks between streets, with lots for houses, a square and parks.

use glam::DVec2;

use super::ground::Cover;
use super::land::{Land, StreetPlace};

/// Distances of streets along u and v, from the middle of one to that of the next; half their width without and with
/// pavements. Meters.
const BLOCK: DVec2 = DVec2::new(62.0, 46.0);
pub(super) const STREET: f64 = 3.0;
const PAVEMENT: f64 = 4.8;
/// Lots side by side on each side of a block.
const LOTS: i64 = 4;

/// Keys of hashes.
pub(super) mod layer {
    pub(in super::super) const BUILT: i64 = 60;
    pub(in super::super) const PARK: i64 = 61;
    pub(in super::super) const LOT: i64 = 62;
}

/// A block of a town.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct TownBlock {
    pub(super) town: [i64; 2],
    pub(super) at: [i64; 2],
}

/// A house's place, without its height.
#[derive(Debug, Clone, Copy)]
pub(super) struct Lot {
    /// Middle and half the lengths along u and v.
    pub(super) uv: DVec2,
    pub(super) half: DVec2,
    /// Storeys above the lowest.
    pub(super) storeys: f64,
    /// `true` if it fills its lot.
    pub(super) dense: bool,
    /// Key for hashes.
    pub(super) key: [i64; 2],
}

impl TownBlock {
    fn around(place: &StreetPlace) -> Self {
        let at = (place.uv / BLOCK).floor();
        Self { town: place.town, at: [at.x as i64, at.y as i64] }
    }

    /// Returns the corner of least u and v.
    pub(super) fn low(&self) -> DVec2 {
        DVec2::new(self.at[0] as f64, self.at[1] as f64) * BLOCK
    }

    /// Returns a key for hashes: the number, and one of the parts.
    fn key(&self, part: i64) -> [i64; 2] {
        [self.at[0] * 64 + part, self.at[1] + 4096 * (self.town[0] + 512 * self.town[1])]
    }

    pub(super) fn hash(&self, land: &Land, part: i64, layer: i64) -> f64 {
        let [x, y] = self.key(part);
        land.hash(x, y, layer)
    }

    /// Returns `true` if the town reaches here.
    fn is_built(&self, land: &Land) -> bool {
        let center = self.low() + 0.5 * BLOCK;
        let reach = land.town_radius(self.town) * (0.8 + 0.35 * self.hash(land, 0, layer::BUILT));
        center.length() < reach && land.river_gap(center, self.town).abs() > land.river + 0.5 * BLOCK.y + 8.0
    }

    pub(super) fn is_square(&self) -> bool {
        self.at == [0, 0]
    }

    fn is_park(&self, land: &Land) -> bool {
        self.at == [-1, 0] || self.hash(land, 0, layer::PARK) < 0.11
    }

    /// Returns the houses of the block.
    pub(super) fn lots<'a>(&self, land: &'a Land) -> impl Iterator<Item = Lot> + use<'a> {
        let block = *self;
        let count = if block.is_square() || block.is_park(land) { 0 } else { 2 * LOTS };
        (0..count).filter_map(move |lot| block.lot(land, lot))
    }

    /// A house that fills most of the width of its lot, a few meters behind the street.
    fn lot(&self, land: &Land, lot: i64) -> Option<Lot> {
        let hash = |what: i64| self.hash(land, lot, layer::LOT + what);
        if hash(0) < 0.07 {
            return None;
        }
        let low = self.low() + PAVEMENT;
        let width = (BLOCK.x - 2.0 * PAVEMENT) / LOTS as f64;
        let dense = (self.low() + 0.5 * BLOCK).length() < 0.42 * land.town_radius(self.town);
        let half = DVec2::new(if dense { 0.47 * width } else { 4.0 + 1.2 * hash(1) }, 4.2 + 1.3 * hash(2));
        let storeys = if dense { 1.0 + f64::from(hash(3) > 0.5) } else { f64::from(hash(3) > 0.45) };
        let setback = if dense { 0.5 } else { 2.0 + 2.5 * hash(4) };
        let u = low.x + width * ((lot % LOTS) as f64 + 0.5);
        let from_street = setback + half.y;
        let v = if lot < LOTS { low.y + from_street } else { low.y + BLOCK.y - 2.0 * PAVEMENT - from_street };
        Some(Lot { uv: DVec2::new(u, v), half, storeys, dense, key: self.key(lot) })
    }
}

/// Returns what covers a place of a town; `None` outside.
pub(super) fn cover(land: &Land, place: &StreetPlace) -> Option<Cover> {
    if place.uv.length() > 1.2 * land.town_radius(place.town) + BLOCK.length() {
        return None;
    }
    let block = TownBlock::around(place);
    let inside = place.uv - block.low();
    let built = block.is_built(land);
    // The block across the nearest street has a share in it.
    let across = |axis: usize| {
        let mut other = block;
        other.at[axis] += if inside[axis] < 0.5 * BLOCK[axis] { -1 } else { 1 };
        other.is_built(land)
    };
    let gap = inside.min(BLOCK - inside);
    for (axis, gap) in gap.to_array().into_iter().enumerate() {
        if gap < STREET && (built || across(axis)) || gap < PAVEMENT && built {
            return Some(if gap < STREET { Cover::Road } else { Cover::Pavement });
        }
    }
    built.then(|| {
        if block.is_square() {
            Cover::Plaza
        } else if block.is_park(land) {
            Cover::Park
        } else {
            Cover::Yard
        }
    })
}

/// Returns `true` if a tree with a crown of this radius has room in a town: not in a house.
pub(super) fn has_room(land: &Land, place: &StreetPlace, radius: f64) -> bool {
    let block = TownBlock::around(place);
    let church = church_uv();
    let mut taken = block.lots(land).map(|lot| (lot.uv, lot.half)).collect::<Vec<_>>();
    if block.is_square() {
        taken.extend(church);
    }
    taken.iter().all(|(center, half)| ((place.uv - center).abs() - half).max_element() > 0.7 * radius + 0.3)
}

/// Returns the built blocks that a circle may touch.
pub(super) fn blocks(land: &Land, center: DVec2, radius: f64) -> Vec<TownBlock> {
    let place = land.place(center);
    // Streets are bent: some meters more.
    let reach = DVec2::splat(1.15 * radius + 8.0);
    if place.uv.length() > reach.length() + 1.2 * land.town_radius(place.town) + BLOCK.length() {
        return Vec::new();
    }
    let (low, high) = (((place.uv - reach) / BLOCK).floor(), ((place.uv + reach) / BLOCK).floor());
    let columns = low.x as i64..=high.x as i64;
    let all = columns.flat_map(|x| (low.y as i64..=high.y as i64).map(move |y| [x, y]));
    all.map(|at| TownBlock { town: place.town, at }).filter(|block| block.is_built(land)).collect()
}

/// Returns the middle and half lengths of the nave and of the tower, on the square.
pub(super) fn church_uv() -> [(DVec2, DVec2); 2] {
    let middle = 0.5 * BLOCK + DVec2::new(4.0, 4.0);
    [(middle, DVec2::new(12.0, 5.5)), (middle - DVec2::new(15.0, 0.0), DVec2::splat(3.2))]
}
