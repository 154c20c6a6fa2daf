//! Runs of a table's rows that are written side by side.

use std::ops::Range;

use glam::{DVec3, Vec3};

use super::{PointTable, RowBlock, RowLayout};

/// A run of rows of a [`PointTable`], in all of its columns.
pub(crate) struct RowRun<'a> {
    positions: &'a mut [DVec3],
    colors: Option<&'a mut [Vec3]>,
    alphas: Option<&'a mut [f32]>,
    normals: Option<&'a mut [Vec3]>,
    radii: Option<&'a mut [f32]>,
    intensity: Option<&'a mut [f32]>,
    scalars: Vec<&'a mut [f32]>,
}

impl<'a> RowRun<'a> {
    /// Returns the rows of a table in runs of this length; the last may be shorter.
    pub(super) fn of(table: &'a mut PointTable, run: usize) -> Vec<Self> {
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
        let mut scalars: Vec<_> = cloud.scalars.iter_mut().map(|(_, column)| column.chunks_mut(run)).collect();
        let rows = cloud.positions.chunks_mut(run).map(|positions| Self {
            positions,
            colors: next(&mut colors),
            alphas: next(&mut alphas),
            normals: next(&mut normals),
            radii: next(&mut radii),
            intensity: next(&mut intensity),
            scalars: scalars.iter_mut().filter_map(Iterator::next).collect(),
        });
        rows.collect()
    }

    pub fn len(&self) -> usize {
        self.positions.len()
    }

    /// Writes the rows of a block, whose positions are finite, to a place.
    pub fn put(&mut self, layout: &RowLayout, at: usize, block: &RowBlock) {
        fn set<T>(column: &mut Option<&mut [T]>, places: Range<usize>, value: impl Fn(usize) -> Option<T>) {
            let Some(column) = column else { return };
            for (row, to) in column[places].iter_mut().enumerate() {
                if let Some(value) = value(row) {
                    *to = value;
                }
            }
        }
        let places = at..at + block.len();
        let value = |row: usize| move |at: usize| block.value(row, at);
        set(&mut Some(&mut *self.positions), places.clone(), |row| layout.position(value(row)));
        set(&mut self.colors, places.clone(), |row| layout.color(value(row)));
        set(&mut self.alphas, places.clone(), |row| layout.alpha(value(row)));
        set(&mut self.normals, places.clone(), |row| layout.normal(value(row)));
        set(&mut self.radii, places.clone(), |row| layout.radius(value(row)));
        set(&mut self.intensity, places.clone(), |row| layout.intensity(value(row)));
        for (column, at) in self.scalars.iter_mut().zip(layout.scalar_places()) {
            set(&mut Some(&mut **column), places.clone(), |row| Some(block.value(row, at) as f32));
        }
    }
}
