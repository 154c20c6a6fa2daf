//! Units of lengths: what `info`, legends and warnings say of a file's coordinate reference system.

use std::path::Path;

use las::{Builder, Point, Vlr, Writer};
use serde_json::{Value, json};

use crate::{device, folder, has_device, inside, run};

/// A LAS file of 400 points that lie 1 apart, 0 to 6 high, with a description of its system.
fn write_las(path: &Path, wkt: &str) {
    let data = wkt.as_bytes().to_vec();
    let user_id = "LASF_Projection".to_owned();
    let mut builder = Builder::from((1, 4));
    builder.vlrs.push(Vlr { user_id, record_id: 2112, description: String::new(), data });
    let mut writer = Writer::from_path(path, builder.into_header().unwrap()).unwrap();
    for i in 0..400 {
        let [x, y, z] = [i % 20, i / 20, i % 7].map(f64::from);
        writer.write_point(Point { x, y, z, ..Point::default() }).unwrap();
    }
    writer.close().unwrap();
}

const FEET: &str = r#"COMPD_CS["Texas + NAVD88",PROJCS["Texas",UNIT["US survey foot",0.304800609601219],
AUTHORITY["EPSG","2278"]],VERT_CS["NAVD88 height",UNIT["metre",1]]]"#;

const METERS: &str = r#"PROJCS["UTM 33N",UNIT["metre",1],AUTHORITY["EPSG","32633"]]"#;

#[test]
fn info_shows_the_system_and_its_units() {
    let folder = folder();
    write_las(&inside(&folder, "feet.las"), FEET);
    write_las(&inside(&folder, "meters.las"), METERS);
    write_las(&inside(&folder, "none.las"), "PROJCS[");
    let text = |file| run(&folder, &["info", file]).1;
    let feet = "\n  crs         Texas + NAVD88 (EPSG:2278)\n  unit        US survey foot (0.3048006096012192 m), heights in metre \
                (1 m)\n";
    assert!(text("feet.las").contains(feet), "{}", text("feet.las"));
    let meters = "\n  crs         UTM 33N (EPSG:32633)\n  unit        metre (1 m)\n";
    assert!(text("meters.las").contains(meters), "{}", text("meters.las"));
    assert!(!text("none.las").contains("crs") && !text("none.las").contains("unit"));

    let (_, text, _) = run(&folder, &["info", "--json", "feet.las", "meters.las", "none.las"]);
    let found: Value = serde_json::from_str(&text).unwrap();
    let (foot, metre) =
        (json!({ "name": "US survey foot", "meters": 1200.0 / 3937.0 }), json!({ "name": "metre", "meters": 1.0 }));
    let wanted = json!({
        "name": "Texas + NAVD88", "epsg": 2278, "unit": foot, "vertical_unit": metre, "wkt": FEET
    });
    assert_eq!(found[0]["crs"], wanted);
    assert_eq!((&found[1]["crs"]["unit"], &found[1]["crs"]["vertical_unit"]), (&metre, &Value::Null));
    assert_eq!(found[2].as_object().unwrap().get("crs"), Some(&Value::Null));
}

#[test]
fn clouds_in_different_units_are_told() {
    if !has_device() {
        return;
    }
    let folder = folder();
    write_las(&inside(&folder, "feet.las"), FEET);
    write_las(&inside(&folder, "meters.las"), METERS);
    let device = device();
    let device: Vec<&str> = device.iter().flat_map(|name| ["--device", name.as_str()]).collect();
    let said = |inputs: &[&str], options: &[&str]| {
        let rest = ["--size", "64x48", "-o", "a.png"];
        let (status, _, stderr) = run(&folder, &[&["render"], inputs, &rest[..], options, &device].concat());
        assert_eq!(status, 0, "{stderr}");
        stderr
    };
    let warning = "warning: feet.las is in US survey foot (0.3048006096012192 m) with heights in metre (1 m), but meters.las is \
                   in metre (1 m): they are drawn as they are, and lengths of the scene have no unit; `scale` of a [[cloud]] \
                   converts one of them\n";
    assert_eq!(said(&["feet.las", "meters.las"], &[]), warning);
    assert_eq!(said(&["feet.las", "meters.las"], &["--host-memory", "64MiB"]), warning);
    assert_eq!(said(&["meters.las", "meters.las"], &[]), "");
}
