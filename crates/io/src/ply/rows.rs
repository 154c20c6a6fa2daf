//! Binary vertices that are rows of one size, read by any number of threads.

use std::io::Seek;
use std::ops::Range;

use ply_rs_bw::ply::Encoding;

use super::header::{Element, PlyHeader, PlyType, ScalarType, size};
use super::payload::{self, column};
use crate::columns::{PointTable, RowBlock, RowLayout};
use crate::{Error, InputFile, SharedFile};
use pellucid_core::progress::Progress;

/// Rows that a thread parses at a time.
const RUN: usize = 1 << 14;

/// The vertices of a file.
#[derive(Debug)]
pub(crate) struct VertexRows {
    pub file: SharedFile,
    pub layout: RowLayout,
    pub count: u64,
    pub row_len: u64,
    /// Byte of the first row.
    start: u64,
    /// The byte in a row, and the type, of each value.
    values: Vec<(usize, ScalarType)>,
    little_endian: bool,
}

/// Returns `true` if the element's records are rows of one size in a binary file.
pub(super) fn are_rows(header: &PlyHeader, element: &Element) -> bool {
    header.encoding != Encoding::Ascii && element.properties.iter().all(|property| property.kind.scalar().is_some())
}

impl VertexRows {
    /// Returns the rows of an element for which [`are_rows`] holds, from a source that stands behind the header and
    /// whose claims are checked.
    pub(super) fn find(mut source: InputFile, header: &PlyHeader, at: usize, layout: RowLayout) -> Result<Self, Error> {
        let little_endian = header.encoding == Encoding::BinaryLittleEndian;
        let binary = payload::Binary { little_endian };
        for element in &header.elements[..at] {
            binary.skip(&mut source, element)?;
        }
        let start = source.reader.stream_position().map_err(|e| source.read_error(e))?;
        let element = &header.elements[at];
        let mut row_len = 0;
        let mut values = Vec::new();
        for property in &element.properties {
            if let PlyType::Scalar(scalar) = &property.kind {
                values.push((row_len, scalar.clone()));
                row_len += size(scalar) as usize;
            }
        }
        let (row_len, count) = (row_len as u64, element.count);
        let there = (source.len - start) / row_len.max(1);
        if there < count {
            return Err(binary.ends_early(&source, element, there));
        }
        Ok(Self { file: source.into(), layout, count, row_len, start, values, little_endian })
    }

    /// Shows some of the rows, block by block.
    pub(super) fn blocks(&self, rows: Range<u64>, mut see: impl FnMut(&mut RowBlock)) -> Result<(), Error> {
        let bytes = self.file.read(self.start + rows.start * self.row_len, (rows.end - rows.start) * self.row_len)?;
        let row_len = self.row_len as usize;
        let mut block = RowBlock::new(self.values.len());
        for records in bytes.chunks(RowBlock::ROWS * row_len) {
            block.set_len(records.len() / row_len);
            for (at, (offset, scalar)) in self.values.iter().enumerate() {
                column(records, row_len, *offset, scalar, self.little_endian, block.column(at));
            }
            see(&mut block);
        }
        Ok(())
    }

    /// Parses some of the rows. Those whose position is not finite are left out, and their places returned.
    pub fn parse(&self, rows: Range<u64>, progress: &Progress) -> Result<(PointTable, Vec<u64>), Error> {
        let mut table = PointTable::new(&self.layout, (rows.end - rows.start) as usize);
        let left_out = table.fill(RUN, |first, to| {
            let first = rows.start + first as u64;
            let (mut done, mut left_out) = (0, Vec::new());
            self.blocks(first..first + to.len() as u64, |block| {
                let rows = block.len();
                let kept = done - left_out.len();
                left_out.extend(block.keep_finite(&self.layout).into_iter().map(|at| first + (done + at) as u64));
                to.put(&self.layout, kept, block);
                done += rows;
            })?;
            progress.inc(to.len() as u64);
            Ok::<_, Error>(left_out)
        })?;
        Ok((table, left_out))
    }
}
