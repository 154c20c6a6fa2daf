//! Trees, hedge, bushes and flowers: wood and leaves in models of their own.

use glam::DVec3;

use super::super::builder::Rgb;
use super::super::random::Random;
use super::model::{Model, class};
use super::paint::Paint;
use super::shape::PatchShape;

/// Wood and leaves.
pub(super) struct Plants {
    pub(super) wood: Model,
    pub(super) leaves: Model,
}

/// Returns everything that grows but the lawn.
pub(super) fn plants(random: &mut Random) -> Plants {
    let mut plants = Plants { wood: Model::new(class::HIGH_VEGETATION), leaves: Model::new(class::HIGH_VEGETATION) };
    let oak = Species { bark: [104, 78, 58], leaf: [92, 142, 48], crown: 0.7 };
    let birch = Species { bark: [226, 222, 212], leaf: [150, 178, 66], crown: 0.52 };
    let maple = Species { bark: [96, 74, 60], leaf: [206, 120, 44], crown: 0.5 };
    plants.tree(DVec3::new(-7.3, 2.9, 0.0), 2.5, 0.26, &oak, random);
    plants.tree(DVec3::new(6.5, 4.8, 0.0), 2.2, 0.17, &birch, random);
    plants.tree(DVec3::new(-6.8, -4.4, 0.0), 1.7, 0.14, &maple, random);
    plants.spruce(DVec3::new(1.8, 6.2, 0.0), 6.2, random);
    plants.spruce(DVec3::new(4.4, 6.6, 0.0), 4.6, random);
    plants.hedge();
    plants.flower_beds(random);
    plants
}

struct Species {
    bark: Rgb,
    leaf: Rgb,
    /// Radius of a cluster of leaves.
    crown: f64,
}

impl Plants {
    fn tree(&mut self, foot: DVec3, trunk: f64, radius: f64, species: &Species, random: &mut Random) {
        let bark = Paint::boards(species.bark, 0.13);
        let root = foot - 0.1 * DVec3::Z;
        self.wood.add(PatchShape::Tube { from: root, to: foot + 0.4 * DVec3::Z, radii: [1.5 * radius, radius] }, bark);
        let lean = (DVec3::Z + 0.08 * random.direction()).normalize();
        let top = foot + trunk * lean;
        self.wood.add(PatchShape::Tube { from: foot + 0.4 * DVec3::Z, to: top, radii: [radius, 0.75 * radius] }, bark);
        self.branch(top, lean, 0.62 * trunk, 0.7 * radius, 3, species, random);
    }

    /// Limbs from the end of another one, and leaves around those of the last two levels.
    #[expect(clippy::too_many_arguments, reason = "a limb is this many numbers")]
    fn branch(
        &mut self,
        from: DVec3,
        along: DVec3,
        length: f64,
        radius: f64,
        level: u32,
        species: &Species,
        random: &mut Random,
    ) {
        let limbs = if level == 3 { 5 } else { 3 };
        let (side, other) = along.any_orthonormal_pair();
        let start = random.unit();
        for limb in 0..limbs {
            let turn = start + (f64::from(limb) + random.range(-0.2, 0.2)) / f64::from(limbs);
            let (cos, sin) = super::super::random::unit_circle(turn);
            let spread = if limb == limbs - 1 { 0.25 } else { random.range(0.75, 1.15) };
            let direction = (along + spread * (cos * side + sin * other) + 0.25 * DVec3::Z).normalize();
            let end = from + length * random.range(0.8, 1.15) * direction;
            let bark = Paint::plain(species.bark);
            self.wood.add(PatchShape::Tube { from, to: end, radii: [radius, 0.55 * radius] }, bark);
            if level == 0 {
                let size = species.crown * random.range(0.75, 1.2);
                let tint = random.range(0.82, 1.18);
                let leaf = species.leaf.map(|c| (f64::from(c) * tint).min(255.0) as u8);
                let semi = DVec3::new(size, size, 0.75 * size);
                self.leaves.add(PatchShape::Leaves { center: end, semi }, Paint::leaves(leaf));
            }
            if level > 0 {
                self.branch(end, direction, 0.68 * length, 0.52 * radius, level - 1, species, random);
            }
        }
    }

