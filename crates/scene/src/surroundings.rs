//! Distribution of the points of a scene around its middle: a room that is scanned on all sides is looked at from
//! within, and notes say where a camera that was not given may be a wrong guess.

use glam::{DVec3, Vec3};

use super::framed::Framed;
use super::scene::Scene;
use super::sensor;
use super::settings::{CameraSettings, ShadingModel};
use super::view::Vertical;
use pellucid_core::cloud::depth_camera::hundredths;
use pellucid_core::cloud::{Bounds, UpAxis};
use pellucid_core::color::encode_srgb;
use pellucid_core::points::Points;

/// Points that are looked at, at most.
const SAMPLES: usize = 1 << 18;
/// Fewest points for which a decision is made.
const FEWEST: usize = 1000;
/// Cells of the floor plan along each side.
const CELLS: usize = 24;
/// The lowest and the highest part of the height, as shares of it.
const LAYER: f64 = 0.15;
/// The part of the height between which only walls and furniture stand.
const MIDDLE: [f64; 2] = [0.35, 0.65];
/// The share of cells with floor, ceiling or wall from which on they have one.
const MOST: f64 = 0.6;
/// The share of cells within the walls that furniture may take.
const FURNISHED: f64 = 0.35;
/// The share of the plan's cells that a room has at least.
const ROOM: f64 = 0.4;
/// A side is flat if it is shorter than this share of the others.
const FLAT: f64 = 0.5;
/// Ratio of height to width from which on the X and Y of points may be degrees.
const NEEDLE: f64 = 20.0;
/// Distance from the origin, in widths, that they then have.
const FAR: f64 = 50.0;
/// Largest difference of two sRGB values that can hardly be told apart.
const ALIKE: f32 = 0.1;
/// The share of points in the background's color from which on there is little to see.
const HIDDEN: f64 = 0.9;
/// The brightest channel of a color that is dark, linear: 0.15 in sRGB.
const DARK: f32 = 0.0195;

/// Some of the points by their coordinates along right, front and up, and the range that each has for all but the
/// outermost hundredths.
struct PointSpread {
    axes: [DVec3; 3],
    places: Vec<[f64; 3]>,
    low: [f64; 3],
    high: [f64; 3],
}

impl PointSpread {
    /// Surroundings of the points that are framed. `None` of few.
    fn of(framed: &Framed<'_>, vertical: Vertical) -> Option<Self> {
        if framed.len() < FEWEST {
            return None;
        }
        let axes = [vertical.right(), vertical.front(), vertical.up()];
        let places: Vec<[f64; 3]> = framed.sampled().iter().map(|p| axes.map(|axis| p.dot(axis))).collect();
        if places.is_empty() {
            return None;
        }
        let ranges = [0, 1, 2].map(|axis| hundredths(places.iter().map(|place| place[axis]).collect()));
        Some(Self { axes, places, low: ranges.map(|range| range[0]), high: ranges.map(|range| range[1]) })
    }

    fn side(&self, axis: usize) -> f64 {
        self.high[axis] - self.low[axis]
    }

    /// A point by shares of the ranges.
    fn at(&self, shares: [f64; 3]) -> DVec3 {
        let along = |axis: usize| self.axes[axis] * (self.low[axis] + shares[axis] * self.side(axis));
        along(0) + along(1) + along(2)
    }

    /// A place as shares of the ranges.
    fn shares(&self, place: &[f64; 3]) -> [f64; 3] {
        [0, 1, 2].map(|axis| (place[axis] - self.low[axis]) / self.side(axis))
    }

    /// An eye within a room and a place to look at; `None` unless the points surround their center, as in a room.
    fn within(&self) -> Option<[DVec3; 2]> {
        if (0..3).any(|axis| self.side(axis) <= 0.0) {
            return None;
        }
        let plan = FloorPlan::of(self);
        if !plan.is_room() {
            return None;
        }
        Some([stand(self, &plan)?, self.at([0.5, 0.5, LOOKED_AT])])
    }

    /// The axis along which the points are much flatter than along both others.
    fn flattest(&self) -> Option<usize> {
        (0..3).find(|axis| (0..3).all(|other| other == *axis || self.side(*axis) < FLAT * self.side(other)))
    }
}

/// Parts of the height that have points in a cell of the plan.
#[derive(Clone, Copy, Default)]
struct Cell {
    any: bool,
    floor: bool,
    middle: bool,
    ceiling: bool,
}

