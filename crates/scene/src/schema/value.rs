//! Types that fields of settings have, and what a file writes for them.

use std::any::Any;
use std::ops::RangeInclusive;
use std::path::PathBuf;

use glam::{DVec3, Vec3};

use super::{Key, Kind, Range};
use crate::Setting;
use crate::error::Error;
use crate::table::Table;

/// A type that a key gives a value to.
pub(crate) trait Value: Sized {
    /// Values that are allowed; `()` if all are.
    type Allowed;

    /// The form of its value in a file.
    fn kind(allowed: Self::Allowed) -> Kind;

    /// The value of a key; `None` if it is not given.
    fn read(table: &Table<'_>, key: &str, allowed: Self::Allowed) -> Result<Option<Self>, Error>;

    /// The value as a file gives it; `None` where leaving the key out means just this.
    fn setting(&self) -> Option<Setting>;
}

/// A field of settings: a value with a key of its own, or settings with keys of theirs.
pub(crate) trait Part {
    /// Allowed values, as of [`Value`].
    type Allowed;

    /// The keys that set it. `key` is what is declared beside the field.
    fn keys(&self, key: Key, allowed: Self::Allowed) -> Vec<Key>;

    /// Adds the settings that it is or holds.
    fn parts<'a>(&'a self, _: &mut Vec<&'a dyn Any>) {}

    /// Takes what the table gives.
    fn update(&mut self, table: &Table<'_>, key: &str, allowed: Self::Allowed) -> Result<(), Error>;
}

impl<T: Value> Part for T {
    type Allowed = T::Allowed;

    fn keys(&self, key: Key, allowed: T::Allowed) -> Vec<Key> {
        vec![Key { kind: T::kind(allowed), value: self.setting(), ..key }]
    }

    fn update(&mut self, table: &Table<'_>, key: &str, allowed: T::Allowed) -> Result<(), Error> {
        if let Some(value) = T::read(table, key, allowed)? {
            *self = value;
        }
        Ok(())
    }
}

impl<T: Value> Value for Option<T> {
    type Allowed = T::Allowed;

    fn kind(allowed: T::Allowed) -> Kind {
        T::kind(allowed)
    }

    fn read(table: &Table<'_>, key: &str, allowed: T::Allowed) -> Result<Option<Self>, Error> {
        Ok(T::read(table, key, allowed)?.map(Some))
    }

    fn setting(&self) -> Option<Setting> {
        self.as_ref().and_then(T::setting)
    }
}

impl Value for f32 {
    type Allowed = Range;

    fn kind(allowed: Range) -> Kind {
        Kind::Number(allowed)
    }

    fn read(table: &Table<'_>, key: &str, allowed: Range) -> Result<Option<Self>, Error> {
        table.number32(key, allowed)
    }

    fn setting(&self) -> Option<Setting> {
        Some(Setting::Number(rounded(*self)))
    }
}

impl Value for f64 {
    type Allowed = Range;

    fn kind(allowed: Range) -> Kind {
        Kind::Number(allowed)
    }

    fn read(table: &Table<'_>, key: &str, allowed: Range) -> Result<Option<Self>, Error> {
        table.number(key, allowed)
    }

    fn setting(&self) -> Option<Setting> {
        Some(Setting::Number(*self))
    }
}

impl Value for u32 {
    type Allowed = RangeInclusive<u32>;

    fn kind(allowed: RangeInclusive<u32>) -> Kind {
        Kind::Integer(*allowed.start(), *allowed.end())
    }

    fn read(table: &Table<'_>, key: &str, allowed: RangeInclusive<u32>) -> Result<Option<Self>, Error> {
        table.integer(key, *allowed.start(), *allowed.end())
    }

    fn setting(&self) -> Option<Setting> {
        Some(Setting::Integer(*self))
    }
}

impl Value for usize {
    type Allowed = RangeInclusive<u32>;

    fn kind(allowed: RangeInclusive<u32>) -> Kind {
        u32::kind(allowed)
    }

    fn read(table: &Table<'_>, key: &str, allowed: RangeInclusive<u32>) -> Result<Option<Self>, Error> {
        Ok(u32::read(table, key, allowed)?.map(|count| count as Self))
    }

    fn setting(&self) -> Option<Setting> {
        u32::try_from(*self).ok().map(Setting::Integer)
    }
}

impl Value for bool {
    type Allowed = ();

    fn kind((): ()) -> Kind {
        Kind::Flag
    }

    fn read(table: &Table<'_>, key: &str, (): ()) -> Result<Option<Self>, Error> {
        table.boolean(key)
    }

    fn setting(&self) -> Option<Setting> {
        Some(Setting::Flag(*self))
    }
}

/// Linear R, G, B.
impl Value for Vec3 {
    type Allowed = ();

    fn kind((): ()) -> Kind {
        Kind::Color
    }

    fn read(table: &Table<'_>, key: &str, (): ()) -> Result<Option<Self>, Error> {
        table.color(key)
    }

    fn setting(&self) -> Option<Setting> {
        Some(Setting::Numbers(self.to_array().map(rounded).to_vec()))
    }
}

/// Vectors that are allowed.
#[derive(Clone, Copy)]
pub(crate) enum Vectors {
    /// All.
    Any,
    /// Vectors that have a direction.
    Directions,
}

impl Value for DVec3 {
    type Allowed = Vectors;

    fn kind(allowed: Vectors) -> Kind {
        match allowed {
            Vectors::Any => Kind::Vector,
            Vectors::Directions => Kind::Direction,
        }
    }

    fn read(table: &Table<'_>, key: &str, allowed: Vectors) -> Result<Option<Self>, Error> {
        match allowed {
            Vectors::Any => table.vector(key),
            Vectors::Directions => table.direction(key),
        }
    }

    fn setting(&self) -> Option<Setting> {
        Some(Setting::Numbers(self.to_array().to_vec()))
    }
}

/// Width and height.
impl Value for [u32; 2] {
    type Allowed = RangeInclusive<u32>;

    fn kind(allowed: RangeInclusive<u32>) -> Kind {
        Kind::Size(*allowed.end())
    }

    fn read(table: &Table<'_>, key: &str, allowed: RangeInclusive<u32>) -> Result<Option<Self>, Error> {
        table.size(key, *allowed.end())
    }

    fn setting(&self) -> Option<Setting> {
        Some(Setting::Integers(self.to_vec()))
    }
}

/// A file, relative to the folder of the scene file.
impl Value for PathBuf {
    type Allowed = ();

    fn kind((): ()) -> Kind {
        Kind::Text
    }

    fn read(table: &Table<'_>, key: &str, (): ()) -> Result<Option<Self>, Error> {
        table.path_of(key)
    }

    fn setting(&self) -> Option<Setting> {
        None
    }
}

/// Returns the shortest number that is this one in float32: 0.17 and not 0.17000000178813934.
pub fn rounded(x: f32) -> f64 {
    x.to_string().parse().unwrap_or(f64::from(x))
}
