//! All columns of points together: in another order, some of them, several lists as one.

use std::sync::Arc;

use bytemuck::{NoUninit, Pod, bytes_of};
use glam::Vec3;
use rayon::prelude::*;

use super::Points;
use crate::cloud::gaussians::Gaussians;
use crate::parallel;

/// Does the same to every column but those of Gaussians.
macro_rules! each_column {
    ($points:expr, |$column:ident| $what:expr) => {{
        let Points { positions, colors, opacities, radii, normals, file_order, dealt_ids, fields, .. } = $points;
        let $column = positions;
        $what;
        std::iter::once(colors).chain(normals).for_each(|$column| $what);
        [opacities, radii, fields].into_iter().for_each(|$column| $what);
        [file_order, dealt_ids].into_iter().for_each(|$column| $what);
    }};
}

/// Returns `true` if all values of a column have the same bits, so that they have no order.
fn is_uniform<T: NoUninit + Sync>(column: &[T]) -> bool {
    let Some(first) = column.first().map(bytes_of) else { return true };
    column.par_chunks(1 << 14).all(|some| some.iter().all(|value| bytes_of(value) == first))
}

impl Points {
    /// Returns the same points in another order: place i gets point `from(i)`. Works column by column and frees each
    /// once it is copied, since memory can't hold a hundred million points twice. Columns of a single value stay as
    /// they are.
    pub fn in_order(mut self, from: impl Fn(usize) -> usize + Sync) -> Self {
        fn pick<T: Pod + Send + Sync>(column: Vec<T>, from: &(impl Fn(usize) -> usize + Sync)) -> Vec<T> {
            if is_uniform(&column) {
                return column;
            }
            parallel::map(column.len(), |i| column[from(i)])
        }
        each_column!(&mut self, |column| *column = pick(std::mem::take(column), &from));
        self.gaussians = self.gaussians.map(|all| all.picked(all.len(), &from));
        self
    }

    /// Returns the points at these places, in that order, with radii times a factor.
    pub fn subset(&self, places: &[u32], radius_factor: f32) -> Self {
        let mut some = Self::picked(&[self], places.len(), &|i| [0, places[i] as usize]);
        some.radii.iter_mut().for_each(|radius| *radius = (radius_factor * *radius).min(f32::MAX));
        Self { unseen: Arc::clone(&self.unseen), whole: self.whole.clone(), ..some }
    }

    /// Returns some points of parts of a scene, which have the same columns but for normals and Gaussians: each by the
    /// number of its part and its place there.
    #[doc(hidden)]
    pub fn gather(parts: &[Arc<Self>], picked: &[[u32; 2]]) -> Self {
        let parts: Vec<&Self> = parts.iter().map(|points| &**points).collect();
        Self::picked(&parts, picked.len(), &|i| picked[i].map(|number| number as usize))
    }

    /// So many points of parts: place i gets the one whose part and place there `of(i)` tells. Normals that a part
    /// lacks are zeros.
    fn picked(parts: &[&Self], count: usize, of: &(impl Fn(usize) -> [usize; 2] + Sync)) -> Self {
        fn pick<'a, T: Pod + Send + Sync>(
            (parts, count): (&[&'a Points], usize),
            of: &(impl Fn(usize) -> [usize; 2] + Sync),
            column: impl Fn(&'a Points) -> &'a [T],
        ) -> Vec<T> {
            let columns: Vec<&[T]> = parts.iter().map(|&points| column(points)).collect();
            let count = if columns.iter().all(|column| column.is_empty()) { 0 } else { count };
            parallel::map(count, |i| {
                let [part, at] = of(i);
                columns[part][at]
            })
        }
        let normal = |i: usize| {
            let [part, at] = of(i);
            parts[part].normals.as_ref().map_or(Vec3::ZERO, |normals| normals[at])
        };
        let splat = |i: usize| {
            let [part, at] = of(i);
            Some((parts[part].gaussians.as_ref()?, at))
        };
        let has_normals = parts.iter().any(|points| points.normals.is_some());
        let degree = parts.iter().filter_map(|points| Some(points.gaussians.as_ref()?.degree)).max();
        let from = (parts, count);
        Self {
            positions: pick(from, of, |points| &points.positions),
            colors: pick(from, of, |points| &points.colors),
            opacities: pick(from, of, |points| &points.opacities),
            radii: pick(from, of, |points| &points.radii),
            normals: has_normals.then(|| parallel::map(count, normal)),
            file_order: pick(from, of, |points| &points.file_order),
            dealt_ids: pick(from, of, |points| &points.dealt_ids),
            fields: pick(from, of, |points| &points.fields),
            gaussians: degree.map(|degree| Gaussians::gathered(count, degree, splat)),
            ..Self::default()
        }
    }

    /// Keeps the points that are marked.
    #[doc(hidden)]
    pub fn retain(&mut self, keep: &[bool]) {
        each_column!(&mut *self, |column| {
            let mut keep = keep.iter();
            column.retain(|_| keep.next().copied().unwrap_or(false));
        });
        if let Some(gaussians) = &self.gaussians {
            let kept: Vec<usize> = (0..keep.len()).filter(|at| keep[*at]).collect();
            self.gaussians = Some(gaussians.picked(kept.len(), |i| kept[i]));
        }
    }

    /// Returns the number of bytes of all columns, also of those of points that are not drawn.
    #[doc(hidden)]
    pub fn bytes(&self) -> u64 {
        let mut bytes = size_of_val(&*self.unseen.positions) + size_of_val(&*self.unseen.radii);
        each_column!(self, |column| bytes += size_of_val(&**column));
        let splats = |all: &Gaussians| all.len() as u64 * Gaussians::bytes_each(all.degree);
        bytes as u64 + self.gaussians.as_ref().map_or(0, splats)
    }

    /// Puts `more` behind these; whoever has no normals gets zeros if the other has some. The orders of their files are
    /// forgotten.
    pub fn append(&mut self, more: Self) {
        if !more.unseen.positions.is_empty() {
            let unseen = Arc::make_mut(&mut self.unseen);
            unseen.positions.extend(&more.unseen.positions);
            unseen.radii.extend(&more.unseen.radii);
        }
        if self.is_empty() {
            *self = Self { file_order: Vec::new(), unseen: Arc::clone(&self.unseen), ..more };
            return;
        }
        let (before, added) = (self.len(), more.len());
        self.sensor = self.sensor.filter(|own| added == 0 || more.sensor == Some(*own));
        self.normals = match (self.normals.take(), more.normals) {
            (None, None) => None,
            (own, other) => {
                let mut normals = own.unwrap_or_else(|| vec![Vec3::ZERO; before]);
                normals.extend(other.unwrap_or_else(|| vec![Vec3::ZERO; added]));
                Some(normals)
            }
        };
        self.gaussians = Gaussians::joined((self.gaussians.take(), before), (more.gaussians, added));
        self.positions.extend(more.positions);
        self.colors.extend(more.colors);
        self.opacities.extend(more.opacities);
        self.radii.extend(more.radii);
        self.fields.extend(more.fields);
        self.dealt_ids.extend(more.dealt_ids);
        self.file_order = Vec::new();
    }
}
