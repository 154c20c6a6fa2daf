//! The header and the variable-length records of a LAS file, checked against the file's size.

use std::io::{Read, Seek, SeekFrom};
use std::sync::Arc;

use glam::DVec3;
use las::point::Format;
use las::raw;
use las::{Transform, Vector};
use laz::LazVlr;

use super::evlrs::{self, LargeFields};
use super::extra::{self, Dimension};
use super::projection;
use crate::{Error, InputFile, decoder};
use pellucid_core::cloud::Bounds;
use pellucid_core::cloud::crs::Crs;

/// The last known version is 1.5.
const LAST_MINOR: u8 = 5;

/// Bytes of a variable-length record before its data.
const VLR_HEADER: u64 = 54;

/// Upper bound on the points in one compressed byte. The probabilities of the arithmetic coder's models are limited to
/// 1 : 2¹⁵, so even equal points take about 0.01 bits each: 830 points per byte were measured. A larger claim is false.
pub(crate) const MAX_POINTS_PER_BYTE: u64 = 4096;

/// The storage and the number of the points.
#[derive(Debug)]
pub(crate) struct LasHeader {
    pub count: u64,
    pub record_len: usize,
    pub format: Format,
    pub transforms: Vector<Transform>,
    /// Byte at which the points start.
    pub start: u64,
    /// Tells that a record is withheld: some bits of a byte; `None` in LAS 1.0, whose classes take the whole byte.
    withheld: Option<(usize, u8)>,
    /// The compression of the points, if any.
    pub laz: Option<LazVlr>,
    /// The extra dimensions of a record.
    pub(super) extra: Vec<Dimension>,
    /// The box of the points, as the header has it: perhaps not finite, empty, or another one's.
    pub bounds: Bounds,
    /// The record that makes a COPC file of it.
    pub copc: Option<Vec<u8>>,
    /// The coordinate reference system that records describe.
    pub crs: Option<Arc<Crs>>,
    /// Oddities of the header that did not prevent reading it.
    pub warnings: Vec<String>,
}

impl LasHeader {
    /// Returns the header's box with a step of the coordinates' grid around it, since many writers round it; `None` if
    /// it can be no box.
    pub fn claimed_bounds(&self) -> Option<Bounds> {
        let Bounds { min, max } = self.widened(self.bounds);
        (min.is_finite() && max.is_finite() && self.bounds.min.cmple(self.bounds.max).all())
            .then_some(Bounds { min, max })
    }

    /// Returns a box with a step of the coordinates' grid around it.
    pub fn widened(&self, bounds: Bounds) -> Bounds {
        let step = DVec3::new(self.transforms.x.scale, self.transforms.y.scale, self.transforms.z.scale).abs();
        Bounds { min: bounds.min - step, max: bounds.max + step }
    }

    /// Returns `true` if a record is marked as withheld, which the standard calls "synonymous with deleted".
    pub fn is_withheld(&self, record: &[u8]) -> bool {
        self.withheld.is_some_and(|(byte, bits)| record.get(byte).is_some_and(|flags| flags & bits != 0))
    }

    /// Returns `true` if every coordinate that the points can store is finite.
    pub fn is_finite(&self) -> bool {
        let Vector { x, y, z } = self.transforms;
        let ends = |t: Transform| [i32::MIN, i32::MAX].map(|stored| f64::from(stored) * t.scale + t.offset);
        [x, y, z].into_iter().flat_map(ends).all(f64::is_finite)
    }
}

/// Reads and checks the header.
pub(super) fn read(source: &mut InputFile) -> Result<LasHeader, Error> {
    let raw = match decoder::guard(|| raw::Header::read_from(&mut source.reader)) {
        Ok(Ok(raw)) => raw,
        Ok(Err(las::Error::Io(e))) if e.kind() == std::io::ErrorKind::UnexpectedEof => {
            return Err(source.truncated(format!("the file ends within the LAS header, at byte {}", source.len)));
        }
        Ok(Err(las::Error::Io(e))) => return Err(source.read_error(e)),
        Ok(Err(e)) => return Err(source.malformed("LAS header", e.to_string())),
        Err(panic) => return Err(source.malformed("LAS header", panic)),
    };
    if raw.version.major != 1 || raw.version.minor > LAST_MINOR {
        return Err(source.malformed("LAS header", format!("version {} (known: 1.0 to 1.{LAST_MINOR})", raw.version)));
    }
    let large = LargeFields::read(source, raw.version.minor)?;
    let mut warnings = Vec::new();
    let count = count(raw.number_of_point_records, large.points, &mut warnings);
    let start = u64::from(raw.offset_to_point_data);
    if start > source.len {
        let len = source.len;
        return Err(source.truncated(format!("the points should start at byte {start}, but the file has {len} bytes")));
    }
    let format = format(source, &raw)?;
    let vlrs = vlrs(source, &raw)?;
    let is_wanted = |user: &[u8], id: u16| extra::is_record(user, id) || projection::is_record(user, id);
    let extended = evlrs::read(source, &large, is_wanted)?;
    let of_header = vlrs.iter().map(|vlr| (user_id(vlr), vlr.record_id, vlr.data.as_slice()));
    let records = || of_header.clone().chain(extended.iter().map(|record| (&*record.user, record.id, &*record.data)));
    let descriptors = records().filter(|(user, id, _)| extra::is_record(user, *id)).flat_map(|(.., data)| data);
    let descriptors: Vec<u8> = descriptors.copied().collect();
    let laz = if format.is_compressed { Some(laz_vlr(source, &vlrs)?) } else { None };
    let header = LasHeader {
        count,
        record_len: raw.point_data_record_length.into(),
        extra: extra::dimensions(&descriptors, format.extra_bytes),
        withheld: (raw.version.minor > 0).then_some(if format.is_extended { (15, 1 << 2) } else { (15, 1 << 7) }),
        format,
        transforms: transforms(&raw),
        start,
        laz,
        bounds: Bounds {
            min: DVec3::new(raw.min_x, raw.min_y, raw.min_z),
            max: DVec3::new(raw.max_x, raw.max_y, raw.max_z),
        },
        crs: projection::crs(records(), raw.global_encoding).map(Arc::new),
        copc: vlrs.iter().find(is_copc).map(|vlr| vlr.data.clone()),
        warnings,
    };
    check_claim(source, &header)?;
    Ok(header)
}

