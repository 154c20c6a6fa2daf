//! Furniture of the house and the terrace.

use glam::DVec3;

use super::super::builder::Rgb;
use super::house::{FLOOR, HALF_X, HALF_Y, PARTITION_X};
use super::model::{Model, class};
use super::paint::Paint;
use super::shape::PatchShape;

const OAK: Rgb = [178, 128, 78];
const WALNUT: Rgb = [112, 74, 48];
const WHITE: Rgb = [240, 236, 228];
const STEEL: Rgb = [58, 60, 66];

/// Returns everything of class furniture, and the house's floor.
pub(super) fn furniture() -> Model {
    let mut model = Model::new(class::BUILDING);
    model.cuboid(
        [-HALF_X + 0.02, -HALF_Y + 0.02, FLOOR - 0.04],
        [HALF_X - 0.02, HALF_Y - 0.02, FLOOR],
        Paint::boards([204, 172, 130], 0.16),
    );
    let mut inside = Model::new(class::FURNITURE);
    living_room(&mut inside);
    kitchen(&mut inside);
    bedroom(&mut inside);
    model.place(&inside, 0.0, 0.0, 0.0, FLOOR);
    model.place(&terrace(), 0.0, 0.0, 0.0, 0.0);
    model
}

fn living_room(room: &mut Model) {
    // Dining table with a lamp above it.
    let (x, y) = (-1.1, -0.75);
    room.place(&table(1.7, 0.95, 0.75), 0.0, x, y, 0.0);
    let chair = chair([196, 62, 48]);
    for (dx, dy, turn) in [(-0.42, -0.72, 0.5), (0.42, -0.78, 0.52), (-0.42, 0.74, 0.0), (0.45, 0.7, -0.03)] {
        room.place(&chair, turn, x + dx, y + dy, 0.0);
    }
    room.tube([x, y, 1.75], [x, y, 2.6], [0.012, 0.012], Paint::plain(STEEL));
    room.tube([x, y, 1.52], [x, y, 1.78], [0.26, 0.05], Paint::plain([250, 206, 96]));
    room.ball([x + 0.1, y, 0.81], [0.16, 0.16, 0.06], Paint::plain([230, 232, 236]));
    room.ball([x + 0.06, y + 0.03, 0.88], [0.05, 0.05, 0.05], Paint::plain([226, 140, 40]));
    room.ball([x + 0.15, y - 0.04, 0.88], [0.05, 0.05, 0.05], Paint::plain([170, 190, 60]));
    // Sofa, rug and low table before the back wall.
    room.cuboid([-2.9, 0.75, 0.0], [-0.5, 1.95, 0.015], Paint::stripes([196, 80, 66], [232, 214, 180], 0.2));
    room.place(&sofa(), 0.0, -1.7, 2.45, 0.0);
    room.place(&table(0.95, 0.5, 0.38), 0.0, -1.7, 1.3, 0.0);
    // Floor lamp.
    room.tube([0.05, 2.55, 0.0], [0.05, 2.55, 0.03], [0.17, 0.15], Paint::plain(STEEL));
    room.tube([0.05, 2.55, 0.0], [0.05, 2.55, 1.5], [0.016, 0.016], Paint::plain(STEEL));
    room.tube([0.05, 2.55, 1.4], [0.05, 2.55, 1.72], [0.24, 0.15], Paint::plain([252, 228, 168]));
    room.place(&bookshelf(), 0.0, 0.82, 2.78, 0.0);
    stove(room);
}

/// Iron stove whose pipe leads into the chimney.
fn stove(room: &mut Model) {
    let iron = Paint::plain([46, 46, 50]);
    room.cuboid([-3.75, 0.3, 0.0], [-2.8, 1.25, 0.03], Paint::plain([126, 122, 118]));
    room.cuboid([-3.6, 0.45, 0.12], [-3.0, 1.05, 0.95], iron);
    room.cuboid([-3.65, 0.4, 0.95], [-2.95, 1.1, 1.0], iron);
    room.cuboid([-3.01, 0.55, 0.3], [-2.985, 0.95, 0.75], Paint::plain([255, 148, 44]));
    for (x, y) in [(-3.55, 0.5), (-3.05, 0.5), (-3.05, 1.0), (-3.55, 1.0)] {
        room.tube([x, y, 0.0], [x, y, 0.12], [0.03, 0.03], iron);
    }
    room.tube([-3.3, 0.75, 1.0], [-3.3, 0.75, 3.65], [0.085, 0.085], iron);
}

