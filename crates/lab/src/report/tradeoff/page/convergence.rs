//! Section about errors that fall with samples, and their bias.

use maud::{Markup, html};

use super::{Row, Tradeoff, error};
use crate::report::page::{ReportTable, count, digits};
use crate::report::tradeoff::figures::{short, signed};
use crate::report::tradeoff::{Analytic, Repeats};

pub(super) fn convergence(report: &Tradeoff) -> Markup {
    let [slope, explained] = [|slope: f64| signed(slope, 3), |share: f64| format!("{share:.3}")];
    let table = ReportTable::new(&report.convergence)
        .text("method", |found| &found.method)
        .text("over", |found| &found.key)
        .number("slope of RMSE", slope, |found| found.rmse.exponent)
        .number("R²", explained, |found| found.rmse.r_squared)
        .number("slope of RMSE over time", slope, |found| found.over_time.exponent)
        .number("R²", explained, |found| found.over_time.r_squared)
        .number("settings", count, |found| found.rows as f64);
    html! {
        @if report.convergence.is_empty() { p { "No method has three settings on a ladder." } } @else {
            p {
                "Slopes of RMSE, both axes logarithmic, by least squares: −0.5 is what independent samples give. A law "
                "with R² far from 1 does not hold."
            }
            (table.html())
        }
    }
}

/// Errors against alpha blending of planes.
pub(super) fn blended(report: &Tradeoff, analytic: &Analytic) -> Markup {
    let expected = |row: &Row| row.step.as_ref().map(|(_, count)| analytic.expected(*count));
    let rows = report.rows.iter().filter(|row| row.step.is_some() && row.rmse_analytic.is_some());
    let table = ReportTable::new(rows)
        .text("setting", |row| short(&row.setting))
        .number("ms", digits, |row| row.gpu_ms.median)
        .number("RMSE against the reference", error, |row| row.errors.rmse)
        .number("against alpha blending", error, |row| row.rmse_analytic)
        .number("expected", error, expected);
    let list = |values: &[f64]| values.iter().map(|value| digits(*value)).collect::<Vec<_>>().join(", ");
    html! {
        h3 { "Against alpha blending" }
        p {
            "This scene consists of planes that fill the image, of opacity " (list(&analytic.opacities)) " (the nearest first) and "
            (list(&analytic.points_per_pixel)) " points on a pixel, so its image is known: a single color. Up to "
            (digits(analytic.dealt_once)) " ensembles, no point is dealt twice, and the error falls as 1/√ensembles"
            @if let Some(law) = analytic.slope { " (slope " (signed(law.exponent, 3)) ", measured)" }
            ". Beyond that, the random number of points on a pixel remains: " (error(analytic.floor))
            " is the error of the reference itself, " (error(analytic.expected_floor)) " is expected."
        }
        (table.html())
    }
}

pub(super) fn bias(report: &Tradeoff) -> Markup {
    let repeats = report.rows.iter().filter_map(|row| Some((row, row.repeats?)));
    let repeats: Vec<(&Row, Repeats)> = repeats.collect();
    let table = ReportTable::new(&repeats)
        .text("method", |(row, _)| &row.method)
        .text("setting", |(row, _)| short(&row.setting))
        .number("seeds", count, |(_, repeats)| f64::from(repeats.seeds))
        .number("RMSE", error, |(row, _)| row.errors.rmse)
        .number("noise", error, |(_, repeats)| repeats.noise)
        .number("bias", error, |(_, repeats)| repeats.bias)
        .number("floor of the bias", error, |(_, repeats)| repeats.bias_floor)
        .text("bias seen", |(_, repeats)| if repeats.bias > repeats.bias_floor { "yes" } else { "no" });
    html! {
        @if repeats.is_empty() { p { "No method among those measured depends on a seed." } } @else {
            p {
                "Images with different seeds are compared with their mean, and the mean with the reference. Noise is the RMSE of one "
                "image against the mean. Bias is that of the mean against the reference, less what noise leaves in it."
            }
            (table.sortable(|_| false))
        }
    }
}
