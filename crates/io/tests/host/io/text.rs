//! Tables, PTS and PTX by hand: every delimiter, every kind of header, every oddity.

use glam::{DVec3, Vec3};
use pellucid_core::cloud::{Cloud, UpAxis};
use pellucid_core::color::decode_srgb;
use pellucid_core::progress::Progress;
use pellucid_io::{ColumnNames, Error, Hints, load_with};

use super::{Folder, assert_refused, load_bytes};

/// Loads a text file with names for its columns.
fn named(name: &str, text: &str, columns: &str) -> Result<Cloud, Error> {
    let path = Folder::new();
    let path = (path.file(name, text), path);
    let columns = ColumnNames::parse(columns).unwrap();
    load_with(&path.0, Hints { columns: Some(&columns), ..Hints::default() }, &Progress::hidden())
}

fn points(cloud: &Cloud) -> Vec<[f64; 3]> {
    cloud.positions.iter().map(DVec3::to_array).collect()
}

const TWO: [[f64; 3]; 2] = [[1.0, 2.5, -3.0], [400.0, 5.0, 6e3]];

#[test]
fn delimiters_and_line_ends() {
    for text in [
        "1 2.5 -3\n400 5 6e3\n",
        "  1   2.5 -3   \n\n\n400\t5 6e3",
        "1\t2.5\t-3\r\n400\t5\t6e3\r\n",
        "1,2.5,-3\n400, 5 ,6e3",
        "1;2.5;-3;\n400;5;6e3;\n",
        "\"1\",\"2.5\",\"-3\"\n400,5,6e3\n",
        "# a remark\n1 2.5 -3\n// another\n400 5 6e3 \n# the end",
        "\u{feff}1 2.5 -3\n400 5 6e3\n",
        "2\n1 2.5 -3\n400 5 6e3\n",
        "X Y Z\n1 2.5 -3\n400 5 6e3\n",
        "\"X\", \"Y\", \"Z\"\n1, 2.5, -3\n400, 5, 6e3\n",
        "\u{feff}x;y;z\r\n1;2.5;-3\r\n400;5;6e3\r\n",
        "2\nx y z\n1 2.5 -3\n400 5 6e3\n",
    ] {
        for name in ["a.xyz", "a.TXT", "a.csv", "a.asc"] {
            let cloud = load_bytes(name, text).unwrap_or_else(|e| panic!("{text:?}: {e}"));
            assert_eq!(points(&cloud), TWO, "{text:?}");
            let columns = Cloud { positions: cloud.positions.clone(), up: UpAxis::Z, ..Cloud::default() };
            assert_eq!(cloud, columns, "{text:?}: nothing else");
        }
    }
    // Without an extension it takes numbers in the first line.
    assert_eq!(points(&load_bytes("points", "# x\n1 2.5 -3\n400 5 6e3").unwrap()), TWO);
    assert_eq!(points(&load_bytes("points", "2\n1 2.5 -3\n400 5 6e3").unwrap()), TWO);
    let long = format!("1 2.5 -3\n400 5 6e3\n{}", "7 8 9\n".repeat(1000));
    assert_eq!(load_bytes("points.dat", long).unwrap().len(), 1002);
    assert_refused("points", "1 2\n", &["known format"]);
    assert_refused("points", "a b c\n1 2 3\n", &["known format"]);
}