fn kitchen(room: &mut Model) {
    let front = Paint::stripes([104, 142, 138], [96, 132, 128], 0.6);
    room.cuboid([-3.95, -2.85, 0.08], [-3.32, -0.35, 0.88], front);
    room.cuboid([-3.95, -2.88, 0.88], [-3.28, -0.3, 0.93], Paint::plain(OAK));
    room.cuboid([-3.85, -2.1, 0.935], [-3.42, -1.5, 0.945], Paint::plain([150, 154, 158]));
    room.tube([-3.88, -1.8, 0.93], [-3.88, -1.8, 1.2], [0.018, 0.018], Paint::plain([190, 194, 198]));
    room.cuboid([-3.85, -1.15, 0.935], [-3.4, -0.6, 0.945], Paint::plain([36, 36, 40]));
    room.tube([-3.62, -0.88, 0.945], [-3.62, -0.88, 1.08], [0.13, 0.13], Paint::plain([196, 66, 50]));
    room.cuboid([-3.95, -2.85, 0.0], [-3.33, -2.2, 2.0], Paint::plain(WHITE));
    room.cuboid([-3.97, -0.25, 1.5], [-3.7, 0.2, 1.54], Paint::plain(OAK));
    room.ball([-3.83, 0.0, 1.63], [0.08, 0.08, 0.09], Paint::plain([86, 142, 70]));
}

fn bedroom(room: &mut Model) {
    // Bed with its head at the back wall.
    let (x, y) = (3.0, 1.95);
    room.cuboid([x - 0.85, y - 1.05, 0.12], [x + 0.85, y + 1.0, 0.34], Paint::plain(WALNUT));
    room.cuboid([x - 0.85, y + 0.95, 0.0], [x + 0.85, y + 1.02, 1.05], Paint::boards(WALNUT, 0.2));
    room.cuboid([x - 0.8, y - 1.0, 0.34], [x + 0.8, y + 0.93, 0.54], Paint::plain(WHITE));
    room.cuboid(
        [x - 0.84, y - 1.04, 0.36],
        [x + 0.84, y + 0.25, 0.6],
        Paint::stripes([58, 98, 168], [238, 236, 230], 0.14),
    );
    for side in [-0.4, 0.4] {
        room.ball([x + side, y + 0.62, 0.62], [0.33, 0.22, 0.11], Paint::plain([250, 248, 244]));
    }
    // Bedside table with a lamp.
    room.cuboid([1.62, 2.5, 0.0], [2.02, 2.92, 0.5], Paint::plain(OAK));
    room.tube([1.82, 2.7, 0.5], [1.82, 2.7, 0.72], [0.05, 0.02], Paint::plain(WHITE));
    room.tube([1.82, 2.7, 0.7], [1.82, 2.7, 0.92], [0.15, 0.09], Paint::plain([252, 222, 150]));
    // Wardrobe at the partition, desk under the window.
    room.cuboid(
        [PARTITION_X + 0.03, -2.9, 0.0],
        [PARTITION_X + 0.6, -1.6, 1.95],
        Paint::stripes([196, 172, 138], WHITE, 0.65),
    );
    room.place(&table(1.5, 0.65, 0.74), 0.0, 2.95, -2.55, 0.0);
    room.place(&chair([64, 128, 118]), 0.02, 2.9, -1.95, 0.0);
    room.cuboid([2.75, -2.75, 0.74], [3.25, -2.72, 1.08], Paint::plain([40, 46, 58]));
    room.cuboid([2.8, -2.55, 0.745], [3.2, -2.4, 0.76], Paint::plain([210, 210, 212]));
    room.disc([2.75, -0.2, 0.012], 0.85, Paint::plain([226, 190, 120]));
}

