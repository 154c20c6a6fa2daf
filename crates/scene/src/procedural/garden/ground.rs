//! The ground: lawn with slight relief, path, flower beds; terrace and fence on it.

use glam::{DVec2, DVec3};

use super::super::Error;
use super::super::random::{Random, dither, hash, noise};
use super::house::{HALF_X, HALF_Y};
use super::model::{Model, class};
use super::paint::{Paint, linear};
use super::scan::{Sample, density, hidden_by_tripod, samples};

/// Half the sides of the lot, meters; beyond it the scan fades out.
const LOT: DVec2 = DVec2::new(10.6, 9.4);

/// Lowest x and y of the terrace, then highest.
const DECK: [f64; 4] = [4.9, -6.3, 8.5, -2.9];

/// Returns the height of the ground, flat near the house.
pub(super) fn height(x: f64, y: f64) -> f64 {
    let away = (DVec2::new(x, y).abs() - DVec2::new(5.5, 5.0)).max(DVec2::ZERO).length();
    let relief = noise(DVec3::new(0.23 * x, 0.23 * y, 0.5)) - 0.5;
    0.55 * relief * (away / 4.0).min(1.0) + 0.02 * (noise(DVec3::new(1.3 * x, 1.3 * y, 9.0)) - 0.5)
}

/// Share of the points left toward the edge of the lot, whose outline is uneven.
fn fade(p: DVec2) -> f64 {
    let outside = (p.abs() - (LOT - 1.8)).max(DVec2::ZERO).length();
    let ragged = outside / 1.8 + 0.9 * (noise(DVec3::new(0.8 * p.x, 0.8 * p.y, 3.0)) - 0.5);
    (1.6 - 1.4 * ragged).clamp(0.0, 1.0)
}

/// About `count` points of the ground and their spacing near a scanner.
pub(super) fn ground(count: usize, random: &mut Random) -> Result<(Vec<Sample>, f64), Error> {
    let half = LOT + 1.2;
    let keep = |p: DVec2| {
        let indoors = p.x.abs() < HALF_X && p.y.abs() < HALF_Y;
        let at = p.extend(0.0);
        if indoors || hidden_by_tripod(at) { 0.0 } else { fade(p) * density(at) }
    };
    let cells = 96;
    let grid = (0..cells * cells).map(|i| {
        let cell = DVec2::new(f64::from(i % cells), f64::from(i / cells)) + 0.5;
        keep((2.0 * cell / f64::from(cells) - 1.0) * half)
    });
    let area = 4.0 * half.x * half.y * grid.sum::<f64>() / f64::from(cells * cells);
    let spacing = (area / count.max(1) as f64).sqrt();
    let (columns, rows) = ((2.0 * half.x / spacing).round() as usize, (2.0 * half.y / spacing).round() as usize);
    let mut out = samples(count)?;
    for row in 0..rows {
        for column in 0..columns {
            let cell = DVec2::new(column as f64, row as f64) + 0.5;
            let jitter = 0.9 * DVec2::new(random.unit() - 0.5, random.unit() - 0.5);
            let p = (2.0 * (cell + jitter) / DVec2::new(columns as f64, rows as f64) - 1.0) * half;
            if dither(column, row) < keep(p) {
                out.push(place(p, random));
            }
        }
    }
    Ok((out, spacing))
}

fn place(p: DVec2, random: &mut Random) -> Sample {
    // Central differences over 10 cm.
    let slope = |d: DVec2| (height(p.x + d.x, p.y + d.y) - height(p.x - d.x, p.y - d.y)) / 0.1;
    let normal = DVec3::new(-slope(DVec2::new(0.05, 0.0)), -slope(DVec2::new(0.0, 0.05)), 1.0).normalize();
    let (albedo, blade, class) = look(p, random);
    let position = p.extend(height(p.x, p.y) + blade * random.unit());
    // Blades of grass lean every way.
    let normal = (normal + 5.0 * blade * random.direction()).normalize_or(DVec3::Z);
    Sample { position, normal, albedo, class }
}

