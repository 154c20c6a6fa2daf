//! E57 files (ASTM E2807): all scans of a file as one cloud, in its common coordinates.
//!
//! A scan's pose is applied to points and normals. Spherical coordinates become Cartesian ones where a point has no
//! valid Cartesian ones; a point that is marked as invalid, or as a mere direction, is left out and counted. Colors
//! and intensities are scaled from their limits to [0, 1] where these hold (`limits`), colors sRGB-encoded. The
//! normals of the extension of that name are normals; `rowIndex` and `columnIndex` are left out; every other number
//! that all scans have is a column by its own name, as in `ply`. Where a scan lacks colors, normals or intensities
//! that others have, its points are white, have no normal, or the intensity 0. Pictures are not read.

mod limits;
mod scan;

use std::io::{Read, Seek};
use std::sync::Arc;

use ::e57::{E57Reader, PointCloud};
use pellucid_core::progress::Progress;

use super::columns::Columns;
use super::crs;
use super::grid::the_only;
use super::number::long;
use super::{Error, InputFile, PROGRESS_STEP, decoder};
use pellucid_core::cloud::{Cloud, UpAxis};
use scan::{Scan, ScanColumns};

/// The first bytes of a file.
pub(super) const MAGIC: &[u8] = b"ASTM-E57";

/// Bytes of a file's header.
const HEADER: usize = 48;

/// Values that the library may make of fields without bits for one packet: 16 bytes each.
const MAX_CONSTANTS: u64 = 8 << 20;

/// Fields of a point at most.
const MAX_FIELDS: usize = 1024;

/// Bytes of a packet that one field has at most.
const MAX_PACKET: u64 = 1 << 16;

/// Reads the points of an E57 file.
pub(super) fn read(source: &mut InputFile, progress: &Progress) -> Result<Cloud, Error> {
    check_header(source)?;
    let len = source.len;
    // The library's behavior on damaged files is unknown; a panic counts as a fault of the file.
    let cloud = decoder::guard(|| points(&mut source.reader, len, progress));
    match cloud {
        Ok(Ok(cloud)) => Ok(cloud),
        Ok(Err(Problem { place, cause })) => Err(source.malformed(place, cause)),
        Err(panic) => Err(source.malformed("E57 data", panic)),
    }
}

/// A defect, and its position in the file.
struct Problem {
    place: String,
    cause: String,
}

impl Problem {
    fn new(place: impl Into<String>, cause: impl Into<String>) -> Self {
        Self { place: place.into(), cause: cause.into() }
    }

    fn library(place: impl Into<String>, error: &::e57::Error) -> Self {
        let text = error.to_string();
        // The library takes what it can't read for missing.
        if let Some((_, page)) = text.split_once("invalid checksum").and_then(|(_, rest)| rest.rsplit_once("for page "))
        {
            return Self::new(place, format!("the file is damaged: page {page} (of 1024 bytes) has a wrong checksum"));
        }
        let cause = ["Failed to read E57: ", "Invalid E57 content: "].iter().find_map(|known| text.strip_prefix(known));
        Self::new(place, cause.unwrap_or(&text))
    }
}

/// Compares what the header claims with the file's size, before the library takes memory for it.
fn check_header(source: &mut InputFile) -> Result<(), Error> {
    let mut header = [0; HEADER];
    let read = source.reader.read_exact(&mut header).and_then(|()| source.reader.rewind());
    if read.is_err() {
        return Err(source.truncated(format!("the file ends within the E57 header, at byte {}", source.len)));
    }
    let [length, start, bytes] = [16, 24, 32].map(|at| long(&header, at));
    let len = source.len;
    if length > len {
        return Err(source.truncated(format!("the header announces {length} bytes, but the file has {len}")));
    }
    if start.checked_add(bytes).is_none_or(|end| end > len) {
        let what = format!("the header announces {bytes} bytes of XML at byte {start}, but the file has {len} bytes");
        return Err(source.truncated(what));
    }
    Ok(())
}

