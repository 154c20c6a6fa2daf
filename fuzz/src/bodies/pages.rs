//! Checksums of E57 files. Without right ones a reader would refuse all that a fuzzer makes of a file at its first
//! page.

/// Bytes of a page, the last four of which are the checksum of the others.
const PAGE: usize = 1024;

/// Returns the file with right checksums; what is left of its last page stays as it is.
pub fn with_checksums(file: &[u8]) -> Vec<u8> {
    let mut mended = file.to_vec();
    for page in mended.chunks_exact_mut(PAGE) {
        let (payload, checksum) = page.split_at_mut(PAGE - 4);
        checksum.copy_from_slice(&crc32c(payload).to_be_bytes());
    }
    mended
}

/// CRC-32C (Castagnoli), reflected.
fn crc32c(bytes: &[u8]) -> u32 {
    let step = |crc: u32| if crc & 1 == 1 { crc >> 1 ^ 0x82f6_3b78 } else { crc >> 1 };
    !bytes.iter().fold(u32::MAX, |crc, byte| (0..8).fold(crc ^ u32::from(*byte), |crc, _| step(crc)))
}
