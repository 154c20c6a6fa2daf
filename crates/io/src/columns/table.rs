//! Columns of rows, before what only all rows tell is known.

use bytemuck::allocation::zeroed_vec;
use glam::Vec3;
use rayon::prelude::*;

use super::{RowLayout, RowRun, taken, taken_optional};
use crate::channel;
use pellucid_core::cloud::Cloud;
use pellucid_core::parallel;

/// The columns of some rows of a table.
pub(crate) struct PointTable {
    /// The points so far; colors, alphas and classes, the last scalar then, may be as they are stored.
    pub cloud: Cloud,
}

/// Does the same to every column of a table.
macro_rules! each_column {
    ($table:expr, |$column:ident| $what:expr) => {{
        let cloud = &mut $table.cloud;
        let $column = &mut cloud.positions;
        $what;
        cloud.colors.iter_mut().chain(&mut cloud.normals).for_each(|$column| $what);
        let ones = [&mut cloud.alphas, &mut cloud.radii, &mut cloud.intensity].into_iter().flatten();
        ones.chain(cloud.scalars.iter_mut().map(|(_, column)| column)).for_each(|$column| $what);
    }};
}

/// Facts that only all rows of a table tell.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct TableFacts {
    /// Some normal has a direction.
    pub directed: bool,
    /// All values of the classification are codes from 0 to 255.
    pub codes: bool,
    /// The largest finite color, if its range is that of all, and the largest finite alpha.
    largest: [Option<f32>; 2],
}

impl TableFacts {
    /// Facts about a table without rows.
    pub const NONE: Self = Self { directed: false, codes: true, largest: [None; 2] };

    /// Merges the facts about two parts of a table.
    #[must_use]
    pub fn and(self, more: Self) -> Self {
        let larger = |a: Option<f32>, b: Option<f32>| match (a, b) {
            (Some(a), Some(b)) => Some(if a.total_cmp(&b).is_ge() { a } else { b }),
            _ => a.or(b),
        };
        Self {
            directed: self.directed || more.directed,
            codes: self.codes && more.codes,
            largest: [0, 1].map(|at| larger(self.largest[at], more.largest[at])),
        }
    }
}

impl PointTable {
    /// Returns columns of so many rows, all zero. Memory is taken as they are written.
    pub fn new(layout: &RowLayout, rows: usize) -> Self {
        let mut table = Self { cloud: layout.empty() };
        each_column!(table, |column| *column = zeroed_vec(rows));
        table
    }

    /// Makes room for this many more rows.
    pub fn reserve(&mut self, rows: usize) {
        each_column!(self, |column| column.reserve_exact(rows));
    }

    /// Returns the rows of parts that have the columns of this layout, one part behind the other. Each column of the
    /// parts is gone once it is joined.
    pub fn join(layout: &RowLayout, mut parts: Vec<Self>) -> Self {
        let (empty, parts) = (Self::new(layout, 0), parts.as_mut_slice());
        let Some(first) = parts.first() else { return empty };
        let scalars =
            first.cloud.scalars.iter().map(|(name, _)| name.clone()).collect::<Vec<_>>().into_iter().enumerate();
        let cloud = Cloud {
            positions: taken(parts, |part| &mut part.cloud.positions),
            colors: taken_optional(parts, |part| &mut part.cloud.colors),
            normals: taken_optional(parts, |part| &mut part.cloud.normals),
            alphas: taken_optional(parts, |part| &mut part.cloud.alphas),
            radii: taken_optional(parts, |part| &mut part.cloud.radii),
            intensity: taken_optional(parts, |part| &mut part.cloud.intensity),
            scalars: scalars.map(|(at, name)| (name, taken(parts, |part| &mut part.cloud.scalars[at].1))).collect(),
            non_finite: parts.iter().map(|part| part.cloud.non_finite).sum(),
            ..empty.cloud
        };
        Self { cloud }
    }

    /// Adds a row, or counts it if its position is not finite.
    pub fn push(&mut self, layout: &RowLayout, row: &[f64]) {
        fn add<T>(column: &mut Option<Vec<T>>, value: Option<T>) {
            if let (Some(column), Some(value)) = (column, value) {
                column.push(value);
            }
        }
        let cloud = &mut self.cloud;
        let value = |at: usize| row[at];
        let Some(position) = layout.position(value) else {
            cloud.non_finite += 1;
            return;
        };
        cloud.positions.push(position);
        add(&mut cloud.normals, layout.normal(value));
        add(&mut cloud.colors, layout.color(value));
        add(&mut cloud.alphas, layout.alpha(value));
        add(&mut cloud.radii, layout.radius(value));
        add(&mut cloud.intensity, layout.intensity(value));
        for ((_, values), value) in cloud.scalars.iter_mut().zip(layout.scalars(value)) {
            values.push(value);
        }
    }

