//! From LAS point records to the columns of a cloud.

use glam::{DVec3, Vec3};
use las::PointDataBuilder;
use rayon::prelude::*;

use super::header::Header;
use crate::cloud::{Cloud, GPS_TIME, NUMBER_OF_RETURNS, POINT_SOURCE, RETURN_NUMBER, UpAxis};
use crate::color::decode_srgb;
use crate::io::LasColumns;

/// Columns of a part of the file, before what only the whole file can tell (the range of the colors) is known.
pub(super) struct Columns {
    positions: Vec<DVec3>,
    rgb: Option<Vec<[u16; 3]>>,
    intensity: Vec<f32>,
    classification: Vec<u8>,
    return_number: Vec<u8>,
    number_of_returns: Vec<u8>,
    /// If it is asked for.
    source: Option<Vec<u16>>,
    /// If it is asked for and there, in seconds.
    gps_time: Option<Vec<f64>>,
    extra: Vec<Vec<f32>>,
    non_finite: usize,
}

impl Columns {
    /// Empty columns.
    pub fn new(header: &Header, asked: LasColumns) -> Self {
        Self {
            positions: Vec::new(),
            rgb: header.format.has_color.then(Vec::new),
            intensity: Vec::new(),
            classification: Vec::new(),
            return_number: Vec::new(),
            number_of_returns: Vec::new(),
            source: asked.source.then(Vec::new),
            gps_time: (asked.gps_time && header.format.has_gps_time).then(Vec::new),
            extra: header.extra.iter().map(|_| Vec::new()).collect(),
            non_finite: 0,
        }
    }

    /// Adds whole point records.
    pub fn push(&mut self, header: &Header, records: &[u8]) -> Result<(), String> {
        let data = PointDataBuilder::new()
            .with_format(header.format)
            .with_transforms(header.transforms)
            .build_from_bytes(records.to_vec())
            .map_err(|e| e.to_string())?;
        let positions: Vec<DVec3> =
            data.x().zip(data.y()).zip(data.z()).map(|((x, y), z)| DVec3::new(x, y, z)).collect();
        let keep: Vec<bool> = positions.iter().map(|p| p.is_finite()).collect();
        self.non_finite += keep.iter().filter(|&&keep| !keep).count();
        extend(&mut self.positions, positions.into_iter(), &keep);
        extend(&mut self.intensity, data.intensity().map(f32::from), &keep);
        extend(&mut self.classification, data.classification(), &keep);
        extend(&mut self.return_number, data.return_number(), &keep);
        extend(&mut self.number_of_returns, data.number_of_returns(), &keep);
        if let Some(source) = &mut self.source {
            extend(source, data.point_source_id(), &keep);
        }
        if let (Some(times), Some(new)) = (&mut self.gps_time, data.gps_time()) {
            extend(times, new, &keep);
        }
        if let (Some(rgb), Some(new)) = (&mut self.rgb, data.rgb()) {
            extend(rgb, new.map(|(r, g, b)| [r, g, b]), &keep);
        }
        let extra_start = header.record_len - usize::from(header.format.extra_bytes);
        for (dimension, values) in header.extra.iter().zip(&mut self.extra) {
            let new = records.chunks_exact(header.record_len).map(|record| dimension.value(&record[extra_start..]));
            extend(values, new, &keep);
        }
        Ok(())
    }

    /// Adds the part of the file that follows.
    pub fn append(&mut self, mut next: Self) {
        self.positions.append(&mut next.positions);
        self.intensity.append(&mut next.intensity);
        self.classification.append(&mut next.classification);
        self.return_number.append(&mut next.return_number);
        self.number_of_returns.append(&mut next.number_of_returns);
        if let (Some(source), Some(next)) = (&mut self.source, &mut next.source) {
            source.append(next);
        }
        if let (Some(times), Some(next)) = (&mut self.gps_time, &mut next.gps_time) {
            times.append(next);
        }
        if let (Some(rgb), Some(next)) = (&mut self.rgb, &mut next.rgb) {
            rgb.append(next);
        }
        for (values, next) in self.extra.iter_mut().zip(&mut next.extra) {
            values.append(next);
        }
        self.non_finite += next.non_finite;
    }

