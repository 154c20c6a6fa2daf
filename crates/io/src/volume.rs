//! Volumes: a scalar for each point of a grid, stored without a header in a file whose name describes it, as in the
//! Open SciVis Datasets: `hydrogen_64x64x64_float32.raw`.

use std::io::Read;
use std::path::Path;
use std::str::FromStr;

use super::number::NumberType;
use super::{Error, InputFile};

/// The type of a volume's numbers, little-endian: `uint8`, `int8`, `uint16`, `int16`, `uint32`, `int32`, `float32` or
/// `float64`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Scalar(NumberType);

/// All of them with their names.
const SCALARS: [(&str, NumberType); 8] = [
    ("uint8", NumberType::Uint8),
    ("int8", NumberType::Int8),
    ("uint16", NumberType::Uint16),
    ("int16", NumberType::Int16),
    ("uint32", NumberType::Uint32),
    ("int32", NumberType::Int32),
    ("float32", NumberType::Float),
    ("float64", NumberType::Double),
];

impl Scalar {
    /// Returns the number of bytes of one number.
    pub fn bytes(self) -> usize {
        self.0.bytes().unwrap_or(1)
    }

    fn name(self) -> &'static str {
        SCALARS.iter().find(|(_, kind)| *kind == self.0).map_or("", |(name, _)| name)
    }
}

impl FromStr for Scalar {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let found = SCALARS.iter().find(|(name, _)| *name == text).map(|(_, kind)| Self(*kind));
        let known = || SCALARS.map(|(name, _)| name).join(", ");
        found.ok_or_else(|| format!("unknown type {text:?}; expected one of {}", known()))
    }
}

/// Numbers of a grid along x, y and z.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Dims(pub [usize; 3]);

impl FromStr for Dims {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let numbers: Option<Vec<usize>> = text.split(['x', 'X', '×']).map(|part| part.trim().parse().ok()).collect();
        let numbers = numbers.and_then(|numbers| <[usize; 3]>::try_from(numbers).ok());
        let dims = numbers.filter(|numbers| numbers.iter().all(|n| *n >= 2));
        dims.map(Self).ok_or_else(|| format!("{text}: expected three numbers of at least 2, as in 64x64x64"))
    }
}

impl std::fmt::Display for Dims {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let [x, y, z] = self.0;
        write!(f, "{x}x{y}x{z}")
    }
}

/// A scalar field on a grid.
#[derive(Debug, Clone, PartialEq)]
pub struct Volume {
    /// Numbers of samples along x, y and z, each at least 2.
    pub dims: [usize; 3],
    /// x fastest, then y, then z; as many as the product of `dims`. May hold values that are not finite.
    pub values: Vec<f32>,
}

/// Reads a volume. Omitted parameters are taken from the file's name.
///
/// # Errors
/// The file is missing or empty; its name lacks the omitted parameters; its size doesn't match; too little memory.
pub fn read(path: &Path, dims: Option<Dims>, scalar: Option<Scalar>) -> Result<Volume, Error> {
    let mut source = InputFile::open(path)?;
    let name = path.file_stem().and_then(|stem| stem.to_str()).unwrap_or_default();
    let parts = || name.rsplit('_');
    let unknown = |option: &str| {
        let cause = format!("does not give size and type, as hydrogen_64x64x64_float32.raw does; use {option}");
        Error::malformed(path, "its name", cause)
    };
    let dims = dims.or_else(|| parts().find_map(|part| part.parse().ok()));
    let dims = dims.ok_or_else(|| unknown("--dims XxYxZ"))?;
    let scalar = scalar.or_else(|| parts().find_map(|part| part.parse().ok()));
    let scalar = scalar.ok_or_else(|| unknown("--type NAME"))?;
    // The product of three numbers of 64 bits may need more than 128.
    let expected = dims.0.iter().try_fold(scalar.bytes() as u128, |all, n| all.checked_mul(*n as u128));
    if expected != Some(source.len.into()) {
        let expected = expected.map_or_else(|| "more than any file's".to_owned(), |bytes| bytes.to_string());
        let cause = format!(
            "{dims} numbers of {} are {expected} bytes, but the file has {}; if its name is wrong, give --dims XxYxZ and \
             --type NAME",
            scalar.name(),
            source.len
        );
        return Err(Error::malformed(path, "its size", cause));
    }
    let values = values(&mut source, scalar)?;
    Ok(Volume { dims: dims.0, values })
}