#[test]
fn headers_name_columns() {
    let text =
        "X,Y,Z,Red,green,BLUE,a,I,Nx,Ny,Nz,Radius,class,\"my, scalar\"\n1,2,3,255,0,51,0.5,77,0,0,2,0.25,6,1.5\n";
    let cloud = load_bytes("a.csv", text).unwrap();
    assert_eq!(cloud.colors.unwrap(), [Vec3::new(1.0, 0.0, decode_srgb(0.2))]);
    assert_eq!((cloud.alphas.unwrap(), cloud.intensity.unwrap()), (vec![0.5], vec![77.0]));
    assert_eq!((cloud.normals.unwrap(), cloud.radii.unwrap()), (vec![Vec3::Z], vec![0.25]));
    assert_eq!(cloud.classification.unwrap(), [6]);
    assert_eq!(cloud.scalars, [("my, scalar".to_owned(), vec![1.5])]);

    // In a comment right before the points, as CloudCompare does.
    let cloud = load_bytes("a.txt", "# old\n//X Y Z R G B height\n1 2 3 0 0 255 9\n").unwrap();
    assert_eq!((cloud.colors.unwrap()[0], cloud.scalars[0].0.as_str()), (Vec3::Z, "height"));
    // A comment of as many words that names no coordinates is none.
    assert!(load_bytes("a.txt", "# one two three\n1 2 3\n").unwrap().scalars.is_empty());

    // The first of two equal names is the one; columns without a name have their number.
    let cloud = load_bytes("a.txt", "x,y,z,X,t,t,\"\",u\n1,2,3,4,5,6,7,8\n").unwrap();
    let names: Vec<_> = cloud.scalars.iter().map(|(name, values)| (name.as_str(), values[0])).collect();
    assert_eq!(points(&cloud), [[1.0, 2.0, 3.0]]);
    assert_eq!(names, [("X_2", 4.0), ("t", 5.0), ("t_2", 6.0), ("column_7", 7.0), ("u", 8.0)]);
    // In any order.
    assert_eq!(points(&load_bytes("a.txt", "z y x\n3 2 1\n").unwrap()), [[1.0, 2.0, 3.0]]);
}

#[test]
fn columns_without_names_go_by_their_values() {
    let load = |text: &str| load_bytes("a.xyz", text).unwrap();
    assert_eq!(load("1 1 1 25\n2 2 2 30\n").intensity.unwrap(), [25.0, 30.0]);
    let cloud = load("1 2 3 117.0 73.0 49.0 255.0\n1 2 3 0 0 255 255\n");
    assert_eq!((cloud.colors.unwrap()[1], cloud.scalars[0].0.as_str()), (Vec3::Z, "column_7"));
    let cloud = load("1 2 3 -12 255 0 0\n");
    assert_eq!((cloud.intensity.unwrap(), cloud.colors.unwrap()), (vec![-12.0], vec![Vec3::X]));
    let cloud = load("1 2 3 0.6 0 0.8\n1 2 3 0 0 0\n");
    assert_eq!((cloud.colors, cloud.normals.unwrap()), (None, vec![Vec3::new(0.6, 0.0, 0.8), Vec3::ZERO]));
    // The range of colors is that of the whole file.
    let wide = load("1 2 3 255 0 0\n1 2 3 65535 0 0\n").colors.unwrap();
    assert_eq!(wide, [Vec3::new(decode_srgb(255.0 / 65535.0), 0.0, 0.0), Vec3::X]);
    assert_eq!(load("1 2 3 0.5 0.5 0\n").colors.unwrap()[0].x, decode_srgb(0.5));
    assert_eq!(load("1 2 3 0 0 0\n").colors, None, "all 0, as nobody would store");
}