    /// Writes all rows on all cores. `write` is given runs of rows and the place of the first of each. It puts the rows
    /// that stay at the front of the run, and returns the places of the others, which are left out and counted; so does
    /// this, in order.
    pub fn fill<E: Send>(
        &mut self,
        run: usize,
        write: impl Fn(usize, &mut RowRun) -> Result<Vec<u64>, E> + Sync,
    ) -> Result<Vec<u64>, E> {
        let runs = RowRun::of(self, run).into_par_iter().enumerate();
        let written = runs.map(|(at, mut rows)| {
            let left_out = write(at * run, &mut rows)?;
            Ok((rows.len() - left_out.len(), left_out))
        });
        let (kept, left_out): (Vec<usize>, Vec<Vec<u64>>) = written.collect::<Result<Vec<_>, E>>()?.into_iter().unzip();
        let left_out = left_out.concat();
        if !left_out.is_empty() {
            self.keep(run, &kept);
        }
        self.cloud.non_finite += left_out.len();
        Ok(left_out)
    }

    /// Moves the first rows of each run together.
    fn keep(&mut self, run: usize, kept: &[usize]) {
        each_column!(self, |column| compact(column, run, kept));
    }

    /// Returns what these rows tell of all.
    pub fn whole(&self, layout: &RowLayout) -> TableFacts {
        let cloud = &self.cloud;
        let [colors, _] = layout.measures();
        let largest = |values: &[f32]| channel::largest(values.par_iter().copied());
        let largest_color = || largest(bytemuck::cast_slice(cloud.colors.as_deref().unwrap_or_default()));
        let is_code = |code: &f32| (0.0..=255.0).contains(code) && code.fract() == 0.0;
        let classes = cloud.scalars.last().filter(|_| layout.classified);
        TableFacts {
            directed: cloud.normals.as_deref().unwrap_or_default().par_iter().any(|&n| n != Vec3::ZERO),
            codes: classes.is_none_or(|(_, values)| values.par_iter().all(is_code)),
            largest: [colors.then(largest_color).flatten(), cloud.alphas.as_deref().and_then(largest)],
        }
    }

    /// Returns the cloud of all rows of a table.
    pub fn into_cloud(self, layout: &RowLayout) -> Cloud {
        let whole = self.whole(layout);
        self.finish(layout, &whole)
    }

    /// Returns the cloud of some rows of a table of which all rows together tell this; its vertical is +Y. Normals that
    /// are all zero are dropped.
    pub fn finish(self, layout: &RowLayout, whole: &TableFacts) -> Cloud {
        let mut cloud = self.cloud;
        if layout.classified && whole.codes {
            let codes = cloud.scalars.pop();
            cloud.classification = codes.map(|(_, codes)| parallel::map_each(&codes, |&code| code as u8));
        }
        let [colors, measured_alphas] = layout.measures();
        if colors {
            let full = channel::full_scale(whole.largest[0]);
            cloud.colors = cloud.colors.zip(full).map(|(colors, full)| channel::measured(colors, full));
        }
        if cloud.alphas.is_some() {
            finish_alphas(&mut cloud, whole.largest[1], measured_alphas);
        }
        cloud.normals = cloud.normals.filter(|_| whole.directed);
        cloud
    }
}

/// Alphas below this hide nearly everything.
const FAINT: f32 = 0.05;

/// Scales alphas whose range is that of all of them, of which this is the largest. Those that are 0 everywhere are no
/// alphas: some writers leave the column empty.
fn finish_alphas(cloud: &mut Cloud, largest: Option<f32>, are_measured: bool) {
    let (Some(largest), Some(full)) = (largest, channel::full_scale(largest)) else {
        cloud.alphas = None;
        cloud.warnings.push("alpha is 0 at every point and is ignored".to_owned());
        return;
    };
    if are_measured {
        cloud.alphas.iter_mut().flatten().for_each(|value| *value = channel::unit_or(1.0, *value / full));
    }
    let largest = if are_measured { largest / full } else { largest };
    if largest < FAINT {
        cloud.warnings.push(format!(
            "no alpha is above {largest:.2}, so the points hardly show; the column may be something else than alpha"
        ));
    }
}

