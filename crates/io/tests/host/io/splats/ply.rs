//! Gaussian splats in PLY files, by the properties that other programs write.

use glam::{DVec3, Quat, Vec3};
use pellucid_core::cloud::UpAxis;
use pellucid_core::cloud::filter::Filter;
use pellucid_core::color::decode_srgb;

use pellucid_io::store::{PlyPieces, Store};

use super::super::{Folder, load_bytes};

const PROPERTIES: [&str; 27] = [
    "x", "y", "z", "nx", "ny", "nz", "f_dc_0", "f_dc_1", "f_dc_2", "f_rest_0", "f_rest_1", "f_rest_2", "f_rest_3",
    "f_rest_4", "f_rest_5", "f_rest_6", "f_rest_7", "f_rest_8", "opacity", "scale_0", "scale_1", "scale_2", "rot_0",
    "rot_1", "rot_2", "rot_3", "time",
];

/// The harmonic times ±0.5/0.2820948 is ±0.5; logit 0 is one half; the extents are 2, 4 and 8; a quarter turn about z.
const ROWS: &str = "1 2 3 0 0 0 1.772453851 -1.772453851 0 1 2 3 4 5 6 7 8 9 0 0.693147181 1.386294361 2.079441542 5 0 0 5 7\n\
                    4 5 6 0 0 0 99 -99 0.886226925 0 0 0 0 0 0 0 0 0 -inf 0 0 0 1 0 0 0 8\n";

fn file(properties: &[&str], comments: &str, rows: &str) -> String {
    let lines: Vec<_> = properties.iter().map(|name| format!("property float {name}\n")).collect();
    let count = rows.lines().count();
    format!("ply\nformat ascii 1.0\n{comments}element vertex {count}\n{}end_header\n{rows}", lines.concat())
}

#[test]
fn splats_have_shape_color_and_opacity() {
    let cloud = load_bytes("a.ply", file(&PROPERTIES, "", ROWS)).unwrap();
    assert_eq!(cloud.positions, [DVec3::new(1.0, 2.0, 3.0), DVec3::new(4.0, 5.0, 6.0)]);
    // Coefficients of ten digits, and the slope of the decoding is at most 2.3.
    let near = |a: Vec3, b: Vec3| assert!(a.distance(b) < 1e-6 * (1.0 + b.length()), "{a}, not {b}");
    let (colors, gaussians) = (cloud.colors.unwrap(), cloud.gaussians.unwrap());
    near(colors[0], Vec3::new(1.0, 0.0, decode_srgb(0.5)));
    near(colors[1], Vec3::new(1.0, 0.0, decode_srgb(0.75)));
    near(gaussians.bases[0], Vec3::new(1.0, 0.0, 0.5));
    near(gaussians.bases[1], Vec3::new(28.427_385, -27.427_385, 0.75));
    near(gaussians.extents[0], Vec3::new(2.0, 4.0, 8.0));
    let turn = gaussians.rotations[0];
    assert!((turn * Vec3::X).distance(Vec3::Y) < 1e-6 && turn.is_normalized(), "{turn}");
    assert_eq!(gaussians.rotations[1], Quat::IDENTITY);
    assert_eq!(gaussians.degree, 1);
    assert_eq!(gaussians.harmonics_of(0), [[1.0, 4.0, 7.0], [2.0, 5.0, 8.0], [3.0, 6.0, 9.0]].map(Vec3::from));
    assert_eq!(cloud.alphas.unwrap(), [0.5, 0.0]);
    assert_eq!((cloud.radii, cloud.normals, cloud.up), (None, None, UpAxis::NegativeY));
    assert_eq!(cloud.scalars, [("time".to_owned(), vec![7.0, 8.0])]);
    assert!(cloud.warnings.is_empty(), "{:?}", cloud.warnings);
}

