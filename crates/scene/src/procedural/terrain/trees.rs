//! Trees and bushes: where they grow, and where in their crowns leaves are.

use glam::{DVec2, DVec3};

use super::super::random::{Random, unit_circle};
use super::ground::{Cover, cover};
use super::land::{Land, StreetPlace, smooth};
use super::light::Tone;
use super::posts::Post;
use super::town;

/// Side of the cells that hold one tree at most, meters; no crown is wider than two of them.
const CELL: f64 = 6.0;

/// Keys of noises and hashes.
mod layer {
    pub(super) const TREE: i64 = 90;
    pub(super) const STANDS: i64 = 110;
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum TreeKind {
    /// Round crowns of lobes.
    Broad,
    Birch,
    /// Cones of whorls.
    Spruce,
    /// Leaves down to the ground.
    Bush,
}

/// A tree. Lengths in meters.
#[derive(Debug, Clone)]
pub(super) struct Tree {
    pub(super) foot: DVec3,
    height: f64,
    /// Radius of the crown, around the trunk.
    pub(super) radius: f64,
    kind: TreeKind,
    /// Color of its leaves before light.
    pub(super) tone: Tone,
    /// Balls that leaves are in: middle and radius.
    lobes: [(DVec3, f64); 7],
}

/// A leaf.
pub(super) struct Leaf {
    pub(super) z: f64,
    pub(super) normal: DVec3,
    /// 0 at the lowest, 1 at the highest leaf of the tree.
    pub(super) up: f64,
}

impl Tree {
    fn new(land: &Land, at: DVec2, kind: TreeKind, size: f64, key: [i64; 2]) -> Self {
        let hash = |what: i64| land.hash(key[0], key[1], layer::TREE + 8 + what);
        let foot = at.extend(land.height(at));
        let (height, slim) = match kind {
            TreeKind::Broad => (size * (9.0 + 7.0 * hash(0)), 0.33),
            TreeKind::Birch => (size * (9.0 + 5.0 * hash(0)), 0.2),
            TreeKind::Spruce => (size * (11.0 + 10.0 * hash(0)), 0.19),
            TreeKind::Bush => (size * (1.4 + 2.0 * hash(0)), 0.62),
        };
        let radius = (slim * height * (0.85 + 0.3 * hash(1))).min(0.95 * CELL);
        let leaves = match kind {
            TreeKind::Broad => Tone::new(86.0, 124.0, 50.0).lerp(Tone::new(142.0, 150.0, 62.0), hash(2) * hash(2)),
            TreeKind::Birch => Tone::new(142.0, 164.0, 76.0),
            TreeKind::Spruce => Tone::new(76.0, 114.0, 76.0),
            TreeKind::Bush => Tone::new(104.0, 136.0, 62.0),
        };
        let tone = leaves * (0.86 + 0.28 * hash(3));
        let mut tree = Self { foot, height, radius, kind, tone, lobes: [(foot, 0.0); 7] };
        tree.grow(hash);
        tree
    }

    /// A lobe at the top of the crown, the others around its middle.
    fn grow(&mut self, hash: impl Fn(i64) -> f64) {
        let low = if self.kind == TreeKind::Bush { 0.3 } else { 0.55 };
        let turn = hash(4);
        for (i, lobe) in self.lobes.iter_mut().enumerate() {
            let i = i as i64;
            let radius = self.radius * (0.46 + 0.14 * hash(5 + i));
            let (cos, sin) = unit_circle(turn + (i as f64 + 0.5 * hash(12 + i)) / 6.0);
            let out = if i == 6 { 0.15 } else { 1.0 } * (self.radius - radius);
            let share = if i == 6 { 1.0 } else { low + (0.92 - low) * hash(19 + i) };
            let z = (share * self.height - radius).max(radius * 0.6);
            *lobe = (self.foot + DVec3::new(out * cos, out * sin, z), radius);
        }
    }

    pub(super) fn top(&self) -> f64 {
        self.foot.z + self.height
    }

    /// The lowest leaves.
    fn low(&self) -> f64 {
        match self.kind {
            TreeKind::Spruce => self.foot.z + 0.1 * self.height,
            _ => self.lobes.iter().map(|(center, radius)| center.z - radius).fold(f64::INFINITY, f64::min),
        }
    }

    /// Returns `true` if the crown is over a position, or under it.
    pub(super) fn covers(&self, p: DVec2) -> bool {
        let d2 = p.distance_squared(self.foot.truncate());
        d2 < self.radius * self.radius
            && (self.kind == TreeKind::Spruce
                || self.lobes.iter().any(|(c, r)| c.truncate().distance_squared(p) < r * r))
    }

    /// Returns `true` if a position is within the crown.
    pub(super) fn shades(&self, p: DVec3) -> bool {
        match self.kind {
            TreeKind::Spruce => p.truncate().distance(self.foot.truncate()) < 0.8 * self.cone_radius(p.z),
            _ => self.lobes.iter().any(|(center, radius)| center.distance_squared(p) < 0.8 * radius * radius),
        }
    }

    fn cone_radius(&self, z: f64) -> f64 {
        if z < self.low() { 0.0 } else { self.radius * (self.top() - z) / (self.top() - self.low()) }
    }

    /// Returns a leaf over a position that the crown covers.
    pub(super) fn leaf(&self, p: DVec2, random: &mut Random) -> Option<Leaf> {
        let (z, out) = if self.kind == TreeKind::Spruce { self.needle(p, random) } else { self.lobe_leaf(p, random)? };
        let normal = (out + 0.55 * random.direction()).normalize_or(DVec3::Z);
        let low = self.low();
        Some(Leaf { z, normal, up: ((z - low) / (self.top() - low)).clamp(0.0, 1.0) })
    }

