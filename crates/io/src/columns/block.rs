//! Some rows of a table, column by column: what is done to all values of a column is decided once.

use super::RowLayout;

/// Rows of a block at most: its columns stay in the processor's cache.
const ROWS: usize = 1024;

/// Some rows of a table.
pub(crate) struct RowBlock {
    /// [`ROWS`] values of each column.
    values: Vec<f64>,
    columns: usize,
    len: usize,
}

impl RowBlock {
    /// Rows of a block at most.
    pub const ROWS: usize = ROWS;

    /// Returns a block of no rows of so many columns.
    pub fn new(columns: usize) -> Self {
        Self { values: vec![0.0; columns * ROWS], columns, len: 0 }
    }

    /// Makes room for this many rows, at most [`Self::ROWS`].
    pub fn set_len(&mut self, len: usize) {
        self.len = len.min(ROWS);
    }

    pub fn len(&self) -> usize {
        self.len
    }

    /// Returns the values of a column.
    pub fn column(&mut self, at: usize) -> &mut [f64] {
        &mut self.values[at * ROWS..][..self.len]
    }

    /// Returns the value of a row in a column.
    #[inline]
    pub fn value(&self, row: usize, column: usize) -> f64 {
        self.values[column * ROWS + row]
    }

    /// Leaves rows out whose positions are not finite; their places are returned.
    pub fn keep_finite(&mut self, layout: &RowLayout) -> Vec<usize> {
        let is_odd = |row: &usize| layout.position(|column| self.value(*row, column)).is_none();
        let odd: Vec<usize> = (0..self.len).filter(is_odd).collect();
        if odd.is_empty() {
            return odd;
        }
        for column in 0..self.columns {
            let (mut kept, mut odd) = (0, odd.iter().peekable());
            let values = self.column(column);
            for row in 0..values.len() {
                if odd.next_if(|odd| **odd == row).is_none() {
                    values[kept] = values[row];
                    kept += 1;
                }
            }
        }
        self.len -= odd.len();
        odd
    }
}
