//! The regions of all ranks, in rounds in which few points are sent at a time.

use pellucid_engine::passes::bands::Window;

use super::super::cut::{Costs, TILE, is_empty};

/// Points that each rank may have of others at a time, whatever it has itself.
const LEAST: f64 = 262_144.0;

/// A rank may have so many points at a time as a part of those that it has itself: they are there several times while
/// they are put into order, and on the device.
const PART: f64 = 0.125;

/// Regions for each rank, round by round; some are empty. `all` are the scene's points, and the device has room for
/// `room` at a time.
pub fn rounds(costs: &Costs, ranks: usize, all: u64, room: u64) -> Vec<Vec<Window>> {
    let most = (PART * all as f64 / ranks as f64).max(LEAST).min(room as f64);
    let parts: Vec<Vec<Window>> =
        costs.windows(ranks, 0, 0.0).into_iter().map(|window| divided(costs, window, most)).collect();
    let count = parts.iter().map(Vec::len).max().unwrap_or(0);
    let round = |round: usize| parts.iter().map(|part| part.get(round).copied().unwrap_or([0; 4])).collect();
    (0..count).map(round).collect()
}

/// A region in parts in which no more points are expected, as far as tiles allow.
fn divided(costs: &Costs, window: Window, most: f64) -> Vec<Window> {
    if is_empty(window) {
        return Vec::new();
    }
    if costs.of(window).points <= most {
        return vec![window];
    }
    match halves(window) {
        Some(halves) => halves.into_iter().flat_map(|half| divided(costs, half, most)).collect(),
        None => vec![window],
    }
}

/// The halves of a region of whole tiles; `None` of one tile.
fn halves([x0, y0, x1, y1]: Window) -> Option<[Window; 2]> {
    let [wide, high] = [(x1 - x0).div_ceil(TILE), (y1 - y0).div_ceil(TILE)];
    if wide <= 1 && high <= 1 {
        return None;
    }
    Some(if high >= wide {
        let y = y0 + high / 2 * TILE;
        [[x0, y0, x1, y], [x0, y, x1, y1]]
    } else {
        let x = x0 + wide / 2 * TILE;
        [[x0, y0, x, y1], [x, y0, x1, y1]]
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn halves_are_whole_tiles_down_to_one() {
        let mut windows = vec![[16, 32, 70, 100]];
        let mut pixels = 0;
        while let Some(window) = windows.pop() {
            let [x0, y0, x1, y1] = window;
            assert!(!is_empty(window) && x0 % TILE == 0 && y0 % TILE == 0);
            match halves(window) {
                Some(halves) => windows.extend(halves),
                None => {
                    assert!(x1 - x0 <= TILE && y1 - y0 <= TILE);
                    pixels += (x1 - x0) * (y1 - y0);
                }
            }
        }
        assert_eq!(pixels, 54 * 68);
    }
}
