//! Extensions of an SPZ file: records of a type, the length of the content, and that content, one behind the other.

use super::frame::Frame;
use crate::number::word;

/// The record of the axes: their number.
const COORDINATE_SYSTEM: u32 = 0xadbe_0003;

/// The record of limits to a viewer's camera, which change no picture. Files of 2025 have it without its length.
const ORBIT: u32 = 0xadbe_0002;

/// Bytes of a type and a length.
const HEAD: usize = 8;

/// The bytes of extensions that are read, at most.
pub(super) const MOST_BYTES: u64 = 1 << 20;

/// Contents of the extensions of a file.
#[derive(Debug, Default)]
pub(super) struct Extensions {
    /// The axes of the splats.
    pub frame: Frame,
    /// Warnings about records that are not read.
    pub warnings: Vec<String>,
}

/// Reads all records, or says what is wrong with one of them.
pub(super) fn read(mut bytes: &[u8]) -> Result<Extensions, String> {
    let (mut found, mut frame) = (Extensions::default(), None);
    while bytes.len() >= HEAD {
        let (kind, len) = (word(bytes, 0), word(bytes, 4));
        let rest = &bytes[HEAD..];
        let Some((content, behind)) = rest.split_at_checked(len as usize) else {
            if kind != ORBIT {
                found.warnings.push(format!(
                    "an extension of the SPZ file is not read: record {kind:#010x} announces {len} bytes, but {} are left",
                    rest.len()
                ));
            }
            break;
        };
        match kind {
            COORDINATE_SYSTEM if len == 4 => {
                let number = word(content, 0);
                let named = Frame::numbered(number);
                let named = named.ok_or_else(|| format!("coordinate system {number} is unknown, expected 0 to 16"))?;
                // The first one counts, as in the format's own reader.
                frame.get_or_insert(named);
            }
            COORDINATE_SYSTEM => return Err(format!("the coordinate system has {len} bytes, expected 4")),
            ORBIT => {}
            _ => found.warnings.push(format!("extension {kind:#010x} of the SPZ file is not read")),
        }
        bytes = behind;
    }
    found.frame = frame.unwrap_or_default();
    Ok(found)
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;

    fn record(kind: u32, content: &[u8]) -> Vec<u8> {
        [&kind.to_le_bytes()[..], &(content.len() as u32).to_le_bytes(), content].concat()
    }

    #[test]
    fn records_are_read_or_named() {
        let axes = |number: u32| record(COORDINATE_SYSTEM, &number.to_le_bytes());
        let all = [record(ORBIT, &[0; 12]), record(0x1234_0001, &[1, 2, 3]), axes(6), axes(4)].concat();
        let found = read(&all).unwrap();
        assert_eq!(found.warnings, ["extension 0x12340001 of the SPZ file is not read"]);
        assert_eq!(found.frame.position(DVec3::ONE), DVec3::ONE, "right, down, front, of the first one");
        for harmless in [Vec::new(), axes(4), axes(0), record(ORBIT, &[0; 12]), vec![0; 7]] {
            let found = read(&harmless).unwrap();
            assert!(found.warnings.is_empty(), "{:?}", found.warnings);
            assert_eq!(found.frame.position(DVec3::ONE), DVec3::new(1.0, -1.0, -1.0));
        }
        // Without its length, which is read as -0.5 then.
        let old = [&ORBIT.to_le_bytes()[..], &(-0.5_f32).to_le_bytes(), &[0; 8]].concat();
        assert!(read(&old).unwrap().warnings.is_empty());
        let cut = read(&axes(6)[..11]).unwrap().warnings;
        assert!(cut[0].contains("record 0xadbe0003 announces 4 bytes, but 3 are left"), "{cut:?}");
        assert_eq!(read(&axes(17)).unwrap_err(), "coordinate system 17 is unknown, expected 0 to 16");
        assert_eq!(
            read(&record(COORDINATE_SYSTEM, &[6])).unwrap_err(),
            "the coordinate system has 1 bytes, expected 4"
        );
    }
}
