use super::*;
use crate::supply::{Branch, HeldPoints};
use pellucid_core::camera::{Camera, Projection};
use pellucid_core::cloud::Bounds;

/// Camera from the origin along x: 50 pixels of a world unit at distance 1.
fn camera() -> Camera {
    let projection = Projection::Perspective { fov_y: std::f64::consts::FRAC_PI_2 };
    Camera::look_at(DVec3::ZERO, DVec3::X, DVec3::Z, projection, 0.5, 1e4).expect("a camera")
}

fn points(positions: Vec<DVec3>) -> Points {
    let radii = vec![0.5; positions.len()];
    Points { radii, ..pellucid_testing_host::white(positions, 1.0) }
}

fn picture<'a>(blocks: &'a [u32], shows: &'a (dyn Fn(DVec3) -> bool + Sync), seed: u64) -> CutPicture<'a> {
    CutPicture { scale: Scale::new(&camera(), 100), blocks, shows, nowhere: -DVec3::X, seed }
}

/// Points in memory as nodes of a tree.
#[derive(Debug)]
struct Nodes {
    blocks: Vec<Block>,
    points: Vec<Points>,
}

impl Supply for Nodes {
    fn blocks(&self) -> &[Block] {
        &self.blocks
    }

    fn take(&self, blocks: &[u32], keep: Keep<'_>, _progress: &Progress) -> Result<Points, Failure> {
        let mut all = Points::default();
        for number in blocks {
            let own = &self.points[*number as usize];
            let kept: Vec<u32> =
                (0..own.len() as u32).filter(|i| (keep.keeps)(own.positions[*i as usize], *number, None)).collect();
            let mut own = own.subset(&kept, 1.0);
            for (radius, position) in own.radii.iter_mut().zip(&own.positions) {
                *radius *= keep.grows.map_or(1.0, |grows| grows(*position, *number));
            }
            all.append(own);
        }
        Ok(all)
    }
}

/// A row of points from x = 10 to x = 90: each level has every second place of the one below. The second level has two
/// nodes.
fn tree() -> Arc<dyn Supply> {
    let row = |xs: &[f64]| points(xs.iter().map(|x| DVec3::new(*x, 0.0, 0.0)).collect());
    let parts = [row(&[10.0, 50.0, 90.0]), row(&[30.0]), row(&[70.0])];
    let block = |points: &Points, bounds: [f64; 2], branch| Block {
        bounds: Bounds { min: DVec3::new(bounds[0], 0.0, 0.0), max: DVec3::new(bounds[1], 0.0, 0.0) },
        radius: 0.5,
        points: points.len() as u64,
        branch: Some(branch),
    };
    let child = Branch { parent: Some(0), spacing: 4.0, growth: 2.0 };
    let blocks = vec![
        block(&parts[0], [10.0, 90.0], Branch { parent: None, spacing: f64::INFINITY, growth: 1.0 }),
        block(&parts[1], [20.0, 45.0], child),
        block(&parts[2], [55.0, 85.0], child),
    ];
    Arc::new(Nodes { blocks, points: parts.into() })
}

fn radii(cut: &Cut) -> Vec<(f64, f32)> {
    let all: Vec<u32> = (0..cut.blocks().len() as u32).collect();
    let taken = cut.take(&all, Keep::ALL, &Progress::hidden()).unwrap();
    let mut found: Vec<(f64, f32)> = taken.positions.iter().map(|p| p.x).zip(taken.radii).collect();
    found.sort_by(|a, b| a.0.total_cmp(&b.0));
    found
}

#[test]
fn nodes_are_left_out_where_those_above_are_fine_enough() {
    let whole = tree();
    let cut = |spacing_px, max_points| {
        let limits = Limits { spacing_px, max_points };
        Cut::new(Arc::clone(&whole), 0.0, &limits, &picture(&[0, 1, 2], &|_| true, 0), &Progress::hidden())
    };
    // Points of the first level are 4 apart: 4 · 50 / 20 = 10 pixels at the near node, 4 · 50 / 55 = 3.64 at the far
    // one.
    let all = cut(3.6, None).unwrap();
    assert_eq!(radii(&all), [10.0, 30.0, 50.0, 70.0, 90.0].map(|x| (x, 0.5)));
    let near = cut(3.7, None).unwrap();
    // 50 and 90 are farther than 4 from the box of the far node, whose place alone lacks points.
    assert_eq!(radii(&near), [10.0, 30.0, 50.0, 90.0].map(|x| (x, 0.5)));
    // Where it is taken from: at 86, within 4 of the box, and inside of it.
    assert_eq!([84.0, 86.0, 90.0].map(|x| near.growth(DVec3::new(x, 0.0, 0.0), 0)), [2.0, 2.0, 1.0]);
    assert_eq!((near.points(), near.most_growth, near.blocks()[0].radius), (4, 2.0, 1.0));
    assert_eq!(near.blocks()[1].radius, 0.5, "nothing is left out there");
    let coarsest = cut(10.1, None).unwrap();
    assert_eq!(coarsest.points(), 3);
    // By the number of points: 5, 4 and 3 are levels, 2 is none.
    for (most, count) in [(9, 5), (5, 5), (4, 4), (3, 3)] {
        let cut = cut(0.0, Some(most)).unwrap();
        assert_eq!((cut.points(), cut.shown()), (count, count), "{most}");
    }
    assert_eq!(cut(10.1, Some(9)).unwrap().points(), 3, "both limits hold");
    assert!(matches!(cut(0.0, Some(2)), Err(Failure::Coarsest { allowed: 2, points: 3 })));
}

