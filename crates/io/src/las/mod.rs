//! LAS 1.0–1.5 and LAZ files; a COPC file is a LAZ file whose chunks happen to form a tree (`store::copc`).
//!
//! The libraries read headers and decompress; everything a file claims (records, counts, lengths) is compared with its
//! size here first, since they allocate what is claimed. Of extended variable-length records those are read that
//! describe extra bytes or the coordinate reference system.

mod chunks;
mod columns;
mod evlrs;
mod extra;
mod header;
mod projection;
mod times;
mod traits;

use glam::DVec3;
use laz::DecompressionSelection;

use super::store::Grid;
use super::{Error, InputFile, LasColumns, SharedFile, memory};
pub(super) use chunks::Chunk;
pub(super) use columns::Columns;
pub(super) use header::{LasHeader, MAX_POINTS_PER_BYTE};
use pellucid_core::cloud::{Bounds, Cloud};
use pellucid_core::parallel;
use pellucid_core::progress::Progress;
pub(super) use traits::Traits;

/// Reads the points of a LAS or LAZ file.
pub(super) fn read(source: InputFile, asked: LasColumns, progress: &Progress) -> Result<Cloud, Error> {
    let file = LasFile::open(source, asked)?;
    memory::check(file.file.path(), file.header.count, Columns::least_bytes(&file.header))?;
    progress.set_length(file.header.count);
    let parts = parallel::try_map_each(&file.chunks, |chunk| file.decode(chunk, progress))?;
    let Some(columns) = Columns::join(parts) else { return Ok(Cloud::default()) };
    let traits = columns.traits();
    let cloud = file.finish(columns, &traits);
    Ok(Cloud { warnings: file.header.warnings, ..cloud })
}

/// An open LAS or LAZ file, whose chunks are decoded by any number of threads.
#[derive(Debug)]
pub(super) struct LasFile {
    pub file: SharedFile,
    pub header: LasHeader,
    /// The runs of points in the file's order; together they hold as many as the header says.
    pub chunks: Vec<Chunk>,
    pub asked: LasColumns,
}

impl LasFile {
    /// Reads the header and finds the chunks.
    pub fn open(mut source: InputFile, asked: LasColumns) -> Result<Self, Error> {
        let header = header::read(&mut source)?;
        let chunks = match &header.laz {
            _ if header.count == 0 => Vec::new(),
            Some(laz) => chunks::compressed(&mut source, &header, laz)?,
            None => chunks::plain(&source, &header)?,
        };
        Ok(Self { file: source.into(), header, chunks, asked })
    }

    /// Returns the columns of a chunk, as they are stored.
    pub fn decode(&self, chunk: &Chunk, progress: &Progress) -> Result<Columns, Error> {
        let mut selection = self.decisive().decompress_z().decompress_intensity();
        selection = selection.decompress_classification().decompress_extra_bytes();
        if self.asked.source {
            selection = selection.decompress_point_source_id();
        }
        self.decode_selected(chunk, selection, progress)
    }

    /// The fields that decide about whole columns.
    fn decisive(&self) -> DecompressionSelection {
        let selection = DecompressionSelection::base().decompress_rgb().decompress_flags();
        if self.asked.gps_time { selection.decompress_gps_time() } else { selection }
    }

    /// Returns what a chunk's points tell of the whole file, and their box if it is asked for. Only the fields that
    /// this needs are decoded, where the compression stores them apart from the rest (LAS 1.4, point formats 6 to 10).
    pub fn traits(&self, chunk: &Chunk, boxes: bool) -> Result<(Traits, Option<Bounds>), Error> {
        let selection = if boxes { self.decisive().decompress_z() } else { self.decisive() };
        let columns = self.decode_selected(chunk, selection, &Progress::hidden())?;
        Ok((columns.traits(), boxes.then(|| columns.bounds()).flatten()))
    }

    fn decode_selected(
        &self,
        chunk: &Chunk,
        selection: DecompressionSelection,
        progress: &Progress,
    ) -> Result<Columns, Error> {
        let bytes = self.file.read(chunk.start, chunk.bytes)?;
        let mut columns = Columns::new(&self.header, self.asked);
        let decoded = chunk.decode(&self.header, &bytes, selection, |records| {
            columns.push(&self.header, records)?;
            progress.inc((records.len() / self.header.record_len) as u64);
            Ok(())
        });
        decoded.map(|()| columns).map_err(|cause| {
            let (first, last) = (chunk.first_point, chunk.first_point + chunk.points - 1);
            self.file.malformed(format!("points {first}–{last} (chunk at byte {})", chunk.start), cause)
        })
    }

    /// Returns the cloud of some of the points, of which all together have these traits.
    pub fn finish(&self, columns: Columns, traits: &Traits) -> Cloud {
        let crs = self.header.crs.clone();
        Cloud { crs, ..columns.finish(self.extra_names(), self.asked, traits) }
    }

    /// Returns the names of the extra dimensions.
    pub fn extra_names(&self) -> impl Iterator<Item = &str> {
        self.header.extra.iter().map(|dimension| &*dimension.name)
    }

    /// Returns the grid that the positions lie on.
    pub fn grid(&self) -> Grid {
        let transforms = &self.header.transforms;
        let each = |of: fn(&las::Transform) -> f64| DVec3::new(of(&transforms.x), of(&transforms.y), of(&transforms.z));
        Grid { scale: each(|transform| transform.scale), offset: each(|transform| transform.offset) }
    }
}