/// A plan of the points from above.
struct FloorPlan(Vec<Cell>);

impl FloorPlan {
    fn of(spread: &PointSpread) -> Self {
        let mut cells = vec![Cell::default(); CELLS * CELLS];
        for [x, y, height] in spread.places.iter().map(|place| spread.shares(place)) {
            let Some(cell) = index(x, y).map(|cell| &mut cells[cell]) else { continue };
            cell.any = true;
            cell.floor |= height < LAYER;
            cell.ceiling |= height > 1.0 - LAYER;
            cell.middle |= MIDDLE[0] < height && height < MIDDLE[1];
        }
        Self(cells)
    }

    /// Returns `true` if a cell and all four beside it have points.
    fn is_within(&self, cell: usize) -> bool {
        let (x, y) = (cell % CELLS, cell / CELLS);
        let inner = 1..CELLS - 1;
        inner.contains(&x)
            && inner.contains(&y)
            && [cell, cell - 1, cell + 1, cell - CELLS, cell + CELLS].iter().all(|cell| self.0[*cell].any)
    }

    /// Returns `true` if there are floor and ceiling nearly everywhere, walls nearly all around, and little between
    /// them.
    fn is_room(&self) -> bool {
        let (mut within, mut around): (Vec<Cell>, Vec<Cell>) = (Vec::new(), Vec::new());
        for cell in (0..self.0.len()).filter(|cell| self.0[*cell].any) {
            if self.is_within(cell) { &mut within } else { &mut around }.push(self.0[cell]);
        }
        let all = [within.as_slice(), &around].concat();
        let share = |cells: &[Cell], has: fn(&Cell) -> bool| {
            cells.iter().filter(|cell| has(cell)).count() as f64 / cells.len().max(1) as f64
        };
        all.len() as f64 >= ROOM * self.0.len() as f64
            && within.len() as f64 >= ROOM * all.len() as f64
            && share(&all, |cell| cell.floor) >= MOST
            && share(&all, |cell| cell.ceiling) >= MOST
            && share(&around, |cell| cell.middle) >= MOST
            && share(&within, |cell| cell.middle) <= FURNISHED
    }
}

/// The cell of a place in shares of the plan's sides; `None` outside.
fn index(x: f64, y: f64) -> Option<usize> {
    let column = |share: f64| (0.0..=1.0).contains(&share).then(|| ((share * CELLS as f64) as usize).min(CELLS - 1));
    Some(column(y)? * CELLS + column(x)?)
}

/// Places to stand: as far from the middle as there is room.
const STANDS: [f64; 2] = [0.38, 0.28];
/// Height of the eye, and of what it looks at, as shares of the room's.
const EYE: f64 = 0.6;
/// See [`EYE`].
const LOOKED_AT: f64 = 0.4;
/// The least distance of an eye to points, as a share of the room's height.
const ELBOW_ROOM: f64 = 0.15;

/// An eye in a room: at its side, where nothing is near.
fn stand(spread: &PointSpread, plan: &FloorPlan) -> Option<DVec3> {
    let places: Vec<DVec3> = spread.places.iter().map(|place| DVec3::from(*place)).collect();
    let free = |shares: [f64; 3]| {
        let place = DVec3::from([0, 1, 2].map(|axis| spread.low[axis] + shares[axis] * spread.side(axis)));
        let nearest = places.iter().map(|other| other.distance_squared(place)).fold(f64::INFINITY, f64::min);
        nearest.sqrt() >= ELBOW_ROOM * spread.side(2)
    };
    // Corners first, which see most.
    let corners = [[-1.0, 1.0], [1.0, 1.0], [1.0, -1.0], [-1.0, -1.0]];
    let walls = [[0.0, 1.0], [1.0, 0.0], [0.0, -1.0], [-1.0, 0.0]];
    let stands =
        STANDS.iter().flat_map(|far| corners.iter().chain(&walls).map(move |[x, y]| [0.5 + far * x, 0.5 + far * y]));
    let inside = stands.filter(|[x, y]| index(*x, *y).is_some_and(|cell| plan.is_within(cell)));
    let mut eyes = inside.map(|[x, y]| [x, y, EYE]);
    eyes.find(|eye| free(*eye)).map(|eye| spread.at(eye))
}