#[test]
fn columns_may_stand_anywhere_and_in_any_case() {
    let order: Vec<usize> = (0..27).rev().collect();
    let names: Vec<String> = order.iter().map(|at| PROPERTIES[*at].to_uppercase()).collect();
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let turned = |row: &str| {
        let words: Vec<_> = row.split(' ').collect();
        order.iter().map(|at| words[*at]).collect::<Vec<_>>().join(" ") + "\n"
    };
    let rows: String = ROWS.lines().map(turned).collect();
    let (straight, turned) = (file(&PROPERTIES, "", ROWS), file(&names, "", &rows));
    let (straight, turned) = (load_bytes("a.ply", straight).unwrap(), load_bytes("a.ply", turned).unwrap());
    assert_eq!((straight.positions, straight.gaussians), (turned.positions, turned.gaussians));
    assert_eq!(turned.scalars[0].0, "TIME");
}

#[test]
fn flat_splats_have_two_extents() {
    let names: Vec<_> = PROPERTIES.into_iter().filter(|name| *name != "scale_2").collect();
    let rows: String = ROWS
        .lines()
        .map(|row| {
            row.split(' ').enumerate().filter(|(at, _)| *at != 21).map(|(_, word)| word).collect::<Vec<_>>().join(" ")
                + "\n"
        })
        .collect();
    let cloud = load_bytes("a.ply", file(&names, "comment SplatRenderMode: 2dgs\n", &rows)).unwrap();
    let extents = cloud.gaussians.unwrap().extents;
    assert!(extents[0].distance(Vec3::new(2.0, 4.0, 0.0)) < 1e-5 && extents[1] == Vec3::new(1.0, 1.0, 0.0));
    assert_eq!(cloud.filter, Some(Filter::Flat));
}

#[test]
fn the_last_comment_names_the_filter() {
    for (comments, filter) in [
        ("", None),
        ("comment SplatRenderMode: mip\n", Some(Filter::Mip)),
        ("comment antialiased 1\n", Some(Filter::Mip)),
        ("comment antialiased 1\ncomment antialiased 0\n", Some(Filter::Plain)),
        ("comment SplatRenderMode: default\ncomment made by hand\n", Some(Filter::Plain)),
        ("comment splatrendermode: unheard-of\n", None),
    ] {
        assert_eq!(load_bytes("a.ply", file(&PROPERTIES, comments, ROWS)).unwrap().filter, filter, "{comments}");
    }
}

#[test]
fn rows_that_are_no_splats_are_left_out_with_their_scalars() {
    let odd = "nan 2 3 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 1 0 0 0 9\n\
               1 2 3 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 10\n\
               1 2 3 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 nan 0 0 0 1 0 0 0 11\n\
               1 2 3 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 89 0 0 1 0 0 0 12\n\
               1 2 3 0 0 0 0 0 0 0 0 0 0 0 0 0 0 inf 0 0 0 0 1 0 0 0 13\n\
               1 2 3 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 -inf -inf -inf 1 0 0 0 14\n";
    let cloud = load_bytes("a.ply", file(&PROPERTIES, "", &format!("{odd}{ROWS}"))).unwrap();
    assert_eq!((cloud.len(), cloud.non_finite), (2, 1));
    assert_eq!(cloud.scalars, [("time".to_owned(), vec![7.0, 8.0])]);
    assert!(cloud.warnings[0].starts_with("5 splats are left out"), "{:?}", cloud.warnings);
    let all = load_bytes("a.ply", file(&PROPERTIES, "", odd)).unwrap_err().to_string();
    assert!(all.contains("a.ply: splats: 5 splats are left out: each has a number that is not finite"), "{all}");
}

#[test]
fn harmonics_of_no_degree_are_left_out() {
    let names: Vec<_> = PROPERTIES.into_iter().filter(|name| *name != "f_rest_8").collect();
    let row = "1 2 3 0 0 0 0 0 0 1 2 3 4 5 6 7 8 0 0 0 0 1 0 0 0 7\n";
    let cloud = load_bytes("a.ply", file(&names, "", row)).unwrap();
    assert_eq!(cloud.gaussians.unwrap().degree, 0);
    assert!(
        cloud.warnings[0].starts_with("8 properties f_rest_ are left out: harmonics of degree"),
        "{:?}",
        cloud.warnings
    );
}

