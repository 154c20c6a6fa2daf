//! Types that fields of settings have, and what a file writes for them.

use std::any::Any;
use std::ops::RangeInclusive;
use std::path::PathBuf;

use glam::{DVec3, Vec3};

use super::{Key, Range, ValueKind, value};
use crate::error::Error;
use crate::setting::Setting;
use crate::table::Table;

/// A type that a key gives a value to.
pub(crate) trait Value: Sized {
    /// Values that are allowed; `()` if all are.
    type Allowed;

    /// The form of its value in a file.
    fn kind(allowed: Self::Allowed) -> ValueKind;

    /// The value of a key; `None` if it is not given.
    fn read(table: &Table<'_>, key: &str, allowed: Self::Allowed) -> Result<Option<Self>, Error>;

    /// The value as a file gives it; `None` where leaving the key out means just this.
    fn setting(&self) -> Option<Setting>;
}

/// A field of settings: a value with a key of its own, or settings with keys of theirs.
pub(crate) trait SettingsField {
    /// Allowed values, as of [`Value`].
    type Allowed;

    /// The keys that set it. `key` is what is declared beside the field.
    fn keys(&self, key: Key, allowed: Self::Allowed) -> Vec<Key>;

    /// Adds the settings that it is or holds.
    fn parts<'a>(&'a self, _: &mut Vec<&'a dyn Any>) {}

    /// Takes what the table gives.
    fn update(&mut self, table: &Table<'_>, key: &str, allowed: Self::Allowed) -> Result<(), Error>;
}

impl<T: Value> SettingsField for T {
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

    fn kind(allowed: T::Allowed) -> ValueKind {
        T::kind(allowed)
    }

    fn read(table: &Table<'_>, key: &str, allowed: T::Allowed) -> Result<Option<Self>, Error> {
        Ok(T::read(table, key, allowed)?.map(Some))
    }

    fn setting(&self) -> Option<Setting> {
        self.as_ref().and_then(T::setting)
    }
}

value! {
    f32, in Range as allowed => ValueKind::Number(allowed);
    |table, key| table.number32(key, allowed);
    |x| Some(Setting::Number(rounded(*x)));
}

value! {
    f64, in Range as allowed => ValueKind::Number(allowed);
    |table, key| table.number(key, allowed);
    |x| Some(Setting::Number(*x));
}

value! {
    u32, in RangeInclusive<u32> as allowed => ValueKind::Integer(*allowed.start(), *allowed.end());
    |table, key| table.integer(key, *allowed.start(), *allowed.end());
    |i| Some(Setting::Integer(*i));
}

value! {
    usize, in RangeInclusive<u32> as allowed => u32::kind(allowed);
    |table, key| Ok(u32::read(table, key, allowed)?.map(|count| count as usize));
    |count| u32::try_from(*count).ok().map(Setting::Integer);
}

value! {
    bool => ValueKind::Flag;
    |table, key| table.boolean(key);
    |flag| Some(Setting::Flag(*flag));
}

// Linear R, G, B.
value! {
    Vec3 => ValueKind::Color;
    |table, key| table.color(key);
    |color| Some(Setting::Numbers(color.to_array().map(rounded).to_vec()));
}

/// Vectors that are allowed.
#[derive(Clone, Copy)]
pub(crate) enum Vectors {
    /// All.
    Any,
    /// Vectors that have a direction.
    Directions,
}

value! {
    DVec3, in Vectors as allowed => match allowed {
        Vectors::Any => ValueKind::Vector,
        Vectors::Directions => ValueKind::Direction,
    };
    |table, key| match allowed {
        Vectors::Any => table.vector(key),
        Vectors::Directions => table.direction(key),
    };
    |vector| Some(Setting::from(vector.to_array()));
}

// Width and height.
value! {
    [u32; 2], in RangeInclusive<u32> as allowed => ValueKind::Size(*allowed.end());
    |table, key| table.size(key, *allowed.end());
    |size| Some(Setting::from(*size));
}

// The lower and the upper end of a range.
value! {
    [f64; 2] => ValueKind::Other("`[low, high]`");
    |table, key| table.range(key);
    |range| Some(Setting::from(*range));
}

// A file, relative to the folder of the scene file.
value! {
    PathBuf => ValueKind::Text;
    |table, key| table.path_of(key);
    |_| None;
}

/// Returns the shortest number that is this one in float32: 0.17 and not 0.17000000178813934.
pub fn rounded(x: f32) -> f64 {
    x.to_string().parse().unwrap_or(f64::from(x))
}