/// Color, height of the grass and class.
fn look(p: DVec2, random: &mut Random) -> (DVec3, f64, u8) {
    let grain = 0.86 + 0.28 * random.unit();
    if let Some(stone) = flagstone(p) {
        return (linear([196, 186, 170]) * (0.8 + 0.35 * stone) * grain, 0.005, class::GROUND);
    }
    let [x0, y0, x1, y1] = DECK;
    let under_deck = p.x > x0 && p.y > y0 && p.x < x1 && p.y < y1;
    let bed = p.x.abs() < 4.05 && (-4.1..-HALF_Y).contains(&p.y);
    if bed || under_deck {
        return (linear([112, 82, 60]) * grain, 0.02, class::GROUND);
    }
    let at = |scale: f64, layer: f64| noise(DVec3::new(scale * p.x, scale * p.y, layer));
    let mix = (0.5 * at(0.45, 20.0) + 0.3 * at(1.9, 21.0) + 0.2 * at(8.0, 22.0) - 0.25).clamp(0.0, 0.5) * 2.0;
    let green = linear([72, 118, 44]).lerp(linear([126, 156, 64]), mix);
    // Mown in stripes.
    let mown = if (p.x / 0.9).floor() % 2.0 == 0.0 { 1.06 } else { 0.94 };
    if hash((p.x * 14.0).floor() as i64, (p.y * 14.0).floor() as i64, 40) < 0.003 {
        return (linear([250, 232, 120]), 0.05, class::LOW_VEGETATION);
    }
    (green * mown * grain, 0.035, class::GROUND)
}

/// The tone of the stone of the path under `p`, from the door to the gate and over to the terrace.
fn flagstone(p: DVec2) -> Option<f64> {
    let bend = 0.5 * (noise(DVec3::new(0.3 * p.y, 0.0, 60.0)) - 0.5);
    let to_gate = (p.x + 0.6 + bend).abs() < 0.62 && p.y < -HALF_Y && p.y > -8.6;
    let to_terrace = (p.y + 4.75 + bend).abs() < 0.5 && (-0.6..5.0).contains(&p.x);
    if !to_gate && !to_terrace {
        return None;
    }
    // Cells of a jittered grid around its nearest stone; the rest is grass between the stones.
    let scaled = p / 0.52;
    let cell = scaled.floor();
    let mut distances = [f64::INFINITY; 2];
    let mut tone = 0.0;
    for i in 0..9 {
        let c = cell + DVec2::new(f64::from(i % 3) - 1.0, f64::from(i / 3) - 1.0);
        let (x, y) = (c.x as i64, c.y as i64);
        let center = c + DVec2::new(0.25 + 0.5 * hash(x, y, 50), 0.25 + 0.5 * hash(x, y, 51));
        let d = center.distance(scaled);
        if d < distances[0] {
            distances = [d, distances[0]];
            tone = hash(x, y, 52);
        } else if d < distances[1] {
            distances[1] = d;
        }
    }
    (distances[1] - distances[0] > 0.13).then_some(tone)
}

/// Returns the terrace's deck and the picket fence with its gate.
pub(super) fn built() -> Model {
    let mut model = Model::new(class::BUILDING);
    let [x0, y0, x1, y1] = DECK;
    model.cuboid([x0, y0, 0.0], [x1, y1, 0.1], Paint::boards([178, 136, 98], 0.15));
    let white = Paint::plain([238, 236, 230]);
    let fence = |model: &mut Model, from: f64, to: f64| {
        for z in [0.3, 0.7] {
            model.cuboid([from, -8.02, z], [to, -7.98, z + 0.07], white);
        }
        let pickets = ((to - from) / 0.16) as u32;
        for i in 0..=pickets {
            let x = from + 0.16 * f64::from(i);
            let top = 0.9 + if i % 12 == 0 { 0.15 } else { 0.0 };
            model.cuboid([x - 0.04, -8.04, height(x, -8.0)], [x + 0.04, -8.02, top], white);
        }
    };
    fence(&mut model, -9.4, -1.2);
    fence(&mut model, 0.0, 9.6);
    model
}
