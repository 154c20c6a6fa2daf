//! The method requested by a scene: a method, or `auto`.

use super::error::Error;
use super::methods::{AUTO, Family, Method};
use super::schema::{Key, Settings};
use super::settings::Discs;
use super::table::Table;

/// `[method]`: the request of a scene. `plan::choose` turns it into a [`Method`] once points and device are
/// known.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum MethodChoice {
    /// The exact method that suits the points, for these discs.
    Auto(Discs),
    /// A particular method.
    Fixed(Method),
}

impl Default for MethodChoice {
    fn default() -> Self {
        Self::Auto(Discs::default())
    }
}

impl From<Method> for MethodChoice {
    fn from(method: Method) -> Self {
        Self::Fixed(method)
    }
}

impl MethodChoice {
    /// Returns the method of this name in a scene file, with its defaults; `None` if this version doesn't have it.
    pub fn named(name: &str) -> Option<Self> {
        let method = Method::all().into_iter().find(|method| method.name() == name);
        if name == AUTO { Some(Self::default()) } else { method.map(Self::Fixed) }
    }

    /// Returns its keys with the values in force; `name` is not among them.
    pub fn keys(&self) -> Vec<Key> {
        match self {
            // No particular method, so keys that only some methods have are left out, unless all have them that it may
            // stand for.
            Self::Auto(discs) => {
                discs.keys().into_iter().filter(|key| key.only.is_empty() || key.only.contains(&AUTO)).collect()
            }
            Self::Fixed(method) => method.keys(),
        }
    }

    /// Takes what the table gives.
    pub(super) fn read(&mut self, table: &Table<'_>) -> Result<(), Error> {
        match self {
            Self::Auto(discs) => discs.read(table),
            Self::Fixed(method) => method.settings_mut().map_or(Ok(()), |settings| settings.read(table)),
        }
    }

    /// The name a scene file gives it.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Auto(_) => AUTO,
            Self::Fixed(method) => method.name(),
        }
    }

    /// Returns the method that was asked for; `None` for `auto`.
    pub fn fixed(&self) -> Option<&Method> {
        match self {
            Self::Auto(_) => None,
            Self::Fixed(method) => Some(method),
        }
    }

    /// Returns a method that shows the requested image for any points and device: for `auto` the A-buffer.
    pub fn representative(&self) -> Method {
        match *self {
            Self::Auto(discs) => Method::ABuffer(discs),
            Self::Fixed(method) => method,
        }
    }

    /// Tells if the choice needs radii, like [`Method::needs_radii`].
    pub fn needs_radii(&self) -> bool {
        self.representative().needs_radii()
    }

    /// Tells if the choice scales by normals, like [`Method::scales_by_normals`].
    pub fn scales_by_normals(&self) -> bool {
        self.representative().scales_by_normals()
    }

    /// Returns `true` for methods that blend discs.
    pub fn is_made_of_discs(&self) -> bool {
        self.representative().family() == Family::Discs
    }

    /// Tells if the choice needs the field, like [`Method::needs_field`].
    pub fn needs_field(&self) -> bool {
        self.representative().needs_field()
    }

    /// Tells if points are shuffled into ensembles, like [`Method::is_dealt`].
    pub fn is_dealt(&self) -> bool {
        self.representative().is_dealt()
    }

    /// Returns `true` if `[shadows]` may apply: to `auto` it does if every point turns out to be opaque.
    pub fn may_take_shadows(&self) -> bool {
        self.fixed().is_none_or(Method::takes_shadows)
    }

    /// Returns `true` if `edl` of `[shading]` may apply, as with shadows.
    pub fn may_take_edl(&self) -> bool {
        self.fixed().is_none_or(Method::takes_edl)
    }
}
