//! Pictures of all methods on one driver, kept in a folder, and those of another driver against them: the digest of
//! all floats says if they are equal, and 8-bit pixels say how far apart they are if not.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use image::{ExtendedColorType, ImageEncoder, codecs::png::PngEncoder};
use pellucid_core::image::Image;
use pellucid_engine::Result;
use pellucid_engine::methods::Renderer;
use pellucid_gpu::Device;
use pellucid_io::output::Error;
use pellucid_lab::check::{self, Lack, MethodScene};
use serde_json::{Value, json};

use crate::lines;

/// File of a line for each picture.
const INDEX: &str = "pictures.jsonl";

/// FNV-1a, 64 bits, of all colors, depths and lengths of lists.
fn digest(image: &Image) -> String {
    let counts = image.fragments.as_deref().unwrap_or_default();
    let parts: [&[u8]; 3] =
        [bytemuck::cast_slice(&image.rgba), bytemuck::cast_slice(&image.depth), bytemuck::cast_slice(counts)];
    let hash = parts.iter().flat_map(|part| part.iter());
    let hash =
        hash.fold(0xcbf2_9ce4_8422_2325, |hash: u64, byte| (hash ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01b3));
    format!("{hash:016x}")
}

/// R, G, B and A of each pixel in 8 bits, linear: what two pictures are compared by.
fn eight_bits(image: &Image) -> Vec<u8> {
    image.rgba.as_flattened().iter().map(|value| (value.clamp(0.0, 1.0) * 255.0).round() as u8).collect()
}

/// A difference of two pictures in 8 bits.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Apart {
    /// Largest step.
    most: u8,
    /// Components that differ.
    differing: usize,
}

fn apart(a: &[u8], b: &[u8]) -> Apart {
    let steps = a.iter().zip(b).map(|(a, b)| a.abs_diff(*b));
    let (most, differing) = steps.fold((0, 0), |(most, count), step| (step.max(most), count + usize::from(step > 0)));
    Apart { most, differing }
}

fn write_png(path: &Path, size: [u32; 2], bytes: &[u8]) -> Result<()> {
    let failed = |error: std::io::Error| Error::Write { path: path.to_owned(), source: error };
    let file = std::fs::File::create(path).map_err(failed)?;
    PngEncoder::new(std::io::BufWriter::new(file))
        .write_image(bytes, size[0], size[1], ExtendedColorType::Rgba8)
        .map_err(|error| failed(std::io::Error::other(error)))?;
    Ok(())
}

fn read_png(path: &Path) -> Option<Vec<u8>> {
    Some(image::open(path).ok()?.into_rgba8().into_raw())
}

/// Renders the subjects and gives each picture to `take`; lines for those that can't be. False if any failed.
fn each(
    device: &Device,
    kind: &str,
    wanted: impl Fn(&MethodScene) -> bool,
    mut take: impl FnMut(usize, &MethodScene, &Image) -> Result<()>,
) -> Result<bool> {
    let mut renderer = Renderer::new(device)?;
    let mut good = true;
    for (number, subject) in check::compared().iter().enumerate().filter(|(_, subject)| wanted(subject)) {
        match subject.render(&mut renderer) {
            Ok(rendered) => take(number, subject, &rendered.image)?,
            Err(error) => {
                let lacks = Lack::in_error(&error).is_some();
                good &= lacks;
                let word = if lacks { "lacks" } else { "failed" };
                lines::put_missing(kind, json!({ "name": subject.name }), word, &error.to_string());
            }
        }
    }
    Ok(good)
}

