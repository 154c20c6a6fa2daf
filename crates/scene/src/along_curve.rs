//! The cloud of a scene along the Morton curve, before anything is found from its points.
//!
//! One sort then serves the search for neighbors, which reads memory in its order and returns what it found in it, and
//! the canonical order, which finds the points sorted.

use bytemuck::Pod;
use pellucid_core::cloud::Cloud;
use pellucid_core::parallel;

use super::coloring::Coloring;
use super::scene::Scene;
use super::settings::ColorBy;
use crate::prepare::order;

/// Puts the only cloud of a scene into the order of the curve. Returns the place in the file of each point; nothing if
/// the cloud stays as it was.
///
/// Columns that the scene doesn't read are dropped, since each of them would take time to move. A cloud of which it
/// reads scalars stays as it was.
pub(super) fn arrange(scene: &Scene, cloud: &mut Cloud) -> Vec<u32> {
    let Some(read) = Read::of(scene, cloud) else { return Vec::new() };
    let Some(order) = order::along_curve(&cloud.positions) else { return Vec::new() };
    move_column(&mut cloud.positions, &order);
    [&mut cloud.colors, &mut cloud.normals].into_iter().flatten().for_each(|column| move_column(column, &order));
    [&mut cloud.alphas, &mut cloud.radii].into_iter().flatten().for_each(|column| move_column(column, &order));
    cloud.scalars = Vec::new();
    cloud.intensity = cloud.intensity.take().filter(|_| read.intensity);
    cloud.intensity.iter_mut().for_each(|column| move_column(column, &order));
    cloud.classification = cloud.classification.take().filter(|_| read.classification);
    cloud.classification.iter_mut().for_each(|column| move_column(column, &order));
    order
}

fn move_column<T: Pod + Send + Sync>(column: &mut Vec<T>, order: &[u32]) {
    *column = parallel::map_each(order, |&from| column[from as usize]);
}

/// Columns besides position, color, alpha, normal and radius that a scene reads of its cloud.
struct Read {
    intensity: bool,
    classification: bool,
}

impl Read {
    /// Returns those of a scene's only cloud; `None` if there are more clouds, or other columns are read.
    fn of(scene: &Scene, cloud: &Cloud) -> Option<Self> {
        let [settings] = &scene.clouds[..] else { return None };
        if !settings.class.is_empty()
            || settings.field.is_some()
            || cloud.gaussians.is_some()
            || cloud.prepared.is_some()
        {
            return None;
        }
        let coloring = Coloring::of(scene, 0, cloud);
        let nothing = Self { intensity: false, classification: false };
        match coloring.by() {
            None | Some(ColorBy::Uniform | ColorBy::Cloud | ColorBy::Field) => Some(nothing),
            Some(ColorBy::Rgb) if cloud.colors.is_some() => Some(nothing),
            Some(ColorBy::Normal) if cloud.normals.is_some() => Some(nothing),
            Some(ColorBy::Height) => Some(Self { intensity: coloring.choice.modulated, ..nothing }),
            Some(ColorBy::Intensity) if cloud.intensity.is_some() => Some(Self { intensity: true, ..nothing }),
            Some(ColorBy::Classification) if cloud.classification.is_some() => {
                Some(Self { classification: true, ..nothing })
            }
            // Scalars, and what fails for lack of a column: the error names those that are there.
            _ => None,
        }
    }
}

/// Returns the places of points among those that are left, from their places among so many. A point keeps its place
/// before or behind each other one.
pub(super) fn without_gaps(places: &[u32], all: usize) -> Vec<u32> {
    let mut before = vec![0u32; all];
    places.iter().for_each(|&place| before[place as usize] = 1);
    let mut count = 0;
    for is_left in &mut before {
        count += std::mem::replace(is_left, count);
    }
    parallel::map_each(places, |&place| before[place as usize])
}

#[cfg(test)]
mod tests {
    use glam::{DVec3, Vec3};
    use pellucid_core::progress::Progress;
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg64Mcg;

    use super::*;

