//! The independent parts of a LAS or LAZ file's points, and their decoding.

use std::io::{Cursor, Read, Seek, SeekFrom};

use laz::las::{v3, v4};
use laz::laszip::{ChunkTable, CompressorType};
use laz::record::{LayeredPointRecordDecompressor, RecordDecompressor, SequentialPointRecordDecompressor};
use laz::{DecompressionSelection, LazItemType, LazVlr};

use super::header::LasHeader;
use super::times::{GpsTime, Timed};
use crate::number::word;
use crate::{Error, InputFile, decoder};

/// Points decoded at a time. Memory is allocated block by block, so that a false count costs nothing.
const BLOCK: u64 = 1 << 16;

/// Bytes of points decoded at a time, for point records that are as large as their 16 bits can say.
const BLOCK_BYTES: u64 = 16 << 20;

/// Bytes of a compressed point record at most: its decoder keeps some 3 kB of models for each extra byte, and has up to
/// four sets of them.
const MAX_COMPRESSED_RECORD: usize = 2048;

/// The number of points of this size that are decoded at a time.
fn block(record_len: usize) -> u64 {
    BLOCK.min(BLOCK_BYTES / record_len.max(1) as u64)
}

/// A run of points that can be decoded independently. It lies within the file.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Chunk {
    pub start: u64,
    pub bytes: u64,
    pub first_point: u64,
    pub points: u64,
}

/// Cuts uncompressed points into blocks.
pub(super) fn plain(source: &InputFile, header: &LasHeader) -> Result<Vec<Chunk>, Error> {
    if header.record_len == 0 {
        return Err(source.malformed("LAS header", "its point records have 0 bytes"));
    }
    let len = header.record_len as u64;
    let block = |first_point| {
        let points = BLOCK.min(header.count - first_point);
        Chunk { start: header.start + first_point * len, bytes: points * len, first_point, points }
    };
    Ok((0..header.count).step_by(BLOCK as usize).map(block).collect())
}

/// Returns the chunks of a compressed file: those of its chunk table, or a single one in files older than that table.
pub(super) fn compressed(source: &mut InputFile, header: &LasHeader, laz: &LazVlr) -> Result<Vec<Chunk>, Error> {
    check_items(source, header, laz)?;
    if compressor(laz) == Some(CompressorType::PointWise) {
        let bytes = source.len - header.start;
        return Ok(vec![Chunk { start: header.start, bytes, first_point: 0, points: header.count }]);
    }
    let (table, data_end) = chunk_table(source, header, laz)?;
    // The points follow the table's own position.
    let mut start = header.start + ChunkTable::OFFSET_SIZE as u64;
    let mut first_point = 0;
    let mut chunks = Vec::new();
    for (index, entry) in table.into_iter().enumerate() {
        let points = entry.point_count.min(header.count - first_point);
        if points == 0 {
            start = start.saturating_add(entry.byte_count);
            continue;
        }
        if entry.byte_count > data_end.saturating_sub(start) {
            let cause =
                format!("it has {} bytes from byte {start}, but all chunks end by byte {data_end}", entry.byte_count);
            return Err(source.malformed(format!("LAZ chunk {index}"), cause));
        }
        chunks.push(Chunk { start, bytes: entry.byte_count, first_point, points });
        start += entry.byte_count;
        first_point += points;
    }
    if first_point < header.count {
        let count = header.count;
        return Err(
            source.truncated(format!("the header announces {count} points, but the chunk table has {first_point}"))
        );
    }
    Ok(chunks)
}

/// The library keeps the field to itself, so it's read from the record as written.
fn compressor(laz: &LazVlr) -> Option<CompressorType> {
    let mut bytes = Vec::new();
    laz.write_to(&mut bytes).ok()?;
    match bytes.first()? {
        1 => Some(CompressorType::PointWise),
        2 => Some(CompressorType::PointWiseChunked),
        3 => Some(CompressorType::LayeredChunked),
        _ => None,
    }
}

