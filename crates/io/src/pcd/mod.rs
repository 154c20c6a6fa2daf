//! PCD files (Point Cloud Library): text, binary and compressed, organized or not.
//!
//! Fields have the names of PLY's properties. `rgb` and `rgba` of four bytes are packed colors whatever their type,
//! since the float only carries the bits. Colors of other types than bytes share a common range. A group of `COUNT`
//! numbers becomes as many scalars, `NAME_0` and so on; fields `_` are padding. `VIEWPOINT` moves no point: it tells
//! where the sensor of an organized cloud stood.

mod depth_image;
mod header;
mod lzf;
mod row;

use std::io::{BufRead, ErrorKind, Read};

use glam::{DQuat, DVec3};
use pellucid_core::progress::Progress;

use super::columns::Columns;
use super::grid::Elevations;
use super::number::word;
use super::{Error, InputFile, PROGRESS_STEP};
use depth_image::DepthImage;
use header::{Encoding, Header};
use pellucid_core::cloud::depth_camera::is_depth_camera;
use pellucid_core::cloud::sensor::Sensor;
use pellucid_core::cloud::{Cloud, UpAxis};
use row::PcdLayout;

/// Numbers of a point at most: each becomes a column. The largest features have about 2000.
const MAX_NUMBERS: u64 = 1 << 16;

/// Returns `true` if the bytes start a PCD file.
pub(super) fn is_pcd(start: &[u8]) -> bool {
    [&b"# .PCD"[..], b"VERSION ", b"FIELDS "].iter().any(|magic| start.starts_with(magic))
}

/// Reads the points of a PCD file.
pub(super) fn read(source: &mut InputFile, progress: &Progress) -> Result<Cloud, Error> {
    let header = header::read(source)?;
    check_claim(source, &header)?;
    let layout = PcdLayout::for_header(&header);
    let mut columns = Columns::new(&layout.columns).map_err(|missing| {
        let names: Vec<_> = header.fields.iter().map(|field| field.name.as_str()).collect();
        source.malformed("header", format!("no field `{missing}`, only [{}]", names.join(", ")))
    })?;
    progress.set_length(header.points);
    let place =
        ["x", "y", "z"].map(|name| layout.columns.iter().position(|column| column.name.eq_ignore_ascii_case(name)));
    let (mut image, mut seen) = (header.columns.map(DepthImage::new), Seen::new(&header));
    let mut taken = 0u64;
    let take = |row: &[f64]| {
        columns.push(row);
        if let (Some(image), [Some(x), Some(y), Some(z)]) = (&mut image, place) {
            let point = [x, y, z].map(|at| row[at]);
            image.add(point);
            if let Some(seen) = &mut seen {
                seen.add(taken, point.into());
            }
        }
        taken += 1;
        if taken.is_multiple_of(PROGRESS_STEP) {
            progress.inc(PROGRESS_STEP);
        }
    };
    match header.encoding {
        Encoding::Ascii => ascii(source, &header, &layout, take)?,
        Encoding::Binary => binary(source, &header, &layout, take)?,
        Encoding::Compressed => compressed(source, &header, &layout, take)?,
    }
    progress.set_position(header.points);
    let mut cloud = columns.finish();
    let is_image = image.is_some_and(|image| image.is_one()) || is_depth_camera(&cloud.positions);
    cloud.up = if is_image { UpAxis::NegativeY } else { UpAxis::Z };
    cloud.up_is_convention = !is_image;
    cloud.sensor = seen.map(|seen| seen.sensor());
    Ok(cloud)
}

/// The cells of an organized cloud, as its sensor has them.
struct Seen {
    columns: u64,
    place: DVec3,
    rotation: DQuat,
    image: DepthImage,
    /// The cells as if the sensor was not turned.
    unturned: DepthImage,
    elevations: Elevations,
}

impl Seen {
    /// Returns `None` for clouds that are not organized, and without a sensor.
    fn new(header: &Header) -> Option<Self> {
        let (columns, (place, rotation)) = (header.columns?, header.viewpoint?);
        let [image, unturned] = [(); 2].map(|()| DepthImage::new(columns));
        Some(Self { columns, place, rotation, image, unturned, elevations: Elevations::default() })
    }

    /// Adds the point of a cell, finite or not.
    fn add(&mut self, cell: u64, point: DVec3) {
        let unturned = point - self.place;
        self.unturned.add(unturned.into());
        let point = self.rotation.inverse() * unturned;
        self.image.add(point.into());
        self.elevations.add(cell / self.columns.max(1), point);
    }

    /// Returns a depth camera, unless rows lie as those of a laser scanner. Grabbers of PCL write a rotation that their
    /// points don't have.
    fn sensor(&self) -> Sensor {
        if self.image.is_one() {
            Sensor::depth_camera(self.place, self.rotation)
        } else if self.unturned.is_one() {
            Sensor::depth_camera(self.place, DQuat::IDENTITY)
        } else if self.elevations.follow_rows() {
            Sensor::laser(self.place, self.rotation)
        } else {
            Sensor::depth_camera(self.place, self.rotation)
        }
    }
}