    fn spruce(&mut self, foot: DVec3, height: f64, random: &mut Random) {
        let bark = Paint::plain([92, 66, 50]);
        self.wood.add(PatchShape::Tube { from: foot, to: foot + height * DVec3::Z, radii: [0.14, 0.02] }, bark);
        let whorls = (height / 0.42) as u32;
        for whorl in 1..whorls {
            let share = f64::from(whorl) / f64::from(whorls);
            let reach = 1.65 * (1.0 - share) + 0.18;
            let start = random.unit();
            for arm in 0..6 {
                let (cos, sin) = super::super::random::unit_circle(start + f64::from(arm) / 6.0);
                let base = foot + share * height * DVec3::Z;
                let end = base + reach * DVec3::new(cos, sin, -0.22);
                self.wood.add(PatchShape::Tube { from: base, to: end, radii: [0.025, 0.01] }, bark);
                let green = [46 + (20.0 * random.unit()) as u8, 96 + (24.0 * random.unit()) as u8, 66];
                let along = DVec3::new(cos, sin, 0.0).abs();
                let semi = 0.38 * reach * along + DVec3::new(0.2, 0.2, 0.14);
                let center = base + 0.62 * (end - base);
                self.leaves.add(PatchShape::Leaves { center, semi }, Paint::leaves(green));
            }
        }
    }

    /// Adds the hedge along the back and the left side of the garden.
    fn hedge(&mut self) {
        let mut hedge = Model::new(class::MEDIUM_VEGETATION);
        let green = Paint::leaves([58, 122, 50]);
        let mut row = |x: f64, y: f64, half_x: f64, half_y: f64| {
            let (center, half) = (DVec3::new(x, y, 0.72), DVec3::new(half_x, half_y, 0.72));
            hedge.add_weighted(PatchShape::Hedge { center, half }, green, 12.0);
        };
        row(0.0, 8.0, 10.0, 0.4);
        row(-9.6, 0.6, 0.4, 7.0);
        self.leaves.place(&hedge, 0.0, 0.0, 0.0, 0.0);
    }

    /// Flowers along the front wall, and a few round bushes.
    fn flower_beds(&mut self, random: &mut Random) {
        let mut low = Model::new(class::LOW_VEGETATION);
        let petals: [Rgb; 5] = [[236, 86, 128], [250, 206, 70], [246, 244, 250], [156, 96, 210], [230, 70, 60]];
        for _ in 0..150 {
            let x = random.range(-3.9, 3.9);
            if (-1.6..0.4).contains(&x) {
                continue;
            }
            let center = DVec3::new(x, random.range(-3.95, -3.3), random.range(0.14, 0.2));
            low.add_weighted(
                PatchShape::Leaves { center, semi: DVec3::new(0.13, 0.13, 0.15) },
                Paint::leaves([84, 138, 62]),
                1.6,
            );
            let petal = petals[random.index(petals.len())];
            let center = center + DVec3::new(0.0, -0.03, random.range(0.14, 0.24));
            low.add_weighted(PatchShape::Ball { center, semi: DVec3::splat(0.075) }, Paint::plain(petal), 6.0);
        }
        for (x, y, r) in [
            (-4.7, -3.4, 0.5),
            (4.75, 1.4, 0.55),
            (4.8, 2.5, 0.45),
            (9.2, -1.2, 0.6),
            (9.0, 0.3, 0.5),
            (-4.8, 2.2, 0.6),
        ] {
            let (center, semi) = (DVec3::new(x, y, 0.8 * r), DVec3::new(r, r, 0.85 * r));
            low.add(PatchShape::Leaves { center, semi }, Paint::leaves([96, 148, 74]));
        }
        self.leaves.place(&low, 0.0, 0.0, 0.0, 0.0);
    }
}
