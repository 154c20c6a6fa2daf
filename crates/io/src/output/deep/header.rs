//! The header of a deep EXR.

use std::io;

use super::super::matrices;
use super::{DeepLayout, Numbers, Packing, State, invalid};

/// Magic number and version 2 with the bit of files that are no images of one value per pixel.
const BEGIN: [u8; 8] = [0x76, 0x2f, 0x31, 0x01, 2, 0x08, 0, 0];
/// The bit of names with more than 31 bytes, in the second byte of the version.
const LONG_NAMES: u8 = 0x04;
/// Bytes of a name without that bit, and with it.
const NAME_BYTES: [usize; 2] = [31, 255];
/// Values of `deepImageState`, and the types of channels.
const SORTED: u8 = 1;
const TIDY: u8 = 3;
const HALF: u32 = 1;
const FLOAT: u32 = 2;
/// Values of `compression`.
const NONE: u8 = 0;
const ZIPS: u8 = 2;

/// A header, and where in it the length of the longest list stands.
pub(super) struct Header {
    pub(super) bytes: Vec<u8>,
    pub(super) longest_at: u64,
}

/// Returns the header of a file, whose longest list is not known.
///
/// # Errors
/// Names of metadata that are empty, longer than 255 bytes, hold a zero, or are the name of another attribute; values
/// of 2 GiB.
pub(super) fn bytes(layout: &DeepLayout) -> io::Result<Header> {
    const LONGEST: &str = "maxSamplesPerPixel";
    let [width, height] = layout.size.map(|side| side as i32);
    let window: Vec<u8> = [0, 0, width - 1, height - 1].iter().flat_map(|v: &i32| v.to_le_bytes()).collect();
    let state = if layout.state == State::Tidy { TIDY } else { SORTED };
    let packing = if layout.packing == Packing::Zips { ZIPS } else { NONE };
    let mut attributes = vec![
        ("channels", "chlist", channels(layout)),
        ("chunkCount", "int", height.to_le_bytes().to_vec()),
        ("compression", "compression", vec![packing]),
        ("dataWindow", "box2i", window.clone()),
        ("displayWindow", "box2i", window),
        // Increasing.
        ("lineOrder", "lineOrder", vec![0]),
        (LONGEST, "int", (-1i32).to_le_bytes().to_vec()),
        ("name", "string", b"deep".to_vec()),
        ("pixelAspectRatio", "float", 1f32.to_le_bytes().to_vec()),
        ("screenWindowCenter", "v2f", vec![0; 8]),
        ("screenWindowWidth", "float", 1f32.to_le_bytes().to_vec()),
        ("type", "string", b"deepscanline".to_vec()),
        ("version", "int", 1i32.to_le_bytes().to_vec()),
    ];
    attributes.extend(layout.tells_state.then(|| ("deepImageState", "deepImageState", vec![state])));
    let matrices = layout.camera.and_then(|camera| matrices::matrices(&camera, layout.size));
    let bytes_of = |matrix: [f32; 16]| matrix.iter().flat_map(|value| value.to_le_bytes()).collect::<Vec<u8>>();
    let matrices = matrices.into_iter().flat_map(|both| matrices::NAMES.into_iter().zip(both));
    attributes.extend(matrices.map(|(name, matrix)| (name, "m44f", bytes_of(matrix))));
    attributes.extend(layout.metadata.iter().map(|(name, value)| (name.as_str(), "string", value.as_bytes().to_vec())));
    attributes.sort();
    let mut header = Header { bytes: BEGIN.to_vec(), longest_at: 0 };
    if attributes.iter().any(|(name, ..)| name.len() > NAME_BYTES[0]) {
        header.bytes[5] |= LONG_NAMES;
    }
    if let Some(pair) = attributes.windows(2).find(|pair| pair[0].0 == pair[1].0) {
        return Err(invalid(format!("two attributes of the name {:?}", pair[0].0)));
    }
    for (name, kind, value) in attributes {
        let length = i32::try_from(value.len()).map_err(|_| invalid(format!("{name} has more than 2 GiB")))?;
        if name.is_empty() || name.len() > NAME_BYTES[1] || name.contains('\0') {
            return Err(invalid(format!(
                "{name:?} is no name of an attribute: it has 1 to 255 bytes, none of them zero"
            )));
        }
        for text in [name, kind] {
            header.bytes.extend_from_slice(text.as_bytes());
            header.bytes.push(0);
        }
        header.bytes.extend(length.to_le_bytes());
        if name == LONGEST {
            header.longest_at = header.bytes.len() as u64;
        }
        header.bytes.extend(value);
    }
    header.bytes.push(0);
    Ok(header)
}

/// The list of channels, by name.
fn channels(layout: &DeepLayout) -> Vec<u8> {
    let color = if layout.numbers == Numbers::Half { HALF } else { FLOAT };
    let mut bytes = Vec::new();
    let back = layout.volumes.then_some(("ZBack", FLOAT));
    let all = [("A", color), ("B", color), ("G", color), ("R", color), ("Z", FLOAT)].into_iter().chain(back);
    for (name, kind) in all {
        bytes.extend_from_slice(name.as_bytes());
        bytes.push(0);
        bytes.extend(kind.to_le_bytes());
        // For lossy packing only, then three unused bytes.
        bytes.extend([0; 4]);
        // A value for each pixel, along both sides.
        bytes.extend([1u32, 1].iter().flat_map(|step| step.to_le_bytes()));
    }
    bytes.push(0);
    bytes
}
