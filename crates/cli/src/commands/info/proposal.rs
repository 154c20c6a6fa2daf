//! A command line that suits a file.

use std::path::Path;

use pellucid_core::cloud::{Cloud, UpAxis};
use pellucid_scene::Overview;

use super::facts::Classes;
use crate::commands::typed::quoted;

/// Classes besides 0 and 1 from which on they tell a scan's parts apart.
const ENOUGH_CLASSES: usize = 3;
/// Vegetation of any height, by its codes.
const VEGETATION: [u8; 3] = [3, 4, 5];
/// Buildings, by their code.
const BUILDING: u8 = 6;
/// Layers below which little lies behind anything.
const FEW_LAYERS: f64 = 1.5;
/// The largest coordinate of a model; those of surveys are mostly larger.
const MODEL: f64 = 1e5;

/// Options of `render`, and why, as a phrase.
#[derive(Debug, PartialEq, Eq)]
pub struct Proposal {
    pub command: String,
    pub why: String,
}

/// A command line for a file that was read with these columns, if any were given.
pub fn propose(file: &Path, columns: Option<&str>, cloud: &Cloud, classes: &Classes, seen: &Overview) -> Proposal {
    let (options, why) = options(cloud, classes, seen);
    let columns = columns.map(|list| format!(" --columns {}", quoted(list))).unwrap_or_default();
    let options = options.map(|options| format!(" {options}")).unwrap_or_default();
    Proposal { command: format!("pellucid render {}{columns}{options}", file_argument(file)), why }
}

fn options(cloud: &Cloud, classes: &Classes, seen: &Overview) -> (Option<&'static str>, String) {
    if cloud.gaussians.is_some() {
        return (None, "Gaussian splats have opacities of their own".into());
    }
    let points = |codes: &[u8]| codes.iter().filter_map(|code| classes.get(code)).sum::<usize>();
    let (leaves, roofs) = (points(&VEGETATION), points(&[BUILDING]));
    let told_apart = classes.keys().filter(|code| **code > 1).count() >= ENOUGH_CLASSES;
    if told_apart && leaves > roofs {
        return (Some("--preset canopy"), "the vegetation class becomes faint and shows the points below".into());
    }
    if told_apart && roofs > 0 {
        return (Some("--preset building"), "the building class becomes faint and shows the points under roofs".into());
    }
    if seen.inside {
        return (Some("--preset indoor"), "the points surround their center, as in a room".into());
    }
    if cloud.up == UpAxis::Y && is_near(cloud) && classes.keys().all(|code| *code <= 1) {
        return (Some("--preset model"), "a model: no classes, Y is up".into());
    }
    match seen.layers {
        Some(layers) if layers >= FEW_LAYERS => {
            let why = format!("lets half of the light through {layers:.1} layers");
            (Some("--see-through 0.5"), why)
        }
        _ => (None, "few points hide others".into()),
    }
}

/// True if coordinates are as small as those of models.
fn is_near(cloud: &Cloud) -> bool {
    cloud.bounds().is_some_and(|bounds| bounds.min.abs().max(bounds.max.abs()).max_element() < MODEL)
}

/// A file as an argument that is neither an option nor several words.
fn file_argument(file: &Path) -> String {
    let text = file.display().to_string();
    quoted(&if text.starts_with('-') { format!("./{text}") } else { text })
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;

    #[test]
    fn files_are_one_word_each() {
        for (file, wanted) in [
            ("scan.laz", "scan.laz"),
            ("a b.laz", "'a b.laz'"),
            ("-o.ply", "./-o.ply"),
            ("it's.ply", "'it'\\''s.ply'"),
            ("$HOME/*.ply", "'$HOME/*.ply'"),
            ("Bäume/ein.laz", "Bäume/ein.laz"),
        ] {
            assert_eq!(file_argument(Path::new(file)), wanted);
        }
    }

    #[test]
    fn options_follow_from_the_file() {
        let cloud = |up| Cloud { positions: vec![DVec3::ZERO, DVec3::ONE], up, ..Cloud::default() };
        let (survey, model) = (cloud(UpAxis::Z), cloud(UpAxis::Y));
        let far = Cloud { positions: vec![DVec3::splat(1e6)], ..model.clone() };
        let with = |codes: &[(u8, usize)]| codes.iter().copied().collect::<Classes>();
        let none = with(&[]);
        let seen = |layers, inside| Overview { layers: Some(layers), inside, spacing: None };
        let forest = with(&[(2, 50), (5, 40), (6, 10)]);
        let town = with(&[(1, 90), (2, 50), (6, 40), (9, 3), (5, 20)]);
        for (cloud, classes, seen, wanted) in [
            (&survey, &forest, seen(9.0, false), "a.laz --preset canopy"),
            (&survey, &town, seen(9.0, false), "a.laz --preset building"),
            (&survey, &with(&[(1, 5), (2, 5), (6, 5)]), seen(9.0, false), "a.laz --see-through 0.5"),
            (&survey, &none, seen(9.0, true), "a.laz --preset indoor"),
            (&model, &none, seen(9.0, false), "a.laz --preset model"),
            (&far, &none, seen(9.0, false), "a.laz --see-through 0.5"),
            (&survey, &none, seen(1.2, false), "a.laz"),
        ] {
            let found = propose(Path::new("a.laz"), None, cloud, classes, &seen);
            assert_eq!(found.command, format!("pellucid render {wanted}"));
        }
        let text = propose(Path::new("a.txt"), Some("x,y,z,-"), &survey, &none, &seen(1.0, false));
        assert_eq!(text.command, "pellucid render a.txt --columns x,y,z,-");
    }
}
