//! Clouds that pellucid prepared and reads back: as they were written, and damaged.

use std::path::Path;

use pellucid_core::cloud::Cloud;
use pellucid_core::progress::Progress;
use pellucid_io::{self as io, ply};
use pellucid_scene::prepare::{self, Request};
use pellucid_scene::{Overrides, Scene};

use super::{cloud::check, scene::arrange, with_file};

/// Points of a cloud that is prepared.
const MOST_POINTS: usize = 100;

/// A PLY file, prepared or not, behind three bytes: place and value of the damage to what is prepared of it.
pub fn prepared(input: &[u8]) {
    let Some((&[high, low, value], content)) = input.split_first_chunk() else { return };
    with_file("input.ply", content, |path| {
        let Ok(cloud) = load(path) else { return };
        if cloud.len() > MOST_POINTS {
            return;
        }
        let request = Request { neighbors: Some(1 + usize::from(value % 30)), ..Request::default() };
        let Ok(cloud) = prepare::prepared(cloud, &request, &Progress::hidden()) else { return };
        let written = path.with_file_name("prepared.ply");
        ply::write_prepared(&written, &cloud).expect("a folder that can be written to");
        let again = load(&written).expect("what was just written");
        assert!(again.prepared.is_some(), "{:?}", again.warnings);
        use_it(&written, again);
        let mut bytes = std::fs::read(&written).expect("what was just written");
        let at = usize::from(u16::from_be_bytes([high, low])) % bytes.len();
        bytes[at] ^= value;
        std::fs::write(&written, bytes).expect("a file that can be written to");
        if let Ok(cloud) = load(&written) {
            use_it(&written, cloud);
        }
    });
}

fn load(path: &Path) -> Result<Cloud, io::Error> {
    io::load(path, &Progress::hidden())
}

fn use_it(path: &Path, cloud: Cloud) {
    check(&cloud);
    if let Some(prepared) = &cloud.prepared {
        assert_eq!(prepared.values.len(), cloud.len());
        assert!(prepared.shadows.as_ref().is_none_or(|shadows| shadows.lit.len() == cloud.len()));
    }
    let scene = Scene::from_clouds([path], &Overrides::default()).expect("a scene of one cloud");
    arrange(&scene, vec![cloud]);
}
