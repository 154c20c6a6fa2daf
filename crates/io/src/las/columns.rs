//! Converts LAS point records to the columns of a cloud.

use glam::{DVec3, Vec3};
use las::PointDataBuilder;

use super::header::LasHeader;
use super::traits::Traits;
use crate::LasColumns;
use crate::channel::full_integer;
use crate::columns::{taken, taken_optional};
use pellucid_core::cloud::{Bounds, Cloud, GPS_TIME, NUMBER_OF_RETURNS, POINT_SOURCE, RETURN_NUMBER, UpAxis};
use pellucid_core::color::linear_values;
use pellucid_core::parallel;

/// Columns of a part of the file, as they are stored: before what only the whole file tells ([`Traits`]) is known.
pub(crate) struct Columns {
    pub positions: Vec<DVec3>,
    pub rgb: Option<Vec<[u16; 3]>>,
    pub intensity: Vec<f32>,
    pub classification: Vec<u8>,
    pub return_number: Vec<u8>,
    pub number_of_returns: Vec<u8>,
    /// Point source IDs, if they are asked for.
    pub source: Option<Vec<u16>>,
    /// GPS times in seconds, if they are asked for and there.
    pub gps_time: Option<Vec<f64>>,
    pub extra: Vec<Vec<f32>>,
    pub non_finite: usize,
    /// The places, among all records, of those that are marked as withheld, which are left out.
    pub withheld: Vec<u64>,
    /// Records so far.
    pub records: u64,
}

impl Columns {
    /// Empty columns.
    pub fn new(header: &LasHeader, asked: LasColumns) -> Self {
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
            withheld: Vec::new(),
            records: 0,
        }
    }

    /// Returns the number of bytes of a point in the columns of a cloud, without those that depend on values and
    /// wishes.
    pub(super) fn least_bytes(header: &LasHeader) -> u64 {
        let (intensity, classification) = (size_of::<f32>(), size_of::<u8>());
        (size_of::<DVec3>() + intensity + classification + header.extra.len() * size_of::<f32>()) as u64
    }

    /// Adds whole point records.
    pub fn push(&mut self, header: &LasHeader, records: &[u8]) -> Result<(), String> {
        let data = PointDataBuilder::new()
            .with_format(header.format)
            .with_transforms(header.transforms)
            .build_from_bytes(records.to_vec())
            .map_err(|e| e.to_string())?;
        let positions: Vec<DVec3> =
            data.x().zip(data.y()).zip(data.z()).map(|((x, y), z)| DVec3::new(x, y, z)).collect();
        let withheld = |at: &usize| header.is_withheld(&records[at * header.record_len..]);
        let withheld: Vec<usize> = (0..positions.len()).filter(withheld).collect();
        let mut keep: Vec<bool> = positions.iter().map(|p| p.is_finite()).collect();
        withheld.iter().for_each(|&at| keep[at] = false);
        self.non_finite += keep.iter().filter(|&&keep| !keep).count() - withheld.len();
        self.withheld.extend(withheld.into_iter().map(|at| self.records + at as u64));
        self.records += positions.len() as u64;
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

    /// Returns the columns of the parts of a file, one behind the other; `None` of no parts. Each column of the parts
    /// is gone once it is joined.
    pub fn join(mut parts: Vec<Self>) -> Option<Self> {
        let extra = parts.first()?.extra.len();
        let parts = parts.as_mut_slice();
        let mut records = 0;
        let mut withheld = Vec::new();
        for part in &*parts {
            withheld.extend(part.withheld.iter().map(|at| records + at));
            records += part.records;
        }
        Some(Self {
            positions: taken(parts, |part| &mut part.positions),
            rgb: taken_optional(parts, |part| &mut part.rgb),
            intensity: taken(parts, |part| &mut part.intensity),
            classification: taken(parts, |part| &mut part.classification),
            return_number: taken(parts, |part| &mut part.return_number),
            number_of_returns: taken(parts, |part| &mut part.number_of_returns),
            source: taken_optional(parts, |part| &mut part.source),
            gps_time: taken_optional(parts, |part| &mut part.gps_time),
            extra: (0..extra).map(|at| taken(parts, |part| &mut part.extra[at])).collect(),
            non_finite: parts.iter().map(|part| part.non_finite).sum(),
            withheld,
            records,
        })
    }

    /// Returns the places of the points in a file, whose records follow this place.
    pub fn places(&self, first: u64) -> impl Iterator<Item = u64> {
        let mut withheld = self.withheld.iter().peekable();
        (0..self.records).filter(move |at| withheld.next_if_eq(&at).is_none()).map(move |at| first + at)
    }

    /// Returns the box of the points; `None` if there are none.
    pub fn bounds(&self) -> Option<Bounds> {
        Bounds::of(&self.positions)
    }

    /// Returns what these points tell of the whole file.
    pub fn traits(&self) -> Traits {
        let largest = |rgb: &[[u16; 3]]| rgb.as_flattened().iter().copied().max().unwrap_or(0);
        let times = self.gps_time.iter().flatten().copied().filter(|time| time.is_finite());
        Traits {
            largest_color: self.rgb.as_deref().map_or(0, largest),
            most_returns: self.number_of_returns.iter().copied().max().unwrap_or(0),
            first_time: times.fold(f64::INFINITY, f64::min),
        }
    }

    /// Returns the cloud of the points of a file with these traits and these names of extra dimensions. Returns are
    /// kept if some pulse has more than one, or if they are asked for.
    pub fn finish<'a>(self, extra: impl Iterator<Item = &'a str>, asked: LasColumns, traits: &Traits) -> Cloud {
        let mut scalars = Vec::new();
        if asked.returns || traits.most_returns > 1 {
            let column = |bytes: &[u8]| parallel::map_each(bytes, |&byte| f32::from(byte));
            scalars.push((RETURN_NUMBER.to_owned(), column(&self.return_number)));
            scalars.push((NUMBER_OF_RETURNS.to_owned(), column(&self.number_of_returns)));
        }
        if let Some(source) = &self.source {
            scalars.push((POINT_SOURCE.to_owned(), source.iter().map(|&id| id.into()).collect()));
        }
        if let Some(times) = &self.gps_time {
            scalars.push((GPS_TIME.to_owned(), since(traits.first_time, times)));
        }
        scalars.extend(extra.map(str::to_owned).zip(self.extra));
        Cloud {
            positions: self.positions,
            colors: self.rgb.and_then(|rgb| linear(&rgb, traits.largest_color)),
            intensity: Some(self.intensity),
            classification: Some(self.classification),
            scalars,
            non_finite: self.non_finite,
            withheld: self.withheld.len(),
            up: UpAxis::Z,
            up_is_convention: true,
            ..Cloud::default()
        }
    }
}