/// Returns the settings of a camera within the points, if these surround the middle of the scene as those of a room do:
/// floor and ceiling, and walls around. `None` where the settings say anything of eye, target, view, lens or depths,
/// and of other scenes.
pub(super) fn inside(settings: &CameraSettings, framed: &Framed<'_>, vertical: Vertical) -> Option<CameraSettings> {
    if !settings.leave_place_open() {
        return None;
    }
    let [eye, target] = PointSpread::of(framed, vertical)?.within()?;
    let up = settings.up.unwrap_or(vertical.up());
    Some(CameraSettings { eye: Some(eye), target: Some(target), up: Some(up), ..*settings })
}

/// Returns notes about the camera that [`super::camera`] finds: that it stands where the sensor stood, or within the
/// points, that another axis may be the vertical, and that there may be nothing to see because points have the color of
/// the background.
pub fn camera_notes(scene: &Scene, points: &Points, up: UpAxis) -> Vec<String> {
    let settings = &scene.camera;
    let vertical = settings.vertical(up);
    let mut notes = Vec::new();
    let found = Framed::of(scene, points).filter(|_| settings.eye.is_none());
    let sensor =
        found.as_ref().and_then(|(framed, bounds)| sensor::seen_from(settings, framed, bounds, scene.image.size));
    if let Some(eye) = sensor.and_then(|camera| camera.eye) {
        let [x, y, z] = eye.to_array();
        notes.push(format!(
            "all points were seen from ({x}, {y}, {z}), where their sensor stood, so the camera is placed there; --view iso \
             looks from outside"
        ));
        notes.extend(found.and_then(|(framed, _)| strays(&framed)));
        notes.extend(in_the_background(scene, points));
        return notes;
    }
    let framed = found.map(|(framed, _)| framed);
    let spread = framed.and_then(|framed| PointSpread::of(&framed, vertical));
    if settings.leave_place_open() && spread.as_ref().is_some_and(|spread| spread.within().is_some()) {
        notes.push(
            "the points surround the middle of the scene, as in a room, so the camera is placed inside; --view iso looks \
             from outside"
                .to_owned(),
        );
    }
    if settings.up.is_none() {
        notes.extend(spread.and_then(|spread| flat_along_another(&spread, vertical)));
    }
    notes.extend(framed.and_then(|framed| strays(&framed)));
    notes.extend(points.bounds().and_then(|bounds| in_degrees(&bounds)));
    notes.extend(in_the_background(scene, points));
    notes
}

/// Says that some points are out of the view because they lie far from the others.
fn strays(framed: &Framed<'_>) -> Option<String> {
    let count = match framed.strays() {
        Some(0) => return None,
        Some(1) => "1 point lies".to_owned(),
        Some(count) => format!("{count} points lie"),
        None => "some points lie".to_owned(),
    };
    Some(format!(
        "{count} far from the others and may be out of view; `outliers = \"drop\"` of a cloud leaves such points out, \
         `camera.frame = \"all\"` shows them"
    ))
}

/// Says that X and Y may be degrees of longitude and latitude, where heights are meters: the scene is a needle then.
fn in_degrees(bounds: &Bounds) -> Option<String> {
    let extent = bounds.max - bounds.min;
    let wide = extent.x.max(extent.y);
    let on_earth = bounds.min.x >= -180.0 && bounds.max.x <= 180.0 && bounds.min.y >= -90.0 && bounds.max.y <= 90.0;
    // A mast in coordinates of its own stands near their origin.
    let far = bounds.center().truncate().abs().max_element() > FAR * wide;
    (on_earth && far && wide > 0.0 && extent.z > NEEDLE * wide).then(|| {
        let [x, y, z] = extent.to_array();
        format!(
            "x and y span only {x:.3} and {y:.3}, but z spans {z:.1}: if x and y are in degrees, project them to meters \
             first, as with PDAL"
        )
    })
}

fn flat_along_another(spread: &PointSpread, vertical: Vertical) -> Option<String> {
    let flattest = Vertical::nearest(spread.axes[spread.flattest().filter(|axis| *axis != 2)?])?;
    let axis = ["x", "y", "z"][flattest.index()];
    Some(format!(
        "{vertical} is assumed to be up, but the points are flattest along {axis}; use --up {axis} or --up -{axis} if that \
         axis is up"
    ))
}

