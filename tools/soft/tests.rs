//! The experiments at a small scale.

use clap::Parser;
use pellucid_testing::has_device;

use crate::{Args, run};

#[test]
fn every_table_and_figure_is_written_with_a_time_in_each_cell() {
    if !has_device() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let output = folder.path().to_str().unwrap();
    let words = ["soft-experiments", "-o", output, "--scale", "0.02", "--frames", "1", "--path", "2"];
    run(&Args::try_parse_from(words).unwrap()).unwrap();
    let text = |name: &str| std::fs::read_to_string(folder.path().join(name)).unwrap();
    let rows = |name: &str| text(name).lines().skip(1).map(str::to_owned).collect::<Vec<_>>();
    for (name, count) in [("table.csv", 3 + 9), ("path.csv", 2), ("second.csv", 8 * 3)] {
        let found = rows(name);
        assert_eq!(found.len(), count, "{name}: {found:?}");
        for row in &found {
            let numbers: Vec<f64> = row.split(',').filter_map(|cell| cell.parse().ok()).collect();
            assert!(numbers.len() >= 3 && numbers.iter().all(|x| x.is_finite() && *x >= 0.0), "{name}: {row}");
        }
    }
    for name in ["table.md", "second.md", "path-time.svg", "path-fragments.svg"] {
        assert!(!text(name).is_empty(), "{name}");
    }
}
