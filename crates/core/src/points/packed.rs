//! Points as bytes, for other processes of the same program on machines of the same byte order.

use bytemuck::{AnyBitPattern, NoUninit, cast_slice, pod_collect_to_vec};

use super::{Points, Unseen};
use crate::cloud::gaussians::{ColorCoding, Gaussians, MAX_DEGREE, coefficients};

/// Marks packed points: of another version or another byte order it is another number.
const MARK: u64 = 0x0003_7374_6e69_6f70;

/// Bytes that are no packed points.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("these bytes are no packed points: {0}")]
pub struct Unreadable(&'static str);

impl Unreadable {
    /// Fewer bytes than there have to be.
    pub const SHORT: Self = Self("they end too early");
    /// Runs that are not one behind the other.
    pub const RUNS: Self = Self("runs that are none");
}

impl Points {
    /// Appends the points to some bytes. What is known of the scene that they stand for is not among them.
    pub fn pack(&self, to: &mut Vec<u8>) {
        let Self {
            positions, colors, opacities, radii, normals, file_order, dealt_ids, fields, gaussians, unseen, ..
        } = self;
        let splats = gaussians.as_ref().map_or(0, |all| 1 + u64::from(all.degree));
        let has_normals = normals.is_some().into();
        put(to, &[MARK, positions.len() as u64, unseen.positions.len() as u64, has_normals, splats]);
        put(to, positions);
        put_column(to, colors);
        [opacities, radii, fields].into_iter().for_each(|column| put_column(to, column));
        [file_order, dealt_ids].into_iter().for_each(|column| put_column(to, column));
        normals.iter().for_each(|normals| put(to, normals));
        if let Some(Gaussians { extents, rotations, bases, coding, degree: _, harmonics }) = gaussians {
            put(to, extents);
            put(to, rotations);
            put(to, bases);
            put(to, harmonics);
            let (word, each): (u64, &[bool]) = match coding {
                ColorCoding::Display => (0, &[]),
                ColorCoding::Linear => (1, &[]),
                ColorCoding::Each(linear) => (2, linear),
            };
            put(to, &[word]);
            put(to, each);
        }
        put(to, &unseen.positions);
        put(to, &unseen.radii);
    }

    /// Takes points off the front of some bytes.
    ///
    /// # Errors
    /// The bytes end too early, were packed by something else, or have positions that are not finite.
    pub fn unpack(bytes: &mut &[u8]) -> Result<Self, Unreadable> {
        let [mark, count, unseen, has_normals, splats] = taken::<u64>(bytes, 5)?[..] else {
            return Err(Unreadable("no header"));
        };
        if mark != MARK || has_normals > 1 || splats > 1 + u64::from(MAX_DEGREE) {
            return Err(Unreadable("another header"));
        }
        let [count, unseen] = [count, unseen].map(|count| usize::try_from(count).unwrap_or(usize::MAX));
        // In the order of the bytes.
        let points = Self {
            sensor: None,
            positions: taken(bytes, count)?,
            colors: taken_column(bytes, count)?,
            opacities: taken_column(bytes, count)?,
            radii: taken_column(bytes, count)?,
            fields: taken_column(bytes, count)?,
            file_order: taken_column(bytes, count)?,
            dealt_ids: taken_column(bytes, count)?,
            normals: (has_normals == 1).then(|| taken(bytes, count)).transpose()?,
            gaussians: splats.checked_sub(1).map(|degree| gaussians(bytes, count, degree as u32)).transpose()?,
            unseen: Unseen { positions: taken(bytes, unseen)?, radii: taken(bytes, unseen)? }.into(),
            whole: None,
        };
        let mut places = points.positions.iter().chain(&points.unseen.positions);
        if places.all(|position| position.is_finite()) { Ok(points) } else { Err(Unreadable("a place that is none")) }
    }
}

fn gaussians(bytes: &mut &[u8], count: usize, degree: u32) -> Result<Gaussians, Unreadable> {
    let harmonics = count.saturating_mul(coefficients(degree));
    Ok(Gaussians {
        extents: taken(bytes, count)?,
        rotations: taken(bytes, count)?,
        bases: taken(bytes, count)?,
        degree,
        harmonics: taken(bytes, harmonics)?,
        coding: match taken::<u64>(bytes, 1)?[..] {
            [0] => ColorCoding::Display,
            [1] => ColorCoding::Linear,
            [2] => ColorCoding::Each(taken::<u8>(bytes, count)?.into_iter().map(|linear| linear != 0).collect()),
            _ => return Err(Unreadable("colors of another meaning")),
        },
    })
}

/// Appends the bytes of a column.
#[doc(hidden)]
pub fn put<T: NoUninit>(to: &mut Vec<u8>, column: &[T]) {
    to.extend_from_slice(cast_slice(column));
}

/// Appends the bytes of a column that may be empty.
fn put_column<T: NoUninit>(to: &mut Vec<u8>, column: &[T]) {
    put(to, &[column.len() as u64]);
    put(to, column);
}

/// Returns a column of so many values, or an empty one.
fn taken_column<T: NoUninit + AnyBitPattern>(bytes: &mut &[u8], count: usize) -> Result<Vec<T>, Unreadable> {
    match taken::<u64>(bytes, 1)?[..] {
        [0] => Ok(Vec::new()),
        [length] if length == count as u64 => taken(bytes, count),
        _ => Err(Unreadable("a column of another length")),
    }
}

/// Returns the first values of some bytes.
#[doc(hidden)]
pub fn taken<T: NoUninit + AnyBitPattern>(bytes: &mut &[u8], count: usize) -> Result<Vec<T>, Unreadable> {
    let length = count.checked_mul(size_of::<T>()).filter(|length| *length <= bytes.len());
    let (own, rest) = bytes.split_at(length.ok_or(Unreadable::SHORT)?);
    *bytes = rest;
    Ok(pod_collect_to_vec(own))
}

#[cfg(test)]
mod tests {
    use glam::{DVec3, Vec3};

    use super::*;

    fn points(degree: u32) -> Points {
        let gaussians = Gaussians {
            extents: vec![Vec3::X; 2],
            harmonics: vec![Vec3::Y; 2 * coefficients(degree)],
            degree,
            ..Gaussians::none(2)
        };
        Points {
            positions: vec![DVec3::ONE, DVec3::splat(-1.0 / 3.0)],
            colors: vec![Vec3::splat(0.1), Vec3::X],
            opacities: vec![0.5, 1.0],
            radii: vec![0.0, 1e-3],
            normals: Some(vec![Vec3::Z; 2]),
            file_order: vec![7, 1],
            dealt_ids: Vec::new(),
            fields: vec![0.25, 0.75],
            gaussians: Some(gaussians),
            unseen: Unseen { positions: vec![DVec3::Z], radii: vec![2.0] }.into(),
            sensor: None,
            whole: None,
        }
    }

    #[test]
    fn packed_points_unpack_to_the_same_points() {
        let few = Points { normals: None, gaussians: None, ..points(0) };
        let none = Points { normals: Some(Vec::new()), ..Points::default() };
        let coded = |coding| {
            let gaussians = points(1).gaussians.map(|all| Gaussians { coding, ..all });
            Points { gaussians, ..points(1) }
        };
        let coded = [ColorCoding::Linear, ColorCoding::Each(vec![false, true])].map(coded);
        let all = [points(0), points(3), few, none, Points::default()].into_iter().chain(coded);
        let all: Vec<Points> = all.collect();
        let mut bytes = Vec::new();
        all.iter().for_each(|points| points.pack(&mut bytes));
        let mut rest = bytes.as_slice();
        for points in all {
            assert_eq!(Points::unpack(&mut rest), Ok(points));
        }
        assert!(rest.is_empty());
    }

    #[test]
    fn other_bytes_are_refused() {
        let mut bytes = Vec::new();
        points(2).pack(&mut bytes);
        for end in 0..bytes.len() {
            assert!(Points::unpack(&mut &bytes[..end]).is_err(), "{end}");
        }
        // Whatever the header says.
        for at in 0..40 {
            for value in [0, 1, 0x7f, 0xff] {
                let mut other = bytes.clone();
                other[at] = value;
                let _ = Points::unpack(&mut other.as_slice());
            }
        }
        bytes[40..48].copy_from_slice(&f64::NAN.to_le_bytes());
        assert!(Points::unpack(&mut bytes.as_slice()).is_err());
    }
}
