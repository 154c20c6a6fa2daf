//! COLMAP's binary files, little-endian.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{self, BufRead, BufReader, Read};
use std::path::Path;

use super::colmap::{Image, MODELS, intrinsics};
use super::{Intrinsics, check_count, content};
use crate::camera::path::Error;

/// Bytes of an image's name at most.
const MAX_NAME: u64 = 4096;

/// Bytes of a point of an image: x and y as float64, and the number of a point in space.
const POINT_BYTES: i64 = 24;

/// A file, and how much of it is left.
struct Bytes<'a> {
    path: &'a Path,
    file: BufReader<File>,
    left: u64,
}

impl<'a> Bytes<'a> {
    fn open(path: &'a Path) -> Result<Self, Error> {
        let failed = |source| Error::Read { path: path.to_owned(), source };
        let file = File::open(path).map_err(failed)?;
        let left = file.metadata().map_err(failed)?.len();
        Ok(Self { path, file: BufReader::new(file), left })
    }

    fn take<const N: usize>(&mut self) -> Result<[u8; N], Error> {
        let mut bytes = [0; N];
        self.count(N as u64)?;
        self.file.read_exact(&mut bytes).map_err(|source| self.failed(source))?;
        Ok(bytes)
    }

    /// Counts what is read, and refuses to read beyond the end.
    fn count(&mut self, bytes: u64) -> Result<(), Error> {
        let left = self.left.checked_sub(bytes);
        self.left = left.ok_or_else(|| content(self.path, "ends too early; the file is damaged, or not COLMAP's"))?;
        Ok(())
    }

    fn failed(&self, source: io::Error) -> Error {
        Error::Read { path: self.path.to_owned(), source }
    }

    fn u32(&mut self) -> Result<u32, Error> {
        Ok(u32::from_le_bytes(self.take()?))
    }

    fn u64(&mut self) -> Result<u64, Error> {
        Ok(u64::from_le_bytes(self.take()?))
    }

    fn f64s<const N: usize>(&mut self) -> Result<[f64; N], Error> {
        let mut numbers = [0.0; N];
        for number in &mut numbers {
            *number = f64::from_le_bytes(self.take()?);
        }
        Ok(numbers)
    }

    /// Reads up to and including a zero byte, and returns the bytes before it.
    fn name(&mut self) -> Result<Vec<u8>, Error> {
        let mut name = Vec::new();
        let limit = self.left.min(MAX_NAME);
        let read = (&mut self.file).take(limit).read_until(0, &mut name);
        let read = read.map_err(|source| self.failed(source))?;
        self.count(read as u64)?;
        match name.pop() {
            Some(0) => Ok(name),
            _ => Err(content(self.path, format!("an image's name has no end within {MAX_NAME} bytes"))),
        }
    }

    /// Passes over the points of an image.
    fn skip_points(&mut self) -> Result<(), Error> {
        let count = self.u64()?;
        let bytes = i64::try_from(count).ok().and_then(|count| count.checked_mul(POINT_BYTES)).unwrap_or(i64::MAX);
        self.count(bytes.unsigned_abs())?;
        self.file.seek_relative(bytes).map_err(|source| self.failed(source))
    }

    /// A number of records, each of at least `bytes` bytes, that is checked against the rest of the file.
    fn records(&mut self, bytes: u64, what: &str) -> Result<u64, Error> {
        let count = self.u64()?;
        if count > self.left / bytes {
            return Err(content(self.path, format!("says that it holds {count} {what}, but is too short for them")));
        }
        check_count(self.path, usize::try_from(count).unwrap_or(usize::MAX), what)?;
        Ok(count)
    }
}

pub fn cameras(path: &Path) -> Result<BTreeMap<u32, Intrinsics>, Error> {
    let mut bytes = Bytes::open(path)?;
    let mut cameras = BTreeMap::new();
    for _ in 0..bytes.records(4 + 4 + 8 + 8 + 3 * 8, "cameras")? {
        let (id, model) = (bytes.u32()?, bytes.u32()?);
        let size = [bytes.u64()? as f64, bytes.u64()? as f64];
        let wrong = |problem: String| content(path, format!("camera {id}: {problem}"));
        let model = model as usize;
        let (_, count, _) = MODELS.get(model).ok_or_else(|| wrong(format!("unknown camera model {model}")))?;
        let mut parameters = Vec::new();
        for _ in 0..*count {
            parameters.extend(bytes.f64s::<1>()?);
        }
        cameras.insert(id, intrinsics(model, size, &parameters).map_err(wrong)?);
    }
    Ok(cameras)
}

pub fn images(path: &Path) -> Result<Vec<Image>, Error> {
    let mut bytes = Bytes::open(path)?;
    let count = bytes.records(4 + 7 * 8 + 4 + 1 + 8, "images")?;
    let mut images = Vec::new();
    for _ in 0..count {
        bytes.u32()?;
        let (rotation, translation) = (bytes.f64s()?, bytes.f64s()?);
        let (camera, name) = (bytes.u32()?, bytes.name()?);
        bytes.skip_points()?;
        images.push(Image { name, rotation, translation, camera });
    }
    Ok(images)
}
