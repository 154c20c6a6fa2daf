//! Well-known text of coordinate reference systems: version 1 (OGC 01-009, and as GDAL and Esri write it) and
//! version 2 (ISO 19162).

use pellucid_core::cloud::crs::{Crs, Unit};

use super::or_of_code;
use super::tree::{self, Node};

const COMPOUND: [&str; 2] = ["COMPD_CS", "COMPOUNDCRS"];
const PROJECTED: [&str; 4] = ["PROJCS", "PROJCRS", "PROJECTEDCRS", "DERIVEDPROJCRS"];
const GEOGRAPHIC: [&str; 3] = ["GEOGCS", "GEOGCRS", "GEOGRAPHICCRS"];
const GEODETIC: [&str; 2] = ["GEODCRS", "GEODETICCRS"];
const OTHERS_IN_LENGTHS: [&str; 4] = ["GEOCCS", "LOCAL_CS", "ENGCRS", "ENGINEERINGCRS"];
const VERTICAL: [&str; 3] = ["VERT_CS", "VERTCRS", "VERTICALCRS"];

/// A kind of unit.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Kind {
    Length,
    Angle,
}

/// Returns the system that a text describes.
pub(super) fn parse(text: &str) -> Option<Crs> {
    let crs = system(&tree::parse(text)?)?;
    Some(Crs { wkt: Some(text.to_owned()), ..crs })
}

fn system(node: &Node) -> Option<Crs> {
    if node.is(&COMPOUND) {
        return Some(compound(node));
    }
    if node.is(&["BOUNDCRS"]) {
        return node.node(&["SOURCECRS"])?.nodes().find_map(system);
    }
    if node.is(&VERTICAL) {
        return Some(Crs { name: name(node), vertical_unit: unit(node, Kind::Length), ..Crs::default() });
    }
    let kind = kind(node)?;
    let stated = unit(node, kind).or_else(|| (kind == Kind::Angle).then(Unit::degree));
    let epsg = epsg(node);
    // Axes of version 2 may have units of their own.
    let third = node.nodes().filter(|node| node.is(&["AXIS"])).nth(2).and_then(|axis| own_unit(axis, Kind::Length));
    let vertical_unit = third.filter(|unit| unit.meters.is_some());
    Some(Crs { name: name(node), unit: or_of_code(stated, epsg), vertical_unit, epsg, wkt: None })
}

/// A horizontal system and a vertical one.
fn compound(node: &Node) -> Crs {
    let mut parts: Vec<Crs> = node.nodes().filter_map(system).collect();
    let vertical_unit = parts.iter().find_map(|part| part.vertical_unit.clone());
    let horizontal = parts.iter().position(|part| part.unit.is_some() || part.epsg.is_some());
    let horizontal = horizontal.map(|at| parts.swap_remove(at)).unwrap_or_default();
    let own = name(node);
    Crs { name: if own.is_empty() { horizontal.name } else { own }, vertical_unit, ..horizontal }
}

/// The kind of the unit of horizontal coordinates; `None` for what is no such system.
fn kind(node: &Node) -> Option<Kind> {
    let is_cartesian =
        || node.node(&["CS"]).and_then(Node::word).is_some_and(|word| word.eq_ignore_ascii_case("Cartesian"));
    if node.is(&GEOGRAPHIC) || node.is(&GEODETIC) && !is_cartesian() {
        return Some(Kind::Angle);
    }
    (node.is(&PROJECTED) || node.is(&GEODETIC) || node.is(&OTHERS_IN_LENGTHS)).then_some(Kind::Length)
}

fn name(node: &Node) -> String {
    node.text().unwrap_or_default().to_owned()
}

/// The code in `AUTHORITY["EPSG","32633"]` or `ID["EPSG",32633]`.
fn epsg(node: &Node) -> Option<u32> {
    let id =
        node.node(&["AUTHORITY", "ID"]).filter(|id| id.text().is_some_and(|of| of.eq_ignore_ascii_case("EPSG")))?;
    let text = id.values.iter().skip(1).find_map(|value| match value {
        tree::Value::Text(text) | tree::Value::Word(text) => text.trim().parse().ok(),
        _ => None,
    });
    // A code is a whole number; the cast is exact below 2³².
    let number = id.number().filter(|code| code.fract() == 0.0 && (0.0..=f64::from(u32::MAX)).contains(code));
    text.or(number.map(|code| code as u32))
}

/// The unit of a system: its own, else that of its first axis.
fn unit(node: &Node, kind: Kind) -> Option<Unit> {
    own_unit(node, kind).or_else(|| own_unit(node.node(&["AXIS"])?, kind))
}

/// The unit that stands in a node itself; `kind` is that of a `UNIT`, which doesn't say.
fn own_unit(node: &Node, kind: Kind) -> Option<Unit> {
    let unit = node.node(&["LENGTHUNIT", "ANGLEUNIT", "UNIT"])?;
    let kind = match unit.keyword.as_str() {
        "LENGTHUNIT" => Kind::Length,
        "ANGLEUNIT" => Kind::Angle,
        _ => kind,
    };
    let (name, size) = (unit.text().unwrap_or_default(), unit.number()?);
    match kind {
        Kind::Length => Unit::length(name, size),
        Kind::Angle => Unit::angle(name, size),
    }
}