/// Moves the first values of each run together.
fn compact<T: Copy>(column: &mut Vec<T>, run: usize, kept: &[usize]) {
    let mut end = 0;
    for (at, &kept) in kept.iter().enumerate() {
        column.copy_within(at * run..at * run + kept, end);
        end += kept;
    }
    column.truncate(end);
}

#[cfg(test)]
mod tests {
    use super::super::{Column, RowBlock, ScalarType};
    use super::*;

    fn layout(names: &[&str]) -> RowLayout {
        let columns: Vec<Column> = names.iter().map(|name| Column::new(*name, ScalarType::Float)).collect();
        RowLayout::new(&columns).unwrap()
    }

    /// Rows filled in runs are those that are pushed one by one, and those that are not finite are in neither.
    #[test]
    fn runs_of_rows_are_rows() {
        let layout =
            layout(&["x", "y", "z", "nx", "ny", "nz", "r", "g", "b", "alpha", "radius", "class", "intensity", "w"]);
        let number = |row: usize, at: usize| match (row % 5, at) {
            (3, 1) if row > 3 => f64::NAN,
            (_, 11) => (row % 200) as f64,
            _ => (row * 14 + at) as f64 * 0.5 - 3.0,
        };
        let rows: Vec<[f64; 14]> = (0..103).map(|row| std::array::from_fn(|at| number(row, at))).collect();
        assert_eq!(layout.bytes(), 24 + 2 * 12 + 5 * 4);
        let mut pushed = PointTable::new(&layout, 0);
        rows.iter().for_each(|row| pushed.push(&layout, row));
        for run in [1, 10, 103, 200] {
            let mut filled = PointTable::new(&layout, rows.len());
            let left_out = filled.fill(run, |first, to| {
                let mut block = RowBlock::new(14);
                let (mut kept, mut left_out) = (0, Vec::new());
                for (number, some) in rows[first..first + to.len()].chunks(7).enumerate() {
                    block.set_len(some.len());
                    (0..14)
                        .for_each(|at| block.column(at).iter_mut().zip(some).for_each(|(value, row)| *value = row[at]));
                    let gone = block.keep_finite(&layout);
                    left_out.extend(gone.into_iter().map(|at| (first + number * 7 + at) as u64));
                    to.put(&layout, kept, &block);
                    kept += block.len();
                }
                Ok::<_, ()>(left_out)
            });
            assert_eq!(left_out.unwrap(), (0..20).map(|at| 8 + 5 * at).take(19).collect::<Vec<_>>());
            assert_eq!(filled.cloud, pushed.cloud, "runs of {run}");
            assert_eq!(filled.cloud.non_finite, 19);
        }
        let parts = rows.chunks(40).map(|rows| {
            let mut part = PointTable::new(&layout, 0);
            part.reserve(rows.len());
            rows.iter().for_each(|row| part.push(&layout, row));
            part
        });
        let joined = PointTable::join(&layout, parts.collect());
        assert_eq!(joined.cloud, pushed.cloud);
        let whole = pushed.whole(&layout);
        assert!(whole.directed && whole.codes);
        let cloud = pushed.finish(&layout, &whole);
        assert_eq!(cloud.classification.map(|codes| codes[1]), Some(1));
        assert_eq!(cloud.scalars.len(), 1);
    }

    #[test]
    fn parts_tell_what_the_whole_tells() {
        let layout = layout(&["x", "y", "z", "nx", "ny", "nz", "r", "g", "b", "a", "class"]);
        let table = |rows: &[[f64; 11]]| {
            let mut table = PointTable::new(&layout, 0);
            rows.iter().for_each(|row| table.push(&layout, row));
            table.whole(&layout)
        };
        let plain = [0.0; 11];
        let special = [0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 7.0, 256.0, f64::NAN, 0.5, 0.5];
        let (a, b) = (table(&[plain]), table(&[special]));
        assert_eq!((a.directed, a.codes), (false, true));
        assert_eq!(a.and(b), table(&[plain, special]));
        assert_eq!(a.and(TableFacts::NONE), a);
        assert_eq!(b.largest, [Some(256.0), None], "`a` is a scalar");
    }
}