/// A splat with the half axes 3, 4 and 12 around it, opacity one half, and properties of any type.
fn one(more: &[(&str, &str)], values: &str) -> String {
    let own = ["opacity", "scale_0", "scale_1", "scale_2", "rot_0", "rot_1", "rot_2", "rot_3"];
    let own = ["x", "y", "z"].into_iter().chain(own).map(|name| ("float", name));
    let lines: String =
        own.chain(more.iter().copied()).map(|(kind, name)| format!("property {kind} {name}\n")).collect();
    let row = "1 2 3 0 1.0986122886681098 1.3862943611198906 2.4849066497880004 1 0 0 0";
    format!("ply\nformat ascii 1.0\nelement vertex 1\n{lines}end_header\n{row} {values}\n")
}

#[test]
fn colors_of_points_are_the_display_colors_of_splats() {
    let load = |kind: &str, values: &str| {
        let file = one(&[(kind, "red"), (kind, "green"), (kind, "blue")], values);
        load_bytes("a.ply", file).unwrap()
    };
    for (kind, values) in
        [("uchar", "51 255 0"), ("ushort", "13107 65535 0"), ("float", "0.2 1 0"), ("double", "0.2 1 0")]
    {
        let cloud = load(kind, values);
        let gaussians = cloud.gaussians.expect(kind);
        // Decoding and encoding in float32.
        assert!(gaussians.bases[0].distance(Vec3::new(0.2, 1.0, 0.0)) < 1e-6, "{kind}: {:?}", gaussians.bases);
        assert!(gaussians.extents[0].distance(Vec3::new(3.0, 4.0, 12.0)) < 1e-5);
        assert_eq!((cloud.alphas, gaussians.degree), (Some(vec![0.5]), 0));
        assert!(cloud.colors.unwrap()[0].distance(Vec3::new(decode_srgb(0.2), 1.0, 0.0)) < 1e-6, "{kind}");
        assert!(cloud.scalars.is_empty() && cloud.warnings.is_empty(), "{kind}: {:?}", cloud.warnings);
    }
    let names = ["f_dc_0", "f_dc_1", "f_dc_2", "red", "green", "blue"].map(|name| ("float", name));
    let both = load_bytes("a.ply", one(&names, "0 0 0 1 1 1")).unwrap();
    assert_eq!(both.gaussians.unwrap().bases, [Vec3::splat(0.5)], "coefficients say more than colors");
}

#[test]
fn what_points_lack_to_be_splats_is_named() {
    let warnings = |gone: &[&str], more: &[(&str, &str)], values: &str| {
        let file = gone
            .iter()
            .fold(one(more, values), |file, name| file.replace(&format!(" {name}\n"), &format!(" q{name}\n")));
        let cloud = load_bytes("a.ply", file).unwrap();
        assert!(cloud.gaussians.is_none());
        cloud.warnings
    };
    let coefficients = [("float", "f_dc_0"), ("float", "f_dc_1"), ("float", "f_dc_2")];
    for (gone, more, said) in [
        (&["rot_3"] as &[&str], &coefficients as &[_], "lack the property `rot_3`, so"),
        (&["opacity"], &coefficients, "lack the property `opacity`, so"),
        (&["scale_1", "rot_0"], &coefficients, "lack the properties `scale_1`, `rot_0`, so"),
        (&[], &coefficients[..2], "lack the property `f_dc_2`, so"),
        (&[], &[], "lack the properties `f_dc_0`, `f_dc_1`, `f_dc_2`, so"),
        (&["rot_2"], &[("uchar", "red"), ("uchar", "green"), ("uchar", "blue")], "lack the property `rot_2`, so"),
    ] {
        let found = warnings(gone, more, &vec!["0"; more.len()].join(" "));
        assert!(found.len() == 1 && found[0].contains("drawn as discs") && found[0].contains(said), "{found:?}");
    }
    // One family alone may be anything.
    assert!(warnings(&["rot_0", "rot_1", "rot_2", "rot_3"], &[], "").is_empty());
}

