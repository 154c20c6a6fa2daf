//! KSPLAT, the format of the viewer GaussianSplats3D: sections of splats, packed in one of three modes.
//!
//! Behind a header of 4096 bytes and one of 1024 bytes for each section stand the sections: sizes of their partial
//! buckets, centers of their buckets, then rows. Mode 0 has floats. Modes 1 and 2 have the center as offsets from that
//! of a bucket, and the rest as float16, mode 2 the harmonics as bytes.

use glam::{DQuat, DVec3, Vec3};

use super::{Splat, Splats, all_bytes, check_count};
use crate::number::{float, half, short, word};
use crate::{Error, InputFile, SharedFile};
use pellucid_core::cloud::gaussians::coefficients;
use pellucid_core::cloud::{Cloud, UpAxis};
use pellucid_core::progress::Progress;

const HEADER: usize = 4096;
const SECTION: usize = 1024;

/// The highest degree of harmonics.
const MAX_DEGREE: u16 = 3;

/// The range of harmonics of mode 2 where the header has none.
const RANGE: f64 = 1.5;

/// Settings that hold for all sections.
struct Mode {
    number: u16,
    /// The harmonics that the bytes 0 and 255 of mode 2 mean.
    range: [f64; 2],
}

/// Rows of a section.
struct Section<'a> {
    /// Number of the first splat in the file.
    first: usize,
    degree: u32,
    row: usize,
    rows: &'a [u8],
    /// Offsets of modes 1 and 2: the one that means zero, and the length of a step.
    zero: f64,
    step: f64,
    centers: &'a [u8],
    /// Splats of each full bucket, and how many full buckets there are.
    full: [u64; 2],
    /// Numbers of splats that the section has up to the end of each partial bucket.
    ends: Vec<u64>,
}

pub(super) fn read(source: InputFile, progress: &Progress) -> Result<Cloud, Error> {
    let (file, bytes) = all_bytes(source)?;
    if bytes.len() < HEADER {
        return Err(file.truncated(format!("the file has {} bytes, but the header alone has {HEADER}", bytes.len())));
    }
    let version = [bytes[0], bytes[1]];
    if version[0] != 0 || version[1] == 0 {
        let cause = format!("version {}.{}, expected 0.1 or a later 0.x: not a KSPLAT file?", version[0], version[1]);
        return Err(file.malformed("byte 0", cause));
    }
    let mode = Mode { number: short(&bytes, 20), range: [range(&bytes, 36, -RANGE), range(&bytes, 40, RANGE)] };
    if mode.number > 2 {
        return Err(file.malformed("byte 20", format!("compression mode {}, expected 0, 1 or 2", mode.number)));
    }
    let sections = sections(&file, &bytes, &mode)?;
    let count = sections.iter().map(Section::len).sum::<usize>();
    let announced = word(&bytes, 16);
    if count as u64 != u64::from(announced) {
        let cause = format!("{announced} splats are announced, but the sections have {count}");
        return Err(file.malformed("byte 16", cause));
    }
    let degree = sections.iter().map(|section| section.degree).max().unwrap_or(0);
    check_count(&file, "byte 16", count as u64, degree, None)?;
    let splats = Splats::gather(count, degree, progress, |at, harmonics| {
        let section = &sections[sections.partition_point(|section| section.first <= at) - 1];
        section.splat(at - section.first, &mode, harmonics)
    });
    Ok(splats.finish(UpAxis::NegativeY))
}

/// A float of the header; zero stands for another value.
fn range(bytes: &[u8], at: usize, other: f64) -> f64 {
    let stored = float(bytes, at);
    if stored == 0.0 { other } else { stored }
}

/// The sections that have splats, all of whose bytes are there.
fn sections<'a>(file: &SharedFile, bytes: &'a [u8], mode: &Mode) -> Result<Vec<Section<'a>>, Error> {
    let sections = word(bytes, 4);
    let room = (bytes.len() - HEADER) / SECTION;
    if sections as usize > room {
        let cause =
            format!("the header announces {sections} sections, but the file has room for only {room} section headers");
        return Err(file.truncated(cause));
    }
    let mut found = Vec::new();
    let (mut first, mut at) = (0, (HEADER + sections as usize * SECTION) as u64);
    for number in 0..sections as usize {
        let header = &bytes[HEADER + number * SECTION..][..SECTION];
        let (section, end) = Section::find(header, bytes, at, first, mode).map_err(|cause| match cause {
            Fault::Short(cause) => file.truncated(format!("section {number}: {cause}")),
            Fault::Wrong(cause) => file.malformed(format!("section {number}"), cause),
        })?;
        at = end;
        first += section.len();
        if section.len() > 0 {
            found.push(section);
        }
    }
    Ok(found)
}

/// Fault of a section.
enum Fault {
    Short(String),
    Wrong(String),
}