fn points(file: impl Read + Seek, len: u64, progress: &Progress) -> Result<Cloud, Problem> {
    let mut reader = E57Reader::new(file).map_err(|e| Problem::library("E57 header", &e))?;
    let crs = reader.coordinate_metadata().and_then(crs::parse);
    let mut clouds: Vec<_> = (1..).zip(reader.pointclouds()).collect();
    clouds.retain(|(_, cloud)| cloud.records > 0);
    if clouds.is_empty() {
        return Ok(Cloud::default());
    }
    let (numbers, clouds): (Vec<usize>, Vec<PointCloud>) = clouds.into_iter().unzip();
    check_claim(&numbers, &clouds, len)?;
    let table = ScanColumns::for_scans(&clouds);
    progress.set_length(clouds.iter().map(|cloud| cloud.records).sum());
    let mut columns = Columns::new(&table.columns)
        .map_err(|missing| Problem::new("E57 data", format!("no coordinate `{missing}`")))?;
    let (mut row, mut limits, mut sensors) = (Vec::new(), Vec::new(), Vec::new());
    for (number, cloud) in numbers.iter().zip(&clouds) {
        let name = cloud.name.as_ref().map_or(String::new(), |name| format!(" ({name:?})"));
        let place = |index: u64| format!("scan {number}{name}, point {index} of {}", cloud.records);
        let scan = Scan::new(cloud, &table).map_err(|cause| Problem::new(format!("scan {number}{name}"), cause))?;
        let first = columns.stored().len();
        let values = reader.pointcloud_raw(cloud).map_err(|e| Problem::library(place(0), &e))?;
        for (index, values) in (0u64..).zip(values) {
            let values = values.map_err(|e| Problem::library(place(index), &e))?;
            scan.row(&values, &mut row).map_err(|e| Problem::library(place(index), &e))?;
            columns.push(&row);
            if (index + 1).is_multiple_of(PROGRESS_STEP) {
                progress.inc(PROGRESS_STEP);
            }
        }
        limits.push(scan.limits(first..columns.stored().len()));
        sensors.push(scan.sensor());
    }
    let stored = columns.stored();
    stored.colors.iter_mut().for_each(|colors| limits::scale_colors(colors, &limits));
    stored.intensity.iter_mut().for_each(|values| limits::scale_intensities(values, &limits));
    let mut cloud = columns.finish();
    (cloud.up, cloud.up_is_convention) = (UpAxis::Z, true);
    (cloud.sensor, cloud.crs) = (the_only(&sensors), crs.map(Arc::new));
    let left_out = |name| format!("`{name}` is left out: not every scan has it");
    cloud.warnings.extend(table.left_out.iter().map(left_out));
    Ok(cloud)
}

/// Compares the claimed numbers of points with the bits that the file has for them, all scans together.
fn check_claim(numbers: &[usize], clouds: &[PointCloud], len: u64) -> Result<(), Problem> {
    let mut needed: u128 = 0;
    for (number, cloud) in numbers.iter().zip(clouds) {
        let bits: Vec<u64> = cloud.prototype.iter().map(|record| scan::bits(&record.data_type)).collect();
        let sum: u64 = bits.iter().sum();
        let records = cloud.records;
        let wrong = |cause: String| Err(Problem::new(format!("scan {number}"), cause));
        let Some(least) = bits.iter().copied().filter(|&bits| bits > 0).min() else {
            return wrong(format!(
                "every field of its {records} points is a constant, so the file could announce any number of points"
            ));
        };
        let constants = bits.iter().filter(|&&bits| bits == 0).count() as u64;
        if cloud.prototype.len() > MAX_FIELDS {
            return wrong(format!("a point has {} fields (at most {MAX_FIELDS})", cloud.prototype.len()));
        }
        if constants * (len.min(MAX_PACKET) * 8 / least) > MAX_CONSTANTS {
            return wrong(format!("{constants} of its fields are constants, so this is not a scan"));
        }
        needed += u128::from(sum) * u128::from(records);
        if needed > u128::from(len) * 8 {
            return wrong(format!("{records} points of {sum} bits each announced, but the file has only {len} bytes"));
        }
    }
    Ok(())
}
