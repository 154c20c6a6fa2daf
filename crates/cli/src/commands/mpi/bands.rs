//! The part of an image that each rank renders: rows of tiles, as many as cost the same.

use pellucid_engine::Result;
use pellucid_engine::methods::Frame;

use super::super::session::Session;

/// Rows of a tile: no tile is cut, so that its splats are ordered once.
const TILE: u32 = 16;

/// By how much an image is smaller that tells what rows cost.
const COARSE: u32 = 8;

/// Fragments that a pixel without any costs.
const EMPTY_PIXEL: f64 = 1.0;

/// First row and one past the last of each rank's band, by a coarse image of list lengths, which is the same on every rank.
///
/// # Errors
/// Those of rendering.
pub fn bands(session: &mut Session, count: usize) -> Result<Vec<[u32; 2]>> {
    let [width, height] = session.frame.size;
    let size = [width.div_ceil(COARSE), height.div_ceil(COARSE)];
    let coarse = Frame { size, fragments: true, depths: false, max_error: None, spread: false, ..session.frame };
    let image = session.renderer.render(&mut session.cloud, &coarse)?.image;
    let fragments = image.fragments.unwrap_or_default();
    let columns = size[0] as usize;
    let weight = |row: u32| {
        let row = (row / COARSE) as usize * columns;
        let counted = fragments.get(row..row + columns).unwrap_or_default();
        counted.iter().map(|length| f64::from(*length)).sum::<f64>() + EMPTY_PIXEL * columns as f64
    };
    Ok(cut(height, count, weight))
}

/// Cuts rows into bands of whole tiles and of about the same weight, one for each of `count`; some may be empty.
fn cut(height: u32, count: usize, weight: impl Fn(u32) -> f64) -> Vec<[u32; 2]> {
    let tiles: Vec<f64> = (0..height)
        .step_by(TILE as usize)
        .map(|first| (first..(first + TILE).min(height)).map(&weight).sum())
        .collect();
    let all: f64 = tiles.iter().sum();
    let (mut bands, mut start, mut before) = (Vec::new(), 0, 0.0);
    let mut tile = 0;
    for number in 1..=count {
        let wanted = all * number as f64 / count as f64;
        // The tile row in which the share ends goes to whom most of it belongs.
        while tile < tiles.len() && before + 0.5 * tiles[tile] <= wanted {
            before += tiles[tile];
            tile += 1;
        }
        let end = if number == count { height } else { (tile as u32 * TILE).min(height) };
        bands.push([start, end]);
        start = end;
    }
    bands
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bands_cover_every_row_once_and_cut_no_tile() {
        for (height, count) in [(1080, 1), (1080, 2), (1080, 7), (17, 4), (1, 3), (64, 4)] {
            let bands = cut(height, count, |row| 1.0 + f64::from(row % 5));
            assert_eq!(bands.len(), count);
            assert_eq!((bands[0][0], bands[count - 1][1]), (0, height));
            for pair in bands.windows(2) {
                assert_eq!(pair[0][1], pair[1][0]);
                assert!(pair[0][1] % TILE == 0 || pair[0][1] == height);
            }
        }
    }

    #[test]
    fn rows_that_cost_more_are_shared_by_more() {
        // All the cost is in the lower half.
        let bands = cut(320, 4, |row| if row < 160 { 0.0 } else { 1.0 });
        assert_eq!(bands[3][1] - bands[3][0], 48);
        assert!(bands[0][1] > 160);
    }
}
