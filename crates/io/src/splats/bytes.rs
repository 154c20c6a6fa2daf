//! Little-endian numbers at places of a slice whose length was checked.

/// Some bytes at a place. Readers check the length of what they read beforehand; behind the end there are zeros.
fn at<const N: usize>(bytes: &[u8], place: usize) -> [u8; N] {
    bytes.get(place..).and_then(|rest| rest.first_chunk()).copied().unwrap_or([0; N])
}

/// Returns a number of 16 bits.
pub(crate) fn short(bytes: &[u8], place: usize) -> u16 {
    u16::from_le_bytes(at(bytes, place))
}

/// Returns a number of 32 bits.
pub(crate) fn word(bytes: &[u8], place: usize) -> u32 {
    u32::from_le_bytes(at(bytes, place))
}

/// Returns a number of 64 bits.
pub(super) fn long(bytes: &[u8], place: usize) -> u64 {
    u64::from_le_bytes(at(bytes, place))
}

/// Returns a float32.
pub(crate) fn float(bytes: &[u8], place: usize) -> f64 {
    f32::from_le_bytes(at(bytes, place)).into()
}

/// Returns a float16.
pub(super) fn half(bytes: &[u8], place: usize) -> f64 {
    half::f16::from_le_bytes(at(bytes, place)).into()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_and_what_is_behind_them() {
        let bytes = [0, 0, 0x80, 0x3f, 0, 0x3c, 1, 0];
        assert_eq!((float(&bytes, 0), half(&bytes, 4), short(&bytes, 6), word(&bytes, 4)), (1.0, 1.0, 1, 0x0001_3c00));
        assert_eq!((long(&bytes, 0), short(&bytes, 7), word(&bytes, 99)), (0x0001_3c00_3f80_0000, 0, 0));
    }
}
