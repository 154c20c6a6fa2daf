//! Clouds opened by what they are.

use std::path::Path;

use pellucid_core::progress::Progress;
use pellucid_io::store::{Store, Tiles, open};
use pellucid_io::{ColumnNames, Error, Hints, LasColumns, photo::Photo};
use tempfile::tempdir;

use super::make_copc;
use super::make_ept::{self, make};
use super::{assert_same, files, joined, load};
use crate::io::las::sample;

pub(super) fn opened(path: &Path) -> Result<Box<dyn Store>, Error> {
    open(path, Hints::default(), &Progress::hidden())
}

/// The beginning of what a store prints of itself, which is its type.
pub(super) fn kind(store: &dyn Store) -> String {
    format!("{store:?}").split_whitespace().next().unwrap_or_default().to_owned()
}

#[test]
fn every_file_opens_as_what_it_is_or_fails_as_loading_does() {
    let endings = [".las", ".laz", ".ply", ".e57", ".pcd", ".pts", ".ptx", ".xyz", ".txt"];
    // The large ones are opened by the tests of their formats.
    let small = |path: &Path| std::fs::metadata(path).unwrap().len() < 1 << 20;
    let mut kinds = std::collections::BTreeMap::new();
    for (name, path) in files(&endings).into_iter().filter(|(_, path)| small(path)) {
        match (opened(&path), load(&path, LasColumns::default())) {
            (Ok(store), Ok(cloud)) => {
                assert_same(&joined(&*store), &cloud, &name);
                *kinds.entry(kind(&*store)).or_insert(0) += 1;
            }
            (Err(opened), Err(loaded)) => assert_eq!(opened.to_string(), loaded.to_string()),
            (opened, loaded) => panic!("{name}: {:?} and {:?}", opened.err(), loaded.err()),
        }
    }
    for wanted in ["LasPieces", "PlyPieces", "MemoryStore"] {
        assert!(kinds.get(wanted).is_some_and(|count| *count >= 4), "{kinds:?}");
    }
}

#[test]
fn folders_and_contents_decide() {
    let folder = tempdir().unwrap();
    let file = |name: &str| folder.path().join(name);
    std::fs::write(file("tree"), make_copc::make(7).bytes).unwrap();
    std::fs::write(file("plain.copc.laz"), sample(2, 3, true, 90)).unwrap();
    std::fs::create_dir(file("octree")).unwrap();
    make(&file("ept"), &file("plain.copc.laz"), make_ept::Tiles::Laszip, true);
    std::fs::write(file("octree/metadata.json"), "{}").unwrap();
    for (name, wanted) in [("tree", "Copc"), ("plain.copc.laz", "LasPieces"), ("ept", "Ept"), ("ept/ept.json", "Ept")] {
        assert_eq!(kind(&*opened(&file(name)).unwrap()), wanted, "{name}");
    }
    for name in ["octree", "octree/metadata.json"] {
        assert!(opened(&file(name)).unwrap_err().to_string().contains("metadata.json"));
    }
    std::fs::remove_file(file("octree/metadata.json")).unwrap();
    assert!(matches!(opened(&file("octree")), Err(Error::Folder { .. })));
    assert!(matches!(opened(&file("nothing")), Err(Error::Missing { .. })));
}

#[test]
fn hints_for_other_files_have_no_effect_or_are_refused() {
    let folder = tempdir().unwrap();
    let path = folder.path().join("any.las");
    std::fs::write(&path, sample(2, 3, false, 90)).unwrap();
    let columns = ColumnNames::parse("x,y,z").unwrap();
    let hints = Hints { columns: Some(&columns), ..Hints::default() };
    let store = open(&path, hints, &Progress::hidden()).unwrap();
    assert!(store.summary().like.warnings[0].contains("no effect"));
    let photo = Photo::default();
    let hints = Hints { photo: Some(&photo), ..Hints::default() };
    assert!(matches!(open(&path, hints, &Progress::hidden()), Err(Error::NoPicture { .. })));
}

#[test]
fn files_of_several_formats_are_one_cloud() {
    let folder = tempdir().unwrap();
    let file = |name: &str| folder.path().join(name);
    std::fs::write(file("a.laz"), sample(2, 3, true, 300)).unwrap();
    std::fs::write(file("b.laz"), make_copc::make(6).bytes).unwrap();
    std::fs::write(file("c.xyz"), "289814 4320978 170\n289815 4320979 171\n289816 4320979 171\n").unwrap();
    let names = ["a.laz", "b.laz", "c.xyz"];
    let clouds = names.map(|name| load(&file(name), LasColumns::default()).unwrap());
    let stores = names.map(|name| opened(&file(name)).unwrap());
    let tiles = Tiles::new(folder.path(), stores.into_iter().collect()).unwrap();
    let all = joined(&tiles);
    assert_eq!(all.len(), clouds.iter().map(|cloud| cloud.len()).sum::<usize>());
    assert_eq!(all.positions, clouds.iter().flat_map(|cloud| cloud.positions.clone()).collect::<Vec<_>>());
    let colors = all.colors.unwrap();
    assert_eq!(colors[..300], clouds[0].colors.as_ref().unwrap()[..]);
    assert!(colors[300..].iter().all(|color| *color == glam::Vec3::ONE));
}
