//! Raw volumes, and the scene `iso` of them.

use pellucid_io::volume::{Dims, Scalar, read};
use pellucid_scene::procedural::iso::build_iso;

use super::with_file;

/// A volume. The first line is the file's name without its ending, then options: what `--dims`, `--type` and `--values`
/// say.
pub fn volume(input: &[u8]) {
    let Some(end) = input.iter().position(|byte| *byte == b'\n') else { return };
    let (Ok(line), content) = (str::from_utf8(&input[..end]), &input[end + 1..]) else { return };
    let mut words = line.split(' ');
    let stem: String = words.next().unwrap_or_default().chars().filter(|c| !"/\0.".contains(*c)).take(60).collect();
    let dims = words.next().and_then(|word| word.parse::<Dims>().ok());
    let scalar = words.next().and_then(|word| word.parse::<Scalar>().ok());
    let values: Vec<f64> = words.filter_map(|word| word.parse().ok()).filter(|value: &f64| value.is_finite()).collect();
    let read = with_file(&format!("a{stem}.raw"), content, |path| read(path, dims, scalar));
    let Ok(volume) = read else { return };
    assert_eq!(volume.values.len(), volume.dims.iter().product::<usize>());
    if let Ok(scene) = build_iso(&volume, &values, &[("points".to_owned(), 100.0)], 1) {
        assert!(scene.clouds.iter().flat_map(|(_, cloud)| &cloud.positions).all(|position| position.is_finite()));
    }
}