#[test]
fn points_without_levels_come_in_a_random_order() {
    // 40,000 points on two planes, 0.1 apart: 50 · 0.1 / 5 = 1 pixel at distance 5, 0.25 pixels at distance 20.
    let plane = |x: f64| {
        (0..20_000).map(move |i| 0.1 * DVec3::new(10.0 * x, f64::from(i % 200) - 100.0, f64::from(i / 200) - 50.0))
    };
    let all: Vec<DVec3> = plane(5.0).chain(plane(20.0)).collect();
    let held: Arc<dyn Supply> = Arc::new(HeldPoints::new(Arc::new(points(all.clone()))));
    let numbers: Vec<u32> = (0..held.blocks().len() as u32).collect();
    // The middle of the planes alone, whose distance is nearly that along x.
    let shows = |p: DVec3| p.y.abs() < 1.0 && p.z.abs() < 1.0;
    let cut = |spacing_px, max_points, seed| {
        let limits = Limits { spacing_px, max_points };
        Cut::new(Arc::clone(&held), 0.1, &limits, &picture(&numbers, &shows, seed), &Progress::hidden()).unwrap()
    };
    let taken = |cut: &Cut| {
        let all: Vec<u32> = (0..cut.blocks().len() as u32).collect();
        cut.take(&all, Keep::ALL, &Progress::hidden()).unwrap()
    };
    let half = cut(0.5, None, 1);
    let found = taken(&half);
    let at = |points: &Points, x: f64| points.positions.iter().filter(|p| p.x == x && shows(**p)).count();
    // All of the 19² near ones; a quarter of the far ones, 90 to some standard errors of 8.
    let count = all.iter().filter(|p| p.x == 20.0 && shows(**p)).count();
    assert_eq!(at(&found, 5.0), all.iter().filter(|p| p.x == 5.0 && shows(**p)).count());
    assert!(at(&found, 20.0).abs_diff(count / 4) < 40, "{} of {count}", at(&found, 20.0));
    for (position, radius) in found.positions.iter().zip(&found.radii) {
        // 0.5 / (0.1 · 50 / r) = r / 10, where that is above 1.
        let expected = 0.5 * (position.length() / 10.0).max(1.0);
        assert!((f64::from(*radius) - expected).abs() < 1e-6 * expected, "{position}: {radius}");
    }
    for block in half.blocks() {
        let inside = |p: &DVec3| block.bounds.min.cmple(*p).all() && p.cmple(block.bounds.max).all();
        let pairs = found.positions.iter().zip(&found.radii);
        assert!(pairs.filter(|(p, _)| inside(p)).all(|(_, radius)| *radius <= 1.000_001 * block.radius), "{block:?}");
    }
    assert!((half.points() as f64 / found.len() as f64 - 1.0).abs() < 0.5, "{} of {}", half.points(), found.len());
    // Coarser cuts have points of finer ones alone, and other seeds others.
    let coarser = taken(&cut(2.0, None, 1));
    assert!(coarser.len() < found.len() && coarser.positions.iter().all(|p| found.positions.contains(p)));
    assert_ne!(taken(&cut(2.0, None, 2)).positions, coarser.positions);
    // The number of points in the picture is at most that asked for, and not much below: bins are 2^-12 wide.
    let shown = |points: &Points| points.positions.iter().filter(|p| shows(**p)).count() as u64;
    for most in [1, 10, 100, 500, 721] {
        let cut = cut(0.0, Some(most), 7);
        let found = shown(&taken(&cut));
        assert_eq!(cut.shown(), found, "the number that is told");
        assert!(found <= most && found + 2 + most / 100 >= most, "{found} of {most}");
    }
    assert_eq!(taken(&cut(0.0, Some(5000), 7)).len(), 40_000);
}

#[test]
fn points_in_one_place_have_no_levels() {
    let held: Arc<dyn Supply> = Arc::new(HeldPoints::new(Arc::new(points(vec![DVec3::X; 9]))));
    let cut = |spacing_px, max_points| {
        let limits = Limits { spacing_px, max_points };
        Cut::new(Arc::clone(&held), 0.0, &limits, &picture(&[0], &|_| true, 0), &Progress::hidden())
    };
    let whole = cut(1e6, None).unwrap();
    assert_eq!(whole.take(&[0], Keep::ALL, &Progress::hidden()).unwrap().radii, [0.5; 9]);
    assert!(matches!(cut(0.0, Some(8)), Err(Failure::Coarsest { allowed: 8, points: 9 })));
    assert_eq!(cut(0.0, Some(9)).unwrap().points(), 9);
}
