//! Clouds that stay where they are stored: whatever nodes a store has, the picture has the bytes of the cloud in
//! memory.

use std::path::PathBuf;
use std::sync::Arc;

use pellucid_core::cloud::{Bounds, Cloud, UpAxis};
use pellucid_io as io;
use pellucid_io::store::{Node, Piece, Store, Summary};
use pellucid_scene::prepare::Arranged;
use pellucid_scene::stored::{OpenStore, Stored};
use pellucid_scene::{self as scene, Scene};

use super::prelude::*;

/// Points of each cloud.
const POINTS: u32 = 3000;
/// Bytes on the device: some hundreds of points at a time, so that there are many regions.
const DEVICE: u64 = 1 << 20;

pub(super) fn cases() -> Vec<Case> {
    let named = |name: &str| Method::all().into_iter().find(|method| method.name() == name);
    let methods: Vec<Method> = ["abuffer", "circles", "stochastic", "unsorted"].into_iter().filter_map(named).collect();
    let borders =
        "points on the borders of nodes, in either of them, at equal depths: values that differ from those in memory";
    let wide = "a disc that covers all nodes, while few windows see its own: values that differ from those in memory";
    let empty = "nodes without points around nodes without points: values that differ from those in memory";
    let place =
        "points of different looks in one place, in nodes of four levels: values that differ from those in memory";
    joined([
        each(&methods, "store-borders", |stage, method| {
            compared(stage, method, |cloud, i| (cloud.positions[i].x + f64::from(i as u32 % 2)).floor() as i64)
        })
        .about(borders),
        each(&methods, "store-wide-disc", |stage, method| {
            compared_with(
                stage,
                method,
                |cloud| cloud.radii.iter_mut().for_each(|radii| radii[7] = 8.0),
                |_, i| i as i64 % 9,
            )
        })
        .about(wide),
        each(&methods, "store-empty-nodes", |stage, method| {
            compared(stage, method, |cloud, i| 5 * (cloud.positions[i].y.floor() as i64) + 2)
        })
        .about(empty),
        each(&methods, "store-one-place", |stage, method| {
            let in_one_place = |cloud: &mut Cloud| {
                for i in (0..cloud.positions.len()).step_by(3) {
                    cloud.positions[i] = cloud.positions[i / 3];
                }
            };
            compared_with(stage, method, in_one_place, |_, i| i as i64 % 4)
        })
        .about(place),
    ])
}

/// Points of a cube of side 4 on a grid of eighths, so that many are on planes between nodes, and at one depth.
fn cloud() -> Cloud {
    let part = |i: u32, factor: u32| f64::from((i.wrapping_mul(factor) >> 7) % 32) / 8.0 - 2.0;
    let position = |i: u32| DVec3::new(part(i, 2_654_435_761), part(i, 2_246_822_519), part(i, 3_266_489_917));
    let shade = |i: u32| ((i * 37) % 16) as f32 / 16.0;
    Cloud {
        positions: (1..=POINTS).map(position).collect(),
        colors: Some((1..=POINTS).map(|i| Vec3::new(shade(i), shade(i + 5), shade(3 * i))).collect()),
        alphas: Some((1..=POINTS).map(|i| 0.25 + 0.5 * shade(7 * i)).collect()),
        radii: Some((1..=POINTS).map(|i| 0.0625 + 0.125 * shade(11 * i)).collect()),
        up: UpAxis::Z,
        ..Cloud::default()
    }
}

/// A cloud in nodes one below the other, as the caller gives them.
#[derive(Debug)]
struct Chain {
    summary: Summary,
    nodes: Vec<Node>,
    pieces: Vec<Piece>,
}

