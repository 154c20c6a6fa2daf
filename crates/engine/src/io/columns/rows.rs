//! Runs of a table's rows that are written side by side.

use glam::{DVec3, Vec3};

use super::{Layout, Table};

/// A run of rows of a [`Table`], in all of its columns.
pub(in crate::io) struct Rows<'a> {
    positions: &'a mut [DVec3],
    colors: Option<&'a mut [Vec3]>,
    alphas: Option<&'a mut [f32]>,
    normals: Option<&'a mut [Vec3]>,
    radii: Option<&'a mut [f32]>,
    intensity: Option<&'a mut [f32]>,
    codes: Option<&'a mut [f32]>,
    scalars: Vec<&'a mut [f32]>,
}

impl<'a> Rows<'a> {
    /// The rows of a table in runs of this length; the last may be shorter.
    pub(super) fn of(table: &'a mut Table, run: usize) -> Vec<Self> {
        fn runs<T>(column: &mut Option<Vec<T>>, run: usize) -> Option<std::slice::ChunksMut<'_, T>> {
            column.as_mut().map(|column| column.chunks_mut(run))
        }
        fn next<'a, T>(runs: &mut Option<std::slice::ChunksMut<'a, T>>) -> Option<&'a mut [T]> {
            runs.as_mut().and_then(Iterator::next)
        }
        let cloud = &mut table.cloud;
        let mut colors = runs(&mut cloud.colors, run);
        let mut alphas = runs(&mut cloud.alphas, run);
        let mut normals = runs(&mut cloud.normals, run);
        let mut radii = runs(&mut cloud.radii, run);
        let mut intensity = runs(&mut cloud.intensity, run);
        let mut codes = runs(&mut table.codes, run);
        let mut scalars: Vec<_> = cloud.scalars.iter_mut().map(|(_, column)| column.chunks_mut(run)).collect();
        let rows = cloud.positions.chunks_mut(run).map(|positions| Self {
            positions,
            colors: next(&mut colors),
            alphas: next(&mut alphas),
            normals: next(&mut normals),
            radii: next(&mut radii),
            intensity: next(&mut intensity),
            codes: next(&mut codes),
            scalars: scalars.iter_mut().filter_map(Iterator::next).collect(),
        });
        rows.collect()
    }

    pub fn len(&self) -> usize {
        self.positions.len()
    }

    /// Writes a row to a place; false if its position is not finite, and the place is free for another.
    pub fn put(&mut self, layout: &Layout, at: usize, row: &[f64]) -> bool {
        fn set<T>(column: &mut Option<&mut [T]>, at: usize, value: Option<T>) {
            if let (Some(column), Some(value)) = (column, value) {
                column[at] = value;
            }
        }
        let Some(position) = layout.position(row) else { return false };
        self.positions[at] = position;
        set(&mut self.colors, at, layout.color(row));
        set(&mut self.alphas, at, layout.alpha(row));
        set(&mut self.normals, at, layout.normal(row));
        set(&mut self.radii, at, layout.radius(row));
        set(&mut self.intensity, at, layout.intensity(row));
        set(&mut self.codes, at, layout.code(row));
        for (values, value) in self.scalars.iter_mut().zip(layout.scalars(row)) {
            values[at] = value;
        }
        true
    }
}
