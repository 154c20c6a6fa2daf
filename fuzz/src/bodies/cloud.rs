//! Point clouds: read, checked for what [`Cloud`] promises, and taken all the way to where a device would be.

use std::path::Path;

use glam::Vec3;
use pellucid_core::cloud::Cloud;
use pellucid_core::cloud::gaussians::{ColorCoding, Gaussians, MAX_DEGREE};
use pellucid_core::progress::Progress;
use pellucid_io::{self as io, ColumnNames, Hints};
use pellucid_scene::{Overrides, Scene};

use super::store::{las_pieces, ply_pieces};
use super::{pages, scene::arrange, with_file};

/// Points of clouds that are taken further than reading, so that an input takes no longer than a few milliseconds.
const MOST_POINTS: usize = 200;

/// PLY, Gaussian splats too, as a whole and in pieces.
pub fn ply(input: &[u8]) {
    with_file("input.ply", input, |path| {
        read(path, None);
        ply_pieces(path);
    });
}

/// LAS and LAZ, as a whole and in pieces.
pub fn las(input: &[u8]) {
    with_file("input.laz", input, |path| {
        read(path, None);
        las_pieces(path);
    });
}

/// E57, as it is and with checksums that are right.
pub fn e57(input: &[u8]) {
    with_file("input.e57", input, |path| read(path, None));
    let mended = pages::with_checksums(input);
    if mended != input {
        with_file("input.e57", &mended, |path| read(path, None));
    }
}

/// PCD.
pub fn pcd(input: &[u8]) {
    with_file("input.pcd", input, |path| read(path, None));
}

/// Endings of text files.
const ENDINGS: [&str; 4] = ["xyz", "csv", "pts", "ptx"];

/// Names that the columns may be given.
const COLUMNS: [&str; 7] = [
    "x,y,z",
    "x,y,z,i",
    "x,y,z,i,r,g,b",
    "x,y,z,nx,ny,nz,radius,class",
    "-,x,y,z,a,word",
    "z,y,x,r,g,b,a,-",
    "i,i_,word,x,y,z",
];

/// Tables, PTS and PTX. The first byte's lowest two bits say the file's ending, the next three what the columns are.
pub fn text(input: &[u8]) {
    let Some((&first, content)) = input.split_first() else { return };
    let ending = ENDINGS[usize::from(first & 3)];
    let columns = COLUMNS.get(usize::from(first >> 2 & 7)).and_then(|names| ColumnNames::parse(names).ok());
    with_file(&format!("input.{ending}"), content, |path| read(path, columns.as_ref()));
}

/// Reads a file and does with its cloud what `info` and `render` do before they need a device.
pub(super) fn read(path: &Path, columns: Option<&ColumnNames>) {
    let hints = Hints { columns, ..Hints::default() };
    let cloud = match io::load_with(path, hints, &Progress::hidden()) {
        Ok(cloud) => cloud,
        Err(error) => return assert!(error.to_string().starts_with(&*path.to_string_lossy()), "{error}"),
    };
    check(&cloud);
    if cloud.len() > MOST_POINTS {
        return;
    }
    for method in ["auto", "spbr", "image-space"] {
        let mut overrides = Overrides::default();
        overrides.set("--method", "method.name", method).expect("a key");
        let scene = Scene::from_clouds([path], &overrides).expect("a scene of one cloud");
        arrange(&scene, vec![cloud.clone()]);
    }
}

/// Checks the invariants of [`Cloud`]'s columns.
pub(super) fn check(cloud: &Cloud) {
    let len = cloud.len();
    let is_whole = |column: Option<usize>| column.is_none_or(|column| column == len);
    assert!(len > 0 && cloud.positions.iter().all(|p| p.is_finite()));
    assert!(is_whole(cloud.colors.as_ref().map(Vec::len)) && is_whole(cloud.alphas.as_ref().map(Vec::len)));
    assert!(is_whole(cloud.normals.as_ref().map(Vec::len)) && is_whole(cloud.radii.as_ref().map(Vec::len)));
    assert!(is_whole(cloud.classification.as_ref().map(Vec::len)) && is_whole(cloud.intensity.as_ref().map(Vec::len)));
    assert!(cloud.scalars.iter().all(|(_, values)| values.len() == len));
    cloud.gaussians.iter().for_each(|gaussians| check_gaussians(gaussians, len));
    let is_color = |color: &Vec3| color.is_finite() && color.min_element() >= 0.0 && color.max_element() <= 1.0;
    assert!(cloud.colors.iter().flatten().all(is_color), "a color out of range");
    assert!(cloud.alphas.iter().flatten().all(|alpha| (0.0..=1.0).contains(alpha)), "an alpha out of range");
    assert!(cloud.radii.iter().flatten().all(|radius| radius.is_finite() && *radius >= 0.0), "a radius out of range");
    let is_normal = |normal: &Vec3| *normal == Vec3::ZERO || normal.is_normalized();
    assert!(cloud.normals.iter().flatten().all(is_normal), "a normal that is none");
}

/// Checks the invariants of the columns of Gaussian splats.
fn check_gaussians(gaussians: &Gaussians, len: usize) {
    let Gaussians { extents, rotations, bases, coding, degree, harmonics } = gaussians;
    if let ColorCoding::Each(linear) = coding {
        assert_eq!(linear.len(), extents.len(), "colors are linear or not for each splat");
    }
    assert!([extents.len(), rotations.len(), bases.len()] == [len; 3] && *degree <= MAX_DEGREE);
    assert_eq!(harmonics.len(), len * gaussians.coefficients());
    let is_extent = |extents: &Vec3| extents.is_finite() && extents.min_element() >= 0.0 && *extents != Vec3::ZERO;
    assert!(extents.iter().all(is_extent), "an extent that is none");
    assert!(rotations.iter().all(|rotation| rotation.is_normalized()), "a rotation that is none");
    assert!(bases.iter().chain(harmonics).all(|color| color.is_finite()), "a color that is not finite");
}
