//! Tiles of an EPT folder that are plain rows of the schema's numbers, little-endian and without gaps.

use glam::DVec3;

use super::metadata::Dimension;
use crate::las::Columns;
use crate::number::NumberType;
use crate::{Error, InputFile, LasColumns, decoder};
use pellucid_core::cloud::Cloud;

/// Dimensions of LAS points that clouds have no columns for.
const UNUSED: [&str; 10] = [
    "ScanAngleRank",
    "ScanAngle",
    "UserData",
    "ScanDirectionFlag",
    "EdgeOfFlightLine",
    "ScanChannel",
    "Synthetic",
    "KeyPoint",
    "Overlap",
    "Infrared",
];

/// The bit of a point's flags that says that it is withheld (LAS 1.4, table 16).
const WITHHELD: u8 = 1 << 2;

/// Bytes of points that one compressed byte stands for, at most: coordinates don't repeat.
pub(super) const MOST_FOR_ONE: u64 = 1000;

/// The numbers of a row, by what they are.
#[derive(Debug)]
pub(super) struct EptRows {
    len: usize,
    position: [Number; 3],
    color: Option<[Number; 3]>,
    intensity: Option<Number>,
    classification: Option<Number>,
    /// Number of the return, and how many the pulse has.
    returns: Option<[Number; 2]>,
    source: Option<Number>,
    gps_time: Option<Number>,
    /// Numbers that tell that a point is withheld, each with the bits that do.
    withheld: Vec<(Number, u8)>,
    extra: Vec<(String, Number)>,
}

/// A number in a row.
#[derive(Debug, Clone, Copy)]
struct Number {
    at: usize,
    kind: NumberType,
    scale: f64,
    offset: f64,
}

impl Number {
    fn of(&self, row: &[u8]) -> f64 {
        self.kind.read(&row[self.at..]) * self.scale + self.offset
    }
}

impl EptRows {
    /// Returns the rows of a schema, or what is wrong with it.
    pub fn new(schema: &[Dimension]) -> Result<Self, String> {
        let mut numbers = Vec::with_capacity(schema.len());
        let mut len = 0;
        for Dimension { name, class, size, scale, offset, .. } in schema {
            let kind = NumberType::of(*class, *size).ok_or_else(|| format!("`{name}` can't have {size} bytes"))?;
            let number = Number { at: len, kind, scale: scale.unwrap_or(1.0), offset: offset.unwrap_or(0.0) };
            numbers.push((name.clone(), number));
            len += size;
        }
        let mut take = |name: &str| {
            let at = numbers.iter().position(|(known, _)| known == name)?;
            Some(numbers.remove(at).1)
        };
        let (Some(x), Some(y), Some(z)) = (take("X"), take("Y"), take("Z")) else {
            return Err("it lacks one of `X`, `Y` and `Z`".to_owned());
        };
        let color = take("Red").zip(take("Green")).zip(take("Blue")).map(|((red, green), blue)| [red, green, blue]);
        let returns = take("ReturnNumber").zip(take("NumberOfReturns")).map(|(number, of)| [number, of]);
        let (intensity, classification) = (take("Intensity"), take("Classification"));
        let (source, gps_time) = (take("PointSourceId"), take("GpsTime"));
        let flags = [("Withheld", u8::MAX), ("ClassFlags", WITHHELD), ("ClassificationFlags", WITHHELD)];
        let withheld = flags.into_iter().filter_map(|(name, bits)| Some((take(name)?, bits))).collect();
        let extra = numbers.into_iter().filter(|(name, _)| !UNUSED.contains(&&**name)).collect();
        let position = [x, y, z];
        Ok(Self { len, position, color, intensity, classification, returns, source, gps_time, withheld, extra })
    }

    /// Returns the number of bytes of a point.
    pub fn len(&self) -> usize {
        self.len
    }

    /// Returns the columns of a tile with so many points, and the names of those that LAS doesn't know.
    pub fn read(
        &self,
        mut source: InputFile,
        points: u64,
        asked: LasColumns,
        compressed: bool,
    ) -> Result<(Columns, Vec<String>), Error> {
        let mut bytes = source.all()?;
        if compressed {
            let most = points.saturating_mul(self.len as u64);
            let fail = |cause| source.malformed("zstandard", format!("{cause}; the hierarchy says {points} points"));
            let packed = bytes.len();
            bytes = decoder::zstandard(&bytes, most).map_err(fail)?;
            if bytes.len() as u64 > most {
                return Err(fail(format!("more than {most} bytes come from {packed} compressed ones")));
            }
        }
        if bytes.len() % self.len != 0 {
            return Err(source.truncated(format!(
                "{} bytes are not a multiple of the {} bytes of a point",
                bytes.len(),
                self.len
            )));
        }
        let records = (bytes.len() / self.len) as u64;
        let is_withheld = |row: &[u8]| self.withheld.iter().any(|(flags, bits)| flags.of(row) as u8 & bits != 0);
        let withheld: Vec<u64> =
            (0u64..).zip(bytes.chunks_exact(self.len)).filter(|(_, row)| is_withheld(row)).map(|(at, _)| at).collect();
        let rows = || bytes.chunks_exact(self.len).filter(|row| withheld.is_empty() || !is_withheld(row));
        let positions: Vec<DVec3> =
            rows().map(|row| DVec3::from(self.position.each_ref().map(|number| number.of(row)))).collect();
        if let Some(at) = positions.iter().position(|position| !position.is_finite()) {
            return Err(source.malformed(format!("point {at}"), "a coordinate is not finite"));
        }
        let byte = |number: Option<Number>| -> Vec<u8> {
            rows().map(|row| number.map_or(0, |number| number.of(row) as u8)).collect()
        };
        let short = |number: &Number| -> Vec<u16> { rows().map(|row| number.of(row) as u16).collect() };
        let number = |number: &Number| -> Vec<f64> { rows().map(|row| number.of(row)).collect() };
        let color = |color: &[Number; 3]| -> Vec<[u16; 3]> {
            rows().map(|row| color.each_ref().map(|number| number.of(row) as u16)).collect()
        };
        let float = |number: &Number| -> Vec<f32> { rows().map(|row| number.of(row) as f32).collect() };
        let columns = Columns {
            rgb: self.color.as_ref().map(color),
            intensity: self.intensity.as_ref().map_or_else(|| vec![0.0; positions.len()], float),
            classification: byte(self.classification),
            return_number: byte(self.returns.map(|[number, _]| number)),
            number_of_returns: byte(self.returns.map(|[_, of]| of)),
            source: self.source.as_ref().filter(|_| asked.source).map(short),
            gps_time: self.gps_time.as_ref().filter(|_| asked.gps_time).map(number),
            extra: self.extra.iter().map(|(_, number)| float(number)).collect(),
            positions,
            non_finite: 0,
            withheld: withheld.clone(),
            records,
        };
        Ok((columns, self.extra.iter().map(|(name, _)| name.clone()).collect()))
    }

    /// Returns the cloud without what the rows don't have.
    pub fn without_missing(&self, mut cloud: Cloud) -> Cloud {
        cloud.intensity = cloud.intensity.filter(|_| self.intensity.is_some());
        cloud.classification = cloud.classification.filter(|_| self.classification.is_some());
        cloud
    }
}
