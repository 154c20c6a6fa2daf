//! Cutting the image into windows that are rendered with all around them that the filters reach.

use crate::passes::bands::{self, Window};
pub use crate::passes::tiles::{TILE, grid as tiles};

/// Returns a window with `halo` pixels more on each side, as far as the image goes.
pub fn grown([x0, y0, x1, y1]: Window, halo: u32, size: [u32; 2]) -> Window {
    let end = |v: u32, most: u32| v.saturating_add(halo).min(most);
    [x0.saturating_sub(halo), y0.saturating_sub(halo), end(x1, size[0]), end(y1, size[1])]
}

/// Pixels of a window's side that so many tiles leave of an image's side, without the halo; 0 if they leave none.
fn inside(tiles: u32, halo: u32, side: u32) -> u32 {
    let reached = u64::from(tiles) * u64::from(TILE);
    if reached >= u64::from(side) { side } else { reached.saturating_sub(2 * u64::from(halo)) as u32 }
}

/// Cuts the image into windows that take at most `most_tiles` tiles each with their halo; of all ways the one with the
/// largest windows. `None` if not even a window of one pixel takes so few.
pub fn windows(size: [u32; 2], most_tiles: u64, halo: u32) -> Option<Vec<Window>> {
    let [columns, rows] = tiles([0, 0, size[0], size[1]]);
    let of = |across: u32| {
        let down = (most_tiles / u64::from(across)).min(u64::from(rows)) as u32;
        [inside(across, halo, size[0]), inside(down, halo, size[1])]
    };
    let area = |[width, height]: &[u32; 2]| u64::from(*width) * u64::from(*height);
    (1..=columns).map(of).max_by_key(area).filter(|best| area(best) > 0).map(|largest| bands::cut(size, largest))
}

/// Returns the fewest tiles that a window of one pixel takes, wherever in the image it lies.
pub fn fewest_tiles(size: [u32; 2], halo: u32) -> u64 {
    let side = |side: u32| u64::from(halo.saturating_mul(2).saturating_add(1).min(side).div_ceil(TILE));
    side(size[0]) * side(size[1])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::passes::bands::pixels;

    #[test]
    fn windows_cover_every_pixel_once_and_keep_to_their_tiles() {
        for size in [[1, 1], [70, 50], [1, 500], [500, 1], [33, 16]] {
            for halo in [0, 1, 4, 9] {
                for most in [1, 4, 5, 9, 30, 1000] {
                    let Some(all) = windows(size, most, halo) else {
                        assert!(fewest_tiles(size, halo) > most, "{size:?} {halo} {most}");
                        continue;
                    };
                    let mut seen = vec![0; (size[0] * size[1]) as usize];
                    for w in &all {
                        let [columns, rows] = tiles(grown(*w, halo, size));
                        assert!(u64::from(columns * rows) <= most, "{size:?} {halo} {most}: {w:?}");
                        for y in w[1]..w[3] {
                            for x in w[0]..w[2] {
                                seen[(y * size[0] + x) as usize] += 1;
                            }
                        }
                    }
                    assert!(seen.iter().all(|n| *n == 1), "{size:?} {halo} {most}");
                }
            }
        }
    }

    #[test]
    fn an_image_that_fits_is_one_window() {
        assert_eq!(windows([64, 32], 8, 100), Some(vec![[0, 0, 64, 32]]));
        assert_eq!(windows([64, 32], 7, 100), None);
        let strips = windows([64, 320], 40, 8).expect("fits");
        assert!(strips.iter().all(|w| w[2] - w[0] == 64) && pixels(strips[0]) == 64 * 144);
    }

    #[test]
    fn a_halo_ends_at_the_image() {
        assert_eq!(grown([3, 40, 10, 50], 5, [12, 100]), [0, 35, 12, 55]);
        assert_eq!(grown([0, 0, 1, 1], u32::MAX, [9, 7]), [0, 0, 9, 7]);
    }
}