#[test]
fn columns_that_the_user_names() {
    let text = "1 2 3 9 255 0 0\n";
    let cloud = named("a.xyz", text, "z, y, x, -, B, G, R").unwrap();
    assert_eq!((points(&cloud), cloud.colors.unwrap()), (vec![[3.0, 2.0, 1.0]], vec![Vec3::Z]));
    assert!(cloud.intensity.is_none() && cloud.scalars.is_empty());
    // They overrule a header, and what a scanner would have written.
    let cloud = named("a.csv", "easting,northing,height\n1,2,3\n", "x,y,z").unwrap();
    assert_eq!(points(&cloud), [[1.0, 2.0, 3.0]]);
    let cloud = named("a.pts", "1\n1 2 3 9 255 0 0\n", "x,y,z,r,t,g,b").unwrap();
    assert_eq!((cloud.intensity, cloud.scalars[0].1[0]), (None, 255.0));
    let message = named("a.xyz", text, "x,y,z").unwrap_err().to_string();
    assert!(
        message.contains("line 1: 7 values, but names are given for 3 columns (name a column to skip `-`)"),
        "{message}"
    );
    // A column to skip may hold the names of points, with or without a header, in the first line too.
    for text in ["P1,1,2,3\nP2,4,5,6\n", "ID,X,Y,Z\nP1,1,2,3\n1.5,4,5,6\n", "# IDs\n-,1,2,3\n,4,5,6"] {
        let cloud = named("a.csv", text, "-,x,y,z").unwrap();
        assert_eq!(points(&cloud), [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]], "{text}");
    }
    let message = named("a.csv", "P1,1,2,3\nP2,4,5 m,6\n", "-,x,y,z").unwrap_err().to_string();
    assert!(message.contains("line 2, column 6: `5 m` is not a number"), "{message}");
    // Where they mean nothing it is said.
    let ply = "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\nend_header\n1 2 3\n";
    assert!(named("a.ply", ply, "x,y,z").unwrap().warnings[0].contains("columns have no effect"));
    assert_eq!(named("a.xyz", text, "x,y,z,-,r,g,b").unwrap().warnings, [""; 0]);
}

#[test]
fn decimal_commas() {
    for text in ["1,5 2,5 3,25\n", "x;y;z\n1,5;2,5;3,25\n", "X Y Z\n1,5\t2,5\t3,25\n", "\"1,5\"; \"2,5\"; \"3,25\""] {
        assert_eq!(points(&load_bytes("a.txt", text).unwrap()), [[1.5, 2.5, 3.25]], "{text}");
    }
    let cloud = named("a.csv", "P1;1,5;2;3\nP2;4;5,5;6\n", "-,x,y,z").unwrap();
    assert_eq!(points(&cloud), [[1.5, 2.0, 3.0], [4.0, 5.5, 6.0]]);
}

#[test]
fn text_that_is_no_number_is_nan_or_an_error() {
    let cloud =
        load_bytes("a.csv", "x,y,z,i,t\n1,2,3,,\nnan,2,3,4,5\n1,inf,3,4,5\n1,,3,4,5\n1,2,-1.#IND,4,5\n6,7,8,9,10\n")
            .unwrap();
    assert_eq!((points(&cloud).len(), cloud.non_finite), (2, 4));
    let (intensity, scalar) = (cloud.intensity.unwrap(), &cloud.scalars[0].1);
    assert!(intensity[0].is_nan() && scalar[0].is_nan() && intensity[1] == 9.0 && scalar[1] == 10.0);
    assert_refused("a.txt", "nan nan nan\n", &["no points (all 1 have"]);
    for (text, says) in [
        ("1 2 3\n4 5\n", "line 2: expected 3 values, found 2"),
        ("1 2 3\n\n4 5 6 7\n", "line 3: expected 3 values, found 4"),
        ("1 2 3\n4  5x 6\n", "line 2, column 4: `5x` is not a number"),
        ("x y z\n1 2 3\n# ü\n4 ü5 6\n", "line 4, column 3: `ü5` is not a number"),
        ("1 2\n", "line 1: expected at least 3 values (x y z), found 2"),
        ("1.5;2,5;3,5\n", "line 1: no column `x`, only [1.5, 2,5, 3,5]; --columns names them"),
        (
            "1.5;2;3\n4;5,000;6\n",
            "line 2, column 3: `5,000` has a decimal comma, where numbers before it have a decimal point",
        ),
        ("x y\n1 2\n", "line 1: no column `z`, only [x, y]"),
        ("X,Y,X\n\n0,0,0\n", "line 1: no column `z`, only [X, Y, X]"),
        ("a table of some sort\n1 2 3\n", "line 1: no column `x`"),
        ("x y z\n1 2\n", "line 2: 2 values, but line 1 names 3 columns"),
        ("x y z\n1 2 3 4\n", "line 2: 4 values, but line 1 names 3 columns"),
        ("x y z\nx y z\n1 2 3\n", "line 2, column 1: `x` is not a number"),
        ("x y z\n", "the cloud has no points"),
        ("# nothing\n", "the cloud has no points"),
        (" \n\n", "the cloud has no points"),
        ("12\n", "truncated"),
    ] {
        assert_refused("a.txt", text, &[says]);
    }
    assert_refused("a.txt", b"1 2 3\n\0\0\0", &["byte 6: binary data, not text"]);
    assert_refused("a.csv", b"\xff\xfe1\0 \0", &["byte 0: UTF-16 text"]);
    assert_refused("a.txt", vec![b'1'; 3 << 20], &["line 1: the line is longer than 1048576 bytes"]);
    // Bytes of another encoding in a comment are no harm.
    assert_eq!(load_bytes("a.txt", b"# \xb5\xff\n1 2 3\n").unwrap().len(), 1);
}

