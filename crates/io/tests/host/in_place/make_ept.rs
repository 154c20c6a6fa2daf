//! EPT folders, made here of LAS and LAZ files.

use std::collections::BTreeMap;
use std::path::Path;

use las::{Builder, Header, Point, Reader, Writer};
use ruzstd::encoding::{CompressionLevel, compress_to_vec};
use serde_json::{Map, Value, json};

type Key = [u32; 4];

/// Formats of the tiles.
#[derive(Clone, Copy, PartialEq)]
pub enum Tiles {
    Laszip,
    Binary,
    Zstandard,
}

/// Makes a folder of the points of a file: a third of them in the root, another one level below, the rest two levels
/// below. Nodes of the deepest level stand in hierarchy files of their own.
pub fn make(folder: &Path, file: &Path, tiles: Tiles, statistics: bool) {
    let mut reader = Reader::from_path(file).unwrap();
    let header = reader.header().clone();
    let points: Vec<Point> = reader.read_all().unwrap().points().map(Result::unwrap).collect();
    let bounds = header.bounds();
    let min = [bounds.min.x, bounds.min.y, bounds.min.z];
    let max = [bounds.max.x, bounds.max.y, bounds.max.z];
    let side = (0..3).map(|axis| max[axis] - min[axis]).fold(0.0, f64::max) * 1.01 + 0.01;
    let mut nodes: BTreeMap<Key, Vec<Point>> = BTreeMap::new();
    for (index, point) in points.iter().enumerate() {
        let level = index as u32 % 3;
        let place = |at: f64, min: f64| ((at - min) / side * f64::from(1u32 << level)) as u32;
        let key = [level, place(point.x, min[0]), place(point.y, min[1]), place(point.z, min[2])];
        nodes.entry(key).or_default().push(point.clone());
    }
    std::fs::create_dir_all(folder.join("ept-data")).unwrap();
    std::fs::create_dir_all(folder.join("ept-hierarchy")).unwrap();
    for (key, points) in &nodes {
        let path = folder.join("ept-data").join(name(key));
        match tiles {
            Tiles::Laszip => write_laz(&path.with_extension("laz"), &header, points),
            Tiles::Binary => std::fs::write(path.with_extension("bin"), rows(&header, points)).unwrap(),
            Tiles::Zstandard => {
                let compressed = compress_to_vec(&*rows(&header, points), CompressionLevel::Fastest);
                std::fs::write(path.with_extension("zst"), compressed).unwrap();
            }
        }
    }
    write_hierarchy(folder, &nodes);
    let description = json!({
        "bounds": [min[0], min[1], min[2], min[0] + side, min[1] + side, min[2] + side],
        "boundsConforming": [min[0], min[1], min[2], max[0], max[1], max[2]],
        "dataType": match tiles {
            Tiles::Laszip => "laszip",
            Tiles::Binary => "binary",
            Tiles::Zstandard => "zstandard",
        },
        "hierarchyType": "json",
        "points": points.len(),
        "schema": schema(&header, &points, statistics),
        "span": 128,
        "srs": {},
        "version": "1.0.0",
    });
    std::fs::write(folder.join("ept.json"), description.to_string()).unwrap();
}

fn name([level, x, y, z]: &Key) -> String {
    format!("{level}-{x}-{y}-{z}")
}

fn write_hierarchy(folder: &Path, nodes: &BTreeMap<Key, Vec<Point>>) {
    let mut root = Map::new();
    for (key, points) in nodes {
        let count = if key[0] < 2 { points.len() as i64 } else { -1 };
        root.insert(name(key), count.into());
        if count == -1 {
            let own = json!({ name(key): points.len(), format!("3-{}-{}-{}", 2 * key[1], 2 * key[2], 2 * key[3]): 0 });
            std::fs::write(folder.join("ept-hierarchy").join(name(key) + ".json"), own.to_string()).unwrap();
        }
    }
    std::fs::write(folder.join("ept-hierarchy/0-0-0-0.json"), Value::from(root).to_string()).unwrap();
}

fn write_laz(path: &Path, header: &Header, points: &[Point]) {
    let mut builder = Builder::from((1, 4));
    builder.point_format = *header.point_format();
    builder.point_format.is_compressed = true;
    builder.transforms = *header.transforms();
    let mut writer = Writer::from_path(path, builder.into_header().unwrap()).unwrap();
    points.iter().for_each(|point| writer.write_point(point.clone()).unwrap());
    writer.close().unwrap();
}

/// Name, type, bytes and value of a dimension.
type Dimension = (&'static str, &'static str, usize, fn(&Point) -> f64);

/// The dimensions behind the coordinates.
fn dimensions(header: &Header) -> Vec<Dimension> {
    let format = header.point_format();
    let mut all: Vec<Dimension> = vec![
        ("Intensity", "unsigned", 2, |p| p.intensity.into()),
        ("ReturnNumber", "unsigned", 1, |p| p.return_number.into()),
        ("NumberOfReturns", "unsigned", 1, |p| p.number_of_returns.into()),
        ("ScanAngleRank", "float", 4, |p| p.scan_angle.into()),
        ("Classification", "unsigned", 1, |p| u8::from(p.classification).into()),
        ("PointSourceId", "unsigned", 2, |p| p.point_source_id.into()),
        ("Withheld", "unsigned", 1, |p| p.is_withheld.into()),
    ];
    if format.has_gps_time {
        all.push(("GpsTime", "float", 8, |p| p.gps_time.unwrap_or_default()));
    }
    if format.has_color {
        all.push(("Red", "unsigned", 2, |p| p.color.unwrap_or_default().red.into()));
        all.push(("Green", "unsigned", 2, |p| p.color.unwrap_or_default().green.into()));
        all.push(("Blue", "unsigned", 2, |p| p.color.unwrap_or_default().blue.into()));
    }
    all
}

fn schema(header: &Header, points: &[Point], statistics: bool) -> Vec<Value> {
    let transforms = header.transforms();
    let coordinates = [("X", transforms.x), ("Y", transforms.y), ("Z", transforms.z)].map(|(name, transform)| {
        json!({ "name": name, "type": "signed", "size": 4, "scale": transform.scale, "offset": transform.offset })
    });
    let others = dimensions(header).into_iter().map(|(name, kind, size, value)| {
        let mut dimension = json!({ "name": name, "type": kind, "size": size });
        if statistics {
            dimension["minimum"] = points.iter().map(value).fold(f64::INFINITY, f64::min).into();
            dimension["maximum"] = points.iter().map(value).fold(f64::NEG_INFINITY, f64::max).into();
        }
        dimension
    });
    coordinates.into_iter().chain(others).collect()
}

fn rows(header: &Header, points: &[Point]) -> Vec<u8> {
    let transforms = header.transforms();
    let mut bytes = Vec::new();
    for point in points {
        for (at, transform) in [(point.x, transforms.x), (point.y, transforms.y), (point.z, transforms.z)] {
            bytes.extend((((at - transform.offset) / transform.scale).round() as i32).to_le_bytes());
        }
        for (_, kind, size, value) in dimensions(header) {
            let value = value(point);
            match (kind, size) {
                ("float", 4) => bytes.extend((value as f32).to_le_bytes()),
                ("float", _) => bytes.extend(value.to_le_bytes()),
                _ => bytes.extend(&(value as u64).to_le_bytes()[..size]),
            }
        }
    }
    bytes
}