#[test]
fn the_smoothing_filter_of_mip_splatting_is_applied() {
    let coefficients = ["f_dc_0", "f_dc_1", "f_dc_2"].map(|name| ("float", name));
    let smoothed = |filter: &str| {
        let properties = [&coefficients[..], &[("float", "filter_3D")]].concat();
        load_bytes("a.ply", one(&properties, &format!("0 0 0 {filter}")))
    };
    let cloud = smoothed("4").unwrap();
    let gaussians = cloud.gaussians.unwrap();
    // √(3² + 4²), √(4² + 4²), √(12² + 4²); the opacity loses the root of the determinants' ratio, det = 3·4·12.
    let (y, z) = (32.0_f32.sqrt(), 160.0_f32.sqrt());
    assert!(gaussians.extents[0].distance(Vec3::new(5.0, y, z)) < 1e-5, "{:?}", gaussians.extents);
    let alpha = cloud.alphas.unwrap()[0];
    assert!((alpha - 0.5 * 144.0 / (5.0 * y * z)).abs() < 1e-6, "{alpha}");
    assert_eq!((cloud.filter, cloud.scalars.len(), cloud.warnings.len()), (Some(Filter::Mip), 0, 0));
    let plain = smoothed("0").unwrap();
    assert_eq!(plain.alphas, Some(vec![0.5]));
    assert!(plain.gaussians.unwrap().extents[0].distance(Vec3::new(3.0, 4.0, 12.0)) < 1e-5);
    let none = smoothed("nan").unwrap_err().to_string();
    assert!(none.contains("1 splats are left out"), "{none}");
}

#[test]
fn comments_state_the_vertical() {
    for (comments, up, warnings) in [
        ("comment Generated by Nerfstudio 1.1.5\ncomment Vertical Axis: z\n", UpAxis::Z, 0),
        ("comment Vertical Axis: y\n", UpAxis::Y, 0),
        ("comment vertical axis: -y\n", UpAxis::NegativeY, 0),
        ("comment Vertical Axis: x\n", UpAxis::NegativeY, 1),
    ] {
        let cloud = load_bytes("a.ply", file(&PROPERTIES, comments, ROWS)).unwrap();
        assert_eq!((cloud.up, cloud.up_reason, cloud.warnings.len()), (up, None, warnings), "{comments}");
    }
    let points = |comment: &str| {
        let header = format!("ply\nformat binary_little_endian 1.0\n{comment}element vertex 2\nproperty float x\n");
        let header = header + "property float y\nproperty float z\nend_header\n";
        let bytes = [0.0_f32, 0.0, 0.0, 1.0, 2.0, 3.0].map(f32::to_le_bytes);
        [header.as_bytes(), bytes.as_flattened()].concat()
    };
    // Other points too, and those that are read in pieces.
    let (folder, comment) = (Folder::new(), "comment Vertical Axis: z\n");
    assert_eq!(load_bytes("a.ply", points("")).unwrap().up, UpAxis::Y);
    assert_eq!(load_bytes("a.ply", points(comment)).unwrap().up, UpAxis::Z);
    let pieces = PlyPieces::open(&folder.file("a.ply", points(comment))).unwrap();
    assert_eq!(pieces.summary().up, UpAxis::Z);
}

#[test]
fn other_points_stay_what_they_are() {
    // Without rotations these are the scalars that they are called, which a warning says.
    let properties: Vec<_> = PROPERTIES.into_iter().filter(|name| !name.starts_with("rot_")).collect();
    let row = "1 2 3 0 0 1 4 5 6 9 9 9 9 9 9 9 9 9 0.25 10 11 12 7\n";
    let cloud = load_bytes("a.ply", file(&properties, "", row)).unwrap();
    assert_eq!((cloud.colors, cloud.alphas, cloud.gaussians, cloud.warnings.len()), (None, None, None, 1));
    assert_eq!((cloud.normals.unwrap(), cloud.scalars.len()), (vec![Vec3::Z], 17));
}
