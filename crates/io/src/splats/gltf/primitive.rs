//! The attributes of a primitive of splats.

use glam::{DQuat, DVec3};
use serde_json::Value;

use super::super::turn::Turn;
use super::super::{Splat, Splats, from_coefficient};
use super::EXTENSION;
use super::accessor::Numbers;
use super::buffers::Buffers;
use super::document::{Document, PrimitiveOf};
use super::nodes::Transform;
use pellucid_core::progress::Progress;

/// The highest degree that attributes are named for.
const MAX_DEGREE: u32 = 3;

/// A primitive of splats.
pub(super) struct Primitive<'a> {
    position: Numbers<'a>,
    rotation: Numbers<'a>,
    scale: Numbers<'a>,
    opacity: Numbers<'a>,
    /// Degree after degree, from 0 on.
    harmonics: Vec<Numbers<'a>>,
    pub degree: u32,
    pub count: usize,
    /// `true` if colors are linear.
    pub linear: bool,
    /// Deviations from what is expected.
    pub odd: Vec<String>,
}

impl<'a> Primitive<'a> {
    /// Returns the attributes, all of one length; else the attribute and what is wrong with it.
    pub fn find(document: &Document, buffers: &'a Buffers, primitive: &PrimitiveOf) -> Result<Self, (String, String)> {
        let about = primitive.splats().unwrap_or(&Value::Null);
        let packed = about.get("extensions").and_then(Value::as_object).into_iter().flat_map(|map| map.keys());
        if let Some(name) = packed.into_iter().find(|name| name.contains("compression")) {
            return Err((
                EXTENSION.to_owned(),
                format!("it is compressed by {name}, which is not supported; write it without compression"),
            ));
        }
        let number = |name: &str| primitive.attributes.get(name).copied();
        let find = |name: &str, shape: &str| {
            let found = number(name).ok_or_else(|| "there is no such attribute".to_owned());
            let numbers = found.and_then(|number| Numbers::find(document, buffers, number, shape));
            numbers.map_err(|cause| (format!("attribute {name}"), cause))
        };
        let own = |name: &str, shape: &str| find(&format!("{EXTENSION}:{name}"), shape);
        let coefficient = |degree: u32, at: u32| format!("SH_DEGREE_{degree}_COEF_{at}");
        let has = |degree: &u32| number(&format!("{EXTENSION}:{}", coefficient(*degree, 0))).is_some();
        let degree = (1..=MAX_DEGREE).take_while(has).last().unwrap_or(0);
        let names = (0..=degree).flat_map(|degree| (0..=2 * degree).map(move |at| coefficient(degree, at)));
        let found = Self {
            position: find("POSITION", "VEC3")?,
            rotation: own("ROTATION", "VEC4")?,
            scale: own("SCALE", "VEC3")?,
            opacity: own("OPACITY", "SCALAR")?,
            harmonics: names.map(|name| own(&name, "VEC3")).collect::<Result<_, _>>()?,
            degree,
            count: 0,
            linear: about.get("colorSpace").and_then(Value::as_str) == Some("lin_rec709_display"),
            odd: odd(about),
        };
        let count = found.position.count;
        let others = [&found.rotation, &found.scale, &found.opacity].into_iter().chain(&found.harmonics);
        if let Some(other) = others.map(|numbers| numbers.count).find(|other| *other != count) {
            return Err(("attributes".to_owned(), format!("one has {other} elements, but POSITION has {count}")));
        }
        Ok(Self { count, ..found })
    }

    /// Returns `true` if an extent is below zero, which only logarithms are.
    pub fn has_negative_scale(&self) -> bool {
        (0..self.count).any(|at| self.scale.get::<3>(at).iter().any(|scale| *scale < 0.0))
    }

    /// Returns the splats where a node places them.
    pub fn splats(&self, transform: &Transform, logarithms: bool, progress: &Progress) -> Splats {
        let turn = (transform.rotation != DQuat::IDENTITY).then(|| Turn::new(transform.rotation));
        Splats::gather(self.count, self.degree, progress, |at, harmonics| {
            let own = &self.harmonics[1..];
            harmonics
                .iter_mut()
                .zip(own)
                .for_each(|(color, numbers)| *color = DVec3::from(numbers.get::<3>(at)).as_vec3());
            if let Some(turn) = &turn {
                turn.apply(harmonics);
            }
            let scale = DVec3::from(self.scale.get::<3>(at));
            let scale = if logarithms { DVec3::new(scale.x.exp(), scale.y.exp(), scale.z.exp()) } else { scale };
            let [opacity] = self.opacity.get::<1>(at);
            let base = from_coefficient(self.harmonics[0].get::<3>(at).into());
            let (extents, rotation) = transform.shape(scale, DQuat::from_array(self.rotation.get::<4>(at)));
            Splat {
                center: transform.point(self.position.get::<3>(at).into()),
                extents,
                rotation,
                base,
                linear: self.linear,
                alpha: opacity,
            }
        })
    }
}

/// Properties whose values are unknown.
fn odd(about: &Value) -> Vec<String> {
    let known = [("kernel", &["ellipse"] as &[&str]), ("colorSpace", &["srgb_rec709_display", "lin_rec709_display"])];
    let unknown = known.into_iter().filter_map(|(name, values)| {
        let value = about.get(name)?.as_str()?;
        (!values.contains(&value)).then(|| format!("{name} {value:?} is unknown; read as {:?}", values[0]))
    });
    unknown.collect()
}
