//! Multi-layer alpha blending: exact for as many layers as it keeps and one more, and for any number that comes in
//! order.

use super::prelude::*;
use pellucid_scene::Mlab;

const NODES: u32 = 4;

pub(super) fn cases() -> Vec<Case> {
    let mlab = [Method::Mlab(Mlab { nodes: NODES, ..Mlab::default() })];
    joined([
        each(&mlab, "faint-from-near", |stage, method| faint(stage, method, false))
            .about("10 000 layers of opacity 1e-4 that come from near to far: as composed"),
        each(&mlab, "faint-from-far", |stage, method| faint(stage, method, true))
            .about("10 000 layers of opacity 1e-4 that come from far to near: as composed"),
        each(&mlab, "one-more-than-nodes", any_order)
            .about("5 layers with 4 nodes, in each of 120 orders: as composed"),
        each(&mlab, "equal-depths", equal_depths).about("5 layers at one depth: later over earlier"),
    ])
}

/// A run merges each layer into the last node, a change of a compensated sum: 2 units of it for any number (Kahan
/// 1965), of color and of what passes. Nodes before it have four roundings each.
fn bound(wanted: &[f64; 4]) -> f64 {
    let most = wanted.iter().copied().fold(0.0, f64::max);
    (8.0 + 4.0 * f64::from(NODES)) * HALF_ULP * most + MERGED
}

/// A layer that is merged has an error of a few roundings relative to itself, and all of them together have an opacity
/// of 1 at most.
const MERGED: f64 = 8.0 * HALF_ULP;

fn as_composed(stage: &mut CaseRenderer, method: Method, dots: &[Dot], wanted: [f64; 4]) -> CaseResult {
    stage.compare(dots, method, &naive::mlab(dots, NODES as usize), &wanted, bound(&wanted))
}

/// Checks fragments that arrive front to back, so that the last node is exact, or back to front: the farthest nodes are
/// merged in their order.
fn faint(stage: &mut CaseRenderer, method: Method, is_reversed: bool) -> CaseResult {
    let mut dots: Vec<Dot> = (0..10_000u32).map(|i| dot(1.0 + f64::from(i), COLORS[i as usize % 5], 1e-4)).collect();
    let wanted = composed(&dots);
    if is_reversed {
        dots.reverse();
    }
    as_composed(stage, method, &dots, wanted)
}

/// All orders of the numbers from 0 to 4.
fn orders() -> Vec<Vec<usize>> {
    let mut orders: Vec<Vec<usize>> = vec![Vec::new()];
    for next in 0..COLORS.len() {
        let with = |order: &Vec<usize>, at: usize| {
            let mut longer = order.clone();
            longer.insert(at, next);
            longer
        };
        orders = orders.iter().flat_map(|order| (0..=next).map(move |at| with(order, at))).collect();
    }
    orders
}

/// A pixel for each order.
fn any_order(stage: &mut CaseRenderer, method: Method) -> CaseResult {
    let orders = orders();
    let layer = |x: usize, i: usize| Dot {
        position: at(x as u32, 0, 1.0 + i as f64),
        color: COLORS[i],
        opacity: 0.3,
        ..Dot::default()
    };
    let lists: Vec<Vec<Dot>> =
        orders.iter().enumerate().map(|(x, order)| order.iter().map(|i| layer(x, *i)).collect()).collect();
    let size = [orders.len() as u32, 1];
    let found = stage.image(&lists.concat(), pixels(size), size, method)?.rgba;
    let sorted: Vec<Dot> = (0..COLORS.len()).map(|i| layer(0, i)).collect();
    let wanted = vec![composed(&sorted); lists.len()];
    // Without the one in transit, a node less.
    let naive: Vec<[f32; 4]> = lists.iter().map(|list| naive::mlab(list, NODES as usize - 1)).collect();
    Ok(Finding::pixels(&found, &naive, &wanted, bound(&wanted[0])))
}

fn equal_depths(stage: &mut CaseRenderer, method: Method) -> CaseResult {
    let dots = COLORS.map(|color| dot(7.0, color, 0.4));
    let mut wanted = dots;
    wanted.reverse();
    // The naive one puts the later behind those of its depth.
    as_composed(stage, method, &dots, composed(&wanted))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_order_is_there_once() {
        let mut all = orders();
        all.sort();
        all.dedup();
        assert_eq!(all.len(), 120);
        assert!(all.iter().all(|order| (0..5).all(|i| order.contains(&i))));
    }
}