/// The fields that the compressor announces must be those of a point record, or the library would panic.
fn check_items(source: &InputFile, header: &LasHeader, laz: &LazVlr) -> Result<(), Error> {
    let place = "LAZ record of the header";
    if compressor(laz).is_none() {
        return Err(source.malformed(place, "the points are marked as compressed, but the record names no compressor"));
    }
    // Before the decoder takes memory for them; the library's own sum of 16-bit sizes may overflow.
    let announced: u64 = laz.items().iter().map(|item| u64::from(item.size())).sum();
    if announced != header.record_len as u64 {
        let cause = format!("its fields take {announced} bytes, but a point record has {}", header.record_len);
        return Err(source.malformed(place, cause));
    }
    if header.record_len > MAX_COMPRESSED_RECORD {
        let cause = format!("its point records have {} bytes (at most {MAX_COMPRESSED_RECORD})", header.record_len);
        return Err(source.malformed(place, cause));
    }
    let items = decoder::guard(|| record_decoder(laz, &[], false).map(|decoder| decoder.record_size()));
    let size = items.and_then(|size| size).map_err(|cause| source.malformed(place, cause))?;
    if size != header.record_len {
        let cause = format!("its fields take {size} bytes, but a point record has {}", header.record_len);
        return Err(source.malformed(place, cause));
    }
    Ok(())
}

/// The chunk table, and the byte before which all chunks end.
fn chunk_table(source: &mut InputFile, header: &LasHeader, laz: &LazVlr) -> Result<(ChunkTable, u64), Error> {
    let place = table_place(source, header).map_err(|e| source.read_error(e))?;
    let data_start = header.start + ChunkTable::OFFSET_SIZE as u64;
    let Some(place) = place.filter(|place| (data_start..source.len.saturating_sub(7)).contains(place)) else {
        let place = place.map_or_else(|| "nowhere".to_owned(), |place| format!("at byte {place}"));
        return Err(
            source.truncated(format!("the LAZ chunk table should be {place}, but the file has {} bytes", source.len))
        );
    };
    // The library allocates the announced number of entries at once. Each chunk starts with an uncompressed point.
    let chunks = entry_count(source, place).map_err(|e| source.read_error(e))?;
    let possible = (place - data_start) / header.record_len.max(1) as u64;
    if chunks > possible {
        let cause = format!("it announces {chunks} chunks, but the bytes before it hold at most {possible}");
        return Err(source.malformed(format!("LAZ chunk table at byte {place}"), cause));
    }
    source.reader.seek(SeekFrom::Start(header.start)).map_err(|e| source.read_error(e))?;
    let read = decoder::guard(|| ChunkTable::read_from(&mut source.reader, laz));
    let table = read
        .and_then(|read| read.map_err(|e| e.to_string()))
        .map_err(|cause| source.malformed(format!("LAZ chunk table at byte {place}"), cause))?;
    Ok((table, place))
}

/// The position of the chunk table, stored where the points start; a writer that couldn't seek back stores it at the
/// end of the file.
fn table_place(source: &mut InputFile, header: &LasHeader) -> std::io::Result<Option<u64>> {
    let mut bytes = [0; 8];
    for from in [SeekFrom::Start(header.start), SeekFrom::End(-8)] {
        source.reader.seek(from)?;
        if source.reader.read_exact(&mut bytes).is_ok() {
            let place = i64::from_le_bytes(bytes);
            if let Some(place) = u64::try_from(place).ok().filter(|&place| place > header.start) {
                return Ok(Some(place));
            }
        }
    }
    Ok(None)
}

/// The number of chunks that the table announces, after its 4-byte version.
fn entry_count(source: &mut InputFile, place: u64) -> std::io::Result<u64> {
    let mut bytes = [0; 4];
    source.reader.seek(SeekFrom::Start(place + 4))?;
    source.reader.read_exact(&mut bytes)?;
    Ok(u32::from_le_bytes(bytes).into())
}

