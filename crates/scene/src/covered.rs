//! Pixels that discs facing the screen cover, by the rule of the disc methods: those whose centers lie in a disc, and
//! the one that its center is in.

use std::ops::Range;

use glam::DVec2;

/// Pixels of an image.
pub(crate) struct Pixels {
    size: [u32; 2],
    /// Words in a row of the map.
    words: usize,
    /// Bits of the covered pixels, row by row.
    map: Vec<u64>,
    /// Pairs of a disc and a pixel.
    fragments: u64,
}

impl Pixels {
    /// Returns an image without discs.
    pub fn none(size: [u32; 2]) -> Self {
        let words = size[0].div_ceil(u64::BITS) as usize;
        Self { size, words, map: vec![0; words * size[1] as usize], fragments: 0 }
    }

    /// Returns the image with the discs of both.
    pub fn joined(mut self, other: Self) -> Self {
        self.map.iter_mut().zip(&other.map).for_each(|(bits, more)| *bits |= more);
        self.fragments += other.fragments;
        self
    }

    /// Returns how many fragments there are, and how many pixels have some.
    pub fn counts(&self) -> [u64; 2] {
        [self.fragments, self.map.iter().map(|bits| u64::from(bits.count_ones())).sum()]
    }

    /// Adds a disc.
    pub fn cover(&mut self, center: DVec2, radius: f64) {
        let own = center.floor();
        for y in covered(center.y, radius, own.y, self.size[1]) {
            let off = f64::from(y) + 0.5 - center.y;
            // NaN where the row misses the disc, and then in place of the pixel of the center elsewhere.
            let half = (radius * radius - off * off).sqrt();
            let own = if f64::from(y) == own.y { own.x } else { f64::NAN };
            self.span(y, covered(center.x, half, own, self.size[0]));
        }
    }

    /// Adds pixels of a row.
    fn span(&mut self, y: u32, columns: Range<u32>) {
        self.fragments += u64::from(columns.end.saturating_sub(columns.start));
        let row = &mut self.map[y as usize * self.words..][..self.words];
        let mut x = columns.start;
        while x < columns.end {
            let (bit, left) = (x % u64::BITS, columns.end - x);
            let count = left.min(u64::BITS - bit);
            row[(x / u64::BITS) as usize] |= (u64::MAX >> (u64::BITS - count)) << bit;
            x += count;
        }
    }
}

/// The pixels of a line of this length whose centers lie within `reach` of a place on it, and `own`; of NaN none.
fn covered(at: f64, reach: f64, own: f64, length: u32) -> Range<u32> {
    let border = |place: f64| place.clamp(0.0, f64::from(length)) as u32;
    border((at - reach - 0.5).ceil().min(own))..border((at + reach - 0.5).floor().max(own) + 1.0)
}