fn terrace() -> Model {
    let mut model = Model::new(class::FURNITURE);
    model.place(&table(1.0, 1.0, 0.72), 0.06, 6.7, -4.6, 0.1);
    let chair = chair([232, 232, 226]);
    for (dx, dy, turn) in [(-0.85, 0.1, 0.24), (0.9, -0.1, 0.77), (0.05, 0.85, 0.01)] {
        model.place(&chair, turn, 6.7 + dx, -4.6 + dy, 0.1);
    }
    model.tube([6.7, -4.6, 0.1], [6.7, -4.6, 2.55], [0.025, 0.025], Paint::plain(WHITE));
    let canopy =
        PatchShape::Tube { from: DVec3::new(6.7, -4.6, 2.1), to: DVec3::new(6.7, -4.6, 2.6), radii: [1.3, 0.03] };
    model.add_weighted(canopy, Paint::stripes([206, 54, 48], [248, 244, 236], 0.5224), 1.8);
    // A bench under the tree.
    let mut bench = Model::new(class::FURNITURE);
    for y in [-0.18, 0.0, 0.18] {
        bench.cuboid([-0.8, y - 0.075, 0.43], [0.8, y + 0.075, 0.46], Paint::plain(OAK));
    }
    for z in [0.62, 0.8] {
        bench.cuboid([-0.8, 0.25, z], [0.8, 0.28, z + 0.12], Paint::plain(OAK));
    }
    for x in [-0.7, 0.7] {
        bench.cuboid([x - 0.03, -0.24, 0.0], [x + 0.03, 0.28, 0.43], Paint::plain(STEEL));
        bench.cuboid([x - 0.03, 0.24, 0.43], [x + 0.03, 0.28, 0.92], Paint::plain(STEEL));
    }
    model.place(&bench, 0.1, -6.4, 0.6, 0.0);
    model
}

fn table(width: f64, depth: f64, height: f64) -> Model {
    let mut model = Model::new(class::FURNITURE);
    let (x, y) = (0.5 * width, 0.5 * depth);
    model.cuboid([-x, -y, height - 0.045], [x, y, height], Paint::boards(OAK, 0.16));
    for (sx, sy) in [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)] {
        let (lx, ly) = (sx * (x - 0.07), sy * (y - 0.07));
        model.cuboid([lx - 0.035, ly - 0.035, 0.0], [lx + 0.035, ly + 0.035, height - 0.045], Paint::plain(OAK));
    }
    model
}

/// A chair whose back is toward +y.
fn chair(seat: Rgb) -> Model {
    let mut model = Model::new(class::FURNITURE);
    model.cuboid([-0.22, -0.22, 0.43], [0.22, 0.22, 0.47], Paint::plain(seat));
    for x in [-0.19, 0.19] {
        model.cuboid([x - 0.02, -0.21, 0.0], [x + 0.02, -0.17, 0.43], Paint::plain(WALNUT));
        model.cuboid([x - 0.02, 0.18, 0.0], [x + 0.02, 0.22, 0.95], Paint::plain(WALNUT));
    }
    for z in [0.6, 0.78] {
        model.cuboid([-0.19, 0.185, z], [0.19, 0.215, z + 0.12], Paint::plain(seat));
    }
    model
}

/// A sofa whose back is toward +y.
fn sofa() -> Model {
    let mut model = Model::new(class::FURNITURE);
    let cloth = Paint::plain([64, 116, 140]);
    model.cuboid([-1.05, -0.42, 0.1], [1.05, 0.42, 0.36], cloth);
    model.cuboid([-1.05, 0.25, 0.36], [1.05, 0.45, 0.88], cloth);
    for x in [-1.12, 0.92] {
        model.cuboid([x, -0.42, 0.1], [x + 0.2, 0.42, 0.62], cloth);
    }
    for x in [-0.46, 0.46] {
        model.ball([x, -0.1, 0.39], [0.46, 0.36, 0.12], Paint::plain([84, 138, 160]));
    }
    model.ball([-0.68, 0.14, 0.62], [0.2, 0.1, 0.2], Paint::plain([240, 190, 70]));
    model.ball([0.66, 0.14, 0.62], [0.2, 0.1, 0.2], Paint::plain([214, 84, 62]));
    model
}

/// Shelves full of books that face −y.
fn bookshelf() -> Model {
    let mut model = Model::new(class::FURNITURE);
    let wood = Paint::plain(WALNUT);
    for x in [-0.47, 0.44] {
        model.cuboid([x, -0.16, 0.0], [x + 0.03, 0.16, 1.9], wood);
    }
    for shelf in 0..=5 {
        let z = 0.05 + 0.365 * f64::from(shelf);
        model.cuboid([-0.44, -0.16, z - 0.015], [0.44, 0.16, z + 0.015], wood);
        if shelf < 5 {
            let end = 0.4 - 0.14 * f64::from(shelf * 2 % 3);
            model.cuboid([-0.43, -0.12, z + 0.02], [end, 0.12, z + 0.27], Paint::books());
        }
    }
    model
}
