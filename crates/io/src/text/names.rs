//! The names of a table's columns: given by the user, by a header, or inferred from the values.

use std::collections::{HashMap, HashSet};

use crate::columns::{Column, ScalarType};
use pellucid_core::parallel;

/// Names of the columns of a text file, from the first one on: `--columns` and `columns` of a `[[cloud]]`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ColumnNames(Vec<String>);

impl ColumnNames {
    /// Splits names at commas. They are `x y z`, `r g b`, `a` (alpha), `i` (intensity), `nx ny nz`, `radius`, `class`,
    /// the names that a PLY file has for these, `-` for a column to skip, and any other word for a scalar; in any case.
    ///
    /// # Errors
    /// A coordinate is missing, a name occurs twice, or a name is empty.
    pub fn parse(text: &str) -> Result<Self, String> {
        let names: Vec<String> = text.split(',').map(|name| name.trim().to_owned()).collect();
        if let Some(at) = names.iter().position(String::is_empty) {
            return Err(format!("name {} of {text:?} is empty (a column to skip is `-`)", at + 1));
        }
        let known: Vec<String> = names.iter().map(|name| canonical(name).to_ascii_lowercase()).collect();
        let mut seen = HashSet::new();
        let twice = (0..known.len()).find(|&at| known[at] != "-" && !seen.insert(&known[at]));
        if let Some(at) = twice {
            return Err(format!("`{}` occurs twice in {text:?}", names[at]));
        }
        match ["x", "y", "z"].into_iter().find(|&name| !known.iter().any(|known| known == name)) {
            Some(missing) => Err(format!("no `{missing}` in {text:?}, as in \"x,y,z,-,r,g,b\"")),
            None => Ok(Self(names)),
        }
    }

    pub(super) fn as_slice(&self) -> &[String] {
        &self.0
    }

    /// Returns `true` for each column that is skipped, which may hold text.
    pub(super) fn skipped(&self) -> Vec<bool> {
        self.0.iter().map(|name| name == "-").collect()
    }
}

/// The columns of a table that are used, and where a line has them.
pub(super) struct UsedColumns {
    pub columns: Vec<Column>,
    pub at: Vec<usize>,
}

impl UsedColumns {
    /// Returns the columns of a line of names: `-` is skipped, and a repeated name gets a number.
    pub fn from_names(names: &[String]) -> Self {
        let mut taken: HashMap<String, usize> = HashMap::new();
        let (mut columns, mut at) = (Vec::new(), Vec::new());
        for (index, name) in names.iter().enumerate().filter(|(_, name)| *name != "-") {
            let name = if name.is_empty() { format!("column_{}", index + 1) } else { canonical(name).to_owned() };
            let count = taken.entry(name.to_ascii_lowercase()).or_insert(0);
            *count += 1;
            let name = if *count == 1 { name } else { format!("{name}_{count}") };
            columns.push(Column::new(name, ScalarType::Double));
            at.push(index);
        }
        Self { columns, at }
    }
}

/// The short names that only tables have.
fn canonical(name: &str) -> &str {
    match name {
        "a" | "A" => "alpha",
        "i" | "I" => "intensity",
        _ => name,
    }
}

/// Returns the columns of a PTS file by their number, if the values allow it: other programs write the same columns in
/// another order.
pub(super) fn of_pts(columns: usize, parts: &[Vec<f64>]) -> Option<Vec<String>> {
    of_scanners(columns).filter(|_| columns < 6 || is_color(parts, columns, columns - 3))
}

/// Returns the columns of PTS and PTX files, by their number.
pub(super) fn of_scanners(columns: usize) -> Option<Vec<String>> {
    let names: &[&str] = match columns {
        3 => &["x", "y", "z"],
        4 => &["x", "y", "z", "intensity"],
        6 => &["x", "y", "z", "red", "green", "blue"],
        7 => &["x", "y", "z", "intensity", "red", "green", "blue"],
        _ => return None,
    };
    Some(names.iter().map(|name| (*name).to_owned()).collect())
}

/// Infers the columns of a table without names from their number and values (docs/formats.md): x, y, z first. From the
/// left, three that are unit vectors are a normal, three that are colors a color, and one before the color, or a single
/// one, is the intensity. The others become `column_N`. `parts` have `columns` values for
/// each point.
pub(super) fn by_values(columns: usize, parts: &[Vec<f64>]) -> Vec<String> {
    let mut names: Vec<String> = (1..=columns).map(|number| format!("column_{number}")).collect();
    let set = |names: &mut [String], at: usize, new: &[&str]| {
        names.iter_mut().skip(at).zip(new).for_each(|(name, new)| *name = (*new).to_owned());
    };
    set(&mut names, 0, &["x", "y", "z"]);
    let (mut normal, mut color) = (None, None);
    let mut at = 3;
    while at < columns {
        let three = at + 3 <= columns;
        if three && normal.is_none() && is_normal(parts, columns, at) {
            normal = Some(at);
            set(&mut names, at, &["nx", "ny", "nz"]);
            at += 3;
        } else if three && color.is_none() && is_color(parts, columns, at) {
            color = Some(at);
            set(&mut names, at, &["red", "green", "blue"]);
            at += 3;
        } else {
            at += 1;
        }
    }
    if columns == 4 || color == Some(4) {
        set(&mut names, 3, &["intensity"]);
    }
    names
}

/// Tolerance for the length of a written unit vector around 1: two decimals.
const UNIT_TOLERANCE: f64 = 0.02;

