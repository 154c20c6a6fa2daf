//! The attributes of a point in octree.bin: their types, what they are to a cloud, and their places in a record.

use serde::{Deserialize, Serialize};

pub(crate) use crate::number::NumberType;
use pellucid_core::cloud::gaussians::{MAX_DEGREE, coefficients};
use pellucid_core::cloud::{GPS_TIME, NUMBER_OF_RETURNS, POINT_SOURCE, RETURN_NUMBER};

/// Bytes of a point at most.
const MAX_STRIDE: usize = 1 << 16;

/// Role of an attribute in a cloud.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Role {
    /// Three integers on the grid.
    Position,
    /// Three sRGB-encoded channels.
    Rgb,
    /// A channel of a linear color, 0 to 2; [`Role::Rgb`] in addition to them is theirs, rounded.
    Linear(u8),
    /// Alpha.
    Alpha,
    /// The normal's coordinate along an axis, 0 to 2.
    Normal(u8),
    /// All three coordinates of the normal.
    NormalVector,
    /// The radius.
    Radius,
    /// F.
    Field,
    /// The share of light.
    Lit,
    /// The class.
    Classification,
    /// The intensity.
    Intensity,
    /// A scalar of this name.
    Scalar(String),
    /// Seconds; a scalar of those since the first.
    Time,
    /// All three coordinates of a position that the grid would round.
    Exact,
    /// The standard deviations of a Gaussian along its three axes.
    Extents,
    /// The unit quaternion that turns x, y and z into these axes: x, y, z, w.
    Rotation,
    /// The color of a Gaussian without harmonics of higher degree, not clamped.
    Base,
    /// 1 if the colors of a Gaussian are linear, 0 if they are display values, as without this attribute.
    Linearity,
    /// The harmonics of a Gaussian from degree 1 to this one: red, green and blue of each.
    Harmonics(u8),
    /// The point's place in its source.
    Place,
    /// Nothing that a cloud has.
    Ignored,
}

impl Role {
    /// Returns the role of an attribute by its name, as PotreeConverter writes them.
    pub(crate) fn named(name: &str, kind: NumberType, elements: usize) -> Self {
        let scalar = |name: &str| Self::Scalar(name.to_owned());
        match (name.to_ascii_lowercase().as_str(), elements) {
            ("position" | "position_cartesian", 3) => Self::Position,
            ("rgb" | "rgba", 3 | 4) => Self::Rgb,
            ("normalx", 1) => Self::Normal(0),
            ("normaly", 1) => Self::Normal(1),
            ("normalz", 1) => Self::Normal(2),
            ("normal", 3) => Self::NormalVector,
            ("alpha", 1) => Self::Alpha,
            ("radius", 1) => Self::Radius,
            ("intensity", 1) => Self::Intensity,
            ("classification", 1) if kind == NumberType::Uint8 => Self::Classification,
            ("gps-time", 1) => Self::Time,
            ("return number", 1) => scalar(RETURN_NUMBER),
            ("number of returns", 1) => scalar(NUMBER_OF_RETURNS),
            ("point source id" | "source id", 1) => scalar(POINT_SOURCE),
            (_, 1) if kind != NumberType::Undefined => scalar(name),
            _ => Self::Ignored,
        }
    }

    /// Returns the name of the attribute in metadata.json.
    pub(crate) fn attribute_name(&self) -> &str {
        match self {
            Self::Position => "position",
            Self::Rgb => "rgb",
            Self::Linear(axis) => ["linear_red", "linear_green", "linear_blue"][usize::from(*axis).min(2)],
            Self::Alpha => "alpha",
            // Names that the viewer makes a vector of.
            Self::Normal(axis) => ["NormalX", "NormalY", "NormalZ"][usize::from(*axis).min(2)],
            Self::NormalVector => "normal",
            Self::Radius => "radius",
            Self::Field => "field",
            Self::Lit => "lit",
            Self::Classification => "classification",
            Self::Intensity => "intensity",
            Self::Scalar(name) if name == RETURN_NUMBER => "return number",
            Self::Scalar(name) if name == NUMBER_OF_RETURNS => "number of returns",
            Self::Scalar(name) if name == POINT_SOURCE => "point source id",
            Self::Scalar(name) => name,
            Self::Time => GPS_TIME,
            Self::Exact => "exact_position",
            Self::Extents => "extents",
            Self::Rotation => "rotation",
            Self::Base => "base",
            Self::Linearity => "linearity",
            Self::Harmonics(_) => "harmonics",
            Self::Place => "place",
            Self::Ignored => "",
        }
    }

