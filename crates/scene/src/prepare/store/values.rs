//! Values of points in a temporary file, in the order of the store's file.

use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use glam::Vec3;

use super::super::temporary::TemporaryFile;
use super::ValuePlan;
use pellucid_core::cloud::field;
use pellucid_io::Error;

/// The values of a point, of which only those of the plan are kept.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Value {
    pub radius: f32,
    pub normal: Vec3,
    /// F before it is scaled.
    pub spread: f64,
}

impl Value {
    fn words(&self) -> [u32; 6] {
        let [x, y, z] = self.normal.to_array().map(f32::to_bits);
        let spread = self.spread.to_bits();
        [self.radius.to_bits(), x, y, z, spread as u32, (spread >> 32) as u32]
    }

    fn of([radius, x, y, z, low, high]: [u32; 6]) -> Self {
        let spread = f64::from_bits(u64::from(high) << 32 | u64::from(low));
        Self { radius: f32::from_bits(radius), normal: Vec3::from([x, y, z].map(f32::from_bits)), spread }
    }
}

/// The file, and the range of the spreads in it.
#[derive(Debug)]
pub(super) struct Values {
    file: TemporaryFile,
    range: Mutex<[f64; 2]>,
    folder: PathBuf,
    /// Words of a value that are kept.
    kept: Vec<usize>,
}

impl Values {
    /// Returns an empty file in a folder.
    pub fn new(folder: &Path, plan: &ValuePlan) -> Result<Self, Error> {
        let folder = folder.to_path_buf();
        let words = [(plan.radii, 0..1), (plan.wants.normals, 1..4), (plan.wants.fields, 4..6)];
        let kept = words.into_iter().filter(|(is_kept, _)| *is_kept).flat_map(|(_, words)| words).collect();
        match TemporaryFile::new(&folder) {
            Ok(file) => Ok(Self { file, range: Mutex::new([f64::INFINITY, f64::NEG_INFINITY]), folder, kept }),
            Err(source) => Err(Error::Write { path: folder, source }),
        }
    }

    /// Writes the values of points by their places.
    pub fn write(&self, mut found: Vec<(u64, Value)>) -> Result<(), Error> {
        found.sort_unstable_by_key(|(place, _)| *place);
        let mut range = self.range.lock().unwrap_or_else(PoisonError::into_inner);
        let [least, most] = field::range(found.iter().map(|(_, value)| value.spread));
        *range = [range[0].min(least), range[1].max(most)];
        // Points in a row are written at once.
        for run in found.chunk_by(|a, b| a.0 + 1 == b.0) {
            let of = |(_, value): &(u64, Value)| {
                let words = value.words();
                self.kept.iter().map(move |at| words[*at])
            };
            let words: Vec<u32> = run.iter().flat_map(of).collect();
            let written = self.file.write(run[0].0 * self.kept.len() as u64, &words);
            written.map_err(|source| Error::Write { path: self.folder.clone(), source })?;
        }
        Ok(())
    }

    /// Returns the range of the spreads.
    pub fn range(&self) -> [f64; 2] {
        *self.range.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Returns the values of some points in a row.
    pub fn read(&self, first: u64, points: usize) -> Result<Vec<Value>, Error> {
        let stride = self.kept.len();
        let mut words = vec![0; points * stride];
        let read = self.file.read(first * stride as u64, &mut words);
        read.map_err(|source| Error::Read { path: self.folder.clone(), source })?;
        let value = |point: usize| {
            let mut all = [0; 6];
            self.kept.iter().zip(&words[point * stride..]).for_each(|(at, word)| all[*at] = *word);
            Value::of(all)
        };
        Ok((0..points).map(value).collect())
    }
}
