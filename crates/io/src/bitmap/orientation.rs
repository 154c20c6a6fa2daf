//! Orientation in which a camera was held: that of Exif (CIPA DC-008, tag 274), which TIFF has as well.

/// Turns and mirrors that bring stored pixels upright.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) enum Orientation {
    #[default]
    Upright,
    Mirrored,
    HalfTurn,
    Flipped,
    Transposed,
    QuarterTurn,
    Transversed,
    ThreeQuarterTurn,
}

impl Orientation {
    /// Returns the orientation with the tag's value, 1 to 8.
    pub fn from_number(number: u16) -> Option<Self> {
        Some(match number {
            1 => Self::Upright,
            2 => Self::Mirrored,
            3 => Self::HalfTurn,
            4 => Self::Flipped,
            5 => Self::Transposed,
            6 => Self::QuarterTurn,
            7 => Self::Transversed,
            8 => Self::ThreeQuarterTurn,
            _ => return None,
        })
    }

    /// Reads the orientation from the block of Exif data, a small TIFF; `None` where it says nothing valid.
    pub fn from_exif(block: &[u8]) -> Option<Self> {
        let is_little = match block.get(..4)? {
            b"II*\0" => true,
            b"MM\0*" => false,
            _ => return None,
        };
        let two = |at: usize| {
            let bytes = block.get(at..at.checked_add(2)?)?.try_into().ok()?;
            Some(if is_little { u16::from_le_bytes(bytes) } else { u16::from_be_bytes(bytes) })
        };
        let four = |at: usize| {
            let bytes = block.get(at..at.checked_add(4)?)?.try_into().ok()?;
            Some(if is_little { u32::from_le_bytes(bytes) } else { u32::from_be_bytes(bytes) })
        };
        let directory = four(4)? as usize;
        for entry in 0..usize::from(two(directory)?) {
            // Tag, type, number of values, value: 2, 2, 4 and 4 bytes.
            let at = directory.checked_add(2 + 12 * entry)?;
            let (tag, kind, count, value) = (two(at)?, two(at + 2)?, four(at + 4)?, two(at + 8)?);
            if (tag, kind, count) == (0x112, 3, 1) {
                return Self::from_number(value);
            }
        }
        None
    }

    /// Returns the width and height of the upright picture, of those stored.
    pub fn size(self, [width, height]: [u32; 2]) -> [u32; 2] {
        match self {
            Self::Upright | Self::Mirrored | Self::HalfTurn | Self::Flipped => [width, height],
            Self::Transposed | Self::QuarterTurn | Self::Transversed | Self::ThreeQuarterTurn => [height, width],
        }
    }

    /// Returns the column and row of the stored pixel that is at (x, y) of the upright picture; `stored`: width and
    /// height.
    pub fn source(self, x: u32, y: u32, stored: [u32; 2]) -> [u32; 2] {
        let [right, bottom] = stored.map(|side| side - 1);
        match self {
            Self::Upright => [x, y],
            Self::Mirrored => [right - x, y],
            Self::HalfTurn => [right - x, bottom - y],
            Self::Flipped => [x, bottom - y],
            Self::Transposed => [y, x],
            Self::QuarterTurn => [y, bottom - x],
            Self::Transversed => [right - y, bottom - x],
            Self::ThreeQuarterTurn => [right - y, x],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The standard names the sides of the picture at which the stored row 0 and column 0 are, of 1 to 8.
    const ROW_AND_COLUMN: [(&str, &str); 8] = [
        ("top", "left"),
        ("top", "right"),
        ("bottom", "right"),
        ("bottom", "left"),
        ("left", "top"),
        ("right", "top"),
        ("right", "bottom"),
        ("left", "bottom"),
    ];

    #[test]
    fn the_first_row_and_column_are_where_the_standard_has_them() {
        let stored = [3, 2];
        for (number, (row, column)) in (1..).zip(ROW_AND_COLUMN) {
            let orientation = Orientation::from_number(number).unwrap();
            let [width, height] = orientation.size(stored);
            let is_at = |side: &str, x: u32, y: u32| match side {
                "top" => y == 0,
                "bottom" => y == height - 1,
                "left" => x == 0,
                _ => x == width - 1,
            };
            let mut seen = std::collections::BTreeSet::new();
            for (x, y) in (0..height).flat_map(|y| (0..width).map(move |x| (x, y))) {
                let [source_x, source_y] = orientation.source(x, y, stored);
                assert_eq!(
                    (source_y == 0, source_x == 0),
                    (is_at(row, x, y), is_at(column, x, y)),
                    "{number}: {x} {y}"
                );
                assert!(source_x < 3 && source_y < 2 && seen.insert([source_x, source_y]), "{number}: {x} {y}");
            }
        }
        assert_eq!((Orientation::from_number(0), Orientation::from_number(9)), (None, None));
    }

    #[test]
    fn exif_in_both_byte_orders() {
        // Two entries: the width, then the orientation 6.
        let big = b"MM\0*\0\0\0\x08\0\x02\x01\0\0\x03\0\0\0\x01\0\x09\0\0\x01\x12\0\x03\0\0\0\x01\0\x06\0\0";
        let little = b"II*\0\x08\0\0\0\x02\0\0\x01\x03\0\x01\0\0\0\x09\0\0\0\x12\x01\x03\0\x01\0\0\0\x06\0\0\0";
        for block in [big.as_slice(), little] {
            assert_eq!(Orientation::from_exif(block), Some(Orientation::QuarterTurn));
            // Its last two bytes fill up the value.
            for cut in 0..block.len() - 2 {
                assert_eq!(Orientation::from_exif(&block[..cut]), None, "{cut}");
            }
        }
        assert_eq!(Orientation::from_exif(b"II*\0\xff\xff\xff\xff"), None);
        assert_eq!(Orientation::from_exif(b"Exif\0\0"), None);
    }
}
