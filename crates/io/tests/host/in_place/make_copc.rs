//! Small COPC files, made here.

use std::io::Cursor;

use laz::laszip::ChunkTable;
use laz::{LasZipCompressor, LazItemRecordBuilder, LazVlr, LazVlrBuilder};

use crate::io::las::{builder, point, write};

/// Points of a made file.
pub const POINTS: u16 = 900;
/// Byte of the info record's fields: the first record of a header of 375 bytes.
pub const INFO: usize = 375 + 54;
/// Bytes of an entry of the hierarchy.
pub const ENTRY: usize = 32;

/// A file, and where its hierarchy is.
pub struct Made {
    pub bytes: Vec<u8>,
    /// Byte of the first entry of each page: that of the root, then the other one.
    pub pages: [usize; 2],
}

/// Nodes of a cube with a side of 8. The second and the fourth stand on the second page.
const NODES: [[i32; 4]; 5] = [[0, 0, 0, 0], [1, 0, 0, 0], [1, 0, 0, 1], [2, 0, 0, 1], [2, 0, 0, 3]];

/// The node of a point, which is `index % 7` above the floor of the cube.
fn node(index: usize) -> usize {
    match index % 7 {
        _ if index.is_multiple_of(3) => 0,
        0 | 1 => 1,
        2 | 3 => 3,
        4 | 5 => 2,
        _ => 4,
    }
}

/// A file of [`POINTS`] points in five nodes.
pub fn make(format: u8) -> Made {
    make_of(format, POINTS)
}

/// A file of some points in five nodes.
pub fn make_of(format: u8, points: u16) -> Made {
    make_with(format, points, Vec::new())
}

/// A file of some points in five nodes, with more records in its header.
pub fn make_with(format: u8, points: u16, more: Vec<las::Vlr>) -> Made {
    let (vlr, records, mut bytes) = head(format, points, more);
    let start = bytes.len();
    compress(&vlr, &records, usize::from(points), &mut bytes);
    let mut table = Cursor::new(&bytes);
    table.set_position(start as u64);
    let table = ChunkTable::read_from(&mut table, &vlr).unwrap();
    // The compressor adds a chunk of no points.
    assert_eq!(table.len(), NODES.len() + 1);

    let mut entries = Vec::new();
    let mut offset = start as u64 + 8;
    for (at, key) in NODES.into_iter().enumerate() {
        let chunk = &table[at];
        entries.push(entry(key, offset, chunk.byte_count as i32, chunk.point_count as i32));
        offset += chunk.byte_count;
    }
    // An extended record: 60 bytes of its own, then the pages.
    let first = bytes.len() + 60;
    let pages = [first, first + 4 * ENTRY];
    let below = [&*entries[1], &entries[3]].concat();
    let root =
        [&*entries[0], &entries[2], &entries[4], &entry(NODES[1], pages[1] as u64, below.len() as i32, -1)].concat();
    bytes.resize(first, 0);
    bytes.extend(root);
    bytes.extend(below);
    for (at, value) in [(40, pages[0] as u64), (48, 4 * ENTRY as u64)] {
        bytes[INFO + at..][..8].copy_from_slice(&value.to_le_bytes());
    }
    Made { bytes, pages }
}

/// Compression, uncompressed records, and everything before the points.
fn head(format: u8, points: u16, more: Vec<las::Vlr>) -> (LazVlr, Vec<u8>, Vec<u8>) {
    let items = LazItemRecordBuilder::default_for_point_format_id(format, 0).unwrap();
    let vlr = LazVlrBuilder::new(items).with_variable_chunk_size().build();
    let mut laszip = Vec::new();
    vlr.write_to(&mut laszip).unwrap();
    let mut builder = builder(4, format, false);
    let record = |user_id: &str, record_id, data| las::Vlr {
        user_id: user_id.to_owned(),
        record_id,
        description: String::new(),
        data,
    };
    builder.vlrs.push(record("copc", 1, vec![0; 160]));
    builder.vlrs.push(record(LazVlr::USER_ID, LazVlr::RECORD_ID, laszip));
    builder.vlrs.extend(more);
    let layout = builder.point_format;
    let mut bytes = write(builder, (0..points).map(|index| point(&layout, index)));
    let records = bytes.split_off(u32::from_le_bytes([bytes[96], bytes[97], bytes[98], bytes[99]]) as usize);
    // The points are compressed.
    bytes[104] |= 0x80;
    let number = |at: usize| f64::from_le_bytes(bytes[at..at + 8].try_into().unwrap());
    let [x, y, z] = [187, 203, 219].map(number);
    let half = 4.0;
    for (at, value) in [x + half, y + half, z + half, half, 0.5].into_iter().enumerate() {
        bytes[INFO + 8 * at..][..8].copy_from_slice(&value.to_le_bytes());
    }
    (vlr, records, bytes)
}

/// Puts the records behind what is there, node by node.
fn compress(vlr: &LazVlr, records: &[u8], points: usize, bytes: &mut Vec<u8>) {
    let mut to = Cursor::new(std::mem::take(bytes));
    to.set_position(to.get_ref().len() as u64);
    let mut compressor = LasZipCompressor::new(to, vlr.clone()).unwrap();
    let records: Vec<&[u8]> = records.chunks(records.len() / points).collect();
    for wanted in 0..NODES.len() {
        let own = records.iter().enumerate().filter(|(index, _)| node(*index) == wanted);
        own.for_each(|(_, record)| compressor.compress_one(record).unwrap());
        compressor.finish_current_chunk().unwrap();
    }
    compressor.done().unwrap();
    *bytes = compressor.into_inner().into_inner();
}

/// An entry of the hierarchy.
pub fn entry(key: [i32; 4], offset: u64, bytes: i32, points: i32) -> Vec<u8> {
    let mut entry: Vec<u8> = key.into_iter().flat_map(i32::to_le_bytes).collect();
    entry.extend(offset.to_le_bytes());
    entry.extend(bytes.to_le_bytes());
    entry.extend(points.to_le_bytes());
    entry
}
