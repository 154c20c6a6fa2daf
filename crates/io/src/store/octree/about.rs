//! The object `pellucid` of metadata.json.

use serde::{Deserialize, Serialize};

use super::attributes::{AttributeLayout, Role};
use crate::prepared::check_claim;
use pellucid_core::cloud::crs::Crs;
use pellucid_core::cloud::field::Field;
use pellucid_core::cloud::shadow_texture::{Casting, ShadowTexture};
use pellucid_core::cloud::{Cloud, Prepared, UpAxis};

/// Version of this description.
pub(crate) const VERSION: u64 = 1;

/// Description that `pellucid prepare` adds: facts about a cloud that Potree has no word for.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct About {
    pub version: u64,
    pub up: UpAxis,
    /// `true` if the source did not state it.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub up_is_convention: bool,
    /// Role of each attribute.
    pub roles: Vec<Role>,
    /// The largest distance of a position from where it was in the source, in the file's units.
    pub rounding: f64,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub prepared: Option<PreparedRecord>,
    /// Points of the source that were dropped because a coordinate is not finite.
    #[serde(default)]
    pub non_finite: u64,
    /// The filter that Gaussian splats were trained for, as PLY files name it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub filter: Option<String>,
    /// The coordinate reference system of the source.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub crs: Option<Crs>,
}

/// Record of how a cloud was prepared.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct PreparedRecord {
    neighbors: usize,
    #[serde(default)]
    radius_cap: f32,
    estimated_radii: bool,
    field: Field,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    shadows: Option<serde_json::Value>,
}

impl PreparedRecord {
    pub fn of(prepared: &Prepared) -> Self {
        let casting = |shadows: &ShadowTexture| serde_json::to_value(shadows.casting).ok();
        Self {
            neighbors: prepared.neighbors,
            radius_cap: prepared.radius_cap,
            estimated_radii: prepared.estimated_radii,
            field: prepared.field.clone(),
            shadows: prepared.shadows.as_ref().and_then(casting),
        }
    }

    /// Returns the same without values; shadows only if there is an attribute for their light. The reason why it can't
    /// be.
    pub fn prepared(&self, has_light: bool) -> Result<Prepared, String> {
        let Self { neighbors, radius_cap, estimated_radii, .. } = *self;
        check_claim(neighbors, radius_cap)?;
        let casting = self.shadows.clone().filter(|_| has_light);
        let casting: Option<Casting> =
            casting.map(serde_json::from_value).transpose().map_err(|error| error.to_string())?;
        let shadows = casting.map(|casting| ShadowTexture { casting, lit: Vec::new() });
        Ok(Prepared { neighbors, radius_cap, estimated_radii, field: self.field.clone(), values: Vec::new(), shadows })
    }
}

impl About {
    /// Returns the description of a store of clouds like this one. `rounding` is the largest distance that positions
    /// moved.
    pub fn new(like: &Cloud, layout: &AttributeLayout, rounding: f64) -> Self {
        Self {
            version: VERSION,
            up: like.up,
            up_is_convention: like.up_is_convention,
            roles: layout.attributes.iter().map(|attribute| attribute.role.clone()).collect(),
            rounding,
            prepared: like.prepared.as_ref().map(PreparedRecord::of),
            non_finite: like.non_finite as u64,
            filter: like.filter.map(|filter| filter.name().to_owned()),
            crs: like.crs.as_deref().cloned(),
        }
    }
}
