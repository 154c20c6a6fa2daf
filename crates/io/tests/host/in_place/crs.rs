//! Coordinate reference systems: what files state is in the cloud that loading gives, and in that of every store.

use std::path::Path;
use std::sync::Arc;

use las::Vlr;
use las::point::Format;
use pellucid_core::cloud::crs::{Crs, Unit};
use pellucid_core::cloud::field::Field;
use pellucid_core::cloud::{Cloud, Prepared};
use pellucid_core::progress::Progress;
use pellucid_io::store::build::{Settings, build};
use pellucid_io::store::{Copc, Ept, LasPieces, Octree, Store};
use pellucid_io::{LasColumns, ply};
use serde_json::{Value, json};
use tempfile::tempdir;

use super::load;
use super::make_copc::make_with;
use super::make_ept::{self, Tiles};
use crate::io::e57::{plain, write_with};
use crate::io::las::{builder, point, sample, write};

/// Feet of the United States, heights in meters.
const COMPOUND: &str = r#"COMPD_CS["Texas + NAVD88",PROJCS["Texas",GEOGCS["NAD83",UNIT["degree",0.0174532925199433]],
UNIT["US survey foot",0.304800609601219],AUTHORITY["EPSG","2278"]],VERT_CS["NAVD88 height",UNIT["metre",1]]]"#;

const UTM: &str = r#"PROJCRS["UTM 33N",BASEGEOGCRS["WGS 84"],CS[Cartesian,2],AXIS["(E)",east,LENGTHUNIT["metre",1]],
AXIS["(N)",north,LENGTHUNIT["metre",1]],ID["EPSG",32633]]"#;

fn record(record_id: u16, data: impl Into<Vec<u8>>) -> Vlr {
    Vlr { user_id: "LASF_Projection".to_owned(), record_id, description: String::new(), data: data.into() }
}

fn text(wkt: &str) -> Vlr {
    record(2112, format!("{wkt}\0\0"))
}

/// A record of GeoTIFF keys with their values in it.
fn keys(entries: &[[u16; 2]]) -> Vlr {
    let header = [1, 1, 0, entries.len() as u16];
    let entries = entries.iter().flat_map(|[key, value]| [*key, 0, 1, *value]);
    record(34735, header.into_iter().chain(entries).flat_map(u16::to_le_bytes).collect::<Vec<_>>())
}

/// A file with records; `has_bit` says that the text counts.
fn las(vlrs: Vec<Vlr>, evlrs: Vec<Vlr>, has_bit: bool) -> Vec<u8> {
    let mut builder = builder(4, 1, false);
    (builder.vlrs, builder.evlrs) = (vlrs, evlrs);
    let mut bytes = write(builder, (0..30).map(|index| point(&Format::new(1).unwrap(), index)));
    bytes[6] = bytes[6] & !(1 << 4) | u8::from(has_bit) << 4;
    bytes
}

fn loaded(name: &str, bytes: &[u8]) -> Option<Arc<Crs>> {
    let folder = tempdir().unwrap();
    let path = folder.path().join(name);
    std::fs::write(&path, bytes).unwrap();
    let cloud = load(&path, LasColumns::default()).unwrap();
    if name.ends_with("las") {
        let store = LasPieces::open(&path, LasColumns::default()).unwrap();
        assert_eq!((&store.summary().like.crs, &store.read(0).unwrap().cloud.crs), (&cloud.crs, &cloud.crs));
    }
    cloud.crs
}

/// Title and units.
fn facts(crs: Option<&Arc<Crs>>) -> (String, [Option<&str>; 2]) {
    let Some(crs) = crs else { return (String::new(), [None; 2]) };
    let name = |unit: &'_ Option<Unit>| unit.as_ref().map(|unit| unit.name.clone().leak() as &str);
    (crs.title(), [name(&crs.unit), name(&crs.vertical_unit)])
}

