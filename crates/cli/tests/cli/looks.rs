//! `tradeoff` on approximations: which settings of them it compares, and what it says of their errors.

use std::fs;

use serde_json::Value;

use crate::{builtin, done, folder, has_device, inside};

fn number(value: &Value, key: &str) -> f64 {
    value[key].as_f64().unwrap_or_else(|| panic!("{key} of {value}"))
}

fn text<'a>(value: &'a Value, key: &str) -> &'a str {
    value[key].as_str().unwrap_or_else(|| panic!("{key} of {value}"))
}

#[test]
fn approximations_say_how_their_errors_look() {
    if !has_device() {
        return;
    }
    let folder = folder();
    let scene = builtin(&folder, "tori", &["points=1500"]);
    let args = ["tradeoff", &scene, "--size", "48x32", "-o", "report", "--quick", "--time", "900", "--json"];
    let methods = ["hybrid", "moments", "wavelet", "mlab", "stochastic", "peel"];
    let options = [&["--opacity", "0.5"][..], &methods.map(|method| ["--only", method]).concat()].concat();
    let report: Value = serde_json::from_str(&done(&folder, &[&args, &options[..]].concat())).unwrap();
    let rows = report["rows"].as_array().unwrap();
    let settings_of = |method: &str| -> Vec<&str> {
        rows.iter().filter(|row| row["method"] == method).map(|row| text(row, "setting")).collect()
    };
    assert_eq!(
        settings_of("moments"),
        ["", " method.overestimation=0", " method.overestimation=0.25"]
            .map(|rest| [4, 8].map(|count| format!("method.moments={count}{rest}")))
            .concat()
    );
    assert_eq!(settings_of("wavelet").len(), 2, "{rows:?}");
    assert_eq!(settings_of("mlab"), ["method.nodes=1", "method.nodes=4"]);
    for row in rows {
        let exact = (text(row, "method"), text(row, "setting")) == ("peel", "");
        assert_eq!(row["look"].is_null(), exact, "{row}");
        if !exact {
            let shares = ["even", "leak", "ghost", "noise"].map(|key| number(&row["look"], key));
            assert!((shares.iter().map(|share| share.abs()).sum::<f64>() - 1.0).abs() < 1e-9, "{row}");
            // The whole image is as high as this.
            assert_eq!(row["look"]["worst"]["side"], 32, "{row}");
            assert!(number(&row["look"], "bias").abs() < 2.0 * number(&row["errors"], "rmse"), "{row}");
        }
    }
    let look = |method: &str, setting: &str| {
        &rows.iter().find(|row| row["method"] == method && row["setting"] == setting).unwrap()["look"]
    };
    // Averaging behind the first fragment gives the image without order, but for that one; samples are taken anew in
    // each pixel.
    assert!(number(look("hybrid", "method.k=1"), "leak") > 0.5, "{}", look("hybrid", "method.k=1"));
    // Few samples show color that is off as a whole, too.
    assert!(number(look("stochastic", "method.samples=64"), "noise") > 0.8, "{rows:?}");
    let page = fs::read_to_string(inside(&folder, "report/report.html")).unwrap();
    // One of which a setting is exact is no approximation.
    assert_eq!(page.matches("<div class=\"look\">").count(), methods.len() - 1);
    assert!(page.contains("<h2>How errors look</h2>") && !page.contains("<h3>peel"));
}