/// Says that nearly all points have the background's color, where no shading tells them apart, or that most of them are
/// dark on a dark background.
fn in_the_background(scene: &Scene, points: &Points) -> Option<String> {
    if points.is_empty() {
        return None;
    }
    let picked = || points.colors.iter().step_by(points.len().div_ceil(SAMPLES));
    let share =
        |holds: &dyn Fn(Vec3) -> bool| picked().filter(|color| holds(**color)).count() as f64 / picked().count() as f64;
    let encoded = |color: Vec3| color.to_array().map(encode_srgb);
    let background = encoded(scene.image.background.color());
    let shaded = scene.shading.model != ShadingModel::None && points.normals.is_some();
    let is_alike = |color: Vec3| encoded(color).iter().zip(background).all(|(c, b)| (c - b).abs() <= ALIKE);
    if !shaded && share(&is_alike) >= HIDDEN {
        return Some(
            "nearly all points have the color of the background; choose another --background to see them".to_owned(),
        );
    }
    let is_dark = |color: Vec3| color.max_element() <= DARK;
    (points.len() >= FEWEST && is_dark(scene.image.background.color()) && share(&is_dark) >= 0.5).then(|| {
        format!(
            "{:.0} % of the points are nearly black, like the background; --background white or --color-by height shows \
             more of them",
            100.0 * share(&is_dark)
        )
    })
}

#[cfg(test)]
mod tests {
    use rand::{Rng, RngExt, SeedableRng};
    use rand_pcg::Pcg64Mcg;

    use super::*;

    /// Points at random on the faces of a box of these sides, from a point of a unit square to one of the face.
    fn on_box(sides: DVec3, count: usize, rng: &mut impl Rng) -> Vec<DVec3> {
        (0..count)
            .map(|i| {
                let axis = i % 3;
                let mut p = DVec3::new(rng.random(), rng.random(), rng.random());
                p[axis] = f64::from(rng.random::<bool>());
                p * sides
            })
            .collect()
    }

    fn scene_of(positions: Vec<DVec3>) -> Points {
        pellucid_testing_host::white(positions, 1.0)
    }

    fn z() -> Vertical {
        Vertical::from(UpAxis::Z)
    }

    #[test]
    fn a_room_is_looked_at_from_within() {
        let mut rng = Pcg64Mcg::seed_from_u64(1);
        let sides = DVec3::new(6.0, 5.0, 2.5);
        let room = on_box(sides, 60_000, &mut rng);
        for turn in [0.0, 0.5] {
            let turned = room.iter().map(|p| glam::DQuat::from_rotation_z(turn) * *p).collect();
            let camera = inside(&CameraSettings::default(), &Framed::all(&scene_of(turned)), z()).expect("a room");
            let back = |p: DVec3| glam::DQuat::from_rotation_z(-turn) * p;
            for p in [camera.eye, camera.target] {
                let p = back(p.unwrap());
                assert!(p.cmpgt(0.05 * sides).all() && p.cmplt(0.95 * sides).all(), "{turn}: {p}");
            }
            assert!(camera.eye.unwrap().distance(camera.target.unwrap()) > 1.5);
        }
        let points = scene_of(room);
        let said = [
            CameraSettings { eye: Some(DVec3::ONE), ..CameraSettings::default() },
            CameraSettings { ortho: true, ..CameraSettings::default() },
            CameraSettings { near: Some(0.1), ..CameraSettings::default() },
        ];
        assert!(said.iter().all(|settings| inside(settings, &Framed::all(&points), z()).is_none()));
    }

    #[test]
    fn other_scenes_are_looked_at_from_outside() {
        let mut rng = Pcg64Mcg::seed_from_u64(2);
        let mut random = |count: usize, place: &mut dyn FnMut(&mut Pcg64Mcg) -> DVec3| -> Vec<DVec3> {
            (0..count).map(|_| place(&mut rng)).collect()
        };
        let ball = random(50_000, &mut |rng| {
            let p = DVec3::new(rng.random(), rng.random(), rng.random());
            (p - DVec3::splat(0.5)).normalize_or(DVec3::X)
        });
        let forest = random(50_000, &mut |rng| {
            DVec3::new(50.0 * rng.random::<f64>(), 50.0 * rng.random::<f64>(), 9.0 * rng.random::<f64>())
        });
        let ground = random(50_000, &mut |rng| DVec3::new(rng.random(), rng.random(), 0.01 * rng.random::<f64>()));
        let flat = random(50_000, &mut |rng| DVec3::new(rng.random(), rng.random(), 0.0));
        let open = on_box(DVec3::new(6.0, 5.0, 2.5), 60_000, &mut Pcg64Mcg::seed_from_u64(3));
        let open: Vec<DVec3> = open.into_iter().filter(|p| p.z < 2.4).collect();
        for (name, positions) in
            [("ball", ball), ("forest", forest), ("ground", ground), ("flat", flat), ("no ceiling", open)]
        {
            assert!(inside(&CameraSettings::default(), &Framed::all(&scene_of(positions)), z()).is_none(), "{name}");
        }
    }

