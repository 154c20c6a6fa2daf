//! Towns: blocks of houses between streets, a square with a church, a bridge, cars and lamps.

use glam::{DVec2, DVec3};

use super::ground::{Cover, ROAD};
use super::land::{Land, Place};
use super::light::Tone;
use super::posts::Post;
use super::solids::{BRIDGE, Front, Roof, Solid};

/// Distances of streets along u and v, from the middle of one to that of the next; half their width without and with
/// pavements. Metres.
const BLOCK: DVec2 = DVec2::new(62.0, 46.0);
const STREET: f64 = 3.0;
const PAVEMENT: f64 = 4.8;
/// Lots side by side on each side of a block.
const LOTS: i64 = 4;

/// Keys of hashes.
mod layer {
    pub(super) const BUILT: i64 = 60;
    pub(super) const PARK: i64 = 61;
    pub(super) const LOT: i64 = 62;
    pub(super) const CAR: i64 = 80;
}

/// A block of a town.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Block {
    town: [i64; 2],
    at: [i64; 2],
}

/// A house's place, without its height.
#[derive(Debug, Clone, Copy)]
pub(super) struct Lot {
    /// Middle and half the lengths along u and v.
    uv: DVec2,
    half: DVec2,
    /// Storeys above the lowest.
    storeys: f64,
    dense: bool,
    key: [i64; 2],
}

impl Block {
    fn around(place: &Place) -> Self {
        let at = (place.uv / BLOCK).floor();
        Self { town: place.town, at: [at.x as i64, at.y as i64] }
    }

    /// The corner of least u and v.
    fn low(&self) -> DVec2 {
        DVec2::new(self.at[0] as f64, self.at[1] as f64) * BLOCK
    }

    /// Its number, and one of its parts, for hashes.
    fn key(&self, part: i64) -> [i64; 2] {
        [self.at[0] * 64 + part, self.at[1] + 4096 * (self.town[0] + 512 * self.town[1])]
    }

    fn hash(&self, land: &Land, part: i64, layer: i64) -> f64 {
        let [x, y] = self.key(part);
        land.hash(x, y, layer)
    }

    /// True if the town reaches here.
    fn is_built(&self, land: &Land) -> bool {
        let center = self.low() + 0.5 * BLOCK;
        let reach = land.town_radius(self.town) * (0.8 + 0.35 * self.hash(land, 0, layer::BUILT));
        center.length() < reach && land.river_gap(center, self.town).abs() > land.river + 0.5 * BLOCK.y + 8.0
    }

    fn is_square(&self) -> bool {
        self.at == [0, 0]
    }

    fn is_park(&self, land: &Land) -> bool {
        self.at == [-1, 0] || self.hash(land, 0, layer::PARK) < 0.11
    }

    /// The houses of the block.
    pub(super) fn lots<'a>(&self, land: &'a Land) -> impl Iterator<Item = Lot> + use<'a> {
        let block = *self;
        let count = if block.is_square() || block.is_park(land) { 0 } else { 2 * LOTS };
        (0..count).filter_map(move |lot| block.lot(land, lot))
    }

    /// A house that fills most of the width of its lot, a few metres behind the street.
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

