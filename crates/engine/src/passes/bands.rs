//! Cutting the image so that any scene fits: windows of pixels whose counters fit, bands of pixels whose fragments fit.

/// A rectangle of pixels: first column, first row, one past the last column and row.
pub type Window = [u32; 4];

/// Returns the number of pixels.
pub fn pixels([x0, y0, x1, y1]: Window) -> u64 {
    u64::from(x1 - x0) * u64::from(y1 - y0)
}

/// Cuts the image into windows of whole rows with at most `capacity` pixels, or of parts of a row if a row has more.
pub fn windows(size: [u32; 2], capacity: u64) -> Vec<Window> {
    let capacity = capacity.max(1);
    let columns = u64::from(size[0]).min(capacity) as u32;
    let rows = (capacity / u64::from(size[0])).clamp(1, u64::from(size[1])) as u32;
    cut(size, [columns, rows])
}

/// Cuts the image into windows of so many columns and rows, the last ones of less.
pub fn cut(size: [u32; 2], [columns, rows]: [u32; 2]) -> Vec<Window> {
    let mut found = Vec::new();
    for y in (0..size[1]).step_by(rows as usize) {
        for x in (0..size[0]).step_by(columns as usize) {
            found.push([x, y, x.saturating_add(columns).min(size[0]), y.saturating_add(rows).min(size[1])]);
        }
    }
    found
}

/// Returns the part of a window in a region; `None` if there is none.
pub fn within(window: Window, region: Window) -> Option<Window> {
    let [x0, y0, x1, y1] = window;
    let part = [x0.max(region[0]), y0.max(region[1]), x1.min(region[2]), y1.min(region[3])];
    (part[0] < part[2] && part[1] < part[3]).then_some(part)
}

/// Side of a tile in pixels.
pub const TILE: u32 = 16;

/// Like [`windows`], but made of whole tiles of the image as long as one fits, so that tiles don't depend on the cut.
pub fn tile_windows(size: [u32; 2], capacity: u64) -> Vec<Window> {
    let [tile, width] = [u64::from(TILE), u64::from(size[0])];
    if capacity < tile * tile || u64::from(size[0]) * u64::from(size[1]) <= capacity {
        return windows(size, capacity);
    }
    // A row of tiles, or as much of it as fits.
    let columns = if width * tile <= capacity { size[0] } else { (capacity / tile / tile * tile) as u32 };
    let rows = (capacity / u64::from(columns) / tile * tile).clamp(tile, u64::from(size[1]).max(tile)) as u32;
    cut(size, [columns, rows])
}

/// Like [`halves`], but cuts between tiles of the image as long as a window has two.
pub fn tile_halves([x0, y0, x1, y1]: Window) -> Option<[Window; 2]> {
    let middle = |low: u32, high: u32| low + (high - low).div_ceil(TILE) / 2 * TILE;
    if y1 - y0 > TILE {
        let y = middle(y0, y1);
        Some([[x0, y0, x1, y], [x0, y, x1, y1]])
    } else if x1 - x0 > TILE {
        let x = middle(x0, x1);
        Some([[x0, y0, x, y1], [x, y0, x1, y1]])
    } else {
        halves([x0, y0, x1, y1])
    }
}

/// Like [`tile_halves`], but cuts the longer side as long as that has two tiles: few points are in both halves then.
pub fn square_halves([x0, y0, x1, y1]: Window) -> Option<[Window; 2]> {
    if x1 - x0 > (y1 - y0).max(TILE) {
        let x = x0 + (x1 - x0).div_ceil(TILE) / 2 * TILE;
        return Some([[x0, y0, x, y1], [x, y0, x1, y1]]);
    }
    tile_halves([x0, y0, x1, y1])
}

/// Halves a window by rows, or by columns if it has one row; `None` for a single pixel.
pub fn halves([x0, y0, x1, y1]: Window) -> Option<[Window; 2]> {
    if y1 - y0 > 1 {
        let y = y0 + (y1 - y0) / 2;
        Some([[x0, y0, x1, y], [x0, y, x1, y1]])
    } else if x1 - x0 > 1 {
        let x = x0 + (x1 - x0) / 2;
        Some([[x0, y0, x, y1], [x, y0, x1, y1]])
    } else {
        None
    }
}

