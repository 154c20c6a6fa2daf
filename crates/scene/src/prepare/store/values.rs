//! Values of points in a temporary file, in the order of the store's file.

use std::fs::File;
use std::io::{Seek, SeekFrom};
use std::path::Path;
use std::sync::{Mutex, PoisonError};

use glam::Vec3;

use super::ValuePlan;
use pellucid_core::cloud::field;
use pellucid_fault as fault;
use pellucid_io::Error;

/// The values of a point, of which only those of the plan are kept.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Value {
    pub radius: f32,
    pub normal: Vec3,
    /// F before it is scaled.
    pub spread: f64,
}

/// The file, and the range of the spreads in it.
#[derive(Debug)]
pub(super) struct Values {
    /// Unnamed: it goes with the process.
    file: Mutex<(File, [f64; 2])>,
    folder: std::path::PathBuf,
    plan: ValuePlan,
}

impl Values {
    /// Returns an empty file in a folder.
    pub fn new(folder: &Path, plan: &ValuePlan) -> Result<Self, Error> {
        let file =
            tempfile::tempfile_in(folder).map_err(|source| Error::Write { path: folder.to_path_buf(), source })?;
        let none = [f64::INFINITY, f64::NEG_INFINITY];
        Ok(Self { file: Mutex::new((file, none)), folder: folder.to_path_buf(), plan: plan.clone() })
    }

    /// Bytes of a point.
    fn stride(&self) -> usize {
        let ValuePlan { radii, wants, .. } = self.plan;
        4 * usize::from(radii) + 12 * usize::from(wants.normals) + 8 * usize::from(wants.fields)
    }

    /// Writes the values of points by their places.
    pub fn write(&self, mut found: Vec<(u64, Value)>) -> Result<(), Error> {
        found.sort_unstable_by_key(|(place, _)| *place);
        let mut locked = self.file.lock().unwrap_or_else(PoisonError::into_inner);
        let (file, range) = &mut *locked;
        let [least, most] = field::range(found.iter().map(|(_, value)| value.spread));
        *range = [range[0].min(least), range[1].max(most)];
        // Points in a row are written at once.
        for run in found.chunk_by(|a, b| a.0 + 1 == b.0) {
            let bytes: Vec<u8> = run.iter().flat_map(|(_, value)| self.bytes(value)).collect();
            let written = file
                .seek(SeekFrom::Start(run[0].0 * self.stride() as u64))
                .and_then(|_| fault::write_all(file, &bytes));
            written.map_err(|source| Error::Write { path: self.folder.clone(), source })?;
        }
        Ok(())
    }

    fn bytes(&self, value: &Value) -> Vec<u8> {
        let mut bytes = Vec::with_capacity(self.stride());
        if self.plan.radii {
            bytes.extend(value.radius.to_le_bytes());
        }
        if self.plan.wants.normals {
            bytes.extend(value.normal.to_array().iter().flat_map(|x| x.to_le_bytes()));
        }
        if self.plan.wants.fields {
            bytes.extend(value.spread.to_le_bytes());
        }
        bytes
    }

    /// Returns the range of the spreads.
    pub fn range(&self) -> [f64; 2] {
        self.file.lock().unwrap_or_else(PoisonError::into_inner).1
    }

    /// Returns the values of some points in a row.
    pub fn read(&self, first: u64, points: usize) -> Result<Vec<Value>, Error> {
        let stride = self.stride();
        if stride == 0 {
            return Ok(vec![Value::default(); points]);
        }
        let mut bytes = vec![0; points * stride];
        let mut locked = self.file.lock().unwrap_or_else(PoisonError::into_inner);
        let file = &mut locked.0;
        let read =
            file.seek(SeekFrom::Start(first * stride as u64)).and_then(|_| std::io::Read::read_exact(file, &mut bytes));
        read.map_err(|source| Error::Read { path: self.folder.clone(), source })?;
        drop(locked);
        Ok(bytes.chunks_exact(stride).map(|bytes| self.value(bytes)).collect())
    }

    fn value(&self, bytes: &[u8]) -> Value {
        let mut rest = bytes;
        let mut float = || {
            let (own, others) = rest.split_at(4);
            rest = others;
            f32::from_le_bytes([own[0], own[1], own[2], own[3]])
        };
        let radius = if self.plan.radii { float() } else { 0.0 };
        let normal = if self.plan.wants.normals { Vec3::new(float(), float(), float()) } else { Vec3::ZERO };
        let spread = if self.plan.wants.fields { f64::from_le_bytes(std::array::from_fn(|i| rest[i])) } else { 0.0 };
        Value { radius, normal, spread }
    }
}
