//! metadata.json, as PotreeConverter writes it, and what this program adds to it.

use std::path::Path;

use serde::{Deserialize, Serialize};

use super::about::{About, VERSION};
use super::attributes::{AS_STORED, Attribute, AttributeLayout, NumberType, Role};
use crate::Error;
use crate::store::Grid;
use pellucid_core::cloud::Bounds;

/// The file of a folder that is an octree.
pub const METADATA: &str = "metadata.json";

/// Bytes of the file at most: it describes attributes, not points.
const MAX_BYTES: u64 = 16 << 20;

/// Coordinates of a box are below: what is rounded is added to them, and they to each other.
const MOST: f64 = 0.25 * f64::MAX;

/// metadata.json.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(crate) struct Metadata {
    pub version: String,
    #[serde(default)]
    pub name: String,
    #[serde(default)]
    pub description: String,
    pub points: u64,
    #[serde(default)]
    pub projection: String,
    pub hierarchy: Hierarchy,
    pub offset: [f64; 3],
    pub scale: [f64; 3],
    pub spacing: f64,
    pub bounding_box: Corners,
    #[serde(default = "uncompressed")]
    pub encoding: String,
    pub attributes: Vec<Described>,
    /// [`About`]; read by itself, since others may write another object of that name.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub pellucid: Option<serde_json::Value>,
}

fn uncompressed() -> String {
    "DEFAULT".to_owned()
}

/// Division of hierarchy.bin.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(crate) struct Hierarchy {
    pub first_chunk_size: u64,
    #[serde(default)]
    pub step_size: u64,
    #[serde(default)]
    pub depth: u64,
}

/// A box.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct Corners {
    pub min: [f64; 3],
    pub max: [f64; 3],
}

/// An attribute.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(crate) struct Described {
    pub name: String,
    #[serde(default)]
    pub description: String,
    pub size: usize,
    pub num_elements: usize,
    pub element_size: usize,
    #[serde(rename = "type")]
    pub kind: NumberType,
    #[serde(default)]
    pub min: Vec<Option<f64>>,
    #[serde(default)]
    pub max: Vec<Option<f64>>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub scale: Option<Vec<f64>>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub offset: Option<Vec<f64>>,
}

impl Described {
    /// Returns the least and largest value, if both are there and a range.
    pub fn range(&self) -> Option<[f64; 2]> {
        let first = |values: &[Option<f64>]| values.first().copied().flatten();
        let [least, most] = [first(&self.min)?, first(&self.max)?];
        (least <= most && (most - least).is_finite()).then_some([least, most])
    }

    /// Returns the largest value of all elements.
    pub fn largest(&self) -> Option<f64> {
        self.max.iter().copied().flatten().max_by(f64::total_cmp)
    }

    /// Factor and summand of its values.
    fn transform(&self) -> [f64; 2] {
        let first = |values: &Option<Vec<f64>>| values.as_ref().and_then(|values| values.first().copied());
        let [factor, summand] = [first(&self.scale).unwrap_or(1.0), first(&self.offset).unwrap_or(0.0)];
        if factor.is_finite() && factor != 0.0 && summand.is_finite() { [factor, summand] } else { AS_STORED }
    }
}

/// metadata.json with everything checked that it says by itself.
pub(crate) struct Checked {
    pub metadata: Metadata,
    pub about: Option<About>,
    pub layout: AttributeLayout,
    pub grid: Grid,
    pub bounds: Bounds,
    pub warnings: Vec<String>,
}

