//! The list of cases as a table: docs/numerics.md holds it.

use super::{Case, Finding, Naive, Verdict, released};

/// A case and the methods for which it is run.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Group {
    /// The part of the name behind the method's.
    pub case: String,
    /// Description of the group.
    pub about: &'static str,
    /// The methods, in the order of the cases.
    pub methods: Vec<String>,
    /// The indices of its cases in the list.
    pub members: Vec<usize>,
}

/// The cases by what they are about, in the order of the first of each.
pub fn groups<'a>(cases: impl IntoIterator<Item = &'a Case>) -> Vec<Group> {
    let mut groups: Vec<Group> = Vec::new();
    for (i, case) in cases.into_iter().enumerate() {
        let (method, name) = case.name.split_once('/').unwrap_or(("", &case.name));
        let known = groups.iter_mut().find(|group| group.case == name && group.about == case.about);
        if let Some(group) = known {
            group.methods.push(method.to_owned());
            group.members.push(i);
        } else {
            let (methods, members) = (vec![method.to_owned()], vec![i]);
            groups.push(Group { case: name.to_owned(), about: case.about, methods, members });
        }
    }
    groups
}

impl Group {
    /// The first columns of the group's row: case, methods, what it is about.
    pub fn columns(&self) -> String {
        let methods: Vec<String> = self.methods.iter().map(|method| format!("`{method}`")).collect();
        format!("| `{}` | {} | {} |", self.case, methods.join(", "), self.about)
    }
}

/// A Markdown table of cases that were run, by what they are about: the largest error found, measured by the last
/// release and allowed, and the smallest of the naive formula.
pub fn markdown(results: &[(&Case, Verdict)]) -> String {
    let mut table = "| case | methods | what is known | error | last release | bound | naive |\n\
                     |---|---|---|---|---|---|---|\n"
        .to_owned();
    for group in groups(results.iter().map(|(case, _)| *case)) {
        let members = || group.members.iter().map(|i| &results[*i]);
        let found: Vec<Finding> = members().filter_map(|(_, verdict)| verdict.finding()).collect();
        let numbers = if found.len() < group.members.len() {
            "not applicable | | |".to_owned()
        } else {
            let most = |of: fn(&Finding) -> f64| number(found.iter().map(of).fold(0.0, f64::max));
            let before =
                members().map(|(case, _)| released(&case.name)).try_fold(0.0, |most, error| Some(error?.max(most)));
            let before = before.map_or("new".to_owned(), number);
            format!("{} | {before} | {} | {}", most(|f| f.error), most(|f| f.bound), naive(&found))
        };
        table += &format!("{} {numbers} |\n", group.columns());
    }
    table
}

/// The smallest error that was computed, and the statements in place of others.
fn naive(found: &[Finding]) -> String {
    let (mut least, mut parts): (Option<f64>, Vec<String>) = (None, Vec::new());
    for finding in found {
        match finding.naive {
            Naive::Computed(error) => least = Some(least.map_or(error, |least| least.min(error))),
            Naive::Stated { why } => {
                let part = format!("stated: {why}");
                if !parts.contains(&part) {
                    parts.push(part);
                }
            }
        }
    }
    least.map(number).into_iter().chain(parts).collect::<Vec<_>>().join("; ")
}

/// Formats a number with two digits; whole numbers are counts.
fn number(value: f64) -> String {
    match value {
        v if !v.is_finite() => "∞".to_owned(),
        v if v == v.trunc() && v < 1e6 => format!("{v}"),
        v if (0.01..1000.0).contains(&v) => format!("{v:.2}"),
        v => format!("{v:.1e}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::check::{Lack, one};

    fn case(name: &str, about: &'static str) -> Case {
        one(name, about, |_| Verdict::NotApplicable(Lack::Limits, "everything".into()))
    }

    #[test]
    fn a_row_for_what_cases_are_about() {
        let cases = [case("a/x", "first"), case("a/y", "second"), case("b/x", "first"), case("b/y", "third")];
        let found = groups(&cases);
        let rows: Vec<String> = found.iter().map(Group::columns).collect();
        assert_eq!(rows, ["| `x` | `a`, `b` | first |", "| `y` | `a` | second |", "| `y` | `b` | third |"]);
        assert_eq!(found[0].members, [0, 2]);

        let found = |error, bound, naive| Verdict::Found(Finding { error, bound, naive });
        let verdicts = [
            found(0.0, 2e-6, Naive::Computed(0.5)),
            found(12.0, 0.0, Naive::Stated { why: "it is lost" }),
            found(1e-7, 1e-6, Naive::Computed(f64::INFINITY)),
            Verdict::NotApplicable(Lack::Subgroups, "no subgroups".into()),
        ];
        let results: Vec<(&Case, Verdict)> = cases.iter().zip(verdicts).collect();
        let table = markdown(&results);
        let lines: Vec<&str> = table.lines().skip(2).collect();
        assert_eq!(lines[0], "| `x` | `a`, `b` | first | 1.0e-7 | new | 2.0e-6 | 0.50 |");
        assert_eq!(lines[1], "| `y` | `a` | second | 12 | new | 0 | stated: it is lost |");
        assert_eq!(lines[2], "| `y` | `b` | third | not applicable | | | |");
    }

    #[test]
    fn a_group_shows_its_least_naive_error_and_each_statement_once() {
        let finding = |naive| Finding { error: 0.0, bound: 0.0, naive };
        let stated = finding(Naive::Stated { why: "it is lost" });
        let all = [finding(Naive::Computed(2.0)), stated, finding(Naive::Computed(0.25)), stated];
        assert_eq!(naive(&all), "0.25; stated: it is lost");
    }
}
