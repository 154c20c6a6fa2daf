//! Section about errors that fall with samples, and their bias.

use maud::{Markup, html};

use super::{Row, Tradeoff, error};
use crate::report::page::{Cell, Column, Line, digits, sortable, table};
use crate::report::tradeoff::figures::{short, signed};
use crate::report::tradeoff::{Analytic, Convergence};

pub(super) fn convergence(report: &Tradeoff) -> Markup {
    let columns = [
        Column::text("method"),
        Column::text("over"),
        Column::number("slope of RMSE"),
        Column::number("R²"),
        Column::number("slope of RMSE over time"),
        Column::number("R²"),
        Column::number("settings"),
    ];
    let row = |c: &Convergence| {
        vec![
            c.method.clone(),
            c.key.clone(),
            signed(c.rmse.exponent, 3),
            format!("{:.3}", c.rmse.r_squared),
            signed(c.over_time.exponent, 3),
            format!("{:.3}", c.over_time.r_squared),
            c.rows.to_string(),
        ]
    };
    let rows: Vec<_> = report.convergence.iter().map(row).collect();
    html! {
        @if rows.is_empty() { p { "No method has three settings on a ladder." } } @else {
            p {
                "Slopes of RMSE, both axes logarithmic, by least squares: −0.5 is what independent samples give. A law "
                "with R² far from 1 does not hold."
            }
            (table(&columns, &rows))
        }
    }
}

/// Errors against alpha blending of planes.
pub(super) fn blended(report: &Tradeoff, analytic: &Analytic) -> Markup {
    let columns = [
        Column::text("setting"),
        Column::number("ms"),
        Column::number("RMSE against the reference"),
        Column::number("against alpha blending"),
        Column::number("expected"),
    ];
    let row = |row: &Row| {
        let (_, count) = row.step.as_ref()?;
        let numbers = [digits(row.gpu_ms.median), error(row.errors.rmse), error(row.rmse_analytic?)];
        Some([vec![short(&row.setting)], numbers.to_vec(), vec![error(analytic.expected(*count))]].concat())
    };
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
        (table(&columns, &report.rows.iter().filter_map(row).collect::<Vec<_>>()))
    }
}

pub(super) fn bias(report: &Tradeoff) -> Markup {
    let columns = [
        Column::text("method"),
        Column::text("setting"),
        Column::number("seeds"),
        Column::number("RMSE"),
        Column::number("noise"),
        Column::number("bias"),
        Column::number("floor of the bias"),
        Column::text("bias seen"),
    ];
    let line = |row: &Row| {
        let repeats = row.repeats?;
        let number = |value| Cell::number(value, error);
        let cells = vec![
            Cell::text(&row.method),
            Cell::text(short(&row.setting)),
            Cell::number(repeats.seeds.into(), |seeds| seeds.to_string()),
            number(row.errors.rmse),
            number(repeats.noise),
            number(repeats.bias),
            number(repeats.bias_floor),
            Cell::text(if repeats.bias > repeats.bias_floor { "yes" } else { "no" }),
        ];
        Some(Line { cells, is_marked: false })
    };
    let lines: Vec<_> = report.rows.iter().filter_map(line).collect();
    html! {
        @if lines.is_empty() { p { "No method among those measured depends on a seed." } } @else {
            p {
                "Images with different seeds are compared with their mean, and the mean with the reference. Noise is the RMSE of one "
                "image against the mean. Bias is that of the mean against the reference, less what noise leaves in it."
            }
            (sortable(&columns, &lines))
        }
    }
}