#[test]
fn records_of_las_name_the_system() {
    let meters = || keys(&[[1024, 1], [3072, 32617], [3076, 9001]]);
    let feet = || keys(&[[1024, 1], [3072, 2278], [3076, 9003]]);
    let (utm, texas) = (("UTM 33N (EPSG:32633)", [Some("metre"), None]), "Texas + NAVD88 (EPSG:2278)");
    let both = [Some("US survey foot"), Some("metre")];
    for (vlrs, evlrs, has_bit, wanted) in [
        (vec![meters()], vec![], false, ("EPSG:32617", [Some("metre"), None])),
        (vec![feet()], vec![], false, ("EPSG:2278", [Some("US survey foot"), None])),
        (vec![text(COMPOUND)], vec![], true, (texas, both)),
        (vec![], vec![text(COMPOUND)], true, (texas, both)),
        (vec![], vec![text(UTM)], false, utm),
        (vec![], vec![meters()], true, ("EPSG:32617", [Some("metre"), None])),
        // Where both are there, the header says which counts.
        (vec![feet(), text(UTM)], vec![], true, utm),
        (vec![text(UTM), feet()], vec![], false, ("EPSG:2278", [Some("US survey foot"), None])),
        // Records that can't be read are no system.
        (vec![text("PROJCS[\"cut"), feet()], vec![], true, ("EPSG:2278", [Some("US survey foot"), None])),
        (vec![text(&"A[".repeat(30_000))], vec![], true, ("", [None; 2])),
        (vec![record(2112, [0xff; 80])], vec![], true, ("", [None; 2])),
        (vec![record(34735, [0xff; 80]), record(34736, [0xff; 7])], vec![], false, ("", [None; 2])),
        (vec![], vec![], false, ("", [None; 2])),
    ] {
        let crs = loaded("a.las", &las(vlrs.clone(), evlrs, has_bit));
        assert_eq!(facts(crs.as_ref()), (wanted.0.to_owned(), wanted.1), "{vlrs:?}");
    }
}

#[test]
fn the_metadata_of_e57_name_the_system() {
    let with = |metadata: &str| {
        let element = format!("<coordinateMetadata type=\"String\"><![CDATA[{metadata}]]></coordinateMetadata>");
        let change = |xml: String| xml.replace("</e57Root>", &format!("{element}</e57Root>"));
        loaded("a.e57", &write_with(vec![plain([[1.0, 2.0, 3.0]])], change))
    };
    for (metadata, title, units) in [
        ("EPSG:25832", "EPSG:25832", [Some("metre"), None]),
        (COMPOUND, "Texas + NAVD88 (EPSG:2278)", [Some("US survey foot"), Some("metre")]),
        (UTM, "UTM 33N (EPSG:32633)", [Some("metre"), None]),
        ("a site of ours", "", [None; 2]),
        ("PROJCS[\"a\",UNIT[\"m\",NaN]]", "a", [None; 2]),
    ] {
        assert_eq!(facts(with(metadata).as_ref()), (title.to_owned(), units), "{metadata}");
    }
}

#[test]
fn copc_files_have_the_system_of_their_records() {
    let folder = tempdir().unwrap();
    let path = folder.path().join("a.copc.laz");
    std::fs::write(&path, make_with(7, 300, vec![text(UTM)]).bytes).unwrap();
    let store = Copc::open(&path, LasColumns::default()).unwrap();
    let wanted = ("UTM 33N (EPSG:32633)".to_owned(), [Some("metre"), None]);
    assert_eq!(facts(store.summary().like.crs.as_ref()), wanted);
    assert_eq!(facts(load(&path, LasColumns::default()).unwrap().crs.as_ref()), wanted);
    assert_eq!(facts(store.read(0).unwrap().cloud.crs.as_ref()), wanted);
}

#[test]
fn the_description_of_ept_names_the_system() {
    let folder = tempdir().unwrap();
    let file = folder.path().join("from.las");
    std::fs::write(&file, sample(2, 3, false, 90)).unwrap();
    let ept = folder.path().join("ept");
    make_ept::make(&ept, &file, Tiles::Binary, true);
    let description: Value = serde_json::from_slice(&std::fs::read(ept.join("ept.json")).unwrap()).unwrap();
    let utm = ("UTM 33N (EPSG:32633)", [Some("metre"), None]);
    for (srs, (title, units)) in [
        (json!({ "authority": "EPSG", "horizontal": "32617", "wkt": "" }), ("EPSG:32617", [Some("metre"), None])),
        (
            json!({ "authority": "EPSG", "horizontal": 2278, "vertical": 6360 }),
            ("EPSG:2278", [None, Some("US survey foot")]),
        ),
        (json!({ "authority": "EPSG", "horizontal": "1", "wkt": UTM }), utm),
        (
            json!({ "authority": "EPSG", "horizontal": "32633", "vertical": "5703", "wkt": UTM }),
            ("UTM 33N (EPSG:32633)", [Some("metre"), Some("metre")]),
        ),
        (json!({ "authority": "ESRI", "horizontal": "32617" }), ("", [None; 2])),
        (json!({ "wkt": { "a": 1 }, "horizontal": [1] }), ("", [None; 2])),
        (json!({}), ("", [None; 2])),
        (json!("none"), ("", [None; 2])),
        (json!(null), ("", [None; 2])),
    ] {
        let mut with = description.clone();
        with["srs"] = srs.clone();
        std::fs::write(ept.join("ept.json"), with.to_string()).unwrap();
        let store = Ept::open(&ept, LasColumns::default()).unwrap();
        assert_eq!(facts(store.summary().like.crs.as_ref()), (title.to_owned(), units), "{srs}");
        assert!((0..store.nodes().len()).all(|node| store.read(node).unwrap().cloud.crs == store.summary().like.crs));
    }
}

