//! Polygons from GeoJSON files. Coordinates other than x and y are left out.

use std::fs::File;
use std::io::Read as _;
use std::path::Path;

use geojson::{GeoJson, GeometryValue};

use super::Error;

/// The corners of a polygon's outline and of its holes, ring by ring.
pub type Rings = Vec<Vec<[f64; 2]>>;

/// A larger file is something else than the outline of an area.
const MAX_BYTES: u64 = 64 << 20;

/// Reads all polygons of a file.
///
/// # Errors
/// The file is missing, too large, no GeoJSON, or has no polygon.
pub fn read(path: &Path) -> Result<Vec<Rings>, Error> {
    let failed = Error::opening(path);
    let malformed = |cause: String| Error::malformed(path, "polygons", cause);
    let mut text = String::new();
    File::open(path).map_err(&failed)?.take(MAX_BYTES + 1).read_to_string(&mut text).map_err(&failed)?;
    if text.len() as u64 > MAX_BYTES {
        return Err(malformed(format!("the file is larger than {} MiB", MAX_BYTES >> 20)));
    }
    let polygons = parse(&text).map_err(malformed)?;
    if polygons.is_empty() { Err(malformed("no polygon in the file".to_owned())) } else { Ok(polygons) }
}

/// All polygons of a text, or the defect as a sentence.
fn parse(text: &str) -> Result<Vec<Rings>, String> {
    let json: GeoJson = text.parse().map_err(|error: geojson::Error| format!("not GeoJSON: {error}"))?;
    let mut polygons = Vec::new();
    let geometries = match json {
        GeoJson::Geometry(geometry) => vec![geometry],
        GeoJson::Feature(feature) => feature.geometry.into_iter().collect(),
        GeoJson::FeatureCollection(all) => all.features.into_iter().filter_map(|feature| feature.geometry).collect(),
    };
    for geometry in geometries {
        collect(geometry.value, &mut polygons)?;
    }
    Ok(polygons)
}

/// Adds the polygons of a geometry and of those inside it. The parser limits how deep they lie.
fn collect(geometry: GeometryValue, polygons: &mut Vec<Rings>) -> Result<(), String> {
    match geometry {
        GeometryValue::Polygon { coordinates } => polygons.push(rings(&coordinates)?),
        GeometryValue::MultiPolygon { coordinates } => {
            for polygon in &coordinates {
                polygons.push(rings(polygon)?);
            }
        }
        GeometryValue::GeometryCollection { geometries } => {
            for geometry in geometries {
                collect(geometry.value, polygons)?;
            }
        }
        _ => {}
    }
    Ok(())
}

fn rings(polygon: &[Vec<geojson::Position>]) -> Result<Rings, String> {
    let corner = |position: &geojson::Position| match position.as_slice() {
        [x, y, ..] if x.is_finite() && y.is_finite() => Ok([*x, *y]),
        other => Err(format!("a corner must have two finite coordinates, found {other:?}")),
    };
    polygon.iter().map(|ring| ring.iter().map(corner).collect()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const TRIANGLE: &str = "[[[0, 0], [4, 0, 7.5], [0, 4], [0, 0]]]";

    #[test]
    fn polygons_are_found_wherever_they_stand() {
        let triangle = vec![vec![[0.0, 0.0], [4.0, 0.0], [0.0, 4.0], [0.0, 0.0]]];
        let polygon = format!(r#"{{"type": "Polygon", "coordinates": {TRIANGLE}}}"#);
        let point = r#"{"type": "Point", "coordinates": [1, 2]}"#;
        let feature = |geometry: &str| format!(r#"{{"type": "Feature", "properties": null, "geometry": {geometry}}}"#);
        for (text, count) in [
            (polygon.clone(), 1),
            (format!(r#"{{"type": "MultiPolygon", "coordinates": [{TRIANGLE}, {TRIANGLE}]}}"#), 2),
            (format!(r#"{{"type": "GeometryCollection", "geometries": [{point}, {polygon}]}}"#), 1),
            (feature(&polygon), 1),
            (feature("null"), 0),
            (format!(r#"{{"type": "FeatureCollection", "features": [{}, {}]}}"#, feature(point), feature(&polygon)), 1),
        ] {
            assert_eq!(parse(&text), Ok(vec![triangle.clone(); count]), "{text}");
        }
    }

    #[test]
    fn other_texts_are_refused_with_a_reason() {
        let corner = r#"{"type": "Polygon", "coordinates": [[[0], [1, 1], [2, 0]]]}"#;
        for text in ["", "{}", "[1, 2]", r#"{"type": "Polygon"}"#, corner, &"[".repeat(100_000)] {
            let reason = parse(text).unwrap_err();
            assert!(reason.starts_with("not GeoJSON: ") || reason.starts_with("a corner must have"), "{reason}");
        }
    }
}