#[test]
fn pts() {
    let cloud = load_bytes("a.pts", "2\n1 2.5 -3 -1613 255 0 51\n400 5 6e3 200 0 0 0\n").unwrap();
    assert_eq!((points(&cloud), cloud.intensity.unwrap()), (TWO.to_vec(), vec![-1613.0, 200.0]));
    assert_eq!(cloud.colors.unwrap()[0], Vec3::new(1.0, 0.0, decode_srgb(0.2)));
    // The columns by their number alone: an intensity that could be a channel.
    let cloud = load_bytes("a.pts", "1\n1 2 3 9 255 0 0\n").unwrap();
    assert_eq!((cloud.intensity.unwrap(), cloud.colors.unwrap()), (vec![9.0], vec![Vec3::X]));
    assert_eq!(load_bytes("a.pts", "1\n1 2 3 0.5\n").unwrap().intensity.unwrap(), [0.5]);
    assert_eq!(load_bytes("a.pts", "1\n1 2 3 255 0 0\n").unwrap().colors.unwrap(), [Vec3::X]);
    // Scans after each other, each with its number; and none.
    let cloud = load_bytes("a.pts", "1\n1 2.5 -3\n1\n400 5 6e3\n").unwrap();
    assert_eq!((points(&cloud), cloud.warnings.len()), (TWO.to_vec(), 0));
    assert_eq!(points(&load_bytes("a.pts", "1 2.5 -3\n400 5 6e3\n").unwrap()), TWO);
    let cloud = load_bytes("a.pts", "1\n1 2.5 -3\n400 5 6e3\n").unwrap();
    assert_eq!((cloud.len(), cloud.warnings[0].contains("announces 1 points, but 2 follow")), (2, true));

    assert_refused("a.pts", "3\n1.25 2.25 3.25\n1 2 3\n", &["ends at line 3 after 2 of the 3 points that line 1"]);
    assert_refused("a.pts", "1\n1 2.5 -3\n2\n400.5 5.5 6e3\n", &["ends at line 4 after 1 of the 2 points that line 3"]);
    for count in ["1000000000000", "18446744073709551615"] {
        assert_refused(
            "a.pts",
            format!("{count}\n1 2 3\n"),
            &[&format!("line 1 announces {count} points"), "at most 1"],
        );
    }
    assert_refused("a.pts", "99999999999999999999\n1 2 3\n", &["line 1: expected at least 3 values"]);
    assert_refused("a.pts", "-5\n1 2 3\n", &["line 1"]);
    assert_refused("a.pts", "", &["empty file"]);
}

/// The head of a scan of so many columns and rows, moved by (10, 20, 30) after a quarter turn about z.
fn head(columns: &str, rows: &str) -> String {
    format!("{columns}\n{rows}\n10 20 30\n0 1 0\n-1 0 0\n0 0 1\n0 1 0 0\n-1 0 0 0\n0 0 1 0\n10 20 30 1\n")
}