/// Reads the file.
pub(crate) fn read(path: &Path) -> Result<Checked, Error> {
    let malformed = |place: &str, cause: String| Error::malformed(path, place, cause);
    let failed = |source| Error::Read { path: path.to_path_buf(), source };
    let bytes = std::fs::metadata(path).map_err(failed)?.len();
    if bytes > MAX_BYTES {
        return Err(malformed("size", format!("{bytes} bytes are too many for a description (at most {MAX_BYTES})")));
    }
    let text = std::fs::read(path).map_err(failed)?;
    let metadata: Metadata = serde_json::from_slice(&text)
        .map_err(|error| malformed("JSON", format!("{error}; a Potree 2.0 octree was expected")))?;
    if !metadata.version.starts_with("2.") {
        return Err(malformed("version", format!("{:?}, but only Potree 2 is supported", metadata.version)));
    }
    if metadata.encoding != "DEFAULT" {
        let cause = format!(
            "compression {:?} is not supported; convert the source with `--encoding UNCOMPRESSED` or with `pellucid prepare`",
            metadata.encoding
        );
        return Err(malformed("encoding", cause));
    }
    let grid = Grid { scale: metadata.scale.into(), offset: metadata.offset.into() };
    if !grid.is_valid() {
        let cause = "scales must be above 0, and coordinates within the range of float64";
        return Err(malformed("scale", cause.to_owned()));
    }
    if metadata.spacing < 0.0 {
        return Err(malformed("spacing", format!("{} is not a distance", metadata.spacing)));
    }
    let bounds = bounds(&metadata.bounding_box).map_err(|cause| malformed("boundingBox", cause))?;
    let mut warnings = Vec::new();
    let about = about(&metadata, &mut warnings);
    let layout = layout(&metadata, about.as_ref()).map_err(|(name, cause)| malformed(&name, cause))?;
    Ok(Checked { metadata, about, layout, grid, bounds, warnings })
}

fn bounds(corners: &Corners) -> Result<Bounds, String> {
    let bounds = Bounds { min: corners.min.into(), max: corners.max.into() };
    let sides = bounds.max - bounds.min;
    let far = bounds.min.abs().max(bounds.max.abs()).max_element();
    if far < MOST && sides.min_element() >= 0.0 {
        return Ok(bounds);
    }
    Err(format!("there is no box from {} to {}", bounds.min, bounds.max))
}

/// Returns the description that this program added, if it can be used; a warning if not.
fn about(metadata: &Metadata, warnings: &mut Vec<String>) -> Option<About> {
    let value = metadata.pellucid.clone()?;
    let read = || {
        match value.get("version").and_then(serde_json::Value::as_u64) {
            Some(VERSION) => {}
            Some(version) => {
                return Err(format!(
                    "it was prepared in format {version}, but this program reads only format {VERSION}"
                ));
            }
            None => return Err("`pellucid` names no version".to_owned()),
        }
        let about: About =
            serde_json::from_value(value).map_err(|error| format!("`pellucid` can't be read ({error})"))?;
        let (roles, attributes) = (about.roles.len(), metadata.attributes.len());
        if roles == attributes {
            Ok(about)
        } else {
            Err(format!("`pellucid` has {roles} roles for {attributes} attributes"))
        }
    };
    let refused =
        |why| warnings.push(format!("{METADATA}: {why}; the values stored by `pellucid prepare` are ignored"));
    read().map_err(refused).ok()
}

/// The places of the attributes in a record. An error comes with the attribute.
fn layout(metadata: &Metadata, about: Option<&About>) -> Result<AttributeLayout, (String, String)> {
    let mut layout = AttributeLayout::default();
    for (index, described) in metadata.attributes.iter().enumerate() {
        let Described { ref name, kind, num_elements: elements, size: bytes, element_size, .. } = *described;
        let role = match about {
            Some(about) => about.roles[index].clone(),
            None => Role::named(name, kind, elements),
        };
        let transform = if about.is_none() { described.transform() } else { AS_STORED };
        let attribute = Attribute { name: name.clone(), kind, elements, role, at: 0, bytes, transform };
        let added = layout.add_foreign(attribute, element_size);
        added.map_err(|cause| (format!("attribute {name:?}"), cause))?;
    }
    if layout.find(&Role::Position).is_none() {
        let names: Vec<_> = layout.attributes.iter().map(|attribute| &*attribute.name).collect();
        return Err((
            "attributes".to_owned(),
            format!("there is no position of three int32, only [{}]", names.join(", ")),
        ));
    }
    Ok(layout)
}

/// Returns the description of an attribute with its range.
pub(crate) fn describe(attribute: &Attribute, ranges: &[[f64; 2]]) -> Described {
    // Ranges of nothing, and what is not finite, are none; the viewer wants numbers.
    let end = |end: usize| {
        let of = |range: &[f64; 2]| Some(if range[0] <= range[1] { range[end] } else { 0.0 });
        ranges.iter().map(of).collect()
    };
    Described {
        name: attribute.name.clone(),
        description: String::new(),
        size: attribute.bytes,
        num_elements: attribute.elements,
        element_size: attribute.bytes / attribute.elements.max(1),
        kind: attribute.kind,
        min: end(0),
        max: end(1),
        scale: None,
        offset: None,
    }
}