    fn notes(text: &str, positions: Vec<DVec3>) -> Vec<String> {
        let text = format!("{text}\n[[cloud]]\npath = 'a.ply'");
        let scene = Scene::from_toml(&text, "s.toml".as_ref()).unwrap();
        camera_notes(&scene, &scene_of(positions), UpAxis::Z)
    }

    #[test]
    fn degrees_beside_meters_are_noted() {
        let mut rng = Pcg64Mcg::seed_from_u64(6);
        let mut spread = |sides: DVec3, at: DVec3| -> Vec<DVec3> {
            (0..2000).map(|_| at + DVec3::new(rng.random(), rng.random(), rng.random()) * sides).collect()
        };
        let place = DVec3::new(-83.4, 39.0, 200.0);
        let said = notes("", spread(DVec3::new(0.02, 0.01, 40.0), place));
        assert!(
            said.iter().any(|note| note.contains("x and y span only 0.020 and 0.010, but z spans 39.9")),
            "{said:?}"
        );
        let others = [
            (DVec3::new(200.0, 100.0, 40.0), DVec3::new(5e5, 4.5e6, 100.0)),
            (DVec3::new(0.5, 0.5, 30.0), DVec3::ZERO),
            (DVec3::new(0.02, 0.01, 0.1), place),
            (DVec3::new(0.5, 0.5, 30.0), DVec3::new(5e5, 4.5e6, 100.0)),
        ];
        for (sides, at) in others {
            let said = notes("", spread(sides, at));
            assert!(!said.iter().any(|note| note.contains("degrees")), "{sides} {at}: {said:?}");
        }
    }

    #[test]
    fn guesses_that_may_be_wrong_are_noted() {
        let mut rng = Pcg64Mcg::seed_from_u64(4);
        let spread = |sides: DVec3, rng: &mut Pcg64Mcg| -> Vec<DVec3> {
            (0..5000).map(|_| DVec3::new(rng.random(), rng.random(), rng.random()) * sides).collect()
        };
        let lying = spread(DVec3::new(10.0, 2.0, 10.0), &mut rng);
        let said = notes("", lying.clone());
        assert!(
            said.len() == 1 && said[0].contains("z is assumed to be up") && said[0].contains("--up y or --up -y"),
            "{said:?}"
        );
        assert!(notes("[camera]\nup = [0, -1, 0]", lying.clone()).is_empty());
        assert!(notes("", spread(DVec3::new(10.0, 10.0, 2.0), &mut rng)).is_empty());
        assert!(notes("", spread(DVec3::new(10.0, 6.0, 10.0), &mut rng)).is_empty(), "not much flatter");
        assert!(notes("", lying[..100].to_vec()).is_empty(), "too few");
        let white = "[image]\nbackground = [1, 0.9, 1]";
        let cube = spread(DVec3::ONE, &mut rng);
        assert!(notes(white, cube.clone())[0].contains("color of the background"));
        let scene = Scene::from_toml(&format!("{white}\n[[cloud]]\npath = 'a.ply'"), "s.toml".as_ref()).unwrap();
        let shaded = Points { normals: Some(vec![Vec3::Z; cube.len()]), ..scene_of(cube.clone()) };
        assert!(camera_notes(&scene, &shaded, UpAxis::Z).is_empty());
        assert!(notes("", cube.clone()).is_empty(), "white on black");
        let scene = Scene::from_toml("[[cloud]]\npath = 'a.ply'", "s.toml".as_ref()).unwrap();
        let colors = (0..cube.len()).map(|i| Vec3::splat(if i % 5 < 3 { 0.01 } else { 1.0 })).collect();
        let dark = Points { colors, normals: Some(vec![Vec3::Z; cube.len()]), ..scene_of(cube.clone()) };
        let said = camera_notes(&scene, &dark, UpAxis::Z);
        assert!(said[0].contains("60 % of the points are nearly black") && said[0].contains("--background white"));
        let grey =
            Scene::from_toml("[image]\nbackground = '#888'\n[[cloud]]\npath = 'a.ply'", "s.toml".as_ref()).unwrap();
        assert!(camera_notes(&grey, &dark, UpAxis::Z).is_empty());
    }
}
