//! A line of a deep EXR as a chunk.

use std::io::{self, Write};

use flate2::Compression;
use flate2::write::ZlibEncoder;
use half::f16;

use super::{DeepLayout, Numbers, Packing, Sample, invalid};

/// Bytes of a chunk before its tables: row, and three sizes.
pub(super) const HEAD_BYTES: u64 = 4 + 3 * 8;
/// The level at which OpenEXR packs as well.
const LEVEL: u32 = 4;

/// A complete line.
pub(super) struct Line<'a> {
    pub(super) y: u32,
    pub(super) lengths: &'a [u32],
    pub(super) samples: &'a [Sample],
}

impl Line<'_> {
    /// Returns the chunk.
    ///
    /// # Errors
    /// 2 GiB or more, which OpenEXR does not read.
    pub(super) fn encode(&self, layout: &DeepLayout) -> io::Result<Vec<u8>> {
        let unpacked = unpacked_bytes(self.y, self.samples.len() as u64, layout)?;
        let mut sum = 0u32;
        let counts = self.lengths.iter().flat_map(|n| {
            // Less than 2 GiB of samples are fewer than 2³¹.
            sum += n;
            sum.to_le_bytes()
        });
        let counts = packed(counts.collect(), layout.packing)?;
        let data = packed(self.channels(layout), layout.packing)?;
        let mut chunk = self.y.to_le_bytes().to_vec();
        chunk.extend([counts.len() as u64, data.len() as u64, unpacked].iter().flat_map(|size| size.to_le_bytes()));
        chunk.extend(counts);
        chunk.extend(data);
        Ok(chunk)
    }

    /// All values of A, then all of B, G, R, Z, and ZBack if there is one.
    fn channels(&self, layout: &DeepLayout) -> Vec<u8> {
        let mut bytes = Vec::with_capacity(self.samples.len() * layout.sample_bytes() as usize);
        for channel in [3, 2, 1, 0] {
            let values = self.samples.iter().map(|sample| sample.rgba[channel]);
            match layout.numbers {
                Numbers::Float => bytes.extend(values.flat_map(f32::to_le_bytes)),
                Numbers::Half => bytes.extend(values.flat_map(|value| finite_half(value).to_le_bytes())),
            }
        }
        bytes.extend(self.samples.iter().flat_map(|sample| sample.depth.to_le_bytes()));
        if layout.volumes {
            bytes.extend(self.samples.iter().flat_map(|sample| sample.back.to_le_bytes()));
        }
        bytes
    }
}

/// Bytes of a row of so many samples.
fn unpacked_bytes(y: u32, samples: u64, layout: &DeepLayout) -> io::Result<u64> {
    let bytes = samples * layout.sample_bytes();
    if bytes > i32::MAX as u64 {
        return Err(invalid(format!(
            "row {y} has {samples} samples, {bytes} bytes: OpenEXR reads rows of less than 2 GiB; fewer columns or fewer points would do"
        )));
    }
    Ok(bytes)
}

/// The nearest float16, but none that is infinite: an infinite color times no light would be no number.
fn finite_half(value: f32) -> f16 {
    f16::from_f32(value).clamp(f16::MIN, f16::MAX)
}

/// Bytes as they are stored: packed if that makes them fewer.
fn packed(bytes: Vec<u8>, packing: Packing) -> io::Result<Vec<u8>> {
    if packing == Packing::Raw || bytes.is_empty() {
        return Ok(bytes);
    }
    let mut encoder = ZlibEncoder::new(Vec::new(), Compression::new(LEVEL));
    encoder.write_all(&differences(&bytes))?;
    let packed = encoder.finish()?;
    Ok(if packed.len() < bytes.len() { packed } else { bytes })
}

/// Returns what ZIPS deflates: bytes of even places before those of odd ones, and of each the difference to the one
/// before, plus 128.
fn differences(bytes: &[u8]) -> Vec<u8> {
    let halves = bytes.iter().step_by(2).chain(bytes.iter().skip(1).step_by(2));
    let mut before = None;
    halves.map(|byte| byte.wrapping_sub(before.replace(*byte).map_or(0, |b: u8| b.wrapping_sub(128)))).collect()
}

#[cfg(test)]
mod tests {
    use super::super::State;
    use super::*;

    #[test]
    fn differences_by_hand() {
        // Even places 10, 30, odd ones 20, 15; the first stays, the others are 30 - 10 + 128, 20 - 30 + 128, 15 - 20 +
        // 128.
        assert_eq!(differences(&[10, 20, 30, 15]), [10, 148, 118, 123]);
        assert_eq!(differences(&[0, 255, 200]), [0, 72, 183]);
        assert!(differences(&[]).is_empty());
    }

    #[test]
    fn halves_are_the_nearest_and_finite() {
        for (value, half) in
            [(1.0, 1.0), (65_504.0, 65_504.0), (65_520.0, 65_504.0), (1e30, 65_504.0), (-1e30, -65_504.0)]
        {
            assert_eq!(finite_half(value).to_f32(), half, "{value}");
        }
        // Halfway between 1 and the next, 1 + 2⁻¹⁰: to even.
        assert_eq!(finite_half(1.0 + 2f32.powi(-11)).to_f32(), 1.0);
    }

    #[test]
    fn incompressible_blocks_are_stored_uncompressed() {
        // Marsaglia's xorshift, which no deflater sees through.
        let mut x = 1u32;
        let mut next = || {
            x ^= x << 13;
            x ^= x >> 17;
            x ^= x << 5;
            (x >> 8) as u8
        };
        let noise: Vec<u8> = (0..64).map(|_| next()).collect();
        assert_eq!(packed(noise.clone(), Packing::Zips).unwrap(), noise);
        assert!(packed(vec![7; 1000], Packing::Zips).unwrap().len() < 100);
        assert_eq!(packed(vec![7; 1000], Packing::Raw).unwrap(), [7; 1000]);
    }

    #[test]
    fn lines_that_nobody_reads_are_refused() {
        let layout = DeepLayout {
            size: [1, 1],
            state: State::Tidy,
            tells_state: false,
            numbers: Numbers::Float,
            packing: Packing::Raw,
            volumes: false,
            metadata: Vec::new(),
            camera: None,
        };
        // The last that fit, of 20 bytes each, and one more.
        let most = (1 << 31) / 20;
        assert_eq!(unpacked_bytes(0, most, &layout).unwrap(), most * 20);
        let error = unpacked_bytes(7, most + 1, &layout).unwrap_err().to_string();
        assert!(error.starts_with("row 7 has 107374183 samples"), "{error}");
    }
}