#[test]
fn a_ptx_file_with_one_scan_position_has_its_scanner() {
    // Five columns of four rows that rise along z.
    let grid = |turned: bool| {
        let cells = (0..5).flat_map(|column| (0..4).map(move |row| (column, row)));
        let cell = |(column, row)| if turned { format!("5 {row} {column}\n") } else { format!("5 {column} {row}\n") };
        cells.map(cell).collect::<String>()
    };
    let of = |text: String| load_bytes("a.ptx", text).unwrap().sensor;
    let scan = head("5", "4") + &grid(false);
    for text in [scan.clone(), scan.clone() + &scan] {
        let sensor = of(text).unwrap();
        assert_eq!((sensor.position, sensor.turns), (DVec3::new(10.0, 20.0, 30.0), true));
        assert!(sensor.forward.distance(DVec3::Y) < 1e-12 && sensor.up.distance(DVec3::Z) < 1e-12, "{sensor:?}");
    }
    assert_eq!(of(scan.clone() + &scan.replace("10 20 30 1", "10 20 31 1")), None, "two positions");
    assert_eq!(of(head("5", "4") + &grid(true)), None, "no grid of a scanner");
    assert_eq!(of(scan.replace("0 0 1 0\n10", "0 0 0 0\n10")), None, "no pose");
}

#[test]
fn ptx() {
    let one = head("2", "2") + "1 2 3 0.5 255 0 0\n0 0 0 0.5 0 0 0\n-0 0 0.0 0 0 0 0\n4 5 6 0.25 0 0 255\n";
    let cloud = load_bytes("a.ptx", &one).unwrap();
    // (x y z 1) · M: x goes to y, y to −x.
    assert_eq!(points(&cloud), [[8.0, 21.0, 33.0], [5.0, 24.0, 36.0]]);
    assert_eq!((cloud.non_finite, cloud.up), (2, UpAxis::Z), "0 0 0 is no return");
    assert_eq!((cloud.intensity.unwrap(), cloud.colors.unwrap()), (vec![0.5, 0.25], vec![Vec3::X, Vec3::Z]));

    // Scans with and without color or intensity.
    let more = one + &head("1", "1") + "1 0 0 0.75\r\n" + &head("1", "1") + "1 0 0\n";
    let cloud = load_bytes("a.ptx", &more).unwrap();
    assert_eq!((cloud.len(), cloud.colors.unwrap()[2]), (4, Vec3::ONE));
    assert_eq!(cloud.intensity.unwrap(), [0.5, 0.25, 0.75, 0.0]);
    let bare = load_bytes("a.ptx", head("1", "1") + "1 0 0\n").unwrap();
    assert_eq!((bare.colors, bare.intensity, bare.scalars.len()), (None, None, 0));
    let cloud = named("a.ptx", &(head("1", "1") + "3 9 1 2\n"), "z,t,x,y").unwrap();
    assert_eq!((points(&cloud), cloud.scalars[0].1[0]), (vec![[8.0, 21.0, 33.0]], 9.0));

    let refused = |text: String, says: &[&str]| assert_refused("a.ptx", text, says);
    refused(head("2", "1") + "1.5 2.5 3.5\n", &["ends after 1 of the 2 points of the scan at line 1"]);
    refused(head("1", "1"), &["announces 1 × 1 points", "at most 0"]);
    for (columns, rows) in [("1000000", "1000000"), ("18446744073709551615", "2")] {
        refused(
            head(columns, rows) + "1 2 3\n",
            &[&format!("line 1 announces {columns} × {rows} points"), "at most 1"],
        );
    }
    refused(head("1", "one"), &["line 2", "expected the number of rows of a scan, found `one`"]);
    refused("1\n1\n1 2 3\n".into(), &["ends at line 3 within the header of a scan"]);
    refused(head("1", "1").replace("0 0 1 0", "0 0 1"), &["line 9: expected 4 values, found 3"]);
    refused(head("1", "1").replace("10 20 30\n", "10 zwanzig 30\n"), &["line 3, column 4: `zwanzig` is not a number"]);
    refused(head("1", "1") + "1 2 3 4 5\n", &["line 11: 5 values (expected x y z, then intensity", "--columns"]);
    refused(head("1", "1") + "1 2 3\nmore\n", &["line 12: expected the number of columns", "`more`"]);
    refused("1 2 3\n".into(), &["line 1", "expected the number of columns"]);
    refused(head("1", "1") + "0 0 0\n", &["no points (all 1"]);
}

