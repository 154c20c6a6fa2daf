//! Points of a cloud that each ensemble gets.
//!
//! The definition (Tanaka et al. 2016; Uchida et al. 2020) asks for ensembles whose sizes differ by one point at most,
//! that are random parts of the points, and for copies of a point in different ensembles. It leaves open which copy
//! goes where. Here the rule that [`pellucid_scene::prepare::ensembles`] describes is written from the points to the
//! hands: blocks are given out one after the other, as a dealer does, where the renderer goes from an ensemble to its
//! n-th point. The two share no function; they do share the rule, since images are compared to the point.

use pellucid_core::random::{key, threefry2x32};
use pellucid_scene::prepare::ensembles::Deal;

/// "agai" on the second word of the key tells the words of later passes from others.
const AGAIN: u32 = 0x6167_6169;

/// Returns the points of every ensemble, counted from the cloud's first, in the order in which they are shuffled.
pub fn hands(deal: &Deal) -> Vec<Vec<u64>> {
    let (points, ensembles) = (deal.points, u128::from(deal.ensembles));
    let before = |ensemble: u128| (u128::from(deal.slots) * ensemble / ensembles) as u64;
    let sizes: Vec<u64> = (0..ensembles).map(|e| before(e + 1) - before(e)).collect();
    // The first pass: the points as they stand, while they last for a whole hand.
    let (mut all, mut next) = (Vec::new(), 0);
    while all.len() < sizes.len() && next + sizes[all.len()] <= points {
        let end = next + sizes[all.len()];
        all.push((next..end).collect());
        next = end;
    }
    let mut pass = 0;
    while all.len() < sizes.len() {
        let mut dealt = later_pass(deal, pass);
        dealt.truncate(sizes.len() - all.len());
        for mut hand in dealt {
            hand.truncate(sizes[all.len()] as usize);
            all.push(hand);
        }
        pass += 1;
    }
    all
}

/// Hands of a later pass, each as long as the longest one.
///
/// The points from a random one on stand in rows of as many blocks as there are hands, and each hand gets one block of
/// each row: the first block of a row goes to a random hand, the others to those that follow, around.
fn later_pass(deal: &Deal, pass: u32) -> Vec<Vec<u64>> {
    let longest = deal.slots.div_ceil(u64::from(deal.ensembles)).max(1);
    // A hand has at least 64 blocks of 1, 2, 4 to 1024 points; single points where whole blocks would be more than the
    // cloud has.
    let mut block = 1;
    while block < 1024 && 2 * block * 64 <= longest {
        block *= 2;
    }
    if longest.next_multiple_of(block) > deal.points {
        block = 1;
    }
    let rows = longest.div_ceil(block);
    // A row has at most 2^15 points, and all rows together 2^22.
    let hands = (deal.points.min(1 << 22) / (rows * block)).min((1 << 15) / block).max(1);
    let [low, high] = key(deal.seed);
    let [word, start] = threefry2x32([pass, deal.place], [low, high ^ AGAIN]);
    let mut point = ((u128::from(start) * u128::from(deal.points)) >> 32) as u64;
    let mut dealt = vec![Vec::new(); hands as usize];
    for row in 0..rows {
        // The hand h places before a block's own place gets it, counted around.
        let turn = u64::from(mixed(word.wrapping_add((row as u32).wrapping_mul(0x9E37_79B9))) >> 10) % hands;
        for place in 0..hands {
            let hand = &mut dealt[((place + hands - turn) % hands) as usize];
            for _ in 0..block {
                hand.push(point);
                point = (point + 1) % deal.points;
            }
        }
    }
    dealt
}

/// C. Wellons' lowbias32.
fn mixed(x: u32) -> u32 {
    let shifted = |x: u32, by: u32| x ^ (x >> by);
    shifted(shifted(shifted(x, 16).wrapping_mul(0x7FEB_352D), 15).wrapping_mul(0x846C_A68B), 16)
}

#[cfg(test)]
mod tests {
    use std::collections::HashSet;

    use super::*;

    fn deals() -> impl Iterator<Item = Deal> {
        let some =
            [(1, 1, 1), (10, 0, 3), (10, 7, 3), (10, 30, 3), (1000, 19_000, 20), (5000, 12_345, 9), (300, 299, 300)];
        let large = [(40_000, 200_000, 40), (100_000, 250_000, 3), (70_000, 7_000_000, 100), (777, 777 * 64, 64)];
        let all = some.into_iter().chain(large);
        all.map(|(points, slots, ensembles)| Deal { points, slots, ensembles, place: 2, seed: 1 << 40 | points })
    }

    #[test]
    fn hands_are_as_the_definition_asks() {
        for deal in deals() {
            let hands = hands(&deal);
            assert_eq!(hands.len(), deal.ensembles as usize, "{deal:?}");
            assert_eq!(hands.iter().map(|hand| hand.len() as u64).sum::<u64>(), deal.slots, "{deal:?}");
            let [least, most] = [hands.iter().map(Vec::len).min(), hands.iter().map(Vec::len).max()];
            assert!(most <= least.map(|least| least + 1), "{deal:?}");
            for hand in hands {
                let different: HashSet<u64> = hand.iter().copied().collect();
                assert!(different.len() == hand.len() && hand.iter().all(|point| *point < deal.points), "{deal:?}");
            }
        }
    }

    #[test]
    fn they_are_those_of_the_renderer() {
        for deal in deals() {
            for (ensemble, hand) in (0..).zip(hands(&deal)) {
                assert!(hand == deal.hand(ensemble), "{deal:?}, ensemble {ensemble}");
            }
        }
    }
}
