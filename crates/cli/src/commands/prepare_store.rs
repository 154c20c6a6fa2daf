//! The part of `pellucid prepare` that writes a store.

use std::path::{Path, PathBuf};

use bytesize::ByteSize;
use pellucid_engine::Result;
use pellucid_io as io;
use pellucid_io::store::build::{NODE_POINTS, Settings};
use pellucid_io::store::{self, Octree, Store};
use pellucid_scene::prepare::{self, Request};
use pellucid_scene::{self as scene, CloudSettings, Scene};
use pellucid_session::describe_store;

use super::bar::Bar;
use super::console::Console;
use super::input;
use super::limit::usage;

/// True if the output is to be a folder: it ends in `/`, has no extension, or is one, unless it is called like a file.
pub fn is_store(output: &Path) -> bool {
    let is_written_as_one = output.to_string_lossy().ends_with(std::path::is_separator);
    let is_called_file = output.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("ply"));
    output.is_dir() && !is_called_file || is_written_as_one || output.extension().is_none()
}

/// Returns the settings for building a store.
pub fn settings(host_memory: Option<ByteSize>, node_points: Option<u32>) -> Result<Settings> {
    let node_points = node_points.map_or(Ok(NODE_POINTS), |points| match usize::try_from(points) {
        Ok(points) if points >= 100 => Ok(points),
        _ => Err(usage(format!("--node-points {points}: expected 100 or more"))),
    })?;
    Ok(Settings { node_points, host_memory: input::host_memory(host_memory)? })
}

/// Returns what is computed of the points of a cloud.
pub fn request(cloud: Option<&CloudSettings>, normals: bool) -> Request {
    Request {
        neighbors: cloud.and_then(|cloud| cloud.neighbors),
        radius_cap: cloud.and_then(|cloud| cloud.strays.radius_cap),
        field: cloud.and_then(|cloud| cloud.field.clone()),
        normals,
        ..Request::default()
    }
}

/// Opens the inputs. An octree is read in place, a file of another format into memory.
fn open(inputs: &[PathBuf], scene: &Scene, progress: &Bar) -> Result<Vec<Box<dyn Store>>> {
    let open = |(path, settings): (&PathBuf, &CloudSettings)| {
        progress.reset();
        progress.set_message(format!("reading {}", path.display()));
        let store = store::open(path, settings.hints(), progress)?;
        describe_store(store.summary(), progress);
        Ok(store)
    };
    inputs.iter().zip(&scene.clouds).map(open).collect()
}

/// Says that options that ask for values have no effect on splats.
pub fn prepare_without(splats: &Path) -> String {
    format!("{}: Gaussian splats are written as they are, without radii, field and normals", splats.display())
}

/// Writes the store. `asks`: whether options ask for values to be computed.
pub fn run(
    inputs: &[PathBuf],
    output: &Path,
    scene: &Scene,
    normals: bool,
    settings: &Settings,
    asks: bool,
    console: Console,
) -> Result<()> {
    let progress = console.progress();
    let stores = open(inputs, scene, &progress)?;
    if asks && let Some(splats) = stores.iter().find(|store| store.summary().like.gaussians.is_some()) {
        console.warn(prepare_without(&splats.summary().path));
    }
    let request = request(scene.clouds.first(), normals);
    let made = prepare::store::prepare(&stores, output, &request, settings, &progress);
    let built = made.map_err(|error| match error {
        prepare::store::Error::Io(error) => pellucid_engine::Error::from(error),
        prepare::store::Error::Field { path, source } => scene::Error::Field { path, source }.into(),
        error => io::Error::Write { path: output.to_path_buf(), source: std::io::Error::other(error) }.into(),
    })?;
    progress.finish_and_clear();
    let shown = output.display();
    built.notes.iter().for_each(|note| console.warn(format_args!("{shown}: {note}")));
    let nodes = Octree::open(output)?.nodes().len();
    console.detail(format_args!("{shown}: written, {} points in {nodes} nodes", built.points));
    if built.rounding > 0.0 {
        console
            .detail(format_args!("{shown}: positions moved by up to {:.3e}, onto a grid of integers", built.rounding));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn folders_are_stores() {
        for store in ["a", "a/", "a.b/", "a/b", "."] {
            assert!(is_store(Path::new(store)), "{store}");
        }
        for file in ["a.ply", "a/b.las", ".x/y.PLY"] {
            assert!(!is_store(Path::new(file)), "{file}");
        }
    }
}