    /// Points of which some share a place, and of these some everything.
    fn cloud() -> Cloud {
        let mut random = Pcg64Mcg::seed_from_u64(23);
        let mut number = |most: f64| random.random::<f64>() * most;
        let mut positions: Vec<DVec3> = (0..3000).map(|_| DVec3::new(number(9.0), number(9.0), number(0.3))).collect();
        positions.extend_from_within(..300);
        positions.extend((0..200).map(|i| DVec3::new(-0.0, 0.5, f64::from(i % 3))));
        let each = |i: usize| [i % 3, i % 5, i % 7].map(|rest| rest as f32);
        let all = || (0..positions.len()).map(each);
        Cloud {
            colors: Some(all().map(|[r, g, b]| Vec3::new(r / 4.0, g / 8.0, b / 8.0)).collect()),
            alphas: Some(all().map(|[a, ..]| 0.5 + a / 8.0).collect()),
            normals: Some(all().map(|[x, ..]| if x > 0.0 { Vec3::Z } else { Vec3::ZERO }).collect()),
            intensity: Some(all().map(|[_, i, _]| i).collect()),
            classification: Some(all().map(|[.., class]| class as u8).collect()),
            scalars: vec![("echo".to_owned(), all().map(|[x, ..]| x).collect())],
            positions,
            ..Cloud::default()
        }
    }

    fn scene(keys: &str, clouds: usize) -> Scene {
        let cloud = |i: usize| format!("[[cloud]]\npath = '{i}.ply'\n{}\n", if i == 0 { keys } else { "" });
        let text: String = (0..clouds).map(cloud).collect();
        let text = format!("[[clip]]\nslab = {{ axis = 'x', max = 7.0 }}\n{text}");
        Scene::from_toml(&text, "s.toml".as_ref()).unwrap()
    }

    /// A second cloud, without points, has the first one take the general way.
    #[test]
    fn points_that_were_sorted_first_are_those_that_are_sorted_last() {
        let keys = [
            "",
            "scale = 2.0\ntranslate = [0.1, 5e5, -3.0]",
            "outliers = 'drop'",
            "color_by = 'height'",
            "color_by = 'intensity'",
            "color_by = 'classification'",
            "color_by = 'normal'",
            "color = [1.0, 1.0, 1.0]",
        ];
        for keys in keys {
            let [alone, beside] = [1, 2].map(|count| {
                let clouds = [cloud(), Cloud::default()].into_iter().take(count).collect();
                crate::assemble(&scene(keys, count), clouds, true, &Progress::hidden()).unwrap()
            });
            assert!(!alone.unseen.positions.is_empty() && !alone.file_order.is_empty());
            assert!(alone == beside, "{keys}");
        }
    }

    #[test]
    fn what_a_scene_does_not_read_is_dropped_and_what_it_reads_moves_along() {
        for (keys, intensity, classification) in
            [("", false, false), ("color_by = 'intensity'", true, false), ("color_by = 'classification'", false, true)]
        {
            let (before, mut after) = (cloud(), cloud());
            let order = arrange(&scene(keys, 1), &mut after);
            assert_eq!((after.intensity.is_some(), after.classification.is_some()), (intensity, classification));
            assert!(after.scalars.is_empty() && order.len() == before.len());
            let moved = before.subset(&order);
            assert_eq!((&after.positions, &after.colors), (&moved.positions, &moved.colors));
            assert_eq!((&after.alphas, &after.normals), (&moved.alphas, &moved.normals));
            assert_eq!(after.intensity, moved.intensity.filter(|_| intensity));
            assert_eq!(after.classification, moved.classification.filter(|_| classification));
            assert!(arrange(&scene(keys, 1), &mut after).is_empty(), "it is along the curve already");
        }
        for keys in ["color_by = 'echo'", "[[cloud.class]]\nid = 3\nvisible = false", "field = 'intensity'"] {
            let mut same = cloud();
            assert!(arrange(&scene(keys, 1), &mut same).is_empty() && same == cloud(), "{keys}");
        }
        let mut same = cloud();
        assert!(arrange(&scene("", 2), &mut same).is_empty() && same == cloud());
    }

    #[test]
    fn places_without_gaps_keep_their_order() {
        assert_eq!(without_gaps(&[7, 2, 9, 4], 10), [2, 0, 3, 1]);
        assert_eq!(without_gaps(&[], 3), [0u32; 0]);
    }
}