/// Builds a store of LAS files with these texts, and returns its system and what was said.
fn built(folder: &Path, texts: &[&str]) -> (Option<Arc<Crs>>, Vec<String>) {
    let stores = texts.iter().enumerate().map(|(number, wkt)| {
        let path = folder.join(format!("{number}.las"));
        let vlrs = if wkt.is_empty() { vec![] } else { vec![text(wkt)] };
        std::fs::write(&path, las(vlrs, vec![], true)).unwrap();
        Box::new(LasPieces::open(&path, LasColumns::default()).unwrap()) as Box<dyn Store>
    });
    let stores: Vec<_> = stores.collect();
    let target = folder.join("store");
    let settings = Settings { node_points: 100, host_memory: 1 << 26 };
    let notes = build(&stores, &target, &settings, &Progress::hidden()).unwrap().notes;
    let store = Octree::open(&target).unwrap();
    assert_eq!(store.read(0).unwrap().cloud.crs, store.summary().like.crs);
    (store.summary().like.crs.clone(), notes)
}

#[test]
fn stores_keep_the_system_that_all_inputs_share() {
    let folder = tempdir().unwrap();
    let texas = ("Texas + NAVD88 (EPSG:2278)".to_owned(), [Some("US survey foot"), Some("metre")]);
    for texts in [&[COMPOUND][..], &[COMPOUND, COMPOUND], &["", COMPOUND]] {
        let (crs, notes) = built(folder.path(), texts);
        assert_eq!((facts(crs.as_ref()), notes), (texas.clone(), Vec::<String>::new()));
        assert_eq!(crs.unwrap().wkt.as_deref(), Some(COMPOUND));
    }
    let (crs, notes) = built(folder.path(), &[COMPOUND, UTM]);
    assert_eq!(crs, None);
    assert!(notes[0].contains("0.las is in Texas + NAVD88 (EPSG:2278), but "), "{notes:?}");
    assert!(notes[0].contains("1.las in UTM 33N (EPSG:32633)"), "{notes:?}");
}

#[test]
fn what_others_claim_of_units_in_a_store_is_checked() {
    let folder = tempdir().unwrap();
    built(folder.path(), &[UTM]);
    let path = folder.path().join("store/metadata.json");
    let mut metadata: Value = serde_json::from_slice(&std::fs::read(&path).unwrap()).unwrap();
    metadata["pellucid"]["crs"] = json!({ "name": "a\u{1b}b", "unit": { "name": "m", "meters": -1 }, "vertical_unit": { "name": "x", "meters": 2 } });
    std::fs::write(&path, metadata.to_string()).unwrap();
    let store = Octree::open(&folder.path().join("store")).unwrap();
    assert_eq!(facts(store.summary().like.crs.as_ref()), ("ab".to_owned(), [None, Some("x")]));
    // Other programs have a field of their own.
    if let Value::Object(object) = &mut metadata {
        object.remove("pellucid");
        object.insert("projection".to_owned(), UTM.into());
    }
    std::fs::write(&path, metadata.to_string()).unwrap();
    let crs = Octree::open(&folder.path().join("store")).unwrap().summary().like.crs.clone();
    assert_eq!(facts(crs.as_ref()).0, "UTM 33N (EPSG:32633)");
}

#[test]
fn prepared_files_keep_the_system() {
    let folder = tempdir().unwrap();
    let path = folder.path().join("a.ply");
    let from = folder.path().join("a.las");
    std::fs::write(&from, las(vec![text(COMPOUND)], vec![], true)).unwrap();
    let cloud = load(&from, LasColumns::default()).unwrap();
    let values = vec![0.5; cloud.len()];
    let prepared = Prepared {
        neighbors: 8,
        radius_cap: 0.0,
        estimated_radii: false,
        field: Field::Intensity,
        values,
        shadows: None,
    };
    let cloud = Cloud { radii: Some(vec![1.0; cloud.len()]), prepared: Some(prepared), ..cloud };
    ply::write_prepared(&path, &cloud).unwrap();
    let again = load(&path, LasColumns::default()).unwrap();
    assert!(again.prepared.is_some() && cloud.crs.is_some());
    assert_eq!(again.crs, cloud.crs);
}