impl<'a> Section<'a> {
    /// A section by its header, and the byte behind it.
    fn find(header: &[u8], bytes: &'a [u8], at: u64, first: usize, mode: &Mode) -> Result<(Self, u64), Fault> {
        let field = |at: usize| u64::from(word(header, at));
        let (count, room, capacity, buckets) = (field(0), field(4), field(8), field(12));
        let (bucket, full, partial) = (u64::from(short(header, 20)), field(32), field(36));
        let degree = short(header, 40);
        if degree > MAX_DEGREE {
            return Err(Fault::Wrong(format!("its harmonics have degree {degree}, expected at most 3")));
        }
        if count > room {
            return Err(Fault::Wrong(format!("it has {count} splats, but room for only {room}")));
        }
        let row = row_len(mode.number, degree.into());
        // Products of two 32-bit numbers; that of the rows is compared with the length before it is a place.
        let (sizes, centers, rows) = (partial * 4, buckets * bucket, u128::from(room) * row as u128);
        let end = u128::from(at) + u128::from(sizes) + u128::from(centers) + rows;
        if end > bytes.len() as u128 {
            return Err(Fault::Short(format!(
                "{room} rows of {row} bytes end at byte {end}, but the file has {} bytes",
                bytes.len()
            )));
        }
        let part = |from: u64, len: u64| &bytes[from as usize..(from + len) as usize];
        let mut ends = Vec::new();
        let mut so_far = full * capacity;
        for size in part(at, sizes).chunks_exact(4) {
            so_far = so_far.saturating_add(word(size, 0).into());
            ends.push(so_far);
        }
        if mode.number > 0 && (so_far < count || full + partial > buckets || bucket < 12) {
            let cause = format!(
                "{buckets} buckets of {bucket} bytes, {full} of them full with {capacity} splats and {partial} partial, hold {so_far} \
                 splats of {count}"
            );
            return Err(Fault::Wrong(cause));
        }
        let range = if field(24) == 0 { 32767.0 } else { field(24) as f64 };
        let section = Self {
            first,
            degree: degree.into(),
            row,
            rows: part(at + sizes + centers, count * row as u64),
            zero: range,
            step: float(header, 16) / 2.0 / range,
            centers: part(at + sizes, centers),
            full: [capacity, full],
            ends,
        };
        Ok((section, end as u64))
    }

    /// Number of its splats.
    fn len(&self) -> usize {
        self.rows.len() / self.row
    }

    /// The splat of a row.
    fn splat(&self, at: usize, mode: &Mode, harmonics: &mut [Vec3]) -> Splat {
        let row = &self.rows[at * self.row..][..self.row];
        let plain = mode.number == 0;
        let (number, size) = if plain { (float as fn(&[u8], usize) -> f64, 4) } else { (half as _, 2) };
        let at_place = |place: usize| number(row, place * size);
        let [sx, sy, sz, w, x, y, z] = std::array::from_fn(|at| at_place(3 + at));
        let color = 10 * size;
        let [red, green, blue, alpha] = std::array::from_fn(|at| f64::from(row[color + at]) / 255.0);
        let stored = |at: usize| match mode.number {
            0 => float(row, 44 + at * 4),
            1 => half(row, 24 + at * 2),
            _ => mode.range[0] + f64::from(row[24 + at]) / 255.0 * (mode.range[1] - mode.range[0]),
        };
        for (at, color) in harmonics.iter_mut().enumerate().take(coefficients(self.degree)) {
            *color = Vec3::from(places(at).map(|place| stored(place) as f32));
        }
        Splat {
            center: if plain { DVec3::new(at_place(0), at_place(1), at_place(2)) } else { self.center(row, at as u64) },
            extents: DVec3::new(sx, sy, sz),
            rotation: DQuat::from_xyzw(x, y, z, w),
            base: DVec3::new(red, green, blue),
            linear: false,
            alpha,
        }
    }

    /// The center of a packed row, as float32, which is all that it was.
    fn center(&self, row: &[u8], at: u64) -> DVec3 {
        let [capacity, full] = self.full;
        let bucket = match at.checked_div(capacity) {
            Some(bucket) if bucket < full => bucket as usize,
            _ => full as usize + self.ends.partition_point(|end| *end <= at),
        };
        let center = |axis: usize| {
            (f64::from(short(row, axis * 2)) - self.zero) * self.step + float(self.centers, (bucket * 3 + axis) * 4)
        };
        DVec3::new(center(0), center(1), center(2)).as_vec3().as_dvec3()
    }
}

/// Bytes of a row.
fn row_len(mode: u16, degree: u32) -> usize {
    let harmonics = 3 * coefficients(degree);
    match mode {
        0 => 44 + 4 * harmonics,
        1 => 24 + 2 * harmonics,
        _ => 24 + harmonics,
    }
}

/// The places of red, green and blue of a coefficient: degree after degree, and in each of them channel after channel.
fn places(at: usize) -> [usize; 3] {
    let (first, count) = match at {
        0..3 => (0, 3),
        3..8 => (3, 5),
        _ => (8, 7),
    };
    [0, 1, 2].map(|channel| 3 * first + channel * count + at - first)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn harmonics_stand_degree_after_degree() {
        assert_eq!(
            [0, 2, 3, 7, 8, 14].map(places),
            [[0, 3, 6], [2, 5, 8], [9, 14, 19], [13, 18, 23], [24, 31, 38], [30, 37, 44]]
        );
        assert_eq!([row_len(0, 0), row_len(1, 0), row_len(2, 2), row_len(0, 3)], [44, 24, 48, 224]);
    }
}
