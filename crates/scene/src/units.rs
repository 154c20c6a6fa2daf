//! Units of a scene's lengths: those of its clouds, where they have the same.

use std::sync::Arc;

use glam::DVec3;

use super::scene::Scene;
use super::settings::CloudSettings;
use pellucid_core::cloud::crs::{Crs, Unit};

/// The systems of a scene's clouds, in its order.
pub type Systems = Vec<Option<Arc<Crs>>>;

/// Units of the lengths in a scene and in the files of its clouds.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Units {
    /// Units in the scene, which clouds have after they were scaled; without any if two clouds differ.
    world: Crs,
    files: Systems,
}

impl Units {
    /// Returns those of a scene whose clouds have these systems. A cloud without one takes the others' units.
    pub fn of(scene: &Scene, files: Systems) -> Self {
        let found = stated(scene, &files);
        let first = found.first().map(|(_, world)| world.clone()).unwrap_or_default();
        let world = if differing(&found).is_none() { first } else { Crs::default() };
        Self { world, files }
    }

    /// Returns the unit of lengths along a direction in the scene.
    pub fn along(&self, direction: DVec3) -> Option<&Unit> {
        self.world.unit_along(direction)
    }

    /// Returns the unit of a column of a cloud's file that is a length; `None` too if the column is none.
    pub fn of_column(&self, cloud: usize, name: &str) -> Option<&Unit> {
        let crs = self.files.get(cloud)?.as_ref()?;
        match name {
            "x" | "y" => crs.unit.as_ref(),
            "z" => crs.height_unit(),
            "radius" => crs.unit_along(DVec3::ONE),
            _ => None,
        }
    }
}

/// Returns a warning about the first two clouds that have other units; `files` as for [`Units::of`].
pub fn differing_units(scene: &Scene, files: &[Option<Arc<Crs>>]) -> Option<String> {
    let found = stated(scene, files);
    let [first, other] = differing(&found)?;
    let words = |(settings, world): &(&CloudSettings, Crs)| {
        let name = |unit: Option<&Unit>| unit.map_or_else(|| "an unknown unit".to_owned(), Unit::described);
        let heights = world.vertical_unit.as_ref().map(|unit| format!(" with heights in {}", unit.described()));
        let path = settings.path.display();
        format!("{path} is in {}{}", name(world.unit.as_ref()), heights.unwrap_or_default())
    };
    Some(format!(
        "{}, but {}: they are drawn as they are, and lengths of the scene have no unit; `scale` of a [[cloud]] converts one \
         of them",
        words(first),
        words(other)
    ))
}

/// The clouds with known units, which are those after scaling.
fn stated<'a>(scene: &'a Scene, files: &[Option<Arc<Crs>>]) -> Vec<(&'a CloudSettings, Crs)> {
    let world = |(settings, crs): (&'a CloudSettings, &Option<Arc<Crs>>)| {
        let crs = crs.as_ref()?;
        let scaled = |unit: &Option<Unit>| unit.as_ref().and_then(|unit| unit.scaled(settings.scale));
        let (unit, vertical_unit) = (scaled(&crs.unit), scaled(&crs.vertical_unit));
        let is_known = unit.is_some() || vertical_unit.is_some();
        is_known.then(|| (settings, Crs { unit, vertical_unit, ..Crs::default() }))
    };
    scene.clouds.iter().zip(files).filter_map(world).collect()
}

/// The first two with other units.
fn differing<'a, 'b>(found: &'b [(&'a CloudSettings, Crs)]) -> Option<[&'b (&'a CloudSettings, Crs); 2]> {
    let same = |a: Option<&Unit>, b: Option<&Unit>| match (a, b) {
        (Some(a), Some(b)) => a.is_same(b),
        (a, b) => a.is_none() && b.is_none(),
    };
    let (first, others) = found.split_first()?;
    let is_other = |(_, other): &&(&CloudSettings, Crs)| {
        let (one, other) = (&first.1, other);
        !same(one.unit.as_ref(), other.unit.as_ref()) || !same(one.height_unit(), other.height_unit())
    };
    others.iter().find(is_other).map(|other| [first, other])
}
