//! Budgets that are too small, for every method: the same picture, or an error that names a budget that will do.

use std::collections::BTreeMap;
use std::fs;

use pellucid_scene::{Family, Method};
use tempfile::TempDir;

use super::{command, has_device, place, text};

/// Budgets that a method tries: nothing, and what lists or tiles make something of. Ensembles work within any, but copy
/// their points so often that it takes minutes.
fn budgets(method: &Method) -> &'static [&'static str] {
    match method.family() {
        Family::Discs => &["1", "2KB", "40KB"],
        Family::Ensembles => &["300KB"],
        _ => &["1", "10KB", "60KB"],
    }
}

/// The picture, or what was said instead.
fn render(folder: &TempDir, method: &str, budget: Option<&str>) -> Result<Vec<u8>, String> {
    let picture = folder.path().join("out/a.exr");
    fs::write(&picture, "old").unwrap();
    let args = ["render", "in/scene.toml", "-q", "--size", "12x10", "--method", method, "-o", "out/a.exr"];
    let budget = budget.map_or_else(Vec::new, |budget| vec!["--memory-budget", budget]);
    let output = command(folder.path(), &[&args[..], &budget].concat()).output().unwrap();
    let (found, stderr) = (fs::read(&picture).unwrap(), text(&output.stderr));
    if output.status.success() {
        assert_eq!(stderr, "", "{method} {budget:?}");
        return Ok(found);
    }
    super::assert_failed(&output, &format!("{method} {budget:?}"), &["; use --memory-budget "]);
    assert_eq!(found, b"old", "{method} {budget:?}");
    Err(stderr)
}

#[test]
#[ignore = "long: every method in up to three budgets"]
fn a_budget_is_kept_or_the_error_names_one_that_will_do() {
    if !has_device() {
        return;
    }
    let folder = place();
    for method in Method::all() {
        let (budgets, method) = (budgets(&method), method.name());
        let wanted = render(&folder, method, None).unwrap();
        // Errors of several budgets name the same one.
        let mut known = BTreeMap::new();
        for budget in budgets {
            let mut budget = (*budget).to_owned();
            let mut tries = 0;
            let found = loop {
                let tried = known.entry(budget.clone()).or_insert_with(|| render(&folder, method, Some(&budget)));
                match tried {
                    Ok(found) => break &*found,
                    Err(said) => {
                        // Each pixel that was too much may be followed by one that is more.
                        tries += 1;
                        assert!(tries < 8, "{method}: {budget} after {tries} errors: {said}");
                        let (_, named) = said.split_once("--memory-budget ").unwrap();
                        budget = named.split([',', '\n']).next().unwrap().trim_end_matches(" or more").replace(' ', "");
                    }
                }
            };
            assert!(*found == wanted, "{method} within {budget}");
        }
    }
}