/// A range of a window's pixels, in their order, and where its fragments begin and end.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Band {
    /// First pixel and one past the last.
    pub pixels: [u32; 2],
    /// The band's first fragment among the window's.
    pub first_fragment: u32,
    /// Fragments of the band.
    pub fragments: u64,
}

impl Band {
    /// Returns the whole window.
    pub fn whole(window: Window, fragments: u64) -> Self {
        Self { pixels: [0, pixels(window) as u32], first_fragment: 0, fragments }
    }
}

/// Cuts a window's pixels into bands of at most `capacity` fragments.
///
/// `offsets` are the prefix sums: one element more than pixels. `Err` is the first pixel that alone has more, with its
/// length.
pub fn bands(offsets: &[u32], capacity: u64) -> Result<Vec<Band>, (u32, u32)> {
    let pixels = offsets.len().saturating_sub(1);
    let mut found = Vec::new();
    let mut start = 0;
    while start < pixels {
        let limit = u64::from(offsets[start]) + capacity;
        // The last end whose offset is within the limit.
        let end = start + offsets[start..].partition_point(|o| u64::from(*o) <= limit) - 1;
        if end == start {
            return Err((start as u32, offsets[start + 1] - offsets[start]));
        }
        found.push(Band {
            pixels: [start as u32, end as u32],
            first_fragment: offsets[start],
            fragments: u64::from(offsets[end] - offsets[start]),
        });
        start = end;
    }
    Ok(found)
}

/// Returns the pixel with the longest list, the first of equals, and its length.
pub fn longest(offsets: &[u32]) -> (u32, u32) {
    let lengths = (0u32..).zip(offsets.windows(2).map(|pair| pair[1] - pair[0]));
    lengths.reduce(|best, next| if next.1 > best.1 { next } else { best }).unwrap_or_default()
}

/// The use of the memory budget.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Budget {
    /// Bytes for everything but cloud and image.
    pub bytes: u64,
    /// The share of tiles of large splats.
    pub tiles: u64,
    /// Bytes that one binding may have.
    pub binding: u64,
}

/// Bytes that are always needed: a staging buffer, small buffers, and the allocator's rounding to blocks.
const OVERHEAD_BYTES: u64 = 40 << 20;

impl Budget {
    /// Returns the number of pixels of a window: limited by a quarter of the budget at `bytes_per_pixel`, and by a
    /// binding of 16 bytes per pixel.
    pub fn window_pixels(&self, bytes_per_pixel: u64) -> u64 {
        (self.bytes / 4 / bytes_per_pixel).min(self.binding / 16).max(1)
    }

    /// Returns the budget with tiles of this many bytes; `None` if they take more than an eighth or a binding.
    pub fn with_tiles(self, tiles: u64) -> Option<Self> {
        (tiles <= self.bytes / 8 && tiles <= self.binding).then_some(Self { tiles, ..self })
    }

    /// Returns the number of bytes left for fragments beside `used` and the tiles.
    pub fn left(&self, used: u64) -> u64 {
        self.bytes.saturating_sub(used + self.tiles + OVERHEAD_BYTES.min(self.bytes / 8 * 3))
    }

    /// Returns a budget that leaves `needed` bytes for fragments whatever windows (at most a quarter) and tiles (an
    /// eighth) take.
    pub fn wanted(needed: u64) -> u64 {
        let small = needed * 4;
        if small <= OVERHEAD_BYTES / 3 * 8 { small } else { ((needed + OVERHEAD_BYTES) * 8).div_ceil(5) }
    }
}

