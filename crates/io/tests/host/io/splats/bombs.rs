//! Files that would become very large. They are refused before that; `crates/cli/tests/fuzz.rs` measures the memory of
//! such files.

use std::io::{Cursor, Write};

use flate2::Compression;
use flate2::write::GzEncoder;
use rawzip::{CompressionMethod, ZipArchiveWriter};
use ruzstd::encoding::{CompressionLevel, compress_to_vec};

use super::super::{assert_refused, load_bytes};
use super::bytes;

/// A header of SPZ with harmonics of degree 0.
fn header(version: u32, count: u32) -> Vec<u8> {
    let mut header = b"NGSP".to_vec();
    header.extend(version.to_le_bytes());
    header.extend(count.to_le_bytes());
    header.extend([0, 12, 0, 5]);
    header
}

/// A header and so many zeros, which a byte of the stream stands for a thousand of.
fn gzip(header: &[u8], zeros: usize) -> Vec<u8> {
    let mut encoder = GzEncoder::new(Vec::new(), Compression::best());
    encoder.write_all(header).unwrap();
    (0..zeros >> 20).for_each(|_| encoder.write_all(&[0; 1 << 20]).unwrap());
    encoder.finish().unwrap()
}

#[test]
fn gzip_streams() {
    // 20 bytes of each splat, of which ten million are announced and there.
    let bomb = gzip(&header(2, 10_000_000), 200 << 20);
    assert!(bomb.len() < 300_000);
    assert_refused("a.spz", bomb, &["byte 8 of the header", "10000000 splats are announced, more than 32 for each"]);
    // Data that the header doesn't announce is not unpacked: splats of zeros all lie at one place, but have an extent.
    let cloud = load_bytes("a.spz", gzip(&header(3, 4), 64 << 20)).unwrap();
    assert_eq!(cloud.len(), 4);
}

#[test]
fn zstandard_streams() {
    let refused = |count: u32, raw: u64, content: &[u8], says: &[&str]| {
        let stream = compress_to_vec(content, CompressionLevel::Fastest);
        let mut file = header(4, count);
        file.extend(32_u32.to_le_bytes());
        file.extend([0; 12]);
        for each in [raw, u64::from(count), 3 * u64::from(count), 3 * u64::from(count), 4 * u64::from(count)] {
            file.extend((stream.len() as u64).to_le_bytes());
            file.extend(each.to_le_bytes());
        }
        (0..5).for_each(|_| file.extend(&stream));
        assert_refused("a.spz", file, says);
    };
    let zeros = vec![0; 16 << 20];
    refused(4, 36, &zeros, &["stream of positions", "more than the 36 bytes that are announced"]);
    refused(4, 36, &[0; 35], &["stream of positions", "it ends after 35 of 36 bytes"]);
    refused(4, 16 << 20, &zeros, &["stream of positions", "16777216 bytes are announced, but 4 splats have 36"]);
    refused(u32::MAX, 36, &[0; 36], &["4294967295 splats are announced, more than 32 for each of the"]);
}

/// The soup as an archive, with some of its files replaced and deflated.
fn sog(replaced: &[(&str, &[u8])]) -> Vec<u8> {
    let names = [
        "meta.json",
        "means_l.webp",
        "means_u.webp",
        "quats.webp",
        "scales.webp",
        "sh0.webp",
        "shN_centroids.webp",
        "shN_labels.webp",
    ];
    let mut archive = ZipArchiveWriter::new(Vec::new());
    for name in names {
        let own = replaced.iter().find(|(replaced, _)| *replaced == name);
        let content = own.map_or_else(|| bytes(&format!("soup-folder/{name}")), |(_, content)| content.to_vec());
        let (mut entry, config) =
            archive.new_file(format!("soup/{name}")).compression_method(CompressionMethod::DEFLATE).start().unwrap();
        let encoder = flate2::write::DeflateEncoder::new(&mut entry, Compression::best());
        let mut writer = config.wrap(encoder);
        writer.write_all(&content).unwrap();
        let (encoder, descriptor) = writer.finish().unwrap();
        encoder.finish().unwrap();
        entry.finish(descriptor).unwrap();
    }
    archive.finish().unwrap()
}

/// A picture of one color.
fn picture(width: u32, height: u32) -> Vec<u8> {
    let mut file = Cursor::new(Vec::new());
    let pixels = vec![7; (width * height * 4) as usize];
    let encoder = image_webp::WebPEncoder::new(&mut file);
    encoder.encode(&pixels, width, height, image_webp::ColorType::Rgba8).unwrap();
    file.into_inner()
}

#[test]
fn archives_and_pictures() {
    // A folder in the archive, and deflated files.
    assert_eq!(load_bytes("a.sog", sog(&[])).unwrap().len(), 40);
    assert_refused(
        "a.sog",
        sog(&[("meta.json", &vec![b' '; 64 << 20])]),
        &["meta.json", "bytes are announced for", "more than 64"],
    );
    let large = picture(4000, 2000);
    assert!(large.len() < 100_000, "{}", large.len());
    assert_refused(
        "a.sog",
        sog(&[("quats.webp", &large)]),
        &["quats.webp", "4000 × 2000 pixels are far more than the 40 splats"],
    );
    assert_refused(
        "a.sog",
        sog(&[("shN_centroids.webp", &picture(512, 300))]),
        &["shN_centroids.webp", "512 × 300 pixels, expected 512 ×"],
    );
    let small = picture(4, 4);
    assert_refused("a.sog", sog(&[("sh0.webp", &small)]), &["sh0.webp", "4 × 4 pixels are fewer than the 40 splats"]);
}
