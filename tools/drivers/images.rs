//! Images of all subjects on one driver, and how they get from the process that renders them to the one that compares.

use std::path::Path;

use pellucid_core::image::Image;
use pellucid_engine::methods::{Facts, Renderer};
use pellucid_gpu::{Device, DeviceOptions};
use pellucid_lab::check::{self, Lack, MethodScene};
use serde_json::{Value, json};

/// The images of all subjects on one driver.
pub struct DriverImages {
    pub device: String,
    pub driver: String,
    /// Outcomes in the order of the subjects.
    pub outcomes: Vec<Outcome>,
}

pub enum Outcome {
    Image(Box<Image>, Met),
    /// The device lacks this.
    Lacks(String),
    Failed(String),
}

/// Quantities on which an image's bound depends.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Met {
    /// Fragments of the longest list, or splats and points of the whole scene.
    pub longest: u64,
}

pub fn is_asked(subject: &MethodScene, only: Option<&str>) -> bool {
    only.is_none_or(|only| subject.name.contains(only))
}

/// Renders the subjects on the device that the environment gives, into a folder.
pub fn render(folder: &Path, only: Option<&str>) -> Result<(), String> {
    let device = Device::open(&DeviceOptions::from_env()).map_err(|e| e.to_string())?;
    let mut renderer = Renderer::new(&device).map_err(|e| e.to_string())?;
    let mut outcomes = Vec::new();
    let subjects = check::compared();
    for (number, subject) in subjects.iter().filter(|subject| is_asked(subject, only)).enumerate() {
        let start = std::time::Instant::now();
        let outcome = match subject.render(&mut renderer) {
            Ok(rendered) => {
                write(&folder.join(number.to_string()), &rendered.image)?;
                let Image { width, height, .. } = rendered.image;
                let counted = rendered.image.fragments.is_some();
                json!({ "width": width, "height": height, "counted": counted, "longest": longest(subject, &rendered.facts) })
            }
            Err(error) if Lack::in_error(&error).is_some() => json!({ "lacks": error.to_string() }),
            Err(error) => json!({ "failed": error.to_string() }),
        };
        eprintln!("{:6.0} ms  {}", start.elapsed().as_secs_f64() * 1e3, subject.name);
        outcomes.push(outcome);
    }
    let info = device.info();
    let index = json!({ "device": info.name, "driver": info.driver, "outcomes": outcomes });
    put(&folder.join("index.json"), index.to_string().as_bytes())
}

/// Counts the fragments, splats or points that may come together in a pixel.
fn longest(subject: &MethodScene, facts: &Facts) -> u64 {
    match u64::from(facts.max_list.max(facts.max_events)) {
        0 => subject.clouds.iter().map(|cloud| cloud.len() as u64).sum(),
        longest => longest,
    }
}

fn put(path: &Path, bytes: &[u8]) -> Result<(), String> {
    std::fs::write(path, bytes).map_err(|e| format!("{}: {e}", path.display()))
}

/// Colors, depths, list lengths, one after the other.
fn write(path: &Path, image: &Image) -> Result<(), String> {
    let counts = image.fragments.as_deref().unwrap_or_default();
    let parts: [&[u8]; 3] =
        [bytemuck::cast_slice(&image.rgba), bytemuck::cast_slice(&image.depth), bytemuck::cast_slice(counts)];
    put(path, &parts.concat())
}

/// Reads the files that [`render`] wrote.
pub fn load(folder: &Path) -> Result<DriverImages, String> {
    let path = folder.join("index.json");
    let text = std::fs::read_to_string(&path).map_err(|e| format!("{}: {e}", path.display()))?;
    let index: Value = serde_json::from_str(&text).map_err(|e| format!("{}: {e}", path.display()))?;
    let word = |key: &str| index[key].as_str().unwrap_or_default().to_owned();
    let listed = index["outcomes"].as_array().ok_or("no outcomes")?;
    let outcomes = listed.iter().enumerate().map(|(number, value)| outcome(&folder.join(number.to_string()), value));
    Ok(DriverImages { device: word("device"), driver: word("driver"), outcomes: outcomes.collect::<Result<_, _>>()? })
}

fn outcome(path: &Path, value: &Value) -> Result<Outcome, String> {
    if let Some(lacks) = value["lacks"].as_str() {
        return Ok(Outcome::Lacks(lacks.to_owned()));
    }
    if let Some(failed) = value["failed"].as_str() {
        return Ok(Outcome::Failed(failed.to_owned()));
    }
    let number = |key: &str| value[key].as_u64().and_then(|n| u32::try_from(n).ok()).ok_or(format!("no {key}"));
    let (width, height) = (number("width")?, number("height")?);
    let bytes = std::fs::read(path).map_err(|e| format!("{}: {e}", path.display()))?;
    let words: Vec<u32> = bytes.as_chunks::<4>().0.iter().map(|word| u32::from_le_bytes(*word)).collect();
    let pixels = width as usize * height as usize;
    let counted = value["counted"] == true;
    if words.len() != pixels * if counted { 6 } else { 5 } {
        return Err(format!("{}: {} words for {pixels} pixels", path.display(), words.len()));
    }
    let (rgba, rest) = words.split_at(4 * pixels);
    let (depth, counts) = rest.split_at(pixels);
    let image = Image {
        width,
        height,
        rgba: rgba.as_chunks::<4>().0.iter().map(|pixel| pixel.map(f32::from_bits)).collect(),
        depth: depth.iter().map(|word| f32::from_bits(*word)).collect(),
        depth_median: None,
        depth_mean: None,
        fragments: counted.then(|| counts.to_vec()),
        ..Image::default()
    };
    Ok(Outcome::Image(Box::new(image), Met { longest: u64::from(number("longest")?) }))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn written_images_load_unchanged() {
        let folder = tempfile::tempdir().expect("a folder");
        let image = Image {
            width: 2,
            height: 1,
            rgba: vec![[0.1, -0.0, 3.0, 1.0], [0.5; 4]],
            depth: vec![2.5, f32::INFINITY],
            depth_median: None,
            depth_mean: None,
            fragments: Some(vec![7, 0]),
            ..Image::default()
        };
        write(&folder.path().join("0"), &image).expect("written");
        let outcomes = json!([
            { "width": 2, "height": 1, "counted": true, "longest": 7 }, { "lacks": "shuffles" }, { "failed": "lost" }
        ]);
        let index = json!({ "device": "a", "driver": "b", "outcomes": outcomes });
        put(&folder.path().join("index.json"), index.to_string().as_bytes()).expect("written");
        let found = load(folder.path()).expect("loaded");
        assert_eq!((found.device.as_str(), found.driver.as_str()), ("a", "b"));
        let [Outcome::Image(loaded, met), Outcome::Lacks(lacks), Outcome::Failed(failed)] = &found.outcomes[..] else {
            panic!("other outcomes");
        };
        assert_eq!(check::difference(loaded, &image), None);
        assert_eq!((met.longest, lacks.as_str(), failed.as_str()), (7, "shuffles", "lost"));
        put(&folder.path().join("0"), &[0; 44]).expect("written");
        assert!(load(folder.path()).is_err_and(|text| text.contains("11 words for 2 pixels")));
    }
}
