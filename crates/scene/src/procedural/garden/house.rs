//! The house: walls and roof as thin skins, and the timber frame, trims and chimney that stay solid.

use glam::DVec3;

use super::model::{Model, class};
use super::paint::Paint;
use super::shape::PatchShape;

/// Plan of the house: 8 m by 6 m around the origin, with the ridge along x.
pub(super) const HALF_X: f64 = 4.0;
pub(super) const HALF_Y: f64 = 3.0;
pub(super) const FLOOR: f64 = 0.3;
const EAVES: f64 = 2.9;
const RIDGE: f64 = 5.1;
const OVERHANG: f64 = 0.45;
/// Rise of the roof over a meter.
const SLOPE: f64 = (RIDGE - EAVES) / HALF_Y;
/// The wall between living room and bedroom.
pub(super) const PARTITION_X: f64 = 1.3;

/// An outer wall seen from outside: its lower left corner, its direction, its length and its openings.
struct Wall {
    corner: DVec3,
    along: DVec3,
    length: f64,
    /// Start and end along the wall, sill and lintel above the floor; a sill at 0 makes a door.
    openings: &'static [[f64; 4]],
}

fn walls() -> [Wall; 4] {
    let corner = |x: f64, y: f64| DVec3::new(x, y, FLOOR);
    [
        Wall {
            corner: corner(-HALF_X, -HALF_Y),
            along: DVec3::X,
            length: 2.0 * HALF_X,
            openings: &[[0.7, 2.1, 0.9, 2.1], [2.9, 3.9, 0.0, 2.1], [5.6, 7.4, 0.9, 2.1]],
        },
        Wall {
            corner: corner(HALF_X, -HALF_Y),
            along: DVec3::Y,
            length: 2.0 * HALF_Y,
            openings: &[[1.2, 2.6, 0.9, 2.1]],
        },
        Wall {
            corner: corner(HALF_X, HALF_Y),
            along: -DVec3::X,
            length: 2.0 * HALF_X,
            openings: &[[1.0, 2.2, 1.1, 2.1], [5.0, 6.6, 0.9, 2.1]],
        },
        Wall {
            corner: corner(-HALF_X, HALF_Y),
            along: -DVec3::Y,
            length: 2.0 * HALF_Y,
            openings: &[[3.6, 5.2, 1.1, 2.1]],
        },
    ]
}

/// Walls, gables, partition, glass and roof: the parts one wants to look through.
pub(super) fn structure() -> Model {
    let mut model = Model::new(class::BUILDING);
    let plaster = Paint::boards([196, 210, 220], 0.2);
    for wall in walls() {
        pierced(&mut model, &wall, EAVES - FLOOR, plaster);
        for &[l0, l1, h0, h1] in wall.openings.iter().filter(|o| o[2] > 0.0) {
            let corner = wall.corner + l0 * wall.along + h0 * DVec3::Z;
            let shape = PatchShape::Quad { corner, u: (l1 - l0) * wall.along, v: (h1 - h0) * DVec3::Z };
            // Glass returns few of a scanner's pulses.
            model.add_weighted(shape, Paint::plain([190, 220, 235]), 0.4);
        }
    }
    for side in [-1.0, 1.0] {
        let middle = DVec3::new(side * HALF_X, 0.0, EAVES);
        for half in [-1.0, 1.0] {
            let (u, v) = (half * HALF_Y * DVec3::Y, (RIDGE - EAVES) * DVec3::Z);
            let (u, v) = if side * half > 0.0 { (u, v) } else { (v, u) };
            model.add(PatchShape::Triangle { corner: middle, u, v }, plaster);
        }
        roof(&mut model, side);
    }
    let partition = Wall {
        corner: DVec3::new(PARTITION_X, -HALF_Y, FLOOR),
        along: DVec3::Y,
        length: 2.0 * HALF_Y,
        openings: &[[2.2, 3.1, 0.0, 2.05]],
    };
    pierced(&mut model, &partition, EAVES - FLOOR, Paint::plain([236, 228, 212]));
    model
}

/// The roof's side toward −y or +y.
fn roof(model: &mut Model, side: f64) {
    let run = HALF_Y + OVERHANG;
    let u = -side * 2.0 * (HALF_X + OVERHANG) * DVec3::X;
    let v = DVec3::new(0.0, -side * run, run * SLOPE);
    let corner = DVec3::new(0.0, side * run, RIDGE - run * SLOPE) - 0.5 * u;
    model.quad(corner, u, v, Paint::tiles([190, 84, 58]));
}

/// A wall less its openings, as the rectangles between their edges.
fn pierced(model: &mut Model, wall: &Wall, height: f64, paint: Paint) {
    let mut cuts: Vec<f64> = wall.openings.iter().flat_map(|o| [o[0], o[1]]).chain([0.0, wall.length]).collect();
    cuts.sort_by(f64::total_cmp);
    for (l0, l1) in cuts.iter().zip(cuts.iter().skip(1)) {
        let opening = wall.openings.iter().find(|o| o[0] <= *l0 && *l1 <= o[1]);
        let spans = opening.map_or([[0.0, height], [0.0, 0.0]], |o| [[0.0, o[2]], [o[3], height]]);
        for [h0, h1] in spans.into_iter().filter(|[h0, h1]| h1 > h0) {
            let corner = wall.corner + *l0 * wall.along + h0 * DVec3::Z;
            model.quad(corner, (l1 - l0) * wall.along, (h1 - h0) * DVec3::Z, paint);
        }
    }
}