impl Chunk {
    /// Passes the chunk's records on in blocks, or returns the defect. Fields that aren't selected may have any value.
    pub(super) fn decode(
        &self,
        header: &LasHeader,
        bytes: &[u8],
        selection: DecompressionSelection,
        mut take: impl FnMut(&[u8]) -> Result<(), String>,
    ) -> Result<(), String> {
        let Some(laz) = &header.laz else { return take(bytes) };
        check_layers(header, laz, bytes)?;
        let mut decoder = record_decoder(laz, bytes, selection.should_decompress_gps_time())?;
        decoder.set_selection(selection);
        let mut records = Vec::new();
        let mut done = 0;
        while done < self.points {
            let points = block(header.record_len).min(self.points - done);
            records.resize(points as usize * header.record_len, 0);
            match decoder::guard(|| decoder.decompress_many(&mut records)) {
                Ok(Ok(())) => {}
                Ok(Err(e)) if e.kind() == std::io::ErrorKind::UnexpectedEof => {
                    return Err(format!("the {} bytes end before {} points are decoded", bytes.len(), self.points));
                }
                Ok(Err(e)) => return Err(e.to_string()),
                Err(panic) => return Err(format!("the LAZ decoder gave up: {panic}")),
            }
            take(&records)?;
            done += points;
        }
        Ok(())
    }
}

type Decoder<'a> = Box<dyn RecordDecompressor<Cursor<&'a [u8]>> + 'a>;

/// A decoder of one chunk, in its initial state. Layers of times are decoded only by one that is made for it.
fn record_decoder<'a>(laz: &LazVlr, bytes: &'a [u8], times: bool) -> Result<Decoder<'a>, String> {
    let input = Cursor::new(bytes);
    let failed = |error: laz::LasZipError| error.to_string();
    match laz.items().first().map(|item| item.version()) {
        Some(1 | 2) => {
            let mut decoder = SequentialPointRecordDecompressor::new(input);
            for item in laz.items() {
                match (item.item_type(), item.version()) {
                    (LazItemType::GpsTime, 2) => decoder.add_field_decompressor(GpsTime::default()),
                    _ => decoder.set_fields_from(&vec![*item]).map_err(failed)?,
                }
            }
            Ok(Box::new(decoder))
        }
        Some(3 | 4) => {
            let mut decoder = LayeredPointRecordDecompressor::new(input);
            for item in laz.items() {
                match (item.item_type(), item.version()) {
                    (LazItemType::Point14, 3) if times => {
                        decoder.add_field_decompressor(Timed::<v3::LasPoint6Decompressor>::default());
                    }
                    (LazItemType::Point14, 4) if times => {
                        decoder.add_field_decompressor(Timed::<v4::LasPoint6Decompressor>::default());
                    }
                    _ => decoder.set_fields_from(&vec![*item]).map_err(failed)?,
                }
            }
            Ok(Box::new(decoder))
        }
        Some(version) => Err(format!("fields compressed by version {version} (known: 1 to 4)")),
        None => Err("no fields".to_owned()),
    }
}

/// The layers of a chunk (LAS 1.4 compression) are allocated as their sizes say, so these must fit into the chunk.
///
/// A chunk is: the first point, the number of points (u32), the size of each layer (u32), the layers.
fn check_layers(header: &LasHeader, laz: &LazVlr, bytes: &[u8]) -> Result<(), String> {
    if laz.items().first().is_none_or(|item| item.version() < 3) {
        return Ok(());
    }
    let layers: usize = laz.items().iter().map(|item| layers(item.item_type())).sum();
    let sizes_start = header.record_len + 4;
    let Some(sizes) = bytes.get(sizes_start..sizes_start + 4 * layers) else {
        return Err(format!("{} bytes are too few for the sizes of its {layers} layers", bytes.len()));
    };
    let total: u64 = sizes.chunks_exact(4).map(|size| u64::from(word(size, 0))).sum();
    let left = (bytes.len() - sizes_start - 4 * layers) as u64;
    if total > left { Err(format!("its layers take {total} bytes, but only {left} are left")) } else { Ok(()) }
}

/// Layers that a field is stored in.
fn layers(item: LazItemType) -> usize {
    match item {
        LazItemType::Point14 => 9,
        LazItemType::RGB14 | LazItemType::WavePacket14 => 1,
        LazItemType::RGBNIR14 => 2,
        LazItemType::Byte14(count) => count.into(),
        // Fields of the older compression, which has no layers.
        _ => 0,
    }
}