/// All numbers of a file whose size is a multiple of theirs.
fn values(source: &mut InputFile, scalar: Scalar) -> Result<Vec<f32>, Error> {
    let count = source.len / scalar.bytes() as u64;
    let bytes = count.saturating_mul(4);
    let cause = || format!("{count} numbers need {bytes} bytes, more than can be allocated");
    let too_large = || Error::malformed(&source.path, "its size", cause());
    let mut values = Vec::new();
    let wanted = usize::try_from(count).map_err(|_| too_large())?;
    values.try_reserve_exact(wanted).map_err(|_| too_large())?;
    let mut chunk = vec![0u8; scalar.bytes() << 16];
    while values.len() < wanted {
        let part = (wanted - values.len()).min(1 << 16) * scalar.bytes();
        let failed = |error| Error::Read { path: source.path.clone(), source: error };
        source.reader.read_exact(&mut chunk[..part]).map_err(failed)?;
        values.extend(chunk[..part].chunks_exact(scalar.bytes()).map(|bytes| scalar.0.read(bytes) as f32));
    }
    Ok(values)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn file(name: &str, bytes: &[u8]) -> (tempfile::TempDir, std::path::PathBuf) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(name);
        std::fs::write(&path, bytes).unwrap();
        (folder, path)
    }

    fn values(scalar: &str, bytes: &[u8]) -> Vec<f32> {
        let (_folder, path) = file("some_thing_2x2x2.raw", bytes);
        let volume = read(&path, None, Some(scalar.parse().unwrap())).unwrap();
        assert_eq!(volume.dims, [2, 2, 2]);
        volume.values
    }

    #[test]
    fn numbers_of_every_type_are_little_endian() {
        let all = |bytes: &[u8]| bytes.repeat(8);
        for (scalar, bytes, value) in [
            ("uint8", &[200u8][..], 200.0),
            ("int8", &[200], -56.0),
            ("uint16", &[1, 255], 65_281.0),
            ("int16", &[1, 255], -255.0),
            ("uint32", &[1, 0, 0, 128], 2_147_483_648.0),
            ("int32", &[255, 255, 255, 255], -1.0),
            ("float32", &0.1f32.to_le_bytes(), 0.1),
            ("float64", &(-1e-3f64).to_le_bytes(), -1e-3),
        ] {
            assert_eq!(values(scalar, &all(bytes)), [value; 8], "{scalar}");
        }
        assert_eq!(values("uint8", &[0, 1, 2, 3, 4, 5, 6, 7]), [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0]);
    }

    #[test]
    fn names_say_what_options_don_t() {
        let (_folder, path) = file("a_b_3x2x2_int16.raw", &[0; 24]);
        assert_eq!(read(&path, None, None).unwrap().dims, [3, 2, 2]);
        assert_eq!(read(&path, Some(Dims([2, 3, 4])), Some(Scalar(NumberType::Uint8))).unwrap().dims, [2, 3, 4]);
    }

    #[test]
    fn sizes_that_do_not_fit_give_errors() {
        let refused = |name: &str, bytes: usize, dims: Option<&str>, parts: &[&str]| {
            let (_folder, path) = file(name, &vec![0; bytes]);
            let message = read(&path, dims.map(|dims| dims.parse().unwrap()), None).unwrap_err().to_string();
            assert!(parts.iter().chain([&name]).all(|part| message.contains(part)), "{message}");
        };
        refused("a_2x2x2_uint8.raw", 9, None, &["2x2x2", "uint8", "8 bytes", "has 9", "--dims"]);
        refused("a_2x2x2_float64.raw", 8, None, &["64 bytes", "has 8"]);
        refused("a_uint8.raw", 8, None, &["its name", "--dims"]);
        refused("a_2x2.raw", 8, Some("2x2x2"), &["its name", "--type"]);
        refused("a_2x2x2_uint8.raw", 0, None, &["0 bytes"]);
        let most = usize::MAX.to_string();
        refused("a_uint8.raw", 8, Some(&format!("{most}x{most}x{most}")), &["more than any file's"]);
        for text in ["64x64", "64x64x1", "64x64x64x64", "axbxc", "", "-2x3x4", "99999999999999999999x2x2"] {
            assert!(text.parse::<Dims>().unwrap_err().contains("as in 64x64x64"), "{text}");
        }
        assert!("float16".parse::<Scalar>().unwrap_err().contains("uint8, int8"));
        assert!(matches!(read(Path::new("nowhere.raw"), None, None), Err(Error::Missing { .. })));
    }
}