/// Times in seconds since the first; those that are not finite stay as they are.
fn since(first: f64, times: &[f64]) -> Vec<f32> {
    times.iter().map(|time| if time.is_finite() { (time - first) as f32 } else { *time as f32 }).collect()
}

fn extend<T>(column: &mut Vec<T>, new: impl Iterator<Item = T>, keep: &[bool]) {
    column.extend(new.zip(keep).filter(|(_, keep)| **keep).map(|(value, _)| value));
}

/// Converts stored colors to linear ones. Many writers put values of 8, 10 or 12 bits into the 16-bit fields, so the
/// largest of the file says how many they have; larger ones, which a store's description may have missed, count as
/// that. Colors that are all zero are dropped.
fn linear(rgb: &[[u16; 3]], largest: u16) -> Option<Vec<Vec3>> {
    if largest == 0 {
        return None;
    }
    let full = full_integer(largest.into());
    let table = linear_values(full);
    let value = |stored: u16| table[usize::from(stored.min(full))];
    Some(parallel::map(rgb.len(), |i| Vec3::from(rgb[i].map(value))))
}

#[cfg(test)]
mod tests {
    use super::*;
    use pellucid_core::color::decode_srgb;

    #[test]
    fn times_count_from_the_first() {
        // Adjusted standard time: a float32 there is 16 seconds apart from the next one.
        let times = since(311_862_000.0, &[311_862_004.25, 311_862_000.0, f64::NAN, 311_862_000.125]);
        assert_eq!([times[0], times[1], times[3]], [4.25, 0.0, 0.125]);
        assert!(times[2].is_nan());
    }

    #[test]
    fn eight_bits_in_sixteen_are_seen_over_the_whole_file() {
        assert_eq!(linear(&[[0; 3], [0; 3]], 0), None);
        let eight = linear(&[[255, 0, 51], [0, 0, 0]], 255).unwrap();
        assert_eq!(eight, [Vec3::new(1.0, 0.0, decode_srgb(0.2)), Vec3::ZERO]);
        let sixteen = linear(&[[255, 0, 0], [65535, 0, 256]], 65535).unwrap();
        assert_eq!(sixteen[0].x, decode_srgb(255.0 / 65535.0));
        assert_eq!(sixteen[1], Vec3::new(1.0, 0.0, decode_srgb(256.0 / 65535.0)));
        let black = linear(&[[0; 3]], 7).unwrap();
        assert_eq!(black, [Vec3::ZERO], "a part of a file with colors");
    }
}