    /// Returns the number of values that it takes.
    fn elements(&self) -> usize {
        match self {
            Self::Position | Self::Rgb | Self::NormalVector | Self::Exact | Self::Extents | Self::Base => 3,
            Self::Rotation => 4,
            Self::Harmonics(degree) => 3 * coefficients(u32::from(*degree).min(MAX_DEGREE)),
            _ => 1,
        }
    }

    /// Returns `true` if numbers of a type can be it.
    fn takes(&self, kind: NumberType, elements: usize) -> bool {
        match self {
            Self::Position => kind == NumberType::Int32 && elements == 3,
            Self::Rgb => matches!(kind, NumberType::Uint8 | NumberType::Uint16) && matches!(elements, 3 | 4),
            Self::Linear(axis) | Self::Normal(axis) => *axis < 3 && kind == NumberType::Float && elements == 1,
            Self::NormalVector | Self::Extents | Self::Rotation | Self::Base => {
                kind == NumberType::Float && elements == self.elements()
            }
            Self::Exact => matches!(kind, NumberType::Float | NumberType::Double) && elements == 3,
            Self::Harmonics(degree) => {
                (1..=MAX_DEGREE).contains(&u32::from(*degree))
                    && kind == NumberType::Float
                    && elements == self.elements()
            }
            Self::Classification | Self::Linearity => kind == NumberType::Uint8 && elements == 1,
            Self::Ignored => true,
            _ => kind != NumberType::Undefined && elements == 1,
        }
    }
}

/// An attribute of each point.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Attribute {
    /// Name of the attribute.
    pub name: String,
    /// The type of its numbers.
    pub kind: NumberType,
    /// Number of values of the attribute.
    pub elements: usize,
    /// Role of the attribute.
    pub role: Role,
    /// The first of its bytes in a record.
    pub at: usize,
    /// All of its bytes.
    pub bytes: usize,
    /// Factor and summand of its values.
    pub transform: [f64; 2],
}

/// The attributes that make Gaussians of points.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SplatAttributes<'a> {
    pub extents: &'a Attribute,
    pub rotation: &'a Attribute,
    pub base: &'a Attribute,
    /// Spherical harmonics with their degree; `None` for degree 0.
    pub harmonics: Option<(&'a Attribute, u32)>,
    /// [`Role::Linearity`], if any colors may be linear.
    pub linearity: Option<&'a Attribute>,
}

impl SplatAttributes<'_> {
    /// Returns the degree of the harmonics.
    pub fn degree(&self) -> u32 {
        self.harmonics.map_or(0, |(_, degree)| degree)
    }
}

/// Factor and summand of values that are stored as they are.
pub(crate) const AS_STORED: [f64; 2] = [1.0, 0.0];

/// The attributes of a point, one behind the other.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct AttributeLayout {
    /// Attributes in the order of their bytes.
    pub attributes: Vec<Attribute>,
    /// Bytes of a point.
    pub stride: usize,
}

impl AttributeLayout {
    /// Adds an attribute of a role, whose name gets a `_` appended while another one has it.
    pub(crate) fn add(&mut self, role: Role, kind: NumberType) {
        let mut name = role.attribute_name().to_owned();
        while self.attributes.iter().any(|other| other.name == name) {
            name.push('_');
        }
        let (elements, bytes) = (role.elements(), role.elements() * kind.bytes().unwrap_or(0));
        self.attributes.push(Attribute { name, kind, elements, role, at: self.stride, bytes, transform: AS_STORED });
        self.stride += bytes;
    }

    /// Adds an attribute of a file.
    ///
    /// # Errors
    /// Returns a description of the fault of an attribute that can't be read.
    pub(crate) fn add_foreign(&mut self, mut attribute: Attribute, bytes_of_element: usize) -> Result<(), String> {
        let Attribute { kind, elements, bytes, .. } = attribute;
        if kind.bytes().is_some_and(|right| right != bytes_of_element) {
            return Err(format!("its elements have {bytes_of_element} bytes, but those of {kind:?} have another size"));
        }
        if elements.checked_mul(bytes_of_element) != Some(bytes) {
            return Err(format!("{bytes} bytes don't match {elements} elements of {bytes_of_element} bytes"));
        }
        if bytes > MAX_STRIDE || self.stride + bytes > MAX_STRIDE {
            return Err(format!("a point has more than {MAX_STRIDE} bytes"));
        }
        if !attribute.role.takes(kind, elements) {
            return Err(format!("{elements} of type {kind:?} can't be {:?}", attribute.role));
        }
        if self.find(&attribute.role).is_some() {
            attribute.role = Role::Ignored;
        }
        attribute.at = self.stride;
        self.stride += bytes;
        self.attributes.push(attribute);
        Ok(())
    }