#[test]
fn random_damage_never_panics() {
    use rand::{RngExt, SeedableRng};
    let files = [
        ("a.csv", "x,y,z,\"r\",g,b\n1,2,3,4,5,6\n1,2,3,4,5,6\n".to_owned()),
        ("a.xyz", "1 2 3 4 5 6 7\n1 2 3 4 5 6 7\n".to_owned()),
        ("a.pts", "2\n1 2 3 4\n1 2 3 4\n".to_owned()),
        ("a.ptx", head("2", "1") + "1 2 3 4\n1 2 3 4\n"),
        (
            "a.pcd",
            "FIELDS x y z rgb\nCOUNT 1 1 1 1\nPOINTS 2\nDATA binary_compressed\n\x03\0\0\0\x20\0\0\0abc".to_owned(),
        ),
    ];
    let folder = Folder::new();
    let mut rng = rand_pcg::Pcg64Mcg::seed_from_u64(5);
    let mut refused = 0;
    for (name, text) in &files {
        for _ in 0..300 {
            let mut damaged = text.clone().into_bytes();
            for _ in 0..rng.random_range(1..4) {
                let at = rng.random_range(0..damaged.len());
                damaged[at] = if rng.random() { b"0-9.,;\n\t \"#e"[rng.random_range(0..12)] } else { rng.random() };
            }
            refused += usize::from(super::load(&folder.file(name, damaged)).is_err());
        }
    }
    assert!(refused > 300, "only {refused} damaged files were refused");
}

/// Files that are longer than what is parsed at a time: scans begin and errors stand where they would line by line.
#[test]
fn batches_of_lines_are_lines() {
    let scan = |points: usize| format!("{points}\n{}", "1.5 2 3 -7\n".repeat(points));
    let two = format!("{}# between\n{}", scan(900_000), scan(900_000));
    let cloud = load_bytes("a.pts", &two).unwrap();
    assert_eq!((cloud.len(), cloud.warnings.len()), (1_800_000, 0));
    assert!(cloud.positions.iter().all(|position| *position == DVec3::new(1.5, 2.0, 3.0)));
    assert_refused("a.pts", format!("{two}1 2\n"), &["line 1800004", "expected 4 values, found 2"]);
    assert_refused("a.pts", format!("{two}1,5 2 3 -7\n"), &["line 1800004, column 1", "where numbers before it"]);
}

#[test]
fn carriage_returns_alone_end_no_line() {
    for (text, line) in [
        ("1 2 3\r4 5 6\r7 8 9\r", "line 1"),
        ("x,y,z\r1,2,3\r4,5,6", "line 1"),
        ("1;2;3\n4;5;6\r7;8;9\n", "line 2"),
        ("1 2 3\n4 5 6\n7 8 9\r1 2 3\n", "line 3"),
    ] {
        assert_refused("a.xyz", text, &[line, "old Macs", "tr '\\r' '\\n'"]);
    }
    // Larger than a line may be.
    assert_refused("a.xyz", "1 2 3\r".repeat(1 << 18), &["line 1", "old Macs"]);
}

#[test]
fn names_and_values_have_one_separator() {
    for (text, separators) in
        [("x,y,z\n1;2;3\n", ["';'", "','"]), ("x;y;z\n1,2,3\n", ["','", "';'"]), ("x,y,z\n1\t2\t3\n", ["'\\t'", "','"])]
    {
        assert_refused("a.csv", text, &["line 2", separators[0], separators[1], "throughout"]);
    }
    assert_eq!(points(&load_bytes("a.csv", "x;y;z\n1,5;2;3\n").unwrap()), [[1.5, 2.0, 3.0]]);
}