impl Chain {
    /// The nodes from the least number to the greatest, those without points among them.
    fn new(cloud: &Cloud, bounds: Bounds, node_of: impl Fn(&Cloud, usize) -> i64) -> Self {
        let numbers: Vec<i64> = (0..cloud.len()).map(|i| node_of(cloud, i)).collect();
        let least = numbers.iter().copied().min().unwrap_or(0);
        let most = numbers.iter().copied().max().unwrap_or(0);
        let piece = |number: i64| {
            let own = (0..cloud.len() as u32).filter(|i| numbers[*i as usize] == number);
            let own: Vec<u32> = own.collect();
            Piece { cloud: cloud.subset(&own), places: own.iter().map(|i| u64::from(*i)).collect() }
        };
        let pieces: Vec<Piece> = (least..=most).map(piece).collect();
        let node = |(level, piece): (u32, &Piece)| Node {
            level,
            parent: level.checked_sub(1),
            bounds,
            points: piece.cloud.len() as u64,
            bytes: 0,
            spacing: 0.0,
            largest_radius: piece.cloud.radii.as_ref().map(|radii| radii.iter().copied().fold(0.0, f32::max)),
        };
        let nodes = (0..).zip(&pieces).map(node).collect();
        let (points, like) = (cloud.len() as u64, cloud.subset(&[]));
        let path = PathBuf::from("store");
        let summary = Summary { path, points, bounds, up: cloud.up, ranges: Vec::new(), grid: None, like };
        Self { summary, nodes, pieces }
    }
}

impl Store for Chain {
    fn summary(&self) -> &Summary {
        &self.summary
    }

    fn nodes(&self) -> &[Node] {
        &self.nodes
    }

    fn read(&self, node: usize) -> Result<Piece, io::Error> {
        Ok(self.pieces[node].clone())
    }
}

fn compared(stage: &mut CaseRenderer, method: Method, node_of: impl Fn(&Cloud, usize) -> i64) -> CaseResult {
    compared_with(stage, method, |_| {}, node_of)
}

/// Values of the picture of a store unlike those of memory. The naive way takes points in the order of their nodes.
fn compared_with(
    stage: &mut CaseRenderer,
    method: Method,
    change: impl Fn(&mut Cloud),
    node_of: impl Fn(&Cloud, usize) -> i64,
) -> CaseResult {
    let mut cloud = cloud();
    change(&mut cloud);
    let scene = Scene::from_toml("[shading]\nmodel = 'none'\n[[cloud]]\npath = 'store'\n", "check".as_ref())?;
    let scene = Scene { method: method.into(), ..scene };
    let hidden = Progress::hidden();
    let Some(bounds) = cloud.bounds() else { return Ok(Finding::new(1.0, 0.0, 1.0)) };
    let store = Chain::new(&cloud, bounds, node_of);
    let by_nodes: Vec<u32> = store.pieces.iter().flat_map(|piece| &piece.places).map(|place| *place as u32).collect();
    let in_memory = scene::arrange(&scene, vec![cloud], 1, &hidden)?;
    let stored = Stored::new(&scene, &[OpenStore::new(Box::new(store))], DEVICE, &hidden)?;
    let camera = looking(DVec3::new(0.0, 0.0, 8.0), DVec3::ZERO, Projection::Orthographic { height: 4.5 }, 1.0, 16.0);
    let whole = Frame::new(camera, [48, 48], method);
    let small = Frame { memory_budget: Some(DEVICE), ..whole };
    let expected = stage.arranged(&in_memory, &whole)?;
    let found = stage.arranged(&stored.arranged(), &small)?;
    // The place of each point among those by nodes, for those in canonical order.
    let points = in_memory.points();
    let mut rank = vec![0u32; by_nodes.len()];
    by_nodes.iter().zip(0..).for_each(|(place, at)| rank[*place as usize] = at);
    let mut order: Vec<u32> = (0..points.len() as u32).collect();
    order.sort_by_key(|at| rank[points.file_order[*at as usize] as usize]);
    let file_order = order.iter().map(|at| rank[points.file_order[*at as usize] as usize]).collect();
    let naive = Points { file_order, ..points.subset(&order, 1.0) };
    let naive = stage.arranged(&Arranged::Canonical(Arc::new(naive)), &whole)?;
    Ok(Finding::new(differing(&found, &expected), 0.0, differing(&naive, &expected)))
}

/// Returns the number of values of two images that differ in their bits.
fn differing(a: &Image, b: &Image) -> f64 {
    let bits = |image: &Image| -> Vec<u32> {
        let colors = image.rgba.iter().flatten().map(|value| value.to_bits());
        colors.chain(image.depth.iter().map(|depth| depth.to_bits())).collect()
    };
    bits(a).into_iter().zip(bits(b)).filter(|(a, b)| a != b).count() as f64
}