/// Returns the number of points. From LAS 1.4 on that is the 64-bit count, unless a writer left it empty; the 32-bit
/// count is for older readers, and 0 where they could not read the points.
fn count(legacy: u32, large: u64, warnings: &mut Vec<String>) -> u64 {
    if large == 0 {
        return legacy.into();
    }
    if legacy != 0 && u64::from(legacy) != large {
        warnings.push(format!("its 32-bit count says {legacy} points, its 64-bit count {large}, which is used"));
    }
    large
}

fn format(source: &InputFile, raw: &raw::Header) -> Result<Format, Error> {
    let number = raw.point_data_record_format;
    // The two upper bits say "compressed".
    let known = Format::new(number).ok().filter(|_| number & 0x3f <= 10);
    let Some(mut format) = known else {
        return Err(source.malformed("LAS header", format!("point format {number} (known: 0 to 10)")));
    };
    let len = raw.point_data_record_length;
    let Some(extra_bytes) = len.checked_sub(format.len()) else {
        let cause =
            format!("its point records have {len} bytes, but point format {} needs {}", number & 0x3f, format.len());
        return Err(source.malformed("LAS header", cause));
    };
    format.extra_bytes = extra_bytes;
    Ok(format)
}

fn transforms(raw: &raw::Header) -> Vector<Transform> {
    Vector {
        x: Transform { scale: raw.x_scale_factor, offset: raw.x_offset },
        y: Transform { scale: raw.y_scale_factor, offset: raw.y_offset },
        z: Transform { scale: raw.z_scale_factor, offset: raw.z_offset },
    }
}

/// The variable-length records that fit before the points; some writers count one too many.
fn vlrs(source: &mut InputFile, raw: &raw::Header) -> Result<Vec<raw::Vlr>, Error> {
    let end = u64::from(raw.offset_to_point_data);
    let mut position = u64::from(raw.header_size);
    let mut vlrs = Vec::new();
    source.reader.seek(SeekFrom::Start(position)).map_err(|e| source.read_error(e))?;
    for _ in 0..raw.number_of_variable_length_records {
        if position + VLR_HEADER > end {
            break;
        }
        let left = end - position;
        // Its length has 16 bits, so no claim can be large.
        let Ok(vlr) = raw::Vlr::read_from(source.reader.by_ref().take(left), false) else { break };
        position += VLR_HEADER + vlr.data.len() as u64;
        vlrs.push(vlr);
    }
    Ok(vlrs)
}

fn is_copc(vlr: &&raw::Vlr) -> bool {
    user_id(vlr) == b"copc" && vlr.record_id == 1
}

fn laz_vlr(source: &InputFile, vlrs: &[raw::Vlr]) -> Result<LazVlr, Error> {
    let place = "LAZ record of the header";
    let is_laz = |vlr: &&raw::Vlr| user_id(vlr) == LazVlr::USER_ID.as_bytes() && vlr.record_id == LazVlr::RECORD_ID;
    let Some(vlr) = vlrs.iter().find(is_laz) else {
        return Err(source.malformed(place, "it is missing, although the points are marked as compressed"));
    };
    LazVlr::from_buffer(&vlr.data).map_err(|e| source.malformed(place, e.to_string()))
}

/// Returns the user of a record, without the zeros behind it.
fn user_id(vlr: &raw::Vlr) -> &[u8] {
    until_zero(&vlr.user_id)
}

/// Returns the bytes of a text before the zeros behind it.
pub(super) fn until_zero(text: &[u8]) -> &[u8] {
    text.split(|&byte| byte == 0).next().unwrap_or_default()
}

/// Compares the claimed number of points with the available bytes.
fn check_claim(source: &InputFile, header: &LasHeader) -> Result<(), Error> {
    let left = source.len - header.start;
    let (possible, each) = match header.laz {
        Some(_) => (left.saturating_mul(MAX_POINTS_PER_BYTE), "compressed".to_owned()),
        None => (left / header.record_len.max(1) as u64, format!("of {} bytes each", header.record_len)),
    };
    if header.count > possible {
        return Err(source.truncated(format!(
            "the header announces {} points {each}, but the {left} bytes after byte {} hold at most {possible}",
            header.count, header.start
        )));
    }
    Ok(())
}