/// Returns `true` if all three numbers are unit vectors or zero, and not all zero.
fn is_normal(parts: &[Vec<f64>], columns: usize, at: usize) -> bool {
    // `true` if a part has unit vectors, `false` if all of its vectors are zero; `None` if it has others.
    let has_units = |part: &Vec<f64>| {
        part.chunks_exact(columns).try_fold(false, |has_units, row| {
            let length = row[at..at + 3].iter().map(|value| value * value).sum::<f64>().sqrt();
            let fits = length == 0.0 || (length - 1.0).abs() <= UNIT_TOLERANCE || length.is_nan();
            fits.then_some(has_units || length > 0.0)
        })
    };
    parallel::try_map_each(parts, |part| has_units(part).ok_or(())).is_ok_and(|units| units.contains(&true))
}

/// Returns `true` if three columns are color channels of one range: fractions of 1, or integers of 255 or 65535.
fn is_color(parts: &[Vec<f64>], columns: usize, at: usize) -> bool {
    // The largest values of a part and whether all are integers; `None` if some are out of any range.
    let range = |part: &Vec<f64>| {
        let (mut largest, mut integers) = ([0f64; 3], true);
        for row in part.chunks_exact(columns) {
            for (value, largest) in row[at..at + 3].iter().zip(&mut largest) {
                if value.is_nan() {
                    continue;
                }
                if !(0.0..=65535.0).contains(value) {
                    return None;
                }
                integers &= value.fract() == 0.0;
                *largest = largest.max(*value);
            }
        }
        Some((largest, integers))
    };
    let Ok(ranges) = parallel::try_map_each(parts, |part| range(part).ok_or(())) else { return false };
    let integers = ranges.iter().all(|(_, integers)| *integers);
    let largest = [0, 1, 2].map(|channel| ranges.iter().map(|(largest, _)| largest[channel]).fold(0.0, f64::max));
    let most = largest.into_iter().fold(0.0, f64::max);
    if !integers {
        return most <= 1.0;
    }
    // One channel of 16 bits beside two of 8 is not a color; a channel of zeros fits any range.
    let wide = |value: f64| value > 255.0;
    largest.iter().all(|&value| value <= 1.0 || wide(value) == wide(most))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(columns: usize, rows: &[f64]) -> String {
        let whole = by_values(columns, &[rows.to_vec()]);
        let parts: Vec<Vec<f64>> = rows.chunks(columns).map(<[f64]>::to_vec).collect();
        assert_eq!(by_values(columns, &parts), whole, "in parts");
        whole[3..].join(" ")
    }

    #[test]
    fn columns_by_their_values() {
        let p = [0.5, 0.5, 0.5];
        let row = |rest: &[f64]| names(3 + rest.len(), &[&p[..], rest].concat());
        assert_eq!(row(&[25.0]), "intensity");
        assert_eq!(row(&[25.0, 26.0]), "column_4 column_5");
        assert_eq!(row(&[25.0, 26.0, 255.0]), "red green blue");
        assert_eq!(row(&[25.0, 26.0, 256.0]), "column_4 column_5 column_6");
        assert_eq!(row(&[1025.0, 0.0, 256.0]), "red green blue");
        assert_eq!(row(&[0.25, 0.0, 1.0]), "red green blue");
        assert_eq!(row(&[0.0, 0.0, 1.0]), "nx ny nz");
        assert_eq!(row(&[0.58, -0.58, 0.58]), "nx ny nz");
        assert_eq!(row(&[0.25, 0.0, 1.5]), "column_4 column_5 column_6");
        assert_eq!(row(&[-1613.0, 52.0, 70.0, 64.0]), "intensity red green blue");
        assert_eq!(row(&[0.25, 52.0, 70.0, 64.0]), "intensity red green blue");
        assert_eq!(row(&[3000.0, 52.0, 70.0, 64.0]), "intensity red green blue");
        assert_eq!(row(&[52.0, 70.0, 64.0, 255.0]), "red green blue column_7");
        assert_eq!(row(&[52.0, 70.0, 64.0, 0.6, 0.0, 0.8]), "red green blue nx ny nz");
        assert_eq!(row(&[0.6, 0.0, 0.8, 52.0, 70.0, 64.0]), "nx ny nz red green blue");
        assert_eq!(row(&[-7.0, 52.0, 70.0, 64.0, 0.6, 0.0, 0.8]), "intensity red green blue nx ny nz");
        assert_eq!(row(&[f64::NAN, 70.0, 64.0]), "red green blue");
    }

    #[test]
    fn one_value_of_all_decides() {
        let rows = [[0.0, 0.0, 0.0, 10.0, 20.0, 30.0], [0.0, 0.0, 0.0, 10.0, -20.0, 30.0]];
        assert_eq!(names(6, &rows[0]), "red green blue");
        assert_eq!(names(6, rows.as_flattened()), "column_4 column_5 column_6");
    }

    #[test]
    fn names_of_the_user() {
        assert_eq!(ColumnNames::parse("X, y,z,-,-,I,a").unwrap().as_slice(), ["X", "y", "z", "-", "-", "I", "a"]);
        for (text, says) in [
            ("", "name 1 of \"\" is empty"),
            ("x,y,,z", "name 3"),
            ("x,y", "no `z` in \"x,y\""),
            ("x,y,z,X", "`X` occurs twice"),
            ("x,y,z,a,alpha", "`alpha` occurs twice"),
        ] {
            assert!(ColumnNames::parse(text).unwrap_err().contains(says), "{text}");
        }
        // Each compared with all before it, these would be 10¹¹ comparisons.
        let many: String = (0..400_000).map(|i| format!("n{i},")).collect();
        assert_eq!(ColumnNames::parse(&format!("{many}x,y,z")).unwrap().as_slice().len(), 400_003);
    }
}