    /// The cloud of all parts. Returns are kept if some pulse has more than one, or if they are asked for.
    pub fn finish(self, header: &Header, asked: LasColumns) -> Cloud {
        let mut scalars = Vec::new();
        if asked.returns || self.number_of_returns.iter().any(|&count| count > 1) {
            let column = |bytes: &[u8]| bytes.iter().map(|&byte| byte.into()).collect();
            scalars.push((RETURN_NUMBER.to_owned(), column(&self.return_number)));
            scalars.push((NUMBER_OF_RETURNS.to_owned(), column(&self.number_of_returns)));
        }
        if let Some(source) = &self.source {
            scalars.push((POINT_SOURCE.to_owned(), source.iter().map(|&id| id.into()).collect()));
        }
        if let Some(times) = &self.gps_time {
            scalars.push((GPS_TIME.to_owned(), since_first(times)));
        }
        scalars.extend(header.extra.iter().map(|dimension| dimension.name.clone()).zip(self.extra));
        Cloud {
            positions: self.positions,
            colors: self.rgb.and_then(|rgb| linear(&rgb)),
            intensity: Some(self.intensity),
            classification: Some(self.classification),
            scalars,
            non_finite: self.non_finite,
            up: UpAxis::Z,
            ..Cloud::default()
        }
    }
}

/// Times in seconds since the smallest finite one; others stay as they are.
fn since_first(times: &[f64]) -> Vec<f32> {
    let first = times.iter().copied().filter(|time| time.is_finite()).fold(f64::INFINITY, f64::min);
    times.iter().map(|time| if time.is_finite() { (time - first) as f32 } else { *time as f32 }).collect()
}

fn extend<T>(column: &mut Vec<T>, new: impl Iterator<Item = T>, keep: &[bool]) {
    column.extend(new.zip(keep).filter(|(_, keep)| **keep).map(|(value, _)| value));
}

/// Converts stored colors to linear ones. Many writers put 8-bit values into the 16-bit fields: if no value of the file
/// exceeds 255, they count as 8-bit. Colors that are all zero are dropped.
fn linear(rgb: &[[u16; 3]]) -> Option<Vec<Vec3>> {
    let largest = rgb.par_iter().map(|&[r, g, b]| r.max(g).max(b)).max().filter(|&largest| largest > 0)?;
    let range = if largest <= 255 { 255 } else { u16::MAX };
    let table: Vec<f32> = (0..=largest).map(|stored| decode_srgb(f32::from(stored) / f32::from(range))).collect();
    Some(rgb.par_iter().map(|color| Vec3::from(color.map(|stored| table[usize::from(stored)]))).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_count_from_the_first() {
        // Adjusted standard time: a float32 there is 16 seconds apart from the next one.
        let times = since_first(&[311_862_004.25, 311_862_000.0, f64::NAN, 311_862_000.125]);
        assert_eq!([times[0], times[1], times[3]], [4.25, 0.0, 0.125]);
        assert!(times[2].is_nan());
    }

    #[test]
    fn eight_bits_in_sixteen_are_seen_over_the_whole_file() {
        assert_eq!(linear(&[[0; 3], [0; 3]]), None);
        let eight = linear(&[[255, 0, 51], [0, 0, 0]]).unwrap();
        assert_eq!(eight, [Vec3::new(1.0, 0.0, decode_srgb(0.2)), Vec3::ZERO]);
        let sixteen = linear(&[[255, 0, 0], [65535, 0, 256]]).unwrap();
        assert_eq!(sixteen[0].x, decode_srgb(255.0 / 65535.0));
        assert_eq!(sixteen[1], Vec3::new(1.0, 0.0, decode_srgb(256.0 / 65535.0)));
    }
}