/// Compares the claimed number of points with the bytes that follow the header.
fn check_claim(source: &InputFile, header: &Header) -> Result<(), Error> {
    let left = source.len.saturating_sub(header.len);
    let (least, possible) = match header.encoding {
        // A digit and a separator for each number; the last line needs no end.
        Encoding::Ascii => {
            let least = header.numbers().saturating_mul(2);
            (least, (left + 1) / least.max(1))
        }
        Encoding::Binary => (header.record_len(), left / header.record_len().max(1)),
        // Checked when the compressed size is known.
        Encoding::Compressed => (0, left.saturating_mul(lzf::MAX_EXPANSION as u64) / header.record_len().max(1)),
    };
    let empty = header.numbers() == 0 && header.points > 0;
    if header.points > possible || empty {
        let size = if least > 0 { format!(" of at least {least} bytes each") } else { String::new() };
        return Err(source.truncated(format!(
            "the header announces {} points{size}, but the {left} bytes after it hold at most {possible}",
            header.points
        )));
    }
    if header.numbers() > MAX_NUMBERS {
        let cause = format!("COUNT gives a point {} numbers (at most {MAX_NUMBERS})", header.numbers());
        return Err(source.malformed("header", cause));
    }
    Ok(())
}

fn ascii(
    source: &mut InputFile,
    header: &Header,
    layout: &PcdLayout,
    mut take: impl FnMut(&[f64]),
) -> Result<(), Error> {
    let (mut line, mut row, mut at) = (Vec::new(), Vec::new(), header.lines);
    let mut index = 0;
    while index < header.points {
        line.clear();
        at += 1;
        let read = source.reader.read_until(b'\n', &mut line);
        let announced = format!("after {index} of the {} points that the header announces", header.points);
        if read.map_err(|e| source.read_error(e))? == 0 {
            return Err(source.truncated(format!("the file ends at line {} {announced}", at - 1)));
        }
        let text = String::from_utf8_lossy(&line);
        let mut words =
            text.split(|c: char| c.is_ascii_whitespace() || c == ',').filter(|word| !word.is_empty()).peekable();
        if words.peek().is_none() {
            continue;
        }
        layout.words(words, &mut row).map_err(|cause| {
            if text.ends_with('\n') {
                return source.malformed(format!("line {at}"), cause);
            }
            source.truncated(format!("the file ends in line {at}, {announced} ({cause})"))
        })?;
        take(&row);
        index += 1;
    }
    Ok(())
}

fn binary(
    source: &mut InputFile,
    header: &Header,
    layout: &PcdLayout,
    mut take: impl FnMut(&[f64]),
) -> Result<(), Error> {
    let mut record = vec![0; header.record_len() as usize];
    let mut row = Vec::new();
    for index in 0..header.points {
        source.reader.read_exact(&mut record).map_err(|e| {
            if e.kind() != ErrorKind::UnexpectedEof {
                return source.read_error(e);
            }
            source.truncated(format!("the file ends in point {index} of {}", header.points))
        })?;
        layout.bytes(&record, &mut row);
        take(&row);
    }
    Ok(())
}

/// Compressed points are stored field by field: all x, then all y, and so on.
fn compressed(
    source: &mut InputFile,
    header: &Header,
    layout: &PcdLayout,
    mut take: impl FnMut(&[f64]),
) -> Result<(), Error> {
    let mut sizes = [0; 8];
    let read = source.reader.read_exact(&mut sizes);
    read.map_err(|_| source.truncated("the file ends before the sizes of its compressed data"))?;
    let [packed, unpacked] = [0, 4].map(|at| u64::from(word(&sizes, at)));
    let wanted = header.record_len() * header.points;
    if unpacked != wanted {
        let cause = format!("{unpacked} unpacked bytes are announced, but {} points need {wanted}", header.points);
        return Err(source.malformed("compressed data", cause));
    }
    let left = source.len.saturating_sub(header.len + 8);
    if packed > left {
        return Err(source.truncated(format!("{packed} compressed bytes are announced, but only {left} are left")));
    }
    let mut bytes = Vec::new();
    let read = source.reader.by_ref().take(packed).read_to_end(&mut bytes);
    read.map_err(|e| source.read_error(e))?;
    let planes = lzf::decompress(&bytes, unpacked as usize).map_err(|e| source.malformed("compressed data", e))?;
    let mut parts = Vec::new();
    let mut rest = planes.as_slice();
    for field in &header.fields {
        // The sizes sum to what was decompressed.
        let (part, after) = rest.split_at((field.bytes() * header.points) as usize);
        parts.push(part.chunks_exact(field.bytes().max(1) as usize));
        rest = after;
    }
    let (mut record, mut row) = (Vec::new(), Vec::new());
    for _ in 0..header.points {
        record.clear();
        parts.iter_mut().for_each(|part| record.extend_from_slice(part.next().unwrap_or_default()));
        layout.bytes(&record, &mut row);
        take(&row);
    }
    Ok(())
}
