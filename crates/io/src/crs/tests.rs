use super::*;

/// Text of PDAL for NAD83 / Texas South Central in US survey feet, with heights in meters.
const COMPOUND_1: &str = r#"COMPD_CS["NAD83 / Texas South Central (ftUS) + NAVD88",PROJCS["NAD83 / Texas South Central (ftUS)",
  GEOGCS["NAD83",DATUM["North_American_Datum_1983",SPHEROID["GRS 1980",6378137,298.257222101,AUTHORITY["EPSG","7019"]]],
    PRIMEM["Greenwich",0],UNIT["degree",0.0174532925199433,AUTHORITY["EPSG","9122"]],AUTHORITY["EPSG","4269"]],
  PROJECTION["Lambert_Conformal_Conic_2SP"],PARAMETER["false_easting",1968500],
  UNIT["US survey foot",0.304800609601219,AUTHORITY["EPSG","9003"]],AXIS["X",EAST],AXIS["Y",NORTH],
  AUTHORITY["EPSG","2278"]],
VERT_CS["NAVD88 height",VERT_DATUM["North American Vertical Datum 1988",2005],UNIT["metre",1],AXIS["Up",UP]]]"#;

const VERSION_2: &str = r#"PROJCRS["WGS 84 / UTM zone 33N",BASEGEOGCRS["WGS 84",
  DATUM["World ""Geodetic"" System 1984",ELLIPSOID["WGS 84",6378137,298.257223563,LENGTHUNIT["metre",1]]],
  PRIMEM["Greenwich",0,ANGLEUNIT["degree",0.0174532925199433]]],
  CONVERSION["UTM zone 33N",METHOD["Transverse Mercator"],
    PARAMETER["False easting",500,LENGTHUNIT["kilometre",1000],ID["EPSG",8806]]],
  CS[Cartesian,2],AXIS["(E)",east,ORDER[1],LENGTHUNIT["metre",1]],AXIS["(N)",north,ORDER[2],LENGTHUNIT["metre",1]],
  USAGE[SCOPE["unknown"],BBOX[0,12,84,18]],ID["EPSG",32633]]"#;

fn units(crs: &Crs) -> [Option<&str>; 2] {
    [&crs.unit, &crs.vertical_unit].map(|unit| unit.as_ref().map(|unit| unit.name.as_str()))
}