    /// Places a leaf in the outer parts of a lobe, most of all its upper half.
    fn lobe_leaf(&self, p: DVec2, random: &mut Random) -> Option<(f64, DVec3)> {
        let over = |(center, radius): &&(DVec3, f64)| center.truncate().distance_squared(p) < radius * radius;
        let count = self.lobes.iter().filter(over).count();
        let (center, radius) = self.lobes.iter().filter(over).nth(random.index(count))?;
        let d = p - center.truncate();
        let half = (radius * radius - d.length_squared()).max(0.0).sqrt();
        let inward = random.unit() * random.unit();
        let rise = half * (1.0 - inward) * if random.unit() < 0.72 { 1.0 } else { -1.0 };
        Some((center.z + rise, d.extend(rise) / *radius))
    }

    /// Places a needle on drooping whorls, most of all near the surface of the cone.
    fn needle(&self, p: DVec2, random: &mut Random) -> (f64, DVec3) {
        let d = p - self.foot.truncate();
        let r = d.length();
        let low = self.low();
        let high = low + (self.top() - low) * (1.0 - r / self.radius).max(0.0);
        let step = 0.055 * self.height;
        let along = random.unit();
        let z = low + (high - low) * (1.0 - along * along);
        let whorl = low + step * ((z - low + 0.35 * r) / step).round() - 0.35 * r;
        let z = whorl + 0.3 * step * (random.unit() - 0.5);
        (z.clamp(low, high), (d / r.max(0.1)).extend(0.55))
    }

    /// Returns its trunk, as far up as it is bare or seen through leaves.
    pub(super) fn trunk(&self) -> Option<Post> {
        let bark = match self.kind {
            TreeKind::Bush => return None,
            TreeKind::Birch => Tone::new(214.0, 210.0, 200.0),
            TreeKind::Broad => Tone::new(112.0, 92.0, 74.0),
            TreeKind::Spruce => Tone::new(110.0, 82.0, 64.0),
        };
        let height = if self.kind == TreeKind::Spruce { 0.3 } else { 0.5 } * self.height;
        let radius = 0.012 * self.height + 0.03;
        Some(Post { foot: self.foot, height, radius, tone: bark, head: None, class: 5 })
    }
}

/// Returns the trees of a square from its lowest corner; its sides are in meters.
pub(super) fn trees(land: &Land, low: DVec2, side: f64) -> Vec<Tree> {
    let first = (low / CELL).floor();
    let last = ((low + side) / CELL).floor();
    let mut trees = Vec::new();
    for y in first.y as i64..=last.y as i64 {
        for x in first.x as i64..=last.x as i64 {
            trees.extend(candidate(land, [x, y]));
        }
    }
    trees
}

/// The tree of a cell, if one grows there.
fn candidate(land: &Land, cell: [i64; 2]) -> Option<Tree> {
    let hash = |what: i64| land.hash(cell[0], cell[1], layer::TREE + what);
    let jitter = DVec2::new(hash(0), hash(1)) * 0.8 + 0.1;
    let p = CELL * (DVec2::new(cell[0] as f64, cell[1] as f64) + jitter);
    let place = land.place(p);
    let (kind, size) = kind(land, p, &place, hash(2), hash(3))?;
    Some(Tree::new(land, p, kind, size, cell))
}

/// Returns what grows at a place, by chance, and how large in comparison with others.
fn kind(land: &Land, p: DVec2, place: &StreetPlace, chance: f64, which: f64) -> Option<(TreeKind, f64)> {
    let or_bush = |tree: TreeKind, share: f64| if which < share { (tree, 0.75) } else { (TreeKind::Bush, 1.0) };
    let grows = match cover(land, p, place) {
        Cover::Forest => (chance < 0.94).then(|| (stand(land, p, place, which), 1.0)),
        Cover::Shore => (chance < 0.5).then(|| or_bush(TreeKind::Broad, 0.35)),
        Cover::Meadow => (chance < 0.025).then(|| or_bush(TreeKind::Broad, 0.5)),
        Cover::Field(parcel) => {
            (parcel.hedge && parcel.edge < 3.0 && chance < 0.8).then(|| or_bush(TreeKind::Broad, 0.3))
        }
        Cover::Park => (chance < 0.4).then(|| or_bush(TreeKind::Broad, 0.8)),
        Cover::Yard => {
            (chance < 0.35).then(|| or_bush(if which < 0.1 { TreeKind::Birch } else { TreeKind::Broad }, 0.45))
        }
        Cover::Plaza => (chance < 0.08).then_some((TreeKind::Broad, 0.7)),
        Cover::Water | Cover::Road | Cover::Pavement => None,
    };
    let built = matches!(cover(land, p, place), Cover::Yard | Cover::Plaza);
    grows.filter(|(kind, _)| !built || town::has_room(land, place, if *kind == TreeKind::Bush { 1.5 } else { 3.0 }))
}

/// The kind of a tree in a forest: spruces higher up, birches here and there.
fn stand(land: &Land, p: DVec2, place: &StreetPlace, which: f64) -> TreeKind {
    let patches = land.noise(p / 85.0, layer::STANDS) + 0.5 * land.noise(p / 26.0, layer::STANDS + 1);
    let spruce = smooth(0.5 + 1.3 * patches + 0.8 * (land.upland(place) - 0.6));
    if which < 0.08 {
        TreeKind::Birch
    } else if which < 0.08 + 0.88 * spruce {
        TreeKind::Spruce
    } else {
        TreeKind::Broad
    }
}