/// Returns the column and row in the image of a window's pixel.
pub fn place(window: Window, pixel: u32) -> [u32; 2] {
    let width = window[2] - window[0];
    [window[0] + pixel % width, window[1] + pixel / width]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn square_halves_cut_the_longer_side_between_tiles() {
        assert_eq!(square_halves([0, 0, 100, 40]), Some([[0, 0, 48, 40], [48, 0, 100, 40]]));
        assert_eq!(square_halves([16, 32, 48, 96]), Some([[16, 32, 48, 64], [16, 64, 48, 96]]));
        assert_eq!(square_halves([0, 0, 17, 16]), Some([[0, 0, 16, 16], [16, 0, 17, 16]]));
        // Within a tile, and of a single pixel, as others.
        assert_eq!(square_halves([0, 0, 16, 8]), halves([0, 0, 16, 8]));
        assert_eq!(square_halves([3, 4, 4, 5]), None);
    }

    #[test]
    fn windows_cover_every_pixel_once() {
        for (size, capacity) in [([7, 5], 14), ([7, 5], 3), ([7, 5], 1), ([7, 5], 1000), ([1, 9], 4), ([9, 1], 4)] {
            let mut seen = vec![0; (size[0] * size[1]) as usize];
            for w in windows(size, capacity) {
                assert!(pixels(w) <= capacity, "{w:?} over {capacity}");
                for y in w[1]..w[3] {
                    for x in w[0]..w[2] {
                        seen[(y * size[0] + x) as usize] += 1;
                    }
                }
            }
            assert!(seen.iter().all(|n| *n == 1), "{size:?} {capacity}");
        }
    }

    #[test]
    fn windows_of_tiles_cover_every_pixel_once_and_cut_no_tile() {
        for (size, capacity) in [([70, 50], 300), ([70, 50], 1200), ([70, 50], 9000), ([70, 50], 100), ([9, 40], 256)] {
            let mut seen = vec![0; (size[0] * size[1]) as usize];
            let mut left = tile_windows(size, capacity);
            assert!(left.iter().all(|w| pixels(*w) <= capacity), "{size:?} {capacity}");
            while let Some(w) = left.pop() {
                let whole =
                    [0, 1].map(|axis| w[axis] % TILE == 0 && (w[axis + 2] % TILE == 0 || w[axis + 2] == size[axis]));
                assert!(capacity < 256 || whole == [true; 2], "{w:?}");
                let single = w[2] - w[0] <= TILE && w[3] - w[1] <= TILE;
                match tile_halves(w).filter(|_| !single) {
                    Some(parts) => left.extend(parts),
                    None => {
                        for y in w[1]..w[3] {
                            for x in w[0]..w[2] {
                                seen[(y * size[0] + x) as usize] += 1;
                            }
                        }
                    }
                }
            }
            assert!(seen.iter().all(|n| *n == 1), "{size:?} {capacity}");
        }
    }

    #[test]
    fn halving_ends_at_one_pixel() {
        let mut windows = vec![[3, 4, 8, 7]];
        let mut single = 0;
        while let Some(w) = windows.pop() {
            match halves(w) {
                Some(parts) => windows.extend(parts),
                None => single += 1,
            }
        }
        assert_eq!(single, 15);
    }

    #[test]
    fn bands_hold_at_most_the_capacity() {
        let lengths = [3u32, 0, 0, 5, 1, 4, 0, 5, 5, 0];
        let mut offsets = vec![0];
        for n in lengths {
            offsets.push(offsets.last().copied().unwrap_or(0) + n);
        }
        let found = bands(&offsets, 5).expect("no pixel has more than 5");
        assert_eq!(found.first().map(|b| b.pixels[0]), Some(0));
        assert_eq!(found.last().map(|b| b.pixels[1]), Some(10));
        assert!(found.windows(2).all(|w| w[0].pixels[1] == w[1].pixels[0]));
        assert!(found.iter().all(|b| b.fragments <= 5));
        assert!(found.iter().all(|b| b.first_fragment == offsets[b.pixels[0] as usize]));
        assert_eq!(found.iter().map(|b| b.fragments).sum::<u64>(), 23);
        assert_eq!(bands(&offsets, 4), Err((3, 5)));
        assert_eq!(longest(&offsets), (3, 5));
        assert_eq!((longest(&[7]), longest(&[0, 1, 1, 4])), ((0, 0), (2, 3)));
    }

    #[test]
    fn the_wanted_budget_leaves_what_is_needed() {
        for needed in [1u64, 1000, 37_400, 50 << 20, 60 << 20, 61 << 20, 3 << 30] {
            let bytes = Budget::wanted(needed);
            let budget = Budget { bytes, tiles: 0, binding: u64::MAX }.with_tiles(bytes / 8).expect("an eighth");
            assert!(budget.left(bytes / 4) >= needed, "{needed} of {bytes}");
        }
    }

    #[test]
    fn no_fragments_are_one_band() {
        assert_eq!(bands(&[0, 0, 0], 1), Ok(vec![Band { pixels: [0, 2], first_fragment: 0, fragments: 0 }]));
    }
}
