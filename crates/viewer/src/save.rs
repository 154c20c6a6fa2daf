//! The scene as a file, and the picture that `render` makes of it.

use std::path::{Path, PathBuf};

use super::draft::Effort;
use super::messages::Saving;
use super::navigate::Pose;
use super::stage::{SceneRenderer, TakenPicture};
use pellucid_engine::Result;
use pellucid_io as io;
use pellucid_io::output::{self, Inputs, WriteOptions};
use pellucid_scene::{Document, Overrides, Setting};
use pellucid_session::{Clouds, inputs};

/// Writes the scene to the current folder under the next free number, or to the given place. On request also writes the
/// path and the picture, equal to `render`'s picture of that file to the last byte. Clouds that no file contains are
/// written first. Returns the files, the scene first.
///
/// # Errors
/// Files can't be written or the scene can't be rendered.
pub fn write(stage: &mut SceneRenderer, saving: &Saving, generated: bool) -> Result<Vec<PathBuf>> {
    let mut document = saving.document.clone();
    if generated {
        write_clouds(stage, &mut document, &saving.stem)?;
    }
    let stem = if saving.path.is_some() { format!("{}-path", saving.stem) } else { saving.stem.clone() };
    let scene_path = saving.to.clone().unwrap_or_else(|| free(&stem, |path| path.exists()));
    // The scene file may be that of the scene, which is what is edited.
    Inputs::default().with(document.named_files()).refuse(&scene_path)?;
    write_text(&scene_path, &document.to_toml(scene_path.parent().unwrap_or(Path::new("")))?)?;
    let mut written = vec![scene_path.clone()];
    if let Some(path) = &saving.path {
        let file = scene_path.with_extension("json");
        write_text(&file, &path.to_json())?;
        written.push(file);
    }
    if saving.picture {
        let picture = scene_path.with_extension("png");
        if let Err(error) = render(stage, &scene_path, &picture) {
            // Files that belong together are there together.
            let _ = std::fs::remove_file(&scene_path);
            return Err(error);
        }
        written.push(picture);
    }
    Ok(written)
}

fn write_text(path: &Path, text: &str) -> Result<()> {
    Ok(output::write_atomically(path, |out| std::io::Write::write_all(out, text.as_bytes()))?)
}

/// The first name `STEM-N.toml` for which the scene, picture and path are all free.
fn free(stem: &str, taken: impl Fn(&Path) -> bool) -> PathBuf {
    let name = |n: u32| PathBuf::from(format!("{stem}-{n}.toml"));
    let is_free =
        |path: &PathBuf| !["toml", "png", "json"].iter().any(|extension| taken(&path.with_extension(extension)));
    (1..u32::MAX).map(name).find(is_free).unwrap_or_else(|| name(u32::MAX))
}

/// Does the same as `pellucid render SCENE -o PICTURE`.
fn render(stage: &mut SceneRenderer, scene_path: &Path, picture: &Path) -> Result<()> {
    let document = Document::read(scene_path, &Overrides::default())?;
    let mut scene = document.scene()?;
    if let Clouds::Held(clouds) = stage.clouds() {
        scene.settle(clouds);
    }
    let TakenPicture { rendered, brightness, .. } = stage.take(&scene, Pose::Scene, Effort::Whole)?;
    let options = stage.write_options(scene_path.display().to_string(), brightness.as_ref())?;
    output::write_image(picture, &rendered.image, &WriteOptions { inputs: inputs(&document), ..options })?;
    stage.recycle(rendered.image);
    Ok(())
}

/// Writes clouds that were made into a folder of their own, and names them there.
fn write_clouds(stage: &SceneRenderer, document: &mut Document, stem: &str) -> Result<()> {
    let folder = PathBuf::from(format!("{stem}-clouds"));
    let failed = |source| output::Error::Write { path: folder.clone(), source };
    std::fs::create_dir_all(&folder).map_err(failed)?;
    let settings = document.scene()?.clouds;
    // Clouds that stay in their files are not generated.
    let Clouds::Held(clouds) = stage.clouds() else { return Ok(()) };
    for (i, (settings, cloud)) in settings.iter().zip(clouds).enumerate() {
        let name = settings.path.file_name().map_or_else(|| PathBuf::from(format!("{i}")), PathBuf::from);
        let path = folder.join(name).with_extension("ply");
        io::ply::write(&path, cloud)?;
        let path = std::path::absolute(&path).map_err(|source| output::Error::Write { path, source })?;
        document.put(&format!("cloud.{i}.path"), Setting::Word(path.display().to_string()))?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_is_written_over() {
        let taken = |path: &Path| ["a-1.toml", "a-2.png"].iter().any(|name| Path::new(name) == path);
        assert_eq!(free("a", taken), Path::new("a-3.toml"));
        assert_eq!(free("b", taken), Path::new("b-1.toml"));
        assert_eq!(free("c", |path| path == Path::new("c-1.json")), Path::new("c-2.toml"));
    }
}
