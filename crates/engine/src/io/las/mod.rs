//! LAS 1.0–1.4 and LAZ files; a COPC file is a LAZ file whose chunks happen to form a tree.
//!
//! The libraries read headers and decompress; everything a file claims (records, counts, lengths) is compared with its
//! size here first, since they allocate what is claimed. Extended variable-length records are not read.

mod chunks;
mod columns;
mod extra;
mod header;

use std::io::{Read, Seek, SeekFrom};

use crate::progress::Progress;
use glam::DVec3;
use rayon::prelude::*;

use super::store::Grid;
use super::{Error, LasColumns, Source};
use crate::cloud::Cloud;
use chunks::Chunk;
use columns::Columns;

/// Chunks read before they are decoded side by side, per thread: enough to level out chunks of different cost.
const CHUNKS_PER_THREAD: usize = 4;

/// Reads the points of a LAS or LAZ file.
pub(super) fn read(source: &mut Source, asked: LasColumns, progress: &Progress) -> Result<Cloud, Error> {
    let header = header::read(source)?;
    progress.set_length(header.count);
    if header.count == 0 {
        return Ok(Cloud::default());
    }
    let chunks = match &header.laz {
        Some(laz) => chunks::compressed(source, &header, laz)?,
        None => chunks::plain(source, &header)?,
    };
    let mut columns = Columns::new(&header, asked);
    for batch in chunks.chunks(CHUNKS_PER_THREAD * rayon::current_num_threads()) {
        let loaded = batch.iter().map(|chunk| load(source, chunk)).collect::<Result<Vec<_>, _>>()?;
        let decode = |(chunk, bytes): (&Chunk, Vec<u8>)| {
            let mut columns = Columns::new(&header, asked);
            let decoded = chunk.decode(&header, &bytes, |records| {
                columns.push(&header, records)?;
                progress.inc((records.len() / header.record_len) as u64);
                Ok(())
            });
            decoded.map(|()| columns).map_err(|cause| {
                let (first, last) = (chunk.first_point, chunk.first_point + chunk.points - 1);
                source.malformed(format!("points {first}–{last} (chunk at byte {})", chunk.start), cause)
            })
        };
        let decoded = batch.par_iter().zip(loaded).map(decode).collect::<Result<Vec<_>, _>>()?;
        decoded.into_iter().for_each(|part| columns.append(part));
    }
    Ok(columns.finish(&header, asked))
}

/// The grid that the positions of a file lie on.
pub(super) fn grid(source: &mut Source) -> Result<Grid, Error> {
    let transforms = header::read(source)?.transforms;
    let each = |of: fn(&las::Transform) -> f64| DVec3::new(of(&transforms.x), of(&transforms.y), of(&transforms.z));
    Ok(Grid { scale: each(|transform| transform.scale), offset: each(|transform| transform.offset) })
}

/// The bytes of a chunk, which lies within the file.
fn load(source: &mut Source, chunk: &Chunk) -> Result<Vec<u8>, Error> {
    let mut bytes = Vec::new();
    let read = source.reader.seek(SeekFrom::Start(chunk.start));
    let read = read.and_then(|_| source.reader.by_ref().take(chunk.bytes).read_to_end(&mut bytes));
    read.map_err(|e| source.read_error(e))?;
    Ok(bytes)
}