    /// Returns the attribute of a role.
    pub(crate) fn find(&self, role: &Role) -> Option<&Attribute> {
        self.attributes.iter().find(|attribute| attribute.role == *role)
    }

    /// Returns the attributes of Gaussians; `None` without any.
    ///
    /// # Errors
    /// Some of them are missing.
    pub(crate) fn splats(&self) -> Result<Option<SplatAttributes<'_>>, String> {
        let harmonics = self.attributes.iter().find_map(|attribute| match attribute.role {
            Role::Harmonics(degree) => Some((attribute, u32::from(degree))),
            _ => None,
        });
        let roles = [Role::Extents, Role::Rotation, Role::Base];
        let found = roles.each_ref().map(|role| self.find(role));
        if let [Some(extents), Some(rotation), Some(base)] = found {
            let linearity = self.find(&Role::Linearity);
            return Ok(Some(SplatAttributes { extents, rotation, base, harmonics, linearity }));
        }
        if harmonics.is_none() && found.iter().all(Option::is_none) {
            return Ok(None);
        }
        let missing = roles.iter().zip(found).filter(|(_, found)| found.is_none());
        let missing: Vec<_> = missing.map(|(role, _)| role.attribute_name()).collect();
        Err(format!("Gaussian splats need extents, rotation and base, but there is no {}", missing.join(" and no ")))
    }

    /// Returns three attributes of one role each, if all are there.
    pub(crate) fn three(&self, role: fn(u8) -> Role) -> Option<[&Attribute; 3]> {
        Some([self.find(&role(0))?, self.find(&role(1))?, self.find(&role(2))?])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_told_apart() {
        let mut layout = AttributeLayout::default();
        layout.add(Role::Position, NumberType::Int32);
        layout.add(Role::Radius, NumberType::Float);
        layout.add(Role::Scalar("radius".to_owned()), NumberType::Float);
        layout.add(Role::Scalar("radius_".to_owned()), NumberType::Float);
        let names: Vec<_> = layout.attributes.iter().map(|attribute| &*attribute.name).collect();
        assert_eq!(names, ["position", "radius", "radius_", "radius__"]);
        assert_eq!((layout.stride, layout.attributes[2].at), (24, 16));
    }

    #[test]
    fn splats_have_all_of_their_attributes() {
        let layout = |roles: &[Role]| {
            let mut layout = AttributeLayout::default();
            roles.iter().for_each(|role| layout.add(role.clone(), NumberType::Float));
            layout
        };
        let all = layout(&[Role::Extents, Role::Rotation, Role::Base, Role::Harmonics(2)]);
        let splats = all.splats().unwrap().unwrap();
        assert_eq!((all.stride, splats.degree()), (4 * (3 + 4 + 3 + 24), 2));
        assert!(layout(&[Role::Alpha]).splats().unwrap().is_none());
        let error = layout(&[Role::Extents, Role::Harmonics(1)]).splats().unwrap_err();
        assert!(error.ends_with("there is no rotation and no base"), "{error}");
    }

    #[test]
    fn sizes_that_lie_are_refused() {
        let attribute = |name: &str, kind, elements, bytes| Attribute {
            name: name.to_owned(),
            kind,
            elements,
            role: Role::named(name, kind, elements),
            at: 0,
            bytes,
            transform: AS_STORED,
        };
        let add = |attribute, size| AttributeLayout::default().add_foreign(attribute, size);
        assert_eq!(add(attribute("position", NumberType::Int32, 3, 12), 4), Ok(()));
        assert!(add(attribute("position", NumberType::Int32, 3, 12), 8).is_err());
        assert!(add(attribute("position", NumberType::Int32, 3, 16), 4).is_err());
        assert!(add(attribute("position", NumberType::Double, 3, 24), 8).is_err());
        assert!(add(attribute("x", NumberType::Undefined, usize::MAX, 12), 16).is_err());
        assert!(add(attribute("x", NumberType::Undefined, 1, 1 << 20), 1 << 20).is_err());
        let harmonics = |degree, elements| {
            let role = Role::Harmonics(degree);
            add(Attribute { role, ..attribute("harmonics", NumberType::Float, elements, 4 * elements) }, 4)
        };
        assert_eq!((harmonics(1, 9), harmonics(4, 72)), (Ok(()), Ok(())));
        for (degree, elements) in [(0, 0), (1, 24), (2, 9), (5, 105), (255, 72)] {
            assert!(harmonics(degree, elements).is_err(), "{elements} numbers of degree {degree}");
        }
        let mut layout = AttributeLayout::default();
        for _ in 0..2 {
            layout.add_foreign(attribute("position", NumberType::Int32, 3, 12), 4).unwrap();
        }
        assert_eq!(layout.attributes[1].role, Role::Ignored, "twice");
    }
}
