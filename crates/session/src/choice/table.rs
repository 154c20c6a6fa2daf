//! The settings among which one was chosen.

use super::{EXACT, Figures, Wish};

/// Settings that are shown.
const SHOWN: usize = 5;

/// An RMSE above this is an image of something else: the levels of a gray wedge of ten steps are as far apart.
const NO_PICTURE: f64 = 0.1;

/// A setting that was measured.
#[derive(Debug, Clone, PartialEq)]
pub struct MeasuredSetting {
    /// Method and setting.
    pub name: String,
    /// Measurements of the setting.
    pub figures: Figures,
    /// Difference between the slowest and the fastest frame, relative to the fastest; `None` for a single frame.
    pub spread: Option<f64>,
    /// True if the spread indicates a busy machine.
    pub busy: bool,
}

/// The best rows for a constraint, the best one first: those that fulfill it, then those that come nearest.
pub(super) fn best(mut rows: Vec<MeasuredSetting>, wish: Wish) -> Vec<MeasuredSetting> {
    let rank = |row: &MeasuredSetting| {
        let Figures { rmse, gpu_ms } = row.figures;
        match (wish.max_error, wish.budget_ms) {
            (Some(most), _) if rmse <= most => (0, gpu_ms, rmse),
            (Some(_), _) => (1, rmse, gpu_ms),
            (None, Some(most)) if gpu_ms > most => (1, gpu_ms, rmse),
            (None, _) => (0, rmse.max(EXACT), gpu_ms),
        }
    };
    rows.sort_by(|a, b| {
        let ((class_a, first_a, second_a), (class_b, first_b, second_b)) = (rank(a), rank(b));
        class_a.cmp(&class_b).then(first_a.total_cmp(&first_b)).then(second_a.total_cmp(&second_b))
    });
    rows.truncate(SHOWN);
    rows
}

/// The advice where the fastest setting of a frame of that size takes `gpu_ms` instead of `most`: its time is taken to
/// go with the pixels, or with the points.
pub(super) fn smaller(size: [u32; 2], gpu_ms: f64, most: f64) -> Option<String> {
    let share = most / gpu_ms;
    if !(share > 0.0 && share < 1.0) {
        return None;
    }
    let [width, height] = size.map(|side| (f64::from(side) * share.sqrt()).floor().max(1.0));
    let every = (1.0 / share).ceil();
    Some(format!("try about {width}x{height} pixels, or 1 of every {every} points"))
}

/// A remark about an error that no picture survives.
pub(super) fn no_picture(rmse: f64) -> Option<String> {
    (rmse > NO_PICTURE).then(|| format!("with an RMSE of {rmse:.2} the picture does not show the scene"))
}

/// Returns the best settings as a table: setting, RMSE, time, and how far apart the times of its frames are.
pub(super) fn listed(rows: &[MeasuredSetting]) -> String {
    let width = rows.iter().map(|row| row.name.chars().count()).max().unwrap_or(0).max("setting".len());
    let line = |row: &MeasuredSetting| {
        let spread = row.spread.map_or_else(String::new, |spread| format!("{:>6.0}%", 100.0 * spread));
        let mark = if row.busy { " (a busy machine?)" } else { "" };
        let Figures { rmse, gpu_ms } = row.figures;
        format!("\n  {:<width$}  {rmse:>8.1e}  {gpu_ms:>9.2}  {spread}{mark}", row.name)
    };
    let lines: String = rows.iter().map(line).collect();
    format!("  {:<width$}  {:>8}  {:>9}  {:>7}{lines}", "setting", "RMSE", "ms", "spread")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::area::Against;

    fn row(name: &str, rmse: f64, gpu_ms: f64) -> MeasuredSetting {
        MeasuredSetting { name: name.into(), figures: Figures { rmse, gpu_ms }, spread: None, busy: false }
    }

    fn names(wish: Wish) -> String {
        let rows = [
            ("a", 0.0, 90.0),
            ("b", 0.01, 20.0),
            ("c", 0.02, 10.0),
            ("d", 0.2, 1.0),
            ("e", 0.3, 2.0),
            ("f", 0.0, 99.0),
        ];
        let rows = rows.map(|(name, rmse, gpu_ms)| row(name, rmse, gpu_ms));
        best(rows.to_vec(), wish).into_iter().map(|row| row.name).collect()
    }

    #[test]
    fn the_best_come_first() {
        let against = Against::Center;
        assert_eq!(names(Wish { max_error: Some(0.01), budget_ms: None, against }), "bafcd");
        assert_eq!(names(Wish { max_error: Some(0.01), budget_ms: Some(1.0), against }), "bafcd");
        assert_eq!(names(Wish { max_error: None, budget_ms: Some(20.0), against }), "bcdea");
        assert_eq!(names(Wish { max_error: None, budget_ms: Some(0.5), against }), "decba");
    }

    #[test]
    fn advice() {
        assert_eq!(smaller([1000, 500], 400.0, 100.0).unwrap(), "try about 500x250 pixels, or 1 of every 4 points");
        assert_eq!((smaller([10, 10], 1.0, 2.0), smaller([10, 10], 1.0, 0.0)), (None, None));
        assert_eq!(no_picture(0.14).unwrap(), "with an RMSE of 0.14 the picture does not show the scene");
        assert_eq!(no_picture(0.01), None);
    }
}