/// What covers a place of a town; `None` outside.
pub(super) fn cover(land: &Land, place: &Place) -> Option<Cover> {
    if place.uv.length() > 1.2 * land.town_radius(place.town) + BLOCK.length() {
        return None;
    }
    let block = Block::around(place);
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

/// True if a tree with a crown of this radius has room in a town: not in a house.
pub(super) fn has_room(land: &Land, place: &Place, radius: f64) -> bool {
    let block = Block::around(place);
    let church = church_uv();
    let mut taken = block.lots(land).map(|lot| (lot.uv, lot.half)).collect::<Vec<_>>();
    if block.is_square() {
        taken.extend(church);
    }
    taken.iter().all(|(center, half)| ((place.uv - center).abs() - half).max_element() > 0.7 * radius + 0.3)
}

/// The built blocks that a circle may touch.
pub(super) fn blocks(land: &Land, center: DVec2, radius: f64) -> Vec<Block> {
    let place = land.place(center);
    // Streets are bent: some metres more.
    let reach = DVec2::splat(1.15 * radius + 8.0);
    if place.uv.length() > reach.length() + 1.2 * land.town_radius(place.town) + BLOCK.length() {
        return Vec::new();
    }
    let (low, high) = (((place.uv - reach) / BLOCK).floor(), ((place.uv + reach) / BLOCK).floor());
    let columns = low.x as i64..=high.x as i64;
    let all = columns.flat_map(|x| (low.y as i64..=high.y as i64).map(move |y| [x, y]));
    all.map(|at| Block { town: place.town, at }).filter(|block| block.is_built(land)).collect()
}

const PLASTER: [[f64; 3]; 6] = [
    [238.0, 228.0, 208.0],
    [230.0, 206.0, 168.0],
    [216.0, 224.0, 222.0],
    [242.0, 238.0, 230.0],
    [224.0, 188.0, 156.0],
    [202.0, 210.0, 190.0],
];
const TILES: [[f64; 3]; 5] =
    [[172.0, 98.0, 76.0], [152.0, 86.0, 70.0], [128.0, 80.0, 68.0], [112.0, 112.0, 118.0], [182.0, 116.0, 90.0]];
const PAINT: [[f64; 3]; 6] = [
    [196.0, 44.0, 40.0],
    [230.0, 230.0, 228.0],
    [48.0, 50.0, 56.0],
    [52.0, 88.0, 150.0],
    [150.0, 154.0, 158.0],
    [222.0, 180.0, 60.0],
];

fn pick<const N: usize>(tones: &[[f64; 3]; N], hash: f64) -> Tone {
    Tone::from_array(tones[((hash * N as f64) as usize).min(N - 1)])
}

/// The bodies of a block: houses with chimneys, the church, parked cars.
pub(super) fn solids(land: &Land, block: &Block) -> Vec<Solid> {
    let mut solids: Vec<Solid> = block.lots(land).flat_map(|lot| house(land, block.town, &lot)).collect();
    if block.is_square() {
        solids.extend(church(land, block.town));
    }
    for slot in 0..14 {
        if block.hash(land, slot, layer::CAR) < 0.35 {
            solids.extend(car(land, block, slot));
        }
    }
    solids
}

/// A body at a place, with half lengths along u and v and its ridge along the one or the other.
fn body(land: &Land, town: [i64; 2], uv: DVec2, half: DVec2, ridge_along_u: bool) -> Solid {
    let center = land.position(uv, town);
    let along_v = land.along_v(uv, town);
    let (axis, half) = if ridge_along_u { (-along_v.perp(), half) } else { (along_v, DVec2::new(half.y, half.x)) };
    let ground = land.height(center);
    Solid {
        center,
        axis,
        half,
        base: ground - 3.0,
        eave: ground,
        rise: 0.0,
        roof: Roof::Gable,
        front: Front::Plain,
        wall: Tone::ZERO,
        cover: Tone::ZERO,
        class: 6,
    }
}

fn house(land: &Land, town: [i64; 2], lot: &Lot) -> [Solid; 2] {
    let hash = |what: i64| land.hash(lot.key[0], lot.key[1], layer::LOT + what);
    let mut house = body(land, town, lot.uv, lot.half, lot.dense || hash(5) < 0.6);
    house.eave += 3.3 + 2.8 * lot.storeys;
    house.rise = (0.8 + 0.35 * hash(6)) * house.half.y;
    house.front = Front::House;
    house.wall = pick(&PLASTER, hash(7)) * (0.93 + 0.09 * hash(8));
    house.cover = pick(&TILES, hash(9)) * (0.9 + 0.2 * hash(10));
    let offset = DVec2::new((hash(11) - 0.5) * house.half.x, 0.3 * house.half.y);
    let chimney = Solid {
        center: house.center + offset.x * house.axis + offset.y * house.axis.perp(),
        half: DVec2::splat(0.35),
        base: house.eave + 0.5 * house.rise,
        eave: house.top() + 0.6,
        rise: 0.0,
        roof: Roof::Flat,
        front: Front::Plain,
        wall: Tone::new(150.0, 84.0, 68.0),
        cover: Tone::new(90.0, 84.0, 80.0),
        ..house.clone()
    };
    [house, chimney]
}

/// Middle and half lengths of the nave and of the tower, on the square.
fn church_uv() -> [(DVec2, DVec2); 2] {
    let middle = 0.5 * BLOCK + DVec2::new(4.0, 4.0);
    [(middle, DVec2::new(12.0, 5.5)), (middle - DVec2::new(15.0, 0.0), DVec2::splat(3.2))]
}

fn church(land: &Land, town: [i64; 2]) -> [Solid; 2] {
    let [nave, tower] = church_uv().map(|(uv, half)| body(land, town, uv, half, true));
    let (wall, front) = (Tone::new(236.0, 228.0, 212.0), Front::Church);
    let nave = Solid { eave: nave.eave + 9.0, rise: 6.5, wall, front, cover: Tone::new(142.0, 74.0, 60.0), ..nave };
    let slate = Tone::new(86.0, 100.0, 104.0);
    [nave, Solid { eave: tower.eave + 20.0, rise: 15.0, roof: Roof::Spire, wall, front, cover: slate, ..tower }]
}

/// A car at the side of one of the two streets of a block, as a body and a cabin.
fn car(land: &Land, block: &Block, slot: i64) -> [Solid; 2] {
    let hash = |what: i64| block.hash(land, slot, layer::CAR + what);
    let along = 8.0 + 5.6 * (slot / 2) as f64 + hash(1);
    let along_u = slot % 2 == 0;
    let from_street = STREET - 1.05;
    let offset = if along_u { DVec2::new(along, from_street) } else { DVec2::new(from_street, along.min(38.0)) };
    let half = if along_u { DVec2::new(2.1, 0.85) } else { DVec2::new(0.85, 2.1) };
    // The main road is wider, and nobody parks on it.
    let beside = if !along_u && block.at[0] == 0 { ROAD - 1.05 - from_street } else { 0.0 };
    let car = body(land, block.town, block.low() + offset + DVec2::new(beside, 0.0), half, along_u);
    let paint = pick(&PAINT, hash(2));
    let ground = car.eave;
    let lower = Solid {
        base: ground + 0.2,
        eave: ground + 0.85,
        roof: Roof::Flat,
        wall: paint,
        cover: paint * 1.05,
        class: 1,
        ..car
    };
    let cabin = Solid {
        center: lower.center - 0.25 * lower.axis,
        half: DVec2::new(1.15, 0.75),
        base: lower.eave,
        eave: ground + 1.45,
        wall: Tone::new(50.0, 58.0, 66.0),
        ..lower.clone()
    };
    [lower, cabin]
}

/// Lamps along a block's streets.
pub(super) fn lamps(land: &Land, block: &Block) -> Vec<Post> {
    let places = [DVec2::new(10.0, 3.6), DVec2::new(35.0, 3.6), DVec2::new(3.6, 27.0)];
    let lamp = |offset: DVec2| {
        let at = land.position(block.low() + offset, block.town);
        Post {
            foot: DVec3::new(at.x, at.y, land.height(at)),
            height: 5.2,
            radius: 0.07,
            tone: Tone::new(92.0, 98.0, 100.0),
            head: Some((0.28, Tone::new(255.0, 236.0, 190.0))),
            class: 1,
        }
    };
    places.map(lamp).into()
}

/// The bridge of the main road and its railings, near a position.
pub(super) fn bridge(land: &Land, near: DVec2) -> [Solid; 3] {
    let town = land.place(near).town;
    let uv = DVec2::new(0.0, -land.river_gap(DVec2::ZERO, town));
    let half = DVec2::new(ROAD + 0.9, land.river + 9.0);
    let deck = body(land, town, uv, half, false);
    let ends = [-1.0, 1.0].map(|end| land.height(deck.center + end * deck.half.x * deck.axis));
    let level = ends[0].max(ends[1]) + 0.1;
    let stone = Tone::new(176.0, 166.0, 150.0);
    let cover = Tone::new(122.0, 120.0, 120.0);
    let deck = Solid { base: level - 0.9, eave: level, roof: Roof::Flat, wall: stone, cover, class: BRIDGE, ..deck };
    let rail = |side: f64| Solid {
        center: deck.center + side * (half.x - 0.15) * deck.axis.perp(),
        half: DVec2::new(deck.half.x, 0.15),
        base: level,
        eave: level + 0.9,
        cover: stone,
        ..deck.clone()
    };
    [rail(-1.0), rail(1.0), deck.clone()]
}