#[test]
fn texts_of_both_versions_name_code_and_units() {
    let crs = parse(COMPOUND_1).unwrap();
    assert_eq!(crs.title(), "NAD83 / Texas South Central (ftUS) + NAVD88 (EPSG:2278)");
    assert_eq!(units(&crs), [Some("US survey foot"), Some("metre")]);
    assert_eq!(crs.unit.unwrap().meters, Some(1200.0 / 3937.0));
    assert_eq!(crs.wkt.as_deref(), Some(COMPOUND_1));
    let crs = parse(&format!(" {VERSION_2}\n\0\0")).unwrap();
    assert_eq!((crs.title().as_str(), units(&crs)), ("WGS 84 / UTM zone 33N (EPSG:32633)", [Some("metre"), None]));
    assert_eq!(crs.height_unit(), Some(&Unit::metre()));
    let both = |horizontal: &str, vertical: &str| format!(r#"COMPOUNDCRS["both",{horizontal},{vertical}]"#);
    for (text, name, wanted) in [
        (r#"LOCAL_CS["site",LOCAL_DATUM["x",0],UNIT["foot",0.3048]]"#.to_owned(), "site", [Some("foot"), None]),
        (r#"GEOGCS["WGS 84",UNIT["degree",0.0174532925199433]]"#.to_owned(), "WGS 84", [Some("degree"), None]),
        (r#"GEOGCRS["WGS 84",CS[ellipsoidal,2]]"#.to_owned(), "WGS 84", [Some("degree"), None]),
        (
            r#"GEOGCRS["3D",CS[ellipsoidal,3],AXIS["lat",north,ANGLEUNIT["degree",0.0174532925199433]],
             AXIS["lon",east,ANGLEUNIT["degree",0.0174532925199433]],AXIS["h",up,LENGTHUNIT["metre",1]]]"#
                .to_owned(),
            "3D",
            [Some("degree"), Some("metre")],
        ),
        (r#"GEODCRS["earth",CS[Cartesian,3],LENGTHUNIT["metre",1]]"#.to_owned(), "earth", [Some("metre"), None]),
        (r#"geoccs("round", unit("metre", 1))"#.to_owned(), "round", [Some("metre"), None]),
        (
            both(VERSION_2, r#"VERTCRS["heights",CS[vertical,1],AXIS["up",up],LENGTHUNIT["foot",0.3048]]"#),
            "both",
            [Some("metre"), Some("foot")],
        ),
        (
            format!(r#"BOUNDCRS[SOURCECRS[{VERSION_2}],TARGETCRS[GEOGCRS["t"]]]"#),
            "WGS 84 / UTM zone 33N",
            [Some("metre"), None],
        ),
        (r#"VERT_CS["heights",UNIT["metre",1]]"#.to_owned(), "heights", [None, Some("metre")]),
        (r#"PROJCS["odd",UNIT["rod",5.0292]]"#.to_owned(), "odd", [Some("rod"), None]),
        // Without a unit the code says it, if it is a known one.
        (r#"PROJCS["bare",AUTHORITY["EPSG","25832"]]"#.to_owned(), "bare", [Some("metre"), None]),
        (r#"PROJCS["bare",AUTHORITY["EPSG","2278"]]"#.to_owned(), "bare", [None, None]),
    ] {
        let crs = parse(&text).unwrap_or_else(|| panic!("{text}"));
        assert_eq!((crs.name.as_str(), units(&crs)), (name, wanted), "{text}");
    }
}

#[test]
fn codes_have_units_only_where_these_are_certain() {
    for (text, code, wanted) in [
        ("EPSG:32633", 32633, [Some("metre"), None]),
        ("epsg:25832+6360", 25832, [Some("metre"), Some("US survey foot")]),
        ("urn:ogc:def:crs:EPSG::4326", 4326, [Some("degree"), None]),
        ("EPSG:2278", 2278, [None, None]),
        ("EPSG:32661", 32661, [None, None]),
    ] {
        let crs = parse(text).unwrap();
        assert_eq!((crs.epsg, units(&crs)), (Some(code), wanted), "{text}");
        assert_eq!(crs.title(), format!("EPSG:{code}"));
    }
}

#[test]
fn hostile_texts_are_no_system() {
    let deep = |depth: usize| "PROJCS[\"a\",".repeat(depth) + "1" + &"]".repeat(depth);
    assert!(parse(&deep(30)).is_some());
    let long = format!("PROJCS[\"{}\"]", "a".repeat(1 << 20));
    for text in [
        &deep(100_000),
        &"[".repeat(60_000),
        &"A[".repeat(30_000),
        &"\"".repeat(60_001),
        &long,
        "",
        "\0",
        "+proj=utm +zone=33",
        "PROJCS",
        "PROJCS[",
        "PROJCS[\"a\"",
        "PROJCS[\"a]",
        "PROJCS[\"a\" \"b\"]",
        "PROJCS[,,]",
        "TOWGS84[1,2]",
        "\"PROJCS\"",
        "EPSG:",
        "EPSG:x",
        "EPSG:99999999999",
        "urn:ogc:def:crs:ü",
    ] {
        assert!(parse(text).is_none(), "{}", &text[..text.len().min(40)]);
    }
    for size in ["NaN", "-1", "0", "1e999", "inf", "metre", ""] {
        let crs = parse(&format!(r#"PROJCS["a",UNIT["metre",{size}{}]]"#, if size.is_empty() { "2" } else { "" }));
        let unit = crs.and_then(|crs| crs.unit);
        assert_eq!(unit.map(|unit| unit.meters), if size.is_empty() { Some(Some(2.0)) } else { None }, "{size}");
    }
    assert!(parse("PROJCS[\"a\",AUTHORITY[\"EPSG\",4.5]]").unwrap().epsg.is_none());
    assert_eq!(parse("PROJCS[\"a\u{1b}[2J\nb\"]").unwrap().name, "a[2Jb");
}

/// A record of keys: each has a key, the record that holds its value, a count, and the value or its place.
fn keys(entries: &[[u16; 4]]) -> Vec<u8> {
    let header = [1, 1, 0, entries.len() as u16];
    [header].iter().chain(entries).flatten().flat_map(|number| number.to_le_bytes()).collect()
}

#[test]
fn keys_name_code_and_units() {
    let text = b"WGS 84 / UTM zone 17N|NAD83(2011) / x|".to_vec();
    let projected =
        [[1024, 0, 1, 1], [1026, 34737, 22, 0], [3072, 0, 1, 32617], [3076, 0, 1, 9001], [4099, 0, 1, 9003]];
    let crs = GeoRecords { keys: keys(&projected), text: text.clone(), ..GeoRecords::default() }.crs().unwrap();
    assert_eq!(crs.title(), "WGS 84 / UTM zone 17N (EPSG:32617)");
    assert_eq!(units(&crs), [Some("metre"), Some("US survey foot")]);
    // Defined by the user: name and size.
    let own = [[1024, 0, 1, 1], [3072, 0, 1, 32767], [3073, 34737, 16, 22], [3076, 0, 1, 32767], [3077, 34736, 1, 1]];
    let numbers = [0.0, 1200.0 / 3937.0].iter().flat_map(|number: &f64| number.to_le_bytes()).collect();
    let crs = GeoRecords { keys: keys(&own), numbers, text }.crs().unwrap();
    assert_eq!((crs.title().as_str(), units(&crs)), ("NAD83(2011) / x", [Some("US survey foot"), None]));
    for (entries, code, wanted) in [
        (&[[1024, 0, 1, 2], [2048, 0, 1, 4269]][..], Some(4269), [Some("degree"), None]),
        (&[[2048, 0, 1, 4326], [4096, 0, 1, 5703]], Some(4326), [Some("degree"), Some("metre")]),
        (&[[1024, 0, 1, 2], [2054, 0, 1, 9105]], None, [Some("grad"), None]),
        (&[[3072, 0, 1, 2278], [3076, 0, 1, 9003]], Some(2278), [Some("US survey foot"), None]),
        (&[[3072, 0, 1, 2278]], Some(2278), [None, None]),
        (&[[3072, 0, 1, 25832]], Some(25832), [Some("metre"), None]),
    ] {
        let crs = GeoRecords { keys: keys(entries), ..GeoRecords::default() }.crs().unwrap();
        assert_eq!((crs.epsg, units(&crs)), (code, wanted), "{entries:?}");
    }
}

#[test]
fn hostile_keys_are_no_system() {
    let whole = [[1026, 34737, 500, 60_000], [3073, 34737, 65_535, 65_535], [3076, 0, 1, 32767], [3077, 34736, 1, 900]];
    let sizes = |size: f64| GeoRecords {
        keys: keys(&[[1024, 0, 1, 1], [3076, 0, 1, 32767], [3077, 34736, 1, 0]]),
        numbers: size.to_le_bytes().to_vec(),
        text: Vec::new(),
    };
    assert_eq!(sizes(0.5).crs().unwrap().unit.unwrap().meters, Some(0.5));
    let bare = |keys: Vec<u8>| GeoRecords { keys, numbers: vec![0; 15], text: b"abc".to_vec() };
    let mut more = keys(&[[3072, 0, 1, 0]]);
    more[6..8].copy_from_slice(&u16::MAX.to_le_bytes());
    for records in [
        GeoRecords::default(),
        bare(keys(&whole)),
        bare(keys(&[])),
        // Private codes.
        bare(keys(&[[3072, 0, 1, 65_535], [1024, 0, 1, 1]])),
        bare(more),
        bare(keys(&[[3072, 0, 1, 32633]])[..15].to_vec()),
        bare(vec![0xff; 3]),
        bare(keys(&[[3072, 34736, 1, 0], [3076, 34737, 1, 0], [1026, 0, 1, 1]])),
        sizes(f64::NAN),
        sizes(-1.0),
        sizes(f64::INFINITY),
    ] {
        assert_eq!(records.crs(), None, "{records:?}");
    }
}
