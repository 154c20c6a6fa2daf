//! Buildings on the plan of a town: houses with chimneys, a church, a bridge; parked cars and lamps.

use glam::{DVec2, DVec3};

use super::ground::ROAD;
use super::land::Land;
use super::light::Tone;
use super::posts::Post;
use super::solids::{BRIDGE, Front, Roof, Solid};
use super::town::{Lot, STREET, TownBlock, church_uv, layer};

/// Key of the hashes of cars.
const CAR: i64 = 80;

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

/// Returns the bodies of a block: houses with chimneys, the church, parked cars.
pub(super) fn solids(land: &Land, block: &TownBlock) -> Vec<Solid> {
    let mut solids: Vec<Solid> = block.lots(land).flat_map(|lot| house(land, block.town, &lot)).collect();
    if block.is_square() {
        solids.extend(church(land, block.town));
    }
    for slot in 0..14 {
        if block.hash(land, slot, CAR) < 0.35 {
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

fn church(land: &Land, town: [i64; 2]) -> [Solid; 2] {
    let [nave, tower] = church_uv().map(|(uv, half)| body(land, town, uv, half, true));
    let (wall, front) = (Tone::new(236.0, 228.0, 212.0), Front::Church);
    let nave = Solid { eave: nave.eave + 9.0, rise: 6.5, wall, front, cover: Tone::new(142.0, 74.0, 60.0), ..nave };
    let slate = Tone::new(86.0, 100.0, 104.0);
    [nave, Solid { eave: tower.eave + 20.0, rise: 15.0, roof: Roof::Spire, wall, front, cover: slate, ..tower }]
}

/// A car at the side of one of the two streets of a block, as a body and a cabin.
fn car(land: &Land, block: &TownBlock, slot: i64) -> [Solid; 2] {
    let hash = |what: i64| block.hash(land, slot, CAR + what);
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
pub(super) fn lamps(land: &Land, block: &TownBlock) -> Vec<Post> {
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

/// Returns the bridge of the main road and its railings, near a position.
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