/// Keeps the pictures in a folder, each with a line in its index.
pub fn record(device: &Device, folder: &Path, only: Option<&str>) -> Result<bool> {
    let failed = |path: &Path| {
        let path = path.to_owned();
        move |source| Error::Write { path, source }
    };
    std::fs::create_dir_all(folder).map_err(failed(folder))?;
    let mut index = String::new();
    let wanted = |subject: &MethodScene| only.is_none_or(|only| subject.name.contains(only));
    let good = each(device, "recorded", wanted, |number, subject, image| {
        let (name, digest) = (&subject.name, digest(image));
        write_png(&picture(folder, number), [image.width, image.height], &eight_bits(image))?;
        index += &format!("{}\n", json!({ "number": number, "name": name, "digest": digest }));
        Ok(())
    })?;
    let path = folder.join(INDEX);
    std::fs::write(&path, &index).map_err(failed(&path))?;
    lines::put("recorded", json!({ "pictures": index.lines().count() }));
    Ok(good)
}

fn picture(folder: &Path, number: usize) -> PathBuf {
    folder.join(format!("{number}.png"))
}

/// Compares this driver's pictures with those of a folder, and keeps those that differ in another one. False if one
/// could not be rendered; a difference is a finding, and no failure.
pub fn compare(device: &Device, folder: &Path, keep: Option<&Path>) -> Result<bool> {
    let path = folder.join(INDEX);
    let text = std::fs::read_to_string(&path).map_err(|source| Error::Write { path, source })?;
    let entries = text.lines().filter_map(|line| serde_json::from_str::<Value>(line).ok());
    let known: BTreeMap<String, (usize, String)> = entries
        .filter_map(|entry| {
            let number = usize::try_from(entry["number"].as_u64()?).ok()?;
            Some((entry["name"].as_str()?.to_owned(), (number, entry["digest"].as_str()?.to_owned())))
        })
        .collect();
    if let Some(keep) = keep {
        std::fs::create_dir_all(keep).map_err(|source| Error::Write { path: keep.to_owned(), source })?;
    }
    let (mut equal, mut compared) = (0, 0);
    let good = each(
        device,
        "picture",
        |subject| known.contains_key(&subject.name),
        |_, subject, image| {
            let (number, wanted) = &known[&subject.name];
            compared += 1;
            if digest(image) == *wanted {
                equal += 1;
                return Ok(());
            }
            let mut line = json!({ "name": subject.name });
            let found = eight_bits(image);
            if let Some(before) = read_png(&picture(folder, *number)) {
                let Apart { most, differing } = apart(&before, &found);
                line["most_steps"] = most.into();
                line["differing"] = differing.into();
                if let Some(keep) = keep.filter(|_| most > 0) {
                    write_png(&picture(keep, *number), [image.width, image.height], &found)?;
                }
            }
            lines::put("picture", line);
            Ok(())
        },
    )?;
    lines::put("pictures", json!({ "compared": compared, "equal": equal }));
    Ok(good && compared > 0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn digests_differ_by_a_bit_and_8_bits_by_steps() {
        let image = Image {
            width: 2,
            height: 1,
            rgba: vec![[0.0, 0.5, 1.0, 2.0], [0.25; 4]],
            depth: vec![1.0, f32::INFINITY],
            ..Image::default()
        };
        let mut other = image.clone();
        assert_eq!(digest(&image), digest(&other));
        other.rgba[1][3] = f32::from_bits(0.25f32.to_bits() + 1);
        assert_ne!(digest(&image), digest(&other));
        // 0.25 · 255 = 63.75, 0.5 · 255 = 127.5, which is rounded away from 0.
        assert_eq!(eight_bits(&image), [0, 128, 255, 255, 64, 64, 64, 64]);
        assert_eq!(apart(&eight_bits(&image), &eight_bits(&other)), Apart { most: 0, differing: 0 });
        assert_eq!(apart(&[0, 10, 20], &[3, 10, 18]), Apart { most: 3, differing: 2 });
        // FNV-1a of nothing is its offset basis.
        assert_eq!(digest(&Image::default()), "cbf29ce484222325");
    }

    #[test]
    fn a_written_picture_is_read_back() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = picture(folder.path(), 3);
        write_png(&path, [1, 2], &[1, 2, 3, 4, 250, 251, 252, 0]).expect("written");
        assert_eq!(read_png(&path), Some(vec![1, 2, 3, 4, 250, 251, 252, 0]));
        assert_eq!(read_png(&picture(folder.path(), 4)), None);
    }
}