/// Timber, trims, plinth, steps and chimney.
pub(super) fn frame() -> Model {
    let mut model = Model::new(class::BUILDING);
    for wall in walls() {
        trims(&mut model, &wall);
    }
    timber(&mut model);
    let stone = Paint::bricks([150, 146, 140]);
    let (x, y) = (HALF_X + 0.04, HALF_Y + 0.04);
    for (corner, u) in
        [([-x, -y], [2.0 * x, 0.0]), ([x, -y], [0.0, 2.0 * y]), ([x, y], [-2.0 * x, 0.0]), ([-x, y], [0.0, -2.0 * y])]
    {
        let (corner, u) = (DVec3::new(corner[0], corner[1], 0.0), DVec3::new(u[0], u[1], 0.0));
        model.quad(corner, u, FLOOR * DVec3::Z, stone);
    }
    model.cuboid([-1.3, -HALF_Y - 0.45, 0.0], [0.1, -HALF_Y - 0.04, 0.22], stone);
    model.cuboid([-1.4, -HALF_Y - 0.85, 0.0], [0.2, -HALF_Y - 0.45, 0.11], stone);
    let brick = Paint::bricks([168, 74, 56]);
    model.cuboid([-3.6, 0.45, 3.9], [-3.0, 1.05, 5.75], brick);
    model.cuboid([-3.66, 0.39, 5.75], [-2.94, 1.11, 5.87], Paint::plain([120, 112, 106]));
    model
}

/// White boards around the openings, bars in the windows, the door ajar.
fn trims(model: &mut Model, wall: &Wall) {
    let white = Paint::plain([244, 242, 236]);
    let out = wall.along.cross(DVec3::Z);
    let at = |l: f64, h: f64| wall.corner + l * wall.along + h * DVec3::Z + 0.02 * out;
    for &[l0, l1, h0, h1] in wall.openings {
        let mut bar = |from: [f64; 2], to: [f64; 2], width: f64| {
            model.beam(at(from[0], from[1]), at(to[0], to[1]), width, out, white);
        };
        bar([l0, h0], [l0, h1], 0.11);
        bar([l1, h0], [l1, h1], 0.11);
        bar([l0 - 0.06, h1], [l1 + 0.06, h1], 0.11);
        if h0 > 0.0 {
            bar([l0 - 0.1, h0], [l1 + 0.1, h0], 0.11);
            let (l, h) = (0.5 * (l0 + l1), 0.5 * (h0 + h1));
            bar([l, h0], [l, h1], 0.05);
            bar([l0, h], [l1, h], 0.05);
        } else {
            // The leaf opens inward by a third of a right angle.
            let leaf = (l1 - l0 - 0.1) * (0.866 * wall.along - 0.5 * out);
            let corner = at(l0 + 0.05, 0.02);
            model.block(
                corner + 0.5 * leaf + 0.5 * (h1 - 0.06) * DVec3::Z,
                [0.5 * leaf, 0.02 * leaf.cross(-DVec3::Z).normalize_or(out), 0.5 * (h1 - 0.06) * DVec3::Z],
                Paint::boards([52, 108, 112], 0.14),
            );
        }
    }
}

/// Corner posts, plates, tie beams, rafters and ridge.
fn timber(model: &mut Model) {
    let wood = Paint::plain([150, 104, 62]);
    let white = Paint::plain([244, 242, 236]);
    for (x, y) in [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)] {
        let foot = DVec3::new(x * HALF_X, y * HALF_Y, FLOOR);
        model.beam(foot, foot + (EAVES - FLOOR) * DVec3::Z, 0.16, DVec3::X, white);
    }
    for y in [-HALF_Y, HALF_Y] {
        let end = DVec3::new(HALF_X + OVERHANG, y, EAVES - 0.08);
        model.beam(end - 2.0 * end.x * DVec3::X, end, 0.15, DVec3::Z, wood);
    }
    let ridge = DVec3::new(HALF_X + OVERHANG, 0.0, RIDGE - 0.1);
    model.beam(ridge - 2.0 * ridge.x * DVec3::X, ridge, 0.16, DVec3::Z, wood);
    let run = HALF_Y + OVERHANG;
    for i in 0..=8 {
        let x = (f64::from(i) / 4.0 - 1.0) * (HALF_X + OVERHANG);
        let verge = i == 0 || i == 8;
        for side in [-1.0, 1.0] {
            let foot = DVec3::new(x, side * run, RIDGE - run * SLOPE - 0.05);
            let top = DVec3::new(x, 0.0, RIDGE - 0.05);
            model.beam(foot, top, if verge { 0.14 } else { 0.09 }, DVec3::X, if verge { white } else { wood });
        }
        if i % 2 == 0 && !verge {
            let tie = DVec3::new(x, HALF_Y, EAVES);
            model.beam(tie - 2.0 * HALF_Y * DVec3::Y, tie, 0.12, DVec3::Z, wood);
        }
    }
    // Gutters.
    for side in [-1.0, 1.0] {
        let (y, z, x) = (side * (run + 0.05), RIDGE - run * SLOPE - 0.02, HALF_X + OVERHANG);
        model.tube([-x, y, z], [x, y, z], [0.06, 0.06], Paint::plain([120, 126, 130]));
    }
}
