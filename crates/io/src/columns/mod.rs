//! Converts the rows of a table to the columns of a cloud, by the names of the table's columns (the table in `ply`).

mod block;
mod join;
mod layout;
mod rows;
mod table;

pub(super) use block::RowBlock;
pub(super) use join::{taken, taken_optional};
pub(super) use layout::RowLayout;
pub use layout::unit_or_zero;
pub(super) use ply_rs_bw::ply::ScalarType;
pub(super) use rows::RowRun;
pub(super) use table::{PointTable, TableFacts};

use pellucid_core::cloud::{CLASSIFICATION_NAMES, Cloud, INTENSITY_NAMES};

const POSITION: [[&str; 3]; 1] = [["x", "y", "z"]];
const NORMAL: [[&str; 3]; 3] =
    [["nx", "ny", "nz"], ["normal_x", "normal_y", "normal_z"], ["normalx", "normaly", "normalz"]];
/// Names of colors, each perhaps behind one of [`COLOR_PREFIXES`]. CloudCompare writes `Rf Gf Bf`.
const COLORS: [[&str; 3]; 3] = [["red", "green", "blue"], ["r", "g", "b"], ["rf", "gf", "bf"]];
const COLOR_PREFIXES: [&str; 7] = ["", "diffuse_", "vertex_", "color_", "colour_", "f_", "scalar_"];
/// Linear colors, which only files have that 16-bit sRGB would round.
pub(super) const LINEAR_COLOR: [[&str; 3]; 1] = [["linear_red", "linear_green", "linear_blue"]];
const ALPHA: [&str; 2] = ["alpha", "diffuse_alpha"];
const RADIUS: [&str; 1] = ["radius"];

/// A column of a file: a name and the type of its values.
pub(super) struct Column {
    pub name: String,
    pub kind: ScalarType,
}

impl Column {
    pub fn new(name: impl Into<String>, kind: ScalarType) -> Self {
        Self { name: name.into(), kind }
    }
}

/// Columns that grow row by row.
pub(super) struct Columns {
    layout: RowLayout,
    table: PointTable,
}

impl Columns {
    /// Finds the columns of a table; fails with the coordinate that is missing.
    pub fn new(columns: &[Column]) -> Result<Self, &'static str> {
        let layout = RowLayout::new(columns)?;
        let table = PointTable::new(&layout, 0);
        Ok(Self { layout, table })
    }

    /// Adds a vertex, or counts it if its position is not finite.
    pub fn push(&mut self, row: &[f64]) {
        self.table.push(&self.layout, row);
    }

    /// Returns the rows so far: colors and alphas as they are stored, unless they are bytes.
    pub fn stored(&mut self) -> &mut Cloud {
        &mut self.table.cloud
    }

    /// Returns the cloud, its vertical +Y. Normals that are all zero are dropped.
    pub fn finish(self) -> Cloud {
        self.table.into_cloud(&self.layout)
    }
}

/// Returns `true` if the reader would take a property of this name for one of its columns, alone or together with
/// others.
pub(crate) fn is_known(name: &str) -> bool {
    let lower = name.to_ascii_lowercase();
    let threes = POSITION.iter().chain(&NORMAL).chain(&LINEAR_COLOR).flatten();
    let ones = ALPHA.iter().chain(&RADIUS).chain(&CLASSIFICATION_NAMES).chain(&INTENSITY_NAMES);
    let is_color = |stem: &str| COLORS.iter().flatten().any(|known| *known == stem);
    threes.chain(ones).any(|known| *known == lower)
        || COLOR_PREFIXES.iter().any(|prefix| lower.strip_prefix(prefix).is_some_and(is_color))
}
